#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <limits>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/call_timer.hpp>
#include <semiexplicit/accuracy/forecast.hpp>

namespace semiexplicit::detail {

/// The work of cost_of_accuracy(): a race of all settings over a short stretch from z0 on, of the best ones
/// over a longer one, and so on to T, or as far as the gradient calls go.
template <class Any>
class Search {
 public:
  explicit Search(Problem<Any>& problem)
      : problem_(problem),
        table_(problem.table),
        families_(families_for(problem)),
        scout_(problem),
        forecast_(problem, scout_),
        timer_(problem) {
    auto targets = options().targets;
    std::sort(targets.begin(), targets.end(), std::greater<>());
    for (const double target : targets) goals_.push_back({.target = target});
    racing_ = goals_.size();
    table_.budget = least_calls();
  }

  /// Fills the table.
  SEMIEXPLICIT_COLD void run() {
    if (!scout()) return;
    table_.time_scale = scout_.time_scale();
    double runs = 0;  // usually
    for (const Goal& goal : goals_)
      runs += 1.5 * std::pow(problem_.in_terms(goal.target) / 1e-4, -0.12) * scout_.rate() * table_.time;
    set_budget(runs);
    // Who is sure to win comes first: what is dearer is not tried further. Of equal steps Gauss's are the
    // longest in hard places.
    const double varies = forecast_.note_paces();
    if (varies > 4)
      std::stable_partition(families_.begin(), families_.end(),
                            [](const Family& family) { return family.front().setting.is_gauss(); });
    if (options().reversible && !timed && varies > 4) {
      const auto following = reversible(families_, scout_.sizes(), scout_.mean_step());
      families_.insert(varies > much_varied ? families_.begin() : families_.end(), following.begin(),
                       following.end());
    }
    for (double length = first_length(); length > 0; length = next_length()) {
      if (!scout()) return;
      problem_.limit =
          std::min(share_of_races(length) * options().max_gradients,
                   std::max(overrun * table_.budget + scout_.spent(),
                            table_.spent_gradients + (length < table_.time ? 0 : table_.budget)));
      table_.tried = length;
      cut_ = !forecast_.see_as_far_as(length);
      race_all();
      if (cut_ || length >= table_.time) break;
    }
    const bool looked = look_beside();
    // What is harder ahead counts in full now, and what was tried roughly is tried well.
    forecast_.count_harder();
    // What these leave is to be timed, or run to the end.
    problem_.limit = std::min((table_.invariant ? 0.85 : 0.97) * options().max_gradients,
                              std::max(problem_.limit, table_.spent_gradients) + 0.4 * table_.budget);
    for (Goal& goal : goals_)
      if (goal.tried > 0 && (goal.tried < table_.time || goal.cut) && !table_.parts_before(goal.target))
        race_again(goal);
    for (const double target : table_.targets)
      for (const Goal& goal : goals_)
        if (goal.target == target) {
          table_.tried_for.push_back(goal.tried);
          break;
        }
    table_.tried = goals_.front().tried;
    if (table_.tried < table_.time) forecast_.believe_rate();
    if (!looked || table_.tried < std::min(table_.time, least_scales * table_.time_scale) ||
        (timed && scout_.time() < table_.time))
      table_.unfinished = std::numeric_limits<double>::infinity();
    for (const Goal& goal : goals_) judge(goal);
    problem_.limit = options().max_gradients;
    finish_rows();
    bool refuted = is_contradicted();
    if (table_.invariant && std::isfinite(table_.unfinished)) refuted = see_to_the_end() || refuted;
    if (refuted) count_whole_runs();
  }

 private:
  /// A target, and who is in the race for it: the cheapest first.
  struct Goal {
    double target;
    double aim = 0;  ///< no less than rounding allows
    std::vector<std::pair<double, Candidate*>> racers{};
    double tried = 0;      ///< how far they all were
    bool stalled = false;  ///< smaller steps no longer made errors smaller
    bool cut = false;      ///< its share of the calls ended before its last race
    double missed = 0;     ///< the length at which it ended before all had been tried
  };

