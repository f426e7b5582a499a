#pragma once

#include <cstddef>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/schemes/scheme.hpp>

namespace semiexplicit::detail {

/// The flows of a scheme in their order, A(a₀dt) B(b₀dt) A(a₁dt) ..., where A(t) and B(t) move what they work
/// on by a time t. The odd flow is the first one: behind the loop g++ would vectorise it together with what
/// follows, and take twice as long for it.
template <class Scalar, class A, class B>
SEMIEXPLICIT_INLINE void sweep(const Scheme<Scalar>& scheme, const Scalar& dt, const A& a, const B& b) {
  const std::size_t n = scheme.b.size();
  a(Scalar(dt * scheme.a[0]));
  for (std::size_t i = 0; i < n; ++i) {
    b(Scalar(dt * scheme.b[i]));
    a(Scalar(dt * scheme.a[i + 1]));
  }
}

/// The time of the k-th flow of that order, which is one of A where k is even.
template <class Scalar>
Scalar time_of_flow(const Scheme<Scalar>& scheme, const Scalar& dt, std::size_t k) {
  return dt * (k % 2 == 0 ? scheme.a[k / 2] : scheme.b[k / 2]);
}

}  // namespace semiexplicit::detail
