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
#include "common/prepare_outputs.hpp"
#include "common/run.hpp"
#include "geodesics/picture.hpp"
#include "geodesics/request.hpp"
#include "geodesics/section.hpp"
#include "geodesics/summary.hpp"

namespace {

using namespace examples;

/// What --cost and --accuracy ask for, of the energy on one orbit of the section; true: there is nothing else
/// to do.
bool answer(Request& request, const RuntimeScene<double, 4>& scene, const State4& start,
            const Region& region) {
  const std::int64_t some = std::min<std::int64_t>(request.crossings, 20);
  const Orbit orbit =
      follow(scene, request.method, start, region, request.settings.dt, some, [](std::int64_t) {});
  if (orbit.end != Orbit::End::all_passages)
    throw std::runtime_error(std::string("the orbit in the middle, whose energy is judged, ") +
                             describe(orbit.end) + "; give other parameters, or a --dt instead of " +
                             (request.cost.curve ? "--cost" : "--accuracy"));
  request.settings.time = orbit.time * static_cast<double>(request.crossings) / static_cast<double>(some);
  return request.cost.answer(scene, start, request.method, request.settings, "geodesics_cost",
                             "geodesics, " + request.metric);
}

/// All orbits. Those that are finished are kept where that is wanted, and not computed again.
std::vector<Orbit> section(const Request& request, const RuntimeScene<double, 4>& scene,
                           const std::function<State4(std::int64_t)>& start, const Region& region,
                           const FinishedBlocks& finished) {
  const bool keeps = request.checkpoint.wanted();
  if (keeps) {
    make_folder(finished.folder(), "--checkpoint");
    if (finished.count() > 0)
      std::cout << "goes on from " << finished.folder().string() << ", orbit " << finished.count()
                << std::endl;
  }
  Progress progress(static_cast<double>(request.orbits * request.crossings), "passages");
  std::vector<Orbit> orbits;
  for (std::int64_t k = 0; k < request.orbits; ++k) {
    const auto numbers = keeps ? finished.load_if_sound(k) : std::nullopt;
    orbits.push_back(numbers ? Orbit::from(*numbers)
                             : follow(scene, request.method, start(k), region, request.settings.dt,
                                      request.crossings, [&](std::int64_t n) {
                                        progress(static_cast<double>(k * request.crossings + n), k);
                                      }));
    if (keeps && !numbers) finished.save(k, orbits.back().numbers());
  }
  return orbits;
}

template <class M>
int run(const M& metric, Request& request, const CLI::App& app, const std::string& title) {
  const Settings& settings = request.settings;
  const Region region = allowed(metric, request.energy, request.l);
  std::cout << formatted("bound in the equator from r = %.3f to %.3f\n", region.inner, region.outer);
  const RuntimeScene<double, 4> scene{geodesics::Geodesic<M>{metric}};
  const auto start = [&](std::int64_t k) {
    return start_of(metric, region, k, request.orbits, request.energy, request.l);
  };
  const std::int64_t middle = request.orbits / 2;
  if (request.cost.wanted(app) && answer(request, scene, start(middle), region)) return 0;

  if (!(region.most_time() * static_cast<double>(request.crossings) / settings.dt <= 1e15))
    throw std::invalid_argument("--dt: an orbit may take more such steps than anybody can wait for");
  const std::filesystem::path csv = settings.output / "geodesics.csv",
                              png = settings.output / "geodesics.png";
  prepare_outputs(settings, {csv, png}, request.checkpoint.file);
  const FinishedBlocks finished(request.checkpoint.file, request.in_words());
  const auto lock = request.checkpoint.wanted() ? finished.lock() : nullptr;
  const std::vector<Orbit> orbits = section(request, scene, start, region, finished);
  CsvWriter writer(csv, {"orbit", "r", "p_r", "chaotic", "log10_gali2"});
  double number = 0;
  for (const Orbit& orbit : orbits) {
    for (std::size_t i = 0; i < orbit.points.size(); i += 2)
      writer.row({number, orbit.points[i], orbit.points[i + 1], orbit.chaotic() ? 1.0 : 0.0,
                  orbit.log_alignment / std::log(10)});
    ++number;
  }
  writer.commit();
  const Summary summary(orbits);
  summary.print(std::cout, region);
  const Orbit& judged = orbits[static_cast<std::size_t>(middle)];
  if (judged.end == Orbit::End::all_passages)
    request.cost.compare_with_energy(judged.worst_energy);
  else if (request.cost.chosen)
    std::cout << "energy error: not measured, the orbit in the middle " << describe(judged.end) << '\n';
  if (request.cost.chosen && summary.worst_energy &&
      (summary.failed > 0 || *summary.worst_energy > request.cost.accuracy))
    std::cout << "the step was chosen on the orbit in the middle: "
              << (summary.failed > 0 ? counted(summary.failed, "orbit") + " failed, and " : "")
              << "the worst of all is off by " << formatted("%.1e", *summary.worst_energy)
              << "; give a smaller --accuracy where that is too much\n";
  std::cout << "data: " << csv.string() << '\n';
  if (request.checkpoint.wanted()) finished.remove();
  if (summary.failed == request.orbits) {
    std::cerr << "geodesics: every orbit failed; give a smaller --dt\n";
    if (!settings.no_plot) tell_of_earlier_picture(png);
    return 1;
  }
  if (settings.no_plot) return 0;
  if (summary.points > 0)
    draw(png, section_picture(png, csv, title), {csv});
  else
    tell_no_picture(png, "no orbit passed the equator");
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
