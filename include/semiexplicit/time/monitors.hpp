#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/time/pace.hpp>

/// Monitor functions for TimeTransformed, which asks for their gradients, and ReversibleSteps, which takes
/// `value` alone. Those of distances leave out the time of a driven system (Autonomous) under
/// ReversibleSteps; a function of one's own has all of its q and p, the time last.
namespace semiexplicit::monitors {

namespace detail {

/// |x|^power, and its slope divided by |x|, from |x|².
template <class Scalar>
std::pair<Scalar, Scalar> power_of_distance(const Scalar& squared, double power) {
  using std::pow;
  const Scalar value = pow(squared, Scalar(power) / 2);
  return {value, Scalar(power) * value / squared};
}

}  // namespace detail

/// g = |q|^power: steps that shrink towards a centre of attraction at the origin. With the power 3/2 a step
/// is the same part of the local free-fall time everywhere, and Kepler orbits of any eccentricity take a
/// hundred steps or so.
struct Distance {
  double power = 1.5;

  template <class Q, class D>
  typename Q::Scalar operator()(const Q& q, D&& dgdq) const {
    const auto [value, slope] = detail::power_of_distance(semiexplicit::detail::dot(q, q), power);
    dgdq = slope * q;
    return value;
  }
  template <class Q, class P>
  typename Q::Scalar value(const Q& q, const P&) const {
    return detail::power_of_distance(semiexplicit::detail::dot(q, q), power).first;
  }
};

/// g = |q - centre|^power: the same towards another point.
template <class Scalar, int Dof>
class DistanceFrom {
  static_assert(!std::is_integral_v<Scalar>,
                "a centre of whole numbers: write Eigen::Vector2d(0, 0) for Eigen::Vector2i(0, 0)");

 public:
  explicit DistanceFrom(Vector<Scalar, Dof> centre, double power = 1.5)
      : centre_(std::move(centre)), power_(power) {}

  template <class Q, class D>
  Scalar operator()(const Q& q, D&& dgdq) const {
    const auto [value, slope] = detail::power_of_distance(squared(q), power_);
    dgdq = slope * (q - centre_);
    return value;
  }
  template <class Q, class P>
  Scalar value(const Q& q, const P&) const {
    return detail::power_of_distance(squared(q), power_).first;
  }

 private:
  template <class Q>
  Scalar squared(const Q& q) const {
    if (q.size() != centre_.size())
      throw std::invalid_argument("DistanceFrom: the centre has " + std::to_string(centre_.size()) +
                                  " coordinates and the system " + std::to_string(q.size()) +
                                  "; give a centre of the system's, without the time");
    Scalar sum(0);
    for (Eigen::Index i = 0; i < centre_.size(); ++i) sum += (q[i] - centre_[i]) * (q[i] - centre_[i]);
    return sum;
  }

  Vector<Scalar, Dof> centre_;
  double power_;
};

template <class Scalar, int Dof>
DistanceFrom(const Vector<Scalar, Dof>&) -> DistanceFrom<Scalar, Dof>;
template <class Scalar, int Dof>
DistanceFrom(const Vector<Scalar, Dof>&, double) -> DistanceFrom<Scalar, Dof>;

/// g = (Σ_{i<j} 1/r^{2 power})^{-1/2} with the distances r of bodies whose places stand in q one after the
/// other, `dimensions` numbers each: about the closest pair's r^power, but smooth where another pair becomes
/// the closest. With the power 3/2 it is the free-fall time, for bodies of like mass. It throws
/// std::invalid_argument where q is not that of two bodies or more.
struct ClosestPair {
  int dimensions = 3;
  double power = 1.5;

  template <class Q, class D>
  typename Q::Scalar operator()(const Q& q, D&& dgdq) const {
    using Scalar = typename Q::Scalar;
    using std::sqrt;
    dgdq.setZero();
    Scalar sum(0);
    each_pair(q, [&](Eigen::Index i, Eigen::Index j, const Scalar& squared) {
      const auto [inverse, slope] = detail::power_of_distance(squared, -2 * power);
      sum += inverse;
      for (Eigen::Index k = 0; k < dimensions; ++k) {
        const Scalar part = slope * (q[i + k] - q[j + k]);
        dgdq[i + k] += part;
        dgdq[j + k] -= part;
      }
    });
    dgdq *= -1 / (2 * sum * sqrt(sum));
    return 1 / sqrt(sum);
  }
  template <class Q, class P>
  typename Q::Scalar value(const Q& q, const P&) const {
    using Scalar = typename Q::Scalar;
    using std::sqrt;
    Scalar sum(0);
    each_pair(q, [&](Eigen::Index, Eigen::Index, const Scalar& squared) {
      sum += detail::power_of_distance(squared, -2 * power).first;
    });
    return 1 / sqrt(sum);
  }

