#pragma once

#include <algorithm>
#include <chrono>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/threads.hpp>
#include <semiexplicit/ensemble/ensemble_run.hpp>
#include <semiexplicit/ensemble/family.hpp>
#include <semiexplicit/ensemble/lane_members.hpp>
#include <semiexplicit/ensemble/plain_members.hpp>
#include <semiexplicit/io/checksum.hpp>

namespace semiexplicit {

/// Many members, stepped with Semiexplicit by the threads of OpenMP, and in the lanes of SIMD registers where
/// these can take the gradient and the solver (in_lanes(), how()). They differ in their initial conditions,
///
///     std::vector<PhasePoint<double, 5>> starts = ...;
///     Ensemble ensemble(systems::NlsLattice<double, 5>(), starts, schemes::low_defect6_s13<double>());
///     ensemble.run({.dt = 0.0125, .steps = 80'000});
///     ensemble.state(i); ensemble.report(i);
///
/// and may in their parameters, a column of numbers each; a family then is a function that makes a
/// Hamiltonian of a column, of numbers or of packs, whichever S is (see PackHamiltonian):
///
///     Ensemble pendulums([]<class S>(const S* k) { return Pendulum<S>{k[0]}; }, parameters, starts, scheme);
///
/// Lanes want such a gradient and SimplifiedNewton. With another solver, and with any other Hamiltonian, as
/// of from_energy(), the members are stepped one by one, which takes as long as Semiexplicit does for each.
///
/// A member's result depends on nothing but its start and parameters: not on the threads, not on the others.
/// One that fails stays at its last good state, with the reason in its report, and the others go on; so does
/// one whose gradient throws, or for whose parameters the family throws. Threads share the Hamiltonian's
/// copies' data, so a gradient that writes to memory of its own needs one a thread (thread_local, as
/// from_energy() has). Memory: 4d numbers a member, stepped one by one 6d, and its report.
template <class Family, class Solver = SimplifiedNewton>
class Ensemble {
  static constexpr bool lanes = detail::MakesPacks<Family> && std::same_as<Solver, SimplifiedNewton>;
  static_assert(lanes || detail::MakesPlain<Family>,
                "the members of this ensemble are stepped one by one, in double: give a Hamiltonian with "
                "`using Scalar = double;`, or a family that makes one of `const double*`");
  using Members =
      std::conditional_t<lanes, detail::LaneMembers<Family>, detail::PlainMembers<Family, Solver>>;

 public:
  static constexpr int Dof = Members::Dof;
  using State = PhasePoint<double, Dof>;
  static constexpr const char* name = "Ensemble";

  /// `parameters` has a column a member; the scheme is the usual one, low_defect6_s13, unless given. Throws
  /// std::invalid_argument where there is no member, where the sizes do not fit together or are below one,
  /// and unless the scheme passes its own check and the solver's options make sense; and what the family
  /// throws where it throws for all members.
  Ensemble(Family family, Eigen::MatrixXd parameters, const std::vector<State>& starts,
           Scheme<double> scheme = usual_scheme<double>(false), Solver solver = {})
      : hamiltonians_{std::move(family), std::move(parameters)},
        records_(checked(starts)),
        members_(hamiltonians_, size(), std::move(scheme), std::move(solver)) {
    if (dof() < 1)
      throw std::invalid_argument("Ensemble: the Hamiltonian has " + std::to_string(dof()) +
                                  " degrees of freedom; give it one at least");
    require_equal_sizes();
    for (Eigen::Index i = 0; i < size(); ++i) set_state(i, starts[static_cast<std::size_t>(i)]);
  }

  /// One Hamiltonian for all.
  template <class H>
  requires std::same_as<Family, detail::SameHamiltonian<H>> Ensemble(
      H hamiltonian, const std::vector<State>& starts, Scheme<double> scheme = usual_scheme<double>(false),
      Solver solver = {})
      : Ensemble(Family{std::move(hamiltonian)}, Eigen::MatrixXd(0, static_cast<Eigen::Index>(starts.size())),
                 starts, std::move(scheme), std::move(solver)) {}

