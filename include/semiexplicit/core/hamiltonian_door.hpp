#pragma once

#include <functional>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/ranks.hpp>

// What the library says of a class that is no Hamiltonian, in one line: the mistake and the remedy. A class
// or a function that takes an H takes Scalar and Dof from HamiltonianDoor<H>, so that this line is the
// compiler's first error.

namespace semiexplicit::detail {

template <class H>
concept NamesGradient = requires {
  &H::gradient;
};
template <class H>
struct GradientParameters : Parameters<void> {};
template <NamesGradient H>
struct GradientParameters<H> : Parameters<decltype(&H::gradient)> {};
/// Of a lambda, what it deduces taken as O, which it can read and write; of a function, its own.
template <class G, class O>
consteval auto parameters_of_lambda() {
  if constexpr (std::is_pointer_v<G>)
    return Parameters<G>{};
  else if constexpr (requires { &G::operator(); })
    return Parameters<decltype(&G::operator())>{};
  else if constexpr (requires { &G::template operator()<O>; })
    return Parameters<decltype(&G::template operator()<O>)>{};
  else if constexpr (requires { &G::template operator()<O, O>; })
    return Parameters<decltype(&G::template operator()<O, O>)>{};
  else if constexpr (requires { &G::template operator()<O, O, O>; })
    return Parameters<decltype(&G::template operator()<O, O, O>)>{};
  else
    return Parameters<void>{};
}
/// Of a Hamiltonian made of two lambdas, the second's.
template <class Scalar, int Dof, class Energy, class Gradient>
struct GradientParameters<LambdaHamiltonian<Scalar, Dof, Energy, Gradient>>
    : decltype(parameters_of_lambda<std::remove_cvref_t<std::unwrap_reference_t<Gradient>>,
                                    Out<Scalar, Dof>>()) {};

/// A column of a number of entries that is fixed and not H::Dof, or of other numbers.
template <class T, class H>
constexpr bool does_not_fit() {
  using Column = std::remove_cvref_t<T>;
  if constexpr (requires {
                  Column::SizeAtCompileTime;
                  typename Column::Scalar;
                })
    return !std::same_as<typename Column::Scalar, typename H::Scalar> ||
           !sizes_may_agree(Column::SizeAtCompileTime, H::Dof);
  else
    return false;
}
template <class H>
constexpr bool gradient_does_not_fit() {
  using Found = GradientParameters<H>;
  if constexpr (Found::count >= 4)
    return does_not_fit<typename Found::template FromLast<3>, H>() ||
           does_not_fit<typename Found::template FromLast<1>, H>();
  else
    return false;
}
/// The time, or another number, behind the outputs, where a default stands in for it.
template <class H>
constexpr bool gradient_ends_with_a_number() {
  return ends_with_a_number<4>(pointer_to_gradient<H, OutColumn<H>>());
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
/// An energy(q, p) of columns that do not fit, as far as its type tells.
template <class H>
constexpr bool energy_does_not_fit() {
  if constexpr (HasScalar<H> && HasDof<H> && NamesEnergy<H>) {
    using Found = Parameters<decltype(&H::energy)>;
    if constexpr (Found::count == 2)
      return does_not_fit<typename Found::template FromLast<1>, H>() ||
             does_not_fit<typename Found::template FromLast<0>, H>();
  }
  return false;
}
/// Dof is there, but may be no constant.
template <class H>
concept NamesDof = requires(H& h) {
  h.Dof;
};

template <class H>
concept SaysSeparableByFunction = requires {
  requires points_to_function<decltype(&H::separable)>;
};
/// It sums over ranks as far as its caller can tell, but not as SumsOverRanks asks for, or in other numbers.
template <class H>
concept SumsOverRanksOtherwise = !requires(const H& h, const typename H::Scalar& x) {
  requires std::same_as < std::remove_cvref_t<decltype(h.sum_over_ranks(x))>,
  typename H::Scalar > ;
}
&&(
    requires { &H::sum_over_ranks; } || requires(H & h, typename H::Scalar& x) { h.sum_over_ranks(x); });

/// Whether all four are deduced, so that none is by value but what still writes to where it is. It is not
/// tried with other types then: the body of a function whose return type is deduced would have to compile
/// with them.
template <class H>
constexpr bool deduces_all = requires {
  &H::template gradient<InColumn<H>, InColumn<H>, OutColumn<H>, OutColumn<H>>;
};

/// Compiles where the gradient, with the time or without, writes into what it is given, as far as its type
/// tells.
template <class H>
consteval bool gradient_writes() {
  using At = const InColumn<H>&;
  const auto of_point = [](const auto& h, auto& out) -> decltype(h.gradient(std::declval<At>(),
                                                                            std::declval<At>(), out, out)) {};
  const auto of_time = [](const auto& h, auto& out) -> decltype(h.gradient(
                                                        std::declval<const typename H::Scalar&>(),
                                                        std::declval<At>(), std::declval<At>(), out, out)) {};
  constexpr bool copies = [&] {
    if constexpr (deduces_all<H>)
      return false;
    else
      return writes_into_copies<GradientParameters<H>, 2>() ||
             loses_output<decltype(of_point), H, OutColumn<H>>() ||
             loses_output<decltype(of_time), H, OutColumn<H>>();
  }();
  static_assert(!copies,
                "the gradient of this Hamiltonian takes dHdq or dHdp by value, so what it writes is lost: "
                "take both as Out<Scalar, Dof>");
  using OfTime = ResultOf<decltype(of_time), H&, OutColumn<H>&>;  // a number is to be dH/dt; see Autonomous
  constexpr bool answered = answers<decltype(of_point), H, OutColumn<H>>() || std::is_same_v<OfTime, bool> ||
                            std::is_enum_v<OfTime>;
  static_assert(
      !answered,
      "the gradient of this Hamiltonian returns a bool, an int or a Status, and nobody asks: let it return "
      "nothing, and throw, or write NaN, where there is none");
  return !copies && !answered;
}
/// What is wrong with the outputs of the members that a Hamiltonian may have.
template <class H>
constexpr OutputFaults faults_of_optional_members() {
  using At = const InColumn<H>&;
  using Hessian = Eigen::Matrix<typename H::Scalar, twice(H::Dof), twice(H::Dof)>;
  const auto hessian = [](const auto& h,
                          auto& out) -> decltype(h.hessian(std::declval<At>(), std::declval<At>(), out)) {};
  const auto product = [](const auto& h, auto& out) -> decltype(h.hessian_times(
                                                        std::declval<At>(), std::declval<At>(),
                                                        std::declval<At>(), std::declval<At>(), out, out)) {};
  const auto position = [](const auto& h,
                           auto& out) -> decltype(h.position_gradient(std::declval<At>(), out)) {};
  const auto momentum = [](const auto& h,
                           auto& out) -> decltype(h.momentum_gradient(std::declval<At>(), out)) {};
  return output_faults<decltype(hessian), H, Hessian>() |
         output_faults<decltype(product), H, OutColumn<H>>() |
         output_faults<decltype(position), H, OutColumn<H>>() |
         output_faults<decltype(momentum), H, OutColumn<H>>();
}
/// Whether one of them takes a number behind its outputs, where a default stands in for it.
template <class H>
constexpr bool optional_member_ends_with_a_number() {
  return ends_with_a_number<2>(pointer_to_position_gradient<H, OutColumn<H>>()) ||
         ends_with_a_number<2>(pointer_to_momentum_gradient<H, OutColumn<H>>());
}

/// Compiles unless H has a hessian or a hessian_times that cannot be called, which second derivatives by
/// differences would hide.
template <class H>
consteval bool second_derivatives_can_be_called() {
  using Matrix = Eigen::Matrix<typename H::Scalar, twice(H::Dof), twice(H::Dof)>;
  constexpr bool hessian = HasHessian<H> || !(
                                                requires { &H::hessian; } ||
                                                requires(H & h, const InColumn<H>& at, Matrix& result) {
                                                  h.hessian(at, at, result);
                                                });
  constexpr bool times = HasHessianTimes<H> || !(
                                                   requires { &H::hessian_times; } ||
                                                   requires(H & h, const InColumn<H>& at, OutColumn<H>& out) {
                                                     h.hessian_times(at, at, at, at, out, out);
                                                   });
  static_assert(
      hessian,
      "hessian of this Hamiltonian cannot be called: write `void hessian(In<Scalar, Dof> q, "
      "In<Scalar, Dof> p, Eigen::Ref<Matrix> result) const`, Matrix being of 2 Dof rows and columns, "
      "or give it another name");
  static_assert(times,
                "hessian_times of this Hamiltonian cannot be called: write `void hessian_times(In<Scalar, "
                "Dof> q, In<Scalar, Dof> p, In<Scalar, Dof> dq, In<Scalar, Dof> dp, Out<Scalar, Dof> hq, "
                "Out<Scalar, Dof> hp) const`, or give it another name");
  return hessian && times;
}

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
  } else if constexpr (gradient_ends_with_a_number<H>()) {
    static_assert(
        !gradient_ends_with_a_number<H>(),
        "the gradient of this Hamiltonian ends with a number, which would always be its default: the "
        "time comes first, `void gradient(const Scalar& t, In<Scalar, Dof> q, ...) const`");
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
  } else if constexpr (gradient_writes<H>()) {
    static_assert(std::copy_constructible<H>,
                  "a Hamiltonian is copied into the stepper, and this one cannot be: give it a copy "
                  "constructor, or hold what cannot be copied by a std::shared_ptr");
    constexpr OutputFaults faults = faults_of_optional_members<H>();
    static_assert(!faults.lost,
                  "hessian, hessian_times, position_gradient or momentum_gradient of this Hamiltonian takes "
                  "an output by value, so what it writes is lost: take it as Out<Scalar, Dof>, a Hessian as "
                  "Eigen::Ref");
    static_assert(!SaysSeparableByFunction<H>,
                  "separable of this Hamiltonian is a function: write `static constexpr bool separable = "
                  "true;`");
    static_assert(
        !faults.answered,
        "hessian, hessian_times, position_gradient or momentum_gradient of this Hamiltonian returns a "
        "bool, an int or a Status, and nobody asks: let it return nothing, and throw, or write NaN, where "
        "there is none");
    static_assert(
        !optional_member_ends_with_a_number<H>(),
        "position_gradient or momentum_gradient of this Hamiltonian ends with a number, which would "
        "always be its default: leave it out");
    static_assert(!SumsOverRanksOtherwise<H>,
                  "sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const "
                  "Scalar& x) const`");
    return std::copy_constructible<H>;
  } else {
    return false;
  }
}

