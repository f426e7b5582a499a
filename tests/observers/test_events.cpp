// Events: surfaces that a run crosses, told of or acted upon.

#include "catch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "folder.hpp"
#include "refusal.hpp"
#include "with_events.hpp"

namespace test_events {

namespace {

using namespace with_events;
const double pi = std::acos(-1.0);

/// H = p²/2 in the plane.
struct Free {
  using Scalar = double;
  static constexpr int Dof = 2;
  double energy(In<double, 2>, In<double, 2> p) const { return p.squaredNorm() / 2; }
  void gradient(In<double, 2>, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq.setZero();
    dHdp = p;
  }
};

}  // namespace

TEST_CASE("A run goes on behind a bounce that ended it, though another kind is still to be told",
          "[events]") {
  const int nodes = GENERATE(2, 4);
  const Ball ball;
  auto stepper = semiexplicit_of(ball);
  Point z(0.5, 0);
  int told = 0, on_floor = 0, above = 0;
  double worst = 0;
  auto watch = events(ball,
                      on_event(
                          height,
                          [](double, Point& at) {
                            at.p()[0] = -at.p()[0];
                            return false;
                          },
                          CrossingDirection::falling),
                      on_event(
                          height, [&](double, const Point&) { ++told; }, CrossingDirection::falling));
  const auto both = [&](int& count, double level) {
    return poincare_section(
        ball, [=](const auto& q, const auto&) { return q[0] - level; },
        [&count](double, const Point&) { ++count; }, {.direction = CrossingDirection::both, .nodes = nodes});
  };
  auto floor = both(on_floor, 0), middle = both(above, 0.3);
  auto at = at_times(
      ball, {0.5, 0.9, 1.02, 1.5, 2.5, 3.03, 5.5},
      [&](double t, const Point& now) { worst = std::max(worst, std::abs(now.q()[0] - elastic(t))); }, nodes);
  DenseOutput dense(ball, nodes);
  const auto look = [&](double, const Point&) {
    if (dense.size() < 2) return;
    Point between;
    const double t = 0.7 * dense.end() + 0.3 * dense.time(dense.size() - 2);
    dense.at(t, between);
    const double off = std::abs(between.q()[0] - elastic(t));
    worst = off <= worst ? worst : off;  // NaN is the worst
  };
  for (double t = 0; t < 6;)
    t = integrate(stepper, z, {.dt = 0.1, .t0 = t, .t_end = 6}, floor, middle, at, dense, look, watch).t;
  for (auto* section : {&floor, &middle}) section->finish();
  at.finish();
  CHECK(told == 3);
  CHECK(on_floor == 0);
  CHECK(above == 6);
  CHECK(at.served() == 7);
  CHECK(worst < 1e-12);
}

TEST_CASE("A ball that bounces without loss keeps to its closed form", "[events]") {
  for (const double dt : {0.01, 0.3, 0.77}) {
    CAPTURE(dt);
    auto stepper = semiexplicit_of(Ball());
    Point z(0.5, 0);
    std::vector<double> bounces, times;
    auto watch = events(Ball(), on_event(
                                    height,
                                    [&](double t, Point& at) {
                                      bounces.push_back(t);
                                      at.p()[0] = -at.p()[0];
                                    },
                                    CrossingDirection::falling));
    double worst = 0, energy = 0;
    const auto report =
        integrate(stepper, z, {.dt = dt, .steps = 500}, watch, [&](double t, const Point& at) {
          worst = std::max(worst, std::abs(at.q()[0] - elastic(t)));
          energy = std::max(energy, std::abs(Ball().energy(at.q(), at.p()) - 0.5));
        });
    CHECK(report.steps == 500);
    CHECK(report.t == 500 * dt);
    CHECK(report.changes == std::int64_t(bounces.size()));
    REQUIRE(bounces.size() == std::size_t(std::floor((500 * dt + 1) / 2)));
    CHECK(watch.count() == report.changes);
    for (std::size_t k = 0; k < bounces.size(); ++k)
      CHECK(std::abs(bounces[k] - (1 + 2 * double(k))) <= 1e-12 * bounces[k]);
    CHECK(worst < 1e-10);
    CHECK(energy < 1e-12);
  }
}

TEST_CASE("A ball that loses speed is stopped where its bounces pile up", "[events]") {
  // Flights of lengths 2 r, 2 r², ...: after the bounce n the time is 1 + 2 (r + ... + r^n), and their sum is
  // finite.
  const double r = 0.7;
  auto stepper = semiexplicit_of(Ball());
  Point z(0.5, 0);
  int n = 0;
  double expected = 1, worst = 0;
  auto watch = events(Ball(), on_event(
                                  height,
                                  [&](double t, Point& at) {
                                    worst = std::max(worst, std::abs(t - expected));
                                    at.p()[0] *= -r;
                                    expected += 2 * std::pow(r, ++n);
                                    return at.p()[0] > 1e-2;
                                  },
                                  CrossingDirection::falling));
  const auto report = integrate(stepper, z, {.dt = 0.05, .t_end = 100}, watch);
  CHECK(report.status == Status::stopped);
  CHECK(n == 13);
  CHECK(report.t == Approx(1 + 2 * r * (1 - std::pow(r, 12)) / (1 - r)).epsilon(1e-12));
  CHECK(std::abs(z.q()[0]) < 1e-12);
  CHECK(z.p()[0] == Approx(std::pow(r, 13)).epsilon(1e-10));
  CHECK(worst < 1e-11);
}

TEST_CASE("A ball that is thrown from the floor bounces, however short its flights are", "[events]") {
  // A flight with the speed v takes 2 v.
  for (const double v : {0.2, 0.03, 0.02, 0.01, 0.0117}) {
    CAPTURE(v);
    auto stepper = semiexplicit_of(Ball());
    Point z(0, v);
    double lowest = 0;
    auto watch = events(
        Ball(), on_event(
                    height, [](double, Point& at) { at.p()[0] = -at.p()[0]; }, CrossingDirection::falling));
    integrate(stepper, z, {.dt = 0.05, .steps = 40}, watch,
              [&](double, const Point& at) { lowest = std::min(lowest, at.q()[0]); });
    CHECK(watch.count() >= std::int64_t(1 / v) - 1);
    CHECK(watch.count() <= std::int64_t(1 / v));
    CHECK(lowest > -1e-16);
  }
}

TEST_CASE("An action that carries the state over a surface makes no crossing of it", "[events]") {
  // On a circle of length 1, by a jump from its end to its beginning.
  const auto end = [](const auto& q, const auto&) { return q[0] - 1; };
  const auto middle = [](const auto& q, const auto&) { return q[0] - 0.5; };
  for (const double dt : {0.01, 0.03, 0.4}) {
    CAPTURE(dt);
    int begun = 0, middles = 0, section = 0;
    auto stepper = semiexplicit_of(Free());
    PhasePoint<double, 2> z({0.2, 0}, {1, 0});
    auto watch = events(Free(), on_event(end, [](double, PhasePoint<double, 2>& at) { at.q()[0] -= 1; }),
                        on_event(height, [&](double, const auto&) { ++begun; }),
                        on_event(middle, [&](double, const auto&) { ++middles; }));
    auto sections = poincare_section(Free(), middle, [&](double, const auto&) { ++section; },
                                     {.direction = CrossingDirection::both});
    integrate(stepper, z, {.dt = dt, .t_end = 20.1}, watch, sections);
    sections.finish();
    CHECK(watch.count(0) == 20);
    CHECK(begun == 0);
    CHECK(middles == 20);
    CHECK(section == 20);
    CHECK(z.q()[0] == Approx(0.3));
  }
}

TEST_CASE("A surface that the orbit crosses slowly has its events in float, too", "[events]") {
  // q = cos t crosses 0.99 with the speed 0.14, less than rounding in the millionth part of a step.
  const auto H =
      from_energy<1, float>([](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; });
  for (const float dt : {0.05F, 0.0005F}) {
    CAPTURE(dt);
    Semiexplicit stepper(H, schemes::blanes_moan6<float>());
    PhasePoint<float, 1> z(1, 0);
    auto watch = events(H, on_event([](const auto& q, const auto&) { return q[0] - 0.99F; },
                                    [](float, PhasePoint<float, 1>&) {}));
    integrate(stepper, z, {.dt = dt, .t_end = 1}, watch);
    CHECK(watch.count() == 1);
  }
}

TEST_CASE("A surface that is NaN where the orbit is is refused", "[events]") {
  auto stepper = semiexplicit_of(Oscillator());
  const auto nowhere = [](const auto& q, const auto&) { return std::sqrt(-1 - q[0] * q[0]); };
  const auto half = [](const auto& q, const auto&) { return std::sqrt(q[0]) - 0.5; };  // q from 1 to below 0
  Point z(1, 0);
  CHECK(refuses(
      [&] {
        integrate(stepper, z, {.dt = 0.1, .steps = 60},
                  poincare_section(Oscillator(), nowhere, [](double, const Point&) {}));
      },
      "is NaN"));
  z = Point(1, 0);
  CHECK(refuses(
      [&] {
        integrate(stepper, z, {.dt = 0.1, .steps = 60},
                  events(Oscillator(), on_event(half, [](double, Point&) {})));
      },
      "is NaN"));
  CHECK(z.q()[0] > 0);  // the last state where it was a number
}

TEST_CASE("A rotor kicked at equal times is the standard map", "[events]") {
  // H = p²/2 in the extended phase space, so that the time of the kick is a surface.
  const Autonomous K(from_energy<1>([](const auto&, const auto&, const auto& p) { return p[0] * p[0] / 2; }));
  using Extended = PhasePoint<double, 2>;
  const double strength = 0.9;
  auto stepper = semiexplicit_of(K);
  auto Z = K.extended({0.4, 1.3}, 0.0);
  auto watch =
      events(K, on_event([](const auto& q, const auto&) { return std::sin(pi * q[1]); },
                         [&](double, Extended& at) { at.p()[0] += strength * std::sin(at.q()[0]); }));
  integrate(stepper, Z, {.dt = 0.13, .t_end = 20.5}, watch);
  double angle = 0.4, p = 1.3;
  for (int n = 0; n < 20; ++n) {
    angle += p;
    p += strength * std::sin(angle);
  }
  CHECK(watch.count() == 20);
  CHECK(Z.q()[0] == Approx(angle + p / 2).epsilon(1e-10));
  CHECK(Z.p()[0] == Approx(p).epsilon(1e-10));
}

TEST_CASE("Several surfaces are told in order of time, each in its direction", "[events]") {
  // q = cos t: q falls through 0 at π/2, p = -sin t rises through 0 at π, q through 1/2 at π/3 and 5π/3.
  for (const bool changing : {false, true}) {
    CAPTURE(changing);
    std::string order;
    std::vector<double> times;
    const auto told = [&](char kind) {
      return [&order, &times, kind](double t, const Point&) {
        order += kind;
        times.push_back(t);
      };
    };
    const auto half = [](const auto& q, const auto&) { return q[0] - 0.5; };
    Point z(1, 0);
    auto stepper = Semiexplicit(Oscillator(), schemes::low_defect8_s20());
    if (changing) {  // a change that changes nothing, and the others are found in the same way
      auto watch =
          events(Oscillator(), on_event(height, told('q'), CrossingDirection::falling),
                 on_event(speed, told('p'), CrossingDirection::rising), on_event(half, told('h')),
                 on_event([](const auto& q, const auto&) { return q[0] - 5; }, [](double, Point&) {}));
      integrate(stepper, z, {.dt = 0.7, .steps = 9}, watch);
      CHECK(watch.count() == 4);
    } else {
      auto watch = events(Oscillator(), on_event(height, told('q'), CrossingDirection::falling),
                          on_event(speed, told('p'), CrossingDirection::rising), on_event(half, told('h')));
      integrate(stepper, z, {.dt = 0.07, .steps = 90}, watch);
      CHECK(watch.count() == 4);
      CHECK(watch.count(2) == 2);
    }
    REQUIRE(order == "hqph");
    const double exact[] = {pi / 3, pi / 2, pi, 5 * pi / 3};
    for (std::size_t k = 0; k < 4; ++k) CHECK(std::abs(times[k] - exact[k]) < 1e-9);
  }
}

TEST_CASE("Two events within one step come in order of time", "[events]") {
  std::string order;
  Point z(1, 0);
  auto stepper = semiexplicit_of(Oscillator());
  auto watch = events(Oscillator(),
                      on_event([](const auto& q, const auto&) { return q[0] + 0.02; },
                               [&](double, const Point&) { order += 'b'; }),
                      on_event([](const auto& q, const auto&) { return q[0] - 0.02; },
                               [&](double, const Point&) { order += 'a'; }));
  integrate(stepper, z, {.dt = 0.1, .steps = 60}, watch);
  CHECK(order == "abba");
}

TEST_CASE("Of two kinds on one surface both have their events, in either order", "[events]") {
  for (const double dt : {0.05, 0.07, 0.3, 0.5}) {
    CAPTURE(dt);
    const auto bounce = [](double, Point& at) { at.p()[0] = -at.p()[0]; };
    for (const bool told_first : {true, false}) {
      CAPTURE(told_first);
      int told = 0;
      const auto tell = [&](double, const Point&) { ++told; };
      auto stepper = semiexplicit_of(Ball());
      Point z(0.5, 0);
      const auto run = [&](auto watch, std::size_t bounces) {
        integrate(stepper, z, {.dt = dt, .t_end = 20.5}, watch);
        CHECK(watch.count(bounces) == 10);
      };
      if (told_first)
        run(events(Ball(), on_event(height, tell, CrossingDirection::falling),
                   on_event(height, bounce, CrossingDirection::falling)),
            1);
      else
        run(events(Ball(), on_event(height, bounce, CrossingDirection::falling),
                   on_event(height, tell, CrossingDirection::falling)),
            0);
      CHECK(told == 10);
      CHECK(z.q()[0] == Approx(elastic(20.5)).epsilon(1e-11));
    }
  }
}

TEST_CASE("A floor written in another form is crossed by the same falls, and by no rise", "[events]") {
  for (const double dt : {0.1, 0.01, 0.001})
    for (const double floor : {0.3, 0.7, 1.3}) {
      CAPTURE(dt, floor);
      const auto fall = [=](const auto& q, const auto&) { return q[0] - floor; };
      const auto scaled = [=](const auto& q, const auto&) { return 10 * q[0] - 10 * floor; };
      const auto squared = [=](const auto& q, const auto&) { return q[0] * q[0] - floor * floor; };
      const auto nothing = [](double, const Point&) {};
      const auto watch_all = [&](auto bounce) {
        return events(Ball(), on_event(fall, bounce, CrossingDirection::falling),
                      on_event(scaled, nothing, CrossingDirection::falling), on_event(scaled, nothing),
                      on_event(squared, nothing, CrossingDirection::rising),
                      on_event(squared, nothing, CrossingDirection::falling));
      };
      const auto bounce = [](double, Point& at) { at.p()[0] *= -0.99; };
      auto watch = watch_all(bounce);
      auto section = poincare_section(Ball(), scaled, [](double, const Point&) {});
      auto stepper = semiexplicit_of(Ball());
      Point z(floor + 0.2, 0);
      integrate(stepper, z, {.dt = dt, .t_end = 50}, watch, section);
      section.finish();
      REQUIRE(watch.count(0) > 30);
      CHECK(watch.count(1) == watch.count(0));
      CHECK(watch.count(2) == watch.count(0));
      CHECK(watch.count(3) == 0);
      CHECK(watch.count(4) == watch.count(0));
      CHECK(section.count() == 0);
    }
}

TEMPLATE_TEST_CASE("Two actions on one wall both happen, however small the steps are", "[events]", float,
                   double) {
  using Scalar = TestType;
  using Flat = PhasePoint<Scalar, 2>;
  const auto H =
      from_energy<2, Scalar>([](const auto&, const auto& p) { return (p[0] * p[0] + p[1] * p[1]) / 2; });
  for (const double dt : {0.01, 0.002, 0.0005})
    for (const bool other_form : {false, true}) {
      CAPTURE(dt, other_form);
      const auto left = [](const auto& q, const auto&) { return q[0]; };
      const auto right = [](const auto& q, const auto&) { return 1 - q[0]; };
      const auto also_right = [=](const auto& q, const auto&) {
        return other_form ? 3 - 3 * q[0] : 1 - q[0];
      };
      const auto turn = [](Scalar, Flat& z) { z.p()[0] = -z.p()[0]; };
      auto watch =
          events(H, on_event(right, turn, CrossingDirection::falling),
                 on_event(left, turn, CrossingDirection::falling),
                 on_event(
                     also_right, [](Scalar, Flat& z) { z.p()[1] /= 2; }, CrossingDirection::falling));
      Semiexplicit stepper(H, schemes::low_defect6_s13<Scalar>());
      Flat z({Scalar(0.5), 0}, {1, 1});
      integrate(stepper, z, {.dt = Scalar(dt), .t_end = Scalar(10)}, watch);
      CHECK(watch.count(0) == 5);
      CHECK(watch.count(2) == 5);
      CHECK(z.p()[1] == std::ldexp(Scalar(1), -5));
    }
}

TEST_CASE("An action that carries the state away from a wall takes no event of it from the other kinds",
          "[events]") {
  const auto H = from_energy<1>([](const auto&, const auto& p) { return p[0] * p[0] / 2; });
  const auto wall = [](const auto& q, const auto&) { return q[0] - 1; };
  const auto scaled = [](const auto& q, const auto&) { return 3 * q[0] - 3; };
  const auto nothing = [](double, const Point&) {};
  for (const double jump : {1.0, 0.7, 0.11}) {
    CAPTURE(jump);
    const auto back = [=](double, Point& z) { z.q()[0] -= jump; };
    auto watch = events(H, on_event(wall, nothing, CrossingDirection::rising), on_event(wall, back),
                        on_event(wall, nothing, CrossingDirection::rising), on_event(scaled, nothing));
    auto stepper = semiexplicit_of(H);
    Point z(0.5, 1);
    integrate(stepper, z, {.dt = 0.013, .t_end = 10.}, watch);
    for (std::size_t k = 0; k < 4; ++k) CHECK(watch.count(k) == std::int64_t(std::floor(9.5 / jump)) + 1);
  }
}

TEST_CASE("An action that changes the scale of another s takes no event from it", "[events]") {
  using Flat = PhasePoint<double, 2>;
  const auto H =
      from_energy<2>([](const auto& q, const auto& p) { return (p[0] * p[0] + p[1] * p[1]) / 2 + q[1]; });
  const auto floor = [](const auto& q, const auto&) { return q[1]; };
  const auto scaled = [](const auto& q, const auto& p) { return std::atan(q[1] * (1 + p[0] * p[0])); };
  const auto push = [](double, Flat& z) { z.p() = Vector<double, 2>(100, -z.p()[1]); };
  const auto nothing = [](double, const Flat&) {};
  for (int i = 0; i < 200; ++i) {
    CAPTURE(i);
    auto watch = events(H, on_event(floor, push, CrossingDirection::falling),
                        on_event(scaled, nothing, CrossingDirection::falling),
                        on_event(scaled, nothing, CrossingDirection::falling));
    GaussLegendre stepper(H, {.stages = 2});
    Flat z({0.5, 0.2 + 0.004 * i}, {-0.9 + 0.0077 * i, -0.3});
    integrate(stepper, z, {.dt = 0.05 + 0.0007 * i, .t_end = 2.5}, watch);
    CHECK(watch.count(0) > 0);
    CHECK(watch.count(1) == watch.count(0));
    CHECK(watch.count(2) == watch.count(0));
  }
}

TEST_CASE("A wall that is hit at the end of a step is only touched for a section", "[events]") {
  using Flat = PhasePoint<double, 2>;
  for (const double unit : {0.1, 0.2, 0.3})
    for (const int width : {10, 12, 13})
      for (const int y : {1, 3, 5}) {
        CAPTURE(unit, width, y);
        // Between two walls, at the height y; the section is a line through where it hits the right one.
        const auto turn = [](double, Flat& at) { at.p()[0] = -at.p()[0]; };
        auto watch = events(
            Free(),
            on_event([](const auto& q, const auto&) { return q[0]; }, turn, CrossingDirection::falling),
            on_event([=](const auto& q, const auto&) { return q[0] - unit * width; }, turn,
                     CrossingDirection::rising));
        auto section = poincare_section(
            Free(), [=](const auto& q, const auto&) { return 2 * q[0] + q[1] - unit * (2 * width + y); },
            [](double, const Flat&) {}, {.direction = CrossingDirection::both});
        GaussLegendre stepper(Free(), {.stages = 2});
        Flat z({3 * unit, y * unit}, {-24 * unit, 0});
        integrate(stepper, z, {.dt = 1.0 / 24, .steps = 173}, watch, section);
        section.finish();
        CHECK(watch.count() > 10);
        CHECK(section.count() == 0);
      }
}

TEST_CASE("Bodies that meet at the same time collide as those that meet one by one", "[events]") {
  using Row = PhasePoint<double, 3>;
  using Pair = PhasePoint<double, 2>;
  const auto run = [](const auto& H, auto& watch, auto z) {
    auto stepper = semiexplicit_of(H);
    integrate(stepper, z, {.dt = 0.125, .t_end = 3}, watch);
    return z;
  };
  // Two bodies of width 1: the first comes to the wall q = 0 when the second comes to it.
  for (const double apart : {0.0, 1e-12, -1e-12}) {
    CAPTURE(apart);
    auto watch = events(
        Free(),
        on_event([](const auto& q, const auto&) { return q[0]; },
                 [](double, Pair& at) { at.p()[0] = -at.p()[0]; }, CrossingDirection::falling),
        on_event([](const auto& q, const auto&) { return q[1] - q[0] - 1; },
                 [](double, Pair& at) { std::swap(at.p()[0], at.p()[1]); }, CrossingDirection::falling));
    const Pair z = run(Free(), watch, Pair({1, 3 + apart}, {-1, -2}));
    CHECK(watch.count() == 4);
    CHECK((z.vector() - Eigen::Vector4d(2, 5, 1, 2)).norm() < 1e-10);
  }
  // Three, of which the outer ones come to the middle one: it is hit from both sides, and they turn.
  const auto H = make_hamiltonian<double, 3>([](const auto&, const auto& p) { return p.squaredNorm() / 2; },
                                             [](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                               dHdq.setZero();
                                               dHdp = p;
                                             });
  auto watch =
      events(H,
             on_event([](const auto& q, const auto&) { return q[1] - q[0] - 1; },
                      [](double, Row& at) { std::swap(at.p()[0], at.p()[1]); }, CrossingDirection::falling),
             on_event([](const auto& q, const auto&) { return q[2] - q[1] - 1; },
                      [](double, Row& at) { std::swap(at.p()[1], at.p()[2]); }, CrossingDirection::falling));
  const Row z = run(H, watch, Row({-2, 0, 2}, {1, 0, -1}));
  CHECK(watch.count() == 3);
  CHECK((z.p() - Eigen::Vector3d(-1, 0, 1)).norm() < 1e-12);
}

TEST_CASE("Two bodies that meet shortly before a wall meet again behind it, in float, too", "[events]") {
  const auto h = make_hamiltonian<float, 2>([](const auto&, const auto& p) { return p.squaredNorm() / 2; },
                                            [](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                              dHdq.setZero();
                                              dHdp = p;
                                            });
  const auto apart = [](const auto& q, const auto&) { return q[1] - q[0]; };
  const auto to_wall = [](const auto& q, const auto&) { return 1 - q[1]; };
  const auto collide = [](float, PhasePoint<float, 2>& z) { std::swap(z.p()[0], z.p()[1]); };
  const auto bounce = [](float, PhasePoint<float, 2>& z) { z.p()[1] *= -1; };
  // The flight between the two is 1e-5 to 1e-4 long, the rounding of their distance as much.
  for (const float before : {1e-6F, 2e-6F, 3.8e-6F, 8e-6F, 1.5e-5F, 3e-5F})
    for (const float dt : {0.1F, 0.01F}) {
      CAPTURE(before, dt);
      const float T = 1.03F;
      PhasePoint<float, 2> z({1 - before - 0.3F * T, 1 - before - 0.2F * T}, {0.3F, 0.2F});
      Semiexplicit stepper(h);
      auto watch = events(h, on_event(apart, collide, CrossingDirection::falling),
                          on_event(to_wall, bounce, CrossingDirection::falling));
      REQUIRE(integrate(stepper, z, {.dt = dt, .t_end = 2}, watch).ok());
      CHECK(watch.count(0) == 2);
      CHECK(watch.count(1) == 2);
      // Equal bodies pass through each other, but for the names.
      CHECK(z.q()[0] == Approx(1 + before - 0.3F * (2 - T)).margin(1e-5));
      CHECK(z.q()[1] == Approx(1 + before - 0.2F * (2 - T)).margin(1e-5));
      CHECK(z.p()[0] == -0.3F);
      CHECK(z.p()[1] == -0.2F);
    }
}

TEMPLATE_TEST_CASE("A ball whose bounces pile up never falls through the floor", "[events]", float, double) {
  using Scalar = TestType;
  using Fall = PhasePoint<Scalar, 1>;
  const auto H =
      make_hamiltonian<Scalar, 1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0]; },
                                  [](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                    dHdq[0] = 1;
                                    dHdp[0] = p[0];
                                  });
  for (const double kept : {0.1, 0.25, 0.5, 0.75})
    for (const double dt : {0.2, 0.05, 0.01})
      for (const double floor : {0.0, 0.3, 2.0, 5.0})
        for (const double drop : {0.5, 1.0, 2.0}) {
          CAPTURE(kept, dt, floor, drop);
          auto bounce = [&](Scalar, Fall& at) { at.p()[0] *= -Scalar(kept); };
          auto watch =
              events(H, on_event([&](const auto& q, const auto&) { return Scalar(q[0] - Scalar(floor)); },
                                 bounce, CrossingDirection::falling));
          Semiexplicit stepper(H, schemes::strang<Scalar>());
          Fall z(Scalar(floor + drop), 0);
          CHECK_THROWS_AS(integrate(stepper, z, {.dt = Scalar(dt), .t_end = Scalar(30)}, watch),
                          std::runtime_error);
          CHECK(double(z.q()[0]) > floor - 1e-4);
        }
}

