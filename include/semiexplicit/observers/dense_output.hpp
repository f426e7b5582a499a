#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/observer.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/root.hpp>
#include <semiexplicit/observers/run_clock.hpp>

namespace semiexplicit {

/// An observer that keeps the last few states of a run and knows what lies between them: Hermite
/// interpolation of degree 2 nodes - 1 by the states and their vector fields (∂H/∂p, -∂H/∂q). The error
/// within a step of size h is of order h^{2 nodes}: four nodes do for methods up to order 8. A gradient is
/// called only where something is interpolated.
///
/// The steps must resolve the motion for that, which is more than a good method asks for: exact flows with
/// five steps an orbit, Gauss's methods of many stages and steps that were cut
/// (IntegrationOptions::subdivide) give states far better than what lies between them, and more nodes do not
/// help there. interpolation_error() tells. Where it is too large take shorter steps, or a step to the very
/// time: a run that ends there, by t_end.
///
/// It says nothing beyond the states it holds, end() included: ready() tells whether these are as many as
/// were asked for. The state that it saw last, shown again as a run continues, changes nothing. Where the
/// time turns round that state is the first of the way back; another orbit starts it anew.
///
/// The time between two states comes from the run's dt where the times themselves are rounded too coarsely
/// (late times, float).
template <class H>
class DenseOutput {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "DenseOutput";
  static constexpr bool interpolates = true;

  /// Throws std::invalid_argument unless nodes is 2 to 8.
  explicit DenseOutput(H hamiltonian, int nodes = 4)
      : hamiltonian_(std::move(hamiltonian)), wanted_(static_cast<std::size_t>(nodes)) {
    if (nodes < 2 || wanted_ > max_nodes)
      throw std::invalid_argument("DenseOutput: " + std::to_string(nodes) +
                                  " nodes; give 2 to 8, half the order of the method or a little more");
    const State zero(dof_of(hamiltonian_));
    last_ = last_but_one_ = zero;
    for (std::size_t i = 0; i < wanted_; ++i) kept_[i] = Node{.z = zero, .field = zero.vector()};
  }

  /// Takes in the next state.
  void operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    push(t, z, run, [](auto) {});
  }

  /// The same; where z does not continue what it holds, done(next) is called first, with how z is related to
  /// these states (detail::RunClock, `follows` on the way back): nothing more comes between them. Whether
  /// there is one more interval to look at.
  template <class Done>
  bool push(const Scalar& t, const State& z, const IntegrationReport& run, const Done& done) {
    using Next = typename detail::RunClock<Scalar>::Next;
    judged_ = none;
    detail::require_same_dof("DenseOutput", z.dof(), "Hamiltonian", dof_of(hamiltonian_),
                             "give the one that the run is of");
    const bool equal = size_ > 0 && z.vector() == node(size_ - 1).z.vector();
    const Next next = clock_.relation(t, equal, run);
    const Scalar after = next == Next::follows ? clock_.interval(t, run) : Scalar(0);
    clock_.set(t, run, next);
    if (next == Next::again) return false;
    if (next != Next::follows) {
      done(next);
      size_ = 0;
    } else if (size_ > 1 && (after > Scalar(0)) != (node(size_ - 1).after > Scalar(0))) {
      done(next);
      first_ = (first_ + size_ - 1) % wanted_;  // the last state stays
      size_ = 1;
    }
    if (size_ == wanted_) {
      first_ = (first_ + 1) % wanted_;
      --size_;
    }
    Node& newest = node(size_);
    newest.t = t;
    newest.after = after;
    newest.z = z;
    newest.has_field = false;
    return ++size_ > 1;
  }

  /// The number of states it holds, and the i-th of them, the oldest first. Throws std::out_of_range, here
  /// and below, for what it does not hold.
  std::size_t size() const { return size_; }
  const Scalar& time(std::size_t i) const { return held(i).t; }
  const State& state(std::size_t i) const { return held(i).z; }
  /// The time from state i to the next one.
  const Scalar& interval(std::size_t i) const { return held(i + 1).after; }

