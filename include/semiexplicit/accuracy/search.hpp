#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/candidates.hpp>
#include <semiexplicit/accuracy/pilot.hpp>
#include <semiexplicit/accuracy/reference.hpp>

namespace semiexplicit::detail {

/// Processor time of this thread, in seconds.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The work of cost_of_accuracy(): a pilot run, trials of settings on parts of the orbit, and for each target
/// a search for the step and the scheme.
template <class Any>
class Search {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  explicit Search(Problem<Any>& problem)
      : problem_(problem), table_(problem.table), families_(families_for(problem)), pilot_(problem) {
    table_.invariant = problem.options.observable.is_energy();
  }

  /// Fills the table.
  SEMIEXPLICIT_COLD void run() {
    if (!pilot_.find_step()) {
      table_.budget = std::max(table_.spent_gradients, std::min(1e5, problem_.options.max_gradients));
      return;
    }
    plan();
    const double pilot_began = table_.spent_gradients;
    if (!pilot_.follow(std::min(table_.time, trial_time_) / window_count, pilot_share * budget_,
                       whole_share * budget_))
      return;
    if (table_.invariant && table_.end_unseen() && pilot_.places.rises()) {
      table_.unfinished = 1e300;
      return;
    }
    // What the pilot took to see all of the run is not left for the search.
    search_limit_ -= std::min(2.0, (table_.spent_gradients - pilot_began) / budget_);
    if (table_.changes) plan();
    if (!table_.invariant && !make_reference()) return;
    choose_windows();
    if (table_.changes && table_.invariant)  // stretches that are longer than planned are worth it
      table_.budget = budget_ = std::min(budget_ * std::clamp(table_.window_time / trial_time_, 1.0, 4.0),
                                         options().max_gradients / 3);
    const double begin = table_.spent_gradients;
    std::vector<double> targets = problem_.options.targets;
    std::sort(targets.begin(), targets.end(), std::greater<>());
    const auto reachable = [this](double target) { return std::max(target, 4 * table_.rounding); };
    double last = 0;
    for (const double target : targets) {
      searched_part_ += 1 / static_cast<double>(targets.size());
      problem_.limit = std::min(problem_.options.max_gradients,
                                begin + search_limit_ * budget_ * searched_part_ + spent_on_whole_runs_);
      searches_ = 0;
      if (tries_whole()) allow_whole_runs(target);
      // What rounding forbids is not looked for, but how near one comes.
      const double now = reachable(target);
      if (now != last) search(now, target);
      last = now;
    }
    // What a later target tried may be cheaper for an earlier one: it has to be confirmed, too.
    settled_ = true;
    for (const double target : targets) confirm(reachable(target), target);
    problem_.limit = problem_.options.max_gradients;
    finish_rows();
  }

 private:
  const CostOptionsOf<Scalar, Eigen::Dynamic>& options() const { return problem_.options; }

  /// Shares out the calls.
  SEMIEXPLICIT_COLD void plan() {
    double run_rates = 0;
    for (const double target : options().targets) run_rates += run_rate(target);
    const double least = options().min_gradients * (table_.invariant ? 1 : 10);
    budget_ =
        std::min(std::max(least, options().budget * run_rates * table_.time), options().max_gradients / 3);
    table_.budget = budget_;
    trial_time_ = trial_share * budget_ / (run_rates * trials_a_target);
  }

  /// How many times the gradient calls of the pilot a run to a target takes, in the same time: a rule of
  /// thumb.
  static double run_over_pilot(double target) { return 1.5 * std::pow(target / 1e-4, -0.12); }
  double run_rate(double target) const { return run_over_pilot(local(target)) * pilot_.rate; }

  /// The error of an invariant that goes with a target: a phase error adds up over the time.
  double local(double target) const {
    if (table_.invariant) return target;
    return std::max(1e-15, target * std::min(1.0, 10 * table_.time_scale / table_.time));
  }

