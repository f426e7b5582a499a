#pragma once

#include <concepts>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/vector.hpp>
#include <semiexplicit/scene/effect.hpp>

namespace semiexplicit::effects::charges::detail {

/// The members of a magnetic field, and of one that depends on the time.
template <class Field, class Scalar>
concept HasMembers = requires(const Field& field, const Vector<Scalar, 3>& x, const Scalar& number,
                              Vector<Scalar, 3>& out) {
  field.add_potential(x, out);
  field.add_gradient(x, x, number, out);
};
template <class Field, class Scalar>
concept HasDrivenMembers = requires(const Field& field, const Vector<Scalar, 3>& x, const Scalar& number,
                                    Vector<Scalar, 3>& out) {
  field.add_potential(number, x, out);
  field.add_gradient(number, x, x, number, out);
  field.add_time_derivative(number, x, out);
};

/// Compiles for a magnetic field whose members write to what they are given.
template <class Field, class Scalar>
consteval bool field_adds() {
  static_assert(!std::is_integral_v<Scalar>, "a charge of whole numbers: write 1.0 for 1");
  using Column = Vector<Scalar, 3>;
  using At = const Column&;
  using Number = const Scalar&;
  const auto potential = [](const auto& field,
                            auto& out) -> decltype(field.add_potential(std::declval<At>(), out)) {};
  const auto gradient = [](const auto& field,
                           auto& out) -> decltype(field.add_gradient(std::declval<At>(), std::declval<At>(),
                                                                     std::declval<Number>(), out)) {};
  const auto driven_potential =
      [](const auto& field,
         auto& out) -> decltype(field.add_potential(std::declval<Number>(), std::declval<At>(), out)) {};
  const auto driven_gradient =
      [](const auto& field,
         auto& out) -> decltype(field.add_gradient(std::declval<Number>(), std::declval<At>(),
                                                   std::declval<At>(), std::declval<Number>(), out)) {};
  const auto time_derivative = [](const auto& field, auto& out)
      -> decltype(field.add_time_derivative(std::declval<Number>(), std::declval<At>(), out)) {};
  using semiexplicit::detail::output_faults;
  constexpr auto faults = output_faults<decltype(potential), Field, Column>() |
                          output_faults<decltype(gradient), Field, Column>() |
                          output_faults<decltype(driven_potential), Field, Column>() |
                          output_faults<decltype(driven_gradient), Field, Column>() |
                          output_faults<decltype(time_derivative), Field, Column>();
  static_assert(
      !faults.lost,
      "add_potential, add_gradient or add_time_derivative of this field takes by value what it adds "
      "to, so that it adds nothing: write `auto& a` and `auto& out`");
  static_assert(
      !faults.answered,
      "add_potential, add_gradient or add_time_derivative of this field returns a bool, an int or a "
      "Status, and nobody asks: let it return nothing, and throw, or add NaN, where there is none");
  static_assert(
      HasMembers<Field, Scalar> || HasDrivenMembers<Field, Scalar>,
      "this field has no `void add_potential(const auto& x, auto& a) const` with `void add_gradient(const "
      "auto& x, const auto& v, const auto& factor, auto& out) const`; one that depends on the time takes "
      "it first in both and in `void add_time_derivative(const auto& t, const auto& x, auto& a) const`");
  using semiexplicit::detail::ends_with_a_number;
  using semiexplicit::detail::rounds;
  // No template of four, whose factor is deduced, too, and no column.
  constexpr auto add_gradient = [] {
    if constexpr (requires { &Field::add_gradient; })
      return &Field::add_gradient;
    else if constexpr (requires { &Field::template add_gradient<Column, Column, Column>; })
      return &Field::template add_gradient<Column, Column, Column>;
    else
      return nullptr;
  }();
  constexpr auto add_potential = semiexplicit::detail::pointer_to_add_potential<Field, Column>();
  static_assert(
      !rounds<Scalar, 4, 2>(add_gradient) && !rounds<Scalar, 5, 0>(add_gradient) &&
          !rounds<Scalar, 5, 3>(add_gradient) && !rounds<Scalar, 3, 0>(add_potential) &&
          !rounds<Scalar, 3, 0>(semiexplicit::detail::pointer_to_add_time_derivative<Field, Column>()),
      "add_potential, add_gradient or add_time_derivative of this field takes the time or the factor as a "
      "whole number, or one of fewer digits than the charge's, which rounds it: write `const auto& t`");
  static_assert(!ends_with_a_number<2>(add_potential) && !ends_with_a_number<4>(add_gradient),
                "add_potential or add_gradient of this field ends with a number, which would always be its "
                "default: the time comes first, in add_time_derivative, too");
  return !faults.lost && (HasMembers<Field, Scalar> || HasDrivenMembers<Field, Scalar>);
}

/// Throws std::invalid_argument where a field gives A along a line of another curvature (0: in Cartesian
/// coordinates). Such a field has `require_line(curvature)`; see BendField.
template <class Scalar, class... Fields>
void require_line(const std::tuple<Fields...>& fields, const Scalar& curvature) {
  const auto require = [&](const auto& field) {
    if constexpr (requires { field.require_line(curvature); }) field.require_line(curvature);
  };
  std::apply([&](const auto&... field) { (require(field), ...); }, fields);
}

template <class Field, class Scalar>
concept IsMagnetic = requires(const Field& field, const Scalar& t, const Vector<Scalar, 3>& x,
                              Vector<Scalar, 3>& a) {
  field.add_potential(x, a);
}
|| requires(const Field& field, const Scalar& t, const Vector<Scalar, 3>& x, Vector<Scalar, 3>& a) {
  field.add_potential(t, x, a);
};

/// The same of one that may be an electric potential, an effect OnPosition.
template <class Field, class Scalar>
consteval bool is_field() {
  if constexpr (PositionEffect<Field>) {
    static_assert(
        Field::Acts::Dof == 3 && std::same_as<typename Field::Acts::Scalar, Scalar>,
        "this electric potential acts in another number of dimensions than 3, or on other numbers than "
        "the charge's: give OnPosition<Scalar, 3>, as Attraction<double, 3>");
    static_assert(
        !IsMagnetic<Field, Scalar>,
        "this class is an electric potential and a magnetic field, and one of both would be left out: "
        "make two of it");
    return semiexplicit::detail::is_effect<Field>();
  } else
    return field_adds<Field, Scalar>();
}

}  // namespace semiexplicit::effects::charges::detail
