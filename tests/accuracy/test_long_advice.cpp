// What lies beyond the trials: slow drift, hard places that come back, and errors that are rounding. Advice
// is judged by closed forms over the whole time.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "catch.hpp"

#include "kepler.hpp"
#include "late_wall.hpp"

namespace test_long_advice {

using namespace semiexplicit;

namespace {

/// A light body in the field of a centre and the tide of a far body at rest.
struct Tidal {
  using Scalar = double;
  static constexpr int Dof = 3;
  double tide;
  double energy(const In<double, 3>& q, const In<double, 3>& p) const {
    return p.squaredNorm() / 2 - 1 / q.norm() + tide * (3 * q[2] * q[2] - q.squaredNorm());
  }
  void gradient(const In<double, 3>& q, const In<double, 3>& p, Out<double, 3> dHdq,
                Out<double, 3> dHdp) const {
    dHdq = q / std::pow(q.norm(), 3) - 2 * tide * q;
    dHdq[2] += 6 * tide * q[2];
    dHdp = p;
  }
};

/// Two coupled oscillators, the second one in a unit of its own: its position is y/unit, its momentum Y unit.
struct UnlikeUnits {
  using Scalar = double;
  static constexpr int Dof = 2;
  double unit, coupling;
  double energy(const In<double, 2>& q, const In<double, 2>& p) const {
    const double x = q[0], X = p[0], y = unit * q[1], Y = p[1] / unit;
    const double first = x * x + X * X, second = y * y + Y * Y, both = first + second;
    return first / 2 + 1.0001 * second / 2 + 0.0111 * (x * y - X * Y) * x + coupling * first * second / 4 +
           1.5737e-4 * both * both;
  }
  void gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                Out<double, 2> dHdp) const {
    const double x = q[0], X = p[0], y = unit * q[1], Y = p[1] / unit;
    const double of_first = 1 + coupling * (y * y + Y * Y) / 2,
                 of_second = 1.0001 + coupling * (x * x + X * X) / 2,
                 of_both = 4 * 1.5737e-4 * (x * x + X * X + y * y + Y * Y);
    dHdq << (of_first + of_both) * x + 0.0111 * (2 * x * y - X * Y),
        unit * ((of_second + of_both) * y + 0.0111 * x * x);
    dHdp << (of_first + of_both) * X - 0.0111 * Y * x, ((of_second + of_both) * Y - 0.0111 * X * x) / unit;
  }
};

PhasePoint<double, 2> at_periapsis(double e) { return {{1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))}}; }

/// Kepler's equation, by halving.
double eccentric_anomaly(double e, double t) {
  const double turn = 2 * std::acos(-1), mean = std::fmod(t, turn);
  double low = 0, high = turn;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (middle - e * std::sin(middle) < mean ? low : high) = middle;
  }
  return low;
}

Eigen::Vector2d eccentricity(const auto& q, const auto& p) {
  const double turn = q[0] * p[1] - q[1] * p[0], r = q.norm();
  return {p[1] * turn - q[0] / r, -p[0] * turn - q[1] / r};
}

/// The largest error of a run that is advised for Kepler's motion: f against exact(t), relative to the
/// largest of the latter.
template <class Cost, class F, class Exact>
double reached(const Cost& cost, const CostRow& advice, PhasePoint<double, 2> z, const F& f,
               const Exact& exact) {
  double worst = 0, size = 0;
  cost.run(z, advice, [&](double t, const auto& now) {
    const Eigen::Vector2d value = exact(t);
    worst = std::max(worst, (f(now.q(), now.p()) - value).norm());
    size = std::max(size, value.norm());
  });
  return worst / size;
}

double size_of(double x) { return std::abs(x); }
double size_of(const Eigen::Vector2d& x) { return x.norm(); }

/// By how much f of a run that is advised differs from f exact at most.
double worst_off(const auto& cost, const CostRow& advice, auto z, const auto& f, const auto& exact) {
  double worst = 0;
  cost.run(z, advice, [&](double t, const auto& now) {
    worst = std::max(worst, size_of(f(now.q(), now.p()) - exact(t)));
  });
  return worst;
}

/// Three oscillators in a row, each twisted and in a unit of its own, with a weak coupling.
struct ThreeInARow {
  std::array<double, 3> rate, length, momentum, quartic;
  double couples;

  auto hamiltonian() const {
    return from_energy<3>([chain = *this](const auto& q, const auto& p) {
      auto sum = 0 * q[0];
      for (std::size_t i = 0; i < 3; ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        const auto x = q[k] / chain.length[i], X = p[k] / chain.momentum[i];
        sum += chain.length[i] * chain.momentum[i] * chain.rate[i] *
               ((x * x + X * X) / 2 + chain.quartic[i] * x * x * X * X);
        if (i > 0) {
          const auto before = q[k - 1] / chain.length[i - 1];
          sum += chain.couples * before * before * x;
        }
      }
      return sum;
    });
  }
};

}  // namespace

TEST_CASE("advice on a constant that every method lets drift is right: the direction of a planet's periapsis",
          "[long]") {
  const auto vector = [](const auto& q, const auto& p) { return eccentricity(q, p); };
  const auto angle = [](const auto& q, const auto& p) {
    const Eigen::Vector2d e = eccentricity(q, p);
    return Eigen::Vector2d(3 + std::atan2(e[1], e[0]), 0);
  };
  const auto check = [](double e, double T, double target, const auto& f) {
    CAPTURE(e, T, target);
    const PhasePoint<double, 2> z0 = at_periapsis(e);
    const auto cost = cost_of_accuracy(Kepler(), z0, T, {.observable = f, .targets = {target}});
    CHECK(cost.invariant);
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    CHECK(advice->limit == LimitedBy::growth);
    const Eigen::Vector2d first = f(z0.q(), z0.p());
    const double error = reached(cost, *advice, z0, f, [&](double) { return first; });
    CHECK(error <= 3 * target);
    CHECK(error >= target / 30);
  };
  check(0.6, 1e3, 1e-4, vector);
  check(0.6, 1e4, 1e-4, vector);
  check(0.2, 1e4, 1e-6, vector);
  check(0.6, 1e4, 1e-5, angle);
}

TEST_CASE("a start in a hard place gives right advice, or none with the reason: a planet at its periapsis",
          "[long]") {
  const auto position = [](const auto& q, const auto&) { return Eigen::Vector2d(q); };
  const auto distance = [](const auto& q, const auto&) { return Eigen::Vector2d(q.norm(), 0); };
  const auto check = [](double e, double T, double target, const auto& f) {
    CAPTURE(e, T, target);
    const PhasePoint<double, 2> z0 = at_periapsis(e);
    const auto exact = [&](double t) {
      const double angle = eccentric_anomaly(e, t);
      return f(Eigen::Vector2d(std::cos(angle) - e, std::sqrt(1 - e * e) * std::sin(angle)), 0);
    };
    const auto cost = cost_of_accuracy(Kepler(), z0, T, {.observable = f, .targets = {target}});
    INFO(cost.why(target));
    const auto advice = cost.cheapest(target);
    if (!advice) {
      CHECK(cost.reach(target) == Reach::budget);
      return false;
    }
    CHECK(cost.reference_time > 2 * std::acos(-1));
    CHECK(reached(cost, *advice, z0, f, exact) <= 3 * target);
    return true;
  };
  CHECK(check(0.8, 100, 1e-4, position));
  CHECK(check(0.9, 100, 1e-4, position));
  CHECK(check(0.9, 300, 1e-5, distance));
  CHECK(check(0.97, 100, 1e-4, position));
  // With so few steps about the periapsis errors differ a hundredfold from one step to the next: only whole
  // runs tell.
  CHECK(check(0.97, 100, 1e-2, distance));
  CHECK(check(0.99, 100, 1e-4, position));
  // A revolution is too dear for a trial.
  const auto only =
      cost_of_accuracy(Kepler(), at_periapsis(0.999), 100,
                       {.observable = observables::Positions{}, .targets = {1e-4}, .min_gradients = 1e4});
  if (!only.cheapest(1e-4)) CHECK(only.reach(1e-4) == Reach::budget);
}

TEST_CASE("an energy that rounding hides beside its terms does not end the orbit: an inverted oscillator") {
  const auto inverted = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (p[0] * p[0] - q[0] * q[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq = -q, dHdp = p; });
  const PhasePoint<double, 1> z0(1, 0.5);
  for (const double T : {25.0, 60.0}) {
    CAPTURE(T);
    const auto cost =
        cost_of_accuracy(inverted, z0, T, {.observable = observables::Coordinate{0}, .targets = {1e-3}});
    INFO(cost.why(1e-3));
    const auto advice = cost.cheapest(1e-3);
    REQUIRE(advice);
    auto z = z0;
    double worst = 0;
    cost.run(z, *advice, [&](double t, const auto& now) {
      worst = std::max(worst, std::abs(now.q()[0] - std::cosh(t) - 0.5 * std::sinh(t)));
    });
    CHECK(worst / std::cosh(T) <= 3e-3 * 1.5);
    // The energy is out of reach, and for what reason.
    const auto energy = cost_of_accuracy(inverted, z0, T, {.targets = {1e-6}});
    CHECK(energy.reach(1e-6) == Reach::rounding);
  }
}

