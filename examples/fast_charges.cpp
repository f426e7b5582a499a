// A charge at nearly the speed of light: gyration, an undulator, a solenoid, a quadrupole, a cosmic ray in
// the Earth's field.
#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "common/scene_program.hpp"
#include "fast_charges/effects.hpp"
#include "fast_charges/measurements.hpp"
#include "fast_charges/view.hpp"

namespace {

using namespace examples;
using State = PhasePoint<double, 3>;

/// At q with the momentum γmv along a direction.
State at(const Choice& c, const Eigen::Vector3d& q, const Eigen::Vector3d& direction) {
  const charges::FieldSum fields = fast_fields(c, "");
  if (fields.empty() && !c.on("kinetic"))
    throw std::invalid_argument("--effects: nothing moves without kinetic or a magnetic field; add one");
  return {q, fast_motion(c, fields).momentum(q, momentum_of(c) * direction)};
}
State along_z(const Choice& c) {
  State z = at(c, {c["x"], c["y"], c["z"]}, {0, 0, 1});
  if (c.on("solenoid")) z.p().head<2>().setZero();  // without angular momentum, as from far away
  return z;
}

std::vector<ScenePreset<3>> presets() {
  const double electron = known_units().at("me").size, proton = known_units().at("mp").size;
  const double e = known_units().at("e").size;
  const UnitSystem metres{"m, s, electron mass, e", 1, 1, electron, e};
  const UnitSystem radii{"Earth radius, s, proton mass, e", known_units().at("Rearth").size, 1, proton, e};
  const auto preset = [&](const std::string& name, const std::string& about, const std::string& field,
                          std::map<std::string, std::string> values, const std::string& dt,
                          const std::string& time, Measurement<3> (*measure)(const Choice&)) {
    values.insert(
        {{"charge", "-1 e"}, {"mass", "1 me"}, {"c", "1 c"}, {"ex", "0"}, {"ey", "1e5 V/m"}, {"ez", "0"}});
    if (name == "cosmic_ray") values["charge"] = "1 e", values["mass"] = "1 mp";
    return ScenePreset<3>{.name = name,
                          .about = about,
                          .units = name == "cosmic_ray" ? radii : metres,
                          .effects = {"kinetic", field},
                          .also = {"electric"},
                          .values = values,
                          .dt = dt,
                          .time = time,
                          .samples = 10'000,
                          .start = along_z,
                          .measure = measure};
  };
  std::vector<ScenePreset<3>> all{
      preset("gyration", "an electron at gamma = 10 in a uniform field of 0.1 T", "uniform_field",
             {{"gamma", "10"}, {"b", "0.1 T"}, {"pitch", "90 deg"}}, "2e-11 s", "2e-8 s", fast_gyration),
      preset(
          "undulator", "an electron of 500 MeV in an undulator of 100 periods", "undulator",
          {{"gamma", "978.47"}, {"b0", "0.7 T"}, {"period", "3 cm"}, {"x", "0"}, {"y", "0.1 mm"}, {"z", "0"}},
          "2e-12 s", "1.00069e-8 s", wiggle),
      preset("solenoid", "an electron of 5 MeV through a solenoid", "solenoid",
             {{"gamma", "10.785"},
              {"b0", "50 mT"},
              {"length", "20 cm"},
              {"radius", "3 cm"},
              {"x", "1 mm"},
              {"y", "0"},
              {"z", "-1 m"}},
             "1e-11 s", "6e-9 s", rotation),
      preset("quadrupole", "an electron of 500 MeV in a quadrupole of 10 T/m", "quadrupole",
             {{"gamma", "978.47"}, {"slope", "-10 T/m"}, {"x", "1 mm"}, {"y", "1 mm"}, {"z", "0"}}, "5e-12 s",
             "1e-9 s", focusing),
      preset("cosmic_ray", "a proton of 10 GV that comes from 60 radii into the Earth's field",
             "dipole_field",
             {{"rigidity", "1e10 V"},
              {"moment", "-3.12e-5 T Rearth^3"},
              {"x", "60 Rearth"},
              {"y", "-4.7 Rearth"},
              {"z", "0.6 Rearth"}},
             "5e-4 s", "3 s", stoermer)};
  all[0].start = [](const Choice& c) {
    const double r = momentum_of(c) * std::sin(c["pitch"]) / (c["charge"] * c["b"]);
    return at(c, {r, 0, 0}, {0, -std::sin(c["pitch"]), std::cos(c["pitch"])});
  };
  all[4].start = [](const Choice& c) { return at(c, {c["x"], c["y"], c["z"]}, {-1, 0, 0}); };
  return all;
}

}  // namespace

int main(int argc, char** argv) {
  SceneProgram<3> program{.name = "fast_charges", .about = "A charge at any speed in magnetic fields."};
  program.joint = fast_field_names;
  program.parameters = {
      {"charge", "C", "the charge", {"a number other than 0", [](double x) { return x != 0; }}},
      {"mass", "kg", "its mass", above_zero},
      {"c", "m/s", "speed of light", above_zero},
      {"gamma",
       "",
       "energy at the start over that at rest",
       {"a number above 1", [](double x) { return x > 1; }}},
      {"rigidity", "V", "momentum at the start times c over the charge", above_zero},
      {"pitch", "rad", "angle of the velocity to the field at the start, 0 to 180 degrees", half_turn},
      {"b", "T", "uniform magnetic field"},
      {"moment", "T m3", "magnetic moment times μ₀/(4π); the Earth's points down"},
      {"b0", "T", "field of the undulator or solenoid"},
      {"length", "m", "of the solenoid", above_zero},
      {"radius", "m", "of the solenoid", above_zero},
      {"period", "m", "of the undulator", above_zero},
      {"slope", "T/m", "of the quadrupole's field"},
      {"ex", "V/m", "uniform electric field, x"},
      {"ey", "V/m", "uniform electric field, y"},
      {"ez", "V/m", "uniform electric field, z"},
      {"x", "m", "where it starts"},
      {"y", "m", "where it starts"},
      {"z", "m", "where it starts"}};
  program.effects = fast_charge_effects();
  program.presets = presets();
  program.view = fast_view;
  return run_scene_program(program, argc, argv);
}
