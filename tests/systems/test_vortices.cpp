#include "catch.hpp"
#include "refusal.hpp"

#include <cmath>
#include <initializer_list>
#include <string>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_vortices {

// Vortices in flows and between walls, against closed forms.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using Circulations = vortices::Circulations<double>;
using Chosen = RuntimeScene<double, Eigen::Dynamic>;  // one stepper for all tests: it compiles faster
using Eigen::VectorXd;

const double pi = std::acos(-1.0);

VectorXd list(std::initializer_list<double> numbers) {
  return Eigen::Map<const VectorXd>(numbers.begin(), static_cast<Eigen::Index>(numbers.size()));
}

struct Places {
  VectorXd x, y;
};

/// Where vortices from (x, y) are after `steps` steps.
Places run(const Chosen& scene, const Circulations& gamma, const VectorXd& x, const VectorXd& y, double dt,
           int steps) {
  PhasePoint<double, Eigen::Dynamic> z(x.cwiseQuotient(gamma.x_per_q), y.cwiseQuotient(gamma.y_per_p));
  with_stepper_for(scene, [&](auto& stepper) { integrate(stepper, z, {.dt = dt, .steps = steps}); });
  return {z.q().cwiseProduct(gamma.x_per_q), z.p().cwiseProduct(gamma.y_per_p)};
}

}  // namespace

TEST_CASE("Two vortices turn at the known rate, a turning flow adds its own", "[systems]") {
  const Circulations gamma(list({1.5, 0.5}));
  const double rate = 0.2, distance = 0.9, t = 2;
  const double angle = (2 / (2 * pi * distance * distance) + rate) * t;
  const VectorXd x = list({0.25 * distance, -0.75 * distance}), y = list({0, 0});
  const Chosen scene{vortices::Pairs{gamma}, vortices::Rotation(gamma, rate)};
  CHECK(!scene.is_separable());
  const auto end = run(scene, gamma, x, y, 0.02, 100);
  for (int i = 0; i < 2; ++i) {
    CHECK(end.x[i] == Approx(x[i] * std::cos(angle)).margin(1e-10));
    CHECK(end.y[i] == Approx(x[i] * std::sin(angle)).margin(1e-10));
  }
}

TEST_CASE("Vortices along a wall: the image moves one, and two are half of a four", "[systems]") {
  const double height = 0.7;
  const Circulations one(list({-1.3}));
  const auto end = run(Chosen{vortices::HalfPlane{one}}, one, list({0.2}), list({height}), 0.05, 40);
  CHECK(end.x[0] == Approx(0.2 - 1.3 / (4 * pi * height) * 2).epsilon(1e-12));
  CHECK(end.y[0] == Approx(height).epsilon(1e-12));

  // Two above the wall move as the upper two of four without it.
  const Circulations two(list({1.1, -0.6}));
  const Circulations four(list({1.1, -0.6, -1.1, 0.6}));
  const VectorXd x = list({0.1, -0.5}), y = list({0.8, 1.3});
  const auto walled = run(Chosen{vortices::Pairs{two}, vortices::HalfPlane{two}}, two, x, y, 0.02, 100);
  const auto free = run(Chosen{vortices::Pairs{four}}, four, list({x[0], x[1], x[0], x[1]}),
                        list({y[0], y[1], -y[0], -y[1]}), 0.02, 100);
  CHECK((walled.x - free.x.head<2>()).norm() <= 1e-10);
  CHECK((walled.y - free.y.head<2>()).norm() <= 1e-10);
  CHECK((walled.x - x).norm() > 0.1);
}

TEST_CASE("A vortex in a disk turns at the known rate, two feel each other's images", "[systems]") {
  const double radius = 2, r = 0.8, strength = 1.7, t = 3;
  const Circulations one(list({strength}));
  const auto end = run(Chosen{vortices::Disk(one, radius)}, one, list({r}), list({0.0}), 0.03, 100);
  const double angle = strength / (2 * pi * (radius * radius - r * r)) * t;
  CHECK(end.x[0] == Approx(r * std::cos(angle)).margin(1e-12));
  CHECK(end.y[0] == Approx(r * std::sin(angle)).margin(1e-12));

  // Two equal ones opposite to each other: the velocity of the other, and of both images at R²/r.
  const Circulations two(list({strength, strength}));
  const auto both = run(Chosen{vortices::Pairs{two}, vortices::Disk(two, radius)}, two, list({r, -r}),
                        list({0, 0}), 0.01, 300);
  const double image = radius * radius / r;
  const double rate = strength / (2 * pi * r) * (1 / (2 * r) + 1 / (image - r) - 1 / (image + r));
  CHECK(both.x[0] == Approx(r * std::cos(rate * t)).margin(1e-10));
  CHECK(both.y[1] == Approx(-r * std::sin(rate * t)).margin(1e-10));
}