TEST_CASE("A ball that hits a corner bounces off both walls", "[events]") {
  // Free flight along the diagonal of a box, whose walls are crossed at once but for rounding.
  using Flat = PhasePoint<double, 2>;
  for (const double width : {1.0, 1.1, 0.3, 0.77, 0.213})
    for (const double ratio : {1.0, 3.0}) {
      CAPTURE(width, ratio);
      auto stepper = semiexplicit_of(Free());
      Flat z({0, 0}, {0.7, 0.7 * ratio});
      auto watch =
          events(Free(),
                 on_event([=](const auto& q, const auto&) { return q[0] * q[0] - width * width; },
                          [](double, Flat& at) { at.p()[0] = -at.p()[0]; }, CrossingDirection::rising),
                 on_event([=](const auto& q, const auto&) { return q[1] - ratio * width; },
                          [](double, Flat& at) { at.p()[1] = -at.p()[1]; }, CrossingDirection::rising),
                 on_event([=](const auto& q, const auto&) { return -ratio * width - q[1]; },
                          [](double, Flat& at) { at.p()[1] = -at.p()[1]; }, CrossingDirection::rising));
      const double period = 4 * width / 0.7;
      integrate(stepper, z, {.dt = 0.05, .t_end = 10 * period}, watch);
      CHECK(watch.count(0) == 20);
      CHECK(watch.count(1) == 10);
      CHECK(watch.count(2) == 10);
      CHECK(z.q().norm() < 1e-11);
      CHECK(z.p()[1] == Approx(0.7 * ratio));
    }
}

