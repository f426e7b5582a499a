#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/line_fit.hpp"
#include "../common/measurement.hpp"
#include "planets.hpp"

namespace examples {

inline constexpr double arcsecond = std::numbers::pi / 648000;

/// The error of a rate, from that with steps shorter by the ratio: right for errors of second order in the
/// step, too large for those of higher orders.
inline double by_shorter_steps(double rate, double of_shorter, double ratio) {
  return std::abs(rate - of_shorter) / (1 - 1 / (ratio * ratio));
}

/// Follows the perihelion of body 1 in the plane of its orbit: the sum of the turns of Laplace's vector about
/// the angular momentum, dω + cos i dΩ, and the straight line through it, which
/// is fitted to the integral of the squares (trapezoids), not to their sum: what the ends of a run make of
/// the rate would else be of first order in the step.
class Perihelion {
 public:
  /// It keeps a row of so many states, and the last one; a run goes on for `length`, to either side of its
  /// start.
  Perihelion(const System& system, std::int64_t every, double length)
      : gm_(system.bodies.up_to(1)), reduced_(system.bodies.reduced(1)), every_(every), length_(length) {}

  void see(double t, const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) {
    const Eigen::Vector3d x = q.head<3>(), v = p.head<3>() / reduced_, momentum = x.cross(v),
                          now = v.cross(momentum) / gm_ - x.normalized();
    if (seen_ > 0) {
      LineFit& line = lines_[side_];
      line.add(last_t_, turned_);
      turned_ += angle_about(momentum, last_, now);
      line.add(t, turned_);
      auto& shorter = shorter_[side_];
      while (std::abs(t) >= length_ * (0.75 + 0.25 * static_cast<double>(shorter.size()) / windows) &&
             shorter.size() < windows)
        shorter.push_back(line);
    }
    last_ = now, last_t_ = t;
    const bool again = seen_ == 0 && !rows_.empty();  // at the start
    const bool last = every_ < std::numeric_limits<std::int64_t>::max() && std::abs(t) == length_;
    if ((seen_++ % every_ == 0 || last) && !again) rows_.emplace_back(t, turned_ / arcsecond);
  }
  /// To be shown every state of a run.
  Measurement<Eigen::Dynamic> look() {
    return {[this](double t, const auto& q, const auto& p) { see(t, q, p); }};
  }
  /// The next state is the start again, to the other side.
  void restart() {
    side_ = seen_ > 0 ? 1 : 0;
    seen_ = 0;
    turned_ = 0;
  }
  /// Arcseconds a century.
  double rate() const { return rate(lines_[0] + lines_[1]); }
  /// What swings leave open of it: by how much it differs over the times from three quarters of this one on.
  double uncertain() const {
    double most = 0;
    for (std::size_t i = 0; i < std::min(shorter_[0].size(), shorter_[1].size()); ++i)
      most = std::max(most, std::abs(rate(shorter_[0][i] + shorter_[1][i]) - rate()));
    return most;
  }
  const std::vector<std::pair<double, double>>& rows() const { return rows_; }  ///< t and arcseconds

 private:
  static constexpr std::size_t windows = 64;
  static double rate(const LineFit& line) { return 100 * line.slope() / arcsecond; }

  double gm_, reduced_;
  std::int64_t every_, seen_ = 0;
  double length_;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
  double last_t_ = 0, turned_ = 0;
  std::size_t side_ = 0;
  std::array<LineFit, 2> lines_{};                 ///< of both sides
  std::array<std::vector<LineFit>, 2> shorter_{};  ///< up to times from three quarters of the length on
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
