#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <memory>
#include <ostream>
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
#include "prepare_outputs.hpp"
#include "results.hpp"
#include "run.hpp"
#include "scene_choice.hpp"
#include "scene_picture.hpp"
#include "scene_request.hpp"

// A program whose user chooses the effects. It says what there is, as data, and the rest is done here:
//
//     SceneProgram<3> program{.name = "orbits", .about = "An orbit."};
//     program.parameters = {{"gm", "m3/s2", "GM of the centre"}, {"a", "m", "semi-major axis"}};
//     program.effects = {{{}, "", [](const Choice&) { return orbits::Kinetic<double, 3>{}; }},
//                        {{"gm"}, "Newton",
//                         [](const Choice& c) { return orbits::Attraction<double, 3>{.gm = c["gm"]}; }}};
//     program.presets = {{.name = "earth", .about = "the Earth about the Sun",
//                         .units = {"AU, year", 149597870700.0, 31557600.0},
//                         .effects = {"kinetic", "attraction"},
//                         .values = {{"gm", "1 GMsun"}, {"a", "1"}}, .dt = "2 day", .time = "1 century",
//                         .start = [](const Choice& c) { return PhasePoint<double, 3>(...); }}};
//     program.view = [](const Choice&) {
//       return path_view<3>({"t", "x", "y", "z", "px", "py", "pz"}, "x", "y", "AU");
//     };
//     return run_scene_program(program, argc, argv);
//
// Options of its own (a file to read, say) it adds by `program.add_options`; the functions above are called
// after the arguments are read, and may refer to what these wrote. No parameter has the name of a common
// option (dt, time, omega, ...).
namespace examples {

/// The table of the audit, and what it means at some accuracies.
template <int Dof>
void show_audit(const RuntimeScene<double, Dof>& scene, const PhasePoint<double, Dof>& z0,
                const Invariants<double, Dof>& invariants, const Settings& settings, const Method& method,
                AuditOptions<double, Dof> options) {
  options.dt = settings.dt;
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
      std::cout << " (below the numerical error: " << joined(open)
                << "; take a smaller --dt, or a shorter --time if that does not help: the orbits part)";
    std::cout << '\n';
  }
}

/// A start that is not finite, or where the energy is not.
template <int Dof>
void refuse_start(const RuntimeScene<double, Dof>& scene, const PhasePoint<double, Dof>& z0,
                  const std::string& suspects) {
  if (!z0.vector().allFinite() || !std::isfinite(scene.energy(z0.q(), z0.p())))
    throw std::invalid_argument(
        "these values make no start: its position, momentum or energy is not finite; " + suspects);
}

/// The effects with forces of their own; empty where there are none.
template <int Dof>
std::string working_forces(const RuntimeScene<double, Dof>& scene) {
  std::vector<std::string> names;
  for (const auto& effect : scene.effects())
    if (effect.motion()) names.push_back(effect.name());
  return joined(names);
}

/// Says which effects are on and what they make of the method; chooses it where the user has not.
template <int Dof>
void settle_method(const RuntimeScene<double, Dof>& scene, Method& method) {
  std::vector<std::string> names;
  for (const auto& effect : scene.effects())
    if (effect.coupled()) names.push_back(effect.name());
  const std::string coupled = joined(names);
  if (method.name == "splitting" && !names.empty())
    throw std::invalid_argument("--method splitting is for separable effects, and q and p are coupled by " +
                                coupled);
  if (method.name.empty()) method.name = names.empty() ? "splitting" : "semiexplicit";
  std::cout << "effects: " << joined(scene.names()) << '\n'
            << (!names.empty()               ? "coupled by " + coupled + ": not separable"
                : method.name == "splitting" ? "separable: plain explicit splitting, no doubling"
                                             : "separable, and taken as any other by " + method.name)
            << '\n';
  if (const std::string forces = working_forces(scene); !forces.empty())
    std::cout << "not symplectic, by " << forces
              << ": the energy changes by the work of these forces, see the books at the end\n";
}

