#pragma once

#include <algorithm>
#include <bit>
#include <concepts>
#include <cstddef>
#include <iterator>
#include <limits>
#include <type_traits>
#include <utility>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/derivatives/term_number.hpp>

namespace semiexplicit {
namespace detail::autodiff {

/// Whether several terms are being evaluated in lanes, in this thread: a sum inside of a term is left to
/// that.
inline bool& inside_term() {
  thread_local constinit bool inside = false;
  return inside;
}
struct InsideTerm {
  InsideTerm() { inside_term() = true; }
  ~InsideTerm() { inside_term() = false; }
};

/// The gradient of a sum, collected from terms that are evaluated as many at a time as a register has lanes.
template <class T>
class LaneSum {
 public:
  using Plain = typename Planes<T>::Plain;
  using L = typename LanesFor<T>::type;
  using Index = LaneIndex<Plain>;
  static constexpr Eigen::Index lanes = Index::size;

  explicit LaneSum(Tape<T>& tape) : tape_(tape), sum_(tape.new_sum()) {}

  /// Adds term(i) from i = `first` on, as many at a time as there are lanes, as long as they read the
  /// variables next to the ones before, and not beyond n - 1. Returns how far it got: not at all where they
  /// have to be evaluated one by one.
  template <class Term>
  SEMIEXPLICIT_NOINLINE SEMIEXPLICIT_FLATTEN Eigen::Index add(const Term& term, Eigen::Index first,
                                                              Eigen::Index n) {
    const std::size_t length = tape_.length();
    const InsideTerm inside;
    lanes_part() = false;
    // At first only for the places, all else the compiler leaves out. What it finds constant of them needs no
    // check in the loop.
    const Eigen::Index begin = whole(first, n);
    TouchedPlaces places(begin);
    const unsigned active = term(&places, begin).active;
    const Eigen::Index most = std::clamp(places.reach, lanes, block);
    Eigen::Index next = first;
    for (; next < n && !lanes_part(); next += lanes) {
      const Eigen::Index now = whole(next, n), at = now - begin;
      if (at + lanes > most) break;
      TouchedPlaces touched(now);
      touched.expected = true;
      touched.used = places.used;
      each_of(places.used, [&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
        touched.put(k, places.offset[k], places.stride[k], places.wrap[k]);
      });
      const TermNumber<L> result = term(&touched, now);
      if (lanes_part() || touched.used != places.used || result.active != active) break;
      each_of(active,
              [&](auto k) SEMIEXPLICIT_INLINE_LAMBDA { store(result.derivative[k], derivatives_[k] + at); });
    }
    if (lanes_part()) tape_.rewind(length);
    if (next == first) return first;
    terms_ = std::min(next, n) - begin;
    active_ = active;
    each_of(active, [&](auto k) SEMIEXPLICIT_INLINE_LAMBDA { places_[k] = places.place(k); });
    if (begin < first) forget(first - begin);
    flush();
    return next;
  }
  /// The values of term(i) for the lanes from `first` on.
  template <class Term>
  SEMIEXPLICIT_NOINLINE SEMIEXPLICIT_FLATTEN T value(const Term& term, Eigen::Index first, Eigen::Index n) {
    const InsideTerm inside;
    const Eigen::Index begin = whole(first, n);
    TouchedPlaces touched(begin);
    const TermNumber<L> result = term(&touched, begin);
    Plain values[std::size_t(Planes<T>::planes * block)];
    store(result.value, values);
    T sum(0);
    for (Eigen::Index k = first - begin; k < lanes; ++k) sum += Planes<T>::join(values + k, block);
    return sum;
  }
  Traced<T> finished(const T& value) { return tape_.finished(sum_, value); }

 private:
  static constexpr int slots = TouchedPlaces::slots;
  static constexpr Eigen::Index block = 32 * lanes;  // terms to collect

  static SEMIEXPLICIT_INTO_TERM void store(const LanePack<Plain>& x, Plain* to) { x.store(to); }
  static SEMIEXPLICIT_INTO_TERM void store(const Dual<LanePack<Plain>, 1>& x, Plain* to) {
    x.value.store(to);
    x.derivative[0].store(to + block);
  }

