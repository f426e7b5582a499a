#pragma once

#include <stdexcept>
#include <string>
#include <vector>

#include "as_published.hpp"

namespace paper {

enum class Family {
  tao,
  pihajoki,
  semiexplicit,  ///< as the paper runs it
  merged,        ///< the same with neighbouring A flows of the composition merged, as the library has them
  library,       ///< the library's own: re-centred, default stopping rule
  gauss,         ///< implicit, as the paper's counts say it was solved
  gauss_newton,  ///< implicit, Newton's method
  gauss_fixed    ///< implicit, fixed-point iteration with extrapolated starting values
};

struct Method {
  std::string name;  ///< as the tables print it
  Family family;
  std::string scheme;  ///< of the splittings
  int stages;          ///< of the implicit ones
  int order;

  bool solves() const { return family == Family::semiexplicit || family == Family::merged; }
  bool doubled() const { return family == Family::tao || family == Family::pihajoki || solves(); }
};

inline const std::vector<Method>& methods() {
  static const std::vector<Method> list{
      {"Tao 2", Family::tao, "strang", 0, 2},
      {"semiexplicit 2", Family::semiexplicit, "strang", 0, 2},
      {"Midpoint", Family::gauss, "", 1, 2},
      {"Tao 4", Family::tao, "triple_jump4", 0, 4},
      {"semiexplicit 4", Family::semiexplicit, "triple_jump4", 0, 4},
      {"semiexplicit-S 4", Family::semiexplicit, "suzuki4", 0, 4},
      {"IRK4", Family::gauss, "", 2, 4},
      {"Tao 6", Family::tao, "triple_jump6", 0, 6},
      {"semiexplicit 6", Family::semiexplicit, "triple_jump6", 0, 6},
      {"semiexplicit-S 6", Family::semiexplicit, "suzuki6", 0, 6},
      {"semiexplicit-Y 6", Family::semiexplicit, "yoshida6", 0, 6},
      // Not in the tables.
      {"Pihajoki 2", Family::pihajoki, "strang", 0, 2},
      {"Pihajoki 4", Family::pihajoki, "triple_jump4", 0, 4},
      {"Pihajoki 6", Family::pihajoki, "triple_jump6", 0, 6},
      {"IRK6", Family::gauss, "", 3, 6},
      {"semiexplicit, Blanes-Moan 6", Family::merged, "blanes_moan6", 0, 6},
      {"semiexplicit, low defect 6", Family::merged, "low_defect6_s13", 0, 6},
      {"semiexplicit-S 4, merged", Family::merged, "suzuki4", 0, 4},
      {"semiexplicit-Y 6, merged", Family::merged, "yoshida6", 0, 6},
      {"library, Strang", Family::library, "strang", 0, 2},
      {"library, Suzuki 4", Family::library, "suzuki4", 0, 4},
      {"library, Yoshida 6", Family::library, "yoshida6", 0, 6},
      {"library, low defect 6", Family::library, "low_defect6_s13", 0, 6},
      {"Midpoint, Newton", Family::gauss_newton, "", 1, 2},
      {"IRK4, Newton", Family::gauss_newton, "", 2, 4},
      {"Midpoint, fixed point", Family::gauss_fixed, "", 1, 2},
      {"IRK4, fixed point", Family::gauss_fixed, "", 2, 4},
      {"IRK6, fixed point", Family::gauss_fixed, "", 3, 6},
  };
  return list;
}

inline const Method& method(const std::string& name) {
  for (const Method& m : methods())
    if (m.name == name) return m;
  throw std::invalid_argument("there is no method called " + name);
}

/// Calls use(stepper) with the stepper of that method.
template <class H, class Use>
void with_stepper(const Method& method, const H& hamiltonian, double omega, const std::string& solver,
                  double epsilon, bool as_published, const Use& use) {
  const auto run = [&](auto stepper) { use(stepper); };
  const auto scheme = [&] { return schemes::by_name(method.scheme); };
  const StoppingRule rule = StoppingRule::paper(epsilon);
  const auto project = [&](const auto& chosen) {
    if (as_published)
      run(AsPublished(hamiltonian, method.family == Family::semiexplicit ? unmerged(scheme()) : scheme(),
                      chosen));
    else
      run(Semiexplicit(hamiltonian, scheme(), chosen));
  };
  switch (method.family) {
    case Family::tao:
      return run(Tao(hamiltonian, scheme(), omega));
    case Family::pihajoki:
      return run(Pihajoki(hamiltonian, scheme()));
    case Family::semiexplicit:
    case Family::merged:
      return solver == "broyden" ? project(Broyden{.stop = rule, .memory = 100})
                                 : project(SimplifiedNewton{.stop = rule});
    case Family::library:
      return run(Semiexplicit(hamiltonian, scheme()));
    case Family::gauss:
      if (as_published) return run(GaussAsPublished(hamiltonian, method.stages, epsilon));
      [[fallthrough]];
    case Family::gauss_newton:
      return run(GaussLegendre(hamiltonian, {.stages = method.stages,
                                             .solver = StageSolver::newton,
                                             .tolerance = epsilon,
                                             .extrapolate = false}));
    case Family::gauss_fixed:
      return run(GaussLegendre(hamiltonian, {.stages = method.stages}));
  }
}

}  // namespace paper
