#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/words.hpp>

namespace semiexplicit {

/// How a step or a run ended. Only the first two move the state.
enum class Status {
  success,           ///< done, as accurately as the stopping rule asks
  rounding_limited,  ///< done: the iteration no longer shrank, but at the level of rounding, so nothing is
                     ///< left to gain
  no_convergence,  ///< the iteration used all its evaluations; the step is too large, or the tolerance out of
                   ///< reach
  not_finite,      ///< a gradient or a copy became NaN or Inf within the step
  invalid_state,   ///< the state has the wrong size, or is NaN or Inf itself
  invalid_step,    ///< dt is zero, NaN or Inf
  invalid_stepper,  ///< the stepper was moved from, or its step, solver or flow said `stopped`
  stopped,          ///< a run only: an observer returned false
  gradient_threw,   ///< a member of an Ensemble only: its gradient, or its family, threw an exception
  close_encounter,  ///< an exact flow only: bodies came closer than the limit of its scene
  invalid_monitor,  ///< of steps that follow a monitor function: it is not finite and positive, or grew too
                    ///< fast
  observer_threw    ///< a member of an Ensemble only: an observer of its own, by each(), threw an exception
};

/// Whether a step that ended so was done.
constexpr bool is_done(Status status) {
  return status == Status::success || status == Status::rounding_limited;
}

namespace detail {
/// The last of them, for who reads one from a file.
inline constexpr Status last_status = Status::observer_threw;
}  // namespace detail

/// What happened, in words, with the remedy.
SEMIEXPLICIT_COLD inline std::string describe(Status status) {
  switch (status) {
    case Status::success:
      return "success";
    case Status::rounding_limited:
      return "success, limited by rounding";
    case Status::no_convergence:
      return "the iteration did not converge; reduce dt, or loosen the stopping rule if the correction is "
             "near rounding";
    case Status::not_finite:
      return "the copies or a gradient became NaN or Inf within the step; reduce dt, or check the gradient "
             "near this state "
             "for a singularity";
    case Status::invalid_state:
      return "the state has another size than the Hamiltonian, or holds NaN or Inf; check the initial data";
    case Status::invalid_step:
      return "dt is zero, NaN or Inf; give a finite step other than zero";
    case Status::invalid_stepper:
      return "the stepper was moved from: use the one that it was moved to, or make a new one; or its step, "
             "solver or flow said `stopped`, which is for a run to say: let it return no_convergence";
    case Status::stopped:
      return "stopped by an observer";
    case Status::gradient_threw:
      return "the gradient, or the family that makes it, threw an exception";
    case Status::close_encounter:
      return "two bodies come closer than the limit of the scene, below which their interaction is not small "
             "and a step of an exact flow does not resolve it; integrate the scene without exactly<...>() "
             "and "
             "with a step that resolves the encounter, or lower the limit (Attraction::hill_radii)";
    case Status::invalid_monitor:
      return "the monitor function is not finite and positive here, or grew to more than about twice its "
             "value within a step, or the steps that follow it came to swing from one to the next, or take "
             "next to nothing of the time to t_end, as where an orbit runs away before; reduce dt, or check "
             "the monitor function near this state";
    case Status::observer_threw:
      return "an observer of this member threw an exception";
  }
  return "unknown status";
}

/// What one step did. `z` is as it was unless ok().
struct StepReport {
  Status status = Status::success;
  std::int64_t evaluations =
      0;  ///< of the residual f; for an explicit map 1, for a Runge-Kutta method its iterations
  std::int64_t gradients = 0;  ///< gradient calls
  double correction =
      0;  ///< size of the solver's next correction, ‖f‖/4 at the accepted point for the projection
  double rate =
      0;  ///< last observed contraction of the correction; above 1 the step is too large; 0: not seen
  int escalations = 0;  ///< with Robust: 0 simplified Newton made the step, 1 Broyden, 2 Newton-Krylov

  /// The step at which the simplified Newton method would contract by a half, judged from `rate`, seen at dt:
  /// an oscillation of frequency λ contracts by |sin(λ dt/2)|, a motion that grows as e^{λt} by (e^{λ dt} -
  /// 1)/2, and the smaller of the two answers is given. Has the sign of dt; dt itself where no rate was seen
  /// or it is below a half. An estimate, which may fail again: the iterations of other solvers and steppers,
  /// and a rate near 1, obey other laws.
  double advised_step(double dt) const {
    if (!(rate > 0.5 && std::isfinite(rate))) return dt;
    const double oscillating = (std::acos(-1.0) / 3) / (2 * std::asin(std::min(rate, 1.0)));
    const double growing = std::log(2.0) / std::log1p(2 * rate);
    return dt * std::min(oscillating, growing);
  }

