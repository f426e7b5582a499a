#include "catch.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <stdexcept>
#include <string>
#include <utility>

#if __has_include(<unistd.h>)
#include <sys/stat.h>
#endif

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_files {

// Checkpoint files: those that must not be gone on from, those that cannot be written, and what goes on
// beside the stepper.

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;

/// Bit for bit.
bool same(const PhasePoint<double, 1>& u, const PhasePoint<double, 1>& v) { return u.vector() == v.vector(); }

/// A run of Product that has left a checkpoint.
struct Interrupted {
  Folder folder;
  fs::path file = folder.path / "run.checkpoint";
  IntegrationOptions<double> options{.dt = 0.1, .steps = 20};
  PhasePoint<double, 1> start{-3, 0};
  systems::Product<double> h;

  Interrupted() {
    GaussLegendre stepper(h, {.stages = 2});
    PhasePoint<double, 1> z = start;
    Invariants<double, 1> seen(h);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, seen);
    integrate(stepper, z, options, seen, checkpoints);
  }
  void write(const std::string& bytes) const { std::ofstream(file, std::ios::binary) << bytes; }

  /// What is said of the file; nothing may change where it is refused.
  std::string refusal_of_file() const {
    GaussLegendre stepper(h, {.stages = 2}), fresh = stepper;
    PhasePoint<double, 1> z = start, y = start;
    Invariants<double, 1> seen(h);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, seen);
    const std::string said = refusal([&] { checkpoints.resume(z); });
    if (!says(said, accepted)) {
      if (!same(z, start) || seen["energy"].started) return "the state or the observers changed";
      stepper.step(z, 0.1);
      fresh.step(y, 0.1);
      if (!same(z, y)) return "the stepper changed";
    }
    return said;
  }
};

}  // namespace

TEST_CASE("A checkpoint with any byte changed, cut short or lengthened is refused, and nothing changes",
          "[checkpoint]") {
  const Interrupted run;
  const std::string sound = contents(run.file);
  REQUIRE(sound.size() > 300);
  REQUIRE(run.refusal_of_file() == accepted);
  const std::string file = "checkpoint " + run.file.string() + ": ";
  // All of it in memory, and every ninth as a file.
  std::size_t damages = 0, refused = 0;
  const auto damage = [&](const std::string& bytes) {
    const auto good = [](const std::string& said) {
      return says(said, "start anew") || says(said, "give the name");
    };
    const bool by_frame = good(refusal([&] { detail::CheckpointFrame::unpack(bytes); }));
    bool by_file = true;
    if (damages++ % 9 == 0) {
      run.write(bytes);
      const std::string said = run.refusal_of_file();
      by_file = says(said, file) && good(said);
    }
    if (by_frame && by_file) ++refused;
  };
  for (std::size_t i = 0; i < sound.size(); ++i)
    for (int bit = 0; bit < 8; ++bit) {
      std::string damaged = sound;
      damaged[i] = static_cast<char>(damaged[i] ^ (1 << bit));
      damage(damaged);
    }
  for (std::size_t length = 0; length < sound.size(); ++length) damage(sound.substr(0, length));
  damage(sound + '\0');
  CHECK(refused == damages);

  // In a frame that is sound, too: numbers that are not those asked for, or that cannot be.
  const std::string inside = detail::CheckpointFrame::unpack(sound);
  std::size_t survived = 0;
  for (std::size_t length = 0; length < inside.size(); length += length < 20 ? 1 : 7) {
    run.write(detail::CheckpointFrame::pack(inside.substr(0, length)));
    if (!says(run.refusal_of_file(), file)) ++survived;
  }
  run.write(detail::CheckpointFrame::pack(inside + "1"));
  if (!says(run.refusal_of_file(), file)) ++survived;
  CHECK(survived == 0);

  std::string other = sound;
  other[28] = 1;
  run.write(other);
  CHECK(says(run.refusal_of_file(), "has the format 1, and this program reads the format 8; go on with"));
  std::memcpy(other.data() + 24, "\x01\x02\x03\x04", 4);
  run.write(other);
  CHECK(says(run.refusal_of_file(), "another byte order"));
  fs::remove(run.file);
  fs::create_directory(run.file);
  CHECK_THROWS_AS(run.refusal_of_file(), std::runtime_error);
}

