#pragma once

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/scene_choice.hpp"
#include "../common/scene_picture.hpp"
#include "measurements.hpp"

namespace examples {

/// The fastest swing of x and y that the fields make, in radians a unit of z.
inline double swing_rate(const Choice& c) {
  const double momentum = momentum_of(c), charge = std::abs(c["charge"]);
  double rate = c.on("undulator") ? 2 * std::numbers::pi / c["period"] : 0;
  if (c.on("solenoid")) rate = std::max(rate, charge * std::abs(c["b0"]) / momentum);
  if (c.on("quadrupole")) rate = std::max(rate, std::sqrt(charge * std::abs(c["slope"]) / momentum));
  return rate;
}

/// x and y along the axis, in lengths of their own; `phase` has seen the angle of such a swing.
inline std::string beam_plot(const std::filesystem::path& csv, const std::string& unit, const Path& phase) {
  const auto curve = [&](int column, const std::string& colour, const std::string& title) {
    return quoted(csv.string()) + formatted(" skip 1 using 4:%d", column) +
           phase.style("rgb '" + colour + "'", 1.5) + " title '" + title + "'";
  };
  return "set size noratio\nset key top right\nset xlabel " + quoted(in("z", unit)) + "\nset ylabel " +
         quoted(in("x, y", unit)) + "\n" + (phase.sparse() ? phase.label("swing") : "") + "plot " +
         curve(2, "#0072B2", "x") + ", " + curve(3, "#D55E00", "y") + "\n";
}

/// The way of a cosmic ray by its distance from the axis and height, with the region that is forbidden to it
/// where there is a lemma for it; about the dipole, or where it does not come there (`near` has seen
/// nothing), all of it (`all`).
inline std::string stoermer_plot(const std::filesystem::path& csv, const std::string& unit,
                                 const std::optional<Stoermer>& region, const std::string& style,
                                 const Path& near, const Path& all) {
  const bool far = near.left > near.right && all.left <= all.right;
  const double wide = far ? std::max({all.right, -2 * all.low, 2 * all.high}) : 8;
  std::string forbidden;
  for (int i = 0; region && i < 160; ++i)
    for (int k = -80; k <= 80; ++k) {
      const double rho = wide * (i + 0.5) / 160, z = wide * k / 160;
      if (region->forbidden(rho, z)) forbidden += formatted("%g,%g\n", rho, z);
    }
  const bool grey = !forbidden.empty();
  return (grey ? "$forbidden << END\n" + forbidden + "END\n" : "") +
         "set object 1 circle at 0,0 size 1 front linewidth 2 fillstyle empty border linecolor "
         "rgb 'black'\n" +
         "set key off\nset size ratio -1\nset xlabel " +
         quoted(in(std::string("distance from the axis") + (grey ? " (grey: forbidden)" : ""), unit)) +
         "\nset ylabel " + quoted(in("z", unit)) +
         formatted("\nset xrange [0:%.9g]\nset yrange [%.9g:%.9g]\nplot ", wide, -wide / 2, wide / 2) +
         (grey ? "$forbidden using 1:2 with points pointtype 5 pointsize 0.6 linecolor rgb '#d0d0d0', "
               : "") +
         quoted(csv.string()) + " skip 1 using (sqrt($2**2 + $3**2)):4" + style + "\n";
}

inline View<3> fast_view(const Choice& c) {
  const std::string unit = c.units.name(0);
  View<3> view = path_view<3>({"t", "x", "y", "z", "px", "py", "pz"}, "x", "y", unit);
  if (c.preset == "cosmic_ray" && c.on("dipole_field")) {
    const Vector<double, 3> q(c["x"], c["y"], c["z"]);
    std::optional<Stoermer> region;  // another field would change it
    if (c.only_field("dipole_field"))
      region.emplace(
          c, q, fast_motion(c, fast_fields(c, "")).momentum(q, Vector<double, 3>(-momentum_of(c), 0, 0)));
    view.paths = 3;
    view.append = [append = view.append](const auto& x, const auto& p, auto& row, auto& paths) {
      append(x, p, row, paths);
      const double rho = std::hypot(x[0], x[1]);
      paths[1].see(rho, x[2]);
      if (rho < 8 && std::abs(x[2]) < 4) paths[2].see(rho, x[2]);
    };
    view.plot = [=](const auto& csv, const auto& paths) {
      return stoermer_plot(csv, unit, region, paths[0].style("rgb '#0072B2'", 2), paths[2], paths[1]);
    };
  } else if (c.preset != "gyration") {
    view.paths = 2;
    view.append = [rate = swing_rate(c), append = view.append](const auto& q, const auto& p, auto& row,
                                                               auto& paths) {
      append(q, p, row, paths);
      paths[1].see_angle(rate * q[2]);
    };
    view.plot = [=](const auto& csv, const auto& paths) { return beam_plot(csv, unit, paths[1]); };
  }
  return view;
}

}  // namespace examples
