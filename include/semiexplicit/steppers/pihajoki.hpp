#pragma once

#include <cmath>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/steppers/detail/kick_chain.hpp>

namespace semiexplicit {

namespace detail {

/// Is `dt` a step at all: finite, and not zero?
template <class Scalar>
bool valid_step(const Scalar& dt) {
  using std::isfinite;
  return isfinite(dt) && dt != Scalar(0);
}

/// Moves `zeta` by an explicit map: run() works on the chain's copies, and only a finite result becomes the new state.
template <class H, class Run>
StepReport step_explicitly(ExtendedPoint<typename KickChain<H>::Scalar, KickChain<H>::Dof>& zeta,
                           KickChain<H>& chain, const typename KickChain<H>::Scalar& dt,
                           std::int64_t gradients, const Run& run) {
  if (!valid_step(dt)) return {.status = Status::invalid_step};
  if (!chain.valid()) return {.status = Status::invalid_stepper};
  if (zeta.a.vector().size() != chain.a.size() || zeta.b.vector().size() != chain.b.size())
    return {.status = Status::invalid_state};
  chain.a = zeta.a.vector();
  chain.b = zeta.b.vector();
  run();
  StepReport report{.status = Status::not_finite, .evaluations = 1, .gradients = gradients};
  if (!chain.a.allFinite() || !chain.b.allFinite()) {
    if (!zeta.a.vector().allFinite() || !zeta.b.vector().allFinite()) report.status = Status::invalid_state;
  } else {
    zeta.a.vector() = chain.a;
    zeta.b.vector() = chain.b;
    report.status = Status::success;
  }
  return report;
}

}  // namespace detail

/// The explicit map of the doubled space: a palindromic list of kicks A(a₀dt) B(b₀dt) A(a₁dt) ..., one gradient call each,
/// where A is the flow of H(q, y) and B that of H(x, p). Symmetric and symplectic in the doubled space R^{4d}. Nothing
/// binds the copies: unprojected, they part in time, which is what the projections are for.
///
/// Source: P. Pihajoki, Celest. Mech. Dyn. Astron. 121 (2015) 211. Memory: three vectors of length 2d, and H.
template <class H>
class Pihajoki {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = ExtendedPoint<Scalar, Dof>;
  static constexpr const char* name = "Pihajoki";

  /// Throws std::invalid_argument, saying what is wrong, unless the scheme passes its own check.
  Pihajoki(H hamiltonian, Scheme<Scalar> scheme) : chain_(std::move(hamiltonian), std::move(scheme)) {}

  /// One step of size dt, which may be negative. zeta is untouched unless the report is ok(); it fails on dt = 0, on a
  /// state of another size or not finite, and where a gradient makes the copies NaN or Inf.
  StepReport step(State& zeta, const Scalar& dt) {
    return detail::step_explicitly(zeta, chain_, dt, chain_.gradients(), [&] { chain_.run(dt); });
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return chain_.hamiltonian; }
  const Scheme<Scalar>& scheme() const { return chain_.scheme; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("scheme", scheme());
    list.function("Hamiltonian", detail::GradientSize(hamiltonian()));
  }
  /// Nothing goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&&) {}

 private:
  detail::KickChain<H> chain_;
};

}  // namespace semiexplicit
