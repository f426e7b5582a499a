#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace examples {

using namespace semiexplicit;
namespace geodesics = effects::geodesics;
using State4 = PhasePoint<double, 4>;

/// p_θ of a body in the equator at r, with p_r = 0, energy E and angular momentum L, from H = -1/2; none where it cannot be.
template <class M>
std::optional<State4> equatorial(const M& metric, double r, double energy, double l) {
  const Vector<double, 4> x(0, r, std::numbers::pi / 2, 0);
  const auto g = metric(x);
  const double square =
      -(1 + g(0, 0) * energy * energy - 2 * g(0, 3) * energy * l + g(3, 3) * l * l) / g(2, 2);
  if (!(square >= 0)) return std::nullopt;
  return State4(x, {-energy, 0, std::sqrt(square), l});
}

/// The widest interval of r between `least` and `most` in which a body can be, in steps of `step`, but not one that reaches to these: there it
/// falls in or leaves.
template <class M>
std::pair<double, double> allowed(const M& metric, double energy, double l, double least, double most,
                                  double step) {
  std::pair<double, double> best(0, 0);
  double begin = least;
  bool inside = equatorial(metric, least, energy, l).has_value(), falls = inside;
  for (double r = least; r < most; r += step) {
    const bool can = equatorial(metric, r, energy, l).has_value();
    if (can && !inside) begin = r;
    if (!can && inside && !falls && r - begin > best.second - best.first) best = {begin, r - step};
    if (!can) falls = false;
    inside = can;
  }
  if (!(best.second > best.first))
    throw std::invalid_argument(
        "no orbit of this --energy and --angular-momentum is bound outside of the hole");
  return best;
}

/// What came of one orbit.
struct OrbitSeen {
  double r, worst_energy = 0, log_alignment = 0;
  std::int64_t crossings = 0;
  bool ended = false;  ///< it fell into the hole, left, or a step failed
};

/// One orbit from the equator: calls point(r, p_r) where it passes the equator upwards, until there are so many.
template <class M, class Point>
OrbitSeen follow(const M& metric, const State4& start, double dt, std::int64_t crossings,
                 const Point& point) {
  const Scene scene(geodesics::Geodesic<M>{metric});
  auto stepper = stepper_for(scene);
  AlignmentIndex alignment(stepper, 2);
  Invariants invariants(scene);
  OrbitSeen seen{.r = start.q()[1]};
  const auto write = [&](double, const State4& z) {
    point(z.q()[1], z.p()[1]);
    return ++seen.crossings < crossings;
  };
  auto section = poincare_section(
      scene, [](const auto& q, const auto&) { return std::numbers::pi / 2 - q[2]; }, write);
  State4 z = start;
  const auto stays = [](double, const State4& now) { return now.q()[1] > 2.05 && now.q()[1] < 1e4; };
  const IntegrationReport run =
      integrate(stepper, z, {.dt = dt, .steps = 50'000 * crossings, .on_failure = OnFailure::stop}, section,
                alignment, invariants, stays);
  seen.ended = !run.ok() || seen.crossings < crossings;
  seen.worst_energy = invariants["energy"].worst;
  seen.log_alignment = alignment.log_index(2);
  return seen;
}

}  // namespace examples
