#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_run {

// How a run ends with any method, and what its report adds up to.

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

const systems::Product<double> product;

/// Moves q by dt, and reports what it is told to.
struct Script {
  using Scalar = double;
  using State = Point;
  std::vector<StepReport> reports;
  std::size_t next = 0;

  StepReport step(Point& z, const double& dt) {
    const StepReport report = next < reports.size() ? reports[next] : StepReport{};
    ++next;
    if (report.ok()) z.q()[0] += dt;
    return report;
  }
};

/// What a run of `stepper` fails with.
template <class Stepper>
IntegrationReport failure(Stepper stepper, typename Stepper::State& state, double dt) {
  try {
    integrate(stepper, state, {.dt = dt, .steps = 3});
  } catch (const IntegrationError& e) {
    return e.report();
  }
  return {};
}

}  // namespace

TEST_CASE("A run: the stop of an earlier observer is not undone by a later one, nor the other way",
          "[integrate]") {
  for (const bool first : {true, false}) {
    Script stepper;
    Point z(0, 0);
    const auto stop = [&](double t, const Point&, const StepReport&) { return t < 2.5; };
    const auto go_on = [](double, const Point&) { return true; };
    const IntegrationOptions<double> options{.dt = 1, .steps = 10};
    const auto report =
        first ? integrate(stepper, z, options, stop, go_on) : integrate(stepper, z, options, go_on, stop);
    CHECK(report.status == Status::stopped);
    CHECK(report.steps == 3);
    CHECK(z.q()[0] == 3);
  }
}

TEST_CASE("A run: the report sums up the steps, a failed one included", "[integrate]") {
  Script stepper{
      .reports = {{.evaluations = 2, .gradients = 20, .correction = 1e-9},
                  {.status = Status::rounding_limited, .evaluations = 4, .gradients = 40, .correction = 3e-7},
                  {.evaluations = 1, .gradients = 10, .correction = 1e-8},
                  {.status = Status::no_convergence,
                   .evaluations = 100,
                   .gradients = 1000,
                   .correction = 0.5,
                   .rate = 1.25}}};
  Point z(0, 0);
  const auto three = integrate(stepper, z, {.dt = 0.25, .steps = 3});
  CHECK(three.status == Status::success);
  CHECK(three.evaluations == 7);
  CHECK(three.gradients == 70);
  CHECK(three.max_correction == 3e-7);
  CHECK(three.last.correction == 1e-8);
  CHECK(three.seconds >= 0);

  stepper.next = 0;
  z = Point(0, 0);
  int calls = 0;
  const auto four = integrate(stepper, z, {.dt = 0.25, .steps = 10, .on_failure = OnFailure::stop, .t0 = 1},
                              [&](double, const Point&) { ++calls; });
  CHECK(four.status == Status::no_convergence);
  CHECK_FALSE(four.ok());
  CHECK(four.steps == 3);
  CHECK(four.t == 1.75);
  CHECK(four.evaluations == 107);
  CHECK(four.gradients == 1070);
  CHECK(four.max_correction == 3e-7);  // of accepted steps
  CHECK(four.last.status == Status::no_convergence);
  CHECK(four.last.correction == 0.5);
  CHECK(four.last.rate == 1.25);
  CHECK(calls == 4);  // not for the step that failed
  CHECK(z.q()[0] == 0.75);
}

TEST_CASE("A run that fails says where, why and what to do", "[integrate]") {
  std::vector<StepReport> reports(41);
  reports.push_back({.status = Status::no_convergence, .evaluations = 100, .correction = 0.125, .rate = 1.5});
  Script stepper{.reports = reports};
  Point z(0, 0);
  try {
    integrate(stepper, z, {.dt = 0.25, .steps = 1000, .t0 = 100});
    FAIL("the run should have failed");
  } catch (const IntegrationError& e) {
    const std::string message = e.what();
    CAPTURE(message);
    for (const char* part : {"step 42 failed", "t = 110.25", "dt = 0.25", "did not converge", "reduce dt",
                             "last correction 0.125 after 100 evaluations", "factor 1.5"}) {
      CAPTURE(part);
      CHECK(message.find(part) != std::string::npos);
    }
    CHECK(e.report().status == Status::no_convergence);
    CHECK(e.report().steps == 41);
    CHECK(e.report().t == 110.25);
    CHECK(e.report().last.rate == 1.5);
  }
  CHECK(z.q()[0] == 41 * 0.25);
  CHECK_THROWS_AS(
      integrate(stepper = {.reports = {{.status = Status::not_finite}}}, z, {.dt = 1, .steps = 1}),
      std::runtime_error);
}

