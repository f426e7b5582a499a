#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

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
/// = true;`. No observer that a checkpoint can keep may stand behind it, nor may it stand within one that
/// shows other states than those of the run's steps.
template <class O>
concept SavesOthers = requires {
  requires bool(detail::Referred<O>::saves_others);
};

namespace detail {

/// Stand for a number where a call is tried, and convert to numbers of one kind: to those that keep the
/// digits of a time, to those that round it, and to those that count places in a list.
template <class Given>
struct AnyTime {
  template <std::floating_point T>
  requires(!is_narrower<T, Given>) operator T() const;
};
template <class Given>
struct AnyRounded {
  template <class T>
  requires is_narrower<T, Given>
  operator T() const;
};
struct AnyPlace {
  template <std::integral T>
  operator T() const;
};

/// A callable beside one that takes exactly such arguments, and is chosen where it fits better.
struct ChosenInstead {};
template <class O, bool is_const, class... Arguments>
struct Beside : O {
  using O::operator();
  ChosenInstead operator()(Arguments...) const;
};
template <class O, class... Arguments>
struct Beside<O, false, Arguments...> : O {
  using O::operator();
  ChosenInstead operator()(Arguments...);
};

/// A number to which `Given` converts no better than to any other.
template <class Given>
using OtherNumber = std::conditional_t<std::same_as<Given, float>, long double, float>;
/// What a callable, which may be a template, takes at one place of these arguments.
template <class O, class... Arguments>
struct AtPlace {
  template <std::size_t place, class Type>
  static consteval auto with() {
    return []<std::size_t... i>(std::index_sequence<i...>) {
      return std::type_identity<std::tuple<
          std::conditional_t<i == place, Type, std::tuple_element_t<i, std::tuple<Arguments...>>>...>>{};
    }
    (std::index_sequence_for<Arguments...>());
  }
  template <class... Tried>
  static consteval bool takes(std::type_identity<std::tuple<Tried...>>) {
    return std::is_invocable_v<O&, Tried...>;
  }
  /// Whether it takes at that place a number of another kind than it gets; not where its type is deduced.
  template <class... Tried>
  static consteval bool converts(std::type_identity<std::tuple<Tried...>>) {
    if constexpr (!std::is_class_v<O> || requires { &O::operator(); }) {
      return true;
    } else if constexpr (!std::is_final_v<O>) {
      constexpr bool is_const = std::is_invocable_v<const O&, Arguments...>;
      using Both = Beside<O, is_const, Tried...>;
      using Called = std::conditional_t<is_const, const Both, Both>;
      return requires(Called & both, Arguments... arguments) {
        { both(arguments...) } -> std::same_as<ChosenInstead>;
      };
    } else {
      return false;
    }
  }
  /// Whether a time is rounded there: to a whole number, or to fewer digits.
  template <std::size_t place>
  static consteval bool rounds() {
    using Given = std::tuple_element_t<place, std::tuple<Arguments...>>;
    if constexpr (std::is_arithmetic_v<Given> && std::is_invocable_v<O&, Arguments...>) {
      if constexpr (converts(with<place, OtherNumber<Given>>()))
        return takes(with<place, AnyRounded<Given>>()) && !takes(with<place, AnyTime<Given>>());
    }
    return false;
  }
  /// Whether a number in a list is taken as a time there.
  template <std::size_t place>
  static consteval bool is_no_place() {
    if constexpr (std::is_invocable_v<O&, Arguments...>) {
      if constexpr (converts(with<place, float>()))
        return takes(with<place, AnyTime<float>>()) && !takes(with<place, AnyPlace>());
    }
    return false;
  }
};

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
  using Called = Referred<O>;
  static_assert(
      !AtPlace<Called, Scalar, State>::template rounds<0>() &&
          !AtPlace<Called, Scalar, State, StepReport>::template rounds<0>() &&
          !AtPlace<Called, Scalar, State, IntegrationReport>::template rounds<0>(),
      "this observer takes the time as a whole number, or one of fewer digits than Scalar, which "
      "rounds it: write `const Scalar& t`; how many steps were taken the IntegrationReport of a third "
      "parameter says");
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

/// Compiles unless one of these observers, which are shown other states than those of the run's steps, saves
/// the run.
template <class... Observers>
consteval bool saves_no_run() {
  static_assert(!(SavesOthers<Observers> || ...),
                "Checkpoints save the run where a step ends, and within at_times(), a section, events() or "
                "with_error_estimate() they are shown other states: give them to integrate() itself, as the "
                "last of its observers; every() may be around them");
  return true;
}

/// The same for a state between the steps, which an observer of the run has found: its report says dt = 0, so
/// that who counts counts these calls.
template <class O, class Scalar, class State>
bool notify_between(O& observer, const Scalar& t, const State& state, const IntegrationReport& so_far) {
  static_assert(saves_no_run<O>());
  if constexpr (!TakesRunReport<O, Scalar, State>) return notify(observer, t, state, so_far);
  IntegrationReport between = so_far;
  between.dt = 0;
  between.at_event = false;
  return notify(observer, t, state, between);
}

}  // namespace detail
}  // namespace semiexplicit
