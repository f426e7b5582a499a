#pragma once

#include <algorithm>
#include <initializer_list>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/scene/any_effect.hpp>
#include <semiexplicit/scene/nearest_names.hpp>
#include <semiexplicit/scene/scene.hpp>
#include <semiexplicit/steppers/stepper_for.hpp>

namespace semiexplicit {

/// A scene whose effects are chosen at run time: a Hamiltonian that holds the effects that are on, and
/// nothing of those that are off. One virtual call an effect and gradient; where the choice is known at
/// compile time a Scene costs less.
///
///     namespace orbits = effects::orbits;
///     RuntimeScene<double, 2> all{orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{},
///                                 orbits::RotatingFrame<double, 2>{}};
///     auto scene = all.with_only({"kinetic", "attraction"});
///     with_stepper_for(scene, [&](auto& stepper) { integrate(stepper, z, {.dt = 0.01, .steps = 1000}); });
template <class ScalarType, int DofValue>
class RuntimeScene {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
  using Any = AnyEffect<Scalar, Dof>;
  using Read = In<Scalar, Dof>;

  /// Throws std::invalid_argument where there is no effect, two have the same name, their sizes differ or are
  /// below one, or they hold different masses or circulations.
  explicit RuntimeScene(std::vector<Any> effects) : effects_(std::move(effects)) {
    if (effects_.empty()) throw std::invalid_argument("RuntimeScene: no effect is on; name one at least");
    if (dof() < 1)
      throw std::invalid_argument("RuntimeScene: the effect " + effects_[0].name() + " has " +
                                  std::to_string(dof()) + " degrees of freedom; give it one at least");
    detail::SameConstants constants("RuntimeScene");
    for (auto it = effects_.begin(); it != effects_.end(); ++it) {
      if (it->dof() != dof())
        throw std::invalid_argument("RuntimeScene: the effect " + it->name() + " has " +
                                    std::to_string(it->dof()) + " degrees of freedom, and " +
                                    (Dof == Eigen::Dynamic ? effects_[0].name() : "the type of the scene") +
                                    " has " + std::to_string(dof()));
      if (is_called(std::span(effects_.begin(), it), it->name()))
        throw std::invalid_argument("RuntimeScene: two effects are called " + it->name() +
                                    "; give one a member name() of its own");
      constants.see(*it);
    }
  }
  RuntimeScene(std::initializer_list<Any> effects) : RuntimeScene(std::vector<Any>(effects)) {}

  /// The effects of a compile-time scene; of those with the same name the second is called drag 2, say.
  template <class... Effects>
  explicit RuntimeScene(const Scene<Effects...>& scene) : RuntimeScene(erased(scene)) {}

  // Moving copies, and copies share the effects: no scene is without any.
  RuntimeScene(const RuntimeScene&) = default;
  RuntimeScene& operator=(const RuntimeScene&) = default;

  Eigen::Index dof() const { return Dof == Eigen::Dynamic ? effects_[0].dof() : Dof; }
  const std::vector<Any>& effects() const { return effects_; }

  std::vector<std::string> names() const {
    std::vector<std::string> list;
    for (const Any& effect : effects_) list.push_back(effect.name());
    return list;
  }

  /// The effects of those names and no others, in the order of this scene. Throws std::invalid_argument, with
  /// the nearest valid names, for an unknown one.
  RuntimeScene with_only(const std::vector<std::string>& wanted) const {
    for (const std::string& name : wanted) require(name);
    return chosen(
        [&](const Any& e) { return std::find(wanted.begin(), wanted.end(), e.name()) != wanted.end(); });
  }
  /// All effects but that one. Throws std::invalid_argument for an unknown name, and where nothing would be
  /// left.
  RuntimeScene without(const std::string& name) const {
    require(name);
    return chosen([&](const Any& e) { return e.name() != name; });
  }

  /// Whether H(q, p) = V(q) + T(p): no effect that is on is coupled.
  bool is_separable() const {
    return std::none_of(effects_.begin(), effects_.end(), [](const Any& e) { return e.coupled(); });
  }

  /// Whether it is a Hamiltonian at all: no effect that is on adds a force of its own; see Scene::symplectic.
  bool is_symplectic() const {
    return std::none_of(effects_.begin(), effects_.end(), [](const Any& e) { return e.motion(); });
  }

