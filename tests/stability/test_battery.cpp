// The battery: every case of benchmarks/stability/cases.hpp for a while, with two solvers, and what has no
// figure there. Bad gradients (NaN, Inf, exceptions at any kick), wrong states and equilibria are in
// tests/steppers/test_failures.cpp.

#include "catch.hpp"

#include <cmath>
#include <limits>
#include <string>

#include <semiexplicit/systems.hpp>

#include "../../benchmarks/stability/cases.hpp"

namespace test_battery {

namespace {

using namespace stability;

struct Seen {
  IntegrationReport report;
  double energy = 0, invariant = 0;  ///< worst relative errors
};

/// A case with this solver for the time of the tests.
template <class H, class Solver>
Seen run_case(const Case<H>& hard, const Solver& solver) {
  using Scalar = typename H::Scalar;
  Semiexplicit stepper(hard.hamiltonian, schemes::low_defect6_s13<Scalar>(), solver);
  auto z = hard.start;
  Invariants<Scalar, H::Dof> errors;
  errors.add("energy", [&](const auto& q, const auto& p) { return energy_of(hard.hamiltonian, q, p); });
  if (hard.invariant) errors.add("invariant", hard.invariant);
  Seen seen;
  seen.report = integrate(stepper, z,
                          {.dt = static_cast<Scalar>(hard.dt),
                           .steps = static_cast<std::int64_t>(std::round(hard.t_test / hard.dt)),
                           .on_failure = OnFailure::stop},
                          every(4, errors));
  seen.energy = static_cast<double>(errors["energy"].worst);
  if (hard.invariant) seen.invariant = static_cast<double>(errors["invariant"].worst);
  return seen;
}

}  // namespace

TEST_CASE("The battery of hard cases", "[stability][long]") {
  for_each_case([](const auto& hard) {
    CAPTURE(hard.name);
    const Seen simple = run_case(hard, SimplifiedNewton{}), robust = run_case(hard, Robust{});
    CHECK(robust.report.ok());
    CHECK(robust.energy <= hard.energy_error);
    CHECK(robust.invariant <= hard.invariant_error);
    if (hard.name == "NLS, edge of convergence") {
      // It gives up here, and says what would do.
      CHECK(simple.report.status == Status::no_convergence);
      CHECK(simple.report.last.advised_step(hard.dt) < hard.dt);
    } else {
      CHECK(simple.report.ok());
    }
    CHECK(simple.energy <= hard.energy_error);
    CHECK(simple.invariant <= hard.invariant_error);
  });
}

TEST_CASE("A step across a singularity is refused, or can be told by the energy", "[stability]") {
  // H = p²/2 - 1/|q| on the line: nothing can be right there, but nothing may be lost either.
  const auto coulomb = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - 1 / std::abs(q[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 1 / (q[0] * std::abs(q[0]));
        dHdp[0] = p[0];
      });
  for (const double dt : {0.1, 0.01, 0.001}) {
    CAPTURE(dt);
    Semiexplicit stepper(coulomb, schemes::low_defect6_s13());
    PhasePoint<double, 1> z(1, 0), last = z;
    const double e0 = coulomb.energy(z.q(), z.p());
    const auto good = [&](double, const auto& at) {
      if (!(std::abs(coulomb.energy(at.q(), at.p()) / e0 - 1) < 1e-3)) return false;
      last = at;
      return true;
    };
    const auto report =
        integrate(stepper, z, {.dt = dt, .steps = 20'000, .on_failure = OnFailure::stop}, good);
    CHECK(report.status != Status::success);  // it falls in at t = 1.11
    CHECK(report.t < 1.2);
    CHECK(last.q()[0] > 0);
    CHECK(z.vector().allFinite());
    if (report.status != Status::stopped) CHECK(z.vector() == last.vector());
    // The stepper is as good as new.
    PhasePoint<double, 1> again(1, 0), fresh(1, 0);
    Semiexplicit other(coulomb, schemes::low_defect6_s13());
    REQUIRE(stepper.step(again, 0.001).ok());
    REQUIRE(other.step(fresh, 0.001).ok());
    CHECK(again.vector() == fresh.vector());
  }
}

TEST_CASE("Exactly on a singularity the step is refused", "[stability]") {
  const systems::PointVortices<double, 2> h({1, 1});
  auto z = h.phase_point({0.5, 0.5}, {0.5, 0.5});
  const auto before = z;
  Semiexplicit stepper(h, schemes::strang(), Robust{});
  const auto report = stepper.step(z, 0.01);
  CHECK(report.status == Status::not_finite);
  CHECK(z.vector() == before.vector());
}

TEST_CASE("There and back again: negative steps undo a chaotic run", "[stability]") {
  const DoublePendulum h;
  const PhasePoint<double, 2> start({1.8, 2.2}, {0, 0});
  auto z = start;
  Semiexplicit stepper(h, schemes::low_defect6_s13(), SimplifiedNewton{.stop = StoppingRule::product(1e-24)});
  integrate(stepper, z, {.dt = 0.05, .steps = 400});
  CHECK((z.vector() - start.vector()).norm() > 0.5);
  integrate(stepper, z, {.dt = -0.05, .steps = 400});
  CHECK((z.vector() - start.vector()).norm() < 1e-9);  // 1e-16, grown by the chaos of both ways
}

TEST_CASE("A hundred thousand degrees of freedom", "[stability]") {
  const systems::NlsLattice<double> h(100'000);
  auto z = random_lattice(100'000, 1);
  const double e0 = h.energy(z.q(), z.p()), m0 = z.vector().squaredNorm();
  Semiexplicit stepper(h, schemes::low_defect4_s7());
  integrate(stepper, z, {.dt = 0.02, .steps = 10});
  CHECK(std::abs(h.energy(z.q(), z.p()) / e0 - 1) < 1e-7);
  CHECK(std::abs(z.vector().squaredNorm() / m0 - 1) < 1e-13);
}

}  // namespace test_battery
