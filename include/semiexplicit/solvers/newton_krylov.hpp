#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/solvers/stopping.hpp>

namespace semiexplicit {

/// Newton's method without matrices: the linear equation of each iteration is solved by GMRES, which asks for
/// the Jacobian only by its products with vectors, and these are differences of f. It converges where the
/// simplified Newton method and Broyden's diverge, at steps that do not resolve the fastest motion, at the
/// price of one evaluation of f a direction: a few where few frequencies are fast, tens in a stiff lattice.
///
/// The accuracy of a step depends on ‖f‖ (see StoppingRule), so e = ‖f‖/4 is judged as for SimplifiedNewton,
/// and a step that this one would accept at once costs the same here.
///
/// Sources: C. T. Kelley, Iterative Methods for Linear and Nonlinear Equations (SIAM 1995), chapters 3, 6 and
/// 8; Y. Saad, M. H. Schultz, SIAM J. Sci. Stat. Comput. 7 (1986) 856.
struct NewtonKrylov {
  static constexpr const char* name = "NewtonKrylov";
  static constexpr bool over_ranks = true;  ///< takes norms by norm_over_ranks()
  StoppingRule stop = StoppingRule::product();
  int max_iterations = 500;  ///< evaluations of f before it gives up, those for products included
  int directions = 30;       ///< largest number of GMRES directions in a Newton iteration

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("rule", stop);
    list("max_iterations", max_iterations);
    list("directions", directions);
  }

  /// directions + 5 vectors of length 2d, and a small triangle.
  template <class Vec>
  struct Workspace {
    using Scalar = typename Vec::Scalar;
    /// Throws std::invalid_argument for options that make no sense.
    Workspace(const NewtonKrylov& options, Eigen::Index size)
        : f(Vec::Zero(size)),
          shifted(f),
          trial(f),
          step(f),
          basis(size, std::max(options.directions, 1) + 1),
          triangle(basis.cols(), basis.cols()),
          rotated(basis.cols()),
          cosine(basis.cols()),
          sine(basis.cols()) {
      detail::require_options(name, options.stop, options.max_iterations);
      if (options.directions < 1)
        throw std::invalid_argument("NewtonKrylov: directions is below 1; give how many GMRES may take");
    }
    Vec f, shifted, trial, step;
    Eigen::Matrix<Scalar, Vec::RowsAtCompileTime, Eigen::Dynamic> basis;  ///< orthonormal directions
    Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> triangle;       ///< R of the Hessenberg matrix
    Eigen::Matrix<Scalar, Eigen::Dynamic, 1> rotated, cosine, sine;  ///< right-hand side, Givens rotations
  };

