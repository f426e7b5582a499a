#include "catch.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "refusal.hpp"

namespace test_relativistic_charges {

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using Point = PhasePoint<double, 3>;
using Chosen = RuntimeScene<double, 3>;  // one stepper for all tests: it compiles faster
using std::numbers::pi;

template <class E>
void require_gradient(const E& effect) {
  const Eigen::Vector3d q(0.8, -0.5, 0.6), p(0.3, 1.1, -0.7);
  const auto found = check_gradient(Chosen{effect}, Point(q, p));
  CAPTURE(found);
  CHECK(found.ok());
}

}  // namespace

TEST_CASE("A potential of two components is refused, also where the type does not tell") {
  const charges::MagneticKinetic kinetic(1.0, 1.0, charges::FieldFrom([](const auto& x) {
                                           return std::vector{-x[1] / 2, x[0] / 2};
                                         }));
  const PhasePoint<double, 3> z({1, 0, 0}, {0, 1, 0});
  CHECK(refuses([&] { kinetic.energy(z.q(), z.p()); }, "the potential has 2 components"));
}

TEST_CASE("gradients of fast charges in all fields are those of their energies, and A by itself is enough") {
  const charges::SolenoidField solenoid(0.7, 1.3, 0.4);
  const charges::UndulatorField undulator(0.5, 1.7);
  const charges::QuadrupoleField quadrupole(0.6);
  const charges::BottleField bottle(0.9, 1.7);
  // The same fields by automatic differentiation of A.
  const charges::FieldFrom from([=](const auto& x) {
    using std::cosh, std::sin, std::sqrt;
    const auto u = x[2] + 0.65, v = x[2] - 0.65, r = 0.16 + 0 * u;
    const auto s = u / sqrt(u * u + r) - v / sqrt(v * v + r);
    const auto second = -3 * r *
                        (u / (sqrt(u * u + r) * (u * u + r) * (u * u + r)) -
                         v / (sqrt(v * v + r) * (v * v + r) * (v * v + r)));
    const auto g = 0.35 * (s / 2 - (x[0] * x[0] + x[1] * x[1]) * second / 16);
    return std::array{-g * x[1] + 0.5 / 1.7 * cosh(1.7 * x[1]) * sin(1.7 * x[2]), g * x[0],
                      -0.3 * (x[0] * x[0] - x[1] * x[1])};
  });
  const charges::RelativisticKinetic by_hand(-1.3, 0.7, 2.0, solenoid, undulator, quadrupole);
  const charges::RelativisticKinetic by_duals(-1.3, 0.7, 2.0, from);
  require_gradient(by_hand);
  require_gradient(by_duals);
  require_gradient(charges::RelativisticKinetic(1.0, 2.0, 1.5, bottle, charges::UniformField(0.3)));
  const Eigen::Vector3d q(0.3, -0.5, 0.6), p(0.3, 1.1, -0.7);
  Point a(3), b(3);
  Scene(by_hand).gradient(q, p, a.q(), a.p());
  Scene(by_duals).gradient(q, p, b.q(), b.p());
  CHECK((a.vector() - b.vector()).norm() <= 1e-14 * a.vector().norm());
  charges::FieldSum sum;
  sum.add(solenoid).add(undulator).add(quadrupole);
  Scene(charges::RelativisticKinetic(-1.3, 0.7, 2.0, sum)).gradient(q, p, b.q(), b.p());
  CHECK((a.vector() - b.vector()).norm() <= 1e-15 * a.vector().norm());
  // Slowly it is MagneticKinetic.
  const charges::RelativisticKinetic slow(1.0, 2.0, 1e5, bottle);
  CHECK(slow.energy(q, p) == Approx(charges::MagneticKinetic(1.0, 2.0, bottle).energy(q, p)).epsilon(1e-9));
}

