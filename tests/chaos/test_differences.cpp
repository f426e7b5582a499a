// Second derivatives by differences of the gradient, in systems that are hard for them.
#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_differences {

using namespace semiexplicit;

/// A satellite near the lighter of two bodies that turn, in their frame.
struct Satellite {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr double lighter = 3.04e-6;
  double length = 1;
  template <class Q, class P>
  static auto unscaled(const Q& q, const P& p) {
    using std::sqrt;
    const auto x = q[0] + lighter, y = q[0] - 1 + lighter;
    return
        typename Q::Scalar((p[0] * p[0] + p[1] * p[1]) / 2 - q[0] * p[1] + q[1] * p[0] -
                           (1 - lighter) / sqrt(x * x + q[1] * q[1]) - lighter / sqrt(y * y + q[1] * q[1]));
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    const double x = q[0] / length, y = q[1] / length, u = x + lighter, v = u - 1;
    const double far = std::pow(u * u + y * y, 1.5), near = std::pow(v * v + y * y, 1.5);
    dHdq[0] = (-p[1] / length + (1 - lighter) * u / far + lighter * v / near) * length;
    dHdq[1] = (p[0] / length + ((1 - lighter) / far + lighter / near) * y) * length;
    dHdp[0] = p[0] + q[1];
    dHdp[1] = p[1] - q[0];
  }
};

TEST_CASE("A tangent map by differences is right close to a body, in any units", "[chaos]") {
  const auto exact_h = from_energy<2>([](const auto& q, const auto& p) { return Satellite::unscaled(q, p); });
  const auto scheme = schemes::low_defect6_s13();
  for (const double length : {1e-3, 1.0, 1e11})
    for (const double distance : {1e-2, 2.8e-4, 4.6e-5}) {
      CAPTURE(length, distance);
      TangentMap exact(exact_h, scheme);
      TangentMap by_gradient(Satellite{length}, scheme);
      Semiexplicit stepper(exact_h, scheme);
      const double speed = std::sqrt(Satellite::lighter / distance);
      PhasePoint<double, 2> z({1 - Satellite::lighter + distance, 0}, {0, speed + 1 + distance});
      const double dt = 0.05 * distance / speed;
      for (int n = 0; n < 20; ++n) {
        PhasePoint<double, 2> scaled;
        scaled.vector() = length * z.vector();
        REQUIRE(exact.at(z, dt) == Status::success);
        REQUIRE(by_gradient.at(scaled, dt) == Status::success);
        CHECK((by_gradient.matrix() - exact.matrix()).norm() <= 1e-6 * exact.matrix().norm());
        REQUIRE(stepper.step(z, dt).ok());
      }
    }
}

/// Rotors in a ring.
struct Rotors {
  using Scalar = double;
  static constexpr int Dof = 6;
  void gradient(In<double, 6> q, In<double, 6> p, Out<double, 6> dHdq, Out<double, 6> dHdp) const {
    for (int i = 0; i < 6; ++i) dHdq[i] = std::sin(q[i] - q[(i + 1) % 6]) + std::sin(q[i] - q[(i + 5) % 6]);
    dHdp = p;
  }
};

TEST_CASE("Tangent vectors by differences are right where momenta begin at zero", "[chaos]") {
  const auto ring = from_energy<6>([](const auto& q, const auto& p) {
    using std::cos;
    typename std::decay_t<decltype(q)>::Scalar sum(0);
    for (Eigen::Index i = 0; i < 6; ++i) sum += p[i] * p[i] / 2 - cos(q[i] - q[(i + 1) % 6]);
    return sum;
  });
  const auto scheme = schemes::low_defect6_s13();
  TangentVectors exact(Semiexplicit(ring, scheme), 1);
  TangentVectors by_gradient(Semiexplicit(Rotors(), scheme), 1);
  for (int i = 0; i < 12; ++i) exact.vectors()(i, 0) = std::sin(1 + i * i);
  by_gradient.vectors() = exact.vectors();
  Semiexplicit stepper(ring, scheme);
  PhasePoint<double, 6> z;
  z.p().setZero();
  for (int i = 0; i < 6; ++i) z.q()[i] = i % 2 == 0 ? 0 : std::acos(-1.0);  // an unstable equilibrium
  for (int n = 0; n < 40; ++n) {
    REQUIRE(exact.advance(z, 0.05).ok());
    REQUIRE(by_gradient.advance(z, 0.05).ok());
    CHECK((by_gradient.vectors() - exact.vectors()).norm() <= 1e-6 * exact.vectors().norm());
    REQUIRE(stepper.step(z, 0.05).ok());
  }
}

namespace {

/// Two bodies in the plane that only feel each other, in other units: nothing holds their centre.
template <class T, class Q, class P>
T energy_of_pair(const Q& q, const P& p) {
  using std::sqrt;
  const T x = q[0] - q[2], y = q[1] - q[3];
  return (p[0] * p[0] + p[1] * p[1]) / 2 + (p[2] * p[2] + p[3] * p[3]) / 6 - T(3) / sqrt(x * x + y * y);
}

auto pair_in_units(double length, double momentum) {
  return from_energy<4>([=](const auto& q, const auto& p) {
    using T = typename std::decay_t<decltype(q)>::Scalar;
    const Eigen::Matrix<T, 4, 1> x = q / T(length), y = p / T(momentum);
    return T(T(length * momentum) * energy_of_pair<T>(x, y));
  });
}

}  // namespace

