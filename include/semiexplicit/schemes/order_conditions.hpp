#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>
#include <utility>
#include <vector>

/// The order conditions of a list of kicks A(a0) B(b0) A(a1) ..., found by computing with the list itself:
/// the kicks are exponentials of two letters that do not commute, and the method is of order p where the
/// logarithm L of their product has no terms of degree 2 to p (Hairer, Lubich and Wanner, Geometric Numerical
/// Integration, III.4 and III.5).
///
/// The symmetric projection sees less. Exchanging the two copies exchanges A and B. The part of L that is
/// even under this exchange moves both copies alike and is an error of the result. The odd part drives the
/// copies apart; the projection takes the difference away again, and what is left of a term of degree r is
/// quadratic in it. So the projected method has order p where the even part vanishes up to degree p and p <=
/// 2r.
namespace semiexplicit::detail {

/// What the conditions are computed in. Float loses them in its own rounding.
template <class Scalar>
using ConditionScalar = std::conditional_t<std::is_same_v<Scalar, float>, double, Scalar>;

/// The distance from 1 to the next number, also of types without numeric_limits.
template <class Scalar>
Scalar machine_epsilon() {
  if constexpr (std::numeric_limits<Scalar>::is_specialized) {
    return std::numeric_limits<Scalar>::epsilon();
  } else {
    Scalar epsilon(1);
    while (Scalar(Scalar(1) + epsilon / Scalar(2)) > Scalar(1)) epsilon = epsilon / Scalar(2);
    return epsilon;
  }
}

template <class Scalar>
Scalar magnitude(const Scalar& x) {
  return x < Scalar(0) ? Scalar(-x) : x;
}

/// A polynomial in the words over {A, B} up to some degree. A word of n letters (A = 0, B = 1, first letter
/// highest) stands at the index 1xx...x in binary with n bits after the leading one, so that the words of
/// length n fill the indices from 2^n to 2^(n+1) - 1, and the empty word is at 1.
template <class Scalar>
using WordSeries = std::vector<Scalar>;

inline std::size_t words(int degree) { return std::size_t{1} << degree; }

/// series = exp(c X) series, where X is the letter B or A. The words that start with k letters X are
/// contiguous: the innermost loop is a plain one.
template <class Scalar>
void multiply_by_kick(WordSeries<Scalar>& series, bool is_b, const Scalar& c, int degree) {
  std::vector<Scalar> power(static_cast<std::size_t>(degree) + 1, Scalar(1));  // c^k / k!
  for (int k = 1; k <= degree; ++k)
    power[static_cast<std::size_t>(k)] = power[static_cast<std::size_t>(k) - 1] * c / Scalar(k);
  for (int n = degree; n >= 1; --n) {  // the long words first: they need the short ones as they were
    for (int k = 1; k <= n; ++k) {
      const std::size_t start = is_b ? words(k + 1) - 1 : words(k);
      const std::size_t count = words(n - k);
      Scalar* const to = series.data() + start * count;
      const Scalar* const from = series.data() + count;
      const Scalar factor = power[static_cast<std::size_t>(k)];
      for (std::size_t u = 0; u < count; ++u) to[u] += factor * from[u];
    }
  }
}

/// The logarithm of 1 + T, by Horner's rule on T - T²/2 + T³/3 - ...: every product may be cut off where the
/// factors T that are still to come push it beyond the degree.
template <class Scalar>
WordSeries<Scalar> logarithm(WordSeries<Scalar> series, int degree) {
  series[1] = Scalar(0);
  WordSeries<Scalar> sum(series.size(), Scalar(0)), product(series.size(), Scalar(0));
  for (int k = degree; k >= 1; --k) {
    sum[1] = Scalar(k % 2 == 1 ? 1 : -1) / Scalar(k);
    for (int n = 1; n <= degree - k + 1; ++n) {
      for (std::size_t w = words(n); w < words(n + 1); ++w) {
        Scalar total(0);
        for (int tail = 0; tail < n; ++tail)  // split the word in front of its last `tail` letters
          total += series[w >> tail] * sum[words(tail) | (w & (words(tail) - 1))];
        product[w] = total;
      }
    }
    sum.swap(product);
    sum[1] = Scalar(0);
  }
  return sum;
}

/// log(exp(a0 A) exp(b0 B) exp(a1 A) ...) up to the degree. `a` has one entry more than `b`.
template <class Scalar>
WordSeries<Scalar> log_of_kicks(const std::vector<Scalar>& a, const std::vector<Scalar>& b, int degree) {
  WordSeries<Scalar> series(words(degree + 1), Scalar(0));
  series[1] = Scalar(1);
  multiply_by_kick(series, false, a.back(), degree);
  for (std::size_t i = b.size(); i-- > 0;) {
    multiply_by_kick(series, true, b[i], degree);
    multiply_by_kick(series, false, a[i], degree);
  }
  return logarithm(std::move(series), degree);
}

/// The largest coefficients of one degree of L, and what rounding of the list may leave of a zero.
template <class Scalar>
struct DegreeDefect {
  Scalar even, odd, tolerance;
};

/// How far the partial sums of a list reach from each other; at least 1. Rounding errors grow with its
/// powers.
template <class Scalar>
Scalar reach(const std::vector<Scalar>& list) {
  Scalar sum(0), low(0), high(1);
  for (const Scalar& c : list) {
    sum += c;
    low = std::min(low, sum);
    high = std::max(high, sum);
  }
  return high - low;
}

/// The defects of the degrees 0 to `degree`; the first two are left zero. Never fails; NaN comes out as NaN.
/// `epsilon` is the precision to which the coefficients are known.
template <class Scalar>
std::vector<DegreeDefect<Scalar>> degree_defects(const std::vector<Scalar>& a, const std::vector<Scalar>& b,
                                                 int degree, const Scalar& epsilon) {
  const WordSeries<Scalar> log = log_of_kicks(a, b, degree);
  Scalar length(0);
  for (const Scalar& c : a) length += magnitude(c);
  for (const Scalar& c : b) length += magnitude(c);
  const Scalar longest = std::max(reach(a), reach(b));
  // Rounding alone leaves about a thirtieth of this; the rest is for lists published with a digit less than
  // Scalar has.
  Scalar tolerance = Scalar(8) * epsilon * length;
  std::vector<DegreeDefect<Scalar>> defects(static_cast<std::size_t>(degree) + 1,
                                            {Scalar(0), Scalar(0), Scalar(0)});
  for (int n = 2; n <= degree; ++n) {
    DegreeDefect<Scalar>& defect = defects[static_cast<std::size_t>(n)];
    tolerance = tolerance * longest;
    defect.tolerance = tolerance;
    for (std::size_t w = words(n); w < words(n + 1); ++w) {
      const Scalar exchanged = log[w ^ (words(n) - 1)];
      const Scalar even = magnitude(Scalar((log[w] + exchanged) / Scalar(2)));
      const Scalar odd = magnitude(Scalar((log[w] - exchanged) / Scalar(2)));
      // Not std::max: NaN has to win.
      if (!(even <= defect.even)) defect.even = even;
      if (!(odd <= defect.odd)) defect.odd = odd;
    }
  }
  return defects;
}

/// The orders of the map used alone and of the projected method, as far as the defects were computed.
struct Orders {
  int explicit_order = 0, projected = 0;
};

template <class Scalar>
Orders orders(const std::vector<DegreeDefect<Scalar>>& defects) {
  const int degree = static_cast<int>(defects.size()) - 1;
  int even = 1, odd = 1;  // the highest degrees up to which the two parts vanish
  while (even < degree && defects[static_cast<std::size_t>(even) + 1].even <=
                              defects[static_cast<std::size_t>(even) + 1].tolerance)
    ++even;
  while (odd < degree && defects[static_cast<std::size_t>(odd) + 1].odd <=
                             defects[static_cast<std::size_t>(odd) + 1].tolerance)
    ++odd;
  const auto down_to_even = [](int n) { return n - n % 2; };
  Orders found;
  found.explicit_order = down_to_even(std::min(even, odd));
  found.projected = down_to_even(odd == degree ? even : std::min(even, 2 * (odd + 1)));
  return found;
}

}  // namespace semiexplicit::detail
