#pragma once

#include <concepts>
#include <cstddef>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/report.hpp>
#include <semiexplicit/scene/effect.hpp>

namespace semiexplicit {

/// The exact flow of an effect, or of a group of effects together: a template to specialise, for effects of
/// one's own, too. With it stepper_for(scene, exactly<Spring, Kinetic>()) moves these effects exactly, on one
/// copy of the phase space:
///
///     template <>
///     struct semiexplicit::ExactFlow<Kinetic, Spring> {
///       static constexpr const char* name = "harmonic oscillator";     // for explain()
///       static constexpr bool rest_is_small = true;                    // optional, see below
///       static constexpr bool quadratic_in_momenta = true;             // optional, see below
///       ExactFlow(const Kinetic&, const Spring& spring) : k(spring.k) {}
///
///       // Writes what q and p move by in the time t, of either sign; all but Status::success refuses it.
///       Status increments(const double& t, const auto& q, const auto& p, auto& dq, auto& dp) const;
///       double k;
///     };
///
/// q, p, dq and dp are columns of length Dof. For a small t compute the increments themselves (1 - cos as 2
/// sin² of the half) and not the difference of two states, which has the rounding error of a state. The order
/// of the group does not matter in exactly<...>(). A flow with much to compute from t alone may also have
/// `prepared(t)`, whose result has `increments(q, p, dq, dp)` and can be default-constructed; it is made once
/// for each time of a step (RotatingFlow). `rest_is_small` (true where it is not said) is whether the group
/// dominates what it is used with: the splitting is a list of generalised order then, else an ordinary scheme
/// (see stepper_for). `quadratic_in_momenta` (false where it is not said) is whether the Hamiltonian of the
/// group is: then a rest that depends on positions alone may have a Nyström list (see NearIntegrable).
///
/// Flows of this library: Kinetic + Attraction, Kinetic + RotatingFrame, Kinetic + Attraction + RotatingFrame
/// (orbits); Kinetic + Attraction (nbody).
template <class... Effects>
struct ExactFlow;

namespace detail {

template <class Flow>
concept IsComplete = requires {
  sizeof(Flow);
};

/// What exactly<...>() gives: a group of effects.
template <class... Group>
struct Exactly {};

/// Tries the orders of a group: Type is ExactFlow of the first one that has a flow, made of the effects in
/// that order.
template <class Chosen, class Left, class Skipped = Exactly<>>
struct FlowInAnyOrder {
  using Type = void;
};
template <class... Chosen>
requires IsComplete<ExactFlow<Chosen...>>
struct FlowInAnyOrder<Exactly<Chosen...>, Exactly<>, Exactly<>> {
  using Type = ExactFlow<Chosen...>;
  using Order = Exactly<Chosen...>;
};
template <class... Chosen, class First, class... Left, class... Skipped>
struct FlowInAnyOrder<Exactly<Chosen...>, Exactly<First, Left...>, Exactly<Skipped...>>
    : std::conditional_t<!std::is_void_v<typename FlowInAnyOrder<Exactly<Chosen..., First>,
                                                                 Exactly<Skipped..., Left...>>::Type>,
                         FlowInAnyOrder<Exactly<Chosen..., First>, Exactly<Skipped..., Left...>>,
                         FlowInAnyOrder<Exactly<Chosen...>, Exactly<Left...>, Exactly<Skipped..., First>>> {};

template <class... Group>
using FlowOf = FlowInAnyOrder<Exactly<>, Exactly<Group...>>;

/// How many of the effects are E.
template <class E, class... Effects>
inline constexpr std::size_t count_of = (std::size_t(std::same_as<E, Effects>) + ... + 0);

/// The members of a flow.
template <class Flow, class Scalar, int Dof>
concept HasIncrements = requires(const Flow& flow, const Scalar& t, const Vector<Scalar, Dof>& x,
                                 Vector<Scalar, Dof>& dx) {
  { flow.increments(t, x, x, dx, dx) } -> std::same_as<Status>;
};

/// Whether a flag of a flow is a function, which would be taken for true, or for absent.
template <class Flow>
concept HasFunctionForFlag = requires {
  requires points_to_function<decltype(&Flow::rest_is_small)>;
}
|| requires { requires points_to_function<decltype(&Flow::quadratic_in_momenta)>; };

template <class Flow>
constexpr bool rest_is_small() {
  static_assert(!HasFunctionForFlag<Flow>,
                "rest_is_small or quadratic_in_momenta of this ExactFlow is a function: write `static "
                "constexpr bool rest_is_small = false;`");
  if constexpr (requires { Flow::rest_is_small; })
    return Flow::rest_is_small;
  else
    return true;
}
template <class Flow>
constexpr bool quadratic_in_momenta() {
  if constexpr (requires { Flow::quadratic_in_momenta; })
    return Flow::quadratic_in_momenta;
  else
    return false;
}

}  // namespace detail

/// Names the effects of a scene that are to be moved by their exact flow, as one group: see ExactFlow and
/// stepper_for.
template <class... Group>
constexpr detail::Exactly<Group...> exactly() {
  return {};
}

}  // namespace semiexplicit
