// Poincaré's transformation of time: eccentric orbits and close encounters by steps of equal size.

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "kepler.hpp"
#include "oscillator.hpp"
#include "refusal.hpp"

namespace test_time_transformed {

namespace {

using namespace semiexplicit;
const double pi = std::acos(-1.0);

/// ∮ dt/g over such an orbit, for g = r^power; with the eccentric anomaly E, dt = r dE.
double parameter_of_orbit(double e, double power) {
  double sum = 0;
  const int n = 20'000;
  for (int i = 0; i < n; ++i)
    sum += 2 * pi / n * std::pow(1 - e * std::cos(2 * pi * (i + 0.5) / n), 1 - power);
  return sum;
}

/// Largest error of a quantity relative to its first value.
struct Worst {
  double first = 0, error = 0;
  void see(double value) {
    if (first == 0) first = value;
    error = std::max(error, std::abs(value / first - 1));
  }
};

}  // namespace

TEST_CASE("Kepler's orbits of any eccentricity: a hundred of them, in a hundred steps each",
          "[time transformed][long]") {
  const Kepler h;
  for (const double e : {0.9, 0.99, 0.999}) {
    CAPTURE(e);
    const TimeTransformed k(h, monitors::Distance{1.5}, -0.5);
    Semiexplicit stepper(k, schemes::low_defect8_s20());
    auto z = k.extended(kepler_orbit(e, 0), 0.0);
    const double p_t = z.p()[2];
    Worst energy, momentum;
    const auto report = integrate(stepper, z, {.dt = parameter_of_orbit(e, 1.5) / 100, .steps = 10'000},
                                  [&](double, const auto& at) {
                                    const auto q = at.q().template head<2>(), p = at.p().template head<2>();
                                    energy.see(h.energy(q, p));
                                    momentum.see(q[0] * p[1] - q[1] * p[0]);
                                  });
    CHECK(energy.error < 1e-9);
    CHECK(momentum.error < 1e-13);
    CHECK(report.evaluations == report.steps);
    // A hundred periods, and the orbit is where it should be at the time that it carries.
    CHECK(std::abs(k.time(z) / (2 * pi) - 100) < 1e-8);
    CHECK(z.p()[2] == p_t);
  }
}

TEST_CASE("A monitor function may take the gradient that it writes by reference", "[time transformed]") {
  const auto cubed = [](const auto& q, auto& dgdq) {
    const double r = q.norm(), g = std::pow(r, 1.5);
    dgdq = 1.5 * g / (r * r) * q;
    return g;
  };
  const TimeTransformed by_hand(Kepler{}, cubed, -0.5);
  const TimeTransformed bundled(Kepler{}, monitors::Distance{1.5}, -0.5);
  Semiexplicit one(by_hand);
  Semiexplicit other(bundled);
  auto z = by_hand.extended(kepler_orbit(0.9, 0), 0.0), x = z;
  integrate(one, z, {.dt = 0.1, .steps = 100});
  integrate(other, x, {.dt = 0.1, .steps = 100});
  CHECK((z.vector() - x.vector()).norm() < 1e-11);
}

TEST_CASE("A step of fixed size fails where the transformed one is exact", "[time transformed]") {
  const Kepler h;
  const double e = 0.99;
  Semiexplicit stepper(h, schemes::low_defect8_s20());
  auto z = kepler_orbit(e, pi);
  const double before = h.energy(z.q(), z.p());
  const auto report =
      integrate(stepper, z, {.dt = 2 * pi / 100, .steps = 1000, .on_failure = OnFailure::stop});
  CHECK((!report.ok() || std::abs(h.energy(z.q(), z.p()) / before - 1) > 1e-3));
}

TEST_CASE("Positions at physical times agree with Kepler's equation", "[time transformed]") {
  const Kepler h;
  const double e = 0.9;
  std::vector<double> times;
  for (int i = 0; i <= 200; ++i) times.push_back(1 + 0.1 * i);  // three orbits, begun at t = 1
  for (const auto& method : {1, 2}) {
    const TimeTransformed k(h, monitors::Distance{1.5}, -0.5);
    auto z = k.extended(kepler_orbit(e, 0), 1.0);
    double worst = 0;
    auto output = at_times(
        k, times,
        [&](double t, const PhasePoint<double, 2>& at) {
          worst = std::max(worst, (at.q() - kepler_orbit(e, t - 1).q()).norm());
        },
        5);
    const double ds = parameter_of_orbit(e, 1.5) / 400;
    if (method == 1) {
      Semiexplicit stepper(k, schemes::low_defect8_s20());
      integrate(stepper, z, {.dt = ds, .steps = 1600}, output);
    } else {
      GaussLegendre stepper(k, {.stages = 4});
      integrate(stepper, z, {.dt = ds, .steps = 1600}, output);
    }
    CHECK(output.served() == times.size());
    CHECK(worst < 1e-9);
  }
}

TEST_CASE("The time is carried to the order of the method", "[time transformed]") {
  const Kepler h;
  const TimeTransformed k(h, monitors::Distance{1.2}, -0.5);
  const double e = 0.5, whole = parameter_of_orbit(e, 1.2);
  for (const char* name : {"strang", "blanes_moan4", "blanes_moan6"}) {
    const auto scheme = schemes::by_name(name);
    const auto error = [&](int steps) {
      Semiexplicit stepper(k, scheme);
      auto z = k.extended(kepler_orbit(e, 0), 0.0);
      integrate(stepper, z, {.dt = whole / steps, .steps = steps});
      return std::abs(k.time(z) - 2 * pi);
    };
    CAPTURE(name);
    CHECK(std::log2(error(120) / error(240)) == Approx(scheme.order).margin(0.35));
  }
}

TEST_CASE("A size known at run time changes nothing", "[time transformed]") {
  const TimeTransformed fixed(Kepler{}, monitors::Distance{}, -0.5);
  const TimeTransformed dynamic(KeplerOf<double, Eigen::Dynamic>{}, monitors::Distance{}, -0.5);
  const auto start = kepler_orbit(0.8, 0.3);
  auto x = fixed.extended(start, 0.0);
  auto y = dynamic.extended({start.q(), start.p()}, 0.0);
  Semiexplicit one(fixed, schemes::blanes_moan6());
  Semiexplicit other(dynamic, schemes::blanes_moan6());
  integrate(one, x, {.dt = 0.05, .steps = 100});
  integrate(other, y, {.dt = 0.05, .steps = 100});
  CHECK((x.vector() - y.vector()).norm() < 1e-12);
}

TEST_CASE("An energy that is a little off is taken up", "[time transformed]") {
  const TimeTransformed exact(Kepler{}, monitors::Distance{}, -0.5),
      wrong(Kepler{}, monitors::Distance{}, -0.6);
  auto x = exact.extended(kepler_orbit(0.8, 0.3), 0.0), y = wrong.extended(kepler_orbit(0.8, 0.3), 0.0);
  CHECK(y.p()[2] == Approx(-0.1));
  Semiexplicit one(exact, schemes::blanes_moan6()), other(wrong, schemes::blanes_moan6());
  integrate(one, x, {.dt = 0.02, .steps = 500});
  integrate(other, y, {.dt = 0.02, .steps = 500});
  CHECK((exact.point(x).vector() - wrong.point(y).vector()).norm() < 1e-11);
  CHECK(exact.time(x) == Approx(wrong.time(y)).epsilon(1e-12));
}

TEST_CASE("Three vortices that nearly collapse", "[time transformed]") {
  // With 1/Γ₁ + 1/Γ₂ + 1/Γ₃ = 0 and Σ ΓᵢΓⱼD² = 0 all distances shrink to nothing in finite time (Aref, Phys.
  // Fluids 22 (1979) 393, section IV); a little off they turn round at a distance that is small.
  const systems::PointVortices<double, 3> h({2, 2, -1});
  const auto start = h.phase_point({-1, 1, 1.0003}, {0, 0, std::sqrt(2.0)});
  const double e0 = h.energy(start.q(), start.p());
  const auto closest = [&](const auto& q, const auto& p) {
    const Eigen::Vector3d x = h.x(q), y = h.y(p);
    return std::min({std::hypot(x[0] - x[1], y[0] - y[1]), std::hypot(x[0] - x[2], y[0] - y[2]),
                     std::hypot(x[1] - x[2], y[1] - y[2])});
  };
  const TimeTransformed k(h, monitors::VortexDistances(h), e0);
  Semiexplicit stepper(k, schemes::low_defect8_s20());
  auto z = k.extended(start, 0.0);
  double nearest = 10, farthest_after = 0;
  Worst energy, impulse;
  integrate(stepper, z, {.dt = 0.2, .steps = 950}, [&](double, const auto& at) {
    const auto point = k.point(at);
    const double now = closest(point.q(), point.p());
    if (now < nearest) farthest_after = 0;
    nearest = std::min(nearest, now);
    farthest_after = std::max(farthest_after, now);
    energy.see(h.energy(point.q(), point.p()));
    impulse.see(h.angular_impulse(point.q(), point.p()));
  });
  CHECK(nearest < 0.03);
  CHECK(farthest_after > 0.5);
  CHECK(energy.error < 1e-10);
  CHECK(impulse.error < 1e-12);
}

TEST_CASE("A relativistic orbit of eccentricity 0.95", "[time transformed]") {
  using namespace semiexplicit::effects;
  const double e = 0.95, c = 300, a = 1;
  const Scene scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = 1},
                    orbits::PostNewtonian1<double, 2>{.gm = 1, .c = c});
  const auto start = kepler_orbit(e, pi);
  const TimeTransformed k(scene, monitors::Distance{}, scene.energy(start.q(), start.p()));
  Semiexplicit stepper(k, schemes::low_defect8_s20());
  auto z = k.extended(start, 0.0);
  Worst energy, momentum;
  double turned = 0;
  std::vector<double> apocentres;  // angles of the apocentres: where q·p goes from above to below zero
  double before = 0, angle_before = 0;
  integrate(stepper, z, {.dt = parameter_of_orbit(e, 1.5) / 100, .steps = 5000}, [&](double, const auto& at) {
    const auto q = at.q().template head<2>(), p = at.p().template head<2>();
    energy.see(scene.energy(q, p));
    momentum.see(q[0] * p[1] - q[1] * p[0]);
    const double angle = std::atan2(q[1], q[0]);
    turned = angle_before + std::remainder(angle - angle_before, 2 * pi);
    const double now = q.dot(p);
    if (before > 0 && now <= 0)
      apocentres.push_back(angle_before + (turned - angle_before) * before / (before - now));
    before = now;
    angle_before = turned;
  });
  REQUIRE(apocentres.size() > 40);
  const double advance = (apocentres.back() - apocentres.front()) / double(apocentres.size() - 1) - 2 * pi;
  CHECK(energy.error < 1e-10);
  CHECK(momentum.error < 1e-12);
  CHECK(advance == Approx(6 * pi / (c * c * a * (1 - e * e))).epsilon(0.005));
}

