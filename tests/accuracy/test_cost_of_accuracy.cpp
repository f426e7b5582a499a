// The advice is judged by gradient calls: they are the same on every machine.
#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>

#include <semiexplicit/accuracy/cost_of_accuracy.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/steppers/gauss_legendre.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/product.hpp>
#include <semiexplicit/time/autonomous.hpp>

#include "catch.hpp"
#include "kepler.hpp"
#include "oscillator.hpp"

namespace test_cost_of_accuracy {

using namespace semiexplicit;

namespace {

using Lattice = systems::NlsLattice<double, 5>;

/// What a whole run with a setting gives.
struct Outcome {
  double error, gradients;
};

template <class H>
Outcome whole_run(const H& hamiltonian, PhasePoint<double, H::Dof> z, double T, const Setting& setting) {
  Invariants invariants(hamiltonian);
  const IntegrationReport report = run(hamiltonian, z, T, setting, invariants);
  return {invariants["energy"].worst, static_cast<double>(report.gradients)};
}

/// The gradient calls of the cheapest run to a target, over every candidate and steps a factor 1.25 apart.
template <class H>
double least_gradients(const H& hamiltonian, const PhasePoint<double, H::Dof>& z0, double T, double target,
                       double largest_step) {
  const CostOptions options;
  std::vector<Setting> settings;
  for (const std::string& scheme : options.schemes) settings.push_back({.scheme = scheme});
  for (const std::string& scheme : options.schemes)
    settings.push_back({.method = Setting::Method::midpoint, .scheme = scheme});
  for (const int stages : options.gauss_stages)
    settings.push_back({.method = Setting::Method::gauss, .stages = stages});
  double least = std::numeric_limits<double>::infinity();
  for (Setting setting : settings)
    for (setting.dt = largest_step; setting.dt > largest_step / 60; setting.dt /= 1.25) {
      try {
        const Outcome outcome = whole_run(hamiltonian, z0, T, setting);
        if (!(outcome.error <= target)) continue;
        least = std::min(least, outcome.gradients);
        break;
      } catch (const IntegrationError&) {
      }
    }
  return least;
}

/// Checks the advice for a target against whole runs.
template <class H>
void check_advice(const H& hamiltonian, const PhasePoint<double, H::Dof>& z0, double T, double target,
                  double largest_step) {
  const PhasePoint<double, H::Dof> before = z0;
  const CostTable cost = cost_of_accuracy(hamiltonian, z0, T, {.targets = {target}});
  CHECK(z0.vector() == before.vector());
  const auto advice = cost.cheapest(target);
  REQUIRE(advice);
  INFO("target " << target << ": " << *advice);
  const Outcome outcome = whole_run(hamiltonian, z0, T, advice->setting);
  CHECK(advice->error <= target);
  CHECK(outcome.error <= 3 * target);
  CHECK(outcome.gradients <= 1.5 * least_gradients(hamiltonian, z0, T, target, largest_step));
  CHECK(outcome.gradients == Approx(advice->gradients).epsilon(0.3));
}

PhasePoint<double, 5> lattice_start() { return {{3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}}; }

std::string refusal(const auto& call) {
  try {
    call();
  } catch (const std::invalid_argument& error) {
    return error.what();
  }
  return "not refused";
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

/// H = ((q - X)² + p²)/2.
template <class Scalar>
auto oscillator_about(const Scalar& X) {
  return make_hamiltonian<Scalar, 1>(
      [=](const auto& q, const auto& p) { return ((q[0] - X) * (q[0] - X) + p[0] * p[0]) / 2; },
      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0] - X;
        dHdp[0] = p[0];
      });
}

}  // namespace

TEST_CASE("the advised setting meets the target and is near the cheapest there is", "[long]") {
  check_advice(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 300, 1e-4, 0.6);
  check_advice(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 300, 1e-8, 0.6);
  check_advice(Lattice(), lattice_start(), 30, 1e-6, 0.12);
}

TEST_CASE("the same again gives the same advice") {
  const auto advice = [] {
    return cost_of_accuracy(Lattice(), lattice_start(), 100, {.targets = {1e-6}}).cheapest(1e-6).value();
  };
  const CostRow first = advice(), second = advice();
  CHECK(first.setting.name() == second.setting.name());
  CHECK(first.setting.dt == second.setting.dt);
  CHECK(first.error == second.error);
}

