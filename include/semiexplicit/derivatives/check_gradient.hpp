#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <locale>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/function_ref.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/median.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/reference_size.hpp>
#include <semiexplicit/core/simd.hpp>

namespace semiexplicit {

/// What a gradient does with an entry of its output, which holds anything when it is called.
enum class GradientOutput {
  written,      ///< overwrites it
  not_written,  ///< leaves it as it is
  added_to,     ///< adds to it
  other_packs,  ///< overwrites it, and with another number where it is called with packs (HasPackGradient)
  unclear       ///< neither: it depends on what was there in another way, or changes from call to call
};

/// What check_gradient() found.
template <class Scalar>
struct GradientCheck {
  /// One entry of the gradient beside what the energy says.
  struct Entry {
    std::string name;    ///< "dH/dq[0]"
    Scalar given;        ///< by H.gradient, into an output of zeros
    Scalar expected;     ///< by differences of H.energy
    Scalar uncertainty;  ///< of `expected`: an entry that is judged is wrong if it is further off than this
    bool judged;  ///< false: the differences are too uncertain to tell a right entry from, say, one of the
                  ///< wrong sign
    bool wrong;
    GradientOutput output = GradientOutput::written;

    /// Not by the energy's slope, which an entry that is only written in the wrong way may have.
    bool clashes() const {
      using std::abs;
      using std::isfinite;
      return !isfinite(given) || (isfinite(expected) && !(abs(given - expected) <= uncertainty));
    }
  };
  std::vector<Entry> entries;  ///< all 2d, positions first

