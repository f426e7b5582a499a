#pragma once

#include <cmath>
#include <cstdint>

#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/reference_size.hpp>

namespace semiexplicit::detail {

/// A number as large as ∇H, as a function of (q, p): by its value at some state a checkpoint tells one
/// Hamiltonian from another. Each half g of the gradient gives ‖g‖ + w·g/2 with weights w of length one at
/// most and of either sign: other signs are another number, and it lies between ‖g‖/2 and 3‖g‖/2, so that
/// nothing cancels. A product of powers of both shows a change of either, however much larger the other one
/// is in its units; the exponents are irrational, for a parameter scales the halves by rational powers, as a
/// mass does one up and one down.
template <class H>
class GradientSize {
 public:
  explicit GradientSize(const H& hamiltonian) : hamiltonian_(hamiltonian) {}

  template <class Q, class P>
  auto operator()(const Q& q, const P& p) const {
    using std::pow;
    using Scalar = typename H::Scalar;
    PhasePoint<Scalar, H::Dof> at(q.size()), gradient = at;
    at.q() = q;
    at.p() = p;
    gradient_at(hamiltonian_, at.vector().data(), gradient.vector().data(), at.dof());
    std::uint64_t random = 1;
    const Scalar by_q = with_signs(gradient.q(), random), by_p = with_signs(gradient.p(), random);
    if (by_q == Scalar(0) || by_p == Scalar(0)) return Scalar(by_q + by_p);
    const Scalar golden(0.61803398874989485);
    return Scalar(pow(by_q, golden) * pow(by_p, 1 - golden));
  }

 private:
  template <class Half>
  static auto with_signs(const Half& half, std::uint64_t& random) {
    using std::isfinite;
    using std::sqrt;
    using Scalar = typename Half::Scalar;
    const Scalar size = norm(half);
    if (size == Scalar(0) || !isfinite(size)) return size;
    Scalar sum(0);
    for (Eigen::Index i = 0; i < half.size(); ++i) sum += Scalar(scattered(random)) * (half[i] / size);
    return Scalar(size * (1 + sum / (2 * sqrt(Scalar(half.size())))));
  }

  const H& hamiltonian_;
};

}  // namespace semiexplicit::detail
