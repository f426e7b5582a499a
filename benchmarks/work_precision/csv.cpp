#include <charconv>
#include <ostream>

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
    out << "problem,family,method,options,order,dt,tolerance,status,t,steps,gradients,seconds,timings,energy_"
           "error,energy_error_first_half,energy_error_second_half,drift";
    for (const std::string& name : result.invariants) out << ',' << name << "_error";
    out << ",trajectory_error,line_end\n";
    for (const std::size_t i : rows) {
      const Row& row = result.rows[i];
      out << result.name << ',' << text(row.method.family) << ',' << text(row.method.name) << ','
          << text(row.method.options) << ',' << row.method.order << ',' << digits(row.dt) << ','
          << digits(row.tolerance) << ',' << text(row.outcome.status) << ',' << digits(row.outcome.t) << ','
          << row.outcome.steps << ',' << row.outcome.gradients << ',' << digits(row.seconds) << ','
          << row.timings << ',' << digits(row.errors.energy) << ',' << digits(row.errors.first_half) << ','
          << digits(row.errors.second_half) << ','
          << (!row.ok()             ? "failed"
              : row.errors.drifts() ? "drifting"
                                    : "bounded");
      for (const double error : row.errors.invariants) out << ',' << digits(error);
      out << ',' << digits(row.errors.trajectory) << ',' << row.line_end << '\n';
    }
  });
}

}  // namespace work_precision
