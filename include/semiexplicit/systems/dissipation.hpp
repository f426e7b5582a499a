#pragma once

#include <cmath>
#include <type_traits>

#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/orbits.hpp>
#include <semiexplicit/systems/post_newtonian.hpp>

/// Forces on the orbit of one body, per unit of its mass, that no Hamiltonian has: see OnMotion, and Books
/// for their work. q and p as in orbits.hpp.
namespace semiexplicit::effects::orbits {

/// Drag, -(k + b |p|) p: linear (a slow body in a viscous fluid), quadratic (a fast one in air), or both.
/// With a scale height h it is that much times exp(-(r - r₀)/h), an atmosphere about the centre, which
/// thickens outwards where h is negative; where h is NaN the step fails.
template <class Scalar = double, int Dim = 2>
struct Drag {
  using Acts = OnMotion<Scalar, Dim>;
  static constexpr const char* name = "drag";
  static constexpr const char* about = "drag, -(k + b|p|) p exp(-(r - r0)/h)";
  Scalar linear = Scalar(0);     ///< k, 1/time
  Scalar quadratic = Scalar(0);  ///< b, 1/length: ½ C_D area density/mass
  Scalar height = Scalar(0);     ///< h, length; 0: the same everywhere
  Scalar radius = Scalar(0);     ///< r₀, length

  void add_force(const auto& q, const auto& p, auto& force) const {
    using std::exp;
    using std::sqrt;
    auto rate = linear + quadratic * sqrt(detail::dot<Dim>(p, p));
    if (height != 0) rate = rate * exp((radius - sqrt(detail::dot<Dim>(q, q))) / height);
    for (int i = 0; i < Dim; ++i) force[i] -= rate * p[i];
  }
};

/// The loss by gravitational waves at its first order, for the relative motion of two bodies; gm, c and nu as
/// in PostNewtonian1:
///
///     F = 8ν (GM)²/(5c⁵r³) ((3p² + 17u/3) s n - (p² + 3u) p),   u = GM/r, n = q/r, s = n·p.
///
/// Over an orbit it takes the energy and angular momentum of Peters's formulas: of two neutron stars in 0.32
/// days 2.4e-12 of the period in itself.
///
/// Sources: T. Damour, N. Deruelle, Phys. Lett. A 87 (1981) 81 (in this gauge); P. Peters, Phys. Rev. 136
/// (1964) B1224.
template <class Scalar = double, int Dim = 2>
struct RadiationReaction {
  using Acts = OnMotion<Scalar, Dim>;
  static constexpr const char* name = "2.5pn";
  static constexpr const char* about = "loss by gravitational waves";
  Scalar gm = Scalar(1);  ///< length³/time², of both together
  Scalar c = Scalar(1);   ///< speed of light, length/time
  Scalar nu = Scalar(0.25);

  void add_force(const auto& q, const auto& p, auto& force) const {
    const auto [inverse_r, square, u, s] = detail::radial_form<Dim>(gm, q, p);
    const Scalar c2 = c * c;  // c⁵ is Inf in float and SI units
    const auto k = 8 * nu / 5 * (gm / c * inverse_r) * (u / c2 * inverse_r);
    const auto along = k * ((3 * square + 17 * u / 3) / c2) * s * inverse_r,
               against = k * ((square + 3 * u) / c2);
    for (int i = 0; i < Dim; ++i) force[i] += along * q[i] - against * p[i];
  }
};

}  // namespace semiexplicit::effects::orbits
