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
///     R(r) = ((r² + a²) E - a L)² - (r² - 2 M r + a²) (r² + (L - a E)² + Q),
///
/// between the horizon and the periapsis.
class Barrier {
 public:
  Barrier(const semiexplicit::effects::black_hole::Kerr<>& hole, double energy, double momentum,
          double carter)
      : M_(hole.mass), a_(hole.spin), E_(energy), L_(momentum), Q_(carter) {
    const double c4 = E_ * E_ - 1, c2 = a_ * a_ * c4 - L_ * L_ - Q_,
                 c1 = 2 * M_ * (std::pow(L_ - a_ * E_, 2) + Q_);
    const auto slope = [&](double r) { return ((4 * c4 * r + 6 * M_) * r + 2 * c2) * r + c1; };
    if (!(c4 < 0)) return;
    // Between the two places where R bends neither way it has its minimum, if any.
    const double bends = std::sqrt(M_ * M_ - 2 * c4 * c2 / 3);
    double inner = (bends - M_) / (2 * c4), outer = -(bends + M_) / (2 * c4);
    if (!(slope(inner) < 0 && slope(outer) > 0)) return;
    for (int i = 0; i < 60; ++i) {
      const double middle = (inner + outer) / 2;
      (slope(middle) < 0 ? inner : outer) = middle;
    }
    if (!(inner > outer_horizon(hole))) return;
    r_ = inner;
    bend_ = (6 * c4 * r_ + 6 * M_) * r_ + c2;
  }

  /// R(r): a body moves where it is positive.
  double radial(double r) const {
    const double k = (r * r + a_ * a_) * E_ - a_ * L_;
    return k * k - delta(r) * (r * r + std::pow(L_ - a_ * E_, 2) + Q_);
  }
  /// What the rounding of a start at that r, which moves E, makes of the turns of an orbit: the motion past
  /// the barrier takes as many as the logarithm of its depth.
  double by_start_in_turns(double start) const {
    if (r_ == 0) return 0;
    const double k = (r_ * r_ + a_ * a_) * E_ - a_ * L_;
    const double turning =
        std::copysign(std::sqrt(L_ * L_ + std::max(0.0, Q_)), L_) - a_ * E_ + a_ * k / delta(r_);
    return std::abs(turning) / (std::numbers::pi * std::sqrt(bend_)) * by_start(start) / (2 * depth());
  }
  /// The same of the nearest r.
  double by_start_in_nearest(double start) const {
    return r_ == 0 ? 0 : by_start(start) / (2 * std::sqrt(bend_ * depth()));
  }

 private:
  double delta(double r) const { return r * r - 2 * M_ * r + a_ * a_; }
  double depth() const { return std::max(0.0, -radial(r_)); }
  /// In R, where the start stays where it is and the mass of the body is off by as much. The factor is
  /// measured.
  double by_start(double start) const {
    const auto by_energy = [this](double r) {
      const double squared = r * r + a_ * a_;
      return (squared * E_ - a_ * L_) * squared;
    };
    const auto by_mass = [this](double r) { return delta(r) * r * r; };
    return 4 * std::numeric_limits<double>::epsilon() *
           std::abs(by_energy(r_) - by_energy(start) * by_mass(r_) / by_mass(start));
  }

  double M_, a_, E_, L_, Q_;
  double r_ = 0, bend_ = 0;  ///< where the minimum is, 0 where there is none, and R''/2 there
};

}  // namespace examples