  /// Solves f(m) = 0, as SimplifiedNewton::solve().
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    using Scalar = typename Vec::Scalar;
    detail::Convergence<Scalar> convergence(stop, max_iterations);
    residual(work.f);
    if (convergence.done(norm_over_ranks(residual, work.f) / 4, Scalar(0), residual))
      return convergence.report();
    m.setZero();
    const Units<Scalar> units(residual);
    Scalar size_f = units.norm(residual, work.f);
    for (;;) {
      find_step(residual, units, m, size_f, work, convergence);
      if (convergence.exhausted()) return convergence.report();
      // Halved until f gets smaller: far from the solution the full step may not.
      Scalar part(1), size_trial;
      for (int halvings = 0;; ++halvings) {
        work.trial = m + part * work.step;
        residual(work.trial, work.f);
        size_trial = units.norm(residual, work.f);
        const bool smaller = size_trial <= (1 - part / 10000) * size_f;
        if (smaller || halvings == 8 || norm_over_ranks(residual, work.f) <= 4 * residual.rounding_level() ||
            convergence.exhausted(1))
          break;
        convergence.count();
        part /= 2;
      }
      m = work.trial;
      size_f = size_trial;
      if (convergence.done(norm_over_ranks(residual, work.f) / 4, norm_over_ranks(residual, m), residual))
        return convergence.report();
    }
  }

 private:
  /// GMRES makes a sum of squares small, which means nothing where momenta are in other units than positions,
  /// and a shift of one may be many times the other: momenta are counted in units in which they are as large.
  template <class Scalar>
  struct Units {
    template <class Residual>
    explicit Units(const Residual& residual) {
      if constexpr (requires { residual.halves(); }) {
        using std::isfinite;
        using std::sqrt;
        const auto halves = residual.halves();
        const Scalar ratio = halves.p / halves.q;
        if (!(ratio > Scalar(0)) || !isfinite(ratio)) return;
        momenta = ratio;
        size = sqrt(Scalar(2)) * halves.q;
      }
    }
    Scalar momenta = Scalar(1), size = Scalar(0);  ///< of the state; 0: not known

    /// A column in these units becomes one in the system's, multiplied by a factor.
    template <class From, class To>
    void to_own(const From& v, const Scalar& factor, To& own) const {
      const Eigen::Index d = v.size() / 2;
      own.head(d) = factor * v.head(d);
      own.tail(d) = (factor * momenta) * v.tail(d);
    }
    template <class From, class To>
    void from_own(const From& own, const Scalar& factor, To&& v) const {
      const Eigen::Index d = own.size() / 2;
      v.head(d) = factor * own.head(d);
      v.tail(d) = (factor / momenta) * own.tail(d);
    }
    template <class Residual, class Vec>
    Scalar norm(const Residual& residual, const Vec& own) const {
      const Eigen::Index d = own.size() / 2;
      return detail::norm(Vector<Scalar, 2>(norm_over_ranks(residual, own.head(d)),
                                            norm_over_ranks(residual, own.tail(d)) / momenta));
    }
  };

  /// GMRES for f'(m) step = -f(m), to a tenth of ‖f‖: the next iteration takes the rest.
  template <class Residual, class Vec, class Scalar>
  void find_step(Residual& residual, const Units<Scalar>& units, const Vec& m, const Scalar& size_f,
                 Workspace<Vec>& work, detail::Convergence<Scalar>& convergence) const {
    using std::abs;
    using std::hypot;
    using std::sqrt;
    // Of the length at which rounding and curvature spoil a difference alike.
    const Scalar size = units.size > Scalar(0) ? units.size : Scalar(residual.state_size());
    const Scalar shift = sqrt(Eigen::NumTraits<Scalar>::epsilon()) * (size + units.norm(residual, m));
    // The whole state has no more directions than numbers; one rank's block may have fewer.
    const Scalar most = std::min(Scalar(double(work.basis.cols() - 1)), size_over_ranks(residual, m));
    units.from_own(work.f, -1 / size_f, work.basis.col(0));
    work.rotated.setZero();
    work.rotated[0] = size_f;
    Eigen::Index k = 0;
    while (Scalar(double(k)) < most && !convergence.exhausted()) {
      units.to_own(work.basis.col(k), shift, work.trial);
      work.trial += m;
      residual(work.trial, work.shifted);
      convergence.count();
      auto next = work.basis.col(k + 1);
      work.shifted -= work.f;
      units.from_own(work.shifted, 1 / shift, next);
      auto column = work.triangle.col(k);
      for (Eigen::Index i = 0; i <= k; ++i) {  // modified Gram-Schmidt
        column[i] = dot_over_ranks(residual, work.basis.col(i), next);
        next -= column[i] * work.basis.col(i);
      }
      const Scalar length = norm_over_ranks(residual, next);
      if (length > Scalar(0)) next /= length;
      for (Eigen::Index i = 0; i < k; ++i) {
        const Scalar above = work.cosine[i] * column[i] + work.sine[i] * column[i + 1];
        column[i + 1] = work.cosine[i] * column[i + 1] - work.sine[i] * column[i];
        column[i] = above;
      }
      const Scalar radius = hypot(column[k], length);
      if (!(radius > Scalar(0))) break;  // a direction that changes nothing, or NaN
      work.cosine[k] = column[k] / radius;
      work.sine[k] = length / radius;
      column[k] = radius;
      work.rotated[k + 1] = -work.sine[k] * work.rotated[k];
      work.rotated[k] *= work.cosine[k];
      ++k;
      if (abs(work.rotated[k]) <= size_f / 10) break;
    }
    work.trial.setZero();
    for (Eigen::Index i = k; i-- > 0;) {
      Scalar sum = work.rotated[i];
      for (Eigen::Index j = i + 1; j < k; ++j) sum -= work.triangle(i, j) * work.rotated[j];
      work.rotated[i] = sum / work.triangle(i, i);
      work.trial += work.rotated[i] * work.basis.col(i);
    }
    units.to_own(work.trial, Scalar(1), work.step);
    if (k == 0) work.step = work.f / -4;
  }
};

}  // namespace semiexplicit
