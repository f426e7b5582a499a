#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/systems/vortex_pairs.hpp>

namespace semiexplicit::systems {

/// N point vortices in the plane with circulations Γᵢ of either sign,
///
///     H = -1/(4π) Σ_{i≠j} Γᵢ Γⱼ log‖zᵢ - zⱼ‖,
///
/// in canonical coordinates qᵢ = √|Γᵢ| xᵢ, pᵢ = √|Γᵢ| sgn(Γᵢ) yᵢ. It keeps H, the linear impulse (Σ Γᵢxᵢ, Σ Γᵢyᵢ) and the
/// angular impulse Σ Γᵢ‖zᵢ‖². Two vortices at distance D turn about each other at (Γ₁ + Γ₂)/(2πD²). Where two vortices
/// coincide the gradient is NaN. N is the number, or Eigen::Dynamic.
///
/// Sources: P. Newton, The N-Vortex Problem (2001), section 2.1; Jayawardana and Ohsawa (2023), eq. (Hamil-Vortices).
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
  explicit PointVortices(Column circulations) : circulation_(std::move(circulations)) {
    if (circulation_.size() == 0)
      throw std::invalid_argument("PointVortices: no circulation given; give one a vortex");
    using std::isfinite;
    for (Eigen::Index i = 0; i < dof(); ++i)
      if (!isfinite(circulation_[i]) || circulation_[i] == Scalar(0))
        throw std::invalid_argument("PointVortices: circulation " + std::to_string(i) +
                                    " is zero or not finite; leave such a vortex out");
    x_per_q_ = circulation_.cwiseAbs().cwiseSqrt().cwiseInverse();
    y_per_p_ = x_per_q_.cwiseProduct(circulation_.cwiseSign());
    factor_q_ = circulation_.cwiseProduct(x_per_q_) / (-2 * pi());
    factor_p_ = circulation_.cwiseProduct(y_per_p_) / (-2 * pi());
  }

  Eigen::Index dof() const { return circulation_.size(); }
  const Column& circulations() const { return circulation_; }

  /// The phase point of vortices at (xᵢ, yᵢ).
  PhasePoint<Scalar, N> phase_point(const Column& x, const Column& y) const {
    if (x.size() != dof() || y.size() != dof())
      throw std::invalid_argument("PointVortices: " + std::to_string(dof()) + " circulations, but " +
                                  std::to_string(x.size()) + " x and " + std::to_string(y.size()) + " y");
    return {x.cwiseQuotient(x_per_q_), y.cwiseQuotient(y_per_p_)};
  }
  Column x(const Read& q) const { return q.cwiseProduct(x_per_q_); }
  Column y(const Read& p) const { return p.cwiseProduct(y_per_p_); }

  Scalar energy(const Read& q, const Read& p) const {
    using std::log;
    Scalar sum(0);
    for (Eigen::Index j = 0; j < dof(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Scalar dx = q[i] * x_per_q_[i] - q[j] * x_per_q_[j],
                     dy = p[i] * y_per_p_[i] - p[j] * y_per_p_[j];
        sum -= circulation_[i] * circulation_[j] * log(dx * dx + dy * dy);
      }
    return sum / (4 * pi());
  }
  /// Σ Γx, linear in q: an invariant.
  Scalar linear_impulse_x(const Read& q, const Read&) const {
    return semiexplicit::detail::dot(circulation_, x(q));
  }
  /// Σ Γy, linear in p: an invariant.
  Scalar linear_impulse_y(const Read&, const Read& p) const {
    return semiexplicit::detail::dot(circulation_, y(p));
  }
  /// Σ Γ(x² + y²) = Σ sgn(Γ)(q² + p²): a quadratic invariant.
  Scalar angular_impulse(const Read& q, const Read& p) const {
    return semiexplicit::detail::dot(circulation_.cwiseSign(), q.cwiseAbs2() + p.cwiseAbs2());
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
  static Scalar pi() {
    using std::acos;
    return acos(Scalar(-1));
  }

  detail::VortexScales<Scalar> scales() const {
    return {circulation_.data(), x_per_q_.data(), y_per_p_.data()};
  }

  Column circulation_, x_per_q_, y_per_p_;
  Column factor_q_, factor_p_;  ///< what makes ∂H/∂q and ∂H/∂p of the pairs' sums
};

}  // namespace semiexplicit::systems
