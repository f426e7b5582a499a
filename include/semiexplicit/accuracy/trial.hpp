#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <semiexplicit/accuracy/problem.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/median.hpp>
#include <semiexplicit/integrate.hpp>

namespace semiexplicit::detail {

/// A stretch of the run that settings are tried on.
template <class State>
struct Window {
  State start;
  double length;  ///< in time
  bool typical;   ///< chosen without regard to how hard it is, so that its cost counts for the whole run
};

/// What a setting did in a trial.
struct Probe {
  Status status = Status::success;
  double range = 0;   ///< of an invariant: the largest of all windows, in its unit
  double spread = 1;  ///< how much the ranges differ among the hard windows, as a factor
  double early = 0,
         late = 0;         ///< largest error in the first half of the trial from z0, and in the second
  double length = 0;       ///< of that trial
  double rate = 0;         ///< gradient calls a unit of time, in typical windows
  double evaluations = 0;  ///< a step, likewise
  double drift = 0;        ///< relative error a unit of time that unfinished solves may add up to
  bool confirmed = false;  ///< on more of the run than the others
  bool cut = false;        ///< the calls ended before the trial
  bool works() const { return status == Status::success && !cut; }
};

inline constexpr double finer_steps = 1.5;  ///< see try_beside_finer()

/// Steps a setting and counts.
template <class Any>
class Walker {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  SEMIEXPLICIT_COLD Walker(Problem<Any>& problem, const Setting& setting)
      : problem_(problem), setting_(setting), stepper_(problem.hamiltonian.stepper(setting)) {}

  /// One step; `counts`: among what the run is expected to cost. False: it failed, or the calls may not
  /// suffice.
  bool step(State& z, double dt, Probe& probe, bool counts) {
    if (static_cast<double>(stepper_.max_gradients()) > problem_.left()) {
      probe.cut = true;
      return false;
    }
    const StepReport report = stepper_.step(z, Scalar(dt));
    problem_.spend(static_cast<double>(report.gradients));
    if (!report.ok()) {
      probe.status = report.status;
      return false;
    }
    if (setting_.method == Setting::Method::semiexplicit || setting_.method == Setting::Method::midpoint)
      drift_ += unfinished(report, z);
    Count& count = counts ? typical_ : others_;
    count.calls += report.gradients;
    count.evaluations += report.evaluations;
    count.time += dt;
    ++count.steps;
    if (setting_.method == Setting::Method::semiexplicit &&
        count.evaluations > most_evaluations * std::max<std::int64_t>(count.steps, 4)) {
      probe.status = Status::no_convergence;
      return false;
    }
    return true;
  }

  void finish(Probe& probe) const {
    const Count& count = typical_.steps > 0 ? typical_ : others_;
    if (count.steps == 0) return;
    probe.drift = drift_ / (typical_.time + others_.time);
    probe.rate = static_cast<double>(count.calls) / count.time;
    probe.evaluations = static_cast<double>(count.evaluations) / static_cast<double>(count.steps);
  }

 private:
  struct Count {
    std::int64_t calls = 0, evaluations = 0, steps = 0;
    double time = 0;
  };

  /// What the step's unfinished solve may add to the error of the invariants, e (‖m‖ + e)/‖z‖²: see
  /// StoppingRule::product.
  double unfinished(const StepReport& report, const State& z) const {
    const double e = report.correction, size = static_cast<double>(state_size(problem_.hamiltonian, z));
    const double m = report.evaluations > 1 && report.rate > 0 ? e / report.rate : 0;
    return size > 0 ? (e / size) * ((m + e) / size) : 0;
  }

  /// A projection takes more a step only where half the step takes less than half as many, and right below
  /// steps at which it fails.
  static constexpr std::int64_t most_evaluations = 30;

  Problem<Any>& problem_;
  Setting setting_;
  AnyStepper<Scalar> stepper_;
  double drift_ = 0;
  Count typical_{}, others_{};
};

/// Follows an invariant along steps, the observable or the energy: how far apart its values are.
template <class Any>
class Range {
 public:
  using Value = typename Problem<Any>::Value;
  Range(const Problem<Any>& problem, bool of_energy) : problem_(&problem), of_energy_(of_energy) {}

  void start(const typename Any::State& z) {
    problem_->measure(z, low_, of_energy_);
    high_ = low_;
  }
  /// NaN makes the range NaN for good.
  void add(const typename Any::State& z) {
    problem_->measure(z, now_, of_energy_);
    for (Eigen::Index i = 0; i < now_.size(); ++i) {
      if (!(now_[i] >= low_[i]) && low_[i] == low_[i]) low_[i] = now_[i];
      if (!(now_[i] <= high_[i]) && high_[i] == high_[i]) high_[i] = now_[i];
    }
  }
  double range() const {
    return static_cast<double>(norm(high_ - low_)) / (of_energy_ ? problem_->energy : problem_->judged).unit;
  }

