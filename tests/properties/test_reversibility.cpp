#include "catch.hpp"

#include <cmath>

#include <semiexplicit/systems.hpp>

#include "methods.hpp"

namespace test_reversibility {

// A step forth and a step back lead to where they began.

namespace {

using namespace semiexplicit;

const systems::NlsLattice<double, 4> lattice;
const PhasePoint<double, 4> start({1, 0.5, -0.3, 0.1}, {0.4, -0.7, 0.2, 0.9});

/// How far from the start n steps forth and n back end.
template <class Stepper>
double way_off(Stepper stepper, double dt, int steps) {
  typename Stepper::State state(start);
  integrate(stepper, state, {.dt = dt, .steps = steps});
  CHECK((state.q() - start.q()).norm() >= 0.01);  // it went somewhere
  integrate(stepper, state, {.dt = -dt, .steps = steps});
  return std::sqrt((state.q() - start.q()).squaredNorm() + (state.p() - start.p()).squaredNorm());
}

}  // namespace

TEST_CASE("A step back undoes a step", "[reversibility]") {
  methods::for_each(lattice, {}, [](const methods::Claim& claim, const auto& stepper) {
    if (!claim.symmetric) return;
    CAPTURE(claim.name);
    CHECK(way_off(stepper, 0.05, 1) <= 1e-14);
    CHECK(way_off(stepper, -0.04, 1) <= 1e-14);
    CHECK(way_off(stepper, 0.05, 50) <= 1e-12);
  });
}

TEST_CASE("With the default stopping rule a step back undoes a step to the rule's accuracy",
          "[reversibility]") {
  methods::Choice choice;
  choice.stop = StoppingRule::product();
  methods::for_each_of_phase_space(lattice, choice, [](const methods::Claim& claim, const auto& stepper) {
    if (!claim.symmetric) return;
    CAPTURE(claim.name);
    CHECK(way_off(stepper, 0.05, 1) <= 1e-13);
    CHECK(way_off(stepper, 0.05, 50) <= 1e-11);
  });
}

TEST_CASE("The midpoint projection is not symmetric", "[reversibility]") {
  CHECK(way_off(MidpointProjection(lattice, schemes::strang()), 0.05, 1) >= 1e-7);
}

}  // namespace test_reversibility
