// A body on a bound geodesic about a black hole, Schwarzschild's or Kerr's, in units of its mass (c = G = 1).
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "black_hole/measurements.hpp"
#include "common/scene_program.hpp"

namespace {

using namespace examples;
using State = PhasePoint<double, 4>;
using Half = In<double, 4>;
using black_hole::Kerr;
using black_hole::Schwarzschild;

using std::numbers::pi;

Kerr<> hole(const Choice& c) {
  const Kerr<> hole{.mass = c["mass"], .spin = c.on("kerr") ? c["spin"] : 0};
  if (!(hole.mass > 0) || !(std::abs(hole.spin) < hole.mass))
    throw std::invalid_argument("--mass is to be positive and --spin smaller than it, in either sense");
  return hole;
}

/// A body at a turning point of r on the equator: the apoapsis, where no more is said.
State at_turning_point(const Choice& c) {
  const double r = c["r"], carter = c["carter"];
  const State z = hole(c).body(r, pi / 2, 0, std::sqrt(carter), c["l"]);
  if (!(carter >= 0) || !z.vector().allFinite())
    throw std::invalid_argument(
        "there is no such body: --r has to be outside of the horizon and --carter not negative");
  return z;
}

/// From the apoapsis of an orbit in the equator of semi-latus rectum p and eccentricity e, p > 6 + 2e:
/// Chandrasekhar, section 19.
State at_apoapsis(const Choice& c) {
  const double mass = c["mass"], p = c["p"], e = c["e"];
  if (!(0 <= e && e < 1) || !(p > 6 + 2 * e))
    throw std::invalid_argument("a bound orbit has 0 <= --e < 1 and --p > 6 + 2e");
  return hole(c).body(p * mass / (1 - e), pi / 2, 0, 0, p * mass / std::sqrt(p - 3 - e * e));
}

Measurement<4> follow(const Choice& c) {
  std::optional<Ellipse> known;
  if (c.on("schwarzschild") && c.has("p")) known = {c["p"], c["e"]};
  return apoapsides(hole(c), known);
}

/// All in units of M.
ScenePreset<4> preset(const std::string& name, const std::string& about, const std::string& effect,
                      std::map<std::string, std::string> values, const std::string& dt,
                      const std::string& time) {
  const auto start = values.count("r") > 0 ? at_turning_point : at_apoapsis;
  return {.name = name,
          .about = about,
          .units = {.about = "mass of the hole"},
          .effects = {effect},
          .values = std::move(values),
          .dt = dt,
          .time = time,
          .samples = 20'000,
          .start = start,
          .measure = follow};
}

}  // namespace

int main(int argc, char** argv) {
  SceneProgram<4> program{.name = "black_hole",
                          .about = "A body on a geodesic about a black hole; proper time.",
                          .one_effect = true};
  program.parameters = {
      {"mass", "", "of the hole: the unit of length and time, where it is 1", above_zero},
      {"spin", "", "of the hole, below its mass; negative: the body goes against it"},
      {"p", "", "of schwarzschild: semi-latus rectum in masses of the hole", above_zero},
      {"e", "", "of schwarzschild: eccentricity"},
      {"r", "", "of kerr and zoom_whirl: where the body starts, at a turning point of r", above_zero},
      {"l", "", "of kerr and zoom_whirl: axial angular momentum"},
      {"carter", "", "of kerr and zoom_whirl: Carter's constant, 0 in the equator", not_negative}};
  program.effects = {
      {{"mass"},
       "Chandrasekhar, The Mathematical Theory of Black Holes (1983)",
       [](const Choice& c) { return Schwarzschild<>{.mass = hole(c).mass}; }},
      {{"mass", "spin"}, "Carter, Phys. Rev. 174 (1968) 1559", [](const Choice& c) { return hole(c); }}};
  program.presets = {
      preset("schwarzschild", "zoom and whirl close to the unstable orbits", "schwarzschild",
             {{"mass", "1"}, {"p", "7.25"}, {"e", "0.6"}}, "0.25", "4000"),
      preset("kerr", "an orbit far off the equator of a fast hole", "kerr",
             {{"mass", "1"}, {"spin", "0.9"}, {"r", "10"}, {"l", "2"}, {"carter", "5"}}, "0.5", "2500"),
      preset("zoom_whirl", "an orbit in the equator of a fast hole that whirls before it zooms out", "kerr",
             {{"mass", "1"}, {"spin", "0.9"}, {"r", "20"}, {"l", "2.5"}, {"carter", "0"}}, "0.05", "2000")};
  program.add_invariants = [](auto& invariants, const Choice& c) {
    invariants.add("E", [](const auto&, const auto& p) { return p[0]; });
    invariants.add("L", [](const auto&, const auto& p) { return p[3]; });
    if (c.has("carter") && c["carter"] > 0)  // it is zero in the equator
      invariants.add("carter", [kerr = hole(c)](const auto& q, const auto& p) { return kerr.carter(q, p); });
  };
  program.view = [](const Choice& c) {
    const double spin2 = std::pow(hole(c).spin, 2);
    const double horizon = std::sqrt(2 * hole(c).mass * outer_horizon(hole(c)));
    View<4> view;
    view.columns = {"t",   "coordinate_t", "r",     "theta", "phi", "p_t",
                    "p_r", "p_theta",      "p_phi", "x",     "y",   "z"};
    view.append = [=](const Half& q, const Half& p, auto& row, auto& paths) {
      row.insert(row.end(), q.begin(), q.end());
      row.insert(row.end(), p.begin(), p.end());
      const double rho = std::sqrt(q[1] * q[1] + spin2) * std::sin(q[2]);
      row.insert(row.end(), {rho * std::cos(q[3]), rho * std::sin(q[3]), q[1] * std::cos(q[2])});
      paths[0].see(row[9], row[10]);
    };
    view.plot = [=](const auto& csv, const auto& paths) {
      return "set object 1 circle at 0,0 size " + formatted("%.9g", horizon) +
             " fillcolor rgb 'black' fillstyle solid\n" +
             path_plot(csv, 10, 11, in("x", c.units.name(0)), in("y", c.units.name(0)), paths[0]);
    };
    return view;
  };
  return run_scene_program(program, argc, argv);
}
