#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <semiexplicit/accuracy/any_hamiltonian.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// A stretch of the run that settings are tried on.
template <class State>
struct Window {
  State start;
  double length;  ///< in time
  bool typical;   ///< chosen without regard to how hard it is, so that its cost counts for the whole run
};

/// What a setting did on some windows.
struct Probe {
  Status status = Status::success;
  double range =
      0;            ///< largest H - smallest H within a window, the largest of all windows, relative to H(z0)
  double rate = 0;  ///< gradient calls a unit of time, in typical windows
  double evaluations = 0;      ///< a step, likewise
  double max_evaluations = 0;  ///< of a step, in any window
  double drift = 0;            ///< relative error a unit of time that unfinished solves may add up to
  double spread = 1;           ///< how much the ranges differ among the hard windows, as a factor
  bool confirmed = false;      ///< on more windows than the others
  std::int64_t gradients = 0;  ///< that the probe took
  bool cut = false;            ///< the calls ended before the windows
  bool works() const { return status == Status::success && !cut; }
};

/// Follows the energy along steps.
template <class Scalar, int Dof>
class EnergyRange {
 public:
  EnergyRange(const AnyHamiltonian<Scalar, Dof>& hamiltonian, const Scalar& unit)
      : hamiltonian_(hamiltonian), unit_(unit) {}

  void start(const PhasePoint<Scalar, Dof>& z) { low_ = high_ = hamiltonian_.energy(z.q(), z.p()); }
  /// NaN makes the range NaN for good.
  void add(const PhasePoint<Scalar, Dof>& z) {
    const Scalar now = hamiltonian_.energy(z.q(), z.p());
    if (!(now >= low_) && low_ == low_) low_ = now;
    if (!(now <= high_) && high_ == high_) high_ = now;
  }
  double range() const { return static_cast<double>((high_ - low_) / unit_); }

 private:
  const AnyHamiltonian<Scalar, Dof>& hamiltonian_;
  Scalar unit_, low_{}, high_{};
};

/// What a step's unfinished solve may add to the error of the invariants, e (‖m‖ + e)/‖z‖²: see StoppingRule::product.
template <class State>
double unfinished(const StepReport& report, const State& z) {
  const double e = report.correction, size = static_cast<double>(norm(z.vector()));
  const double m = report.evaluations > 1 && report.rate > 0 ? e / report.rate : 0;
  return size > 0 ? (e / size) * ((m + e) / size) : 0;
}

/// Tries a setting on windows. Gives up at the first step that fails, or when the error exceeds `hopeless`, and before the first
/// one that may take it beyond `affordable` gradient calls.
template <class Scalar, int Dof>
SEMIEXPLICIT_COLD Probe probe(const AnyHamiltonian<Scalar, Dof>& hamiltonian, const Setting& setting,
                              const std::vector<Window<PhasePoint<Scalar, Dof>>>& windows,
                              const Scalar& energy_unit, double hopeless, double affordable) {
  Probe result;
  AnyStepper<Scalar, Dof> stepper = hamiltonian.stepper(setting);
  EnergyRange<Scalar, Dof> energies(hamiltonian, energy_unit);
  const double worst = static_cast<double>(stepper.max_gradients());
  double time = 0, steps_counted = 0;
  std::int64_t calls = 0, evaluations = 0;
  std::vector<double> hard;
  for (const auto& window : windows) {
    auto z = window.start;
    energies.start(z);
    // Gauss's first step has nothing to extrapolate from: it is not counted.
    const auto steps = std::max<std::int64_t>(4, static_cast<std::int64_t>(window.length / setting.dt) + 1);
    double drift = 0;
    for (std::int64_t n = 0; n < steps; ++n) {
      if (static_cast<double>(result.gradients) + worst > affordable) {
        result.cut = true;
        return result;
      }
      const StepReport report = stepper.step(z, Scalar(setting.dt));
      result.gradients += report.gradients;
      if (!report.ok()) {
        result.status = report.status;
        return result;
      }
      energies.add(z);
      result.max_evaluations = std::max(result.max_evaluations, static_cast<double>(report.evaluations));
      if (setting.method == Setting::Method::semiexplicit) drift += unfinished(report, z);
      if (n > 0 && window.typical) {
        calls += report.gradients;
        evaluations += report.evaluations;
        time += setting.dt;
        ++steps_counted;
      }
    }
    result.drift = std::max(result.drift, drift / (static_cast<double>(steps) * setting.dt));
    if (!window.typical) hard.push_back(energies.range());
    if (!(energies.range() <= result.range)) result.range = energies.range();
    if (!(result.range <= hopeless)) {
      result.status = Status::not_finite;
      return result;
    }
  }
  if (!hard.empty()) {
    std::nth_element(hard.begin(), hard.begin() + static_cast<std::ptrdiff_t>(hard.size() / 2), hard.end());
    const double median = hard[hard.size() / 2];
    if (median > 0) result.spread = std::clamp(std::sqrt(result.range / median), 1.0, 3.0);
  }
  if (time > 0) {
    result.rate = static_cast<double>(calls) / time;
    result.evaluations = static_cast<double>(evaluations) / steps_counted;
  }
  return result;
}

}  // namespace semiexplicit::detail
