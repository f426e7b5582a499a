#include "catch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_systems {

namespace {

using namespace semiexplicit;
using Real = long double;
using Dynamic = PhasePoint<Real, Eigen::Dynamic>;

/// A lattice with its whole gradient only.
struct Whole {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  systems::NlsLattice<double> lattice;
  Eigen::Index dof() const { return lattice.dof(); }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
};
static_assert(HasRangeGradient<systems::NlsLattice<double>> && !HasRangeGradient<Whole>);

/// Numbers without a pattern in (-1, 1).
Real number(int n) { return std::fmod(static_cast<Real>(n + 1) * 0.618033988749894848L, 1.0L) * 2 - 1; }

template <Hamiltonian H>
auto gradient_of(const H& h, const PhasePoint<typename H::Scalar, H::Dof>& z) {
  PhasePoint<typename H::Scalar, H::Dof> g(z.dof());
  h.gradient(z.q(), z.p(), g.q(), g.p());
  return g;
}

/// The gradient against central differences of the energy of order 6.
template <Hamiltonian H>
void gradient_is_that_of_the_energy(const H& h, const PhasePoint<Real, H::Dof>& z) {
  const auto g = gradient_of(h, z);
  const Real delta = 0.002L;
  for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
    const auto moved = [&](Real by) {
      PhasePoint<Real, H::Dof> other = z;
      other.vector()[i] += by;
      return h.energy(other.q(), other.p());
    };
    const Real difference = 0.75L * (moved(delta) - moved(-delta)) -
                            0.15L * (moved(2 * delta) - moved(-2 * delta)) +
                            (moved(3 * delta) - moved(-3 * delta)) / 60;
    CAPTURE(i);
    CHECK(std::abs(static_cast<double>(g.vector()[i] - difference / delta)) <=
          1e-12 * (1 + static_cast<double>(g.vector().norm())));
  }
}

template <int N>
void lattice_of_fixed_size_agrees() {
  PhasePoint<Real, N> z;
  for (int i = 0; i < 2 * N; ++i) z.vector()[i] = number(i);
  const systems::NlsLattice<Real, N> fixed;
  const systems::NlsLattice<Real> dynamic(N);
  gradient_is_that_of_the_energy(fixed, z);
  const Dynamic same(z.q(), z.p());
  if (N <= 10) gradient_is_that_of_the_energy(dynamic, same);
  CHECK(static_cast<double>((gradient_of(fixed, z).vector() - gradient_of(dynamic, same).vector()).norm()) <=
        1e-17);
  CHECK(fixed.energy(z.q(), z.p()) == dynamic.energy(same.q(), same.p()));
  CHECK(fixed.dof() == N);
  CHECK(dynamic.dof() == N);
}

