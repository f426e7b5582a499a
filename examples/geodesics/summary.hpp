#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <ostream>
#include <vector>

#include "../common/output.hpp"
#include "section.hpp"

namespace examples {

/// What came of all orbits of a section.
struct Summary {
  std::int64_t orbits = 0, chaotic = 0, fell = 0, left = 0, failed = 0, most_time = 0;
  std::size_t points = 0;
  std::optional<double> worst_energy{};  ///< of those that came through a step, whatever became of them

  explicit Summary(const std::vector<Orbit>& all) {
    for (const Orbit& orbit : all) {
      ++orbits;
      chaotic += orbit.chaotic() ? 1 : 0;
      fell += orbit.end == Orbit::End::fell ? 1 : 0;
      left += orbit.end == Orbit::End::left ? 1 : 0;
      failed += orbit.end == Orbit::End::failed ? 1 : 0;
      most_time += orbit.end == Orbit::End::most_time ? 1 : 0;
      points += orbit.points.size() / 2;
      if (orbit.measured() && !(worst_energy && orbit.worst_energy <= *worst_energy))
        worst_energy = orbit.worst_energy;
    }
  }

  void print(std::ostream& out, const Region& region) const {
    out << counted(orbits, "orbit") << ", " << chaotic << " of them chaotic (GALI_2 below 1e-8), " << fell
        << " fell into the hole, " << left << " left, " << failed << " failed\n";
    if (most_time > 0)
      out << most_time << " were given up, which took more than "
          << formatted("%.3g M a passage\n", region.most_time());
    out << "error of g^{μν} p_μ p_ν, at worst: "
        << (worst_energy ? formatted("%.1e", *worst_energy) : "not measured, no orbit came through a step")
        << '\n';
  }
};

/// What became of one orbit.
inline const char* describe(Orbit::End end) {
  switch (end) {
    case Orbit::End::all_passages:
      return "came to its end";
    case Orbit::End::fell:
      return "fell into the hole";
    case Orbit::End::left:
      return "left";
    case Orbit::End::failed:
      return "failed";
    case Orbit::End::most_time:
      return "was given up, since it hardly passes the equator";
  }
  return "";
}

}  // namespace examples
