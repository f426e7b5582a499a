#pragma once

#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "../common/results.hpp"
#include "../common/run.hpp"

namespace examples {

inline std::string style(const std::string& method) {
  if (method == "pihajoki") return "linecolor rgb '#D55E00' linewidth 2";
  if (method == "tao") return "linecolor rgb '#CC79A7' linewidth 2";
  if (method == "midpoint") return "linecolor rgb '#009E73' linewidth 2";
  return "linecolor rgb '#0072B2' linewidth 3";
}

inline std::string title(const Run& run) {
  const Method& method = run.method;
  const std::string what = method.name == "pihajoki"   ? "Pihajoki"
                           : method.name == "tao"      ? "Tao, ω = " + formatted("%g", method.omega)
                           : method.name == "midpoint" ? "midpoint projection"
                           : method.name == "gauss"    ? "Gauss-Legendre"
                                                       : "semiexplicit";
  const std::string end = !run.failure.empty() ? ", fails at t = " + formatted("%.3g", run.report.t)
                          : !run.doubt.empty() ? ", NO RESULT"
                                               : "";
  return what + " (" + method.coefficients() + ")" + end;
}

/// Energy, mass and defect in three panels.
inline std::string script(const std::filesystem::path& png, const std::filesystem::path& csv,
                          const std::vector<Run>& runs, const std::string& headline, double time, double dt,
                          bool logarithmic_time) {
  const std::vector<std::string> labels{
      "relative energy error", "relative mass error",
      "distance of the copies\\n{/*0.8 (projected: before they are joined)}"};
  std::vector<std::vector<Curve>> panels(labels.size());
  std::size_t csv_column = 2;
  for (const Run& run : runs)
    for (std::size_t i = 0; i < run.quantities.size(); ++i)
      panels[i].push_back({&run, i, csv_column++, title(run), style(run.method.name)});
  if (panels.back().empty()) panels.pop_back();

  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1400) << "set multiplot layout " << panels.size()
      << ",1 margins 0.13,0.97,0.065,0.885 spacing 0,0.03 title " << quoted(headline)
      << " noenhanced font ',20'\n"
      << "set key at screen 0.55,0.945 center top vertical maxrows 2 Left reverse samplen 3 width -6 "
         "noenhanced\n"
      << "set datafile missing 'nan'\nset logscale y\nset format y '10^{%T}'\nset grid linetype 1 linewidth "
         "0.5 linecolor rgb "
         "'#d8d8d8'\n";
  if (logarithmic_time)  // of one step there is one point, in the middle
    out << "set logscale x\nset xrange [" << (dt < time ? dt : dt / 2) << ':' << (dt < time ? time : 2 * dt)
        << "]\n";
  else
    out << "set xrange [0:" << time << "]\n";
  for (std::size_t i = 0; i < panels.size(); ++i) {
    if (i + 1 < panels.size())
      out << "set format x ''\n";
    else
      out << "set format x " << (logarithmic_time ? "'10^{%T}'" : "'%g'") << "\nset xlabel 'time'\n";
    out << panel(csv, labels[i], panels[i]) << "set key off\n";
  }
  out << "unset multiplot\n";
  return out.str();
}

}  // namespace examples
