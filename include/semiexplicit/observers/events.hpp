#pragma once

#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/observers/dense_output.hpp>

namespace semiexplicit {

/// Which crossings of s = 0 count, in the direction of the run: from negative to positive s, the reverse, or
/// all.
enum class CrossingDirection { rising, falling, both };

namespace detail {

/// An action that asks for the state to change it: it takes a State&, and no const one.
template <class A, class Scalar, class State>
concept StateChange = std::invocable<A&, const Scalar&, State&> && !Observer<A, Scalar, State>;

/// +1, -1, or 0 on the surface.
template <class Scalar>
int side_of(const Scalar& s) {
  return s > Scalar(0) ? 1 : s < Scalar(0) ? -1 : 0;
}

}  // namespace detail

/// One kind of event; see on_event().
template <class Surface, class Action>
struct OnEvent {
  Surface surface;
  Action action;
  CrossingDirection direction = CrossingDirection::both;

  /// Whether going to that side is an event.
  bool counts(int to) const {
    return direction != (to > 0 ? CrossingDirection::falling : CrossingDirection::rising);
  }
};

/// What is to be done where an orbit crosses the surface s(q, p) = 0, for events(). The action is called as
/// action(t, z):
///
/// - one that takes z by const reference or by value is told of the event, as an observer is, and ends the
/// run by returning false;
/// - one that takes `PhasePoint<Scalar, Dof>&`, written out and not as auto&, may change the state: a bounce,
/// a kick.
///
/// A named action is referred to, a temporary is kept.
template <class Surface, class Action>
OnEvent<Surface, Action> on_event(Surface surface, Action&& action,
                                  CrossingDirection direction = CrossingDirection::both) {
  return {std::move(surface), std::forward<Action>(action), direction};
}

/// Watches several surfaces in one run; see events().
template <class H, class... Kinds>
class Events {
 public:
  using Scalar = typename DenseOutput<H>::Scalar;
  using State = typename DenseOutput<H>::State;
  static constexpr const char* name = "events";
  static constexpr std::size_t number = sizeof...(Kinds);
  /// Whether some action may change the state: integrate() then cuts its steps at the events.
  static constexpr bool changes_state =
      (detail::StateChange<std::remove_reference_t<decltype(std::declval<Kinds&>().action)>, Scalar, State> ||
       ...);

  Events(H hamiltonian, int nodes, Kinds... kinds)
      : intervals_(std::move(hamiltonian), nodes),
        kinds_(std::forward<Kinds>(kinds)...),
        at_event_(dof_of(dense().hamiltonian())) {}

  /// Takes in the next state; false where an action asked to stop.
  bool operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    if constexpr (changes_state) {
      // integrate() asks first_event() where a step is to be cut; what starts anew is seen here.
      if (run.steps == 0 && !run.at_event) {
        longest_ = Scalar(0);
        if (!(started_ && t == time_)) {
          sides_.fill(0);
          left_.fill(false);
          pending_.fill(false);
        }
      }
      started_ = true;
      time_ = t;
      return true;
    } else {
      bool go_on = true;
      intervals_.take(t, z, run, [&](std::size_t i) { go_on = look(i, run) && go_on; });
      return go_on;
    }
  }

  /// Looks through a run that ended before it had as many states as the interpolation has nodes.
  void finish() {
    if constexpr (!changes_state) intervals_.finish([this](std::size_t i) { look(i, {}); });
  }

  /// How many events there were, of the k-th kind or of all.
  std::int64_t count(std::size_t k) const { return counts_.at(k); }
  std::int64_t count() const {
    std::int64_t all = 0;
    for (const std::int64_t one : counts_) all += one;
    return all;
  }

  /// Whether it has seen nothing yet: a resumed run would miss the events before.
  bool fresh() const { return changes_state ? !started_ : intervals_.fresh(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    each([&](std::size_t, const auto& kind) {
      list("direction", kind.direction);
      list.function("surface", kind.surface);
    });
    dense().describe(list);
    each([&](std::size_t, const auto& kind) { detail::describe_inner(list, kind.action); });
  }
  /// The states between which it interpolates, the sides of the surfaces, the counts, and what the actions
  /// remember; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    intervals_.visit_memory(visit);
    for (int& side : sides_) visit(side);
    visit(orbit_);
    for (std::int64_t& count : counts_) visit(count);
    visit(started_);
    visit(time_);
    visit(longest_);
    for (bool& one : left_) visit(one);
    for (bool& one : pending_) visit(one);
    each([&](std::size_t, auto& kind) { detail::visit_inner(visit, kind.action); });
  }

  /// An event within a step, the x after its start.
  struct Found {
    std::size_t kind = none;
    Scalar x = Scalar(0);
    explicit operator bool() const { return kind != none; }
  };

