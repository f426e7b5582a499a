#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/vector.hpp>

namespace semiexplicit::detail {

/// How far each coordinate may go before a gradient changes much, as far as the state and its velocity tell:
/// as far as the coordinates are from the origin, or the momenta; the time, as long as that takes. Whatever
/// the units are, these lengths are in them. Of momenta at rest, but for rounding, or coordinates at
/// the origin: as far as they change H by as much as the others do; where nothing does, and of the time, as
/// far as the gradient follows in proportion. 1 where nothing is known.
template <class H>
class Lengths {
 public:
  using Scalar = typename H::Scalar;
  using Vec = typename PhasePoint<Scalar, H::Dof>::Storage;
  static constexpr int most_lengths = 56;
  static constexpr int most_calls = 2 + 5 * most_lengths;  ///< beside; of each half by two ways, of the time

  /// Whether a half of z tells no length: it is zero, or nothing beside the other in H, by the gradient
  /// there.
  bool guesses(const Vec& z, const Vec& gradient) {
    using std::sqrt;
    const Eigen::Index d = z.size() / 2, n = own_dof<H>(d);
    q_ = largest_absolute(z.head(n)), p_ = largest_absolute(z.segment(d, n));
    by_q_ = sqrt(q_) * sqrt(largest_absolute(gradient.head(n)));
    by_p_ = sqrt(p_) * sqrt(largest_absolute(gradient.segment(d, n)));
    q_guessed_ = !(q_ > Scalar(0));
    // Momenta are rounding only at an equilibrium. Positions of a free particle tell nothing either, but a
    // guess no more.
    p_guessed_ = !(p_ > Scalar(0)) || by_p_ < little() * by_q_;
    return q_guessed_ || p_guessed_;
  }

  /// `gradient` is that at z; `at` and `there` are memory to work in; `ranges`: what nothing tells is looked
  /// for by many gradients, else it is 1. Returns how many gradients it took.
  int take(const H& h, const Vec& z, const Vec& gradient, Vec& at, Vec& there, bool ranges = false) {
    const Eigen::Index d = z.size() / 2, n = own_dof<H>(d);
    int calls = 0;
    if (guesses(z, gradient)) {
      at = z;
      Scalar root(0);
      if (!p_guessed_) root = std::max(by_p_, beside(h, p_, d, at, there, calls));
      if (!q_guessed_) root = std::max(by_q_, beside(h, q_, 0, at, there, calls));
      const auto guess = [&](Eigen::Index begin) {
        const Scalar range = ranges ? linear_range(h, z, gradient, begin, n, at, there, calls) : Scalar(0);
        if (range > Scalar(0) || !(root > Scalar(0))) return range;
        return length_of_zeros(h, z, root, begin, at, there, calls);
      };
      if (q_guessed_) q_ = guess(0);
      if (p_guessed_) p_ = guess(d);
      at = z;
    }
    q_beyond_ = Scalar(0);
    if (ranges && !q_guessed_ && !p_guessed_ && by_q_ < little() * by_p_)
      at = z, q_beyond_ = length_of_zeros(h, z, by_p_, 0, at, there, calls);
    if constexpr (InExtendedPhaseSpace<H>) {
      using std::abs;
      const Scalar dq = largest_absolute(gradient.segment(d, n)), dp = largest_absolute(gradient.head(n));
      time_ = abs(gradient[2 * d - 1]) * smaller(dq > Scalar(0) ? Scalar(q_ / dq) : Scalar(0),
                                                 dp > Scalar(0) ? Scalar(p_ / dp) : Scalar(0));
      energy_ = std::max<Scalar>(p_ * dq, q_ * dp);
      if (ranges && !(time_ > Scalar(0)))
        at = z, time_ = linear_range(h, z, gradient, d - 1, 1, at, there, calls);
    }
    return calls;
  }

  /// That of one coordinate of 2d.
  Scalar of(Eigen::Index i, Eigen::Index d) const {
    const Scalar length = or_zero(i, d);
    return length > Scalar(0) ? length : Scalar(1);
  }
  /// Whether anything tells it.
  bool known(Eigen::Index i, Eigen::Index d) const { return or_zero(i, d) > Scalar(0); }

  /// Whether the half of that coordinate is at zero, or nothing beside the other in H, and its length a
  /// guess.
  bool guessed(Eigen::Index i, Eigen::Index d) const { return i < d ? q_guessed_ : p_guessed_; }

