#pragma once

#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <limits>
#include <memory>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/gyration.hpp"
#include "../common/measurement.hpp"
#include "../common/method.hpp"
#include "../common/scene_choice.hpp"
#include "effects.hpp"

namespace examples {

/// What rounding makes of a difference, as a part of what it is taken of.
inline constexpr double few_roundings = 4 * std::numeric_limits<double>::epsilon();

/// γmv at the start.
inline double momentum_of(const Choice& c) {
  if (c.has("rigidity")) return std::abs(c["charge"]) * c["rigidity"] / c["c"];
  const double gamma = c["gamma"];
  return c["mass"] * c["c"] * std::sqrt((gamma - 1) * (gamma + 1));
}

/// γ at the start.
inline double gamma_of(const Choice& c) {
  return c.has("rigidity") ? std::hypot(1.0, momentum_of(c) / (c["mass"] * c["c"])) : c["gamma"];
}

inline Measurement<3> fast_gyration(const Choice& c) {
  const double across = std::abs(std::sin(c["pitch"]));
  return gyration(c, gamma_of(c) * c["mass"], momentum_of(c) * across, "eB/(γm)", "p/(eB)",
                  across < 1e-4 ? "it moves nearly along the field, and solvers stop by the whole momentum; "
                                  "give another --pitch"
                                : "");
}

/// The first place and the last, and how far it went along one axis and to the middle.
struct Way {
  bool begun = false;
  double t0 = 0, t = 0;
  Largest widest, closest;         ///< x, -x
  double highest = 0, across = 0;  ///< the largest |y|, and canonical momentum across z
  double longest = 0;              ///< the way of a step
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first, momentum = first;
  void see(double now, const In<double, 3>& q, const In<double, 3>& p) {
    if (!std::exchange(begun, true)) {
      first = last = q;
      t0 = now;
    }
    longest = std::max(longest, (q - last).norm());
    last = q;
    momentum = p;
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
    for (Eigen::Vector3d* vector : {&first, &last, &momentum}) visit(*vector);
  }
};
/// The figures(way, method) of a charge in one field.
inline Measurement<3> of_way(const Choice& c, const std::string& field,
                             const std::function<std::vector<Figure>(const Way&, const Method&)>& figures) {
  const auto way = std::make_shared<Way>();
  return {[=](double t, const In<double, 3>& q, const In<double, 3>& p) { way->see(t, q, p); },
          memory_of(way),
          [=](const Run& run) -> std::vector<Figure> {
            if (!c.only_field(field)) return {not_measured(field, "the formulas hold for this field alone")};
            return figures(*way, run.method);
          }};
}

/// "the slope is 0.65, and is to be below 0.1", or nothing where it is.
inline std::string too_large(const std::string& what, double value, double limit) {
  return value < limit ? "" : what + formatted(" is %.2g, and is to be below %g", value, limit);
}

/// Where in a step, of 1, a charge in uniform motion feels the field, and with what weight. Of methods that
/// have companions.
inline std::vector<std::pair<double, double>> felt_at(const Method& method) {
  std::vector<std::pair<double, double>> places;
  if (method.name == "gauss") {
    const GaussTableau<double> gauss(method.stages);
    for (int i = 0; i < method.stages; ++i) places.emplace_back(gauss.c[i], gauss.b[i]);
    return places;
  }
  double a = 0, b = 0;  // where the copies of the phase space are, whose mean is taken
  semiexplicit::detail::sweep(
      schemes::by_name<double>(method.scheme_name()), 1.0,
      [&](double t) { places.emplace_back(b, t / 2), a += t; },
      [&](double t) { places.emplace_back(a, t / 2), b += t; });
  return places;
}

/// By how much a step is longer than its dt, of 1: its weights are rounded.
inline double too_long(const Method& method) {
  long double sum = -1;
  for (const auto& [place, weight] : felt_at(method)) sum += weight;
  return static_cast<double>(sum);
}

/// Source: Wille (2000), chapter 9.
inline Measurement<3> wiggle(const Choice& c) {
  const double period = c["period"], k = 2 * std::numbers::pi / period;
  const double strength = std::abs(c["charge"] * c["b0"]) / (c["mass"] * c["c"] * k), gamma = gamma_of(c);
  Measurement<3> measurement =
      of_way(c, "undulator", [=](const Way& way, const Method& method) -> std::vector<Figure> {
        const auto none = [](const std::string& why) { return std::vector{not_measured("wiggle", why)}; };
        const double passed = (way.last - way.first)[2] / period;
        if (strength == 0) return none("there is no field");
        if (std::abs(std::sin(k * way.first[2])) > 1e-9)
          return none("it starts where A is not 0 and so drifts aside; give a --z of whole half periods");
        if (passed < 5) return none("it is less than five periods; give more --time");
        if (const std::string coarse = way.too_coarse("a period", period, 8); !coarse.empty())
          return none(coarse);
        const double slope = strength * c["mass"] * c["c"] / momentum_of(c),
                     behind = (1 + strength * strength / 2) / (gamma * gamma);
        std::string off = too_large("k|y|", k * way.highest, 0.1);
        if (off.empty()) off = too_large("the slope K/(γβ)", slope, 0.1);
        // Far from the origin places are rounded.
        const auto rounding_of = [](double place) {
          return std::numeric_limits<double>::epsilon() * std::abs(place);
        };
        std::vector<Figure> list{
            compared("wiggle, m", (way.widest.value() + way.closest.value()) / 2,
                     (way.widest.uncertain() + way.closest.uncertain()) / 2 + rounding_of(way.first[0]),
                     "K/(γβk)", slope / k, off)};
        if (off.empty()) off = too_large("(1 + K²/2)/γ²", behind, 0.01);
        const double light = c["c"] * (way.t - way.t0),
                     slippage = (light - (way.last - way.first)[2]) / passed,
                     farthest = std::max(std::abs(way.first[2]), std::abs(way.last[2]));
        // A companion's steps are as much too long.
        const double of_weights = 2 * std::abs(too_long(method)) * light,
                     rounding = (rounding_of(std::max(light, farthest)) + of_weights) / passed;
        list.push_back(std::abs(slippage) > rounding
                           ? compared("slippage a period, m", slippage, rounding, "λ(1 + K²/2)/(2γ²)",
                                      period * behind / 2, off)
                           : not_measured("slippage a period, m",
                                          formatted("it is lost in rounding, which is ± %.1g; ", rounding) +
                                              "give a smaller --gamma"));
        return list;
      });
  if (c.only_field("undulator"))
    measurement.heading = [=] { return formatted("K = eB/(mck) = %.6g\n", strength); };
  return measurement;
}

/// A bound on what steps `longest` long miss of ∫B dz through the ends of a solenoid, as a length of the
/// field B₀ within it, for a charge at ρ. By Poisson's sum that is made by the waves of B whose phase turns
/// by 2πm in a step; the transform of an end is B₀ R K₁(kR), to ρ² as in SolenoidField.
inline double missed_of_ends(const Method& method, double longest, double radius, double rho) {
  const auto places = felt_at(method);
  double missed = 0;
  for (int m = 1; m <= 100; ++m) {
    const double turn = 2 * std::numbers::pi * m, k = turn / longest;
    if (!(k * radius < 40)) break;
    std::complex<double> taken = 0;  // for constant, of such a wave
    for (const auto& [place, weight] : places) taken += weight * std::polar(1.0, turn * place);
    missed += std::abs(taken) * std::cyl_bessel_k(1.0, k * radius) * (1 + k * rho * k * rho / 8);
  }
  return 4 * radius * missed;
}

inline Measurement<3> rotation(const Choice& c) {
  const std::string what = "turn of the plane, rad, but for half turns";
  const charges::SolenoidField field(c["b0"], c["length"], c["radius"]);
  const auto larmor = [=](const Way& way) {
    return -c["charge"] * field.integral(way.first[2], way.last[2]) / (2 * momentum_of(c));
  };
  // A plane is the same after half a turn.
  const auto turn = [=](const Way& way) {
    const double pi = std::numbers::pi;
    const Eigen::Vector2d first = way.first.head<2>().stableNormalized(),  // a square of places may be zero
        last = way.last.head<2>().stableNormalized();
    const double angle = std::atan2(first[0] * last[1] - first[1] * last[0], first.dot(last));
    return angle + pi * std::round((larmor(way) - angle) / pi);
  };
  return of_way(c, "solenoid", [=](const Way& way, const Method& method) -> std::vector<Figure> {
    if (way.first.head<2>().isZero(0)) return {not_measured("turn of the plane", "it starts on the axis")};
    if (const std::string coarse = way.too_coarse("the solenoid", c["length"], 4); !coarse.empty())
      return {not_measured("turn of the plane", coarse)};
    const double from_axis = way.first.head<2>().norm();
    // Long steps and half as long ones may miss the same of the field's ends.
    const double turn_a_length = std::abs(c["charge"] * c["b0"]) / (2 * momentum_of(c));
    double missed = turn_a_length * missed_of_ends(method, way.longest, c["radius"], from_axis);
    std::string off =
        too_large("the distance from the axis, in radii of the solenoid,", from_axis / c["radius"], 1);
    const double slope = turn_a_length * from_axis;
    if (off.empty()) off = too_large("the slope eBρ/(2p)", slope, 0.1);
    // Else half turns could be counted so that it holds.
    if (off.empty())
      off = too_large("the slope's square times the turn", slope * slope * std::abs(larmor(way)), 0.5);
    // Of a small angle the rounding of both places is no small part.
    const double angle = turn(way);
    if (few_roundings > 1e-9 * std::abs(angle)) missed += few_roundings;
    return {compared(what, angle, missed, "Larmor, -e∫B dz/(2p)", larmor(way), off)};
  });
}

inline Measurement<3> focusing(const Choice& c) {
  return of_way(c, "quadrupole", [=](const Way& way, auto&) {
    std::vector<Figure> list;
    const double kappa = c["charge"] * c["slope"] / momentum_of(c), z = (way.last - way.first)[2];
    if (const std::string coarse =
            way.too_coarse("a wavelength", 2 * std::numbers::pi / std::sqrt(std::abs(kappa)), 8);
        !coarse.empty())
      return std::vector{not_measured("x and y at the end, of those at the start", coarse)};
    const auto grown = [&](double k) {
      return k > 0 ? std::cos(std::sqrt(k) * z) : std::cosh(std::sqrt(-k) * z);
    };
    for (const int i : {0, 1}) {
      const std::string what = std::string(i == 0 ? "x" : "y") + " at the end, of that at the start";
      if (way.first[i] == 0) {
        list.push_back(not_measured(what, "it starts at 0"));
        continue;
      }
      list.push_back(compared(what, way.last[i] / way.first[i], 0, "cos or cosh(√|κ| z)",
                              grown(i == 0 ? kappa : -kappa),
                              too_large("the slope", way.across / momentum_of(c), 0.1)));
      if (kappa != 0)
        list.back().quarter_later =
            way.momentum[i] / (momentum_of(c) * std::sqrt(std::abs(kappa)) * way.first[i]);
    }
    return list;
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
    double l = 0, turn = 0, azimuth = 0, about = 0;  ///< the last three: the largest turn from step to step
    double momentum = 0;                             ///< the largest, with that of the field
    Eigen::Vector3d last = Eigen::Vector3d::Zero(), way = last;
    Largest closeness, sine;
    void visit_memory(CheckpointMemory& visit) {
      visit(begun);
      visit(l);
      visit(turn);
      visit(azimuth);
      visit(about);
      visit(momentum);
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
            seen->about = std::max(seen->about, angle_between(seen->last, q));
            seen->last = q;
            seen->way = way;
            seen->momentum = std::max(seen->momentum, p.norm());
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            seen->closeness.see(-q.norm());
            seen->sine.see(std::abs(region.sine(std::hypot(q[0], q[1]), q[2])));
          },
          memory_of(seen),
          [=](const Run&) -> std::vector<Figure> {
            if (!c.only_field("dipole_field"))
              return {not_measured("Stoermer's region", "the formula holds for dipole_field alone")};
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            if (!std::isnormal(region.square) || !std::isfinite(seen->sine.value()))
              return {not_measured("Stoermer's region", "there is no field, or no momentum")};
            const std::string sine = "largest |sin χ| on the way";
            // The charge's own momentum is a difference from that of the field.
            const double lost = few_roundings * seen->momentum / momentum_of(c);
            std::string off = too_coarse(seen->turn);
            if (off.empty() && lost > 0.01)
              off = formatted("of the momentum a part of %.1g", lost) +
                    " is lost in rounding; give a larger --rigidity";
            if (!off.empty())
              return {not_measured("largest |sin χ|, and the place nearest to the dipole", off)};
            std::vector<Figure> list;
            // About the axis it peaks as sharply as the path is near to it.
            if (const std::string coarse = too_coarse(seen->azimuth, std::numbers::pi / 12); !coarse.empty())
              list.push_back(not_measured(sine, "about the axis " + coarse));
            else
              list.push_back({sine, seen->sine.value(), seen->sine.uncertain() + lost, "forbidden: above 1"});
            const std::string nearest = "nearest to the dipole, " + c.units.name(0);
            if (const std::string coarse = too_coarse(seen->about, std::numbers::pi / 12); !coarse.empty())
              list.push_back(not_measured(nearest, "about the dipole " + coarse));
            else
              list.push_back({nearest, -seen->closeness.value(), seen->closeness.uncertain()});
            return list;
          },
          {},
          [=]() -> std::string {
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            if (!c.only_field("dipole_field") || !std::isnormal(region.square)) return "";
            const double length = std::sqrt(std::abs(region.square));
            return "Stoermer's length, " + c.units.name(0) + formatted(": %.6g", length) +
                   formatted("; angular momentum over it: %.6g\n", region.per_momentum / length);
          }};
}

}  // namespace examples
