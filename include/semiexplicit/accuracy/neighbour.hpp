#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/problem.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// An orbit of another energy beside the one that is followed: how fast both part, and what a perturbation
/// becomes in the observable.
template <class Any>
class Neighbour {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  /// Beside z0, by more than rounding; a half at rest by what it moves in `dt`.
  SEMIEXPLICIT_COLD Neighbour(Problem<Any>& problem, double dt) : state(problem.z0), problem_(problem) {
    std::uint64_t random = 3;
    const auto shift = [&](auto half, const auto& velocity, const auto& uphill) {
      const Scalar size =
          (Scalar(norm(half)) + Scalar(dt) * Scalar(norm(velocity))) / Scalar(double(half.size()));
      for (Eigen::Index i = 0; i < half.size(); ++i) {
        const double part = beside_by * scattered(random);
        half[i] += Scalar(uphill[i] > Scalar(0)   ? std::abs(part)
                          : uphill[i] < Scalar(0) ? -std::abs(part)
                                                  : part) *
                   std::max(size, Scalar(1e-300));
      }
    };
    const State velocity = problem.velocity_at(state);
    shift(state.q(), velocity.q(), (-velocity.p()).eval());
    shift(state.p(), velocity.p(), velocity.q());
    at_first_ = static_cast<double>(norm((state.vector() - problem.z0.vector()).eval()));
  }

  State state;

  /// A stretch begins, after which both are compared.
  void begin() { observed_ = 0; }
  /// Both have made a step, the other one to z.
  SEMIEXPLICIT_COLD void see(const State& z) {
    observed_ =
        std::max(observed_, static_cast<double>(norm(problem_.measured(state) - problem_.measured(z))));
  }
  /// A stretch has ended at the time t, and the other at z.
  SEMIEXPLICIT_COLD void note(double t, const State& z) {
    const auto between = (state.vector() - z.vector()).eval();
    const double apart = static_cast<double>(norm(between));
    const double log = parted_ + (apart > 0 ? std::log(apart / at_first_) : 0);
    // Relative errors of an orbit that itself goes off as fast do not grow.
    farthest_out_ = std::max(farthest_out_, static_cast<double>(norm(z.vector())));
    parting_.emplace_back(t,
                          log - (problem_.table.relative && farthest_out_ > 0 ? std::log(farthest_out_) : 0));
    if (parted_ == 0 && std::isfinite(observed_)) responses_.emplace_back(t, observed_ / beside_by);
    if (!(apart > 0) || (apart < farthest * at_first_ && apart > at_first_ / farthest)) return;
    state.vector() = z.vector() + Scalar(at_first_ / apart) * between;
    parted_ = log;
  }

  /// The rate at which both part as e^{rate t}, 0 where they do not. Regular orbits part as t or t², by a
  /// factor of 4 at most in the second half; in a hard place for a while by more: what counts is the last
  /// quarter at its least, beside the first and the second at their most.
  SEMIEXPLICIT_COLD double parting_rate() const {
    if (parting_.size() < 8) return 0;
    const double watched = parting_.back().first;
    double first = -1e300, second = -1e300, last = 1e300;
    for (const auto& [t, log] : parting_) {
      double& most = t <= watched / 4 ? first : second;
      if (t <= watched / 2) most = std::max(most, log);
      if (t >= 0.75 * watched) last = std::min(last, log);
    }
    const double least = in_floats ? 8 : 4;  // rounding parts what was brought near again
    if (!(last - first > least && last - second > least / 4)) return 0;
    return (parting_.back().second - first) / (0.75 * watched);
  }
  /// How long it takes to see that: until nothing of the first perturbation is left.
  SEMIEXPLICIT_COLD double time_to_part() const {
    for (const auto& [t, log] : parting_)
      if (log > 30) return t;
    return parting_.empty() ? 0 : parting_.back().first;
  }

  /// What a perturbation by the whole of the initial state would become in the observable, at the end of the
  /// run.
  SEMIEXPLICIT_COLD double response() const {
    if (responses_.empty()) return 0;
    const double watched = responses_.back().first;
    double half = 0, all = 0;
    for (const auto& [t, response] : responses_) {
      all = std::max(all, response);
      if (t <= watched / 2) half = all;
    }
    return all > 1.4 * half ? error_at_the_end(problem_.table, all, watched, 1) : all;
  }

 private:
  static constexpr bool in_floats = Eigen::NumTraits<Scalar>::epsilon() > Scalar(1e-10);
  /// In parts of the state. What is brought near again has bent: it tells whether orbits part, but no longer
  /// by how much they would have.
  static constexpr double beside_by = in_floats ? 3e-4 : 1e-8, farthest = in_floats ? 1e2 : 1e4;

  Problem<Any>& problem_;
  double at_first_ = 0, parted_ = 0, farthest_out_ = 0;
  double observed_ = 0;  ///< largest difference of the observables, within a stretch
  std::vector<std::pair<double, double>> parting_{},  ///< time, logarithm of how far they have parted
      responses_{};  ///< time, change of the observable by what was one of the whole state
};

}  // namespace semiexplicit::detail
