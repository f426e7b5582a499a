#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_late_times {

// An autonomous system does not know what time it is: from any t0 on an observer sees what it sees from 0 on,
// although late times are rounded so coarsely that many steps have the same one.

namespace {

using namespace semiexplicit;

template <class Scalar>
auto henon_heiles() {
  return from_energy<2, Scalar>([](const auto& q, const auto& p) {
    return (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]) / 2 + q[0] * q[0] * q[1] -
           q[1] * q[1] * q[1] / 3;
  });
}

/// What all observers saw of a run of `steps` steps of size dt from t0 on.
template <class Scalar>
struct Seen {
  std::vector<Scalar> at_times, crossings;  ///< coordinates of the states
  std::size_t served = 0, recorded = 0;
  std::int64_t count = 0;
  Scalar exponent = 0, worst = 0;

  Seen(Scalar t0, Scalar dt, std::int64_t steps) {
    const auto h = henon_heiles<Scalar>();
    Semiexplicit stepper(h, schemes::blanes_moan4<Scalar>(),
                         SimplifiedNewton{.stop = StoppingRule::product(sizeof(Scalar) == 4 ? 1e-8 : 1e-16)});
    PhasePoint<Scalar, 2> z({Scalar(0), Scalar(-0.25)}, {Scalar(0.42), Scalar(0)});
    const auto keep = [](std::vector<Scalar>& list) {
      return [&list](const Scalar&, const auto& at) {
        for (const Scalar& x : at.vector()) list.push_back(x);
      };
    };
    std::vector<Scalar> times;
    for (int i = 0; i <= 5; ++i) times.push_back(t0 + Scalar(i) * Scalar(steps / 5) * dt);
    auto at = semiexplicit::at_times(h, times, keep(at_times));
    auto section = poincare_section(
        h, [](const auto& q, const auto&) { return q[0]; }, keep(crossings));
    LyapunovExponents lyapunov(stepper, 1);
    Invariants invariants(h);
    Record<Scalar, 2> record;
    integrate(stepper, z, {.dt = dt, .steps = steps, .t0 = t0}, at, section, lyapunov, invariants,
              every(10, record));
    served = at.served();
    count = section.count();
    exponent = lyapunov.exponents()[0];
    worst = invariants["energy"].worst;
    recorded = record.z.size();
  }
};

template <class Scalar>
void same_at(Scalar late, Scalar dt, std::int64_t steps) {
  const Seen<Scalar> early(0, dt, steps), seen(late, dt, steps);
  CAPTURE(late, dt);
  CHECK(early.served == 6);
  CHECK(early.count >= 2);
  CHECK(seen.served == early.served);
  CHECK(seen.count == early.count);
  CHECK(seen.recorded == early.recorded);
  CHECK(seen.worst == early.worst);
  CHECK(seen.exponent == Approx(early.exponent).epsilon(1e-3));
  const Scalar close = 64 * std::numeric_limits<Scalar>::epsilon();
  REQUIRE(seen.crossings.size() == early.crossings.size());
  Scalar apart = 0;
  for (std::size_t i = 0; i < seen.crossings.size(); ++i)
    apart = std::max(apart, std::abs(seen.crossings[i] - early.crossings[i]));
  CHECK(apart <= close);
  // A time that is rounded to a step or so is served within that.
  REQUIRE(seen.at_times.size() == early.at_times.size());
  const Scalar rounding = late * std::numeric_limits<Scalar>::epsilon();
  for (std::size_t i = 0; i < seen.at_times.size(); ++i)
    CHECK(std::abs(seen.at_times[i] - early.at_times[i]) <= close + 3 * rounding);
}

}  // namespace

