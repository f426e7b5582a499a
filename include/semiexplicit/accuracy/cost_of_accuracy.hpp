#pragma once

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/accuracy/scan.hpp>

namespace semiexplicit {

/// What accuracy costs for *your* Hamiltonian: which scheme or method, which step, how long it takes, for a relative energy
/// error that stays below a target over the time T. Short trial runs find out; see CostOptions for how much they may cost.
///
///     const CostOfAccuracy cost = cost_of_accuracy(H, z0, 1000);
///     std::cout << cost;                              // the table, and what it rests on
///     if (const auto advice = cost.cheapest(1e-8)) run(H, z, 1000, advice->setting);
///
/// A coarse pilot run finds where along the way the problem is hard. Every setting is tried there, at the start, and on some
/// ordinary stretches; from the largest range of the energy in a stretch follows the error over T, on the assumption that
/// it stays bounded, plus what unfinished solves and rounding may add. How much harder than the pilot run the rest of T
/// gets is extrapolated from the tail of what the pilot met. The choice is then confirmed on more of the run, and revised.
/// Where rare events decide (chaos, close encounters) no short run can know them: expect errors off by more than a
/// factor of three there, and aim lower. Resonances of the step with the motion that need long to build up go unseen.
///
/// H needs an energy(q, p), by whose error everything is judged. z0 is not changed. Throws std::invalid_argument, naming
/// the quantity and the remedy, unless T is finite and positive, z0 finite and of the size of H and not at rest, the targets
/// positive, and something is left to try. An exception of the gradient passes through.
template <class H>
CostOfAccuracy cost_of_accuracy(
    const H& hamiltonian,
    const PhasePoint<typename detail::EnergyDoor<H>::Scalar, detail::EnergyDoor<H>::Dof>& z0, double T,
    const CostOptions& options = {}) {
  if constexpr (HasEnergy<H>) {
    detail::check(options);
    if (!(T > 0 && std::isfinite(T)))
      throw std::invalid_argument(
          "cost_of_accuracy: T is not a finite positive time; give the length of the run");
    if (z0.dof() != dof_of(hamiltonian))
      throw std::invalid_argument("cost_of_accuracy: z0 has " + std::to_string(z0.dof()) +
                                  " degrees of freedom and the Hamiltonian " +
                                  std::to_string(dof_of(hamiltonian)) + "; give both the same size");
    if (!z0.vector().allFinite())
      throw std::invalid_argument("cost_of_accuracy: z0 holds NaN or Inf; give a finite initial state");
    using Any = detail::AnyHamiltonian<typename H::Scalar, H::Dof>;
    return detail::Scan<typename H::Scalar, H::Dof>(Any(hamiltonian), z0, T, options).result();
  }
}

}  // namespace semiexplicit
