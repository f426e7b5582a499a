#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/vortex_pairs.hpp>

/// Effects on N point vortices in the plane, of circulations Γᵢ (length²/time), in the canonical coordinates
/// of systems::PointVortices: qᵢ = √|Γᵢ| xᵢ, pᵢ = √|Γᵢ| sgn(Γᵢ) yᵢ. A background flow of stream function ψ,
/// with velocity (∂ψ/∂y, -∂ψ/∂x), adds Σ Γᵢ ψ(xᵢ, yᵢ) to H. N is the number, or Eigen::Dynamic.
///
/// Source: P. Newton, The N-Vortex Problem (2001), chapters 2 and 3.
namespace semiexplicit::effects::vortices {

/// The circulations, and what they make of canonical coordinates. Effects take one each:
///
///     const vortices::Circulations<double> gamma(Eigen::Vector3d(1, 2, -1));
///     Scene scene(vortices::Pairs{gamma}, vortices::HalfPlane{gamma});
template <class ScalarType = double, int N = Eigen::Dynamic>
class Circulations {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = N;
  using Column = Vector<Scalar, N>;

  /// Throws std::invalid_argument unless every circulation is finite and not zero, and there is one at least.
  explicit Circulations(Column circulations) : gamma(std::move(circulations)) {
    using std::isfinite;
    if (gamma.size() == 0)
      throw std::invalid_argument("Circulations: no circulation given; give one a vortex");
    for (Eigen::Index i = 0; i < gamma.size(); ++i)
      if (!isfinite(gamma[i]) || gamma[i] == Scalar(0))
        throw std::invalid_argument("Circulations: circulation " + std::to_string(i) +
                                    " is zero or not finite; leave such a vortex out");
    x_per_q = gamma.cwiseAbs().cwiseSqrt().cwiseInverse();
    y_per_p = x_per_q.cwiseProduct(gamma.cwiseSign());
  }

  Eigen::Index size() const { return N == Eigen::Dynamic ? gamma.size() : N; }
  /// Of all, which effects of one scene have to agree on.
  std::vector<double> values() const {
    std::vector<double> all;
    for (Eigen::Index i = 0; i < gamma.size(); ++i) all.push_back(static_cast<double>(gamma[i]));
    return all;
  }

  Column gamma, x_per_q, y_per_p;
};

template <class Derived>
Circulations(const Eigen::MatrixBase<Derived>&)
    -> Circulations<typename Derived::Scalar, Derived::RowsAtCompileTime>;

namespace detail {

template <class Scalar>
Scalar pi() {
  using std::acos;
  return acos(Scalar(-1));
}

/// -1/(2π) Σ_{i<j} ΓᵢΓⱼ log‖zᵢ - zⱼ‖.
template <class Scalar, int N>
Scalar pair_energy(const Circulations<Scalar, N>& of, const auto& q, const auto& p) {
  using std::log;
  Scalar sum(0);
  for (Eigen::Index j = 0; j < of.size(); ++j)
    for (Eigen::Index i = 0; i < j; ++i) {
      const Scalar dx = q[i] * of.x_per_q[i] - q[j] * of.x_per_q[j],
                   dy = p[i] * of.y_per_p[i] - p[j] * of.y_per_p[j];
      sum -= of.gamma[i] * of.gamma[j] * log(dx * dx + dy * dy);
    }
  return sum / (4 * pi<Scalar>());
}

}  // namespace detail

/// Each vortex moves in the velocities of all others: -1/(2π) Σ_{i<j} ΓᵢΓⱼ log‖zᵢ - zⱼ‖. Vortices that
/// coincide have no gradient (NaN). Two at distance D turn about each other at (Γ₁ + Γ₂)/(2πD²). Source:
/// Newton (2001), section 2.1.
template <class Scalar = double, int N = Eigen::Dynamic>
class Pairs {
 public:
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "pairs";
  static constexpr const char* about = "the velocity that each vortex gives all others";

  explicit Pairs(Circulations<Scalar, N> circulations) : c_(std::move(circulations)) {
    weight_ = c_.gamma / (-2 * detail::pi<Scalar>());
  }
  Eigen::Index dof() const { return c_.size(); }
  std::vector<double> scene_constants() const { return c_.values(); }

  Scalar energy(const auto& q, const auto& p) const { return detail::pair_energy(c_, q, p); }

  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto &sx = c_.x_per_q, &sy = c_.y_per_p;
    for (Eigen::Index j = 1; j < dof(); ++j) {
      const auto xj = q[j] * sx[j], yj = p[j] * sy[j];
      auto sum_x = xj - xj, sum_y = sum_x;
      for (Eigen::Index i = 0; i < j; ++i) {
        const auto dx = q[i] * sx[i] - xj, dy = p[i] * sy[i] - yj;
        const auto pull = weight_[i] * c_.gamma[j] / (dx * dx + dy * dy);
        dHdq[i] += pull * dx * sx[i];
        dHdp[i] += pull * dy * sy[i];
        sum_x += pull * dx;
        sum_y += pull * dy;
      }
      dHdq[j] -= sum_x * sx[j];
      dHdp[j] -= sum_y * sy[j];
    }
  }

