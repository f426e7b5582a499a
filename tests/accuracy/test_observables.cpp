// What accuracy costs for something else than the energy. Advice is judged against runs with a far smaller
// step.
#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/observers/events.hpp>
#include <semiexplicit/observers/every.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/product.hpp>
#include <semiexplicit/systems/vortices.hpp>
#include <semiexplicit/time.hpp>

#include "catch.hpp"

#include "kepler.hpp"
#include "refusal.hpp"

namespace test_observables {

using namespace semiexplicit;

namespace {

const PhasePoint<double, 2> planet({0.5, 0}, {0, std::sqrt(3.0)});  // eccentricity 1/2, period 2 pi

/// Two rods of unit length with unit masses at their ends: chaotic at this height.
struct DoublePendulum {
  using Scalar = double;
  static constexpr int Dof = 2;
  double energy(In<double, 2> q, In<double, 2> p) const {
    const double c = std::cos(q[0] - q[1]), n = 2 - c * c;
    return (p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c) / (2 * n) - 2 * std::cos(q[0]) -
           std::cos(q[1]);
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    const double c = std::cos(q[0] - q[1]), s = std::sin(q[0] - q[1]), n = 2 - c * c;
    const double top = p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c;
    const double turn = p[0] * p[1] * s / n - top * c * s / (n * n);
    dHdq << turn + 2 * std::sin(q[0]), -turn + std::sin(q[1]);
    dHdp << (p[0] - p[1] * c) / n, (2 * p[1] - p[0] * c) / n;
  }
};

/// The largest error of f(z) in an advised run, by a tight one, and the largest f.
template <class H, class F>
std::pair<double, double> compared(const CostOfAccuracy<H>& cost, const CostRow& advice, const H& h,
                                   const PhasePoint<double, H::Dof>& z0, double tight, const F& f) {
  const Setting reference{.method = Setting::Method::gauss, .stages = 8, .dt = tight};
  auto z = z0, exact = z0;
  double error = 0, size = 0, at = 0;
  cost.run(z, advice, [&](double t, const auto& now) {
    if (t > at) run(h, exact, t - at, reference);
    at = t;
    error = std::max(error, Eigen::VectorXd(f(now) - f(exact)).norm());
    size = std::max(size, Eigen::VectorXd(f(exact)).norm());
  });
  return {error, size};
}

/// Runs the advice for a target, and compares it with a tight run.
template <class H, class F>
void check_advice(const H& h, const PhasePoint<double, H::Dof>& z0, double T, double target, double tight,
                  const CostOptionsOf<double, H::Dof>& options, const F& f) {
  const auto cost = cost_of_accuracy(h, z0, T, options);
  const auto advice = cost.cheapest(target);
  INFO(static_cast<const CostTable&>(cost));
  REQUIRE(advice);
  CHECK_FALSE(cost.invariant);
  CHECK(cost.reference_error < target);
  const auto [error, size] = compared(cost, *advice, h, z0, tight, f);
  CHECK(error / size <= 3 * target);
  // Half the accuracy for nothing: the advice is not much better than asked for, either.
  // Nor is it much better than asked for; a steep order makes much of a step.
  CHECK(error / size >= target / 200);
}

Eigen::VectorXd all(const auto& z) { return z.vector(); }

/// A spring that pulls a mass which grows with the distance, in units of one's own.
struct VaryingMass {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length = 1, momentum = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    const double x = q[0] / length, y = p[0] / momentum;
    return length * momentum * (y * y / (1 + x * x) + x * x) / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double x = q[0] / length, velocity = p[0] / momentum / (1 + x * x);
    dHdq[0] = momentum * (x - velocity * velocity * x);
    dHdp[0] = length * velocity;
  }
};

}  // namespace

TEST_CASE("advice on the position of a planet over a hundred orbits is right, and takes explicit splitting",
          "[long]") {
  check_advice(Kepler(), planet, 628, 1e-5, 0.02, {.observable = observables::Positions{}, .targets = {1e-5}},
               [](const auto& z) { return z.q(); });
  const auto cost =
      cost_of_accuracy(Kepler(), planet, 628.0, {.observable = observables::Positions{}, .targets = {1e-5}});
  CHECK(cost.cheapest(1e-5)->setting.method == Setting::Method::splitting);
  CHECK(cost.cheapest(1e-5)->limit == LimitedBy::growth);
}

