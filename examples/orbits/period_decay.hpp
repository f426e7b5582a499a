#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/scene_choice.hpp"
#include "measurements.hpp"

namespace examples {

/// The work of 2.5pn from one apoapsis to another, where it hardly works.
struct WorkBetweenApoapsides {
  Books<double, 3> books;
  Crossing<2> crossing{};  // of -r p_r, and the work
  int apoapsides = 0;
  double first = 0, last = 0, open = 0;

  void see(double t, const In<double, 3>& q, const In<double, 3>& p) {
    books(t, PhasePoint<double, 3>(q, p));
    if (!crossing.see(t, {-q.dot(p), books.work()})) return;
    last = crossing.place().values[1];
    if (apoapsides++ == 0) first = last;
    open = std::max(
        open, crossing.uncertain([](const auto& a, const auto& b) { return a.values[1] - b.values[1]; }));
  }
  double an_orbit() const { return (last - first) / (apoapsides - 1); }
  /// What the steps leave open of that, at both ends.
  double an_orbit_uncertain() const { return 2 * open / (apoapsides - 1); }
  void visit_memory(CheckpointMemory& visit) {
    books.visit_memory(visit);
    crossing.visit_memory(visit);
    visit(apoapsides);
    for (double* number : {&first, &last, &open}) visit(*number);
  }
};

/// How fast the period of a binary, from apoapsis to apoapsis, shrinks, by that work: the energy itself
/// changes by less than its digits. With 1PN the mean motion is n = (-2E)^(3/2)/GM (1 - (ν - 15) E/(4c²)); T.
/// Damour, N. Deruelle, Ann. Inst. H. Poincaré 43 (1985) 107. Beside it Peters (1964).
inline Measurement<3> period_decay(const Choice& c) {
  struct Seen {
    WorkBetweenApoapsides all, every_other;  // of the steps
    double energy = 0;                       // at the start
    bool begun = false, odd = false;
    double turn = 0;  // the largest from step to step
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    void visit_memory(CheckpointMemory& visit) {
      all.visit_memory(visit);
      every_other.visit_memory(visit);
      visit(energy);
      visit(begun);
      visit(odd);
      visit(turn);
      visit(last);
    }
  };
  const double gm = c["gm"], e = c["e"], a = c["a"], light = c["c"], nu = c["nu"];
  const auto light_of = [&](const char* effect) { return c.on(effect) ? light : INFINITY; };
  const Scene scene(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                    orbits::PostNewtonian1<double, 3>{.gm = gm, .c = light_of("1pn"), .nu = nu},
                    orbits::PostNewtonian2<double, 3>{.gm = gm, .c = light_of("2pn"), .nu = nu},
                    orbits::RadiationReaction<double, 3>{gm, light, nu});
  const auto seen = std::make_shared<Seen>(Seen{{Books<double, 3>(scene)}, {Books<double, 3>(scene)}});
  const double first = (nu - 15) / (4 * light * light), relativity = c.on("1pn") ? first : 0,
               next = c.on("1pn") || c.on("2pn") ? first : 0;
  return {
      [=](double t, const In<double, 3>& q, const In<double, 3>& p) {
        if (!std::exchange(seen->begun, true)) seen->energy = scene.energy(q, p);
        seen->all.see(t, q, p);
        if (seen->odd = !seen->odd; seen->odd) seen->every_other.see(t, q, p);
        seen->turn = std::max(seen->turn, angle_between(seen->last, q));
        seen->last = q;
      },
      memory_of(seen),
      [=](const Run&) -> std::vector<Figure> {
        const std::string name = "period derivative", coarse = too_coarse(seen->turn);
        if (!c.only_of({"kinetic", "attraction", "1pn", "2pn", "2.5pn"}))
          return {not_measured(name, "that is for kinetic, attraction, 1pn, 2pn and 2.5pn only")};
        if (std::min(seen->all.apoapsides, seen->every_other.apoapsides) < 3)
          return {not_measured(name,
                               "the run has no two whole orbits from apoapsis to apoapsis; give more --time, "
                               "or a larger --e, as a circle that shrinks has none")};
        if (!coarse.empty()) return {not_measured(name, coarse)};
        // Of the middle of these orbits, as their mean period is.
        const double energy = seen->energy + (seen->all.first + seen->all.last) / 2,
                     growth = 1.5 / energy - relativity / (1 - relativity * energy);  // of ln n with E
        // That relation is of first order; measured, the second, 2PN's own, is some four squares of the
        // first. What is lost of the energy meanwhile leaves open by its square which mean that is.
        const double value = -growth * seen->all.an_orbit(),
                     lost = (seen->all.last - seen->all.first) / energy,
                     by_steps = std::abs(seen->every_other.an_orbit() - seen->all.an_orbit()) +
                                seen->all.an_orbit_uncertain(),
                     uncertain = std::abs(growth) * by_steps +
                                 (10 * std::pow(next * energy, 2) + lost * lost) * std::abs(value);
        if (!(uncertain <= 0.1 * std::abs(value)))
          return {not_measured(name,
                               formatted("steps leave %.2g ± %.1g; give a smaller --dt", value, uncertain))};
        const double f = (1 + 73.0 / 24 * e * e + 37.0 / 96 * std::pow(e, 4)) / std::pow(1 - e * e, 3.5);
        return {compared(name, value, uncertain,
                         "from " + std::to_string(seen->all.apoapsides - 1) + " orbits; Peters",
                         -192 * std::numbers::pi / 5 * nu * f * std::pow(gm / a, 2.5) / std::pow(light, 5))};
      }};
}

/// The advance of the periastron, and the loss where it is on.
inline Measurement<3> binary_pulsar(const Choice& c) {
  const Measurement<3> turn = node(c);
  if (!c.on("2.5pn")) return turn;
  const Measurement<3> decay = period_decay(c);
  return {[=](double t, const In<double, 3>& q, const In<double, 3>& p) {
            turn.observe(t, q, p);
            decay.observe(t, q, p);
          },
          [=](CheckpointMemory& visit) {
            turn.memory(visit);
            decay.memory(visit);
          },
          [=](const Run& run) {
            std::vector<Figure> list = turn.figures(run);
            for (const Figure& figure : decay.figures(run)) list.push_back(figure);
            return list;
          },
          [=](std::ostream& out, const Run& run) {
            turn.report(out, run);
            decay.tell(out, run);
          }};
}

}  // namespace examples
