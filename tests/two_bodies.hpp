#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

/// Two bodies of mass 1 in a plane that attract each other, H = |p|²/2 - 1/r.
inline auto two_bodies() {
  return semiexplicit::from_energy<4>([](const auto& q, const auto& p) {
    using std::sqrt;
    const auto x = q[0] - q[2], y = q[1] - q[3];
    return p.squaredNorm() / 2 - 1 / sqrt(x * x + y * y);
  });
}
/// At a distance 1 from each other, so far from the origin, bound, and on their way.
inline semiexplicit::PhasePoint<double, 4> two_bodies_at(double far) {
  return {{far + 0.5, 0, far - 0.5, 0}, {0.3, 0.5, 0.3, -0.6}};
}
