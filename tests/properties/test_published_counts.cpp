#include "catch.hpp"

#include <string>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_published_counts {

// The evaluations of f per step that Jayawardana and Ohsawa (Math. Comp. 92 (2023) 251, appendix A.1) publish
// for the NLS lattice with the step 0.01 and the tolerance 1e-13: the figures of their tables that do not
// depend on the machine.

namespace {

using namespace semiexplicit;

template <class Solver>
double evaluations_per_step(const std::string& scheme, const Solver& solver) {
  PhasePoint<double, 5> z({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0});
  Semiexplicit stepper(systems::NlsLattice<double, 5>{}, schemes::by_name(scheme), solver);
  // The counts settle early: T = 100 instead of the published 1000.
  const auto report = integrate(stepper, z, {.dt = 0.01, .steps = 10'000});
  return static_cast<double>(report.evaluations) / static_cast<double>(report.steps);
}

}  // namespace

TEST_CASE("The published numbers of evaluations per step come out", "[published][long]") {
  struct Row {
    const char* scheme;
    double simplified, broyden;
  };
  for (const Row& row :
       {Row{"strang", 11.55, 8.88}, Row{"triple_jump4", 9.88, 7.85}, Row{"suzuki4", 8.56, 6.95},
        Row{"triple_jump6", 8.92, 7.06}, Row{"suzuki6", 4.69, 4.30}, Row{"yoshida6", 6.91, 5.99}}) {
    CAPTURE(row.scheme);
    const auto rule = StoppingRule::paper(1e-13);
    CHECK(evaluations_per_step(row.scheme, SimplifiedNewton{.stop = rule}) ==
          Approx(row.simplified).epsilon(0.03));
    CHECK(evaluations_per_step(row.scheme, Broyden{.stop = rule}) == Approx(row.broyden).epsilon(0.03));
  }
}

}  // namespace test_published_counts