  /// Whether it holds as many states as it was told to; before that the interpolation is of a lower degree.
  bool ready() const { return size_ == wanted_; }
  const Scalar& begin() const { return held(0).t; }
  const Scalar& end() const { return held(size_ > 0 ? size_ - 1 : 0).t; }

  /// z becomes the interpolated state at t, which lies between begin() and end(), but for the rounding of
  /// times.
  void at(const Scalar& t, State& z) {
    require_within(t);
    std::size_t i = 0;
    while (i + 2 < size_ && (end() > begin() ? time(i + 1) <= t : time(i + 1) >= t)) ++i;
    after(i, t - time(i), z);
  }

  /// z becomes the interpolated state at the time x, from 0 to interval(i) or next to it, after state i.
  void after(std::size_t i, const Scalar& x, State& z) {
    const Places at(*this, i);
    const Scalar spread = interpolate(at, i, x, z);
    note_error(at, i, x, spread);
  }
  /// The same for a search, whose states are not handed on: interpolation_error() does not hear of them.
  void sought_after(std::size_t i, const Scalar& x, State& z) { interpolate(Places(*this, i), i, x, z); }

  /// The largest error of the interpolated states so far, as estimated: ‖error of (q, p)‖ relative to ‖(q,
  /// p)‖ of the larger of the states before and behind, a number without unit; in an extended phase space
  /// without (t, p_t). 0 before anything was interpolated, and no less than rounding after it. That is the
  /// interpolation alone: the error of the run's own states comes to it (with_error_estimate()).
  ///
  /// The estimate is the next term of Newton's series for the interpolant, with a divided difference guessed
  /// from the last two by a geometric law; it costs no gradient, and once a step the time of two
  /// interpolations (0.1 µs with four nodes of one degree of freedom). For steps that resolve the motion it
  /// was 1 to 7 times the worst error on harmonic, Kepler's and systems::Product's, and where the error is as
  /// large as the orbit it is of that size too. Beside a large slow motion that of a small fast one may be
  /// ten times what it says, and more by two or three nodes, or in the first steps. What leaves no trace in
  /// the states at the steps it cannot see.
  ///
  /// Source: J. Stoer, R. Bulirsch, Introduction to Numerical Analysis, 3rd ed., sections 2.1.3 to 2.1.5.
  const Scalar& interpolation_error() const { return worst_; }

