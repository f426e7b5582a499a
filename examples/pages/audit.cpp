// A satellite about an oblate planet, with relativity: which effects does a given accuracy need? The answer
// chooses the effects of the run.
#include <cmath>
#include <iostream>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
namespace orbits = effects::orbits;

int main() {
  const RuntimeScene<double, 3> all{orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = 1},
                                    orbits::Oblateness<double>{.gm = 1, .j2 = 1e-3, .radius = 0.2},
                                    orbits::PostNewtonian1<double, 3>{.gm = 1, .c = 1e5}};
  const PhasePoint<double, 3> start({1, 0, 0}, {0, 0.9, 0.5});

  const Audit found = audit(all, start, 20.0, {.dt = 0.1, .samples = 20});
  std::cout << found;  // the table
  const auto wanted = found.called_for(1e-6);
  std::cout << "an accuracy of 1e-6 needs:";
  for (const std::string& name : wanted) std::cout << ' ' << name;
  std::cout << '\n';

  // The same choice by name; with_stepper_for takes explicit splitting where the chosen effects are
  // separable.
  PhasePoint<double, 3> z = start, z_all = start;
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 200};
  with_stepper_for(all.with_only(wanted), [&](auto& stepper) { integrate(stepper, z, options); });
  with_stepper_for(all, [&](auto& stepper) { integrate(stepper, z_all, options); });
  const double shift = (z.q() - z_all.q()).norm();
  std::cout << "shift by what is left out: " << shift << '\n';
  return wanted.size() == 3 && shift < 1e-6 ? 0 : 1;
}
