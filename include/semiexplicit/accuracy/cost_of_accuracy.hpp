#pragma once

#include <cmath>
#include <concepts>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/accuracy/search.hpp>
#include <semiexplicit/integrate.hpp>

namespace semiexplicit {

/// Integrates z over the time T with a setting: in the fewest equal steps that are no longer than setting.dt,
/// or by ReversibleSteps.
/// Observers, report and failures as integrate() has them. The stepper works on a Hamiltonian whose type is
/// hidden, which saves a compiler much, and takes a small system some time: a program that is all about speed
/// makes its own from the setting. Throws std::invalid_argument unless T and setting.dt are finite and
/// positive, for an unknown scheme, a number of stages outside 1 to 8, a method that H cannot have, and
/// events that change the state beside steps that follow the motion.
///
///     const CostRow advice = cost.cheapest(1e-8).value();
///     Invariants invariants(H);
///     run(H, z, T, advice.setting, invariants);
template <Hamiltonian H, class... Observers>
IntegrationReport run(const H& hamiltonian, PhasePoint<typename H::Scalar, H::Dof>& z, double T,
                      const Setting& setting, Observers&&... observers) {
  if (!(T > 0 && std::isfinite(T)))
    throw std::invalid_argument("run: T is not a finite positive time; give how long to integrate");
  if (!(setting.dt > 0 && std::isfinite(setting.dt)))
    throw std::invalid_argument("run: setting.dt is not a finite positive step; set it");
  using Scalar = typename H::Scalar;
  const detail::Erased<H> erased(hamiltonian);
  detail::AnyStepperOf<Scalar, H::Dof> stepper(erased.stepper(setting), dof_of(hamiltonian));
  IntegrationOptions<Scalar> options{.dt = Scalar(setting.dt), .t_end = Scalar(T)};
  if (!setting.reversible) {  // by the steps that its trials took, though setting.dt may be no Scalar
    using Time = std::common_type_t<double, Scalar>;
    const double end = static_cast<double>(*options.t_end);
    options.dt = Scalar(Time(*options.t_end) / Time(detail::steps_between(0.0, end, setting.dt)));
    return integrate(stepper, z, options, std::forward<Observers>(observers)...);
  }
  if constexpr ((false || ... || ChangesState<Observers>)) {
    throw std::invalid_argument(
        "run: events that change the state need equal steps, and setting.reversible asks for others; "
        "ask with .reversible = false");
  } else {
    ReversibleSteps following(std::move(stepper), detail::pace_of(hamiltonian, setting));
    return integrate(following, z, options, std::forward<Observers>(observers)...);
  }
}

/// A CostTable with the Hamiltonian that it is about.
template <class H>
class CostOfAccuracy : public CostTable {
 public:
  CostOfAccuracy(CostTable table, H hamiltonian)
      : CostTable(std::move(table)), hamiltonian_(std::move(hamiltonian)) {}

  /// Integrates z over the time T that was asked about, as a row says; see semiexplicit::run().
  template <class... Observers>
  IntegrationReport run(PhasePoint<typename H::Scalar, H::Dof>& z, const CostRow& row,
                        Observers&&... observers) const {
    return semiexplicit::run(hamiltonian_, z, time, row.setting, std::forward<Observers>(observers)...);
  }

