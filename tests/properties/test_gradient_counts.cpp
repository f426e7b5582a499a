#include "catch.hpp"

#include <cstdint>
#include <memory>
#include <string>

#include <semiexplicit/systems.hpp>

#include "methods.hpp"

namespace test_gradient_counts {

// A gradient call is the unit of work: what the reports say must be what was called.

namespace {

using namespace semiexplicit;

/// The NLS lattice, which counts how often its gradient is called. Copies count together.
struct Counting {
  using Scalar = double;
  static constexpr int Dof = 4;

  void gradient(In<double, 4> q, In<double, 4> p, Out<double, 4> dHdq, Out<double, 4> dHdp) const {
    ++*calls;
    lattice.gradient(q, p, dHdq, dHdp);
  }

  systems::NlsLattice<double, 4> lattice;
  std::shared_ptr<std::int64_t> calls = std::make_shared<std::int64_t>(0);
};

const PhasePoint<double, 4> start({1, 0.5, -0.3, 0.1}, {0.4, -0.7, 0.2, 0.9});

}  // namespace

TEST_CASE("The reports of steps and runs count the gradient calls", "[counts]") {
  const Counting h;
  methods::for_each(h, {}, [&](const methods::Claim& claim, auto stepper) {
    CAPTURE(claim.name);
    typename decltype(stepper)::State state(start);
    CHECK(*h.calls == 0);  // building one costs none
    for (int n = 0; n < 3; ++n) {
      *h.calls = 0;
      const StepReport report = stepper.step(state, 0.05);
      REQUIRE(report.ok());
      CHECK(report.gradients == *h.calls);
      CHECK(report.evaluations >= 1);
    }
    *h.calls = 0;
    std::int64_t evaluations = 0;
    const IntegrationReport run =
        integrate(stepper, state, {.dt = 0.05, .steps = 20},
                  [&](double, const auto&, const StepReport& step) { evaluations += step.evaluations; });
    CHECK(run.gradients == *h.calls);
    CHECK(run.evaluations == evaluations);
    *h.calls = 0;
  });
}

TEST_CASE("A sweep costs one gradient call a kick", "[counts]") {
  const Counting h;
  const auto of = [&](auto stepper) {
    typename decltype(stepper)::State state(start);
    *h.calls = 0;
    const StepReport report = stepper.step(state, 0.01);
    REQUIRE(report.ok());
    CHECK(*h.calls == report.gradients);
    CHECK(report.gradients % report.evaluations == 0);
    return report.gradients / report.evaluations;
  };
  struct Row {
    const char* name;
    int kicks;
  };
  for (const Row& row : {Row{"strang", 3}, Row{"mclachlan2", 5}, Row{"triple_jump4", 7}, Row{"suzuki4", 11},
                         Row{"blanes_moan4", 13}, Row{"yoshida6", 15}, Row{"triple_jump6", 19},
                         Row{"blanes_moan6", 21}, Row{"low_defect6_s13", 27}, Row{"suzuki_umeno8", 31},
                         Row{"low_defect8_s20", 41}, Row{"sofroniou_spaletta10", 71}}) {
    CAPTURE(row.name);
    const auto s = schemes::by_name(row.name);
    CHECK(of(Semiexplicit(h, s)) == row.kicks);
    CHECK(of(Semiexplicit(h, s, Broyden{})) == row.kicks);
    CHECK(of(MidpointProjection(h, s)) == row.kicks);
    CHECK(of(Pihajoki(h, s)) == row.kicks);
  }
  CHECK(of(Tao(h, schemes::strang(), 10.0)) == 4);
  CHECK(of(Tao(h, schemes::triple_jump(4), 10.0)) == 10);
  CHECK(of(Tao(h, schemes::yoshida6(), 10.0)) == 22);
}

TEST_CASE("Tao's map keeps the last gradient of a step for the next one, and for no other point",
          "[counts]") {
  const Counting h;
  Tao stepper(h, schemes::triple_jump(4), 10.0);
  ExtendedPoint<double, 4> zeta(start), by_fresh_ones(start);
  for (const int calls : {10, 9, 9, 9}) {
    const StepReport report = stepper.step(zeta, 0.01);
    REQUIRE(report.ok());
    CHECK(report.gradients == calls);
    REQUIRE(Tao(h, schemes::triple_jump(4), 10.0).step(by_fresh_ones, 0.01).ok());
    CHECK(zeta.a.vector() == by_fresh_ones.a.vector());
    CHECK(zeta.b.vector() == by_fresh_ones.b.vector());
  }
  CHECK(stepper.step(zeta, -0.01).gradients == 9);  // the step may change, the point may not
  ExtendedPoint<double, 4> other(start);
  CHECK(stepper.step(other, 0.01).gradients == 10);
  CHECK(stepper.step(other, 0.0).status == Status::invalid_step);
  CHECK(stepper.step(other, 0.01).gradients == 10);
}

TEST_CASE("A step with one evaluation costs one sweep", "[counts]") {
  const Counting h;
  PhasePoint<double, 4> z = start;
  Semiexplicit stepper(h, schemes::blanes_moan6(), SimplifiedNewton{.stop = StoppingRule::paper(1e-3)});
  const StepReport report = stepper.step(z, 0.01);
  CHECK(report.evaluations == 1);
  CHECK(report.rate == 0);
  CHECK(*h.calls == 21);
}

TEST_CASE("A failed step's calls are counted, too", "[counts]") {
  const Counting h;
  PhasePoint<double, 4> z = start;
  Semiexplicit stepper(h, schemes::strang(),
                       SimplifiedNewton{.stop = StoppingRule::paper(1e-15), .max_iterations = 2});
  const StepReport report = stepper.step(z, 0.05);
  CHECK(report.status == Status::no_convergence);
  CHECK(report.evaluations == 2);
  CHECK(report.gradients == 6);
  CHECK(*h.calls == 6);
  *h.calls = 0;
  const auto run = integrate(stepper, z, {.dt = 0.05, .steps = 10, .on_failure = OnFailure::stop});
  CHECK(run.steps == 0);
  CHECK(run.gradients == 6);
  CHECK(run.evaluations == 2);
  CHECK(*h.calls == 6);
}

TEST_CASE("Refused arguments cost nothing", "[counts]") {
  const Counting h;
  methods::for_each(h, {}, [&](const methods::Claim& claim, auto stepper) {
    CAPTURE(claim.name);
    typename decltype(stepper)::State state(start);
    const StepReport report = stepper.step(state, 0.0);
    CHECK_FALSE(report.ok());
    CHECK(report.gradients == 0);
    CHECK(report.evaluations == 0);
    CHECK(*h.calls == 0);
  });
}

}  // namespace test_gradient_counts
