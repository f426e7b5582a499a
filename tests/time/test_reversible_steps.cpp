// Steps that follow a monitor function and can be undone.

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "folder.hpp"
#include "kepler.hpp"
#include "refusal.hpp"

namespace test_reversible_steps {

namespace {

using namespace semiexplicit;
const double pi = std::acos(-1.0);

using Point = PhasePoint<double, 2>;

/// The free-fall time, up to a factor; no derivatives.
const auto free_fall = [](const auto& q, const auto&) { return std::pow(q.squaredNorm(), 0.75); };

/// An own stepper without anything but a step: leapfrog composed to order 4 (Suzuki).
struct Leapfrogs {
  using Scalar = double;
  using State = Point;
  StepReport step(Point& z, const double& dt) {
    Point next = z;
    const double s = 1 / (4 - std::cbrt(4.0));
    for (const double part : {s, s, 1 - 4 * s, s, s}) {
      next.q() += part * dt / 2 * next.p();
      next.p() -= part * dt * next.q() / std::pow(next.q().squaredNorm(), 1.5);
      next.q() += part * dt / 2 * next.p();
    }
    if (!next.vector().allFinite()) return {.status = Status::not_finite};
    z = next;
    return {.evaluations = 1, .gradients = 5};
  }
};

template <class Stepper>
double there_and_back(Stepper stepper, double ds) {
  const Point start = kepler_orbit(0.9, 1);
  Point z = start;
  const auto there = integrate(stepper, z, {.dt = ds, .steps = 500, .t0 = 3});
  const auto back = integrate(stepper, z, {.dt = -ds, .steps = 500, .t0 = there.t});
  CHECK(std::abs(there.t - 3) > 10);
  CHECK(back.t == Approx(3).margin(1e-10));
  return (z.vector() - start.vector()).norm() / start.vector().norm();
}

}  // namespace

TEST_CASE("Reversible steps lead there and back to rounding, with every symmetric stepper",
          "[reversible steps]") {
  const Kepler h;
  CHECK(there_and_back(ReversibleSteps(Leapfrogs(), free_fall), 0.1) < 1e-10);
  CHECK(there_and_back(ReversibleSteps(ExplicitSplitting(h, schemes::blanes_moan6()), free_fall), 0.1) <
        1e-10);
  CHECK(there_and_back(ReversibleSteps(Semiexplicit(h, schemes::blanes_moan6(),
                                                    SimplifiedNewton{.stop = StoppingRule::paper(1e-15)}),
                                       free_fall),
                       0.1) < 1e-10);
  CHECK(there_and_back(ReversibleSteps(GaussLegendre(h, {.stages = 4}), free_fall), 0.1) < 1e-10);
  const Scene scene(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{.gm = 1});
  CHECK(there_and_back(ReversibleSteps(stepper_for(scene), free_fall), 0.1) < 1e-10);
  // The midpoint projection is not symmetric, but its error is small where its steps are.
  CHECK(there_and_back(ReversibleSteps(MidpointProjection(h, schemes::low_defect6_s13()), free_fall), 0.05) <
        1e-5);
}

/// Two oscillators, one of them hard.
struct Oscillators {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr bool separable = true;
  using SeparableGradientOf = Oscillators;
  double energy(In<double, 2> q, In<double, 2> p) const {
    return (p.squaredNorm() + q[0] * q[0] + 2 * q[1] * q[1]) / 2 + q[0] * q[0] * q[0] * q[0] / 4;
  }
  void position_gradient(In<double, 2> q, Out<double, 2> half) const {
    half << q[0] + q[0] * q[0] * q[0], 2 * q[1];
  }
  void momentum_gradient(In<double, 2> p, Out<double, 2> half) const { half = p; }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    position_gradient(q, dHdq);
    momentum_gradient(p, dHdp);
  }
};

