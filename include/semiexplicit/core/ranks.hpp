#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include <semiexplicit/core/vector.hpp>

// One trajectory over many processes (ranks): each has a block of the state, its Hamiltonian exchanges what
// neighbours need in gradient(), and the decisions of a step are taken from sums over all of them.

namespace semiexplicit {

/// Optional, for a Hamiltonian whose (q, p) is one rank's block of a larger state: `Scalar
/// sum_over_ranks(const Scalar& x) const` gives the sum of all ranks' x, with the same bits on each. Norms,
/// checks and statuses of a step are then those of the whole state, so that every rank takes the same number
/// of evaluations and the same way out. All ranks call it, gradient() and energy() equally often, in the same
/// order; energy() gives the whole energy. What throws on one rank has to throw on all, or to end them. The
/// residual that a solver gets has this member where H has it.
///
/// Semiexplicit, MidpointProjection, ExplicitSplitting, Pihajoki and Tao take such an H, with every solver of
/// the library; what takes norms of its own (GaussLegendre, tangent vectors, time transformations,
/// ReversibleSteps, FieldSize and TimeScale, run() and cost_of_accuracy(), an Ensemble) or looks at one block
/// only (events and sections, with_error_estimate()) refuses it.
template <class T, class Scalar = typename T::Scalar>
concept SumsOverRanks = requires(const T& t, const Scalar& x) {
  { t.sum_over_ranks(x) } -> std::convertible_to<Scalar>;
};

/// u · v of whole columns, of which each rank has its block. `where` is a Hamiltonian or a residual; where it
/// has no sum_over_ranks() the block is all there is.
template <class Where, class U, class V>
typename U::Scalar dot_over_ranks([[maybe_unused]] const Where& where, const Eigen::MatrixBase<U>& u,
                                  const Eigen::MatrixBase<V>& v) {
  if constexpr (SumsOverRanks<Where, typename U::Scalar>)
    return where.sum_over_ranks(detail::dot(u, v));
  else
    return detail::dot(u, v);
}

/// Euclidean norm of a whole column, likewise; it neither underflows nor overflows.
template <class Where, class V>
typename V::Scalar norm_over_ranks([[maybe_unused]] const Where& where, const Eigen::MatrixBase<V>& v) {
  using Scalar = typename V::Scalar;
  if constexpr (SumsOverRanks<Where, Scalar>) {
    using std::isfinite;
    using std::sqrt;
    const Scalar squared = where.sum_over_ranks(detail::dot(v, v));
    if (detail::is_plain_square(squared)) return sqrt(squared);
    const Scalar own = detail::norm(v), unit = where.sum_over_ranks(own);
    if (unit == Scalar(0) || !isfinite(unit)) return unit;
    return unit * sqrt(where.sum_over_ranks((own / unit) * (own / unit)));
  } else {
    return detail::norm(v);
  }
}

/// How many numbers a whole column has, of which each rank has its block.
template <class Where, class V>
typename V::Scalar size_over_ranks([[maybe_unused]] const Where& where, const Eigen::MatrixBase<V>& v) {
  const typename V::Scalar own(static_cast<double>(v.size()));
  if constexpr (SumsOverRanks<Where, typename V::Scalar>)
    return where.sum_over_ranks(own);
  else
    return own;
}

/// Whether something holds on all ranks.
template <class Scalar, class Where>
bool on_all_ranks([[maybe_unused]] const Where& where, bool here) {
  if constexpr (SumsOverRanks<Where, Scalar>)
    return where.sum_over_ranks(Scalar(here ? 0 : 1)) == Scalar(0);
  else
    return here;
}

namespace detail {

/// Compiles for an H whose state is in one process; of others the compiler says what takes them.
template <class H>
consteval bool is_in_one_process() {
  static_assert(!SumsOverRanks<H>,
                "this Hamiltonian has sum_over_ranks(), and what is asked of it here takes norms of one "
                "process's state; over ranks go Semiexplicit, MidpointProjection, ExplicitSplitting, "
                "Pihajoki and Tao, see core/ranks.hpp");
  return true;
}

/// Compiles for a solver that may be used with H: over ranks its norms have to be those of the whole.
template <class H, class Solver>
consteval bool solver_goes_with() {
  if constexpr (SumsOverRanks<H>)
    static_assert(
        requires { requires bool(Solver::over_ranks); },
        "this Hamiltonian has sum_over_ranks(), so that the solver has to take norms by "
        "norm_over_ranks(residual, v): do so, and write `static constexpr bool over_ranks = "
        "true;` in it; see core/ranks.hpp");
  return true;
}

}  // namespace detail
}  // namespace semiexplicit
