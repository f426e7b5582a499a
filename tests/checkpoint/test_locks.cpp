#include "catch.hpp"

#if __has_include(<unistd.h>)
#include <csignal>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <string>

#include <sys/stat.h>
#include <unistd.h>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "child.hpp"
#include "folder.hpp"
#include "refusal.hpp"

namespace test_locks {

// Two runs on one checkpoint file, and checkpoint files behind links.

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;

const std::string refusal_of_second =
    ": another run has it open; wait for its end, or give this run another file";

/// A run and its checkpoints, every ten steps.
struct Run {
  GaussLegendre<systems::Product<double>> stepper{systems::Product<double>{}, {.stages = 1}};
  PhasePoint<double, 1> z{-3, 0};
  IntegrationOptions<double> options{.dt = 0.1, .steps = 25};
  Checkpoints<GaussLegendre<systems::Product<double>>> checkpoints;

  explicit Run(const fs::path& file) : checkpoints(file, {.every = 10}, stepper, options) {}
  std::int64_t resume() { return (options.done = checkpoints.resume(z)).steps; }
  void go() { integrate(stepper, z, options, checkpoints); }
};

/// A process that has resumed a run, has saved it or not, and lives.
pid_t start_run(const fs::path& file, bool saves) {
  Signal ready;
  const pid_t child = start_child([&] {
    Run run(file);
    run.resume();
    if (saves) run.go();
    ready.give();
    pause();
    return 0;
  });
  REQUIRE(ready.wait());
  return child;
}

std::ptrdiff_t files_in(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

}  // namespace

TEST_CASE("A second process on a checkpoint is refused while the first lives", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  const pid_t child = start_run(file, true);
  const std::string saved = contents(file);
  Run second(file);
  CHECK(complaint([&] { second.resume(); }) == file.string() + refusal_of_second);
  CHECK(complaint([&] { second.go(); }) == file.string() + refusal_of_second);  // without resume()
  CHECK(complaint([&] { second.checkpoints.remove(); }) == file.string() + refusal_of_second);
  CHECK(contents(file) == saved);
  CHECK(files_in(folder.path) == 1);  // no locks of their own

  kill(child, SIGKILL);
  exit_code(child);
  Run third(file);
  CHECK(third.resume() == 20);
  third.go();
  third.checkpoints.remove();
  CHECK(files_in(folder.path) == 0);
}

TEST_CASE("Who is refused a checkpoint does not disturb the run that saves there", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  Signal ready;
  const pid_t child = start_child([&] {
    Run run(file);
    run.resume();
    run.go();
    ready.give();
    run.options.steps = 3000;
    run.go();
    return 0;
  });
  REQUIRE(ready.wait());
  int refused = 0, status = 0;
  while (waitpid(child, &status, WNOHANG) == 0) {
    refused += complaint<std::exception>([&] { Run(file).resume(); }) == file.string() + refusal_of_second;
    refused += complaint<std::exception>([&] { Run(file).go(); }) == file.string() + refusal_of_second;
  }
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
  CHECK(refused > 100);
}

TEST_CASE("A checkpoint is locked before it is saved for the first time", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  const pid_t child = start_run(file, false);
  Run second(file);
  CHECK(complaint([&] { second.resume(); }) == file.string() + refusal_of_second);
  CHECK(complaint([&] { second.go(); }) == file.string() + refusal_of_second);
  kill(child, SIGKILL);
  exit_code(child);
  {
    Run third(file);
    CHECK(third.resume() == 0);
  }
  CHECK(files_in(folder.path) == 0);
  // Nor does the end of a run take away what has come to that place since.
  { std::ofstream(file) << "results\n"; }
  CHECK(says(complaint([&] { remove_checkpoint(file); }), "a file of another kind is there"));
  CHECK(contents(file) == "results\n");
}

TEST_CASE("A process may resume a run whose first object it still holds", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  Run first(file);
  CHECK(first.resume() == 0);
  first.go();
  Run next(file);
  CHECK(next.resume() == 20);
  next.go();
  first.z = Run(file).z;
  CHECK(first.resume() == 20);  // back again
  first.go();
  first.checkpoints.remove();
  CHECK(files_in(folder.path) == 0);
}

TEST_CASE("Two runs of one process do not overwrite each other\'s checkpoint", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  Run first(file), second(file);
  CHECK(first.resume() == 0);
  CHECK(second.resume() == 0);
  first.go();
  const std::string saved = contents(file);
  CHECK(complaint([&] { second.go(); }) == file.string() + refusal_of_second);
  CHECK(complaint([&] { second.checkpoints.remove(); }) == file.string() + refusal_of_second);
  CHECK(contents(file) == saved);
  // One that goes on from what the first has saved takes the file over, and the first is refused.
  Run next(file);
  CHECK(next.resume() == 20);
  next.options.steps = 40;
  next.go();
  CHECK(complaint([&] { first.checkpoints.save(first.z, IntegrationReport{.steps = 25}); }) ==
        file.string() + refusal_of_second);
  CHECK(complaint([&] { first.checkpoints.remove(); }) == file.string() + refusal_of_second);
  next.checkpoints.remove();
  CHECK(files_in(folder.path) == 0);
}

TEST_CASE("A checkpoint does not take the name of the .part of a table", "[checkpoint]") {
  const Folder folder;
  const fs::path path = folder.path / "run.csv", part = folder.path / "run.csv.part";
  CsvTrajectory table(path, 1);
  table(0.0, PhasePoint<double, 1>(1, 2));
  Run run(part);
  for (const std::string& said : {complaint([&] { run.resume(); }), complaint([&] { run.go(); }),
                                  complaint([&] { run.checkpoints.remove(); })})
    CHECK(says(said, part.string() + ": names in .part are for files that are being written"));
  table(1.0, PhasePoint<double, 1>(3, 4));
  table.commit();
  CHECK(contents(path) == "t,q0,p0\n0,1,2\n1,3,4\n");
}

TEST_CASE("A second run with the same object is saved, too", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  const bool by_clock = GENERATE(true, false);
  GaussLegendre<systems::Product<double>> stepper{systems::Product<double>{}, {.stages = 1}};
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 20};
  CheckpointOptions when{.every = 20};
  if (by_clock) when = {.seconds = 1e-9};
  Checkpoints checkpoints(file, when, stepper, options);
  for (const double q : {-3, -2}) {
    PhasePoint<double, 1> z(q, 0), again(q, 0);
    integrate(stepper, z, options, checkpoints);
    CHECK(fs::exists(file));
    CHECK(checkpoints.resume(again).steps > 0);
    checkpoints.remove();
  }
}

