#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <exception>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble/pack_run.hpp>
#include <semiexplicit/ensemble/threads.hpp>

namespace semiexplicit {

/// What a run of all members did; each has its own report beside.
struct EnsembleReport {
  Eigen::Index members = 0, failed = 0;
  std::int64_t steps = 0;        ///< completed, of all members together
  std::int64_t evaluations = 0;  ///< likewise
  double seconds = 0;            ///< wall clock

  bool ok() const { return failed == 0; }
};

namespace detail {

/// The family whose members all have the same Hamiltonian.
template <class H>
struct SameHamiltonian {
  H hamiltonian;
  template <class S>
  const H& operator()(const S*) const {
    return hamiltonian;
  }
};

}  // namespace detail

/// Many members, stepped with Semiexplicit in the lanes of SIMD registers (SemiexplicitPack) and by the threads of OpenMP.
/// They differ in their initial conditions,
///
///     std::vector<PhasePoint<double, 5>> starts = ...;
///     Ensemble ensemble(systems::NlsLattice<double, 5>(), starts, schemes::low_defect6_s13<double>());
///     ensemble.run({.dt = 0.0125, .steps = 80'000});
///     ensemble.state(i); ensemble.report(i);
///
/// and may in their parameters, a column of numbers each; a family then is a function that makes a Hamiltonian of a column,
/// of numbers or of packs, whichever S is (see PackHamiltonian):
///
///     Ensemble pendulums([]<class S>(const S* k) { return Pendulum<S>{k[0]}; }, parameters, starts, scheme);
///
/// A member's result depends on nothing but its start and parameters: not on the threads, not on the others. One that fails
/// stays at its last good state, with the reason in its report, and the others go on; so does one whose gradient throws.
/// Memory: 4d numbers a member and its report.
template <class Family>
class Ensemble {
  using Many = detail::Many;

 public:
  using PackH =
      std::remove_cvref_t<decltype(std::declval<const Family&>()(static_cast<const Many*>(nullptr)))>;
  static constexpr int Dof = PackH::Dof;
  using State = PhasePoint<double, Dof>;

  /// `parameters` has a column a member. Throws std::invalid_argument where there is no member, where the sizes do not
  /// fit together, and unless the scheme passes its own check.
  Ensemble(Family family, Eigen::MatrixXd parameters, const std::vector<State>& starts, Scheme<double> scheme,
           SimplifiedNewton solver = {})
      : family_(std::move(family)),
        parameters_(std::move(parameters)),
        size_(checked(starts)),
        first_(family_(columns(0).data()), std::move(scheme), solver),
        points_(static_cast<std::size_t>((size_ + width - 1) / width), PackPoint<Dof>(first_.dof())),
        reports_(starts.size()),
        thrown_(starts.size()) {
    for (Eigen::Index i = 0; i < size_; ++i) set_state(i, starts[static_cast<std::size_t>(i)]);
    // Lanes beyond the last member do as it does.
    for (Eigen::Index i = size_; i % width != 0; ++i) points_.back().set_lane(lane(i), starts.back());
  }

  /// One Hamiltonian for all.
  template <PackHamiltonian H>
  Ensemble(H hamiltonian, const std::vector<State>& starts, Scheme<double> scheme,
           SimplifiedNewton solver = {})
      : Ensemble(Family{std::move(hamiltonian)}, Eigen::MatrixXd(0, static_cast<Eigen::Index>(starts.size())),
                 starts, std::move(scheme), solver) {}

  /// Takes every member `steps` steps from where it is. observe(member, t, state) is called at the start and after every
  /// `every` steps, by several threads at once for different members. An exception of the observer ends the run of the pack
  /// that it was told of (status `stopped`), and is thrown again when the others are done. Throws std::invalid_argument for
  /// negative steps, `every` or threads.
  template <class Observer>
  EnsembleReport run(const EnsembleOptions& options, const Observer& observe) {
    if (options.steps < 0 || options.every < 0 || options.threads < 0)
      throw std::invalid_argument(
          "Ensemble: steps, every and threads must not be negative; to go back in time give a negative dt");
    const auto start = std::chrono::steady_clock::now();
    for (std::string& words : thrown_) words.clear();
    reports_.assign(reports_.size(), {});
    detail::for_each_in_parallel(static_cast<std::int64_t>(points_.size()), options.threads,
                                 [&](std::int64_t pack) { run_pack(pack, options, observe); });
    EnsembleReport all{.members = size_};
    for (const IntegrationReport& one : reports_) {
      all.failed += one.ok() ? 0 : 1;
      all.steps += one.steps;
      all.evaluations += one.evaluations;
    }
    all.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return all;
  }
  EnsembleReport run(EnsembleOptions options) {
    options.every = 0;
    return run(options, [](Eigen::Index, double, const State&) {});
  }