TEST_CASE("advice on a trajectory whose phase error grows over ten times the trials is right") {
  check_advice(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 300, 1e-5, 0.02,
               {.observable = observables::Trajectory{}, .targets = {1e-5}},
               [](const auto& z) { return all(z); });
}

TEST_CASE("growth of an error that its oscillation hides in a trial is not left out") {
  const auto momentum = [](const auto&, const auto& p) { return p[0]; };
  check_advice(VaryingMass(), PhasePoint<double, 1>(2, 0), 2000, 1e-8, 0.05,
               // Gauss's method with eight stages costs the same, and would be far better than asked for.
               {.observable = momentum, .targets = {1e-4, 1e-6, 1e-8, 1e-10}, .gauss_stages = {}},
               [](const auto& z) { return z.p(); });
}

TEST_CASE("advice does not depend on the units of positions and momenta", "[long]") {
  const auto position = [](const auto& q, const auto&) { return q[0]; };
  const auto product = [](const auto& q, const auto& p) { return q[0] * p[0]; };
  for (const double target : {1e-4, 1e-6})
    for (const auto& [length, momentum] : {std::pair(1e11, 1e4), {1e-10, 1e-24}, {1e-10, 1.0}, {1e7, 1.0}}) {
      CAPTURE(target, length, momentum);
      const VaryingMass h{length, momentum};
      const PhasePoint<double, 1> z0(2 * length, 0);
      check_advice(h, z0, 500, target, 0.05, {.observable = position}, [](const auto& z) { return z.q(); });
      check_advice(h, z0, 500, target, 0.05, {.observable = product},
                   [](const auto& z) { return z.q().cwiseProduct(z.p()); });
    }
}

TEST_CASE("advice on the paths of vortices is right") {
  const systems::PointVortices<double, 4> vortices(Eigen::Vector4d(1, -0.5, 0.7, 0.4));
  const auto z0 = vortices.phase_point(Eigen::Vector4d(0, 1, 5, 5), Eigen::Vector4d(0, 0, 0, 1));
  check_advice(vortices, z0, 500, 1e-6, 0.25, {.observable = observables::Trajectory{}, .targets = {1e-6}},
               [](const auto& z) { return all(z); });
}

TEST_CASE(
    "the trajectory of a chaotic system is refused with the rate at which orbits part, its energy is not") {
  const PhasePoint<double, 2> z0({1.8, 2.2}, {0, 0});
  const auto path = cost_of_accuracy(DoublePendulum(), z0, 1000.0,
                                     {.observable = observables::Trajectory{}, .targets = {1e-4}});
  CHECK_FALSE(path.cheapest(1e-4));
  CHECK(path.reach(1e-4) == Reach::orbits_part);
  CHECK(path.parting_rate > 0.1);
  CHECK(path.horizon < 300);
  CHECK(path.why(1e-4).find("nothing of the trajectory is left") != std::string::npos);
  CHECK(cost_of_accuracy(DoublePendulum(), z0, 1000.0, {.targets = {1e-4}}).cheapest(1e-4));
}

TEST_CASE("an observable is a lambda of any arguments, its result a number or a column") {
  const systems::Product<double> product;
  const PhasePoint<double, 1> z0(-3, 0);
  const auto advised = [&](const auto& cost) {
    const auto advice = cost.cheapest(1e-4);
    REQUIRE(advice);
    PhasePoint<double, 1> z = z0;
    CHECK(cost.run(z, *advice).ok());
    return advice->setting.dt;
  };
  const double dt = advised(
      cost_of_accuracy(product, z0, 10, {.observable = observables::Coordinate{0}, .targets = {1e-4}}));
  const auto generic = [](const auto& q, const auto&) { return q[0]; };
  CHECK(advised(cost_of_accuracy(product, z0, 10, {.observable = generic, .targets = {1e-4}})) == dt);
  const auto typed = [](In<double, 1> q, In<double, 1>) { return q[0]; };
  CHECK(advised(cost_of_accuracy(product, z0, 10, {.observable = typed, .targets = {1e-4}})) == dt);
  const auto column = [](const auto& q, const auto&) { return Eigen::VectorXd(q); };
  CHECK(advised(cost_of_accuracy(product, z0, 10, {.observable = column, .targets = {1e-4}})) == dt);
  CostOptions kept{.targets = {1e-4}};
  kept.observable = generic;
  CHECK(advised(cost_of_accuracy(product, z0, 10, kept)) == dt);
  CHECK_THROWS_AS(cost_of_accuracy(product, z0, 10, {.observable = observables::Coordinate{2}}),
                  std::out_of_range);
}

