#pragma once

#include <cmath>
#include <memory>
#include <numbers>
#include <optional>
#include <ostream>
#include <utility>

#include <semiexplicit/semiexplicit.hpp>

#include "scene_choice.hpp"
#include "table.hpp"

namespace examples {

/// Follows an angle of the orbit from the first to the last upward passage of a function through zero. In between it turns
/// slowly, so that a straight line between the two steps about a passage is enough.
class Passages {
 public:
  void see(double t, double function, double angle) {
    if (seen_ && last_function_ < 0 && function >= 0) {
      const double w = last_function_ / (last_function_ - function);
      const double at = last_t_ + w * (t - last_t_), turned = last_angle_ + w * near(angle - last_angle_);
      if (!first_t_) {
        first_t_ = at;
      } else {
        turned_ += near(turned - at_passage_);
        passed_ = at - *first_t_;
        ++orbits_;
      }
      at_passage_ = turned;
    }
    seen_ = true;
    last_t_ = t;
    last_function_ = function;
    last_angle_ = angle;
  }
  int orbits() const { return orbits_; }
  double per_orbit() const { return turned_ / orbits_; }
  double per_time() const { return turned_ / passed_; }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    visit(orbits_);
    bool begun = first_t_.has_value();
    double first = first_t_.value_or(0.0);
    visit(begun);
    for (double* number : {&first, &last_t_, &last_function_, &last_angle_, &at_passage_, &turned_, &passed_})
      visit(*number);
    if (begun) first_t_ = first;
  }

 private:
  static double near(double angle) { return std::remainder(angle, 2 * std::numbers::pi); }
  bool seen_ = false;
  double last_t_ = 0, last_function_ = 0, last_angle_ = 0, at_passage_ = 0, turned_ = 0, passed_ = 0;
  std::optional<double> first_t_;
  int orbits_ = 0;
};

/// Mercury's perihelion. The Laplace-Runge-Lenz vector points to it at the passage.
inline Measurement<3> perihelion(const Choice& c) {
  auto passages = std::make_shared<Passages>();
  const double gm = c["gm"], a = c["a"], e = c["e"];
  const auto observe = [=](double t, const HalfRef<3>& q, const HalfRef<3>& p) {
    const double r = q.norm(), radial = q.dot(p), along = p.squaredNorm() / gm - 1 / r;
    passages->see(t, radial,
                  std::atan2(along * q[1] - radial * p[1] / gm, along * q[0] - radial * p[0] / gm));
  };
  double expected = 0, parameter = a * (1 - e * e);
  if (c.on("1pn")) expected += 6 * std::numbers::pi * gm / (c["c"] * c["c"] * parameter);
  if (c.on("j2")) expected += 3 * std::numbers::pi * c["j2"] * std::pow(c["radius"] / parameter, 2);
  const auto report = [=](std::ostream& out) {
    if (passages->orbits() == 0) {
      out << "perihelion advance: not measured, the run is shorter than two passages; give more --time\n";
      return;
    }
    const double arcseconds = 180 / std::numbers::pi * 3600,
                 a_century = 100 * std::sqrt(gm / (a * a * a)) / (2 * std::numbers::pi);
    out << "perihelion advance: "
        << formatted("%.4f arcseconds a century from %d orbits",
                     passages->per_orbit() * a_century * arcseconds, passages->orbits())
        << formatted("; 1PN and J2 to first order: %.4f\n", expected * a_century * arcseconds);
  };
  return {observe, report, memory_of(passages)};
}

/// How far the node of a tilted orbit turns.
inline Measurement<3> node(const Choice& c) {
  auto passages = std::make_shared<Passages>();
  const auto observe = [=](double t, const HalfRef<3>& q, const HalfRef<3>& p) {
    passages->see(t, q[2], std::atan2(q[1] * p[2] - q[2] * p[1], q[0] * p[2] - q[2] * p[0]));
  };
  const double a = c["a"], rate = std::sqrt(c["gm"] / (a * a * a)), flat = 1 - c["e"] * c["e"];
  const double expected =
      c.on("j2") ? -1.5 * rate * c["j2"] * std::pow(c["radius"] / (a * flat), 2) * std::cos(c["inclination"])
                 : 0;
  const auto report = [=](std::ostream& out) {
    if (passages->orbits() == 0) {
      out << "node: not measured, the run has no two upward passages through the equator; give more --time "
             "or "
             "an --inclination\n";
      return;
    }
    const double degrees_a_year = 180 / std::numbers::pi * 365.25 * 86400;
    out << formatted("node: %.4f degrees a year", passages->per_time() * degrees_a_year)
        << formatted(" from %d orbits; J2 to first order: ", passages->orbits())
        << formatted("%.4f\n", expected * degrees_a_year);
  };
  return {observe, report, memory_of(passages)};
}

/// How well the orbit closes, and Jacobi's constant.
inline Measurement<3> closure(const Choice& c) {
  struct Seen {
    bool begun = false;
    PhasePoint<double, 3> first, last;
    void visit_memory(CheckpointMemory& visit) {
      visit(begun);
      visit(first.vector());
      visit(last.vector());
    }
  };
  const auto seen = std::make_shared<Seen>();
  const auto observe = [=](double, const HalfRef<3>& q, const HalfRef<3>& p) {
    seen->last = PhasePoint<double, 3>(q, p);
    if (!std::exchange(seen->begun, true)) seen->first = seen->last;
  };
  const auto jacobi = [=](const PhasePoint<double, 3>& z) {
    return -2 * (Scene(orbits::Kinetic<3>{}, orbits::TwoCentres<3>::restricted(c["mu"]),
                       orbits::RotatingFrame<3>{.omega = c["frame-rate"]})
                     .energy(z.q(), z.p()));
  };
  const auto report = [=](std::ostream& out) {
    out << formatted("closure: %.2e in position", (seen->last.q() - seen->first.q()).norm());
    if (c.on("two_centres") && c.on("rotating_frame"))
      out << formatted("; Jacobi's constant: %.12f at first, ", jacobi(seen->first))
          << formatted("%.12f at last", jacobi(seen->last));
    out << '\n';
  };
  return {observe, report, memory_of(seen)};
}

}  // namespace examples
