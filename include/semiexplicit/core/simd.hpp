#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>

#include <semiexplicit/core/hamiltonian.hpp>

// Not in every standard library (libstdc++ has it from version 11 on). SEMIEXPLICIT_NO_SIMD leaves it out,
// for tests.
#if defined(__has_include) && !defined(SEMIEXPLICIT_NO_SIMD)
#if __has_include(<experimental/simd>)
// By clang++ for AVX-512 a masked assignment, where(mask, x) = y, changes all lanes or none (libstdc++ 12,
// bits/simd_x86.h: "FIXME: this does a boolean choice, not a blend"), and sin and cos with it: packs have the
// registers of AVX2 there.
#if defined(__clang__) && defined(__AVX512F__)
#ifdef __cpp_lib_experimental_parallel_simd
#error \
    "semiexplicit: include its headers before <experimental/simd>, whose masks are wrong by clang++ with AVX-512"
#endif
#pragma push_macro("__AVX512F__")
#pragma push_macro("__AVX512VL__")
#pragma push_macro("__AVX512BW__")
#pragma push_macro("__AVX512DQ__")
#undef __AVX512F__
#undef __AVX512VL__
#undef __AVX512BW__
#undef __AVX512DQ__
#include <experimental/simd>
#pragma pop_macro("__AVX512F__")
#pragma pop_macro("__AVX512VL__")
#pragma pop_macro("__AVX512BW__")
#pragma pop_macro("__AVX512DQ__")
#else
#include <experimental/simd>
#endif
#endif
#endif
#ifndef __cpp_lib_experimental_parallel_simd
#include <semiexplicit/core/array_pack.hpp>
#endif

#ifdef __cpp_lib_experimental_parallel_simd
// libstdc++'s sin and cos of packs count the quadrants in an int, which ends at 3.4e9, and reduce all lanes
// in another way where one is beyond 805, so that a lane's result depends on the others. These take such
// lanes one by one. They have to stand where packs are, as nothing else finds them for a Hamiltonian's
// `sin(q[0])`; being more special they come first.
namespace std::experimental {
inline namespace parallelism_v2 {
#define SEMIEXPLICIT_FAR_LANES_ONE_BY_ONE(function)                                                       \
  template <class Abi>                                                                                    \
  requires(!std::same_as<Abi, simd_abi::scalar>) simd<double, Abi> function(const simd<double, Abi>& x) { \
    const auto far = !(abs(x) < 800.0);                                                                   \
    if (none_of(far)) return function<double, Abi>(x);                                                    \
    simd<double, Abi> near = x;                                                                           \
    for (std::size_t k = 0; k < near.size(); ++k)                                                         \
      if (far[k]) near[k] = 0.0;                                                                          \
    simd<double, Abi> result = function<double, Abi>(near);                                               \
    for (std::size_t k = 0; k < near.size(); ++k)                                                         \
      if (far[k]) result[k] = std::function(double(x[k]));                                                \
    return result;                                                                                        \
  }
SEMIEXPLICIT_FAR_LANES_ONE_BY_ONE(sin)
SEMIEXPLICIT_FAR_LANES_ONE_BY_ONE(cos)
#undef SEMIEXPLICIT_FAR_LANES_ONE_BY_ONE
}  // namespace parallelism_v2
}  // namespace std::experimental
#endif

namespace semiexplicit {

#ifdef __cpp_lib_experimental_parallel_simd
/// How many numbers a register of the target holds: for double 8 with AVX-512 (4 by clang++), 4 with AVX2, 2
/// with neither; 1 where the standard library has no packs.
template <class Scalar>
inline constexpr std::size_t native_width = std::experimental::native_simd<Scalar>::size();

/// `Width` numbers side by side; arithmetic, sqrt, sin and so on go lane by lane. Eight, as for the stages of
/// a Gauss method, are one register with AVX-512 and several without.
template <class Scalar, std::size_t Width = 8>
using Pack = std::experimental::simd<Scalar, std::experimental::simd_abi::deduce_t<Scalar, Width>>;

namespace detail {
inline constexpr auto aligned = std::experimental::vector_aligned;
inline constexpr auto unaligned = std::experimental::element_aligned;
}  // namespace detail
#else
template <class Scalar>
inline constexpr std::size_t native_width = 1;
template <class Scalar, std::size_t Width = 8>
using Pack = detail::ArrayPack<Scalar, Width>;

namespace detail {
inline constexpr struct { } aligned, unaligned; }  // namespace detail
#endif

namespace detail {

/// A pack is a number to Eigen, too: columns of packs are what a Hamiltonian of packs takes.
template <class Pack>
struct PackTraits : Eigen::GenericNumTraits<Pack> {
  using Scalar = typename Pack::value_type;
  using Real = Pack;
  using NonInteger = Pack;
  using Nested = Pack;
  using Literal = Scalar;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
  static Real epsilon() { return Eigen::NumTraits<Scalar>::epsilon(); }
  static Real dummy_precision() { return Eigen::NumTraits<Scalar>::dummy_precision(); }
  static Real highest() { return Eigen::NumTraits<Scalar>::highest(); }
  static Real lowest() { return Eigen::NumTraits<Scalar>::lowest(); }
  static int digits10() { return Eigen::NumTraits<Scalar>::digits10(); }
};

}  // namespace detail
}  // namespace semiexplicit

