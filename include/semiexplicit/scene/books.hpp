#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/observers/run_clock.hpp>
#include <semiexplicit/scene/nearest_names.hpp>
#include <semiexplicit/scene/runtime_scene.hpp>
#include <semiexplicit/scene/scene.hpp>

namespace semiexplicit {

namespace detail {

/// ∫ f dt of a function whose values are seen one after the other: by the polynomial through the eight last
/// values over the interval in their middle, of order 8. Values may be spaced in any way, and time may turn:
/// of those that lie far closer to each other than the interval is long, or far off, some are left out, down
/// to the trapezoidal rule.
template <class Scalar>
class RunningIntegral {
 public:
  /// The value where the time is `interval` later than at the last one; without a last one the first.
  void see(const Scalar& interval, const Scalar& value) {
    if (count_ > 1 && (interval > Scalar(0)) != (times_[1] > times_[0])) {  // it has turned round
      const Scalar there = values_[last()];
      begin_anew();
      see(Scalar(0), there);
    }
    // Two times that are one but for rounding are one node.
    using std::abs;
    merged_ = !merged_ && count_ > 1 && 1000 * abs(interval) < abs(times_[last()] - times_[last() - 1]);
    if (merged_) {
      for (std::size_t i = 0; i < last(); ++i) times_[i] -= interval;
      return see_again(value);
    }
    if (count_ == nodes) {
      for (std::size_t i = 1; i < nodes; ++i) {
        times_[i - 1] = times_[i];
        values_[i - 1] = values_[i];
      }
      --count_;
    }
    // Times are those before the last value, which is at 0.
    for (std::size_t i = 0; i < static_cast<std::size_t>(count_); ++i) times_[i] -= interval;
    times_[static_cast<std::size_t>(count_)] = Scalar(0);
    values_[static_cast<std::size_t>(count_)] = value;
    ++count_;
    if (count_ < nodes) return;
    if (!full_) add(integral(0, 3));  // the first time also what lies before the middle
    full_ = true;
    add(integral(3, 4));
  }
  /// The last value is this one, as a run tells that goes on.
  void see_again(const Scalar& value) { values_[last()] = value; }
  /// What was seen so far counts, and f may go on from another value.
  void begin_anew() {
    if (count_ > 1) add(integral(full_ ? 4 : 0, last()));
    count_ = 0;
    full_ = false;
  }
  /// Up to the last value.
  Scalar value() const {
    return count_ < 2 ? sum_ + carry_ : sum_ + (carry_ + integral(full_ ? 4 : 0, last()));
  }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (Scalar& number : times_) visit(number);
    for (Scalar& number : values_) visit(number);
    visit(sum_);
    visit(carry_);
    visit(count_);
    visit(full_);
    visit(merged_);
  }

 private:
  static constexpr std::int64_t nodes = 8;
  static constexpr int most_uneven = 32;  ///< lengths that differ by more do not go together
  std::size_t last() const { return static_cast<std::size_t>(count_ - 1); }

  void add(const Scalar& part) {  // with the rounding errors kept
    const Scalar term = part + carry_, sum = sum_ + term;
    carry_ = term - (sum - sum_);
    sum_ = sum;
  }

  /// Between two of the nodes, of the polynomial through all, by Gauss's rule of four points, which is exact
  /// for it.
  Scalar integral(std::size_t from, std::size_t to) const {
    using std::sqrt;
    static const Scalar apart = 2 * sqrt(Scalar(6) / 5) / 7, uneven = sqrt(Scalar(30)) / 36,
                        points[] = {sqrt(Scalar(3) / 7 - apart), sqrt(Scalar(3) / 7 + apart)},
                        weights[] = {Scalar(1) / 2 + uneven, Scalar(1) / 2 - uneven};
    Scalar sum(0);
    for (std::size_t k = from; k < to; ++k) {
      const Scalar half = (times_[k + 1] - times_[k]) / 2, middle = times_[k] + half;
      const Nodes near = nodes_about(k);
      for (std::size_t i = 0; i < 2; ++i)
        for (const int sign : {-1, 1})
          sum += half * weights[i] * interpolated(near, middle + Scalar(sign) * half * points[i]);
    }
    return sum;
  }