TEST_CASE("A failed run of a wrong gradient names check_gradient", "[integrate]") {
  const auto wrong = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = -q[0] * (p[0] * p[0] + 1);
        dHdp[0] = p[0] * (q[0] * q[0] + 1);
      });
  Semiexplicit stepper(wrong, schemes::low_defect6_s13<double>());
  PhasePoint<double, 1> z(-3, 0.5);
  std::string said;
  try {
    integrate(stepper, z, {.dt = 0.1, .steps = 1000});
  } catch (const IntegrationError& error) {
    said = error.what();
  }
  CHECK(said.find("check_gradient(H, z) tells whether the gradient is right") != std::string::npos);
  CHECK(said.find("may converge") == std::string::npos);
  CHECK_FALSE(check_gradient(wrong, PhasePoint<double, 1>(-3, 0.5)).ok());
}

TEST_CASE("Every status has a description, those of failures with a remedy", "[integrate]") {
  const auto failed = [](Status status) {
    Script stepper{.reports = {{.status = status}}};
    Point z(0, 0);
    try {
      integrate(stepper, z, {.dt = 1, .steps = 1});
    } catch (const IntegrationError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  CHECK(failed(Status::no_convergence).find("reduce dt") != std::string::npos);
  CHECK(failed(Status::not_finite).find("check the gradient near this state for a singularity") !=
        std::string::npos);
  CHECK(failed(Status::invalid_state).find("check the initial data") != std::string::npos);
  CHECK(failed(Status::invalid_step).find("give a finite step") != std::string::npos);
  CHECK(failed(Status::no_convergence).find("last correction") == std::string::npos);  // there was none
  CHECK(failed(Status::success).empty());
  CHECK(failed(Status::rounding_limited).empty());
  CHECK(describe(Status::stopped) == "stopped by an observer");
}

TEST_CASE("A run that fails leaves the last good state", "[integrate]") {
  // H = p - 2√(1 - q): q moves on at speed 1 and at t = 1 comes to where the gradient ends.
  auto h =
      make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return p[0] - 2 * std::sqrt(1 - q[0]); },
                                  [](const auto& q, const auto&, auto& dHdq, auto& dHdp) {
                                    dHdq[0] = 1 / std::sqrt(1 - q[0]);
                                    dHdp[0] = 1;
                                  });
  const auto fails = [](auto stepper) {
    typename decltype(stepper)::State raised(Point(0, 0)), stopped(Point(0, 0));
    auto again = stepper;
    typename decltype(stepper)::State last_seen = raised;
    try {
      integrate(stepper, raised, {.dt = 0.03, .steps = 100},
                [&](double, const auto& now) { last_seen = now; });
      FAIL("the run should have failed");
    } catch (const IntegrationError& e) {
      CHECK(e.report().status == Status::not_finite);
      CHECK(e.report().steps > 25);
      CHECK(e.report().steps <= 33);
      CHECK(raised.q()[0] == Approx(e.report().t).margin(0.01));
      CHECK(raised.q()[0] == last_seen.q()[0]);
      CHECK(raised.p()[0] == last_seen.p()[0]);
      const auto report =
          integrate(again, stopped, {.dt = 0.03, .steps = 100, .on_failure = OnFailure::stop});
      CHECK(report.status == Status::not_finite);
      CHECK(report.steps == e.report().steps);
      CHECK(report.t == e.report().t);
    }
    CHECK(raised.q()[0] == stopped.q()[0]);
    CHECK(raised.p()[0] == stopped.p()[0]);
  };
  fails(Semiexplicit(h, schemes::strang()));
  fails(Semiexplicit(h, schemes::strang(), Broyden{}));
  fails(MidpointProjection(h, schemes::strang()));
  fails(GaussLegendre(h));
  fails(Pihajoki(h, schemes::strang()));
  fails(Tao(h, schemes::strang(), 5.0));
}

TEST_CASE("An exception of the gradient passes through, with the last good state", "[integrate]") {
  int left = 20;
  auto h = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                       [&](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                         if (left-- == 0) throw std::domain_error("no gradient");
                                         product.gradient(q, p, dHdq, dHdp);
                                       });
  MidpointProjection three_calls(h, schemes::strang());
  Point z(-3, 0), last_seen(0, 0);
  CHECK_THROWS_AS(integrate(three_calls, z, {.dt = 0.01, .steps = 10},
                            [&](double, const Point& now) { last_seen = now; }),
                  std::domain_error);
  CHECK(left == -1);
  CHECK(z.vector() == last_seen.vector());
  CHECK(z.q()[0] != -3);
}

