// Rounding errors and drift over many steps; bench_stability does 10⁸.

#include "catch.hpp"

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_long_runs {

namespace {

using namespace semiexplicit;

/// Root mean square of the relative energy errors of eight runs from starts a little apart.
double rounding_error(Summation summation, std::int64_t steps) {
  const systems::Product<double> h;
  double sum = 0;
  for (int k = 0; k < 8; ++k) {
    // The method's own error is 1e-19 at this step.
    Semiexplicit stepper(h, schemes::low_defect8_s20(), SimplifiedNewton{}, summation);
    PhasePoint<double, 1> z(-3 * (1 + 0.01 * k), 0);
    const double e0 = h.energy(z.q(), z.p());
    integrate(stepper, z, {.dt = 0.005, .steps = steps});
    sum += std::pow(h.energy(z.q(), z.p()) / e0 - 1, 2);
  }
  return std::sqrt(sum / 8);
}

}  // namespace

TEST_CASE("Rounding errors grow like a random walk, and compensated ones are small", "[stability][long]") {
  // Drift would take the error up by 100 from the first to the second.
  const double few = rounding_error(Summation::compensated, 1000),
               many = rounding_error(Summation::compensated, 100'000),
               plain = rounding_error(Summation::plain, 100'000);
  CHECK(many < 6e-15);
  CHECK(many < 30 * std::max(few, 1e-16));
  CHECK(plain > 5 * many);
  CHECK(plain < 1e-12);
}

TEST_CASE("The tolerance of the product rule is a drift budget", "[stability][long]") {
  const systems::NlsLattice<double, 5> h;
  const std::int64_t steps = 20'000;
  for (const double tau : {1e-12, 1e-14, 1e-16, 1e-18, 1e-20}) {
    CAPTURE(tau);
    Semiexplicit stepper(h, schemes::blanes_moan6(), SimplifiedNewton{.stop = StoppingRule::product(tau)});
    PhasePoint<double, 5> z({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
    const double m0 = z.vector().squaredNorm();
    integrate(stepper, z, {.dt = 0.02, .steps = steps});
    CHECK(std::abs(z.vector().squaredNorm() / m0 - 1) < 3 * tau * static_cast<double>(steps) + 2e-14);
  }
}

namespace {
struct Rotor {
  using Scalar = double;
  static constexpr int Dof = 2;
  double energy(In<double, 2> q, In<double, 2> p) const {
    return p[0] * p[0] / 2 - 0.3 * std::cos(q[0]) * q[1] + (q[1] * q[1] + 1) * (p[1] * p[1] + 1) / 2;
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = 0.3 * std::sin(q[0]) * q[1];
    dHdq[1] = -0.3 * std::cos(q[0]) + q[1] * (p[1] * p[1] + 1);
    dHdp[0] = p[0];
    dHdp[1] = p[1] * (q[1] * q[1] + 1);
  }
};
}  // namespace

TEST_CASE("An angle that is not wound back does not loosen the stopping rule", "[stability][long]") {
  // A rotor coupled to an oscillator: the angle grows to 3e4, the motion is that of the angle modulo 2π.
  Semiexplicit stepper(Rotor(), schemes::strang<double>());
  PhasePoint<double, 2> z({0, 2}, {3, 0});
  Invariants early{Rotor()}, all{Rotor()};
  integrate(stepper, z, {.dt = 0.1, .steps = 10'000}, early, all);
  integrate(stepper, z, {.dt = 0.1, .steps = 90'000, .t0 = 1000}, all);
  CHECK(std::abs(z.q()[0]) > 1e4);
  CHECK(all["energy"].worst < 1.05 * early["energy"].worst);
}

}  // namespace test_long_runs