 private:
  Circulations<Scalar, N> c_;
  Vector<Scalar, N> weight_;  ///< -Γᵢ/(2π)
};

template <class Scalar, int N>
Pairs(Circulations<Scalar, N>) -> Pairs<Scalar, N>;

/// A uniform straining flow, outward along the axis at `angle` and inward across it, of velocity rate ·
/// distance: ψ = rate (cos 2α xy + sin 2α (y² - x²)/2). Source: Newton (2001), section 3.1.
template <class Scalar = double, int N = Eigen::Dynamic>
class Strain {
 public:
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "strain";
  static constexpr const char* about = "uniform straining flow";

  /// `rate` in 1/time, `angle` in radians.
  Strain(const Circulations<Scalar, N>& circulations, Scalar rate, Scalar angle = Scalar(0))
      : c_(circulations), sign_(circulations.gamma.cwiseSign()) {
    using std::cos;
    using std::sin;
    along_ = rate * cos(2 * angle);
    across_ = rate * sin(2 * angle);
  }
  Eigen::Index dof() const { return c_.size(); }
  std::vector<double> scene_constants() const { return c_.values(); }

  // Γx² = sgn(Γ) q², Γy² = sgn(Γ) p² and Γxy = qp.
  Scalar energy(const auto& q, const auto& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i)
      sum += along_ * q[i] * p[i] + across_ * sign_[i] * (p[i] * p[i] - q[i] * q[i]) / 2;
    return sum;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    for (Eigen::Index i = 0; i < dof(); ++i) {
      dHdq[i] += along_ * p[i] - across_ * sign_[i] * q[i];
      dHdp[i] += along_ * q[i] + across_ * sign_[i] * p[i];
    }
  }

 private:
  Circulations<Scalar, N> c_;
  Vector<Scalar, N> sign_;
  Scalar along_, across_;
};

template <class Scalar, int N, class... Numbers>
Strain(Circulations<Scalar, N>, Numbers...) -> Strain<Scalar, N>;

/// A flow that turns about the origin at `rate`, counterclockwise: ψ = -rate (x² + y²)/2. A frame that turns
/// at ω sees the rate -ω.
template <class Scalar = double, int N = Eigen::Dynamic>
class Rotation {
 public:
  using Acts = OnEach<Scalar, N>;
  static constexpr const char* name = "rotation";
  static constexpr const char* about = "uniform rotation about the origin";

  /// `rate` in radians/time.
  Rotation(const Circulations<Scalar, N>& circulations, Scalar rate)
      : c_(circulations), weight_(-rate * circulations.gamma.cwiseSign()) {}
  Eigen::Index dof() const { return c_.size(); }
  std::vector<double> scene_constants() const { return c_.values(); }

  Scalar energy(const auto& x) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i) sum += weight_[i] * x[i] * x[i] / 2;
    return sum;
  }
  void add_gradient(const auto& x, auto& dHdx) const {
    for (Eigen::Index i = 0; i < dof(); ++i) dHdx[i] += weight_[i] * x[i];
  }

 private:
  Circulations<Scalar, N> c_;
  Vector<Scalar, N> weight_;  ///< -rate sgn(Γᵢ)
};

template <class Scalar, int N, class Number>
Rotation(Circulations<Scalar, N>, Number) -> Rotation<Scalar, N>;

}  // namespace semiexplicit::effects::vortices

namespace semiexplicit::systems {

/// N point vortices in the plane with circulations Γᵢ of either sign,
///
///     H = -1/(4π) Σ_{i≠j} Γᵢ Γⱼ log‖zᵢ - zⱼ‖,
///
/// in canonical coordinates qᵢ = √|Γᵢ| xᵢ, pᵢ = √|Γᵢ| sgn(Γᵢ) yᵢ. It keeps H, the linear impulse (Σ Γᵢxᵢ, Σ
/// Γᵢyᵢ) and the angular impulse Σ Γᵢ‖zᵢ‖². Two vortices at distance D turn about each other at (Γ₁ +
/// Γ₂)/(2πD²). Where two vortices coincide the gradient is NaN. N is the number, or Eigen::Dynamic.
///
/// Sources: P. Newton, The N-Vortex Problem (2001), section 2.1; Jayawardana and Ohsawa (2023), eq.
/// (Hamil-Vortices).
template <class ScalarType = double, int N = Eigen::Dynamic>
class PointVortices {
  /// Few, but enough to gain by it.
  static constexpr bool in_lanes = N >= 4 && N <= 16 && std::is_same_v<ScalarType, double>;

 public:
  using Scalar = ScalarType;
  static constexpr int Dof = N;
  using Column = Vector<Scalar, N>;
  using Read = In<Scalar, N>;