TEST_CASE("A second wall behind the first bounces the ball when it is there, however soon", "[events]") {
  using Flat = PhasePoint<double, 2>;
  for (const double later : {1e-3, 3e-6, 1e-6, 3e-7, 1e-8, 1e-10}) {
    CAPTURE(later);
    auto stepper = semiexplicit_of(Free());
    Flat z({0, 0}, {1, 1 / (1 + later)});
    double second = 0;
    auto watch = events(Free(),
                        on_event([](const auto& q, const auto&) { return 1 - q[0]; },
                                 [](double, Flat& at) { at.p()[0] = -at.p()[0]; }),
                        on_event([](const auto& q, const auto&) { return 1 - q[1]; },
                                 [&](double t, Flat& at) {
                                   second = t;
                                   at.p()[1] = -at.p()[1];
                                 }));
    integrate(stepper, z, {.dt = 4, .steps = 1}, watch);
    CHECK(watch.count() == 2);
    CHECK(std::abs(second - (1 + later)) < 4e-12);
  }
}

TEST_CASE("A section keeps what comes shortly before a bounce off another surface", "[events]") {
  using Flat = PhasePoint<double, 2>;
  for (const double before : {1e-3, 1e-6, 3e-7, 1e-9, 1e-11, 0.}) {
    CAPTURE(before);
    auto stepper = semiexplicit_of(Free());
    Flat z({before, 0}, {1, 1});
    auto wall = events(Free(), on_event([](const auto& q, const auto&) { return 1 - q[1]; },
                                        [](double, Flat& at) { at.p()[1] = -at.p()[1]; }));
    auto section = poincare_section(
        Free(), [](const auto& q, const auto&) { return q[0] - 1; }, [](double, const Flat&) {});
    integrate(stepper, z, {.dt = 0.3, .steps = 10}, wall, section);
    section.finish();
    CHECK(wall.count() == 1);
    CHECK(section.count() == 1);
  }
}

