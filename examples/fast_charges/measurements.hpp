#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/scene_choice.hpp"
#include "effects.hpp"

namespace examples {

/// γmv at the start.
inline double momentum_of(const Choice& c) {
  if (c.has("rigidity")) return std::abs(c["charge"]) * c["rigidity"] / c["c"];
  const double gamma = c["gamma"];
  return c["mass"] * c["c"] * std::sqrt(gamma * gamma - 1);
}

/// γ at the start.
inline double gamma_of(const Choice& c) {
  return c.has("rigidity") ? std::hypot(1.0, momentum_of(c) / (c["mass"] * c["c"])) : c["gamma"];
}

/// Is a field on, alone or with the motion itself? Else the formulas are for something else.
inline bool only_field(const Choice& c, const std::string& field) {
  return c.only({field}) || c.only({"kinetic", field});
}

inline Measurement<3> fast_gyration(const Choice& c) {
  const auto turning = std::make_shared<Turning>();
  const bool alone = only_field(c, "uniform_field");
  return {[=](double t, const In<double, 3>& q, const In<double, 3>&) { turning->see(t, q[0], q[1]); },
          [=](std::ostream& out, const Run&) {
            const double across = std::abs(std::sin(c["pitch"]));
            const double rate = c["charge"] * c["b"] / (gamma_of(c) * c["mass"]);
            const std::string coarse = too_coarse(turning->largest(rate));
            const std::string why = !alone            ? "the formula holds for uniform_field alone"
                                    : across < 1e-12  ? "it moves along the field"
                                    : !coarse.empty() ? coarse
                                    : std::abs(turning->turned()) < 2 * std::numbers::pi
                                        ? "the run has no whole turn; give more --time"
                                        : "";
            if (!why.empty()) return print_none(out, "gyrofrequency", why);
            print_comparison(out, "gyrofrequency, rad/s", -turning->rate(), "eB/(γm)", rate);
            print_comparison(out, "gyroradius, m", turning->mean_radius(), "p/(eB)",
                             momentum_of(c) * across / std::abs(c["charge"] * c["b"]));
          },
          memory_of(turning)};
}

/// The first place and the last, and how far it went along one axis and to the middle.
struct Way {
  bool begun = false;
  double t0 = 0, t = 0;
  Largest widest, closest;         ///< x, -x
  double highest = 0, across = 0;  ///< the largest |y|, and canonical momentum across z
  double longest = 0;              ///< the way of a step
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first;
  void see(double now, const In<double, 3>& q, const In<double, 3>& p) {
    if (!std::exchange(begun, true)) {
      first = last = q;
      t0 = now;
    }
    longest = std::max(longest, (q - last).norm());
    last = q;
    t = now;
    widest.see(q[0]);
    closest.see(-q[0]);
    highest = std::max(highest, std::abs(q[1]));
    across = std::max(across, p.head<2>().norm());
  }
  /// Why nothing is measured where so many steps at least are to go through a length; empty where they do.
  std::string too_coarse(const std::string& what, double length, int least) const {
    const double part = longest / length;
    if (part <= 1.0 / least) return "";
    return formatted("a step goes through %.2g of ", part) + what +
           formatted("; give a --dt %.0f times smaller", std::ceil(2 * least * part));
  }
  void visit_memory(CheckpointMemory& visit) {
    visit(begun);
    for (double* number : {&t0, &t, &highest, &across, &longest}) visit(*number);
    widest.visit_memory(visit);
    closest.visit_memory(visit);
    visit(first);
    visit(last);
  }
};
/// `figures(way)`: those whose error a companion run is to tell; optional.
template <class Report>
Measurement<3> of_way(const Choice& c, const std::string& field, const Report& report,
                      const std::function<std::vector<Figure>(const Way&)>& figures = {}) {
  const auto way = std::make_shared<Way>();
  Measurement<3> measurement{
      [=](double t, const In<double, 3>& q, const In<double, 3>& p) { way->see(t, q, p); },
      [=](std::ostream& out, const Run& run) {
        if (only_field(c, field)) return report(out, *way, run);
        print_none(out, field, "the formulas hold for this field alone");
      },
      memory_of(way)};
  if (figures) measurement.figures = [=] { return figures(*way); };
  return measurement;
}

/// print_comparison() where a formula holds to a per cent or so, which is as long as nothing is in `off`,
/// else the measured figure alone.
inline void print_where_it_holds(std::ostream& out, const std::string& what, double measured,
                                 const std::string& reference, double expected, const std::string& off,
                                 double uncertain = 0) {
  if (off.empty())
    print_comparison(out, what, measured, reference, expected, uncertain);
  else
    print_figure(out, what, measured, off, uncertain);
}

/// "the slope is 0.65, and is to be below 0.1", or nothing where it is.
inline std::string too_large(const std::string& what, double value, double limit) {
  return value < limit ? "" : what + formatted(" is %.2g, and is to be below %g", value, limit);
}

/// Source: Wille (2000), chapter 9.
inline Measurement<3> wiggle(const Choice& c) {
  return of_way(c, "undulator", [=](std::ostream& out, const Way& way, const Run&) {
    const double period = c["period"], k = 2 * std::numbers::pi / period;
    const double strength = std::abs(c["charge"] * c["b0"]) / (c["mass"] * c["c"] * k), gamma = gamma_of(c);
    const double passed = (way.last - way.first)[2] / period;
    if (strength == 0) return print_none(out, "wiggle", "there is no field");
    if (std::abs(std::sin(k * way.first[2])) > 1e-9)
      return print_none(out, "wiggle",
                        "it starts where A is not 0 and so drifts aside; give a --z of whole half periods");
    if (passed < 5) return print_none(out, "wiggle", "it is less than five periods; give more --time");
    if (const std::string coarse = way.too_coarse("a period", period, 8); !coarse.empty())
      return print_none(out, "wiggle", coarse);
    out << formatted("K = eB/(mck) = %.6g, %.1f periods\n", strength, passed);
    const double slope = strength * c["mass"] * c["c"] / momentum_of(c),
                 behind = (1 + strength * strength / 2) / (gamma * gamma);
    std::string off = too_large("k|y|", k * way.highest, 0.1);
    if (off.empty()) off = too_large("the slope K/(γβ)", slope, 0.1);
    print_where_it_holds(out, "wiggle, m", (way.widest.value() + way.closest.value()) / 2, "K/(γβk)",
                         slope / k, off, (way.widest.uncertain() + way.closest.uncertain()) / 2);
    if (off.empty()) off = too_large("(1 + K²/2)/γ²", behind, 0.01);
    const double light = c["c"] * (way.t - way.t0), slippage = (light - (way.last - way.first)[2]) / passed,
                 rounding = std::numeric_limits<double>::epsilon() * light / passed;
    if (!(std::abs(slippage) > rounding))
      return print_none(
          out, "slippage a period, m",
          formatted("it is lost in rounding, which is ± %.1g; ", rounding) + "give a smaller --gamma");
    print_where_it_holds(out, "slippage a period, m", slippage, "λ(1 + K²/2)/(2γ²)", period * behind / 2, off,
                         rounding);
  });
}

inline Measurement<3> rotation(const Choice& c) {
  const std::string what = "turn of the plane, rad, but for half turns";
  const charges::SolenoidField field(c["b0"], c["length"], c["radius"]);
  const auto larmor = [=](const Way& way) {
    return -c["charge"] * field.integral(way.first[2], way.last[2]) / (2 * momentum_of(c));
  };
  // A plane is the same after half a turn.
  const auto turn = [=](const Way& way) {
    const double pi = std::numbers::pi,
                 angle = std::atan2(way.first[0] * way.last[1] - way.first[1] * way.last[0],
                                    way.first.head<2>().dot(way.last.head<2>()));
    return angle + pi * std::round((larmor(way) - angle) / pi);
  };
  const auto report = [=](std::ostream& out, const Way& way, const Run& run) {
    if (way.first.head<2>().isZero(0)) return print_none(out, "turn of the plane", "it starts on the axis");
    if (const std::string coarse = way.too_coarse("the solenoid", c["length"], 4); !coarse.empty())
      return print_none(out, "turn of the plane", coarse);
    const auto error = run.figure_errors.find(what);
    if (error == run.figure_errors.end())
      return print_none(out, "turn of the plane",
                        "no companion run tells its error; give a smaller --dt, or another --method");
    const double from_axis = way.first.head<2>().norm();
    std::string off =
        too_large("the distance from the axis, in radii of the solenoid,", from_axis / c["radius"], 1);
    if (off.empty())
      off = too_large("the slope eBρ/(2p)",
                      std::abs(c["charge"] * c["b0"]) * from_axis / (2 * momentum_of(c)), 0.1);
    print_where_it_holds(out, what, turn(way), "Larmor, -e∫B dz/(2p)", larmor(way), off,
                         error->second.by_trajectory);
  };
  return of_way(c, "solenoid", report, [=](const Way& way) {
    return std::vector<Figure>{{what, turn(way)}};
  });
}

inline Measurement<3> focusing(const Choice& c) {
  return of_way(c, "quadrupole", [=](std::ostream& out, const Way& way, const Run&) {
    const double kappa = c["charge"] * c["slope"] / momentum_of(c), z = (way.last - way.first)[2];
    const auto grown = [&](double k) {
      return k > 0 ? std::cos(std::sqrt(k) * z) : std::cosh(std::sqrt(-k) * z);
    };
    for (const int i : {0, 1}) {
      const std::string what = std::string(i == 0 ? "x" : "y") + " at the end, of that at the start";
      if (way.first[i] == 0)
        print_none(out, what, "it starts at 0");
      else
        print_where_it_holds(out, what, way.last[i] / way.first[i], "cos or cosh(√|κ| z)",
                             grown(i == 0 ? kappa : -kappa),
                             too_large("the slope", way.across / momentum_of(c), 0.1));
    }
  });
}

/// Stoermer's lemma: with the angular momentum L about the dipole, kept, sin χ = v_φ/v = L/(pρ) - eMρ/(pr³);
/// where its absolute value is above 1 no charge of this momentum can be. C. Störmer, The Polar Aurora
/// (1955).
struct Stoermer {
  double per_momentum, square;  ///< L/p and eM/p

