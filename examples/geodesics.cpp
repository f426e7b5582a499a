// Geodesics of a metric that is given by its components alone: a section through the orbits about a black hole.
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/output.hpp"
#include "geodesics/section.hpp"

namespace {

using namespace examples;

struct Request {
  std::string metric = "ernst";
  double field = 0.1, spin = 0.9, energy = 1.36, l = 6, dt = 2;
  std::int64_t orbits = 20, crossings = 500;
};

std::string script(const std::filesystem::path& png, const std::filesystem::path& csv,
                   const std::string& title) {
  return gnuplot_prologue(png, 1100, 900) + "set title " + quoted(title) +
         " noenhanced\nset xlabel 'r/M'\nset ylabel 'p_r'\nset key off\nunset colorbox\n"
         "set palette defined (0 '#0072B2', 1 '#009E73', 2 '#E69F00', 3 '#56B4E9', 4 '#CC79A7')\n"
         "plot " +
         quoted(csv.string()) +
         " using ($4 > 0 ? $2 : NaN):3 skip 1 with points pointtype 7 pointsize 0.25 " +
         "linecolor rgb '#D55E00', " + quoted(csv.string()) +
         " using ($4 > 0 ? NaN : $2):3:1 skip 1 with points pointtype 7 pointsize 0.35 palette\n";
}

template <class M>
int run(const M& metric, const Request& request, const Settings& settings, const std::string& title) {
  const auto [inner, outer] = allowed(metric, request.energy, request.l, 2.1, 200, 0.001);
  std::cout << formatted("bound in the equator from r = %.3f to %.3f\n", inner, outer);
  struct Row {
    double r, p_r;
  };
  std::vector<std::vector<Row>> orbits(static_cast<std::size_t>(request.orbits));
  std::vector<OrbitSeen> seen;
  double worst = 0;
  std::int64_t chaotic = 0, fallen = 0;
  for (std::int64_t k = 0; k < request.orbits; ++k) {
    const double r =
        inner + (outer - inner) * (static_cast<double>(k) + 0.5) / static_cast<double>(request.orbits);
    const auto start = equatorial(metric, r, request.energy, request.l);
    if (!start)
      throw std::runtime_error("no orbit starts in the middle of the allowed region; take other parameters");
    auto& rows = orbits[static_cast<std::size_t>(k)];
    seen.push_back(follow(metric, *start, request.dt, request.crossings, [&](double at, double p_r) {
      rows.push_back({at, p_r});
    }));
    if (seen.back().ended)
      ++fallen;
    else if (!(seen.back().worst_energy <= worst))
      worst = seen.back().worst_energy;
    if (seen.back().log_alignment < std::log(1e-8)) ++chaotic;
  }
  settings.make_output_folder();
  const std::filesystem::path csv = settings.output / "geodesics.csv",
                              png = settings.output / "geodesics.png";
  CsvWriter writer(csv, {"orbit", "r", "p_r", "chaotic", "log10_gali2"});
  for (std::size_t k = 0; k < orbits.size(); ++k)
    for (const Row& row : orbits[k])
      writer.row({static_cast<double>(k), row.r, row.p_r, seen[k].log_alignment < std::log(1e-8) ? 1.0 : 0.0,
                  seen[k].log_alignment / std::log(10)});
  writer.commit();
  std::cout << request.orbits << " orbits, " << chaotic << " of them chaotic (GALI_2 below 1e-8), " << fallen
            << " fell into the hole, left or failed\n"
            << formatted("error of g^{μν} p_μ p_ν, at worst: %.1e\n", worst) << "section: " << csv.string()
            << '\n';
  if (!settings.no_plot) draw(png, script(png, csv, title));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Geodesics of a metric given by its components: a section (r, p_r) where bodies pass the equator."};
  Request request;
  Settings settings;
  add_value(app, "--metric", request.metric,
            "ernst (a black hole in a magnetic field) or kerr; units G = c = M = 1",
            one_of({"ernst", "kerr"}), "NAME");
  auto* const field =
      add_value(app, "--field", request.field, "magnetic field B of ernst, 1/M; 0: Schwarzschild",
                number<double>("a number from 0 on", [](double x) { return x >= 0; }));
  auto* const spin =
      add_value(app, "--spin", request.spin, "spin a/M of kerr",
                number<double>("a number from -1 to 1", [](double x) { return std::abs(x) < 1; }));
  add_value(app, "--energy", request.energy, "E per rest mass", positive());
  add_value(app, "--angular-momentum", request.l, "L per rest mass and M",
            number<double>("a number", [](double x) { return std::isfinite(x); }));
  add_value(app, "--orbits", request.orbits, "which start at rest in r, from within outwards",
            whole_number(1, 10'000), "N");
  add_value(app, "--crossings", request.crossings, "of the equator, for each of them",
            whole_number(1, 1'000'000), "N");
  add_value(app, "--dt", request.dt, "step of proper time, in M", positive());
  add_output(app, settings, false);
  return run_program(app, argc, argv, [&] {
    if (request.metric == "kerr") {
      if (field->count() > 0) throw std::invalid_argument("--field means nothing to kerr; leave it out");
      return run(geodesics::KerrMetric<double>{.mass = 1, .spin = request.spin}, request, settings,
                 formatted("Kerr, a = %g, E = %g, L = %g", request.spin, request.energy, request.l));
    }
    if (spin->count() > 0) throw std::invalid_argument("--spin means nothing to ernst; leave it out");
    return run(geodesics::ErnstMetric<double>{.mass = 1, .field = request.field}, request, settings,
               formatted("A black hole in a magnetic field, B = %g, E = %g, L = %g; orange: chaotic",
                         request.field, request.energy, request.l));
  });
}
