#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <span>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>

#include "output.hpp"
#include "results.hpp"

namespace examples {

/// A label with its unit; a quantity without one stays alone.
inline std::string in(const std::string& what, const std::string& unit) {
  return unit.empty() ? what : what + ", " + unit;
}

/// gnuplot's line for a word above a graph.
inline std::string label_above(const std::string& text) {
  return "set label 1 " + quoted(text) + " at graph 0, graph 1.015 left font ',12'\n";
}

/// Sees the rows of a path in the plane, and tells how to draw it: rows that lie too far apart, fewer than 24
/// a turn, must not be joined by lines, which would show places where nothing has been. A few may, where one
/// does not see it.
class Path {
 public:
  /// What is seen next is no row, but the step before one that is so many steps behind the last: by its
  /// length a whole turn in between is told from none.
  void step_before_row(double steps) { steps_ = steps; }
  void see(double x, double y) {
    if (const double steps = std::exchange(steps_, 0); steps > 0) {
      row_steps_ = steps;
      step_x_ = x, step_y_ = y;
      return;
    }
    if (std::isfinite(x) && std::isfinite(y)) {
      left = std::min(left, x), right = std::max(right, x);
      low = std::min(low, y), high = std::max(high, y);
    }
    const double dx = x - x_, dy = y - y_;
    const double straight = std::hypot(dx, dy), by_steps = row_steps_ * std::hypot(x - step_x_, y - step_y_);
    if (row_steps_ > 0) {
      shown_ += straight;
      gone_ += by_steps;
    }
    if (rows_ > 1) {
      const double angle = std::abs(std::atan2(dx_ * dy - dy_ * dx, dx_ * dx + dy_ * dy));
      if (std::isfinite(angle)) turned_ += angle;
      const bool sharp = !(angle < std::acos(-1.0) / 12) || by_steps > 2 * straight;
      if (sharp) ++sharp_;
      // As near the periapsis of a long ellipse.
      if (sharp && 30 * std::min(straight, std::hypot(dx_, dy_)) > std::max(right - left, high - low))
        ++chords_;
    }
    dx_ = dx, dy_ = dy;
    x_ = x, y_ = y;
    row_steps_ = 0;
    ++rows_;
  }
  /// The same of an angle along a curve that is drawn otherwise, whole turns included.
  void see_angle(double angle) {
    if (std::exchange(steps_, 0) > 0) return;
    if (rows_ > 0 && !(std::abs(angle - x_) < std::acos(-1.0) / 12)) ++sharp_;
    x_ = angle;
    ++rows_;
  }
  /// Steps are so long that they hide beats themselves.
  void hide_motion() { hidden_ = true; }
  /// Most of what happens happens between rows, which show some slow motion or other.
  bool hides_motion() const { return hidden_ || gone_ > 2 * shown_; }
  bool sparse() const { return 20 * sharp_ > rows_ || 100 * chords_ > rows_; }
  /// gnuplot's "with ..." in a colour, which is gnuplot's "rgb ..." or "palette ...".
  std::string style(const std::string& colour, double width = 1) const {
    if (!sparse()) return " with lines linewidth " + formatted("%.2g", width) + " linecolor " + colour;
    return " with points pointtype 7 pointsize " + std::string(rows_ > 5000 ? "0.15" : "0.4") +
           " linecolor " + colour;
  }
  /// A label above the graph for what is not plain to see.
  std::string label(const std::string& turn = "orbit") const {
    const double turns = turned_ / (2 * std::acos(-1.0));
    const std::string text = sparse() ? std::to_string(rows_) + " rows, too few per " + turn + " for a line"
                             : turns > 30 ? formatted("the rows go round %.0f times", turns)
                                          : "";
    return text.empty() ? "unset label 1\n" : label_above(text);
  }
  void visit_memory(CheckpointMemory& visit) {
    for (double* number : {&left, &right, &low, &high, &x_, &y_, &dx_, &dy_, &step_x_, &step_y_, &row_steps_,
                           &turned_, &gone_, &shown_})
      visit(*number);
    for (std::int64_t* count : {&rows_, &sharp_, &chords_}) visit(*count);
  }