  /// Takes every member to step `steps` from where it is. Observers are those of members (MemberObserver;
  /// each() of the library's) and those of the whole (WholeObserver), in any order. An exception of one by
  /// each() ends the run of its member (status `observer_threw`; failure() has the text). One of an observer
  /// of all members ends the run of those that are stepped together with the member (status `stopped`), and
  /// is thrown again when all the others have come to where all are together. Throws std::invalid_argument
  /// for options that make no sense, and std::logic_error where the ensemble was moved from.
  template <class... Observers>
  EnsembleReport run(const EnsembleOptions& options, Observers&&... observers) {
    constexpr bool whole = (!of_member<Observers> || ...);
    if (size() == 0) throw std::logic_error(moved_from);
    (require_observer(observers, options), ...);
    require(options);
    const auto start = Clock::now();
    const auto watch = std::apply(
        [&](const auto&... of_members) {
          return detail::MemberWatch<State, std::remove_cvref_t<decltype(of_members)>...>(options.every,
                                                                                          of_members...);
        },
        std::tuple_cat(if_of_member(observers)...));
    // Every observer hears of it, also when one before it asks to stop.
    const auto tell = [&](EnsembleReport report) {
      ((report.stopped = !notify(observers, report) || report.stopped), ...);
      return report;
    };

    EnsembleReport report;
    if (options.done == 0) {
      auto before = std::exchange(records_, detail::MemberRecords(records_.report.size()));
      for (IntegrationReport& one : records_.report) one.t = options.t0;
      try {
        report = tell(gathered(options, 0, start));
      } catch (...) {  // nothing has begun
        records_ = std::move(before);
        throw;
      }
    } else {
      report = gathered(options, options.done, start);
    }
    bool begun = options.done > 0;  // observers of members hear of the start also where there are no steps
    std::int64_t length = 1;        // of a part
    while ((report.done < options.steps || !begun) && !report.stopped) {
      begun = true;
      if (options.together > 0)
        length = options.together - report.done % options.together;
      else if (!whole)
        length = options.steps;
      const detail::EnsemblePart part{options.dt, options.t0, options.subdivide, report.done,
                                      std::min(options.steps - report.done, length) + report.done};
      const auto part_start = Clock::now();
      detail::for_each_in_parallel(members_.tasks(), options.threads, [&](std::int64_t task) {
        members_.run(hamiltonians_, task, part, records_, watch);
      });
      const double seconds = since(part_start);
      if (seconds < 0.25) length = std::min<std::int64_t>(2 * length, std::int64_t{1} << 40);
      if (seconds > 1) length = std::max<std::int64_t>(length / 2, 1);
      report = gathered(options, part.until, start);
      if (part.until > part.from) report = tell(report);
    }
    return report;
  }

  /// Whether members share the lanes of SIMD registers; else they are stepped one by one.
  static constexpr bool in_lanes() { return lanes; }
  /// That in words, with the reason.
  static std::string how() {
    if constexpr (lanes && pack_width == 1) {
      return "one member at a time: the standard library has no packs (<experimental/simd>)";
    } else if constexpr (lanes) {
      return std::to_string(pack_width) + " members at a time, in the lanes of SIMD registers";
    } else {
      std::string why = "the gradient takes no packs, see PackHamiltonian";
      if constexpr (detail::MakesPacks<Family>) {
        why = "only SimplifiedNewton goes in lanes";
        if constexpr (requires { std::string(Solver::name); }) why += std::string(", not ") + Solver::name;
      }
      return "one member at a time: " + why;
    }
  }

  /// 0 where it was moved from.
  Eigen::Index size() const { return static_cast<Eigen::Index>(records_.report.size()); }
  Eigen::Index dof() const { return members_.dof(); }
  /// Members count from 0; std::out_of_range, naming the member, is thrown beyond size() - 1, here and below.
  State state(Eigen::Index member) const {
    require_member(member);
    return members_.state(member);
  }
  void set_state(Eigen::Index member, const State& state) {
    require_member(member);
    if (state.dof() != dof())
      throw std::invalid_argument("Ensemble: member " + std::to_string(member) + " has " +
                                  std::to_string(state.dof()) + " degrees of freedom and the Hamiltonian " +
                                  std::to_string(dof()) + "; give all the same");
    members_.set_state(member, state);
  }
  /// Of the last run, whose wall clock it does not tell.
  const IntegrationReport& report(Eigen::Index member) const {
    require_member(member);
    return records_.report[static_cast<std::size_t>(member)];
  }
  /// Throws std::invalid_argument unless the members that can go on have taken so many steps.
  void require_done(std::int64_t done) const {
    for (const IntegrationReport& one : records_.report)
      if (one.status == Status::success && one.steps != done)
        throw std::invalid_argument(
            "Ensemble: " + std::to_string(done) + " steps are said to be done, and " +
            std::to_string(one.steps) +
            " are; give what EnsembleCheckpoints::resume() or the last run's report says");
  }
  /// Why a member failed in the last run, in words.
  std::string failure(Eigen::Index member) const {
    require_member(member);
    const std::string& thrown = records_.thrown[static_cast<std::size_t>(member)];
    return thrown.empty() ? semiexplicit::describe(report(member).status) : thrown;
  }
  /// A member's own Hamiltonian, of plain numbers; what the family throws for it comes out.
  auto hamiltonian(Eigen::Index member) const {
    require_member(member);
    return hamiltonians_.plain(member);
  }
  /// The size of a member's gradient where it is, by which its Hamiltonian is known; see GradientSize.
  double gradient_size(Eigen::Index member) const {
    return hamiltonians_.gradient_size(member, state(member));
  }
  /// The stepper that takes a member's steps alone: for an observer that wants one, as LyapunovExponents.
  auto stepper(Eigen::Index member) const { return Semiexplicit(hamiltonian(member), scheme(), solver()); }
  const Scheme<double>& scheme() const { return members_.scheme(); }
  const Solver& solver() const { return members_.solver(); }

