#pragma once

#include <algorithm>
#include <cmath>
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
#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

/// What "cheapest" is measured in.
enum class CostBy {
  gradients,  ///< gradient calls: the same on every machine and at every load
  seconds     ///< processor time, measured on the spot
};

/// What the error of a setting is mostly made of.
enum class LimitedBy {
  step,      ///< the size of the step, and the error stays bounded
  growth,    ///< the size of the step, and the error grows with the time, as that of a phase does
  rounding,  ///< the rounding of states and gradients, or the error of the reference
  failure    ///< the setting failed: CostRow::status says why
};

/// A setting, and what a run with it over the whole time is expected to give and to cost.
struct CostRow {
  Setting setting{};
  double error = 0;      ///< the largest over the time; see CostTable for what it is relative to. Infinite
                         ///< where it is not known, as hard places come back that were not tried
  double gradients = 0;  ///< gradient calls
  double seconds = 0;    ///< of processor time; NaN where that was not measured
  LimitedBy limit = LimitedBy::step;
  Status status = Status::success;  ///< why the setting failed in a trial; the figures above are NaN then
  double tried = 0;                 ///< how far, in time: less than the whole where calls did not suffice
  double harder = 1;                ///< how much finer steps must be in what comes after that
  bool lasts = true;                ///< false: it has to be tried to the end to be advised, as where calls
                                    ///< did not suffice to look at neighbouring orbits, and was not
  bool interpolated = false;        ///< no: all advice was tried itself

  bool works() const { return is_done(status); }
  double cost(CostBy by) const { return by == CostBy::gradients ? gradients : seconds; }
};

/// Whether a target can be met, and if not, why.
enum class Reach {
  met,          ///< CostTable::cheapest() has a setting for it
  rounding,     ///< it is below what rounding, noise, or the error of the reference leaves to be seen
  budget,       ///< the gradient calls ended first
  orbit_ends,   ///< no step tried goes beyond CostTable::orbit_end
  not_finite,   ///< the observable is NaN or Inf on the orbit, at CostTable::observable_end
  orbits_part,  ///< neighbouring orbits part so fast that no run in this precision can give it
  no_step       ///< none of the settings that were tried meets it
};

/// The curve of accuracy against cost for one problem; made by cost_of_accuracy(). An error is the largest
/// over [0, T] of ‖f(z(t)) - f(exact z(t))‖, f being the observable (Euclidean norm), divided by `unit`. For
/// an invariant (the energy, or what a tight run finds constant) that unit is |f(z0)|, for others the largest
/// ‖f‖ along the orbit: behind the trials as far as a coarse run keeps its energy.
struct CostTable {
  std::vector<CostRow> rows{};  ///< every setting that was tried: method by method, the largest step first
  std::vector<double> targets{};
  CostBy by = CostBy::gradients;

  double time = 0;        ///< T, the length of the run that is advised on
  double time_scale = 0;  ///< characteristic time at z0 that the search started from
  double tried = 0;       ///< how far the best settings were tried from z0 on: to T where calls sufficed
  std::vector<double> tried_for{};  ///< the same for each of the targets
  double budget = 0;                ///< gradient calls that the search was to take: a guide
  double spent_gradients = 0;       ///< what it took
  double spent_seconds = 0;         ///< of processor time, likewise

  bool invariant = true;       ///< the observable is an invariant: its error is the distance from f(z0)
  bool relative = true;        ///< false: errors are absolute, by request or because f is zero up to rounding
  double unit = 1;             ///< size of the observable that errors are relative to
  double rounding = 0;         ///< no error below this can be told from rounding, or noise
  double reference_error = 0;  ///< of the reference as it grows over the whole time; 0 for an invariant
  double reference_time = 0;   ///< how far the reference went
  double parting_rate = 0;     ///< neighbouring orbits part as e^{rate t}; 0: not seen to, or not looked for
  double horizon = std::numeric_limits<double>::infinity();         ///< when nothing of the orbit is left
  double orbit_end = std::numeric_limits<double>::infinity();       ///< time that no step tried got beyond
  double observable_end = std::numeric_limits<double>::infinity();  ///< first time that it is NaN or Inf at
  std::string exact_flow{};  ///< of a scene: what advised_flow() says at z0; no row has such a stepper
  double size = 1;           ///< of the observable, the largest norm, in the unit of errors
  double unfinished = 0;     ///< the loosest target whose search ended with the calls; 0: none; infinite: all

