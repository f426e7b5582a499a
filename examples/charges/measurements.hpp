#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/gyration.hpp"
#include "../common/measurement.hpp"
#include "../common/scene_choice.hpp"

namespace examples {

/// Follows a coordinate that goes up and down: how long that takes, and how far it gets.
class Bouncing {
 public:
  void see(double t, double z) {
    ++samples_;
    if (crossing_.see(t, Crossing<1>::Values(z))) {
      latest_ = crossing_.place().t;
      if (passages_++ == 0)
        first_ = latest_;
      else
        fewest_ = std::min(fewest_, samples_), nearest_ = std::min({nearest_, above_, below_});
      open_ = std::max(open_, crossing_.uncertain([](const auto& a, const auto& b) { return a.t - b.t; }));
      samples_ = 0;
      above_ = below_ = 0;
    }
    above_ = std::max(above_, z);
    below_ = std::max(below_, -z);
    if (seen_) longest_ = std::max(longest_, t - last_t_);
    seen_ = true;
    last_t_ = t;
    highest_.see(std::abs(z));
  }
  /// Why there is no figure of a charge that gyrates by about `rate`, and so many times as fast where it
  /// turns back, in a field alone or with other effects; empty where there is one.
  std::string missing(double rate, double faster, bool alone) const {
    if (const std::string coarse = too_coarse(rate * longest_); !coarse.empty()) return coarse;
    if (const std::string coarse = too_coarse(rate * faster * longest_, 2); !coarse.empty())
      return "where it turns back " + coarse;
    if (passages_ < 2)
      return alone ? "the run has no whole bounce; give more --time"
                   : "the run has no whole bounce through z = 0, which need not be the middle with other "
                     "effects; give more --time, or leave them out";
    if (fewest_ < 16) return "a bounce has " + std::to_string(fewest_) + " steps; give a smaller --dt";
    if (nearest_ < highest_.value() / 10)
      return "the charge turns near z = 0, where no bounce plainly ends; give another --pitch, or "
             "other effects";
    return "";
  }
  double period() const { return (latest_ - first_) / static_cast<double>(passages_ - 1); }
  /// That, beside a formula for it. Bounces are not all the same.
  Figure figure(const std::string& formula, double expected, const std::string& off) const {
    Figure mean = compared("bounce period, s", period(), period_uncertain(), formula, expected, off);
    mean.beside = "mean of " + counted(passages_ - 1, "bounce") + "; " + mean.beside;
    return mean;
  }
  /// What the steps leave open of that, at both ends.
  double period_uncertain() const { return 2 * open_ / static_cast<double>(passages_ - 1); }
  const Largest& highest() const { return highest_; }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    visit(passages_);
    visit(samples_);
    visit(fewest_);
    crossing_.visit_memory(visit);
    for (double* number : {&last_t_, &first_, &latest_, &longest_, &open_, &above_, &below_, &nearest_})
      visit(*number);
    highest_.visit_memory(visit);
  }

 private:
  bool seen_ = false;
  Crossing<1> crossing_;
  double last_t_ = 0, first_ = 0, latest_ = 0, longest_ = 0, open_ = 0;
  double above_ = 0, below_ = 0, nearest_ = INFINITY;  // how far to both sides, and the least of a bounce
  Largest highest_;
  std::int64_t passages_ = 0, samples_ = 0, fewest_ = std::int64_t{1} << 62;
};

/// The velocity at the start, from the energy and the angle to the field.
struct Velocity {
  explicit Velocity(const Choice& c)
      : all(std::sqrt(2 * c["energy"] / c["mass"])),
        across(all * std::sin(c["pitch"])),
        along(all * std::cos(c["pitch"])) {}
  /// Does it go across the field, so that it gyrates?
  bool crosses() const { return across > 1e-12 * all; }
  static constexpr const char* no_crossing =
      "nothing moves across the field; give another --pitch or --energy";
  double all, across, along;
};

inline Measurement<3> slow_gyration(const Choice& c) {
  const Velocity v(c);
  return gyration(c, c["mass"], c["mass"] * v.across, "eB/m", "mv/(eB)",
                  v.crosses() ? "" : Velocity::no_crossing);
}

