#include "catch.hpp"

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_options {

// A run is not resumed with other options than it was saved with, those of a user's own classes included.

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

/// A solver written outside the library: a fixed number of damped corrections.
struct Damped {
  static constexpr const char* name = "Damped";
  double damping = 1;
  int count = 1;

  template <class List>
  void describe(List& list) const {
    list("damping", damping);
    list("count", count);
  }
  template <class Vec>
  struct Workspace {
    Workspace(const Damped&, Eigen::Index size) : f(Vec::Zero(size)) {}
    Vec f;
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    m.setZero();
    residual(work.f);
    for (int k = 1; k < count; ++k) {
      m -= damping * work.f / 4;
      residual(m, work.f);
    }
    return {.status = Status::success, .evaluations = count};
  }
};

/// An observer written outside the library.
struct Mean {
  static constexpr const char* name = "Mean";
  double power = 1, sum = 0;
  std::int64_t count = 0;

  void operator()(double, const Point& z) {
    sum += std::pow(z.q()[0], power);
    ++count;
  }
  bool fresh() const { return count == 0; }
  template <class List>
  void describe(List& list) const {
    list("power", power);
  }
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(sum);
    visit(count);
  }
};

/// A stepper written outside the library: the explicit Euler method for a fall.
struct Fall {
  using Scalar = double;
  using State = Point;
  static constexpr const char* name = "Fall";
  double g = 9.81;

  StepReport step(State& z, const double& dt) {
    z.q()[0] += dt * z.p()[0];
    z.p()[0] -= dt * g;
    return {.evaluations = 1, .gradients = 1};
  }
  template <class List>
  void describe(List& list) const {
    list("g", g);
  }
  template <class Visitor>
  void visit_memory(Visitor&&) {}
};

/// One that lists nothing: by whether it says its Hamiltonian, or lists it, another is known.
template <bool says, bool lists>
struct Rotation {
  using Scalar = double;
  using State = Point;
  static constexpr const char* name = "Rotation";
  double omega = 1;

  struct Oscillator {
    using Scalar = double;
    static constexpr int Dof = 1;
    double omega;
    void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
      dHdq = omega * q;
      dHdp = omega * p;
    }
  } own{omega};

  StepReport step(State& z, const double& dt) {
    const double q = z.q()[0], p = z.p()[0], c = std::cos(omega * dt), s = std::sin(omega * dt);
    z = State(c * q + s * p, c * p - s * q);
    return {};
  }
  const Oscillator& hamiltonian() const requires says { return own; }
  template <class List>
  void describe(List& list) const {
    if (lists) list.function("H", GradientSize(own));
  }
  template <class Visitor>
  void visit_memory(Visitor&&) {}
};

/// An observer that lets copies of its numbers be visited.
struct Copied {
  static constexpr const char* name = "Copied";
  double sum = 0;
  void operator()(double, const Point& z) { sum += z.q()[0]; }
  template <class List>
  void describe(List&) const {}
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    Eigen::Vector2d all(sum, 1);
    visit(all);
  }
};

/// Saves a run that was made with one stepper and observer, and says what is said of resuming it with others.
struct Saved {
  Folder folder;
  std::filesystem::path file = folder.path / "run.checkpoint";
  IntegrationOptions<double> options{.dt = 0.05, .steps = 20};

  template <class Stepper, class... Observers>
  Saved(Stepper stepper, Observers... observers) {
    Point z(-3, 0);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, observers...);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, observers..., checkpoints);
  }
  template <class Stepper, class... Observers>
  std::string resumed(Stepper stepper, Observers... observers) const {
    Point z(-3, 0);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options, observers...);
    return refusal([&] { checkpoints.resume(z); });
  }
};

/// An observer that hands on what its file says of itself.
struct NamedColumns {
  static constexpr const char* name = "NamedColumns";
  std::shared_ptr<CsvWriter> csv;

  void operator()(double, const Point&) {}
  template <class List>
  void describe(List& list) const {
    csv->describe(list);
  }
  template <class Visitor>
  void visit_memory(Visitor&&) {}
};