  const H& hamiltonian() const { return hamiltonian_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("nodes", wanted_);
    list.function("Hamiltonian", GradientSize(hamiltonian_));
  }
  /// The states that it keeps; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (std::size_t i = 0; i < wanted_; ++i) {
      Node& one = kept_[i];
      visit(one.t);
      visit(one.after);
      visit(one.z.vector());
      visit(one.field);
      visit(one.has_field);
    }
    visit(first_);
    visit(size_);
    visit(worst_);
    judged_ = none;
    clock_.visit_memory(visit);
  }

 private:
  static constexpr std::size_t max_nodes = 8, none = ~std::size_t{0};
  struct Node {
    Scalar t = Scalar(0), after = Scalar(0);  ///< the time, and the time since the node before
    State z;
    typename State::Storage field;  ///< dz/dt, where has_field
    bool has_field = false;
  };

  Node& node(std::size_t i) { return kept_[(first_ + i) % wanted_]; }
  const Node& node(std::size_t i) const { return kept_[(first_ + i) % wanted_]; }
  const Scalar& gap(std::size_t i) const { return node(i + 1).after; }
  const Node& held(std::size_t i) const {
    if (i >= size_) refuse_number(i);
    return node(i);
  }
  [[noreturn]] SEMIEXPLICIT_COLD void refuse_number(std::size_t i) const {
    if (size_ == 0) throw std::out_of_range("DenseOutput: it holds no state yet; show it those of a run");
    throw std::out_of_range("DenseOutput: there is no state " + std::to_string(i) +
                            "; they count from 0 to " + std::to_string(size_ - 1));
  }
  /// Beyond the ends by less than 1/64 of the interval there the interpolation holds, and a time may be so
  /// late that it is rounded by more.
  void require_within(const Scalar& t) const {
    using std::abs;
    const Scalar rounding = 4 * Eigen::NumTraits<Scalar>::epsilon() * (abs(begin()) + abs(end()));
    const auto next_to = [&](const Scalar& to, std::size_t behind) {
      const Scalar part = size_ > 1 ? Scalar(abs(node(behind).after) / 64) : Scalar(0);
      return abs(t - to) <= std::max(rounding, part);
    };
    const bool within = end() > begin() ? t >= begin() && t <= end() : t <= begin() && t >= end();
    if (within || next_to(begin(), 1) || next_to(end(), size_ - 1)) return;
    throw std::out_of_range("DenseOutput: t = " + detail::in_words(t, 9) +
                            " lies outside what it holds, from " + detail::in_words(begin(), 9) + " to " +
                            detail::in_words(end(), 9) +
                            "; ask while the run is there, or let at_times() ask");
  }

  const typename State::Storage& field(Node& at) {
    if (!at.has_field) {
      const Eigen::Index d = at.z.dof();
      Scalar* const x = at.field.data();
      const Scalar* const z = at.z.vector().data();
      detail::gradient_at(hamiltonian_, z, z + d, x + d, x, d);
      for (Eigen::Index i = d; i < 2 * d; ++i) x[i] = -x[i];
      at.has_field = true;
    }
    return at.field;
  }

  /// Where the states lie, from state i on, and which of them an interpolation behind it goes through.
  struct Places {
    Scalar place[max_nodes];
    bool used[max_nodes];
    Scalar inverse[max_nodes][max_nodes];  ///< 1/(place[j] - place[k]) of those used

    Places(const DenseOutput& dense, std::size_t i) {
      const std::size_t size = dense.size_;
      place[i] = Scalar(0);
      for (std::size_t k = i; k + 1 < size; ++k) place[k + 1] = place[k] + dense.gap(k);
      for (std::size_t k = i; k > 0; --k) place[k - 1] = place[k] - dense.gap(k - 1);
      // States that lie close together, as before and behind a step that was cut, are one to an interpolation
      // over longer steps.
      const auto take = [&, least = dense.gap(i) / 8](std::size_t k, std::size_t& nearest) {
        using std::abs;
        used[k] = abs(place[k] - place[nearest]) >= abs(least);
        if (used[k]) nearest = k;
      };
      std::size_t nearest = i;
      used[i] = true;
      for (std::size_t k = i; k > 0; --k) take(k - 1, nearest);
      if (i + 1 < size) used[nearest = i + 1] = true;
      for (std::size_t k = i + 2; k < size; ++k) take(k, nearest);
      for (std::size_t j = 0; j < size; ++j)
        for (std::size_t k = 0; k < j; ++k)
          if (used[j] && used[k]) inverse[k][j] = -(inverse[j][k] = 1 / (place[j] - place[k]));
    }
  };

  /// Returns the sum of the absolute weights of the other states: how often their rounding is in z.
  Scalar interpolate(const Places& at, std::size_t i, const Scalar& x, State& z) {
    using std::abs;
    const auto& place = at.place;
    Scalar spread(0);
    // The weights of the states have the sum 1: differences from state i are added to it, so that late times
    // and other large values are not rounded once a node.
    const State& start = node(i).z;
    if (z.dof() != start.dof()) z = start;  // of dynamic size
    z.vector().setZero();
    for (std::size_t j = 0; j < size_; ++j) {
      if (!at.used[j]) continue;
      // Lagrange's polynomial of node j at x, and its slope at the node.
      Scalar polynomial(1), slope(0);
      for (std::size_t k = 0; k < size_; ++k) {
        if (k == j || !at.used[k]) continue;
        polynomial *= (x - place[k]) / (place[j] - place[k]);
        slope += at.inverse[j][k];
      }
      const Scalar squared = polynomial * polynomial, beyond = x - place[j];
      if (j != i) {
        const Scalar weight = squared * (1 - 2 * beyond * slope);
        z.vector() += weight * (node(j).z.vector() - start.vector());
        spread += abs(weight);
      }
      z.vector() += (squared * beyond) * field(node(j));
    }
    z.vector() += start.vector();
    return spread;
  }

  /// What every place of an interval has in common of the error: with m nodes a guess of the divided
  /// difference of order 2m, in units of the interval and relative to the size of the states.
  void judge(const Places& at, std::size_t i) {
    using std::abs;
    using std::pow;
    judged_ = i;
    const Scalar unit = gap(i);
    const auto larger = [&](auto&& of) { return std::max(Scalar(of(i)), Scalar(of(i + 1))); };
    const Scalar size = larger([&](std::size_t k) { return detail::state_size(hamiltonian_, node(k).z); });
    const Scalar speed = abs(unit) * larger([&](std::size_t k) {
                           last_.vector() = field(node(k));
                           return detail::state_size(hamiltonian_, last_);
                         });
    // The divided differences of order 2m - 1, and 2m - 2 without the slope at the farthest node.
    std::size_t farthest = i, nodes = 0;
    for (std::size_t k = 0; k < size_; ++k) {
      if (!at.used[k]) continue;
      ++nodes;
      if (abs(at.place[k]) > abs(at.place[farthest])) farthest = k;
    }
    last_.vector().setZero();
    last_but_one_.vector().setZero();
    for (std::size_t j = 0; j < size_; ++j) {
      if (!at.used[j]) continue;
      Scalar weight(1), slope(0);
      for (std::size_t k = 0; k < size_; ++k) {
        if (k == j || !at.used[k]) continue;
        const Scalar inverse = unit * at.inverse[j][k];
        weight *= inverse * inverse;
        slope += inverse;
      }
      const Scalar away = (at.place[j] - at.place[farthest]) / unit;
      if (j != i) {
        const auto beyond = node(j).z.vector() - node(i).z.vector();
        last_.vector() += (-2 * weight * slope) * beyond;
        last_but_one_.vector() += (weight * (1 - 2 * away * slope)) * beyond;
      }
      last_.vector() += (weight * unit) * field(node(j));
      last_but_one_.vector() += (weight * away * unit) * field(node(j));
    }
    const Scalar last = detail::state_size(hamiltonian_, last_),
                 before = detail::state_size(hamiltonian_, last_but_one_);
    next_difference_ = Scalar(0);
    if (!(speed > Scalar(0) && size > Scalar(0))) return;
    // By what factor they grow from one order to the next: on the way from the field to the last ones, the
    // larger, since that from one to the other is anything near a zero of either.
    const int order = 2 * static_cast<int>(nodes) - 2;
    const Scalar growth = pow(Scalar(before / speed), Scalar(1) / Scalar(order - 1));
    next_difference_ = last > before * growth
                           ? Scalar(last * pow(Scalar(last / speed), Scalar(1) / Scalar(order)) / size)
                           : Scalar(before * growth * growth / size);
  }

  void note_error(const Places& at, std::size_t i, const Scalar& x, const Scalar& spread) {
    if (i + 1 >= size_ || x == Scalar(0) || x == gap(i)) return;
    if (judged_ != i) judge(at, i);
    Scalar error = next_difference_;
    for (std::size_t k = 0; k < size_; ++k) {
      const Scalar from = (x - at.place[k]) / gap(i);
      if (at.used[k]) error *= from * from;
    }
    error += Eigen::NumTraits<Scalar>::epsilon() * (1 + 2 * spread);  // of the fields about as much
    if (error > worst_) worst_ = error;
  }

  H hamiltonian_;
  std::size_t wanted_, first_ = 0, size_ = 0;
  std::array<Node, max_nodes> kept_;
  detail::RunClock<Scalar> clock_;
  Scalar worst_ = Scalar(0);
  State last_, last_but_one_;  ///< divided differences; see judge()
  std::size_t judged_ = none;  ///< the interval of
  Scalar next_difference_ = Scalar(0);
};

