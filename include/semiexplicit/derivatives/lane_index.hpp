#pragma once

#include <algorithm>
#include <concepts>
#include <cstddef>
#include <limits>

#include <Eigen/Core>

#include <semiexplicit/derivatives/lane_pack.hpp>

namespace semiexplicit::detail::autodiff {

/// Entries of q or p, one a lane: the first lane's, the distance from lane to lane, and where counting starts
/// again at 0 (0: nowhere).
struct Place {
  Eigen::Index first, stride, wrap;

  SEMIEXPLICIT_INTO_TERM Eigen::Index of_lane(Eigen::Index k) const {
    return wrap == 0 ? first + stride * k : (first + stride * k) % wrap;
  }
  /// Beyond a column of that size the first lane's, with which a term comes to an end: its branches follow
  /// the first lane. The terms are taken one by one then.
  SEMIEXPLICIT_INTO_TERM Eigen::Index of_lane_or_first(Eigen::Index k, Eigen::Index size) const {
    const Eigen::Index i = of_lane(k);
    if (i >= 0 && i < size) return i;
    lanes_part() = true;
    return of_lane(0);
  }
  /// How many lanes there could be in a column of that size; where counting starts again none is sure.
  SEMIEXPLICIT_INTO_TERM Eigen::Index reach(Eigen::Index size) const {
    if (wrap != 0) return 0;
    if (stride > 0) return (size - 1 - first) / stride + 1;
    if (stride < 0) return first / -stride + 1;
    return std::numeric_limits<Eigen::Index>::max();
  }
};

/// Which variables the terms in the lanes have touched: each has a slot among `slots` derivatives, found from
/// the half it is in and from its distance to the terms' number, so that the compiler knows it.
struct TouchedPlaces {
  static constexpr int slots = 16;
  Eigen::Index term;      // the first lane's
  bool expected = false;  // what is used has been found with earlier terms
  unsigned used = 0;
  /// For so many terms the places next to these are inside of their columns.
  Eigen::Index reach = std::numeric_limits<Eigen::Index>::max();
  // Not as places: to copy one of those two stores at a time stalls. The first lane's is told relative to the
  // terms' number, which makes it a constant.
  Eigen::Index offset[slots] = {}, stride[slots] = {}, wrap[slots] = {};

  explicit TouchedPlaces(Eigen::Index first_term) : term(first_term) {}

  /// Whether this place, in a column of that size, has been expected.
  SEMIEXPLICIT_INTO_TERM bool touch(int slot, const Place& at, Eigen::Index size) {
    const Eigen::Index from_term = at.first - at.stride * term;
    if (!expected) reach = std::min(reach, at.reach(size));
    if ((used >> slot & 1u) == 0) {
      put(slot, from_term, at.stride, at.wrap);
      used |= 1u << slot;
      return false;
    }
    if (offset[slot] == from_term && stride[slot] == at.stride && wrap[slot] == at.wrap) return expected;
    lanes_part() = true;  // two variables, one slot
    return false;
  }
  SEMIEXPLICIT_INTO_TERM void put(int slot, Eigen::Index from_term, Eigen::Index distance,
                                  Eigen::Index around) {
    offset[slot] = from_term;
    stride[slot] = distance;
    wrap[slot] = around;
  }
  SEMIEXPLICIT_INTO_TERM Place place(int slot) const {
    return {offset[slot] + stride[slot] * term, stride[slot], wrap[slot]};
  }
};

/// The numbers of some neighbouring terms, one a lane, for what a term does with its index: i + 1, 3 * i + 2,
/// (i + 1) % n. With stride 0 it is the same number in all lanes, as the second of a pair. It is an integer,
/// too: the first lane's.
template <class S>
struct LaneIndex {
  static constexpr Eigen::Index size = lanes_of<S>;
  TouchedPlaces* touched;
  Eigen::Index base, offset;  // their sum is the first lane's number; the offset is what the compiler knows
  Eigen::Index stride, wrap;
  Eigen::Index window;  // offsets that differ by less have slots of their own