  /// Throws std::invalid_argument unless every circulation is finite and not zero, and there is one at least.
  explicit PointVortices(Column circulations) : c_(std::move(circulations)) {
    const Column factor = c_.gamma / (-2 * effects::vortices::detail::pi<Scalar>());
    factor_q_ = factor.cwiseProduct(c_.x_per_q);
    factor_p_ = factor.cwiseProduct(c_.y_per_p);
  }

  Eigen::Index dof() const { return c_.size(); }
  const Column& circulations() const { return c_.gamma; }

  /// The phase point of vortices at (xᵢ, yᵢ).
  PhasePoint<Scalar, N> phase_point(const Column& x, const Column& y) const {
    if (x.size() != dof() || y.size() != dof())
      throw std::invalid_argument("PointVortices: " + std::to_string(dof()) + " circulations, but " +
                                  std::to_string(x.size()) + " x and " + std::to_string(y.size()) + " y");
    return {x.cwiseQuotient(c_.x_per_q), y.cwiseQuotient(c_.y_per_p)};
  }
  /// The positions back. Throw std::invalid_argument for another number of vortices.
  Column x(const Read& q) const { return times(c_.x_per_q, q); }
  Column y(const Read& p) const { return times(c_.y_per_p, p); }

  Scalar energy(const Read& q, const Read& p) const {
    return effects::vortices::detail::pair_energy(c_, q, p);
  }
  /// Σ Γx, linear in q: an invariant.
  Scalar linear_impulse_x(const Read& q, const Read&) const {
    return semiexplicit::detail::dot(c_.gamma, x(q));
  }
  /// Σ Γy, linear in p: an invariant.
  Scalar linear_impulse_y(const Read&, const Read& p) const {
    return semiexplicit::detail::dot(c_.gamma, y(p));
  }
  /// Σ Γ(x² + y²) = Σ sgn(Γ)(q² + p²): a quadratic invariant.
  Scalar angular_impulse(const Read& q, const Read& p) const {
    return semiexplicit::detail::dot(c_.gamma.cwiseSign(), q.cwiseAbs2() + p.cwiseAbs2());
  }

  void gradient(const Read& q, const Read& p, Out<Scalar, N> dHdq, Out<Scalar, N> dHdp) const {
    gradient(q.data(), p.data(), dHdq.data(), dHdp.data());
  }
  using PackGradientOf = PointVortices;
  /// The same with any numbers in arrays, packs above all; see HasPackGradient.
  template <class T>
  void gradient(const T* q, const T* p, T* dHdq, T* dHdp) const {
#ifdef SEMIEXPLICIT_HAS_LANES
    if constexpr (in_lanes && std::is_same_v<T, double>) {
      constexpr int size = registers_for(N);
      Lanes at_q[std::size_t(size)], at_p[std::size_t(size)], to_q[std::size_t(size)],
          to_p[std::size_t(size)];
      semiexplicit::detail::load_lanes<N>(q, at_q);
      semiexplicit::detail::load_lanes<N>(p, at_p);
      lane_gradient(at_q, at_p, to_q, to_p);
      semiexplicit::detail::store_lanes<N>(to_q, dHdq);
      semiexplicit::detail::store_lanes<N>(to_p, dHdp);
      return;
    }
#endif
    detail::sum_vortex_pairs(dof(), scales(), q, p, dHdq, dHdp);
    for (Eigen::Index i = 0; i < dof(); ++i) {
      dHdq[i] *= factor_q_[i];
      dHdp[i] *= factor_p_[i];
    }
  }

#ifdef SEMIEXPLICIT_HAS_LANES
  using LaneGradientOf = PointVortices;
  /// The same for few vortices in registers; see HasLaneGradient.
  void lane_gradient(const Lanes* q, const Lanes* p, Lanes* dHdq, Lanes* dHdp) const requires(in_lanes) {
    Lanes factor_q[std::size_t(registers_for(N))], factor_p[std::size_t(registers_for(N))];
    semiexplicit::detail::load_lanes<N>(factor_q_.data(), factor_q);
    semiexplicit::detail::load_lanes<N>(factor_p_.data(), factor_p);
    detail::sum_vortex_pairs<N>(scales(), q, p, dHdq, dHdp);
    for (int k = 0; k < registers_for(N); ++k) {
      dHdq[k] *= factor_q[k];
      dHdp[k] *= factor_p[k];
    }
  }
#endif

 private:
  Column times(const Column& scale, const Read& coordinates) const {
    semiexplicit::detail::require_same_dof("PointVortices", coordinates.size(), "vortices", dof(),
                                           "give q and p of as many vortices");
    return coordinates.cwiseProduct(scale);
  }
  detail::VortexScales<Scalar> scales() const {
    return {c_.gamma.data(), c_.x_per_q.data(), c_.y_per_p.data()};
  }

  effects::vortices::Circulations<Scalar, N> c_;
  Column factor_q_, factor_p_;  ///< what makes ∂H/∂q and ∂H/∂p of the pairs' sums
};

}  // namespace semiexplicit::systems