  static constexpr double most_harder = 4;  ///< CostRow::harder that a row is advised with

  /// Whether what comes after the trials is so much harder that they tell nothing of it.
  SEMIEXPLICIT_COLD bool harder_ahead() const {
    for (const CostRow& row : rows)
      if (row.works() && row.harder > most_harder) return true;
    return false;
  }

  /// Whether a perturbation of one rounding grows to the target before the end.
  bool parts_before(double target) const {
    return horizon < std::numeric_limits<double>::infinity() &&
           time > horizon + std::log(std::min(target / size, 1.0)) / parting_rate;
  }

  /// Why a target is out of reach.
  SEMIEXPLICIT_COLD Reach reach(double target) const {
    if (parts_before(target)) return Reach::orbits_part;
    if (cheapest(target)) return Reach::met;
    if (observable_end <= time) return Reach::not_finite;
    if (orbit_end < time) return Reach::orbit_ends;
    // More than the observable itself is no rounding that was seen, but growth that was not followed.
    if (target < rounding && (invariant || !(rounding > size))) return Reach::rounding;
    if (harder_ahead()) return Reach::budget;
    return target <= std::max(unfinished, rounding) ? Reach::budget : Reach::no_step;
  }
  /// The same in words, with what to do about it; empty where the target is met.
  SEMIEXPLICIT_COLD std::string why(double target) const {
    using detail::in_words;
    switch (reach(target)) {
      case Reach::met:
        return "";
      case Reach::rounding:
        return "errors below " + in_words(rounding, 2) +
               (invariant
                    ? " cannot be told from the rounding or noise of the observable, which may be small "
                      "beside its terms"
                    : " cannot be told from rounding, which adds up over the time");
      case Reach::budget:
        return (harder_ahead() ? "the gradient calls of a trial ended before the motion came to, or back to, "
                                 "where it is hard; raise "
                               : "the gradient calls ended; raise ") +
               std::string("options.budget, min_gradients or max_gradients");
      case Reach::orbit_ends:
        return "the orbit ends near t = " + in_words(orbit_end, 3) +
               ", or is too hard there: no step goes beyond; give a shorter T";
      case Reach::not_finite:
        return "the observable is NaN or Inf on the orbit, at t = " + in_words(observable_end, 3) +
               "; give one that is finite all along";
      case Reach::orbits_part:
        return "neighbouring orbits part as e^(" + in_words(parting_rate, 2) +
               " t): after t = " + in_words(horizon, 2) +
               " nothing of the trajectory is left in this precision; means and "
               "sections may still be right";
      case Reach::no_step:
        return "no step of those tried meets it";
    }
    return "";
  }

  /// The cheapest setting that was tried and whose error is expected to stay below `target`, or nothing where
  /// none was found: `best()` says how near one comes.
  SEMIEXPLICIT_COLD std::optional<CostRow> cheapest(double target) const {
    if (!(target > 0))
      throw std::invalid_argument("CostTable::cheapest: target is not a positive error; give one");
    std::optional<CostRow> found;
    if (parts_before(target) || std::isinf(unfinished) || observable_end <= time || orbit_end < time)
      return found;
    const auto offer = [&](double error, double least) {
      for (const CostRow& row : rows)
        if (counts(row, least) && row.error <= error && (!found || row.cost(by) < found->cost(by)))
          found = row;
    };
    offer(target, tried_to(target));
    // What is advice for a tighter target is for this one, too, though tried less far.
    for (const double tighter : targets)
      if (tighter < target && !parts_before(tighter)) offer(tighter, tried_to(tighter));
    return found;
  }

  /// The row of the smallest error, whatever it costs, of those tried farthest; nothing where no setting
  /// works.
  SEMIEXPLICIT_COLD std::optional<CostRow> best() const {
    std::optional<CostRow> found;
    const double far = tried_for.empty() ? tried : *std::min_element(tried_for.begin(), tried_for.end());
    for (const CostRow& row : rows)
      if (counts(row, far) && (!found || row.error < found->error)) found = row;
    return found;
  }

  /// What the scan took, as a fraction of the run that a row stands for.
  double fraction_of(const CostRow& row) const { return spent_gradients / row.gradients; }

