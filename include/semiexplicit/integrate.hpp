#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/observer.hpp>
#include <semiexplicit/core/stepper.hpp>

namespace semiexplicit {

/// What integrate() does about a step that fails.
enum class OnFailure {
  raise,  ///< throw IntegrationError; the state is the last good one
  stop    ///< return the report, whose status says why
};

/// How far to go, and how.
template <class Scalar>
struct IntegrationOptions {
  Scalar dt =
      Scalar(0);  ///< the step; negative goes back in time; of a stepper that ChoosesSteps in its parameter
  static constexpr std::int64_t not_given = -1;
  std::int64_t steps = not_given;  ///< how many, those of `done` included; instead of t_end
  OnFailure on_failure = OnFailure::raise;
  /// A step that does not converge or is not finite is tried again as 2, 4, ... up to 2^subdivide equal ones
  /// before it counts as failed; IntegrationReport::subdivided says how often. The energy then may drift: a
  /// step that depends on the state is a symplectic map no more. Observers see whole steps: what interpolates
  /// between such says by interpolation_error() how badly. Not with events that change the state. 0: never.
  int subdivide = 0;
  Scalar t0 = Scalar(0);  ///< time of the state that is handed in, or of the first one where the run goes on
  /// Where the run ends, exactly: with the fewest equal steps that are no longer than dt.
  /// IntegrationReport::dt says which dt that took. A stepper that ChoosesSteps keeps dt and cuts its last
  /// two steps. Not given: `steps` says how far.
  std::optional<Scalar> t_end{};
  /// Report of an earlier part, which the run goes on from: its steps count among `steps`, and its sums are
  /// added to. See Checkpoints::resume().
  IntegrationReport done{};
};

namespace detail {

/// Refuses an observer that counts on having seen a run from its start, and has not.
template <class Observer>
void require_restored(const Observer& observer, std::int64_t steps) {
  if (is_fresh(observer))
    throw std::invalid_argument("integrate: the run is resumed after step " + std::to_string(steps) +
                                ", and an observer knows nothing of what came before; name it among those of "
                                "Checkpoints");
}

/// Throws std::invalid_argument where an observer saves another stepper than the run's, which a resumed run
/// would go on without, and std::logic_error where it put back another state than the run goes on from.
template <class S, class Observer>
void require_saved(const S& stepper, const typename S::State& state, std::int64_t steps,
                   const Observer& observer) {
  if constexpr (requires { referred(observer).saves(stepper); })
    if (!referred(observer).saves(stepper))
      throw std::invalid_argument(
          "integrate: the Checkpoints among the observers save another stepper, or a copy of the run's: make "
          "them with the very stepper that integrate() is given");
  if constexpr (requires { referred(observer).require_start(state, steps); })
    referred(observer).require_start(state, steps);
}

/// Whether the run ends at a time that the stepper's own steps are to meet.
template <class S>
bool ends_by_clock(const IntegrationOptions<typename S::Scalar>& options) {
  return ChoosesSteps<S> && options.t_end;
}

/// What a stepper that chooses its steps knows of the time; of others nothing.
template <class S>
auto clock_of(const S& stepper) {
  if constexpr (ChoosesSteps<S>)
    return stepper.clock();
  else
    return 0;
}

/// What a step says to a run, whose own `stopped` is: from a step, its solver or its flow it is a failure.
inline StepReport said_by_step(StepReport report) {
  if (report.status == Status::stopped) report.status = Status::invalid_stepper;
  return report;
}

/// A step of size dt, not beyond t_end.
template <class S>
StepReport one_step(S& stepper, typename S::State& state, const typename S::Scalar& dt,
                    const IntegrationOptions<typename S::Scalar>& options) {
  if constexpr (ChoosesSteps<S>)
    if (ends_by_clock<S>(options)) return said_by_step(stepper.step_until(state, dt, *options.t_end));
  return said_by_step(stepper.step(state, dt));
}

/// The failed step from `state`, the last good one, as 2, 4, ... equal ones, the first number that succeeds;
/// adds to the report what they cost.
template <class S>
SEMIEXPLICIT_COLD bool step_in_parts(S& stepper, typename S::State& state,
                                     const IntegrationOptions<typename S::Scalar>& options,
                                     IntegrationReport& report) {
  using Scalar = typename S::Scalar;
  const StepReport whole = report.last;
  [[maybe_unused]] const auto clock = clock_of(stepper);
  Scalar part = options.dt;
  std::int64_t parts = 1;
  for (int level = 0; level < options.subdivide; ++level) {
    if (report.last.status != Status::no_convergence && report.last.status != Status::not_finite) break;
    parts *= 2;
    part /= 2;
    typename S::State trial = state;
    struct Back {  // of the clock, unless all parts succeed; also where a gradient throws
      S& stepper;
      const decltype(clock)& to;
      const typename S::State& state;
      bool all = false;
      ~Back() {
        if constexpr (ChoosesSteps<S>)
          if (!all) stepper.rewind(to, state);
      }
    } back{stepper, clock, state};
    [[maybe_unused]] double taken = 0;
    StepReport together;
    for (std::int64_t i = 0; i < parts && together.ok(); ++i) {
      if constexpr (ChoosesSteps<S>)
        if (ends_by_clock<S>(options) && stepper.reached(*options.t_end)) break;
      const StepReport one = one_step(stepper, trial, part, options);
      report.evaluations += one.evaluations;
      report.gradients += one.gradients;
      together = {.status = one.status,
                  .evaluations = together.evaluations + one.evaluations,
                  .gradients = together.gradients + one.gradients,
                  .correction = std::max(together.correction, one.correction),
                  .rate = std::max(together.rate, one.rate),
                  .escalations = std::max(together.escalations, one.escalations)};
      if constexpr (ChoosesSteps<S>) taken += static_cast<double>(stepper.taken());
    }
    report.last = together;
    if (together.ok()) {
      state = trial;
      back.all = true;
      if constexpr (ChoosesSteps<S>) report.taken = taken;
      ++report.subdivided;
      return true;
    }
  }
  report.last = whole;  // what is said of a failure is said of the step that was asked for
  return false;
}

/// The fewest equal steps no longer than dt from t0 to t_end, which lies where dt leads; a quotient that is a
/// whole number but for rounding is one. The times themselves are rounded, and late ones by more than their
/// difference is.
template <class Scalar>
Scalar steps_between(const Scalar& t0, const Scalar& t_end, const Scalar& dt) {
  using std::abs;
  using std::ceil;
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), quotient = (t_end - t0) / dt;
  const Scalar slack = (8 * epsilon * quotient) + epsilon / 2 * (abs(t0) + abs(t_end)) / abs(dt);
  const Scalar steps = ceil(quotient - (slack < Scalar(0.5) ? slack : Scalar(0.5)));
  return steps < Scalar(1) ? Scalar(1) : steps;
}

/// The options with t_end turned into steps and the dt that they take, unless the stepper S chooses its
/// steps.
template <class S, class Scalar = typename S::Scalar>
SEMIEXPLICIT_COLD IntegrationOptions<Scalar> with_steps(
    std::type_identity_t<IntegrationOptions<Scalar>> options) {
  using std::abs;
  using std::isfinite;
  const bool by_steps = options.steps != options.not_given;
  if (by_steps == options.t_end.has_value())
    throw std::invalid_argument(by_steps ? "integrate: give steps or t_end, not both"
                                         : "integrate: give steps or t_end, or there is no end");
  if (by_steps) return options;
  options.steps = 0;
  const Scalar time = *options.t_end - options.t0;
  if (!isfinite(time) || !isfinite(options.dt) || options.dt == Scalar(0))
    throw std::invalid_argument(
        "integrate: with t_end, dt must be finite and not zero, and t_end and t0 finite");
  if (time == Scalar(0)) return options;
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
  if ((time > Scalar(0)) != (options.dt > Scalar(0)))
    throw std::invalid_argument("integrate: dt leads away from t_end; give it the sign of t_end - t0");
  if (ChoosesSteps<S>) return options;
  const Scalar steps = steps_between(options.t0, *options.t_end, options.dt);
  if (!(steps < Scalar(9e18)))
    throw std::invalid_argument("integrate: t_end is more than 9e18 steps of dt away; give a longer dt");
  options.steps = static_cast<std::int64_t>(steps);
  // A dt that divides the time stays as it is, bit for bit: a longer t_end then goes on with the same steps.
  // What was gone on with so far divides it but for the rounding of both times.
  const Scalar even = time / Scalar(options.steps);
  const Scalar of_times = options.done.steps > 0 && options.done.dt == static_cast<double>(options.dt)
                              ? epsilon / 2 * (abs(options.t0) + abs(*options.t_end)) / Scalar(options.steps)
                              : Scalar(0);
  if (abs(even - options.dt) > 4 * epsilon * abs(options.dt) + of_times) options.dt = even;
  return options;
}

/// Throws std::invalid_argument, in the name of `who`, unless a step may be cut into 2^subdivide parts.
SEMIEXPLICIT_COLD inline void require_subdivide(const std::string& who, int subdivide) {
  if (subdivide < 0 || subdivide > 30)
    throw std::invalid_argument(who + ": subdivide is not between 0 and 30; 10 makes a thousandth of a step");
}

/// Throws std::invalid_argument, in the name of `who`, where a run begins or ends at no finite time. A dt
/// that is NaN or Inf is for the steps to refuse.
template <class Scalar>
SEMIEXPLICIT_COLD void require_times(const std::string& who, const Scalar& t0, std::int64_t steps,
                                     const Scalar& dt) {
  using std::isfinite;
  if (!isfinite(t0)) throw std::invalid_argument(who + ": t0 is not finite; give the time of the start");
  if (isfinite(dt) && !isfinite(Scalar(t0 + Scalar(steps) * dt)))
    throw std::invalid_argument(who + ": t0 + steps dt is not finite; give fewer steps, or a shorter dt");
}

/// Throws std::invalid_argument, in the name of `who`, where the earlier part of a run took other steps.
SEMIEXPLICIT_COLD inline void require_step(const std::string& who, const IntegrationReport& done, double dt) {
  if (done.steps > 0 && done.dt != 0 && done.dt != dt)
    throw std::invalid_argument(who + ": the earlier part took steps of " + in_words(done.dt, 17) +
                                ", and dt is " + in_words(dt, 17) +
                                " now; give the same dt, or begin a new run with t0 = the time reached");
}

/// Throws std::invalid_argument, in the name of `who`, unless the earlier part of a run of equal steps began
/// at t0.
template <class Scalar>
SEMIEXPLICIT_COLD void require_start(const std::string& who, const IntegrationReport& done,
                                     const Scalar& t0) {
  if (done.steps == 0 || done.dt == 0) return;
  const double start = static_cast<double>(t0), reached = start + static_cast<double>(done.steps) * done.dt,
               epsilon = std::max(std::numeric_limits<double>::epsilon(),
                                  static_cast<double>(Eigen::NumTraits<Scalar>::epsilon())),
               rounding = 4 * epsilon * (std::abs(start) + std::abs(reached));
  if (std::abs(done.t - reached) > std::abs(done.dt) / 2 + rounding)
    throw std::invalid_argument(who + ": the earlier part, `done`, came to t = " + in_words(done.t, 17) +
                                " and from t0 = " + in_words(start, 17) + " it would have come to " +
                                in_words(reached, 17) + "; give the t0 that it began with, or no `done`");
}

/// Throws std::invalid_argument for options that make no sense.
template <class Scalar>
SEMIEXPLICIT_COLD void check_options(const IntegrationOptions<Scalar>& options, bool by_clock,
                                     bool equal_steps) {
  require_subdivide("integrate", options.subdivide);
  if (options.steps < 0)
    throw std::invalid_argument("integrate: steps is negative; to go back in time give a negative dt");
  require_times("integrate", options.t0, options.steps, options.dt);
  if (options.done.steps < 0 || (!by_clock && options.done.steps > options.steps))
    throw std::invalid_argument("integrate: " + std::to_string(options.done.steps) +
                                " steps are done, and not 0 to " + std::to_string(options.steps) +
                                " of them; steps counts those of the earlier part, too");
  if (options.done.at_event)
    throw std::invalid_argument("integrate: the earlier part ended at an event within a step, at t = " +
                                in_words(options.done.t, 17) +
                                ", and its steps cannot be gone on with; start a new run with t0 = report.t "
                                "and without `done`");
  require_step("integrate", options.done, static_cast<double>(options.dt));
  if (equal_steps) require_start("integrate", options.done, options.t0);
}

/// Throws std::invalid_argument where what is left of a run is more steps of the last one's length than
/// anyone can wait for.
template <class Scalar>
void require_end(const Scalar& left, const Scalar& taken, const Scalar& t) {
  using std::abs;
  if (abs(left) < Scalar(9e18) * abs(taken)) return;
  throw std::invalid_argument("integrate: at t = " + in_words(t, 9) + " a step took " + in_words(taken, 3) +
                              ", and t_end is more than 9e18 of these away; give a longer dt, or a monitor "
                              "function that stays of the size of the local time scale");
}

/// Throws std::invalid_argument unless a stepper that chooses its steps is where the earlier part of a run
/// left it, and t_end lies ahead. What a checkpoint restored has no `taken`.
template <ChoosesSteps S>
SEMIEXPLICIT_COLD void check_clock(const S& stepper, const IntegrationOptions<typename S::Scalar>& options) {
  if (options.done.steps == 0) return;
  // What was taken for a subdivided step is the sum of its parts.
  const bool same_step =
      options.done.subdivided > 0 || options.done.taken == static_cast<double>(stepper.taken());
  if (options.done.taken != 0 && !(same_step && options.done.t == static_cast<double>(stepper.time())))
    throw std::invalid_argument(
        "integrate: this stepper did not make the earlier part, or has made another run since, and it keeps "
        "the time and the length of its steps; go on with the one that made it, or begin a new run with "
        "t0 = the time reached");
  const typename S::Scalar left = options.t_end ? *options.t_end - stepper.time() : options.dt;
  if (left != 0 && (left > 0) != (options.dt > 0))
    throw std::invalid_argument("integrate: the earlier part went to t = " + in_words(stepper.time(), 17) +
                                ", and dt leads away from t_end; give a t_end beyond that");
}

/// Compiles for what a run tells of itself.
template <class O, class Scalar, class State>
consteval bool is_told() {
  if constexpr (ChangesState<O>)
    return true;
  else
    return is_observer<O, Scalar, State>();
}

/// Compiles unless an observer would change the state of a stepper that chooses its steps.
template <class S, class... Observers>
consteval bool lets_state_change() {
  constexpr bool lets = !(ChoosesSteps<S> && (false || ... || ChangesState<Observers>));
  static_assert(lets,
                "events that change the state need a stepper of equal steps, and this one chooses its steps: "
                "take its inner stepper, or actions with a const state");
  return lets;
}

/// Compiles unless a checkpoint would lack what an observer behind it sees of the same step.
template <class... Observers>
consteval bool saves_all() {
  bool saved = false, all = true;
  [[maybe_unused]] const auto next = [&](bool saves, bool is_kept) {
    all = all && !(saved && is_kept);
    saved = saved || saves;
  };
  (next(SavesOthers<Observers>, Checkpointable<Referred<Observers>>), ...);
  return all;
}

/// The observer that may change the state; of others there is none.
template <class First, class... Others>
auto& changing(First& first, Others&... others) {
  if constexpr (ChangesState<First>)
    return first;
  else
    return changing(others...);
}

/// A step that was taken from `start`, at the time t, to `state`, cut where an observer wants to change the
/// state: `state` and t become those after the last event, and what is left of the step is taken from there.
/// tell() notifies all observers of `state` at t. Success, `stopped` at an event, or why the rest of the step
/// failed; in the latter two cases behind an event report.at_event stays true. Where something throws,
/// `start` and `known` are the last good state and what the observer knew there: before an action that
/// throws.
template <class S, class Tell, class Observer, class Known>
Status cut_at_events(S& stepper, typename S::State& start, Known& known, typename S::State& state,
                     typename S::Scalar& t, const typename S::Scalar& end,
                     const IntegrationOptions<typename S::Scalar>& options, IntegrationReport& report,
                     const Tell& tell, Observer& observer) {
  using Scalar = typename S::Scalar;
  Scalar h = options.dt;
  const auto keep = [&] {
    start = state;
    known = observer.known();
  };
  const auto accept = [&] {
    report.max_correction = std::max(report.max_correction, report.last.correction);
  };
  constexpr int most = 1000;
  struct SearchFailed {
    StepReport step;
  };
  const auto move = [&](const Scalar& x, typename S::State& z) {
    z = start;
    if (x == Scalar(0)) return StepReport{};
    const StepReport one = one_step(stepper, z, x, options);
    report.evaluations += one.evaluations;
    report.gradients += one.gradients;
    return one;
  };
  const auto search = [&](const Scalar& x, typename S::State& z) {
    if (const StepReport one = move(x, z); !one.ok()) throw SearchFailed{one};
  };
  for (int events = 0;; ++events) {
    const auto back = [&] {
      state = start;
      observer.back_to(known, start);
      return report.last.status;
    };
    decltype(observer.first_event(start, state, h, search)) found;
    try {
      found = observer.first_event(start, state, h, search);
    } catch (const SearchFailed& failed) {
      report.last = failed.step;
      return back();
    }
    if (!found) {
      accept();
      report.part = events > 0 ? static_cast<double>(h) : 0;
      t = end;
      report.at_event = false;
      return Status::success;
    }
    if (events >= most)
      throw std::runtime_error("integrate: " + std::to_string(most) +
                               " events in the step to t = " + in_words(end, 9) +
                               "; take a shorter dt, or let the action end the run where they pile up");
    // The state goes to the event, however little of that a late time can tell.
    using std::abs;
    const Scalar rounding = 4 * Eigen::NumTraits<Scalar>::epsilon() * abs(options.dt);
    const Scalar x = abs(found.x) <= rounding ? Scalar(0) : abs(h - found.x) <= rounding ? h : found.x;
    report.last = move(x, state);
    if (!report.last.ok()) return back();
    accept();
    const Scalar now = x == h ? end : Scalar(t + x);
    t = (h > Scalar(0) ? now > end : now < end) ? end : now;
    h -= x;
    report.at_event = true;
    report.part = static_cast<double>(x);
    keep();
    bool go_on = x == Scalar(0) || tell();
    go_on = observer.act(found, t, state, report) && go_on;
    keep();
    const bool changed = observer.changes(found);
    report.changes += changed ? 1 : 0;
    report.part = 0;
    // What nothing has changed where the step begins was shown before.
    const bool shown = x == Scalar(0) && !changed;
    if (!shown && (h != Scalar(0) || !go_on)) go_on = tell() && go_on;
    if (!go_on) return Status::stopped;
    if (h == Scalar(0)) continue;
    report.last = one_step(stepper, state, h, options);
    report.evaluations += report.last.evaluations;
    report.gradients += report.last.gradients;
    if (!report.last.ok()) {
      state = start;
      return report.last.status;
    }
  }
}

/// integrate(), whose arguments are what they should be.
template <class S, class... Observers>
IntegrationReport integrate_checked(S& stepper, typename S::State& state,
                                    const IntegrationOptions<typename S::Scalar>& asked,
                                    Observers&... observers) {
  static_assert(saves_all<Observers...>(),
                "an observer that a checkpoint can keep stands behind Checkpoints, and a run that is resumed "
                "would lack what it saw of the last step: give Checkpoints as the last one");
  using Scalar = typename S::Scalar;
  const IntegrationOptions<Scalar> options = with_steps<S>(asked);
  const bool by_clock = ends_by_clock<S>(options);
  const auto time_after = [&](std::int64_t n) {
    if constexpr (ChoosesSteps<S>)
      return Scalar(stepper.time());
    else
      return n == options.steps && options.t_end ? *options.t_end
                                                 : Scalar(options.t0 + Scalar(n) * options.dt);
  };
  check_options(options, by_clock, !ChoosesSteps<S>);
  constexpr int changing_observers = (0 + ... + (ChangesState<Observers> ? 1 : 0));
  if (changing_observers > 0 && options.subdivide > 0)
    throw std::invalid_argument(
        "integrate: subdivide goes with no observer that changes the state (events() with such an action), "
        "whose search takes whole steps; leave subdivide at 0 and take a shorter dt");
  const auto start = std::chrono::steady_clock::now();
  (require_saved(stepper, state, options.done.steps, observers), ...);
  if (options.done.steps > 0) (require_restored(observers, options.done.steps), ...);
  IntegrationReport report = options.done;
  report.dt = static_cast<double>(options.dt);
  if constexpr (ChoosesSteps<S>) {
    check_clock(stepper, options);
    if (report.steps == 0) stepper.begin(state, options.t0);
  }
  Scalar t = report.steps > 0 ? time_after(report.steps) : options.t0;
  // Every observer hears of every step, also when one before it asks to stop.
  const auto show = [&](auto& observer) {
    if constexpr (ChangesState<decltype(observer)>) {
      observer.see(t, std::as_const(state), std::as_const(report));
      return true;
    } else {
      return notify(observer, t, state, report);
    }
  };
  const auto wanted = [&] {
    bool go_on = true;
    ((go_on = show(observers) && go_on), ...);
    return go_on;
  };
  const auto finish = [&](Status status) {
    report.status = status;
    report.t = static_cast<double>(t);
    report.seconds = options.done.seconds +
                     std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return report;
  };

  const auto fail = [&](Status status) {
    finish(status);
    if (options.on_failure == OnFailure::raise)
      throw IntegrationError(report, static_cast<double>(options.dt));
    return report;
  };
  static_assert(changing_observers <= 1,
                "only one observer of a run may change the state: put these events into one events(H, ...)");

  if (report.steps == 0 && !wanted()) return finish(Status::stopped);
  // The state at the last whole step, or at the last event behind that, for who goes on from there.
  std::optional<typename S::State> last_good;
  if (changing_observers == 1 || options.subdivide > 0) last_good.emplace(state);
  const auto at_end = [&] {
    if constexpr (ChoosesSteps<S>)
      if (by_clock) return stepper.reached(*options.t_end);
    return report.steps >= options.steps;
  };
  while (!at_end()) {
    if (last_good) *last_good = state;
    if constexpr (ChoosesSteps<S>)
      if (stepper.time() != t)
        throw std::logic_error(
            "integrate: an observer has moved the stepper of this run, which keeps a time; give it a copy");
    if constexpr (ChoosesSteps<S>)
      if (by_clock && report.steps > options.done.steps) require_end(*options.t_end - t, stepper.taken(), t);
    report.last = one_step(stepper, state, options.dt, options);
    report.evaluations += report.last.evaluations;
    report.gradients += report.last.gradients;
    if constexpr (ChoosesSteps<S>)
      if (report.last.ok()) report.taken = static_cast<double>(stepper.taken());
    if (!report.last.ok()) {
      if (last_good) state = *last_good;
      if (!step_in_parts(stepper, state, options, report)) return fail(report.last.status);
    }
    if constexpr (changing_observers == 1) {
      auto& changes = changing(observers...);
      const Status status = [&, known = changes.known()]() mutable {
        try {
          return cut_at_events(stepper, *last_good, known, state, t, time_after(report.steps + 1), options,
                               report, wanted, changes);
        } catch (...) {
          state = *last_good;
          changes.back_to(known, *last_good);
          throw;
        }
      }();
      if (status == Status::stopped) return finish(status);
      if (status != Status::success) return fail(status);
      ++report.steps;
    } else {
      report.max_correction = std::max(report.max_correction, report.last.correction);
      ++report.steps;
      t = time_after(report.steps);
    }
    if (!wanted()) return finish(Status::stopped);
  }
  return finish(Status::success);
}

}  // namespace detail

