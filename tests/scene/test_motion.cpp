#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_motion {

// Effects with a force of their own, against closed forms.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using std::numbers::pi;

struct Free {
  using Acts = OnMomentum<double, 1>;
  static constexpr const char* name = "free";
  double energy(const auto& p) const { return p[0] * p[0] / 2; }
  void add_gradient(const auto& p, auto& dHdp) const { dHdp[0] += p[0]; }
};

struct Thrust {
  using Acts = OnMotion<double, 1>;
  static constexpr const char* name = "thrust";
  void add_force(const auto&, const auto&, auto& force) const { force[0] += 0.1; }
};

struct Spring {  // |q|²/2
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "spring";
  double energy(const auto& q) const { return (q[0] * q[0] + q[1] * q[1]) / 2; }
  void add_gradient(const auto& q, auto& dHdq) const {
    dHdq[0] += q[0];
    dHdq[1] += q[1];
  }
};

struct Weight {  // g y
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "weight";
  double g = 9.81;
  double energy(const auto& q) const { return g * q[1]; }
  void add_gradient(const auto&, auto& dHdq) const { dHdq[1] += g; }
};

using Kinetic = orbits::Kinetic<double, 2>;
using Drag = orbits::Drag<double, 2>;

/// x'' = -x - 2γx' from x = 1 at rest.
double damped(double gamma, double t) {
  const double w = std::sqrt(1 - gamma * gamma);
  return std::exp(-gamma * t) * (std::cos(w * t) + gamma / w * std::sin(w * t));
}

}  // namespace

TEST_CASE("a damped oscillator is integrated to the full order of the scheme, and the books close") {
  const double gamma = 0.1;
  const Scene scene(Kinetic{}, Spring{}, Drag{.linear = 2 * gamma});
  static_assert(!decltype(scene)::separable && !decltype(scene)::symplectic);
  for (const auto& scheme : {schemes::low_defect6_s13<double>(), schemes::yoshida6<double>(),
                             schemes::blanes_moan4<double>(), schemes::strang<double>()}) {
    CAPTURE(scheme.name);
    double error[2], open[2];
    for (int k = 0; k < 2; ++k) {
      auto stepper = stepper_for(scene, scheme);
      PhasePoint<double, 2> z({1, 0.5}, {0, 0});
      Books books(scene);
      integrate(stepper, z, {.dt = 0.4 / (k + 1), .t_end = 20}, books);
      error[k] = std::abs(z.q()[0] - damped(gamma, 20)) + std::abs(z.q()[1] - damped(gamma, 20) / 2);
      open[k] = std::abs(books.difference());
      CHECK(books.energy_at_start() == 0.625);
      CHECK(books.energy_now() < 0.02);
      CHECK(books.work("drag") == Approx(-0.625).epsilon(0.05));
    }
    const double order = std::log2(error[0] / error[1]);
    CHECK(order > scheme.order - 0.4);
    CHECK(open[1] < 0.5 * open[0]);
  }
}

TEST_CASE("a projectile with drag flies as its closed form says") {
  const double k = 0.3, g = 9.81, t = 2;
  const Scene linear(Kinetic{}, Weight{g}, Drag{.linear = k});
  auto stepper = stepper_for(linear);
  PhasePoint<double, 2> z({0, 0}, {30, 20});
  Books books(linear);
  integrate(stepper, z, {.dt = 0.02, .t_end = t}, books);
  const double left = (1 - std::exp(-k * t)) / k;
  CHECK(z.q()[0] == Approx(30 * left).epsilon(1e-13));
  CHECK(z.q()[1] == Approx((20 + g / k) * left - g / k * t).epsilon(1e-12));
  // The work is -k∫v².
  const double vx2 = 900 * (1 - std::exp(-2 * k * t)) / (2 * k), c = 20 + g / k,
               vy2 =
                   c * c * (1 - std::exp(-2 * k * t)) / (2 * k) - 2 * c * g / k * left + g * g / (k * k) * t;
  CHECK(books.work("drag") == Approx(-k * (vx2 + vy2)).epsilon(1e-12));
  CHECK(std::abs(books.difference()) < 1e-10 * books.energy_at_start());

  // Falling from rest with quadratic drag: v = V tanh(g t/V), V² = g/b.
  const double b = 0.01, fastest = std::sqrt(g / b);
  const Scene quadratic(Kinetic{}, Weight{g}, Drag{.quadratic = b});
  auto falling = stepper_for(quadratic);
  PhasePoint<double, 2> y({0, 0}, {0, -1e-30});
  integrate(falling, y, {.dt = 0.02, .t_end = 5});
  CHECK(y.p()[1] == Approx(-fastest * std::tanh(g * 5 / fastest)).epsilon(1e-12));
  CHECK(y.q()[1] == Approx(-fastest * fastest / g * std::log(std::cosh(g * 5 / fastest))).epsilon(1e-12));
}

