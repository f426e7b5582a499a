#include "catch.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_effects {

// Every effect by itself: its gradient against its energy, and against what else is known of it.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;

/// Numbers without a pattern in (-1, 1).
double number(int n) { return std::fmod((n + 1) * 0.6180339887498949, 1.0) * 2 - 1; }

template <int Dof>
PhasePoint<double, Dof> some_point(Eigen::Index dof = Dof) {
  PhasePoint<double, Dof> z(dof);
  for (Eigen::Index i = 0; i < 2 * dof; ++i) z.vector()[i] = number(static_cast<int>(i));
  return z;
}

/// How far the gradient of an effect, on top of what is there, is from central differences of the energy of
/// order 6.
template <int Dof>
double gradient_error(const AnyEffect<double, Dof>& effect, const PhasePoint<double, Dof>& z) {
  PhasePoint<double, Dof> g(z.dof()), other = z;
  for (Eigen::Index i = 0; i < 2 * z.dof(); ++i) g.vector()[i] = 3;
  Out<double, Dof> by_q = g.q(), by_p = g.p();
  effect.add_gradient(z.q(), z.p(), by_q, by_p);
  const double delta = 0.003;
  double worst = 0;
  for (Eigen::Index i = 0; i < 2 * z.dof(); ++i) {
    const auto at = [&](double by) {
      other.vector()[i] = z.vector()[i] + by * delta;
      return effect.energy(other.q(), other.p());
    };
    const double difference = 0.75 * (at(1) - at(-1)) - 0.15 * (at(2) - at(-2)) + (at(3) - at(-3)) / 60;
    other.vector()[i] = z.vector()[i];
    const double error = std::abs(g.vector()[i] - 3 - difference / delta);
    if (!(error <= worst)) worst = error;
  }
  return worst;
}

/// How far the two halves, had separately, are from the whole gradient.
template <int Dof>
double halves_error(const AnyEffect<double, Dof>& effect, const PhasePoint<double, Dof>& z) {
  PhasePoint<double, Dof> whole(z.dof()), halves(z.dof());
  Out<double, Dof> by_q = whole.q(), by_p = whole.p(), half_q = halves.q(), half_p = halves.p();
  effect.add_gradient(z.q(), z.p(), by_q, by_p);
  effect.add_position_gradient(z.q(), half_q);
  effect.add_momentum_gradient(z.p(), half_p);
  return (whole.vector() - halves.vector()).norm();
}

void require_small(const std::string& name, double error, double halves) {
  CAPTURE(name);
  CHECK(error <= 1e-8);
  CHECK(halves == 0);
}

template <int Dof>
void gradients_are_those_of_the_energies(const std::vector<AnyEffect<double, Dof>>& effects,
                                         const PhasePoint<double, Dof>& z) {
  for (const auto& effect : effects)
    require_small(effect.name(), gradient_error(effect, z), effect.coupled() ? 0 : halves_error(effect, z));
}

template <int Dim>
void orbit_effects_agree() {
  using namespace orbits;
  auto z = some_point<Dim>();
  z.q() *= 2;
  gradients_are_those_of_the_energies<Dim>(
      {Kinetic<double, Dim>{}, Attraction<double, Dim>{.gm = 1.3}, TwoCentres<double, Dim>::restricted(0.2),
       Oblateness<double, Dim>{.gm = 1.3, .j2 = 0.3, .radius = 0.7},
       RotatingFrame<double, Dim>{.omega = -0.7}, PostNewtonian1<double, Dim>{.gm = 1.3, .c = 1.5, .nu = 0.2},
       PostNewtonian2<double, Dim>{.gm = 1.3, .c = 1.5, .nu = 0.2},
       SpinOrbit<double, Dim>{.gs = 0.4, .c = 1.2}},
      z);
}

Eigen::VectorXd column(int n, double offset) {
  Eigen::VectorXd x(n);
  for (int i = 0; i < n; ++i) x[i] = offset + number(i);
  return x;
}

}  // namespace

