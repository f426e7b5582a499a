#include <algorithm>
#include <charconv>
#include <fstream>
#include <map>
#include <ostream>
#include <set>
#include <stdexcept>

#include "common/output.hpp"
#include "report.hpp"

namespace work_precision {

namespace {

/// As many digits as it takes to read it back; NaN is "nan".
std::string digits(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// A text that may contain commas.
std::string text(const std::string& value) { return '"' + value + '"'; }

}  // namespace

void write_csv(const std::filesystem::path& file, const Result& result,
               const std::vector<std::size_t>& rows) {
  examples::write_whole(file, [&](std::ostream& out) {
    out << "problem,title,end,family,method,options,order,dt,tolerance,status,t,steps,gradients,seconds,"
           "timings,energy_error,energy_error_first_half,energy_error_second_half,drift";
    for (const std::string& name : result.invariants) out << ',' << name << "_error";
    out << ",trajectory_error,line_end\n";
    for (const std::size_t i : rows) {
      const Row& row = result.rows[i];
      out << result.name << ',' << text(result.title) << ',' << digits(result.end) << ','
          << text(row.method.family) << ',' << text(row.method.name) << ',' << text(row.method.options) << ','
          << row.method.order << ',' << digits(row.dt) << ',' << digits(row.tolerance) << ','
          << text(row.outcome.status) << ',' << digits(row.outcome.t) << ',' << row.outcome.steps << ','
          << row.outcome.gradients << ',' << digits(row.seconds) << ',' << row.timings << ','
          << digits(row.errors.energy) << ',' << digits(row.errors.first_half) << ','
          << digits(row.errors.second_half) << ','
          << (!row.ok()             ? "failed"
              : row.errors.drifts() ? "drifting"
                                    : "bounded");
      for (const double error : row.errors.invariants) out << ',' << digits(error);
      out << ',' << digits(row.errors.trajectory) << ',' << row.line_end << '\n';
    }
  });
}

namespace {

/// The fields of a line of such a file, without quotes.
std::vector<std::string> fields(const std::string& line) {
  std::vector<std::string> list(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == ',' && !quoted)
      list.emplace_back();
    else
      list.back() += c;
  }
  return list;
}

bool is_invariant(const std::string& name) {
  return name.ends_with("_error") && name != "energy_error" && name != "trajectory_error";
}

}  // namespace

Result read_csv(const std::filesystem::path& file) try {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> names = fields(line);
  Result result;
  for (const std::string& name : names)
    if (is_invariant(name)) result.invariants.push_back(name.substr(0, name.rfind("_error")));
  while (std::getline(in, line)) {
    const std::vector<std::string> values = fields(line);
    std::map<std::string, std::string> cell;
    Row row;
    for (std::size_t i = 0; i < std::min(names.size(), values.size()); ++i) {
      cell[names[i]] = values[i];
      if (is_invariant(names[i])) row.errors.invariants.push_back(std::stod(values[i]));
    }
    result.name = cell.at("problem");
    result.title = cell.at("title");
    result.end = std::stod(cell.at("end"));
    row.method = {cell.at("family"), cell.at("method"), cell.at("options"), std::stoi(cell.at("order"))};
    row.dt = std::stod(cell.at("dt"));
    row.tolerance = std::stod(cell.at("tolerance"));
    row.parameter = row.dt > 0 ? row.dt : row.tolerance;
    row.outcome.status = cell.at("status");
    row.outcome.gradients = std::stoll(cell.at("gradients"));
    row.seconds = std::stod(cell.at("seconds"));
    row.timings = std::stoi(cell.at("timings"));
    row.errors.energy = std::stod(cell.at("energy_error"));
    row.errors.first_half = std::stod(cell.at("energy_error_first_half"));
    row.errors.second_half = std::stod(cell.at("energy_error_second_half"));
    row.errors.trajectory = std::stod(cell.at("trajectory_error"));
    result.rows.push_back(row);
  }
  return result;
} catch (const std::logic_error&) {  // a column or a number is missing
  throw std::runtime_error(file.string() + ": is no table of this program; measure that problem again");
}

std::vector<std::size_t> rows_to_keep(const std::vector<Row>& rows) {
  std::set<std::size_t> kept;
  for (const Family& family : families()) {
    for (const Cost cost : {Cost::seconds, Cost::gradients})
      for (const std::size_t i : front(rows, {family.name}, cost)) kept.insert(i);
    for (const ErrorOf error : {energy_error, invariant_error, trajectory_error})
      for (const double target : targets())
        if (const Row* row = cheapest(rows, {family.name}, Cost::seconds, target, error))
          kept.insert(static_cast<std::size_t>(row - rows.data()));
  }
  return {kept.begin(), kept.end()};
}

}  // namespace work_precision
