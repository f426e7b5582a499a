#include <cmath>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/arguments.hpp"
#include "common/scene_request.hpp"
#include "fuzz.hpp"

namespace {

using namespace examples;

/// A program with a parameter of every kind.
const SceneProgram<2>& program() {
  static const SceneProgram<2> program = [] {
    SceneProgram<2> made{.name = "fuzzed", .about = "Two effects."};
    made.parameters = {{"k", "", "a number"},
                       {"v", "m/s", "a velocity"},
                       {"b", "T", "a magnetic field"},
                       {"gm", "m3/s2", "a GM"}};
    made.effects = {
        {{"k"}, "", [](const Choice&) { return orbits::Kinetic<double, 2>{}; }},
        {{"gm"}, "", [](const Choice& c) { return orbits::Attraction<double, 2>{.gm = c["gm"]}; }}};
    ScenePreset<2> first{.name = "first",
                         .about = "in units",
                         .units = {"AU, year", 149597870700.0, 31557600.0},
                         .effects = {"kinetic", "attraction"},
                         .values = {{"gm", "1 GMsun"}, {"v", "1 km/s"}},
                         .dt = "2 day",
                         .time = "1 century",
                         .start = {}};
    ScenePreset<2> second = first;
    second.name = "second";
    second.units = {"numbers"};
    second.values = {{"gm", "1"}};
    second.dt = "0.1";
    second.time = "10";
    made.presets = {first, second};
    return made;
  }();
  return program;
}

/// Hands the options of a program to parse(app), and looks at what has come of them: refused in one line, or
/// options that mean something.
template <class Parse>
void put_options(const Parse& parse) {
  const auto one_line = [](const std::string& what) {
    promise(!what.empty(), "a refusal says something");
    return what;
  };
  CLI::App app("fuzzed");
  SceneRequest<2> request(program());
  Settings settings;
  Method method{.name = ""};
  request.add_to(app);
  std::vector<std::string> methods = Method::names();
  methods.push_back("splitting");
  add_method(app, method, methods);
  add_output(app, settings);
  try {
    parse(app);
    const Choice choice = request.choice();
    for (const auto& [name, value] : choice.values) promise(std::isfinite(value), "a parameter is a number");
    request.put_times_into(settings);
    promise(settings.dt > 0 && std::isfinite(settings.dt) && settings.time > 0 && settings.fit_steps() > 0,
            "there are steps to take");
    promise(settings.samples > 0, "there are rows to write");
    promise(method.omega - method.omega == 0 && method.stages >= 1 && method.stages <= 8,
            "the method's options are in range");
    promise(!request.scene(choice).effects().empty(), "there are effects");
  } catch (const CLI::Success&) {
  } catch (const CLI::ParseError& refusal) {
    one_line(refusal.what());
  } catch (const std::invalid_argument& refusal) {
    one_line(refusal.what());
  }
}

}  // namespace

// A command line, an argument a line; each is also read as a number with a unit.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::istringstream in(std::string(reinterpret_cast<const char*>(data), size));
  std::vector<std::string> arguments;
  for (std::string line; std::getline(in, line);) arguments.push_back(line);
  const char* const wanted[] = {"m/s", "T", ""};
  for (std::size_t i = 0; i < arguments.size(); ++i) try {
      const bool positive = i % 2 == 0;
      const double value =
          examples::read_quantity(arguments[i], wanted[i % 3], program().presets[i / 3 % 2].units, positive);
      promise(std::isfinite(value) && (!positive || value > 0), "a quantity is a number");
    } catch (const std::invalid_argument& refusal) {
      promise(refusal.what()[0] != 0, "a refusal says something");
    }
  // No files: neither --config nor --checkpoint.
  std::erase_if(arguments, [](const std::string& a) { return a.starts_with("--c"); });
  put_options([&](CLI::App& app) {
    app.parse(std::vector<std::string>(arguments.rbegin(), arguments.rend()));  // CLI11 wants the last first
  });
  return 0;
}
