#pragma once

#include <semiexplicit/core/hamiltonian.hpp>

#if defined(__AVX512F__) && (defined(__GNUC__) || defined(__clang__))
#define SEMIEXPLICIT_HAS_LANES 1
#include <immintrin.h>
#endif

namespace semiexplicit {

/// How many numbers of type Scalar one SIMD register of the target holds, where compiler and target have registers wide
/// enough to be worth it (AVX-512, g++ or clang); 0 elsewhere.
template <class Scalar>
inline constexpr int lane_count = 0;

#ifdef SEMIEXPLICIT_HAS_LANES
template <>
inline constexpr int lane_count<double> = 8;

/// Eight doubles side by side; arithmetic goes lane by lane.
using Lanes = double __attribute__((vector_size(64)));

/// Optional, for a system so small that all its positions fit into one register, and all its momenta into another: the
/// gradient on registers, entry i in lane i. Lanes from Dof on are zero on entry and have to be zero on exit. The copies
/// then stay in registers through all kicks of a step. gradient() is needed all the same, and must agree.
template <class H>
concept HasLaneGradient = Hamiltonian<H> && std::same_as<typename H::Scalar, double> && H::Dof >
0 && H::Dof <= 8 && requires(const H& h, const Lanes& q, const Lanes& p, Lanes& dHdq, Lanes& dHdp) {
  h.lane_gradient(q, p, dHdq, dHdp);
};

namespace detail {

/// A phase point in two registers.
template <int Dof>
struct LanePoint {
  Lanes q, p;

  static LanePoint load(const double* z) {
    return {_mm512_maskz_loadu_pd(mask, z), _mm512_maskz_loadu_pd(mask, z + Dof)};
  }
  void store(double* z) const {
    _mm512_mask_storeu_pd(z, mask, q);
    _mm512_mask_storeu_pd(z + Dof, mask, p);
  }

 private:
  static constexpr __mmask8 mask = static_cast<__mmask8>((1 << Dof) - 1);
};

}  // namespace detail
#else
template <class H>
concept HasLaneGradient = false;
#endif

}  // namespace semiexplicit
