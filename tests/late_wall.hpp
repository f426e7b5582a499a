#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

/// A free motion x to a wall exp(-k x) and back, beside an oscillator (y, v): both turned against the
/// coordinates. It comes to the wall once, at the time `arrives`, with `speed`.
struct LateWall {
  double steep, speed, rate, arrives;
  double y, v;  ///< of the oscillator at the start
  double turn = 0, c = std::cos(turn), s = std::sin(turn);

  /// The energy, for from_energy<2>().
  auto operator()(const auto& q, const auto& p) const {
    const auto x = c * q[0] + s * q[1], other = c * q[1] - s * q[0], u = c * p[0] + s * p[1],
               of_other = c * p[1] - s * p[0];
    return u * u / 2 + exp(-steep * x) + rate / 2 * (other * other + of_other * of_other);
  }
  /// The orbit: x = (2 ln cosh(k speed (t - arrives)/2) - ln(speed²/2))/k.
  semiexplicit::PhasePoint<double, 2> at(double t) const {
    const double to_turn = steep * speed * (t - arrives) / 2, far = std::abs(to_turn), angle = rate * t;
    const double x = (2 * (far + std::log1p(std::exp(-2 * far)) - std::log(2.0)) -
                      std::log(speed * speed / 2)) /
                     steep,
                 u = speed * std::tanh(to_turn);
    const double other = y * std::cos(angle) + v * std::sin(angle),
                 of_other = v * std::cos(angle) - y * std::sin(angle);
    return {{c * x - s * other, s * x + c * other}, {c * u - s * of_other, s * u + c * of_other}};
  }
};
