#pragma once

#include <cmath>

#include <semiexplicit/core/hamiltonian.hpp>

// Hamiltonians as a user writes them: a struct with gradient(), no registers, no special kernel. The formula
// itself is a template, so that the kicks by hand can have the same on plain arrays.

namespace bench {

using semiexplicit::In;
using semiexplicit::Out;

/// What each has in common: gradient() as the README shows it, from Formula::evaluate().
template <class Formula, int D>
struct Written {
  using Scalar = double;
  static constexpr int Dof = D;
  void gradient(const In<double, D>& q, const In<double, D>& p, Out<double, D> dHdq,
                Out<double, D> dHdp) const {
    Formula::evaluate(q, p, dHdq, dHdp);
  }
};

/// H = (q² + 1)(p² + 1)/2.
struct ProductFormula {
  template <class Q, class P, class Dq, class Dp>
  __attribute__((always_inline)) static void evaluate(const Q& q, const P& p, Dq& dHdq, Dp& dHdp) {
    dHdq[0] = q[0] * (p[0] * p[0] + 1);
    dHdp[0] = p[0] * (q[0] * q[0] + 1);
  }
};

/// Two equal pendulums, one hanging from the other; masses, lengths and gravity are 1.
struct DoublePendulumFormula {
  template <class Q, class P, class Dq, class Dp>
  __attribute__((always_inline)) static void evaluate(const Q& q, const P& p, Dq& dHdq, Dp& dHdp) {
    const double s = std::sin(q[0] - q[1]), c = std::cos(q[0] - q[1]), inertia = 1 + s * s;
    const double kinetic = p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c;
    const double torque = p[0] * p[1] * s / inertia - kinetic * s * c / (inertia * inertia);
    dHdq[0] = torque + 2 * std::sin(q[0]);
    dHdq[1] = -torque + std::sin(q[1]);
    dHdp[0] = (p[0] - p[1] * c) / inertia;
    dHdp[1] = (2 * p[1] - p[0] * c) / inertia;
  }
};

/// A geodesic about a black hole of mass 1 and spin a = 0.9, (t, r, θ, φ) of Boyer and Lindquist:
/// H = (Δ p_r² + p_θ² + (p_φ/sin θ + a sin θ p_t)² - ((r² + a²) p_t + a p_φ)²/Δ) / 2Σ.
struct KerrFormula {
  template <class Q, class P, class Dq, class Dp>
  __attribute__((always_inline)) static void evaluate(const Q& q, const P& p, Dq& dHdq, Dp& dHdp) {
    constexpr double a = 0.9;
    const double r = q[1], sine = std::sin(q[2]), cosine = std::cos(q[2]);
    const double sigma = r * r + a * a * cosine * cosine, delta = r * r - 2 * r + a * a;
    const double polar = p[3] / sine + a * sine * p[0], radial = (r * r + a * a) * p[0] + a * p[3];
    const double over = radial / delta;
    const double sum = delta * p[1] * p[1] + p[2] * p[2] + polar * polar - radial * over;
    const double sum_r = (2 * r - 2) * (p[1] * p[1] + over * over) - 4 * r * p[0] * over;
    const double sum_theta = 2 * polar * cosine * (a * p[0] - p[3] / (sine * sine));
    const double half = 1 / (2 * sigma), value = sum * half;
    dHdq[0] = 0;
    dHdq[1] = sum_r * half - 2 * r * value / sigma;
    dHdq[2] = sum_theta * half + 2 * a * a * sine * cosine * value / sigma;
    dHdq[3] = 0;
    dHdp[0] = (a * sine * polar - (r * r + a * a) * over) / sigma;
    dHdp[1] = delta * p[1] / sigma;
    dHdp[2] = p[2] / sigma;
    dHdp[3] = (polar / sine - a * over) / sigma;
  }
};

/// The lattice of Jayawardana and Ohsawa with five sites.
struct NlsFormula {
  template <class Q, class P, class Dq, class Dp>
  __attribute__((always_inline)) static void evaluate(const Q& q, const P& p, Dq& dHdq, Dp& dHdp) {
    for (int i = 0; i < 5; ++i) {
      double dq = 0, dp = 0;
      const double r = q[i] * q[i] + p[i] * p[i];
      if (i > 0) {
        const double x = q[i - 1], y = p[i - 1];
        dq -= 2 * (x * x - y * y) * q[i] + 4 * x * y * p[i];
        dp += 2 * (x * x - y * y) * p[i] - 4 * x * y * q[i];
      }
      if (i < 4) {
        const double x = q[i + 1], y = p[i + 1];
        dq -= 2 * (x * x - y * y) * q[i] + 4 * x * y * p[i];
        dp += 2 * (x * x - y * y) * p[i] - 4 * x * y * q[i];
      }
      dHdq[i] = r * q[i] + dq;
      dHdp[i] = r * p[i] + dp;
    }
  }
};

/// Ten vortices of circulations 1 and -0.6, in turns, whose coordinates are scaled to be canonical.
struct VorticesFormula {
  template <class Q, class P, class Dq, class Dp>
  __attribute__((always_inline)) static void evaluate(const Q& q, const P& p, Dq& dHdq, Dp& dHdp) {
    constexpr int n = 10;
    for (int i = 0; i < n; ++i) dHdq[i] = dHdp[i] = 0;
    for (int i = 0; i < n; ++i)
      for (int j = i + 1; j < n; ++j) {
        const double x = q[i] - q[j], y = p[i] - p[j];
        const double weight = ((i + j) % 2 == 0 ? 1.0 : -0.6) / (6.283185307179586 * (x * x + y * y));
        dHdq[i] -= weight * x;
        dHdq[j] += weight * x;
        dHdp[i] -= weight * y;
        dHdp[j] += weight * y;
      }
  }
};

}  // namespace bench
