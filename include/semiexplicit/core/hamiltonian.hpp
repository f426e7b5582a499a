#pragma once

#include <concepts>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/vector.hpp>

namespace semiexplicit {

/// H names the type it computes with: `using Scalar = double;`.
template <class H>
concept HasScalar = requires {
  typename H::Scalar;
};

namespace detail {

/// Dof is an ordinary member, which no type can be made of.
template <class H>
concept HasDofOfEachObject = requires {
  requires std::is_member_object_pointer_v<decltype(&H::Dof)>;
};

}  // namespace detail

/// H names its degrees of freedom d, so that q and p lie in R^d: `static constexpr int Dof = 5;`, or
/// Eigen::Dynamic.
template <class H>
concept HasDof = !detail::HasDofOfEachObject<H> && requires {
  typename std::integral_constant<int, H::Dof>;
  requires(H::Dof > 0 || H::Dof == Eigen::Dynamic);
};

/// An H of dynamic size also says it at run time: `Eigen::Index dof() const;`. A fixed one need not.
template <class H>
concept HasRuntimeDof = requires(const H& h) {
  { h.dof() } -> std::convertible_to<Eigen::Index>;
};

namespace detail {

/// What the members of a Hamiltonian are called with: columns in somebody else's memory.
template <class H>
using InColumn = Eigen::Map<const Vector<typename H::Scalar, H::Dof>>;
template <class H>
using OutColumn = Eigen::Map<Vector<typename H::Scalar, H::Dof>>;

}  // namespace detail

/// H writes both halves of its gradient, ∂H/∂q and ∂H/∂p, into the caller's storage in one call. This is all
/// that an integrator needs of it, and the unit in which work is counted.
template <class H>
concept HasGradient = requires(const H& h, const detail::InColumn<H>& q, const detail::InColumn<H>& p,
                               detail::OutColumn<H>& dHdq, detail::OutColumn<H>& dHdp) {
  h.gradient(q, p, dHdq, dHdp);
};

/// What a user writes where H depends on the time: the same with the time as the first argument.
/// Autonomous(H) makes a Hamiltonian of it; without that no integrator takes it. Optional are `energy(t, q,
/// p)` and ∂H/∂t, by `time_derivative(t, q, p)` or as what gradient() returns.
template <class H>
concept TimeDependentHamiltonian = std::copy_constructible<H> && HasScalar<H> && HasDof<H> &&
    requires(const H& h, const typename H::Scalar& t, const detail::InColumn<H>& q,
             const detail::InColumn<H>& p, detail::OutColumn<H>& dHdq, detail::OutColumn<H>& dHdp) {
  h.gradient(t, q, p, dHdq, dHdp);
} &&(H::Dof != Eigen::Dynamic || HasRuntimeDof<H>);

/// No integrator takes a bare time-dependent H; the name is what a compiler will say of one.
template <class H>
concept DependsOnTimeSoWrapItInAutonomous = TimeDependentHamiltonian<H>;

/// What a user writes: a copyable type with `Scalar`, `Dof` (and `dof()` if dynamic) and `gradient`. A
/// gradient may throw; the state then stays at the last good step and the stepper stays usable. NaN or Inf in
/// its result is reported likewise.
///
///     struct Product {  // H = (q² + 1)(p² + 1)/2
///       using Scalar = double;
///       static constexpr int Dof = 1;
///       void gradient(In<double, 1> q, In<double, 1> p,
///                     Out<double, 1> dHdq, Out<double, 1> dHdp) const {
///         dHdq[0] = q[0] * (p[0] * p[0] + 1);
///         dHdp[0] = p[0] * (q[0] * q[0] + 1);
///       }
///     };
template <class H>
concept Hamiltonian =
    std::copy_constructible<H> && HasScalar<H> && HasDof<H> && !DependsOnTimeSoWrapItInAutonomous<H> &&
    HasGradient<H> && (H::Dof != Eigen::Dynamic || HasRuntimeDof<H>);

/// Optional: the value H(q, p), for the energy error of a run. No integrator needs it.
template <class H>
concept HasEnergy = Hamiltonian<H> &&
    requires(const H& h, const detail::InColumn<H>& q, const detail::InColumn<H>& p) {
  { h.energy(q, p) } -> std::convertible_to<typename H::Scalar>;
};

/// Optional, for large systems in which a site feels its neighbours only: the entries begin to end - 1 of the
/// gradient, into dHdq[0], dHdp[0] and on. An explicit step then goes through such a system in blocks that
/// stay in the nearest cache, instead of writing a whole gradient to memory and reading it back: 1.2 times
/// faster at 1000 sites, 1.8 at 10⁶. H says that it agrees with gradient() by `using RangeGradientOf = H;`,
/// which does not hold for a type that derives from H and changes gradient(). With OpenMP several threads
/// call it at once, for different ranges.
template <class H>
concept HasRangeGradient = Hamiltonian<H> && std::same_as<typename H::RangeGradientOf, H> &&
    requires(const H& h, Eigen::Index begin, Eigen::Index end, const typename H::Scalar* at,
             typename H::Scalar* gradient) {
  h.gradient_range(begin, end, at, at, gradient, gradient);  // q, p, dHdq, dHdp
};

/// Optional, beside a range gradient: entry i of the gradient reads the entries i - reach() to i + reach() of
/// q and p, and no others. In a large system a step then takes every block through many kicks while it is in
/// the cache, and each thread a part of the system through all of them: at 10⁶ sites 1.4 times as fast on one
/// core, and 2.6 times on two. A ring, whose ends are neighbours, has no reach.
template <class H>
concept HasLocalGradient = HasRangeGradient<H> && requires(const H& h) {
  { h.reach() } -> std::convertible_to<Eigen::Index>;
};

/// Optional: the symmetric 2d × 2d matrix [H_qq H_qp; H_pq H_pp]. Tangent maps and Newton's method of
/// GaussLegendre use it; without it they take differences of the gradient. Tangent vectors of large systems
/// want HasHessianTimes.
template <class H>
concept HasHessian = Hamiltonian<H> &&
    requires(const H& h, const detail::InColumn<H>& q, const detail::InColumn<H>& p,
             Eigen::Ref<Eigen::Matrix<typename H::Scalar, twice(H::Dof), twice(H::Dof)>> hessian) {
  h.hessian(q, p, hessian);
};

/// Optional: that matrix times a column (dq, dp), written to the halves hq and hp, without the matrix.
/// Tangent vectors use it: their cost is then that of a few gradients, whatever the size.
///
///     void hessian_times(In<double, 1> q, In<double, 1> p, In<double, 1> dq, In<double, 1> dp,
///                        Out<double, 1> hq, Out<double, 1> hp) const;
template <class H>
concept HasHessianTimes = Hamiltonian<H> &&
    requires(const H& h, const detail::InColumn<H>& at, detail::OutColumn<H>& half) {
  h.hessian_times(at, at, at, at, half, half);  // q, p, dq, dp, hq, hp
};

/// Optional: H(q, p) = V(q) + T(p), and each half of the gradient can be had alone. H says so by `static
/// constexpr bool separable = true;` and `using SeparableGradientOf = H;`, which does not hold for a type
/// that derives from H and changes gradient(). ExplicitSplitting then needs no second copy of the phase
/// point.
template <class H>
concept SeparableHamiltonian =
    Hamiltonian<H> && std::same_as<typename H::SeparableGradientOf, H> && requires {
  requires bool(H::separable);
} && requires(const H& h, const detail::InColumn<H>& at, detail::OutColumn<H>& half) {
  h.position_gradient(at, half);  // ∂V/∂q at q
  h.momentum_gradient(at, half);  // ∂T/∂p at p
};

/// The degrees of freedom of `h`: known to the type, or asked of the value.
template <class H>
constexpr Eigen::Index dof_of(const H& h) {
  if constexpr (H::Dof == Eigen::Dynamic)
    return h.dof();
  else
    return H::Dof;
}

namespace detail {

/// Whether the vector field of H is that of a Hamiltonian. A scene with forces of its own has gradient(),
/// which all steppers take, and says no: `bool is_symplectic() const`.
template <class H>
constexpr bool is_symplectic([[maybe_unused]] const H& h) {
  if constexpr (requires {
                  { h.is_symplectic() } -> std::convertible_to<bool>;
                })
    return h.is_symplectic();
  else
    return true;
}

/// Throws std::invalid_argument, in the name of `who`, unless H is a Hamiltonian in truth; `instead` is the
/// remedy.
template <class H>
void require_symplectic(const H& h, const std::string& who, const std::string& instead) {
  if (!is_symplectic(h))
    throw std::invalid_argument(who +
                                ": the scene has an effect with a force of its own (OnMotion), and is no "
                                "Hamiltonian system; " +
                                instead);
}

/// One gradient call with each column wherever it lies. Every stepper calls gradient() by it.
template <class H>
SEMIEXPLICIT_INLINE SEMIEXPLICIT_INLINE_CALLS void gradient_at(const H& hamiltonian,
                                                               const typename H::Scalar* q,
                                                               const typename H::Scalar* p,
                                                               typename H::Scalar* dHdq,
                                                               typename H::Scalar* dHdp, Eigen::Index dof) {
  const InColumn<H> at_q(q, dof), at_p(p, dof);
  OutColumn<H> by_q(dHdq, dof), by_p(dHdp, dof);
  hamiltonian.gradient(at_q, at_p, by_q, by_p);
}

/// One gradient call at the contiguous phase point `at`, written to the contiguous pair (∂H/∂q, ∂H/∂p).
template <class H>
SEMIEXPLICIT_INLINE SEMIEXPLICIT_INLINE_CALLS void gradient_at(const H& hamiltonian,
                                                               const typename H::Scalar* at,
                                                               typename H::Scalar* gradient,
                                                               Eigen::Index dof) {
  gradient_at(hamiltonian, at, at + dof, gradient, gradient + dof, dof);
}

}  // namespace detail

/// A Hamiltonian made of two callables; see make_hamiltonian().
template <class ScalarType, int DofValue, class Energy, class Gradient>
class LambdaHamiltonian {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;