  static constexpr bool timed = Forecast<Any>::timed;
  bool scout() {
    const double most = options().max_gradients / 3;
    return scout_.go(scout_share * table_.budget, timed ? most : std::min(to_the_end * table_.budget, most));
  }

  const CostOptionsOf<typename Any::Scalar, Eigen::Dynamic>& options() const { return problem_.options; }

  /// A gradient of many degrees of freedom is dear.
  double least_calls() const {
    return std::min(
        options().max_gradients / overrun,
        std::max(enough_to_begin,
                 options().min_gradients * std::min(1.0, 10.0 / static_cast<double>(problem_.z0.dof()))));
  }

  /// By the gradient calls of a run to each target.
  void set_budget(double runs) {
    const double most = options().max_gradients / overrun;
    table_.budget = options().whole ? most : std::min(most, std::max(least_calls(), options().budget * runs));
  }

  SEMIEXPLICIT_COLD double first_length() const {
    if (!(scout_.time() > 0)) return 0;
    const double calls = first_share * table_.budget / (first_trials * static_cast<double>(goals_.size()));
    const double length =
        scout_.first_trial(std::clamp(calls / (scout_.rate() * scout_.mean_step()), 10.0, 60.0));
    return length > nearly_all * table_.time && scout_.time() >= table_.time ? table_.time : length;
  }
  /// What is worth seeing next; 0: nothing, or the calls do not suffice. All of T is worth a smaller race.
  SEMIEXPLICIT_COLD double next_length() {
    racing_ = goals_.size();
    const double once = racing_rate(1);
    if (once == 0) return 0;
    set_budget(once * table_.time);
    const double left = table_.budget - (table_.spent_gradients - scout_.spent());
    const double of_reference = forecast_.rate_of_reference();  // which goes on
    const auto affordable = [&](std::size_t racers, double calls) {
      return (calls + of_reference * table_.tried) / (trials_a_racer * racing_rate(racers) + of_reference);
    };
    const bool whole = table_.tried * stretch >= nearly_all * table_.time && scout_.time() >= table_.time;
    // The tightest stay behind where the calls do not suffice for all.
    for (; racing_ > 0; --racing_) {
      for (std::size_t racers = whole ? most_racers : 0; racers > 0; --racers) {
        if (overrun * affordable(racers, std::max(left, table_.budget / overrun)) < table_.time) continue;
        for (std::size_t i = 0; i < racing_; ++i)
          goals_[i].racers.resize(std::min(goals_[i].racers.size(), racers));
        return table_.time;
      }
      // Nor is a part of T worth anything where only runs of the whole are advice, which come to more.
      if (racing_ > 1 && only_whole_runs() &&
          overrun * affordable(1, std::max(left, table_.budget / overrun)) < table_.time)
        continue;
      for (std::size_t racers = racing_rate(1) > 0 ? most_racers : 0; racers > 0; --racers) {
        const double length = std::min({affordable(racers, left), stretch * table_.tried, scout_.time()});
        if (!(length > 1.5 * table_.tried)) continue;
        for (std::size_t i = 0; i < racing_; ++i) keep(goals_[i].racers, racers);
        return length;
      }
    }
    return 0;
  }
  /// Whether some target in the race has no racer whose steps are advice before T.
  SEMIEXPLICIT_COLD bool only_whole_runs() const {
    return std::any_of(
        goals_.begin(), goals_.begin() + static_cast<std::ptrdiff_t>(racing_), [this](const Goal& goal) {
          return !goal.racers.empty() &&
                 std::none_of(goal.racers.begin(), goal.racers.end(),
                              [this](const auto& one) { return forecast_.goes_on(*one.second); });
        });
  }
  /// Gradient calls a unit of time of so many racers for each target in the race.
  SEMIEXPLICIT_COLD double racing_rate(std::size_t racers) const {
    double sum = 0;
    for (std::size_t k = 0; k < racing_; ++k)
      for (std::size_t i = 0; i < racers && i < goals_[k].racers.size(); ++i)
        sum += goals_[k].racers[i].second->rate;
    return sum;
  }