  /// The first event on the way from `start` to `end`, which takes the time h; move(x, z) makes z the state
  /// at the time x after `start`. Events at the same time follow one by one with x = 0, also where nothing is
  /// left of the step, h = 0. For integrate(), where changes_state.
  template <class Move>
  Found first_event(const State& start, const State& end, const Scalar& h, const Move& move) {
    using std::abs;
    for (std::size_t k = 0; k < number; ++k)
      if (std::exchange(pending_[k], false)) {
        left_[k] = true;
        return {k, Scalar(0)};
      }
    if (h == Scalar(0)) return {};
    if (abs(h) > abs(longest_)) longest_ = h;
    const Scalar near =
        h > Scalar(0) ? Scalar(shortest() * abs(longest_)) : Scalar(-shortest() * abs(longest_));
    const bool decides = abs(h) > abs(near);
    Found first;
    std::array<int, number> after{};
    std::array<bool, number> crossed{};
    std::array<Scalar, number> when{};
    each([&](std::size_t k, auto& kind) {
      after[k] = sides_[k];
      if (left_[k] && !decides) return;
      const auto at = [&](const Scalar& x) {
        move(x, at_event_);
        return value(kind, at_event_);
      };
      // A surface that an event was on: which side it was left to shows a little later.
      const Scalar from_x = left_[k] ? near : Scalar(0);
      const Scalar from = left_[k] ? at(from_x) : value(kind, start), to = value(kind, end);
      if (detail::side_of(from) != 0) sides_[k] = detail::side_of(from);
      after[k] = detail::side_of(to);
      if (after[k] == 0) after[k] = sides_[k];
      if (sides_[k] == 0 || after[k] == sides_[k] || !kind.counts(after[k])) return;
      const Scalar x = from == Scalar(0) ? from_x : detail::bracketed_root(at, from_x, from, h, to);
      if (left_[k] && abs(x) < 10 * abs(near))
        throw std::runtime_error(
            "events: a surface is crossed again within " +
            detail::in_words(10 * static_cast<double>(shortest()), 2) +
            " of a step, and its events pile up; let the action end the run before, or hold the state");
      crossed[k] = true;
      when[k] = x;
      if (!first || abs(x) < abs(first.x)) first = {k, x};
    });
    if (!first) {
      sides_ = after;
      if (decides) left_.fill(false);
      return first;
    }
    // Rounding decides on which side of a surface that is crossed at the same time the state at the event is,
    // and the action may turn it back: these events are noted before it.
    crossed[first.kind] = false;
    bool others = false;
    for (const bool one : crossed) others = others || one;
    if (others) {
      move(first.x, at_event_);
      const Scalar same = 16 * Eigen::NumTraits<Scalar>::epsilon() * abs(longest_);
      each([&](std::size_t k, auto& kind) {
        pending_[k] = crossed[k] && (abs(Scalar(when[k] - first.x)) <= same ||
                                     detail::side_of(value(kind, at_event_)) == after[k]);
      });
    }
    if (abs(first.x) >= abs(near)) left_.fill(false);
    left_[first.kind] = true;
    return first;
  }

  /// Calls its action; false: it wants the run to stop.
  bool act(const Found& found, const Scalar& t, State& z, const IntegrationReport& run) {
    bool go_on = true;
    each([&](std::size_t k, auto& kind) {
      if (k != found.kind) return;
      ++counts_[k];
      using Action = std::remove_reference_t<decltype(kind.action)>;
      if constexpr (detail::StateChange<Action, Scalar, State>) {
        if constexpr (std::same_as<std::invoke_result_t<Action&, const Scalar&, State&>, bool>)
          go_on = kind.action(t, z);
        else
          kind.action(t, z);
      } else {
        go_on = told(kind, t, z, run);
      }
    });
    return go_on;
  }

 protected:
  DenseOutput<H>& dense() { return intervals_.dense; }
  const DenseOutput<H>& dense() const { return intervals_.dense; }

 private:
  static constexpr std::size_t none = ~std::size_t{0};
  /// The part of a step within which a surface is not crossed again after an event on it.
  static Scalar shortest() {
    using std::sqrt;
    const Scalar rounding = sqrt(Eigen::NumTraits<Scalar>::epsilon());
    return rounding > Scalar(1e-6) ? rounding : Scalar(1e-6);
  }

  template <class F>
  void each(const F& f) {
    [&]<std::size_t... k>(std::index_sequence<k...>) { (f(k, std::get<k>(kinds_)), ...); }
    (std::make_index_sequence<number>());
  }
  template <class F>
  void each(const F& f) const {
    [&]<std::size_t... k>(std::index_sequence<k...>) { (f(k, std::get<k>(kinds_)), ...); }
    (std::make_index_sequence<number>());
  }

  template <class Kind>
  static Scalar value(const Kind& kind, const State& z) {
    return kind.surface(z.q(), z.p());
  }

  template <class Kind>
  static bool told(Kind& kind, const Scalar& t, const State& z, const IntegrationReport& run) {
    if constexpr (InExtendedPhaseSpace<H>)
      return detail::notify(kind.action, H::time(z), H::point(z), run);
    else
      return detail::notify(kind.action, t, z, run);
  }