/// The adiabatic estimates are for a gyroradius much smaller than the length of the field, and for the field
/// alone.
inline Measurement<3> mirrors(const Choice& c) {
  if (!c.on("magnetic_bottle")) return {};
  const auto bouncing = std::make_shared<Bouncing>();
  const Velocity v(c);
  const double length = c["length"], gyroradius = std::abs(v.across * c["mass"] / (c["charge"] * c["b0"]));
  const bool alone = c.only_field("magnetic_bottle");
  const std::string no_estimate = !alone                       ? "other effects than the field are on"
                                  : gyroradius > 0.05 * length ? "the gyroradius is not small beside --length"
                                                               : "";
  return {
      [=](double t, const In<double, 3>& q, const In<double, 3>&) { bouncing->see(t, q[2]); },
      memory_of(bouncing),
      [=](const Run&) -> std::vector<Figure> {
        const double top = bouncing->highest().value() / length, faster = 1 + top * top;
        std::string why = v.crosses()
                              ? bouncing->missing(std::abs(c["charge"] * c["b0"]) / c["mass"], faster, alone)
                              : Velocity::no_crossing;
        const bool stays = length * std::abs(v.along) / v.across < 1e-6 * gyroradius;
        if (v.crosses() && stays && bouncing->highest().value() < 1e-6 * gyroradius)
          why = "the charge stays in the middle; give another --pitch";
        if (!why.empty())
          return {not_measured("turning point and bounce period",
                               why + (why.find("--time") == why.npos
                                          ? ""
                                          : ", or a stronger field, which keeps the charge near the axis"))};
        return {compared(alone ? "turning point, m" : "largest |z|, m", bouncing->highest().value(),
                         bouncing->highest().uncertain(), "adiabatic, L cot(pitch)",
                         length * std::abs(v.along) / v.across, no_estimate),
                bouncing->figure("adiabatic, 2πL/(v sin(pitch))", 2 * std::numbers::pi * length / v.across,
                                 no_estimate)};
      }};
}

/// Source: M. Schulz and L. Lanzerotti, Particle Diffusion in the Radiation Belts (1974), section I.4, for a
/// guiding centre of vanishing gyroradius.
inline Measurement<3> bounce_and_drift(const Choice& c) {
  if (!c.on("dipole_field")) return {};
  const auto bouncing = std::make_shared<Bouncing>();
  const auto drifting = std::make_shared<Turning>();
  const double v = Velocity(c).all, y = std::sin(c["pitch"]), l = c["r"];
  const double way = 1.3802 - 0.3198 * (y + std::sqrt(y)), bounce = 4 * l / v * way;
  const double drift = (5.5208 - 0.4381 * y - 0.6397 * (y * std::log(y) + std::sqrt(y))) / 12;
  const double rate = 3 * l * v * v * c["mass"] / (c["charge"] * c["moment"]) * drift / way;
  // As an angle about the dipole.
  const double gyroradius = std::abs(Velocity(c).across * c["mass"] * l * l / (c["charge"] * c["moment"]));
  const bool alone = c.only_field("dipole_field");
  const std::string no_estimate =
      !alone ? "other effects than the field are on"
      : !(gyroradius < 0.1) || !(y > 0.01)
          ? "the gyroradius is not small beside --r, or --pitch is too near to the field"
          : "";
  return {[=](double t, const In<double, 3>& q, const In<double, 3>&) {
            bouncing->see(t, q[2]);
            drifting->see(t, q[0], q[1]);
          },
          [=](CheckpointMemory& visit) {
            bouncing->visit_memory(visit);
            drifting->visit_memory(visit);
          },
          [=](const Run&) -> std::vector<Figure> {
            const std::string coarse = too_coarse(drifting->largest());
            const Velocity start(c);
            const bool stays = std::abs(start.along) < 1e-6 * start.all;
            // At both ends the gyration is part of the angle, and the drift is faster here and slower there
            // on a bounce, twice to and fro.
            const double share =
                (2 * gyroradius + std::abs(drifting->rate()) * bounce / (2 * std::numbers::pi)) /
                std::abs(drifting->turned());
            const double period = 2 * std::numbers::pi / drifting->rate();
            // A line of the field from there goes up to 0.38 of it.
            const std::string lost =
                drifting->farthest() < 2 * l && bouncing->highest().value() < l
                    ? ""
                    : "the field does not hold the charge; give a smaller --r, or less --energy";
            const std::string no_bounce = !start.crosses() ? Velocity::no_crossing
                                          : !lost.empty()  ? lost
                                          : stays && bouncing->highest().value() < 1e-6 * l
                                              ? "the charge stays in the equator; give another --pitch"
                                              : bouncing->missing(v / (gyroradius * l), 1, alone),
                              no_drift =
                                  !alone            ? "other effects than the field make the drift uneven"
                                  : !lost.empty()   ? lost
                                  : !coarse.empty() ? coarse
                                  : share < 0.1
                                      ? ""
                                      : "the drift is not yet large beside the gyroradius; give more --time";
            const std::string drift_name = "drift period, s (westward: negative)";
            return {no_bounce.empty() ? bouncing->figure("adiabatic", bounce, no_estimate)
                                      : not_measured("bounce period, s", no_bounce),
                    no_drift.empty() ? compared(drift_name, period, share * std::abs(period), "adiabatic",
                                                2 * std::numbers::pi / rate, no_estimate)
                                     : not_measured(drift_name, no_drift)};
          }};
}

}  // namespace examples