TEST_CASE("what varies by a small part of its size is no constant where the target is smaller still") {
  const auto oscillator = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq = q, dHdp = p; });
  const auto f = [](const auto& q, const auto&) { return 1 + 1e-10 * q[0]; };
  const PhasePoint<double, 1> z0(1, 0);
  for (const bool absolute : {true, false}) {
    const auto cost =
        cost_of_accuracy(oscillator, z0, 500, {.observable = f, .targets = {1e-12}, .absolute = absolute});
    CHECK_FALSE(cost.invariant);
    const auto advice = cost.cheapest(1e-12);
    REQUIRE(advice);
    auto z = z0;
    double worst = 0;
    cost.run(z, *advice, [&](double t, const auto& now) {
      worst = std::max(worst, std::abs(f(now.q(), now.p()) - 1 - 1e-10 * std::cos(t)));
    });
    CHECK(worst <= 3e-12);
  }
}

TEST_CASE("a slow instability that parts of the run do not show is seen in the whole of it", "[long]") {
  // Kozai's cycles in the tide of a far body: the eccentricity of an inclined orbit grows from 0.01 as
  // e^{st}, while the perihelion of a coarse run turns by itself, which suppresses that.
  const double e = 0.01, inclination = 80 * 3.14159265358979 / 180, T = 600 * 6.283185307179586;
  const double speed = std::sqrt((1 + e) / (1 - e));
  const PhasePoint<double, 3> z0(
      Eigen::Vector3d(1 - e, 0, 0),
      Eigen::Vector3d(0, speed * std::cos(inclination), speed * std::sin(inclination)));
  for (const double tide : {1e-4, 3e-4, 1e-3}) {
    CAPTURE(tide);
    const Tidal tidal{tide};
    const auto cost = cost_of_accuracy(tidal, z0, T, {.targets = {1e-6, 1e-8}});
    for (const double target : cost.targets) {
      const auto advice = cost.cheapest(target);
      if (tide == 1e-4) REQUIRE(advice);
      if (!advice) continue;
      auto z = z0;
      double worst = 0;
      const double start = tidal.energy(z.q(), z.p());
      cost.run(z, *advice, [&](double, const auto& now) {
        worst = std::max(worst, std::abs(tidal.energy(now.q(), now.p()) / start - 1));
      });
      CHECK(worst <= 3 * target);
    }
  }
}

TEST_CASE("rounding does not make a regular motion in float part from its neighbours") {
  const auto pendulum = [](auto scalar) {
    using T = decltype(scalar);
    return make_hamiltonian<T, 1>(
        [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - std::cos(q[0]); },
        [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq[0] = std::sin(q[0]), dHdp = p; });
  };
  constexpr double T = 1000;
  for (const double q0 : {1.5, 2.5}) {
    CAPTURE(q0);
    const auto H = pendulum(0.0F);
    PhasePoint<float, 1> z(static_cast<float>(q0), 0);
    const auto cost =
        cost_of_accuracy(H, z, T, {.observable = observables::Coordinate{0}, .targets = {1e-2, 1e-3}});
    INFO(cost.why(1e-2));
    CHECK(cost.parting_rate == 0);
    const auto advice = cost.cheapest(1e-2);
    REQUIRE(advice);
    cost.run(z, *advice);
    GaussLegendre exact(pendulum(0.0), {.stages = 6});
    PhasePoint<double, 1> end(q0, 0);
    integrate(exact, end, {.dt = 0.2, .t_end = T});
    CHECK(std::abs(static_cast<double>(z.q()[0]) - end.q()[0]) <= 3 * 1e-2 * q0);
  }
}

TEST_CASE("every target of a list is met where runs are short enough to be made as a whole", "[long]") {
  const auto check = [](const auto& H, const auto& z0, double T, const std::vector<double>& targets) {
    CAPTURE(T, targets.size());
    const double start = H.energy(z0.q(), z0.p());
    const auto cost = cost_of_accuracy(H, z0, T, {.targets = targets});
    for (const double target : targets) {
      CAPTURE(target);
      const auto advice = cost.cheapest(target);
      REQUIRE(advice);
      CHECK_FALSE(advice->interpolated);
      auto z = z0;
      double worst = 0;
      cost.run(z, *advice, [&](double, const auto& now) {
        worst = std::max(worst, std::abs(H.energy(now.q(), now.p()) / start - 1));
      });
      CHECK(worst <= 1.1 * target);
    }
  };
  const auto steep = from_energy<1>([](const auto& q, const auto& p) {
    using std::exp;
    return exp(q[0]) - q[0] + exp(p[0]) - p[0];
  });
  const auto pendulums = from_energy<2>([](const auto& q, const auto& p) {
    using std::cos;
    const auto c = cos(q[0] - q[1]);
    return (p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c) / (2 * (2 - c * c)) - 2 * cos(q[0]) -
           cos(q[1]);
  });
  const std::vector<double> all{1e-4, 1e-6, 1e-8, 1e-10};
  check(steep, PhasePoint<double, 1>(3, 0), 30, all);
  check(steep, PhasePoint<double, 1>(3, 0), 300, all);
  check(pendulums, PhasePoint<double, 2>({2.5, 2.5}, {0, 0}), 30, all);
  check(pendulums, PhasePoint<double, 2>({2.4, 2.5}, {0, 0}), 10, {1e-9});
  check(pendulums, PhasePoint<double, 2>({2.8, 2.5}, {0, 0}), 10, {1e-6});
}

namespace {

/// A position on a Kepler orbit of semi-major axis 1 that starts at its periapsis, along the axis.
double position_at(double e, double t) { return std::cos(eccentric_anomaly(e, t)) - e; }

/// Masses on a line between springs with a quadratic term (Fermi, Pasta, Ulam, Tsingou).
struct Chain {
  using Scalar = double;
  static constexpr int Dof = 15;
  double energy(In<double, 15> q, In<double, 15> p) const {
    double sum = p.squaredNorm() / 2;
    for (Eigen::Index i = 0; i <= 15; ++i) {
      const double d = (i < 15 ? q[i] : 0) - (i > 0 ? q[i - 1] : 0);
      sum += d * d / 2 + 0.25 * d * d * d / 3;
    }
    return sum;
  }
  void gradient(In<double, 15> q, In<double, 15> p, Out<double, 15> dHdq, Out<double, 15> dHdp) const {
    dHdp = p;
    dHdq.setZero();
    for (Eigen::Index i = 0; i <= 15; ++i) {
      const double d = (i < 15 ? q[i] : 0) - (i > 0 ? q[i - 1] : 0), force = d + 0.25 * d * d;
      if (i < 15) dHdq[i] += force;
      if (i > 0) dHdq[i - 1] -= force;
    }
  }
};

struct DrivenPendulum {
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(double t, In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / 2 - std::cos(q[0]) + q[0] * (0.1 * std::cos(0.7 * t) + 0.05 * std::sin(1.3 * t));
  }
  double gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                  Out<double, 1> dHdp) const {
    dHdq[0] = std::sin(q[0]) + 0.1 * std::cos(0.7 * t) + 0.05 * std::sin(1.3 * t);
    dHdp[0] = p[0];
    return q[0] * (-0.07 * std::sin(0.7 * t) + 0.065 * std::cos(1.3 * t));
  }
};

}  // namespace

TEST_CASE("over thousands of orbits advice counts rounding, or refuses for it", "[long]") {
  const double e = 0.3, T = 20'000, target = 1e-10;
  const PhasePoint<double, 2> z0 = at_periapsis(e);
  const auto cost =
      cost_of_accuracy(Kepler(), z0, T, {.observable = observables::Coordinate{0}, .targets = {target}});
  // A random walk of the energy by rounding: of the order of 1e-10 after that time.
  CHECK(cost.rounding > 1e-11);
  CHECK(cost.rounding < 1e-9);
  if (const auto advice = cost.cheapest(target)) {
    auto z = z0;
    double worst = 0;
    cost.run(z, *advice, [&](double t, const auto& now) {
      worst = std::max(worst, std::abs(now.q()[0] - position_at(e, t)));
    });
    CHECK(worst <= 3 * target);
  } else {
    CHECK(cost.reach(target) == Reach::rounding);
  }
}