TEST_CASE("The gradient of every effect is that of its energy", "[systems]") {
  SECTION("orbits") {
    orbit_effects_agree<2>();
    orbit_effects_agree<3>();
  }
  SECTION("black holes") {
    PhasePoint<double, 4> z({0.3, 6.1, 1.1, 0.4}, {-0.96, 0.2, 1.4, 2.3});
    gradients_are_those_of_the_energies<4>(
        {black_hole::Kerr<>{.mass = 1.1, .spin = 0.8}, black_hole::Schwarzschild<>{.mass = 1.1}}, z);
  }
  SECTION("charges") {
    using namespace charges;
    gradients_are_those_of_the_energies<3>(
        {Kinetic<>{.mass = 1.7}, UniformElectric<>{.charge = 1.2, .x = 0.3, .y = -0.4, .z = 0.8},
         Coulomb<>{.k = 0.8}, Quadrupole<>{.k = 1.4}, MagneticKinetic(1.4, 0.7),
         MagneticKinetic(1.4, 0.7, UniformField(0.9), DipoleField(-0.4), BottleField(0.6, 1.5))},
        some_point<3>());
  }
  SECTION("lattices") {
    for (const int n : {1, 2, 3, 7}) {
      CAPTURE(n);
      gradients_are_those_of_the_energies<Eigen::Dynamic>(
          {lattice::OnSite<>{.sites = n, .strength = 0.7},
           lattice::PairExchange<>{.sites = n, .strength = 1.3}, lattice::Hopping<>{.sites = n, .rate = 0.6},
           lattice::Disorder<>(column(n, 0.3))},
          some_point<Eigen::Dynamic>(n));
    }
    gradients_are_those_of_the_energies<4>(
        {lattice::OnSite<double, 4>{}, lattice::PairExchange<double, 4>{}, lattice::Hopping<double, 4>{}},
        some_point<4>());
  }
  SECTION("vortices") {
    const vortices::Circulations gamma(Eigen::Vector4d(1.2, -0.7, 0.4, 2));
    PhasePoint<double, 4> z = some_point<4>();
    z.p() = gamma.gamma.cwiseSign().cwiseProduct(z.p()) + 2 * gamma.gamma.cwiseSign();  // above the wall
    gradients_are_those_of_the_energies<4>(
        {vortices::Pairs(gamma), vortices::Strain(gamma, 0.6, 0.4), vortices::Rotation(gamma, 0.8),
         vortices::HalfPlane(gamma), vortices::Disk(gamma, 6.0)},
        z);
  }
}

TEST_CASE("A scene of lattice effects is the NLS lattice", "[systems]") {
  const auto same = []<int N>(const auto& scene, const systems::NlsLattice<double, N>& lattice) {
    const auto z = some_point<N>(scene.dof());
    PhasePoint<double, N> one(z.dof()), other(z.dof());
    scene.gradient(z.q(), z.p(), one.q(), one.p());
    lattice.gradient(z.q(), z.p(), other.q(), other.p());
    CHECK((one.vector() - other.vector()).norm() <= 1e-14 * other.vector().norm());
    CHECK(scene.energy(z.q(), z.p()) == Approx(lattice.energy(z.q(), z.p())).epsilon(1e-14));
  };
  same(Scene(lattice::OnSite<double, 5>{}, lattice::PairExchange<double, 5>{}),
       systems::NlsLattice<double, 5>());
  same(Scene(lattice::OnSite<>{.sites = 33}, lattice::PairExchange<>{.sites = 33}),
       systems::NlsLattice<>(33));
}

TEST_CASE("Lattice effects of another number of sites than the type says are refused", "[systems]") {
  using effects::lattice::OnSite, effects::lattice::PairExchange, effects::lattice::Hopping;
  const std::string said = " has 7 degrees of freedom, and the type of the scene has 5";
  CHECK(refuses([] { Scene scene(OnSite<double, 5>{.sites = 7}); }, "on_site" + said));
  CHECK(refuses([] { Scene scene(OnSite<double, 5>{}, PairExchange<double, 5>{.sites = 7}); },
                "pair_exchange" + said));
  CHECK(refuses([] { RuntimeScene<double, 5>{Hopping<double, 5>{.sites = 7}}; }, "hopping" + said));
  CHECK(Scene(OnSite<double, 5>{}, PairExchange<double, 5>{.sites = 5}).dof() == 5);
}

TEST_CASE("A scene of vortex pairs is systems::PointVortices", "[systems]") {
  const Eigen::Vector3d strengths(1.2, -0.7, 2);
  const systems::PointVortices<double, 3> known(strengths);
  const Scene scene(vortices::Pairs{vortices::Circulations(strengths)});
  const auto z = some_point<3>();
  PhasePoint<double, 3> one, other;
  scene.gradient(z.q(), z.p(), one.q(), one.p());
  known.gradient(z.q(), z.p(), other.q(), other.p());
  CHECK((one.vector() - other.vector()).norm() <= 1e-14 * other.vector().norm());
  CHECK(scene.energy(z.q(), z.p()) == Approx(known.energy(z.q(), z.p())).epsilon(1e-14));
}

