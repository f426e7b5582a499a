#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

double energy_error_after_a_step(double dt);

double energy_error_after_a_step(double dt) {
  using namespace semiexplicit;
  const auto energy = [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; };
  const auto H =
      make_hamiltonian<double, 1>(energy, [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0] * (p[0] * p[0] + 1);
        dHdp[0] = p[0] * (q[0] * q[0] + 1);
      });
  PhasePoint<double, 1> z(-3, 0);
  const double initial = energy(z.q(), z.p());
  Semiexplicit stepper(H, schemes::strang<double>());
  return stepper.step(z, dt).ok() ? std::abs(energy(z.q(), z.p()) - initial) : 1;
}