TEST_CASE("a tight target takes nothing away from a loose one", "[long]") {
  const PhasePoint<double, 2> z0({0.5, 0}, {0, 1.75});
  for (const double T : {6000.0, 20'000.0}) {
    CAPTURE(T);
    const auto cost = cost_of_accuracy(
        Kepler(), z0, T,
        {.observable = observables::Coordinate{0}, .targets = {1e-1, 1e-10}, .splittings = {}});
    INFO(cost.why(1e-1));
    CHECK(cost.reach(1e-1) == Reach::met);
    CHECK(cost.parting_rate == 0);
  }
  // Where only runs of the whole time are advice, and the calls suffice for the loosest.
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    using std::sqrt;
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  const auto cost =
      cost_of_accuracy(h, at_periapsis(0.9), 1800.0,
                       {.observable = observables::Coordinate{0}, .targets = {1e-6, 1e-8, 1e-10}});
  const auto advice = cost.cheapest(1e-6);
  REQUIRE(advice);
  const auto place = [](const auto& q, const auto&) { return Eigen::Vector2d(q[0], 0); };
  CHECK(reached(cost, *advice, at_periapsis(0.9), place,
                [&](double t) { return Eigen::Vector2d(kepler_orbit(0.9, t).q()[0], 0); }) < 3e-6);
}

TEST_CASE("a regular orbit in floats is not taken for a chaotic one", "[long]") {
  for (const float e : {0.5f, 0.7f}) {
    CAPTURE(e);
    const PhasePoint<float, 2> z0({1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
    const auto cost = cost_of_accuracy(KeplerOf<float>(), z0, 628.0,
                                       {.observable = observables::Coordinate{0}, .targets = {1e-2}});
    INFO(cost.why(1e-2));
    CHECK(cost.reach(1e-2) == Reach::met);
  }
}

namespace {
/// p²/(2(1 + q²)) + q²/2.
struct VaryingMass {
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / (2 * (1 + q[0] * q[0])) + q[0] * q[0] / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double velocity = p[0] / (1 + q[0] * q[0]);
    dHdq[0] = q[0] - velocity * velocity * q[0];
    dHdp[0] = velocity;
  }
};
}  // namespace

TEST_CASE("a reference that gets worse by jumps is no chaos where neighbouring orbits stay together",
          "[long]") {
  const auto cost = cost_of_accuracy(VaryingMass{}, PhasePoint<double, 1>(2, 0), 1e5,
                                     {.observable = [](const auto& q, const auto&) { return q[0]; },
                                      .targets = {1e-4, 1e-9},
                                      .absolute = true,
                                      .max_gradients = 3e6});
  CHECK(cost.parting_rate == 0);
  CHECK(cost.rounding < 1e-4);
}

TEST_CASE("the unit of errors is the largest value on the orbit, not on a coarse run whose energy drifts",
          "[long]") {
  const auto unit = [](const auto& h, const PhasePoint<double, 1>& z0, double T, int power) {
    const auto f = [power](const auto& q, const auto&) { return std::pow(q[0], power); };
    return cost_of_accuracy(h, z0, T, {.observable = f, .targets = {1e-3}}).unit;
  };
  for (const int power : {1, 4})
    CHECK(unit(VaryingMass{}, {2, 0}, 2e4, power) == Approx(std::pow(2, power)).epsilon(0.03));
  // A beat that grows where the coarse run ends.
  const auto weakly_coupled = from_energy<2>([](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]) / 2 + 1e-5 * q[0] * q[1];
  });
  const auto beat =
      cost_of_accuracy(weakly_coupled, PhasePoint<double, 2>({1, 0}, {0, 0}), 3e5,
                       {.observable = observables::Coordinate{1}, .targets = {1e-4}, .min_gradients = 2e6});
  CHECK(beat.unit < 1.03);
}

TEST_CASE("the unit of errors is the orbit's where a coarse run hides a small motion beside a large one",
          "[long]") {
  const auto first = [](const auto& q, const auto&) { return q[0]; };
  const double w = 1.08, fall = GENERATE(0.0, 1000.0), T = 1e5, target = 1e-4;
  CAPTURE(fall);
  const auto h = from_energy<2>([=](const auto& q, const auto& p) {
    const auto slow = fall > 0 ? -fall * q[1] : 0.045 * q[1] * q[1];
    return w * (q[0] * q[0] + p[0] * p[0]) / 2 + p[1] * p[1] / 2 + slow;
  });
  const PhasePoint<double, 2> z0({1, fall > 0 ? 1.0 : 1e5}, {0.5, 0});
  const auto cost = cost_of_accuracy(h, z0, T, {.observable = first, .targets = {target}});
  CHECK(cost.unit == Approx(std::sqrt(1.25)).epsilon(0.03));
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  CHECK(worst_off(cost, *advice, z0, first,
                  [w](double t) { return std::cos(w * t) + 0.5 * std::sin(w * t); }) < 3 * target);
}

TEST_CASE("what parts without the observable's seeing it takes nothing away: an oscillator beside a saddle",
          "[long]") {
  const auto first = [](const auto& q, const auto&) { return q[0]; };
  const double w = 1.08, rate = 0.001, T = 2e4;
  const auto h = from_energy<2>([=](const auto& q, const auto& p) {
    return w * (q[0] * q[0] + p[0] * p[0]) / 2 + (p[1] * p[1] - rate * rate * q[1] * q[1]) / 2;
  });
  const PhasePoint<double, 2> z0({1, 1}, {0.5, 0});
  const auto cost = cost_of_accuracy(h, z0, T, {.observable = first, .targets = {1e-4, 1e-8}});
  for (const double target : {1e-4, 1e-8}) {
    INFO(target << ": " << cost.why(target));
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    CHECK(advice->error > 1e-3 * target);
    CHECK(worst_off(cost, *advice, z0, first,
                    [w](double t) { return std::cos(w * t) + 0.5 * std::sin(w * t); }) < 3 * target);
  }
}

TEST_CASE("a small motion that becomes chaotic is seen in a neighbouring orbit beside a large one",
          "[long]") {
  // Three oscillators of actions 5, 5e-4 and 9e4, each in a unit of its own, the middle one between weak
  // couplings.
  const auto h =
      ThreeInARow{.rate = {1.4860187666763047, 2.9375650006310887, 1.9231026322118667},
                  .length = {19432493.277363196, 3526.0515570517064, 23475111.437795971},
                  .momentum = {2.3783321140739657e-07, 1.5067503278966939e-07, 0.0039796830266348145},
                  .quartic = {0.0065235139348367695, 0.31241604622447261, 0.26826144090660758},
                  .couples = 7.0742341886002928e-05}
          .hamiltonian();
  const PhasePoint<double, 3> z0({-7374093.5278977901, -260.47174385846301, -18875886.153536726},
                                 {-1.0492538188728304e-07, 8.0869165630132331e-08, -0.00055248824875213083});
  const double T = 2813.80574, target = 1e-6;
  const auto cost =
      cost_of_accuracy(h, z0, T, {.observable = observables::Coordinate{1}, .targets = {target}});
  const auto advice = cost.cheapest(target);
  if (!advice) {
    CHECK(cost.reach(target) != Reach::no_step);
    return;
  }
  auto z = z0, exact = z0;
  cost.run(z, *advice);
  run(h, exact, T, Setting{.method = Setting::Method::gauss, .stages = 8, .dt = 0.05});
  CHECK(std::abs(z.q()[1] - exact.q()[1]) < 3 * target * cost.unit);
}

TEST_CASE("an error that grows faster behind the trials is seen by steps of two lengths", "[long]") {
  struct Case {
    ThreeInARow chain;
    PhasePoint<double, 3> z0;
    double T, target, calls;
    Eigen::Index observed;
  };
  const Case beats{{{2.4401638736249871, 1.368678837727209, 0.66939326435621704},
                    {0.0095342993515094374, 190.35744834963421, 1.50607371513453},
                    {0.049859672047158209, 0.0047868087068525878, 0.036965305505010572},
                    {0.26400455281690616, 0.042117251034852969, 0.41331580205514951},
                    3.9189072844591355e-06},
                   {{-0.013963751242649322, 79.992072846212565, 0.20245063911293437},
                    {-0.052894103273632219, 0.00027472576089752177, -0.0059805194370892521}},
                   10926.204598219407,
                   1e-7,
                   80803.652563614276,
                   0},
      chaotic{{{0.64952021012983985, 2.6581882768552925, 2.374772654457634},
               {0.037492617353329136, 0.0067897116413202065, 0.011081073219078787},
               {7.169822407067266, 0.60322916348255351, 8.0395400995530437},
               {0.15037977906267105, 0.31407986648181269, 0.83873135563191514},
               0.0012728541830083998},
              {{-0.025050715624501271, 0.0066092428719029339, 0.007603509004131659},
               {-9.1725145663571936, -0.86155123305015036, -0.84238093362794564}},
              11456.570293271725,
              1e-8,
              319822.44027047529,
              2};
  const Case one = GENERATE_COPY(beats, chaotic);
  CAPTURE(one.T);
  const auto h = one.chain.hamiltonian();
  const observables::Coordinate f{one.observed};
  const auto cost = cost_of_accuracy(h, one.z0, one.T,
                                     {.observable = f, .targets = {one.target}, .min_gradients = one.calls});
  const auto advice = cost.cheapest(one.target);
  if (!advice) {
    CHECK(cost.reach(one.target) != Reach::no_step);
    return;
  }
  auto z = one.z0, exact = one.z0;
  cost.run(z, *advice);
  run(h, exact, one.T, Setting{.method = Setting::Method::gauss, .stages = 8, .dt = 0.05});
  CHECK(std::abs(z.q()[f.index] - exact.q()[f.index]) < 3 * one.target * cost.unit);
}