const systems::Product<double> h;
auto usual() { return Semiexplicit(h, schemes::strang<double>()); }
const auto q_of = [](const auto& q, const auto&) { return q[0]; };
const auto nothing = [](double, const Point&) {};

}  // namespace

TEST_CASE("Options are listed with all their digits, and texts of any type as texts", "[checkpoint]") {
  detail::OptionText list;
  list("whole", std::vector<int>{11, -123456});
  list("many", std::array<long, 1>{9007199254740993});
  list("text", std::string_view("abc"));
  CHECK(list.text() == "whole: 2 numbers 11 -123456\nmany: 1 numbers 9007199254740993\ntext: abc\n");
}

TEST_CASE("An observer that another one refers to is saved as one of its own", "[checkpoint]") {
  Mean mean;
  auto of_its_own = every(2, mean);
  auto referring = every(2, std::ref(mean));
  CheckpointMemory own, referred;
  of_its_own.visit_memory(own);
  referring.visit_memory(referred);
  CHECK(own.bytes() == referred.bytes());
  detail::OptionText options, of_referred;
  of_its_own.describe(options);
  referring.describe(of_referred);
  CHECK(options.text() == of_referred.text());
}

TEST_CASE("A user's own solver, stepper and observer are resumed with their own options only",
          "[checkpoint]") {
  const auto with = [](const Damped& solver) { return Semiexplicit(h, schemes::strang<double>(), solver); };
  const Saved solver(with({.damping = 1, .count = 3}));
  CHECK(solver.resumed(with({.damping = 1, .count = 3})) == accepted);
  CHECK(says(solver.resumed(with({.damping = 1. / 3, .count = 3})),
             "'solver damping: 1' there, 'solver damping: 0.33333333333333331' here"));
  CHECK(says(solver.resumed(with({.damping = 1, .count = 2})), "'solver count: 3' there"));
  const Saved third(with({.damping = 1. / 3, .count = 3}));
  CHECK(says(third.resumed(with({.damping = 0.3, .count = 3})), "'solver damping"));

  const Saved fall(Fall{});
  CHECK(fall.resumed(Fall{}) == accepted);
  CHECK(says(fall.resumed(Fall{.g = 1.62}), "'g: 9.8"));
  CHECK(says(fall.resumed(usual()), "'stepper: Fall' there, 'stepper: Semiexplicit' here"));

  const Saved said(Rotation<true, false>{});
  CHECK(said.resumed(Rotation<true, false>{}) == accepted);
  CHECK(says(said.resumed(Rotation<true, false>{.omega = 2}), "it belongs to another Hamiltonian:"));
  const Saved listed(Rotation<false, true>{});
  CHECK(listed.resumed(Rotation<false, true>{}) == accepted);
  CHECK(says(listed.resumed(Rotation<false, true>{.omega = 2}), "it belongs to another H:"));

  const Saved mean(usual(), Mean{});
  CHECK(mean.resumed(usual(), Mean{}) == accepted);
  CHECK(says(mean.resumed(usual(), Mean{.power = 2}), "'observer 1 power: 1' there"));
}

TEST_CASE("What is not put back, or saved of another stepper, is refused", "[checkpoint]") {
  const Saved copied(usual(), Copied{});
  CHECK(says(copied.resumed(usual(), Copied{}), "visits copies of its numbers, or changes them"));

  const Folder folder;
  IntegrationOptions<double> options{.dt = 0.05, .steps = 20};
  auto stepper = usual(), copy = usual();
  Point z(-3, 0);
  Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
  CHECK(refuses([&] { integrate(copy, z, options, checkpoints); }, "save another stepper, or a copy"));
  integrate(stepper, z, options, checkpoints);

  // A run that begins with the state of resume(), as if it were its first.
  Point again(-3, 0);
  Checkpoints other(folder.path / "run.checkpoint", {.every = 10}, stepper, options);
  const IntegrationReport done = other.resume(again);
  REQUIRE(done.steps == 20);
  options.steps = 40;
  CHECK(says(complaint<std::logic_error>([&] { integrate(stepper, again, options, other); }),
             "put the state back to step 20"));
  options.done = done;
  CHECK(integrate(stepper, again, options, other).steps == 40);
}

