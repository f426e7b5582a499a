#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <vector>

#include <Eigen/Core>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/observer.hpp>
#include <semiexplicit/core/report.hpp>

namespace semiexplicit {

/// How far to go with all members of an ensemble, and how.
struct EnsembleOptions {
  double dt = 0;  ///< the step; negative goes back in time
  static constexpr std::int64_t not_given = -1;
  std::int64_t steps = not_given;  ///< how many, those of `done` included
  std::int64_t every =
      1;            ///< the observers of members hear of the start and of every so many steps; 0: of none
  int threads = 0;  ///< 0: what OpenMP takes; one a task at most. Without OpenMP there is one
  double t0 = 0;    ///< time of the states, or of the first ones where the run goes on
  /// A step of a member that does not converge or is not finite is tried again in parts; see
  /// IntegrationOptions::subdivide.
  int subdivide = 0;
  /// After so many steps all members are together, and the observers of the whole are called. 0: about twice
  /// a second, where there are any. It changes no result.
  std::int64_t together = 0;
  /// Steps of an earlier part, which the run goes on from; see EnsembleCheckpoints::resume().
  std::int64_t done = 0;
};

/// What a run of all members did; each has its own report beside.
struct EnsembleReport {
  Eigen::Index members = 0, failed = 0;
  std::int64_t steps = 0;        ///< completed, of all members together
  std::int64_t evaluations = 0;  ///< likewise
  double seconds = 0;            ///< wall clock of this part of the run
  double t = 0;                  ///< time of the members that neither failed nor were stopped
  std::int64_t done = 0;         ///< steps of each of these
  bool stopped = false;  ///< by an observer of the whole; run() goes on where EnsembleOptions::done says so

  bool ok() const { return failed == 0; }
};

/// What Ensemble::run() tells of each member: any callable (member, t, state), or (member, t, state,
/// IntegrationReport), which is the member's so far but for status, t and seconds. Of Eigen::Index, double
/// and PhasePoint. Called by several threads at once for different members. One that returns the bool false
/// ends the run of that member (status `stopped`).
template <class O, class State>
concept MemberObserver = std::invocable<const O&, Eigen::Index, double, const State&> ||
    std::invocable<const O&, Eigen::Index, double, const State&, const IntegrationReport&>;

/// What Ensemble::run() tells when all members are together, at the start, the end and in between: any
/// callable (t, EnsembleReport), Progress or EnsembleCheckpoints, say. One that returns the bool false ends
/// the run there.
template <class O>
concept WholeObserver = std::invocable<O&, const double&, const EnsembleReport&>;

/// An observer of members that has one of the library's, or of yours, for each; see each().
template <class Observer>
class Each {
 public:
  explicit Each(std::vector<Observer>& observers) : observers_(&observers) {}

  template <class State>
  bool operator()(Eigen::Index member, double t, const State& state, const IntegrationReport& run) const {
    return detail::notify((*observers_)[static_cast<std::size_t>(member)], t, state, run);
  }
  Eigen::Index members() const { return static_cast<Eigen::Index>(observers_->size()); }
  /// Whether that of a member has seen nothing yet, and must not be left out where a run is resumed.
  bool fresh(Eigen::Index member) const {
    return detail::is_fresh((*observers_)[static_cast<std::size_t>(member)]);
  }

 private:
  std::vector<Observer>* observers_;
};

/// `each(observers)`: an observer for each member, of integrate()'s kind, in the order of the members. They
/// are referred to. One that throws, as LyapunovExponents without a tangent map, ends the run of its member
/// (status `observer_threw`); what an observer of all members throws ends the run of all.
///
///     std::vector<LyapunovExponents<...>> exponents;  // one made with ensemble.stepper(i) for each member i
///     ensemble.run({.dt = 0.1, .steps = 1000}, each(exponents));
template <class Observer>
Each<Observer> each(std::vector<Observer>& observers) {
  return Each<Observer>(observers);
}

namespace detail {

/// A part of a run, from one step to another.
struct EnsemblePart {
  double dt, t0;
  int subdivide;
  std::int64_t from, until;

  double time(std::int64_t n) const { return t0 + static_cast<double>(n) * dt; }
  /// The state before the first step is shown where the run begins.
  bool begins() const { return from == 0; }
};

/// What was thrown, and by whom.
inline std::string thrown_in_words(const std::string& who, const std::exception_ptr& thrown) {
  try {
    std::rethrow_exception(thrown);
  } catch (const std::exception& error) {
    return who + " threw: " + error.what();
  } catch (...) {
    return who + " threw something that is no std::exception";
  }
}

/// What is known of every member.
struct MemberRecords {
  explicit MemberRecords(std::size_t members) : report(members), thrown(members) {}
  std::vector<IntegrationReport> report;
  std::vector<std::string> thrown;  ///< by gradients and observers, in words
};

/// Calls the observers of members, and knows when.
template <class State, class... Observers>
class MemberWatch {
 public:
  MemberWatch(std::int64_t every, const Observers&... observers) : every_(every), observers_(observers...) {}

  bool due(std::int64_t steps) const { return sizeof...(Observers) > 0 && every_ > 0 && steps % every_ == 0; }
  /// `success`; `stopped`: one of them wants this member to stop; `observer_threw`: one of its own threw,
  /// what `threw` then says. All hear of it.
  Status operator()(Eigen::Index member, double t, const State& state, const IntegrationReport& run,
                    std::string& threw) const {
    bool go_on = true;
    std::apply(
        [&](const auto&... observer) {
          ((go_on = tell(observer, member, t, state, run, threw) && go_on), ...);
        },
        observers_);
    return go_on ? Status::success : threw.empty() ? Status::stopped : Status::observer_threw;
  }

 private:
  template <class O>
  static bool tell(const Each<O>& each, Eigen::Index member, double t, const State& state,
                   const IntegrationReport& run, std::string& threw) {
    try {
      return each(member, t, state, run);
    } catch (...) {
      threw = thrown_in_words("an observer of this member", std::current_exception());
      return false;
    }
  }
  template <class O>
  static bool tell(const O& observer, Eigen::Index member, double t, const State& state,
                   const IntegrationReport& run, std::string&) {
    const auto call = [&]() -> decltype(auto) {
      if constexpr (std::invocable<const O&, Eigen::Index, double, const State&, const IntegrationReport&>)
        return observer(member, t, state, run);
      else
        return observer(member, t, state);
    };
    if constexpr (std::same_as<std::remove_cvref_t<decltype(call())>, bool>) {
      return call();
    } else {
      call();
      return true;
    }
  }

  std::int64_t every_;
  std::tuple<const Observers&...> observers_;
};

/// Every number of a report but the wall clock; see CheckpointMemory.
template <class Visitor>
void visit_report(Visitor&& visit, IntegrationReport& report) {
  visit_status(visit, report.status);
  visit_step(visit, report.last);
  for (auto* count : {&report.steps, &report.evaluations, &report.gradients, &report.subdivided})
    visit(*count);
  for (auto* number : {&report.t, &report.dt, &report.max_correction}) visit(*number);
}

}  // namespace detail
}  // namespace semiexplicit
