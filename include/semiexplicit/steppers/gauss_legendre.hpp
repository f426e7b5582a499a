#pragma once

#include <limits>
#include <optional>
#include <utility>

#include <semiexplicit/core/linear_system.hpp>
#include <semiexplicit/steppers/detail/gauss_shell.hpp>

namespace semiexplicit {

/// The implicit Gauss-Legendre Runge-Kutta method: symplectic, symmetric, keeps quadratic invariants, order
/// 2s. The strongest general rival of the semiexplicit method, and therefore written to win: extrapolated
/// starting values, Gauss-Seidel iteration that stops at the rounding floor, compensated update. The
/// coefficients are symplectic as they are rounded: errors of the energy by rounding are a random walk,
/// without a drift (the phase drifts by some ε of itself, for Σb is rounded).
///
/// Newton's method takes the Hessian of H where it has one (HasHessian), else central differences of the
/// gradient (4d calls a stage). Memory: (3s + 10) vectors of length 2d; Newton's method 2 (2ds)² numbers
/// more, and its factorisation may use the heap. Its step ends with the gradients from before the last
/// correction, so it wants a tight tolerance. step(), the accessors and what a checkpoint asks for are in
/// detail::GaussShell.
///
/// Sources: Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3 and VIII.6; Antoñana, Makazaga,
/// Murua, Numer. Algorithms 76 (2017) 861.
template <class H>
class GaussLegendre : public detail::GaussShell<GaussLegendre<H>, H> {
  using Shell = detail::GaussShell<GaussLegendre<H>, H>;
  friend Shell;

 public:
  using Shell::Dof, Shell::dof;
  using typename Shell::Scalar, typename Shell::State;
  static constexpr const char* name = "GaussLegendre";

  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8, max_iterations ≥ 1 and tolerance ≥ 0.
  GaussLegendre(H hamiltonian, GaussLegendreOptions options = {})
      : Shell(std::move(hamiltonian), options),
        extrapolation_(options.stages, options.stages),
        quadrature_(tableau_.b),
        gradients_(Stages::Zero(small ? padded : 2 * dof(), options.stages)),
        started_(gradients_),
        displacements_(gradients_),
        sign_(gradients_.col(0)),
        changed_(sign_),
        point_(State(dof()).vector()) {
    sign_.head(dof()).setOnes();
    sign_.segment(dof(), dof()).setConstant(Scalar(-1));
    if (options.solver == StageSolver::newton) newton_.emplace(dof(), options.stages);
  }

 private:
  using Shell::hamiltonian_, Shell::options_, Shell::tableau_;
  using typename Shell::Vec;
  /// Columns of a few numbers are padded with zeros to whole registers, where sums over the stages then stay.
  static constexpr bool small = Dof != Eigen::Dynamic && Dof <= 32;
  static constexpr int padded = small ? (2 * Dof + 3) / 4 * 4 : twice(Dof);
  using Column = Vector<Scalar, padded>;
  using Stages = Eigen::Matrix<Scalar, padded, Eigen::Dynamic>;  // a column a stage
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  Eigen::Index size() const { return quadrature_.size() == 0 ? 0 : point_.size(); }

  void scale_weights(const Scalar& dt) { quadrature_ = dt * tableau_.b; }

  /// The matrix that makes dt b_i X_i of the next step from those of this one.
  void follow_by(const Scalar& ratio) {
    Scalar values[8];
    for (Eigen::Index i = 0; i < extrapolation_.rows(); ++i) {
      tableau_.lagrange(Scalar(1 + ratio * tableau_.c[i]), values);
      for (Eigen::Index j = 0; j < extrapolation_.cols(); ++j)
        extrapolation_(i, j) = ratio * values[j] * tableau_.b[i] / tableau_.b[j];
    }
  }

  Scalar increment(Eigen::Index i) const {
    Scalar sum(0);
    for (Eigen::Index j = 0; j < gradients_.cols(); ++j) sum += gradients_(i, j);
    return sign_[i] * sum;
  }

  template <class Visitor>
  void visit_stages(Visitor& visit) {
    visit(gradients_);
    if (newton_) newton_->second.visit_memory(visit);
  }

