#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/time/pace.hpp>

namespace semiexplicit {

/// Poincaré's transformation of time: steps of equal size in a parameter s with dt = g ds, so small where g
/// is small and symplectic still, which steps that are chosen as one goes are not. It is a Hamiltonian in the
/// extended phase space, of one degree of freedom more, whose coordinates are (q, t) and (p, p_t):
///
///     K = g(q, p) (H(q, p) + p_t - energy)
///
/// On K = 0, where extended() starts, its orbits are those of H, and the physical time is carried by the
/// integrator itself, to its order. K is not separable even where H is. p_t stays what it is.
///
///     TimeTransformed K(H, monitors::Distance{}, H.energy(z.q(), z.p()));       // monitors.hpp
///     Semiexplicit stepper(K, schemes::low_defect8_s20());
///     auto Z = K.extended(z, 0.0);
///     integrate(stepper, Z, {.dt = ds, .steps = n}, at_times(K, times, observer));  // physical times
///     z = K.point(Z);  K.time(Z);
///
/// Of a driven system H is an Autonomous that follows its work: its time and p_t serve, none is added, and g
/// is one of its own (q, p). p_t then changes as there.
///
/// H needs its energy. `energy` is its value on the orbit; extended() takes up what it is off by. A step
/// within which g is not positive fails (Status::not_finite). Where g only comes near to 0, K = 0 says little
/// of H: choose one that does not.
/// A gradient of K is one gradient and one energy of H, and g. One of dynamic size works in memory of its
/// own: threads need a copy each, as every stepper has.
///
/// Source: E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., section VIII.2.1;
/// carrying the time as a coordinate: S. Mikkola, Celest. Mech. Dyn. Astron. 67 (1997) 145.
template <class H, class G>
class TimeTransformed
    : public ExtendedPhaseSpace<typename detail::EnergyDoor<H>::Scalar, detail::own_dof_of<H>> {
  static_assert(detail::is_monitor_with_gradient<G, typename H::Scalar, detail::own_dof_of<H>>());
  static constexpr bool driven = InExtendedPhaseSpace<H>;
  static constexpr int own = detail::own_dof_of<H>;

 public:
  using Scalar = typename H::Scalar;
  using Space = ExtendedPhaseSpace<Scalar, own>;
  using typename Space::Point;
  using typename Space::State;
  static constexpr int Dof = Space::Dof;
  static constexpr bool steps_in_time = false;
  static_assert(detail::is_in_one_process<H>());

  TimeTransformed(H hamiltonian, G monitor, Scalar energy)
      : hamiltonian_(std::move(hamiltonian)),
        monitor_(std::move(monitor)),
        energy_(energy),
        dg_(detail::own_dof<H>(dof_of(hamiltonian_))) {
    detail::require_symplectic(hamiltonian_, "TimeTransformed",
                               "its energy changes, on which K = g(H - E) rests; take ReversibleSteps");
  }

  Eigen::Index dof() const { return dof_of(hamiltonian_) + (driven ? 0 : 1); }

  /// The extended point of z at the time t, on K = 0. Throws std::invalid_argument where z has another size
  /// than H, or H, g or its gradient is not finite at z, or not written, or g not positive.
  State extended(const Point& z, const Scalar& t) const {
    using std::isfinite;
    if (z.dof() != dof() - 1)
      throw std::invalid_argument("TimeTransformed: the state has another size than the Hamiltonian");
    State extended = Space::join(z, t, Scalar(0));
    const Scalar energy = energy_of_system(extended.q(), extended.p());
    auto&& dg = work();
    dg.q().setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    if constexpr (PhaseMonitor<G, Scalar, own>) dg.p().setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    const Scalar g = pace(z.q(), z.p(), dg);
    if (!detail::all_finite(dg.vector()))
      throw std::invalid_argument(
          "TimeTransformed: the monitor function leaves entries of its gradient unwritten, or not finite; "
          "write all of dgdq, and of g(q, p, dgdq, dgdp) all of dgdp");
    if (!isfinite(energy) || !isfinite(g))
      throw std::invalid_argument(
          "TimeTransformed: the energy or the monitor function is not finite here, or the monitor function "
          "not positive; check the initial data");
    extended.p()[dof() - 1] = energy_ - energy;
    return extended;
  }

  /// Behind a change of (q, p), as by an action of events(), which calls it: p_t takes up what H has changed
  /// by, so that K is as near to 0 as it was. Where p_t was changed, too, it stays.
  void follow_change(const State& before, State& after) const {
    const Eigen::Index d = dof() - 1;
    if (after.p()[d] != before.p()[d]) return;
    after.p()[d] += energy_of_system(before.q(), before.p()) - energy_of_system(after.q(), after.p());
  }

  /// K, which stays near 0.
  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    auto&& dg = work();
    return pace(Space::head(q), Space::head(p), dg) * surplus(q, p);
  }

  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dKdq,
                Out<Scalar, Dof> dKdp) const {
    const Eigen::Index d = dof() - 1;
    if constexpr (driven)
      hamiltonian_.gradient(q, p, dKdq, dKdp);
    else
      detail::gradient_at(hamiltonian_, q.data(), p.data(), dKdq.data(), dKdp.data(), d);
    auto&& dg = work();
    const Scalar g = pace(Space::head(q), Space::head(p), dg), above = surplus(q, p);
    for (Eigen::Index i = 0; i < d; ++i) dKdq[i] = g * dKdq[i] + above * dg.vector()[i];
    for (Eigen::Index i = 0; i < d; ++i) dKdp[i] = g * dKdp[i] + above * dg.vector()[d + i];
    dKdq[d] = driven ? Scalar(g * dKdq[d]) : Scalar(0);
    dKdp[d] = driven ? Scalar(g * dKdp[d]) : g;
  }

  const H& hamiltonian() const { return hamiltonian_; }

 private:
  /// H + p_t - energy.
  Scalar surplus(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    return (energy_of_system(q, p) - energy_) + (driven ? Scalar(0) : p[dof() - 1]);
  }
  /// H, which in a driven system has p_t in it.
  Scalar energy_of_system(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    if constexpr (driven)
      return hamiltonian_.energy(q, p);
    else
      return hamiltonian_.energy(Space::head(q), Space::head(p));
  }

  /// Where ∂g/∂q, ∂g/∂p come to lie; the latter stays zero for a g of q alone.
  decltype(auto) work() const {
    if constexpr (Dof == Eigen::Dynamic) {
      if (dg_.dof() != dof() - 1) dg_ = Point(dof() - 1);  // it was moved from
      return (dg_);
    } else {
      return Point{};
    }
  }

  /// g, and its gradient to dg. NaN where g is not positive, so that a step fails there: it would go back in
  /// time, or along another orbit, as K = 0 says nothing of H where g = 0.
  template <class Q, class P>
  Scalar pace(const Q& q, const P& p, Point& dg) const {
    auto dgdq = dg.q(), dgdp = dg.p();  // a monitor may take them by reference
    const Scalar g = [&] {
      if constexpr (PhaseMonitor<G, Scalar, own>)
        return detail::monitor_value<Scalar>(monitor_(q, p, dgdq, dgdp));
      else
        return detail::monitor_value<Scalar>(monitor_(q, dgdq));
    }();
    return g > Scalar(0) ? g : std::numeric_limits<Scalar>::quiet_NaN();
  }

  H hamiltonian_;
  G monitor_;
  Scalar energy_;
  mutable Point dg_;  // of dynamic size only, where a gradient must not use the heap
};

template <HasEnergy H, class G, class Energy>
TimeTransformed(H, G, Energy) -> TimeTransformed<H, G>;

}  // namespace semiexplicit
