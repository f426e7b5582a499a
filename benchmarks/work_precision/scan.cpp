#include "scan.hpp"

#include <algorithm>
#include <cmath>
#include <iostream>
#include <numeric>
#include <set>
#include <stdexcept>

namespace work_precision {

namespace {

bool contains(const std::vector<std::string>& list, const std::string& word) {
  return std::find(list.begin(), list.end(), word) != list.end();
}

/// One timing of a setting: the mean of as many runs as fill a batch.
double time_once(const Line& line, double parameter, double batch) {
  double total = 0;
  int runs = 0;
  do {
    total += line.run(parameter, nullptr).seconds;
    ++runs;
  } while (total < batch);
  return total / runs;
}

Row observe(const Task& task, std::size_t index, double parameter, const ScanOptions& options) {
  const Line& line = task.lines[index];
  Row row{.line = index, .method = line.method, .parameter = parameter, .outcome = {}, .errors = {}};
  Watch watch(task.yardstick, options.samples, task.most_calls);
  row.outcome = line.run(parameter, &watch);
  row.errors = watch.errors();
  if (row.ok() && !std::isfinite(row.errors.energy)) row.outcome.status = "not finite";
  row.seconds = row.outcome.seconds;
  if (line.over_steps)
    row.dt = task.yardstick.end / std::ceil(task.yardstick.end / parameter * (1 - 1e-12));
  else
    row.tolerance = parameter;
  return row;
}

/// Whether another setting of the family, of as high an order, is better by far in every respect: then finer
/// settings of this line will be beaten, too.
bool is_beaten(const Row& row, const std::vector<Row>& rows) {
  const double far = 1.3;
  return std::any_of(rows.begin(), rows.end(), [&](const Row& other) {
    return other.ok() && other.method.family == row.method.family && other.method.order >= row.method.order &&
           other.errors.energy <= row.errors.energy && !(other.errors.trajectory > row.errors.trajectory) &&
           far * other.seconds <= row.seconds &&
           far * static_cast<double>(other.outcome.gradients) <= static_cast<double>(row.outcome.gradients);
  });
}

/// What the next setting of the line is expected to take. A tolerance is lowered by 10^⅓, and a method of
/// order 5 or more takes steps shorter by a sixth.
double calls_of_next(const Line& line, const Row& row) {
  return static_cast<double>(row.outcome.gradients) * (line.over_steps ? line.factor : 1.2);
}

/// Scans one line, the rows of which are added to the others'.
void scan_line(const Task& task, std::size_t index, const ScanOptions& options, std::vector<Row>& rows) {
  const Line& line = task.lines[index];
  const int patience = 3;
  int beaten = 0, level = 0, failed = 0, good = 0, taken = 0;
  double best = INFINITY, parameter = line.first;
  bool any = false;
  for (;; parameter /= line.factor) {
    if (line.over_steps && parameter > task.yardstick.end / 4) continue;
    Row row = observe(task, index, parameter, options);
    if (row.ok() && row.seconds < options.batch && !options.is_short)
      row.seconds = time_once(line, parameter, 0);
    const double error = row.errors.energy;
    if (row.ok()) {
      any = true;
      failed = 0;
      if (error < 1e-2) ++good;
      level = error < 1e-7 && error > 0.7 * best ? level + 1 : 0;
      best = std::min(best, error);
      beaten = error < 1e-2 && is_beaten(row, rows) ? beaten + 1 : 0;
    } else {
      ++failed;
    }
    ++taken;
    if (level >= patience || (any && best < 1e-15))
      row.line_end = "accuracy";
    else if (beaten >= 2)
      row.line_end = "beaten";
    else if ((row.ok() || line.over_steps) && calls_of_next(line, row) > task.most_calls)
      row.line_end = "calls";
    else if (failed > (options.is_short ? 60 : 20))
      row.line_end = "failures";
    else if (line.last > 0 && parameter / line.factor < line.last)
      row.line_end = "finest";
    else if (options.is_short && (good >= 2 || taken >= 60))
      row.line_end = "short";
    rows.push_back(row);
    if (!row.line_end.empty()) return;
  }
}

}  // namespace

const std::vector<double>& targets() {
  static const std::vector<double> list{1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12, 1e-13};
  return list;
}

double cost_of(const Row& row, Cost cost) {
  return cost == Cost::seconds ? row.seconds : static_cast<double>(row.outcome.gradients);
}

namespace {

/// An energy error of a tenth is not worth a point.
bool counts(const Row& row, const std::vector<std::string>& of_families, Cost cost, bool all = false) {
  return contains(of_families, row.method.family) && row.errors.energy < 0.1 &&
         (row.careful() || ((all || cost == Cost::gradients) && row.ok()));
}

}  // namespace

std::vector<std::size_t> front(const std::vector<Row>& rows, const std::vector<std::string>& of_families,
                               Cost cost, bool all) {
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < rows.size(); ++i)
    if (counts(rows[i], of_families, cost, all)) indices.push_back(i);
  std::sort(indices.begin(), indices.end(),
            [&](std::size_t a, std::size_t b) { return cost_of(rows[a], cost) < cost_of(rows[b], cost); });
  std::vector<std::size_t> best;
  double error = INFINITY;
  for (const std::size_t i : indices)
    if (rows[i].errors.energy < error) {
      error = rows[i].errors.energy;
      best.push_back(i);
    }
  return best;
}