  Eigen::Index size() const { return size_; }
  /// Members count from 0; std::out_of_range, naming the member, is thrown beyond size() - 1, here and below.
  State state(Eigen::Index member) const {
    require_member(member);
    return points_[static_cast<std::size_t>(member / width)].lane(lane(member));
  }
  void set_state(Eigen::Index member, const State& state) {
    require_member(member);
    if (state.dof() != first_.dof())
      throw std::invalid_argument("Ensemble: member " + std::to_string(member) + " has " +
                                  std::to_string(state.dof()) + " degrees of freedom and the Hamiltonian " +
                                  std::to_string(first_.dof()) + "; give all the same");
    points_[static_cast<std::size_t>(member / width)].set_lane(lane(member), state);
  }
  /// Of the last run, whose wall clock it does not tell.
  const IntegrationReport& report(Eigen::Index member) const {
    require_member(member);
    return reports_[static_cast<std::size_t>(member)];
  }
  /// Why a member failed in the last run, in words.
  std::string failure(Eigen::Index member) const {
    require_member(member);
    const std::string& thrown = thrown_[static_cast<std::size_t>(member)];
    return thrown.empty() ? describe(report(member).status) : thrown;
  }
  /// A member's own Hamiltonian, of plain numbers.
  auto hamiltonian(Eigen::Index member) const {
    require_member(member);
    return family_(parameters_.col(member).data());
  }
  const Scheme<double>& scheme() const { return first_.scheme(); }

 private:
  static constexpr Eigen::Index width = pack_width;
  using Stepper = SemiexplicitPack<PackH>;

  static std::size_t lane(Eigen::Index member) { return static_cast<std::size_t>(member % width); }
  void require_member(Eigen::Index member) const {
    if (member < 0 || member >= static_cast<Eigen::Index>(reports_.size()))
      throw std::out_of_range("Ensemble: there is no member " + std::to_string(member) +
                              "; they count from 0 to " +
                              std::to_string(static_cast<Eigen::Index>(reports_.size()) - 1));
  }

  Eigen::Index checked(const std::vector<State>& starts) const {
    const auto members = static_cast<Eigen::Index>(starts.size());
    if (members == 0) throw std::invalid_argument("Ensemble: no member; give one initial state at least");
    if (parameters_.cols() != members)
      throw std::invalid_argument("Ensemble: " + std::to_string(members) + " initial states and " +
                                  std::to_string(parameters_.cols()) +
                                  " columns of parameters; give one column a member");
    return members;
  }

  /// The parameters of the members from `first` on, a lane each; or of that one alone in all lanes.
  std::vector<Many> columns(Eigen::Index first, bool alone = false) const {
    std::vector<Many> packs(static_cast<std::size_t>(std::max<Eigen::Index>(parameters_.rows(), 1)),
                            Many(0.0));
    for (Eigen::Index i = 0; i < parameters_.rows(); ++i)
      for (Eigen::Index k = 0; k < width; ++k)
        packs[static_cast<std::size_t>(i)][static_cast<std::size_t>(k)] =
            parameters_(i, alone ? first : std::min(first + k, parameters_.cols() - 1));
    return packs;
  }

  template <class Observer>
  void run_pack(std::int64_t pack, const EnsembleOptions& options, const Observer& observe) {
    detail::PackRun run;
    const Eigen::Index first = pack * width;
    for (Eigen::Index k = 0; k < width; ++k) {
      run.member[lane(k)] = first + k;
      run.going[lane(k)] = first + k < size_;
    }
    PackPoint<Dof>& point = points_[static_cast<std::size_t>(pack)];
    const std::vector<Many> parameters = columns(first);
    Stepper stepper = first_.with(family_(parameters.data()));
    if (options.every > 0) run.tell(point, options, observe);
    run.advance(stepper, point, options, observe);
    // Some member's gradient throws: each goes on alone, in all lanes.
    if (run.gradient_threw)
      for (std::size_t k = 0; k < run.going.size(); ++k)
        if (run.going[k]) run_alone(k, point, run, options, observe);
    for (Eigen::Index k = 0; k < width && first + k < size_; ++k)
      reports_[static_cast<std::size_t>(first + k)] = run.report[lane(k)];
    if (run.observer_threw) std::rethrow_exception(run.observer_threw);
  }

  template <class Observer>
  void run_alone(std::size_t k, PackPoint<Dof>& point, detail::PackRun& run, const EnsembleOptions& options,
                 const Observer& observe) {
    detail::PackRun alone;
    alone.member[0] = run.member[k];
    alone.going[0] = true;
    alone.report[0] = run.report[k];
    alone.steps = run.steps;
    alone.observer_threw = run.observer_threw;
    PackPoint<Dof> copies = point.alone(k);
    const std::vector<Many> parameters = columns(run.member[k], true);
    Stepper stepper = first_.with(family_(parameters.data()));
    alone.advance(stepper, copies, options, observe);
    if (alone.gradient_threw) {
      alone.report[0].status = Status::gradient_threw;
      thrown_[static_cast<std::size_t>(run.member[k])] = message(alone.gradient_threw);
    }
    point.take(k, copies);
    run.report[k] = alone.report[0];
    run.observer_threw = alone.observer_threw;
  }

  static std::string message(const std::exception_ptr& thrown) {
    try {
      std::rethrow_exception(thrown);
    } catch (const std::exception& error) {
      return std::string("the gradient threw: ") + error.what();
    } catch (...) {
      return "the gradient threw something that is no std::exception";
    }
  }

  Family family_;
  Eigen::MatrixXd parameters_;
  Eigen::Index size_;
  Stepper first_;  ///< what the others are copies of, with Hamiltonians of their own
  std::vector<PackPoint<Dof>> points_;
  std::vector<IntegrationReport> reports_;
  std::vector<std::string> thrown_;  ///< by the gradients, in words
};

template <PackHamiltonian H>
Ensemble(H, const std::vector<PhasePoint<double, H::Dof>>&, Scheme<double>, SimplifiedNewton = {})
    -> Ensemble<detail::SameHamiltonian<H>>;

}  // namespace semiexplicit
