#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "lattice_energy.hpp"

namespace test_tangent_map {

// The derivative of a step: symplectic, and the limit of differences of the step.

namespace {

using namespace semiexplicit;
using Extended = long double;

/// max |MᵀJM - J|.
template <class Matrix>
auto asymmetry(const Matrix& m) {
  const Eigen::Index d = m.rows() / 2;
  Matrix j = Matrix::Zero(m.rows(), m.cols());
  j.topRightCorner(d, d).setIdentity();
  j.bottomLeftCorner(d, d) = -j.topRightCorner(d, d);
  return (m.transpose() * j * m - j).cwiseAbs().maxCoeff();
}

/// The derivative of stepper.step by differences, extrapolated from two steps h and h/2.
template <class S>
auto differences(S& stepper, const typename S::State& z, typename S::Scalar dt, typename S::Scalar h) {
  using Scalar = typename S::Scalar;
  const Eigen::Index size = z.vector().size();
  Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic> m(size, size);
  const auto slope = [&](Eigen::Index i, Scalar shift) {
    auto above = z, below = z;
    above.vector()[i] += shift;
    below.vector()[i] -= shift;
    REQUIRE(stepper.step(above, dt).ok());
    REQUIRE(stepper.step(below, dt).ok());
    return ((above.vector() - below.vector()) / (2 * shift)).eval();
  };
  for (Eigen::Index i = 0; i < size; ++i) m.col(i) = (4 * slope(i, h / 2) - slope(i, h)) / 3;
  return m;
}

const PhasePoint<double, 3> lattice_point({0.8, -0.3, 0.5}, {0.2, 0.9, -0.6});

/// A pendulum whose driving has the period 1: all late times below are the time 0.
struct Driven {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = std::sin(q[0]) * (1 + 0.5 * std::cos(std::acos(-1.0) * 2 * (t - std::floor(t))));
    dHdp[0] = p[0];
  }
};

/// V(x/length)·strength of one coordinate with a gradient, and with its Hessian too: cos x or -eˣ.
template <class Scalar_>
struct Plain {
  using Scalar = Scalar_;
  static constexpr int Dof = 1;
  bool exponential = false;
  Scalar length = 1, strength = 1;
  void gradient(In<Scalar, 1> q, In<Scalar, 1> p, Out<Scalar, 1> dHdq, Out<Scalar, 1> dHdp) const {
    dHdq[0] = strength * (exponential ? std::exp(q[0] / length) : std::sin(q[0] / length));
    dHdp[0] = p[0];
  }
};
template <class Scalar>
struct WithHessian : Plain<Scalar> {
  void hessian(In<Scalar, 1> q, In<Scalar, 1>, Eigen::Ref<Eigen::Matrix<Scalar, 2, 2>> out) const {
    out.setIdentity();
    out(0, 0) = this->strength / this->length *
                (this->exponential ? std::exp(q[0] / this->length) : std::cos(q[0] / this->length));
  }
};

/// With one that adds, and leaves out what is 0.
struct AddsHessian : Plain<double> {
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> out) const {
    out(1, 1) += 1;
    if (std::abs(q[0]) > 0.1) out(0, 0) = std::cos(q[0]);
  }
};
struct AddsProduct : Plain<double> {
  void hessian_times(In<double, 1> q, In<double, 1>, In<double, 1> dq, In<double, 1> dp, Out<double, 1> hq,
                     Out<double, 1> hp) const {
    hq += std::cos(q[0]) * dq;
    hp += dp;
  }
};

