#pragma once

#include <cstdint>
#include <exception>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/memory.hpp>
#include <semiexplicit/ensemble/ensemble_run.hpp>
#include <semiexplicit/ensemble/family.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit::detail {

/// Members that are stepped one by one, by Semiexplicit with any solver. Memory: 6d numbers each, and a
/// stepper a thread.
template <class Family, class Solver>
class PlainMembers {
 public:
  using H = MadeOf<Family, double>;
  using Stepper = Semiexplicit<H, Solver>;
  static constexpr int Dof = HamiltonianDoor<H>::Dof;
  static_assert(is_in_one_process<H>());
  using State = PhasePoint<double, Dof>;

  PlainMembers(const MemberHamiltonians<Family>& all, Eigen::Index size, Scheme<double> scheme, Solver solver)
      : first_(all.first([&](Eigen::Index i) { return all.plain(i); }), std::move(scheme), std::move(solver)),
        states_(static_cast<std::size_t>(size), State(first_.dof())),
        carried_(states_.size()) {}

  /// The run is made of so many tasks, which threads share.
  std::int64_t tasks() const { return static_cast<std::int64_t>(states_.size()); }

  template <class Watch>
  void run(const MemberHamiltonians<Family>& all, std::int64_t task, const EnsemblePart& part,
           MemberRecords& records, const Watch& watch) {
    const auto i = static_cast<std::size_t>(task);
    IntegrationReport& report = records.report[i];
    if (report.status != Status::success) return;
    std::optional<Stepper> stepper;
    std::exception_ptr observer_threw;
    Status told = Status::success;
    IntegrationReport seen = report;
    const auto tell = [&](double t, const State& z, const IntegrationReport& so_far) {
      seen = so_far;
      if (!watch.due(so_far.steps)) return true;
      try {
        told = watch(task, t, z, so_far, records.thrown[i]);
        return told == Status::success;
      } catch (...) {
        observer_threw = std::current_exception();
        return false;
      }
    };
    try {
      stepper.emplace(first_.with(all.plain(task)));
      if (!carried_[i].empty()) {
        CheckpointMemory restore(carried_[i], CheckpointMemory::Read::restore);
        stepper->visit_memory(restore);
      }
      report = integrate(*stepper, states_[i],
                         {.dt = part.dt,
                          .steps = part.until,
                          .on_failure = OnFailure::stop,
                          .subdivide = part.subdivide,
                          .t0 = part.t0,
                          .done = report},
                         tell);
      if (told == Status::observer_threw) report.status = told;
    } catch (...) {
      if (!stepper && part.begins()) tell(part.t0, states_[i], report);
      records.thrown[i] = thrown_in_words(stepper ? "the gradient" : "the family", std::current_exception());
      report = seen;
      report.status = Status::gradient_threw;
      report.dt = part.dt;
      report.t = part.time(report.steps);
    }
    report.seconds = 0;
    if (stepper) {
      CheckpointMemory memory;
      stepper->visit_memory(memory);
      carried_[i] = memory.bytes();
    }
    if (observer_threw) std::rethrow_exception(observer_threw);
  }

  const State& state(Eigen::Index member) const { return states_[static_cast<std::size_t>(member)]; }
  /// Of the size dof().
  void set_state(Eigen::Index member, const State& state) {
    states_[static_cast<std::size_t>(member)] = state;
    carried_[static_cast<std::size_t>(member)].clear();
  }

  /// The state and what the stepper carries; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Eigen::Index member, Visitor&& visit) {
    visit(states_[static_cast<std::size_t>(member)].vector());
    visit(carried_[static_cast<std::size_t>(member)]);
  }

  Eigen::Index dof() const { return first_.dof(); }
  const Scheme<double>& scheme() const { return first_.scheme(); }
  const Solver& solver() const { return first_.solver(); }

 private:
  Stepper first_;  ///< what the others are copies of, with Hamiltonians of their own
  std::vector<State> states_;
  std::vector<std::string> carried_;  ///< by the stepper from step to step; empty: nothing
};

}  // namespace semiexplicit::detail
