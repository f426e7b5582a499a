#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

namespace examples {

using namespace semiexplicit;
namespace nbody = effects::nbody;
using State = PhasePoint<double, Eigen::Dynamic>;

// Lengths in au, times in Julian years.
inline constexpr double au = 149597870700.0, days_a_year = 365.25, year = days_a_year * 86400,
                        degree = std::numbers::pi / 180;
inline constexpr double gm_sun = 1.32712440041e20 / (au * au * au) * year * year;
inline constexpr double light = 299792458.0 / au * year;
inline constexpr double sun_j2 = 2.2e-7, sun_radius = 6.957e8 / au;  // Park et al., Astron. J. 153 (2017) 121

/// A planet, the Earth with the Moon. Elements of J2000 about the Sun in the ecliptic: E. M. Standish,
/// Keplerian Elements for Approximate Positions of the Major Planets (JPL), table 1, at the epoch. Masses:
/// IAU WGAS Sub-group on Numerical Standards (1994), as the Sun's mass in theirs. The last two: by what it
/// turns Mercury's perihelion, arcseconds a century, after G. M. Clemence, Rev. Mod. Phys. 19 (1947) 361, and
/// with today's masses after R. Park et al., Astron. J. 153 (2017) 121.
struct Planet {
  std::string name;
  double suns, a, e, inclination, longitude, perihelion, node, clemence = 0, park = 0;
};
inline const std::vector<Planet>& planets() {
  static const std::vector<Planet> all{
      {"mercury", 6023600.0, 0.38709927, 0.20563593, 7.00497902, 252.25032350, 77.45779628, 48.33076593},
      {"venus", 408523.71, 0.72333566, 0.00677672, 3.39467605, 181.97909950, 131.60246718, 76.67984255,
       277.856, 277.418},
      {"earth", 328900.56, 1.00000261, 0.01671123, -0.00001531, 100.46457166, 102.93768193, 0, 90.038,
       90.888},
      {"mars", 3098708.0, 1.52371034, 0.09339410, 1.84969142, -4.55343205, -23.94362959, 49.55953891, 2.536,
       2.481},
      {"jupiter", 1047.3486, 5.20288700, 0.04838624, 1.30439695, 34.39644051, 14.72847983, 100.47390909,
       153.584, 153.990},
      {"saturn", 3497.898, 9.53667594, 0.05386179, 2.48599187, 49.95424423, 92.59887831, 113.66242448, 7.302,
       7.323},
      {"uranus", 22902.98, 19.18916464, 0.04725744, 0.77263783, 313.23810451, 170.95427630, 74.01692503,
       0.141, 0.142},
      {"neptune", 19412.24, 30.06992276, 0.00859048, 1.77004347, -55.12002969, 44.96476227, 131.78422574,
       0.042, 0.042}};
  return all;
}
inline const std::vector<std::string> corrections{"1pn", "eih", "j2"};

/// The Sun and the planets that are named, from within outwards, and their state at J2000.
struct System {
  explicit System(const std::vector<std::string>& effects) : bodies({1, 1}) {
    const auto on = [&](const std::string& name) {
      return std::find(effects.begin(), effects.end(), name) != effects.end();
    };
    std::vector<double> gm{gm_sun};
    nbody::Bodies<double>::Vectors r{{0, 0, 0}}, v = r;
    for (const Planet& planet : planets()) {
      if (!on(planet.name)) continue;
      longest_period = std::pow(planet.a, 1.5);
      if (names.empty()) period = longest_period;
      names.push_back(planet.name);
      gm.push_back(gm_sun / planet.suns);
      const auto z = state_of(
          effects::orbits::Elements<double>{.a = planet.a,
                                            .e = planet.e,
                                            .inclination = planet.inclination * degree,
                                            .node = planet.node * degree,
                                            .periapsis = (planet.perihelion - planet.node) * degree,
                                            .mean_anomaly = (planet.longitude - planet.perihelion) * degree},
          gm.front() + gm.back());
      r.push_back(z.q());
      v.push_back(z.p());
    }
    if (names.empty()) throw std::invalid_argument("--effects: no planet is on; name one at least");
    bodies = nbody::Bodies<double>(gm);
    start = bodies.jacobi(r, v);
    pair_relativity = on("1pn"), full_relativity = on("eih"), oblate = on("j2");
    if (pair_relativity && full_relativity)
      throw std::invalid_argument("--effects: 1pn is part of eih; name one of them");
  }

  std::vector<std::string> names;  ///< of the planets, body 1 and on
  nbody::Bodies<double> bodies;
  State start;
  double period = 0, longest_period = 0;  ///< of the innermost and of the outermost, in years
  bool pair_relativity = false, full_relativity = false, oblate = false;
};

}  // namespace examples
