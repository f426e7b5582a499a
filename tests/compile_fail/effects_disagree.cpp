// error names: must agree on the degrees of freedom
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() { Scene scene(orbits::Kinetic<2>{}, orbits::Attraction<3>{}); }
