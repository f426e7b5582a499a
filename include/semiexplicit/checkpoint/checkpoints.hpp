#pragma once

#include <algorithm>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <system_error>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/io/checkpoint_file.hpp>

namespace semiexplicit {

/// When checkpoints are written, and of what run.
struct CheckpointOptions {
  std::int64_t every = 0;  ///< after so many steps; 0: by the clock
  double seconds = 60;     ///< by the clock: not before so many seconds have passed since the last one
  /// Anything that tells this run from others, the parameters of H, say: a checkpoint with another text is
  /// refused.
  std::string run = "";

  /// Throws std::invalid_argument, in the name of `who`, where every is negative or seconds are not positive.
  void check(const std::string& who) const {
    if (every < 0) throw std::invalid_argument(who + ": every is negative; give steps, or 0");
    if (!(seconds > 0)) throw std::invalid_argument(who + ": seconds is not positive; give a time, 60 say");
  }
};

namespace detail {

/// Whether a function that has these values at the same place is the same: but for the rounding of another
/// compiler.
template <class Scalar>
bool same_but_for_rounding(const Scalar& there, const Scalar& here) {
  using std::abs;
  using std::isfinite;
  if (!isfinite(here)) return there == here;
  return abs(there - here) <= std::pow(std::numeric_limits<Scalar>::epsilon(), Scalar(0.875)) * abs(here);
}

/// Throws where the i-th function had another value where `who` was saved. NaN here tells nothing.
template <class State>
void require_same(const FunctionValues<State>& functions, std::size_t i, const typename State::Scalar& there,
                  const std::string& who) {
  constexpr int digits = std::numeric_limits<typename State::Scalar>::max_digits10;
  const auto& here = functions.values()[i];
  if (here == here && !same_but_for_rounding(there, here))
    throw std::invalid_argument("it belongs to another " + functions.names()[i] + ": where " + who +
                                " was saved this is " + in_words(there, digits) + " there, " +
                                in_words(here, digits) +
                                " here; give it the same parameters, or the run another file");
}

/// The lines by which a run is known, and those of the file: they must not differ.
inline void visit_settings(CheckpointMemory& memory, const std::string& here) {
  std::string settings = here;
  memory(settings);
  if (const std::string other = difference_of_lines(settings, here); !other.empty())
    throw std::invalid_argument("it belongs to another run: " + other +
                                "; give it the same settings, or another file");
}

/// How a run began, one state or those of all members, by its checksum: without it no resume() could take a
/// checkpoint.
class StartOfRun {
 public:
  void set(std::uint64_t checksum) { checksum_ = checksum; }
  /// After so many steps of the run, where after none checksum() is its start. Throws std::logic_error where
  /// that is not known, or another one.
  template <class Checksum>
  void require(std::int64_t steps, const Checksum& checksum) {
    if (steps == 0) {
      const std::uint64_t start = checksum();
      if (checksum_ && checksum_ != start)
        throw std::logic_error(
            "Checkpoints: save() at step 0 of another state than the run began with; give the report of the "
            "run, that of integrate(), or of another run Checkpoints of its own");
      set(start);
    }
    require_known();
  }
  /// What a resume() has put back after so many steps, which no run may begin with at step 0.
  void put_back(std::int64_t steps, std::uint64_t checksum) { put_back_ = {steps, checksum}; }
  /// Throws std::logic_error where a run goes on after so many steps with another state than was put back
  /// there; `remedy` says which one that was.
  template <class Checksum>
  void require_put_back(std::int64_t steps, const Checksum& checksum, const std::string& remedy) const {
    if (steps > 0 && put_back_ && put_back_->first == steps && put_back_->second != checksum())
      throw std::logic_error("Checkpoints: resume() put another state back to step " + std::to_string(steps) +
                             " than the run goes on from; " + remedy);
  }
  /// require() for a run that is shown, which may begin anew; std::logic_error where it begins with what was
  /// put back, `option` being where the result of resume() belongs.
  template <class Checksum>
  void follow(std::int64_t steps, const Checksum& checksum, const std::string& option) {
    if (steps == 0) {
      const std::uint64_t start = checksum();
      if (put_back_ && put_back_->second == start)
        throw std::logic_error(
            "Checkpoints: resume() put the state back to step " + std::to_string(put_back_->first) +
            ", and the run begins with it at step 0; give what resume() returns as " + option);
      set(start);
    }
    put_back_.reset();
    require_known();
  }
  /// Saves it, or compares it with that of the file: `another` is what that may be, in words.
  void visit(CheckpointMemory& memory, const std::string& another) const {
    std::uint64_t there = checksum_.value();
    memory(there);
    if (there != checksum_)
      throw std::invalid_argument("it belongs to a run from " + another + ", or another file");
  }

