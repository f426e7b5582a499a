// Every hard case with every kind of method. Ours has one setting; a rival tries several of about 1.1 times
// its gradient calls on a twentieth of the time, the three best go all the way, and the best of these counts.

#include "battery.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iostream>
#include <limits>

#include "cases.hpp"

namespace stability {

namespace {

std::string text(const char* format, auto... values) {
  char line[512];
  std::snprintf(line, sizeof line, format, values...);
  return line;
}

/// One run: the whole time, in steps of about dt. It ends early where the energy is beyond all help or the
/// budget of gradient calls is spent (0: none).
template <class H, class S>
Outcome attempt(const Case<H>& hard, S stepper, double dt, double t_end, std::int64_t budget,
                std::string setting) {
  using Scalar = typename H::Scalar;
  typename S::State z(hard.start);
  const auto steps = static_cast<std::int64_t>(std::ceil(t_end / dt - 1e-9));
  const std::int64_t between = std::max<std::int64_t>(1, steps / 20'000);
  Invariants<Scalar, H::Dof> errors;
  errors.add("energy", [&](const auto& q, const auto& p) { return energy_of(hard.hamiltonian, q, p); });
  if (hard.invariant) errors.add("invariant", hard.invariant);
  bool spent = false;
  std::int64_t calls = 0;
  const auto stop = [&](const Scalar&, const auto&, const StepReport& report) {
    calls += report.gradients;
    spent = budget > 0 && calls > budget;
    return !spent && static_cast<double>(errors["energy"].worst) < 1e3;  // false for NaN as well
  };
  Outcome result{.setting = std::move(setting)};
  const auto report = integrate(stepper, z,
                                {.dt = static_cast<Scalar>(t_end / static_cast<double>(steps)),
                                 .steps = steps,
                                 .on_failure = OnFailure::stop},
                                every(between, errors), stop);
  result.t = report.t;
  result.energy = static_cast<double>(errors["energy"].worst);
  if (hard.invariant) result.invariant = static_cast<double>(errors["invariant"].worst);
  result.gradients = report.gradients;
  result.seconds = report.seconds;
  // The quadratic invariant may be off by as much as the energy, though symplectic methods keep it much
  // better.
  result.survived = report.status == Status::success && result.energy <= hard.energy_error &&
                    result.invariant <= hard.energy_error;
  return result;
}

/// The better one: who survives before who does not, then who came further, then the smaller energy error.
bool better(const Outcome& x, const Outcome& y) {
  if (x.survived != y.survived) return x.survived;
  if (!x.survived && std::abs(x.t - y.t) > 1e-3 * std::abs(y.t)) return x.t > y.t;
  return x.energy < y.energy;
}

/// Runs with one setting each, to the given time.
using Settings = std::vector<std::function<Outcome(double)>>;

Outcome best_of(const Settings& settings, double t_end) {
  std::vector<std::pair<Outcome, std::size_t>> tried;
  for (std::size_t i = 0; i < settings.size(); ++i) tried.emplace_back(settings[i](t_end / 20), i);
  std::sort(tried.begin(), tried.end(),
            [](const auto& x, const auto& y) { return better(x.first, y.first); });
  tried.resize(std::min<std::size_t>(tried.size(), 3));
  std::vector<Outcome> finalists;
  for (const auto& entry : tried) finalists.push_back(settings[entry.second](t_end));
  return *std::min_element(finalists.begin(), finalists.end(), better);
}

template <class H>
Line run_case(const Case<H>& hard, double part) {
  using Scalar = typename H::Scalar;
  const double t_end = hard.t_test + part * (hard.t_long - hard.t_test);
  Line line{.name = hard.name,
            .why = hard.why,
            .dt = hard.dt,
            .t_end = t_end,
            .energy_bound = hard.energy_error,
            .invariant_bound = hard.invariant_error,
            .outcomes = {}};
  const auto ours = schemes::low_defect6_s13<Scalar>();
  const std::string ours_setting = text("%s, %g", ours.name.c_str(), hard.dt);
  line.outcomes.push_back(
      attempt(hard, Semiexplicit(hard.hamiltonian, ours), hard.dt, t_end, 0, ours_setting));
  line.outcomes.push_back(
      attempt(hard, Semiexplicit(hard.hamiltonian, ours, Robust{}), hard.dt, t_end, 0, ours_setting));
  const double calls_per_time = 1.1 * static_cast<double>(line.outcomes.back().gradients) / t_end;

  Settings settings;
  for (const char* name :
       {"blanes_moan4", "low_defect4_s11", "blanes_moan6", "low_defect6_s13", "sofroniou_spaletta10"}) {
    const auto scheme = schemes::by_name<Scalar>(name);
    const double dt = static_cast<double>(scheme.kicks()) / calls_per_time;
    settings.push_back([=, &hard](double t) {
      return attempt(hard, MidpointProjection(hard.hamiltonian, scheme), dt, t, 0,
                     text("%s, %.3g", name, dt));
    });
  }
  line.outcomes.push_back(best_of(settings, t_end));

  settings.clear();
  for (const char* name : {"suzuki4", "kahan_li6", "kahan_li8"})
    for (const double turn : {0.003, 0.02, 0.1, 0.5}) {  // ω dt
      const auto scheme = schemes::by_name<Scalar>(name);
      // Three calls a Strang step: the last of one is the first of the next.
      const double dt = 3 * static_cast<double>(scheme.b.size()) / calls_per_time, omega = turn / dt;
      settings.push_back([=, &hard](double t) {
        return attempt(hard, Tao(hard.hamiltonian, scheme, static_cast<Scalar>(omega)), dt, t, 0,
                       text("%s, %.3g, ω = %.3g", name, dt, omega));
      });
    }
  line.outcomes.push_back(best_of(settings, t_end));

  settings.clear();
  for (const int stages : {1, 2, 4, 6, 8})
    for (const double iterations : {2.0, 3.0, 4.5, 6.0, 8.0, 11.0, 15.0, 20.0}) {  // those a step may take
      const double dt = stages * iterations / calls_per_time;
      settings.push_back([=, &hard](double t) {
        const auto budget = static_cast<std::int64_t>(1.05 * calls_per_time * t);
        return attempt(hard, GaussLegendre(hard.hamiltonian, {.stages = stages}), dt, t, budget,
                       text("%d stages, %.3g", stages, dt));
      });
    }
  line.outcomes.push_back(best_of(settings, t_end));
  return line;
}

}  // namespace

const std::vector<std::string>& method_names() {
  static const std::vector<std::string> names{"semiexplicit, simplified Newton", "semiexplicit, Robust",
                                              "midpoint projection", "Tao", "Gauss-Legendre"};
  return names;
}

std::vector<Line> run_battery(double part, const std::string& only) {
  std::vector<Line> lines;
  for_each_case([&](const auto& hard) {
    if (!only.empty() && hard.name.find(only) == std::string::npos) return;
    lines.push_back(run_case(hard, part));
    const Line& line = lines.back();
    std::cout << line.name << " (t = " << line.t_end << ", energy within " << line.energy_bound << ")\n";
    for (std::size_t i = 0; i < line.outcomes.size(); ++i) {
      const Outcome& o = line.outcomes[i];
      std::cout << text("  %-32s %-9s t = %-8.4g energy %.1e  invariant %.1e  %.3g calls  %.2f s  %s\n",
                        method_names()[i].c_str(), o.survived ? "survives" : "LOST", o.t, o.energy,
                        o.invariant, static_cast<double>(o.gradients), o.seconds, o.setting.c_str());
    }
    std::cout << std::flush;
  });
  return lines;
}

}  // namespace stability