  /// put(k, Σ_j matrix_ij stages_kj) for every k: row i of a matrix over the stages, in blocks that stay in
  /// registers.
  template <class Put>
  static void combine(const Dense& matrix, Eigen::Index i, const Stages& stages, const Put& put) {
    const Eigen::Index n = stages.rows();
    constexpr Eigen::Index block = small ? padded : 32;
    Eigen::Index begin = 0;
    for (; begin + block <= n; begin += block) combine_block<block>(matrix, i, stages, begin, block, put);
    if constexpr (!small)
      if (begin < n) combine_block<block>(matrix, i, stages, begin, n - begin, put);
  }
  template <Eigen::Index Block, class Put>
  static void combine_block(const Dense& matrix, Eigen::Index i, const Stages& stages, Eigen::Index begin,
                            Eigen::Index size, const Put& put) {
    Scalar sum[std::size_t(Block)];
    for (Eigen::Index k = 0; k < Block; ++k) sum[k] = Scalar(0);
    for (Eigen::Index j = 0; j < stages.cols(); ++j) {
      const Scalar factor = matrix(i, j);
      const Scalar* const stage = stages.data() + j * stages.rows() + begin;
      for (Eigen::Index k = 0; k < size; ++k) sum[k] += factor * stage[k];
    }
    for (Eigen::Index k = 0; k < size; ++k) put(begin + k, sum[k]);
  }

  /// First values of the stages' gradients and displacements.
  void start(const State& z, bool extrapolate, StepReport& report) {
    if (extrapolate) {
      started_.swap(gradients_);
      for (Eigen::Index i = 0; i < gradients_.cols(); ++i) {
        Scalar* const to = gradients_.data() + i * gradients_.rows();
        combine(extrapolation_, i, started_, [to](Eigen::Index k, const Scalar& sum) { to[k] = sum; });
      }
    } else {
      point_ = z.vector();
      evaluate(0);
      for (Eigen::Index i = gradients_.cols() - 1; i >= 0; --i)
        gradients_.col(i) = quadrature_[i] * gradients_.col(0);
      ++report.gradients;
    }
    for (Eigen::Index i = 0; i < gradients_.cols(); ++i) displace(i);
  }

  Status solve(const State& z, bool extrapolate, StepReport& report) {
    detail::inlined<Scalar>([&] { start(z, extrapolate, report); });
    const auto sweep = [&] {
      if (options_.solver == StageSolver::fixed_point)
        return detail::inlined<Scalar>([&] { return fixed_point_iteration(z, report); });
      const Scalar change = newton_iteration(z, report);
      // From far off Newton's method may find another solution: what does not continue the last step starts
      // at z.
      if (!extrapolate || report.evaluations > 0 || this->changed_by(Scalar(1) / 2)) return change;
      start(z, false, report);
      const Scalar largest = std::numeric_limits<Scalar>::max();
      return change < largest ? change : largest;
    };
    return this->iterate(z, report, sweep);
  }

  Scalar displaced(Eigen::Index i) const { return detail::sum_of_absolutes(displacements_.row(i)); }
  Scalar changed(Eigen::Index i) const { return changed_[i]; }
  Scalar residual(Eigen::Index i) const {
    using std::abs;
    Scalar sum(0);
    for (Eigen::Index at = i; newton_ && at < newton_->residual.size(); at += 2 * dof())
      sum += abs(newton_->residual[at]);
    return sum;
  }

  /// Stage i's displacement Σ_j m_ij (dt b_j X_j) as the gradients have it. Adds up to changed_ by how much
  /// that differs from what it was.
  void displace(Eigen::Index i) {
    Scalar* const displacement = displacements_.data() + i * displacements_.rows();
    const Scalar* const sign = sign_.data();
    Scalar* const changed = changed_.data();
    combine(tableau_.m, i, gradients_, [=](Eigen::Index k, const Scalar& sum) {
      using std::abs;
      changed[k] += abs(sign[k] * sum - displacement[k]);
      displacement[k] = sign[k] * sum;
    });
  }

