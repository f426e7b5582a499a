#pragma once

#include <concepts>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>
#include <semiexplicit/steppers/flow_splitting.hpp>

namespace semiexplicit {

namespace detail {

/// What stands for a scene without effects.
struct NoScene {};

template <class... Effects>
auto scene_of(const std::tuple<Effects...>& effects) {
  if constexpr (sizeof...(Effects) == 0)
    return NoScene{};
  else
    return std::apply([](const Effects&... effect) { return Scene<Effects...>(effect...); }, effects);
}

/// One effect, or none.
template <bool keep, class E>
auto kept(const E& effect) {
  if constexpr (keep)
    return std::tuple<E>(effect);
  else
    return std::tuple<>();
}

/// Compiles for a group of effects that the scene has and that has a flow; else the compiler says what is
/// missing, and only that.
template <class Scalar, int Dof, class... Group, class... Effects>
consteval bool can_be_exact(std::type_identity<Scene<Effects...>>) {
  constexpr bool named = sizeof...(Group) > 0;
  static_assert(named,
                "exactly<...>() names the effects that have an exact flow together: exactly<Kinetic, "
                "Attraction>()");
  if constexpr (named) {
    constexpr bool all = ((count_of < Group, Effects... >> 0) && ...);
    static_assert(all,
                  "exactly<...>() names an effect that the scene does not have; template arguments count: "
                  "Kinetic<double, 2> is not Kinetic<double, 3>");
    constexpr bool once = ((count_of<Group, Effects...> <= 1 && count_of<Group, Group...> == 1) && ...);
    static_assert(!all || once, "exactly<...>() names an effect that is there more than once");
    if constexpr (all && once) {
      using Flow = typename FlowOf<Group...>::Type;
      static_assert(!std::is_void_v<Flow>,
                    "these effects have no exact flow together: specialise semiexplicit::ExactFlow for them, "
                    "see scene/exact_flow.hpp, or name others");
      if constexpr (!std::is_void_v<Flow>) {
        static_assert(
            HasIncrements<Flow, Scalar, Dof>,
            "this ExactFlow has no `Status increments(const Scalar& t, const auto& q, const auto& p, "
            "auto& dq, auto& dp) const`; see scene/exact_flow.hpp");
        using Column = Vector<Scalar, Dof>;
        const auto increments = [](const auto& h, auto& out)
            -> decltype(void(h.increments(std::declval<const Scalar&>(), std::declval<const Column&>(),
                                          std::declval<const Column&>(), out, out))) {};
        static_assert(
            !rounds<Scalar, 5, 0>(pointer_to_increments<Flow, Column>()) &&
                !rounds<Scalar, 1, 0>(pointer_to_prepared<Flow, Scalar, Scalar, true>()),
            "increments or prepared of this ExactFlow takes the time as a whole number, or one of fewer "
            "digits than Scalar, which rounds it: write `const Scalar& t`");
        static_assert(!overrides_beside(pointer_to_increments<Flow, Column>(),
                                        pointer_to_prepared<Flow, Scalar, Scalar, true>()),
                      "this ExactFlow has increments() of its own and inherits prepared(), which is asked "
                      "instead: write both");
        static_assert(!ends_with_a_number<5>(pointer_to_increments<Flow, Column>()),
                      "increments of this ExactFlow ends with a number, which would always be its default: "
                      "leave it out");
        static_assert(!loses_output<decltype(increments), Flow, Column>(),
                      "the increments of this ExactFlow take dq or dp by value, so that nothing moves: "
                      "write `auto& dq, auto& dp`, or Vector<Scalar, Dof>&");
        return HasIncrements<Flow, Scalar, Dof>;
      }
    }
  }
  return false;
}

/// A scene in which a group of effects has an exact flow: what FlowSplitting asks for.
template <class Whole, class... Group>
class SplitScene;
template <class... Effects, class... Group>
class SplitScene<Scene<Effects...>, Group...> {
  template <class E>
  static constexpr bool is_rest = count_of<E, Group...> == 0;
  template <class E>
  static constexpr bool is_coupled = is_rest<E>&& couples<E>;
  template <class E>
  static constexpr bool is_kicked = is_rest<E> && !couples<E>;

 public:
  using Whole = Scene<Effects...>;
  static constexpr bool is_symplectic() { return Whole::symplectic; }
  using Scalar = typename Whole::Scalar;
  static constexpr int Dof = Whole::Dof;
  using Flow = typename FlowOf<Group...>::Type;

  static constexpr bool kicks_momenta = ((is_kicked<Effects> && !MomentumEffect<Effects>) || ...);
  static constexpr bool drifts_positions = ((is_kicked<Effects> && !PositionEffect<Effects>) || ...);
  static constexpr bool doubles = (is_coupled<Effects> || ...);
  static constexpr bool flow_is_quadratic = quadratic_in_momenta<Flow>();
  static constexpr bool rest_is_small = detail::rest_is_small<Flow>();

  explicit SplitScene(Whole scene)
      : scene_(std::move(scene)),
        flow_(made(scene_, typename FlowOf<Group...>::Order{})),
        kicked_(kicked_of(scene_)),
        doubled_(doubled_of(scene_)) {}

  /// A flow may refer to the effects that it was made of: that of a copy is made of the copy's.
  SplitScene(const SplitScene& other)
      : scene_(other.scene_),
        flow_(made(scene_, typename FlowOf<Group...>::Order{})),
        kicked_(other.kicked_),
        doubled_(other.doubled_) {}
  SplitScene& operator=(const SplitScene& other) {
    scene_ = other.scene_;
    flow_.emplace(made(scene_, typename FlowOf<Group...>::Order{}));
    kicked_ = other.kicked_;
    doubled_ = other.doubled_;
    return *this;
  }
  ~SplitScene() = default;

