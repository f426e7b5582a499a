#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/observer.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/observers/run_clock.hpp>

namespace semiexplicit {

template <class Observer>
class Every;

namespace detail {

template <class T>
inline constexpr bool counts_steps = false;
template <class Observer>
inline constexpr bool counts_steps<Every<Observer>> = true;

}  // namespace detail

/// Hands on every n-th call, the first included; see every().
template <class Observer>
class Every {
  static_assert(!detail::counts_steps<detail::Referred<Observer>>,
                "every() within every() would count the steps of the run, too: give one of them the product");

 public:
  static constexpr const char* name = "every";
  static constexpr bool interpolates = Interpolates<Observer>, saves_others = SavesOthers<Observer>;

  Every(std::int64_t n, Observer&& observer) : n_(n), observer_(std::forward<Observer>(observer)) {
    if (n < 1) throw std::invalid_argument("every: n is below 1; give how many steps lie between two calls");
  }

  template <class Scalar, detail::HasHalves State>
  bool operator()(const Scalar& t, const State& state, const IntegrationReport& run = {}) {
    if (Interpolates<Observer> && n_ > 1 && run.changes > 0 && run.dt != 0)
      throw std::invalid_argument(
          "every: an event has changed the state, and an observer that interpolates, as a section or "
          "at_times(), has to see every state of such a run; take every() away from it");
    if (!is_due(t, state, run)) return true;
    try {
      return detail::notify(observer_, t, state, run);
    } catch (...) {
      started_ = false;  // it was not shown, and is due again
      throw;
    }
  }

  /// Whether an observer that saves others saves this stepper; see Checkpoints.
  template <class S>
  bool saves(const S& stepper) const requires requires(const detail::Referred<Observer>& observer) {
    observer.saves(stepper);
  }
  { return detail::referred(observer_).saves(stepper); }
  /// Refuses a run that goes on from another state than it put back; see Checkpoints.
  template <class State>
  void require_start(const State& z, std::int64_t steps) const requires
      requires(const detail::Referred<Observer>& observer) {
    observer.require_start(z, steps);
  }
  { detail::referred(observer_).require_start(z, steps); }

  /// Whether the observer has seen nothing yet and cannot do without; see Checkpointable.
  bool fresh() const { return detail::is_fresh(observer_); }

  /// n, and the options of the observer; see Describable.
  template <class List>
  void describe(List& list) const {
    list("n", n_);
    detail::describe_inner(list, observer_);
  }
  /// The steps so far, and what the observer remembers; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(started_);
    visit(time_);
    visit(last_);
    visit(before_);
    visit(steps_);
    rounding_.visit_memory(visit);
    detail::visit_inner(visit, observer_);
  }

 private:
  /// Counts the steps of the runs: those of one that goes on from where the last one ended count on.
  template <class Scalar, class State>
  bool is_due(const Scalar& t, const State& state, const IntegrationReport& run) {
    const double now = static_cast<double>(t);
    if (run.dt == 0) {  // called by hand, or by an observer of the run
      steps_ += started_ ? 1 : 0;
    } else if (run.at_event) {  // a run that ends there is gone on with from that state
      keep(now, state);
      return Interpolates<Observer> && n_ == 1;
    } else if (run.steps == 0) {
      const double epsilon = std::max(std::numeric_limits<double>::epsilon(),
                                      static_cast<double>(Eigen::NumTraits<Scalar>::epsilon()));
      const bool again = started_ && rounding_.same(now, time_, run.dt, epsilon) && is_last(state);
      if (!again) rounding_.begin(now);
      before_ = again ? before_ + steps_ : 0;
      steps_ = 0;
      if (again) return false;  // its first state is the last one of the run before
    } else {
      steps_ = run.steps;
    }
    started_ = true;
    keep(now, state);
    return (before_ + steps_) % n_ == 0;
  }
  template <class State>
  void keep(double now, const State& state) {
    time_ = now;
    rounding_.see(now);
    const Eigen::Index d = state.q().size();
    last_.resize(static_cast<std::size_t>(2 * d));
    Eigen::Map<Eigen::VectorXd> last(last_.data(), 2 * d);
    last.head(d) = state.q().template cast<double>();
    last.tail(d) = state.p().template cast<double>();
  }
  template <class State>
  bool is_last(const State& state) const {
    const Eigen::Index d = state.q().size();
    const Eigen::Map<const Eigen::VectorXd> last(last_.data(), static_cast<Eigen::Index>(last_.size()));
    return last.size() == 2 * d && last.head(d) == state.q().template cast<double>() &&
           last.tail(d) == state.p().template cast<double>();
  }

  std::int64_t n_;
  bool started_ = false;
  double time_ = 0;                      ///< of the last state
  std::vector<double> last_;             ///< (q, p) there
  std::int64_t before_ = 0, steps_ = 0;  ///< of the earlier runs, and of this one
  detail::TimeRounding<double> rounding_;
  Observer observer_;
};

/// `every(100, observer)`: calls the observer at the start and then after every 100 steps. A named observer
/// is referred to, so it must outlive the run; a temporary is kept. A run that begins where the last one
/// ended, with its last state, counts on, a resumed one counts from its own start, any other begins anew; the
/// last state is only seen where a multiple of n falls on it. No every() stands within another. What is shown
/// are whole steps, no events; std::invalid_argument where an event changes the state and the observer
/// Interpolates. Where the observer throws, the next run begins anew, so that it is shown that state again.
template <class Observer>
Every<Observer> every(std::int64_t n, Observer&& observer) {
  return {n, std::forward<Observer>(observer)};
}
template <std::floating_point Number, class Observer>
Every<Observer> every(Number n, Observer&& observer) {
  static_assert(std::integral<Number>, "every() counts steps: give a whole number of them, as 5 for 5.0");
  return {static_cast<std::int64_t>(n), std::forward<Observer>(observer)};
}

}  // namespace semiexplicit
