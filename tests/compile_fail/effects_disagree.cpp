// error names: must agree on the degrees of freedom
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
using namespace semiexplicit::effects;

int main() { Scene scene(orbits::Kinetic<2>{}, orbits::Attraction<3>{}); }