  /// False: there is nothing to compare with. An observable that turns out to be constant becomes an
  /// invariant.
  SEMIEXPLICIT_COLD bool make_reference() {
    const auto extremes = std::minmax_element(options().targets.begin(), options().targets.end());
    const double tightest = *extremes.first, loosest = *extremes.second;
    // Beyond what a choice is confirmed on nothing is compared. Within some time after which nothing is left
    // of the orbit, the whole of it has to be seen.
    const double end = std::min(table_.time, table_.horizon / 2);
    const double length =
        std::min(end, std::max(8 * trial_time_, 2 * confirm_share * budget_ / run_rate(loosest)));
    const auto make = [&] {
      const bool made =
          reference_.make(problem_, {.calls = reference_share * budget_ * (table_.changes ? 4 : 1),
                                     .length = length,
                                     .end = end,
                                     .tried = pilot_.rate_time,
                                     .trial = trial_time_,
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
    plan();
    trial_time_ = table_.window_time = reference_.trial();
    table_.cycle = reference_.cycle();
    if (table_.cycles_unseen()) return false;
    if (reference_.is_constant(problem_)) {
      table_.invariant = true;
      table_.parting_rate = 0;
      table_.horizon = std::numeric_limits<double>::infinity();
      return true;
    }
    table_.reference_time = reference_.length();
    table_.reference_error = beyond(reference_.error(), reference_.length(), 1.5);
    table_.rounding = table_.reference_error;
    return true;
  }

  /// What an error that grows with a power of the time, or as neighbouring orbits part, is at T.
  double beyond(double error, double length, double power) const {
    const double stretch = std::max(1.0, table_.time / length);
    if (table_.parting_rate > 0)
      return error * std::exp(std::min(500.0, table_.parting_rate * length * (stretch - 1)));
    return error * std::pow(stretch, power);
  }

  /// The windows that an invariant is tried on: the start, evenly spread ones, and the hardest.
  SEMIEXPLICIT_COLD void choose_windows() {
    if (!table_.invariant) {
      table_.windows = 1;
      table_.window_time = trial_time_ = std::min(trial_time_, reference_.length());
      return;
    }
    if (trial_time_ >= table_.time) {
      windows_ = {{problem_.z0, table_.time, true}};
    } else {
      // What need not be bounded is followed for longer.
      const bool energy = options().observable.is_energy();
      const double each = trial_time_ / window_count / (energy ? 1 : 2);
      windows_.push_back(
          {problem_.z0, energy ? each : std::max(trial_time_ / 2, std::min(trial_time_, 1.05 * table_.cycle)),
           true});
      const auto& all = pilot_.places.all();
      for (std::size_t i = 1; i <= 2; ++i) windows_.push_back({all[all.size() * i / 3].start, each, true});
      for (std::size_t i = 0; i < 5 && i < pilot_.places.count(); ++i)
        windows_.push_back({pilot_.places.hardest(i), std::max(each, pilot_.segment_time), false});
    }
    note_windows();
  }
  SEMIEXPLICIT_COLD void note_windows() {
    table_.window_time = 0;
    for (const auto& window : windows_) table_.window_time += window.length;
    table_.windows = static_cast<int>(windows_.size());
    table_.growth = growth(4);
  }

  /// How much larger than in the hardest stretch that was tried the error of a method of that order gets.
  SEMIEXPLICIT_COLD double growth(int order) const {
    if (tries_whole()) return 1;
    return table_.changes ? pilot_.walk : pilot_.places.growth(order, table_.time / table_.pilot_time);
  }

  /// Whether an invariant is tried on the whole run.
  bool tries_whole() const { return windows_.size() == 1 && windows_.front().length >= table_.time; }
  /// Whether a choice for it is worth confirming so.
  bool confirms_whole(double rate) const {
    return table_.invariant &&
           rate * table_.time <= (surprised_ ? 10 : 1) * std::max(budget_, 10 * options().min_gradients);
  }
  /// Lets the search take at least so many calls more, where the bound on them does.
  void allow(double calls) {
    problem_.limit =
        std::min(options().max_gradients, std::max(problem_.limit, table_.spent_gradients + calls));
  }
  void allow_whole_runs(double target) {
    allow(std::max(whole_runs * run_rate(target) * table_.time, 10 * options().min_gradients));
  }
  /// From now on it is: what parts of the run told was wrong, and is forgotten.
  SEMIEXPLICIT_COLD void try_whole() {
    windows_ = {{problem_.z0, table_.time, true}};
    note_windows();
    for (Family& family : families_)
      for (Candidate& candidate : family)
        std::erase_if(candidate.trials, [&](const auto& trial) { return trial.second.length < table_.time; });
  }

  /// What a choice is confirmed on: other hard stretches, and the run itself as far as the calls go.
  SEMIEXPLICIT_COLD std::vector<Window<State>> confirming_windows(double rate) const {
    const double length =
        confirms_whole(rate) ? table_.time : std::min(table_.time, confirm_share * budget_ / rate);
    std::vector<Window<State>> list{{problem_.z0, length, true}};
    for (std::size_t i = 5; i < 30 && i < pilot_.places.count() && length < table_.time; ++i)
      list.push_back({pilot_.places.hardest(i), pilot_.segment_time, false});
    return list;
  }

  SEMIEXPLICIT_COLD Probe tried(const Setting& setting, bool confirming, double rate = 1) {
    Probe result =
        !table_.invariant
            ? reference_.compare(
                  problem_, setting,
                  confirming ? std::max(2 * trial_time_, confirm_share * budget_ / rate) : trial_time_)
            : try_on_windows(problem_, setting, confirming ? confirming_windows(rate) : windows_,
                             pilot_.hopeless, false);
    exhausted_ = exhausted_ || result.cut;
    return result;
  }

  /// The error of the whole run, in what parts of it tell. Too much is believed only where a choice is tried
  /// on all of it.
  double surprise(const Candidate& candidate, const Probe& probe) const {
    const double known = candidate.surprise > 0 ? candidate.surprise : surprise_;
    return confirms_whole(probe.rate) && !settled_ ? known : std::max(1.0, known);
  }
  bool of_whole_run(const Probe& probe) const { return probe.length >= 0.999 * table_.time; }

  /// The parts of the estimate of the error over the whole time.
  struct Estimate {
    double step, drift, rounding;
    bool grows;
    double sum() const { return step + drift + rounding; }
  };
  SEMIEXPLICIT_COLD Estimate estimate(const Candidate& candidate, const Probe& probe, double dt) const {
    const double T = table_.time;
    const bool explicit_ = candidate.setting.method == Setting::Method::midpoint;
    const bool energy = options().observable.is_energy();
    const bool whole = of_whole_run(probe);
    const double hard =
        probe.range * (whole ? 1 : probe.spread * growth(candidate.order) * surprise(candidate, probe));
    // A symplectic method keeps the energy within bounds. The trials of another are too short to tell its
    // drift.
    const double grown = !energy || (explicit_ && probe.confirmed) ? at_the_end(probe, explicit_) : 0;
    // The energy that drifts takes the frequencies along.
    const double drift = table_.invariant ? (whole ? 0 : probe.drift * T)
                         : explicit_      ? 0.1 * probe.drift * T * T / (2 * table_.time_scale)
                                          : 0;
    return {std::max(hard, grown), drift, table_.invariant ? problem_.rounding(dt) : table_.reference_error,
            whole ? !energy && probe.late > 1.4 * probe.early
                  : grown > std::max(hard, 1.2 * std::max(probe.early, probe.late))};
  }
  /// What an error that was seen to grow from z0 on, or not, comes to at T.
  SEMIEXPLICIT_COLD double at_the_end(const Probe& probe, bool explicit_) const {
    const double seen = std::max(probe.early, probe.late), T = table_.time;
    if (of_whole_run(probe)) return seen;
    // A few passages of a hard place may all be lucky.
    const double cycles = table_.cycle > 0 ? std::floor(probe.length / table_.cycle) : 1e9;
    const double spread = 1 + 2 / std::max(1.0, cycles * cycles);
    const double ratio = probe.early > 0 ? probe.late / probe.early : 1;
    // In t² grows what a method that is not symplectic makes; of another only a long trial is believed that.
    const bool squared = ratio > 2.8 && (explicit_ || (probe.length > 0.05 * T && cycles > 1));
    if (table_.parting_rate > 0 || ratio > 1.4 || cycles < 2)
      return spread * beyond(seen, probe.length, squared ? 2 : 1);
    // What comes back with the motion may hide growth of its own size.
    const double grown = std::max(2 * (probe.late - probe.early), hidden_growth * probe.late);
    return spread * seen + grown / probe.length * (T - probe.length);
  }
  /// No smaller than with any shorter step that was tried: an error that dips at one step is luck, but where
  /// it is that of the run itself.
  double error(const Candidate& candidate, const Probe& probe, double dt) const {
    double worst = estimate(candidate, probe, dt).sum();
    if (of_whole_run(probe)) return worst;
    for (const auto& [step, seen] : candidate.trials)
      if (step < dt && seen.works()) worst = std::max(worst, estimate(candidate, seen, step).sum());
    return worst;
  }

  /// Nothing where the calls do not suffice.
  SEMIEXPLICIT_COLD const Probe* trial(Candidate& candidate, double dt) {
    dt = std::min(dt, table_.time);
    const double least = (table_.invariant ? 1 : 0.5) * candidate.kicks *
                         std::max(4.0, (table_.invariant ? table_.window_time : trial_time_) / dt) /
                         (candidate.setting.is_gauss() ? 7 : 1);
    exhausted_ = exhausted_ || least > problem_.left();
    if (exhausted_) return nullptr;
    const Probe seen = tried(candidate.with_step(dt), false);
    if (seen.cut) return nullptr;
    Probe& noted = candidate.trials[dt] = seen;
    noted.confirmed = tries_whole();
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
      if (!(seen.works() && error(candidate, seen, step) <= target))
        result.high = std::min(result.high, step);
    for (const auto& [step, seen] : candidate.trials)
      if (step < result.high) result.low = std::max(result.low, step);
    return result;
  }

  /// The step to try next: by the order where nothing else is known, between both ends of the bracket later.
  SEMIEXPLICIT_COLD double next_step(Candidate& candidate, const Bracket& known, double target) {
    auto& trials = candidate.trials;
    const auto error_at = [&](double step) { return error(candidate, trials[step], step); };
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
    const double now = error(candidate, here->second, step);
    return larger->second.works() && step < larger->first / 1.1 &&
           now < std::max(1e-9, 4 * table_.rounding) &&
           now > 0.7 * error(candidate, larger->second, larger->first);
  }

  /// The cheapest rate of a candidate for a target; infinity where it does not reach it, or cannot be worth
  /// it.
  SEMIEXPLICIT_COLD double solve(Candidate& candidate, double target, double best) {
    const double infinity = std::numeric_limits<double>::infinity();
    auto& trials = candidate.trials;
    Bracket known;
    for (int attempt = 0; attempt < 8; ++attempt) {
      known = bracket(candidate, target);
      if (known.has_low() &&
          (known.high / known.low < 1.12 || error(candidate, trials[known.low], known.low) > target / 2.5 ||
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
      if (seen.works() && error(candidate, seen, step) <= target)
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
      if (error(candidate, *smaller, dt) <= target)
        cheapest = std::min(cheapest, cost_rate(candidate, *smaller));
    }
    return cheapest;
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
        if (seen.works() && error(other, seen, step) <= factor * target) least = std::min(least, seen.rate);
      });
      if (std::isfinite(least)) break;
    }
    return candidate.kicks / (std::isfinite(least) ? least : run_rate(target));
  }

  /// Where in a family a target is expected to be met best: by figures from many problems.
  std::size_t expected(const Family& family, double target) const {
    const double place = (-std::log10(local(target)) - 4) / 2 + (family.front().setting.is_gauss() ? 1 : 0);
    return static_cast<std::size_t>(
        std::clamp(std::round(place), 0.0, static_cast<double>(family.size() - 1)));
  }

  /// Looks for the cheapest of each family: from where it is expected to both sides, for as long as it gets
  /// cheaper. `wanted` is what the user asked for, where rounding forbids that.
  SEMIEXPLICIT_COLD void search(double target, double wanted) {
    exhausted_ = false;
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
      const Estimate now = estimate(candidate, seen, step);
      if (now.sum() < least) least = now.sum(), rounded = now.sum() < 3 * now.rounding;
    });
    if (least <= wanted) return;
    if (rounded || target > wanted)
      table_.rounding = std::max(table_.rounding, std::nextafter(wanted, std::numeric_limits<double>::max()));
    else if (exhausted_)
      table_.unfinished = std::max(table_.unfinished, wanted);
  }

