// The orbit of one body about a centre, or two: Newton, relativity, oblateness, rotating frame, as the user chooses.
#include <cmath>
#include <map>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/scene_program.hpp"
#include "orbits/measurements.hpp"

namespace {

using namespace examples;
using State = PhasePoint<double, 3>;

using std::numbers::pi;

/// From the periapsis on the first axis, the plane tilted about that axis.
State at_periapsis(const Choice& c) {
  const double a = c["a"], e = c["e"], tilt = c["inclination"];
  if (!(0 <= e && e < 1)) throw std::invalid_argument("--e: a bound orbit has 0 <= e < 1");
  const double speed = std::sqrt(c["gm"] / a * (1 + e) / (1 - e));
  return {{a * (1 - e), 0, 0}, {0, speed * std::cos(tilt), speed * std::sin(tilt)}};
}

std::vector<ScenePreset<3>> presets() {
  return {
      {.name = "mercury",
       .about = "Mercury about the Sun, in the Sun's equator",
       .units = {"AU, year", 149597870700.0, 365.25 * 86400},
       .effects = {"kinetic", "attraction", "1pn"},
       .also = {"j2", "2pn", "spin_orbit"},
       .values = {{"gm", "1 GMsun"},
                  {"c", "1 c"},
                  {"nu", "0"},
                  {"j2", "2.2e-7"},
                  {"radius", "1 Rsun"},
                  {"gs", "1.28e31 m^5/s^3"},
                  {"a", "0.38709893 AU"},
                  {"e", "0.20563069"},
                  {"inclination", "0"}},
       .dt = "0.5 day",
       .time = "1 century",
       .samples = 20'000,
       .start = at_periapsis,
       .measure = perihelion,
       .figure = direction_of_perihelion},
      {.name = "arenstorf",
       .about = "Arenstorf's orbit about Earth and Moon, in the frame that turns with them",
       .units = {"Earth-Moon distance, month/(2 pi)", 3.84400e8, 27.321661 * 86400 / (2 * pi)},
       .effects = {"kinetic", "two_centres", "rotating_frame"},
       .values = {{"mu", "0.012277471"},
                  {"frame-rate", "1"},
                  {"x", "0.994"},
                  {"vy", "-2.00158510637908252240537862224"}},
       .dt = "0.0004",
       .time = formatted("%.17g", arenstorf_period),
       .start =
           [](const Choice& c) {  // p = v + omega x q
             return State({c["x"], 0, 0},
                          {0, c["vy"] + (c.on("rotating_frame") ? c["frame-rate"] * c["x"] : 0), 0});
           },
       .measure = closure},
      {.name = "gps",
       .about = "a satellite like those of GPS about the oblate Earth",
       .units = {"km, s", 1000, 1},
       .effects = {"kinetic", "attraction", "j2"},
       .also = {"1pn", "spin_orbit"},
       .values = {{"gm", "1 GMearth"},
                  {"j2", "1.08262668e-3"},
                  {"radius", "1 Rearth"},
                  {"c", "1 c"},
                  {"nu", "0"},
                  {"gs", "3.9e23 m^5/s^3"},
                  {"a", "26559.7 km"},
                  {"e", "0"},
                  {"inclination", "55 deg"}},
       .dt = "10 min",
       .time = "30 day",
       .samples = 5000,
       .start = at_periapsis,
       .measure = node},
  };
}

}  // namespace

int main(int argc, char** argv) {
  using namespace orbits;
  SceneProgram<3> program{.name = "orbits", .about = "The orbit of one body about a centre or two."};
  program.parameters = {{"gm", "m3/s2", "GM of the centre", above_zero},
                        {"mu",
                         "",
                         "mass of the second centre, of both together",
                         {"a number from 0 to 1", [](double x) { return 0 <= x && x <= 1; }}},
                        {"j2", "", "J2 of the centre"},
                        {"radius", "m", "equatorial radius of the centre", above_zero},
                        {"frame-rate", "1/s", "radians by which the frame turns in a unit of time"},
                        {"c", "m/s", "speed of light", above_zero},
                        {"nu",
                         "",
                         "symmetric mass ratio, 0 to 1/4",
                         {"a number from 0 to 1/4", [](double x) { return 0 <= x && x <= 0.25; }}},
                        {"gs", "m5/s3", "G times the spin of the centre"},
                        {"a", "m", "semi-major axis", above_zero},
                        {"e", "", "eccentricity"},
                        {"inclination", "rad", "of the orbit to the equator, 0 to 180 degrees", half_turn},
                        {"x", "m", "where arenstorf starts, on the axis of the centres"},
                        {"vy", "m/s", "how fast, across it"}};
  const std::string djs = "Damour, Jaranowski, Schaefer, Phys. Rev. D 62 (2000) 044024";
  program.effects = {
      {{}, "", [](const Choice&) { return Kinetic<double, 3>{}; }},
      {{"gm"}, "", [](const Choice& c) { return Attraction<double, 3>{.gm = c["gm"]}; }},
      {{"mu"},
       "Szebehely, Theory of Orbits (1967)",
       [](const Choice& c) { return TwoCentres<double, 3>::restricted(c["mu"]); }},
      {{"gm", "j2", "radius"},
       "Vallado, Fundamentals of Astrodynamics, 4th ed.",
       [](const Choice& c) {
         return Oblateness<double, 3>{.gm = c["gm"], .j2 = c["j2"], .radius = c["radius"]};
       }},
      {{"frame-rate"},
       "Arnold, Mathematical Methods of Classical Mechanics",
       [](const Choice& c) { return RotatingFrame<double, 3>{.omega = c["frame-rate"]}; }},
      {{"gm", "c", "nu"},
       djs,
       [](const Choice& c) { return PostNewtonian1<double, 3>{.gm = c["gm"], .c = c["c"], .nu = c["nu"]}; }},
      {{"gm", "c", "nu"},
       djs,
       [](const Choice& c) { return PostNewtonian2<double, 3>{.gm = c["gm"], .c = c["c"], .nu = c["nu"]}; }},
      {{"gs", "c"}, "Lense, Thirring (1918)", [](const Choice& c) {
         return SpinOrbit<double, 3>{.gs = c["gs"], .c = c["c"]};
       }}};
  program.presets = presets();
  program.add_invariants = [](auto& invariants, const Choice& c) {
    if (!c.on("two_centres"))
      invariants.add("angular_momentum",
                     [](const auto& q, const auto& p) { return q[0] * p[1] - q[1] * p[0]; });
  };
  program.view = [](const Choice& c) {
    std::vector<std::pair<double, double>> centres{{0, 0}};
    if (c.on("two_centres")) centres = {{-c["mu"], 0}, {1 - c["mu"], 0}};
    return path_view<3>({"t", "x", "y", "z", "px", "py", "pz"}, "x", "y", c.units.name(0), centres);
  };
  return run_scene_program(program, argc, argv);
}