template <int N>
void vortices_agree() {
  Vector<Real, N> circulations, x, y;
  for (int i = 0; i < N; ++i) {
    circulations[i] = (i % 3 == 0 ? -1 : 1) * (1 + number(i) / 2);
    x[i] = i % 7 + number(3 * i) / 4;  // a grid, somewhat disturbed
    y[i] = i / 7 + number(5 * i + 2) / 4;
  }
  const systems::PointVortices<Real, N> fixed(circulations);
  const systems::PointVortices<Real> dynamic{Vector<Real, Eigen::Dynamic>(circulations)};
  const auto z = fixed.phase_point(x, y);
  const Dynamic same(z.q(), z.p());
  gradient_is_that_of_the_energy(fixed, z);
  gradient_is_that_of_the_energy(dynamic, same);
  CHECK(static_cast<double>((gradient_of(fixed, z).vector() - gradient_of(dynamic, same).vector()).norm()) <=
        1e-17);
  CHECK(static_cast<double>((fixed.x(z.q()) - x).norm()) <= 1e-17);
  CHECK(static_cast<double>((fixed.y(z.p()) - y).norm()) <= 1e-17);
  CHECK(dynamic.circulations() == circulations);

  // Against the sum over pairs in the plane, written out: Γᵢ(x', y')ᵢ = ...
  const auto g = gradient_of(fixed, z);
  const Real pi = std::acos(Real(-1));
  for (int i = 0; i < N; ++i) {
    Real dx = 0, dy = 0;
    for (int j = 0; j < N; ++j)
      if (j != i) {
        const Real r2 = (x[i] - x[j]) * (x[i] - x[j]) + (y[i] - y[j]) * (y[i] - y[j]);
        dx -= circulations[j] * (y[i] - y[j]) / r2 / (2 * pi);
        dy += circulations[j] * (x[i] - x[j]) / r2 / (2 * pi);
      }
    const Real root = std::sqrt(std::abs(circulations[i])), sign = circulations[i] > 0 ? 1 : -1;
    CHECK(static_cast<double>(g.p()[i] / root) == Approx(static_cast<double>(dx)).margin(1e-15));
    CHECK(static_cast<double>(-g.q()[i] / root * sign) == Approx(static_cast<double>(dy)).margin(1e-15));
  }
  // Its invariants in the plane.
  Real impulse_x = 0, impulse_y = 0, angular = 0;
  for (int i = 0; i < N; ++i) {
    impulse_x += circulations[i] * x[i];
    impulse_y += circulations[i] * y[i];
    angular += circulations[i] * (x[i] * x[i] + y[i] * y[i]);
  }
  CHECK(static_cast<double>(fixed.linear_impulse_x(z.q(), z.p()) - impulse_x) == Approx(0).margin(1e-15));
  CHECK(static_cast<double>(fixed.linear_impulse_y(z.q(), z.p()) - impulse_y) == Approx(0).margin(1e-15));
  CHECK(static_cast<double>(fixed.angular_impulse(z.q(), z.p()) - angular) == Approx(0).margin(1e-14));
}

}  // namespace

TEST_CASE("The gradient of the NLS lattice is that of its energy, for every size", "[systems]") {
  lattice_of_fixed_size_agrees<1>();
  lattice_of_fixed_size_agrees<2>();
  lattice_of_fixed_size_agrees<3>();
  lattice_of_fixed_size_agrees<5>();
  lattice_of_fixed_size_agrees<8>();
  lattice_of_fixed_size_agrees<9>();
  lattice_of_fixed_size_agrees<16>();
  lattice_of_fixed_size_agrees<64>();
  lattice_of_fixed_size_agrees<65>();
  lattice_of_fixed_size_agrees<100>();
}

TEST_CASE("The NLS lattice in double and float agrees with long double", "[systems]") {
  PhasePoint<double, 7> z;
  for (int i = 0; i < 14; ++i) z.vector()[i] = static_cast<double>(number(i));
  const PhasePoint<Real, 7> wide(z.q().cast<Real>(), z.p().cast<Real>());
  const PhasePoint<float, 7> narrow(z.q().cast<float>(), z.p().cast<float>());
  const auto g = gradient_of(systems::NlsLattice<double, 7>{}, z);
  const auto w = gradient_of(systems::NlsLattice<Real, 7>{}, wide);
  const auto n = gradient_of(systems::NlsLattice<float, 7>{}, narrow);
  CHECK((g.vector() - w.vector().cast<double>()).norm() <= 1e-14);
  CHECK((g.vector() - n.vector().cast<double>()).norm() <= 1e-5);
}

