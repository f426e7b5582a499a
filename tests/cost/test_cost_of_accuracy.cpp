// The advice is judged by gradient calls: they are the same on every machine.
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include <semiexplicit/cost/cost_of_accuracy.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>
#include <semiexplicit/systems/product.hpp>

#include "catch.hpp"

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
  const CostOfAccuracy cost = cost_of_accuracy(hamiltonian, z0, T, {.targets = {target}});
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
    const CostOfAccuracy cost =
        cost_of_accuracy(lattice, lattice_start(), 3000, {.targets = {1e-8}, .budget = budget});
    const auto advice = cost.cheapest(1e-8);
    REQUIRE(advice);
    CHECK(cost.spent_gradients > 0);
    CHECK(cost.fraction_of(*advice) == Approx(cost.spent_gradients / advice->gradients));
    CHECK(cost.fraction_of(*advice) < 2 * budget);
  }
}

TEST_CASE("a tighter target costs more, from one scan") {
  const CostOfAccuracy cost = cost_of_accuracy(Lattice(), lattice_start(), 100);
  double last = 0;
  for (const double target : {1e-3, 1e-4, 1e-6, 3e-8, 1e-9, 1e-10}) {
    const auto row = cost.cheapest(target);
    REQUIRE(row);
    CHECK(row->error <= target);
    CHECK(row->gradients >= last);
    last = row->gradients;
  }
}

TEST_CASE("an accuracy out of reach is said to be so") {
  const CostOfAccuracy cost =
      cost_of_accuracy(systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 1000, {.targets = {1e-18}});
  CHECK_FALSE(cost.cheapest(1e-18));
  REQUIRE(cost.best());
  CHECK(cost.best()->error > 1e-18);
  std::ostringstream text;
  text << cost;
  CHECK(contains(text.str(), "out of reach"));
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

TEST_CASE("bad requests are refused by name") {
  const systems::Product<double> product;
  const PhasePoint<double, 1> z0(-3, 0);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto of = [&](const PhasePoint<double, 1>& z, double T, const CostOptions& options = {}) {
    return refusal([&] { cost_of_accuracy(product, z, T, options); });
  };
  CHECK(contains(of(z0, 0), "T is not a finite positive time"));
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
  const CostOfAccuracy nothing;
  CHECK_FALSE(nothing.cheapest(1e-6));
  CHECK(contains(refusal([&] { (void)nothing.cheapest(0); }), "target is not"));
  CHECK(contains(refusal([&] { (void)nothing.cheapest(nan); }), "target is not"));
}

TEST_CASE("a gradient that does not belong to the energy is refused") {
  const auto wrong = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0] * (p[0] * p[0] + 1);
        dHdp[0] = -p[0] * (q[0] * q[0] + 1);
      });
  CHECK_THROWS_AS(cost_of_accuracy(wrong, PhasePoint<double, 1>(-3, 0.5), 100), std::invalid_argument);
}
