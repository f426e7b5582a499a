#include "catch.hpp"

#include <cmath>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

namespace test_units {

// Second derivatives by differences of the gradient, in any units: of an ion, a planet, an electron.

namespace {

using namespace semiexplicit;

/// A ring of hard springs whose masses vary, weakly coupled.
template <class Q, class P>
auto energy(const Q& q, const P& p, double weak) {
  using std::sin;
  using Number = typename Q::Scalar;
  Number sum(0);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Number s = sin(q[i]), qq = q[i] * q[i], apart = q[(i + 1) % q.size()] - q[i];
    sum += p[i] * p[i] / 2 * (1 + s * s / 2) + qq / 2 + qq * qq / 4 + Number(weak) * apart * apart / 2;
  }
  return sum;
}

struct Units {
  double time = 1, length = 1, mass = 1;
  double momentum() const { return mass * length / time; }
};

/// The ring in other units, with its gradient and nothing more; one spring is driven.
template <class Scalar_, int N>
struct Ring {
  using Scalar = Scalar_;
  static constexpr int Dof = N;
  Units units;
  double weak;
  void gradient(const In<Scalar, N>& q, const In<Scalar, N>& p, Out<Scalar, N> dHdq,
                Out<Scalar, N> dHdp) const {
    at(0, q, p, dHdq, dHdp);
  }
  void at(double drive, const In<Scalar, N>& q, const In<Scalar, N>& p, Out<Scalar, N> dHdq,
          Out<Scalar, N> dHdp) const {
    const auto length = Scalar(units.length), momentum = Scalar(units.momentum()), time = Scalar(units.time);
    for (int i = 0; i < N; ++i) {
      const Scalar x = q[i] / length, y = p[i] / momentum, s = std::sin(x);
      const Scalar bent = (2 * q[i] - q[(i + 1) % N] - q[(i + N - 1) % N]) / length;
      const Scalar force = y * y / 2 * s * std::cos(x) + x + x * x * x + Scalar(weak) * bent;
      dHdq[i] = (force - (i == 0 ? Scalar(drive) : Scalar(0))) * momentum / time;
      dHdp[i] = y * (1 + s * s / 2) * length / time;
    }
  }
};

/// The same in a drive that begins at its top.
template <class Scalar_, int N>
struct DrivenRing {
  using Scalar = Scalar_;
  static constexpr int Dof = N;
  Ring<Scalar, N> ring;
  void gradient(Scalar t, const In<Scalar, N>& q, const In<Scalar, N>& p, Out<Scalar, N> dHdq,
                Out<Scalar, N> dHdp) const {
    ring.at(0.3 * std::cos(1.3 * static_cast<double>(t) / ring.units.time), q, p, dHdq, dHdp);
  }
};

/// One spring moves far, the others little.
template <class Scalar, int N>
PhasePoint<Scalar, N> start() {
  PhasePoint<Scalar, N> z;
  for (int i = 0; i < N; ++i) {
    z.q()[i] = Scalar(i == 1 ? 2 : 0.1 * std::sin(1 + i));
    z.p()[i] = Scalar(0.2 * std::sin(2 + i));
  }
  return z;
}

/// What coordinates are multiplied by.
template <class Scalar, int N>
Vector<Scalar, 2 * N> scales(const Units& units) {
  Vector<Scalar, 2 * N> result;
  result.template head<N>().setConstant(Scalar(units.length));
  result.template tail<N>().setConstant(Scalar(units.momentum()));
  return result;
}

constexpr Units ion{1e-7, 1e-6, 1e-25}, electron{1e-9, 1e-3, 9.1e-31}, planet{1e7, 1e11, 1e24},
    light{1, 1, 1e-18}, fast{1e-9, 1, 1};
const std::vector<Units> any_units{{}, ion, electron, planet, light, fast};

}  // namespace

