#pragma once

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/scene_choice.hpp"

namespace examples {

using namespace semiexplicit;
namespace charges = effects::charges;

/// The motion without fields.
struct FastKinetic : charges::RelativisticKinetic<double> {
  using RelativisticKinetic::RelativisticKinetic;
  static constexpr const char* name = "kinetic";
  static constexpr const char* about = "√(m²c⁴ + c²p²) - mc²";
};

/// What one magnetic field adds to the motion in those before it: √(m²c⁴ + c²|p - e(A + B)|²) - √(m²c⁴ + c²|p
/// - eA|²), so that each is an effect of its own. `moves` leaves the second root out, for a first field where
/// no kinetic effect is on.
class FastFieldEffect {
 public:
  using Acts = OnBoth<double, 3>;
  using Motion = charges::RelativisticKinetic<double, charges::FieldSum>;

  FastFieldEffect(std::string called, Motion with, Motion without, bool moves)
      : name_(std::move(called)), with_(std::move(with)), without_(std::move(without)), moves_(moves) {}

  std::string name() const { return name_; }
  double energy(const auto& q, const auto& p) const {
    return with_.energy(q, p) - (moves_ ? 0 : without_.energy(q, p));
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    with_.add_gradient(q, p, dHdq, dHdp);
    if (moves_) return;
    Vector<double, 3> by_q(0, 0, 0), by_p(0, 0, 0);
    without_.add_gradient(q, p, by_q, by_p);
    for (int i = 0; i < 3; ++i) {
      dHdq[i] -= by_q[i];
      dHdp[i] -= by_p[i];
    }
  }

 private:
  std::string name_;
  Motion with_, without_;
  bool moves_;
};

inline const std::vector<std::string> fast_field_names{"uniform_field", "dipole_field", "solenoid",
                                                       "undulator", "quadrupole"};

/// The motion in the fields that are on and come before `end` in this order; all of them: "".
inline charges::FieldSum fast_fields(const Choice& c, const std::string& end) {
  charges::FieldSum sum;
  for (const std::string& name : fast_field_names) {
    if (name == end) break;
    if (!c.on(name)) continue;
    if (name == "uniform_field") sum.add(charges::UniformField(c["b"]));
    if (name == "dipole_field") sum.add(charges::DipoleField(c["moment"]));
    if (name == "solenoid") sum.add(charges::SolenoidField(c["b0"], c["length"], c["radius"]));
    if (name == "undulator") sum.add(charges::UndulatorField(c["b0"], 2 * std::acos(-1.0) / c["period"]));
    if (name == "quadrupole") sum.add(charges::QuadrupoleField(c["slope"]));
  }
  return sum;
}
inline FastFieldEffect::Motion fast_motion(const Choice& c, const charges::FieldSum& fields) {
  return {c["charge"], c["mass"], c["c"], fields};
}

inline std::vector<EffectEntry<3>> fast_charge_effects() {
  const std::string jackson = "Jackson, Classical Electrodynamics (1999), section 12.1";
  const auto field = [&](const std::string& name, std::vector<std::string> takes, const std::string& from,
                         const std::string& about) {
    for (const char* each : {"charge", "mass", "c"}) takes.emplace_back(each);
    return EffectEntry<3>(
        takes, from,
        [name](const Choice& c) {
          charges::FieldSum before = fast_fields(c, name), with = before;
          Choice alone = c;
          alone.effects = {name};
          with.add(fast_fields(alone, ""));
          return FastFieldEffect(name, fast_motion(c, with), fast_motion(c, before),
                                 !c.on("kinetic") && before.empty());
        },
        name, about);
  };
  return {{{"mass", "c"}, jackson, [](const Choice& c) { return FastKinetic(0, c["mass"], c["c"]); }},
          field("uniform_field", {"b"}, jackson, "uniform magnetic field along z"),
          field("dipole_field", {"moment"}, jackson, "magnetic dipole along z at the origin"),
          field("solenoid", {"b0", "length", "radius"}, jackson,
                "solenoid along z about the origin, with soft edges"),
          field("undulator", {"b0", "period"}, "Scharlemann, J. Appl. Phys. 58 (1985) 2154",
                "undulator along z, field along y"),
          field("quadrupole", {"slope"}, "Wille, The Physics of Particle Accelerators (2000)",
                "magnetic quadrupole along z"),
          {{"ex", "ey", "ez", "charge"}, jackson, [](const Choice& c) {
             return charges::UniformElectric<>{
                 .charge = c["charge"], .x = c["ex"], .y = c["ey"], .z = c["ez"]};
           }}};
}

}  // namespace examples
