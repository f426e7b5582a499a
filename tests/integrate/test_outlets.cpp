#include "catch.hpp"

#include <charconv>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <thread>
#include <type_traits>
#include <vector>

#if __has_include(<unistd.h>)
#include <fcntl.h>
#include <unistd.h>
#endif

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"

namespace test_outlets {

// What observers let out: CSV files where writing fails, the progress bar, every() with observers of all
// kinds.

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;
using Point = PhasePoint<double, 1>;

/// Moves nothing.
struct Idle {
  using Scalar = double;
  using State = Point;
  StepReport step(Point&, const double&) { return {}; }
};

/// An observer that counts in itself.
struct Counter {
  int calls = 0;
  template <class Scalar, class State>
  void operator()(const Scalar&, const State&) {
    ++calls;
  }
};

}  // namespace

TEST_CASE("every() refers to a named observer and keeps a temporary", "[observers]") {
  Idle stepper;
  Point z(0, 0);
  Counter named;
  auto third = every(3, named);
  static_assert(std::is_same_v<decltype(third), Every<Counter&>>);
  static_assert(std::is_same_v<decltype(every(3, Counter())), Every<Counter>>);
  integrate(stepper, z, {.dt = 1, .steps = 9}, third);
  CHECK(named.calls == 4);  // at 0, 3, 6, 9

  // A temporary with memory of its own outlives the expression that made it.
  std::vector<int> seen;
  const auto make = [&seen] {
    return every(2, [&seen, many = std::vector<int>(100, 7)](double, const Point&) mutable {
      seen.push_back(many[99]++);
    });
  };
  auto second = make();
  integrate(stepper, z, {.dt = 1, .steps = 5}, second);
  CHECK(seen == std::vector<int>{7, 8, 9});

  // The step's report is handed on, and every(1, ...) changes nothing.
  int reports = 0;
  integrate(stepper, z, {.dt = 1, .steps = 5},
            every(1, [&](double, const Point&, const StepReport&) { ++reports; }));
  CHECK(reports == 6);

  for (const int n : {0, -1}) {
    std::string message;
    try {
      every(n, named);
    } catch (const std::invalid_argument& e) {
      message = e.what();
    }
    CHECK(message == "every: n is below 1; give how many steps lie between two calls");
  }
}

TEST_CASE("CSV: any number reads back as it was, and as short as can be", "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "numbers.csv";
  std::vector<double> written;
  {
    CsvWriter writer(path, {"x"});
    double x = 1e-310;  // by way of the subnormal numbers, up to the largest
    while (std::isfinite(x)) {
      for (const double value : {x, -x, std::nextafter(x, 0.0)}) {
        written.push_back(value);
        writer.row({value});
      }
      x *= 1234.56789;
    }
    writer.row({std::numeric_limits<double>::infinity()});
    writer.row({std::nan("")});
    writer.commit();
  }
  CHECK(written.size() > 300);
  std::istringstream lines(contents(path));
  std::string line;
  std::getline(lines, line);
  CHECK(line == "x");
  int different = 0;
  for (const double value : written) {
    std::getline(lines, line);
    double read = 0;
    std::from_chars(line.data(), line.data() + line.size(), read);
    if (read != value) ++different;
  }
  CHECK(different == 0);
  std::getline(lines, line);
  CHECK(line == "inf");
  std::getline(lines, line);
  CHECK(line == "nan");
  CHECK_FALSE(std::getline(lines, line));
}

TEST_CASE("CSV: a trajectory of the doubled space, and one that is never ended", "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "trajectory.csv";
  ExtendedPoint zeta(Point(1, 2));
  zeta.a.p()[0] = 3;  // y, which is not written
  {
    CsvTrajectory trajectory(path, 1);
    trajectory(0.5L, zeta);
    trajectory.commit();
  }
  CHECK(contents(path) == "t,q0,p0\n0.5,1,2\n");

  // A run that fails: the file of the run before it is still there, whole, and its own rows are in the .part.
  Semiexplicit stepper(systems::Product<double>{}, schemes::strang());
  const std::string part = path.string() + ".part", first = "t,q0,p0\n0,1,2\n";
  Point z(1, 2);
  const auto run = [&] {
    CsvTrajectory trajectory(path, 1);
    integrate(stepper, z, {.dt = 0, .steps = 1}, trajectory);
    trajectory.commit();
  };
  CHECK_THROWS_AS(run(), IntegrationError);
  CHECK(contents(path) == "t,q0,p0\n0.5,1,2\n");
  CHECK(contents(part) == first);
  { CsvTrajectory without_rows(path, 1); }  // takes nothing away that it has not written
  CHECK(contents(part) == first);
  fs::remove(part);

  {  // where the exception is caught while the trajectory is there
    CsvTrajectory trajectory(path, 1);
    CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0, .steps = 1}, trajectory), IntegrationError);
  }
  CHECK(contents(part) == first);
  fs::remove(part);
  {
    CsvTrajectory not_ended(path, 1);
    not_ended(0.0, Point(1, 2));
    CHECK(contents(part) == first);  // a row is there as soon as it is written
  }
  CHECK(contents(part) == first);
  CHECK(contents(path) == "t,q0,p0\n0.5,1,2\n");
  fs::remove(part);
  { CsvTrajectory without_rows(path, 1); }
  CHECK_FALSE(fs::exists(part));
}

