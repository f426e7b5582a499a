#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <deque>
#include <functional>
#include <limits>
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

/// r of the outer horizon.
inline double horizon(const geodesics::KerrMetric<double>& hole) {
  return hole.mass * (1 + std::sqrt((1 - hole.spin) * (1 + hole.spin)));
}
inline double horizon(const geodesics::ErnstMetric<double>& hole) { return 2 * hole.mass; }

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

/// Where a body of some E and L can be in the equator, and from where on it counts as lost.
struct Region {
  double inner = 0, outer = 0;       ///< r
  double fallen = 0, left = 0;       ///< a smaller r, a larger one
  std::int64_t most_periods = 1000;  ///< of a circle of the mean r, for one passage of the equator

  double most_time() const {
    return static_cast<double>(most_periods) * 2 * std::numbers::pi * std::pow((inner + outer) / 2, 1.5);
  }
};

/// The widest region between the horizon and r = 10⁶ M in which a body can be, but not one that reaches to
/// these: there it falls in or leaves. Looked for by steps of 1e-4 of the distance from the horizon, so that
/// what is narrower may be missed; its ends are as exact as the numbers. Throws std::invalid_argument where
/// there is none.
template <class M>
Region allowed(const M& metric, double energy, double l) {
  const double r_horizon = horizon(metric);
  const auto can = [&](double r) { return equatorial(metric, r, energy, l).has_value(); };
  const auto edge = [&](double in, double out) {  // the last r that can be
    for (int i = 0; i < 60; ++i) {
      const double middle = (in + out) / 2;
      (can(middle) ? in : out) = middle;
    }
    return in;
  };
  Region best;
  double begin = 0, last = r_horizon * (1 + 1e-6);
  bool inside = can(last), falls = inside;
  for (double beyond = last - r_horizon; beyond < 1e6; beyond *= 1.0001) {
    const double r = r_horizon + beyond;
    const bool now = can(r);
    if (now && !inside) begin = edge(r, last);
    if (!now && inside && !falls) {
      const double end = edge(last, r);
      if (end - begin > best.outer - best.inner) best = {.inner = begin, .outer = end};
    }
    if (!now) falls = false;
    inside = now, last = r;
  }
  if (!(best.outer > best.inner))
    throw std::invalid_argument(
        "no orbit of this --energy and --angular-momentum is bound whatever its inclination: those that may "
        "be in a region that reaches the hole are left out");
  best.fallen = r_horizon + (best.inner - r_horizon) / 40;
  best.left = std::max(1e4, 10 * best.outer);
  return best;
}

/// What came of one orbit.
struct Orbit {
  enum class End { all_passages, fell, left, failed, most_time };

  double worst_energy = 0, log_alignment = 0;
  End end = End::all_passages;
  double time = 0;               ///< that it took, in M
  std::vector<double> points{};  ///< r and p_r where it passed the equator upwards, by turns

  bool chaotic() const { return end != End::failed && log_alignment < std::log(1e-8); }
  /// Whether it came through a step, so that there is an error.
  bool measured() const { return time > 0; }

  /// All that as numbers, and back.
  std::vector<double> numbers() const {
    std::vector<double> all{worst_energy, log_alignment, static_cast<double>(end), time};
    all.insert(all.end(), points.begin(), points.end());
    return all;
  }
  static Orbit from(const std::vector<double>& all) {
    return {all.at(0), all.at(1), static_cast<End>(all.at(2)), all.at(3), {all.begin() + 4, all.end()}};
  }
};

/// A body that starts at rest in r in the middle of the k-th of `count` parts of the region. Throws
/// std::runtime_error where there is none.
template <class M>
State4 start_of(const M& metric, const Region& region, std::int64_t k, std::int64_t count, double energy,
                double l) {
  const double part = (static_cast<double>(k) + 0.5) / static_cast<double>(count);
  const auto start = equatorial(metric, region.inner + (region.outer - region.inner) * part, energy, l);
  if (!start)
    throw std::runtime_error("no orbit starts in the middle of the allowed region; take other parameters");
  return *start;
}

/// How far north of the equator.
inline double latitude(const auto& q) { return std::numbers::pi / 2 - q[2]; }

/// Where the orbit passes the equator at about the time `after` z, by steps to that place: between long steps
/// interpolation tells the time, and the place badly. None where such a step fails.
template <class Stepper>
std::optional<State4> passage(Stepper stepper, State4 z, double after) {
  for (int i = 0; i < 30; ++i) {
    if (after != 0 && !stepper.step(z, after).ok()) return std::nullopt;
    if (!(std::abs(latitude(z.q())) > 1e-14)) break;
    State4 gradient(4);
    stepper.hamiltonian().gradient(z.q(), z.p(), gradient.q(), gradient.p());
    after = latitude(z.q()) / gradient.p()[2];
  }
  return z;
}

/// One orbit from the equator, until it has passed it so often upwards; seen(n) hears of each passage.
inline Orbit follow(const RuntimeScene<double, 4>& scene, const Method& method, const State4& start,
                    const Region& region, double dt, std::int64_t crossings,
                    const std::function<void(std::int64_t)>& seen) {
  using End = Orbit::End;
  Orbit orbit;
  with_projected_stepper(method, scene, [&](auto& stepper) {
    AlignmentIndex alignment(stepper, 2);
    Invariants invariants(scene);
    std::int64_t count = 0;
    std::deque<std::pair<double, State4>> last;  // the states that the section may be between
    const auto keep = [&](double t, const State4& z) {
      last.emplace_back(t, z);
      if (last.size() > 8) last.pop_front();
    };
    const auto write = [&](double t, const State4&) {
      if (orbit.end == End::failed) return false;  // within the step that lost the energy
      const auto& [begin, z] =
          *std::find_if(last.rbegin(), last.rend() - 1, [t](const auto& one) { return one.first <= t; });
      const auto point = passage(stepper, z, t - begin);
      if (!point) {
        orbit.end = End::failed;
        return false;
      }
      orbit.points.insert(orbit.points.end(), {point->q()[1], point->p()[1]});
      seen(++count);
      return count < crossings;
    };
    auto section = poincare_section(
        scene, [](const auto& q, const auto&) { return latitude(q); }, write);
    const auto stays = [&](double t, const State4& now) {  // comes before the section
      const double r = now.q()[1];
      orbit.time = t;
      if (r < region.fallen) orbit.end = End::fell;
      if (r > region.left) orbit.end = End::left;
      if (!(invariants["energy"].worst <= 1e-2)) orbit.end = End::failed;  // it is another motion by then
      return orbit.end == End::all_passages;
    };
    State4 z = start;
    const double most_steps = std::ceil(region.most_time() * static_cast<double>(crossings) / dt);
    try {
      const IntegrationReport run =
          integrate(stepper, z,
                    {.dt = dt, .steps = static_cast<std::int64_t>(most_steps), .on_failure = OnFailure::stop},
                    invariants, stays, keep, section, alignment);
      orbit.time = run.t;
      if (!run.ok())
        orbit.end = End::failed;
      else if (orbit.end != End::failed && count == crossings)
        orbit.end = End::all_passages;
      else if (run.status == Status::success)
        orbit.end = End::most_time;
    } catch (const std::runtime_error&) {  // of the alignment index: the step has no tangent map
      orbit.end = End::failed;
    }
    orbit.worst_energy = invariants["energy"].worst;
    orbit.log_alignment = alignment.log_index(2);
  });
  return orbit;
}

}  // namespace examples