TEST_CASE("a motion that gets faster in the course of the time is run to the end before it is advised",
          "[long]") {
  // An oscillator whose rate the position of a second degree of freedom, a clock, doubles.
  const double T = 1e5;
  const auto h = from_energy<2>(
      [T](const auto& q, const auto& p) { return (1 + q[1] / T) * (q[0] * q[0] + p[0] * p[0]) / 2 + p[1]; });
  const PhasePoint<double, 2> z0({1, 0}, {0.3, 0});
  const auto check = [&](const auto& cost, double target, const auto& f, const auto& exact) {
    CAPTURE(target);
    const auto advice = cost.cheapest(target);
    if (!advice)
      CHECK(cost.reach(target) == Reach::budget);
    else
      CHECK(worst_off(cost, *advice, z0, f, exact) < 3 * target * cost.unit);
  };
  const auto energy = [&h](const auto& q, const auto& p) { return h.energy(q, p); };
  const auto kept = [&](double) { return h.energy(z0.q(), z0.p()); };
  for (const double target : {1e-10, 1e-11})
    check(cost_of_accuracy(h, z0, T, {.targets = {target}}), target, energy, kept);
  const auto product = [](const auto& q, const auto& p) { return q[0] * p[0]; };
  const auto turned = [T](double t) {
    const double angle = t + t * t / (2 * T), c = std::cos(angle), s = std::sin(angle);
    return (c + 0.3 * s) * (0.3 * c - s);
  };
  check(cost_of_accuracy(h, z0, T, {.observable = product, .targets = {1e-6}}), 1e-6, product, turned);
}

TEST_CASE("a wall that comes behind the trials, once, is no surprise", "[long]") {
  struct Flight {
    LateWall wall;
    double T, target;
    bool shows_angle;
  };
  for (const auto& [wall, T, target, shows_angle] :
       {Flight{{14.632, 0.110871, 0.781582, 3778, 0.5, 0.7}, 18097.5, 1e-8, true},
        Flight{{10.75, 2.544, 23.17, 322.5, 0.5, 0.7}, 668.52, 1.45e-7, false}}) {
    CAPTURE(T);
    const auto h = from_energy<2>(wall);
    const auto shown = [angle = shows_angle](double position) {
      return angle ? Eigen::Vector2d(std::sin(position), std::cos(position)) : Eigen::Vector2d(position, 0);
    };
    const auto f = [shown](const auto& q, const auto&) { return shown(q[0]); };
    const auto cost =
        cost_of_accuracy(h, wall.at(0), T, {.observable = f, .targets = {target}, .absolute = !shows_angle});
    if (const auto advice = cost.cheapest(target))
      CHECK(worst_off(cost, *advice, wall.at(0), f,
                      [&, wall = wall](double t) { return shown(wall.at(t).q()[0]); }) < 3 * target);
    else
      CHECK(cost.reach(target) == Reach::budget);
  }
}

TEST_CASE("the passage of a saddle is no chaos", "[long]") {
  // A pendulum that swings over 1e-9 below the top: neighbours that start on both sides of that part at once.
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return p[0] * p[0] / 2 - cos(q[0]) + 1.5 * (q[1] * q[1] + p[1] * p[1]);
  });
  for (const double T : {2549.0, 7000.0}) {
    const auto cost = cost_of_accuracy(h, PhasePoint<double, 2>({0, 0.5}, {2 * (1 - 1e-9), 0.7}), T,
                                       {.observable = observables::Positions{}, .targets = {1e-5}});
    CHECK(cost.parting_rate == 0);
    CHECK(cost.reach(1e-5) != Reach::orbits_part);
  }
}

TEST_CASE("advice on whole runs only has met its target, or says what is missing") {
  // I + I²/20 with 2I = q² + p²: a circle with the rate 1 + I/10.
  const auto h = from_energy<1>([](const auto& q, const auto& p) {
    const auto action = (q[0] * q[0] + p[0] * p[0]) / 2;
    return action + action * action / 20;
  });
  const double T = 1e4;
  const PhasePoint<double, 1> start(1, 0);
  const auto place = [](const auto& q, const auto&) { return q[0]; };
  const auto ask = [&](const auto& what, bool whole, double most) {
    return cost_of_accuracy(h, start, T,
                            {.observable = what,
                             .targets = {1e-4, 1e-7},
                             .min_gradients = 1e4,
                             .max_gradients = most,
                             .whole = whole});
  };
  const Observable<double, 1> position = place, energy;
  CHECK(ask(position, false, 1e8).cheapest(1e-7)->tried < T);
  for (const auto& what : {position, energy}) {
    const auto cost = ask(what, true, 1e8);
    for (const double target : cost.targets) {
      CAPTURE(target);
      const auto advice = cost.cheapest(target);
      REQUIRE(advice);
      CHECK(advice->tried == T);
      const auto exact = [](double t) { return std::cos(1.05 * t); };
      auto z = start;
      Invariants invariants(h);
      CHECK((what.is_energy() ? (cost.run(z, *advice, invariants), invariants["energy"].worst)
                              : worst_off(cost, *advice, start, place, exact)) < 1.05 * target);
    }
    const auto boundless = ask(what, true, std::numeric_limits<double>::infinity());
    CHECK(boundless.cheapest(1e-7));
    CHECK(boundless.spent_gradients < 1e8);
    const auto less = ask(what, true, 2e4);
    CHECK(less.spent_gradients <= 2e4);
    CHECK(less.reach(1e-7) == Reach::budget);
  }
}

TEST_CASE("a wall is seen where its coordinate is mixed with an oscillator's, and so is the moment of it",
          "[long]") {
  struct Flight {
    LateWall wall;
    double T;
    std::vector<double> targets;
    bool shows_momentum;
  };
  for (const Flight& flight :
       {Flight{{1.51, 1.95623, 1.803, 170, -0.90164, 0.772696}, 1157.54, {5.53e-8, 1.942e-7}, true},
        Flight{{6.48811, 0.376643, 0.584082, 484.4, -0.19796, -0.36659, 2.8477}, 978.3, {4.068e-6}, true},
        Flight{{7.862, 0.5187, 1.294, 5687, 0.895678, -0.626224, 1.11}, 13450.7, {3.045e-6}, false},
        Flight{{2.69166, 2.15912, 1.99829, 9636, 0.739239, 0.793919, 1.21975}, 18411.9, {5.1e-6}, false}}) {
    CAPTURE(flight.T);
    const auto start = flight.wall.at(0);
    const auto shown = [&](double q, double p) {
      return flight.shows_momentum ? Eigen::Vector2d(p, 0) : Eigen::Vector2d(std::sin(q), std::cos(q));
    };
    const auto f = [shown](const auto& q, const auto& p) { return shown(q[0], p[0]); };
    const auto cost = cost_of_accuracy(from_energy<2>(flight.wall), start, flight.T,
                                       {.observable = f, .targets = flight.targets});
    for (const double target : flight.targets)
      if (const auto advice = cost.cheapest(target))
        CHECK(worst_off(cost, *advice, start, f, [&](double t) {
                const auto there = flight.wall.at(t);
                return shown(there.q()[0], there.p()[0]);
              }) < 3 * target * cost.unit);
      else
        CHECK(cost.reach(target) == Reach::budget);
  }
}

TEST_CASE("the velocity of a ball is right at its bounces, too", "[long]") {
  // On a stiff floor, from the height h: most steps of a coarse run are made in the bounces.
  struct Ball {
    double stiff, height, T, target;
  };
  for (const auto& [k, height, T, target] :
       {Ball{150, 1, 12, 1e-5}, Ball{100, 1, 12, 1e-7}, Ball{168, 1.55, 7.88, 5.4e-5}}) {
    CAPTURE(k, T);
    const auto h = from_energy<1>(
        [k = k](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0] + exp(-k * q[0]); });
    const PhasePoint<double, 1> z0(height, 0);
    const auto velocity = [](const auto&, const auto& p) { return p[0]; };
    const auto cost =
        cost_of_accuracy(h, z0, T, {.observable = velocity, .targets = {target}, .whole = true});
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    auto right = z0;  // by steps of a twentieth of a bounce
    double before = 0;
    CHECK(worst_off(cost, *advice, z0, velocity, [&, k = k](double t) {
            if (t > before)
              run(h, right, t - before, {.method = Setting::Method::gauss, .stages = 8, .dt = 0.05 / k});
            before = t;
            return right.p()[0];
          }) < 3 * target * cost.unit);
  }
}

TEST_CASE("a coarse run that leaves for where the orbit never comes does not set the unit", "[long]") {
  // A pendulum near its separatrix, which steps that are a little off take over the top, to wind.
  const double T = 2549;
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return p[0] * p[0] / 2 - cos(q[0]) + 8.5 / 2 * (q[1] * q[1] + p[1] * p[1]);
  });
  const PhasePoint<double, 2> z0({0, 0.5}, {2 * (1 - 1e-8), 0.7});
  const auto cost = cost_of_accuracy(
      h, z0, T, {.observable = observables::Positions{}, .targets = {1e-5}, .reversible = false});
  CHECK(cost.unit < 6.6);  // twice the largest position, π and the oscillator's 0.86
}

TEST_CASE("the distance of bodies that fall together is rounded as their places grow, and advice counts that",
          "[long]") {
  const double force = 9.81, T = 1e5;
  const auto apart = [](const auto& q, const auto&) { return q[0] - q[1]; };
  const auto h = from_energy<2>([=](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1]) / 2 + (q[0] - q[1]) * (q[0] - q[1]) / 4 - force * (q[0] + q[1]);
  });
  const PhasePoint<double, 2> z0({0.5, -0.5}, {0.25, -0.25});
  const auto cost = cost_of_accuracy(h, z0, T, {.observable = apart, .targets = {1e-3, 1e-4}});
  for (const double target : {1e-3, 1e-4}) {
    CAPTURE(target);
    const auto advice = cost.cheapest(target);
    if (!advice) {
      CHECK(cost.reach(target) == Reach::rounding);
      continue;
    }
    CHECK(worst_off(cost, *advice, z0, apart, [](double t) { return std::cos(t) + 0.5 * std::sin(t); }) <
          3 * target);
  }
}

