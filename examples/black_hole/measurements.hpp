#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"
#include "barrier.hpp"

namespace examples {

/// Semi-latus rectum, in masses of the hole, and eccentricity.
struct Ellipse {
  double p, e;
};

/// Counts the orbits from apoapsis to apoapsis, and says what they are like. For an `ellipse` about a hole
/// without spin the turns between two apoapsides are known.
inline Measurement<4> apoapsides(const black_hole::Kerr<>& hole, const std::optional<Ellipse>& ellipse) {
  struct Seen {
    double start = 0, energy = 0, momentum = 0, carter = 0;  // r and more at first
    Largest closeness, distance, highest;
    Crossing<2> crossing;  // of -p_r, and phi
    double last_r = 0, last_r_momentum = 0, last_theta = 0, last_phi = 0, first = 0, latest = 0, open = 0,
           turn = 0, tilt = 0;  // the largest of a step, in phi and in theta
    std::int64_t rows = 0, apoapsides = 0;
    bool over_a_pole = false;
    void visit_memory(CheckpointMemory& visit) {
      for (double* number : {&start, &energy, &momentum, &carter, &last_r, &last_r_momentum, &last_theta,
                             &last_phi, &first, &latest, &open, &turn, &tilt})
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
  const std::string another = ellipse ? "a larger --p" : "another --r or --l";
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
      s.start = q[1];
      s.energy = -p[0];
      s.momentum = p[3];
      s.carter = hole.carter(q, p);
    } else {
      s.turn = std::max(s.turn, std::abs(q[3] - s.last_phi));
      s.tilt = std::max(s.tilt, std::abs(q[2] - s.last_theta));
    }
    ++s.rows;
    s.last_r = q[1];
    s.last_r_momentum = p[1];
    s.last_theta = q[2];
    s.last_phi = q[3];
    s.closeness.see(-q[1]);
    s.distance.see(q[1]);
    // Over a pole theta goes on, and phi stays where it was.
    if (q[2] <= 0 || q[2] >= pi) s.over_a_pole = true;
    s.highest.see(std::abs(q[2] - pi / 2) * 180 / pi);
  };
  const auto heading = [=] {
    const Seen& s = *seen;
    auto turned = hole;  // seen so that the orbit has a positive L
    if (s.momentum < 0) turned.spin = -hole.spin;
    return formatted("E = %.9g, L = %.9g; ", s.energy, s.momentum) +
           formatted("innermost stable circular orbit%s: r = %.6g\n",
                     s.momentum * hole.spin < 0 ? " against the spin" : "", turned.innermost_stable_orbit());
  };
  const auto figures = [=](const Run&) {
    const Seen& s = *seen;
    const double nearest = -s.closeness.value(), farthest = s.distance.value();
    const double rounding = 90 * std::numeric_limits<double>::epsilon();  // of theta
    // It goes over a pole where L is zero, and else past it by less than a step tells.
    const double highest = s.over_a_pole ? 90 : s.highest.value(),
                 open = s.over_a_pole    ? (s.momentum == 0 ? 0 : s.tilt * 180 / pi)
                        : highest < 1e-9 ? highest + s.highest.uncertain()  // in the equator
                                         : s.highest.uncertain() + rounding;
    std::vector<Figure> list{{"nearest r", nearest, s.closeness.uncertain()},
                             {"farthest r", farthest, s.distance.uncertain()},
                             {"degrees off the equator", highest, open}};
    // A companion may be off by as much then.
    const std::string jumps = nearest <= outer_horizon(hole)
                                  ? "a step jumps through the horizon; give a smaller --dt, or " + another
                                  : "",
                      coarse = jumps.empty() ? too_coarse(std::max(s.turn, s.tilt), 2 * pi) : jumps;
    for (Figure& figure : list) figure.missing = coarse;
    // Steps of half a turn see the same of its swing over and over.
    if (coarse.empty() && highest >= 1e-9) list[2].missing = too_coarse(std::max(s.turn, s.tilt), pi / 2);
    // The force of L²/sin²θ beside a pole is then that of chance, of the companion's steps as well.
    if (s.momentum != 0 && 4 * std::abs(s.momentum) < s.tilt * std::sqrt(std::max(0.0, s.carter)))
      for (std::size_t i = 0; i < 2; ++i)
        list[i].missing =
            "the orbit passes the poles by less than a step; give a smaller --dt, or another --l";
    Figure turns{.name = "turns from apoapsis to apoapsis"};
    turns.missing =
        !jumps.empty() ? jumps
        : s.over_a_pole
            ? "the orbit goes over a pole, where phi does not count the half turns; give another --l"
        : farthest - nearest < 1e-6 * farthest
            ? "r stays the same: a circle, or too short a run; give another " +
                  std::string(ellipse ? "--e" : "--r or --l") + ", or more --time"
            : too_coarse(s.turn);
    const std::int64_t orbits = s.apoapsides - 1;
    if (turns.missing.empty() && orbits < 1)
      turns.missing = s.energy >= 1 ? "the body is not bound, E >= 1; give another --r or --l"
                                    : "the run has no whole orbit; give more --time";
    const double angle = 2 * pi * static_cast<double>(orbits);
    turns.value = (s.latest - s.first) / angle;
    turns.uncertain = 2 * s.open / angle;
    turns.beside = "mean of " + counted(orbits, "orbit");
    const Barrier barrier(hole, s.start, s.energy, s.momentum, s.carter);
    turns.uncertain += barrier.by_rounding_in_turns();
    list[0].uncertain += barrier.by_rounding_in_nearest();
    if (barrier.rounding_decides()) {
      const std::string why =
          "rounding decides how often it turns so near to the separatrix; give " + another;
      for (Figure* figure : {&list[0], &turns})
        if (figure->missing.empty()) figure->missing = why;
    }
    if (ellipse) {  // Cutler, Kennefick, Poisson, Phys. Rev. D 50 (1994) 3816, section II
      const double width = ellipse->p - 6 + 2 * ellipse->e;
      turns.beside += "; closed form";
      turns.expected =
          2 / pi * std::sqrt(ellipse->p / width) * std::comp_ellint_1(std::sqrt(4 * ellipse->e / width));
    }
    list.push_back(turns);
    return list;
  };
  // Inwards, and no turning point on the way from where it was farthest, where the radial potential of Carter
  // (1968), eq. (62), is zero: one that is behind it was jumped over by a step. A barrier may be narrow.
  const auto ending = [=]() -> std::string {
    const Seen& s = *seen;
    if (!(s.last_r_momentum < 0) || !(s.last_r > 0)) return "";
    const double horizon = outer_horizon(hole), farthest = s.distance.value();
    const Barrier barrier(hole, s.start, s.energy, s.momentum, s.carter);
    if (barrier.turns_back(farthest) && !barrier.rounding_decides()) return "";
    for (int i = 1; i < 10'000; ++i) {
      const double r = 1 / (1 / horizon + (1 / farthest - 1 / horizon) * i / 10'000);
      if (!(barrier.radial(r) > 0)) return "";
    }
    return formatted(
        "the body falls into the hole, from r = %.4g on nothing turns it back before the horizon, r = %.4g; "
        "give %s, a --time that ends before, or a smaller --dt, by which it goes on for longer%s",
        s.last_r, horizon, another.c_str(),
        barrier.rounding_decides() ? "; rounding decides so near to the separatrix" : "");
  };
  return {observe, memory_of(seen), figures, {}, heading, ending};
}

}  // namespace examples
