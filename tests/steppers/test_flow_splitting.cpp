#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_flow_splitting {

// Splitting with the exact flow of some effects: its orders, its geometry, its failures.

namespace {

using namespace semiexplicit;
namespace orbits = effects::orbits;
using Real = long double;

/// Kepler's motion with 1PN of relative size eps, and with a part on q alone where `oblate` is not zero.
template <class Scalar>
auto relativistic(Scalar eps, Scalar oblate = 0) {
  return Scene(orbits::Kinetic<Scalar, 2>{}, orbits::Attraction<Scalar, 2>{.gm = 1},
               orbits::PostNewtonian1<Scalar, 2>{.gm = 1, .c = 1 / std::sqrt(eps)},
               orbits::Oblateness<Scalar, 2>{.gm = 1, .j2 = oblate, .radius = 1});
}
template <class Scalar>
constexpr auto kepler() {
  return exactly<orbits::Kinetic<Scalar, 2>, orbits::Attraction<Scalar, 2>>();
}
template <class Scalar>
PhasePoint<Scalar, 2> start() {
  return {{Scalar(0.8), Scalar(0)}, {Scalar(0), std::sqrt(Scalar(1.2) / Scalar(0.8))}};
}

/// The state after a time of 12 in so many steps.
PhasePoint<Real, 2> after(const NearIntegrable<Real>& list, Real eps, Real oblate, int steps) {
  auto stepper = stepper_for(relativistic<Real>(eps, oblate), kepler<Real>(), list,
                             SimplifiedNewton{.stop = StoppingRule::paper(0)});
  PhasePoint<Real, 2> z = start<Real>();
  integrate(stepper, z, {.dt = Real(12) / steps, .steps = steps});
  return z;
}
Real error(const NearIntegrable<Real>& list, Real eps, Real oblate, int steps) {
  const auto right = after(schemes::aba1064<Real>(), eps, oblate, 600);
  return (after(list, eps, oblate, steps).vector() - right.vector()).norm();
}
/// The power of h between two numbers of steps.
double order(const NearIntegrable<Real>& list, Real eps, int steps, int more) {
  return double(std::log(error(list, eps, 0, steps) / error(list, eps, 0, more)) /
                std::log(Real(more) / Real(steps)));
}

/// z after one step, and the numbers that it is made of, by differences.
template <class S>
double symplecticity_defect(S stepper, const typename S::State& z, Real dt) {
  constexpr int n = 2 * S::Dof;
  Eigen::Matrix<Real, n, n> jacobian, omega = Eigen::Matrix<Real, n, n>::Zero();
  const Real h = Real(1e-5);
  const auto moved = [&](int k, Real by) {
    auto near = z;
    near.vector()[k] += by;
    REQUIRE(stepper.step(near, dt).ok());
    return near.vector().eval();
  };
  for (int k = 0; k < n; ++k)
    jacobian.col(k) = (8 * (moved(k, h) - moved(k, -h)) - (moved(k, 2 * h) - moved(k, -2 * h))) / (12 * h);
  for (int k = 0; k < S::Dof; ++k) {
    omega(k, S::Dof + k) = 1;
    omega(S::Dof + k, k) = -1;
  }
  return double((jacobian.transpose() * omega * jacobian - omega).cwiseAbs().maxCoeff());
}

/// A repulsion that is NaN inside of a disk, coupled or not.
template <class Kind, bool throws = false>
struct Hole {
  using Acts = Kind;
  static constexpr const char* name = "hole";
  double inner = 0.5;
  template <class Q>
  double check(const Q& q) const {
    const double r2 = q[0] * q[0] + q[1] * q[1];
    if (r2 < inner * inner) {
      if (throws) throw std::runtime_error("in the hole");
      return std::nan("");
    }
    return 0;
  }
  double energy(const auto& q) const { return check(q); }
  double energy(const auto& q, const auto&) const { return check(q); }
  void add_gradient(const auto& q, auto& dHdq) const { dHdq[0] += check(q); }
  void add_gradient(const auto& q, const auto&, auto& dHdq, auto& dHdp) const {
    dHdq[0] += check(q);
    dHdp[0] += check(q);
  }
};

/// A solver of one's own that is limited by rounding at its second solve.
struct Limited {
  mutable int solves = 0;
  template <class Vec>
  struct Workspace {
    Workspace(const Limited&, Eigen::Index size) : own(SimplifiedNewton{}, size) {}
    SimplifiedNewton::Workspace<Vec> own;
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    auto report = SimplifiedNewton{}.solve(residual, m, work.own);
    if (++solves == 2) report.status = Status::rounding_limited;
    return report;
  }
  template <class List>
  void describe(List&) const {}
};

}  // namespace

