#pragma once

#include <concepts>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/derivatives/columns.hpp>
#include <semiexplicit/derivatives/dual.hpp>
#include <semiexplicit/derivatives/terms.hpp>

namespace semiexplicit {
namespace detail {

/// How many derivatives are taken in one evaluation of an energy of so many variables: all where they are
/// few, rounded up to whole registers, else eight at a time. (Measured with AVX-512.)
constexpr int dual_width(int variables) {
  if (variables <= 0 || variables > 24) return 8;
  if (variables <= 4) return variables;
  return variables <= 12 ? (variables + 3) / 4 * 4 : (variables + 7) / 8 * 8;
}

/// A number that varies in that direction, if it is one of 0 to N - 1, and is constant otherwise.
template <class Scalar, int N>
Dual<Scalar, N> variable(const Scalar& value, Eigen::Index direction) {
  Dual<Scalar, N> x(value);
  for (int k = 0; k < N; ++k)
    if (k == direction) x.derivative[k] = Scalar(1);
  return x;
}

/// Half a phase point as a column of duals, which are made where they are read: nothing is stored.
/// make(value, i) makes the one of variable i, `first` is the index of the first.
template <class Column, class Make>
auto as_duals(const Column& values, Eigen::Index first, const Make& make) {
  using Number = decltype(make(values[0], first));
  return Eigen::Matrix<Number, Column::RowsAtCompileTime, 1>::NullaryExpr(
      values.size(),
      [data = values.data(), first, make](Eigen::Index i) { return make(data[i], first + i); });
}

/// Whether the energy can be called with columns of numbers of that type, and gives one.
template <class Number, class Energy, class Q, class P>
consteval bool is_energy_of_columns() {
  constexpr bool takes_columns = std::invocable<const Energy&, Q, P>;
  static_assert(
      takes_columns,
      "from_energy: the energy does not take columns of any numbers, or changes itself: write it as "
      "`[](const auto& q, const auto& p) { return ...; }`, with t in front where it depends on the "
      "time, and not mutable");
  if constexpr (takes_columns)
    static_assert(std::convertible_to<std::invoke_result_t<const Energy&, Q, P>, Number>,
                  "from_energy: the energy gives no number of those it takes: return one, as `return (p[0] * "
                  "p[0] + q[0] * q[0]) / 2;`");
  return takes_columns;
}

}  // namespace detail

/// A Hamiltonian made of its energy alone, by automatic differentiation; see from_energy(). Where the energy
/// takes the time as well, (t, q, p), it models TimeDependentHamiltonian instead.
template <class ScalarType, int DofValue, class Energy>
class EnergyHamiltonian {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
  using Half = In<Scalar, Dof>;
  using HalfGradient = Out<Scalar, Dof>;
  static constexpr bool driven = std::invocable<const Energy&, const Scalar&, const Half&, const Half&>;

  static_assert(
      !detail::takes_time_last<driven, Energy, const Half&, const Half&, const Scalar&>(),
      "from_energy: the energy takes a number behind q and p, which would always be its default: the "
      "time comes first, (t, q, p)");

  EnergyHamiltonian(Eigen::Index dof, Energy energy) : dof_(dof), energy_(std::move(energy)) {
    if (dof < 1)
      throw std::invalid_argument("from_energy: " + std::to_string(dof) +
                                  " degrees of freedom; give one or more");
    if constexpr (may_use_tape)
      if (by_tape()) {
        reserve<Scalar>();
        reserve<detail::Dual<Scalar, 1>>();
      }
  }

  Eigen::Index dof() const { return dof_; }

  Scalar energy(const Half& q, const Half& p) const requires(!driven) { return energy_(q, p); }
  Scalar energy(const Scalar& t, const Half& q, const Half& p) const requires driven {
    return energy_(t, q, p);
  }

  void gradient(const Half& q, const Half& p, HalfGradient dHdq, HalfGradient dHdp) const requires(!driven) {
    differentiate(energy_, q, p, dHdq, dHdp);
  }
  void gradient(const Scalar& t, const Half& q, const Half& p, HalfGradient dHdq,
                HalfGradient dHdp) const requires driven {
    const auto now = [&](const auto& at_q, const auto& at_p) { return energy_(t, at_q, at_p); };
    differentiate(now, q, p, dHdq, dHdp);
  }
  /// ∂H/∂t.
  Scalar time_derivative(const Scalar& t, const Half& q, const Half& p) const requires driven {
    const detail::Dual<Scalar, 1> h = energy_(detail::variable<Scalar, 1>(t, 0), q, p);
    return h.derivative[0];
  }

