#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <ostream>
#include <utility>

#include <semiexplicit/semiexplicit.hpp>

#include "scene_choice.hpp"
#include "table.hpp"

namespace examples {

/// Semi-latus rectum, in masses of the hole, and eccentricity.
struct Ellipse {
  double p, e;
};

/// Counts the orbits from apoapsis to apoapsis, and says what they are like. For an `ellipse` about a hole without spin the
/// turns between two apoapsides are known.
inline Measurement<4> apoapsides(const black_hole::Kerr<>& hole, const std::optional<Ellipse>& ellipse) {
  struct Seen {
    bool started = false;
    double energy = 0, momentum = 0;  // at first
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0, highest = 0;
    double last_r_momentum = 0, last_phi = 0, apoapsis = 0;
    int orbits = 0;
    void visit_memory(CheckpointMemory& visit) {
      visit(started);
      for (double* number :
           {&energy, &momentum, &nearest, &farthest, &highest, &last_r_momentum, &last_phi, &apoapsis})
        visit(*number);
      visit(orbits);
    }
  };
  using std::numbers::pi;
  const auto seen = std::make_shared<Seen>();
  const auto observe = [=](double, const HalfRef<4>& q, const HalfRef<4>& p) {
    Seen& s = *seen;
    if (!std::exchange(s.started, true)) {
      s.energy = -p[0];
      s.momentum = p[3];
    }
    if (s.last_r_momentum > 0 && p[1] <= 0) {
      const double w = s.last_r_momentum / (s.last_r_momentum - p[1]);
      s.apoapsis = s.last_phi + w * (q[3] - s.last_phi);
      ++s.orbits;
    }
    s.last_r_momentum = p[1];
    s.last_phi = q[3];
    s.nearest = std::min(s.nearest, q[1]);
    s.farthest = std::max(s.farthest, q[1]);
    s.highest = std::max(s.highest, std::abs(q[2] - pi / 2));
  };
  const auto report = [=](std::ostream& out) {
    const Seen& s = *seen;
    out << formatted("E = %.9g, L = %.9g; ", s.energy, s.momentum)
        << formatted("r from %.5f to %.5f, ", s.nearest, s.farthest)
        << formatted("%.2f degrees off the equator\n", s.highest * 180 / pi)
        << formatted("innermost stable circular orbit: r = %.5f\n", hole.innermost_stable_orbit());
    if (s.orbits == 0) {
      out << "turns from apoapsis to apoapsis: not measured, the run has no whole orbit; give more --time\n";
      return;
    }
    out << formatted("turns from apoapsis to apoapsis: %.6f", s.apoapsis / s.orbits / (2 * pi))
        << formatted(", mean of %d orbits", s.orbits);
    if (ellipse) {  // Cutler, Kennefick, Poisson, Phys. Rev. D 50 (1994) 3816, section II
      const double width = ellipse->p - 6 + 2 * ellipse->e;
      out << formatted("; closed form: %.6f", 2 / pi * std::sqrt(ellipse->p / width) *
                                                  std::comp_ellint_1(std::sqrt(4 * ellipse->e / width)));
    }
    out << '\n';
  };
  return {observe, report, memory_of(seen)};
}

}  // namespace examples