/// How far the tangent map by differences is from the one by the Hessian, of all steps of a run; it has seen
/// another place before.
template <class Scalar>
Scalar difference_of_maps(const Plain<Scalar>& plain, PhasePoint<Scalar, 1> z, Scalar dt, int steps = 1) {
  const auto scheme = schemes::low_defect6_s13<Scalar>();
  TangentMap<Plain<Scalar>> by_gradient(plain, scheme);
  TangentMap<WithHessian<Scalar>> exact(WithHessian<Scalar>{plain}, scheme);
  static_assert(HasHessian<WithHessian<Scalar>> && !HasHessian<Plain<Scalar>>);
  Semiexplicit stepper(plain, scheme,
                       SimplifiedNewton{.stop = StoppingRule::product(sizeof(Scalar) == 4 ? 1e-8 : 1e-16)});
  PhasePoint<Scalar, 1> other(z.q()[0] / 1000, Scalar(0.1) * plain.length);
  REQUIRE(by_gradient.at(other, dt) == Status::success);
  Scalar worst(0);
  for (int n = 0; n < steps; ++n) {
    REQUIRE(by_gradient.at(z, dt) == Status::success);
    REQUIRE(exact.at(z, dt) == Status::success);
    REQUIRE(asymmetry(by_gradient.matrix()) <= 64 * std::numeric_limits<Scalar>::epsilon());
    worst = std::max(worst, (by_gradient.matrix() - exact.matrix()).cwiseAbs().maxCoeff());
    REQUIRE(stepper.step(z, dt).ok());
  }
  return worst;
}

}  // namespace

TEST_CASE("The tangent map is symplectic and the limit of differences", "[chaos]") {
  const auto H = from_energy<3>(lattice_energy);
  const SimplifiedNewton tight{.stop = StoppingRule::product(1e-30)};
  for (const auto& scheme : {schemes::strang(), schemes::low_defect6_s13()})
    for (const double dt : {0.2, -0.05}) {
      CAPTURE(scheme.name, dt);
      Semiexplicit stepper(H, scheme, tight);
      TangentMap tangent(stepper);
      REQUIRE(tangent.at(lattice_point, dt) == Status::success);
      CHECK(asymmetry(tangent.matrix()) <= 1e-13);
      CHECK((tangent.matrix() - differences(stepper, lattice_point, dt, 1e-3)).cwiseAbs().maxCoeff() <=
            1e-11);
      // It is not the identity, nor the derivative of the step without projection.
      CHECK((tangent.matrix() - Eigen::Matrix<double, 6, 6>::Identity()).norm() > 0.1);
    }
}

TEST_CASE("A Hessian may add to what it is given, or leave out what is 0", "[chaos]") {
  const auto scheme = schemes::low_defect6_s13();
  TangentMap own(AddsHessian{}, scheme);
  TangentMap exact(WithHessian<double>{}, scheme);
  TangentVectors vectors(Semiexplicit(AddsProduct{}, scheme), 2);
  const PhasePoint<double, 1> z(0.8, 0.3);
  REQUIRE(own.at(PhasePoint<double, 1>(0.4, -0.2), 0.1) == Status::success);
  REQUIRE(own.at(z, 0.1) == Status::success);
  REQUIRE(exact.at(z, 0.1) == Status::success);
  REQUIRE(vectors.advance(z, 0.1).ok());
  CHECK((own.matrix() - exact.matrix()).norm() <= 1e-14);
  CHECK((vectors.vectors() - exact.matrix()).norm() <= 1e-13);
}

TEST_CASE("Without a Hessian the tangent map is approximate, and symplectic still", "[chaos]") {
  const systems::NlsLattice<double, 3> H;
  static_assert(!HasHessian<decltype(H)>);
  Semiexplicit stepper(from_energy<3>(lattice_energy), schemes::strang());
  TangentMap exact(stepper);
  TangentMap approximate(H, schemes::strang());
  REQUIRE(exact.at(lattice_point, 0.2) == Status::success);
  REQUIRE(approximate.at(lattice_point, 0.2) == Status::success);
  CHECK(asymmetry(approximate.matrix()) <= 1e-13);
  const double difference = (exact.matrix() - approximate.matrix()).cwiseAbs().maxCoeff();
  CHECK(difference <= 1e-8);
  CHECK(difference > 1e-14);
}

