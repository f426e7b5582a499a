#pragma once

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/field_door.hpp>
#include <semiexplicit/systems/detail/over_cube.hpp>

/// Effects on one charge e of mass m in space, in the electric and magnetic fields of others. q is the
/// position, p the canonical momentum m v + e A(q). Any consistent units, in which the Lorentz force is e(E +
/// v × B): SI, or m = e = 1 and B in units of the gyrofrequency. Velocities far below that of light.
///
/// Source: J. D. Jackson, Classical Electrodynamics, 3rd ed., sections 5.6 and 12.1 to 12.5.
namespace semiexplicit::effects::charges {

namespace detail {

/// What numbers are computed with: 1 is meant as 1.0.
template <class... Numbers>
using NumberOf = std::conditional_t<std::is_integral_v<std::common_type_t<Numbers...>>, double,
                                    std::common_type_t<Numbers...>>;

/// A field about the third axis, A = g(x, y, z) (-y, x, 0). `Profile` gives slopes(x) with g and its
/// derivatives by each coordinate.
template <class Profile>
struct AxialPotential {
  /// a += A(x).
  void add_potential(const auto& x, auto& a) const {
    const auto [g, by_x, by_y, by_z] = profile().slopes(x);
    a[0] -= g * x[1];
    a[1] += g * x[0];
  }
  /// out += factor ∂(v·A)/∂x, at fixed v.
  void add_gradient(const auto& x, const auto& v, const auto& factor, auto& out) const {
    const auto [g, by_x, by_y, by_z] = profile().slopes(x);
    const auto swirl = factor * (v[1] * x[0] - v[0] * x[1]);
    out[0] += factor * g * v[1] + swirl * by_x;
    out[1] += swirl * by_y - factor * g * v[0];
    out[2] += swirl * by_z;
  }

 private:
  const Profile& profile() const { return static_cast<const Profile&>(*this); }
};

template <class Number>
struct Slopes {
  Number g, by_x, by_y, by_z;
};

}  // namespace detail

/// A uniform field B along the third axis: A = B/2 (-y, x, 0). The charge turns at eB/m.
template <class Scalar = double>
struct UniformField : detail::AxialPotential<UniformField<Scalar>> {
  explicit UniformField(Scalar strength) : b(strength) {}
  Scalar b;
  auto slopes(const auto&) const { return detail::Slopes<Scalar>{b / 2, Scalar(0), Scalar(0), Scalar(0)}; }
};
template <std::integral Number>
UniformField(Number) -> UniformField<double>;

/// The field of a magnetic dipole at the origin, its moment along the third axis: A = M (-y, x, 0)/r³, with M
/// = μ₀/(4π) times the moment (field · length³). On the equator B = -M/r³.
template <class Scalar = double>
struct DipoleField : detail::AxialPotential<DipoleField<Scalar>> {
  explicit DipoleField(Scalar moment) : m(moment) {}
  Scalar m;
  auto slopes(const auto& x) const {
    const auto r2 = x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
    const auto g = semiexplicit::detail::over_cube(m, r2), by = -3 * g / r2;
    return detail::Slopes<std::remove_cv_t<decltype(g)>>{g, by * x[0], by * x[1], by * x[2]};
  }
};
template <std::integral Number>
DipoleField(Number) -> DipoleField<double>;

/// A magnetic bottle about the origin, free of sources: B_z = B(1 + (z² - ρ²/2)/L²), B_ρ = -B ρz/L². A charge
/// is thrown back where the field on its line is B/sin²α, α the angle of its velocity to the field in the
/// middle, as long as its gyroradius is small (the magnetic moment is then an adiabatic invariant); it
/// bounces at the rate v sin α/L.
template <class Scalar = double>
struct BottleField : detail::AxialPotential<BottleField<Scalar>> {
  /// `strength` is B in the middle; the field on the axis doubles at the distance `length`.
  BottleField(Scalar strength, Scalar length) : b(strength), inverse_l2(1 / (length * length)) {}
  Scalar b, inverse_l2;
  auto slopes(const auto& x) const {
    const auto rho2 = x[0] * x[0] + x[1] * x[1], z2 = x[2] * x[2];
    const auto g = b / 2 * (1 + (z2 - rho2 / 4) * inverse_l2);
    const auto by = b / 4 * inverse_l2;
    return detail::Slopes<std::remove_cv_t<decltype(g)>>{g, -by * x[0], -by * x[1], 4 * by * x[2]};
  }
};
template <std::integral Number>
BottleField(Number, Number) -> BottleField<double>;
template <class... Numbers>
requires(std::is_arithmetic_v<Numbers>&&...) BottleField(Numbers...)
->BottleField<detail::NumberOf<Numbers...>>;

/// |p - eA(q)|²/(2m) in the sum of any number of magnetic fields, or in none: with a field it couples q and
/// p. A field of your own has `add_potential(x, a)`, a += A(x), and `add_gradient(x, v, factor, out)`, out +=
/// factor ∂(v·A)/∂x.
///
///     // charge, mass, fields
///     charges::MagneticKinetic motion(1.0, 1.0, charges::UniformField(0.1), charges::DipoleField(1.0));
template <class Scalar, class... Fields>
class MagneticKinetic {
  static_assert((detail::field_adds<Fields, Scalar>() && ...));

 public:
  using Acts = OnBoth<Scalar, 3>;
  static constexpr const char* name = "magnetic_kinetic";
  static constexpr const char* about = "motion in magnetic fields, |p - eA(q)|²/(2m)";

  /// Throws std::invalid_argument for a BendField along a curved line.
  MagneticKinetic(Scalar charge, Scalar mass, Fields... fields)
      : charge_(charge), mass_(mass), fields_(std::move(fields)...) {
    detail::require_line(fields_, Scalar(0));
  }

  Scalar energy(const auto& q, const auto& p) const {
    const auto v = velocity(q, p);
    return mass_ * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) / 2;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto v = velocity(q, p);
    for (int i = 0; i < 3; ++i) dHdp[i] += v[i];
    const Scalar factor = -charge_;
    std::apply([&](const auto&... field) { (field.add_gradient(q, v, factor, dHdq), ...); }, fields_);
  }

  /// v = (p - eA(q))/m.
  Vector<Scalar, 3> velocity(const auto& q, const auto& p) const {
    const auto a = potential(q);
    return {(p[0] - charge_ * a[0]) / mass_, (p[1] - charge_ * a[1]) / mass_,
            (p[2] - charge_ * a[2]) / mass_};
  }
  /// The canonical momentum of the velocity v at q.
  Vector<Scalar, 3> momentum(const auto& q, const auto& v) const {
    const auto a = potential(q);
    return {mass_ * v[0] + charge_ * a[0], mass_ * v[1] + charge_ * a[1], mass_ * v[2] + charge_ * a[2]};
  }

 private:
  Vector<Scalar, 3> potential(const auto& q) const {
    Vector<Scalar, 3> a(-Scalar(0), -Scalar(0), -Scalar(0));
    std::apply([&](const auto&... field) { (field.add_potential(q, a), ...); }, fields_);
    return a;
  }

  Scalar charge_, mass_;
  std::tuple<Fields...> fields_;
};

}  // namespace semiexplicit::effects::charges
