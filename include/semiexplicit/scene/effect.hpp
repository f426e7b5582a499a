#pragma once

#include <concepts>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/parameters.hpp>

namespace semiexplicit {

/// What an effect, one term of a Hamiltonian, acts on. An effect names one of these as its `Acts`, which also
/// fixes the number type and the degrees of freedom, and gives the two members that belong to it:
///
///     OnPosition   energy(q)      add_gradient(q, dHdq)            a potential V(q)
///     OnMomentum   energy(p)      add_gradient(p, dHdp)            a kinetic energy T(p)
///     OnEach       energy(x)      add_gradient(x, dHdx)            e(q) + e(p), the same function of both
///     OnBoth       energy(q, p)   add_gradient(q, p, dHdq, dHdp)   what couples them
///     OnMotion     no energy      add_force(q, p, force)           a force of its own in dp/dt, F(q, p)
///
/// Only OnBoth and OnMotion make a scene non-separable. OnMotion is what is not a Hamiltonian (drag,
/// radiation reaction): the same steppers integrate it, to their order, but the motion is not symplectic
/// then, and the energy changes by the work of these forces, of which Books keeps account. A whole effect,
/// with the name by which programs and audits call it:
///
///     struct Trap {  // k|q|²/2
///       using Acts = OnPosition<double, 2>;
///       static constexpr const char* name = "trap";
///       double k = 1;
///       double energy(const auto& q) const { return k * (q[0] * q[0] + q[1] * q[1]) / 2; }
///       void add_gradient(const auto& q, auto& dHdq) const {
///         dHdq[0] += k * q[0];
///         dHdq[1] += k * q[1];
///       }
///     };
///
/// A gradient is added to what is there. q, p and the rest are Eigen columns of length Dof. The effects of
/// this library ask only for q[i], and compute in the type that this has: double, long double, packs of
/// numbers; types with expression templates (Boost's et_on) will not do. An effect of dynamic size also has
/// `Eigen::Index dof() const`. One line for lists, `static constexpr const char* about`, is optional, and so
/// is `std::vector<double> scene_constants() const`, the masses or circulations that it holds: a scene
/// refuses effects that hold other ones.
template <class ScalarType, int DofValue>
struct OnPosition {
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
};
/// See OnPosition.
template <class ScalarType, int DofValue>
struct OnMomentum : OnPosition<ScalarType, DofValue> {};
/// See OnPosition.
template <class ScalarType, int DofValue>
struct OnEach : OnPosition<ScalarType, DofValue> {};
/// See OnPosition.
template <class ScalarType, int DofValue>
struct OnBoth : OnPosition<ScalarType, DofValue> {};
/// See OnPosition.
template <class ScalarType, int DofValue>
struct OnMotion : OnPosition<ScalarType, DofValue> {};

namespace detail {

/// E says what it acts on: `using Acts = OnPosition<double, 2>;` or OnMomentum, OnEach, OnBoth, OnMotion.
template <class E>
concept HasActs = requires {
  typename E::Acts::Scalar;
  E::Acts::Dof;
};

template <class E, template <class, int> class Kind>
concept ActsAs = std::same_as<typename E::Acts, Kind<typename E::Acts::Scalar, E::Acts::Dof>>;

template <class E>
using EffectScalar = typename E::Acts::Scalar;
template <class E>
using EffectIn = In<EffectScalar<E>, E::Acts::Dof>;
template <class E>
using EffectOut = Out<EffectScalar<E>, E::Acts::Dof>;

/// The two members of an effect on one half.
template <class E>
concept HasHalfMembers = requires(const E& effect, const EffectIn<E>& x, EffectOut<E>& dHdx) {
  { effect.energy(x) } -> std::convertible_to<EffectScalar<E>>;
  effect.add_gradient(x, dHdx);
};

/// The two members of an effect on both halves together.
template <class E>
concept HasCoupledMembers = requires(const E& effect, const EffectIn<E>& q, const EffectIn<E>& p,
                                     EffectOut<E>& dHdq, EffectOut<E>& dHdp) {
  { effect.energy(q, p) } -> std::convertible_to<EffectScalar<E>>;
  effect.add_gradient(q, p, dHdq, dHdp);
};

/// The member of an effect that adds a force.
template <class E>
concept HasForce = requires(const E& effect, const EffectIn<E>& q, const EffectIn<E>& p,
                            EffectOut<E>& force) {
  effect.add_force(q, p, force);
};

}  // namespace detail

/// An effect that acts OnPosition, OnMomentum, OnEach, OnBoth or OnMotion, with the members that belong to
/// it.
template <class E>
concept PositionEffect = detail::ActsAs<E, OnPosition> && detail::HasHalfMembers<E>;
template <class E>
concept MomentumEffect = detail::ActsAs<E, OnMomentum> && detail::HasHalfMembers<E>;
template <class E>
concept EachEffect = detail::ActsAs<E, OnEach> && detail::HasHalfMembers<E>;
template <class E>
concept CoupledEffect = detail::ActsAs<E, OnBoth> && detail::HasCoupledMembers<E>;

template <class E>
concept MotionEffect = detail::ActsAs<E, OnMotion> && detail::HasForce<E>;

/// An effect of any of the five kinds.
template <class E>
concept Effect =
    PositionEffect<E> || MomentumEffect<E> || EachEffect<E> || CoupledEffect<E> || MotionEffect<E>;

namespace detail {

/// Whether it depends on q and p in a way that no sum of functions of one does.
template <class E>
inline constexpr bool couples = CoupledEffect<E> || MotionEffect<E>;

/// The name of an effect: `static constexpr const char* name`, or a member function `name()`. Throws
/// std::invalid_argument for nullptr.
template <class E>
std::string effect_name(const E& effect) {
  const auto in_words = [](const auto& name) {
    if constexpr (std::convertible_to<decltype(name), const char*>)
      if (static_cast<const char*>(name) == nullptr)
        throw std::invalid_argument("the name of an effect is nullptr; give it one, \"wind\" say");
    return std::string(std::string_view(name));
  };
  if constexpr (requires { effect.name(); })
    return in_words(effect.name());
  else
    return in_words(effect.name);
}

template <class E>
concept HasEffectDof = requires(const E& effect) {
  { effect.dof() } -> std::convertible_to<Eigen::Index>;
};

template <class E>
concept NamesEffectDof = requires {
  requires std::is_member_function_pointer_v<decltype(&E::dof)>;
}
|| requires(E& effect) { effect.dof(); };

template <class E>
concept HasSceneConstants = requires(const E& effect) {
  { effect.scene_constants() } -> std::same_as<std::vector<double>>;
};

template <class E>
concept NamesSceneConstants = requires {
  requires std::is_member_function_pointer_v<decltype(&E::scene_constants)>;
}
|| requires(E& effect) { effect.scene_constants(); };

/// How many degrees of freedom an effect is made for. One of fixed size may know better than its type, as of
/// how many bodies it holds.
template <class E>
Eigen::Index effect_dof(const E& effect) {
  if constexpr (HasEffectDof<E>)
    return effect.dof();
  else
    return E::Acts::Dof;
}

/// What the effects of one scene have to agree on, where they hold any: masses, circulations.
class SameConstants {
 public:
  explicit SameConstants(const char* who) : who_(who) {}

