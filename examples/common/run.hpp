#pragma once

#include <cstdint>
#include <filesystem>
#include <iostream>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/checkpoint.hpp>

#include "arguments.hpp"
#include "method.hpp"

namespace examples {

/// The options --checkpoint, save the run there and go on from there, and --checkpoint-every.
struct CheckpointRequest {
  std::filesystem::path file{};
  std::int64_t every = 0;
  std::ostringstream run{};  ///< what makes this run this run; whoever starts it writes it here

  void add_to(CLI::App& app) {
    auto* const option = add_file(app,
                                  "file to save the run in from time to time; where it is there and "
                                  "fits, the run goes on from it");
    app.add_option("--checkpoint-every", every, "steps from one to the next; without it, a minute")
        ->check(whole_number(1, 1'000'000'000'000'000))
        ->type_name("N")
        ->needs(option);
  }

  /// --checkpoint alone, for what is saved piece by piece.
  CLI::Option* add_file(CLI::App& app, const std::string& about) {
    const auto in_a_folder = [](const std::string& text) -> std::string {
      const std::filesystem::path path(text), folder = path.parent_path();
      for (const auto& name : {path, folder})
        if (const std::string complaint = complaint_of_link(name); !complaint.empty()) return complaint;
      std::error_code failure;  // of which the file tells
      if (std::filesystem::is_directory(path, failure) || !path.has_filename())
        return "'" + text + "' is a folder; give the name of a file in it";
      if (!folder.empty() && !std::filesystem::is_directory(folder, failure))
        return "the folder " + folder.string() + " is not there; make it first";
      return "";
    };
    return app.add_option("--checkpoint", file, about)
        ->type_name("FILE")
        ->check(CLI::Validator(in_a_folder, "", "file"))
        ->excludes("--cost")
        ->excludes("--accuracy");
  }

  bool wanted() const { return !file.empty(); }
  /// The run is done, its files are there and its figures are told; else the checkpoint stays.
  void finish() const {
    if (wanted() && std::cout.flush()) remove_checkpoint(file);
  }
};

/// The numbers of the steps after which a row is kept: the start, the end, and `samples` in all at most.
using Rows = std::vector<std::int64_t>;

/// Distance of the kept rows where they are evenly spaced.
inline std::int64_t stride(std::int64_t steps, std::int64_t samples) {
  return samples < 2 ? steps + 1 : (steps + samples - 2) / (samples - 1);
}

inline Rows evenly_spaced(std::int64_t steps, std::int64_t samples) {
  Rows rows;
  for (std::int64_t n = 0; n < steps; n += stride(steps, samples)) rows.push_back(n);
  if (samples > 1) rows.push_back(steps);
  return rows;
}

/// Counts the steps of a run: which of them have a row.
class RowClock {
 public:
  explicit RowClock(const Rows& rows) : rows_(rows) {}

  /// Whether the next step has one.
  bool due() {
    if (done() || step_++ != rows_[next_]) return false;
    ++next_;
    return true;
  }
  bool done() const { return next_ == rows_.size(); }
  /// How far the row of the step after the next is from the one before it; 0 where there is none.
  std::int64_t steps_to_row_behind() const {
    return next_ > 0 && !done() && step_ + 1 == rows_[next_] ? rows_[next_] - rows_[next_ - 1] : 0;
  }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(next_);
    visit(step_);
  }

 private:
  const Rows& rows_;
  std::size_t next_ = 0;
  std::int64_t step_ = 0;
};

/// What is uncertain of a figure: by the trajectory, as a companion run tells, and by how it is measured.
struct FigureError {
  double by_trajectory = 0, by_measuring = 0;
  double all() const { return by_trajectory + by_measuring; }
};

/// What came of one method.
struct Run {
  /// The relative error of an invariant, or the defect, as it grows. A row holds the largest value since the
  /// row before it, so that no peak falls between two rows.
  struct Quantity {
    std::string name;
    double worst = 0, final = 0, peak = 0;  ///< of the run, at its end, since the last row
    std::vector<double> rows{};

    std::string column() const { return name == "defect" ? name : name + "_error"; }
    void see(double value) {
      final = value;
      for (double* largest : {&worst, &peak})
        if (!(value <= *largest)) *largest = value;  // a NaN is the worst
    }
  };

  Method method{};
  std::vector<Quantity> quantities{};  ///< the invariants, then the defect
  std::vector<double> t{};             ///< of the rows
  IntegrationReport report{};
  std::string failure{};  ///< empty if the run came to its end
  std::string doubt{};    ///< not empty if the result means nothing although it did
  std::map<std::string, FigureError> figure_errors{};  ///< where a companion run tells one
  bool companion = false;                              ///< whether one went along
  std::optional<double> companion_parted{};            ///< when it parted from the run

  /// Of the figure of that name; nothing where no companion told.
  std::optional<FigureError> figure_error(const std::string& figure) const {
    const auto found = figure_errors.find(figure);
    return found == figure_errors.end() ? std::nullopt : std::optional(found->second);
  }
  bool is_result() const { return failure.empty() && doubt.empty(); }
  /// Says on stderr why this is no result; false: it is one.
  bool tell_failure() const {
    if (!is_result()) std::cerr << method.name << ": " << (failure.empty() ? doubt : failure) << '\n';
    return !is_result();
  }
};

/// An observer that fills a Run's quantities, the defect for methods that work with copies. Comes after the
/// invariants that it reads.
template <class Watched>
class Watch {
 public:
  static constexpr const char* name = "Watch";

