#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <exception>
#include <functional>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

namespace test_turned_runs {

// Observers of several runs: there and back, on from where the last one ended, another orbit.

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

/// A rotation, q + ip = e^{-it}, up to the step's own error.
const auto rotor =
    make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
                                [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                  dHdq[0] = q[0];
                                  dHdp[0] = p[0];
                                });
auto stepper() { return Semiexplicit(rotor, schemes::low_defect6_s13<double>()); }
const auto position = [](const auto& q, const auto&) { return q[0]; };

/// A section of q = 0 that lists the times.
struct Section {
  std::vector<double> times;
  PoincareSectionOptions options{.direction = CrossingDirection::both};
  auto observer(const auto& surface) {
    return poincare_section(
        rotor, surface, [this](double t, const Point&) { times.push_back(t); }, options);
  }
};

}  // namespace

TEST_CASE("A section sees every crossing of a run there and back, wherever it turns", "[observers]") {
  for (int steps = 1; steps <= 40; ++steps) {
    CAPTURE(steps);
    Section there, back;
    auto one = there.observer(position), both = back.observer(position);
    auto move = stepper();
    Point z(1, 0.03);
    integrate(move, z, {.dt = 0.1, .steps = steps}, one, both);
    one.finish();
    integrate(move, z, {.dt = -0.1, .steps = steps, .t0 = 0.1 * steps}, both);
    both.finish();
    REQUIRE(back.times.size() == 2 * there.times.size());
    for (std::size_t i = 0; i < there.times.size(); ++i) {
      // The order of the interpolation is lower in a run of few steps.
      const double accuracy = steps < 19 ? 1e-4 : 1e-7;
      CHECK(back.times[i] == Approx(there.times[i]).margin(accuracy));
      CHECK(back.times[back.times.size() - 1 - i] == Approx(there.times[i]).margin(accuracy));
    }
  }
}

TEST_CASE("Times are served in the first interval after a run turned round", "[observers]") {
  std::vector<double> seen;
  auto move = stepper();
  Point z(1, 0);
  integrate(move, z, {.dt = 0.1, .steps = 10});
  auto at = at_times(rotor, {1.0, 0.97, 0.03, 0.0}, [&](double t, const Point& w) {
    seen.push_back(t);
    CHECK(w.q()[0] == Approx(std::cos(t)).margin(1e-9));
  });
  integrate(move, z, {.dt = -0.1, .steps = 10, .t0 = 1}, at);
  CHECK(seen == std::vector<double>{1.0, 0.97, 0.03, 0.0});
}

TEST_CASE("A section does not connect the end of one orbit with the start of another", "[observers]") {
  Section section;
  auto observer = section.observer(position);
  auto move = stepper();
  for (const double start : {1.0, -1.0, 1.0}) {
    Point z(start, 0);
    integrate(move, z, {.dt = 0.1, .steps = 10}, observer);  // to t = 1, before the crossing at π/2
  }
  observer.finish();
  CHECK(section.times.empty());
  // Started on the surface, where the last orbit was beside it.
  Point z(0, 1);
  integrate(move, z, {.dt = 0.1, .steps = 10}, observer);
  observer.finish();
  CHECK(section.times.empty());
}

TEST_CASE("A state that touches the surface is no crossing, one that goes through is", "[observers]") {
  for (const CrossingDirection direction :
       {CrossingDirection::rising, CrossingDirection::falling, CrossingDirection::both}) {
    const auto times_of = [&](const std::vector<double>& values) {
      Section section{.times = {}, .options = {.direction = direction}};
      auto observer = section.observer(position);
      for (std::size_t i = 0; i < values.size(); ++i) observer(double(i), Point(values[i], 0));
      observer.finish();
      return section.times;
    };
    const bool rises = direction != CrossingDirection::falling,
               falls = direction != CrossingDirection::rising;
    CHECK(times_of({-3, -2, -1, 0, -1, -2, -3, -4}).empty());
    CHECK(times_of({3, 2, 1, 0, 1, 2, 3, 4}).empty());
    CHECK(times_of({0, 0, 0, 0, 0}).empty());
    CHECK(times_of({0, 1, 2, 3, 4}).empty());
    CHECK(times_of({-2, -1, 0, 1, 2}) == (rises ? std::vector<double>{2} : std::vector<double>{}));
    CHECK(times_of({2, 1, 0, 0, -1, -2}) == (falls ? std::vector<double>{3} : std::vector<double>{}));
  }
}

