#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit::detail {

/// What an error of a function of (q, p) is relative to.
template <class Scalar>
struct ReferenceSize {
  Scalar size = Scalar(1);   ///< |f(z)|, or 1 where f(z) is zero up to the rounding of its terms
  Scalar terms = Scalar(0);  ///< about the size of the terms that f(z) is the sum of
  bool relative = false;     ///< size is |f(z)|
};

/// The next of a fixed sequence of numbers that look random, from 1/2 to 1 in size, of either sign (Knuth's
/// MMIX generator).
inline double scattered(std::uint64_t& state) {
  state = state * 6364136223846793005U + 1442695040888963407U;
  const double size = 0.5 + 0.5 * static_cast<double>(state >> 12) * 0x1p-52;
  return (state >> 11) % 2 == 0 ? size : -size;
}

/// The largest finite distance(near) of four points `near` z, in which each entry is changed by about that
/// part of it.
template <class Scalar, int Dof, class F>
Scalar largest_beside(const PhasePoint<Scalar, Dof>& z, const Scalar& change, const F& distance) {
  using std::isfinite;
  Scalar largest(0);
  std::uint64_t random = 1;
  for (int attempt = 0; attempt < 4; ++attempt) {
    PhasePoint<Scalar, Dof> near = z;
    for (Eigen::Index i = 0; i < near.vector().size(); ++i)
      near.vector()[i] *= Scalar(1) + change * static_cast<Scalar>(scattered(random));
    const Scalar here = distance(near);
    if (isfinite(here)) largest = std::max(largest, here);
  }
  return largest;
}

/// The size that an error of f at z = (q, p), where it is `value`, is relative to. The terms' size is how far
/// f moves when all entries of z change by a small factor: four values of f, whatever the dimension. It is
/// that of 100 roundings: by far more a function that is quadratic in a small distance far from the origin
/// would have terms that it has not.
template <class Scalar, int Dof, class F>
ReferenceSize<Scalar> reference_size(const F& f, const Scalar& value, const PhasePoint<Scalar, Dof>& z) {
  using std::abs;
  using std::isfinite;
  const Scalar change = 100 * Eigen::NumTraits<Scalar>::epsilon();
  ReferenceSize<Scalar> result;
  if (!isfinite(value)) return result;
  result.terms = largest_beside(
      z, change, [&](const auto& near) { return Scalar(abs(f(near.q(), near.p()) - value) / change); });
  result.relative = abs(value) > change * result.terms;
  if (result.relative) result.size = abs(value);
  return result;
}

}  // namespace semiexplicit::detail
