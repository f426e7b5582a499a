#pragma once

#include <string>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/solvers/stopping.hpp>
#include <semiexplicit/time/monitors.hpp>

namespace semiexplicit {

/// An integrator with everything that it needs but the Hamiltonian: the coordinates of a point on the curve
/// of accuracy against work. A plain value, to be kept, printed, edited, and run by run() or
/// CostOfAccuracy::run().
struct Setting {
  enum class Method {
    semiexplicit,  ///< Semiexplicit with simplified Newton: `scheme` and `rule` count
    midpoint,      ///< MidpointProjection: `scheme` counts
    gauss,         ///< Gauss-Legendre with fixed-point iteration: `stages` counts
    gauss_lanes,   ///< the same with its stages in SIMD lanes, where H has a gradient for packs
    splitting      ///< ExplicitSplitting, where H is separable: `scheme` counts
  };

  Method method = Method::semiexplicit;
  std::string scheme{};  ///< a name that schemes::by_name() knows
  StoppingRule rule = StoppingRule::product();
  int stages = 0;  ///< 1 to 8
  double dt = 0;   ///< the step, in the Hamiltonian's unit of time; of reversible ones in that of `pace`
  /// By ReversibleSteps, which follow the motion: g is monitors::TimeScale of these sizes. The method is one
  /// of the others, and a step that of time = g ds.
  bool reversible = false;
  monitors::TimeScaleOptions<double> pace{};

  bool is_gauss() const { return method == Method::gauss || method == Method::gauss_lanes; }

  /// "low_defect6_s13", "midpoint low_defect4_s7", "splitting blanes_moan6", "gauss_s4", "gauss_lanes_s4"
  /// (four stages), "reversible low_defect6_s13": what tells two settings apart beside dt and rule.
  SEMIEXPLICIT_COLD std::string name() const {
    const std::string steps = reversible ? "reversible " : "";
    switch (method) {
      case Method::midpoint:
        return steps + "midpoint " + scheme;
      case Method::splitting:
        return steps + "splitting " + scheme;
      case Method::gauss:
        return steps + "gauss_s" + std::to_string(stages);
      case Method::gauss_lanes:
        return steps + "gauss_lanes_s" + std::to_string(stages);
      case Method::semiexplicit:
        break;
    }
    return steps + scheme;
  }

  /// "product(1e-16)" for the semiexplicit method, "fixed point" for Gauss-Legendre, "none" for what is
  /// explicit.
  SEMIEXPLICIT_COLD std::string solver() const {
    if (is_gauss()) return "fixed point";
    if (method != Method::semiexplicit) return "none";
    return (rule.kind == StoppingRule::Kind::product ? "product(" : "paper(") +
           detail::in_words(rule.tolerance, 2) + ")";
  }
};

}  // namespace semiexplicit