TEST_CASE("Every option of the library's solvers and steppers counts", "[checkpoint]") {
  const auto scheme = schemes::strang<double>();
  const auto differs = [&](const auto& first, const auto& second, const std::string& what) {
    CAPTURE(what);
    const Saved saved(first);
    CHECK(saved.resumed(first) == accepted);
    CHECK(says(saved.resumed(second), what));
  };
  const auto with = [&](const auto& solver) { return Semiexplicit(h, scheme, solver); };
  differs(with(SimplifiedNewton{}), with(SimplifiedNewton{.max_iterations = 9}), "solver max_iterations");
  differs(with(SimplifiedNewton{}), with(SimplifiedNewton{.stop = StoppingRule::paper(1e-16)}), "rule kind");
  differs(with(SimplifiedNewton{}), with(SimplifiedNewton{.stop = StoppingRule::product(1e-17)}),
          "rule tolerance");
  differs(with(Broyden{}), with(Broyden{.max_iterations = 9}), "solver max_iterations");
  differs(with(Broyden{}), with(Broyden{.memory = 9}), "solver memory");
  differs(with(NewtonKrylov{}), with(NewtonKrylov{.max_iterations = 9}), "solver max_iterations");
  differs(with(NewtonKrylov{}), with(NewtonKrylov{.directions = 9}), "solver directions");
  differs(with(Robust{}), with(Robust{.newton_iterations = 9}), "solver newton_iterations");
  differs(with(Robust{}), with(Robust{.broyden_iterations = 9}), "solver broyden_iterations");
  differs(with(Robust{}), with(Robust{.max_iterations = 9}), "solver max_iterations");
  differs(usual(), Semiexplicit(h, scheme, SimplifiedNewton{}, Summation::plain), "summation");
  differs(usual(), MidpointProjection(h, scheme), "stepper: Semiexplicit");
  differs(GaussLegendre(h), GaussLegendre(h, {.tolerance = 1e-14}), "tolerance");
  differs(GaussLegendre(h), GaussLegendre(h, {.max_iterations = 50}), "max_iterations");
  differs(GaussLegendre(h), GaussLegendre(h, {.solver = StageSolver::newton}), "stage solver");
  differs(GaussLegendre(h), GaussLegendre(h, {.extrapolate = false}), "extrapolate");
}

TEST_CASE("Every option of the library's observers counts", "[checkpoint]") {
  const auto differs = [&](const auto& first, const auto& second, const std::string& what) {
    CAPTURE(what);
    const Saved saved(usual(), first);
    CHECK(saved.resumed(usual(), first) == accepted);
    CHECK(says(saved.resumed(usual(), second), what));
  };
  const Record<double, 1> record;
  differs(every(10, Record(record)), every(7, Record(record)),
          "'observer 1 n: 10' there, 'observer 1 n: 7' here");
  differs(every(10, Mean{}), every(10, Mean{.power = 2}), "'observer 1 observer power: 1'");
  differs(at_times(h, {0.0, 0.5}, nothing), at_times(h, {0.0, 0.6}, nothing), "observer 1 times");
  differs(at_times(h, {0.0, 0.5}, nothing), at_times(h, {0.0, 0.5, 0.7}, nothing),
          "observer 1 times: 2 numbers");
  differs(at_times(h, {0.0, 0.5}, nothing), at_times(h, {0.0, 0.5}, nothing, 5), "observer 1 nodes");
  const auto section = [](auto surface, PoincareSectionOptions options = {}) {
    return poincare_section(h, surface, nothing, options);
  };
  differs(section(q_of), section([](const auto& q, const auto&) { return q[0] - 0.01; }), "another surface");
  differs(section(q_of), section(q_of, {.direction = CrossingDirection::both}), "observer 1 direction");
  const auto following = [](auto f) {
    Invariants<double, 1> invariants(h);
    invariants.add("mine", f);
    return invariants;
  };
  differs(following(q_of), following([](const auto& q, const auto&) { return 1.001 * q[0]; }),
          "another mine");
  const auto infinite = [&](double c) {
    return following([c](const auto&, const auto&) { return c / 0.0; });
  };
  differs(infinite(1), infinite(-1), "another mine");
  differs(infinite(1), following(q_of), "another mine");
  const auto file = [](const char* name) {
    return NamedColumns{std::make_shared<CsvWriter>("/dev/null", std::vector<std::string>{"t", name})};
  };
  differs(file("energy"), file("mass"), "observer 1 columns: t,energy");
  auto stepper = usual();
  differs(LyapunovExponents(stepper, 1), LyapunovExponents(stepper, 2), "observer 1 exponents: 1");

  // What has a Hamiltonian of its own, beside that of the stepper.
  const auto stretched = [](double k) {
    return from_energy<1>([k](const auto& q, const auto& p) { return (k * q[0] * q[0] + p[0] * p[0]) / 2; });
  };
  const std::string other = "another Hamiltonian";
  differs(at_times(stretched(1), {0.0, 0.5}, nothing), at_times(stretched(2), {0.0, 0.5}, nothing), other);
  differs(poincare_section(stretched(1), q_of, nothing), poincare_section(stretched(2), q_of, nothing),
          other);
  differs(events(stretched(1), on_event(q_of, nothing)), events(stretched(2), on_event(q_of, nothing)),
          other);
  const auto of = [&](double k) { return Semiexplicit(stretched(k), schemes::strang<double>()); };
  differs(LyapunovExponents(of(1), 1), LyapunovExponents(of(2), 1), other);
  differs(AlignmentIndex(of(1), 2), AlignmentIndex(of(2), 2), other);
}