TEST_CASE(
    "an observable that the motion keeps is judged as an invariant, by the distance from its first value") {
  const systems::NlsLattice<double, 5> lattice;
  const PhasePoint<double, 5> z0({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  const auto cost = cost_of_accuracy(
      lattice, z0, 20,
      {.observable = [&](const auto& q, const auto& p) { return lattice.energy(q, p); }, .targets = {1e-6}});
  CHECK(cost.invariant);
  CHECK(cost.unit == Approx(std::abs(lattice.energy(z0.q(), z0.p()))));
  CHECK(cost.reach(1e-6) == Reach::met);
}

TEST_CASE("errors are relative to the largest value of the observable, or absolute by request") {
  const systems::Product<double> product;
  const PhasePoint<double, 1> z0(-3, 0);
  const auto one = [](const auto& q, const auto&) { return q[0]; };
  const auto hundred = [](const auto& q, const auto&) { return 100 * q[0]; };
  const auto calls = [&](const auto& cost) { return cost.cheapest(1e-3)->gradients; };
  CHECK(calls(cost_of_accuracy(product, z0, 20, {.observable = hundred, .targets = {1e-3}})) ==
        Approx(calls(cost_of_accuracy(product, z0, 20, {.observable = one, .targets = {1e-3}}))));
  // Of one scheme: with more to choose from, a tighter target may happen to find something better.
  const auto of_one_scheme = [&](const auto& f) {
    return calls(cost_of_accuracy(product, z0, 20,
                                  {.observable = f,
                                   .targets = {1e-3},
                                   .absolute = true,
                                   .schemes = {"low_defect6_s13"},
                                   .gauss_stages = {}}));
  };
  CHECK(of_one_scheme(hundred) > of_one_scheme(one));
}

TEST_CASE("in a run of a few steps no error and no size goes unseen") {
  const systems::Product<double> product;
  const auto q0 = [](const auto& q, const auto&) { return q[0]; };
  const auto p0 = [](const auto&, const auto& p) { return p[0]; };
  int advices = 0;
  const auto check = [&](const PhasePoint<double, 1>& z0, double T, const auto& f, double target) {
    CAPTURE(z0.q()[0], T, target);
    const auto cost = cost_of_accuracy(product, z0, T, {.observable = f, .targets = {target}});
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    CHECK(advice->tried == T);
    auto z = z0, exact = z0;
    GaussLegendre fine(product, {.stages = 8});
    double before = 0, worst = 0, size = 0;
    cost.run(z, *advice, [&](double t, const auto& now) {
      const int steps = static_cast<int>(std::ceil((t - before) / 0.01));
      for (int n = 0; n < steps; ++n) {
        REQUIRE(fine.step(exact, (t - before) / steps).ok());
        size = std::max(size, std::abs(f(exact.q(), exact.p())));
      }
      before = t;
      size = std::max(size, std::abs(f(exact.q(), exact.p())));
      worst = std::max(worst, std::abs(f(now.q(), now.p()) - f(exact.q(), exact.p())));
    });
    CHECK(cost.unit == Approx(size).epsilon(0.05));
    CHECK(worst < 1.1 * target * size);
    ++advices;
  };
  check({0.368868, 0.0207956}, 1.36088, p0, 1e-8);
  check({0.3, 0}, 1.5, q0, 1e-10);
  for (const double T : {0.4, 1.0, 1.5}) check({0.1, 0}, T, q0, 1e-6);
  for (const double T : {0.4, 1.0, 3.0}) check({3, 0}, T, q0, 1e-8);
  CHECK(advices == 8);
}

TEST_CASE("a trajectory is that of the system, without the time it is driven by", "[long]") {
  const Autonomous pendulum(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 - cos(q[0]) * (1 + 0.1 * cos(0.3 * t));
  }));
  const auto start = pendulum.extended({0.5, 0}, 1e6);
  const auto both = [](const auto& q, const auto& p) { return Eigen::Vector2d(q[0], p[0]); };
  const auto by_hand = cost_of_accuracy(pendulum, start, 100, {.observable = both, .targets = {1e-6}});
  const auto by_name =
      cost_of_accuracy(pendulum, start, 100, {.observable = observables::Trajectory{}, .targets = {1e-6}});
  const auto one = by_hand.cheapest(1e-6), other = by_name.cheapest(1e-6);
  REQUIRE((one && other));
  CHECK(other->setting.dt == one->setting.dt);
  const auto positions =
      cost_of_accuracy(pendulum, start, 100, {.observable = observables::Positions{}, .targets = {1e-6}})
          .cheapest(1e-6);
  REQUIRE(positions);
  auto z = start, better = start;
  by_hand.run(z, *positions);
  GaussLegendre gauss(pendulum, {.stages = 8});
  integrate(gauss, better, {.dt = 0.05, .t_end = 100});
  CHECK(std::abs(z.q()[0] - better.q()[0]) < 3e-6 * 0.5);
}

