#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <string>
#include <vector>

#include <semiexplicit/checkpoint.hpp>

#include "checkpoint_request.hpp"
#include "method.hpp"

namespace examples {

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

/// For a logarithmic time axis.
inline Rows geometrically_spaced(std::int64_t steps, std::int64_t samples) {
  Rows rows{0};
  for (std::int64_t k = 0; k < samples - 1 && rows.back() < steps; ++k) {
    const double exponent = static_cast<double>(k + 1) / static_cast<double>(samples - 1);
    const auto n = static_cast<std::int64_t>(std::round(std::pow(static_cast<double>(steps), exponent)));
    if (n > rows.back()) rows.push_back(std::min(n, steps));
  }
  return rows;
}

/// Errors over time, a column each. A row holds the largest values since the row before it, so that no peak falls
/// between two rows.
struct Series {
  std::vector<std::string> names;
  std::vector<double> t;
  std::vector<std::vector<double>> columns;
};

/// What came of one method.
struct Run {
  struct Quantity {
    std::string name;
    double worst, final;
  };

  Method method{};
  std::vector<Quantity> quantities{};  ///< relative errors of the invariants, then the defect
  Series series{};
  IntegrationReport report{};
  std::string failure{};  ///< empty if the run came to its end
  std::string doubt{};    ///< not empty if the result means nothing although it did

  bool is_result() const { return failure.empty() && doubt.empty(); }
};

/// An observer that fills a Run's series, and follows the defect of methods that work with copies. Comes after the
/// invariants that it reads.
template <class Watched>
class Watch {
 public:
  static constexpr const char* name = "Watch";

  Watch(const Watched& invariants, const Rows& rows, Run& run)
      : invariants_(invariants), rows_(rows), run_(run) {
    for (const auto& row : invariants.rows()) run.quantities.push_back({row.name, 0, 0});
    if (run.method.doubles()) run.quantities.push_back({"defect", 0, 0});
    for (const auto& quantity : run.quantities)
      run.series.names.push_back(quantity.name == "defect" ? "defect" : quantity.name + "_error");
    run.series.columns.resize(run.quantities.size());
    largest_.assign(run.quantities.size(), 0.0);
  }

  template <class State>
  void operator()(double t, const State& state, const StepReport& report) {
    for (std::size_t i = 0; i < run_.quantities.size(); ++i) {
      auto& [quantity, worst, final] = run_.quantities[i];
      final = i < invariants_.rows().size() ? invariants_.rows()[i].final : defect(state, report);
      keep_larger(worst, final);
      keep_larger(largest_[i], final);
    }
    t_ = t;
    pending_ = true;
    if (next_ < rows_.size() && step_ == rows_[next_]) {
      ++next_;
      write_row();
    }
    ++step_;
  }

  template <class List>
  void describe(List& list) const {
    list("rows", rows_.size());
    list("quantities", run_.quantities.size());
  }
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    for (auto& quantity : run_.quantities) {
      visit(quantity.worst);
      visit(quantity.final);
    }
    visit(run_.series.t);
    for (auto& column : run_.series.columns) visit(column);
    visit(largest_);
    visit(t_);
    visit(pending_);
    visit(next_);
    visit(step_);
  }

  /// A run that fails ends between two rows: keeps what was seen since the last one.
  void finish() {
    if (pending_ && next_ < rows_.size()) write_row();
  }

 private:
  static void keep_larger(double& largest, double value) {
    if (!(value <= largest)) largest = value;  // a NaN is the worst
  }

  /// How far the copies are apart at the end of a step; where they are then joined, just before that.
  template <class State>
  static double defect(const State& state, const StepReport& report) {
    if constexpr (requires { state.defect(); })
      return state.defect();
    else
      return 4 * report.correction;
  }

  void write_row() {
    run_.series.t.push_back(t_);
    for (std::size_t i = 0; i < largest_.size(); ++i) run_.series.columns[i].push_back(largest_[i]);
    largest_.assign(largest_.size(), 0.0);
    pending_ = false;
  }

  const Watched& invariants_;
  const Rows& rows_;
  Run& run_;
  std::vector<double> largest_;
  double t_ = 0;
  bool pending_ = false;
  std::size_t next_ = 0;
  std::int64_t step_ = 0;
};

/// Integrates from z0 and watches the invariants; a failed step ends up in the Run, with all that came before it.
template <class H, class Watched, class... Observers>
Run run_method(const Method& method, const H& hamiltonian, const PhasePoint<double, H::Dof>& z0,
               Watched invariants, double dt, const Rows& rows, std::int64_t steps,
               const CheckpointRequest& request, Observers&... observers) {
  Run run{.method = method};
  with_stepper(method, hamiltonian, [&](auto& stepper) {
    typename std::decay_t<decltype(stepper)>::State state(z0);
    Watch watch(invariants, rows, run);
    IntegrationOptions<double> options{.dt = dt, .steps = steps};
    Checkpoints checkpoints(request.file, request.options(), stepper, options, invariants, watch,
                            observers...);
    if (request.wanted()) options.done = checkpoints.resume(state);
    if (options.done.steps > 0)
      std::cout << "goes on from " << request.file.string() << ", step " << options.done.steps
                << std::endl;  // also if it is killed
    const auto save = [&](double t, const auto& z, const IntegrationReport& so_far) {
      if (request.wanted()) checkpoints(t, z, so_far);
    };
    Progress progress(static_cast<double>(steps) * dt, method.name);
    try {
      run.report = integrate(stepper, state, options, invariants, watch, observers..., progress, save);
    } catch (const IntegrationError& error) {
      run.report = error.report();
      run.failure = error.what();
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
