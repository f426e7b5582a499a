#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

namespace stability {

using namespace semiexplicit;

/// Oscillators with frequencies over four decades, weakly and not separably coupled.
struct StiffLattice {
  using Scalar = double;
  static constexpr int Dof = 8;
  static double frequency(int i) { return 0.1 * std::pow(10.0, 4.0 * i / 7.0); }
  double energy(In<double, 8> q, In<double, 8> p) const {
    double sum = 0;
    for (int i = 0; i < 8; ++i) sum += frequency(i) * (q[i] * q[i] + p[i] * p[i]) / 2;
    for (int i = 1; i < 8; ++i) sum += 0.01 * q[i] * q[i - 1] * p[i] * p[i - 1];
    return sum;
  }
  void gradient(In<double, 8> q, In<double, 8> p, Out<double, 8> dHdq, Out<double, 8> dHdp) const {
    for (int i = 0; i < 8; ++i) {
      dHdq[i] = frequency(i) * q[i];
      dHdp[i] = frequency(i) * p[i];
    }
    for (int i = 1; i < 8; ++i) {
      dHdq[i] += 0.01 * q[i - 1] * p[i] * p[i - 1];
      dHdq[i - 1] += 0.01 * q[i] * p[i] * p[i - 1];
      dHdp[i] += 0.01 * q[i] * q[i - 1] * p[i - 1];
      dHdp[i - 1] += 0.01 * q[i] * q[i - 1] * p[i];
    }
  }
  /// Every oscillator with about the same energy.
  static PhasePoint<double, 8> start() {
    PhasePoint<double, 8> z;
    for (int i = 0; i < 8; ++i) {
      z.q()[i] = 1 / std::sqrt(frequency(i));
      z.p()[i] = 0.3 / std::sqrt(frequency(i));
    }
    return z;
  }
};

}  // namespace stability