TEST_CASE("The lists of generalised order pass their own check, and refuse to claim more",
          "[flow_splitting]") {
  for (const auto& list : {schemes::aba82<double>(), schemes::aba84<double>(), schemes::aba104<double>(),
                           schemes::aba864<double>(), schemes::aba1064<double>()}) {
    INFO(list.name);
    CHECK_NOTHROW(list.check());
    auto more = list;
    more.orders.front() += 2;
    CHECK(refuses([&] { more.check(); }, "is claimed, but a condition of degree"));
    more = list;
    more.orders.back() += 2;
    CHECK(refuses([&] { more.check(); }, "is claimed, but a condition of degree"));
    more = list;
    more.b.front() += 1e-3;
    CHECK(refuses([&] { more.check(); }, "palindromic"));
  }
  CHECK(schemes::aba864<double>().order_in_words() == "(8,6,4)");
  CHECK_NOTHROW(schemes::aba1064<long double>());
  CHECK_NOTHROW(schemes::aba82<float>());
  CHECK(refuses([] { NearIntegrable<double>("mine", {2, 4}, {0.5, 0.5}, {1}); }, "do not grow"));
  CHECK(refuses([] { NearIntegrable<double>("mine", {}, {0.5, 0.5}, {1}); }, "no order is claimed"));
  CHECK(refuses([] { NearIntegrable<double>("mine", {2}, {0.5, 0.5}, {}); }, "at least one B"));
}

TEST_CASE("An ordinary scheme is a list, unless it needs the projection for its order", "[flow_splitting]") {
  const NearIntegrable<double> list = schemes::blanes_moan6<double>();
  CHECK(list.orders == std::vector<int>{6});
  CHECK(refuses([] { NearIntegrable<double>(schemes::low_defect6_s13<double>()); },
                "with the projection only"));
}

TEST_CASE("A Nyström list has its order for a potential that is not small, and is refused for all else",
          "[flow_splitting]") {
  using Frame = orbits::RotatingFrame<Real, 2>;
  constexpr auto free_motion = exactly<orbits::Kinetic<Real, 2>, Frame>();
  const Scene scene(orbits::Kinetic<Real, 2>{}, Frame{.omega = 1},
                    orbits::TwoCentres<Real, 2>::restricted(0.3L));
  const auto list = schemes::blanes_moan_nystrom6<Real>();
  const auto end = [&](const NearIntegrable<Real>& by, int steps) {
    auto stepper = stepper_for(scene, free_motion, by);
    PhasePoint<Real, 2> z({0.3L, 0.9L}, {-0.9L, 0.2L});
    integrate(stepper, z, {.dt = 4 / Real(steps), .steps = steps});
    return z.vector().eval();
  };
  const auto right = end(schemes::sofroniou_spaletta10<Real>(), 1600);
  const auto error = [&](const NearIntegrable<Real>& by, int steps) {
    return (end(by, steps) - right).norm();
  };
  CHECK(double(std::log2(error(list, 40) / error(list, 80))) == Approx(6).margin(0.2));
  CHECK(error(list, 50) < error(schemes::blanes_moan6<Real>(), 70) / 2);  // 700 kicks each

  // For any other A and B it has order 4 only: it is no list of order 6 without the claim.
  CHECK(refuses([&] { NearIntegrable<Real>("mine", {6}, list.a, list.b); }, "3 in epsilon is violated"));
  CHECK(refuses([&] { NearIntegrable<Real>("mine", {8}, list.a, list.b, "", true); }, "up to order 6"));
  auto wrong = list;
  wrong.b[1] += 1e-4L;
  wrong.b[12] += 1e-4L;
  wrong.b[0] -= 1e-4L;
  wrong.b[13] -= 1e-4L;
  CHECK(refuses([&] { wrong.check(); }, "is violated"));
  CHECK(refuses([&] { stepper_for(relativistic<Real>(1e-6L), kepler<Real>(), list); }, "positions alone"));
}

