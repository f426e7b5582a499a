#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "task.hpp"

namespace work_precision {

struct ScanOptions {
  int samples = 400;       ///< looks at a run
  int repetitions = 5;     ///< of a careful timing
  double batch = 0.01;     ///< seconds: shorter runs are repeated until a timing has lasted so long
  double margin = 1.5;     ///< how far from its family's front a setting may be to be timed carefully
  std::size_t rivals = 2;  ///< settings a family and target that are timed carefully, besides the front
  bool is_short = false;
};

/// One setting and all that was measured of it.
struct Row {
  std::size_t line = 0;
  Method method;
  double parameter = 0;  ///< as Line::run takes it
  double dt = 0;         ///< 0: adaptive
  double tolerance = 0;  ///< of the adaptive ones
  Outcome outcome;
  Errors errors;
  double seconds = 0;
  int timings = 1;         ///< that `seconds` is the median of
  std::string line_end{};  ///< why the scan of the line went no further, in its last row

  bool ok() const { return outcome.ok(); }
  bool careful() const { return ok() && timings > 1; }
};

/// The levels of the tables: 1e-3 to 1e-13.
const std::vector<double>& targets();

/// Runs every line from its coarsest setting on, each setting once under watch and, where that is short, once
/// for the clock. A line ends where its error no longer falls, where its family has long done better with as
/// high an order, or where a run would take too long.
std::vector<Row> scan(const Task& task, const ScanOptions& options);

/// Times what could be first at a target or is on a front of its family again, in turns, and keeps the
/// medians.
void time_carefully(const Task& task, std::vector<Row>& rows, const ScanOptions& options);

/// Indices of the rows of these families that no other of them beats in error and cost together, by falling
/// error. For times only the carefully timed rows count, unless `all`.
enum class Cost { seconds, gradients };
double cost_of(const Row& row, Cost cost);
std::vector<std::size_t> front(const std::vector<Row>& rows, const std::vector<std::string>& of_families,
                               Cost cost, bool all = false);

/// Which error a target is about.
using ErrorOf = double (*)(const Row& row);
inline double energy_error(const Row& row) { return row.errors.energy; }
inline double invariant_error(const Row& row) { return row.errors.worst_invariant(); }
inline double trajectory_error(const Row& row) { return row.errors.trajectory; }

/// The cheapest row of these families whose error is within the target, of those that front() looks at; null:
/// there is none.
const Row* cheapest(const std::vector<Row>& rows, const std::vector<std::string>& of_families, Cost cost,
                    double target, ErrorOf error = energy_error);

/// Runs that are too long to be repeated: watched, and timed by their parts. Takes the settings of the same
/// problem's carefully timed `rows`, to the time `short_end`, that were the cheapest of their family at a
/// target. What was twenty times as dear there as another setting with no larger an error is left out.
std::vector<Row> long_runs(const Task& task, const std::vector<Row>& rows, double short_end,
                           const ScanOptions& options);

}  // namespace work_precision