/// The same for one that depends on the time, which Autonomous takes.
template <class H>
consteval bool is_time_dependent() {
  if constexpr (!HasScalar<H> || !HasDof<H> || gradient_does_not_fit<H>() ||
                gradient_ends_with_a_number<H>()) {
    return is_hamiltonian<H>();
  } else if constexpr (TimeDependentHamiltonian<H>) {
    using Scalar = typename H::Scalar;
    constexpr bool rounded = rounds<Scalar, 5, 0>(pointer_to_gradient<H, OutColumn<H>>()) ||
                             rounds<Scalar, 3, 0>(pointer_to_energy<H, InColumn<H>>()) ||
                             rounds<Scalar, 3, 0>(pointer_to_time_derivative<H, InColumn<H>>());
    static_assert(!rounded,
                  "gradient, energy or time_derivative of this Hamiltonian takes the time as a whole number, "
                  "or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`");
    return gradient_writes<H>() && !rounded;
  } else {
    static_assert(!Hamiltonian<H>,
                  "this Hamiltonian does not depend on the time: give the stepper H itself, not "
                  "Autonomous(H)");
    static_assert(Hamiltonian<H>,
                  "the gradient of this Hamiltonian cannot be called with the time: write `void "
                  "gradient(const Scalar& t, In<Scalar, Dof> q, In<Scalar, Dof> p, Out<Scalar, Dof> dHdq, "
                  "Out<Scalar, Dof> dHdp) const`, and dof() where Dof is Eigen::Dynamic");
    return false;
  }
}