namespace detail {

/// The first exception of several calls, which is passed on when all of them were made.
class FirstException {
 public:
  template <class Call>
  void of(const Call& call) {
    try {
      call();
    } catch (...) {
      if (!first_) first_ = std::current_exception();
    }
  }
  void pass_on() const {
    if (first_) std::rethrow_exception(first_);
  }

 private:
  std::exception_ptr first_;
};

/// The intervals of a run, each once, as soon as they can be interpolated to the full degree: what at_times()
/// and poincare_section() look at.
template <class H>
class Intervals {
 public:
  using Scalar = typename DenseOutput<H>::Scalar;
  using State = typename DenseOutput<H>::State;
  using Next = typename RunClock<Scalar>::Next;

  Intervals(H hamiltonian, int nodes) : dense(std::move(hamiltonian), nodes) {}

  /// Takes in the next state, and hands look(i) the intervals from state i of `dense` to the next one. What
  /// look() throws is passed on when the state is in and all are seen: the run may go on from there.
  template <class Look>
  void take(const Scalar& t, const State& z, const IntegrationReport& run, const Look& look) {
    FirstException thrown;
    const auto done = [&](Next next) {
      cut_ = next == Next::changed;
      show(look, thrown);
      if (next != Next::follows) ++(next == Next::changed ? arcs_ : orbits_);
    };
    const bool more = dense.push(t, z, run, done);
    cut_ = run.at_event;
    if (more) ++unseen_;
    if (dense.ready()) show(look, thrown);
    thrown.pass_on();
  }

