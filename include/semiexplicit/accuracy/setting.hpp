#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/accuracy/any_stepper.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/gauss_legendre.hpp>
#include <semiexplicit/steppers/gauss_legendre_lanes.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit {

/// An integrator with everything that it needs but the Hamiltonian: the coordinates of a point on the curve of accuracy
/// against work. A plain value, to be kept, printed, edited, and run by run() or stepper_for().
struct Setting {
  enum class Method {
    semiexplicit,  ///< Semiexplicit with simplified Newton: `scheme` and `rule` count
    gauss,         ///< GaussLegendre with fixed-point iteration: `stages` counts
    gauss_lanes    ///< GaussLegendreLanes: the same with its stages in SIMD lanes
  };

  Method method = Method::semiexplicit;
  std::string scheme{};  ///< a name that schemes::by_name() knows
  StoppingRule rule = StoppingRule::product();
  int stages = 0;  ///< 1 to 8
  double dt = 0;   ///< the step, in the Hamiltonian's unit of time

  /// "low_defect6_s13", "gauss_s4", "gauss_lanes_s4" (four stages): what tells two settings apart beside dt and rule.
  SEMIEXPLICIT_COLD std::string name() const {
    if (method == Method::semiexplicit) return scheme;
    return (method == Method::gauss ? "gauss_s" : "gauss_lanes_s") + std::to_string(stages);
  }

  /// "product(1e-16)" for the semiexplicit method, "fixed point" for the others.
  SEMIEXPLICIT_COLD std::string solver() const {
    if (method != Method::semiexplicit) return "fixed point";
    return (rule.kind == StoppingRule::Kind::product ? "product(" : "paper(") +
           detail::in_words(rule.tolerance, 2) + ")";
  }
};

/// The stepper of a setting: a Semiexplicit, a GaussLegendre or a GaussLegendreLanes. Throws std::invalid_argument for an
/// unknown scheme, a number of stages outside 1 to 8, and for stages in lanes where H has no gradient for packs.
///
///     auto stepper = stepper_for(H, advice.setting);
///     stepper.step(z, advice.setting.dt);
template <Hamiltonian H>
SEMIEXPLICIT_COLD AnyStepper<typename H::Scalar, H::Dof> stepper_for(const H& hamiltonian,
                                                                     const Setting& setting) {
  using Any = AnyStepper<typename H::Scalar, H::Dof>;
  switch (setting.method) {
    case Setting::Method::semiexplicit:
      return Any(Semiexplicit(hamiltonian, schemes::by_name<typename H::Scalar>(setting.scheme),
                              SimplifiedNewton{.stop = setting.rule}));
    case Setting::Method::gauss:
      return Any(GaussLegendre(hamiltonian, {.stages = setting.stages}));
    case Setting::Method::gauss_lanes:
      if constexpr (HasPackGradient<H>)
        return Any(GaussLegendreLanes(hamiltonian, {.stages = setting.stages}));
      throw std::invalid_argument(
          "stepper_for: this Hamiltonian has no gradient for packs; take Setting::Method::gauss");
  }
  throw std::invalid_argument("stepper_for: setting.method is none of Setting::Method");
}

/// Integrates z over the time T with a setting: in the fewest equal steps that are no longer than setting.dt. Observers,
/// report and failures as integrate() has them. Throws std::invalid_argument unless T and setting.dt are finite and
/// positive, and as stepper_for() does.
///
///     const CostRow advice = cost.cheapest(1e-8).value();
///     Invariants invariants(H);
///     run(H, z, T, advice.setting, invariants);
template <Hamiltonian H, class... Observers>
IntegrationReport run(const H& hamiltonian, PhasePoint<typename H::Scalar, H::Dof>& z, double T,
                      const Setting& setting, Observers&&... observers) {
  if (!(T > 0 && std::isfinite(T)))
    throw std::invalid_argument("run: T is not a finite positive time; give how long to integrate");
  if (!(setting.dt > 0 && std::isfinite(setting.dt)))
    throw std::invalid_argument("run: setting.dt is not a finite positive step; set it");
  AnyStepper<typename H::Scalar, H::Dof> stepper = stepper_for(hamiltonian, setting);
  using Scalar = typename H::Scalar;
  return integrate(stepper, z, {.dt = Scalar(setting.dt), .t_end = Scalar(T)},
                   std::forward<Observers>(observers)...);
}

}  // namespace semiexplicit
