#pragma once

#include <string>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/scene_choice.hpp"
#include "magnetic_fields.hpp"

namespace examples {

// The fields, and the effects that they are. A field counts those before it in this order as there already.
inline const std::vector<std::string> field_names{"uniform_field", "dipole_field", "magnetic_bottle"};

inline FieldSum fields_before(const Choice& c, const std::string& end) {
  FieldSum sum;
  for (const std::string& name : field_names) {
    if (name == end) break;
    if (!c.on(name)) continue;
    if (name == "uniform_field") sum.add(charges::UniformField(c["b"]));
    if (name == "dipole_field") sum.add(charges::DipoleField(c["moment"]));
    if (name == "magnetic_bottle") sum.add(charges::BottleField(c["b0"], c["length"]));
  }
  return sum;
}

template <class Field>
auto field_effect(const Choice& c, const std::string& name, const Field& field) {
  const FieldSum others = fields_before(c, name);
  return FieldEffect<Field>(name, c["charge"], c["mass"], field, others, !c.on("kinetic") && others.empty());
}

/// Not a charge's own, but of the same form as Coulomb's.
struct Gravity : charges::Coulomb<> {
  static constexpr const char* name = "gravity";
  static constexpr const char* about = "a point mass at the origin, -GMm/r";
};

inline std::vector<EffectEntry<3>> charge_effects() {
  const char* const jackson = "Jackson, Classical Electrodynamics (1999), sections 5.6, 12.1 to 12.5";
  return {{{"mass"}, jackson, [](const Choice& c) { return charges::Kinetic<>{.mass = c["mass"]}; }},
          {{"b", "charge", "mass"},
           jackson,
           [](const Choice& c) { return field_effect(c, "uniform_field", charges::UniformField(c["b"])); },
           "uniform_field",
           "uniform magnetic field along z, A = B/2 (-y, x, 0)"},
          {{"moment", "charge", "mass"},
           jackson,
           [](const Choice& c) { return field_effect(c, "dipole_field", charges::DipoleField(c["moment"])); },
           "dipole_field",
           "magnetic dipole along z at the origin, A = M (-y, x, 0)/r³"},
          {{"b0", "length", "charge", "mass"},
           jackson,
           [](const Choice& c) {
             return field_effect(c, "magnetic_bottle", charges::BottleField(c["b0"], c["length"]));
           },
           "magnetic_bottle",
           "magnetic bottle along z, B_z = B0 (1 + (z² - ρ²/2)/L²)"},
          {{"ex", "ey", "ez", "charge"},
           jackson,
           [](const Choice& c) {
             return charges::UniformElectric<>{
                 .charge = c["charge"], .x = c["ex"], .y = c["ey"], .z = c["ez"]};
           }},
          {{"centre", "charge"},
           jackson,
           [](const Choice& c) { return charges::Coulomb<>{.k = c["charge"] * c["centre"]}; }},
          {{"quadrupole", "charge"},
           "Brown and Gabrielse, Rev. Mod. Phys. 58 (1986) 233",
           [](const Choice& c) { return charges::Quadrupole<>{.k = c["charge"] * c["quadrupole"]}; }},
          {{"gm", "mass"}, "", [](const Choice& c) { return Gravity{{.k = -c["gm"] * c["mass"]}}; }}};
}

}  // namespace examples