TEST_CASE("A tangent map by differences is right in any units, at weak couplings and from rest",
          "[chaos][long]") {
  const auto scheme = schemes::low_defect6_s13();
  for (const double weak : {0.1, 1e-4})
    for (const bool at_rest : {false, true})
      for (const Units& units : any_units) {
        CAPTURE(weak, at_rest, units.time, units.length, units.mass);
        const auto ring = from_energy<3>([&](const auto& q, const auto& p) { return energy(q, p, weak); });
        Semiexplicit stepper(ring, scheme);
        TangentMap exact(ring, scheme);
        TangentMap by_gradient(Ring<double, 3>{units, weak}, scheme);
        const auto scale = scales<double, 3>(units);
        auto z = start<double, 3>();
        if (at_rest) z.p().setZero();
        for (int n = 0; n < 60; ++n) {
          PhasePoint<double, 3> scaled;
          scaled.vector() = scale.cwiseProduct(z.vector());
          REQUIRE(exact.at(z, 0.1) == Status::success);
          REQUIRE(by_gradient.at(scaled, 0.1 * units.time) == Status::success);
          const auto found =
              (scale.cwiseInverse().asDiagonal() * by_gradient.matrix() * scale.asDiagonal()).eval();
          CHECK((found - exact.matrix()).cwiseAbs().maxCoeff() <= 1e-9);
          REQUIRE(stepper.step(z, 0.1).ok());
        }
      }
}

TEST_CASE("Tangent vectors by differences are right in any units, at weak couplings", "[chaos][long]") {
  const auto scheme = schemes::low_defect6_s13();
  for (const double weak : {0.1, 1e-5})
    for (const bool one_site : {false, true})
      for (const Units& units : any_units) {
        CAPTURE(weak, one_site, units.time, units.length, units.mass);
        const auto ring = from_energy<6>([&](const auto& q, const auto& p) { return energy(q, p, weak); });
        TangentVectors exact(Semiexplicit(ring, scheme), 1);
        TangentVectors by_gradient(Semiexplicit(Ring<double, 6>{units, weak}, scheme), 1);
        const auto scale = scales<double, 6>(units);
        exact.vectors().setOnes();
        if (one_site) exact.vectors().bottomRows(10).setZero();
        by_gradient.vectors() = scale.asDiagonal() * exact.vectors();
        Semiexplicit stepper(ring, scheme);
        auto z = start<double, 6>();
        for (int n = 0; n < 60; ++n) {
          PhasePoint<double, 6> scaled;
          scaled.vector() = scale.cwiseProduct(z.vector());
          REQUIRE(exact.advance(z, 0.1).ok());
          REQUIRE(by_gradient.advance(scaled, 0.1 * units.time).ok());
          const auto found = (scale.cwiseInverse().asDiagonal() * by_gradient.vectors()).eval();
          CHECK((found - exact.vectors()).norm() <= 1e-8 * exact.vectors().norm());
          REQUIRE(stepper.step(z, 0.1).ok());
        }
      }
}

TEST_CASE("Tangent vectors by differences are right in floats", "[chaos][long]") {
  const auto scheme = schemes::low_defect6_s13<float>();
  const double weak = 1e-3;
  for (const Units& units : {Units{}, Units{1, 1, 1e-8}, Units{1, 1, 1e6}}) {
    CAPTURE(units.mass);
    const auto ring = from_energy<6, float>([&](const auto& q, const auto& p) { return energy(q, p, weak); });
    TangentVectors exact(Semiexplicit(ring, scheme), 1);
    TangentVectors by_gradient(Semiexplicit(Ring<float, 6>{units, weak}, scheme), 1);
    const auto scale = scales<float, 6>(units);
    exact.vectors().setZero();
    exact.vectors()(1, 0) = 1;
    by_gradient.vectors() = scale.asDiagonal() * exact.vectors();
    Semiexplicit stepper(ring, scheme);
    auto z = start<float, 6>();
    for (int n = 0; n < 100; ++n) {
      PhasePoint<float, 6> scaled;
      scaled.vector() = scale.cwiseProduct(z.vector());
      REQUIRE(exact.advance(z, 0.1f).ok());
      REQUIRE(by_gradient.advance(scaled, 0.1f * float(units.time)).ok());
      REQUIRE(stepper.step(z, 0.1f).ok());
    }
    const auto found = (scale.cwiseInverse().asDiagonal() * by_gradient.vectors()).eval();
    CHECK((found - exact.vectors()).norm() <= 2e-3f * exact.vectors().norm());
  }
}

