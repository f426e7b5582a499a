#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "problems.hpp"
#include "task.hpp"

// The clock of every run starts behind the construction of the stepper, which checks its scheme: that is no
// part of a step.

namespace work_precision {

inline std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

inline std::string status_name(Status status) {
  switch (status) {
    case Status::success:
    case Status::rounding_limited:
      return "ok";
    case Status::no_convergence:
      return "no convergence";
    case Status::not_finite:
      return "not finite";
    default:
      return "failed";
  }
}

/// The point that a state stands for, as 2d numbers.
template <int Dof>
const double* numbers(const PhasePoint<double, Dof>& z, std::vector<double>&) {
  return z.vector().data();
}

/// Of Tao's copies the mean, which is more accurate than either.
template <int Dof>
const double* numbers(const ExtendedPoint<double, Dof>& zeta, std::vector<double>& mean) {
  mean.resize(static_cast<std::size_t>(2 * zeta.dof()));
  for (Eigen::Index i = 0; i < 2 * zeta.dof(); ++i)
    mean[static_cast<std::size_t>(i)] = (zeta.a.vector()[i] + zeta.b.vector()[i]) / 2;
  return mean.data();
}

/// The loop of the library's own methods while more(outcome), which may say why not: step(state) reports, and
/// time(outcome) is where it has come to.
template <class State, class More, class Step, class Time>
Outcome run_while(State state, Watch* watch, const More& more, const Step& step, const Time& time) {
  Outcome outcome;
  std::vector<double> buffer;
  const double begin = cpu_seconds();
  while (more(outcome)) {
    const StepReport report = step(state);
    outcome.gradients += report.gradients;
    if (!report.ok()) {
      outcome.status = status_name(report.status);
      break;
    }
    ++outcome.steps;
    if (watch == nullptr) continue;
    if (const double t = time(outcome); watch->due(t) && !watch->see(t, numbers(state, buffer))) {
      outcome.status = "energy lost";
      break;
    }
  }
  outcome.seconds = cpu_seconds() - begin;
  outcome.t = time(outcome);
  return outcome;
}

/// The whole number of steps to `end` that comes nearest from above, and a run with so many.
template <class S>
Outcome run_steps(S stepper, typename S::State state, double end, double dt_wanted, Watch* watch) {
  const auto steps = static_cast<std::int64_t>(std::ceil(end / dt_wanted * (1 - 1e-12)));
  const double dt = end / static_cast<double>(steps);
  return run_while(
      std::move(state), watch, [&](const Outcome& so_far) { return so_far.steps < steps; },
      [&](auto& z) { return stepper.step(z, dt); },
      [&](const Outcome& so_far) { return static_cast<double>(so_far.steps) * dt; });
}

/// `calls` gradient calls a step at the coarsest setting.
template <class S, class H>
Line line_of_steps(Method method, S stepper, const Problem<H>& problem, double end, double calls,
                   bool in_short) {
  Line line{.method = std::move(method), .first = problem.step_per_call * calls, .in_short = in_short};
  line.run = [stepper = std::move(stepper), start = typename S::State(problem.start), end](
                 double dt, Watch* watch) { return run_steps(stepper, start, end, dt, watch); };
  return line;
}

inline bool is_low_defect(const std::string& scheme) { return scheme.rfind("low_defect", 0) == 0; }

inline std::string text_of(const StoppingRule& rule) {
  return (rule.kind == StoppingRule::Kind::paper ? "paper " : "product ") + number(rule.tolerance);
}

/// Every scheme under both rules, some with Broyden's method, and without iteration.
template <class H>
void add_semiexplicit(std::vector<Line>& lines, const Problem<H>& problem, double end) {
  const H& h = problem.hamiltonian;
  for (const std::string& name : schemes::names()) {
    const Scheme<double> scheme = schemes::by_name(name);
    const auto calls = static_cast<double>(scheme.kicks());
    const char* own = is_low_defect(name) ? family::low_defect : family::published;
    const auto add = [&](const char* family, const std::string& options, auto stepper, bool in_short) {
      lines.push_back(
          line_of_steps({family, name, options, scheme.order}, stepper, problem, end, calls, in_short));
    };
    for (const double tau : {1e-16, 1e-13, 1e-20}) {
      const StoppingRule rule = StoppingRule::product(tau);
      add(own, text_of(rule), Semiexplicit(h, scheme, SimplifiedNewton{.stop = rule}),
          tau == 1e-16 && (name == "low_defect6_s13" || name == "blanes_moan6"));
    }
    for (const double epsilon : {1e-13, 1e-9}) {
      const StoppingRule rule = StoppingRule::paper(epsilon);
      add(family::paper_rule, text_of(rule), Semiexplicit(h, scheme, SimplifiedNewton{.stop = rule}),
          epsilon == 1e-9 && name == "suzuki4");
    }
    if (name == "low_defect4_s7" || name == "low_defect6_s13" || name == "blanes_moan4" ||
        name == "blanes_moan6")
      add(own, "Broyden, product 1e-20",
          Semiexplicit(h, scheme, Broyden{.stop = StoppingRule::product(1e-20)}), false);
    add(family::midpoint, "", MidpointProjection(h, scheme), name == "blanes_moan6");
  }
}

/// Eight ω on either side of the problem's.
template <class H>
void add_tao(std::vector<Line>& lines, const Problem<H>& problem, double end) {
  for (const char* name : {"strang", "triple_jump4", "suzuki4", "suzuki6", "yoshida6", "kahan_li6",
                           "sofroniou_spaletta6", "kahan_li8", "suzuki_umeno8", "sofroniou_spaletta8"}) {
    const Scheme<double> scheme = schemes::by_name(name);
    const double calls = 1.5 * static_cast<double>(scheme.kicks());
    for (int power = -5; power <= 2; ++power) {
      const double omega = problem.omega * std::exp2(power);
      Line line = line_of_steps({family::tao, name, "ω " + number(omega), scheme.order},
                                Tao(problem.hamiltonian, scheme, omega), problem, end, calls,
                                power == 0 && calls < 15);
      line.factor = 1.4;
      lines.push_back(std::move(line));
    }
  }
}

}  // namespace work_precision
