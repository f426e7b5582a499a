// Steps that do not resolve the fastest motion: the solvers that survive them, what they say, and what
// integrate() can do.

#include "catch.hpp"

#include <cmath>
#include <complex>
#include <memory>
#include <stdexcept>
#include <string>

#include <Eigen/Eigenvalues>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../../benchmarks/stability/stiff_lattice.hpp"

namespace test_large_steps {

namespace {

using namespace semiexplicit;
using stability::StiffLattice;

/// H = ½ zᵀ S z with a positive definite S that is not diagonal: a skewed oscillator.
struct Quadratic {
  using Scalar = double;
  static constexpr int Dof = 1;
  double qq, qp, pp;
  double frequency() const { return std::sqrt(qq * pp - qp * qp); }
  double energy(In<double, 1> q, In<double, 1> p) const {
    return (qq * q[0] * q[0] + pp * p[0] * p[0]) / 2 + qp * q[0] * p[0];
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = qq * q[0] + qp * p[0];
    dHdp[0] = qp * q[0] + pp * p[0];
  }
};

/// The step's matrix for a linear system.
template <class S>
Eigen::Matrix2d matrix_of(S stepper, double dt) {
  Eigen::Matrix2d matrix;
  for (int i = 0; i < 2; ++i) {
    PhasePoint<double, 1> z(i == 0, i == 1);
    REQUIRE(stepper.step(z, dt).ok());
    matrix.col(i) = z.vector();
  }
  return matrix;
}

}  // namespace

TEST_CASE("Solved exactly, the linear oscillator stays on the unit circle at steps that resolve nothing",
          "[stability]") {
  for (const Quadratic& h : {Quadratic{1, 0, 1}, Quadratic{3, 1, 1}, Quadratic{100, -2, 0.5}})
    for (const char* name : {"strang", "triple_jump4", "suzuki4", "blanes_moan4", "blanes_moan6"})
      for (const double angle : {0.5, 1.7, 2.5, 4.0, 7.0, 12.0}) {  // radians a step
        if (angle > 7 && name != std::string("strang")) continue;   // kicks so large that rounding decides
        CAPTURE(h.qq, name, angle);
        const double dt = angle / h.frequency();
        const NewtonKrylov solver{.stop = StoppingRule::paper(1e-10)};
        const Eigen::Matrix2d m = matrix_of(Semiexplicit(h, schemes::by_name(name), solver), dt);
        CHECK(std::abs(m.determinant() - 1) <= 1e-7);
        const Eigen::Vector2cd values = m.eigenvalues();
        CHECK(std::abs(values[0]) <= 1 + 1e-6);
        CHECK(std::abs(values[1]) <= 1 + 1e-6);
      }
}

TEST_CASE("Simplified Newton gives up near 1.85 radians a step with Strang, the others go on",
          "[stability][long]") {
  const Quadratic h{1, 0, 1};
  const auto survives = [&](const auto& solver, double dt) {
    Semiexplicit stepper(h, schemes::strang(), solver);
    PhasePoint<double, 1> z(1, 0);
    const auto run = integrate(stepper, z, {.dt = dt, .steps = 2000, .on_failure = OnFailure::stop});
    return run.ok() && std::abs(h.energy(z.q(), z.p()) / 0.5 - 1) < 1e-2 * std::pow(1 + dt, 8);
  };
  CHECK(survives(SimplifiedNewton{.max_iterations = 1000}, 1.75));
  CHECK_FALSE(survives(SimplifiedNewton{.max_iterations = 1000}, 1.95));
  for (const double dt : {1.75, 1.95, 3.0, 6.0}) {
    CAPTURE(dt);
    CHECK(survives(Broyden{}, dt));
    CHECK(survives(NewtonKrylov{}, dt));
    CHECK(survives(Robust{}, dt));
  }
}

TEST_CASE("A stiff lattice, frequencies over four decades, ten radians a step for the fastest",
          "[stability][long]") {
  const StiffLattice h;
  const double dt = 0.01;
  const auto run = [&](const auto& solver, double& worst) {
    Semiexplicit stepper(h, schemes::strang(), solver);
    auto z = StiffLattice::start();
    Invariants energy(h);
    const auto report =
        integrate(stepper, z, {.dt = dt, .steps = 2000, .on_failure = OnFailure::stop}, energy);
    worst = energy["energy"].worst;
    return report;
  };
  double worst = 0;
  CHECK_FALSE(run(SimplifiedNewton{}, worst).ok());
  const auto by_krylov = run(NewtonKrylov{}, worst);
  CHECK(by_krylov.ok());
  CHECK(worst < 1e-5);
  const auto by_robust = run(Robust{}, worst);
  CHECK(by_robust.ok());
  CHECK(by_robust.last.escalations >= 1);
  CHECK(worst < 1e-5);
}

TEST_CASE("Robust costs nothing where simplified Newton does, and says who made a step", "[stability]") {
  const systems::NlsLattice<double, 5> h;
  PhasePoint<double, 5> a({3, .01, .01, .01, .01}, {1, 0, 0, 0, 0}), b = a;
  Semiexplicit simple(h, schemes::blanes_moan6());
  Semiexplicit robust(h, schemes::blanes_moan6(), Robust{});
  for (int n = 0; n < 20; ++n) {
    const auto r = simple.step(a, 0.02), s = robust.step(b, 0.02);
    REQUIRE(r.ok());
    CHECK(r.evaluations == s.evaluations);
    CHECK(s.escalations == 0);
    CHECK(a.vector() == b.vector());
  }
  Semiexplicit impatient(h, schemes::blanes_moan6(),
                         Robust{.stop = StoppingRule::paper(1e-12), .newton_iterations = 1});
  const auto second = impatient.step(b, 0.02);
  CHECK(second.ok());
  CHECK(second.escalations == 1);
  Semiexplicit more(
      h, schemes::blanes_moan6(),
      Robust{.stop = StoppingRule::paper(1e-12), .newton_iterations = 1, .broyden_iterations = 1});
  const auto third = more.step(b, 0.02);
  CHECK(third.ok());
  CHECK(third.escalations == 2);
  Semiexplicit none(h, schemes::blanes_moan6(),
                    Robust{.stop = StoppingRule::paper(1e-12),
                           .newton_iterations = 1,
                           .broyden_iterations = 1,
                           .max_iterations = 1});
  const auto before = b;
  CHECK(none.step(b, 0.02).status == Status::no_convergence);
  CHECK(b.vector() == before.vector());
}

TEST_CASE("A step that explodes is not taken for one that rounding limits", "[stability]") {
  // The copies leave for 1e100, where their rounding is larger than the state.
  for (const double dt : {0.02, 0.05, 0.1, 0.2, 0.5, 1.0}) {
    CAPTURE(dt);
    const auto try_it = [&](const auto& solver) {
      auto z = StiffLattice::start();
      const auto before = z;
      Semiexplicit stepper(StiffLattice{}, schemes::strang(), solver);
      if (stepper.step(z, dt).ok())
        CHECK(StiffLattice{}.energy(z.q(), z.p()) < 1.1 * StiffLattice{}.energy(before.q(), before.p()));
      else
        CHECK(z.vector() == before.vector());
    };
    try_it(SimplifiedNewton{});
    try_it(Broyden{});
    try_it(NewtonKrylov{});
    try_it(Robust{});
  }
}

TEST_CASE("The advised step converges as promised", "[stability]") {
  for (const double frequency : {1.0, 37.0}) {
    const Quadratic h{frequency, 0, frequency};
    for (const double angle : {1.5, 2.2, 2.8}) {
      CAPTURE(frequency, angle);
      const double dt = angle / frequency;
      Semiexplicit stepper(h, schemes::blanes_moan6(), SimplifiedNewton{.stop = StoppingRule::paper(1e-12)});
      PhasePoint<double, 1> z(1, 0);
      const auto report = stepper.step(z, dt);
      CHECK(report.rate > 0.5);
      const double advised = report.advised_step(dt);
      CHECK(advised < dt);
      CHECK(report.advised_step(-dt) == -advised);
      z = PhasePoint<double, 1>(1, 0);
      const auto better = stepper.step(z, advised);
      CHECK(better.ok());
      CHECK(better.rate <= 0.6);
      CHECK(better.rate >= 0.2);
    }
  }
  CHECK(StepReport{}.advised_step(0.1) == 0.1);
  // The message of a run that fails carries it.
  Semiexplicit stepper(Quadratic{1, 0, 1}, schemes::blanes_moan6(),
                       SimplifiedNewton{.stop = StoppingRule::paper(1e-14), .max_iterations = 20});
  PhasePoint<double, 1> z(1, 0);
  try {
    integrate(stepper, z, {.dt = 2.5, .steps = 1});
    FAIL("2.5 radians should not converge in 20 evaluations");
  } catch (const IntegrationError& error) {
    CHECK(std::string(error.what()).find("try a dt of about ") != std::string::npos);
  }
}

TEST_CASE("A run subdivides failed steps only where it is told to, and says so", "[stability]") {
  // Fails at 2.5 radians, converges at 1.25.
  const Quadratic h{1, 0, 1};
  Semiexplicit stepper(h, schemes::strang(), SimplifiedNewton{});
  PhasePoint<double, 1> z(1, 0), by_halves = z;
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 2.5, .steps = 10}), IntegrationError);
  CHECK(z.vector() == by_halves.vector());

  const auto report = integrate(stepper, z, {.dt = 2.5, .steps = 10, .subdivide = 3});
  CHECK(report.ok());
  CHECK(report.steps == 10);
  CHECK(report.subdivided == 10);
  CHECK(report.t == 25);
  Semiexplicit fresh(h, schemes::strang(), SimplifiedNewton{});
  integrate(fresh, by_halves, {.dt = 1.25, .steps = 20});
  CHECK((z.vector() - by_halves.vector()).norm() <= 1e-13);

  // Not enough parts: the state stays, the status says why.
  PhasePoint<double, 1> stuck(1, 0);
  const auto failed =
      integrate(stepper, stuck, {.dt = 50, .steps = 1, .on_failure = OnFailure::stop, .subdivide = 2});
  CHECK_FALSE(failed.ok());
  CHECK(failed.subdivided == 0);
  Semiexplicit whole(h, schemes::strang());
  PhasePoint<double, 1> again(1, 0);
  CHECK(failed.last.evaluations == whole.step(again, 50).evaluations);  // the report is of the step asked for
  CHECK(stuck.vector() == Eigen::Vector2d(1, 0));
  CHECK_THROWS_AS(integrate(stepper, stuck, {.dt = 1, .steps = 1, .subdivide = -1}), std::invalid_argument);
}

