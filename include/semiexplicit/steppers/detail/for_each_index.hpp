#pragma once

#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>

namespace semiexplicit::detail {

/// Calls f(i) for every i < n. With a small constant for n there is no loop, and what f indexes can stay in
/// registers; from 5 on compilers do better with a loop, which they vectorise.
template <class F>
SEMIEXPLICIT_INLINE void for_each_index(Eigen::Index n, const F& f) {
  for (Eigen::Index i = 0; i < n; ++i) f(i);
}
template <int N, class F>
SEMIEXPLICIT_INLINE void for_each_index(std::integral_constant<int, N>, const F& f) {
  if constexpr (N <= 4) [&]<int... I>(std::integer_sequence<int, I...>) {
      (f(I), ...);
    }
  (std::make_integer_sequence<int, N>());
  else for (Eigen::Index i = 0; i < N; ++i) f(i);
}
/// Whether a number of degrees of freedom is a constant, and so small that a loop over it gains nothing by
/// vectors. With g++ the two copies also have to fit into the registers: 16 of them, or 32.
template <class Size>
inline constexpr bool is_small_constant = false;
template <int D>
#if defined(__clang__) || defined(__AVX512VL__)
inline constexpr bool is_small_constant<std::integral_constant<int, D>> = D <= 8;
#else
inline constexpr bool is_small_constant<std::integral_constant<int, D>> = D <= 4;
#endif
/// And whether the sum of the increments, as long as a copy, fits in beside them.
template <class Size>
inline constexpr bool sums_are_small = is_small_constant<Size>;
#if !defined(__clang__)
template <int D>
inline constexpr bool sums_are_small<std::integral_constant<int, D>> = D <= 4;
#endif

/// 2d, a constant where d is one.
inline Eigen::Index twice_of(Eigen::Index d) { return 2 * d; }
template <int D>
constexpr std::integral_constant<int, 2 * D> twice_of(std::integral_constant<int, D>) {
  return {};
}

}  // namespace semiexplicit::detail
