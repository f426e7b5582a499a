#pragma once

#include <cmath>
#include <concepts>
#include <stdexcept>
#include <type_traits>

#include <semiexplicit/systems/charges.hpp>

/// Magnetic fields of accelerators, for MagneticKinetic, RelativisticKinetic, RelativisticCharge and
/// ChargeAlongPath; see charges.hpp for units.
namespace semiexplicit::effects::charges {

/// A solenoid about the third axis with its middle at the origin, a current sheet of a length and a radius R:
///
///     B(z) = B/2 (s(z + L/2) - s(z - L/2)),  s(u) = u/√(u² + R²) on the axis,
///     A = (B(z)/2 - ρ² B''(z)/16) (-y, x, 0),
///
/// to the third power of the distance ρ from it, which is for ρ much smaller than R. The orbital plane of a
/// charge on its way along the axis turns by Larmor's angle, -e ∫B dz/(2p), where ∫B dz = BL.
///
/// Source: Jackson, Classical Electrodynamics, 3rd ed., problems 5.3 and 5.4.
template <class Scalar = double>
struct SolenoidField : detail::AxialPotential<SolenoidField<Scalar>> {
  /// `strength` is B in the middle of a long one.
  SolenoidField(Scalar strength, Scalar of_length, Scalar of_radius)
      : b(strength), length(of_length), radius(of_radius) {}
  Scalar b, length, radius;

  /// ∫B dz on the axis: b/2 times what √((z + L/2)² + R²) - √((z - L/2)² + R²) grows by.
  Scalar integral(const Scalar& from, const Scalar& to) const {
    using std::hypot;
    const Scalar half = length / 2;
    const auto root = [this](const Scalar& z) { return Scalar(hypot(z, radius)); };
    const auto value = [&](const Scalar& z) {
      return Scalar(length * (2 * z / (root(z + half) + root(z - half))));
    };
    // What it lacks of L far out, where the difference has no digits.
    const auto lacks = [&](const Scalar& z) {
      const Scalar begin = root(z + half), end = root(z - half), both = begin + end;
      return Scalar(length * (radius / both) * (radius / (begin + (z + half)) + radius / (end + (z - half))));
    };
    const Scalar far_out = half + radius;
    if (from > far_out && to > far_out) return b / 2 * (lacks(from) - lacks(to));
    if (from < -far_out && to < -far_out) return b / 2 * (lacks(-to) - lacks(-from));
    return b / 2 * (value(to) - value(from));
  }

  auto slopes(const auto& x) const {
    const auto begin = edge(x[2] + length / 2), end = edge(x[2] - length / 2);
    const auto rho2 = x[0] * x[0] + x[1] * x[1], f2 = begin.second - end.second;
    const auto by = -b / 8 * f2;
    using Number = std::remove_cvref_t<decltype(rho2 * f2)>;
    return detail::Slopes<Number>{b / 4 * (begin.value - end.value - rho2 * f2 / 8), by * x[0] / 2,
                                  by * x[1] / 2,
                                  b / 4 * (begin.first - end.first - rho2 * (begin.third - end.third) / 8)};
  }

 private:
  /// s(u) and its derivatives.
  template <class Number>
  struct Edge {
    Number value, first, second, third;
  };
  template <class Number>
  Edge<Number> edge(const Number& u) const {
    using std::sqrt;
    // By ratios: fifth powers of large lengths have no room in a float.
    const Number d2 = 1 / (u * u + radius * radius), d1 = sqrt(d2), part = u * d1,
                 first = radius * radius * d2 * d1, by_d2 = first * d2;
    return {part, first, -3 * part * first * d1, 3 * (5 * part * part - 1) * by_d2};
  }
};
template <std::integral Number>
SolenoidField(Number, Number, Number) -> SolenoidField<double>;
template <class... Numbers>
requires(std::is_arithmetic_v<Numbers>&&...) SolenoidField(Numbers...)
->SolenoidField<detail::NumberOf<Numbers...>>;

/// A planar undulator along the third axis, with the field up and down along the second one:
///
///     A = (B/k) cosh(ky) sin(kz) (1, 0, 0),   B_y = B cosh(ky) cos(kz),   B_z = -B sinh(ky) sin(kz).
///
/// With K = eB/(mck) a charge wiggles by K/(γβk), is slowed to c (1 - (1 + K²/2)/(2γ²)) along the axis, and
/// is focused along y with the wave number Kk/(√2 γβ).
///
/// Source: K. Wille, The Physics of Particle Accelerators (2000), chapter 9; E. Scharlemann, J. Appl. Phys.
/// 58 (1985) 2154.
template <class Scalar = double>
struct UndulatorField {
  UndulatorField(Scalar strength, Scalar wave_number) : b(strength), k(wave_number) {}
  Scalar b, k;