TEST_CASE("Where second derivatives are given, units of positions and momenta are of no account", "[chaos]") {
  PhasePoint<double, 4> start;
  start.q() << 0.75, 0.1, -0.25, 0.05;
  start.p() << 0.1, 1.3, -0.1, -1.25;
  const auto with = [&](double length, double momentum, const auto& use) {
    PhasePoint<double, 4> z = start;
    z.q() *= length;
    z.p() *= momentum;
    use(pair_in_units(length, momentum), z);
    z.q() /= length;
    z.p() /= momentum;
    return z;
  };
  for (const auto& [length, momentum] : {std::pair{0x1p37, 0x1p120}, {0x1p-10, 0x1p-90}}) {
    CAPTURE(length, momentum);
    Eigen::Matrix<double, 8, 8> plain, in_units;
    const auto map_to = [](auto& matrix) {
      return [&](const auto& h, auto& z) {
        TangentMap map(h, schemes::low_defect4_s7());
        for (int step = 0; step < 10; ++step) {
          REQUIRE(map.at(z, 0.01) == Status::success);
          Semiexplicit(h, schemes::low_defect4_s7()).step(z, 0.01);
        }
        matrix = map.matrix();
      };
    };
    with(1, 1, map_to(plain));
    with(length, momentum, map_to(in_units));
    in_units.topRightCorner(4, 4) *= momentum / length;
    in_units.bottomLeftCorner(4, 4) *= length / momentum;
    CHECK((in_units - plain).norm() <= 1e-14 * plain.norm());

    const auto by_gauss = [](const auto& h, auto& z) {
      GaussLegendre gauss(h, {.stages = 3, .solver = StageSolver::newton});
      CHECK(integrate(gauss, z, {.dt = 0.02, .steps = 20}).ok());
    };
    CHECK((with(length, momentum, by_gauss).vector() - with(1, 1, by_gauss).vector()).norm() <= 1e-12);
  }
}

namespace {

/// A relativistic electron in a trap, in SI units.
struct Electron {
  using Scalar = double;
  static constexpr int Dof = 1;
  static constexpr double mass = 9.109e-31, light = 2.998e8, strength = 1e-9;
  double root(double p) const { return std::sqrt(mass * mass * light * light + p * p); }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = strength * q[0] * (1 + q[0] * q[0] * 1e4);
    dHdp[0] = light * p[0] / root(p[0]);
  }
};
struct ElectronWithHessian : Electron {
  void hessian(In<double, 1> q, In<double, 1> p, Eigen::Ref<Eigen::Matrix2d> hessian) const {
    hessian.setZero();
    hessian(0, 0) = strength * (1 + 3 * q[0] * q[0] * 1e4);
    hessian(1, 1) = light * std::pow(mass * light / root(p[0]), 2) / root(p[0]);
  }
};

/// A harmonic well with a narrow hill in it.
struct Hill {
  using Scalar = double;
  static constexpr int Dof = 1;
  double width;
  double force(double x) const { return 0.1 * std::exp(-x * x); }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double x = (q[0] - 1) / width;
    dHdq[0] = q[0] - 2 * x / width * force(x);
    dHdp[0] = p[0];
  }
};
struct HillWithHessian : Hill {
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> hessian) const {
    const double x = (q[0] - 1) / width;
    hessian << 1 + (4 * x * x - 2) / (width * width) * force(x), 0, 0, 1;
  }
};

/// How far the tangent map by differences is from the exact one, relative to what the exact one changes.
template <class H, class Exact>
double error_of_map(const H& h, const Exact& exact, const PhasePoint<double, 1>& z, double dt) {
  TangentMap map(h, schemes::strang());
  TangentMap right(exact, schemes::strang());
  REQUIRE(map.at(z, dt) == Status::success);
  REQUIRE(right.at(z, dt) == Status::success);
  double error = 0;
  for (const auto& [i, j] : {std::pair{0, 1}, {1, 0}})
    error = std::max(error, std::abs(map.matrix()(i, j) / right.matrix()(i, j) - 1));
  return error;
}

}  // namespace

/// H = (a x² + b y² + c px² + d py²)/2 + k x px² + e |z|⁴/4.
template <class T>
struct Quartic {
  using Scalar = T;
  static constexpr int Dof = 2;
  T a = T(-0.17), b = T(0.25), c = T(0.034), d = T(0.93), k = T(0.095), e = T(0.1);
  void gradient(In<T, 2> q, In<T, 2> p, Out<T, 2> dHdq, Out<T, 2> dHdp) const {
    const T r = e * (q.squaredNorm() + p.squaredNorm());
    dHdq[0] = (a + r) * q[0] + k * p[0] * p[0];
    dHdq[1] = (b + r) * q[1];
    dHdp[0] = (c + r) * p[0] + 2 * k * q[0] * p[0];
    dHdp[1] = (d + r) * p[1];
  }
};
struct WithHessian : Quartic<double> {
  void hessian(In<double, 2> q, In<double, 2> p, Eigen::Ref<Eigen::Matrix4d> result) const {
    const double r = e * (q.squaredNorm() + p.squaredNorm());
    const Eigen::Vector4d z(q[0], q[1], p[0], p[1]);
    result = 2 * e * z * z.transpose();
    result.diagonal() += Eigen::Vector4d(a + r, b + r, c + r + 2 * k * q[0], d + r);
    result(0, 2) += 2 * k * p[0];
    result(2, 0) += 2 * k * p[0];
  }
};

