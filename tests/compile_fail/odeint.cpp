// case no_mistake: compiles
// case state_of_whole_numbers: the state is of whole numbers, or ones of fewer digits than the stepper's, to which each step would be rounded
// case state_of_floats: the state is of whole numbers, or ones of fewer digits than the stepper's, to which each step would be rounded
// case pair_of_floats: the state is of whole numbers, or ones of fewer digits than the stepper's, to which each step would be rounded
#include <array>
#include <utility>
#include <vector>

#include <semiexplicit/compat/odeint.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>
#include <semiexplicit/systems/product.hpp>

using namespace semiexplicit;

int main() {
  OdeintStepper stepper(Semiexplicit(systems::Product<double>(), schemes::strang<double>()));
#if defined(state_of_whole_numbers)
  std::array x{-3, 0};
#elif defined(state_of_floats)
  std::vector<float> x{-3, 0};
#elif defined(pair_of_floats)
  std::pair<std::vector<float>, std::vector<float>> x{{-3}, {0}};
#else
  std::vector<long double> x{-3, 0};
#endif
  stepper.do_step(stepper.system(), x, 0.0, 0.1);
}