  /// Where the lanes for the terms from `first` on begin: the last ones go together with some before them.
  static Eigen::Index whole(Eigen::Index first, Eigen::Index n) {
    return first + lanes <= n ? first : n - lanes;
  }
  /// f(std::integral_constant<int, slot>) for these slots.
  template <class F>
  static SEMIEXPLICIT_INTO_TERM void each_of(unsigned these, const F& f) {
    TermNumber<L>::each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if ((these >> k & 1u) != 0) f(k);
    });
  }
  /// Of the terms collected the first ones.
  SEMIEXPLICIT_NOINLINE void forget(Eigen::Index count) {
    for (unsigned left = active_; left != 0; left &= left - 1)
      for (Eigen::Index plane = 0; plane < Planes<T>::planes; ++plane)
        for (Eigen::Index i = 0; i < count; ++i)
          derivatives_[std::countr_zero(left)][plane * block + i] = Plain(0);
  }

  /// Adds what has been collected to the gradient.
  SEMIEXPLICIT_NOINLINE void flush() {
    for (unsigned left = active_; left != 0; left &= left - 1) {
      const int k = std::countr_zero(left);
      for (Eigen::Index plane = 0; plane < Planes<T>::planes; ++plane)
        add_to(tape_.gradient_of(sum_, plane, k >= slots / 2 ? 1 : 0), tape_.weight_of(sum_), places_[k],
               derivatives_[k] + plane * block, terms_);
    }
  }
  static void add_to(Plain* __restrict to, Plain weight, const Place& place, const Plain* __restrict from,
                     Eigen::Index count) {
    using Pack = LanePack<Plain>;
    Eigen::Index i = 0;
    if (place.wrap != 0) {
      for (; i < count; ++i) to[place.of_lane(i)] += weight * from[i];
    } else if (place.stride == 1) {
      to += place.first;
      for (; i + lanes <= count; i += lanes)
        (Pack::load(to + i) + weight * Pack::load(from + i)).store(to + i);
      for (; i < count; ++i) to[i] += weight * from[i];
    } else if (place.stride == 0) {
      Pack sum(0);
      for (; i + lanes <= count; i += lanes) sum += Pack::load(from + i);
      for (int k = 0; k < lanes; ++k) to[place.first] += weight * sum.lanes[k];
      for (; i < count; ++i) to[place.first] += weight * from[i];
    } else {
      for (; i < count; ++i) to[place.first + place.stride * i] += weight * from[i];
    }
  }

  Tape<T>& tape_;
  std::size_t sum_;
  Eigen::Index terms_ = 0;
  unsigned active_ = 0;
  Place places_[slots];
  alignas(64) Plain derivatives_[slots][std::size_t(Planes<T>::planes * block)];
};

/// Σ at(i), i from 0 to n - 1, by lanes(touched, i) wherever they agree.
template <class T>
class TracedSum {
 public:
  explicit TracedSum(Tape<T>& tape) : tape_(tape), lanes_(tape) {}

  template <class InLanes, class Single>
  SEMIEXPLICIT_INTO_TERM void add(Eigen::Index n, const InLanes& in_lanes, const Single& single) {
    constexpr Eigen::Index size = LaneSum<T>::lanes;
    for (Eigen::Index i = 0; i < n;) {
      const bool together = n >= size && failures_ <= 2 + successes_;
      Eigen::Index end = together ? lanes_.add(in_lanes, i, n) : i;
      if (end > i) {
        successes_ += (end - i) / size;
        if (tape_.values)
          for (; i < end; i += size) value_ += lanes_.value(in_lanes, i, n);
        i = end;
      } else {
        if (n >= size) ++failures_;
        for (end = std::min(i + size, n); i < end; ++i) others_ += single(i);
      }
    }
  }
  Traced<T> finished() {
    if (successes_ == 0) return others_;
    const T unknown(std::numeric_limits<typename LaneSum<T>::Plain>::quiet_NaN());
    return lanes_.finished(tape_.values ? value_ : unknown) + others_;
  }

 private:
  Tape<T>& tape_;
  LaneSum<T> lanes_;
  Traced<T> others_;
  T value_ = T(0);
  Eigen::Index successes_ = 0, failures_ = 0;
};

template <class X>
struct TracedBase {
  using type = void;
};
template <class T>
struct TracedBase<Traced<T>> {
  using type = T;
};

}  // namespace detail::autodiff

