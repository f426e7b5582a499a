#pragma once

#include <type_traits>

// Compilers stop inlining a small gradient in a large translation unit, which nearly doubles the time of a
// kick; the sweep is where that must not happen. g++ inlines all that a function with `flatten` calls,
// however deep; clang++ only what it calls itself.
#if defined(__clang__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#define SEMIEXPLICIT_NOINLINE __attribute__((noinline))
#define SEMIEXPLICIT_INLINE __attribute__((always_inline)) inline
#define SEMIEXPLICIT_INLINE_CALLS __attribute__((flatten))
#elif defined(__GNUC__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#define SEMIEXPLICIT_NOINLINE __attribute__((noinline))
#define SEMIEXPLICIT_INLINE inline
#define SEMIEXPLICIT_INLINE_CALLS
#else
#define SEMIEXPLICIT_FLATTEN
#define SEMIEXPLICIT_NOINLINE
#define SEMIEXPLICIT_INLINE inline
#define SEMIEXPLICIT_INLINE_CALLS
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
