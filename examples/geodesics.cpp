// Geodesics of a metric that is given by its components alone: a section through the orbits about a black
// hole.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iostream>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/finished_blocks.hpp"
#include "common/method.hpp"
#include "common/output.hpp"
#include "common/run.hpp"
#include "geodesics/request.hpp"
#include "geodesics/section.hpp"

namespace {

using namespace examples;

std::string script(const std::filesystem::path& png, const std::filesystem::path& csv,
                   const std::string& title) {
  return gnuplot_prologue(png, 1100, 900) + "set title " + quoted(title + "; orange: chaotic") +
         " noenhanced\nset xlabel 'r/M'\nset ylabel 'p_r'\nset key off\nunset colorbox\n"
         "set offsets graph 0.02, graph 0.02, graph 0.02, graph 0.02\n"
         "set palette defined (0 '#0072B2', 1 '#009E73', 2 '#56B4E9', 3 '#666666')\n"
         "plot " +
         quoted(csv.string()) +
         " using ($4 > 0 ? $2 : NaN):3 skip 1 with points pointtype 7 pointsize 0.25 " +
         "linecolor rgb '#D55E00', " + quoted(csv.string()) +
         " using ($4 > 0 ? NaN : $2):3:1 skip 1 with points pointtype 7 pointsize 0.35 palette\n";
}

/// What --cost and --accuracy ask for, of the energy on one orbit of the section; true: there is nothing else
/// to do.
bool answer(Request& request, const RuntimeScene<double, 4>& scene, const State4& start) {
  const std::int64_t some = std::min<std::int64_t>(request.crossings, 20);
  const Orbit orbit = follow(scene, request.method, start, request.settings.dt, some, [](std::int64_t) {});
  if (orbit.ended)
    throw std::runtime_error(
        "the orbit in the middle, whose energy is judged, does not stay; take other parameters, or --dt");
  request.settings.time = orbit.time * static_cast<double>(request.crossings) / static_cast<double>(some);
  return request.cost.answer(scene, start, request.method, request.settings, "geodesics_cost",
                             "geodesics, " + request.metric);
}

/// All orbits. Those that are finished are kept where that is wanted, and not computed again.
std::vector<Orbit> section(const Request& request, const RuntimeScene<double, 4>& scene,
                           const std::function<State4(std::int64_t)>& start, const FinishedBlocks& finished) {
  const bool keeps = request.checkpoint.wanted();
  if (keeps) {
    Settings{.output = finished.folder()}.make_output_folder();
    if (finished.count() > 0)
      std::cout << "goes on from " << finished.folder().string() << ", orbit " << finished.count()
                << std::endl;
  }
  Progress progress(static_cast<double>(request.orbits * request.crossings), "passages");
  std::vector<Orbit> orbits;
  for (std::int64_t k = 0; k < request.orbits; ++k) {
    const auto numbers = keeps ? finished.load_if_sound(k) : std::nullopt;
    orbits.push_back(numbers ? Orbit::from(*numbers)
                             : follow(scene, request.method, start(k), request.settings.dt, request.crossings,
                                      [&](std::int64_t n) {
                                        progress(static_cast<double>(k * request.crossings + n), k);
                                      }));
    if (keeps && !numbers) finished.save(k, orbits.back().numbers());
  }
  return orbits;
}

template <class M>
int run(const M& metric, Request& request, const CLI::App& app, const std::string& title) {
  const Settings& settings = request.settings;
  const auto interval = allowed(metric, request.energy, request.l, 2.1, 200, 0.001);
  std::cout << formatted("bound in the equator from r = %.3f to %.3f\n", interval.first, interval.second);
  const RuntimeScene<double, 4> scene{geodesics::Geodesic<M>{metric}};
  const auto start = [&](std::int64_t k) {
    return start_of(metric, interval, k, request.orbits, request.energy, request.l);
  };
  const std::int64_t middle = request.orbits / 2;
  if (request.cost.wanted(app) && answer(request, scene, start(middle))) return 0;

  const FinishedBlocks finished(request.checkpoint.file, request.in_words());
  const std::vector<Orbit> orbits = section(request, scene, start, finished);
  settings.make_output_folder();
  const std::filesystem::path csv = settings.output / "geodesics.csv",
                              png = settings.output / "geodesics.png";
  CsvWriter writer(csv, {"orbit", "r", "p_r", "chaotic", "log10_gali2"});
  double worst = 0, number = 0;
  std::int64_t chaotic = 0, fallen = 0;
  for (const Orbit& orbit : orbits) {
    if (orbit.ended)
      ++fallen;
    else if (!(orbit.worst_energy <= worst))
      worst = orbit.worst_energy;
    if (orbit.chaotic()) ++chaotic;
    for (std::size_t i = 0; i < orbit.points.size(); i += 2)
      writer.row({number, orbit.points[i], orbit.points[i + 1], orbit.chaotic() ? 1.0 : 0.0,
                  orbit.log_alignment / std::log(10)});
    ++number;
  }
  writer.commit();
  std::cout << request.orbits << " orbits, " << chaotic << " of them chaotic (GALI_2 below 1e-8), " << fallen
            << " fell into the hole, left or failed\n"
            << formatted("error of g^{μν} p_μ p_ν, at worst: %.1e\n", worst);
  request.cost.compare_with_energy(orbits[static_cast<std::size_t>(middle)].worst_energy);
  std::cout << "data: " << csv.string() << '\n';
  if (request.checkpoint.wanted()) finished.remove();
  if (!settings.no_plot) draw(png, script(png, csv, title));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "Geodesics of a metric given by its components: a section (r, p_r) where bodies pass the equator. The "
      "metric is one effect: there is nothing to audit."};
  Request request;
  request.add_to(app);
  return run_program(app, argc, argv, [&] {
    request.refuse_idle(app);
    if (request.metric == "kerr")
      return run(geodesics::KerrMetric<double>{.mass = 1, .spin = request.spin}, request, app,
                 formatted("Kerr, a = %g, E = %g, L = %g", request.spin, request.energy, request.l));
    return run(geodesics::ErnstMetric<double>{.mass = 1, .field = request.field}, request, app,
               formatted("A black hole in a magnetic field, B = %g, E = %g, L = %g", request.field,
                         request.energy, request.l));
  });
}
