#pragma once

#include <semiexplicit/core/inlined.hpp>

namespace semiexplicit::detail {

/// A rounded sum, and what rounding cut off.
template <class Scalar>
struct TwoSum {
  Scalar sum, lost;
};

/// a + b without error, whichever is larger.
///
/// Source: Knuth, The Art of Computer Programming, vol. 2, 4.2.2, theorem B.
template <class Scalar>
SEMIEXPLICIT_INLINE TwoSum<Scalar> two_sum(const Scalar& a, const Scalar& b) {
  const Scalar sum = a + b, moved = sum - a;
  return {sum, (a - (sum - moved)) + (b - moved)};
}

}  // namespace semiexplicit::detail
