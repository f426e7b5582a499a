// A stiff lattice at steps up to twenty radians of its fastest oscillation: which solver goes on, and what it
// takes.

#include <cmath>
#include <cstdio>
#include <iostream>
#include <string>

#include "common/output.hpp"
#include "long_runs.hpp"
#include "stiff_lattice.hpp"

namespace stability {

namespace {

/// Evaluations a step and the energy error over 2000 steps, or where it failed.
template <class Solver>
std::string figures(const Solver& solver, const Scheme<double>& scheme, double dt) {
  const StiffLattice h;
  Semiexplicit stepper(h, scheme, solver);
  auto z = StiffLattice::start();
  Invariants energy(h);
  const auto report = integrate(stepper, z, {.dt = dt, .steps = 2000, .on_failure = OnFailure::stop}, energy);
  if (!report.ok()) return "fails at step " + std::to_string(report.steps + 1);
  char text[64];
  std::snprintf(text, sizeof text, "%.1f (%.0e)", static_cast<double>(report.evaluations) / 2000,
                energy["energy"].worst);
  return text;
}

}  // namespace

void run_solvers(const std::filesystem::path& folder) {
  std::cout << "solvers at large steps: stiff lattice, evaluations a step (energy error)\n";
  examples::write_whole(folder / "solvers.md", [&](std::ostream& out) {
    out << "| scheme | radians a step | simplified Newton | Broyden | Newton-Krylov | Robust "
           "|\n|--|--|--|--|--|--|\n";
    for (const char* name : {"strang", "blanes_moan4", "low_defect6_s13"})
      for (const double radians : {0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0, 20.0}) {
        const auto scheme = schemes::by_name(name);
        const double dt = radians / StiffLattice::frequency(7);
        std::string row = "| " + std::string(name) + " | " + std::to_string(radians).substr(0, 5);
        row += " | " + figures(SimplifiedNewton{}, scheme, dt) + " | " + figures(Broyden{}, scheme, dt) +
               " | " + figures(NewtonKrylov{}, scheme, dt) + " | " + figures(Robust{}, scheme, dt) + " |";
        out << row << '\n';
        std::cout << "  " << row << '\n' << std::flush;
      }
  });
}

}  // namespace stability
