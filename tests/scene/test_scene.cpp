#include "catch.hpp"
#include "refusal.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>
#include <type_traits>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_scene {

// What a scene is, which stepper it gets, the choice at run time, and the audit.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using namespace semiexplicit::effects::orbits;
using Point = PhasePoint<double, 2>;

/// Effects that count how often they are asked.
template <class Kind>
struct Counting {
  using Acts = Kind;
  static constexpr const char* name = "counting";
  std::int64_t* calls;
  double energy(const auto& x) const { return (x[0] * x[0] + x[1] * x[1]) / 2; }
  void add_gradient(const auto& x, auto& dHdx) const {
    ++*calls;
    for (int i = 0; i < 2; ++i) dHdx[i] += x[i];
  }
};
using CountingPotential = Counting<OnPosition<double, 2>>;
using CountingKinetic = Counting<OnMomentum<double, 2>>;

struct NoEffect {};

struct Oscillator {
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "oscillator";
  double energy(const auto& q) const { return q.squaredNorm() / 2; }
  void add_gradient(const auto& q, auto& dHdq) const { dHdq += q; }
};

/// An effect with the types of its arguments spelled out and Eigen's arithmetic.
struct Spelled {
  using Acts = OnBoth<double, 2>;
  std::string name() const { return "spelled"; }
  double energy(const In<double, 2>& q, const In<double, 2>& p) const { return 3 * q.dot(p); }
  void add_gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                    Out<double, 2> dHdp) const {
    dHdq += 3 * p;
    dHdp += 3 * q;
  }
};

auto mercury() {
  const double gm = 39.47841760435743;  // 4π², au and years
  return Scene(Kinetic<double, 2>{}, Attraction<double, 2>{.gm = gm},
               PostNewtonian1<double, 2>{.gm = gm, .c = 63241.077},
               Oblateness<double, 2>{.gm = gm, .j2 = 2e-7, .radius = 0.00465047});
}

}  // namespace

TEST_CASE("The kind of an effect follows from what it acts on, and separability from the kinds", "[scene]") {
  static_assert(MomentumEffect<Kinetic<double, 2>> && !PositionEffect<Kinetic<double, 2>>);
  static_assert(PositionEffect<Attraction<double, 3>> && !MomentumEffect<Attraction<double, 3>>);
  static_assert(CoupledEffect<RotatingFrame<double, 2>> && !PositionEffect<RotatingFrame<double, 2>>);
  static_assert(EachEffect<lattice::Hopping<>> && !CoupledEffect<lattice::Hopping<>>);
  static_assert(!Effect<NoEffect>);

  using Plain = Scene<Kinetic<double, 2>, Attraction<double, 2>>;
  using Turning = Scene<Kinetic<double, 2>, Attraction<double, 2>, RotatingFrame<double, 2>>;
  static_assert(Hamiltonian<Plain> && HasEnergy<Plain> && SeparableHamiltonian<Plain> && Plain::separable);
  static_assert(Hamiltonian<Turning> && HasEnergy<Turning> && !SeparableHamiltonian<Turning>);
  static_assert(std::is_same_v<decltype(stepper_for(std::declval<Plain>())), ExplicitSplitting<Plain>>);
  static_assert(std::is_same_v<decltype(stepper_for(std::declval<Turning>())), Semiexplicit<Turning>>);
  static_assert(std::is_same_v<decltype(stepper_for(std::declval<Turning>(), schemes::strang(), Broyden{})),
                               Semiexplicit<Turning, Broyden>>);
  static_assert(!SeparableHamiltonian<systems::Product<double>>);
  SUCCEED();
}

TEST_CASE("A scene is the sum of its effects, in one gradient or in halves", "[scene]") {
  const Kinetic<double, 2> kinetic;
  const Attraction<double, 2> attraction{.gm = 1.2};
  const RotatingFrame<double, 2> frame{.omega = 0.7};
  const Scene scene(kinetic, attraction, frame);
  const Point z({0.7, -0.4}, {0.3, 1.1});
  Point sum, whole;
  sum.vector().setZero();
  Eigen::Ref<Eigen::Vector2d> by_q = sum.q(), by_p = sum.p();
  kinetic.add_gradient(z.p(), by_p);
  attraction.add_gradient(z.q(), by_q);
  const Point halves = sum;
  frame.add_gradient(z.q(), z.p(), by_q, by_p);
  whole.vector().setConstant(7);  // what is there is overwritten
  scene.gradient(z.q(), z.p(), whole.q(), whole.p());
  CHECK(whole.vector() == sum.vector());
  CHECK(scene.energy(z.q(), z.p()) ==
        kinetic.energy(z.p()) + attraction.energy(z.q()) + frame.energy(z.q(), z.p()));

  const Scene spelled(Spelled{}, kinetic);
  spelled.gradient(z.q(), z.p(), whole.q(), whole.p());
  CHECK(whole.q() == 3 * z.p());
  CHECK((whole.p() - 3 * z.q() - z.p()).norm() < 1e-15);
  CHECK(RuntimeScene(spelled).names()[0] == "spelled");

  const Scene plain(kinetic, attraction);
  whole.vector().setConstant(7);
  plain.position_gradient(z.q(), whole.q());
  plain.momentum_gradient(z.p(), whole.p());
  CHECK(whole.vector() == halves.vector());
}

