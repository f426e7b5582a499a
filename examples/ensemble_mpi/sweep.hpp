#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <string>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../common/arguments.hpp"
#include "../common/output.hpp"

namespace examples {

using namespace semiexplicit;

/// A uniform number in [0, 1): the n-th of the stream of a seed, without those before it. SplitMix64: G. L.
/// Steele, D. Lea, C. H. Flood, OOPSLA 2014.
inline double uniform(std::uint64_t seed, std::uint64_t n) {
  std::uint64_t x = seed * 0xd1342543de82ef95u + (n + 1) * 0x9e3779b97f4a7c15u;
  x = (x ^ (x >> 30)) * 0xbf58476d1ce4e5b9u;
  x = (x ^ (x >> 27)) * 0x94d049bb133111ebu;
  return static_cast<double>((x ^ (x >> 31)) >> 11) * 0x1p-53;
}

/// Four point vortices: three of circulation 1 on the corners of an equilateral triangle, which by itself
/// turns for ever, and a fourth that disturbs them, at random in a square. Alone, the three are integrable;
/// the four are not: H. Aref, N. Pomphrey, Proc. R. Soc. A 380 (1982) 359.
struct Sweep {
  std::int64_t members = 100'000, seed = 1;
  double dt = 0.1, time = 1000, strength = 1, extent = 2.5;

  /// What comes of a member, in this order in memory and files. Its place in the square; ‖z' - z‖/‖z‖, z'
  /// being the state after `time` forward and the same back, which rounding makes small for regular motion
  /// and of order one for chaotic (the reversibility error: F. Panichi, K. Goździewski, G. Turchetti, MNRAS
  /// 468 (2017) 469); the energy error at `time`, absolute, since a sum of logarithms has no zero that means
  /// anything; evaluations a step; and the Status, as a number. The errors are NaN where a step failed.
  static const std::vector<std::string>& columns() {
    static const std::vector<std::string> names{"x",           "y",     "reversibility_error", "energy_error",
                                                "evaluations", "status"};
    return names;
  }

  std::int64_t steps() const { return steps_in(time, dt); }

  /// All that the results depend on.
  std::string in_words() const {
    return "vortices, members " + std::to_string(members) + ", seed " + std::to_string(seed) + ", dt " +
           exact(dt) + ", time " + exact(time) + ", strength " + exact(strength) + ", extent " +
           exact(extent);
  }

  /// The results of members first ... last - 1, a row each.
  std::vector<double> run(std::int64_t first, std::int64_t last, int threads) const {
    const systems::PointVortices<double, 4> vortices(Eigen::Vector4d{1, 1, 1, strength});
    // Lanes wait for the slowest of their register, so members that will take alike many evaluations go side
    // by side: those with a pair of vortices at like distance.
    std::vector<std::int64_t> order(static_cast<std::size_t>(last - first));
    std::iota(order.begin(), order.end(), first);
    std::stable_sort(order.begin(), order.end(),
                     [&](std::int64_t i, std::int64_t j) { return nearest(i) < nearest(j); });
    std::vector<PhasePoint<double, 4>> starts;
    for (const std::int64_t i : order) {
      const Eigen::Vector2d place = fourth(i);
      starts.push_back(vortices.phase_point({x[0], x[1], x[2], place.x()}, {y[0], y[1], y[2], place.y()}));
    }
    Ensemble ensemble(vortices, starts, schemes::low_defect6_s13<double>());
    ensemble.run({.dt = dt, .steps = steps(), .threads = threads});
    Ensemble back = ensemble;
    back.run({.dt = -dt, .steps = steps(), .threads = threads});

    const auto energy = [&](const PhasePoint<double, 4>& z) { return vortices.energy(z.q(), z.p()); };
    std::vector<double> table(order.size() * columns().size());
    for (std::size_t n = 0; n < order.size(); ++n) {
      const auto k = static_cast<Eigen::Index>(n);
      const IntegrationReport& there = ensemble.report(k);
      const Status status = there.ok() ? back.report(k).status : there.status;
      double reversibility = std::nan(""), energy_error = reversibility;
      if (status == Status::success) {
        const auto& start = starts[n].vector();
        reversibility = (back.state(k).vector() - start).norm() / start.norm();
        energy_error = std::abs(energy(ensemble.state(k)) - energy(starts[n]));
      }
      const Eigen::Vector2d place = fourth(order[n]);
      const std::int64_t tried = there.steps + (there.ok() ? 0 : 1);
      const double row[] = {place.x(),
                            place.y(),
                            reversibility,
                            energy_error,
                            static_cast<double>(there.evaluations) / static_cast<double>(tried),
                            static_cast<double>(status)};
      std::copy(std::begin(row), std::end(row),
                table.begin() + (order[n] - first) * static_cast<std::int64_t>(columns().size()));
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

  /// The triangle.
  static constexpr double x[3] = {0, -0.8660254037844386, 0.8660254037844386}, y[3] = {1, -0.5, -0.5};
  double nearest(std::int64_t i) const {
    const Eigen::Vector2d place = fourth(i);
    double squared = (place - Eigen::Vector2d(x[0], y[0])).squaredNorm();
    for (int k : {1, 2}) squared = std::min(squared, (place - Eigen::Vector2d(x[k], y[k])).squaredNorm());
    return squared;
  }

  /// With all its digits.
  static std::string exact(double value) { return formatted("%.17g", value); }
};

}  // namespace examples
