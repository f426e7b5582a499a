#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "measurement.hpp"
#include "scene_choice.hpp"

namespace examples {

/// A charge of this mass, or γ times it, and momentum across a uniform field turns about the origin: how
/// fast, and how far away, beside formulas of these names. Other effects than the field would make it wander.
/// `along`: why nothing is measured of what moves along the field, or empty.
inline Measurement<3> gyration(const Choice& c, double mass, double momentum, const std::string& frequency,
                               const std::string& radius, const std::string& along) {
  const auto turning = std::make_shared<Turning>();
  const bool alone = c.only_field("uniform_field");
  const double force = c["charge"] * (alone ? c["b"] : 0), rate = force / mass;
  return {[=](double t, const In<double, 3>& q, const In<double, 3>&) { turning->see(t, q[0], q[1]); },
          memory_of(turning),
          [=](const Run&) -> std::vector<Figure> {
            const std::string coarse = too_coarse(turning->largest(rate));
            const std::string why = !alone            ? "the formula holds for uniform_field alone"
                                    : !along.empty()  ? along
                                    : !coarse.empty() ? coarse
                                    : std::abs(turning->turned()) < 2 * std::numbers::pi
                                        ? "the run has no whole turn; give more --time"
                                        : "";
            if (!why.empty()) return {not_measured("gyrofrequency", why)};
            return {compared("gyrofrequency, rad/s", -turning->rate(), 0, frequency, rate),
                    compared("gyroradius, m", turning->mean_radius(), 0, radius, std::abs(momentum / force))};
          }};
}

}  // namespace examples