TEST_CASE("A step from where the monitor function is not positive fails", "[time transformed]") {
  const double zero = GENERATE(-0.5, -0.2);
  const auto g = [zero](const auto& q, auto&& dgdq) {
    dgdq[0] = 1;
    return q[0] - zero;
  };
  const TimeTransformed k(OscillatorOf<double>{}, g, 0.5);
  for (const double ds : {0.5, 1.0, 1.5, 2.0}) {
    CAPTURE(zero, ds);
    MidpointProjection stepper(k, schemes::strang());
    auto z = k.extended({1, 0}, 0.0);
    int beyond = 0;
    const auto report = integrate(stepper, z, {.dt = ds, .steps = 100, .on_failure = OnFailure::stop},
                                  [&](double, const auto& at) { beyond += !(at.q()[0] > zero); });
    CHECK(beyond <= 1);
    if (beyond > 0) CHECK(report.status == Status::not_finite);
  }
}

TEST_CASE("What cannot be transformed is refused", "[time transformed]") {
  const TimeTransformed k(Kepler{}, monitors::Distance{}, -0.5);
  CHECK(refuses([&] { k.extended({{0, 0}, {0, 1}}, 0.0); }, "not finite"));
  const auto negative = [](const auto& q, auto&& dgdq) {
    dgdq.setZero();
    return -q[0];
  };
  const TimeTransformed backwards(Kepler{}, negative, -0.5);
  CHECK(refuses([&] { backwards.extended({{1, 0}, {0, 1}}, 0.0); }, "not positive"));
  const TimeTransformed dynamic(KeplerOf<double, Eigen::Dynamic>{}, monitors::Distance{}, -0.5);
  CHECK(refuses([&] { dynamic.extended(PhasePoint<double, Eigen::Dynamic>(3), 0.0); }, "another size"));
  // A value of (q, p), as ReversibleSteps takes it, is no monitor of q that writes its gradient.
  const auto value = [](const auto& q, const auto& p) { return 1 / (p.squaredNorm() + 1 / q.norm()); };
  const TimeTransformed unwritten(Kepler{}, value, -0.5);
  CHECK(refuses(
      [&] {
        unwritten.extended({{1, 0}, {0, 1}}, 0.0);
      },
      "leaves entries of its gradient unwritten"));
}