TEST_CASE("A separable scene is not doubled: half of the calls, and fewer forces than that", "[scene]") {
  std::int64_t forces = 0, speeds = 0;
  const Scene scene(CountingKinetic{&speeds}, CountingPotential{&forces});
  const auto scheme = schemes::blanes_moan6();  // s = 10
  auto single = stepper_for(scene, scheme);
  Semiexplicit doubled(scene, scheme);
  Point z({1, 0}, {0, 0.5}), w = z;

  const auto report = integrate(single, z, {.dt = 0.1, .steps = 50});
  CHECK(forces == 50 * 10);
  CHECK(speeds == 50 * 11);
  CHECK(forces == 50 * single.position_gradients());
  CHECK(speeds == 50 * single.momentum_gradients());
  CHECK(report.gradients == 50 * 11);  // whole ones: 21 halves, rounded up
  forces = speeds = 0;
  const auto other = integrate(doubled, w, {.dt = 0.1, .steps = 50});
  CHECK(forces == 21 * other.evaluations);
  CHECK(speeds == forces);
  CHECK(other.evaluations >= 50);
  CHECK((z.vector() - w.vector()).norm() < 1e-8);
  CHECK(z.q()[0] == Approx(std::cos(5.0)).margin(1e-8));
}

TEST_CASE("Explicit splitting has the order of its scheme, goes back, and refuses what fails", "[scene]") {
  const Scene scene(Kinetic<double, 2>{}, Attraction<double, 2>{});
  const Point start({0.8, 0}, {0, 1.25});
  // The orbit closes after its period.
  const double energy = scene.energy(start.q(), start.p()),
               period = 2 * std::acos(-1.0) * std::pow(-2 * energy, -1.5);
  for (const char* name : {"strang", "blanes_moan4", "blanes_moan6", "kahan_li8"}) {
    CAPTURE(name);
    const auto scheme = schemes::by_name(name);
    auto stepper = stepper_for(scene, scheme);
    const auto error = [&](int steps) {
      Point z = start;
      integrate(stepper, z, {.dt = period / steps, .steps = steps});
      return (z.vector() - start.vector()).norm();
    };
    const int steps = scheme.order == 2 ? 400 : 60;
    CHECK(std::log2(error(steps) / error(2 * steps)) == Approx(scheme.order).margin(0.35));
  }

  auto stepper = stepper_for(scene);
  Point z = start;
  integrate(stepper, z, {.dt = 0.05, .steps = 100});
  CHECK((z.vector() - start.vector()).norm() > 0.1);
  integrate(stepper, z, {.dt = -0.05, .steps = 100});
  CHECK((z.vector() - start.vector()).norm() < 1e-13);

  CHECK(stepper.step(z, 0).status == Status::invalid_step);
  Point centre({0, 0}, {0, 0}), lost({std::nan(""), 0}, {0, 0});
  CHECK(stepper.step(centre, 0.1).status == Status::not_finite);
  CHECK(centre.vector().isZero());
  CHECK(stepper.step(lost, 0.1).status == Status::invalid_state);

  CHECK(refuses([&] { stepper_for(scene, schemes::low_defect6_s13()); },
                "order 6 with the projection only, and order 4"));
  CHECK(refuses([&] { stepper_for(scene, schemes::low_defect6_s13()); }, "blanes_moan6"));
  auto meant = schemes::low_defect6_s13();
  meant.order = 4;
  CHECK_NOTHROW(stepper_for(scene, meant));
}

