#pragma once

#include <cmath>
#include <cstdint>
#include <sstream>
#include <string>

#include <CLI/CLI.hpp>

#include "../common/arguments.hpp"
#include "../common/cost.hpp"
#include "../common/method.hpp"
#include "../common/run.hpp"

namespace examples {

/// What the user wants; lengths and times in units of the hole's mass, G = c = 1.
struct Request {
  std::string metric = "ernst";
  double field = 0.1, spin = 0.9, energy = 1.36, l = 6;
  std::int64_t orbits = 20, crossings = 500;
  Settings settings{.dt = 2};
  Method method{};
  CostRequest cost{};
  CheckpointRequest checkpoint{};

  /// All that the orbits depend on.
  std::string in_words() const {
    std::ostringstream out;
    out.precision(17);
    out << "section of geodesics of " << metric << ", field " << field << ", spin " << spin << ", energy "
        << energy << ", angular momentum " << l << ", orbits " << orbits << ", crossings " << crossings
        << ", dt " << settings.dt << ", " << method.name << ' ' << method.scheme_name() << ' '
        << method.solver << ' ' << method.rule << ' ' << method.tolerance.value_or(0);
    return out.str();
  }

  void add_to(CLI::App& app) {
    cost.with_gauss = false;  // the alignment index goes along projected steps only
    add_value(app, "--metric", metric,
              "ernst (a black hole in a magnetic field) or kerr; units G = c = M = 1",
              one_of({"ernst", "kerr"}), "NAME");
    add_value(app, "--field", field, "magnetic field B of ernst, 1/M; 0: Schwarzschild",
              number<double>("a number from 0 on", [](double x) { return x >= 0; }));
    add_value(app, "--spin", spin, "spin a/M of kerr",
              number<double>("a number between -1 and 1", [](double x) { return std::abs(x) < 1; }));
    add_value(app, "--energy", energy, "E per rest mass", positive());
    add_value(app, "--angular-momentum", l, "L per rest mass and M",
              number<double>("a number", [](double x) { return std::isfinite(x); }));
    add_value(app, "--orbits", orbits, "which start at rest in r, from within outwards",
              whole_number(1, 10'000), "N");
    add_value(app, "--crossings", crossings, "of the equator, for each of them", whole_number(1, 1'000'000),
              "N");
    add_value(app, "--dt", settings.dt, "step of proper time, in M", positive());
    add_method(app, method, {"semiexplicit", "midpoint"});
    add_output(app, settings, false);
    cost.add_to(app);
    checkpoint.add_file(app,
                        "orbits that are finished are kept in a folder of this name and a number; where "
                        "it is there and fits, the section goes on from it");
  }

  /// Refuses what the method or the metric has no use for.
  void refuse_idle(const CLI::App& app) const {
    refuse_idle_options(app, {method.name});
    refuse_options(app, metric, {metric == "kerr" ? "--field" : "--spin"});
  }
};

}  // namespace examples
