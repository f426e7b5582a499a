#include "catch.hpp"

#include <cmath>
#include <random>
#include <sstream>
#include <string>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_check_members {

// What check_gradient() says of the other members that a Hamiltonian may have: halves, ranges, the exact flow
// and the rest, second derivatives. Each is right with factors of 1.

namespace {

using namespace semiexplicit;
namespace orbits = effects::orbits;

template <class H, class State>
std::string words(const H& hamiltonian, const State& z) {
  std::ostringstream out;
  out << check_gradient(hamiltonian, z);
  return out.str();
}
const std::string right = "the gradient agrees with the energy";

/// A chain of pendulums, H = Σ p²/2 − cos q_i + (q_{i+1} − q_i)⁴/4, with a factor for each member.
template <class Scalar>
struct Chain {
  using SeparableGradientOf = Chain;
  using RangeGradientOf = Chain;
  static constexpr int Dof = Eigen::Dynamic;
  static constexpr bool separable = true;
  using Column = In<Scalar, Dof>;
  Eigen::Index n = 5;
  double in_q = 1, in_p = 1, in_range = 1;
  Eigen::Index seen = 1;

  Eigen::Index dof() const { return n; }
  Scalar energy(const Column& q, const Column& p) const {
    using std::cos;
    using std::pow;
    Scalar sum = p.squaredNorm() / 2;
    for (Eigen::Index i = 0; i < n; ++i) {
      sum -= cos(q[i]);
      if (i + 1 < n) sum += Scalar(pow(q[i + 1] - q[i], 4)) / 4;
    }
    return sum;
  }
  Scalar force(Eigen::Index i, const Scalar* q) const {
    using std::pow;
    using std::sin;
    Scalar sum = sin(q[i]);
    if (i > 0) sum += Scalar(pow(q[i] - q[i - 1], 3));
    if (i + 1 < n) sum -= Scalar(pow(q[i + 1] - q[i], 3));
    return sum;
  }
  void position_gradient(const Column& q, Out<Scalar, Dof> dHdq) const {
    for (Eigen::Index i = 0; i < n; ++i) dHdq[i] = Scalar(in_q) * force(i, q.data());
  }
  void momentum_gradient(const Column& p, Out<Scalar, Dof> dHdp) const { dHdp = Scalar(in_p) * p; }
  void gradient(const Column& q, const Column& p, Out<Scalar, Dof> dHdq, Out<Scalar, Dof> dHdp) const {
    for (Eigen::Index i = 0; i < n; ++i) dHdq[i] = force(i, q.data());
    dHdp = p;
  }
  void gradient_range(Eigen::Index begin, Eigen::Index end, const Scalar* q, const Scalar* p, Scalar* dHdq,
                      Scalar* dHdp) const {
    for (Eigen::Index i = begin; i < end; ++i) {
      dHdq[i - begin] = force(i, q);
      dHdp[i - begin] = Scalar(in_range) * p[i];
    }
  }
  Eigen::Index reach() const { return seen; }
};

template <class T>
struct ChainOf : Chain<T> {
  using Scalar = T;
  using SeparableGradientOf = ChainOf;
  using RangeGradientOf = ChainOf;
};

template <class Scalar>
PhasePoint<Scalar, Eigen::Dynamic> chain_point(unsigned seed, Scalar size = 1) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  PhasePoint<Scalar, Eigen::Dynamic> z(5);
  for (auto& x : z.vector()) x = size * Scalar(normal(random));
  return z;
}

/// H = p²/2 + (q_0² + q_1⁴)/2 as its motion under p²/2 + q_0²/2 and the rest, with factors.
struct Split {
  using Scalar = double;
  static constexpr int Dof = 2;
  double rest = 1, time = 1, turned = 1;
  bool first_order = false;
  double energy(In<double, 2> q, In<double, 2> p) const {
    return (p.squaredNorm() + q[0] * q[0] + std::pow(q[1], 4)) / 2;
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq << q[0], 2 * std::pow(q[1], 3);
    dHdp = p;
  }
  Status flow(const double& of, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const double t = time * of;
    if (first_order) {
      dq = t * p;
      dp << -t * q[0], 0;
      return Status::success;
    }
    dq << (std::cos(t) - 1) * q[0] + std::sin(t) * p[0], t * p[1];
    dp << -turned * std::sin(t) * q[0] + (std::cos(t) - 1) * p[0], 0;
    return Status::success;
  }
  std::string flow_name() const { return "oscillator and free motion"; }
  void rest_position_gradient(In<double, 2> q, Out<double, 2> dHdq) const {
    dHdq << 0, rest * 2 * std::pow(q[1], 3);
  }
};

