#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/problem.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/time/reversible_steps.hpp>

namespace semiexplicit::detail {

/// What a setting did in a trial, a run from z0 on with the steps that the whole run takes.
struct Probe {
  Status status = Status::success;
  double early = 0, error = 0;  ///< largest error in the first quarter, and in all of it
  double length = 0;            ///< in time
  double asked = 0;             ///< how far it was to go
  double rate = 0;              ///< gradient calls a unit of time
  double evaluations = 0;       ///< a step
  double drift = 0;             ///< of the mean of an invariant, from one half of the trial to the other
  bool cut = false;             ///< the calls ended before the trial
  bool given_up = false;  ///< before the end, at an error that is hopeless for the target it was tried for
  bool works() const { return is_done(status) && !cut; }

  /// How far it is known what it does.
  double seen_to() const { return given_up ? length : asked; }

  void note(double t, double wanted, double off) {
    double* const both[] = {&early, &error};
    for (double* largest : both)
      if ((largest == &error || t <= wanted / 4) && !(off <= *largest)) *largest = off;
  }
};

/// Steps a setting and counts.
template <class Any>
class Walker {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  SEMIEXPLICIT_COLD Walker(Problem<Any>& problem, const Setting& setting)
      : problem_(problem),
        setting_(setting),
        stepper_(problem.hamiltonian.stepper(setting, Any::sweeps_of_trial)),
        most_(static_cast<double>(stepper_.max_gradients())) {}

  /// A step of the given time. False: it failed, or the calls may not suffice.
  template <class Time>
  bool step(State& z, const Time& dt, Probe& probe) {
    if (!affordable(1, probe)) return false;
    return count(stepper_.step(z, Scalar(dt)), static_cast<double>(dt), probe);
  }
  /// The same as the setting has them: the next of a run from z0 on, not beyond T, by equal ones of dt or a
  /// reversible one. t is the time after it.
  template <class Time>
  bool step_on(State& z, Time& t, const Time& dt, Probe& probe) {
    if (!setting_.reversible) {
      if (!step(z, dt, probe)) return false;
      const double T = problem_.table.time;
      t = Time(++taken_) * dt;
      if (!(t < T * (1 - 1e-12))) t = T;
      return true;
    }
    if (!affordable(4, probe)) return false;  // a start tries to both sides
    if (!following_) {
      following_.emplace(std::move(stepper_), pace_of(problem_.hamiltonian, setting_));
      following_->begin(z, Scalar(t));
    }
    const StepReport report = following_->step_until(z, Scalar(setting_.dt), Scalar(problem_.table.time));
    t = static_cast<Time>(following_->time());
    return count(report, static_cast<double>(following_->taken()), probe);
  }

  void finish(Probe& probe) const {
    if (steps_ == 0) return;
    probe.rate = static_cast<double>(calls_) / time_;
    probe.evaluations =
        static_cast<double>(evaluations_) / static_cast<double>(std::max<std::int64_t>(steps_ - 1, 1));
  }

 private:
  bool affordable(double steps, Probe& probe) const {
    probe.cut = steps * most_ > problem_.left();
    return !probe.cut;
  }
  bool count(const StepReport& report, double dt, Probe& probe) {
    problem_.spend(static_cast<double>(report.gradients));
    probe.status = report.status;
    if (!report.ok()) return false;
    // The first step of some has nothing to start from: it counts where there is no other.
    if (steps_++ == 1) time_ = 0, calls_ = evaluations_ = 0;
    time_ += dt, calls_ += report.gradients, evaluations_ += report.evaluations;
    if (setting_.method == Setting::Method::semiexplicit &&
        evaluations_ > most_evaluations * std::max<std::int64_t>(steps_, 4))
      probe.status = Status::no_convergence;
    return probe.works();
  }

  /// A projection takes more a step only where half the step takes less than half as many, and right below
  /// steps at which it fails.
  static constexpr std::int64_t most_evaluations = 30;

