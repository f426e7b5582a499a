// What accuracy costs: energy error against CPU time and gradient calls, this library's methods and everybody
// else's, on eight problems and three of them for longer. See README.md in this folder.
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <numeric>
#include <stdexcept>
#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "common/arguments.hpp"
#include "common/output.hpp"
#include "report.hpp"
#include "scan.hpp"

namespace {

using namespace work_precision;

struct Entry {
  std::string name;
  Task (*make)(bool is_short);
  Task (*make_long)(bool is_short) = nullptr;  ///< with the best settings of the other

  std::string long_name() const { return make_long == nullptr ? "" : name + "_long"; }
};

const std::vector<Entry>& entries() {
  static const std::vector<Entry> list{{"product", product_task},
                                       {"nls5", nls5_task, nls5_long_task},
                                       {"nls1000", nls1000_task, nls1000_long_task},
                                       {"vortices10", vortices_task},
                                       {"vortices10_disparate", disparate_vortices_task},
                                       {"vortices300", vortices300_task, vortices300_long_task},
                                       {"magnetic_bottle", bottle_task},
                                       {"kerr", kerr_task}};
  return list;
}

Result result_of(const Task& task, std::vector<Row> rows) {
  Result result{.name = task.name,
                .title = task.title,
                .end = task.yardstick.end,
                .invariants = {},
                .rows = std::move(rows)};
  for (const auto& invariant : task.yardstick.invariants) result.invariants.push_back(invariant.name);
  return result;
}

Result run(const Task& task, const ScanOptions& options) {
  const double begin = cpu_seconds();
  std::cout << task.name << ": " << task.lines.size() << " lines, the state at the end "
            << (task.yardstick.last.empty()
                    ? "unknown"
                    : "to " + examples::formatted("%.0e", task.yardstick.last_unknown))
            << '\n'
            << std::flush;
  std::vector<Row> rows = scan(task, options);
  const double scanned = cpu_seconds();
  time_carefully(task, rows, options);
  std::cout << "  " << static_cast<int>(scanned - begin) << " s to scan, "
            << static_cast<int>(cpu_seconds() - scanned) << " s to time\n"
            << std::flush;
  return result_of(task, std::move(rows));
}

/// What the short run finds wrong: a gradient that is not the energy's, a family that never gets anywhere.
std::vector<std::string> faults(const Task& task, const Result& result) {
  std::vector<std::string> list;
  for (const Family& family : families()) {
    const auto is_one = [&](const auto& x) { return x.method.family == family.name; };
    if (std::none_of(task.lines.begin(), task.lines.end(), is_one)) continue;
    if (std::none_of(result.rows.begin(), result.rows.end(),
                     [&](const Row& row) { return is_one(row) && row.ok() && row.errors.energy < 1e-2; }))
      list.push_back(task.name + ": no setting of the family '" + family.name + "' comes near");
  }
  return list;
}

std::filesystem::path table_of(const std::filesystem::path& output, const std::string& name) {
  return output / "tables" / (name + ".csv");
}

void report(const std::filesystem::path& output, const Result& result, bool plot) {
  write_tables(output / "tables", result);
  if (plot) draw_result(output / "figures", result);
}

void write(const std::filesystem::path& output, const Result& result, bool plot) {
  for (const char* folder : {"tables", "figures", "scans"})
    std::filesystem::create_directories(output / folder);
  std::vector<std::size_t> all(result.rows.size());
  std::iota(all.begin(), all.end(), std::size_t{0});
  write_csv(output / "scans" / (result.name + ".csv"), result, all);
  write_csv(table_of(output, result.name), result, rows_to_keep(result.rows));
  report(output, result, plot);
}

/// All problems that were ever measured: they may be measured one by one. A table of an earlier program is
/// left out, and named.
std::vector<Result> measured(const std::filesystem::path& output, const std::vector<std::string>& names) {
  std::vector<Result> results;
  for (const std::string& name : names) {
    if (!std::filesystem::exists(table_of(output, name))) continue;
    try {
      results.push_back(read_csv(table_of(output, name)));
    } catch (const std::runtime_error& error) {
      std::cerr << "left out of the summary: " << error.what() << '\n';
    }
  }
  return results;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "What accuracy costs: scans every method over steps, tolerances and parameters, and writes tables "
      "(CSV, "
      "Markdown) and pictures of energy error against CPU time and gradient calls. Pin it to a core."};
  std::vector<std::string> known, chosen;
  for (const Entry& entry : entries()) {
    known.push_back(entry.name);
    if (entry.make_long != nullptr) known.push_back(entry.long_name());
  }
  std::filesystem::path output = "out/work_precision";
  bool is_short = false, no_plot = false, only_report = false;
  ScanOptions options;
  app.add_option("what", chosen, "problems; all if none is named: " + examples::joined(known))
      ->check(examples::one_of(known))
      ->type_name("NAME");
  app.add_option("--output", output, "folder for tables and figures")
      ->type_name("DIR")
      ->capture_default_str();
  app.add_option("--repetitions", options.repetitions, "of each careful timing")
      ->check(examples::whole_number(2, 1000))
      ->type_name("NUMBER")
      ->capture_default_str();
  app.add_flag("--short", is_short, "small problems and few settings: a test that everything runs");
  app.add_flag("--no-plot", no_plot, "leave the pictures out");
  app.add_flag("--report", only_report, "measure nothing: pages and figures from the CSV files of --output");

  return examples::run_program(app, argc, argv, [&] {
    if (only_report) {
      const std::vector<Result> results = measured(output, known);
      for (const Result& result : results) report(output, result, !no_plot);
      write_summary(output / "tables", results);
      return 0;
    }
    if (chosen.empty()) chosen = known;
    if (is_short) {
      options.is_short = true;
      options.samples = 20;
      options.batch = 0;
      options.repetitions = 2;
    }
    const auto wants = [&](const std::string& name) {
      return std::find(chosen.begin(), chosen.end(), name) != chosen.end();
    };
    std::vector<std::string> wrong;
    const auto keep = [&](const Result& result) {
      write(output, result, !no_plot);
      write_summary(output / "tables", measured(output, known));
    };
    for (const Entry& entry : entries()) {
      if (wants(entry.name)) {
        const Task task = entry.make(is_short);
        if (!(task.gradient_error < 1e-6))
          throw std::runtime_error(task.name + ": the gradient is not the energy's, off by " +
                                   std::to_string(task.gradient_error));
        const Result result = run(task, options);
        keep(result);
        const auto found = faults(task, result);
        if (is_short) wrong.insert(wrong.end(), found.begin(), found.end());
      }
      if (entry.make_long == nullptr || !wants(entry.long_name())) continue;
      const Task task = entry.make_long(is_short);
      const double begin = cpu_seconds();
      const Result shorter = read_csv(table_of(output, entry.name));
      keep(result_of(task, long_runs(task, shorter.rows, shorter.end, options)));
      std::cout << task.name << ": " << static_cast<int>(cpu_seconds() - begin) << " s\n" << std::flush;
    }
    std::cout << "tables: " << (output / "tables").string() << '\n';
    for (const std::string& fault : wrong) std::cerr << fault << '\n';
    return wrong.empty() ? 0 : 1;
  });
}