  /// Whether there is something to advise, but no calls are left to look for better.
  bool affordable() const {
    return !std::isfinite(best_rate_) || problem_.left() > 0.7 * search_limit_ * budget_;
  }

  /// Whether it is the projection that keeps the cheapest projected step for a target from being larger: it
  /// takes several evaluations, or would. Else the midpoint projection, which takes one, is the same.
  SEMIEXPLICIT_COLD bool projection_limits(double target) {
    double least = std::numeric_limits<double>::infinity();
    bool limits = true;
    for_each_trial([&](Candidate& candidate, double step, const Probe& seen) {
      if (!candidate.projects() || !seen.works() || error(candidate, seen, step) > target) return;
      if (!(cost_rate(candidate, seen) < least)) return;
      least = cost_rate(candidate, seen);
      limits = seen.evaluations > 1.1 || error(candidate, seen, step) < target / 3;
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
        if (!seen.works() || error(candidate, seen, step) > target || !(cost_rate(candidate, seen) < least))
          return;
        least = cost_rate(candidate, seen);
        chosen = &candidate, dt = step;
      });
      if (chosen == nullptr || chosen->trials[dt].confirmed) return;
      Probe& seen = chosen->trials[dt];
      whole_run = confirms_whole(seen.rate) ? 1.2 * seen.rate * table_.time : 0;
      const double before = table_.spent_gradients;
      problem_.limit = std::min(options().max_gradients, problem_.limit + whole_run);
      const Probe again = tried(chosen->with_step(dt), true, seen.rate);
      if (whole_run > 0) spent_on_whole_runs_ += table_.spent_gradients - before;
      if (again.cut) return;
      if (whole_run > 0) {
        if (!(again.works() && again.range <= much_worse * target)) break;
        const double now = again.range / estimate(*chosen, seen, dt).step;
        surprise_ = chosen->surprise = std::max(1e-3, now * surprise(*chosen, seen));
        surprised_ = surprised_ || now > 2;
        seen = again;
        seen.confirmed = true;
      } else {
        dearer = again.rate > 1.1 * seen.rate;
        take(seen, again);
      }
      // Parts of the run told far too much: larger steps will do.
      if (whole_run > 0 && !settled_ && !tries_whole() && seen.range < target / 4 &&
          ++searches_ <= most_searches)
        return search(target, wanted);
      if (dearer || !(seen.works() && error(*chosen, seen, dt) <= target))
        solve(*chosen, target, std::numeric_limits<double>::infinity());
    }
    if (tries_whole() || whole_run == 0) return;
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