  struct Nodes {
    std::array<std::size_t, static_cast<std::size_t>(nodes)> which{};
    std::size_t count = 0;
    void add(std::size_t i) { which[count++] = i; }
  };
  /// For the interval behind node k: a polynomial through neighbours at all distances would magnify their
  /// rounding, and its own error.
  Nodes nodes_about(std::size_t k) const {
    using std::abs;
    const Scalar length = abs(times_[k + 1] - times_[k]);
    Nodes near;
    // The next one on the way out from node `last`, n where there is none.
    const auto n = static_cast<std::size_t>(count_);
    const auto next_of = [&](std::size_t last, std::size_t step) {
      for (std::size_t i = last + step; i < n; i += step) {  // below 0 it is above n
        const Scalar gap = abs(times_[i] - times_[last]);
        if (gap > most_uneven * length) return n;
        if (gap * most_uneven >= length) return i;
      }
      return n;
    };
    for (std::size_t i = k; i < n; i = next_of(i, ~std::size_t{0})) near.add(i);
    std::reverse(near.which.begin(), near.which.begin() + static_cast<std::ptrdiff_t>(near.count));
    for (std::size_t i = k + 1; i < n; i = next_of(i, 1)) near.add(i);
    return near;
  }
  /// Neville's scheme.
  Scalar interpolated(const Nodes& near, const Scalar& t) const {
    std::array<Scalar, static_cast<std::size_t>(nodes)> f;
    for (std::size_t i = 0; i < near.count; ++i) f[i] = values_[near.which[i]];
    const auto time = [&](std::size_t i) { return times_[near.which[i]]; };
    for (std::size_t width = 1; width < near.count; ++width)
      for (std::size_t i = 0; i + width < near.count; ++i)
        f[i] += (t - time(i)) / (time(i + width) - time(i)) * (f[i + 1] - f[i]);
    return f[0];
  }

  std::array<Scalar, static_cast<std::size_t>(nodes)> times_{}, values_{};
  Scalar sum_ = Scalar(0), carry_ = Scalar(0);
  std::int64_t count_ = 0;
  bool full_ = false;
  bool merged_ = false;  ///< what was seen last, with the node before
};

}  // namespace detail

/// An observer that keeps account of the energy where a scene has effects with forces of their own
/// (OnMotion): the energy at the start and now, the work ∫ F·∂H/∂p dt of each of them, and the difference,
/// which is what the method, and the integral over the steps, get wrong. That integral is of order 8 in the
/// time between calls, so the books close as well as the method is accurate where steps resolve the motion.
/// Of a step that is 32 times as long as those beside it it is of order 2.
///
///     const Scene scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{},
///                       orbits::Drag<double, 2>{.linear = 0.01});
///     auto stepper = stepper_for(scene);
///     Books books(scene);
///     integrate(stepper, z, {.dt = 0.01, .steps = 1000}, books);
///     std::cout << books;                    // a table
///     books.difference();
///
/// A run may turn round, and events may change the state: what they do to the energy is by_events(). The
/// books go on from run to run, at whatever time the next one starts; a state that was changed in between
/// counts as changed by an event.
///
/// Asks for one gradient and each force a step. Has to see every step; takes part in checkpoints.
template <class ScalarType, int DofValue>
class Books {
 public:
  static constexpr const char* name = "Books";
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;

  explicit Books(RuntimeScene<Scalar, Dof> scene)
      : scene_(std::move(scene)), gradient_(scene_.dof()), last_(gradient_), force_(gradient_.q()) {
    for (const auto& effect : scene_.effects())
      if (effect.motion()) accounts_.push_back({effect, {}});
  }
  template <class... Effects>
  explicit Books(const Scene<Effects...>& scene) : Books(RuntimeScene<Scalar, Dof>(scene)) {}

  // Moving copies, as of the scene: no books are without their accounts.
  Books(const Books&) = default;
  Books& operator=(const Books&) = default;