TEST_CASE("a trial that is given up tells nothing of the time behind: an orbit that leaves") {
  const double slow = 0.00089707840436444226, fast = 0.0034687783905172397, T = 38662.921031549427;
  // Two saddles in coordinates that mix them, of units far apart.
  const double length = std::ldexp(1.0, -18), action = std::ldexp(1.0, 20);
  const auto saddles = [=](const auto& q, const auto& p) {
    const auto x = length * q[0], y = q[1], X = action / length * p[0], Y = action * p[1];
    return std::array{2 * x + y, x + y, X - Y, 2 * Y - X};
  };
  const auto h = from_energy<2>([=](const auto& q, const auto& p) {
    const auto [x, y, X, Y] = saddles(q, p);
    return ((X * X - slow * slow * x * x) / 2 + fast * y * Y) / action;
  });
  const PhasePoint<double, 2> z0({273282.28177317465, -2.0847804004991672},
                                 {-3.7974810767502293e-12, -9.9548704186569725e-07});
  const auto all = [saddles](const auto& q, const auto& p) {
    const auto [x, y, X, Y] = saddles(q, p);
    return Eigen::Vector4d(x, X, y, Y);
  };
  const auto cost =
      cost_of_accuracy(h, z0, T, {.observable = all, .targets = {1e-3, 1e-5, 1e-7, 1e-9, 1e-11}});
  const double there = all(z0.q(), z0.p())[2] * std::exp(fast * T);
  for (const double target : cost.targets) {
    CAPTURE(target);
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    auto z = z0;
    cost.run(z, *advice);
    CHECK(std::abs(all(z.q(), z.p())[2] / there - 1) < 3 * target);
  }
}

TEST_CASE("advice on an energy is run to the end where that is affordable: a fall over a washboard",
          "[long]") {
  const double force = 0.3, height = 0.05;
  const auto h = from_energy<2>([=](const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 - force * q[0] + height * cos(q[0]) + (q[1] * q[1] + p[1] * p[1]) / 2 +
           0.1 * q[1] * q[1] * p[1] * p[1];
  });
  const PhasePoint<double, 2> z0({0.3, 0.8}, {0.5, 0.3});
  const bool all = GENERATE(true, false);
  const auto targets = all ? std::vector{1e-3, 1e-5, 1e-7, 1e-9} : std::vector{1e-3};
  const double most = all ? 1e7 : 4e7;  // enough for the whole of it
  const auto cost =
      cost_of_accuracy(h, z0, 862, {.targets = targets, .min_gradients = most / 2, .max_gradients = most});
  for (const double target : targets) {
    CAPTURE(target);
    const auto advice = cost.cheapest(target);
    if (!all) REQUIRE(advice);
    if (!advice) continue;
    CHECK(advice->tried == 862);
    auto z = z0;
    Invariants energy(h);
    cost.run(z, *advice, energy);
    CHECK(energy["energy"].worst < 3 * target);
  }
}

TEST_CASE("an energy at a late time has no noise by the time's size", "[long]") {
  const Autonomous driven{DrivenPendulum()};
  for (const double t0 : {0.0, 1e4, 2e4, 3e4}) {
    CAPTURE(t0);
    const auto cost = cost_of_accuracy(driven, driven.extended({1.0, 0.3}, t0), 1000, {.targets = {1e-8}});
    INFO(cost.why(1e-8));
    CHECK(cost.rounding < 1e-10);
    CHECK(cost.reach(1e-8) == Reach::met);
  }
}

/// H = p²/2 + w²q²/2 - F q cos Wt; counts its gradients.
struct DrivenOscillator {
  using Scalar = double;
  static constexpr int Dof = 1;
  static constexpr double w = 0.82088, W = 0.821387, F = 0.150495;
  double* calls;
  double energy(double t, In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / 2 + w * w * q[0] * q[0] / 2 - F * q[0] * std::cos(W * t);
  }
  double gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                  Out<double, 1> dHdp) const {
    ++*calls;
    dHdq[0] = w * w * q[0] - F * std::cos(W * t);
    dHdp[0] = p[0];
    return F * q[0] * W * std::sin(W * t);
  }
};

TEST_CASE("a driven system that starts at zero gets its advice, within the bound on calls", "[long]") {
  using Driven = DrivenOscillator;
  for (const double bound : {1e5, 1e7}) {
    CAPTURE(bound);
    double calls = 0;
    const Autonomous driven(Driven{&calls});
    auto z = driven.extended({0, 0}, 0.0);
    const double T = 332.641;
    const auto cost = cost_of_accuracy(driven, z, T,
                                       {.observable = [](const auto& q, const auto&) { return q[0]; },
                                        .targets = {1e-5},
                                        .max_gradients = bound});
    INFO(cost.why(1e-5));
    CHECK(calls <= bound);
    const auto advice = cost.cheapest(1e-5);
    if (!advice && bound < 1e6) continue;
    REQUIRE(advice);
    cost.run(z, *advice);
    const double right = Driven::F / (Driven::w * Driven::w - Driven::W * Driven::W) *
                         (std::cos(Driven::W * T) - std::cos(Driven::w * T));
    CHECK(std::abs(z.q()[0] - right) < 3e-5 * 30.2);
  }
}

TEST_CASE("H of a system with transformed time is kept where K is zero: parts of the run begin there",
          "[long]") {
  for (const double e : {0.9, 0.95}) {
    CAPTURE(e);
    const PhasePoint<double, 2> z0 = at_periapsis(e);
    const TimeTransformed transformed(Kepler(), monitors::Distance{1.5}, -0.5);
    const auto energy = [](const auto& q, const auto& p) {
      return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / std::hypot(q[0], q[1]);
    };
    const auto cost = cost_of_accuracy(transformed, transformed.extended(z0, 0.0), 300,
                                       {.observable = energy, .targets = {1e-8}});
    INFO(cost.why(1e-8));
    CHECK(cost.reach(1e-8) == Reach::met);
  }
}

TEST_CASE("a reference is judged by how it converges: the energy of a chain's slowest mode", "[long]") {
  PhasePoint<double, 15> z0;
  z0.vector().setZero();
  Eigen::Matrix<double, 15, 1> mode;
  const double pi = std::acos(-1);
  for (int i = 0; i < 15; ++i) mode[i] = std::sqrt(2.0 / 16) * std::sin(pi * (i + 1) / 16);
  for (int i = 0; i < 15; ++i) z0.q()[i] = std::sin(pi * (i + 1) / 16);
  const auto energy = [mode, frequency = 2 * std::sin(pi / 32)](const auto& q, const auto& p) {
    return (std::pow(mode.dot(p), 2) + std::pow(frequency * mode.dot(q), 2)) / 2;
  };
  const double target = 1e-11;
  const auto cost = cost_of_accuracy(Chain(), z0, 1000, {.observable = energy, .targets = {target}});
  INFO(cost.why(target));
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  auto z = z0, exact = z0;
  cost.run(z, *advice);
  GaussLegendre gauss(Chain(), {.stages = 8});
  integrate(gauss, exact, {.dt = 0.25, .t_end = 1000});
  CHECK(std::abs(energy(z.q(), z.p()) - energy(exact.q(), exact.p())) <= 3 * target * cost.unit);
}

TEST_CASE("a well: what the stopping rule of a projection lets the energy drift by is seen behind a trial") {
  const auto well = from_energy<1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0] * q[0] * (q[0] * q[0] - 2) / 4; });
  const PhasePoint<double, 1> z0(1.1, 0.1);
  const double target = 1.5e-10;
  const auto cost = cost_of_accuracy(well, z0, 1e6, {.targets = {target}});
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  REQUIRE(advice->setting.method == Setting::Method::semiexplicit);
  CHECK(advice->tried < 0.1 * cost.time);
  auto z = z0;
  Invariants invariants(well);
  cost.run(z, *advice, invariants);
  CHECK(invariants["energy"].worst <= 1.2 * target);  // it was 2.3 times the target
}

TEST_CASE("a linear motion over thousands of periods gets no harder along the way", "[long]") {
  const auto oscillator =
      from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; });
  const PhasePoint<double, 1> z0(1, 0);
  const auto cost =
      cost_of_accuracy(oscillator, z0, 1e4, {.observable = observables::Coordinate{0}, .targets = {1e-6}});
  INFO(cost.why(1e-6));
  const auto advice = cost.cheapest(1e-6);
  REQUIRE(advice);
  auto z = z0;
  double worst = 0;
  cost.run(z, *advice,
           [&](double t, const auto& now) { worst = std::max(worst, std::abs(now.q()[0] - std::cos(t))); });
  CHECK(worst <= 2e-6);
}