TEST_CASE("Of long lists the entry that differs is told", "[checkpoint]") {
  const std::string begin = "run: a program with a name of some length; 4000 steps, samples 1000, ",
                    end = ", mass 1, charge 1, spin 0.5, gm 398600.44";
  const auto told = [&](const std::string& there, const std::string& here) {
    return detail::difference_of_lines(begin + there + end, begin + here + end);
  };
  CHECK(told("e 0.5", "e 0.55") == "'e 0.5' there, 'e 0.55' here");
  CHECK(told("e 0.5", "a 3") == "'e 0.5' there, 'a 3' here");
  CHECK(told("e 0.5", "e 0.5").empty());
  CHECK(detail::difference_of_lines(begin + "e, f" + end, begin + "e; g" + end) ==
        "'e, f' there, 'e; g' here");
  CHECK(detail::difference_of_lines(begin + "e" + end, begin) == "'e' there, '' here");
  CHECK(
      detail::difference_of_lines(begin + end, "x" + begin + end) ==
      "'run: a program with a name of some length' there, 'xrun: a program with a name of some length' here");
}

TEST_CASE("A checkpoint of another run is refused, by what differs", "[checkpoint]") {
  const Interrupted run;
  using Point = PhasePoint<double, 1>;
  Invariants<double, 1> seen(run.h);
  const auto said = [&](auto stepper, auto options, const Point& from = {-3, 0}, std::string label = "") {
    Point z = from;
    Checkpoints checkpoints(run.file, {.every = 10, .run = label}, stepper, options, seen);
    return refusal([&] { checkpoints.resume(z); });
  };
  const GaussLegendre gauss(run.h, {.stages = 2});
  auto options = run.options;
  CHECK(said(gauss, options) == accepted);
  options.steps = 1000;  // a longer run is the same run
  CHECK(said(gauss, options) == accepted);
  options.dt = 0.2;
  CHECK(says(said(gauss, options), "'dt: 0.1"));
  options = run.options;
  options.t0 = 1;
  CHECK(says(said(gauss, options), "'t0: 0' there, 't0: 1' here"));
  options = run.options;
  CHECK(says(said(GaussLegendre(run.h, {.stages = 3}), options), "'stages: 2' there, 'stages: 3' here"));
  CHECK(says(said(GaussLegendre(run.h, {.stages = 2, .extrapolate = false}), options), "'extrapolate: 1'"));
  CHECK(
      says(said(Semiexplicit(run.h, schemes::strang<double>()), options), "'stepper: GaussLegendre' there"));
  CHECK(says(said(gauss, options, Point(-3, 1)), "another initial state"));
  CHECK(says(said(gauss, options, Point(-3, 0), "k = 2"), "'run: ' there, 'run: k = 2' here"));

  auto other_h = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                             [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                               dHdq[0] = 1.001 * q[0] * (p[0] * p[0] + 1);
                                               dHdp[0] = p[0] * (q[0] * q[0] + 1);
                                             });
  CHECK(says(said(GaussLegendre(other_h, {.stages = 2}), options), "another Hamiltonian"));

  GaussLegendre stepper(run.h, {.stages = 2});  // other observers, or none
  Point z = run.start;
  seen.add("q", [](const auto& q, const auto&) { return q[0]; });
  CHECK(says(said(gauss, options), "'nothing' there, 'observer 1 q: a function' here"));
  Checkpoints without(run.file, {}, stepper, options);
  CHECK(says(refusal([&] { without.resume(z); }), "'observer 1: Invariants' there, 'nothing' here"));

  GaussLegendre longer(systems::Product<long double>{}, {.stages = 2});
  PhasePoint<long double, 1> wide(-3, 0);
  Checkpoints of_long_double(run.file, {}, longer, IntegrationOptions<long double>{.dt = 0.1L, .steps = 20});
  CHECK(says(refusal([&] { of_long_double.resume(wide); }), "'bits of a number: 53' there"));
  GaussLegendre larger(systems::NlsLattice<double, 2>{}, {.stages = 2});
  PhasePoint<double, 2> two({1, 0.5}, {0.4, -0.7});
  Checkpoints of_lattice(run.file, {}, larger, options);
  CHECK(says(refusal([&] { of_lattice.resume(two); }), "'degrees of freedom: 1' there"));

  // Schemes and solvers, as their own run sees them.
  const fs::path file = run.folder.path / "scheme";
  const auto scheme = schemes::blanes_moan4<double>();
  Semiexplicit first(run.h, scheme, Broyden{.memory = 5});
  Checkpoints(file, {}, first, options).save(z, {});
  const auto refused = [&](auto second) {
    return refusal([&] { Checkpoints(file, {}, second, options).resume(z); });
  };
  CHECK(says(refused(Semiexplicit(run.h, schemes::kahan_li6<double>(), Broyden{.memory = 5})),
             "'scheme: blanes_moan4"));
  auto edited = scheme;
  edited.a.front() = edited.a.back() = std::nextafter(edited.a.front(), 1.0);
  CHECK(says(refused(Semiexplicit(run.h, edited, Broyden{.memory = 5})), "'scheme a: 7 numbers"));
  CHECK(says(refused(Semiexplicit(run.h, scheme)), "'solver: Broyden' there"));
  CHECK(says(refused(Semiexplicit(run.h, scheme, Broyden{.memory = 6})), "'solver memory: 5' there"));
  const Broyden loose{.stop = StoppingRule::product(1e-12), .memory = 5};
  CHECK(says(refused(Semiexplicit(run.h, scheme, loose)), "'solver rule tolerance: 9.9"));
}

