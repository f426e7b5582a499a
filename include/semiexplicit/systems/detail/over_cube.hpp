#pragma once

#include <cmath>

namespace semiexplicit::detail {

/// k/r³ from r², without r³ itself, which is beyond the range of float in SI units.
template <class K, class Number>
auto over_cube(const K& k, const Number& r2) {
  using std::sqrt;
  const auto inverse2 = 1 / r2;
  return k * inverse2 * sqrt(inverse2);
}

}  // namespace semiexplicit::detail
