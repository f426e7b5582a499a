#pragma once

#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/pihajoki.hpp>

namespace semiexplicit::detail {

/// What the projections share: one step of the doubled system from a common point z, and the move of z to the mean of
/// the copies. Six vectors of length 2d.
template <class H>
class DoubledStep {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  using Vec = typename State::Storage;

  DoubledStep(H hamiltonian, Scheme<Scalar> scheme, Summation summation)
      : chain_(std::move(hamiltonian), std::move(scheme)),
        sum_(chain_.a),
        update_(dof_of(chain_.hamiltonian)),
        summation_(summation) {}

  /// Whether a step of size dt can start from z: Status::success if so. Costs nothing: a state that is not finite shows
  /// in the result, and diagnose() tells it from a gradient that is not.
  Status check(const State& z, const Scalar& dt) const {
    if (!valid_step(dt)) return Status::invalid_step;
    if (!chain_.valid()) return Status::invalid_stepper;
    return z.vector().size() == chain_.a.size() ? Status::success : Status::invalid_state;
  }

  /// The status of a step from z that came out NaN or Inf.
  static Status diagnose(const State& z) {
    return z.vector().allFinite() ? Status::not_finite : Status::invalid_state;
  }

  /// All kicks from a = b = z.
  void sweep(const State& z, const Scalar& dt) { run(z.vector(), z.vector(), dt); }

  /// The same from a = z + m, b = z - m (the paper's ζ + Aᵀμ).
  void sweep(const State& z, const Vec& m, const Scalar& dt) {
    chain_.a = z.vector() + m;
    chain_.b = z.vector() - m;
    run(chain_.a, chain_.b, dt);
  }

  /// a - b after the sweep.
  auto difference() const { return chain_.a - chain_.b; }

  /// How far the mean of the copies moved from z, in the Euclidean norm.
  Scalar distance(const State& z) const {
    return summed() ? norm(sum_) / 2 : norm((chain_.a - z.vector()) + (chain_.b - z.vector())) / 2;
  }

  /// z becomes the mean of the copies; false, and z untouched, where that is not finite.
  bool finish(State& z) {
    if (summation_ == Summation::plain) {
      sum_ = (chain_.a + chain_.b) / 2;
      if (!sum_.allFinite()) return false;
      z.vector() = sum_;
      return true;
    }
    if (summed()) return update_.update(z, [moved = sum_.data()](Eigen::Index i) { return moved[i] / 2; });
    return update_.update(z, [a = chain_.a.data(), b = chain_.b.data(), from = z.vector().data()](
                                 Eigen::Index i) { return ((a[i] - from[i]) + (b[i] - from[i])) / 2; });
  }

  const KickChain<H>& chain() const { return chain_; }
  Summation summation() const { return summation_; }

  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof_of(chain_.hamiltonian));
    list("scheme", chain_.scheme);
    list("summation", summation_);
    list.function("Hamiltonian", GradientSize(chain_.hamiltonian));
  }
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
  }

 private:
  /// In vectors longer than this (bytes) a kick costs what it moves through memory, and keeping the sum up to date in each
  /// would be a third of that. What the copies moved is taken from them at the end then, with their rounding errors.
  static constexpr std::size_t long_vector = std::size_t{1} << 20;
  bool summed() const {
    return summation_ == Summation::compensated &&
           static_cast<std::size_t>(chain_.a.size()) * sizeof(Scalar) <= long_vector;
  }

  void run(const Vec& from_a, const Vec& from_b, const Scalar& dt) {
    if (summed()) {
      chain_.run(from_a, from_b, dt, sum_);
    } else {
      if (&from_a != &chain_.a) {
        chain_.a = from_a;
        chain_.b = from_b;
      }
      chain_.run(dt);
    }
  }

  KickChain<H> chain_;
  Vec sum_;
  CompensatedUpdate<Scalar, Dof> update_;
  Summation summation_;
};

}  // namespace semiexplicit::detail
