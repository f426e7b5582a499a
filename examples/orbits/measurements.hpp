#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../common/measurement.hpp"
#include "../common/output.hpp"
#include "../common/scene_choice.hpp"

namespace examples {

/// How a direction turns about an axis that may turn as well, from step to step, and how far from one upward
/// passage of a function through zero to the next.
class Passages {
 public:
  using Direction = Eigen::Vector3d;

  void see(double t, double function, const Direction& direction, const Direction& axis) {
    // Between two planes about the axis of the one in the middle, which leaves an error of third order in the
    // step, a sixth of what two steps at once differ by.
    const Plane now{direction, axis.normalized()};
    const double step = last_plane_.turn_to(now);
    turn_ += step;
    if (!before_.axis.isZero()) turn_ -= (before_.turn_to(now) - (last_step_ + step)) / 6;
    last_step_ = step;
    before_ = std::exchange(last_plane_, now);
    if (!crossing_.see(t, {function, turn_})) return;
    const Place place = crossing_.place();
    if (passages_++ > 0) {
      const double turn = place.values[1] - last_.values[1];
      turned_ += turn;
      largest_ = std::max(largest_, std::abs(turn));
      passed_ += place.t - last_.t;
    }
    open_ = std::max(
        open_, crossing_.uncertain([](const Place& a, const Place& b) { return a.values[1] - b.values[1]; }));
    open_time_ =
        std::max(open_time_, crossing_.uncertain([](const Place& a, const Place& b) { return a.t - b.t; }));
    last_ = place;
  }
  int orbits() const { return std::max(passages_ - 1, 0); }
  double per_time() const { return turned_ / passed_; }
  /// What steps of such an angle leave open of that at both ends, about so many times this part of what an
  /// order more changed, and the rounding of directions and of the gradient, which is the companion's as
  /// well. That of the state turns what is so long beside 1, as an eccentricity, by one over that.
  double uncertain(double step, double length, double share) const {
    const double epsilon = std::numeric_limits<double>::epsilon();
    const double rounding = 4e-15 + 4 * std::numbers::pi * epsilon * orbits() +
                            epsilon / 2 * std::sqrt(static_cast<double>(orbits())) / length;
    return (2 * std::min(1.0, share * step) * (open_ + std::abs(per_time()) * open_time_) + rounding) /
           passed_;
  }
  /// Is it plain which way round the direction went in an orbit?
  bool plain() const { return largest_ < std::numbers::pi / 2; }

  void visit_memory(CheckpointMemory& visit) {
    crossing_.visit_memory(visit);
    visit(passages_);
    for (double* number : {&last_.t, &last_step_, &turn_, &turned_, &passed_, &largest_, &open_, &open_time_})
      visit(*number);
    visit(last_.values);
    for (Plane* plane : {&before_, &last_plane_}) visit(plane->direction), visit(plane->axis);
  }

 private:
  using Place = Crossing<2>::Place;
  /// A direction in the plane across an axis of length 1; none at first.
  struct Plane {
    Direction direction = Direction::Zero(), axis = Direction::Zero();
    /// To the rounding of what they differ by, which adds up over many steps.
    double turn_to(const Plane& next) const {
      if (axis.isZero()) return 0;
      const Direction moved = next.direction - direction;
      return std::atan2((axis + next.axis).normalized().dot(direction.cross(moved)),
                        direction.dot(next.direction));
    }
  };