TEST_CASE("Another Hamiltonian of the same kind is refused", "[checkpoint]") {
  const auto stretched = [](double k) {
    return Semiexplicit(
        make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                    [k](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                      dHdq[0] = k * q[0];
                                      dHdp[0] = p[0];
                                    }),
        schemes::strang<double>());
  };
  const Saved saved(stretched(1));
  CHECK(saved.resumed(stretched(1)) == accepted);
  CHECK(says(saved.resumed(stretched(1 + 1e-9)), "another Hamiltonian"));
  CHECK(says(saved.resumed(stretched(-1)), "another Hamiltonian"));

  // A mass, which makes the forces larger and the velocities smaller by the same factor.
  const auto of_mass = [](double m) {
    return Semiexplicit(
        make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                    [m](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                      dHdq[0] = m * q[0];
                                      dHdp[0] = p[0] / m;
                                    }),
        schemes::strang<double>());
  };
  const Saved light(of_mass(1));
  CHECK(light.resumed(of_mass(1)) == accepted);
  CHECK(says(light.resumed(of_mass(2)), "another Hamiltonian"));
  CHECK(says(light.resumed(of_mass(1 + 1e-9)), "another Hamiltonian"));
}

namespace {
/// What is said where one goes on with what the other has saved.
std::string saved_and_resumed(auto stepper, auto other) {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  PhasePoint<double, 2> start({10, 1}, {0.5, 0.3}), z = start;
  IntegrationOptions<double> options{.dt = 0.1, .steps = 20};
  {
    Checkpoints checkpoints(file, {.every = 10}, stepper, options);
    integrate(stepper, z, options, checkpoints);
  }
  z = start;
  std::string said = "accepted";
  try {
    Checkpoints(file, {.every = 10}, other, options).resume(z);
  } catch (const std::invalid_argument& refusal) {
    said = refusal.what();
  }
  return said;
}
}  // namespace