TEST_CASE("a field by automatic differentiation has the precision of the place and the time") {
  const charges::FieldFrom field([](const auto& t, const auto& x) {
    return std::array{0 * t + 0 * x[0], x[0] * x[0] * x[0] / (1 + t * t), 0 * t + 0 * x[0]};
  });
  const long double x = 0.1L, t = 0.7L, v = 1.3L;
  const Vector<long double, 3> at(x, 0, 0), along(0, v, 0);
  Vector<long double, 3> by_x(0, 0, 0), by_t = by_x;
  field.add_gradient(t, at, along, 1.0L, by_x);
  field.add_time_derivative(t, at, by_t);
  const long double rounding = 4 * std::numeric_limits<long double>::epsilon(), slope = 1 + t * t;
  CHECK(std::abs(by_x[0] / (3 * v * x * x / slope) - 1) <= rounding);
  CHECK(std::abs(by_t[1] / (-2 * t * x * x * x / (slope * slope)) - 1) <= rounding);
}

TEST_CASE("at gamma 10 a charge gyrates at eB/(γm) with the radius p/(eB)") {
  const double charge = -1.6, mass = 0.8, c = 2, b = 0.9, gamma = 10;
  const charges::RelativisticKinetic motion(charge, mass, c, charges::UniformField(b));
  const double momentum = mass * c * std::sqrt(gamma * gamma - 1);
  const Eigen::Vector3d at(0.3, -0.2, 0.1), along(0.8, 0, 0.6), pi_0 = momentum * along;
  Point z(at, motion.momentum(at, pi_0));
  CHECK(motion.gamma(z.q(), z.p()) == Approx(gamma).epsilon(1e-14));
  const double rate = std::abs(charge) * b / (gamma * mass), radius = 0.8 * momentum / (std::abs(charge) * b);
  auto stepper = stepper_for(Chosen{motion});
  const double period = 2 * pi / rate;
  Point half = z;
  integrate(stepper, half, {.dt = period / 100, .steps = 50});
  CHECK((half.q() - at).head<2>().norm() == Approx(2 * radius).epsilon(1e-8));
  integrate(stepper, z, {.dt = period / 100, .steps = 300});
  CHECK((z.q() - at - Eigen::Vector3d(0, 0, 3 * period * 0.6 * momentum / (gamma * mass))).norm() <
        1e-7 * radius);
  // Across a field E < cB the drift is E/B at any speed.
  const double e = 0.3;
  Point y(at, motion.momentum(at, pi_0));
  auto across = stepper_for(Chosen{motion, charges::UniformElectric<>{.charge = charge, .x = e}});
  const double t = 400 * period;
  integrate(across, y, {.dt = period / 60, .t_end = t});
  CHECK((y.q() - at)[1] / t == Approx(-e / b).margin(2 * radius / t * 3));
}

TEST_CASE("an undulator wiggles, slows and focuses a charge by the textbook") {
  const double k = 2 * pi, gamma = 50, strength = 1.2;  // c = m = e = 1, K = strength
  const charges::RelativisticKinetic motion(1.0, 1.0, 1.0, charges::UndulatorField(strength * k, k));
  const double p = std::sqrt(gamma * gamma - 1), dt = 0.01, y0 = 1e-4;
  Point z({0, y0, 0}, {0, 0, p});
  double widest = 0, closest = 1;
  auto stepper = stepper_for(Chosen{motion});
  const double focus = strength * k / (std::numbers::sqrt2 * p);
  double t_end = pi / (2 * focus), out = 0;
  integrate(stepper, z, {.dt = dt, .t_end = t_end}, [&](double, const Point& now) {
    widest = std::max(widest, now.q()[0]);
    closest = std::min(closest, now.q()[0]);
    out = std::max(out, std::abs(now.q()[1]));
  });
  CHECK((widest - closest) / 2 == Approx(strength / (p * k)).epsilon(2e-3));
  CHECK(z.q()[2] / t_end == Approx(1 - (1 + strength * strength / 2) / (2 * gamma * gamma)).epsilon(2e-6));
  // A quarter of the slow swing along y: from the start to the axis.
  CHECK(std::abs(z.q()[1]) < 0.02 * y0);
  CHECK(out <= 1.01 * y0);
}