  using Read = const In<Scalar, Dof>&;
  using Written = Out<Scalar, Dof>&;
  static_assert(!detail::takes_time_last<false, Energy, Read, Read, const Scalar&>() &&
                    !detail::takes_time_last<false, Gradient, Read, Read, Written, Written, const Scalar&>(),
                "make_hamiltonian: a function takes a number behind the others, which would always be its "
                "default; one that depends on the time is a class, see Autonomous");
  static_assert(
      !detail::is_answer<detail::ResultOf<Gradient, Read, Read, Written, Written>>,
      "make_hamiltonian: the gradient returns a bool, an int or a Status, and nobody asks: let it return "
      "nothing, and throw, or write NaN, where there is none");
  static_assert(!detail::is_narrower<detail::ResultOf<Energy, Read, Read>, Scalar>,
                "make_hamiltonian: the energy is a whole number, or one of fewer digits than Scalar: let it "
                "return a Scalar");

  LambdaHamiltonian(Eigen::Index dof, Energy energy, Gradient gradient)
      : dof_(dof), energy_(std::move(energy)), gradient_(std::move(gradient)) {
    if (dof < 1)
      throw std::invalid_argument("make_hamiltonian: " + std::to_string(dof) +
                                  " degrees of freedom; give one or more");
  }

