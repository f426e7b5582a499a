#pragma once

#include <cmath>
#include <string>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/scene_choice.hpp"
#include "../common/scene_picture.hpp"

namespace examples {

/// From above, and along the axis.
inline View<3> charge_view(const Choice& c) {
  const std::string unit = c.units.name(0);
  View<3> view = path_view<3>({"t", "x", "y", "z", "px", "py", "pz"}, "x", "y", unit);
  view.paths = 2;
  view.append = [append = view.append](const auto& q, const auto& p, auto& row, auto& paths) {
    append(q, p, row, paths);
    paths[1].see(std::hypot(q[0], q[1]), q[2]);
  };
  const std::string earth =
      c.preset == "dipole" ? "set object 1 circle at 0,0 size 1 fillstyle solid fillcolor rgb '#999999'\n"
                           : "";
  view.plot = [=, from_above = view.plot](const auto& csv, const auto& paths) {
    return earth +
           "set xtics rotate by -40\nset rmargin at screen 0.6\nset bmargin at screen 0.47\n"
           "set tmargin at screen 0.85\n" +
           from_above(csv, paths) +
           "unset object\nset size noratio\nset lmargin at screen 0.72\nset rmargin at screen 0.95\n"
           "set xtics rotate by -90\nset xrange [0:*]\nset yrange [*:*]\nset offsets 0, graph 0.1, 0, 0\nset "
           "xlabel " +
           quoted(in("distance from the axis", unit)) + "\nset ylabel " + quoted(in("z", unit)) + "\n" +
           paths[1].label() + "plot " + quoted(csv.string()) + " skip 1 using (sqrt($2**2 + $3**2)):4" +
           paths[1].style("rgb '#0072B2'") + "\nset xtics norotate\nset offsets 0, 0, 0, 0\n";
  };
  return view;
}

}  // namespace examples