TEST_CASE("Reversible steps that come to swing start afresh, and fail where they do soon",
          "[reversible steps]") {
  // With steps of which the longest is a tenth of a period, and g three times as large there as elsewhere.
  const Oscillators h;
  const auto g = [](const auto& q, const auto&) { return 1 / (0.3 + 0.5 * q.squaredNorm()); };
  const Point start({0.3, 0.2}, {0.8, 0.9});
  ReversibleSteps stepper(ExplicitSplitting(h, schemes::blanes_moan6()), g);
  Invariants invariants(h);
  double farthest = 0, longest = 0, wanted = 0;
  Point z = start;
  const auto look = [&](double, const Point& now, const IntegrationReport& run) {
    farthest = std::max(farthest, stepper.swing());
    if (run.steps > 0) longest = std::max(longest, run.taken / wanted);
    wanted = 0.087 * g(now.q(), now.p());
  };
  integrate(stepper, z, {.dt = 0.087, .steps = 60'000}, invariants, look);
  CHECK(stepper.restarts() >= 1);
  CHECK(stepper.restarts() <= 3);
  CHECK(farthest > 0.1);
  CHECK(farthest <= stepper.most_swing);
  CHECK(longest < 1.6);
  CHECK(invariants["energy"].worst < 1e-7);

  ReversibleSteps coarse(ExplicitSplitting(h, schemes::blanes_moan6()), g);
  z = start;
  Point last = z;
  const auto report = integrate(coarse, z, {.dt = 0.115, .steps = 60'000, .on_failure = OnFailure::stop},
                                [&](double, const Point& now) { last = now; });
  CHECK(report.status == Status::invalid_monitor);
  CHECK(report.steps < coarse.least_between);
  CHECK(z.vector() == last.vector());
  CHECK(coarse.time() == report.t);

  // A shorter dt does not inherit the swing.
  Point y = z;
  ReversibleSteps fresh(ExplicitSplitting(h, schemes::blanes_moan6()), g);
  integrate(coarse, z, {.dt = 0.05, .steps = 2000});
  integrate(fresh, y, {.dt = 0.05, .steps = 2000});
  CHECK(z.vector() == y.vector());
}

TEST_CASE("Monitor functions of distances leave out the time of a driven system", "[reversible steps]") {
  const Autonomous driven(from_energy<2>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    using std::sqrt;
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]) + 0.01 * q[0] * cos(t);
  }));
  const auto start = driven.extended({{0.7, 0}, {0, 1.3}}, 100);
  const auto end_with = [&](const auto& monitor) {
    auto z = start;
    const Semiexplicit by_times(driven);
    ReversibleSteps stepper(by_times, monitor);
    integrate(stepper, z, {.dt = 0.05, .t0 = 100, .t_end = 120});
    return z;
  };
  const auto by_hand = end_with([](const auto& q, const auto&) { return std::sqrt(q.head(2).norm()); });
  CHECK((end_with(monitors::Distance{.power = 0.5}).vector() - by_hand.vector()).norm() < 1e-12);
  const Eigen::Vector2d origin(0, 0);
  CHECK((end_with(monitors::DistanceFrom(origin, 0.5)).vector() - by_hand.vector()).norm() < 1e-12);
  CHECK(refuses([&] { end_with(monitors::DistanceFrom(Eigen::Vector3d(0, 0, 0), 0.5)); },
                "give a centre of the system's, without the time"));
}

namespace {

/// Vortices that are shaken.
struct Shaken {
  using Scalar = double;
  static constexpr int Dof = 3;
  systems::PointVortices<double, 3> vortices;
  void gradient(const double& t, In<double, 3> q, In<double, 3> p, Out<double, 3> dHdq,
                Out<double, 3> dHdp) const {
    vortices.gradient(q, p, dHdq, dHdp);
    dHdq[0] += 1e-3 * std::cos(t);
  }
};

}  // namespace

TEST_CASE("Distances of vortices leave out the time of a driven system", "[reversible steps]") {
  const systems::PointVortices<double, 3> vortices({1, 0.7, -0.4});
  const Autonomous driven(Shaken{vortices});
  const monitors::VortexDistances distances(vortices);
  const auto end_with = [&](const auto& monitor) {
    auto z = driven.extended({{0.3, -0.8, 0.5}, {0.1, 0.4, -0.6}}, 0.5);
    const Semiexplicit by_times(driven);
    ReversibleSteps stepper(by_times, monitor);
    const auto report = integrate(stepper, z, {.dt = 0.02, .t0 = 0.5, .t_end = 2.5});
    return std::pair(z, report.steps);
  };
  const auto [ready, steps] = end_with(distances);
  const auto [by_hand, expected] =
      end_with([&](const auto& q, const auto& p) { return distances.value(q.head(3), p.head(3)); });
  CHECK(steps == expected);
  CHECK(ready.vector() == by_hand.vector());
}

TEST_CASE("A run by reversible steps refuses an observer that moves its stepper", "[reversible steps]") {
  const Semiexplicit by_times{Kepler()};
  ReversibleSteps stepper(by_times, free_fall);
  Point z = kepler_orbit(0.5, 0);
  CHECK(says(complaint<std::logic_error>([&] {
               integrate(stepper, z, {.dt = 0.1, .t_end = 5}, [&](double t, Point ahead) {
                 if (t > 2) integrate(stepper, ahead, {.dt = 0.1, .steps = 3, .t0 = t});
               });
             }),
             "an observer has moved the stepper of this run, which keeps a time; give it a copy"));
  z = kepler_orbit(0.5, 0);
  CHECK_NOTHROW(integrate(stepper, z, {.dt = 0.1, .t_end = 5}, [&](double t, Point ahead) {
    auto own = stepper;
    if (t > 2) integrate(own, ahead, {.dt = 0.1, .steps = 3, .t0 = t});
  }));
}

TEST_CASE("Reversible steps have the order of their stepper, and end at the time asked for",
          "[reversible steps]") {
  for (const auto& scheme : {schemes::strang(), schemes::blanes_moan4(), schemes::blanes_moan6()}) {
    CAPTURE(scheme.name);
    const auto error = [&](double ds) {
      ReversibleSteps stepper(Semiexplicit(Kepler(), scheme), free_fall);
      Point z = kepler_orbit(0.7, 0.5);
      const auto report = integrate(stepper, z, {.dt = ds, .t0 = 0.5, .t_end = 5.5});
      CHECK(report.t == 5.5);
      CHECK(stepper.time() == 5.5);
      return (z.vector() - kepler_orbit(0.7, 5.5).vector()).norm();
    };
    CHECK(std::log2(error(0.06) / error(0.03)) == Approx(scheme.order).margin(0.5));
  }
}