  explicit Stoermer(const Choice& c, const Vector<double, 3>& q, const Vector<double, 3>& p)
      : per_momentum((q[0] * p[1] - q[1] * p[0]) / momentum_of(c)),
        square(c["charge"] * c["moment"] / momentum_of(c)) {}
  double sine(double rho, double z) const {
    const double r = std::hypot(rho, z);
    return per_momentum / rho - square * rho / (r * r * r);
  }
  bool forbidden(double rho, double z) const { return std::abs(sine(rho, z)) > 1; }
};

inline Measurement<3> stoermer(const Choice& c) {
  struct Seen {
    bool begun = false;
    double l = 0, turn = 0, azimuth = 0;  ///< the last two: the largest turn from step to step
    Eigen::Vector3d last = Eigen::Vector3d::Zero(), way = last;
    Largest closeness, sine;
    void visit_memory(CheckpointMemory& visit) {
      visit(begun);
      visit(l);
      visit(turn);
      visit(azimuth);
      visit(last);
      visit(way);
      closeness.visit_memory(visit);
      sine.visit_memory(visit);
    }
  };
  const auto seen = std::make_shared<Seen>();
  return {[=](double, const In<double, 3>& q, const In<double, 3>& p) {
            if (!std::exchange(seen->begun, true)) {
              seen->l = q[0] * p[1] - q[1] * p[0];
              seen->last = q;
            }
            const Eigen::Vector3d way = q - seen->last;
            seen->turn = std::max(seen->turn, angle_between(seen->way, way));
            const Eigen::Vector3d across(1, 1, 0);
            seen->azimuth = std::max(seen->azimuth,
                                     angle_between(seen->last.cwiseProduct(across), q.cwiseProduct(across)));
            seen->last = q;
            seen->way = way;
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            seen->closeness.see(-q.norm());
            seen->sine.see(std::abs(region.sine(std::hypot(q[0], q[1]), q[2])));
          },
          [=](std::ostream& out, const Run&) {
            if (!only_field(c, "dipole_field"))
              return print_none(out, "Stoermer's region", "the formula holds for dipole_field alone");
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            if (!std::isnormal(region.square) || !std::isfinite(seen->sine.value()))
              return print_none(out, "Stoermer's region", "there is no field, or no momentum");
            const std::string unit = ", " + c.units.name(0) + ": ";
            out << formatted("Stoermer's length%s%.6g; angular momentum over it: %.6g\n", unit.c_str(),
                             std::sqrt(std::abs(region.square)),
                             region.per_momentum / std::sqrt(std::abs(region.square)));
            if (const std::string coarse = too_coarse(seen->turn); !coarse.empty())
              return print_none(out, "largest |sin χ|, and the place nearest to the dipole", coarse);
            // About the axis it peaks as sharply as the path is near to it.
            if (const std::string coarse = too_coarse(seen->azimuth, std::numbers::pi / 6); !coarse.empty())
              print_none(out, "largest |sin χ| on the way", "about the axis " + coarse);
            else
              out << "largest |sin χ| on the way: "
                  << with_uncertainty(seen->sine.value(), seen->sine.uncertain()) << "; forbidden: above 1\n";
            out << "nearest to the dipole" << unit
                << with_uncertainty(-seen->closeness.value(), seen->closeness.uncertain()) << '\n';
          },
          memory_of(seen)};
}

}  // namespace examples
