#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/derivatives/hessian.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/detail/gauss_tableau.hpp>

namespace semiexplicit {

/// How GaussLegendre finds its stages.
enum class StageSolver {
  fixed_point,  ///< each stage from the newest values of the others: no derivatives, O(s² d) work an
                ///< iteration
  newton  ///< full Newton with a dense 2ds × 2ds matrix each iteration: for small problems; by steps in
          ///< which the motion turns by a radian and more it may find another solution of the stages
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

namespace detail {

/// What the Gauss-Legendre steppers have in common: everything but the stages. A Stepper derives from it,
/// befriends it, and has
///
///     Eigen::Index size() const;                 // 2d, or 0 where the stages were moved from
///     void scale_weights(const Scalar& dt);      // dt b_j, for another dt than before
///     void follow_by(const Scalar& ratio);       // how to extrapolate to a step so many times as long
///     Status solve(const State& z, bool extrapolate, StepReport& report);  // then iterate()
///     Scalar increment(Eigen::Index i) const;    // Σ_j dt b_j X_ji
///     Scalar displaced(Eigen::Index i) const;    // Σ_j of the absolute values of displacement i, from z
///     Scalar changed(Eigen::Index i) const;      // the same of what the last sweep changed in it
///     Scalar residual(Eigen::Index i) const;     // of Newton's equations, before the last correction, or 0
///     void visit_stages(Visitor& visit);  // the gradients, which the next stages are extrapolated from
template <class Stepper, class H>
class GaussShell {
 public:
  using Scalar = typename HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static_assert(is_in_one_process<H>());
  using Vec = typename State::Storage;

