// Needs the component boost
// Ten oscillations of the solvable product by odeint's integrate_const, on a std::vector.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include <boost/numeric/odeint/integrate/integrate_const.hpp>
#include <semiexplicit/compat/odeint.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>
#include <semiexplicit/systems/product.hpp>

using namespace semiexplicit;

int main() {
  OdeintStepper stepper(Semiexplicit(systems::Product<double>(), schemes::low_defect6_s13<double>()));
  std::vector<double> x{-3, 0};  // q, p
  double worst = 0;
  const auto watch = [&](const std::vector<double>& at, double) {
    worst = std::max(worst, std::abs((at[0] * at[0] + 1) * (at[1] * at[1] + 1) / 2 - 5));
  };
  boost::numeric::odeint::integrate_const(stepper, stepper.system(), x, 0.0, 32.6, 0.05, watch);
  std::cout << "q = " << x[0] << ", p = " << x[1] << ", worst error of the energy: " << worst << '\n';
  return worst < 1e-6 ? 0 : 1;
}