/// A measurement, and the books of a scene with forces of their own.
template <int Dof>
Measurement<Dof> with_books(const RuntimeScene<double, Dof>& scene, const Measurement<Dof>& measurement) {
  const auto books = std::make_shared<Books<double, Dof>>(scene);
  return {[=](double t, const In<double, Dof>& q, const In<double, Dof>& p) {
            (*books)(t, PhasePoint<double, Dof>(q, p));
            if (measurement.observe) measurement.observe(t, q, p);
          },
          [=](CheckpointMemory& visit) {
            books->visit_memory(visit);
            if (measurement.memory) measurement.memory(visit);
          },
          measurement.figures,
          [=](std::ostream& out, const Run& run) {
            out << *books;
            measurement.tell(out, run);
          },
          {},
          measurement.ending,
          [=]() -> std::string {
            const double first = std::abs(books->energy_at_start()), now = std::abs(books->energy_now()),
                         off = std::abs(books->difference());
            if (off <= std::max(first / 2, (first + now) / 100)) return "";
            return "the books do not close, they are off by more than half of the energy at the start: the "
                   "result means nothing; give a smaller --dt, or another method";
          }};
}

/// What an accuracy with a unit asks for; nothing where there is none. Throws std::invalid_argument where the
/// preset measures no such figure.
template <int Dof>
AngleTarget angle_of(const CostRequest& cost, const ScenePreset<Dof>& preset, const Choice& choice,
                     double time) {
  if (cost.unit.empty()) return {};
  if (!preset.figure)
    throw std::invalid_argument("--accuracy: the preset " + preset.name +
                                " measures no angle; give a relative energy error, as 1e-9");
  const TurningFigure<Dof> figure = preset.figure(choice);
  const double per = read_quantity(figure.per, "s", preset.units, true);
  return {figure.direction, cost.accuracy * read_unit(cost.unit).size * time / per, figure.longest_dt,
          figure.name, figure.unit};
}

/// What is to be run, whatever the Hamiltonian.
template <int Dof>
struct SceneRun {
  const Method& method;
  const PhasePoint<double, Dof>& start;
  const Invariants<double, Dof>& invariants;
  double dt;
  std::int64_t steps;
  const Rows& rows;
  const CheckpointRequest& checkpoint;
  ViewCsv<Dof>& path;
  const Measurement<Dof>& of_companion;
};

/// What takes a compiler long for every Hamiltonian.
template <class H>
struct OnHamiltonian {
  static constexpr int Dof = H::Dof;
  static Run run(const H& hamiltonian, const SceneRun<Dof>& what, Measurement<Dof>& measurement);
  static bool answer(const H& hamiltonian, const PhasePoint<double, Dof>& start, CostRequest& cost,
                     Method& method, Settings& settings, const std::string& program,
                     const std::string& preset, const AngleTarget& angle);
};
template <class H>
Run OnHamiltonian<H>::run(const H& hamiltonian, const SceneRun<Dof>& what, Measurement<Dof>& measurement) {
  return run_method(what.method, hamiltonian, what.start, what.invariants, what.dt, what.rows, what.steps,
                    what.checkpoint, FigureErrors<Dof>(measurement, what.of_companion), what.path,
                    measurement);
}
template <class H>
bool OnHamiltonian<H>::answer(const H& hamiltonian, const PhasePoint<double, Dof>& start, CostRequest& cost,
                              Method& method, Settings& settings, const std::string& program,
                              const std::string& preset, const AngleTarget& angle) {
  return cost.answer(hamiltonian, start, method, settings, program + "_cost", program + ", " + preset, angle);
}

// Scenes of sizes that several programs have: compiled once for all, in scene_runs.cpp.
extern template struct OnHamiltonian<RuntimeScene<double, 3>>;
extern template struct OnHamiltonian<SeparableRuntimeScene<double, 3>>;
extern template struct OnHamiltonian<RuntimeScene<double, Eigen::Dynamic>>;
extern template struct OnHamiltonian<SeparableRuntimeScene<double, Eigen::Dynamic>>;