/// Σ term(i) over i = 0, ..., n - 1, in an energy for from_energy(): a sum of local terms, as over sites or
/// bonds. To plain numbers it is no more than that; differentiated is each term on its own, several
/// neighbouring ones in the lanes of a register, at a cost that does not depend on the size of the system:
///
///     auto H = from_energy(n, [=](const auto& q, const auto& p) {
///       return sum_over(n, [&](auto i) { return p[i] * p[i] / 2; }) +
///              sum_over(n, [&](auto i) {
///                const auto r = q[(i + 1) % n] - q[i];
///                return r * r / 2 + r * r * r * r / 4;
///              });
///     });
///
/// The term takes its index by `auto` and reads q and p at i, i + 1, i - 2, 3 * i + 1, (i + 1) % n, and
/// at(array, i) of arrays of its parameters. Anything else is right as well, but slower (terms one by one on
/// a tape): array[i] with a plain array, at(array, i) of integers, branches that neighbouring terms take
/// differently, positions out of a table, more than eight neighbours, q and p copied elsewhere before. A term
/// that does not compile with such an index takes it as `Eigen::Index i`, and is evaluated one by one. It may
/// be called more often than n times.
template <std::integral Count, class Term>
auto sum_over(Count n, const Term& term);

namespace detail::autodiff {

template <class T, class Term, class Single>
Traced<T> traced_sum_over(Eigen::Index n, const Term& term, const Single& single) {
  using Index = LaneIndex<typename Planes<T>::Plain>;
  if constexpr (LanesFor<T>::exist) {
    if constexpr (std::same_as<std::invoke_result_t<const Term&, Index>,
                               TermNumber<typename LanesFor<T>::type>>) {
      if (!inside_term() && n >= Index::size) {
        TracedSum<T> sum(*Tape<T>::current());
        const auto in_lanes = [&](TouchedPlaces* touched, Eigen::Index first) SEMIEXPLICIT_CALL_OF_TERM {
          return term(Index{touched, first, 0, 1, 0, 8});
        };
        sum.add(n, in_lanes, single);
        return sum.finished();
      }
    }
  }
  Traced<T> sum;
  for (Eigen::Index i = 0; i < n; ++i) sum += single(i);
  return sum;
}

template <class T, class Term>
Traced<T> traced_sum_over_pairs(Eigen::Index n, const Term& term) {
  using Index = LaneIndex<typename Planes<T>::Plain>;
  if constexpr (LanesFor<T>::exist) {
    if constexpr (std::same_as<std::invoke_result_t<const Term&, Index, Index>,
                               TermNumber<typename LanesFor<T>::type>>) {
      if (!inside_term() && n > Index::size) {
        TracedSum<T> sum(*Tape<T>::current());
        for (Eigen::Index j = 1; j < n; ++j) {
          const auto in_lanes = [&](TouchedPlaces* touched, Eigen::Index first) SEMIEXPLICIT_CALL_OF_TERM {
            return term(Index{touched, first, 0, 1, 0, 4}, Index{touched, j, 0, 0, 0, 4});
          };
          sum.add(j, in_lanes, [&](Eigen::Index i) { return term(i, j); });
        }
        return sum.finished();
      }
    }
  }
  Traced<T> sum;
  for (Eigen::Index j = 1; j < n; ++j)
    for (Eigen::Index i = 0; i < j; ++i) sum += term(i, j);
  return sum;
}

}  // namespace detail::autodiff

template <std::integral Count, class Term>
auto sum_over(Count n, const Term& term) {
  using Number = std::remove_cvref_t<std::invoke_result_t<const Term&, Eigen::Index>>;
  using T = typename detail::autodiff::TracedBase<Number>::type;
  const auto count = static_cast<Eigen::Index>(n);
  if constexpr (!std::is_void_v<T>) {
    return detail::autodiff::traced_sum_over<T>(count, term, term);
  } else {
    Number sum(0);
    for (Eigen::Index i = 0; i < count; ++i) sum += term(i);
    return sum;
  }
}

/// Σ term(i, j) over all pairs 0 ≤ i < j < n, likewise: of particles that interact with all others. Both
/// indices are as the one of sum_over(), but with four neighbours each, as 3 * i, 3 * i + 1 and 3 * i + 2; j
/// may index plain arrays, too.
///
///     sum_over_pairs(n, [&](auto i, auto j) {
///       using std::sqrt;
///       const auto x = q[2 * i] - q[2 * j], y = q[2 * i + 1] - q[2 * j + 1];
///       return -at(mass, i) * at(mass, j) / sqrt(x * x + y * y);
///     })
template <std::integral Count, class Term>
auto sum_over_pairs(Count n, const Term& term) {
  using Number = std::remove_cvref_t<std::invoke_result_t<const Term&, Eigen::Index, Eigen::Index>>;
  using T = typename detail::autodiff::TracedBase<Number>::type;
  const auto count = static_cast<Eigen::Index>(n);
  if constexpr (!std::is_void_v<T>) {
    return detail::autodiff::traced_sum_over_pairs<T>(count, term);
  } else {
    Number sum(0);
    for (Eigen::Index j = 1; j < count; ++j)
      for (Eigen::Index i = 0; i < j; ++i) sum += term(i, j);
    return sum;
  }
}

