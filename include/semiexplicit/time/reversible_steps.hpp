#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/core/two_sum.hpp>
#include <semiexplicit/time/pace.hpp>

namespace semiexplicit {

namespace detail {

/// Compiles for a stepper whose Hamiltonian, where it says one, has steps of the time and is in one process.
template <class S>
consteval bool times_of_steps_are_free() {
  using H = SaidHamiltonian<S>;
  if constexpr (InExtendedPhaseSpace<H>)
    static_assert(H::steps_in_time,
                  "the Hamiltonian of this stepper is TimeTransformed, by which its steps follow a monitor "
                  "already: give ReversibleSteps a stepper of the Hamiltonian within, and one monitor for "
                  "both");
  return is_in_one_process<H>();
}

}  // namespace detail

/// Steps that follow the motion and can be undone: each takes about the time g(q, p) dt, where g > 0 is a
/// monitor function, the local time scale, and the density ρ = dt/time of the steps is carried from step to
/// step by a rule that is its own reverse,
///
///     ρ_{n+1/2} + ρ_{n-1/2} = 2/g(z_n),     t_{n+1} = t_n + dt/ρ_{n+1/2}.
///
/// It asks for values of g alone and for no energy, and takes any stepper whose step back undoes a step:
/// Semiexplicit, GaussLegendre, ExplicitSplitting, FlowSplitting, one of your own; MidpointProjection as far
/// as it is one. A step back with -dt undoes a step, and for reversible systems, H(q, -p) = H(q, p), that
/// stands in for symplecticity: integrable ones and those near them keep energy and actions without drift, as
/// with steps of one size. The map itself is not symplectic; TimeTransformed is, where H has its energy and g
/// a gradient.
///
///     ReversibleSteps stepper(Semiexplicit(H, schemes::low_defect8_s20()),
///                             [](const auto& q, const auto& p) { return ...; });
///     integrate(stepper, z, {.dt = 0.1, .t_end = 1000}, observers...);  // observer(t, z), t the time
///
/// dt is the step in the parameter s of TimeTransformed, time = g ds, so that the monitors of monitors.hpp
/// serve both. Dense output, sections, at_times() and all that observes take H itself and see physical times,
/// which are summed with compensation. With t_end the run ends there exactly: the last two steps are cut, and
/// can be undone still; where a run goes on after that, the densities swing a little more. What goes on from
/// step to step, ρ and the time, is among what a checkpoint saves. Tangent vectors are carried by the
/// derivative of each step at its own length. Events are told of as with any stepper, but may not change the
/// state: the compiler refuses that, since neither the density nor the times would follow the jump.
///
/// The first density is taken from a trial step to either side, so that the densities do not swing from step
/// to step, for that swing would stay. Where g more than doubles within a step, no density may be left: the
/// step fails with Status::invalid_monitor, and a smaller dt is the remedy. g is to be smooth on the scale of
/// a step; kinks of g are noise to the density.
///
/// Of the rules that can be undone this one is tied to g at every step, and no swing grows or decays by
/// itself. Measured on Kepler orbits, e = 0.9 to 0.999, thirty to two hundred steps an orbit, it is as stable
/// over 1e5 periods as ρ_{n+1/2} - ρ_{n-1/2} = -dt (∇g·X)/g (Hairer, Söderlind), which needs the derivative
/// along the motion; the product ρ_{n+1/2} ρ_{n-1/2} = 1/g², always positive, is not, its swing grows. But
/// where g varies within the longest steps, and then in chaotic motion above all, the swing takes a random
/// walk, the faster the longer the steps are. Where it comes to `most_swing` the density starts afresh, which
/// is the one step that cannot be undone; restarts() counts them. Where it does so within `least_between`
/// steps, the step fails with Status::invalid_monitor: energies would drift, and a smaller dt is the remedy.
///
/// Sources: W. Huang, B. Leimkuhler, SIAM J. Sci. Comput. 18 (1997) 239, the rule; S. Cirilli, E. Hairer, B.
/// Leimkuhler, BIT 39 (1999) 25, its start and its swing; E. Hairer, G. Söderlind, SIAM J. Sci. Comput. 26
/// (2005) 1838, why there is no drift.
template <class S, class G>
class ReversibleSteps {
  static_assert(detail::is_stepper<S>());
  static_assert(detail::is_monitor<G, typename S::Scalar, S::State::Dof>());
  static_assert(!ChoosesSteps<S>,
                "this stepper chooses the times of its steps already: give ReversibleSteps "
                "its inner stepper, and one monitor for both");
  static_assert(detail::times_of_steps_are_free<S>());

