// The programs with three degrees of freedom.
#include "scene_program.hpp"

namespace examples {

template int run_scene_program(const SceneProgram<3>& program, int argc, char** argv, const NoKernel& kernel);

}  // namespace examples
