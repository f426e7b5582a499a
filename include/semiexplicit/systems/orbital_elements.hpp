#pragma once

#include <cmath>
#include <stdexcept>

#include <Eigen/Geometry>
#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit::effects::orbits {

/// Kepler's elements of a bound orbit. Angles in radians: inclination and node to the plane of the first two
/// axes, the argument of the periapsis from the node, the mean anomaly from the periapsis.
template <class Scalar = double>
struct Elements {
  Scalar a = Scalar(1), e = Scalar(0);  ///< semi-major axis, length; eccentricity, 0 <= e < 1
  Scalar inclination = Scalar(0), node = Scalar(0), periapsis = Scalar(0), mean_anomaly = Scalar(0);
};

namespace detail {

/// x - sin x, to rounding also where x is small.
template <class Scalar>
Scalar less_sine(const Scalar& x) {
  using std::abs;
  using std::sin;
  if (!(abs(x) < 1)) return x - sin(x);
  Scalar term = x * x * x / 6, sum = term;
  for (int n = 4; abs(term) > Eigen::NumTraits<Scalar>::epsilon() * abs(sum); n += 2) {
    term *= -x * x / Scalar(n * (n + 1));
    sum += term;
  }
  return sum;
}

/// 1 - cos x, likewise.
template <class Scalar>
Scalar less_cosine(const Scalar& x) {
  using std::sin;
  const Scalar half = sin(x / 2);
  return 2 * half * half;
}

}  // namespace detail

/// The eccentric anomaly E of E - e sin E = M. Source: J. Danby, Fundamentals of Celestial Mechanics, 2nd
/// ed., section 6.6.
template <class Scalar>
Scalar eccentric_anomaly(const Scalar& mean_anomaly, const Scalar& e) {
  using std::abs;
  using std::sin;
  // 1 - e stands alone, since near the periapsis of a steep orbit nothing else is left of x - e sin x.
  Scalar x = mean_anomaly + (sin(mean_anomaly) < 0 ? -e : e) * Scalar(17) / 20;
  for (int i = 0; i < 60; ++i) {
    const Scalar step =
        ((1 - e) * x + e * detail::less_sine(x) - mean_anomaly) / ((1 - e) + e * detail::less_cosine(x));
    x -= step;
    if (abs(step) <= 4 * Eigen::NumTraits<Scalar>::epsilon() * (1 + abs(x))) break;
  }
  return x;
}

/// Position and velocity on an orbit about a centre of the given GM. Throws std::invalid_argument unless a
/// and GM are positive and 0 <= e < 1.
template <class Scalar>
PhasePoint<Scalar, 3> state_of(const Elements<Scalar>& orbit, const Scalar& gm) {
  using std::cos;
  using std::sin;
  using std::sqrt;
  if (!(orbit.a > 0 && orbit.e >= 0 && orbit.e < 1 && gm > 0))
    throw std::invalid_argument("state_of: a bound orbit has a > 0, 0 <= e < 1 and GM > 0");
  const Scalar x = eccentric_anomaly(orbit.mean_anomaly, orbit.e);
  // 1 - e stands alone here, too: in 1 - e cos x and cos x - e.
  const Scalar minor = sqrt((1 - orbit.e) * (1 + orbit.e)), bend = detail::less_cosine(x);
  const Scalar speed = sqrt(gm / orbit.a) / ((1 - orbit.e) + orbit.e * bend);
  const Scalar along = orbit.a * ((1 - orbit.e) - bend), across = orbit.a * minor * sin(x);
  const Scalar v_along = -speed * sin(x), v_across = speed * minor * cos(x);
  const Scalar co = cos(orbit.node), so = sin(orbit.node), ci = cos(orbit.inclination),
               si = sin(orbit.inclination), cw = cos(orbit.periapsis), sw = sin(orbit.periapsis);
  const Vector<Scalar, 3> to_periapsis(co * cw - so * sw * ci, so * cw + co * sw * ci, sw * si),
      beside(-co * sw - so * cw * ci, -so * sw + co * cw * ci, cw * si);
  return {along * to_periapsis + across * beside, v_along * to_periapsis + v_across * beside};
}

/// The elements of the orbit through a position with a velocity. The node of an orbit in the plane is 0, on
/// the first axis; a circle counts as one whose periapsis is where the body is now. Throws
/// std::invalid_argument where the orbit is not bound, or a line but for rounding.
template <class Scalar>
Elements<Scalar> elements_of(const Vector<Scalar, 3>& q, const Vector<Scalar, 3>& v, const Scalar& gm) {
  using semiexplicit::detail::norm;
  using std::atan2, std::cos, std::sin, std::sqrt;
  const Scalar r = norm(q), per_a = 2 / r - v.dot(v) / gm;
  if (!(per_a > 0)) throw std::invalid_argument("elements_of: the orbit is not bound");
  const Vector<Scalar, 3> momentum = q.cross(v);
  // sqrt(1 - e²), which says more of an e near 1 than e.
  const Scalar turning = norm(momentum), minor = turning * sqrt(per_a / gm),
               epsilon = Eigen::NumTraits<Scalar>::epsilon();
  if (!(minor * minor > 4 * epsilon) || !(turning > 4 * epsilon * r * norm(v)))
    throw std::invalid_argument("elements_of: the body falls along a line, which is in no plane");
  const Scalar flat = norm(momentum.template head<2>());
  Elements<Scalar> orbit{.a = 1 / per_a};
  const Scalar ec = 1 - r * per_a, es = q.dot(v) / sqrt(gm * orbit.a);
  const Scalar squared = ec * ec + es * es;
  orbit.e = squared < Scalar(0.5) ? sqrt(squared) : sqrt((1 - minor) * (1 + minor));
  orbit.inclination = atan2(flat, momentum[2]);
  if (flat > 0) orbit.node = atan2(momentum[0], -momentum[1]);
  const Scalar x = orbit.e > 0 ? Scalar(atan2(es, ec)) : Scalar(0);
  orbit.mean_anomaly = x - es;
  const Vector<Scalar, 3> to_node(cos(orbit.node), sin(orbit.node), Scalar(0));
  const Vector<Scalar, 3> beside = momentum.cross(to_node) / turning;
  const Scalar anomaly = atan2(minor * sin(x), cos(x) - orbit.e);
  orbit.periapsis = atan2(q.dot(beside), q.dot(to_node)) - anomaly;
  return orbit;
}

}  // namespace semiexplicit::effects::orbits
