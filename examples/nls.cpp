// The lattice of the nonlinear Schrödinger equation, by any method, or by four of them side by side
// (--compare).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/prepare_outputs.hpp"
#include "common/results.hpp"
#include "common/run.hpp"
#include "nls/picture.hpp"

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
    return run_method(method, lattice, z, invariants, dt, rows, steps, checkpoint, NoCompanion());
  });
}

/// The four contestants. All take the same step, and the schemes are such that a step costs nearly the same,
/// 21 to 27 gradient calls: the rivals have the published sixth-order one that serves them best at that price
/// (Tao's map takes compositions of Strang only).
std::vector<Method> contestants(const Method& semiexplicit) {
  return {{.name = "pihajoki", .scheme = "blanes_moan6"},
          {.name = "tao", .scheme = "kahan_li6", .omega = semiexplicit.omega},
          {.name = "midpoint", .scheme = "blanes_moan6"},
          semiexplicit};
}

/// For a logarithmic time axis.
Rows geometrically_spaced(std::int64_t steps, std::int64_t samples) {
  Rows rows{0};
  for (std::int64_t k = 0; k < samples - 1 && rows.back() < steps; ++k) {
    const double exponent = static_cast<double>(k + 1) / static_cast<double>(samples - 1);
    const auto n = static_cast<std::int64_t>(std::round(std::pow(static_cast<double>(steps), exponent)));
    if (n > rows.back()) rows.push_back(std::min(n, steps));
  }
  return rows;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "The lattice of the nonlinear Schrödinger equation, from q = (3, .01, ..., .01), p = (1, 0, ..., 0)."};
  Settings settings{.dt = 0.0125, .time = 1000};
  Method method;
  Eigen::Index sites = 5;
  bool compare = false;
  add_value(app, "--sites", sites, "size of the lattice", whole_number(1, 100'000'000), "N");
  add_method(app, method);
  add_value(app, "--dt", settings.dt, "step size; made a little smaller where the time is no multiple",
            positive());
  add_value(app, "--time", settings.time, "time to integrate to", positive());
  add_output(app, settings);
  auto* const comparison = app.add_flag(
      "--compare", compare,
      "run pihajoki, tao, midpoint and semiexplicit side by side (the schemes of the first three are set)");
  app.get_option("--method")->excludes(comparison);
  CostRequest request;
  request.add_to(app);
  CheckpointRequest checkpoint;
  checkpoint.add_to(app);
  comparison->excludes("--cost")->excludes("--accuracy")->excludes("--checkpoint");
  app.footer(
      app.get_footer() +
      "\n\n--compare gives every method the same dt, and schemes with which a step costs nearly the same.");

  return run_program(app, argc, argv, [&] {
    if (request.wanted(app) && with_lattice(sites, [&](const auto& lattice, const auto& z) {
          return request.answer(lattice, z, method, settings, "nls_cost",
                                "NLS lattice, N = " + std::to_string(sites));
        }))
      return 0;
    const std::vector<Method> methods = compare ? contestants(method) : std::vector<Method>{method};
    std::vector<std::string> listening;
    for (const Method& m : methods) listening.push_back(m.name);
    if (!request.chosen) refuse_idle_options(app, listening);
    const std::int64_t steps = settings.fit_steps();
    const std::string name = compare ? "nls_comparison" : "nls";
    const std::filesystem::path csv = settings.output / (name + ".csv"),
                                png = settings.output / (name + ".png");
    prepare_outputs(settings, {csv, png}, checkpoint.file);

    const Rows rows =
        compare ? geometrically_spaced(steps, settings.samples) : evenly_spaced(steps, settings.samples);
    checkpoint.run << "nls, " << sites << " sites, " << steps << " steps, samples " << settings.samples;
    std::vector<Run> runs;
    for (const Method& m : methods) runs.push_back(run_sites(m, sites, settings.dt, rows, steps, checkpoint));

    print_table(std::cout, runs, settings.dt);
    request.compare_with(runs.back());
    write_series(csv, runs);
    std::cout << "data: " << csv.string() << '\n';
    const std::string headline = "NLS lattice, N = " + std::to_string(sites) +
                                 (compare ? ", the same step for all: dt = " : ", dt = ") +
                                 formatted("%g", settings.dt);
    if (!settings.no_plot)
      draw(png, script(png, csv, runs, headline, settings.time, settings.dt, compare), {csv});
    checkpoint.finish();

    // A rival that fails is a result; the method that was asked for must not.
    bool failed = false;
    for (const Run& run : runs) failed = run.tell_failure();
    return failed ? 1 : 0;
  });
}