 public:
  using Scalar = typename S::Scalar;
  using State = typename S::State;
  using Fixed = S;  ///< takes steps of given times
  static constexpr int Dof = State::Dof;
  static constexpr const char* name = "ReversibleSteps";

  /// What goes on from step to step beside the state.
  struct Clock {
    Scalar time = Scalar(0), carry = Scalar(0);  ///< carry: what rounding cuts off the time
    Scalar density = Scalar(0);                  ///< 1/g of the state that it left; 0: it has left none
    Scalar slope = Scalar(0);                    ///< (ρ_{n+1/2} - ρ_{n-1/2})/(2 dt), the same backward
    Scalar taken = Scalar(0);                    ///< the time of the last step
    Scalar swing = Scalar(0);                    ///< see swing()
    std::int64_t since = 0, restarts = 0;        ///< since: steps since the density started afresh
  };
  /// The swing from which on the density starts afresh, and how many steps it has to last.
  static constexpr double most_swing = 0.15;
  static constexpr std::int64_t least_between = 10'000;
  static constexpr std::int64_t most_stale = 100'000;

  ReversibleSteps(S stepper, G monitor) : stepper_(std::move(stepper)), monitor_(std::move(monitor)) {
    if constexpr (requires { stepper_.dof(); })
      last_ = trial_ = scratch_ = State(Eigen::Index(stepper_.dof()));
  }

  /// A step of dt in s, which may be negative. z is untouched unless the report is ok(), and so are time and
  /// density; also where the gradient or the monitor throws. Only a density that swings too much is given up:
  /// the next step starts afresh. No heap use beyond the stepper's own.
  StepReport step(State& z, const Scalar& dt) {
    return advance(z, dt, [](const Scalar& time) { return time; });
  }

  /// The same, but not beyond t_end: what is left of less than two steps is taken in two halves, of less than
  /// one at once. Where `most_stale` steps, one after the other, were each less than 1e-12 of what is left,
  /// as on an orbit that runs away before t_end, the next one fails with Status::invalid_monitor.
  StepReport step_until(State& z, const Scalar& dt, const Scalar& t_end) {
    using std::abs;
    if (reached(t_end)) return {};
    const Scalar left = left_to(t_end);
    if (stale_ >= most_stale) return {.status = Status::invalid_monitor};
    if ((left > Scalar(0)) != (dt > Scalar(0))) return {.status = Status::invalid_step};
    bool last = false;
    const StepReport report = advance(z, dt, [&](const Scalar& time) {
      last = abs(left) <= abs(time);
      return last ? left : abs(left) < 2 * abs(time) ? Scalar(left / 2) : time;
    });
    if (report.ok()) stale_ = abs(left) > Scalar(1e12) * abs(clock_.taken) ? stale_ + 1 : 0;
    if (last && report.ok()) {
      clock_.time = t_end;
      clock_.carry = Scalar(0);
    }
    return report;
  }

  /// A run starts from z at the time t. Where z is the state that it left last, it goes on, or turns round,
  /// with the density of then.
  void begin(const State& z, const Scalar& t) {
    if (!continues(z)) clock_.density = Scalar(0);
    stale_ = 0;
    clock_.time = t;
    clock_.carry = Scalar(0);
  }

