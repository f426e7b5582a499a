#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <iomanip>
#include <iostream>
#include <string>
#include <vector>

#include "run.hpp"

namespace examples {

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
  char text[200];
  std::snprintf(text, sizeof text, format, numbers...);
  return text;
}

/// Says on stderr why a run is no result; false: it is one.
inline bool tell_failure(const Run& run) {
  const std::string& why = run.failure.empty() ? run.doubt : run.failure;
  if (!why.empty()) std::cerr << run.method.name << ": " << why << '\n';
  return !why.empty();
}

/// One column a run, one line a figure.
inline void print_table(std::ostream& out, const std::vector<Run>& runs, double dt) {
  std::vector<std::vector<std::string>> lines;
  const auto line = [&](const std::string& name, const std::function<std::string(const Run&)>& entry) {
    lines.push_back({name});
    for (const Run& run : runs) lines.back().push_back(entry(run));
  };

  const auto failed = [](const Run& run) { return "FAILED at t = " + formatted("%.3g", run.report.t); };
  const auto a_step = [](const char* format, const Run& run, std::int64_t count) {
    return run.failure.empty()
               ? formatted(format, static_cast<double>(count) / static_cast<double>(run.report.steps))
               : std::string("-");
  };
  line("", [](const Run& run) { return run.method.name; });
  line("scheme", [](const Run& run) { return run.method.coefficients(); });
  line("dt", [&](const Run&) { return formatted("%g", dt); });
  const auto& most = std::max_element(runs.begin(), runs.end(), [](const Run& a, const Run& b) {
                       return a.quantities.size() < b.quantities.size();
                     })->quantities;
  for (std::size_t i = 0; i < most.size(); ++i) {
    std::string what = most[i].name == "defect" ? "defect" : most[i].name + " error";
    std::replace(what.begin(), what.end(), '_', ' ');
    const auto entry = [&](double Run::Quantity::*which) {
      return [=](const Run& run) {
        if (i >= run.quantities.size()) return std::string("-");
        return run.failure.empty() ? formatted("%.1e", run.quantities[i].*which) : failed(run);
      };
    };
    line(what + ", worst", entry(&Run::Quantity::worst));
    line(what + ", final", entry(&Run::Quantity::final));
  }
  line("gradient calls", [](const Run& run) { return std::to_string(run.report.gradients); });
  line("calls per step", [&](const Run& run) { return a_step("%.1f", run, run.report.gradients); });
  line("evaluations per step", [&](const Run& run) { return a_step("%.2f", run, run.report.evaluations); });
  line("seconds", [](const Run& run) { return formatted("%.3f", run.report.seconds); });
  line("status", [&](const Run& run) {
    if (!run.failure.empty()) return failed(run);
    return (run.doubt.empty() ? "t = " : "WRONG, t = ") + formatted("%g", run.report.t);
  });

  std::vector<std::size_t> widths(runs.size() + 1, 0);
  for (const auto& cells : lines)
    for (std::size_t i = 0; i < cells.size(); ++i) widths[i] = std::max(widths[i], cells[i].size());
  for (const auto& cells : lines) {
    out << std::left << std::setw(static_cast<int>(widths[0])) << cells[0] << std::right;
    for (std::size_t i = 1; i < cells.size(); ++i)
      out << "  " << std::setw(static_cast<int>(widths[i])) << cells[i];
    out << '\n';
  }
}

}  // namespace examples
