#pragma once

#include <Eigen/LU>

namespace semiexplicit::detail {

/// A square system of linear equations, factorised once and solved for many right-hand sides. One type for
/// all sizes: compilers take a second for Eigen's factorisation of each size that they know. The memory for
/// small systems is taken at construction; Eigen's products take some for large ones, from about a hundred
/// on.
template <class Scalar>
class LinearSystem {
 public:
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  explicit LinearSystem(Eigen::Index size) : matrix(Dense::Zero(size, size)), lu_(size) {}

  Dense matrix;

  /// What is solved from now on is `matrix` as it is at this call.
  void factorise() { lu_.compute(matrix); }

  /// Solves for one right-hand side, of as many numbers as the matrix has rows. `b` and `x` are apart.
  void solve(const Scalar* b, Scalar* x) const {
    using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
    Eigen::Map<Column>(x, matrix.rows()) = lu_.solve(Eigen::Map<const Column>(b, matrix.rows()));
  }
  /// For as many right-hand sides as the matrix has rows, column by column.
  void solve_square(const Scalar* b, Scalar* x) const {
    Eigen::Map<Dense>(x, matrix.rows(), matrix.rows()) =
        lu_.solve(Eigen::Map<const Dense>(b, matrix.rows(), matrix.rows()));
  }

 private:
  Eigen::PartialPivLU<Dense> lu_;
};

}  // namespace semiexplicit::detail
