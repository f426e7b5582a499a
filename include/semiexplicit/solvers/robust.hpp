#pragma once

#include <semiexplicit/solvers/broyden.hpp>
#include <semiexplicit/solvers/newton_krylov.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>

namespace semiexplicit {

/// A solver that does not give up early: simplified Newton, and where that fails Broyden, and where that
/// fails Newton-Krylov, each from the start. StepReport::escalations says which of them made the step: 0, 1
/// or 2. An easy step costs what it costs with simplified Newton alone; for the memory of all three see
/// Broyden and NewtonKrylov.
struct Robust {
  static constexpr const char* name = "Robust";
  static constexpr bool over_ranks = true;  ///< takes norms by norm_over_ranks()
  StoppingRule stop = StoppingRule::product();
  int newton_iterations =
      15;  ///< evaluations of f for the simplified Newton method; a good step takes one or two
  int broyden_iterations = 30;  ///< evaluations of f for Broyden's
  int max_iterations = 500;     ///< evaluations of f for the Newton-Krylov method

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("rule", stop);
    list("newton_iterations", newton_iterations);
    list("broyden_iterations", broyden_iterations);
    list("max_iterations", max_iterations);
  }

  template <class Vec>
  struct Workspace {
    /// Throws std::invalid_argument for options that make no sense, as each of the three does.
    Workspace(const Robust& options, Eigen::Index size)
        : newton({.stop = options.stop, .max_iterations = options.newton_iterations}, size),
          broyden({.stop = options.stop, .max_iterations = options.broyden_iterations}, size),
          krylov({.stop = options.stop, .max_iterations = options.max_iterations}, size) {}
    SimplifiedNewton::Workspace<Vec> newton;
    Broyden::Workspace<Vec> broyden;
    NewtonKrylov::Workspace<Vec> krylov;
  };

  /// Solves f(m) = 0, as SimplifiedNewton::solve().
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    auto report = SimplifiedNewton{stop, newton_iterations}.solve(residual, m, work.newton);
    const auto go_on = [&](const auto& solver, auto& workspace) {
      const auto failed = report;
      report = solver.solve(residual, m, workspace);
      report.evaluations += failed.evaluations;
      report.escalations = failed.escalations + 1;
    };
    // Where f(0) itself is not finite nobody can help.
    const auto hopeless = [&] { return report.status == Status::not_finite && report.evaluations == 1; };
    if (!report.ok() && !hopeless())
      go_on(Broyden{.stop = stop, .max_iterations = broyden_iterations}, work.broyden);
    if (!report.ok() && !hopeless())
      go_on(NewtonKrylov{.stop = stop, .max_iterations = max_iterations}, work.krylov);
    return report;
  }
};

}  // namespace semiexplicit
