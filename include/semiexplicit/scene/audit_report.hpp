#pragma once

#include <algorithm>
#include <iomanip>
#include <limits>
#include <locale>
#include <ostream>
#include <sstream>
#include <string>
#include <vector>

namespace semiexplicit {

/// What an audit found of one effect. Sizes and shares are numbers from 0 on; `infinite` where the scene does
/// not run without the effect.
struct AuditRow {
  static constexpr double infinite = std::numeric_limits<double>::infinity();

  std::string name;
  bool coupled = false;
  double seconds = 0;     ///< of one gradient of this effect alone
  double time_share = 0;  ///< of the time of all effects' gradients
  double size_max = 0;    ///< part of ∂H/∂q or ∂H/∂p along the orbit, the larger one
  double size_mean = 0;
  double shift_max =
      0;  ///< how far the orbit moves without it, relative to its largest distance from the origin
  double shift_final = 0;               ///< the same at the end
  std::vector<double> invariant_shift;  ///< how far each of Audit::invariants strays without it, relative
};

/// What leaving an effect out means at a given accuracy.
enum class Verdict {
  called_for,      ///< the orbit moves by more than the accuracy
  not_called_for,  ///< it does not
  below_noise      ///< it moves by no more than a few times the numerical error, which is itself above the
                   ///< accuracy
};

/// What an audit found; see audit().
struct Audit {
  double t = 0, dt = 0;
  /// Numerical error of the orbit, as the shifts are measured: the distance to a run at dt/2. Where a smaller
  /// dt does not lower it, neighbouring orbits part, and only a shorter time tells the effects apart.
  double noise = 0;
  std::vector<std::string> invariants;
  std::vector<AuditRow> rows;  ///< in the scene's order
  std::string exact_flow;      ///< advice, see advised_flow(); empty: none, or the effects' types do not show

  /// Whether a shift stands out of the numerical error; where orbits part by themselves, both are of the
  /// orbit's size.
  bool above_noise(const AuditRow& row) const { return row.shift_max > 3 * noise; }
  /// `accuracy` is a distance between orbits as in AuditRow::shift_max.
  Verdict verdict(const AuditRow& row, double accuracy) const {
    if (row.shift_max > accuracy && above_noise(row)) return Verdict::called_for;
    return std::max(row.shift_max, noise) <= accuracy ? Verdict::not_called_for : Verdict::below_noise;
  }
  /// The effects that the scene calls for at that accuracy.
  std::vector<std::string> called_for(double accuracy) const { return named(accuracy, Verdict::called_for); }
  /// Those of which these runs cannot say.
  std::vector<std::string> undecided(double accuracy) const { return named(accuracy, Verdict::below_noise); }

 private:
  std::vector<std::string> named(double accuracy, Verdict wanted) const {
    std::vector<std::string> list;
    for (const AuditRow& row : rows)
      if (verdict(row, accuracy) == wanted) list.push_back(row.name);
    return list;
  }
};

/// A table, an effect a line. An asterisk marks a shift that does not stand out of the numerical error.
inline std::ostream& operator<<(std::ostream& to, const Audit& audit) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  std::size_t width = 6;
  for (const AuditRow& row : audit.rows) width = std::max(width, row.name.size());
  const auto name = [&](const std::string& text) {
    out << std::left << std::setw(static_cast<int>(width)) << text << std::right;
  };
  name("effect");
  out << "    time   size max  size mean  shift max  shift end";
  for (const std::string& invariant : audit.invariants) out << "  " << std::setw(10) << invariant;
  out << '\n';
  for (const AuditRow& row : audit.rows) {
    name(row.name);
    out << std::fixed << std::setprecision(1) << std::setw(7) << 100 * row.time_share << '%'
        << std::scientific;
    for (const double x : {row.size_max, row.size_mean, row.shift_max, row.shift_final})
      out << "  " << std::setw(9) << x;
    out << (audit.above_noise(row) ? ' ' : '*');  // takes one of the two places between columns
    for (std::size_t k = 0; k < row.invariant_shift.size(); ++k)
      out << (k == 0 ? " " : "  ")
          << std::setw(static_cast<int>(std::max<std::size_t>(10, audit.invariants[k].size())))
          << row.invariant_shift[k];
    out << '\n';
  }
  out << "numerical error of the orbit: " << std::scientific << std::setprecision(1) << audit.noise << '\n';
  if (!audit.exact_flow.empty()) out << audit.exact_flow << '\n';
  return to << out.str();
}

}  // namespace semiexplicit
