// A run that knows its error: estimates against closed forms.

#include "catch.hpp"

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "folder.hpp"
#include "kepler.hpp"
#include "oscillator.hpp"
#include "refusal.hpp"

namespace test_error_estimate {

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 2>;
const double pi = std::acos(-1.0);

/// How often the estimate is within a factor 3 of the true error, while both are small and above rounding.
template <class Stepper, class Companion>
void is_within_three(Stepper stepper, Companion companion, ErrorEstimateOptions options, double dt) {
  const double e = 0.4;
  Point z = kepler_orbit(e, 1);
  auto estimate = with_error_estimate(companion, options);
  int seen = 0, within = 0;
  integrate(stepper, z, {.dt = dt, .t0 = 1, .t_end = 40}, estimate, [&](double t, const Point& at) {
    const double error = (at.vector() - kepler_orbit(e, t).vector()).norm();
    if (error < 1e-12 || error > 1e-2) return;
    ++seen;
    REQUIRE(estimate.error());
    if (*estimate.error() < 3 * error && error < 3 * *estimate.error()) ++within;
  });
  CHECK(seen > 30);
  CHECK(within == seen);
  CHECK(estimate.gradients() > 0);
}

/// H = (|p|² + |q|²)/2 + x²y - y³/3, chaotic at the energy 1/6.
struct HenonHeiles {
  using Scalar = double;
  static constexpr int Dof = 2;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = q[0] + 2 * q[0] * q[1];
    dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
    dHdp = p;
  }
};

/// An own stepper without anything but a step.
struct Leapfrog {
  using Scalar = double;
  using State = Point;
  StepReport step(Point& z, const double& dt) {
    z.q() += dt / 2 * z.p();
    z.p() -= dt * z.q() / std::pow(z.q().squaredNorm(), 1.5);
    z.q() += dt / 2 * z.p();
    return {.evaluations = 1, .gradients = 1};
  }
};

}  // namespace

TEST_CASE("The estimate is within a factor of three of the error of Kepler's orbit", "[error estimate]") {
  const Kepler h;
  const Semiexplicit strang(h, schemes::strang()), sixth(h, schemes::blanes_moan6());
  is_within_three(strang, strang, {}, 0.002);
  is_within_three(sixth, sixth, {}, 0.1);
  const GaussLegendre gauss(h, {.stages = 2});
  is_within_three(gauss, gauss, {}, 0.03);
  is_within_three(Leapfrog(), Leapfrog(), {}, 0.002);
  // By a better method with steps of the same size.
  is_within_three(gauss, GaussLegendre(h, {.stages = 4}), {.parts = 1}, 0.03);
  // Along steps that follow the motion.
  const auto g = [](const auto& q, const auto&) { return std::pow(q.squaredNorm(), 0.75); };
  is_within_three(ReversibleSteps(sixth, g), sixth, {}, 0.15);
}

TEST_CASE("The estimate of a driven system is that of its state, whatever work the force does",
          "[error estimate]") {
  const double force = 1e4, w = 0.7, T = 100;
  const Autonomous forced(from_energy<1>([=](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (p[0] * p[0] + q[0] * q[0]) / 2 - force * q[0] * cos(w * t);
  }));
  const Semiexplicit stepper(forced, schemes::low_defect4_s7<double>());
  auto z = forced.extended({0, 0}, 0.0);
  auto estimate = with_error_estimate(stepper);
  auto run = stepper;
  integrate(run, z, {.dt = 0.1, .t_end = T}, estimate);
  const double size = force / (1 - w * w), q = size * (std::cos(w * T) - std::cos(T)),
               p = size * (std::sin(T) - w * std::sin(w * T));
  const double error = std::hypot(z.q()[0] - q, z.p()[0] - p);
  REQUIRE(estimate.error());
  CHECK(*estimate.error() < 3 * error);
  CHECK(error < 3 * *estimate.error());
}