TEST_CASE("Reversible steps are proportional to the monitor function", "[reversible steps]") {
  ReversibleSteps stepper(ExplicitSplitting(Kepler(), schemes::suzuki_umeno8()), free_fall);
  Point z = kepler_orbit(0.9, 2), before = z;
  double worst = 0;
  const double ds = 0.05;
  integrate(stepper, z, {.dt = ds, .steps = 2000},
            [&](double, const Point& at, const IntegrationReport& report) {
              if (report.taken != 0) {
                const double g = std::sqrt(free_fall(at.q(), at.p()) * free_fall(before.q(), before.p()));
                worst = std::max(worst, std::abs(report.taken / (ds * g) - 1));
              }
              before = at;
            });
  CHECK(worst < 0.02);
}

TEST_CASE("The clock of reversible steps sums times with compensation", "[reversible steps]") {
  ReversibleSteps stepper(Leapfrogs(), free_fall);
  Point z = kepler_orbit(0.5, 1);
  long double sum = 1000;
  const auto run =
      integrate(stepper, z, {.dt = 0.01, .steps = 20'000, .t0 = 1000},
                [&](double, const Point&, const IntegrationReport& so_far) { sum += so_far.taken; });
  CHECK(std::abs(double(run.t - sum)) <= 1.2e-13);  // a rounding of the time itself
}

TEST_CASE("Output, sections and events of reversible steps are at physical times", "[reversible steps]") {
  const Kepler h;
  const double e = 0.9;
  ReversibleSteps stepper(Semiexplicit(h, schemes::low_defect8_s20()), monitors::Distance{});
  std::vector<double> times;
  for (int i = 0; i <= 100; ++i) times.push_back(1 + 0.3 * i);
  double worst = 0, worst_section = 0;
  auto output = at_times(
      h, times,
      [&](double t, const Point& at) { worst = std::max(worst, (at.q() - kepler_orbit(e, t).q()).norm()); },
      6);
  int count = 0;
  auto section = poincare_section(
      h, [](const auto& q, const auto&) { return q[1]; },
      [&](double t, const Point&) {
        worst_section = std::max(worst_section, std::abs(t - 2 * pi * ++count));
      },
      {.nodes = 6});
  Point z = kepler_orbit(e, 1);
  integrate(stepper, z, {.dt = 0.03, .t0 = 1, .t_end = 32}, output, section);
  output.finish();
  CHECK(output.served() == times.size());
  CHECK(count == 5);
  CHECK(worst < 1e-9);
  CHECK(worst_section < 1e-9);
}

TEST_CASE("Reversible steps, events and estimates take float and long double", "[reversible steps]") {
  const auto run = []<class T>(T) {
    // The solvable product: after a whole period the orbit is where it was.
    const systems::Product<T> h;
    // 4 K(3/√10)/√10 with the complete elliptic integral K by the mean of arithmetic and geometric means.
    T a = T(1), b = 1 / std::sqrt(T(10));
    for (int i = 0; i < 8; ++i) {
      const T mean = (a + b) / 2;
      b = std::sqrt(a * b);
      a = mean;
    }
    const T period = 2 * T(std::acos(T(-1))) / (a * std::sqrt(T(10)));
    ReversibleSteps stepper(Semiexplicit(h, schemes::blanes_moan6<T>()), [](const auto& q, const auto& p) {
      return T(1) / (1 + q[0] * q[0] + p[0] * p[0]);
    });
    PhasePoint<T, 1> z(T(-3), T(0));
    int crossings = 0;
    auto estimate = with_error_estimate(stepper.stepper());
    auto watch = events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                                    [&](const T&, const PhasePoint<T, 1>&) { ++crossings; }));
    integrate(stepper, z, {.dt = T(0.1), .t_end = period}, estimate, watch);
    CHECK(crossings == 2);
    CHECK(double(z.q()[0]) == Approx(-3).epsilon(1e-5));
    CHECK(std::abs(double(z.p()[0])) < 1e-4);
    CHECK(*estimate.error() < T(1e-4));
  };
  run(1.0F);
  run(1.0L);
}

TEST_CASE("A resumed run of reversible steps has the same bits", "[reversible steps]") {
  const Folder folder;
  const auto path = folder.path / "run.checkpoint";
  const auto make = [] {
    return ReversibleSteps(GaussLegendre(Kepler(), {.stages = 4}), monitors::Distance{});
  };
  for (const bool by_time : {false, true}) {
    IntegrationOptions<double> options{.dt = 0.1, .t0 = 1};
    if (by_time)
      options.t_end = 40;
    else
      options.steps = 400;
    auto whole = make();
    Point z = kepler_orbit(0.9, 1);
    const auto all = integrate(whole, z, options);

    {
      auto first = make();
      Point x = kepler_orbit(0.9, 1);
      Checkpoints checkpoints(path, {.every = 100}, first, options);
      checkpoints.resume(x);
      integrate(first, x, options, checkpoints, [](double t, const Point&) { return t < 20; });
    }
    auto second = make();
    Point y = kepler_orbit(0.9, 1);
    Checkpoints checkpoints(path, {.every = 100}, second, options);
    options.done = checkpoints.resume(y);
    CHECK(options.done.steps >= 100);
    const auto rest = integrate(second, y, options, checkpoints);
    CHECK(rest.t == all.t);
    CHECK(rest.steps == all.steps);
    CHECK((y.vector().array() == z.vector().array()).all());
    checkpoints.remove();
  }
}

