#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include <semiexplicit/chaos.hpp>
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

}  // namespace test_long_exponents
