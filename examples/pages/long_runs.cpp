// What remains where the method's own error is below rounding, with compensated summation and without; and a
// step that is too large for the default solver.
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

int main() {
  const systems::Product<> H;  // (q² + 1)(p² + 1)/2

  const auto worst_error = [&](Summation summation) {
    Semiexplicit stepper(H, schemes::low_defect6_s13<double>(),
                         SimplifiedNewton{.stop = StoppingRule::product(1e-20)}, summation);
    PhasePoint<double, 1> z(-3, 0);
    Invariants invariants(H);
    integrate(stepper, z, {.dt = 0.005, .steps = 5000}, invariants);
    return invariants["energy"].worst;
  };
  const double compensated = worst_error(Summation::compensated), plain = worst_error(Summation::plain);
  std::cout << "rounding: energy error " << compensated << " compensated, " << plain << " plain\n";

  // The nonlinear Schrödinger lattice with a step at the limit of convergence.
  const systems::NlsLattice<double, 5> lattice;
  const PhasePoint<double, 5> start({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  const IntegrationOptions<double> options{.dt = 0.06, .steps = 20, .on_failure = OnFailure::stop};

  PhasePoint<double, 5> z = start;
  Semiexplicit usual(lattice, schemes::low_defect6_s13<double>());
  const IntegrationReport failed = integrate(usual, z, options);
  std::cout << "simplified Newton: " << describe(failed.status) << ", after " << failed.steps
            << " steps; advised step " << failed.last.advised_step(failed.dt) << '\n';

  z = start;
  Semiexplicit robust(lattice, schemes::low_defect6_s13<double>(), Robust{});
  Invariants invariants(lattice);
  int escalations = 0;
  const IntegrationReport run = integrate(
      robust, z, options, invariants,
      [&](double, const auto&, const StepReport& step) { escalations += step.escalations > 0 ? 1 : 0; });
  std::cout << "Robust: " << run.steps << " steps, " << escalations << " of them by another solver, "
            << run.evaluations << " evaluations, energy error " << invariants["energy"].worst << '\n';
  return compensated < plain / 4 && !failed.ok() && run.ok() && escalations > 0 ? 0 : 1;
}