TEST_CASE("Reversible steps are gone on with by the stepper that made them, and by no other",
          "[reversible steps]") {
  const auto make = [] {
    return ReversibleSteps(GaussLegendre(Kepler(), {.stages = 4}), monitors::Distance{});
  };
  const auto until_20 = [](double t, const Point&) { return t < 20; };
  IntegrationOptions<double> options{.dt = 0.1, .t_end = 40};
  auto whole = make(), first = make();
  Point z = kepler_orbit(0.9, 1), x = z;
  integrate(whole, z, options);
  const auto early = integrate(first, x, options, until_20);
  options.done = early;

  auto same = first;
  Point y = x;
  CHECK(integrate(same, y, options).t == 40);
  CHECK((y.vector().array() == z.vector().array()).all());
  auto fresh = make(), elsewhere = first;
  Point other = kepler_orbit(0.5, 0);
  integrate(elsewhere, other, {.dt = 0.1, .steps = 7});
  y = x;
  CHECK(refuses([&] { integrate(fresh, y, options); }, "did not make the earlier part"));
  CHECK(refuses([&] { integrate(elsewhere, y, options); }, "did not make the earlier part"));
  options.t_end = 10;
  CHECK(refuses([&] { integrate(first, y, options); }, "give a t_end beyond that"));
  CHECK((y.vector().array() == x.vector().array()).all());
}

TEST_CASE("A run of reversible steps goes on after a subdivided step", "[time]") {
  // Steps of 0.6 do not converge from there; the parts do.
  const systems::Product<double> h;
  const auto steps_of_one = [](const auto&, const auto&) { return 1.0; };
  const auto stepper = [&] {
    return ReversibleSteps(Semiexplicit(h, schemes::low_defect6_s13()), steps_of_one);
  };
  IntegrationOptions<double> options{.dt = 0.6, .steps = 10, .subdivide = 6};
  auto whole = stepper(), parts = stepper(), other = stepper();
  PhasePoint<double, 1> z(-3, 0), y = z, x = z;
  const auto all = integrate(whole, z, options);
  REQUIRE(all.subdivided > 0);
  options.steps = 5;
  options.done = integrate(parts, y, options);
  REQUIRE(options.done.subdivided > 0);
  options.steps = 10;
  CHECK(integrate(parts, y, options).t == all.t);
  CHECK(y.vector() == z.vector());
  integrate(other, x, {.dt = 0.6, .steps = 4, .subdivide = 6});
  CHECK(refuses([&] { integrate(other, x, options); }, "did not make the earlier part"));
}

TEST_CASE("A run of reversible steps goes on after a step that failed in parts, too", "[time]") {
  const auto steps_of_one = [](const auto&, const auto&) { return 1.0; };
  int failed = 0;
  for (double dt = 0.3; dt < 0.6; dt += 0.02) {
    CAPTURE(dt);
    ReversibleSteps stepper(Semiexplicit(Kepler(), schemes::low_defect6_s13<double>()), steps_of_one);
    const double e = 0.9;
    Point z({-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))});
    IntegrationOptions<double> options{.dt = dt, .on_failure = OnFailure::stop, .subdivide = 2, .t_end = 6};
    options.done = integrate(stepper, z, options);
    if (options.done.ok()) continue;
    ++failed;
    if (options.done.subdivided == 0) CHECK(options.done.taken == stepper.taken());
    options.subdivide = 8;
    CHECK_NOTHROW(integrate(stepper, z, options));
  }
  CHECK(failed > 5);
}

TEST_CASE("A checkpoint of reversible steps by another monitor function is refused", "[reversible steps]") {
  const Folder folder;
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 10};
  Point z = kepler_orbit(0.9, 1);
  {
    ReversibleSteps one(GaussLegendre(Kepler(), {.stages = 4}), monitors::Distance{1.5});
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, one, options);
    checkpoints.resume(z);
    integrate(one, z, options, checkpoints);
  }
  ReversibleSteps other(GaussLegendre(Kepler(), {.stages = 4}), monitors::Distance{1});
  Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, other, options);
  z = kepler_orbit(0.9, 1);
  CHECK(refuses([&] { checkpoints.resume(z); }, "monitor"));
}

TEST_CASE("A reversible step that fails leaves the state, the time and the density", "[reversible steps]") {
  // Everything stays where the monitor throws, is not positive, or the stepper fails; and the run goes on
  // after.
  struct Fault {
    int* calls;
    int at;
    int kind;
    double operator()(const In<double, 2>& q, const In<double, 2>&) const {
      if (++*calls == at) {
        if (kind == 0) throw std::runtime_error("monitor");
        return kind == 1 ? -1.0 : std::nan("");
      }
      return std::pow(q.squaredNorm(), 0.75);
    }
  };
  for (const int kind : {0, 1, 2}) {
    int calls = 0, never = 0;
    ReversibleSteps faulty(Leapfrogs(), Fault{&calls, 8, kind}), sound(Leapfrogs(), Fault{&never, 0, 0});
    Point z = kepler_orbit(0.9, 1), x = z;
    for (int i = 0; i < 4; ++i) REQUIRE((faulty.step(z, 0.1).ok() && sound.step(x, 0.1).ok()));
    const Point before = z;
    const double time = faulty.time();
    if (kind == 0)
      CHECK_THROWS_AS(faulty.step(z, 0.1), std::runtime_error);
    else
      CHECK(faulty.step(z, 0.1).status == Status::invalid_monitor);
    CHECK(z.vector() == before.vector());
    CHECK(faulty.time() == time);
    for (int i = 0; i < 4; ++i) REQUIRE((faulty.step(z, 0.1).ok() && sound.step(x, 0.1).ok()));
    CHECK(z.vector() == x.vector());
    CHECK(faulty.time() == sound.time());
  }
}

