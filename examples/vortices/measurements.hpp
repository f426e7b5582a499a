#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/scene_choice.hpp"

namespace examples {

/// A pair of vortices, the second of circulation 1, that comes down to a wall: it parts there, and its halves
/// go along the wall, with 1/x² + 1/y² kept. Source: H. Lamb, Hydrodynamics (1932), article 155.
inline Measurement<Eigen::Dynamic> along_the_wall(const Choice& c) {
  if (!c.only({"pairs", "half_plane"})) return {};
  struct Seen {
    std::int64_t states = 0;
    double first = 0, step = 0, t = 0, y = 0;
    std::array<double, 5> x{};  // the last first
    void visit_memory(CheckpointMemory& visit) {
      visit(states);
      for (double* number : {&first, &step, &t, &y}) visit(*number);
      for (double& one : x) visit(one);
    }
  };
  const auto seen = std::make_shared<Seen>();
  const auto kept = [](double x, double y) { return 1 / (x * x) + 1 / (y * y); };
  return {[=](double t, const auto& q, const auto& p) {  // its canonical coordinates are x and y themselves
            if (seen->states++ == 0) seen->first = kept(q[1], p[1]);
            seen->step = t - std::exchange(seen->t, t);
            std::shift_right(seen->x.begin(), seen->x.end(), 1);
            seen->x[0] = q[1];
            seen->y = p[1];
          },
          memory_of(seen),
          [=](const Run&) -> std::vector<Figure> {
            const auto& [x, x1, x2, x3, x4] = seen->x;
            const double y = 1 / std::sqrt(seen->first - 1 / (x * x));
            if (seen->states < 5)
              return {not_measured("speed along the wall", "the run has too few steps; give a smaller --dt")};
            if (!std::isfinite(y))
              return {not_measured("speed along the wall", "the pair has not parted yet; give more --time")};
            // By the polynomials through the last places. Each next order tells what the one before leaves
            // open, but for places where that goes through zero.
            const double by_three = (3 * x - 4 * x1 + x2) / (2 * seen->step),
                         by_four = (11 * x - 18 * x1 + 9 * x2 - 2 * x3) / (6 * seen->step),
                         by_five = (25 * x - 48 * x1 + 36 * x2 - 16 * x3 + 3 * x4) / (12 * seen->step);
            // What is kept tells its own error, also where run and companion are off alike. The places and
            // times of short steps are rounded.
            const double now = kept(x, seen->y), strays = std::abs(now - seen->first);
            const double rounding = std::numeric_limits<double>::epsilon() *
                                    (7 * std::abs(x) + std::abs(by_four) * seen->t) / seen->step;
            return {compared("1/x² + 1/y² at the end", now, strays, "at the start", seen->first),
                    compared("speed along the wall at the end", by_four,
                             std::abs(by_four - by_three) + std::abs(by_five - by_four) +
                                 by_four * strays / seen->first + rounding,
                             "Γ/(4πy)/(1 + y²/x²)", 1 / (4 * std::numbers::pi * y * (1 + y * y / (x * x))))};
          }};
}

/// One vortex of circulation 1 in a disk.
inline Measurement<Eigen::Dynamic> about_the_centre(const Choice& c) {
  if (!c.on("disk")) return {};
  const auto turning = std::make_shared<Turning>();
  return {
      [=](double t, const auto& q, const auto& p) { turning->see(t, q[0], p[0]); }, memory_of(turning),
      [=, radius = c["radius"],
       background = c.on("rotation") ? c["rotation_rate"] : 0](const Run&) -> std::vector<Figure> {
        const double r = turning->mean_radius(),
                     expected = background + 1 / (2 * std::numbers::pi * (radius * radius - r * r));
        const std::string coarse = too_coarse(turning->largest(expected));
        if (!coarse.empty()) return {not_measured("turns at", coarse)};
        if (std::abs(turning->turned()) < 0.1)
          return {
              not_measured("turns at", "it has turned by less than a tenth of a radian; give more --time")};
        return {compared("turns at", turning->rate(), 0, "Γ/(2π(R² - r²)), with the background", expected)};
      }};
}

}  // namespace examples