TEST_CASE("Effects chosen at run time give the same orbit as the scene of them", "[scene]") {
  const Scene scene(Kinetic<double, 2>{}, Attraction<double, 2>{}, RotatingFrame<double, 2>{.omega = 0.3});
  const RuntimeScene all(scene);
  CHECK(all.names() == std::vector<std::string>{"kinetic", "attraction", "rotating_frame"});
  CHECK(all.effects()[1].about() == "Newton's attraction by a centre, -GM/r");
  CHECK(!all.is_separable());
  const auto plain = all.with_only({"attraction", "kinetic"});
  CHECK(plain.names() == std::vector<std::string>{"kinetic", "attraction"});
  CHECK(plain.is_separable());
  CHECK(all.without("rotating_frame").names() == plain.names());

  const auto orbit = [](auto& stepper) {
    Point z({1, 0}, {0, 1.1});
    const auto report = integrate(stepper, z, {.dt = 0.05, .steps = 100});
    CHECK(report.gradients > 0);
    return z.vector();
  };
  auto coupled = stepper_for(scene);
  auto separable = stepper_for(Scene(Kinetic<double, 2>{}, Attraction<double, 2>{}));
  CHECK(with_stepper_for(all, orbit) == orbit(coupled));
  CHECK(with_stepper_for(plain, orbit) == orbit(separable));
  CHECK(all.energy(Eigen::Vector2d(1, 0), Eigen::Vector2d(0, 1)) == Approx(-0.5 - 0.3));
}

TEST_CASE("An effect that is off is not called, an unknown one is refused with the nearest names",
          "[scene]") {
  std::int64_t calls = 0;
  const RuntimeScene<double, 2> all{Kinetic<double, 2>{}, Attraction<double, 2>{}, CountingPotential{&calls},
                                    RotatingFrame<double, 2>{}};
  auto stepper = stepper_for(all.without("counting"));
  Point z({1, 0}, {0, 1});
  integrate(stepper, z, {.dt = 0.1, .steps = 10});
  CHECK(calls == 0);

  CHECK(refuses(
      [&] {
        all.with_only({"kinetic", "rotating-frame"});
      },
      "no effect is called 'rotating-frame'; the nearest names are rotating_frame, "));
  CHECK(refuses([&] { all.without("Kinetics"); }, "nearest names are kinetic,"));
  CHECK(refuses([&] { all.with_only({}); }, "no effect is on"));
  const effects::lattice::OnSite<> nowhere{.sites = -1, .strength = 1};
  CHECK(refuses([&] { RuntimeScene<double, Eigen::Dynamic>{nowhere}; }, "-1 degrees of freedom"));
  CHECK(refuses(
      [&] {
        (RuntimeScene<double, 2>{Kinetic<double, 2>{}, Kinetic<double, 2>{}});
      },
      "two effects are called kinetic"));
  CHECK(refuses([&] { (SeparableRuntimeScene<double, 2>(all)); }, "rotating_frame couples q and p"));
  CHECK(nearest_names("au", {"km", "AU", "m"}, 1) == std::vector<std::string>{"AU"});
}

TEST_CASE("An effect that was moved from is still there, and one whose name is nullptr is refused",
          "[scene]") {
  AnyEffect<double, 2> kinetic(Kinetic<double, 2>{});
  const AnyEffect<double, 2> moved(std::move(kinetic));
  CHECK(RuntimeScene<double, 2>{kinetic, Attraction<double, 2>{}}.names() ==
        std::vector<std::string>{"kinetic", "attraction"});
  AnyEffect<double, 2> assigned(Attraction<double, 2>{});
  assigned = std::move(kinetic);
  CHECK(RuntimeScene<double, 2>{kinetic}.energy(Eigen::Vector2d(0, 0), Eigen::Vector2d(0, 2)) == 2);

  struct Nameless : Oscillator {
    const char* name = nullptr;
  };
  CHECK(refuses([] { AnyEffect<double, 2>(Nameless{}); }, "the name of an effect is nullptr; give it one"));
}