TEST_CASE("The rounding of a step's weights, which the companion shares, is in the estimate",
          "[error estimate]") {
  const auto oscillator = [](auto number) {
    using T = decltype(number);
    return make_hamiltonian<T, 1>(
        [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
        [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = q[0];
          dHdp[0] = p[0];
        });
  };
  GaussLegendre stepper(oscillator(0.0), {.stages = 6});
  auto estimate = with_error_estimate(stepper);
  PhasePoint<double, 1> z(1, 0);
  integrate(stepper, z, {.dt = 0.0625, .t_end = 6250}, estimate);
  const double error = std::hypot(z.q()[0] - std::cos(6250.0), z.p()[0] + std::sin(6250.0));
  CHECK(error > 1e-12);
  REQUIRE(estimate.error());
  CHECK(*estimate.error() >= error / 3);
  CHECK(*estimate.error() <= error * 3);
  // That alone parts nobody.
  Semiexplicit in_float(oscillator(0.0F), schemes::low_defect6_s13<float>());
  auto strict = with_error_estimate(in_float, {.parted = 2e-5});
  PhasePoint<float, 1> x(1, 0);
  integrate(in_float, x, {.dt = 0.1F, .steps = 5000}, strict);
  REQUIRE(strict.error());
  CHECK(*strict.error() > 4e-5F);
}

TEST_CASE("That rounding counts by the speed of now where it is fast", "[error estimate]") {
  const double e = 0.8, T = 4 * std::acos(-1.0), steps = 20'000,
               epsilon = std::numeric_limits<double>::epsilon();
  GaussLegendre stepper(Kepler(), {.stages = 4});
  auto estimate = with_error_estimate(stepper, {.parts = 1});  // it shares all
  auto z = kepler_orbit(e, 0.0);
  double slow = 0;  // at the apocentre
  integrate(stepper, z, {.dt = T / steps, .t_end = T}, estimate, [&](double t, const Point&) {
    if (t < T / 4) slow = *estimate.error();
  });
  const double of_time = std::hypot(std::sqrt((1 + e) / (1 - e)), std::pow(1 - e, -2)) * epsilon * T;
  CHECK(*estimate.error() == Approx(of_time).epsilon(0.01));
  CHECK(slow < 0.2 * of_time);
  CHECK(*estimate.worst() >= *estimate.error());
}

TEST_CASE("Of wide numbers the estimate does not hold what dt is rounded to in a report",
          "[error estimate]") {
  const long double T = 1000;
  for (const long double dt : {0.1L, 0.125L}) {  // the latter is a double
    GaussLegendre stepper(OscillatorOf<long double>(), {.stages = 8});
    auto estimate = with_error_estimate(stepper);
    PhasePoint<long double, 1> z(1, 0);
    integrate(stepper, z, {.dt = dt, .t_end = T}, estimate);
    REQUIRE(estimate.error());
    const long double error = std::hypot(z.q()[0] - std::cos(T), z.p()[0] + std::sin(T));
    CHECK(*estimate.error() < 4 * error);
    CHECK(error < 4 * *estimate.error());
  }
}

TEST_CASE("Where orbits part the estimate says nothing, and when", "[error estimate]") {
  const HenonHeiles h;
  Semiexplicit stepper(h, schemes::blanes_moan6());
  Point z({0, 0.1}, {0.5, 0.1});
  z.p()[0] = std::sqrt(2 * (1.0 / 6 - 0.005 + 0.001 / 3) - 0.01);  // the energy is 1/6, nearly
  Record<double, 2> there;
  auto estimate = with_error_estimate(stepper, {}, there);
  double before = 0;
  integrate(stepper, z, {.dt = 0.2, .t_end = 2000}, estimate, [&](double t, const Point&) {
    if (estimate.error()) before = t;
  });
  REQUIRE(estimate.parted_at());
  CHECK_FALSE(estimate.error());
  CHECK_FALSE(estimate.worst());
  CHECK_FALSE(estimate.error_of([](const auto& q, const auto&) { return q[0]; }));
  // An exponent of 0.1 or so takes an error of 1e-6 a unit of time to the size of the orbit within some
  // hundreds.
  CHECK(*estimate.parted_at() > 20);
  CHECK(*estimate.parted_at() < 1000);
  CHECK(before < *estimate.parted_at());
  CHECK(before > *estimate.parted_at() - 0.5);
  CHECK(there.t.back() == before);  // the companion stands still from there on
}

TEST_CASE("Figures that are measured on both runs have an error", "[error estimate]") {
  // The time of the last passage of the pericentre, against whole periods.
  const Kepler h;
  const double e = 0.4;
  Semiexplicit stepper(h, schemes::blanes_moan4());
  double of_run = 0, of_companion = 0;
  const auto radial = [](const auto& q, const auto& p) { return q.dot(p); };
  auto section = poincare_section(h, radial, [&](double t, const Point&) { of_run = t; }, {.nodes = 6});
  auto other = poincare_section(h, radial, [&](double t, const Point&) { of_companion = t; }, {.nodes = 6});
  auto estimate = with_error_estimate(stepper, {}, other);
  Point z = kepler_orbit(e, 1);
  integrate(stepper, z, {.dt = 0.05, .t0 = 1, .t_end = 20 * 2 * pi + 1}, section, estimate);
  const double error = std::abs(of_run - 20 * 2 * pi);
  REQUIRE(estimate.error_of(of_run, of_companion));
  CHECK(error > 1e-9);
  CHECK(*estimate.error_of(of_run, of_companion) < 3 * error);
  CHECK(error < 3 * *estimate.error_of(of_run, of_companion));
  // The companion is the better one.
  CHECK((estimate.companion().vector() - kepler_orbit(e, 1).vector()).norm() <
        0.2 * (z.vector() - kepler_orbit(e, 1).vector()).norm());
  const auto x = [](const auto& q, const auto&) { return q[0]; };
  const double off = std::abs(z.q()[0] - kepler_orbit(e, 1).q()[0]);
  CHECK(*estimate.error_of(x) < 3 * off);
  CHECK(off < 3 * *estimate.error_of(x));
}

TEST_CASE("The run keeps its bits beside an estimate, and every() changes little of it", "[error estimate]") {
  const Kepler h;
  Semiexplicit stepper(h, schemes::blanes_moan6()), alone = stepper;
  Point z = kepler_orbit(0.4, 1), x = z;
  auto estimate = with_error_estimate(stepper), sparse = estimate;
  integrate(stepper, z, {.dt = 0.1, .steps = 400}, estimate, every(10, sparse));
  integrate(alone, x, {.dt = 0.1, .steps = 400});
  CHECK(z.vector() == x.vector());
  CHECK(*sparse.error() == Approx(*estimate.error()).epsilon(1e-3));
}

TEST_CASE("A sparse estimate of steps that choose their lengths is refused at the first it would guess",
          "[error estimate]") {
  const Semiexplicit fixed(Kepler(), schemes::blanes_moan4());
  ReversibleSteps stepper(fixed, monitors::Distance());
  Point z = kepler_orbit(0.8, 1);
  auto estimate = with_error_estimate(fixed);
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.05, .t_end = 41}, every(50, estimate)); },
                "take every() away"));
  CHECK(stepper.time() > 0);
  // Also where the ends of runs are hidden: the next state is one step into a run, and ten from the last one.
  auto next_run = stepper;
  z = kepler_orbit(0.4, 1);
  auto beside = with_error_estimate(fixed);
  auto sparse = every(10, beside);
  double t = 0;
  CHECK(refuses(
      [&] {
        for (int part = 0; part < 2; ++part)
          t = integrate(next_run, z, {.dt = 0.05, .steps = 9, .t0 = t}, sparse).t;
      },
      "take every() away"));
  ReversibleSteps again(fixed, monitors::Distance());
  z = kepler_orbit(0.8, 1);
  CHECK(integrate(again, z, {.dt = 0.05, .t_end = 41}, every(1, estimate)).ok());
  const double error = (z.vector() - kepler_orbit(0.8, 42).vector()).norm();
  REQUIRE(estimate.error());
  CHECK(*estimate.error() > error / 3);
  CHECK(*estimate.error() < 3 * error);
}