TEST_CASE("what the advice costs stays near its budget") {
  const Lattice lattice;
  for (const double budget : {0.05, 0.2}) {
    const CostTable cost = cost_of_accuracy(lattice, lattice_start(), 3000,
                                            {.targets = {1e-8}, .budget = budget, .min_gradients = 1e4});
    const auto advice = cost.cheapest(1e-8);
    REQUIRE(advice);
    CHECK(cost.spent_gradients > 0);
    CHECK(cost.fraction_of(*advice) == Approx(cost.spent_gradients / advice->gradients));
    CHECK(cost.fraction_of(*advice) < 2 * budget);
  }
}

TEST_CASE("a tighter target costs more, from one scan") {
  const CostTable cost = cost_of_accuracy(Lattice(), lattice_start(), 100);
  double last = 0;
  for (const double target : {1e-3, 1e-4, 1e-6, 3e-8, 1e-9, 1e-10}) {
    const auto row = cost.cheapest(target);
    REQUIRE(row);
    CHECK(row->error <= target);
    CHECK(row->gradients >= last);
    last = row->gradients;
  }
}

TEST_CASE("advice for a tighter target is advice for a looser one that was tried farther") {
  CostTable cost;
  cost.by = CostBy::gradients;
  cost.time = 1;
  cost.targets = {1e-3, 1e-6};
  cost.tried_for = {0.5, 0.01};
  cost.rows = {{.error = 1e-5, .gradients = 100, .tried = 0.5, .harder = 1},
               {.error = 1e-7, .gradients = 10, .tried = 0.01, .harder = 1},
               {.error = 1e-5, .gradients = 1, .tried = 0.01, .harder = 1}};  // not tried far enough for that
  REQUIRE(cost.cheapest(1e-3));
  CHECK(cost.cheapest(1e-3)->gradients == 10);
  CHECK(cost.cheapest(1e-6)->gradients == 10);
}

TEST_CASE("an accuracy out of reach is said to be so") {
  const CostTable cost =
      cost_of_accuracy(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 1000, {.targets = {1e-18}});
  CHECK_FALSE(cost.cheapest(1e-18));
  REQUIRE(cost.best());
  CHECK(cost.best()->error > 1e-18);
  std::ostringstream text;
  text << cost;
  CHECK(contains(text.str(), "out of reach"));
}

TEST_CASE("of wide numbers the times are as wide as the states") {
  const PhasePoint<long double, 1> z0(1, 0);
  const auto cost = cost_of_accuracy(OscillatorOf<long double>(), z0, 200,
                                     {.observable = observables::Coordinate{0}, .targets = {1e-16}});
  const auto advice = cost.cheapest(1e-16);
  REQUIRE(advice);
  auto z = z0;
  long double worst = 0;
  cost.run(z, *advice, [&](const long double& t, const auto& now) {
    worst = std::max(worst, std::abs(now.q()[0] - std::cos(t)));
  });
  CHECK(worst < 3e-16L);
}

TEST_CASE("a row of either method runs") {
  const systems::Product<double> product;
  for (const Setting& setting : {Setting{.scheme = "low_defect6_s13", .dt = 0.03},
                                 Setting{.method = Setting::Method::gauss, .stages = 4, .dt = 0.03}}) {
    PhasePoint<double, 1> z(-3, 0);
    const IntegrationReport report = run(product, z, 1, setting);
    CHECK(report.steps == 34);
    CHECK(report.t == Approx(1));
  }
  PhasePoint<double, 1> z(-3, 0);
  CHECK(run(product, z, 1, {.scheme = "strang", .dt = 0.1}).steps == 10);
  CHECK(contains(refusal([&] { run(product, z, -1, {.scheme = "strang", .dt = 0.1}); }), "T is not"));
  CHECK(contains(refusal([&] { run(product, z, 1, {.scheme = "strang"}); }), "setting.dt is not"));
  CHECK(contains(refusal([&] { run(product, z, 1, {.scheme = "no such", .dt = 0.1}); }), "no such"));
}

TEST_CASE("what no calls were left to follow is no rounding") {
  CostTable cost;
  cost.invariant = false, cost.time = 3e9, cost.rounding = 1e-8;
  CHECK(cost.reach(1e-9) == Reach::rounding);
  cost.rounding = 1e154;  // a growth that was seen over a part of the time, and extrapolated
  CHECK(cost.reach(1e-9) == Reach::budget);
  CHECK(cost.why(1e-9).find("max_gradients") != std::string::npos);
}

