#pragma once

#include <algorithm>
#include <map>
#include <ostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "arguments.hpp"
#include "scene_choice.hpp"
#include "units.hpp"

namespace examples {

/// The options that the user gave, and what they mean for a program.
template <int Dof>
class SceneRequest {
 public:
  explicit SceneRequest(const SceneProgram<Dof>& program) : program_(program) {}

  std::string preset_name;
  std::vector<std::string> effects;
  std::string dt, time;
  bool list_presets = false, list_effects = false, audit = false;

  void add_to(CLI::App& app) {
    const auto add = [&](const std::string& name, auto& value, const std::string& what, const char* type) {
      return app.add_option("--" + name, value, what)
          ->type_name(type)
          ->default_str("the preset's")
          ->check(CLI::Validator(
              [](const std::string& text) { return text.empty() ? "nothing is given" : ""; }, "", "given"));
    };
    preset_name = program_.presets.front().name;
    add_value(app, "--preset", preset_name, "a set-up ready made; see --list-presets", CLI::Validator(),
              "NAME");
    add("effects", effects, "the effects that are on, as a,b,c; see --list-effects", "NAMES")->delimiter(',');
    app.add_flag("--list-presets", list_presets, "list them, with their effects, and stop");
    app.add_flag("--list-effects", list_effects, "list them, with their parameters, and stop");
    app.add_flag("--audit", audit,
                 "print what each effect is worth and which are called for, instead of a long run");
    add("dt", dt, "step size; made a little smaller where the time is no multiple", "X[ UNIT]");
    add("time", time, "time to integrate to", "X[ UNIT]");
    for (const Parameter& parameter : program_.parameters)
      add(parameter.name, texts_[parameter.name], about(parameter), parameter.unit.empty() ? "X" : "X[ UNIT]")
          ->default_str("")
          ->group(
              "Parameters; the defaults are the preset's, and a number without a unit is in the preset's "
              "units (--list-presets)");
    add_config(app);
  }

  /// Lists what is asked for; false: nothing.
  bool list(std::ostream& out) const {
    if (list_presets) print_presets(out);
    if (list_effects) print_effects(out);
    return list_presets || list_effects;
  }

  const ScenePreset<Dof>& preset() const {
    std::vector<std::string> names;
    for (const auto& preset : program_.presets) {
      if (preset.name == preset_name) return preset;
      names.push_back(preset.name);
    }
    throw std::invalid_argument("--preset: " + unknown_name("preset", preset_name, names));
  }

  /// Throws std::invalid_argument, in one line, for unknown names and units.
  Choice choice() const {
    const auto& chosen = preset();
    Choice choice{.preset = chosen.name, .effects = effects, .values = {}, .units = chosen.units};
    if (effects.empty()) {
      choice.effects = chosen.effects;
      if (audit) choice.effects.insert(choice.effects.end(), chosen.also.begin(), chosen.also.end());
    }
    std::vector<std::string> names;
    for (const auto& entry : program_.effects) names.push_back(entry.name);
    for (std::string& effect : choice.effects) {
      CLI::detail::trim(effect);  // "a, b"
      if (std::find(names.begin(), names.end(), effect) == names.end())
        throw std::invalid_argument("--effects: " + unknown_name("effect", effect, names));
      if (std::count(choice.effects.begin(), choice.effects.end(), effect) > 1)
        throw std::invalid_argument("--effects: " + effect + " is named twice");
    }
    if (program_.one_effect && choice.effects.size() > 1)
      throw std::invalid_argument("--effects: each of " + joined(names) +
                                  " is a whole Hamiltonian; name one");
    choice.is_preset = effects.empty() || choice.only(chosen.effects);
    for (const auto& [name, unit, about, allowed] : program_.parameters) {
      const auto given = chosen.values.find(name);
      if (given != chosen.values.end()) choice.values[name] = quantity(name, given->second, unit);
      const std::string& text = texts_.at(name);
      if (text.empty()) continue;
      const double value = quantity(name, text, unit);
      if (!allowed.holds(value))
        throw std::invalid_argument("--" + name + ": '" + text + "' is not " + allowed.words);
      if (given == chosen.values.end() || value != choice.values[name]) choice.is_preset = false;
      choice.values[name] = value;
    }
    return choice;
  }

