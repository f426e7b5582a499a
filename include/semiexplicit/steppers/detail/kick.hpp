#pragma once

#include <algorithm>
#include <concepts>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/steppers/detail/for_each_index.hpp>
#include <semiexplicit/steppers/detail/sweep.hpp>

namespace semiexplicit::detail {

/// x, which clang++ cannot see through where Size is a small constant: it would pack the few numbers of a kick into registers,
/// and spend more on the shuffles between one kick and the next than it gains.
template <class Size, class Number>
SEMIEXPLICIT_INLINE Number apart(Number x) {
#if defined(__clang__) && defined(__x86_64__)
  if constexpr (is_small_constant<Size> && (std::same_as<Number, double> || std::same_as<Number, float>))
    asm("" : "+x"(x));
#endif
  return x;
}

/// to += t X, and likewise the sums, in `size` places, where X = (∂H/∂p, -∂H/∂q) and momenta lie d places after positions.
/// Plain loops over raw pointers: compilers vectorise these, and not the equivalent Eigen expression on the halves of a
/// vector of odd fixed size. Each sum is one expression, which clang++ makes one fused operation where there are some.
template <class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void add(const Scalar& t, const Number* __restrict gradient, Number* __restrict to,
                             Size size, Eigen::Index d, Sum* __restrict... sum) {
  for_each_index(size, [&](Eigen::Index i) {
    const Number slope = gradient[size + i];
    to[i] = apart<Size, Number>(to[i] + t * slope);
    ((sum[i] = apart<Size, Number>(sum[i] + t * slope)), ...);
  });
  for_each_index(size, [&](Eigen::Index i) {
    const Number slope = gradient[i];
    to[d + i] = apart<Size, Number>(to[d + i] - t * slope);
    ((sum[d + i] = apart<Size, Number>(sum[d + i] - t * slope)), ...);
  });
}

/// The gradient at a phase point of 2d numbers: those of H, or packs of them (HasPackGradient), or the registers of
/// HasLaneGradient.
template <class H, class Number>
SEMIEXPLICIT_INLINE SEMIEXPLICIT_INLINE_CALLS void gradient_on(const H& hamiltonian, const Number* at,
                                                               Number* gradient, Eigen::Index d) {
  if constexpr (std::same_as<Number, typename H::Scalar>)
    gradient_at(hamiltonian, at, gradient, d);
  else if constexpr (requires { hamiltonian.lane_gradient(at, at, gradient, gradient); })
    hamiltonian.lane_gradient(at, at + d, gradient, gradient + d);
  else {
    const Number *const q = at, *const p = at + d;  // named, for gradients that deduce one type for both
    Number *const dHdq = gradient, *const dHdp = gradient + d;
    hamiltonian.gradient(q, p, dHdq, dHdp);
  }
}

/// A kick of a large system in blocks that stay in the cache. Not inlined: g++ vectorises the loops on their own, and not
/// within the sweep.
template <class H, class Scalar, class... Sum>
SEMIEXPLICIT_NOINLINE void kick_in_blocks(const H& hamiltonian, const Scalar& t,
                                          const Scalar* __restrict from, Scalar* __restrict to,
                                          Scalar* __restrict gradient, Eigen::Index block, Eigen::Index d,
                                          Sum* __restrict... sum) {
  for (Eigen::Index begin = 0; begin < d; begin += block) {
    const Eigen::Index size = std::min(block, d - begin);
    hamiltonian.gradient_range(begin, begin + size, from, from + d, gradient, gradient + size);
    add(t, gradient, to + begin, size, d, (sum + begin)...);
  }
}

/// One kick of the doubled system: `to`, and the sums, move by t X(from). `gradient` is work space, 2d numbers.
template <class H, class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void kick(const H& hamiltonian, const Scalar& t, const Number* from, Number* to,
                              Number* gradient, Size d, Sum*... sum) {
  constexpr Eigen::Index block = 64;
  if constexpr (HasRangeGradient<H> && std::same_as<Number, Scalar>)
    if (d > block) return kick_in_blocks(hamiltonian, t, from, to, gradient, block, d, sum...);
  gradient_on(hamiltonian, from, gradient, d);
  add(t, gradient, to, d, d, sum...);
}

/// All kicks of a step on two copies of a phase point. A is the exact flow of H(q, y) and B that of H(x, p): with a = (q, y)
/// and b = (x, p), each moves one copy along the vector field at the other, which rests.
template <class H, class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void kicks(const H& hamiltonian, const Scheme<Scalar>& scheme, const Scalar& dt,
                               Number* a, Number* b, Number* gradient, Size d, Sum*... sum) {
  sweep(
      scheme, dt, [&](const Scalar& t) { kick(hamiltonian, t, a, b, gradient, d, sum...); },
      [&](const Scalar& t) { kick(hamiltonian, t, b, a, gradient, d, sum...); });
}

/// The residual of the projection: all kicks from a = z + m, b = z - m (m = 0 where none is given); f becomes a - b + 2m, and
/// `moved` what both copies moved together. With `summed` that is summed apart from the copies and has the rounding errors of
/// the increments, else it has those of the copies.
template <class H, class Scalar, class Number, class Size>
SEMIEXPLICIT_INLINE void projection_residual(const H& hamiltonian, const Scheme<Scalar>& scheme,
                                             const Scalar& dt, bool summed, const Number* z, const Number* m,
                                             Number* a, Number* b, Number* gradient, Number* moved, Number* f,
                                             Size d) {
  const auto size = twice_of(d);
  if (m)
    for_each_index(size, [&](Eigen::Index i) {
      a[i] = z[i] + m[i];
      b[i] = z[i] - m[i];
    });
  else
    for_each_index(size, [&](Eigen::Index i) { a[i] = b[i] = z[i]; });
  if (summed) {
    for_each_index(size, [&](Eigen::Index i) { moved[i] = Number{}; });
    kicks(hamiltonian, scheme, dt, a, b, gradient, d, moved);
  } else {
    kicks(hamiltonian, scheme, dt, a, b, gradient, d);
    for_each_index(size, [&](Eigen::Index i) { moved[i] = (a[i] - z[i]) + (b[i] - z[i]); });
  }
  if (m)
    for_each_index(size, [&](Eigen::Index i) { f[i] = a[i] - b[i] + (m[i] + m[i]); });
  else
    for_each_index(size, [&](Eigen::Index i) { f[i] = a[i] - b[i]; });
}

/// A phase point on the stack: 2d numbers.
template <class Scalar, int Dof>
struct StackPoint {
  static constexpr std::integral_constant<int, Dof> d{};
  Scalar data[std::size_t(2 * d)];

  void load(const Scalar* z) {
    for_each_index(twice_of(d), [&](Eigen::Index i) { data[i] = z[i]; });
  }
  void store(Scalar* z) const {
    for_each_index(twice_of(d), [&](Eigen::Index i) { z[i] = data[i]; });
  }
};

/// What a step of an H that fits on the stack works on.
template <class H>
struct WorkPoint {
  using Type = StackPoint<typename H::Scalar, H::Dof>;
};
#ifdef SEMIEXPLICIT_HAS_LANES
template <HasLaneGradient H>
struct WorkPoint<H> {
  using Type = LanePoint<H::Dof>;
};
#endif

}  // namespace semiexplicit::detail
