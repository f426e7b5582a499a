#pragma once

#include <semiexplicit/core/hamiltonian.hpp>

// Not in every standard library (libstdc++ has it from version 11 on).
#if defined(__has_include)
#if __has_include(<experimental/simd>)
#include <experimental/simd>
#ifdef __cpp_lib_experimental_parallel_simd
#define SEMIEXPLICIT_HAS_PACKS 1
#endif
#endif
#endif

namespace semiexplicit {

#ifdef SEMIEXPLICIT_HAS_PACKS
/// Eight numbers side by side; arithmetic, sqrt, sin and so on go lane by lane. One register with AVX-512, several without.
template <class Scalar>
using Pack = std::experimental::simd<Scalar, std::experimental::simd_abi::deduce_t<Scalar, 8>>;

/// Optional: the gradient of eight phase points at once, one a lane, on arrays of packs. A gradient whose arguments are
/// templates, and which does no more than index them, has it for nothing. H says so by `using PackGradientOf = H;`:
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
#else
template <class H>
concept HasPackGradient = false;
#endif

}  // namespace semiexplicit