TEST_CASE("Reversible steps whose first step failed start as if it had not been", "[reversible steps]") {
  const auto begun = [](auto& stepper) {
    Point z = kepler_orbit(0.9, 1);
    integrate(stepper, z, {.dt = 0.1, .steps = 500});
    return z;
  };
  ReversibleSteps clean{Semiexplicit(Kepler()), free_fall};
  const Point expected = begun(clean);
  for (const double too_long : {1.5, 3.0}) {
    ReversibleSteps stepper{Semiexplicit(Kepler()), free_fall};
    Point z = kepler_orbit(0.9, 1);
    REQUIRE_FALSE(stepper.step(z, too_long).ok());
    CHECK(begun(stepper).vector() == expected.vector());
    CHECK(stepper.swing() == clean.swing());
  }
  for (const int at : {1, 2, 3, 4}) {
    int calls = 0;
    ReversibleSteps stepper{Semiexplicit(Kepler()), [&](const auto& q, const auto& p) {
                              if (++calls == at) throw std::runtime_error("monitor");
                              return free_fall(q, p);
                            }};
    Point z = kepler_orbit(0.9, 1);
    CHECK_THROWS_AS(stepper.step(z, 0.1), std::runtime_error);
    CHECK(begun(stepper).vector() == expected.vector());
  }
  // Where only one of the trial steps can be taken, the density has the slope of that.
  ReversibleSteps one_sided{Semiexplicit(Kepler()), [](const auto& q, const auto& p) {
                              // starts with 0.8844, and rises
                              return q.dot(p) > 0.88 ? free_fall(q, p) : std::nan("");
                            }};
  Point z = kepler_orbit(0.9, 0.5);
  integrate(one_sided, z, {.dt = 0.1, .steps = 3});
  CHECK(one_sided.swing() < 0.005);
}

TEST_CASE("Reversible steps below the rounding of the time come to t_end", "[reversible steps]") {
  const auto oscillator =
      from_energy<1, float>([](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; });
  ReversibleSteps stepper(Semiexplicit(oscillator, schemes::low_defect6_s13<float>()),
                          [](const auto&, const auto&) { return 1.0F; });
  PhasePoint<float, 1> z(1, 0);
  const auto run = integrate(stepper, z, {.dt = 0.003F, .t0 = 1e6F, .t_end = 1e6F + 2});
  CHECK(run.t == 1e6 + 2);
  CHECK(double(z.q()[0]) == Approx(std::cos(2.0)).epsilon(1e-6));
}

TEST_CASE("A monitor function that grows too fast for the step is said to", "[reversible steps]") {
  ReversibleSteps stepper(Leapfrogs(), free_fall);
  Point z = kepler_orbit(0.99, -0.3);
  const auto report = integrate(stepper, z, {.dt = 2.5, .steps = 100, .on_failure = OnFailure::stop});
  CHECK(report.status == Status::invalid_monitor);
  CHECK(z.vector().allFinite());
  CHECK(describe(report.status).find("reduce dt") != std::string::npos);
}

TEST_CASE("A reversible step cut into parts keeps time and density", "[reversible steps]") {
  // Steps fail beyond a size, as those of an iteration would.
  struct Short : Leapfrogs {
    StepReport step(Point& z, const double& dt) {
      if (std::abs(dt) > 0.5) return {.status = Status::no_convergence};
      return Leapfrogs::step(z, dt);
    }
  };
  ReversibleSteps stepper(Short(), free_fall);
  Point z = kepler_orbit(0.9, 0);
  const auto report = integrate(stepper, z, {.dt = 0.3, .subdivide = 3, .t_end = 4});
  CHECK(report.subdivided > 0);
  CHECK(report.t == 4);
  CHECK((z.vector() - kepler_orbit(0.9, 4).vector()).norm() < 5e-2);
}

TEST_CASE("Lyapunov exponents under reversible steps are those of the motion", "[reversible steps]") {
  // The hyperbolic fixed point at which the equations of motion are linear: q' = p, p' = q, exponents 1 and
  // -1.
  const auto h = from_energy<1>([](const auto& q, const auto& p) { return (p[0] * p[0] - q[0] * q[0]) / 2; });
  ReversibleSteps stepper(Semiexplicit(h, schemes::blanes_moan6()),
                          [](const auto& q, const auto&) { return 1 / (1 + q[0] * q[0]); });
  PhasePoint<double, 1> z(1e-6, -1e-6);
  LyapunovExponents lyapunov(stepper, 2);
  Eigen::Matrix2d directions;
  directions << 1, 1, 1, -1;
  lyapunov.start_with(directions);
  integrate(stepper, z, {.dt = 0.05, .t_end = 10}, lyapunov);
  CHECK(lyapunov.exponents()[0] == Approx(1).epsilon(1e-8));
  CHECK(lyapunov.exponents()[1] == Approx(-1).epsilon(1e-8));
}

