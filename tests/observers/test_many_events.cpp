// Runs with many events.

#include "catch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

#include "refusal.hpp"
#include "with_events.hpp"

namespace test_many_events {

using namespace with_events;

const double pi = std::acos(-1.0);

TEST_CASE("Bounces that pile up are said, and no ball falls through the floor", "[events]") {
  // Down to one that comes to rest at once, also where the floor is so far from 0 that s is rounded coarsely.
  for (const double kept : {0.9, 0.7, 0.3, 0.09, 0.05, 0.02, 0.01, 1e-4, 0.0})
    for (const double floor : {0.0, 1000.0, 6.4e6})
      for (const double dt : {0.05, 0.0013})
        for (const auto direction : {CrossingDirection::falling, CrossingDirection::both}) {
          CAPTURE(kept, floor, dt, int(direction));
          auto stepper = semiexplicit_of(Ball());
          Point z(floor + 0.5, 0);
          auto watch = events(Ball(), on_event([=](const auto& q, const auto&) { return q[0] - floor; },
                                               [=](double, Point& at) { at.p()[0] *= -kept; }, direction));
          CHECK(says(complaint([&] { integrate(stepper, z, {.dt = dt, .t_end = 25}, watch); }), "pile up"));
          CHECK(z.q()[0] - floor > -1e-14 - 1e-15 * floor);
        }
}

TEMPLATE_TEST_CASE("Bounces next to the ends of steps are no longer than they are", "[events]", double,
                   long double) {
  using Scalar = TestType;
  for (const int parts : {20, 38, 50, 54, 62}) {
    CAPTURE(parts);
    const BallOf<Scalar> ball;
    Semiexplicit stepper(ball, schemes::blanes_moan6<Scalar>());
    PhasePoint<Scalar, 1> z(Scalar(0.5), 0);
    auto bounces =
        events(ball, on_event(
                         height, [](const Scalar&, PhasePoint<Scalar, 1>& at) { at.p()[0] = -at.p()[0]; },
                         CrossingDirection::falling));
    std::vector<Scalar> times;
    for (int i = 1; i < 100; ++i) times.push_back(Scalar(i) * Scalar(0.19));
    double worst = 0;
    std::size_t shown = 0;
    auto at = at_times(ball, times, [&](const Scalar& t, const auto& now) {
      ++shown;
      worst = std::max(worst, std::abs(static_cast<double>(now.q()[0]) - elastic(static_cast<double>(t))));
    });
    integrate(stepper, z, {.dt = Scalar(1) / Scalar(parts), .t_end = Scalar(20)}, bounces, at);
    CHECK(shown == times.size());
    CHECK(worst < 1e-13);
  }
}

TEST_CASE("Which crossings count does not depend on rounding where events change the state on the surface",
          "[events][long]") {
  const auto count_of = [](std::int64_t& n) { return [&n](double, const Point&) { ++n; }; };
  const auto run = [&](const auto& h, const auto& surface, Point z, double dt, const auto& action,
                       CrossingDirection direction) {
    std::array<std::int64_t, 4> n{};  // told: rising, falling; sections: rising, falling
    auto stepper = semiexplicit_of(h);
    auto watch = events(h, on_event(surface, action, direction),
                        on_event(surface, count_of(n[0]), CrossingDirection::rising),
                        on_event(surface, count_of(n[1]), CrossingDirection::falling));
    auto rising = poincare_section(h, surface, count_of(n[2]));
    auto falling = poincare_section(h, surface, count_of(n[3]), {.direction = CrossingDirection::falling});
    integrate(stepper, z, {.dt = dt, .t_end = 200}, watch, rising, falling);
    rising.finish();
    falling.finish();
    return std::pair(watch.count(0), n);
  };
  const auto bounce = [](double, Point& at) { at.p()[0] = -at.p()[0]; };
  for (const double dt : {0.05, 0.0731, 0.37}) {
    for (const double start : {0.37, 0.5, 0.00123}) {
      CAPTURE(dt, start);
      // A bounce turns the orbit round on the surface: an event is told that it comes there, a section sees
      // an orbit that only touches it.
      const auto [bounces, n] =
          run(Ball(), height, Point(start, 0.01), dt, bounce, CrossingDirection::falling);
      CHECK(bounces > 90);
      CHECK(n == std::array<std::int64_t, 4>{0, bounces, 0, 0});
    }
    // A kick lets the orbit go on through the surface: all see one crossing.
    const auto faster = [](double, Point& at) { at.p()[0] *= 1.0001; };
    const auto further = [](double, Point& at) { at.q()[0] *= 1.0001; };
    CAPTURE(dt);
    const auto [kicks, n] =
        run(Oscillator(), height, Point(-0.37, 0.1), dt, faster, CrossingDirection::rising);
    CHECK(kicks == 32);
    CHECK(n == std::array<std::int64_t, 4>{kicks, kicks, kicks, kicks});
    const auto [tops, m] =
        run(Oscillator(), speed, Point(-0.37, 0.1), dt, further, CrossingDirection::falling);
    CHECK(tops == 32);
    CHECK(m == std::array<std::int64_t, 4>{tops - 1, tops, tops - 1, tops});
  }
}

TEST_CASE("A section in float counts the kicks on its surface, however little of a step is left behind them",
          "[events][long]") {
  // Far from 0, so that s is rounded coarsely.
  const float centre = 35.3F;
  const auto H = from_energy<1, float>([=](const auto& q, const auto& p) {
    const auto x = q[0] - centre;
    return (p[0] * p[0] + x * x) / 2;
  });
  const auto surface = [=](const auto& q, const auto&) { return q[0] - centre - 0.0523F; };
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    Semiexplicit stepper(H, schemes::blanes_moan6<float>());
    PhasePoint<float, 1> z(centre + 0.3F + 0.001F * float(i % 7), 0);
    auto watch = events(H, on_event(surface, [n = 0](float, PhasePoint<float, 1>& at) mutable {
                          at.p()[0] *= ++n % 2 == 0 ? 1.01F : 0.99F;
                        }));
    std::int64_t seen = 0;
    auto section = poincare_section(H, surface, [&](float, const auto&) { ++seen; },
                                    {.direction = CrossingDirection::both});
    integrate(stepper, z, {.dt = 0.001F + 0.00001F * float(i % 150), .t_end = 8}, watch, section);
    section.finish();
    CHECK(watch.count() == 3);  // at t = 1.4, 4.9 and 7.7
    CHECK(seen == 3);
  }
}

