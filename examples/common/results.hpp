#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <iomanip>
#include <iostream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "output.hpp"
#include "run.hpp"

namespace examples {

/// "angular_momentum" without the strokes.
inline std::string in_words(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

/// One column a run, one line a figure.
inline void print_table(std::ostream& out, const std::vector<Run>& runs, double dt) {
  using Entry = std::function<std::string(const Run&)>;
  std::vector<std::size_t> widths(runs.size() + 1, 0);
  std::vector<std::vector<std::string>> lines;
  const auto line = [&](const std::string& name, const Entry& entry) {
    lines.push_back({name});
    for (const Run& run : runs) lines.back().push_back(entry(run));
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], lines.back()[i].size());
  };
  const auto unless_failed = [](const Run& run, const std::string& figure) {
    return run.failure.empty() ? figure : "FAILED at t = " + formatted("%.3g", run.report.t);
  };
  const auto a_step = [](const char* format, const Run& run, std::int64_t count) {
    return run.failure.empty()
               ? formatted(format, static_cast<double>(count) / static_cast<double>(run.report.steps))
               : "-";
  };
  line("", [](const Run& run) { return run.method.name; });
  line("scheme", [](const Run& run) { return run.method.coefficients(); });
  line("dt", [&](const Run&) { return formatted("%g", dt); });
  std::vector<Run::Quantity> most;
  for (const Run& run : runs)
    if (run.quantities.size() > most.size()) most = run.quantities;
  for (std::size_t i = 0; i < most.size(); ++i)
    for (const auto& [when, which] :
         {std::pair(", worst", &Run::Quantity::worst), std::pair(", final", &Run::Quantity::final)})
      line(in_words(most[i].column()) + when, [&, which = which](const Run& run) {
        return i < run.quantities.size() ? unless_failed(run, formatted("%.1e", run.quantities[i].*which))
                                         : "-";
      });
  line("gradient calls", [](const Run& run) { return std::to_string(run.report.gradients); });
  line("calls per step", [&](const Run& run) { return a_step("%.1f", run, run.report.gradients); });
  line("evaluations per step", [&](const Run& run) { return a_step("%.2f", run, run.report.evaluations); });
  line("seconds", [](const Run& run) { return formatted("%.3f", run.report.seconds); });
  line("status", [&](const Run& run) {
    return unless_failed(run, (run.doubt.empty() ? "t = " : "WRONG, t = ") + formatted("%g", run.report.t));
  });
  for (const auto& cells : lines) {
    out << std::left << std::setw(static_cast<int>(widths[0])) << cells[0] << std::right;
    for (std::size_t i = 1; i < cells.size(); ++i)
      out << "  " << std::setw(static_cast<int>(widths[i])) << cells[i];
    out << '\n';
  }
}

/// Writes the rows of runs side by side. Where there is more than one, their columns begin with the method's
/// name; where a run has no row at that time, as behind the end of one that failed, stands nan.
inline void write_series(const std::filesystem::path& path, const std::vector<Run>& runs) {
  std::vector<std::string> names{"t"};
  std::set<double> times;
  for (const Run& run : runs) {
    times.insert(run.t.begin(), run.t.end());
    for (const auto& quantity : run.quantities)
      names.push_back((runs.size() > 1 ? run.method.name + "_" : "") + quantity.column());
  }
  CsvWriter csv(path, names);
  std::vector<std::size_t> next(runs.size(), 0);
  for (const double t : times) {
    std::vector<double> values{t};
    for (std::size_t i = 0; i < runs.size(); ++i) {
      const bool is_there = next[i] < runs[i].t.size() && runs[i].t[next[i]] == t;
      for (const auto& quantity : runs[i].quantities)
        values.push_back(is_there ? quantity.rows[next[i]] : std::numeric_limits<double>::quiet_NaN());
      next[i] += is_there ? 1 : 0;
    }
    csv.row(values);
  }
  csv.commit();
}

/// A curve of a picture: a quantity of a run, and its column in the file, counted from 1.
struct Curve {
  const Run* run;
  std::size_t quantity, csv_column;
  std::string title, style;

  const std::vector<double>& values() const { return run->quantities[quantity].rows; }
  static bool visible(double value) { return value > 0 && std::isfinite(value); }
};

/// The gnuplot lines that draw curves against time in one panel, with logarithmic errors. The label is
/// gnuplot's own text. The decades hold the curves, within reason: what has failed may leave the panel at the
/// top.
inline std::string panel(const std::filesystem::path& csv, const std::string& label,
                         const std::vector<Curve>& curves) {
  std::vector<double> shown;
  for (const Curve& curve : curves)
    std::copy_if(curve.values().begin(), curve.values().end(), std::back_inserter(shown), Curve::visible);
  if (shown.empty()) shown = {1e-15};
  const auto [low, high] = std::minmax_element(shown.begin(), shown.end());
  const int bottom = std::clamp(decimal_place(*low), -17, 0);
  const int top = std::clamp(static_cast<int>(std::ceil(std::log10(*high) + 0.1)), bottom + 1, 2);
  std::ostringstream out;
  out << "set ylabel \"" << label << "\"\nset yrange [1e" << bottom << ":1e" << top << "]\nunset label\n";
  for (const Curve& curve : curves)
    if (!curve.run->failure.empty())  // a cross where the run ended
      out << "set label '' at first " << curve.run->report.t << ", graph 0.97 point pointtype 2 pointsize 2 "
          << curve.style << '\n';
  out << "plot NaN notitle";  // which makes a panel without any visible curve legal
  for (const Curve& curve : curves)
    if (std::any_of(curve.values().begin(), curve.values().end(), Curve::visible))
      out << ", \\\n  " << quoted(csv.string()) << " skip 1 using 1:($" << curve.csv_column << " > 0 ? $"
          << curve.csv_column << " : NaN) with lines " << curve.style << " title " << quoted(curve.title);
  out << '\n';
  return out.str();
}

}  // namespace examples