  double left = std::numeric_limits<double>::infinity(), right = -left, low = left, high = -left;

 private:
  double x_ = 0, y_ = 0, dx_ = 0, dy_ = 0, turned_ = 0;
  double step_x_ = 0, step_y_ = 0, row_steps_ = 0;  ///< the step before the row, 0 where it is one itself
  double steps_ = 0;
  double gone_ = 0, shown_ = 0;  ///< the ways between rows by the speed at these, and straight
  std::int64_t rows_ = 0, sharp_ = 0, chords_ = 0;
  bool hidden_ = false;
};

/// gnuplot's ranges of a square around paths.
inline std::string square_around(std::span<const Path> paths) {
  Path all;
  for (const Path& path : paths) {
    all.left = std::min(all.left, path.left), all.right = std::max(all.right, path.right);
    all.low = std::min(all.low, path.low), all.high = std::max(all.high, path.high);
  }
  if (!(all.left <= all.right)) return "";
  const double width = std::max(all.right - all.left, all.high - all.low);
  // A path may be short beside its distance from the origin, and the ends of a range must not be equal.
  double farthest = 0;
  for (const double end : {all.left, all.right, all.low, all.high})
    farthest = std::max(farthest, std::abs(end));
  const double reach = width > 0 ? std::max(0.52 * width, 1e-14 * farthest) : 1;
  const auto range = [&](double low, double high) {
    const double middle = (low + high) / 2;
    return formatted("range [%.17g:%.17g]\n", middle - reach, middle + reach);
  };
  return "set x" + range(all.left, all.right) + "set y" + range(all.low, all.high);
}

/// How a program shows states: the columns of its trajectory file, t first, and the upper part of its
/// picture.
template <int Dof>
struct View {
  using Half = In<double, Dof>;

  std::vector<std::string> columns{"t"};
  /// Appends a number for each column behind t, and shows the paths where they go on.
  std::function<void(const Half& q, const Half& p, std::vector<double>& row, std::vector<Path>&)> append;
  /// gnuplot's lines for the upper part, which is square unless they set other margins.
  std::function<std::string(const std::filesystem::path& csv, const std::vector<Path>&)> plot;
  std::size_t paths = 1;
  double fastest = 0;  ///< radians a unit of time of the fastest beats, where that is known
};

/// gnuplot's lines for a path in the plane of two columns of the file, with a ring where it starts and dots
/// at `marks`.
inline std::string path_plot(const std::filesystem::path& csv, std::size_t x_column, std::size_t y_column,
                             const std::string& x_label, const std::string& y_label, const Path& path,
                             const std::vector<std::pair<double, double>>& marks = {}) {
  std::ostringstream out;
  out << square_around({&path, 1}) << "set size ratio -1\nset key off\nset xlabel " << quoted(x_label)
      << "\nset ylabel " << quoted(y_label) << '\n';
  if (!marks.empty()) {
    out << "$marks << END\n";
    for (const auto& [x, y] : marks) out << formatted("%.9g,%.9g\n", x, y);
    out << "END\n";
  }
  const std::string columns = " using " + std::to_string(x_column) + ":" + std::to_string(y_column);
  out << path.label() << "plot " << quoted(csv.string()) << " skip 1" << columns
      << path.style("rgb '#0072B2'") << ", \\\n  " << quoted(csv.string()) << " skip 1 every ::0::0"
      << columns << " with points pointtype 6 pointsize 1.6 linewidth 2 linecolor rgb '#D55E00'";
  if (!marks.empty())
    out << ", \\\n  $marks using 1:2 with points pointtype 7 pointsize 1.4 linecolor rgb 'black'";
  out << '\n';
  return out.str();
}

/// A view of t, q0, q1, ..., p0, p1, ... under the names given, and the path in the plane of two of them,
/// which are lengths in `unit`.
template <int Dof>
View<Dof> path_view(const std::vector<std::string>& columns, const std::string& x, const std::string& y,
                    const std::string& unit, const std::vector<std::pair<double, double>>& marks = {}) {
  const auto place = [&](const std::string& name) {
    const auto found = std::find(columns.begin(), columns.end(), name);
    if (found == columns.end()) throw std::logic_error("path_view: no column " + name);
    return static_cast<std::size_t>(found - columns.begin());
  };
  const std::size_t i = place(x), j = place(y);
  return {.columns = columns,
          .append =
              [=](const auto& q, const auto& p, auto& row, auto& paths) {
                row.insert(row.end(), q.begin(), q.end());
                row.insert(row.end(), p.begin(), p.end());
                paths[0].see(row[i], row[j]);
              },
          .plot =
              [=](const auto& csv, const auto& paths) {
                return path_plot(csv, i + 1, j + 1, in(x, unit), in(y, unit), paths[0], marks);
              }};
}

/// An observer that writes a view's columns.
template <int Dof>
class ViewCsv {
 public:
  static constexpr const char* name = "ViewCsv";

