#include "catch.hpp"

#include <cmath>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_orbits {

// What is known of orbits in closed form or from observation, from runs of scenes.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects::orbits;

template <int Dim>
using Chosen = RuntimeScene<double, Dim>;  // few steppers for all tests: it compiles faster

const double pi = std::acos(-1.0);

/// Steps on until crossing(z) has passed zero upwards `times` times, and leaves z on the last crossing;
/// returns the time. Not in the first step, which may begin on one.
template <class Stepper, class Crossing>
double run_to_crossing(Stepper& stepper, typename Stepper::State& z, double dt, int times,
                       const Crossing& crossing) {
  for (int step = 0;; ++step) {
    const auto before = z;
    REQUIRE(stepper.step(z, dt).ok());
    if (step == 0 || !(crossing(before) < 0 && crossing(z) >= 0) || --times > 0) continue;
    // The secant method on the length of this last step.
    double low = 0, high = dt, f_low = crossing(before), f_high = crossing(z);
    for (int i = 0; i < 20 && std::abs(high - low) > 1e-15 * dt && f_high != f_low; ++i) {
      const double next = high - f_high * (high - low) / (f_high - f_low);
      low = high;
      f_low = f_high;
      high = next;
      z = before;
      if (high != 0) REQUIRE(stepper.step(z, high).ok());
      f_high = crossing(z);
    }
    return step * dt + high;
  }
}

const auto radial = [](const auto& z) { return z.q().dot(z.p()); };

/// By what angle the periapsis turns in `orbits` orbits, from one on the first axis.
double periapsis_advance(const Chosen<2>& scene, const Eigen::Vector4d& start, double dt, int orbits) {
  return with_stepper_for(scene, schemes::sofroniou_spaletta8(), [&](auto& stepper) {
    PhasePoint<double, 2> z;
    z.vector() = start;
    for (int i = 0; i < 3; ++i) stepper.step(z, -dt);  // so that the first periapsis is one of the crossings
    run_to_crossing(stepper, z, dt, 1, radial);
    const double first = std::atan2(z.q()[1], z.q()[0]);
    run_to_crossing(stepper, z, dt, orbits, radial);
    return std::atan2(z.q()[1], z.q()[0]) - first;
  });
}

}  // namespace

TEST_CASE("States near the periapsis of steep orbits have the energy of these, to rounding", "[systems]") {
  for (const double off : {1e-1, 1e-4, 1e-6, 1e-8}) {
    CAPTURE(off);
    for (double mean = 3; mean > 1e-10; mean *= 0.7) {
      const auto z = state_of(
          Elements<double>{
              .a = 1, .e = 1 - off, .inclination = 0.3, .node = 1, .periapsis = 2, .mean_anomaly = mean},
          1.0);
      const auto q = z.q().cast<long double>().eval(), p = z.p().cast<long double>().eval();
      const long double per_a = 2 / q.norm() - p.squaredNorm();
      CHECK(std::abs(static_cast<double>(per_a) - 1) <= 1e-14 / off);  // 2/r is rounded by that
    }
  }
}

TEST_CASE("The eccentric anomaly near the periapsis of nearly parabolic orbits has all digits", "[systems]") {
  const auto mean = [](long double x, long double off) {  // off x + (1 - off) (x - sin x), by its series
    const long double x2 = x * x;
    return off * x + (1 - off) * x * x2 / 6 * (1 - x2 / 20 * (1 - x2 / 42 * (1 - x2 / 72 * (1 - x2 / 110))));
  };
  for (int power = 2; power <= 53; ++power) {
    const double off = std::ldexp(1.0, -power);
    CAPTURE(off);
    for (double x = 0.1; x > 1e-12; x *= 0.3) {
      const double anomaly = eccentric_anomaly(static_cast<double>(mean(x, off)), 1 - off);
      CHECK(std::abs(anomaly / x - 1) <= 1e-15);
      CHECK(eccentric_anomaly(-static_cast<double>(mean(x, off)), 1 - off) == -anomaly);
    }
  }
  CHECK(eccentric_anomaly(0.0, 1 - 1e-9) == 0);
}

TEST_CASE("The elements of an orbit of any length come back, and those of a circle are as documented",
          "[systems]") {
  for (const double a : {1e-300, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e300}) {
    CAPTURE(a);
    const auto z = state_of(
        Elements<double>{
            .a = a, .e = 0.3, .inclination = 0.4, .node = 0.5, .periapsis = 0.6, .mean_anomaly = 0.7},
        1.0);
    const auto back = elements_of<double>(z.q(), z.p(), 1.0);
    CHECK(back.a == Approx(a).epsilon(1e-13));
    CHECK(back.e == Approx(0.3));
    CHECK(back.inclination == Approx(0.4));
    CHECK(back.node == Approx(0.5));
    CHECK(back.periapsis == Approx(0.6));
    CHECK(back.mean_anomaly == Approx(0.7));
  }
  // A quarter of an inclined circle behind its node, and the same in the plane.
  const auto inclined = elements_of<double>({0, 0.6, 0.8}, {-1, 0, 0}, 1.0);
  CHECK(inclined.e == 0);
  CHECK(std::abs(inclined.node) < 1e-15);
  CHECK(inclined.periapsis == Approx(pi / 2));
  CHECK(inclined.mean_anomaly == 0);
  const auto flat = elements_of<double>({0, 1, 0}, {-1, 0, 0}, 1.0);
  CHECK(flat.node == 0);
  CHECK(flat.periapsis == Approx(pi / 2));
}