TEST_CASE("Where a checkpoint cannot be written, that is said and the old one stays", "[checkpoint]") {
  const Interrupted run;
  const std::string old = contents(run.file);
  GaussLegendre stepper(run.h, {.stages = 2});
  PhasePoint<double, 1> z = run.start;
  const auto said_of = [&](const fs::path& path) -> std::string {
    try {
      Checkpoints checkpoints(path, {.every = 10}, stepper, run.options);
      integrate(stepper, z, run.options, checkpoints);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "";
  };
  CHECK(says(said_of(run.folder.path / "nowhere" / "file"), "check that the folder exists"));
  fs::create_directory(run.folder.path / "folder");
  CHECK(says(said_of(run.folder.path / "folder"), "folder: "));
  CHECK_FALSE(fs::exists(run.folder.path / "folder.part"));
  // Before the first step, whenever it would be saved; none is made.
  const auto begins = [&](const fs::path& path) {
    z = run.start;
    Checkpoints checkpoints(path, {.seconds = 1e9}, stepper, run.options);
    integrate(stepper, z, run.options, every(3, checkpoints));
  };
  CHECK(
      says(complaint([&] { begins(run.folder.path / "nowhere" / "file"); }), "check that the folder exists"));
  CHECK(z.vector() == run.start.vector());
  if (fs::exists("/dev/null")) CHECK(refuses([&] { begins("/dev/null"); }, "is a pipe or a device"));
  begins("");  // none are wanted
  begins(run.folder.path / "new");
  CHECK_FALSE(fs::exists(run.folder.path / "new"));
  CHECK_FALSE(fs::exists(run.folder.path / "new.part"));
  CHECK(contents(run.file) == old);
  // What only the operating system knows, in the words of a save, and nothing is touched.
  const auto is_told = [&](const fs::path& path, const std::string& words) {
    CAPTURE(path.string());
    const std::string said = complaint([&] { begins(path); });
    CHECK(says(said, words));
    CHECK(z.vector() == run.start.vector());
    CHECK(said_of(path) == said);
  };
  const auto here = [&](const std::string& name) { return run.folder.path / name; };
  const auto write = [](const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
  };
  const auto files = [&] {
    return std::distance(fs::directory_iterator(run.folder.path), fs::directory_iterator());
  };
  write(here("other"), "a result");
  write(here("rests.part"), "rows of another run");
  write(here("empty.part"), "");
  fs::create_directory(here("folder_there.part"));
  fs::create_symlink("nowhere", here("dangling.part"));
  const auto before = files();
  is_told(here("other") / "x", "check that the folder exists");
  is_told(here("other"), "a file of another kind is there; give another name");
  is_told(here(std::string(252, 'n')), "cannot be written");
  is_told(here("folder_there"), "folder_there.part: is in the way; remove it");
  is_told(here("dangling"), "dangling.part: is in the way; remove it");
  for (const fs::path folder : {"/proc", "/sys", "/dev/fd"})
    if (fs::exists(folder)) is_told(folder / "x", "cannot be written");
  begins(here("rests"));
  begins(here("empty"));
  begins(here(std::string(250, 'n')));
  CHECK(files() == before);
  CHECK(contents(here("other")) == "a result");
  CHECK(contents(here("rests.part")) == "rows of another run");
  CHECK(fs::is_symlink(here("dangling.part")));
#if __has_include(<unistd.h>)
  REQUIRE(mkfifo(here("pipe.part").c_str(), 0600) == 0);
  is_told(here("pipe"), "pipe.part: is in the way; remove it");
  CHECK(fs::is_fifo(here("pipe.part")));
#endif
  CHECK(contents(run.file) == old);
  CHECK(refuses([&] { Checkpoints("x", {.every = -1}, stepper, run.options); }, "every is negative"));
  CHECK(refuses([&] { Checkpoints("x", {.seconds = 0}, stepper, run.options); }, "seconds is not positive"));
}

TEST_CASE("By the clock, after steps, and away when the run is done", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  PhasePoint<double, 1> z(-3, 0);
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 10};
  Checkpoints never(file, {.seconds = 1e9}, stepper, options);
  CHECK(never.resume(z).steps == 0);
  integrate(stepper, z, options, never);
  CHECK_FALSE(fs::exists(file));
  Checkpoints always(file, {.seconds = 1e-9}, stepper, options);
  integrate(stepper, z, options, always);
  CHECK(fs::exists(file));
  always.remove();
  CHECK_FALSE(fs::exists(file));
  always.remove();
  Checkpoints fours(file, {.every = 4}, stepper, options);
  z = {-3, 0};
  integrate(stepper, z, options, fours);
  z = {-3, 0};
  CHECK(fours.resume(z).steps == 8);
}

