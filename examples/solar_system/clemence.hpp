#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
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
  // One row at J2000, and so many at most on each side.
  const std::int64_t rows = (samples - 1) / 2, every = steps_in(time / 2, dt) / (rows + 1) + 1;
  Perihelion perihelion(system, every);
  for (const double sign : {-1.0, 1.0}) {
    State z = system.start;
    Kept none;
    perihelion.restart();
    integrate_system(system, list, z, {.dt = sign * dt, .t_end = sign * time / 2}, none, perihelion.look(),
                     label);
  }
  return perihelion;
}

/// Clemence's table: what each effect turns Mercury's perihelion by, alone with Mercury and the Sun, and all
/// of them together. Gives the curves as (name, rows).
struct PerihelionTable {
  std::vector<std::pair<std::string, Perihelion>> curves{};
};
inline PerihelionTable clemence(const std::vector<std::string>& effects, const NearIntegrable<double>& list,
                                double dt, double time, std::int64_t samples) {
  PerihelionTable table;
  std::vector<std::string> newton;
  double sum_1947 = 0, sum_2017 = 0;
  std::cout << "perihelion of Mercury, arcseconds a century, dω + cos i dΩ\n"
            << formatted("%-22s %9s %9s %9s\n", "", "here", "1947", "2017");
  const auto line = [&](const std::string& name, double here, double then, double now) {
    std::cout << formatted("%-22s %9.3f ", name.c_str(), here)
              << (then > 0 ? formatted("%9.3f ", then) : "          ")
              << (now > 0 ? formatted("%9.3f", now) : "") << '\n';
  };
  const auto measure = [&](const std::string& name, const std::vector<std::string>& with) {
    return table.curves.emplace_back(name, perihelion_of(name, with, list, dt, time, samples)).second.rate();
  };
  for (const std::string& effect : effects) {
    if (effect == "mercury") continue;
    const double rate = measure(effect, {"mercury", effect});
    for (const Planet& planet : planets())
      if (planet.name == effect) {
        line(effect, rate, planet.clemence, planet.park);
        newton.push_back(effect);
        sum_1947 += planet.clemence;
        sum_2017 += planet.park;
      }
    if (effect == "1pn" || effect == "eih") line(effect, rate, 43.03, 42.980);
    if (effect == "j2") line(effect, rate, 0.010, 0.029);
  }
  newton.emplace_back("mercury");
  if (newton.size() > 2) {
    double by_planets = 0;
    for (const auto& [name, perihelion] : table.curves)
      if (std::count(newton.begin(), newton.end(), name) > 0) by_planets += perihelion.rate();
    line("planets, sum", by_planets, sum_1947, sum_2017);
    line("planets, together", measure("planets together", newton), 0, 0);
  }
  if (newton.size() < effects.size()) line("all together", measure("all", effects), 0, 0);
  return table;
}

/// One column a curve.
inline void write_perihelion(const std::filesystem::path& path, const PerihelionTable& table) {
  std::vector<std::string> names{"t"};
  std::vector<std::vector<std::pair<double, double>>> columns;
  for (const auto& [name, perihelion] : table.curves) {
    names.push_back(name);
    columns.push_back(perihelion.rows());
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
