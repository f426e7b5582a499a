#pragma once

#include <cmath>

#include <semiexplicit/core/vector.hpp>

/// Monitor functions for TimeTransformed.
namespace semiexplicit::monitors {

/// g = |q|^power: steps that shrink towards a centre of attraction at the origin. With the power 3/2 a step is the same part of
/// the local free-fall time everywhere, and Kepler orbits of any eccentricity take a hundred steps or so.
struct Distance {
  double power = 1.5;

  template <class Q, class D>
  typename Q::Scalar operator()(const Q& q, D&& dgdq) const {
    using Scalar = typename Q::Scalar;
    using std::pow;
    const Scalar squared = semiexplicit::detail::dot(q, q);
    const Scalar value = pow(squared, Scalar(power) / 2);
    dgdq = (Scalar(power) * value / squared) * q;
    return value;
  }
};

/// g = 1/Σ_{i<j} 1/D²ᵢⱼ with the distances D of point vortices, of which each pair turns at a rate like 1/D²: steps that shrink
/// where two of them come close. For PointVortices; it needs their circulations for the places.
template <class Scalar, int N>
class VortexDistances {
 public:
  /// The vortices are a PointVortices or anything else with circulations().
  template <class Vortices>
  explicit VortexDistances(const Vortices& vortices)
      : x_per_q_(vortices.circulations().cwiseAbs().cwiseSqrt().cwiseInverse()),
        y_per_p_(x_per_q_.cwiseProduct(vortices.circulations().cwiseSign())) {}

  template <class Q, class P, class D>
  Scalar operator()(const Q& q, const P& p, D&& dgdq, D&& dgdp) const {
    dgdq.setZero();
    dgdp.setZero();
    Scalar sum(0);
    for (Eigen::Index j = 1; j < q.size(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const Scalar dx = q[i] * x_per_q_[i] - q[j] * x_per_q_[j],
                     dy = p[i] * y_per_p_[i] - p[j] * y_per_p_[j];
        const Scalar rate = 1 / (dx * dx + dy * dy), slope = 2 * rate * rate;
        sum += rate;
        dgdq[i] += slope * dx * x_per_q_[i];
        dgdq[j] -= slope * dx * x_per_q_[j];
        dgdp[i] += slope * dy * y_per_p_[i];
        dgdp[j] -= slope * dy * y_per_p_[j];
      }
    dgdq /= sum * sum;
    dgdp /= sum * sum;
    return 1 / sum;
  }

 private:
  Vector<Scalar, N> x_per_q_, y_per_p_;
};

template <class Vortices>
VortexDistances(const Vortices&) -> VortexDistances<typename Vortices::Scalar, Vortices::Dof>;

}  // namespace semiexplicit::monitors
