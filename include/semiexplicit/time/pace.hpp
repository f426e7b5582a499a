#pragma once

#include <concepts>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// A monitor function g(q) > 0, the pace of time: g(q, dgdq) returns the value and writes the gradient.
template <class G, class Scalar, int Dof>
concept PositionMonitor = requires(const G& g, In<Scalar, Dof> q, Out<Scalar, Dof> dgdq) {
  { g(q, dgdq) } -> std::convertible_to<Scalar>;
};

/// A monitor function g(q, p) > 0: g(q, p, dgdq, dgdp) returns the value and writes both halves of the
/// gradient.
template <class G, class Scalar, int Dof>
concept PhaseMonitor = requires(const G& g, In<Scalar, Dof> q, In<Scalar, Dof> p, Out<Scalar, Dof> dgdq,
                                Out<Scalar, Dof> dgdp) {
  { g(q, p, dgdq, dgdp) } -> std::convertible_to<Scalar>;
};

namespace detail {

template <class G, class Scalar, int Dof>
concept HasMonitorValue = requires(const G& g, In<Scalar, Dof> q, In<Scalar, Dof> p) {
  { g.value(q, p) } -> std::convertible_to<Scalar>;
};
template <class G, class Scalar, int Dof>
concept ValueFunction = std::invocable < const G&,
        const In<Scalar, Dof>
&, const In<Scalar, Dof>& > ;

}  // namespace detail

/// A monitor function of which the value is all that is asked: `g.value(q, p)`, which a monitor with
/// gradients may have beside them, or a PhaseMonitor, or any function g(q, p). A function of two arguments is
/// taken as one of q and p.
template <class G, class Scalar, int Dof>
concept ValueMonitor = detail::HasMonitorValue<G, Scalar, Dof> || PhaseMonitor<G, Scalar, Dof> ||
    detail::ValueFunction<G, Scalar, Dof>;

namespace detail {

/// Compiles for a monitor function whose value and gradient are known; of anything else the compiler says how
/// to write it.
template <class G, class Scalar, int Dof>
consteval bool is_monitor_with_gradient() {
  constexpr bool fits = PositionMonitor<G, Scalar, Dof> || PhaseMonitor<G, Scalar, Dof>;
  static_assert(
      fits,
      "this monitor function cannot be called: write `double operator()(const auto& q, auto&& dgdq) "
      "const`, which returns g and writes its gradient, or (q, p, dgdq, dgdp)");
  return fits;
}
/// The same for one of which the value is asked alone.
template <class G, class Scalar, int Dof>
consteval bool is_monitor() {
  static_assert(ValueMonitor<G, Scalar, Dof>,
                "this monitor function cannot be called: write `double operator()(const auto& q, const auto& "
                "p) const`, which returns g");
  return ValueMonitor<G, Scalar, Dof>;
}

/// What a monitor function returned, as a Scalar.
template <class Scalar, class Value>
Scalar monitor_value(Value&& g) {
  static_assert(!is_narrower<std::remove_cvref_t<Value>, Scalar>,
                "this monitor function returns a whole number, or one of fewer digits than Scalar, which "
                "rounds it: return g as a Scalar");
  return static_cast<Scalar>(std::forward<Value>(g));
}

/// A monitor that is one of the system's own coordinates, not of the time where that is one.
template <class G>
inline constexpr bool leaves_time_out = false;

/// g at z, `Timed`: in an extended phase space; `scratch` is for a gradient that comes with it.
template <bool Timed, class G, class Scalar, int Dof>
Scalar pace(const G& g, const PhasePoint<Scalar, Dof>& z, [[maybe_unused]] PhasePoint<Scalar, Dof>& scratch) {
  if constexpr (Timed && leaves_time_out<G>)
    return monitor_value<Scalar>(g.value(z.q().head(z.dof() - 1), z.p().head(z.dof() - 1)));
  else if constexpr (HasMonitorValue<G, Scalar, Dof>)
    return monitor_value<Scalar>(g.value(z.q(), z.p()));
  else if constexpr (PhaseMonitor<G, Scalar, Dof>) {
    auto dgdq = scratch.q(), dgdp = scratch.p();  // a monitor may take them by reference
    return monitor_value<Scalar>(g(z.q(), z.p(), dgdq, dgdp));
  } else
    return monitor_value<Scalar>(g(z.q(), z.p()));
}

}  // namespace detail
}  // namespace semiexplicit