 private:
  /// Whether a row works and was tried so far, and what is harder ahead is no harder for it.
  static bool counts(const CostRow& row, double far) {
    return row.works() && row.lasts && row.tried >= far &&
           (row.setting.reversible || row.harder <= most_harder);
  }
  /// How far the settings for a target were tried: as those for the next tighter one that was asked for.
  SEMIEXPLICIT_COLD double tried_to(double target) const {
    double next = 0, far = tried;
    for (std::size_t i = 0; i < targets.size() && i < tried_for.size(); ++i)
      if (targets[i] <= target && targets[i] >= next) next = targets[i], far = tried_for[i];
    return far;
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

SEMIEXPLICIT_COLD inline const char* words(LimitedBy limit) {
  switch (limit) {
    case LimitedBy::step:
      return "step, bounded";
    case LimitedBy::growth:
      return "step, grows with t";
    case LimitedBy::rounding:
      return "rounding";
    case LimitedBy::failure:
      break;
  }
  return "FAILED";
}

}  // namespace detail

/// One line: what to run, what it should give, what it costs.
SEMIEXPLICIT_COLD inline std::ostream& operator<<(std::ostream& out, const CostRow& row) {
  using detail::column, detail::figure;
  return out << column(row.setting.name(), 34) + ' ' + column(row.setting.solver(), 14) + ' ' +
                    figure(row.setting.dt, 4, 10) + ' ' + figure(row.error, 1, 10, true) + ' ' +
                    figure(row.gradients, 3, 12) + ' ' + figure(row.seconds, 3, 10) + "  " +
                    detail::words(row.limit);
}

/// The advice for every target or why there is none, all that was tried, and what the figures rest on.
SEMIEXPLICIT_COLD inline std::ostream& operator<<(std::ostream& out, const CostTable& cost) {
  using detail::column, detail::figure, detail::in_words;
  const std::string header = column("method", 34) + ' ' + column("solver", 14) + ' ' +
                             column("dt", 10, true) + ' ' + column("error", 10, true) + ' ' +
                             column("gradients", 12, true) + ' ' + column("seconds", 10, true) +
                             "  limited by\n";
  out << "The cheapest " << (cost.by == CostBy::gradients ? "in gradient calls" : "in processor time")
      << " over T = " << in_words(cost.time, 6)
      << (cost.relative ? ", for a relative error of at most (the unit is " + in_words(cost.unit, 3) + ")"
                        : std::string(", for an absolute error of at most"))
      << ":\n         " << header;
  const auto as_far_as = [&](const CostRow& row) {
    return row.works() && row.tried < cost.time
               ? "; tried over " + in_words(100 * row.tried / cost.time, 2) + "%"
               : std::string();
  };
  for (const double target : cost.targets) {
    out << figure(target, 0, 7, true) << "  ";
    if (const auto row = cost.cheapest(target)) {
      const double runs = cost.fraction_of(*row);  // that the search took
      out << *row << as_far_as(*row) << "; the search took " << in_words(runs < 1 ? 100 * runs : runs, 2)
          << (runs < 1 ? "% of that\n" : " times that\n");
    } else {
      out << "out of reach: " << cost.why(target);
      if (const auto best = cost.best()) out << "; the best found is " << figure(best->error, 1, 0, true);
      out << '\n';
    }
  }
  if (!cost.exact_flow.empty()) out << "Not tried: " << cost.exact_flow << ".\n";
  const std::string spent = "Spent: " + in_words(cost.spent_gradients, 3) + " gradient calls, " +
                            in_words(cost.spent_seconds, 3) + " seconds.\n";
  if (cost.rows.empty()) return out << "\nNo setting was tried over the whole time.\n" << spent;
  out << "\nAll that was tried:\n         " << header;
  for (const CostRow& row : cost.rows) {
    out << "         " << row << as_far_as(row)
        << (std::isinf(row.error) ? ", without what is hard behind\n" : "\n");
  }
  out << "\nThe race went from z0 to t = " << in_words(cost.tried, 3) << ", "
      << in_words(cost.tried / cost.time_scale, 2) << " characteristic times of "
      << in_words(cost.time_scale, 3);
  if (cost.tried < cost.time)
    out << "; behind what was tried errors are extrapolated as they were seen to grow";
  const std::string constant =
      cost.tried < cost.time ? ". Constant until there, and taken for an invariant to T" : ". An invariant";
  out << (cost.invariant ? constant + ": errors are those from its first value.\n"
                         : ". Errors are those from a run that is known to " +
                               figure(cost.reference_error, 1, 0, true) + " over T.\n");
  return out << spent;
}

}  // namespace semiexplicit
