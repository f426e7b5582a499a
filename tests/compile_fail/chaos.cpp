// case no_mistake: compiles
// case no_derivative: the derivative of this stepper's step is not known: give TangentVectors, LyapunovExponents
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/tao.hpp>
#include <semiexplicit/systems/product.hpp>

using namespace semiexplicit;

int main() {
#ifdef no_derivative
  const Tao stepper(systems::Product<double>(), schemes::strang(), 10);
#else
  const Semiexplicit stepper(systems::Product<double>(), schemes::strang());
#endif
  const LyapunovExponents lyapunov(stepper, 1);
}