TEST_CASE("degrees of freedom in units far apart get the same advice as in one: two oscillators") {
  struct Case {
    double unit, T, first, second, at_first, at_second, coupling;
  };
  const Case one = GENERATE(Case{1.32e-7, 2.37e4, 0.992, 0.605, 5.17, 0.742, 0.0278},
                            Case{2.63e-7, 2.213e5, 0.99, 0.775, 0.759, 4.538, 0.0249},
                            Case{8.32e6, 1.097e4, 0.839, 0.596, 4.589, 0.733, 0.0489});
  const double unit = one.unit;
  const PhasePoint<double, 2> z0(
      {one.first * std::cos(one.at_first), one.second * std::cos(one.at_second) / unit},
      {one.first * std::sin(one.at_first), one.second * std::sin(one.at_second) * unit});
  const auto in_one_unit = [unit](const auto& q, const auto& p) {
    return Eigen::Vector4d(q[0], p[0], unit * q[1], p[1] / unit);
  };
  const auto cost = cost_of_accuracy(UnlikeUnits{unit, one.coupling}, z0, one.T,
                                     {.observable = in_one_unit, .targets = {1e-3, 1e-6}});
  for (const double target : {1e-3, 1e-6}) {
    INFO("unit " << unit << ", target " << target << ": " << cost.why(target));
    CHECK(cost.cheapest(target));  // was refused: "the gradient calls ended"
  }
}

TEST_CASE("an orbit that leaves as fast as neighbours part is not lost: a charge on a saddle", "[long]") {
  struct Charge {
    double field, mass, force, saddle, unit_x, unit_y;
  };
  const std::array<Charge, 3> charges{Charge{0.919695, 5.57317, -0.404058, 0, 1, 0.0625},
                                      Charge{5.05115, 0.23845, 0.0387787, 0.00280135, 4, 16},
                                      Charge{0.524764, 2.58741, -0.364988, 0.0102483, 8, 8}};
  const auto all = from_energy<6>([charges](const auto& q, const auto& p) {
    auto sum = 0 * q[0];
    for (int i = 0; i < 3; ++i) {
      const auto& [field, mass, force, saddle, unit_x, unit_y] = charges[static_cast<std::size_t>(i)];
      const auto x = q[2 * i] / unit_x, y = q[2 * i + 1] / unit_y;
      const auto vx = p[2 * i] * unit_x + field / 2 * y, vy = p[2 * i + 1] * unit_y - field / 2 * x;
      sum += (vx * vx + vy * vy) / (2 * mass) - force * x + saddle / 2 * (x * x - y * y);
    }
    return sum;
  });
  const PhasePoint<double, 6> z0({0.240384, -0.0338671, -0.669575, 9.26991, -7.91145, -7.70007},
                                 {0.563201, -15.4032, 0.0771045, 0.0190203, -0.0958586, 0.0678581});
  const auto cost =
      cost_of_accuracy(all, z0, 1900, {.observable = observables::Trajectory{}, .targets = {5.8e-8, 1e-8}});
  for (const double target : {5.8e-8, 1e-8}) {
    INFO(cost.why(target));
    CHECK(cost.reach(target) != Reach::orbits_part);
  }
}

TEST_CASE("the energy of an orbit that leaves is rounded as its terms grow, and advice counts that") {
  const double rate = 0.0625, target = GENERATE(1e-4, 1e-6), T = GENERATE(270.0, 300.0, 340.0);
  CAPTURE(target, T);
  const auto energy = [rate](const auto& q, const auto& p) {
    return (p[0] * p[0] - rate * rate * q[0] * q[0] + p[1] * p[1] + q[1] * q[1] +
            q[1] * q[1] * q[1] * q[1] / 4) /
           2;
  };
  const PhasePoint<double, 2> z0({0.1, 1}, {0.01, 0.3});
  const auto cost = cost_of_accuracy(from_energy<2>(energy), z0, T, {.targets = {target}});
  const auto advice = cost.cheapest(target);
  if (!advice) {
    CHECK(cost.reach(target) == Reach::rounding);
    return;
  }
  const auto exact = [&](const auto& z) {
    return energy(z.q().template cast<long double>().eval(), z.p().template cast<long double>().eval());
  };
  auto z = z0;
  long double worst = 0;
  cost.run(z, *advice,
           [&](double, const auto& now) { worst = std::max(worst, std::abs(exact(now) - exact(z0))); });
  CHECK(static_cast<double>(worst / std::abs(exact(z0))) < 3 * target);
}

TEST_CASE("advice does not depend on the unit of mass where an angle is cyclic") {
  const double mass = std::ldexp(1.0, GENERATE(0, -40, -66));
  CAPTURE(mass);
  const auto polar = from_energy<2>([mass](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1] / (q[0] * q[0])) / (2 * mass) - mass / q[0];
  });
  const PhasePoint<double, 2> z0({1, 0}, {mass / 16, 1.08 * mass});
  const auto cost =
      cost_of_accuracy(polar, z0, 4e4, {.observable = observables::Coordinate{0}, .targets = {1e-4}});
  INFO(cost.why(1e-4));
  CHECK(cost.cheapest(1e-4));
}

TEST_CASE("an angle that winds is rounded more and more, and advice counts that", "[long]") {
  const auto pendulum = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - std::cos(q[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq[0] = std::sin(q[0]), dHdp = p; });
  const auto direction = [](const auto& q, const auto&) {
    return Eigen::Vector2d(std::sin(q[0]), std::cos(q[0]));
  };
  const auto cost = cost_of_accuracy(pendulum, PhasePoint<double, 1>(0, 2.5), 2000,
                                     {.observable = direction, .targets = {1e-6, 1e-10}});
  CHECK(cost.reach(1e-6) == Reach::met);
  CHECK(cost.reach(1e-10) == Reach::rounding);  // 3e-9 is what a run with 4e-11 of its steps' error comes to
}

namespace {

/// Three stiff springs between soft ones, as in I.5.1 of Hairer, Lubich, Wanner, Geometric Numerical
/// Integration (2006).
struct StiffSprings {
  using Scalar = double;
  static constexpr int Dof = 6;
  static constexpr double stiff = 50;
  static Eigen::Vector4d soft(const In<double, 6>& q) {
    return {q[0] - q[3], q[1] - q[4] - q[0] - q[3], q[2] - q[5] - q[1] - q[4], q[2] + q[5]};
  }
  double energy(const In<double, 6>& q, const In<double, 6>& p) const {
    return (p.squaredNorm() + stiff * stiff * q.tail(3).squaredNorm()) / 2 + soft(q).array().pow(4).sum() / 4;
  }
  void gradient(const In<double, 6>& q, const In<double, 6>& p, Out<double, 6> dHdq,
                Out<double, 6> dHdp) const {
    const Eigen::Vector4d f = soft(q).array().cube();
    for (int i = 0; i < 3; ++i) {
      dHdq[i] = i < 2 ? f[i] - f[i + 1] : f[2] + f[3];
      dHdq[3 + i] = stiff * stiff * q[3 + i] - f[i] + (i < 2 ? -f[i + 1] : f[3]);
    }
    dHdp = p;
  }
};

/// A light body in the frame of the Earth and the Moon.
struct AboutTwoBodies {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr double moon = 0.0121505;
  double energy(const In<double, 2>& q, const In<double, 2>& p) const {
    const double x = q[0] + moon;
    return p.squaredNorm() / 2 + q[1] * p[0] - q[0] * p[1] - (1 - moon) / std::hypot(x, q[1]) -
           moon / std::hypot(x - 1, q[1]);
  }
  void gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                Out<double, 2> dHdp) const {
    const double x = q[0] + moon, earth = (1 - moon) / std::pow(std::hypot(x, q[1]), 3),
                 other = moon / std::pow(std::hypot(x - 1, q[1]), 3);
    dHdq << -p[1] + earth * x + other * (x - 1), p[0] + (earth + other) * q[1];
    dHdp << p[0] + q[1], p[1] - q[0];
  }
};

/// A charge in a magnetic field and a round trough: it turns fast, and drifts slowly.
struct Charge {
  using Scalar = double;
  static constexpr int Dof = 2;
  double field = 100;
  double energy(const In<double, 2>& q, const In<double, 2>& p) const {
    return (Eigen::Vector2d(p[0] + field / 2 * q[1], p[1] - field / 2 * q[0]).squaredNorm() +
            q.squaredNorm()) /
           2;
  }
  void gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                Out<double, 2> dHdp) const {
    dHdp << p[0] + field / 2 * q[1], p[1] - field / 2 * q[0];
    dHdq << q[0] - field / 2 * dHdp[1], q[1] + field / 2 * dHdp[0];
  }
};

}  // namespace

TEST_CASE("chaos that a trial does not show is seen in a neighbouring orbit", "[long]") {
  PhasePoint<double, 6> z0;
  z0.q() << 1, 0, 0, 0.02, 0, 0;
  z0.p() << 1, 0, 0, 1, 0, 0;
  const auto cost = cost_of_accuracy(StiffSprings(), z0, 1000, {.observable = observables::Coordinate{0}});
  for (const double target : cost.targets) {
    CAPTURE(target, cost.why(target));
    CHECK(cost.reach(target) == Reach::orbits_part);
  }
}

