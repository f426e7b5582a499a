#pragma once

#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/observer.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/observers/run_clock.hpp>

namespace semiexplicit {

/// What with_error_estimate() may be told.
struct ErrorEstimateOptions {
  int parts = 2;         ///< steps of the companion for one of the run; 1 where its method is a better one
  double parted = 0.01;  ///< error relative to |z| from which on nothing is said any more
};

/// Runs a companion beside a run and says how far the two are apart; see with_error_estimate().
template <Stepper S, class... Observers>
class ErrorEstimate {
 public:
  using Scalar = typename S::Scalar;
  using State = typename S::State;
  static constexpr const char* name = "with_error_estimate";
  static_assert(detail::is_stepper<S>());
  static_assert(detail::saves_no_run<Observers...>());
  static_assert(
      requires(const State& z) { z.vector(); },
      "with_error_estimate takes steppers of phase points, and this one moves two copies: take "
      "Semiexplicit or MidpointProjection");
  static_assert(detail::is_in_one_process<detail::SaidHamiltonian<S>>());
  static_assert(!ChoosesSteps<S>,
                "with_error_estimate takes a companion that steps by times: give stepper.stepper()");

  ErrorEstimate(S stepper, ErrorEstimateOptions options, Observers&&... observers)
      : stepper_(std::move(stepper)), options_(options), observers_(std::forward<Observers>(observers)...) {
    if (options_.parts < 1)
      throw std::invalid_argument("with_error_estimate: parts is below 1; give 2, or 1 for a better method");
    if (!(options_.parted > 0))
      throw std::invalid_argument("with_error_estimate: parted is not positive; give a relative error, 0.01");
    if constexpr (requires { stepper_.dof(); })
      companion_ = last_ = difference_ = State(Eigen::Index(stepper_.dof()));
  }

  /// Takes in the next state; false where an observer of the companion asked to stop. Throws
  /// std::invalid_argument where the state is of another size than the companion, where an event has changed
  /// it, and where every() hides steps of a run that chooses their lengths.
  bool operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    using std::abs;
    using Next = typename detail::RunClock<Scalar>::Next;
    if (run.changes > 0)
      throw std::invalid_argument(
          "with_error_estimate: an event has changed the state, which its companion knows nothing of; "
          "estimate "
          "the arcs between events by runs of their own");
    if constexpr (requires { stepper_.dof(); })
      detail::require_same_dof("with_error_estimate", z.vector().size() / 2, "companion",
                               Eigen::Index(stepper_.dof()), "give a stepper of the same system");
    const bool same =
        clock_.started() && z.vector().size() == last_.vector().size() && z.vector() == last_.vector();
    const Next next = clock_.relation(t, same, run);
    // Where steps are cut into parts the companion's would be those same parts, or fail as the run's did.
    if (run.subdivided > 0 && next == Next::follows) failed_ = true;
    if (next == Next::follows) {
      difference_.vector() = z.vector() - last_.vector();
      const Scalar way = size(difference_), time = clock_.interval(t, run);
      path_ += way;
      time_ += abs(time);
      longest_ =
          time != Scalar(0) && way * time_ > path_ * abs(time) ? Scalar(way * time_ / abs(time)) : path_;
      const std::int64_t steps = clock_.steps_since(t, run);
      if (steps > 1 && run.taken != 0)
        throw std::invalid_argument(
            "with_error_estimate: the steps of this run have lengths of their own, and it has to see each of "
            "them; take every() away from it");
      if (!parted_ && !failed_) go_on(time, steps);
    } else if (!same) {
      companion_ = difference_ = z;
      parted_ = failed_ = false;
      error_ = worst_ = path_ = time_ = longest_ = Scalar(0);
    }
    clock_.set(t, run, next);
    last_ = z;
    judge(t);
    return parted_ || tell(t, run);  // from there on the companion stands still
  }

  /// The error of (q, p) at the last state, in the Euclidean norm, without the work p_t of a driven system;
  /// nothing where the companion has parted from the run. No less than ε times the length of the path in
  /// phase space, or what that were at the speed of now where it is longer: the weights of a step are
  /// rounded, so that it takes a little more or less time than dt, and the companion's likewise.
  std::optional<Scalar> error() const { return said(error_); }
  /// The largest so far.
  std::optional<Scalar> worst() const { return said(worst_); }
  /// The error of f(q, p), a number, at the last state.
  template <class F>
  std::optional<Scalar> error_of(const F& f) const {
    using std::abs;
    return said(Scalar(factor() * abs(f(last_.q(), last_.p()) - f(companion_.q(), companion_.p()))));
  }
  /// Of two figures of one kind, one measured on the run and one on the companion by its observers, the error
  /// of the former; nothing where they have parted. No less than what rounding leaves of them.
  std::optional<Scalar> error_of(const Scalar& of_run, const Scalar& of_companion) const {
    using std::abs;
    return said(
        Scalar(factor() * abs(of_run - of_companion) + Eigen::NumTraits<Scalar>::epsilon() * abs(of_run)));
  }

  /// When the two parted, or a step of the companion failed; nothing where they have not.
  std::optional<Scalar> parted_at() const { return parted_ ? std::optional(parted_at_) : std::nullopt; }
  /// The companion's state, which is the better one. Where they have parted it is that at parted_at(), or,
  /// where a step had failed or was cut into parts, the one before.
  const State& companion() const { return companion_; }
  /// Gradient calls of the companion.
  std::int64_t gradients() const { return gradients_; }

