#pragma once

#include <cstdint>
#include <stdexcept>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/observer.hpp>

namespace semiexplicit {

/// Hands on every n-th call, the first included; see every().
template <class Observer>
class Every {
 public:
  static constexpr const char* name = "every";

  Every(std::int64_t n, Observer&& observer) : n_(n), observer_(std::forward<Observer>(observer)) {
    if (n < 1) throw std::invalid_argument("every: n is below 1; give how many steps lie between two calls");
  }

  template <class Scalar, class State>
  bool operator()(const Scalar& t, const State& state, const IntegrationReport& run = {}) {
    return calls_++ % n_ != 0 || detail::notify(observer_, t, state, run);
  }

  /// Whether the observer has seen nothing yet and cannot do without; see Checkpointable.
  bool fresh() const { return detail::is_fresh(observer_); }

  /// n, and the options of the observer; see Describable.
  template <class List>
  void describe(List& list) const {
    list("n", n_);
    if constexpr (remembers) list("observer", observer_);
  }
  /// Its count, and what the observer remembers; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(calls_);
    if constexpr (remembers) observer_.visit_memory(visit);
  }

 private:
  static constexpr bool remembers = HasMemory<std::remove_cvref_t<Observer>>;

  std::int64_t n_, calls_ = 0;
  Observer observer_;
};

/// `every(100, observer)`: calls the observer at the start and then after every 100 steps. A named observer is referred to,
/// so it must outlive the run; a temporary is kept. The count goes on from run to run; the last state is only seen where a
/// multiple of n falls on it.
template <class Observer>
Every<Observer> every(std::int64_t n, Observer&& observer) {
  return {n, std::forward<Observer>(observer)};
}

}  // namespace semiexplicit
