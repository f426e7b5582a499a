#include "catch.hpp"

#include <cmath>
#include <numbers>
#include <vector>

#include <boost/math/special_functions/ellint_1.hpp>
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

namespace test_poincare_section {

// Crossings of surfaces: times and points against the closed form of the solvable product.

namespace {

using namespace semiexplicit;

const double q0 = -3, omega = std::sqrt(1 + q0 * q0), modulus = std::abs(q0) / omega;
const double period = 4 * boost::math::ellint_1(modulus) / omega;

/// The orbit of systems::Product from (q0, 0).
PhasePoint<double, 1> exact(double t) {
  double cn, dn;
  const double sn = boost::math::jacobi_elliptic(modulus, omega * t, &cn, &dn), q = q0 * cn;
  return {q, -q0 * omega * sn * dn / (q * q + 1)};
}

constexpr auto position = [](const auto& q, const auto&) { return q[0]; };

struct Crossing {
  double t, p;
};

}  // namespace

TEST_CASE("A fine run crosses where the closed form does", "[section]") {
  // q rises through 0 at a quarter of the period and whole ones later, always with p = |q0|.
  std::vector<Crossing> found;
  auto section = poincare_section(systems::Product<double>(), position, [&](double t, const auto& z) {
    CHECK(std::abs(z.q()[0]) <= 1e-13);  // t = 10 has no more digits
    found.push_back({t, z.p()[0]});
  });
  Semiexplicit stepper(systems::Product<double>(), schemes::low_defect8_s20());
  PhasePoint<double, 1> z(q0, 0);
  integrate(stepper, z, {.dt = period / 500, .steps = 5000}, section);
  REQUIRE(found.size() == 10);
  CHECK(section.count() == 10);
  for (std::size_t k = 0; k < 10; ++k) {
    CHECK(std::abs(found[k].t - (0.25 + static_cast<double>(k)) * period) <= 1e-12);
    CHECK(std::abs(found[k].p - 3) <= 1e-12);
  }
}

TEST_CASE("Crossings are as accurate as the interpolation", "[section]") {
  // Of the exact states, so that nothing else is in the error. q rises through q₀/2 where cn = 1/2, but for
  // the period.
  const double first = boost::math::ellint_1(modulus, std::acos(0.5)) / omega;
  for (const int nodes : {2, 3, 4}) {
    const auto error = [&](int steps) {
      double worst = 0;
      auto section = poincare_section(
          systems::Product<double>(), [](const auto& q, const auto&) { return q[0] + 1.5; },
          [&](double t, const auto&) {
            worst = std::max(worst, std::abs(std::remainder(t - first, period)));
          },
          {.nodes = nodes});
      for (int n = -steps / 2; n < 9 * steps / 2; ++n) {
        const double t = first + (n + 0.5) * period / steps;  // crossings always in the middle of a step
        section(t, exact(t), {});
      }
      CHECK(section.count() == 5);
      return worst;
    };
    CAPTURE(nodes);
    CHECK(std::log2(error(80) / error(160)) == Approx(2 * nodes).margin(0.9));
  }
}

TEST_CASE("Crossings are counted by direction, forwards and backwards", "[section]") {
  const auto count = [](CrossingDirection direction, double dt) {
    auto section = poincare_section(systems::Product<double>(), position, [](double, const auto&) {},
                                    {.direction = direction});
    for (int n = 0; n <= 90; ++n) section(n * dt, exact(n * dt), {});
    return section.count();
  };
  // 2.25 periods from -3, and the last state lies on the surface, as nearly as numbers go.
  CHECK(count(CrossingDirection::falling, period / 41) == 2);
  CHECK(count(CrossingDirection::rising, period / 41) == 2);
  CHECK(count(CrossingDirection::both, period / 41) == 4);
  CHECK(count(CrossingDirection::rising, period / 39) == 3);
  CHECK(count(CrossingDirection::rising, -period / 39) == 3);
}

TEST_CASE("States on the surface are crossings once, and starts never", "[section]") {
  const auto H = make_hamiltonian<double, 1>([](const auto&, const auto& p) { return p[0]; },
                                             [](const auto&, const auto&, auto& dHdq, auto& dHdp) {
                                               dHdq[0] = 0;
                                               dHdp[0] = 1;
                                             });
  std::vector<double> times;
  auto section = poincare_section(
      H, [](const auto& q, const auto&) { return (q[0] + 3) * q[0]; },
      [&](double t, const auto&) { times.push_back(t); }, {.direction = CrossingDirection::both});
  for (int n = 0; n < 8; ++n) section(n, {n - 3.0, 1.0}, {});  // starts on s = 0, and q = 0 at t = 3
  REQUIRE(times.size() == 1);
  CHECK(times[0] == 3);
}

TEST_CASE("Short runs are looked through by finish(), and observers end runs", "[section]") {
  int seen = 0;
  auto section = poincare_section(systems::Product<double>(), position, [&](double, const auto&) { ++seen; });
  section(0.0, exact(0.0), {});
  section(0.4 * period, exact(0.4 * period), {});
  CHECK(seen == 0);
  section.finish();
  section.finish();
  CHECK(seen == 1);

  Semiexplicit stepper(systems::Product<double>(), schemes::blanes_moan4());
  PhasePoint<double, 1> z(q0, 0);
  auto two =
      poincare_section(systems::Product<double>(), position, [&](double, const auto&) { return ++seen < 3; });
  const auto report = integrate(stepper, z, {.dt = period / 100, .steps = 1000}, two);
  CHECK(report.status == Status::stopped);
  CHECK(seen == 3);
}

TEST_CASE("A driven system is cut at equal phases of the driving", "[section]") {
  // Stroboscopically: where sin(t/2) changes its sign, at whole multiples of 2π.
  const Autonomous K(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (p[0] * p[0] - q[0] * cos(t)) / 2;
  }));
  std::vector<double> times, momenta;
  auto section = poincare_section(
      K, [](const auto& q, const auto&) { return std::sin(q[1] / 2); },
      [&](double t, const PhasePoint<double, 1>& z) {
        times.push_back(t);
        momenta.push_back(z.p()[0]);
      },
      {.direction = CrossingDirection::both});
  Semiexplicit stepper(K, schemes::low_defect6_s13());
  auto Z = K.extended({0, 1}, 0.1);
  integrate(stepper, Z, {.dt = 0.05, .steps = 1000}, section);
  REQUIRE(times.size() == 7);
  for (std::size_t k = 0; k < times.size(); ++k) {
    CHECK(times[k] == Approx(2 * std::numbers::pi * static_cast<double>(k + 1)).epsilon(1e-13));
    CHECK(momenta[k] == Approx(1 - std::sin(0.1) / 2).epsilon(1e-11));  // p' = cos(t)/2
  }
}

TEST_CASE("A run that goes on counts no crossing twice", "[section]") {
  const systems::Product<double> h;
  const auto surface = [](const auto& q, const auto&) { return q[0]; };
  const auto count = [&](const std::vector<int>& parts, double late) {
    int crossings = 0;
    auto section = poincare_section(h, surface, [&](double, const auto&) { ++crossings; });
    Semiexplicit stepper(h, schemes::blanes_moan6());
    PhasePoint<double, 1> z(-3, 0);
    double t = 0;
    for (const int steps : parts) {
      integrate(stepper, z, {.dt = 0.01, .steps = steps, .t0 = t}, section);
      t += steps * 0.01 * (1 + late);
    }
    return crossings;
  };
  const int whole = count({3000}, 0);
  CHECK(whole > 5);
  // Parts that end in every place, also just behind a crossing, and times that meet but for rounding.
  CHECK(count(std::vector<int>(300, 10), 0) == whole);
  CHECK(count(std::vector<int>(1000, 3), 0) == whole);
  CHECK(count(std::vector<int>(300, 10), 1e-16) == whole);
}

}  // namespace test_poincare_section
