// A double pendulum from its energy alone, and a gradient by hand with a wrong sign.
#include <cmath>
#include <iostream>
#include <sstream>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

struct Mistaken {  // H = (q² + 1)(p² + 1)/2
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = -q[0] * (p[0] * p[0] + 1);  // it is +
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
};

int main() {
  const auto H = from_energy<2>([](const auto& q, const auto& p) {
    using std::cos;
    const auto c = cos(q[0] - q[1]);
    return (p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c) / (2 * (2 - c * c)) - 2 * cos(q[0]) -
           cos(q[1]);
  });
  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  PhasePoint<double, 2> z({0.5, -0.8}, {0, 0});
  Invariants invariants(H);
  integrate(stepper, z, {.dt = 0.1, .steps = 1000}, invariants);
  std::cout << "worst energy error: " << invariants["energy"].worst << '\n';

  std::ostringstream verdict;
  verdict << check_gradient(Mistaken(), PhasePoint<double, 1>(-3, 0.5));
  std::cout << verdict.str()
            << '\n';  // dH/dq[0] is 3.75, but by the energy it is -3.75 (+- ...): the sign is wrong

  return invariants["energy"].worst < 1e-7 && verdict.str().ends_with("the sign is wrong") ? 0 : 1;
}
