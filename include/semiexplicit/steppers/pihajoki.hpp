#pragma once

#include <cstdint>
#include <utility>

#include <semiexplicit/steppers/detail/explicit_map.hpp>

namespace semiexplicit {

/// The explicit map of the doubled space: a palindromic list of kicks A(a₀dt) B(b₀dt) A(a₁dt) ..., one
/// gradient call each, where A is the flow of H(q, y) and B that of H(x, p). Symmetric and symplectic in the
/// doubled space R^{4d}. Nothing binds the copies: unprojected, they part in time, which is what the
/// projections are for.
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
  Pihajoki(H hamiltonian, Scheme<Scalar> scheme) : map_(std::move(hamiltonian), std::move(scheme)) {}

  /// One step of size dt, which may be negative. zeta is untouched unless the report is ok(); it fails on dt
  /// = 0, on a state of another size or not finite, and where a gradient makes the copies NaN or Inf.
  StepReport step(State& zeta, const Scalar& dt) {
    return map_.step(zeta, dt, static_cast<std::int64_t>(scheme().kicks()),
                     [&](auto* a, auto* b, auto* gradient, auto d) {
                       detail::kicks(hamiltonian(), scheme(), dt, a, b, gradient, d);
                     });
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return map_.hamiltonian; }
  const Scheme<Scalar>& scheme() const { return map_.scheme; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("scheme", scheme());
    list.function("Hamiltonian", GradientSize(hamiltonian()));
  }
  /// Nothing goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&&) {}

 private:
  detail::ExplicitMap<H> map_;
};

}  // namespace semiexplicit
