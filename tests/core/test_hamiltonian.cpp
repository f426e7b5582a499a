#include "catch.hpp"

#include <cmath>
#include <concepts>
#include <stdexcept>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_hamiltonian {

// What is a Hamiltonian and what is not.

namespace {

using namespace semiexplicit;

struct Good {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(Hamiltonian<Good>);
static_assert(!HasEnergy<Good> && !HasHessian<Good>);

struct WithEnergy : Good {
  double energy(In<double, 1> q, In<double, 1> p) const { return (q[0] * q[0] + p[0] * p[0]) / 2; }
};
static_assert(HasEnergy<WithEnergy>);
static_assert(HasEnergy<systems::Product<double>> && HasHessian<systems::Product<double>>);
static_assert(HasEnergy<systems::NlsLattice<float, 3>> && !HasHessian<systems::NlsLattice<float, 3>>);
static_assert(HasEnergy<systems::PointVortices<long double>>);

struct Templated {
  using Scalar = float;
  static constexpr int Dof = 3;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D& dHdq, D& dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(Hamiltonian<Templated>);

struct ByReference {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index dof() const { return 4; }
  void gradient(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p,
                Out<double, Eigen::Dynamic> dHdq, Out<double, Eigen::Dynamic> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(Hamiltonian<ByReference>);

struct NoScalar {
  [[maybe_unused]] static constexpr int Dof = 1;
  void gradient(In<double, 1>, In<double, 1>, Out<double, 1>, Out<double, 1>) const {}
};
struct NoDof {
  using Scalar = double;
  void gradient(In<double, 1>, In<double, 1>, Out<double, 1>, Out<double, 1>) const {}
};
struct ZeroDof : Good {
  static constexpr int Dof = 0;
};
struct NoGradient {
  using Scalar = double;
  static constexpr int Dof = 1;
};
struct NotConst {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1>, In<double, 1>, Out<double, 1>, Out<double, 1>) {}
};
struct OneHalf {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1>, In<double, 1>, Out<double, 1>) const {}
};
struct NoRuntimeDof {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  void gradient(In<double, -1>, In<double, -1>, Out<double, -1>, Out<double, -1>) const {}
};
struct NotCopyable : Good {
  NotCopyable() = default;
  NotCopyable(const NotCopyable&) = delete;
};
static_assert(!Hamiltonian<NoScalar> && !HasScalar<NoScalar>);
static_assert(!Hamiltonian<NoDof> && !HasDof<NoDof>);
static_assert(!Hamiltonian<ZeroDof> && !HasDof<ZeroDof>);
static_assert(!Hamiltonian<NoGradient> && !HasGradient<NoGradient>);
static_assert(!Hamiltonian<NotConst> && !HasGradient<NotConst>);
static_assert(!Hamiltonian<OneHalf> && !HasGradient<OneHalf>);
static_assert(!Hamiltonian<NoRuntimeDof> && HasGradient<NoRuntimeDof> && !HasRuntimeDof<NoRuntimeDof>);
static_assert(!Hamiltonian<NotCopyable>);
static_assert(!Hamiltonian<int>);

static_assert(Stepper<Semiexplicit<Good>> && Stepper<Semiexplicit<Good, Broyden>>);
static_assert(Stepper<MidpointProjection<Good>> && Stepper<GaussLegendre<Good>>);
static_assert(Stepper<Pihajoki<Good>> && Stepper<Tao<Good>>);
static_assert(!Stepper<Good>);

}  // namespace

TEST_CASE("The degrees of freedom come from the type or from the value", "[hamiltonian]") {
  CHECK(dof_of(Good{}) == 1);
  CHECK(dof_of(Templated{}) == 3);
  CHECK(dof_of(ByReference{}) == 4);
  CHECK(dof_of(systems::NlsLattice<double>(7)) == 7);
}

TEST_CASE("A Hamiltonian is made of two lambdas", "[hamiltonian]") {
  const auto energy = [](const auto& q, const auto& p) {
    return (q.squaredNorm() + 1) * (p.squaredNorm() + 1) / 2;
  };
  const auto gradient = [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
    dHdq = q * (p.squaredNorm() + 1);
    dHdp = p * (q.squaredNorm() + 1);
  };
  const auto fixed = make_hamiltonian<double, 1>(energy, gradient);
  static_assert(HasEnergy<decltype(fixed)>);
  static_assert(decltype(fixed)::Dof == 1);
  const auto dynamic = make_hamiltonian<double>(3, energy, gradient);
  static_assert(HasEnergy<decltype(dynamic)>);
  static_assert(decltype(dynamic)::Dof == Eigen::Dynamic);
  CHECK(dof_of(fixed) == 1);
  CHECK(dof_of(dynamic) == 3);
  CHECK_THROWS_AS(make_hamiltonian<double>(0, energy, gradient), std::invalid_argument);

  // The same steps as with the system of that formula.
  PhasePoint<double, 1> z(-3, 0), other = z;
  Semiexplicit stepper(fixed, schemes::yoshida6());
  Semiexplicit known(systems::Product<double>{}, schemes::yoshida6());
  for (int n = 0; n < 10; ++n) {
    REQUIRE(stepper.step(z, 0.01).ok());
    REQUIRE(known.step(other, 0.01).ok());
  }
  CHECK((z.vector() - other.vector()).norm() <= 1e-13);
  CHECK(fixed.energy(z.q(), z.p()) == Approx(5).epsilon(1e-7));

  PhasePoint<double, Eigen::Dynamic> long_z({-3, 0, 0}, {0, 0, 0});
  Semiexplicit long_stepper(dynamic, schemes::yoshida6());
  for (int n = 0; n < 10; ++n) REQUIRE(long_stepper.step(long_z, 0.01).ok());
  CHECK(std::abs(long_z.q()[0] - z.q()[0]) <= 1e-13);
  CHECK(long_z.q()[1] == 0);
}

/// An oscillator whose gradient takes its arguments in one of the ways that write where they are.
template <int form>
struct Oscillator {
  using Scalar = double;
  static constexpr int Dof = 2;
};
template <class V>
concept Column = std::derived_from<V, Eigen::MatrixBase<V>>;
template <>
struct Oscillator<0> : Oscillator<-1> {
  void gradient(const Column auto& q, const Column auto& p, Column auto& dHdq, Column auto& dHdp) const {
    dHdq = q, dHdp = p;
  }
};
template <>
struct Oscillator<1> : Oscillator<-1> {
  template <class Q, class G>
  void gradient(const Eigen::MatrixBase<Q>& q, const Eigen::MatrixBase<Q>& p, Eigen::MatrixBase<G>& dHdq,
                Eigen::MatrixBase<G>& dHdp) const {
    dHdq = q, dHdp = p;
  }
};
template <>
struct Oscillator<2> : Oscillator<-1> {
  auto gradient(const auto& q, const auto& p, auto&& dHdq, auto&& dHdp) const { dHdq = q, dHdp = p; }
};
template <>
struct Oscillator<3> : Oscillator<-1> {
  void gradient(auto q, auto p, auto dHdq, auto dHdp) const { dHdq = q, dHdp = p; }
};
template <>
struct Oscillator<4> : Oscillator<-1> {
  void gradient(const auto& q, const auto& p, Eigen::Ref<Eigen::VectorXd> dHdq, Out<double, 2> dHdp) const {
    dHdq = q, dHdp = p;
  }
};
template <>
struct Oscillator<5> : Oscillator<-1> {
  using Map = Eigen::Map<Eigen::Vector2d>;
  void gradient(const auto& q, const auto& p, Map& dHdq, Map dHdp) const { dHdq = q, dHdp = p; }
};

template <>
struct Oscillator<6> : Oscillator<-1> {  // reads what it has written
  auto gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    dHdq = q;
    const Eigen::Vector2d force = dHdq;
    dHdp = p + 0 * force;
  }
};
template <class V>
concept Mapped = std::same_as<V, Eigen::Map<Eigen::Vector2d>>;
template <>
struct Oscillator<7> : Oscillator<-1> {
  void gradient(const auto& q, const auto& p, Mapped auto& dHdq, Mapped auto& dHdp) const {
    dHdq = q, dHdp = p;
  }
};

TEMPLATE_TEST_CASE_SIG("A gradient may take its outputs in any way that writes where they are",
                       "[hamiltonian]", ((int form), form), 0, 1, 2, 3, 4, 5, 6, 7) {
  PhasePoint<double, 2> z({1, 0}, {0, 0});
  Semiexplicit stepper(Oscillator<form>{}, schemes::yoshida6());
  REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 10}).ok());
  CHECK(z.q()[0] == Approx(std::cos(1)).epsilon(1e-6));
}

