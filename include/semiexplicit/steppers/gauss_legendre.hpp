#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include <Eigen/Core>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/detail/dense_lu.hpp>
#include <semiexplicit/steppers/detail/gauss_tableau.hpp>
#include <semiexplicit/steppers/pihajoki.hpp>

namespace semiexplicit {

/// How GaussLegendre finds its stages.
enum class StageSolver {
  fixed_point,  ///< each stage from the newest values of the others: no derivatives, O(s² d) work an iteration
  newton        ///< full Newton with a dense 2ds × 2ds matrix each iteration: for small problems
};

/// What a GaussLegendre stepper is made with.
struct GaussLegendreOptions {
  int stages = 2;  ///< 1 to 8; order 2 · stages; 1 is the implicit midpoint rule
  StageSolver solver = StageSolver::fixed_point;
  double tolerance =
      0;  ///< bound on the sum of the stages' last changes, absolute; 0: until rounding stops it
  int max_iterations = 100;  ///< the step is refused beyond
  bool extrapolate = true;  ///< start the stages from the last step's collocation polynomial, instead of at z

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("stages", stages);
    list("stage solver", solver);
    list("tolerance", tolerance);
    list("max_iterations", max_iterations);
    list("extrapolate", extrapolate);
  }
};

/// The implicit Gauss-Legendre Runge-Kutta method: symplectic, symmetric, keeps quadratic invariants, order 2s. The strongest
/// general rival of the semiexplicit method, and therefore written to win: extrapolated starting values, Gauss-Seidel
/// iteration that stops at the rounding floor, compensated update.
///
/// Newton's method takes the Hessian of H where it has one (HasHessian), else central differences of the gradient (4d calls a
/// stage). Memory: (3s + 5) vectors of length 2d; Newton's method 2 (2ds)² numbers more, and its factorisation may use the heap. Its
/// step ends with the gradients from before the last correction, so it wants a tight tolerance.
///
/// Sources: Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3 and VIII.6; Antoñana, Makazaga, Murua,
/// Numer. Algorithms 76 (2017) 861.
template <class H>
class GaussLegendre {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "GaussLegendre";

  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8, max_iterations ≥ 1 and tolerance ≥ 0.
  GaussLegendre(H hamiltonian, GaussLegendreOptions options = {})
      : hamiltonian_(std::move(hamiltonian)),
        options_(options),
        tableau_(options.stages),
        update_(dof()),
        weights_(options.stages, options.stages),
        gradients_(Stages::Zero(small ? padded : 2 * dof(), options.stages)),
        started_(gradients_),
        displacements_(gradients_),
        sign_(gradients_.col(0)),
        displaced_(sign_),
        point_(State(dof()).vector()) {
    sign_.head(dof()).setOnes();
    sign_.segment(dof(), dof()).setConstant(Scalar(-1));
    if (!(options.max_iterations >= 1 && options.tolerance >= 0 && std::isfinite(options.tolerance)))
      throw std::invalid_argument(
          "GaussLegendre: max_iterations must be 1 or more, and tolerance 0 or more and finite");
    if (options.solver == StageSolver::newton) newton_.emplace(2 * dof(), options.stages);
  }