TEST_CASE("advice for times of a step or two is right, also where they end in a hard place", "[long]") {
  int advices = 0;
  for (const double e : {0.5, 0.7, 0.9}) {
    const PhasePoint<double, 2> apocentre({-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))});
    const auto x = [&](double t) {
      const double mean = std::acos(-1.0) + t;
      double anomaly = mean;
      for (int i = 0; i < 300; ++i)
        anomaly -= (anomaly - e * std::sin(anomaly) - mean) / (1 - e * std::cos(anomaly));
      return std::cos(anomaly) - e;
    };
    for (const double T : {1.0, 3.2, 6.3})
      for (const double target : {1e-2, 1e-4, 1e-8}) {
        CAPTURE(e, T, target);
        const auto cost = cost_of_accuracy(Kepler(), apocentre, T,
                                           {.observable = observables::Coordinate{0}, .targets = {target}});
        const auto advice = cost.cheapest(target);
        if (!advice) continue;
        ++advices;
        CHECK(advice->setting.dt <= T);
        auto z = apocentre;
        double worst = 0, unit = 0;
        const auto run = cost.run(z, *advice, [&](double t, const auto& now) {
          worst = std::max(worst, std::abs(now.q()[0] - x(t)));
          unit = std::max(unit, std::abs(x(t)));
        });
        CHECK(worst < 1.05 * target * unit);
        CHECK(advice->gradients > 0.5 * static_cast<double>(run.gradients));
      }
  }
  CHECK(advices > 24);
}

TEST_CASE("advice is right for runs no longer than the time scale of their start", "[long]") {
  const auto q0 = [](const auto& q, const auto&) { return q[0]; };
  int advices = 0;
  const auto check = [&](const auto& h, const auto& start, double T) {
    auto exact = start;
    GaussLegendre fine(h, {.stages = 8});
    integrate(fine, exact, {.dt = 0.005, .t_end = T});
    for (const double target : {1e-3, 1e-6, 1e-8}) {
      CAPTURE(T, target);
      const auto cost = cost_of_accuracy(h, start, T, {.observable = q0, .targets = {target}});
      const auto advice = cost.cheapest(target);
      REQUIRE(advice);
      ++advices;
      auto z = start;
      double largest = std::abs(start.q()[0]);
      cost.run(z, *advice,
               [&](double, const auto& now) { largest = std::max(largest, std::abs(now.q()[0])); });
      CHECK(std::abs(z.q()[0] - exact.q()[0]) < 3 * target * largest);
    }
  };
  const auto pendulum = from_energy<1>([](const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 - cos(q[0]);
  });
  for (const double T : {1.8, 2.0, 3.6}) check(pendulum, PhasePoint<double, 1>(1, T < 1.9 ? 5.3 : 4.0), T);
  const auto hill = from_energy<1>([](const auto& q, const auto& p) {
    using std::exp;
    return p[0] * p[0] / 2 + 0.1 * exp(-q[0] * q[0]);
  });
  for (const double way : {5.0, 20.0}) check(hill, PhasePoint<double, 1>(-way, 1), 2 * way + 2);
  for (const double way : {5.0, 20.0})
    check(Kepler(), PhasePoint<double, 2>({-way, 1}, {1.5, 0}), 2 * way / 1.5);
  CHECK(advices == 21);
}

TEST_CASE("a vector that changes its size is refused as an observable") {
  const auto growing = [](const auto& q, const auto&) {
    return Eigen::VectorXd(Eigen::VectorXd::Ones(q[0] < 0.4 ? 1 : 2));
  };
  CHECK(refuses([&] { cost_of_accuracy(Kepler(), planet, 10, {.observable = growing}); },
                "options.observable gives a vector of 1 numbers, and of 2 at z0"));
}

