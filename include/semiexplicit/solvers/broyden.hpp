#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/solvers/stopping.hpp>

namespace semiexplicit {

/// Broyden's "good" method, from m = 0 and the Jacobian 4I, restarted every step. It is superlinear where the
/// simplified Newton method is linear: fewer evaluations of f when dt is large, the same when one or two are
/// enough.
///
/// The inverse Jacobian is never formed. Because each correction s_k is -J⁻¹f itself, the k-th rank-one
/// update of J⁻¹ is s_{k+1} s_kᵀ J⁻¹ / ‖s_k‖², so the corrections are all that has to be kept: k vectors of
/// length 2d and O(k d) work an iteration, with the iterates of the dense 2d × 2d matrix.
///
/// Sources: C. G. Broyden, Math. Comp. 19 (1965) 577; Jayawardana and Ohsawa (2023), eq. (Broyden); the
/// storage of the corrections alone: C. T. Kelley, Iterative Methods for Linear and Nonlinear Equations (SIAM
/// 1995), section 7.3.
struct Broyden {
  static constexpr const char* name = "Broyden";
  static constexpr bool over_ranks = true;  ///< takes norms by norm_over_ranks()
  StoppingRule stop = StoppingRule::product();
  int max_iterations = 100;  ///< evaluations of f before it gives up; the step is refused then
  int memory = 20;  ///< corrections kept; when they are used up the method starts anew from the current m

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("rule", stop);
    list("max_iterations", max_iterations);
    list("memory", memory);
  }

  /// f, J⁻¹f and the kept corrections: memory + 2 vectors of length 2d.
  template <class Vec>
  struct Workspace {
    using Scalar = typename Vec::Scalar;
    /// Throws std::invalid_argument for options that make no sense.
    Workspace(const Broyden& options, Eigen::Index size)
        : f(Vec::Zero(size)),
          u(f),
          directions(size, std::max(options.memory, 1)),
          lengths(std::max(options.memory, 1)) {
      detail::require_options(name, options.stop, options.max_iterations);
      if (options.memory < 1)
        throw std::invalid_argument("Broyden: memory is below 1; give how many corrections to keep");
    }
    Vec f, u;
    Eigen::Matrix<Scalar, Vec::RowsAtCompileTime, Eigen::Dynamic> directions;  ///< s_k / ‖s_k‖
    Vector<Scalar, Eigen::Dynamic> lengths;                                    ///< ‖s_k‖
  };

  /// Solves f(m) = 0, as SimplifiedNewton::solve().
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    using std::abs;
    using Scalar = typename Vec::Scalar;
    detail::Convergence<Scalar> convergence(stop, max_iterations);
    residual(work.f);
    work.u = work.f / -4;
    Scalar length = norm_over_ranks(residual, work.u);
    const Scalar first = length;  // ‖f(0)‖/4
    if (convergence.done(length, Scalar(0), residual)) return convergence.report();
    m.setZero();
    Eigen::Index kept = 0;
    for (;;) {
      if (kept < work.lengths.size()) {
        work.directions.col(kept) = work.u / length;
        work.lengths[kept] = length;
        ++kept;
      } else {
        kept = 0;  // this correction is not -f/4, so it cannot be the first of a new row; the next one can
      }
      m += work.u;

      residual(m, work.f);
      const Scalar size_f = norm_over_ranks(residual, work.f);
      work.u = work.f / -4;
      for (Eigen::Index j = 0; j + 1 < kept; ++j) {
        const Scalar share = dot_over_ranks(residual, work.directions.col(j), work.u) *
                             (work.lengths[j + 1] / work.lengths[j]);
        work.u += share * work.directions.col(j + 1);
      }
      // The newest update would need s_{k+1}, the vector wanted: solved for it, it is a mere scaling.
      if (kept > 0) {
        const Scalar divisor =
            1 - dot_over_ranks(residual, work.directions.col(kept - 1), work.u) / work.lengths[kept - 1];
        if (abs(divisor) <= Scalar(1e-6)) {  // the update is singular: start anew
          work.u = work.f / -4;
          kept = 0;
        } else {
          work.u /= divisor;
        }
      }
      length = norm_over_ranks(residual, work.u);
      // The updates may cancel what f still has, so that a short correction alone says nothing.
      if (convergence.done(std::max(length, size_f / 4), norm_over_ranks(residual, m), residual)) {
        if (convergence.refused_as_distant() && !convergence.exhausted(1)) {
          for (int sweep = 0; sweep < 2; ++sweep) convergence.count();
          if (is_straight(residual, m, first, work)) convergence.take_distant();
        }
        return convergence.report();
      }
    }
  }

 private:
  /// Whether f falls to 0 on a nearly straight way, ‖f(m/2)‖ = ‖f(0)‖/2: then m is the step's solution,
  /// however far the iteration strayed, as it does at steps of radians. Two evaluations; leaves the copies at
  /// m.
  template <class Residual, class Vec>
  static bool is_straight(Residual& residual, const Vec& m, const typename Vec::Scalar& first,
                          Workspace<Vec>& work) {
    using std::abs;
    work.u = m / 2;
    residual(work.u, work.f);
    const auto half = norm_over_ranks(residual, work.f);
    residual(m, work.f);
    return abs(half - 2 * first) <= first / 50;
  }
};

}  // namespace semiexplicit