/// How far M of h by differences is off, at most, along a run; by that of `exact`, in double.
template <class H, class E>
double worst_along(const H& h, const E& exact, const char* scheme, PhasePoint<typename H::Scalar, H::Dof> z,
                   typename H::Scalar dt, int steps) {
  Semiexplicit stepper(h, schemes::by_name<typename H::Scalar>(scheme));
  TangentMap by_gradient(stepper);
  TangentMap by_hessian(exact, schemes::by_name<double>(scheme));
  double worst = 0;
  for (int n = 0; n < steps; ++n) {
    const PhasePoint<double, H::Dof> same(z.q().template cast<double>(), z.p().template cast<double>());
    REQUIRE(by_gradient.at(z, dt) == Status::success);
    REQUIRE(by_hessian.at(same, static_cast<double>(dt)) == Status::success);
    worst = std::max(worst, (by_gradient.matrix().template cast<double>() - by_hessian.matrix()).norm() /
                                by_hessian.matrix().norm());
    stepper.step(z, dt);
  }
  return worst;
}

TEST_CASE("Differences in float give up no half of a column for digits of the other", "[chaos]") {
  // The force is quadratic in px, so that no shift is too long for it; ∂H/∂px is not.
  double worst = 0;
  for (int k = 0; k < 60; ++k) {
    const PhasePoint<float, 2> z({0.3F * std::sin(1.7F * float(k)), 0.33F * std::cos(2.3F * float(k))},
                                 {0.02F * std::sin(3.1F * float(k) + 1), 0.57F * std::cos(1.1F * float(k))});
    worst = std::max(worst, worst_along(Quartic<float>(), WithHessian(), "low_defect4_s7", z, 0.05F, 40));
  }
  CHECK(worst < 2e-5);
}

/// Two pendula, weakly coupled; lengths count in that unit.
struct Pendula {
  using Scalar = float;
  static constexpr int Dof = 2;
  float unit = 1, coupling = 0;
  void gradient(In<float, 2> q, In<float, 2> p, Out<float, 2> dHdq, Out<float, 2> dHdp) const {
    dHdq[0] = unit * std::sin(q[0] / unit) + coupling * q[1];
    dHdq[1] = 2 * unit * std::sin(q[1] / unit) + coupling * q[0];
    dHdp = p;
  }
};
struct PendulaWithHessian : Pendula {
  void hessian(In<float, 2> q, In<float, 2>, Eigen::Ref<Eigen::Matrix4f> result) const {
    result.setIdentity();
    result(0, 0) = std::cos(q[0] / unit), result(1, 1) = 2 * std::cos(q[1] / unit);
    result(0, 1) = result(1, 0) = coupling;
  }
};

TEST_CASE("Differences in float do not step over a system in small units", "[chaos]") {
  const auto scheme = schemes::low_defect6_s13<float>();
  for (const float unit : {1.0F, 1e-3F, 1e-4F, 1e-5F, 1e-6F, 1e-7F, 1e6F}) {
    float worst = 0;
    for (int k = 0; k < 400; ++k) {
      const float n = static_cast<float>(k);
      const Pendula pendula{unit, 0.5F + 0.5F * std::sin(n)};
      const PhasePoint<float, 2> z({unit * std::sin(1.7F * n), unit * std::cos(2.3F * n)},
                                   {unit * std::sin(3.1F * n + 1), unit * std::cos(1.1F * n)});
      TangentMap<Pendula> by_gradient(pendula, scheme);
      TangentMap<PendulaWithHessian> exact(PendulaWithHessian{pendula}, scheme);
      REQUIRE(by_gradient.at(z, 0.1F) == Status::success);
      REQUIRE(exact.at(z, 0.1F) == Status::success);
      worst = std::max(worst, (by_gradient.matrix() - exact.matrix()).norm() / exact.matrix().norm());
    }
    CAPTURE(unit);
    CHECK(worst < 1e-5F);
  }
}

/// A chain of sites, each with a quartic well of its own and coupled to the next ones.
template <class T>
struct Chain {
  using Scalar = T;
  static constexpr int Dof = 5;
  T coupling = T(0.1);
  void gradient(In<T, 5> q, In<T, 5> p, Out<T, 5> dHdq, Out<T, 5> dHdp) const {
    for (int i = 0; i < 5; ++i) {
      const T before = i > 0 ? q[i - 1] : T(0), after = i < 4 ? q[i + 1] : T(0);
      dHdq[i] = (1 + 2 * coupling + q[i] * q[i]) * q[i] - coupling * (before + after);
      dHdp[i] = (1 + p[i] * p[i]) * p[i];
    }
  }
};
struct ChainWithHessian : Chain<double> {
  void hessian(In<double, 5> q, In<double, 5> p, Eigen::Ref<Eigen::Matrix<double, 10, 10>> result) const {
    result.setZero();
    for (int i = 0; i < 5; ++i) {
      result(i, i) = 1 + 2 * coupling + 3 * q[i] * q[i], result(i + 5, i + 5) = 1 + 3 * p[i] * p[i];
      if (i > 0) result(i, i - 1) = result(i - 1, i) = -coupling;
    }
  }
};

/// How far second derivatives are off, at most, along a run in steps of dt from a chain of which one site
/// moves. The sites beyond are smaller by that factor each.
template <class T>
double worst_of_chain(const char* scheme, T factor, T dt, int steps) {
  PhasePoint<T, 5> z;
  for (int i = 0; i < 5; ++i) z.q()[i] = (i > 0 ? z.q()[i - 1] : T(0.9)) * (i > 0 ? factor : T(1));
  return worst_along(Chain<T>(), ChainWithHessian(), scheme, z, dt, steps) / static_cast<double>(dt);
}

