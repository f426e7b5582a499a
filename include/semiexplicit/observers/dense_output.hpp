#pragma once

#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/root.hpp>

namespace semiexplicit {

/// An observer that keeps the last few states of a run and knows what lies between them: Hermite interpolation of degree
/// 2 nodes - 1 by the states and their vector fields (∂H/∂p, -∂H/∂q). The error within a step of size h is of order
/// h^{2 nodes}: four nodes do for methods up to order 8. A gradient is called only where something is interpolated.
///
/// It says nothing beyond the states it holds, end() included: ready() tells whether these are as many as were asked for.
/// The state that it saw last, shown again as a run goes on from it, changes nothing; a time that turns round, or another state
/// at the same time, starts it anew.
template <Hamiltonian H>
class DenseOutput {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;

  /// Throws std::invalid_argument unless nodes is 2 to 8.
  explicit DenseOutput(H hamiltonian, int nodes = 4)
      : hamiltonian_(std::move(hamiltonian)), wanted_(static_cast<std::size_t>(nodes)) {
    if (nodes < 2 || nodes > 8)
      throw std::invalid_argument("DenseOutput: " + std::to_string(nodes) +
                                  " nodes; give 2 to 8, half the order of the method or a little more");
    const State zero(dof_of(hamiltonian_));
    kept_.assign(wanted_, Node{.z = zero, .field = zero.vector()});
  }

  /// Takes in the next state.
  void operator()(const Scalar& t, const State& z) { push(t, z); }
  /// The same; whether there is one more interval to look at.
  bool push(const Scalar& t, const State& z) {
    using std::abs;
    // The times of two runs that meet may differ by rounding.
    if (size_ > 0 && abs(t - end()) <= 64 * Eigen::NumTraits<Scalar>::epsilon() * abs(t)) {
      if (z.vector() == node(size_ - 1).z.vector()) return false;
      size_ = 0;
    }
    if (size_ > 1 && (t > end()) != (end() > begin())) size_ = 0;
    if (size_ == wanted_) {
      first_ = (first_ + 1) % wanted_;
      --size_;
    }
    Node& next = node(size_);
    next.t = t;
    next.z = z;
    next.has_field = false;
    return ++size_ > 1;
  }

  /// The number of states it holds, and the i-th of them, the oldest first.
  std::size_t size() const { return size_; }
  const Scalar& time(std::size_t i) const { return node(i).t; }
  const State& state(std::size_t i) const { return node(i).z; }

  /// Whether it holds as many states as it was told to; before that the interpolation is of a lower degree.
  bool ready() const { return size_ == wanted_; }
  const Scalar& begin() const { return node(0).t; }
  const Scalar& end() const { return node(size_ - 1).t; }

  /// z becomes the interpolated state at t, which must not lie outside begin() to end().
  void at(const Scalar& t, State& z) {
    z.vector().setZero();
    for (std::size_t j = 0; j < size_; ++j) {
      // Lagrange's polynomial of node j at t, and its slope at the node.
      Scalar polynomial(1), slope(0);
      for (std::size_t k = 0; k < size_; ++k) {
        if (k == j) continue;
        polynomial *= (t - time(k)) / (time(j) - time(k));
        slope += 1 / (time(j) - time(k));
      }
      const Scalar squared = polynomial * polynomial, after = t - time(j);
      z.vector() += (squared * (1 - 2 * after * slope)) * node(j).z.vector();
      z.vector() += (squared * after) * field(node(j));
    }
  }

  const H& hamiltonian() const { return hamiltonian_; }

  /// The states that it keeps; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (Node& one : kept_) {
      visit(one.t);
      visit(one.z.vector());
      visit(one.field);
      visit(one.has_field);
    }
    visit(first_);
    visit(size_);
  }

 private:
  struct Node {
    Scalar t = Scalar(0);
    State z;
    typename State::Storage field;  ///< dz/dt, where has_field
    bool has_field = false;
  };

  Node& node(std::size_t i) { return kept_[(first_ + i) % wanted_]; }
  const Node& node(std::size_t i) const { return kept_[(first_ + i) % wanted_]; }

  const typename State::Storage& field(Node& at) {
    if (!at.has_field) {
      const Eigen::Index d = at.z.dof();
      Scalar* const x = at.field.data();
      using Column = Eigen::Map<Vector<Scalar, H::Dof>>;
      hamiltonian_.gradient(at.z.q(), at.z.p(), Column(x + d, d), Column(x, d));
      for (Eigen::Index i = d; i < 2 * d; ++i) x[i] = -x[i];
      at.has_field = true;
    }
    return at.field;
  }

  H hamiltonian_;
  std::size_t wanted_, first_ = 0, size_ = 0;
  std::vector<Node> kept_;
};

