#include "catch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_gauss_lanes {

using namespace semiexplicit;

namespace {

const systems::NlsLattice<double, 3> lattice;
const PhasePoint<double, 3> start({1, 0.5, -0.3}, {0.4, -0.7, 0.2});

/// A gradient as HasPackGradient's example has it: one text for numbers and for packs, with a root.
struct Kepler {
  using Scalar = double;
  using PackGradientOf = Kepler;
  static constexpr int Dof = 2;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    using std::sqrt;
    const auto squared = q[0] * q[0] + q[1] * q[1];
    const auto cubed = squared * sqrt(squared);
    for (int i = 0; i < 2; ++i) {
      dHdq[i] = q[i] / cubed;
      dHdp[i] = p[i];
    }
  }
};
static_assert(HasPackGradient<Kepler> && HasPackGradient<systems::Product<double>> &&
              HasPackGradient<systems::NlsLattice<double>> &&
              HasPackGradient<systems::PointVortices<double, 10>>);

struct Plain {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(!HasPackGradient<Plain>);

template <class H>
void same_as_one_by_one(const H& h, const PhasePoint<double, H::Dof>& from, double dt) {
  for (int stages = 1; stages <= 8; ++stages)
    for (const bool extrapolate : {true, false}) {
      CAPTURE(stages, extrapolate);
      GaussLegendre one_by_one(h, {.stages = stages, .extrapolate = extrapolate});
      GaussLegendreLanes in_lanes(h, {.stages = stages, .extrapolate = extrapolate});
      auto u = from, v = from;
      for (int n = 0; n < 20; ++n) {
        REQUIRE(one_by_one.step(u, dt).ok());
        const auto report = in_lanes.step(v, dt);
        REQUIRE(report.ok());
        CHECK(report.gradients == stages * report.evaluations + ((extrapolate && n > 0) ? 0 : 1));
      }
      CHECK((u.vector() - v.vector()).norm() <= 1e-14 * from.vector().norm());
    }
}

}  // namespace

TEST_CASE("Stages in lanes take the steps of the stages one by one", "[gauss]") {
  same_as_one_by_one(lattice, start, 0.05);
  same_as_one_by_one(systems::NlsLattice<double>(3), {start.q(), start.p()}, 0.05);
  same_as_one_by_one(Kepler{}, {{1, 0}, {0, 0.9}}, 0.05);
}

TEST_CASE("Stages in lanes: another direction is not extrapolated to", "[gauss]") {
  GaussLegendreLanes stepper(lattice, {.stages = 4}), fresh(lattice, {.stages = 4});
  auto z = start;
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(z, 0.05).ok());
  auto copy = z;
  CHECK(stepper.step(z, -0.05).gradients == fresh.step(copy, -0.05).gradients);
  CHECK((z.vector() - copy.vector()).norm() <= 1e-15);
}

TEST_CASE("Stages in lanes: a tolerance ends the iteration early", "[gauss]") {
  auto loose = start, tight = start;
  const auto a = GaussLegendreLanes(lattice, {.stages = 3, .tolerance = 1e-6}).step(loose, 0.1);
  const auto b = GaussLegendreLanes(lattice, {.stages = 3}).step(tight, 0.1);
  CHECK(a.ok());
  CHECK(a.correction < 1e-6);
  CHECK(a.evaluations < b.evaluations);
  CHECK((loose.vector() - tight.vector()).norm() <= 1e-6);
}