  bool ok() const { return is_done(status); }
};

namespace detail {
/// Every number of a status and of a step's report; see CheckpointMemory.
template <class Visitor>
void visit_status(Visitor&& visit, Status& status) {
  auto number = static_cast<std::int32_t>(status);
  visit(number);
  if (number < 0 || number > static_cast<std::int32_t>(last_status))
    throw std::invalid_argument("a status that is none; start anew without it");
  status = static_cast<Status>(number);
}
template <class Visitor>
void visit_step(Visitor&& visit, StepReport& step) {
  visit_status(visit, step.status);
  for (auto* count : {&step.evaluations, &step.gradients}) visit(*count);
  for (auto* number : {&step.correction, &step.rate}) visit(*number);
  visit(step.escalations);
}
}  // namespace detail

/// What a solver did with the equation of the projection.
template <class Scalar>
struct SolverReport {
  Status status = Status::no_convergence;
  std::int64_t evaluations = 0;  ///< of the residual
  Scalar correction = 0;         ///< size e of the next correction
  Scalar rate = 0;               ///< e over the one before it; 0 after a single evaluation
  int escalations = 0;           ///< solvers that failed before the one that made this report; see Robust

  bool ok() const { return is_done(status); }
  /// What a step says of its solve.
  void tell(StepReport& report) const {
    report.status = status;
    report.evaluations = evaluations;
    report.correction = static_cast<double>(correction);
    report.rate = static_cast<double>(rate);
    report.escalations = escalations;
  }
};

/// What a run did.
struct IntegrationReport {
  Status status = Status::success;  ///< success, stopped, or why the last step failed
  double t = 0;                     ///< time of the state that is left in z
  double dt = 0;                    ///< the step; with t_end the one that ends there; 0: what observers
                                    ///< are shown was found between the steps, as by a section
  std::int64_t steps = 0;           ///< completed
  std::int64_t evaluations = 0;     ///< sum over the steps, a failed one included
  std::int64_t gradients = 0;       ///< likewise
  std::int64_t subdivided = 0;      ///< steps that had to be cut into parts; see IntegrationOptions
  std::int64_t changes = 0;         ///< of the state, by actions of events()
  double max_correction = 0;        ///< largest accepted correction
  double seconds = 0;               ///< wall clock, observers included
  bool at_event = false;            ///< what observers are shown is no end of a step, but an event within it;
                                    ///< in the end: the run ended there, and `done` does not go on with it
  StepReport last{};                ///< the last step's own report: where the run failed, what the solver saw
  double taken = 0;                 ///< the time of the last step, where the stepper chose it (ChoosesSteps)
  double part = 0;                  ///< of a step that an event cut: the time from the event, or the start of
                                    ///< the step, before; t may be too late to tell. 0: a whole step

  /// The run came to its end, or to where an observer stopped it.
  bool ok() const { return status == Status::success || status == Status::stopped; }
};

/// A step of integrate() failed. The state is the last good one; report() says how far the run came.
class IntegrationError : public std::runtime_error {
 public:
  IntegrationError(const IntegrationReport& report, double dt)
      : std::runtime_error(message(report, dt)), report_(report) {}
  const IntegrationReport& report() const { return report_; }

 private:
  SEMIEXPLICIT_COLD static std::string message(const IntegrationReport& r, double dt) {
    using detail::in_words;
    std::string text = "integrate: step " + std::to_string(r.steps + 1) +
                       " failed at t = " + in_words(r.t, 9) + " (dt = " + in_words(dt, 9) +
                       "): " + describe(r.status);
    if (r.last.correction > 0) {
      text += " (last correction " + in_words(r.last.correction, 3) + " after " +
              std::to_string(r.last.evaluations) + " evaluations";
      if (r.last.rate > 0) text += ", changing by a factor " + in_words(r.last.rate, 3) + " each";
      text += ")";
      if (r.status == Status::no_convergence && r.last.rate > 0.5)
        text += "; try a dt of about " + in_words(r.last.advised_step(dt), 3) +
                ", and a shorter one where that fails";
    }
    if (r.status == Status::no_convergence || r.status == Status::not_finite)
      text += "; where no dt helps, check_gradient(H, z) tells whether the gradient is right";
    return text;
  }
  IntegrationReport report_;
};

}  // namespace semiexplicit
