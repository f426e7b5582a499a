#pragma once

#include "adaptive.hpp"

#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
#include <boost/numeric/odeint/stepper/bulirsch_stoer.hpp>
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#endif

namespace work_precision {

#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
/// `make(absolute, relative)` gives a controlled stepper of Boost.odeint.
template <class H, class Make>
Outcome run_controlled(const Problem<H>& problem, double end, double tolerance, Watch* watch,
                       const Make& make) {
  auto z = start_numbers(problem.start);
  auto stepper = make(tolerance * problem.size(), tolerance);
  std::int64_t gradients = 0;
  const H& hamiltonian = problem.hamiltonian;
  const auto field = [&](const auto& at, auto& dzdt, double) {
    ++gradients;
    vector_field(hamiltonian, at.data(), dzdt.data());
  };
  return run_adaptively(
      end, problem.step_per_call, watch, z.data(), z.size(), gradients, [&](double& t, double& dt) {
        return detail::inlined<double>(
            [&] { return stepper.try_step(field, z, t, dt) == boost::numeric::odeint::success; });
      });
}

/// The formula with a fixed step.
template <class H>
struct FixedRk78 {
  using Scalar = double;
  using State = PhasePoint<double, H::Dof>;
  using Z = Numbers<H::Dof>;

  StepReport step(State& z, double dt) {
    for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = z.vector()[static_cast<Eigen::Index>(i)];
    StepReport report;
    const auto field = [&](const Z& at, Z& dzdt, double) {
      ++report.gradients;
      vector_field(hamiltonian, at.data(), dzdt.data());
    };
    stepper.do_step(field, numbers, 0.0, dt);
    for (std::size_t i = 0; i < numbers.size(); ++i) z.vector()[static_cast<Eigen::Index>(i)] = numbers[i];
    if (!std::isfinite(numbers[0])) report.status = Status::not_finite;
    return report;
  }

  H hamiltonian;
  Z numbers;
  boost::numeric::odeint::runge_kutta_fehlberg78<Z> stepper{};
};
#endif

/// Runge-Kutta-Fehlberg of order 8 and Bulirsch-Stoer of Boost.odeint.
template <class H>
void add_odeint([[maybe_unused]] std::vector<Line>& lines, [[maybe_unused]] const Problem<H>& problem,
                [[maybe_unused]] double end) {
#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
  namespace odeint = boost::numeric::odeint;
  using Z = Numbers<H::Dof>;
  Line rk78 = line_of_tolerances({family::rk78, "RK78", "adaptive", 0}, true);
  rk78.run = [=](double tolerance, Watch* watch) {
    return run_controlled(problem, end, tolerance, watch, [](double absolute, double relative) {
      return odeint::make_controlled(absolute, relative, odeint::runge_kutta_fehlberg78<Z>());
    });
  };
  lines.push_back(rk78);
  lines.push_back(line_of_steps({family::rk78, "RK78", "fixed step", 8},
                                FixedRk78<H>{problem.hamiltonian, start_numbers(problem.start)}, problem, end,
                                13, false));
  Line stoer = line_of_tolerances({family::bulirsch_stoer, "Bulirsch-Stoer", "adaptive", 0}, true);
  stoer.run = [=](double tolerance, Watch* watch) {
    return run_controlled(problem, end, tolerance, watch, [](double absolute, double relative) {
      return odeint::bulirsch_stoer<Z>(absolute, relative);
    });
  };
  lines.push_back(stoer);
#endif
}

}  // namespace work_precision
