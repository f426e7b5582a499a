#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <iostream>
#include <vector>

#include <mpi.h>

#include "../common/arguments.hpp"
#include "../common/finished_blocks.hpp"
#include "sweep.hpp"

namespace examples {

using Clock = std::chrono::steady_clock;

/// The process among all.
struct World {
  int rank = 0, size = 1;
  World() {
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    MPI_Comm_size(MPI_COMM_WORLD, &size);
  }
  bool first() const { return rank == 0; }
};

/// What the user wants.
struct Job {
  Sweep sweep;
  std::int64_t block = 512;  ///< members
  int threads = 1;
  bool progress = false;
  Settings settings;  ///< of which the output counts

  std::int64_t last_of(std::int64_t b) const { return std::min((b + 1) * block, sweep.members); }
  std::int64_t blocks() const { return (sweep.members + block - 1) / block; }
};

/// The blocks that are still to be computed; the first process looks, and tells the others.
inline std::vector<std::int64_t> missing_blocks(const World& world, const Job& job,
                                                const FinishedBlocks& checkpoints) {
  std::vector<std::int64_t> missing;
  if (world.first())
    for (std::int64_t b = 0; b < job.blocks(); ++b)
      if (!checkpoints.load_if_sound(b)) missing.push_back(b);
  auto count = static_cast<std::int64_t>(missing.size());
  MPI_Bcast(&count, 1, MPI_INT64_T, 0, MPI_COMM_WORLD);
  missing.resize(static_cast<std::size_t>(count));
  MPI_Bcast(missing.data(), static_cast<int>(count), MPI_INT64_T, 0, MPI_COMM_WORLD);
  return missing;
}

/// One line that is written over and over.
inline void show_progress(const Job& job, const FinishedBlocks& checkpoints, std::int64_t before,
                          Clock::time_point start) {
  const std::int64_t done = checkpoints.count();
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();
  const double left = seconds * static_cast<double>(job.blocks() - done) /
                      static_cast<double>(std::max<std::int64_t>(done - before, 1));
  std::cerr << '\r' << done << " of " << job.blocks() << " blocks, " << formatted("%.0f", left)
            << " s left\x1b[K" << std::flush;
}

}  // namespace examples