  void stage_gradient(const State& z, Eigen::Index i) {
    const Scalar* const displacement = displacements_.data() + i * displacements_.rows();
    for (Eigen::Index k = 0; k < point_.size(); ++k) point_[k] = z.vector()[k] + displacement[k];
    evaluate(i);
    gradients_.col(i) *= quadrature_[i];
  }

  /// Gradient i at point_. Its halves are exchanged, so that with sign_ it is the vector field X = (∂H/∂p,
  /// -∂H/∂q).
  void evaluate(Eigen::Index i) {
    const Eigen::Index d = dof();
    Scalar* const gradient = gradients_.data() + i * gradients_.rows();
    detail::gradient_at(hamiltonian_, point_.data(), point_.data() + d, gradient + d, gradient, d);
  }

  /// One sweep over the stages; returns the sum of the absolute values of what changed.
  Scalar fixed_point_iteration(const State& z, StepReport& report) {
    changed_.setZero();
    for (Eigen::Index i = 0; i < gradients_.cols(); ++i) {
      if (report.evaluations > 0) displace(i);
      stage_gradient(z, i);
      ++report.gradients;
    }
    return detail::sum_of_absolutes(changed_);
  }

  /// What Newton's method needs: the Hessian of a stage, and the matrix and right-hand side of all.
  struct Newton {
    Newton(Eigen::Index dof, Eigen::Index stages)
        : second(dof, false),
          hessian(2 * dof, 2 * dof),
          residual(2 * dof * stages),
          correction(residual),
          system(2 * dof * stages) {}
    detail::SecondDerivatives<H> second;
    typename detail::SecondDerivatives<H>::Matrix hessian;
    Vector<Scalar, Eigen::Dynamic> residual, correction;
    detail::LinearSystem<Scalar> system;
  };

  /// One Newton step on all stages together; returns the sum of the absolute values of the correction.
  Scalar newton_iteration(const State& z, StepReport& report) {
    using std::abs;
    Newton& work = *newton_;
    const Eigen::Index d = dof(), n = 2 * d, stages = gradients_.cols();
    for (Eigen::Index j = 0; j < stages; ++j) {
      stage_gradient(z, j);
      work.second(hamiltonian_, point_, work.hessian);
      report.gradients += 1 + work.second.gradients();
      // An infinite entry would make the correction zero, which looks like the end.
      if (!detail::all_finite(work.hessian)) return std::numeric_limits<Scalar>::quiet_NaN();
      for (Eigen::Index i = 0; i < stages; ++i) {
        const Scalar factor = tableau_.m(i, j) * quadrature_[j];
        for (Eigen::Index column = 0; column < n; ++column) {  // δ_ij I - dt a_ij J H''
          Scalar* const block = &work.system.matrix(i * n, j * n + column);
          for (Eigen::Index k = 0; k < d; ++k) {
            block[k] = -factor * work.hessian(d + k, column);
            block[d + k] = factor * work.hessian(k, column);
          }
          if (i == j) block[column] += Scalar(1);
        }
      }
    }
    for (Eigen::Index i = 0; i < stages; ++i)
      combine(tableau_.m, i, gradients_, [&](Eigen::Index k, const Scalar& sum) {
        if (k < n) work.residual[i * n + k] = sign_[k] * sum - displacements_(k, i);
      });
    work.system.factorise();
    work.system.solve(work.residual.data(), work.correction.data());
    changed_.setZero();
    for (Eigen::Index i = 0; i < stages; ++i)
      for (Eigen::Index k = 0; k < n; ++k) {
        displacements_(k, i) += work.correction[i * n + k];
        changed_[k] += abs(work.correction[i * n + k]);
      }
    return detail::sum_of_absolutes(changed_);
  }

  Dense extrapolation_;
  Vector<Scalar, Eigen::Dynamic> quadrature_;   ///< dt b_j
  Stages gradients_, started_, displacements_;  ///< the gradients times dt b_j
  Column sign_, changed_;
  Vec point_;
  std::optional<Newton> newton_;
};

}  // namespace semiexplicit