TEST_CASE("An error linear in a small perturbation has the first of the generalised orders",
          "[flow_splitting]") {
  const Real eps = 1e-9L;
  CHECK(order(schemes::aba82<Real>(), eps, 24, 34) == Approx(8).margin(0.8));
  CHECK(order(schemes::aba84<Real>(), eps, 24, 34) == Approx(8).margin(0.8));
  CHECK(order(schemes::aba864<Real>(), eps, 28, 36) == Approx(8).margin(1.2));
  CHECK(order(schemes::aba104<Real>(), eps, 10, 14) == Approx(10).margin(1.5));
  for (const auto& list : {schemes::aba82<Real>(), schemes::aba104<Real>()}) {
    INFO(list.name);
    CHECK(double(error(list, 2 * eps, 0, 12) / error(list, eps, 0, 12)) == Approx(2).epsilon(0.01));
  }
}

TEST_CASE("With (8,2) an error quadratic in the perturbation is left, of second order in the step",
          "[flow_splitting]") {
  const auto list = schemes::aba82<Real>();
  const Real eps = 1e-3L;
  CHECK(order(list, eps, 100, 200) == Approx(2).margin(0.1));
  CHECK(double(error(list, 2 * eps, 0, 100) / error(list, eps, 0, 100)) == Approx(4).epsilon(0.1));
}

TEST_CASE(
    "With (8,4) the quadratic error is of fourth order, and with (8,6,4) only what the kicks leave is seen",
    "[flow_splitting]") {
  const Real eps = 1e-3L;
  const auto quadratic = schemes::aba84<Real>(), kicks = schemes::aba864<Real>();
  CHECK(order(quadratic, eps, 80, 160) == Approx(4).margin(0.3));
  CHECK(double(error(quadratic, 2 * eps, 0, 100) / error(quadratic, eps, 0, 100)) == Approx(4).epsilon(0.1));
  CHECK(order(kicks, eps, 100, 200) == Approx(2).margin(0.3));
  CHECK(double(error(kicks, 2 * eps, 0, 200) / error(kicks, eps, 0, 200)) == Approx(8).epsilon(0.2));
  CHECK(error(kicks, eps, 0, 100) < error(schemes::aba82<Real>(), eps, 0, 100) / 50);
}

TEST_CASE("A rest with a part on q alone and a coupled one keeps the orders", "[flow_splitting]") {
  const Real eps = 1e-5L;
  const auto list = schemes::aba82<Real>();
  const double eighth =
      double(std::log(error(list, 1e-9L, 1e-9L, 24) / error(list, 1e-9L, 1e-9L, 34)) / std::log(34 / 24.0L));
  CHECK(eighth == Approx(8).margin(0.8));
  const double second =
      double(std::log(error(list, eps, eps, 150) / error(list, eps, eps, 300)) / std::log(2.0L));
  CHECK(second == Approx(2).margin(0.2));
}