TEST_CASE("A lambda for the gradient may deduce any of its arguments", "[hamiltonian]") {
  const auto energy = [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; };
  const auto turned = [&](const auto& gradient) {
    PhasePoint<double, 2> z({1, 0}, {0, 0});
    Semiexplicit stepper(make_hamiltonian<double, 2>(energy, gradient), schemes::yoshida6());
    REQUIRE(integrate(stepper, z, {.dt = 0.1, .steps = 10}).ok());
    return z.q()[0];
  };
  const auto right = Approx(std::cos(1)).epsilon(1e-6);
  CHECK(turned([](In<double, 2> q, In<double, 2> p, auto& dHdq, auto& dHdp) { dHdq = q, dHdp = p; }) ==
        right);
  CHECK(turned([](const auto& q, In<double, 2> p, Out<double, 2> dHdq, auto& dHdp) {
          dHdq = q;
          const Eigen::Vector2d force = dHdq;
          dHdp = p + 0 * force;
        }) == right);
  CHECK(turned([](auto q, auto p, Out<double, 2> dHdq, Out<double, 2> dHdp) { dHdq = q, dHdp = p; }) ==
        right);
}

TEST_CASE("A stepper copies the Hamiltonian and gives it back", "[hamiltonian]") {
  systems::NlsLattice<double> h(7);
  const Semiexplicit stepper(h, schemes::strang());
  CHECK(stepper.hamiltonian().dof() == 7);
  CHECK(&stepper.hamiltonian() != &h);
  CHECK(stepper.dof() == 7);
  CHECK(stepper.scheme().name == "strang");
  CHECK(Tao(h, schemes::strang(), 3.0).omega() == 3.0);
  CHECK(GaussLegendre(h, {.stages = 4}).options().stages == 4);
  CHECK(MidpointProjection(h, schemes::strang()).dof() == 7);
  CHECK(Pihajoki(h, schemes::strang()).dof() == 7);
  CHECK(Semiexplicit(h, schemes::strang(), Broyden{.memory = 3}).solver().memory == 3);
}

}  // namespace test_hamiltonian
