#pragma once

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>

#include <Eigen/Geometry>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"
#include "measurements.hpp"

namespace examples {

/// The work of 2.5pn from one apoapsis to another, where it hardly works; each by a straight line between the
/// steps about it.
struct WorkBetweenApoapsides {
  Books<double, 3> books;
  bool begun = false;
  int apoapsides = 0;
  double last = 0, last_t = 0, last_work = 0, t0 = 0, t1 = 0, work0 = 0, work1 = 0;

  void see(double t, const In<double, 3>& q, const In<double, 3>& p) {
    books(t, PhasePoint<double, 3>(q, p));
    const double now = q.dot(p), work = books.work();
    if (begun && last > 0 && now <= 0) {
      const double w = last / (last - now);
      t1 = last_t + w * (t - last_t);
      work1 = last_work + w * (work - last_work);
      if (apoapsides++ == 0) t0 = t1, work0 = work1;
    }
    begun = true;
    last = now, last_t = t, last_work = work;
  }
  double per_time() const { return (work1 - work0) / (t1 - t0); }
  void visit_memory(CheckpointMemory& visit) {
    books.visit_memory(visit);
    visit(begun);
    visit(apoapsides);
    for (double* number : {&last, &last_t, &last_work, &t0, &t1, &work0, &work1}) visit(*number);
  }
};

/// How fast the period of a binary shrinks, by that work: the energy itself changes by less than its digits.
/// dP/dt = -3/2 (P/E) dE/dt. Beside it Peters (1964).
inline Measurement<3> period_decay(const Choice& c) {
  using Loss = orbits::RadiationReaction<double, 3>;
  struct Seen {
    WorkBetweenApoapsides all, every_other;  // of the steps
    bool odd = false;
    double turn = 0;  // the largest from step to step
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    void visit_memory(CheckpointMemory& visit) {
      all.visit_memory(visit);
      every_other.visit_memory(visit);
      visit(odd);
      visit(turn);
      visit(last);
    }
  };
  const double gm = c["gm"], e = c["e"], a = c["a"], light = c["c"], nu = c["nu"];
  const Scene scene(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                    Loss{gm, light, nu});
  const auto seen = std::make_shared<Seen>(Seen{{Books<double, 3>(scene)}, {Books<double, 3>(scene)}});
  return {
      [=](double t, const In<double, 3>& q, const In<double, 3>& p) {
        seen->all.see(t, q, p);
        if (seen->odd = !seen->odd; seen->odd) seen->every_other.see(t, q, p);
        seen->turn = std::max(seen->turn, angle_between(seen->last, q));
        seen->last = q;
      },
      memory_of(seen),
      {},
      [=](std::ostream& out, const Run& run) {
        if (!c.only_of({"kinetic", "attraction", "1pn", "2pn", "2.5pn"}))
          return print_none(out, "period derivative",
                            "that is for kinetic, attraction, 1pn, 2pn and 2.5pn only");
        if (seen->all.apoapsides < 3)
          return print_none(out, "period derivative", "the run has no two whole orbits; give more --time");
        if (const std::string coarse = too_coarse(seen->turn); !coarse.empty())
          return print_none(out, "period derivative", coarse);
        const double period = 2 * std::numbers::pi * std::sqrt(a * a * a / gm), energy = -gm / (2 * a);
        const auto shrinks = [&](const WorkBetweenApoapsides& by) {
          return -1.5 * period * by.per_time() / energy;
        };
        // With an error of the energy comes one of the loss that is a few times as large.
        const double value = shrinks(seen->all),
                     uncertain = std::abs(shrinks(seen->every_other) - value) +
                                 10 * run.quantities.front().worst * std::abs(value);
        if (!(uncertain <= 0.1 * std::abs(value)))
          return print_none(out, "period derivative",
                            formatted("steps leave %.2g ± %.1g; give a smaller --dt", value, uncertain));
        const double f = (1 + 73.0 / 24 * e * e + 37.0 / 96 * std::pow(e, 4)) / std::pow(1 - e * e, 3.5);
        const double peters =
            -192 * std::numbers::pi / 5 * nu * f * std::pow(gm / a, 2.5) / std::pow(light, 5);
        const auto place = [](double x) { return std::floor(std::log10(std::max(std::abs(x), 1e-300))); };
        const int decimals = static_cast<int>(std::clamp(place(value) - place(uncertain), 0.0, 4.0));
        out << "period derivative: "
            << formatted("%.*e ± %.1g from %d orbits", decimals, value, uncertain, seen->all.apoapsides - 1)
            << formatted("; Peters: %.4e\n", peters);
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
          turn.figures,
          [=](std::ostream& out, const Run& run) {
            turn.report(out, run);
            decay.report(out, run);
          }};
}

}  // namespace examples