TEST_CASE("Observers see at late times what they see at early ones", "[observers][long]") {
  same_at<double>(1.7e9, 2e-2, 20'000);
  same_at<double>(2.1e12, 0.02, 20'000);
  same_at<double>(1e13, 1e-3, 20'000);  // a step is half the distance of two numbers
  same_at<float>(1e4F, 0.02F, 20'000);
  same_at<float>(4e5F, 0.02F, 20'000);
}

namespace {
/// The states a few roundings of the time behind a step, and before the first one, by steps of 1/8.
template <class Scalar>
void meets_times_to_rounding(Scalar late) {
  const auto h =
      from_energy<1, Scalar>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; });
  const Scalar infinity = std::numeric_limits<Scalar>::infinity(), step = late + 5,
               rounding = std::nextafter(step, infinity) - step;
  for (const int behind : {1, 2, 3, 4})
    for (const bool turned : {false, true}) {
      const Scalar dt = turned ? -0.125 : 0.125, start = turned ? late + 10 : late,
                   wanted = step + Scalar(turned ? -behind : behind) * rounding;
      CAPTURE(late, behind, turned);
      GaussLegendre stepper(h, {.stages = 4});
      PhasePoint<Scalar, 1> z(std::cos(Scalar(start - late)), -std::sin(Scalar(start - late)));
      Scalar off = infinity;
      auto at = at_times(h, {wanted}, [&](Scalar t, const auto& x) {
        off = std::hypot(x.q()[0] - std::cos(t - late), x.p()[0] + std::sin(t - late));
      });
      integrate(stepper, z, {.dt = dt, .steps = 80, .t0 = start}, at);
      CHECK(off <= rounding + 64 * std::numeric_limits<Scalar>::epsilon());
    }
}
}  // namespace

TEST_CASE("A time behind a step by a few roundings is met to one of them", "[observers]") {
  meets_times_to_rounding<double>(0);
  meets_times_to_rounding<double>(1e12);
  meets_times_to_rounding<float>(1000);
  meets_times_to_rounding<float>(16384);
  meets_times_to_rounding<float>(4e5F);
  meets_times_to_rounding<float>(1e7F);  // eight steps from one number to the next
  // The last one, where a run of such steps ends before it by rounding.
  const auto h = henon_heiles<float>();
  GaussLegendre stepper(h, {.stages = 4});
  PhasePoint<float, 2> z({0, -0.25F}, {0.42F, 0});
  int calls = 0;
  auto at = at_times(h, {1e7F + 11}, [&](float, const auto& x) {
    ++calls;
    CHECK(x.vector() == z.vector());
  });
  integrate(stepper, z, {.dt = 0.125F, .steps = 80, .t0 = 1e7F}, at);
  CHECK(calls == 0);
  at.finish();
  at.finish();
  CHECK(calls == 1);
}

namespace {
/// A ball q₁ over the floor, beside an oscillator q₂.
template <class Scalar>
auto ball_and_oscillator() {
  return make_hamiltonian<Scalar, 2>(
      [](const auto& q, const auto& p) { return (p[0] * p[0] + p[1] * p[1] + q[1] * q[1]) / 2 + q[0]; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 1;
        dHdq[1] = q[1];
        dHdp = p;
      });
}

/// The states at the crossings of q₂ = 0 while the ball bounces.
template <class Scalar>
std::vector<Scalar> crossings_beside_bounces(Scalar t0) {
  const auto h = ball_and_oscillator<Scalar>();
  Semiexplicit stepper(h, schemes::blanes_moan6<Scalar>());
  PhasePoint<Scalar, 2> z({Scalar(0.05), Scalar(1)}, {Scalar(0), Scalar(0)});
  std::vector<Scalar> crossings;
  auto section = poincare_section(
      h, [](const auto& q, const auto&) { return q[1]; },
      [&](Scalar, const auto& at) {
        for (const Scalar& x : at.vector()) crossings.push_back(x);
      },
      {.direction = CrossingDirection::both});
  auto bounces = events(h, on_event([](const auto& q, const auto&) { return q[0]; },
                                    [](Scalar, PhasePoint<Scalar, 2>& at) { at.p()[0] = -at.p()[0]; },
                                    CrossingDirection::falling));
  integrate(stepper, z, {.dt = Scalar(0.02), .steps = 4000, .t0 = t0}, bounces, section);
  section.finish();
  return crossings;
}
}  // namespace

TEST_CASE("Sections beside events see at late times what they see at early ones", "[observers][long]") {
  const auto early = crossings_beside_bounces(0.0);
  REQUIRE(early.size() == 4 * 25);
  for (const double t0 : {1e9, 1e13, 1e16}) CHECK(crossings_beside_bounces(t0) == early);
  const auto early_in_float = crossings_beside_bounces(0.0F);
  REQUIRE(early_in_float.size() == 4 * 25);
  for (const float t0 : {1e4F, 4e5F}) CHECK(crossings_beside_bounces(t0) == early_in_float);
}

TEST_CASE("Observers do not forget steps in a long run of floats", "[observers][long]") {
  // 64 ε t exceeds dt after 131072 steps.
  const Seen<float> seen(0, 0.02F, 200'000);
  const Seen<double> wide(0, 0.02, 200'000);
  CHECK(seen.served == 6);
  CHECK(std::abs(double(seen.count) / double(wide.count) - 1) < 0.02);
  CHECK(seen.exponent == Approx(wide.exponent).epsilon(0.3));  // chaotic, so other orbits of the same sea
}

TEST_CASE("Lyapunov exponents of floats do not drift", "[observers][long]") {
  const auto saddle =
      from_energy<1, float>([](const auto& q, const auto& p) { return (p[0] * p[0] - q[0] * q[0]) / 2; });
  Semiexplicit stepper(saddle, schemes::low_defect4_s7<float>(),
                       SimplifiedNewton{.stop = StoppingRule::product(1e-8)});
  LyapunovExponents lyapunov(stepper, 1);
  PhasePoint<float, 1> z(0, 0);
  integrate(stepper, z, {.dt = 0.02F, .steps = 300'000}, lyapunov);
  CHECK(lyapunov.exponents()[0] == Approx(1).epsilon(0.002));
}

}  // namespace test_late_times
