#pragma once

#include <cstddef>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/derivatives/term_number.hpp>

namespace semiexplicit::detail::autodiff {

/// Half a phase point in the memory of the caller; with the half of a direction, numbers that move along it.
template <class T>
struct HalfPoint {
  const T* values;
  T operator[](Eigen::Index i) const { return values[i]; }
  SEMIEXPLICIT_INTO_TERM LanePack<T> load(Eigen::Index i) const { return LanePack<T>::load(values + i); }
};
template <class T>
struct HalfPoint<Dual<T, 1>> {
  const T *values, *direction;
  Dual<T, 1> operator[](Eigen::Index i) const {
    Dual<T, 1> x(values[i]);
    x.derivative[0] = direction[i];
    return x;
  }
  SEMIEXPLICIT_INTO_TERM Dual<LanePack<T>, 1> load(Eigen::Index i) const {
    Dual<LanePack<T>, 1> x(LanePack<T>::load(values + i));
    x.derivative[0] = LanePack<T>::load(direction + i);
    return x;
  }
};

/// Makes the variables of one half, number `first` and on, where they are read.
template <class T>
struct ReadTraced {
  Tape<T>* tape;
  HalfPoint<T> at;
  Eigen::Index first;
  Traced<T> operator()(Eigen::Index i) const { return tape->variable(at[i], first + i); }
};

template <class T, int Rows>
using TracedColumn = Eigen::CwiseNullaryOp<ReadTraced<T>, const Eigen::Matrix<Traced<T>, Rows, 1>>;

/// What an energy gets for q (half 0) and p (half 1): a column of traced numbers to Eigen, and to a term in
/// lanes its own.
template <class T, int Rows, int half>
class EnergyColumn : public TracedColumn<T, Rows> {
 public:
  EnergyColumn(Tape<T>* tape, HalfPoint<T> at, Eigen::Index size)
      : TracedColumn<T, Rows>(size, 1, {tape, at, half * size}), at_(at) {}

  using TracedColumn<T, Rows>::operator[];
  using TracedColumn<T, Rows>::operator();
  template <class S>
  SEMIEXPLICIT_INTO_TERM auto operator[](const LaneIndex<S>& i) const {
    return in_lanes(i);
  }
  template <class S>
  SEMIEXPLICIT_INTO_TERM auto operator()(const LaneIndex<S>& i) const {
    return in_lanes(i);
  }

 private:
  template <class S>
  SEMIEXPLICIT_INTO_TERM auto in_lanes(const LaneIndex<S>& i) const {
    using L = typename LanesFor<T>::type;
    const int slot = i.slot(half);
    const Place place = i.place();
    const bool expected = i.touched->touch(slot, place, this->size());
    TermNumber<L> x(load(place, i.last(), expected));
    x.active = 1u << slot;
    TermNumber<L>::each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if (k == slot) x.derivative[k] = L(1);
    });
    return x;
  }
  /// Beyond the column there is nothing: the term alone then reads what it asks for. An expected place is
  /// known to be inside.
  SEMIEXPLICIT_INTO_TERM typename LanesFor<T>::type load(const Place& place, Eigen::Index last,
                                                         bool expected) const {
    if (place.stride == 1 && place.wrap == 0 && (expected || (place.first >= 0 && last < this->size())))
      return at_.load(place.first);
    if (place.stride == 0 && (expected || (place.first >= 0 && place.first < this->size())))
      return same(at_[place.first]);
    return gathered(place);
  }
  template <class S>
  static SEMIEXPLICIT_INTO_TERM LanePack<S> same(const S& x) {
    return x;
  }
  template <class S>
  static SEMIEXPLICIT_INTO_TERM Dual<LanePack<S>, 1> same(const Dual<S, 1>& x) {
    Dual<LanePack<S>, 1> all(LanePack<S>(x.value));
    all.derivative[0] = LanePack<S>(x.derivative[0]);
    return all;
  }
  /// Entries apart from each other, or some of them beyond the column.
  SEMIEXPLICIT_NOINLINE auto gathered(Place place) const {
    using L = typename LanesFor<T>::type;
    constexpr Eigen::Index size = lanes_of<typename Planes<T>::Plain>;
    typename Planes<T>::Plain values[std::size_t(size * Planes<T>::planes)] = {};
    for (Eigen::Index k = 0; k < size; ++k) {
      const Eigen::Index i = place.of_lane_or_first(k, this->size());
      if (i >= 0 && i < this->size()) put(at_[i], values + k);
    }
    L x;
    take(values, x);
    return x;
  }
  template <class S>
  static void put(const S& x, S* to) {
    *to = x;
  }
  template <class S>
  static void put(const Dual<S, 1>& x, S* to) {
    to[0] = x.value;
    to[lanes_of<S>] = x.derivative[0];
  }
  template <class S>
  static void take(const S* from, LanePack<S>& x) {
    x = LanePack<S>::load(from);
  }
  template <class S>
  static void take(const S* from, Dual<LanePack<S>, 1>& x) {
    x.value = LanePack<S>::load(from);
    x.derivative[0] = LanePack<S>::load(from + lanes_of<S>);
  }

  HalfPoint<T> at_;
};

}  // namespace semiexplicit::detail::autodiff
