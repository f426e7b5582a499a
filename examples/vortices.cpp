// Point vortices in the plane, from a preset or a CSV file, by any method; in background flows and between walls.
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "common/arguments.hpp"
#include "common/cost.hpp"
#include "common/run.hpp"
#include "common/scene_program.hpp"
#include "common/series_csv.hpp"
#include "common/table.hpp"
#include "vortices/file.hpp"
#include "vortices/measurements.hpp"
#include "vortices/picture.hpp"

namespace {

using namespace examples;
using System = systems::PointVortices<>;
using Column = System::Column;
constexpr int any = Eigen::Dynamic;
using State = PhasePoint<double, any>;

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

State start(const Vortices& v) { return System(v.circulation).phase_point(v.x, v.y); }

std::vector<ScenePreset<any>> presets() {
  struct Row {
    std::string name, about;
    std::vector<std::string> effects, also;
    std::map<std::string, std::string> values;
    std::string dt, time;
    std::function<Measurement<any>(const Choice&)> measure;
  };
  const std::vector<Row> rows{
      {"paper",
       "the ten vortices of Jayawardana and Ohsawa",
       {"pairs"},
       {"strain", "rotation"},
       {{"strain_rate", "1e-3"}, {"strain_angle", "0"}, {"rotation_rate", "1e-3"}, {"radius", "20"}},
       "0.1",
       "1000",
       {}},
      {"disparate",
       "ten vortices whose circulations and distances differ much",
       {"pairs"},
       {"strain", "rotation"},
       {{"strain_rate", "1e-3"}, {"strain_angle", "0"}, {"rotation_rate", "1e-3"}, {"radius", "100"}},
       "0.01",
       "100",
       {}},
      {"wall",
       "a vortex pair that comes to a wall and goes along it",
       {"pairs", "half_plane"},
       {"strain"},
       {{"strain_rate", "1e-4"}, {"strain_angle", "0"}},
       "0.1",
       "200",
       along_the_wall},
      {"disk",
       "a vortex in a disk",
       {"pairs", "disk"},
       {"rotation"},
       {{"radius", "1"}, {"rotation_rate", "1e-3"}},
       "0.1",
       "100",
       about_the_centre}};
  std::vector<ScenePreset<any>> list;
  for (const Row& row : rows)
    list.push_back({.name = row.name,
                    .about = row.about,
                    .units = {"numbers"},
                    .effects = row.effects,
                    .also = row.also,
                    .values = row.values,
                    .dt = row.dt,
                    .time = row.time,
                    .start = [name = row.name](const Choice&) { return start(vortex_sets().at(name)); },
                    .measure = row.measure});
  return list;
}

/// `wet` says whether a vortex is on the right side of the wall of that name.
template <class Wet>
void refuse_dry(const Vortices& v, const std::string& name, const Wet& wet) {
  for (Eigen::Index i = 0; i < v.x.size(); ++i)
    if (!wet(v.x[i], v.y[i]))
      throw std::invalid_argument("--effects: vortex " + std::to_string(i) + " is on the dry side of " +
                                  name);
}

/// The effects on `v`, which has its vortices when an effect is made.
std::vector<EffectEntry<any>> all_effects(const Vortices& v) {
  const auto gamma = [&v] { return vortices::Circulations<>(v.circulation); };
  const char* const newton = "Newton, The N-Vortex Problem (2001), chapters 2 and 3";
  const char* const images = "Newton (2001), section 3.2; Saffman, Vortex Dynamics (1992), section 7";
  return {{{}, newton, [=](const Choice&) { return vortices::Pairs<>(gamma()); }},
          {{"strain_rate", "strain_angle"},
           newton,
           [=](const Choice& c) { return vortices::Strain<>(gamma(), c["strain_rate"], c["strain_angle"]); }},
          {{"rotation_rate"},
           newton,
           [=](const Choice& c) { return vortices::Rotation<>(gamma(), c["rotation_rate"]); }},
          {{},
           images,
           [=, &v](const Choice& c) {
             if (c.on("disk"))
               throw std::invalid_argument("--effects: half_plane and disk are two flows; take one");
             if (c.on("rotation") || (c.on("strain") && std::sin(2 * c["strain_angle"]) != 0))
               throw std::invalid_argument(
                   "--effects: only strain with --strain_angle 0 flows along half_plane, not through it");
             refuse_dry(v, "half_plane", [](double, double y) { return y > 0; });
             return vortices::HalfPlane<>(gamma());
           }},
          {{"radius"}, images, [=, &v](const Choice& c) {
             if (c.on("strain"))
               throw std::invalid_argument("--effects: strain flows through the wall of disk; take one");
             const double radius = c["radius"];
             refuse_dry(v, "disk", [=](double x, double y) { return std::hypot(x, y) < radius; });
             return vortices::Disk<>(gamma(), radius);
           }}};
}

/// What the flow keeps. An impulse that cancels but for rounding counts as zero, so that its error is absolute.
template <class H>
Invariants<double, any> invariants_of(const H& hamiltonian, const System& system, const Vortices& v,
                                      const Choice& c) {
  Invariants<double, any> invariants(hamiltonian);
  const auto z = system.phase_point(v.x, v.y);
  const auto add = [&](const char* name, auto impulse, double size) {
    const double initial = (system.*impulse)(z.q(), z.p());
    const double offset = std::abs(initial) <= 1e-14 * size ? initial : 0;
    invariants.add(name, [=](const auto& q, const auto& p) { return (system.*impulse)(q, p) - offset; });
  };
  const Column weight = v.circulation.cwiseAbs();
  const bool still = !c.on("strain") && !c.on("rotation") && !c.on("disk");
  if (still && !c.on("half_plane")) add("impulse_x", &System::linear_impulse_x, weight.dot(v.x.cwiseAbs()));
  if (still) add("impulse_y", &System::linear_impulse_y, weight.dot(v.y.cwiseAbs()));
  if (!c.on("strain") && !c.on("half_plane"))
    add("angular_impulse", &System::angular_impulse, weight.dot(v.x.cwiseAbs2() + v.y.cwiseAbs2()));
  return invariants;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Point vortices in the plane, from a preset or a file."};
  Vortices vortices;
  SceneProgram<any> program{.name = "vortices", .about = app.get_description()};
  program.parameters = {{"strain_rate", "1/s", "of the strain"},
                        {"strain_angle", "rad", "of the axis along which it stretches"},
                        {"rotation_rate", "rad/s", "of the rotation, counterclockwise"},
                        {"radius", "m", "of the disk", above_zero}};
  program.effects = all_effects(vortices);
  program.presets = presets();
  SceneRequest<any> request(program);
  request.add_to(app);
  for (const char* name : {"--dt", "--time"}) app.get_option(name)->check(positive());
  std::string input;
  app.add_option("--input", input, "CSV file with the columns x,y,gamma: a line a vortex, # begins a comment")
      ->type_name("FILE")
      ->excludes("--preset");
  Settings settings;
  Method method;
  std::vector<std::string> methods = Method::names();
  methods.push_back("splitting");
  add_method(app, method, methods);
  add_output(app, settings);
  CostRequest cost;
  add_cost(app, cost);
  CheckpointRequest checkpoint;
  add_checkpoint(app, checkpoint);
  app.get_option("--audit")->excludes("--checkpoint");
  app.get_option("--audit")->excludes("--cost")->excludes("--accuracy");

  return run_program(app, argc, argv, [&] {
    if (request.list_presets) request.print_presets(std::cout);
    if (request.list_effects) request.print_effects(std::cout);
    if (request.list_presets || request.list_effects) return 0;
    if (!input.empty()) {
      vortices = read_vortices(input);
      program.presets.push_back({.name = input,
                                 .about = "vortices of a file",
                                 .units = program.presets.front().units,
                                 .effects = {"pairs"},
                                 .dt = "0.01",
                                 .time = "100",
                                 .start = [&](const Choice&) { return start(vortices); }});
      request.preset_name = input;
    }
    const auto& preset = request.preset();
    if (input.empty()) vortices = vortex_sets().at(preset.name);
    const Choice choice = request.choice();
    const RuntimeScene<double, any> scene = request.scene(choice);
    // Nothing but pairs is worth a type of its own, which runs several times faster.
    const System system(vortices.circulation);
    const bool only_pairs = choice.effects == std::vector<std::string>{"pairs"};
    const auto with_hamiltonian = [&](const auto& use) { return only_pairs ? use(system) : use(scene); };
    if (request.audit)
      refuse_options(app, "--audit",
                     {"--method", "--solver", "--rule", "--tolerance", "--omega", "--stages"});
    if (app.count("--method") == 0 && scene.is_separable()) method.name = "splitting";
    if (!cost.wanted(app)) refuse_idle_options(app, {method.name});
    request.put_times_into(settings);
    request.refuse_idle_parameters(choice);
    const State z0 = start(vortices);
    refuse_start(scene, z0);
    const auto invariants =
        with_hamiltonian([&](const auto& h) { return invariants_of(h, system, vortices, choice); });
    if (request.audit) {
      show_audit(scene, z0, invariants, settings, method, Compare::state);
      return 0;
    }
    if (cost.wanted(app)) {
      settings.make_output_folder();
      const CostOfAccuracy found = with_hamiltonian(
          [&](const auto& h) { return cost_of_accuracy(h, z0, settings.time, cost.options()); });
      if (cost.curve) {
        show_cost(found, settings, "vortices_cost", std::to_string(vortices.x.size()) + " vortices");
        return 0;
      }
      cost.choose(found, method, settings);
    }
    settle_method(scene, method);
    const std::int64_t steps = settings.fit_steps();
    settings.make_output_folder();

    const std::filesystem::path csv = settings.output / "vortices.csv",
                                places_csv = settings.output / "vortices_trajectory.csv",
                                png = settings.output / "vortices.png";
    PlacesCsv places(places_csv, system);
    auto some_places = every(stride(steps, settings.samples), places);
    const Measurement<any> measurement = preset.measure ? preset.measure(choice) : Measurement<any>{};
    Measuring<any> observe{measurement};
    checkpoint.run << preset.name << ": " << joined(scene.names());
    checkpoint.run.precision(17);
    for (const auto& [parameter, value] : choice.values) checkpoint.run << ", " << parameter << ' ' << value;
    checkpoint.run << "; " << steps << " steps, samples " << settings.samples;
    const auto go = [&](const auto& hamiltonian) {
      return run_method(method, hamiltonian, z0, invariants, settings.dt,
                        evenly_spaced(steps, settings.samples), steps, checkpoint, some_places, observe);
    };
    const Run run =
        method.name == "splitting" ? go(SeparableRuntimeScene<double, any>(scene)) : with_hamiltonian(go);

    print_table(std::cout, {run}, settings.dt);
    cost.compare_with(run);
    measurement.print(std::cout, run);
    places.commit();
    write_series(csv, {run});
    checkpoint.finish();
    std::cout << "data: " << csv.string() << ", " << places_csv.string() << '\n';
    const std::string headline =
        std::to_string(vortices.x.size()) + (vortices.x.size() == 1 ? " vortex (" : " vortices (") +
        std::filesystem::path(preset.name).filename().string() + "): " + joined(scene.names()) + "; " +
        method.name + ", dt = " + formatted("%g", settings.dt) + (run.is_result() ? "" : "; NO RESULT");
    if (!settings.no_plot)
      draw(png, vortex_script(png, places_csv, csv, vortices, run, headline, settings.time, places, choice));

    return tell_failure(run) ? 1 : 0;
  });
}
