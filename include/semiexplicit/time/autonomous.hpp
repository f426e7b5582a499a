#pragma once

#include <concepts>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>

namespace semiexplicit {

namespace detail {

template <class H>
concept NamesTimeDerivative = requires {
  &H::time_derivative;
}
|| requires(H& h, const typename H::Scalar& t, const InColumn<H>& at) { h.time_derivative(t, at, at); };
/// What the gradient returns, of which a reference is as good.
template <class H>
using ReturnedByGradient = std::remove_cvref_t<decltype(std::declval<const H&>().gradient(
    std::declval<const typename H::Scalar&>(), std::declval<const InColumn<H>&>(),
    std::declval<const InColumn<H>&>(), std::declval<OutColumn<H>&>(), std::declval<OutColumn<H>&>()))>;
/// A number that is no Scalar, whatever else a gradient may return.
template <class H>
constexpr bool gradient_returns_another_number() {
  if constexpr (TimeDependentHamiltonian<H>) {
    using Returned = ReturnedByGradient<H>;
    return std::convertible_to<Returned, typename H::Scalar> && !std::same_as<Returned, typename H::Scalar> &&
           !std::same_as<Returned, bool>;
  } else {
    return false;
  }
}

/// Whether its time_derivative or its energy gives a whole number, or one of fewer digits.
template <class H>
constexpr bool tells_narrow_numbers() {
  using Scalar = typename H::Scalar;
  using At = const InColumn<H>&;
  const auto derivative = [](const auto& h) -> decltype(h.time_derivative(std::declval<const Scalar&>(),
                                                                          std::declval<At>(),
                                                                          std::declval<At>())) {};
  const auto energy = [](const auto& h) -> decltype(h.energy(std::declval<const Scalar&>(),
                                                             std::declval<At>(), std::declval<At>())) {};
  return is_narrower<ResultOf<decltype(derivative), const H&>, Scalar> ||
         is_narrower<ResultOf<decltype(energy), const H&>, Scalar>;
}

}  // namespace detail

/// An H that depends on the time, as an autonomous Hamiltonian in the extended phase space, of one degree of
/// freedom more, whose coordinates are (q, t) and (p, p_t):
///
///     K = H(t, q, p) + p_t
///
/// Then dt/ds = 1, every copy of the doubled system carries a time of its own, and whatever takes a
/// Hamiltonian takes this one, with its order and symplecticity.
///
///     Autonomous K(H);
///     Semiexplicit stepper(K, schemes::low_defect6_s13());
///     auto Z = K.extended(z, t0);
///     integrate(stepper, Z, {.dt = dt, .steps = n, .t0 = t0}, observer);   // observer(t, Z)
///     z = K.point(Z);  K.time(Z);
///
/// p_t changes by -∂H/∂t, so it is minus the energy that the driving has put in, and K stays what it was: the
/// check that the energy is elsewhere. That takes `time_derivative(t, q, p)`, or a gradient() that returns
/// ∂H/∂t, for what they have in common. An H with neither is integrated just as well, since neither q, p nor
/// t depend on p_t; but p_t then stays at 0, and there is no energy() here because it would mean nothing.
/// Whether ∂H/∂t is right check_gradient(K, Z) tells.
///
/// Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., section VIII.2.1 (with
/// g = 1).
template <class H>
class Autonomous : public ExtendedPhaseSpace<typename detail::TimeDependentDoor<H>::Scalar,
                                             detail::TimeDependentDoor<H>::Dof> {
 public:
  using Scalar = typename detail::TimeDependentDoor<H>::Scalar;
  using Space = ExtendedPhaseSpace<Scalar, detail::TimeDependentDoor<H>::Dof>;
  using typename Space::Point;
  using typename Space::State;
  static constexpr int Dof = Space::Dof;
  static_assert(detail::is_in_one_process<H>());

  /// Whether the gradient of H returns ∂H/∂t, a Scalar.
  static constexpr bool gradient_follows_work = requires {
    requires std::same_as<detail::ReturnedByGradient<H>, Scalar>;
  };
  /// Or has it by itself.
  static constexpr bool has_time_derivative =
      requires(const H& h, const Scalar& t, const detail::InColumn<H>& q, const detail::InColumn<H>& p) {
    { h.time_derivative(t, q, p) } -> std::convertible_to<Scalar>;
  };
  static_assert(
      !detail::gradient_returns_another_number<H>(),
      "the gradient of this Hamiltonian returns another number than a Scalar: let it return dH/dt as "
      "a Scalar, or nothing");
  static_assert(
      !detail::tells_narrow_numbers<H>(),
      "energy or time_derivative of this Hamiltonian is a whole number, or one of fewer digits than "
      "Scalar: let it return a Scalar");
  static_assert(has_time_derivative || !detail::NamesTimeDerivative<H>,
                "time_derivative of this Hamiltonian cannot be called: write `Scalar time_derivative(const "
                "Scalar& t, In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
  static_assert(
      !(gradient_follows_work && has_time_derivative),
      "this Hamiltonian says dH/dt twice: let its gradient return nothing, or leave time_derivative out");
  /// Whether H says ∂H/∂t, so that p_t is followed, and whether there is K to check the run by.
  static constexpr bool follows_work = gradient_follows_work || has_time_derivative;
  static constexpr bool follows_energy =
      follows_work &&
      requires(const H& h, const Scalar& t, const detail::InColumn<H>& q, const detail::InColumn<H>& p) {
    { h.energy(t, q, p) } -> std::convertible_to<Scalar>;
  };

  explicit Autonomous(H hamiltonian) : hamiltonian_(std::move(hamiltonian)) {}

  Eigen::Index dof() const {
    if constexpr (H::Dof == Eigen::Dynamic)
      return hamiltonian_.dof() + 1;
    else
      return Dof;
  }

  /// The extended point of z at the time t, with p_t = 0, so that K starts as H(t, z). Throws
  /// std::invalid_argument where z has another size than H.
  State extended(const Point& z, const Scalar& t) const {
    detail::require_same_dof("Autonomous", z.dof(), "Hamiltonian", dof() - 1);
    return Space::join(z, t, Scalar(0));
  }

  /// K, which the exact motion keeps.
  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const requires follows_energy {
    const Eigen::Index d = dof() - 1;
    const detail::InColumn<H> own_q(q.data(), d), own_p(p.data(), d);
    return hamiltonian_.energy(q[d], own_q, own_p) + p[d];
  }

  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dKdq,
                Out<Scalar, Dof> dKdp) const {
    const Eigen::Index d = dof() - 1;
    const detail::InColumn<H> own_q(q.data(), d), own_p(p.data(), d);
    detail::OutColumn<H> dHdq(dKdq.data(), d), dHdp(dKdp.data(), d);
    if constexpr (gradient_follows_work) {
      dKdq[d] = hamiltonian_.gradient(q[d], own_q, own_p, dHdq, dHdp);
    } else {
      hamiltonian_.gradient(q[d], own_q, own_p, dHdq, dHdp);
      if constexpr (follows_work)
        dKdq[d] = hamiltonian_.time_derivative(q[d], own_q, own_p);
      else
        dKdq[d] = Scalar(0);
    }
    dKdp[d] = Scalar(1);
  }

  const H& hamiltonian() const { return hamiltonian_; }

 private:
  H hamiltonian_;
};

}  // namespace semiexplicit