TEST_CASE("A step with an exact flow is symplectic to the accuracy of the kick's solve", "[flow_splitting]") {
  PhasePoint<Real, 2> z({0.9L, 0.3L}, {-0.2L, 1.1L});
  for (const Real eps : {1e-6L, 1e-3L, 1e-2L})
    for (const Real oblate : {0.0L, 0.01L}) {
      INFO("eps = " << double(eps) << ", oblate = " << double(oblate));
      CHECK(symplecticity_defect(
                stepper_for(relativistic<Real>(eps, oblate), kepler<Real>(), schemes::aba82<Real>(),
                            SimplifiedNewton{.stop = StoppingRule::paper(0)}),
                z, 0.5L) < 1e-13);
      // With the usual rule, one evaluation or two: its tolerance is a drift a kick.
      CHECK(symplecticity_defect(stepper_for(relativistic<Real>(eps, oblate), kepler<Real>()), z, 0.5L) <
            1e-11);
    }
  const Scene frame(orbits::Kinetic<Real, 2>{}, orbits::RotatingFrame<Real, 2>{.omega = 1},
                    orbits::TwoCentres<Real, 2>::restricted(0.1L));
  CHECK(symplecticity_defect(
            stepper_for(frame, exactly<orbits::Kinetic<Real, 2>, orbits::RotatingFrame<Real, 2>>()), z,
            0.2L) < 1e-13);
}

TEST_CASE("A step back with an exact flow undoes the step", "[flow_splitting]") {
  auto stepper = stepper_for(relativistic<double>(1e-3, 1e-3), kepler<double>(), schemes::aba864<double>(),
                             SimplifiedNewton{.stop = StoppingRule::paper(0)});
  PhasePoint<double, 2> z = start<double>();
  const auto before = z;
  integrate(stepper, z, {.dt = 0.7, .steps = 100});
  CHECK((z.vector() - before.vector()).norm() > 0.1);
  integrate(stepper, z, {.dt = -0.7, .steps = 100});
  CHECK((z.vector() - before.vector()).norm() < 1e-11);
}