TEST_CASE("The tangent map of a driven system is right in any units, from the top of the drive on",
          "[chaos]") {
  using Extended = long double;
  const auto scheme = schemes::low_defect6_s13();
  for (const bool at_zero : {false, true})
    for (const Units& units : any_units) {
      CAPTURE(at_zero, units.time, units.length, units.mass);
      const Autonomous driven(DrivenRing<double, 2>{{units, 0.1}});
      TangentMap by_gradient(driven, scheme);
      Semiexplicit stepper(driven, scheme);
      // Once more in other numbers, whose differences in time tell what comes out.
      const Autonomous same(DrivenRing<Extended, 2>{{{}, 0.1}});
      Semiexplicit reference(same, schemes::low_defect6_s13<Extended>());
      PhasePoint<double, 2> begin;
      const auto z0 = start<double, 2>();
      begin.vector() = scales<double, 2>(units).cwiseProduct(z0.vector());
      if (at_zero) begin.vector().setZero();
      auto z = driven.extended(begin, 0.0);
      for (int n = 0; n < 40; ++n) {
        REQUIRE(by_gradient.at(z, 0.1 * units.time) == Status::success);
        PhasePoint<Extended, 2> here;
        for (int i = 0; i < 2; ++i) {
          here.q()[i] = Extended(z.q()[i]) / Extended(units.length);
          here.p()[i] = Extended(z.p()[i]) / Extended(units.momentum());
        }
        const Extended t = Extended(z.q()[2]) / Extended(units.time), h = 1e-5L;
        auto later = same.extended(here, t + h), earlier = same.extended(here, t - h);
        REQUIRE(reference.step(later, 0.1L).ok());
        REQUIRE(reference.step(earlier, 0.1L).ok());
        for (int i = 0; i < 2; ++i) {
          const auto slope = (later.p()[i] - earlier.p()[i]) / (2 * h);
          const double found = by_gradient.matrix()(3 + i, 2) * units.time / units.momentum();
          CHECK(std::abs(found - static_cast<double>(slope)) <= 1e-9);
        }
        REQUIRE(stepper.step(z, 0.1 * units.time).ok());
      }
    }
}

TEST_CASE("A tangent map by differences is right where coordinates are next to nothing", "[chaos]") {
  for (const double smallest : {1e-200, 1e-300, 1e-310, 5e-324}) {
    CAPTURE(smallest);
    Ring<double, 3> ring{{}, 0.1};
    const auto given = from_energy<3>([](const auto& q, const auto& p) { return energy(q, p, 0.1); });
    TangentMap exact(given, schemes::low_defect6_s13());
    TangentMap by_gradient(ring, schemes::low_defect6_s13());
    auto z = start<double, 3>();
    z.q()[2] = z.p()[0] = smallest;
    REQUIRE(exact.at(z, 0.1) == Status::success);
    REQUIRE(by_gradient.at(z, 0.1) == Status::success);
    CHECK((by_gradient.matrix() - exact.matrix()).cwiseAbs().maxCoeff() <= 1e-9);
  }
}

