#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <vector>

#include <semiexplicit/accuracy/call_timer.hpp>
#include <semiexplicit/accuracy/reference.hpp>
#include <semiexplicit/accuracy/whole_run.hpp>

namespace semiexplicit::detail {

/// The work of cost_of_accuracy(): a pilot run, trials of settings on parts of the orbit, and for each target
/// a search for the step and the scheme.
template <class Any>
class Search {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  explicit Search(Problem<Any>& problem)
      : problem_(problem),
        table_(problem.table),
        families_(families_for(problem)),
        pilot_(problem),
        plan_(problem, pilot_),
        whole_(problem, plan_),
        timer_(problem) {
    table_.invariant = problem.options.observable.is_energy();
  }

  /// Fills the table.
  SEMIEXPLICIT_COLD void run() {
    if (!pilot_.find_step()) {
      table_.budget = std::max(table_.spent_gradients, std::min(1e5, problem_.options.max_gradients));
      return;
    }
    plan_.share();
    const double pilot_began = table_.spent_gradients;
    if (!pilot_.follow(std::min(table_.time, plan_.trial_time) / Plan<Any>::window_count,
                       pilot_share * plan_.budget, whole_share * plan_.budget))
      return;
    if (table_.invariant && table_.end_unseen() && pilot_.places.rises()) {
      table_.unfinished = 1e300;
      return;
    }
    // What the pilot took to see all of the run is not left for the search.
    search_limit_ -= std::min(2.0, (table_.spent_gradients - pilot_began) / plan_.budget);
    if (table_.changes) plan_.share();
    if (!table_.invariant && !make_reference()) return;
    if (table_.invariant)
      plan_.choose_windows();
    else
      plan_.try_until(reference_.length());
    if (table_.changes && table_.invariant)  // stretches that are longer than planned are worth it
      plan_.set_budget(std::min(plan_.budget * std::clamp(table_.window_time / plan_.trial_time, 1.0, 4.0),
                                options().max_gradients / 3));
    const double begin = table_.spent_gradients;
    std::vector<double> targets = problem_.options.targets;
    std::sort(targets.begin(), targets.end(), std::greater<>());
    const auto reachable = [this](double target) { return std::max(target, 4 * table_.rounding); };
    double last = 0;
    for (const double target : targets) {
      searched_part_ += 1 / static_cast<double>(targets.size());
      problem_.limit = std::min(problem_.options.max_gradients,
                                begin + search_limit_ * plan_.budget * searched_part_ + spent_on_whole_runs_);
      searches_ = 0;
      if (plan_.tries_whole()) allow_whole_runs(target);
      // What rounding forbids is not looked for, but how near one comes.
      const double now = reachable(target);
      if (now != last) search(now, target);
      last = now;
    }
    // What a later target tried may be cheaper for an earlier one: it has to be confirmed, too.
    whole_.settle();
    for (const double target : targets) confirm(reachable(target), target);
    problem_.limit = problem_.options.max_gradients;
    finish_rows();
  }

 private:
  const CostOptionsOf<Scalar, Eigen::Dynamic>& options() const { return problem_.options; }

