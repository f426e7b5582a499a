// Point vortices in the plane, from a preset or a CSV file, by any method.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/error_panels.hpp"
#include "common/gnuplot.hpp"
#include "common/run.hpp"
#include "common/series_csv.hpp"
#include "common/table.hpp"
#include "common/vortex_file.hpp"

namespace {

using namespace examples;
using System = systems::PointVortices<>;
using Column = System::Column;

Column column(std::initializer_list<double> values) {
  return Eigen::Map<const Column>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

struct Preset {
  std::string name;
  Vortices vortices;
  double dt, time;
};

/// "paper" is the set of Jayawardana and Ohsawa; in "disparate" circulations and distances differ much more.
std::vector<Preset> presets() {
  return {{.name = "paper",
           .vortices = {.x = column({3, -10, 6, 9, 0, 7, -8, 5, 9, 7}),
                        .y = column({-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
                        .circulation = column({-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6})},
           .dt = 0.1,
           .time = 1000},
          {.name = "disparate",
           .vortices = {.x = column({.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4}),
                        .y = column({5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4}),
                        .circulation = column({-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8})},
           .dt = 0.01,
           .time = 100}};
}

/// What the flow keeps. An impulse that cancels but for rounding counts as zero, so that its error is absolute.
Invariants<double, Eigen::Dynamic> invariants_of(const System& system, const Vortices& v) {
  Invariants invariants(system);
  const auto z = system.phase_point(v.x, v.y);
  const auto add = [&](const char* name, auto impulse, double size) {
    const double initial = (system.*impulse)(z.q(), z.p());
    const double offset = std::abs(initial) <= 1e-14 * size ? initial : 0;
    invariants.add(name, [=](const auto& q, const auto& p) { return (system.*impulse)(q, p) - offset; });
  };
  const Column weight = v.circulation.cwiseAbs();
  add("impulse_x", &System::linear_impulse_x, weight.dot(v.x.cwiseAbs()));
  add("impulse_y", &System::linear_impulse_y, weight.dot(v.y.cwiseAbs()));
  add("angular_impulse", &System::angular_impulse, weight.dot(v.x.cwiseAbs2() + v.y.cwiseAbs2()));
  return invariants;
}

/// An observer that writes the places: t, x0, y0, x1, y1, ..., and knows the square around them.
class PlacesCsv {
 public:
  struct Square {
    double x, y, half_width;
  };

  PlacesCsv(const std::filesystem::path& path, const System& system)
      : system_(system), writer_(path, names(system.dof())) {}

  template <class State>
  void operator()(double t, const State& state) {
    const Column x = system_.x(state.q()), y = system_.y(state.p());
    row_.assign(1, t);
    for (Eigen::Index i = 0; i < x.size(); ++i) row_.insert(row_.end(), {x[i], y[i]});
    writer_.row(row_);
    left_ = std::min(left_, x.minCoeff());
    right_ = std::max(right_, x.maxCoeff());
    low_ = std::min(low_, y.minCoeff());
    high_ = std::max(high_, y.maxCoeff());
  }
  void commit() { writer_.commit(); }

  Square square() const {
    const double width = std::max(right_ - left_, high_ - low_);
    return {(left_ + right_) / 2, (low_ + high_) / 2, width > 0 ? width / 2 : 1};
  }

 private:
  static std::vector<std::string> names(Eigen::Index count) {
    std::vector<std::string> list{"t"};
    for (Eigen::Index i = 0; i < count; ++i)
      list.insert(list.end(), {"x" + std::to_string(i), "y" + std::to_string(i)});
    return list;
  }

  System system_;
  CsvWriter writer_;
  std::vector<double> row_;
  double left_ = std::numeric_limits<double>::infinity(), right_ = -left_, low_ = left_, high_ = -left_;
};

/// The plane above, the errors below.
std::string script(const std::filesystem::path& png, const std::filesystem::path& places,
                   const std::filesystem::path& csv, const Vortices& v, const Run& run,
                   const std::string& headline, double time, const PlacesCsv::Square& square) {
  // gnuplot reads the file anew for every path.
  const Eigen::Index drawn = std::min<Eigen::Index>(v.x.size(), 100);
  const double strongest = v.circulation.cwiseAbs().maxCoeff();
  const auto range = [&](double middle) {
    const double reach = 1.04 * square.half_width;
    return "[" + formatted("%.9g", middle - reach) + ":" + formatted("%.9g", middle + reach) + "]";
  };
  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1600) << "$start << END\n";
  for (Eigen::Index i = 0; i < drawn; ++i) out << v.x[i] << ',' << v.y[i] << ',' << v.circulation[i] << '\n';
  out << "END\nset multiplot title " << quoted(headline) << " noenhanced font ',20'\n"
      << "set lmargin at screen 0.11\nset rmargin at screen 0.86\nset bmargin at screen 0.36\nset tmargin at "
         "screen 0.945\n"
      << "set size ratio -1\nset key off\nset grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\nset "
         "xlabel 'x'\nset ylabel 'y'\n"
      << "set xrange " << range(square.x) << "\nset yrange " << range(square.y) << '\n'
      << "set palette defined (-1 '#08519c', -0.1 '#6baed6', 0 '#999999', 0.1 '#fc9272', 1 '#a50f15')\n"
      << "set cbrange [" << -strongest << ':' << strongest << "]\nset cblabel 'circulation Γ'\nplot ";
  for (Eigen::Index i = 0; i < drawn; ++i)
    out << quoted(places.string()) << " skip 1 using " << 2 + 2 * i << ':' << 3 + 2 * i
        << " with lines linewidth 0.9 linecolor palette cb " << v.circulation[i] << ", \\\n  ";
  out << "$start using 1:2 with points pointtype 7 pointsize 1.8 linecolor rgb 'black', \\\n"
      << "  $start using 1:2:3 with points pointtype 7 pointsize 1.2 linecolor palette\n"
      << "set bmargin at screen 0.055\nset tmargin at screen 0.27\nset rmargin at screen 0.96\nset size "
         "noratio\n"
      << "set key at screen 0.535,0.295 center center horizontal maxrows 1 samplen 3 width -2\n"
      << "set autoscale y\nset logscale y\nset format y '10^{%T}'\nset xlabel 'time'\nset xrange [0:" << time
      << "]\n";
  const std::vector<std::pair<std::string, std::string>> curves{{"energy", "#0072B2"},
                                                                {"linear impulse, x", "#009E73"},
                                                                {"linear impulse, y", "#E69F00"},
                                                                {"angular impulse", "#D55E00"}};
  std::vector<Curve> all;
  for (std::size_t i = 0; i < curves.size(); ++i)
    all.push_back(
        {&run, i, i + 2, curves[i].first, "linewidth 1.5 linecolor rgb " + quoted(curves[i].second)});
  out << panel(csv, "relative error", all) << "unset multiplot\n";
  return out.str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Point vortices in the plane, from a preset or a file."};
  std::vector<std::string> preset_names;
  for (const Preset& preset : presets()) preset_names.push_back(preset.name);
  std::string preset_name = preset_names.front(), input;
  Settings settings;
  Method method;
  auto* const preset_option =
      app.add_option("--preset", preset_name, "ten vortices ready made: " + joined(preset_names))
          ->check(one_of(preset_names))
          ->type_name("NAME")
          ->capture_default_str();
  app.add_option("--input", input, "CSV file with the columns x,y,gamma: a line a vortex, # begins a comment")
      ->type_name("FILE")
      ->excludes(preset_option);
  add_method(app, method);
  add_settings(app, settings);
  app.get_option("--dt")->default_str("paper: 0.1, others: 0.01");
  app.get_option("--time")->default_str("paper: 1000, others: 100");
  CostRequest request;
  add_cost(app, request);

  return run_program(app, argc, argv, [&] {
    if (!request.wanted(app)) refuse_idle_options(app, {method.name});
    Preset chosen{.name = input, .vortices = {}, .dt = settings.dt, .time = settings.time};
    if (!input.empty()) chosen.vortices = read_vortices(input);
    for (const Preset& preset : presets())
      if (input.empty() && preset.name == preset_name) chosen = preset;
    if (app.count("--dt") == 0) settings.dt = chosen.dt;
    if (app.count("--time") == 0) settings.time = chosen.time;
    const Vortices& vortices = chosen.vortices;
    const System system(vortices.circulation);
    if (request.wanted(app)) {
      settings.make_output_folder();
      const CostOfAccuracy cost = cost_of_accuracy(system, system.phase_point(vortices.x, vortices.y),
                                                   settings.time, request.options());
      if (request.curve) {
        show_cost(cost, settings, "vortices_cost", std::to_string(vortices.x.size()) + " vortices");
        return 0;
      }
      request.choose(cost, method, settings);
    }
    const std::int64_t steps = settings.steps();
    settings.make_output_folder();

    const std::filesystem::path csv = settings.output / "vortices.csv",
                                places_csv = settings.output / "vortices_trajectory.csv",
                                png = settings.output / "vortices.png";
    PlacesCsv places(places_csv, system);
    auto some_places = every(stride(steps, settings.samples), places);
    const Run run = run_method(method, system, system.phase_point(vortices.x, vortices.y),
                               invariants_of(system, vortices), settings.dt,
                               evenly_spaced(steps, settings.samples), steps, some_places);

    print_table(std::cout, {run}, settings.dt);
    request.compare_with(run);
    places.commit();
    write_series(csv, {run});
    std::cout << "data: " << csv.string() << ", " << places_csv.string() << '\n';
    const std::string headline = std::to_string(vortices.x.size()) + " vortices (" +
                                 std::filesystem::path(chosen.name).filename().string() + "), " +
                                 method.name + ", dt = " + formatted("%g", settings.dt);
    if (!settings.no_plot)
      draw(png, script(png, places_csv, csv, vortices, run, headline, settings.time, places.square()));

    if (!run.failure.empty()) std::cerr << method.name << ": " << run.failure << '\n';
    return run.failure.empty() ? 0 : 1;
  });
}
