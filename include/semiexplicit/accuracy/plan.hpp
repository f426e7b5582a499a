#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <vector>

#include <semiexplicit/accuracy/pilot.hpp>

namespace semiexplicit::detail {

/// How the gradient calls are shared out, and which parts of the run settings are tried on.
template <class Any>
class Plan {
 public:
  using State = typename Any::State;

  Plan(Problem<Any>& problem, const Pilot<Any>& pilot)
      : problem_(problem), table_(problem.table), pilot_(pilot) {}

  static constexpr double window_count = 8;

  double budget = 0;       ///< gradient calls of the search
  double trial_time = 0;   ///< how long a setting is tried
  bool surprised = false;  ///< the error of a whole run was more than twice what parts of it told

  /// Shares out the calls, by what the pilot knows.
  SEMIEXPLICIT_COLD void share() {
    double run_rates = 0;
    for (const double target : options().targets) run_rates += run_rate(target);
    const double least = options().min_gradients * (table_.invariant ? 1 : 10);
    set_budget(
        std::min(std::max(least, options().budget * run_rates * table_.time), options().max_gradients / 3));
    trial_time = trial_share * budget / (run_rates * trials_a_target);
  }
  void set_budget(double calls) { table_.budget = budget = calls; }

  /// Gradient calls a unit of time of a run to a target.
  double run_rate(double target) const { return run_over_pilot(local(target)) * pilot_.rate; }

  /// The error of an invariant that goes with a target: a phase error adds up over the time.
  double local(double target) const {
    if (table_.invariant) return target;
    return std::max(1e-15, target * std::min(1.0, 10 * table_.time_scale / table_.time));
  }

  /// What is no invariant is tried from z0 on, as far as there is something to compare it with.
  void try_until(double length) {
    table_.windows = 1;
    table_.window_time = trial_time = std::min(trial_time, length);
  }
  /// The windows that an invariant is tried on: the start, evenly spread ones, and the hardest.
  SEMIEXPLICIT_COLD void choose_windows() {
    if (trial_time >= table_.time) return try_whole();
    // What need not be bounded is followed for longer.
    const bool energy = options().observable.is_energy();
    const double each = trial_time / window_count / (energy ? 1 : 2);
    windows_.push_back({problem_.z0,
                        energy ? each : std::max(trial_time / 2, std::min(trial_time, 1.05 * table_.cycle)),
                        true});
    const auto& all = pilot_.places.all();
    for (std::size_t i = 1; i <= 2; ++i)
      windows_.push_back({problem_.on_the_energy(all[all.size() * i / 3].start), each, true});
    for (std::size_t i = 0; i < 5 && i < pilot_.places.count(); ++i)
      windows_.push_back(
          {problem_.on_the_energy(pilot_.places.hardest(i)), std::max(each, pilot_.segment_time), false});
    note_windows();
  }
  /// From now on settings are tried on the whole run.
  SEMIEXPLICIT_COLD void try_whole() {
    windows_ = {{problem_.z0, table_.time, true}};
    trial_time = table_.time;
    note_windows();
  }
  bool tries_whole() const { return windows_.size() == 1 && windows_.front().length >= table_.time; }
  const std::vector<Window<State>>& windows() const { return windows_; }

  /// Whether a choice that takes `rate` calls a unit of time is worth confirming on the whole run.
  bool confirms_whole(double rate) const {
    return whole_calls(rate) <= (surprised ? 10 : 1) * std::max(budget, 10 * options().min_gradients) &&
           at_most(whole_calls(rate)) <= options().max_gradients - table_.spent_gradients;
  }
  /// With a margin: parts of a run tell its calls to that.
  static double at_most(double calls) { return 1.2 * calls; }
  /// The gradient calls that it takes: what is no invariant has to be compared with something.
  double whole_calls(double rate) const {
    return (table_.invariant ? 1 : 1 + finer_steps) * rate * table_.time;
  }
  /// How far from z0 on a choice is confirmed.
  double confirming_time(double rate) const { return confirm_share * budget / rate; }
  /// What it is confirmed on: other hard stretches, and the run itself as far as the calls go.
  SEMIEXPLICIT_COLD std::vector<Window<State>> confirming_windows(double rate) {
    const double length = confirms_whole(rate) ? table_.time : std::min(table_.time, confirming_time(rate));
    std::vector<Window<State>> list{{problem_.z0, length, true}};
    for (std::size_t i = 5; i < 30 && i < pilot_.places.count() && length < table_.time; ++i)
      list.push_back({problem_.on_the_energy(pilot_.places.hardest(i)), pilot_.segment_time, false});
    return list;
  }

  /// How much larger than in the hardest stretch that was tried the error of a method of that order gets.
  SEMIEXPLICIT_COLD double growth(int order) const {
    if (tries_whole()) return 1;
    return table_.changes ? pilot_.walk : pilot_.places.growth(order, table_.time / table_.pilot_time);
  }

 private:
  const auto& options() const { return problem_.options; }

  /// How many times the gradient calls of the pilot a run to a target takes, in the same time: a rule of
  /// thumb.
  static double run_over_pilot(double target) { return 1.5 * std::pow(target / 1e-4, -0.12); }

  SEMIEXPLICIT_COLD void note_windows() {
    table_.window_time = 0;
    for (const auto& window : windows_) table_.window_time += window.length;
    table_.windows = static_cast<int>(windows_.size());
    table_.growth = growth(4);
  }

  static constexpr double trial_share = 0.45, confirm_share = 0.25;  ///< of the budget
  static constexpr double trials_a_target = 12;

  Problem<Any>& problem_;
  CostTable& table_;
  const Pilot<Any>& pilot_;
  std::vector<Window<State>> windows_{};
};

}  // namespace semiexplicit::detail