TEST_CASE("CSV: a state of another size is not written", "[observers]") {
  const Folder folder;
  CsvTrajectory trajectory(folder.path / "trajectory.csv", 2);
  CHECK_THROWS_AS(trajectory(0.0, Point(1, 2)), std::invalid_argument);
}

#if __has_include(<unistd.h>)
namespace {

/// Half a second of a run under a progress bar; then a line, while the observer is still there.
void run_with_progress() {
  Idle stepper;
  Point z(0, 0);
  Progress progress(12, "the label", 2);
  integrate(stepper, z, {.dt = 1, .steps = 10, .t0 = 2}, progress,
            [](double, const Point&) { std::this_thread::sleep_for(std::chrono::milliseconds(50)); });
  std::fputs("next line", stderr);
}

/// Eight steps at 20 a second of a run that was resumed at its step 900 of 1000.
void resume_with_progress() {
  Progress progress(1000, "resumed");
  for (double t = 900; t < 908; ++t) {
    progress(t, Point(0, 0));
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

/// Runs with the file descriptor 2 leading to `to`.
template <class Action>
void with_stderr_to(int to, const Action& action) {
  std::fflush(stderr);
  const int saved = dup(STDERR_FILENO);
  dup2(to, STDERR_FILENO);
  action();
  std::fflush(stderr);
  dup2(saved, STDERR_FILENO);
  close(saved);
}

}  // namespace

/// What `action` writes to a terminal; nothing where none is to be had.
template <class Action>
std::string on_terminal(const Action& action) {
  const int master = posix_openpt(O_RDWR | O_NOCTTY);
  if (master < 0 || grantpt(master) != 0 || unlockpt(master) != 0) return "";
  const int terminal = open(ptsname(master), O_RDWR | O_NOCTTY);
  if (terminal < 0) return "";
  with_stderr_to(terminal, action);
  close(terminal);
  std::string drawn;
  char piece[256];
  for (auto n = read(master, piece, sizeof piece); n > 0; n = read(master, piece, sizeof piece))
    drawn.append(piece, static_cast<std::size_t>(n));
  close(master);
  return drawn;
}

TEST_CASE("The progress bar is drawn on a terminal, taken away at the end of the run, and nowhere else seen",
          "[observers]") {
  const Folder folder;
  const fs::path path = folder.path / "stderr";
  const int file = open(path.c_str(), O_WRONLY | O_CREAT, 0600);
  REQUIRE(file >= 0);
  with_stderr_to(file, run_with_progress);
  close(file);
  CHECK(contents(path) == "next line");

  const std::string drawn = on_terminal(run_with_progress);
  if (drawn.empty()) return;
  CAPTURE(drawn);
  CHECK(drawn.find("the label [#") != std::string::npos);
  CHECK(drawn.find("%  t = ") != std::string::npos);
  CHECK(drawn.find(" s left") != std::string::npos);
  CHECK(drawn.ends_with("\r\x1b[Knext line"));
  // Ten times a second at most.
  std::size_t bars = 0;
  for (std::size_t at = drawn.find('['); at != std::string::npos; at = drawn.find("the label [", at + 1))
    ++bars;
  CHECK(bars <= 8);
}

TEST_CASE("The time left of a resumed run is not reckoned from steps taken earlier", "[observers]") {
  const std::string drawn = on_terminal(resume_with_progress);
  CAPTURE(drawn);
  if (drawn.empty()) return;
  CHECK(drawn.find("90%  t = 90") != std::string::npos);
  CHECK(drawn.find("  0 s left") == std::string::npos);  // it takes nearly five
}

}  // namespace test_outlets

#endif
