// One large lattice of the nonlinear Schrödinger equation over any number of processes (MPI), each with a
// range of the sites. The steps, their evaluations and the errors are those of one process but for rounding.
// A run that was killed goes on from its checkpoints when it is started again with the same settings.
//
//     mpirun -n 4 nls_mpi --sites 1000000
#include <chrono>
#include <cstdint>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <mpi.h>
#include <CLI/CLI.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/mpi_program.hpp"
#include "nls_mpi/block_lattice.hpp"
#include "nls_mpi/generations.hpp"
#include "nls_mpi/ranks.hpp"

namespace {

using namespace examples;

struct Job {
  std::int64_t sites = 100'000;
  std::int64_t checkpoint = 0;  ///< steps between two
  int threads = 1;
  double tolerance = StoppingRule::product().tolerance;
  Settings settings{.dt = 0.05, .time = 5};
};

int run(const Ranks& ranks, Job& job) {
#ifdef _OPENMP
  omp_set_num_threads(job.threads);
#endif
  const BlockLattice lattice(ranks, job.sites);
  const std::int64_t steps = job.settings.fit_steps();
  if (job.checkpoint > 0) job.settings.make_output_folder();

  Semiexplicit stepper(lattice, schemes::low_defect6_s13<double>(),
                       SimplifiedNewton{.stop = StoppingRule::product(job.tolerance)});
  auto z = lattice.start();
  Invariants invariants(lattice);
  invariants.add("mass", [&](const auto& q, const auto& p) { return lattice.mass(q, p); });
  IntegrationOptions<double> options{.dt = job.settings.dt, .steps = steps, .on_failure = OnFailure::stop};
  Generations checkpoints(
      job.settings.output, job.checkpoint, "nls_mpi, " + std::to_string(job.sites) + " sites", ranks,
      [&] { return lattice.start(); }, stepper, options, invariants);
  options.done = checkpoints.resume(z);
  if (ranks.first() && options.done.steps > 0)
    std::cout << "resumed: " << options.done.steps << " of " << steps << " steps are done already"
              << std::endl;

  const auto start = std::chrono::steady_clock::now();
  const std::clock_t processor_start = std::clock();
  const IntegrationReport report = integrate(stepper, z, options, invariants, checkpoints);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  const double processor_seconds =
      ranks.sum(static_cast<double>(std::clock() - processor_start) / CLOCKS_PER_SEC);
  const auto site_steps = static_cast<double>(job.sites * (report.steps - options.done.steps));
  const double spread = lattice.participation(z.q(), z.p());
  if (!report.ok()) {  // on all, with their states of the last good step
    if (ranks.first()) std::cerr << "nls_mpi: " << IntegrationError(report, job.settings.dt).what() << '\n';
    return 1;
  }
  if (ranks.first())
    std::cout << "sites: " << job.sites << ", steps: " << report.steps
              << ", evaluations: " << report.evaluations << '\n'
              << "participation number: " << formatted("%.15g", spread)
              << " by these steps, all digits to compare runs: in chaos dt and rounding change it\n"
              << "worst energy error: " << formatted("%.1e", invariants["energy"].worst)
              << ", worst mass error: " << formatted("%.1e", invariants["mass"].worst) << '\n'
              << ranks.size() << (ranks.size() > 1 ? " processes: " : " process: ")
              << throughput(site_steps, "site-steps", seconds, processor_seconds) << std::endl;
  // Where that could not be told it is to be had again from the last save. The others have no output.
  if (ranks.sum(ranks.first() && !std::cout ? 1 : 0) == 0) checkpoints.finish();
  return 0;
}

int run_job(int argc, char** argv) {
  const Ranks ranks;
  CLI::App app{
      "One lattice of the nonlinear Schrödinger equation over many processes, each with a range of "
      "its sites: mpirun -n 4 nls_mpi."};
  Job job;
  add_value(app, "--sites", job.sites, "size of the lattice", whole_number(1, 1'000'000'000'000), "N");
  add_value(app, "--dt", job.settings.dt, "step size; made a little smaller where the time is no multiple",
            positive());
  add_value(app, "--time", job.settings.time, "time to integrate to", positive());
  add_value(app, "--tolerance", job.tolerance, "of a step's projection, see StoppingRule::product",
            positive());
  add_value(app, "--checkpoint", job.checkpoint,
            "steps between two checkpoints, a file of each process in --output; 0: none",
            whole_number(0, 1'000'000'000), "N");
  add_value(app, "--threads", job.threads, "of each process, where the program is built with OpenMP",
            whole_number(1, 4096), "N");
  add_value(app, "--output", job.settings.output, "folder for the checkpoints", CLI::Validator(), "DIR");
  const auto check = [&] {
    steps_in(job.settings.time, job.settings.dt);
    if (job.sites < ranks.size())
      throw std::invalid_argument("--sites: fewer than processes; give each one at least");
  };
  return run_mpi_program(app, "nls_mpi", ranks.rank(), argc, argv, check, [&] { return run(ranks, job); });
}

}  // namespace

int main(int argc, char** argv) {
  return with_mpi(argc, argv, [&] { return run_job(argc, argv); });
}