/// Takes `steps` steps of size dt, or those that end at t_end, and calls every observer, in order, at the
/// start and after each step. An observer is any callable (t, state), or (t, state, StepReport), or (t,
/// state, IntegrationReport), which is the run's so far but for status, t and seconds; one that returns the
/// bool false ends the run there (status `stopped`).
///
///     PhasePoint<double, 1> z(-3, 0);
///     integrate(stepper, z, {.dt = 0.01, .steps = 1000},
///               [](double t, const auto& z) { std::cout << t << ' ' << z.q() << '\n'; });
///
/// Times are t0 + n dt, without accumulated rounding; of a stepper that ChoosesSteps they are its own. A step
/// that fails leaves `state` at the last good one and throws IntegrationError, or ends the run
/// (OnFailure::stop). An exception of a gradient, an observer or an event's action passes through, with the
/// state likewise: that of the last whole step, or of the last event in the step behind it, before an action
/// that throws, or behind which a surface does. A new run from there, with t0 the time that observers were
/// shown with it, goes on with the same observers, and calls that action again. Throws std::invalid_argument
/// for a negative number of steps, a t_end that dt leads away from, a senseless `subdivide`, one with an
/// observer that changes the state (ChangesState), and a run to be gone on with that ended at an event within
/// a step (`done.at_event`), or that another stepper made that ChoosesSteps. With a stepper that ChoosesSteps
/// no observer may change the state; the compiler says so.
template <class S, class State, class... Observers>
IntegrationReport integrate(
    S&& stepper, State& state,
    const IntegrationOptions<typename detail::StepperScalar<std::remove_cvref_t<S>>::Type>& options,
    Observers&&... observers) {
  using Taken = std::remove_reference_t<S>;  // a temporary, too
  using Scalar = typename detail::StepperScalar<std::remove_cv_t<Taken>>::Type;
  if constexpr (!detail::is_stepper_of<Taken, State>() ||
                !(detail::is_told<std::remove_reference_t<Observers>, Scalar, State>() && ...) ||
                !detail::lets_state_change<Taken, std::remove_reference_t<Observers>...>())
    return {};
  else
    return detail::integrate_checked(stepper, state, options, observers...);
}

}  // namespace semiexplicit