TEST_CASE("a spiral through an atmosphere loses what the drag takes") {
  // A circle in thin air: da/dt = -2 b ρ a v with v² = GM/a; King-Hele, Theory of Satellite Orbits,
  // section 4.
  const double b = 1e-6, height = 0.05;
  const Scene scene(Kinetic{}, orbits::Attraction<double, 2>{},
                    Drag{.quadratic = b, .height = height, .radius = 1});
  auto exact = stepper_for(scene, exactly<Kinetic, orbits::Attraction<double, 2>>());
  CHECK(says(explain(exact), "doubled: drag"));
  CHECK(says(explain(exact), "not symplectic: drag adds a force of its own"));
  CHECK(says(explain(stepper_for(scene)), "not symplectic: drag adds a force of its own"));
  PhasePoint<double, 2> z({1, 0}, {0, 1});
  Books books(scene);
  const double t = 2 * pi * 50;
  integrate(exact, z, {.dt = 0.1, .t_end = t}, books);
  const double a = -1 / (2 * scene.energy(z.q(), z.p()));
  // exp((a - 1)/h) falls linearly with the slope 2b/h, but for a second order in 1 - a.
  const double expected = 1 + height * std::log(1 - 2 * b / height * t);
  CHECK(1 - a == Approx(1 - expected).epsilon(2e-3));
  CHECK(std::abs(books.difference()) < 1e-6 * std::abs(books.work()));
}

TEST_CASE("A scale height below 0 or NaN is not taken for none", "[motion]") {
  const auto force = [](double height) {
    Eigen::Vector2d sum(0, 0);
    Drag{.linear = 2, .height = height, .radius = 1}.add_force(Eigen::Vector2d(1.5, 0), Eigen::Vector2d(0, 1),
                                                               sum);
    return sum[1];
  };
  CHECK(force(0) == -2);
  CHECK(force(-0.5) == Approx(-2 * std::exp(1.0)).epsilon(1e-14));
  CHECK(std::isnan(force(std::nan(""))));
}

TEST_CASE("the loss by gravitational waves is that of Peters") {
  using orbits::Attraction;
  const double gm = 1, c = 40, nu = 0.2;
  for (const double e : {0.0, 0.3, 0.617}) {
    CAPTURE(e);
    const Scene scene(Kinetic{}, Attraction<double, 2>{}, orbits::RadiationReaction<double, 2>{gm, c, nu});
    auto stepper = stepper_for(scene, exactly<Kinetic, Attraction<double, 2>>());
    PhasePoint<double, 2> z({1 + e, 0}, {0, std::sqrt((1 - e) / (1 + e))});  // a = 1, from the apoapsis
    const double t = 2 * pi * 10;
    integrate(stepper, z, {.dt = 2 * pi / 400.3, .t_end = t});
    const double energy = z.p().squaredNorm() / 2 - gm / z.q().norm(), a = -gm / (2 * energy);
    const double l = z.q()[0] * z.p()[1] - z.q()[1] * z.p()[0], e2 = 1 + 2 * energy * l * l;
    const double f = 1 - e * e, k = nu * std::pow(c, -5);
    const double da =
        -64.0 / 5 * k * std::pow(f, -3.5) * (1 + 73.0 / 24 * e * e + 37.0 / 96 * std::pow(e, 4));
    const double de = -304.0 / 15 * e * k * std::pow(f, -2.5) * (1 + 121.0 / 304 * e * e);
    CHECK((a - 1) / t == Approx(da).epsilon(1e-3));
    if (e > 0) CHECK((std::sqrt(e2) - e) / t == Approx(de).epsilon(1e-3));
  }
}

