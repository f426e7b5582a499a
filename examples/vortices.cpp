// Point vortices in the plane, from a preset or a CSV file, by any method; in background flows and between
// walls.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/scene_program.hpp"
#include "vortices/effects.hpp"
#include "vortices/file.hpp"
#include "vortices/measurements.hpp"
#include "vortices/picture.hpp"

namespace {

using namespace examples;
using System = systems::PointVortices<>;
using Column = System::Column;
constexpr int any = Eigen::Dynamic;

Column column(std::initializer_list<double> values) {
  return Eigen::Map<const Column>(values.begin(), static_cast<Eigen::Index>(values.size()));
}

/// "paper" is the set of Jayawardana and Ohsawa; in "disparate" circulations and distances differ much more.
const std::map<std::string, Vortices>& vortex_sets() {
  static const std::map<std::string, Vortices> sets{
      {"paper",
       {.x = column({3, -10, 6, 9, 0, 7, -8, 5, 9, 7}),
        .y = column({-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
        .circulation = column({-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6})}},
      {"disparate",
       {.x = column({.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4}),
        .y = column({5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4}),
        .circulation = column({-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8})}},
      {"wall", {.x = column({-1, 1}), .y = column({5, 5}), .circulation = column({-1, 1})}},
      {"disk", {.x = column({.5}), .y = column({0}), .circulation = column({1})}}};
  return sets;
}

std::vector<ScenePreset<any>> presets() {
  const ScenePreset<any> paper{
      .name = "paper",
      .about = "the ten vortices of Jayawardana and Ohsawa",
      .units = {"numbers"},
      .effects = {"pairs"},
      .also = {"strain", "rotation"},
      .values = {{"strain_rate", "1e-3"}, {"strain_angle", "0"}, {"rotation_rate", "1e-3"}, {"radius", "20"}},
      .dt = "0.1",
      .time = "1000",
      .start = {}};
  ScenePreset<any> disparate = paper;
  disparate.name = "disparate";
  disparate.about = "ten vortices whose circulations and distances differ much";
  disparate.values["radius"] = "100";
  disparate.dt = "0.01";
  disparate.time = "100";
  std::vector<ScenePreset<any>> list{paper,
                                     disparate,
                                     {.name = "wall",
                                      .about = "a vortex pair that comes to a wall and goes along it",
                                      .units = {"numbers"},
                                      .effects = {"pairs", "half_plane"},
                                      .also = {"strain"},
                                      .values = {{"strain_rate", "1e-4"}, {"strain_angle", "0"}},
                                      .dt = "0.1",
                                      .time = "200",
                                      .start = {},
                                      .measure = along_the_wall},
                                     {.name = "disk",
                                      .about = "a vortex in a disk",
                                      .units = {"numbers"},
                                      .effects = {"pairs", "disk"},
                                      .also = {"rotation"},
                                      .values = {{"radius", "1"}, {"rotation_rate", "1e-3"}},
                                      .dt = "0.1",
                                      .time = "100",
                                      .start = {},
                                      .measure = about_the_centre}};
  for (auto& preset : list)
    preset.start = [name = preset.name](const Choice&) { return start(vortex_sets().at(name)); };
  return list;
}

}  // namespace

int main(int argc, char** argv) {
  SceneProgram<any> program{.name = "vortices",
                            .about = "Point vortices in the plane, from a preset or a file."};
  Vortices vortices;
  std::string input;
  program.parameters = {{"strain_rate", "1/s", "of the strain"},
                        {"strain_angle", "rad", "of the axis along which it stretches"},
                        {"rotation_rate", "rad/s", "of the rotation, counterclockwise"},
                        {"radius", "m", "of the disk", above_zero}};
  program.effects = vortex_effects(vortices);
  program.presets = presets();
  program.compare = Compare::state;
  program.add_options = [&](CLI::App& app) {
    app.add_option("--input", input,
                   "CSV file with the columns x,y,gamma: a line a vortex, # begins a comment")
        ->type_name("FILE")
        ->check([](const std::string& name) { return name.empty() ? "an empty name" : ""; })
        ->excludes("--preset");
  };
  program.prepare = [&](const std::string& preset) {
    if (const auto set = vortex_sets().find(preset); set != vortex_sets().end()) vortices = set->second;
    if (input.empty()) return preset;
    vortices = read_vortices(input);
    // In front: its name may be that of another preset.
    program.presets.insert(program.presets.begin(),
                           {.name = input,
                            .about = "vortices of a file",
                            .units = {"numbers"},
                            .effects = {"pairs"},
                            .dt = "0.01",
                            .time = "100",
                            .start = [&](const Choice&) { return start(vortices); }});
    return input;
  };
  program.add_invariants = [&](auto& invariants, const Choice& c) { add_impulses(invariants, vortices, c); };
  program.view = [&](const Choice& c) { return places(vortices, c); };
  // Nothing but pairs is worth a type of its own, which runs several times faster.
  return run_scene_program(program, argc, argv, [&](const Choice& c) {
    return c.only({"pairs"}) ? std::optional(System(vortices.circulation)) : std::nullopt;
  });
}