  /// False: there is nothing to compare with. An observable that turns out to be constant becomes an
  /// invariant.
  SEMIEXPLICIT_COLD bool make_reference() {
    const auto extremes = std::minmax_element(options().targets.begin(), options().targets.end());
    const double tightest = *extremes.first, loosest = *extremes.second;
    // Beyond what a choice is confirmed on nothing is compared. Within some time after which nothing is left
    // of the orbit, the whole of it has to be seen.
    const double end = std::min(table_.time, table_.horizon / 2);
    const double length =
        std::min(end, std::max(8 * plan_.trial_time, 2 * plan_.confirming_time(plan_.run_rate(loosest))));
    const auto make = [&] {
      const bool made =
          reference_.make(problem_, {.calls = reference_share * plan_.budget * (table_.changes ? 4 : 1),
                                     .length = length,
                                     .end = end,
                                     .tried = pilot_.rate_time,
                                     .trial = plan_.trial_time,
                                     .tightest = tightest,
                                     .whole = table_.changes});
      if (!made && !(table_.orbit_end < table_.time)) table_.unfinished = 1e300;
      return made;
    };
    if (!make()) return false;
    // What the coarse run found harder than all that the reference saw, but for the last of it.
    if (!table_.changes &&
        pilot_.places.harder_behind(0.8 * reference_.length() / table_.pilot_time) > much_harder) {
      table_.changes = true;
      if (!make()) return false;
    }
    pilot_.rate *= reference_.hardness();
    plan_.share();
    plan_.trial_time = table_.window_time = reference_.trial();
    table_.cycle = reference_.cycle();
    if (table_.cycles_unseen()) return false;
    if (reference_.is_constant(problem_)) {
      table_.invariant = true;
      table_.parting_rate = 0;
      table_.horizon = std::numeric_limits<double>::infinity();
      return true;
    }
    table_.reference_time = reference_.length();
    table_.rounding = problem_.rounding_of_orbit(table_.time_scale);
    table_.reference_error =
        error_at_the_end(table_, reference_.error(), reference_.length(), 1) + table_.rounding;
    return true;
  }

  /// Lets the search take at least so many calls more, where the bound on them does.
  void allow(double calls) {
    problem_.limit =
        std::min(options().max_gradients, std::max(problem_.limit, table_.spent_gradients + calls));
  }
  void allow_whole_runs(double target) {
    allow(std::max(whole_runs * plan_.whole_calls(plan_.run_rate(target)), 10 * options().min_gradients));
  }
  /// From now on the whole run is tried: what parts of it told was wrong, and is forgotten.
  SEMIEXPLICIT_COLD void try_whole() {
    plan_.try_whole();
    for (Family& family : families_)
      for (Candidate& candidate : family)
        std::erase_if(candidate.trials, [&](const auto& trial) { return trial.second.length < table_.time; });
  }

  SEMIEXPLICIT_COLD Probe tried(const Candidate& candidate, double dt, bool confirming, double rate = 1) {
    const Setting setting = candidate.with_step(dt);
    Probe result =
        table_.invariant
            ? try_on_windows(problem_, setting, confirming ? plan_.confirming_windows(rate) : plan_.windows(),
                             pilot_.hopeless, false)
            : compared(setting, candidate.order,
                       plan_.tries_whole() || (confirming && plan_.confirms_whole(rate)),
                       confirming ? std::max(2 * plan_.trial_time, plan_.confirming_time(rate))
                                  : plan_.trial_time);
    exhausted_ = exhausted_ || result.cut;
    return result;
  }
  /// What is no invariant, compared with the reference, and with a finer run where that does not go to the
  /// end.
  SEMIEXPLICIT_COLD Probe compared(const Setting& setting, int order, bool whole, double length) {
    const bool to_end = reference_.length() >= 0.999 * table_.time;
    Probe seen = reference_.compare(problem_, setting, whole && to_end ? table_.time : length);
    if (!whole || !seen.works()) return seen;
    if (!to_end) {
      // What the reference tells for sure.
      const double early = seen.early - 2 * reference_.error_until(seen.length / 2),
                   late = seen.late - 2 * reference_.error_until(seen.length);
      seen = try_beside_finer(problem_, setting, order);
      seen.early = std::max(seen.early, early);
      seen.late = std::max(seen.late, late);
    }
    seen.range = std::max(seen.early, seen.late);
    return seen;
  }

