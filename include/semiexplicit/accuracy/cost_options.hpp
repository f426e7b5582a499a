#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/accuracy/cost_table.hpp>
#include <semiexplicit/accuracy/observable.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit {

/// What cost_of_accuracy() judges by, what it tries, and how hard. Scalar and Dof are those of H, and follow
/// from it where the options are written in braces in the call: {.observable = f, .by = CostBy::seconds}.
template <class Scalar, int Dof>
struct CostOptionsOf {
  Observable<Scalar, Dof> observable{};  ///< what is to be accurate; without one, the energy
  std::vector<double> targets{1e-4, 1e-6, 1e-8,
                              1e-10};  ///< errors to find the cheapest setting for; see CostTable
  bool absolute = false;               ///< errors are in the observable's own unit, instead of relative
  /// Gradient calls to spend, as a fraction of those of the runs to the targets, added up. A guide: three
  /// times as many where the whole run can then be seen, four where growth is to be seen behind the trials.
  double budget = 0.1;
  /// But no less, of 10 degrees of freedom or fewer; of more, in proportion, as 167,000 of 300. Where that
  /// suffices, as it does for runs of up to some 200,000 calls, settings are tried over all of T.
  double min_gradients = 5e6;
  /// Bound on the gradient calls that the search takes, which is kept whatever the Hamiltonian. What it
  /// leaves unfinished counts as out of reach, and CostTable::why() says so: also where a neighbouring orbit
  /// could not be followed for long.
  double max_gradients = 1e7;
  /// Advise only what was run over all of T, and so has met its target; max_gradients alone then bounds the
  /// search. Else what was tried over a part of T is a forecast.
  bool whole = false;
  CostBy by = CostBy::gradients;  ///< what is to be cheap
  /// Schemes of the semiexplicit method and of the midpoint projection, from loose to tight targets.
  std::vector<std::string> schemes{"low_defect4_s7",  "low_defect4_s11", "low_defect6_s13",
                                   "low_defect6_s15", "low_defect8_s20", "sofroniou_spaletta10"};
  std::vector<int> gauss_stages{2, 3, 4, 6, 8};  ///< of the Gauss-Legendre method, rising
  /// Schemes of the explicit splitting, for a Hamiltonian that is separable (SeparableHamiltonian), from
  /// loose to tight.
  std::vector<std::string> splittings{"blanes_moan4", "blanes_moan6", "sofroniou_spaletta8",
                                      "sofroniou_spaletta10"};
  /// Also the semiexplicit method and splittings by ReversibleSteps with monitors::TimeScale, where the time
  /// scales along the orbit differ by more than four and H does not depend on the time.
  bool reversible = true;
};

/// Options to be kept in a variable, whatever the Hamiltonian: an observable then sees columns of dynamic
/// size.
using CostOptions = CostOptionsOf<double, Eigen::Dynamic>;

namespace detail {

template <class Scalar, int Dof>
SEMIEXPLICIT_COLD void check(const CostOptionsOf<Scalar, Dof>& options) {
  const auto refuse = [](const std::string& what) {
    throw std::invalid_argument("cost_of_accuracy: " + what);
  };
  if (options.targets.empty()) refuse("options.targets is empty; give at least one error to aim for");
  for (const double target : options.targets)
    if (!(target > 0 && std::isfinite(target) && (options.absolute || target < 1)))
      refuse("options.targets holds " + in_words(target, 3) + "; give relative errors between 0 and 1");
  if (!(options.budget > 0 && options.budget <= 1e6))
    refuse("options.budget is " + in_words(options.budget, 3) + "; give a fraction of the run, as 0.05");
  if (!(options.min_gradients >= 0 && std::isfinite(options.min_gradients)))
    refuse("options.min_gradients is negative or not finite; give a number of gradient calls");
  if (!(options.max_gradients >= 1000))
    refuse("options.max_gradients is below 1000; give a bound that leaves room for a few steps");
  for (const int stages : options.gauss_stages)
    if (stages < 1 || stages > 8)
      refuse("options.gauss_stages holds " + std::to_string(stages) + "; give numbers from 1 to 8");
}

}  // namespace detail
}  // namespace semiexplicit