TEST_CASE("a solenoid turns the plane of a ray by Larmor's angle, a quadrupole focuses one plane") {
  const charges::SolenoidField field(0.3, 2.0, 0.2);
  const double gamma = 10, p = std::sqrt(gamma * gamma - 1), z0 = -4, x0 = 1e-3;
  const charges::RelativisticKinetic motion(1.0, 1.0, 1.0, field);
  Point z({x0, 0, z0}, {0, 0, p});  // without canonical angular momentum
  auto stepper = stepper_for(Chosen{motion});
  integrate(stepper, z, {.dt = 0.02, .t_end = 8});
  double angle = std::atan2(z.q()[1], z.q()[0]);
  CHECK(angle == Approx(-field.integral(z0, z.q()[2]) / (2 * p)).epsilon(1e-5));
  CHECK(field.integral(-1e4, 1e4) == Approx(0.3 * 2.0).epsilon(1e-6));
  // Far out s(u) is 1 - R²/(2u²), on either side, and ∫B dz over a short way no difference of large numbers.
  const double near = 999.5 - 1, far = 999.5 + 1;  // of the ends of the solenoid
  const double b = 0.3 / 2 * 0.2 * 0.2 / 2 * (1 / (near * near) - 1 / (far * far));
  for (const double side : {1.0, -1.0})
    CHECK(side * field.integral(side * 999, side * 1000) == Approx(b).epsilon(1e-5).margin(0));
  // A short one from far out on one side to the other.
  CHECK(charges::SolenoidField(0.3, 0.1, 0.2).integral(-1e6, 1e6) ==
        Approx(0.3 * 0.1 * (1 - 0.02 * 1e-12)).epsilon(4e-16).margin(0));
  CHECK(charges::SolenoidField<float>(0.3f, 0.01f, 0.02f).integral(-8e3f, 9e3f) ==
        Approx(0.3f * 0.01f).epsilon(4e-7).margin(0));
  CHECK(field.integral(-0.01, 0.02) + field.integral(0.02, 1.5) == Approx(field.integral(-0.01, 1.5)));
  // Of a point on the axis of the sheet the field is that of its angles.
  CHECK(2 * field.slopes(std::array{0.0, 0.0, 0.4}).g ==
        Approx(0.15 * (1.4 / std::hypot(1.4, 0.2) + 0.6 / std::hypot(0.6, 0.2))));
  // In a float, too, of lengths whose fifth powers have no room there.
  for (const double unit : {1.0, 1e8, 1e9}) {
    const auto slopes = [unit](auto one) {
      using Scalar = decltype(one);
      const auto length = [unit](double x) { return static_cast<Scalar>(x * unit); };
      const charges::SolenoidField<Scalar> of_size(Scalar(0.3), length(2), length(0.2));
      const auto at = of_size.slopes(std::array{length(0.05), length(0.02), length(0.9)});
      return Eigen::Vector4d(at.g, at.by_x * unit, at.by_y * unit, at.by_z * unit);
    };
    CHECK((slopes(1.0F).array() / slopes(1.0).array() - 1).abs().maxCoeff() < 1e-5);
  }

  const double g = 0.5, root = std::sqrt(g / p);
  const charges::RelativisticKinetic focusing(1.0, 1.0, 1.0, charges::QuadrupoleField(g));
  Point y({x0, x0, 0}, {0, 0, p});
  auto through = stepper_for(Chosen{focusing});
  integrate(through, y, {.dt = 0.05, .t_end = 4});
  CHECK(y.q()[0] == Approx(x0 * std::cos(root * y.q()[2])).epsilon(1e-5));
  CHECK(y.q()[1] == Approx(x0 * std::cosh(root * y.q()[2])).epsilon(1e-5));
}

