#pragma once

#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/simd.hpp>
#include <semiexplicit/steppers/detail/gauss_shell.hpp>

namespace semiexplicit {

/// GaussLegendre with its stages side by side in the lanes of a SIMD register: all stages' gradients are one
/// call with packs for numbers (HasPackGradient). It is made for systems of a few degrees of freedom, which
/// leave the lanes empty otherwise.
///
/// The same method, options and reports as GaussLegendre, but for the iteration: all stages from the old
/// values of all others (Jacobi), and no Newton mode. `gradients` counts one a stage, as if each had been
/// called for alone. Memory: four arrays of 2d packs, 64 numbers a degree of freedom. step() and the
/// accessors are in detail::GaussShell.
///
/// Sources: as GaussLegendre; the stages in lanes: Antoñana, Alberdi, Makazaga, Murua, arXiv:2204.01697
/// (IRKGL16-SIMD).
template <class H>
class GaussLegendreLanes : public detail::GaussShell<GaussLegendreLanes<H>, H> {
  static_assert(HasPackGradient<H>,
                "GaussLegendreLanes needs a gradient that takes packs: make gradient() a template that only "
                "indexes its arguments, and add `using PackGradientOf = <your type>;` (HasPackGradient); or "
                "take GaussLegendre");
  using Shell = detail::GaussShell<GaussLegendreLanes<H>, H>;
  friend Shell;

 public:
  using Shell::Dof, Shell::dof;
  using typename Shell::Scalar, typename Shell::State;
  static constexpr const char* name = "GaussLegendreLanes";

  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8, max_iterations ≥ 1, tolerance ≥ 0 and solver is
  /// fixed_point.
  GaussLegendreLanes(H hamiltonian, GaussLegendreOptions options = {})
      : Shell(std::move(hamiltonian), options),
        gradients_(at(2 * dof())),
        points_(gradients_),
        displacements_(gradients_),
        changes_(gradients_) {
    if (options.solver != StageSolver::fixed_point)
      throw std::invalid_argument(
          "GaussLegendreLanes: only StageSolver::fixed_point; GaussLegendre has Newton's method");
    for (int j = 0; j < 8; ++j) extrapolation_[j] = weight_[j] = Scalar(0);
    for (int j = 0; j < options.stages; ++j) weight_[j] = column([&](int i) { return tableau_.m(i, j); });
  }

 private:
  using Shell::hamiltonian_, Shell::options_, Shell::tableau_;
  using Many = Pack<Scalar>;
  static constexpr int width = static_cast<int>(Many::size());
  static_assert(width >= 8, "one lane a stage");

  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// value(i) in lane i of every stage, and zero beyond.
  template <class Value>
  Many column(const Value& value) const {
    return Many([&](auto i) {
      return static_cast<int>(i) < options_.stages ? Scalar(value(static_cast<int>(i))) : Scalar(0);
    });
  }

  Eigen::Index size() const { return static_cast<Eigen::Index>(gradients_.size()); }

  void scale_weights(const Scalar& dt) {
    quadrature_ = column([&](int j) { return dt * tableau_.b[j]; });
  }

  void follow_by(const Scalar& ratio) {
    const Many used = column([](int) { return 1; });
    tableau_.lagrange(Many(1 + ratio * column([&](int i) { return tableau_.c[i]; })), extrapolation_);
    for (int j = 0; j < options_.stages; ++j) extrapolation_[j] *= used;
  }

  Scalar increment(Eigen::Index i) const {
    const Eigen::Index d = dof();
    return i < d ? reduce(quadrature_ * gradients_[at(d + i)]) : -reduce(quadrature_ * gradients_[at(i - d)]);
  }

  Scalar displaced(Eigen::Index i) const {
    using std::abs;
    return reduce(abs(displacements_[at(i)]));
  }
  Scalar changed(Eigen::Index i) const { return reduce(changes_[at(i)]); }
  Scalar residual(Eigen::Index) const { return Scalar(0); }  // it has no Newton's method

