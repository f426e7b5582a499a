#pragma once

#include <algorithm>
#include <filesystem>
#include <span>
#include <sstream>
#include <string>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../common/scene_choice.hpp"
#include "file.hpp"

namespace examples {

/// gnuplot's lines for the paths in the plane, in the colours of the circulations, with a dot where each
/// starts, and the wall.
inline std::string plane(const std::filesystem::path& csv, const std::vector<Path>& paths, const Vortices& v,
                         const std::string& wall) {
  // gnuplot reads the file anew for every path.
  const Eigen::Index drawn = std::min<Eigen::Index>(v.x.size(), 100);
  const std::span<const Path> shown(paths.data(), static_cast<std::size_t>(drawn));
  const double strongest = v.circulation.cwiseAbs().maxCoeff();
  std::ostringstream out;
  out.precision(17);
  out << "$start << END\n";
  for (Eigen::Index i = 0; i < drawn; ++i) out << v.x[i] << ',' << v.y[i] << ',' << v.circulation[i] << '\n';
  out << "END\nset rmargin at screen 0.86\nset size ratio -1\nset key off\nset xlabel '"
      << (drawn < v.x.size() ? formatted("x, of the first %d of %d vortices", int(drawn), int(v.x.size()))
                             : "x")
      << "'\nset ylabel 'y'\n"
      << "set palette defined (-1 '#08519c', -0.1 '#6baed6', 0 '#999999', 0.1 '#fc9272', 1 '#a50f15')\n"
      << "set cbrange [" << -strongest << ':' << strongest << "]\nset cblabel 'circulation Γ'\n"
      << square_around(shown) << wall;
  const auto sparse = [](const Path& path) { return path.sparse(); };
  const auto dotted = std::find_if(shown.begin(), shown.end(), sparse);
  out << (dotted != shown.end() ? *dotted : shown.front()).label() << "plot ";
  for (Eigen::Index i = 0; i < drawn; ++i)
    out << quoted(csv.string()) << " skip 1 using " << 2 + 2 * i << ':' << 3 + 2 * i
        << shown[static_cast<std::size_t>(i)].style("palette cb " + formatted("%g", v.circulation[i]), 0.9)
        << ", \\\n  ";
  out << "$start using 1:2 with points pointtype 7 pointsize 1.8 linecolor rgb 'black', \\\n"
      << "  $start using 1:2:3 with points pointtype 7 pointsize 1.2 linecolor palette\n";
  return out.str();
}

/// The places of the vortices: x0, y0, x1, y1, ....
inline View<Eigen::Dynamic> places(const Vortices& v, const Choice& c) {
  View<Eigen::Dynamic> view;
  view.paths = static_cast<std::size_t>(v.x.size());
  for (std::size_t i = 0; i < view.paths; ++i)
    for (const char* axis : {"x", "y"}) view.columns.push_back(axis + std::to_string(i));
  view.append = [system = systems::PointVortices<>(v.circulation)](const auto& q, const auto& p, auto& row,
                                                                   auto& paths) {
    const Eigen::VectorXd x = system.x(q), y = system.y(p);
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      row.insert(row.end(), {x[i], y[i]});
      paths[static_cast<std::size_t>(i)].see(x[i], y[i]);
    }
  };
  std::string wall;
  if (c.on("half_plane")) wall = "set arrow 1 from graph 0, first 0 to graph 1, first 0 nohead linewidth 4\n";
  if (c.on("disk")) {  // which is to be seen whole
    const double radius = c["radius"], reach = 1.04 * radius;
    wall = formatted("set xrange [%.9g:%.9g]\nset yrange [%.9g:%.9g]\n", -reach, reach, -reach, reach) +
           formatted("set object 1 circle at 0,0 size %.9g fillstyle empty border ", radius) +
           "linecolor rgb 'black' linewidth 3\n";
  }
  view.plot = [=](const auto& csv, const auto& paths) { return plane(csv, paths, v, wall); };
  return view;
}

}  // namespace examples
