// A run with everything that may watch it: the nonlinear Schrödinger lattice with five sites.
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

  Invariants invariants(H);
  invariants.add("mass", [](const auto& q, const auto& p) { return q.squaredNorm() + p.squaredNorm(); });
  Record<double, 5> record;              // in memory
  CsvTrajectory csv("page_run.csv", 5);  // in a file, which gets its name by commit()
  const auto until_it_arrives = [](double, const auto& state) {
    return state.q()[4] * state.q()[4] + state.p()[4] * state.p()[4] < 5;  // false stops the run
  };

  const IntegrationReport run = integrate(stepper, z, {.dt = 0.01, .steps = 100'000}, invariants,
                                          every(100, record), every(10, csv), until_it_arrives);
  csv.commit();

  std::cout << describe(run.status) << " at t = " << run.t << " after " << run.gradients
            << " gradient calls\n"
            << "energy error " << invariants["energy"].worst << ", mass error " << invariants["mass"].worst
            << ", states kept: " << record.z.size() << '\n';

  std::ifstream file("page_run.csv");
  std::int64_t lines = 0;
  for (std::string line; std::getline(file, line);) ++lines;
  std::remove("page_run.csv");
  const bool watched =
      static_cast<std::int64_t>(record.z.size()) == run.steps / 100 + 1 && lines == 1 + run.steps / 10 + 1;
  return run.status == Status::stopped && watched && invariants["energy"].worst < 1e-9 &&
                 invariants["mass"].worst < 1e-12
             ? 0
             : 1;
}