  /// The derivatives of the gradient: 2d times the work of hessian_times().
  void hessian(const Half& q, const Half& p,
               Eigen::Ref<Eigen::Matrix<Scalar, twice(Dof), twice(Dof)>> hessian) const requires(!driven) {
    if constexpr (may_use_tape)
      if (by_tape()) {
        for (Eigen::Index column = 0; column < 2 * dof_; ++column) {
          auto both = hessian.col(column);  // the direction, and then the result
          both.setZero();
          both[column] = Scalar(1);
          Scalar* const to = &hessian(0, column);
          backwards<detail::Dual<Scalar, 1>>(energy_, {q.data(), to}, {p.data(), to + dof_}, to, to + dof_);
          for (Eigen::Index i = 0; i < column; ++i) both[i] = hessian(column, i);
        }
        return;
      }
    if constexpr (may_use_duals)
      for (Eigen::Index column = 0; column < 2 * dof_; ++column)
        second_derivatives(
            q, p, column + 1, [column](Eigen::Index i) { return Scalar(i == column ? 1 : 0); },
            [&](Eigen::Index i, const Scalar& slope) { hessian(i, column) = hessian(column, i) = slope; });
  }

  /// The Hessian times (dq, dp), written to out_q and out_p, of d numbers each: the derivative of the
  /// gradient along that direction. A few times the work of a gradient. The outputs must not overlap the
  /// inputs.
  void hessian_times(const Half& q, const Half& p, const Half& dq, const Half& dp, HalfGradient out_q,
                     HalfGradient out_p) const requires(!driven) {
    if constexpr (may_use_tape)
      if (by_tape())
        return backwards<detail::Dual<Scalar, 1>>(energy_, {q.data(), dq.data()}, {p.data(), dp.data()},
                                                  out_q.data(), out_p.data());
    if constexpr (may_use_duals)
      second_derivatives(
          q, p, 2 * dof_, [&](Eigen::Index i) { return i < dof_ ? dq[i] : dp[i - dof_]; },
          [&](Eigen::Index i, const Scalar& slope) { (i < dof_ ? out_q[i] : out_p[i - dof_]) = slope; });
  }

 private:
  static constexpr int width = detail::dual_width(twice(Dof));
  /// Up to so many degrees of freedom carrying all derivatives along costs less than a tape.
  static constexpr int few = 8;
  static constexpr bool may_use_tape = Dof == Eigen::Dynamic || Dof > few;
  static constexpr bool may_use_duals = Dof == Eigen::Dynamic || Dof <= few;
  bool by_tape() const { return Dof == Eigen::Dynamic ? dof_ > few : may_use_tape; }

  template <class T>
  void reserve() const {
    detail::Tape<T>::use([&](detail::Tape<T>& tape) { tape.reserve(2 * dof_, 1024, 4); });
  }

  template <class F>
  void differentiate(const F& f, const Half& q, const Half& p, HalfGradient& dHdq, HalfGradient& dHdp) const {
    if constexpr (may_use_tape)
      if (by_tape()) return backwards<Scalar>(f, {q.data()}, {p.data()}, dHdq.data(), dHdp.data());
    if constexpr (may_use_duals) forwards(f, q, p, dHdq, dHdp);
  }

  template <class F>
  void forwards(const F& f, const Half& q, const Half& p, HalfGradient& dHdq, HalfGradient& dHdp) const {
    using Number = detail::Dual<Scalar, width>;
    for (Eigen::Index begin = 0; begin < 2 * dof_; begin += width) {
      const auto make = [begin](const Scalar& value, Eigen::Index i) {
        return detail::variable<Scalar, width>(value, i - begin);
      };
      using Column = decltype(detail::as_duals(q, 0, make));
      static_assert(detail::is_energy_of_columns<Number, F, Column, Column>());
      const Number h = f(detail::as_duals(q, 0, make), detail::as_duals(p, dof_, make));
      for (Eigen::Index i = begin, k = 0; k < width && i < 2 * dof_; ++i, ++k)
        (i < dof_ ? dHdq[i] : dHdp[i - dof_]) = h.derivative[k];
    }
  }

