#include "catch.hpp"

#include <cmath>
#include <numbers>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_geodesics {

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using Point = PhasePoint<double, 4>;
using Chosen = RuntimeScene<double, 4>;  // one stepper for all tests: it compiles faster
using Four = Eigen::Vector4d;
using std::numbers::pi;

/// Kerr's metric as it is printed in most books, g_{μν}.
struct LowerKerr {
  double a = 0;
  auto operator()(const auto& x) const {
    using std::cos, std::sin;
    geodesics::Components g(x);
    const auto r = x[1], s = sin(x[2]), c = cos(x[2]), s2 = s * s;
    const auto sigma = r * r + a * a * c * c;
    g(0, 0) = 2 * r / sigma - 1;
    g(0, 3) = -2 * a * r * s2 / sigma;
    g(1, 1) = sigma / (r * r - 2 * r + a * a);
    g(2, 2) = sigma;
    g(3, 3) = (r * r + a * a + 2 * r * a * a * s2 / sigma) * s2;
    return geodesics::inverse(g);
  }
};

/// Schwarzschild's in the coordinates (t, x, y, z) of Kerr and Schild, regular at the horizon: η^{μν} - 2M/r
/// l^μ l^ν.
struct KerrSchild {
  auto operator()(const auto& x) const {
    using std::sqrt;
    geodesics::Components g(x);
    const auto r = sqrt(x[1] * x[1] + x[2] * x[2] + x[3] * x[3]);
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j) {
        const auto li = i == 0 ? -1 + 0 * r : x[i] / r, lj = j == 0 ? -1 + 0 * r : x[j] / r;
        g(i, j) = (i == j ? (i == 0 ? -1 : 1) : 0) - 2 / r * li * lj;
      }
    return g;
  }
};

/// Schwarzschild's in ingoing coordinates (v, r, θ, φ), v = t + r + 2 log(r/2 - 1): regular at the horizon,
/// g^{00} = 0.
struct Ingoing {
  auto operator()(const auto& x) const {
    using std::sin;
    geodesics::Components g(x);
    const auto r = x[1], s = sin(x[2]);
    g(0, 1) = 1;
    g(1, 1) = 1 - 2 / r;
    g(2, 2) = 1 / (r * r);
    g(3, 3) = 1 / (r * r * s * s);
    return g;
  }
};

/// Flat, in a frame that turns about z: x = r cos(φ + ωt).
struct TurningFlat {
  double omega = 0.3;
  auto operator()(const auto& x) const {
    geodesics::Components g(x);
    g(0, 0) = -1;
    g(0, 3) = omega;
    g(1, 1) = 1;
    g(2, 2) = 1;  // of z
    g(3, 3) = 1 / (x[1] * x[1]) - omega * omega;
    return g;
  }
};

}  // namespace

TEST_CASE("Kerr from its metric alone is the Kerr of the library, to rounding") {
  const black_hole::Kerr<double> by_hand{.mass = 1, .spin = 0.9};
  const geodesics::Geodesic upper(geodesics::KerrMetric<double>{.mass = 1, .spin = 0.9});
  const geodesics::Geodesic lower(LowerKerr{0.9});
  for (const double r : {2.5, 6.0, 40.0})
    for (const double theta : {0.4, 1.2, 2.8}) {
      CAPTURE(r, theta);
      const Point z = by_hand.body(r, theta, 0.1, 1.3, 2.1);
      CHECK((z.vector() - upper.body({0, r, theta, 0}, {0.1, 1.3, 2.1}).vector()).norm() <= 1e-13);
      Point a, b, c;
      Scene(by_hand).gradient(z.q(), z.p(), a.q(), a.p());
      Scene(upper).gradient(z.q(), z.p(), b.q(), b.p());
      Scene(lower).gradient(z.q(), z.p(), c.q(), c.p());
      CHECK((a.vector() - b.vector()).norm() <= 2e-14 * a.vector().norm());
      CHECK((a.vector() - c.vector()).norm() <= 1e-13 * a.vector().norm());
      CHECK(upper.energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-13));
      CHECK(lower.energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-12));
    }
  // And so are its orbits; Carter's constant is kept.
  const Point start = by_hand.body(8, 1.3, 0, 1.5, 2.8);
  Point y = start, z = start;
  auto one = stepper_for(Chosen{by_hand}), other = stepper_for(Chosen{upper});
  integrate(one, y, {.dt = 0.5, .steps = 1000});
  integrate(other, z, {.dt = 0.5, .steps = 1000});
  CHECK((y.vector() - z.vector()).norm() < 1e-9);
  CHECK(by_hand.carter(z.q(), z.p()) == Approx(by_hand.carter(start.q(), start.p())).epsilon(1e-7));
}

