#pragma once

// Two Hamiltonians that are not in the library: written the way a user would, generically, so that the same
// lines run on numbers and on SIMD packs.

#include <semiexplicit/semiexplicit.hpp>

namespace work_precision {

/// A charge in a magnetic bottle, H = |p - A(q)|²/2. The field B = (-xz/L², -yz/L², 1 + z²/L² - (x² +
/// y²)/(2L²)) is free of divergence and curl; its potential is A = (-y, x, 0) g with g = (1 + z²/L²)/2 - (x²
/// + y²)/(8L²). Keeps H and the canonical angular momentum x p_y - y p_x.
struct MagneticBottle {
  using Scalar = double;
  using PackGradientOf = MagneticBottle;
  static constexpr int Dof = 3;
  double length = 3;

  template <class Q>
  double energy(const Q& q, const Q& p) const {
    const double k = 1 / (length * length);
    const double g = (1 + k * q[2] * q[2]) / 2 - k / 8 * (q[0] * q[0] + q[1] * q[1]);
    const double vx = p[0] + g * q[1], vy = p[1] - g * q[0], vz = p[2];
    return (vx * vx + vy * vy + vz * vz) / 2;
  }
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    const double k = 1 / (length * length);
    const auto g = 0.5 + (k / 2) * q[2] * q[2] - (k / 8) * (q[0] * q[0] + q[1] * q[1]);
    const auto vx = p[0] + g * q[1], vy = p[1] - g * q[0];
    const auto torque = vx * q[1] - vy * q[0];  // ∂H/∂g
    dHdq[0] = torque * (-k / 4 * q[0]) - vy * g;
    dHdq[1] = torque * (-k / 4 * q[1]) + vx * g;
    dHdq[2] = torque * (k * q[2]);
    dHdp[0] = vx;
    dHdp[1] = vy;
    dHdp[2] = p[2] * 1.0;
  }
};

/// A geodesic around a rotating black hole (mass 1, spin a) in r and u = cos θ, with the conserved E and L
/// put in:
///
///     H = (Δ p_r² + (1 - u²) p_u² + (aE(1 - u²) - L)²/(1 - u²) - P²/Δ)/(2Σ),
///
/// Σ = r² + a²u², Δ = r² - 2r + a², P = (r² + a²)E - aL. A massive particle has H = -1/2. Keeps H and
/// Carter's constant.
///
/// Source: B. Carter, Phys. Rev. 174 (1968) 1559.
struct KerrGeodesic {
  using Scalar = double;
  using PackGradientOf = KerrGeodesic;
  static constexpr int Dof = 2;
  double a = 0.9, energy_at_infinity = 0.95, angular_momentum = 2.5;

  template <class Q>
  double energy(const Q& q, const Q& p) const {
    const double r = q[0], u = q[1], s = 1 - u * u, delta = r * r - 2 * r + a * a;
    const double momentum = (r * r + a * a) * energy_at_infinity - a * angular_momentum;
    const double axial = a * energy_at_infinity * s - angular_momentum;
    return (delta * p[0] * p[0] + s * p[1] * p[1] + axial * axial / s - momentum * momentum / delta) /
           (2 * (r * r + a * a * u * u));
  }
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    const double E = energy_at_infinity, L = angular_momentum;
    const auto r = q[0] * 1.0, u = q[1] * 1.0;
    const auto s = 1.0 - u * u, delta = r * r - 2.0 * r + a * a, momentum = r * r * E + (a * a * E - a * L);
    const auto one_over_s = 1.0 / s, one_over_delta = 1.0 / delta;
    const auto axial = a * E * s - L, ratio = momentum * one_over_delta, axial_ratio = axial * one_over_s;
    const auto half_inverse = 0.5 / (r * r + a * a * u * u);
    const auto value =
        (delta * p[0] * p[0] + s * p[1] * p[1] + axial * axial_ratio - momentum * ratio) * half_inverse;
    // d(axial²/s)/ds = 2aE axial/s - (axial/s)², ds/du = -2u, and likewise in r.
    const auto by_s = p[1] * p[1] + axial_ratio * (2.0 * a * E - axial_ratio);
    const auto by_r = (2.0 * r - 2.0) * (p[0] * p[0] + ratio * ratio) - 4.0 * E * r * ratio;
    dHdq[0] = (by_r - 4.0 * r * value) * half_inverse;
    dHdq[1] = (-2.0 * u * by_s - 4.0 * a * a * u * value) * half_inverse;
    dHdp[0] = 2.0 * delta * p[0] * half_inverse;
    dHdp[1] = 2.0 * s * p[1] * half_inverse;
  }

  /// Q = p_θ² + cos²θ (a²(μ² - E²) + L²/sin²θ), with μ² = -2H.
  double carter(const double* z) const {
    const double u = z[1], s = 1 - u * u, E = energy_at_infinity, L = angular_momentum;
    const double mass = -2 * energy(z, z + 2);
    return s * z[3] * z[3] + u * u * (a * a * (mass - E * E) + L * L / s);
  }
};

static_assert(semiexplicit::HasEnergy<MagneticBottle> && semiexplicit::HasEnergy<KerrGeodesic>);

}  // namespace work_precision
