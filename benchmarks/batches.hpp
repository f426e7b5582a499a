#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

/// What benchmarks share that compare two works in alternating batches.
namespace bench {

/// The wall-clock time of so many calls of work().
template <class Work>
double seconds(int times, const Work& work) {
  const auto start = std::chrono::steady_clock::now();
  for (int i = 0; i < times; ++i) work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// The value that a part q of the values, which are not empty, does not exceed: 0.5 gives the median.
inline double quantile(std::vector<double> values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

}  // namespace bench
