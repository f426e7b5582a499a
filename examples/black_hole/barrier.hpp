#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <semiexplicit/systems/black_hole.hpp>

namespace examples {

inline double outer_horizon(const semiexplicit::effects::black_hole::Kerr<>& hole) {
  return hole.mass + std::sqrt(hole.mass * hole.mass - hole.spin * hole.spin);
}

/// What an orbit whirls above: the minimum of Carter's radial potential (1968), eq. (62), for a unit mass,
///
///     R(r) = k² - (r² - 2 M r + a²) (r² + (L - a E)² + Q),   k = (r² + a²) E - a L,
///
/// between the horizon and the periapsis; and what rounding makes of an orbit there: that of its start, a
/// turning point of r at `start`, which moves E, and that of its steps.
class Barrier {
  using Wide = long double;  // the terms of R cancel beside the barrier, by more digits than a double has

 public:
  Barrier(const semiexplicit::effects::black_hole::Kerr<>& hole, double start, double energy, double momentum,
          double carter)
      : M_(hole.mass), a_(hole.spin), E_(energy), L_(momentum), Q_(carter) {
    const Wide r0 = start, horizon = outer_horizon(hole);
    mass2_ = (k(r0) * k(r0) / delta(r0) - std::pow(L_ - a_ * E_, 2) - Q_) / (r0 * r0);
    const Wide c4 = E_ * E_ - mass2_, c3 = 2 * mass2_ * M_, c2 = a_ * a_ * c4 - L_ * L_ - Q_,
               c1 = 2 * M_ * (std::pow(L_ - a_ * E_, 2) + Q_);
    const auto slope = [&](Wide r) { return ((4 * c4 * r + 3 * c3) * r + 2 * c2) * r + c1; };
    if (!(c4 < 0)) return;
    // Between the two places where R bends neither way it has its minimum, if any.
    const Wide bends = std::sqrt(c3 * c3 / 4 - 2 * c4 * c2 / 3);
    Wide r = (bends - c3 / 2) / (2 * c4), outer = -(bends + c3 / 2) / (2 * c4);
    if (!(slope(r) < 0 && slope(outer) > 0)) return;
    for (int i = 0; i < 60; ++i) {
      const Wide middle = (r + outer) / 2;
      (slope(middle) < 0 ? r : outer) = middle;
    }
    if (!(r > horizon)) return;
    place_ = r;
    // By this much R is off where E is by one rounding: as the start stays where it is, its mass is off, too.
    // Both cancel beside the start; the rounding of the steps does not. The factors are measured.
    const Wide by_energy = k(r) * (r * r + a_ * a_),
               by_mass = k(r0) * (r0 * r0 + a_ * a_) * delta(r) * r * r / (delta(r0) * r0 * r0),
               off = std::numeric_limits<double>::epsilon() *
                     (4 * std::abs(by_energy - by_mass) + (std::abs(by_energy) + std::abs(by_mass)) / 10);
    // The motion past the barrier takes as many turns as the logarithm of its height.
    const Wide bend = (6 * c4 * r + 3 * c3) * r + c2, height = std::abs(radial(r)),
               turning = std::copysign(std::sqrt(L_ * L_ + std::max(Wide(0), Q_)), L_) - a_ * E_ +
                         a_ * k(r) / delta(r);
    in_turns_ = std::abs(turning) / (std::numbers::pi_v<Wide> * std::sqrt(bend)) * off / (2 * height);
    in_nearest_ = off / (2 * std::sqrt(bend * height));
  }

  /// R(r), for the mass that the start has: a body moves where it is positive.
  Wide radial(Wide r) const {
    return k(r) * k(r) - delta(r) * (mass2_ * r * r + std::pow(L_ - a_ * E_, 2) + Q_);
  }
  /// Whether a body that comes from there, which may be beneath, turns back.
  bool turns_back(double from) const { return place_ > 0 && place_ < from && radial(place_) < 0; }
  double by_rounding_in_turns() const { return double(in_turns_); }      ///< of an orbit
  double by_rounding_in_nearest() const { return double(in_nearest_); }  ///< r
  /// How often it turns, or that it falls.
  bool rounding_decides() const { return !(in_turns_ < Wide(0.1)); }

 private:
  Wide k(Wide r) const { return (r * r + a_ * a_) * E_ - a_ * L_; }
  Wide delta(Wide r) const { return r * r - 2 * M_ * r + a_ * a_; }

  Wide M_, a_, E_, L_, Q_, mass2_ = 1;
  Wide place_ = 0;  // of the minimum; 0 where there is none
  Wide in_turns_ = 0, in_nearest_ = 0;
};

}  // namespace examples
