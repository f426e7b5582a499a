#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "scan.hpp"

namespace work_precision {

/// A problem with its results.
struct Result {
  std::string name, title;
  double end = 0;
  std::vector<std::string> invariants;
  std::vector<Row> rows;
};

/// These rows of the result.
void write_csv(const std::filesystem::path& file, const Result& result, const std::vector<std::size_t>& rows);

/// What tables, figures and longer runs need of such a file. Throws std::runtime_error for another one.
Result read_csv(const std::filesystem::path& file);

/// The rows that they need.
std::vector<std::size_t> rows_to_keep(const std::vector<Row>& rows);

/// `<name>.md`: who is first at every target, in CPU time and in gradient calls, and with what.
void write_tables(const std::filesystem::path& folder, const Result& result);

/// `summary.md`: the CPU times of all problems in short, for targets of the energy, the invariants and the
/// state at the end.
void write_summary(const std::filesystem::path& folder, const std::vector<Result>& results);

/// `<name>.png`: energy error against CPU time and against gradient calls.
void draw_result(const std::filesystem::path& folder, const Result& result);

/// As /proc/cpuinfo has it.
std::string processor_name();

}  // namespace work_precision
