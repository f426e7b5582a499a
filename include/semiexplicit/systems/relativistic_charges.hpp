#pragma once

#include <cmath>
#include <tuple>
#include <utility>

#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/field_door.hpp>
#include <semiexplicit/systems/detail/fields_in_time.hpp>

/// Charges as fast as light. q is the position, p the canonical momentum γmv + eA; units as in charges.hpp,
/// with c.
///
/// Source: J. D. Jackson, Classical Electrodynamics, 3rd ed., section 12.1.
namespace semiexplicit::effects::charges {

namespace detail {

/// What a kinetic momentum π = γmv means.
template <class Scalar>
struct Relativity {
  Scalar mass, c;

  /// √(m²c⁴ + c²π²) - mc², without loss of digits where π is small.
  auto energy(const auto& momentum) const {
    const auto square = rapid(momentum);
    return square / (root(square) + 1) * (mass * c) * c;
  }
  auto gamma(const auto& momentum) const { return root(rapid(momentum)); }
  Vector<Scalar, 3> velocity(const auto& momentum) const {
    const Scalar factor = 1 / (mass * root(rapid(momentum)));
    return {factor * momentum[0], factor * momentum[1], factor * momentum[2]};
  }

 private:
  /// (π/(mc))²: in SI units m² is nothing in float.
  auto rapid(const auto& momentum) const {
    const Scalar unit = 1 / (mass * c);
    const auto x = unit * momentum[0], y = unit * momentum[1], z = unit * momentum[2];
    return x * x + y * y + z * z;
  }
  static auto root(const auto& square) {
    using std::sqrt;
    return sqrt(1 + square);
  }
};

}  // namespace detail

/// √(m²c⁴ + c²|p - eA(q)|²) - mc² in the sum of any number of magnetic fields, or in none: a charge at any
/// speed. Fields as for MagneticKinetic, your own and FieldFrom too; electric potentials are effects beside
/// it (electrostatics.hpp).
///
///     charges::RelativisticKinetic motion(1.0, 1.0, 1.0, charges::UniformField(0.1));   // e, m, c, fields
template <class Scalar, class... Fields>
class RelativisticKinetic {
  static_assert((detail::field_adds<Fields, Scalar>() && ...));

 public:
  using Acts = OnBoth<Scalar, 3>;
  static constexpr const char* name = "relativistic_kinetic";
  static constexpr const char* about =
      "motion at any speed in magnetic fields, √(m²c⁴ + c²|p - eA(q)|²) - mc²";

  /// Throws std::invalid_argument for a BendField along a curved line.
  RelativisticKinetic(Scalar charge, Scalar mass, Scalar c, Fields... fields)
      : charge_(charge), relativity_{mass, c}, fields_(std::move(fields)...) {
    detail::require_line(fields_, Scalar(0));
  }

  Scalar energy(const auto& q, const auto& p) const { return relativity_.energy(kinetic(q, p)); }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const Vector<Scalar, 3> v = velocity(q, p);
    for (int i = 0; i < 3; ++i) dHdp[i] += v[i];
    const Scalar factor = -charge_;
    std::apply([&](const auto&... field) { (field.add_gradient(q, v, factor, dHdq), ...); }, fields_);
  }

  Scalar gamma(const auto& q, const auto& p) const { return relativity_.gamma(kinetic(q, p)); }
  Vector<Scalar, 3> velocity(const auto& q, const auto& p) const {
    return relativity_.velocity(kinetic(q, p));
  }
  /// The canonical momentum for a kinetic one, π = γmv, at q.
  Vector<Scalar, 3> momentum(const auto& q, const auto& of_motion) const {
    const Vector<Scalar, 3> a = potential(q);
    return {of_motion[0] + charge_ * a[0], of_motion[1] + charge_ * a[1], of_motion[2] + charge_ * a[2]};
  }

 private:
  Vector<Scalar, 3> potential(const auto& q) const {
    Vector<Scalar, 3> a(-Scalar(0), -Scalar(0), -Scalar(0));
    std::apply([&](const auto&... field) { (field.add_potential(q, a), ...); }, fields_);
    return a;
  }
  Vector<Scalar, 3> kinetic(const auto& q, const auto& p) const {
    const Vector<Scalar, 3> a = potential(q);
    return {p[0] - charge_ * a[0], p[1] - charge_ * a[1], p[2] - charge_ * a[2]};
  }

  Scalar charge_;
  detail::Relativity<Scalar> relativity_;
  std::tuple<Fields...> fields_;
};

/// The same in fields that depend on the time, or not: a Hamiltonian for Autonomous. A field that does has
/// `add_potential(t, x, a)`, `add_gradient(t, x, v, factor, out)` and `add_time_derivative(t, x, a)`, a +=
/// ∂A/∂t; FieldFrom makes them of A(t, x). Electric potentials (electrostatics.hpp) may stand among the
/// fields.
///
///     Autonomous K(charges::RelativisticCharge(1.0, 1.0, 1.0, wave));   // e, m, c, fields
template <class ScalarType, class... Fields>
class RelativisticCharge {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = 3;
  using Column = Vector<Scalar, 3>;

  /// Throws std::invalid_argument for a BendField along a curved line.
  RelativisticCharge(Scalar charge, Scalar mass, Scalar c, Fields... fields)
      : charge_(charge), relativity_{mass, c}, fields_(Scalar(0), std::move(fields)...) {}

  Scalar energy(const Scalar& t, const In<Scalar, 3>& q, const In<Scalar, 3>& p) const {
    return relativity_.energy(kinetic(t, q, p)) + fields_.electric_energy(q);
  }
  /// Returns ∂H/∂t.
  Scalar gradient(const Scalar& t, const In<Scalar, 3>& q, const In<Scalar, 3>& p, Out<Scalar, 3> dHdq,
                  Out<Scalar, 3> dHdp) const {
    const Column v = relativity_.velocity(kinetic(t, q, p));
    dHdp = v;
    dHdq.setZero();
    fields_.add_gradient(t, q, v, -charge_, dHdq);
    fields_.add_electric_gradient(q, dHdq);
    return -charge_ * fields_.time_derivative(t, q, v);
  }
  Scalar gamma(const Scalar& t, const auto& q, const auto& p) const {
    return relativity_.gamma(kinetic(t, q, p));
  }
  /// The kinetic momentum γmv = p - eA, and the canonical momentum for one.
  Column kinetic(const Scalar& t, const auto& q, const auto& p) const {
    const Column a = fields_.potential(t, q);
    return {p[0] - charge_ * a[0], p[1] - charge_ * a[1], p[2] - charge_ * a[2]};
  }
  Column momentum(const Scalar& t, const auto& q, const auto& of_motion) const {
    const Column a = fields_.potential(t, q);
    return {of_motion[0] + charge_ * a[0], of_motion[1] + charge_ * a[1], of_motion[2] + charge_ * a[2]};
  }

 private:
  Scalar charge_;
  detail::Relativity<Scalar> relativity_;
  detail::FieldsInTime<Scalar, Fields...> fields_;
};

}  // namespace semiexplicit::effects::charges