  /// No entry is wrong, as far as they could be judged.
  bool ok() const {
    return std::none_of(entries.begin(), entries.end(), [](const Entry& e) { return e.wrong; });
  }
  /// Every entry could be judged: right is then ok() && judged().
  bool judged() const {
    return std::all_of(entries.begin(), entries.end(), [](const Entry& e) { return e.judged; });
  }
};

namespace detail {

/// A guess at why entry i is not what the energy says, or nothing.
template <class Scalar>
SEMIEXPLICIT_COLD std::string gradient_guess(const GradientCheck<Scalar>& check, std::size_t i) {
  const auto& e = check.entries[i];
  const auto near = [](const Scalar& x, const Scalar& y, const Scalar& uncertainty) {
    using std::abs;
    return abs(x - y) <= uncertainty;
  };
  const std::size_t d = check.entries.size() / 2;
  const Scalar& partner = check.entries[(i + d) % (2 * d)].expected;
  if (near(e.expected, Scalar(0), e.uncertainty)) return "";
  if (near(e.given, Scalar(0), e.uncertainty)) return "is it set at all?";
  if (near(e.given, -e.expected, e.uncertainty)) return "the sign is wrong";
  if (near(e.given, 2 * e.expected, 2 * e.uncertainty) || near(2 * e.given, e.expected, e.uncertainty))
    return "a factor 2";
  if (near(e.given, partner, e.uncertainty) || near(e.given, -partner, e.uncertainty))
    return "that is the other half's; are dHdq and dHdp exchanged?";
  return "";
}

SEMIEXPLICIT_COLD inline std::string describe(GradientOutput output) {
  switch (output) {
    case GradientOutput::written:
      return "is written";
    case GradientOutput::not_written:
      return "is not written: what was in the output stays there";
    case GradientOutput::added_to:
      return "is added to what was in the output: write it with =, or set the output to zero first";
    case GradientOutput::other_packs:
      return "is another number where the gradient is called with packs, as by Ensemble and "
             "GaussLegendreLanes: let both do the same, or leave PackGradientOf out";
    case GradientOutput::unclear:
      return "depends on what was in the output, or changes from call to call";
  }
  return "";
}

/// One wrong entry in words.
template <class Scalar>
SEMIEXPLICIT_COLD std::string entry_in_words(const GradientCheck<Scalar>& check, std::size_t i) {
  using std::isfinite;
  const auto& e = check.entries[i];
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << e.name;
  const bool clashes = !isfinite(e.given) || (e.judged && e.clashes());
  if (clashes) {
    text.precision(10);
    text << " is " << static_cast<long double>(e.given) << ", but by the energy it is "
         << static_cast<long double>(e.expected);
    text.precision(1);
    text << " (+- " << static_cast<long double>(e.uncertainty) << ")";
    const std::string guess = gradient_guess(check, i);
    if (!guess.empty()) text << ": " << guess;
  }
  if (e.output != GradientOutput::written) text << (clashes ? "; it " : " ") << describe(e.output);
  return text.str();
}

}  // namespace detail

/// In words: every wrong entry with its value, the expected one and a guess at the cause, or that all is
/// right, and what could not be judged. Of long lists the first entries.
template <class Scalar>
SEMIEXPLICIT_COLD std::ostream& operator<<(std::ostream& out, const GradientCheck<Scalar>& check) {
  constexpr std::size_t most = 12;
  std::size_t wrong = 0, unjudged = 0;
  std::string lines, names;
  for (std::size_t i = 0; i < check.entries.size(); ++i) {
    const auto& e = check.entries[i];
    if (e.wrong && ++wrong <= most) lines += (lines.empty() ? "" : "\n") + detail::entry_in_words(check, i);
    if (!e.wrong && !e.judged && ++unjudged <= most) names += (names.empty() ? "" : ", ") + e.name;
  }
  if (wrong > most) lines += "\nand " + std::to_string(wrong - most) + " entries more";
  if (unjudged > most) names += " and " + std::to_string(unjudged - most) + " more";
  if (wrong == 0 && unjudged < check.entries.size())
    lines = unjudged == 0 ? "the gradient agrees with the energy"
                          : "the gradient agrees with the energy in the entries that could be judged";
  if (unjudged > 0)
    lines += (lines.empty() ? "" : "\n") + ("not judged: " + names) +
             "; the differences of the energy say too little about them here, choose another z";
  return out << lines;
}

namespace detail {

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

/// The gradient of H at z, and what it does with its outputs, from calls that find different numbers in them.
template <Hamiltonian H>
SEMIEXPLICIT_COLD std::vector<GradientOutput> written_gradient(
    const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
    PhasePoint<typename H::Scalar, H::Dof>& given) {
  using Scalar = typename H::Scalar;
  using Limits = std::numeric_limits<Scalar>;
  using std::abs;
  using std::isfinite;
  using std::sqrt;
  const auto into = [&](const Scalar& filling) {
    auto out = z;
    out.vector().setConstant(filling);
    gradient_at(hamiltonian, z.vector().data(), out.vector().data(), z.dof());
    return out;
  };
  given = into(Scalar(0));
  Scalar filling(1);
  for (const Scalar& x : given.vector())
    if (isfinite(x)) filling = std::max(filling, abs(x));
  const auto second = into(filling), third = Limits::has_quiet_NaN ? into(Limits::quiet_NaN()) : second;
  // Of sums in another order, in the units of a half.
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(),
               largest[2] = {largest_absolute(given.q()), largest_absolute(given.p())};
  const auto same = [&](Eigen::Index i, const Scalar& x, const Scalar& y) {
    return x == y || (x != x && y != y) ||
           abs(x - y) <= sqrt(epsilon) * std::min<Scalar>(abs(x), abs(y)) +
                             256 * epsilon * largest[i < z.dof() ? 0 : 1];
  };
  std::vector<GradientOutput> outputs;
  for (Eigen::Index i = 0; i < given.vector().size(); ++i) {
    const Scalar a = given.vector()[i], b = second.vector()[i], c = third.vector()[i];
    outputs.push_back(same(i, a, b) && same(i, a, c)   ? GradientOutput::written
                      : a == Scalar(0) && b == filling ? GradientOutput::not_written
                      : isfinite(a) && abs(b - a - filling) <= sqrt(epsilon) * filling
                          ? GradientOutput::added_to
                          : GradientOutput::unclear);
  }
  return outputs;
}

/// Sizes of the entries of q, or of p.
template <class Scalar>
struct EntrySizes {
  Scalar largest;
  /// For entries that are zero, which say nothing about it: the middle one of the others' sizes, so that a
  /// late time or another large entry does not count.
  Scalar typical;
};

/// Of entries that are not all zero, or of none.
template <class Scalar>
SEMIEXPLICIT_COLD std::optional<EntrySizes<Scalar>> entry_sizes(const auto& entries) {
  using std::abs;
  std::vector<Scalar> sizes;
  for (const Scalar& x : entries)
    if (x != Scalar(0)) sizes.push_back(abs(x));
  if (sizes.empty()) return std::nullopt;
  return EntrySizes<Scalar>{largest_absolute(entries), median(std::move(sizes))};
}

/// Those of q and of p, whose units may be any; of a half that is zero those of the other one, or 1.
template <class Scalar, int Dof>
SEMIEXPLICIT_COLD std::array<EntrySizes<Scalar>, 2> sizes_of_halves(const PhasePoint<Scalar, Dof>& z) {
  const auto q = entry_sizes<Scalar>(z.q()), p = entry_sizes<Scalar>(z.p());
  const EntrySizes<Scalar> one{Scalar(1), Scalar(1)};
  return {q.value_or(p.value_or(one)), p.value_or(q.value_or(one))};
}

/// Says of which entries, of those that are written, the gradient for packs makes another number. Looks at
/// points around z, too: these show how large the terms of an entry are, which may cancel at z, and by which
/// alone it is judged, since others may be in other units.
template <HasPackGradient H>
SEMIEXPLICIT_COLD void compare_packs(const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
                                     std::vector<GradientOutput>& outputs) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::sqrt;
  constexpr int points = 4;
  const auto d = static_cast<std::size_t>(z.dof());
  const auto sizes = sizes_of_halves(z);
  std::vector<Scalar> off(2 * d, Scalar(0)), terms = off;
  std::vector<Pack<Scalar>> at(2 * d), packs(2 * d);
  Scalar largest[2] = {Scalar(0), Scalar(0)};
  PhasePoint<Scalar, H::Dof> point = z, given = z;
  std::uint64_t random = 1;
  for (int k = 0; k < points; ++k) {
    for (std::size_t i = 0; i < 2 * d; ++i) {
      auto& x = point.vector()[static_cast<Eigen::Index>(i)];
      if (k > 0) x += Scalar(scattered(random)) / 4 * (x == Scalar(0) ? sizes[i < d ? 0 : 1].typical : x);
      for (std::size_t lane = 0; lane < Pack<Scalar>::size(); ++lane)
        at[i][lane] = x, packs[i][lane] = Scalar(1);
    }
    try {
      gradient_at(hamiltonian, point.vector().data(), given.vector().data(), z.dof());
      if (!all_finite(given.vector())) continue;
      const Pack<Scalar>*q = at.data(), *p = q + d;
      Pack<Scalar>*dHdq = packs.data(), *dHdp = dHdq + d;
      hamiltonian.gradient(q, p, dHdq, dHdp);
    } catch (const std::logic_error&) {  // out of the domain
      continue;
    }
    for (std::size_t i = 0; i < 2 * d; ++i) {
      const Scalar expected = given.vector()[static_cast<Eigen::Index>(i)];
      terms[i] = std::max<Scalar>(terms[i], abs(expected));
      largest[i < d ? 0 : 1] = std::max<Scalar>(largest[i < d ? 0 : 1], abs(expected));
      for (std::size_t lane = 0; lane < Pack<Scalar>::size(); ++lane) {
        const Scalar found = abs(packs[i][lane] - expected);
        if (!(found <= off[i])) off[i] = found == found ? found : std::numeric_limits<Scalar>::infinity();
      }
    }
  }
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
  for (std::size_t i = 0; i < 2 * d; ++i)
    if (outputs[i] == GradientOutput::written &&
        off[i] > sqrt(epsilon) * terms[i] + 64 * epsilon * largest[i < d ? 0 : 1])
      outputs[i] = GradientOutput::other_packs;
}

/// NaN where the energy throws std::logic_error, as std::domain_error out of its domain.
template <class H>
typename H::Scalar energy_or_nan(const H& hamiltonian, const auto& q, const auto& p) {
  try {
    return hamiltonian.energy(q, p);
  } catch (const std::logic_error&) {
    return std::numeric_limits<typename H::Scalar>::quiet_NaN();
  }
}

/// How far a coordinate that is zero, as all of its half are, is to go so that f, the energy, moves by about
/// `energy`: its size, of which nothing else tells.
template <class Scalar>
SEMIEXPLICIT_COLD std::optional<Scalar> size_by_energy(const ScalarFunction<Scalar>& f, const Scalar& guess,
                                                       const Scalar& energy) {
  using std::abs;
  constexpr int most = 80;
  const Scalar here = f(Scalar(0)), factor(16);
  const auto too_far = [&](const Scalar& x) {  // also out of the domain
    return !(abs(f(x) - here) <= energy && abs(f(-x) - here) <= energy);
  };
  Scalar size = guess;
  int k = 0;
  if (too_far(size))
    while (k < most && too_far(size)) size /= factor, ++k;
  else
    while (k < most && !too_far(size * factor)) size *= factor, ++k;
  return k < most ? std::optional(size) : std::nullopt;
}

/// What rounding makes of an energy is judged by its terms, which may be far larger than their sum, and by
/// how far it moves at least where all entries change, which is Inf where it does not. Not by the gradient: a
/// wrong one would excuse itself.
template <HasEnergy H>
typename H::Scalar energy_rounding(const H& hamiltonian, const typename H::Scalar& energy,
                                   const PhasePoint<typename H::Scalar, H::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  const auto terms =
      reference_size([&](const auto& q, const auto& p) { return energy_or_nan(hamiltonian, q, p); }, energy,
                     z)
          .terms;
  PhasePoint<Scalar, H::Dof> at = z, direction = z;
  const auto sizes = sizes_of_halves(z);
  const auto along = [&](const Scalar& s) -> Scalar {
    at.vector() = z.vector() + s * direction.vector();
    return energy_or_nan(hamiltonian, at.q(), at.p());
  };
  Scalar least = std::numeric_limits<Scalar>::infinity();
  std::uint64_t random = 1;
  const bool stays[2] = {z.q().isZero(0), z.p().isZero(0)};  // of unknown size
  for (int k = 0; k < 8 && (k < 4 || !isfinite(least)); ++k) {
    for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
      const std::size_t half = i < z.dof() ? 0 : 1;
      const Scalar own = z.vector()[i] != Scalar(0) ? z.vector()[i]
                         : k < 4 && stays[half]     ? Scalar(0)
                                                    : sizes[half].typical;
      direction.vector()[i] = Scalar(scattered(random)) * (k < 4 ? own : std::max<Scalar>(abs(own), 1));
    }
    least =
        std::min(least, k < 4 ? first_move<Scalar>(along, Scalar(0), Scalar(1)) : first_move<Scalar>(along));
  }
  return std::max<Scalar>({Eigen::NumTraits<Scalar>::epsilon() * (abs(energy) + 2 * terms), least / 4,
                           std::numeric_limits<Scalar>::min()});  // where it underflows
}

}  // namespace detail