TEST_CASE("A surface that its action moves on is met again where it is then", "[events]") {
  const auto count = [](const auto& make) {
    double next = 1.05;
    std::vector<double> times;
    auto watch = make([&](const auto& q, const auto&) { return q[0] - next; },
                      [&](double t, const PhasePoint<double, 2>&) { times.push_back(t), next += 1; });
    auto stepper = semiexplicit_of(Free());
    PhasePoint<double, 2> z({0, 0}, {1, 0});
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 100}, watch).ok());
    REQUIRE(times.size() == 9);
    for (std::size_t i = 0; i < times.size(); ++i)
      CHECK(times[i] == Approx(1.05 + static_cast<double>(i)).epsilon(1e-12));
  };
  count([](auto s, auto action) { return events(Free(), on_event(s, std::move(action))); });
  count([](auto s, auto action) { return poincare_section(Free(), s, std::move(action)); });
}

TEST_CASE("An event on a surface that another action moves away in the same step is none", "[events]") {
  double wall = 0.57;
  std::vector<double> times;
  auto watch = events(Free(),
                      on_event([](const auto& q, const auto&) { return q[0] - 0.52; },
                               [&](double, const PhasePoint<double, 2>&) { wall = 1.05; }),
                      on_event([&](const auto& q, const auto&) { return q[0] - wall; },
                               [&](double t, const PhasePoint<double, 2>&) { times.push_back(t); }));
  auto stepper = semiexplicit_of(Free());
  PhasePoint<double, 2> z({0, 0}, {1, 0});
  REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 20}, watch).ok());
  REQUIRE(times.size() == 1);
  CHECK(times[0] == Approx(1.05));
}