namespace {

/// Ions in a trap that is stiffer across than along, each beside the next, in units where all is 1 or others.
struct IonChain {
  using Scalar = double;
  static constexpr int Dof = 6;
  double stiffness, mass, charge;
  static constexpr double across = 9;
  void gradient(In<double, 6> q, In<double, 6> p, Out<double, 6> dHdq, Out<double, 6> dHdp) const {
    const Eigen::Vector3d trap = stiffness * Eigen::Vector3d(across, across, 1),
                          r = q.head<3>() - q.tail<3>();
    const Eigen::Vector3d force = charge * r / std::pow(r.norm(), 3);
    dHdq.head<3>() = trap.cwiseProduct(q.head<3>()) - force;
    dHdq.tail<3>() = trap.cwiseProduct(q.tail<3>()) + force;
    dHdp = p / mass;
  }
};
struct IonChainWithHessian : IonChain {
  void hessian_times(In<double, 6> q, In<double, 6>, In<double, 6> dq, In<double, 6> dp, Out<double, 6> hq,
                     Out<double, 6> hp) const {
    const Eigen::Vector3d trap = stiffness * Eigen::Vector3d(across, across, 1),
                          r = q.head<3>() - q.tail<3>(), dr = dq.head<3>() - dq.tail<3>();
    const double r3 = std::pow(r.norm(), 3);
    const Eigen::Vector3d change = charge * (dr / r3 - 3 * r.dot(dr) / (r3 * r.squaredNorm()) * r);
    hq.head<3>() = trap.cwiseProduct(dq.head<3>()) - change;
    hq.tail<3>() = trap.cwiseProduct(dq.tail<3>()) + change;
    hp = dp / mass;
  }
};

}  // namespace

TEST_CASE("Tangent vectors by differences are right at an equilibrium, in any units", "[chaos][long]") {
  const auto growth = [](const auto& h) {
    const double length = std::cbrt(h.charge / h.stiffness), dt = 0.05 * std::sqrt(h.mass / h.stiffness);
    Semiexplicit stepper(h, schemes::low_defect4_s7());
    LyapunovExponents lyapunov(stepper, 2);
    PhasePoint<double, 6> z;
    z.vector().setZero();
    z.q()[2] = -std::cbrt(0.25) * length, z.q()[5] = -z.q()[2];
    REQUIRE(integrate(stepper, z, {.dt = dt, .steps = 4000}, lyapunov).ok());
    return Eigen::Vector2d(lyapunov.exponents() * (4000 * dt));
  };
  for (const IonChainWithHessian& h : {IonChainWithHessian{{1, 1, 1}}, {{2.6e-12, 6.6e-26, 2.3e-28}}}) {
    CAPTURE(h.mass);
    const Eigen::Vector2d exact = growth(h);
    CHECK((growth(IonChain(h)) - exact).norm() < 1e-4);
  }
}

namespace {

/// Hénon and Heiles' system in units of powers of two, with products of its Hessian.
struct HenonHeilesInUnits {
  using Scalar = double;
  static constexpr int Dof = 2;
  double length, momentum;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    const double x = q[0] / length, y = q[1] / length;
    dHdq[0] = momentum * (x + 2 * x * y);
    dHdq[1] = momentum * (y + x * x - y * y);
    dHdp = p * (length / momentum);
  }
  void hessian_times(In<double, 2> q, In<double, 2>, In<double, 2> dq, In<double, 2> dp, Out<double, 2> hq,
                     Out<double, 2> hp) const {
    const double x = q[0] / length, y = q[1] / length, dx = dq[0] / length, dy = dq[1] / length;
    hq[0] = momentum * (dx + 2 * (dx * y + x * dy));
    hq[1] = momentum * (dy + 2 * (x * dx - y * dy));
    hp = dp * (length / momentum);
  }
};

}  // namespace

