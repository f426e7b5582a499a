#pragma once

#include <cmath>
#include <concepts>

#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

namespace detail {

/// Is dt a step at all: finite, and not zero?
template <class Scalar>
bool valid_step(const Scalar& dt) {
  using std::isfinite;
  return isfinite(dt) && dt != Scalar(0);
}

/// What every step asks first. `has_parts`: the stepper was not moved from; `fits`: the state has the stepper's size.
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
template <class S>
concept HasStep = requires(S& stepper, typename S::State& state, const typename S::Scalar& dt) {
  { stepper.step(state, dt) } -> std::same_as<StepReport>;
};

}  // namespace detail

/// Anything that moves a state by a step: Semiexplicit, MidpointProjection and GaussLegendre a PhasePoint, Pihajoki and Tao
/// an ExtendedPoint. It names its Scalar and its State, and has `StepReport step(State& state, const Scalar& dt)`, which
/// leaves the state as it was unless the report is ok(). A stepper whose runs are to be saved has a `name`, lists its options
/// and shows what it carries from step to step; see Checkpointable.
template <class S>
concept Stepper = detail::NamesScalarAndState<S> && detail::HasStep<S>;

namespace detail {

/// Compiles for a stepper that moves such a state; of anything else the compiler says what is missing.
template <class S, class State>
consteval bool is_stepper_of() {
  static_assert(NamesScalarAndState<S>,
                "this stepper does not say what it moves: write `using Scalar = double; using State = "
                "PhasePoint<double, 2>;` in it");
  if constexpr (NamesScalarAndState<S>) {
    static_assert(HasStep<S>,
                  "this stepper has no step: write `StepReport step(State& state, const Scalar& dt)` in it, "
                  "not const");
    static_assert(std::same_as<State, typename S::State>,
                  "the state is of another type than the one that the stepper moves: give it a "
                  "PhasePoint<Scalar, Dof> with the Scalar and Dof of the Hamiltonian (Pihajoki and Tao: an "
                  "ExtendedPoint)");
    return HasStep<S> && std::same_as<State, typename S::State>;
  } else {
    return false;
  }
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
