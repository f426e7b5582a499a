// A run with many observers: the nonlinear Schrödinger lattice with five sites.
#include <cstdint>
#include <cstdio>
#include <fstream>
#include <iostream>
#include <string>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

int main() {
  const systems::NlsLattice<double, 5> H;
  PhasePoint<double, 5> z({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());

  Invariants invariants(H);  // the energy
  invariants.add("mass", [](const auto& q, const auto& p) { return q.squaredNorm() + p.squaredNorm(); });
  Record<double, 5> record;              // in memory
  CsvTrajectory csv("page_run.csv", 5);  // in a file, which gets its name by commit()
  Progress progress(1000);               // draws on a terminal only
  double mass_of_first = 0;
  auto at_two_times = at_times(H, {0.125, 0.375}, [&](double, const PhasePoint<double, 5>& at) {
    mass_of_first += at.q()[0] * at.q()[0] + at.p()[0] * at.p()[0];
  });
  const auto until_it_arrives = [](double, const auto& state) {
    return state.q()[4] * state.q()[4] + state.p()[4] * state.p()[4] < 5;  // false stops the run
  };

  const IntegrationReport run =
      integrate(stepper, z, {.dt = 0.01, .steps = 100'000}, invariants, every(100, record), every(10, csv),
                progress, at_two_times, until_it_arrives);
  csv.commit();

  std::cout << describe(run.status) << " at t = " << run.t << " after " << run.gradients
            << " gradient calls\n"
            << "energy error " << invariants["energy"].worst << ", mass error " << invariants["mass"].worst
            << ", states kept: " << record.z.size() << '\n';

  // On to a given time, exactly: the report tells the step that this took.
  const IntegrationReport rest = integrate(stepper, z, {.dt = 0.01, .t0 = run.t, .t_end = run.t + 1.0 / 3});
  std::cout << "then " << rest.steps << " steps of " << rest.dt << " to t = " << rest.t << '\n';

  std::ifstream file("page_run.csv");
  std::int64_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  std::remove("page_run.csv");
  const bool watched = static_cast<std::int64_t>(record.z.size()) == run.steps / 100 + 1 &&
                       lines == 1 + run.steps / 10 + 1 && mass_of_first > 5 && rest.dt < 0.01;
  return run.status == Status::stopped && watched && invariants["energy"].worst < 1e-9 &&
                 invariants["mass"].worst < 1e-12
             ? 0
             : 1;
}
