#pragma once

#include <type_traits>

#include <semiexplicit/core/hamiltonian.hpp>

// What the library says of a class that is no Hamiltonian, in one line: the mistake and the remedy. A class
// or a function that takes an H takes Scalar and Dof from HamiltonianDoor<H>, so that this line is the
// compiler's first error.

namespace semiexplicit::detail {

/// The parameters of a member function that is neither overloaded nor a template.
template <class F>
struct Parameters {
  static constexpr bool known = false;
};
template <class R, class Q, class P, class OutQ, class OutP>
struct Parameters<R(Q, P, OutQ, OutP)> {
  static constexpr bool known = true;
  using First = Q;
  using Output = OutQ;
  using LastOutput = OutP;
};
#define SEMIEXPLICIT_PARAMETERS_OF(qualifiers)                          \
  template <class R, class C, class Q, class P, class OutQ, class OutP> \
  struct Parameters<R (C::*)(Q, P, OutQ, OutP) qualifiers> : Parameters<R(Q, P, OutQ, OutP)> {};
SEMIEXPLICIT_PARAMETERS_OF()
SEMIEXPLICIT_PARAMETERS_OF(noexcept)
SEMIEXPLICIT_PARAMETERS_OF(const)
SEMIEXPLICIT_PARAMETERS_OF(const noexcept)
SEMIEXPLICIT_PARAMETERS_OF(const&)
SEMIEXPLICIT_PARAMETERS_OF(const& noexcept)
#undef SEMIEXPLICIT_PARAMETERS_OF
template <class R, class Q, class P, class OutQ, class OutP, bool Noexcept>
struct Parameters<R (*)(Q, P, OutQ, OutP) noexcept(Noexcept)> : Parameters<R(Q, P, OutQ, OutP)> {};

template <class H>
concept NamesGradient = requires {
  &H::gradient;
};
template <class H>
struct GradientParameters : Parameters<void> {};
template <NamesGradient H>
struct GradientParameters<H> : Parameters<decltype(&H::gradient)> {};
/// Of a Hamiltonian made of two lambdas, the second's, which may be generic in q and p.
template <class Scalar, int Dof, class Energy, class Gradient>
requires requires { &Gradient::template operator()<In<Scalar, Dof>, In<Scalar, Dof>>; }
struct GradientParameters<LambdaHamiltonian<Scalar, Dof, Energy, Gradient>>
    : Parameters<decltype(&Gradient::template operator()<In<Scalar, Dof>, In<Scalar, Dof>>)> {};
template <class Scalar, int Dof, class Energy, class Gradient>
requires requires { &Gradient::operator(); }
struct GradientParameters<LambdaHamiltonian<Scalar, Dof, Energy, Gradient>>
    : Parameters<decltype(&Gradient::operator())> {};

/// An Eigen matrix by value: what is written into it is lost.
template <class T>
inline constexpr bool is_matrix_by_value =
    !std::is_reference_v<T> &&
    std::is_base_of_v<Eigen::PlainObjectBase<std::remove_cv_t<T>>, std::remove_cv_t<T>>;
template <class T>
requires(!std::is_class_v<std::remove_cv_t<T>>) inline constexpr bool is_matrix_by_value<T> = false;

/// A column of a number of entries that is fixed and not H::Dof, or of other numbers.
template <class T, class H>
constexpr bool does_not_fit() {
  using Column = std::remove_cvref_t<T>;
  if constexpr (requires {
                  Column::RowsAtCompileTime;
                  typename Column::Scalar;
                })
    return !std::same_as<typename Column::Scalar, typename H::Scalar> ||
           (H::Dof != Eigen::Dynamic && Column::RowsAtCompileTime != Eigen::Dynamic &&
            Column::RowsAtCompileTime != H::Dof);
  else
    return false;
}
template <class H>
constexpr bool gradient_does_not_fit() {
  using Found = GradientParameters<H>;
  if constexpr (Found::known)
    return does_not_fit<typename Found::First, H>() || does_not_fit<typename Found::Output, H>();
  else
    return false;
}
template <class Found>
constexpr bool writes_into_copies() {
  if constexpr (Found::known)
    return is_matrix_by_value<typename Found::Output> || is_matrix_by_value<typename Found::LastOutput>;
  else
    return false;
}

template <class H>
concept HasMutableGradient = requires(H& h, const InColumn<H>& q, const InColumn<H>& p, OutColumn<H>& dHdq,
                                      OutColumn<H>& dHdp) {
  h.gradient(q, p, dHdq, dHdp);
};
template <class H>
concept HasMutableEnergy = requires(H& h, const InColumn<H>& q, const InColumn<H>& p) {
  h.energy(q, p);
};
template <class H>
concept NamesEnergy = requires {
  &H::energy;
};
/// Dof is there, but may be no constant.
template <class H>
concept NamesDof = requires(H& h) {
  h.Dof;
};

/// Compiles for a Hamiltonian, and what it gives is true. For anything else the compiler says what is
/// missing, and how to write it; of several mistakes the first.
template <class H>
consteval bool is_hamiltonian() {
  if constexpr (!HasScalar<H>) {
    static_assert(
        HasScalar<H>,
        "this Hamiltonian does not say what it computes with: write `using Scalar = double;` in it, public");
    return false;
  } else if constexpr (!HasDof<H>) {
    static_assert(NamesDof<H>,
                  "this Hamiltonian does not say how many degrees of freedom it has: write `static "
                  "constexpr int Dof = 2;` in it, or Eigen::Dynamic");
    static_assert(!NamesDof<H>,
                  "the Dof of this Hamiltonian is no constant above 0: write `static constexpr int Dof = "
                  "2;`, or Eigen::Dynamic");
    return false;
  } else if constexpr (H::Dof == Eigen::Dynamic && !HasRuntimeDof<H>) {
    static_assert(HasRuntimeDof<H>,
                  "a Hamiltonian with Dof = Eigen::Dynamic says its size at run time: write `Eigen::Index "
                  "dof() const { return n; }` in it");
    return false;
  } else if constexpr (gradient_does_not_fit<H>()) {  // before a call is tried: Eigen's own errors come first
                                                      // then
    static_assert(!gradient_does_not_fit<H>(),
                  "the gradient of this Hamiltonian takes columns of another size or of other numbers than "
                  "its Dof and Scalar: write In<Scalar, Dof> and Out<Scalar, Dof>");
    return false;
  } else if constexpr (TimeDependentHamiltonian<H>) {
    static_assert(DependsOnTimeSoWrapItInAutonomous<H> && !TimeDependentHamiltonian<H>,
                  "this Hamiltonian depends on the time: give the stepper Autonomous(H), see "
                  "time/autonomous.hpp");
    return false;
  } else if constexpr (!HasGradient<H>) {
    static_assert(!HasMutableGradient<H>,
                  "the gradient of this Hamiltonian is not const: write `const` behind its parameters");
    if constexpr (!HasMutableGradient<H>) {
      static_assert(!NamesGradient<H>,
                    "the gradient of this Hamiltonian takes other arguments: write `void "
                    "gradient(In<Scalar, Dof> q, In<Scalar, Dof> p, Out<Scalar, Dof> dHdq, "
                    "Out<Scalar, Dof> dHdp) const`, no Vector& (it would need a copy)");
      static_assert(NamesGradient<H>,
                    "this Hamiltonian has no public gradient of (q, p): write `void gradient(In<Scalar, "
                    "Dof> q, In<Scalar, Dof> p, Out<Scalar, Dof> dHdq, Out<Scalar, Dof> dHdp) "
                    "const`, or take from_energy()");
    }
    return false;
  } else if constexpr (writes_into_copies<GradientParameters<H>>()) {
    static_assert(!writes_into_copies<GradientParameters<H>>(),
                  "the gradient of this Hamiltonian takes dHdq or dHdp by value, so what it writes is lost: "
                  "take both as Out<Scalar, Dof>");
    return false;
  } else {
    static_assert(std::copy_constructible<H>,
                  "a Hamiltonian is copied into the stepper, and this one cannot be: give it a copy "
                  "constructor, or hold what cannot be copied by a std::shared_ptr");
    return std::copy_constructible<H>;
  }
}

/// The same for the energy, which some functions need: H(q, p), const, a number.
template <class H>
consteval bool has_energy() {
  if constexpr (HasEnergy<H>) {
    return true;
  } else if constexpr (is_hamiltonian<H>()) {
    static_assert(!HasMutableEnergy<H>,
                  "the energy of this Hamiltonian is not const, or no number: write `Scalar "
                  "energy(In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
    if constexpr (!HasMutableEnergy<H>) {
      static_assert(!NamesEnergy<H>,
                    "the energy of this Hamiltonian takes other arguments: write `Scalar "
                    "energy(In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
      static_assert(NamesEnergy<H>,
                    "this Hamiltonian has no public energy, by which the run is to be judged: write `Scalar "
                    "energy(In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
    }
    return false;
  } else {
    return false;
  }
}

/// Scalar and Dof of a Hamiltonian. Of a class that is none the compiler says why, and goes on with these.
template <class H, bool = is_hamiltonian<H>()>
struct HamiltonianDoor {
  using Scalar = double;
  static constexpr int Dof = 1;
};
template <class H>
struct HamiltonianDoor<H, true> {
  using Scalar = typename H::Scalar;
  static constexpr int Dof = H::Dof;
};

/// The same of a Hamiltonian whose energy is needed.
template <class H, bool = has_energy<H>()>
struct EnergyDoor : HamiltonianDoor<H> {};

}  // namespace semiexplicit::detail
