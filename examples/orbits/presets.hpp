#pragma once

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/scene_choice.hpp"
#include "measurements.hpp"
#include "period_decay.hpp"

namespace examples {

using State3 = PhasePoint<double, 3>;

/// From the periapsis on the first axis, the plane tilted about that axis.
inline State3 at_periapsis(const Choice& c) {
  const double a = c["a"], e = c["e"], tilt = c["inclination"];
  if (!(0 <= e && e < 1)) throw std::invalid_argument("--e: a bound orbit has 0 <= e < 1");
  const double speed = std::sqrt(c["gm"] / a * (1 + e) / (1 - e));
  return {{a * (1 - e), 0, 0}, {0, speed * std::cos(tilt), speed * std::sin(tilt)}};
}

inline std::vector<ScenePreset<3>> orbit_presets() {
  return {
      {.name = "mercury",
       .about = "Mercury about the Sun, in the Sun's equator",
       .units = {"AU, year", 149597870700.0, 365.25 * 86400},
       .effects = {"kinetic", "attraction", "1pn"},
       .also = {"j2", "2pn", "spin_orbit"},
       .values = {{"gm", "1 GMsun"},
                  {"c", "1 c"},
                  {"nu", "0"},
                  {"j2", "2.2e-7"},
                  {"radius", "1 Rsun"},
                  {"gs", "1.28e31 m^5/s^3"},
                  {"a", "0.38709893 AU"},
                  {"e", "0.20563069"},
                  {"inclination", "0"}},
       .dt = "0.5 day",
       .time = "1 century",
       .samples = 20'000,
       .start = at_periapsis,
       .measure = perihelion,
       .figure = direction_of_perihelion},
      {.name = "arenstorf",
       .about = "Arenstorf's orbit about Earth and Moon, in the frame that turns with them",
       .units = {"Earth-Moon distance, month/(2 pi)", 3.84400e8, 27.321661 * 86400 / (2 * std::numbers::pi)},
       .effects = {"kinetic", "two_centres", "rotating_frame"},
       .values = {{"mu", "0.012277471"},
                  {"frame-rate", "1"},
                  {"x", "0.994"},
                  {"vy", "-2.00158510637908252240537862224"}},
       .dt = "0.0004",
       .time = formatted("%.17g", arenstorf_period),
       .start =
           [](const Choice& c) {  // p = v + omega x q
             return State3({c["x"], 0, 0},
                           {0, c["vy"] + (c.on("rotating_frame") ? c["frame-rate"] * c["x"] : 0), 0});
           },
       .measure = closure},
      {.name = "hulse_taylor",
       .about = "the pulsar PSR B1913+16 and its companion, two neutron stars",
       .units = {"km, s", 1000, 1},
       .effects = {"kinetic", "attraction", "1pn", "2.5pn"},
       .also = {"2pn"},
       // J. Weisberg, J. Taylor, ASP Conf. Ser. 328 (2005) 25: 1.4414 and 1.3867 suns, 27906.979587 s, e; a by Kepler's third law
       .values = {{"gm", "2.8281 GMsun"},
                  {"c", "1 c"},
                  {"nu", "0.2499065"},
                  {"a", "1949055.067275 km"},
                  {"e", "0.6171334"},
                  {"inclination", "0"}},
       .dt = "60",
       .time = "1 year",
       .samples = 20'000,
       .start = at_periapsis,
       .measure = binary_pulsar},
      {.name = "gps",
       .about = "a satellite like those of GPS about the oblate Earth",
       .units = {"km, s", 1000, 1},
       .effects = {"kinetic", "attraction", "j2"},
       .also = {"1pn", "spin_orbit"},
       .values = {{"gm", "1 GMearth"},
                  {"j2", "1.08262668e-3"},
                  {"radius", "1 Rearth"},
                  {"c", "1 c"},
                  {"nu", "0"},
                  {"gs", "3.9e23 m^5/s^3"},
                  {"drag", "1e-16 1/m"},
                  {"air-height", "300 km"},
                  {"a", "26559.7 km"},
                  {"e", "0"},
                  {"inclination", "55 deg"}},
       .dt = "10 min",
       .time = "30 day",
       .samples = 5000,
       .start = at_periapsis,
       .measure = node},
  };
}

}  // namespace examples
