#pragma once

#include <cstdint>
#include <memory>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/stepper.hpp>

namespace semiexplicit::detail {

/// A stepper of phase points whose type does not show: what uses one is compiled once, whichever method it
/// is. A step takes a virtual call more.
template <class ScalarType>
class AnyStepper {
 public:
  using Scalar = ScalarType;
  using State = PhasePoint<Scalar, Eigen::Dynamic>;

  /// `max_gradients`: what a step cannot exceed.
  template <Stepper S>
  AnyStepper(S stepper, std::int64_t max_gradients)
      : stepper_(std::make_unique<Model<S>>(std::move(stepper))), max_gradients_(max_gradients) {}

  StepReport step(State& z, const Scalar& dt) { return stepper_->step(z, dt); }
  std::int64_t max_gradients() const { return max_gradients_; }

 private:
  struct Interface {
    Interface() = default;
    Interface(const Interface&) = delete;
    Interface& operator=(const Interface&) = delete;
    virtual ~Interface() = default;
    virtual StepReport step(State& z, const Scalar& dt) = 0;
  };
  template <class S>
  struct Model final : Interface {
    explicit Model(S given) : stepper(std::move(given)) {}
    StepReport step(State& z, const Scalar& dt) override { return stepper.step(z, dt); }
    S stepper;
  };

  std::unique_ptr<Interface> stepper_;
  std::int64_t max_gradients_;
};

/// The same for phase points of a fixed size.
template <class ScalarType, int Dof>
class AnyStepperOf {
 public:
  using Scalar = ScalarType;
  using State = PhasePoint<Scalar, Dof>;

  AnyStepperOf(AnyStepper<Scalar> stepper, Eigen::Index dof) : stepper_(std::move(stepper)), at_(dof) {}

  Eigen::Index dof() const { return at_.dof(); }
  StepReport step(State& z, const Scalar& dt) {
    if (z.dof() != dof()) return {.status = Status::invalid_state};
    at_.vector() = z.vector();
    const StepReport report = stepper_.step(at_, dt);
    if (report.ok()) z.vector() = at_.vector();
    return report;
  }

 private:
  AnyStepper<Scalar> stepper_;
  PhasePoint<Scalar, Eigen::Dynamic> at_;
};

}  // namespace semiexplicit::detail
