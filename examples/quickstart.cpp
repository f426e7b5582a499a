#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() {
  // H = (q² + 1)(p² + 1)/2: not a sum of a function of p and a function of q
  const auto H =
      from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; });

  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  PhasePoint<double, 1> z(-3, 0);
  Invariants invariants(H);
  const IntegrationReport run = integrate(stepper, z, {.dt = 0.1, .steps = 100'000}, invariants);

  std::cout << "q = " << z.q() << ", p = " << z.p() << " at t = " << run.t << '\n'
            << "worst relative energy error: " << invariants["energy"].worst << '\n'
            << "evaluations per step: " << double(run.evaluations) / double(run.steps) << '\n';
}
