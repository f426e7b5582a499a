#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct Product {  // H = (q² + 1)(p² + 1)/2
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1);
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
};

int main() {
  Semiexplicit stepper(Product{}, schemes::low_defect6_s13<double>());
  PhasePoint<double, 1> z(-3, 0);
  Invariants invariants(Product{});
  const IntegrationReport run = integrate(stepper, z, {.dt = 0.1, .steps = 100'000}, invariants);

  std::cout << "q = " << z.q() << ", p = " << z.p() << " at t = " << run.t << '\n'
            << "worst relative energy error: " << invariants["energy"].worst << '\n'
            << "evaluations per step: " << double(run.evaluations) / double(run.steps) << '\n';
}
