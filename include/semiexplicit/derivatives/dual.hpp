#pragma once

#include <cmath>
#include <concepts>
#include <limits>

#include <Eigen/Core>

// A namespace of its own, since functions as sqrt would hide the standard ones from the rest of detail.
namespace semiexplicit::detail::autodiff {

/// A number with its derivatives in N directions (forward automatic differentiation): arithmetic and the functions below obey
/// the chain rule. It is a plain value that owns its numbers. Eigen's AutoDiffScalar is not: what its operators give refers to
/// their operands, and a function that returns `sum / 2` of a local sum hands out a reference to nothing.
///
/// Comparisons look at the value only. Where a function has no derivative, as sqrt and abs at 0, it comes out NaN or one-sided.
///
/// Source: Griewank, Walther, Evaluating Derivatives, 2nd ed. (SIAM 2008), chapter 3.
template <class T, int N>
struct Dual {
  T value = T(0);
  Eigen::Array<T, N, 1> derivative =
      Eigen::Array<T, N, 1>::Constant(T(0));  // in registers: g++ leaves loops scalar

  Dual() = default;
  template <class U>
  requires(std::convertible_to<U, T>) Dual(const U& number)
      : value(static_cast<T>(number)) {}  // NOLINT: a number is a constant

  /// f(x), of which value f and slope f' are known.
  Dual chain(const T& f, const T& slope) const {
    Dual result(f);
    result.derivative = slope * derivative;
    return result;
  }
  /// f(x, y), of which the value and both slopes are known.
  static Dual chain(const T& f, const T& slope_x, const Dual& x, const T& slope_y, const Dual& y) {
    Dual result(f);
    result.derivative = slope_x * x.derivative + slope_y * y.derivative;
    return result;
  }

  Dual operator+() const { return *this; }
  Dual operator-() const { return chain(-value, T(-1)); }
  friend Dual operator+(const Dual& x, const Dual& y) {
    Dual result(x.value + y.value);
    result.derivative = x.derivative + y.derivative;
    return result;
  }
  friend Dual operator-(const Dual& x, const Dual& y) {
    Dual result(x.value - y.value);
    result.derivative = x.derivative - y.derivative;
    return result;
  }
  friend Dual operator*(const Dual& x, const Dual& y) {
    return chain(x.value * y.value, y.value, x, x.value, y);
  }
  friend Dual operator/(const Dual& x, const Dual& y) {
    const T inverse = T(1) / y.value, ratio = x.value * inverse;
    return chain(x.value / y.value, inverse, x, -ratio * inverse, y);
  }