TEST_CASE("A run: dt = 0, NaN or Inf, and a state of another size", "[integrate]") {
  const auto refuses = [](const auto& stepper) {
    using State = typename std::decay_t<decltype(stepper)>::State;
    using Base = PhasePoint<double, Eigen::Dynamic>;
    Base two(2), three(3);
    two.vector() << 1, 0.5, 0.2, -0.3;
    State state(two), wrong(three);
    for (const double dt : {0.0, std::nan(""), std::numeric_limits<double>::infinity()}) {
      CAPTURE(dt);
      const auto report = failure(stepper, state, dt);
      CHECK(report.status == Status::invalid_step);
      CHECK(report.steps == 0);
      CHECK(report.t == 0);
      CHECK(state.q()[1] == 0.5);
      CHECK(state.p()[1] == -0.3);
    }
    CHECK(failure(stepper, wrong, 0.01).status == Status::invalid_state);
    CHECK(failure(stepper, state, 0.01).steps == 0);  // no failure
    CHECK(failure(stepper, state, 0.01).status == Status::success);
  };
  const systems::NlsLattice<double> h(2);
  refuses(Semiexplicit(h, schemes::strang()));
  refuses(Semiexplicit(h, schemes::strang(), Broyden{}));
  refuses(MidpointProjection(h, schemes::strang()));
  refuses(GaussLegendre(h));
  refuses(GaussLegendre(h, {.solver = StageSolver::newton}));
  refuses(Pihajoki(h, schemes::strang()));
  refuses(Tao(h, schemes::strang(), 5.0));
}

TEST_CASE("A run of the doubled space", "[integrate]") {
  const Point start(-3, 0);
  Point expected = start;
  auto reference = Semiexplicit(product, schemes::sofroniou_spaletta8());
  integrate(reference, expected, {.dt = 0.01, .steps = 50});

  const auto comes_close = [&](auto stepper, std::int64_t gradients) {
    ExtendedPoint state(start);
    Record<double, 1> record;
    Invariants invariants(product);
    double defect = 0;
    const auto report = integrate(stepper, state, {.dt = 0.01, .steps = 50}, record, invariants,
                                  [&](double, const auto& now) { defect = std::max(defect, now.defect()); });
    CHECK(report.status == Status::success);
    CHECK(report.evaluations == 50);
    CHECK(report.gradients == gradients);
    CHECK((state.a.vector() - expected.vector()).norm() < 1e-6);
    CHECK((state.b.vector() - expected.vector()).norm() < 1e-6);
    CHECK(defect > 0);
    // Observers see q and p.
    REQUIRE(record.z.size() == 51);
    CHECK(record.z[50].q() == state.q());
    CHECK(record.z[50].p() == state.p());
    CHECK(record.z[50].q() == state.a.q());
    CHECK(record.z[50].p() == state.b.p());
    CHECK(invariants["energy"].worst > 0);
    CHECK(invariants["energy"].worst < 1e-6);
  };
  comes_close(Pihajoki(product, schemes::yoshida6()), 50 * 15);
  comes_close(Tao(product, schemes::yoshida6(), 5.0), 50 * 21 + 1);  // the last gradient is kept
}

TEST_CASE("A run in another number type", "[integrate]") {
  using Real = long double;
  Semiexplicit stepper(systems::Product<Real>{}, schemes::blanes_moan4<Real>());
  PhasePoint<Real, 1> z(-3, 0);
  Record<Real, 1> record;
  integrate(stepper, z, {.dt = 0.1L, .steps = 5, .t0 = 0.3L}, record);
  REQUIRE(record.t.size() == 6);
  CHECK(record.t[1] == 0.3L + 0.1L);
  CHECK(record.z[5].vector() == z.vector());
}

TEST_CASE("A late run in more digits than a double's goes on from its first part", "[integrate]") {
  const auto h = make_hamiltonian<long double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0];
        dHdp[0] = p[0];
      });
  for (int k = 0; k < 20; ++k) {
    Semiexplicit stepper(h, schemes::strang<long double>());
    PhasePoint<long double, 1> z(-1.0L, 0.0L);
    IntegrationOptions<long double> options{.dt = 1e-5L, .steps = 10, .t0 = 2.4e11L + 1.7e-6L * k};
    options.done = integrate(stepper, z, options);
    options.steps = 20;
    CHECK_NOTHROW(integrate(stepper, z, options));
  }
}