namespace detail::autodiff {

/// How many entries an array has, as far as it tells.
template <class Array>
Eigen::Index entries_of(const Array& array) {
  if constexpr (requires { array.derived(); })
    return array.derived().size();
  else if constexpr (requires { std::size(array); })
    return static_cast<Eigen::Index>(std::size(array));
  else
    return std::numeric_limits<Eigen::Index>::max();
}

}  // namespace detail::autodiff

/// array[i], in a term of sum_over() or sum_over_pairs(), for the several terms at once that i may stand for.
/// Arrays are containers and vectors of Eigen, and pointers to entries for all terms, also those that a
/// branch leaves out.
template <class Array, std::integral I>
auto at(const Array& array, I i) {
  if constexpr (requires { array.derived(); })
    return array.derived().coeff(static_cast<Eigen::Index>(i));
  else if constexpr (requires { std::data(array); })
    return std::data(array)[i];
  else
    return array[i];
}
/// Integers stay what they are, as 1 / 2 is 0: those of a single term.
template <class Array, class S>
requires requires(const Array& array) { semiexplicit::at(array, Eigen::Index()) % 1; }
SEMIEXPLICIT_INTO_TERM auto at(const Array& array, const detail::autodiff::LaneIndex<S>& i) {
  return at(array, static_cast<Eigen::Index>(i));
}
template <class Array, class S>
SEMIEXPLICIT_INTO_TERM auto at(const Array& array, const detail::autodiff::LaneIndex<S>& i) {
  using Pack = detail::autodiff::LanePack<S>;
  const detail::autodiff::Place place = i.place();
  if (place.stride == 0) return Pack(at(array, place.first));
  const Eigen::Index size = detail::autodiff::entries_of(array);
  const bool in_a_row = place.stride == 1 && place.wrap == 0 && place.first >= 0 && i.last() < size;
  if constexpr (!requires { array.derived(); })
    if constexpr (requires {
                    { std::data(array) } -> std::convertible_to<const S*>;
                  } ||
                  std::convertible_to<Array, const S*>) {
      const S* data;
      if constexpr (requires { std::data(array); })
        data = std::data(array);
      else
        data = array;
      if (in_a_row) return Pack::load(data + place.first);
    }
  if constexpr (requires {
                  array.derived().innerStride();
                  { array.derived().data() } -> std::convertible_to<const S*>;
                })
    if (array.derived().innerStride() == 1 && in_a_row)
      return Pack::load(array.derived().data() + place.first);
  return Pack::of([&](int k) { return static_cast<S>(at(array, place.of_lane_or_first(k, size))); });
}

/// matrix(i, j), of a matrix of Eigen.
template <class Matrix, std::integral I, std::integral J>
auto at(const Matrix& matrix, I i, J j) {
  return matrix.coeff(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
}
template <class Matrix, class S>
requires requires(const Matrix& matrix) { matrix.coeff(0, 0) % 1; }
SEMIEXPLICIT_INTO_TERM auto at(const Matrix& matrix, const detail::autodiff::LaneIndex<S>& i,
                               const detail::autodiff::LaneIndex<S>& j) {
  return at(matrix, static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
}
template <class Matrix, class S>
SEMIEXPLICIT_INTO_TERM auto at(const Matrix& matrix, const detail::autodiff::LaneIndex<S>& i,
                               const detail::autodiff::LaneIndex<S>& j) {
  const detail::autodiff::Place row = i.place(), column = j.place();
  return detail::autodiff::LanePack<S>::of([&](int k) {
    return static_cast<S>(
        at(matrix, row.of_lane_or_first(k, matrix.rows()), column.of_lane_or_first(k, matrix.cols())));
  });
}
template <class Matrix, class S, std::integral J>
SEMIEXPLICIT_INTO_TERM auto at(const Matrix& matrix, const detail::autodiff::LaneIndex<S>& i, J j) {
  return at(matrix.col(static_cast<Eigen::Index>(j)), i);
}
template <class Matrix, std::integral I, class S>
SEMIEXPLICIT_INTO_TERM auto at(const Matrix& matrix, I i, const detail::autodiff::LaneIndex<S>& j) {
  return at(matrix.row(static_cast<Eigen::Index>(i)), j);
}

}  // namespace semiexplicit
