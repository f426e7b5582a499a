#pragma once

#include <concepts>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/derivatives/dual.hpp>

namespace semiexplicit {
namespace detail {

/// How many derivatives are taken in one evaluation of an energy of so many variables: all where they are few, rounded up to
/// whole registers, else eight at a time. (Measured with AVX-512.)
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

/// Half a phase point as a column of duals, which are made where they are read: nothing is stored. make(value, i) makes the
/// one of variable i, `first` is the index of the first.
template <class Column, class Make>
auto as_duals(const Column& values, Eigen::Index first, const Make& make) {
  using Number = decltype(make(values[0], first));
  return Eigen::Matrix<Number, Column::RowsAtCompileTime, 1>::NullaryExpr(
      values.size(),
      [data = values.data(), first, make](Eigen::Index i) { return make(data[i], first + i); });
}

}  // namespace detail

/// A Hamiltonian made of its energy alone, by automatic differentiation; see from_energy(). Where the energy takes the time
/// as well, (t, q, p), it models TimeDependentHamiltonian instead.
template <class ScalarType, int DofValue, class Energy>
class EnergyHamiltonian {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
  using Half = In<Scalar, Dof>;
  using HalfGradient = Out<Scalar, Dof>;
  static constexpr bool driven = std::invocable<const Energy&, const Scalar&, const Half&, const Half&>;

  EnergyHamiltonian(Eigen::Index dof, Energy energy) : dof_(dof), energy_(std::move(energy)) {
    if (dof < 1)
      throw std::invalid_argument("from_energy: " + std::to_string(dof) +
                                  " degrees of freedom; give one or more");
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

  /// The derivatives of the gradient, by duals of duals: 2d times the work of a gradient.
  void hessian(const Half& q, const Half& p,
               Eigen::Ref<Eigen::Matrix<Scalar, twice(Dof), twice(Dof)>> hessian) const requires(!driven) {
    using Inner = detail::Dual<Scalar, width>;
    using Outer = detail::Dual<Inner, 1>;
    for (Eigen::Index column = 0; column < 2 * dof_; ++column)
      for (Eigen::Index begin = 0; begin <= column; begin += width) {
        const auto make = [begin, column](const Scalar& value, Eigen::Index i) {
          Outer x(detail::variable<Scalar, width>(value, i - begin));
          if (i == column) x.derivative[0].value = Scalar(1);
          return x;
        };
        const Outer h = energy_(detail::as_duals(q, 0, make), detail::as_duals(p, dof_, make));
        for (Eigen::Index i = begin, k = 0; k < width && i <= column; ++i, ++k)
          hessian(i, column) = hessian(column, i) = h.derivative[0].derivative[k];
      }
  }

 private:
  static constexpr int width = detail::dual_width(twice(Dof));

  template <class F>
  void differentiate(const F& f, const Half& q, const Half& p, HalfGradient& dHdq, HalfGradient& dHdp) const {
    using Number = detail::Dual<Scalar, width>;
    for (Eigen::Index begin = 0; begin < 2 * dof_; begin += width) {
      const auto make = [begin](const Scalar& value, Eigen::Index i) {
        return detail::variable<Scalar, width>(value, i - begin);
      };
      const Number h = f(detail::as_duals(q, 0, make), detail::as_duals(p, dof_, make));
      for (Eigen::Index i = begin, k = 0; k < width && i < 2 * dof_; ++i, ++k)
        (i < dof_ ? dHdq[i] : dHdp[i - dof_]) = h.derivative[k];
    }
  }

  Eigen::Index dof_;
  Energy energy_;
};

/// A Hamiltonian from nothing but its energy: gradient and Hessian are found by automatic differentiation, exact to rounding.
///
///     auto H = from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; });
///
/// The energy is called with numbers of other types than double, so it has to be a template: `auto` parameters, and `auto` or
/// `typename std::decay_t<decltype(q)>::Scalar` for sums. Functions are called without `std::` in front (`using std::sqrt;
/// sqrt(x)`); there are sqrt, cbrt, exp, expm1, log, log1p, the trigonometric and hyperbolic ones with their inverses, hypot,
/// pow and abs. q and p are columns of Eigen: q.squaredNorm(), q.dot(p), q.head(3) work, q.data() does not.
///
/// A gradient takes the energy once with all 2d derivatives carried along, beyond d = 12 several times with eight of them, so its
/// cost grows with d times that of the energy. A step with it, over one with a gradient by hand (bench_autodiff, AVX-512):
/// 2.3 in one degree of freedom, 7 on a lattice of five sites, 16 for ten vortices, 90 on a lattice of 100. No heap use.
template <int Dof, class Scalar = double, class Energy>
requires(Dof > 0) auto from_energy(Energy energy) {
  return EnergyHamiltonian<Scalar, Dof, Energy>(Dof, std::move(energy));
}

/// The same with the size `dof` known at run time: `from_energy(n, energy)`. Throws std::invalid_argument unless dof > 0.
template <class Scalar = double, class Energy>
auto from_energy(Eigen::Index dof, Energy energy) {
  return EnergyHamiltonian<Scalar, Eigen::Dynamic, Energy>(dof, std::move(energy));
}

}  // namespace semiexplicit