TEST_CASE("Mercury over a century: what the scene calls for depends on the accuracy", "[scene][long]") {
  const double gm = 39.47841760435743, a = 0.38709893, e = 0.20563069;
  const Point z({a * (1 - e), 0}, {0, std::sqrt(gm / a * (1 + e) / (1 - e))});
  const Audit report = audit(mercury(), z, 100, {.dt = 0.0015});
  CAPTURE(report.noise);
  CHECK(report.noise < 1e-8);
  CHECK(report.called_for(1e-6) == std::vector<std::string>{"kinetic", "attraction", "1pn"});
  CHECK(report.called_for(1e-8) == std::vector<std::string>{"kinetic", "attraction", "1pn", "j2"});
  CHECK(report.called_for(0.01) == std::vector<std::string>{"kinetic", "attraction"});
  CHECK(report.undecided(1e-6).empty());

  const AuditRow &relativity = report.rows[2], &oblateness = report.rows[3];
  CHECK(relativity.coupled);
  CHECK(!oblateness.coupled);
  CHECK(relativity.shift_max > 2e-4);  // the perihelion, and the mean motion
  CHECK(relativity.shift_max < 2e-3);
  CHECK(oblateness.shift_max == Approx(5e-7).epsilon(0.5));
  // (3/2) J₂ (R/r)² of the attraction, at perihelion.
  CHECK(oblateness.size_max == Approx(1.5 * 2e-7 * std::pow(0.00465047 / (a * (1 - e)), 2)).epsilon(0.01));
  CHECK(oblateness.size_mean < oblateness.size_max);
  CHECK(relativity.invariant_shift[0] > oblateness.invariant_shift[0]);
  double share = 0;
  for (const AuditRow& row : report.rows) share += row.time_share;
  CHECK(share == Approx(1));

  std::ostringstream table;
  table << report;
  CHECK(table.str().find("1pn") != std::string::npos);
}

TEST_CASE("Shifts and a numerical error of the orbit's size leave every effect undecided", "[scene]") {
  Audit chaotic;
  chaotic.noise = 1.9;
  for (const auto& [name, shift] :
       std::vector<std::pair<const char*, double>>{{"small", 2.1}, {"large", 1.8}})
    chaotic.rows.push_back({.name = name, .shift_max = shift, .invariant_shift = {}});
  CHECK(chaotic.called_for(0.01).empty());
  CHECK(chaotic.undecided(0.01) == std::vector<std::string>{"small", "large"});
  chaotic.noise = 0.1;
  CHECK(chaotic.called_for(0.01) == std::vector<std::string>{"small", "large"});
}

TEST_CASE("An audit says where its own runs are too coarse, and where nothing runs without an effect",
          "[scene]") {
  const double gm = 39.47841760435743, a = 0.38709893;
  const Point z({a, 0}, {0, std::sqrt(gm / a)});
  const Audit coarse = audit(mercury(), z, 10, {.dt = 0.008});
  CHECK(coarse.noise > 1e-9);
  CHECK(coarse.undecided(1e-12) == std::vector<std::string>{"j2"});
  CHECK(coarse.called_for(1e-12).size() == 3);

  const Audit alone = audit(Scene(Kinetic<double, 2>{}), Point({1, 0}, {0, 1}), 1, {.dt = 0.1});
  CHECK(std::isinf(alone.rows[0].shift_max));
  CHECK(alone.called_for(1) == std::vector<std::string>{"kinetic"});
  // An orbit through the origin is compared, too.
  const Audit oscillator =
      audit(Scene(Kinetic<double, 2>{}, Oscillator{}), Point({0, 0}, {1, 0}), 6.4, {.dt = 0.1});
  CHECK(oscillator.rows[1].shift_max == Approx(6.4 - std::sin(6.4)).epsilon(1e-4));
  CHECK(oscillator.called_for(0.1).size() == 2);
  CHECK(refuses([&] { audit(mercury(), z, INFINITY, {.dt = 1}); }, "finite"));
  CHECK(refuses([&] { audit(mercury(), z, 1, {}); }, "options.dt"));
}

TEST_CASE("An audit keeps its bound on gradient calls, or says what to change", "[scene]") {
  const Point z({1, 0}, {0, 1});
  std::int64_t calls = 0;
  const Scene counted(CountingPotential{&calls}, Kinetic<double, 2>{}, Spelled{});
  const auto bounded = [&](double bound) {
    calls = 0;
    return refusal([&] { audit(counted, z, 10, {.dt = 0.05, .max_gradients = bound}); });
  };
  // Six runs of 200 steps: refused before they begin, and in their midst.
  CHECK(says(bounded(1e4), "options.max_gradients is 1e+04; give a larger options.dt, a shorter time"));
  CHECK(calls == 0);
  const double least = 1212 + 1200.0 * static_cast<double>(schemes::low_defect6_s13().kicks());
  CHECK(says(bounded(least), "and more gradient calls, and options.max_gradients is"));
  CHECK(calls > 0);
  CHECK(static_cast<double>(calls) <= least);
  CHECK(bounded(1e9) == accepted);
  CHECK(says(bounded(0), "options.max_gradients is not positive"));
  AuditOptions<double, 2> unfilled{.dt = 0.05};
  unfilled.invariants = {{"L", {}}};
  CHECK(refuses([&] { audit(counted, z, 10, unfilled); }, "the invariant L of options.invariants is empty"));
  // A time that no loop counter holds.
  CHECK(refuses([&] { audit(counted, z, 1e300, {.dt = 1e-10}); }, "options.max_gradients is 1e+09"));
}

