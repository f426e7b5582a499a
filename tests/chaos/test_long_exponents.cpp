#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "henon_heiles.hpp"

namespace test_long_exponents {

// Lyapunov exponents and alignment indices of long runs: closed forms, published figures, order and chaos.

namespace {

using namespace semiexplicit;

const Semiexplicit henon_heiles(HenonHeilesWithProduct{}, schemes::low_defect6_s13());
constexpr double chaotic = -0.25, regular = 0.1;

template <class... Observers>
void run(double y, std::int64_t steps, Observers&&... observers) {
  auto stepper = henon_heiles;
  auto z = HenonHeiles::point(y);
  integrate(stepper, z, {.dt = 0.2, .steps = steps}, observers...);
}

/// x'' + x⁵ = sin 2.19t.
struct DrivenQuintic {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double square = q[0] * q[0];
    dHdq[0] = square * square * q[0] - std::sin(2.19 * t);
    dHdp[0] = p[0];
  }
};

/// A quarter of a unit of time for each of s.
struct Quarter {
  double operator()(const auto&, auto&& derivative) const {
    derivative.setZero();
    return 0.25;
  }
};

}  // namespace

TEST_CASE("A ring of eight vortices parts at Havelock's rate", "[lyapunov][long]") {
  // The fastest mode m = 4 of N = 8 grows at Γ/(4πR²) √(m(N - m)(m(N - m) - 2(N - 1))): T. H. Havelock, Phil.
  // Mag. 11 (1931) 617.
  const systems::PointVortices<double, 8> vortices(Vector<double, 8>::Constant(2 * std::numbers::pi));
  Vector<double, 8> x, y;
  for (int k = 0; k < 8; ++k) {
    x[k] = std::cos(k * std::numbers::pi / 4);
    y[k] = std::sin(k * std::numbers::pi / 4);
  }
  auto z = vortices.phase_point(x, y);
  Semiexplicit stepper(vortices, schemes::blanes_moan4());
  LyapunovExponents lyapunov(stepper, 1);
  integrate(stepper, z, {.dt = 0.01, .steps = 400}, lyapunov);
  const double early = 4 * lyapunov.exponents()[0];
  integrate(stepper, z, {.dt = 0.01, .steps = 400, .t0 = 4}, lyapunov);
  CHECK((8 * lyapunov.exponents()[0] - early) / 4 == Approx(std::sqrt(32.0) / 2).epsilon(1e-3));
}

