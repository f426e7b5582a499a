#include "figures.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "common/output.hpp"
#include "methods.hpp"
#include "problems.hpp"

namespace paper {

namespace {

using examples::quoted;
using Panels = std::vector<std::vector<std::string>>;

const Panels against_tao{
    {"Tao 2", "semiexplicit 2"}, {"Tao 4", "semiexplicit 4"}, {"Tao 6", "semiexplicit 6"}};
const Panels against_others{{"Midpoint", "semiexplicit 2"},
                            {"IRK4", "semiexplicit 4", "semiexplicit-S 4"},
                            {"semiexplicit 6", "semiexplicit-S 6", "semiexplicit-Y 6"}};
const Panels bare_and_bound{{"Pihajoki 2", "Tao 2"}, {"Pihajoki 4", "Tao 4"}, {"Pihajoki 6", "Tao 6"}};

/// The eleven methods of the paper's plot of orders, and three that it did not have.
const Panels of_all_orders{{"Tao 2", "semiexplicit 2", "Midpoint", "Tao 4", "semiexplicit 4",
                            "semiexplicit-S 4", "IRK4", "Tao 6", "semiexplicit 6", "semiexplicit-S 6",
                            "semiexplicit-Y 6", "semiexplicit, Blanes-Moan 6", "semiexplicit, low defect 6",
                            "IRK6"}};

/// Whole numbers of steps in T = 100, about evenly spaced on the logarithmic axis.
const std::vector<double> order_steps{0.001, 0.002, 0.004, 0.005, 0.01, 0.02, 0.025, 0.04, 0.05, 0.1};

std::string colour(const std::string& name) {
  const Method& m = method(name);
  return m.family == Family::tao                          ? "#CC79A7"
         : m.family == Family::pihajoki                   ? "#D55E00"
         : m.family == Family::gauss                      ? "#E69F00"
         : m.scheme == "suzuki4" || m.scheme == "suzuki6" ? "#009E73"
         : m.scheme == "yoshida6"                         ? "#56B4E9"
         : m.scheme == "blanes_moan6"                     ? "#999999"
         : m.scheme == "low_defect6_s13"                  ? "#000000"
                                                          : "#0072B2";
}

std::string style(const std::string& name) { return "linecolor rgb '" + colour(name) + "' linewidth 1.5"; }

std::string points(int order) {
  return " pointtype " +
         std::to_string(order == 2   ? 7
                        : order == 4 ? 5
                                     : 9) +
         " dashtype " + std::to_string(order / 2);
}

/// A path as the script, which runs in the folder where the program ran, is to read it.
std::string data(const Results& results, const Experiment& e) { return quoted(results.file(e).string()); }

Experiment experiment(const Figure& figure, const std::string& method, double dt, bool as_published,
                      bool is_short) {
  const double steps = figure.time / dt;
  return {.problem = figure.problem,
          .method = method,
          .dt = dt,
          .time = dt * (is_short ? std::min(steps, 500.0) : steps),
          .epsilon = figure.epsilon,
          .solver = figure.solver,
          .as_published = as_published,
          .series = true};
}

std::string grid() {
  return "set grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\nset logscale y\nset format y "
         "'10^{%T}'\n";
}

std::string orders_script(const std::filesystem::path& folder, const Figure& figure, bool as_published,
                          bool is_short, const Results& results) {
  const std::filesystem::path csv = folder / (figure.name + ".csv");
  examples::write_whole(csv, [&](std::ostream& table) {
    table << "dt";
    for (const std::string& name : figure.panels.front()) table << ",\"" << name << '"';
    table << '\n';
    for (const double dt : order_steps) {
      table << dt;
      for (const std::string& name : figure.panels.front()) {
        const Result r = results.get(experiment(figure, name, dt, as_published, is_short));
        table << ',' << (r.ok() ? r.worst.front() : std::numeric_limits<double>::quiet_NaN());
      }
      table << '\n';
    }
  });
  std::ostringstream out;
  out << grid()
      << "set logscale x\nset format x '10^{%T}'\nset xrange [0.0009:0.11]\nset xlabel 'dt'\n"
         "set yrange [1e-16:10]\nset ylabel 'max |(H - H_0)/H_0|'\nset key outside right noenhanced "
         "Left reverse\nplot \\\n";
  for (const int order : {2, 4, 6})
    out << "  (x > 0.01 ? 3*x**" << order
        << " : NaN) with lines linecolor rgb '#aaaaaa' linewidth 4 title 'slope " << order << "', \\\n";
  for (std::size_t i = 0; i < figure.panels.front().size(); ++i)
    out << "  " << quoted(csv.string()) << " skip 1 using 1:" << i + 2 << " with linespoints "
        << style(figure.panels.front()[i]) << points(method(figure.panels.front()[i]).order) << " title "
        << quoted(figure.panels.front()[i]) << (i + 1 < figure.panels.front().size() ? ", \\\n" : "\n");
  return out.str();
}

/// A panel a row of methods and an invariant (or the defect), errors against time.
std::string time_script(const Figure& figure, bool as_published, bool is_short, const Results& results) {
  const bool of_defect = figure.kind == Figure::Kind::defect;
  const auto names = invariant_names(figure.problem);
  const std::size_t columns = of_defect ? 1 : names.size();
  const std::size_t rows = figure.panels.size();
  const double left = columns > 2 ? 0.085 : 0.115, right = 0.97, bottom = 0.075, top = 0.955, gap = 0.075;
  std::ostringstream out;
  out << grid() << "set multiplot layout " << rows << ',' << columns << " margins " << left << ',' << right
      << ',' << bottom << ',' << top << " spacing " << (columns > 2 ? 0.08 : 0.12) << ',' << gap
      << "\nset yrange [1e-16:*]\nset key off\n";
  if (of_defect)
    out << "set logscale x\nset xrange [" << figure.dt << ':' << figure.time << "]\nset format x '10^{%T}'\n";
  else
    out << "set xrange [0:*]\nset format x '%g'\n";
  for (std::size_t row = 0; row < rows; ++row)
    for (std::size_t i = 0; i < columns; ++i) {
      const std::size_t value = of_defect ? names.size() : i;
      out << "unset label\n"
          << (row + 1 == rows ? "set xlabel 't'\n" : "unset xlabel\n") << "set ylabel '"
          << (of_defect ? "‖(q, p) - (x, y)‖" : "|" + names[i] + "/" + names[i] + "_0 - 1|") << "'\n";
      std::ostringstream curves;
      const double above =
          top + 0.018 - static_cast<double>(row) * (top - bottom + gap) / static_cast<double>(rows);
      for (std::size_t m = 0; m < figure.panels[row].size(); ++m) {
        const std::string& name = figure.panels[row][m];
        const Experiment e = experiment(figure, name, figure.dt, as_published, is_short);
        const Result result = results.get(e);
        const std::string column = '$' + std::to_string(value + 2);
        curves << ", \\\n  " << data(results, e) << " using 1:(" << column << " > 0 ? " << column
               << " : NaN) with lines " << style(name) << " notitle";
        if (i == 0)  // the row's legend, above it
          out << "set label "
              << quoted(name + (result.ok() ? "" : ", fails at t = " + examples::formatted("%.3g", result.t)))
              << " at screen " << left + 0.3 * static_cast<double>(m) << ',' << above
              << " noenhanced textcolor rgb '" << colour(name) << "'\n";
      }
      out << "plot NaN notitle" << curves.str() << '\n';
    }
  out << "unset multiplot\n";
  return out.str();
}

}  // namespace

const std::vector<Figure>& figures() {
  using Kind = Figure::Kind;
  // The captions give no end time for the invariants; these are the times of the tables of the same runs.
  static const std::vector<Figure> list{
      {"exact-orders", Kind::orders, "product", 0, 100, 1e-15, "simplified", of_all_orders},
      {"Schrodinger_diff", Kind::defect, "nls", 1e-3, 1000, 1e-10, "simplified", bare_and_bound},
      {"Schrodinger_Inv_Tao", Kind::invariants, "nls", 1e-3, 1000, 1e-10, "simplified", against_tao},
      {"Schrodinger_Inv", Kind::invariants, "nls", 1e-3, 1000, 1e-13, "simplified", against_others},
      {"vortex_Inv_Tao", Kind::invariants, "vortices", 0.1, 1000, 1e-10, "simplified", against_tao},
      {"vortex_Inv", Kind::invariants, "vortices", 0.1, 1000, 1e-13, "simplified", against_others},
      {"Schrodinger_Inv_Tao_0.01", Kind::invariants, "nls", 1e-2, 1e4, 1e-10, "broyden", against_tao},
      {"Schrodinger_Inv_0.01", Kind::invariants, "nls", 1e-2, 1e4, 1e-13, "broyden", against_others},
      {"vortex_Inv_Tao_2nd", Kind::invariants, "disparate vortices", 0.01, 1000, 1e-10, "broyden",
       against_tao},
      {"vortex_Inv_2nd", Kind::invariants, "disparate vortices", 0.01, 1000, 1e-13, "broyden",
       against_others},
  };
  return list;
}

std::vector<Experiment> experiments(const Figure& figure, bool as_published, bool is_short) {
  std::vector<Experiment> list;
  for (const auto& row : figure.panels)
    for (const std::string& name : row)
      for (const double dt :
           figure.kind == Figure::Kind::orders ? order_steps : std::vector<double>{figure.dt})
        list.push_back(experiment(figure, name, dt, as_published, is_short));
  return list;
}

void draw_figure(const std::filesystem::path& folder, const Figure& figure, bool as_published, bool is_short,
                 const Results& results) {
  std::filesystem::create_directories(folder);
  const std::filesystem::path png = folder / (figure.name + ".png");
  const bool wide = figure.kind == Figure::Kind::invariants && invariant_names(figure.problem).size() > 2;
  const std::string prologue =
      examples::gnuplot_prologue(png, wide ? 1500 : 1100, figure.kind == Figure::Kind::orders ? 750 : 950);
  const std::string body = figure.kind == Figure::Kind::orders
                               ? orders_script(folder, figure, as_published, is_short, results)
                               : time_script(figure, as_published, is_short, results);
  examples::draw(png, prologue + body);
}

}  // namespace paper
