#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble/ensemble_run.hpp>
#include <semiexplicit/ensemble/family.hpp>
#include <semiexplicit/ensemble/semiexplicit_pack.hpp>
#include <semiexplicit/integrate.hpp>

namespace semiexplicit::detail {

/// A member by itself, the same in all lanes, as a stepper that drops the carry where Semiexplicit does: at a
/// point that its last step did not make.
template <class H>
class LaneAlone {
 public:
  using Scalar = double;
  using State = PackPoint<H::Dof>;

  LaneAlone(SemiexplicitPack<H> stepper, const State& start) : stepper_(std::move(stepper)), next_(start.z) {}

  StepReport step(State& z, const double& dt) {
    if (!continues(z)) z.drop_carry();
    const StepReport report = stepper_.step(z, dt)[0];
    if (report.ok())
      next_ = z.z;
    else if (!z.has_carry())  // a sum that was not finite: no point goes on from there
      next_.assign(next_.size(), Many(std::numeric_limits<double>::quiet_NaN()));
    return report;
  }
  bool continues(const State& z) const {
    for (std::size_t i = 0; i < next_.size(); ++i)
      if (!(z.z[i][0] == next_[i][0])) return false;
    return true;
  }

 private:
  SemiexplicitPack<H> stepper_;
  std::vector<Many> next_;
};

/// A run of up to a register full of members, in lockstep. One that fails is left behind with its report.
struct PackRun {
  std::array<Eigen::Index, static_cast<std::size_t>(pack_width)> member{};  ///< by lanes
  LaneChoice going{};
  std::array<IntegrationReport, static_cast<std::size_t>(pack_width)> report{};
  std::int64_t steps = 0;
  std::exception_ptr family_threw, gradient_threw, observer_threw;

  /// Steps to the end of the part, or to where a gradient or an observer throws. in_parts(k) tries the failed
  /// step of lane k in parts.
  template <class H, class InParts, class Watch>
  void advance(SemiexplicitPack<H>& stepper, PackPoint<H::Dof>& point, const EnsemblePart& part,
               const InParts& in_parts, MemberRecords& records, const Watch& watch) {
    PackReport step{};
    bool stepped = false;
    gradient_threw = nullptr;
    while (steps < part.until && going != LaneChoice{} && !observer_threw) {
      try {
        step = stepper.step(point, part.dt, going);
      } catch (...) {
        gradient_threw = std::current_exception();
        break;
      }
      ++steps;
      stepped = true;
      for (std::size_t k = 0; k < going.size(); ++k)
        if (going[k]) count(k, step[k], in_parts);
      if (watch.due(steps)) {
        for (std::size_t k = 0; k < going.size(); ++k)
          if (going[k]) report[k].last = step[k];
        tell(point, part, records, watch);
      }
    }
    for (std::size_t k = 0; k < going.size(); ++k) {
      report[k].t = part.time(report[k].steps);
      if (!going[k]) continue;
      if (stepped) report[k].last = step[k];
      if (observer_threw) report[k].status = Status::stopped;
    }
  }

  /// Tells the observers where those are that go on.
  template <int Dof, class Watch>
  void tell(const PackPoint<Dof>& point, const EnsemblePart& part, MemberRecords& records,
            const Watch& watch) {
    try {
      for (std::size_t k = 0; k < going.size(); ++k) {
        if (!going[k]) continue;
        const Status status = watch(member[k], part.time(steps), point.lane(k), report[k],
                                    records.thrown[static_cast<std::size_t>(member[k])]);
        if (status == Status::success) continue;
        report[k].status = status;
        going[k] = false;
      }
    } catch (...) {
      observer_threw = std::current_exception();
    }
  }

 private:
  template <class InParts>
  void count(std::size_t k, StepReport& step, const InParts& in_parts) {
    report[k].evaluations += step.evaluations;
    report[k].gradients += step.gradients;
    if (!step.ok()) {
      report[k].last = step;
      if (!in_parts(k)) {
        if (report[k].status == Status::success) report[k].status = step.status;
        going[k] = false;
        return;
      }
      step = report[k].last;
    }
    ++report[k].steps;
    report[k].max_correction = std::max(report[k].max_correction, step.correction);
  }
};

/// Members that are stepped a register full at a time, by SemiexplicitPack. Memory: 4d numbers each.
template <class Family>
class LaneMembers {
 public:
  using H = MadeOf<Family, Many>;
  static constexpr int Dof = H::Dof;
  using State = PhasePoint<double, Dof>;

  LaneMembers(const MemberHamiltonians<Family>& all, Eigen::Index size, Scheme<double> scheme,
              SimplifiedNewton solver)
      : size_(size),
        first_(all.first([&](Eigen::Index i) { return all.family(all.packs(i, true).data()); }),
               std::move(scheme), solver),
        points_(static_cast<std::size_t>((size_ + width - 1) / width), PackPoint<Dof>(first_.dof())) {}

  /// The run is made of so many tasks, which threads share.
  std::int64_t tasks() const { return static_cast<std::int64_t>(points_.size()); }