TEST_CASE("a cosmic ray of 10 GV turns back where Stoermer's forbidden region begins") {
  // In the equator v_phi/v = b/r - C²/r², C² = eM/p, for an impact parameter b: it turns where that is ±1.
  const double radius = 6378137, moment = -3.12e-5 * std::pow(radius, 3), c = 299792458;
  const double rigidity = 10e9 / c, stoermer2 = -moment / rigidity;  // T m, m²
  CHECK(std::sqrt(stoermer2) / radius == Approx(2.44).epsilon(0.01));
  // Momenta in units of mc, for a proton; lengths in Earth radii.
  const double rest = 0.93827208e9, p = 10e9 / rest,
               field = moment / std::pow(radius, 3) / rigidity * p * radius;
  const charges::RelativisticKinetic motion(1.0, 1.0, 1.0, charges::DipoleField(field));
  for (const double b : {-2.0, 0.0, 3.0}) {
    CAPTURE(b);
    const double far = 60;
    const Eigen::Vector3d at(far, b, 0), kinetic(-p, 0, 0);
    Point z(at, motion.momentum(at, kinetic));
    const double angular = z.q()[0] * z.p()[1] - z.q()[1] * z.p()[0];  // is kept: L/p = rv_phi/v + eM/(pr)
    const double l = angular / p, c2 = -field / p;
    double nearest = far;
    auto stepper = stepper_for(Chosen{motion});
    integrate(stepper, z, {.dt = 0.02, .t_end = 130},
              [&](double, const Point& now) { nearest = std::min(nearest, now.q().norm()); });
    // |l r + c2| = r²: the largest root on the way in.
    double turning = 0;
    for (const double sign : {-1.0, 1.0}) {
      const double root = l * l / 4 + sign * c2;
      if (root < 0) continue;
      for (const double which : {-1.0, 1.0}) {
        const double r = sign * l / 2 + which * std::sqrt(root);
        if (r < far / 2) turning = std::max(turning, r);
      }
    }
    CHECK(turning > 1);
    CHECK(nearest == Approx(turning).epsilon(1e-4));
    CHECK(nearest >= turning * (1 - 1e-9));
  }
}

TEST_CASE("in a plane wave γ - p_z and the canonical momentum are kept") {
  const double a0 = 0.8, k = 2, phase = 0.3;
  const charges::FieldFrom wave([=](const auto& t, const auto& x) {
    using std::cos;
    return std::array{0 * t + 0 * x[2], a0 * cos(k * (x[2] - t) + phase), 0 * t + 0 * x[2]};
  });
  const charges::RelativisticCharge charge(1.0, 1.0, 1.0, wave, charges::UniformField(0.0));
  const Autonomous K(charge);
  auto stepper = Semiexplicit(K, schemes::low_defect6_s13<double>());
  const Point start({0.1, 0, 0.2}, {0.05, 0.2, -0.1});
  auto Z = K.extended(start, 0.0);
  Invariants invariants(K);
  const double lightlike = charge.gamma(0, start.q(), start.p()) - start.p()[2];
  integrate(stepper, Z, {.dt = 0.02, .t_end = 20}, invariants);
  const Point z = K.point(Z);
  CHECK(invariants["energy"].worst < 1e-9);
  CHECK(charge.gamma(20, z.q(), z.p()) - z.p()[2] == Approx(lightlike).epsilon(1e-9));
  CHECK(z.p()[1] == Approx(start.p()[1]).epsilon(1e-13));
  CHECK(z.p()[2] != Approx(start.p()[2]).epsilon(1e-2));
  CHECK(check_gradient(K, Z).ok());
}

TEST_CASE("fast charges in float and SI units are as fast as in double") {
  const auto electron = []<class Scalar>(Scalar) {
    return charges::RelativisticKinetic(Scalar(-1.602e-19), Scalar(9.109e-31), Scalar(2.998e8));
  };
  const auto rough = electron(1.f);
  const auto exact = electron(1.0);
  for (const double size : {1e-24, 1e-22, 1e-20}) {
    CAPTURE(size);
    const Eigen::Vector3d q(1, 2, 3), p(0.6 * size, 0, 0.8 * size);
    const Eigen::Vector3f qf = q.cast<float>(), pf = p.cast<float>();
    CHECK(rough.gamma(qf, pf) == Approx(exact.gamma(q, p)).epsilon(1e-6));
    CHECK(rough.energy(qf, pf) == Approx(exact.energy(q, p)).epsilon(1e-6));
    CHECK((rough.velocity(qf, pf).cast<double>() - exact.velocity(q, p)).norm() <
          1e-6 * exact.velocity(q, p).norm());
  }
}

}  // namespace test_relativistic_charges