  SEMIEXPLICIT_INTO_TERM Eigen::Index first() const { return base + offset; }
  SEMIEXPLICIT_INTO_TERM Eigen::Index last() const { return first() + stride * (size - 1); }
  SEMIEXPLICIT_INTO_TERM Place place() const { return {first(), stride, wrap}; }
  /// Of 2 · window slots, for offsets in either half; numbers that are the same in all lanes have the upper
  /// half of a window.
  SEMIEXPLICIT_INTO_TERM int slot(int half) const {
    const Eigen::Index within = (stride == 0 ? 4 : 0) + (offset & (window - 1));
    return static_cast<int>((half * 8 + within) & (TouchedPlaces::slots - 1));  // beyond: multiplied by 0
  }
  SEMIEXPLICIT_INTO_TERM operator Eigen::Index() const {  // NOLINT
    if (stride != 0) lanes_part() = true;
    return first();
  }

  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator+(LaneIndex i, I n) {
    return i.moved(static_cast<Eigen::Index>(n), __builtin_constant_p(n));
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator+(I n, LaneIndex i) {
    return i.moved(static_cast<Eigen::Index>(n), __builtin_constant_p(n));
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator-(LaneIndex i, I n) {
    return i.moved(-static_cast<Eigen::Index>(n), __builtin_constant_p(n));
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator*(LaneIndex i, I n) {
    const auto factor = static_cast<Eigen::Index>(n);
    if (i.wrap != 0 || factor == 0) lanes_part() = true;
    i.base *= factor;
    i.offset *= factor;
    i.stride *= factor;
    return i;
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator*(I n, LaneIndex i) {
    return i * n;
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM LaneIndex operator%(LaneIndex i, I n) {
    const auto count = static_cast<Eigen::Index>(n);
    if (i.wrap != 0 || i.stride < 0 || i.first() < 0) lanes_part() = true;
    if (i.first() >= count || i.first() < 0) i.base += i.first() % count - i.first();
    if (i.last() >= count) i.wrap = count;
    return i;
  }
#define SEMIEXPLICIT_WITH_NUMBERS(op)                                                     \
  template <std::floating_point F>                                                        \
  friend SEMIEXPLICIT_INTO_TERM LanePack<S> operator op(const LaneIndex& i, const F& x) { \
    return LanePack<S>(i) op x;                                                           \
  }                                                                                       \
  template <std::floating_point F>                                                        \
  friend SEMIEXPLICIT_INTO_TERM LanePack<S> operator op(const F& x, const LaneIndex& i) { \
    return x op LanePack<S>(i);                                                           \
  }
  SEMIEXPLICIT_WITH_NUMBERS(+)
  SEMIEXPLICIT_WITH_NUMBERS(-)
  SEMIEXPLICIT_WITH_NUMBERS(*)
  SEMIEXPLICIT_WITH_NUMBERS(/)
#undef SEMIEXPLICIT_WITH_NUMBERS
  SEMIEXPLICIT_INTO_TERM LaneIndex& operator++() { return *this = *this + 1; }
  SEMIEXPLICIT_INTO_TERM LaneIndex& operator--() { return *this = *this - 1; }
  template <std::integral I>
  SEMIEXPLICIT_INTO_TERM LaneIndex& operator+=(I n) {
    return *this = *this + n;
  }
  template <std::integral I>
  SEMIEXPLICIT_INTO_TERM LaneIndex& operator-=(I n) {
    return *this = *this - n;
  }

  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator==(const LaneIndex& i, I n) {
    const auto number = static_cast<Eigen::Index>(n);
    const bool before = number < i.first() && number < i.last();
    const bool behind = number > i.first() && number > i.last();
    if (i.stride != 0 && (i.wrap != 0 || !(before || behind))) lanes_part() = true;
    return i.first() == number;
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator<(const LaneIndex& i, I n) {
    return i.ordered([number = static_cast<Eigen::Index>(n)](Eigen::Index k) { return k < number; });
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator>(const LaneIndex& i, I n) {
    return i.ordered([number = static_cast<Eigen::Index>(n)](Eigen::Index k) { return k > number; });
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator<=(const LaneIndex& i, I n) {
    return !(i > n);
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator>=(const LaneIndex& i, I n) {
    return !(i < n);
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator<(I n, const LaneIndex& i) {
    return i > n;
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator>(I n, const LaneIndex& i) {
    return i < n;
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator<=(I n, const LaneIndex& i) {
    return !(i < n);
  }
  template <std::integral I>
  friend SEMIEXPLICIT_INTO_TERM bool operator>=(I n, const LaneIndex& i) {
    return !(i > n);
  }

 private:
  /// Moved by n. What the compiler does not know, as in q[i + k], goes to the other half of the window.
  SEMIEXPLICIT_INTO_TERM LaneIndex moved(Eigen::Index n, bool known) const {
    LaneIndex to = *this;
    if (wrap != 0) lanes_part() = true;
    if (known) {
      to.offset += n;
    } else {
      to.offset += window / 2;
      to.base += n - window / 2;
    }
    return to;
  }
  template <class Compare>
  SEMIEXPLICIT_INTO_TERM bool ordered(const Compare& compare) const {
    if (wrap != 0 || compare(first()) != compare(last())) lanes_part() = true;
    return compare(first());
  }
};

}  // namespace semiexplicit::detail::autodiff