TEST_CASE("A sparse estimate counts on over runs that follow one another", "[error estimate]") {
  const Semiexplicit stepper(Kepler(), schemes::blanes_moan4());
  const auto run_of = [&](std::int64_t first) {
    auto moves = stepper;
    Point z = kepler_orbit(0.4, 1);
    auto estimate = with_error_estimate(stepper);
    auto sparse = every(4, estimate);
    integrate(moves, z, {.dt = 0.05, .steps = first}, sparse);
    if (first < 200)
      integrate(moves, z, {.dt = 0.05, .steps = 200 - first, .t0 = 0.05 * double(first)}, sparse);
    return estimate;
  };
  const auto whole = run_of(200);
  for (const std::int64_t first : {100, 99, 98, 97, 3, 150}) {
    CAPTURE(first);
    const auto parts = run_of(first);
    CHECK(parts.gradients() == whole.gradients());
    CHECK(*parts.error() == Approx(*whole.error()).epsilon(0.01));
  }
}

TEST_CASE("A sparse estimate goes on where a run turned between two of its states", "[error estimate]") {
  for (const int steps : {24, 25, 27}) {  // of 25 the next state is at the time of the last one
    CAPTURE(steps);
    Semiexplicit stepper(Kepler(), schemes::strang());
    auto estimate = with_error_estimate(stepper), each_step = estimate;
    auto tenth = every(10, estimate);
    Point z = kepler_orbit(0.4, 1);
    const auto there = integrate(stepper, z, {.dt = 0.01, .steps = steps}, tenth, each_step);
    integrate(stepper, z, {.dt = -0.01, .steps = 3 * steps, .t0 = there.t}, tenth, each_step);
    REQUIRE(estimate.error());
    CHECK(*estimate.error() == Approx(*each_step.error()).epsilon(0.3));
  }
}

