// A run that is interrupted and goes on, against one that is not.
#include <cstdint>
#include <filesystem>
#include <iostream>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

const std::filesystem::path file = "product.checkpoint";

/// Runs to the end, or to step `until`; gives the last state.
PhasePoint<double, 1> run(std::int64_t until, double& energy_error) {
  const systems::Product<double> H;
  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  PhasePoint<double, 1> z(-3, 0);
  Invariants invariants(H);

  IntegrationOptions<double> options{.dt = 0.1, .steps = 5000};
  Checkpoints checkpoints(file, {.every = 1000}, stepper, options, invariants);
  options.done = checkpoints.resume(z);  // nothing where there is no such file
  std::cout << "begins at step " << options.done.steps << '\n';
  const auto interrupt = [&](double, const auto&, const IntegrationReport& so_far) {
    return so_far.steps != until;
  };
  const auto report = integrate(stepper, z, options, invariants, checkpoints, interrupt);
  if (report.status == Status::success) checkpoints.remove();
  energy_error = invariants["energy"].worst;
  return z;
}

int main() {
  std::filesystem::remove(file);
  double whole_error = 0, error = 0;
  const PhasePoint<double, 1> whole = run(-1, whole_error);
  run(3700, error);
  const PhasePoint<double, 1> resumed = run(-1, error);  // from step 3000
  const bool same = resumed.vector() == whole.vector() && error == whole_error;
  std::cout << (same ? "the same to the last bit" : "another run") << '\n';
  return same ? 0 : 1;
}