  Scalar energy(const Read& q, const Read& p) const {
    Scalar sum(0);
    for (const Any& effect : effects_) sum += effect.energy(q, p);
    return sum;
  }
  void gradient(const Read& q, const Read& p, Out<Scalar, Dof> dHdq, Out<Scalar, Dof> dHdp) const {
    dHdq.setZero();
    dHdp.setZero();
    for (const Any& effect : effects_) effect.add_gradient(q, p, dHdq, dHdp);
  }

 private:
  template <class... Effects>
  static std::vector<Any> erased(const Scene<Effects...>& scene) {
    std::vector<Any> list;
    scene.for_each([&](const auto& effect) {
      const Any any(effect);
      std::string name = any.name();
      for (int n = 2; is_called(list, name); ++n) name = any.name() + " " + std::to_string(n);
      list.push_back(any.called(std::move(name)));
    });
    return list;
  }
  static bool is_called(std::span<const Any> list, const std::string& name) {
    return std::any_of(list.begin(), list.end(), [&](const Any& effect) { return effect.name() == name; });
  }
  void require(const std::string& name) const {
    const std::vector<std::string> valid = names();
    if (std::find(valid.begin(), valid.end(), name) == valid.end())
      throw std::invalid_argument(unknown_name("effect", name, valid));
  }
  template <class Wanted>
  RuntimeScene chosen(const Wanted& wanted) const {
    std::vector<Any> list;
    std::copy_if(effects_.begin(), effects_.end(), std::back_inserter(list), wanted);
    return RuntimeScene(std::move(list));
  }

  std::vector<Any> effects_;
};

template <class... Effects>
RuntimeScene(const Scene<Effects...>&)
    -> RuntimeScene<typename Scene<Effects...>::Scalar, Scene<Effects...>::Dof>;

/// A RuntimeScene that is known to be separable, as explicit splitting wants it.
template <class ScalarType, int DofValue>
class SeparableRuntimeScene : public RuntimeScene<ScalarType, DofValue> {
 public:
  using Base = RuntimeScene<ScalarType, DofValue>;
  using typename Base::Any, typename Base::Read, typename Base::Scalar;
  static constexpr int Dof = DofValue;
  static constexpr bool separable = true;
  using SeparableGradientOf = SeparableRuntimeScene;

  /// Throws std::invalid_argument, naming it, if an effect is coupled.
  explicit SeparableRuntimeScene(Base scene) : Base(std::move(scene)) {
    for (const Any& effect : this->effects())
      if (effect.coupled())
        throw std::invalid_argument("SeparableRuntimeScene: the effect " + effect.name() +
                                    " couples q and p");
    for (const Any& effect : this->effects()) {
      if (effect.on_position()) on_position_.push_back(effect);
      if (effect.on_momentum()) on_momentum_.push_back(effect);
    }
  }

  SeparableRuntimeScene(const SeparableRuntimeScene&) = default;
  SeparableRuntimeScene& operator=(const SeparableRuntimeScene&) = default;

  void position_gradient(const Read& q, Out<Scalar, Dof> dHdq) const {
    dHdq.setZero();
    for (const Any& effect : on_position_) effect.add_position_gradient(q, dHdq);
  }
  void momentum_gradient(const Read& p, Out<Scalar, Dof> dHdp) const {
    dHdp.setZero();
    for (const Any& effect : on_momentum_) effect.add_momentum_gradient(p, dHdp);
  }

 private:
  std::vector<Any> on_position_, on_momentum_;
};

/// Calls use(stepper) with the cheapest stepper that is right for the scene, as stepper_for does at compile
/// time, and returns what it returns.
template <class Scalar, int Dof, class Use>
decltype(auto) with_stepper_for(const RuntimeScene<Scalar, Dof>& scene, const Scheme<Scalar>& scheme,
                                const Use& use) {
  if (scene.is_separable()) {
    auto stepper = stepper_for(SeparableRuntimeScene<Scalar, Dof>(scene), scheme);
    return use(stepper);
  }
  auto stepper = stepper_for(scene, scheme);
  return use(stepper);
}
template <class Scalar, int Dof, class Use>
decltype(auto) with_stepper_for(const RuntimeScene<Scalar, Dof>& scene, const Use& use) {
  return with_stepper_for(scene, usual_scheme<Scalar>(scene.is_separable()), use);
}

}  // namespace semiexplicit