TEMPLATE_TEST_CASE("A section on the floor counts no bounce, whatever rounding leaves of the height",
                   "[events]", float, double) {
  using T = TestType;
  using P = PhasePoint<T, 1>;
  const auto free = make_hamiltonian<T, 1>(
      [](const auto&, const auto& p) { return T(p[0] * p[0] / 2); },
      [](const auto&, const auto& p, auto& dHdq, auto& dHdp) { dHdq[0] = T(0), dHdp[0] = p[0]; });
  const auto bounce = [](const T&, P& z) { z.p()[0] = -z.p()[0]; };
  for (int i = 0; i < 60; ++i) {
    CAPTURE(i);
    P z;
    z.q()[0] = T(0.05) + T(i % 10) * T(0.09), z.p()[0] = -1;
    Semiexplicit stepper(free, schemes::strang<T>());
    auto walls = events(
        free, on_event(height, bounce, CrossingDirection::falling),
        on_event([](const auto& q, const auto&) { return 1 - q[0]; }, bounce, CrossingDirection::falling));
    int crossings = 0;
    auto floor = poincare_section(free, height, [&](const T&, const P&) { ++crossings; },
                                  {.direction = CrossingDirection::both});
    integrate(stepper, z, {.dt = T(0.1) + T(i / 10) * T(0.07), .steps = 100}, floor, walls);
    floor.finish();
    CHECK(walls.count() > 8);
    CHECK(crossings == 0);
  }
}