  /// How far shifts of it are worth a look: at least 1, and of positions that are near the origin by chance
  /// as far as they change H by as much as momenta do.
  Scalar beyond(Eigen::Index i, Eigen::Index d) const {
    if (guessed(i, d)) return Scalar(1);
    return std::max<Scalar>(std::max<Scalar>(of(i, d), 1), i < own_dof<H>(d) ? q_beyond_ : Scalar(0));
  }

  /// Whether its own size tells more, as where the others are in other units; not where it is nothing beside
  /// them, nor of the time.
  bool has_own(Eigen::Index i, const Vec& z) const {
    using std::abs;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Eigen::Index d = z.size() / 2;
    const bool is_time = InExtendedPhaseSpace<H> && i % d == d - 1;
    return !is_time && !guessed(i, d) && abs(z[i]) / epsilon > epsilon * of(i, d);
  }
  /// The same by that, where it does.
  Scalar own(Eigen::Index i, const Vec& z) const {
    using std::abs;
    return has_own(i, z) ? Scalar(abs(z[i])) : of(i, z.size() / 2);
  }

  /// The larger of the lengths of positions and momenta along v, where along() is the smaller one; 0 where
  /// neither is known.
  template <class Column>
  Scalar farthest_along(const Column& v) const {
    const Eigen::Index d = v.size() / 2, n = own_dof<H>(d);
    const Scalar q = largest_absolute(v.head(n)), p = largest_absolute(v.segment(d, n));
    return std::max<Scalar>(q > Scalar(0) ? Scalar(q_ / q) : Scalar(0),
                            p > Scalar(0) ? Scalar(p_ / p) : Scalar(0));
  }

  /// What v is to be multiplied by so that no coordinate goes farther.
  template <class Column>
  Scalar along(const Column& v) const {
    const Eigen::Index d = v.size() / 2, n = own_dof<H>(d);
    const auto part = [](const Scalar& length, const Scalar& moved) {
      return moved > Scalar(0) ? Scalar(length / moved) : Scalar(0);
    };
    Scalar length =
        smaller(part(q_, largest_absolute(v.head(n))), part(p_, largest_absolute(v.segment(d, n))));
    if constexpr (InExtendedPhaseSpace<H>) {
      using std::abs;
      length = smaller(length, smaller(part(time_, abs(v[d - 1])), part(energy_, abs(v[2 * d - 1]))));
    }
    if (length > Scalar(0)) return length;
    const Scalar largest = largest_absolute(v);
    return largest > Scalar(0) ? Scalar(1 / largest) : Scalar(1);
  }

 private:
  static constexpr int factor = 16;  ///< of each length to the one before

  /// Of the energies of both halves, as square roots: below that one is nothing beside the other.
  static Scalar little() {
    using std::sqrt;
    return sqrt(sqrt(Eigen::NumTraits<Scalar>::epsilon()));
  }

  /// That of one coordinate; 0: nothing is known.
  Scalar or_zero(Eigen::Index i, Eigen::Index d) const {
    if constexpr (InExtendedPhaseSpace<H>)
      if (i % d == d - 1) return i < d ? time_ : energy_;
    return i < d ? q_ : p_;
  }

  /// The square root of the energy of a half, whose largest entry that is, a sixteenth beside where it is: at
  /// an equilibrium there is none. 0 where that cannot be found.
  static Scalar beside(const H& h, const Scalar& largest, Eigen::Index begin, Vec& at, Vec& there,
                       int& calls) {
    using std::isfinite;
    using std::sqrt;
    const Eigen::Index d = at.size() / 2, n = own_dof<H>(d);
    at.segment(begin, n) *= Scalar(17) / Scalar(16);
    ++calls;
    Scalar root(0);
    try {
      gradient_at(h, at.data(), there.data(), d);
      root = sqrt(largest) * sqrt(largest_absolute(there.segment(begin, n)));
    } catch (const std::logic_error&) {
    }
    at.segment(begin, n) *= Scalar(16) / Scalar(17);
    return isfinite(root) ? root : Scalar(0);
  }

