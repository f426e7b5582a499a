// A particle whose mass depends on where it is: H = p²/(2 m(q)) + q²/2, m(q) = 1 + q².
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct VaryingMass {
  using Scalar = double;
  static constexpr int Dof = 1;

  double energy(In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / (2 * mass(q[0])) + q[0] * q[0] / 2;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double velocity = p[0] / mass(q[0]);
    dHdq[0] = q[0] - velocity * velocity * q[0];
    dHdp[0] = velocity;
  }
  static double mass(double q) { return 1 + q * q; }
};
static_assert(HasEnergy<VaryingMass>);  // a Hamiltonian, with the optional energy

int main() {
  const VaryingMass H;
  PhasePoint<double, 1> z(0.7, 0.4);

  // Is the gradient that of the energy? Central differences say so up to 1e-10.
  const double h = 1e-5;
  Vector<double, 1> dHdq, dHdp, step{h};
  H.gradient(z.q(), z.p(), dHdq, dHdp);
  const double by_q = (H.energy(z.q() + step, z.p()) - H.energy(z.q() - step, z.p())) / (2 * h);
  const double by_p = (H.energy(z.q(), z.p() + step) - H.energy(z.q(), z.p() - step)) / (2 * h);
  const double gradient_error = std::hypot(dHdq[0] - by_q, dHdp[0] - by_p);

  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  Invariants invariants(H);
  integrate(stepper, z, {.dt = 0.1, .steps = 10'000}, invariants);

  std::cout << "gradient against differences: " << gradient_error << '\n'
            << "worst relative energy error: " << invariants["energy"].worst << '\n';
  return gradient_error < 1e-9 && invariants["energy"].worst < 1e-8 ? 0 : 1;
}