TEST_CASE("The energy of the NLS lattice is the published sum", "[systems]") {
  PhasePoint<Real, 4> z;
  for (int i = 0; i < 8; ++i) z.vector()[i] = number(i);
  const auto q = z.q(), p = z.p();
  Real sum = 0;
  for (int i = 0; i < 4; ++i) {
    const Real density = q[i] * q[i] + p[i] * p[i];
    sum += density * density / 4;
  }
  for (int i = 1; i < 4; ++i)
    sum -= p[i - 1] * p[i - 1] * p[i] * p[i] + q[i - 1] * q[i - 1] * q[i] * q[i] -
           q[i - 1] * q[i - 1] * p[i] * p[i] - p[i - 1] * p[i - 1] * q[i] * q[i] +
           4 * p[i - 1] * p[i] * q[i - 1] * q[i];
  CHECK(static_cast<double>(systems::NlsLattice<Real, 4>{}.energy(q, p) - sum) == Approx(0).margin(1e-17));
  CHECK(systems::NlsLattice<Real, 4>::mass(q, p) == Approx(static_cast<double>(z.vector().squaredNorm())));
}

TEST_CASE("The gradient of point vortices is that of their energy, for every number", "[systems]") {
  vortices_agree<1>();
  vortices_agree<2>();
  vortices_agree<3>();
  vortices_agree<10>();
  vortices_agree<16>();
  vortices_agree<17>();
  vortices_agree<40>();
}

TEST_CASE("The product system: gradient, Hessian, closed form of the energy", "[systems]") {
  const systems::Product<Real> h;
  const PhasePoint<Real, 1> z(-1.7L, 0.6L);
  gradient_is_that_of_the_energy(h, z);
  CHECK(h.energy(z.q(), z.p()) == Approx(static_cast<double>((1.7L * 1.7L + 1) * (0.36L + 1) / 2)));
  Eigen::Matrix<Real, 2, 2> hessian;
  h.hessian(z.q(), z.p(), hessian);
  const Real delta = 1e-5L;
  for (int k = 0; k < 2; ++k) {
    PhasePoint<Real, 1> ahead = z, behind = z;
    ahead.vector()[k] += delta;
    behind.vector()[k] -= delta;
    const auto column =
        ((gradient_of(h, ahead).vector() - gradient_of(h, behind).vector()) / (2 * delta)).eval();
    CHECK(static_cast<double>((hessian.col(k) - column).norm()) <= 1e-12);
  }
}

TEST_CASE("Two vortices turn about each other at the known rate", "[systems]") {
  const double g1 = 1.5, g2 = -0.4, distance = 0.8, pi = std::acos(-1.0);
  const systems::PointVortices<double, 2> h({g1, g2});
  PhasePoint<double, 2> z = h.phase_point({0, distance}, {0, 0});
  Semiexplicit stepper(h, schemes::low_defect6_s13());
  integrate(stepper, z, {.dt = 0.01, .steps = 100});
  const double angle = (g1 + g2) / (2 * pi * distance * distance);  // after t = 1
  const auto x = h.x(z.q()), y = h.y(z.p());
  CHECK(x[1] - x[0] == Approx(distance * std::cos(angle)).epsilon(1e-12));
  CHECK(y[1] - y[0] == Approx(distance * std::sin(angle)).epsilon(1e-12));
  // About their centre.
  CHECK(g1 * x[0] + g2 * x[1] == Approx(g2 * distance).epsilon(1e-13));
  CHECK(g1 * y[0] + g2 * y[1] == Approx(0).margin(1e-14));
}

TEST_CASE("An opposite pair moves straight on at the known speed", "[systems]") {
  const double gamma = 2.5, distance = 0.5, pi = std::acos(-1.0);
  const systems::PointVortices<double, 2> h({gamma, -gamma});
  PhasePoint<double, 2> z = h.phase_point({0, 0}, {distance / 2, -distance / 2});
  Semiexplicit stepper(h, schemes::blanes_moan4(), Broyden{});
  integrate(stepper, z, {.dt = 0.01, .steps = 200});
  const auto x = h.x(z.q()), y = h.y(z.p());
  for (int i = 0; i < 2; ++i) {
    CHECK(x[i] == Approx(2 * gamma / (2 * pi * distance)).epsilon(1e-12));
    CHECK(y[i] == Approx(i == 0 ? distance / 2 : -distance / 2).epsilon(1e-12));
  }
}