TEST_CASE("An event that is told of can end the run", "[events]") {
  Point z(1, 0);
  auto stepper = semiexplicit_of(Oscillator());
  auto watch = events(Oscillator(), on_event(height, [](double, const Point&) { return false; }));
  const auto report = integrate(stepper, z, {.dt = 0.01, .steps = 1000}, watch);
  CHECK(report.status == Status::stopped);
  CHECK(report.t == Approx(1.58).epsilon(1e-12));  // the end of its step

  // Also by a reference to what it keeps, from an action that changes the state.
  z = Point(1, 0);
  const bool go_on = false;
  auto bounce = events(Oscillator(), on_event(height, [&](double, Point& at) -> const bool& {
                         at.p()[0] = -at.p()[0];
                         return go_on;
                       }));
  CHECK(integrate(stepper, z, {.dt = 0.01, .steps = 1000}, bounce).status == Status::stopped);
}

TEST_CASE("What interpolates does not reach across a change of the state", "[events]") {
  for (const double dt : {0.05, 0.0499999999}) {
    auto stepper = semiexplicit_of(Ball());
    Point z(0.5, 0);
    auto watch = events(
        Ball(), on_event(
                    height, [](double, Point& at) { at.p()[0] = -at.p()[0]; }, CrossingDirection::falling));
    std::vector<double> times;
    for (int i = 0; i <= 90; ++i) times.push_back(0.111 * i);
    double worst = 0;
    auto output = at_times(Ball(), times, [&](double t, const Point& at) {
      worst = std::max(worst, std::abs(at.q()[0] - elastic(t)));
    });
    std::vector<double> tops;
    auto top = poincare_section(Ball(), speed, [&](double t, const Point&) { tops.push_back(t); },
                                {.direction = CrossingDirection::falling});
    Record<double, 1> all, some;
    auto every_third = every(3, some);
    integrate(stepper, z, {.dt = dt, .steps = 201}, watch, output, top, all, every_third);
    output.finish();
    CHECK(output.served() == times.size());
    CHECK(worst < 1e-11);
    REQUIRE(tops.size() == 5);  // p jumps from -1 to 1 at the floor: no crossing
    for (std::size_t k = 0; k < 5; ++k) CHECK(std::abs(tops[k] - 2 * double(k + 1)) < 1e-11);
    CHECK(some.t.size() == 68);
    CHECK(all.t.size() >= 202 + 5);
    CHECK(std::is_sorted(all.t.begin(), all.t.end()));
  }
}

TEST_CASE("Backward runs bounce, too", "[events]") {
  auto stepper = semiexplicit_of(Ball());
  Point z(0.5, 0);
  const auto bounce = [](double, Point& at) { at.p()[0] = -at.p()[0]; };
  auto there = events(Ball(), on_event(height, bounce, CrossingDirection::falling));
  integrate(stepper, z, {.dt = 0.07, .t_end = 10.3}, there);
  CHECK(z.q()[0] == Approx(elastic(10.3)).epsilon(1e-11));
  auto back = events(Ball(), on_event(height, bounce, CrossingDirection::falling));
  integrate(stepper, z, {.dt = -0.07, .t0 = 10.3, .t_end = 0}, back);
  CHECK(back.count() == there.count());
  CHECK(z.q()[0] == Approx(0.5).epsilon(1e-11));
  CHECK(std::abs(z.p()[0]) < 1e-11);
}

TEST_CASE("A run that ended at an event is gone on with by a new run, not by `done`", "[events]") {
  const IntegrationOptions<double> options{.dt = 0.07, .t_end = 20.3};
  for (const int stop : {1, 3}) {
    int n = 0;
    auto watch = events(Ball(), on_event(
                                    height,
                                    [&](double, Point& at) {
                                      at.p()[0] = -at.p()[0];
                                      return ++n != stop;
                                    },
                                    CrossingDirection::falling));
    auto stepper = semiexplicit_of(Ball());
    Point z(0.5, 0);
    const auto first = integrate(stepper, z, options, watch);
    REQUIRE(first.status == Status::stopped);
    CHECK(first.at_event);
    auto wrong = options;
    wrong.done = first;
    const Point there = z;
    CHECK(refuses([&] { integrate(stepper, z, wrong, watch); }, "t0 = report.t"));
    CHECK(z.vector() == there.vector());
    const auto rest = integrate(stepper, z, {.dt = 0.07, .t0 = first.t, .t_end = 20.3}, watch);
    CHECK(!rest.at_event);
    CHECK(n == 10);
    CHECK(z.q()[0] == Approx(elastic(20.3)).epsilon(1e-11));
  }
}

TEST_CASE("A run of any precision goes on from the event that ended one, by the time of the report",
          "[events]") {
  const auto run = [](auto zero) {
    using T = decltype(zero);
    using P = PhasePoint<T, 1>;
    for (int k = 0; k < 20; ++k) {
      CAPTURE(k);
      int n = 0;
      auto watch = events(BallOf<T>(), on_event(
                                           height,
                                           [&](T, P& at) {
                                             at.p()[0] = -at.p()[0];
                                             return ++n % 3 != 0;
                                           },
                                           CrossingDirection::falling));
      Semiexplicit stepper(BallOf<T>(), schemes::blanes_moan6<T>());
      P z(T(0.5) + T(0.0137) * T(k), 0);
      T lowest(0), t(0);
      while (t < 20)
        t = T(integrate(stepper, z, {.dt = T(0.05), .t0 = t, .t_end = T(20)}, watch, [&](T, const P& at) {
                lowest = std::min(lowest, at.q()[0]);
              }).t);
      CHECK(n >= 8);
      CHECK(lowest > -100 * std::numeric_limits<T>::epsilon());
    }
  };
  run(0.0F);
  run(0.0);
  run(0.0L);
}

TEST_CASE("A run that begins elsewhere at the time where the last one ended crosses nothing between",
          "[events]") {
  auto stepper = semiexplicit_of(Ball());
  auto watch = events(Ball(), on_event(height, [](double, Point& at) { at.p()[0] = -at.p()[0]; }));
  Point z(0.5, 0);
  integrate(stepper, z, {.dt = 0.05, .steps = 10}, watch);
  z = Point(-3, 1);
  integrate(stepper, z, {.dt = 0.05, .steps = 10, .t0 = 0.5}, watch);
  CHECK(watch.count() == 0);
}