/// Compares the gradient of H at z, entry by entry, with differences of its energy, and takes no right
/// gradient for a wrong one: the differences come with their uncertainty, typically 1e-12 of the energy in
/// double. (But for a z within some 1e-5 of its size, 1e-3 in float, of a kink of the energy, of which it may
/// tell the other side; and where a term of the energy drowns in the rounding of the others, or oscillates
/// often within the size of a coordinate: of random sums with such terms one right gradient in 10,000 is
/// refused in float, one in 100,000 in double. An energy that is computed in single precision and returned as
/// double is less exact than its rounding shows, and it is one in a hundred.) Costs some sixty energies
/// an entry, up to eight times that where they say little or the entry is wrong, and three gradients, whose
/// outputs hold different numbers before; with a gradient for packs four more of both kinds, at z and near
/// it.
///
///     if (const auto check = check_gradient(H, z); !check.ok()) std::cerr << check << '\n';
///
/// Wrong are also a NaN in the gradient, and an entry that is not written or added to instead: an integrator
/// hands in outputs that hold anything; and one that is another number by a gradient for packs. An entry
/// about which the differences say too little, as at the edge of the domain, is not judged:
/// GradientCheck::judged() is false then. Choose z with care: at a point of symmetry, as z = 0, many wrong
/// gradients vanish like the right one. Throws std::invalid_argument if z has another size than H, or the
/// energy at z is not finite.
template <class H>
SEMIEXPLICIT_COLD GradientCheck<typename detail::EnergyDoor<H>::Scalar> check_gradient(
    const H& hamiltonian,
    const PhasePoint<typename detail::EnergyDoor<H>::Scalar, detail::EnergyDoor<H>::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  const Eigen::Index d = dof_of(hamiltonian);
  if (z.dof() != d)
    throw std::invalid_argument("check_gradient: z has " + std::to_string(z.dof()) +
                                " degrees of freedom and the Hamiltonian " + std::to_string(d));
  if (d == 0) throw std::invalid_argument("check_gradient: there are no degrees of freedom");
  const Scalar energy = hamiltonian.energy(z.q(), z.p());
  if (!isfinite(energy))
    throw std::invalid_argument(
        "check_gradient: the energy at z is NaN or Inf; choose a point where it is finite");
  PhasePoint<Scalar, H::Dof> given(d), at(z);
  auto outputs = detail::written_gradient(hamiltonian, z, given);
  if constexpr (HasPackGradient<H>) detail::compare_packs(hamiltonian, z, outputs);
  const Scalar rounding = detail::energy_rounding(hamiltonian, energy, z),
               epsilon = Eigen::NumTraits<Scalar>::epsilon();
  const auto sizes = detail::sizes_of_halves(z);
  GradientCheck<Scalar> check;
  for (Eigen::Index i = 0; i < 2 * d; ++i) {
    const auto energy_at = [&](const Scalar& x) -> Scalar {
      at.vector()[i] = x;
      return detail::energy_or_nan(hamiltonian, at.q(), at.p());
    };
    // The first step is meant to be too large, but not by much: about a tenth of the variable.
    const auto& [largest, typical] = sizes[i < d ? 0 : 1];
    const Scalar x = z.vector()[i], own = x == Scalar(0) ? typical : Scalar(abs(x));
    const auto slope_within = [&](const Scalar& from, const Scalar& widest) {
      return detail::judging_slope<Scalar>(energy_at, x, given.vector()[i], from, widest, rounding);
    };
    std::optional<Scalar> by_energy;
    const bool at_zero = (i < d ? z.q() : z.p()).isZero(0);
    if (at_zero) by_energy = detail::size_by_energy<Scalar>(energy_at, own, rounding / epsilon);
    auto slope = by_energy ? slope_within(*by_energy, *by_energy) : slope_within(own, largest);
    // The size of the other half says nothing of this one: what 1 tells has to agree.
    if (at_zero && !by_energy && slope.judges) {
      const auto other = slope_within(Scalar(1), Scalar(1));
      slope.judges = other.judges &&
                     abs(other.value - slope.value) <= other.uncertainty + slope.uncertainty &&
                     (given.vector()[i] == Scalar(0) || slope.uncertainty <= abs(given.vector()[i]));
    }
    // Beside energies elsewhere an oscillation may be too small to tell its size; the given slope may.
    const Scalar entry_size = abs(given.vector()[i]), implied = rounding / epsilon / entry_size;
    if (at_zero && slope.judges && !slope.admits(given.vector()[i]) && isfinite(implied) &&
        implied > Scalar(0))
      if (const auto other = slope_within(implied, implied);
          other.admits(given.vector()[i]) && other.uncertainty <= entry_size / 1000)
        slope = other;
    at.vector()[i] = z.vector()[i];
    typename GradientCheck<Scalar>::Entry entry{
        .name = std::string(i < d ? "dH/dq[" : "dH/dp[") + std::to_string(i < d ? i : i - d) + "]",
        .given = given.vector()[i],
        .expected = slope.value,
        .uncertainty = slope.uncertainty,
        .judged = slope.judges,
        .wrong = false,
        .output = outputs[static_cast<std::size_t>(i)]};
    entry.wrong = !isfinite(entry.given) || (entry.judged && entry.clashes()) ||
                  entry.output != GradientOutput::written;
    check.entries.push_back(entry);
  }
  return check;
}

}  // namespace semiexplicit