TEST_CASE("chaos is no advice where the calls end before a neighbouring orbit was followed") {
  const double target = 1e-8;
  for (const double shift : {0.0, 0.1})
    for (const double T : {60.0, 100.0})
      for (const double bound : {3e4, 7e4, 3e5}) {
        CAPTURE(shift, T, bound);
        const PhasePoint<double, 3> z0({1.2, 0.2 + shift, -0.1}, {0.1, 0.25, 0.2 - shift});
        const auto cost = cost_of_accuracy(
            systems::NlsLattice<double, 3>(), z0, T,
            {.observable = observables::Trajectory{}, .targets = {target}, .max_gradients = bound});
        const auto advice = cost.cheapest(target);
        CHECK((!advice || advice->tried >= T));
        if (bound == 3e4) CHECK(cost.reach(target) == Reach::budget);
      }
}

TEST_CASE("what errors are relative to is not enlarged by the drift of a coarse run") {
  const double c = 0.62, k = 0.2486;
  const auto H = from_energy<1>([=](const auto& q, const auto& p) {
    const auto square = q[0] * q[0];
    return p[0] * p[0] / (2 * (1 + c * square)) + square / 2 + k * square * square / 4;
  });
  const PhasePoint<double, 1> z0(0.965, 1);
  const double largest = (std::sqrt(0.25 + k * H.energy(z0.q(), z0.p())) - 0.5) / (k / 2);  // where p = 0
  const CostOptionsOf<double, 1> options{.observable = [](const auto& q, const auto&) { return q[0] * q[0]; },
                                         .targets = {1e-3, 1e-4}};
  for (const double T : {12e3, 24e3})
    CHECK(cost_of_accuracy(H, z0, T, options).unit == Approx(largest).epsilon(0.03));
}

TEST_CASE("an orbit that comes close to a body is tried to the end before it is advised", "[long]") {
  const PhasePoint<double, 2> z0({0.8369, 0}, {0, 0.8369});
  const double T = 100;
  const auto cost = cost_of_accuracy(AboutTwoBodies(), z0, T, {.observable = observables::Trajectory{}});
  const Setting tight{.method = Setting::Method::gauss, .stages = 8, .dt = 0.01};
  for (const double target : cost.targets)
    if (const auto advice = cost.cheapest(target)) {
      CAPTURE(target, *advice);
      auto z = z0, exact = z0;
      cost.run(z, *advice);
      run(AboutTwoBodies(), exact, T, tight);
      CHECK((z.vector() - exact.vector()).norm() <= 3 * target * cost.unit);
    }
  CHECK(cost.cheapest(1e-4));
}

TEST_CASE("a coarse run that is carried over a saddle does not end the orbit", "[long]") {
  // Just below the energy of escape, 1/6, from which no orbit gets away.
  const auto henon_heiles = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) {
        return (p.squaredNorm() + q.squaredNorm()) / 2 + q[0] * q[0] * q[1] - q[1] * q[1] * q[1] / 3;
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0] + 2 * q[0] * q[1], dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
        dHdp = p;
      });
  const PhasePoint<double, 2> z0({0, -0.1}, {std::sqrt(2 * (0.1665 - 0.005 - 0.001 / 3)), 0});
  const auto cost = cost_of_accuracy(henon_heiles, z0, 1e5, {.targets = {1e-6}});
  CHECK(cost.orbit_end > cost.time);
  CHECK(cost.cheapest(1e-6));
}

TEST_CASE("a coordinate that has grown in a trial need not go on to grow: a charge that drifts in a circle",
          "[long]") {
  const PhasePoint<double, 2> z0({1, 0}, {0.1, 50});
  const auto cost = cost_of_accuracy(Charge(), z0, 3 * 2 * std::acos(-1) * 100,
                                     {.observable = observables::Coordinate{1}, .targets = {1e-5}});
  CHECK(cost.unit == Approx(1.001).epsilon(0.01));
}

TEST_CASE(
    "reversible steps that only fail take nothing away from other methods: a fall from an unstable circle",
    "[long]") {
  const auto schwarzschild = from_energy<3>([](const auto& q, const auto& p) {  // of (r, phi, t)
    const auto f = 1 - 2 / q[0];
    return (f * p[0] * p[0] + p[1] * p[1] / (q[0] * q[0]) - p[2] * p[2] / f) / 2;
  });
  const double r = 4.0001;
  const PhasePoint<double, 3> z0({r, 0, 0}, {0, 4, std::sqrt((1 - 2 / r) * (1 + 16 / (r * r)))});
  const auto cost = cost_of_accuracy(schwarzschild, z0, 2000);
  for (const double target : cost.targets) {
    CAPTURE(target);
    REQUIRE(cost.cheapest(target));
    CHECK(cost.cheapest(target)->gradients < 1e4);
  }
}

/// A ring of oscillators in wells with a corner: the force on each jumps where its coordinate is 0.
struct Jumps {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index n;
  Eigen::Index dof() const { return n; }
  double energy(In<double, Dof> q, In<double, Dof> p) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const double stretched = q[(i + 1) % n] - q[i];
      sum += p[i] * p[i] * (1 + 0.25 * q[i] * q[i]) / 2 + q[i] * q[i] / 2 + 0.3 * std::abs(q[i]) +
             0.1 * stretched * stretched;
    }
    return sum;
  }
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    for (Eigen::Index i = 0; i < n; ++i) {
      const double before = q[(i + n - 1) % n], behind = q[(i + 1) % n];
      dHdq[i] = 0.25 * p[i] * p[i] * q[i] + q[i] +
                (q[i] > 0   ? 0.3
                 : q[i] < 0 ? -0.3
                            : 0) +
                0.2 * (2 * q[i] - before - behind);
      dHdp[i] = p[i] * (1 + 0.25 * q[i] * q[i]);
    }
  }
};

TEST_CASE("a start where forces jump gives advice that was tried, or none", "[long]") {
  for (const Eigen::Index n : {2, 3, 5, 8})
    for (int start = 0; start < 4; ++start) {
      CAPTURE(n, start);
      PhasePoint<double, Eigen::Dynamic> z0(n);
      for (Eigen::Index i = 0; i < 2 * n; ++i) {
        const double x = 0.2 * std::sin(7.0 * static_cast<double>(i * i + 1) + 3.0 * start);
        z0.vector()[i] = x > 0 ? x : 0;  // half of them on the jump
      }
      const auto cost = cost_of_accuracy(Jumps{n}, z0, 20, {.targets = {1e-2}});
      const auto advice = cost.cheapest(1e-2);
      if (!advice) continue;
      CHECK(advice->tried > 1e-3 * 20);
      auto z = z0;
      Invariants invariants(Jumps{n});
      CHECK(cost.run(z, *advice, invariants).ok());
      CHECK(invariants["energy"].worst <= 3e-2);
    }
}

TEST_CASE("a target is not lost in rounding because the motion is harder behind the first stretch") {
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return p[0] * p[0] / (2 * (1 + q[0] * q[0])) + p[1] * p[1] / (2 * (1 + q[1] * q[1])) +
           (q[0] * q[0] + q[1] * q[1]) / 2 + q[0] * q[0] * q[1] * q[1] / 8;
  });
  const PhasePoint<double, 2> start({1.75651116986, 1.11355694216}, {-0.171180762893, -0.277205719092});
  const auto cost =
      cost_of_accuracy(h, start, 5000.0, {.observable = observables::Positions{}, .targets = {1e-8}});
  CHECK(cost.cheapest(1e-8));
  CHECK(cost.reference_error < 1e-10);  // 2e-12 is what Gauss's method is off by, in long double
}

TEST_CASE("a step that fails behind its trial takes no other setting's advice away: a planet") {
  // From the pericentre of an orbit of another size than kepler_orbit()'s.
  const PhasePoint<double, 2> start({0.7, 0}, {0, 1.2});
  const double a = 1 / (2 / 0.7 - 1.44), e = 1 - 0.7 / a;
  const auto place = [](const auto& q, const auto&) -> Eigen::Vector2d { return q; };
  for (const double T : {3000.0, 15000.0}) {
    const auto cost = cost_of_accuracy(
        Kepler(), start, T,
        {.observable = [](const auto& q, const auto&) { return q[0]; }, .targets = {1e-4, 1e-6, 1e-8}});
    for (const double target : cost.targets) {
      const auto advice = cost.cheapest(target);
      REQUIRE(advice);
      CHECK(reached(cost, *advice, start, place, [&](double t) -> Eigen::Vector2d {
              return a * kepler_orbit(e, t / (a * std::sqrt(a))).q();
            }) < 3 * target);
    }
  }
}

TEST_CASE("a target is not lost in rounding where a pericentre is far harder: a planet") {
  const auto place = [](const auto& q, const auto&) -> Eigen::Vector2d { return q; };
  const double e = 0.7, target = 1e-10;
  const auto cost =
      cost_of_accuracy(Kepler(), at_periapsis(e), 1500.0, {.observable = place, .targets = {target}});
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  CHECK(reached(cost, *advice, at_periapsis(e), place,
                [&](double t) -> Eigen::Vector2d { return kepler_orbit(e, t).q(); }) < 3 * target);
}

