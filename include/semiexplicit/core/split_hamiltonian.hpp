#pragma once

#include <concepts>
#include <string>
#include <type_traits>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

/// A Hamiltonian A + V(q) + T(p) + C(q, p) whose part A has an exact flow, with each of the other parts or
/// without it. Beside what any Hamiltonian has:
///
///     Status flow(t, q, p, dq, dp) const;              // the motion under A in the time t; see ExactFlow
///     std::string flow_name() const;                   // for words
///     auto prepared(t) const;                          // optional: for one t, with increments(q, p, dq, dp)
///     void rest_position_gradient(q, dHdq) const;      // ∂V/∂q, if there is a V
///     void rest_momentum_gradient(p, dHdp) const;      // ∂T/∂p, if there is a T
///     const C& coupled_rest() const;                   // a Hamiltonian, if there is a C
///     static constexpr bool flow_is_quadratic = true;  // optional: A is, in p; for Nyström lists
///
/// stepper_for(scene, exactly<...>()) makes one of a scene.
template <class H>
concept SplitHamiltonian = Hamiltonian<H> &&
    requires(const H& h, const typename H::Scalar& t, const Vector<typename H::Scalar, H::Dof>& x,
             Vector<typename H::Scalar, H::Dof>& dx) {
  { h.flow(t, x, x, dx, dx) } -> std::same_as<Status>;
  { h.flow_name() } -> std::convertible_to<std::string>;
};

namespace detail {

template <class H>
concept HasPositionRest = requires(const H& h, const InColumn<H>& q, OutColumn<H>& dHdq) {
  h.rest_position_gradient(q, dHdq);
};
template <class H>
concept HasMomentumRest = requires(const H& h, const InColumn<H>& p, OutColumn<H>& dHdp) {
  h.rest_momentum_gradient(p, dHdp);
};
template <class H>
concept HasCoupledRest = requires(const H& h) {
  requires std::is_lvalue_reference_v<decltype(h.coupled_rest())>;
  requires Hamiltonian<std::remove_cvref_t<decltype(h.coupled_rest())>>;
};
template <class H>
concept HasPreparedFlow = requires(const H& h, const typename H::Scalar& t) {
  h.prepared(t);
};

}  // namespace detail

}  // namespace semiexplicit