  void add_potential(const auto& x, auto& a) const {
    using std::cosh;
    using std::sin;
    a[0] += b / k * cosh(k * x[1]) * sin(k * x[2]);
  }
  void add_gradient(const auto& x, const auto& v, const auto& factor, auto& out) const {
    using std::cos;
    using std::cosh;
    using std::sin;
    using std::sinh;
    const auto by = factor * v[0] * b;
    out[1] += by * sinh(k * x[1]) * sin(k * x[2]);
    out[2] += by * cosh(k * x[1]) * cos(k * x[2]);
  }
};
template <std::integral Number>
UndulatorField(Number, Number) -> UndulatorField<double>;
template <class... Numbers>
requires(std::is_arithmetic_v<Numbers>&&...) UndulatorField(Numbers...)
->UndulatorField<detail::NumberOf<Numbers...>>;

/// A magnetic quadrupole along the third axis, without ends: B = G (y, x, 0), A = -G/2 (x² - y²) (0, 0, 1).
/// With κ = eG/p a charge along the axis is focused along x as cos(√κ z) and driven away along y as cosh(√κ
/// z).
template <class Scalar = double>
struct QuadrupoleField {
  explicit QuadrupoleField(Scalar gradient) : g(gradient) {}
  Scalar g;  ///< field/length

  void add_potential(const auto& x, auto& a) const { a[2] -= g / 2 * (x[0] * x[0] - x[1] * x[1]); }
  void add_gradient(const auto& x, const auto& v, const auto& factor, auto& out) const {
    const auto by = factor * v[2] * g;
    out[0] -= by * x[0];
    out[1] += by * x[1];
  }
};
template <std::integral Number>
QuadrupoleField(Number) -> QuadrupoleField<double>;

/// The field of a bending magnet, without ends: B along the second axis, uniform. It is given by the
/// component of A along a line of the constant curvature κ that ChargeAlongPath follows, at the distance x to
/// the outside of it,
///
///     A = -B (x + κx²/2)/(1 + κx) (0, 0, 1).
///
/// A charge of the momentum p stays on a line with κ = eB/p. With κ = 0, the default, it is the same field in
/// Cartesian coordinates, A = -Bx (0, 0, 1), which all other classes take. They, and a ChargeAlongPath along
/// a line of another curvature, throw std::invalid_argument.
template <class Scalar = double>
struct BendField {
  explicit BendField(Scalar strength, Scalar of_line = Scalar(0)) : b(strength), curvature(of_line) {}
  Scalar b, curvature;

  void add_potential(const auto& x, auto& a) const { a[2] += along(x); }
  void add_gradient(const auto& x, const auto& v, const auto& factor, auto& out) const {
    out[0] -= factor * v[2] * (b + curvature * along(x) / (1 + curvature * x[0]));
  }
  /// Throws std::invalid_argument where the line has another curvature, beyond the rounding of a float.
  void require_line(const auto& of_line) const requires std::totally_ordered<Scalar> {  // no packs
    using std::abs;
    if (!(abs(of_line - curvature) <= 1e-6 * abs(curvature)))
      throw std::invalid_argument(
          "BendField: its curvature is not that of the line; give both the same one, and none where x, y and "
          "z are Cartesian");
  }

 private:
  auto along(const auto& x) const { return -b * x[0] * (1 + curvature * x[0] / 2) / (1 + curvature * x[0]); }
};
template <std::integral Number>
BendField(Number) -> BendField<double>;
template <std::integral Number>
BendField(Number, Number) -> BendField<double>;
template <class... Numbers>
requires(std::is_arithmetic_v<Numbers>&&...) BendField(Numbers...)
->BendField<detail::NumberOf<Numbers...>>;

}  // namespace semiexplicit::effects::charges
