#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include "../common/output.hpp"

namespace examples {

/// The gnuplot script of `count` curves of a CSV file over the years: column 2 and every stride-th behind it.
inline std::string curves(const std::filesystem::path& png, const std::filesystem::path& csv,
                          const std::string& title, const std::string& label, std::size_t count,
                          std::size_t stride) {
  std::string text = gnuplot_prologue(png, 1200, 800) + "set title " + quoted(title) +
                     " noenhanced\nset xlabel 'years from J2000'\nset ylabel '" + label +
                     "'\nset grid\nset key outside right noenhanced\nplot ";
  for (std::size_t i = 0; i < count; ++i)
    text += (i > 0 ? ", \\\n  " : "") + quoted(csv.string()) + " using 1:" + std::to_string(2 + i * stride) +
            " with lines linewidth 1.5 linetype " + std::to_string(i + 1) + (i > 7 ? " dashtype 2" : "") +
            " title columnheader(" + std::to_string(2 + i * stride) + ")";
  return text + '\n';
}

}  // namespace examples
