#pragma once

#include <cmath>
#include <utility>

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/steppers/detail/doubled_step.hpp>

namespace semiexplicit {

/// The explicit relative of Semiexplicit: double z, step the copies, take their mean; no iteration, so a step
/// always costs one sweep. Not symplectic but nearly so, with an error of order dt^{2p+2} for a scheme of
/// order p: cheapest at loose targets, drifting in the long run.
template <class H>
class MidpointProjection {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "MidpointProjection";

  /// Throws std::invalid_argument, saying what is wrong, unless the scheme passes its own check.
  MidpointProjection(H hamiltonian, Scheme<Scalar> scheme, Summation summation = Summation::compensated)
      : doubled_(std::move(hamiltonian), std::move(scheme), summation), difference_(State(dof()).vector()) {}

  /// One step of size dt, which may be negative; z is untouched unless the report is ok(). `correction` is a
  /// quarter of the distance between the copies before the mean is taken.
  StepReport step(State& z, const Scalar& dt) {
    StepReport report{.status = doubled_.check(z, dt)};
    if (!report.ok()) return report;
    doubled_.residual(z, nullptr, dt, difference_);
    report.evaluations = 1;
    report.gradients = doubled_.gradients();
    using std::isfinite;
    const Scalar correction = norm_over_ranks(hamiltonian(), difference_) / 4;
    report.correction = static_cast<double>(correction);
    if (!isfinite(correction) || !doubled_.finish(z)) report.status = doubled_.diagnose(z);
    return report;
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return doubled_.hamiltonian(); }
  const Scheme<Scalar>& scheme() const { return doubled_.scheme(); }
  Summation summation() const { return doubled_.summation(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    doubled_.describe(list);
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    doubled_.visit_memory(visit);
  }

 private:
  detail::DoubledStep<H> doubled_;
  typename State::Storage difference_;
};

}  // namespace semiexplicit
