#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/stepper.hpp>

namespace semiexplicit {

/// A stepper of phase points whose type does not show: what uses one is compiled once, whichever method it is. A step takes a
/// virtual call more.
template <class ScalarType, int D>
class AnyStepper {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = D;
  using State = PhasePoint<Scalar, Dof>;

  /// S also tells its max_gradients().
  template <Stepper S>
  explicit AnyStepper(S stepper) : stepper_(std::make_unique<Model<S>>(std::move(stepper))) {}

  StepReport step(State& z, const Scalar& dt) { return stepper_->step(z, dt); }
  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const { return stepper_->max_gradients(); }

 private:
  struct Interface {
    Interface() = default;
    Interface(const Interface&) = delete;
    Interface& operator=(const Interface&) = delete;
    virtual ~Interface() = default;
    virtual StepReport step(State& z, const Scalar& dt) = 0;
    virtual std::int64_t max_gradients() const = 0;
  };
  template <class S>
  struct Model final : Interface {
    explicit Model(S given) : stepper(std::move(given)) {}
    StepReport step(State& z, const Scalar& dt) override { return stepper.step(z, dt); }
    std::int64_t max_gradients() const override { return stepper.max_gradients(); }
    S stepper;
  };

  std::unique_ptr<Interface> stepper_;
};

}  // namespace semiexplicit