TEST_CASE("a search for an observable keeps its bound on gradient calls") {
  for (const double bound : {1e3, 1e4, 1e5, 1e6}) {
    const auto cost = cost_of_accuracy(
        systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 1e6,
        {.observable = observables::Trajectory{}, .targets = {1e-4, 1e-9}, .max_gradients = bound});
    CHECK(cost.spent_gradients <= bound);
    std::ostringstream text;
    text << static_cast<const CostTable&>(cost);
    CHECK(text.str().find("Spent: ") != std::string::npos);
  }
}

TEST_CASE("a coordinate that winds for long takes the tight targets of the energy away", "[long]") {
  const auto rotor = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) {
        return p[0] * p[0] / 2 * (1 + 0.3 * std::cos(q[0])) + 1 - std::cos(q[0]);
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = -0.15 * p[0] * p[0] * std::sin(q[0]) + std::sin(q[0]);
        dHdp[0] = p[0] * (1 + 0.3 * std::cos(q[0]));
      });
  const auto cost = cost_of_accuracy(rotor, PhasePoint<double, 1>(0, 3), 1e6, {.targets = {1e-6, 1e-10}});
  CHECK(cost.reach(1e-6) == Reach::met);
  CHECK(cost.reach(1e-10) == Reach::rounding);
}

TEST_CASE("a start near the origin says nothing of the time scale") {
  const auto pendulum = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) {
        return p[0] * p[0] / 2 * (1 + 0.1 * q[0] * q[0]) + 1 - std::cos(q[0]) - 0.5 * q[0];
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 0.1 * p[0] * p[0] * q[0] + std::sin(q[0]) - 0.5;
        dHdp[0] = p[0] * (1 + 0.1 * q[0] * q[0]);
      });
  const auto cost =
      cost_of_accuracy(pendulum, PhasePoint<double, 1>(1e-9, 0), 100, {.targets = {1e-6}, .absolute = true});
  CHECK(cost.time_scale > 0.1);
  CHECK(cost.reach(1e-6) == Reach::met);
}

namespace {

/// Two atoms on a bond of that stiffness in a field: the distance of both and the angle.
auto molecule(double stiffness) {
  return from_energy<2>([stiffness](const auto& q, const auto& p) {
    using std::cos;
    const auto stretch = q[0] - 1;
    return p[0] * p[0] / 2 + p[1] * p[1] / (2 * q[0] * q[0]) + stiffness / 2 * stretch * stretch -
           0.3 * q[0] * cos(q[1]);
  });
}
/// A slow oscillator with a weakly coupled fast one.
auto slow_and_fast(double frequency, double quartic, double coupling) {
  return from_energy<2>([=](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1] * (1 + coupling * q[0] * q[0])) / 2 + q[0] * q[0] / 2 +
           quartic * q[0] * q[0] * q[0] * q[0] + frequency * frequency / 2 * q[1] * q[1] * (1 + 0.3 * q[0]);
  });
}

}  // namespace

TEST_CASE("advice holds to the end where a bond nearly at rest makes large steps unstable late", "[long]") {
  for (const double stiffness : {1e4, 2e3, 1e3}) {
    CAPTURE(stiffness);
    const auto h = molecule(stiffness);
    const PhasePoint<double, 2> start({1 + 1e-6, 0.8}, {0, 0});
    const auto cost = cost_of_accuracy(
        h, start, 100.0, {.observable = [](const auto& q, const auto&) { return q[1]; }, .targets = {1e-3}});
    const auto advice = cost.cheapest(1e-3);
    REQUIRE(advice);
    auto z = start, exact = start;
    Invariants energy(h);
    cost.run(z, *advice, energy);
    CHECK(energy["energy"].worst < 1);
    GaussLegendre gauss(h, {.stages = 8});
    integrate(gauss, exact, {.dt = 0.01, .t_end = 100});
    CHECK(std::abs(z.q()[1] - exact.q()[1]) < 3e-3);
  }
}

TEST_CASE("a projection that hardly converges is no advice") {
  for (const double frequency : {20.0, 100.0}) {
    CAPTURE(frequency);
    const auto h = slow_and_fast(frequency, 0.1, 0);
    PhasePoint<double, 2> z({1, 1e-5}, {0, 0});
    const auto cost = cost_of_accuracy(h, z, 200.0, {.targets = {1e-3}});
    const auto advice = cost.cheapest(1e-3);
    REQUIRE(advice);
    CHECK(advice->gradients < 1000 * frequency);
    Invariants energy(h);
    cost.run(z, *advice, energy);
    CHECK(energy["energy"].worst < 3e-3);
  }
}