 private:
  void require_known() const {
    if (!checksum_)
      throw std::logic_error(
          "checkpoints of a run that goes on from an earlier part: how it began is not known; call resume() "
          "with the initial state first");
  }

  std::optional<std::uint64_t> checksum_;
  std::optional<std::pair<std::int64_t, std::uint64_t>> put_back_;
};

/// Whether both are one object.
template <class T, class Other>
bool is_same_object([[maybe_unused]] const T& one, [[maybe_unused]] const Other& other) {
  if constexpr (std::same_as<T, Other>)
    return &one == &other;
  else
    return false;
}

/// The counts of a report, its sums, and its last step.
inline void visit_sums(CheckpointMemory& memory, IntegrationReport& report) {
  for (auto* count :
       {&report.steps, &report.evaluations, &report.gradients, &report.subdivided, &report.changes}) {
    memory(*count);
    if (*count < 0 || *count > std::int64_t{1} << 62)
      throw std::invalid_argument("its counts cannot be; start anew without it");
  }
  for (auto* number : {&report.max_correction, &report.seconds}) memory(*number);
  visit_step(memory, report.last);
}

/// visit(from) puts everything back, and require() may say that it does not fit: where either throws nothing
/// is changed.
template <class Visit, class Require>
void restore_all_or_nothing(CheckpointMemory& from, const Visit& visit, const Require& require) {
  CheckpointMemory now;
  visit(now);
  try {
    const std::size_t begin = from.position();
    visit(from);
    require();
    CheckpointMemory again;
    visit(again);
    if (from.bytes().compare(begin, from.position() - begin, again.bytes()) != 0)
      throw std::invalid_argument(
          "what was put back is not there: visit_memory() of a stepper or an observer visits copies of its "
          "numbers, or changes them; let it visit the members themselves");
  } catch (...) {
    CheckpointMemory before(now.bytes(), CheckpointMemory::Read::restore);
    visit(before);
    throw;
  }
}

}  // namespace detail

/// An observer that saves a run from time to time, so that it can be gone on with after a crash: bit for bit
/// the same trajectory, times and reports. It saves the state, what the stepper carries from step to step,
/// and the memory of the observers that are named (Checkpointable: Invariants, Record, CsvTrajectory,
/// LyapunovExponents, at_times(), poincare_section(), every() of any observer, or your own). A run with other
/// options of the stepper, its solver or these observers is refused, and integrate() refuses to resume with
/// one of them that was not named.
///
///     IntegrationOptions<double> options{.dt = 0.01, .steps = 1'000'000'000};
///     Checkpoints checkpoints("run.checkpoint", {.every = 1'000'000}, stepper, options, invariants, csv);
///     options.done = checkpoints.resume(z);  // changes nothing where there is no such file
///     integrate(stepper, z, options, invariants, csv, checkpoints);
///     csv.commit();
///     checkpoints.remove();
///
/// Comes behind all observers that it can keep, for it saves what those before it have seen, and within none
/// but every(); the compiler refuses others. The file is written whole and flushed to the disk before it
/// takes the place of the one before; where that fails, std::runtime_error is thrown and the old one stays.
/// From resume(), or the first save, on it is locked as long as this object lives, and another run on it is
/// refused; in this process another object may resume from it and go on, which ends this one's right to the
/// file. Refers to the stepper and the observers, which must outlive it. `steps` may grow from run to run,
/// and `t_end` where the steps that it takes stay the same: it is refused where dt divides one of the times
/// only. What was shown at the t_end of then keeps that time, which may differ from t0 + n dt by its
/// rounding. A checkpoint holds for the compiler and the flags that the program was built with, as the last
/// bits of any floating-point result do.
template <class S, class... Observers>
class Checkpoints {
 public:
  static_assert(detail::is_checkpointable<S>() && (detail::is_checkpointable<Observers>() && ...));
  using Scalar = typename S::Scalar;
  using State = typename S::State;
  static constexpr bool saves_others = true;