TEST_CASE("Where not every step is shown, what is saved is the first one behind a multiple of `every`",
          "[checkpoint]") {
  const Folder folder;
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 29};
  for (const auto& [shown, saved] : {std::pair(1, 20), std::pair(3, 21), std::pair(25, 25)}) {
    PhasePoint<double, 1> z(-3, 0), again = z;
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
    integrate(stepper, z, options, every(shown, checkpoints));
    CHECK(checkpoints.resume(again).steps == saved);
    checkpoints.remove();
  }
}

TEST_CASE("A run goes on with the very state that was put back, or is refused", "[checkpoint]") {
  const Interrupted run;
  IntegrationOptions<double> options = run.options;
  options.steps = 40;
  GaussLegendre stepper(run.h, {.stages = 2});
  Invariants<double, 1> seen(run.h);
  Checkpoints checkpoints(run.file, {.every = 10}, stepper, options, seen);
  PhasePoint<double, 1> z = run.start, saved = z;
  options.done = checkpoints.resume(saved);
  REQUIRE(options.done.steps == 20);
  const std::string remedy = "give integrate() the state that resume() was given";
  const auto refused = [&](auto&& observer) {
    return says(complaint<std::logic_error>([&] { integrate(stepper, z, options, seen, observer); }), remedy);
  };
  CHECK(refused(checkpoints));
  CHECK(refused(std::ref(checkpoints)));
  CHECK(refused(every(2, checkpoints)));
  CHECK(same(z, run.start));
  CHECK(integrate(stepper, saved, options, seen, checkpoints).steps == 40);
}

TEST_CASE("What is saved by hand as step 0 is how the run began", "[checkpoint]") {
  const Interrupted run;
  GaussLegendre stepper(run.h, {.stages = 2});
  Invariants<double, 1> seen(run.h);
  Checkpoints checkpoints(run.file, {.every = 10}, stepper, run.options, seen);
  PhasePoint<double, 1> z = run.start;
  const auto is_refused = [&] {
    const std::string old = contents(run.file),
                      said = complaint<std::logic_error>([&] { checkpoints.save(z, {}); });
    return says(said, "give the report of the run") && contents(run.file) == old;
  };
  checkpoints.resume(z);
  CHECK(is_refused());
  z = run.start;
  const auto report = integrate(stepper, z, run.options, seen, checkpoints);
  CHECK(is_refused());
  checkpoints.save(z, report);
  z = run.start;
  checkpoints.save(z, {});
  CHECK(checkpoints.resume(z).steps == 0);
}

TEST_CASE("A table does not replace a checkpoint", "[checkpoint]") {
  const Interrupted run;
  const std::string old = contents(run.file), words = "a checkpoint is there; give another name";
  CHECK(says(complaint([&] { CsvTrajectory(run.file, 1); }), words));
  CHECK_FALSE(fs::exists(run.file.string() + ".part"));
  const fs::path other = run.folder.path / "run.csv";
  CsvWriter csv(other, {"t"});
  csv.row({1});
  fs::rename(run.file, other);
  CHECK(says(complaint([&] { csv.commit(); }), words));
  CHECK(contents(other) == old);
  fs::remove(other);
  csv.commit();
  csv.commit();
  CHECK(contents(other) == "t\n1\n");
}

