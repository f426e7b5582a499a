#pragma once

#include <cstddef>
#include <limits>
#include <tuple>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

// What a user's member function takes, as far as its type tells: one that takes an output by value can be
// called, and what it writes is lost.

namespace semiexplicit::detail {

/// The parameters of a function, a member or static; of one that is overloaded or a template nothing is
/// known, as of any other F.
template <class F>
struct Parameters {
  static constexpr std::size_t count = 0;
};
template <class R, class... T>
struct Parameters<R(T...)> {
  static constexpr std::size_t count = sizeof...(T);
  /// Counted from the last one, 0.
  template <std::size_t back>
  using FromLast = std::tuple_element_t<count - 1 - back, std::tuple<T...>>;
};
#define SEMIEXPLICIT_PARAMETERS_OF(qualifiers) \
  template <class R, class C, class... T>      \
  struct Parameters<R (C::*)(T...) qualifiers> : Parameters<R(T...)> {};
SEMIEXPLICIT_PARAMETERS_OF()
SEMIEXPLICIT_PARAMETERS_OF(noexcept)
SEMIEXPLICIT_PARAMETERS_OF(const)
SEMIEXPLICIT_PARAMETERS_OF(const noexcept)
SEMIEXPLICIT_PARAMETERS_OF(&)
SEMIEXPLICIT_PARAMETERS_OF(&noexcept)
SEMIEXPLICIT_PARAMETERS_OF(const&)
SEMIEXPLICIT_PARAMETERS_OF(const& noexcept)
#undef SEMIEXPLICIT_PARAMETERS_OF
template <class R, class... T, bool Noexcept>
struct Parameters<R (*)(T...) noexcept(Noexcept)> : Parameters<R(T...)> {};

/// Whether a pointer to a member, static or not, is one to a function.
template <class Pointer>
inline constexpr bool points_to_function =
    std::is_member_function_pointer_v<Pointer> || std::is_function_v<std::remove_pointer_t<Pointer>>;

/// pointer_to_step<C, T, U>(), and so on: a null pointer of the type of that member of C, which may be a
/// template of T and U; else a nullptr, about which nothing is known. No body is instantiated but where the
/// return type is deduced: a template of one or three may deduce the time, of which T is no type. `all` says
/// that none does. Of a member with outputs T is one that can be read, too: it may stand for any of its
/// columns.
#define SEMIEXPLICIT_POINTER_TO(member)                                 \
  template <class C, class T, class U = T, bool all = false>            \
  consteval auto pointer_to_##member() {                                \
    constexpr auto is_of = []<class... Given>() {                       \
      if constexpr (all || sizeof...(Given) % 2 == 0) return requires { \
          &C::template member<Given...>;                                \
        };                                                              \
      else                                                              \
        return false;                                                   \
    };                                                                  \
    if constexpr (requires { &C::member; })                             \
      return decltype(&C::member){};                                    \
    else if constexpr (is_of.template operator()<T>())                  \
      return decltype(&C::template member<T>){};                        \
    else if constexpr (is_of.template operator()<T, U>())               \
      return decltype(&C::template member<T, U>){};                     \
    else if constexpr (is_of.template operator()<T, T, U>())            \
      return decltype(&C::template member<T, T, U>){};                  \
    else if constexpr (is_of.template operator()<T, T, U, U>())         \
      return decltype(&C::template member<T, T, U, U>){};               \
    else                                                                \
      return nullptr;                                                   \
  }
SEMIEXPLICIT_POINTER_TO(step)
SEMIEXPLICIT_POINTER_TO(step_until)
SEMIEXPLICIT_POINTER_TO(gradient)
SEMIEXPLICIT_POINTER_TO(energy)
SEMIEXPLICIT_POINTER_TO(time_derivative)
SEMIEXPLICIT_POINTER_TO(position_gradient)
SEMIEXPLICIT_POINTER_TO(momentum_gradient)
SEMIEXPLICIT_POINTER_TO(rest_position_gradient)
SEMIEXPLICIT_POINTER_TO(rest_momentum_gradient)
SEMIEXPLICIT_POINTER_TO(flow)
SEMIEXPLICIT_POINTER_TO(increments)
SEMIEXPLICIT_POINTER_TO(prepared)
SEMIEXPLICIT_POINTER_TO(add_force)
SEMIEXPLICIT_POINTER_TO(add_potential)
SEMIEXPLICIT_POINTER_TO(add_gradient)
SEMIEXPLICIT_POINTER_TO(add_time_derivative)
#undef SEMIEXPLICIT_POINTER_TO

/// A whole number, or one of fewer digits than Scalar.
template <class Number, class Scalar>
inline constexpr bool is_narrower = std::is_integral_v<Number> || (std::is_floating_point_v<Number> &&
                                                                   std::numeric_limits<Number>::digits <
                                                                       std::numeric_limits<Scalar>::digits);

/// Whether a function with `count` parameters takes a Scalar as a narrower number in the place that is given,
/// counted from 0.
template <class Scalar, std::size_t count, std::size_t place, class Function>
constexpr bool rounds(Function) {
  using Found = Parameters<Function>;
  if constexpr (Found::count == count)
    return is_narrower<std::remove_cvref_t<typename Found::template FromLast<count - 1 - place>>, Scalar>;
  else
    return false;
}