 private:
  H hamiltonian_;
};

namespace detail {

/// The options with an observable of states of another size, of what is H's own in them.
template <class H, class Scalar, int Dof, int OtherDof>
SEMIEXPLICIT_COLD CostOptionsOf<Scalar, Dof> options_for(const CostOptionsOf<Scalar, OtherDof>& options) {
  CostOptionsOf<Scalar, Dof> result{.targets = options.targets,
                                    .absolute = options.absolute,
                                    .budget = options.budget,
                                    .min_gradients = options.min_gradients,
                                    .max_gradients = options.max_gradients,
                                    .whole = options.whole,
                                    .by = options.by,
                                    .schemes = options.schemes,
                                    .gauss_stages = options.gauss_stages,
                                    .splittings = options.splittings,
                                    .reversible = options.reversible};
  if (!options.observable.is_energy())
    result.observable = [f = options.observable](const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) {
      return f(PhasePoint<Scalar, OtherDof>(q, p), own_dof<H>(q.size()));
    };
  return result;
}

}  // namespace detail

/// What accuracy costs for *your* Hamiltonian and what you measure: which scheme or method, which step, how
/// long it takes, for an error of the observable that stays below a target over the time T. Trial runs find
/// out; see CostOptionsOf for how much they may cost.
///
///     const auto first = [](const auto& q, const auto&) { return q[0]; };
///     auto cost = cost_of_accuracy(H, z0, 1000, {.observable = first});
///     std::cout << cost;                              // the table, and what it rests on
///     if (const auto advice = cost.cheapest(1e-8)) cost.run(z, *advice);
///
/// Without an observable it is the energy. The error is the largest over [0, T], relative to the size of the
/// observable (CostTable says which), or absolute by request.
///
/// It is a race. Every setting is tried from z0 over a short stretch, the best ones over one eight times as
/// long, and so on, to T where the gradient calls suffice: what is advised then was run as a whole, and has
/// met the target. Else its error is extrapolated: by the power of the time that it was seen to grow with, or
/// not at all for the energy of a symplectic method where it does not grow, and by how much finer steps must
/// be where a coarse run, which goes ahead, found the motion harder (CostRow::tried, CostRow::harder). An
/// invariant, the energy or whatever a tight run finds constant, is compared with its first value; anything
/// else with two runs of Gauss-Legendre that are as good as rounding allows; behind the trials its errors
/// grow as those of steps of two lengths, or as a neighbouring orbit goes off. A target that no run can meet,
/// because neighbouring orbits part exponentially, is refused with the rate, and one below the rounding that
/// adds up with the reason. What lies beyond the trials of a long run, and no coarse run shows, goes unseen:
/// close encounters in chaos, slow instabilities, resonances of the step with the motion, and that an
/// observable which was constant until there is none behind: it has no error then. Raise min_gradients and
/// max_gradients there until `tried` is T. An observable other than an invariant is compared at some 80 times
/// along what was tried, and where that is much of T up to four times in a step of the coarse run, or some
/// 500 times. Where steps of the tight runs are longer than 1/640 of it also between these, wherever a line
/// does not do: a flash between two of these places goes unseen, too.
///
/// H needs an energy(q, p), which the gradient is compared with first. That of a TimeTransformed is K, near
/// zero: for the energy of its H give that as the observable. z0 is not changed. Throws
/// std::invalid_argument, naming the quantity and the remedy, unless T is finite and positive, z0 finite and
/// of the size of H and not at rest, the targets positive, the observable finite at z0, and something is left
/// to try. An exception of the gradient or the observable passes through, but for a std::domain_error of the
/// gradient or the energy, which says that a trial has left their domain and fails.
template <class H>
auto cost_of_accuracy(
    const H& hamiltonian,
    const PhasePoint<typename detail::EnergyDoor<H>::Scalar, detail::EnergyDoor<H>::Dof>& z0, double T,
    const CostOptionsOf<typename detail::EnergyDoor<H>::Scalar, detail::EnergyDoor<H>::Dof>& options = {}) {
  if constexpr (HasEnergy<H>) {
    detail::check(options);
    T = static_cast<double>(typename H::Scalar(T));  // as far as runs go
    if (!(T > 0 && std::isfinite(T)))
      throw std::invalid_argument(
          "cost_of_accuracy: T is not a finite positive time as a number of H's; give the length of the run");
    if (z0.dof() != dof_of(hamiltonian))
      throw std::invalid_argument("cost_of_accuracy: z0 has " + std::to_string(z0.dof()) +
                                  " degrees of freedom and the Hamiltonian " +
                                  std::to_string(dof_of(hamiltonian)) + "; give both the same size");
    if (!detail::all_finite(z0.vector()))
      throw std::invalid_argument("cost_of_accuracy: z0 holds NaN or Inf; give a finite initial state");
    detail::require_symplectic(hamiltonian, "cost_of_accuracy",
                               "its energy changes by their work: give runs with_error_estimate() instead");
    using Any = detail::Erased<H>;
    const double start = detail::cpu_seconds();
    PhasePoint<typename H::Scalar, Eigen::Dynamic> at(z0.dof());
    at.vector() = z0.vector();
    detail::Problem<Any> problem(Any(hamiltonian).for_trials(), at, T,
                                 detail::options_for<H, typename H::Scalar, Eigen::Dynamic>(options));
    detail::Search<Any>(problem).run();
    problem.table.spent_seconds = detail::cpu_seconds() - start;
    if constexpr (requires { advised_flow(hamiltonian, z0); })  // a Scene
      problem.table.exact_flow = advised_flow(hamiltonian, z0).value_or("");
    return CostOfAccuracy<H>(std::move(problem.table), hamiltonian);
  }
}

/// The same with options from a variable, whose observable takes columns of dynamic size.
template <class H, std::same_as<CostOptions> Options>
requires(H::Dof != Eigen::Dynamic) auto cost_of_accuracy(const H& hamiltonian,
                                                         const PhasePoint<double, H::Dof>& z0, double T,
                                                         const Options& options) {
  return cost_of_accuracy(hamiltonian, z0, T, detail::options_for<H, double, H::Dof>(options));
}

}  // namespace semiexplicit
