#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/vector.hpp>

namespace semiexplicit::detail {

/// Gaussian elimination with partial pivoting, for the matrices of up to about a hundred rows that Newton's method makes.
/// Eigen's PartialPivLU does the same in blocks, and takes the compiler three seconds and 100 MB for each number type.
template <class Scalar>
class DenseLu {
 public:
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Column = Vector<Scalar, Eigen::Dynamic>;

  explicit DenseLu(Eigen::Index size)
      : factors_(Matrix::Zero(size, size)), pivots_(static_cast<std::size_t>(size)) {}

  /// Memory is only taken where the size is a new one. A singular matrix shows in NaN or Inf in solve().
  void compute(const Matrix& matrix) {
    factors_ = matrix;
    const Eigen::Index n = factors_.rows();
    pivots_.resize(static_cast<std::size_t>(n));
    for (Eigen::Index j = 0; j < n; ++j) {
      Scalar* const column = factors_.data() + j * n;
      for (Eigen::Index k = 0; k < j; ++k) std::swap(column[k], column[pivots_[static_cast<std::size_t>(k)]]);
      eliminate(column, j, n);
      const Eigen::Index pivot = largest(column, j, n);
      pivots_[static_cast<std::size_t>(j)] = pivot;
      for (Eigen::Index i = 0; i <= j; ++i) std::swap(factors_(j, i), factors_(pivot, i));
      for (Eigen::Index i = j + 1; i < n; ++i) column[i] /= column[j];
    }
  }

  /// x with matrix x = b.
  Column solve(const Column& b) const {
    Column x = b;
    const Eigen::Index n = factors_.rows();
    for (Eigen::Index k = 0; k < n; ++k) std::swap(x[k], x[pivots_[static_cast<std::size_t>(k)]]);
    eliminate(x.data(), n, n);
    for (Eigen::Index k = n; k-- > 0;) {
      x[k] /= factors_(k, k);
      const Scalar* const column = factors_.data() + k * n;
      for (Eigen::Index i = 0; i < k; ++i) x[i] -= x[k] * column[i];
    }
    return x;
  }

 private:
  /// What the first `steps` columns of L make of a column; two at a time, which halves the way through memory.
  void eliminate(Scalar* __restrict to, Eigen::Index steps, Eigen::Index n) const {
    Eigen::Index k = 0;
    for (; k + 1 < steps; k += 2) {
      const Scalar *const first = factors_.data() + k * n, *const second = first + n;
      to[k + 1] -= to[k] * first[k + 1];
      const Scalar by_first = to[k], by_second = to[k + 1];
      for (Eigen::Index i = k + 2; i < n; ++i) to[i] -= by_first * first[i] + by_second * second[i];
    }
    for (; k < steps; ++k) {
      const Scalar* const first = factors_.data() + k * n;
      const Scalar by_first = to[k];
      for (Eigen::Index i = k + 1; i < n; ++i) to[i] -= by_first * first[i];
    }
  }
  static Eigen::Index largest(const Scalar* column, Eigen::Index begin, Eigen::Index end) {
    using std::abs;
    Eigen::Index at = begin;
    for (Eigen::Index i = begin + 1; i < end; ++i)
      if (abs(column[i]) > abs(column[at])) at = i;
    return at;
  }

  Matrix factors_;  ///< L below the diagonal, U from it on
  std::vector<Eigen::Index> pivots_;
};

}  // namespace semiexplicit::detail