TEST_CASE("Angular momentum is kept to rounding, and the energy error does not grow",
          "[flow_splitting][long]") {
  const auto scene = relativistic<double>(1e-6, 1e-6);
  auto stepper = stepper_for(scene, kepler<double>());
  PhasePoint<double, 2> z = start<double>();
  Invariants invariants(scene);
  invariants.add("angular momentum", [](const auto& q, const auto& p) { return q[0] * p[1] - q[1] * p[0]; });
  integrate(stepper, z, {.dt = 0.6, .steps = 20'000}, invariants);
  const double early = invariants["energy"].worst;
  CHECK(early < 1e-9);
  integrate(stepper, z, {.dt = 0.6, .steps = 180'000}, invariants);
  CHECK(invariants["energy"].worst < 1.5 * early);
  CHECK(invariants["angular momentum"].worst < 1e-12);
}

TEST_CASE("A kick of a small coupled rest takes two gradient calls", "[flow_splitting]") {
  auto stepper = stepper_for(relativistic<double>(1e-8), kepler<double>());
  static_assert(decltype(stepper)::has_position && decltype(stepper)::has_coupled &&
                !decltype(stepper)::has_momentum);
  PhasePoint<double, 2> z = start<double>();
  const IntegrationReport run = integrate(stepper, z, {.dt = 0.8, .steps = 1000});
  CHECK(run.evaluations == 4 * run.steps);
  CHECK(run.gradients == (2 + 1) * 4 * run.steps);  // and two halves for the oblateness
  CHECK(stepper.gradients_of_kick() == 3);
}

TEST_CASE("A kick that was limited by rounding is told of, whatever comes after it", "[flow_splitting]") {
  auto stepper =
      stepper_for(relativistic<double>(1e-8), kepler<double>(), schemes::aba84<double>(), Limited{});
  PhasePoint<double, 2> z = start<double>();
  CHECK(stepper.step(z, 0.8).status == Status::rounding_limited);
  CHECK(stepper.step(z, 0.8).status == Status::success);
}

TEST_CASE("A scene whose effects all have the exact flow is that flow", "[flow_splitting]") {
  auto stepper = stepper_for(Scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = 1}),
                             kepler<double>());
  PhasePoint<double, 2> z = start<double>();
  const StepReport report = stepper.step(z, 2 * std::acos(-1.0));
  CHECK(report.ok());
  CHECK(report.gradients == 0);
  CHECK((z.vector() - start<double>().vector()).norm() < 1e-14);
}

TEST_CASE("Free motion in a turning frame is exact, and its potential a kick", "[flow_splitting]") {
  const Scene scene(orbits::Kinetic<double, 2>{}, orbits::RotatingFrame<double, 2>{.omega = 1},
                    orbits::TwoCentres<double, 2>::restricted(0.3));
  auto exact = stepper_for(scene, exactly<orbits::Kinetic<double, 2>, orbits::RotatingFrame<double, 2>>());
  static_assert(!decltype(exact)::has_coupled);
  auto doubled = stepper_for(scene);
  PhasePoint<double, 2> z({0.3, 0.9}, {-0.9, 0.2}), other = z;
  const IntegrationReport run = integrate(exact, z, {.dt = 0.01, .steps = 400});
  integrate(doubled, other, {.dt = 0.01, .steps = 400});
  CHECK((z.vector() - other.vector()).norm() < 1e-9);
  CHECK(run.gradients == 7 * run.steps);  // fourteen kicks in q alone
  CHECK(exact.max_gradients() == 7);
}

TEST_CASE("A step that fails says why and leaves the state", "[flow_splitting]") {
  using Coupled = Hole<OnBoth<double, 2>>;
  using Position = Hole<OnPosition<double, 2>>;
  using Throwing = Hole<OnBoth<double, 2>, true>;
  const orbits::Kinetic<double, 2> kinetic;
  const orbits::Attraction<double, 2> attraction;
  const PhasePoint<double, 2> inside({0.2, 0}, {0, 1}), good({1, 0}, {0, 1});
  const auto fails = [](auto stepper, PhasePoint<double, 2> z, double dt, Status status) {
    const auto before = z;
    const StepReport report = stepper.step(z, dt);
    const bool untouched = std::equal(z.vector().begin(), z.vector().end(), before.vector().begin(),
                                      [](double x, double y) { return x == y || (x != x && y != y); });
    return report.status == status && untouched;
  };
  const auto with = [&](const auto& effect) {
    return stepper_for(Scene(kinetic, attraction, effect), kepler<double>());
  };
  CHECK(fails(with(Coupled{}), inside, 0.01, Status::not_finite));
  CHECK(fails(with(Position{}), inside, 0.01, Status::not_finite));
  CHECK(fails(with(Coupled{}), {{0, 0}, {0, 1}}, 0.01, Status::not_finite));  // collision
  CHECK(fails(with(Coupled{}), {{std::nan(""), 0}, {0, 1}}, 0.01, Status::invalid_state));
  CHECK(fails(with(Position{}), {{1, 0}, {0, std::numeric_limits<double>::infinity()}}, 0.01,
              Status::invalid_state));
  CHECK(fails(with(Coupled{}), good, 0, Status::invalid_step));
  CHECK(fails(with(Coupled{}), good, std::nan(""), Status::invalid_step));

  auto throwing = with(Throwing{});
  PhasePoint<double, 2> z = inside;
  CHECK_THROWS_AS(throwing.step(z, 0.01), std::runtime_error);
  CHECK(z.vector() == inside.vector());
  z = good;
  CHECK(throwing.step(z, 0.01).ok());

  // Too strong for one copy of a step: the equation of a kick has no solution within its evaluations.
  auto strong = stepper_for(relativistic<double>(0.5), kepler<double>(), schemes::aba82<double>(),
                            SimplifiedNewton{.max_iterations = 5});
  CHECK_FALSE(fails(strong, good, 2, Status::success));
  z = good;
  const StepReport report = strong.step(z, 4);
  CHECK((report.ok() || z.vector() == good.vector()));

  auto weak = stepper_for(relativistic<double>(1e-6), kepler<double>());
  auto moved_to = std::move(weak);
  z = good;
  CHECK(weak.step(z, 0.1).status == Status::invalid_stepper);  // NOLINT: moved from, on purpose
  CHECK(moved_to.step(z, 0.1).ok());
}

/// (q² + p²)/2 exact, and q⁴/4 kicked; no flow is prepared for more than 2.
struct Anharmonic {
  using Scalar = double;
  static constexpr int Dof = 1;
  struct Prepared {
    double sine = 0, less = 0;
    Status increments(const auto& q, const auto& p, auto& dq, auto& dp) const {
      dq[0] = sine * p[0] - less * q[0];
      dp[0] = -sine * q[0] - less * p[0];
      return Status::success;
    }
  };
  Prepared prepared(double t) const {
    if (std::abs(t) > 2) throw std::runtime_error("too long");
    return {std::sin(t), 2 * std::sin(t / 2) * std::sin(t / 2)};
  }
  Status flow(double t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    return prepared(t).increments(q, p, dq, dp);
  }
  std::string flow_name() const { return "oscillator"; }
  double energy(In<double, 1> q, In<double, 1> p) const {
    return (q[0] * q[0] + p[0] * p[0]) / 2 + std::pow(q[0], 4) / 4;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] + std::pow(q[0], 3);
    dHdp = p;
  }
  void rest_position_gradient(In<double, 1> q, Out<double, 1> dHdq) const { dHdq[0] = std::pow(q[0], 3); }
};

TEST_CASE("A flow that cannot be prepared leaves those of the step before as they were", "[flow_splitting]") {
  FlowSplitting stepper(Anharmonic{}, schemes::blanes_moan6<double>()), other = stepper;
  PhasePoint<double, 1> z(0.5, 1), x = z;
  integrate(stepper, z, {.dt = 0.1, .steps = 10});
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 9, .steps = 1}), std::runtime_error);
  integrate(stepper, z, {.dt = 0.1, .steps = 10});
  integrate(other, x, {.dt = 0.1, .steps = 20});
  CHECK(z.vector() == x.vector());
}

