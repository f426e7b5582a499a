#pragma once

#include <cmath>
#include <type_traits>

#include <semiexplicit/systems/orbits.hpp>

/// Relativistic corrections to orbits::Kinetic + orbits::Attraction, for the relative motion of two bodies of
/// total mass M and symmetric mass ratio ν = m₁m₂/M² (0 for a test particle, 1/4 for equal masses), in ADM
/// coordinates of the centre of mass; p is the relative momentum per reduced mass. Valid for GM/(c²r) and
/// (p/c)² much below one.
namespace semiexplicit::effects::orbits {

namespace detail {

/// What these corrections depend on: the square of p, u = GM/r and s = p·q/r.
template <int Dim, class Number>
struct RadialForm {
  Number inverse_r, square, u, s;

  /// Adds the gradient of h(square, u, s), given its derivatives.
  void add_gradient(const Number& by_square, const Number& by_u, const Number& by_s, const auto& q,
                    const auto& p, auto& dHdq, auto& dHdp) const {
    const Number across = by_s * inverse_r, along = -(by_u * u + by_s * s) * inverse_r * inverse_r;
    for (int i = 0; i < Dim; ++i) {
      dHdq[i] += along * q[i] + across * p[i];
      dHdp[i] += 2 * by_square * p[i] + across * q[i];
    }
  }
};

template <int Dim, class Scalar>
auto radial_form(const Scalar& gm, const auto& q, const auto& p) {
  using std::sqrt;
  const auto r2 = dot<Dim>(q, q);
  using Number = std::remove_cvref_t<decltype(r2)>;
  const Number inverse_r = 1 / sqrt(r2);
  return RadialForm<Dim, Number>{inverse_r, dot<Dim>(p, p), gm * inverse_r, dot<Dim>(q, p) * inverse_r};
}

}  // namespace detail

/// The first post-Newtonian correction,
///
///     H = 1/c² (-(1 - 3ν) p⁴/8 - u/2 ((3 + ν) p² + ν s²) + u²/2),   u = GM/r, s = p·q/r.
///
/// It turns the periapsis by 6πGM/(c²a(1 - e²)) an orbit: 42.98 arcseconds a century for Mercury.
///
/// Source: Damour, Jaranowski, Schäfer, Phys. Rev. D 62 (2000) 044024, eq. (2.4b).
template <class Scalar = double, int Dim = 2>
struct PostNewtonian1 {
  using Acts = OnBoth<Scalar, Dim>;
  static constexpr const char* name = "1pn";
  static constexpr const char* about = "first post-Newtonian correction";
  Scalar gm = Scalar(1);  ///< length³/time², as in Attraction
  Scalar c = Scalar(1);   ///< speed of light, length/time
  Scalar nu = Scalar(0);  ///< symmetric mass ratio, 0 to 1/4

  auto energy(const auto& q, const auto& p) const {
    const auto [inverse_r, square, u, s] = detail::radial_form<Dim>(gm, q, p);
    return (-(1 - 3 * nu) * square * square / 8 - u * ((3 + nu) * square + nu * s * s) / 2 + u * u / 2) /
           (c * c);
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto form = detail::radial_form<Dim>(gm, q, p);
    const auto& [inverse_r, square, u, s] = form;
    const Scalar k = 1 / (c * c);
    form.add_gradient(-k * ((1 - 3 * nu) * square / 4 + (3 + nu) * u / 2),
                      k * (u - ((3 + nu) * square + nu * s * s) / 2), -k * nu * u * s, q, p, dHdq, dHdp);
  }
};

/// The second post-Newtonian correction,
///
///     H = 1/c⁴ ((1 - 5ν + 5ν²) p⁶/16 + u/8 ((5 - 20ν - 3ν²) p⁴ - 2ν² s²p² - 3ν² s⁴)
///               + u²/2 ((5 + 8ν) p² + 3ν s²) - (1 + 3ν) u³/4).
///
/// Without PostNewtonian1 it makes little sense. Source: Damour, Jaranowski, Schäfer (2000), eq. (2.4c).
template <class Scalar = double, int Dim = 2>
struct PostNewtonian2 {
  using Acts = OnBoth<Scalar, Dim>;
  static constexpr const char* name = "2pn";
  static constexpr const char* about = "second post-Newtonian correction";
  Scalar gm = Scalar(1);
  Scalar c = Scalar(1);
  Scalar nu = Scalar(0);

  auto energy(const auto& q, const auto& p) const {
    const auto form = detail::radial_form<Dim>(gm, q, p);
    const auto [a, b, d] = coefficients();
    // Over c², for c⁴ has no room in cm/s and float.
    const Scalar k = 1 / (c * c);
    const auto square = k * form.square, u = k * form.u, ss = k * nu * form.s * form.s;
    return form.square * (a * square * square / 16) +
           form.u * ((b * square * square - 2 * nu * ss * square - 3 * ss * ss) / 8 +
                     u * (d * square + 3 * ss) / 2 - (1 + 3 * nu) * u * u / 4);
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto form = detail::radial_form<Dim>(gm, q, p);
    const auto [a, b, d] = coefficients();
    const Scalar k = 1 / (c * c);
    const auto square = k * form.square, u = k * form.u, ss = k * nu * form.s * form.s;
    form.add_gradient(3 * a * square * square / 16 + u * (b * square - nu * ss) / 4 + d * u * u / 2,
                      (b * square * square - 2 * nu * ss * square - 3 * ss * ss) / 8 +
                          u * (d * square + 3 * ss) - (3 + 9 * nu) * u * u / 4,
                      nu * form.s * u * (3 * u - (nu * square + 3 * ss) / 2), q, p, dHdq, dHdp);
  }

 private:
  struct Coefficients {
    Scalar a, b, d;
  };
  Coefficients coefficients() const {
    return {1 - 5 * nu + 5 * nu * nu, 5 - 20 * nu - 3 * nu * nu, 5 + 8 * nu};
  }
};

/// Spin and orbit at leading order, for a test body about a centre with spin (angular momentum) S along the
/// third axis: 2G S·L/(c²r³), the dragging of frames. It turns the node of an orbit at 2GS/(c²a³(1 -
/// e²)^(3/2)).
///
/// Sources: J. Lense and H. Thirring, Phys. Z. 19 (1918) 156; Damour and Schäfer, Nuovo Cim. B 101 (1988)
/// 127.
template <class Scalar = double, int Dim = 3>
struct SpinOrbit {
  using Acts = OnBoth<Scalar, Dim>;
  static constexpr const char* name = "spin_orbit";
  static constexpr const char* about = "dragging of frames by the centre's spin, 2G S·L/(c²r³)";
  Scalar gs = Scalar(1);  ///< G times the spin, length⁵/time³
  Scalar c = Scalar(1);   ///< length/time

  auto energy(const auto& q, const auto& p) const { return weight(q) * (q[0] * p[1] - q[1] * p[0]); }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto k = weight(q), l = q[0] * p[1] - q[1] * p[0];
    const auto pull = 3 * k * l / detail::dot<Dim>(q, q);
    dHdq[0] += k * p[1];
    dHdq[1] -= k * p[0];
    for (int i = 0; i < Dim; ++i) dHdq[i] -= pull * q[i];
    dHdp[0] -= k * q[1];
    dHdp[1] += k * q[0];
  }

 private:
  auto weight(const auto& q) const {
    return semiexplicit::detail::over_cube(Scalar(2 * gs / (c * c)), detail::dot<Dim>(q, q));
  }
};

}  // namespace semiexplicit::effects::orbits