TEST_CASE("Invariants, records and counts of a run there and back", "[observers]") {
  auto move = stepper();
  Point z(1, 0);
  Invariants invariants(rotor);
  Record<double, 1> record;
  int calls = 0;
  auto third = every(3, [&](double, const Point&) { ++calls; });
  integrate(move, z, {.dt = 0.1, .steps = 30}, invariants, record, third);
  integrate(move, z, {.dt = -0.1, .steps = 30, .t0 = 3}, invariants, record, third);
  CHECK(record.t.size() == 62);
  CHECK(record.t[31] == 3);
  CHECK(record.t.back() == Approx(0).margin(1e-15));
  CHECK(calls == 21);
  CHECK(invariants["energy"].worst < 1e-12);
  CHECK(z.q()[0] == Approx(1).epsilon(1e-12));
}

TEST_CASE("every() counts on from run to run, and begins anew with another orbit", "[observers]") {
  auto move = stepper();
  Point z(1, 0);
  Record<double, 1> record;
  auto tenth = every(10, record);
  for (int part = 0; part < 4; ++part) integrate(move, z, {.dt = 0.1, .steps = 10, .t0 = part * 1.0}, tenth);
  REQUIRE(record.t.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) CHECK(record.t[i] == Approx(double(i)));

  // Two orbits of different energies: what lies between the end of one and the start of the other is no
  // crossing.
  std::vector<double> energies;
  auto section = poincare_section(
      rotor, position, [&](double, const Point& w) { energies.push_back(w.vector().squaredNorm() / 2); },
      {.direction = CrossingDirection::both});
  auto fifth = every(5, section);
  for (const double amplitude : {1.0, 4.0}) {
    z = Point(amplitude, 0);
    integrate(move, z, {.dt = 0.02, .steps = 252}, fifth);
  }
  section.finish();
  REQUIRE(energies.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(energies[i] == Approx(i < 2 ? 0.5 : 8).epsilon(1e-6));
}

TEST_CASE("every() begins anew where a run starts from another state at the time of the last one",
          "[observers]") {
  auto move = stepper();
  Record<double, 1> record;
  std::vector<double> energies;
  auto section = poincare_section(
      rotor, position, [&](double, const Point& w) { energies.push_back(w.vector().squaredNorm() / 2); },
      {.direction = CrossingDirection::both});
  auto every_state = every(1, record);
  auto all = every(1, section);
  Point z(1, 0);
  integrate(move, z, {.dt = 0.1, .steps = 10}, every_state, all);
  z = Point(-1, -3);
  integrate(move, z, {.dt = 0.1, .steps = 10, .t0 = 1}, every_state, all);
  section.finish();
  CHECK(record.t.size() == 22);
  CHECK(energies.empty());  // neither arc passes 0
}

TEST_CASE("every() shows a state again at which its observer threw", "[observers]") {
  auto move = stepper();
  std::vector<double> rows;
  bool full = true;
  auto tenth = every(10, [&](double t, const Point&) {
    if (full && t > 1.95) throw std::runtime_error("disk full");
    rows.push_back(t);
  });
  double now = 0;
  const auto clock = [&](double t, const Point&) { now = t; };
  Point z(1, 0);
  CHECK_THROWS_WITH(integrate(move, z, {.dt = 0.1, .t_end = 4}, clock, tenth), "disk full");
  full = false;
  integrate(move, z, {.dt = 0.1, .t0 = now, .t_end = 4}, clock, tenth);
  REQUIRE(rows.size() == 5);
  for (std::size_t i = 0; i < 5; ++i) CHECK(rows[i] == Approx(double(i)));
}

TEST_CASE("every() counts on from an event at which a run ended", "[observers]") {
  auto move = stepper();
  std::vector<double> rows;
  auto fifth = every(5, [&](double t, const Point&) { rows.push_back(t); });
  auto end = events(rotor, on_event([](const auto& q, const auto&) { return q[0] - 0.5; },
                                    [](double, Point&) { return false; }));
  Point z(1, 0);
  const auto first = integrate(move, z, {.dt = 0.1, .steps = 40}, end, fifth);
  REQUIRE(first.steps == 10);
  REQUIRE(first.at_event);
  integrate(move, z, {.dt = 0.1, .steps = 12, .t0 = first.t}, end, fifth);
  REQUIRE(rows.size() == 5);
  for (std::size_t i = 0; i < 5; ++i)
    CHECK(rows[i] == Approx(i < 3 ? 0.5 * double(i) : first.t + 0.5 * double(i - 2)));
}

TEST_CASE("every() shows a section all of a run that bounces, or refuses", "[observers]") {
  const double period = 2 * (std::acos(-1.0) - std::acos(0.5));  // from bounce to bounce
  for (const int n : {1, 2, 3}) {
    CAPTURE(n);
    auto move = stepper();
    Point z(1, 0);
    auto bounce =
        events(rotor, on_event([](const auto& q, const auto&) { return q[0] + 0.5; },
                               [](double, Point& w) { w.p()[0] *= -1; }, CrossingDirection::falling));
    auto near_wall = poincare_section(
        rotor, [](const auto& q, const auto&) { return q[0] + 0.45; }, [](double, const Point&) {},
        {.direction = CrossingDirection::both});
    double worst = 0;
    std::vector<double> times;
    for (int i = 1; i < 400; ++i) times.push_back(0.1 * i + 0.013);
    auto at = at_times(rotor, times, [&](double t, const Point& w) {
      const double phase = std::remainder(t, period);
      worst = std::max(worst, std::abs(w.q()[0] - std::cos(phase)));
    });
    auto sparse_section = every(n, std::ref(near_wall));
    auto sparse_times = every(n, at);
    const auto run = [&] {
      integrate(move, z, {.dt = 0.05, .t_end = 40.1}, bounce, sparse_section, sparse_times);
    };
    if (n > 1) {
      CHECK_THROWS_WITH(run(), Catch::Contains("take every() away from it"));
      continue;
    }
    run();
    near_wall.finish();
    at.finish();
    CHECK(near_wall.count() == 2 * bounce.count());
    CHECK(at.served() == 399);
    CHECK(worst < 1e-4);
  }
}

TEST_CASE("every() within another observer counts the calls of that one", "[observers]") {
  auto move = stepper();
  Record<double, 1> served, crossings, events_seen;
  auto at = at_times(rotor, {0.05, 0.15, 0.25, 0.35, 0.45, 0.55, 0.65}, every(2, served));
  auto section = poincare_section(rotor, position, every(2, crossings));
  Point z(1, 0);
  integrate(move, z, {.dt = 0.1, .steps = 320}, at, section);
  section.finish();
  REQUIRE(served.t.size() == 4);
  for (std::size_t i = 0; i < 4; ++i) CHECK(served.t[i] == Approx(0.05 + 0.2 * double(i)));
  REQUIRE(crossings.t.size() == 3);
  for (std::size_t i = 0; i < 3; ++i)
    CHECK(crossings.t[i] == Approx((4 * double(i) + 1.5) * std::acos(-1.0)));

  auto bounces = events(
      rotor, on_event(position, every(2, events_seen)),
      on_event([](const auto&, const auto& p) { return p[0]; }, [](double, Point& w) { w.p()[0] = 0; }));
  z = Point(1, 0.01);
  integrate(move, z, {.dt = 0.1, .steps = 320}, bounces);
  CHECK(bounces.count(0) == 10);
  CHECK(events_seen.t.size() == 5);
}

TEST_CASE("Going on after finish() loses no interval", "[observers]") {
  for (const int first : {1, 2, 3, 4}) {
    Section section;
    auto observer = section.observer(position);
    std::vector<double> served;
    auto at = at_times(
        rotor, {0.15, 0.95, 3.0}, [&](double t, const Point&) { served.push_back(t); }, 6);
    auto move = stepper();
    Point z(std::cos(0.4), -std::sin(0.4));
    integrate(move, z, {.dt = 0.5, .steps = first}, observer, at);
    observer.finish();
    at.finish();
    integrate(move, z, {.dt = 0.5, .steps = 20, .t0 = 0.5 * first}, observer, at);
    observer.finish();
    CHECK(section.times.size() >= 3);
    CHECK(section.times.front() == Approx(std::numbers::pi / 2 - 0.4).margin(1e-2));
    CHECK(served == std::vector<double>{0.15, 0.95, 3.0});
  }
}

TEST_CASE("Another orbit is served the times anew, one that begins where the last one ended is not",
          "[observers]") {
  using Times = std::vector<double>;
  const auto served_by = [](double dt, Times times, const auto& second) {
    Times served;
    auto at = at_times(rotor, std::move(times), [&](double t, const Point&) { served.push_back(t); });
    auto move = stepper();
    Point z(1, 0), w(0.5, 0);
    integrate(move, z, {.dt = dt, .steps = 10}, at);
    at.finish();
    second(move, w, at);
    at.finish();
    return served;
  };
  const auto from = [](double t0, double dt) {
    return [=](auto& move, Point& w, auto& at) { integrate(move, w, {.dt = dt, .steps = 10, .t0 = t0}, at); };
  };
  CHECK(served_by(0.1, {0.0, 0.5, 1.0}, from(0, 0.1)) == Times{0, 0.5, 1, 0, 0.5, 1});
  CHECK(served_by(-0.1, {0.0, -0.5, -1.0}, from(0, -0.1)) == Times{0, -0.5, -1, 0, -0.5, -1});
  CHECK(served_by(0.1, {0.0, 7.0}, from(0, 0.1)) == Times{0, 0});
  CHECK(served_by(0.1, {0.5}, from(0, 0.1)) == Times{0.5, 0.5});
  CHECK(served_by(-0.1, {-0.5}, from(0, -0.1)) == Times{-0.5, -0.5});
  CHECK(served_by(0.1, {0.5, 1.0, 1.5}, from(1.0, 0.1)) == Times{0.5, 1, 1.5});  // changed by hand
  CHECK(served_by(0.1, {0.5, 1.0, 5.5}, from(5.0, 0.1)) == Times{0.5, 1, 5.5});  // after a gap
  CHECK(served_by(0.1, {0.0, 0.5, 1.0}, from(0.25, 0.1)) == Times{0, 0.5, 1, 0.5, 1});
}

TEST_CASE("The last of the times is served although n (T/n) is rounded below T", "[observers]") {
  int served = 0;
  for (int n = 1; n <= 300; ++n) {
    auto move = stepper();
    Point z(1, 0);
    auto at = at_times(rotor, {0.0, 0.5, 1.0}, [](double, const Point&) {});
    integrate(move, z, {.dt = 1.0 / n, .steps = n}, at);
    at.finish();
    served += static_cast<int>(at.served());
  }
  CHECK(served == 900);
  auto move = stepper();
  Point z(1, 0);
  auto start = at_times(rotor, {0.3, 0.5}, [](double, const Point&) {});
  integrate(move, z, {.dt = 0.1, .steps = 5, .t0 = 3 * 0.1}, start);  // 0.30000000000000004
  CHECK(start.served() == 2);
  auto none = at_times(rotor, {0.0}, [](double, const Point&) {});
  integrate(move, z, {.dt = 0.1, .steps = 0}, none);
  none.finish();
  CHECK(none.served() == 1);
}

namespace {
struct Forced {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] - 0.7 * std::cos(2.1 * t);
    dHdp[0] = p[0];
  }
};
}  // namespace