  /// The events between state i and the next one, in order.
  bool look(std::size_t i, const IntegrationReport& run) {
    if (std::exchange(orbit_, intervals_.orbits()) != intervals_.orbits()) sides_.fill(0);
    std::array<bool, number> found{};
    std::array<Scalar, number> when{};
    each([&](std::size_t k, const auto& kind) {
      const Scalar from = value(kind, dense().state(i)), to = value(kind, dense().state(i + 1));
      if (detail::side_of(from) != 0) sides_[k] = detail::side_of(from);
      const int before = sides_[k], after = detail::side_of(to);
      // On the surface it is not decided yet: an orbit that only touches it comes back to the side where it
      // was.
      if (after == 0) return;
      sides_[k] = after;
      if (before == 0 || before == after || !kind.counts(after)) return;
      const auto at = [&](const Scalar& x) {
        dense().after(i, x, at_event_);
        return value(kind, at_event_);
      };
      found[k] = true;
      when[k] = from == Scalar(0)
                    ? Scalar(0)
                    : detail::bracketed_root(at, Scalar(0), from, Scalar(dense().interval(i)), to);
    });
    bool go_on = true;
    for (;;) {
      using std::abs;
      std::size_t next = none;
      for (std::size_t k = 0; k < number; ++k)
        if (found[k] && (next == none || abs(when[k]) < abs(when[next]))) next = k;
      if (next == none) return go_on;
      found[next] = false;
      dense().after(i, when[next], at_event_);
      each([&](std::size_t k, auto& kind) {
        if (k != next) return;
        ++counts_[k];
        go_on = told(kind, Scalar(dense().time(i) + when[next]), std::as_const(at_event_), run) && go_on;
      });
    }
  }

  detail::Intervals<H> intervals_;
  std::tuple<Kinds...> kinds_;
  State at_event_;
  std::array<int, number>
      sides_{};  ///< of each surface where the orbit was last: -1, 1; 0 before it was seen beside it
  std::array<std::int64_t, number> counts_{};
  std::int64_t orbit_ = 0;
  bool started_ = false;
  Scalar time_ = Scalar(0), longest_ = Scalar(0);  ///< longest: of the steps so far
  std::array<bool, number> left_{};     ///< surfaces that an event was on, and not yet seen beside since
  std::array<bool, number> pending_{};  ///< crossed at the time of the last event, and not yet acted upon
};

/// An observer of events: calls the actions where the orbit crosses their surfaces, in order of time.
///
///     auto bounce = [](double t, PhasePoint<double, 1>& z) { z.p() *= -0.9; };
///     auto watch = events(H, on_event(floor, bounce, CrossingDirection::falling),
///                            on_event(top, [&](double t, const auto& z) { tops.push_back(t); }));
///     integrate(stepper, z, {.dt = 0.01, .t_end = 10}, watch);
///
/// Each s(q, p) is to be continuous, and the steps so small that it changes its sign once in each: of an
/// angle take sin(q), not q modulo 2π. A start on a surface is no event, nor is a state that only touches it.
/// Of an extended Hamiltonian s has the extended q and p, so that the time is the last q.
///
/// Where no action changes the state, events are found to rounding on the interpolation of the run
/// (DenseOutput, `nodes` states), whose steps stay as they are; actions hear of the first ones up to nodes -
/// 1 steps late, and finish() hands on the last ones of a shorter run. One that returns false ends the run
/// after the step.
///
/// Where an action may change the state, integrate() cuts the step at every event: it finds the time by steps
/// of the stepper itself, to 1e-12 of the step and better, for five to ten steps more an event; every other
/// observer sees the state before and after the action, both at the time of the event; and what is left of
/// the step is taken from the changed state, so that times stay t0 + n dt. An action that returns false ends
/// the run at the event, with the state there. Said plainly what that does: between the events each arc is as
/// symplectic as its steps, but the map as a whole is not, since the cut depends on the state (a reversible
/// action, as a bounce, in a reversible system keeps it reversible); what a stepper carries begins anew, as
/// the compensation of its sums and the first iterates of Gauss's method;
/// dense output and sections begin anew; Lyapunov exponents refuse such a run. An action on a ball whose
/// bounces pile up is to end the run: events on a surface within 1e-5 of a step (in float 3e-3) throw
/// std::runtime_error, and so do a thousand in one step. Surfaces crossed at the same time, to rounding, all
/// have their events, in order of kinds behind the first, each action seeing what the one before made of the
/// state. Only one observer of a run may change the state. Refused are: with a stepper
/// that ChoosesSteps (ReversibleSteps), by the compiler; IntegrationOptions::subdivide; and to go on by
/// `done` with a run that ended at an event: start a new one with t0 = report.t.
template <class H, class... Kinds>
Events<H, Kinds...> events(H hamiltonian, Kinds... kinds) {
  return {std::move(hamiltonian), 4, std::forward<Kinds>(kinds)...};
}

}  // namespace semiexplicit