TEST_CASE("A straining and a turning flow have the velocities that they say", "[systems]") {
  const Eigen::Vector2d gamma(1.5, -0.4);
  const systems::PointVortices<double, 2> plane(gamma);
  const vortices::Circulations circulations(gamma);
  const Eigen::Vector2d x(0.7, -1.2), y(0.3, 0.9);
  const auto z = plane.phase_point(x, y);
  // The velocity of each, from dHdp and -dHdq as the coordinates themselves.
  const auto velocity = [&](const auto& effect) {
    PhasePoint<double, 2> g;
    Scene(effect).gradient(z.q(), z.p(), g.q(), g.p());
    return std::pair<Eigen::Vector2d, Eigen::Vector2d>(plane.x(g.p()), plane.y(-g.q()));
  };
  const double angle = 0.3, rate = 0.8;
  const Eigen::Vector2d axis(std::cos(angle), std::sin(angle)), across(-axis[1], axis[0]);
  const auto [sx, sy] = velocity(vortices::Strain(circulations, rate, angle));
  const auto [rx, ry] = velocity(vortices::Rotation(circulations, rate));
  for (int i = 0; i < 2; ++i) {
    const Eigen::Vector2d at(x[i], y[i]);
    const Eigen::Vector2d flow = rate * (at.dot(axis) * axis - at.dot(across) * across);
    CHECK((Eigen::Vector2d(sx[i], sy[i]) - flow).norm() <= 1e-14);
    CHECK((Eigen::Vector2d(rx[i], ry[i]) - rate * Eigen::Vector2d(-y[i], x[i])).norm() <= 1e-14);
  }
}

TEST_CASE("The curl of the vector potentials is the field", "[systems]") {
  const Eigen::Vector3d x(0.7, -0.4, 0.9);
  const auto curl = [&](const auto& field) {
    Eigen::Matrix3d slope;  // slope(i, k) = ∂A_k/∂x_i
    for (int k = 0; k < 3; ++k) {
      Eigen::Vector3d column = Eigen::Vector3d::Zero();
      field.add_gradient(x, Eigen::Vector3d(Eigen::Vector3d::Unit(k)), 1.0, column);
      slope.col(k) = column;
    }
    return Eigen::Vector3d(slope(1, 2) - slope(2, 1), slope(2, 0) - slope(0, 2), slope(0, 1) - slope(1, 0));
  };
  const double r2 = x.squaredNorm(), m = 0.6, b = 1.3, length = 2.5;
  const Eigen::Vector3d dipole = m * (3 * x[2] * x - r2 * Eigen::Vector3d::UnitZ()) / std::pow(r2, 2.5);
  const double rho2 = x[0] * x[0] + x[1] * x[1], l2 = length * length;
  const Eigen::Vector3d bottle(-b * x[0] * x[2] / l2, -b * x[1] * x[2] / l2,
                               b * (1 + (x[2] * x[2] - rho2 / 2) / l2));
  CHECK((curl(charges::UniformField(b)) - b * Eigen::Vector3d::UnitZ()).norm() <= 1e-15);
  CHECK((curl(charges::DipoleField(m)) - dipole).norm() <= 1e-14);
  CHECK((curl(charges::BottleField(b, length)) - bottle).norm() <= 1e-14);
}

TEST_CASE("attraction and the loss by waves in float and SI units are those in double", "[effects]") {
  const auto at_the_sun = []<class Scalar>(Scalar) {
    const Vector<Scalar, 2> q(Scalar(6e12), Scalar(8e12)), p(Scalar(-3e3), Scalar(2e3));
    PhasePoint<Scalar, 2> slopes(2);
    Out<Scalar, 2> slope = slopes.q(), force = slopes.p();
    orbits::Attraction<Scalar, 2>{.gm = Scalar(1.327e20)}.add_gradient(q, slope);
    orbits::RadiationReaction<Scalar, 2>{.gm = Scalar(1.327e20), .c = Scalar(2.998e8)}.add_force(
        Vector<Scalar, 2>(q / 1000), p, force);
    return slopes;
  };
  const PhasePoint<double, 2> rough(at_the_sun(1.f).q().cast<double>(), at_the_sun(1.f).p().cast<double>()),
      exact = at_the_sun(1.0);
  REQUIRE(exact.p().norm() > 0);
  CHECK((rough.q() - exact.q()).norm() < 1e-6 * exact.q().norm());
  CHECK((rough.p() - exact.p()).norm() < 1e-6 * exact.p().norm());
}

}  // namespace test_effects