TEST_CASE("A checkpoint neither replaces nor removes a file of another kind", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.csv";
  const auto is_refused = [](const auto& call) {
    try {
      call();
    } catch (const std::runtime_error& error) {
      return says(error.what(), "a file of another kind is there; give another name");
    }
    return false;
  };
  Semiexplicit stepper(systems::Product<double>{});
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 4};
  for (const bool saved_before : {false, true}) {
    CAPTURE(saved_before);
    Checkpoints checkpoints(file, {.every = 2}, stepper, options);
    PhasePoint<double, 1> z(-3, 0);
    if (saved_before) integrate(stepper, z, options, checkpoints);
    write_durably(file, "t,q\n0,1\n");
    CHECK(is_refused([&] { integrate(stepper, z, options, checkpoints); }));
    CHECK(is_refused([&] { checkpoints.remove(); }));
    CHECK(contents(file) == "t,q\n0,1\n");
    fs::remove(file);
    if (saved_before) {  // over the checkpoint itself
      integrate(stepper, z, options, checkpoints);
      std::ofstream(file) << "a result";
      CHECK(is_refused([&] { integrate(stepper, z, options, checkpoints); }));
      CHECK(is_refused([&] { checkpoints.remove(); }));
      CHECK(contents(file) == "a result");
    }
  }
}

TEST_CASE("integrate() goes on from an earlier part: times, counts, observers", "[checkpoint]") {
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  PhasePoint<double, 1> z(-3, 0);
  IntegrationOptions<double> options{.dt = 0.1, .steps = 5, .t0 = 7};
  Record<double, 1> record;
  options.done = integrate(stepper, z, options, record);
  options.steps = 12;
  std::int64_t counted = 0;
  const auto report =
      integrate(stepper, z, options, record,
                [&](double, const auto&, const IntegrationReport& so_far) { counted = so_far.steps; });
  CHECK(counted == 12);
  CHECK(report.steps == 12);
  REQUIRE(record.t.size() == 13);  // the state in the middle once
  for (std::size_t n = 0; n < 13; ++n) CHECK(record.t[n] == 7 + static_cast<double>(n) * 0.1);
  options.done = report;
  CHECK(integrate(stepper, z, options, record).t == 7 + 12 * 0.1);  // nothing is left to do
  CHECK(record.t.size() == 13);
  options.steps = 4;
  CHECK(refuses([&] { integrate(stepper, z, options); }, "12 steps are done, and not 0 to 4"));
}

TEST_CASE("A run to a time is extended with the same steps, or not at all", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  const auto run_to = [&](double dt, double t_end) {
    Semiexplicit stepper(systems::Product<double>{}, schemes::low_defect6_s13<double>());
    PhasePoint<double, 1> z(1, 0);
    IntegrationOptions<double> options{.dt = dt, .t_end = t_end};
    Checkpoints checkpoints(file, {.every = 10}, stepper, options);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, checkpoints);
    return z;
  };
  const auto whole = run_to(0.1, 20);
  fs::remove(file);
  run_to(0.1, 10);
  CHECK(run_to(0.1, 20).vector() == whole.vector());

  fs::remove(file);
  run_to(0.3, 10);  // 34 steps of 0.294
  CHECK(refuses([&] { run_to(0.3, 20); }, "'dt: 0.29411764705882354' there"));
}

TEST_CASE("A longer time that dt divides but for rounding goes on, also from a late start", "[checkpoint]") {
  const Folder folder;
  const auto steps_to = [&](double t_end) {
    GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
    PhasePoint<double, 1> z(1, 0);
    IntegrationOptions<double> options{.dt = 0.1, .t0 = 1e6, .t_end = t_end};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
    options.done = checkpoints.resume(z);
    return integrate(stepper, z, options, checkpoints).steps;
  };
  CHECK(steps_to(1e6 + 100) == 1000);
  CHECK(steps_to(1e6 + 200.1) == 2001);
}

TEST_CASE("A run that is resumed at its end has the report of its last step", "[checkpoint]") {
  const Folder folder;
  const auto run = [&] {
    Semiexplicit stepper(systems::Product<double>{}, schemes::strang<double>());
    PhasePoint<double, 1> z(-3, 0);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 20};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
    options.done = checkpoints.resume(z);
    return integrate(stepper, z, options, checkpoints).last;
  };
  const StepReport first = run(), again = run();
  CHECK(first.correction > 0);
  CHECK(again.correction == first.correction);
  CHECK(again.evaluations == first.evaluations);
  CHECK(again.gradients == first.gradients);
  CHECK(again.rate == first.rate);
}

