// The orbit of one body about a centre, or two: Newton, relativity, oblateness, rotating frame, as the user chooses.
#include <string>
#include <utility>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/scene_program.hpp"
#include "orbits/presets.hpp"

int main(int argc, char** argv) {
  using namespace examples;
  using namespace orbits;
  SceneProgram<3> program{.name = "orbits", .about = "The orbit of one body about a centre or two."};
  program.parameters = {
      {"gm", "m3/s2", "GM of the centre", above_zero},
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
      {"drag", "1/m", "half the drag coefficient times area times density over mass", not_negative},
      {"air-height", "m", "scale height of the air, above the radius", above_zero},
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
      {{"gm", "c", "nu"},
       "Damour, Deruelle, Phys. Lett. A 87 (1981) 81; Peters, Phys. Rev. 136 (1964) B1224",
       [](const Choice& c) {
         return RadiationReaction<double, 3>{.gm = c["gm"], .c = c["c"], .nu = c["nu"]};
       }},
      {{"drag", "air-height", "radius"},
       "King-Hele, Theory of Satellite Orbits in an Atmosphere (1987)",
       [](const Choice& c) {
         return Drag<double, 3>{.quadratic = c["drag"], .height = c["air-height"], .radius = c["radius"]};
       }},
      {{"gs", "c"}, "Lense, Thirring (1918)", [](const Choice& c) {
         return SpinOrbit<double, 3>{.gs = c["gs"], .c = c["c"]};
       }}};
  program.presets = orbit_presets();
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
