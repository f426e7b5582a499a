#pragma once

#include <cmath>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/simd.hpp>
#include <semiexplicit/steppers/gauss_legendre.hpp>

#ifdef SEMIEXPLICIT_HAS_PACKS

namespace semiexplicit {

/// GaussLegendre with its stages side by side in the lanes of a SIMD register: all stages' gradients are one call with packs
/// for numbers (HasPackGradient). It is made for systems of a few degrees of freedom, which leave the lanes empty otherwise.
///
/// The same method, options and reports as GaussLegendre, but for the iteration: all stages from the old values of all
/// others (Jacobi), and no Newton mode. `gradients` counts one a stage, as if each had been called for alone.
/// Memory: three arrays of 2d packs, 48 numbers a degree of freedom.
///
/// Sources: as GaussLegendre; the stages in lanes: Antoñana, Alberdi, Makazaga, Murua, arXiv:2204.01697 (IRKGL16-SIMD).
template <class H>
class GaussLegendreLanes {
  static_assert(HasPackGradient<H>,
                "GaussLegendreLanes needs a gradient that takes packs; see HasPackGradient in core/simd.hpp");

 public:
  using Scalar = typename H::Scalar;
  static constexpr int Dof = H::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "GaussLegendreLanes";

  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8, max_iterations ≥ 1, tolerance ≥ 0 and solver is fixed_point.
  GaussLegendreLanes(H hamiltonian, GaussLegendreOptions options = {})
      : hamiltonian_(std::move(hamiltonian)),
        options_(options),
        tableau_(options.stages),
        update_(dof()),
        gradients_(at(size())),
        points_(gradients_),
        displacements_(gradients_) {
    if (!(options.max_iterations >= 1 && options.tolerance >= 0 && std::isfinite(options.tolerance)))
      throw std::invalid_argument(
          "GaussLegendreLanes: max_iterations must be 1 or more, and tolerance 0 or more and finite");
    if (options.solver != StageSolver::fixed_point)
      throw std::invalid_argument(
          "GaussLegendreLanes: only StageSolver::fixed_point; GaussLegendre has Newton's method");
    for (int j = 0; j < 8; ++j) extrapolation_[j] = weight_[j] = Scalar(0);
    for (int j = 0; j < options.stages; ++j)
      extrapolation_[j] = column([&](int i) { return tableau_.extrapolation(i, j); });
  }

  /// One step of size dt, which may be negative; z is untouched unless the report is ok(). `evaluations` are iterations,
  /// `correction` is the sum of the absolute values of what they last changed in the stages.
  StepReport step(State& z, const Scalar& dt) {
    StepReport report;
    if (!detail::valid_step(dt))
      report.status = Status::invalid_step;
    else if (gradients_.empty())
      report.status = Status::invalid_stepper;
    else if (z.vector().size() != size())
      report.status = Status::invalid_state;
    if (!report.ok()) return report;

    const bool goes_on = options_.extrapolate && last_dt_ == dt && update_.continues(z);
    last_dt_ = Scalar(0);  // nothing to extrapolate from until the step is done, also where a gradient throws
    scale_weights(dt);
    report.status = with_stages([&](auto stages) {
      start<stages.value>(z, goes_on, report);
      return iterate<stages.value>(z, report);
    });
    if (report.status == Status::not_finite && !z.vector().allFinite()) report.status = Status::invalid_state;
    if (!report.ok()) return report;
    const Eigen::Index d = dof();
    const bool finite = update_.update(z, [&](Eigen::Index i) {
      return i < d ? reduce(quadrature_ * gradients_[at(d + i)])
                   : -reduce(quadrature_ * gradients_[at(i - d)]);
    });
    if (finite)
      last_dt_ = dt;
    else
      report.status = Status::not_finite;
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const { return 1 + std::int64_t{options_.max_iterations} * options_.stages; }

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
    for (Many& gradient : gradients_) {  // the next step's stages are extrapolated from them
      alignas(Many) Scalar stages[static_cast<std::size_t>(width)];
      gradient.copy_to(stages, std::experimental::vector_aligned);
      for (Scalar& stage : stages) visit(stage);
      gradient.copy_from(stages, std::experimental::vector_aligned);
    }
    visit(last_dt_);
  }