  /// Nothing where the calls do not suffice.
  SEMIEXPLICIT_COLD const Probe* trial(Candidate& candidate, double dt) {
    dt = std::min(dt, table_.time);
    const double least = (table_.invariant ? 1 : 0.5) * candidate.kicks *
                         std::max(4.0, (table_.invariant ? table_.window_time : plan_.trial_time) / dt) /
                         (candidate.setting.is_gauss() ? 7 : 1);
    exhausted_ = exhausted_ || least > problem_.left();
    if (exhausted_) return nullptr;
    // Where many evaluations a step make it dear, smaller steps are cheaper.
    const double limit = problem_.limit, dearest = plan_.tries_whole()
                                                       ? table_.spent_gradients + few_steps +
                                                             4 * plan_.whole_calls(candidate.kicks / dt)
                                                       : limit;
    problem_.limit = std::min(limit, dearest);
    Probe seen = tried(candidate, dt, false);
    problem_.limit = limit;
    if (seen.cut && !(dearest < limit)) return nullptr;
    if (seen.cut) {
      seen = {.status = Status::no_convergence};
      exhausted_ = false, cut_short_ = true;
    }
    Probe& noted = candidate.trials[dt] = seen;
    noted.confirmed = plan_.tries_whole();
    return &noted;
  }

  /// The smallest step of a candidate known not to be accurate enough, and the largest below it that is.
  struct Bracket {
    double low = 0, high = std::numeric_limits<double>::infinity();
    bool has_low() const { return low > 0; }
    bool has_high() const { return std::isfinite(high); }
  };
  SEMIEXPLICIT_COLD Bracket bracket(const Candidate& candidate, double target) const {
    Bracket result;
    for (const auto& [step, seen] : candidate.trials)
      if (!(seen.works() && whole_.error(candidate, seen, step) <= target))
        result.high = std::min(result.high, step);
    for (const auto& [step, seen] : candidate.trials)
      if (step < result.high) result.low = std::max(result.low, step);
    return result;
  }

  /// The step to try next: by the order where nothing else is known, between both ends of the bracket later.
  SEMIEXPLICIT_COLD double next_step(Candidate& candidate, const Bracket& known, double target) {
    auto& trials = candidate.trials;
    const auto error_at = [&](double step) { return whole_.error(candidate, trials[step], step); };
    const auto by_order = [&](double step) {
      return step * std::pow(0.7 * target / error_at(step), 1.0 / candidate.order);
    };
    if (trials.empty()) return first_step(candidate, target);
    const bool high_works = known.has_high() && trials[known.high].works();
    if (known.has_low() && high_works)
      return known.low * std::pow(known.high / known.low,
                                  std::clamp(std::log(0.7 * target / error_at(known.low)) /
                                                 std::log(error_at(known.high) / error_at(known.low)),
                                             0.1, 0.9));
    if (known.has_low() && known.has_high()) return std::sqrt(known.low * known.high);
    if (known.has_low()) return std::min(4 * known.low, by_order(known.low));
    if (high_works) return std::clamp(by_order(known.high), known.high / 5, known.high / 1.1);
    return known.high / 1.6;
  }

  /// Whether smaller steps no longer lower the error: rounding.
  SEMIEXPLICIT_COLD bool stalls(const Candidate& candidate, double step) const {
    const auto& trials = candidate.trials;
    const auto here = trials.find(step);
    if (here == trials.begin() || here == trials.end() || !here->second.works()) return false;
    const auto larger = std::prev(here);
    const double now = whole_.error(candidate, here->second, step);
    return larger->second.works() && step < larger->first / 1.1 &&
           now < std::max({1e-9, 4 * table_.rounding, 4 * table_.reference_error}) &&
           now > 0.7 * whole_.error(candidate, larger->second, larger->first);
  }