TEST_CASE("What is saved at the start shows the start once, and at an event within a step nothing is saved",
          "[checkpoint]") {
  const Folder folder;
  const auto h = systems::Product<double>{};
  const auto run = [&](bool stops) {
    GaussLegendre stepper(h, {.stages = 2});
    PhasePoint<double, 1> z(-3, 0);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 10};
    Record<double, 1> record;
    CsvTrajectory csv(folder.path / "run.csv", 1);
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 1000}, stepper, options, record, csv);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, record, csv, checkpoints,
              [&](double, const auto& at, const IntegrationReport& so_far) {
                if (stops) checkpoints.save(at, so_far);
                return !stops;
              });
    return record.t.size();
  };
  CHECK(run(true) == 1);
  CHECK(run(false) == 11);

  GaussLegendre stepper(h, {.stages = 2});
  PhasePoint<double, 1> z(-3, 0);
  IntegrationOptions<double> options{.dt = 0.03, .steps = 100};
  auto crossing = events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                                     [](const double&, PhasePoint<double, 1>&) { return false; }));
  Checkpoints checkpoints(folder.path / "other.checkpoint", {.every = 1000}, stepper, options);
  options.done = checkpoints.resume(z);
  const auto report = integrate(stepper, z, options, crossing, checkpoints);
  REQUIRE(report.at_event);
  CHECK(refuses([&] { checkpoints.save(z, report); }, "save at the end of a step"));
  CHECK_FALSE(fs::exists(folder.path / "other.checkpoint"));
}

TEST_CASE("A CSV file goes on although another run has written one of that name since", "[checkpoint]") {
  const Folder folder;
  const fs::path csv = folder.path / "run.csv", file = folder.path / "run.checkpoint";
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  const auto run = [&](const fs::path& rows, const fs::path& saved, std::int64_t steps, bool ends) {
    IntegrationOptions<double> options{.dt = 0.1, .steps = steps};
    PhasePoint<double, 1> z(-3, 0);
    CsvTrajectory table(rows, 1);
    Checkpoints checkpoints(saved, {.every = 10}, stepper, options, table);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, table, checkpoints);
    if (ends) table.commit();
  };
  run(folder.path / "whole.csv", folder.path / "whole.checkpoint", 30, true);
  run(csv, file, 15, false);
  for (const bool ends : {true, false}) {
    CsvTrajectory another(csv, 1);
    another(0.0, PhasePoint<double, 1>(1, 2));
    if (ends) another.commit();
  }
  {  // it begins with the same rows, and has more
    PhasePoint<double, 1> z(-3, 0);
    CsvTrajectory another(csv, 1);
    integrate(stepper, z, {.dt = 0.1, .steps = 40}, another);
  }
  const std::string longer = contents(csv.string() + ".part");
  for (const std::int64_t steps : {18, 25, 30}) run(csv, file, steps, steps == 30);
  CHECK(contents(csv) == contents(folder.path / "whole.csv"));
  CHECK(contents(csv.string() + ".part.1") == longer);  // where the first rows of this run were
  CHECK(fs::exists(csv.string() + ".part.2"));
  CHECK_FALSE(fs::exists(csv.string() + ".part.3"));
}