  /// Hands on the intervals that were not yet, of a run that ended before there were as many states, from its
  /// start or from the last event that changed one, as the interpolation has nodes.
  template <class Look>
  void finish(const Look& look) {
    FirstException thrown;
    show(look, thrown);
    thrown.pass_on();
  }

  /// Whether it has seen nothing yet.
  bool fresh() const { return dense.size() == 0; }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    dense.visit_memory(visit);
    visit(unseen_);
    visit(orbits_);
    visit(arcs_);
    visit(cut_);
  }

  /// How many orbits were begun.
  std::int64_t orbits() const { return orbits_; }
  /// How often an orbit went on behind an event that may have changed its state.
  std::int64_t arcs() const { return arcs_; }
  /// Whether interval i ends at such an event.
  bool cut(std::size_t i) const { return cut_ && i + 2 == dense.size(); }

  DenseOutput<H> dense;

 private:
  template <class Look>
  void show(const Look& look, FirstException& thrown) {
    for (std::size_t i = dense.size() - 1 - unseen_; unseen_ > 0; ++i, --unseen_) thrown.of([&] { look(i); });
  }

  std::size_t unseen_ = 0;  ///< intervals at the end
  std::int64_t orbits_ = 0, arcs_ = 0;
  bool cut_ = false;  ///< the last state is that of an event
};

}  // namespace detail

/// Calls another observer at given times instead of after every step; see at_times().
template <class H, class Observer>
class AtTimes {
 public:
  using Scalar = typename DenseOutput<H>::Scalar;
  using State = typename DenseOutput<H>::State;
  static constexpr const char* name = "at_times";
  static constexpr bool interpolates = true;

