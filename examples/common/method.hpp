#pragma once

#include <optional>
#include <string>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace examples {

using namespace semiexplicit;
using namespace semiexplicit::effects;

/// A method chosen by name, and its settings.
struct Method {
  std::string name = "semiexplicit";
  std::optional<std::string> scheme{};
  std::string solver = "newton";
  std::string rule = "product";
  std::optional<double> tolerance{};
  double omega = 100;
  int stages = 3;
  bool lanes = false;  ///< of gauss: its stages in SIMD lanes; only --accuracy chooses them

  static std::vector<std::string> names() { return {"semiexplicit", "midpoint", "pihajoki", "tao", "gauss"}; }

  /// Tao's map takes compositions of Strang only, and low_defect6_s13 needs the projection, so these two have defaults of
  /// their own.
  std::string scheme_name() const {
    return scheme.value_or(name == "tao"         ? "yoshida6"
                           : name == "splitting" ? "blanes_moan6"
                                                 : "low_defect6_s13");
  }

  /// What the table and the legend call the coefficients.
  std::string coefficients() const {
    return name == "gauss" ? std::to_string(stages) + (lanes ? " stages, lanes" : " stages") : scheme_name();
  }

  /// Does it work with two copies of the phase space?
  bool doubles() const { return name != "gauss" && name != "splitting"; }

  StoppingRule stopping_rule() const {
    return rule == "paper" ? StoppingRule::paper(tolerance.value_or(1e-13))
                           : StoppingRule::product(tolerance.value_or(1e-16));
  }
};

/// with_stepper() for a Hamiltonian that is not known to be separable.
template <class H, class Use>
void with_general_stepper(const Method& method, const H& hamiltonian, const Use& use) {
#ifdef SEMIEXPLICIT_HAS_PACKS
  if constexpr (HasPackGradient<H>) {
    if (method.name == "gauss" && method.lanes) {
      GaussLegendreLanes stepper(hamiltonian, {.stages = method.stages});
      return use(stepper);
    }
  }
#endif
  if (method.name == "gauss") {
    GaussLegendre stepper(hamiltonian, {.stages = method.stages});
    return use(stepper);
  }
  const auto scheme = schemes::by_name<typename H::Scalar>(method.scheme_name());
  if (method.name == "pihajoki") {
    Pihajoki stepper(hamiltonian, scheme);
    use(stepper);
  } else if (method.name == "tao") {
    Tao stepper(hamiltonian, scheme, method.omega);
    use(stepper);
  } else if (method.name == "midpoint") {
    MidpointProjection stepper(hamiltonian, scheme);
    use(stepper);
  } else if (method.solver == "broyden") {
    Semiexplicit stepper(hamiltonian, scheme, Broyden{.stop = method.stopping_rule()});
    use(stepper);
  } else {
    Semiexplicit stepper(hamiltonian, scheme, SimplifiedNewton{.stop = method.stopping_rule()});
    use(stepper);
  }
}

/// Makes the stepper that `method` names and hands it to `use`. Throws std::invalid_argument where the settings do
/// not fit together.
template <class H, class Use>
void with_stepper(const Method& method, const H& hamiltonian, const Use& use) {
  // What is separable by its type gets the plain splitting, which no other Hamiltonian can have.
  if constexpr (SeparableHamiltonian<H>) {
    ExplicitSplitting stepper(hamiltonian, schemes::by_name<typename H::Scalar>(method.scheme_name()));
    return use(stepper);
  } else {
    with_general_stepper(method, hamiltonian, use);
  }
}

}  // namespace examples
