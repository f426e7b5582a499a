// Which method, which step, for an energy error of 1e-6 over T = 2000, and for a position? Ask, run, compare.
#include <iostream>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct VaryingMass {  // p²/(2(1 + q²)) + q²/2
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / (2 * (1 + q[0] * q[0])) + q[0] * q[0] / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double velocity = p[0] / (1 + q[0] * q[0]);
    dHdq[0] = q[0] - velocity * velocity * q[0];
    dHdp[0] = velocity;
  }
};

int main() {
  const VaryingMass H;
  PhasePoint<double, 1> z(2, 0);
  const double T = 2000, target = 1e-6;

  const auto cost = cost_of_accuracy(H, z, T, {.targets = {target}});
  const auto advice = cost.cheapest(target);
  if (!advice) return 1;

  Invariants invariants(H);
  const IntegrationReport done = cost.run(z, *advice, invariants);
  std::cout << *advice << '\n'
            << "reached: " << invariants["energy"].worst << " in " << done.gradients << " gradient calls\n";

  // The phase of the motion is off by more than the energy, and the more so the longer the run.
  const auto position = [](const auto& q, const auto&) { return q[0]; };
  const auto of_position =
      cost_of_accuracy(H, PhasePoint<double, 1>(2, 0), T, {.observable = position, .targets = {target}});
  if (const auto other = of_position.cheapest(target)) std::cout << *other << '\n';
  return invariants["energy"].worst < 3 * target ? 0 : 1;
}