  /// Throws std::invalid_argument where every is negative, seconds are not positive, or the stepper goes over
  /// ranks and every is not given.
  Checkpoints(const std::filesystem::path& path, CheckpointOptions options, S& stepper,
              const IntegrationOptions<Scalar>& run, Observers&... observers)
      : file_(path),
        options_(std::move(options)),
        stepper_(stepper),
        settings_(settings_of(stepper, run, options_.run, observers...)),
        observers_(observers...) {
    options_.check("Checkpoints");
    if constexpr (SumsOverRanks<detail::SaidHamiltonian<S>>)
      if (options_.every == 0)
        throw std::invalid_argument(
            "Checkpoints: the Hamiltonian has sum_over_ranks(), and by the clock its ranks would save after "
            "different steps; give .every");
  }

  /// Puts stepper, observers and z, which comes as the run began, back to where the file has them, and gives
  /// the report up to there but for dt, and for t unless the stepper ChoosesSteps, for
  /// IntegrationOptions::done. Where there is no such file it changes nothing and gives an empty report.
  /// Throws std::invalid_argument, naming file, reason and remedy, where the file is damaged or belongs to
  /// another run, and std::runtime_error where it cannot be written or another run that is alive has it open;
  /// z, the stepper and the observers are then untouched.
  IntegrationReport resume(State& z) {
    start_.set(checksum_of(z));
    last_time_ = Clock::now();
    IntegrationReport done;
    const bool found = file_.read([&](const std::string& contents) {
      using Read = CheckpointMemory::Read;
      State copy = z;
      CheckpointMemory restore(contents, Read::restore), check(contents, Read::check);
      visit_head(restore, done, copy);
      visit_head(check, done, copy);
      visit_all(check);
      if (!check.at_end()) throw std::invalid_argument("it holds more numbers than are asked for");
      if (done.steps == 0) return;  // nothing is done: the observers see the start again
      // A file that an observer counts on may turn out to be another one only here.
      detail::restore_all_or_nothing(
          restore, [this](CheckpointMemory& memory) { visit_all(memory); }, [] {});
      z = copy;
    });
    if (!found || done.steps == 0) return {};
    done_seconds_ = done.seconds;
    last_ = done.steps;
    start_.put_back(last_, checksum_of(z));
    if constexpr (ChoosesSteps<S>) {  // by which integrate() knows a copy, or another stepper
      done.t = static_cast<double>(stepper_.time());
      done.taken = static_cast<double>(stepper_.taken());
    }
    return done;
  }

  void operator()(const Scalar&, const State& z, const IntegrationReport& so_far) {
    if (so_far.at_event) return;  // a run is resumed at the end of a step
    start_.follow(
        so_far.steps, [&] { return checksum_of(z); }, "IntegrationOptions::done");
    if (so_far.steps < std::max(std::exchange(seen_, so_far.steps), last_)) {  // another run
      last_ = so_far.steps;
      next_look_ = 0;
    }
    if (so_far.steps == last_) return;
    // Not every step may be shown: the multiple of `every` may lie between two of them.
    if (options_.every > 0 ? so_far.steps / options_.every == last_ / options_.every
                           : !time_has_come(so_far.steps))
      return;
    save(z, so_far);
  }

  /// Writes a checkpoint now. Throws std::invalid_argument at an event within a step, where no run can be
  /// gone on with, and std::logic_error where so_far has no steps and z is not how the run began.
  void save(const State& z, const IntegrationReport& so_far) {
    if (so_far.at_event)
      throw std::invalid_argument(
          "Checkpoints: save() at an event within a step, from where a run cannot be resumed; save at the "
          "end of a step");
    start_.require(so_far.steps, [&] { return checksum_of(z); });
    IntegrationReport report = so_far;
    State copy = z;
    CheckpointMemory memory;
    report.seconds = done_seconds_ + since(begin_);
    visit_head(memory, report, copy);
    visit_all(memory);
    file_.write(memory.bytes());
    last_ = so_far.steps;
    last_time_ = Clock::now();
  }

  /// Whether this is the stepper that it saves.
  template <class Other>
  bool saves(const Other& stepper) const {
    return detail::is_same_object(stepper_, stepper);
  }
  /// Throws std::logic_error where a run is to go on after so many steps from another z than resume() put
  /// back. What resume() and save() would refuse of the file, its contents aside, it refuses as they do, and
  /// leaves all as it was.
  void require_start(const State& z, std::int64_t steps) const {
    file_.require_place();
    start_.require_put_back(
        steps, [&] { return checksum_of(z); }, "give integrate() the state that resume() was given");
  }

  /// Lines "what: value" of all that the run was made with, by which its checkpoints are known.
  const std::string& settings() const { return settings_; }