/// No Hamiltonian of a program's own.
struct NoKernel {
  NoKernel operator()(const Choice&) const { return {}; }
};

/// Reads the arguments, does what they ask for, and gives the exit code. A program may know a faster
/// Hamiltonian than its scene for some choices: kernel(choice) gives it, as a std::optional, and is taken
/// where there is one.
template <int Dof, class Kernel = NoKernel>
int run_scene_program(const SceneProgram<Dof>& program, int argc, char** argv, const Kernel& kernel = {}) {
  CLI::App app{program.about};
  SceneRequest<Dof> request(program);
  Settings settings;
  Method method{.name = ""};
  CostRequest cost;
  CheckpointRequest checkpoint;
  request.add_to(app);
  if (program.add_options) program.add_options(app);
  std::vector<std::string> methods = Method::names();
  methods.push_back("splitting");
  add_method(app, method, methods);
  app.get_option("--method")->default_str("splitting where the effects are separable, else semiexplicit");
  app.get_option("--scheme")->default_str("splitting: blanes_moan6, tao: yoshida6, else low_defect6_s13");
  add_output(app, settings);
  app.get_option("--samples")->default_str("the preset's");
  cost.add_to(app, std::any_of(program.presets.begin(), program.presets.end(),
                               [](const auto& preset) { return bool(preset.figure); }));
  checkpoint.add_to(app);
  app.get_option("--audit")->excludes("--checkpoint")->excludes("--cost")->excludes("--accuracy");

  return run_program(app, argc, argv, [&] {
    if (request.list(std::cout)) return 0;
    if (program.prepare) request.preset_name = program.prepare(request.preset_name);
    const bool cost_wanted = cost.wanted(app);
    const auto& preset = request.preset();
    const Choice choice = request.choice();
    request.put_times_into(settings);
    if (cost_wanted)
      settings.dt = std::min(settings.dt, settings.time);
    else
      settings.fit_steps();
    if (app.count("--samples") == 0) settings.samples = preset.samples;
    const RuntimeScene<double, Dof> scene = request.scene(choice);
    const PhasePoint<double, Dof> z0 = preset.start(choice);
    const auto own = kernel(choice);
    const auto with_hamiltonian = [&](const auto& use) {
      if constexpr (requires { *own; })
        if (own) return use(*own);
      return use(scene);
    };
    Invariants<double, Dof> invariants =
        with_hamiltonian([](const auto& h) { return Invariants<double, Dof>(h); });
    if (program.add_invariants) program.add_invariants(invariants, choice);
    request.refuse_idle_parameters(choice);
    refuse_start(scene, z0, request.suspects(choice));

    if (request.audit)
      refuse_options(app, "--audit",
                     {"--method", "--solver", "--rule", "--tolerance", "--omega", "--stages", "--samples",
                      "--output", "--no-plot"});
    const std::string usual = scene.is_separable() ? "splitting" : "semiexplicit";
    if (cost_wanted && !scene.is_symplectic())
      throw std::invalid_argument(std::string(cost.curve ? "--cost" : "--accuracy") +
                                  " is about Hamiltonian systems, and the energy changes by the work of " +
                                  working_forces(scene) +
                                  "; give --dt and look at the figures' errors, or leave that effect out");
    if (!cost_wanted) refuse_idle_options(app, {method.name.empty() ? usual : method.name});
    std::cout << preset.name << (choice.is_preset ? ": " : ", changed by options: ") << preset.about
              << " (units: " << preset.units.about << ")\n";
    if (request.audit) {
      const auto without = [&](const std::string& name) {
        const auto& joint = program.joint;
        if (std::find(joint.begin(), joint.end(), name) == joint.end()) return scene.without(name);
        Choice others = choice;
        std::erase(others.effects, name);
        return request.scene(others);
      };
      show_audit(scene, z0, invariants, settings, method, {.compare = program.compare, .without = without});
      if (!program.joint.empty() && !choice.on("kinetic"))
        std::cout << "the motion itself is that in a field, as kinetic is not on: one field at least stays\n";
      return 0;
    }
    if (cost_wanted) {
      const auto angle = angle_of(cost, preset, choice, settings.time);
      const auto answer = [&]<class H>(const H& h) {
        return OnHamiltonian<H>::answer(h, z0, cost, method, settings, program.name, preset.name, angle);
      };
      if (scene.is_separable() ? answer(SeparableRuntimeScene<double, Dof>(scene)) : with_hamiltonian(answer))
        return 0;
    }
    settle_method(scene, method);
    const std::int64_t steps = settings.fit_steps();
    const std::filesystem::path csv = settings.output / (program.name + ".csv"),
                                path_csv = settings.output / (program.name + "_trajectory.csv"),
                                png = settings.output / (program.name + ".png");
    prepare_outputs(settings, {csv, path_csv, png}, checkpoint.file);
    const View<Dof> view = program.view(choice);
    const Rows rows = evenly_spaced(steps, settings.samples);
    ViewCsv<Dof> path(path_csv, view, rows, settings.dt);
    Measurement<Dof> measurement, of_companion;
    if (preset.measure) {
      measurement = preset.measure(choice);
      of_companion = preset.measure(choice);
    }
    if (!scene.is_symplectic()) measurement = with_books(scene, measurement);
    checkpoint.run << program.name << ' ' << preset.name << ": " << joined(scene.names());
    checkpoint.run.precision(17);
    for (const auto& [parameter, value] : choice.values) checkpoint.run << ", " << parameter << ' ' << value;
    // What no parameter tells, as the circulations of a file: the state is the same in a mirror image.
    std::vector<double> shown;
    std::vector<Path> paths(view.paths);
    view.append(z0.q(), z0.p(), shown, paths);
    checkpoint.run << "; " << steps << " steps, samples " << settings.samples;
    for (std::size_t i = 0; i < shown.size(); ++i)
      checkpoint.run << ", from " << view.columns[i + 1] << ' ' << shown[i];
    const SceneRun<Dof> what{method, z0,         invariants, settings.dt, steps,
                             rows,   checkpoint, path,       of_companion};
    const auto go = [&]<class H>(const H& hamiltonian) {
      return OnHamiltonian<H>::run(hamiltonian, what, measurement);
    };
    Run run =
        method.name == "splitting" ? go(SeparableRuntimeScene<double, Dof>(scene)) : with_hamiltonian(go);

    // Where the energy is meant to change its books are to close.
    if (!scene.is_symplectic() && !run.doubt.empty()) run.doubt = measurement.doubt();
    measurement.explain(run);
    print_table(std::cout, {run}, settings.dt);
    measurement.print(std::cout, run);
    const std::string complaint = cost.compare_with(run);
    path.commit();
    write_series(csv, {run});
    std::cout << "data: " << csv.string() << ", " << path_csv.string() << '\n';
    const std::string headline = program.name + ", " + preset.name + ": " + joined(scene.names()) + "\n" +
                                 method.name + " (" + method.coefficients() +
                                 "), dt = " + formatted("%.4g", settings.dt) +
                                 "; units: " + preset.units.about + (run.is_result() ? "" : "; NO RESULT");
    if (!settings.no_plot)
      draw(png,
           scene_script(png, view.plot(path_csv, path.paths()), csv, run, headline, settings.time,
                        preset.units.name(1), scene.is_symplectic() ? "relative error" : "relative change"),
           {csv, path_csv});
    checkpoint.finish();
    if (!complaint.empty()) throw std::runtime_error(complaint);
    return run.tell_failure() ? 1 : 0;
  });
}

}  // namespace examples