/// The same for the energy, which some functions need: H(q, p), const, a number.
template <class H>
consteval bool has_energy() {
  if constexpr (energy_does_not_fit<H>()) {
    static_assert(
        !energy_does_not_fit<H>(),
        "the energy of this Hamiltonian takes columns of another size or of other numbers than its Dof "
        "and Scalar: write `Scalar energy(In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
    return false;
  } else if constexpr (HasEnergy<H>) {
    using Column = InColumn<H>;
    using At = const Column&;
    const auto energy = [](const auto& h) -> decltype(h.energy(std::declval<At>(), std::declval<At>())) {};
    constexpr bool narrow = is_narrower<ResultOf<decltype(energy), const H&>, typename H::Scalar>;
    static_assert(
        !narrow,
        "the energy of this Hamiltonian is a whole number, or one of fewer digits than Scalar: let it "
        "return a Scalar");
    constexpr bool longer = ends_with_a_number<2>(pointer_to_energy<H, Column>());
    static_assert(!longer,
                  "the energy of this Hamiltonian ends with a number, which would always be its default: the "
                  "time comes first, `Scalar energy(const Scalar& t, In<Scalar, Dof> q, ...) const`");
    return !narrow && !longer;
  } else if constexpr (is_hamiltonian<H>()) {
    static_assert(!InExtendedPhaseSpace<H>,
                  "of this driven Hamiltonian there is no K to judge a run by: write `Scalar energy(const "
                  "Scalar& t, In<Scalar, Dof> q, In<Scalar, Dof> p) const`, and let the gradient return "
                  "dH/dt");
    static_assert(!HasMutableEnergy<H>,
                  "the energy of this Hamiltonian is not const, or no number: write `Scalar "
                  "energy(In<Scalar, Dof> q, In<Scalar, Dof> p) const`");
    if constexpr (!HasMutableEnergy<H> && !InExtendedPhaseSpace<H>) {
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

/// The same of a Hamiltonian that depends on the time.
template <class H, bool = is_time_dependent<H>()>
struct TimeDependentDoor : HamiltonianDoor<H, false> {};
template <class H>
struct TimeDependentDoor<H, true> : HamiltonianDoor<H, true> {};

/// The same of a Hamiltonian whose energy is needed.
template <class H, bool = has_energy<H>()>
struct EnergyDoor : HamiltonianDoor<H> {};

}  // namespace semiexplicit::detail
