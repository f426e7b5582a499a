#pragma once

#include <cmath>
#include <filesystem>
#include <iostream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "arguments.hpp"
#include "cost.hpp"
#include "run.hpp"
#include "scene_choice.hpp"
#include "scene_picture.hpp"
#include "scene_request.hpp"
#include "series_csv.hpp"
#include "table.hpp"

// A program whose user chooses the effects. It says what there is, as data, and the rest is done here:
//
//     int main(int argc, char** argv) {
//       SceneProgram<3> program{.name = "orbits", .about = "An orbit."};
//       program.parameters = {{"gm", "m3/s2", "GM of the centre"}, {"a", "m", "semi-major axis"}};
//       program.effects = {
//           {{}, "", [](const Choice&) { return orbits::Kinetic<double, 3>{}; }},
//           {{"gm"}, "Newton (1687)", [](const Choice& c) { return orbits::Attraction<double, 3>{.gm = c["gm"]}; }}};
//       program.presets = {{.name = "earth", .about = "the Earth about the Sun",
//                           .units = {"AU, year", 149597870700.0, 31557600.0},
//                           .effects = {"kinetic", "attraction"},
//                           .values = {{"gm", "1 GMsun"}, {"a", "1"}},
//                           .dt = "2 day", .time = "1 century",
//                           .start = [](const Choice& c) { return PhasePoint<double, 3>(...); }}};
//       program.view = [](const Choice&) { return path_view<3>({"x", "y", "z", "px", "py", "pz"}, "x", "y", "AU"); };
//       return run_scene_program(program, argc, argv);
//     }
//
// Options of its own (a file to read, say) a program adds by `program.add_options = [&](CLI::App& app) {...}`; the functions
// above are all called after the arguments are read, and may refer to what these options wrote. Parameters must not have
// the names of the common options (dt, time, omega, ...).
namespace examples {

/// The table of the audit, and what it means at some accuracies.
template <int Dof>
void show_audit(const RuntimeScene<double, Dof>& scene, const PhasePoint<double, Dof>& z0,
                const Invariants<double, Dof>& invariants, const Settings& settings, const Method& method,
                Compare compare) {
  AuditOptions<double, Dof> options{.dt = settings.dt, .compare = compare};
  if (method.scheme) options.scheme = schemes::by_name<double>(*method.scheme);
  for (const auto& row : invariants.rows())
    if (row.name != "energy") options.invariants.emplace_back(row.name, row.value);
  const Audit found = audit(scene, z0, settings.time, options);
  std::cout << found << '\n';
  for (const double accuracy : {1e-2, 1e-4, 1e-6, 1e-8, 1e-10}) {
    std::cout << "called for at " << formatted("%.0e", accuracy) << ": "
              << joined(found.called_for(accuracy));
    const auto open = found.undecided(accuracy);
    if (!open.empty())
      std::cout << " (below the numerical error: " << joined(open) << "; take a smaller --dt)";
    std::cout << '\n';
  }
}

/// A start that is not finite, or where the energy is not.
template <int Dof>
void refuse_start(const RuntimeScene<double, Dof>& scene, const PhasePoint<double, Dof>& z0) {
  if (!z0.vector().allFinite() || !std::isfinite(scene.energy(z0.q(), z0.p())))
    throw std::invalid_argument(
        "these values make no start: its position, momentum or energy is not finite; is one of them zero "
        "that "
        "must not be, or too large?");
}

/// Says which effects are on and what they make of the method; chooses it where the user has not.
template <int Dof>
void settle_method(const RuntimeScene<double, Dof>& scene, Method& method) {
  std::vector<std::string> coupled;
  for (const auto& effect : scene.effects())
    if (effect.coupled()) coupled.push_back(effect.name());
  if (method.name == "splitting" && !coupled.empty())
    throw std::invalid_argument("--method splitting is for separable effects, and q and p are coupled by " +
                                joined(coupled));
  if (method.name.empty()) method.name = coupled.empty() ? "splitting" : "semiexplicit";
  std::cout << "effects: " << joined(scene.names()) << '\n';
  if (!coupled.empty())
    std::cout << "coupled by " << joined(coupled) << ": not separable\n";
  else if (method.name == "splitting")
    std::cout << "separable: plain explicit splitting, no doubling\n";
  else
    std::cout << "separable, and taken as any other by " << method.name << '\n';
}

/// Reads the arguments, does what they ask for, and gives the exit code.
template <int Dof>
int run_scene_program(const SceneProgram<Dof>& program, int argc, char** argv) {
  CLI::App app{program.about};
  SceneRequest<Dof> request(program);
  Settings settings;
  Method method{.name = ""};
  CostRequest cost;
  request.add_to(app);
  if (program.add_options) program.add_options(app);
  std::vector<std::string> methods = Method::names();
  methods.insert(methods.begin(), "splitting");
  add_method(app, method, methods);
  app.get_option("--method")->default_str("splitting where the effects are separable, else semiexplicit");
  app.get_option("--scheme")->default_str("splitting: blanes_moan6, tao: yoshida6, else low_defect6_s13");
  add_output(app, settings);
  app.get_option("--samples")->default_str("the preset's");
  add_cost(app, cost);
  CheckpointRequest checkpoint;
  add_checkpoint(app, checkpoint);
  app.get_option("--audit")->excludes("--checkpoint");
  app.get_option("--audit")->excludes("--cost")->excludes("--accuracy");

  return run_program(app, argc, argv, [&] {
    if (request.list_presets) request.print_presets(std::cout);
    if (request.list_effects) request.print_effects(std::cout);
    if (request.list_presets || request.list_effects) return 0;

    const bool cost_wanted = cost.wanted(app);
    const auto& preset = request.preset();
    const Choice choice = request.choice();
    request.put_times_into(settings);
    if (app.count("--samples") == 0) settings.samples = preset.samples;
    const RuntimeScene<double, Dof> scene = request.scene(choice);
    const PhasePoint<double, Dof> z0 = preset.start(choice);
    request.refuse_idle_parameters(choice);
    refuse_start(scene, z0);
    Invariants<double, Dof> invariants(scene);
    if (program.add_invariants) program.add_invariants(invariants, choice);

    if (request.audit)
      refuse_options(app, "--audit",
                     {"--method", "--solver", "--rule", "--tolerance", "--omega", "--stages"});
    if (!cost_wanted) {
      const std::string usual = scene.is_separable() ? "splitting" : "semiexplicit";
      refuse_idle_options(app, {method.name.empty() ? usual : method.name});
    }
    std::cout << preset.name << ": " << preset.about << " (units: " << preset.units.about << ")\n";
    if (request.audit) {
      show_audit(scene, z0, invariants, settings, method, program.compare);
      return 0;
    }
    if (cost_wanted) {
      settings.make_output_folder();
      if (scene.is_separable())
        std::cout << "separable: plain splitting, which costs less still, is not among what --cost tries\n";
      const CostOfAccuracy found = cost_of_accuracy(scene, z0, settings.time, cost.options());
      if (cost.curve) {
        show_cost(found, settings, program.name + "_cost", program.name + ", " + preset.name);
        return 0;
      }
      cost.choose(found, method, settings);
    }
    settle_method(scene, method);
    const std::int64_t steps = settings.fit_steps();
    settings.make_output_folder();

    const std::filesystem::path csv = settings.output / (program.name + ".csv"),
                                path_csv = settings.output / (program.name + "_trajectory.csv"),
                                png = settings.output / (program.name + ".png");
    const View<Dof> view = program.view(choice);
    ViewCsv<Dof> path(path_csv, view);
    auto some_of_path = every(stride(steps, settings.samples), path);
    const Measurement<Dof> measurement = preset.measure ? preset.measure(choice) : Measurement<Dof>{};
    Measuring<Dof> observe{measurement};
    checkpoint.run << program.name << ' ' << preset.name << ": " << joined(scene.names());
    checkpoint.run.precision(17);
    for (const auto& [parameter, value] : choice.values) checkpoint.run << ", " << parameter << ' ' << value;
    checkpoint.run << "; " << steps << " steps, samples " << settings.samples;
    const auto go = [&](const auto& hamiltonian) {
      return run_method(method, hamiltonian, z0, invariants, settings.dt,
                        evenly_spaced(steps, settings.samples), steps, checkpoint, some_of_path, observe);
    };
    const Run run = method.name == "splitting" ? go(SeparableRuntimeScene<double, Dof>(scene)) : go(scene);

    print_table(std::cout, {run}, settings.dt);
    cost.compare_with(run);
    measurement.print(std::cout, run);
    path.commit();
    write_series(csv, {run});
    checkpoint.finish();
    std::cout << "data: " << csv.string() << ", " << path_csv.string() << '\n';
    const std::string headline = program.name + ", " + preset.name + ": " + joined(scene.names()) + "\n" +
                                 method.name + " (" + method.coefficients() +
                                 "), dt = " + formatted("%.4g", settings.dt) +
                                 "; units: " + preset.units.about + (run.is_result() ? "" : "; NO RESULT");
    if (!settings.no_plot)
      draw(png, scene_script(png, path_csv, csv, view, run, headline, settings.time, preset.units.name(1)));
    return tell_failure(run) ? 1 : 0;
  });
}

}  // namespace examples