TEST_CASE("The lists of this library have the digits of wide types", "[flow_splitting]") {
  using Wide = boost::multiprecision::cpp_bin_float_50;
  CHECK_NOTHROW(schemes::aba82<Wide>());
  CHECK_NOTHROW(schemes::aba84<Wide>());
  CHECK_NOTHROW(schemes::aba104<Wide>());
  CHECK_NOTHROW(schemes::aba864<Wide>());
  CHECK_NOTHROW(schemes::aba1064<Wide>());
  CHECK_NOTHROW(schemes::blanes_moan_nystrom6<Wide>());
}

TEST_CASE("A run with an exact flow in float keeps its energy to float's rounding", "[flow_splitting]") {
  const auto scene = relativistic<float>(1e-4F);
  auto stepper = stepper_for(scene, kepler<float>());
  PhasePoint<float, 2> z = start<float>();
  Invariants invariants(scene);
  CHECK(integrate(stepper, z, {.dt = 0.5F, .steps = 5000}, invariants).ok());
  CHECK(invariants["energy"].worst < 1e-4F);
}

TEST_CASE("Steps of many periods, and after 10⁸ of them, still keep the energy", "[flow_splitting]") {
  const auto scene = relativistic<double>(1e-13);
  auto stepper = stepper_for(scene, kepler<double>());
  PhasePoint<double, 2> z = start<double>();
  Invariants invariants(scene);
  CHECK(integrate(stepper, z, {.dt = 1e6, .steps = 100, .t0 = 1e12}, invariants).ok());
  CHECK(invariants["energy"].worst < 1e-6);  // a kick is of 1e-7
}

