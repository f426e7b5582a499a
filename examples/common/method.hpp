#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "arguments.hpp"

namespace examples {

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

  /// Tao's map takes compositions of Strang only, and low_defect6_s13 needs the projection, so these two have
  /// defaults of their own.
  std::string scheme_name() const {
    return scheme.value_or(name == "tao"         ? "yoshida6"
                           : name == "splitting" ? "blanes_moan6"
                                                 : "low_defect6_s13");
  }

  /// What the table and the legend call the coefficients.
  std::string coefficients() const {
    return name == "gauss" ? counted(stages, "stage") + (lanes ? ", lanes" : "") : scheme_name();
  }

  /// Does it work with two copies of the phase space?
  bool doubles() const { return name != "gauss" && name != "splitting"; }

  StoppingRule stopping_rule() const {
    return rule == "paper" ? StoppingRule::paper(tolerance.value_or(1e-13))
                           : StoppingRule::product(tolerance.value_or(1e-16));
  }
};

/// Hands `use` the stepper of midpoint or semiexplicit: of steps that are projected to one point, and so have
/// tangent vectors.
template <class H, class Use>
void with_projected_stepper(const Method& method, const H& hamiltonian, const Use& use) {
  const auto hand = [&](auto stepper) { use(stepper); };
  const auto scheme = schemes::by_name<typename H::Scalar>(method.scheme_name());
  if (method.name == "midpoint")
    hand(MidpointProjection(hamiltonian, scheme));
  else if (method.solver == "broyden")
    hand(Semiexplicit(hamiltonian, scheme, Broyden{.stop = method.stopping_rule()}));
  else
    hand(Semiexplicit(hamiltonian, scheme, SimplifiedNewton{.stop = method.stopping_rule()}));
}

/// Makes the stepper that `method` names and hands it to `use`. Throws std::invalid_argument where the
/// settings do not fit together.
template <class H, class Use>
void with_stepper(const Method& method, const H& hamiltonian, const Use& use) {
  const auto hand = [&](auto stepper) { use(stepper); };
  const auto scheme = [&] { return schemes::by_name<typename H::Scalar>(method.scheme_name()); };
  // What is separable by its type gets the plain splitting, which no other Hamiltonian can have.
  if constexpr (SeparableHamiltonian<H>) {
    hand(ExplicitSplitting(hamiltonian, scheme()));
  } else if (method.name == "gauss") {
    if (!method.lanes) return hand(GaussLegendre(hamiltonian, {.stages = method.stages}));
    if constexpr (HasPackGradient<H>) return hand(GaussLegendreLanes(hamiltonian, {.stages = method.stages}));
    throw std::invalid_argument("--lanes: this Hamiltonian has no gradient for packs; leave it out");
  } else if (method.name == "pihajoki") {
    hand(Pihajoki(hamiltonian, scheme()));
  } else if (method.name == "tao") {
    hand(Tao(hamiltonian, scheme(), method.omega));
  } else {
    with_projected_stepper(method, hamiltonian, use);
  }
}

/// The options of the methods that a program takes.
inline void add_method(CLI::App& app, Method& method,
                       const std::vector<std::string>& methods = Method::names()) {
  const auto choice = [&](const char* name, std::string& value, const std::vector<std::string>& words,
                          const std::string& about) {
    add_value(app, name, value, about + ": " + joined(words), one_of(words), "NAME");
  };
  const auto has = [&](const char* name) {
    return std::find(methods.begin(), methods.end(), name) != methods.end();
  };
  choice("--method", method.name, methods, "the integrator");
  app.add_option("--scheme", method.scheme,
                 std::string("its coefficients") + (has("gauss") ? " (not of gauss)" : "") +
                     ", by a name from the list below")
      ->check(one_of(schemes::names()))
      ->type_name("NAME")
      ->default_str(std::string("low_defect6_s13") + (has("tao") ? "; tao: yoshida6" : ""));
  choice("--solver", method.solver, {"newton", "broyden"}, "of the semiexplicit projection");
  choice("--rule", method.rule, {"product", "paper"}, "when the solver may stop");
  app.add_option("--tolerance", method.tolerance,
                 "of that rule: drift in a step relative to the state, or size of the next correction")
      ->check(positive())
      ->type_name("X")
      ->default_str("product: 1e-16, paper: 1e-13");
  if (has("tao"))
    add_value(app, "--omega", method.omega, "coupling of the copies in tao",
              number<double>("a finite number", [](double x) { return std::isfinite(x); }));
  if (has("gauss")) add_value(app, "--stages", method.stages, "of gauss, 1 to 8", whole_number(1, 8), "N");
  app.footer("Schemes: " + joined(schemes::names()) + ".");
}

/// Refuses options that none of the methods that run listens to.
inline void refuse_idle_options(const CLI::App& app, const std::vector<std::string>& methods) {
  const std::vector<std::pair<const char*, std::vector<std::string>>> all{
      {"--scheme", {"semiexplicit", "midpoint", "pihajoki", "tao", "splitting"}},
      {"--solver", {"semiexplicit"}},
      {"--rule", {"semiexplicit"}},
      {"--tolerance", {"semiexplicit"}},
      {"--omega", {"tao"}},
      {"--stages", {"gauss"}}};
  for (const auto& [option, listeners] : all)
    if (is_given(app, option) && std::find_first_of(methods.begin(), methods.end(), listeners.begin(),
                                                    listeners.end()) == methods.end())
      throw std::invalid_argument(option + std::string(" means nothing to ") + joined(methods) +
                                  "; it is for " + joined(listeners));
}

}  // namespace examples