  Crossing<2> crossing_;  ///< of the function, and the turn since the start
  Place last_{};
  Plane before_{}, last_plane_{};
  double last_step_ = 0, turn_ = 0, turned_ = 0, passed_ = 0, largest_ = 0, open_ = 0, open_time_ = 0;
  int passages_ = 0;
};

/// What turns an orbit, in radians a unit of time: its node, the periapsis from there, and the periapsis
/// along the orbit.
struct TurnRates {
  double node = 0, from_node = 0, along = 0;
};

/// That to first order. Oblateness: Vallado, section 9.4; relativity: Damour and Deruelle, Ann. Inst. H.
/// Poincaré 43 (1985) 107, at this order without the mass ratio; spin: Lense, Thirring.
class FirstOrder {
 public:
  explicit FirstOrder(const Choice& c) : gm_(c["gm"]) {
    const double a = c["a"], e = c["e"], tilt = c["inclination"], p = a * (1 - e * e);
    const double relativity = 3 * gm_ / (c["c"] * c["c"]);
    double second = 0, strongest = 0, at_most = 0;  // of what turns the node, and of all times its factor
    const auto take = [&](const char* name, double& coefficient, double value, double power,
                          double of_square) {
      terms += (terms.empty() ? "" : " and ") + std::string(name);
      coefficient = value;
      const double size = std::abs(value / std::pow(p, power));
      largest = std::max(largest, size);
      at_most = std::max(at_most, of_square * size);
      second = std::max(second, of_square * size * size);
      return size;
    };
    // Of relativity the terms of second order are measured to be two to four squares, of J2 up to one, and
    // more where the orbit is nearly circular; of spin 24 of a circle, 15 at e = 0.05, 10 at 0.2, 3.3 at 0.6.
    const double of_spin = 3 + 21 * std::pow(1 - e, 4);
    double of_relativity = 0;
    if (c.on("1pn")) of_relativity = take("1PN", relativity_, relativity, 1, 3);
    if (c.on("j2")) strongest = take("J2", j2_, 1.5 * c["j2"] * std::pow(c["radius"], 2), 2, 1);
    if (c.on("spin_orbit")) {
      const double spin = take("spin", spin_, 2 * c["gs"] / (c["c"] * c["c"] * std::sqrt(gm_)), 1.5, of_spin);
      strongest = std::max(strongest, spin);
      // Where both turn the orbit the same way it is the square of their sum.
      if (c["gs"] * std::cos(tilt) < 0)
        second = std::max(second, std::pow(std::sqrt(3.0) * of_relativity + std::sqrt(of_spin) * spin, 2));
    }
    if (c.on("2pn")) {  // of that order itself; a node that something else turns it moves by up to 4 squares
      const double square = std::pow(relativity / p, 2);
      second = std::max(second, 3 * square);
      at_most = std::max(at_most, 4 * square);
    }
    second_of_node = (c.on("j2") ? 2.5 : 1) * strongest * at_most;  // by J2 at most, Brouwer
    // A periapsis that is hardly determined turns by more. A loss of energy bends a circle by such a part of
    // its radius, which counts beside e.
    second_of_periapsis = second * (c.on("j2") ? 1 + 0.3 / e : 1);
    if (c.on("2.5pn"))
      second_of_periapsis += largest * 4 * 6.4 * c["nu"] * std::pow(relativity / (3 * p), 2.5) / e;
    at_start = rates(a, e, std::cos(tilt));
  }

  /// Of an orbit in a plane whose tilt has this cosine.
  TurnRates rates(double a, double e, double cosine) const {
    const double p = a * (1 - e * e), motion = std::sqrt(gm_ / (a * a * a));
    const double oblate = j2_ / (p * p) * motion, spin = spin_ / (p * std::sqrt(p)) * motion;
    const double node = spin - oblate * cosine;
    const double from_node =
        relativity_ / p * motion + oblate * (2.5 * cosine * cosine - 0.5) - 3 * spin * cosine;
    return {node, from_node, from_node + cosine * node};
  }
  bool holds() const { return largest < 0.01; }

  std::string terms{};
  TurnRates at_start{};
  double largest = 0;  ///< of the terms, in radians a radian of the mean motion
  /// Those of second order for mean elements, likewise. Of a node: Brouwer, Astron. J. 64 (1959) 378.
  double second_of_periapsis = 0, second_of_node = 0;