TEST_CASE("A dt beside which the time is nothing takes one step to it", "[integrate]") {
  GaussLegendre stepper(systems::Product<double>{}, {.stages = 1});
  PhasePoint<double, 1> z(1, 0);
  CHECK(integrate(stepper, z, {.dt = 1e10, .t_end = 1e-320}).steps == 1);
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = -1e10, .t_end = 1e-320}), std::invalid_argument);
}

TEST_CASE("A run that goes on from a report with another dt is refused", "[integrate]") {
  Semiexplicit stepper(systems::Product<double>(), schemes::strang<double>());
  PhasePoint<double, 1> z(-3, 0);
  const auto done = integrate(stepper, z, {.dt = 0.1, .steps = 100});
  CHECK(done.dt == 0.1);
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.05, .steps = 200, .done = done}), std::invalid_argument);
  CHECK(integrate(stepper, z, {.dt = 0.1, .steps = 200, .done = done}).t == Approx(20));
}

/// Leaves the state where its failed step came to; one longer than that fails.
struct LeavesFailed {
  using Scalar = double;
  using State = Point;
  double longest = 0.05;
  StepReport step(Point& z, const double& dt) {
    z.q()[0] += dt;
    return {.status = dt > longest ? Status::no_convergence : Status::success};
  }
};

TEST_CASE("Parts of a failed step begin at the last good state, wherever the failed step left it",
          "[integrate]") {
  Point z(0, 0);
  const auto report = integrate(LeavesFailed{}, z, {.dt = 0.08, .steps = 10, .subdivide = 4});
  CHECK(report.subdivided == 10);
  CHECK(z.q()[0] == Approx(report.t).epsilon(1e-14));
  z = Point(0, 0);
  CHECK_THROWS_AS(integrate(LeavesFailed{.longest = 1e-9}, z, {.dt = 0.08, .steps = 10, .subdivide = 4}),
                  IntegrationError);
  CHECK(z.q()[0] == 0);
}

TEST_CASE("Where the rest of a step behind an event fails, the state is that of the event", "[integrate]") {
  const auto kick = [](double, Point& at) { at.p()[0] += 1; };
  for (const Status said : {Status::no_convergence, Status::stopped}) {
    struct FailsShort {
      using Scalar = double;
      using State = Point;
      Status said;
      StepReport step(Point& z, const double& dt) {
        z.q()[0] += dt;
        return {.status = z.p()[0] > 0 ? said : Status::success};
      }
    };
    const auto drift = make_hamiltonian<double, 1>([](const auto&, const auto& p) { return p[0]; },
                                                   [](const auto&, const auto&, auto& dHdq, auto& dHdp) {
                                                     dHdq[0] = 0;
                                                     dHdp[0] = 1;
                                                   });
    auto watch = events(drift, on_event([](const auto& q, const auto&) { return q[0] - 0.25; }, kick));
    Point z(0, 0);
    const auto report =
        integrate(FailsShort{said}, z, {.dt = 0.1, .steps = 10, .on_failure = OnFailure::stop}, watch);
    CHECK_FALSE(report.ok());
    CHECK(report.at_event);
    CHECK(z.q()[0] == Approx(0.25));
    CHECK(z.p()[0] == 1);
  }
}

/// A solver that says what only a run may.
struct Stops {
  template <class Vec>
  struct Workspace {
    Workspace(const Stops&, Eigen::Index) {}
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual&, Vec&, Workspace<Vec>&) const {
    return {.status = Status::stopped, .evaluations = 1};
  }
};

TEST_CASE("A step or a solver that says `stopped` has failed", "[integrate]") {
  const auto check = [](auto stepper) {
    Point z(-3, 0.5);
    auto again = stepper;
    const auto report =
        integrate(stepper, z, {.dt = 0.1, .steps = 10, .on_failure = OnFailure::stop, .subdivide = 2});
    CHECK_FALSE(report.ok());
    CHECK(report.status == Status::invalid_stepper);
    CHECK(report.steps == 0);
    CHECK(z.vector() == Point(-3, 0.5).vector());
    CHECK(says(complaint<IntegrationError>([&] { integrate(again, z, {.dt = 0.1, .steps = 10}); }),
               "said `stopped`, which is for a run to say"));
  };
  check(Script{.reports = std::vector(20, StepReport{.status = Status::stopped})});
  check(Semiexplicit(product, schemes::strang(), Stops{}));
  Ensemble ensemble(product, std::vector(2, Point(-3, 0.5)), schemes::strang(), Stops{});
  const auto all = ensemble.run({.dt = 0.1, .steps = 10});
  CHECK(all.failed == 2);
  CHECK_FALSE(all.ok());
}

}  // namespace test_run