const Row* cheapest(const std::vector<Row>& rows, const std::vector<std::string>& of_families, Cost cost,
                    double target, ErrorOf error) {
  const Row* best = nullptr;
  for (const Row& row : rows)
    if (counts(row, of_families, cost) && error(row) <= target &&
        (best == nullptr || cost_of(row, cost) < cost_of(*best, cost)))
      best = &row;
  return best;
}

std::vector<Row> scan(const Task& task, const ScanOptions& options) {
  // High orders first: they are what the low ones are beaten by.
  std::vector<std::size_t> order(task.lines.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return task.lines[a].method.order > task.lines[b].method.order;
  });
  std::vector<Row> rows;
  const double begin = cpu_seconds();
  int done = 0;
  for (const std::size_t i : order) {
    if (options.is_short && !task.lines[i].in_short) continue;
    scan_line(task, i, options, rows);
    if (++done % 50 == 0)
      std::cout << "  " << done << " of " << order.size() << " lines scanned in "
                << static_cast<int>(cpu_seconds() - begin) << " s\n"
                << std::flush;
  }
  return rows;
}

void time_carefully(const Task& task, std::vector<Row>& rows, const ScanOptions& options) {
  std::set<std::size_t> chosen;
  for (const Family& family : families()) {
    for (const std::size_t i : front(rows, {family.name}, Cost::seconds, true)) chosen.insert(i);
    for (const ErrorOf error : {energy_error, invariant_error, trajectory_error})
      for (const double target : targets()) {
        std::vector<std::size_t> good;
        for (std::size_t i = 0; i < rows.size(); ++i)
          if (rows[i].ok() && rows[i].method.family == family.name && error(rows[i]) <= target)
            good.push_back(i);
        std::sort(good.begin(), good.end(),
                  [&](std::size_t a, std::size_t b) { return rows[a].seconds < rows[b].seconds; });
        for (std::size_t k = 0; k < std::min(good.size(), options.rivals); ++k)
          if (rows[good[k]].seconds <= options.margin * rows[good.front()].seconds) chosen.insert(good[k]);
      }
  }
  std::cout << "  " << chosen.size() << " of " << rows.size() << " settings timed carefully\n" << std::flush;
  // In turns, so that a disturbance of the machine meets all alike.
  std::vector<std::vector<double>> seconds(rows.size());
  for (int round = 0; round < options.repetitions; ++round)
    for (const std::size_t i : chosen)
      seconds[i].push_back(time_once(task.lines[rows[i].line], rows[i].parameter, options.batch));
  for (const std::size_t i : chosen) {
    rows[i].seconds = median(seconds[i]);
    rows[i].timings = options.repetitions;
  }
}

std::vector<Row> long_runs(const Task& task, const std::vector<Row>& rows, double short_end,
                           const ScanOptions& options) {
  const double longer = task.yardstick.end / short_end, begin = cpu_seconds(), far = 20;
  /// Why a setting is not worth the time; empty where it is.
  const auto objection = [&](const Row& row) -> std::string {
    const double calls = static_cast<double>(row.outcome.gradients) * longer;
    if (calls > task.most_calls)
      return "not run: would take " + std::to_string(static_cast<std::int64_t>(calls)) + " calls";
    for (const Row& other : rows)
      if (other.careful() && other.errors.energy <= row.errors.energy && far * other.seconds < row.seconds)
        return "not run: far dearer than " + other.method.family;
    return "";
  };
  std::vector<Row> results;
  for (const Family& family : families()) {
    std::set<const Row*> chosen;
    for (const double target : targets())
      if (const Row* row = cheapest(rows, {family.name}, Cost::seconds, target)) chosen.insert(row);
    for (const Row* row : chosen) {
      const auto line = std::find_if(task.lines.begin(), task.lines.end(), [&](const Line& one) {
        return one.method.family == row->method.family && one.method.name == row->method.name &&
               one.method.options == row->method.options;
      });
      if (line == task.lines.end())
        throw std::runtime_error(task.name + ": " + row->method.name +
                                 " is not there any more; measure the shorter problem again");
      Row result{.line = static_cast<std::size_t>(line - task.lines.begin()),
                 .method = row->method,
                 .parameter = row->parameter,
                 .dt = row->dt,
                 .tolerance = row->tolerance,
                 .outcome = {.status = objection(*row)},
                 .errors = Errors{.energy = nan,
                                  .invariants = std::vector<double>(row->errors.invariants.size(), nan)}};
      if (result.outcome.status.empty()) {
        Watch watch(task.yardstick, 1000, task.most_calls);
        result.outcome = line->run(row->parameter, &watch);
        result.errors = watch.errors();
        result.seconds = watch.seconds_by_parts();
        result.timings = options.repetitions;
      }
      results.push_back(result);
    }
    std::cout << "  " << task.name << ", " << family.name << ": " << chosen.size() << " settings, "
              << static_cast<int>(cpu_seconds() - begin) << " s so far\n"
              << std::flush;
  }
  return results;
}

}  // namespace work_precision