  /// The step and the time.
  void put_times_into(Settings& settings) const {
    settings.dt = quantity("dt", dt.empty() ? preset().dt : dt, "s", true);
    settings.time = quantity("time", time.empty() ? preset().time : time, "s", true);
  }

  /// The effects that are on, in the program's order.
  RuntimeScene<double, Dof> scene(const Choice& choice) const {
    std::vector<AnyEffect<double, Dof>> list;
    for (const auto& entry : program_.effects)
      if (entry.make && choice.on(entry.name)) list.push_back(entry.make(choice));
    if (list.empty()) throw std::invalid_argument("--effects: nothing that moves anything is on");
    return RuntimeScene<double, Dof>(std::move(list));
  }

  /// To be called when the effects and the start are made. Throws std::invalid_argument where one of the
  /// parameters that the user gave has not been asked for.
  void refuse_idle_parameters(const Choice& choice) const {
    for (const auto& [name, text] : texts_) {
      if (text.empty() || choice.used->count(name) > 0) continue;
      std::vector<std::string> listeners;
      std::string on;
      for (const auto& entry : program_.effects) {
        if (choice.on(entry.name) && !program_.one_effect) on += entry.name + ",";
        if (std::find(entry.parameters.begin(), entry.parameters.end(), name) != entry.parameters.end())
          listeners.push_back(entry.name);
      }
      throw std::invalid_argument("--" + name + " means nothing to the preset " + preset().name +
                                  (listeners.empty()
                                       ? std::string("; leave it out")
                                       : " with these effects; it goes with " + joined(listeners) +
                                             ", as in --effects " + on + listeners.front()));
    }
  }

  /// Which options can be why there is no start: those that were given, of them those that are zero; where
  /// none was given, the zeros of the preset.
  std::string suspects(const Choice& choice) const {
    std::vector<std::string> zeros, given;
    for (const auto& [name, text] : texts_)
      if (!text.empty()) given.push_back("--" + name);
    for (const auto& [name, value] : choice.values)
      if (value == 0 && choice.used->count(name) > 0 && (given.empty() || !texts_.at(name).empty()))
        zeros.push_back("--" + name);
    if (!zeros.empty()) return "one of these is zero and must not be: " + joined(zeros);
    const std::string wrong = " too large, too small, or a start where a force has no bound";
    return given.empty() ? "a number of it is" + wrong + "; look at the file that was read, or the preset"
                         : "one of these is" + wrong + ": " + joined(given);
  }

 private:
  void print_presets(std::ostream& out) const {
    for (const auto& preset : program_.presets) {
      out << preset.name << ": " << preset.about << "\n  effects: " << joined(preset.effects);
      if (!preset.also.empty()) out << " (values also for " << joined(preset.also) << ')';
      out << "\n  units: " << preset.units.about << "\n  dt = " << preset.dt << ", time = " << preset.time;
      for (const auto& [name, value] : preset.values) out << ", " << name << " = " << value;
      out << '\n';
    }
  }

  void print_effects(std::ostream& out) const {
    for (const auto& entry : program_.effects) {
      out << entry.name << ": " << entry.about << (entry.acts.empty() ? "" : "; " + entry.acts) << '\n';
      for (const std::string& name : entry.parameters)
        for (const Parameter& parameter : program_.parameters)
          if (parameter.name == name)
            out << "  --" << name << ": " << about(parameter) << " [" << dimension(read_unit(parameter.unit))
                << "]\n";
      if (!entry.source.empty()) out << "  source: " << entry.source << '\n';
    }
    std::vector<std::string> units;
    for (const auto& [name, unit] : known_units()) units.push_back(name);
    out << "Parameters are in the units of the preset, or have one behind them: --c \"299792.458 km/s\". "
           "Units: "
        << joined(units) << ".\n";
  }

  /// What a parameter is. Angles are in radians in all presets.
  static std::string about(const Parameter& parameter) {
    return parameter.about + (parameter.unit == "rad" ? "; in radians, or as \"90 deg\"" : "");
  }

  double quantity(const std::string& option, const std::string& text, const std::string& unit,
                  bool positive = false) const {
    return read_option(option, text, unit, preset().units, positive);
  }

  const SceneProgram<Dof>& program_;
  std::map<std::string, std::string> texts_;
};

}  // namespace examples
