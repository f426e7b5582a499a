#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

namespace paper {

/// One integration: everything its result depends on.
struct Experiment {
  std::string problem;
  std::string method;
  double dt = 0, time = 0;
  double epsilon = 1e-13;             ///< of the solver; explicit methods do without
  std::string solver = "simplified";  ///< or "broyden"; of the semiexplicit methods
  bool as_published = true;           ///< or with the library's steppers and the physical Hamiltonian
  bool series = false;                ///< follow the invariants over time, too
  int rounding = 0;                   ///< the first position starts this many units in the last place higher

  std::int64_t steps() const { return std::llround(time / dt); }
  /// A name that tells it from every other experiment, fit for a file.
  std::string key() const;
};

/// What came of it. Numbers that were never seen are NaN.
struct Result {
  std::string status = "success";  ///< or why it ended early
  double t = 0;                    ///< where it ended
  double steps = 0;
  double evaluations = 0;  ///< a step, on average: NW_itr
  double gradients = 0;    ///< a step, on average
  double seconds = 0;
  double max_error = 0;    ///< largest accepted correction
  double max_defect = 0;   ///< of the copies after a step
  double unconverged = 0;  ///< steps that were taken without convergence

  std::vector<double> worst;  ///< largest relative error of every invariant, where followed

  bool ok() const { return status == "success"; }
};

/// A folder of results, one file an experiment. A file appears when it is whole, so whatever is there is
/// done.
class Results {
 public:
  explicit Results(std::filesystem::path folder) : folder_(std::move(folder)) {}

  std::filesystem::path file(const Experiment& experiment) const {
    return folder_ / (experiment.key() + ".csv");
  }
  bool has(const Experiment& experiment) const { return std::filesystem::exists(file(experiment)); }
  Result get(const Experiment& experiment) const;
  /// Runs it, with `label` before the progress bar, and keeps the result.
  void make(const Experiment& experiment, const std::string& label) const;

 private:
  std::filesystem::path folder_;
};

}  // namespace paper