TEST_CASE("books tell of each effect, at run time, too, and of steps of any length") {
  const RuntimeScene<double, 2> scene{Kinetic{}, Spring{}, Drag{.linear = 0.2},
                                      orbits::RadiationReaction<double, 2>{1, 20, 0.25}};
  CHECK(!scene.is_symplectic());
  CHECK(!scene.is_separable());
  CHECK(scene.with_only({"kinetic", "spring"}).is_symplectic());
  Books books(scene);
  CHECK(books.fresh());
  CHECK(books.names() == std::vector<std::string>{"drag", "2.5pn"});
  PhasePoint<double, 2> z({1, 0.5}, {0, 1});
  with_stepper_for(scene, [&](auto& stepper) {
    IntegrationReport run = integrate(stepper, z, {.dt = 0.05, .steps = 13}, books);
    for (int i = 0; i < 40; ++i)  // goes on with other steps
      run = integrate(stepper, z, {.dt = i % 2 == 0 ? 0.03 : 0.06, .steps = 3, .t0 = run.t}, books);
    CHECK(std::abs(books.difference()) < 1e-9);
    CHECK(books.work() == books.work("drag") + books.work("2.5pn"));
    CHECK(std::abs(books.work("2.5pn")) < 1e-3);
    // What a checkpoint keeps makes the same books.
    CheckpointMemory saved;
    books.visit_memory(saved);
    CheckpointMemory kept(saved.bytes(), CheckpointMemory::Read::restore);
    Books again(scene);
    again.visit_memory(kept);
    CHECK(!again.fresh());
    CHECK(again.work("drag") == books.work("drag"));
    CHECK(again.difference() == books.difference());
    // Backwards the work is given back.
    integrate(stepper, z, {.dt = -0.05, .t0 = run.t, .t_end = 0}, books);
  });
  CHECK((z.vector() - PhasePoint<double, 2>({1, 0.5}, {0, 1}).vector()).norm() < 1e-8);
  CHECK(std::abs(books.work()) < 1e-8);
  std::ostringstream table;
  table << books;
  CHECK(says(table.str(), "work of drag"));
  CHECK(says(table.str(), "difference"));
  CHECK(refuses([&] { books.work("darg"); }, "drag"));
}

TEST_CASE("Effects of a scene with the same name are numbered in books and audits", "[motion]") {
  const Scene scene(Kinetic{}, Spring{}, Drag{.linear = 0.1}, Drag{.quadratic = 0.2}, Drag{.linear = 0.3});
  const std::vector<std::string> drags{"drag", "drag 2", "drag 3"};
  const PhasePoint<double, 2> start({1, 0.5}, {0, 1});
  Books books(scene);
  CHECK(books.names() == drags);
  auto z = start;
  auto stepper = stepper_for(scene);
  integrate(stepper, z, {.dt = 0.02, .steps = 50}, books);
  CHECK(std::abs(books.difference()) < 1e-9);
  CHECK(books.work("drag 3") == Approx(3 * books.work("drag")));
  CHECK(refuses([&] { books.work("drag 4"); }, "drag 2"));
  const Audit found = audit(scene, start, 1, {.dt = 0.1, .samples = 5});
  for (std::size_t i = 0; i < drags.size(); ++i) CHECK(found.rows[2 + i].name == drags[i]);
  CHECK(refuses(
      [] {
        (RuntimeScene<double, 2>{Kinetic{}, Drag{.linear = 0.1}, Drag{.linear = 0.2}});
      },
      "two effects are called drag; give one a member name() of its own"));
}