TEST_CASE(
    "The time scale of any Hamiltonian is r^(3/2) of a circular orbit, in any units, and steps follow it",
    "[reversible steps]") {
  const Kepler h;
  for (const double r : {0.1, 1.0, 30.0}) {
    const monitors::TimeScale scale(h, {.length = r, .momentum = 1 / std::sqrt(r), .longest = 1e12});
    CHECK(scale.value(Eigen::Vector2d(r, 0), Eigen::Vector2d(0, 1 / std::sqrt(r))) ==
          Approx(std::pow(r, 1.5)).epsilon(1e-5));
    const monitors::TimeScale capped(h, {.length = 1, .momentum = 1, .longest = 2});
    CHECK(capped.value(Eigen::Vector2d(r, 0), Eigen::Vector2d(0, 1 / std::sqrt(r))) ==
          Approx(1 / (std::pow(r, -1.5) + 0.5)).epsilon(1e-5));
  }
  // The same in units of one's own: lengths in 1e-11, momenta in 1e20.
  const auto in_units = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return 1e9 * Kepler().energy(q * 1e11, p * 1e-20); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        const Eigen::Vector2d x = q * 1e11, y = p * 1e-20;
        Eigen::Vector2d a, b;
        Kepler().gradient(x, y, a, b);
        dHdq = 1e20 * a, dHdp = 1e-11 * b;  // the same motion: {x, y} = 1e-9
      });
  const monitors::TimeScale one(h, {.longest = 5.0});
  const monitors::TimeScale other(in_units, {.length = 1e-11, .momentum = 1e20, .longest = 5.0});
  const Eigen::Vector2d q(0.3, -0.2), p(0.5, 1.9);
  CHECK(other.value(q * 1e-11, p * 1e20) == Approx(one.value(q, p)).epsilon(1e-5));
  CHECK(one.gradients() == 2);
  CHECK_THROWS_AS(monitors::TimeScale(h, {.length = 0.0}), std::invalid_argument);

  // An orbit of e = 0.9: a few hundred steps each, and no drift of the energy.
  PhasePoint<double, 2> z({0.1, 0}, {0, std::sqrt(19.0)});
  ReversibleSteps stepper(Semiexplicit(h, schemes::low_defect8_s20()),
                          monitors::TimeScale(h, {.momentum = 4.0, .longest = 3.0}));
  Invariants invariants(h);
  const IntegrationReport run =
      integrate(stepper, z, {.dt = 0.25, .t_end = 200 * std::acos(-1.0)}, invariants);
  CHECK(run.ok());
  CHECK(run.steps < 100 * 100);
  CHECK(invariants["energy"].worst < 1e-7);
}

TEST_CASE("The time scale of a driven system is known at late times, too", "[reversible steps]") {
  const Autonomous k(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (p[0] * p[0] + q[0] * q[0]) / 2 + q[0] * q[0] * q[0] * q[0] / 4 - 0.5 * q[0] * cos(3 * t);
  }));
  for (const double t0 : {0.0, 1e9}) {
    CAPTURE(t0);
    ReversibleSteps stepper(Semiexplicit(k, schemes::low_defect6_s13()), monitors::TimeScale(k));
    auto z = k.extended(PhasePoint<double, 1>(0.7, 0.2), t0);
    CHECK(integrate(stepper, z, {.dt = 0.003, .t0 = t0, .t_end = t0 + 20}).ok());
  }
}

TEST_CASE("The ready monitor functions have the values and gradients that they say", "[reversible steps]") {
  const Eigen::Vector4d q(0.3, -0.4, 1.2, 0.5), p(0.1, 0.2, -0.3, 0.7);
  const double r = std::hypot(0.9, 0.9);
  CHECK(monitors::ClosestPair{.dimensions = 2, .power = 1.5}.value(q, p) == Approx(std::pow(r, 1.5)));
  CHECK(monitors::Distance{}.value(q, p) == Approx(std::pow(q.norm(), 1.5)));
  const Eigen::Vector4d centre(1, 0, 0, 2);
  const monitors::DistanceFrom from(centre, 2);
  CHECK(from.value(q, p) == Approx((q - centre).squaredNorm()));
  const Kepler h;
  CHECK(monitors::FieldSize(h).value(Eigen::Vector2d(3, 4), Eigen::Vector2d(0, 1)) ==
        Approx(1 / std::hypot(1.0 / 25, 1.0)));
  // Of a driven system without dt/ds = 1 and the work.
  const Autonomous driven(from_energy<1>([](const auto& t, const auto& at, const auto& momentum) {
    return (momentum[0] * momentum[0] + at[0] * at[0]) / 2 + 5.0 * t;
  }));
  CHECK(monitors::FieldSize(driven).value(Eigen::Vector2d(3e-3, 2), Eigen::Vector2d(4e-3, 1)) == Approx(200));

  const auto slopes_match = [&](const auto& g) {
    Eigen::Matrix<double, 6, 1> at, slope, shifted;
    at << 0.3, -0.4, 1.2, 0.5, -0.2, 0.9;
    const double value = g(at, slope);
    CHECK(value == Approx(g.value(at, at)));
    for (Eigen::Index i = 0; i < 6; ++i) {
      shifted = at;
      shifted[i] += 1e-6;
      const double above = g.value(shifted, at);
      shifted[i] -= 2e-6;
      CHECK(slope[i] == Approx((above - g.value(shifted, at)) / 2e-6).epsilon(1e-6).margin(1e-8));
    }
  };
  slopes_match(monitors::ClosestPair{.dimensions = 3, .power = 1.5});
  slopes_match(monitors::ClosestPair{.dimensions = 2, .power = 1});
  slopes_match(monitors::DistanceFrom(Eigen::Matrix<double, 6, 1>(Eigen::Matrix<double, 6, 1>::Ones()), 1.5));
  CHECK(refuses([&] { monitors::ClosestPair{.dimensions = 3}.value(q, p); }, "4 coordinates"));
}

