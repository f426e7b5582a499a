#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "planets.hpp"

namespace examples {

inline constexpr double arcsecond = std::numbers::pi / 648000;

/// Follows the perihelion of body 1 in the plane of its orbit: the sum of the turns of Laplace's vector about
/// the angular momentum, dω + cos i dΩ, and the straight line through it, which
/// is fitted to the integral of the squares (trapezoids), not to their sum: what the ends of a run make of
/// the rate would else be of first order in the step.
class Perihelion {
 public:
  explicit Perihelion(const System& system, std::int64_t every)
      : gm_(system.bodies.up_to(1)), reduced_(system.bodies.reduced(1)), every_(every) {}

  void see(double t, const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) {
    const Eigen::Vector3d x = q.head<3>(), v = p.head<3>() / reduced_, momentum = x.cross(v),
                          now = v.cross(momentum) / gm_ - x.normalized();
    if (seen_ > 0) {
      add(last_t_);
      turned_ += std::atan2(momentum.normalized().dot(last_.cross(now)), last_.dot(now));
      add(t);
    }
    last_ = now, last_t_ = t;
    const bool again = seen_ == 0 && !rows_.empty();  // at the start
    if (seen_++ % every_ == 0 && !again) rows_.emplace_back(t, turned_ / arcsecond);
  }
  /// To be shown every state of a run.
  Measurement<Eigen::Dynamic> look() {
    return {[this](double t, const auto& q, const auto& p) { see(t, q, p); }};
  }
  /// The next state is the start again.
  void restart() {
    seen_ = 0;
    turned_ = 0;
  }
  /// Arcseconds a century.
  double rate() const { return 100 * (sum_ * t_angle_ - t_ * angle_) / (sum_ * tt_ - t_ * t_) / arcsecond; }
  const std::vector<std::pair<double, double>>& rows() const { return rows_; }  ///< t and arcseconds

 private:
  /// One end of a step.
  void add(double t) { sum_ += 1, t_ += t, tt_ += t * t, angle_ += turned_, t_angle_ += t * turned_; }

  double gm_, reduced_;
  std::int64_t every_, seen_ = 0;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
  double last_t_ = 0, turned_ = 0, sum_ = 0, t_ = 0, tt_ = 0, angle_ = 0, t_angle_ = 0;
  std::vector<std::pair<double, double>> rows_;
};

/// Eccentricity and inclination (degrees) of every planet about the Sun.
inline std::vector<double> shapes(const System& system, const In<double, Eigen::Dynamic>& q,
                                  const In<double, Eigen::Dynamic>& p) {
  const auto r = system.bodies.positions(q), v = system.bodies.velocities(p);
  std::vector<double> all;
  for (std::size_t i = 1; i < r.size(); ++i) {
    const auto orbit = effects::orbits::elements_of<double>(
        r[i] - r[0], v[i] - v[0], gm_sun + system.bodies.gm(static_cast<Eigen::Index>(i)));
    all.push_back(orbit.e);
    all.push_back(orbit.inclination / degree);
  }
  return all;
}

}  // namespace examples