TEST_CASE("The end of a driven run is served by at_times, however its steps round the time", "[observers]") {
  const Autonomous forced(Forced{});
  const auto exact = [](double t) { return 0.7 * (std::cos(2.1 * t) - std::cos(t)) / (1 - 2.1 * 2.1); };
  std::size_t served = 0, due = 0;
  double worst = 0;
  const auto run = [&](auto move, double T, double dt, double t0) {
    // Whether the run is told of the time of its first state, or begins at 0.
    auto Z = forced.extended({0, 0}, 0);
    auto at = at_times(forced, {0.0, T / 2, T}, [&](double t, const Point& z) {
      worst = std::max(worst, std::abs(z.q()[0] - exact(t)));
    });
    integrate(move, Z, {.dt = dt, .t0 = t0, .t_end = t0 + T}, at);
    at.finish();
    served += at.served();
    due += 3;
  };
  for (int n = 40; n <= 160; ++n)
    for (const double T : {1.0, 2 * std::numbers::pi, 10.0}) run(Semiexplicit(forced), T, T / n, 0);
  for (const double T : {1.0, 10.0, -10.0, 100.0})
    for (const double dt : {0.1, 1.0 / 3, 0.01})
      for (const double t0 : {0.0, 16.0}) {
        run(Semiexplicit(forced, schemes::sofroniou_spaletta10()), T, std::copysign(dt, T), t0);
        run(Semiexplicit(forced, schemes::low_defect8_s20(), SimplifiedNewton{}, Summation::plain), T,
            std::copysign(dt, T), t0);
      }
  CHECK(served == due);
  CHECK(worst < 1e-4);
}

