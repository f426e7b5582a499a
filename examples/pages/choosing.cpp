// Step, rule, solver and omega, by trial: the NLS lattice to T = 10.
#include <algorithm>
#include <cstdint>
#include <iostream>
#include <limits>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

const systems::NlsLattice<double, 5> H;
const PhasePoint<double, 5> start({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});

struct Trial {
  double error;              ///< of the energy, the worst, relative; infinite where the run failed
  std::int64_t evaluations;  ///< a step, rounded up
  std::int64_t gradients;
};

template <class Stepper>
Trial tried(Stepper stepper, double dt) {
  typename Stepper::State state(start);
  Invariants invariants(H);
  const auto steps = static_cast<std::int64_t>(10 / dt);
  const IntegrationReport run =
      integrate(stepper, state, {.dt = dt, .steps = steps, .on_failure = OnFailure::stop}, invariants);
  const double error = run.ok() ? invariants["energy"].worst : std::numeric_limits<double>::infinity();
  return {error, (run.evaluations + steps - 1) / steps, run.gradients};
}

int main() {
  // The step: double it until the evaluations a step leave one.
  std::int64_t evaluations = 1;
  double dt = 0.01;
  for (; evaluations == 1 && dt < 1; dt *= 2) {
    const Trial trial = tried(Semiexplicit(H, schemes::low_defect6_s13<double>()), dt);
    evaluations = trial.evaluations;
    std::cout << "dt " << dt << ": energy error " << trial.error << ", evaluations a step "
              << trial.evaluations << '\n';
  }

  // The rule: the product bounds what matters, at a fraction of the work.
  const auto with = [](const StoppingRule& rule) {
    return tried(Semiexplicit(H, schemes::blanes_moan4<double>(), SimplifiedNewton{.stop = rule}), 0.005);
  };
  const Trial product = with(StoppingRule::product()), paper = with(StoppingRule::paper(1e-13));
  std::cout << "gradient calls by the product rule: " << product.gradients
            << ", by the paper's: " << paper.gradients << ", energy errors " << product.error << " and "
            << paper.error << '\n';

  // The solver: at a step that is too large for simplified Newton, Broyden's method and Robust still
  // converge.
  const auto by = [](const auto& solver) {
    return tried(Semiexplicit(H, schemes::low_defect6_s13<double>(), solver), 0.06);
  };
  const Trial newton = by(SimplifiedNewton{}), broyden = by(Broyden{}), robust = by(Robust{});
  std::cout << "dt 0.06: energy error by simplified Newton " << newton.error << ", Broyden " << broyden.error
            << " in " << broyden.evaluations << " evaluations a step, Robust " << robust.error << " in "
            << robust.evaluations << '\n';

  // Tao's omega: too small, and the copies separate.
  double worst = 0, best = std::numeric_limits<double>::infinity();
  for (const double omega : {1.0, 10.0, 100.0}) {
    const double error = tried(Tao(H, schemes::kahan_li6<double>(), omega), 0.005).error;
    std::cout << "Tao, omega " << omega << ": energy error " << error << '\n';
    worst = std::max(worst, error);
    best = std::min(best, error);
  }
  return evaluations > 1 && product.gradients < paper.gradients && product.error < 2 * paper.error &&
                 worst > 1000 * best && broyden.error < 1e-4 && robust.error < 1e-4 && newton.error > 1
             ? 0
             : 1;
}
