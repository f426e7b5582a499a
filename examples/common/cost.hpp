#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <limits>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include <semiexplicit/accuracy.hpp>

#include "arguments.hpp"
#include "output.hpp"
#include "prepare_outputs.hpp"
#include "run.hpp"
#include "units.hpp"

namespace examples {

/// What an accuracy with a unit asks for: the largest error of a direction over the run, in radians, for a
/// figure of that name.
struct AngleTarget {
  std::function<Eigen::VectorXd(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p)>
      direction{};
  double target = 0;
  double longest_dt = 0;         ///< with which it can be measured
  std::string figure{}, unit{};  ///< that the figure is given in
};

/// The options --cost, what accuracy costs, and --accuracy, choose a method and a step for me.
struct CostRequest {
  bool curve = false;
  double accuracy = 0;  ///< relative, of the energy; of an angle where there is a unit
  std::string unit{};   ///< behind it
  std::string by = "seconds";
  bool with_gauss = true;  ///< false: what the program measures asks for a projected step
  std::optional<CostRow> chosen{};

  /// `angles`: the program measures some, which an accuracy with a unit is about.
  void add_to(CLI::App& app, bool angles = false) {
    auto* const flag =
        app.add_flag("--cost", curve, "print what accuracy costs here, and draw it, instead of a long run");
    app.add_option("--accuracy", text_,
                   std::string("largest relative energy error") +
                       (angles ? ", or with a unit that of the angle which the preset measures" : "") +
                       ": choose the cheapest method and step for it, and run")
        ->check(CLI::Validator([this](std::string& text) { return read(text); }, "", "accuracy"))
        ->type_name(angles ? "X[ UNIT]" : "X")
        ->excludes(flag);
    add_value(app, "--cost-by", by, "what cheap means: seconds, gradients", one_of({"seconds", "gradients"}),
              "NAME");
  }

  /// Whether one of them is there. Throws std::invalid_argument where the user has chosen a method or a step
  /// as well.
  bool wanted(const CLI::App& app) const {
    if (!curve && app.count("--accuracy") == 0) {
      if (app.count("--cost-by") > 0)
        throw std::invalid_argument("--cost-by goes with --cost or --accuracy; give one of them");
      return false;
    }
    for (const char* other : {"--dt", "--list", "--method", "--scheme", "--solver", "--rule", "--tolerance",
                              "--omega", "--stages"})
      if (is_given(app, other))
        throw std::invalid_argument(std::string(other) + " is what " + (curve ? "--cost" : "--accuracy") +
                                    " is to find out; leave one of them out");
    return true;
  }

  /// Finds the costs of a run from z0. Shows them, and gives true: there is nothing else to do; or takes the
  /// cheapest setting for the accuracy, says why, and puts it into method and settings. Throws
  /// std::runtime_error where the accuracy is out of reach.
  template <class H, class State>
  bool answer(const H& hamiltonian, const State& z0, Method& method, Settings& settings,
              const std::string& file, const std::string& title, const AngleTarget& angle = {}) {
    CostOptions options{.by = cost_by(), .reversible = false};  // the programs' steps are of one size
    if (!with_gauss) options.gauss_stages.clear();
    double target = accuracy;
    if (angle.direction) {
      options.observable = angle.direction;
      options.absolute = true;
      target = angle.target / safety;
      longest_dt_ = angle.longest_dt;
      aim_at(angle.figure, angle.unit);
    } else if (!unit.empty()) {
      throw std::invalid_argument(
          "--accuracy: no angle is measured here; give a relative energy error, as 1e-9");
    }
    if (!curve) options.targets = {target};
    prepare(settings, file);
    const CostTable cost = cost_of_accuracy(hamiltonian, z0, settings.time, options);
    if (curve) {
      std::cout << told(cost);
      write(cost, settings, file, title);
    } else {
      if (angle.direction)
        std::cout << "errors are those of the direction over the whole time, in radians: "
                  << formatted("%g ", accuracy) << unit << " of the " << angle.figure
                  << formatted(" are %.2e; a third of that is aimed at, to be safe\n", angle.target);
      choose(cost, target, method, settings);
    }
    return curve;
  }

  CostBy cost_by() const { return by == "seconds" ? CostBy::seconds : CostBy::gradients; }

  /// The accuracy with a unit is about a figure that is given in figure_unit; gives it in that unit.
  double aim_at(const std::string& figure, const std::string& figure_unit) {
    figure_ = figure;
    figure_unit_ = figure_unit;
    return asked_ = accuracy * read_unit(unit).size / read_unit(figure_unit).size;
  }
  /// Estimates are good to a factor of three: of a figure a third of what is asked for is looked for.
  static constexpr double safety = 3;