  AtTimes(H hamiltonian, std::vector<Scalar> times, Observer&& observer, int nodes)
      : intervals_(std::move(hamiltonian), nodes),
        times_(std::move(times)),
        observer_(std::forward<Observer>(observer)),
        between_(dof_of(system())) {
    using std::isfinite;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      if (!isfinite(times_[i]))
        throw std::invalid_argument("at_times: time " + std::to_string(i) +
                                    " is NaN or Inf; give finite ones");
      if (i > 0 && times_[i] == times_[i - 1])
        throw std::invalid_argument("at_times: time " + std::to_string(i) +
                                    " is there twice; give each once");
      if (i > 0 && (times_[i] > times_[i - 1]) != (times_[1] > times_[0]))
        throw std::invalid_argument("at_times: the times neither rise nor fall throughout; sort them");
    }
  }

  /// Takes in the next state; false where the observer asked to stop.
  bool operator()(const Scalar& s, const State& z, const IntegrationReport& run = {}) {
    bool go_on = true;
    const std::size_t states = intervals_.dense.size();
    const Scalar end = states > 0 ? clock(states - 1) : s;
    detail::FirstException thrown;
    thrown.of([&] { intervals_.take(s, z, run, [&](std::size_t i) { go_on = look(i, run) && go_on; }); });
    if (orbit_ != intervals_.orbits()) {
      begin_orbit();
      if (states > 0) begin_times(end, run.dt > 0);
    }
    thrown.pass_on();
    return go_on;
  }

  /// Serves the last times: where fewer than nodes - 1 steps were taken from the start or the last event, or
  /// that lie behind the end by rounding.
  void finish() {
    intervals_.finish([this](std::size_t i) { look(i, {}); });
    const std::size_t states = intervals_.dense.size();
    if (states > 1) look(states - 2, {}, true);
    if (states != 1) return;  // a run of no step
    between_ = intervals_.dense.state(0);
    while (next_ < times_.size() && !(beyond(times_[next_], clock(0)) || beyond(clock(0), times_[next_])))
      serve(times_[next_++], {});
  }

  /// How many of the times the orbit has come to.
  std::size_t served() const { return next_; }
  /// The largest error of the interpolation at these times, estimated, relative to the size of the state; see
  /// DenseOutput::interpolation_error().
  const Scalar& interpolation_error() const { return intervals_.dense.interpolation_error(); }

  /// Whether it has seen nothing yet: a resumed run would miss the times before. The observer sees nothing
  /// until the first of the times.
  bool fresh() const { return intervals_.fresh() || (next_ > 0 && detail::is_fresh(observer_)); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("times", times_);
    intervals_.dense.describe(list);
    detail::describe_inner(list, observer_);
  }
  /// The states between which it interpolates, how many times were served, and what the observer remembers;
  /// see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    intervals_.visit_memory(visit);
    visit(next_);
    visit(orbit_);
    visit(shift_);
    rounding_.visit_memory(visit);
    detail::visit_inner(visit, observer_);
  }

 private:
  static constexpr bool extended = InExtendedPhaseSpace<H>;
  const H& system() const { return intervals_.dense.hamiltonian(); }

  /// Whether the time is one of the states alone. Else it is the run's, which ends where it was told to: that
  /// in the state is a sum of parts of steps, and strays with their rounding.
  static constexpr bool own_time = [] {
    if constexpr (extended)
      return !H::steps_in_time;
    else
      return false;
  }();

  /// Time of state i.
  Scalar clock(std::size_t i) const {
    if constexpr (own_time)
      return system().time(intervals_.dense.state(i));
    else
      return intervals_.dense.time(i) + shift_;
  }

  /// The only state is the first one of an orbit.
  void begin_orbit() {
    orbit_ = intervals_.orbits();
    if constexpr (extended && !own_time)
      shift_ = system().time(intervals_.dense.state(0)) - intervals_.dense.time(0);
    rounding_.begin(clock(0));
    see_rounding(0);
  }

  /// An orbit that begins at the `end` of the last one goes on with the times, any other is served anew those
  /// that do not lie before its start.
  void begin_times(const Scalar& end, bool forward) {
    const Scalar start = clock(0);
    const auto earlier = [&](const Scalar& a, const Scalar& b) {
      return forward ? beyond(b, a) : beyond(a, b);
    };
    if (!earlier(start, end) && !earlier(end, start)) return;
    while (next_ > 0 && !earlier(times_[next_ - 1], start)) --next_;
  }

  /// The time of state i is rounded as the run's is where it is made of that.
  void see_rounding(std::size_t i) {
    rounding_.see(clock(i));
    if (shift_ != Scalar(0)) rounding_.see(intervals_.dense.time(i));
  }

  /// Whether a is above b by more than the rounding of times: n·(T/n) need not be T, nor t0 + n·dt be 0; and
  /// a time within the state begins anew, without its compensation, wherever an event cuts a step. A shift is
  /// rounded, and what it is added to.
  bool beyond(const Scalar& a, const Scalar& b) const {
    const std::int64_t sums = own_time ? intervals_.arcs() : shift_ != Scalar(0) ? 2 : 0;
    return a - b > Scalar(double(2 + sums)) * Eigen::NumTraits<Scalar>::epsilon() *
                       std::max(rounding_.size(a), rounding_.size(b));
  }

  /// Serves the times of an interval. One that lies behind it by rounding waits for the next, or for
  /// finish(), which sees the `last` one, unless it is served as well from here.
  bool look(std::size_t i, const IntegrationReport& run, bool last = false) {
    const Scalar from = clock(i), to = clock(i + 1);
    see_rounding(i + 1);
    const bool forward = intervals_.dense.interval(i) > Scalar(0);
    bool go_on = true;
    detail::FirstException thrown;
    while (next_ < times_.size()) {
      const Scalar t = times_[next_];
      if (forward ? beyond(t, to) : beyond(to, t)) break;
      if ((forward ? t > to : t < to) && !last && outside(i, t - to) == Scalar(0)) break;
      if (forward ? beyond(from, t) : beyond(t, from))
        throw std::invalid_argument(
            "at_times: t = " + detail::in_words(t, 9) +
            " lies before the start of the run, or the run turned round before it; leave it out");
      ++next_;
      thrown.of([&] {
        intervals_.dense.after(i, where(i, t, from, to), between_);
        go_on = serve(t, run) && go_on;
      });
    }
    thrown.pass_on();
    return go_on;
  }

  /// Hands the observer the state `between_`, at the time t.
  bool serve(const Scalar& t, const IntegrationReport& run) {
    if constexpr (extended)
      return detail::notify_between(observer_, t, system().point(between_), run);
    else
      return detail::notify_between(observer_, t, std::as_const(between_), run);
  }

  /// The time x before or behind the interval after state i, where it is so small a part of that that the
  /// interpolation holds there, else 0.
  Scalar outside(std::size_t i, const Scalar& x) const {
    using std::abs;
    return !own_time && 64 * abs(x) <= abs(intervals_.dense.interval(i)) ? x : Scalar(0);
  }

  /// How long after state i the clock shows t.
  Scalar where(std::size_t i, const Scalar& t, const Scalar& from, const Scalar& to) {
    const Scalar interval = intervals_.dense.interval(i);
    const bool forward = interval > Scalar(0);
    if (forward ? !(t > from) : !(t < from)) return outside(i, t - from);
    if (forward ? !(t < to) : !(t > to)) return interval + outside(i, t - to);
    if constexpr (own_time) {
      const auto late = [&](const Scalar& x) {
        intervals_.dense.sought_after(i, x, between_);
        return Scalar(system().time(between_) - t);
      };
      return detail::bracketed_root(late, Scalar(0), Scalar(from - t), interval, Scalar(to - t));
    } else {
      const Scalar x = t - from;  // of rounded times: the interval bounds it
      return (x > interval) == forward ? interval : x;
    }
  }

  detail::Intervals<H> intervals_;
  std::vector<Scalar> times_;
  Observer observer_;
  State between_;
  std::size_t next_ = 0;
  std::int64_t orbit_ = 0;    ///< of those that were begun
  Scalar shift_ = Scalar(0);  ///< from the run's time to that of the orbit
  detail::TimeRounding<Scalar> rounding_;
};