TEST_CASE("A run whose steps may be subdivided refuses events that change the state, and no others",
          "[events]") {
  auto stepper = semiexplicit_of(Ball());
  Point z(0.5, 0);
  auto change = events(Ball(), on_event(height, [](double, Point& at) { at.p()[0] = 1; }));
  CHECK(
      refuses([&] { integrate(stepper, z, {.dt = 0.1, .steps = 5, .subdivide = 2}, change); }, "subdivide"));
  CHECK(z.q()[0] == 0.5);
  auto tell = events(Ball(), on_event(height, [](double, const Point&) {}));
  integrate(stepper, z, {.dt = 0.1, .steps = 15, .subdivide = 2}, tell);
  CHECK(tell.count() == 1);
}

TEST_CASE("Events that are only told of change nothing for other observers", "[events]") {
  // Beside a kind that may change the state, and does not.
  const auto watch_of = [] {
    return events(Oscillator(),
                  on_event([](const auto& q, const auto&) { return q[0] - 5; },
                           [](double, Point& at) { at.p()[0] = 0; }),
                  on_event(height, [](double, const Point&) {}));
  };
  auto stepper = semiexplicit_of(Oscillator());
  auto estimate = with_error_estimate(stepper), alone = estimate;
  auto fifth = every(5, poincare_section(Oscillator(), speed, [](double, const Point&) {}));
  int crossings = 0;
  auto section = poincare_section(Oscillator(), height, [&](double, const Point&) { ++crossings; },
                                  {.direction = CrossingDirection::both});
  auto watch = watch_of();
  Point z(1, 0), y = z;
  const auto report = integrate(stepper, z, {.dt = 0.1, .steps = 100}, watch, estimate, fifth, section);
  section.finish();
  CHECK(report.changes == 0);
  CHECK(watch.count() == 3);
  CHECK(crossings == 3);
  integrate(stepper, y, {.dt = 0.1, .steps = 100}, alone);
  REQUIRE(estimate.error());
  CHECK(*estimate.error() == Approx(*alone.error()).epsilon(0.1));
}

TEST_CASE("A resumed run with events has the same bits", "[events]") {
  const Folder folder;
  const IntegrationOptions<double> whole{.dt = 0.01, .steps = 1000};
  const auto make = [](Record<double, 1>& record) {
    return events(Oscillator(),
                  on_event([](const auto& q, const auto&) { return q[0] + 0.3; },
                           [](double, Point& at) { at.p()[0] = -at.p()[0]; }, CrossingDirection::falling),
                  on_event(speed, record));
  };
  auto stepper = semiexplicit_of(Oscillator());
  Point z(1, 0);
  Record<double, 1> tops;
  auto watch = make(tops);
  const auto report = integrate(stepper, z, whole, watch);
  CHECK(report.changes == 3);
  for (const int part : {100, 500, 700}) {
    auto first = semiexplicit_of(Oscillator()), second = first;
    Record<double, 1> record_1, record_2;
    auto options = whole;
    {
      auto events_1 = make(record_1);
      Point x(1, 0);
      Checkpoints checkpoints(folder.path / "run", {.every = part}, first, options, events_1);
      checkpoints.resume(x);
      integrate(first, x, options, events_1, checkpoints,
                [&](double, const Point&, const IntegrationReport& run) { return run.steps < part + 50; });
    }
    auto events_2 = make(record_2);
    Point y(1, 0);
    Checkpoints checkpoints(folder.path / "run", {.every = part}, second, options, events_2);
    options.done = checkpoints.resume(y);
    const auto rest = integrate(second, y, options, events_2, checkpoints);
    CHECK(y.vector() == z.vector());
    CHECK(rest.changes == report.changes);
    CHECK(record_2.t == tops.t);
    checkpoints.remove();
  }
}

TEST_CASE("A failure behind an event leaves the state of the event", "[events]") {
  // Upwards no step succeeds.
  struct OnlyDown {
    using Scalar = double;
    using State = Point;
    StepReport step(Point& z, const double& dt) {
      if (z.p()[0] > 0) return {.status = Status::no_convergence};
      z.q()[0] += dt * z.p()[0] - dt * dt / 2;
      z.p()[0] -= dt;
      return {};
    }
  };
  OnlyDown stepper;
  Point z(0.5, 0);
  auto watch =
      events(Ball(), on_event(
                         height, [](double, Point& at) { at.p()[0] = 1; }, CrossingDirection::falling));
  const auto report = integrate(stepper, z, {.dt = 0.3, .steps = 10, .on_failure = OnFailure::stop}, watch);
  CHECK(report.status == Status::no_convergence);
  CHECK(report.t == Approx(1).epsilon(1e-12));
  CHECK(std::abs(z.q()[0]) < 1e-12);
  CHECK(z.p()[0] == 1);
}

TEST_CASE("What throws at an event leaves the state of the event, and no event is lost or counted twice",
          "[events]") {
  auto stepper = semiexplicit_of(Ball());
  for (const bool action : {true, false}) {
    for (const int which : {1, 2}) {  // two bounces in a step of 3
      CAPTURE(action, which);
      Point z(0.5, 0), good = z;
      double now = 0;
      int bounces = 0;
      bool thrown = false;
      auto watch = events(Ball(), on_event(
                                      height,
                                      [&](double, Point& at) {
                                        at.p()[0] = 1;
                                        if (++bounces == which && action) throw std::runtime_error("action");
                                      },
                                      CrossingDirection::falling));
      const auto observer = [&](double t, const Point& at) {
        good = at;
        now = t;
        if (bounces == which && !action && !std::exchange(thrown, true)) throw std::runtime_error("observer");
      };
      CHECK_THROWS_AS(integrate(stepper, z, {.dt = 3.5, .t_end = 34}, watch, observer), std::runtime_error);
      CHECK(z.vector() == good.vector());
      CHECK(now == Approx(2 * which - 1));
      CHECK(z.p()[0] == Approx(action ? -1 : 1));
      CHECK(watch.count() == (action ? which - 1 : which));
      integrate(stepper, z, {.dt = 3.5, .t0 = now, .t_end = 34}, watch, observer);
      CHECK(watch.count() == 17);  // at t = 1, 3, ..., 33
      CHECK(z.q()[0] == Approx(elastic(34)));
    }
  }
}

TEST_CASE("Observers see nothing twice where a run goes on behind a gradient that threw at an event",
          "[events]") {
  for (const int call : {0, 5, 30}) {
    CAPTURE(call);
    int left = -1;
    const auto H =
        make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0]; },
                                    [&](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                      if (left >= 0 && left-- == 0) throw std::runtime_error("no licence");
                                      dHdq[0] = 1;
                                      dHdp[0] = p[0];
                                    });
    int bounces = 0;
    const auto bounce = [&](double, Point& at) {
      at.p()[0] = -at.p()[0];
      if (++bounces == 1) left = call;
    };
    auto watch = events(Ball(), on_event(height, bounce, CrossingDirection::falling));
    std::vector<double> crossings, rows;
    auto section = poincare_section(
        Ball(), [](const auto& q, const auto&) { return q[0] - 0.125; },
        [&](double t, const Point&) { crossings.push_back(t); }, {.direction = CrossingDirection::both});
    auto fourth = every(4, [&](double t, const Point&) { rows.push_back(t); });
    double now = 0;
    const auto clock = [&](double t, const Point&) { now = t; };
    auto stepper = semiexplicit_of(H);
    Point z(0.5, 0);
    const auto run = [&] {
      integrate(stepper, z, {.dt = 0.3, .t0 = now, .t_end = 3.9}, watch, section, fourth, clock);
    };
    CHECK_THROWS_AS(run(), std::runtime_error);  // in the step from 0.9 to 1.2, the surface crossed before it
    CHECK(now == Approx(1));
    CHECK(z.p()[0] == Approx(1));
    run();
    section.finish();
    CHECK(bounces == 2);
    const double time = std::sqrt(0.75);
    REQUIRE(crossings.size() == 4);
    CHECK(crossings[0] == Approx(time));
    CHECK(crossings[1] == Approx(2 - time));
    REQUIRE(rows.size() == 4);
    CHECK(rows[1] == Approx(1.29));  // three steps, and one of ten to the end
    CHECK(z.q()[0] == Approx(elastic(3.9)));
  }
}