  /// Takes the cheapest setting for a target, and throws std::runtime_error, saying why, where there is none.
  /// The target is what the accuracy is in the table, or `safely` times less.
  const CostRow& choose(const CostTable& cost, double target, double safely = 1) {
    chosen = cost.cheapest(target);
    if (chosen) return *chosen;
    const std::string unit_behind = unit.empty() ? "" : " " + unit;
    const auto as_asked = [&](double error) {  // in its unit, and as cautious
      return formatted("%.2e", error * (accuracy / target)) + unit_behind +
             (safely > 1 ? formatted(" (%g times the estimate)", safely) : "");
    };
    std::string why = "--accuracy " + formatted("%g", accuracy) + unit_behind + " is out of reach";
    if (std::none_of(cost.rows.begin(), cost.rows.end(), works))
      why += "; no setting works";
    else if (const auto best = cost.best(); !best)
      why += "; no setting was seen to the end";
    else if (best->error > target)  // else it has another reason, which comes next
      why += ": the best found is " + as_asked(best->error) + " by " + best->setting.name() +
             " with dt = " + formatted("%.3g", best->setting.dt);
    const Reach reach = cost.reach(target);
    throw std::runtime_error(
        why + "; " +
        (safely > 1 && reach == Reach::rounding
             ? "errors below " + as_asked(cost.rounding) + " cannot be told from rounding"
         : reach == Reach::budget
             ? "the motion is too long and uneven for the search; give a shorter --time, or --dt instead"
         : reach == Reach::orbit_ends ? formatted("no step goes beyond t = %.3g, where the orbit ends, or is "
                                                  "too hard; give a shorter --time",
                                                  cost.orbit_end)
                                      : cost.why(target)));
  }
  /// In what the cheapest is the cheapest, and of how many.
  std::string among(const CostTable& cost) const {
    return std::string("the cheapest in ") + (by == "seconds" ? "processor time" : "gradient calls") +
           " of " + std::to_string(cost.rows.size()) + " settings tried";
  }

  /// Says what came of the choice. Gives the complaint where the figure is not as accurate as it was to be,
  /// for when the results are written; else nothing.
  std::string compare_with(const Run& run) const {
    if (!run.is_result()) return "";
    if (!figure_.empty()) return compare_with_figure(run.figure_error(figure_));
    compare_with_energy(run.quantities.front().worst);
    return "";
  }
  void compare_with_energy(double error) const {
    if (chosen)
      std::cout << formatted("energy error: %.1e asked for, %.1e expected, %.1e reached", accuracy,
                             chosen->error, error)
                << (error <= accuracy ? "\n" : "; give a smaller --accuracy where that is too much\n");
  }
  /// The error of the figure by a companion run; nothing where it was not measured.
  std::string compare_with_figure(const std::optional<FigureError>& error) const {
    if (!chosen) return "";
    const std::string asked = figure_ + formatted(": %g ", asked_) + figure_unit_ + " asked for, ";
    if (!error)
      return asked +
             "and its error was not measured: the run is too short for the figure, or a companion run has "
             "parted from it; give more --time, or a smaller --accuracy, or a --dt instead";
    const std::string reached = asked + formatted("%.1e reached by the trajectory", error->by_trajectory);
    if (!(error->by_trajectory <= asked_)) return reached + "; give a smaller --accuracy, or a --dt instead";
    if (!(error->all() <= asked_))
      return reached +
             formatted(", but such steps over so short a time leave ± %.1g by measuring",
                       error->by_measuring) +
             "; give more --time, or a --dt smaller than this one instead of --accuracy";
    std::cout << reached << ", as a companion run with shorter steps tells"
              << (error->by_measuring > 0 ? formatted(", and ± %.1g by measuring", error->by_measuring) : "")
              << '\n';
    return "";
  }

