#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/core/threads.hpp>
#include <semiexplicit/steppers/detail/for_each_index.hpp>
#include <semiexplicit/steppers/detail/sweep.hpp>
#include <semiexplicit/steppers/detail/waves.hpp>

namespace semiexplicit::detail {

/// x, which compilers cannot see through where Size is a small constant: they would pack the few numbers of a
/// kick into registers, and spend more on the shuffles between one kick and the next than they gain; and they
/// would read in one piece what was just written number by number, which then waits for all of that to arrive
/// in the cache.
template <class Size, class Number>
SEMIEXPLICIT_INLINE Number apart(Number x) {
#if defined(__GNUC__) && defined(__x86_64__)
  if constexpr (is_small_constant<Size> && (std::same_as<Number, double> || std::same_as<Number, float>))
    asm("" : "+v"(x));
#endif
  return x;
}

/// Dual numbers, which move a point and its tangent vectors.
template <class Number, class Scalar>
concept MovesVectors = requires(Number& to, const Scalar& t, const Number& slope) {
  to.add_multiple(t, slope);
};

/// to += t slope.
template <class Size, class Scalar, class Number>
SEMIEXPLICIT_INLINE void add_multiple(Number& to, const Scalar& t, const Number& slope) {
  if constexpr (MovesVectors<Number, Scalar>)
    to.add_multiple(t, slope);
  else
    to = apart<Size, Number>(to + t * slope);
}

/// to += t X, and likewise the sums, in `size` places, where X = (∂H/∂p, -∂H/∂q) and momenta lie d places
/// after positions. Plain loops over raw pointers: compilers vectorise these, and not the equivalent Eigen
/// expression on the halves of a vector of odd fixed size. Each sum is one expression, which clang++ makes
/// one fused operation where there are some.
template <class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void add_halves(const Scalar& t, const Number* __restrict dHdq,
                                    const Number* __restrict dHdp, Number* __restrict to, Size size,
                                    Eigen::Index d, Sum* __restrict... sum) {
  using OfSum = std::conditional_t<sums_are_small<Size>, Size, Eigen::Index>;
  const Scalar minus_t = -t;
  for_each_index(size, [&](Eigen::Index i) {
    const Number& slope = dHdp[i];
    add_multiple<Size>(to[i], t, slope);
    (add_multiple<OfSum>(sum[i], t, slope), ...);
  });
  for_each_index(size, [&](Eigen::Index i) {
    const Number& slope = dHdq[i];
    add_multiple<Size>(to[d + i], minus_t, slope);
    (add_multiple<OfSum>(sum[d + i], minus_t, slope), ...);
  });
}
/// The same with both halves of the gradient in a row.
template <class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void add(const Scalar& t, const Number* gradient, Number* to, Size size, Eigen::Index d,
                             Sum*... sum) {
  add_halves(t, gradient, gradient + size, to, size, d, sum...);
}
/// And in long vectors, by threads.
template <class Scalar, class Number, class... Sum>
SEMIEXPLICIT_NOINLINE void add_many(const Scalar& t, const Number* gradient, Number* to, Eigen::Index d,
                                    Sum*... sum) {
  in_parts(d, 64, long_loop, [&](Eigen::Index begin, Eigen::Index end) {
    add_halves(t, gradient + begin, gradient + d + begin, to + begin, end - begin, d, (sum + begin)...);
  });
}

/// The gradient at a phase point of 2d numbers: those of H, or packs of them (HasPackGradient), or the
/// registers of HasLaneGradient.
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

/// A range gradient of the numbers of H, or of dual numbers where it is a template.
template <class H, class Number>
concept HasRangeGradientOn = HasRangeGradient<H> &&
    (std::same_as<Number, typename H::Scalar> ||
     MovesVectors<Number, typename H::Scalar>)&&requires(const H& h, Eigen::Index i, const Number* at,
                                                         Number* gradient) {
  h.gradient_range(i, i, at, at, gradient, gradient);
};

/// So many sites of a large system stay in the cache together; all steppers kick the same blocks, whose
/// numbers then have the same bits.
inline constexpr Eigen::Index kick_block = 64;

/// A kick of the blocks of a large system from `begin` to `end`. Not inlined: g++ vectorises the loops on
/// their own, and not within the sweep. `gradient` is work space for one block.
template <class H, class Scalar, class Number, class... Sum>
SEMIEXPLICIT_NOINLINE void kick_blocks(const H& hamiltonian, const Scalar& t, const Number* __restrict from,
                                       Number* __restrict to, Number* __restrict gradient, Eigen::Index begin,
                                       Eigen::Index end, Eigen::Index d, Sum* __restrict... sum) {
  for (Eigen::Index i = begin; i < end; i += kick_block) {
    const Eigen::Index size = std::min(kick_block, end - i);
    inlined<Scalar>(
        [&] { hamiltonian.gradient_range(i, i + size, from, from + d, gradient, gradient + size); });
    add(t, gradient, to + i, size, d, (sum + i)...);
  }
}

/// The same of all, by threads. (Measured: from so many sites on they gain, where a site reads two
/// neighbours.)
template <class H, class Scalar, class Number, class... Sum>
void kick_in_blocks(const H& hamiltonian, const Scalar& t, const Number* from, Number* to, Number* gradient,
                    Eigen::Index d, Sum*... sum) {
  constexpr Eigen::Index least = 16384;
  if (d < least) return kick_blocks(hamiltonian, t, from, to, gradient, Eigen::Index(0), d, d, sum...);
  in_parts(d, kick_block, least, [&](Eigen::Index begin, Eigen::Index end) {
    kick_blocks(hamiltonian, t, from, to, gradient + 2 * begin, begin, end, d, sum...);
  });
}

/// One kick of the doubled system: `to`, and the sums, move by t X(from). `gradient` is work space, 2d
/// numbers.
template <class H, class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void kick(const H& hamiltonian, const Scalar& t, const Number* from, Number* to,
                              Number* gradient, Size d, Sum*... sum) {
  if constexpr (HasRangeGradientOn<H, Number>)
    if (d > kick_block) return kick_in_blocks(hamiltonian, t, from, to, gradient, Eigen::Index(d), sum...);
  gradient_on(hamiltonian, from, gradient, d);
  if constexpr (std::same_as<Size, Eigen::Index>)
    if (d > long_loop) return add_many(t, gradient, to, d, sum...);
  add(t, gradient, to, d, d, sum...);
}

/// All kicks of a step on two copies of a phase point. A is the exact flow of H(q, y) and B that of H(x, p):
/// with a = (q, y) and b = (x, p), each moves one copy along the vector field at the other, which rests.
template <class H, class Scalar, class Number, class Size, class... Sum>
SEMIEXPLICIT_INLINE void kicks(const H& hamiltonian, const Scheme<Scalar>& scheme, const Scalar& dt,
                               Number* a, Number* b, Number* gradient, Size d, Sum*... sum) {
  sweep(
      scheme, dt,
      [&](const Scalar& t) SEMIEXPLICIT_INLINE_KICK { kick(hamiltonian, t, a, b, gradient, d, sum...); },
      [&](const Scalar& t) SEMIEXPLICIT_INLINE_KICK { kick(hamiltonian, t, b, a, gradient, d, sum...); });
}

/// What a step does before and after all kicks, on the numbers from `begin` to `end`: a = z + m and b = z -
/// m, m being null for 0, and the residual f = a - b + 2m with `moved`, which is the sum of the increments,
/// or found from the copies.
template <class Number>
struct ProjectionEnds {
  const Number *z, *m;
  Number *a, *b, *moved, *f;
  bool summed;

