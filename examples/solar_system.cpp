// The Sun and its planets: Kepler's motion exact, their attraction kicked, only relativity doubled. --audit:
// Clemence's table.
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/output.hpp"
#include "common/prepare_outputs.hpp"
#include "common/run.hpp"
#include "solar_system/clemence.hpp"
#include "solar_system/cost.hpp"
#include "solar_system/measurements.hpp"
#include "solar_system/motion.hpp"
#include "solar_system/picture.hpp"
#include "solar_system/planets.hpp"
#include "solar_system/request.hpp"

namespace {

using namespace examples;

int audit(const Request& request) {
  const double dt = request.settings.dt, time = request.settings.time;
  prepare_outputs(request.settings, {request.file(".csv"), request.file(".png")}, request.checkpoint.file);
  const auto& list = list_called(request.list);
  const std::vector<PerihelionCurve> all =
      clemence(request.effects, list, dt, time, request.settings.samples);
  std::string complaint;
  if (request.cost.chosen) complaint = request.cost.compare_with_figure(FigureError{all.back().by_steps});
  write_perihelion(request.file(".csv"), all);
  std::cout << "data: " << request.file(".csv").string() << '\n';
  if (!request.settings.no_plot)
    draw(request.file(".png"),
         curves(request.file(".png"), request.file(".csv"),
                "By what each effect turns the perihelion of Mercury", "arcseconds", all.size(), 1),
         {request.file(".csv")});
  if (!complaint.empty()) throw std::runtime_error(complaint);
  return 0;
}

/// Why a run ended, and what its user may do.
std::string why(Status status) {
  if (status != Status::close_encounter) return describe(status);
  return "two bodies come so close that their attraction is not small beside that of the Sun: in truth, "
         "which these lists do not resolve, or as the step is too long; give a shorter --dt";
}

int run(Request& request, const System& system) {
  Settings& settings = request.settings;
  const std::int64_t steps = settings.fit_steps();
  prepare_outputs(settings, {request.file(".csv"), request.file(".png")}, request.checkpoint.file);
  std::vector<std::string> columns{"t"};
  for (const std::string& name : system.names) columns.insert(columns.end(), {"e_" + name, "i_" + name});
  columns.emplace_back("energy_error");
  CsvWriter writer(request.file(".csv"), columns);
  Kept kept = kept_of(system);
  const Rows rows = evenly_spaced(steps, settings.samples);
  RowClock clock(rows);
  Run::Quantity energy{.name = "energy"};
  const auto row = [&](double t, const auto& q, const auto& p) {
    energy.see(kept["energy"].final);
    if (!clock.due()) return;
    std::vector<double> values{t};
    for (const double value : shapes(system, q, p)) values.push_back(value);
    values.push_back(std::exchange(energy.peak, 0));
    writer.row(values);
  };
  const auto memory = [&](CheckpointMemory& visit) {
    writer.visit_memory(visit);
    clock.visit_memory(visit);
    visit(energy.peak);
  };
  request.checkpoint.run << "solar_system: " << joined(request.effects) << "; " << steps << " steps, samples "
                         << settings.samples;
  with_splitting(system, list_called(request.list),
                 [](const auto& stepper) { std::cout << explain(stepper) << '\n'; });
  State z = system.start;
  const IntegrationReport report =
      integrate_system(system, list_called(request.list), z,
                       {.dt = settings.dt, .steps = steps, .on_failure = OnFailure::stop}, kept,
                       {.observe = row, .memory = memory}, "solar_system", request.checkpoint);
  std::cout << formatted("%g years, %.0f steps of %.6g days: ", report.t, double(report.steps),
                         settings.dt * days_a_year);
  if (report.ok())
    std::cout << formatted("energy error %.1e (at the end %.1e), ", kept["energy"].worst,
                           kept["energy"].final)
              << formatted("angular momentum about %s %.1e\n", system.oblate ? "the Sun's axis" : "z",
                           kept["angular_momentum"].worst)
              << formatted("seconds: %.2f, %.3g years a second\n", report.seconds, report.t / report.seconds);
  else
    std::cout << "FAILED, errors mean nothing\n";
  if (report.ok()) request.cost.compare_with_energy(kept["energy"].worst);
  writer.commit();
  std::cout << "data: " << request.file(".csv").string() << '\n';
  if (!settings.no_plot)
    draw(request.file(".png"),
         curves(
             request.file(".png"), request.file(".csv"),
             "Eccentricities about the Sun: " + joined(request.effects) + (report.ok() ? "" : "; NO RESULT"),
             "eccentricity", system.names.size(), 2),
         {request.file(".csv")});
  request.checkpoint.finish();
  if (!report.ok())
    std::cerr << formatted("solar_system: at t = %g: ", report.t) << why(report.status) << '\n';
  return report.ok() ? 0 : 1;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The Sun and its planets, from their elements of J2000; the Earth with the Moon."};
  Request request;
  request.add_to(app);
  return run_program(app, argc, argv, [&] {
    request.read();
    const System system(request.effects);
    request.refuse_wrong_audit(system);
    if (!request.cost.wanted(app))
      request.settings.fit_steps();
    else if (answer(request.cost, system, request.audit ? Judge::perihelion : Judge::energy, request.list,
                    request.settings))
      return 0;
    return request.audit ? audit(request) : run(request, system);
  });
}