TEST_CASE("bad requests are refused by name") {
  const systems::Product<double> product;
  const PhasePoint<double, 1> z0(-3, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto of = [&](const PhasePoint<double, 1>& z, double T, const CostOptions& options = {}) {
    return refusal([&] { cost_of_accuracy(product, z, T, options); });
  };
  CHECK(contains(of(z0, 0), "T is not a finite positive time"));
  const auto in_floats =
      from_energy<1, float>([](const auto& q, const auto& p) { return q[0] + p[0] * p[0]; });
  for (const double T : {1e39, 1e-46}) {  // infinite and zero as floats
    CAPTURE(T);
    CHECK(contains(refusal([&] {
                     cost_of_accuracy(in_floats, PhasePoint<float, 1>(0, 1), T,
                                      {.observable = observables::Coordinate{0}});
                   }),
                   "T is not a finite positive time"));
  }
  CHECK(contains(of(z0, -1), "T is not"));
  CHECK(contains(of(z0, nan), "T is not"));
  CHECK(contains(of({nan, 0}, 1), "z0 holds NaN or Inf; give"));
  CHECK(contains(of({0, 0}, 1), "nothing moves at z0"));
  CHECK(contains(of(z0, 1, {.targets = {}}), "options.targets is empty; give"));
  CHECK(contains(of(z0, 1, {.targets = {0.0}}), "options.targets holds 0; give"));
  CHECK(contains(of(z0, 1, {.targets = {-1e-6}}), "options.targets holds"));
  CHECK(contains(of(z0, 1, {.targets = {nan}}), "options.targets holds"));
  CHECK(contains(of(z0, 1, {.budget = 0}), "options.budget"));
  CHECK(contains(of(z0, 1, {.schemes = {}, .gauss_stages = {}}), "both empty"));
  CHECK(contains(of(z0, 1, {.gauss_stages = {9}}), "options.gauss_stages holds 9"));
  CHECK(contains(of(z0, 1, {.schemes = {"yoshda6"}}), "yoshda6"));
  const CostTable nothing;
  CHECK_FALSE(nothing.cheapest(1e-6));
  CHECK(contains(refusal([&] { (void)nothing.cheapest(0); }), "target is not"));
  CHECK(contains(refusal([&] { (void)nothing.cheapest(nan); }), "target is not"));
}

TEST_CASE("of a separable Hamiltonian splittings alone are something to try") {
  const Kepler kepler;
  const PhasePoint<double, 2> z0({1, 0}, {0, 1.1});
  const CostOptions alone{.targets = {1e-6}, .schemes = {}, .gauss_stages = {}};
  const auto cost = cost_of_accuracy(kepler, z0, 100, alone);
  const auto advice = cost.cheapest(1e-6);
  REQUIRE(advice);
  CHECK(advice->setting.method == Setting::Method::splitting);
  CostOptions none = alone;
  none.splittings = {};
  CHECK(contains(refusal([&] { cost_of_accuracy(kepler, z0, 100, none); }), "both empty"));
}

namespace {

/// H = f(q, p) and a gradient of one's own, whose calls are counted.
template <class Energy, class Gradient>
auto counted(double& calls, Energy energy, Gradient gradient) {
  return make_hamiltonian<double, 1>(
      energy, [&calls, gradient](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        ++calls;
        gradient(q[0], p[0], dHdq[0], dHdp[0]);
      });
}
/// H = (q² + 1)(p² + 1)/2 + offset.
auto product_energy(double offset) {
  return
      [offset](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2 + offset; };
}
auto product_gradient(double by_q, double by_p) {
  return [=](double q, double p, double& dHdq, double& dHdp) {
    dHdq = by_q * q * (p * p + 1);
    dHdp = by_p * p * (q * q + 1);
  };
}

}  // namespace

TEST_CASE("a gradient that does not belong to the energy is refused before anything else") {
  double calls = 0;
  const auto said = [&](const PhasePoint<double, 1>& z0, double by_q, double by_p) {
    calls = 0;
    const auto wrong = counted(calls, product_energy(0), product_gradient(by_q, by_p));
    const std::string text = refusal([&] { cost_of_accuracy(wrong, z0, 1000); });
    CHECK(calls <= 21);
    CHECK(contains(text, "check_gradient"));
    return text;
  };
  CHECK(contains(said({-3, 0.5}, 1, -1), "dH/dp[0] is -5, but by the energy it is 5"));
  CHECK(contains(said({-3, 0.5}, 1, -1), "the sign is wrong"));
  // At rest one half of the gradient is zero at z0, whatever its sign.
  CHECK(contains(said({-3, 0}, -1, 1), "at z0: dH/dq[0] is 3, but by the energy it is -3"));
  CHECK(contains(said({-3, 0}, 1, -1), "near z0: dH/dp[0] is"));
  CHECK(contains(said({-3, 0}, 1.03, 1), "dH/dq[0]"));

  const auto adds = counted(calls, product_energy(0), [](double q, double p, double& dHdq, double& dHdp) {
    dHdq += q * (p * p + 1);
    dHdp += p * (q * q + 1);
  });
  CHECK(
      contains(refusal([&] { cost_of_accuracy(adds, PhasePoint<double, 1>(-3, 0.5), 100); }), "is added to"));

  // One entry of two hundred, for a few hundred energies.
  struct Chain : systems::NlsLattice<double> {
    using systems::NlsLattice<double>::NlsLattice;
    double* energies;
    double energy(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) const {
      ++*energies;
      return systems::NlsLattice<double>::energy(q, p);
    }
    void gradient(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p,
                  Out<double, Eigen::Dynamic> dHdq, Out<double, Eigen::Dynamic> dHdp) const {
      systems::NlsLattice<double>::gradient(q, p, dHdq, dHdp);
      dHdq[377] *= -1;
    }
  };
  double energies = 0;
  Chain chain(500);
  chain.energies = &energies;
  PhasePoint<double, Eigen::Dynamic> z(500);
  for (Eigen::Index i = 0; i < 1000; ++i) z.vector()[i] = std::sin(static_cast<double>(i));
  CHECK(contains(refusal([&] { cost_of_accuracy(chain, z, 10); }), "a slope of the energy is not the one"));
  CHECK(energies < 500);
}

TEST_CASE(
    "a scan keeps its bound on gradient calls, whatever the Hamiltonian, and says why it found nothing") {
  double calls = 0;
  const auto scan = [&](const auto& hamiltonian, const PhasePoint<double, 1>& z0, double T,
                        const CostOptions& options) {
    calls = 0;
    const CostTable cost = cost_of_accuracy(hamiltonian, z0, T, options);
    CHECK(calls == cost.spent_gradients);
    CHECK(calls <= options.max_gradients);
    CHECK(calls <= 2.1 * cost.budget);  // the coarse run to T included
    for (const double target : cost.targets) {
      CHECK((cost.reach(target) == Reach::met) == cost.cheapest(target).has_value());
      CHECK((cost.reach(target) == Reach::met) == cost.why(target).empty());
    }
    std::ostringstream text;
    text << cost;
    CHECK(contains(text.str(), "Spent: "));
    return cost;
  };
  const CostOptions usual;

  // An energy that is small beside its terms: rounding forbids the tight targets.
  for (const double left : {1e-3, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 0.0}) {
    CAPTURE(left);
    const CostTable cost =
        scan(counted(calls, product_energy(left - 1.625), product_gradient(1, 1)), {-1.5, 0}, 100, usual);
    CHECK(cost.relative == (left > 1e-13));
    if (left == 1e-8) {
      CHECK(cost.reach(1e-4) == Reach::met);
      CHECK(cost.reach(1e-8) == Reach::rounding);
      CHECK(cost.reach(1e-10) == Reach::rounding);
      CHECK(contains(cost.why(1e-10), "small beside its terms"));
    }
  }
  // Kinks: the accuracy of a scheme is lost there. Noise, and rounding to float: not wrong gradients.
  scan(counted(
           calls, [](const auto& q, const auto& p) { return p[0] * p[0] / 2 + std::abs(q[0]); },
           [](double q, double p, double& dHdq, double& dHdp) { dHdq = q > 0 ? 1 : -1, dHdp = p; }),
       {1, 0}, 1000, usual);
  const CostTable wall = scan(counted(
                                  calls,
                                  [](const auto& q, const auto& p) {
                                    const double x = std::max(q[0] - 0.5, 0.0);
                                    return (p[0] * p[0] + q[0] * q[0]) / 2 + 50 * x * x;
                                  },
                                  [](double q, double p, double& dHdq, double& dHdp) {
                                    dHdq = q + 100 * std::max(q - 0.5, 0.0), dHdp = p;
                                  }),
                              {-1, 0}, 1000, usual);
  CHECK(wall.reach(1e-4) == Reach::met);
  CHECK(wall.reach(1e-10) != Reach::met);
  const CostTable noisy =
      scan(counted(
               calls,
               [](const auto& q, const auto& p) {
                 return (p[0] * p[0] + q[0] * q[0]) / 2 + 1e-7 * std::sin(1e6 * q[0]);
               },
               [](double q, double p, double& dHdq, double& dHdp) { dHdq = q, dHdp = p; }),
           {-1, 0}, 1000, usual);
  CHECK(noisy.reach(1e-4) == Reach::met);
  CHECK(noisy.reach(1e-8) == Reach::rounding);
  const CostTable rounded =
      scan(counted(
               calls,
               [](const auto& q, const auto& p) {
                 const double xx = q[0] * q[0], yy = p[0] * p[0];
                 return static_cast<double>(static_cast<float>((xx + yy) / 2 + 0.1 * xx * yy));
               },
               [](double q, double p, double& dHdq, double& dHdp) {
                 dHdq = q + 0.2 * q * p * p, dHdp = p + 0.2 * q * q * p;
               }),
           {-1, 0}, 1000, usual);
  CHECK(rounded.reach(1e-4) == Reach::met);
  CHECK(rounded.reach(1e-8) == Reach::rounding);
  // A late time is no reason to call a right gradient wrong, nor an oscillation noise.
  const auto late = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) {
        return p[0] * p[0] / 2 + p[1] - std::cos(q[0]) * (1 + 0.5 * std::cos(3 * q[1]));
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq << std::sin(q[0]) * (1 + 0.5 * std::cos(3 * q[1])), 1.5 * std::cos(q[0]) * std::sin(3 * q[1]);
        dHdp << p[0], 1;
      });
  for (const double t : {1e4, 1e6})
    CHECK(cost_of_accuracy(late, PhasePoint<double, 2>({1, t}, {0.5, 0.3}), 100.0).rounding < 1e-4);

  // However little is allowed.
  for (const double bound : {1e3, 1e4, 1e5}) {
    const CostTable cost = scan(counted(calls, product_energy(0), product_gradient(1, 1)), {-3, 0}, 1e9,
                                {.max_gradients = bound, .by = CostBy::seconds});
    if (bound == 1e3) CHECK(cost.reach(1e-4) == Reach::budget);
    if (bound == 1e3) CHECK(contains(cost.why(1e-4), "max_gradients"));
  }
  const auto product = counted(calls, product_energy(0), product_gradient(1, 1));
  CHECK(contains(
      refusal([&] { cost_of_accuracy(product, PhasePoint<double, 1>(-3, 0), 1, {.max_gradients = 10}); }),
      "options.max_gradients is below 1000"));

  const CostTable single = cost_of_accuracy(systems::Product<float>(), PhasePoint<float, 1>(-3, 0), 100);
  CHECK(single.reach(1e-4) == Reach::met);
  CHECK(single.reach(1e-8) == Reach::rounding);
  CHECK(single.spent_gradients <= 1.6 * single.budget);
  // A run in floats goes to a time that a float has, and so do its trials.
  const double T =
      cost_of_accuracy(systems::Product<float>(), PhasePoint<float, 1>(-3, 0), 100.1, {.targets = {1e-3}})
          .time;
  CHECK(T == static_cast<double>(100.1F));
  // As many of them where a setting's dt is a Scalar of more digits, or of fewer.
  const auto steps_by = [](auto z, double dt) {
    const systems::Product<typename decltype(z)::Scalar> h;
    return run(h, z, 7, {.method = Setting::Method::gauss, .stages = 4, .dt = dt}).steps;
  };
  for (int n = 14; n <= 60; ++n) {
    CHECK(steps_by(PhasePoint<long double, 1>(0.3, 0.2), 7.0 / n * (1 + 1e-6)) == n);
    CHECK(steps_by(PhasePoint<float, 1>(0.3F, 0.2F), 7.0 / n * (1 + 1e-6)) == n);
  }
  // A step that ends at rounding is done.
  for (const CostRow& row : single.rows)
    if (row.setting.method == Setting::Method::semiexplicit && row.setting.dt < 0.2) CHECK(row.works());
}

