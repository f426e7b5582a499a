#pragma once

#include <algorithm>
#include <cmath>

#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>

namespace semiexplicit::detail {

/// The longest ways that steps have made in q and in p. Degrees of freedom whose units are far apart count in
/// units of their own, √(length/momentum): in these q and p are as large as the root of the action, which is
/// the same in all units.
struct LengthsOfWays {
  Eigen::VectorXd unit{};                    ///< of each degree of freedom
  Eigen::VectorXd of_each_q{}, of_each_p{};  ///< the longest ways of each, in H's units
  double in_q = 0, in_p = 0;

  /// How large v is, a difference of positions or of momenta.
  double size_in_q(const Eigen::VectorXd& v) const { return norm(v.cwiseQuotient(unit).eval()); }
  double size_in_p(const Eigen::VectorXd& v) const { return norm(v.cwiseProduct(unit).eval()); }
};

/// 1 for what is no size.
inline double positive(double size) { return size > 0 && std::isfinite(size) ? size : 1; }

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
        dt_(rounded(problem.table.time_scale / 16)),
        in_each_q_(Column::Zero(own_dof<Any>(problem.z0.dof()))),
        in_each_p_(in_each_q_),
        longest_{.unit = Column::Ones(in_each_q_.size())} {}

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
      z = next, whole_ = whole;
      pace_ = wanted < 3 * dt ? wanted : 0;  // of a far smaller step it tells little
      if (!to_end && wanted > 1.2 * dt_) dt_ = rounded(std::min(wanted / 1.1, 1.5 * dt_));
      return dt;
    }
    return 0;
  }

  /// The step that is asked for where the last one was, 0 where that is not known: how hard the motion is
  /// there.
  double pace() const { return pace_; }
  /// The longest way that a step has made in q, and in p; 1 where nothing moves.
  double longest_in_q() const { return positive(longest_q_); }
  double longest_in_p() const { return positive(longest_p_); }
  /// The same with each degree of freedom in its own unit.
  LengthsOfWays lengths() const {
    return {longest_.unit, in_each_q_, in_each_p_, positive(longest_.in_q), positive(longest_.in_p)};
  }
  /// Where the last step leads when it is made whole, not in halves.
  const State& whole() const { return whole_; }
  /// How long the next step may be.
  double next() const { return dt_; }
  /// Whether it was the calls that ended the last step.
  bool cut() const { return cut_; }

 private:
  using Column = Eigen::VectorXd;

  /// The error of the step made whole, as a part of what is allowed.
  SEMIEXPLICIT_COLD double error_of(const State& whole, const State& next, const State& before) const {
    const auto of_half = [this](double error, double made, double at, double longest) {
      if (error <= 32 * Problem<Any>::epsilon * at) return 1e-9;  // rounding says nothing
      return error / (tolerance_ * (made + 0.03 * longest));
    };
    const auto q = [this](const auto& v) { return longest_.size_in_q(own(v)); };
    const auto p = [this](const auto& v) { return longest_.size_in_p(own(v)); };
    return std::max(of_half(q(whole.q() - next.q()), q(next.q() - before.q()), q(next.q()), longest_.in_q),
                    of_half(p(whole.p() - next.p()), p(next.p() - before.p()), p(next.p()), longest_.in_p));
  }
  /// Notes the longest ways that steps have made, and by them the units.
  SEMIEXPLICIT_COLD void grow_lengths(const State& next, const State& before) {
    const Column way_q = own(next.q() - before.q()), way_p = own(next.p() - before.p());
    longest_q_ = std::max(longest_q_, norm(way_q)), longest_p_ = std::max(longest_p_, norm(way_p));
    in_each_q_ = in_each_q_.cwiseMax(moved(way_q, own(next.q())));
    in_each_p_ = in_each_p_.cwiseMax(moved(way_p, own(next.p())));
    const Column unit = units();
    const auto changed = [](double now, double then) { return now > 2 * then || then > 2 * now ? 1.0 : 0.0; };
    if (unit.binaryExpr(longest_.unit, changed).any()) {
      longest_.unit = unit;
      longest_.in_q = longest_.size_in_q(in_each_q_), longest_.in_p = longest_.size_in_p(in_each_p_);
    }
    longest_.in_q = std::max(longest_.in_q, longest_.size_in_q(way_q));
    longest_.in_p = std::max(longest_.in_p, longest_.size_in_p(way_p));
  }

  /// Of the system's own degrees of freedom: a late time says nothing.
  static Column own(const auto& v) { return v.head(own_dof<Any>(v.size())).template cast<double>(); }
  /// How far each coordinate went by more than rounding, on its way to `end`.
  static Column moved(const Column& way, const Column& end) {
    return (way.array().abs() > 100 * Problem<Any>::epsilon * end.array().abs()).select(way.cwiseAbs(), 0);
  }
  /// All 1 where they are as near as the motion alone can bring them. One of which q or p stays, as of an
  /// angle that nothing depends on, tells none of its own.
  SEMIEXPLICIT_COLD Column units() const {
    const double usual = positive(std::sqrt(longest_q_) / std::sqrt(longest_p_));
    const Column unit = in_each_q_.binaryExpr(in_each_p_, [usual](double length, double momentum) {
      return length > 0 && momentum > 0 ? positive(std::sqrt(length) / std::sqrt(momentum)) : usual;
    });
    return unit.maxCoeff() > far_apart * unit.minCoeff() ? unit : Column(Column::Ones(unit.size()));
  }
  /// To ten bits: the times then add up without rounding.
  static double rounded(double dt) {
    int exponent = 0;
    const double part = std::frexp(dt, &exponent);
    return std::ldexp(std::floor(std::ldexp(part, 10)), exponent - 10);
  }

  inline static const Setting method{.method = Setting::Method::midpoint, .scheme = "low_defect4_s7"};
  static constexpr double far_apart = 30;                     ///< units
  static constexpr int most_attempts = 60, most_refused = 6;  ///< at a kink no step is short enough

  Walker<Any> in_one_, in_halves_;
  State whole_{};
  double tolerance_, dt_, pace_ = 0, longest_q_ = 0, longest_p_ = 0;
  Column in_each_q_, in_each_p_;  ///< the longest way of each coordinate
  LengthsOfWays longest_;
  bool cut_ = false;
};

}  // namespace semiexplicit::detail
