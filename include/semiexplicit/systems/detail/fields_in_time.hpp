#pragma once

#include <tuple>
#include <utility>

#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/field_door.hpp>

namespace semiexplicit::effects::charges::detail {

/// The fields of a charge as one: magnetic ones that depend on the time or not, and electric potentials,
/// which are effects OnPosition.
template <class Scalar, class... Fields>
class FieldsInTime {
  static_assert((is_field<Fields, Scalar>() && ...));

 public:
  using Column = Vector<Scalar, 3>;
  static constexpr bool has_electric = (PositionEffect<Fields> || ...);

  /// Throws std::invalid_argument for a field along a line of another curvature.
  explicit FieldsInTime(const Scalar& curvature, Fields... fields) : fields_(std::move(fields)...) {
    require_line(fields_, curvature);
  }

  /// A.
  Column potential(const Scalar& t, const auto& x) const {
    Column a(Scalar(0), Scalar(0), Scalar(0));
    each([&]<class Field>(const Field& field) {
      if constexpr (driven<Field>)
        field.add_potential(t, x, a);
      else if constexpr (!PositionEffect<Field>)
        field.add_potential(x, a);
    });
    return a;
  }
  /// out += factor ∂(v·A)/∂x, at fixed v.
  void add_gradient(const Scalar& t, const auto& x, const Column& v, const Scalar& factor, auto& out) const {
    each([&]<class Field>(const Field& field) {
      if constexpr (driven<Field>)
        field.add_gradient(t, x, v, factor, out);
      else if constexpr (!PositionEffect<Field>)
        field.add_gradient(x, v, factor, out);
    });
  }
  /// v·∂A/∂t.
  Scalar time_derivative(const Scalar& t, const auto& x, const Column& v) const {
    Column a(Scalar(0), Scalar(0), Scalar(0));
    each([&]<class Field>(const Field& field) {
      if constexpr (driven<Field>) field.add_time_derivative(t, x, a);
    });
    return v[0] * a[0] + v[1] * a[1] + v[2] * a[2];
  }

  /// The energy of the charge in the electric potentials, eφ.
  Scalar electric_energy(const auto& x) const {
    Scalar sum(0);
    each([&]<class Field>(const Field& field) {
      if constexpr (PositionEffect<Field>) sum += field.energy(x);
    });
    return sum;
  }
  /// out += ∂(eφ)/∂x.
  void add_electric_gradient(const auto& x, auto& out) const {
    each([&]<class Field>(const Field& field) {
      if constexpr (PositionEffect<Field>) field.add_gradient(x, out);
    });
  }

 private:
  template <class Field>
  static constexpr bool driven = requires(const Field& field, const Scalar& t, const Column& x, Column& a) {
    field.add_potential(t, x, a);
  };

  template <class Use>
  void each(const Use& use) const {
    std::apply([&](const auto&... field) { (use(field), ...); }, fields_);
  }

  std::tuple<Fields...> fields_;
};

}  // namespace semiexplicit::effects::charges::detail