  Eigen::Index dof() const { return scene_.dof(); }
  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const { return scene_.energy(q, p); }
  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                Out<Scalar, Dof> dHdp) const {
    scene_.gradient(q, p, dHdq, dHdp);
  }

  template <class X, class DX>
  Status flow(const Scalar& t, const X& q, const X& p, DX& dq, DX& dp) const {
    return flow_->increments(t, q, p, dq, dp);
  }
  auto prepared(const Scalar& t) const requires requires(const Flow& f) { f.prepared(t); }
  { return flow_->prepared(t); }
  std::string flow_name() const {
    std::string text;
    for_each_exact([&](const auto& effect) { text += (text.empty() ? "" : " + ") + effect_name(effect); });
    return text + " (" + Flow::name + ")";
  }
  void rest_position_gradient(const In<Scalar, Dof>& q, Out<Scalar, Dof> dHdq) const requires kicks_momenta {
    kicked_.position_gradient(q, dHdq);
  }
  void rest_momentum_gradient(const In<Scalar, Dof>& p,
                              Out<Scalar, Dof> dHdp) const requires drifts_positions {
    kicked_.momentum_gradient(p, dHdp);
  }
  const auto& coupled_rest() const requires doubles { return doubled_; }

  const Whole& scene() const { return scene_; }
  /// Calls visit(effect) for the effects that are moved exactly.
  template <class Visit>
  void for_each_exact(const Visit& visit) const {
    scene_.for_each([&]<class E>(const E& effect) {
      if constexpr (!is_rest<E>) visit(effect);
    });
  }
  /// And for those that are not.
  template <class Visit>
  void for_each_of_rest(const Visit& visit) const {
    scene_.for_each([&]<class E>(const E& effect) {
      if constexpr (is_rest<E>) visit(effect);
    });
  }

 private:
  template <class... Ordered>
  static Flow made(const Whole& scene, Exactly<Ordered...>) {
    return Flow(std::get<Ordered>(scene.effects())...);
  }
  static auto kicked_of(const Whole& scene) {
    return scene_of(std::apply(
        [](const Effects&... e) { return std::tuple_cat(kept<is_kicked<Effects>>(e)...); }, scene.effects()));
  }
  static auto doubled_of(const Whole& scene) {
    return scene_of(
        std::apply([](const Effects&... e) { return std::tuple_cat(kept<is_coupled<Effects>>(e)...); },
                   scene.effects()));
  }

  Whole scene_;
  std::optional<Flow> flow_;
  decltype(kicked_of(std::declval<const Whole&>())) kicked_;
  decltype(doubled_of(std::declval<const Whole&>())) doubled_;
};

/// The list to begin with.
template <class Split>
NearIntegrable<typename Split::Scalar> usual_list() {
  using Scalar = typename Split::Scalar;
  if constexpr (rest_is_small<typename Split::Flow>())
    return schemes::aba82<Scalar>();
  else if constexpr (has_nystrom_lists<Split>())
    return schemes::blanes_moan_nystrom6<Scalar>();
  else
    return schemes::blanes_moan6<Scalar>();
}

/// What stepper_for gives after an error: nothing more to say.
struct NoStepper {};

}  // namespace detail

/// A stepper that moves a group of effects by their exact flow, on one copy of the phase space, and splits
/// the rest off:
///
///     using namespace effects::orbits;
///     auto stepper = stepper_for(scene, exactly<Kinetic<double, 3>, Attraction<double, 3>>());
///
/// Effects of the rest on q or on p alone are kicks; only what couples q and p is doubled. See FlowSplitting.
/// The list is aba82, of generalised order (8,2), where the rest is small beside the group; where the flow
/// says that it need not be (ExactFlow::rest_is_small), blanes_moan_nystrom6 for potentials (see
/// NearIntegrable) and blanes_moan6 for all else, which is of order 6 for a rest on p alone and of order 2
/// for one of several parts or a coupled one (see FlowSplitting). Another list, or a Scheme, may be given:
/// aba864 for a rest of 1e-3.
template <class... Effects, class... Group, class Solver = SimplifiedNewton>
auto stepper_for(const Scene<Effects...>& scene, detail::Exactly<Group...>,
                 NearIntegrable<typename Scene<Effects...>::Scalar> list, Solver solver = {}) {
  using Whole = Scene<Effects...>;
  if constexpr (detail::can_be_exact<typename Whole::Scalar, Whole::Dof, Group...>(
                    std::type_identity<Whole>())) {
    using Split = detail::SplitScene<Whole, Group...>;
    return FlowSplitting<Split, Solver>(Split(scene), std::move(list), std::move(solver));
  } else {
    return detail::NoStepper{};
  }
}

/// The same with the usual list.
template <class... Effects, class... Group>
auto stepper_for(const Scene<Effects...>& scene, detail::Exactly<Group...> group) {
  using Whole = Scene<Effects...>;
  if constexpr (detail::can_be_exact<typename Whole::Scalar, Whole::Dof, Group...>(
                    std::type_identity<Whole>()))
    return stepper_for(scene, group, detail::usual_list<detail::SplitScene<Whole, Group...>>());
  else
    return detail::NoStepper{};
}

}  // namespace semiexplicit
