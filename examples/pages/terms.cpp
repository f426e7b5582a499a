// The nonlinear Schrödinger lattice with 32 sites, from its energy as a sum over sites and bonds; its largest
// exponent.
#include <cmath>
#include <iostream>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() {
  constexpr Eigen::Index n = 32;
  Eigen::VectorXd disorder(n);
  for (Eigen::Index i = 0; i < n; ++i) disorder[i] = std::sin(7.0 * double(i * i));

  const auto H = from_energy(n, [=](const auto& q, const auto& p) {
    const auto sites = sum_over(n, [&](auto i) {
      const auto density = (q[i] * q[i] + p[i] * p[i]) / 2;
      return at(disorder, i) * density + density * density / 2;
    });
    const auto bonds = sum_over(n - 1, [&](auto i) { return q[i] * q[i + 1] + p[i] * p[i + 1]; });
    return sites - bonds;
  });

  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  PhasePoint<double, Eigen::Dynamic> z(n);
  for (Eigen::Index i = 12; i < 20; ++i) z.q()[i] = 1;
  Invariants invariants(H);
  LyapunovExponents lyapunov(stepper, 1);
  integrate(stepper, z, {.dt = 0.2, .steps = 50}, invariants, lyapunov);

  std::cout << "worst relative energy error: " << invariants["energy"].worst << '\n'
            << "largest exponent at t = 10: " << lyapunov.exponents()[0] << '\n';
  return invariants["energy"].worst < 1e-6 && lyapunov.exponents()[0] > 0 ? 0 : 1;
}