TEST_CASE("A Hamiltonian that differs in a sign, or in the smaller entries of its gradient, is refused",
          "[checkpoint]") {
  // A charge in the field of another one, repelled or attracted, in units where the force is far smaller than
  // the velocity.
  for (const double unit : {1.0, 1e-14}) {
    const auto charges = [unit](double k, double turn = 1) {
      return Semiexplicit(
          make_hamiltonian<double, 2>([](const auto&, const auto&) { return 0.0; },
                                      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                        const double r = q.norm();
                                        dHdq = -k * unit * q / (r * r * r);
                                        dHdp = p;
                                        dHdp[1] *= turn;
                                      }),
          schemes::strang<double>());
    };
    CAPTURE(unit);
    CHECK(saved_and_resumed(charges(1), charges(1)) == "accepted");
    CHECK(says(saved_and_resumed(charges(1), charges(-1)), "another Hamiltonian"));
    CHECK(says(saved_and_resumed(charges(1), charges(1 + 1e-9)), "another Hamiltonian"));
    CHECK(says(saved_and_resumed(charges(1), charges(1, -1)), "another Hamiltonian"));
  }

  // What is light beside something heavy.
  const auto beside = [](double k) {
    return Semiexplicit(from_energy<2>([k](const auto& q, const auto& p) {
                          return (q[0] * q[0] + p[0] * p[0] + 1e-13 * (k * q[1] * q[1] + p[1] * p[1])) / 2;
                        }),
                        schemes::strang<double>());
  };
  CHECK(saved_and_resumed(beside(1), beside(1)) == "accepted");
  CHECK(says(saved_and_resumed(beside(1), beside(2)), "another Hamiltonian"));
  CHECK(says(saved_and_resumed(beside(1), beside(1 + 1e-9)), "another Hamiltonian"));

  // One that is no longer there, where all others are equal.
  const auto turning = [](double a, double b) {
    return Semiexplicit(make_hamiltonian<double, 2>([](const auto&, const auto&) { return 0.0; },
                                                    [=](const auto&, const auto&, auto& dHdq, auto& dHdp) {
                                                      dHdq.setZero();
                                                      dHdp[0] = a, dHdp[1] = b;
                                                    }),
                        schemes::strang<double>());
  };
  CHECK(saved_and_resumed(turning(2, 0), turning(2, 0)) == "accepted");
  CHECK(says(saved_and_resumed(turning(2, 2), turning(2, 0)), "another Hamiltonian"));
  CHECK(says(saved_and_resumed(turning(2, 0), turning(0, 2)), "another Hamiltonian"));
}

TEST_CASE("A Record comes back whole, also within every(), or the run is refused", "[checkpoint]") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  auto whole = usual();
  Point w(-3, 0);
  Record<double, 1> all_of_it;
  integrate(whole, w, {.dt = 0.05, .steps = 1000}, all_of_it);

  Record<double, 1> all, some;
  for (const bool first : {true, false}) {
    auto stepper = usual();
    Point z(-3, 0);
    Record<double, 1> kept, tenth;
    auto tenths = every(10, tenth);
    const IntegrationOptions<double> options{.dt = 0.05, .steps = 1000};
    IntegrationOptions<double> resumed = options;
    Checkpoints checkpoints(file, {.every = 100}, stepper, options, kept, tenths);
    resumed.done = checkpoints.resume(z);
    if (first) resumed.steps = 750;
    integrate(stepper, z, resumed, kept, tenths, checkpoints);
    all = kept;
    some = tenth;
    if (!first) {
      Record<double, 1> unnamed;
      CHECK(refuses([&] { integrate(stepper, z, resumed, unnamed); }, "name it among those"));
      CHECK(refuses([&] { integrate(stepper, z, resumed, every(10, unnamed)); }, "name it among those"));
    }
  }
  REQUIRE(all.t.size() == 1001);
  REQUIRE(some.t.size() == 101);
  for (std::size_t i = 0; i < all.z.size(); ++i) CHECK(all.z[i].vector() == all_of_it.z[i].vector());
  CHECK(all.t == all_of_it.t);
  for (std::size_t i = 0; i < some.z.size(); ++i) CHECK(some.z[i].vector() == all_of_it.z[10 * i].vector());
}

