#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <istream>
#include <locale>
#include <map>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/vector.hpp>

namespace examples {

/// Places and circulations of vortices.
struct Vortices {
  semiexplicit::Vector<double, Eigen::Dynamic> x, y, circulation;
};

inline std::string trimmed(const std::string& text) {
  const char* const blanks = " \t\r";
  const std::size_t begin = text.find_first_not_of(blanks);
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(blanks) + 1 - begin);
}

/// Reads CSV with the columns x,y,gamma: a line a vortex, an optional header, blank lines, comments from #
/// on. Throws std::invalid_argument, "file:line: reason", for anything else, and for vortices that cannot be:
/// zero circulation, two in one place.
inline Vortices read_vortices(std::istream& in, const std::string& file) {
  std::vector<double> columns[3];
  std::map<std::pair<double, double>, int> line_of_place;
  std::string line;
  bool header_allowed = true;
  for (int number = 1; std::getline(in, line); ++number) {
    const auto refuse = [&](const std::string& reason) {
      throw std::invalid_argument(file + ":" + std::to_string(number) + ": " + reason);
    };
    if (number == 1 && line.starts_with("\xef\xbb\xbf"))
      line.erase(0, 3);  // the byte order mark of spreadsheets
    line = trimmed(line.substr(0, line.find('#')));
    if (line.empty()) continue;

    std::vector<std::string> fields{""};
    for (const char c : line)
      if (c == ',')
        fields.emplace_back();
      else
        fields.back() += c;
    for (std::string& field : fields) field = trimmed(field);
    if (fields.size() != 3)
      refuse("x,y,gamma are three fields, here " + std::string(fields.size() == 1 ? "is " : "are ") +
             std::to_string(fields.size()));

    std::string lower = fields[0] + "," + fields[1] + "," + fields[2];
    for (char& c : lower) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (std::exchange(header_allowed, false) && lower == "x,y,gamma") continue;

    double values[3] = {};
    for (std::size_t i = 0; i < 3; ++i) {
      std::istringstream number_in(fields[i]);
      number_in.imbue(std::locale::classic());
      if (!(number_in >> values[i]) || number_in.peek() != std::istringstream::traits_type::eof())
        refuse("'" + fields[i] + "' is not a finite number");
      columns[i].push_back(values[i]);
    }
    if (values[2] == 0) refuse("the circulation is zero; leave such a vortex out");
    const auto [place, is_new] = line_of_place.try_emplace({values[0], values[1]}, number);
    if (!is_new) refuse("a vortex is in this place already, see line " + std::to_string(place->second));
  }
  if (in.bad()) throw std::invalid_argument(file + ": cannot be read");
  if (columns[0].empty()) throw std::invalid_argument(file + ": no vortices in it; give lines x,y,gamma");

  const auto column = [&](int i) {
    return Eigen::Map<const Eigen::VectorXd>(columns[i].data(), static_cast<Eigen::Index>(columns[i].size()))
        .eval();
  };
  return {column(0), column(1), column(2)};
}

/// Reads no more than 100 MB, a million vortices: a device has no end.
inline Vortices read_vortices(const std::filesystem::path& path) {
  constexpr std::size_t most = 100'000'000;
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::invalid_argument(path.string() + ": cannot be read");
  std::string bytes;
  for (char part[65536]; bytes.size() <= most && (file.read(part, sizeof part) || file.gcount() > 0);)
    bytes.append(part, static_cast<std::size_t>(file.gcount()));
  if (file.bad()) throw std::invalid_argument(path.string() + ": cannot be read");
  if (bytes.size() > most)
    throw std::invalid_argument(path.string() + ": longer than 100 MB; give a file of lines x,y,gamma");
  std::istringstream in(std::move(bytes));
  return read_vortices(in, path.string());
}

}  // namespace examples
