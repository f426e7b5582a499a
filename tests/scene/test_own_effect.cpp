#include "catch.hpp"

#include <cmath>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace test_own_effect {

using namespace semiexplicit;
using namespace semiexplicit::effects;

struct Trap {  // k|q|²/2
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "trap";
  double k = 1;
  double energy(const auto& q) const { return k * (q[0] * q[0] + q[1] * q[1]) / 2; }
  void add_gradient(const auto& q, auto& dHdq) const {
    dHdq[0] += k * q[0];
    dHdq[1] += k * q[1];
  }
};

TEST_CASE("A user's own effect goes into a scene like any other", "[scene]") {
  static_assert(PositionEffect<Trap>);
  // A trap in a frame that turns, seen from outside: an oscillator of frequency √k.
  const double omega = 0.3, t = 10;
  const Scene scene(orbits::Kinetic<double, 2>{}, Trap{.k = 4},
                    orbits::RotatingFrame<double, 2>{.omega = omega});
  static_assert(!decltype(scene)::separable);
  auto stepper = stepper_for(scene);
  PhasePoint<double, 2> z({1, 0}, {0, 1});
  integrate(stepper, z, {.dt = 0.02, .steps = 500});
  const double x = std::cos(2 * t), y = std::sin(2 * t) / 2;
  CHECK(z.q()[0] == Approx(std::cos(omega * t) * x + std::sin(omega * t) * y).margin(1e-8));
  CHECK(z.q()[1] == Approx(std::cos(omega * t) * y - std::sin(omega * t) * x).margin(1e-8));

  // Without the frame nothing is coupled, and nothing doubled.
  static_assert(decltype(Scene(orbits::Kinetic<double, 2>{}, Trap{}))::separable);
}

}  // namespace test_own_effect
