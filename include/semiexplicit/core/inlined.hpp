#pragma once

#include <type_traits>

// Compilers stop inlining a small gradient in a large translation unit, which nearly doubles the time of a
// kick; the sweep is where that must not happen. g++ inlines all that a function with `flatten` calls,
// however deep; clang++ only what it calls itself. g++ does not inline copies that it makes of a function for
// constant arguments, and makes none beyond a function with `noclone`. Without optimisation all of this would
// only make functions of megabytes.
#if defined(__clang__) && defined(__OPTIMIZE__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#define SEMIEXPLICIT_NOINLINE __attribute__((noinline))
#define SEMIEXPLICIT_INLINE __attribute__((always_inline)) inline
#define SEMIEXPLICIT_INLINE_CALLS __attribute__((flatten))
// Inlined by every compiler that optimises, whatever its size.
#define SEMIEXPLICIT_INTO_CALLER __attribute__((always_inline)) inline
// What calls a user's term, which has to become one piece with the loop over terms, and what a term is made
// of.
#define SEMIEXPLICIT_CALL_OF_TERM __attribute__((always_inline, flatten))
#define SEMIEXPLICIT_INTO_TERM __attribute__((always_inline)) inline
#define SEMIEXPLICIT_INLINE_LAMBDA __attribute__((always_inline))
// A kick within a sweep, which clang++ makes a function; by g++ it is slower inlined by force.
#define SEMIEXPLICIT_INLINE_KICK __attribute__((always_inline))
#elif defined(__GNUC__) && defined(__OPTIMIZE__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#define SEMIEXPLICIT_NOINLINE __attribute__((noinline))
#define SEMIEXPLICIT_INLINE inline
#define SEMIEXPLICIT_INLINE_CALLS
#define SEMIEXPLICIT_INTO_CALLER __attribute__((always_inline)) inline
#define SEMIEXPLICIT_CALL_OF_TERM __attribute__((noclone, flatten))
#define SEMIEXPLICIT_INTO_TERM __attribute__((always_inline)) inline
#define SEMIEXPLICIT_INLINE_LAMBDA __attribute__((always_inline))
#define SEMIEXPLICIT_INLINE_KICK
#else
#define SEMIEXPLICIT_FLATTEN
#define SEMIEXPLICIT_NOINLINE
#define SEMIEXPLICIT_INLINE inline
#define SEMIEXPLICIT_INLINE_CALLS
#define SEMIEXPLICIT_INTO_CALLER inline
#define SEMIEXPLICIT_CALL_OF_TERM
#define SEMIEXPLICIT_INTO_TERM inline
#define SEMIEXPLICIT_INLINE_LAMBDA
#define SEMIEXPLICIT_INLINE_KICK
#endif

namespace semiexplicit::detail {

template <class F>
SEMIEXPLICIT_FLATTEN auto call_inlined(const F& f) {
  return f();
}

/// Calls f with everything that it calls inlined. Not where numbers are classes: with multiprecision
/// arithmetic inlined into itself g++ takes hours and all memory.
template <class Scalar, class F>
auto inlined(const F& f) {
  if constexpr (std::is_floating_point_v<Scalar>)
    return call_inlined(f);
  else
    return f();
}

}  // namespace semiexplicit::detail
