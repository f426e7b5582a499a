#pragma once

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/cost/setting.hpp>

namespace semiexplicit {

/// What "cheapest" is measured in.
enum class CostBy {
  gradients,  ///< gradient calls: the same on every machine and at every load
  seconds     ///< processor time, measured on the spot
};

/// A setting, and what a run with it over the whole time is expected to give and to cost.
struct CostRow {
  Setting setting{};
  double error = 0;      ///< largest relative energy error (absolute where H(z0) = 0)
  double gradients = 0;  ///< gradient calls
  double seconds = 0;    ///< of processor time
  bool drifts =
      false;  ///< the error may grow with time: what unfinished solves add up to is over a third of it
  Status status = Status::success;  ///< why the setting failed in a trial; the figures above are NaN then
  bool confirmed = false;           ///< tried on more of the run than the other rows
  bool interpolated = false;        ///< between two trials of the same scheme, instead of tried itself

  bool works() const { return status == Status::success; }
  double cost(CostBy by) const { return by == CostBy::gradients ? gradients : seconds; }
};

/// The curve of accuracy against cost for one problem; made by cost_of_accuracy().
struct CostOfAccuracy {
  std::vector<CostRow> rows{};  ///< every setting that was tried: method by method, the largest step first
  std::vector<double> targets{};
  CostBy by = CostBy::gradients;

  double time = 0;         ///< T, the length of the run that is advised on
  double time_scale = 0;   ///< ‖z₀‖/‖X(z₀)‖, the characteristic time that the scan started from
  double pilot_time = 0;   ///< how far the coarse run went that found where the problem is hard
  double window_time = 0;  ///< length of the trial runs of each setting, all windows together
  int windows = 0;         ///< how many stretches that is
  double growth = 1;  ///< factor from the hardest stretch of the pilot run to the hardest of the whole time
  double spent_gradients = 0;  ///< what the scan itself took
  double spent_seconds = 0;    ///< of processor time, likewise

  /// The cheapest setting whose error is expected to stay below `target`, or nothing where none was found: `best()` says
  /// how near one comes. Between two trials of a scheme the step is interpolated.
  std::optional<CostRow> cheapest(double target) const {
    if (!(target > 0))
      throw std::invalid_argument("CostOfAccuracy::cheapest: target is not a positive error; give one");
    std::optional<CostRow> found;
    const auto offer = [&](const CostRow& row) {
      if (row.works() && row.error <= target && (!found || row.cost(by) < found->cost(by))) found = row;
    };
    for (const CostRow& row : rows) offer(row);
    for (std::size_t i = 1; i < rows.size(); ++i)
      if (rows[i - 1].setting.name() == rows[i].setting.name() && rows[i - 1].works() && rows[i].works() &&
          rows[i - 1].error > target && rows[i].error < target &&
          rows[i - 1].setting.dt > 1.25 * rows[i].setting.dt)
        offer(between(rows[i - 1], rows[i], target));
    return found;
  }

  /// The row of the smallest error, whatever it costs; nothing where no setting works.
  std::optional<CostRow> best() const {
    std::optional<CostRow> found;
    for (const CostRow& row : rows)
      if (row.works() && (!found || row.error < found->error)) found = row;
    return found;
  }

  /// What the scan took, as a fraction of the run that a row stands for.
  double fraction_of(const CostRow& row) const { return spent_gradients / row.gradients; }

 private:
  /// The setting between two of the same scheme, a with the larger step, whose error is `target`: errors and costs follow
  /// powers of the step.
  static CostRow between(const CostRow& a, const CostRow& b, double target) {
    const double w = std::log(a.error / target) / std::log(a.error / b.error);
    const auto mean = [w](double x, double y) { return std::pow(x, 1 - w) * std::pow(y, w); };
    CostRow row = b;
    row.setting.dt = mean(a.setting.dt, b.setting.dt);
    row.error = target;
    row.gradients = mean(a.gradients, b.gradients);
    row.seconds = mean(a.seconds, b.seconds);
    row.drifts = a.drifts || b.drifts;
    row.interpolated = true;
    row.confirmed = false;
    return row;
  }
};

/// One line: what to run, what it should give, what it costs.
inline std::ostream& operator<<(std::ostream& out, const CostRow& row) {
  char text[160];
  std::snprintf(text, sizeof text, "%-24s %-14s %10.4g %10.1e %12.3g %10.3g  %s", row.setting.name().c_str(),
                row.setting.solver().c_str(), row.setting.dt, row.error, row.gradients, row.seconds,
                row.works() ? (row.drifts ? "may drift" : "bounded") : "FAILED");
  return out << text;
}

/// The advice for every target, all that was tried, and what the figures rest on.
inline std::ostream& operator<<(std::ostream& out, const CostOfAccuracy& cost) {
  const auto text = [](const char* format, auto... numbers) {
    char line[200];
    std::snprintf(line, sizeof line, format, numbers...);
    return std::string(line);
  };
  const std::string header = text("%-24s %-14s %10s %10s %12s %10s  %s\n", "method", "solver", "dt", "error",
                                  "gradients", "seconds", "energy");
  out << "The cheapest " << (cost.by == CostBy::gradients ? "in gradient calls" : "in processor time")
      << text(" over T = %g, for a relative energy error of at most:\n", cost.time) << "         " << header;
  for (const double target : cost.targets) {
    out << text("%7.0e  ", target);
    if (const auto row = cost.cheapest(target))
      out << *row << text("; advice cost %.1f%%\n", 100 * cost.fraction_of(*row));
    else if (const auto best = cost.best())
      out << text("out of reach: the best found is %.1e\n", best->error);
    else
      out << "out of reach: no setting works\n";
  }
  out << "\nAll that was tried:\n         " << header;
  for (const CostRow& row : cost.rows) out << "         " << row << '\n';
  return out << text(
                    "\nEstimates. Each setting ran for a time of %.3g in %d windows: %.2g characteristic "
                    "times of %.3g,\n",
                    cost.window_time, cost.windows, cost.window_time / cost.time_scale, cost.time_scale)
             << text("at the start and along a coarse run to t = %.3g, where that was hardest among them.\n",
                     cost.pilot_time)
             << text(
                    "Assumed: the energy error stays bounded as a symplectic method's does, but for rounding "
                    "and\n"
                    "unfinished solves; times %.2g for what lies beyond the coarse run.\n",
                    cost.growth)
             << text("Spent: %.3g gradient calls, %.3g seconds.\n", cost.spent_gradients, cost.spent_seconds);
}

}  // namespace semiexplicit
