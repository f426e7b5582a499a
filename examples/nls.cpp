// The lattice of the nonlinear Schrödinger equation, by any method, or by four of them side by side (--compare).
#include <filesystem>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/error_panels.hpp"
#include "common/gnuplot.hpp"
#include "common/run.hpp"
#include "common/series_csv.hpp"
#include "common/table.hpp"

namespace {

using namespace examples;

/// Calls use(lattice, z0).
template <int N, class Use>
auto with_lattice_of(Eigen::Index sites, const Use& use) {
  const systems::NlsLattice<double, N> lattice(sites);
  PhasePoint<double, N> z(sites);
  z.q().setConstant(0.01);
  z.q()[0] = 3;
  z.p()[0] = 1;
  return use(lattice, z);
}

// The paper's size is worth a type of its own: it runs twice as fast.
template <class Use>
auto with_lattice(Eigen::Index sites, const Use& use) {
  return sites == 5 ? with_lattice_of<5>(sites, use) : with_lattice_of<Eigen::Dynamic>(sites, use);
}

Run run_sites(const Method& method, Eigen::Index sites, double dt, const Rows& rows, std::int64_t steps,
              const CheckpointRequest& checkpoint) {
  return with_lattice(sites, [&](const auto& lattice, const auto& z) {
    Invariants invariants(lattice);
    invariants.add("mass", lattice.mass);
    return run_method(method, lattice, z, invariants, dt, rows, steps, checkpoint);
  });
}

/// The four contestants. All take the same step, and the schemes are such that a step costs nearly the same, 21 to 27
/// gradient calls: the rivals have the published sixth-order one that serves them best at that price (Tao's map takes
/// compositions of Strang only).
std::vector<Method> contestants(const Method& semiexplicit) {
  return {{.name = "pihajoki", .scheme = "blanes_moan6"},
          {.name = "tao", .scheme = "kahan_li6", .omega = semiexplicit.omega},
          {.name = "midpoint", .scheme = "blanes_moan6"},
          semiexplicit};
}

std::string style(const std::string& method) {
  if (method == "pihajoki") return "linecolor rgb '#D55E00' linewidth 2";
  if (method == "tao") return "linecolor rgb '#CC79A7' linewidth 2";
  if (method == "midpoint") return "linecolor rgb '#009E73' linewidth 2";
  return "linecolor rgb '#0072B2' linewidth 3";
}

std::string title(const Run& run) {
  const Method& method = run.method;
  const std::string what = method.name == "pihajoki"   ? "Pihajoki"
                           : method.name == "tao"      ? "Tao, ω = " + formatted("%g", method.omega)
                           : method.name == "midpoint" ? "midpoint projection"
                           : method.name == "gauss"    ? "Gauss-Legendre"
                                                       : "semiexplicit";
  const std::string end = run.failure.empty() ? "" : ", fails at t = " + formatted("%.3g", run.report.t);
  return what + " (" + method.coefficients() + ")" + end;
}

/// Energy, mass and defect in three panels.
std::string script(const std::filesystem::path& png, const std::filesystem::path& csv,
                   const std::vector<Run>& runs, const std::string& headline, double time, double dt,
                   bool logarithmic_time) {
  const std::vector<std::string> labels{
      "relative energy error", "relative mass error",
      "distance of the copies\\n{/*0.8 (projected: before they are joined)}"};
  std::vector<std::vector<Curve>> panels(labels.size());
  std::size_t csv_column = 2;
  for (const Run& run : runs)
    for (std::size_t i = 0; i < run.series.columns.size(); ++i)
      panels[i].push_back({&run, i, csv_column++, title(run), style(run.method.name)});
  if (panels.back().empty()) panels.pop_back();

  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1400) << "set multiplot layout " << panels.size()
      << ",1 margins 0.13,0.97,0.065,0.885 spacing 0,0.03 title " << quoted(headline)
      << " noenhanced font ',20'\n"
      << "set key at screen 0.55,0.945 center top vertical maxrows 2 Left reverse samplen 3 width -6 "
         "noenhanced\n"
      << "set logscale y\nset format y '10^{%T}'\nset grid linetype 1 linewidth 0.5 linecolor rgb "
         "'#d8d8d8'\n";
  if (logarithmic_time)
    out << "set logscale x\nset xrange [" << dt << ':' << time << "]\n";
  else
    out << "set xrange [0:" << time << "]\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (i + 1 < panels.size())
      out << "set format x ''\n";
    else
      out << "set format x " << (logarithmic_time ? "'10^{%T}'" : "'%g'") << "\nset xlabel 'time'\n";
    out << panel(csv, labels[i], panels[i]) << "set key off\n";
  }
  out << "unset multiplot\n";
  return out.str();
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The lattice of the nonlinear Schrödinger equation, from q = (3, .01, ..., .01), p = (1, 0, ..., 0)."};
  Settings settings{.dt = 0.0125, .time = 1000};
  Method method;
  Eigen::Index sites = 5;
  bool compare = false;
  app.add_option("--sites", sites, "size of the lattice")
      ->check(whole_number(1, 100'000'000))
      ->type_name("N")
      ->capture_default_str();
  add_method(app, method);
  add_settings(app, settings);
  auto* const comparison = app.add_flag(
      "--compare", compare,
      "run pihajoki, tao, midpoint and semiexplicit side by side (the schemes of the first three are set)");
  app.get_option("--method")->excludes(comparison);
  CostRequest request;
  add_cost(app, request);
  CheckpointRequest checkpoint;
  add_checkpoint(app, checkpoint);
  comparison->excludes("--cost")->excludes("--accuracy")->excludes("--checkpoint");
  app.footer(
      app.get_footer() +
      "\n\n--compare gives every method the same dt, and schemes with which a step costs nearly the same.");

  return run_program(app, argc, argv, [&] {
    if (request.wanted(app)) {
      settings.make_output_folder();
      const CostOfAccuracy cost = with_lattice(sites, [&](const auto& lattice, const auto& z) {
        return cost_of_accuracy(lattice, z, settings.time, request.options());
      });
      if (request.curve) {
        show_cost(cost, settings, "nls_cost", "NLS lattice, N = " + std::to_string(sites));
        return 0;
      }
      request.choose(cost, method, settings);
    }
    const std::vector<Method> methods = compare ? contestants(method) : std::vector<Method>{method};
    std::vector<std::string> listening;
    for (const Method& m : methods) listening.push_back(m.name);
    if (!request.chosen) refuse_idle_options(app, listening);
    const std::int64_t steps = settings.fit_steps();
    settings.make_output_folder();

    const Rows rows =
        compare ? geometrically_spaced(steps, settings.samples) : evenly_spaced(steps, settings.samples);
    checkpoint.run << "nls, " << sites << " sites, " << steps << " steps, samples " << settings.samples;
    std::vector<Run> runs;
    for (const Method& m : methods) runs.push_back(run_sites(m, sites, settings.dt, rows, steps, checkpoint));

    print_table(std::cout, runs, settings.dt);
    request.compare_with(runs.back());
    const std::string name = compare ? "nls_comparison" : "nls";
    const std::filesystem::path csv = settings.output / (name + ".csv"),
                                png = settings.output / (name + ".png");
    write_series(csv, runs);
    checkpoint.finish();
    std::cout << "data: " << csv.string() << '\n';
    const std::string headline = "NLS lattice, N = " + std::to_string(sites) +
                                 (compare ? ", the same step for all: dt = " : ", dt = ") +
                                 formatted("%g", settings.dt);
    if (!settings.no_plot) draw(png, script(png, csv, runs, headline, settings.time, settings.dt, compare));

    // A rival that fails is a result; the method that was asked for must not.
    bool failed = false;
    for (const Run& run : runs) failed = tell_failure(run);
    return failed ? 1 : 0;
  });
}