 private:
  const Problem<Any>* problem_;
  bool of_energy_;
  Value low_{}, high_{}, now_{};
};

/// Tries a setting on windows, for the observable where that is an invariant, or the energy. Gives up at the
/// first step that fails, or when the error exceeds `hopeless`.
template <class Any>
SEMIEXPLICIT_COLD Probe try_on_windows(Problem<Any>& problem, const Setting& setting,
                                       const std::vector<Window<typename Any::State>>& windows,
                                       double hopeless, bool of_energy) {
  Probe result;
  Walker<Any> walker(problem, setting);
  Range<Any> invariant(problem, of_energy);
  std::vector<double> hard;
  for (const auto& window : windows) {
    auto z = window.start;
    invariant.start(z);
    double half = 0;
    // The whole run is tried with the steps that it takes.
    const double T = problem.table.time;
    const bool whole = window.length >= T;
    const auto steps =
        whole ? steps_between(0.0, T, setting.dt) : std::max(4.0, std::floor(window.length / setting.dt) + 1);
    const double dt = whole ? T / steps : setting.dt;
    // Gauss's first step has nothing to extrapolate from: it is not counted.
    for (double n = 0; n < steps; ++n) {
      if (!walker.step(z, dt, result, n > 0 && window.typical)) return result;
      invariant.add(z);
      if (2 * n < steps) half = invariant.range();
    }
    if (&window == &windows.front()) {
      result.early = half, result.late = invariant.range();
      result.length = steps * dt;
    }
    if (!window.typical) hard.push_back(invariant.range());
    if (!(invariant.range() <= result.range)) result.range = invariant.range();
    if (!(result.range <= hopeless)) {
      result.status = Status::not_finite;
      return result;
    }
  }
  if (!hard.empty()) {
    const double usual = median(hard);
    if (usual > 0) result.spread = std::clamp(std::sqrt(result.range / usual), 1.0, 3.0);
  }
  walker.finish(result);
  return result;
}

/// The observable at the given rising times of a run from z0. advance(z) makes a step and returns the time
/// after it, or the same as before where it failed. Between the steps' ends it is found by shorter steps of
/// `method` back from the later one, so that no error of a whole step is left out; they leave the run alone.
/// Fewer values than times: a step failed.
template <class Any, class Advance>
SEMIEXPLICIT_COLD std::vector<typename Problem<Any>::Value> values_along(Problem<Any>& problem,
                                                                         const std::vector<double>& times,
                                                                         const Setting& method, Probe& probe,
                                                                         const Advance& advance) {
  std::vector<typename Problem<Any>::Value> values;
  Walker<Any> between(problem, method);
  auto z = problem.z0, at = z;
  for (double t = 0, end = 0; values.size() < times.size(); t = end) {
    end = advance(z);
    if (!(end > t)) break;
    for (; values.size() < times.size() && times[values.size()] <= end;
         values.push_back(problem.measured(at))) {
      at.vector() = z.vector();
      const double back = times[values.size()] - end;
      if (back != 0 && !between.step(at, back, probe, false)) return values;
    }
  }
  return values;
}

/// The same along the run that a setting stands for, which ends at T with equal steps.
template <class Any>
SEMIEXPLICIT_COLD std::vector<typename Problem<Any>::Value> values_of_run(Problem<Any>& problem,
                                                                          const Setting& setting,
                                                                          const std::vector<double>& times,
                                                                          Probe& probe) {
  Walker<Any> walker(problem, setting);
  const double T = problem.table.time, all = steps_between(0.0, T, setting.dt), dt = T / all;
  double n = 0;
  auto values = values_along(problem, times, setting, probe, [&](auto& z) {
    const double begin = n * dt, end = ++n < all ? n * dt : T;
    return walker.step(z, dt, probe, n > 1) ? end : begin;
  });
  walker.finish(probe);
  probe.length = times.back();
  return values;
}

/// Notes by how much the values of a run are off those that it is compared with, in both halves of it.
template <class Any>
SEMIEXPLICIT_COLD void note_errors(const Problem<Any>& problem, const std::vector<double>& times,
                                   const std::vector<typename Problem<Any>::Value>& values,
                                   const std::vector<typename Problem<Any>::Value>& right, double factor,
                                   Probe& probe) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double error = factor * static_cast<double>(norm(values[i] - right[i])) / problem.table.unit;
    double& half = times[i] < probe.length / 2 ? probe.early : probe.late;
    if (!(error <= half)) half = error;
  }
  if (!std::isfinite(probe.late)) probe.status = Status::not_finite;
}

/// Makes the whole run with a setting of that order, and again with steps finer_steps times smaller: what is
/// apart then tells the error at the end, also where that grows as no part of the run told.
template <class Any>
SEMIEXPLICIT_COLD Probe try_beside_finer(Problem<Any>& problem, const Setting& setting, int order) {
  constexpr int count = 100;
  std::vector<double> times;  // not in step with any period
  for (int i = 1; i <= count; ++i)
    times.push_back(i == count ? problem.table.time
                               : problem.table.time * (i - 0.3 * std::fmod(0.618034 * i, 1.0)) / count);
  Probe probe, finer;
  const auto values = values_of_run(problem, setting, times, probe);
  if (!probe.works()) return probe;
  Setting fine = setting;
  fine.dt /= finer_steps;
  const auto right = values_of_run(problem, fine, times, finer);
  probe.status = finer.status, probe.cut = finer.cut;
  if (!probe.works()) return probe;
  note_errors(problem, times, values, right, 1 / (1 - std::pow(finer_steps, -order)), probe);
  return probe;
}

}  // namespace semiexplicit::detail