 private:
  template <class Q, class See>
  void each_pair(const Q& q, const See& see) const {
    if (dimensions < 1 || q.size() < 2 * dimensions || q.size() % dimensions != 0)
      throw std::invalid_argument("ClosestPair: " + std::to_string(q.size()) +
                                  " coordinates are not those of two bodies or more in " +
                                  std::to_string(dimensions) + " dimensions; give the dimensions");
    for (Eigen::Index j = dimensions; j < q.size(); j += dimensions)
      for (Eigen::Index i = 0; i < j; i += dimensions) {
        typename Q::Scalar squared(0);
        for (Eigen::Index k = 0; k < dimensions; ++k)
          squared += (q[i + k] - q[j + k]) * (q[i + k] - q[j + k]);
        see(i, j, squared);
      }
  }
};

/// g = 1/|∇H|, the size of the vector field: steps of equal length in phase space. q and p are compared in
/// their own units: scale H where these differ. A value is one gradient call, and there is no gradient: for
/// ReversibleSteps. One of dynamic size works in memory of its own. Of a driven system the time and its
/// momentum do not count.
template <class H>
class FieldSize {
 public:
  using Scalar = typename semiexplicit::detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = semiexplicit::detail::HamiltonianDoor<H>::Dof;
  static_assert(semiexplicit::detail::is_in_one_process<H>());

  explicit FieldSize(H hamiltonian)
      : hamiltonian_(std::move(hamiltonian)), at_(dof_of(hamiltonian_)), gradient_(at_) {}

  template <class Q, class P>
  Scalar value(const Q& q, const P& p) const {
    semiexplicit::detail::require_same_dof("monitors::FieldSize", q.size(), "Hamiltonian",
                                           dof_of(hamiltonian_), "give it that of the stepper");
    if (at_.dof() != q.size()) at_ = gradient_ = PhasePoint<Scalar, Dof>(q.size());  // it was moved from
    at_.q() = q;
    at_.p() = p;
    semiexplicit::detail::gradient_at(hamiltonian_, at_.vector().data(), gradient_.vector().data(),
                                      at_.dof());
    return 1 / semiexplicit::detail::state_size(hamiltonian_, gradient_);
  }
  /// Gradient calls of a value.
  std::int64_t gradients() const { return 1; }

 private:
  H hamiltonian_;
  mutable PhasePoint<Scalar, Dof> at_, gradient_;
};

/// In what TimeScale counts a state.
template <class Scalar>
struct TimeScaleOptions {
  Scalar length = Scalar(1), momentum = Scalar(1);  ///< about by how much q and p change along the orbit
  Scalar longest = Scalar(1);  ///< about the longest time scale of the orbit, which g stays below
};

/// g = 1/(‖Ẋ‖/‖X‖ + 1/longest), X being the vector field and Ẋ its change along the motion: the time in which
/// the motion becomes another one, of any Hamiltonian. r^{3/2} of a circular Kepler orbit. A value is two
/// gradient calls, and there is no gradient: for ReversibleSteps, which go back along their way to some 1e-10
/// by it, as Ẋ is a difference. One of dynamic size works in memory of its
/// own. Of a driven system the time and its momentum do not count.
template <class H>
class TimeScale {
 public:
  using Scalar = typename semiexplicit::detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = semiexplicit::detail::HamiltonianDoor<H>::Dof;
  static_assert(semiexplicit::detail::is_in_one_process<H>());
  using Options = TimeScaleOptions<Scalar>;

  /// Throws std::invalid_argument unless all options are positive and finite.
  explicit TimeScale(H hamiltonian, Options options = {})
      : hamiltonian_(std::move(hamiltonian)),
        options_(options),
        at_(dof_of(hamiltonian_)),
        here_(at_),
        ahead_(at_) {
    using std::isfinite;
    for (const Scalar& size : {options.length, options.momentum, options.longest})
      if (!(size > Scalar(0) && isfinite(size)))
        throw std::invalid_argument(
            "monitors::TimeScale: length, momentum or longest is not positive and finite; give sizes of the "
            "orbit");
  }