 private:
  using Many = Pack<Scalar>;
  static constexpr int width = static_cast<int>(Many::size());
  static_assert(width >= 8, "one lane a stage");

  Eigen::Index size() const { return 2 * dof(); }
  static std::size_t at(Eigen::Index i) { return static_cast<std::size_t>(i); }

  /// value(i) in lane i of every stage, and zero beyond.
  template <class Value>
  Many column(const Value& value) const {
    return Many([&](auto i) {
      return static_cast<int>(i) < options_.stages ? Scalar(value(static_cast<int>(i))) : Scalar(0);
    });
  }

  void scale_weights(const Scalar& dt) {
    if (weights_dt_ == dt) return;
    for (int j = 0; j < options_.stages; ++j)
      weight_[j] = column([&](int i) { return tableau_.m(i, j) * (dt * tableau_.b[j]); });
    quadrature_ = column([&](int j) { return dt * tableau_.b[j]; });
    weights_dt_ = dt;
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
    stages.copy_to(value, std::experimental::vector_aligned);
    Many even = matrix[0] * value[0], odd = matrix[1] * value[1];  // two chains: half the latency
    for (int j = 2; j < Stages; j += 2) {
      even += matrix[j] * value[j];
      odd += matrix[j + 1] * value[j + 1];
    }
    return even + odd;
  }

  void evaluate(StepReport& report) {
    const std::size_t d = at(dof());
    hamiltonian_.gradient(static_cast<const Many*>(points_.data()),
                          static_cast<const Many*>(points_.data() + d), gradients_.data(),
                          gradients_.data() + d);
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

  template <int Stages>
  Status iterate(const State& z, StepReport& report) {
    using std::isfinite;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar size_of_state = detail::sum_of_absolutes(z.vector());
    Scalar previous(0);
    for (;;) {
      Many moved = Scalar(0), displaced = Scalar(0);  // sums of absolute values
      detail::inlined<Scalar>([&] {
        move<Stages>(z, moved, displaced);
        evaluate(report);
      });
      ++report.evaluations;
      if (report.evaluations > 1) {  // before, no change can be seen
        const Scalar change = reduce(moved);
        report.correction = static_cast<double>(change);
        if (previous > Scalar(0)) report.rate = static_cast<double>(change / previous);
        if (!isfinite(change)) return Status::not_finite;
        if (change == Scalar(0) || change < Scalar(options_.tolerance)) return Status::success;
        if (previous > Scalar(0) && change >= previous &&
            change <= 100 * epsilon * (size_of_state + reduce(displaced)))
          return options_.tolerance == 0 ? Status::success : Status::rounding_limited;
        previous = change;
      }
      if (report.evaluations >= options_.max_iterations) return Status::no_convergence;
    }
  }

  /// The stages' displacements, z + dt Σ_j a_ij X_j - z, and points from their gradients; adds up the absolute
  /// values of the displacements and of what changed in them.
  template <int Stages>
  void move(const State& z, Many& moved, Many& displaced) {
    const std::size_t d = at(dof());
    const Scalar* const state = z.vector().data();
    Many weight[std::size_t(Stages)];
    for (int j = 0; j < Stages; ++j) weight[j] = weight_[j];
    const auto put = [&](std::size_t i, const Many& displacement) {
      using std::abs;
      moved += abs(displacement - displacements_[i]);
      displaced += abs(displacement);
      displacements_[i] = displacement;
      points_[i] = state[i] + displacement;
    };
    for (std::size_t i = 0; i < d; ++i) {
      put(i, combine<Stages>(weight, gradients_[d + i]));
      put(d + i, -combine<Stages>(weight, gradients_[i]));
    }
  }

  H hamiltonian_;
  GaussLegendreOptions options_;
  GaussTableau<Scalar> tableau_;
  CompensatedUpdate<Scalar, Dof> update_;
  std::vector<Many> gradients_, points_, displacements_;
  Many extrapolation_[8], weight_[8], quadrature_;  ///< matrices by columns; dt is in the last two
  Scalar last_dt_ = Scalar(0), weights_dt_ = Scalar(0);
};

}  // namespace semiexplicit

#endif
