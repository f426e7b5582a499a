#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <iostream>
#include <limits>
#include <ostream>
#include <stdexcept>
#include <string>
#include <vector>

#include "../common/cost.hpp"
#include "../common/output.hpp"
#include "measurements.hpp"
#include "motion.hpp"

namespace examples {

/// What a list and a step are judged by.
enum class Judge {
  energy,     ///< the largest relative error of the energy
  perihelion  ///< the error of how Mercury's perihelion turns, arcseconds a century
};

/// What came of a list and a step on a short run; its costs are those of the whole one.
struct Trial {
  CostRow row{};
  double rate = 0;  ///< of the perihelion
};

/// Tries a list for the time `trial`, with a step of dt or a little less.
inline Trial try_list(const System& system, const NearIntegrable<double>& list, double dt, double trial,
                      double time, Judge judge) {
  const double steps = std::ceil(trial / dt), share = time / trial;
  Trial result{
      .row = {.setting = {.method = Setting::Method::splitting, .scheme = list.name, .dt = trial / steps},
              .tried = trial}};
  CostRow& row = result.row;
  State z = system.start;
  Kept kept;
  if (judge == Judge::energy) kept = kept_of(system);
  Perihelion perihelion(system, std::numeric_limits<std::int64_t>::max(),
                        std::numeric_limits<double>::infinity());
  const std::clock_t begin = std::clock();
  const IntegrationReport run = integrate_system(
      system, list, z,
      {.dt = row.setting.dt, .steps = static_cast<std::int64_t>(steps), .on_failure = OnFailure::stop}, kept,
      judge == Judge::perihelion ? perihelion.look() : Look(), "trial of " + list.name);
  row.seconds = share * static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  row.gradients = share * static_cast<double>(run.gradients);
  row.status = run.status;
  row.error = std::numeric_limits<double>::quiet_NaN();
  if (!run.ok()) return result;
  result.rate = perihelion.rate();
  if (judge == Judge::energy) {
    const double rounding = std::numeric_limits<double>::epsilon() / 2 * std::sqrt(share * steps);
    row.error = std::max(kept["energy"].worst, rounding);
    if (row.error == rounding) row.limit = LimitedBy::rounding;
  }
  return result;
}

/// The steps that are tried: a quarter of the period of the innermost planet, and then ever shorter ones by
/// 2^{1/4}; each half as long as the one four before.
inline constexpr int tried_steps = 18, trials_to_half = 4;
inline double tried_step(const System& system, int k) { return system.period / 4 * std::pow(2, -k / 4.0); }

/// What accuracy costs over `time`, by trials of all lists: over 200 periods of the innermost planet, or the
/// whole time where that is shorter, with the steps of tried_step(), until the error has stayed below
/// `enough`, or rounding, down to half the step. The error of the energy is the largest in the trial, and no
/// less than what rounding makes of a whole run, ε/2 times the root of its steps. That of the perihelion is
/// by_shorter_steps(). Neither is less than with any shorter step: what is better than that is so by
/// accident. Gradient calls and seconds are those of the trial, times time/trial.
inline CostTable cost_of_lists(const System& system, double time, Judge judge, double enough, CostBy by) {
  constexpr std::size_t half = trials_to_half;
  CostTable table{.by = by, .time = time, .tried = std::min(time, 200 * system.period)};
  for (const auto& list : lists()) {
    std::vector<Trial> trials;
    std::size_t below = 0;  // so many in a row
    for (int k = 0; k < tried_steps && below <= half; ++k) {
      const double dt = tried_step(system, k);
      if (dt > table.tried) continue;
      trials.push_back(try_list(system, list, dt, table.tried, time, judge));
      const std::size_t later = judge == Judge::perihelion ? half : 0;
      if (trials.size() <= later) continue;
      Trial& judged = *(trials.rbegin() + static_cast<std::ptrdiff_t>(later));
      if (judge == Judge::perihelion && judged.row.works() && trials.back().row.works())
        judged.row.error = by_shorter_steps(judged.rate, trials.back().rate, 2);
      below = judged.row.error <= enough || judged.row.limit == LimitedBy::rounding ? below + 1 : 0;
    }
    double least = 0;
    std::vector<CostRow> rows;
    for (auto trial = trials.rbegin(); trial != trials.rend(); ++trial) {
      if (trial->row.works() && std::isnan(trial->row.error)) continue;  // half the step was not tried
      if (trial->row.works()) least = trial->row.error = std::max(trial->row.error, least);
      rows.push_back(trial->row);
    }
    table.rows.insert(table.rows.end(), rows.rbegin(), rows.rend());
  }
  return table;
}

inline void print_costs(std::ostream& out, const CostTable& cost, Judge judge) {
  const bool angle = judge == Judge::perihelion;
  out << formatted("over %g years, by trials of %.4g years; ", cost.time, cost.tried)
      << (angle ? "error of the turn of Mercury's perihelion, arcseconds a century, by half the step\n"
                : "largest relative error of the energy\n")
      << formatted("%-8s %10s %10s %15s %10s\n", "list", "dt, days", "error", "gradient calls", "seconds");
  for (const CostRow& row : cost.rows)
    out << formatted("%-8s %10.4g ", row.setting.scheme.c_str(), row.setting.dt * days_a_year)
        << (row.works() ? formatted("%10.1e %15.3g %10.3g", row.error, row.gradients, row.seconds)
                        : "failed: " + describe(row.status))
        << '\n';
}

/// Does what --cost or --accuracy ask for. True: the costs are shown, and there is nothing else to do; else
/// the cheapest list and step are chosen. Throws std::invalid_argument where the time is too short for any.
inline bool answer(CostRequest& request, const System& system, Judge judge, std::string& list,
                   Settings& settings) {
  const bool angle = judge == Judge::perihelion;
  const double asked =
      request.unit.empty() ? request.accuracy : request.aim_at("perihelion of Mercury", "arcsec");
  const double target = asked / CostRequest::safety;
  const double shortest = tried_step(system, tried_steps - 1 - (angle ? trials_to_half : 0));
  if (settings.time < shortest)
    throw std::invalid_argument(
        formatted("--time is shorter than a step; the shortest for --cost and --accuracy has %.3g days",
                  shortest * days_a_year));
  const std::string file = "solar_system_cost";
  request.prepare(settings, file);
  const CostTable cost = cost_of_lists(system, settings.time, judge, target, request.cost_by());
  print_costs(std::cout, cost, judge);
  if (request.curve) {
    CostRequest::write(cost, settings, file, "The Solar System",
                       angle ? "error of the turn of the perihelion, arcseconds a century"
                             : "largest relative energy error, expected");
    return true;
  }
  const Setting& setting = request.choose(cost, target, CostRequest::safety).setting;
  list = setting.scheme;
  settings.dt = setting.dt;
  settings.fit_steps();
  std::cout << "chosen: " << list << formatted(", dt = %.4g days, ", settings.dt * days_a_year)
            << request.among(cost) << "\n\n";
  return false;
}

}  // namespace examples
