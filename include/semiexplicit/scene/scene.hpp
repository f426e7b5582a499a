#pragma once

#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include <semiexplicit/scene/effect.hpp>

namespace semiexplicit {

/// A Hamiltonian that is the sum of the effects that are named, and of no others:
///
///     namespace orbits = effects::orbits;
///     Scene scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = 1},
///                 orbits::RotatingFrame<double, 2>{.omega = 1});
///     auto stepper = stepper_for(scene);
///
/// The effects are known at compile time and inlined into one gradient, which costs what the same sum written
/// by hand costs. All have the same number type and degrees of freedom.
template <class... Effects>
class Scene {
  static_assert(sizeof...(Effects) > 0, "a Scene has one effect at least");
  static_assert((detail::is_effect<Effects>() && ...));
  template <class E>
  using Acts = typename detail::ActsOf<E>::Type;
  using First = Acts<std::tuple_element_t<0, std::tuple<Effects...>>>;

 public:
  using Scalar = typename First::Scalar;
  static constexpr int Dof = First::Dof;
  static_assert((std::same_as<typename Acts<Effects>::Scalar, Scalar> && ...),
                "the effects of a Scene must agree on the number type, Acts::Scalar");
  static_assert(((Acts<Effects>::Dof == Dof) && ...),
                "the effects of a Scene must agree on the degrees of freedom, Acts::Dof");

  /// Whether H(q, p) = V(q) + T(p): no effect is coupled.
  static constexpr bool separable = (!detail::couples<Effects> && ...);
  /// Whether it is a Hamiltonian at all: no effect adds a force of its own (OnMotion), which energy() would
  /// not know of and which gradient() counts as part of -∂H/∂q.
  static constexpr bool symplectic = (!MotionEffect<Effects> && ...);
  static constexpr bool is_symplectic() { return symplectic; }
  using SeparableGradientOf = Scene;

  /// Throws std::invalid_argument where effects have different sizes, or none, or hold different masses or
  /// circulations.
  explicit Scene(Effects... effects) : effects_(std::move(effects)...) {
    if (dof() < 1)
      throw std::invalid_argument("Scene: the effect " + detail::effect_name(std::get<0>(effects_)) +
                                  " has no degree of freedom; give its size (sites, circulations)");
    for_each([&](const auto& effect) {
      if (detail::effect_dof(effect) != dof())
        throw std::invalid_argument(
            "Scene: the effect " + detail::effect_name(effect) + " has " +
            std::to_string(detail::effect_dof(effect)) + " degrees of freedom, and " +
            (Dof == Eigen::Dynamic ? detail::effect_name(std::get<0>(effects_)) : "the type of the scene") +
            " has " + std::to_string(dof()));
    });
    if constexpr ((detail::HasSceneConstants<Effects> || ...)) {
      detail::SameConstants constants("Scene");
      for_each([&](const auto& effect) { constants.see(effect); });
    }
  }

  Eigen::Index dof() const {
    if constexpr (Dof == Eigen::Dynamic)
      return std::get<0>(effects_).dof();
    else
      return Dof;
  }

  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    Scalar sum(0);
    for_each([&](const auto& effect) { sum += detail::effect_energy(effect, q, p); });
    return sum;
  }

  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                Out<Scalar, Dof> dHdp) const {
    collect(dHdq, [&](auto& sum_q) {
      collect(dHdp, [&](auto& sum_p) {
        for_each([&](const auto& effect) { detail::add_effect(effect, q, p, sum_q, sum_p); });
      });
    });
  }

  /// ∂V/∂q alone.
  void position_gradient(const In<Scalar, Dof>& q, Out<Scalar, Dof> dHdq) const requires separable {
    collect(dHdq, [&](auto& sum) {
      for_each([&]<class E>(const E& effect) {
        if constexpr (!MomentumEffect<E>) effect.add_gradient(q, sum);
      });
    });
  }
  /// ∂T/∂p alone.
  void momentum_gradient(const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdp) const requires separable {
    collect(dHdp, [&](auto& sum) {
      for_each([&]<class E>(const E& effect) {
        if constexpr (!PositionEffect<E>) effect.add_gradient(p, sum);
      });
    });
  }

  const std::tuple<Effects...>& effects() const { return effects_; }
  /// Calls visit(effect) for each effect, in order.
  template <class Visit>
  void for_each(const Visit& visit) const {
    std::apply([&](const auto&... effect) { (visit(effect), ...); }, effects_);
  }

 private:
  /// Hands add() a zero column to add to, and writes the sum to `out`. Few entries are summed in registers,
  /// from -0: adding to -0 changes no number, so the compiler leaves the first addition out.
  template <class Add>
  static void collect(Out<Scalar, Dof>& out, const Add& add) {
    if constexpr (detail::fits_on_stack(Dof)) {
      Vector<Scalar, Dof> sum;
      for (int i = 0; i < Dof; ++i) sum[i] = -Scalar(0);
      add(sum);
      for (int i = 0; i < Dof; ++i) out[i] = sum[i];
    } else {
      out.setZero();
      add(out);
    }
  }

  std::tuple<Effects...> effects_;
};

}  // namespace semiexplicit
