#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>

#include <semiexplicit/core/inlined.hpp>

// A namespace of its own, since functions as sqrt would hide the standard ones from the rest of detail.
namespace semiexplicit::detail::autodiff {

/// What the numbers that differentiate have in common: a value and, in some form, derivatives, on which
/// chain() applies the chain rule. The functions of this header are written once for all of them.
struct Differentiating {};
template <class X>
concept Number = std::derived_from<X, Differentiating>;

/// The slope of |x|: of -0, too, |x| is 0.
template <class T>
SEMIEXPLICIT_INTO_TERM T sign_of(const T& x) {
  return x < T(0) ? T(-1) : T(1);
}

/// log(n), of the precision of T.
template <class T>
T logarithm_of(int n) {
  using std::log;
  return log(T(n));
}
/// The slope of erf, 2/√π exp(-x²).
template <class T>
T bell(const T& x) {
  using std::atan, std::exp, std::sqrt;
  return T(1) / sqrt(atan(T(1))) * exp(-x * x);  // atan(1) = π/4 has a slope where T has derivatives
}

/// The operators of a number X on the base T. X has
///
///     x.value                              chain(f, slope)   f(x), of which value and slope are known
///     chain(f, slope_x, x, slope_y, y)     f(x, y), likewise
///     chain_if_varying(...)              the same where a slope may be NaN along a number that does not vary
///     plus(x, y), minus(x, y)              and, with a constant c, x.shifted(value) and x.scaled(value, c)
///     x.compared()                         the value, to compare
///
/// Comparisons look at the value only. Where a function has no derivative, as sqrt and abs at 0, it comes out
/// NaN or one-sided.
template <class X, class T>
struct Operators : Differentiating {
  using Base = T;
  template <class U>
  static constexpr bool constant = std::convertible_to<U, T> && !std::same_as<U, X>;

  friend SEMIEXPLICIT_INTO_TERM X operator+(const X& x) { return x; }
  friend SEMIEXPLICIT_INTO_TERM X operator-(const X& x) { return x.scaled(-x.value, T(-1)); }
  friend SEMIEXPLICIT_INTO_TERM X operator+(const X& x, const X& y) { return X::plus(x, y); }
  friend SEMIEXPLICIT_INTO_TERM X operator-(const X& x, const X& y) { return X::minus(x, y); }
  friend SEMIEXPLICIT_INTO_TERM X operator*(const X& x, const X& y) {
    return X::chain(x.value * y.value, y.value, x, x.value, y);
  }
  friend SEMIEXPLICIT_INTO_TERM X operator/(const X& x, const X& y) {
    const T inverse = T(1) / y.value, ratio = x.value * inverse;
    return X::chain(x.value / y.value, inverse, x, -ratio * inverse, y);
  }