  /// Throws std::invalid_argument where this effect holds others than the first one that holds any.
  template <class E>
  void see(const E& effect) {
    if constexpr (HasSceneConstants<E>) {
      std::vector<double> constants = effect.scene_constants();
      if (constants.empty()) return;
      if (first_.empty()) {
        first_ = std::move(constants);
        name_ = effect_name(effect);
      } else if (constants != first_) {
        throw std::invalid_argument(std::string(who_) + ": the effects " + name_ + " and " +
                                    effect_name(effect) +
                                    " have other masses or circulations; give both the same ones");
      }
    }
  }

 private:
  const char* who_;
  std::string name_{};
  std::vector<double> first_{};
};

/// One line on an effect, or nothing.
template <class E>
std::string effect_about(const E& effect) {
  if constexpr (requires { effect.about; })
    return effect.about;
  else
    return "";
}

/// E::Acts; for what has none anything, so that the one error of is_effect() is not followed by others.
template <class E>
struct ActsOf {
  using Type = OnPosition<double, 1>;
};
template <HasActs E>
struct ActsOf<E> {
  using Type = typename E::Acts;
};

template <class E>
concept HasName = requires(const E& effect) {
  { effect.name() } -> std::convertible_to<std::string_view>;
}
|| requires(const E& effect) {
  { effect.name } -> std::convertible_to<std::string_view>;
};

/// What is wrong with the output of what an effect adds.
template <class E>
constexpr OutputFaults faults_of_added() {
  using At = const EffectIn<E>&;
  using Column = Vector<EffectScalar<E>, E::Acts::Dof>;
  const auto force = [](const auto& h,
                        auto& out) -> decltype(h.add_force(std::declval<At>(), std::declval<At>(), out)) {};
  const auto both = [](const auto& h, auto& out) -> decltype(h.add_gradient(std::declval<At>(),
                                                                            std::declval<At>(), out, out)) {};
  const auto one = [](const auto& h, auto& out) -> decltype(h.add_gradient(std::declval<At>(), out)) {};
  if constexpr (ActsAs<E, OnMotion>)
    return output_faults<decltype(force), E, Column>();
  else if constexpr (ActsAs<E, OnBoth>)
    return output_faults<decltype(both), E, Column>();
  else
    return output_faults<decltype(one), E, Column>();
}
/// Whether one of its members takes a number behind its own, where a default stands in for it.
template <class E>
constexpr bool member_ends_with_a_number() {
  using At = EffectIn<E>;
  using To = EffectOut<E>;
  constexpr std::size_t halves = ActsAs<E, OnBoth> ? 2 : 1;
  if constexpr (ActsAs<E, OnMotion>)
    return ends_with_a_number<3>(pointer_to_add_force<E, To, To, true>());
  else
    return ends_with_a_number<2 * halves>(pointer_to_add_gradient<E, To, To, true>()) ||
           ends_with_a_number<halves>(pointer_to_energy<E, At, At, true>());
}
/// Whether its energy is a whole number, or one of fewer digits.
template <class E>
constexpr bool has_narrow_energy() {
  using At = const EffectIn<E>&;
  const auto energy_of_one = [](const auto& effect) -> decltype(effect.energy(std::declval<At>())) {};
  const auto energy_of_both =
      [](const auto& effect) -> decltype(effect.energy(std::declval<At>(), std::declval<At>())) {};
  using Energy = std::conditional_t<ActsAs<E, OnBoth>, decltype(energy_of_both), decltype(energy_of_one)>;
  return is_narrower<ResultOf<Energy, const E&>, EffectScalar<E>>;
}

/// Compiles for an effect; for what is none the compiler says what is missing, and only that.
template <class E>
consteval bool is_effect() {
  static_assert(HasActs<E>,
                "an effect says what it acts on: using Acts = OnPosition<double, 2>; or OnMomentum, OnEach, "
                "OnBoth, OnMotion");
  static_assert(
      !HasActs<E> || HasName<E>,
      "an effect has a name: static constexpr const char* name = \"wind\"; or std::string name() const");
  if constexpr (HasActs<E>) {
    static_assert(
        !std::is_integral_v<EffectScalar<E>>,
        "this effect computes with whole numbers: write 1.0 for 1, or name its numbers, as <double>");
    if constexpr (ActsAs<E, OnBoth>)
      static_assert(HasCoupledMembers<E>,
                    "an effect OnBoth needs energy(q, p) const and add_gradient(q, p, dHdq, dHdp) const");
    else if constexpr (ActsAs<E, OnMotion>)
      static_assert(HasForce<E>, "an effect OnMotion needs add_force(q, p, force) const");
    else if constexpr (!ActsAs<E, OnPosition> && !ActsAs<E, OnMomentum> && !ActsAs<E, OnEach>)
      static_assert(Effect<E>,
                    "an effect acts as one of five: using Acts = OnPosition<double, 2>; or OnMomentum, "
                    "OnEach, OnBoth, OnMotion, and no type of your own");
    else
      static_assert(HasHalfMembers<E>,
                    "an effect on one half needs energy(x) const and add_gradient(x, dHdx) const");
    static_assert(E::Acts::Dof != Eigen::Dynamic || HasEffectDof<E>,
                  "an effect with Dof = Eigen::Dynamic says its size at run time: write `Eigen::Index dof() "
                  "const { return n; }` in it");
    static_assert(ActsAs<E, OnMotion> || !HasForce<E>,
                  "this effect has a force of its own, add_force, which is asked for OnMotion only: make two "
                  "effects of it, one OnMotion");
    static_assert(
        !ActsAs<E, OnMotion> || (!HasHalfMembers<E> && !HasCoupledMembers<E>),
        "this effect OnMotion has an energy with its gradient, which is not asked: make two effects of "
        "it, the other one OnPosition, OnMomentum, OnEach or OnBoth");
    static_assert(HasEffectDof<E> || !NamesEffectDof<E>,
                  "dof() of this effect cannot be called: write `Eigen::Index dof() const`");
    static_assert(HasSceneConstants<E> || !NamesSceneConstants<E>,
                  "scene_constants() of this effect is not asked: write `std::vector<double> "
                  "scene_constants() const`");
    constexpr OutputFaults faults = faults_of_added<E>();
    static_assert(!faults.lost,
                  "this effect takes by value what it adds to, so that it adds nothing: write `auto& dHdq`, "
                  "or Out<Scalar, Dof>");
    static_assert(!faults.answered,
                  "add_gradient or add_force of this effect returns a bool, an int or a Status, and nobody "
                  "asks: let it return nothing, and throw, or add NaN, where there is none");
    static_assert(
        !member_ends_with_a_number<E>(),
        "a member of this effect ends with a number, which would always be its default: leave it out; "
        "what depends on the time is a Hamiltonian, see Autonomous");
    static_assert(
        !has_narrow_energy<E>(),
        "the energy of this effect is a whole number, or one of fewer digits than its Scalar: let it "
        "return a Scalar");
  }
  return true;
}

// What an effect adds to each half of a gradient; a force of its own counts as -∂H/∂q.
template <class E, class Q, class P, class OutQ, class OutP>
void add_effect(const E& effect, const Q& q, const P& p, OutQ& dHdq, OutP& dHdp) {
  if constexpr (CoupledEffect<E>) {
    effect.add_gradient(q, p, dHdq, dHdp);
  } else if constexpr (MotionEffect<E>) {
    for (Eigen::Index i = 0; i < dHdq.size(); ++i) dHdq[i] = -dHdq[i];
    effect.add_force(q, p, dHdq);
    for (Eigen::Index i = 0; i < dHdq.size(); ++i) dHdq[i] = -dHdq[i];
  } else {
    if constexpr (!MomentumEffect<E>) effect.add_gradient(q, dHdq);
    if constexpr (!PositionEffect<E>) effect.add_gradient(p, dHdp);
  }
}

template <class E, class Q, class P>
auto effect_energy([[maybe_unused]] const E& effect, [[maybe_unused]] const Q& q,
                   [[maybe_unused]] const P& p) {
  if constexpr (CoupledEffect<E>)
    return effect.energy(q, p);
  else if constexpr (MotionEffect<E>)
    return EffectScalar<E>(0);
  else if constexpr (PositionEffect<E>)
    return effect.energy(q);
  else if constexpr (MomentumEffect<E>)
    return effect.energy(p);
  else
    return effect.energy(q) + effect.energy(p);
}

}  // namespace detail
}  // namespace semiexplicit
