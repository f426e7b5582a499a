#pragma once

#include <algorithm>
#include <type_traits>

#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/core/threads.hpp>

/// The sums over all pairs of vortices, which are nearly all of the time that a vortex code takes: with rᵢ the positions,
///
///     sum_x[i] = Σ_{j≠i} Γⱼ (xᵢ - xⱼ)/‖rᵢ - rⱼ‖²,   and sum_y likewise.
namespace semiexplicit::systems::detail {

/// Circulations, and the factors that make positions of canonical coordinates: xᵢ = x_per_q[i] q[i], yᵢ = y_per_p[i] p[i].
template <class Scalar>
struct VortexScales {
  const Scalar *gamma, *x_per_q, *y_per_p;
};

/// 1/s. On AVX-512 registers the processor's estimate of 14 bits, whose error e = 1 - s r is then taken down to e⁴: dividing
/// registers would take as long as all the rest of a pair. Lanes outside of `wanted` get zero.
#ifdef SEMIEXPLICIT_HAS_LANES
inline Lanes reciprocal(const Lanes& s, __mmask8 wanted = 0xff) {
  const Lanes r = _mm512_maskz_rcp14_pd(wanted, s);
  const Lanes e = 1 - s * r;
  return (r + r * e) * (1 + e * e);
}
#endif
template <class T>
T reciprocal(const T& s) {
#ifdef SEMIEXPLICIT_HAS_LANES
  if constexpr (requires {
                  typename T::abi_type;
                  static_cast<__m512d>(s);
                }) {  // a Pack<double>
    const Lanes lanes = static_cast<__m512d>(s);
    return T(reciprocal(lanes));
  } else
#endif
    return T(1) / s;
}

/// Each pair once: half the divisions. vortices::Pairs, which adds to what is there, keeps its own loop over pairs: with one
/// for both either packs take 1.25 times as long or scenes 1.5 times.
template <class T, class Scalar>
void add_each_pair(Eigen::Index n, const VortexScales<Scalar>& of, const T* __restrict q,
                   const T* __restrict p, T* __restrict sum_x, T* __restrict sum_y) {
  for (Eigen::Index j = 1; j < n; ++j) {
    const T xj = q[j] * of.x_per_q[j], yj = p[j] * of.y_per_p[j];
    for (Eigen::Index i = 0; i < j; ++i) {
      const T dx = q[i] * of.x_per_q[i] - xj, dy = p[i] * of.y_per_p[i] - yj;
      const T inverse = reciprocal<T>(dx * dx + dy * dy);
      const T wx = dx * inverse, wy = dy * inverse;
      sum_x[i] += of.gamma[j] * wx;
      sum_y[i] += of.gamma[j] * wy;
      sum_x[j] -= of.gamma[i] * wx;
      sum_y[j] -= of.gamma[i] * wy;
    }
  }
}

/// Every i from `first` to `last` over one j at a time, which fills the SIMD lanes where there are many.
template <class T, class Scalar>
void add_rows(Eigen::Index first, Eigen::Index last, Eigen::Index n, const VortexScales<Scalar>& of,
              const T* __restrict q, const T* __restrict p, T* __restrict sum_x, T* __restrict sum_y) {
  for (Eigen::Index j = 0; j < n; ++j) {
    const Scalar gj = of.gamma[j];
    const T xj = q[j] * of.x_per_q[j], yj = p[j] * of.y_per_p[j];
    const auto add = [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) {
        const T dx = q[i] * of.x_per_q[i] - xj, dy = p[i] * of.y_per_p[i] - yj;
        const T weight = gj / (dx * dx + dy * dy);
        sum_x[i] += dx * weight;
        sum_y[i] += dy * weight;
      }
    };
    add(first, std::min(j, last));
    add(std::max(j + 1, first), last);
  }
}

#ifdef SEMIEXPLICIT_HAS_LANES
/// Eight vortices, one a lane, and what has been summed for them.
struct VortexBlock {
  Lanes x, y, sum_x = {}, sum_y = {};

  /// A vortex at (xj, yj) moves the `acting` lanes.
  void add(double xj, double yj, double gamma, __mmask8 acting) {
    const Lanes dx = x - xj, dy = y - yj, weight = gamma * reciprocal(dx * dx + dy * dy, acting);
    sum_x += dx * weight;
    sum_y += dy * weight;
  }
  /// The same, and what the block, of circulations `mine`, does to that vortex in return.
  void add(double xj, double yj, double gamma, const Lanes& mine, Lanes& reaction_x, Lanes& reaction_y) {
    const Lanes dx = x - xj, dy = y - yj, weight = reciprocal(dx * dx + dy * dy);
    const Lanes wx = dx * weight, wy = dy * weight;
    sum_x += gamma * wx;
    sum_y += gamma * wy;
    reaction_x -= mine * wx;
    reaction_y -= mine * wy;
  }
};

/// All lanes but the one where vortex j meets itself in the block from i on.
inline __mmask8 all_but_self(Eigen::Index j, Eigen::Index i) {
  return static_cast<__mmask8>(j >= i && j < i + 8 ? ~(1 << (j - i)) : 0xff);
}

/// The sums of the lanes of u and of v, in lanes 0 and 1; zeros beyond.
inline Lanes sums_of(const Lanes& u, const Lanes& v) {
  const Lanes pairs = __builtin_shufflevector(u, v, 0, 8, 2, 10, 4, 12, 6, 14) +
                      __builtin_shufflevector(u, v, 1, 9, 3, 11, 5, 13, 7, 15);
  const auto fours =
      __builtin_shufflevector(pairs, pairs, 0, 1, 2, 3) + __builtin_shufflevector(pairs, pairs, 4, 5, 6, 7);
  const auto sums = __builtin_shufflevector(fours, fours, 0, 1) + __builtin_shufflevector(fours, fours, 2, 3);
  return Lanes{sums[0], sums[1]};
}

