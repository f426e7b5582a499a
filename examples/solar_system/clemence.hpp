#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

#include "../common/output.hpp"
#include "measurements.hpp"
#include "motion.hpp"

namespace examples {

/// How Mercury's perihelion turns in a scene, fitted over half of the time before J2000 and half of it
/// behind: the rates change slowly, and so that of J2000 comes out.
inline Perihelion perihelion_of(const std::string& label, const std::vector<std::string>& effects,
                                const NearIntegrable<double>& list, double dt, double time,
                                std::int64_t samples) {
  const System system(effects);
  // One row at J2000, and so many at most on each side, with the end.
  const std::int64_t rows = (samples - 1) / 2, steps = steps_in(time / 2, dt),
                     every = rows > 0 ? (steps + rows - 1) / rows : std::numeric_limits<std::int64_t>::max();
  Perihelion perihelion(system, every, time / 2);
  for (const double sign : {-1.0, 1.0}) {
    State z = system.start;
    Kept none;
    perihelion.restart();
    integrate_system(system, list, z, {.dt = sign * dt, .t_end = sign * time / 2}, none, perihelion.look(),
                     label);
  }
  return perihelion;
}

/// How the perihelion turns by an effect, and what is open of that in arcseconds a century.
struct PerihelionCurve {
  std::string name;
  Perihelion perihelion;
  double by_steps;  ///< from a run with a shorter step; of second order at least
  double uncertain() const { return perihelion.uncertain() + by_steps; }
};

/// Clemence's table: what each effect turns Mercury's perihelion by, alone with Mercury and the Sun, and all
/// of them together. Gives the curves.
inline std::vector<PerihelionCurve> clemence(const std::vector<std::string>& effects,
                                             const NearIntegrable<double>& list, double dt, double time,
                                             std::int64_t samples) {
  std::vector<PerihelionCurve> curves;
  std::vector<std::string> newton;
  double sum_1947 = 0, sum_2017 = 0;
  std::cout << "perihelion of Mercury, arcseconds a century, dω + cos i dΩ; ±: by swings over so long a "
               "time, and steps\n"
            << formatted("%-22s %9s %10s %9s %9s\n", "", "here", "±", "1947", "2017");
  const auto line = [](const std::string& name, double here, double uncertain, double then, double now) {
    constexpr double of_digits = 5e-4;
    std::cout << formatted("%-22s %9.3f %9.2g ", name.c_str(), here, std::max(uncertain, of_digits))
              << (then > 0 ? formatted("%9.3f ", then) : "          ")
              << (now > 0 ? formatted("%9.3f", now) : "") << '\n';
  };
  const auto measure = [&](const std::string& name, const std::vector<std::string>& with, double then = 0,
                           double now = 0) {
    Perihelion here = perihelion_of(name, with, list, dt, time, samples);
    // The ratio of the golden section: no step near a resonance with the planets has the other near one.
    const double ratio = std::numbers::phi,
                 finer = perihelion_of(name + ", shorter steps", with, list, dt / ratio, time, 2).rate(),
                 by_steps = by_shorter_steps(here.rate(), finer, ratio);
    curves.push_back({name, std::move(here), by_steps});
    line(name, curves.back().perihelion.rate(), curves.back().uncertain(), then, now);
  };
  for (const std::string& effect : effects) {
    if (effect == "mercury") continue;
    const auto planet = std::find_if(planets().begin(), planets().end(),
                                     [&](const Planet& one) { return one.name == effect; });
    const bool is_planet = planet != planets().end();
    if (is_planet) {
      measure(effect, {"mercury", effect}, planet->clemence, planet->park);
      newton.push_back(effect);
      sum_1947 += planet->clemence;
      sum_2017 += planet->park;
    } else if (effect == "j2") {
      measure(effect, {"mercury", effect}, 0.010, 0.029);
    } else {
      measure(effect, {"mercury", effect}, 43.03, 42.980);  // 1pn or eih
    }
  }
  newton.emplace_back("mercury");
  if (newton.size() > 2) {
    double by_planets = 0, uncertain = 0;
    for (const PerihelionCurve& curve : curves)
      if (std::count(newton.begin(), newton.end(), curve.name) > 0) {
        by_planets += curve.perihelion.rate();
        uncertain += curve.uncertain();
      }
    line("planets, sum", by_planets, uncertain, sum_1947, sum_2017);
    measure("planets together", newton);
  }
  if (newton.size() < effects.size()) measure("all", effects);
  return curves;
}

/// One column a curve.
inline void write_perihelion(const std::filesystem::path& path, const std::vector<PerihelionCurve>& curves) {
  std::vector<std::string> names{"t"};
  std::vector<std::vector<std::pair<double, double>>> columns;
  for (const PerihelionCurve& curve : curves) {
    names.push_back(curve.name);
    columns.push_back(curve.perihelion.rows());
    std::sort(columns.back().begin(), columns.back().end());
  }
  CsvWriter csv(path, names);
  for (std::size_t row = 0; row < columns.front().size(); ++row) {
    std::vector<double> values{columns.front()[row].first};
    for (const auto& column : columns) values.push_back(column[row].second);
    csv.row(values);
  }
  csv.commit();
}

}  // namespace examples
