#include "experiment.hpp"

#include <algorithm>
#include <fstream>
#include <map>
#include <optional>
#include <sstream>
#include <stdexcept>

#include "common/output.hpp"
#include "methods.hpp"
#include "problems.hpp"

namespace paper {

namespace {

/// Relative errors over time in some hundred rows, dense enough for a linear and for a logarithmic axis. A
/// row holds the largest values since the row before it.
struct Series {
  std::vector<double> t;
  std::vector<std::vector<double>> rows;
};

constexpr std::int64_t series_rows = 500;

void keep_larger(double& largest, double value) {
  if (!(value <= largest) && !std::isnan(largest)) largest = value;  // a NaN is the worst, and stays
}

/// An observer: invariants and, of methods with two copies, the defect.
template <int Dof>
class Watch {
 public:
  Watch(const std::vector<Invariant<Dof>>& invariants, const Experiment& experiment, Result& result,
        Series& series)
      : invariants_(invariants),
        experiment_(experiment),
        result_(result),
        series_(series),
        stride_(std::max<std::int64_t>(experiment.steps() / series_rows, 1)) {
    if (experiment.series) result.worst.assign(invariants.size(), 0);
    largest_.assign(invariants.size() + 1, 0);
  }

  template <class State>
  void operator()(double t, const State& state, const StepReport& report) {
    if (step_ > 0 && report.correction >= experiment_.epsilon) ++result_.unconverged;
    if constexpr (requires { state.defect(); }) {
      const double defect = state.defect();
      keep_larger(result_.max_defect, defect);
      keep_larger(largest_.back(), defect);
    }
    if (experiment_.series) follow(t, state);
    ++step_;
  }

 private:
  template <class State>
  void follow(double t, const State& state) {
    for (std::size_t i = 0; i < invariants_.size(); ++i) {
      const double now = invariants_[i].value(state.q(), state.p());
      if (step_ == 0) initial_.push_back(now);
      const double error = std::abs(now - initial_[i]) / std::abs(initial_[i]);
      keep_larger(result_.worst[i], error);
      keep_larger(largest_[i], error);
    }
    if (step_ == 0 || (step_ % stride_ != 0 && step_ < next_geometric_ && step_ != experiment_.steps()))
      return;
    next_geometric_ = std::max(next_geometric_, step_ + 1 + step_ / 40);
    series_.t.push_back(t);
    series_.rows.push_back(largest_);
    std::fill(largest_.begin(), largest_.end(), 0.0);
  }

  const std::vector<Invariant<Dof>>& invariants_;
  const Experiment& experiment_;
  Result& result_;
  Series& series_;
  std::int64_t stride_, step_ = 0, next_geometric_ = 0;
  std::vector<double> initial_, largest_;
};

void run(const Experiment& experiment, const std::string& label, Result& result, Series& series) {
  with_problem(experiment.problem, experiment.as_published, [&](const auto& problem) {
    const Method& chosen = method(experiment.method);
    with_stepper(chosen, problem.hamiltonian, problem.omega, experiment.solver, experiment.epsilon,
                 experiment.as_published, [&](auto& stepper) {
                   auto start = problem.start;
                   for (int i = 0; i < experiment.rounding; ++i)
                     start.q()[0] = std::nextafter(start.q()[0], std::numeric_limits<double>::infinity());
                   typename std::decay_t<decltype(stepper)>::State state(start);
                   Watch watch(problem.invariants, experiment, result, series);
                   Progress progress(experiment.time, label);
                   const auto report = integrate(
                       stepper, state,
                       {.dt = experiment.dt, .steps = experiment.steps(), .on_failure = OnFailure::stop},
                       watch, progress);
                   const double attempted = static_cast<double>(report.steps) + (report.ok() ? 0 : 1);
                   result.status = report.ok() ? "success" : describe(report.status);
                   result.t = report.t;
                   result.steps = static_cast<double>(report.steps);
                   result.evaluations = static_cast<double>(report.evaluations) / attempted;
                   result.gradients = static_cast<double>(report.gradients) / attempted;
                   result.seconds = report.seconds;
                   result.max_error = report.max_correction;
                   if (!chosen.doubled()) result.max_defect = std::numeric_limits<double>::quiet_NaN();
                 });
  });
}

struct Field {
  const char* name;
  double Result::*value;
};

const std::vector<Field>& fields() {
  static const std::vector<Field> list{
      {"t", &Result::t},
      {"steps", &Result::steps},
      {"evaluations", &Result::evaluations},
      {"gradients", &Result::gradients},
      {"seconds", &Result::seconds},
      {"max_error", &Result::max_error},
      {"max_defect", &Result::max_defect},
      {"unconverged", &Result::unconverged},
  };
  return list;
}

}  // namespace

std::string Experiment::key() const {
  const Method& chosen = paper::method(method);
  std::ostringstream out;
  out << problem << " dt " << dt << " T " << time << ' ' << method;
  if (chosen.solves()) out << ' ' << solver;
  if (chosen.solves() || chosen.family == Family::gauss || chosen.family == Family::gauss_newton)
    out << ' ' << epsilon;
  if (!as_published) out << " library";
  if (series) out << " series";
  if (rounding > 0) out << " plus " << rounding << " ulp";
  std::string text = out.str();
  text.erase(std::remove(text.begin(), text.end(), ','), text.end());
  std::replace(text.begin(), text.end(), ' ', '_');
  return text;
}

void Results::make(const Experiment& experiment, const std::string& label) const {
  Result result;
  Series series;
  run(experiment, label, result, series);

  std::filesystem::create_directories(folder_);
  examples::write_whole(file(experiment), [&](std::ostream& out) {
    out.precision(17);
    out << "# status," << result.status << '\n';
    for (const Field& field : fields()) out << "# " << field.name << ',' << result.*field.value << '\n';
    const auto names = invariant_names(experiment.problem);
    for (std::size_t i = 0; i < result.worst.size(); ++i)
      out << "# worst " << names[i] << ',' << result.worst[i] << '\n';
    if (experiment.series) {
      out.precision(6);
      out << "# series: t";
      for (const std::string& name : names) out << ',' << name;
      out << ",defect\n";
      for (std::size_t n = 0; n < series.t.size(); ++n) {
        out << series.t[n];
        for (const double value : series.rows[n]) out << ',' << value;
        out << '\n';
      }
    }
  });
}

Result Results::get(const Experiment& experiment) const {
  std::ifstream in(file(experiment));
  Result result;
  std::string line;
  while (std::getline(in, line) && line.rfind("# ", 0) == 0) {
    const auto comma = line.find(',');
    const std::string name = line.substr(2, comma - 2), value = line.substr(comma + 1);
    if (name == "status") result.status = value;
    for (const Field& field : fields())
      if (name == field.name) result.*field.value = std::strtod(value.c_str(), nullptr);
    if (name.rfind("worst ", 0) == 0) result.worst.push_back(std::strtod(value.c_str(), nullptr));
  }
  if (!in.eof() && !in) throw std::runtime_error(file(experiment).string() + ": cannot be read");
  return result;
}

}  // namespace paper
