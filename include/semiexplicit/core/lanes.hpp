#pragma once

#include <semiexplicit/core/hamiltonian.hpp>

// Where the target has registers wide enough to be worth it, and the compiler can shuffle them (g++ from 12 on, clang).
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

/// Optional, for a system so small that all its positions fit into one register, and all its momenta into another: the
/// gradient on registers, entry i in lane i. Lanes from Dof on are zero on entry and have to be zero on exit. The copies
/// then stay in registers through all kicks of a step. gradient() is needed all the same and must agree: H says that it
/// does by `using LaneGradientOf = H;`, which does not hold for a type that derives from H and changes gradient().
template <class H>
concept HasLaneGradient = Hamiltonian<H> && std::same_as<typename H::Scalar, double> &&
                          std::same_as<typename H::LaneGradientOf, H> &&(H::Dof > 0) &&
                          (H::Dof <= 8) &&
                          requires(const H& h, const Lanes& q, const Lanes& p, Lanes& dHdq, Lanes& dHdp) {
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
