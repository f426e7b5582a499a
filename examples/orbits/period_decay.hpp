#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"
#include "measurements.hpp"

namespace examples {

/// How fast the period of a binary shrinks, from the work of 2.5pn from one apoapsis to another, where it
/// hardly works: the energy itself changes by less than its digits. dP/dt = -3/2 (P/E) dE/dt. Beside it
/// Peters (1964).
inline Measurement<3> period_decay(const Choice& c) {
  using Loss = orbits::RadiationReaction<double, 3>;
  struct Seen {
    Books<double, 3> books;
    bool begun = false;
    int orbits = 0;
    double last = 0, t0 = 0, t1 = 0, work0 = 0, work1 = 0;
    void visit_memory(CheckpointMemory& visit) {
      books.visit_memory(visit);
      visit(begun);
      visit(orbits);
      for (double* number : {&last, &t0, &t1, &work0, &work1}) visit(*number);
    }
  };
  const double gm = c["gm"], e = c["e"], a = c["a"], light = c["c"], nu = c["nu"];
  const Scene scene(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                    Loss{gm, light, nu});
  const auto seen = std::make_shared<Seen>(Seen{Books<double, 3>(scene)});
  return {[=](double t, const In<double, 3>& q, const In<double, 3>& p) {
            seen->books(t, PhasePoint<double, 3>(q, p));
            const double now = q.dot(p);
            if (seen->begun && seen->last > 0 && now <= 0) {
              if (seen->orbits++ == 0) {
                seen->t0 = t;
                seen->work0 = seen->books.work();
              }
              seen->t1 = t;
              seen->work1 = seen->books.work();
            }
            seen->begun = true;
            seen->last = now;
          },
          [=](std::ostream& out, const Run&) {
            if (!c.only_of({"kinetic", "attraction", "1pn", "2pn", "2.5pn"}))
              return print_none(out, "period derivative",
                                "that is for kinetic, attraction, 1pn, 2pn and 2.5pn only");
            if (seen->orbits < 3)
              return print_none(out, "period derivative",
                                "the run has no two whole orbits; give more --time");
            const double period = 2 * std::numbers::pi * std::sqrt(a * a * a / gm), energy = -gm / (2 * a);
            const double loss = (seen->work1 - seen->work0) / (seen->t1 - seen->t0);
            const double f = (1 + 73.0 / 24 * e * e + 37.0 / 96 * std::pow(e, 4)) / std::pow(1 - e * e, 3.5);
            const double peters =
                -192 * std::numbers::pi / 5 * nu * f * std::pow(gm / a, 2.5) / std::pow(light, 5);
            out << "period derivative: "
                << formatted("%.4e from %d orbits", -1.5 * period * loss / energy, seen->orbits - 1)
                << formatted("; Peters: %.4e\n", peters);
          },
          memory_of(seen)};
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
          [=](std::ostream& out, const Run& run) {
            turn.report(out, run);
            decay.report(out, run);
          },
          [=](CheckpointMemory& visit) {
            turn.memory(visit);
            decay.memory(visit);
          },
          turn.figures};
}

}  // namespace examples
