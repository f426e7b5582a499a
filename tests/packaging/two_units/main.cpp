#include <semiexplicit/semiexplicit.hpp>

double energy_error_after_a_step(double dt);  // the other unit's

int main() {
  using namespace semiexplicit;
  const auto scheme = schemes::strang<double>();
  return scheme.order == 2 && energy_error_after_a_step(1e-3) < 1e-3 ? 0 : 1;
}
