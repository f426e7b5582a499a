#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/accuracy/cost_table.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit {

/// What cost_of_accuracy() tries, and how hard.
struct CostOptions {
  std::vector<double> targets{1e-4, 1e-6, 1e-8,
                              1e-10};  ///< relative energy errors to find the cheapest setting for
  /// Gradient calls to spend, as a fraction of those of the runs to the targets, added up. A guide, which hard problems
  /// overrun by a factor of two or so: CostOfAccuracy::spent_gradients says what it came to.
  double budget = 0.1;
  double min_gradients = 30'000;  ///< but no less: where the run is shorter, advice costs a larger part of it
  /// Bound on the gradient calls that the scan takes, which is kept whatever the Hamiltonian; the guide above ends at a
  /// third of it. What it leaves unfinished counts as out of reach, and CostOfAccuracy::why() says so.
  double max_gradients = 1e7;
  CostBy by = CostBy::gradients;  ///< what is to be cheap
  /// Schemes of the semiexplicit method, from loose to tight targets.
  std::vector<std::string> schemes{"low_defect4_s7",  "low_defect4_s11", "low_defect6_s13",
                                   "low_defect6_s15", "low_defect8_s20", "sofroniou_spaletta10"};
  std::vector<int> gauss_stages{2, 3, 4, 6, 8};  ///< of the Gauss-Legendre method, rising
};

namespace detail {

SEMIEXPLICIT_COLD inline void check(const CostOptions& options) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("cost_of_accuracy: " + what);
  };
  if (options.targets.empty()) refuse("options.targets is empty; give at least one error to aim for");
  for (const double target : options.targets)
    if (!(target > 0 && target < 1))
      refuse("options.targets holds " + in_words(target, 3) + "; give relative errors between 0 and 1");
  if (!(options.budget > 0 && options.budget <= 1e6))
    refuse("options.budget is " + in_words(options.budget, 3) + "; give a fraction of the run, as 0.05");
  if (!(options.min_gradients >= 0 && std::isfinite(options.min_gradients)))
    refuse("options.min_gradients is negative or not finite; give a number of gradient calls");
  if (!(options.max_gradients >= 1000))
    refuse("options.max_gradients is below 1000; give a bound that leaves room for a few steps");
  if (options.schemes.empty() && options.gauss_stages.empty())
    refuse("options.schemes and options.gauss_stages are both empty; give something to try");
  for (const int stages : options.gauss_stages)
    if (stages < 1 || stages > 8)
      refuse("options.gauss_stages holds " + std::to_string(stages) + "; give numbers from 1 to 8");
}

}  // namespace detail
}  // namespace semiexplicit