namespace {

/// H = (x² + 1)(y² + 1)/2 with q = length x and p = momentum y, in a unit of energy of both.
struct ProductInUnits {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length = 1, momentum = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    const double x = q[0] / length, y = p[0] / momentum;
    return length * momentum * (x * x + 1) * (y * y + 1) / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double x = q[0] / length, y = p[0] / momentum;
    dHdq[0] = momentum * x * (y * y + 1);
    dHdp[0] = length * y * (x * x + 1);
  }
};

}  // namespace

TEST_CASE("Large steps by Newton and Krylov do not depend on the units of positions and momenta",
          "[stability][long]") {
  const auto worst = [](double length, double momentum) {
    const ProductInUnits h{length, momentum};
    Semiexplicit stepper(h, schemes::low_defect6_s13(), NewtonKrylov{});
    PhasePoint<double, 1> z(-3 * length, 0);
    Invariants invariants(h);
    REQUIRE(integrate(stepper, z, {.dt = 0.19, .steps = 20'000}, invariants).ok());
    return invariants["energy"].worst;
  };
  const double in_ones = worst(1, 1);
  for (const double unit : {1e-3, 1e-9, 1e-20, 1e12}) {
    CAPTURE(unit);
    CHECK(worst(1, unit) == Approx(in_ones).epsilon(0.05));
    CHECK(worst(unit, 1 / unit) == Approx(in_ones).epsilon(0.05));
  }
}

}  // namespace test_large_steps