/// Whether a function that is called with `count` arguments takes a number behind them, as the time, for
/// which a default stands in.
template <std::size_t count, class Function>
constexpr bool ends_with_a_number(Function) {
  using Found = Parameters<Function>;
  if constexpr (Found::count > count)
    return std::is_floating_point_v<std::remove_cvref_t<typename Found::template FromLast<0>>>;
  else
    return false;
}

/// The class that declares a member, by a pointer to it.
template <class Pointer>
struct DeclaredBy {};
template <class Member, class Class>
struct DeclaredBy<Member Class::*> {
  using Type = Class;
};
/// Whether the member `Newer` is declared by a class that derives from the one of `Older`: what goes with it
/// there may be stale.
template <class Newer, class Older>
constexpr bool overrides_beside(Newer, Older) {
  if constexpr (requires {
                  typename DeclaredBy<Newer>::Type;
                  typename DeclaredBy<Older>::Type;
                }) {
    using Derived = typename DeclaredBy<Newer>::Type;
    using Base = typename DeclaredBy<Older>::Type;
    return !std::is_same_v<Derived, Base> && std::is_base_of_v<Base, Derived>;
  } else {
    return false;
  }
}

/// An Eigen matrix by value, or by T&&, for which one is made: what is written into it is lost.
template <class T>
constexpr bool is_matrix_by_value() {
  using Plain = std::remove_cvref_t<T>;
  if constexpr (std::is_class_v<Plain> && !std::is_lvalue_reference_v<T>)
    return std::is_base_of_v<Eigen::PlainObjectBase<Plain>, Plain>;
  else
    return false;
}

/// Whether one of the last parameters, the outputs, is a matrix by value.
template <class Found, std::size_t outputs>
constexpr bool writes_into_copies() {
  if constexpr (Found::count < outputs)
    return false;
  else
    return []<std::size_t... k>(std::index_sequence<k...>) {
      return (is_matrix_by_value<typename Found::template FromLast<k>>() || ...);
    }
  (std::make_index_sequence<outputs>());
}

/// Whether F, which does not take the time first (`driven`), takes one more argument behind its own, for
/// which a default stands in.
template <bool driven, class F, class... Arguments>
constexpr bool takes_time_last() {
  if constexpr (driven)
    return false;  // its body would not compile with them
  else
    return std::is_invocable_v<const F&, Arguments...>;
}

/// What a function gives; of one that cannot be called so, void.
template <class F, class... Arguments>
struct ResultOfCall {
  using Type = void;
};
template <class F, class... Arguments>
requires std::is_invocable_v<const F&, Arguments...>
struct ResultOfCall<F, Arguments...> {
  using Type = std::remove_cvref_t<std::invoke_result_t<const F&, Arguments...>>;
};
template <class F, class... Arguments>
using ResultOf = typename ResultOfCall<F, Arguments...>::Type;

/// A column of somebody's own type, which is an Eigen column.
template <class Column>
struct Derived : Column {
  using Column::Column;
  using Column::operator=;
};
/// The same, but of which no other can be made by copying its type.
template <class Column>
struct Uncopied : Derived<Column> {
  using Derived<Column>::Derived;
  using Derived<Column>::operator=;
  Uncopied(const Uncopied&) = delete;
};
/// The same, in somebody else's memory, but of which no matrix can be made: this conversion is nearer than
/// Eigen's.
template <class Column>
struct NoMatrix : Derived<Eigen::Map<Column>> {
  using Derived<Eigen::Map<Column>>::Derived;
  using Derived<Eigen::Map<Column>>::operator=;
  template <class Matrix>
  requires std::is_base_of_v<Eigen::PlainObjectBase<Matrix>, Matrix>
  operator Matrix() = delete;
};
/// Whether a member that may be a template, called with an output, takes it by value. `Call` is given the
/// object, const where it says so, and hands an output on to the member, `Given`; a Map or a Ref that is
/// copied still writes to where it is.
template <class Call, class Object, class Given>
constexpr bool loses_output() {
  using Column = typename Given::PlainObject;
  const auto takes = []<class Out>(std::type_identity<Out>) {
    return std::is_invocable_v<Call, Object&, Out&>;
  };
  const bool copied = std::is_same_v<Given, Column> && takes(std::type_identity<Derived<Column>>()) &&
                      !takes(std::type_identity<Uncopied<Column>>());
  return copied || (takes(std::type_identity<Derived<Eigen::Map<Column>>>()) &&
                    !takes(std::type_identity<NoMatrix<Column>>()));
}

/// A bool, an int or a Status: what nobody asks of a member that writes to its outputs.
template <class T>
inline constexpr bool is_answer = std::is_integral_v<T> || std::is_enum_v<T>;
/// Whether a member, called as for loses_output(), gives one: `Call` returns what the member does.
template <class Call, class Object, class Given>
constexpr bool answers() {
  return is_answer<ResultOf<Call, Object&, Given&>>;
}
/// What is wrong with a member that writes to an output.
struct OutputFaults {
  bool lost = false, answered = false;
  constexpr OutputFaults operator|(const OutputFaults& other) const {
    return {lost || other.lost, answered || other.answered};
  }
};
template <class Call, class Object, class Given>
constexpr OutputFaults output_faults() {
  return {loses_output<Call, Object, Given>(), answers<Call, Object, Given>()};
}

}  // namespace semiexplicit::detail
