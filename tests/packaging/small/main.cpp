// The smallest program that the headers must arrive for: one projected step of the pendulum H = p²/2 - cos q,
// there and back.
#include <cmath>

#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

int main() {
  const auto pendulum = semiexplicit::make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - std::cos(q[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = std::sin(q[0]);
        dHdp[0] = p[0];
      });
  semiexplicit::PhasePoint<double, 1> z(1, 0);
  semiexplicit::Semiexplicit stepper(pendulum, semiexplicit::schemes::strang<double>());
  if (!stepper.step(z, 0.1).ok() || !(z.q()[0] < 1)) return 1;
  if (!stepper.step(z, -0.1).ok()) return 2;
  return std::abs(z.q()[0] - 1) < 1e-12 ? 0 : 3;
}