TEST_CASE("An estimate goes on in a run from the last state, whatever its t0", "[error estimate]") {
  const Semiexplicit stepper(Kepler(), schemes::blanes_moan4());
  for (const double t0 : {0.0, 20.0}) {
    CAPTURE(t0);
    auto moves = stepper;
    Point z = kepler_orbit(0.4, 1);
    auto estimate = with_error_estimate(stepper);
    integrate(moves, z, {.dt = 0.05, .steps = 400}, estimate);
    integrate(moves, z, {.dt = 0.05, .steps = 20, .t0 = t0}, estimate);
    const double error = (z.vector() - kepler_orbit(0.4, 22).vector()).norm();
    CHECK(*estimate.error() < 3 * error);
    CHECK(error < 3 * *estimate.error());
  }
}

TEST_CASE("Observers of the companion are shown the times that those of the run are", "[error estimate]") {
  Semiexplicit stepper(Kepler(), schemes::blanes_moan4());
  Point z = kepler_orbit(0.4, 1);
  Record<double, 2> all, tenth, all_there, tenth_there;
  auto sparse = every(10, tenth);
  auto estimate = with_error_estimate(stepper, {}, all_there, every(10, tenth_there));
  for (const double t0 : {0.0, 1.5})
    integrate(stepper, z, {.dt = 0.1, .steps = 15, .t0 = t0}, all, sparse, estimate);
  CHECK(all_there.t == all.t);
  CHECK(tenth_there.t == tenth.t);
  CHECK(tenth.t.size() == 4);
}

TEST_CASE("A resumed run has the same estimate", "[error estimate]") {
  const Folder folder;
  const Kepler h;
  auto options = IntegrationOptions<double>{.dt = 0.1, .steps = 300};
  Semiexplicit stepper(h, schemes::blanes_moan6()), first = stepper, second = stepper;
  Point z = kepler_orbit(0.4, 1), x = z, y = z;
  auto whole = with_error_estimate(stepper), one = whole, two = whole;
  integrate(stepper, z, options, whole);
  {
    Checkpoints checkpoints(folder.path / "run", {.every = 100}, first, options, one);
    checkpoints.resume(x);
    integrate(first, x, options, one, checkpoints,
              [](double, const Point&, const IntegrationReport& run) { return run.steps < 150; });
  }
  Checkpoints checkpoints(folder.path / "run", {.every = 100}, second, options, two);
  options.done = checkpoints.resume(y);
  integrate(second, y, options, two, checkpoints);
  CHECK(*two.error() == *whole.error());
  CHECK(*two.worst() == *whole.worst());
  CHECK(two.companion().vector() == whole.companion().vector());
}