TEST_CASE("Mercury's perihelion turns by 42.98 arcseconds a century with 1PN and not without", "[systems]") {
  const double gm = 4 * pi * pi, a = 0.38709893, e = 0.20563069, c = 63241.077;  // au, years
  const double year_orbits = std::pow(a, -1.5), speed = std::sqrt(gm / a * (1 + e) / (1 - e));
  const Eigen::Vector4d start(a * (1 - e), 0, 0, speed);
  const int orbits = 100;
  const double arcseconds_a_century = 180 / pi * 3600 * 100 * year_orbits / orbits;
  const double dt = 1 / year_orbits / 100;
  const Chosen<2> newton{Kinetic<double, 2>{}, Attraction<double, 2>{.gm = gm}};
  const Chosen<2> einstein{Kinetic<double, 2>{}, Attraction<double, 2>{.gm = gm},
                           PostNewtonian1<double, 2>{.gm = gm, .c = c}};
  CHECK(std::abs(periapsis_advance(newton, start, dt, orbits) * arcseconds_a_century) < 1e-3);
  CHECK(periapsis_advance(einstein, start, dt, orbits) * arcseconds_a_century == Approx(42.98).margin(0.005));
}

TEST_CASE("The periapsis turns as the second post-Newtonian order says, for any mass ratio", "[systems]") {
  // Damour, Jaranowski, Schäfer (2000), eq. (5.6), in units of GM = 1.
  for (const double nu : {0.0, 0.25}) {
    CAPTURE(nu);
    const double c = 60, c2 = c * c, e0 = 0.4;
    const Chosen<2> scene{Kinetic<double, 2>{}, Attraction<double, 2>{},
                          PostNewtonian1<double, 2>{.c = c, .nu = nu},
                          PostNewtonian2<double, 2>{.c = c, .nu = nu}};
    const PhasePoint<double, 2> start({1 - e0, 0}, {0, std::sqrt((1 + e0) / (1 - e0))});
    const double j = start.q()[0] * start.p()[1], j2 = j * j, energy = scene.energy(start.q(), start.p());
    const double first = 3 / (j2 * c2);
    const double second =
        (15 * (7 - 2 * nu) / (4 * j2 * j2) + 3 * (5 - 2 * nu) * energy / (2 * j2)) / (c2 * c2);
    const double turned = periapsis_advance(scene, start.vector(), 2 * pi / 200, 3) / (3 * 2 * pi);
    CHECK(turned - first == Approx(second).epsilon(0.005));  // the third order is of relative size 1/c²
  }
}

TEST_CASE("A circular orbit of second post-Newtonian order has the energy of its frequency", "[systems]") {
  // E = -x/2 (1 - (9 + ν)x/12 - (81 - 57ν + ν²)x²/24), x = Ω^(2/3). Blanchet, Living Rev. Relativ. 17 (2014)
  // 2, eq. (232).
  const double nu = 0.25, r = 4000;
  const Chosen<2> scene{Kinetic<double, 2>{}, Attraction<double, 2>{}, PostNewtonian1<double, 2>{.nu = nu},
                        PostNewtonian2<double, 2>{.nu = nu}};
  PhasePoint<double, 2> z({r, 0}, {0, 1 / std::sqrt(r)}), g;
  for (int i = 0; i < 50; ++i) {  // the momentum of the circular orbit: p Ω = ∂H/∂r
    scene.gradient(z.q(), z.p(), g.q(), g.p());
    z.p()[1] = (z.p()[1] + g.q()[0] * r / g.p()[1]) / 2;
  }
  scene.gradient(z.q(), z.p(), g.q(), g.p());
  const double x = std::pow(g.p()[1] / r, 2.0 / 3);
  const double excess = scene.energy(z.q(), z.p()) / (-x / 2) - 1 + (9 + nu) / 12 * x;
  CHECK(excess / (x * x) == Approx(-(81 - 57 * nu + nu * nu) / 24).epsilon(0.01));
}