TEST_CASE("Differences are right where one site of a chain moves and the others hardly", "[chaos]") {
  for (const double factor : {1e-1, 1e-4, 1e-8, 1e-12, 0.0}) {
    CAPTURE(factor);
    CHECK(worst_of_chain<double>("low_defect6_s13", factor, 0.1, 40) < 1e-8);
    CHECK(worst_of_chain<float>("low_defect6_s13", static_cast<float>(factor), 0.1F, 40) < 1e-4);
  }
  // The first kicks from rest: sites of the sizes dt³ and dt⁶.
  for (const double dt : {1e-2, 1e-3, 1e-4}) {
    CAPTURE(dt);
    CHECK(worst_of_chain<double>("strang", 0.0, dt, 3) < 1e-6);
  }
}

/// A dimple of that width in the middle of a bowl; a bump, where its depth is below 0.
template <class T>
struct Dimple {
  using Scalar = T;
  static constexpr int Dof = 2;
  T width = 1, depth = T(0.15);
  T deep(In<T, 2> q) const { return 2 * depth * std::exp(-q.squaredNorm() / (width * width)); }
  void gradient(In<T, 2> q, In<T, 2> p, Out<T, 2> dHdq, Out<T, 2> dHdp) const {
    dHdq = (1 - deep(q)) * q;
    dHdp = p;
  }
};
struct DimpleWithHessian : Dimple<double> {
  void hessian(In<double, 2> q, In<double, 2>, Eigen::Ref<Eigen::Matrix4d> result) const {
    result.setIdentity();
    result.diagonal().head<2>().array() -= deep(q);
    result.topLeftCorner<2, 2>() += 2 * deep(q) / (width * width) * q * q.transpose();
  }
};

TEST_CASE("Shifts that were found on a plain are not kept within a bump, in float", "[chaos]") {
  double worst = 0;
  for (int k = 1; k <= 40; ++k) {
    const float n = static_cast<float>(k), width = 0.3F + 0.2F * std::sin(n);
    const Dimple<float> dimple{width, 0.1F * std::cos(2 * n) / (width * width)};
    const PhasePoint<float, 2> z({std::sin(3 * n), std::cos(5 * n)}, {std::sin(7 * n), std::sin(11 * n)});
    worst = std::max(worst, worst_along(dimple, DimpleWithHessian{{dimple.width, dimple.depth}},
                                        "low_defect4_s7", z, 0.1F, 200));
  }
  CHECK(worst < 5e-4);
}

/// |p|²/2 + (px y - py x)/3 + k |q|⁴/4 in a frame that turns.
struct Turning {
  using Scalar = double;
  static constexpr int Dof = 2;
  double k = 0;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = Eigen::Vector2d(-p[1], p[0]) / 3 + k * q.squaredNorm() * q;
    dHdp = p + Eigen::Vector2d(q[1], -q[0]) / 3;
  }
};
struct TurningWithHessian : Turning {
  void hessian(In<double, 2> q, In<double, 2>, Eigen::Ref<Eigen::Matrix4d> result) const {
    result.setIdentity();
    result.topLeftCorner<2, 2>() =
        k * (q.squaredNorm() * Eigen::Matrix2d::Identity() + 2 * q * q.transpose());
    result(0, 3) = result(3, 0) = -1.0 / 3, result(1, 2) = result(2, 1) = 1.0 / 3;
  }
};

TEST_CASE(
    "Differences are right where momenta are rounding in a frame that turns, and at rest in a quartic well",
    "[chaos]") {
  const auto off = [](double k, const PhasePoint<double, 2>& z, double dt) {
    return worst_along(Turning{k}, TurningWithHessian{{k}}, "low_defect4_s7", z, dt, 1);
  };
  for (const double p : {0.0, 1e-6, 1e-10, 1e-14, 1e-18, -5.5e-17}) {
    CAPTURE(p);
    CHECK(off(0, {{0.8, 0.6}, {p, -p / 3}}, 0.1) < 1e-10);
  }
  for (const double p : {1e-3, 1.0, 1e2, 1e4}) {  // from the middle, where no second derivative is
    CAPTURE(p);
    CHECK(off(1, {{0, 0}, {p, p / 2}}, 0.02 / std::sqrt(p)) < 1e-7);
  }
}

/// A chain of atoms between walls, displaced by q from where they are at rest; each on a spring of its own.
struct Bonds {
  static auto energy(double unit) {
    return [unit](const auto& q, const auto& p) {
      auto sum = p[0] * p[0] / 2 + q[0] * q[0] / (2 * unit * unit);
      for (int i = 1; i < 4; ++i) sum += p[i] * p[i] / 2 + q[i] * q[i] / (2 * unit * unit);
      for (int i = 0; i < 3; ++i) {
        const auto r = 1 + (q[i + 1] - q[i]) / unit, inverse = 1 / (r * r * r * r * r * r);
        sum += inverse * inverse - 2 * inverse;
      }
      return sum;
    };
  }
};

TEST_CASE("Differences are right for a chain of atoms at rest, whose second derivatives are believed",
          "[chaos]") {
  for (const double unit : {1.0, 1e-3, 1e-6, 1e5}) {
    const auto chain = from_energy<4>(Bonds::energy(unit));
    const auto by_gradient = make_hamiltonian<double, 4>(
        [=](const auto& q, const auto& p) { return chain.energy(q, p); },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { chain.gradient(q, p, dHdq, dHdp); });
    const PhasePoint<double, 4> rest;
    Semiexplicit stepper(chain, schemes::low_defect4_s7<double>());
    TangentMap exact(stepper);
    TangentMap map(by_gradient, schemes::low_defect4_s7<double>());
    REQUIRE(exact.at(rest, 0.1 * unit) == Status::success);
    REQUIRE(map.at(rest, 0.1 * unit) == Status::success);
    CAPTURE(unit);
    CHECK((map.matrix() - exact.matrix()).norm() <= 1e-7 * exact.matrix().norm());
    PhasePoint<double, 4> z;
    LyapunovExponents exponents(stepper, 2);
    CHECK(integrate(stepper, z, {.dt = 0.1 * unit, .steps = 3}, exponents).ok());
  }
}