TEST_CASE("Times are those of the first state, wherever the run counts from", "[observers]") {
  const Autonomous forced(Forced{});
  std::size_t served = 0, due = 0;
  for (const double in_state : {0.1, 0.3, 0.7})
    for (const double in_run : {0.2, 3.1, 17.3, 100.7, 1000.9})
      for (const double dt : {0.1, 0.07, -0.03}) {
        auto Z = forced.extended({0, 0}, in_state);
        auto move = Semiexplicit(forced);
        auto at = at_times(forced, {in_state, in_state + 10 * dt}, [](double, const Point&) {});
        integrate(move, Z, {.dt = dt, .steps = 10, .t0 = in_run}, at);
        at.finish();
        served += at.served();
        due += 2;
      }
  CHECK(served == due);
}

TEST_CASE("Runs that continue each other through t = 0 are one", "[observers]") {
  // Two times that mean 0 are rounding of the run's times, of whatever size theirs is.
  int cases = 0, counts = 0, rows = 0, times = 0;
  for (const double dt : {0.1, 0.07, 0.3, 0.01, 1.0 / 3})
    for (const int n : {6, 10, 12, 60})
      for (const int part : {1, 2, 4}) {
        const double start = -n * dt;
        struct Seen {
          std::int64_t crossings = 0;
          std::vector<double> rows, times;
        };
        const auto seen_in = [&](int chunk) {
          auto move = stepper();
          Point z(std::sin(start), std::cos(start));  // through the surface at t = 0
          Seen seen;
          auto section = poincare_section(rotor, position, [](double, const Point&) {},
                                          {.direction = CrossingDirection::both});
          auto fifth = every(5, [&](double t, const Point&) { seen.rows.push_back(t); });
          auto at = at_times(rotor, {start / 2, 0.0, -start / 2},
                             [&](double t, const Point&) { seen.times.push_back(t); });
          for (int i = 0; i < 2 * n; i += chunk)
            integrate(move, z, {.dt = dt, .steps = chunk, .t0 = start + i * dt}, section, fifth, at);
          section.finish();
          at.finish();
          seen.crossings = section.count();
          return seen;
        };
        const Seen whole = seen_in(2 * n), parts = seen_in(part);
        ++cases;
        counts += parts.crossings == whole.crossings;
        rows += parts.rows.size() == whole.rows.size() &&
                std::abs(parts.rows.back() - whole.rows.back()) < dt / 1000;
        times += parts.times == std::vector<double>{start / 2, 0, -start / 2} && whole.times == parts.times;
      }
  CHECK(counts == cases);
  CHECK(rows == cases);
  CHECK(times == cases);
}