  template <class Size>
  SEMIEXPLICIT_INLINE void load(Eigen::Index begin, Size size) const {
    const Number *const z_ = z + begin, *const m_ = m ? m + begin : nullptr;
    Number *const a_ = a + begin, *const b_ = b + begin, *const moved_ = moved + begin;
    if (m_)
      for_each_index(size, [&](Eigen::Index i) {
        a_[i] = z_[i] + m_[i];
        b_[i] = z_[i] - m_[i];
      });
    else
      for_each_index(size, [&](Eigen::Index i) { a_[i] = b_[i] = z_[i]; });
    if (summed) for_each_index(size, [&](Eigen::Index i) { moved_[i] = Number{}; });
  }
  template <class Size>
  SEMIEXPLICIT_INLINE void finish(Eigen::Index begin, Size size) const {
    const Number *const z_ = z + begin, *const m_ = m ? m + begin : nullptr, *const a_ = a + begin,
                        *const b_ = b + begin;
    Number *const moved_ = moved + begin, *const f_ = f + begin;
    if (!summed) for_each_index(size, [&](Eigen::Index i) { moved_[i] = (a_[i] - z_[i]) + (b_[i] - z_[i]); });
    if (m_)
      for_each_index(size, [&](Eigen::Index i) { f_[i] = a_[i] - b_[i] + (m_[i] + m_[i]); });
    else
      for_each_index(size, [&](Eigen::Index i) { f_[i] = a_[i] - b_[i]; });
  }
};

/// projection_residual() of a large system with near neighbours only, block by block through all kicks; the
/// same operations.
template <class H, class Scalar, class... Sum>
SEMIEXPLICIT_NOINLINE void projection_in_waves(const H& hamiltonian, const Scheme<Scalar>& scheme,
                                               const Scalar& dt, const ProjectionEnds<Scalar>& ends,
                                               Waves waves, Eigen::Index d, Sum*... sum) {
  const auto kicks = static_cast<Eigen::Index>(scheme.kicks());
  in_waves(waves, kicks + 2, d, [&](Eigen::Index stage, Eigen::Index begin, Eigen::Index end) {
    if (stage == 0 || stage > kicks) {
      for (const Eigen::Index half : {begin, begin + d}) {
        if (stage == 0)
          ends.load(half, end - begin);
        else
          ends.finish(half, end - begin);
      }
    } else {
      const bool is_a = stage % 2 == 1;
      const Scalar t = time_of_flow(scheme, dt, static_cast<std::size_t>(stage - 1));
      Scalar gradient[2 * kick_block];  // always the same memory, in the nearest cache
      kick_blocks(hamiltonian, t, is_a ? ends.a : ends.b, is_a ? ends.b : ends.a, gradient, begin, end, d,
                  sum...);
    }
  });
}

/// The residual of the projection: all kicks from a = z + m, b = z - m (m = 0 where none is given); f becomes
/// a - b + 2m, and `moved` what both copies moved together. With `summed` that is summed apart from the
/// copies and has the rounding errors of the increments, else it has those of the copies.
template <class H, class Scalar, class Number, class Size>
SEMIEXPLICIT_INLINE void projection_residual(const H& hamiltonian, const Scheme<Scalar>& scheme,
                                             const Scalar& dt, bool summed, const Number* z, const Number* m,
                                             Number* a, Number* b, Number* gradient, Number* moved, Number* f,
                                             Size d) {
  const ProjectionEnds<Number> ends{z, m, a, b, moved, f, summed};
  if constexpr (HasLocalGradient<H> && std::same_as<Number, Scalar> && std::same_as<Size, Eigen::Index>)
    if (const Waves waves(d, static_cast<Eigen::Index>(scheme.kicks()) + 2, kick_block);
        waves.pay() && hamiltonian.reach() >= 0 && hamiltonian.reach() <= kick_block) {
      if (summed)
        projection_in_waves(hamiltonian, scheme, dt, ends, waves, d, moved);
      else
        projection_in_waves(hamiltonian, scheme, dt, ends, waves, d);
      return;
    }
  ends.load(0, twice_of(d));
  if (summed)
    kicks(hamiltonian, scheme, dt, a, b, gradient, d, moved);
  else
    kicks(hamiltonian, scheme, dt, a, b, gradient, d);
  ends.finish(0, twice_of(d));
}

/// A phase point on the stack: 2d numbers.
template <class Scalar, int Dof>
struct StackPoint {
  using Size = std::integral_constant<int, Dof>;
  static constexpr Size d{};
  Scalar data[std::size_t(2 * d)];

  void load(const Scalar* z) {
    for_each_index(twice_of(d), [&](Eigen::Index i) { data[i] = apart<Size, Scalar>(z[i]); });
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
