#pragma once

#include <cmath>
#include <limits>

namespace semiexplicit::detail {

/// A zero of the continuous function f between a and b, where it has the values fa and fb of different signs:
/// regula falsi in the form of Anderson and Björck, every third step a bisection. It stops where f is zero or
/// a step moves by no more than rounding; a value that is not finite ends it at the last point.
///
/// Source: N. Anderson, Å. Björck, BIT 13 (1973) 253.
template <class F, class Scalar>
Scalar bracketed_root(const F& f, Scalar a, Scalar fa, Scalar b, Scalar fb) {
  using std::abs;
  if (fa == Scalar(0)) return a;
  for (int i = 0; i < 200 && fb != Scalar(0); ++i) {
    // [a, b] brackets the zero, and b is the newest point.
    const Scalar width = b - a;
    Scalar next = b - fb * (width / (fb - fa));
    const Scalar middle = a + width / 2;
    const bool inside = (next > a && next < b) || (next < a && next > b);
    if (!inside || i % 3 == 2) next = middle;
    const Scalar finest = std::numeric_limits<Scalar>::epsilon() * (abs(a) < abs(b) ? abs(b) : abs(a));
    if (!(abs(next - b) > finest)) return next;
    const Scalar value = f(next);
    if (!(abs(value) <= (std::numeric_limits<Scalar>::max)())) return b;
    if ((value > Scalar(0)) != (fb > Scalar(0))) {
      a = b;
      fa = fb;
    } else {
      const Scalar factor = 1 - value / fb;
      fa *= factor > Scalar(0) ? factor : Scalar(0.5);
    }
    b = next;
    fb = value;
  }
  return b;
}

}  // namespace semiexplicit::detail
