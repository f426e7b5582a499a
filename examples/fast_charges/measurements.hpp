#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
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
            const std::string coarse =
                across < 1e-12 ? "it moves along the field" : too_coarse(turning->largest());
            if (!alone || !coarse.empty())
              return print_none(out, "gyrofrequency",
                                alone ? coarse : "the formula holds for uniform_field alone");
            print_comparison(out, "gyrofrequency, rad/s", -turning->rate(), "eB/(γm)",
                             c["charge"] * c["b"] / (gamma_of(c) * c["mass"]));
            print_comparison(out, "gyroradius, m", turning->mean_radius(), "p/(eB)",
                             momentum_of(c) * across / std::abs(c["charge"] * c["b"]));
          },
          memory_of(turning)};
}

/// The first place and the last, and how far it went along one axis and to the middle.
struct Way {
  bool begun = false;
  double t0 = 0, t = 0, widest = -INFINITY, closest = INFINITY, nearest = INFINITY;
  Eigen::Vector3d first = Eigen::Vector3d::Zero(), last = first;
  void see(double now, const In<double, 3>& q) {
    if (!std::exchange(begun, true)) {
      first = q;
      t0 = now;
    }
    last = q;
    t = now;
    widest = std::max(widest, q[0]);
    closest = std::min(closest, q[0]);
    nearest = std::min(nearest, q.norm());
  }
  void visit_memory(CheckpointMemory& visit) {
    visit(begun);
    for (double* number : {&t0, &t, &widest, &closest, &nearest}) visit(*number);
    visit(first);
    visit(last);
  }
};
template <class Report>
Measurement<3> of_way(const Choice& c, const std::string& field, const Report& report) {
  const auto way = std::make_shared<Way>();
  return {[=](double t, const In<double, 3>& q, const In<double, 3>&) { way->see(t, q); },
          [=](std::ostream& out, const Run&) {
            if (only_field(c, field)) return report(out, *way);
            print_none(out, field, "the formulas hold for this field alone");
          },
          memory_of(way)};
}

/// Source: Wille (2000), chapter 9.
inline Measurement<3> wiggle(const Choice& c) {
  return of_way(c, "undulator", [=](std::ostream& out, const Way& way) {
    const double period = c["period"], k = 2 * std::numbers::pi / period;
    const double strength = std::abs(c["charge"] * c["b0"]) / (c["mass"] * c["c"] * k), gamma = gamma_of(c);
    const double passed = (way.last - way.first)[2] / period;
    if (strength == 0) return print_none(out, "wiggle", "there is no field");
    if (std::abs(std::sin(k * way.first[2])) > 1e-9)
      return print_none(out, "wiggle",
                        "it starts where A is not 0 and so drifts aside; give a --z of whole half periods");
    if (passed < 5) return print_none(out, "wiggle", "it is less than five periods; give more --time");
    out << formatted("K = eB/(mck) = %.6g, %.1f periods\n", strength, passed);
    print_comparison(out, "wiggle, m", (way.widest - way.closest) / 2, "K/(γβk)",
                     strength * c["mass"] * c["c"] / (momentum_of(c) * k));
    print_comparison(out, "slippage a period, m",
                     (c["c"] * (way.t - way.t0) - (way.last - way.first)[2]) / passed, "λ(1 + K²/2)/(2γ²)",
                     period * (1 + strength * strength / 2) / (2 * gamma * gamma));
  });
}

inline Measurement<3> rotation(const Choice& c) {
  return of_way(c, "solenoid", [=](std::ostream& out, const Way& way) {
    const charges::SolenoidField field(c["b0"], c["length"], c["radius"]);
    if (way.first.head<2>().isZero(0)) return print_none(out, "turn of the plane", "it starts on the axis");
    const double pi = std::numbers::pi,
                 angle = std::atan2(way.first[0] * way.last[1] - way.first[1] * way.last[0],
                                    way.first.head<2>().dot(way.last.head<2>()));
    const double larmor = -c["charge"] * field.integral(way.first[2], way.last[2]) / (2 * momentum_of(c));
    // A plane is the same after half a turn.
    print_comparison(out, "turn of the plane, rad, but for half turns",
                     angle + pi * std::round((larmor - angle) / pi), "Larmor, -e∫B dz/(2p)", larmor);
  });
}

inline Measurement<3> focusing(const Choice& c) {
  return of_way(c, "quadrupole", [=](std::ostream& out, const Way& way) {
    const double kappa = c["charge"] * c["slope"] / momentum_of(c), z = (way.last - way.first)[2];
    const auto grown = [&](double k) {
      return k > 0 ? std::cos(std::sqrt(k) * z) : std::cosh(std::sqrt(-k) * z);
    };
    for (const int i : {0, 1}) {
      const std::string what = std::string(i == 0 ? "x" : "y") + " at the end, of that at the start";
      if (way.first[i] == 0)
        print_none(out, what, "it starts at 0");
      else
        print_comparison(out, what, way.last[i] / way.first[i], "cos or cosh(√|κ| z)",
                         grown(i == 0 ? kappa : -kappa));
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
    double l = 0, nearest = INFINITY, largest = 0;
    void visit_memory(CheckpointMemory& visit) {
      visit(begun);
      for (double* number : {&l, &nearest, &largest}) visit(*number);
    }
  };
  const auto seen = std::make_shared<Seen>();
  return {[=](double, const In<double, 3>& q, const In<double, 3>& p) {
            if (!std::exchange(seen->begun, true)) seen->l = q[0] * p[1] - q[1] * p[0];
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            seen->nearest = std::min(seen->nearest, q.norm());
            seen->largest = std::max(seen->largest, std::abs(region.sine(std::hypot(q[0], q[1]), q[2])));
          },
          [=](std::ostream& out, const Run&) {
            if (!only_field(c, "dipole_field"))
              return print_none(out, "Stoermer's region", "the formula holds for dipole_field alone");
            const Stoermer region(c, {1, 0, 0}, {0, seen->l, 0});
            if (!std::isnormal(region.square) || !std::isfinite(seen->largest))
              return print_none(out, "Stoermer's region", "there is no field, or no momentum");
            out << formatted("Stoermer's length: %.6g, angular momentum over it: %.6g\n",
                             std::sqrt(std::abs(region.square)),
                             region.per_momentum / std::sqrt(std::abs(region.square)))
                << formatted("largest |sin χ| on the way: %.10f; forbidden: above 1\n", seen->largest);
            out << formatted("nearest to the dipole: %.8g\n", seen->nearest);
          },
          memory_of(seen)};
}

}  // namespace examples
