#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>

static_assert(EIGEN_VERSION_AT_LEAST(3, 4, 0), "semiexplicit needs Eigen 3.4 or later");

namespace semiexplicit {

/// A column of `Dof` numbers (positions, momenta or half a gradient); `Dof` may be Eigen::Dynamic.
template <class Scalar, int Dof>
using Vector = Eigen::Matrix<Scalar, Dof, 1>;

/// Read access to somebody else's column, without a copy.
template <class Scalar, int Dof>
using In = Eigen::Ref<const Vector<Scalar, Dof>>;

/// Write access to somebody else's column, without a copy.
template <class Scalar, int Dof>
using Out = Eigen::Ref<Vector<Scalar, Dof>>;

/// The length of a phase point with `dof` degrees of freedom, at compile time where it is known.
constexpr int twice(int dof) { return dof == Eigen::Dynamic ? Eigen::Dynamic : 2 * dof; }

namespace detail {

/// So few degrees of freedom that work space is on the stack, where the compiler can keep it in registers.
constexpr bool fits_on_stack(int dof) { return dof != Eigen::Dynamic && dof <= 16; }

/// u · v, in four partial sums. Eigen's own reductions make g++ 12 warn of uninitialised variables in its AVX-512
/// intrinsics, in every program that is compiled for such a processor.
template <class U, class V>
typename U::Scalar dot(const Eigen::MatrixBase<U>& u, const Eigen::MatrixBase<V>& v) {
  using Scalar = typename U::Scalar;
  Scalar part[4] = {Scalar(0), Scalar(0), Scalar(0), Scalar(0)};
  const Eigen::Index n = u.size(), whole = n - n % 4;
  for (Eigen::Index i = 0; i < whole; i += 4)
    for (Eigen::Index k = 0; k < 4; ++k) part[k] += u.derived().coeff(i + k) * v.derived().coeff(i + k);
  for (Eigen::Index i = whole; i < n; ++i) part[i - whole] += u.derived().coeff(i) * v.derived().coeff(i);
  return (part[0] + part[1]) + (part[2] + part[3]);
}

/// Σ |vᵢ|, in four partial sums: a norm without squares, which have less room in the exponent.
template <class Derived>
typename Derived::Scalar sum_of_absolutes(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::abs;
  Scalar part[4] = {Scalar(0), Scalar(0), Scalar(0), Scalar(0)};
  const Eigen::Index n = v.size(), whole = n - n % 4;
  for (Eigen::Index i = 0; i < whole; i += 4)
    for (Eigen::Index k = 0; k < 4; ++k) part[k] += abs(v.derived().coeff(i + k));
  for (Eigen::Index i = whole; i < n; ++i) part[i - whole] += abs(v.derived().coeff(i));
  return (part[0] + part[1]) + (part[2] + part[3]);
}

/// norm() of a vector whose squares leave the range of normal numbers.
template <class Derived>
SEMIEXPLICIT_NOINLINE typename Derived::Scalar norm_of_extreme(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::abs;
  using std::isfinite;
  using std::sqrt;
  Scalar largest(0);
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (abs(v.derived().coeff(i)) > largest) largest = abs(v.derived().coeff(i));
  if (largest == Scalar(0) || !isfinite(largest)) return largest;
  return largest * sqrt(dot(v / largest, v / largest));
}

/// Euclidean norm that neither underflows nor overflows: states of size 1e-200 or 1e200 have a norm, too.
template <class Derived>
typename Derived::Scalar norm(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::sqrt;
  // The plain sum is right wherever no square left the range of normal numbers.
  const Scalar squared = dot(v, v);
  const Scalar small = (std::numeric_limits<Scalar>::min)() / std::numeric_limits<Scalar>::epsilon();
  const Scalar large = (std::numeric_limits<Scalar>::max)() * std::numeric_limits<Scalar>::epsilon();
  if ((squared >= small && squared <= large) || squared != squared) return sqrt(squared);
  return norm_of_extreme(v);
}

}  // namespace detail
}  // namespace semiexplicit
