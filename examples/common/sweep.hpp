#pragma once

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

#include "table.hpp"

namespace examples {

using namespace semiexplicit;

/// A uniform number in [0, 1): the n-th of the stream of a seed, without those before it. SplitMix64: G. L. Steele, D. Lea, C. H.
/// Flood, OOPSLA 2014.
inline double uniform(std::uint64_t seed, std::uint64_t n) {
  std::uint64_t x = seed * 0xd1342543de82ef95u + (n + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

/// Four point vortices: three of circulation 1 on the corners of an equilateral triangle, which by itself turns for ever, and a
/// fourth that disturbs them, at random in a square. Alone, the three are integrable; the four are not: H. Aref, N. Pomphrey,
/// Proc. R. Soc. A 380 (1982) 359.
struct Sweep {
  std::int64_t members = 100'000, seed = 1;
  double dt = 0.1, time = 1000, strength = 1, extent = 2.5;

  /// What comes of a member, in this order in memory and files. Its place in the square; ‖z' - z‖/‖z‖, z' being
  /// the state after `time` forward and the same back, which rounding makes small for regular motion and of order one for chaotic (the
  /// reversibility error: F. Panichi, K. Goździewski, G. Turchetti, MNRAS 468 (2017) 469); the energy error at
  /// `time`, absolute, since a sum of logarithms has no zero that means anything; evaluations a step; and the Status, as a number. The errors are NaN where a step failed.
  static const std::vector<std::string>& columns() {
    static const std::vector<std::string> names{"x",           "y",     "reversibility_error", "energy_error",
                                                "evaluations", "status"};
    return names;
  }

  std::int64_t steps() const { return static_cast<std::int64_t>(std::round(time / dt)); }

  /// All that the results depend on.
  std::string in_words() const {
    return "vortices, members " + std::to_string(members) + ", seed " + std::to_string(seed) + ", dt " +
           exact(dt) + ", time " + exact(time) + ", strength " + exact(strength) + ", extent " +
           exact(extent);
  }

  /// The results of members first ... last - 1, a row each.
  std::vector<double> run(std::int64_t first, std::int64_t last, int threads) const {
    const systems::PointVortices<double, 4> vortices(Eigen::Vector4d{1, 1, 1, strength});
    std::vector<PhasePoint<double, 4>> starts;
    for (std::int64_t i = first; i < last; ++i) {
      const Eigen::Vector2d place = fourth(i);
      const double h = std::sqrt(0.75);
      starts.push_back(vortices.phase_point({0, -h, h, place.x()}, {1, -0.5, -0.5, place.y()}));
    }
    Ensemble ensemble(vortices, starts, schemes::low_defect6_s13<double>());
    ensemble.run({.dt = dt, .steps = steps(), .threads = threads});
    Ensemble back = ensemble;
    back.run({.dt = -dt, .steps = steps(), .threads = threads});

    const auto energy = [&](const PhasePoint<double, 4>& z) { return vortices.energy(z.q(), z.p()); };
    std::vector<double> table;
    for (std::int64_t i = first; i < last; ++i) {
      const Eigen::Index k = i - first;
      const PhasePoint<double, 4>& start = starts[static_cast<std::size_t>(k)];
      const IntegrationReport& there = ensemble.report(k);
      const Status status = there.ok() ? back.report(k).status : there.status;
      double reversibility = std::nan(""), energy_error = reversibility;
      if (status == Status::success) {
        reversibility = (back.state(k).vector() - start.vector()).norm() / start.vector().norm();
        energy_error = std::abs(energy(ensemble.state(k)) - energy(start));
      }
      const Eigen::Vector2d place = fourth(i);
      table.insert(table.end(), {place.x(), place.y(), reversibility, energy_error,
                                 static_cast<double>(there.evaluations) / static_cast<double>(steps()),
                                 static_cast<double>(status)});
    }
    return table;
  }

 private:
  /// Where member i has its fourth vortex: this depends on nothing but the seed and i.
  Eigen::Vector2d fourth(std::int64_t i) const {
    const auto number = [&](std::uint64_t k) {
      return extent *
             (2 * uniform(static_cast<std::uint64_t>(seed), 2 * static_cast<std::uint64_t>(i) + k) - 1);
    };
    return {number(0), number(1)};
  }

  /// With all its digits.
  static std::string exact(double x) { return formatted("%.17g", x); }
};

}  // namespace examples