  /// Takes the file away: the run is done. Does nothing where there is none. Throws std::runtime_error where
  /// another run has it open.
  void remove() { file_.remove(); }

 private:
  using Clock = std::chrono::steady_clock;
  static double since(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  /// What tells whether the rest is wanted, the report and the state.
  void visit_head(CheckpointMemory& memory, IntegrationReport& report, State& z) {
    detail::visit_settings(memory, settings_);
    start_.visit(memory, "another initial state; give it the same one");
    std::int64_t dof = z.dof();
    memory(dof);
    if (dof != z.dof())
      throw std::invalid_argument("the state handed in has " + std::to_string(z.dof()) +
                                  " degrees of freedom, and the one that was saved " + std::to_string(dof));
    detail::visit_sums(memory, report);
    visit_state(memory, z);
    if (!detail::all_finite(z.q()) || !detail::all_finite(z.p()))
      throw std::invalid_argument("its state is NaN or Inf; start anew without it");
    visit_functions(memory, z);
  }

  /// The values of H's gradient and of the observers' functions where the run was saved: equal but for the
  /// rounding of another compiler, or they are other functions.
  void visit_functions(CheckpointMemory& memory, const State& z) {
    detail::FunctionValues<State> here(z);
    list_all(here, stepper_, observers_);
    for (std::size_t i = 0; i < here.values().size(); ++i) {
      Scalar there = here.values()[i];
      memory(there);
      detail::require_same(here, i, there, "it");
    }
  }

  /// Lists the stepper and the observers, all that tells this trajectory and what is seen of it from others
  /// beside H and the initial state.
  template <class List>
  static void list_all(List& list, const S& stepper, const std::tuple<Observers&...>& observers) {
    list("stepper", stepper.name);
    stepper.describe(list);
    if constexpr (detail::SaysItsHamiltonianOf<S, State::Dof>)  // whatever describe() lists
      list.function("Hamiltonian", GradientSize(stepper.hamiltonian()));
    int count = 0;
    std::apply([&](const auto&... observer) { (list("observer " + std::to_string(++count), observer), ...); },
               observers);
  }

  static std::string settings_of(const S& stepper, const IntegrationOptions<Scalar>& run,
                                 const std::string& label, Observers&... observers) {
    detail::OptionText list;
    list("run", label);
    list("bits of a number", std::numeric_limits<Scalar>::digits);
    // A dt that divides the time but for rounding is that of a shorter t_end; integrate() knows what it was.
    IntegrationOptions<Scalar> gone_on = run;
    gone_on.done = {.dt = static_cast<double>(run.dt), .steps = 1};
    list("dt", detail::with_steps<S>(gone_on).dt);
    list("t0", run.t0);
    list("subdivide", run.subdivide);
    list_all(list, stepper, std::tuple<Observers&...>(observers...));
    return list.text();
  }

  static void visit_state(CheckpointMemory& memory, State& z) {
    if constexpr (requires { z.a; }) {  // an ExtendedPoint
      memory(z.a.vector());
      memory(z.b.vector());
    } else {
      memory(z.vector());
    }
  }
  static std::uint64_t checksum_of(State z) {
    CheckpointMemory memory;
    visit_state(memory, z);
    return semiexplicit::checksum(memory.bytes());
  }

  void visit_all(CheckpointMemory& memory) {
    std::apply([&](auto&... observer) { (observer.visit_memory(memory), ...); }, observers_);
    stepper_.visit_memory(memory);  // after the observers, which may refuse
  }

  /// Reading the clock costs as much as a small step: it is looked at about a thousand times a second.
  bool time_has_come(std::int64_t step) {
    if (step < next_look_) return false;
    const double passed = since(last_look_);
    look_every_ = passed < 1e-3 ? std::min<std::int64_t>(2 * look_every_, 1 << 20)
                                : std::max<std::int64_t>(look_every_ / 2, 1);
    next_look_ = step + look_every_;
    last_look_ = Clock::now();
    return since(last_time_) >= options_.seconds;
  }

  detail::CheckpointFile file_;
  CheckpointOptions options_;
  S& stepper_;
  std::string settings_;
  std::tuple<Observers&...> observers_;
  detail::StartOfRun start_;
  double done_seconds_ = 0;
  std::int64_t last_ = 0, seen_ = 0, next_look_ = 0, look_every_ = 1;
  Clock::time_point begin_ = Clock::now(), last_time_ = begin_, last_look_ = begin_;
};

}  // namespace semiexplicit