  /// Moves `count` entries of z from `begin` on, by different parts of a length, over lengths of all orders
  /// of magnitude from the smallest one on, while look(length, inside) of the gradient `there` says so; not
  /// inside, as beyond a wall, is the last one. Leaves `at` at z.
  template <class Look>
  static void along_lengths(const H& h, const Vec& z, Eigen::Index begin, Eigen::Index count, Vec& at,
                            Vec& there, int& calls, const Look& look) {
    const Eigen::Index d = at.size() / 2;
    Scalar length = Scalar(1e-36);
    for (int k = 0; k < most_lengths; ++k, length *= factor) {
      for (Eigen::Index i = 0; i < count; ++i)
        at[begin + i] = z[begin + i] + length * Scalar(i + 1) / Scalar(count);
      ++calls;
      bool inside = false;
      try {
        gradient_at(h, at.data(), there.data(), d);
        inside = all_finite(there);
      } catch (const std::logic_error&) {
      }
      if (!look(length, inside) || !inside) break;
    }
    at.segment(begin, count) = z.segment(begin, count);
  }

  /// How far a half of z from `begin` on, all zeros or next to nothing, is to be moved so that its share of H
  /// is about that energy, of which `root` is the square root (the energy itself may have no room in the
  /// exponent): the shortest such way, or that of the largest share where none is as large. 0: it has none.
  static Scalar length_of_zeros(const H& h, const Vec& z, const Scalar& root, Eigen::Index begin, Vec& at,
                                Vec& there, int& calls) {
    using std::log;
    using std::pow;
    using std::sqrt;
    const Eigen::Index d = at.size() / 2, n = own_dof<H>(d);
    Scalar found(0), largest(0), before(0);
    along_lengths(h, z, begin, n, at, there, calls, [&](const Scalar& length, bool inside) {
      if (!inside) return false;
      const Scalar here = sqrt(largest_absolute(there.segment(begin, n))) * sqrt(length);
      const bool reached = here >= root;
      if (reached)  // between this one and the one before, by the power of the length that they tell
        found = before > Scalar(0)
                    ? Scalar(length * pow(Scalar(factor), -log(here / root) / log(here / before)))
                    : length;
      else if (here > largest)
        found = length, largest = here;
      before = here;
      return !reached;
    });
    return found;
  }

  /// How far `count` entries of z from `begin` on may be moved while the gradient follows in proportion: the
  /// order of magnitude. There may be several such ranges: nearer to z rounding leaves out a part of what is
  /// within the gradient, about 1/ε times nearer, and it comes in all at once; farther away is what is
  /// around. 0: there is none.
  static Scalar linear_range(const H& h, const Vec& z, const Vec& gradient, Eigen::Index begin,
                             Eigen::Index count, Vec& at, Vec& there, int& calls) {
    using std::abs;
    using std::cbrt;
    using std::pow;
    using std::sqrt;
    const Eigen::Index d = at.size() / 2, n = own_dof<H>(d);
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), near = sqrt(cbrt(epsilon)),
                 far_apart = pow(epsilon, Scalar(-0.6));
    Scalar range(0), changed(0), changes[2] = {Scalar(0), Scalar(0)}, off[2] = {Scalar(0), Scalar(0)};
    int times[2] = {0, 0};
    bool at_once = false;
    along_lengths(h, z, begin, count, at, there, calls, [&](const Scalar& length, bool inside) {
      for (int half = 0; half < 2; ++half) {
        const Scalar before = changes[half], now = largest_absolute((there - gradient).segment(half * d, n)),
                     force = largest_absolute(gradient.segment(half * d, n)), least = sqrt(epsilon) * force,
                     off_before = std::exchange(off[half], Scalar(abs(now / (factor * before) - 1)));
        const bool follows = inside && before > Scalar(0) && off[half] < near,
                   ends = !follows && times[half] >= 3;
        if (ends && !(length < range * far_apart))
          range = length / factor, at_once = off_before < 16 * epsilon;
        times[half] = follows ? times[half] + 1 : 0;
        changes[half] = now > least ? now : Scalar(0);
        if (changed == Scalar(0) && force > Scalar(0) && !(2 * now < force)) changed = length;
      }
      return true;
    });
    return at_once || range == Scalar(0) ? changed : range;
  }

  /// Of two, where 0 says nothing.
  static Scalar smaller(const Scalar& a, const Scalar& b) {
    return a > Scalar(0) && (a < b || !(b > Scalar(0))) ? a : b;
  }

