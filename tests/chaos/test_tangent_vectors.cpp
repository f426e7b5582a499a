#include "catch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "henon_heiles.hpp"
#include "lattice_energy.hpp"
#include "refusal.hpp"
#include "tangent_lattice.hpp"

namespace test_tangent_vectors {

// Tangent vectors carried along by a step: the dense derivative of the step times them.

namespace {

using namespace tangent_lattice;

/// How far the vectors carried by one step are from the dense map times them, relative to their size.
template <class Stepper, class Exact>
double error_of_vectors(const Stepper& stepper, const Exact& exact,
                        const PhasePoint<typename Stepper::Scalar, Stepper::Dof>& z, double dt,
                        Eigen::Index count = 3) {
  using Scalar = typename Stepper::Scalar;
  TangentVectors tangents(stepper, count);
  fill(tangents.vectors());
  const auto before = tangents.vectors();
  REQUIRE(tangents.advance(z, Scalar(dt)).ok());
  TangentMap dense(exact, stepper.scheme());
  REQUIRE(dense.at(z, Scalar(dt)) == Status::success);
  Scalar worst(0);
  for (Eigen::Index j = 0; j < count; ++j)
    worst = std::max(
        worst, (tangents.vectors().col(j) - dense.matrix() * before.col(j)).norm() / before.col(j).norm());
  return static_cast<double>(worst);
}

const SimplifiedNewton tight{.stop = StoppingRule::product(1e-32)};

/// Hénon and Heiles' system in halves.
struct Halves {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr bool separable = true;
  using SeparableGradientOf = Halves;
  void position_gradient(In<double, 2> q, Out<double, 2> dVdq) const {
    dVdq[0] = q[0] + 2 * q[0] * q[1];
    dVdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
  }
  void momentum_gradient(In<double, 2> p, Out<double, 2> dTdp) const { dTdp = p; }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    position_gradient(q, dHdq);
    momentum_gradient(p, dHdp);
  }
  void hessian_times(In<double, 2> q, In<double, 2>, In<double, 2> dq, In<double, 2> dp, Out<double, 2> hq,
                     Out<double, 2> hp) const {
    hq[0] = dq[0] + 2 * (dq[0] * q[1] + q[0] * dq[1]);
    hq[1] = dq[1] + 2 * (q[0] * dq[0] - q[1] * dq[1]);
    hp = dp;
  }
};

/// The same with a gradient of any numbers in place of second derivatives.
struct HalvesOfNumbers {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr bool separable = true;
  using SeparableGradientOf = HalvesOfNumbers;
  using PackGradientOf = HalvesOfNumbers;
  void position_gradient(auto& q, auto& dVdq) const { Halves().position_gradient(q, dVdq); }
  void momentum_gradient(In<double, 2> p, Out<double, 2> dTdp) const { dTdp = p; }
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = q[0] + 2.0 * q[0] * q[1];
    dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
    dHdp[0] = p[0];
    dHdp[1] = p[1];
  }
};
static_assert(detail::HasDualGradient<HalvesOfNumbers> && !HasHessianTimes<HalvesOfNumbers>);

struct Rotors {  // angles that turn, coupled to their neighbours; the last one to nothing
  using Scalar = double;
  static constexpr int Dof = 8;
  void gradient(In<double, 8> q, In<double, 8> p, Out<double, 8> dHdq, Out<double, 8> dHdp) const {
    for (int i = 0; i < 7; ++i) dHdq[i] = std::sin(q[i]);
    for (int i = 0; i < 6; ++i) {
      const double force = std::sin(q[i] - q[i + 1]);
      dHdq[i] += force;
      dHdq[i + 1] -= force;
    }
    dHdq[7] = 0;
    dHdp = p;
  }
};
struct RotorsExactly : Rotors {
  void hessian_times(In<double, 8> q, In<double, 8>, In<double, 8> dq, In<double, 8> dp, Out<double, 8> hq,
                     Out<double, 8> hp) const {
    for (int i = 0; i < 7; ++i) hq[i] = std::cos(q[i]) * dq[i];
    for (int i = 0; i < 6; ++i) {
      const double force = std::cos(q[i] - q[i + 1]) * (dq[i] - dq[i + 1]);
      hq[i] += force;
      hq[i + 1] -= force;
    }
    hq[7] = 0;
    hp = dp;
  }
};