  /// put(i, the derivative of ∂H/∂xᵢ along the direction) for the first `count` variables, by duals of duals.
  template <class Direction, class Put>
  void second_derivatives(const Half& q, const Half& p, Eigen::Index count, const Direction& direction,
                          const Put& put) const {
    using Inner = detail::Dual<Scalar, width>;
    using Outer = detail::Dual<Inner, 1>;
    for (Eigen::Index begin = 0; begin < count; begin += width) {
      const auto make = [begin, &direction](const Scalar& value, Eigen::Index i) {
        Outer x(detail::variable<Scalar, width>(value, i - begin));
        x.derivative[0].value = direction(i);
        return x;
      };
      const Outer h = energy_(detail::as_duals(q, 0, make), detail::as_duals(p, dof_, make));
      for (Eigen::Index i = begin, k = 0; k < width && i < count; ++i, ++k)
        put(i, h.derivative[0].derivative[k]);
    }
  }

  /// Not part of a step: with it a compiler takes minutes.
  template <class T, class F>
  SEMIEXPLICIT_NOINLINE void backwards(const F& f, detail::autodiff::HalfPoint<T> q,
                                       detail::autodiff::HalfPoint<T> p, Scalar* to_q, Scalar* to_p) const {
    using detail::autodiff::EnergyColumn;
    using Tape = detail::Tape<T>;
    struct Memory {
      bool values = true;                // whether this energy needs the values of its sums
      typename Tape::Weights weights{};  // which else enter it with these
    };
    thread_local constinit Memory memory;
    Tape::use([&](Tape& tape) {
      const auto once = [&](bool direct) {
        tape.start(2 * dof_, to_q, to_p, direct ? &memory.weights : nullptr);
        tape.values = memory.values;
        using Q = EnergyColumn<T, Dof, 0>;
        using P = EnergyColumn<T, Dof, 1>;
        static_assert(detail::is_energy_of_columns<detail::Traced<T>, F, Q, P>());
        const detail::Traced<T> h = f(Q(&tape, q, dof_), P(&tape, p, dof_));
        if (memory.values || !tape.values_used) return tape.sweep(h, memory.weights);
        memory.values = true;
        return false;
      };
      const auto record = [&] {
        // Derivatives of duals have their inputs where the outputs come to lie.
        const bool direct = std::is_same_v<T, Scalar> && std::is_floating_point_v<Scalar> && !memory.values;
        if (!once(direct) && !once(direct && !memory.values)) once(false);
      };
      record();
      if (memory.values != tape.values_used) {
        // The two ways round differently, and a gradient must not depend on those before it: a run that is
        // resumed.
        memory.values = tape.values_used;
        record();
      }
      tape.write();
    });
  }

  Eigen::Index dof_;
  Energy energy_;
};

/// A Hamiltonian from nothing but its energy: gradient and Hessian are found by automatic differentiation,
/// exact to rounding.
///
///     auto H = from_energy<1>([](const auto& q, const auto& p) {
///       return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2;
///     });
///
/// The energy is called with numbers of other types than double, so it has to be a template: `auto`
/// parameters, and `auto` or `typename std::decay_t<decltype(q)>::Scalar` for sums. Functions are called
/// without `std::` in front (`using std::sqrt; sqrt(x)`); there are sqrt, cbrt, exp, exp2, expm1, log, log2,
/// log10, log1p, the trigonometric and hyperbolic ones with their inverses, atan2, hypot, pow, erf, erfc,
/// abs, fabs, min, max, fmin and fmax. q and p are columns of Eigen: q.squaredNorm(), q.dot(p), q.head(3)
/// work, q.data() does not.
///
/// Up to eight degrees of freedom the energy is evaluated once or twice with all derivatives carried along.
/// Beyond that it is recorded and gone through backwards, for a few times the cost of the energy however many
/// variables there are; an energy written with sum_over() and sum_over_pairs() is differentiated term by
/// term, which is faster again (terms.hpp). Gradients by terms take 2.5 to 4 times as long as a vectorised
/// loop by hand on a lattice of 100 or 400 sites (backwards: 70 times), twice as long for pairs of 200
/// vortices; see benchmarks/autodiff. Memory is kept, one piece for each thread; no heap use once it is large
/// enough, and none where all of the energy are sums.
template <int Dof, class Scalar = double, class Energy>
requires(Dof > 0) auto from_energy(Energy energy) {
  return EnergyHamiltonian<Scalar, Dof, Energy>(Dof, std::move(energy));
}

/// The same with the size `dof` known at run time: `from_energy(n, energy)`. Throws std::invalid_argument
/// unless dof > 0.
template <class Scalar = double, class Energy>
auto from_energy(Eigen::Index dof, Energy energy) {
  return EnergyHamiltonian<Scalar, Eigen::Dynamic, Energy>(dof, std::move(energy));
}

}  // namespace semiexplicit