TEST_CASE("Two of three bodies that meet closely pass under reversible steps by the closest pair",
          "[reversible steps]") {
  // Three bodies of mass 1 at rest would collide in pairs; a little angular momentum keeps them apart.
  const auto h = from_energy<6>([](const auto& q, const auto& p) {
    auto sum = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3] + p[4] * p[4] + p[5] * p[5]) / 2;
    using std::sqrt;
    for (int j = 2; j < 6; j += 2)
      for (int i = 0; i < j; i += 2) {
        const auto x = q[i] - q[j], y = q[i + 1] - q[j + 1];
        sum = sum - 1 / sqrt(x * x + y * y);
      }
    return sum;
  });
  PhasePoint<double, 6> z({0, 0, 1, 0, 5, 0}, {0, -0.1, 0, 0.1, 0, 0.3});
  Invariants invariants(h);
  double closest = 1, farthest = 0;
  ReversibleSteps stepper(Semiexplicit(h, schemes::low_defect8_s20()),
                          monitors::ClosestPair{.dimensions = 2});
  integrate(stepper, z, {.dt = 0.1, .t_end = 5}, invariants,
            [&](double, const auto&, const IntegrationReport& report) {
              if (report.taken == 0) return;
              closest = std::min(closest, report.taken);
              farthest = std::max(farthest, report.taken);
            });
  CHECK(farthest / closest > 100);
  CHECK(invariants["energy"].worst < 1e-8);
}

TEST_CASE("Vortices and the vector field serve as monitors of reversible steps", "[reversible steps]") {
  const systems::PointVortices<double, 3> h({2, 2, -1});
  auto z = h.phase_point({-1, 1, 1.0003}, {0, 0, std::sqrt(2.0)});
  const auto start = z;
  Invariants invariants(h);
  ReversibleSteps by_distance(Semiexplicit(h, schemes::low_defect8_s20()), monitors::VortexDistances(h));
  integrate(by_distance, z, {.dt = 0.2, .steps = 900}, invariants);
  CHECK(invariants["energy"].worst < 1e-9);
  z = start;
  Invariants again(h);
  ReversibleSteps by_field(Semiexplicit(h, schemes::low_defect8_s20()), monitors::FieldSize(h));
  const auto report = integrate(by_field, z, {.dt = 0.02, .steps = 100}, again);
  CHECK(again["energy"].worst < 1e-9);
  Semiexplicit plain(h, schemes::low_defect8_s20());
  z = start;
  const auto one = plain.step(z, 1e-6);
  CHECK(report.gradients >= 100 * (one.gradients + 1));  // its own calls are counted
}

TEST_CASE("A run of reversible steps is not resumed with a copy of the stepper that came back",
          "[reversible steps]") {
  const Folder folder;
  const IntegrationOptions<double> options{.dt = 0.05, .t_end = 20.0};
  const auto make = [] {
    return ReversibleSteps(GaussLegendre(Kepler(), {.stages = 4}), monitors::Distance{});
  };
  const Point start = kepler_orbit(0.9, 1);
  const auto stop = [](double, const auto&, const IntegrationReport& run) { return run.steps < 60; };
  auto z = start;
  auto stepper = make();
  Checkpoints saved(folder.path / "run.checkpoint", {.every = 50}, stepper, options);
  integrate(stepper, z, options, saved, stop);
  const auto resumed = [&](auto& run, auto& at) {
    Checkpoints again(folder.path / "run.checkpoint", {.every = 50}, run, options);
    auto gone_on = options;
    gone_on.done = again.resume(at);
    CHECK(gone_on.done.steps == 50);
    CHECK(gone_on.done.t == run.time());
    return gone_on;
  };
  auto copy = make(), right = make();
  auto y = start;
  const auto gone_on = resumed(copy, y);
  CHECK(refuses([&] { integrate(right, y, gone_on); }, "this stepper did not make the earlier part"));
  Checkpoints within(folder.path / "other.checkpoint", {.every = 50}, copy, options);
  CHECK(refuses([&] { integrate(right, y, options, every(10, within)); }, "save another stepper"));
  CHECK(integrate(copy, y, gone_on).t == 20);
}

TEST_CASE("Monitor functions of a system of another size are refused", "[reversible steps]") {
  const systems::PointVortices<double> four(Eigen::VectorXd::Ones(4)), two(Eigen::VectorXd::Ones(2));
  const Eigen::Vector4d x(0, 1, 0, 1), y(0, 0, 1, 1.3);
  auto z = four.phase_point(x, y);
  const auto refused = [&](auto stepper, auto& state) {
    return refuses([&] { integrate(stepper, state, {.dt = 0.1, .steps = 1}); },
                   "the state has 4 degrees of freedom and the");
  };
  const Semiexplicit semiexplicit(four);
  CHECK(refused(ReversibleSteps(semiexplicit, monitors::VortexDistances(two)), z));
  CHECK(refused(ReversibleSteps(semiexplicit, monitors::FieldSize(two)), z));
  CHECK(refused(ReversibleSteps(semiexplicit, monitors::TimeScale(two)), z));
  const TimeTransformed transformed(four, monitors::VortexDistances(two), four.energy(z.q(), z.p()));
  CHECK(refuses([&] { transformed.extended(z, 0.0); }, "the state has 4 degrees of freedom and the"));
}

