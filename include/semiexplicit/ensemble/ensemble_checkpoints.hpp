#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint/checkpoints.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/ensemble/ensemble.hpp>

namespace semiexplicit {

/// An observer of the whole that saves the run of an ensemble, as Checkpoints does that of one state: the run
/// that goes on from the file is the same bit for bit, whatever the number of threads. It saves all members
/// with their reports, and the memory of the observers that are named, lists of one for each member (see
/// each()), which have to be Checkpointable.
///
///     EnsembleOptions options{.dt = 0.05, .steps = 1'000'000};
///     EnsembleCheckpoints checkpoints("map.checkpoint", {.seconds = 60}, ensemble, options, exponents);
///     options.done = checkpoints.resume();  // changes nothing where there is no such file
///     ensemble.run(options, each(exponents), checkpoints);
///     checkpoints.remove();
///
/// It saves where all members are together (EnsembleOptions::together) and so many steps or seconds have
/// passed since the last time. A file of a run with other options, Hamiltonians, parameters, initial states
/// or observers, of any member, is refused; functions of (q, p) are told from others by their values where
/// the members were saved. The ensemble and the lists must outlive it. The file, its lock and what it holds
/// for are as with Checkpoints.
template <class Family, class Solver, class... Observers>
class EnsembleCheckpoints {
 public:
  static_assert((detail::is_checkpointable<Observers>() && ...));
  using Members = Ensemble<Family, Solver>;

  /// Throws std::invalid_argument where every is negative, seconds are not positive, or a list has not one
  /// observer a member, and std::logic_error, as resume() and save() do, where the ensemble was moved from.
  EnsembleCheckpoints(const std::filesystem::path& path, CheckpointOptions options, Members& ensemble,
                      const EnsembleOptions& run, std::vector<Observers>&... observers)
      : file_(path),
        options_(std::move(options)),
        ensemble_(ensemble),
        observers_(observers...),
        settings_(settings_of(run)) {
    options_.check("EnsembleCheckpoints");
  }

  /// Puts the ensemble, which comes as the run began, and the observers back to where the file has them, and
  /// gives the steps done up to there, for EnsembleOptions::done. Where there is no such file it changes
  /// nothing and gives 0. Throws as Checkpoints::resume() does; ensemble and observers are then untouched.
  std::int64_t resume() {
    require_members();
    start_.set(checksum_of_states());
    last_time_ = Clock::now();
    std::int64_t done = 0;
    file_.read([&](const std::string& contents) {
      using Read = CheckpointMemory::Read;
      CheckpointMemory restore(contents, Read::restore), check(contents, Read::check);
      std::int64_t saved = 0, unused = 0;
      visit_head(restore, saved);
      visit_head(check, unused);
      visit_all(check);
      if (!check.at_end()) throw std::invalid_argument("it holds more numbers than are asked for");
      detail::restore_all_or_nothing(
          restore, [this](CheckpointMemory& memory) { visit_all(memory); },
          [this] { require_same_functions(); });
      done = saved;
    });
    if (done > 0) start_.put_back(done, checksum_of_states());
    return last_ = done;
  }

  void operator()(double, const EnsembleReport& so_far) {
    start_.follow(
        so_far.done, [this] { return checksum_of_states(); }, "EnsembleOptions::done");
    if (so_far.done == 0 || so_far.done < last_) last_ = 0;
    if (so_far.done == last_) return;
    if (options_.every > 0
            ? so_far.done - last_ >= options_.every
            : std::chrono::duration<double>(Clock::now() - last_time_).count() >= options_.seconds)
      save(so_far.done);
  }

  /// Whether this is the ensemble that it saves.
  template <class Other>
  bool saves(const Other& ensemble) const {
    return detail::is_same_object(ensemble_, ensemble);
  }
  /// Throws std::logic_error where a run is to go on after so many steps from other states than resume() put
  /// back, and where no file can be made, as Checkpoints::require_start().
  void require_start(std::int64_t done) const {
    file_.require_place();
    start_.require_put_back(
        done, [this] { return checksum_of_states(); },
        "leave the members where it has put them, without set_state()");
  }

  /// Writes a checkpoint now, after so many steps of each member. Throws std::invalid_argument where the
  /// members have taken another number.
  void save(std::int64_t done) {
    require_members();
    ensemble_.require_done(done);
    start_.require(done, [this] { return checksum_of_states(); });
    CheckpointMemory memory;
    values_.clear();
    for (Eigen::Index i = 0; i < ensemble_.size(); ++i)
      with_functions(i, [&](const auto& functions) {
        values_.insert(values_.end(), functions.values().begin(), functions.values().end());
      });
    visit_head(memory, done);
    visit_all(memory);
    file_.write(memory.bytes());
    last_ = done;
    last_time_ = Clock::now();
  }

  /// Lines "what: value" of all that the run was made with, by which its checkpoints are known.
  const std::string& settings() const { return settings_; }

  /// Takes the file away: the run is done. Does nothing where there is none. Throws std::runtime_error where
  /// another run has it open.
  void remove() { file_.remove(); }