namespace detail {

/// Hands the intervals of a run to look(dense, i), from state i to i + 1, each once, as soon as they can be interpolated to the
/// full degree.
template <class H, class Look>
void look_at_new_intervals(DenseOutput<H>& dense, bool& begun, const Look& look) {
  if (!dense.ready()) {
    begun = false;
    return;
  }
  for (std::size_t i = begun ? dense.size() - 2 : 0; i + 1 < dense.size(); ++i) look(i);
  begun = true;
}

}  // namespace detail

/// Calls another observer at given times instead of after every step; see at_times().
template <Hamiltonian H, class Observer>
class AtTimes {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;

  AtTimes(H hamiltonian, std::vector<Scalar> times, Observer&& observer, int nodes)
      : dense_(std::move(hamiltonian), nodes),
        times_(std::move(times)),
        observer_(std::forward<Observer>(observer)),
        between_(dof_of(dense_.hamiltonian())) {
    for (std::size_t i = 1; i < times_.size(); ++i)
      if (!((times_[i] > times_[i - 1]) == (times_[1] > times_[0]) && times_[i] != times_[i - 1]))
        throw std::invalid_argument("at_times: the times neither rise nor fall throughout; sort them");
  }

  void operator()(const Scalar& s, const State& z) {
    if (dense_.push(s, z)) detail::look_at_new_intervals(dense_, begun_, [this](std::size_t i) { look(i); });
  }

  /// Serves the times of a run that ended before it had as many states as the interpolation has nodes.
  void finish() {
    if (begun_) return;
    for (std::size_t i = 0; i + 1 < dense_.size(); ++i) look(i);
    begun_ = true;
  }

  /// How many of the times were served.
  std::size_t served() const { return next_; }

  /// Whether it has seen nothing yet: a run that goes on would miss the times before.
  bool fresh() const { return dense_.size() == 0; }

  /// The states between which it interpolates, and how many times were served; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    dense_.visit_memory(visit);
    visit(next_);
    visit(begun_);
  }

 private:
  /// Time of a state: its own, where it carries one.
  Scalar clock(const Scalar& s, const State& z) const {
    if constexpr (requires { dense_.hamiltonian().time(z); })
      return dense_.hamiltonian().time(z);
    else
      return s;
  }

  void look(std::size_t i) {
    const Scalar from = clock(dense_.time(i), dense_.state(i));
    const Scalar to = clock(dense_.time(i + 1), dense_.state(i + 1));
    const bool forward = to > from;
    while (next_ < times_.size()) {
      const Scalar& t = times_[next_];
      if (forward ? t > to : t < to) return;
      if (forward ? t < from : t > from)
        throw std::invalid_argument("at_times: a time lies before the start of the run; leave it out");
      dense_.at(where(i, t, from, to), between_);
      ++next_;
      if constexpr (requires { dense_.hamiltonian().point(between_); })
        observer_(t, dense_.hamiltonian().point(between_));
      else
        observer_(t, std::as_const(between_));
    }
  }

  /// The run's own parameter at which its clock shows t.
  Scalar where(std::size_t i, const Scalar& t, const Scalar& from, const Scalar& to) {
    if constexpr (requires { dense_.hamiltonian().time(between_); }) {
      const auto late = [&](const Scalar& s) {
        dense_.at(s, between_);
        return Scalar(clock(s, between_) - t);
      };
      return detail::bracketed_root(late, dense_.time(i), Scalar(from - t), dense_.time(i + 1),
                                    Scalar(to - t));
    } else {
      return t;
    }
  }

  DenseOutput<H> dense_;
  std::vector<Scalar> times_;
  Observer observer_;
  State between_;
  std::size_t next_ = 0;
  bool begun_ = false;
};

/// `at_times(H, {0, 0.5, 1}, observer)`: an observer that calls another one, (t, z), at these times, which rise or fall with
/// the run, by interpolation between the steps (see DenseOutput). With a TimeTransformed they are physical times, and z is
/// the phase point without time. Call finish() after a run of fewer than nodes - 1 steps. A named observer is referred to, a
/// temporary is kept. Throws std::invalid_argument for times that are not sorted or lie before the start.
template <Hamiltonian H, class Observer>
AtTimes<H, Observer> at_times(H hamiltonian, std::vector<typename H::Scalar> times, Observer&& observer,
                              int nodes = 4) {
  return {std::move(hamiltonian), std::move(times), std::forward<Observer>(observer), nodes};
}

}  // namespace semiexplicit
