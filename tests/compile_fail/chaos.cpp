// case no_mistake: compiles
// case no_derivative: the derivative of this stepper's step is not known: give TangentVectors, LyapunovExponents
// case of_a_hamiltonian: this stepper does not say what it moves: write `using Scalar = double; using State =
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/tao.hpp>
#include <semiexplicit/systems/product.hpp>

using namespace semiexplicit;

int main() {
#ifdef no_derivative
  const Tao stepper(systems::Product<double>(), schemes::strang(), 10);
#elif defined(of_a_hamiltonian)
  const systems::Product<double> stepper;
#else
  const Semiexplicit stepper(systems::Product<double>(), schemes::strang());
#endif
  const LyapunovExponents lyapunov(stepper, 1);
}
