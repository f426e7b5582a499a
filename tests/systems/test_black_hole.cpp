#include "catch.hpp"

#include <algorithm>
#include <cmath>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_black_hole {

// Geodesics of black holes against closed forms.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
const double pi = std::acos(-1.0);

}  // namespace

TEST_CASE("A geodesic of Kerr keeps energy, angular momentum and Carter's constant", "[systems]") {
  const black_hole::Kerr<> hole{.spin = 0.9};
  const Scene scene(hole);
  auto z = hole.body(9, pi / 2, 0.05, 1.6, 2.4);
  const auto start = z;
  CHECK(scene.energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-14));
  auto stepper = stepper_for(scene);
  Invariants invariants(scene);
  invariants.add("Carter", [&](const auto& q, const auto& p) { return hole.carter(q, p); });
  double lowest = 9, highest = 9, tilt = 0;
  integrate(stepper, z, {.dt = 0.5, .steps = 4000}, invariants, [&](double, const auto& now) {
    lowest = std::min(lowest, now.q()[1]);
    highest = std::max(highest, now.q()[1]);
    tilt = std::max(tilt, std::abs(now.q()[2] - pi / 2));
  });
  CHECK(highest - lowest > 1);  // neither circular nor equatorial
  CHECK(tilt > 0.3);
  CHECK(invariants["energy"].worst < 1e-10);
  CHECK(invariants["Carter"].worst < 1e-10);
  CHECK(z.p()[0] == start.p()[0]);
  CHECK(z.p()[3] == start.p()[3]);
}

TEST_CASE("The innermost stable orbit of Kerr: its radius and its frequency", "[systems]") {
  CHECK(black_hole::Kerr<>{}.innermost_stable_orbit() == Approx(6));
  CHECK(black_hole::Kerr<>{.spin = 0.9}.innermost_stable_orbit() == Approx(2.32088).epsilon(1e-5));
  CHECK(black_hole::Kerr<>{.spin = -0.9}.innermost_stable_orbit() == Approx(8.71735).epsilon(1e-5));
  for (const double spin : {1e-7, -2e-6, 1.1e-5, 1e-4}) {  // 6 - 4 sqrt(2/3) a - 7/18 a² + O(a³)
    const double series = 6 - 4 * std::sqrt(2.0 / 3) * spin - 7.0 / 18 * spin * spin;
    CHECK(std::abs(black_hole::Kerr<>{.spin = spin}.innermost_stable_orbit() - series) <
          4e-15 + std::abs(spin * spin * spin));
    CHECK(std::abs(double(black_hole::Kerr<float>{.spin = float(spin)}.innermost_stable_orbit()) - series) <
          1e-6);
  }
  CHECK(std::abs(black_hole::Kerr<float>{.spin = 5e-4F}.innermost_stable_orbit() - 5.99836691F) < 1e-6F);
  for (const double spin : {0.0, 0.9}) {
    CAPTURE(spin);
    const black_hole::Kerr<> hole{.spin = spin};
    const double r = hole.innermost_stable_orbit();
    auto z = hole.circular(r);
    CHECK(Scene(hole).energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-13));
    auto stepper = stepper_for(Scene(hole));
    integrate(stepper, z, {.dt = 0.2, .steps = 500});
    CHECK(z.q()[1] == Approx(r).epsilon(1e-12));
    CHECK(z.q()[3] / z.q()[0] == Approx(1 / (std::pow(r, 1.5) + spin)).epsilon(1e-12));
    CHECK(z.q()[3] > 2 * pi);
  }
  // Known to be stable outside only: a push inward ends in the hole below it, and comes back above.
  const black_hole::Kerr<> hole{};
  const auto pushed = [&](double r) {
    auto z = hole.circular(r);
    z = hole.body(r, pi / 2, -1e-3, 0, z.p()[3]);
    auto stepper = stepper_for(Scene(hole));
    double lowest = r;
    integrate(stepper, z, {.dt = 0.5, .steps = 2000, .on_failure = OnFailure::stop},
              [&](double, const auto& now) {
                lowest = std::min(lowest, now.q()[1]);
                return now.q()[1] > 2.5;
              });
    return lowest;
  };
  CHECK(pushed(6.3) > 6);
  CHECK(pushed(5.7) < 2.6);
}

TEST_CASE("Kerr without spin is Schwarzschild", "[systems]") {
  const PhasePoint<double, 4> z({0.3, 7.1, 1.2, 0.4}, {-0.96, 0.2, 1.4, 2.3});
  PhasePoint<double, 4> one, other;
  Scene(black_hole::Kerr<>{.mass = 1.2}).gradient(z.q(), z.p(), one.q(), one.p());
  Scene(black_hole::Schwarzschild<>{.mass = 1.2}).gradient(z.q(), z.p(), other.q(), other.p());
  CHECK((one.vector() - other.vector()).norm() <= 1e-14 * other.vector().norm());
}

}  // namespace test_black_hole
