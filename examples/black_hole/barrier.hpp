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
/// between the horizon and the periapsis; and what the rounding of a start at `start`, which moves E, makes
/// of an orbit there.
class Barrier {
 public:
  Barrier(const semiexplicit::effects::black_hole::Kerr<>& hole, double start, double energy, double momentum,
          double carter)
      : M_(hole.mass), a_(hole.spin), E_(energy), L_(momentum), Q_(carter) {
    const double c4 = E_ * E_ - 1, c2 = a_ * a_ * c4 - L_ * L_ - Q_,
                 c1 = 2 * M_ * (std::pow(L_ - a_ * E_, 2) + Q_);
    const auto slope = [&](double r) { return ((4 * c4 * r + 6 * M_) * r + 2 * c2) * r + c1; };
    if (!(c4 < 0)) return;
    // Between the two places where R bends neither way it has its minimum, if any.
    const double bends = std::sqrt(M_ * M_ - 2 * c4 * c2 / 3);
    double r = (bends - M_) / (2 * c4), outer = -(bends + M_) / (2 * c4);
    if (!(slope(r) < 0 && slope(outer) > 0)) return;
    for (int i = 0; i < 60; ++i) {
      const double middle = (r + outer) / 2;
      (slope(middle) < 0 ? r : outer) = middle;
    }
    if (!(r > outer_horizon(hole))) return;
    const double bend = (6 * c4 * r + 6 * M_) * r + c2, depth = std::max(0.0, -radial(r));
    // In R, where the start stays where it is and the mass of the body is off by as much. The factor is
    // measured.
    const auto by_energy = [this](double at) { return k(at) * (at * at + a_ * a_); };
    const auto by_mass = [this](double at) { return delta(at) * at * at; };
    const double by_start = 4 * std::numeric_limits<double>::epsilon() *
                            std::abs(by_energy(r) - by_energy(start) * by_mass(r) / by_mass(start));
    // The motion past the barrier takes as many turns as the logarithm of its depth.
    const double turning =
        std::copysign(std::sqrt(L_ * L_ + std::max(0.0, Q_)), L_) - a_ * E_ + a_ * k(r) / delta(r);
    in_turns_ = std::abs(turning) / (std::numbers::pi * std::sqrt(bend)) * by_start / (2 * depth);
    in_nearest_ = by_start / (2 * std::sqrt(bend * depth));
  }

  /// R(r): a body moves where it is positive.
  double radial(double r) const { return k(r) * k(r) - delta(r) * (r * r + std::pow(L_ - a_ * E_, 2) + Q_); }
  double by_start_in_turns() const { return in_turns_; }      ///< of an orbit
  double by_start_in_nearest() const { return in_nearest_; }  ///< r
  bool rounding_decides() const { return !(in_turns_ < 0.1); }

 private:
  double k(double r) const { return (r * r + a_ * a_) * E_ - a_ * L_; }
  double delta(double r) const { return r * r - 2 * M_ * r + a_ * a_; }

  double M_, a_, E_, L_, Q_;
  double in_turns_ = 0, in_nearest_ = 0;
};

}  // namespace examples
