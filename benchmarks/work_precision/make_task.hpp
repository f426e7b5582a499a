#pragma once

#include "gauss_methods.hpp"
#include "gsl_methods.hpp"
#include "odeint_methods.hpp"
#include "own_methods.hpp"
#include "reversible_methods.hpp"
#include "sundials_methods.hpp"
#include "task.hpp"

namespace work_precision {

/// Largest difference between the gradient and central differences of the energy, relative to the gradient.
template <class H>
double gradient_error(const H& hamiltonian, PhasePoint<double, H::Dof> z) {
  const Eigen::Index d = z.dof();
  const PhasePoint<double, H::Dof> at = z;
  PhasePoint<double, H::Dof> gradient(d);
  hamiltonian.gradient(at.q(), at.p(), gradient.q(), gradient.p());
  double worst = 0, scale = 0;
  for (Eigen::Index i = 0; i < 2 * d; ++i) {
    const double h = 1e-5 * std::max(1.0, std::abs(at.vector()[i]));
    z.vector()[i] = at.vector()[i] + h;
    const double ahead = hamiltonian.energy(z.q(), z.p());
    z.vector()[i] = at.vector()[i] - h;
    const double behind = hamiltonian.energy(z.q(), z.p());
    z.vector()[i] = at.vector()[i];
    worst = std::max(worst, std::abs((ahead - behind) / (2 * h) - gradient.vector()[i]));
    scale = std::max(scale, std::abs(gradient.vector()[i]));
  }
  return worst / scale;
}

/// The state at the end by Gauss's method of order 16, its steps halved until that no longer helps, and how
/// far the last two runs are from each other.
template <class H>
void find_last(const Problem<H>& problem, double end, Yardstick& yardstick) {
  const auto run = [&](std::int64_t steps) {
    PhasePoint<double, H::Dof> z = problem.start;
    GaussLegendre gauss(problem.hamiltonian, {.stages = 8});
    try {
      integrate(gauss, z, {.dt = end / static_cast<double>(steps), .steps = steps});
    } catch (const IntegrationError&) {  // too coarse
      return std::vector<double>(yardstick.start.size(), nan);
    }
    const auto& x = z.vector();
    return std::vector<double>(x.data(), x.data() + x.size());
  };
  const int halvings = 10;
  auto steps = static_cast<std::int64_t>(std::ceil(end / (24 * problem.step_per_call)));
  std::vector<double> before = run(steps);
  double apart = INFINITY;
  for (int k = 0; k < halvings; ++k) {
    yardstick.last = run(steps *= 2);
    const double now = distance(yardstick.last.data(), before.data(), yardstick.start);
    yardstick.last_unknown = std::max(now, apart < 1e-3 ? apart : 0);
    if (now > apart / 2 && now < 1e-3) break;
    before = yardstick.last;
    apart = now;
  }
  if (!(yardstick.last_unknown < 1e-3)) yardstick.last.clear();  // nothing is left of it
}

/// Everything that is run on a problem.
template <class H>
Task make_task(const Problem<H>& problem, bool is_short) {
  const double end = is_short ? problem.short_end : problem.end;
  Task task{.name = problem.name, .title = problem.title, .yardstick = {}, .most_calls = problem.most_calls};
  const H& hamiltonian = problem.hamiltonian;
  const auto& z = problem.start.vector();
  task.yardstick = {
      .end = end,
      .start = {z.data(), z.data() + z.size()},
      .energy = on_numbers<H::Dof>(problem.start.dof(),
                                   [=](const auto& q, const auto& p) { return hamiltonian.energy(q, p); }),
      .invariants = problem.invariants,
      .last = {}};
  if (problem.exact) {
    task.yardstick.last.resize(task.yardstick.start.size());
    problem.exact(end, task.yardstick.last.data());
  } else if (!problem.is_long) {
    find_last(problem, end, task.yardstick);
  }

  // Away from the start, where many a derivative happens to vanish.
  PhasePoint<double, H::Dof> moved = problem.start;
  for (Eigen::Index i = 0; i < z.size(); ++i)
    moved.vector()[i] += 0.05 * std::sin(static_cast<double>(i) + 1);
  task.gradient_error = gradient_error(hamiltonian, moved);

  add_semiexplicit(task.lines, problem, end);
  add_tao(task.lines, problem, end);
  add_gauss_methods(task.lines, problem, end);
  add_reversible(task.lines, problem, end);
  add_odeint(task.lines, problem, end);
  add_gsl(task.lines, problem, end);
  add_sundials(task.lines, problem, end);
  return task;
}

/// The same problem a hundred times as long: what drifts is seen to drift.
template <class H>
Task make_long_task(Problem<H> problem, double most_calls, bool is_short) {
  problem.name += "_long";
  problem.title += ", long";
  problem.end *= 100;
  problem.short_end *= 10;
  problem.most_calls = most_calls;
  problem.is_long = true;
  return make_task(problem, is_short);
}

}  // namespace work_precision
