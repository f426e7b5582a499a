#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <initializer_list>
#include <map>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include <semiexplicit/scene/nearest_names.hpp>

namespace examples {

/// A product of units: its size in SI units, and the powers of metre, second, kilogram and coulomb in it.
struct Unit {
  double size = 1;
  std::array<int, 4> powers{};
};

/// The units that users may write behind a number. Angles are numbers, in radians. The masses of celestial
/// bodies come as GM, which is what is known of them.
inline const std::map<std::string, Unit>& known_units() {
  static const std::map<std::string, Unit> units = [] {
    std::map<std::string, Unit> all;
    const auto add = [&](std::array<int, 4> powers,
                         std::initializer_list<std::pair<const char*, double>> list) {
      for (const auto& [name, size] : list) all[name] = {size, powers};
    };
    const double degree = std::acos(-1.0) / 180, e = 1.602176634e-19;
    add({1}, {{"m", 1}, {"mm", 1e-3}, {"cm", 1e-2}, {"km", 1e3}, {"AU", 149597870700.0}});
    add({1}, {{"Rearth", 6378137}, {"Rsun", 6.957e8}});
    add({0, 1}, {{"s", 1}, {"ns", 1e-9}, {"us", 1e-6}, {"ms", 1e-3}, {"second", 1}});
    add({0, 1}, {{"min", 60}, {"minute", 60}, {"h", 3600}, {"hour", 3600}});
    add({0, 1}, {{"d", 86400}, {"day", 86400}, {"yr", 365.25 * 86400}, {"year", 365.25 * 86400}});
    add({0, 1}, {{"century", 36525.0 * 86400}});
    add({0, 0, 1}, {{"kg", 1}, {"me", 9.1093837015e-31}, {"mp", 1.67262192369e-27}});
    add({0, 0, 0, 1}, {{"C", 1}, {"e", e}});
    add({1, -1}, {{"c", 299792458}});
    add({3, -2}, {{"GMsun", 1.32712440041e20}, {"GMearth", 3.986004418e14}, {"GMmoon", 4.9028e12}});
    add({0, -1, 1, -1}, {{"T", 1}, {"mT", 1e-3}, {"uT", 1e-6}, {"nT", 1e-9}, {"G", 1e-4}});
    add({2, -2, 1, -1}, {{"V", 1}, {"mV", 1e-3}, {"kV", 1e3}});
    add({2, -2, 1}, {{"J", 1}, {"eV", e}, {"keV", 1e3 * e}, {"MeV", 1e6 * e}});
    add({}, {{"rad", 1}, {"deg", degree}, {"arcsec", degree / 3600}});
    return all;
  }();
  return units;
}

/// Reads "km/s", "AU^3/year^2", "m3/s2", "1/s": units with powers, joined by blanks, * or /, each / for the
/// one unit behind it. Throws std::invalid_argument, with the nearest names, for an unknown one.
inline Unit read_unit(const std::string& text) {
  Unit product;
  int sign = 1;
  for (std::size_t i = 0; i < text.size();) {
    const auto take = [&](auto what) {
      std::string part;
      while (i < text.size() && what(static_cast<unsigned char>(text[i]))) part += text[i++];
      return part;
    };
    if (text[i] == '/' || text[i] == '*' || std::isspace(static_cast<unsigned char>(text[i]))) {
      if (text[i++] == '/') sign = -1;
      continue;
    }
    const std::string name = take([](int c) { return std::isalpha(c) != 0; });
    if (i < text.size() && text[i] == '^') ++i;
    const std::string power = take([](int c) { return c == '-' || std::isdigit(c); });
    if (name.empty() && power == "1") continue;  // 1/s
    if (name.empty())
      throw std::invalid_argument("'" + text + "' is no unit; write one as km, km/s or AU^3/year^2");
    auto found = known_units().find(name);
    if (found == known_units().end() && name.size() > 3 && name.back() == 's')  // days
      found = known_units().find(name.substr(0, name.size() - 1));
    if (found == known_units().end()) {
      std::vector<std::string> valid;
      for (const auto& [known, unit] : known_units()) valid.push_back(known);
      throw std::invalid_argument(semiexplicit::unknown_name("unit", name, valid));
    }
    int exponent = 1;
    const char* const end = power.data() + power.size();
    if (!power.empty()) {
      const auto [rest, failure] = std::from_chars(power.data(), end, exponent);
      if (failure != std::errc() || rest != end || std::abs(exponent) > 9)
        throw std::invalid_argument("'" + power + "' is no power of a unit; give -9 to 9");
    }
    exponent *= std::exchange(sign, 1);
    product.size *= std::pow(found->second.size, exponent);
    for (std::size_t k = 0; k < 4; ++k) product.powers[k] += exponent * found->second.powers[k];
    if (!std::isnormal(product.size))
      throw std::invalid_argument("'" + text + "' is too large or too small a unit; write fewer factors");
  }
  if (sign < 0) throw std::invalid_argument("'" + text + "' ends in a stroke; write a unit behind it");
  return product;
}

/// "length^3/time^2", "mass/time/charge", "number".
inline std::string dimension(const Unit& unit) {
  static const char* const names[] = {"length", "time", "mass", "charge"};
  std::string sides[2];  // above and below the stroke
  for (std::size_t k = 0; k < 4; ++k) {
    const int power = unit.powers[k];
    std::string& side = sides[power < 0];
    if (power == 0) continue;
    side += (side.empty() ? "" : power < 0 ? "/" : " ") + std::string(names[k]);
    if (std::abs(power) > 1) side += "^" + std::to_string(std::abs(power));
  }
  if (sides[1].empty()) return sides[0].empty() ? "number" : sides[0];
  return (sides[0].empty() ? "1" : sides[0]) + "/" + sides[1];
}

/// The units that a preset counts in, by what they are in SI units. One that is NaN is not fixed: numbers
/// only.
struct UnitSystem {
  std::string about;  ///< "AU, year"
  double length = NAN, time = NAN, mass = NAN, charge = NAN;