TEST_CASE("A checkpoint behind a link, and one that is no file", "[checkpoint]") {
  const Folder folder, elsewhere;
  const fs::path link = folder.path / "link", target = elsewhere.path / "run.checkpoint";
  fs::create_symlink(target, link);
  {
    Run run(link);
    CHECK(run.resume() == 0);  // where the link leads to no file yet
    run.go();
  }
  CHECK(fs::is_symlink(link));
  CHECK(fs::is_regular_file(target));
  Run again(link);
  CHECK(again.resume() == 20);
  again.checkpoints.remove();
  CHECK_FALSE(fs::exists(target));
  CHECK(fs::is_symlink(link));

  fs::create_directory(folder.path / "folder");
  CHECK(
      says(complaint([&] { Run(folder.path / "folder").resume(); }), "is a folder; give the name of a file"));
  CHECK(says(complaint([&] { Run(folder.path / "no" / "file").resume(); }), "check that the folder exists"));
  if (fs::exists("/dev/null")) {
    Run device("/dev/null");
    CHECK(refuses([&] { device.resume(); }, "is a pipe or a device; give the name of a file"));
    device.checkpoints.remove();
    CHECK(fs::is_character_file("/dev/null"));
  }
  const fs::path pipe = folder.path / "pipe";
  REQUIRE(mkfifo(pipe.c_str(), 0600) == 0);
  Run waiting(pipe);
  CHECK(refuses([&] { waiting.resume(); }, "is a pipe or a device"));
}

}  // namespace test_locks

#endif
