#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>

#include <semiexplicit/semiexplicit.hpp>

#include "motions.hpp"
#include "scene_choice.hpp"

namespace examples {

/// The velocity at the start, from the energy and the angle to the field.
struct Velocity {
  explicit Velocity(const Choice& c)
      : all(std::sqrt(2 * c["energy"] / c["mass"])),
        across(all * std::sin(c["pitch"])),
        along(all * std::cos(c["pitch"])) {}
  double all, across, along;
};

/// About the origin; other effects than the field would make it wander.
inline Measurement<3> gyration(const Choice& c) {
  if (!c.on("uniform_field") || c.effects.size() > (c.on("kinetic") ? 2 : 1))
    return {{},
            [](std::ostream& out) {
              out << "gyrofrequency: not measured, the formula holds for uniform_field alone\n";
            },
            {}};
  const auto turning = std::make_shared<Turning>();
  const double rate = c["charge"] * c["b"] / c["mass"], radius = std::abs(Velocity(c).across / rate);
  return {[=](double t, const HalfRef<3>& q, const HalfRef<3>&) { turning->see(t, q[0], q[1]); },
          [=](std::ostream& out) {
            print_comparison(out, "gyrofrequency, rad/s", -turning->rate(), "eB/m", rate);
            print_comparison(out, "gyroradius, m", turning->mean_radius(), "mv/(eB)", radius);
          },
          memory_of(turning)};
}

inline Measurement<3> mirrors(const Choice& c) {
  if (!c.on("magnetic_bottle")) return {};
  const auto bouncing = std::make_shared<Bouncing>();
  const Velocity v(c);
  const double length = c["length"];
  return {[=](double t, const HalfRef<3>& q, const HalfRef<3>&) { bouncing->see(t, q[2]); },
          [=](std::ostream& out) {
            if (bouncing->bounces() == 0) {
              out << "turning point and bounce period: not measured, the run has no whole bounce; give more "
                     "--time, or a stronger field, which keeps the charge near the axis\n";
              return;
            }
            print_comparison(out, "turning point, m", bouncing->highest(), "adiabatic, L cot(pitch)",
                             length * v.along / v.across);
            print_comparison(out, "bounce period, s", bouncing->period(), "adiabatic, 2πL/(v sin(pitch))",
                             2 * std::numbers::pi * length / v.across);
          },
          memory_of(bouncing)};
}

/// Source: M. Schulz and L. Lanzerotti, Particle Diffusion in the Radiation Belts (1974), section I.4, for a guiding centre
/// of vanishing gyroradius.
inline Measurement<3> bounce_and_drift(const Choice& c) {
  if (!c.on("dipole_field")) return {};
  const auto bouncing = std::make_shared<Bouncing>();
  const auto drifting = std::make_shared<Turning>();
  const double v = Velocity(c).all, y = std::sin(c["pitch"]), l = c["r"];
  const double way = 1.3802 - 0.3198 * (y + std::sqrt(y)), bounce = 4 * l / v * way;
  const double drift = (5.5208 - 0.4381 * y - 0.6397 * (y * std::log(y) + std::sqrt(y))) / 12;
  const double rate = 3 * l * v * v * c["mass"] / (c["charge"] * c["moment"]) * drift / way;
  return {[=](double t, const HalfRef<3>& q, const HalfRef<3>&) {
            bouncing->see(t, q[2]);
            drifting->see(t, q[0], q[1]);
          },
          [=](std::ostream& out) {
            if (bouncing->bounces() > 0)
              print_comparison(out, "bounce period, s", bouncing->period(), "adiabatic", bounce);
            else
              out << "bounce period: not measured, the run has no whole bounce; give more --time\n";
            print_comparison(out, "drift period, s (westward: negative)",
                             2 * std::numbers::pi / drifting->rate(), "adiabatic",
                             2 * std::numbers::pi / rate);
          },
          [=](CheckpointMemory& visit) {
            bouncing->visit_memory(visit);
            drifting->visit_memory(visit);
          }};
}

}  // namespace examples
