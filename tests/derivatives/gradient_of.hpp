#pragma once

#include <semiexplicit/core/phase_point.hpp>

/// Both halves of H's gradient at z.
template <class H>
auto gradient_of(const H& h, const semiexplicit::PhasePoint<typename H::Scalar, H::Dof>& z) {
  auto result = z;
  h.gradient(z.q(), z.p(), result.q(), result.p());
  return result.vector();
}