/// An oscillator whose gradient is NaN beyond 1, and throws beyond 2.
struct Walled {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    if (q[0] > 2) throw std::domain_error("beyond 2");
    dHdq[0] = q[0] > 1 ? std::numeric_limits<double>::quiet_NaN() : q[0];
    dHdp[0] = p[0];
  }
  void hessian_times(In<double, 1>, In<double, 1>, In<double, 1> dq, In<double, 1> dp, Out<double, 1> hq,
                     Out<double, 1> hp) const {
    hq = dq;
    hp = dp;
  }
};

/// How far the vectors by differences come from the exact ones in some steps, relative to their size.
double error_by_differences(PhasePoint<double, 8> z, int steps) {
  const auto scheme = schemes::low_defect6_s13();
  Semiexplicit stepper(Rotors{}, scheme);
  TangentVectors by_differences(stepper, 2);
  TangentVectors exact(Semiexplicit(RotorsExactly{}, scheme), 2);
  fill(exact.vectors());
  by_differences.vectors() = exact.vectors();
  double worst = 0;
  for (int n = 0; n < steps; ++n) {
    REQUIRE(by_differences.advance(z, 0.1).ok());
    REQUIRE(exact.advance(z, 0.1).ok());
    REQUIRE(stepper.step(z, 0.1).ok());
    for (const int j : {0, 1})
      worst = std::max(worst, (by_differences.vectors().col(j) - exact.vectors().col(j)).norm() /
                                  exact.vectors().col(j).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("Tangent vectors are the dense map times vectors", "[chaos][long]") {
  const auto exact = from_energy<5>(lattice_energy);
  const auto z = some_point<double, 5>(5);
  const auto scheme = schemes::low_defect6_s13();
  for (const double dt : {0.1, -0.2}) {
    CAPTURE(dt);
    const Semiexplicit by_product(WithProduct<double, 5>{}, scheme, tight);
    CHECK(error_of_vectors(by_product, exact, z, dt) <= 3e-15);
    const Semiexplicit by_duals(systems::NlsLattice<double, 5>(), scheme, tight);
    for (const Eigen::Index count : {1, 6, 9})
      CHECK(error_of_vectors(by_duals, exact, z, dt, count) <= 3e-15);
    const Semiexplicit by_hessian(exact, scheme, tight);
    CHECK(error_of_vectors(by_hessian, exact, z, dt) <= 3e-15);
    // By differences along each of few vectors, and by a matrix for many.
    const Semiexplicit by_differences(GradientOnly<double, 5>{}, scheme, tight);
    CHECK(error_of_vectors(by_differences, exact, z, dt) <= 1e-8);
    CHECK(error_of_vectors(by_differences, exact, z, dt, 5) <= 1e-8);
    // With the usual rule the point is not found to rounding.
    CHECK(error_of_vectors(Semiexplicit(WithProduct<double, 5>{}, scheme), exact, z, dt) <= 1e-8);
  }
}

TEST_CASE("Tangent vectors of any size and precision, and of every solver", "[chaos]") {
  using Extended = long double;
  const auto lattice = from_energy<Extended>(4, lattice_energy);
  const auto wide = some_point<Extended, Eigen::Dynamic>(4);
  const SimplifiedNewton tighter{.stop = StoppingRule::product(1e-38)};
  const systems::NlsLattice<Extended> by_duals(4);
  CHECK(error_of_vectors(Semiexplicit(by_duals, schemes::blanes_moan4<Extended>(), tighter), lattice, wide,
                         0.1) <= 1e-17);
  const auto short_lattice = from_energy<float>(4, lattice_energy);
  const SimplifiedNewton loose{.stop = StoppingRule::product(1e-12)};
  CHECK(error_of_vectors(Semiexplicit(systems::NlsLattice<float>(4), schemes::blanes_moan4<float>(), loose),
                         short_lattice, some_point<float, Eigen::Dynamic>(4), 0.1) <= 3e-6);

  const auto exact = from_energy<5>(lattice_energy);
  const WithProduct<double, 5> h;
  const auto z = some_point<double, 5>(5);
  const auto strang = schemes::strang();
  CHECK(error_of_vectors(Semiexplicit(h, strang, Broyden{.stop = tight.stop}), exact, z, 0.3) <= 1e-14);
  CHECK(error_of_vectors(Semiexplicit(h, strang, NewtonKrylov{.stop = tight.stop}), exact, z, 0.3) <= 1e-12);
  CHECK(error_of_vectors(Semiexplicit(h, strang, Robust{}), exact, z, 0.3) <= 1e-7);
}

TEST_CASE("Tangent vectors at the ends of the range of numbers", "[chaos]") {
  const Semiexplicit stepper(HenonHeilesWithProduct{}, schemes::blanes_moan4());
  const auto z = HenonHeiles::point(0.1);
  TangentVectors unit(stepper, 1);
  REQUIRE(unit.advance(z, 0.1).ok());
  for (const int power : {-1030, 1023}) {
    TangentVectors tangents(stepper, 1);
    tangents.vectors() *= std::ldexp(1.0, power);
    REQUIRE(tangents.advance(z, 0.1).ok());
    for (int i = 0; i < 4; ++i)
      CHECK(std::ldexp(tangents.vectors()(i, 0), -power) == Approx(unit.vectors()(i, 0)).margin(1e-12));
  }
}

TEST_CASE("Tangent vectors by dual numbers are those by products", "[chaos]") {
  const auto compare = [](const auto& by_duals, const auto& by_product, const auto& z, Eigen::Index count) {
    TangentVectors found(by_duals, count);
    TangentVectors wanted(by_product, count);
    fill(found.vectors());
    wanted.vectors() = found.vectors();
    REQUIRE(found.advance(z, 0.1).ok());
    REQUIRE(wanted.advance(z, 0.1).ok());
    for (Eigen::Index j = 0; j < count; ++j)
      CHECK((found.vectors().col(j) - wanted.vectors().col(j)).norm() <=
            1e-14 * wanted.vectors().col(j).norm());
  };
  constexpr int any = Eigen::Dynamic;
  const systems::NlsLattice<double> lattice(200);  // kicked in blocks
  const WithProduct<double, any> product{{lattice}};
  for (const Eigen::Index count : {1, 7})
    compare(Semiexplicit(lattice, schemes::strang(), tight), Semiexplicit(product, schemes::strang(), tight),
            some_point<double, any>(200), count);
  for (const Eigen::Index count : {2, 6})
    compare(ExplicitSplitting(HalvesOfNumbers{}, schemes::blanes_moan4()),
            ExplicitSplitting(Halves{}, schemes::blanes_moan4()), some_point<double, 2>(2), count);
}

TEST_CASE("Tangent vectors of the explicit methods are the limit of differences", "[chaos]") {
  const auto limit = [](auto stepper, const auto& z) {
    TangentVectors tangents(stepper, 2);
    fill(tangents.vectors());
    const auto before = tangents.vectors();
    REQUIRE(tangents.advance(z, 0.2).ok());
    for (const int j : {0, 1}) {
      const auto slope = [&](double shift) {
        auto above = z, below = z;
        above.vector() += shift * before.col(j).normalized();
        below.vector() -= shift * before.col(j).normalized();
        REQUIRE(stepper.step(above, 0.2).ok());
        REQUIRE(stepper.step(below, 0.2).ok());
        return ((above.vector() - below.vector()) / (2 * shift) * before.col(j).norm()).eval();
      };
      const auto found = ((4 * slope(5e-4) - slope(1e-3)) / 3).eval();
      CHECK((tangents.vectors().col(j) - found).norm() <= 1e-10 * found.norm());
    }
  };
  limit(MidpointProjection(WithProduct<double, 5>{}, schemes::blanes_moan4()), some_point<double, 5>(5));
  limit(ExplicitSplitting(Halves{}, schemes::blanes_moan4()), some_point<double, 2>(2));
}

TEST_CASE("Differences along vectors suit angles that have wound up, and one that is coupled to nothing",
          "[chaos]") {
  PhasePoint<double, 8> z;
  for (int i = 0; i < 8; ++i) {
    z.q()[i] = 0.3 * i;
    z.p()[i] = 0.2 + 0.1 * i;
  }
  const auto allowed = [](double q) { return 3e-8 + 100 * std::pow(2.2e-16 * q, 2.0 / 3); };
  CHECK(error_by_differences(z, 40) <= allowed(0));
  for (const double turns : {1e2, 1e4, 1e6}) {
    CAPTURE(turns);
    auto wound = z;
    wound.q().head<7>().array() += turns * 2 * std::acos(-1.0);
    CHECK(error_by_differences(wound, 40) <= allowed(6.3 * turns));
    auto one = z;  // only one has wound up
    one.q()[3] += turns * 2 * std::acos(-1.0);
    CHECK(error_by_differences(one, 40) <= allowed(6.3 * turns));
  }
  for (const double far : {1e6, 1e12}) {
    auto uncoupled = z;
    uncoupled.q()[7] = far;
    CAPTURE(far);
    CHECK(error_by_differences(uncoupled, 40) <= allowed(0));
  }
}

namespace {

/// Six coupled coordinates between walls at -1 and 1, outside of which the gradient throws.
struct Walls {
  using Scalar = double;
  static constexpr int Dof = 6;
  double energy(In<double, 6> q, In<double, 6> p) const {
    double sum = 0;
    for (int i = 0; i < 6; ++i)
      sum += (1 + q[i] * q[i]) * p[i] * p[i] / 2 - std::log1p(-q[i] * q[i]) / 2 + q[i] * q[(i + 1) % 6] / 10;
    return sum;
  }
  void gradient(In<double, 6> q, In<double, 6> p, Out<double, 6> dHdq, Out<double, 6> dHdp) const {
    for (int i = 0; i < 6; ++i) {
      if (!(std::abs(q[i]) < 1)) throw std::domain_error("behind the wall");
      dHdq[i] = q[i] * p[i] * p[i] + q[i] / (1 - q[i] * q[i]) + (q[(i + 1) % 6] + q[(i + 5) % 6]) / 10;
      dHdp[i] = (1 + q[i] * q[i]) * p[i];
    }
  }
};

struct WallsWithHessian : Walls {
  void hessian(In<double, 6> q, In<double, 6> p, Eigen::Ref<Eigen::Matrix<double, 12, 12>> hessian) const {
    hessian.setZero();
    for (int i = 0; i < 6; ++i) {
      const double room = 1 - q[i] * q[i];
      hessian(i, i) = p[i] * p[i] + (1 + q[i] * q[i]) / (room * room);
      hessian(i, (i + 1) % 6) = hessian(i, (i + 5) % 6) = 0.1;
      hessian(i, 6 + i) = hessian(6 + i, i) = 2 * q[i] * p[i];
      hessian(6 + i, 6 + i) = 1 + q[i] * q[i];
    }
  }
};

}  // namespace

TEST_CASE("A gradient that throws out of its domain is differentiated up to the border", "[chaos]") {
  Semiexplicit stepper(Walls(), schemes::strang(), tight);
  PhasePoint<double, 6> z;
  z.q() << 0.9, -0.5, 0.97, 0.2, -0.99, 0.7;
  z.p() << 0.1, 0.3, -0.2, 0.5, 0.05, -0.4;
  REQUIRE(error_of_vectors(stepper, WallsWithHessian(), z, 0.002, 1) < 1e-8);
  Semiexplicit with_hessian(WallsWithHessian(), schemes::strang(), tight);
  TangentMap exact(with_hessian);
  TangentMap map(stepper);
  REQUIRE(exact.at(z, 0.002) == Status::success);
  REQUIRE(map.at(z, 0.002) == Status::success);
  REQUIRE((map.matrix() - exact.matrix()).norm() < 1e-8 * exact.matrix().norm());
  LyapunovExponents growth(stepper, 1);
  LyapunovExponents exact_growth(with_hessian, 1);
  auto there = z;
  REQUIRE(integrate(stepper, there, {.dt = 0.002, .steps = 500}, growth).ok());
  REQUIRE(integrate(with_hessian, z, {.dt = 0.002, .steps = 500}, exact_growth).ok());
  REQUIRE(growth.exponents()[0] == Approx(exact_growth.exponents()[0]).epsilon(1e-6));
}

TEST_CASE("Where a step has no derivative the vectors stay", "[chaos]") {
  const Walled h;
  TangentVectors tangents(Semiexplicit(h, schemes::strang()), 2);
  tangents.vectors() << 1e5, 3, 0.1, 1e-9;
  const Eigen::Matrix2d before = tangents.vectors();
  CHECK(tangents.advance({1.5, 0}, 0.1).status == Status::not_finite);
  CHECK(tangents.vectors() == before);
  CHECK_THROWS_AS(tangents.advance({3, 0}, 0.1), std::domain_error);
  CHECK(tangents.vectors() == before);
  CHECK(tangents.advance({0.5, 0}, 0).status == Status::invalid_step);
  CHECK(tangents.advance({NAN, 0}, 0.1).status == Status::invalid_state);
  CHECK(tangents.vectors() == before);
  REQUIRE(tangents.advance({0.5, 0.5}, 0.1).ok());
  CHECK(tangents.vectors() != before);
  CHECK(refuses([&] { TangentVectors(Semiexplicit(h, schemes::strang()), 0); }, "give one or more"));
  // A step far too long.
  TangentVectors stiff(Semiexplicit(WithProduct<double, 5>{}, schemes::strang()), 1);
  CHECK(!stiff.advance(some_point<double, 5>(5), 50).ok());
  CHECK(stiff.vectors() == Eigen::Matrix<double, 10, 1>::Unit(0));
}

TEST_CASE("A hessian_times that is no derivative of the gradient is refused", "[chaos]") {
  const auto z = some_point<double, 5>(5);
  WithProduct<double, 5> h;
  const auto start = [&] {
    LyapunovExponents lyapunov(Semiexplicit(h, schemes::strang()), 1);
    lyapunov(0.0, z);
  };
  CHECK_NOTHROW(start());
  h.factor = 1.001;  // too near for differences to be trusted
  CHECK_NOTHROW(start());
  h.factor = 2;
  CHECK(refuses(start, "hessian_times of the Hamiltonian is not the derivative of its gradient"));
  h.factor = -1;
  CHECK(refuses(start, "hessian_times"));
}

TEST_CASE("Tangent vectors of another number or size than was asked for are refused", "[chaos]") {
  const auto h =
      from_energy(2, [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; });
  PhasePoint<double, Eigen::Dynamic> z(2);
  z.q() << 1, 2;
  for (const Eigen::Index columns : {1, 3, 4}) {
    TangentVectors tangents(Semiexplicit(h, schemes::strang()), 2);
    tangents.vectors() = Eigen::MatrixXd::Identity(4, columns);
    CHECK(refuses([&] { tangents.advance(z, 0.1); },
                  "has been given 4 rows and " + std::to_string(columns) + " columns"));
    CHECK(refuses([&] { tangents.check(z); }, "has been given 4 rows"));
    CHECK(refuses([&] { tangents.unit_of_momenta(z); }, "has been given 4 rows"));
  }
  TangentVectors tangents(Semiexplicit(h, schemes::strang()), 2);
  tangents.vectors() = Eigen::MatrixXd::Identity(6, 2);
  CHECK(refuses([&] { tangents.advance(z, 0.1); }, "has been given 6 rows"));
  tangents.vectors() = Eigen::MatrixXd::Identity(4, 2);
  CHECK(tangents.advance(z, 0.1).ok());
  CHECK(std::abs(tangents.vectors()(0, 0) - std::cos(0.1)) < 1e-3);
}

}  // namespace test_tangent_vectors