  /// prepare_outputs() for what write() writes, if it is to.
  void prepare(const Settings& settings, const std::string& file) const {
    prepare_outputs(settings, curve ? outputs(settings, file) : std::vector<std::filesystem::path>());
  }
  /// What write() writes.
  static std::vector<std::filesystem::path> outputs(const Settings& settings, const std::string& file) {
    return {settings.output / (file + ".csv"), settings.output / (file + ".png")};
  }
  /// The rows in <file>.csv, and error against cost in <file>.png, a curve a method.
  static void write(const CostTable& cost, const Settings& settings, const std::string& file,
                    const std::string& title,
                    const std::string& error = "largest relative energy error, expected") {
    const auto both = outputs(settings, file);
    const std::filesystem::path &csv = both[0], &png = both[1];
    write_whole(csv, [&](std::ostream& out) {
      out.precision(9);
      out << "method,solver,dt,error,gradients,seconds,limit,works\n";
      for (const CostRow& row : cost.rows)
        out << row.setting.name() << ',' << row.setting.solver() << ',' << row.setting.dt << ',' << row.error
            << ',' << row.gradients << ',' << row.seconds << ',' << static_cast<int>(row.limit) << ','
            << row.works() << '\n';
    });
    std::cout << "data: " << csv.string() << '\n';
    if (settings.no_plot) return;

    const bool seconds = cost.by == CostBy::seconds;
    const double most = cost.relative ? 1 : std::numeric_limits<double>::max();  // nothing is left beyond
    const auto shown = [&](const CostRow& row) {                                 // on logarithmic axes
      return row.works() && row.error > 0 && row.error <= most && (seconds ? row.seconds : row.gradients) > 0;
    };
    if (std::none_of(cost.rows.begin(), cost.rows.end(), shown))
      return tell_no_picture(
          png, std::any_of(cost.rows.begin(), cost.rows.end(), works)
                   ? "no setting has a known error, up to 1 where it is relative, and a cost above 0, as "
                     "logarithmic axes want them"
                   : "no setting works; give a shorter --time, or another start");
    std::ostringstream out;
    out << gnuplot_prologue(png, 1200, 800) << "set title "
        << quoted(title + ": what accuracy costs over T = " + formatted("%g", cost.time)) << " noenhanced\n"
        << "set logscale xy\nset format '10^{%T}'\nset xrange [*:*] reverse\n"
        << "set xlabel " << quoted(error) << "\nset ylabel '"
        << (seconds ? "seconds of processor time" : "gradient calls") << "'\n"
        << "set key outside right noenhanced\nset grid linetype 1 linewidth 0.5 linecolor rgb '#d8d8d8'\n"
        << "plot NaN notitle";
    std::vector<std::string> drawn;
    for (const CostRow& row : cost.rows) {
      const std::string method = row.setting.name();
      if (!shown(row) || std::find(drawn.begin(), drawn.end(), method) != drawn.end()) continue;
      drawn.push_back(method);
      out << ", \\\n  " << quoted(csv.string()) << " skip 1 using (stringcolumn(1) eq " << quoted(method)
          << " && $8 == 1 && $4 <= " << most << " ? $4 : NaN):" << (seconds ? 6 : 5)
          << " with linespoints linewidth 2 pointtype " << 4 + drawn.size()
          << (row.setting.is_gauss() ? " dashtype 2" : "") << " title " << quoted(method);
    }
    out << '\n';
    draw(png, out.str(), {csv});
  }

 private:
  /// Reads a number from 1e-300 to 0.1, or one with a unit of an angle behind it; says what is wrong.
  std::string read(const std::string& text) {
    const char* const end = text.data() + text.size();
    const auto [rest, failure] = std::from_chars(text.data(), end, accuracy);
    unit.assign(rest, end);
    unit.erase(0, unit.find_first_not_of(" \t"));
    unit.erase(unit.find_last_not_of(" \t") + 1);
    if (failure != std::errc() || !std::isfinite(accuracy) || !(accuracy >= 1e-300) ||
        (unit.empty() && accuracy > 0.1))
      return "'" + text +
             "' is no accuracy: a relative energy error from 1e-300 to 0.1, or, of a program that measures "
             "one, an angle as \"0.001 arcsec\"";
    if (unit.empty()) return "";
    try {
      if (is_angle(unit)) return "";
      return "'" + text + "' is no angle; give one in rad, deg or arcsec";
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
  }

  static bool works(const CostRow& row) { return row.works(); }
  /// The table, with advice that a program can follow.
  static std::string told(const CostTable& cost) {
    std::ostringstream out;
    out << cost;
    std::string text = out.str();
    static const std::string options = "raise options.budget, min_gradients or max_gradients";
    for (std::size_t at = 0; (at = text.find(options, at)) != std::string::npos;)
      text.replace(at, options.size(), "give a shorter --time");
    return text;
  }

  std::string text_, figure_, figure_unit_;
  double asked_ = 0;  ///< the accuracy in the unit of the figure
  double longest_dt_ = std::numeric_limits<double>::infinity();

  void choose(const CostTable& cost, double target, Method& method, Settings& settings) {
    const Setting& setting = choose(cost, target, unit.empty() ? 1 : safety).setting;
    method.name = setting.method == Setting::Method::semiexplicit ? "semiexplicit"
                  : setting.method == Setting::Method::midpoint   ? "midpoint"
                  : setting.method == Setting::Method::splitting  ? "splitting"
                                                                  : "gauss";
    if (!setting.is_gauss()) method.scheme = setting.scheme;
    method.tolerance = setting.rule.tolerance;
    method.stages = std::max(1, setting.stages);
    method.lanes = setting.method == Setting::Method::gauss_lanes;
    const bool too_long = setting.dt > longest_dt_;
    settings.dt = std::min(too_long ? longest_dt_ : setting.dt, settings.time);
    settings.fit_steps();  // as many as were tried
    std::cout << told(cost) << "\nchosen: " << setting.name() << ", dt = " << formatted("%.4g", settings.dt)
              << (too_long ? " (shorter than it could be, to measure the figure)" : "") << ", " << among(cost)
              << "\n\n";
  }
};

}  // namespace examples