TEST_CASE("The tangent map has the precision of its numbers", "[chaos]") {
  const systems::Product<Extended> H;
  Semiexplicit stepper(H, schemes::blanes_moan4<Extended>(),
                       SimplifiedNewton{.stop = StoppingRule::product(1e-38)});
  TangentMap tangent(stepper);
  const PhasePoint<Extended, 1> z(-1.5L, 0.4L);
  REQUIRE(tangent.at(z, 0.2L) == Status::success);
  CHECK(asymmetry(tangent.matrix()) <= 1e-18L);
  CHECK((tangent.matrix() - differences(stepper, z, 0.2L, 1e-4L)).cwiseAbs().maxCoeff() <= 1e-14L);
}

TEST_CASE("Steps that hardly converge have a tangent map", "[chaos]") {
  Semiexplicit stepper(systems::Product<Extended>(), schemes::strang<Extended>(),
                       SimplifiedNewton{.stop = StoppingRule::product(1e-38), .max_iterations = 1000});
  const PhasePoint<Extended, 1> z(-3, 0);
  auto end = z;
  CHECK(stepper.step(end, 0.36L).evaluations > 50);
  TangentMap tangent(stepper);
  REQUIRE(tangent.at(z, 0.36L) == Status::success);
  CHECK(asymmetry(tangent.matrix()) <= 1e-16L);
  CHECK((tangent.matrix() - differences(stepper, z, 0.36L, 1e-4L)).cwiseAbs().maxCoeff() <= 1e-10L);
}

TEST_CASE("A tangent map that cannot be had says why", "[chaos]") {
  TangentMap tangent(systems::Product<Extended>(), schemes::strang<Extended>());
  CHECK(tangent.at({1, 2}, 0) == Status::invalid_step);
  CHECK(tangent.at({1, NAN}, 0.1L) == Status::invalid_state);
  CHECK(tangent.at({1e4000L, 1e4000L}, 0.1L) == Status::not_finite);
  CHECK(tangent.matrix() == Eigen::Matrix<Extended, 2, 2>::Identity());
}

TEST_CASE("Second derivatives by differences at the ends of the range of numbers end in a status",
          "[chaos]") {
  for (const double amplitude : {1e10, 1e16, 1e30, 1e150, 1e300}) {
    CAPTURE(amplitude);
    const Autonomous shaken(from_energy<1>([=](const auto& t, const auto& q, const auto& p) {
      using std::cos, std::sin;
      const auto velocity = p[0] + amplitude * sin(10 * t) * sin(q[0]);
      return velocity * velocity / 2 - cos(q[0]);
    }));
    Semiexplicit stepper(shaken, schemes::low_defect6_s13());
    TangentMap tangent(stepper);
    CHECK(tangent.at(shaken.extended({3, 0}, 0), 0.01) != Status::success);
  }
}

TEST_CASE("The time of a driven system does not loosen its tangent map, nor does a start from rest",
          "[chaos]") {
  const Autonomous driven(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2 - q[0] * cos(t);
  }));
  Semiexplicit stepper(driven, schemes::blanes_moan4());
  TangentMap tangent(stepper);
  const double late = 6.283185307179586 * 1e9;  // the same phase, to 1e-6
  REQUIRE(tangent.at(driven.extended({1, 0.5}, 0.0), 0.1) == Status::success);
  const auto early = tangent.matrix();
  REQUIRE(tangent.at(driven.extended({1, 0.5}, late), 0.1) == Status::success);
  CHECK((tangent.matrix() - early).topLeftCorner(1, 1).norm() < 1e-5);
  CHECK(asymmetry(tangent.matrix()) < 1e-9);
  CHECK(tangent.at(driven.extended({0, 0}, 0.0), 0.1) == Status::success);
}