  // With a constant on one side there is half as much to do.
  template <class U>
  static constexpr bool constant = std::convertible_to<U, T> && !std::same_as<U, Dual>;
  template <class U>
  requires constant<U>
  friend Dual operator+(Dual x, const U& c) {
    x.value += static_cast<T>(c);
    return x;
  }
  template <class U>
  requires constant<U>
  friend Dual operator+(const U& c, const Dual& x) { return x + c; }
  template <class U>
  requires constant<U>
  friend Dual operator-(Dual x, const U& c) {
    x.value -= static_cast<T>(c);
    return x;
  }
  template <class U>
  requires constant<U>
  friend Dual operator-(const U& c, const Dual& x) { return -x + c; }
  template <class U>
  requires constant<U>
  friend Dual operator*(const Dual& x, const U& c) {
    return x.chain(x.value * static_cast<T>(c), static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend Dual operator*(const U& c, const Dual& x) { return x * c; }
  template <class U>
  requires constant<U>
  friend Dual operator/(const Dual& x, const U& c) {
    return x.chain(x.value / static_cast<T>(c), T(1) / static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend Dual operator/(const U& c, const Dual& x) {
    const T ratio = static_cast<T>(c) / x.value;
    return x.chain(ratio, -ratio / x.value);
  }

  template <class U>
  Dual& operator+=(const U& y) {
    return *this = *this + y;
  }
  template <class U>
  Dual& operator-=(const U& y) {
    return *this = *this - y;
  }
  template <class U>
  Dual& operator*=(const U& y) {
    return *this = *this * y;
  }
  template <class U>
  Dual& operator/=(const U& y) {
    return *this = *this / y;
  }

  friend bool operator==(const Dual& x, const Dual& y) { return x.value == y.value; }
  friend bool operator<(const Dual& x, const Dual& y) { return x.value < y.value; }
  friend bool operator>(const Dual& x, const Dual& y) { return x.value > y.value; }
  friend bool operator<=(const Dual& x, const Dual& y) { return x.value <= y.value; }
  friend bool operator>=(const Dual& x, const Dual& y) { return x.value >= y.value; }
};

// What an energy may call, found by argument-dependent lookup: `using std::sqrt; sqrt(x)`, or plain `sqrt(x)`.

template <class T, int N>
Dual<T, N> sqrt(const Dual<T, N>& x) {
  using std::sqrt;
  const T root = sqrt(x.value);
  return x.chain(root, T(1) / (T(2) * root));
}
template <class T, int N>
Dual<T, N> cbrt(const Dual<T, N>& x) {
  using std::cbrt;
  const T root = cbrt(x.value);
  return x.chain(root, T(1) / (T(3) * root * root));
}
template <class T, int N>
Dual<T, N> exp(const Dual<T, N>& x) {
  using std::exp;
  const T value = exp(x.value);
  return x.chain(value, value);
}
template <class T, int N>
Dual<T, N> expm1(const Dual<T, N>& x) {
  using std::exp, std::expm1;
  return x.chain(expm1(x.value), exp(x.value));  // expm1(x) + 1 would lose the digits of a small exp(x)
}
template <class T, int N>
Dual<T, N> log(const Dual<T, N>& x) {
  using std::log;
  return x.chain(log(x.value), T(1) / x.value);
}
template <class T, int N>
Dual<T, N> log1p(const Dual<T, N>& x) {
  using std::log1p;
  return x.chain(log1p(x.value), T(1) / (x.value + T(1)));
}
template <class T, int N>
Dual<T, N> sin(const Dual<T, N>& x) {
  using std::cos, std::sin;
  return x.chain(sin(x.value), cos(x.value));
}
template <class T, int N>
Dual<T, N> cos(const Dual<T, N>& x) {
  using std::cos, std::sin;
  return x.chain(cos(x.value), -sin(x.value));
}
template <class T, int N>
Dual<T, N> tan(const Dual<T, N>& x) {
  using std::tan;
  const T value = tan(x.value);
  return x.chain(value, T(1) + value * value);
}
template <class T, int N>
Dual<T, N> asin(const Dual<T, N>& x) {
  using std::asin, std::sqrt;
  return x.chain(asin(x.value), T(1) / sqrt((T(1) - x.value) * (T(1) + x.value)));
}
template <class T, int N>
Dual<T, N> acos(const Dual<T, N>& x) {
  using std::acos, std::sqrt;
  return x.chain(acos(x.value), T(-1) / sqrt((T(1) - x.value) * (T(1) + x.value)));
}
template <class T, int N>
Dual<T, N> atan(const Dual<T, N>& x) {
  using std::atan;
  return x.chain(atan(x.value), T(1) / (T(1) + x.value * x.value));
}
template <class T, int N>
Dual<T, N> atan2(const Dual<T, N>& y, const Dual<T, N>& x) {
  using std::atan2, std::hypot;
  const T r = hypot(x.value, y.value);  // the squares may overflow, or vanish
  return Dual<T, N>::chain(atan2(y.value, x.value), x.value / r / r, y, -y.value / r / r, x);
}
template <class T, int N>
Dual<T, N> sinh(const Dual<T, N>& x) {
  using std::cosh, std::sinh;
  return x.chain(sinh(x.value), cosh(x.value));
}
template <class T, int N>
Dual<T, N> cosh(const Dual<T, N>& x) {
  using std::cosh, std::sinh;
  return x.chain(cosh(x.value), sinh(x.value));
}
template <class T, int N>
Dual<T, N> tanh(const Dual<T, N>& x) {
  using std::abs, std::exp, std::tanh;
  const T decay = exp(T(-2) * abs(x.value));  // 1 - tanh² would be mere rounding where tanh is nearly 1
  return x.chain(tanh(x.value), T(4) * decay / ((T(1) + decay) * (T(1) + decay)));
}
template <class T, int N>
Dual<T, N> asinh(const Dual<T, N>& x) {
  using std::asinh, std::hypot;
  return x.chain(asinh(x.value), T(1) / hypot(x.value, T(1)));
}
template <class T, int N>
Dual<T, N> acosh(const Dual<T, N>& x) {
  using std::acosh, std::sqrt;
  return x.chain(acosh(x.value), T(1) / sqrt(x.value - T(1)) / sqrt(x.value + T(1)));
}
template <class T, int N>
Dual<T, N> atanh(const Dual<T, N>& x) {
  using std::atanh;
  return x.chain(atanh(x.value), T(1) / ((T(1) - x.value) * (T(1) + x.value)));
}
template <class T, int N>
Dual<T, N> hypot(const Dual<T, N>& x, const Dual<T, N>& y) {
  using std::hypot;
  const T value = hypot(x.value, y.value);
  return Dual<T, N>::chain(value, x.value / value, x, y.value / value, y);
}
// With a constant on one side.
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> atan2(const Dual<T, N>& y, const U& x) {
  return atan2(y, Dual<T, N>(x));
}
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> atan2(const U& y, const Dual<T, N>& x) {
  return atan2(Dual<T, N>(y), x);
}
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> hypot(const Dual<T, N>& x, const U& y) {
  return hypot(x, Dual<T, N>(y));
}
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> hypot(const U& x, const Dual<T, N>& y) {
  return hypot(Dual<T, N>(x), y);
}
template <class T, int N>
Dual<T, N> abs(const Dual<T, N>& x) {
  using std::abs;
  return x.chain(abs(x.value), x.value < T(0) ? T(-1) : T(1));  // of -0, too, it is 0
}
template <class T, int N>
Dual<T, N> fabs(const Dual<T, N>& x) {
  return abs(x);
}

/// Zero with all its derivatives.
template <class T>
bool is_constant_zero(const T& x) {
  return x == T(0);
}
template <class T, int N>
bool is_constant_zero(const Dual<T, N>& x) {
  bool zero = is_constant_zero(x.value);
  for (Eigen::Index i = 0; i < N; ++i) zero = zero && is_constant_zero(x.derivative[i]);
  return zero;
}
/// slope · change, where nothing changes 0 even if there is no slope: x^y at x < 0 has one along x only.
template <class T>
T change_along(const T& slope, const T& change) {
  return is_constant_zero(change) ? T(0) : T(slope * change);
}

/// x^y log(x)^k, which is 0 at x = 0 where y > 0; the derivatives of a power are made of these.
template <class T>
T power_log(const T& x, const T& y, int k) {
  using std::log, std::pow;
  if (k == 0) return pow(x, y);
  if (x == T(0) && y > T(0)) return T(0);
  T result = pow(x, y);
  for (int i = 0; i < k; ++i) result *= log(x);
  return result;
}
template <class T, int N>
Dual<T, N> power_log(const Dual<T, N>& x, const Dual<T, N>& y, int k) {
  T by_x(0);  // x^0 does not change with x
  if (!is_constant_zero(y.value)) by_x = y.value * power_log(x.value, T(y.value - T(1)), k);
  if (k > 0) by_x += T(k) * power_log(x.value, T(y.value - T(1)), k - 1);
  const T by_y = power_log(x.value, y.value, k + 1);
  Dual<T, N> result(power_log(x.value, y.value, k));
  for (Eigen::Index i = 0; i < N; ++i)
    result.derivative[i] = change_along(by_x, x.derivative[i]) + change_along(by_y, y.derivative[i]);
  return result;
}

template <class T, int N>
Dual<T, N> pow(const Dual<T, N>& x, const Dual<T, N>& y) {
  return power_log(x, y, 0);
}
/// x^c with a constant exponent: also for negative x where c is an integer.
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> pow(const Dual<T, N>& x, const U& c) {
  using std::pow;
  if constexpr (requires { c.derivative; }) {
    return pow(x, Dual<T, N>(c));  // constant on the outer level only
  } else {
    if (c == U(0)) return Dual<T, N>(1);
    // c stays a plain number, so that a dual of duals comes back here, and not to the logarithm.
    return x.chain(static_cast<T>(pow(x.value, c)),
                   static_cast<T>(c) * static_cast<T>(pow(x.value, c - U(1))));
  }
}
template <class T, int N, class U>
requires(Dual<T, N>::template constant<U>) Dual<T, N> pow(const U& c, const Dual<T, N>& y) {
  const T base = static_cast<T>(c);
  return y.chain(power_log(base, y.value, 0), power_log(base, y.value, 1));
}
template <class T, int N>
bool isfinite(const Dual<T, N>& x) {
  using std::isfinite;
  return isfinite(x.value);
}

}  // namespace semiexplicit::detail::autodiff

namespace semiexplicit::detail {
using autodiff::Dual;
}

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
