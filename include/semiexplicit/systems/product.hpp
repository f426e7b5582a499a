#pragma once

#include <semiexplicit/core/vector.hpp>

namespace semiexplicit::systems {

/// H = (q² + 1)(p² + 1)/2 in one degree of freedom: the smallest non-separable problem with a closed form.
/// From (q₀, 0), q(t) = q₀ cn(√(1 + q₀²) t | k² = q₀²/(1 + q₀²)) and p = q'/(q² + 1), with Jacobi's elliptic
/// function cn.
///
/// Source: M. Tao, Phys. Rev. E 94 (2016) 043303; the order test of Jayawardana and Ohsawa (2023), eq.
/// (exact-H).
template <class ScalarType = double>
struct Product {
  using Scalar = ScalarType;
  static constexpr int Dof = 1;

  Scalar energy(const In<Scalar, 1>& q, const In<Scalar, 1>& p) const {
    return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2;
  }
  void gradient(const In<Scalar, 1>& q, const In<Scalar, 1>& p, Out<Scalar, 1> dHdq,
                Out<Scalar, 1> dHdp) const {
    gradient(q.data(), p.data(), dHdq.data(), dHdp.data());
  }
  using PackGradientOf = Product;
  /// The same with any numbers in arrays, packs above all; see HasPackGradient.
  template <class T>
  void gradient(const T* q, const T* p, T* dHdq, T* dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + T(1));
    dHdp[0] = p[0] * (q[0] * q[0] + T(1));
  }
  void hessian(const In<Scalar, 1>& q, const In<Scalar, 1>& p,
               Eigen::Ref<Eigen::Matrix<Scalar, 2, 2>> hessian) const {
    hessian << p[0] * p[0] + 1, 2 * q[0] * p[0], 2 * q[0] * p[0], q[0] * q[0] + 1;
  }
};

}  // namespace semiexplicit::systems