TEST_CASE("Arenstorf's orbit closes and keeps Jacobi's constant", "[systems][long]") {
  const double mu = 0.012277471, period = 17.0652165601579625588917206249,
               speed = -2.00158510637908252240537862224;
  const Chosen<2> scene{Kinetic<double, 2>{}, TwoCentres<double, 2>::restricted(mu),
                        RotatingFrame<double, 2>{}};
  const PhasePoint<double, 2> start({0.994, 0}, {0, speed + 0.994});  // p = v + ω × q
  PhasePoint<double, 2> z = start;
  auto stepper = stepper_for(scene, schemes::low_defect8_s20());
  Invariants invariants(scene);
  const int steps = 40'000;
  integrate(stepper, z, {.dt = period / steps, .steps = steps}, invariants);
  CHECK((z.vector() - start.vector()).norm() < 1e-7);
  CHECK((z.q() - start.q()).norm() < 1e-9);
  CHECK(invariants["energy"].worst < 1e-11);
}

TEST_CASE("The node of an orbit about an oblate centre turns at the known rate", "[systems]") {
  // A GPS satellite, in km and s; Vallado, eq. (9-38): about -14 degrees a year.
  const double gm = 398600.4418, j2 = 1.08262668e-3, radius = 6378.137, a = 26559.7, tilt = 55 * pi / 180;
  const Chosen<3> scene{Kinetic<double, 3>{}, Attraction<double, 3>{.gm = gm},
                        Oblateness<double, 3>{.gm = gm, .j2 = j2, .radius = radius}};
  CHECK(scene.is_separable());
  const double n = std::sqrt(gm / (a * a * a)), speed = n * a;
  PhasePoint<double, 3> z({a, 0, 0}, {0, speed * std::cos(tilt), speed * std::sin(tilt)});
  auto stepper = stepper_for(SeparableRuntimeScene<double, 3>(scene));
  const auto height = [](const auto& at) { return at.q()[2]; };
  const double dt = 2 * pi / n / 60;
  run_to_crossing(stepper, z, dt, 1, height);
  const double before = std::atan2(z.q()[1], z.q()[0]);
  const double time = run_to_crossing(stepper, z, dt, 30, height);
  const double rate = (std::atan2(z.q()[1], z.q()[0]) - before) / time;
  const double known = -1.5 * n * j2 * std::pow(radius / a, 2) * std::cos(tilt);
  CHECK(rate == Approx(known).epsilon(1e-3));
  CHECK(known * 180 / pi * 86400 * 365.25 == Approx(-14.2).epsilon(0.01));
}

TEST_CASE("The spin of the centre drags the node along at the known rate", "[systems]") {
  const double gs = 1e-4, c = 1, tilt = 1.0;
  const Chosen<3> scene{Kinetic<double, 3>{}, Attraction<double, 3>{},
                        SpinOrbit<double, 3>{.gs = gs, .c = c}};
  PhasePoint<double, 3> z({1, 0, 0}, {0, std::cos(tilt), std::sin(tilt)});
  auto stepper = stepper_for(scene);
  const auto height = [](const auto& at) { return at.q()[2]; };
  run_to_crossing(stepper, z, 0.1, 1, height);
  const double before = std::atan2(z.q()[1], z.q()[0]);
  const double time = run_to_crossing(stepper, z, 0.1, 10, height);
  CHECK((std::atan2(z.q()[1], z.q()[0]) - before) / time == Approx(2 * gs).epsilon(2e-3));
}

TEST_CASE("Relativity and oblateness have room in float and cm", "[systems]") {
  const auto gradients = [](auto number) {
    using T = decltype(number);
    const PostNewtonian2<T, 3> second{.gm = T(3.7e26), .c = T(2.998e10), .nu = T(0.25)};
    const Oblateness<T, 3> sun{.gm = T(1.327e26), .j2 = T(2e-7), .radius = T(6.96e10)};
    const Vector<T, 3> q(T(1.2e8), T(-3e7), T(2e7)), p(T(2e8), T(1.6e9), T(-3e8)), far = q * T(1e5);
    Vector<T, 3> by_q = Vector<T, 3>::Zero(), by_p = by_q, by_far = by_q;
    second.add_gradient(q, p, by_q, by_p);
    sun.add_gradient(far, by_far);
    Eigen::Matrix<double, 11, 1> all;
    all << by_q.template cast<double>(), by_p.template cast<double>(), by_far.template cast<double>(),
        static_cast<double>(second.energy(q, p)), static_cast<double>(sun.energy(far));
    return all;
  };
  // Without a limit to speeds there is no relativity.
  CHECK(PostNewtonian2<double, 2>{.c = INFINITY}.energy(Vector<double, 2>(1, 0), Vector<double, 2>(0, 1)) ==
        0);
  const auto in_float = gradients(0.0F), in_double = gradients(0.0);
  for (int i = 0; i < 11; ++i) {
    CAPTURE(i);
    CHECK(in_float[i] == Approx(in_double[i]).epsilon(1e-5));
  }
}

}  // namespace test_orbits
