#pragma once

#include <string>

#include "../../tests/kepler.hpp"
#include "systems.hpp"

namespace bench {

/// Where the periapsis lies, as a vector: that of Laplace, Runge and Lenz.
inline Eigen::Vector2d periapsis(const In<double, 2>& q, const In<double, 2>& p) {
  const double turn = q[0] * p[1] - q[1] * p[0];
  return Eigen::Vector2d(p[1] * turn, -p[0] * turn) - q / q.norm();
}

/// Calls use(name, H, z0, T, target, observable) for each of the twelve pairs of a system and what is
/// measured.
template <class Use>
void for_each_pair(const Use& use) {
  const auto pair = [&](const std::string& name, const auto& h, const auto& z0, double T, double target,
                        const auto& f) {
    using H = std::decay_t<decltype(h)>;
    use(name, h, z0, T, target, Observable<double, H::Dof>(f));
  };
  const PhasePoint<double, 2> planet({0.5, 0}, {0, std::sqrt(3.0)});
  pair("Kepler, position", Kepler(), planet, 1000.0, 1e-6, observables::Positions{});
  pair("Kepler, energy", Kepler(), planet, 1000.0, 1e-8, observables::Energy{});
  const systems::Product<double> product;
  pair("product, trajectory", product, PhasePoint<double, 1>(-3, 0), 1000.0, 1e-4, observables::Trajectory{});
  pair("product, momentum", product, PhasePoint<double, 1>(-3, 0), 1000.0, 1e-7, observables::Coordinate{1});
  const PhasePoint<double, 5> sites({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  const systems::NlsLattice<double, 5> lattice;
  pair("NLS 5, energy", lattice, sites, 1000.0, 1e-8, observables::Energy{});
  pair("NLS 5, first site", lattice, sites, 5.0, 1e-5,
       [](const auto& q, const auto& p) { return q[0] * q[0] + p[0] * p[0]; });
  const Eigen::Vector4d strengths(1, -0.5, 0.7, 0.4);
  const systems::PointVortices<double, 4> vortices(strengths);
  const auto swirl = vortices.phase_point(Eigen::Vector4d(0, 1, 5, 5), Eigen::Vector4d(0, 0, 0, 1));
  pair("four vortices, trajectory", vortices, swirl, 1000.0, 1e-5, observables::Trajectory{});
  pair("four vortices, energy", vortices, swirl, 5000.0, 1e-9, observables::Energy{});
  const PhasePoint<double, 3> charge({0.5, 0, 0}, {0, 1, 0.7});
  pair("magnetic bottle, position", MagneticBottle(), charge, 1000.0, 1e-5, observables::Positions{});
  const PhasePoint<double, 2> binary({1.5, 0}, {0, 0.55});
  pair("post-Newtonian orbit, periapsis", PostNewtonian(), binary, 2000.0, 1e-5, periapsis);
  pair("post-Newtonian orbit, energy", PostNewtonian(), binary, 2000.0, 1e-7, observables::Energy{});
  pair("double pendulum, trajectory", DoublePendulum(), PhasePoint<double, 2>({1.8, 2.2}, {0, 0}), 1000.0,
       1e-6, observables::Trajectory{});
}

}  // namespace bench