  /// Of a run by steps of dt.
  ViewCsv(const std::filesystem::path& path, const View<Dof>& view, const Rows& rows, double dt)
      : view_(view), clock_(rows), writer_(path, view.columns), paths_(view.paths) {
    if (view.fastest * dt > most_in_a_step)
      for (Path& one : paths_) one.hide_motion();
  }

  template <class State>
  void operator()(double t, const State& state) {
    const auto steps = static_cast<double>(clock_.steps_to_row_behind());
    const bool due = clock_.due();
    if (!due && steps == 0) return;
    if (!due)
      for (Path& path : paths_) path.step_before_row(steps);
    row_.assign(1, t);
    view_.append(state.q(), state.p(), row_, paths_);
    if (due) writer_.row(row_);
  }
  void commit() { writer_.commit(); }
  const std::vector<Path>& paths() const { return paths_; }

  template <class List>
  void describe(List& list) const {
    list("rows", writer_);
  }
  void visit_memory(CheckpointMemory& visit) {
    writer_.visit_memory(visit);
    for (Path& path : paths_) path.visit_memory(visit);
    clock_.visit_memory(visit);
  }

 private:
  const View<Dof>& view_;
  RowClock clock_;
  CsvWriter writer_;
  std::vector<Path> paths_;
  std::vector<double> row_;
};

/// gnuplot's lines of the view above, the errors of the invariants below.
inline std::string scene_script(const std::filesystem::path& png, const std::string& view,
                                const std::filesystem::path& csv, const Run& run, const std::string& headline,
                                double time, const std::string& time_unit,
                                const std::string& label = "relative error") {
  std::string title = quoted(headline);
  if (const auto end = headline.find('\n'); end != std::string::npos)  // gnuplot breaks lines in "" only
    title = quoted(headline.substr(0, end)) + ".\"\\n\"." + quoted(headline.substr(end + 1));
  static const char* const colours[] = {"#0072B2", "#009E73", "#E69F00", "#D55E00", "#CC79A7"};
  std::vector<Curve> curves;
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (run.quantities[i].name != "defect")  // which is in the file
      curves.push_back({&run, i, i + 2, in_words(run.quantities[i].name),
                        "linewidth 1.5 linecolor rgb " + quoted(colours[curves.size() % 5])});
  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1600) << "set multiplot title " << title << " noenhanced font ',18'\n"
      << "set lmargin at screen 0.13\nset rmargin at screen 0.89\nset bmargin at screen 0.36\nset tmargin at "
         "screen 0.93\n"
      << "set grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\n"
      << view
      << "unset label\nunset object\nunset arrow\nset lmargin at screen 0.11\nset rmargin at screen 0.95\n"
      << "set bmargin at screen 0.055\nset tmargin at screen 0.27\nset size noratio\nunset logscale\n"
      << "set key on at screen 0.53,0.295 center center horizontal maxrows 1 samplen 3 width 2 noenhanced\n"
      << "set autoscale xy\nset logscale y\nset format x '%g'\nset format y '10^{%T}'\nset xlabel "
      << quoted(in("time", time_unit)) << "\nset xrange [0:" << time << "]\n"
      << panel(csv, label, curves) << "unset multiplot\n";
  return out.str();
}

}  // namespace examples