/// H = (q² + 1)(p² + 1)/2 with second derivatives, and factors.
template <bool times>
struct Curved {
  using Scalar = double;
  static constexpr int Dof = 1;
  double mixed = 1, own = 1;
  double energy(In<double, 1> q, In<double, 1> p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1);
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
  void hessian(In<double, 1> q, In<double, 1> p, Eigen::Ref<Eigen::Matrix2d> result) const requires(!times) {
    result << p[0] * p[0] + 1, mixed * 2 * q[0] * p[0], mixed * 2 * q[0] * p[0], own * (q[0] * q[0] + 1);
  }
  void hessian_times(In<double, 1> q, In<double, 1> p, In<double, 1> dq, In<double, 1> dp, Out<double, 1> hq,
                     Out<double, 1> hp) const requires times {
    hq[0] = (p[0] * p[0] + 1) * dq[0] + mixed * 2 * q[0] * p[0] * dp[0];
    hp[0] = mixed * 2 * q[0] * p[0] * dq[0] + own * (q[0] * q[0] + 1) * dp[0];
  }
};

/// H = (p² + q²)/2 + 0.15 q_1⁴ with a factor in its Hessian.
struct HarmonicBeside {
  using Scalar = double;
  static constexpr int Dof = 2;
  double first = 1;
  double energy(In<double, 2> q, In<double, 2> p) const {
    return (p.squaredNorm() + q.squaredNorm()) / 2 + 0.15 * std::pow(q[1], 4);
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq << q[0], q[1] + 0.6 * std::pow(q[1], 3);
    dHdp = p;
  }
  void hessian(In<double, 2> q, In<double, 2>, Eigen::Ref<Eigen::Matrix4d> result) const {
    result.setIdentity();
    result(0, 0) = first;
    result(1, 1) = 1 + 1.8 * q[1] * q[1];
  }
};

/// A pendulum, H = p²/2m − 2m cos q, about whose lower point nothing tells a size of q; with a factor.
struct Pendulum {
  using Scalar = double;
  static constexpr int Dof = 1;
  double m = 1, curvature = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / (2 * m) - 2 * m * std::cos(q[0]);
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = 2 * m * std::sin(q[0]);
    dHdp[0] = p[0] / m;
  }
  void hessian(In<double, 1> q, In<double, 1>, Eigen::Ref<Eigen::Matrix2d> result) const {
    result << curvature * 2 * m * std::cos(q[0]), 0, 0, 1 / m;
  }
};

/// H = p²/2m + m q²/2 as its exact flow, in as many units.
struct Oscillator {
  using Scalar = double;
  static constexpr int Dof = 1;
  double m = 1;
  bool first_order = false;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / (2 * m) + m * q[0] * q[0] / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = m * q[0];
    dHdp[0] = p[0] / m;
  }
  Status flow(const double& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const double turned = first_order ? 0 : std::cos(t) - 1, far = first_order ? t : std::sin(t);
    dq[0] = turned * q[0] + far * p[0] / m;
    dp[0] = turned * p[0] - far * m * q[0];
    return Status::success;
  }
  std::string flow_name() const { return "oscillator"; }
  void rest_position_gradient(In<double, 1>, Out<double, 1> dHdq) const { dHdq.setZero(); }
};

