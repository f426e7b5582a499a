// A program outside the project: its own Hamiltonian, a few steps, and the energy at the end.
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

struct Product {  // H = (q² + 1)(p² + 1)/2
  using Scalar = double;
  static constexpr int Dof = 1;
  using In = semiexplicit::In<double, 1>;
  using Out = semiexplicit::Out<double, 1>;

  double energy(In q, In p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(In q, In p, Out dHdq, Out dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1);
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
};

int main() {
  const Product H;
  semiexplicit::PhasePoint<double, 1> z(-3, 0);
  const double initial = H.energy(z.q(), z.p());

  semiexplicit::Semiexplicit stepper(H, semiexplicit::schemes::strang<double>());
  for (int step = 0; step < 100; ++step)
    if (!stepper.step(z, 1e-2).ok()) return 1;

  const double error = H.energy(z.q(), z.p()) - initial;
  std::cout << "energy error " << error << '\n';
  return std::abs(error) < 1e-2 ? 0 : 1;
}