namespace {

/// Kepler's problem in a field that swings from t0 on.
template <int D>
struct SwingingKepler {
  using Scalar = double;
  static constexpr int Dof = D;
  double t0;
  Eigen::Index dof() const { return 2; }
  double energy(double t, In<double, D> q, In<double, D> p) const {
    return dot(p, p) / 2 - 1 / q.norm() + 0.02 * q[0] * std::cos(1.3 * (t - t0));
  }
  void gradient(double t, In<double, D> q, In<double, D> p, Out<double, D> dHdq, Out<double, D> dHdp) const {
    dHdq = q / std::pow(q.norm(), 3);
    dHdq[0] += 0.02 * std::cos(1.3 * (t - t0));
    dHdp = p;
  }
  double time_derivative(double t, In<double, D> q, In<double, D>) const {
    return -0.026 * q[0] * std::sin(1.3 * (t - t0));
  }
  static double dot(const In<double, D>& a, const In<double, D>& b) { return a.dot(b); }
};

}  // namespace

TEST_CASE("A driven system is transformed by monitors of its own coordinates", "[time transformed][long]") {
  for (const double t0 : {0.0, 0x1p20}) {
    CAPTURE(t0);
    const double e = 0.8;
    const PhasePoint<double, 2> start({-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))});
    std::vector<double> times;
    for (int i = 1; i <= 40; ++i) times.push_back(t0 + i);
    const auto collect = [](std::vector<Eigen::Vector2d>& list) {
      return [&](double, const auto& z) { list.push_back({z.q()[0], z.q()[1]}); };
    };

    const Autonomous plain(SwingingKepler<2>{t0});
    std::vector<Eigen::Vector2d> exact, found, at_run_time;
    auto Z = plain.extended(start, t0);
    GaussLegendre gauss(plain, {.stages = 8});
    REQUIRE(integrate(gauss, Z, {.dt = 0.01, .steps = 4100, .t0 = t0}, at_times(plain, times, collect(exact)))
                .ok());

    const auto transformed = [&](const auto& h, const auto& from, std::vector<Eigen::Vector2d>& list) {
      const TimeTransformed k(h, monitors::Distance{},
                              h.energy(h.extended(from, t0).q(), h.extended(from, t0).p()));
      REQUIRE(k.dof() == 3);
      auto K = k.extended(from, t0);
      Semiexplicit stepper(k, schemes::low_defect6_s15());
      REQUIRE(integrate(stepper, K, {.dt = 0.02, .steps = 4000}, at_times(k, times, collect(list))).ok());
      CHECK(k.time(K) > t0 + 40);
      CHECK(std::abs(k.energy(K.q(), K.p())) < 1e-9);
      // The size that tolerances are relative to is that of the system's own (q, p).
      CHECK(detail::state_size(k, K) < 10);
    };
    transformed(plain, start, found);
    PhasePoint<double, Eigen::Dynamic> start_at_run_time(2);
    start_at_run_time.vector() = start.vector();
    transformed(Autonomous(SwingingKepler<Eigen::Dynamic>{t0}), start_at_run_time, at_run_time);
    REQUIRE(found.size() == exact.size());
    for (std::size_t i = 0; i < exact.size(); ++i) {
      CHECK((found[i] - exact[i]).norm() < (t0 == 0 ? 1e-7 : 1e-6));
      CHECK((found[i] - at_run_time[i]).norm() < (t0 == 0 ? 1e-10 : 1e-7));
    }
  }
}

TEST_CASE("A transformation of dynamic size works on where it was moved from") {
  const auto H =
      from_energy(2, [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; });
  PhasePoint<double, Eigen::Dynamic> z(2);
  z.q() << 1, 2;
  TimeTransformed K(H, monitors::Distance{}, H.energy(z.q(), z.p()));
  auto Z = K.extended(z, 0.0), same = Z;
  const auto moved = std::move(K);
  integrate(Semiexplicit(moved, schemes::strang()), Z, {.dt = 0.1, .steps = 2});
  integrate(Semiexplicit(K, schemes::strang()), same, {.dt = 0.1, .steps = 2});
  CHECK(same.vector() == Z.vector());
}

}  // namespace test_time_transformed
