#pragma once

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/derivatives/dual.hpp>

/// The gradient of energy(q, p), one derivative at a time by dual numbers: what other ways to find it are
/// compared with.
template <class Energy, class Scalar, int Dof>
typename semiexplicit::PhasePoint<Scalar, Dof>::Storage forward_gradient(
    const Energy& energy, const semiexplicit::PhasePoint<Scalar, Dof>& z) {
  using Number = semiexplicit::detail::Dual<Scalar, 1>;
  const Eigen::Index d = z.dof();
  auto result = z.vector();
  for (Eigen::Index k = 0; k < 2 * d; ++k) {
    semiexplicit::Vector<Number, Eigen::Dynamic> x(2 * d);
    for (Eigen::Index i = 0; i < 2 * d; ++i) {
      x[i] = Number(z.vector()[i]);
      if (i == k) x[i].derivative[0] = Scalar(1);
    }
    const semiexplicit::Vector<Number, Eigen::Dynamic> q = x.head(d), p = x.tail(d);
    const Number h = energy(q, p);
    result[k] = h.derivative[0];
  }
  return result;
}
