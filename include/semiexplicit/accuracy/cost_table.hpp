#pragma once

#include <cmath>
#include <cstdint>
#include <iomanip>
#include <limits>
#include <locale>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/accuracy/setting.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit {

/// What "cheapest" is measured in.
enum class CostBy {
  gradients,  ///< gradient calls: the same on every machine and at every load
  seconds     ///< processor time, measured on the spot
};

/// A setting, and what a run with it over the whole time is expected to give and to cost.
struct CostRow {
  Setting setting{};
  double error = 0;      ///< largest relative energy error (absolute unless CostOfAccuracy::relative)
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

/// Whether a target can be met, and if not, why.
enum class Reach {
  met,         ///< CostOfAccuracy::cheapest() has a setting for it
  rounding,    ///< it is below what rounding, or noise, does to the energy
  budget,      ///< the gradient calls ended first
  orbit_ends,  ///< no step goes beyond CostOfAccuracy::orbit_end
  no_step      ///< none of the settings that were tried meets it
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
  double budget = 0;  ///< gradient calls that the scan was to take: a guide
  double spent_gradients = 0;  ///< what the scan itself took
  double spent_seconds = 0;    ///< of processor time, likewise

  bool relative =
      true;  ///< errors are relative to H(z0); false: that is zero up to rounding, and they are absolute
  double rounding = 0;  ///< no error below this can be told from rounding, or noise, of the energy
  double orbit_end = std::numeric_limits<double>::infinity();  ///< time that no step tried got beyond
  double unfinished = 0;  ///< the loosest target whose search ended with the calls; 0: none

  /// Why a target is out of reach.
  SEMIEXPLICIT_COLD Reach reach(double target) const {
    if (cheapest(target)) return Reach::met;
    if (orbit_end < time) return Reach::orbit_ends;
    if (target < rounding) return Reach::rounding;
    return target <= unfinished ? Reach::budget : Reach::no_step;
  }
  /// The same in words, with what to do about it; empty where the target is met.
  SEMIEXPLICIT_COLD std::string why(double target) const {
    switch (reach(target)) {
      case Reach::met:
        return "";
      case Reach::rounding:
        return "errors below " + detail::in_words(rounding, 2) +
               " are lost in the rounding or noise of the energy, which may be small beside its terms";
      case Reach::budget:
        return "the gradient calls ended; raise options.budget, min_gradients or max_gradients";
      case Reach::orbit_ends:
        return "the orbit ends near t = " + detail::in_words(orbit_end, 3) +
               ": no step goes beyond; give a shorter T";
      case Reach::no_step:
        return "no step of those tried meets it";
    }
    return "";
  }

  /// The cheapest setting whose error is expected to stay below `target`, or nothing where none was found: `best()` says
  /// how near one comes. Between two trials of a scheme the step is interpolated.
  SEMIEXPLICIT_COLD std::optional<CostRow> cheapest(double target) const {
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
  SEMIEXPLICIT_COLD std::optional<CostRow> best() const {
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
  SEMIEXPLICIT_COLD static CostRow between(const CostRow& a, const CostRow& b, double target) {
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

namespace detail {

/// A number in a column, in the classic locale.
SEMIEXPLICIT_COLD inline std::string figure(double x, int digits, int width, bool scientific = false) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  if (scientific) out << std::scientific;
  out << std::setprecision(digits) << std::setw(width) << x;
  return out.str();
}
SEMIEXPLICIT_COLD inline std::string column(const std::string& text, std::size_t width, bool right = false) {
  const std::string space(width > text.size() ? width - text.size() : 0, ' ');
  return right ? space + text : text + space;
}

}  // namespace detail

/// One line: what to run, what it should give, what it costs.
SEMIEXPLICIT_COLD inline std::ostream& operator<<(std::ostream& out, const CostRow& row) {
  using detail::column, detail::figure;
  return out << column(row.setting.name(), 24) + ' ' + column(row.setting.solver(), 14) + ' ' +
                    figure(row.setting.dt, 4, 10) + ' ' + figure(row.error, 1, 10, true) + ' ' +
                    figure(row.gradients, 3, 12) + ' ' + figure(row.seconds, 3, 10) + "  " +
                    (row.works() ? (row.drifts ? "may drift" : "bounded") : "FAILED");
}

/// The advice for every target or why there is none, all that was tried, and what the figures rest on.
SEMIEXPLICIT_COLD inline std::ostream& operator<<(std::ostream& out, const CostOfAccuracy& cost) {
  using detail::column, detail::figure, detail::in_words;
  const std::string header = column("method", 24) + ' ' + column("solver", 14) + ' ' +
                             column("dt", 10, true) + ' ' + column("error", 10, true) + ' ' +
                             column("gradients", 12, true) + ' ' + column("seconds", 10, true) + "  energy\n";
  out << "The cheapest " << (cost.by == CostBy::gradients ? "in gradient calls" : "in processor time")
      << " over T = " << in_words(cost.time, 6)
      << (cost.relative
              ? ", for a relative energy error of at most:\n         "
              : ", for an absolute energy error (H(z0) is zero up to rounding) of at most:\n         ")
      << header;
  for (const double target : cost.targets) {
    out << figure(target, 0, 7, true) << "  ";
    if (const auto row = cost.cheapest(target)) {
      std::ostringstream percent;
      percent.imbue(std::locale::classic());
      percent << std::fixed << std::setprecision(1) << 100 * cost.fraction_of(*row);
      out << *row << "; advice cost " << percent.str() << "%\n";
    } else {
      out << "out of reach: " << cost.why(target);
      if (const auto best = cost.best()) out << "; the best found is " << figure(best->error, 1, 0, true);
      out << '\n';
    }
  }
  const std::string spent = "Spent: " + in_words(cost.spent_gradients, 3) + " gradient calls, " +
                            in_words(cost.spent_seconds, 3) + " seconds.\n";
  if (cost.rows.empty()) return out << "\nNo setting was tried over the whole time.\n" << spent;
  out << "\nAll that was tried:\n         " << header;
  for (const CostRow& row : cost.rows) out << "         " << row << '\n';
  return out
         << "\nEstimates. Each setting ran for a time of " << in_words(cost.window_time, 3) << " in "
         << std::to_string(cost.windows) << " windows: " << in_words(cost.window_time / cost.time_scale, 2)
         << " characteristic times of " << in_words(cost.time_scale, 3)
         << ",\nat the start and along a coarse run to t = " << in_words(cost.pilot_time, 3)
         << ", where that was hardest among them.\n"
            "Assumed: the energy error stays bounded as a symplectic method's does, but for rounding and\n"
            "unfinished solves; times "
         << in_words(cost.growth, 2) << " for what lies beyond the coarse run.\n"
         << spent;
}

}  // namespace semiexplicit
