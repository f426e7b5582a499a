#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

#include <semiexplicit/checkpoint.hpp>

#include "ranks.hpp"

namespace examples {

using namespace semiexplicit;

/// Checkpoints of a run over ranks: every rank saves its block after the same steps, and keeps the last two
/// files. A run that was killed between the saves of two ranks goes on from the last step that all of them
/// have. (No rank saves again before all have finished the save before: they meet in every step between.)
template <class S, class... Observers>
class Generations {
 public:
  using State = typename S::State;

  /// `start` gives the initial state, by which checkpoints are known; every = 0: none are written.
  Generations(std::filesystem::path folder, std::int64_t every, std::string run, const Ranks& ranks,
              std::function<State()> start, S& stepper, const IntegrationOptions<double>& options,
              Observers&... observers)
      : folder_(std::move(folder)),
        every_(every),
        prefix_("rank" + std::to_string(ranks.rank()) + "of" + std::to_string(ranks.size()) + "-step"),
        ranks_(ranks),
        start_(std::move(start)),
        open_([this, label = std::move(run), options, &stepper, &observers...](std::int64_t step) -> Saved& {
          return current_.emplace(file(step), CheckpointOptions{.every = 1, .run = label}, stepper, options,
                                  observers...);
        }) {}

  /// Puts z, the stepper and the observers back to the last step that all ranks have saved, and gives the
  /// report up to there, an empty one where there is none. Removes no file: those that do not fit may be all
  /// that is left of another run. Throws as Checkpoints::resume(), and std::runtime_error where a rank has
  /// files of two steps, so that all ranks had one, and now some lack it.
  IntegrationReport resume(State& z) {
    if (every_ == 0) return {};
    DurableFile(file(0));  // where no file can be made that is said now
    std::set<std::int64_t> here = saved();
    std::int64_t step = most;
    for (;;) {
      const auto after = here.upper_bound(step);
      step = ranks_.least(after == here.begin() ? 0 : *std::prev(after));
      if (step == 0 || ranks_.least(here.count(step) > 0 ? 1 : 0) == 1) break;
      --step;
    }
    if (step == 0 && ranks_.least(here.size() > 1 ? 0 : 1) == 0)
      throw std::runtime_error("the checkpoints " + folder_.string() +
                               "/rank*: no step is there of all ranks, though all had saved one; bring the "
                               "missing files back, or remove the others to begin anew");
    if (step == 0 && ranks_.first()) mention_others();
    last_ = step;
    const auto kept = here.lower_bound(step);  // the save before that one goes with the next
    before_ = kept == here.begin() ? step : *std::prev(kept);
    left_ = std::move(here);
    left_.erase(step);
    left_.erase(before_);
    return step == 0 ? IntegrationReport{} : open_(step).resume(z);
  }

  void operator()(const double&, const State& z, const IntegrationReport& so_far) {
    if (every_ == 0 || so_far.steps == last_ || so_far.steps % every_ != 0) return;
    if (left_.erase(so_far.steps) > 0) remove(so_far.steps);
    Saved& checkpoint = open_(so_far.steps);
    State start = start_();
    checkpoint.resume(start);  // takes note of the initial state; throws where another run has saved by now
    checkpoint.save(z, so_far);
    if (before_ != last_) remove(before_);
    before_ = std::exchange(last_, so_far.steps);
  }

  /// Takes the files of this rank away: the run is done. Also those that are left of runs that were killed.
  void finish() {
    if (every_ == 0) return;
    current_.reset();
    for (const std::int64_t step : left_) remove(step);
    remove(before_);
    remove(last_);
  }

 private:
  using Saved = Checkpoints<S, Observers...>;
  static constexpr std::int64_t most = std::int64_t{1} << 62;
  static constexpr const char* suffix = ".checkpoint";

  std::filesystem::path file(std::int64_t step) const {
    return folder_ / (prefix_ + std::to_string(step) + suffix);
  }
  void remove(std::int64_t step) const {
    std::error_code ignored;  // an old file does no harm
    std::filesystem::remove(file(step), ignored);
  }
  /// The steps of this rank's files.
  std::set<std::int64_t> saved() const {
    std::set<std::int64_t> steps;
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with(prefix_) || !name.ends_with(suffix)) continue;
      const std::string digits =
          name.substr(prefix_.size(), name.size() - prefix_.size() - std::string(suffix).size());
      if (digits.empty() || digits.size() > 18 || digits.find_first_not_of("0123456789") != std::string::npos)
        continue;
      if (const std::int64_t step = std::stoll(digits); step > 0) steps.insert(step);
    }
    return steps;
  }

  /// A run that begins while checkpoints of other numbers of processes lie beside may be meant to go on.
  void mention_others() const {
    for (const auto& entry : std::filesystem::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (!name.starts_with("rank0of") || name.starts_with(prefix_) || !name.ends_with(suffix)) continue;
      std::cerr << "note: begins anew; " + entry.path().string() +
                       " is of a run with another number of processes: start as many to go on from there\n"
                << std::flush;
      return;
    }
  }

  std::filesystem::path folder_;
  std::int64_t every_, before_ = 0, last_ = 0;
  std::string prefix_;
  std::set<std::int64_t>
      left_;  ///< steps of other files, as those that the run which was killed had not saved on all ranks
  const Ranks& ranks_;
  std::function<State()> start_;
  std::optional<Saved> current_;  ///< locks its file
  std::function<Saved&(std::int64_t)> open_;
};

}  // namespace examples