  /// Of all calls, in a race over that length: a neighbouring orbit, or a run to the end, may need the rest.
  double share_of_races(double length) const {
    return table_.invariant ? 0.8 : length < table_.time ? 0.75 : 0.85;
  }
  /// Where the calls end before T: what becomes of a neighbouring orbit, as far as a budget goes. False: the
  /// orbit cannot be followed by steps that met a target.
  SEMIEXPLICIT_COLD bool look_beside() {
    if (options().observable.is_energy() || table_.invariant || table_.parting_rate > 0) return true;
    bool followed = true;
    for (const Goal& goal : goals_) {
      if (goal.tried == 0 || goal.tried >= table_.time) continue;
      table_.tried = goal.tried;
      for (int attempt = 0; attempt < most_besides; ++attempt) {
        Candidate* cheapest = nullptr;  // not only of the racers: to T also those remain that do not go on
        double dt = 0, least = std::numeric_limits<double>::infinity();
        for_each_trial([&](Candidate& candidate, double step, const Probe& seen) {
          if (forecast_.goes_on(candidate) && is_current(seen) && seen.works() && !seen.given_up &&
              seen.rate < least && forecast_.error_of(candidate, seen, step) <= goal.aim)
            cheapest = &candidate, dt = step, least = seen.rate;
        });
        if (cheapest == nullptr) break;
        problem_.limit =
            std::min(0.9 * options().max_gradients, table_.spent_gradients + beside_share * table_.budget);
        if (forecast_.look_beside(cheapest->with_step(dt))) return true;
        followed = false;
        // Behind its trial, where its iteration hardly converges, or one that is hard itself: others tell.
        cheapest->trials[dt].status = Status::no_convergence;
      }
    }
    return followed;
  }

  /// A run of the whole time shows what rounding makes of an invariant; before, that is an estimate. What
  /// cannot be met is not chased.
  double aim_of(const Goal& goal) const {
    const bool shown = table_.invariant && table_.tried >= table_.time;
    const double least = forecast_.least_error(), reached = goal.target < least ? 2 * least : goal.target;
    return std::max(reached, 2 * (shown ? problem_.judged.noise : table_.rounding));
  }

  double longest_step(const Candidate& candidate) const {
    return candidate.setting.reversible ? most_scales : table_.time;
  }

  bool is_current(const Probe& probe) const { return probe.asked >= table_.tried; }

  /// Tries a setting; nullptr where the calls do not suffice.
  SEMIEXPLICIT_COLD Probe* trial(Candidate& candidate, double dt, double aim) {
    Probe probe =
        try_setting(problem_, candidate.with_step(dt), table_.tried, forecast_.samples(), 1e3 * aim);
    if (probe.cut) {
      cut_ = true;
      return nullptr;
    }
    probe.asked = table_.tried;
    return &(candidate.trials[dt] = probe);
  }

  /// The largest step that meets the aim, and the smallest above it that does not.
  struct Bracket {
    double low = 0, high = std::numeric_limits<double>::infinity();
    bool has_low() const { return low > 0; }
    bool has_high() const { return std::isfinite(high); }
  };
  SEMIEXPLICIT_COLD Bracket bracket(const Candidate& candidate, double aim, bool current) const {
    Bracket result;
    for (const auto& [step, seen] : candidate.trials) {
      if (is_current(seen) != current) continue;
      const bool meets = seen.works() && forecast_.error_of(candidate, seen, step) <= aim;
      // Of what was given up for a tighter target it is not known whether it meets a looser one.
      if (meets && seen.given_up) continue;
      if (meets) {
        if (!result.has_low()) result.low = step;
      } else if (!result.has_low()) {
        result.high = step;
      }
    }
    return result;
  }