TEST_CASE("what rounding makes of an energy is seen in a run of the whole time: Arenstorf's orbit") {
  static constexpr double moon = 0.012277471;
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    using std::hypot;
    return (p[0] * p[0] + p[1] * p[1]) / 2 + q[1] * p[0] - q[0] * p[1] -
           (1 - moon) / hypot(q[0] + moon, q[1]) - moon / hypot(q[0] - 1 + moon, q[1]);
  });
  const PhasePoint<double, 2> start({0.994, 0}, {0, 0.994 - 2.00158510637908252});
  const std::vector<double> targets{1e-10, 1e-13, 1e-14};
  const auto cost =
      cost_of_accuracy(h, start, 17.0652165601579625, {.targets = targets, .by = CostBy::gradients});
  for (const double target : targets) {
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    auto z = start;
    Invariants energy(h);
    cost.run(z, *advice, energy);
    CHECK(energy["energy"].worst < 1.5 * target);
  }
  CHECK(cost.rounding < 1e-14);
}

namespace {
/// p²/2 + depth (1 - exp(-rate q))² from its outer turning point, at that part of the energy at which it
/// breaks.
struct Bond {
  double rate, depth, part;

  auto energy(const auto& q, const auto& p) const {
    using std::exp;
    const auto x = 1 - exp(-rate * q);
    return p * p / 2 + depth * x * x;
  }
  double frequency() const { return rate * std::sqrt(2 * depth * (1 - part)); }
  double start() const { return std::log((1 + std::sqrt(part)) / (1 - part)) / rate; }
  double momentum(double t) const {
    const double phase = frequency() * t;
    return -std::sqrt(part) * frequency() * std::sin(phase) / (1 + std::sqrt(part) * std::cos(phase)) / rate;
  }
};
}  // namespace

TEST_CASE("A run of the whole meets its target at each turn, also of two bonds that are about to break",
          "[long]") {
  const auto [first, second, T, target] =
      GENERATE(table<Bond, Bond, double, double>({{{1.12, 0.528, 0.793}, {1.401, 1.469, 0.999}, 245, 1e-7},
                                                  {{0.705, 0.502, 0.997}, {0.733, 1.406, 0.978}, 145, 1e-3},
                                                  {{2.01, 0.702, 0.971}, {1.959, 0.553, 0.929}, 275, 1e-4},
                                                  {{1.937, 2.59, 0.726}, {2.625, 1.828, 0.999}, 89, 1e-4}}));
  const Bond a = first, b = second;
  const auto h = from_energy<2>(
      [=](const auto& q, const auto& p) { return a.energy(q[0], p[0]) + b.energy(q[1], p[1]); });
  const auto momenta = [](const auto&, const auto& p) { return Eigen::Vector2d(p[0], p[1]); };
  const PhasePoint<double, 2> z0({a.start(), b.start()}, {0, 0});
  const auto cost = cost_of_accuracy(h, z0, T, {.observable = momenta, .targets = {target}, .whole = true});
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  CHECK(reached(cost, *advice, z0, momenta,
                [&](double t) { return Eigen::Vector2d(a.momentum(t), b.momentum(t)); }) < 2 * target);
}

TEST_CASE("Two runs that a jump of the force has made wrong by the same are no reference", "[long]") {
  const auto h = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 + std::abs(q[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0] > 0 ? 1 : q[0] < 0 ? -1 : 0;
        dHdp = p;
      });
  const auto [q0, p0, T, target] = GENERATE(table<double, double, double, double>(
      {{0.55012928431296004, 0.04030820216189035, 3.0355864328718116, 4.7456435921034916e-07},
       {0.55, 0.04, 3.0, 5e-7},
       {0.7, 0.1, 3.0, 1e-6},
       {0.52725860425315041, 0.28318417733628531, 1.7817702100621879, 6.8e-06}}));
  const bool only_momentum = GENERATE(false, true);
  const double start = q0, first = p0, v = std::sqrt(first * first + 2 * start), jump = first + v;
  const PhasePoint<double, 1> z0(start, first);
  const auto exact = [&](double t) {
    const double s = t - jump;
    return t < jump ? Eigen::Vector2d(start + first * t - t * t / 2, first - t)
                    : Eigen::Vector2d(-v * s + s * s / 2, -v + s);
  };
  REQUIRE(T < jump + 2 * v);
  const auto seen = [=](const auto& q, const auto& p) {
    return Eigen::Vector2d(only_momentum ? 0.0 : q[0], p[0]);
  };
  const auto exactly_seen = [&](double t) { return seen(exact(t).head<1>(), exact(t).tail<1>()); };
  const auto cost = cost_of_accuracy(h, z0, T, {.observable = seen, .targets = {target}, .whole = true});
  if (const auto advice = cost.cheapest(target))
    CHECK(worst_off(cost, *advice, z0, seen, exactly_seen) < 3 * target * cost.unit);
}

TEST_CASE("A dear reference has to agree twice, too: one wall, whose force jumps once") {
  const double wall = -0.37522071402537094, stiff = 8888.5361308852443, push = 0.13540607693727413,
               pull = -5.5866209998016831, mass = 0.47641312432323499, T = 1.9979645913286765,
               target = 9.1942347532341895e-07;
  const auto h = make_hamiltonian<double, 1>(
      [=](const auto& q, const auto& p) {
        const double d = q[0] - wall;
        return p[0] * p[0] / 2 / mass + (d >= 0 ? push * d + stiff * d * d / 2 : pull * d);
      },
      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        const double d = q[0] - wall;
        dHdq[0] = d >= 0 ? push + stiff * d : pull;
        dHdp[0] = p[0] / mass;
      });
  const PhasePoint<double, 1> z0(-0.22530968353201386, 0.79225062243098199);
  // An oscillation until it leaves the wall, after half a period at most, then a free fall.
  const double w = std::sqrt(stiff / mass), c = push / stiff, d0 = z0.q()[0] - wall + c,
               v0 = z0.p()[0] / mass, size = std::hypot(d0, v0 / w),
               leaves = (std::acos(c / size) + std::atan2(v0 / w, d0)) / w,
               speed = -w * std::sqrt(size * size - c * c);
  const auto exact = [=](double t) {
    const double s = t - leaves;
    return Eigen::Vector2d(t < leaves ? wall - c + d0 * std::cos(w * t) + v0 / w * std::sin(w * t)
                                      : wall + speed * s - pull / mass * s * s / 2,
                           0);
  };
  const auto place = [](const auto& q, const auto&) { return Eigen::Vector2d(q[0], 0); };
  for (const double min_gradients : {1e5, 5e6}) {
    const auto cost = cost_of_accuracy(h, z0, T,
                                       {.observable = observables::Coordinate{0},
                                        .targets = {4.0038398183614314e-05, target},
                                        .min_gradients = min_gradients});
    for (const double each : cost.targets) {
      const auto advice = cost.cheapest(each);
      CHECK((!advice || worst_off(cost, *advice, z0, place, exact) < 3 * each * cost.unit));
    }
  }
}

TEST_CASE("A reference that never agreed is not known to what its last try is apart by accident") {
  Eigen::Matrix3d turn;
  turn << -0.20737996030440398, -0.65095461425010104, -0.73024081113742634, 0.94895112213634203,
      -0.31521352380570367, 0.011497921819549783, -0.23766640456808641, -0.690578398588092,
      0.68309307970670075;
  const Eigen::Array3d mass(2.9509477620037026, 1.7629919415075495, 1.1754302223678155),
      wall(-0.24225007069342086, 0.52934860231518654, 0.95423140835417075),
      push(-0.73245900184324719, 0.39003716342928896, -0.04379260450847311),
      pull(0.73245900184324719, 0.42969814395054895, 0.04379260450847311),
      stiff(0.26975218189284461, 3.4929029054331266, 1.5233630726834517),
      soft(0.26975218189284461, 2.0327416354121426, 1.5233630726834517);
  // Three oscillators in halves, seen turned; the force of the second jumps.
  const auto h = make_hamiltonian<double, 3>(
      [=](const auto& q, const auto& p) {
        const Eigen::Array3d d = (turn.transpose() * q).array() - wall, Y = (turn.transpose() * p).array();
        const Eigen::Array3d outside = push * d + stiff * d.square() / 2,
                             inside = -pull * d + soft * d.square() / 2;
        return (Y.square() / mass / 2 + (d >= 0).select(outside, inside)).sum();
      },
      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        const Eigen::Array3d d = (turn.transpose() * q).array() - wall, Y = (turn.transpose() * p).array();
        const Eigen::Array3d outside = push + stiff * d, inside = -pull + soft * d;
        dHdq = turn * (d >= 0).select(outside, inside).matrix();
        dHdp = turn * (Y / mass).matrix();
      });
  const PhasePoint<double, 3> z0({0.90086664775043523, 1.273157408797329, -2.4326354622841762},
                                 {-0.39921042912121224, 0.82961583042345921, 1.6122587475405197});
  const auto seen = [](const auto& q, const auto& p) { return Eigen::Vector2d(q[2] * q[2], p[2]); };
  const auto cost =
      cost_of_accuracy(h, z0, 1.6119084097619161,
                       {.observable = seen,
                        .targets = {1.0244758339710871e-06, 0.00015671963937313025, 1.407181076957156e-08}});
  // 3e-7 by leapfrog's steps of 2e-8.
  CHECK(cost.reference_error > 1e-7);
  CHECK_FALSE(cost.cheapest(1.407181076957156e-08));
}

}  // namespace test_long_advice
