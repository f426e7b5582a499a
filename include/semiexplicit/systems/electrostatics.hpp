#pragma once

#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/orbits.hpp>

/// Electrostatic fields on one charge e in space; see charges.hpp for units.
namespace semiexplicit::effects::charges {

/// p²/(2m): a charge without magnetic fields, which keeps the scene separable.
template <class Scalar = double>
struct Kinetic {
  using Acts = OnMomentum<Scalar, 3>;
  static constexpr const char* name = "kinetic";
  static constexpr const char* about = "p²/(2m), without magnetic fields";
  Scalar mass = Scalar(1);

  Scalar energy(const auto& p) const {  // p² is nothing in SI units and float
    return (p[0] * (p[0] / mass) + p[1] * (p[1] / mass) + p[2] * (p[2] / mass)) / 2;
  }
  void add_gradient(const auto& p, auto& dHdp) const {
    for (int i = 0; i < 3; ++i) dHdp[i] += p[i] / mass;
  }
};

/// A uniform electric field E: -e E·q. Across a uniform magnetic field a charge drifts at E × B/B².
template <class Scalar = double>
struct UniformElectric {
  using Acts = OnPosition<Scalar, 3>;
  static constexpr const char* name = "electric";
  static constexpr const char* about = "uniform electric field, -e E·q";
  Scalar charge = Scalar(1);
  Scalar x = Scalar(0), y = Scalar(0), z = Scalar(0);  ///< the field E

  Scalar energy(const auto& q) const { return -charge * (x * q[0] + y * q[1] + z * q[2]); }
  void add_gradient(const auto&, auto& dHdq) const {
    dHdq[0] -= charge * x;
    dHdq[1] -= charge * y;
    dHdq[2] -= charge * z;
  }
};

/// A point charge at the origin: k/r. Like charges have k > 0; in SI k = e e'/(4π ε₀).
template <class Scalar = double>
struct Coulomb {
  using Acts = OnPosition<Scalar, 3>;
  static constexpr const char* name = "coulomb";
  static constexpr const char* about = "a point charge at the origin, k/r";
  Scalar k = Scalar(-1);  ///< energy · length

  Scalar energy(const auto& q) const { return attraction().energy(q); }
  void add_gradient(const auto& q, auto& dHdq) const { attraction().add_gradient(q, dHdq); }

 private:
  orbits::Attraction<Scalar, 3> attraction() const { return {.gm = -k}; }
};

/// An electric quadrupole about the third axis, k(z² - ρ²/2)/2: bound along the axis, at the rate √(k/m), and
/// driven away from it. With a uniform magnetic field it is a Penning trap, whose rates across the axis are
/// ω/2 ± √(ω²/4 - k/(2m)), ω = eB/m.
///
/// Source: L. Brown and G. Gabrielse, Rev. Mod. Phys. 58 (1986) 233, section II.
template <class Scalar = double>
struct Quadrupole {
  using Acts = OnPosition<Scalar, 3>;
  static constexpr const char* name = "quadrupole";
  static constexpr const char* about = "electric quadrupole of a Penning trap, k(z² - ρ²/2)/2";
  Scalar k = Scalar(1);  ///< energy/length²

  Scalar energy(const auto& q) const { return k / 2 * (q[2] * q[2] - (q[0] * q[0] + q[1] * q[1]) / 2); }
  void add_gradient(const auto& q, auto& dHdq) const {
    dHdq[0] -= k / 2 * q[0];
    dHdq[1] -= k / 2 * q[1];
    dHdq[2] += k * q[2];
  }
};

}  // namespace semiexplicit::effects::charges
