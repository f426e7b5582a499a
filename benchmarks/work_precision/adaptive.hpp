#pragma once

#include <array>
#include <type_traits>
#include <vector>

#include "own_methods.hpp"

namespace work_precision {

/// State of the rivals from other libraries: an array where the size is known, which is what is fastest with
/// them.
template <int Dof>
using Numbers =
    std::conditional_t<(Dof > 0), std::array<double, std::size_t(Dof == Eigen::Dynamic ? 1 : 2 * Dof)>,
                       std::vector<double>>;

template <int Dof>
Numbers<Dof> start_numbers(const PhasePoint<double, Dof>& z) {
  Numbers<Dof> values{};
  if constexpr (Dof == Eigen::Dynamic) values.resize(static_cast<std::size_t>(z.vector().size()));
  for (Eigen::Index i = 0; i < z.vector().size(); ++i) values[static_cast<std::size_t>(i)] = z.vector()[i];
  return values;
}

/// dz/dt = (∂H/∂p, -∂H/∂q), written straight to where it belongs.
template <class H>
void vector_field(const H& hamiltonian, const double* z, double* dzdt) {
  using Column = Vector<double, H::Dof>;
  const Eigen::Index d = dof_of(hamiltonian);
  hamiltonian.gradient(Eigen::Map<const Column>(z, d), Eigen::Map<const Column>(z + d, d),
                       Eigen::Map<Column>(dzdt + d, d), Eigen::Map<Column>(dzdt, d));
  for (Eigen::Index i = d; i < 2 * d; ++i) dzdt[i] = -dzdt[i];
}

/// The loop of all adaptive methods. try_step(t, dt) tries a step from t, sets t and the next dt, says
/// whether the step was taken, and counts its `gradients`.
template <class TryStep>
Outcome run_adaptively(double end, double first_dt, Watch* watch, const double* z, std::size_t size,
                       const std::int64_t& gradients, const TryStep& try_step) {
  Outcome outcome;
  double t = 0, dt = first_dt;
  int refused = 0;
  const double begin = cpu_seconds();
  while (end - t > 1e-12 * end) {
    if (watch != nullptr && watch->is_late(gradients)) {
      outcome.status = "too slow";
      break;
    }
    if (dt > end - t) dt = end - t;
    if (try_step(t, dt)) {
      refused = 0;
      ++outcome.steps;
    } else if (++refused > 100) {
      outcome.status = "no step is accepted";
      break;
    }
    if (!(dt > 1e-14 * end)) {
      outcome.status = "step too small";
      break;
    }
    if (watch != nullptr && refused == 0 && watch->due(t) && !watch->see(t, z)) {
      outcome.status = "energy lost";
      break;
    }
  }
  outcome.seconds = cpu_seconds() - begin;
  outcome.t = t;
  outcome.gradients = gradients;
  for (std::size_t i = 0; i < size; ++i)
    if (!std::isfinite(z[i])) outcome.status = "not finite";
  return outcome;
}

/// A line over tolerances, which the methods take relative to the size of the state.
inline Line line_of_tolerances(Method method, bool in_short) {
  return {.method = std::move(method),
          .over_steps = false,
          .first = 1e-2,
          .last = 1e-15,
          .factor = std::cbrt(10.0),
          .in_short = in_short};
}

}  // namespace work_precision