/// H = p²/2 + (1 + 3 [q < 0]) q²/2, with packs; `mixed`: one branch for all lanes.
template <bool mixed>
struct Kinked {
  using Scalar = double;
  static constexpr int Dof = 1;
  using PackGradientOf = Kinked;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / 2 + (q[0] > 0 ? 1 : 4) * q[0] * q[0] / 2;
  }
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    const auto above = q[0] > 0.0;
    dHdp[0] = 1.0 * p[0];
    dHdq[0] = 1.0 * q[0];
    if constexpr (std::is_same_v<decltype(above), const bool>) {
      if (!above) dHdq[0] *= 4;
    } else if constexpr (mixed) {
      if (!any_of(above)) dHdq[0] = 4.0 * dHdq[0];
    } else {
      where(!above, dHdq[0]) = 4.0 * dHdq[0];
    }
  }
};

template <class Scalar>
int refused_chains() {
  int wrong = 0;
  for (unsigned seed = 0; seed < 50; ++seed)
    for (const Scalar size : {Scalar(1e-3), Scalar(1), Scalar(10)})
      if (!check_gradient(ChainOf<Scalar>{}, chain_point<Scalar>(seed, size)).ok()) ++wrong;
  return wrong;
}

}  // namespace

TEST_CASE("Halves of a separable gradient that are others are wrong", "[check_gradient]") {
  using H = ChainOf<double>;
  static_assert(SeparableHamiltonian<H> && HasLocalGradient<H>);
  const auto z = chain_point<double>(1);
  CHECK(words(H(), z) == right);
  CHECK(refused_chains<double>() == 0);
  CHECK(refused_chains<float>() == 0);
  const std::string force = words(H{{.in_q = -1}}, z), slower = words(H{{.in_p = 1.0001}}, z);
  CHECK(says(force, "dH/dq[0] is another number by position_gradient"));
  CHECK_FALSE(says(force, "dH/dp"));
  CHECK(says(slower, "dH/dp[4] is another number by position_gradient or momentum_gradient"));
  CHECK_FALSE(says(slower, "dH/dq"));
}

TEST_CASE("A gradient of ranges that is another one is wrong", "[check_gradient]") {
  using H = ChainOf<double>;
  const auto z = chain_point<double>(2);
  CHECK(says(words(H{{.in_range = 0.5}}, z), "dH/dp[1] is another number by gradient_range"));
  CHECK(says(words(H{{.seen = 0}}, z), "dH/dq[1] is another number by gradient_range"));
  CHECK(words(H{{.seen = 3}}, z) == right);
}

TEST_CASE("A flow and a rest that do not add up to the gradient are wrong", "[check_gradient]") {
  static_assert(SplitHamiltonian<Split>);
  const PhasePoint<double, 2> z({0.7, -0.4}, {0.3, 1.2});
  CHECK(words(Split(), z) == right);
  CHECK(words(Split(), PhasePoint<double, 2>({0.7, 0}, {0, 0})) == right);
  CHECK(says(words(Split{.rest = -1}, z), "dH/dq[1] is another number by flow() and the gradients of the"));
  CHECK(says(words(Split{.time = -1}, z), "dH/dp[1] is another number by flow()"));
  CHECK(says(words(Split{.turned = 1.001}, z), "dH/dq[0] is another number by flow()"));
  const std::string euler = words(Split{.first_order = true}, z);
  CHECK(says(euler, "dH/dq[0] is another number by flow()"));
  CHECK(says(euler, "a flow of the time 2t is that of t, twice"));
}

TEST_CASE("Exact flows of the library add up with the rest", "[check_gradient]") {
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  const auto refused = [&](const auto& stepper) {
    int wrong = 0;
    for (int n = 0; n < 100; ++n) {
      auto z = PhasePoint<double, std::remove_cvref_t<decltype(stepper)>::Dof>(stepper.dof());
      for (auto& x : z.vector()) x = normal(random);
      if (!check_gradient(stepper.hamiltonian(), z).ok()) ++wrong;
    }
    return wrong;
  };
  using Kinetic = orbits::Kinetic<double, 2>;
  using Attraction = orbits::Attraction<double, 2>;
  using Frame = orbits::RotatingFrame<double, 2>;
  const Scene scene(Kinetic{}, Attraction{.gm = 1}, Frame{.omega = 0.7},
                    orbits::PostNewtonian1<double, 2>{.gm = 1, .c = 30},
                    orbits::Oblateness<double, 2>{.gm = 1, .j2 = 1e-3, .radius = 1});
  CHECK(refused(stepper_for(scene, exactly<Kinetic, Attraction>())) == 0);
  CHECK(refused(stepper_for(scene, exactly<Kinetic, Frame>())) == 0);
  CHECK(refused(stepper_for(scene, exactly<Kinetic, Attraction, Frame>())) == 0);
  namespace nbody = effects::nbody;
  const nbody::Bodies<double> bodies({1, 1e-3, 1e-4});
  CHECK(refused(stepper_for(Scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                                  nbody::Interaction<double>{bodies}),
                            exactly<nbody::Kinetic<double>, nbody::Attraction<double>>())) == 0);
}