TEST_CASE("what large steps of the reference miss of a fast oscillation is not taken for rounding") {
  const auto slow = [](const auto& q, const auto&) { return q[0]; };
  const auto measured = [](const auto& z) { return Eigen::VectorXd::Constant(1, z.q()[0]); };
  for (const double target : {1e-7, 1e-9}) {
    CAPTURE(target);
    check_advice(slow_and_fast(10, 0, 0.1), PhasePoint<double, 2>({1, 0.01}, {0, 0.1}), 100, target, 0.02,
                 {.observable = slow, .targets = {target}}, measured);
  }
}

TEST_CASE("advice on a chaotic trajectory is of runs to the end, also beside targets that nothing meets") {
  const auto chain = from_energy<3>([](const auto& q, const auto& p) {
    auto sum = 0 * q[0];
    for (int i = 0; i < 3; ++i) {
      const auto square = q[i] * q[i] + p[i] * p[i];
      sum += square * square / 4;
      if (i > 0) sum -= 0.19117877957528701 * (q[i] * q[i - 1] + p[i] * p[i - 1]);
    }
    return sum;
  });
  const PhasePoint<double, 3> start({-0.52682063355697495, 0.63294052494930098, 0.053482975887533965},
                                    {-0.032654790160515354, 0.51990710687178165, -0.6849279928561044});
  check_advice(chain, start, 316.79561565489439, 2.6e-3, 0.1,
               {.observable = [](const auto& q, const auto&) { return 3 + q[0]; },
                .targets = {1e-2, 2.6e-3, 7e-10, 4e-11}},
               [](const auto& z) { return Eigen::VectorXd::Constant(1, 3 + z.q()[0]); });
}

TEST_CASE("the end of the first step counts where an observable is the largest at the start", "[long]") {
  // A flyby from its periapsis on, in a frame that turns.
  constexpr double near = 0.5, speed = 2.5;
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]) -
           (q[0] * p[1] - q[1] * p[0]);
  });
  const auto distance = [](double t) {  // by Kepler's equation, e sinh F - F = M
    const double e = near * speed * speed - 1, a = near / (e - 1), M = t / std::sqrt(a * a * a);
    double F = std::asinh(M / e);
    for (int i = 0; i < 60; ++i) F -= (e * std::sinh(F) - F - M) / (e * std::cosh(F) - 1);
    return a * (e * std::cosh(F) - 1);
  };
  const PhasePoint<double, 2> start({near, 0}, {0, speed});
  const auto [T, target] = GENERATE(std::pair(500.0, 1e-8), std::pair(200.0, 1e-6), std::pair(50.0, 1e-6));
  CAPTURE(T, target);
  const auto force = [](const auto& q, const auto&) { return 1 / q.squaredNorm(); };
  const auto cost = cost_of_accuracy(h, start, T, {.observable = force, .targets = {target}});
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  double off = 0;
  auto z = start;
  cost.run(z, *advice, [&](double t, const auto& state) {
    const double r = distance(t);
    off = std::max(off, std::abs(1 / state.q().squaredNorm() - 1 / (r * r)));
  });
  CHECK(off / cost.unit < 2 * target);
}

TEST_CASE("the beginning of a long run is seen as closely as the rest", "[long]") {
  // A rotor whose inertia changes with its angle: it winds, and the observable is the largest at the start.
  const auto h = from_energy<1>([](const auto& q, const auto& p) {
    return p[0] * p[0] / (2 * (1 + 0.7 * cos(q[0]))) - 1.5 * cos(q[0]);
  });
  const PhasePoint<double, 1> start(2.5, 5);
  const auto f = [](const auto& q, const auto&) { return 1 / (1 + q[0] * q[0]); };
  const double T = 30, target = 1e-6;
  const auto cost = cost_of_accuracy(h, start, T, {.observable = f, .targets = {target}, .whole = true});
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  double off = 0, now = 0;
  auto z = start, right = start;
  GaussLegendre tight(h, {.stages = 8});
  cost.run(z, *advice, [&](double t, const auto& state) {
    if (t > now) REQUIRE(integrate(tight, right, {.dt = (t - now) / 4, .steps = 4}).ok());
    now = t;
    off = std::max(off, std::abs(f(state.q(), 0) - f(right.q(), 0)));
  });
  CHECK(off / cost.unit < 2 * target);
}

