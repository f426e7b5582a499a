#pragma once

#include <algorithm>

#include <semiexplicit/core/threads.hpp>

namespace semiexplicit::detail {

/// A part of the table of stages and tiles, in an order in which each comes after the stage before it in the same tile and its
/// neighbours, and before the stage after that in these. So the latest stages are near each other in memory, however many tiles
/// there are. At an inner end of the part every stage has one tile less than the one before, for its neighbour is not there.
template <class Stage>
void wave(Eigen::Index stages, Eigen::Index first, Eigen::Index last, bool inner_first, bool inner_last,
          const Stage& stage) {
  for (Eigen::Index front = first; front < last + stages - 1; ++front)
    for (Eigen::Index s = std::max<Eigen::Index>(0, front - last + 1); s < stages && front - s >= first;
         ++s) {
      const Eigen::Index b = front - s;
      if (b >= first + (inner_first ? s : 0) && b < last - (inner_last ? s : 0)) stage(s, b);
    }
}

/// What wave() leaves out at the inner end between two parts, in front of the tile `middle`.
template <class Stage>
void fill_between(Eigen::Index stages, Eigen::Index middle, const Stage& stage) {
  for (Eigen::Index s = 1; s < stages; ++s)
    for (Eigen::Index b = middle - s; b < middle + s; ++b) stage(s, b);
}

/// How the sites of a large system are shared out to threads and to tiles.
struct Waves {
  Eigen::Index tile = 0;  ///< sites, a multiple of `block`; 0: kick after kick of the whole system is as fast
  Eigen::Index threads = 1;

  /// Large tiles are for the memory, small ones for threads that are alone at the inner ends of their parts. (Measured: NLS
  /// lattice, 27 kicks.)
  Waves(Eigen::Index sites, Eigen::Index stages, Eigen::Index block) {
    constexpr Eigen::Index beyond_cache = 1 << 17, most = 8;
    const Eigen::Index least = block * 4 * stages;  // sites of a thread
    threads = std::min<Eigen::Index>(sites < 2 * least ? 1 : threads_for_one(), sites / least);
    if (threads < 2) {
      threads = 1;
      if (sites >= beyond_cache) tile = most * block;
      return;
    }
    Eigen::Index factor = most;
    while (factor > 1 && 2 * sites < 3 * factor * least * threads) factor /= 2;
    tile = factor * block;
  }
  bool pay() const { return tile > 0; }
};

/// stage(s, begin, end) for every s < stages, and every tile of the sites. Each may read what lies in the tile and its neighbours as
/// stage s - 1 left it there, and write to the tile what stages s - 2 and s - 1 read. By threads, each has a part of the tiles in
/// whose inner ends the later stages are missing; these are made up when all have come so far.
template <class Stage>
void in_waves(const Waves& waves, Eigen::Index stages, Eigen::Index sites, const Stage& stage) {
  const Eigen::Index tile = waves.tile, tiles = (sites + tile - 1) / tile, threads = waves.threads;
  const auto at = [&](Eigen::Index s, Eigen::Index b) {
    stage(s, b * tile, std::min((b + 1) * tile, sites));
  };
  if (threads == 1) return wave(stages, 0, tiles, false, false, at);
  const auto begin = [&](Eigen::Index part) { return tiles * part / threads; };
  for_each_in_parallel(threads, static_cast<int>(threads), [&](Eigen::Index part) {
    wave(stages, begin(part), begin(part + 1), part > 0, part + 1 < threads, at);
  });
  for_each_in_parallel(threads - 1, static_cast<int>(threads - 1),
                       [&](Eigen::Index part) { fill_between(stages, begin(part + 1), at); });
}

}  // namespace semiexplicit::detail