TEST_CASE("no advice is given for an orbit that ends before T") {
  double calls = 0;
  const auto escapes = counted(
      calls, [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - q[0] * q[0] * q[0]; },
      [](double q, double p, double& dHdq, double& dHdp) { dHdq = -3 * q * q, dHdp = p; });
  for (const double T : {10.0, 1000.0}) {
    const CostTable cost = cost_of_accuracy(escapes, PhasePoint<double, 1>(1, 0.5), T, {.targets = {1e-6}});
    CHECK_FALSE(cost.cheapest(1e-6));
    CHECK_FALSE(cost.best());
    CHECK(cost.reach(1e-6) == Reach::orbit_ends);
    CHECK(cost.orbit_end == Approx(1.55).epsilon(0.02));
    CHECK(cost.spent_gradients <= 4 * cost.budget);
    std::ostringstream text;
    text << cost;
    CHECK(contains(text.str(), "the orbit ends near t = 1.5"));
  }
  CHECK(cost_of_accuracy(escapes, PhasePoint<double, 1>(1, 0.5), 1, {.targets = {1e-6}}).cheapest(1e-6));
}

TEST_CASE(
    "a hard place on the way is not said to be the end of the orbit, and reversible steps are advised") {
  // Past the centre at 0.02 of a unit, from 100 away.
  const auto kepler = from_energy<2>([](const auto& q, const auto& p) {
    using std::sqrt;
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  const PhasePoint<double, 2> z0({-100, 0.2}, {1, 0});
  const CostTable cost = cost_of_accuracy(kepler, z0, 200, {.targets = {1e-7}});
  const auto advice = cost.cheapest(1e-7);
  REQUIRE(advice);
  CHECK(advice->setting.reversible);
  const Outcome outcome = whole_run(kepler, z0, 200, advice->setting);
  CHECK(outcome.error <= 3e-7);
  CHECK(outcome.gradients < 1e5);
}

TEST_CASE("where the motion gets harder along the way advice holds to the end, or none is given", "[long]") {
  // An oscillator whose frequency rises threefold, all along or late: the start says little of the end.
  const double T = 1000;
  const auto rising = [&](bool late) {
    return Autonomous(from_energy<1>([=](const auto& t, const auto& q, const auto& p) {
      using std::tanh;
      const auto w = late ? 2 + tanh((t - 0.7 * T) / 100) : 1 + 2 * t / T;
      return (p[0] * p[0] + w * w * q[0] * q[0]) / 2;
    }));
  };
  for (const bool late : {false, true}) {
    const auto driven = rising(late);
    const auto z0 = driven.extended({1, 0}, 0.0);
    CAPTURE(late);
    int met = 0;
    for (const double calls : {3e4, 3e5, 3e6}) {
      const auto cost = cost_of_accuracy(driven, z0, T, {.targets = {1e-4, 1e-6}, .min_gradients = calls});
      for (const double target : {1e-4, 1e-6}) {
        if (const auto advice = cost.cheapest(target)) {
          ++met;
          CHECK(whole_run(driven, z0, T, advice->setting).error < 3 * target);
        } else {
          CHECK(cost.reach(target) == Reach::budget);
        }
      }
    }
    CHECK(met >= 2);

    // Of what is no invariant, too.
    const auto position = [](const auto& q, const auto&) { return q[0]; };
    const auto of_position = cost_of_accuracy(driven, z0, T, {.observable = position, .targets = {1e-4}});
    REQUIRE(of_position.cheapest(1e-4));
    auto z = z0, exact = z0;
    of_position.run(z, *of_position.cheapest(1e-4));
    GaussLegendre gauss(driven, {.stages = 8});
    integrate(gauss, exact, {.dt = 0.05, .t_end = T});
    CHECK(std::abs(z.q()[0] - exact.q()[0]) < 3e-4);
  }
}

TEST_CASE("a trial that leaves the domain of H fails, whatever H says there") {
  // A fall from 1 in the potential ln q, which ends in q = 0 at 1.2533.
  enum class Outside { is_nan, throws, throws_other };
  const auto search = [](Outside says) {
    const auto guard = [says](double q) {
      if (q > 0) return q;
      if (says == Outside::throws) throw std::domain_error("q is not positive");
      if (says == Outside::throws_other) throw std::runtime_error("q is not positive");
      return std::numeric_limits<double>::quiet_NaN();
    };
    const auto H = make_hamiltonian<double, 1>(
        [=](const auto& q, const auto& p) { return p[0] * p[0] / 2 + std::log(guard(q[0])); },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = 1 / guard(q[0]);
          dHdp[0] = p[0];
        });
    const auto cost = cost_of_accuracy(H, PhasePoint<double, 1>(1, 0), 0.9,
                                       {.observable = [](const auto& q, const auto&) { return q[0]; }});
    PhasePoint<double, 1> z(1, 0);
    const auto advice = cost.cheapest(1e-9);
    REQUIRE(advice.has_value());
    cost.run(z, *advice);
    CHECK(std::abs(z.q()[0] - 0.5604904) < 1e-6);
    return cost.spent_gradients;
  };
  CHECK(search(Outside::throws) == search(Outside::is_nan));
  CHECK_THROWS_WITH(search(Outside::throws_other), "q is not positive");
}

TEST_CASE("an observable that is NaN somewhere on the orbit is refused with the time") {
  const auto pendulum = from_energy<1>([](const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 - cos(q[0]);
  });
  const auto partial = [](const auto& q, const auto&) { return std::sqrt(q[0] + 0.5); };
  const auto cost = cost_of_accuracy(pendulum, PhasePoint<double, 1>(1, 0.2), 50, {.observable = partial});
  for (const double target : cost.targets) {
    CHECK(cost.reach(target) == Reach::not_finite);
    CHECK(contains(cost.why(target), "the observable is NaN or Inf on the orbit, at t = "));
    CHECK((cost.observable_end > 2 && cost.observable_end < 4));
  }
}

TEST_CASE("no error is said to be less than what the rounding of a state makes of the observable") {
  // From (X + 1/2, 1/4).
  const auto search = [](auto far, double T, const auto& observable, std::vector<double> targets) {
    using Scalar = decltype(far);
    const auto H = oscillator_about(far);
    const PhasePoint<Scalar, 1> start(far + Scalar(0.5), Scalar(0.25));
    const auto cost =
        cost_of_accuracy(H, start, T, {.observable = observable, .targets = std::move(targets)});
    double worst = 0;
    for (const double target : cost.targets)
      if (const auto advice = cost.cheapest(target)) {
        double off = 0;
        auto z = start;
        cost.run(z, *advice, [&](const auto& t, const auto& state) {
          const auto time = static_cast<long double>(t), place = static_cast<long double>(state.q()[0]) - far;
          off = std::max(
              off, static_cast<double>(std::abs(place - 0.5L * std::cos(time) - 0.25L * std::sin(time))));
        });
        worst = std::max(worst, off / cost.unit / target);
      } else if (T >= 0.1) {  // before, the motion is compared with its first value
        CHECK(cost.reach(target) == Reach::rounding);
      }
    CHECK(cost.cheapest(1e-2).has_value());
    CHECK_FALSE(cost.cheapest(1e-11).has_value());
    CHECK(worst < 2);
  };
  const double T = GENERATE(1e-7, 0.1, 0.5, 1.0, 2.0);
  CAPTURE(T);
  const std::vector<double> targets{1e-2, 1e-4, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11};
  for (const double far : {1e7, 1e8, 1e9})
    search(
        far, T, [=](const auto& q, const auto&) { return q[0] - far; }, targets);
  // A vector whose size stays the same.
  const auto on_circle = [](const auto& q, const auto&) {
    return Eigen::Vector2d(std::cos(q[0]), std::sin(q[0]));
  };
  search(1e8, T, on_circle, targets);
  search(
      1e11L, T, [=](const auto& q, const auto&) { return q[0] - 1e11L; }, targets);
  for (const float far : {16.0F, 256.0F})
    search(
        far, T, [=](const auto& q, const auto&) { return q[0] - far; }, targets);
}

TEST_CASE("no error is said to be less than what the rounding of a state makes of the motion") {
  // From (X, p0), or from rest, where q moves by less than a rounding of X.
  const auto search = [](auto far, double T, bool rests) {
    using Scalar = decltype(far);
    const auto H = oscillator_about(far);
    const Scalar small = far * Eigen::NumTraits<Scalar>::epsilon();
    const PhasePoint<Scalar, 1> start(rests ? far + 8 * small : far,
                                      rests ? Scalar(0) : small / Scalar(10 * T));
    const double displaced = static_cast<double>(start.q()[0] - far),
                 moving = static_cast<double>(start.p()[0]);
    const auto momentum = [](const auto&, const auto& p) { return p[0]; };
    for (const bool whole : {false, true}) {
      const auto cost = cost_of_accuracy(
          H, start, T, {.observable = momentum, .targets = {0.9, 1e-2, 1e-4, 1e-6, 1e-8}, .whole = whole});
      for (const double target : cost.targets)
        if (const auto advice = cost.cheapest(target)) {
          auto z = start;
          cost.run(z, *advice);
          const double right = moving * std::cos(T) - displaced * std::sin(T);
          CHECK(std::abs(static_cast<double>(z.p()[0]) - right) / cost.unit < 2 * target);
        } else {
          CHECK(cost.reach(target) == Reach::rounding);
        }
      CHECK(cost.cheapest(0.9).has_value());
      CHECK_FALSE(cost.cheapest(1e-8).has_value());
    }
  };
  const double T = GENERATE(1e-3, 1e-2, 0.1, 0.25);
  CAPTURE(T);
  for (const bool rests : {false, true}) {
    search(149597870700.0, T, rests);
    search(6.4e6F, T, rests);
  }
}

TEST_CASE("no target is lost in rounding because something far faster lies ahead, or is at rest") {
  const auto rounding = [](const auto& H, const auto& start, double T, const auto& f) {
    const auto cost = cost_of_accuracy(H, start, T, {.observable = f, .targets = {1e-6, 1e-10}});
    CHECK(cost.cheapest(1e-10).has_value());
    return cost.rounding;
  };
  const auto momentum = [](const auto&, const auto& p) { return p[0]; };
  // A ball above a soft floor, which it comes to at 1.4.
  const auto ball = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0] + std::exp(-40 * q[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 1 - 40 * std::exp(-40 * q[0]);
        dHdp[0] = p[0];
      });
  CHECK(rounding(ball, PhasePoint<double, 1>(1, 0), 1.2, momentum) < 1e-13);
  // Two atoms on a stiff spring that fall, by their centre and their distance, which stays what it is.
  const auto atoms = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) {
        return (p[0] * p[0] + p[1] * p[1]) / 2 + q[0] + 5e5 * (q[1] - 1) * (q[1] - 1);
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 1;
        dHdq[1] = 1e6 * (q[1] - 1);
        dHdp = p;
      });
  CHECK(rounding(atoms, PhasePoint<double, 2>({10, 1}, {-1, 0}), 1.0, momentum) < 1e-13);
  // From the apoapsis of an ellipse, e = 0.999, to its periapsis.
  const Kepler kepler;
  const PhasePoint<double, 2> apoapsis({1.999, 0}, {0, std::sqrt(0.001 / 1.999)});
  const auto eccentricity = [](const auto& q, const auto& p) {
    const double l = q[0] * p[1] - q[1] * p[0];
    return Eigen::Vector2d(p[1] * l - q[0] / q.norm(), -p[0] * l - q[1] / q.norm());
  };
  CHECK(rounding(kepler, apoapsis, std::acos(-1.0), eccentricity) < 1e-13);
}