TEST_CASE("what is advised as a run of the whole was compared to the end") {
  // With few calls the first race comes to nearly T, where the observable is the largest: it goes to T then.
  const auto h = from_energy<3>([](const auto& q, const auto& p) {
    return (q[0] * q[0] + p[0] * p[0] + 1.19 * (q[1] * q[1] + p[1] * p[1]) +
            1.464 * (q[2] * q[2] + p[2] * p[2])) /
           2;
  });
  const PhasePoint<double, 3> start({-0.4, -0.8, 0.68}, {-0.93, -0.42, -0.81});
  const auto f = [](const auto& q, const auto&) { return std::exp(6.3 * (q[0] + q[1] + q[2])); };
  const double T = 29.47, target = 0.065;
  for (const double calls : {39500.0, 40500.0, 41500.0, 43500.0, 1e7}) {
    const auto cost = cost_of_accuracy(
        h, start, T, {.observable = f, .targets = {target}, .max_gradients = calls, .whole = true});
    const auto advice = cost.cheapest(target);
    CAPTURE(calls);
    REQUIRE(advice);
    CHECK(advice->tried == T);
  }
}

TEST_CASE("a step to the end of what was constant at first is no run of the whole") {
  // A pendulum that turns over, and passes there once: before, nothing is to be seen.
  const auto h = from_energy<1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 - cos(q[0]); });
  const PhasePoint<double, 1> start(0, 3);
  for (const double place : {2e3, 2e4}) {
    const auto passed = [place](const auto& q, const auto&) { return (1 + std::tanh(q[0] - place)) / 2; };
    const double T = 0.5 * place, target = 1e-3;
    for (const bool whole : {false, true}) {
      const auto cost = cost_of_accuracy(h, start, T,
                                         {.observable = passed,
                                          .targets = {target},
                                          .min_gradients = 1e5,
                                          .max_gradients = 1e6,
                                          .whole = whole});
      CAPTURE(place, whole);
      for (const CostRow& row : cost.rows) CHECK((row.tried < T || row.setting.dt < T / 100));
      if (const auto advice = cost.cheapest(target)) {
        auto z = start;
        cost.run(z, *advice);
        CHECK(std::abs(passed(z.q(), z.p()) - 1) < target);
      }
    }
  }
}

TEST_CASE("a bump that is narrower than the reference's steps is compared") {
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return (p[0] * p[0] * (1 + 0.2 * q[0] * q[0]) + q[0] * q[0] + 1.3 * (p[1] * p[1] + q[1] * q[1])) / 2 +
           0.1 * q[0] * q[0] * q[1];
  });
  const PhasePoint<double, 2> start({0.8, -0.3}, {0.1, 0.6});
  const Setting tight{.method = Setting::Method::gauss, .stages = 8, .dt = 0.1};
  const double T = 25, target = 1e-3;
  for (const int k : {13, 15, 20}) {
    auto centre = start;
    run(h, centre, 0.3 + k * T / 41, tight);
    const auto f = [=](const auto& q, const auto& p) {
      return 1 + std::exp(-200 * ((q - centre.q()).squaredNorm() + (p - centre.p()).squaredNorm()));
    };
    const auto cost = cost_of_accuracy(
        h, start, T, {.observable = f, .targets = {target}, .max_gradients = 2e5, .whole = true});
    const auto advice = cost.cheapest(target);
    REQUIRE(advice);
    const auto [off, size] = compared(cost, *advice, h, start, 0.1,
                                      [&](const auto& z) { return Vector<double, 1>(f(z.q(), z.p())); });
    CAPTURE(k);
    CHECK(off / 2 < target);  // of 2 at the peak
  }
}

TEST_CASE("what was given up for a tight target is no advice for a loose one") {
  // Past a centre once, and late: large steps show nothing until they come there.
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  const PhasePoint<double, 2> start({-6, 0.2}, {1, 0});
  const auto cost = cost_of_accuracy(h, start, 8.0, {.targets = {1e-3, 1e-8}, .reversible = false});
  int asked = 0;
  for (const double target : {1e-3, 1e-4, 1e-5, 1e-8}) {
    const auto advice = cost.cheapest(target);
    if (!advice || advice->tried < 8) continue;
    ++asked;
    CAPTURE(target, advice->setting.name(), advice->setting.dt);
    auto z = start;
    Invariants energy(h);
    CHECK_NOTHROW(run(h, z, 8.0, advice->setting, energy));
    CHECK(energy["energy"].worst <= 3 * target);
  }
  CHECK(asked >= 2);
}

