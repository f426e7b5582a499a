#pragma once

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit::detail {

/// ‖∇H‖ as a function of (q, p): by its value at some state a checkpoint tells one Hamiltonian from another.
template <class H>
class GradientSize {
 public:
  explicit GradientSize(const H& hamiltonian) : hamiltonian_(hamiltonian) {}

  template <class Q, class P>
  auto operator()(const Q& q, const P& p) const {
    using Scalar = typename H::Scalar;
    PhasePoint<Scalar, H::Dof> at(q.size()), gradient = at;
    at.q() = q;
    at.p() = p;
    gradient_at(hamiltonian_, at.vector().data(), gradient.vector().data(), at.dof());
    return norm(gradient.vector());
  }

 private:
  const H& hamiltonian_;
};

}  // namespace semiexplicit::detail