/// Duffing's oscillators in a chain, coupled weakly.
struct WeakChain {
  using Scalar = double;
  static constexpr int Dof = 6;
  void gradient(In<double, 6> q, In<double, 6> p, Out<double, 6> dHdq, Out<double, 6> dHdp) const {
    dHdq = q.array().cube().matrix() - q;
    dHdp = p;
    for (int i = 0; i < 5; ++i) {
      const double force = 1e-6 * (q[i] - q[i + 1]);
      dHdq[i] += force;
      dHdq[i + 1] -= force;
    }
  }
};
struct WeakChainWithHessian : WeakChain {
  void hessian(In<double, 6> q, In<double, 6>, Eigen::Ref<Eigen::Matrix<double, 12, 12>> out) const {
    out.setIdentity();
    for (int i = 0; i < 6; ++i) out(i, i) = 3 * q[i] * q[i] - 1 + (i % 5 == 0 ? 1e-6 : 2e-6);
    for (int i = 0; i < 5; ++i) out(i, i + 1) = out(i + 1, i) = -1e-6;
  }
};

TEST_CASE("Differences for a Hessian suit couplings that are far weaker than the forces", "[chaos]") {
  const auto scheme = schemes::low_defect6_s13();
  TangentMap<WeakChain> by_gradient(WeakChain(), scheme);
  TangentMap<WeakChainWithHessian> exact(WeakChainWithHessian(), scheme);
  Semiexplicit stepper(WeakChain(), scheme);
  // Along one vector, too: the other oscillators hardly move it.
  TangentVectors one(stepper, 1);
  one.vectors().setZero();
  one.vectors()(0, 0) = 1;
  PhasePoint<double, 6> z;
  for (int i = 0; i < 6; ++i) z.q()[i] = 0.05 * (i + 1), z.p()[i] = 0.1 * i;
  for (int n = 0; n < 200; ++n) {
    REQUIRE(by_gradient.at(z, 0.05) == Status::success);
    REQUIRE(exact.at(z, 0.05) == Status::success);
    CHECK((by_gradient.matrix() - exact.matrix()).cwiseAbs().maxCoeff() <= 1e-9);
    const Eigen::Matrix<double, 12, 1> expected = exact.matrix() * one.vectors().col(0);
    REQUIRE(one.advance(z, 0.05).ok());
    CHECK((one.vectors().col(0) - expected).norm() <= 1e-8 * expected.norm());
    REQUIRE(stepper.step(z, 0.05).ok());
  }
}

TEST_CASE("The tangent map of a driven system needs no derivative with respect to the time", "[chaos]") {
  const Autonomous driven(Driven{});
  Semiexplicit stepper(driven, schemes::low_defect6_s13());
  TangentMap tangent(stepper);
  const auto z = driven.extended({1, 0.2}, 0.3);
  REQUIRE(tangent.at(z, 0.1) == Status::success);
  CHECK(asymmetry(tangent.matrix()) <= 1e-13);
  CHECK((tangent.matrix() - differences(stepper, z, 0.1, 1e-3)).topRows(3).cwiseAbs().maxCoeff() <= 1e-9);
}

TEST_CASE("Differences for a Hessian suit a time that is far larger than the state", "[chaos]") {
  const Autonomous driven(Driven{});
  TangentMap tangent(driven, schemes::low_defect6_s13());
  REQUIRE(tangent.at(driven.extended({1, 0.2}, 0), 0.02) == Status::success);
  const Eigen::Matrix4d early = tangent.matrix();
  for (const double t0 : {1e3, 1e6, 1e9, 1e12, -1e12}) {
    CAPTURE(t0);
    REQUIRE(tangent.at(driven.extended({1, 0.2}, t0), 0.02) == Status::success);
    CHECK(asymmetry(tangent.matrix()) <= 1e-13);
    // As far as the rounding of the times allows.
    CHECK((tangent.matrix() - early).cwiseAbs().maxCoeff() <= 1e-9 + std::cbrt(std::abs(t0) * 2e-16) / 4);
    Eigen::Matrix2d late, soon;  // of q and p alone
    late << tangent.matrix()(0, 0), tangent.matrix()(0, 2), tangent.matrix()(2, 0), tangent.matrix()(2, 2);
    soon << early(0, 0), early(0, 2), early(2, 0), early(2, 2);
    CHECK((late - soon).cwiseAbs().maxCoeff() <= 1e-9 + std::abs(t0) * 1e-15);
  }
}