TEST_CASE("an invariant that is zero, as a sum of large terms, is met") {
  // Three bodies about their centre of mass: their momentum.
  const auto h = from_energy<6>([](const auto& q, const auto& p) {
    const auto apart = [&](int i, int j) {
      return sqrt((q[2 * i] - q[2 * j]) * (q[2 * i] - q[2 * j]) +
                  (q[2 * i + 1] - q[2 * j + 1]) * (q[2 * i + 1] - q[2 * j + 1]));
    };
    return (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3] + p[4] * p[4] + p[5] * p[5]) / 2 -
           1 / apart(0, 1) - 1 / apart(0, 2) - 1 / apart(1, 2);
  });
  const PhasePoint<double, 6> start({1, 0, -0.5, 0.9, -0.5, -0.9}, {0, 0.8, -0.7, -0.4, 0.7, -0.4});
  const auto momentum = [](const auto&, const auto& p) { return p[0] + p[2] + p[4]; };
  const auto cost = cost_of_accuracy(h, start, 20.0, {.observable = momentum, .targets = {1e-9}});
  CHECK(cost.cheapest(1e-9));
  CHECK(cost.spent_gradients < 2e6);
}

TEST_CASE("a small motion far from the origin is no invariant") {
  // q - X = x0 cos t.
  for (const double far : {1e6, 1e9}) {
    CAPTURE(far);
    const auto h = from_energy<1>(
        [far](const auto& q, const auto& p) { return (p[0] * p[0] + (q[0] - far) * (q[0] - far)) / 2; });
    const PhasePoint<double, 1> start(far * (1 + 4e-12), 0);
    const double x0 = start.q()[0] - far;
    const auto square = [far](const auto& q, const auto&) { return (q[0] - far) * (q[0] - far); };
    const auto cost = cost_of_accuracy(h, start, 20.0, {.observable = square, .targets = {1e-2}});
    CHECK(cost.relative);
    CHECK_FALSE(cost.invariant);
    const auto row = cost.cheapest(1e-2);
    REQUIRE(row);
    auto z = start;
    double worst = 0;
    cost.run(z, *row, [&](double t, const auto& at) {
      worst = std::max(worst, std::abs(std::pow((at.q()[0] - far) / x0, 2) - std::pow(std::cos(t), 2)));
    });
    CHECK(worst < 3e-2);
  }
}

TEST_CASE("absolute targets may be in any unit") {
  const PhasePoint<double, 2> start = planet;
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  for (const double unit : {1.0, 1e12, 1e-12}) {
    CAPTURE(unit);
    const auto place = [unit](const auto& q, const auto&) { return q[0] / unit; };
    const auto cost = cost_of_accuracy(
        h, start, 60.0, {.observable = place, .targets = {1e-4 / unit, 1e-30 / unit}, .absolute = true});
    CHECK(cost.cheapest(1e-4 / unit));
    CHECK_FALSE(cost.cheapest(1e-30 / unit));
  }
}

TEST_CASE("a reversible setting refuses a state of another size") {
  const systems::NlsLattice<double> h(5);
  for (const Eigen::Index size : {4, 6}) {
    PhasePoint<double, Eigen::Dynamic> z(size);
    z.q().setConstant(1);
    const Setting setting{.scheme = "low_defect4_s7",
                          .dt = 0.5,
                          .reversible = true,
                          .pace = {.length = 1, .momentum = 1, .longest = 0.1}};
    CHECK_THROWS_WITH(run(h, z, 1.0, setting), Catch::Contains("size"));
  }
}

TEST_CASE("a setting runs beside events that change the state, by equal steps") {
  const systems::Product<double> h;
  PhasePoint<double, 1> z(-3, 0);
  int bounces = 0;
  auto wall = events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                                 [&](double, PhasePoint<double, 1>& at) { at.p()[0] *= -1, ++bounces; }));
  Setting setting{.scheme = "low_defect6_s13", .dt = 0.02};
  CHECK(run(h, z, 3.0, setting, wall).ok());
  CHECK(bounces > 1);
  setting.reversible = true;
  CHECK_THROWS_WITH(run(h, z, 3.0, setting, wall), Catch::Contains("need equal steps"));
}

}  // namespace test_observables
