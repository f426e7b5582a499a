#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_integrate {

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

Semiexplicit<systems::Product<double>> product_stepper() {
  return {systems::Product<double>{}, schemes::blanes_moan4()};
}
const Point start(-1, 0.5);

/// Two thirds of the way to infinity: H = q p², with q' = 2qp, p' = -p², so that p = 1/(1/p₀ + t) for any q.
auto blowing_up() {
  return make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return q[0] * p[0] * p[0]; },
                                     [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                       dHdq[0] = p[0] * p[0];
                                       dHdp[0] = 2 * q[0] * p[0];
                                     });
}

}  // namespace

TEST_CASE("Times are t0 + n dt to the last bit", "[integrate]") {
  auto stepper = product_stepper();
  for (const double dt : {0.001, -0.003}) {
    Point z = start;
    std::vector<double> times;
    const auto report = integrate(stepper, z, {.dt = dt, .steps = 1000, .t0 = 0.7},
                                  [&](double t, const Point&) { times.push_back(t); });
    REQUIRE(times.size() == 1001);
    bool exact = true;
    for (std::size_t n = 0; n < times.size(); ++n)
      exact = exact && times[n] == 0.7 + static_cast<double>(n) * dt;
    CHECK(exact);
    CHECK(report.t == 0.7 + 1000 * dt);
    CHECK(report.steps == 1000);
    CHECK(report.status == Status::success);
    CHECK(report.ok());
    CHECK(report.seconds >= 0);
  }
}

TEST_CASE("A run is its steps", "[integrate]") {
  auto stepper = product_stepper(), other = product_stepper();
  Point z = start, expected = start;
  double largest = 0;
  std::int64_t evaluations = 0, gradients = 0;
  for (int n = 0; n < 50; ++n) {
    const StepReport step = other.step(expected, 0.02);
    largest = std::max(largest, step.correction);
    evaluations += step.evaluations;
    gradients += step.gradients;
  }
  const auto report = integrate(stepper, z, {.dt = 0.02, .steps = 50});
  CHECK(z.vector() == expected.vector());
  CHECK(report.max_correction == largest);
  CHECK(report.evaluations == evaluations);
  CHECK(report.gradients == gradients);
  CHECK(report.last.evaluations > 0);
}

TEST_CASE("No steps are a run, a negative number of steps is none", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  int calls = 0;
  const auto report =
      integrate(stepper, z, {.dt = 0.1, .steps = 0, .t0 = 2}, [&](double, const Point&) { ++calls; });
  CHECK(report.ok());
  CHECK(report.steps == 0);
  CHECK(report.t == 2);
  CHECK(calls == 1);
  CHECK(z.vector() == start.vector());
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.1, .steps = -1}), std::invalid_argument);
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.1, .steps = 1, .t0 = NAN}), std::invalid_argument);
}

TEST_CASE("Observers of two or three arguments, several at once, in order", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  std::string order;
  std::int64_t gradients = 0;
  auto mutable_observer = [count = 0](double, const Point&) mutable { ++count; };
  integrate(
      stepper, z, {.dt = 0.01, .steps = 3}, [&](double, const Point&) { order += 'a'; },
      [&](double t, const Point& now, const StepReport& step) {
        order += 'b';
        gradients += step.gradients;
        if (t == 0) {
          CHECK(step.gradients == 0);  // no step yet
          CHECK(now.vector() == start.vector());
        } else {
          CHECK(step.gradients > 0);
        }
      },
      mutable_observer, [&](const auto&, const auto&) { order += 'c'; });
  CHECK(order == "abcabcabcabc");
  CHECK(gradients > 0);
}

TEST_CASE("An observer that returns false ends the run there", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  int others = 0;
  const auto report = integrate(
      stepper, z, {.dt = 0.01, .steps = 100}, [](double t, const Point&) { return t < 0.045; },
      [&](double, const Point&) { ++others; });
  CHECK(report.status == Status::stopped);
  CHECK(report.ok());
  CHECK(report.steps == 5);
  CHECK(report.t == 5 * 0.01);
  CHECK(others == 6);  // every observer hears of every step, the last included

  // Already at the start.
  Point y = start;
  const auto none = integrate(stepper, y, {.dt = 0.01, .steps = 100},
                              [](double, const Point&, const StepReport&) { return false; });
  CHECK(none.status == Status::stopped);
  CHECK(none.steps == 0);
  CHECK(y.vector() == start.vector());

  // One that returns true, or something that is not a bool's business, goes on.
  CHECK(integrate(stepper, y, {.dt = 0.01, .steps = 7}, [](double, const Point&) { return true; }).steps ==
        7);
  CHECK(integrate(stepper, y, {.dt = 0.01, .steps = 7}, [](double, const Point&) {
          return std::string("no");
        }).steps == 7);
}

