#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <semiexplicit/systems.hpp>

#include "methods.hpp"

namespace test_invariants {

// Linear and quadratic invariants of H are kept by the converged method itself, not only as well as the
// solution is; the energy error stays bounded.

namespace {

using namespace semiexplicit;

const systems::NlsLattice<double, 5> lattice;
const PhasePoint<double, 5> lattice_start({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});

const systems::PointVortices<double, 4> vortices({1, -0.6, 0.8, 2});
PhasePoint<double, 4> vortices_start() {
  return vortices.phase_point({1, -1, 0.2, 0.4}, {0.1, 0.3, 1.2, -0.9});
}

/// The worst relative errors of a run on the lattice.
template <class Stepper>
auto errors_on_lattice(Stepper stepper, double dt, std::int64_t steps) {
  PhasePoint<double, 5> z = lattice_start;
  Invariants errors(lattice);
  errors.add("mass", [](const auto& q, const auto& p) { return lattice.mass(q, p); });
  integrate(stepper, z, {.dt = dt, .steps = steps}, errors);
  return errors;
}

/// Likewise for the vortices. None of the first values is zero.
template <class Stepper>
auto errors_of_vortices(Stepper stepper, double dt, std::int64_t steps) {
  PhasePoint<double, 4> z = vortices_start();
  Invariants errors(vortices);
  errors.add("angular", [](const auto& q, const auto& p) { return vortices.angular_impulse(q, p); });
  errors.add("x", [](const auto& q, const auto& p) { return vortices.linear_impulse_x(q, p); });
  errors.add("y", [](const auto& q, const auto& p) { return vortices.linear_impulse_y(q, p); });
  integrate(stepper, z, {.dt = dt, .steps = steps}, errors);
  return errors;
}

}  // namespace

TEST_CASE("Every symplectic method keeps the linear and the quadratic invariants", "[invariants]") {
  methods::Choice choice;
  choice.most_stages = 4;
  methods::for_each_of_phase_space(lattice, choice, [](const methods::Claim& claim, const auto& stepper) {
    if (!claim.symplectic) return;
    CAPTURE(claim.name);
    const auto errors = errors_on_lattice(stepper, 0.01, 1000);
    CHECK(errors["mass"].worst <= 1e-14);
    CHECK(errors["energy"].worst <= 0.1);
  });
  methods::for_each_of_phase_space(vortices, choice, [](const methods::Claim& claim, const auto& stepper) {
    if (!claim.symplectic) return;
    CAPTURE(claim.name);
    const auto errors = errors_of_vortices(stepper, 0.05, 500);
    for (const char* name : {"angular", "x", "y"}) CHECK(errors[name].worst <= 1e-14);
    CHECK(errors["energy"].worst <= 0.01);
  });
}

TEST_CASE("The mass error of a long run is that of rounding", "[invariants][long]") {
  const auto tight = StoppingRule::paper(0);
  CHECK(errors_on_lattice(Semiexplicit(lattice, schemes::strang(), SimplifiedNewton{.stop = tight}), 0.01,
                          50'000)["mass"]
            .worst <= 1e-14);
  CHECK(errors_on_lattice(Semiexplicit(lattice, schemes::blanes_moan4(), Broyden{.stop = tight}), 0.01,
                          20'000)["mass"]
            .worst <= 1e-14);
  // The default rule allows a relative drift of 1e-16 a step at most.
  CHECK(errors_on_lattice(Semiexplicit(lattice, schemes::strang()), 0.01, 50'000)["mass"].worst <=
        50'000 * 1e-16);
  CHECK(errors_on_lattice(Semiexplicit(lattice, schemes::low_defect6_s13()), 0.01, 20'000)["mass"].worst <=
        20'000 * 1e-16);
  CHECK(errors_on_lattice(GaussLegendre(lattice, {.stages = 3}), 0.01, 20'000)["mass"].worst <= 1e-14);
  // The test can fail.
  CHECK(errors_on_lattice(MidpointProjection(lattice, schemes::strang()), 0.01, 2000)["mass"].worst >= 1e-8);
}

TEST_CASE("The impulses of vortices in a long run are kept to rounding", "[invariants]") {
  const auto tight = StoppingRule::paper(0);
  const auto strang = errors_of_vortices(
      Semiexplicit(vortices, schemes::strang(), SimplifiedNewton{.stop = tight}), 0.02, 20'000);
  const auto default_rule =
      errors_of_vortices(Semiexplicit(vortices, schemes::low_defect6_s13(), Broyden{}), 0.05, 20'000);
  for (const char* name : {"angular", "x", "y"}) {
    CAPTURE(name);
    CHECK(strang[name].worst <= 1e-13);
    CHECK(default_rule[name].worst <= 1e-12);
  }
}

TEST_CASE("The energy error is bounded: the second half of a run is no worse than the first",
          "[invariants]") {
  struct Halves {
    double first = 0, second = 0;
  };
  const auto halves = [](auto stepper, const auto& h, auto z, double dt, std::int64_t steps) {
    const double begin = h.energy(z.q(), z.p());
    const double middle = dt * static_cast<double>(steps) / 2;
    Halves worst;
    integrate(stepper, z, {.dt = dt, .steps = steps}, [&](double t, const auto& now) {
      const double error = std::abs(h.energy(now.q(), now.p()) / begin - 1);
      double& half = t < middle ? worst.first : worst.second;
      half = std::max(half, error);
    });
    return worst;
  };
  const auto is_bounded = [](const Halves& h, double size) {
    CHECK(h.first <= size);
    CHECK(h.first > 0);
    CHECK(h.second <= 1.3 * h.first);
  };
  is_bounded(halves(Semiexplicit(lattice, schemes::strang()), lattice, lattice_start, 0.01, 50'000), 2e-2);
  is_bounded(halves(Semiexplicit(lattice, schemes::blanes_moan4()), lattice, lattice_start, 0.01, 20'000),
             1e-5);
  is_bounded(halves(Semiexplicit(lattice, schemes::low_defect4_s7(), Broyden{}), lattice, lattice_start, 0.01,
                    20'000),
             1e-4);
  is_bounded(halves(Semiexplicit(vortices, schemes::strang()), vortices, vortices_start(), 0.02, 20'000),
             1e-2);
  is_bounded(halves(Semiexplicit(vortices, schemes::yoshida6()), vortices, vortices_start(), 0.05, 10'000),
             1e-3);
}

}  // namespace test_invariants