 private:
  double gm_, relativity_ = 0, j2_ = 0, spin_ = 0;
};

/// How the periapsis and the node of an orbit turn, in `unit`: a radian a unit of time is `factor` of these.
/// Where something turns the node the periapsis is also counted from there; along the orbit (dω + cos i dΩ)
/// it has a meaning without a node, too.
inline Measurement<3> turning_orbit(const Choice& c, const std::string& unit, double factor) {
  using std::numbers::pi;
  struct Seen {
    Passages along, from_node, node;
    Eigen::Vector3d last = Eigen::Vector3d::Zero();
    double step = 0;       // the largest angle from one step to the next
    double upright = 1;    // the smallest sine of the inclination
    double eccentric = 1;  // and eccentricity
    TurnRates swing{};     // from the start: how far the rates of first order go, which are for mean elements
    bool has_node() const { return upright > 1e-3; }
    void visit_memory(CheckpointMemory& visit) {
      for (Passages* passages : {&along, &from_node, &node}) passages->visit_memory(visit);
      visit(last);
      visit(step);
      visit(upright);
      visit(eccentric);
      for (double* number : {&swing.node, &swing.from_node, &swing.along}) visit(*number);
    }
  };
  const auto seen = std::make_shared<Seen>();
  const double gm = c["gm"], e = c["e"];
  const FirstOrder expected(c);
  const auto observe = [=](double t, const In<double, 3>& q, const In<double, 3>& p) {
    const Eigen::Vector3d x = q, v = p, momentum = x.cross(v), axis(0, 0, 1), node = axis.cross(momentum);
    const Eigen::Vector3d laplace = v.cross(momentum) / gm - x.normalized();  // it points to the periapsis
    const double omega = angle_about(momentum, node, laplace);
    seen->along.see(t, x.dot(v), laplace, momentum);
    seen->from_node.see(t, x.dot(v), {std::cos(omega), std::sin(omega), 0}, axis);
    seen->node.see(t, x[2], node, axis);
    seen->upright = std::min(seen->upright, node.norm() / momentum.norm());
    seen->eccentric = std::min(seen->eccentric, laplace.norm());
    if (!seen->last.isZero(0)) seen->step = std::max(seen->step, angle_between(seen->last, x));
    seen->last = x;
    const TurnRates now = expected.rates(1 / (2 / x.norm() - v.squaredNorm() / gm), laplace.norm(),
                                         momentum.z() / momentum.norm());
    for (double TurnRates::*rate : {&TurnRates::node, &TurnRates::from_node, &TurnRates::along})
      seen->swing.*rate = std::max(seen->swing.*rate, std::abs(now.*rate - expected.at_start.*rate));
  };
  const bool with_node = c.on("j2") || c.on("spin_orbit");
  const double motion = std::sqrt(gm / std::pow(c["a"], 3)) * factor;  // per radian of the mean motion
  const auto figures = [=](const Run&) {
    std::vector<Figure> list;
    // A loss of energy swings the axis in sharper peaks at the periapsis than what else turns it.
    const double share = c.on("2.5pn") && !c.on("1pn") && !c.on("2pn") ? 15 : 2;
    const auto add = [&](const char* what, const Passages& passages, double length) {
      if (passages.orbits() >= 2)
        list.push_back(
            {what, passages.per_time() * factor, passages.uncertain(seen->step, length, share) * factor});
    };
    if (with_node && seen->has_node())
      add("perihelion advance", seen->from_node, std::min(seen->eccentric, seen->upright));
    else
      add("perihelion advance", seen->along, seen->eccentric);
    add("perihelion and node, along the orbit", seen->along, seen->eccentric);
    add("node", seen->node, seen->upright);
    return list;
  };
  const auto report = [=](std::ostream& out, const Run& run) {
    const bool about_the_node = c.preset == "gps";  // its orbit is a circle
    const std::string first = about_the_node ? "node" : "perihelion advance";
    if (!c.on("kinetic") || !c.on("attraction") || c.on("two_centres") || c.on("rotating_frame"))
      return print_none(out, first, "that is for kinetic, attraction, j2, 1pn, 2pn and spin_orbit only");
    if (c.on("drag")) return print_none(out, first, "drag turns it, too");
    if (seen->step > pi / 6)
      return print_none(out, first,
                        formatted("a step goes through %.0f degrees of the orbit; ", seen->step * 180 / pi) +
                            formatted("give a --dt %.0f times smaller", std::ceil(seen->step * 12 / pi)));
    const auto figure = [&](const std::string& what, const Passages& passages, double TurnRates::*rate) {
      if (passages.orbits() < 2)
        return print_none(out, what, "the run has no two whole orbits; give more --time");
      if (!passages.plain())
        return print_none(out, what,
                          "it turns by more than a quarter in an orbit, so that the way round is not plain");
      const auto error = run.figure_error(what);
      if (!error) return print_none(out, what, no_error(run));
      const double uncertain = error->all();
      if (!(uncertain <= (expected.largest > 0 ? 0.1 * expected.largest : 1e-3) * motion))
        return print_none(out, what,
                          formatted("a companion run leaves ± %.2g ", uncertain) + unit +
                              " open; give a smaller --dt, or a method of higher order");
      const int digits = uncertain > 0 ? std::max(-decimal_place(uncertain), 0) : 40;
      const auto decimals = [&](double x) {
        if (digits > 30)
          return formatted("%.*e", x == 0 ? 0 : std::clamp(decimal_place(x) + digits, 0, 17), x);
        const double last = std::pow(10, -digits);
        return formatted("%.*f", digits, std::round(x / last) * last + 0.0);
      };
      out << what << ": " << decimals(passages.per_time() * factor) << formatted(" ± %.1g ", uncertain)
          << unit << formatted(" from %d orbits", passages.orbits());
      if (expected.holds()) {
        out << "; " << (expected.terms.empty() ? "Kepler" : expected.terms + " to first order") << ": "
            << decimals(expected.at_start.*rate * factor);
        const double second =
            rate == &TurnRates::node ? expected.second_of_node : expected.second_of_periapsis;
        if (second > 0)
          out << formatted(", terms of second order: about %.0g",
                           seen->swing.*rate * factor + second * motion);
      } else {
        out << "; too strong a field for a formula of first order";
      }
      out << '\n';
    };
    if (!about_the_node || e > 0) {
      if (e < 1e-6 || e < 10 * expected.largest)
        print_none(out, "perihelion advance",
                   "the orbit is too near to a circle, for what turns it, to have one; give a larger --e");
      else if ((c.on("j2") || c.on("spin_orbit")) && seen->has_node()) {
        figure("perihelion advance", seen->from_node, &TurnRates::from_node);
        figure("perihelion and node, along the orbit", seen->along, &TurnRates::along);
      } else {
        figure("perihelion advance", seen->along, &TurnRates::along);
      }
    }
    if (!seen->has_node() && about_the_node)
      print_none(out, "node",
                 "it is too near to the equator to have one; give an --inclination of 0.1 to 179.9 degrees");
    else if (seen->has_node() && (about_the_node || c.on("j2") || c.on("spin_orbit")))
      figure("node", seen->node, &TurnRates::node);
  };
  return {observe, memory_of(seen), figures, report};
}

inline Measurement<3> perihelion(const Choice& c) {
  return turning_orbit(c, "arcseconds a century", 100 * 3600 * 180 / std::numbers::pi);
}

/// The direction of the perihelion, by the vector of Laplace.
inline TurningFigure<3> direction_of_perihelion(const Choice& c) {
  const double gm = c["gm"], a = c["a"], e = c["e"];
  // Six degrees at the perihelion, so that a straight line between two steps leaves 1e-4 arcsec.
  const double period = 2 * std::numbers::pi * std::sqrt(a * a * a / gm),
               longest = period / 60 * std::pow(1 - e * e, 1.5) / ((1 + e) * (1 + e));
  return {"perihelion advance", "arcsec", "1 century", longest, [gm](const auto& q, const auto& p) {
            const Eigen::Vector3d x = q, v = p, laplace = v.cross(x.cross(v)) / gm - x.normalized();
            return Eigen::VectorXd(laplace.normalized());
          }};
}

inline Measurement<3> node(const Choice& c) {
  return turning_orbit(c, "degrees a year", 365.25 * 86400 * 180 / std::numbers::pi);
}

inline constexpr double arenstorf_period = 17.0652165601579625588917206249;

/// How well Arenstorf's orbit closes, which it does for his values only, and Jacobi's constant.
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
  const auto observe = [=](double, const In<double, 3>& q, const In<double, 3>& p) {
    seen->last = PhasePoint<double, 3>(q, p);
    if (!std::exchange(seen->begun, true)) seen->first = seen->last;
  };
  const bool restricted = c.only({"kinetic", "two_centres", "rotating_frame"}) && c["frame-rate"] == 1;
  const auto jacobi = [=](const PhasePoint<double, 3>& z) {
    return -2 * (Scene(orbits::Kinetic<double, 3>{}, orbits::TwoCentres<double, 3>::restricted(c["mu"]),
                       orbits::RotatingFrame<double, 3>{.omega = c["frame-rate"]})
                     .energy(z.q(), z.p()));
  };
  const auto report = [=](std::ostream& out, const Run& run) {
    if (restricted && c.is_preset && std::abs(run.report.t - arenstorf_period) < 1e-9)
      out << formatted("closure: %.2e in position\n", (seen->last.q() - seen->first.q()).norm());
    else
      out << "closure: not measured, the orbit closes with the preset's effects, values and --time only\n";
    if (restricted)
      out << formatted("Jacobi's constant: %.12f at first, ", jacobi(seen->first))
          << formatted("%.12f at last\n", jacobi(seen->last));
  };
  return {observe, memory_of(seen), {}, report};
}

}  // namespace examples