TEST_CASE("Steps from the surface to the surface miss no crossing: a kicked rotor whose step is its period",
          "[long]") {
  const Autonomous free(from_energy<1>(
      [](const auto& t, const auto& q, const auto& p) { return p[0] * p[0] / 2 + 0 * q[0] + 0 * t; }));
  using Extended = PhasePoint<double, 2>;
  constexpr int steps = 500;
  for (const double period : {1.0, 0.7, 0.3, 2.992, -0.7}) {
    for (const double t0 : {0.0, 4000.0, 1e6}) {
      CAPTURE(period, t0);
      const auto surface = [=](const auto& q, const auto&) { return std::sin(pi * (q[1] - t0) / period); };
      const auto run = [&](auto& watch) {
        Semiexplicit stepper(free, schemes::strang<double>());
        auto z = free.extended({0.5, 0.3}, t0);
        integrate(stepper, z, {.dt = period, .steps = steps, .t0 = t0}, watch);
      };
      // Whether the one at the very end is seen is rounding's.
      const auto is_about = [](std::int64_t count, int expected) {
        CHECK(count >= expected - 1);
        CHECK(count <= expected);
      };
      auto kicks =
          events(free, on_event(surface, [](double, Extended& z) { z.p()[0] += 0.9 * std::sin(z.q()[0]); }));
      run(kicks);
      is_about(kicks.count(), steps);
      auto told = events(free, on_event(surface, [](double, const auto&) {}),
                         on_event(
                             surface, [](double, const auto&) {}, CrossingDirection::rising));
      run(told);
      told.finish();
      is_about(told.count(0), steps);
      is_about(told.count(1), steps / 2);
    }
  }
}

TEST_CASE("A ball bounces at the floor itself, however late or coarse the times are", "[events]") {
  // The time at 1e9 has ticks of 1.2e-7, a thousandth of the step.
  const auto run = [](auto t0, auto dt, std::int64_t steps) {
    using T = decltype(t0);
    using P = PhasePoint<T, 1>;
    for (const auto direction : {CrossingDirection::falling, CrossingDirection::both}) {
      CAPTURE(double(t0), double(dt), int(direction));
      const double epsilon = double(std::numeric_limits<T>::epsilon());
      double off = 0, lowest = 0;
      auto watch = events(BallOf<T>(), on_event(
                                           height,
                                           [&](T, P& at) {
                                             off = std::max(off, std::abs(double(at.q()[0])));
                                             at.p()[0] = -at.p()[0];
                                           },
                                           direction));
      Semiexplicit stepper(BallOf<T>(), schemes::blanes_moan6<T>());
      P z(T(0.5), T(0));
      const auto report = integrate(stepper, z, {.dt = dt, .steps = steps, .t0 = t0}, watch,
                                    [&](T, const P& at) { lowest = std::min(lowest, double(at.q()[0])); });
      const double end = double(dt) * double(steps);
      CHECK(watch.count() == std::int64_t(std::floor((end + 1) / 2)));
      CHECK(off <= 4 * epsilon * double(dt));
      CHECK(lowest >= -4 * epsilon * double(dt));
      CHECK(std::abs(double(z.q()[0]) - elastic(end)) < 4 * epsilon * double(steps));
      CHECK(report.steps == steps);
    }
  };
  run(1e9, 1.37e-4, 100000);
  run(1e12, 1.37e-3, 10000);
  run(0.0F, 0.05F, 1000);
  run(0.0F, 0.003F, 3000);
  run(1e5F, 0.05F, 500);
}

