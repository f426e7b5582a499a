#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/function_ref.hpp>
#include <semiexplicit/core/vector.hpp>

// The derivative of a function of one number, with an uncertainty to judge another value by.

namespace semiexplicit::detail {

/// A derivative, how far it may be off, and whether that is little enough to judge another value by it.
template <class Scalar>
struct Slope {
  Scalar value, uncertainty;
  bool judges = false;
  Scalar steps_from = Scalar(0);  ///< the largest of the steps that it was looked for with

  bool admits(const Scalar& given, const Scalar& slack = Scalar(0)) const {
    using std::abs;
    return abs(given - value) <= uncertainty + slack;
  }
};

/// A function of one number; what takes it is compiled once.
template <class Scalar>
using ScalarFunction = FunctionRef<Scalar(const Scalar&)>;

/// The level of noise in f near x, from the fourth differences of values so close that nothing else is left
/// in them.
///
/// Source: J. J. Moré, S. M. Wild, SIAM J. Sci. Comput. 33 (2011) 1292.
template <class Scalar>
Scalar noise_level(const ScalarFunction<Scalar>& f, const Scalar& x, const Scalar& step) {
  using std::sqrt;
  constexpr int count = 9, order = 4;
  Scalar values[count];
  for (int i = 0; i < count; ++i) values[i] = f(x + Scalar(i - count / 2) * step);
  for (int k = 0; k < order; ++k)
    for (int i = 0; i + 1 < count - k; ++i) values[i] = values[i + 1] - values[i];
  Scalar squares(0);
  for (int i = 0; i < count - order; ++i) squares += values[i] * values[i];
  return sqrt(squares / (count - order) / 70);  // 70 = 1 + 16 + 36 + 16 + 1
}

/// The larger of two levels with spacings far below h: with one only, values rounded to a grid could happen
/// to lie on a line. 0 where f is not finite.
template <class Scalar>
Scalar noise_near(const ScalarFunction<Scalar>& f, const Scalar& x, const Scalar& h) {
  using std::isfinite;
  Scalar noise(0);
  for (const Scalar& spacing : {Scalar(h / 65536), Scalar(h / 106039)}) {
    const Scalar found = noise_level<Scalar>(f, x, spacing);
    if (isfinite(found) && found > noise) noise = found;
  }
  return noise;
}

/// How far f moves where it first moves at all as one goes away from x, by the rounding of a number of the
/// size `own` and then 4 times as far each time: where values are rounded to a coarse grid this is 1 to about
/// 4 times its width, and differences below are no slope but 0. Infinite where f does not move up to own/2.
template <class Scalar, class F>
Scalar first_move(const F& f, const Scalar& x, const Scalar& own) {
  using std::abs;
  const Scalar here = f(x);
  Scalar step = std::max<Scalar>(2 * Eigen::NumTraits<Scalar>::epsilon() * own,
                                 (std::numeric_limits<Scalar>::min)());  // below, a step may be no number
  for (; step <= own / 2; step *= 4) {
    const Scalar above = abs(f(x + step) - here), below = abs(f(x - step) - here);
    const Scalar smaller = above > Scalar(0) && !(below > Scalar(0) && below < above) ? above : below;
    if (smaller > Scalar(0)) return smaller;
  }
  return std::numeric_limits<Scalar>::infinity();
}

/// The same at x = 0 where nothing tells how far to go: by the smallest power of 2 that moves f.
template <class Scalar, class F>
Scalar first_move(const F& f) {
  using std::abs;
  using std::isfinite;
  using std::ldexp;
  const Scalar here = f(Scalar(0));
  const auto moved = [&](int exponent) {
    const Scalar x = ldexp(Scalar(1), exponent);
    return std::max<Scalar>(abs(f(x) - here), abs(f(-x) - here));
  };
  int still = std::numeric_limits<Scalar>::min_exponent,
      moving = std::numeric_limits<Scalar>::max_exponent - 1;
  while (moving - still > 1) {
    const int middle = still + (moving - still) / 2;
    (moved(middle) == Scalar(0) ? still : moving) = middle;  // out of the domain it is NaN
  }
  const Scalar found = moved(moving);
  return isfinite(found) && found > Scalar(0) ? found : std::numeric_limits<Scalar>::infinity();
}

/// f'(x) by central differences, extrapolated to a vanishing step (Ridders' method): the step shrinks from
/// `h` on, every column of the tableau removes one more even power of it, and of every row the entry that
/// agrees best with its neighbours is a candidate. Its uncertainty is their disagreement and the noise of f,
/// with room to spare: the level near x, `rounding`, and the rounding of the values that the row is made of,
/// which may be far larger than f(x). A row of larger steps is believed only where it does not contradict the
/// smaller ones: an oscillation may pass unseen.
///
/// Source: C. J. F. Ridders, Adv. Eng. Software 4 (1982) 75.
template <class Scalar>
SEMIEXPLICIT_COLD Slope<Scalar> extrapolated_slope(const ScalarFunction<Scalar>& f, const Scalar& x, Scalar h,
                                                   const Scalar& rounding) {
  using std::abs;
  using std::isfinite;
  constexpr int rows = 16;
  const Scalar unknown = std::numeric_limits<Scalar>::infinity(),
               epsilon = Eigen::NumTraits<Scalar>::epsilon();
  const Scalar noise_here = std::max(rounding, noise_near<Scalar>(f, x, h));
  const Scalar first = h;
  std::vector<Slope<Scalar>> candidates;
  Scalar previous[rows], current[rows], largest[rows];
  for (int i = 0, known = 0; i < rows; ++i, h /= 2) {
    const Scalar right = x + h, left = x - h, above = f(right), below = f(left);
    current[0] = (above - below) / (right - left);
    if (!isfinite(current[0])) {  // outside of the domain: smaller steps may be inside
      known = 0;
      continue;
    }
    largest[known] = std::max(abs(above), abs(below));
    Slope<Scalar> best{current[0], unknown, false, first};
    Scalar power(4), values = largest[known];
    for (int k = 1; k <= known; ++k, power *= 4) {
      current[k] = current[k - 1] + (current[k - 1] - previous[k - 1]) / (power - 1);
      // The weight of the row before is about a third, and half of that by its step.
      values = std::max<Scalar>(values, largest[known - k] / power);
      const Scalar uncertainty =
          8 * std::max(abs(current[k] - current[k - 1]), abs(current[k] - previous[k - 1])) +
          16 * std::max<Scalar>(noise_here, epsilon * values) / h;
      if (uncertainty < best.uncertainty) best.value = current[k], best.uncertainty = uncertainty;
    }
    candidates.push_back(best);
    std::copy(current, current + known + 1, previous);
    ++known;
  }
  Slope<Scalar> result{std::numeric_limits<Scalar>::quiet_NaN(), unknown, false, first};
  for (auto row = candidates.rbegin(); row != candidates.rend(); ++row)
    if (row->uncertainty < result.uncertainty &&
        !(abs(row->value - result.value) > result.uncertainty + row->uncertainty))
      result = *row;
  return result;
}

/// Neither is off from the other by more than both uncertainties, or one of them is unknown.
template <class Scalar>
bool compatible(const Slope<Scalar>& a, const Slope<Scalar>& b) {
  using std::abs;
  return !(abs(a.value - b.value) > a.uncertainty + b.uncertainty);
}

/// f'(x), to judge `given` by, where x is a number of the size `own` in a state of the size `size`; `slack`
/// is by how much a right one may be off beside the uncertainty.
///
/// Steps of about a tenth of `own` come first. Where they say too little, as beside an oscillation much
/// faster than they are, or speak against `given`, smaller ones follow, down to some hundred roundings of x:
/// of two that contradict each other the smaller ones are right. Where all drown in rounding, as at x = 1e-8
/// beside terms of size one, larger ones follow, which must not contradict the others. Entries of a tableau
/// may agree by chance: what speaks against `given` is to do so by other steps as well, and larger ones by
/// such that are 30 times smaller, in float not at all: they do not see what f does near x. Where f moves
/// nowhere it may oscillate below its rounding.
template <class Scalar>
SEMIEXPLICIT_COLD Slope<Scalar> judging_slope(const ScalarFunction<Scalar>& f, const Scalar& x,
                                              const Scalar& given, const Scalar& own, const Scalar& size,
                                              const Scalar& rounding, const Scalar& slack = Scalar(0)) {
  using std::abs;
  using std::isfinite;
  using std::sqrt;
  const Scalar here = f(x), widest = std::max<Scalar>(size, 1);
  Scalar grid = first_move<Scalar>(f, x, own);
  if (!isfinite(grid))
    grid = first_move<Scalar>(
        f, x, std::min<Scalar>(1000000 * std::max(own, widest), (std::numeric_limits<Scalar>::max)()));
  const Scalar noise = isfinite(grid) ? std::max<Scalar>(rounding, grid / 4) : rounding;
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), tiny = sqrt(epsilon);
  Scalar place(0);  // what the rounding of x makes of a right slope, where it is looked at
  const auto agrees = [&](const Slope<Scalar>& slope) { return slope.admits(given, slack + place); };
  const auto with_place = [&](Slope<Scalar> slope) {
    if (slope.judges && !slope.admits(given, slack)) slope.uncertainty += place;
    return slope;
  };
  const auto confirmed = [&](Slope<Scalar> slope) {
    if (!slope.judges || agrees(slope)) return slope;
    for (const double part : {0.71, 0.59, 0.83}) {
      const auto other = extrapolated_slope<Scalar>(f, x, Scalar(part) * slope.steps_from, noise);
      if (!agrees(other) || !(other.uncertainty <= 64 * slope.uncertainty)) continue;
      slope.uncertainty += abs(other.value - slope.value) + other.uncertainty;
      slope.judges = false;
      break;
    }
    return slope;
  };
  const auto variation = [&](const Scalar& h) -> Scalar {
    return std::max(abs(f(x + h) - here), abs(f(x - h) - here)) / h;
  };
  // To speak for `given` takes more than to speak against it: an error of a thousandth is not to pass.
  // A slope of zero is judged by how far f moves nearby, as fast as a polynomial may, for an exponential
  // moves by any amount; one that is only lost in the uncertainty is not.
  const auto moves_nearby = [&](Scalar step) {
    Scalar least = variation(step), power(1);
    for (int k = 0; k < 16; ++k) {
      step /= 2, power *= 8;
      const Scalar moved = variation(step);
      if (!(moved * step > 16 * noise)) break;
      least = std::min<Scalar>(least, moved * power);
    }
    return least;
  };
  const auto judges = [&](const Slope<Scalar>& slope, const Scalar& step, bool near) {
    if (slope.uncertainty <= abs(slope.value) / (agrees(slope) ? 2000 : 100)) return true;
    if (!near) return false;
    const Scalar moved = moves_nearby(step);
    const bool is_rounding = abs(given) <= std::max<Scalar>(slack, 1024 * noise / own);
    return slope.uncertainty <= tiny * moved &&
           (!agrees(slope) || (is_rounding && abs(given) <= 8 * epsilon * moved + slack));
  };
  Scalar h = own / 9, moves = variation(h);
  bool varies = moves != Scalar(0) || isfinite(grid);
  Slope<Scalar> best = extrapolated_slope<Scalar>(f, x, h, noise);
  best.judges = judges(best, h, true);
  if (best.judges && agrees(best)) return best;
  // Where terms cancel at x, the slope is that of an x that is off by some roundings: at the rest of a spring
  // in scaled coordinates it is 0 by one of them, and not by another.
  if (x != Scalar(0)) place = 32 * epsilon * moves_nearby(h);
  if (!isfinite(place)) place = Scalar(0);
  if (best.judges && agrees(best)) return with_place(best);
  // From the steps h of `best` on to smaller ones.
  const auto refine = [&](Scalar step) {
    for (step /= 8192; step > Scalar(0) && step >= 1048576 * epsilon * own; step /= 8192) {
      const Scalar moved = variation(step);
      if (moved == Scalar(0)) break;  // below the resolution of f
      Slope<Scalar> found = extrapolated_slope<Scalar>(f, x, step, noise);
      found.judges = judges(found, step, true);
      if (best.judges ? !compatible(found, best) && agrees(found)
                      : found.judges || found.uncertainty < best.uncertainty || !compatible(found, best))
        best = found;
      if (best.judges && agrees(best)) break;
    }
  };
  if (moves * h > 16384 * std::max<Scalar>(noise, epsilon * abs(here))) refine(h);
  if (best.judges) return with_place(confirmed(best));
  Scalar last = own;
  for (const Scalar& wanted : {Scalar(1000 * own), widest}) {
    const Scalar reach = std::min(wanted, std::max(own, widest));
    if (!(reach > last)) continue;
    last = reach;
    h = reach / 9, moves = variation(h);
    if (moves != Scalar(0)) varies = true;
    const Slope<Scalar> found = extrapolated_slope<Scalar>(f, x, h, noise);
    if (found.uncertainty < best.uncertainty && compatible(found, best)) best = found;
    best.judges = judges(best, h, reach <= std::max(own, size));
    if (best.judges && !agrees(best)) refine(h);
    if (best.judges && !agrees(best)) {
      best.judges = epsilon < Scalar(1e-12);
      if (best.judges) {
        const auto smaller = extrapolated_slope<Scalar>(f, x, Scalar(best.steps_from / 30), noise);
        best.judges = !agrees(smaller) && compatible(smaller, best);
      }
    }
    best = confirmed(best);
    if (best.judges) return with_place(best);
  }
  // f does not depend on x.
  if (!varies) best.uncertainty = std::max<Scalar>(best.uncertainty, 1000 * noise / own);
  best.judges = !varies && isfinite(best.uncertainty) && (given == Scalar(0) || !agrees(best));
  return with_place(best);
}

}  // namespace semiexplicit::detail
