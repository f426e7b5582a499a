#pragma once

#include <cmath>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/scene/effect.hpp>

/// Geodesics about a black hole in Boyer-Lindquist coordinates q = (t, r, θ, φ), with the covariant momenta
/// p = (-E, p_r, p_θ, L) per rest mass; c = G = 1. H = g^{μν} p_μ p_ν/2 is -1/2 for a body and 0 for light,
/// and the time of integration is proper time (for light an affine parameter). E, the axial angular momentum
/// L and Carter's constant are kept. Each is a whole Hamiltonian: a scene of one effect, to which weak
/// perturbations may be added. Outside of the horizon, and off the axis θ = 0, π.
namespace semiexplicit::effects::black_hole {

/// A black hole of mass M and spin aM, |a| < M.
///
/// Sources: B. Carter, Phys. Rev. 174 (1968) 1559; J. Bardeen, W. Press, S. Teukolsky, Astrophys. J. 178
/// (1972) 347.
template <class Scalar = double>
struct Kerr {
  using Acts = OnBoth<Scalar, 4>;
  static constexpr const char* name = "kerr";
  static constexpr const char* about = "geodesic of a spinning black hole";
  Scalar mass = Scalar(1);  ///< M, the unit of length and time where it is 1
  Scalar spin = Scalar(0);  ///< a, a length; the angular momentum is aM

  Scalar energy(const auto& q, const auto& p) const {
    const Parts f(*this, q, p);
    return ((f.delta * p[1] * p[1] + f.n) / f.sigma - p[0] * p[0]) / 2;
  }

  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const Parts f(*this, q, p);
    const Scalar r = q[1], e = -p[0], a2 = spin * spin, inverse = 1 / f.sigma, pr2 = p[1] * p[1];
    // Δ p_r²/Σ - E² is p_r² - E² but for terms that vanish far out: only those are differentiated.
    const Scalar weak = f.n + (a2 * f.sin2 - 2 * mass * r) * pr2;
    dHdq[1] += ((r - mass) * f.m_over_delta * f.m_over_delta - mass * (pr2 + e * (e + 2 * f.m_over_delta)) -
                r * inverse * weak) *
               inverse;
    dHdq[2] +=
        f.sin * f.cos * (a2 * inverse * (f.delta * pr2 + f.n) - f.l_over_sin2 * f.l_over_sin2) * inverse;
    dHdp[0] += e + 2 * mass * r * (e + f.m_over_delta) * inverse;
    dHdp[1] += f.delta * p[1] * inverse;
    dHdp[2] += p[2] * inverse;
    dHdp[3] += (f.l_over_sin2 + spin * f.m_over_delta) * inverse;
  }

  /// Carter's constant Q = p_θ² + cos²θ (a²(μ² - E²) + L²/sin²θ), for rest mass μ = 1.
  Scalar carter(const auto& q, const auto& p) const {
    using std::cos;
    using std::sin;
    const Scalar c = cos(q[2]), s = sin(q[2]);
    return p[2] * p[2] + c * c * (spin * spin * (1 - p[0] * p[0]) + p[3] * p[3] / (s * s));
  }

