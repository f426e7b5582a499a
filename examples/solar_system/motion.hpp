#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/run.hpp"
#include "planets.hpp"

namespace examples {

/// The lists of the splitting.
inline const std::vector<NearIntegrable<double>>& lists() {
  static const std::vector<NearIntegrable<double>> all{schemes::aba82<double>(), schemes::aba84<double>(),
                                                       schemes::aba104<double>(), schemes::aba864<double>(),
                                                       schemes::aba1064<double>()};
  return all;
}
inline std::vector<std::string> list_names() {
  std::vector<std::string> names;
  for (const auto& list : lists()) names.push_back(list.name);
  return names;
}
inline const NearIntegrable<double>& list_called(const std::string& name) {
  for (const auto& list : lists())
    if (list.name == name) return list;
  throw std::invalid_argument("--list: no list " + name);
}

/// The axis that the Sun turns about, of length one; R. Carrington (1863).
inline Eigen::Vector3d sun_axis() {
  const double tilt = 7.25 * degree, node = 75.76 * degree;  // of its equator
  return {std::sin(node) * std::sin(tilt), -std::cos(node) * std::sin(tilt), std::cos(tilt)};
}

/// Calls use(stepper) with the splitting that moves the Kepler parts exactly, and doubles nothing but
/// relativity.
template <class Use>
void with_splitting(const System& system, const NearIntegrable<double>& list, const Use& use) {
  const auto& bodies = system.bodies;
  const auto hand = [&](const auto&... more) {
    auto stepper = stepper_for(Scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                                     nbody::Interaction<double>{bodies}, more...),
                               exactly<nbody::Kinetic<double>, nbody::Attraction<double>>(), list);
    use(stepper);
  };
  const auto with_relativity = [&](const auto&... more) {
    if (system.pair_relativity)
      hand(more..., nbody::PostNewtonian1<double>{bodies, light});
    else if (system.full_relativity)
      hand(more..., nbody::EinsteinInfeldHoffmann<double>(bodies, light));
    else
      hand(more...);
  };
  if (!system.oblate) return with_relativity();
  const Eigen::Vector3d axis = sun_axis();
  with_relativity(nbody::Oblateness<double>{bodies, sun_j2, sun_radius, {axis[0], axis[1], axis[2]}});
}

using Look = Measurement<Eigen::Dynamic>;
using Kept = Invariants<double, Eigen::Dynamic>;

/// The energy, and the angular momentum about z, or about the Sun's axis where the Sun is oblate: no other
/// part is kept then. To be followed by integrate_system().
inline Kept kept_of(const System& system) {
  Kept all;
  with_splitting(system, lists().front(), [&](const auto& stepper) { all = Kept(stepper.hamiltonian()); });
  const Eigen::Vector3d axis = system.oblate ? sun_axis() : Eigen::Vector3d::UnitZ();
  all.add("angular_momentum", [axis](const auto& q, const auto& p) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    for (Eigen::Index i = 0; i < q.size(); i += 3)
      sum += Eigen::Vector3d(q[i], q[i + 1], q[i + 2]).cross(Eigen::Vector3d(p[i], p[i + 1], p[i + 2]));
    return axis.dot(sum);
  });
  return all;
}

/// Integrates z, with a progress bar on a terminal, and a checkpoint where one is wanted; `look` sees the
/// states after the invariants that are followed, if any.
inline IntegrationReport integrate_system(const System& system, const NearIntegrable<double>& list, State& z,
                                          const IntegrationOptions<double>& options, Kept& kept, Look look,
                                          const std::string& label, const CheckpointRequest& request = {}) {
  IntegrationReport report;
  with_splitting(system, list, [&](auto& stepper) {
    report = integrate_saved(request, label, stepper, z, options, kept, look);
  });
  return report;
}

}  // namespace examples
