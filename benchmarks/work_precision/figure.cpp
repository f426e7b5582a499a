#include <sstream>

#include "common/output.hpp"
#include "report.hpp"

namespace work_precision {

namespace {

using examples::quoted;

/// The points of a front as a block of data within the script; false: there are none.
bool write_block(std::ostream& out, const std::string& name, const Result& result,
                 const std::vector<std::string>& of_families, Cost cost) {
  const auto indices = front(result.rows, of_families, cost);
  if (indices.empty()) return false;
  out << '$' << name << " << END\n";
  for (const std::size_t i : indices)
    out << cost_of(result.rows[i], cost) << ',' << result.rows[i].errors.energy << '\n';
  out << "END\n";
  return true;
}

}  // namespace

void draw_result(const std::filesystem::path& folder, const Result& result) {
  const std::filesystem::path png = folder / (result.name + ".png");
  std::ostringstream blocks, panels;
  std::vector<std::string> everybody;
  for (const Family& family : families()) everybody.push_back(family.name);
  int panel = 0;
  for (const Cost cost : {Cost::seconds, Cost::gradients}) {
    const bool is_time = cost == Cost::seconds;
    std::ostringstream curves;
    const std::string suffix = is_time ? "_time" : "_calls";
    if (write_block(blocks, "all" + suffix, result, everybody, cost))
      curves << ", \\\n  $all" << suffix
             << " using 1:2 with lines linecolor rgb '#dddddd' linewidth 9 title 'first of all'";
    for (std::size_t k = 0; k < families().size(); ++k) {
      const Family& family = families()[k];
      const std::string name = "family" + std::to_string(k) + suffix;
      if (!write_block(blocks, name, result, {family.name}, cost)) continue;
      curves << ", \\\n  $" << name << " using 1:2 with linespoints linecolor rgb '" << family.colour
             << "' linewidth " << (family.ours ? 2 : 1.2) << " pointtype " << (family.ours ? 7 : 4)
             << " pointsize 0.6 title " << quoted(family.name);
    }
    panels << (is_time ? "set key off\nset xlabel 'CPU time in seconds'\nset ylabel 'largest relative energy "
                         "error' offset 0.5\n"
                       : "set key at screen 0.77,0.9 left top Left reverse noenhanced\nset xlabel 'gradient "
                         "calls'\nunset "
                         "ylabel\n")
           << "set lmargin at screen " << (panel == 0 ? 0.085 : 0.445) << "\nset rmargin at screen "
           << (panel == 0 ? 0.39 : 0.76) << "\nplot NaN notitle" << curves.str() << '\n';
    ++panel;
  }
  std::ostringstream script;
  script << examples::gnuplot_prologue(png, 1650, 620) << blocks.str()
         << "set grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\nset logscale xy\nset format "
            "'10^{%T}'\nset yrange [1e-15:1]\nset multiplot layout 1,2 title "
         << quoted(result.title) << "\nset bmargin at screen 0.12\nset tmargin at screen 0.92\n"
         << panels.str() << "unset multiplot\n";
  examples::draw(png, script.str());
}

}  // namespace work_precision