TEST_CASE(
    "no error of an energy is said to be less than half a rounding of it: a constant that hides noise") {
  const auto h = from_energy<1, float>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2 + 7956.f; });
  const PhasePoint<float, 1> z(0.1f, 0.03f);
  const float energy = h.energy(z.q(), z.p());
  for (const bool absolute : {true, false})
    for (const double T : {0.01, 1.0, 100.0}) {
      CAPTURE(absolute, T);
      const double unit = absolute ? 1 : energy, hopeless = 3.8e-6 / unit, enough = 6e-3 / unit;
      const CostTable cost = cost_of_accuracy(h, z, T, {.targets = {enough, hopeless}, .absolute = absolute});
      const double least = std::numeric_limits<float>::epsilon() / 2 * energy / unit;
      CHECK_FALSE(cost.rows.empty());
      for (const CostRow& row : cost.rows)
        if (row.works()) CHECK(row.error >= least * (1 - 1e-12));
      CHECK(cost.rounding >= least * (1 - 1e-12));
      CHECK_FALSE(cost.cheapest(hopeless));
      CHECK(cost.reach(hopeless) == Reach::rounding);
      CHECK(cost.cheapest(enough));
    }
}

TEST_CASE("the table does not depend on the locale") {
  const CostTable cost =
      cost_of_accuracy(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 10, {.targets = {1e-6}});
  const auto printed = [&] {
    std::ostringstream text;
    text << cost;
    return text.str();
  };
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
    char do_thousands_sep() const override { return '.'; }
    std::string do_grouping() const override { return "\3"; }
  };
  const std::string classic = printed();
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const std::string here = printed();
  std::locale::global(before);
  CHECK(here == classic);
}

}  // namespace test_cost_of_accuracy