TEST_CASE("A companion that fails ends the estimate and not the run", "[error estimate]") {
  struct Fails : Leapfrog {
    int left = 50;
    StepReport step(Point& z, const double& dt) {
      if (left-- <= 0) return {.status = Status::no_convergence};
      return Leapfrog::step(z, dt);
    }
  };
  Leapfrog stepper;
  Point z = kepler_orbit(0.4, 1);
  auto estimate = with_error_estimate(Fails());
  const auto report = integrate(stepper, z, {.dt = 0.01, .steps = 100}, estimate);
  CHECK(report.steps == 100);
  CHECK_FALSE(estimate.error());
  CHECK(*estimate.parted_at() == Approx(0.26));
}

TEST_CASE("A companion that throws within its step goes on from before that", "[error estimate]") {
  struct Throws : Leapfrog {
    int left = 21;
    StepReport step(Point& z, const double& dt) {
      if (left-- == 0) throw std::runtime_error("no gradient");
      return Leapfrog::step(z, dt);
    }
  };
  Leapfrog stepper;
  Point z = kepler_orbit(0.4, 1), last = z;
  auto estimate = with_error_estimate(Throws()), whole = with_error_estimate(Throws{{}, -1});
  CHECK_THROWS_WITH(
      integrate(stepper, z, {.dt = 0.01, .steps = 20}, estimate, [&](double, const Point& at) { last = at; }),
      "no gradient");
  z = last;
  integrate(stepper, z, {.dt = 0.01, .steps = 10, .t0 = 0.1}, estimate);
  z = kepler_orbit(0.4, 1);
  integrate(stepper, z, {.dt = 0.01, .steps = 20}, whole);
  CHECK(*estimate.error() == Approx(*whole.error()).epsilon(1e-3));
}

TEST_CASE("An estimate refuses senseless options and states that an event has changed", "[error estimate]") {
  const Semiexplicit stepper(Kepler(), schemes::strang());
  CHECK(refuses([&] { with_error_estimate(stepper, {.parts = 0}); }, "parts"));
  CHECK(refuses([&] { with_error_estimate(stepper, {.parted = 0}); }, "parted"));
  auto run = stepper;
  auto estimate = with_error_estimate(stepper);
  Point z = kepler_orbit(0.4, 1);
  auto kick = events(Kepler(), on_event([](const auto& q, const auto&) { return q[1]; },
                                        [](double, Point& at) { at.p() *= 0.9; }));
  CHECK(refuses([&] { integrate(run, z, {.dt = 0.1, .steps = 100}, kick, estimate); }, "event"));
}

TEST_CASE("Nothing is estimated from the first step on that was cut into parts", "[error_estimate]") {
  const systems::Product<double> h;
  const SimplifiedNewton strict{.max_iterations = 5};
  Semiexplicit stepper(h, schemes::strang<double>(), strict);
  PhasePoint<double, 1> z(-3, 0);
  auto estimate = with_error_estimate(stepper);
  const auto run = integrate(stepper, z, {.dt = 0.2, .steps = 50, .subdivide = 8}, estimate);
  REQUIRE(run.subdivided > 0);
  CHECK_FALSE(estimate.error());
  CHECK(estimate.parted_at());
  z = PhasePoint<double, 1>(-0.3, 0);  // another run begins afresh
  integrate(stepper, z, {.dt = 0.01, .steps = 10}, estimate);
  CHECK(estimate.error());
}

TEST_CASE("An estimate refuses a state that its companion cannot take", "[error estimate]") {
  const systems::NlsLattice<double> four(4), five(5);
  auto estimate = with_error_estimate(MidpointProjection(four, schemes::strang<double>()));
  MidpointProjection of_four(four, schemes::strang<double>()), of_five(five, schemes::strang<double>());
  PhasePoint<double, Eigen::Dynamic> z(4), other(5);
  z.q()[0] = other.q()[0] = 1;
  integrate(of_four, z, {.dt = 0.01, .steps = 10}, estimate);
  CHECK(refuses([&] { integrate(of_five, other, {.dt = 0.01, .steps = 10}, estimate); },
                "the state has 5 degrees of freedom and the companion 4"));
  integrate(of_four, z, {.dt = 0.01, .steps = 10}, estimate);
  CHECK(estimate.error());
}

}  // namespace test_error_estimate
