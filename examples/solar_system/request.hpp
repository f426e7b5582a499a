#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "../common/arguments.hpp"
#include "../common/cost.hpp"
#include "../common/output.hpp"
#include "../common/run.hpp"
#include "motion.hpp"
#include "planets.hpp"

namespace examples {

/// What is on, how long, and with which step.
struct Preset {
  std::string name, dt, time;
  std::vector<std::string> effects;
};
inline const std::vector<Preset>& presets() {
  static const std::vector<Preset> all{
      {"planets",
       "8 day",
       "800 year",
       {"mercury", "venus", "earth", "mars", "jupiter", "saturn", "uranus", "neptune", "1pn"}},
      {"inner", "8 day", "10000 year", {"mercury", "venus", "earth", "mars", "jupiter", "saturn", "1pn"}},
      {"outer", "0.4 year", "1000000 year", {"jupiter", "saturn", "uranus", "neptune"}}};
  return all;
}
inline std::vector<std::string> preset_names() {
  std::vector<std::string> names;
  for (const Preset& each : presets()) names.push_back(each.name);
  return names;
}
/// One of those names.
inline const Preset& preset_called(const std::string& name) {
  return *std::find_if(presets().begin(), presets().end(),
                       [&](const Preset& each) { return each.name == name; });
}

/// What the user wants.
struct Request {
  std::string preset = "planets", list{}, dt{}, time{};
  std::vector<std::string> effects{};
  bool audit = false;
  Settings settings{};
  CostRequest cost{};
  CheckpointRequest checkpoint{};

  void add_to(CLI::App& app) {
    std::vector<std::string> known = corrections;
    for (const Planet& planet : planets()) known.push_back(planet.name);
    add_value(app, "--preset", preset, joined(preset_names()), one_of(preset_names()), "NAME");
    app.add_option("--effects", effects, "which are on, as a,b,c: " + joined(known))
        ->delimiter(',')
        ->check(one_of(known))
        ->type_name("NAMES")
        ->default_str("the preset's");
    app.add_option("--dt", dt, "step; made a little smaller where the time is no multiple")
        ->type_name("X[ UNIT]")
        ->default_str("the preset's; a plain number is in years");
    app.add_option("--time", time, "to integrate to; with --audit, half of it to each side of J2000")
        ->type_name("X[ UNIT]")
        ->default_str("the preset's");
    app.add_option("--list", list, "of the splitting: " + joined(list_names()))
        ->check(one_of(list_names()))
        ->type_name("NAME")
        ->default_str("aba1064; with --audit aba82");
    app.add_flag("--audit", audit, "Clemence's table: what each effect turns Mercury's perihelion by");
    add_output(app, settings);
    cost.add_to(app, true);
    checkpoint.add_to(app);
    app.get_option("--audit")->excludes("--checkpoint");
  }

  /// Fills in what the preset says. Throws std::invalid_argument for what cannot be read, and for an effect
  /// that is named twice: it would count twice.
  void read() {
    const Preset& chosen = preset_called(preset);
    const UnitSystem units{.about = "au, year", .length = au, .time = year};
    if (effects.empty()) effects = chosen.effects;
    for (auto one = effects.begin(); one != effects.end(); ++one)
      if (std::find(effects.begin(), one, *one) != one)
        throw std::invalid_argument("--effects: " + *one + " is named twice");
    if (list.empty()) list = audit ? "aba82" : "aba1064";
    settings.dt = read_option("dt", dt.empty() ? chosen.dt : dt, "s", units, true);
    settings.time = read_option("time", time.empty() ? chosen.time : time, "s", units, true);
  }

  /// Throws std::invalid_argument where the audit, or an accuracy, does not go with the rest.
  void refuse_wrong_audit(const System& system) const {
    if (!audit && !cost.unit.empty())
      throw std::invalid_argument(
          "--accuracy: an angle is that of Mercury's perihelion, which --audit measures; add --audit, or "
          "give "
          "a relative energy error, as 1e-9");
    if (!audit) return;
    if (system.names.front() != "mercury")
      throw std::invalid_argument("--audit: Mercury's perihelion needs mercury among the --effects");
    if (effects.size() < 2) throw std::invalid_argument("--audit: name an effect beside mercury");
    constexpr double mercury_year = 0.2408, longest = 22 / days_a_year;  // a quarter of it
    const bool finds_dt = cost.curve || cost.accuracy > 0;
    if (!finds_dt && settings.dt > longest)
      throw std::invalid_argument("--audit: a step goes through " +
                                  formatted("%.2g of Mercury's orbit; ", settings.dt / mercury_year) +
                                  "give a --dt of 22 days or less");
    // The perihelion swings with each planet, and in 5.7 years as five of its turns are nearly two of Venus.
    const double needed = std::ceil(std::max(20.0, 2 * system.longest_period));
    if (settings.time < needed)
      throw std::invalid_argument(
          formatted("--audit: %g years are too short: ", settings.time) +
          "the perihelion swings with the planets, and a line through it means something over "
          "20 years, and two turns of the outermost planet; give a --time of " +
          formatted("%g years or more", needed));
    if (cost.accuracy > 0 && cost.unit.empty())
      throw std::invalid_argument(
          "--accuracy: with --audit it is that of the perihelion; give an angle, as \"0.001 arcsec\"");
  }

  /// A file in the output folder.
  std::filesystem::path file(const char* extension) const {
    return settings.output / ((audit ? "solar_system_perihelion" : "solar_system") + std::string(extension));
  }
};

}  // namespace examples