  /// The next step to try: by the order of the method where one end is known, between both else.
  SEMIEXPLICIT_COLD double next_step(Candidate& candidate, const Bracket& known, double aim) {
    const auto error_at = [&](double step) {
      return forecast_.error_of(candidate, candidate.trials[step], step);
    };
    const auto by_order = [&](double step) {
      return step * std::pow(0.7 * aim / error_at(step), 1.0 / candidate.order);
    };
    const bool high_works = known.has_high() && candidate.trials[known.high].works();
    if (known.has_low() && high_works)
      return known.low * std::pow(known.high / known.low,
                                  std::clamp(std::log(0.7 * aim / error_at(known.low)) /
                                                 std::log(error_at(known.high) / error_at(known.low)),
                                             0.1, 0.9));
    if (known.has_low() && known.has_high()) return std::sqrt(known.low * known.high);
    if (known.has_low()) return std::min(4 * known.low, by_order(known.low));
    if (high_works) return std::clamp(by_order(known.high), known.high / 5, known.high / 1.1);
    if (known.has_high()) return known.high / 1.6;
    const Bracket before = bracket(candidate, aim, false);
    if (before.has_low()) return std::min(1.5 * before.low, by_order(before.low));
    if (!before.has_high()) return first_step(candidate, aim);
    return candidate.trials[before.high].works() ? by_order(before.high) : before.high / 1.6;
  }
  /// Where to begin: with a step as dear as the cheapest known one that meets the aim, or nearly.
  SEMIEXPLICIT_COLD double first_step(const Candidate& candidate, double aim) {
    double least = std::numeric_limits<double>::infinity();
    for (const double factor : {1.0, 30.0}) {
      for_each_trial([&](const Candidate& other, double step, const Probe& seen) {
        if (seen.works() && forecast_.error_of(other, seen, step) <= factor * aim)
          least = std::min(least, seen.rate);
      });
      if (std::isfinite(least)) break;
    }
    const double usual = 20 * std::pow(problem_.in_terms(aim) / 1e-4, -0.1) / table_.time_scale;
    return std::min(longest_step(candidate),
                    candidate.kicks / (std::isfinite(least) ? least : usual) / candidate.unit);
  }

  /// Whether steps below that one no longer lower the error: rounding.
  SEMIEXPLICIT_COLD bool stalls(const Candidate& candidate, double step) const {
    const auto here = candidate.trials.find(step);
    if (here == candidate.trials.begin() || here == candidate.trials.end() || !here->second.works())
      return false;
    const auto larger = std::prev(here);
    const double now = forecast_.error_of(candidate, here->second, step);
    return larger->second.works() && is_current(larger->second) && step < larger->first / 1.1 &&
           (problem_.in_terms(now) < 1e-9 || now < 10 * table_.rounding) &&
           now > 0.7 * forecast_.error_of(candidate, larger->second, larger->first);
  }

  /// Whether all of four steps failed: reversible ones do, however short, where the motion gets harder within
  /// few of them.
  static bool only_fails(const Candidate& candidate) {
    return candidate.trials.size() >= 4 &&
           std::none_of(candidate.trials.begin(), candidate.trials.end(),
                        [](const auto& trial) { return trial.second.works() || trial.second.cut; });
  }

