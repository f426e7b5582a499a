#pragma once

#include <cmath>
#include <concepts>
#include <type_traits>

#include <Eigen/Core>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

namespace detail {

/// Is dt a step at all: finite, and not zero?
template <class Scalar>
bool valid_step(const Scalar& dt) {
  using std::isfinite;
  return isfinite(dt) && dt != Scalar(0);
}

/// What every step asks first. `has_parts`: the stepper was not moved from; `fits`: the state has the
/// stepper's size.
template <class Scalar>
Status status_at_start(const Scalar& dt, bool has_parts, bool fits) {
  if (!valid_step(dt)) return Status::invalid_step;
  if (!has_parts) return Status::invalid_stepper;
  return fits ? Status::success : Status::invalid_state;
}

template <class S>
concept NamesScalarAndState = requires {
  typename S::Scalar;
  typename S::State;
};
/// It says its Hamiltonian, whose (q, p) its states are.
template <class S, int Dof>
concept SaysItsHamiltonianOf = requires(const S& stepper) {
  requires Hamiltonian<std::remove_cvref_t<decltype(stepper.hamiltonian())>>;
  requires(std::remove_cvref_t<decltype(stepper.hamiltonian())>::Dof == Dof);
};
/// That Hamiltonian; of a stepper that says none an empty class.
template <class S>
struct HamiltonianSaidBy {
  struct Type {
    using Scalar = double;
  };
};
template <class S>
requires SaysItsHamiltonianOf<S, S::State::Dof>
struct HamiltonianSaidBy<S> {
  using Type = std::remove_cvref_t<decltype(std::declval<const S&>().hamiltonian())>;
};
template <class S>
using SaidHamiltonian = typename HamiltonianSaidBy<S>::Type;
template <class S>
concept HasStep = requires(S& stepper, typename S::State& state, const typename S::Scalar& dt) {
  { stepper.step(state, dt) } -> std::same_as<StepReport>;
};

}  // namespace detail

/// Anything that moves a state by a step: Semiexplicit, MidpointProjection and GaussLegendre a PhasePoint,
/// Pihajoki and Tao an ExtendedPoint. It names its Scalar and its State, and has `StepReport step(State&
/// state, const Scalar& dt)`, which leaves the state as it was unless the report is ok(). A stepper whose
/// runs are to be saved has a `name`, lists its options and shows what it carries from step to step; see
/// Checkpointable. Two members are optional. `const H& hamiltonian() const`: of a driven H, or one of
/// transformed time, monitors and error estimates leave the time out only where they know of it.
/// `Eigen::Index dof() const`, where its size is known at run time: what keeps states of its own can be saved
/// then.
template <class S>
concept Stepper = detail::NamesScalarAndState<S> && detail::HasStep<S>;

/// A stepper whose steps take a time of its own choice, as ReversibleSteps: dt is the step of a parameter s
/// then, and the stepper knows the time. integrate() takes it from there, and so do its observers. Beside
/// what a stepper has:
///
///     void begin(const State& z, const Scalar& t);   // a run starts from z at the time t
///     Scalar time() const, taken() const;            // of its last state, and of the step to it
///     StepReport step_until(State& z, const Scalar& dt, const Scalar& t_end);  // step(), not beyond t_end
///     bool reached(const Scalar& t) const;           // has come to t, which time() may round to earlier
///     Clock clock() const;                           // what it knows of the time and of its steps,
///     void rewind(const Clock& clock, const State& z);  // and back to that, and the state of then
///     const S& stepper() const;                      // takes steps of given times; `using Fixed = S;`
template <class S>
concept ChoosesSteps = Stepper<S> && requires(S& s, const S& c, typename S::State& z,
                                              const typename S::Scalar& x, const typename S::Clock& clock) {
  s.begin(z, x);
  { c.time() } -> std::convertible_to<typename S::Scalar>;
  { c.taken() } -> std::convertible_to<typename S::Scalar>;
  { s.step_until(z, x, x) } -> std::same_as<StepReport>;
  { c.reached(x) } -> std::same_as<bool>;
  { c.clock() } -> std::convertible_to<typename S::Clock>;
  s.rewind(clock, z);
  { c.stepper() } -> std::convertible_to<const typename S::Fixed&>;
};

