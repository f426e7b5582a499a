#pragma once

#include <concepts>
#include <functional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// What can be asked for by name; all of them in any number of degrees of freedom.
namespace observables {

/// H(q, p), by which cost_of_accuracy() judges where nothing is said.
struct Energy {};
/// All of z = (q, p), without (t, p_t) where the time is a coordinate, see InExtendedPhaseSpace.
struct Trajectory {};
/// All positions, likewise.
struct Positions {};
/// One entry of (q, p), counted from 0: the momenta follow the d positions, of a driven system (Autonomous) q
/// and the time, then p and its momentum. Beyond 2d - 1: std::out_of_range
/// where it is used.
struct Coordinate {
  Eigen::Index index;
};

}  // namespace observables

/// A function of (q, p) that is measured along a run: a number or a vector. Made of any callable f(q, p)
/// whose arguments are `const auto&`, In<Scalar, Dof> or columns, and whose result is a number or an Eigen
/// column. Has no jumps: of an angle that is wrapped, return sine and cosine.
template <class ScalarType, int D>
class Observable {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = D;
  using Value = Vector<Scalar, Eigen::Dynamic>;

  /// The energy.
  Observable() = default;
  Observable(observables::Energy) {}
  Observable(observables::Trajectory)
      : value_([](const PhasePoint<Scalar, Dof>& z, Eigen::Index d) {
          Value all(2 * d);
          all << z.q().head(d), z.p().head(d);
          return all;
        }) {}
  Observable(observables::Positions)
      : value_([](const PhasePoint<Scalar, Dof>& z, Eigen::Index d) { return Value(z.q().head(d)); }) {}
  Observable(observables::Coordinate one)
      : value_([i = one.index](const PhasePoint<Scalar, Dof>& z, Eigen::Index) {
          if (i < 0 || i >= z.vector().size())
            throw std::out_of_range("observables::Coordinate: there is no entry " + std::to_string(i) +
                                    " among " + std::to_string(z.vector().size()));
          return Value(Value::Constant(1, z.vector()[i]));
        }) {}
  template <class F>
  requires std::invocable < const F&, const In<Scalar, Dof>
  &, const In<Scalar, Dof>& > Observable(F f)
      : value_([f = std::move(f)](const PhasePoint<Scalar, Dof>& z, Eigen::Index) {
          return column(f(In<Scalar, Dof>(z.q()), In<Scalar, Dof>(z.p())));
        }) {}

  bool is_energy() const { return !value_; }
  /// Throws std::logic_error where it is the energy, which H knows alone.
  Value operator()(const PhasePoint<Scalar, Dof>& z) const { return (*this)(z, z.dof()); }
  /// Where only the first `d` degrees of freedom are the system's own.
  Value operator()(const PhasePoint<Scalar, Dof>& z, Eigen::Index d) const {
    if (is_energy()) throw std::logic_error("Observable: the energy is H's own; call H.energy(q, p)");
    return value_(z, d);
  }

 private:
  template <class Result>
  static Value column(Result&& result) {
    static_assert(
        !detail::is_narrower<std::remove_cvref_t<Result>, Scalar>,
        "this function tells no more than true and false, whole numbers, or ones of fewer digits than "
        "Scalar, which hides how far it strayed: let it return a Scalar");
    if constexpr (std::convertible_to<Result, Scalar>)
      return Value::Constant(1, Scalar(result));
    else
      return Value(std::forward<Result>(result));
  }
  std::function<Value(const PhasePoint<Scalar, Dof>&, Eigen::Index)> value_{};
};

}  // namespace semiexplicit