  /// The least cost a unit of time of a candidate that meets the goal; infinity where it does not, or cannot
  /// be worth it beside `best`.
  SEMIEXPLICIT_COLD double solve(Candidate& candidate, Goal& goal, double best) {
    const double infinity = std::numeric_limits<double>::infinity(), aim = goal.aim;
    auto& trials = candidate.trials;
    for (int attempt = 0; attempt < most_trials; ++attempt) {
      const Bracket known = bracket(candidate, aim, true);
      if (known.has_low() && (known.high / known.low < 1.12 ||
                              forecast_.error_of(candidate, trials[known.low], known.low) > aim / 2.5 ||
                              (candidate.projects() && trials[known.low].evaluations > 1.3)))
        break;  // near enough; or larger steps take more evaluations still
      const double longest = longest_step(candidate);
      if (known.has_low() && known.low >= longest) break;
      if (candidate.setting.reversible && only_fails(candidate)) return infinity;
      const double dt = std::min(next_step(candidate, known, aim), longest);
      const double from = known.has_low() ? known.low : known.high;
      if (std::isfinite(from) && trials[from].works() &&
          (!candidate.projects() || trials[from].evaluations < 1.3)) {
        // Not worth more where even the step that is promised is dearer. Larger ones of Gauss take more
        // iterations.
        const double power = candidate.setting.is_gauss() ? 0.6 : 1.0;
        if (cost_of(candidate, trials[from]) * std::pow(from / dt, power) > 1.15 * best) return infinity;
      }
      // Nor where its kicks alone are far dearer.
      const double single = cost_of_call(candidate);
      if ((candidate.setting.is_gauss() ? 0.4 : 1) * candidate.kicks / (dt * candidate.unit) * single >
          3 * best)
        return infinity;
      if (!known.has_low() && known.has_high() && stalls(candidate, known.high)) {
        goal.stalled = true;
        return infinity;
      }
      const Probe* const seen = trial(candidate, dt, aim);
      if (seen == nullptr) break;
      if (!first_race_ || !seen->works()) continue;
      // Near enough to tell what the aim would cost.
      const double off = forecast_.error_of(candidate, *seen, dt) / aim;
      if (!(off > 0.25 && off < 4) || (candidate.projects() && seen->evaluations > 1.3)) continue;
      candidate.rate = seen->rate * std::pow(off / 0.7, 1.0 / candidate.order);
      return cost_of(candidate, *seen) * candidate.rate / seen->rate;
    }
    double cheapest = infinity, dt = 0;
    for (const auto& [step, seen] : trials) {
      if (!is_current(seen) || !seen.works() || seen.given_up ||
          forecast_.error_of(candidate, seen, step) > aim)
        continue;
      if (dt == 0) dt = step;
      if (cost_of(candidate, seen) < cheapest)
        cheapest = cost_of(candidate, seen), candidate.rate = seen.rate;
    }
    if (dt == 0) return infinity;
    // Where the projection takes several evaluations, a smaller step may be cheaper; with one it costs
    // `single` a kick. Not where rounding alone takes them.
    const double single = cost_of_call(candidate);
    for (int attempt = 0; attempt < 5 && candidate.projects() && trials[dt].evaluations >= 1.1; ++attempt) {
      const double before = trials[dt].evaluations;
      dt /= before > 1.5 ? 1.3 : 1.12;
      if (candidate.kicks / (dt * candidate.unit) * single > std::min(cheapest, 1.2 * best)) break;
      const Probe* const smaller = trial(candidate, dt, aim);
      if (smaller == nullptr || !smaller->works()) break;
      if (forecast_.error_of(candidate, *smaller, dt) <= aim && cost_of(candidate, *smaller) < cheapest)
        cheapest = cost_of(candidate, *smaller), candidate.rate = smaller->rate;
      if (smaller->evaluations >= before) break;
    }
    return cheapest;
  }

  /// Processor time of a gradient call in this method. Where time decides it is measured for longer.
  double seconds_per_call(const Candidate& candidate) {
    const double enough = table_.budget * (options().by == CostBy::seconds ? 0.003 : 0.0005);
    return timer_.seconds_per_call(candidate, std::min(enough, most_timed));
  }
  /// Cost of a gradient call, in what is to be cheap.
  double cost_of_call(const Candidate& candidate) {
    return options().by == CostBy::seconds ? seconds_per_call(candidate) : 1.0;
  }
  /// And of a unit of time.
  SEMIEXPLICIT_COLD double cost_of(Candidate& candidate, const Probe& seen) {
    return seen.rate * cost_of_call(candidate);
  }