  // With a constant on one side there is half as much to do.
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator+(const X& x, const U& c) {
    return x.shifted(x.value + static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator+(const U& c, const X& x) {
    return x.shifted(static_cast<T>(c) + x.value);
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator-(const X& x, const U& c) {
    return x.shifted(x.value - static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator-(const U& c, const X& x) {
    return x.scaled(static_cast<T>(c) - x.value, T(-1));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator*(const X& x, const U& c) {
    return x.scaled(x.value * static_cast<T>(c), static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator*(const U& c, const X& x) {
    return x.scaled(static_cast<T>(c) * x.value, static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator/(const X& x, const U& c) {
    return x.scaled(x.value / static_cast<T>(c), T(1) / static_cast<T>(c));
  }
  template <class U>
  requires constant<U>
  friend SEMIEXPLICIT_INTO_TERM X operator/(const U& c, const X& x) {
    const T ratio = static_cast<T>(c) / x.value;
    return x.chain(ratio, -ratio / x.value);
  }
  template <class U>
  friend SEMIEXPLICIT_INTO_TERM X& operator+=(X& x, const U& y) {
    return x = x + y;
  }
  template <class U>
  friend SEMIEXPLICIT_INTO_TERM X& operator-=(X& x, const U& y) {
    return x = x - y;
  }
  template <class U>
  friend SEMIEXPLICIT_INTO_TERM X& operator*=(X& x, const U& y) {
    return x = x * y;
  }
  template <class U>
  friend SEMIEXPLICIT_INTO_TERM X& operator/=(X& x, const U& y) {
    return x = x / y;
  }

  friend SEMIEXPLICIT_INTO_TERM bool operator==(const X& x, const X& y) {
    return x.compared() == y.compared();
  }
  friend SEMIEXPLICIT_INTO_TERM bool operator<(const X& x, const X& y) { return x.compared() < y.compared(); }
  friend SEMIEXPLICIT_INTO_TERM bool operator>(const X& x, const X& y) { return y.compared() < x.compared(); }
  friend SEMIEXPLICIT_INTO_TERM bool operator<=(const X& x, const X& y) {
    return x.compared() <= y.compared();
  }
  friend SEMIEXPLICIT_INTO_TERM bool operator>=(const X& x, const X& y) {
    return y.compared() <= x.compared();
  }

  // Functions of two numbers, one of which may be a constant.
  friend SEMIEXPLICIT_INTO_TERM X atan2(const X& y, const X& x) {
    using std::atan2, std::hypot;
    const T r = hypot(x.value, y.value);  // the squares may overflow, or vanish
    return X::chain(atan2(y.value, x.value), x.value / r / r, y, -y.value / r / r, x);
  }
  friend X pow(const X& x, const X& y) { return power_log(x, y, 0); }
  friend SEMIEXPLICIT_INTO_TERM X hypot(const X& x, const X& y) {
    using std::hypot;
    const T value = hypot(x.value, y.value);
    return X::chain(value, x.value / value, x, y.value / value, y);
  }
  friend SEMIEXPLICIT_INTO_TERM X max(const X& x, const X& y) { return x < y ? y : x; }
  friend SEMIEXPLICIT_INTO_TERM X min(const X& x, const X& y) { return y < x ? y : x; }
  friend SEMIEXPLICIT_INTO_TERM X fmax(const X& x, const X& y) { return x < y || x != x ? y : x; }
  friend SEMIEXPLICIT_INTO_TERM X fmin(const X& x, const X& y) { return y < x || x != x ? y : x; }
};

// What an energy may call, found by argument-dependent lookup: `using std::sqrt; sqrt(x)`, or plain
// `sqrt(x)`.

template <Number X>
SEMIEXPLICIT_INTO_TERM X sqrt(const X& x) {
  using T = typename X::Base;
  using std::sqrt;
  const T root = sqrt(x.value);
  return x.chain(root, T(1) / (T(2) * root));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X cbrt(const X& x) {
  using T = typename X::Base;
  using std::cbrt;
  const T root = cbrt(x.value);
  return x.chain(root, T(1) / (T(3) * root * root));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X exp(const X& x) {
  using T = typename X::Base;
  using std::exp;
  const T value = exp(x.value);
  return x.chain(value, value);
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X exp2(const X& x) {
  using T = typename X::Base;
  using std::exp2;
  const T value = exp2(x.value);
  return x.chain(value, logarithm_of<T>(2) * value);
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X expm1(const X& x) {
  using std::exp, std::expm1;
  return x.chain(expm1(x.value), exp(x.value));  // expm1(x) + 1 would lose the digits of a small exp(x)
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X log(const X& x) {
  using T = typename X::Base;
  using std::log;
  return x.chain(log(x.value), T(1) / x.value);
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X log2(const X& x) {
  using T = typename X::Base;
  using std::log2;
  return x.chain(log2(x.value), T(1) / (logarithm_of<T>(2) * x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X log10(const X& x) {
  using T = typename X::Base;
  using std::log10;
  return x.chain(log10(x.value), T(1) / (logarithm_of<T>(10) * x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X log1p(const X& x) {
  using T = typename X::Base;
  using std::log1p;
  return x.chain(log1p(x.value), T(1) / (x.value + T(1)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X sin(const X& x) {
  using std::cos, std::sin;
  return x.chain(sin(x.value), cos(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X cos(const X& x) {
  using std::cos, std::sin;
  return x.chain(cos(x.value), -sin(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X tan(const X& x) {
  using T = typename X::Base;
  using std::tan;
  const T value = tan(x.value);
  return x.chain(value, T(1) + value * value);
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X asin(const X& x) {
  using T = typename X::Base;
  using std::asin, std::sqrt;
  return x.chain(asin(x.value), T(1) / sqrt((T(1) - x.value) * (T(1) + x.value)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X acos(const X& x) {
  using T = typename X::Base;
  using std::acos, std::sqrt;
  return x.chain(acos(x.value), T(-1) / sqrt((T(1) - x.value) * (T(1) + x.value)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X atan(const X& x) {
  using T = typename X::Base;
  using std::atan;
  return x.chain(atan(x.value), T(1) / (T(1) + x.value * x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X sinh(const X& x) {
  using std::cosh, std::sinh;
  return x.chain(sinh(x.value), cosh(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X cosh(const X& x) {
  using std::cosh, std::sinh;
  return x.chain(cosh(x.value), sinh(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X tanh(const X& x) {
  using T = typename X::Base;
  using std::abs, std::exp, std::tanh;
  const T decay = exp(T(-2) * abs(x.value));  // 1 - tanh² would be mere rounding where tanh is nearly 1
  return x.chain(tanh(x.value), T(4) * decay / ((T(1) + decay) * (T(1) + decay)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X asinh(const X& x) {
  using T = typename X::Base;
  using std::asinh, std::hypot;
  return x.chain(asinh(x.value), T(1) / hypot(x.value, T(1)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X acosh(const X& x) {
  using T = typename X::Base;
  using std::acosh, std::sqrt;
  return x.chain(acosh(x.value), T(1) / sqrt(x.value - T(1)) / sqrt(x.value + T(1)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X atanh(const X& x) {
  using T = typename X::Base;
  using std::atanh;
  return x.chain(atanh(x.value), T(1) / ((T(1) - x.value) * (T(1) + x.value)));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X erf(const X& x) {
  using T = typename X::Base;
  using std::erf, std::exp;
  return x.chain(erf(x.value), bell<T>(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X erfc(const X& x) {
  using T = typename X::Base;
  using std::erfc, std::exp;
  return x.chain(erfc(x.value), -bell<T>(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X abs(const X& x) {
  using std::abs;
  return x.chain(abs(x.value), sign_of(x.value));
}
template <Number X>
SEMIEXPLICIT_INTO_TERM X fabs(const X& x) {
  return abs(x);
}

/// Zero with all its derivatives.
template <class T>
bool is_constant_zero(const T& x) {
  if constexpr (requires { x.constant_zero(); })
    return x.constant_zero();
  else
    return x == T(0);
}

/// x^y log(x)^k, which is 0 at x = 0 where y > 0; the derivatives of a power are made of these.
template <class T>
T power_log(const T& x, const T& y, int k) {
  if constexpr (Number<T>) {
    using Base = typename T::Base;
    Base by_x(0);  // x^0 does not change with x
    if (!is_constant_zero(y.value)) by_x = y.value * power_log(x.value, Base(y.value - Base(1)), k);
    if (k > 0) by_x += Base(k) * power_log(x.value, Base(y.value - Base(1)), k - 1);
    return T::chain_if_varying(power_log(x.value, y.value, k), by_x, x, power_log(x.value, y.value, k + 1),
                               y);
  } else {
    using std::log, std::pow;
    if (k == 0) return pow(x, y);
    if (x == T(0) && y > T(0)) return T(0);
    T result = pow(x, y);
    for (int i = 0; i < k; ++i) result *= log(x);
    return result;
  }
}

/// What a number, of numbers or not, is made of in the end.
template <class X>
struct PlainOf {
  using Type = X;
};
template <Number X>
struct PlainOf<X> : PlainOf<typename X::Base> {};

/// x^c with a constant exponent: also for negative x where c is an integer.
template <Number X, class U>
requires(X::template constant<U>) SEMIEXPLICIT_INTO_TERM X pow(const X& x, const U& c) {
  using std::pow;
  using T = typename X::Base;
  if constexpr (Number<U>) {
    return pow(x, X(c));  // constant on the outer level only
  } else if constexpr (std::floating_point<U> && std::numeric_limits<typename PlainOf<X>::Type>::digits >
                                                     std::numeric_limits<U>::digits) {
    return pow(x, typename PlainOf<X>::Type(c));  // c - 1 would be rounded
  } else {
    if (c == U(0)) return X(1);
    // c stays a plain number, so that a dual of duals comes back here, and not to the logarithm.
    return x.chain(static_cast<T>(pow(x.value, c)),
                   static_cast<T>(c) * static_cast<T>(pow(x.value, c - U(1))));
  }
}
template <Number X, class U>
requires(X::template constant<U>) X pow(const U& c, const X& y) {
  using T = typename X::Base;
  const T base = static_cast<T>(c);
  return y.chain(power_log(base, y.value, 0), power_log(base, y.value, 1));
}

template <Number X>
bool isfinite(const X& x) {
  using std::isfinite;
  return isfinite(x.compared());
}
template <Number X>
bool isnan(const X& x) {
  using std::isnan;
  return isnan(x.compared());
}

}  // namespace semiexplicit::detail::autodiff