/// `at_times(H, {0, 0.5, 1}, observer)`: an observer that calls another one, (t, z), at these times, which
/// rise or fall with the run, by interpolation between the steps (see DenseOutput). With a TimeTransformed
/// they are physical times, with an Autonomous those of the run, from the time in its first state on; z is
/// then the phase point without time. Call finish() at the end: the last ones wait for it where fewer than
/// nodes - 1 steps were taken from the start, or from the last event that changed the state, and so do those
/// behind the end by a rounding that is more than 1/64 of a step, or of a physical time. A named observer is
/// referred to, a temporary is kept. An orbit that begins at the time where the last one ended goes on with
/// the times; any other is served them anew, from its start on. Throws std::invalid_argument for times that
/// are not finite, not sorted, there twice, or lie before the start. What the observer throws is passed on
/// when the other times of the step were handed to it; a gradient that throws within the interpolation costs
/// the observer that time.
///
/// Where a step is long the states between are far worse than those at the steps: interpolation_error()
/// tells. If it is too large, shorten the steps, or end a run at each time by t_end. A time is met to its own
/// rounding, in which the state moves, too: 1e-4 at t = 1e12, and a unit in float at 1e7; twice that where
/// the run begins behind or ends before it by rounding.
template <class H, class Observer>
AtTimes<H, Observer> at_times(
    H hamiltonian, std::vector<std::type_identity_t<typename detail::HamiltonianDoor<H>::Scalar>> times,
    Observer&& observer, int nodes = 4) {
  return {std::move(hamiltonian), std::move(times), std::forward<Observer>(observer), nodes};
}

}  // namespace semiexplicit