  template <class Use>
  void for_each_trial(const Use& use) {
    for (Family& family : families_)
      for (Candidate& candidate : family)
        for (auto& [step, seen] : candidate.trials) use(candidate, step, seen);
  }

  /// So many of the cheapest first, one more where none is advice before T.
  SEMIEXPLICIT_COLD void keep(std::vector<std::pair<double, Candidate*>>& racers, std::size_t count) const {
    count = std::min(count, racers.size());
    const auto first = std::find_if(racers.begin(), racers.end(),
                                    [this](const auto& racer) { return forecast_.goes_on(*racer.second); });
    const auto place = static_cast<std::size_t>(first - racers.begin());
    if (first != racers.end() && place >= count) std::swap(racers[count++], *first);
    racers.resize(count);
  }
  SEMIEXPLICIT_COLD void race_all() {
    const double limit = problem_.limit, begin = table_.spent_gradients;
    // What cannot be met takes no more than its share of the calls, and the first race not all of them.
    const double end =
        goals_.front().tried > 0 ? limit : std::min(limit, begin + most_of_first * table_.budget);
    double left = static_cast<double>(racing_);
    for (std::size_t i = 0; i < racing_; ++i) {
      Goal& goal = goals_[i];
      const double share = (end - table_.spent_gradients) / left--;
      if (cut_ || table_.parts_before(goal.target) || (goal.cut && goal.racers.empty())) continue;
      goal.aim = aim_of(goal);
      if (&goal != &goals_.front() && goal.aim == (&goal - 1)->aim)
        goal.racers = (&goal - 1)->racers, goal.tried = (&goal - 1)->tried, goal.cut = (&goal - 1)->cut;
      else {
        problem_.limit = std::min(end, table_.spent_gradients + 1.5 * share);
        race(goal);
        goal.cut = std::exchange(cut_, false);
        problem_.limit = limit;
      }
    }
  }
  /// Whoever is in the race for the goal, all at first, is tried on the stretch; the best stay.
  SEMIEXPLICIT_COLD void race(Goal& goal) {
    std::vector<std::pair<double, Candidate*>> results;
    double best = std::numeric_limits<double>::infinity();
    // What is advice also where the calls end before T is looked for although it is dearer.
    double best_before_end = best;
    const auto enter = [&](Candidate& candidate) {
      const bool before_end = forecast_.goes_on(candidate) && table_.tried < table_.time;
      const double cost =
          solve(candidate, goal, before_end ? std::min(best_before_end, much_dearer * best) : best);
      best = std::min(best, cost);
      if (before_end) best_before_end = std::min(best_before_end, cost);
      if (std::isfinite(cost)) results.emplace_back(cost, &candidate);
      return cost;
    };
    const bool first = goal.racers.empty();
    first_race_ = first && table_.tried < table_.time;
    for (const auto& racer : goal.racers) enter(*racer.second);
    if (first || results.empty())
      for (Family& family : families_) enter_family(family, goal.aim, enter);
    std::stable_sort(results.begin(), results.end(),
                     [](const auto& a, const auto& b) { return a.first < b.first; });
    std::size_t stay = 0;
    while (stay < results.size() && stay < (first ? most_racers : 3) && results[stay].first <= 1.5 * best)
      ++stay;
    if (cut_ && goal.tried > 0) return;  // not all have been tried as far
    keep(results, stay);
    goal.racers = results;
    goal.tried = table_.tried;
    if (first) goal.missed = cut_ ? goal.tried : 0;
  }
  /// A last race as far as the goal was tried, and to T where the calls that are left suffice for one racer.
  SEMIEXPLICIT_COLD void race_again(Goal& goal) {
    cut_ = false;
    goal.aim = aim_of(goal);  // a neighbouring orbit may have told better what rounding comes to
    table_.tried = goal.tried;
    if (goal.missed == goal.tried) goal.racers.clear();
    race(goal);
    const double T = table_.time;
    if (!cut_ && goal.tried < T && !goal.racers.empty() && scout_.time() >= T &&
        trials_a_racer * goal.racers.front().second->rate * T <= problem_.left()) {
      goal.racers.resize(1);
      table_.tried = T;
      if (forecast_.see_as_far_as(T)) race(goal);
    }
    goal.cut = std::exchange(cut_, false);
  }
  /// From where in a family the aim is expected to be met best, by figures from many problems, to both sides,
  /// for as long as it gets cheaper.
  SEMIEXPLICIT_COLD void enter_family(Family& family, double aim, const auto& enter) {
    if (!options().observable.is_energy()) aim *= table_.tried / table_.time;  // it grows
    const double place =
        (-std::log10(problem_.in_terms(aim)) - 4) / 2 + (family.front().setting.is_gauss() ? 1 : 0);
    const auto middle =
        static_cast<std::size_t>(std::clamp(std::round(place), 0.0, static_cast<double>(family.size() - 1)));
    const double here = enter(family[middle]);
    for (const std::size_t next : {std::size_t{1}, ~std::size_t{0}}) {  // up, and down
      double last = here;
      for (std::size_t i = middle + next; i < family.size() && !cut_; i += next) {
        const double now = enter(family[i]);
        if (!(now < last) && std::isfinite(last)) break;
        last = now;
      }
    }
  }