TEST_CASE("What needs a Hamiltonian refuses a scene with a force of its own by name", "[motion]") {
  const Scene damped(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{},
                     effects::orbits::Drag<double, 2>{.linear = 0.01});
  const RuntimeScene<double, 2> at_run_time(damped);
  const PhasePoint<double, 2> z({1, 0}, {0, 1});
  const auto stepper = Semiexplicit(damped, schemes::low_defect6_s13<double>());
  CHECK(refuses([&] { LyapunovExponents(stepper, 1); }, "a force of its own"));
  CHECK(refuses([&] { TangentMap(damped, schemes::strang<double>()); }, "a force of its own"));
  CHECK(refuses([&] { LyapunovExponents(Semiexplicit(at_run_time, schemes::strang<double>()), 1); },
                "a force of its own"));
  CHECK(refuses(
      [&] {
        TimeTransformed(damped, monitors::DistanceFrom<double, 2>({0, 0}), -0.5);
      },
      "take ReversibleSteps"));
  CHECK(refuses([&] { cost_of_accuracy(damped, z, 10); }, "with_error_estimate()"));
}

TEST_CASE("Books of a run that turns round, or whose state an event changes, close as well", "[motion]") {
  const Scene damped(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Drag<double, 2>{.linear = 0.1});
  Semiexplicit stepper(damped, schemes::low_defect8_s20<double>());
  PhasePoint<double, 2> z({1, 0}, {1, 0});
  Books books(damped);
  const auto there = integrate(stepper, z, {.dt = 0.1, .steps = 200}, books);
  const auto back = integrate(stepper, z, {.dt = -0.1, .steps = 50, .t0 = there.t}, books);
  integrate(stepper, z, {.dt = 0.1, .steps = 500, .t0 = back.t}, books);
  CHECK(std::abs(books.difference()) < 1e-9);

  Books kicked(damped);
  z = PhasePoint<double, 2>({0, 0}, {1, 0});
  auto watch = events(
      damped, on_event([](const auto& q, const auto&) { return q[0] - 3; },
                       [](double, PhasePoint<double, 2>& at) { at.p()[0] += 3; }, CrossingDirection::rising));
  integrate(stepper, z, {.dt = 0.1, .t_end = 20}, kicked, watch);
  REQUIRE(watch.count() == 1);
  // p falls from 1 by 0.1 a length of way: 0.7 where the kick makes 3.7 of it.
  CHECK(kicked.by_events() == Approx((3.7 * 3.7 - 0.7 * 0.7) / 2).epsilon(1e-9));
  CHECK(std::abs(kicked.difference()) < 1e-9);
}

TEST_CASE("Books of many short runs are those of one long run, whatever the times they start at",
          "[motion]") {
  const Scene scene(Kinetic{}, Spring{}, Drag{.linear = 0.03});
  const double dt = 0.1;
  const int steps = 1000;
  auto stepper = stepper_for(scene);
  const PhasePoint<double, 2> z0({1, 0}, {0, 0.5});
  PhasePoint<double, 2> z = z0;
  Books whole(scene);
  integrate(stepper, z, {.dt = dt, .steps = steps}, whole);
  REQUIRE(std::abs(whole.difference()) < 1e-10);

  Books rounded(scene), from_zero(scene);  // i dt is not the sum of i steps
  z = z0;
  for (int i = 0; i < steps; ++i) integrate(stepper, z, {.dt = dt, .steps = 1, .t0 = i * dt}, rounded);
  CHECK(std::abs(rounded.difference()) < 1e-10);
  z = z0;
  for (int i = 0; i < 10; ++i) integrate(stepper, z, {.dt = dt, .steps = steps / 10}, from_zero);
  CHECK(std::abs(from_zero.difference()) < 1e-7);  // every run begins a new integral
  CHECK(from_zero.by_events() == 0);

  // What is done to the state between two runs is no work, and loses none.
  Books kicked(scene);
  z = z0;
  const auto first = integrate(stepper, z, {.dt = dt, .steps = 200}, kicked);
  const double before = kicked.work(), energy = scene.energy(z.q(), z.p());
  z.p()[0] += 2;
  integrate(stepper, z, {.dt = dt, .steps = 0, .t0 = first.t}, kicked);
  CHECK(kicked.work() == Approx(before).epsilon(1e-14));
  CHECK(kicked.by_events() == Approx(scene.energy(z.q(), z.p()) - energy).epsilon(1e-14));
  integrate(stepper, z, {.dt = dt, .steps = 200, .t0 = first.t}, kicked);
  CHECK(std::abs(kicked.difference()) < 1e-7);
}

