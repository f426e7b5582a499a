#pragma once

#include <cmath>
#include <cstdint>

#include <Eigen/Core>

#include <semiexplicit/core/report.hpp>

namespace semiexplicit::detail {

/// What an observer knows of the state that it saw last, and how the next one is related to it. The time between two states is
/// taken from the steps and dt of the run where that is more exact: after many steps, or from a large t0 on, the difference of two
/// times is mostly rounding.
template <class Scalar>
class RunClock {
 public:
  enum class Next {
    first,    ///< nothing was seen before
    again,    ///< the state that was seen last, as a run shows it that continues an earlier one
    follows,  ///< a later state of the same run, or of one that continues it; interval() is the time between
    anew      ///< the start of another run
  };

  /// How the state at t is related to the last one, to which it is equal or not.
  Next relation(const Scalar& t, bool equal, const IntegrationReport& run) const {
    using std::abs;
    if (!started_) return Next::first;
    const Scalar rounding = 64 * Eigen::NumTraits<Scalar>::epsilon() * (abs(t) < abs(t_) ? abs(t_) : abs(t));
    const bool starts = run.dt != 0 && run.steps == 0;  // no dt: called by hand
    if (equal && abs(t - t_) <= rounding && (starts || run.dt == 0)) return Next::again;
    return starts || (run.dt == 0 && t == t_) ? Next::anew : Next::follows;
  }

  /// The time from the last state to the one at t.
  Scalar interval(const Scalar& t, const IntegrationReport& run) const {
    using std::abs;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar shown = t - t_, counted = Scalar(run.dt) * Scalar(run.steps - steps_);
    const Scalar size = abs(t) < abs(t_) ? abs(t_) : abs(t);
    const bool more_exact = Scalar(2.3e-16) * abs(counted) < epsilon * size;  // dt is a double there
    return counted != Scalar(0) && more_exact && abs(shown - counted) <= 4 * epsilon * size ? counted : shown;
  }

  /// How many steps lie between, where that is known; else 1.
  std::int64_t steps_since(const IntegrationReport& run) const {
    return run.dt != 0 ? run.steps - steps_ : 1;
  }

  /// The state at t is the last one now.
  void set(const Scalar& t, const IntegrationReport& run) {
    started_ = true;
    t_ = t;
    steps_ = run.steps;
  }

  bool started() const { return started_; }
  const Scalar& time() const { return t_; }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(started_);
    visit(t_);
    visit(steps_);
  }

 private:
  bool started_ = false;
  Scalar t_ = Scalar(0);
  std::int64_t steps_ = 0;
};

}  // namespace semiexplicit::detail
