// Steps that take many states, or large ones, to show that none is a distant solution.
#include "catch.hpp"

#include <cmath>
#include <random>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_distant_solutions {

using namespace semiexplicit;

TEST_CASE("No solver takes a distant solution of the projection for that of the step", "[failures][long]") {
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    const auto well = q[0] * q[0] - 1;
    return (p[0] * p[0] + p[1] * p[1]) / 2 * (1 + 0.3 * q[0] * q[0]) + well * well / 4 + q[1] * q[1] / 2 +
           0.2 * q[0] * q[1] * p[0];
  });
  // An iteration that wanders for nearly a hundred evaluations ends there.
  PhasePoint<double, 2> z({-1.6049070631184654, 0.26706564373062314},
                          {-1.1391682576997479, -1.9528368559373941});
  const auto before = z;
  CHECK(Semiexplicit(h).step(z, 1.0).status == Status::no_convergence);
  CHECK(z.vector() == before.vector());

  // Some that creep there, by corrections that hardly grow.
  const auto pendulum = from_energy<2>([](const auto& q, const auto& p) {
    using std::cos;
    const auto c = cos(q[0] - q[1]);
    return (p[0] * p[0] + 2.0 * p[1] * p[1] - 2.0 * p[0] * p[1] * c) / (2.0 * (2.0 - c * c)) -
           2.0 * cos(q[0]) - cos(q[1]);
  });
  z = PhasePoint<double, 2>({0.559684803075, 0.139013434778}, {-0.0653690382194, 1.92854961961});
  CHECK(Semiexplicit(pendulum).step(z, 0.940993).status == Status::no_convergence);
  z = PhasePoint<double, 2>({-0.345490979631, -0.690546170824}, {-1.48843466865, 0.501279126427});
  CHECK(Semiexplicit(pendulum).step(z, 1.40802).status == Status::no_convergence);

  const auto thrown = [&](auto solver) {
    std::mt19937_64 random(11);
    std::uniform_real_distribution<double> entry(-2, 2);
    Semiexplicit stepper(h, schemes::low_defect6_s13(), solver);
    int taken = 0, off = 0;
    for (int i = 0; i < 5000; ++i) {
      for (double& x : z.vector()) x = entry(random);
      auto y = z;
      if (!stepper.step(y, 0.9).ok()) continue;
      ++taken;
      if (std::abs(h.energy(y.q(), y.p()) / h.energy(z.q(), z.p()) - 1) > 0.2) ++off;
    }
    CHECK(taken > 2000);
    return off;
  };
  CHECK(thrown(SimplifiedNewton{}) == 0);
  CHECK(thrown(Broyden{}) == 0);
  CHECK(thrown(NewtonKrylov{}) == 0);
  CHECK(thrown(Robust{}) == 0);

  // Angles that have wound up make the state large, and nothing else.
  const auto pendulums = from_energy<2>([](const auto& q, const auto& p) {
    using std::cos;
    return (1 - 0.557887 * cos(q[0] - q[1])) * (p[0] * p[0] + p[1] * p[1]) / 2 +
           3 * (2 - cos(q[0]) - cos(q[1]));
  });
  for (const int turns : {0, 10, 1000}) {
    CAPTURE(turns);
    const double wound = turns * 2 * std::acos(-1.0);
    z = PhasePoint<double, 2>({2.02487 + wound, 0.310773 + wound}, {-3.94475, 1.3608});
    CHECK(Semiexplicit(pendulums).step(z, 0.574479).status == Status::no_convergence);
  }
}

TEST_CASE("No solver accepts copies that are far apart: random states and large steps", "[failures][long]") {
  const systems::Product<double> h;
  const auto flung = [&](auto solver, const Scheme<double>& scheme) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> entry(-2, 2), exponent(std::log(0.05), std::log(4.0));
    Semiexplicit stepper(h, scheme, solver);
    int taken = 0, far = 0;
    for (int i = 0; i < 4000; ++i) {
      const PhasePoint<double, 1> z(entry(random), entry(random));
      auto y = z;
      if (!stepper.step(y, std::exp(exponent(random))).ok()) continue;
      ++taken;
      if (y.vector().norm() > 1000 * z.vector().norm()) ++far;
    }
    CHECK(taken > 1500);
    return far;
  };
  for (const auto& scheme : {schemes::strang(), schemes::low_defect4_s7()}) {
    CHECK(flung(SimplifiedNewton{}, scheme) == 0);
    CHECK(flung(Broyden{}, scheme) == 0);
    CHECK(flung(NewtonKrylov{}, scheme) == 0);
    CHECK(flung(Robust{}, scheme) == 0);
  }
}

