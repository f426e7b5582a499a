#pragma once

#include <concepts>
#include <type_traits>

#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/referred.hpp>
#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

namespace detail {

template <class O, class Scalar, class State>
concept TakesStepReport = std::invocable<O&, const Scalar&, const State&, const StepReport&>;
template <class O, class Scalar, class State>
concept TakesRunReport = std::invocable<O&, const Scalar&, const State&, const IntegrationReport&> &&
    !TakesStepReport<O, Scalar, State>;

}  // namespace detail

/// What integrate() tells of the run, at the start and after each step: any callable (t, state), or (t,
/// state, StepReport), or (t, state, IntegrationReport), which is the run's so far but for status, t and
/// seconds. Arguments by value or by const reference. One that returns the bool false ends the run; what else
/// it returns is ignored.
template <class O, class Scalar, class State>
concept Observer = std::invocable<O&, const Scalar&, const State&> ||
    detail::TakesStepReport<O, Scalar, State> || detail::TakesRunReport<O, Scalar, State>;

/// An observer for which integrate() cuts steps, since it may change the state there: `static constexpr bool
/// changes_state = true;`, see(t, z, report), which is told what observers are, first_event(start, end, h,
/// move), the first event on a step, changes(found), whether that may change z, act(found, t, z, report), and
/// known() and back_to(known, z), by which what fails or throws is taken back; see Events. It is no Observer,
/// so that none of those can hide it from integrate().
template <class O>
concept ChangesState = requires {
  requires bool(std::remove_cvref_t<O>::changes_state);
};

/// An observer that draws a curve through the states that it sees, and has to see all of a run that events
/// bend: `static constexpr bool interpolates = true;`.
template <class O>
concept Interpolates = requires {
  requires bool(detail::Referred<O>::interpolates);
};

/// An observer that saves what those before it have seen, as Checkpoints: `static constexpr bool saves_others
/// = true;`. No observer that a checkpoint can keep may stand behind it.
template <class O>
concept SavesOthers = requires {
  requires bool(detail::Referred<O>::saves_others);
};

namespace detail {

/// The parameters of a callable that is no template.
template <class O>
struct CalledWith : Parameters<O> {};
template <class O>
requires requires { &O::operator(); }
struct CalledWith<O> : Parameters<decltype(&O::operator())> {};
/// Whether the one that stands at `place` of so many or more is a whole number or a bool, which a time would
/// be rounded to; or, Time, a number that is none, which would be taken for a place in a list.
template <class O, std::size_t place, std::size_t least, bool Time = true>
constexpr bool rounds() {
  using Found = CalledWith<O>;
  if constexpr (Found::count >= least) {
    using T = std::remove_cvref_t<typename Found::template FromLast<Found::count - 1 - place>>;
    return Time ? std::is_integral_v<T> : std::is_floating_point_v<T>;
  } else {
    return false;
  }
}

/// Compiles for an observer of such a run; of anything else the compiler says what is missing.
template <class O, class Scalar, class State>
consteval bool is_observer() {
  static_assert(!ChangesState<Referred<O>>,
                "events that change the state are an argument of integrate() itself: not within every(), "
                "each(), at_times(), with_error_estimate() or std::ref(), and not of an Ensemble");
  static_assert(
      Observer<O, Scalar, State>,
      "this observer cannot be called: write `void operator()(const Scalar& t, const State& state)`, "
      "or a third parameter `const StepReport&` or `const IntegrationReport&`; the state is const (an action "
      "of events() that is to change it takes the very State& of the stepper, which may have the time in "
      "it)");
  static_assert(!rounds<Referred<O>, 0, 2>(),
                "this observer takes the time as a whole number, which rounds it: write `double t`; how many "
                "steps were taken the IntegrationReport of a third parameter says");
  return Observer<O, Scalar, State>;
}

/// Calls an observer with what it takes; false: it wants the run to stop.
template <class O, class Scalar, class State>
bool notify(O& observer, const Scalar& t, const State& state, const IntegrationReport& so_far) {
  const auto call = [&]() -> decltype(auto) {
    if constexpr (TakesStepReport<O, Scalar, State>)
      return observer(t, state, so_far.last);
    else if constexpr (TakesRunReport<O, Scalar, State>)
      return observer(t, state, so_far);
    else if constexpr (is_observer<O, Scalar, State>())
      return observer(t, state);
  };
  if constexpr (std::same_as<std::remove_cvref_t<decltype(call())>, bool>) {
    return call();
  } else {
    call();
    return true;
  }
}

/// The same for a state between the steps, which an observer of the run has found: its report says dt = 0, so
/// that who counts counts these calls.
template <class O, class Scalar, class State>
bool notify_between(O& observer, const Scalar& t, const State& state, const IntegrationReport& so_far) {
  if constexpr (!TakesRunReport<O, Scalar, State>) return notify(observer, t, state, so_far);
  IntegrationReport between = so_far;
  between.dt = 0;
  between.at_event = false;
  return notify(observer, t, state, between);
}

}  // namespace detail
}  // namespace semiexplicit
