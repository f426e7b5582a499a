#pragma once

#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>

namespace semiexplicit::detail {

/// What the projections share: one step of the doubled system from a common point z, and the move of z to the
/// mean of the copies. Three vectors of length 2d, and three more where they do not fit on the stack.
template <class H>
class DoubledStep {
 public:
  using Scalar = typename HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  using Vec = typename State::Storage;

  DoubledStep(H hamiltonian, Scheme<Scalar> scheme, Summation summation)
      : DoubledStep(std::move(hamiltonian), std::move(scheme), summation, Checked{}) {
    scheme_.check();
  }
  /// The same with another Hamiltonian, and no memory of earlier steps. The scheme is not checked again,
  /// which takes longer than many steps.
  DoubledStep with(H hamiltonian) const { return {std::move(hamiltonian), scheme_, summation_, Checked{}}; }

  /// Whether a step of size dt can start from z: Status::success if so. Costs nothing: a state that is not
  /// finite shows in the result, and diagnose() tells it from a gradient that is not.
  Status check(const State& z, const Scalar& dt) const {
    return status_at_start(dt, !scheme_.b.empty(),
                           on_all_ranks<Scalar>(hamiltonian_, z.vector().size() == moved_.size()));
  }

  /// The status of a step from z that came out NaN or Inf.
  Status diagnose(const State& z) const {
    return on_all_ranks<Scalar>(hamiltonian_, all_finite(z.vector())) ? Status::not_finite
                                                                      : Status::invalid_state;
  }

  /// f becomes the residual of the projection at m, or at m = 0 where it is null.
  void residual(const State& z, const Vec* m, const Scalar& dt, Vec& f) {
    inlined<Scalar>([&] {
      if constexpr (fits_on_stack(Dof)) {
        typename WorkPoint<H>::Type at, by, a, b, gradient{}, moved, difference;
        at.load(z.vector().data());
        if (m) by.load(m->data());
        projection_residual(hamiltonian_, scheme_, dt, summed(), at.data, m ? by.data : nullptr, a.data,
                            b.data, gradient.data, moved.data, difference.data, at.d);
        moved.store(moved_.data());
        difference.store(f.data());
      } else {
        projection_residual(hamiltonian_, scheme_, dt, summed(), z.vector().data(), m ? m->data() : nullptr,
                            a_.data(), b_.data(), gradient_.data(), moved_.data(), f.data(), dof());
      }
    });
    drop_time<H>(z.vector(), f, scheme_.kicks());
  }

  /// How far the mean of the copies moved, in the Euclidean norm.
  Scalar distance() const { return norm_over_ranks(hamiltonian_, moved_) / 2; }

  /// Twice that, entry by entry.
  const Vec& moved() const { return moved_; }

  /// z becomes the mean of the copies; false, and z untouched, where that is not finite.
  bool finish(State& z) {
    if (summation_ == Summation::compensated)
      return update_.update(
          z, [moved = moved_.data()](Eigen::Index i) { return moved[i] / 2; },
          [this](bool ok) { return on_all_ranks<Scalar>(hamiltonian_, ok); });
    if constexpr (fits_on_stack(Dof)) {
      StackPoint<Scalar, Dof> next;
      for_each_index(twice_of(next.d), [&](Eigen::Index i) {
        next.data[i] = apart<std::integral_constant<int, Dof>, Scalar>(z.vector()[i] + moved_[i] / 2);
      });
      if (!on_all_ranks<Scalar>(hamiltonian_, all_finite(next.data, 2 * Dof))) return false;
      next.store(z.vector().data());
      return true;
    }
    moved_ = z.vector() + Scalar(0.5) * moved_;
    if (!on_all_ranks<Scalar>(hamiltonian_, all_finite(moved_))) return false;
    z.vector() = moved_;
    return true;
  }

  /// Gradient calls of an evaluation of the residual.
  std::int64_t gradients() const { return static_cast<std::int64_t>(scheme_.kicks()); }
  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<Scalar>& scheme() const { return scheme_; }
  Summation summation() const { return summation_; }

  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("scheme", scheme_);
    list("summation", summation_);
    list.function("Hamiltonian", GradientSize(hamiltonian_));
  }
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
  }

 private:
  /// In vectors longer than this (bytes) a kick costs what it moves through memory, and keeping the sum up to
  /// date in each would be a third of that. What the copies moved is taken from them at the end then, with
  /// their rounding errors.
  static constexpr std::size_t long_vector = std::size_t{1} << 20;
  struct Checked {};
  DoubledStep(H hamiltonian, Scheme<Scalar> scheme, Summation summation, Checked)
      : hamiltonian_(std::move(hamiltonian)),
        scheme_(std::move(scheme)),
        moved_(State(dof()).vector()),
        update_(dof()),
        summation_(summation) {
    if constexpr (!fits_on_stack(Dof)) a_ = b_ = gradient_ = moved_;
  }

  bool summed() const {
    return summation_ == Summation::compensated &&
           static_cast<std::size_t>(moved_.size()) * sizeof(Scalar) <= long_vector;
  }

  H hamiltonian_;
  Scheme<Scalar> scheme_;
  Vec moved_;  ///< what both copies moved together
  CompensatedUpdate<Scalar, Dof> update_;
  Summation summation_;
  Vec a_, b_, gradient_;  ///< of large systems only
};

}  // namespace semiexplicit::detail
