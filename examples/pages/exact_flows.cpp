// Mercury with relativity: Kepler's motion is exact, only relativity is doubled. And an effect of one's own
// with a flow.
#include <cmath>
#include <iostream>
#include <numbers>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
namespace orbits = effects::orbits;

struct Spring {  // k|q|²/2
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "spring";
  double k = 1;
  double energy(const auto& q) const { return k * (q[0] * q[0] + q[1] * q[1]) / 2; }
  void add_gradient(const auto& q, auto& dHdq) const {
    dHdq[0] += k * q[0];
    dHdq[1] += k * q[1];
  }
};

template <>
struct semiexplicit::ExactFlow<orbits::Kinetic<double, 2>, Spring> {
  static constexpr const char* name = "harmonic oscillator";
  ExactFlow(const orbits::Kinetic<double, 2>&, const Spring& spring) : w(std::sqrt(spring.k)) {}
  Status increments(const double& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const double half = std::sin(w * t / 2), sine = 2 * half * std::cos(w * t / 2), less = 2 * half * half;
    for (int i = 0; i < 2; ++i) {
      dq[i] = sine / w * p[i] - less * q[i];
      dp[i] = -sine * w * q[i] - less * p[i];
    }
    return Status::success;
  }
  double w;
};

int main() {
  const double gm = 4 * std::numbers::pi * std::numbers::pi, a = 0.38709893, e = 0.20563069;  // au, years
  const Scene scene(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                    orbits::PostNewtonian1<double, 3>{.gm = gm, .c = 63241.077});
  auto doubled = stepper_for(scene);
  auto exact = stepper_for(scene, exactly<orbits::Kinetic<double, 3>, orbits::Attraction<double, 3>>());

  const PhasePoint<double, 3> start({a * (1 - e), 0, 0}, {0, std::sqrt(gm / a * (1 + e) / (1 - e)), 0});
  std::cout << explain(doubled) << '\n' << explain(exact, start) << '\n';

  // A century with 38 steps an orbit, and with five.
  PhasePoint<double, 3> z = start, z_exact = start;
  Invariants invariants(scene), invariants_exact(scene);
  const IntegrationReport run = integrate(doubled, z, {.dt = 0.0064, .t_end = 100}, invariants);
  const IntegrationReport run_exact =
      integrate(exact, z_exact, {.dt = 0.0482, .t_end = 100}, invariants_exact);
  std::cout << "doubled: " << run.gradients << " gradient calls, energy error " << invariants["energy"].worst
            << '\n'
            << "exact:   " << run_exact.gradients << " gradient calls, energy error "
            << invariants_exact["energy"].worst << '\n';

  // The spring in a frame that turns slowly.
  const Scene own(orbits::Kinetic<double, 2>{}, Spring{.k = 2},
                  orbits::RotatingFrame<double, 2>{.omega = 1e-4});
  auto oscillator = stepper_for(own, exactly<orbits::Kinetic<double, 2>, Spring>());
  PhasePoint<double, 2> y({1, 0}, {0, 0.5});
  Invariants invariants_own(own);
  integrate(oscillator, y, {.dt = 0.5, .steps = 1000}, invariants_own);
  std::cout << explain(oscillator) << ", energy error " << invariants_own["energy"].worst << '\n';

  return invariants_exact["energy"].worst < 1e-8 && run_exact.gradients < run.gradients / 10 &&
                 invariants_own["energy"].worst < 1e-8
             ? 0
             : 1;
}
