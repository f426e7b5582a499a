#pragma once

#include <algorithm>
#include <filesystem>
#include <limits>
#include <map>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../common/error_panels.hpp"
#include "../common/gnuplot.hpp"
#include "../common/run.hpp"
#include "../common/scene_program.hpp"
#include "../common/table.hpp"
#include "file.hpp"

namespace examples {

/// An observer that writes the places: t, x0, y0, x1, y1, ..., and knows the square around them.
class PlacesCsv {
  using Places = systems::PointVortices<>;

 public:
  struct Square {
    double x, y, half_width;
  };

  static constexpr const char* name = "PlacesCsv";

  PlacesCsv(const std::filesystem::path& path, const Places& system)
      : system_(system),
        writer_(path, names(system.dof())),
        chords_(static_cast<std::size_t>(system.dof())) {}

  template <class State>
  void operator()(double t, const State& state) {
    const Eigen::VectorXd x = system_.x(state.q()), y = system_.y(state.p());
    row_.assign(1, t);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      row_.insert(row_.end(), {x[i], y[i]});
      chords_[static_cast<std::size_t>(i)].see(x[i], y[i]);
    }
    writer_.row(row_);
    left_ = std::min(left_, x.minCoeff());
    right_ = std::max(right_, x.maxCoeff());
    low_ = std::min(low_, y.minCoeff());
    high_ = std::max(high_, y.maxCoeff());
  }
  void commit() { writer_.commit(); }
  template <class List>
  void describe(List& list) const {
    list("rows", writer_);
  }
  void visit_memory(CheckpointMemory& visit) {
    writer_.visit_memory(visit);
    for (double* side : {&left_, &right_, &low_, &high_}) visit(*side);
    for (Chords& chords : chords_) chords.visit_memory(visit);
  }
  const std::vector<Chords>& chords() const { return chords_; }

  Square square() const {
    const double width = std::max(right_ - left_, high_ - low_);
    return {(left_ + right_) / 2, (low_ + high_) / 2, width > 0 ? width / 2 : 1};
  }

 private:
  static std::vector<std::string> names(Eigen::Index count) {
    std::vector<std::string> list{"t"};
    for (Eigen::Index i = 0; i < count; ++i)
      list.insert(list.end(), {"x" + std::to_string(i), "y" + std::to_string(i)});
    return list;
  }

  Places system_;
  CsvWriter writer_;
  std::vector<Chords> chords_;  // of each vortex
  std::vector<double> row_;
  double left_ = std::numeric_limits<double>::infinity(), right_ = -left_, low_ = left_, high_ = -left_;
};

/// The plane above, the errors below.
inline std::string vortex_script(const std::filesystem::path& png, const std::filesystem::path& places,
                                 const std::filesystem::path& csv, const Vortices& v, const Run& run,
                                 const std::string& headline, double time, const PlacesCsv& seen,
                                 const Choice& c) {
  const PlacesCsv::Square square = seen.square();
  const std::vector<Chords>& chords = seen.chords();
  // gnuplot reads the file anew for every path.
  const Eigen::Index drawn = std::min<Eigen::Index>(v.x.size(), 100);
  const double strongest = v.circulation.cwiseAbs().maxCoeff();
  const double wall = c.on("disk") ? c["radius"] : 0;  // which is to be seen whole
  const double reach = 1.04 * std::max(square.half_width, wall);
  const auto range = [&](double middle) {
    if (wall > 0) middle = 0;
    return "[" + formatted("%.9g", middle - reach) + ":" + formatted("%.9g", middle + reach) + "]";
  };
  std::ostringstream out;
  out << gnuplot_prologue(png, 1200, 1600) << "$start << END\n";
  for (Eigen::Index i = 0; i < drawn; ++i) out << v.x[i] << ',' << v.y[i] << ',' << v.circulation[i] << '\n';
  out << "END\nset multiplot title " << quoted(headline) << " noenhanced font ',20'\n"
      << "set lmargin at screen 0.11\nset rmargin at screen 0.86\nset bmargin at screen 0.36\nset tmargin at "
         "screen 0.945\n"
      << "set size ratio -1\nset key off\nset grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\nset "
         "xlabel 'x'\nset ylabel 'y'\n"
      << "set xrange " << range(square.x) << "\nset yrange " << range(square.y) << '\n'
      << "set palette defined (-1 '#08519c', -0.1 '#6baed6', 0 '#999999', 0.1 '#fc9272', 1 '#a50f15')\n"
      << (c.on("half_plane") ? "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead linewidth 4\n"
                             : "")
      << (c.on("disk") ? "set object 1 circle at 0,0 size " + formatted("%.9g", wall) +
                             " fillstyle empty border linecolor rgb 'black' linewidth 3\n"
                       : "")
      << "set cbrange [" << -strongest << ':' << strongest << "]\nset cblabel 'circulation Γ'\n";
  const auto dotted =
      std::find_if(chords.begin(), chords.end(), [](const Chords& path) { return path.sparse(); });
  out << (dotted != chords.end() ? *dotted : chords.front()).label() << "plot ";
  for (Eigen::Index i = 0; i < drawn; ++i)
    out << quoted(places.string()) << " skip 1 using " << 2 + 2 * i << ':' << 3 + 2 * i
        << chords[static_cast<std::size_t>(i)].style("palette cb " + formatted("%g", v.circulation[i]), 0.9)
        << ", \\\n  ";
  out << "$start using 1:2 with points pointtype 7 pointsize 1.8 linecolor rgb 'black', \\\n"
      << "  $start using 1:2:3 with points pointtype 7 pointsize 1.2 linecolor palette\nunset arrow\nunset "
         "object\n"
      << "set bmargin at screen 0.055\nset tmargin at screen 0.27\nset rmargin at screen 0.96\nset size "
         "noratio\n"
      << "set key at screen 0.535,0.295 center center horizontal maxrows 1 samplen 3 width -2\n"
      << "set autoscale y\nset logscale y\nset format y '10^{%T}'\nset xlabel 'time'\nset xrange [0:" << time
      << "]\n";
  const std::map<std::string, std::pair<std::string, std::string>> curves{
      {"energy", {"energy", "#0072B2"}},
      {"impulse_x", {"linear impulse, x", "#009E73"}},
      {"impulse_y", {"linear impulse, y", "#E69F00"}},
      {"angular_impulse", {"angular impulse", "#D55E00"}}};
  std::vector<Curve> all;
  for (std::size_t i = 0; i < run.quantities.size(); ++i)
    if (const auto found = curves.find(run.quantities[i].name); found != curves.end())
      all.push_back({&run, i, i + 2, found->second.first,
                     "linewidth 1.5 linecolor rgb " + quoted(found->second.second)});
  out << panel(csv, "relative error", all) << "unset multiplot\n";
  return out.str();
}

}  // namespace examples
