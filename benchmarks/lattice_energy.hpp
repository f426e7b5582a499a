#pragma once

#include <semiexplicit/derivatives.hpp>

namespace bench {

/// The energy of systems::NlsLattice of n sites as a user writes it who gives no derivatives: sums over sites
/// and bonds, for from_energy().
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

}  // namespace bench