  /// What all members share, and their parameters; see Describable.
  template <class List>
  void describe(List& list) const {
    list("members", size());
    list("degrees of freedom", dof());
    list("in lanes", lanes);
    list("scheme", scheme());
    list("solver", solver());
    const auto numbers = static_cast<std::size_t>(hamiltonians_.parameters.size());
    list(
        "checksum of the parameters",
        checksum({reinterpret_cast<const char*>(hamiltonians_.parameters.data()), numbers * sizeof(double)}));
  }
  /// States, what rounding has cut off them, and reports; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (std::size_t i = 0; i < records_.report.size(); ++i) {
      members_.visit_memory(static_cast<Eigen::Index>(i), visit);
      detail::visit_report(visit, records_.report[i]);
      visit(records_.thrown[i]);
    }
  }

 private:
  using Clock = std::chrono::steady_clock;
  static constexpr const char* moved_from =
      "Ensemble: it was moved from and has no members; use the one that it was moved to, or make a new one";

  static double since(Clock::time_point then) {
    return std::chrono::duration<double>(Clock::now() - then).count();
  }

  template <class O>
  static constexpr bool of_member = MemberObserver<std::remove_cvref_t<O>, State>;
  /// Whether it takes a time that is rounded, or a member's number as a time.
  template <class O>
  static consteval bool misplaces() {
    using Called = detail::Referred<O>;
    using Short = detail::AtPlace<Called, Eigen::Index, double, State>;
    using Long = detail::AtPlace<Called, Eigen::Index, double, State, IntegrationReport>;
    if constexpr (of_member<O>)
      return Short::template is_no_place<0>() || Short::template rounds<1>() ||
             Long::template is_no_place<0>() || Long::template rounds<1>();
    else
      return detail::AtPlace<Called, double, EnsembleReport>::template rounds<0>();
  }
  template <class O>
  static auto if_of_member(const O& observer) {
    if constexpr (of_member<O>)
      return std::tuple<const O&>(observer);
    else
      return std::tuple<>();
  }
  template <class O>
  static bool notify(O& observer, const EnsembleReport& report) {
    if constexpr (of_member<O>) {
      return true;
    } else if constexpr (std::same_as<std::remove_cvref_t<decltype(observer(report.t, report))>, bool>) {
      return observer(report.t, report);
    } else {
      observer(report.t, report);
      return true;
    }
  }

  template <class O>
  void require_observer(const O& observer, const EnsembleOptions& options) const {
    static_assert(
        of_member<O> || WholeObserver<O>,
        "this observer of an ensemble cannot be called: of members it takes (Eigen::Index member, "
        "double t, const State& state), of the whole (double t, const EnsembleReport& report); for one "
        "of integrate()'s a member give each(observers)");
    static_assert(!(of_member<O> && WholeObserver<O>),
                  "this observer of an ensemble can be called of members and of the whole, and one of both "
                  "would never be: give two observers");
    static_assert(
        !misplaces<std::remove_cvref_t<O>>(),
        "this observer of an ensemble takes the time as a whole number, or one of fewer digits than "
        "double, or the member as no whole one: of members write (Eigen::Index member, double t, const "
        "State& state), of the whole (double t, const "
        "EnsembleReport& report)");
    if constexpr (requires { detail::referred(observer).saves(*this); })
      if (!detail::referred(observer).saves(*this))
        throw std::invalid_argument(
            "Ensemble: the EnsembleCheckpoints among the observers save another ensemble, or a copy of this "
            "one: make them with the very one that is run");
    if constexpr (requires { detail::referred(observer).require_start(options.done); })
      detail::referred(observer).require_start(options.done);
    const auto require_seen = [&](bool fresh, const char* remedy) {
      if (fresh)
        throw std::invalid_argument("Ensemble: the run is resumed after step " +
                                    std::to_string(options.done) +
                                    ", and an observer knows nothing of what came before; " + remedy);
    };
    if constexpr (const auto& all = detail::referred(observer); requires {
                    { all.members() } -> std::same_as<Eigen::Index>;
                  }) {
      if (all.members() != size())
        throw std::invalid_argument("Ensemble: each() has " + std::to_string(all.members()) +
                                    " observers and the ensemble " + std::to_string(size()) +
                                    " members; give one a member");
      // Those of members whose run has ended see no more.
      const bool goes_on = options.done > 0 && options.every > 0;
      for (Eigen::Index i = 0; goes_on && i < size(); ++i)
        require_seen(report(i).ok() && all.fresh(i), "name it among those of EnsembleCheckpoints");
    } else if (options.done > 0 && (!of_member<O> || options.every > 0)) {
      require_seen(detail::is_fresh(observer),
                   "EnsembleCheckpoints keeps those of each() only: save this one yourself and put it back "
                   "before the run");
    }
  }

  void require(const EnsembleOptions& options) const {
    if (options.steps == options.not_given)
      throw std::invalid_argument("Ensemble: give steps, or there is no end");
    if (options.steps < 0 || options.every < 0 || options.threads < 0 || options.together < 0 ||
        options.done < 0)
      throw std::invalid_argument(
          "Ensemble: steps, every, threads, together and done must not be negative; to go back in time give "
          "a negative dt");
    detail::require_times("Ensemble", options.t0, options.steps, options.dt);
    detail::require_subdivide("Ensemble", options.subdivide);
    if (options.done > options.steps)
      throw std::invalid_argument("Ensemble: " + std::to_string(options.done) + " steps are done of " +
                                  std::to_string(options.steps) +
                                  "; steps counts those of the earlier part, too");
    if (options.done == 0) return;
    require_done(options.done);
    for (const IntegrationReport& one : records_.report) {
      if (one.status != Status::success) continue;
      detail::require_step("Ensemble", one, options.dt);
      detail::require_start("Ensemble", one, options.t0);
    }
  }

  void require_member(Eigen::Index member) const {
    if (size() == 0) throw std::out_of_range(moved_from);
    if (member < 0 || member >= size())
      throw std::out_of_range("Ensemble: there is no member " + std::to_string(member) +
                              "; they count from 0 to " + std::to_string(size() - 1));
  }

  std::size_t checked(const std::vector<State>& starts) const {
    const auto members = static_cast<Eigen::Index>(starts.size());
    if (members == 0) throw std::invalid_argument("Ensemble: no member; give one initial state at least");
    if (hamiltonians_.parameters.cols() != members)
      throw std::invalid_argument("Ensemble: " + std::to_string(members) + " initial states and " +
                                  std::to_string(hamiltonians_.parameters.cols()) +
                                  " columns of parameters; give one column a member");
    return starts.size();
  }

  /// A family could make Hamiltonians of any size.
  void require_equal_sizes() const {
    if constexpr (Dof == Eigen::Dynamic && detail::MakesPlain<Family>) {
      if (hamiltonians_.parameters.rows() == 0) return;
      const auto dof_of_member = [&](Eigen::Index i) {
        try {
          return dof_of(hamiltonians_.plain(i));
        } catch (...) {  // run() tells of it
          return dof();
        }
      };
      for (Eigen::Index i = 0; i < size(); ++i)
        if (const Eigen::Index own = dof_of_member(i); own != dof())
          throw std::invalid_argument("Ensemble: the Hamiltonian of member " + std::to_string(i) + " has " +
                                      std::to_string(own) + " degrees of freedom, and the first one has " +
                                      std::to_string(dof()) + "; give each size an ensemble of its own");
    }
  }

  EnsembleReport gathered(const EnsembleOptions& options, std::int64_t done, Clock::time_point start) const {
    EnsembleReport all{.members = size(),
                       .seconds = since(start),
                       .t = options.t0 + static_cast<double>(done) * options.dt,
                       .done = done};
    for (const IntegrationReport& one : records_.report) {
      all.failed += one.ok() ? 0 : 1;
      all.steps += one.steps;
      all.evaluations += one.evaluations;
    }
    return all;
  }

  detail::MemberHamiltonians<Family> hamiltonians_;
  detail::MemberRecords records_;
  Members members_;
};

template <class H, int Dof, class Solver = SimplifiedNewton>
Ensemble(H, const std::vector<PhasePoint<double, Dof>>&, Scheme<double> = usual_scheme<double>(false),
         Solver = {}) -> Ensemble<detail::SameHamiltonian<H>, Solver>;

}  // namespace semiexplicit
