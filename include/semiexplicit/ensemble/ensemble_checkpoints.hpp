#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
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
/// or observers is refused. The ensemble and the lists must outlive it. The file, its lock and what it holds
/// for are as with Checkpoints.
template <class Family, class Solver, class... Observers>
class EnsembleCheckpoints {
 public:
  static_assert((detail::is_checkpointable<Observers>() && ...));
  using Members = Ensemble<Family, Solver>;

  /// Throws std::invalid_argument where every is negative, seconds are not positive, or a list has not one
  /// observer a member.
  EnsembleCheckpoints(std::filesystem::path path, CheckpointOptions options, Members& ensemble,
                      const EnsembleOptions& run, std::vector<Observers>&... observers)
      : file_(std::move(path)),
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
    starts_ = checksum_of_states();
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
          [this] { require_same_gradients(); });
      done = saved;
    });
    return last_ = done;
  }

  void operator()(double, const EnsembleReport& so_far) {
    if (so_far.done == 0) starts_ = checksum_of_states();
    if (so_far.done == 0 || so_far.done < last_) last_ = 0;
    if (so_far.done == last_) return;
    if (options_.every > 0
            ? so_far.done - last_ >= options_.every
            : std::chrono::duration<double>(Clock::now() - last_time_).count() >= options_.seconds)
      save(so_far.done);
  }

  /// Writes a checkpoint now, after so many steps of each member.
  void save(std::int64_t done) {
    CheckpointMemory memory;
    gradients_ = gradient_sizes();
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
    std::uint64_t starts = starts_;
    memory(starts);
    if (starts != starts_)
      throw std::invalid_argument(
          "it belongs to a run from other initial states; give it the same ones, or another file");
    memory(done);
    if (done < 0) throw std::invalid_argument("its counts cannot be; start anew without it");
  }
  void visit_all(CheckpointMemory& memory) {
    std::apply([&](auto&... lists) { (visit_list(memory, lists), ...); }, observers_);
    ensemble_.visit_memory(memory);
    memory(gradients_);
  }

  template <class Observer>
  static void visit_list(CheckpointMemory& memory, std::vector<Observer>& observers) {
    for (Observer& one : observers) one.visit_memory(memory);
  }

  /// Of every member where it is, by which its Hamiltonian is known; NaN where the gradient throws.
  std::vector<double> gradient_sizes() const {
    std::vector<double> sizes;
    if constexpr (detail::MakesPlain<Family>)
      for (Eigen::Index i = 0; i < ensemble_.size(); ++i) {
        const auto hamiltonian = ensemble_.hamiltonian(i);
        const auto state = ensemble_.state(i);
        double size = std::numeric_limits<double>::quiet_NaN();
        try {
          size = detail::GradientSize(hamiltonian)(state.q(), state.p());
        } catch (...) {
        }
        sizes.push_back(size);
      }
    return sizes;
  }
  void require_same_gradients() const {
    const std::vector<double> here = gradient_sizes();
    if (here.size() != gradients_.size())
      throw std::invalid_argument("it belongs to an ensemble of other members; give it another file");
    for (std::size_t i = 0; i < here.size(); ++i)
      if (here[i] == here[i] && !detail::same_but_for_rounding(gradients_[i], here[i]))
        throw std::invalid_argument("it belongs to another Hamiltonian: where member " + std::to_string(i) +
                                    " was saved its size is " + detail::in_words(gradients_[i], 9) +
                                    " there, " + detail::in_words(here[i], 9) +
                                    " here; give it the same parameters, or the run another file");
  }

  std::string settings_of(const EnsembleOptions& run) {
    detail::OptionText list;
    list("run", options_.run);
    list("dt", run.dt);
    list("t0", run.t0);
    list("every", run.every);
    list("subdivide", run.subdivide);
    list("ensemble", ensemble_);
    int count = 0;
    const auto add = [&](const auto& observers) {
      if (static_cast<Eigen::Index>(observers.size()) != ensemble_.size())
        throw std::invalid_argument("EnsembleCheckpoints: a list has " + std::to_string(observers.size()) +
                                    " observers and the ensemble " + std::to_string(ensemble_.size()) +
                                    " members; give one a member");
      list("observer " + std::to_string(++count), observers.front());
    };
    std::apply([&](const auto&... lists) { (add(lists), ...); }, observers_);
    return list.text();
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
  std::vector<double> gradients_;
  std::uint64_t starts_ = 0;
  std::int64_t last_ = 0;
  Clock::time_point last_time_ = Clock::now();
};

}  // namespace semiexplicit
