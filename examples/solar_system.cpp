// The Sun and its planets: Kepler's motion exact, their attraction kicked, only relativity doubled. --audit: Clemence's table.
#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/arguments.hpp"
#include "common/output.hpp"
#include "solar_system/clemence.hpp"
#include "solar_system/measurements.hpp"
#include "solar_system/planets.hpp"

namespace {

using namespace examples;

struct Preset {
  std::string name, dt, time;
  std::vector<std::string> effects;
};
const std::vector<Preset>& presets() {
  static const std::vector<Preset> all{
      {"planets",
       "8 day",
       "800 year",
       {"mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune", "1pn"}},
      {"inner", "8 day", "10000 year", {"mercury", "venus", "earth", "mars", "jupiter", "saturn", "1pn"}},
      {"outer", "0.4 year", "1000000 year", {"jupiter", "saturn", "uranus", "neptune"}}};
  return all;
}

NearIntegrable<double> list_called(const std::string& name) {
  for (const auto& list : {schemes::aba82<double>(), schemes::aba84<double>(), schemes::aba104<double>(),
                           schemes::aba864<double>(), schemes::aba1064<double>()})
    if (list.name == name) return list;
  throw std::invalid_argument("--list: no list " + name);
}

std::string curves(const std::filesystem::path& png, const std::filesystem::path& csv,
                   const std::string& title, const std::string& label, std::size_t count,
                   std::size_t stride) {
  std::string text = gnuplot_prologue(png, 1200, 800) + "set title " + quoted(title) +
                     " noenhanced\nset xlabel 'years from J2000'\nset ylabel '" + label +
                     "'\nset grid\nset key outside right noenhanced\nplot ";
  for (std::size_t i = 0; i < count; ++i)
    text += (i > 0 ? ", \\\n  " : "") + quoted(csv.string()) + " using 1:" + std::to_string(2 + i * stride) +
            " with lines linewidth 1.5 linetype " + std::to_string(i + 1) + (i > 7 ? " dashtype 2" : "") +
            " title columnheader(" + std::to_string(2 + i * stride) + ")";
  return text + '\n';
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The Sun and its planets, from their elements of J2000; the Earth with the Moon."};
  std::string preset = "planets", list = "", dt_text, time_text;
  std::vector<std::string> effects, known = corrections, names;
  bool audit = false;
  Settings settings;
  for (const Planet& planet : planets()) known.push_back(planet.name);
  for (const Preset& each : presets()) names.push_back(each.name);
  add_value(app, "--preset", preset, joined(names), one_of(names), "NAME");
  app.add_option("--effects", effects, "which are on, as a,b,c: " + joined(known))
      ->delimiter(',')
      ->check(one_of(known))
      ->type_name("NAMES")
      ->default_str("the preset's");
  app.add_option("--dt", dt_text, "step; made a little smaller where the time is no multiple")
      ->type_name("X[ UNIT]")
      ->default_str("the preset's; a plain number is in years");
  app.add_option("--time", time_text, "to integrate to; with --audit, half of it to each side of J2000")
      ->type_name("X[ UNIT]")
      ->default_str("the preset's");
  app.add_option("--list", list, "of the splitting: aba82, aba84, aba104, aba864, aba1064")
      ->check(one_of({"aba82", "aba84", "aba104", "aba864", "aba1064"}))
      ->type_name("NAME")
      ->default_str("aba1064; with --audit aba82");
  app.add_flag("--audit", audit, "Clemence's table: what each effect turns Mercury's perihelion by");
  add_output(app, settings);

  return run_program(app, argc, argv, [&] {
    const Preset& chosen = *std::find_if(presets().begin(), presets().end(),
                                         [&](const Preset& each) { return each.name == preset; });
    const UnitSystem units{.about = "au, year", .length = au, .time = year};
    if (effects.empty()) effects = chosen.effects;
    settings.dt = read_quantity(dt_text.empty() ? chosen.dt : dt_text, "s", units, true);
    settings.time = read_quantity(time_text.empty() ? chosen.time : time_text, "s", units, true);
    const std::int64_t steps = settings.fit_steps();
    if (list.empty()) list = audit ? "aba82" : "aba1064";
    const System system(effects);
    const std::filesystem::path stem = settings.output / (audit ? "solar_system_perihelion" : "solar_system");
    const std::filesystem::path csv = stem.string() + ".csv", png = stem.string() + ".png";
    if (audit) {
      if (system.names.front() != "mercury")
        throw std::invalid_argument("--audit: Mercury's perihelion needs mercury among the --effects");
      if (effects.size() < 2) throw std::invalid_argument("--audit: name an effect beside mercury");
      const PerihelionTable table = clemence(effects, list_called(list), settings.dt, settings.time);
      settings.make_output_folder();
      write_perihelion(csv, table);
      std::cout << "data: " << csv.string() << '\n';
      if (!settings.no_plot)
        draw(png, curves(png, csv, "By what each effect turns the perihelion of Mercury", "arcseconds",
                         table.curves.size(), 1));
      return 0;
    }
    settings.make_output_folder();
    std::vector<std::string> columns{"t"};
    for (const std::string& name : system.names) columns.insert(columns.end(), {"e_" + name, "i_" + name});
    columns.emplace_back("energy_error");
    CsvWriter writer(csv, columns);
    bool fine = false;
    with_splitting(system, list_called(list), [&](auto& stepper) {
      std::cout << explain(stepper) << '\n';
      State z = system.start;
      Invariants invariants(stepper.hamiltonian());
      invariants.add("angular_momentum", [](const auto& q, const auto& p) { return spin(q, p)[2]; });
      const auto row = [&](double t, const State& now) {
        std::vector<double> values{t};
        for (const double value : shapes(system, now)) values.push_back(value);
        values.push_back(invariants["energy"].final);
        writer.row(values);
      };
      const auto stride = std::max<std::int64_t>(1, (steps + settings.samples - 1) / settings.samples);
      auto rows = every(stride, row);
      const IntegrationReport run = integrate(
          stepper, z, {.dt = settings.dt, .steps = steps, .on_failure = OnFailure::stop}, invariants, rows);
      std::cout << formatted("%g years, %.0f steps of %.6g days: ", run.t, double(run.steps),
                             settings.dt * 365.25)
                << formatted("energy error %.1e (at the end %.1e), ", invariants["energy"].worst,
                             invariants["energy"].final)
                << formatted("angular momentum %.1e\n", invariants["angular_momentum"].worst)
                << formatted("%.2f seconds, %.3g years a second\n", run.seconds, run.t / run.seconds);
      fine = run.ok();
      if (!fine) std::cerr << formatted("solar_system: at t = %g: ", run.t) << describe(run.status) << '\n';
    });
    writer.commit();
    std::cout << "data: " << csv.string() << '\n';
    if (!settings.no_plot)
      draw(png, curves(png, csv, "Eccentricities about the Sun: " + joined(effects), "eccentricity",
                       system.names.size(), 2));
    return fine ? 0 : 1;
  });
}