TEST_CASE("Chaos has a positive exponent, order has none, and they come in pairs", "[lyapunov][long]") {
  const auto exponents = [](double y, int steps) {
    LyapunovExponents lyapunov(henon_heiles);
    run(y, steps, lyapunov);
    return lyapunov.exponents();
  };
  const auto chaos = exponents(chaotic, 20'000);
  CHECK(chaos[0] > 0.03);
  CHECK(chaos[0] < 0.08);
  const double t = 4000;
  CHECK(std::abs(chaos[0] + chaos[3]) <= 10 / t);
  CHECK(std::abs(chaos[1] + chaos[2]) <= 10 / t);
  CHECK(std::abs(chaos[1]) <= 2 * std::log(t) / t);
  CHECK(std::abs(chaos.sum()) <= 1e-12);  // volume is kept
  const auto early = exponents(regular, 5'000), late = exponents(regular, 20'000);
  CHECK(early[0] <= 2 * std::log(1000.0) / 1000);
  CHECK(late[0] <= 2 * std::log(t) / t);
  CHECK(late[0] < early[0] / 2);
}

TEST_CASE("In chaos alignment indices decay at the rates of the exponents", "[alignment][long]") {
  AlignmentIndex gali(henon_heiles, 4);
  LyapunovExponents lyapunov(henon_heiles);
  run(chaotic, 50'000, gali, lyapunov);
  const double t = 1e4;
  const auto x = lyapunov.exponents();
  // GALI_2, far below the rounding of the vectors, and below the smallest double.
  CHECK(-gali.log_index(2) / t == Approx(x[0] - x[1]).epsilon(0.02));
  CHECK(-gali.log_index(3) / t == Approx(2 * x[0] - x[1] - x[2]).epsilon(0.02));
  CHECK(-gali.log_index(4) / t == Approx(3 * x[0] - x[1] - x[2] - x[3]).epsilon(0.02));
  CHECK(gali.log_index(4) < -1000);
  CHECK(gali.index(4) == 0);
  CHECK(gali.index(2) < 1e-100);
}

TEST_CASE("On a torus GALI_2 stays, GALI_3 falls as 1/t² and GALI_4 as 1/t⁴", "[alignment][long]") {
  AlignmentIndex gali(henon_heiles, 4);
  std::vector<double> t, means[5];
  double sums[5] = {};
  int seen = 0;
  run(regular, 100'000, gali, [&](double, const auto&, const IntegrationReport& so_far) {
    // Means of the logarithm over the last tenth before 200, 2000 and 20000, which the revolutions of the
    // torus modulate.
    for (const std::int64_t end : {1'000, 10'000, 100'000}) {
      if (so_far.steps <= end - end / 2 || so_far.steps > end) continue;
      ++seen;
      for (const int k : {2, 3, 4}) sums[k] += gali.log_index(k) / std::log(10.0);
      if (so_far.steps == end) {
        for (const int k : {2, 3, 4}) means[k].push_back(sums[k] / seen), sums[k] = 0;
        seen = 0;
      }
    }
  });
  for (const std::size_t decade : {0U, 1U}) {
    CAPTURE(decade);
    CHECK(std::abs(means[2][decade + 1] - means[2][decade]) < 0.2);
    CHECK(means[3][decade + 1] - means[3][decade] == Approx(-2).margin(0.4));
    CHECK(means[4][decade + 1] - means[4][decade] == Approx(-4).margin(0.5));
  }
}

TEST_CASE("A driven chaotic oscillator has the exponent that was published", "[lyapunov][long]") {
  // 0.163 from the origin at rest: J. C. Sprott, "Simple Driven Conservative Chaotic Flows" (2001), table;
  // see also his Chaos and Time-Series Analysis (2003). Estimates over this time scatter by some percent.
  const Autonomous driven(DrivenQuintic{});
  Semiexplicit stepper(driven, schemes::blanes_moan4());
  LyapunovExponents lyapunov(stepper, 1);
  auto z = driven.extended({0, 0}, 0.0);
  integrate(stepper, z, {.dt = 0.1, .steps = 50'000}, lyapunov);
  CHECK(lyapunov.exponents()[0] == Approx(0.163).epsilon(0.1));
  // A second run that goes on from here, at times that meet but for rounding.
  integrate(stepper, z, {.dt = 0.1, .steps = 1000, .t0 = driven.time(z) * (1 + 2e-16)}, lyapunov);
  CHECK(lyapunov.exponents()[0] == Approx(0.163).epsilon(0.1));
}

TEST_CASE("Lyapunov exponents of a backward run, the largest growth first", "[lyapunov][long]") {
  // H = (p² - q²)/2 at its saddle: the exponents 1 and -1, which the first vectors take time to find.
  const auto saddle = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (p[0] * p[0] - q[0] * q[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = -q[0];
        dHdp[0] = p[0];
      });
  Semiexplicit stepper(saddle, schemes::low_defect6_s13<double>());
  for (const double dt : {0.1, -0.1}) {
    LyapunovExponents lyapunov(stepper, 2);
    PhasePoint<double, 1> z(0, 0);
    integrate(stepper, z, {.dt = dt, .steps = 10'000}, lyapunov);
    CHECK(lyapunov.exponents()[0] == Approx(1).epsilon(0.005));
    CHECK(lyapunov.exponents()[1] == Approx(-1).epsilon(0.005));
  }
}

TEST_CASE("Exponents of a run in another variable than the time are growth in time", "[chaos][long]") {
  const auto saddle =
      from_energy<1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 - q[0] * q[0] / 2; });
  const TimeTransformed transformed(saddle, Quarter{}, 0.0);
  Semiexplicit stepper(transformed, schemes::low_defect6_s13<double>());
  auto z = transformed.extended(PhasePoint<double, 1>(0, 0), 0.0);
  LyapunovExponents lyapunov(stepper, 1);
  integrate(stepper, z, {.dt = 0.2, .steps = 4000}, lyapunov);
  REQUIRE(transformed.time(z) == Approx(200));
  CHECK(lyapunov.exponents()[0] == Approx(1).epsilon(0.03));
  CHECK(lyapunov.times().back() <= 200.001);
}

TEST_CASE("Exponents of a transformed time count in the time, also late", "[lyapunov]") {
  // A pendulum at its top, where the exponent is 1, by steps that take g ds of the time.
  const auto exponent = [](auto t0, double ds, double g) {
    using Scalar = decltype(t0);
    const auto h = from_energy<1, Scalar>(
        [](const auto& q, const auto& p) { return p[0] * p[0] / Scalar(2) + cos(q[0]); });
    const auto monitor = [g](const auto&, auto&& slope) {
      slope.setZero();
      return static_cast<Scalar>(g);
    };
    PhasePoint<Scalar, 1> z(Scalar(0), Scalar(0));
    TimeTransformed transformed(h, monitor, h.energy(z.q(), z.p()));
    Semiexplicit stepper(transformed, schemes::low_defect4_s7<Scalar>());
    auto extended = transformed.extended(z, t0);
    LyapunovExponents lyapunov(stepper, 1);
    integrate(stepper, extended, {.dt = static_cast<Scalar>(ds), .steps = 4000}, lyapunov);
    REQUIRE_FALSE(lyapunov.times().empty());
    CHECK(lyapunov.times().back() ==
          Approx(static_cast<double>(transformed.time(extended) - t0)).epsilon(0.15));
    return static_cast<double>(lyapunov.exponents()[0]);
  };
  CHECK(exponent(0.0, 0.01, 1.45) == Approx(1).epsilon(0.04));
  CHECK(exponent(1e12, 0.01, 1.05) == Approx(exponent(0.0, 0.01, 1.05)).epsilon(1e-4));
  CHECK(exponent(1e4F, 0.01, 1.45) == Approx(exponent(0.0, 0.01, 1.45)).epsilon(1e-3));
  CHECK(std::isfinite(exponent(1e5F, 0.1, 0.01)));  // steps below the rounding of the time
}

TEST_CASE("In floats an index far below 1 goes on to fall where a step changes it little", "[alignment]") {
  // Two pendula that stand on their heads: GALI_4 falls by the same every step.
  const auto h = from_energy<2, float>([](const auto& q, const auto& p) {
    return p[0] * p[0] / 2 + p[1] * p[1] / 2 + 0.1F * cos(q[0]) + 0.05F * cos(q[1]);
  });
  Semiexplicit own(h, schemes::blanes_moan4<float>());
  AlignmentIndex gali(own, 4);
  PhasePoint<float, 2> z({0, 0}, {0, 0});
  integrate(own, z, {.dt = 0.5F, .steps = 2000}, gali);
  const double before = static_cast<double>(gali.log_index(4));
  integrate(own, z, {.dt = 3e-5F, .steps = 10'000}, gali);
  // The sum of the differences of the exponents ±√0.1, ±√0.05 from the largest.
  const double rate = 4 * std::sqrt(0.1);
  CHECK(before == Approx(-1000 * rate).epsilon(1e-2));
  CHECK(static_cast<double>(gali.log_index(4)) - before == Approx(-0.3 * rate).epsilon(0.05));
}

}  // namespace test_long_exponents
