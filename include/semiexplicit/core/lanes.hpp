#pragma once

#include <type_traits>

#include <semiexplicit/core/hamiltonian.hpp>

// Where the target has registers wide enough to be worth it, and the compiler can shuffle them (g++ from 12
// on, clang).
#if defined(__AVX512F__) && defined(__has_builtin)
#if __has_builtin(__builtin_shufflevector)
#define SEMIEXPLICIT_HAS_LANES 1
#include <immintrin.h>
#endif
#endif

namespace semiexplicit {

#ifdef SEMIEXPLICIT_HAS_LANES
/// Eight doubles side by side; arithmetic goes lane by lane.
using Lanes = double __attribute__((vector_size(64)));

/// How many registers hold `dof` numbers.
constexpr int registers_for(int dof) { return (dof + 7) / 8; }

/// Optional, for a system so small that its positions fit into one or two registers, and its momenta into as
/// many: the gradient on registers, entry i in lane i % 8 of register i / 8. Lanes from Dof on are zero on
/// entry and have to be zero on exit. The copies then stay in registers through all kicks of a step.
/// gradient() is needed all the same and must agree: H says that it does by `using LaneGradientOf = H;`,
/// which does not hold for a type that derives from H and changes gradient().
template <class H>
concept HasLaneGradient = Hamiltonian<H> && std::same_as<typename H::Scalar, double> &&
                          std::same_as<typename H::LaneGradientOf, H> &&(H::Dof > 0) &&
                          (H::Dof <= 16) && requires(const H& h, const Lanes* at, Lanes* gradient) {
  h.lane_gradient(at, at, gradient, gradient);  // q, p, dHdq, dHdp: registers_for(Dof) registers each
};

namespace detail {

/// The lanes of register k that hold some of `dof` numbers.
constexpr __mmask8 lanes_of(int dof, int k) {
  return static_cast<__mmask8>(dof >= 8 * (k + 1) ? 0xff : (1 << (dof - 8 * k)) - 1);
}

/// Up to 16 numbers in registers; lanes beyond are zero.
template <int Dof>
void load_lanes(const double* from, Lanes* to) {
  for (int k = 0; k < registers_for(Dof); ++k) to[k] = _mm512_maskz_loadu_pd(lanes_of(Dof, k), from + 8 * k);
}
template <int Dof>
void store_lanes(const Lanes* from, double* to) {
  for (int k = 0; k < registers_for(Dof); ++k) _mm512_mask_storeu_pd(to + 8 * k, lanes_of(Dof, k), from[k]);
}

/// A phase point in registers: those of the positions, then those of the momenta.
template <int Dof>
struct LanePoint {
  static constexpr std::integral_constant<int, registers_for(Dof)> d{};
  Lanes data[std::size_t(2 * d)];

  void load(const double* z) {
    load_lanes<Dof>(z, data);
    load_lanes<Dof>(z + Dof, data + d);
  }
  void store(double* z) const {
    store_lanes<Dof>(data, z);
    store_lanes<Dof>(data + d, z + Dof);
  }
};

}  // namespace detail
#else
template <class H>
concept HasLaneGradient = false;
#endif

}  // namespace semiexplicit
