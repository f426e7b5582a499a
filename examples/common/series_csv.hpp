#pragma once

#include <algorithm>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include "run.hpp"

namespace examples {

/// Writes the series of runs that kept the same rows side by side. Where there is more than one, their columns begin
/// with the method's name; behind the end of a run that failed early stands nan.
inline void write_series(const std::filesystem::path& path, const std::vector<Run>& runs) {
  std::vector<std::string> names{"t"};
  for (const Run& run : runs)
    for (const std::string& name : run.series.names)
      names.push_back(runs.size() > 1 ? run.method.name + "_" + name : name);

  const std::vector<double>& t = std::max_element(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
                                   return a.series.t.size() < b.series.t.size();
                                 })->series.t;
  CsvWriter csv(path, names);
  for (std::size_t row = 0; row < t.size(); ++row) {
    std::vector<double> values{t[row]};
    for (const Run& run : runs)
      for (const auto& column : run.series.columns)
        values.push_back(row < column.size() ? column[row] : std::numeric_limits<double>::quiet_NaN());
    csv.row(values);
  }
  csv.commit();
}

}  // namespace examples