  Eigen::Index dof() const { return dof_; }
  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const { return energy_(q, p); }
  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                Out<Scalar, Dof> dHdp) const {
    gradient_(q, p, dHdq, dHdp);
  }

 private:
  Eigen::Index dof_;
  Energy energy_;
  Gradient gradient_;
};

/// A Hamiltonian from two lambdas, with its size fixed at compile time:
///
///     auto H = make_hamiltonian<double, 1>(
///         [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; },
///         [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
///           dHdq[0] = q[0] * (p[0] * p[0] + 1);
///           dHdp[0] = p[0] * (q[0] * q[0] + 1);
///         });
template <class Scalar, int Dof, class Energy, class Gradient>
requires(Dof > 0) auto make_hamiltonian(Energy energy, Gradient gradient) {
  return LambdaHamiltonian<Scalar, Dof, Energy, Gradient>(Dof, std::move(energy), std::move(gradient));
}

/// The same with the size `dof` known at run time: `make_hamiltonian<double>(n, energy, gradient)`. Throws
/// std::invalid_argument where it is below one.
template <class Scalar, class Energy, class Gradient>
auto make_hamiltonian(Eigen::Index dof, Energy energy, Gradient gradient) {
  return LambdaHamiltonian<Scalar, Eigen::Dynamic, Energy, Gradient>(dof, std::move(energy),
                                                                     std::move(gradient));
}

}  // namespace semiexplicit