  template <class Watch>
  void run(const MemberHamiltonians<Family>& all, std::int64_t task, const EnsemblePart& part,
           MemberRecords& records, const Watch& watch) {
    const Eigen::Index first = task * width;
    PackRun run;
    run.steps = part.from;
    for (Eigen::Index k = 0; k < width && first + k < size_; ++k) {
      run.member[lane(k)] = first + k;
      run.report[lane(k)] = records.report[static_cast<std::size_t>(first + k)];
      run.report[lane(k)].dt = part.dt;
      run.going[lane(k)] = run.report[lane(k)].status == Status::success;
    }
    PackPoint<Dof>& point = points_[static_cast<std::size_t>(task)];
    const std::vector<Many> parameters = all.packs(first);
    if (part.begins() && watch.due(0)) run.tell(point, part, records, watch);
    if (auto stepper = made(all, parameters, run))
      run.advance(
          *stepper, point, part,
          [&](std::size_t k) { return in_parts(all, k, point, run, k, part, records); }, records, watch);
    // Some member's family or gradient throws: each goes on alone, in all lanes.
    if (run.family_threw || run.gradient_threw)
      for (std::size_t k = 0; k < run.going.size(); ++k)
        if (run.going[k]) run_alone(all, k, point, run, part, records, watch);
    for (Eigen::Index k = 0; k < width && first + k < size_; ++k)
      records.report[static_cast<std::size_t>(first + k)] = run.report[lane(k)];
    if (run.observer_threw) std::rethrow_exception(run.observer_threw);
  }

  State state(Eigen::Index member) const { return point_of(member).lane(lane(member)); }
  /// Of the size dof(). Lanes beyond the last member do as it does.
  void set_state(Eigen::Index member, const State& state) {
    const Eigen::Index end = member + 1 < size_ ? member + 1 : (member / width + 1) * width;
    for (Eigen::Index i = member; i < end; ++i) point_of(member).set_lane(lane(i), state);
  }

  /// The state and what rounding has cut off it; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Eigen::Index member, Visitor&& visit) {
    PackPoint<Dof>& point = point_of(member);
    std::vector<double> numbers;
    for (auto* list : {&point.z, &point.carry}) {
      numbers.clear();
      for (const Many& x : *list) numbers.push_back(x[lane(member)]);
      visit(numbers);
      if (numbers.size() != list->size())
        throw std::invalid_argument("a member has another number of degrees of freedom there");
      for (std::size_t i = 0; i < numbers.size(); ++i) (*list)[i][lane(member)] = numbers[i];
    }
  }

  Eigen::Index dof() const { return first_.dof(); }
  const Scheme<double>& scheme() const { return first_.scheme(); }
  const SimplifiedNewton& solver() const { return first_.solver(); }

 private:
  static constexpr Eigen::Index width = pack_width;
  using Stepper = SemiexplicitPack<H>;

  static std::size_t lane(Eigen::Index member) { return static_cast<std::size_t>(member % width); }
  const PackPoint<Dof>& point_of(Eigen::Index member) const {
    return points_[static_cast<std::size_t>(member / width)];
  }
  PackPoint<Dof>& point_of(Eigen::Index member) { return points_[static_cast<std::size_t>(member / width)]; }

  /// What steps members of such parameters; nothing where the family throws, which the run then knows.
  std::optional<Stepper> made(const MemberHamiltonians<Family>& all, const std::vector<Many>& parameters,
                              PackRun& run) const {
    try {
      return first_.with(all.family(parameters.data()));
    } catch (...) {
      run.family_threw = std::current_exception();
      return std::nullopt;
    }
  }

  /// The step of lane k of the point, that of the run's member in lane `who`, in parts.
  SEMIEXPLICIT_COLD bool in_parts(const MemberHamiltonians<Family>& all, std::size_t k, PackPoint<Dof>& point,
                                  PackRun& run, std::size_t who, const EnsemblePart& part,
                                  MemberRecords& records) const {
    if (part.subdivide == 0) return false;
    const std::vector<Many> parameters = all.packs(run.member[who], true);
    PackPoint<Dof> copies = point.alone(k);
    const IntegrationOptions<double> options{.dt = part.dt, .subdivide = part.subdivide};
    try {
      LaneAlone<H> alone(first_.with(all.family(parameters.data())), copies);
      const bool done = step_in_parts(alone, copies, options, run.report[who]);
      if (!alone.continues(copies)) copies.drop_carry();
      point.take(k, copies);
      return done;
    } catch (...) {
      gave_up(run.report[who], records.thrown[static_cast<std::size_t>(run.member[who])], "the gradient",
              std::current_exception());
      return false;
    }
  }

  template <class Watch>
  void run_alone(const MemberHamiltonians<Family>& all, std::size_t k, PackPoint<Dof>& point, PackRun& run,
                 const EnsemblePart& part, MemberRecords& records, const Watch& watch) {
    PackRun alone;
    alone.member[0] = run.member[k];
    alone.going[0] = true;
    alone.report[0] = run.report[k];
    alone.steps = run.steps;
    alone.observer_threw = run.observer_threw;
    PackPoint<Dof> copies = point.alone(k);
    const std::vector<Many> parameters = all.packs(run.member[k], true);
    const auto parts = [&](std::size_t) {
      const bool done = in_parts(all, 0, copies, alone, 0, part, records);
      copies = copies.alone(0);
      return done;
    };
    if (auto stepper = made(all, parameters, alone))
      alone.advance(*stepper, copies, part, parts, records, watch);
    std::string& words = records.thrown[static_cast<std::size_t>(run.member[k])];
    if (alone.family_threw) gave_up(alone.report[0], words, "the family", alone.family_threw);
    if (alone.gradient_threw) gave_up(alone.report[0], words, "the gradient", alone.gradient_threw);
    point.take(k, copies);
    run.report[k] = alone.report[0];
    run.observer_threw = alone.observer_threw;
  }

  static void gave_up(IntegrationReport& report, std::string& words, const char* who,
                      const std::exception_ptr& thrown) {
    report.status = Status::gradient_threw;
    words = thrown_in_words(who, thrown);
  }

  Eigen::Index size_;
  Stepper first_;  ///< what the others are copies of, with Hamiltonians of their own
  std::vector<PackPoint<Dof>> points_;
};

}  // namespace semiexplicit::detail