TEST_CASE("The size of a system does not change its steps", "[failures][long]") {
  // Sites of the lattice that are empty stay so: 70000 sites of which five are taken are these five. Vectors
  // of that length are worked on in another way than short ones.
  const PhasePoint<double, 5> five({3, 0.01, 0.02, -0.01, 0.5}, {1, 0, 0.1, 0, -0.2});
  PhasePoint<double, Eigen::Dynamic> many(70'000);
  many.q().head(5) = five.q();
  many.p().head(5) = five.p();
  const systems::NlsLattice<double, 5> small;
  const systems::NlsLattice<double> large(70'000);
  const auto agree = [&](auto small_stepper, auto large_stepper) {
    PhasePoint<double, 5> x = five;
    PhasePoint<double, Eigen::Dynamic> y = many;
    for (int n = 0; n < 5; ++n) {
      const auto r = small_stepper.step(x, 0.01), s = large_stepper.step(y, 0.01);
      REQUIRE(r.ok());
      REQUIRE(s.ok());
      CHECK(r.evaluations == s.evaluations);
    }
    CHECK((y.q().head(5) - x.q()).norm() <= 1e-14);
    CHECK((y.p().head(5) - x.p()).norm() <= 1e-14);
    CHECK(y.q().tail(69'995).isZero(0));
    CHECK(y.p().tail(69'995).isZero(0));
  };
  const auto s = schemes::strang();
  agree(Semiexplicit(small, s), Semiexplicit(large, s));
  agree(Semiexplicit(small, s, Broyden{}), Semiexplicit(large, s, Broyden{}));
  agree(MidpointProjection(small, s), MidpointProjection(large, s));
  agree(GaussLegendre(small, {.stages = 2, .tolerance = 1e-14}),
        GaussLegendre(large, {.stages = 2, .tolerance = 1e-14}));
}

TEST_CASE(
    "An iteration that runs away from its start, the solution, is no success: a circle in a long step") {
  const auto h = from_energy<3>([](const auto& q, const auto& p) {
    using std::sin;
    const auto across = q[0] * sin(q[1]);
    return (p[0] * p[0] + p[1] * p[1] / (q[0] * q[0]) + p[2] * p[2] / (across * across)) / 2 - 1 / q[0];
  });
  const double pi = std::acos(-1.0);
  int accepted = 0;
  for (int stages = 1; stages <= 8; ++stages)
    for (int i = 0; i < 40; ++i)
      for (double periods = 0.2; periods < 4; periods *= 1.1) {
        const double r = 1 + 0.34 * i;
        PhasePoint<double, 3> z({r, pi / 2, 0}, {0, 0, std::sqrt(r)});
        GaussLegendre stepper(h, {.stages = stages});
        if (!stepper.step(z, 2 * pi * std::pow(r, 1.5) * periods).ok()) continue;
        ++accepted;
        if (!(std::abs(z.q()[0] / r - 1) < 1e-8)) {
          CAPTURE(stages, r, periods, z.q()[0]);
          CHECK(z.q()[0] == Approx(r));
        }
      }
  CHECK(accepted > 3000);
}

TEMPLATE_TEST_CASE("A start at rest is solved where momenta are nothing beside positions: one stage", "",
                   float, double) {
  using Scalar = TestType;
  const double mass = std::same_as<Scalar, float> ? 1e-26 : 1e-33, length = mass < 1e-30 ? 1e18 : 1e3,
               rate = mass < 1e-30 ? 1e-14 : 1e-2, angle = 2 * std::atan(0.15);
  const auto lightness = static_cast<Scalar>(1 / mass), spring = static_cast<Scalar>(mass * rate * rate);
  const auto well = make_hamiltonian<Scalar, 1>(
      [=](const auto& q, const auto& p) { return (lightness * p[0] * p[0] + spring * q[0] * q[0]) / 2; },
      [=](const auto& q, const auto& p, auto&& dHdq, auto&& dHdp) {
        dHdq[0] = spring * q[0];
        dHdp[0] = lightness * p[0];
      });
  GaussLegendre stepper(well, {.stages = 1});
  PhasePoint<Scalar, 1> z(Scalar(length), Scalar(0));
  REQUIRE(stepper.step(z, Scalar(0.3 / rate)).ok());
  const double bound = 50 * static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
  CHECK(std::abs(static_cast<double>(z.q()[0]) / length - std::cos(angle)) < bound);
  CHECK(std::abs(static_cast<double>(z.p()[0]) / (mass * rate * length) + std::sin(angle)) < bound);
}

}  // namespace test_distant_solutions