  /// The cheapest rate of a candidate for a target; infinity where it does not reach it, or cannot be worth
  /// it.
  SEMIEXPLICIT_COLD double solve(Candidate& candidate, double target, double best) {
    const double infinity = std::numeric_limits<double>::infinity();
    auto& trials = candidate.trials;
    Bracket known;
    for (int attempt = 0; attempt < 8; ++attempt) {
      known = bracket(candidate, target);
      if (known.has_low() && (known.high / known.low < 1.12 ||
                              whole_.error(candidate, trials[known.low], known.low) > target / 2.5 ||
                              (candidate.projects() && trials[known.low].evaluations > 1.3)))
        break;  // near enough; or larger steps take more evaluations still
      const double dt = next_step(candidate, known, target), from = known.has_low() ? known.low : known.high;
      if (std::isfinite(from) && trials[from].works() &&
          (!candidate.projects() || trials[from].evaluations < 1.3)) {
        // Not worth more where even the step that is promised is dearer. Larger ones of Gauss take more
        // iterations.
        const double power = candidate.setting.is_gauss() ? 0.6 : 1.0;
        if (cost_rate(candidate, trials[from]) * std::pow(from / dt, power) > 1.15 * best) return infinity;
      }
      if (!known.has_low() && stalls(candidate, known.high)) return infinity;
      if (known.has_low() && dt >= table_.time && known.low >= table_.time) break;
      if (trial(candidate, dt) == nullptr) break;
    }
    known = bracket(candidate, target);
    if (!known.has_low()) return infinity;
    double cheapest = infinity;
    for (const auto& [step, seen] : trials)
      if (seen.works() && whole_.error(candidate, seen, step) <= target)
        cheapest = std::min(cheapest, cost_rate(candidate, seen));
    return candidate.projects() ? with_fewer_evaluations(candidate, target, known.low, best, cheapest)
                                : cheapest;
  }

  /// Where the projection takes several evaluations, a smaller step may be cheaper; with one it costs
  /// `single` a kick.
  SEMIEXPLICIT_COLD double with_fewer_evaluations(Candidate& candidate, double target, double dt, double best,
                                                  double cheapest) {
    const double single = options().by == CostBy::seconds ? seconds_per_call(candidate) : 1.0;
    for (int attempt = 0; attempt < 5 && candidate.trials[dt].evaluations >= 1.1; ++attempt) {
      dt /= candidate.trials[dt].evaluations > 1.5 ? 1.3 : 1.12;
      if (candidate.kicks / dt * single > std::min(cheapest, 1.2 * best)) break;
      const Probe* const smaller =
          candidate.trials.contains(dt) ? &candidate.trials[dt] : trial(candidate, dt);
      if (smaller == nullptr || !smaller->works()) break;
      if (whole_.error(candidate, *smaller, dt) <= target)
        cheapest = std::min(cheapest, cost_rate(candidate, *smaller));
    }
    return cheapest;
  }

  /// Processor time of a gradient call in this method. Where time decides it is measured for longer.
  double seconds_per_call(const Candidate& candidate) {
    return timer_.seconds_per_call(candidate,
                                   plan_.budget * (options().by == CostBy::seconds ? 0.02 : 0.003));
  }
  /// Cost a unit of time, in what is to be cheap.
  SEMIEXPLICIT_COLD double cost_rate(Candidate& candidate, const Probe& seen) {
    return seen.rate * (options().by == CostBy::seconds ? seconds_per_call(candidate) : 1.0);
  }

  template <class Use>
  void for_each_trial(const Use& use) {
    for (Family& family : families_)
      for (Candidate& candidate : family)
        for (auto& [step, seen] : candidate.trials) use(candidate, step, seen);
  }

  /// Where to begin: with a step as dear as the cheapest known one that meets the target, or nearly.
  SEMIEXPLICIT_COLD double first_step(const Candidate& candidate, double target) {
    double least = std::numeric_limits<double>::infinity();
    for (const double factor : {1.0, 30.0}) {
      for_each_trial([&](const Candidate& other, double step, const Probe& seen) {
        if (seen.works() && whole_.error(other, seen, step) <= factor * target)
          least = std::min(least, seen.rate);
      });
      if (std::isfinite(least)) break;
    }
    return candidate.kicks / (std::isfinite(least) ? least : plan_.run_rate(target));
  }

  /// Where in a family a target is expected to be met best: by figures from many problems.
  std::size_t expected(const Family& family, double target) const {
    const double place =
        (-std::log10(plan_.local(target)) - 4) / 2 + (family.front().setting.is_gauss() ? 1 : 0);
    return static_cast<std::size_t>(
        std::clamp(std::round(place), 0.0, static_cast<double>(family.size() - 1)));
  }