namespace {

/// A spring with a hill on either side of its middle, in a unit of length.
struct BetweenHills {
  using Scalar = double;
  static constexpr int Dof = 1;
  double unit, place, height, steep;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    double force = q[0] / unit;
    for (const double x : {q[0] / unit - place, q[0] / unit + place})
      force -= 2 * steep * height * x * std::exp(-steep * x * x);
    dHdq[0] = force / unit;
    dHdp = p;
  }
};
struct BetweenHillsWithHessian : BetweenHills {
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> all) const {
    double bend = 1;
    for (const double x : {q[0] / unit - place, q[0] / unit + place})
      bend += height * (4 * steep * steep * x * x - 2 * steep) * std::exp(-steep * x * x);
    all << bend / unit / unit, 0, 0, 1;
  }
};

/// An oscillator of Morse's, in a unit of length.
struct MorseSpring {
  using Scalar = double;
  static constexpr int Dof = 1;
  double unit;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double e = std::exp(-1.4 * q[0] / unit);
    dHdq[0] = 2.8 * (1 - e) * e * unit;
    dHdp = p;
  }
};
struct MorseWithHessian : MorseSpring {
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> all) const {
    const double e = std::exp(-1.4 * q[0] / unit);
    all << 3.92 * (2 * e - 1) * e, 0, 0, 1;
  }
};

}  // namespace

TEST_CASE("Differences are right in the middle between hills, where rounding hides them from short shifts",
          "[chaos]") {
  for (const double unit : {1.0, 1e-3, 1e-4, 1e-6})
    for (int i = 0; i < 60; ++i) {
      const BetweenHills hills{unit, 0.3 + 0.025 * i, 0.2 + 0.1 * (i % 5), 1.0 + i % 4};
      CAPTURE(unit, hills.place, hills.height, hills.steep);
      for (const double p : {0.0, 0.1})
        CHECK(error_of_map(hills, BetweenHillsWithHessian{hills}, {0, p}, 0.05 * unit) < 1e-7);
    }
}

namespace {

/// Two bonds of Morse's, counted from a minimum that is known to `off`, coupled.
struct CoupledBonds {
  using Scalar = double;
  static constexpr int Dof = 2;
  double off;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    for (int i = 0; i < 2; ++i) {
      const double u = std::exp(-q[i] - off);
      dHdq[i] = 2 * u * (1 - u) + q[1 - i] / 2;
    }
    dHdp = p;
  }
};

/// Sites in a trap upon a hill of that width, light and from rest.
struct OnHills {
  using Scalar = double;
  static constexpr int Dof = 6;
  double width;
  void gradient(In<double, 6> q, In<double, 6> p, Out<double, 6> dHdq, Out<double, 6> dHdp) const {
    dHdq = 1e-3 * (q.array() * (1 - 2 * (-q.array().square() / (width * width)).exp()));
    dHdp = 1e3 * p;
  }
};

/// A pendulum that begins at q = 0 where it is pulled.
template <class T>
struct Pulled {
  using Scalar = T;
  static constexpr int Dof = 1;
  T unit;
  void gradient(In<T, 1> q, In<T, 1> p, Out<T, 1> dHdq, Out<T, 1> dHdp) const {
    dHdq[0] = std::sin(q[0] / unit - 1) / unit;
    dHdp = p;
  }
};
/// Of the map of a step of 0.2 units from rest, ∂p'/∂q in units.
template <class T>
double pull(double unit) {
  TangentMap<Pulled<T>> map(Pulled<T>{T(unit)}, schemes::low_defect6_s13<T>());
  REQUIRE(map.at(PhasePoint<T, 1>(T(0), T(0)), T(0.2 * unit)) == Status::success);
  return double(map.matrix()(1, 0)) * unit;
}

/// H = (1 + cos(t)/2) (1 - cos q) + p²/2.
struct ShakenPendulum {
  using Scalar = double;
  static constexpr int Dof = 1;
  double gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                  Out<double, 1> dHdp) const {
    dHdq[0] = (1 + std::cos(t) / 2) * std::sin(q[0]);
    dHdp = p;
    return -std::sin(t) / 2 * (1 - std::cos(q[0]));
  }
};
/// H = Σ p²/2 + q⁴/(4 w²): without forces at rest, and of no length.
template <int N>
struct OnFlats {
  using Scalar = double;
  static constexpr int Dof = N;
  double width;
  void gradient(In<double, N> q, In<double, N> p, Out<double, N> dHdq, Out<double, N> dHdp) const {
    dHdq = q.array().cube() / (width * width);
    dHdp = p;
  }
};

}  // namespace

TEST_CASE("Differences are right where terms of the gradient cancel, in small oscillations", "[chaos]") {
  for (const double off : {1e-5, 1e-7, 1e-8}) {
    CAPTURE(off);
    const CoupledBonds bonds{off};
    double worst = 0;
    for (int k = 0; k < 200; ++k) {
      detail::SecondDerivatives<CoupledBonds> second(2);
      PhasePoint<double, 2> z({2 * off * std::sin(3 * k + 1), 2 * off * std::cos(5 * k)},
                              {2 * off * std::sin(7 * k), 2 * off * std::cos(11 * k)});
      Eigen::Matrix4d hessian;
      second(bonds, z.vector(), hessian);
      for (int i = 0; i < 2; ++i) {
        const double u = std::exp(-z.q()[i] - off);
        worst = std::max(worst, std::abs(hessian(i, i) - (4 * u - 2) * u));
      }
    }
    CHECK(worst < 1e-7);
  }
}

