#include "catch.hpp"

#include <algorithm>
#include <cmath>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_charges {

// Charges in fields, against closed forms.

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using Point = PhasePoint<double, 3>;
using Chosen = RuntimeScene<double, 3>;  // one stepper for all tests: it compiles faster

const double pi = std::acos(-1.0);

}  // namespace

TEST_CASE("A charge turns at the gyrofrequency, and drifts at E × B/B²", "[systems]") {
  const double charge = -1.6, mass = 0.8, b = 0.9, ex = 0.05;
  const charges::MagneticKinetic motion(charge, mass, charges::UniformField(b));
  const Chosen scene{motion, charges::UniformElectric<>{.charge = charge, .x = ex}};
  CHECK(!scene.is_separable());
  const Eigen::Vector3d at(0.3, -0.2, 0.1), v(0.7, 0.2, 0.4);
  Point z(at, motion.momentum(at, v));
  auto stepper = stepper_for(scene);
  const double period = 2 * pi * mass / (std::abs(charge) * b);
  integrate(stepper, z, {.dt = period / 100, .steps = 300});
  // After whole turns the velocity is back, and what is left of the way is the drift.
  const Eigen::Vector3d drift(0, -ex / b, v[2]);
  CHECK((z.q() - at - 3 * period * drift).norm() <= 1e-7);
  CHECK((motion.velocity(z.q(), z.p()) - v).norm() <= 1e-7);
  // Half a turn from a start without a field: across by the diameter.
  Point half(at, motion.momentum(at, v));
  auto plain = stepper_for(Chosen{motion});
  integrate(plain, half, {.dt = period / 100, .steps = 50});
  const double omega = charge * b / mass;
  CHECK(half.q()[0] - at[0] == Approx(2 * v[1] / omega).epsilon(1e-7));
  CHECK(half.q()[1] - at[1] == Approx(-2 * v[0] / omega).epsilon(1e-7));
}

TEST_CASE("A charge in a Penning trap has the three known rates", "[systems]") {
  const double k = 0.6, b = 3, lower = b / 2 - std::sqrt(b * b / 4 - k / 2);
  const charges::MagneticKinetic motion(1.0, 1.0, charges::UniformField(b));
  const Chosen scene{motion, charges::Quadrupole<>{.k = k}};
  // The slow motion alone: a circle at the lower rate, clockwise for a positive charge.
  const Eigen::Vector3d at(1, 0, 0.5), v(0, -lower, 0);
  Point z(at, motion.momentum(at, v));
  auto stepper = stepper_for(scene);
  const double t = 20;
  integrate(stepper, z, {.dt = 0.02, .steps = 1000});
  CHECK(z.q()[0] == Approx(std::cos(lower * t)).margin(1e-8));
  CHECK(z.q()[1] == Approx(-std::sin(lower * t)).margin(1e-8));
  CHECK(z.q()[2] == Approx(0.5 * std::cos(std::sqrt(k) * t)).margin(1e-8));
}

TEST_CASE("A magnetic bottle throws a charge back where its moment says", "[systems]") {
  const double b = 200, length = 1, v_across = 0.8, v_along = 0.5;  // gyroradius 0.004
  const charges::MagneticKinetic motion(1.0, 1.0, charges::BottleField(b, length));
  const Chosen scene{motion};
  const Eigen::Vector3d at(v_across / b, 0, 0), v(0, -v_across, v_along);  // about the axis
  Point z(at, motion.momentum(at, v));
  auto stepper = stepper_for(scene);
  const double period = 2 * pi * length / v_across, dt = 2 * pi / b / 20;
  double highest = 0;
  const auto steps = static_cast<std::int64_t>(std::llround(1.25 * period / dt));
  double before = 0, t_before = 0, back = 0;  // of the upward crossing of the middle
  integrate(stepper, z, {.dt = dt, .steps = steps}, [&](double t, const Point& now) {
    highest = std::max(highest, now.q()[2]);
    if (before < 0 && now.q()[2] >= 0) back = t_before - before * (t - t_before) / (now.q()[2] - before);
    before = now.q()[2];
    t_before = t;
  });
  CHECK(highest == Approx(length * v_along / v_across).epsilon(1e-4));
  CHECK(back == Approx(period).epsilon(1e-4));
}

TEST_CASE("An electron in SI units has an energy, in float", "[systems]") {
  const charges::Kinetic<float> electron{.mass = 9.109e-31F};
  const Vector<float, 3> p(9.109e-25F, 0, 0);  // of 1e6 m/s
  CHECK(electron.energy(p) == Approx(4.5545e-19).epsilon(1e-5));
}

}  // namespace test_charges