TEST_CASE("A run that comes to the next number behind leaves the steps that follow as they are",
          "[reversible steps]") {
  const auto run_to = [](std::initializer_list<double> times) {
    ReversibleSteps stepper{Semiexplicit(Kepler()), free_fall};
    Point z = kepler_orbit(0.9, pi);
    double t0 = 0;
    for (const double t : times) {
      integrate(stepper, z, {.dt = 0.05, .t0 = t0, .t_end = t});
      t0 = t;
    }
    return Kepler().energy(z.q(), z.p()) / -0.5 - 1;
  };
  double worst = 0, worst_without = 0;
  for (double t = 0.3; t < 6; t += 0.3) {
    worst = std::max(worst, std::abs(run_to({t, std::nextafter(t, 10.0), 20.0})));
    worst_without = std::max(worst_without, std::abs(run_to({t, 20.0})));
  }
  CHECK(worst < 1.1 * worst_without);
}

TEST_CASE("A run by steps has come to the time that it reports", "[reversible steps]") {
  for (int n = 1; n < 40; ++n) {
    ReversibleSteps stepper{Semiexplicit(Kepler()), free_fall};
    Point z = kepler_orbit(0.9, pi);
    const auto first = integrate(stepper, z, {.dt = 0.05, .steps = n});
    CHECK(stepper.reached(first.t));
    CHECK(integrate(stepper, z, {.dt = 0.05, .t_end = first.t, .done = first}).steps == n);
  }
}

TEST_CASE("Reversible steps that were moved from say so, whatever their monitor keeps",
          "[reversible steps]") {
  const KeplerOf<double, Eigen::Dynamic> h;
  ReversibleSteps from(GaussLegendre(h, {.stages = 2}), monitors::FieldSize(h));
  PhasePoint<double, Eigen::Dynamic> z(2);
  z.vector() = kepler_orbit(0.5, 1).vector();
  ReversibleSteps to(std::move(from));
  CHECK(from.step(z, 0.1).status == Status::invalid_stepper);
  CHECK(to.step(z, 0.1).ok());
}

TEST_CASE("Monitor functions of dynamic size work on where they were moved from", "[reversible steps]") {
  const KeplerOf<double, Eigen::Dynamic> h;
  const Eigen::VectorXd q = Eigen::Vector2d(3, 4), p = Eigen::Vector2d(0, 1);
  const auto check = [&](auto monitor) {
    const double value = monitor.value(q, p);
    const auto moved = std::move(monitor);
    CHECK(moved.value(q, p) == value);
    CHECK(monitor.value(q, p) == value);
  };
  check(monitors::FieldSize(h));
  check(monitors::TimeScale(h));
}

TEST_CASE("A run of more steps than anyone can wait for comes back", "[reversible steps]") {
  const auto run = [](double dt, auto monitor) {
    ReversibleSteps stepper{Semiexplicit(systems::Product<double>(), schemes::strang()), monitor};
    PhasePoint<double, 1> z(-3, 0);
    integrate(stepper, z, {.dt = dt, .t_end = 1});
  };
  CHECK(refuses([&] { run(1e-300, [](const auto&, const auto&) { return 1.0; }); },
                "more than 9e18 of these away"));
  CHECK(refuses([&] { run(0.1, [](const auto&, const auto&) { return 1e-30; }); },
                "more than 9e18 of these away"));
}

TEST_CASE("A run whose orbit runs away before its end comes back", "[reversible_steps]") {
  // p = q²/√2 from q = p√2 = 1 on: q = 1/(1 - t/√2) has gone to infinity at t = √2. Steps of ds = dt (1 +
  // q²).
  const auto h = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - std::pow(q[0], 4) / 4; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = -std::pow(q[0], 3);
        dHdp[0] = p[0];
      });
  PhasePoint<double, 1> z(1, std::sqrt(0.5));
  ReversibleSteps stepper(Semiexplicit(h, schemes::strang<double>()),
                          [](const auto& q, const auto&) { return 1 / (1 + q[0] * q[0]); });
  const auto report = integrate(stepper, z, {.dt = 0.1, .on_failure = OnFailure::stop, .t_end = 1e6});
  CHECK(report.status == Status::invalid_monitor);
  CHECK(report.steps > ReversibleSteps<Semiexplicit<decltype(h)>, monitors::Distance>::most_stale);
  CHECK(std::abs(report.t - std::sqrt(2.0)) < 1e-2);
  CHECK(z.q()[0] > 1000);
}

TEST_CASE("A gradient that throws while a step is cut into parts leaves the clock at the state's time",
          "[reversible_steps]") {
  std::int64_t calls = 0, when = -1;
  const auto h = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return p.squaredNorm() / 2 - 1 / q.norm(); },
      [&](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        if (++calls == when) throw std::runtime_error("interrupted");
        dHdq = q / std::pow(q.norm(), 3);
        dHdp = p;
      });
  int interrupted = 0;
  for (when = 2000; when < 20'000; when += 311) {
    calls = 0;
    PhasePoint<double, 2> z({0.1, 0}, {0, std::sqrt(19.0)});
    double last = 0;
    ReversibleSteps stepper(
        Semiexplicit(h, schemes::low_defect8_s20(), SimplifiedNewton{.max_iterations = 4}),
        monitors::Distance{});
    try {
      integrate(stepper, z, {.dt = 0.6, .subdivide = 6, .t_end = 50.0},
                [&](double t, const auto&) { last = t; });
    } catch (const std::runtime_error&) {
      ++interrupted;
    }
    if (calls == when) CHECK(stepper.time() == last);
  }
  CHECK(interrupted > 20);
}

}  // namespace test_reversible_steps