  /// Looks for the cheapest of each family: from where it is expected to both sides, for as long as it gets
  /// cheaper. `wanted` is what the user asked for, where rounding forbids that.
  SEMIEXPLICIT_COLD void search(double target, double wanted) {
    exhausted_ = cut_short_ = false;
    best_rate_ = std::numeric_limits<double>::infinity();
    for (Family& family : families_) {
      if (family.front().setting.method == Setting::Method::midpoint && !projection_limits(target)) continue;
      const std::size_t middle = expected(family, target);
      const double here = solve(family[middle], target, best_rate_);
      best_rate_ = std::min(best_rate_, here);
      const auto walk = [&](auto next) {
        double last = here;
        for (std::size_t i = next(middle); i < family.size() && affordable(); i = next(i)) {
          const double now = solve(family[i], target, best_rate_);
          best_rate_ = std::min(best_rate_, now);
          if (!(now < last) && std::isfinite(last)) break;
          last = now;
        }
      };
      walk([](std::size_t i) { return i + 1; });
      walk([](std::size_t i) { return i - 1; });  // below zero it wraps round, beyond the size
    }
    confirm(target, wanted);
    double least = std::numeric_limits<double>::infinity();
    bool rounded = false;
    for_each_trial([&](const Candidate& candidate, double step, const Probe& seen) {
      if (!seen.works()) return;
      const auto now = whole_.estimate(candidate, seen, step);
      if (now.sum() < least) least = now.sum(), rounded = now.sum() < 3 * now.rounding;
    });
    if (least <= wanted) return;
    if (rounded || target > wanted)
      table_.rounding = std::max(table_.rounding, std::nextafter(wanted, std::numeric_limits<double>::max()));
    else if (exhausted_ || cut_short_ || table_.reference_error > wanted / 3)
      table_.unfinished = std::max(table_.unfinished, wanted);
  }

  /// Whether there is something to advise, but no calls are left to look for better.
  bool affordable() const {
    return !std::isfinite(best_rate_) || problem_.left() > 0.7 * search_limit_ * plan_.budget;
  }

  /// Whether it is the projection that keeps the cheapest projected step for a target from being larger: it
  /// takes several evaluations, or would. Else the midpoint projection, which takes one, is the same.
  SEMIEXPLICIT_COLD bool projection_limits(double target) {
    double least = std::numeric_limits<double>::infinity();
    bool limits = true;
    for_each_trial([&](Candidate& candidate, double step, const Probe& seen) {
      if (!candidate.projects() || !seen.works() || whole_.error(candidate, seen, step) > target) return;
      if (!(cost_rate(candidate, seen) < least)) return;
      least = cost_rate(candidate, seen);
      limits = seen.evaluations > 1.1 || whole_.error(candidate, seen, step) < target / 3;
    });
    return limits;
  }

  /// Tries what would be advised on more of the run, and looks further where it fails there.
  SEMIEXPLICIT_COLD void confirm(double target, double wanted) {
    double whole_run = 0;  // what it takes, where it is worth that
    for (int attempt = 0; attempt < 6; ++attempt) {
      bool dearer = false;
      Candidate* chosen = nullptr;
      double dt = 0, least = std::numeric_limits<double>::infinity();
      for_each_trial([&](Candidate& candidate, double step, const Probe& seen) {
        if (!seen.works() || whole_.error(candidate, seen, step) > target ||
            !(cost_rate(candidate, seen) < least))
          return;
        least = cost_rate(candidate, seen);
        chosen = &candidate, dt = step;
      });
      if (chosen == nullptr || chosen->trials[dt].confirmed) return;
      Probe& seen = chosen->trials[dt];
      whole_run = plan_.confirms_whole(seen.rate) ? plan_.at_most(plan_.whole_calls(seen.rate)) : 0;
      const double before = table_.spent_gradients;
      const double limit = std::min(options().max_gradients, problem_.limit + whole_run),
                   dearest = whole_run > 0 ? before + few_steps + 3 * whole_run : limit;
      problem_.limit = std::min(limit, dearest);
      const Probe again = tried(*chosen, dt, true, seen.rate);
      problem_.limit = limit;
      if (whole_run > 0) spent_on_whole_runs_ += table_.spent_gradients - before;
      if (again.cut && dearest < limit) {  // far dearer than parts of it told
        seen.status = Status::no_convergence;
        continue;
      }
      if (again.cut) return;
      if (whole_run > 0) {
        if (!(again.works() && again.range <= much_worse * target)) break;
        const double now = again.range / whole_.estimate(*chosen, seen, dt).step;
        whole_.learn(*chosen, seen, now);
        plan_.surprised = plan_.surprised || now > 2;
        seen = again;
        seen.confirmed = true;
      } else {
        dearer = again.rate > 1.1 * seen.rate;
        take(seen, again);
      }
      // Parts of the run told far too much: larger steps will do.
      if (whole_run > 0 && !whole_.settled() && !plan_.tries_whole() && seen.range < target / 4 &&
          ++searches_ <= most_searches)
        return search(target, wanted);
      if (dearer || !(seen.works() && whole_.error(*chosen, seen, dt) <= target))
        solve(*chosen, target, std::numeric_limits<double>::infinity());
    }
    if (plan_.tries_whole() || whole_run == 0) return;
    try_whole();
    allow_whole_runs(target);
    search(target, wanted);
  }

