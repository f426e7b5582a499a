#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>

namespace semiexplicit::detail {

/// ∇²H at z, a symmetric 2d × 2d matrix: by H.hessian where there is one, else by central differences of the gradient, which are
/// off by about 1e-10 of its size in double (ε^{2/3}); by more along a time so late that its own rounding shows. NaN or Inf
/// where the gradient is; what a gradient throws goes through. Memory: three vectors of length 2d.
template <class H>
class SecondDerivatives {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Matrix = Eigen::Matrix<Scalar, twice(H::Dof), twice(H::Dof)>;

  explicit SecondDerivatives(Eigen::Index dof) : at_(dof), above_(at_), below_(at_) {}

  /// Gradient calls that a Hessian takes.
  static Eigen::Index gradients(Eigen::Index dof) { return HasHessian<H> ? 0 : 4 * dof; }

  void operator()(const H& h, const typename State::Storage& z, Matrix& hessian) {
    const Eigen::Index d = z.size() / 2;
    if constexpr (HasHessian<H>) {
      h.hessian(InColumn<H>(z.data(), d), InColumn<H>(z.data() + d, d), hessian);
    } else {
      using std::abs;
      using std::cbrt;
      at_.vector() = z;
      const Scalar size_or_zero = state_size(h, at_);
      const Scalar size = size_or_zero > Scalar(0) ? size_or_zero : Scalar(1);
      const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), usual = cbrt(epsilon);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        // The best shift for the rounding of this entry: a time may be far larger than the state.
        const Scalar rounding = epsilon * (abs(z[i]) / size);
        const Scalar shift =
            size * (rounding > epsilon ? std::max<Scalar>(cbrt(rounding), 2 * rounding) : usual);
        const Scalar right = z[i] + shift, left = z[i] - shift;
        at_.vector()[i] = right;
        gradient_at(h, at_.vector().data(), above_.vector().data(), d);
        at_.vector()[i] = left;
        gradient_at(h, at_.vector().data(), below_.vector().data(), d);
        at_.vector()[i] = z[i];
        hessian.col(i) = (above_.vector() - below_.vector()) / (right - left);
      }
      // Symmetric to the last bit, so that the tangent map is symplectic although its entries are approximate.
      for (Eigen::Index i = 0; i < z.size(); ++i)
        for (Eigen::Index j = 0; j < i; ++j)
          hessian(i, j) = hessian(j, i) = (hessian(i, j) + hessian(j, i)) / 2;
    }
  }

 private:
  State at_, above_, below_;
};

}  // namespace semiexplicit::detail
