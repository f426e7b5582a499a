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

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/observers/dense_output.hpp>

namespace semiexplicit {

/// Which crossings of s = 0 count, in the direction of the run: from negative to positive s, the reverse, or
/// all.
enum class CrossingDirection { rising, falling, both };

namespace detail {

/// An action that asks for the state to change it: it takes a State&, and no const one.
template <class A, class Scalar, class State>
concept StateChange = std::invocable<A&, const Scalar&, State&> && !Observer<A, Scalar, State>;

/// Compiles unless an action that changes the state takes a time that is rounded.
template <class Action, class Scalar, class State>
consteval bool is_action() {
  using Called = std::remove_cvref_t<Action>;
  if constexpr (StateChange<Called, Scalar, State>)
    static_assert(!AtPlace<Called, Scalar, State&>::template rounds<0>(),
                  "this action takes the time as a whole number, or one of fewer digits than Scalar, which "
                  "rounds it: write `const Scalar& t`");
  return true;
}

/// Compiles for a surface s(q, p), a number; of anything else the compiler says how to write it.
template <class Surface, class State>
consteval bool is_surface() {
  constexpr bool fits = requires(const Surface& s, const State& z) {
    { s(z.q(), z.p()) } -> std::convertible_to<typename State::Scalar>;
    requires !std::is_integral_v<std::remove_cvref_t<decltype(s(z.q(), z.p()))>>;
  };
  static_assert(fits,
                "this surface cannot be called, or tells no more than true and false, or whole numbers: "
                "write `[](const auto& "
                "q, const auto& p) { return q[0]; }`, a number that is 0 on the surface");
  return fits;
}

/// +1, -1, or 0 on the surface. Throws std::invalid_argument where s is NaN.
template <class Scalar>
int side_of(const Scalar& s) {
  if (s > Scalar(0)) return 1;
  if (s < Scalar(0)) return -1;
  if (s == Scalar(0)) return 0;
  throw std::invalid_argument(
      "events: a surface s(q, p) is NaN at a state of the run; let it be a number wherever the orbit comes");
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

namespace detail {

template <class T>
inline constexpr bool is_on_event = false;
template <class Surface, class Action>
inline constexpr bool is_on_event<OnEvent<Surface, Action>> = true;

}  // namespace detail

/// Watches several surfaces in one run; see events().
template <class H, class... Kinds>
class Events {
 public:
  using Scalar = typename DenseOutput<H>::Scalar;
  using State = typename DenseOutput<H>::State;
  static_assert(detail::is_in_one_process<H>());
  static_assert((detail::is_on_event<Kinds> && ...),
                "events() takes kinds of events: write `on_event(surface, action)` for each");
  static_assert((detail::is_surface<decltype(std::declval<Kinds&>().surface), State>() && ...));
  static_assert((detail::is_action<decltype(std::declval<Kinds&>().action), Scalar, State>() && ...));
  static constexpr const char* name = "events";
  static constexpr bool interpolates = true;
  static constexpr std::size_t number = sizeof...(Kinds);
  /// Whether some action may change the state: integrate() then cuts its steps at the events.
  static constexpr bool changes_state =
      (detail::StateChange<std::remove_reference_t<decltype(std::declval<Kinds&>().action)>, Scalar, State> ||
       ...);

  Events(H hamiltonian, int nodes, Kinds... kinds)
      : intervals_(std::move(hamiltonian), nodes),
        kinds_(std::forward<Kinds>(kinds)...),
        at_event_(dof_of(dense().hamiltonian())),
        cut_(at_event_),
        largest_(at_event_),
        last_(at_event_) {}

  /// Takes in the next state; false where an action asked to stop.
  bool operator()(const Scalar& t, const State& z,
                  const IntegrationReport& run = {}) requires(!changes_state) {
    bool go_on = true;
    intervals_.take(t, z, run, [&](std::size_t i) { go_on = look(i, run) && go_on; });
    return go_on;
  }
  /// The same where changes_state: a run that begins with another state than the last one is seen here, all
  /// else by first_event().
  void see(const Scalar&, const State& z, const IntegrationReport& run) requires(changes_state) {
    require_size(z);
    if (run.steps == 0 && !run.at_event) {
      longest_ = Scalar(0);
      if (!started_ || z.vector() != last_.vector()) forget();
    }
    enlarge(z);
    started_ = true;
    last_ = z;
  }

  /// Looks through the last steps, where fewer than nodes - 1 were taken from the start or the last event.
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

  /// The largest error of the interpolated states at the events, estimated, relative to the size of the
  /// state; see DenseOutput::interpolation_error(). Events that change the state are not interpolated.
  const Scalar& interpolation_error() const requires(!changes_state) { return dense().interpolation_error(); }

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
    for (std::int64_t& count : counts_) visit(count);
    visit(orbit_);
    visit(arc_);
    visit(started_);
    visit(last_.vector());
    visit(longest_);
    for (Known& one : known_) one.visit(visit);
    visit(largest_.vector());
    visit(since_);
    each([&](std::size_t, auto& kind) { detail::visit_inner(visit, kind.action); });
  }

  /// What it knows of the orbit, and back to that, at the state z: for integrate(), which takes back what
  /// fails or throws on the way to an event, or at it.
  auto known() const { return std::tuple(known_, counts_, since_); }
  template <class Before>
  void back_to(const Before& before, const State& z) {
    std::tie(known_, counts_, since_) = before;
    last_ = z;
  }

  /// An event within a step, the x after its start.
  struct Found {
    std::size_t kind = none;
    Scalar x = Scalar(0);
    explicit operator bool() const { return kind != none; }
  };

  /// The first event on the way from `start` to `end`, which takes the time h; move(x, z) makes z the state
  /// at the time x after `start`. Events at the same time follow one by one with x = 0, also where nothing is
  /// left of the step, h = 0. It is to come until act(). For integrate(), where changes_state.
  template <class Move>
  Found first_event(const State& start, const State& end, const Scalar& h, const Move& move) {
    using std::abs;
    lengthen(h);
    const Scalar near = shortly(h == Scalar(0) ? longest_ : h);
    const auto along = [&](const auto& kind) {
      return [&](const Scalar& x) {
        move(x, at_event_);
        return value(kind, at_event_);
      };
    };
    // Beside others that wait the one that acted is settled first: what they make of its way is theirs.
    const Found waiting = next_pending();
    std::array<Leaving, number> settled{};
    each([&](std::size_t k, auto& kind) {
      Known& own = known_[k];
      if (own.open && !own.pending && (own.fired || !waiting))
        own.pending = settle(k, kind, start, end, near, longest_, along(kind), settled[k]);
    });
    if (const Found found = next_pending()) return found;
    for (Known& own : known_)
      if (own.way == through && !own.open) own.way = 0;
    if (h == Scalar(0)) return {};
    Found first;
    std::array<int, number> after{};
    std::array<Found, number> crossed{};
    each([&](std::size_t k, auto& kind) {
      after[k] = known_[k].side;
      if (known_[k].open) return;
      const auto crossing = leaves_side(k, kind, start, end, h, near, along(kind), settled[k]);
      if (!crossing.to) return;
      after[k] = crossing.to;
      if (!kind.counts(crossing.to)) return;
      crossed[k] = {k, crossing.x};
      if (!first || abs(crossing.x) < abs(first.x)) first = crossed[k];
    });
    if (!first) {
      for (std::size_t k = 0; k < number; ++k) known_[k].cross(after[k]);
      if (abs(since_) < steps_at_rest * abs(longest_)) since_ += h;
      return first;
    }
    // What an event takes the orbit back from does not show at the end of the step.
    for (bool earlier = true; earlier;) {
      earlier = false;
      each([&](std::size_t k, auto& kind) {
        if (k == first.kind || known_[k].open || after[k] != known_[k].side) return;
        move(first.x, at_event_);
        const Scalar there = value(kind, at_event_);
        if (detail::side_of(there) != -known_[k].side || abs(there) <= rounding_at_event(k, kind)) return;
        cut_ = at_event_;
        const auto crossing = leaves_side(k, kind, start, cut_, first.x, near, along(kind), settled[k]);
        if (!crossing.to || !kind.counts(crossing.to) || !(abs(crossing.x) < abs(first.x))) return;
        after[k] = crossing.to;
        first = crossed[k] = {k, crossing.x};
        earlier = true;
      });
    }
    // Beside what is told at the same time an action takes the state of its own surface.
    each([&](std::size_t k, const auto&) {
      if (acting[k] && !acting[first.kind] && crossed[k] &&
          abs(crossed[k].x - first.x) <= abs(same_time(near)))
        first = crossed[k];
    });
    known_[first.kind].cross(after[first.kind]);
    // Of another surface that is crossed at the same time rounding decides on which side the state at the
    // event is, and in which step it is crossed; and the action may turn the orbit back. Its crossing is
    // noted before, by the orbit as it comes.
    each([&](std::size_t k, auto& kind) {
      Known& own = known_[k];
      if (k == first.kind || own.open) return;
      const auto small = [&](const State& z) { return !(abs(value(kind, z)) > own.size() / 1000); };
      if (after[k] == own.side && !small(start) && !small(end)) return;
      move(first.x, at_event_);
      const Scalar from = value(kind, at_event_), noise = rounding_at_event(k, kind);
      int to = crossed[k] && detail::side_of(from) == after[k] ? after[k] : 0;
      bool passes = false;
      const auto off = [&](const Scalar& x) { return along(kind)(Scalar(first.x + x)); };
      if (abs(from) <= noise || is_near(k, from, same_time(near), off)) {
        const Leaving gone = leaving(from, noise, near, longest_, off);
        passes = gone.side != 0 && !(own.way == back && gone.side == own.side) &&
                 detail::side_of(Scalar(off(Scalar(-gone.x)) - from)) == -gone.side;
        if (passes) to = gone.side;
      }
      if (to != 0 && to != own.side) {
        own.cross(to);
        own.pending = kind.counts(to);
      }
      if (passes) own.way = through;
    });
    known_[first.kind].pending = true;
    return first;
  }

  /// Whether the action of that event may change the state.
  bool changes(const Found& found) const { return acting[found.kind]; }
  /// Calls its action; false: it wants the run to stop.
  bool act(const Found& found, const Scalar& t, State& z, const IntegrationReport& run) {
    bool go_on = true;
    // Those that wait keep their s of before the first action.
    each([&](std::size_t k, auto& kind) {
      Known& own = known_[k];
      if (own.pending && !own.open) own.level = value(kind, z);
      own.open = true;
    });
    known_[found.kind].pending = false;
    since_ = Scalar(0);
    each([&](std::size_t k, auto& kind) {
      if (k != found.kind) return;
      using std::abs;
      Known& own = known_[k];
      ++counts_[k];
      const Scalar before = own.level;
      if constexpr (acts<decltype(kind)>) {
        last_ = z;
        if constexpr (detail::is_bool<std::invoke_result_t<decltype(kind.action)&, const Scalar&, State&>>)
          go_on = kind.action(t, z);
        else
          kind.action(t, z);
        if constexpr (requires { dense().hamiltonian().follow_change(std::as_const(last_), z); })
          dense().hamiltonian().follow_change(std::as_const(last_), z);
      } else {
        go_on = told(kind, t, z, run);
      }
      own.level = value(kind, z);
      own.fired = true;
      own.rests = abs(own.level) <= 2 * abs(before) || abs(own.level) <= rounding(k, kind, z);
      own.noise = Scalar(0);
    });
    return go_on;
  }

 protected:
  DenseOutput<H>& dense() { return intervals_.dense; }
  const DenseOutput<H>& dense() const { return intervals_.dense; }

 private:
  static constexpr std::size_t none = ~std::size_t{0};
  /// A state that has not moved off a surface for so long had no speed.
  static constexpr int steps_at_rest = 16;
  template <class Kind>
  static constexpr bool acts =
      detail::StateChange<std::remove_reference_t<decltype(std::declval<Kind>().action)>, Scalar, State>;
  static constexpr std::array<bool, number> acting{acts<Kinds>...};

  /// Where s goes from a state on the surface: to that side (0: not seen), seen at the time x.
  struct Leaving {
    int side;
    Scalar x, s;
  };
  /// How the orbit came off a surface on which it was: through it at the last event, as far as is known
  /// before the actions, or back from its own.
  static constexpr int through = 1, back = -1;
  /// What it knows of the orbit beside the surface of one kind.
  struct Known {
    int side = 0;          ///< on which it is, also at a state on the surface: -1, 1; 0 before it is known
    bool open = true;      ///< an orbit or what follows an event has begun: see settle()
    bool pending = false;  ///< crossed where the orbit is, and not yet acted upon
    bool fired = false;    ///< open since its own event
    int way = 0;           ///< `through`, `back`, or neither
    bool rests = false;    ///< open, and s has not moved off `level` yet
    Scalar level = Scalar(0);
    Scalar noise = Scalar(0);         ///< the largest rounding of s since it rests
    Scalar scale = Scalar(0);         ///< the largest |s| since the last crossing
    int steps = 0;                    ///< since then
    Scalar scale_before = Scalar(0);  ///< and between that and the one before

    void enlarge(const Scalar& s) {
      using std::abs;
      if (abs(s) > scale) scale = abs(s);
    }
    /// The largest |s| since the last crossing but one: what s is small beside.
    const Scalar& size() const { return scale_before > scale ? scale_before : scale; }
    void cross(int to) {
      if (to == side) return;
      side = to;
      way = 0;
      // Where steps go from surface to surface no state shows how large it was.
      if (std::exchange(steps, 0) >= 3 || scale > scale_before / 1000)
        scale_before = std::exchange(scale, Scalar(0));
    }
    template <class Visitor>
    void visit(Visitor& visit) {
      visit(side);
      visit(open);
      visit(pending);
      visit(fired);
      visit(way);
      visit(rests);
      visit(level);
      visit(noise);
      visit(scale);
      visit(steps);
      visit(scale_before);
    }
  };
  /// A crossing to that side (0: none) at the time x.
  struct Crossing {
    int to = 0;
    Scalar x = Scalar(0);
  };

  /// The time from an event after which it shows where a surface was left to, in the direction of h: the
  /// least part of a step that events on it lie apart.
  Scalar shortly(const Scalar& h) const {
    using std::abs;
    using std::sqrt;
    const Scalar rounding = sqrt(Eigen::NumTraits<Scalar>::epsilon());
    const Scalar size = (rounding > Scalar(1e-6) ? rounding : Scalar(1e-6)) * abs(longest_);
    return h < Scalar(0) ? Scalar(-size) : size;
  }
  /// How far apart two events may be found that are at the same time; of shortly().
  Scalar same_time(const Scalar& near) const {
    using std::abs;
    return near * abs(Scalar(near / longest_));
  }
  void lengthen(const Scalar& h) {
    using std::abs;
    if (abs(h) > abs(longest_)) longest_ = h;
  }
  Found next_pending() {
    for (std::size_t k = 0; k < number; ++k)
      if (known_[k].pending) return {k, Scalar(0)};
    return {};
  }

  /// By how much the rounding of the coordinates, several units each, moves s: now, and of a coordinate that
  /// is small by now, where it was largest. Of that no more than the rounding of the largest s on its way
  /// here.
  template <class Kind>
  Scalar rounding(std::size_t k, const Kind& kind, const State& z) {
    at_event_ = z;
    return rounding_at_event(k, kind);
  }
  template <class Kind>
  Scalar rounding_at_event(std::size_t k, const Kind& kind) {
    using std::abs;
    const Scalar s = value(kind, at_event_), units = 16 * Eigen::NumTraits<Scalar>::epsilon(),
                 most = units * known_[k].size();
    Scalar sum(0), carried(0);
    for (Eigen::Index i = 0; i < at_event_.vector().size(); ++i) {
      Scalar& x = at_event_.vector()[i];
      const Scalar kept = x;
      const auto moved_by = [&](const Scalar& way) {
        x = kept + way;
        const Scalar moved = abs(Scalar(value(kind, at_event_) - s));
        return moved > Scalar(0) ? moved : Scalar(0);  // NaN beyond the edge of what s is defined on
      };
      sum += moved_by(Scalar(kept * units));
      if (carried < most) carried += moved_by(Scalar(units * largest_.vector()[i]));
      x = kept;
    }
    return sum + (carried < most ? carried : most);
  }
  void forget() {
    known_.fill({});
    largest_.vector().setZero();
  }
  void require_size(const State& z) const {
    if (largest_.dof() != z.dof())
      throw std::logic_error(
          "events: the state has another size than H, or it was moved from; use the one that it was moved "
          "to, or make a new one");
  }
  void enlarge(const State& z) { largest_.vector() = largest_.vector().cwiseMax(z.vector().cwiseAbs()); }

  /// Whether s = from is so small that it is crossed, or was, within about `near`.
  template <class At>
  bool is_near(std::size_t k, const Scalar& from, const Scalar& near, const At& at) const {
    using std::abs;
    return !(abs(from) > known_[k].size() / 10) && abs(from) <= abs(Scalar(at(near) - from));
  }

  /// To which side of s = from it goes, at(x) being s at the time x: seen at `near` or, where s does not move
  /// by more than `noise` until then, later, up to `most`. A short flight to the side `expected` may begin
  /// and end between these times: it is looked for.
  template <class At>
  static Leaving leaving(const Scalar& from, const Scalar& noise, const Scalar& near, const Scalar& most,
                         const At& at, int expected = 0) {
    using std::abs;
    for (Scalar x = near;; x *= 8) {
      if (abs(x) > abs(most) || x == Scalar(0)) x = most;  // of a step that is denormal nothing is near
      const Scalar s = at(x), moved = s - from;
      if (!(abs(moved) <= noise)) {
        const int side = detail::side_of(moved);
        if (side == -expected && x != near)
          for (const Scalar& earlier : {Scalar(x / 4), Scalar(x / 2)})
            if (const Scalar between = at(earlier); Scalar(expected) * (between - from) > noise)
              return {expected, earlier, between};
        return {side, x, s};
      }
      if (x == most) return {0, x, s};
    }
  }

  /// Decides on which side of its surface the orbit is that begins at `start`, or goes on there behind an
  /// event: the side of `start`, or where it is on the surface, the side to which it goes. Whether that is a
  /// crossing that counts, of which no event told.
  template <class Kind, class At>
  bool settle(std::size_t k, const Kind& kind, const State& start, const State& end, const Scalar& near,
              const Scalar& most, const At& at, Leaving& gone) {
    using std::abs;
    Known& own = known_[k];
    const Scalar from = value(kind, start), now = rounding(k, kind, start);
    // Of an orbit that stays in the surface the coordinates may be small now, and their rounding not gone.
    if (!own.rests || now > own.noise) own.noise = now;
    const Scalar noise = own.noise;
    own.enlarge(from);
    if constexpr (changes_state)
      own.enlarge(value(kind, end));
    else
      own.enlarge(at(near));  // costs no step, and both ends may be on the surface
    const bool on =
        own.rests ||
        abs(from) <= (own.way == through ? 4 * noise : noise) ||  // what it was may have been more
        is_near(k, from, same_time(near), at);
    const Scalar level = own.rests ? own.level : from;
    const int turned = acts<Kind> && own.fired ? -own.side : 0;
    gone =
        on ? leaving(level, noise, near, most, at, turned) : Leaving{detail::side_of(from), Scalar(0), from};
    if (on) own.enlarge(gone.s);
    own.rests = gone.side == 0;
    own.level = level;
    if (own.rests) return false;
    // On its way through the surface s doubles in twice the time since the event; it grows fourfold where the
    // action has left it no speed, and more where it comes back.
    if constexpr (acts<Kind>)
      if (own.fired && on && gone.side == own.side) {
        const auto moved = [&](const Scalar& x) { return Scalar(Scalar(gone.side) * (at(x) - level)); };
        Scalar x = gone.x;
        while (abs(x) > 2 * abs(near) && moved(x / 2) > noise) x /= 2;
        if (abs(since_) >= steps_at_rest * abs(longest_) || !(moved(since_ + 2 * x) <= 3 * moved(x)))
          throw std::runtime_error(
              "events: behind an event the state has no speed off the surface, or comes back to it within " +
              detail::in_words(static_cast<double>(near / longest_), 2) +
              " of a step, or before s has moved by more than its rounding: bounces pile up there; let the "
              "action end the run before, or hold the state");
      }
    own.open = false;
    const int before = own.side;
    if (std::exchange(own.fired, false)) {
      own.side = gone.side;
      own.way = gone.side == before ? through : back;
      return false;
    }
    const bool crossed = own.way != through && on && before != 0 && before != gone.side;
    if (crossed)
      own.cross(gone.side);
    else
      own.side = gone.side;
    return crossed && kind.counts(gone.side);
  }

  /// Where in the interval from `start` to `end` the orbit leaves the side that it is on; the time only of
  /// what counts, or where it is `timed`. at_once: the orbit does not begin at `start`, nor is there an
  /// event, so that a start on the surface is the crossing. `settled` is what settle() has seen from `start`,
  /// if that was on the surface.
  template <class Kind, class At>
  Crossing leaves_side(std::size_t k, const Kind& kind, const State& start, const State& end, const Scalar& h,
                       const Scalar& near, const At& at, const Leaving& settled, bool timed = false,
                       bool at_once = false) {
    Known& own = known_[k];
    const Scalar to = value(kind, end);
    const int after = detail::side_of(to);
    own.enlarge(to);
    ++own.steps;
    // On the surface it is not decided yet: an orbit that only touches it comes back to the side where it
    // was.
    using std::abs;
    const Scalar small = own.size() / 1000;
    bool stays = after == 0 || after == own.side;
    if (stays && abs(to) > small) return {};
    const Scalar from = value(kind, start);
    // Nor is it to rounding: it may be a touch, or another observer's event may turn the orbit back in the
    // next step. An action is not to wait for that, and a step beyond the end tells it from a touch.
    if (const Scalar part = abs(Scalar(to - from)) / 64; !stays && abs(to) <= part) {
      const Scalar noise = rounding(k, kind, end);
      stays = abs(to) <= noise && noise <= part;
      if constexpr (changes_state)
        if (stays) {
          const auto beyond = [&](const Scalar& x) { return at(Scalar(h + x)); };
          stays = leaving(to, noise, near, longest_, beyond).side == -after;
        }
    }
    if (stays) {
      // From the surface to the surface: the signs at the ends are rounding.
      if (abs(from) > small || !is_near(k, from, near, at)) return {};
      const Scalar noise = rounding(k, kind, start);
      const int side = abs(from) <= noise ? leaving(from, noise, near, h, at).side : 0;
      return side == -own.side ? Crossing{side, Scalar(0)} : Crossing{};
    }
    if (at_once && from == Scalar(0)) return {after, Scalar(0)};
    const bool beyond = detail::side_of(from) != own.side;
    if (beyond || (!at_once && is_near(k, from, near, at))) {
      const Leaving gone =
          settled.x != Scalar(0) ? settled : leaving(from, rounding(k, kind, start), near, h, at, own.side);
      if (!(abs(gone.x) < abs(h)) && gone.side != after) return {};
      const Scalar level = beyond ? from : Scalar(0);
      if (gone.side == 0 || (gone.side != after && detail::side_of(Scalar(to - level)) != after)) return {};
      if (gone.side != after)  // away from the surface, and back to it
        return {after, detail::bracketed_root([&](const Scalar& x) { return Scalar(at(x) - level); }, gone.x,
                                              Scalar(gone.s - level), h, Scalar(to - level))};
      if (beyond) return {after, Scalar(0)};
    }
    timed = timed || kind.counts(after);
    return {after, timed ? detail::bracketed_root(at, Scalar(0), from, h, to) : h};
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
      return detail::notify_between(kind.action, H::time(z), H::point(z), run);
    else
      return detail::notify_between(kind.action, t, z, run);
  }

  /// The events between state i and the next one, in order.
  bool look(std::size_t i, const IntegrationReport& run) {
    const State &start = dense().state(i), &end = dense().state(i + 1);
    const Scalar h = dense().interval(i);
    if (std::exchange(orbit_, intervals_.orbits()) != intervals_.orbits()) {
      longest_ = Scalar(0);
      forget();
    }
    require_size(start);
    enlarge(start);
    enlarge(end);
    if (std::exchange(arc_, intervals_.arcs()) != intervals_.arcs()) {
      for (Known& one : known_) {
        one.open = true;
        one.rests = false;
      }
    }
    lengthen(h);
    using std::abs;
    const Scalar shortest = shortly(h), near = abs(shortest) < abs(h) ? shortest : h;
    bool go_on = true;
    detail::FirstException thrown;
    std::array<bool, number> found{};
    std::array<Scalar, number> when{};
    const auto look_at = [&](std::size_t k, auto& kind) {
      Known& own = known_[k];
      const auto at = [&](const Scalar& x) {
        dense().sought_after(i, x, at_event_);
        return value(kind, at_event_);
      };
      const bool begins = own.open;
      Leaving gone{};
      if (begins && settle(k, kind, start, end, near, h, at, gone))
        go_on = tell(k, i, Scalar(0), run) && go_on;
      if (own.open) return;
      const bool cut = intervals_.cut(i);
      own.open = true;  // where the search throws the next interval has to find the side anew
      const Crossing crossing = leaves_side(k, kind, start, end, h, near, at, gone, cut, !begins);
      own.open = false;
      // On the surface of an event that changed the state it is the way on that decides.
      if (!crossing.to || (cut && (abs(Scalar(h - crossing.x)) <= abs(same_time(near)) ||
                                   abs(value(kind, end)) <= rounding(k, kind, end))))
        return;
      own.cross(crossing.to);
      found[k] = kind.counts(crossing.to);
      when[k] = crossing.x;
    };
    each([&](std::size_t k, auto& kind) { thrown.of([&] { look_at(k, kind); }); });
    for (;;) {
      std::size_t next = none;
      for (std::size_t k = 0; k < number; ++k)
        if (found[k] && (next == none || abs(when[k]) < abs(when[next]))) next = k;
      if (next == none) break;
      found[next] = false;
      // Of a surface that its action moves on the side counts anew.
      std::array<Scalar, number> before{};
      each([&](std::size_t k, auto& kind) { before[k] = value(kind, end); });
      thrown.of([&] { go_on = tell(next, i, when[next], run) && go_on; });
      each([&](std::size_t k, auto& kind) {
        const Scalar s = value(kind, end);
        if (s == before[k] || !(abs(s) > Scalar(0))) return;         // NaN is refused by look_at()
        if (detail::side_of(s) != known_[k].side) found[k] = false;  // it is no longer crossed there
        known_[k].side = detail::side_of(s);
      });
    }
    thrown.pass_on();
    return go_on;
  }

  /// Tells the n-th kind of its event at the time x after state i.
  bool tell(std::size_t n, std::size_t i, const Scalar& x, const IntegrationReport& run) {
    bool go_on = true;
    dense().after(i, x, at_event_);
    each([&](std::size_t k, auto& kind) {
      if (k != n) return;
      ++counts_[k];
      go_on = told(kind, Scalar(dense().time(i) + x), std::as_const(at_event_), run);
    });
    return go_on;
  }

  detail::Intervals<H> intervals_;
  std::tuple<Kinds...> kinds_;
  State at_event_, cut_;
  State largest_;  ///< of each coordinate, its absolute value so far
  std::array<std::int64_t, number> counts_{};
  std::array<Known, number> known_{};
  Scalar since_ = Scalar(0);  ///< the time since the last event, up to steps_at_rest
  std::int64_t orbit_ = 0, arc_ = 0;
  State last_;
  bool started_ = false;
  Scalar longest_ = Scalar(0);  ///< of the steps so far
};

/// An observer of events: calls the actions where the orbit crosses their surfaces, in order of time.
///
///     auto bounce = [](double t, PhasePoint<double, 1>& z) { z.p() *= -0.9; };
///     auto watch = events(H, on_event(floor, bounce, CrossingDirection::falling),
///                            on_event(top, [&](double t, const auto& z) { tops.push_back(t); }));
///     integrate(stepper, z, {.dt = 0.01, .t_end = 10}, watch);
///
/// Each s(q, p) is to be a number everywhere (NaN throws std::invalid_argument), continuous, and the steps so
/// small that it changes its sign once in each: of an angle take sin(q), not q modulo 2π. It crosses 0 with a
/// slope: of an orbit that lies in the surface what is told is rounding, if anything. The orbit is on one
/// side of a surface, also where a state lies on it: on the side to which s goes from there, seen as soon as
/// s has moved by more than its rounding. A crossing is a change of that side: a start on a surface is none,
/// nor is a state that only touches it. Of an extended Hamiltonian s has the extended q and p, so that the
/// time is the last q. Actions that change the state get what the stepper moves, of a TimeTransformed the
/// extended point at s; others the phase point at its time.
///
/// Where no action changes the state, events are found to rounding on the interpolation of the run
/// (DenseOutput, `nodes` states), whose steps stay as they are and must resolve the motion:
/// interpolation_error() tells how far; actions hear of the first ones up to nodes -
/// 1 steps late, and finish() hands on the last ones where fewer steps were taken from the start, or from the
/// last event of another observer that changed the state. One that returns false ends the run after the step.
/// What s or a gradient throws in the search passes through, and a crossing in that interval is not told.
///
/// Where an action may change the state, integrate() cuts the step at every event: it finds the time by steps
/// of the stepper itself, to 1e-12 of the step and better, for some ten to twenty steps more an event; every
/// other observer sees the state before and after the action, both at the time of the event; and what is left
/// of the step is taken from the changed state, so that times stay t0 + n dt. An action that returns false
/// ends the run at the event, with the state there. Said plainly what that does: between the events each arc
/// is as symplectic as its steps, but the map as a whole is not, since the cut depends on the state (a
/// reversible action, as a bounce, in a reversible system keeps it reversible); what a stepper carries begins
/// anew, as the compensation of its sums and the first iterates of Gauss's method; dense output begins anew;
/// Lyapunov exponents refuse such a run. With a TimeTransformed p_t takes up what the action does to H.
///
/// Surfaces crossed at the same time, to rounding, all have their events, in order of kinds behind the first,
/// each action seeing what the one before made of the state; one that has turned the orbit back is met again
/// where another of these sends it there. What then counts on the surface where the state is changed: the
/// kinds of this observer are told of the orbit as it comes, before any action, so that a ball that bounces
/// falls through the floor once and never rises through it; a section, and any other events(), see the orbit
/// as it goes on: a bounce only touches the floor, a kick lets it go through, once, at the changed state. A
/// jump over a surface crosses it for none of them.
///
/// An action on a ball whose bounces pile up is to end the run: an orbit that an action leaves no speed off
/// the surface, or that is back on it within 1e-6 of a step (in float 3e-4), or before s has moved by more
/// than its rounding (what 16 ε of each coordinate make, now and at its largest, the latter no more than 16
/// ε of the largest s since the last crossing but one), throws std::runtime_error, and so do a thousand
/// events in one step. Only one observer of a run may change the state. Refused are: by the compiler a
/// stepper that ChoosesSteps (ReversibleSteps), and such events within another observer or an Ensemble;
/// IntegrationOptions::subdivide; and to go on by `done` with a run that ended at an event: start a new one
/// with t0 = report.t.
template <class H, class... Kinds>
Events<H, Kinds...> events(H hamiltonian, Kinds... kinds) {
  return {std::move(hamiltonian), 4, std::forward<Kinds>(kinds)...};
}

}  // namespace semiexplicit