TEST_CASE("Exponents and alignment do not depend on units that are far apart", "[chaos][lyapunov][long]") {
  bool given = false;  // the vectors that the exponents start with
  const auto measured = [&](double length, double momentum) {
    Semiexplicit stepper(HenonHeilesInUnits{length, momentum}, schemes::low_defect4_s7());
    LyapunovExponents lyapunov(stepper);
    Eigen::Matrix4d vectors{{1, 0, 0.5, 0.1}, {0, 1, 0.3, 0.2}, {0.2, 0.4, 1, 0}, {0.6, 0.3, 0, 1}};
    vectors.topRows(2) *= length;
    vectors.bottomRows(2) *= momentum;
    if (given) lyapunov.start_with(vectors);
    AlignmentIndex gali(stepper, 4);
    PhasePoint<double, 2> z({0.1 * length, 0.15 * length}, {0.45 * momentum, 0.05 * momentum});
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 5000}, lyapunov, gali).ok());
    Eigen::Matrix<double, 5, 1> all;
    all << lyapunov.exponents(), gali.log_index(4);
    return all;
  };
  const auto here = measured(1, 0x1p-40);
  CHECK(std::abs(here.head(4).sum()) < 1e-12);
  CHECK(here[0] > 0.005);
  CHECK((measured(0x1p20, 0x1p98) - here).norm() == 0);
  CHECK((measured(0x1p-30, 0x1p-120) - here).norm() == 0);

  given = true;
  const auto from_given = measured(1, 0x1p-40);
  CHECK(std::abs(from_given.head(4).sum()) < 1e-12);
  CHECK(from_given[0] == Approx(here[0]).epsilon(0.3));
  CHECK((measured(0x1p20, 0x1p98) - from_given).norm() == 0);
  CHECK((measured(0x1p-30, 0x1p-120) - from_given).norm() == 0);
}

TEST_CASE("A start near zero or far from it is none in other units", "[chaos][lyapunov]") {
  const auto exponent = [](double q, double p) {
    Semiexplicit stepper(HenonHeilesInUnits{1, 1}, schemes::low_defect4_s7());
    LyapunovExponents lyapunov(stepper);
    PhasePoint<double, 2> z({q, 0}, {0.3 * p, 0.4 * p});
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 1000}, lyapunov).ok());
    return lyapunov.exponents()[0];
  };
  for (const double q : {6.1e-17, 1e-12, 1e-9}) CHECK(exponent(q, 1) == Approx(exponent(0, 1)).epsilon(1e-6));
  for (const double p : {6.1e-17, 1e-9}) CHECK(exponent(0.3, p) == Approx(exponent(0.3, 0)).epsilon(1e-6));
}

TEST_CASE("Exponents by every solver are there in any unit of momenta", "[chaos]") {
  // Momenta in units 2^30 times smaller: the same motion, to the bit but for the projection's last changes.
  const auto run = [](double ratio, const auto& solver, double dt, double strength) {
    const auto h = from_energy<6>([=](const auto& q, const auto& p) {
      auto sum = 0 * p[0];
      for (int i = 0; i < 6; ++i) {
        const auto x = q[i], y = q[(i + 1) % 6], v = p[i] / ratio;
        sum += v * v / 2 * (1 + 0.3 * cos(x)) + strength * (x - y) * (x - y) / 4 + 0.1 * x * x * y * y;
      }
      return sum * ratio;
    });
    PhasePoint<double, 6> z;
    for (int i = 0; i < 6; ++i) {
      z.q()[i] = std::sin(1.0 + i * i);
      z.p()[i] = ratio * std::cos(2.0 + 3 * i);
    }
    Semiexplicit stepper(h, schemes::low_defect4_s7(), solver);
    LyapunovExponents lyapunov(stepper, 2);
    integrate(stepper, z, {.dt = dt, .steps = 40}, lyapunov);
    return lyapunov.exponents()[0];
  };
  for (const double ratio : {1.0, 0x1p20, 0x1p-20, 0x1p30}) {
    CAPTURE(ratio);
    CHECK_NOTHROW(run(ratio, NewtonKrylov{}, 0.15, 60));
    CHECK_NOTHROW(run(ratio, Robust{}, 0.3, 20));
  }
}

}  // namespace test_units