TEST_CASE("Kicks at given times come at late times, too, and in float", "[events]") {
  const auto run = [](auto t0, auto dt) {
    using T = decltype(t0);
    CAPTURE(double(t0), double(dt));
    const Autonomous K(
        from_energy<1, T>([](const auto&, const auto&, const auto& p) { return p[0] * p[0] / 2; }));
    using Extended = typename decltype(K)::State;
    const auto kick = [](T, Extended& at) { at.p()[0] += 1; };
    Semiexplicit stepper(K, schemes::blanes_moan6<T>());
    const T at = t0 + T(0.503);
    auto once = events(K, on_event([=](const auto& q, const auto&) { return q[1] - at; }, kick));
    auto often = events(
        K,
        on_event([=](const auto& q, const auto&) { return std::sin(T(pi) * (q[1] - t0) + T(0.3)); }, kick));
    auto z = K.extended(PhasePoint<T, 1>(0, 0), t0);
    integrate(stepper, z, {.dt = dt, .steps = std::int64_t(5.5 / double(dt)), .t0 = t0}, once);
    CHECK(once.count() == 1);
    CHECK(z.p()[0] == 1);
    z = K.extended(PhasePoint<T, 1>(0, 0), t0);
    integrate(stepper, z, {.dt = dt, .steps = std::int64_t(5.5 / double(dt)), .t0 = t0}, often);
    CHECK(often.count() == 5);
  };
  for (const double t0 : {0.0, 1e6, 1e9, 1e10}) run(t0, 0.01);
  for (const float t0 : {0.0F, 10.0F, 100.0F, 1000.0F}) run(t0, 0.01F);
  run(1e12L, 0.01L);
}