  /// Whether it has seen nothing yet: a resumed run would lack the error of its beginning.
  bool fresh() const { return !clock_.started(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("companion", stepper_);
    list("parts", options_.parts);
    list("parted", options_.parted);
    std::apply([&](const auto&... observer) { (detail::describe_inner(list, observer), ...); }, observers_);
  }
  /// The companion, and what its observers remember; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    static_assert(detail::is_of_known_size<S>());
    if constexpr (detail::is_checkpointable<S>()) stepper_.visit_memory(visit);
    visit(companion_.vector());
    visit(last_.vector());
    visit(parted_);
    visit(parted_at_);
    visit(error_);
    visit(worst_);
    visit(path_);
    visit(time_);
    visit(longest_);
    visit(gradients_);
    clock_.visit_memory(visit);
    std::apply([&](auto&... observer) { (detail::visit_inner(visit, observer), ...); }, observers_);
  }

 private:
  /// With half the step and a method of order p the difference is 1 - 2^-p of the error: exact for p = 2, an
  /// upper bound above.
  Scalar factor() const { return options_.parts > 1 ? Scalar(4) / 3 : Scalar(1); }

  /// ‖z‖, without time and work, (t, p_t), where these are coordinates.
  Scalar size(const State& z) const {
    if constexpr (requires { stepper_.hamiltonian(); })
      return detail::state_size(stepper_.hamiltonian(), z);
    else
      return detail::norm(z.vector());
  }

  std::optional<Scalar> said(const Scalar& value) const {
    return parted_ ? std::nullopt : std::optional<Scalar>(value);
  }

  void go_on(const Scalar& time, std::int64_t steps) {
    if (steps == 0) return;
    const std::int64_t parts = options_.parts * steps;
    const Scalar part = time / Scalar(parts);
    State& ahead = difference_;  // a gradient may throw, or fail, between two parts
    ahead = companion_;
    for (std::int64_t i = 0; i < parts; ++i) {
      const StepReport report = stepper_.step(ahead, part);
      gradients_ += report.gradients;
      if (report.ok()) continue;
      failed_ = true;  // an estimate is no reason to end a run
      return;
    }
    std::swap(companion_, ahead);
  }

  void judge(const Scalar& t) {
    if (parted_) return;
    difference_.vector() = last_.vector() - companion_.vector();
    const Scalar apart = factor() * size(difference_);
    error_ = apart + Eigen::NumTraits<Scalar>::epsilon() * longest_;
    if (failed_ || !(apart <= Scalar(options_.parted) * size(last_))) {
      parted_ = true;
      parted_at_ = t;
      failed_ = false;
    } else if (error_ > worst_) {
      worst_ = error_;
    }
  }

  bool tell(const Scalar& t, const IntegrationReport& run) {
    bool go_on = true;
    std::apply(
        [&](auto&... observer) {
          ((go_on = detail::notify(observer, t, std::as_const(companion_), run) && go_on), ...);
        },
        observers_);
    return go_on;
  }

  S stepper_;
  ErrorEstimateOptions options_;
  std::tuple<Observers...> observers_;
  State companion_, last_, difference_;
  bool parted_ = false, failed_ = false;
  Scalar parted_at_ = Scalar(0), error_ = Scalar(0), worst_ = Scalar(0);
  Scalar path_ = Scalar(0), time_ = Scalar(0);  ///< of the run, without sign
  Scalar longest_ = Scalar(0);                  ///< the path, or what it is at the speed of now
  std::int64_t gradients_ = 0;
  detail::RunClock<Scalar> clock_;
};

/// An observer by which a run knows its error: a companion starts from the same state and goes along, by two
/// steps for each of the run, and how far the two are apart is the error of the run, while it is small.
///
///     auto estimate = with_error_estimate(stepper);  // a copy; or another method, {.parts = 1}
///     integrate(stepper, z, {.dt = 0.01, .t_end = 100}, estimate);
///     if (const auto error = estimate.error()) ...  // of (q, p); estimate.error_of(f) of any number f(q, p)
///
/// Where neighbouring orbits part the difference grows to the size of the orbit, and then tells nothing: from
/// the first moment on at which it passes `parted` of |z| there is no estimate, and parted_at() says when.
/// Observers of the companion see its states, up to the last one before parted_at(): a figure that is
/// measured on both runs, a period or a precession, has the error error_of(on_the_run, on_the_companion).
///
/// No estimate either from the first step on that was cut into parts (IntegrationOptions::subdivide). A run
/// that begins at another state than the last one seen begins a new estimate; one that begins at that state
/// goes on with it, whatever its t0.
///
/// An observer and no stepper, so that the run stays what it is, bit for bit, and takes any stepper of
/// phase points: one that chooses its steps as well, around which the companion halves each (give it
/// `stepper.stepper()`, and no every()). Costs twice the gradient calls of the run. Errors that both have in
/// common, a wrong H or a start that is off, it cannot see. With a TimeTransformed both are compared at the
/// same s, and the time is left out: the error at the same time is another.
///
/// Source: E. Hairer, S. Nørsett, G. Wanner, Solving Ordinary Differential Equations I, 2nd ed., section II.4
/// (Richardson).
template <Stepper S, class... Observers>
ErrorEstimate<S, Observers...> with_error_estimate(S stepper, ErrorEstimateOptions options,
                                                   Observers&&... observers) {
  return {std::move(stepper), options, std::forward<Observers>(observers)...};
}
template <Stepper S>
ErrorEstimate<S> with_error_estimate(S stepper) {
  return {std::move(stepper), {}};
}

}  // namespace semiexplicit