TEST_CASE("Stages in lanes: what cannot be done is refused, and the state left alone", "[gauss]") {
  CHECK_THROWS_AS(GaussLegendreLanes(lattice, {.stages = 9}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendreLanes(lattice, {.solver = StageSolver::newton}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendreLanes(lattice, {.tolerance = -1}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendreLanes(lattice, {.max_iterations = 0}), std::invalid_argument);

  auto z = start;
  CHECK(GaussLegendreLanes(lattice, {.stages = 3, .max_iterations = 2}).step(z, 0.2).status ==
        Status::no_convergence);
  GaussLegendreLanes stepper(lattice, {.stages = 3});
  CHECK(stepper.step(z, 0.0).status == Status::invalid_step);
  CHECK(stepper.step(z, 1e3).status != Status::success);
  CHECK(z.vector() == start.vector());
  z.q()[1] = std::nan("");
  CHECK(stepper.step(z, 0.1).status == Status::invalid_state);
  z = start;
  CHECK(stepper.step(z, 0.1).ok());
  PhasePoint<double, Eigen::Dynamic> small(2);
  CHECK(GaussLegendreLanes(systems::NlsLattice<double>(3)).step(small, 0.1).status == Status::invalid_state);
  PhasePoint<double, 2> singular({0, 0}, {1, 0});
  CHECK(GaussLegendreLanes(Kepler{}).step(singular, 0.1).status == Status::not_finite);
}

namespace {

/// How much the energy of Kepler orbits has changed after that many steps, on average over several.
template <class Stepper>
double energy_drift(int steps, double dt) {
  const auto energy = [](const PhasePoint<double, 2>& z) {
    const auto q = z.q().cast<long double>(), p = z.p().cast<long double>();
    return p.squaredNorm() / 2 - 1 / q.norm();
  };
  long double sum = 0;
  for (const double e : {0.2, 0.21, 0.22, 0.23}) {
    PhasePoint<double, 2> z({1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
    const long double before = energy(z);
    Stepper stepper(Kepler(), {.stages = 8});
    for (int n = 0; n < steps; ++n) REQUIRE(stepper.step(z, dt).ok());
    sum += energy(z) - before;
  }
  return static_cast<double>(sum / 4);
}

/// A spherical pendulum: its second angle winds up, and nothing depends on it.
struct Pendulum {
  using Scalar = float;
  using PackGradientOf = Pendulum;
  static constexpr int Dof = 2;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D& dHdq, D& dHdp) const {
    using std::cos;
    using std::sin;
    const auto s = sin(q[0]);
    dHdq[0] = s - p[1] * p[1] * cos(q[0]) / (s * s * s);
    dHdq[1] = s * 0.0f;
    dHdp[0] = p[0] * 1.0f;
    dHdp[1] = p[1] / (s * s);
  }
};

/// The largest relative error of the energy, which is found in more digits.
template <class Stepper>
double energy_error_of_pendulum(int stages, float dt, int steps) {
  const auto energy = [](const auto& z) {
    const double q = double(z.q()[0]), p = double(z.p()[0]), l = double(z.p()[1]);
    return p * p / 2 + std::pow(l / std::sin(q), 2) / 2 - std::cos(q);
  };
  Stepper stepper(Pendulum(), {.stages = stages});
  PhasePoint<float, 2> z({1, 0}, {0, 0.3f});
  const double before = energy(z);
  double worst = 0;
  for (int n = 0; n < steps; ++n) {
    REQUIRE(stepper.step(z, dt).ok());
    worst = std::max(worst, std::abs(energy(z) / before - 1));
  }
  return worst;
}

/// p₁²/2 + ω(p₂² + q₂² + 0.1 q₂⁴)/2: nothing depends on q₁.
template <class ScalarType>
struct BesideAFarOne {
  using Scalar = ScalarType;
  using PackGradientOf = BesideAFarOne;
  static constexpr int Dof = 2;
  Scalar omega;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = q[0] * Scalar(0);
    dHdq[1] = omega * (q[1] + Scalar(0.2) * q[1] * q[1] * q[1]);
    dHdp[0] = p[0] * Scalar(1);
    dHdp[1] = omega * p[1];
  }
};

/// Steps of one unit of time take the oscillator where they take it with q₁ = 0.
template <template <class> class Stepper, class Scalar>
void beside_a_far_one(const GaussLegendreOptions& options, Scalar omega, const std::vector<Scalar>& far) {
  const auto oscillator_after = [&](Scalar q1) {
    const BesideAFarOne<Scalar> system{omega};
    Stepper<BesideAFarOne<Scalar>> stepper(system, options);
    PhasePoint<Scalar, 2> z({q1, Scalar(1e-3)}, {Scalar(0.5), 0});
    for (int n = 0; n < 50; ++n) REQUIRE(stepper.step(z, Scalar(1)).ok());
    return Eigen::Vector2d(static_cast<double>(z.q()[1]), static_cast<double>(z.p()[1]));
  };
  const Eigen::Vector2d alone = oscillator_after(0);
  for (const Scalar q1 : far) {
    CAPTURE(q1, options.stages, options.extrapolate);
    CHECK((oscillator_after(q1) - alone).norm() <=
          1000 * static_cast<double>(std::numeric_limits<Scalar>::epsilon()) * alone.norm());
  }
}

/// A sun, a slow planet and a light, fast satellite of the sun, in the plane; masses in units of 1 / `unit`.
struct LightSatellite {
  using Scalar = double;
  using PackGradientOf = LightSatellite;
  static constexpr int Dof = 6;
  static constexpr double light = 0x1p-60;
  double unit;
  double mass(int i) const { return unit * (i == 0 ? 1 : i == 1 ? 1e-3 : light); }

  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    using std::sqrt;
    for (int i = 0; i < 6; ++i) {
      dHdp[i] = p[i] / mass(i / 2);
      dHdq[i] = q[i] * 0.0;
    }
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < i; ++j) {
        const auto x = q[2 * i] - q[2 * j], y = q[2 * i + 1] - q[2 * j + 1], squared = x * x + y * y;
        const auto pull = mass(i) * mass(j) / unit / (squared * sqrt(squared));
        dHdq[2 * i] += pull * x;
        dHdq[2 * j] -= pull * x;
        dHdq[2 * i + 1] += pull * y;
        dHdq[2 * j + 1] -= pull * y;
      }
  }
  PhasePoint<double, 6> start() const {
    const double planet = std::sqrt(1 / 5.2), satellite = std::sqrt(1.3 / 0.1);
    return {{0, 0, 5.2, 0, 0.1, 0}, {0, -mass(1) * planet, 0, mass(1) * planet, 0, mass(2) * satellite}};
  }
};

/// Ten steps a turn of the satellite.
template <template <class> class Stepper>
Eigen::Vector2d satellite_after(int steps, double unit, GaussLegendreOptions options) {
  const LightSatellite system{unit};
  Stepper<LightSatellite> stepper(system, options);
  auto z = system.start();
  for (int n = 0; n < steps; ++n) REQUIRE(stepper.step(z, 0.0199).ok());
  return z.q().tail(2);
}

template <template <class> class Stepper>
void satellite_is_the_same_in_heavy_units(const GaussLegendreOptions& options) {
  CAPTURE(options.stages, options.extrapolate);
  const auto light = satellite_after<Stepper>(400, 1, options);
  CHECK((satellite_after<Stepper>(400, 0x1p60, options) - light).norm() < 1e-9);
  CHECK((satellite_after<Stepper>(400, 0x1p100, options) - light).norm() < 1e-9);
}

/// A satellite of the Earth, 1000 kg, and the Earth about the Sun behind it, in relative coordinates, SI
/// units.
struct BesideEarth {
  using Scalar = float;
  using PackGradientOf = BesideEarth;
  static constexpr int Dof = 4;
  void gradient(const auto& q, const auto& p, auto&& by_q, auto&& by_p) const {
    using std::sqrt;
    const auto orbit = [&](int i, float pull, float mass) {
      const auto squared = q[i] * q[i] + q[i + 1] * q[i + 1], force = pull / (squared * sqrt(squared)) * mass;
      for (const int j : {i, i + 1}) by_q[j] = force * q[j], by_p[j] = p[j] / mass;
    };
    orbit(0, 3.986e14F, 1000);
    orbit(2, 1.327e20F, 5.97e24F);
  }
};

/// Of its angular momentum, and whether all steps were taken.
template <template <class> class Stepper>
std::pair<double, bool> drift_of_satellite(int stages, float dt, int steps) {
  PhasePoint<float, 4> z({7e6F, 0, 1.496e11F, 0}, {0, 7.9e6F, 0, 5.97e24F * 2.978e4F});
  Stepper<BesideEarth> stepper(BesideEarth(), {.stages = stages});
  const auto momentum = [&] { return double(z.q()[0]) * z.p()[1] - double(z.q()[1]) * z.p()[0]; };
  const double first = momentum();
  bool ok = true;
  for (int n = 0; n < steps && ok; ++n) ok = stepper.step(z, dt).ok();
  return {std::abs(momentum() / first - 1), ok};
}

template <template <class> class Stepper>
void satellite_converges_beside_the_earth() {
  for (const int stages : {2, 3}) {
    CAPTURE(stages);
    const auto [drift, ok] = drift_of_satellite<Stepper>(stages, 300, 2000);
    CHECK(ok);
    CHECK(drift < 1e-5);
  }
  // Slowly; and not at all, as without the Earth.
  const auto [drift, ok] = drift_of_satellite<Stepper>(4, 2000, 50);
  CHECK(ok);
  CHECK(drift < 1e-5);
  for (const float dt : {600.F, 750.F}) {
    CAPTURE(dt);
    const auto far_too_long = drift_of_satellite<Stepper>(1, dt, 50);
    CHECK_FALSE(far_too_long.second);
    CHECK(far_too_long.first < 1e-4);
  }
}

/// At the rates 2 and 0.01.
struct TwoOscillators {
  using Scalar = double;
  static constexpr int Dof = 2;
  using PackGradientOf = TwoOscillators;
  void gradient(const auto& q, const auto& p, auto&& by_q, auto&& by_p) const {
    by_q[0] = 4.0 * q[0];
    by_q[1] = 1e-4 * q[1];
    by_p[0] = p[0];
    by_p[1] = p[1];
  }
};

/// An oscillator whose rate grows with its action, x = q and X = unit p.
struct Twisted {
  using Scalar = double;
  static constexpr int Dof = 1;
  using PackGradientOf = Twisted;
  double unit;
  void gradient(const auto& q, const auto& p, auto&& by_q, auto&& by_p) const {
    const auto x = q[0], X = unit * p[0];
    const auto rate = 1.4557316974736749 + 0.18838654011487962 * (x * x + X * X);
    by_q[0] = rate * x / unit;
    by_p[0] = rate * X;
  }
};

/// By what part of itself its action, which is kept but for rounding, changes a step, on an average.
template <class Stepper>
double drift_of_action(double unit, double dt) {
  Stepper stepper(Twisted{unit}, {.stages = 8});
  PhasePoint<double, 1> z(-0.92770463973283768, -0.95676750317215919 / unit);
  const auto action = [&] {
    const long double x = z.q()[0], X = static_cast<long double>(unit) * z.p()[0];
    return x * x + X * X;
  };
  const long double first = action();
  const int steps = 5000;
  for (int n = 0; n < steps; ++n) REQUIRE(stepper.step(z, dt).ok());
  return static_cast<double>((action() / first - 1) / steps);
}

}  // namespace

TEST_CASE("Light bodies' stages converge as well where heavy bodies' numbers are far larger", "[gauss]") {
  for (const bool extrapolate : {true, false}) {
    satellite_is_the_same_in_heavy_units<GaussLegendre>({.stages = 6, .extrapolate = extrapolate});
    satellite_is_the_same_in_heavy_units<GaussLegendreLanes>({.stages = 6, .extrapolate = extrapolate});
  }
  satellite_is_the_same_in_heavy_units<GaussLegendre>({.stages = 3, .solver = StageSolver::newton});
}

TEST_CASE("Gauss converges for what is nothing beside a heavy body to the third power of rounding") {
  satellite_converges_beside_the_earth<GaussLegendre>();
  satellite_converges_beside_the_earth<GaussLegendreLanes>();
}

TEST_CASE("A small oscillation converges as well beside a large one", "[gauss]") {
  const auto keeps_its_energy = [](auto stepper) {
    for (const double small : {1e-6, 1e-9, 1e-12, 1e-15}) {
      PhasePoint<double, 2> z({small, 1}, {small, 0});
      const auto energy = [&] { return z.p()[0] * z.p()[0] + 4 * z.q()[0] * z.q()[0]; };
      const double first = energy();
      integrate(stepper, z, {.dt = 1, .steps = 500});
      CAPTURE(small);
      CHECK(energy() == Approx(first).epsilon(1e-9));
    }
  };
  keeps_its_energy(GaussLegendre(TwoOscillators(), {.stages = 2}));  // whose changes shrink in turns
  keeps_its_energy(GaussLegendreLanes(TwoOscillators(), {.stages = 4}));
}

TEST_CASE("Stages that run away are no success beside numbers that are far larger", "[gauss]") {
  for (const double large : {1.0, 1e16, 1e18, 1e21, 1e25})
    for (const double dt : {1.2, 2.0, 3.0}) {
      CAPTURE(large, dt);
      const PhasePoint<double, 2> before({0.7, large}, {0.3, 0});
      auto z = before;
      CHECK(GaussLegendre(TwoOscillators(), {.stages = 1}).step(z, dt).status == Status::no_convergence);
      CHECK(GaussLegendreLanes(TwoOscillators(), {.stages = 1}).step(z, dt).status == Status::no_convergence);
      CHECK(z.vector() == before.vector());
    }
}

TEST_CASE("Gauss's methods iterate as well where momenta are in a unit far from that of positions",
          "[gauss]") {
  for (const double unit : {1.0, 512.0, 0x1p40})
    for (const double dt : {1.02, 1.069}) {
      CAPTURE(unit, dt);
      const double rounding = std::numeric_limits<double>::epsilon();
      CHECK(std::abs(drift_of_action<GaussLegendre<Twisted>>(unit, dt)) < 0.2 * rounding);
      CHECK(std::abs(drift_of_action<GaussLegendreLanes<Twisted>>(unit, dt)) < 0.2 * rounding);
    }
}

TEST_CASE("Gauss's methods iterate as well beside a coordinate that has gone far", "[gauss]") {
  for (const bool extrapolate : {true, false}) {
    beside_a_far_one<GaussLegendre, float>({.stages = 6, .extrapolate = extrapolate}, 3, {1e3F, 1e6F});
    beside_a_far_one<GaussLegendreLanes, float>({.stages = 6, .extrapolate = extrapolate}, 5, {1e3F, 1e6F});
    beside_a_far_one<GaussLegendreLanes, double>({.stages = 6, .extrapolate = extrapolate}, 5, {1e4, 1e10});
  }
  beside_a_far_one<GaussLegendre, float>({.stages = 2, .solver = StageSolver::newton}, 2, {1e5F});
}

TEST_CASE("Gauss's methods go on to iterate where an angle has wound up", "[gauss][long]") {
  // The iteration converges slowly, and not evenly; in double the error stays at 1.02e-5.
  CHECK(energy_error_of_pendulum<GaussLegendre<Pendulum>>(4, 0.264884f, 20'000) < 3e-5);
  CHECK(energy_error_of_pendulum<GaussLegendreLanes<Pendulum>>(4, 0.264884f, 20'000) < 3e-5);
}

TEST_CASE("Rounding makes the energy of Gauss's methods walk at random, not drift", "[gauss][long]") {
  const int steps = 80'000;
  const double dt = 0.2, walk = std::numeric_limits<double>::epsilon() * std::sqrt(steps) * dt;
  CHECK(std::abs(energy_drift<GaussLegendre<Kepler>>(steps, dt)) / walk < 0.8);
  CHECK(std::abs(energy_drift<GaussLegendreLanes<Kepler>>(steps, dt)) / walk < 0.8);
}

}  // namespace test_gauss_lanes
