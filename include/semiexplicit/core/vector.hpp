#pragma once

#include <cmath>
#include <limits>

#include <Eigen/Core>

static_assert(EIGEN_VERSION_AT_LEAST(3, 4, 0), "semiexplicit needs Eigen 3.4 or later");

namespace semiexplicit {

/// A column of `Dof` numbers (positions, momenta or half a gradient); `Dof` may be Eigen::Dynamic.
template <class Scalar, int Dof>
using Vector = Eigen::Matrix<Scalar, Dof, 1>;

/// Read access to somebody else's column, without a copy.
template <class Scalar, int Dof>
using ConstRef = Eigen::Ref<const Vector<Scalar, Dof>>;

/// Write access to somebody else's column, without a copy.
template <class Scalar, int Dof>
using Ref = Eigen::Ref<Vector<Scalar, Dof>>;

/// The length of a phase point with `dof` degrees of freedom, at compile time where it is known.
constexpr int twice(int dof) { return dof == Eigen::Dynamic ? Eigen::Dynamic : 2 * dof; }

namespace detail {

/// Euclidean norm that neither underflows nor overflows: states of size 1e-150 or 1e150 have a norm, too.
template <class Derived>
typename Derived::Scalar norm(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::sqrt;
  const Scalar squared = v.squaredNorm();
  // The plain sum is right wherever no square left the range of normal numbers.
  static const Scalar small =
      Scalar(std::numeric_limits<Scalar>::min()) / Eigen::NumTraits<Scalar>::epsilon();
  static const Scalar large =
      Scalar(std::numeric_limits<Scalar>::max()) * Eigen::NumTraits<Scalar>::epsilon();
  if (squared >= small && squared <= large) return sqrt(squared);
  return v.stableNorm();
}

}  // namespace detail
}  // namespace semiexplicit
