#pragma once

#include <type_traits>

#include <Eigen/Core>

/// The energy of systems::NlsLattice, for any number of sites and any numbers.
inline constexpr auto lattice_energy = [](const auto& q, const auto& p) {
  typename std::decay_t<decltype(q)>::Scalar sum(0);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const auto density = q[i] * q[i] + p[i] * p[i];
    sum += density * density / 4;
    if (i > 0)
      sum -= (q[i - 1] * q[i - 1] - p[i - 1] * p[i - 1]) * (q[i] * q[i] - p[i] * p[i]) +
             4 * q[i - 1] * p[i - 1] * q[i] * p[i];
  }
  return sum;
};
