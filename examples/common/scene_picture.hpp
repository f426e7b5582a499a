#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "error_panels.hpp"
#include "gnuplot.hpp"
#include "run.hpp"

namespace examples {

/// How a program shows states: the columns of its trajectory file behind t, and the upper part of its picture.
template <int Dof>
struct View {
  using Half = ConstRef<double, Dof>;

  std::vector<std::string> columns;
  /// Appends a number for each column.
  std::function<void(const Half& q, const Half& p, std::vector<double>& row)> append;
  /// gnuplot's lines for the upper part, which is square unless they set other margins.
  std::function<std::string(const std::filesystem::path& csv)> plot;
  std::function<void(CheckpointMemory&)> memory;  ///< of what append() has seen, for checkpoints
};

/// Grows to hold places in the plane, and gives gnuplot's lines for a square around them.
class Square {
 public:
  void hold(double x, double y) {
    if (!std::isfinite(x) || !std::isfinite(y)) return;
    left_ = std::min(left_, x);
    right_ = std::max(right_, x);
    low_ = std::min(low_, y);
    high_ = std::max(high_, y);
  }
  std::string ranges() const {
    if (!(left_ <= right_)) return "";
    const double width = std::max(right_ - left_, high_ - low_), reach = width > 0 ? 0.52 * width : 1;
    const auto range = [&](double middle) {
      std::ostringstream out;
      out.precision(9);
      out << '[' << middle - reach << ':' << middle + reach << ']';
      return out.str();
    };
    return "set xrange " + range((left_ + right_) / 2) + "\nset yrange " + range((low_ + high_) / 2) + "\n";
  }
  void visit_memory(CheckpointMemory& visit) {
    for (double* side : {&left_, &right_, &low_, &high_}) visit(*side);
  }

 private:
  double left_ = std::numeric_limits<double>::infinity(), right_ = -left_, low_ = left_, high_ = -left_;
};

/// gnuplot's lines for a path in the plane of two columns of the file, with a ring where it starts and crosses or dots at
/// `marks`: "x y" lines. `labels` are gnuplot's own texts.
inline std::string path_plot(const std::filesystem::path& csv, std::size_t x_column, std::size_t y_column,
                             const std::string& x_label, const std::string& y_label,
                             const std::vector<std::pair<double, double>>& marks = {}) {
  std::ostringstream out;
  out << "set size ratio -1\nset key off\nset xlabel " << quoted(x_label) << "\nset ylabel "
      << quoted(y_label) << '\n';
  if (!marks.empty()) {
    out.precision(9);
    out << "$marks << END\n";
    for (const auto& [x, y] : marks) out << x << ',' << y << '\n';
    out << "END\n";
  }
  const std::string columns = " using " + std::to_string(x_column) + ":" + std::to_string(y_column);
  out << "plot " << quoted(csv.string()) << " skip 1" << columns
      << " with lines linewidth 1 linecolor rgb '#0072B2', \\\n  " << quoted(csv.string())
      << " skip 1 every ::0::0" << columns
      << " with points pointtype 6 pointsize 1.6 linewidth 2 linecolor rgb '#D55E00'";
  if (!marks.empty())
    out << ", \\\n  $marks using 1:2 with points pointtype 7 pointsize 1.4 linecolor rgb 'black'";
  out << '\n';
  return out.str();
}

/// A view of q0, q1, ..., p0, p1, ... under the names given, and the path in the plane of two of them.
template <int Dof>
View<Dof> path_view(const std::vector<std::string>& columns, const std::string& x, const std::string& y,
                    const std::vector<std::pair<double, double>>& marks = {}) {
  const auto place = [&](const std::string& name) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) throw std::logic_error("path_view: no column " + name);
    return static_cast<std::size_t>(found - columns.begin()) + 2;
  };
  const std::size_t x_column = place(x), y_column = place(y);
  const auto square = std::make_shared<Square>();
  return {.columns = columns,
          .append =
              [=](const auto& q, const auto& p, std::vector<double>& row) {
                row.insert(row.end(), q.begin(), q.end());
                row.insert(row.end(), p.begin(), p.end());
                square->hold(row[x_column - 1], row[y_column - 1]);
              },
          .plot =
              [=](const std::filesystem::path& csv) {
                return square->ranges() + path_plot(csv, x_column, y_column, x, y, marks);
              },
          .memory = [=](CheckpointMemory& visit) { square->visit_memory(visit); }};
}

/// An observer that writes a view's columns.
template <int Dof>
class ViewCsv {
 public:
  ViewCsv(const std::filesystem::path& path, const View<Dof>& view)
      : view_(view), writer_(path, names(view)) {}

  template <class State>
  void operator()(double t, const State& state) {
    row_.assign(1, t);
    view_.append(state.q(), state.p(), row_);
    writer_.row(row_);
  }
  void commit() { writer_.commit(); }
  void visit_memory(CheckpointMemory& visit) {
    writer_.visit_memory(visit);
    if (view_.memory) view_.memory(visit);
  }

 private:
  static std::vector<std::string> names(const View<Dof>& view) {
    std::vector<std::string> list{"t"};
    list.insert(list.end(), view.columns.begin(), view.columns.end());
    return list;
  }

  const View<Dof>& view_;
  CsvWriter writer_;
  std::vector<double> row_;
};

/// The view above, the errors of the invariants below.
template <int Dof>
std::string scene_script(const std::filesystem::path& png, const std::filesystem::path& path_csv,
                         const std::filesystem::path& csv, const View<Dof>& view, const Run& run,
                         const std::string& headline, double time) {
  std::string title = quoted(headline);
  if (const auto end = headline.find('\n'); end != std::string::npos)  // gnuplot breaks lines in "" only
    title = quoted(headline.substr(0, end)) + ".\"\\n\"." + quoted(headline.substr(end + 1));
  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1600) << "set multiplot title " << title << " noenhanced font ',18'\n"
      << "set lmargin at screen 0.13\nset rmargin at screen 0.89\nset bmargin at screen 0.36\nset tmargin at "
         "screen 0.93\n"
      << "set grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\n"
      << view.plot(path_csv)
      << "unset label\nunset object\nset lmargin at screen 0.11\nset rmargin at screen 0.95\n"
      << "set bmargin at screen 0.055\nset tmargin at screen 0.27\nset size noratio\nunset logscale\n"
      << "set key on at screen 0.53,0.295 center center horizontal maxrows 1 samplen 3 width 2 noenhanced\n"
      << "set autoscale xy\nset logscale y\nset format x '%g'\nset format y '10^{%T}'\nset xlabel "
         "'time'\nset "
         "xrange [0:"
      << time << "]\n";
  static const char* const colours[] = {"#0072B2", "#009E73", "#E69F00", "#D55E00", "#CC79A7"};
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < run.quantities.size(); ++i) {
    std::string name = run.quantities[i].name;
    if (name == "defect") continue;  // it is in the file
    std::replace(name.begin(), name.end(), '_', ' ');
    curves.push_back(
        {&run, i, i + 2, name, "linewidth 1.5 linecolor rgb " + quoted(colours[curves.size() % 5])});
  }
  out << panel(csv, "relative error", curves) << "unset multiplot\n";
  return out.str();
}

}  // namespace examples
