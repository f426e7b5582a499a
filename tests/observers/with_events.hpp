#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

#include "oscillator.hpp"

// What bounces, swings and is kicked in the tests of events.

namespace with_events {

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

/// A ball in a field of strength 1: H = p²/2 + q.
template <class T>
struct BallOf {
  using Scalar = T;
  static constexpr int Dof = 1;
  T energy(In<T, 1> q, In<T, 1> p) const { return p[0] * p[0] / 2 + q[0]; }
  void gradient(In<T, 1>, In<T, 1> p, Out<T, 1> dHdq, Out<T, 1> dHdp) const {
    dHdq[0] = 1;
    dHdp[0] = p[0];
  }
};
using Ball = BallOf<double>;

using Oscillator = OscillatorOf<double>;

constexpr auto height = [](const auto& q, const auto&) { return q[0]; };
constexpr auto speed = [](const auto&, const auto& p) { return p[0]; };

template <class H>
auto semiexplicit_of(const H& h) {
  return Semiexplicit(h, schemes::blanes_moan6());
}

/// Height at the time t of a ball that is let go at the height 1/2 and bounces without loss: bounces at t =
/// 1, 3, 5, ...
inline double elastic(double t) {
  const double since = std::remainder(t, 2.0);
  return 0.5 - since * since / 2;
}

}  // namespace with_events
