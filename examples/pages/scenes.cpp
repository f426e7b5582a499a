// An oscillator in a rotating frame: effects of the library and one of one's own, against the closed form.
#include <cmath>
#include <iostream>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

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

int main() {
  using namespace effects;
  const double omega = 0.3, t = 20;
  const Scene at_rest(orbits::Kinetic<double, 2>{}, Trap{});
  const Scene turning(orbits::Kinetic<double, 2>{}, Trap{}, orbits::RotatingFrame<double, 2>{.omega = omega});
  static_assert(at_rest.separable && !turning.separable);

  // At rest nothing couples q and p: stepper_for gives plain explicit splitting. In the turning frame the
  // angular momentum couples them, and it gives Semiexplicit.
  auto plain = stepper_for(at_rest);
  auto projected = stepper_for(turning);
  const PhasePoint<double, 2> start({1, 0}, {0, 0.5});
  PhasePoint<double, 2> z = start, z_turning = start;
  integrate(plain, z, {.dt = 0.05, .steps = 400});
  integrate(projected, z_turning, {.dt = 0.05, .steps = 400});

  // q(t) = (cos t, sin(t)/2), and in the turning frame the same point seen from axes that are ahead by omega
  // t.
  const Vector<double, 2> q(std::cos(t), std::sin(t) / 2);
  const double c = std::cos(omega * t), s = std::sin(omega * t);
  const Vector<double, 2> q_turning(c * q[0] + s * q[1], c * q[1] - s * q[0]);
  const double error = (z.q() - q).norm(), error_turning = (z_turning.q() - q_turning).norm();

  std::cout << "error at rest: " << error << ", in the turning frame: " << error_turning << '\n'
            << "gradient calls a step: " << plain.step(z, 0.05).gradients << " and "
            << projected.step(z_turning, 0.05).gradients << '\n';
  return error < 1e-8 && error_turning < 1e-8 ? 0 : 1;
}
