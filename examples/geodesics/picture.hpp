#pragma once

#include <filesystem>
#include <string>

#include "../common/output.hpp"

namespace examples {

/// The gnuplot script of a section, orbits in colours from within outwards.
inline std::string section_picture(const std::filesystem::path& png, const std::filesystem::path& csv,
                                   const std::string& title) {
  return gnuplot_prologue(png, 1100, 900) + "set title " + quoted(title + "; orange: chaotic") +
         " noenhanced\nset xlabel 'r/M'\nset ylabel 'p_r'\nset key off\nunset colorbox\nset cbrange "
         "[-0.5:*]\n"
         "set offsets graph 0.02, graph 0.02, graph 0.02, graph 0.02\n"
         "set palette defined (0 '#0072B2', 1 '#009E73', 2 '#56B4E9', 3 '#666666')\n"
         "plot " +
         quoted(csv.string()) +
         " using ($4 > 0 ? $2 : NaN):3 skip 1 with points pointtype 7 pointsize 0.25 " +
         "linecolor rgb '#D55E00', " + quoted(csv.string()) +
         " using ($4 > 0 ? NaN : $2):3:1 skip 1 with points pointtype 7 pointsize 0.35 palette\n";
}

}  // namespace examples