TEST_CASE("Of a small swing that is driven the rounding of dH/dt does not choose shifts", "[chaos]") {
  for (const double amplitude : {1e-5, 1e-6, 1e-7}) {
    CAPTURE(amplitude);
    Autonomous<ShakenPendulum> shaken(ShakenPendulum{});
    detail::SecondDerivatives<Autonomous<ShakenPendulum>> second(2);
    double worst = 0;
    for (int k = 0; k < 100; ++k) {
      const double t = 0.1 * k;
      const auto z =
          shaken.extended(PhasePoint<double, 1>(amplitude * std::cos(t), -amplitude * std::sin(t)), t);
      Eigen::Matrix4d hessian;
      second(shaken, z.vector(), hessian);
      const double q = z.q()[0], mixed = -std::sin(t) / 2 * std::sin(q);
      worst = std::max({worst, std::abs(hessian(0, 0) - (1 + std::cos(t) / 2) * std::cos(q)),
                        std::abs(hessian(0, 1) - mixed), std::abs(hessian(1, 0) - mixed)});
    }
    CHECK(worst < 1e-8);
  }
}

TEST_CASE("Differences at rest are right where H begins with the fourth power, in any unit", "[chaos]") {
  for (const double width : {1.0, 1e-2, 1e-4, 1e-8}) {
    CAPTURE(width);
    TangentMap map(OnFlats<1>{width}, schemes::low_defect4_s7());
    REQUIRE(map.at(PhasePoint<double, 1>(), 0.05) == Status::success);
    CHECK(std::abs(map.matrix()(1, 0)) < 1e-10);
    CHECK(map.matrix()(0, 1) == Approx(0.05).epsilon(1e-9));

    Semiexplicit stepper{OnFlats<6>{width}};
    LyapunovExponents exponents(stepper, 1);
    PhasePoint<double, 6> z, nowhere;
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 300}, exponents).ok());
    Semiexplicit shallow{OnFlats<6>{1e20}};
    LyapunovExponents right(shallow, 1);
    REQUIRE(integrate(shallow, nowhere, {.dt = 0.1, .steps = 300}, right).ok());
    CHECK(exponents.exponents()[0] == Approx(right.exponents()[0]).epsilon(1e-8));
  }
}

TEST_CASE("Exponents by differences along vectors are the same in any unit, from rest", "[chaos]") {
  const auto exponent = [](double width) {
    Semiexplicit stepper{OnHills{width}};
    LyapunovExponents exponents(stepper, 1);
    PhasePoint<double, 6> z;
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 300}, exponents).ok());
    return exponents.exponents()[0];
  };
  const double right = exponent(1);
  for (const double width : {1e-3, 1e-6, 1e-10}) {
    CAPTURE(width);
    CHECK(exponent(width) == Approx(right).epsilon(1e-6));
  }
}

TEST_CASE("A resumed run's exponents by differences are the same bits at rest", "[chaos][checkpoint]") {
  const Folder folder;
  const auto run = [&](const std::string& file, std::int64_t until) {
    Semiexplicit stepper{OnHills{1}};
    LyapunovExponents exponents(stepper, 1);
    PhasePoint<double, 6> z;
    IntegrationOptions<double> options{.dt = 0.1, .steps = 40};
    Checkpoints checkpoints(folder.path / file, {.every = 5}, stepper, options, exponents);
    options.done = checkpoints.resume(z);
    integrate(stepper, z, options, exponents, checkpoints,
              [&](double, const auto&, const IntegrationReport& report) { return report.steps != until; });
    return exponents.exponents()[0];
  };
  const double whole = run("whole", -1);
  for (const int until : {7, 12, 31}) {
    const std::string file = std::to_string(until);
    run(file, until);
    CHECK(run(file, -1) == whole);
  }
}

TEST_CASE("Differences are right at zero where a force acts, in any unit", "[chaos]") {
  const double right = pull<double>(1);
  for (const double unit : {1e-6, 1e6, 1e11, 1e14}) {
    CAPTURE(unit);
    CHECK(std::abs(pull<double>(unit) - right) < 1e-8);
  }
  for (const double unit : {1e4, 1e6, 1e9}) {
    CAPTURE(unit);
    CHECK(std::abs(pull<float>(unit) - right) < 1e-3);
  }
}

TEST_CASE("Differences are right near the middle of a spring, in any unit", "[chaos]") {
  for (const double unit : {1.0, 1e-15, 1e10, 1e12, 1e18})
    for (const double q : {0.0, 1e-15, -1e-12, 1e-8, -1e-4}) {
      CAPTURE(unit, q);
      const MorseSpring spring{unit};
      for (const double p : {0.1, 0.8})
        CHECK(error_of_map(spring, MorseWithHessian{spring}, {q * unit, p * unit}, 0.1) < 1e-7);
    }
}

TEST_CASE("Differences do not step over what an entry has a part of, on an axis", "[chaos]") {
  // Across the axis the entry is 1 - deep: larger shifts see 1.
  for (const double width : {1.0, 1e-2, 1e-3, 1e-6}) {
    const Dimple<double> dimple{width};
    const double dt = 1e-4;
    TangentMap map(dimple, schemes::strang<double>());
    for (const double x : {0.1, 0.5, 0.9}) {
      const PhasePoint<double, 2> z({x * width, 0}, {0.3 * width, 0});
      REQUIRE(map.at(z, dt) == Status::success);
      CAPTURE(width, x);
      CHECK(-map.matrix()(3, 1) / dt == Approx(1 - dimple.deep(z.q())).epsilon(1e-3));
    }
  }
}

