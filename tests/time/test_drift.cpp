// Reversible steps over thousands of periods.

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

#include "kepler.hpp"

namespace test_drift {

namespace {

using namespace semiexplicit;
using Point = PhasePoint<double, 2>;
const double pi = std::acos(-1.0);

/// Relative error of the energy after the run so far, its worst.
struct Drift {
  double worst = 0, sum = 0;
  std::int64_t count = 0;
  void operator()(double, const Point& z) {
    const double error = Kepler().energy(z.q(), z.p()) / -0.5 - 1;
    worst = std::max(worst, std::abs(error));
    sum += error;
    ++count;
  }
};

}  // namespace

TEST_CASE("Eccentric orbits of Kepler keep their energy without drift under reversible steps",
          "[reversible steps][long]") {
  for (const double e : {0.9, 0.99}) {
    CAPTURE(e);
    ReversibleSteps stepper(ExplicitSplitting(Kepler(), schemes::suzuki_umeno8()), monitors::Distance{});
    Point z = kepler_orbit(e, pi);
    const auto part = [&](double t0, double t1) {
      Drift drift;
      integrate(stepper, z, {.dt = 0.15, .t0 = t0, .t_end = t1}, drift);
      return drift;
    };
    const Drift early = part(0, 100 * 2 * pi);
    part(100 * 2 * pi, 1900 * 2 * pi);
    const Drift late = part(1900 * 2 * pi, 2000 * 2 * pi);
    CHECK(early.worst < 1e-4);
    CHECK(late.worst < 1.02 * early.worst);
    // The mean of the error would move with a drift, however small its share of the worst.
    const double mean = early.sum / double(early.count), later = late.sum / double(late.count);
    CHECK(std::abs(later - mean) < 1e-2 * std::abs(early.worst));
    CHECK(stepper.swing() < 0.01);
    CHECK(stepper.restarts() == 0);
  }
}

}  // namespace test_drift
