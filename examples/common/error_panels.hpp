#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "gnuplot.hpp"
#include "run.hpp"

namespace examples {

/// A curve of a picture: a column of a run's series.
struct Curve {
  const Run* run;
  std::size_t column;      ///< in the series
  std::size_t csv_column;  ///< in the file, counted from 1
  std::string title;
  std::string style;

  const std::vector<double>& values() const { return run->series.columns[column]; }
  bool visible() const {
    return std::any_of(values().begin(), values().end(), [](double v) { return v > 0 && std::isfinite(v); });
  }
};

/// The decades that hold the curves, within reason: what has failed may leave the panel at the top.
inline std::string decades(const std::vector<Curve>& curves) {
  double low = 1e-15, high = 1e-15;
  bool first = true;
  for (const Curve& curve : curves)
    for (const double v : curve.values())
      if (v > 0 && std::isfinite(v)) {
        low = first ? v : std::min(low, v);
        high = first ? v : std::max(high, v);
        first = false;
      }
  const int bottom = std::clamp(static_cast<int>(std::floor(std::log10(low))), -17, 0);
  const int top = std::clamp(static_cast<int>(std::ceil(std::log10(high))), bottom + 1, 2);
  return "[1e" + std::to_string(bottom) + ":1e" + std::to_string(top) + "]";
}

/// The gnuplot lines that draw curves against time in one panel, with logarithmic errors. The label is gnuplot's own text.
inline std::string panel(const std::filesystem::path& csv, const std::string& label,
                         const std::vector<Curve>& curves) {
  std::ostringstream out;
  out << "set ylabel \"" << label << "\"\nset yrange " << decades(curves) << "\nunset label\n";
  for (const Curve& curve : curves)
    if (!curve.run->failure.empty())  // a cross where the run ended
      out << "set label '' at first " << curve.run->report.t << ", graph 0.97 point pointtype 2 pointsize 2 "
          << curve.style << '\n';
  // The empty plot makes a panel without any visible curve legal.
  out << "plot NaN notitle";
  for (const Curve& curve : curves)
    if (curve.visible())
      out << ", \\\n  " << quoted(csv.string()) << " skip 1 using 1:($" << curve.csv_column << " > 0 ? $"
          << curve.csv_column << " : NaN) with lines " << curve.style << " title " << quoted(curve.title);
  out << '\n';
  return out.str();
}

}  // namespace examples