 private:
  using Clock = std::chrono::steady_clock;

  void visit_head(CheckpointMemory& memory, std::int64_t& done) {
    detail::visit_settings(memory, settings_);
    start_.visit(memory, "other initial states; give it the same ones");
    memory(done);
    if (done < 0) throw std::invalid_argument("its counts cannot be; start anew without it");
  }
  void visit_all(CheckpointMemory& memory) {
    std::apply([&](auto&... lists) { (visit_list(memory, lists), ...); }, observers_);
    ensemble_.visit_memory(memory);
    memory(values_);
  }

  template <class Observer>
  static void visit_list(CheckpointMemory& memory, std::vector<Observer>& observers) {
    for (Observer& one : observers) one.visit_memory(memory);
  }

  void require_members() const {
    if (ensemble_.size() == 0)
      throw std::logic_error(
          "EnsembleCheckpoints: the ensemble was moved from; use the one that it was moved to, or make a new "
          "one");
  }

  /// Calls use() with the values of a member's functions where it is: the size of its gradient, by which its
  /// Hamiltonian is known, and those of its observers. NaN where one throws.
  template <class Use>
  void with_functions(Eigen::Index member, const Use& use) const {
    using Values = detail::FunctionValues<typename Members::State>;
    const auto state = ensemble_.state(member);
    Values functions(state, Values::Throwing::nan);
    functions.function("Hamiltonian",
                       [&](const auto&, const auto&) { return ensemble_.gradient_size(member); });
    std::apply([&](const auto&... lists) { (functions("", lists[static_cast<std::size_t>(member)]), ...); },
               observers_);
    use(functions);
  }
  void require_same_functions() const {
    const auto require = [](bool fits) {
      if (!fits)
        throw std::invalid_argument(
            "it holds the values of other functions; give the observers of the run "
            "that wrote it, or another file");
    };
    std::size_t next = 0;
    for (Eigen::Index i = 0; i < ensemble_.size(); ++i)
      with_functions(i, [&](const auto& functions) {
        const std::size_t count = functions.values().size();
        require(count <= values_.size() - next);
        for (std::size_t k = 0; k < count; ++k)
          detail::require_same(functions, k, values_[next + k], "member " + std::to_string(i));
        next += count;
      });
    require(next == values_.size());
  }

  std::string settings_of(const EnsembleOptions& run) const {
    require_members();
    detail::OptionText list;
    list("run", options_.run);
    list("dt", run.dt);
    list("t0", run.t0);
    list("every", run.every);
    list("subdivide", run.subdivide);
    list("ensemble", ensemble_);
    each_list([&](const std::string& what, const auto& observers) {
      if (static_cast<Eigen::Index>(observers.size()) != ensemble_.size())
        throw std::invalid_argument("EnsembleCheckpoints: a list has " + std::to_string(observers.size()) +
                                    " observers and the ensemble " + std::to_string(ensemble_.size()) +
                                    " members; give one a member");
      list(what, observers.front());
    });
    each_list([&](const std::string& what, const auto& observers) { add_others(list, what, observers); });
    return list.text();
  }

  /// A line for each member whose observer has other options than the first one's: the first that differs,
  /// not all of a long one, and the checksum of all.
  template <class Observer>
  static void add_others(detail::OptionText& list, const std::string& what,
                         const std::vector<Observer>& observers) {
    const auto options_of = [&](const Observer& one) {
      detail::OptionText options;
      options(what, one);
      return options.text();
    };
    constexpr std::size_t longest = 100;
    const std::string first = options_of(observers.front());
    for (std::size_t i = 1; i < observers.size(); ++i) {
      const std::string own = options_of(observers[i]);
      if (own == first) continue;
      std::string line = detail::first_other_lines(first, own).second;
      if (line.size() > longest) line = line.substr(0, longest) + "...";
      list("member " + std::to_string(i), line + " (checksum " + std::to_string(checksum(own)) + ")");
    }
  }

  template <class Use>
  void each_list(const Use& use) const {
    int count = 0;
    std::apply([&](const auto&... lists) { (use("observer " + std::to_string(++count), lists), ...); },
               observers_);
  }

  std::uint64_t checksum_of_states() const {
    std::uint64_t sum = checksum("");
    for (Eigen::Index i = 0; i < ensemble_.size(); ++i) {
      const auto state = ensemble_.state(i);
      sum = checksum({reinterpret_cast<const char*>(state.vector().data()),
                      static_cast<std::size_t>(state.vector().size()) * sizeof(double)},
                     sum);
    }
    return sum;
  }

  detail::CheckpointFile file_;
  CheckpointOptions options_;
  Members& ensemble_;
  std::tuple<std::vector<Observers>&...> observers_;
  std::string settings_;
  std::vector<double> values_;  ///< of the functions of all members where they were saved
  detail::StartOfRun start_;
  std::int64_t last_ = 0;
  Clock::time_point last_time_ = Clock::now();
};

}  // namespace semiexplicit
