#pragma once

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/solvers/stopping.hpp>

namespace semiexplicit {

/// Newton's iteration with the Jacobian 4I that f has at dt = 0: m ← m - f(m)/4, from m = 0. Needs no memory
/// of its own beyond f. It contracts by |sin(λ dt/2)| on an oscillation of frequency λ (for an accurate
/// scheme), so it is the right solver wherever the step resolves the motion.
///
/// Source: Jayawardana and Ohsawa, Math. Comp. 92 (2023) 251, eq. (simplified_Newton).
struct SimplifiedNewton {
  static constexpr const char* name = "SimplifiedNewton";
  static constexpr bool over_ranks = true;  ///< takes norms by norm_over_ranks()
  StoppingRule stop = StoppingRule::product();
  int max_iterations = 100;  ///< evaluations of f before it gives up; the step is refused then

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("rule", stop);
    list("max_iterations", max_iterations);
  }

  /// The residual's value: one vector of length 2d.
  template <class Vec>
  struct Workspace {
    /// Throws std::invalid_argument for options that make no sense.
    Workspace(const SimplifiedNewton& options, Eigen::Index size) : f(Vec::Zero(size)) {
      detail::require_options(name, options.stop, options.max_iterations);
    }
    Vec f;
  };

  /// The bookkeeping of such an iteration. One whose m becomes eight times the first correction creeps, and
  /// may be on its way to another solution.
  template <class Scalar>
  detail::Convergence<Scalar> convergence() const {
    return {stop, max_iterations, 8};
  }

  /// Solves f(m) = 0, where residual(f) writes f(0) and residual(m, f) writes f(m). On return the residual
  /// was last evaluated at the accepted m; `m` itself is only set where more than one evaluation was needed.
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    using Scalar = typename Vec::Scalar;
    auto convergence = this->template convergence<Scalar>();
    residual(work.f);
    Scalar size_m(0);
    while (!convergence.done(norm_over_ranks(residual, work.f) / 4, size_m, residual)) {
      if (size_m == Scalar(0)) m.setZero();
      m -= work.f / 4;
      size_m = norm_over_ranks(residual, m);
      residual(m, work.f);
    }
    return convergence.report();
  }
};

}  // namespace semiexplicit
