#include "catch.hpp"

#if __has_include(<sys/mman.h>)
#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <random>
#include <thread>

#include <sys/mman.h>
#include <sys/wait.h>
#include <unistd.h>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"

namespace test_killed {

// A run in a process of its own that is killed, again and again, at moments that nothing in it knows of.

namespace {

using namespace semiexplicit;

constexpr std::int64_t every_steps = 200, all_steps = 20'000;

/// What a run that is killed leaves in memory: from where it went on, and how far it came.
struct Trace {
  std::int64_t from, reached;
};

/// Runs, or goes on, in this process.
void run(const std::filesystem::path& folder, volatile Trace& trace) {
  const systems::NlsLattice<double, 2> lattice;
  GaussLegendre stepper(lattice, {.stages = 2});
  PhasePoint<double, 2> z({1, 0.5}, {0.4, -0.7});
  IntegrationOptions<double> options{.dt = 0.04, .steps = all_steps};
  CsvTrajectory csv(folder / "run.csv", 2);
  auto some = every(100, csv);
  Checkpoints checkpoints(folder / "run.checkpoint", {.every = every_steps}, stepper, options, some);
  options.done = checkpoints.resume(z);
  trace.from = options.done.steps;
  integrate(
      stepper, z, options, some,
      [&](double, const auto&, const IntegrationReport& so_far) { trace.reached = so_far.steps; },
      checkpoints);
  csv.commit();
}

}  // namespace

TEST_CASE("A run that is killed loses an interval at most, and ends the same", "[checkpoint][long]") {
  const Folder folder, other;
  void* const shared =
      mmap(nullptr, sizeof(Trace), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  REQUIRE(shared != MAP_FAILED);
  auto& trace = *static_cast<volatile Trace*>(shared);
  const auto begin = std::chrono::steady_clock::now();
  run(other.path, trace);
  const auto whole = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin);

  const unsigned seed = std::random_device()();
  std::cout << "seed " << seed << '\n';
  CAPTURE(seed);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.02, 0.2);
  std::int64_t reached = 0, lost = 0, last_from = 0;
  int kills = 0;
  for (bool done = false; !done;) {
    trace.from = -1;
    trace.reached = 0;
    const pid_t child = fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      run(folder.path, trace);
      _exit(0);
    }
    if (kills < 12) {
      std::this_thread::sleep_for(share(random) * whole);
      kill(child, SIGKILL);
    }
    int status = 0;
    waitpid(child, &status, 0);
    done = WIFEXITED(status);
    if (done)
      REQUIRE(WEXITSTATUS(status) == 0);
    else
      REQUIRE(WTERMSIG(status) == SIGKILL);
    if (!done) ++kills;
    if (trace.from < 0) continue;  // killed before it had begun
    last_from = trace.from;
    lost = std::max(lost, reached - last_from);
    reached = std::max(last_from, std::int64_t{trace.reached});
  }
  CHECK(kills > 0);
  CHECK(last_from > 0);
  CHECK(lost <= every_steps);
  CHECK(reached == all_steps);
  munmap(shared, sizeof(Trace));
  CHECK(contents(folder.path / "run.csv") == contents(other.path / "run.csv"));
}

}  // namespace test_killed

#endif
