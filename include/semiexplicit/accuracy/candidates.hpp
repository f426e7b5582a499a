#pragma once

#include <functional>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/schemes/named.hpp>

namespace semiexplicit::detail {

/// One scheme or number of stages, and its trials by the step, the largest first.
struct Candidate {
  Setting setting{};
  int order = 2;
  double kicks = 1;  ///< gradient calls a step, usually
  double unit = 1;   ///< time that a dt of 1 stands for, usually
  double rate = 0;   ///< gradient calls a unit of time, where it met the last aim
  std::map<double, Probe, std::greater<>> trials{};

  bool projects() const { return setting.method == Setting::Method::semiexplicit; }
  bool is_symplectic() const { return setting.method != Setting::Method::midpoint && !setting.reversible; }
  Setting with_step(double dt) const {
    Setting result = setting;
    result.dt = dt;
    return result;
  }
};

/// Candidates of one kind, from loose to tight targets.
using Family = std::vector<Candidate>;

/// Every way that there is for a Hamiltonian. Throws std::invalid_argument for what is misspelled, and where
/// there is none.
template <class Any>
SEMIEXPLICIT_COLD std::vector<Family> families_for(const Problem<Any>& problem) {
  using Method = Setting::Method;
  const auto& options = problem.options;
  std::vector<Family> all;
  const auto add_schemes = [&](Method method, const std::vector<std::string>& names, double per_kick) {
    if (names.empty()) return;
    all.emplace_back();
    for (const std::string& name : names) {
      const auto scheme = schemes::by_name<double>(name);
      all.back().push_back({.setting = {.method = method, .scheme = name},
                            .order = scheme.order,
                            .kicks = per_kick * static_cast<double>(scheme.kicks())});
    }
  };
  if (problem.hamiltonian.is_separable()) add_schemes(Method::splitting, options.splittings, 0.5);
  add_schemes(Method::semiexplicit, options.schemes, 1);
  add_schemes(Method::midpoint, options.schemes, 1);
  if (options.gauss_stages.empty()) {
    if (all.empty())
      throw std::invalid_argument(
          "cost_of_accuracy: options.schemes and options.gauss_stages are both empty, and there is no "
          "splitting to try; give something to try");
    return all;
  }
  // In gradient calls the stages in lanes are no better: they only win in time.
  const bool lanes = problem.hamiltonian.takes_packs() && options.by == CostBy::seconds;
  all.emplace_back();
  for (const int stages : options.gauss_stages)
    all.back().push_back(
        {.setting = {.method = lanes ? Method::gauss_lanes : Method::gauss, .stages = stages},
         .order = 2 * stages,
         .kicks = 14.0 * stages});
  return all;
}

/// Those of these families that can go by reversible steps, with that pace; `unit`: the time that a step of 1
/// takes, usually.
SEMIEXPLICIT_COLD inline std::vector<Family> reversible(std::vector<Family> families,
                                                        const monitors::TimeScaleOptions<double>& pace,
                                                        double unit) {
  using Method = Setting::Method;
  // Gauss's method gains less: it loses the start of its stages where the step changes.
  std::erase_if(families, [](const Family& f) {
    return f.front().setting.method == Method::midpoint || f.front().setting.is_gauss();
  });
  for (Family& family : families)
    for (Candidate& candidate : family) {
      candidate.setting.reversible = true, candidate.setting.pace = pace;
      candidate.unit = unit;
    }
  return families;
}

}  // namespace semiexplicit::detail
