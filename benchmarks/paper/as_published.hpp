#pragma once

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/LU>

#include <semiexplicit/semiexplicit.hpp>

// The steps as the published runs took them, which the library does not: it re-centres the copies after every
// step, keeps the physical Hamiltonian of the vortices, and refuses a step that did not converge.

namespace paper {

using namespace semiexplicit;

/// Half of a Hamiltonian: the vortices with every pair counted once under the factor 1/(4π), at half their
/// speed.
template <Hamiltonian Base>
class PairsOnce {
 public:
  using Scalar = double;
  static constexpr int Dof = Base::Dof;

  explicit PairsOnce(Base base) : base_(std::move(base)) {}

  Eigen::Index dof() const { return base_.dof(); }
  double energy(const In<double, Dof>& q, const In<double, Dof>& p) const { return base_.energy(q, p) / 2; }
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    base_.gradient(q, p, dHdq, dHdp);
    dHdq /= 2;
    dHdp /= 2;
  }

 private:
  Base base_;
};

/// A composition of Strang steps as it is written down, A(g₁/2) B(g₁) A(g₁/2) A(g₂/2) B(g₂) ..., where the
/// library merges neighbouring A flows. The map is the same; more kicks make more rounding errors, and where
/// ε is close to those, more iterations. (A list of A and B alternating needs a B of size zero between the
/// two, which costs a gradient call.)
inline Scheme<double> unmerged(const Scheme<double>& composition) {
  std::vector<double> a, b;
  for (const double weight : composition.b) {
    if (!b.empty()) b.push_back(0);
    a.push_back(weight / 2);
    b.push_back(weight);
    a.push_back(weight / 2);
  }
  return {composition.name + ", not merged", composition.order, a, b, composition.source};
}

/// The semiexplicit step on the four blocks ζ = (q, x, p, y). The next one starts from ζ' = map(ζ + Aᵀμ) +
/// Aᵀμ as it is, with the defect that the solver left. Where the solver does not converge the step is taken
/// all the same; the report's correction then says so by being no less than ε.
template <class H, class Solver>
class AsPublished {
 public:
  using Scalar = double;
  static constexpr int Dof = H::Dof;
  using State = ExtendedPoint<double, Dof>;

  AsPublished(H hamiltonian, Scheme<double> scheme, Solver solver)
      : map_(std::move(hamiltonian), std::move(scheme)),
        solver_(std::move(solver)),
        end_(PhasePoint<double, Dof>(map_.dof())),
        m_(end_.a.vector()),
        work_(solver_, m_.size()) {}

  StepReport step(State& zeta, const double& dt) {
    Residual residual{map_, zeta, end_, dt};
    const auto solved = solver_.solve(residual, m_, work_);
    if (!std::isfinite(solved.correction))
      return {.status = Status::not_finite, .evaluations = solved.evaluations};
    zeta = end_;
    return {.evaluations = solved.evaluations,
            .gradients = solved.evaluations * static_cast<std::int64_t>(map_.scheme().kicks()),
            .correction = solved.correction,
            .rate = solved.rate};
  }

 private:
  using Vec = typename PhasePoint<double, Dof>::Storage;

  /// f(μ) = A(map(ζ + Aᵀμ) + Aᵀμ), with m = (μ₁, -μ₂): (q, y) moves by +m, (x, p) by -m. Leaves the argument
  /// of A in `end`.
  struct Residual {
    Pihajoki<H>& map;
    const State& zeta;
    State& end;
    const double& dt;

    void operator()(Vec& f) {
      end = zeta;
      evaluate(f);
    }
    void operator()(const Vec& m, Vec& f) {
      end.a.vector() = zeta.a.vector() + m;
      end.b.vector() = zeta.b.vector() - m;
      evaluate(f, m);
    }
    template <class... Shift>
    void evaluate(Vec& f, const Shift&... m) {
      if (!map.step(end, dt).ok()) {
        f.setConstant(std::numeric_limits<double>::quiet_NaN());
        return;
      }
      ((end.a.vector() += m), ...);
      ((end.b.vector() -= m), ...);
      f = end.a.vector() - end.b.vector();
    }