  /// Notes why a target is not met.
  SEMIEXPLICIT_COLD void judge(const Goal& goal) {
    double least = std::numeric_limits<double>::infinity();
    for_each_trial([&](const Candidate& candidate, double step, const Probe& seen) {
      if (seen.works() && seen.seen_to() >= goal.tried && forecast_.lasts(candidate, seen) &&
          (candidate.setting.reversible || forecast_.harder_behind(seen.seen_to()) <= CostTable::most_harder))
        least = std::min(least, forecast_.error_of(candidate, seen, step));
    });
    if (least <= goal.target) {
      if (table_.invariant) table_.rounding = std::min(table_.rounding, least);
      return;
    }
    if (goal.stalled || goal.aim > goal.target)
      table_.rounding =
          std::max(table_.rounding, std::nextafter(goal.target, std::numeric_limits<double>::max()));
    else if (goal.cut || goal.tried < table_.time)
      table_.unfinished = std::max(table_.unfinished, goal.target);
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
                  .tried = forecast_.is_whole(seen) ? table_.time : seen.seen_to(),
                  .harder = forecast_.harder_behind(seen.seen_to())};
      if (seen.works() && !forecast_.lasts(candidate, seen)) row.lasts = false;
      if (row.works()) {
        row.error = candidate.setting.reversible || std::isfinite(row.harder)
                        ? forecast_.error_of(candidate, seen, step)
                        : std::numeric_limits<double>::infinity();
        row.gradients = seen.rate * table_.time;
        const double per_call = seconds_per_call(candidate);  // 0: no calls were left to measure it
        if (per_call > 0 || options().by == CostBy::seconds) row.seconds = row.gradients * per_call;
        row.limit = row.error < 3 * table_.rounding    ? LimitedBy::rounding
                    : forecast_.grows(candidate, seen) ? LimitedBy::growth
                                                       : LimitedBy::step;
      }
      table_.rows.push_back(row);
    });
  }

  /// Whether a run of the whole is far off from what a part of one, by no smaller steps, promised.
  SEMIEXPLICIT_COLD bool is_contradicted() const {
    const auto contradicts = [this](const CostRow& whole, const CostRow& part) {
      return whole.tried >= table_.time && part.tried < table_.time && part.lasts &&
             part.setting.dt >= 0.99 * whole.setting.dt &&
             whole.error > 10 * std::max(part.error, table_.rounding) &&
             part.setting.name() == whole.setting.name();
    };
    for (const CostRow& whole : table_.rows)
      for (const CostRow& part : table_.rows)
        if (contradicts(whole, part)) return true;
    return false;
  }

  /// What is advised by a part of T is run to the end where the calls that are left suffice: what a motion
  /// that gets faster does with the steps, as in a resonance, is not seen before. Whether that refutes one.
  SEMIEXPLICIT_COLD bool see_to_the_end() {
    problem_.limit = std::min(options().max_gradients, whole_runs * table_.budget);
    bool refuted = false;
    for (const Goal& goal : goals_)
      for (auto row = table_.cheapest(goal.target);
           row && row->tried < table_.time && 1.1 * row->gradients < problem_.left();
           row = table_.cheapest(goal.target)) {
        const Probe seen = try_setting(problem_, row->setting, table_.time, {}, 1e3 * goal.target);
        if (seen.cut) break;
        for (CostRow& other : table_.rows)
          if (other.setting.name() == row->setting.name() &&
              other.setting.solver() == row->setting.solver() && other.setting.dt == row->setting.dt)
            note_whole(other, seen);
        refuted =
            refuted || !seen.works() || seen.given_up || seen.error > std::max(goal.target, 3 * row->error);
      }
    return refuted;
  }
  /// From now on no others count.
  SEMIEXPLICIT_COLD void count_whole_runs() {
    for (CostRow& row : table_.rows)
      if (row.tried < table_.time) row.lasts = false;
    for (const Goal& goal : goals_)
      if (!table_.cheapest(goal.target)) table_.unfinished = std::max(table_.unfinished, goal.target);
  }
  SEMIEXPLICIT_COLD void note_whole(CostRow& row, const Probe& seen) const {
    row.status = seen.status;
    row.tried = table_.time, row.harder = 1, row.lasts = !seen.given_up;
    const double gradients = seen.rate * table_.time;
    row.seconds *= gradients / row.gradients, row.gradients = gradients;
    row.error = forecast_.error_of_whole(seen);
    if (!row.works()) {
      row.error = row.gradients = row.seconds = std::numeric_limits<double>::quiet_NaN();
      row.limit = LimitedBy::failure;
    }
  }

  static constexpr double enough_to_begin = 1000;  ///< gradient calls
  static constexpr double most_timed = 1e6;        ///< of them, to time a method
  static constexpr double most_scales = 4;         ///< of the local time, that a reversible step may take
  static constexpr double scout_share = 0.2;       ///< of the budget
  static constexpr double most_of_first = 0.7;     ///< of the budget, that the first race may take
  static constexpr double first_share = 0.3;       ///< of the budget, for the first race
  static constexpr double first_trials =
      120;  ///< that it takes for a target, each in so many of the scout's calls
  static constexpr double to_the_end = 0.5;      ///< budgets that a coarse run to T is worth
  static constexpr double overrun = 1.5;         ///< of the budget, at most
  static constexpr double whole_runs = 3;        ///< budgets in all, where advice is run to the end
  static constexpr double beside_share = 2.6;    ///< of the budget, for a neighbouring orbit
  static constexpr double stretch = 8;           ///< from one race to the next
  static constexpr double nearly_all = 0.8;      ///< of T: all of it is tried instead
  static constexpr double trials_a_racer = 2.5;  ///< usually
  static constexpr double least_scales = 8;      ///< that a trial has to last
  static constexpr double much_dearer = 20, much_varied = 12;
  static constexpr std::size_t most_racers = 5;
  static constexpr int most_trials = 8, most_besides = 4;

  Problem<Any>& problem_;
  CostTable& table_;
  std::vector<Family> families_;
  Scout<Any> scout_;
  Forecast<Any> forecast_;
  CallTimer<Any> timer_;
  std::vector<Goal> goals_{};
  std::size_t racing_ = 0;  ///< of them, the loosest
  bool first_race_ = false;
  bool cut_ = false;  ///< a trial met the limit of calls
};

}  // namespace semiexplicit::detail
