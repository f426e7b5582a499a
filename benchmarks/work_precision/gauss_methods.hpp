#pragma once

#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble.hpp>

#include "own_methods.hpp"

namespace work_precision {

/// Fixed-point Gauss-Legendre methods; tolerances relative to the state, 0: until rounding stops it.
template <template <class> class Method, class H>
void add_gauss(std::vector<Line>& lines, const char* family, const Problem<H>& problem, double end) {
  const double size = problem.size();
  const auto add = [&](int stages, double tolerance, bool extrapolate, bool in_short) {
    Method<H> stepper(problem.hamiltonian,
                      {.stages = stages, .tolerance = tolerance * size, .extrapolate = extrapolate});
    const std::string options = (tolerance > 0 ? "tolerance " + number(tolerance) : "to rounding") +
                                (extrapolate ? "" : ", no extrapolation");
    lines.push_back(line_of_steps({family, std::to_string(stages) + " stages", options, 2 * stages},
                                  std::move(stepper), problem, end, 3.0 * stages, in_short));
  };
  for (const int stages : {1, 2, 3, 4, 6, 8}) {
    for (const double tolerance : {0.0, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-3})
      add(stages, tolerance, true, tolerance == 0 && stages == 4);
    for (const double tolerance : {0.0, 1e-8}) add(stages, tolerance, false, false);
  }
}

/// The scalar method, and where the gradient takes packs the one with its stages in SIMD lanes.
template <class H>
void add_gauss_methods(std::vector<Line>& lines, const Problem<H>& problem, double end) {
  add_gauss<GaussLegendre>(lines, family::gauss, problem, end);
  if constexpr (HasPackGradient<H>) add_gauss<GaussLegendreLanes>(lines, family::gauss_lanes, problem, end);
}

}  // namespace work_precision
