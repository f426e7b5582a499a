#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <locale>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <semiexplicit/io/durable_file.hpp>

#include <sys/wait.h>

namespace examples {

template <class... Numbers>
std::string formatted(const char* format, Numbers... numbers) {
  std::string text(static_cast<std::size_t>(std::snprintf(nullptr, 0, format, numbers...)), ' ');
  std::snprintf(text.data(), text.size() + 1, format, numbers...);
  return text;
}

inline std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

/// "1 orbit", "2 orbits".
inline std::string counted(std::int64_t number, const std::string& what) {
  return std::to_string(number) + " " + what + (number == 1 ? "" : "s");
}

/// Writes what write(out) puts out to a file, which gets its name when it is whole; numbers have a decimal
/// point in any locale. Throws std::runtime_error where that fails.
template <class Write>
void write_whole(const std::filesystem::path& path, const Write& write) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  write(out);
  semiexplicit::write_durably(path, out.view());
}

/// A text between single quotes, where each of its own is replaced: gnuplot reads '' as one, a shell '\''.
inline std::string quoted(const std::string& text, const char* quote = "''") {
  std::string result = "'";
  for (const char c : text) result += c == '\'' ? quote : std::string(1, c);
  return result + "'";
}

/// Lines every script begins with. `output` may be given from outside.
inline std::string gnuplot_prologue(const std::filesystem::path& png, int width, int height) {
  const std::string size = " size " + std::to_string(width) + "," + std::to_string(height);
  return "# Draws the picture again: gnuplot " + std::filesystem::path(png).replace_extension("gp").string() +
         "\nif (!exists('output')) output = " + quoted(png.string()) +
         "\nif (strstrt(GPVAL_TERMINALS, 'pngcairo')) {\n  set terminal pngcairo font 'sans,15'" + size +
         "\n} else {\n  set terminal png font 'arial,15'" + size +
         "\n}\nset output output\nset datafile separator ','\nset encoding utf8\n";
}

/// Says of a file that is there that it is not of this run.
inline void tell_of_earlier(const std::filesystem::path& file, const std::string& what) {
  std::error_code none;
  if (std::filesystem::exists(file, none))
    std::cerr << file.string() << " stays as it is, " << what << " of an earlier run\n";
}
inline void tell_of_earlier_picture(const std::filesystem::path& png) { tell_of_earlier(png, "a picture"); }

/// Says why a run that succeeded has no picture.
inline void tell_no_picture(const std::filesystem::path& png, const std::string& why) {
  std::cout << "no picture: " << why << '\n';
  tell_of_earlier_picture(png);
}

/// Leaves the script beside the picture `png`, and draws it. The picture gets its name when it is whole; it
/// comes through a pipe, since gnuplot does not notice a full disk. In the locale C gnuplot would warn of the
/// signs of UTF-8. Without gnuplot there is a hint and no picture; nor is there one where the data or the
/// script would go to a pipe or a device, where gnuplot would wait for them.
inline void draw(const std::filesystem::path& png, const std::string& script,
                 std::vector<std::filesystem::path> data) {
  const std::filesystem::path file = std::filesystem::path(png).replace_extension("gp");
  data.push_back(file);
  for (const auto& one : data)
    if (semiexplicit::detail::Destination(one).direct)
      return tell_no_picture(png, one.string() + " is no file that could be read again");
  const std::string script_name = (file.is_absolute() ? "" : "./") + file.string();  // it may begin with -
  semiexplicit::DurableFile::remove(png);  // an older one would belong to other data
  semiexplicit::write_durably(file, script);

  constexpr int none = 127;
  const std::string command = "command -v gnuplot >/dev/null || exit " + std::to_string(none) +
                              "; LC_ALL=C.UTF-8 exec gnuplot -e \"output = '/dev/stdout'\" " +
                              quoted(script_name, "'\\''");
  std::FILE* const pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) throw std::runtime_error("gnuplot: no pipe can be opened to it");
  std::string picture;
  char piece[1 << 16];
  for (std::size_t size = 1; size > 0;) {
    size = std::fread(piece, 1, sizeof piece, pipe);
    picture.append(piece, size);
  }
  const int status = pclose(pipe);
  if (WIFEXITED(status) && WEXITSTATUS(status) == none) {
    std::cerr << "No picture: gnuplot is not installed (Debian, Ubuntu: apt-get install gnuplot-nox). "
                 "Then: gnuplot "
              << file.string() << '\n';
    return;
  }
  if (status != 0 || picture.empty()) throw std::runtime_error("gnuplot failed on " + file.string());
  semiexplicit::write_durably(png, picture);
  std::cout << "picture: " << png.string() << '\n';
}

/// Radians of a beat that a step may go through and still show it.
inline constexpr double most_in_a_step = 2;

/// The decimal place of the first digit, 0 for that of the units.
inline int decimal_place(double x) { return static_cast<int>(std::floor(std::log10(std::abs(x)))); }

/// "77.8 ± 0.7", no more digits than that means; eight of them where none of these is uncertain.
inline std::string with_uncertainty(double value, double uncertain) {
  if (!(uncertain > 1e-8 * std::abs(value))) return formatted("%.8g", value);
  const bool small = value != 0 && std::abs(value) < 1e-4;  // as %g has it
  const int decimals = std::clamp((small ? decimal_place(value) : 0) - decimal_place(uncertain), 0, 15);
  return formatted(small ? "%.*e" : "%.*f", decimals, value) + formatted(" ± %.1g", uncertain);
}

}  // namespace examples
