#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/method.hpp"

namespace examples {

using namespace semiexplicit;
namespace geodesics = effects::geodesics;
using State4 = PhasePoint<double, 4>;

/// p_θ of a body in the equator at r, with p_r = 0, energy E and angular momentum L, from H = -1/2; none
/// where it cannot be.
template <class M>
std::optional<State4> equatorial(const M& metric, double r, double energy, double l) {
  const Vector<double, 4> x(0, r, std::numbers::pi / 2, 0);
  const auto g = metric(x);
  const double square =
      -(1 + g(0, 0) * energy * energy - 2 * g(0, 3) * energy * l + g(3, 3) * l * l) / g(2, 2);
  if (!(square >= 0)) return std::nullopt;
  return State4(x, {-energy, 0, std::sqrt(square), l});
}

/// The widest interval of r between `least` and `most` in which a body can be, in steps of `step`, but not
/// one that reaches to these: there it falls in or leaves.
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
struct Orbit {
  double worst_energy = 0, log_alignment = 0;
  bool ended = false;            ///< it fell into the hole, left, or a step failed
  double time = 0;               ///< that it took, in M
  std::vector<double> points{};  ///< r and p_r where it passed the equator upwards, by turns

  bool chaotic() const { return log_alignment < std::log(1e-8); }

  /// All that as numbers, and back.
  std::vector<double> numbers() const {
    std::vector<double> all{worst_energy, log_alignment, ended ? 1.0 : 0.0, time};
    all.insert(all.end(), points.begin(), points.end());
    return all;
  }
  static Orbit from(const std::vector<double>& all) {
    return {all.at(0), all.at(1), all.at(2) > 0, all.at(3), {all.begin() + 4, all.end()}};
  }
};

/// A body that starts at rest in r in the middle of the k-th of `count` parts of the interval. Throws
/// std::runtime_error where there is none.
template <class M>
State4 start_of(const M& metric, const std::pair<double, double>& interval, std::int64_t k,
                std::int64_t count, double energy, double l) {
  const double part = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
  const auto start =
      equatorial(metric, interval.first + (interval.second - interval.first) * part, energy, l);
  if (!start)
    throw std::runtime_error("no orbit starts in the middle of the allowed region; take other parameters");
  return *start;
}

/// One orbit from the equator, until it has passed it so often upwards; seen(n) hears of each passage.
inline Orbit follow(const RuntimeScene<double, 4>& scene, const Method& method, const State4& start,
                    double dt, std::int64_t crossings, const std::function<void(std::int64_t)>& seen) {
  Orbit orbit;
  with_projected_stepper(method, scene, [&](auto& stepper) {
    AlignmentIndex alignment(stepper, 2);
    Invariants invariants(scene);
    std::int64_t count = 0;
    const auto write = [&](double, const State4& z) {
      orbit.points.insert(orbit.points.end(), {z.q()[1], z.p()[1]});
      seen(++count);
      return count < crossings;
    };
    auto section = poincare_section(
        scene, [](const auto& q, const auto&) { return std::numbers::pi / 2 - q[2]; }, write);
    const auto stays = [](double, const State4& now) { return now.q()[1] > 2.05 && now.q()[1] < 1e4; };
    State4 z = start;
    const IntegrationReport run =
        integrate(stepper, z, {.dt = dt, .steps = 50'000 * crossings, .on_failure = OnFailure::stop}, section,
                  alignment, invariants, stays);
    orbit.ended = !run.ok() || count < crossings;
    orbit.time = run.t;
    orbit.worst_energy = invariants["energy"].worst;
    orbit.log_alignment = alignment.log_index(2);
  });
  return orbit;
}

}  // namespace examples