  /// Processor time of a gradient call in this method, its share of the step included: measured.
  SEMIEXPLICIT_COLD double seconds_per_call(Candidate& candidate) {
    double& known = seconds_per_call_[candidate.setting.name()];
    if (known > 0) return known;
    double dt = candidate.trials.empty() ? table_.time_scale / 10 : 0;
    for (const auto& [step, seen] : candidate.trials)
      if (seen.works()) dt = step;
    if (dt == 0) return 0;
    // Where time decides it is worth a little more.
    const double enough = budget_ * (options().by == CostBy::seconds ? 0.02 : 0.003);
    Walker<Any> walker(problem_, candidate.with_step(dt));
    State z = problem_.z0;
    Probe probe;
    double from = table_.spent_gradients, begin = cpu_seconds();
    for (std::int64_t n = 0; table_.spent_gradients - from < enough || n < 20; ++n) {
      if (n == 10) from = table_.spent_gradients, begin = cpu_seconds();  // warm now
      if (walker.step(z, dt, probe, false)) continue;
      if (probe.cut || n == 0) break;
      z = problem_.z0;  // it ran into something: time the first steps again
    }
    const double calls = table_.spent_gradients - from;
    known = calls > 0 ? (cpu_seconds() - begin) / calls : 0;
    return known;
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
        const Estimate parts = estimate(candidate, seen, step);
        row.error = error(candidate, seen, step);
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

  static constexpr double pilot_share = 0.3, trial_share = 0.45, confirm_share = 0.25,
                          reference_share = 0.4;  ///< of the budget
  static constexpr double much_harder = 4;        ///< than what comes back is, from time to time
  static constexpr double much_worse = 10;        ///< than parts of the run told: they are of no use
  static constexpr double hidden_growth = 0.4;    ///< in a trial from z0, of the error that it saw
  static constexpr double whole_share = 3;        ///< that seeing the whole run is worth
  static constexpr double whole_runs = 8;         ///< that a target takes where each trial is one
  static constexpr int most_searches = 3;         ///< again, for a target
  static constexpr double trials_a_target = 12, window_count = 8;

  Problem<Any>& problem_;
  CostTable& table_;
  std::vector<Family> families_;
  Pilot<Any> pilot_;
  Reference<Any> reference_{};
  std::vector<Window<State>> windows_{};
  double search_limit_ = 5.3;  ///< budgets after which even a target without a setting is given up
  double budget_ = 0, trial_time_ = 0, best_rate_ = 0, searched_part_ = 0, spent_on_whole_runs_ = 0;
  double surprise_ = 1;     ///< the last of all candidates
  int searches_ = 0;        ///< of those for the target that is searched for
  bool settled_ = false;    ///< every target has been searched for
  bool surprised_ = false;  ///< the error of a whole run was more than twice what parts of it told
  bool exhausted_ = false;  ///< the search for a target has met the limit
  std::map<std::string, double> seconds_per_call_{};
};

}  // namespace semiexplicit::detail
