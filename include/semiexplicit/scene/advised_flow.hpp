#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/scene/scene.hpp>

namespace semiexplicit {

namespace detail {

/// The larger one; NaN where one is NaN.
inline double larger(double a, double b) { return a >= b || a != a ? a : b; }

/// How large a part of the gradient of H that of an effect is: |∂effect/∂q|/|∂H/∂q|, or the same by p where
/// that is larger. Units of q and p leave it as it is. 0 where H is in equilibrium, NaN where it has no
/// gradient.
template <class Scalar, int Dof>
double part_of_gradient(const PhasePoint<Scalar, Dof>& effect, const PhasePoint<Scalar, Dof>& whole) {
  const auto part = [](const auto& of, const auto& all) {
    return norm(all) == Scalar(0) ? 0.0 : static_cast<double>(norm(of) / norm(all));
  };
  return larger(part(effect.q(), whole.q()), part(effect.p(), whole.p()));
}

/// The same at a state.
template <class E, class H, class Scalar, int Dof>
SEMIEXPLICIT_COLD double size_of_effect(const E& effect, const H& whole, const PhasePoint<Scalar, Dof>& z) {
  using Column = Vector<Scalar, Dof>;
  const Column q = z.q(), p = z.p();
  PhasePoint<Scalar, Dof> one(z.dof()), all(z.dof());
  Column by_q = Column::Zero(z.dof()), by_p = by_q;
  add_effect(effect, q, p, by_q, by_p);
  one.q() = by_q;
  one.p() = by_p;
  gradient_at(whole, z.vector().data(), all.vector().data(), z.dof());
  return part_of_gradient(one, all);
}

/// The flow of a group of effects; void: it has none, or its effects are there more than once.
template <class Group, class Whole>
struct SmallRestFlow;
template <class... Group, class... Effects>
struct SmallRestFlow<Exactly<Group...>, Scene<Effects...>> {
  template <class Flow>
  static constexpr bool suits() {
    if constexpr (std::is_void_v<Flow>)
      return false;
    else
      return rest_is_small<Flow>();
  }
  static constexpr bool once = ((count_of<Group, Effects...> == 1) && ...);
  using Found = typename FlowOf<Group...>::Type;
  using Type = std::conditional_t<once && suits<Found>(), Found, void>;
};

}  // namespace detail

/// The exact flow that a scene should be run with, in words for a user, or nothing: of two or three effects,
/// whose rest has a size below 1e-4, for there it takes several times fewer gradient calls. `sizes` are the
/// effects' parts of the gradient, in their order. Of several the one that leaves least.
template <class... Effects>
SEMIEXPLICIT_COLD std::optional<std::string> advised_flow(
    const Scene<Effects...>& scene, const std::array<double, sizeof...(Effects)>& sizes) {
  constexpr std::size_t n = sizeof...(Effects);
  std::optional<std::string> advice;
  double least = 1e-4;
  using All = std::tuple<Effects...>;
  const auto consider = [&]<std::size_t... group>(std::index_sequence<group...>) {
    using Group = detail::Exactly<std::tuple_element_t<group, All>...>;
    using Flow = typename detail::SmallRestFlow<Group, Scene<Effects...>>::Type;
    if constexpr (!std::is_void_v<Flow>) {
      std::string names;
      double rest = 0;
      std::size_t i = 0;
      scene.for_each([&](const auto& effect) {
        if (((i == group) || ...))
          names += (names.empty() ? "" : " + ") + detail::effect_name(effect);
        else
          rest += sizes[i];
        ++i;
      });
      if (!(rest < least)) return;
      least = rest;
      advice =
          names + " have an exact flow (" + Flow::name + "), and the rest is " + detail::in_words(rest, 2) +
          " of the gradient: stepper_for(scene, exactly<...>()) should take several times fewer gradient "
          "calls";
    }
  };
  const auto for_each_of = []<std::size_t... i>(std::index_sequence<i...>, const auto& call) {
    (call(std::integral_constant<std::size_t, i>()), ...);
  };
  constexpr auto all = std::make_index_sequence<n>();
  for_each_of(all, [&]<std::size_t k>(std::integral_constant<std::size_t, k>) {
    for_each_of(std::make_index_sequence<k>(), [&]<std::size_t j>(std::integral_constant<std::size_t, j>) {
      consider(std::index_sequence<j, k>());
      for_each_of(std::make_index_sequence<j>(), [&]<std::size_t i>(std::integral_constant<std::size_t, i>) {
        consider(std::index_sequence<i, j, k>());
      });
    });
  });
  return advice;
}

/// The same with the sizes at z. Throws std::invalid_argument for a state of another size.
template <class... Effects>
std::optional<std::string> advised_flow(
    const Scene<Effects...>& scene,
    const PhasePoint<typename Scene<Effects...>::Scalar, Scene<Effects...>::Dof>& z) {
  detail::require_same_dof("advised_flow", z.dof(), "scene", scene.dof());
  std::array<double, sizeof...(Effects)> sizes{};
  std::size_t i = 0;
  scene.for_each([&](const auto& effect) { sizes[i++] = detail::size_of_effect(effect, scene, z); });
  return advised_flow(scene, sizes);
}

}  // namespace semiexplicit
