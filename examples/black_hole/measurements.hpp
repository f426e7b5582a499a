#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"

namespace examples {

/// Semi-latus rectum, in masses of the hole, and eccentricity.
struct Ellipse {
  double p, e;
};

inline double outer_horizon(const black_hole::Kerr<>& hole) {
  return hole.mass + std::sqrt(hole.mass * hole.mass - hole.spin * hole.spin);
}

/// Counts the orbits from apoapsis to apoapsis, and says what they are like. For an `ellipse` about a hole
/// without spin the turns between two apoapsides are known.
inline Measurement<4> apoapsides(const black_hole::Kerr<>& hole, const std::optional<Ellipse>& ellipse) {
  struct Seen {
    double energy = 0, momentum = 0, carter = 0;  // at first
    Largest closeness, distance, highest;
    Crossing<2> crossing;  // of -p_r, and phi
    double last_r = 0, last_r_momentum = 0, last_phi = 0, first = 0, latest = 0, open = 0, turn = 0;
    std::int64_t rows = 0, apoapsides = 0;
    bool over_a_pole = false;
    void visit_memory(CheckpointMemory& visit) {
      for (double* number :
           {&energy, &momentum, &carter, &last_r, &last_r_momentum, &last_phi, &first, &latest, &open, &turn})
        visit(*number);
      crossing.visit_memory(visit);
      highest.visit_memory(visit);
      closeness.visit_memory(visit);
      distance.visit_memory(visit);
      visit(rows);
      visit(apoapsides);
      visit(over_a_pole);
    }
  };
  using std::numbers::pi;
  const auto seen = std::make_shared<Seen>();
  const auto observe = [=](double t, const In<double, 4>& q, const In<double, 4>& p) {
    Seen& s = *seen;
    // The start may be one.
    const double outwards = s.rows == 0 && p[1] == 0 ? std::numeric_limits<double>::min() : p[1];
    if (s.crossing.see(t, {-outwards, q[3]})) {
      s.latest = s.crossing.place().values[1];
      if (s.apoapsides++ == 0) s.first = s.latest;
      s.open = std::max(s.open, s.crossing.uncertain(
                                    [](const auto& a, const auto& b) { return a.values[1] - b.values[1]; }));
    }
    if (s.rows == 0) {
      s.energy = -p[0];
      s.momentum = p[3];
      s.carter = hole.carter(q, p);
    } else {
      s.turn = std::max(s.turn, std::abs(q[3] - s.last_phi));
    }
    ++s.rows;
    s.last_r = q[1];
    s.last_r_momentum = p[1];
    s.last_phi = q[3];
    s.closeness.see(-q[1]);
    s.distance.see(q[1]);
    // Over a pole theta goes on, and phi stays where it was.
    if (q[2] <= 0 || q[2] >= pi) s.over_a_pole = true;
    s.highest.see(std::abs(q[2] - pi / 2) * 180 / pi);
  };
  const auto report = [=](std::ostream& out, const Run&) {
    const Seen& s = *seen;
    const double nearest = -s.closeness.value(), farthest = s.distance.value();
    auto turned = hole;  // seen so that the orbit has a positive L
    if (s.momentum < 0) turned.spin = -hole.spin;
    out << formatted("E = %.9g, L = %.9g; ", s.energy, s.momentum) << "r from "
        << with_uncertainty(nearest, s.closeness.uncertain()) << " to "
        << with_uncertainty(farthest, s.distance.uncertain()) << ", "
        << (s.over_a_pole || s.highest.uncertain() < 0.005
                ? formatted("%.2f", s.over_a_pole ? 90 : s.highest.value())
                : with_uncertainty(s.highest.value(), s.highest.uncertain()))
        << " degrees off the equator\n"
        << formatted("innermost stable circular orbit%s: r = %.6g\n",
                     s.momentum * hole.spin < 0 ? " against the spin" : "", turned.innermost_stable_orbit());
    const std::string what = "turns from apoapsis to apoapsis";
    if (nearest <= outer_horizon(hole))
      return print_none(out, what, "the body has fallen through the horizon");
    if (s.over_a_pole)
      return print_none(
          out, what, "the orbit goes over a pole, where phi does not count the half turns; give another --l");
    if (farthest - nearest < 1e-6 * farthest)
      return print_none(
          out, what,
          "r stays the same: a circle, or too short a run; give another --e, --r or --l, or more --time");
    const std::string coarse = too_coarse(s.turn);
    if (!coarse.empty()) return print_none(out, what, coarse);
    const std::int64_t orbits = s.apoapsides - 1;
    if (orbits < 1) return print_none(out, what, "the run has no whole orbit; give more --time");
    const double angle = 2 * pi * static_cast<double>(orbits);
    out << what << ": " << with_uncertainty((s.latest - s.first) / angle, 2 * s.open / angle) << ", mean of "
        << orbits << (orbits == 1 ? " orbit" : " orbits");
    if (ellipse) {  // Cutler, Kennefick, Poisson, Phys. Rev. D 50 (1994) 3816, section II
      const double width = ellipse->p - 6 + 2 * ellipse->e;
      out << formatted("; closed form: %.6f", 2 / pi * std::sqrt(ellipse->p / width) *
                                                  std::comp_ellint_1(std::sqrt(4 * ellipse->e / width)));
    }
    out << '\n';
  };
  // Inwards, and no turning point ahead, where the radial potential of Carter (1968), eq. (62), is zero.
  const auto ending = [=]() -> std::string {
    const Seen& s = *seen;
    const double a = hole.spin, horizon = outer_horizon(hole);
    const double rest = s.carter + std::pow(s.momentum - a * s.energy, 2);
    for (int i = 1; i <= 1000; ++i) {
      const double r = horizon + (s.last_r - horizon) * i / 1000;
      const double k = (r * r + a * a) * s.energy - a * s.momentum;
      if (!(k * k > (r * r - 2 * hole.mass * r + a * a) * (r * r + rest))) return "";
    }
    if (!(s.last_r_momentum < 0)) return "";
    return formatted(
        "the body falls into the hole, from r = %.4g on nothing turns it back before the horizon, r = %.4g; "
        "give another --r or --l, or a --time that ends before",
        s.last_r, horizon);
  };
  return {observe, report, memory_of(seen), {}, ending};
}

}  // namespace examples