TEST_CASE("Systems refuse what makes no sense, and say so", "[systems]") {
  CHECK(says(refusal([] { systems::NlsLattice<double> h(0); }), "0 sites asked for; give one or more"));
  CHECK(says(refusal([] { systems::NlsLattice<double> h(-3); }), "-3 sites"));
  CHECK(says(refusal([] { systems::NlsLattice<double, 5> h(4); }), "4 sites asked for; give 5"));

  using Vortices = systems::PointVortices<double>;
  const auto vortices = [](std::initializer_list<double> list) {
    return refusal([&] {
      Vortices h(Eigen::Map<const Eigen::VectorXd>(list.begin(), static_cast<Eigen::Index>(list.size())));
    });
  };
  CHECK(says(vortices({}), "no circulation given"));
  CHECK(says(vortices({1, 0, 2}), "circulation 1 is zero or not finite"));
  CHECK(says(vortices({1, 2, std::nan("")}), "circulation 2 is zero or not finite"));
  CHECK(says(vortices({std::numeric_limits<double>::infinity()}), "circulation 0"));
  CHECK(vortices({1, -1e-9}) == accepted);
  const Vortices pair(Eigen::Vector2d(1, 2));
  CHECK(says(refusal([&] { pair.phase_point(Eigen::Vector3d(1, 2, 3), Eigen::Vector2d(1, 2)); }),
             "2 circulations, but 3 x and 2 y"));
  const Eigen::Vector3d three(1, 2, 3);
  CHECK(says(refusal([&] { pair.x(three); }), "3 degrees of freedom and the vortices 2"));
  CHECK(says(refusal([&] { pair.y(three); }), "3 degrees of freedom and the vortices 2"));
}

TEST_CASE("Vortices that coincide have no gradient, and a step fails without harm", "[systems]") {
  for (const int n : {2, 3, 20}) {
    CAPTURE(n);
    const systems::PointVortices<double> h(Eigen::VectorXd::Constant(n, 1.5));
    Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, 0, 5);
    x[n - 1] = x[0];
    const auto z = h.phase_point(x, x);
    const auto g = gradient_of(h, z);
    CHECK(std::isnan(g.q()[0]));
    CHECK(std::isnan(g.p()[n - 1]));
    const auto fails = [&](auto stepper) {
      typename decltype(stepper)::State state(z);
      const auto report = stepper.step(state, 0.01);
      CHECK(report.status == Status::not_finite);
      CHECK(state.q() == z.q());
      CHECK(state.p() == z.p());
    };
    fails(Semiexplicit(h, schemes::strang()));
    fails(Semiexplicit(h, schemes::strang(), Broyden{}));
    fails(MidpointProjection(h, schemes::strang()));
    fails(Pihajoki(h, schemes::strang()));
    fails(Tao(h, schemes::strang(), 1.0));
    fails(GaussLegendre(h));
  }
}

TEST_CASE("A large lattice stepped block by block takes the steps of the whole gradient", "[systems]") {
  // Sizes about the length of a block, where ends meet.
  for (const Eigen::Index sites : {64, 65, 128, 129, 200}) {
    CAPTURE(sites);
    const systems::NlsLattice<double> lattice(sites);
    PhasePoint<double, Eigen::Dynamic> u(sites);
    for (Eigen::Index i = 0; i < 2 * sites; ++i) u.vector()[i] = std::sin(1.0 + 3.7 * double(i * i));
    auto v = u;
    Semiexplicit in_blocks(lattice, schemes::blanes_moan4());
    Semiexplicit at_once(Whole{lattice}, schemes::blanes_moan4());
    for (int n = 0; n < 5; ++n) {
      REQUIRE(in_blocks.step(u, 0.01).ok());
      REQUIRE(at_once.step(v, 0.01).ok());
    }
    CHECK((u.vector() - v.vector()).norm() <= 1e-14 * v.vector().norm());
  }
}

}  // namespace test_systems