  template <detail::HasHalves State>
  void operator()(const Scalar& t, const State& state, const IntegrationReport& run = {}) {
    static_assert(detail::is_state_of<State, Dof>());
    const In<Scalar, Dof> q = state.q(), p = state.p();
    detail::require_same_dof("Books", q.size(), "scene", last_.dof());
    const Scalar before = energy_;
    energy_ = scene_.energy(q, p);
    using Next = typename detail::RunClock<Scalar>::Next;
    const Next next = clock_.relation(t, q == last_.q() && p == last_.p(), run);
    const Scalar interval = next == Next::follows ? clock_.interval(t, run) : Scalar(0);
    clock_.set(t, run, next);
    last_.q() = q, last_.p() = p;
    if (next == Next::first) start_ = energy_;
    if (next == Next::changed || next == Next::anew) {
      changed_ += energy_ - before;
      for (Account& account : accounts_) account.work.begin_anew();
    }
    if (accounts_.empty()) return;
    scene_.gradient(q, p, gradient_.q(), gradient_.p());
    for (Account& account : accounts_) {
      force_.setZero();
      Out<Scalar, Dof> force(force_);
      account.effect.add_force(q, p, force);
      const Scalar power = detail::dot(force_, gradient_.p());
      if (next == Next::again)
        account.work.see_again(power);
      else
        account.work.see(interval, power);
    }
  }

  Scalar energy_at_start() const { return start_; }
  Scalar energy_now() const { return energy_; }
  /// The names of the effects whose work is counted.
  std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (const Account& account : accounts_) list.push_back(account.effect.name());
    return list;
  }
  /// What an effect has done so far. Throws std::invalid_argument, with the nearest valid names, for one that
  /// has no account.
  Scalar work(const std::string& effect) const {
    for (const Account& account : accounts_)
      if (account.effect.name() == effect) return account.work.value();
    throw std::invalid_argument(unknown_name("effect", effect, names()));
  }
  Scalar work() const {
    Scalar sum(0);
    for (const Account& account : accounts_) sum += account.work.value();
    return sum;
  }
  /// By how much events have changed the energy, or whoever changed the state between two runs; see events().
  Scalar by_events() const { return changed_; }
  /// Energy now, less that at the start, less all work and what events did: zero but for errors.
  Scalar difference() const { return (energy_ - start_) - work() - changed_; }

  /// Whether it has seen nothing yet.
  bool fresh() const { return !clock_.started(); }
  /// See Describable.
  template <class List>
  void describe(List& list) const {
    for (const std::string& effect : names()) list("account", effect);
    list.function("scene", GradientSize(scene_));  // with the forces
  }
  /// See CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(start_);
    visit(energy_);
    visit(changed_);
    visit(last_.vector());
    clock_.visit_memory(visit);
    for (Account& account : accounts_) account.work.visit_memory(visit);
  }

 private:
  struct Account {
    AnyEffect<Scalar, Dof> effect;
    detail::RunningIntegral<Scalar> work;
  };

  RuntimeScene<Scalar, Dof> scene_;
  PhasePoint<Scalar, Dof> gradient_, last_;  ///< the state that was seen last
  Vector<Scalar, Dof> force_;
  std::vector<Account> accounts_{};
  Scalar start_ = Scalar(0), energy_ = Scalar(0), changed_ = Scalar(0);
  detail::RunClock<Scalar> clock_;
};

template <class Scalar, int Dof>
Books(const RuntimeScene<Scalar, Dof>&) -> Books<Scalar, Dof>;
template <class... Effects>
Books(const Scene<Effects...>&) -> Books<typename Scene<Effects...>::Scalar, Scene<Effects...>::Dof>;

/// The books as a table, a line an entry.
template <class Scalar, int Dof>
std::ostream& operator<<(std::ostream& out, const Books<Scalar, Dof>& books) {
  std::vector<std::pair<std::string, Scalar>> lines{{"energy at the start", books.energy_at_start()}};
  for (const std::string& effect : books.names()) lines.emplace_back("work of " + effect, books.work(effect));
  if (books.by_events() != Scalar(0)) lines.emplace_back("by events", books.by_events());
  lines.emplace_back("energy now", books.energy_now());
  lines.emplace_back("difference", books.difference());
  std::size_t width = 0;
  for (const auto& [what, value] : lines) width = std::max(width, what.size());
  for (const auto& [what, value] : lines)
    out << what << std::string(width + 2 - what.size(), ' ')
        << detail::in_words(static_cast<double>(value), what == "difference" ? 2 : 15) << '\n';
  return out;
}

}  // namespace semiexplicit