  template <class Q, class P>
  Scalar value(const Q& q, const P& p) const {
    using std::abs;
    using std::sqrt;
    semiexplicit::detail::require_same_dof("monitors::TimeScale", q.size(), "Hamiltonian",
                                           dof_of(hamiltonian_), "give it that of the stepper");
    if (at_.dof() != q.size()) at_ = here_ = ahead_ = PhasePoint<Scalar, Dof>(q.size());  // it was moved from
    at_.q() = q;
    at_.p() = p;
    field(here_);
    const Scalar speed = size(here_), epsilon = Eigen::NumTraits<Scalar>::epsilon();
    Scalar h = 100 * sqrt(epsilon) / speed;
    if constexpr (InExtendedPhaseSpace<H>) {  // so that the rounding of a late time does not show
      const Scalar late = 10 * sqrt(epsilon * abs(at_.q()[at_.dof() - 1]) / speed);
      if (late > h) h = late;
    }
    at_.vector() += h * here_.vector();
    field(ahead_);
    ahead_.vector() -= here_.vector();
    return 1 / (size(ahead_) / (h * speed) + 1 / options_.longest);
  }
  /// Gradient calls of a value.
  std::int64_t gradients() const { return 2; }

 private:
  /// X where at_ is.
  void field(PhasePoint<Scalar, Dof>& velocity) const {
    semiexplicit::detail::gradient_at(hamiltonian_, at_.vector().data(), velocity.vector().data(), at_.dof());
    for (Eigen::Index i = 0; i < at_.dof(); ++i) {
      const Scalar force = -velocity.q()[i];
      velocity.q()[i] = velocity.p()[i];
      velocity.p()[i] = force;
    }
  }
  Scalar size(const PhasePoint<Scalar, Dof>& velocity) const {
    using std::sqrt;
    Scalar squares(0);
    for (Eigen::Index i = 0; i < semiexplicit::detail::own_dof<H>(velocity.dof()); ++i) {
      const Scalar x = velocity.q()[i] / options_.length, y = velocity.p()[i] / options_.momentum;
      squares += x * x + y * y;
    }
    return sqrt(squares);
  }

  H hamiltonian_;
  Options options_;
  mutable PhasePoint<Scalar, Dof> at_, here_, ahead_;
};

/// g = 1/Σ_{i<j} 1/D²ᵢⱼ with the distances D of point vortices, of which each pair turns at a rate like 1/D²:
/// steps that shrink where two of them come close. For PointVortices; it needs their circulations for the
/// places.
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
    require_size(q);
    dgdq.setZero();
    dgdp.setZero();
    Scalar sum(0);
    for (Eigen::Index j = 1; j < q.size(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const auto [dx, dy] = difference(q, p, i, j);
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
  template <class Q, class P>
  Scalar value(const Q& q, const P& p) const {
    require_size(q);
    Scalar sum(0);
    for (Eigen::Index j = 1; j < q.size(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const auto [dx, dy] = difference(q, p, i, j);
        sum += 1 / (dx * dx + dy * dy);
      }
    return 1 / sum;
  }

 private:
  template <class Q>
  void require_size(const Q& q) const {
    semiexplicit::detail::require_same_dof("monitors::VortexDistances", q.size(), "vortices' system",
                                           x_per_q_.size(), "give it the vortices of the stepper");
  }
  template <class Q, class P>
  std::pair<Scalar, Scalar> difference(const Q& q, const P& p, Eigen::Index i, Eigen::Index j) const {
    return {q[i] * x_per_q_[i] - q[j] * x_per_q_[j], p[i] * y_per_p_[i] - p[j] * y_per_p_[j]};
  }

  Vector<Scalar, N> x_per_q_, y_per_p_;
};

template <class Vortices>
VortexDistances(const Vortices&) -> VortexDistances<typename Vortices::Scalar, Vortices::Dof>;

}  // namespace semiexplicit::monitors

namespace semiexplicit::detail {

template <>
inline constexpr bool leaves_time_out<monitors::Distance> = true;
template <class Scalar, int Dof>
inline constexpr bool leaves_time_out<monitors::DistanceFrom<Scalar, Dof>> = true;
template <>
inline constexpr bool leaves_time_out<monitors::ClosestPair> = true;
template <class Scalar, int N>
inline constexpr bool leaves_time_out<monitors::VortexDistances<Scalar, N>> = true;

}  // namespace semiexplicit::detail