TEST_CASE("A tangent map by differences is right at rest, in any units", "[chaos]") {
  for (const double q : {1e-2, -3e-3, 2e-2})
    for (const double dt : {1e-14, 1e-12})
      CHECK(error_of_map(Electron(), ElectronWithHessian(), {q, 0}, dt) < 1e-8);
  for (const double p : {1e-22, 1e-24})
    CHECK(error_of_map(Electron(), ElectronWithHessian(), {0, p}, 1e-13) < 1e-8);
}

TEST_CASE("A tangent map by differences is right within a hill that is narrow beside the whole", "[chaos]") {
  for (const double width : {1e-1, 1e-2, 1e-3})
    for (const double place : {-2.0, -0.9, 0.1, 0.4, 1.3}) {
      CAPTURE(width, place);
      const HillWithHessian h{width};
      CHECK(error_of_map(Hill{width}, h, {1 + place * width, 0.02}, width / 100) < 1e-6);
    }
}

namespace {

/// An electron in a wave of light, by its momentum across the beam, which nothing changes.
struct ElectronInWave {
  using Scalar = double;
  static constexpr int Dof = 1;
  double mass, speed_of_light, frequency, strength;
  void gradient(double t, In<double, 1>, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double u = p[0] / (mass * speed_of_light) - strength * std::sin(frequency * t);
    dHdq[0] = 0;
    dHdp[0] = speed_of_light * u / std::sqrt(1 + u * u);
  }
};

}  // namespace

TEST_CASE("A tangent map by differences is right from zero where no force acts, in SI units", "[chaos]") {
  for (const double strength : {1e-3, 1.0, 5.0}) {
    CAPTURE(strength);
    const ElectronInWave wave{9.1e-31, 3e8, 2.35e15, strength}, in_ones{1, 1, 1, strength};
    const auto stretch = [](const ElectronInWave& h) {  // dq/dp in its own units
      const Autonomous driven(h);
      TangentMap map(driven, schemes::low_defect6_s13());
      REQUIRE(map.at(driven.extended({0, 0}, 0.0), 0.3 / h.frequency) == Status::success);
      return map.matrix()(0, 2) * h.mass * h.frequency;
    };
    // ∫ (1 + u²)^(-3/2) dt by Simpson's rule
    double right = 0;
    for (int i = 0; i <= 100; ++i) {
      const double u = strength * std::sin(0.003 * i);
      right += (i % 100 == 0 ? 1 : i % 2 == 1 ? 4 : 2) * std::pow(1 + u * u, -1.5) * 0.001;
    }
    CHECK(std::abs(stretch(in_ones) - right) < 1e-4);
    CHECK(std::abs(stretch(wave) - right) < 1e-4);
  }
}

namespace {

/// An atom in a harmonic trap and a standing wave of light, in SI units: many minima within the orbit.
struct LatticeTrap {
  using Scalar = double;
  static constexpr int Dof = 1;
  double ratio;  ///< of both curvatures
  static constexpr double mass = 1.4e-25, wave_number = 8e6, stiffness = 5.5e-20;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = stiffness * (q[0] - ratio / wave_number * std::sin(wave_number * q[0]));
    dHdp[0] = p[0] / mass;
  }
};

/// A spring of Toda's, which overflows 700 lengths away.
struct TodaSpring {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = (1 - std::exp(-q[0] / length)) / length;
    dHdp[0] = p[0];
  }
};
struct TodaWithHessian : TodaSpring {
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> all) const {
    all << std::exp(-q[0] / length) / length / length, 0, 0, 1;
  }
};

}  // namespace

TEST_CASE("A tangent map by differences is right at zero where the gradient overflows not far from it",
          "[chaos]") {
  for (const double length : {1., 1e-9, 1e-14, 1e-20}) {
    CAPTURE(length);
    TangentMap exact(TodaWithHessian{length}, schemes::low_defect4_s7());
    TangentMap by_gradient(TodaSpring{length}, schemes::low_defect4_s7());
    const PhasePoint<double, 1> z(0, 0.7);
    REQUIRE(exact.at(z, 0.1 * length) == Status::success);
    REQUIRE(by_gradient.at(z, 0.1 * length) == Status::success);
    const Eigen::Vector2d scale(length, 1);
    const Eigen::Matrix2d off =
        scale.cwiseInverse().asDiagonal() * (by_gradient.matrix() - exact.matrix()) * scale.asDiagonal();
    CHECK(off.cwiseAbs().maxCoeff() < 1e-9);
  }
}

TEST_CASE("Differences are right where a second derivative passes through zero", "[chaos]") {
  for (const double start : {1e-5, 1e-4}) {
    CAPTURE(start);
    const LatticeTrap h{1};
    const double frequency = std::sqrt(2 * h.stiffness / h.mass);
    Semiexplicit stepper(h, schemes::low_defect4_s7(),
                         SimplifiedNewton{.stop = StoppingRule::product(1e-12)});
    detail::SecondDerivatives<LatticeTrap> second(1);
    PhasePoint<double, 1> z(start, 0);
    double worst = 0;
    for (int n = 0; n < 3000; ++n) {
      Eigen::Matrix2d hessian;
      second(h, z.vector(), hessian);
      const double right = h.stiffness * (1 - std::cos(h.wave_number * z.q()[0]));
      worst = std::max(worst, std::abs(hessian(0, 0) - right) / h.stiffness);
      REQUIRE(stepper.step(z, 0.2 / frequency).ok());
    }
    CHECK(worst < 1e-5);
  }
}

