#pragma once

namespace semiexplicit::detail {

/// Gradient calls that a step of that stepper cannot exceed: a bound on calls is kept by taking no step that may break it.
template <class Stepper>
double worst_step(const Stepper& stepper) {
  double iterations = 1, each = 1;
  if constexpr (requires { stepper.scheme().kicks(); })
    each = static_cast<double>(stepper.scheme().kicks() + 1);
  if constexpr (requires { stepper.solver().max_iterations; }) iterations = stepper.solver().max_iterations;
  if constexpr (requires { stepper.options().stages; }) {
    iterations = stepper.options().max_iterations;
    each = stepper.options().stages;
  }
  return iterations * each + 1;
}

}  // namespace semiexplicit::detail
