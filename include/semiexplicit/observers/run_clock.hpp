#pragma once

#include <cmath>
#include <cstdint>
#include <limits>

#include <Eigen/Core>

#include <semiexplicit/core/report.hpp>

namespace semiexplicit::detail {

/// How exactly the times of an orbit are known: they are sums that are rounded at their largest, so that one
/// near t = 0 is off by far more than its own size tells.
template <class Scalar>
class TimeRounding {
 public:
  /// The orbit's first time, and every later one.
  void begin(const Scalar& t) { largest_ = Scalar(0), see(t); }
  void see(const Scalar& t) {
    using std::abs;
    if (abs(t) > largest_) largest_ = abs(t);
  }
  /// The largest time of the orbit, t included.
  Scalar size(const Scalar& t) const {
    using std::abs;
    return abs(t) < largest_ ? largest_ : Scalar(abs(t));
  }
  /// Whether t and the orbit's time `last` may mean the same where steps are dt long: they differ by
  /// rounding, or by less than 1/1024 of a step.
  bool same(const Scalar& t, const Scalar& last, const Scalar& dt,
            const Scalar& epsilon = Eigen::NumTraits<Scalar>::epsilon()) const {
    using std::abs;
    return abs(t - last) <= 64 * epsilon * size(t) || 1024 * abs(t - last) <= abs(dt);
  }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(largest_);
  }

 private:
  Scalar largest_ = Scalar(0);
};

/// What an observer knows of the state that it saw last, and how the next one is related to it. The time
/// between two states is taken from the steps and dt of the run where that is more exact: after many steps,
/// or from a large t0 on, the difference of two times is mostly rounding.
template <class Scalar>
class RunClock {
 public:
  enum class Next {
    first,    ///< nothing was seen before
    again,    ///< the state that was seen last, as a run shows it that continues an earlier one
    follows,  ///< a later state of the same run, or of one that continues it; interval() is the time between
    changed,  ///< the last one, as an event has left it; see events()
    anew      ///< the start of another run
  };

  /// How the state at t is related to the last one, to which it is equal or not.
  Next relation(const Scalar& t, bool equal, const IntegrationReport& run) const {
    if (!started_) return Next::first;
    if (run.changes != changes_ && run.changes > 0) return Next::changed;
    if (at_event_ && equal && t == t_) return Next::again;               // at the end of its step
    const bool starts = run.dt != 0 && run.steps == 0 && !run.at_event;  // no dt: called by hand
    if (equal && rounding_.same(t, t_, Scalar(run.dt)) && (starts || run.dt == 0)) return Next::again;
    return starts || (run.dt == 0 && t == t_) ? Next::anew : Next::follows;
  }

  /// The time from the last state to the one at t.
  Scalar interval(const Scalar& t, const IntegrationReport& run) const {
    using std::abs;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const bool chosen = run.taken != 0 && run.steps - steps_ == 1;
    const bool cut =
        run.part != 0 && (run.at_event ? run.steps == steps_ : at_event_ && run.steps - steps_ == 1);
    const Scalar shown = t - t_, counted = cut      ? Scalar(run.part)
                                           : chosen ? Scalar(run.taken)
                                                    : Scalar(run.dt) * Scalar(run.steps - steps_);
    const Scalar size = rounding_.size(t);
    // They are doubles there: of a wider number the rounding of dt adds up, step by step, and that of times
    // does not.
    constexpr double of_doubles = std::numeric_limits<double>::epsilon();
    const Scalar adding_up = cut || chosen ? counted : Scalar(run.dt) * Scalar(run.steps);
    const bool more_exact = epsilon >= of_doubles || of_doubles * abs(adding_up) < epsilon * size;
    return counted != Scalar(0) && more_exact && abs(shown - counted) <= 4 * epsilon * size ? counted : shown;
  }

  /// How many steps lie between, where that is known; else 1. By the time where the state at which one run
  /// ended and the next one began was not shown: of steps that were chosen, as many of the last one's length;
  /// none where a run that turned is back at the time of the last state.
  std::int64_t steps_since(const Scalar& t, const IntegrationReport& run) const {
    using std::abs;
    if (run.dt == 0) return 1;
    const std::int64_t counted = run.steps - steps_;
    if (run.taken != 0 && counted > 1) return counted;
    const Scalar length = static_cast<Scalar>(run.taken != 0 ? run.taken : run.dt), passed = t - t_;
    const Scalar open = abs(length) / 2 + 4 * Eigen::NumTraits<Scalar>::epsilon() * rounding_.size(t);
    if (counted > 0 && abs(passed - Scalar(counted) * length) <= open) return counted;
    const double by_time = std::round(static_cast<double>(abs(passed / length)));
    if (run.at_event || at_event_) return 1;  // a part of a step
    return static_cast<std::int64_t>(by_time);
  }

  /// The state at t, so related to the one before, is the last one now.
  void set(const Scalar& t, const IntegrationReport& run, Next next) {
    started_ = true;
    if (next == Next::first || next == Next::anew)
      rounding_.begin(t);
    else
      rounding_.see(t);
    t_ = t;
    steps_ = run.steps;
    changes_ = run.changes;
    at_event_ = run.at_event;
  }

  bool started() const { return started_; }
  const Scalar& time() const { return t_; }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(started_);
    visit(t_);
    visit(steps_);
    visit(changes_);
    visit(at_event_);
    rounding_.visit_memory(visit);
  }

 private:
  bool started_ = false;
  Scalar t_ = Scalar(0);
  std::int64_t steps_ = 0, changes_ = 0;
  bool at_event_ = false;
  TimeRounding<Scalar> rounding_;
};

}  // namespace semiexplicit::detail
