// A sweep over the initial conditions of four vortices by any number of processes (MPI). Each block of
// members that is finished is kept in a file; a run that was interrupted goes on from these when it is
// started again with the same settings.
//
//     mpirun -n 4 ensemble_mpi --members 100000
#include <chrono>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include <mpi.h>
#include <unistd.h>
#include <CLI/CLI.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/arguments.hpp"
#include "common/finished_blocks.hpp"
#include "common/mpi_program.hpp"
#include "common/prepare_outputs.hpp"
#include "ensemble_mpi/job.hpp"
#include "ensemble_mpi/results.hpp"
#include "ensemble_mpi/sweep.hpp"

namespace {

using namespace examples;

int run(const World& world, const Job& job) {
  const FinishedBlocks checkpoints(job.settings.output / "sweep",
                                   job.sweep.in_words() + ", block " + std::to_string(job.block));
  const std::filesystem::path data = SweepResults::file_in(job.settings.output),
                              png = job.settings.output / "sweep.png";
  std::unique_ptr<DurableFile> lock;
  if (world.first()) {
    prepare_outputs(job.settings, {data, png});
    lock = checkpoints.lock();
    make_folder(checkpoints.folder(), "--output");
    std::cout << "checkpoints: " << checkpoints.folder().string() << std::endl;
  }
  const std::vector<std::int64_t> missing = missing_blocks(world, job, checkpoints);
  const auto here_before = job.blocks() - static_cast<std::int64_t>(missing.size());
  if (world.first() && here_before > 0)
    std::cout << "resumed: " << here_before << " of " << job.blocks() << " blocks are here already\n";

  // Every block costs nearly the same, so they are dealt out like cards.
  const auto start = Clock::now();
  const std::clock_t processor_start = std::clock();
  const bool shows = world.first() && (job.progress || isatty(STDERR_FILENO) != 0);
  for (auto i = static_cast<std::size_t>(world.rank); i < missing.size();
       i += static_cast<std::size_t>(world.size)) {
    const std::int64_t b = missing[i];
    checkpoints.save(b, job.sweep.run(b * job.block, job.last_of(b), job.threads));
    if (shows) show_progress(job, checkpoints, here_before, start);
  }
  const double here = static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC;
  double processor_seconds = 0;  // of all, for which the first process waits here
  MPI_Reduce(&here, &processor_seconds, 1, MPI_DOUBLE, MPI_SUM, 0, MPI_COMM_WORLD);
  if (!world.first()) return 0;
  if (shows) std::cerr << "\r\x1b[K";
  const double seconds = std::chrono::duration<double>(Clock::now() - start).count();

  std::vector<double> table;
  for (std::int64_t b = 0; b < job.blocks(); ++b) {
    const auto rows = checkpoints.load(b);
    if (!rows)
      throw std::runtime_error(checkpoints.folder().string() + ": a block has vanished; start again");
    table.insert(table.end(), rows->begin(), rows->end());
  }
  const SweepResults results(job.sweep, std::move(table));
  results.print(std::cout);
  if (!missing.empty()) {
    std::int64_t members = 0;
    for (const std::int64_t b : missing) members += job.last_of(b) - b * job.block;
    const double steps = 2.0 * static_cast<double>(job.sweep.steps() * members);
    std::cout << world.size << (world.size > 1 ? " processes, " : " process, ") << job.threads
              << (job.threads > 1 ? " threads each: " : " thread each: ")
              << throughput(steps, "member-steps", seconds, processor_seconds) << '\n';
  }
  results.write(data);
  std::cout << "data: " << data.string() << std::endl;
  checkpoints.remove();
  if (results.sorted(3).empty()) {
    std::cerr << "ensemble_mpi: no member came to its end; give a smaller --dt\n";
    if (!job.settings.no_plot) tell_of_earlier_picture(png);
    return 1;
  }
  if (!job.settings.no_plot) draw(png, results.script(png), {data});
  return 0;
}

int run_job(int argc, char** argv) {
  const World world;
  CLI::App app{
      "Four point vortices: three on a triangle, the fourth at random; which places make them chaotic? By "
      "many processes: mpirun -n 4 ensemble_mpi."};
  Job job;
  constexpr std::int64_t most = 1'000'000'000;
  add_value(app, "--members", job.sweep.members, "initial conditions", whole_number(1, most), "N");
  add_value(app, "--seed", job.sweep.seed, "of their places; member i depends on nothing else",
            whole_number(0, most), "N");
  add_value(app, "--dt", job.sweep.dt, "step size; made a little smaller where the time is no multiple",
            positive(), "X");
  add_value(app, "--time", job.sweep.time, "time to integrate to, and back", positive(), "X");
  add_value(app, "--strength", job.sweep.strength,
            "circulation of the fourth vortex; that of the others is 1", positive(), "X");
  add_value(app, "--extent", job.sweep.extent, "half the side of the square of its places", positive(), "X");
  add_value(app, "--block", job.block, "members between two checkpoints", whole_number(1, most), "N");
  add_value(app, "--threads", job.threads, "of each process, where the program is built with OpenMP",
            whole_number(1, 4096), "N");
  add_output(app, job.settings, false);
  app.add_flag("--progress", job.progress,
               "show the progress on stderr though it is no terminal, as under mpirun");
  const auto fit_step = [&] { job.sweep.dt = job.sweep.time / static_cast<double>(job.sweep.steps()); };
  return run_mpi_program(app, "ensemble_mpi", world.rank, argc, argv, fit_step,
                         [&] { return run(world, job); });
}

}  // namespace

int main(int argc, char** argv) {
  return with_mpi(argc, argv, [&] { return run_job(argc, argv); });
}