  Problem<Any>& problem_;
  Setting setting_;
  AnyStepper<Scalar> stepper_;
  double most_;  ///< gradient calls a step
  std::optional<ReversibleSteps<AnyStepper<Scalar>, monitors::TimeScale<Any>>> following_{};
  std::int64_t steps_ = 0, calls_ = 0, evaluations_ = 0;
  double time_ = 0, taken_ = 0;
};

/// The observable where a reference knows it.
template <class Any>
struct Sample {
  typename Problem<Any>::Time t;
  typename Problem<Any>::Value value;
  double apart;  ///< how far the two runs of the reference differ there
  double terms;  ///< about the size of what it is a sum of
  bool stays;    ///< however far the run goes: errors are far larger than usual, or no step comes near
  bool opening;  ///< one more at the start, where no step has told how far apart they may be
};

/// By how much the mean of something moves from the first half of a time to the second. Weights that rise and
/// fall leave its oscillations out.
template <class Value>
class DriftOfMean {
 public:
  void see(double part, const Value& value) {
    Half& half = part < 0.5 ? first_ : second_;
    const double weight = std::pow(std::sin(2 * std::numbers::pi * part), 2);
    if (half.weight == 0) half.sum = Value::Zero(value.size());
    half.sum += typename Value::Scalar(weight) * value;
    half.weight += weight;
  }
  double size() const {
    if (!(first_.weight > 0 && second_.weight > 0)) return 0;
    using Scalar = typename Value::Scalar;
    return static_cast<double>(
        norm((second_.sum / Scalar(second_.weight) - first_.sum / Scalar(first_.weight)).eval()));
  }

 private:
  struct Half {
    Value sum{};
    double weight = 0;
  };
  Half first_{}, second_{};
};

/// Tries a setting as far as `length`: against the first value at every step where there are no samples,
/// else against these. Gives up at the first step that fails, or where the error exceeds `hopeless`. Between
/// the steps' ends the observable is found by shorter steps back from the later one, so that no error of a
/// whole step is left out; they leave the run alone.
template <class Any>
SEMIEXPLICIT_COLD Probe try_setting(Problem<Any>& problem, const Setting& setting, double length,
                                    const std::vector<Sample<Any>>& samples, double hopeless) {
  using Time = typename Problem<Any>::Time;
  Probe probe;
  Walker<Any> walker(problem, setting), between(problem, setting);
  const double T = problem.table.time, unit = problem.judged.unit;
  const Time dt = Time(T) / Time(steps_between(0.0, T, setting.dt));
  auto z = problem.z0, at = z;
  auto value = problem.first;
  const auto note = [&](const Time& t, const auto& state, const auto& right) {
    problem.measure(state, value);
    const double off = static_cast<double>(norm(value - right)) / unit;
    probe.note(static_cast<double>(t), length, off);
    if (!std::isfinite(off)) probe.status = Status::not_finite;
    probe.given_up = probe.error > hopeless;
    if (probe.given_up) probe.length = static_cast<double>(t);
    return !probe.given_up && probe.works();
  };
  auto next = samples.begin();
  DriftOfMean<typename Problem<Any>::Value> drift;
  Time t = 0;
  while (t < length * (1 - 1e-12) && walker.step_on(z, t, dt, probe)) {
    if (probe.length == 0)  // far within the first step they tell nothing of this setting
      while (next != samples.end() && next->opening && next->t < t / 2) ++next;
    probe.length = static_cast<double>(t);
    if (samples.empty()) {
      if (!note(t, z, problem.first)) break;
      drift.see(probe.length / length, value - problem.first);
    }
    bool goes_on = true;
    for (; goes_on && next != samples.end() && next->t <= t; ++next) {
      at.vector() = z.vector();
      const Time back = next->t - t;
      goes_on = (back == 0 || between.step(at, back, probe)) && note(next->t, at, next->value);
      if (goes_on && !problem.keeps_energy(at)) probe.status = Status::not_finite, goes_on = false;
    }
    if (!goes_on) break;
  }
  walker.finish(probe);
  probe.drift = drift.size() / unit;
  return probe;
}

}  // namespace semiexplicit::detail
