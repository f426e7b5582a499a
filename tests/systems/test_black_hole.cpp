#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

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

TEMPLATE_TEST_CASE("A body starts on its mass shell in any unit of length", "[systems]", float, double) {
  const TestType epsilon = std::numeric_limits<TestType>::epsilon();
  for (const double exponent : {-0.3, -0.28, -0.1, 0.0, 0.1, 0.2}) {  // of the whole range
    const auto m =
        static_cast<TestType>(std::pow(10, exponent * std::numeric_limits<TestType>::max_exponent10));
    CAPTURE(m);
    const black_hole::Kerr<TestType> hole{.mass = m, .spin = TestType(0.9) * m};
    const auto z = hole.body(20 * m, std::acos(TestType(0)), 0, 0, TestType(2.5) * m);
    CHECK(std::abs(hole.energy(z.q(), z.p()) + TestType(0.5)) < 8 * epsilon);
    CHECK(-z.p()[0] == Approx(0.956621795));
  }
}

TEST_CASE("Far from a spinning hole its pull has all digits", "[systems]") {
  const auto slopes = [](auto scene, double r) {
    using Scalar = typename decltype(scene)::Scalar;
    const auto z = black_hole::Kerr<>{.mass = 2, .spin = 1.5}.body(r, 1.1, 0.01, 0.3 * std::sqrt(r), 1.3);
    PhasePoint<Scalar, 4> of(z.q().cast<Scalar>(), z.p().cast<Scalar>()), gradient(of);
    // Rounded to float for all.
    of.vector() = of.vector().template cast<float>().template cast<Scalar>();
    scene.gradient(of.q(), of.p(), gradient.q(), gradient.p());
    return Vector<double, 2>(double(gradient.q()[1]), double(gradient.q()[2]));
  };
  for (const double r : {30.0, 3e3, 3e5, 3e7}) {
    CAPTURE(r);
    const auto exact = slopes(Scene(black_hole::Kerr<long double>{.mass = 2, .spin = 1.5L}), r);
    CHECK(exact[0] > 0.5 * 2 / (r * r));
    const auto check = [&](const auto& found, double epsilon) {
      CHECK(std::abs(found[0] / exact[0] - 1) < 16 * epsilon);
      CHECK(std::abs(found[1] / exact[1] - 1) < 16 * epsilon);
    };
    check(slopes(Scene(black_hole::Kerr<float>{.mass = 2, .spin = 1.5F}), r), 6e-8);
    check(slopes(Scene(black_hole::Kerr<>{.mass = 2, .spin = 1.5}), r), 1.1e-16);
    check(
        slopes(Scene(geodesics::Geodesic<geodesics::KerrMetric<float>, float>({.mass = 2, .spin = 1.5F})), r),
        6e-8);
  }
}

TEST_CASE("Next to the horizon of a fast spinning hole the gradient keeps its digits", "[systems]") {
  const double spin = 1 - 1e-7, r = 1 + 1e-3;
  const auto at = [&](auto number) {
    using Scalar = decltype(number);
    const Scene scene(black_hole::Kerr<Scalar>{.spin = Scalar(spin)});
    const PhasePoint<Scalar, 4> z({0, Scalar(r), 1, 0}, {-1, 200, 1.5, 1});
    auto gradient = z;
    scene.gradient(z.q(), z.p(), gradient.q(), gradient.p());
    Vector<long double, 9> all;
    all << gradient.vector().template cast<long double>(),
        static_cast<long double>(scene.energy(z.q(), z.p()));
    return all;
  };
  const auto exact = at(1.0L), found = at(1.0);
  for (const int i : {1, 2, 4, 5, 6, 7, 8}) CHECK(std::abs(double(found[i] / exact[i] - 1)) < 2e-14);
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
