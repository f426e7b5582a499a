#include "catch.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_spin_orbit {

using namespace semiexplicit;
using Column = Vector<double, 3>;

TEST_CASE(
    "Two spinning bodies keep energy, total angular momentum and the coupling of the spins to the orbit",
    "[spins][long]") {
  const systems::SpinOrbit<double> bodies(1, 1, 0.7, 0.9, 0.6);
  const auto h = bodies.hamiltonian();
  auto z = bodies.state({100, 0, 0}, {0, 0.09, 0.03}, {1, 0.3, 0.5}, {-0.2, 1, 0.4});
  const Column before = bodies.total_angular_momentum(z);
  const double energy = h.energy(z.q(), z.p()), coupling = bodies.coupling(z.q(), z.p());
  const double phi = z.q()[3];
  Semiexplicit stepper(h, schemes::low_defect8_s20<double>());
  REQUIRE(integrate(stepper, z, {.dt = 100, .steps = 5000}).ok());
  CHECK(z.q().head<3>().norm() < 130);
  CHECK(std::abs(z.q()[3] - phi) > 1);  // the spins have turned
  CHECK(std::abs(h.energy(z.q(), z.p()) / energy - 1) < 1e-9);
  CHECK((bodies.total_angular_momentum(z) - before).norm() < 1e-9 * before.norm());
  CHECK(std::abs(bodies.coupling(z.q(), z.p()) / coupling - 1) < 1e-9);
}

TEST_CASE("A small spin turns about a circular orbit's axis at the geodetic rate", "[spins]") {
  // dφ/dt = (2GMν/(c²r³)) σ L, with σν = (3/2)(m₂/M) (1 + m₁/(3M)) for the spin of body 1: de Sitter's 3/2
  // where m₁ is small.
  const double share = 1e-3, r = 1e4, l = std::sqrt(r);
  const systems::SpinOrbit<double> bodies(1, 1, share, 1e-6, 0);
  auto z = bodies.state({r, 0, 0}, {0, l / r, 0}, {1, 0, 1e-3}, {1, 0, 0});
  Semiexplicit stepper(bodies.hamiltonian(), schemes::low_defect8_s20<double>());
  const double period = 2 * std::numbers::pi * std::sqrt(r * r * r);
  const double phi = z.q()[3];
  REQUIRE(integrate(stepper, z, {.dt = period / 40, .t_end = 10 * period}).ok());
  const double de_sitter = 1.5 * (1 - share) * (1 + share / 3) / std::pow(r, 2.5);
  CHECK((z.q()[3] - phi) / (10 * period) == Approx(de_sitter).epsilon(5e-3));  // r is 1PN's, to 1/r
}

TEST_CASE("Two spinning bodies have no exponent: what grows with the time goes down as its logarithm over it",
          "[spins][long]") {
  const systems::SpinOrbit<double> bodies(1, 1, 0.5, 0.8, 0.8);
  auto z = bodies.state({100, 0, 0}, {0, 0.09, 0.02}, {1, 0.2, 0.4}, {-0.3, 1, 0.2});
  Semiexplicit stepper(bodies.hamiltonian(), schemes::low_defect8_s20<double>());
  LyapunovExponents exponents(stepper, 1);
  REQUIRE(integrate(stepper, z, {.dt = 100, .steps = 2000}, exponents).ok());
  const double early = exponents.exponents()[0];
  REQUIRE(integrate(stepper, z, {.dt = 100, .steps = 8000, .t0 = 200'000}, exponents).ok());
  const double late = exponents.exponents()[0], t = 1e6;
  CHECK(z.q().head<3>().norm() < 130);
  CHECK(late < 0.4 * early);
  CHECK(late < 3 * std::log(t) / t);
}

TEST_CASE("Masses, spins and directions that make no sense are refused by name", "[spins]") {
  using Bodies = systems::SpinOrbit<double>;
  CHECK(refuses([] { Bodies(0, 1, 0.5, 0, 0); }, "gm and c are to be positive"));
  const double infinite = std::numeric_limits<double>::infinity();
  CHECK(refuses([&] { Bodies(infinite, 1, 0.5, 0, 0); }, "gm and c are to be positive, and gm finite"));
  CHECK(refuses([&] { Bodies(1, 1, 0.5, 0, infinite); }, "length is negative, NaN or Inf"));
  CHECK(refuses([] { Bodies(1, 1, 1, 0, 0); }, "share of the first body"));
  CHECK(refuses([] { Bodies(1, 1, 0.5, -1, 0); }, "length is negative"));
  CHECK(refuses(
      [] {
        Bodies(1, 1, 0.5, 1, 1).state({1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {1, 0, 0});
      },
      "direction 1 has no length"));
  CHECK(refuses(
      [&] {
        Bodies(1, 1, 0.5, 1, 1).state({1, 0, 0}, {0, 1, 0}, {1, 0, 0}, {infinite, 0, 0});
      },
      "direction 2 has no length, or holds NaN or Inf"));
}

TEST_CASE("Only the directions of spins count, whatever their length", "[spins]") {
  const systems::SpinOrbit<double> bodies(1, 4, 0.6, 0.7, 0.9);
  const auto z = bodies.state({8, 0, 1}, {0, 0.3, 0.1}, {1, 0, 1}, {0, 1, 1});
  for (const double length : {1e-300, 1e-170, 1e-100, 1e100, 1e160, 1e300}) {
    CAPTURE(length);
    const auto same = bodies.state({8, 0, 1}, {0, 0.3, 0.1}, {length, 0, length}, {0, length, length});
    CHECK(same.q() == z.q());
    CHECK((same.p() - z.p()).norm() < 1e-15);
  }
}

}  // namespace test_spin_orbit