/// Up to 16 vortices in registers.
template <int N>
void sum_vortex_pairs(const VortexScales<double>& of, const Lanes* q, const Lanes* p, Lanes* sum_x,
                      Lanes* sum_y) {
  namespace core = semiexplicit::detail;
  constexpr int size = registers_for(N);
  Lanes gamma[std::size_t(size)], scale_x[std::size_t(size)], scale_y[std::size_t(size)];
  core::load_lanes<N>(of.gamma, gamma);
  core::load_lanes<N>(of.x_per_q, scale_x);
  core::load_lanes<N>(of.y_per_p, scale_y);
  VortexBlock block[std::size_t(size)];
  alignas(64) double x[std::size_t(8 * size)], y[std::size_t(8 * size)];
  for (int k = 0; k < size; ++k) {
    block[k].x = q[k] * scale_x[k];
    block[k].y = p[k] * scale_y[k];
    _mm512_store_pd(x + 8 * k, block[k].x);
    _mm512_store_pd(y + 8 * k, block[k].y);
  }
  // One or two vortices beyond a full block get from it by reaction what would take ten evaluations of a nearly empty one.
  constexpr bool few_left = N == 9 || N == 10;
  if constexpr (few_left) {
    Lanes reaction_x[2] = {}, reaction_y[2] = {};
    for (int j = 0; j < 8; ++j) block[0].add(x[j], y[j], of.gamma[j], all_but_self(j, 0));
    for (int j = 8; j < N; ++j)
      block[0].add(x[j], y[j], of.gamma[j], gamma[0], reaction_x[j - 8], reaction_y[j - 8]);
    block[1].sum_x = sums_of(reaction_x[0], reaction_x[1]);
    block[1].sum_y = sums_of(reaction_y[0], reaction_y[1]);
    if constexpr (N == 10) {
      const double dx = x[8] - x[9], dy = y[8] - y[9], inverse = 1 / (dx * dx + dy * dy);
      const Lanes both{of.gamma[9] * inverse, -of.gamma[8] * inverse};
      block[1].sum_x += dx * both;
      block[1].sum_y += dy * both;
    }
  } else {
    for (int j = 0; j < N; ++j)
      for (int k = 0; k < size; ++k) block[k].add(x[j], y[j], of.gamma[j], all_but_self(j, 8 * k));
  }
  for (int k = 0; k < size; ++k) {
    // Lanes beyond the last vortex hold what one at the origin would feel.
    sum_x[k] = _mm512_maskz_mov_pd(core::lanes_of(N, k), block[k].sum_x);
    sum_y[k] = _mm512_maskz_mov_pd(core::lanes_of(N, k), block[k].sum_y);
  }
}

/// The vortices from `begin` to `end` of any number, in blocks of eight.
inline void add_in_lanes(Eigen::Index begin, Eigen::Index end, Eigen::Index n, const VortexScales<double>& of,
                         const double* q, const double* p, double* sum_x, double* sum_y) {
  constexpr Eigen::Index chunk = 64;
  double x[chunk], y[chunk];
  for (Eigen::Index first = 0; first < n; first += chunk) {
    const Eigen::Index others = std::min(chunk, n - first);
    for (Eigen::Index j = 0; j < others; ++j) {
      x[j] = q[first + j] * of.x_per_q[first + j];
      y[j] = p[first + j] * of.y_per_p[first + j];
    }
    for (Eigen::Index i = begin; i < end; i += 8) {
      const auto inside = static_cast<__mmask8>(end - i >= 8 ? 0xff : (1 << (end - i)) - 1);
      const auto load = [&](const double* from) -> Lanes { return _mm512_maskz_loadu_pd(inside, from + i); };
      VortexBlock block{load(q) * load(of.x_per_q), load(p) * load(of.y_per_p), load(sum_x), load(sum_y)};
      for (Eigen::Index j = 0; j < others; ++j)
        block.add(x[j], y[j], of.gamma[first + j], all_but_self(first + j, i));
      _mm512_mask_storeu_pd(sum_x + i, inside, block.sum_x);
      _mm512_mask_storeu_pd(sum_y + i, inside, block.sum_y);
    }
  }
}
#endif

/// From so many vortices on several threads gain. (Measured.)
inline constexpr Eigen::Index vortices_for_threads = 256;

/// sum_x and sum_y of n vortices, with numbers of any kind.
template <class T, class Scalar>
void sum_vortex_pairs(Eigen::Index n, const VortexScales<Scalar>& of, const T* __restrict q,
                      const T* __restrict p, T* __restrict sum_x, T* __restrict sum_y) {
  for (Eigen::Index i = 0; i < n; ++i) sum_x[i] = sum_y[i] = T(0);
#ifdef SEMIEXPLICIT_HAS_LANES
  if constexpr (std::is_same_v<T, double>)
    if (n >= 6)
      return in_parts(n, 8, vortices_for_threads, [&](Eigen::Index begin, Eigen::Index end) {
        add_in_lanes(begin, end, n, of, q, p, sum_x, sum_y);
      });
#endif
  if (n <= 16 || !std::is_floating_point_v<T>)  // packs fill the lanes by themselves
    return add_each_pair(n, of, q, p, sum_x, sum_y);
  // Blocks of rows, for loops of other lengths could round in another way.
  constexpr Eigen::Index block = 128;
  in_parts(n, block, vortices_for_threads, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; i += block)
      add_rows(i, std::min(i + block, end), n, of, q, p, sum_x, sum_y);
  });
}

}  // namespace semiexplicit::systems::detail
