#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <string>
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
    double first = 0, t = 0, x = 0, y = 0, speed = 0, middle = 0;
    void visit_memory(CheckpointMemory& visit) {
      for (double* number : {&first, &t, &x, &y, &speed, &middle}) visit(*number);
    }
  };
  const auto seen = std::make_shared<Seen>();
  const auto kept = [](double x, double y) { return 1 / (x * x) + 1 / (y * y); };
  return {[=](double t, const auto& q, const auto& p) {  // its canonical coordinates are x and y themselves
            const double x = q[1], y = p[1];
            if (t == 0) seen->first = kept(x, y);
            if (t > 0) seen->speed = (x - seen->x) / (t - seen->t);
            seen->middle = (x + seen->x) / 2;
            seen->t = t;
            seen->x = x;
            seen->y = y;
          },
          memory_of(seen),
          [=](const Run&) -> std::vector<Figure> {
            const double x = seen->middle, y = 1 / std::sqrt(seen->first - 1 / (x * x));
            if (!std::isfinite(y))
              return {not_measured("speed along the wall", "the pair has not parted yet; give more --time")};
            return {
                compared("1/x² + 1/y² at the end", kept(seen->x, seen->y), 0, "at the start", seen->first),
                compared("speed along the wall at the end", seen->speed, 0, "Γ/(4πy)/(1 + y²/x²)",
                         1 / (4 * std::numbers::pi * y * (1 + y * y / (x * x))))};
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