namespace Eigen {
#ifdef __cpp_lib_experimental_parallel_simd
template <class Scalar, class Abi>
struct NumTraits<std::experimental::simd<Scalar, Abi>>
    : semiexplicit::detail::PackTraits<std::experimental::simd<Scalar, Abi>> {};
#else
template <class Scalar, std::size_t Width>
struct NumTraits<semiexplicit::detail::ArrayPack<Scalar, Width>>
    : semiexplicit::detail::PackTraits<semiexplicit::detail::ArrayPack<Scalar, Width>> {};
#endif
}  // namespace Eigen

namespace semiexplicit {

/// As many as one register holds, as for the members of an ensemble. (Packs of several registers g++ 12
/// copies clumsily.)
template <class Scalar>
using RegisterPack = Pack<Scalar, native_width<Scalar>>;

/// Optional: the gradient of eight phase points at once, one a lane, on arrays of packs. A gradient whose
/// arguments are templates, and which does no more than index them, has it for nothing. H says so by `using
/// PackGradientOf = H;`:
///
///     using PackGradientOf = Product;
///     template <class Q, class D>
///     void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
///       dHdq[0] = q[0] * (p[0] * p[0] + 1.0);
///       dHdp[0] = p[0] * (q[0] * q[0] + 1.0);
///     }
template <class H>
concept HasPackGradient = Hamiltonian<H> && std::same_as<typename H::PackGradientOf, H> &&
    requires(const H& h, const Pack<typename H::Scalar>* at, Pack<typename H::Scalar>* gradient) {
  h.gradient(at, at, gradient, gradient);
};

namespace detail {

using Many = RegisterPack<double>;
using LaneMask = Many::mask_type;

/// to = from in the chosen lanes.
inline void assign(const LaneMask& lanes, Many& to, const Many& from) {
#ifdef __cpp_lib_experimental_parallel_simd
  where(lanes, to) = from;
#else
  for (std::size_t k = 0; k < Many::size(); ++k)
    if (lanes[k]) to[k] = double(from[k]);
#endif
}

inline Many square_of(const Many& x) { return x * x; }
inline Many squares_of_block(const Many* v, Eigen::Index n) {
  return sum_in_four<Many>(0, n, [v](Eigen::Index i) { return square_of(v[i]); });
}
/// v · v in each lane, summed in the order of dot().
inline Many squares(const Many* v, Eigen::Index n) {
  if (n <= long_sum) return squares_of_block(v, n);
  Many sum = 0.0;
  const Eigen::Index block = block_of_sum(n);
  for (Eigen::Index i = 0; i < n; i += block) sum += squares_of_block(v + i, std::min(block, n - i));
  return sum;
}

/// √x. g++ 12 suspects an uninitialised variable in its own AVX-512 intrinsic.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
inline Many square_root(const Many& x) { return sqrt(x); }
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

/// The norms of all lanes, by the operations of the norm of a vector and in their order.
inline Many norm(const Many* v, Eigen::Index n) {
  const Many squared = squares(v, n);
  constexpr double small = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  constexpr double large = std::numeric_limits<double>::max() * std::numeric_limits<double>::epsilon();
  const LaneMask plain = (squared >= small && squared <= large) || squared != squared;
  Many result = square_root(squared);
  if (all_of(plain)) return result;
  // Some lane's squares have no room in the exponent.
  Many largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) largest = max(largest, abs(v[i]));
  Many unit = largest;
  assign(largest == 0.0, unit, 1.0);
  const auto scaled_square = [&](Eigen::Index i) { return square_of(v[i] / unit); };
  Many rescaled = largest * square_root(sum_in_four<Many>(0, n, scaled_square));
  assign(!isfinite(largest), rescaled, largest);
  assign(!plain, result, rescaled);
  return result;
}

}  // namespace detail

}  // namespace semiexplicit