TEST_CASE("in Kerr-Schild coordinates a body falls through the horizon, and circles at r^(-3/2)") {
  const geodesics::Geodesic hole(KerrSchild{});
  auto stepper = stepper_for(Chosen{hole});
  // From rest at infinity, E = 1: dr/dτ = -√(2/r).
  const double r0 = 10;
  Point z({0, r0, 0, 0}, {-1, 0, 0, 0});
  // H = -1/2 gives p_x of the ingoing body: the smaller root.
  const double f = 2 / r0;
  double low = -3, high = -f / (1 - f);
  for (int i = 0; i < 200; ++i) {
    const double middle = (low + high) / 2;
    z.p()[1] = middle;
    (hole.energy(z.q(), z.p()) > -0.5 ? low : high) = middle;
  }
  const double t = std::sqrt(2.0) / 3 * (std::pow(r0, 1.5) - 1);  // to r = 1, inside
  integrate(stepper, z, {.dt = 0.03, .t_end = t});
  CHECK(z.q()[1] == Approx(1).epsilon(1e-7));
  CHECK(hole.energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-9));

  const double r = 8, rate = std::pow(r, -1.5), u = 1 / std::sqrt(1 - 3 / r);  // dt/dτ
  // p_μ = g_{μν} u^ν; there u^r = 0, and so p_x = (2/r) u.
  Point y({0, r, 0, 0}, {-(1 - 2 / r) * u, 2 / r * u, r * rate * u, 0});
  CHECK(hole.energy(y.q(), y.p()) == Approx(-0.5).epsilon(1e-14));
  integrate(stepper, y, {.dt = 0.5, .t_end = 2 * pi / (rate * u)});
  CHECK(y.q()[0] == Approx(2 * pi / rate).epsilon(1e-8));
  CHECK((y.q().tail<3>() - Eigen::Vector3d(r, 0, 0)).norm() < 1e-6);
}

TEST_CASE("a straight line stays one in turning coordinates") {
  const geodesics::Geodesic flat(TurningFlat{});
  const Point start = flat.body({0, 2, 0.5, 0}, {0.3, -0.2, 0.8});
  Point z = start;
  auto stepper = stepper_for(Chosen{flat});
  const double t = 6;
  integrate(stepper, z, {.dt = 0.01, .t_end = t});
  // Covariant momenta: p_φ is the angular momentum, the velocity (0.3, 0.4) and -0.2 along z.
  const double angle = z.q()[3] + 0.3 * z.q()[0];
  CHECK(z.q()[1] * std::cos(angle) == Approx(2 + 0.3 * t).epsilon(1e-9));
  CHECK(z.q()[1] * std::sin(angle) == Approx(0.4 * t).epsilon(1e-9));
  CHECK(z.q()[2] == Approx(0.5 - 0.2 * t).epsilon(1e-9));
}

TEST_CASE(
    "a black hole in a magnetic field has Schwarzschild's orbits without, and the right gradient with it") {
  const geodesics::Geodesic none(geodesics::ErnstMetric<double>{}),
      some(geodesics::ErnstMetric<double>{.mass = 1, .field = 0.1});
  const Point z = some.body({0, 7, 1.2, 0}, {0.1, 0.4, 6});
  CHECK(some.energy(z.q(), z.p()) == Approx(-0.5).epsilon(1e-13));
  const auto check = check_gradient(Chosen{some}, z);
  CAPTURE(check);
  CHECK(check.ok());
  Point a, b;
  Scene(none).gradient(z.q(), z.p(), a.q(), a.p());
  Scene(black_hole::Schwarzschild<double>{}).gradient(z.q(), z.p(), b.q(), b.p());
  CHECK((a.vector() - b.vector()).norm() <= 1e-14 * b.vector().norm());
  // At rest on the axis it falls as without the field: there Λ = 1.
  CHECK(some.body({0, 9, 1e-6, 0}, {0, 0, 0}).p()[0] ==
        Approx(none.body({0, 9, 1e-6, 0}, {0, 0, 0}).p()[0]).epsilon(1e-9));
}

TEST_CASE("a body has its energy where g^{00} is zero, and next to where it is") {
  // There p_r = dv/dτ; a body that falls from rest at infinity has E = 1 and dr/dτ = -√(2/r).
  const geodesics::Geodesic hole(Ingoing{});
  for (const double r : {1.0, 2.0, 8.0}) {
    const double fall = std::sqrt(2 / r);
    CHECK(hole.body({0, r, 1, 0}, {1 / (1 + fall), 0, 0}).p()[0] == Approx(-1).epsilon(1e-15));
  }
  const Point round = hole.body({0, 8, 1, 0}, {1.3, 0.4, 2});
  CHECK(hole.energy(round.q(), round.p()) == Approx(-0.5).epsilon(1e-15));
  // With p_r ≤ 0 it would go back in v.
  CHECK(std::isnan(hole.body({0, 8, 1, 0}, {-1.3, 0, 0}).p()[0]));
  CHECK(std::isnan(hole.body({0, 8, 1, 0}, {0, 0, 0}).p()[0]));

  // The same in coordinates (v + ε r, r, θ, φ), ε = -1e-12, whose g^{00} is all but zero.
  const geodesics::Geodesic near([](const auto& x) {
    constexpr double tilt = -1e-12;
    auto g = Ingoing{}(x);
    g(0, 0) = 2 * tilt + tilt * tilt * g(1, 1);
    g(0, 1) = 1 + tilt * g(1, 1);
    return g;
  });
  CHECK(near.body({0, 8, 1, 0}, {1 / 1.5 - 1e-12, 0, 0}).p()[0] == Approx(-1).epsilon(1e-11));
}

}  // namespace test_geodesics
