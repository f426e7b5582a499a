#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/threads.hpp>

static_assert(EIGEN_VERSION_AT_LEAST(3, 4, 0), "semiexplicit needs Eigen 3.4 or later");
static_assert(!Eigen::Matrix<double, 2, 2>::IsRowMajor,
              "semiexplicit keeps matrices by columns: compile it without EIGEN_DEFAULT_TO_ROW_MAJOR");
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "semiexplicit needs sums and NaN as they are written: compile it without -ffast-math and -Ofast"
#endif

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

/// Whether two sizes, as far as they are known at compile time, may be the same.
constexpr bool sizes_may_agree(int one, int other) {
  return one == other || one == Eigen::Dynamic || other == Eigen::Dynamic;
}

/// The number of columns of a matrix of work space, at compile time where it is known and the matrix is not
/// too large to be a member (Eigen allows 128 kB).
template <class Scalar>
constexpr int columns_in_place(int rows, int columns) {
  const bool known = rows != Eigen::Dynamic && columns != Eigen::Dynamic;
  return known && sizeof(Scalar) * std::size_t(rows) * std::size_t(columns) <= 128 * 1024 ? columns
                                                                                          : Eigen::Dynamic;
}

/// So few degrees of freedom that work space is on the stack, where the compiler can keep it in registers.
constexpr bool fits_on_stack(int dof) { return dof != Eigen::Dynamic && dof <= 16; }

/// Sums of more terms than this are those of blocks, so that they do not depend on how many threads sum them.
inline constexpr Eigen::Index long_sum = 16384, most_blocks = 64;
/// The length of the blocks of such a sum, a multiple of 64; there are most_blocks or less.
constexpr Eigen::Index block_of_sum(Eigen::Index n) {
  const Eigen::Index block = (n + most_blocks - 1) / most_blocks;
  return (block + 63) / 64 * 64;
}

/// Sum of term(i) over begin <= i < end, in four partial sums.
template <class Scalar, class Term>
SEMIEXPLICIT_INLINE Scalar sum_in_four(Eigen::Index begin, Eigen::Index end, const Term& term) {
  Scalar part[4] = {Scalar(0), Scalar(0), Scalar(0), Scalar(0)};
  const Eigen::Index whole = end - (end - begin) % 4;
  for (Eigen::Index i = begin; i < whole; i += 4)
    for (Eigen::Index k = 0; k < 4; ++k) part[k] += term(i + k);
  for (Eigen::Index i = whole; i < end; ++i) part[i - whole] += term(i);
  return (part[0] + part[1]) + (part[2] + part[3]);
}

template <class U, class V>
SEMIEXPLICIT_INLINE typename U::Scalar dot_of_block(const Eigen::MatrixBase<U>& u,
                                                    const Eigen::MatrixBase<V>& v, Eigen::Index begin,
                                                    Eigen::Index end) {
  using Scalar = typename U::Scalar;
  return sum_in_four<Scalar>(begin, end, [&](Eigen::Index i) SEMIEXPLICIT_INLINE_LAMBDA {
    return Scalar(u.derived().coeff(i) * v.derived().coeff(i));
  });
}
template <class U, class V>
SEMIEXPLICIT_NOINLINE typename U::Scalar dot_of_many(const Eigen::MatrixBase<U>& u,
                                                     const Eigen::MatrixBase<V>& v) {
  using Scalar = typename U::Scalar;
  const Eigen::Index n = u.size(), block = block_of_sum(n);
  Scalar part[most_blocks];
  in_parts(n, block, 2 * long_loop, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; i += block)
      part[i / block] = dot_of_block(u, v, i, std::min(i + block, end));
  });
  Scalar sum(0);
  for (Eigen::Index i = 0; i * block < n; ++i) sum += part[i];
  return sum;
}

/// u · v, in four partial sums; of long vectors in blocks. Eigen's own reductions make g++ 12 warn of
/// uninitialised variables in its AVX-512 intrinsics, in every program that is compiled for such a processor.
template <class U, class V>
typename U::Scalar dot(const Eigen::MatrixBase<U>& u, const Eigen::MatrixBase<V>& v) {
  constexpr bool may_be_long = U::SizeAtCompileTime == Eigen::Dynamic || U::SizeAtCompileTime > long_sum;
  if constexpr (may_be_long)
    if (u.size() > long_sum) return dot_of_many(u, v);
  return dot_of_block(u, v, 0, u.size());
}

/// Σ |vᵢ|, in four partial sums: a norm without squares, which have less room in the exponent.
template <class Derived>
typename Derived::Scalar sum_of_absolutes(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::abs;
  return sum_in_four<Scalar>(0, v.size(), [&](Eigen::Index i) { return Scalar(abs(v.derived().coeff(i))); });
}

/// The power of two next above a positive number: as a unit it rounds nothing.
template <class Scalar>
Scalar power_of_two(const Scalar& x) {
  using std::frexp;
  using std::ldexp;
  int power = 0;
  frexp(x, &power);
  return ldexp(Scalar(1), power);
}

/// Whether none of n numbers is NaN or Inf. Eigen's allFinite() costs compilers a family of classes for each
/// type of vector.
template <class Scalar>
bool all_finite(const Scalar* x, Eigen::Index n) {
  return sum_in_four<Scalar>(0, n, [x](Eigen::Index i) { return Scalar(x[i] - x[i]); }) == Scalar(0);
}
template <class Dense>
bool all_finite(const Dense& v) {
  return all_finite(v.data(), v.size());
}

/// max |vᵢ|; NaN does not count.
template <class Derived>
typename Derived::Scalar largest_absolute(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::abs;
  Scalar largest(0);
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (abs(v.derived().coeff(i)) > largest) largest = abs(v.derived().coeff(i));
  return largest;
}

/// norm() of a vector whose squares leave the range of normal numbers.
template <class Derived>
SEMIEXPLICIT_NOINLINE typename Derived::Scalar norm_of_extreme(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::isfinite;
  using std::sqrt;
  const Scalar largest = largest_absolute(v);
  if (largest == Scalar(0) || !isfinite(largest)) return largest;
  return largest * sqrt(sum_in_four<Scalar>(0, v.size(), [&](Eigen::Index i) {
           const Scalar part = v.derived().coeff(i) / largest;
           return Scalar(part * part);
         }));
}

/// Whether a sum of squares is right as it is: none of them left the range of normal numbers, or it is NaN.
template <class Scalar>
bool is_plain_square(const Scalar& squared) {
  const Scalar small = (std::numeric_limits<Scalar>::min)() / std::numeric_limits<Scalar>::epsilon();
  const Scalar large = (std::numeric_limits<Scalar>::max)() * std::numeric_limits<Scalar>::epsilon();
  return (squared >= small && squared <= large) || squared != squared;
}

/// Euclidean norm that neither underflows nor overflows: states of size 1e-200 or 1e200 have a norm, too.
template <class Derived>
typename Derived::Scalar norm(const Eigen::MatrixBase<Derived>& v) {
  using Scalar = typename Derived::Scalar;
  using std::sqrt;
  const Scalar squared = dot(v, v);
  if (is_plain_square(squared)) return sqrt(squared);
  return norm_of_extreme(v);
}

}  // namespace detail
}  // namespace semiexplicit
