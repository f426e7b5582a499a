#pragma once

#include <type_traits>

#include <Eigen/Core>

#include <semiexplicit/derivatives.hpp>

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

/// The same of n sites as a user writes it who gives no derivatives: sums over sites and bonds, for
/// from_energy(). Benchmarks take it, too.
inline auto lattice_by_terms(Eigen::Index n) {
  return [n](const auto& q, const auto& p) {
    using semiexplicit::sum_over;
    return sum_over(n,
                    [&](auto i) {
                      const auto density = q[i] * q[i] + p[i] * p[i];
                      return density * density / 4;
                    }) -
           sum_over(n - 1, [&](auto i) {
             const auto u = q[i] * q[i] - p[i] * p[i], v = q[i] * p[i];
             const auto next_u = q[i + 1] * q[i + 1] - p[i + 1] * p[i + 1], next_v = q[i + 1] * p[i + 1];
             return u * next_u + 4 * (v * next_v);
           });
  };
}