  Scalar q_ = Scalar(0), p_ = Scalar(0), time_ = Scalar(0), energy_ = Scalar(0);
  Scalar by_q_ = Scalar(0), by_p_ = Scalar(0);  ///< square roots of the energies of both halves
  Scalar q_beyond_ = Scalar(0);
  bool q_guessed_ = false, p_guessed_ = false;
};

/// Looks for the shift of a central difference of the gradient: of shifts over several orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. Memory: eleven vectors of length 2d.
template <class H>
class ShiftSearch {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  static constexpr int most_shifts = 48;
  static constexpr int by_own = 0, by_half = 1, countings = 2;  ///< what entries count in, see count_in()

  explicit ShiftSearch(Eigen::Index dof) : above_(dof), below_(dof) {
    for (Vec* one : {&here_, &middle_, &smaller_, &units_[by_own], &units_[by_half], &largest_, &seen_,
                     &off_at_, &agreed_})
      *one = above_.vector();
    for (Vec& units : units_) units.setOnes();
  }

  /// What a difference writes its two gradients to.
  Vec& above() { return above_.vector(); }
  Vec& below() { return below_.vector(); }
  /// The gradient where the differences are taken: to be written before a search.
  Vec& here() { return here_; }
  /// To be called at the point z of a search: a half of a column is a sum of entries times what the
  /// coordinates are counted in. That is how large each was at most, where they are in different units, and
  /// the length of its half, where one is small by chance: which of them it is nothing tells, and a shift has
  /// to be right by both.
  void count_in(const Lengths<H>& lengths, const Vec& z) {
    using std::abs;
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      if (lengths.has_own(i, z)) largest_[i] = std::max<Scalar>(largest_[i], abs(z[i]));
      units_[by_half][i] = lengths.of(i, z.size() / 2);
      units_[by_own][i] = largest_[i] > Scalar(0) ? largest_[i] : units_[by_half][i];
    }
  }
  /// What that remembers; see CheckpointMemory.
  Vec& largest() { return largest_; }
  /// The largest of them in the half of that coordinate.
  Scalar largest_of_half(Eigen::Index i) const {
    const Eigen::Index d = largest_.size() / 2, n = own_dof<H>(d), begin = i < d ? 0 : d;
    return i - begin < n ? largest_absolute(largest_.segment(begin, n)) : largest_[i];
  }

  /// What is known of a coordinate, or a direction, that a shift is looked for along.
  struct Along {
    Scalar length, farthest;  ///< over which the gradient varies, of what is moved and of its half
    Scalar own;               ///< the size of what is moved, which rounds it
    Scalar unit;              ///< shifts are looked for up to that, and to the length
    bool known = true;        ///< else the length is 1 because nothing is known
    bool time = false;        ///< whether it is the time alone
  };

  /// Of `count` shifts in geometric order from the larger one to the smaller one, that whose differences
  /// agree best with those of its two neighbours; see choose(). difference(shift, column) writes above(),
  /// below() and their difference by the shift; NaN and std::domain_error say that the shift is too large.
  template <class Difference>
  Scalar best(const Along& along, const Scalar& from, const Scalar& to, int count,
              const Difference& difference) {
    using std::abs;
    using std::log;
    using std::pow;
    const Scalar ratio = pow(to / from, Scalar(1) / Scalar(std::max(count - 1, 1)));
    // Below it differences that agree may do so because the gradient is rounded.
    const Scalar rounded = along.known ? Scalar(usual_part(along.length) / 64) : Scalar(0);
    HalfBy by_shift[countings][2][most_shifts];
    Scalar shift = from;
    int gap[2] = {0, 0};
    seen_.setZero(), off_at_.setZero(), agreed_.setZero();
    rows_ = along.time ? here_.size() / 2 : own_dof<H>(here_.size() / 2);
    for (int k = 0; k < count; ++k, shift *= ratio) {
      try {
        difference(shift, smaller_);
      } catch (const std::domain_error&) {
        smaller_.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
      }
      for (Eigen::Index j = 0; j < smaller_.size(); ++j)
        seen_[j] = std::max<Scalar>(seen_[j], abs(smaller_[j]));  // NaN sees nothing
      if (k > 0)
        for (int half = 0; half < 2; ++half) {
          for (int counting = 0; counting < countings; ++counting)
            by_shift[counting][half][k] = compare(units_[counting], half, shift);
          if (shift > rounded) gap[half] = std::max(gap[half], last_gap_of_entries(half, k));
        }
      middle_ = smaller_;
    }
    for (auto& counting : by_shift)
      for (auto& half : counting) count_rounding(half, count, from, ratio);
    for (int half = 0; half < 2; ++half) {
      const int last = std::max(gap[half], last_gap(by_shift[by_own][half], count, from, ratio, rounded));
      for (auto& counting : by_shift)
        for (int k = 1; k <= last; ++k) counting[half][k] = {};
    }
    bool shortest = false;
    for (const auto& half : by_shift[by_half]) shortest = shortest || vanishes(half, count);
    Scalar apart[most_shifts], alike[most_shifts];
    score(by_shift, count, {along.length, along.farthest}, apart, alike);
    for (int k = 1; k < count - 1; ++k)  // with both neighbours
      apart[k] = std::max(apart[k], apart[k + 1]), alike[k] = std::max(alike[k], alike[k + 1]);
    return from *
           pow(ratio, Scalar(choose(apart, alike, count, log(from / along.farthest), log(ratio), shortest)));
  }

  /// The same over all shifts that may be right: from the length, or the unit, to the rounding of what is
  /// moved, or nothing.
  template <class Difference>
  Scalar best_of_all(const Along& along, const Difference& difference) {
    using std::ceil;
    using std::log;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar from = std::max<Scalar>(along.length, along.unit) / 2;
    const Scalar least = std::max(Scalar(16 * epsilon * along.own),
                                  Scalar(epsilon * std::min<Scalar>(along.length, along.unit)));
    const Scalar count = ceil(log(from / least) / log(Scalar(8)));  // below 3 or NaN at the ends of the range
    const int shifts = count >= Scalar(most_shifts) ? most_shifts
                       : count > Scalar(3)          ? static_cast<int>(count)
                                                    : 3;
    return best(along, from, least, shifts, difference);
  }

  /// A shift that was right a while ago, looked at again.
  template <class Difference>
  Scalar best_near(const Along& along, const Scalar& shift, const Difference& difference) {
    const Scalar from = 512 * shift, to = shift / 512;
    const Scalar found = best(along, from, to, 7, difference);
    return found > from / 16 || found < to * 16 ? best_of_all(along, difference) : found;
  }

  /// No more than eight times what was right a while ago, or than the usual part of the length: where a
  /// second derivative passes through zero, shifts that are far too large may agree better.
  static Scalar bounded(const Scalar& found, const Scalar& before, const Scalar& length) {
    return std::min(found, std::max<Scalar>(8 * before, usual_part(length)));
  }

  /// The shift at which rounding and curvature spoil a difference alike, where the gradient varies along the
  /// length.
  static Scalar usual_part(const Scalar& length) {
    using std::cbrt;
    return length * cbrt(Eigen::NumTraits<Scalar>::epsilon());
  }

  /// Whether any difference of the last search was not zero.
  bool saw() const { return saw_; }

 private:
  /// The number of a shift that agrees with its neighbours as well as is enough, or nearly best where none
  /// does so: of these one that all halves agree with, whatever they count; of these, as where the gradient
  /// is linear or even, that nearest to the usual part of the length, or the `shortest`, with which half a
  /// column vanishes. Shifts within the length come first where they will do: far out a polynomial may be all
  /// there is, of which no shift is too large. `from` and `ratio` are logarithms of the first shift by that
  /// length, and of a shift by the next larger one.
  static int choose(const Scalar* apart, const Scalar* alike, int count, const Scalar& from,
                    const Scalar& ratio, bool shortest) {
    using std::abs;
    using std::log;
    const Scalar enough = log(32 * usual_part(usual_part(Scalar(1)))), usual = log(usual_part(Scalar(1)));
    const auto by_length = [&](int k) { return Scalar(from + Scalar(k) * ratio); };
    int near = 1, begin = 1;
    while (near < count - 1 && by_length(near) > Scalar(0)) ++near;
    for (int k = near; k < count - 1 && begin == 1; ++k)
      if (std::max(apart[k], alike[k]) <= enough + log(Scalar(8))) begin = near;
    const auto nearly_least = [&](const Scalar* measure, const auto& counts) {
      Scalar least(0);
      for (int k = begin; k < count - 1; ++k)
        if (counts(k)) least = std::min(least, measure[k]);
      return std::max<Scalar>(enough, least + log(Scalar(2)));
    };
    const Scalar most = nearly_least(apart, [](int) { return true; }),
                 most_alike = nearly_least(alike, [&](int k) { return apart[k] <= most; });
    int result = count / 2;
    Scalar nearest(-1);
    for (int k = begin; k < count - 1; ++k) {
      const Scalar distance = shortest ? Scalar(count - k) : abs(by_length(k) - usual);
      if (!(apart[k] <= most && alike[k] <= most_alike)) continue;
      if (nearest < Scalar(0) || distance < nearest) nearest = distance, result = k;
    }
    return result;
  }

  /// Half a column by a shift and by the next larger one: the size of the larger, and how far they are from
  /// each other relative to it, no less than what the rounding of the gradient may make of it.
  struct HalfBy {
    Scalar size = Scalar(0), apart = Scalar(1);
    Scalar bend = Scalar(0);  ///< the second difference of the gradient by the shift
  };
  /// In sums of entries, as a coupling far weaker than the forces would ask for shifts too large for these.
  HalfBy compare(const Vec& units, int half, const Scalar& shift) const {
    using std::abs;
    using std::isfinite;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Eigen::Index d = middle_.size() / 2;
    Scalar apart(0), size(0), bend(0);
    for (Eigen::Index j = half * d; j < half * d + rows_; ++j) {
      const Scalar value = std::max<Scalar>(abs(above_.vector()[j]), abs(below_.vector()[j]));
      const Scalar rounding = seen_[j] == Scalar(0) ? Scalar(0) : Scalar(epsilon * value / shift);
      apart += units[j] * (abs(middle_[j] - smaller_[j]) + rounding);
      size += units[j] * std::max<Scalar>(abs(middle_[j]), abs(smaller_[j]));
      bend += units[j] * abs((above_.vector()[j] - here_[j]) + (below_.vector()[j] - here_[j]));
    }
    if (!isfinite(size) || !isfinite(apart) || size == Scalar(0)) return {};
    return {size, apart / size, bend};
  }

  /// Whether half a column is zero although no difference is, as of q³ at q = 0: the shorter the less.
  static bool vanishes(const HalfBy (&half)[most_shifts], int count) {
    constexpr int enough = 5;
    int in_order = 0;
    for (int k = count - 1; k > 1 && in_order < enough; --k) {
      if (!(16 * half[k].size <= half[k - 1].size)) return false;
      if (half[k].size > Scalar(0)) ++in_order;
    }
    return in_order == enough;
  }

  /// What terms that cancel are rounded by, as at a minimum, the gradient itself does not tell. Second
  /// differences by short shifts do: they are that rounding, from the shortest shift on to where they begin
  /// to grow with the square. Some of them may vanish by chance, so that a shift has the rounding of others
  /// up to ε^{-1/3} times as long: of a linear gradient no more than ε^{2/3}.
  static void count_rounding(HalfBy (&half)[most_shifts], int count, const Scalar& from,
                             const Scalar& ratio) {
    using std::log;
    using std::pow;
    const Scalar square = 1 / (ratio * ratio);  // what a second difference grows by, from shift to shift
    const int longer = static_cast<int>(log(usual_part(Scalar(1))) / log(ratio));
    // Of a float there are too few shifts to tell rounding from curvature.
    if (Eigen::NumTraits<Scalar>::epsilon() > Scalar(1e-12)) return;
    const auto grows = [&](const Scalar& here, const Scalar& there) {
      return there > 4 * here && there < 6 * square * here;
    };
    int first = count - 1;  // of the shifts that tell it
    for (Scalar largest(0); first > 2; --first) {
      largest = std::max(largest, half[first].bend);
      const Scalar next = half[first - 1].bend, farther = half[first - 2].bend;
      if (grows(largest, next) && grows(next, farther) && farther > 3 * square * largest) break;
    }
    if (first <= 2) first = 1;
    for (int k = count - 1; k >= 1; --k) {
      Scalar rounding(0);
      for (int j = std::max(first, k - longer); j < count; ++j) rounding = std::max(rounding, half[j].bend);
      if (half[k].size > Scalar(0)) half[k].apart += rounding / (half[k].size * from * pow(ratio, Scalar(k)));
    }
  }

  /// The last shift, of those so far, at which an entry of a column was another than by three smaller ones,
  /// which agree: that and larger ones have stepped over something; see last_gap(). 0: there is none.
  int last_gap_of_entries(int half, int k) {
    using std::abs;
    const Eigen::Index d = middle_.size() / 2;
    int last = 0;
    for (Eigen::Index j = half * d; j < half * d + rows_; ++j) {
      const Scalar off = abs(middle_[j] - smaller_[j]),
                   size = std::max<Scalar>(abs(middle_[j]), abs(smaller_[j]));
      agreed_[j] = size > Scalar(0) && off < Scalar(1e-2) * size ? agreed_[j] + 1 : Scalar(0);
      if (!(off < Scalar(0.3) * size)) off_at_[j] = Scalar(k);
      if (agreed_[j] == Scalar(2)) last = std::max(last, static_cast<int>(off_at_[j]));
    }
    return last;
  }

  /// Where differences agree over small shifts, disagree over larger ones and agree once more over larger
  /// ones still, these have stepped over something, as a narrow wall, and see what is around it. They begin
  /// to disagree with the square of the shift, 64 times as much from one to the next. Where it comes at once,
  /// or below `least`, the gradient is rounded, to floats say, and it is the small ones that see nothing. The
  /// last of those larger ones; 0: there is none.
  static int last_gap(const HalfBy (&half)[most_shifts], int count, const Scalar& from, const Scalar& ratio,
                      const Scalar& least) {
    using std::pow;
    const Scalar third = usual_part(Scalar(1));
    const auto both = [&](int k) { return std::max(half[k].apart, half[k + 1].apart); };
    Scalar best(1), last(1);
    for (int k = count - 2; k >= 1; --k) {
      const Scalar before = std::exchange(last, both(k));
      best = std::min(best, last);
      const Scalar times = last / std::max(best, Scalar(third * third));
      if (!(best < Scalar(1e-3) && times > 100)) continue;
      Scalar farther(1);
      for (int j = 1; j < k; ++j) farther = std::min(farther, both(j));
      const bool at_once = times > Scalar(1e4) || (last > 1000 * before && 16 * farther < best);
      return at_once || from * pow(ratio, Scalar(k)) < least ? 0 : k;
    }
    return 0;
  }

  /// How far the columns by each shift and by the next larger one are from each other: the logarithm of the
  /// mean over both halves (the mean of logarithms would give up one half for digits of the other). A half
  /// counts by how much it moves its half of the gradient over the length, at most all of it, as it is where
  /// it is seen best: by shifts that are too large it may have vanished, and then it disagrees. At most 0.
  /// `alike` is the same where all count in full: it decides among shifts that will do.
  void score(const HalfBy (&by_shift)[countings][2][most_shifts], int count,
             const Scalar (&lengths)[countings], Scalar* apart, Scalar* alike) {
    using std::log;
    // What is better than ε^{2/3} does not count: a half that is constant would ask for shifts too large for
    // the other.
    const Scalar least = usual_part(usual_part(Scalar(1)));
    const Eigen::Index d = here_.size() / 2;
    std::fill(apart, apart + count, Scalar(0));
    std::fill(alike, alike + count, Scalar(0));
    Scalar weights(0);
    int halves = 0;
    for (int counting = 0; counting < countings; ++counting)
      for (int half = 0; half < 2; ++half) {
        const HalfBy* by = by_shift[counting][half];
        Scalar seen(0);
        for (int k = 1; k < count; ++k)
          if (by[k].apart < Scalar(0.5)) seen = std::max(seen, by[k].size);
        if (!(seen > Scalar(0))) continue;
        const Scalar force = here_.segment(half * d, d).cwiseAbs().dot(units_[counting].segment(half * d, d));
        const Scalar moved = lengths[counting] * seen,
                     weight = force < moved ? Scalar(1) : Scalar(moved / force);
        for (int k = 1; k < count; ++k) {
          const Scalar here = std::clamp<Scalar>(by[k].apart, least, Scalar(1));
          apart[k] += weight * here, alike[k] += here;
        }
        weights += weight, ++halves;
      }
    saw_ = weights > Scalar(0);
    for (int k = 1; k < count && saw_; ++k)
      apart[k] = log(Scalar(apart[k] / weights)), alike[k] = log(Scalar(alike[k] / Scalar(halves)));
  }

  State above_, below_;
  Vec here_, middle_, smaller_, units_[countings], largest_, seen_, off_at_, agreed_;
  Eigen::Index rows_ = 0;  ///< of a half that count; ∂H/∂t tells the shift of the time alone
  bool saw_ = false;
};

}  // namespace semiexplicit::detail