TEST_CASE("Books close whatever the steps from run to run differ by", "[motion]") {
  const Scene scene(Kinetic{}, Spring{}, Drag{.linear = 0.1});
  const auto open = [&](const std::vector<std::pair<double, double>>& runs) {  // dt and length of each
    auto stepper = stepper_for(scene);
    PhasePoint<double, 2> z({1, 0.5}, {0.2, 0.7});
    Books books(scene);
    double t = 0;
    for (const auto& [dt, length] : runs) {
      integrate(stepper, z, {.dt = dt, .t0 = t, .t_end = t + length}, books);
      t += length;
    }
    return std::abs(books.difference());
  };
  const double even = open({{0.05, 6}});
  CHECK(even < 1e-8);
  // To times that are one but for rounding, as 3 * 0.1 and 0.3.
  std::vector<std::pair<double, double>> twice;
  for (int i = 0; i < 60; ++i) {
    twice.emplace_back(0.05, 0.1);
    twice.emplace_back(0.05, 1e-15);
  }
  CHECK(open(twice) < 10 * even);
  for (const double finer : {3.0, 10.0, 100.0, 6000.0, 1e6})
    for (const int then : {1, 2, 3, 5, 20}) {
      CAPTURE(finer, then);
      const double dt = 0.05, most = finer < 32 ? 1e-8 : 1e-5;  // one step by the trapezoidal rule
      CHECK(open({{dt / finer, 40 * dt / finer}, {dt, then * dt}}) < most);
      CHECK(open({{dt, 10 * dt}, {dt / finer, 40 * dt / finer}, {dt, then * dt}}) < most);
    }
}

TEST_CASE("Books in float at late times are those at early ones", "[motion]") {
  const Scene scene(effects::orbits::Kinetic<float, 2>{}, effects::orbits::Drag<float, 2>{.linear = 0.25f});
  double work[2];
  for (const bool late : {false, true}) {
    auto stepper = stepper_for(scene);
    PhasePoint<float, 2> z({0, 0}, {1, 0.5f});
    Books books(scene);
    // Times are 0.0078 apart there.
    integrate(stepper, z, {.dt = 0.01f, .steps = 400, .t0 = late ? 1e5f : 0.f}, books);
    work[late ? 1 : 0] = static_cast<double>(books.work());
  }
  CHECK(work[1] == Approx(work[0]).epsilon(1e-6));
  CHECK(work[0] == Approx(1.25 / 2 * std::expm1(-2 * 0.25 * 4)).epsilon(1e-5));
}

TEST_CASE("Books beside bounces in float at late times are those at early ones", "[motion]") {
  using Point = PhasePoint<float, 2>;
  const Scene scene(effects::orbits::Kinetic<float, 2>{}, effects::orbits::Drag<float, 2>{.linear = 0.25f});
  for (const float t0 : {0.f, 1e4f, 4e5f}) {
    CAPTURE(t0);
    auto stepper = stepper_for(scene);
    Point z({0.1f, 0}, {1, 0.5f});
    Books books(scene);
    const auto bounce = [](float, Point& at) { at.p()[0] = -at.p()[0]; };
    auto walls = events(
        scene,
        on_event([](const auto& q, const auto&) { return q[0] - 0.3f; }, bounce, CrossingDirection::rising),
        on_event([](const auto& q, const auto&) { return q[0]; }, bounce, CrossingDirection::falling));
    integrate(stepper, z, {.dt = 0.01f, .steps = 400, .t0 = t0}, walls, books);
    CHECK(walls.count() > 5);
    CHECK(static_cast<double>(books.work()) == Approx(1.25 / 2 * std::expm1(-2 * 0.25 * 4)).epsilon(1e-5));
    CHECK(books.by_events() == 0);
  }
}

