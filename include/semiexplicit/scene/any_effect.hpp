#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/scene/effect.hpp>

namespace semiexplicit {

/// An effect whose type is forgotten, for programs that learn at run time which ones are wanted. A call is
/// one virtual call. Copies share the effect, which is never changed.
template <class ScalarType, int DofValue>
class AnyEffect {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
  using Read = In<Scalar, Dof>;
  using Write = Out<Scalar, Dof>;

  template <Effect E>
  requires std::same_as<typename E::Acts::Scalar, Scalar> &&(E::Acts::Dof == Dof) AnyEffect(E effect)
      : name_(detail::effect_name(effect)),
        about_(detail::effect_about(effect)),
        on_position_(!MomentumEffect<E>),
        on_momentum_(!PositionEffect<E>),
        coupled_(detail::couples<E>),
        motion_(MotionEffect<E>),
        effect_(std::make_shared<Model<E>>(std::move(effect))) {
    static_assert(detail::is_effect<E>());
  }

  // Moving copies: no effect is without what it is made of.
  AnyEffect(const AnyEffect&) = default;
  AnyEffect& operator=(const AnyEffect&) = default;

  const std::string& name() const { return name_; }
  const std::string& about() const { return about_; }
  /// The same effect by another name.
  AnyEffect called(std::string name) const {
    AnyEffect other = *this;
    other.name_ = std::move(name);
    return other;
  }
  /// Whether it depends on q, on p, and on both in a way that no sum does.
  bool on_position() const { return on_position_; }
  bool on_momentum() const { return on_momentum_; }
  bool coupled() const { return coupled_; }
  /// Whether it adds a force of its own; see OnMotion.
  bool motion() const { return motion_; }
  Eigen::Index dof() const { return effect_->dof(); }
  /// The masses or circulations that it holds; empty: none.
  std::vector<double> scene_constants() const { return effect_->scene_constants(); }

  Scalar energy(const Read& q, const Read& p) const { return effect_->energy(q, p); }
  /// Adds both halves of its gradient.
  void add_gradient(const Read& q, const Read& p, Write& dHdq, Write& dHdp) const {
    effect_->add_gradient(q, p, dHdq, dHdp);
  }
  /// Adds one half of the gradient of an effect that is not coupled; nothing where it does not depend on that
  /// half.
  void add_position_gradient(const Read& q, Write& dHdq) const { effect_->add_position_gradient(q, dHdq); }
  void add_momentum_gradient(const Read& p, Write& dHdp) const { effect_->add_momentum_gradient(p, dHdp); }

  /// Adds the force of an effect OnMotion; nothing for others.
  void add_force(const Read& q, const Read& p, Write& force) const { effect_->add_force(q, p, force); }

  /// The sum of its gradients at all of the points, added up inside the effect: its cost without the virtual
  /// calls.
  void add_gradients(const std::vector<PhasePoint<Scalar, Dof>>& points, Write& dHdq, Write& dHdp) const {
    effect_->add_gradients(points, dHdq, dHdp);
  }

 private:
  struct Interface {
    virtual ~Interface() = default;
    virtual Eigen::Index dof() const = 0;
    virtual std::vector<double> scene_constants() const = 0;
    virtual Scalar energy(const Read& q, const Read& p) const = 0;
    virtual void add_gradient(const Read& q, const Read& p, Write& dHdq, Write& dHdp) const = 0;
    virtual void add_position_gradient(const Read& q, Write& dHdq) const = 0;
    virtual void add_momentum_gradient(const Read& p, Write& dHdp) const = 0;
    virtual void add_force(const Read& q, const Read& p, Write& force) const = 0;
    virtual void add_gradients(const std::vector<PhasePoint<Scalar, Dof>>& points, Write& dHdq,
                               Write& dHdp) const = 0;
  };

  template <class E>
  struct Model final : Interface {
    explicit Model(E wrapped) : effect(std::move(wrapped)) {}
    Eigen::Index dof() const override { return detail::effect_dof(effect); }
    std::vector<double> scene_constants() const override {
      if constexpr (detail::HasSceneConstants<E>)
        return effect.scene_constants();
      else
        return {};
    }
    Scalar energy(const Read& q, const Read& p) const override { return detail::effect_energy(effect, q, p); }
    void add_gradient(const Read& q, const Read& p, Write& dHdq, Write& dHdp) const override {
      detail::add_effect(effect, q, p, dHdq, dHdp);
    }
    void add_position_gradient([[maybe_unused]] const Read& q, [[maybe_unused]] Write& dHdq) const override {
      if constexpr (PositionEffect<E> || EachEffect<E>) effect.add_gradient(q, dHdq);
    }
    void add_momentum_gradient([[maybe_unused]] const Read& p, [[maybe_unused]] Write& dHdp) const override {
      if constexpr (MomentumEffect<E> || EachEffect<E>) effect.add_gradient(p, dHdp);
    }
    void add_force([[maybe_unused]] const Read& q, [[maybe_unused]] const Read& p,
                   [[maybe_unused]] Write& force) const override {
      if constexpr (MotionEffect<E>) effect.add_force(q, p, force);
    }
    void add_gradients(const std::vector<PhasePoint<Scalar, Dof>>& points, Write& dHdq,
                       Write& dHdp) const override {
      for (const auto& z : points) detail::add_effect(effect, Read(z.q()), Read(z.p()), dHdq, dHdp);
    }
    E effect;
  };

  std::string name_, about_;
  bool on_position_, on_momentum_, coupled_, motion_;
  std::shared_ptr<const Interface> effect_;
};

}  // namespace semiexplicit
