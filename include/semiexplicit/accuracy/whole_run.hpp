#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/accuracy/candidates.hpp>
#include <semiexplicit/accuracy/plan.hpp>

namespace semiexplicit::detail {

/// What trials on parts of the run tell of its error as a whole.
template <class Any>
class WholeRun {
 public:
  WholeRun(const Problem<Any>& problem, const Plan<Any>& plan)
      : problem_(problem), table_(problem.table), plan_(plan) {}

  /// The parts of the estimate of the error over the whole time.
  struct Estimate {
    double step, drift, rounding;
    bool grows;
    double sum() const { return step + drift + rounding; }
  };
  SEMIEXPLICIT_COLD Estimate estimate(const Candidate& candidate, const Probe& probe, double dt) const {
    const double T = table_.time;
    const bool explicit_ = candidate.setting.method == Setting::Method::midpoint;
    const bool energy = problem_.options.observable.is_energy();
    const bool whole = is_whole(probe);
    const double worse = whole ? 1 : surprise(candidate, probe);
    const double hard = probe.range * (whole ? 1 : probe.spread * plan_.growth(candidate.order) * worse);
    // A symplectic method keeps the energy within bounds. The trials of another are too short to tell its
    // drift.
    const double grown =
        !energy || (explicit_ && probe.confirmed) ? at_the_end(probe, explicit_) * (energy ? 1 : worse) : 0;
    // The energy that drifts takes the frequencies along.
    const double drift = table_.invariant      ? (whole ? 0 : probe.drift * T)
                         : explicit_ && !whole ? 0.1 * probe.drift * T * T / (2 * table_.time_scale)
                                               : 0;
    const double rounding = table_.invariant ? problem_.rounding(dt) : problem_.rounding_of_orbit(dt);
    const bool grows = whole ? !energy && probe.late > 1.4 * probe.early
                             : grown > std::max(hard, 1.2 * std::max(probe.early, probe.late));
    const double step = std::max(hard, grown);
    // What a whole run was off holds its rounding.
    if (whole && !table_.invariant)
      return {step - std::min(step, rounding), drift, std::min(step, rounding), grows};
    return {step, drift, rounding, grows};
  }

  /// No smaller than with any shorter step that was tried: an error that dips at one step is luck, but where
  /// it is that of the run itself.
  double error(const Candidate& candidate, const Probe& probe, double dt) const {
    double worst = estimate(candidate, probe, dt).sum();
    if (is_whole(probe)) return worst;
    for (const auto& [step, seen] : candidate.trials)
      if (step < dt && seen.works()) worst = std::max(worst, estimate(candidate, seen, step).sum());
    return worst;
  }

  /// A candidate's error of the whole run turned out to be `ratio` times the estimate by `probe`.
  SEMIEXPLICIT_COLD void learn(Candidate& candidate, const Probe& probe, double ratio) {
    last_surprise_ = candidate.surprise = std::max(1e-3, ratio * surprise(candidate, probe));
  }
  /// Every target has been searched for.
  void settle() { settled_ = true; }
  bool settled() const { return settled_; }

 private:
  bool is_whole(const Probe& probe) const { return probe.length >= 0.999 * table_.time; }

  /// The error of the whole run, in what parts of it tell. Too much is believed only where a choice is tried
  /// on all of it.
  double surprise(const Candidate& candidate, const Probe& probe) const {
    const double known = candidate.surprise > 0 ? candidate.surprise : last_surprise_;
    return plan_.confirms_whole(probe.rate) && !settled_ ? known : std::max(1.0, known);
  }

  /// What an error that was seen to grow from z0 on, or not, comes to at T.
  SEMIEXPLICIT_COLD double at_the_end(const Probe& probe, bool explicit_) const {
    const double seen = std::max(probe.early, probe.late), T = table_.time;
    if (is_whole(probe)) return seen;
    // A few passages of a hard place may all be lucky.
    const double cycles = table_.cycle > 0 ? std::floor(probe.length / table_.cycle) : 1e9;
    const double spread = 1 + 2 / std::max(1.0, cycles * cycles);
    const double ratio = probe.early > 0 ? probe.late / probe.early : 1;
    // In t² grows what a method that is not symplectic makes; of another only a long trial is believed that.
    const bool squared = ratio > 2.8 && (explicit_ || (probe.length > 0.05 * T && cycles > 1));
    if (table_.parting_rate > 0 || ratio > 1.4 || cycles < 2)
      return spread * error_at_the_end(table_, seen, probe.length, squared ? 2 : 1);
    // What comes back with the motion may hide growth of its own size.
    const double grown = std::max(2 * (probe.late - probe.early), hidden_growth * probe.late);
    return spread * seen + grown / probe.length * (T - probe.length);
  }

  static constexpr double hidden_growth = 0.4;  ///< in a trial from z0, of the error that it saw

  const Problem<Any>& problem_;
  const CostTable& table_;
  const Plan<Any>& plan_;
  double last_surprise_ = 1;  ///< of all candidates
  bool settled_ = false;
};

}  // namespace semiexplicit::detail