TEST_CASE("The largest correction is that of what was accepted of a step that was cut", "[events]") {
  // One of the fall by its length, ten times that where it is fast, and five of the way up.
  struct Falls {
    using Scalar = double;
    using State = Point;
    StepReport step(Point& z, const double& dt) {
      const double p = z.p()[0];
      z.q()[0] += dt * p - dt * dt / 2;
      z.p()[0] -= dt;
      return {.correction = p > 0 ? 5 : p < -0.5 ? 10 * dt : dt};
    }
  };
  Falls stepper;
  Point z(0.5, 0);
  auto watch =
      events(Ball(), on_event(
                         height, [](double, Point& at) { at.p()[0] = 1; }, CrossingDirection::falling));
  CHECK(integrate(stepper, z, {.dt = 0.6, .steps = 2}, watch).max_correction == 5);
}

TEST_CASE("An action that throws, or a surface that is NaN, takes no event from the other kinds",
          "[events]") {
  // All within one step, q = cos t from 0.07 to -0.03.
  for (const bool action : {true, false}) {
    CAPTURE(action);
    int calls = 0;
    const auto level = [](double s) { return [s](const auto& q, const auto&) { return q[0] - s; }; };
    const auto tell = [](double, const Point&) {};
    auto watch = events(Oscillator(), on_event(level(-0.02), tell),
                        on_event([&](const auto& q, const auto&) { return action ? q[0] : std::sqrt(q[0]); },
                                 [&](double, const Point&) {
                                   if (++calls == 1) throw std::runtime_error("action");
                                 }),
                        on_event(level(0.02), tell), on_event(level(-0.01), tell));
    Point z(1, 0);
    double now = 0;
    const auto run = [&] {
      auto stepper = semiexplicit_of(Oscillator());
      integrate(
          stepper, z, {.dt = 0.1, .t0 = now, .t_end = 3}, [&](double t, const Point&) { now = t; }, watch);
    };
    if (action) {
      CHECK_THROWS_AS(run(), std::runtime_error);
      run();
    } else {
      while (now < 3) CHECK_THROWS_AS(run(), std::invalid_argument);
    }
    for (const std::size_t k : {0U, 2U, 3U}) CHECK(watch.count(k) == 1);
    CHECK(calls == (action ? 1 : 0));
  }
}

TEST_CASE("Lyapunov exponents refuse a run whose state is changed", "[events]") {
  auto stepper = semiexplicit_of(Ball());
  Point z(0.5, 0);
  LyapunovExponents lyapunov(stepper, 1);
  auto watch =
      events(Ball(), on_event(
                         height, [](double, Point& at) { at.p()[0] = 1; }, CrossingDirection::falling));
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.3, .steps = 10}, watch, lyapunov); }, "an event"));
}

TEST_CASE("An orbit that only touches a surface, or starts on it, makes no event", "[events]") {
  auto stepper = semiexplicit_of(Ball());
  Point z(0, 1);
  auto watch = events(Ball(), on_event(height, [](double, Point& at) { at.p()[0] = -at.p()[0]; }));
  integrate(stepper, z, {.dt = 0.1, .t_end = 1.9}, watch);
  CHECK(watch.count() == 0);
}

namespace {

/// Free motion, and no step but of a quarter.
struct Quarters {
  using Scalar = double;
  using State = PhasePoint<double, 1>;
  bool others = false;
  StepReport step(State& z, const double& dt) {
    if (dt != 0.25 && !others) return {.status = Status::no_convergence};
    z.q() += dt * z.p();
    return {};
  }
};

}  // namespace

TEST_CASE("Where a ball thrown up to a ceiling touches it rounding makes no event", "[events]") {
  for (int i = 0; i < 100; ++i) {
    const double speed = 0.3 + 0.017 * i, start = 0.01 * i - 0.7;
    CAPTURE(speed, start);
    const double top = start + speed * speed / 2, dt = speed / (7 + i % 5);
    const auto ceiling = [=](const auto& q, const auto&) { return std::exp(q[0]) - std::exp(top); };
    const auto stop = [](double, Point& z) { z.p()[0] = 0; };
    const auto nothing = [](double, const Point&) {};
    auto stopping = events(Ball(), on_event(ceiling, stop), on_event(height, nothing));
    auto told = events(Ball(), on_event(ceiling, nothing));
    auto stepper = semiexplicit_of(Ball());
    Point z(start, speed);
    integrate(stepper, z, {.dt = dt, .t_end = 2 * speed}, stopping, told);
    told.finish();
    CHECK(stopping.count(0) == 0);
    CHECK(told.count() == 0);
  }
}

TEST_CASE("A step of the search for an event that fails ends the run at the last good step", "[events]") {
  const systems::Product<double> any;
  Quarters stepper;
  PhasePoint<double, 1> z(0, 1);
  auto watch = events(any, on_event([](const auto& q, const auto&) { return q[0] - 0.6; },
                                    [](double, PhasePoint<double, 1>& at) { at.p() *= -1; }));
  const auto report = integrate(stepper, z, {.dt = 0.25, .steps = 10, .on_failure = OnFailure::stop}, watch);
  CHECK(report.status == Status::no_convergence);
  CHECK(report.steps == 2);
  CHECK(z.q()[0] == 0.5);
  CHECK(watch.count() == 0);
  // And nothing is lost of it where a better stepper goes on.
  stepper.others = true;
  integrate(stepper, z, {.dt = 0.25, .t0 = report.t, .t_end = 1}, watch);
  CHECK(watch.count() == 1);
  CHECK(z.q()[0] == Approx(0.2));
}

TEST_CASE("An exception in the search for an event loses none", "[events]") {
  // With an event of another kind before it in the same step.
  bool armed = false;
  const auto H =
      make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0]; },
                                  [&](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                    if (std::exchange(armed, false)) throw std::runtime_error("no licence");
                                    dHdq[0] = 1;
                                    dHdp[0] = p[0];
                                  });
  int told = 0, calls = 0;
  auto watch = events(
      H,
      on_event([](const auto& q, const auto&) { return q[0] - 0.01; },
               [&](double, const Point&) { armed = ++told == 1; }, CrossingDirection::falling),
      on_event(
          height, [&](double, Point& at) { ++calls, at.p()[0] = -at.p()[0]; }, CrossingDirection::falling));
  auto stepper = semiexplicit_of(H);
  Point z(0.5, 0);
  double now = 0;
  const auto clock = [&](double t, const Point&) { now = t; };
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.3, .t_end = 3.9}, clock, watch), std::runtime_error);
  CHECK(now == Approx(std::sqrt(0.98)));
  CHECK(watch.count() == 1);
  integrate(stepper, z, {.dt = 0.3, .t0 = now, .t_end = 3.9}, clock, watch);
  CHECK(watch.count(0) == 2);
  CHECK(watch.count(1) == 2);
  CHECK(calls == 2);
  CHECK(z.q()[0] == Approx(elastic(3.9)));
}