TEST_CASE("A CSV file goes on where the checkpoint has it, byte for byte", "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint", csv = folder.path / "run.csv",
                 part = csv.string() + ".part";
  const systems::Product<double> h;
  IntegrationOptions<double> options{.dt = 0.1, .steps = 100};
  struct Killed {};
  /// Runs until it is done or dies after some steps; what was written after the last checkpoint stays in the
  /// .part.
  const auto run = [&](std::int64_t dies, bool has_rows = false) {
    GaussLegendre stepper(h, {.stages = 2});
    PhasePoint<double, 1> z(-3, 0);
    CsvTrajectory trajectory(csv, 1);
    if (has_rows) trajectory(-1.0, z);
    auto thirds = every(3, trajectory);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, thirds);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, thirds, checkpoints,
              [&](double, const auto&, const IntegrationReport& so_far) {
                if (so_far.steps == dies) throw Killed();
              });
    trajectory.commit();
    checkpoints.remove();
  };
  run(-1);
  const std::string whole = contents(csv);
  fs::remove(csv);
  for (const std::int64_t dies : {9, 10, 37, 59, 99}) CHECK_THROWS_AS(run(dies), Killed);
  CHECK(options.done.steps == 50);
  CHECK(contents(part).size() > 1000);
  CHECK_FALSE(fs::exists(csv));

  const std::string rows = contents(part), kept = contents(file);
  for (const std::string& other : {rows.substr(0, 500), "T" + rows.substr(1), std::string()}) {
    std::ofstream(part, std::ios::binary) << other;
    CHECK(refuses([&] { run(-1); }, "run.csv.part is not what it was when the checkpoint was written"));
    CHECK(contents(file) == kept);
  }
  std::ofstream(part, std::ios::binary) << rows << "0.1,0.";  // a row that was cut off
  options.dt = 0.2;
  CHECK(refuses([&] { run(-1); }, "'dt: 0.1"));  // and the rows are still there
  options.dt = 0.1;
  run(-1);
  CHECK(contents(csv) == whole);
  CHECK_FALSE(fs::exists(part));
  CHECK_FALSE(fs::exists(file));

  // Killed between commit() and remove(): the rows have their name already.
  std::ofstream(file, std::ios::binary) << kept;
  run(-1);
  CHECK(contents(csv) == whole);
  CHECK_FALSE(fs::exists(part));

  // The same behind rows that were written before the run is gone on with.
  std::ofstream(file, std::ios::binary) << kept;
  run(-1, true);
  CHECK(contents(csv) == whole);
}

TEST_CASE("Where a CSV file does not fit its checkpoint, a run from the start saves its own rows",
          "[checkpoint]") {
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint", csv = folder.path / "run.csv";
  const auto run = [&](bool anew) {
    GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
    PhasePoint<double, 1> z(-3, 0);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 25};
    CsvTrajectory trajectory(csv, 1);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, trajectory);
    if (anew)
      CHECK(refuses([&] { checkpoints.resume(z); }, "is not what it was"));
    else
      options.done = checkpoints.resume(z);
    integrate(stepper, z, options, trajectory, checkpoints);
    return options.done.steps;
  };
  run(false);
  const std::string rows = contents(csv.string() + ".part");
  std::ofstream(csv.string() + ".part", std::ios::binary) << "T" + rows.substr(1);
  run(true);
  CHECK(run(false) == 20);
  CHECK(contents(csv.string() + ".part") == rows);
}

TEST_CASE("A resume() that is refused for one CSV file leaves the others' rows", "[checkpoint]") {
  const Folder folder;
  const fs::path first = folder.path / "first.csv", second = folder.path / "second.csv";
  const fs::path first_part = first.string() + ".part", second_part = second.string() + ".part";
  const auto run = [&](bool stops) {
    GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
    PhasePoint<double, 1> z(-3, 0);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 50};
    CsvTrajectory one(first, 1), other(second, 1);
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options, one, other);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, one, other, checkpoints,
              [&](double t, const auto&) { return !(stops && t > 2.45); });
    return options.done.steps;
  };
  run(true);
  const std::string rows = contents(first_part);
  fs::rename(second_part, folder.path / "elsewhere");
  CHECK(refuses([&] { run(false); }, "second.csv.part is not what it was"));
  CHECK(contents(first_part) == rows);  // those behind the checkpoint, too
  fs::rename(folder.path / "elsewhere", second_part);
  CHECK(run(false) == 20);
}

TEST_CASE("Checkpoints of a run of which only a later part is known are refused", "[checkpoint]") {
  const Folder folder;
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  const PhasePoint<double, 1> start(-3, 0);
  auto z = start;
  const auto first = integrate(stepper, z, {.dt = 0.1, .steps = 20});
  const auto middle = z;
  IntegrationOptions<double> options{.dt = 0.1, .steps = 50, .done = first};
  {
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
    const auto go_on = [&] { integrate(stepper, z, options, checkpoints); };
    CHECK_THROWS_WITH(go_on(), Catch::Contains("call resume() with the initial state"));
    CHECK_THROWS_WITH(checkpoints.save(z, first), Catch::Contains("call resume() with the initial state"));
    auto began = start;
    checkpoints.resume(began);
    z = middle;
    go_on();
  }
  Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
  auto resumed = start;
  CHECK(checkpoints.resume(resumed).steps == 50);
  CHECK(same(resumed, z));
}

