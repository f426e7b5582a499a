#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>

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
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = N;
  using Column = Vector<Scalar, N>;
  using Read = ConstRef<Scalar, N>;

  /// Throws std::invalid_argument unless every circulation is finite and not zero, and there is one at least.
  explicit PointVortices(Column circulations) : circulation_(std::move(circulations)) {
    if (circulation_.size() == 0)
      throw std::invalid_argument("PointVortices: no circulation given; give one a vortex");
    using std::isfinite;
    for (Eigen::Index i = 0; i < dof(); ++i)
      if (!isfinite(circulation_[i]) || circulation_[i] == Scalar(0))
        throw std::invalid_argument("PointVortices: circulation " + std::to_string(i) +
                                    " is zero or not finite; leave such a vortex out");
    factor_ = -1 / (2 * pi());
    x_per_q_ = circulation_.cwiseAbs().cwiseSqrt().cwiseInverse();
    y_per_p_ = x_per_q_.cwiseProduct(circulation_.cwiseSign());
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
  Scalar linear_impulse_x(const Read& q, const Read&) const { return detail::dot(circulation_, x(q)); }
  /// Σ Γy, linear in p: an invariant.
  Scalar linear_impulse_y(const Read&, const Read& p) const { return detail::dot(circulation_, y(p)); }
  /// Σ Γ(x² + y²) = Σ sgn(Γ)(q² + p²): a quadratic invariant.
  Scalar angular_impulse(const Read& q, const Read& p) const {
    return detail::dot(circulation_.cwiseSign(), q.cwiseAbs2() + p.cwiseAbs2());
  }

  void gradient(const Read& q, const Read& p, Ref<Scalar, N> dHdq, Ref<Scalar, N> dHdp) const {
    sum_pairs(q.data(), p.data(), dHdq.data(), dHdp.data());
    for (Eigen::Index i = 0; i < dof(); ++i) {
      dHdq[i] *= factor_ * circulation_[i] * x_per_q_[i];
      dHdp[i] *= factor_ * circulation_[i] * y_per_p_[i];
    }
  }

 private:
  static Scalar pi() {
    using std::acos;
    return acos(Scalar(-1));
  }

  /// sum_x[i] = Σ_{j≠i} Γⱼ (xᵢ - xⱼ)/‖zᵢ - zⱼ‖², and sum_y likewise.
  void sum_pairs(const Scalar* __restrict q, const Scalar* __restrict p, Scalar* __restrict sum_x,
                 Scalar* __restrict sum_y) const {
    const Eigen::Index n = dof();
    const Scalar* const gamma = circulation_.data();
    const Scalar* const sx = x_per_q_.data();
    const Scalar* const sy = y_per_p_.data();
    for (Eigen::Index i = 0; i < n; ++i) sum_x[i] = sum_y[i] = Scalar(0);
    // Few vortices: each pair once, half the divisions. Many: every i over one j, which fills the SIMD lanes.
    if (n <= 16) {
      for (Eigen::Index j = 1; j < n; ++j) {
        const Scalar xj = q[j] * sx[j], yj = p[j] * sy[j];
        for (Eigen::Index i = 0; i < j; ++i) {
          const Scalar dx = q[i] * sx[i] - xj, dy = p[i] * sy[i] - yj;
          const Scalar inverse = 1 / (dx * dx + dy * dy);
          sum_x[i] += gamma[j] * (dx * inverse);
          sum_y[i] += gamma[j] * (dy * inverse);
          sum_x[j] -= gamma[i] * (dx * inverse);
          sum_y[j] -= gamma[i] * (dy * inverse);
        }
      }
      return;
    }
    for (Eigen::Index j = 0; j < n; ++j) {
      const Scalar xj = q[j] * sx[j], yj = p[j] * sy[j], gj = gamma[j];
      const auto add = [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i) {
          const Scalar dx = q[i] * sx[i] - xj, dy = p[i] * sy[i] - yj;
          const Scalar weight = gj / (dx * dx + dy * dy);
          sum_x[i] += dx * weight;
          sum_y[i] += dy * weight;
        }
      };
      add(0, j);
      add(j + 1, n);
    }
  }

  Column circulation_, x_per_q_, y_per_p_;
  Scalar factor_ = 0;  ///< -1/(2π)
};

}  // namespace semiexplicit::systems