TEMPLATE_TEST_CASE("Events are found however small s has become", "[events]", float, double) {
  // A spring at rest on a wall: it hits it every half turn, whatever is left of its speed, and turns between.
  using State = PhasePoint<TestType, 1>;
  const auto spring =
      from_energy<1, TestType>([](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; });
  GaussLegendre stepper(spring, {.stages = 6});
  const auto position = [](const auto& q, const auto&) { return q[0]; };
  int hits = 0, turns = 0;
  double worst = 0;
  auto bounces = events(spring, on_event(
                                    position,
                                    [&](TestType t, State& at) {
                                      worst = std::max(worst, std::abs(double(t) - (hits++ + 0.5) * pi));
                                      at.p()[0] *= TestType(-0.5);
                                      return hits < 90;
                                    },
                                    CrossingDirection::falling));
  auto tops = poincare_section(
      spring, [](const auto&, const auto& p) { return p[0]; },
      [&](TestType t, const State&) { worst = std::max(worst, std::abs(double(t) - ++turns * pi)); },
      {.direction = CrossingDirection::falling});
  State z(1, 0);
  integrate(stepper, z, {.dt = TestType(0.1), .t_end = 300}, bounces, tops);
  tops.finish();
  CHECK(hits == 90);
  CHECK(turns == 89);
  CHECK(worst < 400 * std::numeric_limits<TestType>::epsilon() * 300);
}

TEST_CASE("A ball that is braked as it falls through a surface goes on, in float", "[events]") {
  using State = PhasePoint<float, 1>;
  const auto ball =
      from_energy<1, float>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + 0.7F * q[0]; });
  const float left = GENERATE(0.1F, 0.005F, 0.002F, 0.001F);
  auto watch = events(ball, on_event([](const auto& q, const auto&) { return q[0]; },
                                     [&](float, State& at) { at.p()[0] = -left; }));
  State z(2, 0);
  Semiexplicit stepper(ball, schemes::strang<float>());
  integrate(stepper, z, {.dt = 0.05F, .t_end = 4}, watch);
  const double after = 4 - std::sqrt(4 / 0.7);
  CHECK(watch.count() == 1);
  CHECK(double(z.q()[0]) == Approx(-left * after - 0.35 * after * after).epsilon(1e-5));
}

TEST_CASE("An orbit that lies in a surface has no crossings there", "[events]") {
  using State = PhasePoint<double, 2>;
  const auto oscillator =
      from_energy<2>([](const auto& q, const auto& p) { return (dot(q, q) + dot(p, p)) / 2; });
  const auto surface = [](const auto& q, const auto&) { return q[1] - 0.7 * q[0]; };
  Semiexplicit stepper(oscillator, schemes::low_defect6_s13());
  State z({1, 0.7}, {0.2, 0.14});
  auto told = events(oscillator, on_event(surface, [](double, const State&) {}));
  integrate(stepper, z, {.dt = 0.1, .steps = 2000}, told);
  CHECK(told.count() == 0);
  CHECK(std::abs(surface(z.q(), z.p())) < 1e-12);
  auto acts = events(oscillator, on_event(surface, [](double, State& at) { at.p() *= 0.5; }));
  integrate(stepper, z = State({1, 0.7}, {0.2, 0.14}), {.dt = 0.1, .steps = 2000}, acts);
  CHECK(acts.count() == 0);
}

/// A stepper of which one call fails.
struct FailsOnce {
  using Scalar = double;
  using State = PhasePoint<double, 1>;
  Semiexplicit<Ball> stepper;
  int fails_at = 0, calls = 0;
  StepReport step(State& z, const double& dt) {
    if (++calls == fails_at) return {.status = Status::no_convergence};
    return stepper.step(z, dt);
  }
};

TEST_CASE("A step that fails while an event is looked for is that failure, wherever it is", "[events]") {
  int failed = 0;
  for (int k = 1; k < 400; ++k) {
    CAPTURE(k);
    FailsOnce stepper{Semiexplicit(Ball(), schemes::strang<double>()), k};
    PhasePoint<double, 1> z(0.3, 0), shown = z;
    auto bounces = events(Ball(),
                          on_event([](const auto& q, const auto&) { return q[0]; },
                                   [](double, PhasePoint<double, 1>& at) { at.p() *= -1; }),
                          on_event([](const auto& q, const auto&) { return q[0] - 0.15; },
                                   [](double, PhasePoint<double, 1>& at) { at.p() *= 1.01; }));
    IntegrationReport report;
    CHECK_NOTHROW(report = integrate(stepper, z, {.dt = 0.2, .steps = 20, .on_failure = OnFailure::stop},
                                     bounces, [&](double, const auto& at) { shown = at; }));
    failed += report.ok() ? 0 : 1;
    CHECK((report.ok() || report.status == Status::no_convergence));
    CHECK(z.vector() == shown.vector());
  }
  CHECK(failed > 50);
}

TEMPLATE_TEST_CASE("A surface is seen again by its own size, once steps have shown that", "[events]", float,
                   double) {
  using Scalar = TestType;
  using State = PhasePoint<Scalar, 2>;
  // The second position is the time, and s is large only before the first of the burns.
  const auto h = from_energy<2, Scalar>([](const auto&, const auto& p) { return p[0] * p[0] / 2 + p[1]; });
  const bool in_float = std::same_as<Scalar, float>;
  const Scalar far = in_float ? 30 : 10'000, dt = in_float ? Scalar(0.1) : Scalar(0.005);
  const Scalar last = in_float ? Scalar(1.3) : Scalar(1.02);
  const auto s = [=](const auto& q, const auto&) -> Scalar {
    return (q[1] - far) * (q[1] - far - 1) * (q[1] - far - last);
  };
  int burns = 0;
  auto watch = events(h, on_event(s, [&](Scalar, State& z) {
                        ++burns;
                        z.p()[0] += Scalar(0.5);
                      }));
  Semiexplicit stepper(h, schemes::strang<Scalar>());
  State z({0, 0}, {1, 0});
  integrate(stepper, z, {.dt = dt, .t_end = far + 2}, watch);
  CHECK(burns == 3);
  CHECK(z.p()[0] == Approx(2.5));
}

TEMPLATE_TEST_CASE("Steps too short for any part of them to be a number come back", "[events]", float,
                   double) {
  using State = PhasePoint<TestType, 1>;
  const auto h =
      from_energy<1, TestType>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; });
  for (const TestType dt :
       {std::numeric_limits<TestType>::denorm_min(), std::numeric_limits<TestType>::min()}) {
    State z(TestType(0), TestType(1));  // on the surface
    GaussLegendre stepper(h, {.stages = 3});
    auto bounces = events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                                      [](TestType, State& now) { now.p()[0] *= -1; }));
    integrate(stepper, z, {.dt = dt, .steps = 10}, bounces);
    CHECK(bounces.count() == 0);
    CHECK(z.p()[0] == TestType(1));
  }
}

TEST_CASE("A section that was moved from says so, whatever the size", "[events]") {
  const auto h =
      from_energy(2, [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; });
  auto from = poincare_section(
      h, [](const auto& q, const auto&) { return q[0]; }, [](double, const auto&) {});
  const auto to = std::move(from);
  PhasePoint<double, Eigen::Dynamic> z(2);
  z.vector().setOnes();
  GaussLegendre stepper(h, {.stages = 3});
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.1, .steps = 50}, from), std::logic_error);
}

TEST_CASE("Events that act refuse a state of another size in a later run too", "[events]") {
  const auto energy = [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; };
  const auto h = from_energy(3, energy), other = from_energy(2, energy);
  auto bounces =
      events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                         [](double, PhasePoint<double, Eigen::Dynamic>& now) { now.p()[0] *= -1; }));
  GaussLegendre stepper(h, {.stages = 3}), second(other, {.stages = 3});
  PhasePoint<double, Eigen::Dynamic> z(3), smaller(2);
  z.vector().setOnes();
  smaller.vector().setOnes();
  integrate(stepper, z, {.dt = 0.1, .steps = 50}, bounces);
  CHECK_THROWS_WITH(integrate(second, smaller, {.dt = 0.1, .steps = 50}, bounces),
                    Catch::Contains("the state has another size than H"));
}

}  // namespace test_events