  Watch(const Watched& invariants, const Rows& rows, Run& run)
      : invariants_(invariants), rows_(rows), clock_(rows), run_(run) {
    for (const auto& row : invariants.rows()) run.quantities.push_back({.name = row.name});
    if (run.method.doubles()) run.quantities.push_back({.name = "defect"});
  }

  template <class State>
  void operator()(double t, const State& state, const StepReport& report) {
    const auto& rows = invariants_.rows();
    for (std::size_t i = 0; i < run_.quantities.size(); ++i)
      run_.quantities[i].see(i < rows.size() ? rows[i].final : defect(state, report));
    t_ = t;
    pending_ = true;
    if (clock_.due()) write_row();
  }

  template <class List>
  void describe(List& list) const {
    list("rows", rows_.size());
    list("quantities", run_.quantities.size());
  }
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (auto& quantity : run_.quantities) {
      for (double* number : {&quantity.worst, &quantity.final, &quantity.peak}) visit(*number);
      visit(quantity.rows);
    }
    visit(run_.t);
    visit(t_);
    visit(pending_);
    clock_.visit_memory(visit);
  }

  /// A run that fails ends between two rows: keeps what was seen since the last one.
  void finish() {
    if (pending_ && !clock_.done()) write_row();
  }

 private:
  /// How far the copies are apart at the end of a step; where they are then joined, just before that.
  template <class State>
  static double defect(const State& state, const StepReport& report) {
    if constexpr (requires { state.defect(); })
      return state.defect();
    else
      return 4 * report.correction;
  }

  void write_row() {
    run_.t.push_back(t_);
    for (auto& quantity : run_.quantities) quantity.rows.push_back(std::exchange(quantity.peak, 0));
    pending_ = false;
  }

  const Watched& invariants_;
  const Rows& rows_;
  RowClock clock_;
  Run& run_;
  double t_ = 0;
  bool pending_ = false;
};

/// Integrates with a progress bar on a terminal. Where that is wanted it saves stepper, state and observers,
/// and goes on from what was saved; the observers have to be Checkpointable.
template <class S, class State, class... Observers>
IntegrationReport integrate_saved(const CheckpointRequest& request, const std::string& label, S& stepper,
                                  State& state, IntegrationOptions<double> options, Observers&... observers) {
  Checkpoints checkpoints(request.file, {.every = request.every, .run = request.run.str()}, stepper, options,
                          observers...);
  if (request.wanted()) options.done = checkpoints.resume(state);
  if (options.done.steps > 0)
    std::cout << "goes on from " << request.file.string() << ", step " << options.done.steps
              << std::endl;  // also if it is killed
  const auto save = [&](double t, const auto& z, const IntegrationReport& so_far) {
    if (request.wanted()) checkpoints(t, z, so_far);
  };
  Progress progress(options.t_end.value_or(static_cast<double>(options.steps) * options.dt), label);
  return integrate(stepper, state, options, observers..., progress, save);
}

/// No companion runs beside a run.
struct NoCompanion {
  bool wanted() const { return false; }
  void conclude(const auto&, Run&) const {}
};

/// Integrates from z0 and watches the invariants; a failed step ends up in the Run, with all that came before
/// it. A companion that is wanted goes along, with half the step, and says in the end what it has seen
/// (FigureErrors).
template <class H, class Watched, class Companion, class... Observers>
Run run_method(const Method& method, const H& hamiltonian, const PhasePoint<double, H::Dof>& z0,
               Watched invariants, double dt, const Rows& rows, std::int64_t steps,
               const CheckpointRequest& request, Companion companion, Observers&... observers) {
  Run run{.method = method};
  with_stepper(method, hamiltonian, [&](auto& stepper) {
    using State = typename std::decay_t<decltype(stepper)>::State;
    State state(z0);
    Watch watch(invariants, rows, run);
    const IntegrationOptions<double> options{.dt = dt, .steps = steps};
    const auto go = [&](auto&... estimate) {
      try {
        run.report = integrate_saved(request, method.name, stepper, state, options, invariants, watch,
                                     observers..., estimate...);
        if constexpr (sizeof...(estimate) > 0) companion.conclude(estimate..., run);
      } catch (const IntegrationError& error) {
        run.report = error.report();
        run.failure = error.what();
      }
    };
    if constexpr (std::is_same_v<State, PhasePoint<double, H::Dof>> &&
                  !std::is_same_v<Companion, NoCompanion>) {
      auto estimate = with_error_estimate(stepper, {}, companion);
      if (companion.wanted())
        go(estimate);
      else
        go();
    } else {
      go();
    }
    watch.finish();
    for (const auto& row : invariants.rows())
      if (row.name == "energy" && row.relative && !(row.worst <= 0.5))
        run.doubt =
            "the energy is off by more than half of itself, the result means nothing; give a smaller "
            "--dt, or another method";
  });
  return run;
}

}  // namespace examples