TEST_CASE("Books keep the work done before an event that ends a step, or the run", "[motion]") {
  // Between two walls that cost nothing, with drag: p² decays as e^{-2kt}, also where every bounce falls on
  // the end of a step, as at a wall that is a whole number of steps away.
  const double k = 0.5;
  const Scene scene(Kinetic{}, Drag{.linear = k});
  auto stepper = stepper_for(scene);
  using Point = PhasePoint<double, 2>;
  const auto bounce = [](double, Point& at) { at.p()[0] = -at.p()[0]; };
  for (const double wall : {1.0, 0.5, 0.377})
    for (const double speed : {1.0, 3.0}) {
      CAPTURE(wall, speed);
      Books books(scene);
      double worst = 0;
      auto watch = events(
          scene,
          on_event([&](const auto& q, const auto&) { return q[0] - wall; }, bounce,
                   CrossingDirection::rising),
          on_event([](const auto& q, const auto&) { return q[0]; }, bounce, CrossingDirection::falling));
      Point z({0.1, 0}, {speed, 1});
      integrate(stepper, z, {.dt = 0.01, .steps = 500}, watch, books,
                [&](double, const Point&) { worst = std::max(worst, std::abs(books.difference())); });
      CHECK(watch.count() >= 1);
      CHECK(worst < 1e-6);  // just behind an event few values are there to integrate by
      CHECK(std::abs(books.difference()) < 1e-11);
      CHECK(books.work() == Approx((speed * speed + 1) / 2 * std::expm1(-2 * k * 5)).epsilon(1e-10));
    }
  // What lands stays there.
  Books books(scene);
  Point z({0, 0}, {1, 0});
  integrate(stepper, z, {.dt = 0.01, .t_end = 10},
            events(scene, on_event([](const auto& q, const auto&) { return q[0] - 1; },
                                   [](double, Point& at) {
                                     at.p().setZero();
                                     return false;
                                   })),
            books);
  CHECK(books.work() == Approx((0.5 * 0.5 - 1) / 2).epsilon(1e-10));  // p = 1 - k q
  CHECK(books.by_events() == Approx(-0.5 * 0.5 / 2).epsilon(1e-10));
  CHECK(std::abs(books.difference()) < 1e-12);
}

TEST_CASE("A state that is turned between two runs counts as changed, although it has the same energy",
          "[motion]") {
  const Scene scene(Free{}, Thrust{});
  auto stepper = stepper_for(scene);
  PhasePoint<double, 1> z(0, 1);
  Books books(scene);
  const auto run = integrate(stepper, z, {.dt = 0.1, .steps = 50}, books);
  z.p() = -z.p();
  integrate(stepper, z, {.dt = 0.1, .steps = 50, .t0 = run.t}, books);
  CHECK(std::abs(books.difference()) < 1e-12);
  CHECK(std::abs(books.work() - (z.p()[0] * z.p()[0] - 1) / 2) < 1e-12);
}

TEST_CASE("Books refuse the states of a scene of another size", "[motion]") {
  Books books(Scene(effects::lattice::OnSite<>{.sites = 3}, effects::lattice::Hopping<>{.sites = 3}));
  CHECK(refuses([&] { books(0.0, PhasePoint<double, Eigen::Dynamic>(4)); },
                "the state has 4 degrees of freedom and the scene 3"));
}

TEST_CASE("a checkpoint is not gone on with by the books of another scene") {
  const Folder folder;
  const auto scene = [](double k, double gm) {
    return Scene(Kinetic{}, orbits::Attraction<double, 2>{.gm = gm}, Drag{.linear = k});
  };
  const IntegrationOptions<double> options{.dt = 0.05, .steps = 20};
  const auto go = [&](const auto& kept, bool resumes) {
    auto stepper = stepper_for(scene(0.01, 1));
    Books books(kept);
    Checkpoints checkpoints(folder.path / "saved", {.every = 10}, stepper, options, books);
    PhasePoint<double, 2> z({1, 0}, {0, 1});
    auto run = options;
    if (resumes) run.done = checkpoints.resume(z);
    integrate(stepper, z, run, books, checkpoints);
  };
  go(scene(0.01, 1), false);
  CHECK(refuses([&] { go(scene(0.02, 1), true); }, "another scene"));
  CHECK(refuses([&] { go(scene(0.01, 1.1), true); }, "another scene"));
  go(scene(0.01, 1), true);
}

}  // namespace test_motion
