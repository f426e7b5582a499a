#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/reference_size.hpp>
#include <semiexplicit/derivatives/check_gradient.hpp>

namespace semiexplicit::detail {

/// What a few directions at z say about the gradient there.
template <class Scalar>
struct GradientGlance {
  std::string complaint{};   ///< what is wrong, or nothing
  Scalar noise = Scalar(0);  ///< of the energy
  int gradients = 3;         ///< calls that it took
};

/// Compares the gradient with the energy along six fixed directions that change every entry: some 300
/// energies, whatever the dimension, and more where they say little. A difference counts where neither noise
/// nor the last half of the digits explains it. Three directions change every entry by its own size, three
/// also those by more that may be zero up to rounding.
template <HasEnergy H>
SEMIEXPLICIT_COLD GradientGlance<typename H::Scalar> glance_at_gradient(
    const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  using std::sqrt;
  GradientGlance<Scalar> result;
  const Scalar energy = hamiltonian.energy(z.q(), z.p());
  if (!isfinite(energy)) return result;
  PhasePoint<Scalar, H::Dof> gradient(z.dof()), direction = z, at = z;
  const auto outputs = written_gradient(hamiltonian, z, gradient);
  bool wrong = std::any_of(outputs.begin(), outputs.end(),
                           [](GradientOutput output) { return output != GradientOutput::written; });
  const Scalar rounding = energy_rounding(hamiltonian, energy, z);
  const auto sizes = sizes_of_halves(z);
  std::uint64_t random = 1;
  for (int k = 0; k < 6 && !wrong; ++k) {
    Scalar slope(0), terms(0);
    for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
      const Scalar typical = sizes[i < z.dof() ? 0 : 1].typical;
      const Scalar x = abs(z.vector()[i]), least = k < 3 ? Scalar(0) : Scalar(typical / 1000);
      const Scalar own = x == Scalar(0) ? typical : std::max(x, least);
      direction.vector()[i] = Scalar(scattered(random)) * own;
      const Scalar term = gradient.vector()[i] * direction.vector()[i];
      slope += term, terms += abs(term);
    }
    const auto along = [&](const Scalar& s) -> Scalar {
      at.vector() = z.vector() + s * direction.vector();
      return hamiltonian.energy(at.q(), at.p());
    };
    const Scalar slack = sqrt(Eigen::NumTraits<Scalar>::epsilon()) * terms;
    const auto expected =
        judging_slope<Scalar>(along, Scalar(0), slope, Scalar(1), Scalar(1), rounding, slack);
    // Below the steps that resolve the energy: an oscillation is no noise.
    if (k == 0) {
      result.noise = noise_near<Scalar>(along, Scalar(0), expected.steps_from);
      // A late time says nothing about how fast H changes with it.
      if constexpr (InExtendedPhaseSpace<H>)
        result.noise =
            std::min(result.noise, noise_near<Scalar>(along, Scalar(0), Scalar(expected.steps_from / 1024)));
    }
    wrong = !isfinite(slope) || (expected.judges && !expected.admits(slope, slack));
  }
  if (!wrong) return result;
  result.complaint = "a slope of the energy is not the one that the gradient gives";
  if (z.dof() <= 200) {  // else the comparison of all entries would take long
    const auto check = check_gradient(hamiltonian, z);
    result.gradients += 3;
    if (check.ok())
      result.complaint.clear();  // a direction sees less: one entry's coarse rounding beside the others
    for (std::size_t i = check.entries.size(); i-- > 0;)
      if (check.entries[i].wrong) result.complaint = entry_in_words(check, i);
  }
  return result;
}

/// Throws std::invalid_argument, in the name of `who`, where the gradient at z or near it is not the
/// energy's. `velocity` is the vector field at z: an Euler step of a twentieth of `time_scale` leaves a state
/// at rest, where wrong signs hide. Returns the noise of the energy; adds the gradient calls to `gradients`.
template <HasEnergy H>
SEMIEXPLICIT_COLD typename H::Scalar require_right_gradient(
    const std::string& who, const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
    const PhasePoint<typename H::Scalar, H::Dof>& velocity, double time_scale, double& gradients) {
  using Scalar = typename H::Scalar;
  const auto judge = [&](const GradientGlance<Scalar>& seen, const std::string& where) {
    gradients += seen.gradients;
    if (!seen.complaint.empty())
      throw std::invalid_argument(who + ": the gradient is not that of the energy" + where + ": " +
                                  seen.complaint + "; correct it, check_gradient(H, z) compares every entry");
  };
  const auto here = glance_at_gradient(hamiltonian, z);
  judge(here, " at z0");
  auto moved = z;
  std::uint64_t random = 2;
  for (Eigen::Index i = 0; i < z.vector().size(); ++i)
    moved.vector()[i] = z.vector()[i] * Scalar(1 + 0.05 * scattered(random)) +
                        Scalar(0.05 * time_scale) * velocity.vector()[i];
  GradientGlance<Scalar> there = here;
  try {
    there = glance_at_gradient(hamiltonian, moved);
  } catch (...) {  // outside of the domain, where the orbit need not come
    gradients += 3;
    return here.noise;
  }
  judge(there, " near z0");
  return std::min(here.noise, there.noise);  // one of them may sit on a kink
}

}  // namespace semiexplicit::detail
