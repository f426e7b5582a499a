// A charge in magnetic and electric fields: gyration, a magnetic bottle, a proton in the Earth's dipole
// field.
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "charges/effects.hpp"
#include "charges/measurements.hpp"
#include "charges/view.hpp"
#include "common/scene_program.hpp"

namespace {

using namespace examples;
using State = PhasePoint<double, 3>;

State at(const Choice& c, const Eigen::Vector3d& q, const Eigen::Vector3d& v) {
  const FieldSum fields = fields_before(c, "");
  if (fields.empty() && !c.on("kinetic"))
    throw std::invalid_argument("--effects: nothing moves without kinetic or a magnetic field; add one");
  return {q, c["mass"] * v + c["charge"] * fields.potential(q)};
}

/// Turning about the third axis in the field b.
State about_the_axis(const Choice& c, double b) {
  const Velocity v(c);
  return at(c, {v.across * c["mass"] / (c["charge"] * b), 0, 0}, {0, -v.across, v.along});
}

/// A start whose speed Newton's equations are for.
template <class Start>
std::function<State(const Choice&)> slow(const UnitSystem& units, const Start& start) {
  const double light = units.size_of(known_units().at("c"));
  return [=](const Choice& c) -> State {
    const double beta = Velocity(c).all / light;
    if (!(beta < 0.3))
      throw std::invalid_argument("--energy: that is a speed of " + formatted("%.2g", beta) +
                                  " c, where Newton's equations are off by 5 % and more; take fast_charges");
    return start(c);
  };
}

std::vector<ScenePreset<3>> presets() {
  const double proton = known_units().at("mp").size, e = known_units().at("e").size;
  const UnitSystem metres{"m, s, proton mass, e", 1, 1, proton, e};
  const UnitSystem radii{"Earth radius, s, proton mass, e", known_units().at("Rearth").size, 1, proton, e};
  return {
      {.name = "gyration",
       .about = "a proton of 1 keV in a uniform field of 0.1 T",
       .units = metres,
       .effects = {"kinetic", "uniform_field"},
       .also = {"electric"},
       .values = {{"charge", "1 e"},
                  {"mass", "1 mp"},
                  {"energy", "1 keV"},
                  {"pitch", "80 deg"},
                  {"b", "0.1 T"},
                  {"ex", "10 V/m"},
                  {"ey", "0"},
                  {"ez", "0"}},
       .dt = "1e-8 s",
       .time = "1e-5 s",
       .start = slow(metres, [](const Choice& c) { return about_the_axis(c, c["b"]); }),
       .measure = slow_gyration},
      {.name = "bottle",
       .about = "a proton of 1 keV between magnetic mirrors, 1 T in the middle",
       .units = metres,
       .effects = {"kinetic", "magnetic_bottle"},
       .also = {"electric", "coulomb"},
       .values = {{"charge", "1 e"},
                  {"mass", "1 mp"},
                  {"energy", "1 keV"},
                  {"pitch", "60 deg"},
                  {"b0", "1 T"},
                  {"length", "1 m"},
                  {"ex", "10 V/m"},
                  {"ey", "0"},
                  {"ez", "0"},
                  {"centre", "1e-3 V m"}},
       .dt = "2e-9 s",
       .time = "1e-4 s",
       .samples = 10'000,
       .start = slow(metres, [](const Choice& c) { return about_the_axis(c, c["b0"]); }),
       .measure = mirrors},
      {.name = "dipole",
       .about = "a proton of 10 MeV trapped in the Earth's field, at four radii",
       .units = radii,
       .effects = {"kinetic", "dipole_field"},
       .also = {"electric", "gravity"},
       .values = {{"charge", "1 e"},
                  {"mass", "1 mp"},
                  {"energy", "10 MeV"},
                  {"pitch", "30 deg"},
                  {"r", "4 Rearth"},
                  {"moment", "-3.12e-5 T Rearth^3"},
                  {"b", "5e-9 T"},
                  {"ex", "0"},
                  {"ey", "2e-4 V/m"},
                  {"ez", "0"},
                  {"gm", "1 GMearth"}},
       .dt = "2e-3 s",
       .time = "80 s",
       .samples = 20'000,
       // The drift is along y, and is not to be part of the gyration: so that starts along x.
       .start = slow(radii,
                     [](const Choice& c) {
                       const Velocity v(c);
                       const double r = c["r"], b = -c["moment"] / (r * r * r);
                       return at(c, {r, v.across * c["mass"] / (c["charge"] * b), 0}, {v.across, 0, v.along});
                     }),
       .measure = bounce_and_drift}};
}

}  // namespace

int main(int argc, char** argv) {
  SceneProgram<3> program{.name = "charges", .about = "A charge in magnetic and electric fields."};
  program.joint = field_names;
  program.parameters = {
      {"charge", "C", "the charge", {"a number other than 0", [](double x) { return x != 0; }}},
      {"mass", "kg", "its mass", above_zero},
      {"energy", "J", "kinetic energy at the start", not_negative},
      {"pitch", "rad", "angle of the velocity to the field at the start, 0 to 180 degrees", half_turn},
      {"r", "m", "distance of the start from the dipole", above_zero},
      {"b", "T", "uniform magnetic field"},
      {"moment", "T m3", "magnetic moment times μ₀/(4π); the Earth's points down"},
      {"b0", "T", "field in the middle of the bottle"},
      {"length", "m", "where on its axis the bottle's field is doubled", above_zero},
      {"ex", "V/m", "uniform electric field, x"},
      {"ey", "V/m", "uniform electric field, y"},
      {"ez", "V/m", "uniform electric field, z"},
      {"centre", "V m", "the point charge, Q/(4πε₀); 1.44e-9 V m for a proton"},
      {"quadrupole", "V/m2", "strength of the electric quadrupole"},
      {"gm", "m3/s2", "GM of the point mass", above_zero}};
  program.effects = charge_effects();
  program.presets = presets();
  program.view = charge_view;
  return run_scene_program(program, argc, argv);
}
