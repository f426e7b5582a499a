#pragma once

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include <semiexplicit/core/report.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/systems/kepler_flow.hpp>
#include <semiexplicit/systems/nbody.hpp>

namespace semiexplicit::effects::nbody {

/// Kepler's motion of each body about those within, the exact flow of Kinetic + Attraction. Two bodies (not
/// the primary) that are, or within the time would come, on straight lines, closer than
/// Attraction::hill_radii mutual Hill radii are refused with Status::close_encounter: the interaction is not
/// small then, and a step of a splitting does not resolve it.
template <class Scalar = double>
class KeplerFlows {
 public:
  /// Throws std::invalid_argument where hill_radii is below 0 or NaN.
  KeplerFlows(const Bodies<Scalar>& bodies, const Scalar& hill_radii) : bodies_(bodies) {
    using std::cbrt;
    if (!(hill_radii >= 0))
      throw std::invalid_argument("nbody: hill_radii of Attraction is negative or NaN; give 0 or more");
    for (Eigen::Index k = 1; hill_radii > 0 && k < bodies.size(); ++k)
      for (Eigen::Index j = 0; j < k; ++j)
        limits_.push_back(
            j == 0 ? Scalar(0)
                   : Scalar(hill_radii / 2 * cbrt((bodies.gm(j) + bodies.gm(k)) / (3 * bodies.gm(0)))));
  }

  /// See ExactFlow.
  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    if (!limits_.empty() && encounter(t, q, p)) return Status::close_encounter;
    for (Eigen::Index i = 1; i < bodies_.size(); ++i) {
      // By division: with a rounded 1/μ the same error in every call would make the energy drift.
      const auto x = detail::triple(q, i);
      auto w = detail::triple(p, i), dx = x, dw = w;
      for (Scalar& of_w : w.of) of_w /= bodies_.reduced(i);
      const Status status = orbits::KeplerFlow<Scalar, 3>{bodies_.up_to(i)}.increments(t, x, w, dx, dw);
      if (status != Status::success) return status;
      for (Eigen::Index k = 0; k < 3; ++k) {
        dq[3 * i - 3 + k] = dx[k];
        dp[3 * i - 3 + k] = bodies_.reduced(i) * dw[k];
      }
    }
    return Status::success;
  }

 private:
  /// Is there a pair whose distance, squared, gets below its limit?
  bool encounter(const Scalar& t, const auto& q, const auto& p) const {
    using std::sqrt;
    bool found = false;
    std::size_t pair = 0;
    const auto length = [&](Eigen::Index i) {
      const auto x = detail::triple(q, i);
      return sqrt(detail::dot(x, x));
    };
    // The relative velocities are sums of p as the distances are of q.
    Scalar outer(0);
    detail::Triple<Scalar> all{Scalar(0), Scalar(0), Scalar(0)}, sum = all, at = all;
    Eigen::Index last = 0;
    detail::for_each_pair(
        bodies_, q,
        [&](Eigen::Index j, Eigen::Index k, const detail::Triple<Scalar>& d) {
          if (k != last) {
            last = k;
            at = velocity(p, k);
            sum = all;
            outer = length(k);
          }
          if (j == 0) {
            ++pair;
            return;
          }
          const detail::Triple<Scalar> other = velocity(p, j);
          detail::Triple<Scalar> w;
          for (Eigen::Index i = 0; i < 3; ++i) {
            w[i] = at[i] + (sum[i] - other[i]);
            sum[i] -= bodies_.share(j) * other[i];
          }
          const Scalar limit = limits_[pair++] * (outer + length(j)), d2 = detail::dot(d, d),
                       dw = detail::dot(d, w), w2 = detail::dot(w, w);
          Scalar nearest = d2;  // at s = -d·w/w² where that is on the way
          if (dw * t < 0) {
            const bool passes = -dw * (t < 0 ? -1 : 1) < w2 * (t < 0 ? -t : t);
            nearest = passes ? Scalar(d2 - dw * dw / w2) : Scalar(d2 + t * (2 * dw + t * w2));
          }
          if (nearest < limit * limit) found = true;
        },
        [&](Eigen::Index k) {
          for (Eigen::Index i = 0; i < 3; ++i) all[i] += bodies_.share(k) * at[i];
        });
    return found;
  }
  detail::Triple<Scalar> velocity(const auto& p, Eigen::Index i) const {
    detail::Triple<Scalar> w = detail::triple(p, i);
    for (Scalar& of_w : w.of) of_w /= bodies_.reduced(i);
    return w;
  }

  Bodies<Scalar> bodies_;
  std::vector<Scalar> limits_;  ///< of the pairs, per sum of the distances; empty: none
};

}  // namespace semiexplicit::effects::nbody

namespace semiexplicit {

/// See KeplerFlows.
template <class Scalar, int Dof>
struct ExactFlow<effects::nbody::Kinetic<Scalar, Dof>, effects::nbody::Attraction<Scalar, Dof>>
    : effects::nbody::KeplerFlows<Scalar> {
  static constexpr const char* name = "Kepler, each body about those within";
  static constexpr bool quadratic_in_momenta = true;
  ExactFlow(const effects::nbody::Kinetic<Scalar, Dof>&,
            const effects::nbody::Attraction<Scalar, Dof>& attraction)
      : effects::nbody::KeplerFlows<Scalar>(attraction.bodies, attraction.hill_radii) {}
};

}  // namespace semiexplicit
