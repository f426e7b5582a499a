#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace semiexplicit::detail {

/// The middle one of some values, in the order of size; of an even number the upper. There must be one.
template <class T>
T median(std::vector<T> some) {
  const auto middle = some.begin() + static_cast<std::ptrdiff_t>(some.size() / 2);
  std::nth_element(some.begin(), middle, some.end());
  return *middle;
}

}  // namespace semiexplicit::detail