  /// The name of the k-th unit in `about`, for labels: 0 the length, 1 the time; none for plain numbers.
  std::string name(int k) const {
    if (about == "numbers") return "";
    std::string rest = about;
    for (std::size_t comma = 0; k > 0 && (comma = rest.find(", ")) != std::string::npos; --k)
      rest.erase(0, comma + 2);
    return rest.substr(0, rest.find(", "));
  }

  /// What such a unit is in this system.
  double size_of(const Unit& unit) const {
    const double base[] = {length, time, mass, charge};
    double size = unit.size;
    for (std::size_t k = 0; k < 4; ++k)
      if (unit.powers[k] != 0) size /= std::pow(base[k], unit.powers[k]);
    return size;
  }
};

/// Whether that is the unit of an angle: one name, without a power.
inline bool is_angle(const std::string& unit) {
  return read_unit(unit).powers == Unit().powers &&
         std::all_of(unit.begin(), unit.end(), [](unsigned char c) { return std::isalpha(c) != 0; });
}

/// Reads "0.3", in units of the system, or "0.3 km/s", and gives the number in those units. `wanted` is any
/// unit of the kind that is meant. Throws std::invalid_argument for anything else, and for zero and less
/// where it has to be positive.
inline double read_quantity(const std::string& text, const std::string& wanted, const UnitSystem& system,
                            bool positive = false) {
  const auto refuse = [&](const std::string& why) { throw std::invalid_argument("'" + text + "' " + why); };
  double value = 0;
  const std::size_t digits = std::min(text.find_first_not_of(" \t"), text.size());
  const char *begin = text.data() + digits, *const end = text.data() + text.size();
  if (end - begin > 1 && *begin == '+' && begin[1] != '-') ++begin;
  const auto [rest, failure] = std::from_chars(begin, end, value);
  if (failure != std::errc() || !std::isfinite(value) || (positive && !(value > 0)))
    refuse(std::string("is not a ") + (positive ? "positive" : "finite") + " number");
  std::string behind(rest, end);
  behind.erase(behind.find_last_not_of(" \t") + 1);
  if (behind.empty()) return value;
  if (wanted.empty()) refuse("has a unit, and a plain number is wanted");
  behind.erase(0, behind.find_first_not_of(" \t"));
  const Unit unit = read_unit(behind), meant = read_unit(wanted);
  if (unit.powers == Unit().powers && !is_angle(behind)) refuse("is no angle; give it as 30deg");
  if (unit.powers != meant.powers)
    refuse("is a " + dimension(unit) + ", and a " + dimension(meant) + " is wanted");
  const double size = system.size_of(unit), converted = value * size;
  if (!std::isfinite(size))
    refuse("has a unit, and this preset counts in " + system.about + "; give a plain number");
  if (!std::isfinite(converted) || (positive && !(converted > 0)))
    refuse("is out of range in the units of the preset, " + system.about);
  return converted;
}

/// The same of what was given to an option, which is named in what is thrown.
inline double read_option(const std::string& option, const std::string& text, const std::string& wanted,
                          const UnitSystem& system, bool positive = false) {
  try {
    return read_quantity(text, wanted, system, positive);
  } catch (const std::invalid_argument& error) {
    throw std::invalid_argument("--" + option + ": " + error.what());
  }
}

}  // namespace examples
