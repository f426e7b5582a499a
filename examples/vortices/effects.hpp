#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../common/scene_choice.hpp"
#include "file.hpp"

namespace examples {

/// The state of vortices in their places.
inline PhasePoint<double, Eigen::Dynamic> start(const Vortices& v) {
  return systems::PointVortices<>(v.circulation).phase_point(v.x, v.y);
}

/// `wet` says whether a vortex is on the right side of the wall of that name.
template <class Wet>
void refuse_dry(const Vortices& v, const std::string& name, const Wet& wet) {
  for (Eigen::Index i = 0; i < v.x.size(); ++i)
    if (!wet(v.x[i], v.y[i]))
      throw std::invalid_argument("--effects: vortex " + std::to_string(i) + " is on the dry side of " +
                                  name);
}

/// The effects on `v`, which has its vortices when an effect is made.
inline std::vector<EffectEntry<Eigen::Dynamic>> vortex_effects(const Vortices& v) {
  const auto gamma = [&v] { return vortices::Circulations<>(v.circulation); };
  const char* const newton = "Newton, The N-Vortex Problem (2001), chapters 2 and 3";
  const char* const images = "Newton (2001), section 3.2; Saffman, Vortex Dynamics (1992), section 7";
  return {{{}, newton, [=](const Choice&) { return vortices::Pairs<>(gamma()); }},
          {{"strain_rate", "strain_angle"},
           newton,
           [=](const Choice& c) { return vortices::Strain<>(gamma(), c["strain_rate"], c["strain_angle"]); }},
          {{"rotation_rate"},
           newton,
           [=](const Choice& c) { return vortices::Rotation<>(gamma(), c["rotation_rate"]); }},
          {{},
           images,
           [=, &v](const Choice& c) {
             if (c.on("disk"))
               throw std::invalid_argument("--effects: half_plane and disk are two flows; take one");
             if (c.on("rotation") || (c.on("strain") && std::abs(std::sin(2 * c["strain_angle"])) > 1e-12))
               throw std::invalid_argument(
                   "--effects: only strain with --strain_angle 0 or \"90 deg\" flows along half_plane, not "
                   "through it");
             refuse_dry(v, "half_plane", [](double, double y) { return y > 0; });
             return vortices::HalfPlane<>(gamma());
           }},
          {{"radius"}, images, [=, &v](const Choice& c) {
             if (c.on("strain"))
               throw std::invalid_argument("--effects: strain flows through the wall of disk; take one");
             const double radius = c["radius"];
             refuse_dry(v, "disk", [=](double x, double y) { return std::hypot(x, y) < radius; });
             return vortices::Disk<>(gamma(), radius);
           }}};
}

/// What the flow keeps. An impulse that cancels but for rounding counts as zero, so that its error is
/// absolute.
inline void add_impulses(Invariants<double, Eigen::Dynamic>& invariants, const Vortices& v, const Choice& c) {
  using System = systems::PointVortices<>;
  const System system(v.circulation);
  const auto z = start(v);
  const auto add = [&](const char* name, auto impulse, double size) {
    const double initial = (system.*impulse)(z.q(), z.p());
    const double offset = std::abs(initial) <= 1e-14 * size ? initial : 0;
    invariants.add(name, [=](const auto& q, const auto& p) { return (system.*impulse)(q, p) - offset; });
  };
  const Eigen::VectorXd weight = v.circulation.cwiseAbs();
  const bool still = !c.on("strain") && !c.on("rotation") && !c.on("disk");
  if (still && !c.on("half_plane")) add("impulse_x", &System::linear_impulse_x, weight.dot(v.x.cwiseAbs()));
  if (still) add("impulse_y", &System::linear_impulse_y, weight.dot(v.y.cwiseAbs()));
  if (!c.on("strain") && !c.on("half_plane"))
    add("angular_impulse", &System::angular_impulse, weight.dot(v.x.cwiseAbs2() + v.y.cwiseAbs2()));
}

}  // namespace examples