  /// A body at (r, θ) with the given momenta, and with the energy that its rest mass asks for. NaN where
  /// there is none.
  PhasePoint<Scalar, 4> body(Scalar r, Scalar theta, Scalar p_r, Scalar p_theta, Scalar p_phi) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    // In units of r, whose fourth power has no room where it is small.
    const Scalar a = spin / r, l = p_phi / r, k = p_theta / r, d = delta(r) / r / r;
    const Scalar s2 = sin(theta) * sin(theta), a2 = a * a, r2a2 = 1 + a2, sigma = r2a2 - a2 * s2;
    // αE² + 2βE + γ = 0
    const Scalar alpha = a2 * s2 - r2a2 * r2a2 / d, beta = a * l * (r2a2 / d - 1);
    const Scalar gamma = d * p_r * p_r + k * k + l * l * (1 / s2 - a2 / d) + sigma;
    const Scalar e = (-beta - sqrt(beta * beta - alpha * gamma)) / alpha;
    return {{Scalar(0), r, theta, Scalar(0)}, {-e, p_r, p_theta, p_phi}};
  }

  /// The equatorial circular orbit at r, in the sense of the spin (L > 0); its angular velocity dφ/dt is
  /// circular_rate(r). NaN between the horizon and the photon orbit. Source: Bardeen, Press, Teukolsky
  /// (1972), eqs. (2.12), (2.13), (2.16).
  PhasePoint<Scalar, 4> circular(Scalar r) const {
    using std::acos;
    using std::sqrt;
    const Scalar u = mass / r, root = sqrt(u), a = spin / r;
    const Scalar norm = sqrt(1 - 3 * u + 2 * a * root);
    const Scalar e = (1 - 2 * u + a * root) / norm;
    const Scalar l = r * root * (1 - 2 * a * root + a * a) / norm;
    return {{Scalar(0), r, acos(Scalar(-1)) / 2, Scalar(0)}, {-e, Scalar(0), Scalar(0), l}};
  }
  Scalar circular_rate(Scalar r) const {
    using std::sqrt;
    return sqrt(mass) / (r * sqrt(r) + spin * sqrt(mass));
  }

  /// Radius of the innermost stable circular orbit in the sense of the spin; for a < 0 against it. Eq. (2.21)
  /// there.
  Scalar innermost_stable_orbit() const {
    using std::cbrt;
    using std::sqrt;
    // The formula's 3 - Z1, which cancels for small spins, is (x - y)² (x + y).
    const Scalar a = spin / mass, x = cbrt(1 + a), y = cbrt(1 - a);
    const Scalar z1 = 1 + x * y * (x + y), z2 = sqrt(3 * a * a + z1 * z1);
    const Scalar apart = 2 * a / (x * x + x * y + y * y);
    return mass * (3 + z2 - apart * sqrt((x + y) * (3 + z1 + 2 * z2)));
  }

 private:
  /// Δ = r² - 2Mr + a², by differences that are exact next to the horizon.
  Scalar delta(const Scalar& r) const { return (r - mass) * (r - mass) - (mass - spin) * (mass + spin); }

  /// H = (Δp_r² + n)/(2Σ) - E²/2, n = p_θ² + L²/sin²θ - 2MrE² - m²/Δ, m = 2MrE - aL.
  struct Parts {
    Parts(const Kerr& hole, const auto& q, const auto& p) {
      using std::cos;
      using std::sin;
      const Scalar r = q[1], e = -p[0], twice = 2 * hole.mass * r;
      this->sin = sin(q[2]);
      this->cos = cos(q[2]);
      sin2 = this->sin * this->sin;
      delta = hole.delta(r);
      sigma = r * r + hole.spin * hole.spin * this->cos * this->cos;
      l_over_sin2 = p[3] / sin2;
      const Scalar m = twice * e - hole.spin * p[3];
      m_over_delta = m / delta;
      n = p[2] * p[2] + p[3] * l_over_sin2 - twice * e * e - m * m_over_delta;
    }
    Scalar sin, cos, sin2, delta, sigma, l_over_sin2, m_over_delta, n;
  };
};

/// A black hole of mass M without spin: Kerr with a = 0, and cheaper. Q is L² - L_z² then, the rest of the
/// angular momentum.
///
/// Source: S. Chandrasekhar, The Mathematical Theory of Black Holes (1983), chapter 3.
template <class Scalar = double>
struct Schwarzschild {
  using Acts = OnBoth<Scalar, 4>;
  static constexpr const char* name = "schwarzschild";
  static constexpr const char* about = "geodesic of a black hole without spin";
  Scalar mass = Scalar(1);

  Scalar energy(const auto& q, const auto& p) const {
    using std::sin;
    const Scalar r = q[1], f = 1 - 2 * mass / r, s = sin(q[2]);
    return (f * p[1] * p[1] - p[0] * p[0] / f + (p[2] * p[2] + p[3] * p[3] / (s * s)) / (r * r)) / 2;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    using std::cos;
    using std::sin;
    const Scalar r = q[1], s = sin(q[2]), inverse2 = 1 / (r * r);
    const Scalar f = 1 - 2 * mass / r, e_over_f = p[0] / f, l_over_s2 = p[3] / (s * s);
    dHdq[1] += inverse2 * (mass * (p[1] * p[1] + e_over_f * e_over_f) - (p[2] * p[2] + p[3] * l_over_s2) / r);
    dHdq[2] -= inverse2 * l_over_s2 * l_over_s2 * s * cos(q[2]);
    dHdp[0] -= e_over_f;
    dHdp[1] += f * p[1];
    dHdp[2] += inverse2 * p[2];
    dHdp[3] += inverse2 * l_over_s2;
  }
};

}  // namespace semiexplicit::effects::black_hole