  /// One step of size dt, which may be negative; z is untouched unless the report is ok(). `evaluations` are iterations,
  /// `correction` is the sum of the absolute values of what they last changed in the stages.
  StepReport step(State& z, const Scalar& dt) {
    using std::isfinite;
    StepReport report;
    if (!detail::valid_step(dt))
      report.status = Status::invalid_step;
    else if (weights_.size() == 0)
      report.status = Status::invalid_stepper;
    else if (z.vector().size() != point_.size())
      report.status = Status::invalid_state;
    if (!report.ok()) return report;

    const bool goes_on = options_.extrapolate && last_dt_ == dt && update_.continues(z);
    last_dt_ = Scalar(0);  // nothing to extrapolate from until the step is done, also where a gradient throws
    scale_weights(dt);
    detail::inlined<Scalar>([&] { start(z, goes_on, report); });
    report.status = iterate(z, report);
    if (report.status == Status::not_finite && !z.vector().allFinite()) report.status = Status::invalid_state;
    if (!report.ok()) return report;
    const bool finite = update_.update(z, [&](Eigen::Index i) {
      Scalar sum(0);
      for (Eigen::Index j = 0; j < gradients_.cols(); ++j) sum += (dt * tableau_.b[j]) * gradients_(i, j);
      return sign_[i] * sum;
    });
    if (finite)
      last_dt_ = dt;
    else
      report.status = Status::not_finite;
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const {
    const bool differences = options_.solver == StageSolver::newton && !HasHessian<H>;
    return 1 + std::int64_t{options_.max_iterations} * options_.stages * (differences ? 1 + 4 * dof() : 1);
  }

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const GaussLegendreOptions& options() const { return options_; }
  const GaussTableau<Scalar>& tableau() const { return tableau_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    options_.describe(list);
    list.function("Hamiltonian", detail::GradientSize(hamiltonian()));
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
    visit(gradients_);  // the next step's stages are extrapolated from them
    visit(last_dt_);
  }

 private:
  using Vec = typename State::Storage;
  /// Columns of a few numbers are padded with zeros to whole registers, where sums over the stages then stay.
  static constexpr bool small = Dof != Eigen::Dynamic && Dof <= 32;
  static constexpr int padded = small ? (2 * Dof + 3) / 4 * 4 : twice(Dof);
  using Column = Vector<Scalar, padded>;
  using Stages = Eigen::Matrix<Scalar, padded, Eigen::Dynamic>;  // a column a stage
  using Dense = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  void scale_weights(const Scalar& dt) {
    if (weights_dt_ == dt) return;
    for (Eigen::Index i = 0; i < weights_.rows(); ++i)
      for (Eigen::Index j = 0; j < weights_.cols(); ++j)
        weights_(i, j) = tableau_.m(i, j) * (dt * tableau_.b[j]);
    weights_dt_ = dt;
  }

  /// put(k, Σ_j matrix_ij stages_kj) for every k: row i of a matrix over the stages, in blocks that stay in registers.
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
        combine(tableau_.extrapolation, i, started_,
                [to](Eigen::Index k, const Scalar& sum) { to[k] = sum; });
      }
    } else {
      point_ = z.vector();
      evaluate(0);
      for (Eigen::Index i = 1; i < gradients_.cols(); ++i) gradients_.col(i) = gradients_.col(0);
      ++report.gradients;
    }
    for (Eigen::Index i = 0; i < gradients_.cols(); ++i) displace(i);
  }

  Status iterate(const State& z, StepReport& report) {
    using std::isfinite;
    const Scalar all = detail::sum_of_absolutes(z.vector());
    const Scalar size = size_without_time(z, all);
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const bool newton = options_.solver == StageSolver::newton;
    Scalar previous(0), least = std::numeric_limits<Scalar>::infinity();
    int since_least = 0;
    for (;;) {
      // The first fixed-point sweep only evaluates the gradients at the starting values: a change is yet to be seen.
      const bool seen = newton || report.evaluations > 0;
      const Scalar change = newton
                                ? newton_iteration(z, report)
                                : detail::inlined<Scalar>([&] { return fixed_point_iteration(z, report); });
      ++report.evaluations;
      if (seen) {
        report.correction = static_cast<double>(change);
        if (previous > Scalar(0)) report.rate = static_cast<double>(change / previous);
        if (!isfinite(change)) return Status::not_finite;
        if (change == Scalar(0) || change < Scalar(options_.tolerance)) return Status::success;
        if (previous > Scalar(0) && change >= previous &&
            change <= 100 * epsilon * (size + detail::sum_of_absolutes(displacements_.reshaped())))
          return options_.tolerance == 0 ? Status::success : Status::rounding_limited;
        // The rounding of a late time may be far above that of the state: believed where nothing improves any more.
        since_least = change < least ? 0 : since_least + 1;
        if (change < least) least = change;
        if (InExtendedPhaseSpace<H> && since_least >= 8 &&
            change <= 100 * epsilon * (all + detail::sum_of_absolutes(displacements_.reshaped())))
          return options_.tolerance == 0 ? Status::success : Status::rounding_limited;
        previous = change;
      }
      if (report.evaluations >= options_.max_iterations) return Status::no_convergence;
    }
  }

  /// Σ |zᵢ| without (t, p_t), where the time is a coordinate; `all` elsewhere.
  static Scalar size_without_time(const State& z, const Scalar& all) {
    if constexpr (InExtendedPhaseSpace<H>)
      return detail::sum_of_absolutes(z.q().head(z.dof() - 1)) +
             detail::sum_of_absolutes(z.p().head(z.dof() - 1));
    else
      return all;
  }

  /// Stage i's displacement dt Σ_j a_ij X_j as the gradients have it. Adds up to displaced_ by how much that differs from
  /// what it was.
  void displace(Eigen::Index i) {
    Scalar* const displacement = displacements_.data() + i * displacements_.rows();
    const Scalar* const sign = sign_.data();
    Scalar* const displaced = displaced_.data();
    combine(weights_, i, gradients_, [=](Eigen::Index k, const Scalar& sum) {
      using std::abs;
      displaced[k] += abs(sign[k] * sum - displacement[k]);
      displacement[k] = sign[k] * sum;
    });
  }

  void stage_gradient(const State& z, Eigen::Index i) {
    const Scalar* const displacement = displacements_.data() + i * displacements_.rows();
    for (Eigen::Index k = 0; k < point_.size(); ++k) point_[k] = z.vector()[k] + displacement[k];
    evaluate(i);
  }

  /// Gradient i at point_. Its halves are exchanged, so that with sign_ it is the vector field X = (∂H/∂p, -∂H/∂q).
  void evaluate(Eigen::Index i) {
    const Eigen::Index d = dof();
    Scalar* const gradient = gradients_.data() + i * gradients_.rows();
    detail::gradient_at(hamiltonian_, point_.data(), point_.data() + d, gradient + d, gradient, d);
  }

  /// One sweep over the stages; returns the sum of the absolute values of what changed.
  Scalar fixed_point_iteration(const State& z, StepReport& report) {
    displaced_.setZero();
    for (Eigen::Index i = 0; i < gradients_.cols(); ++i) {
      if (report.evaluations > 0) displace(i);
      stage_gradient(z, i);
      ++report.gradients;
    }
    return detail::sum_of_absolutes(displaced_);
  }

  /// What Newton's method needs: the Hessian of a stage, and the matrix and right-hand side of all.
  struct Newton {
    Newton(Eigen::Index size, Eigen::Index stages)
        : hessian(size, size),
          matrix(size * stages, size * stages),
          residual(size * stages),
          lu(size * stages),
          ahead(Vec::Zero(size)),
          behind(ahead) {}
    Eigen::Matrix<Scalar, twice(Dof), twice(Dof)> hessian;
    Dense matrix;
    Vector<Scalar, Eigen::Dynamic> residual;
    detail::DenseLu<Scalar> lu;
    Vec ahead, behind;
  };

  /// One Newton step on all stages together; returns the sum of the absolute values of the correction.
  Scalar newton_iteration(const State& z, StepReport& report) {
    Newton& work = *newton_;
    const Eigen::Index d = dof(), n = 2 * d, stages = gradients_.cols();
    for (Eigen::Index j = 0; j < stages; ++j) {
      stage_gradient(z, j);
      ++report.gradients;
      stage_hessian(report);
      for (Eigen::Index i = 0; i < stages; ++i) {
        const Scalar factor = weights_(i, j);
        auto block = work.matrix.block(i * n, j * n, n, n);  // δ_ij I - dt a_ij J H''
        block.topRows(d) = -factor * work.hessian.bottomRows(d);
        block.bottomRows(d) = factor * work.hessian.topRows(d);
        if (i == j) block.diagonal().array() += Scalar(1);
      }
    }
    for (Eigen::Index i = 0; i < stages; ++i)
      combine(weights_, i, gradients_, [&](Eigen::Index k, const Scalar& sum) {
        if (k < n) work.residual[i * n + k] = sign_[k] * sum - displacements_(k, i);
      });
    work.lu.compute(work.matrix);
    work.residual = work.lu.solve(work.residual).eval();
    for (Eigen::Index i = 0; i < stages; ++i)
      displacements_.col(i).head(n) += work.residual.segment(i * n, n);
    return detail::sum_of_absolutes(work.residual);
  }

  /// The Hessian at point_.
  void stage_hessian(StepReport& report) {
    Newton& work = *newton_;
    const Eigen::Index d = dof();
    if constexpr (HasHessian<H>) {
      using Half = const Vector<Scalar, Dof>;
      hamiltonian_.hessian(Eigen::Map<Half>(point_.data(), d), Eigen::Map<Half>(point_.data() + d, d),
                           work.hessian);
    } else {
      using std::cbrt;
      const Scalar size = detail::norm(point_);
      const Scalar h = cbrt(Eigen::NumTraits<Scalar>::epsilon()) * (size > Scalar(0) ? size : Scalar(1));
      for (Eigen::Index k = 0; k < 2 * d; ++k) {
        const Scalar middle = point_[k];
        point_[k] = middle + h;
        detail::gradient_at(hamiltonian_, point_.data(), work.ahead.data(), d);
        point_[k] = middle - h;
        detail::gradient_at(hamiltonian_, point_.data(), work.behind.data(), d);
        point_[k] = middle;
        work.hessian.col(k) = (work.ahead - work.behind) / (2 * h);
      }
      report.gradients += 4 * d;
    }
  }

  H hamiltonian_;
  GaussLegendreOptions options_;
  GaussTableau<Scalar> tableau_;
  CompensatedUpdate<Scalar, Dof> update_;
  Dense weights_;  ///< dt a_ij, for steps of weights_dt_
  Stages gradients_, started_, displacements_;
  Column sign_, displaced_;
  Vec point_;
  Scalar last_dt_ = Scalar(0), weights_dt_ = Scalar(0);
  std::optional<Newton> newton_;
};

}  // namespace semiexplicit
