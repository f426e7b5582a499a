#pragma once

#include <concepts>
#include <limits>
#include <type_traits>

#include <Eigen/Core>

#include <semiexplicit/derivatives/functions.hpp>

namespace semiexplicit::detail::autodiff {

/// Derivatives in N directions, to be multiplied by numbers and added: an array, which goes into registers
/// where g++ leaves loops scalar. One derivative of a pack is but one more pack: through arrays of packs the
/// compilers would not inline the terms of a sum.
template <class T, int N>
struct DerivativesOf {
  using type = Eigen::Array<T, N, 1>;
  static type zero() { return type::Constant(T(0)); }
};
template <class T>
requires(!std::is_floating_point_v<T>) struct DerivativesOf<T, 1> {
  struct type {
    T only;
    SEMIEXPLICIT_INTO_TERM T& operator[](Eigen::Index) { return only; }
    SEMIEXPLICIT_INTO_TERM const T& operator[](Eigen::Index) const { return only; }
    SEMIEXPLICIT_INTO_TERM type& operator+=(const type& y) {
      only += y.only;
      return *this;
    }
    friend SEMIEXPLICIT_INTO_TERM type operator*(const T& factor, const type& x) { return {factor * x.only}; }
    friend SEMIEXPLICIT_INTO_TERM type operator+(const type& x, const type& y) { return {x.only + y.only}; }
    friend SEMIEXPLICIT_INTO_TERM type operator-(const type& x, const type& y) { return {x.only - y.only}; }
  };
  static SEMIEXPLICIT_INTO_TERM type zero() { return {T(0)}; }
};

/// A number with its derivatives in N directions (forward automatic differentiation): arithmetic and the
/// functions of functions.hpp obey the chain rule. It is a plain value that owns its numbers. Eigen's
/// AutoDiffScalar is not: what its operators give refers to their operands, and a function that returns `sum
/// / 2` of a local sum hands out a reference to nothing.
///
/// Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (SIAM 2008), chapter 3.
template <class T, int N>
struct Dual : Operators<Dual<T, N>, T> {
  T value = T(0);
  typename DerivativesOf<T, N>::type derivative = DerivativesOf<T, N>::zero();

  Dual() = default;
  template <class U>
  requires(std::convertible_to<U, T>) SEMIEXPLICIT_INTO_TERM Dual(const U& number)
      : value(static_cast<T>(number)) {}  // NOLINT: a number is a constant

  SEMIEXPLICIT_INTO_TERM Dual chain(const T& f, const T& slope) const {
    Dual result(f);
    result.derivative = slope * derivative;
    return result;
  }
  static SEMIEXPLICIT_INTO_TERM Dual chain(const T& f, const T& slope_x, const Dual& x, const T& slope_y,
                                           const Dual& y) {
    Dual result(f);
    result.derivative = slope_x * x.derivative + slope_y * y.derivative;
    return result;
  }
  static Dual chain_if_varying(const T& f, const T& slope_x, const Dual& x, const T& slope_y, const Dual& y) {
    const auto change = [](const T& slope, const T& by) {
      return is_constant_zero(by) ? T(0) : T(slope * by);
    };
    Dual result(f);
    for (Eigen::Index i = 0; i < N; ++i)
      result.derivative[i] = change(slope_x, x.derivative[i]) + change(slope_y, y.derivative[i]);
    return result;
  }
  static SEMIEXPLICIT_INTO_TERM Dual plus(const Dual& x, const Dual& y) {
    Dual result(x.value + y.value);
    result.derivative = x.derivative + y.derivative;
    return result;
  }
  static SEMIEXPLICIT_INTO_TERM Dual minus(const Dual& x, const Dual& y) {
    Dual result(x.value - y.value);
    result.derivative = x.derivative - y.derivative;
    return result;
  }
  SEMIEXPLICIT_INTO_TERM Dual shifted(const T& f) const {
    Dual result(f);
    result.derivative = derivative;
    return result;
  }
  SEMIEXPLICIT_INTO_TERM Dual scaled(const T& f, const T& factor) const { return chain(f, factor); }
  SEMIEXPLICIT_INTO_TERM const T& compared() const { return value; }

  /// *this += t y, in place: g++ vectorises this, and not a sum that is assigned.
  SEMIEXPLICIT_INTO_TERM void add_multiple(const T& t, const Dual& y) {
    value += t * y.value;
    derivative += t * y.derivative;
  }

  bool constant_zero() const {
    bool zero = is_constant_zero(value);
    for (Eigen::Index i = 0; i < N; ++i) zero = zero && is_constant_zero(derivative[i]);
    return zero;
  }
};

}  // namespace semiexplicit::detail::autodiff

namespace semiexplicit::detail {
using autodiff::Dual;
}

template <class T, int N>
class std::numeric_limits<semiexplicit::detail::Dual<T, N>> : public std::numeric_limits<T> {};

// What Eigen has to know, so that q.squaredNorm(), q.dot(p) and 2.0 * q work.
namespace Eigen {

template <class T, int N>
struct NumTraits<semiexplicit::detail::Dual<T, N>> : NumTraits<T> {
  using Real = semiexplicit::detail::Dual<T, N>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Real;
  enum { IsComplex = 0, IsInteger = 0, IsSigned = 1, RequireInitialization = 1 };
  enum { ReadCost = N + 1, AddCost = N + 1, MulCost = 3 * N };
};
template <class T, int N, class Operation>
struct ScalarBinaryOpTraits<semiexplicit::detail::Dual<T, N>, T, Operation> {
  using ReturnType = semiexplicit::detail::Dual<T, N>;
};
template <class T, int N, class Operation>
struct ScalarBinaryOpTraits<T, semiexplicit::detail::Dual<T, N>, Operation> {
  using ReturnType = semiexplicit::detail::Dual<T, N>;
};

}  // namespace Eigen
