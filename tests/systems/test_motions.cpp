#include "catch.hpp"

#include <boost/math/constants/constants.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include <algorithm>
#include <cmath>
#include <complex>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_motions {

// Motions of the systems against closed forms, and values by hand.

using namespace semiexplicit;

TEST_CASE("The product system from (-3, 0) moves as Jacobi's cn", "[systems]") {
  const double q0 = -3, frequency = std::sqrt(1 + q0 * q0), modulus = std::abs(q0) / frequency;
  PhasePoint<double, 1> z(q0, 0);
  Semiexplicit stepper(systems::Product<double>{}, schemes::sofroniou_spaletta8());
  double worst = 0, longest_way = 0;
  integrate(stepper, z, {.dt = 0.01, .steps = 1000}, [&](double t, const auto& now) {
    double cn = 0, dn = 0;
    const double sn = boost::math::jacobi_elliptic(modulus, frequency * t, &cn, &dn);
    const double q = q0 * cn, p = -q0 * frequency * sn * dn / (q * q + 1);
    worst = std::max({worst, std::abs(now.q()[0] - q), std::abs(now.p()[0] - p)});
    longest_way = std::max(longest_way, std::abs(now.q()[0] - q0));
  });
  CHECK(longest_way > 5.9);  // over to the other side
  CHECK(worst < 1e-10);
}

TEST_CASE("One site of the NLS lattice turns at its density, clockwise", "[systems]") {
  // H = |ψ|⁴/4: ψ = ψ₀ exp(-i |ψ₀|² t).
  PhasePoint<double, 1> z(1.2, -0.5);
  const std::complex<double> start(1.2, -0.5);
  Semiexplicit stepper(systems::NlsLattice<double, 1>(), schemes::sofroniou_spaletta8());
  integrate(stepper, z, {.dt = 0.05, .steps = 100});
  const auto end = start * std::polar(1.0, -std::norm(start) * 5);
  CHECK(z.q()[0] == Approx(end.real()).margin(1e-12));
  CHECK(z.p()[0] == Approx(end.imag()).margin(1e-12));
}

TEST_CASE("Two vortices turn about their centre, whatever the signs", "[systems]") {
  const double distance = 1.3, dt = 0.02;
  const int steps = 500;
  for (const Eigen::Vector2d& strength :
       {Eigen::Vector2d(1, 2.5), Eigen::Vector2d(2, -0.7), Eigen::Vector2d(-1, -1.5)}) {
    CAPTURE(strength);
    const systems::PointVortices<double> h(strength);
    const double total = strength.sum(), centre = strength[1] * distance / total;
    auto z = h.phase_point(Eigen::Vector2d(0, distance), Eigen::Vector2d(0, 0));
    Semiexplicit stepper(h, schemes::blanes_moan6());
    integrate(stepper, z, {.dt = dt, .steps = steps});
    const double angle =
        total / (2 * boost::math::constants::pi<double>() * distance * distance) * dt * steps;
    CHECK(std::abs(angle) > 1);
    const Eigen::Vector2d x = h.x(z.q()), y = h.y(z.p());
    CHECK(x[0] == Approx(centre - centre * std::cos(angle)).margin(1e-10));
    CHECK(y[0] == Approx(-centre * std::sin(angle)).margin(1e-10));
    CHECK(x[1] == Approx(centre + (distance - centre) * std::cos(angle)).margin(1e-10));
    CHECK(y[1] == Approx((distance - centre) * std::sin(angle)).margin(1e-10));
  }
}

TEST_CASE("Vortices by hand: coordinates and energy", "[systems]") {
  const systems::PointVortices<double, 3> h(Eigen::Vector3d(4, -9, 2));
  const auto z = h.phase_point({1.5, -2, 0.7}, {0.25, 3, -1.1});
  CHECK((z.q() - Eigen::Vector3d(3, -6, std::sqrt(2.0) * 0.7)).norm() < 1e-14);
  CHECK((z.p() - Eigen::Vector3d(0.5, -9, std::sqrt(2.0) * -1.1)).norm() < 1e-14);

  // H = -Γ₁Γ₂ log D/(2π), to the accuracy of the number type.
  using Real = long double;
  const systems::PointVortices<Real, 2> pair(Vector<Real, 2>(2, -3));
  const auto at = pair.phase_point({0, 5}, {1, 1});
  const Real expected = 6 * std::log(5.0L) / (2 * boost::math::constants::pi<Real>());
  CHECK(std::abs(pair.energy(at.q(), at.p()) / expected - 1) < 1e-18L);
}

}  // namespace test_motions
