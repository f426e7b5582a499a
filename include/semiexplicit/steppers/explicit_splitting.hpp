#pragma once

#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/detail/sweep.hpp>

namespace semiexplicit {

/// The classical explicit splitting of a separable H = V(q) + T(p): drifts q += a·dt ∂T/∂p and kicks p -=
/// b·dt ∂V/∂q with the two lists of a scheme, starting and ending with a drift. Symplectic and symmetric in
/// the phase space itself, so there is nothing to double and nothing to solve.
///
/// A scheme with s entries in b takes s gradients of V and s + 1 of T. The doubled method takes 2s + 1 of
/// both an evaluation, which is twice the halves and more than twice the forces.
///
/// The order is that of the bare map, Scheme::explicit_order. A scheme that reaches its order only with the
/// projection (low_defect6_*, low_defect8_*) is refused.
///
/// Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, II.5 and V.3. Memory: five vectors of
/// length 2d.
template <class H>
class ExplicitSplitting {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  static_assert(SeparableHamiltonian<H>,
                "ExplicitSplitting needs a separable Hamiltonian: `using SeparableGradientOf = H;`, `static "
                "constexpr bool separable = true;`, position_gradient and momentum_gradient");
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "ExplicitSplitting";

  /// Throws std::invalid_argument, saying what is wrong, unless the scheme passes its own check and has its
  /// order without the projection, too.
  ExplicitSplitting(H hamiltonian, Scheme<Scalar> scheme)
      : hamiltonian_(std::move(hamiltonian)),
        scheme_(std::move(scheme)),
        at_(State(dof()).vector()),
        moved_(at_),
        half_(State(dof()).q()),
        update_(dof()) {
    scheme_.check();
    if (scheme_.explicit_order < scheme_.order)
      throw std::invalid_argument(
          detail::scheme_called(scheme_.name) + "has order " + std::to_string(scheme_.order) +
          " with the projection only, and order " + std::to_string(scheme_.explicit_order) +
          " in ExplicitSplitting; take another one (blanes_moan6, say), or set its order to " +
          std::to_string(scheme_.explicit_order) + " if that is meant");
  }

  /// One step of size dt, which may be negative; z is untouched unless the report is ok(). No heap use.
  /// `gradients` counts whole gradients, as for the other steppers: the 2s + 1 halves make s + 1, rounded up.
  StepReport step(State& z, const Scalar& dt) {
    const auto everywhere = [this](bool here) { return on_all_ranks<Scalar>(hamiltonian_, here); };
    StepReport report{.status = detail::status_at_start(dt, !scheme_.b.empty(),
                                                        everywhere(z.vector().size() == at_.size()))};
    if (!report.ok()) return report;
    detail::inlined<Scalar>([&] { run(z, dt); });
    report.evaluations = 1;
    report.gradients = position_gradients() + 1;
    if (!update_.update(
            z, [moved = moved_.data()](Eigen::Index i) { return moved[i]; }, everywhere))
      report.status = everywhere(detail::all_finite(z.vector())) ? Status::not_finite : Status::invalid_state;
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const { return position_gradients() + 1; }

  /// Calls of position_gradient and of momentum_gradient in a step.
  std::int64_t position_gradients() const { return static_cast<std::int64_t>(scheme_.b.size()); }
  std::int64_t momentum_gradients() const { return static_cast<std::int64_t>(scheme_.a.size()); }

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<Scalar>& scheme() const { return scheme_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("scheme", scheme());
    list.function("Hamiltonian", GradientSize(hamiltonian()));
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
  }

 private:
  using Vec = typename State::Storage;
  using Column = Vector<Scalar, Dof>;

  /// Few numbers stay on the stack for a step, where the compiler can keep them in registers.
  void run(const State& z, const Scalar& dt) {
    if constexpr (detail::fits_on_stack(Dof)) {
      Vec at = z.vector(), moved = Vec::Zero();
      Column half = Column::Zero();
      drifts_and_kicks(dt, at.data(), moved.data(), half.data());
      moved_ = moved;
    } else {
      at_ = z.vector();
      moved_.setZero();
      drifts_and_kicks(dt, at_.data(), moved_.data(), half_.data());
    }
  }

  // What is moved is summed apart from the state: it has the rounding errors of the increments only.
  void drifts_and_kicks(const Scalar& dt, Scalar* at, Scalar* moved, Scalar* half) const {
    const Eigen::Index d = dof();
    const Eigen::Map<const Column> q(at, d), p(at + d, d);
    Eigen::Map<Column> out(half, d);
    detail::sweep(
        scheme_, dt,
        [&](const Scalar& t) {
          out.setZero();  // for one that adds, or leaves out what is 0
          hamiltonian_.momentum_gradient(p, out);
          add(t, half, at, moved, d);
        },
        [&](const Scalar& t) {
          out.setZero();
          hamiltonian_.position_gradient(q, out);
          add(-t, half, at + d, moved + d, d);
        });
  }

  static void add(const Scalar& t, const Scalar* __restrict half, Scalar* __restrict to,
                  Scalar* __restrict moved, Eigen::Index d) {
    for (Eigen::Index i = 0; i < d; ++i) {
      const Scalar move = t * half[i];
      to[i] += move;
      moved[i] += move;
    }
  }

  H hamiltonian_;
  Scheme<Scalar> scheme_;
  Vec at_, moved_;
  Column half_;
  CompensatedUpdate<Scalar, Dof> update_;
};

}  // namespace semiexplicit
