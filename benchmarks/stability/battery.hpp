#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace stability {

/// How one method did on one case, with the best of its settings.
struct Outcome {
  std::string setting;    ///< scheme, step, what it was chosen from
  bool survived = false;  ///< came to the end, within the bounds of the case
  double t = 0;           ///< how far it came
  double energy = 0;      ///< worst relative errors
  double invariant = 0;
  std::int64_t gradients = 0;
  double seconds = 0;
};

/// A line of the table: a case, and every method in the order of method_names().
struct Line {
  std::string name, why;
  double dt = 0, t_end = 0, energy_bound = 0, invariant_bound = 0;
  std::vector<Outcome> outcomes;
};

const std::vector<std::string>& method_names();

/// Every case with every method, for `part` of the long time (1: all of it), those named `only` if that is
/// not empty.
std::vector<Line> run_battery(double part, const std::string& only);

}  // namespace stability