TEST_CASE("Differences for a Hessian suit an angle that has wound up, and one near 0", "[chaos]") {
  const double turn = 6.283185307179586;
  for (const double q : {0.0, 0.5, 629.0, 6e4, 6e5, 1e6 * turn + 0.5, -6e5}) {
    CAPTURE(q);
    const double allowed = 3e-9 + 10 * std::pow(2.2e-16 * std::abs(q), 2.0 / 3);
    CHECK(difference_of_maps<double>({}, {q, 0.3}, 0.3) <= allowed);
    CHECK(difference_of_maps<double>({}, {q, 2.5}, 0.3, 100) <= allowed);  // it goes on turning
    const double allowed_float = 2e-3 + 10 * std::pow(1.2e-7 * std::abs(q), 2.0 / 3);
    if (q < 1e3) CHECK(difference_of_maps<float>({}, {static_cast<float>(q), 0.3F}, 0.3F) <= allowed_float);
  }
  for (const double q : {0.0, 1e-6, -1e-10, 1e-12, 1e-14, 1e-100})
    for (const double dt : {0.1, 1e-3}) {
      CAPTURE(q, dt);
      CHECK(difference_of_maps<double>({.exponential = true}, {q, 0}, dt) <= 1e-8 * dt);
      CHECK(difference_of_maps<float>({.exponential = true}, {static_cast<float>(q), 0}, float(dt)) <= 1e-3);
    }
  // Metres and seconds: an orbit's size, and an atom's.
  for (const double length : {1e11, 1e-10, 1e5}) {
    CAPTURE(length);
    const Plain<double> units{.exponential = false, .length = length, .strength = length};
    for (const double q : {0.5, 3.0, -40.0})
      CHECK(difference_of_maps<double>(units, {q * length, 0.3 * length}, 0.3, 100) <= 1e-7);
  }
}

TEST_CASE("The map of a step is as good far from the origin as the rounding of the place lets it",
          "[chaos]") {
  // Against the same place an angle of whole turns back, in a wider type.
  const auto make = [](auto zero) {
    using Scalar = decltype(zero);
    return Semiexplicit(from_energy<1, Scalar>([](const auto& q, const auto& p) {
                          return p[0] * p[0] * (1 + cos(q[0]) * Scalar(0.5)) / 2 - cos(q[0]);
                        }),
                        schemes::strang<Scalar>());
  };
  const auto worst = [&](auto zero, double far) {
    using Scalar = decltype(zero);
    double most = 0;
    for (int i = 0; i < 50; ++i) {
      const Scalar q = static_cast<Scalar>(far + 0.37 * i), p = static_cast<Scalar>(1.3 + 0.01 * i);
      const Extended turn = 8 * std::atan(Extended(1));
      TangentMap map(make(zero));
      TangentMap exact(make(Extended(0)));
      REQUIRE(map.at({q, p}, Scalar(1)) == Status::success);
      REQUIRE(exact.at({std::fmod(static_cast<Extended>(q), turn), static_cast<Extended>(p)}, 1) ==
              Status::success);
      const auto off = (map.matrix().template cast<Extended>() - exact.matrix()).norm();
      most = std::max(most, static_cast<double>(off / exact.matrix().norm()));
    }
    return most;
  };
  CHECK(worst(0.0, 1e4) <= 1e-9);
  CHECK(worst(0.0, 1e8) <= 1e-6);
  CHECK(worst(0.0F, 0) <= 5e-5);
  CHECK(worst(0.0F, 1e3) <= 4e-4);
}

}  // namespace test_tangent_map