namespace {

/// Two oscillators, each in units of its own, one with a wave on its spring, coupled weakly by a momentum.
struct OwnUnits {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr double wave = 21.8, coupling = 1.4e-5;
  double first, second, action;
  Eigen::Vector4d scale() const { return {first, second, action / first, action / second}; }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    const double x = q[0] / first, y = q[1] / second, u = p[0] * first / action, v = p[1] * second / action;
    dHdq[0] = action / first * (0.035 * x - 0.7 * std::sin(wave * x) / wave + coupling * y * u);
    dHdq[1] = action / second * (0.035 * y + coupling * x * u);
    dHdp[0] = first * (u + coupling * x * y);
    dHdp[1] = second * v;
  }
  /// In units where all is 1.
  Eigen::Matrix4d plain_hessian(const Eigen::Vector4d& z) const {
    const Eigen::Vector4d at = z.cwiseQuotient(scale());
    Eigen::Matrix4d all = Eigen::Vector4d(0.035 - 0.7 * std::cos(wave * at[0]), 0.035, 1, 1).asDiagonal();
    all(0, 1) = all(1, 0) = coupling * at[2];
    all(0, 2) = all(2, 0) = coupling * at[1];
    all(1, 2) = all(2, 1) = coupling * at[0];
    return all;
  }
};

}  // namespace

TEST_CASE("Differences are right where coordinates are in units that are far apart from each other",
          "[chaos]") {
  for (const OwnUnits& h : {OwnUnits{1, 1, 1}, {8, 4e-6, 7e-8}, {4e-6, 8, 7e-8}, {1e-7, 1e4, 1}}) {
    CAPTURE(h.first, h.second);
    Semiexplicit stepper(h, schemes::low_defect4_s7());
    detail::SecondDerivatives<OwnUnits> second(2);
    PhasePoint<double, 2> z;
    z.vector() = h.scale().cwiseProduct(Eigen::Vector4d(-0.16, 0.66, 0, -0.93));
    double worst = 0;
    for (int n = 0; n < 1000; ++n) {
      Eigen::Matrix4d hessian;
      second(h, z.vector(), hessian);
      const Eigen::Matrix4d plain = h.scale().asDiagonal() * hessian * h.scale().asDiagonal() / h.action;
      worst = std::max(worst, (plain - h.plain_hessian(z.vector())).cwiseAbs().maxCoeff());
      REQUIRE(stepper.step(z, 0.01).ok());
    }
    CHECK(worst < 1e-7);
  }
}

namespace {

struct Springs {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index n;
  Eigen::Index dof() const { return n; }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

}  // namespace

TEST_CASE("A wrong Hessian is refused at the origin, where small shifts vanish in rounding", "[chaos]") {
  struct Forgotten : TodaSpring {
    void hessian_times(In<double, 1>, In<double, 1>, In<double, 1>, In<double, 1> dp, Out<double, 1> hq,
                       Out<double, 1> hp) const {
      hq[0] = 0;
      hp = dp;
    }
  };
  for (const double q : {0., 0.1}) {
    Semiexplicit stepper(Forgotten{{1}}, schemes::strang());
    LyapunovExponents lyapunov(stepper, 1);
    CHECK(refuses([&] { lyapunov(0.0, PhasePoint<double, 1>(q, 0.5)); },
                  "hessian_times of the Hamiltonian is not the derivative of its gradient"));
  }
}

namespace {
/// p²/2 + q²/2 + a cos(wq)/w², whose wave usual shifts step over.
template <class Number>
struct Rippled {
  using Scalar = Number;
  static constexpr int Dof = 1;
  Scalar w, a;
  void gradient(In<Scalar, 1> q, In<Scalar, 1> p, Out<Scalar, 1> dHdq, Out<Scalar, 1> dHdp) const {
    dHdq[0] = q[0] - a * std::sin(w * q[0]) / w;
    dHdp[0] = p[0];
  }
  void hessian(In<Scalar, 1> q, In<Scalar, 1>, Eigen::Ref<Eigen::Matrix<Scalar, 2, 2>> second) const {
    second << 1 - a * std::cos(w * q[0]), 0, 0, 1;
  }
};
}  // namespace

TEST_CASE("A Hessian with a fast wave in it, or that is zero at the start, is believed", "[chaos]") {
  const auto begins = []<class Scalar>(Scalar w, Scalar a, Scalar q) {
    CAPTURE(w, a, q);
    LyapunovExponents lyapunov(Semiexplicit(Rippled<Scalar>{.w = w, .a = a}), 1);
    CHECK_NOTHROW(lyapunov(Scalar(0), PhasePoint<Scalar, 1>(q, Scalar(0.3))));
  };
  for (const double w : {30., 1e3, 3e3, 1e4, 1e5})
    for (const double a : {0.5, 1., 1.5})
      for (const double q : {0., 0.5, 10.}) begins(w, a, q);
  for (const float w : {10.f, 100.f, 1e3f})
    for (const float a : {0.5f, 1.f, 3.f})
      for (const float q : {0.f, 0.5f, 1.f}) begins(w, a, q);
}

TEST_CASE("Lyapunov exponents refuse a state of another size", "[chaos][lyapunov]") {
  Semiexplicit stepper(Springs{4}, schemes::strang());
  LyapunovExponents lyapunov(stepper, 1);
  PhasePoint<double, Eigen::Dynamic> z(5);
  z.vector().setOnes();
  CHECK(refuses([&] { lyapunov(0.0, z); }, "another number of degrees of freedom than the stepper"));
}

}  // namespace test_differences