TEST_CASE("A kick of a run with transformed time leaves the orbit that of the Hamiltonian", "[events]") {
  const auto H = from_energy<2>([](const auto& q, const auto& p) {
    using std::sqrt;
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  using Flat = PhasePoint<double, 2>;
  const Flat start({0.5, 0}, {0, std::sqrt(3.0)});
  const auto apocentre = [](const auto& q, const auto&) { return q[1]; };
  Flat direct = start;
  {
    Semiexplicit stepper(H, schemes::low_defect8_s20<double>());
    bool kicked = false;
    auto watch = events(H, on_event(
                               apocentre,
                               [&](double, Flat& at) {
                                 if (!std::exchange(kicked, true)) at.p() *= 1.2;
                               },
                               CrossingDirection::falling));
    integrate(stepper, direct, {.dt = 0.0025, .t_end = 8}, watch);
  }
  const TimeTransformed K(H, monitors::Distance{}, H.energy(start.q(), start.p()));
  using Extended = decltype(K)::State;
  for (const bool anew : {false, true}) {  // whether the action does by itself what the library does
    CAPTURE(anew);
    Semiexplicit stepper(K, schemes::low_defect8_s20<double>());
    bool kicked = false;
    auto watch = events(K, on_event(
                               apocentre,
                               [&](double, Extended& at) {
                                 if (std::exchange(kicked, true)) return;
                                 at.p().head(2) *= 1.2;
                                 if (anew) at = K.extended(K.point(at), K.time(at));
                               },
                               CrossingDirection::falling));
    auto Z = K.extended(start, 0.0);
    Flat at_8(2);
    auto output = at_times(K, {8.0}, [&](double, const Flat& z) { at_8 = z; });
    integrate(stepper, Z, {.dt = 0.02, .steps = 1000}, watch, output);
    CHECK(std::abs(K.energy(Z.q(), Z.p())) < 1e-9);
    CHECK((at_8.vector() - direct.vector()).norm() < 1e-8);
  }
}

TEST_CASE("A time shortly behind one of many bounces gets the state behind it", "[events]") {
  // A ball with the speed 10 between walls at 0 and 1 is at 1 at t = 0.1, 0.3, ...
  const auto H = from_energy<1>([](const auto&, const auto& p) { return p[0] * p[0] / 2; });
  const int bounces = 10'000;
  for (const double later : {1e-9, 1e-10, 1e-11}) {
    CAPTURE(later);
    GaussLegendre stepper(H, {.stages = 1});
    PhasePoint<double, 1> z(0, 10);
    const auto turn = [](double, PhasePoint<double, 1>& at) { at.p() *= -1; };
    auto watch = events(H, on_event([](const auto& q, const auto&) { return q[0] * (1 - q[0]); }, turn,
                                    CrossingDirection::falling));
    double speed = 0;
    auto at = at_times(H, {double(bounces - 1) / 10 + later},
                       [&](double, const PhasePoint<double, 1>& w) { speed = w.p()[0]; });
    integrate(stepper, z, {.dt = 0.073, .t_end = (bounces + 20) / 10.0}, watch, at);
    CHECK(speed == -10);
  }
}

TEST_CASE("A surface that is crossed before a bounce in the same step tells of it", "[events]") {
  // A ball that flies along the floor passes the line x + y = 0.18 once; without the floor it would come
  // back.
  const auto H =
      from_energy<2>([](const auto& q, const auto& p) { return (p[0] * p[0] + p[1] * p[1]) / 2 + 3 * q[1]; });
  using State = PhasePoint<double, 2>;
  for (const double dt : {0.4, 0.2, 0.05}) {
    CAPTURE(dt);
    std::vector<double> passed;
    auto watch = events(H,
                        on_event([](const auto& q, const auto&) { return q[1]; },
                                 [](double, State& z) { z.p()[1] *= -1; }, CrossingDirection::falling),
                        on_event([](const auto& q, const auto&) { return q[0] + q[1] - 0.18; },
                                 [&](double t, const State&) { passed.push_back(t); }));
    Semiexplicit stepper(H);
    State z({0, 0.15}, {1, -0.5});
    REQUIRE(integrate(stepper, z, {.dt = dt, .t_end = 0.4}, watch).ok());
    CHECK(watch.count(0) == 1);
    REQUIRE(passed.size() == 1);
    CHECK(passed[0] == Approx((0.5 - std::sqrt(0.25 - 6 * 0.03)) / 3));  // t/2 - 3t²/2 = 0.03
  }
}

TEST_CASE("Crossings are seen however much larger s is elsewhere", "[events]") {
  // A kicked oscillator; the current of a diode is nothing where its voltage is, and 1e17 beside.
  for (const double k : {30.0, 34.0, 36.0, 40.0}) {
    CAPTURE(k);
    const auto current = [k](const auto& q, const auto&) { return std::expm1(k * q[0]); };
    const auto run = [&](const auto& surface) {
      auto stepper = semiexplicit_of(Oscillator{});
      Point z(1, 0);
      auto watch = events(Oscillator{}, on_event(surface, [](double, Point& at) { at.p()[0] *= 0.99; }),
                          on_event(current, [](double, const Point&) {}));
      integrate(stepper, z, {.dt = 0.1, .t_end = 32}, watch);
      CHECK(watch.count(0) == 10);
      CHECK(watch.count(1) == 10);
      return z.q()[0];
    };
    CHECK(run(current) == Approx(run(height)).epsilon(1e-12));
  }
}

TEST_CASE("A line through the very point of a bounce does not move it, and is told once", "[events]") {
  // Free flight in the unit box; behind some bounces the ball leaves the line more slowly than it came, and
  // the times of both are the same but for rounding.
  const auto H = from_energy<2>([](const auto&, const auto& p) { return p[0] * p[0] / 2 + p[1] * p[1] / 2; });
  using State = PhasePoint<double, 2>;
  struct Flight {
    double x, y, speed_x, speed_y, dt, t_end, a, b, level;
  };
  const Flight flights[] = {
      {0.5, 0.75, 1.25, 1.25, -0.75, -15.3, -1.9790578126853469, 1.8431833222449727, 0.46079583056124318},
      {0.25, 0.5, 1.5, 1.5, -0.75, -15.0, 0.995361328125, 1.5439910888671875, 0.24884033203125},
      {0.75, 0.375, -1.75, 1.75, 0.3145, 17.5, 1.392822265625, -0.8397979736328125, -0.73482322692871094}};
  for (const Flight& f : flights) {
    CAPTURE(f.x, f.dt);
    const auto bounce = [](int i) { return [i](double, State& z) { z.p()[i] *= -1; }; };
    const auto beyond = [](int i, double wall) {
      return [=](const auto& q, const auto&) { return (2 * wall - 1) * (q[i] - wall); };
    };
    const auto rising = CrossingDirection::rising;
    auto watch =
        events(H,
               on_event([&](const auto& q, const auto&) { return f.a * q[0] + f.b * q[1] - f.level; },
                        [](double, const State&) {}),
               on_event(beyond(0, 0), bounce(0), rising), on_event(beyond(0, 1), bounce(0), rising),
               on_event(beyond(1, 0), bounce(1), rising), on_event(beyond(1, 1), bounce(1), rising));
    Semiexplicit stepper(H, schemes::low_defect6_s13());
    State z({f.x, f.y}, {f.speed_x, f.speed_y});
    integrate(stepper, z, {.dt = f.dt, .t_end = f.t_end}, watch);
    // The box unfolded, and what the line is crossed by on each straight way, its end included.
    const auto folded = [](double x) { return std::abs(x - 2 * std::round(x / 2)); };
    const double forth = f.t_end < 0 ? -1 : 1, shortly = 1e-6 * forth;
    std::vector<double> turns{0, f.t_end};
    for (int wall = -40; wall <= 40; ++wall)
      for (const double t : {(wall - f.x) / f.speed_x, (wall - f.y) / f.speed_y})
        if (t / f.t_end > 0 && t / f.t_end < 1) turns.push_back(t);
    std::sort(turns.begin(), turns.end(), [forth](double s, double t) { return forth * s < forth * t; });
    int crossings = 0;
    for (std::size_t i = 0; i + 1 < turns.size(); ++i) {
      const double from = turns[i] + shortly, way = turns[i + 1] - turns[i];
      if (!(forth * way > 1e-9)) continue;  // a corner
      const auto s = [&](double t) {
        return f.a * folded(f.x + f.speed_x * t) + f.b * folded(f.y + f.speed_y * t) - f.level;
      };
      const double at_first = s(from), a_unit = (s(from + way / 2) - at_first) / (way / 2);
      crossings += (at_first > 0) != (at_first + a_unit * way > 0);
    }
    CHECK(watch.count(0) == crossings);
    CHECK(z.q()[0] == Approx(folded(f.x + f.speed_x * f.t_end)).margin(1e-13));
    CHECK(z.q()[1] == Approx(folded(f.y + f.speed_y * f.t_end)).margin(1e-13));
  }
}

TEST_CASE("The end of a driven run that bounces is served by at_times", "[events][long]") {
  const Autonomous K(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 + q[0] * q[0] / 2 + 0.01 * q[0] * cos(t);
  }));
  using Extended = PhasePoint<double, 2>;
  for (const double t0 : {0.0, 1e3, 1e7})
    for (const double T : {300.0, -300.0}) {
      CAPTURE(t0, T);
      int served = 0, bounces = 0;
      auto output = at_times(K, {t0 + T / 2, t0 + T}, [&](double, const auto&) { ++served; });
      auto watch = events(K, on_event([](const auto& q, const auto&) { return q[0]; },
                                      [&](double, Extended& z) { ++bounces, z.p()[0] = -z.p()[0]; },
                                      CrossingDirection::falling));
      Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
      auto Z = K.extended({1, 0}, t0);
      REQUIRE(integrate(stepper, Z, {.dt = T / 6000, .t0 = t0, .t_end = t0 + T}, watch, output).ok());
      CHECK(bounces > 80);
      CHECK(served == 2);
    }
}

}  // namespace test_many_events