namespace detail {

/// Whether a function takes the state, its first parameter, by value or const.
template <class Function>
constexpr bool cannot_move_state(Function) {
  using Found = Parameters<Function>;
  if constexpr (Found::count >= 2) {
    using Given = typename Found::template FromLast<Found::count - 1>;
    return !std::is_reference_v<Given> || std::is_const_v<std::remove_reference_t<Given>>;
  } else {
    return false;
  }
}
/// Whether a step leaves the state where it is.
template <class S>
constexpr bool leaves_state() {
  using State = typename S::State;
  return cannot_move_state(pointer_to_step<S, State, typename S::Scalar, true>()) ||
         cannot_move_state(pointer_to_step_until<S, State, State, true>());
}

/// The optional members of a stepper, written so that they would be taken for absent.
template <class S>
concept NamesHamiltonianOtherwise = !requires(const S& stepper) {
  stepper.hamiltonian();
}
&&(
    requires(S& stepper) { stepper.hamiltonian(); } ||
    requires { requires std::is_member_function_pointer_v<decltype(&S::hamiltonian)>; });
template <class S>
concept NamesDofOtherwise = !requires(const S& stepper) {
  { stepper.dof() } -> std::convertible_to<Eigen::Index>;
}
&&(
    requires(S& stepper) { stepper.dof(); } ||
    requires { requires std::is_member_function_pointer_v<decltype(&S::dof)>; });

/// Whether a member that takes a time there, which is no template, rounds it.
template <class S>
constexpr bool rounds_times() {
  using Scalar = typename S::Scalar;
  const auto until = pointer_to_step_until<S, typename S::State>();
  bool found = rounds<Scalar, 3, 1>(until) || rounds<Scalar, 3, 2>(until);
  if constexpr (requires { &S::begin; }) found = found || rounds<Scalar, 2, 1>(&S::begin);
  if constexpr (requires { &S::reached; }) found = found || rounds<Scalar, 1, 0>(&S::reached);
  return found;
}

/// Compiles for a stepper; of anything else the compiler says what is missing.
template <class S>
consteval bool is_stepper() {
  static_assert(NamesScalarAndState<S>,
                "this stepper does not say what it moves: write `using Scalar = double; using State = "
                "PhasePoint<double, 2>;` in it");
  static_assert(!std::is_const_v<S>, "the stepper is const, and a step changes it: leave `const` out");
  if constexpr (NamesScalarAndState<S> && !std::is_const_v<S>)
    static_assert(HasStep<S>,
                  "this stepper has no step: write `StepReport step(State& state, const Scalar& dt)` in it, "
                  "not const");
  if constexpr (NamesScalarAndState<S>)
    static_assert(
        !leaves_state<S>(),
        "the step of this stepper takes the state by value or const, so that it stays where it is: write "
        "`StepReport step(State& state, const Scalar& dt)`");
  if constexpr (NamesScalarAndState<S> && requires { typename S::State::Scalar; })
    static_assert(
        std::same_as<typename S::Scalar, typename S::State::Scalar>,
        "the State of this stepper has other numbers than its Scalar, in which dt comes: give both the "
        "same");
  if constexpr (NamesScalarAndState<S>)
    static_assert(
        !rounds<typename S::Scalar, 2, 1>(pointer_to_step<S, typename S::State, typename S::Scalar, true>()),
        "the step of this stepper takes dt as a whole number, or one of fewer digits than Scalar, which "
        "rounds it: write `StepReport step(State& state, const Scalar& dt)`");
  if constexpr (ChoosesSteps<S>)
    static_assert(!rounds_times<S>(),
                  "step_until, begin or reached of this stepper takes a time as a whole number, or one of "
                  "fewer digits than Scalar, which rounds it: write `const Scalar& t`");
  static_assert(!NamesHamiltonianOtherwise<S>,
                "hamiltonian() of this stepper cannot be called: write `const H& hamiltonian() const`");
  static_assert(!NamesDofOtherwise<S>,
                "dof() of this stepper cannot be called, or is no number: write `Eigen::Index dof() const`");
  static_assert(ChoosesSteps<S> || !(
                                       requires { &S::step_until; } ||
                                       requires {
                                         typename S::Fixed;
                                         typename S::Clock;
                                       }),
                "this stepper has a step_until() as one that chooses its steps, and lacks another part of "
                "ChoosesSteps (core/stepper.hpp): begin, time, taken, step_until, reached, clock, rewind, "
                "stepper, `using Clock` and `using Fixed`");
  return Stepper<S> && !std::is_const_v<S>;
}
/// The same for one that moves such a state.
template <class S, class State>
consteval bool is_stepper_of() {
  static_assert(!std::is_const_v<State>,
                "the state is const, and a run moves it: leave `const` out, or give it a copy");
  if constexpr (!is_stepper<S>() || std::is_const_v<State>) {
    return false;
  } else {
    static_assert(std::same_as<State, typename S::State>,
                  "the state is of another type than the one that the stepper moves: give it a "
                  "PhasePoint<Scalar, Dof> with the Scalar and Dof of the Hamiltonian (Pihajoki and Tao: an "
                  "ExtendedPoint)");
    return std::same_as<State, typename S::State>;
  }
}

/// Compiles for a stepper whose states can be made before it has seen one, as a run that is resumed needs.
template <class S>
consteval bool is_of_known_size() {
  static_assert(
      S::State::Dof != Eigen::Dynamic || requires(const S& s) { s.dof(); },
      "this stepper, of a size known at run time, does not say how large its states are, so that "
      "no run can be resumed: write `Eigen::Index dof() const` in it");
  return true;
}

/// The numbers that a stepper computes with; double where it does not say.
template <class S>
struct StepperScalar {
  using Type = double;
};
template <NamesScalarAndState S>
struct StepperScalar<S> {
  using Type = typename S::Scalar;
};

}  // namespace detail
}  // namespace semiexplicit