TEST_CASE("A time 0 at the end of a run is served although that end is rounded below it", "[observers]") {
  int served = 0, runs = 0;
  for (const double dt : {0.1, 0.07, 0.3, 0.01, 0.05, 0.02, 1.0 / 3, 0.7})
    for (const int sign : {1, -1})
      for (int n = 5; n < 60; ++n, ++runs) {
        const double start = -std::round(100 * n * dt) / 100 * sign;
        if (std::abs(start + n * dt * sign) > 1e-9) {
          served += 2;
          continue;
        }
        auto move = stepper();
        Point z(1, 0);
        auto at = at_times(rotor, {start / 2, 0.0}, [](double, const Point&) {});
        integrate(move, z, {.dt = dt * sign, .steps = n, .t0 = start}, at);
        at.finish();
        served += static_cast<int>(at.served());
      }
  CHECK(served == 2 * runs);
  // A time that is beyond by more than rounding is not.
  auto move = stepper();
  Point z(1, 0);
  auto at = at_times(rotor, {-1.0, 1e-12}, [](double, const Point&) {});
  integrate(move, z, {.dt = 0.3, .steps = 6, .t0 = -1.8}, at);
  at.finish();
  CHECK(at.served() == 1);
}

TEST_CASE("every() begins anew with an orbit that starts at another time near 0", "[observers]") {
  auto move = stepper();
  std::vector<double> rows;
  auto third = every(3, [&](double t, const Point&) { rows.push_back(t); });
  for (const double start : {-0.4, 0.05}) {
    Point z(1, 0);
    integrate(move, z, {.dt = 0.1, .steps = 4, .t0 = start}, third);
  }
  REQUIRE(rows.size() == 4);
  CHECK(rows[2] == 0.05);
}