TEST_CASE("Second derivatives that are not those of the gradient are wrong", "[check_gradient]") {
  const PhasePoint<double, 1> z(0.7, -0.4);
  CHECK(words(Curved<false>(), z) == right);
  CHECK(words(Curved<true>(), z) == right);
  CHECK(words(Curved<true>(), PhasePoint<double, 1>(0, 0)) == right);
  CHECK(says(words(Curved<false>{.mixed = -1}, z),
             "dH/dq[0] has another derivative than hessian or hessian_times says"));
  const std::string own = words(Curved<true>{.own = 1.01}, z);
  CHECK(says(own, "dH/dp[0] has another derivative"));
  CHECK_FALSE(says(own, "dH/dq"));
  // A harmonic coordinate beside an anharmonic one: steps far beyond these show noise of the other alone.
  for (const double factor : {0.7, 1.5, 2.0})
    CHECK_FALSE(check_gradient(HarmonicBeside{factor}, PhasePoint<double, 2>({0.1, 0.1}, {0.3, 0.4})).ok());
  CHECK(check_gradient(HarmonicBeside{1}, PhasePoint<double, 2>({0.1, 0.1}, {0.3, 0.4})).ok());
}

TEST_CASE("A coordinate that is zero in units far from the others hides nothing", "[check_gradient]") {
  for (int exponent = -24; exponent <= 24; exponent += 3) {
    CAPTURE(exponent);
    const double m = std::pow(10.0, exponent);
    for (const PhasePoint<double, 1>& z : {PhasePoint<double, 1>(0, m), PhasePoint<double, 1>(1, 0)}) {
      CHECK(check_gradient(Pendulum{m}, z).ok());
      CHECK(check_gradient(Oscillator{m}, z).ok());
    }
    const PhasePoint<double, 1> low(0, m);
    for (const double factor : {-1.0, 0.0, 1.01}) CHECK_FALSE(check_gradient(Pendulum{m, factor}, low).ok());
  }
  CHECK_FALSE(check_gradient(Oscillator{1, true}, PhasePoint<double, 1>(1, 0)).ok());
  // A planet in polar coordinates, in metres and seconds, on an axis of its potential.
  const auto planet = from_energy<2>([](const auto& q, const auto& p) {
    return p[0] * p[0] / 2 + p[1] * p[1] / (2 * q[0] * q[0]) - 1.3e20 / q[0] * (1 + 0.01 * cos(2 * q[1]));
  });
  CHECK(check_gradient(planet, PhasePoint<double, 2>({1.5e11, 0}, {0, 4.46e15})).ok());
  using Kinetic = orbits::Kinetic<double, 2>;
  using Attraction = orbits::Attraction<double, 2>;
  const auto falls =
      stepper_for(Scene(Kinetic{}, Attraction{.gm = 1.327e20}), exactly<Kinetic, Attraction>());
  CHECK(check_gradient(falls.hamiltonian(), PhasePoint<double, 2>({1.4e11, 0.5e11}, {0, 0})).ok());
}

TEST_CASE("A gradient of packs that takes one branch for all lanes is wrong", "[check_gradient]") {
  for (const double q : {0.5, -0.5}) {
    CHECK(words(Kinked<false>(), PhasePoint<double, 1>(q, 0.3)) == right);
    CHECK(says(words(Kinked<true>(), PhasePoint<double, 1>(q, 0.3)),
               "dH/dq[0] is another number where the gradient is called with packs"));
  }
}

}  // namespace test_check_members
