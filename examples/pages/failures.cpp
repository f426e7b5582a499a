// What happens when a step is too large, and the ways to deal with it.
#include <iostream>
#include <stdexcept>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

int main() {
  const systems::Product<> H;
  const Point start(-3, 0);
  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  bool all_right = true;

  // A single step says why it failed, and leaves the state alone. The factor by which the corrections change
  // tells which step would converge.
  Point z = start;
  const StepReport report = stepper.step(z, 0.6);
  std::cout << describe(report.status) << "; corrections change by a factor " << report.rate
            << ", advised step " << report.advised_step(0.6) << '\n';
  all_right = all_right && !report.ok() && z.vector() == start.vector();

  // A run throws, with the state at the last good step.
  try {
    integrate(stepper, z, {.dt = 0.6, .steps = 10});
    all_right = false;
  } catch (const IntegrationError& error) {
    std::cout << error.what() << '\n';
    all_right = all_right && error.report().steps == 0 && z.vector() == start.vector();
  }

  // Or it stops and says so in its report.
  const IntegrationReport run =
      integrate(stepper, z, {.dt = 0.6, .steps = 10, .on_failure = OnFailure::stop});
  all_right = all_right && !run.ok() && run.status == report.status;

  // Or it cuts a step that fails into equal parts: such a run may drift.
  Invariants invariants(H);
  const IntegrationReport parts = integrate(stepper, z, {.dt = 0.6, .steps = 10, .subdivide = 6}, invariants);
  std::cout << parts.subdivided << " steps were subdivided; energy error " << invariants["energy"].worst
            << '\n';
  all_right = all_right && parts.subdivided > 0;

  // Arguments that make no sense are refused before anything is done.
  try {
    integrate(stepper, z, {.dt = 0.1, .steps = -1});
    all_right = false;
  } catch (const std::invalid_argument& refusal) {
    std::cout << refusal.what() << '\n';
  }
  return all_right ? 0 : 1;
}
