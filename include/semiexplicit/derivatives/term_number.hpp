#pragma once

#include <concepts>
#include <cstddef>
#include <utility>

#include <Eigen/Core>

#include <semiexplicit/derivatives/lane_index.hpp>
#include <semiexplicit/derivatives/tape.hpp>

namespace semiexplicit::detail::autodiff {

/// The numbers that the lanes of a term take for a tape's.
template <class T>
struct LanesFor {
  using type = LanePack<T>;
  static constexpr bool exist = lanes_of<T> > 0;
};
template <class T>
struct LanesFor<Dual<T, 1>> {
  using type = Dual<LanePack<T>, 1>;
  static constexpr bool exist = lanes_of<T> > 0;
};
template <class T>
T first_lane(const LanePack<T>& x) {
  return x.lanes[0];
}
template <class T>
Dual<T, 1> first_lane(const Dual<LanePack<T>, 1>& x) {
  Dual<T, 1> first(x.value.lanes[0]);
  first.derivative[0] = x.derivative[0].lanes[0];
  return first;
}

/// A number in neighbouring terms, with its derivatives in the variables that they have touched. `active`
/// says which derivatives are not zero, and those only are computed: once all is inlined the compiler knows
/// it, and nothing is left of the others.
template <class L>
struct TermNumber : Operators<TermNumber<L>, L> {
  static constexpr int slots = TouchedPlaces::slots;
  L value;
  L derivative[slots];
  unsigned active = 0;

  TermNumber() : value(0) {}
  template <class U>
  requires(std::convertible_to<U, L>) SEMIEXPLICIT_INTO_TERM TermNumber(const U& number)
      : value(static_cast<L>(number)) {}  // NOLINT: a number is a constant

  SEMIEXPLICIT_INTO_TERM bool varies(int slot) const { return (active >> slot & 1u) != 0; }
  /// f(std::integral_constant<int, slot>) for all slots.
  template <class F>
  static SEMIEXPLICIT_INTO_TERM void each_slot(const F& f) {
    each_of(f, std::make_integer_sequence<int, slots>());
  }

  SEMIEXPLICIT_INTO_TERM TermNumber chain(const L& f, const L& slope) const {
    TermNumber result(f);
    result.active = active;
    each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if (varies(k)) result.derivative[k] = slope * derivative[k];
    });
    return result;
  }
  static SEMIEXPLICIT_INTO_TERM TermNumber chain(const L& f, const L& slope_x, const TermNumber& x,
                                                 const L& slope_y, const TermNumber& y) {
    TermNumber result(f);
    result.active = x.active | y.active;
    each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if (x.varies(k) && y.varies(k))
        result.derivative[k] = slope_x * x.derivative[k] + slope_y * y.derivative[k];
      else if (x.varies(k))
        result.derivative[k] = slope_x * x.derivative[k];
      else if (y.varies(k))
        result.derivative[k] = slope_y * y.derivative[k];
    });
    return result;
  }
  static TermNumber chain_if_varying(const L& f, const L& slope_x, const TermNumber& x, const L& slope_y,
                                     const TermNumber& y) {
    return chain(f, slope_x, x, slope_y, y);
  }
  static SEMIEXPLICIT_INTO_TERM TermNumber plus(const TermNumber& x, const TermNumber& y) {
    TermNumber result(x.value + y.value);
    result.active = x.active | y.active;
    each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if (x.varies(k) && y.varies(k))
        result.derivative[k] = x.derivative[k] + y.derivative[k];
      else if (x.varies(k))
        result.derivative[k] = x.derivative[k];
      else if (y.varies(k))
        result.derivative[k] = y.derivative[k];
    });
    return result;
  }
  static SEMIEXPLICIT_INTO_TERM TermNumber minus(const TermNumber& x, const TermNumber& y) {
    TermNumber result(x.value - y.value);
    result.active = x.active | y.active;
    each_slot([&](auto k) SEMIEXPLICIT_INLINE_LAMBDA {
      if (x.varies(k) && y.varies(k))
        result.derivative[k] = x.derivative[k] - y.derivative[k];
      else if (x.varies(k))
        result.derivative[k] = x.derivative[k];
      else if (y.varies(k))
        result.derivative[k] = -y.derivative[k];
    });
    return result;
  }
  SEMIEXPLICIT_INTO_TERM TermNumber shifted(const L& f) const {
    TermNumber result(*this);
    result.value = f;
    return result;
  }
  SEMIEXPLICIT_INTO_TERM TermNumber scaled(const L& f, const L& factor) const { return chain(f, factor); }
  SEMIEXPLICIT_INTO_TERM const L& compared() const { return value; }

  /// Where a term mixes with numbers that are the same for all terms, but not constant, it goes to the tape.
  template <class T>
  requires(std::same_as<typename LanesFor<T>::type, L>) operator Traced<T>() const {  // NOLINT
    lanes_part() = true;
    return first_lane(value);
  }
  template <class T>
  requires(std::same_as<typename LanesFor<T>::type, L>) TermNumber& operator=(const Traced<T>& x) {
    lanes_part() = true;
    active = 0;
    value = L(Planes<T>::plain(x.value));
    return *this;
  }

 private:
  template <class F, int... K>
  static SEMIEXPLICIT_INTO_TERM void each_of(const F& f, std::integer_sequence<int, K...>) {
    (f(std::integral_constant<int, K>()), ...);
  }
};

}  // namespace semiexplicit::detail::autodiff

template <class L>
class std::numeric_limits<semiexplicit::detail::autodiff::TermNumber<L>> : public std::numeric_limits<L> {};
