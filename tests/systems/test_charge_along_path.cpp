#include "catch.hpp"
#include "refusal.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

namespace test_charge_along_path {

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using std::numbers::pi;
using Column = Eigen::Vector3d;

/// A light wave along the third axis, A = (0, a cos(k(z - ct) + φ), 0).
constexpr double wave_number = 2.3, wave_phase = 0.4;
struct Wave {
  double a, c;
  auto operator()(const auto& t, const auto& x) const {
    using std::cos;
    const auto zero = 0 * t + 0 * x[2];
    return std::array{zero, a * cos(wave_number * (x[2] - c * t) + wave_phase), zero};
  }
};

/// All kinds of fields at once, each of which may be zero: few types, which compile in little time.
struct Strengths {
  double solenoid = 0, undulator = 0, quadrupole = 0, bend = 0, wave = 0, electric = 0;
};
constexpr double undulator_number = 2 * pi, charge = -1.3, mass = 0.7, c = 2;

template <template <class, class...> class Motion, class... Line>
auto in_fields(const Strengths& of, const Line&... line) {
  double curvature = 0;
  if constexpr (sizeof...(Line) == 1) curvature = (line.curvature, ...);
  const charges::SolenoidField solenoid(of.solenoid, 1.1, 0.3);
  const charges::UndulatorField undulator(of.undulator, undulator_number);
  const charges::QuadrupoleField quadrupole(of.quadrupole);
  const charges::BendField bend(of.bend, curvature);
  const charges::FieldFrom wave(Wave{of.wave, c});
  const charges::UniformElectric<> electric{.charge = charge, .x = of.electric / 2, .y = 0, .z = of.electric};
  return Motion(charge, mass, c, line..., solenoid, undulator, quadrupole, bend, wave, electric);
}
auto along(const Strengths& of, const charges::ReferenceLine<>& line = {}) {
  return in_fields<charges::ChargeAlongPath>(of, line);
}
using Along = decltype(along({}));
using AtTime = Along::AtTime;

/// From where a charge is at a time to where it is at s.
AtTime run_along(const Along& line, const AtTime& start, double s_end, double ds) {
  const auto [s, z] = line.on_line(start);
  const Autonomous K(line);
  auto Z = K.extended(z, s);
  Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
  integrate(stepper, Z, {.dt = ds, .t0 = s, .t_end = s_end});
  return line.at_time(s_end, K.point(Z));
}

/// The same on a straight line by steps in time and dense output.
AtTime run_in_time(const Strengths& of, const AtTime& start, double z_end, double dt) {
  const auto motion = in_fields<charges::RelativisticCharge>(of);
  const Autonomous K(motion);
  auto Z = K.extended({start.q, motion.momentum(start.t, start.q, start.momentum)}, start.t);
  Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
  AtTime end{};
  auto there = poincare_section(
      K, [z_end](const auto& q, const auto&) { return q[2] - z_end; },
      [&](double t, const PhasePoint<double, 3>& z) {
        end = {t, z.q(), motion.kinetic(t, z.q(), z.p())};
        return false;
      },
      {.nodes = 6});
  integrate(stepper, Z, {.dt = dt, .t0 = start.t, .t_end = start.t + 100 * z_end / c}, there);
  REQUIRE(there.count() == 1);
  return end;
}

void require_same(const AtTime& found, const AtTime& expected, double tolerance) {
  CAPTURE(found.t, expected.t, found.q, expected.q, found.momentum, expected.momentum);
  CHECK(std::abs(found.t - expected.t) <= tolerance * std::abs(expected.t));
  CHECK((found.q - expected.q).norm() <= tolerance * expected.q.norm());
  CHECK((found.momentum - expected.momentum).norm() <= tolerance * expected.momentum.norm());
}

/// (2/π) K(m), an elliptic integral, by the arithmetic-geometric mean.
long double elliptic(long double m) {
  long double a = 1, b = std::sqrt(1 - m);
  for (int i = 0; i < 10; ++i) {
    const long double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return 1 / a;
}

}  // namespace

TEST_CASE(
    "the gradient along a path is that of the textbook's square root, on a curved line in driven fields") {
  const double kappa = 0.4, beta = 0.8;
  const Strengths of{
      .solenoid = 0.6, .undulator = 0.5, .quadrupole = 0.7, .bend = 0.4, .wave = 0.3, .electric = 0.2};
  const Along line = along(of, {.curvature = kappa, .beta = beta});
  const Autonomous K(line);
  // The same fields, each from its formula.
  const Autonomous textbook(from_energy<3>([=](const auto& s, const auto& q, const auto& p) {
    using std::cos, std::cosh, std::sin, std::sqrt;
    const auto &x = q[0], &y = q[1];
    const auto t = (q[2] + s / beta) / c;
    const auto h = 1 + kappa * x;
    const auto u = s + 0.55, v = s - 0.55, r = 0.09 + 0 * s;
    const auto second = -3 * r *
                        (u / (sqrt(u * u + r) * (u * u + r) * (u * u + r)) -
                         v / (sqrt(v * v + r) * (v * v + r) * (v * v + r)));
    const auto turn =
        of.solenoid / 2 * ((u / sqrt(u * u + r) - v / sqrt(v * v + r)) / 2 - (x * x + y * y) * second / 16);
    const double k = undulator_number;
    const auto a_x = -turn * y + of.undulator / k * cosh(k * y) * sin(k * s);
    const auto a_y = turn * x + of.wave * cos(wave_number * (s - c * t) + wave_phase);
    const auto a_s = -of.quadrupole / 2 * (x * x - y * y) - of.bend * (x + kappa * x * x / 2) / h;
    const auto total = mass * c * c - c * p[2] + charge * of.electric * (x / 2 + s);
    const auto px = p[0] - charge * a_x, py = p[1] - charge * a_y;
    return -h * (charge * a_s + sqrt(total * total / (c * c) - mass * mass * c * c - px * px - py * py)) -
           p[2] / beta;
  }));
  for (const double s : {-0.3, 0.2, 5.1}) {
    CAPTURE(s);
    const auto Z = K.extended({{0.2, -0.15, 0.3}, {0.4, -0.3, -9.0}}, s);
    CHECK(K.energy(Z.q(), Z.p()) == Approx(textbook.energy(Z.q(), Z.p())).margin(1e-13));
    PhasePoint<double, 4> found(4), expected(4);
    K.gradient(Z.q(), Z.p(), found.q(), found.p());
    textbook.gradient(Z.q(), Z.p(), expected.q(), expected.p());
    CAPTURE(found.vector(), expected.vector());
    CHECK((found.vector() - expected.vector()).norm() <= 1e-13 * expected.vector().norm());
    CHECK(check_gradient(K, Z).ok());
  }
  // Fields chosen at run time.
  const charges::QuadrupoleField quadrupole(0.7);
  charges::FieldSum chosen;
  chosen.add(quadrupole);
  const auto gradient = [&](const auto& field) {
    const Autonomous by(charges::ChargeAlongPath(charge, mass, c, charges::ReferenceLine<>{}, field));
    PhasePoint<double, 4> out(4);
    by.gradient(Eigen::Vector4d(0.2, -0.15, 0.3, 1), Eigen::Vector4d(0.4, -0.3, -9, 0), out.q(), out.p());
    return out;
  };
  CHECK(gradient(chosen).vector() == gradient(quadrupole).vector());
}

TEST_CASE("a bend along a line of another curvature is refused, also among fields chosen at run time") {
  const auto check = [](const auto& of, bool refused) {
    const double curvature = 0.2;
    const charges::ReferenceLine<> line{.curvature = curvature};
    const auto said = [&](const auto& make) {
      CHECK(says(refusal(make), refused ? "BendField: its curvature is not that of the line" : accepted));
    };
    said([&] {
      charges::ChargeAlongPath(1.0, 1.0, 1.0, line, charges::UniformField(1.0), of(curvature / 2));
    });
    said([&] { charges::ChargeAlongPath(1.0, 1.0, 1.0, line, of(0.0)); });
    said([&] { charges::ChargeAlongPath(1.0, 1.0, 1.0, charges::ReferenceLine<>{}, of(curvature)); });
    said([&] { charges::RelativisticCharge(1.0, 1.0, 1.0, of(curvature)); });
    said([&] { charges::RelativisticKinetic(1.0, 1.0, 1.0, of(curvature)); });
    said([&] { charges::MagneticKinetic(1.0, 1.0, of(curvature)); });
    CHECK(refusal([&] {
            charges::ChargeAlongPath(1.0, 1.0, 1.0, line, of(curvature));
            // The rounding of a float does not matter.
            charges::ChargeAlongPath(1.0, 1.0, 1.0, charges::ReferenceLine<>{.curvature = double(0.2f)},
                                     of(curvature));
            charges::RelativisticCharge(1.0, 1.0, 1.0, of(0.0));
            charges::RelativisticKinetic(1.0, 1.0, 1.0, of(0.0));
            charges::MagneticKinetic(1.0, 1.0, of(0.0));
          }) == accepted);
  };
  check([](double curvature) { return charges::BendField(2.0, curvature); }, true);
  check(
      [](double curvature) {
        charges::FieldSum fields;
        fields.add(charges::QuadrupoleField(0.7)).add(charges::BendField(2.0, curvature));
        return fields;
      },
      true);
  check([](double) { return charges::QuadrupoleField(0.7); }, false);
}

TEST_CASE("a sum of fields that was moved from still holds them") {
  charges::FieldSum fields, assigned;
  fields.add(charges::UniformField(0.5));
  const charges::FieldSum moved(std::move(fields));
  assigned = std::move(fields);
  const Eigen::Vector3d x(1, 2, 3);
  CHECK_FALSE(fields.empty());
  CHECK(fields.potential(x) == Eigen::Vector3d(-0.5, 0.25, 0));
}

TEST_CASE("a drift along a path is exact, for charges slow and fast, behind any clock") {
  for (const double momentum : {1e-6, 1.0, 1e6})
    for (const double beta : {0.5, 1.0, std::numeric_limits<double>::infinity()}) {
      CAPTURE(momentum, beta);
      const Along line = along({}, {.beta = beta});
      const double rest = mass * c, energy = std::hypot(rest, momentum);  // over c
      const Column along_ray = momentum * Column(0.02, -0.01, std::sqrt(1 - 5e-4));
      const AtTime start{0.3, {1e-3, 2e-3, 0.5}, along_ray};
      const AtTime end = run_along(line, start, 40.5, 4);
      const double way = 40 * momentum / along_ray[2];
      require_same(end,
                   {0.3 + way * energy / momentum / c, start.q + 40 / along_ray[2] * along_ray, along_ray},
                   1e-12);
      const auto from = line.on_line(start), to = line.on_line(end);
      const double behind = beta == 1 ? way * (rest * rest / (energy + momentum)) / momentum + (way - 40)
                                      : way * energy / momentum - 40 / beta;
      CHECK(to.z.q()[2] - from.z.q()[2] == Approx(behind).epsilon(1e-11));
      CHECK(to.z.p()[2] == Approx(from.z.p()[2]).epsilon(1e-14));
    }
}

TEST_CASE("a state on the line and the state of that charge at a time are made of each other") {
  const Strengths of{.solenoid = 0.6, .undulator = 0.5, .quadrupole = 0.7, .wave = 0.3, .electric = 0.2};
  for (const double curvature : {0.0, 0.4, -0.3, 1e-9}) {
    CAPTURE(curvature);
    const Along line = along(of, {.curvature = curvature, .beta = 0.9});
    const AtTime charge_at{1.7, {0.3, -0.2, 0.8}, {0.5, -0.4, 3.0}};
    const auto [s, z] = line.on_line(charge_at);
    require_same(line.at_time(s, z), charge_at, 1e-14);
    CHECK(line.time(s, z.q()) == Approx(1.7).epsilon(1e-14));
    const auto motion = in_fields<charges::RelativisticCharge>(of);
    const Column p = motion.momentum(1.7, charge_at.q, charge_at.momentum);
    CHECK(line.gamma(s, z.q(), z.p()) == Approx(motion.gamma(1.7, charge_at.q, p)).epsilon(1e-14));
    if (curvature == 0) {
      CHECK((z.p().head<2>() - p.head<2>()).norm() <= 1e-15);
      CHECK(z.p()[2] == Approx(-motion.energy(1.7, charge_at.q, p) / c).epsilon(1e-14));
    }
    CHECK_THROWS_AS(line.on_line({0, charge_at.q, {0, 0, -1}}), std::invalid_argument);
  }
  CHECK_THROWS_AS(along({}, {.beta = 0}), std::invalid_argument);
  CHECK_THROWS_AS(along({}, {.curvature = std::nan("")}), std::invalid_argument);
}

TEST_CASE("along the path through magnets a charge comes where steps in time bring it") {
  const AtTime start{0.2, {0.02, -0.03, -1.0}, {0.01, 0.02, 6}};
  const auto compare = [&](const Strengths& of, double ds, double dt) {
    require_same(run_along(along(of), start, 2, ds), run_in_time(of, start, 2, dt), 1e-9);
  };
  SECTION("a quadrupole") { compare({.quadrupole = 1.5}, 0.05, 0.02); }
  SECTION("an undulator") { compare({.undulator = 4}, 0.02, 0.005); }
  SECTION("a solenoid with soft edges, end to end") { compare({.solenoid = 2}, 0.02, 0.005); }
  SECTION("a bending magnet, along a straight line") { compare({.bend = 0.8}, 0.05, 0.02); }
  SECTION("a light wave in an electric field") { compare({.wave = 0.7, .electric = 0.5}, 0.02, 0.005); }
}

TEST_CASE("on a curved line a charge moves on the helix of a uniform field, and the reference orbit stays") {
  const double b = -0.9, momentum = 5, kappa = charge * b / momentum, rest = mass * c;
  const charges::ReferenceLine<> bend{.curvature = kappa, .beta = momentum / std::hypot(momentum, rest)};
  const Along line = along({.bend = b}, bend);
  const double s_end = 1.2 / kappa;
  const AtTime reference = run_along(line, {0, {0, 0, 0}, {0, 0, momentum}}, s_end, 0.1);
  const auto [s, z] = line.on_line(reference);
  CHECK(z.q().norm() <= 1e-13);
  CHECK(z.p().head<2>().norm() <= 1e-13);
  CHECK(s == Approx(s_end).epsilon(1e-14));
  // Another one: a circle about a point of the plane, with a constant speed upwards.
  const AtTime start{0, {0.2, 0.1, 0}, {0.7, 0.4, 4.5}};
  const double across = std::hypot(0.7, 4.5), radius = across / (charge * b);
  const Column centre = start.q - radius / across * Column(4.5, 0, -0.7);
  const AtTime end = run_along(line, start, s_end, 0.1);
  CHECK(std::hypot(end.q[0] - centre[0], end.q[2] - centre[2]) == Approx(radius).epsilon(1e-11));
  const auto direction = [&](const AtTime& at) {
    return std::atan2(at.q[2] - centre[2], at.q[0] - centre[0]);
  };
  const double turned = direction(end) - direction(start);
  CHECK(turned == Approx(1.2).margin(0.3));
  const double energy = std::sqrt(rest * rest + start.momentum.squaredNorm());
  CHECK(end.t == Approx(turned * radius / across * energy / c).epsilon(1e-10));
  CHECK(end.q[1] == Approx(0.1 + turned * radius / across * 0.4).epsilon(1e-10));
  // It is at the angle of s_end to the line's centre, (-1/κ, 0, 0).
  CHECK(std::atan2(end.q[2], end.q[0] + 1 / kappa) == Approx(1.2).epsilon(1e-13));
}

TEST_CASE(
    "a curved line and a straight one through the same field that depends on the time show the same charge") {
  const double kappa = 0.6;
  const auto cartesian = [](const auto& t, const auto& x, const auto& y, const auto& z) {
    using std::cos, std::sin;
    return std::array{sin(2 * z - t) * cos(y), x * z / 2 + 0 * t, sin(x + y) * cos(t) - z * y / 3};
  };
  const charges::FieldFrom field(
      [=](const auto& t, const auto& x) { return cartesian(t, x[0], x[1], x[2]); });
  const charges::FieldFrom in_curved_axes([=](const auto& t, const auto& x) {
    using std::cos, std::sin;
    const auto cosine = cos(kappa * x[2]), sine = sin(kappa * x[2]);
    const auto radius = x[0] + 1 / kappa;
    const auto [a, b, d] = cartesian(t, radius * cosine - 1 / kappa, x[1], radius * sine);
    return std::array{cosine * a + sine * d, b, cosine * d - sine * a};
  });
  const charges::ChargeAlongPath straight(charge, mass, c, charges::ReferenceLine<>{}, field);
  const charges::ChargeAlongPath curved(
      charge, mass, c, charges::ReferenceLine<>{.curvature = kappa, .beta = 0.9}, in_curved_axes);
  const auto run = [](const auto& line, const auto& start, double s_end) {
    const auto [s, z] = line.on_line({start.t, start.q, start.momentum});
    const Autonomous K(line);
    auto Z = K.extended(z, s);
    GaussLegendre stepper(K, {.stages = 6});
    integrate(stepper, Z, {.dt = 0.02, .t0 = s, .t_end = s_end});
    return line.at_time(s_end, K.point(Z));
  };
  const AtTime start{0.7, {0.1, -0.2, 0.05}, {0.5, 0.6, 5}};
  const auto on_curve = run(curved, start, 0.9);
  CHECK(std::abs(on_curve.q[0] - start.q[0]) > 0.02);
  const auto on_straight = run(straight, start, on_curve.q[2]);
  require_same({on_curve.t, on_curve.q, on_curve.momentum},
               {on_straight.t, on_straight.q, on_straight.momentum}, 1e-12);
}

TEST_CASE("in an undulator a charge falls behind light by a wavelength of its radiation a period") {
  for (const double gamma : {30.0, 3e4}) {
    CAPTURE(gamma);
    const double strength = 1.4, rest = mass * c, p = rest * std::sqrt(gamma * gamma - 1);
    const Along line = along({.undulator = strength * rest * undulator_number / charge});
    const int periods = 10;
    const AtTime start{0, {0, 0, 0}, {0, 0, p}};
    const auto [s, z] = line.on_line(start);
    const Autonomous K(line);
    auto Z = K.extended(z, s);
    Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
    integrate(stepper, Z, {.dt = 0.02, .t_end = periods});
    const double found = K.point(Z).q()[2] / periods;  // the period is 1
    CHECK(found ==
          Approx((1 + strength * strength / 2) / (2 * gamma * gamma)).epsilon(2 / gamma / gamma + 1e-8));
    // Exactly, (γ/√(γ² - 1)) (2/π) K(m) - 1 with m = K²/(γ² - 1). This difference loses as many digits as γ²
    // has, the run none.
    const long double u2 = static_cast<long double>(gamma) * gamma - 1;
    const auto exact = static_cast<double>(gamma / std::sqrt(u2) * elliptic(strength * strength / u2) - 1);
    CHECK(found == Approx(exact).epsilon(1e-18 * gamma * gamma + 1e-12));
  }
}

TEST_CASE(
    "an electric field along the line gives its work to the charge, and stops one that runs against it") {
  const double field = 0.9, force = charge * field, rest = mass * c;
  const Along line = along({.electric = field});
  // Away from the axis there is a force along x, too, of half the size.
  const AtTime start{0, {0, 0, 0}, {0, 0, 4}};
  const AtTime end = run_along(line, start, 0.5, 0.02);
  CHECK(end.momentum[2] == Approx(4 + force * end.t).epsilon(1e-10));
  CHECK(end.momentum[0] == Approx(force / 2 * end.t).epsilon(1e-10));
  const double work = c * (std::hypot(rest, end.momentum.norm()) - std::hypot(rest, 4));
  CHECK(work == Approx(force * (0.5 + end.q[0] / 2)).epsilon(1e-10));

  // The momentum along the line is used up at the time 4/|force|.
  const Autonomous K(line);
  auto Z = K.extended(line.on_line(start).z, 0.0);
  Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
  const IntegrationReport run =
      integrate(stepper, Z, {.dt = 0.01, .on_failure = OnFailure::stop, .t_end = 100});
  CAPTURE(run.t, describe(run.status));
  CHECK(run.status == Status::not_finite);
  const auto last = line.at_time(K.time(Z), K.point(Z));
  CHECK(last.t == Approx(4 / std::abs(force)).epsilon(0.05));
  CHECK(last.momentum[2] > 0);
  // Behind that point there is no state of this energy.
  PhasePoint<double, 4> beyond = Z, gradient(4);
  beyond.q()[3] += 1;
  CHECK(std::isnan(K.energy(beyond.q(), beyond.p())));
  CHECK(stepper.step(beyond, 0.01).status == Status::not_finite);
  // Nor of less than no energy, nor beyond the centre of curvature.
  for (const auto& [x, p_l] : {std::array{0.0, 30.0}, std::array{-3.0, -30.0}}) {
    const Autonomous curved(along({}, {.curvature = 0.5}));
    CHECK(std::isnan(curved.energy(Eigen::Vector4d(x, 0, 0, 0), Eigen::Vector4d(0, 0, p_l, 0))));
  }
}

TEST_CASE("steps back along the path undo the steps forth") {
  const Strengths of{.solenoid = 2, .undulator = 3, .quadrupole = 0.7, .wave = 0.3, .electric = 0.2};
  const Autonomous K(along(of));
  const auto start = K.extended({{0.02, -0.03, 0.1}, {0.1, 0.2, -9.0}}, -0.7);
  auto Z = start;
  Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
  integrate(stepper, Z, {.dt = 0.02, .steps = 70});
  CHECK((Z.vector() - start.vector()).norm() >= 0.1);
  integrate(stepper, Z, {.dt = -0.02, .steps = 70});
  CHECK((Z.vector() - start.vector()).norm() <= 1e-11);
}

TEST_CASE("a charge in magnets is followed along the path by float, to its rounding") {
  const auto end = [](auto one) {
    using Scalar = decltype(one);
    const Scalar strength = 3;
    const Autonomous K(charges::ChargeAlongPath(one, one, one, charges::ReferenceLine<Scalar>{},
                                                charges::UndulatorField(strength, Scalar(6)),
                                                charges::QuadrupoleField(strength)));
    auto Z = K.extended({{Scalar(0.02), Scalar(0.01), 0}, {Scalar(0.1), Scalar(0.2), -9}}, Scalar(0));
    Semiexplicit stepper(K, schemes::low_defect6_s13<Scalar>());
    integrate(stepper, Z, {.dt = Scalar(0.03125), .steps = 64});
    return Vector<double, 6>(K.point(Z).vector().template cast<double>());
  };
  const Vector<double, 6> found = end(1.0F), expected = end(1.0);
  CAPTURE(found, expected);
  CHECK((found - expected).norm() <= 2e-6 * expected.norm());
  CHECK((found - expected).head<3>().norm() <= 5e-6 * expected.head<3>().norm());
}

TEST_CASE("far along the line and at a late time a charge moves as at the start") {
  const AtTime start{0, {0.02, -0.03, 0}, {0.01, 0.02, 1}};
  const double beta = start.momentum.norm() / std::hypot(start.momentum.norm(), mass * c);
  const Along line = along({.quadrupole = 0.5, .bend = 0.1}, {.beta = beta});
  const AtTime near = run_along(line, start, 2, 0.05);
  const double far = 1 << 24, late = far / (beta * c);
  const AtTime end = run_along(line, {late, start.q + Column(0, 0, far), start.momentum}, far + 2, 0.05);
  CHECK((end.q - Column(0, 0, far) - near.q).norm() <= 1e-13);
  CHECK((end.momentum - near.momentum).norm() <= 1e-13);
  CHECK(end.t - late == Approx(near.t).margin(4e-16 * late));
}

TEST_CASE("cells of quadrupoles with hard edges focus a charge near the axis as their matrices do") {
  const double momentum = 12, g = 3.5, length = 0.4, gap = 1.1,
               k = std::sqrt(std::abs(charge) * g / momentum);
  const auto magnet = [&](double gradient) {
    return Semiexplicit(Autonomous(along({.quadrupole = gradient})), schemes::low_defect6_s13<double>());
  };
  struct Element {
    decltype(magnet(0)) stepper;
    double length;
  };
  std::vector<Element> cell{{magnet(g), length}, {magnet(0), gap}, {magnet(-g), length}, {magnet(0), gap}};
  const Along drift = along({});
  const auto through = [&](const Column& q, const Column& of_motion) {
    auto Z = Autonomous(drift).extended(drift.on_line({0, q, of_motion}).z, 0.0);
    for (Element& one : cell) {
      const double s = Z.q()[3];
      integrate(one.stepper, Z, {.dt = 0.05, .t0 = s, .t_end = s + one.length});
    }
    return Z;
  };
  const double tiny = 1e-5;
  const auto by_x = through({tiny, tiny, 0}, {0, 0, momentum});
  const auto by_p = through({0, 0, 0}, {tiny, tiny, std::sqrt(momentum * momentum - 2 * tiny * tiny)});
  const double phi = k * length;
  const auto trace = [&](double sign) {  // of the matrices multiplied
    using Matrix = Eigen::Matrix2d;
    const auto quadrupole = [&](bool focuses) {
      Matrix m;
      if (focuses)
        m << std::cos(phi), std::sin(phi) / k, -k * std::sin(phi), std::cos(phi);
      else
        m << std::cosh(phi), std::sinh(phi) / k, k * std::sinh(phi), std::cosh(phi);
      return m;
    };
    Matrix free;
    free << 1, gap, 0, 1;
    return (free * quadrupole(sign < 0) * free * quadrupole(sign > 0)).trace();
  };
  // The force on a charge is e(v × B), so that one of the sign of e g > 0 is focused along x.
  CHECK(by_x.q()[0] / tiny + by_p.p()[0] / tiny == Approx(trace(charge * g)).epsilon(1e-8));
  CHECK(by_x.q()[1] / tiny + by_p.p()[1] / tiny == Approx(trace(-charge * g)).epsilon(1e-8));
}

TEST_CASE("An electron in SI units moves on as it does, in float", "[systems]") {
  const float e = 1.602e-19F, m = 9.109e-31F, light = 2.998e8F;
  for (const float u : {0.1F, 1.0F, 10.0F}) {  // γβ
    CAPTURE(u);
    const float momentum = m * light * u, beta = u / std::sqrt(1 + u * u);
    const charges::ChargeAlongPath line(e, m, light, charges::ReferenceLine<float>{},
                                        charges::QuadrupoleField<float>(momentum / e));  // x'' = -x
    const Autonomous K(line);
    const auto on = line.on_line({.t = 0, .q = {1e-3F, 0, 0}, .momentum = {0, 0, momentum}});
    auto Z = K.extended(on.z, on.s);
    GaussLegendre stepper(K, {.stages = 3});
    integrate(stepper, Z, {.dt = 0.05F, .t0 = on.s, .t_end = 2.0F});
    const auto at = line.at_time(K.time(Z), K.point(Z));
    CHECK(at.q[0] == Approx(1e-3 * std::cos(2.0)).epsilon(1e-4));
    CHECK(at.t == Approx(2 / (beta * light)).epsilon(1e-4));
    CHECK(at.momentum.cast<double>().norm() == Approx(momentum).epsilon(1e-5));
  }
}

}  // namespace test_charge_along_path
