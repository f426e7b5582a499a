#pragma once

#include <concepts>
#include <type_traits>

#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/core/vector.hpp>

namespace semiexplicit {

namespace detail {

/// How large positions and momenta are, as a step counts them; 0 where that is not known.
template <class Scalar>
struct SizesOfHalves {
  Scalar q = Scalar(0), p = Scalar(0);
};

/// The equation of the projection as a solver sees it.
template <class Vec>
struct AnyResidual {
  using Scalar = typename Vec::Scalar;
  void operator()(Vec& f);                ///< f(0), where every solver starts
  void operator()(const Vec& m, Vec& f);  ///< f(m)
  Scalar state_size() const;              ///< ‖z‖, or less; see StoppingRule
  Scalar farthest() const;        ///< the step's own solution has no larger ‖m‖, by the last sweep
  Scalar rounding_level() const;  ///< a correction below this may be nothing but rounding
  /// Of the last f: |fᵢ|/4 in every entry is below so many roundings of zᵢ and of what a step moves. The
  /// norms of rounding_level() are those of the largest entry, which may be coupled to nothing.
  bool within_rounding(double multiple) const;
};

template <class S, class Vec>
concept HasWorkspace = requires(const S& solver, Eigen::Index size) {
  requires std::constructible_from < typename S::template Workspace<Vec>,
  decltype(solver), decltype(size) > ;
};
template <class S, class Vec>
concept HasSolve = requires(const S& solver, AnyResidual<Vec>& residual, Vec& m,
                            typename S::template Workspace<Vec>& work) {
  { solver.solve(residual, m, work) } -> std::same_as<SolverReport<typename Vec::Scalar>>;
};

}  // namespace detail

/// What finds the multiplier m with f(m) = 0 for Semiexplicit, Vec being a column of 2d numbers:
///
///     struct Mine {
///       template <class Vec>
///       struct Workspace {                                   // its memory, made once
///         Workspace(const Mine& options, Eigen::Index size);
///       };
///       template <class Residual, class Vec>
///       SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const;
///     };
///
/// residual(f) writes f(0) and residual(m, f) writes f(m), one sweep each. On return the residual was last
/// evaluated at the accepted m. A residual may also say by `halves()` how large positions and momenta are,
/// whose units may differ by any factor (SizesOfHalves). See SimplifiedNewton, the shortest. A solver whose
/// runs are to be saved has a `name` and lists its options; see Describable.
template <class S, class Vec>
concept Solver = std::copy_constructible<S> && detail::HasWorkspace<S, Vec> && detail::HasSolve<S, Vec>;

namespace detail {

template <class Found>
constexpr bool takes_multiplier_by_value() {
  if constexpr (Found::count == 3)
    return !std::is_reference_v<typename Found::template FromLast<1>> ||
           !std::is_reference_v<typename Found::template FromLast<2>>;
  else
    return false;
}
/// Whether what a solver finds, or the residual that it was last evaluated of, is a copy's.
template <class S, class Vec>
constexpr bool solves_a_copy() {
  using Residual = AnyResidual<Vec>;
  using Work = typename S::template Workspace<Vec>;
  if constexpr (requires { &S::solve; })
    return takes_multiplier_by_value<Parameters<decltype(&S::solve)>>();
  else if constexpr (requires { &S::template solve<Residual, Vec>; })
    return takes_multiplier_by_value<Parameters<decltype(&S::template solve<Residual, Vec>)>>();
  else if constexpr (requires { &S::template solve<Residual, Vec, Work>; })
    return takes_multiplier_by_value<Parameters<decltype(&S::template solve<Residual, Vec, Work>)>>();
  else
    return false;
}

/// Compiles for a solver; of anything else the compiler says what is missing.
template <class S, class Vec>
consteval bool is_solver() {
  static_assert(HasWorkspace<S, Vec>,
                "this solver has no memory to work in: write `template <class Vec> struct Workspace` in it, "
                "made of (const Solver&, Eigen::Index size); see core/solver.hpp");
  if constexpr (HasWorkspace<S, Vec>)
    static_assert(HasSolve<S, Vec>,
                  "this solver has no `template <class Residual, class Vec> SolverReport<typename "
                  "Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const`; see "
                  "core/solver.hpp");
  if constexpr (Solver<S, Vec>)
    static_assert(
        !solves_a_copy<S, Vec>(),
        "solve() of this solver takes the residual or m by value, so that what it finds is lost: "
        "write `SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& "
        "work) const`");
  return Solver<S, Vec>;
}

/// Where the class is no solver, something to go on with after the error.
struct NoWorkspace {
  template <class... Anything>
  explicit NoWorkspace(const Anything&...) {}
};
template <class S, class Vec, bool = is_solver<S, Vec>()>
struct SolverDoor {
  using Workspace = NoWorkspace;
};
template <class S, class Vec>
struct SolverDoor<S, Vec, true> {
  using Workspace = typename S::template Workspace<Vec>;
};

}  // namespace detail
}  // namespace semiexplicit
