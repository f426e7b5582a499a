#pragma once

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/time.hpp>

#include "gauss_methods.hpp"
#include "own_methods.hpp"

namespace work_precision {

/// A run by steps that follow the motion, which ends at `end` itself; `ds` is the step in their parameter.
template <class S>
Outcome run_along(S stepper, typename S::State state, double end, double ds, Watch* watch) {
  stepper.begin(state, 0.0);
  return run_while(
      std::move(state), watch,
      [&](Outcome& so_far) {
        if (watch == nullptr || !watch->is_late(so_far.gradients)) return !stepper.reached(end);
        so_far.status = "too slow";
        return false;
      },
      [&](auto& z) { return stepper.step_until(z, ds, end); },
      [&](const Outcome&) { return stepper.time(); });
}

/// The parameter is the time of the first step.
template <class S, class Monitor, class H>
Line line_along(Method method, S inner, const Monitor& monitor, const Problem<H>& problem, double end,
                double calls, bool in_short) {
  Line line{.method = std::move(method), .first = problem.step_per_call * calls, .in_short = in_short};
  const double scale = monitor.value(problem.start.q(), problem.start.p());
  line.run = [stepper = ReversibleSteps(std::move(inner), monitor), start = problem.start, end, scale](
                 double dt, Watch* watch) { return run_along(stepper, start, end, dt / scale, watch); };
  return line;
}

/// ReversibleSteps around some of the projected schemes and Gauss's methods, by the two monitors that serve
/// any Hamiltonian; their gradient calls count.
template <class H>
void add_reversible(std::vector<Line>& lines, const Problem<H>& problem, double end) {
  const H& h = problem.hamiltonian;
  const double size = problem.size();
  const auto add = [&](const std::string& by, const auto& monitor) {
    for (const char* name : {"low_defect4_s11", "low_defect6_s13", "low_defect8_s20", "blanes_moan6"}) {
      const Scheme<double> scheme = schemes::by_name(name);
      for (const double tau : {1e-16, 1e-13}) {
        const StoppingRule rule = StoppingRule::product(tau);
        lines.push_back(line_along({family::reversible, name, by + ", " + text_of(rule), scheme.order},
                                   Semiexplicit(h, scheme, SimplifiedNewton{.stop = rule}), monitor, problem,
                                   end, static_cast<double>(scheme.kicks()),
                                   tau == 1e-16 && name == std::string("low_defect6_s13")));
      }
    }
    for (const int stages : {3, 4, 6, 8})
      for (const double tolerance : {0.0, 1e-10, 1e-8, 1e-6, 1e-4}) {
        const GaussLegendreOptions options{.stages = stages, .tolerance = tolerance * size};
        const auto line = [&](auto gauss) {
          lines.push_back(line_along(
              {family::gauss_reversible, std::to_string(stages) + " stages",
               by + (tolerance > 0 ? ", tolerance " + number(tolerance) : ", to rounding"), 2 * stages},
              std::move(gauss), monitor, problem, end, 3.0 * stages, tolerance == 0 && stages == 4));
        };
        if constexpr (HasPackGradient<H>)
          line(GaussLegendreLanes(h, options));
        else
          line(GaussLegendre(h, options));
      }
  };
  double length = 0, momentum = 0;
  for (const double x : problem.start.q()) length = std::max(length, std::abs(x));
  for (const double x : problem.start.p()) momentum = std::max(momentum, std::abs(x));
  if (length == 0) length = momentum;
  if (momentum == 0) momentum = length;
  add("by the field", monitors::FieldSize(h));
  add("by its change",
      monitors::TimeScale(h, {.length = length, .momentum = momentum, .longest = end / 100}));
}

}  // namespace work_precision
