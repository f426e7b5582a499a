#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>

#include "error_panels.hpp"
#include "gnuplot.hpp"
#include "run.hpp"
#include "table.hpp"

namespace examples {

/// How a program shows states: the columns of its trajectory file behind t, and the upper part of its picture.
template <int Dof>
struct View {
  using Half = In<double, Dof>;

  std::vector<std::string> columns;
  /// Appends a number for each column.
  std::function<void(const Half& q, const Half& p, std::vector<double>& row)> append;
  /// gnuplot's lines for the upper part, which is square unless they set other margins.
  std::function<std::string(const std::filesystem::path& csv)> plot;
  std::function<void(CheckpointMemory&)> memory;  ///< of what append() has seen, for checkpoints
};

/// A label with its unit; a quantity without one stays alone.
inline std::string in(const std::string& what, const std::string& unit) {
  return unit.empty() ? what : what + ", " + unit;
}

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

/// Sees the rows of a path, and tells how to draw it: rows that lie too far apart, fewer than 24 a turn, must not be joined by
/// lines, which would show places where nothing has been.
class Chords {
 public:
  void see(double x, double y) {
    const double dx = x - x_, dy = y - y_;
    if (rows_ > 1) {
      const double angle = std::abs(std::atan2(dx_ * dy - dy_ * dx, dx_ * dx + dy_ * dy));
      if (std::isfinite(angle)) turned_ += angle;
      if (!(angle < std::acos(-1.0) / 12)) ++sharp_;
    }
    dx_ = dx, dy_ = dy;
    x_ = x, y_ = y;
    ++rows_;
  }
  bool sparse() const { return 20 * sharp_ > rows_; }
  /// gnuplot's "with ..." in a colour, which is gnuplot's "rgb ..." or "palette ...".
  std::string style(const std::string& colour, double width = 1) const {
    if (!sparse()) return " with lines linewidth " + formatted("%.2g", width) + " linecolor " + colour;
    return " with points pointtype 7 pointsize " + std::string(rows_ > 5000 ? "0.15" : "0.4") +
           " linecolor " + colour;
  }
  /// A label above the graph for what is not plain to see.
  std::string label() const {
    const double turns = turned_ / (2 * std::acos(-1.0));
    const std::string text = sparse()     ? std::to_string(rows_) + " rows, too few a turn for a line"
                             : turns > 30 ? formatted("%.0f turns over one another", turns)
                                          : "";
    return text.empty() ? "unset label 1\n"
                        : "set label 1 " + quoted(text) + " at graph 0, graph 1.015 left font ',12'\n";
  }
  void visit_memory(CheckpointMemory& visit) {
    for (double* number : {&x_, &y_, &dx_, &dy_, &turned_}) visit(*number);
    for (std::int64_t* count : {&rows_, &sharp_}) visit(*count);
  }

 private:
  double x_ = 0, y_ = 0, dx_ = 0, dy_ = 0, turned_ = 0;
  std::int64_t rows_ = 0, sharp_ = 0;
};

/// gnuplot's lines for a path in the plane of two columns of the file, with a ring where it starts and crosses or dots at
/// `marks`: "x y" lines. `labels` are gnuplot's own texts.
inline std::string path_plot(const std::filesystem::path& csv, std::size_t x_column, std::size_t y_column,
                             const std::string& x_label, const std::string& y_label, const Chords& chords,
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
  out << chords.label();
  const std::string columns = " using " + std::to_string(x_column) + ":" + std::to_string(y_column);
  out << "plot " << quoted(csv.string()) << " skip 1" << columns << chords.style("rgb '#0072B2'")
      << ", \\\n  " << quoted(csv.string()) << " skip 1 every ::0::0" << columns
      << " with points pointtype 6 pointsize 1.6 linewidth 2 linecolor rgb '#D55E00'";
  if (!marks.empty())
    out << ", \\\n  $marks using 1:2 with points pointtype 7 pointsize 1.4 linecolor rgb 'black'";
  out << '\n';
  return out.str();
}

/// A view of q0, q1, ..., p0, p1, ... under the names given, and the path in the plane of two of them, which are lengths in
/// `unit`.
template <int Dof>
View<Dof> path_view(const std::vector<std::string>& columns, const std::string& x, const std::string& y,
                    const std::string& unit, const std::vector<std::pair<double, double>>& marks = {}) {
  const auto place = [&](const std::string& name) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) throw std::logic_error("path_view: no column " + name);
    return static_cast<std::size_t>(found - columns.begin()) + 2;
  };
  const std::size_t x_column = place(x), y_column = place(y);
  const auto square = std::make_shared<Square>();
  const auto chords = std::make_shared<Chords>();
  return {.columns = columns,
          .append =
              [=](const auto& q, const auto& p, std::vector<double>& row) {
                row.insert(row.end(), q.begin(), q.end());
                row.insert(row.end(), p.begin(), p.end());
                square->hold(row[x_column - 1], row[y_column - 1]);
                chords->see(row[x_column - 1], row[y_column - 1]);
              },
          .plot =
              [=](const std::filesystem::path& csv) {
                return square->ranges() +
                       path_plot(csv, x_column, y_column, in(x, unit), in(y, unit), *chords, marks);
              },
          .memory =
              [=](CheckpointMemory& visit) {
                square->visit_memory(visit);
                chords->visit_memory(visit);
              }};
}

/// An observer that writes a view's columns.
template <int Dof>
class ViewCsv {
 public:
  static constexpr const char* name = "ViewCsv";

  ViewCsv(const std::filesystem::path& path, const View<Dof>& view)
      : view_(view), writer_(path, names(view)) {}

  template <class State>
  void operator()(double t, const State& state) {
    row_.assign(1, t);
    view_.append(state.q(), state.p(), row_);
    writer_.row(row_);
  }
  void commit() { writer_.commit(); }
  template <class List>
  void describe(List& list) const {
    list("rows", writer_);
  }
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
                         const std::string& headline, double time, const std::string& time_unit) {
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
      << quoted(in("time", time_unit)) << "\nset xrange [0:" << time << "]\n";
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
