#pragma once

#include <cmath>

#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/over_cube.hpp>

/// Effects on the orbit of one body, per unit of its mass, about a centre at the origin, in the plane (Dim 2)
/// or in space (Dim 3): q is the position and p the momentum per mass, in the inertial frame the velocity in
/// Newton's limit. Any consistent units: au, year and GM = 4π², say, or km, s and GM = 398600.4418. A body at
/// the centre itself has no gradient (NaN). The relativistic effects are in post_newtonian.hpp.
namespace semiexplicit::effects::orbits {

namespace detail {

template <int Dim, class X, class Y>
auto dot(const X& x, const Y& y) {
  static_assert(Dim == 2 || Dim == 3, "an orbit is in the plane or in space: let Dim be 2 or 3");
  auto sum = x[0] * y[0] + x[1] * y[1];
  if constexpr (Dim == 3) sum += x[2] * y[2];
  return sum;
}

}  // namespace detail

/// p²/2.
template <class Scalar = double, int Dim = 2>
struct Kinetic {
  using Acts = OnMomentum<Scalar, Dim>;
  static constexpr const char* name = "kinetic";
  static constexpr const char* about = "p²/2";

  auto energy(const auto& p) const { return detail::dot<Dim>(p, p) / 2; }
  void add_gradient(const auto& p, auto& dHdp) const {
    for (int i = 0; i < Dim; ++i) dHdp[i] += p[i];
  }
};

/// Newton's attraction by a mass at the origin, -GM/r. For two bodies q is the relative position and GM the
/// sum of both.
template <class Scalar = double, int Dim = 2>
struct Attraction {
  using Acts = OnPosition<Scalar, Dim>;
  static constexpr const char* name = "attraction";
  static constexpr const char* about = "Newton's attraction by a centre, -GM/r";
  Scalar gm = Scalar(1);  ///< length³/time²

  auto energy(const auto& q) const {
    using std::sqrt;
    return -gm / sqrt(detail::dot<Dim>(q, q));
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    const auto factor = semiexplicit::detail::over_cube(gm, detail::dot<Dim>(q, q));
    for (int i = 0; i < Dim; ++i) dHdq[i] += factor * q[i];
  }
};

/// Newton's attraction by two masses that rest on the first axis. With RotatingFrame of rate 1 and
/// restricted(μ) it is the circular restricted three-body problem, in units of the distance of the masses and
/// 1/(2π) of their period; Jacobi's constant is then -2H.
///
/// Source: V. Szebehely, Theory of Orbits (1967), section 1.5.
template <class Scalar = double, int Dim = 2>
struct TwoCentres {
  using Acts = OnPosition<Scalar, Dim>;
  static constexpr const char* name = "two_centres";
  static constexpr const char* about = "Newton's attraction by two centres on the first axis";
  Scalar gm1 = Scalar(1), x1 = Scalar(0);  ///< length³/time², length
  Scalar gm2 = Scalar(1), x2 = Scalar(1);

  /// Masses 1 - μ and μ at distance 1, the origin at their centre of mass.
  static TwoCentres restricted(Scalar mu) { return {.gm1 = 1 - mu, .x1 = -mu, .gm2 = mu, .x2 = 1 - mu}; }

  auto energy(const auto& q) const {
    using std::sqrt;
    return -gm1 / sqrt(distance2(q, x1)) - gm2 / sqrt(distance2(q, x2));
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    using semiexplicit::detail::over_cube;
    const auto f1 = over_cube(gm1, distance2(q, x1)), f2 = over_cube(gm2, distance2(q, x2));
    dHdq[0] += f1 * (q[0] - x1) + f2 * (q[0] - x2);
    for (int i = 1; i < Dim; ++i) dHdq[i] += (f1 + f2) * q[i];
  }

 private:
  static auto distance2(const auto& q, const Scalar& x) {
    auto sum = (q[0] - x) * (q[0] - x) + q[1] * q[1];
    if constexpr (Dim == 3) sum += q[2] * q[2];
    return sum;
  }
};

/// The oblateness of the centre, whose axis is the third one: GM J₂ R²/(2r³) · (3z²/r² - 1), outside of the
/// body. In the plane (Dim 2) the orbit is equatorial, z = 0. The node of an orbit turns at -(3/2) n J₂
/// (R/a)² cos i/(1 - e²)².
///
/// Source: D. Vallado, Fundamentals of Astrodynamics and Applications, 4th ed., sections 8.6 and 9.4.
template <class Scalar = double, int Dim = 3>
struct Oblateness {
  using Acts = OnPosition<Scalar, Dim>;
  static constexpr const char* name = "j2";
  static constexpr const char* about = "oblateness of the centre, GM J2 R²(3z²/r² - 1)/(2r³)";
  Scalar gm = Scalar(1);
  Scalar j2 = Scalar(0);      ///< a number: Earth 1.08263e-3, Sun 2e-7
  Scalar radius = Scalar(1);  ///< equatorial, that J₂ refers to; length

  auto energy(const auto& q) const {
    const auto r2 = detail::dot<Dim>(q, q), k3 = over_cube(r2);
    if constexpr (Dim == 3)
      return k3 * (3 * q[2] * q[2] / r2 - 1);
    else
      return -k3;
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    const auto r2 = detail::dot<Dim>(q, q), k5 = 3 * over_cube(r2) / r2;
    auto factor = k5;
    if constexpr (Dim == 3) {
      factor -= 5 * k5 * q[2] * q[2] / r2;
      dHdq[2] += 2 * k5 * q[2];
    }
    for (int i = 0; i < Dim; ++i) dHdq[i] += factor * q[i];
  }

 private:
  /// GM J₂ R²/(2r³); R² last, as it has no room beside GM in cm and float.
  auto over_cube(const auto& r2) const {
    return semiexplicit::detail::over_cube(Scalar(gm * j2 / 2), r2) * radius * radius;
  }
};

/// A frame that turns about the third axis at the rate ω: -ω(q₁p₂ - q₂p₁), which is the Coriolis and the
/// centrifugal force. p stays the inertial velocity: p = q' + ω × q.
///
/// Source: V. Arnold, Mathematical Methods of Classical Mechanics, section 27.
template <class Scalar = double, int Dim = 2>
struct RotatingFrame {
  using Acts = OnBoth<Scalar, Dim>;
  static constexpr const char* name = "rotating_frame";
  static constexpr const char* about = "Coriolis and centrifugal force, -ω(q1 p2 - q2 p1)";
  Scalar omega = Scalar(1);  ///< radians/time

  auto energy(const auto& q, const auto& p) const { return -omega * (q[0] * p[1] - q[1] * p[0]); }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    dHdq[0] -= omega * p[1];
    dHdq[1] += omega * p[0];
    dHdp[0] += omega * q[1];
    dHdp[1] -= omega * q[0];
  }
};

}  // namespace semiexplicit::effects::orbits