TEST_CASE("A vortex near a round wall moves as its place says, to rounding", "[systems]") {
  const vortices::Circulations<double, 1> circulation(Vector<double, 1>(2.0));
  const vortices::Disk disk(circulation, 1.0);
  for (const double off : {1e-2, 1e-4, 1e-6, 1e-8}) {
    CAPTURE(off);
    const Vector<double, 1> q(0.6 * (1 - off) / circulation.x_per_q[0]),
        p(0.8 * (1 - off) / circulation.y_per_p[0]);
    Vector<double, 1> by_q(0.0), by_p(0.0);
    disk.add_gradient(q, p, by_q, by_p);
    const auto x = static_cast<long double>(q[0] * circulation.x_per_q[0]),
               y = static_cast<long double>(p[0] * circulation.y_per_p[0]), inside = 1 - x * x - y * y;
    const auto close = 4e-16 / off;  // what the rounding of a place is worth
    CHECK(by_p[0] * circulation.x_per_q[0] ==
          Approx(static_cast<double>(-y / (std::acos(-1.0L) * inside))).epsilon(4 * close));
    CHECK(disk.energy(q, p) ==
          Approx(static_cast<double>(std::log(inside) / std::acos(-1.0L))).margin(close));
  }
}

TEST_CASE("A strained vortex of strength one moves as the flow does", "[systems]") {
  const Circulations one(list({2.0}));
  const auto end = run(Chosen{vortices::Strain(one, 0.5)}, one, list({0.3}), list({0.9}), 0.02, 100);
  CHECK(end.x[0] == Approx(0.3 * std::exp(1.0)).epsilon(1e-10));
  CHECK(end.y[0] == Approx(0.9 * std::exp(-1.0)).epsilon(1e-10));
}

TEST_CASE("Circulations refuse what makes no sense", "[systems]") {
  CHECK(refuses([&] { Circulations{VectorXd()}; }, "no circulation given"));
  CHECK(refuses([&] { Circulations(list({1, 0})); }, "circulation 1 is zero"));
}

TEST_CASE("A scene refuses effects of other vortices, and a disk a radius that is none", "[systems]") {
  const Circulations gamma(list({1, 2})), same(list({1, 2})), others(list({1, 3}));
  const vortices::Pairs pairs{gamma};
  const auto check = [&](const auto& effect) {
    const std::string said = "the effects pairs and " + std::string(effect.name) +
                             " have other masses or circulations; give both the same ones";
    CHECK(refuses([&] { Scene(pairs, effect); }, "Scene: " + said));
    CHECK(refuses([&] { (Chosen{pairs, effect}); }, "RuntimeScene: " + said));
  };
  check(vortices::Strain(others, 0.6, 0.4));
  check(vortices::Rotation(others, 0.8));
  check(vortices::HalfPlane{others});
  check(vortices::Disk{others, 2.0});
  CHECK(refusal([&] { Scene(pairs, vortices::Rotation(same, 0.8), vortices::HalfPlane{same}); }) == accepted);
  for (const double radius : {0.0, -2.0, std::nan("")})
    CHECK(refuses([&] { vortices::Disk(gamma, radius); }, "Disk: the radius is not positive and finite"));
}

TEST_CASE("Linear waves on a lattice: hopping and disorder", "[systems]") {
  // A standing wave of the open chain, ψᵢ = sin(k(i + 1)), k = π/(n + 1), turns at -2J cos k; equal energies
  // add theirs.
  const int n = 20;
  const double j = 0.7, energy = 0.4, k = pi / (n + 1), t = 5, angle = -(energy - 2 * j * std::cos(k)) * t;
  const Chosen scene{lattice::Hopping<>{.sites = n, .rate = j},
                     lattice::Disorder<>(VectorXd::Constant(n, energy))};
  CHECK(scene.is_separable());
  PhasePoint<double, Eigen::Dynamic> z(n);
  VectorXd wave(n);
  for (int i = 0; i < n; ++i) z.q()[i] = wave[i] = std::sin(k * (i + 1));
  with_stepper_for(scene, [&](auto& stepper) { integrate(stepper, z, {.dt = 0.1, .steps = 50}); });
  CHECK((z.q() - std::cos(angle) * wave).norm() <= 1e-7);
  CHECK((z.p() - std::sin(angle) * wave).norm() <= 1e-7);

  CHECK(refuses([&] { Scene(lattice::Hopping<>{.sites = 4}, lattice::OnSite<>{.sites = 5}); },
                "on_site has 5 degrees of freedom, and hopping has 4"));
}

}  // namespace test_vortices