TEST_CASE("Rows that a checkpoint counts on stay where a run is stopped", "[checkpoint]") {
  const Folder folder;
  const fs::path csv = folder.path / "run.csv";
  const systems::Product<double> h;
  const IntegrationOptions<double> fresh{.dt = 0.1, .steps = 30};
  const auto run = [&](bool stops) {
    auto options = fresh;
    Semiexplicit stepper(h, schemes::blanes_moan4());
    PhasePoint<double, 1> z(-3, 0);
    CsvTrajectory trajectory(csv, 1);
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options, trajectory);
    options.done = checkpoints.resume(z);
    const auto report = integrate(stepper, z, options, trajectory, checkpoints,
                                  [&](double t, const auto&) { return !(stops && t > 1.45); });
    if (report.status == Status::success) trajectory.commit();
    return report.steps;
  };
  CHECK(run(true) == 15);
  CHECK(fs::exists(csv.string() + ".part"));
  CHECK(run(false) == 30);
  CHECK(fs::exists(csv));
}

TEST_CASE("Sections and exponents go on, and what was not named is refused", "[checkpoint]") {
  const Folder folder;
  const auto h =
      from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; });
  const IntegrationOptions<double> fresh{.dt = 0.05, .steps = 400};
  struct Result {
    std::int64_t crossings;
    double exponent;
  };
  const auto run = [&](std::int64_t stop_at, bool named) {
    auto options = fresh;
    Semiexplicit stepper(h, schemes::blanes_moan4());
    PhasePoint<double, 1> z(-3, 0);
    auto section = poincare_section(
        h, [](const auto& q, const auto&) { return q[0]; }, [](double, const auto&) {});
    LyapunovExponents lyapunov(stepper, 1);
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 50}, stepper, options, section,
                            lyapunov);
    options.done = checkpoints.resume(z);
    const auto stop = [&](double, const auto&, const IntegrationReport& so_far) {
      return so_far.steps != stop_at;
    };
    LyapunovExponents other(stepper, 1);
    if (named)
      integrate(stepper, z, options, section, lyapunov, checkpoints, stop);
    else
      integrate(stepper, z, options, section, other, checkpoints, stop);
    return Result{section.count(), lyapunov.exponents()[0]};
  };
  const Result whole = run(-1, true);
  fs::remove(folder.path / "run.checkpoint");
  run(170, true);
  CHECK(refuses([&] { run(-1, false); }, "resumed after step 150"));
  const Result resumed = run(-1, true);
  CHECK(whole.crossings > 3);
  CHECK(resumed.crossings == whole.crossings);
  CHECK(resumed.exponent == whole.exponent);
}

TEST_CASE("A change of the working directory takes no file along", "[checkpoint]") {
  struct Back {
    fs::path before = fs::current_path();
    ~Back() { fs::current_path(before); }
  };
  Folder here, there;
  const Back back;
  fs::current_path(here.path);
  Semiexplicit stepper(systems::Product<double>(), schemes::strang());
  PhasePoint<double, 1> z(-3, 0);
  {
    const IntegrationOptions<double> options{.dt = 0.01, .steps = 40};
    Checkpoints checkpoints("run.checkpoint", {.every = 10}, stepper, options);
    CsvWriter rows("run.csv", {"t"});
    integrate(stepper, z, options, checkpoints, [&](double t, const auto&) {
      rows.row({t});
      if (t > 0.2) fs::current_path(there.path);
    });
    rows.commit();
    CHECK(fs::is_empty(there.path));
    CHECK(fs::exists(here.path / "run.csv"));
    CHECK(fs::exists(here.path / "run.checkpoint"));
    checkpoints.remove();
    CHECK(!fs::exists(here.path / "run.checkpoint"));
  }
  // Killed between commit() and remove(): the file that has its name is found from elsewhere, too.
  const auto run = [&](bool again) {
    fs::current_path(here.path);
    z = PhasePoint<double, 1>(-3, 0);
    IntegrationOptions<double> options{.dt = 0.01, .steps = 40};
    CsvTrajectory rows("rows.csv", 1);
    Checkpoints checkpoints("rows.checkpoint", {.every = 40}, stepper, options, rows);
    fs::current_path(there.path);
    options.done = checkpoints.resume(z);
    CHECK(options.done.steps == (again ? 40 : 0));
    integrate(stepper, z, options, rows, checkpoints);
    rows.commit();
  };
  run(false);
  run(true);
  CHECK(fs::exists(here.path / "rows.csv"));
}

}  // namespace test_files
