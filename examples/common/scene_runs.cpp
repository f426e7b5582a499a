// What the programs with scenes of these sizes have in common.
#include "scene_program.hpp"

namespace examples {

template struct OnHamiltonian<RuntimeScene<double, 3>>;
template struct OnHamiltonian<SeparableRuntimeScene<double, 3>>;
template struct OnHamiltonian<RuntimeScene<double, Eigen::Dynamic>>;
template struct OnHamiltonian<SeparableRuntimeScene<double, Eigen::Dynamic>>;

}  // namespace examples
