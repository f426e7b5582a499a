#pragma once

#include <cmath>

#include <Eigen/LU>

#include <semiexplicit/core/vector.hpp>

namespace semiexplicit::detail {

/// A square system of linear equations, factorised once and solved for many right-hand sides. One type for
/// all sizes: compilers take a second for Eigen's factorisation of each size that they know. The memory for
/// small systems is taken at construction; Eigen's products take some for large ones, from about a hundred
/// on.
///
/// Each equation is in the unit of the unknown of the same number, and these units may differ by any factor
/// (metres, kg m/s), by which pivots must not be chosen: the matrix is balanced first, in powers of two.
///
/// Source: B. N. Parlett, C. Reinsch, Numer. Math. 13 (1969) 293.
template <class Scalar>
class LinearSystem {
 public:
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  explicit LinearSystem(Eigen::Index size)
      : matrix(Dense::Zero(size, size)), unit_(Column::Ones(size)), scaled_(unit_), lu_(size) {}

  Dense matrix;

  /// What is solved from now on is `matrix` as it is at this call, which is balanced in place.
  void factorise() {
    balance();
    lu_.compute(matrix);
  }

  /// Solves for one right-hand side, of as many numbers as the matrix has rows. `b` and `x` are apart.
  void solve(const Scalar* b, Scalar* x) {
    const Eigen::Index n = matrix.rows();
    for (Eigen::Index i = 0; i < n; ++i) scaled_[i] = b[i] / unit_[i];
    Eigen::Map<Column> result(x, n);
    result = lu_.solve(scaled_);
    for (Eigen::Index i = 0; i < n; ++i) x[i] *= unit_[i];
  }

 private:
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// matrix becomes U⁻¹ matrix U, U being the diagonal matrix of unit_, where no column's entries off the
  /// diagonal are far larger or smaller than its row's.
  void balance() {
    using std::abs;
    using std::isfinite;
    using std::sqrt;
    const Eigen::Index n = matrix.rows();
    unit_.setOnes();
    bool changed = true;
    for (int pass = 0; pass < 8 && changed; ++pass) {
      changed = false;
      for (Eigen::Index i = 0; i < n; ++i) {
        Scalar row(0), column(0);
        for (Eigen::Index k = 0; k < n; ++k)
          if (k != i) row += abs(matrix(i, k)), column += abs(matrix(k, i));
        const Scalar ratio = sqrt(row) / sqrt(column);
        if (!(ratio > Scalar(0)) || !isfinite(ratio) || (ratio < Scalar(16) && ratio > Scalar(1) / 16))
          continue;
        const Scalar unit = power_of_two(ratio);
        for (Eigen::Index k = 0; k < n; ++k) matrix(i, k) /= unit;
        for (Eigen::Index k = 0; k < n; ++k) matrix(k, i) *= unit;
        unit_[i] *= unit;
        changed = true;
      }
    }
  }

  Column unit_, scaled_;
  Eigen::PartialPivLU<Dense> lu_;
};

}  // namespace semiexplicit::detail
