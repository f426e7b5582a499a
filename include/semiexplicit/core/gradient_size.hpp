#pragma once

#include <cmath>
#include <cstdint>

#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/reference_size.hpp>

namespace semiexplicit {

/// The size of ∇H, as a function of (q, p): by its value at some state a checkpoint tells one Hamiltonian
/// from another. A stepper or an observer of one's own that has an H lists it (see Describable):
///
///     list.function("Hamiltonian", GradientSize(hamiltonian_));
///
/// It refers to H. It is a product of powers of the entries, which shows a change of any, however much larger
/// others are: of one by a part δ it is a part of some δ/2d. The powers are random, for a parameter scales
/// entries by rational powers, as a mass does one up and one down, and other signs, or zeros, are another
/// number.
template <class H>
class GradientSize {
 public:
  explicit GradientSize(const H& hamiltonian) : hamiltonian_(hamiltonian) {}

  template <class Q, class P>
  auto operator()(const Q& q, const P& p) const {
    using std::exp, std::exp2, std::frexp, std::isfinite, std::log;
    using Scalar = typename H::Scalar;
    PhasePoint<Scalar, H::Dof> at(q.size()), gradient = at;
    at.q() = q;
    at.p() = p;
    detail::gradient_at(hamiltonian_, at.vector().data(), gradient.vector().data(), at.dof());
    std::uint64_t random = 1;
    // Mantissas and exponents are added up apart: a part of the last digits of either is not lost.
    Scalar weights(0), mantissas(0), exponents(0);
    for (const Scalar& entry : gradient.vector()) {
      const Scalar weight(1 + detail::scattered(random) / 2);
      if (!isfinite(entry)) return entry;
      int exponent = 0;
      const Scalar mantissa = frexp(entry, &exponent);
      weights += weight;
      mantissas += weight * (entry == Scalar(0)  ? -3 * weight
                             : entry < Scalar(0) ? log(-mantissa) - weight
                                                 : log(mantissa));
      exponents += weight * Scalar(exponent);
    }
    return Scalar(exp(mantissas / weights) * exp2(exponents / weights));
  }

 private:
  const H& hamiltonian_;
};

}  // namespace semiexplicit