  /// One step of size dt, which may be negative; z is untouched unless the report is ok(). `evaluations` are
  /// iterations, `correction` is the sum of the absolute values of what they last changed in the stages.
  StepReport step(State& z, const Scalar& dt) {
    StepReport report{.status =
                          status_at_start(dt, stages().size() != 0, z.vector().size() == stages().size())};
    if (!report.ok()) return report;

    // A polynomial of degree s - 1 grows fast behind the step that it is of.
    const Scalar ratio = last_dt_ == Scalar(0) ? Scalar(0) : Scalar(dt / last_dt_);
    const bool goes_on =
        options_.extrapolate && ratio > Scalar(0) && ratio <= Scalar(2) && update_.continues(z);
    if (goes_on && ratio != ratio_) stages().follow_by(ratio_ = ratio);
    last_dt_ = Scalar(0);  // nothing to extrapolate from until the step is done, also where a gradient throws
    if (weights_dt_ != dt) stages().scale_weights(dt);
    weights_dt_ = dt;
    report.status = stages().solve(z, goes_on, report);
    if (report.ok()) {
      if (update_.update(z, [&](Eigen::Index i) { return stages().increment(i); }))
        last_dt_ = dt;
      else
        report.status = Status::not_finite;
    }
    if (!report.ok() && !detail::all_finite(z.vector())) report.status = Status::invalid_state;
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const {
    const auto hessian =
        options_.solver == StageSolver::newton ? SecondDerivatives<H>::max_gradients(dof()) : Eigen::Index{0};
    return 1 + 3 * (std::int64_t{1} + options_.max_iterations) +
           std::int64_t{options_.max_iterations} * options_.stages * (1 + hessian);
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
    list.function("Hamiltonian", GradientSize(hamiltonian()));
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
    stages().visit_stages(visit);
    visit(last_dt_);
  }

 protected:
  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8, max_iterations ≥ 1 and tolerance ≥ 0.
  GaussShell(H hamiltonian, const GaussLegendreOptions& options)
      : hamiltonian_(std::move(hamiltonian)),
        options_(options),
        tableau_(options.stages),
        update_(dof()),
        least_(Vec::Zero(2 * dof())),
        at_(least_),
        felt_(least_),
        passed_on_(least_),
        field_(least_),
        other_(least_) {
    if (!(options.max_iterations >= 1 && options.tolerance >= 0 && std::isfinite(options.tolerance)))
      throw std::invalid_argument(std::string(Stepper::name) +
                                  ": max_iterations must be 1 or more, and tolerance 0 or more and finite");
  }

  /// Repeats sweep(), which returns the sum of the absolute values of what it changed in the stages'
  /// displacements from z, until that is zero, within the tolerance, or nothing beside them in any units or
  /// but the rounding of z and the displacements, in each entry as well.
  template <class Sweep>
  Status iterate(const State& z, StepReport& report, const Sweep& sweep) {
    using std::isfinite;
    const auto displaced = [&] {
      Scalar sum(0);
      for (Eigen::Index i = 0; i < least_.size(); ++i) sum += stages().displaced(i);
      return sum;
    };
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar size = sum_of_absolutes(z.vector()), nothing = epsilon * (epsilon * (epsilon * size));
    Scalar previous(0), least = std::numeric_limits<Scalar>::infinity();
    int since_least = 0;
    Scalar earlier[] = {least, least};  // what that was two and one of some sweeps ago
    int feels = 0;
    Scalar felt_at(0);  // displaced() then
    // Only of changes that are small beside the displacements their rounding is felt, too: far out it moves
    // the field at z by as much as anything.
    bool felt_moved = false;
    using std::sqrt;
    const auto is_small = [&](const Scalar& off) { return off <= sqrt(epsilon) * displaced(); };
    // An iteration of one stage that runs away changes momenta and positions in turns.
    const auto settles = [&] { return changed_by(sqrt(epsilon)); };
    // Rounding of z is all there is only of a state that hardly leaves z, far out or near rest: in a wall of
    // e^q it makes as much of the field at z, wherever the stages went.
    const auto stays = [&] {
      const auto half = [&](Eigen::Index begin) {
        Scalar moved(0);
        for (Eigen::Index i = begin; i < begin + dof(); ++i) moved += stages().displaced(i);
        return moved <= sqrt(epsilon) * sum_of_absolutes(z.vector().segment(begin, dof()));
      };
      return half(0) || half(dof());
    };
    // What Newton's method met on its way far out says nothing of here. Some roundings cancel each other, so
    // that it is felt again.
    const auto feel = [&](bool moved, bool again = false) {
      if (moved != felt_moved || displaced() < felt_at / 4) feels = 0;
      if (feels > 0 && !again) return;
      felt_at = displaced();
      felt_moved = moved;
      feel_rounding(z, moved, feels++, report);
    };
    // Newton's corrections may be small, as where the field grows exponentially, and its equations far off.
    const auto ended = [&](Status status) {
      if (options_.solver != StageSolver::newton) return status;
      Scalar off(0);
      bool each_is_small = true;
      for (Eigen::Index i = 0; i < least_.size(); ++i) {
        const Scalar part = stages().residual(i);
        off += part;
        each_is_small = each_is_small && part <= sqrt(epsilon) * size_of(z, i);
      }
      if (each_is_small && is_small(off)) return status;
      feel(false);
      Scalar rounding(0);
      for (Eigen::Index i = 0; i < least_.size(); ++i) {
        const Scalar own = 100 * (Scalar(options_.stages) * felt_[i] + 10 * epsilon * stages().displaced(i));
        rounding += own;
        if (!(stages().residual(i) <= own + sqrt(epsilon) * size_of(z, i))) return Status::no_convergence;
      }
      return off <= rounding ? status : Status::no_convergence;
    };
    bool entries_left = false;
    const Status at_rounding = options_.tolerance == 0 ? Status::success : Status::rounding_limited;
    for (;;) {
      const Scalar change = sweep();
      ++report.evaluations;
      // The first fixed-point sweep only evaluates the gradients at the starting values: a change is yet to
      // be seen.
      const bool seen = report.evaluations > 1 || options_.solver == StageSolver::newton;
      if (seen) {
        report.correction = static_cast<double>(change);
        if (previous > Scalar(0)) report.rate = static_cast<double>(change / previous);
        if (!isfinite(change)) return Status::not_finite;
        if (change < Scalar(options_.tolerance)) return Status::success;
        // From rest a sweep changes momenta alone, which may be nothing beside positions in another unit.
        const bool is_nothing = change <= nothing && previous > Scalar(0) && previous <= nothing;
        if (change == Scalar(0)) return ended(Status::success);
        since_least = change < least ? 0 : since_least + 1;
        if (change < least) least = change;
        if (report.evaluations % 16 == 0) earlier[0] = std::exchange(earlier[1], least);
        // A change grows by rounding. That of a state far from the origin, as of an angle that has wound up,
        // or of a late time, may be above that of the displacements, or nowhere at all: it is measured.
        if (since_least >= (options_.solver == StageSolver::newton ? 1 : 3)) {
          // What a stiff field makes of them is small beside the displacements, or the iteration runs away.
          const bool moved = settles();
          feel(moved, since_least >= 12 && since_least % 4 == 0);
          if ((moved || stays()) && is_within_felt(moved && since_least >= 12 ? 100 : 1))
            return ended(at_rounding);
        }
        const bool grows = previous > Scalar(0) && change >= previous;
        if (!entries_left && (is_nothing || (grows && change <= 10 * epsilon * displaced()))) {
          entries_left = true;
          since_better_ = 0;
          parts_ = std::numeric_limits<Scalar>::infinity();
          least_.setConstant(parts_);
        }
        // One that began at its solution, as of a circle, may run away from there, and so may an entry that
        // is nothing in a sum.
        if (entries_left && !improves(z) && settled(z) &&
            (is_nothing || change <= 100 * epsilon * displaced())) {
          if (worst_ <= sqrt(epsilon)) return ended(at_rounding);
          feel(settles());
          if (is_within_felt(100)) return ended(at_rounding);
        }
        previous = change;
      }
      if (report.evaluations < options_.max_iterations) continue;
      if (!seen) return Status::no_convergence;
      // It goes on to shrink, in turns where its rate is complex.
      if (since_least == 0) return Status::no_convergence;
      const bool moved = settles(), shrinks = !(earlier[0] <= Scalar(1.1) * least);
      feel(moved);
      return (moved || stays()) && is_within_felt(moved && !shrinks ? 100 : 1) ? ended(at_rounding)
                                                                               : Status::no_convergence;
    }
  }

  /// Whether the last sweep changed the displacements by no more than that part of them, in positions and in
  /// momenta.
  bool changed_by(const Scalar& part) {
    const auto half = [&](Eigen::Index begin) {
      Scalar changed(0), moved(0);
      for (Eigen::Index i = begin; i < begin + dof(); ++i) {
        changed += stages().changed(i);
        moved += stages().displaced(i);
      }
      return changed <= part * moved;
    };
    return half(0) && half(dof());
  }

  H hamiltonian_;
  GaussLegendreOptions options_;
  GaussTableau<Scalar> tableau_;

 private:
  /// By how much a few roundings of z, and of the stages' displacements where these `moved`, others each
  /// time, change dt times the vector field at z at most, entry by entry, and that in its turn.
  SEMIEXPLICIT_COLD void feel_rounding(const State& z, bool moved, int before, StepReport& report) {
    using std::abs, std::max;
    const Eigen::Index d = dof();
    const auto field_at = [&](Vec& field) {
      gradient_at(hamiltonian_, at_.data(), at_.data() + d, field.data() + d, field.data(), d);
    };
    // Gives its share of the displacements, of positions or of momenta.
    const auto feel_at = [&](Vec& most) {
      field_at(other_);
      Scalar sums[2][2] = {};
      for (Eigen::Index i = 0; i < at_.size(); ++i) {
        other_[i] = abs(weights_dt_ * (other_[i] - field_[i]));
        if (before == 0 || other_[i] > most[i]) most[i] = other_[i];
        sums[i < d][0] += other_[i];
        sums[i < d][1] += stages().displaced(i);
      }
      const auto share = [](const auto& sum) {
        return sum[0] > Scalar(0) ? Scalar(sum[0] / sum[1]) : sum[0];
      };
      return max(share(sums[0]), share(sums[1]));
    };
    at_ = z.vector();
    field_at(field_);
    for (Eigen::Index i = 0; i < at_.size(); ++i) {
      constexpr int roundings[] = {4, -3, 6, -5, 3, -6, 5};
      const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
      const Scalar size = abs(at_[i]) + (moved ? stages().displaced(i) : Scalar(0));
      at_[i] += Scalar(roundings[(i % 3 + before * (i + 1)) % 7]) * epsilon * size;
    }
    const Scalar share = feel_at(felt_);
    for (Eigen::Index i = 0; i < at_.size(); ++i)
      at_[i] = z.vector()[i] + ((i + before) % 2 == 0 ? other_[i] : Scalar(-other_[i]));
    const Scalar passed_on = feel_at(passed_on_),
                 growth = share > Scalar(0) ? Scalar(passed_on / share) : share;
    growth_ = before == 0 ? growth : max(growth_, growth);
    report.gradients += 3;
  }
  /// Whether the last sweep changed no entry by more than so many times that and its own rounding. Where
  /// steps of several radians make much more of a rounding than it was, it is no measure.
  bool is_within_felt(int multiple) {
    const Scalar count = Scalar(options_.stages), rounding = 10 * Eigen::NumTraits<Scalar>::epsilon();
    const bool passes_on = growth_ <= Scalar(10);
    for (Eigen::Index i = 0; i < felt_.size(); ++i) {
      const Scalar felt = passes_on && passed_on_[i] > felt_[i] ? passed_on_[i] : felt_[i];
      if (!(stages().changed(i) <= Scalar(multiple) * (count * felt + rounding * stages().displaced(i))))
        return false;
    }
    return true;
  }

  /// Whether one of the last sweeps improved an entry by more than the rounding of its own: a light body's
  /// numbers are nothing in a sum with a heavy one's. Changes may shrink in turns, and one that shrinks no
  /// more is the rounding of others.
  bool improves(const State& z) {
    const Scalar rounding = 100 * Eigen::NumTraits<Scalar>::epsilon();
    bool above = false, better = false;
    for (Eigen::Index i = 0; i < least_.size(); ++i) {
      const Scalar change = stages().changed(i);
      if (!(change > rounding * size_of(z, i))) continue;
      above = true;
      if (change < least_[i]) {
        least_[i] = change;
        better = true;
      }
    }
    since_better_ = better ? 0 : since_better_ + 1;
    return above && since_better_ < 4;
  }

  /// Whether the entries no longer get better, each beside its own size, where sizes are far apart. Positions
  /// and momenta change in turns, and of one in a small unit a sum of all tells nothing.
  bool settled(const State& z) {
    Scalar sum(0), largest(0), smallest = std::numeric_limits<Scalar>::infinity();
    worst_ = Scalar(0);
    for (Eigen::Index i = 0; i < least_.size(); ++i) {
      const Scalar size = size_of(z, i);
      if (!(size > Scalar(0))) continue;
      const Scalar part = stages().changed(i) / size;
      sum += part, worst_ = std::max(worst_, part);
      largest = std::max(largest, size), smallest = std::min(smallest, size);
    }
    if (largest <= 30 * smallest || 2 * worst_ <= Eigen::NumTraits<Scalar>::epsilon()) return true;
    return sum >= std::exchange(parts_, sum);
  }

  /// Of entry i, at z and on the way.
  Scalar size_of(const State& z, Eigen::Index i) {
    using std::abs;
    return abs(z.vector()[i]) + stages().displaced(i);
  }

  Stepper& stages() { return static_cast<Stepper&>(*this); }

  CompensatedUpdate<Scalar, Dof> update_;
  Vec least_;                                     ///< change of each entry so far
  int since_better_ = 0;                          ///< how many sweeps ago one of these became less
  Scalar parts_ = Scalar(0), worst_ = Scalar(0);  ///< what the last sweep changed in them, as parts of their
                                                  ///< sizes, and in the worst
  Vec at_, felt_, passed_on_, field_, other_;     ///< of feel_rounding()
  Scalar growth_ = Scalar(0);                     ///< from what is felt to what is passed on
  Scalar last_dt_ = Scalar(0), weights_dt_ = Scalar(0);
  Scalar ratio_ = Scalar(0);  ///< that the stages know how to follow by
};

}  // namespace detail
}  // namespace semiexplicit
