#pragma once

#include <utility>

#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/explicit_splitting.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit {

/// The cheapest stepper that is right for H: explicit splitting where H is separable, and two copies with the
/// projection only where something couples q and p. `solver` is for the latter and unused otherwise. Throws
/// std::invalid_argument where the scheme does not suit (see ExplicitSplitting).
template <Hamiltonian H, class Solver = SimplifiedNewton>
auto stepper_for(H hamiltonian, Scheme<typename H::Scalar> scheme, Solver solver = {}) {
  if constexpr (SeparableHamiltonian<H>)
    return ExplicitSplitting<H>(std::move(hamiltonian), std::move(scheme));
  else
    return Semiexplicit<H, Solver>(std::move(hamiltonian), std::move(scheme), std::move(solver));
}

/// The same with the usual scheme.
template <Hamiltonian H>
auto stepper_for(H hamiltonian) {
  return stepper_for(std::move(hamiltonian), usual_scheme<typename H::Scalar>(SeparableHamiltonian<H>));
}

}  // namespace semiexplicit
