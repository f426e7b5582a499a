#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <limits>
#include <ostream>

#include "common/output.hpp"
#include "report.hpp"

namespace work_precision {

namespace {

using examples::formatted;

std::vector<std::string> family_names(bool ours) {
  std::vector<std::string> names;
  for (const Family& family : families())
    if (family.ours == ours) names.push_back(family.name);
  return names;
}

std::vector<std::string> families_in_library(bool inside) {
  std::vector<std::string> names;
  for (const Family& family : families())
    if (family.in_library == inside) names.push_back(family.name);
  return names;
}

/// Three digits, in milliseconds or in calls.
std::string cost_text(const Row* row, Cost cost) {
  if (row == nullptr) return "–";
  const double value = cost_of(*row, cost);
  return cost == Cost::seconds ? formatted("%.3g", 1e3 * value)
                               : std::to_string(static_cast<long long>(value));
}

std::string setting(const Row& row) {
  std::string text = row.method.name;
  if (!row.method.options.empty()) text += ", " + row.method.options;
  text += row.dt > 0 ? formatted(", dt = %.4g", row.dt) : formatted(", %.2g", row.tolerance);
  return text + (row.errors.drifts() ? ", drifting" : "");
}

/// How many times cheaper ours is than the best rival: above 1 ours is first. Where only one side reaches the
/// target it is infinite or zero, where none does NaN.
double advantage(const std::vector<Row>& rows, Cost cost, double target,
                 const std::vector<std::string>& rivals,
                 const std::vector<std::string>& of_us = family_names(true), ErrorOf error = energy_error) {
  const Row* own = cheapest(rows, of_us, cost, target, error);
  const Row* rival = cheapest(rows, rivals, cost, target, error);
  if (own == nullptr) return rival == nullptr ? nan : 0;
  return rival == nullptr ? INFINITY : cost_of(*rival, cost) / cost_of(*own, cost);
}

std::string factor_text(double factor) {
  if (std::isnan(factor)) return "–";
  if (std::isinf(factor)) return "only ours";
  return factor == 0 ? "only rivals" : formatted("%.2f", factor);
}

/// Families that have at least one setting here, in their order.
std::vector<std::string> present(const std::vector<Row>& rows) {
  std::vector<std::string> names;
  for (const Family& family : families())
    if (std::any_of(rows.begin(), rows.end(), [&](const Row& r) { return r.method.family == family.name; }))
      names.push_back(family.name);
  return names;
}

void write_costs(std::ostream& out, const Result& result, Cost cost) {
  const std::vector<std::string> names = present(result.rows);
  out << "| energy error |";
  for (const std::string& name : names) out << ' ' << name << " |";
  out << " first | best rival / ours |\n|" << std::string(2, '-') << '|';
  for (std::size_t i = 0; i < names.size() + 2; ++i) out << "--|";
  out << '\n';
  for (const double target : targets()) {
    const Row* first = cheapest(result.rows, names, cost, target);
    out << "| " << formatted("%.0e", target) << " |";
    for (const std::string& name : names) {
      const Row* row = cheapest(result.rows, {name}, cost, target);
      const std::string text = cost_text(row, cost);
      out << ' ' << (row != nullptr && row == first ? "**" + text + "**" : text) << " |";
    }
    out << ' ' << (first == nullptr ? "–" : first->method.family) << " | "
        << factor_text(advantage(result.rows, cost, target, family_names(false))) << " |\n";
  }
}

/// The errors of a run besides that of the energy.
std::string other_errors(const Result& result, const Row& row) {
  std::string text;
  for (std::size_t i = 0; i < result.invariants.size(); ++i)
    text += "; " + result.invariants[i] + formatted(" %.0e", row.errors.invariants[i]);
  if (!std::isnan(row.errors.trajectory)) text += formatted("; trajectory %.0e", row.errors.trajectory);
  std::replace(text.begin(), text.end(), '_', ' ');
  return text;
}

/// What the winners are.
void write_settings(std::ostream& out, const Result& result) {
  out << "| energy error | ours | best rival |\n|--|--|--|\n";
  for (const double target : targets()) {
    out << "| " << formatted("%.0e", target) << " |";
    for (const bool ours : {true, false}) {
      const Row* row = cheapest(result.rows, family_names(ours), Cost::seconds, target);
      out << ' '
          << (row == nullptr ? "–" : row->method.family + ": " + setting(*row) + other_errors(result, *row))
          << " |";
    }
    out << '\n';
  }
}

/// The levels of the summary.
const std::vector<double>& levels() {
  static const std::vector<double> list{1e-4, 1e-6, 1e-8, 1e-10, 1e-12};
  return list;
}

/// How often the library is first, and by how much where accuracy is asked for.
void write_count(std::ostream& out, const std::vector<Result>& results, ErrorOf error) {
  int reached = 0, first = 0, tight = 0, far = 0;
  for (const Result& result : results)
    for (const double level : levels()) {
      const double factor = advantage(result.rows, Cost::seconds, level, families_in_library(false),
                                      families_in_library(true), error);
      if (std::isnan(factor)) continue;
      ++reached;
      if (factor >= 1) ++first;
      if (level > 1e-8) continue;
      ++tight;
      if (factor >= 1.5) ++far;
    }
  out << "\nThe library is first at " << first << " of the " << reached
      << " targets that anyone meets, and by 1.5 times or more at " << far << " of the " << tight
      << " from 1e-08 on.\n";
}

/// A line a problem where there is such an error: the cheapest of these and of those at some targets.
void write_fronts(std::ostream& out, const std::vector<Result>& results,
                  const std::vector<std::string>& of_us, const std::vector<std::string>& rivals,
                  ErrorOf error = energy_error) {
  out << "| problem |";
  for (const double level : levels()) out << formatted(" %.0e |", level);
  out << "\n|--|--|--|--|--|--|\n";
  for (const Result& result : results) {
    if (std::none_of(result.rows.begin(), result.rows.end(),
                     [&](const Row& row) { return std::isfinite(error(row)); }))
      continue;
    out << "| " << result.title << " |";
    for (const double level : levels()) {
      const Row* own = cheapest(result.rows, of_us, Cost::seconds, level, error);
      const Row* rival = cheapest(result.rows, rivals, Cost::seconds, level, error);
      const double factor = advantage(result.rows, Cost::seconds, level, rivals, of_us, error);
      const auto who = [](const Row* row) { return row == nullptr ? "" : " " + row->method.family; };
      out << ' ' << cost_text(own, Cost::seconds) << who(own) << " / " << cost_text(rival, Cost::seconds)
          << who(rival) << ": " << (factor >= 1 ? "**" : "") << factor_text(factor)
          << (factor >= 1 ? "**" : "") << " |";
    }
    out << '\n';
  }
}

}  // namespace

std::string processor_name() {
  std::ifstream in("/proc/cpuinfo");
  for (std::string line; std::getline(in, line);)
    if (line.rfind("model name", 0) == 0) return line.substr(line.find(':') + 2);
  return "an unknown processor";
}

void write_tables(const std::filesystem::path& folder, const Result& result) {
  examples::write_whole(folder / (result.name + ".md"), [&](std::ostream& out) {
    out << "# " << result.title << ", t = 0 to " << formatted("%g", result.end) << "\n\n"
        << "Cheapest measured setting of each family whose largest relative energy error is within the "
           "target.\n"
           "Processor: "
        << processor_name() << ", one core.\n\n## CPU time, milliseconds\n\n";
    write_costs(out, result, Cost::seconds);
    out << "\n## Gradient calls\n\n";
    write_costs(out, result, Cost::gradients);
    out << "\n## The settings that were fastest\n\n";
    write_settings(out, result);
  });
}

void write_summary(const std::filesystem::path& folder, const std::vector<Result>& results) {
  examples::write_whole(folder / "summary.md", [&](std::ostream& out) {
    out << "Processor: " << processor_name()
        << ", one core. CPU time in milliseconds, cheapest of the library / cheapest outside it, who these "
           "are,\n"
           "and (time outside) / (time of the library). The Gauss methods are the library's, too.\n\n";
    const auto of_library = [&](ErrorOf error) {
      write_fronts(out, results, families_in_library(true), families_in_library(false), error);
      write_count(out, results, error);
    };
    of_library(energy_error);
    out << "\nThe semiexplicit methods alone: ours / best rival, the library's Gauss methods among "
           "these.\n\n";
    write_fronts(out, results, family_names(true), family_names(false));
    out << "\nThe library as a whole, by the largest error of the other invariants (mass, impulses, angular "
           "momentum, Carter's constant).\n\n";
    of_library(invariant_error);
    out << "\nThe same by the error of the state at the end, where a reference has one. A target near what "
           "the "
           "reference may be off by is met by nobody.\n\n";
    of_library(trajectory_error);
  });
}

}  // namespace work_precision