namespace {

/// A force in x, and a spring that another effect may bring along.
struct Pull {
  using Acts = OnPosition<double, 2>;
  std::string called;
  double force, spring = 0;
  std::string name() const { return called; }
  double energy(const auto& q) const { return force * q[0] + spring * q[0] * q[0] / 2; }
  void add_gradient(const auto& q, auto& dHdq) const { dHdq[0] += force + spring * q[0]; }
};

}  // namespace

TEST_CASE("An audit leaves out an effect that others count as there by making these anew", "[scene]") {
  using Chosen = RuntimeScene<double, 2>;
  const auto scene = [](std::vector<AnyEffect<double, 2>> pulls) {
    pulls.insert(pulls.begin(), {Kinetic<double, 2>{}, Oscillator{}});
    return Chosen(pulls);
  };
  const Chosen both = scene({Pull{"first", 0.2}, Pull{"second", 0.1, 0.3}}),
               alone = scene({Pull{"second", 0.1}});
  const Point z0({1, 0}, {0, 0.5});
  const auto without = [&](const std::string& name) { return name == "first" ? alone : both.without(name); };
  const Audit found = audit(both, z0, 10, {.dt = 0.01, .without = without});
  const auto end = [&](const Chosen& of) {
    Point z = z0;
    auto stepper = stepper_for(of, schemes::low_defect6_s13<double>());
    integrate(stepper, z, {.dt = 0.01, .t_end = 10});
    return z;
  };
  double size = z0.q().norm();
  Point z = z0;
  auto stepper = stepper_for(both, schemes::low_defect6_s13<double>());
  integrate(stepper, z, {.dt = 0.05, .t_end = 10},
            [&](double, const Point& now) { size = std::max(size, now.q().norm()); });
  CHECK(found.rows[2].name == "first");
  CHECK(found.rows[2].shift_final == Approx((end(both).q() - end(alone).q()).norm() / size).epsilon(1e-6));
  const Audit as_it_is = audit(both, z0, 10, {.dt = 0.01});
  CHECK(std::abs(found.rows[2].shift_final / as_it_is.rows[2].shift_final - 1) > 0.1);
  CHECK(found.rows[3].shift_final == Approx(as_it_is.rows[3].shift_final).epsilon(1e-12));
}

TEST_CASE("What strays is relative to nothing that is zero up to rounding", "[scene]") {
  AuditOptions<double, 2> options{.dt = 0.01};
  options.invariants = {{"L", [](const auto& q, const auto& p) { return q[0] * p[1] - q[1] * p[0]; }}};
  const Audit radial =
      audit(Scene(Kinetic<double, 2>{}, Attraction<double, 2>{}, RotatingFrame<double, 2>{.omega = 0.1}),
            Point({1.0 / 3, 3}, {1.0 / 9, 1 + 2e-16}), 1, options);
  for (const AuditRow& row : radial.rows) CHECK(row.invariant_shift[1] < 1);
}

TEST_CASE("a circular binary shrinks to its merger as Peters says", "[long]") {
  // a = a₀ (1 - t/T)^(1/4), T = 5c⁵a₀⁴/(256ν(GM)³): half the size after 15/16 of the time.
  const double c = 10, nu = 0.25, merger = 5 * std::pow(c, 5) / (256 * nu);
  const Scene scene(Kinetic<double, 2>{}, Attraction<double, 2>{}, RadiationReaction<double, 2>{1, c, nu});
  auto stepper = stepper_for(scene, exactly<Kinetic<double, 2>, Attraction<double, 2>>());
  PhasePoint<double, 2> z({1, 0}, {0, 1});
  Books books(scene);
  integrate(stepper, z, {.dt = 0.07, .t_end = merger * 15 / 16}, books);
  CHECK(-1 / (2 * scene.energy(z.q(), z.p())) == Approx(0.5).epsilon(1e-3));
  CHECK(books.work() == Approx(-0.5).epsilon(2e-3));
  CHECK(std::abs(books.difference()) < 1e-8);
}

}  // namespace test_scene