  /// Time of the state that it left last; the sum of its steps where there was no begin().
  Scalar time() const { return clock_.time; }
  /// Whether it has come to t, but for what t is rounded by. Steps below that rounding have a time() of t
  /// earlier.
  bool reached(const Scalar& t) const {
    using std::abs;
    const Scalar left = left_to(t);
    if (left == Scalar(0)) return true;
    return t == clock_.time &&
           (1000 * abs(left) < abs(clock_.taken) || (left > Scalar(0)) != (clock_.taken > Scalar(0)));
  }
  /// How long its last step was.
  Scalar taken() const { return clock_.taken; }

  /// How far the densities swing from step to step, lately: by this part of themselves to either side.
  Scalar swing() const {
    using std::abs;
    return abs(clock_.swing);
  }
  /// How often the density started afresh, since it swung too far.
  std::int64_t restarts() const { return clock_.restarts; }

  const Clock& clock() const { return clock_; }
  void rewind(const Clock& clock, const State& z) {
    clock_ = clock;
    last_ = z;
  }

  const S& stepper() const { return stepper_; }
  const G& monitor() const { return monitor_; }
  Eigen::Index dof() const requires requires(const S& s) { s.dof(); }
  { return stepper_.dof(); }
  decltype(auto) hamiltonian() const requires requires(const S& s) { s.hamiltonian(); }
  { return stepper_.hamiltonian(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const requires Describable<S> {
    list("stepper", stepper_);
    list.function("monitor", [this](const auto& q, const auto& p) {
      State z(q, p), scratch = z;
      return detail::pace<timed>(monitor_, z, scratch);
    });
  }
  /// Time, density, and what the stepper itself carries; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) requires HasMemory<S> {
    static_assert(detail::is_of_known_size<S>());
    stepper_.visit_memory(visit);
    visit(clock_.time);
    visit(clock_.carry);
    visit(clock_.density);
    visit(clock_.slope);
    visit(clock_.taken);
    visit(clock_.swing);
    visit(clock_.since);
    visit(clock_.restarts);
    visit(last_.vector());
  }

 private:
  static constexpr bool timed = InExtendedPhaseSpace<detail::SaidHamiltonian<S>>;

  Scalar left_to(const Scalar& t) const { return (t - clock_.time) - clock_.carry; }

  bool continues(const State& z) const {
    return clock_.density != Scalar(0) && z.vector().size() == last_.vector().size() &&
           z.vector() == last_.vector();
  }

  /// A step of dt in s, whose time `limit` may shorten.
  template <class Limit>
  StepReport advance(State& z, const Scalar& dt, const Limit& limit) {
    StepReport report{.status = detail::status_at_start(dt, is_whole(), fits(z))};
    if (!report.ok()) return report;
    // A start counts from the step on that succeeds.
    Clock clock = clock_;
    const bool goes_on = continues(z);
    if (!goes_on) {
      start(clock, z, dt, report);
      trial_ = z;
    }
    const Scalar rho = clock.density + dt * clock.slope;
    if (!usable(clock.density) || !usable(rho)) return failed(z, report);

    const Scalar whole = dt / rho, time = limit(whole);
    // The step in s that takes the time: ds/(density + ds slope) = time.
    const Scalar ds = time == whole ? dt : Scalar(time * clock.density / (1 - time * clock.slope));
    struct Back {  // also where the monitor throws
      State& z;
      const State& before;
      bool wanted = false;
      ~Back() {
        if (wanted) z = before;
      }
    } back{z, goes_on ? last_ : trial_};
    add(report, stepper_.step(z, time));
    if (!report.ok()) return report;
    back.wanted = true;
    const Scalar density = density_at(z, report);
    if (!usable(density)) {
      report.status = Status::invalid_monitor;
      return report;
    }
    using std::abs;
    using std::sqrt;
    // The slope of a step that is cut to next to nothing would be the rounding of the densities.
    if (abs(ds) > sqrt(Eigen::NumTraits<Scalar>::epsilon()) * abs(dt)) {
      clock.slope = (density - (time == whole ? rho : Scalar(ds / time))) / ds;
      clock.swing = next_swing(clock.swing, dt * clock.slope / density);
    }
    clock.density = density;
    if (abs(clock.swing) > Scalar(most_swing)) {
      clock.density = clock.swing = Scalar(0);
      if (clock.since < least_between) {
        clock_.density = Scalar(0);
        report.status = Status::invalid_monitor;
        return report;
      }
      ++clock.restarts;
    }
    back.wanted = false;
    ++clock.since;
    const auto [sum, lost] = detail::two_sum<Scalar>(clock.time, time + clock.carry);
    clock.carry = lost;
    clock.time = sum;
    clock.taken = time;
    clock_ = clock;
    last_ = z;
    return report;
  }

  /// The part of ρ_{n+1/2} g(z_n) - 1 that changes its sign at every step, averaged over some thirty steps:
  /// what follows the motion averages out.
  static Scalar next_swing(const Scalar& last, const Scalar& off) {
    const Scalar weight = Scalar(1) / 32, most = Scalar(1);
    return weight * std::clamp(off, Scalar(-most), most) - (1 - weight) * last;
  }

  /// Density and slope at a z that it has not come to itself; the slope from a trial step to either side, or
  /// to the one that can be gone.
  void start(Clock& clock, const State& z, const Scalar& dt, StepReport& report) {
    scratch_ = z;
    clock.density = density_at(z, report);
    clock.slope = clock.swing = Scalar(0);
    clock.since = 0;
    if (!usable(clock.density)) return;
    const Scalar time = dt / clock.density;
    Scalar change(0);
    int sides = 0;
    for (const Scalar& side : {Scalar(1), Scalar(-1)}) {
      trial_ = z;
      StepReport one = stepper_.step(trial_, side * time);
      const Scalar density = one.ok() ? density_at(trial_, one) : Scalar(0);
      report.gradients += one.gradients;
      report.evaluations += one.evaluations;
      if (!usable(density)) continue;
      change += side * (density - clock.density);
      ++sides;
    }
    if (sides == 0) return;
    const Scalar most = clock.density / 2;
    clock.slope = std::clamp(Scalar(change / static_cast<Scalar>(2 * sides)), Scalar(-most), most) / dt;
  }

  static StepReport failed(const State& z, StepReport report) {
    report.status = detail::all_finite(z.vector()) ? Status::invalid_monitor : Status::invalid_state;
    return report;
  }

  static void add(StepReport& report, const StepReport& step) {
    const std::int64_t evaluations = report.evaluations, gradients = report.gradients;
    report = step;
    report.evaluations += evaluations;
    report.gradients += gradients;
  }

  bool fits(const State& z) const {
    if constexpr (requires { stepper_.dof(); })
      return z.dof() == Eigen::Index(stepper_.dof());
    else
      return z.dof() > 0;
  }

  /// Whether it was not moved from.
  bool is_whole() const {
    if constexpr (requires { stepper_.dof(); })
      return last_.dof() == Eigen::Index(stepper_.dof());
    else
      return true;
  }

  static bool usable(const Scalar& density) {
    using std::isfinite;
    return isfinite(density) && density > Scalar(0);
  }

  Scalar density_at(const State& z, StepReport& report) {
    if constexpr (requires { monitor_.gradients(); }) report.gradients += monitor_.gradients();
    return 1 / detail::pace<timed>(monitor_, z, scratch_);
  }

  S stepper_;
  G monitor_;
  State last_, trial_, scratch_;
  Clock clock_;
  std::int64_t stale_ = 0;  ///< steps of next to no time, one after the other; see step_until()
};

}  // namespace semiexplicit