  template <class Visitor>
  void visit_stages(Visitor& visit) {
    for (Many& gradient : gradients_) {
      alignas(Many) Scalar stages[static_cast<std::size_t>(width)];
      gradient.copy_to(stages, detail::aligned);
      for (Scalar& stage : stages) visit(stage);
      gradient.copy_from(stages, detail::aligned);
    }
  }

  Status solve(const State& z, bool extrapolate, StepReport& report) {
    return with_stages([&](auto stages) {
      start<stages.value>(z, extrapolate, report);
      const auto sweep = [&] {
        Many changed = Scalar(0);
        detail::inlined<Scalar>([&] {
          move<stages.value>(z, changed);
          evaluate(report);
        });
        return reduce(changed);
      };
      return this->iterate(z, report, sweep);
    });
  }

  /// The number of stages, rounded up to an even one, as a constant: that keeps the weights in registers.
  template <class F>
  Status with_stages(const F& f) const {
    if (options_.stages <= 2) return f(std::integral_constant<int, 2>());
    if (options_.stages <= 4) return f(std::integral_constant<int, 4>());
    if (options_.stages <= 6) return f(std::integral_constant<int, 6>());
    return f(std::integral_constant<int, 8>());
  }

  /// Σ_j matrix_j stage_j: in lane i what the matrix makes of the stages' values.
  template <int Stages>
  static Many combine(const Many* matrix, const Many& stages) {
    alignas(Many) Scalar value[static_cast<std::size_t>(width)];
    stages.copy_to(value, detail::aligned);
    Many even = matrix[0] * value[0], odd = matrix[1] * value[1];  // two chains: half the latency
    for (int j = 2; j < Stages; j += 2) {
      even += matrix[j] * value[j];
      odd += matrix[j + 1] * value[j + 1];
    }
    return even + odd;
  }

  void evaluate(StepReport& report) {
    const std::size_t d = at(dof());
    const Many *q = points_.data(), *p = q + d;
    Many *dHdq = gradients_.data(), *dHdp = dHdq + d;
    hamiltonian_.gradient(q, p, dHdq, dHdp);
    report.gradients += options_.stages;
  }

  /// First values of the stages' gradients.
  template <int Stages>
  void start(const State& z, bool extrapolate, StepReport& report) {
    if (extrapolate) {
      for (auto& gradient : gradients_) gradient = combine<Stages>(extrapolation_, gradient);
    } else {
      for (Eigen::Index i = 0; i < size(); ++i) points_[at(i)] = z.vector()[i];
      evaluate(report);
      report.gradients += 1 - options_.stages;  // the lanes hold the same
    }
    for (auto& displacement : displacements_) displacement = Scalar(0);
  }

  /// The stages' displacements, z + dt Σ_j a_ij X_j - z, and points from their gradients; adds up the
  /// absolute values of what changed in them.
  template <int Stages>
  void move(const State& z, Many& changed) {
    const std::size_t d = at(dof());
    const Scalar* const state = z.vector().data();
    const Many quadrature = quadrature_;
    Many weight[std::size_t(Stages)];
    for (int j = 0; j < Stages; ++j) weight[j] = weight_[j];
    const auto put = [&](std::size_t i, const Many& displacement) {
      using std::abs;
      changes_[i] = abs(displacement - displacements_[i]);
      changed += changes_[i];
      displacements_[i] = displacement;
      points_[i] = state[i] + displacement;
    };
    for (std::size_t i = 0; i < d; ++i) {
      put(i, combine<Stages>(weight, quadrature * gradients_[d + i]));
      put(d + i, -combine<Stages>(weight, quadrature * gradients_[i]));
    }
  }

  std::vector<Many> gradients_, points_, displacements_, changes_;
  Many extrapolation_[8], weight_[8];  ///< matrices by columns
  Many quadrature_ = Scalar(0);        ///< dt b_j
};

}  // namespace semiexplicit