TEST_CASE("What an observer within at_times() or a section remembers is resumed, too", "[checkpoint]") {
  const Folder folder;
  const auto run = [&](std::int64_t stop_at, std::int64_t resumed_at) {
    auto stepper = usual();
    Point z(-3, 0);
    CsvTrajectory rows(folder.path / "rows.csv", 1);
    Record<double, 1> crossings;
    auto at = at_times(h, {1., 2., 3., 4., 5., 6., 7., 8., 9.}, rows);
    auto section = poincare_section(h, q_of, crossings);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 100};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 25}, stepper, options, at, section);
    options.done = checkpoints.resume(z);
    CHECK(options.done.steps == resumed_at);
    options.steps = stop_at;
    integrate(stepper, z, options, at, section, checkpoints);
    if (stop_at == 100) rows.commit();
    CHECK(static_cast<std::int64_t>(crossings.t.size()) == section.count());
    return crossings.t.size();
  };
  run(70, 0);
  CHECK(run(100, 50) >= 2);
  std::ifstream in(folder.path / "rows.csv");
  int lines = 0;
  for (std::string line; std::getline(in, line);) ++lines;
  CHECK(lines == 10);
}

TEST_CASE(
    "A run saved before the first of its at_times() is resumed, and one that does not name it is refused",
    "[checkpoint]") {
  for (const bool named : {true, false}) {
    const Folder folder;
    const auto run = [&](std::int64_t stop_at) {
      auto stepper = usual();
      Point z(-3, 0);
      Record<double, 1> record;
      auto late = at_times(h, {6., 8.}, record);
      IntegrationOptions<double> options{.dt = 0.1, .steps = 100};
      const auto go = [&](auto&&... saved) {
        Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 25}, stepper, options, saved...);
        options.done = checkpoints.resume(z);
        options.steps = stop_at;
        integrate(stepper, z, options, late, checkpoints);
      };
      if (named)
        go(late);
      else
        go();
      return record.t;
    };
    CHECK(run(50).empty());
    if (named)
      CHECK(run(100) == std::vector<double>{6., 8.});
    else
      CHECK_THROWS_AS(run(100), std::invalid_argument);
  }
}

TEST_CASE("every() that is not named keeps its phase in a resumed run", "[checkpoint]") {
  const Folder folder;
  std::vector<double> times;
  for (const std::int64_t stop_at : {1500, 5000}) {
    auto stepper = usual();
    Point z(-3, 0);
    Record<double, 1> record;
    IntegrationOptions<double> options{.dt = 0.01, .steps = 5000};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 700}, stepper, options, record);
    options.done = checkpoints.resume(z);
    options.steps = stop_at;
    integrate(stepper, z, options, every(1000, record), checkpoints);
    times = record.t;
  }
  REQUIRE(times.size() == 6);
  for (std::size_t i = 0; i < 6; ++i) CHECK(times[i] == Approx(10. * double(i)));
}

TEST_CASE("A resume() that is refused leaves the observers as they were", "[checkpoint]") {
  const Folder folder;
  const auto path = folder.path / "rows.csv";
  Record<double, 1> record;
  std::string said;
  for (const bool first : {true, false}) {
    auto stepper = usual();
    Point z(-3, 0);
    record = {};
    Invariants invariants(h);
    CsvTrajectory rows(path, 1);
    IntegrationOptions<double> options{.dt = 0.1, .steps = 100};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 50}, stepper, options, record,
                            invariants, rows);
    said = refusal([&] { options.done = checkpoints.resume(z); });
    integrate(stepper, z, options, record, invariants, rows, checkpoints);
    CHECK(record.t.size() == 101);
    if (first) continue;
    rows.commit();
    checkpoints.remove();
  }
  CHECK(said == accepted);  // the first run left its rows as they were

  const auto other = folder.path / "other.csv";
  for (const bool first : {true, false}) {
    auto stepper = usual();
    Point z(-3, 0);
    record = {};
    IntegrationOptions<double> options{.dt = 0.1, .steps = 100};
    if (!first) std::ofstream(other.string() + ".part") << "something else";
    CsvTrajectory rows(other, 1);
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 50}, stepper, options, record, rows);
    said = refusal([&] { options.done = checkpoints.resume(z); });
    if (!first) {
      CHECK(says(said, "is not what it was"));
      CHECK(record.t.empty());
    }
    integrate(stepper, z, options, record, rows, checkpoints);
    CHECK(record.t.size() == 101);
  }
}

}  // namespace test_options