TEST_CASE("An observer within at_times() stops the run", "[observers]") {
  auto move = stepper();
  Point z(1, 0);
  int seen = 0;
  auto at = at_times(rotor, {0.5, 1.0, 1.5, 2.0}, [&](double, const Point&) { return ++seen < 2; });
  const auto report = integrate(move, z, {.dt = 0.1, .steps = 100}, at);
  CHECK(report.status == Status::stopped);
  CHECK(seen == 2);
}

namespace {

/// Runs to t = 20 with steps of 0.1, and goes on from the last good step behind every exception; their
/// number.
int go_on_to_20(Point& z, auto& observer) {
  auto move = stepper();
  double now = 0;
  const auto clock = [&](double t, const Point&) { now = t; };
  for (int thrown = 0;; ++thrown) {
    REQUIRE(thrown < 20);
    try {
      integrate(move, z, {.dt = 0.1, .t0 = now, .t_end = 20}, clock, observer);
      return thrown;
    } catch (const std::exception&) {
    }
  }
}

}  // namespace

TEST_CASE("A run goes on with the observer of a section that has thrown, and loses no other crossing",
          "[observers]") {
  for (const int nodes : {2, 4, 6}) {
    CAPTURE(nodes);
    const auto options = PoincareSectionOptions{.direction = CrossingDirection::both, .nodes = nodes};
    // Not a number at the start, and from t = 2π - 0.045 to 2π + 0.045, ...
    std::vector<double> times;
    auto section = poincare_section(
        rotor, [](const auto& q, const auto&) { return std::sqrt(0.999 - q[0]) - 0.7; },
        [&](double t, const Point&) { times.push_back(t); }, options);
    Point z(1, 0);
    CHECK(go_on_to_20(z, section) > 0);
    REQUIRE(times.size() == 7);
    CHECK(times[0] == Approx(std::acos(0.509)).margin(1e-4));
    CHECK(times[1] == Approx(2 * std::numbers::pi - std::acos(0.509)).margin(1e-4));

    // Its action throws at the first crossings.
    int calls = 0;
    auto throwing = poincare_section(
        rotor, [](const auto& q, const auto&) { return q[0] - 0.9; },
        [&](double, const Point&) {
          if (++calls < 3) throw std::runtime_error("full");
        },
        options);
    z = Point(1, 0);
    CHECK(go_on_to_20(z, throwing) == 2);
    CHECK(calls == 7);
    CHECK(throwing.count() == 7);
  }
}