TEST_CASE("An interrupted run with an exact flow goes on bit for bit", "[flow_splitting]") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  const auto fresh = stepper_for(relativistic<double>(1e-5, 1e-5), kepler<double>());
  IntegrationOptions<double> options{.dt = 0.3, .steps = 50};
  auto whole = fresh;
  PhasePoint<double, 2> z = start<double>();
  integrate(whole, z, options);
  {
    auto first = fresh;
    PhasePoint<double, 2> lost = start<double>();
    IntegrationOptions<double> part = options;
    part.steps = 17;
    Checkpoints checkpoints(file, {.every = 17}, first, options);
    integrate(first, lost, part, checkpoints);
  }
  {
    auto another = stepper_for(relativistic<double>(1e-5, 1e-5), kepler<double>(), schemes::aba84<double>());
    PhasePoint<double, 2> resumed = start<double>();
    Checkpoints checkpoints(file, {.every = 17}, another, options);
    CHECK_THROWS(checkpoints.resume(resumed));
  }
  auto second = fresh;
  PhasePoint<double, 2> resumed = start<double>();
  Checkpoints checkpoints(file, {.every = 1000}, second, options);
  options.done = checkpoints.resume(resumed);
  CHECK(options.done.steps == 17);
  integrate(second, resumed, options, checkpoints);
  CHECK(resumed.vector() == z.vector());
}

/// (q² + p²)/2 + q⁴/40, of which an oscillator of another frequency is exact and the difference is kicked.
struct Detuned {
  using Scalar = double;
  static constexpr int Dof = 1;
  double frequency;
  Status flow(double t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const double less = 2 * std::pow(std::sin(frequency * t / 2), 2), sine = std::sin(frequency * t);
    dq[0] = sine / frequency * p[0] - less * q[0];
    dp[0] = -frequency * sine * q[0] - less * p[0];
    return Status::success;
  }
  std::string flow_name() const { return "oscillator"; }
  double energy(In<double, 1> q, In<double, 1> p) const {
    return (q[0] * q[0] + p[0] * p[0]) / 2 + std::pow(q[0], 4) / 40;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] + std::pow(q[0], 3) / 10;
    dHdp = p;
  }
  void rest_position_gradient(In<double, 1> q, Out<double, 1> dHdq) const {
    dHdq[0] = (1 - frequency * frequency) * q[0] + std::pow(q[0], 3) / 10;
  }
};

TEST_CASE("A run with the same Hamiltonian in other parts is refused", "[flow_splitting]") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  const IntegrationOptions<double> options{.dt = 0.3, .steps = 20};
  const auto go = [&](double frequency, std::int64_t until) {
    FlowSplitting stepper(Detuned{frequency}, schemes::aba84<double>());
    PhasePoint<double, 1> z(1, 0);
    Checkpoints checkpoints(file, {.every = 10}, stepper, options);
    IntegrationOptions<double> part = options;
    part.done = checkpoints.resume(z);
    part.steps = until;
    integrate(stepper, z, part, checkpoints);
  };
  go(1, 10);
  CHECK_THROWS_AS(go(1.02, 20), std::invalid_argument);
  CHECK_NOTHROW(go(1, 20));
}

/// Two oscillators, exact, with a coupled rest of a size of its own.
struct Oversized {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  systems::NlsLattice<double> rest;
  Eigen::Index dof() const { return 2; }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    dHdq = q, dHdp = p;
  }
  Status flow(double t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    dq = t * p, dp = -t * q;
    return Status::success;
  }
  std::string flow_name() const { return "oscillators"; }
  const systems::NlsLattice<double>& coupled_rest() const { return rest; }
};

TEST_CASE("A coupled rest of another size than the Hamiltonian is refused") {
  const auto list = schemes::aba82<double>();
  CHECK(refuses([&] { FlowSplitting(Oversized{systems::NlsLattice<double>(3)}, list); },
                "the coupled rest 3; give both the same size"));
  CHECK_NOTHROW(FlowSplitting(Oversized{systems::NlsLattice<double>(2)}, list));
}

}  // namespace test_flow_splitting