TEST_CASE("every() hands on each n-th call, the first included", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  std::vector<double> times;
  Record<double, 1> record;
  integrate(stepper, z, {.dt = 0.5e-2, .steps = 10},
            every(3, [&](double t, const Point&) { times.push_back(t); }), every(10, record));
  CHECK(times == std::vector<double>{0, 3 * 0.5e-2, 6 * 0.5e-2, 9 * 0.5e-2});
  CHECK(record.t.size() == 2);  // the named one is referred to, not copied

  int calls = 0;
  const auto report = integrate(stepper, z, {.dt = 0.01, .steps = 10},
                                every(4, [&](double, const Point&) { return ++calls < 2; }));
  CHECK(report.status == Status::stopped);
  CHECK(report.steps == 4);
  for (const int n : {0, -1}) CHECK_THROWS_AS(every(n, record), std::invalid_argument);
}

TEST_CASE("A failed step ends the run at the last good state", "[integrate]") {
  // p₀ = -1: p = 1/(t - 1) goes to -∞ at t = 1.
  Semiexplicit stepper(blowing_up(), schemes::strang());
  const Point begin(0.1, -1);
  Point z = begin;
  IntegrationReport seen;
  std::string text;
  Record<double, 1> record;
  try {
    integrate(stepper, z, {.dt = 0.01, .steps = 10'000, .t0 = 5}, record);
  } catch (const IntegrationError& error) {
    seen = error.report();
    text = error.what();
  }
  REQUIRE(seen.steps > 50);
  REQUIRE(seen.steps < 200);
  CHECK_FALSE(seen.ok());
  CHECK((seen.status == Status::no_convergence || seen.status == Status::not_finite));
  CHECK(seen.status == seen.last.status);
  CHECK(seen.t == 5 + static_cast<double>(seen.steps) * 0.01);
  CHECK(seen.last.evaluations > 0);
  CHECK(z.vector() == record.z.back().vector());
  CHECK(z.vector().allFinite());
  CHECK(static_cast<std::int64_t>(record.z.size()) == seen.steps + 1);
  CHECK(says(text, "step " + std::to_string(seen.steps + 1) + " failed at t = "));
  CHECK(says(text, "(dt = 0.01"));
  CHECK(says(text, describe(seen.status)));
  CHECK(says(text, "last correction"));
  CHECK(says(text, "after " + std::to_string(seen.last.evaluations) + " evaluations"));

  // The same without an exception.
  Point y = begin;
  Semiexplicit again(blowing_up(), schemes::strang());
  const auto report =
      integrate(again, y, {.dt = 0.01, .steps = 10'000, .on_failure = OnFailure::stop, .t0 = 5});
  CHECK(report.status == seen.status);
  CHECK(report.steps == seen.steps);
  CHECK(report.t == seen.t);
  CHECK(report.gradients == seen.gradients);
  CHECK(y.vector() == z.vector());
}

TEST_CASE("Wrong arguments of a run fail at its first step, in words", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  const auto message = [&](double dt) -> std::string {
    try {
      integrate(stepper, z, {.dt = dt, .steps = 1});
    } catch (const IntegrationError& error) {
      return error.what();
    }
    return "nothing was thrown";
  };
  CHECK(says(message(0), "dt is zero, NaN or Inf"));
  CHECK(says(message(0), "step 1 failed"));
  z.q()[0] = std::nan("");
  CHECK(says(message(0.1), "holds NaN or Inf"));
  CHECK(integrate(stepper, z, {.dt = 0.1, .steps = 1, .on_failure = OnFailure::stop}).status ==
        Status::invalid_state);
}

TEST_CASE("An exception of an observer passes through, with the state where it was", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  Record<double, 1> record;
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.01, .steps = 10}, record,
                            [](double t, const Point&) {
                              if (t > 0.035) throw std::length_error("enough");
                            }),
                  std::length_error);
  CHECK(record.z.size() == 5);
  CHECK(z.vector() == record.z.back().vector());
}

TEST_CASE("Back and forth ends where it began", "[integrate]") {
  auto stepper = product_stepper();
  Point z = start;
  const auto there = integrate(stepper, z, {.dt = 0.01, .steps = 100});
  const auto back = integrate(stepper, z, {.dt = -0.01, .steps = 100, .t0 = there.t});
  CHECK(back.t == Approx(0).margin(1e-15));
  CHECK((z.vector() - start.vector()).norm() <= 1e-12);
}

TEST_CASE("The doubled maps are integrated on extended points", "[integrate]") {
  ExtendedPoint<double, 1> zeta(start);
  Pihajoki pihajoki(systems::Product<double>{}, schemes::strang());
  Record<double, 1> record;
  Invariants errors(systems::Product<double>{});
  integrate(pihajoki, zeta, {.dt = 0.01, .steps = 10}, record, errors,
            [&](double t, const auto& now) { CHECK((now.defect() == 0) == (t == 0)); });
  CHECK(record.z.size() == 11);
  CHECK(record.z.back().q() == zeta.q());
  CHECK(record.z.back().p() == zeta.p());
  CHECK(errors["energy"].worst > 0);
}

TEST_CASE("A run ends at t_end exactly, with the fewest equal steps no longer than dt", "[integrate]") {
  const systems::Product<double> H;
  const PhasePoint<double, 1> z0(-3, 0);
  const auto run = [&](IntegrationOptions<double> options, PhasePoint<double, 1>& z) {
    Semiexplicit stepper(H, schemes::strang());
    return integrate(stepper, z, options);
  };
  auto z = z0;
  auto report = run({.dt = 0.03, .t_end = 1}, z);
  CHECK(report.t == 1);
  CHECK(report.steps == 34);
  CHECK(report.dt == 1.0 / 34);
  auto by_steps = z0;
  run({.dt = 1.0 / 34, .steps = 34}, by_steps);
  CHECK(z.vector() == by_steps.vector());

  // 0.1 is no binary fraction, and 1 / 0.1 ten steps all the same; so at a late time, and back.
  z = z0;
  CHECK(run({.dt = 0.1, .t_end = 1}, z).steps == 10);
  CHECK(run({.dt = 1e-3, .t_end = 100}, z).steps == 100'000);
  report = run({.dt = 0.1, .t0 = 1e9, .t_end = 1e9 + 1}, z);
  CHECK(report.steps == 10);
  CHECK(report.t == 1e9 + 1);
  report = run({.dt = -0.3, .t_end = -1}, z);
  CHECK(report.steps == 4);
  CHECK(report.dt == -0.25);
  CHECK(run({.dt = 0.1, .t0 = 2, .t_end = 2}, z).steps == 0);

  CHECK(refuses([&] { run({.dt = 0.1, .t_end = -1}, z); }, "the sign of t_end - t0"));
  CHECK(refuses([&] { run({.dt = 0, .t_end = 1}, z); }, "dt must be finite and not zero"));
  CHECK(refuses([&] { run({.dt = 0.1, .steps = 5, .t_end = 1}, z); }, "steps or t_end, not both"));
  CHECK(refuses([&] { run({.dt = 0.1}, z); }, "give steps or t_end, or there is no end"));
  for (const double no_time : {std::nan(""), HUGE_VAL})
    CHECK(refuses([&] { run({.dt = 0.1, .t_end = no_time}, z); }, "t_end and t0 finite"));
  CHECK(refuses([&] { run({.dt = 1e-300, .t_end = 1}, z); }, "more than 9e18 steps"));
  CHECK(refuses([&] { run({.dt = 1e308, .steps = 10}, z); }, "t0 + steps dt is not finite"));

  // The rest of a run that was stopped: the same options, and what is done.
  z = z0;
  Semiexplicit stepper(H, schemes::strang());
  const IntegrationOptions<double> whole{.dt = 0.03, .t_end = 1};
  const auto part = integrate(stepper, z, whole, [](double t, const auto&) { return t < 0.5; });
  CHECK(part.status == Status::stopped);
  auto rest = whole;
  rest.done = part;
  CHECK(integrate(stepper, z, rest).t == 1);
  CHECK(z.vector() == by_steps.vector());

  // Of the same start.
  z = z0;
  const auto early = run({.dt = 0.1, .t0 = 5, .t_end = 6}, z);
  CHECK(refuses([&] { run({.dt = 0.1, .t_end = 7, .done = early}, z); }, "give the t0 that it began with"));
  CHECK(refuses([&] { run({.dt = 0.1, .t0 = 6, .t_end = 7, .done = early}, z); }, "began with"));
  CHECK(run({.dt = 0.1, .t0 = 5, .t_end = 7, .done = early}, z).steps == 20);
}

TEST_CASE("A run from any t0 goes on with the dt of its report to a later t_end") {
  for (const double t0 : {0.0, 1000.1, -3.7, 1e6 + 0.3, 12345.678}) {
    for (const double dt : {0.1, 0.037, -0.3}) {
      for (int n = 5; n < 40; ++n) {
        CAPTURE(t0, dt, n);
        Semiexplicit stepper{systems::Product<double>(), schemes::strang<double>()};
        PhasePoint<double, 1> z(-3, 0);
        const auto part = integrate(stepper, z, {.dt = dt, .t0 = t0, .t_end = t0 + n * 0.77 * dt});
        const auto all = integrate(stepper, z,
                                   {.dt = part.dt,
                                    .t0 = t0,
                                    .t_end = t0 + static_cast<double>(part.steps + 7) * part.dt,
                                    .done = part});
        CHECK(all.steps == part.steps + 7);
        CHECK(all.dt == part.dt);
      }
    }
  }
}

}  // namespace test_integrate