TEST_CASE("A gradient that throws in the search of a section makes no crossing off the surface",
          "[observers]") {
  for (const int call : {0, 1, 2, 3}) {
    CAPTURE(call);
    int left = call;
    bool armed = false;
    const auto H = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                               [&](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                                 if (armed && left-- == 0) throw std::runtime_error("full");
                                                 dHdq[0] = q[0];
                                                 dHdp[0] = p[0];
                                               });
    double farthest = 0;
    auto section = poincare_section(
        H, position, [&](double, const Point& at) { farthest = std::max(farthest, std::abs(at.q()[0])); },
        {.direction = CrossingDirection::both});
    const auto within = [&](double t, const Point& at, const IntegrationReport& run) {
      armed = t > 1.55;  // it crosses at t = 1.57, the first time
      return section(t, at, run);
    };
    Point z(1, 0);
    CHECK(go_on_to_20(z, within) == 1);
    section.finish();
    CHECK(section.count() == 5);  // of six
    CHECK(farthest < 1e-9);
  }
}

TEST_CASE("A run goes on with at_times() behind an exception of its observer or of the gradient",
          "[observers]") {
  std::vector<double> times;
  for (int i = 0; i < 60; ++i) times.push_back(0.03 + 0.05 * i);
  for (const int nodes : {2, 4, 6}) {
    CAPTURE(nodes);
    std::vector<double> served;
    int calls = 0;
    auto at = at_times(
        rotor, times,
        [&](double t, const Point&) {
          if (++calls < 5) throw std::runtime_error("full");
          served.push_back(t);
        },
        nodes);
    Point z(1, 0);
    CHECK(go_on_to_20(z, at) > 0);
    CHECK(served == std::vector<double>(times.begin() + 4, times.end()));

    int gradients = 0;
    const auto once = make_hamiltonian<double, 1>(
        [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
        [&](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          if (++gradients == 1) throw std::runtime_error("no licence");
          dHdq[0] = q[0];
          dHdp[0] = p[0];
        });
    served.clear();
    auto of_once = at_times(
        once, times, [&](double t, const Point&) { served.push_back(t); }, nodes);
    z = Point(1, 0);
    CHECK(go_on_to_20(z, of_once) == 1);
    CHECK(served == std::vector<double>(times.begin() + 1, times.end()));
  }
}

TEST_CASE("Dense output of a state of another size is refused", "[observers]") {
  const systems::NlsLattice<double, Eigen::Dynamic> two(2), three(3);
  Semiexplicit move(three, schemes::strang<double>());
  PhasePoint<double, Eigen::Dynamic> z(3);
  z.vector().setConstant(0.3);
  auto section = poincare_section(
      two, [](const auto& q, const auto&) { return q[0]; },
      [](double, const PhasePoint<double, Eigen::Dynamic>&) {});
  CHECK_THROWS_AS(integrate(move, z, {.dt = 0.1, .steps = 10}, section), std::invalid_argument);
}

}  // namespace test_turned_runs