  /// Adds what was seen on more of the run.
  static void take(Probe& seen, const Probe& again) {
    seen.confirmed = true;
    if (!again.works()) seen.status = again.status;
    seen.range = std::max(seen.range, again.range);
    if (again.length > 0) seen.early = again.early, seen.late = again.late, seen.length = again.length;
    if (again.rate > 0) {
      seen.rate = 0.2 * seen.rate + 0.8 * again.rate;
      seen.evaluations = std::max(seen.evaluations, again.evaluations);
    }
    seen.drift = std::max(seen.drift, again.drift);
  }

  SEMIEXPLICIT_COLD void finish_rows() {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for_each_trial([&](Candidate& candidate, double step, const Probe& seen) {
      CostRow row{.setting = candidate.with_step(step),
                  .error = nan,
                  .gradients = nan,
                  .seconds = nan,
                  .limit = LimitedBy::failure,
                  .status = seen.status,
                  .confirmed = seen.confirmed};
      if (seen.works()) {
        const auto parts = whole_.estimate(candidate, seen, step);
        row.error = whole_.error(candidate, seen, step);
        row.gradients = seen.rate * table_.time;
        row.seconds = row.gradients * seconds_per_call(candidate);
        row.limit = parts.drift > row.error / 3      ? LimitedBy::drift
                    : parts.rounding > row.error / 2 ? LimitedBy::rounding
                    : parts.grows                    ? LimitedBy::growth
                                                     : LimitedBy::step;
      }
      table_.rows.push_back(row);
    });
  }

  static constexpr double pilot_share = 0.3, reference_share = 0.4;  ///< of the budget
  static constexpr double much_harder = 4;  ///< than what comes back is, from time to time
  static constexpr double much_worse = 10;  ///< than parts of the run told: they are of no use
  static constexpr double whole_share = 3;  ///< that seeing the whole run is worth
  static constexpr double few_steps = 1e4;  ///< in calls, however many a step may take
  static constexpr double whole_runs = 8;   ///< that a target takes where each trial is one
  static constexpr int most_searches = 3;   ///< again, for a target

  Problem<Any>& problem_;
  CostTable& table_;
  std::vector<Family> families_;
  Pilot<Any> pilot_;
  Plan<Any> plan_;
  WholeRun<Any> whole_;
  CallTimer<Any> timer_;
  Reference<Any> reference_{};
  double search_limit_ = 5.3;  ///< budgets after which even a target without a setting is given up
  double best_rate_ = 0, searched_part_ = 0, spent_on_whole_runs_ = 0;
  int searches_ = 0;  ///< of those for the target that is searched for
  /// The search for a target has met the limit, or the part of it that a trial is worth.
  bool exhausted_ = false, cut_short_ = false;
};

}  // namespace semiexplicit::detail