    // Sizes of zero: nothing is forgiven as rounding, the iteration goes on to the last one allowed.
    double state_size() const { return 0; }
    bool within_rounding(double) const { return false; }
    double farthest() const { return 1e300; }  // the paper has no such rule
    double rounding_level() const { return 0; }
  };

  Pihajoki<H> map_;
  Solver solver_;
  State end_;
  Vec m_;
  typename Solver::template Workspace<Vec> work_;
};

/// Gauss-Legendre with Newton's iteration on the stage values, started at z each step, until the Euclidean
/// norm of the correction (of all stages together) is below ε; at most 100 iterations, after which the step
/// is taken as it is.
///
/// The published counts (up to 16.66 a step) are those of a Jacobian with one block transposed: of the
/// derivative [H_pq H_pp; -H_qq -H_qp] of the vector field, H_pq in the upper left is replaced by H_qp. The
/// iteration then converges linearly. With `transposed_block` false it is Newton's method proper.
template <class H>
class GaussAsPublished {
 public:
  using Scalar = double;
  static constexpr int Dof = H::Dof;
  using State = PhasePoint<double, Dof>;

  GaussAsPublished(H hamiltonian, int stages, double epsilon, bool transposed_block = true)
      : hamiltonian_(std::move(hamiltonian)),
        tableau_(stages),
        stages_(stages),
        epsilon_(epsilon),
        transposed_block_(transposed_block),
        field_(2 * dof(), stages),
        values_(field_.size()),
        residual_(values_),
        matrix_(field_.size(), field_.size()),
        derivative_(2 * dof(), 2 * dof()) {}

  StepReport step(State& z, const double& dt) {
    const Eigen::Index n = 2 * dof();
    StepReport report;
    values_ = z.vector().replicate(stages_, 1);
    do {
      for (int j = 0; j < stages_; ++j) {
        const Vec stage = values_.segment(j * n, n);
        field_.col(j) = field(stage, report);
        differentiate(stage, report);
        for (int i = 0; i < stages_; ++i) {
          auto block = matrix_.block(i * n, j * n, n, n);
          block = -dt * a(i, j) * derivative_;
          if (i == j) block.diagonal().array() += 1;
        }
      }
      for (int i = 0; i < stages_; ++i) {
        auto part = residual_.segment(i * n, n);
        part = z.vector() - values_.segment(i * n, n);
        for (int j = 0; j < stages_; ++j) part += dt * a(i, j) * field_.col(j);
      }
      lu_.compute(matrix_);
      residual_ = lu_.solve(residual_).eval();
      values_ += residual_;
      report.correction = residual_.norm();
      ++report.evaluations;
    } while (report.correction >= epsilon_ && report.evaluations < 100);

    Vec next = z.vector();
    for (int j = 0; j < stages_; ++j) next += dt * tableau_.b[j] * field(values_.segment(j * n, n), report);
    if (next.allFinite())
      z.vector() = next;
    else
      report.status = Status::not_finite;
    return report;
  }

 private:
  using Vec = typename State::Storage;

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  double a(int i, int j) const { return tableau_.m(i, j) * tableau_.b[j]; }

  /// X = (∂H/∂p, -∂H/∂q).
  Vec field(const Vec& z, StepReport& report) const {
    const State at(z.head(dof()), z.tail(dof()));
    State gradient(dof());
    hamiltonian_.gradient(at.q(), at.p(), gradient.q(), gradient.p());
    ++report.gradients;
    return State(gradient.p(), -gradient.q()).vector();
  }

  void differentiate(Vec z, StepReport& report) {
    constexpr double h = 1e-5;
    for (Eigen::Index k = 0; k < z.size(); ++k) {
      const double middle = z[k];
      z[k] = middle + h;
      const Vec ahead = field(z, report);
      z[k] = middle - h;
      derivative_.col(k) = (ahead - field(z, report)) / (2 * h);
      z[k] = middle;
    }
    if (transposed_block_) derivative_.topLeftCorner(dof(), dof()).transposeInPlace();
  }

  H hamiltonian_;
  GaussTableau<double> tableau_;
  int stages_;
  double epsilon_;
  bool transposed_block_;
  Eigen::MatrixXd field_;
  Eigen::VectorXd values_, residual_;
  Eigen::MatrixXd matrix_, derivative_;
  Eigen::PartialPivLU<Eigen::MatrixXd> lu_;
};

}  // namespace paper
