#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>

namespace semiexplicit::detail {

/// Steps that follow the motion: an explicit method of the fourth order makes each whole and in two halves,
/// and what these differ by is a small part of the way.
template <class Any>
class Pacer {
 public:
  using State = typename Any::State;

  /// `tolerance`: what a step may be off by, as a part of its way.
  SEMIEXPLICIT_COLD explicit Pacer(Problem<Any>& problem, double tolerance = 1e-2)
      : in_one_(problem, method),
        in_halves_(problem, method),
        tolerance_(tolerance),
        dt_(rounded(problem.table.time_scale / 16)) {}

  /// A step from z at the time t, no longer than `left`: moves z and returns how long it is; 0 where none
  /// works, or the calls ended.
  SEMIEXPLICIT_COLD double step(State& z, double t, double left) {
    for (int attempt = 0; attempt < most_attempts && t + dt_ > t; ++attempt) {
      const bool to_end = !(1.01 * dt_ < left);
      const double dt = to_end ? left : dt_;
      State whole = z, next = z;
      Probe probe;
      const bool works = in_one_.step(whole, dt, probe) && in_halves_.step(next, dt / 2, probe) &&
                         in_halves_.step(next, dt / 2, probe);
      cut_ = probe.cut;
      if (cut_) return 0;
      const double error = works ? error_of(whole, next, z) : std::numeric_limits<double>::infinity();
      const double wanted =
          dt * (std::isfinite(error) ? std::clamp(0.8 * std::pow(error, -1.0 / 5), 0.2, 4.0) : 0.1);
      if (!works || (error > 1 && attempt < most_refused)) {
        dt_ = rounded(std::min(0.9 * dt, wanted));
        continue;
      }
      grow_lengths(next, z);
      z = next;
      pace_ = wanted < 3 * dt ? wanted : 0;  // of a far smaller step it tells little
      if (!to_end && wanted > 1.2 * dt_) dt_ = rounded(std::min(wanted / 1.1, 1.5 * dt_));
      return dt;
    }
    return 0;
  }

  /// The step that is asked for where the last one was, 0 where that is not known: how hard the motion is
  /// there.
  double pace() const { return pace_; }
  /// The longest way that a step has made in q, and in p.
  double longest_in_q() const { return longest_q_; }
  double longest_in_p() const { return longest_p_; }
  /// How long the next step may be.
  double next() const { return dt_; }
  /// Whether it was the calls that ended the last step.
  bool cut() const { return cut_; }

 private:
  /// The error of the step made whole, as a part of what is allowed.
  SEMIEXPLICIT_COLD double error_of(const State& whole, const State& next, const State& before) const {
    const Eigen::Index d = own_dof<Any>(next.dof());  // a late time says nothing
    const auto of_half = [this, d](const auto& a, const auto& b, const auto& from, double longest) {
      const auto size = [d](const auto& v) { return static_cast<double>(norm(v.head(d).eval())); };
      const double error = size(a - b);
      if (error <= 32 * Problem<Any>::epsilon * size(b)) return 1e-9;  // rounding says nothing
      return error / (tolerance_ * (size(b - from) + 0.03 * longest));
    };
    return std::max(of_half(whole.q(), next.q(), before.q(), longest_q_),
                    of_half(whole.p(), next.p(), before.p(), longest_p_));
  }
  /// Notes the longest way that a step has made in q and in p.
  SEMIEXPLICIT_COLD void grow_lengths(const State& next, const State& before) {
    const Eigen::Index d = own_dof<Any>(next.dof());
    longest_q_ = std::max(longest_q_, static_cast<double>(norm((next.q() - before.q()).head(d).eval())));
    longest_p_ = std::max(longest_p_, static_cast<double>(norm((next.p() - before.p()).head(d).eval())));
  }
  /// To ten bits: the times then add up without rounding.
  static double rounded(double dt) {
    int exponent = 0;
    const double part = std::frexp(dt, &exponent);
    return std::ldexp(std::floor(std::ldexp(part, 10)), exponent - 10);
  }

  inline static const Setting method{.method = Setting::Method::midpoint, .scheme = "low_defect4_s7"};
  static constexpr int most_attempts = 60, most_refused = 6;  ///< at a kink no step is short enough

  Walker<Any> in_one_, in_halves_;
  double tolerance_, dt_, pace_ = 0, longest_q_ = 0, longest_p_ = 0;
  bool cut_ = false;
};

}  // namespace semiexplicit::detail
