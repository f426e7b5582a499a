#include "catch.hpp"

#include <algorithm>
#include <cmath>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "tangent_lattice.hpp"

namespace test_tangent_runs {

// Tangent vectors over many steps.

namespace {

using namespace tangent_lattice;

/// vᵀJu.
template <class V>
auto area(const V& v, const V& u) {
  const Eigen::Index d = v.size() / 2;
  return v.head(d).dot(u.tail(d)) - v.tail(d).dot(u.head(d));
}

}  // namespace

TEST_CASE("Symplecticity holds of tangent vectors over a long run", "[chaos][long]") {
  // Close to what the rule allows of each step, 1e-16 of the size of the vectors.
  const auto drift = [](const auto& h) {
    Semiexplicit stepper(h, schemes::low_defect6_s13());
    TangentVectors tangents(stepper, 3);
    fill(tangents.vectors());
    tangents.vectors().colwise().normalize();
    auto z = some_point<double, 5>(5);
    const auto v = tangents.vectors();
    double worst = 0;
    for (int n = 0; n < 20'000; ++n) {
      REQUIRE(tangents.advance(z, 0.02).ok());
      REQUIRE(stepper.step(z, 0.02).ok());
      const auto& u = tangents.vectors();
      for (const int j : {0, 1})
        worst = std::max(worst, std::abs(area(u.col(j), u.col(2)) - area(v.col(j), v.col(2))) /
                                    (u.col(j).norm() * u.col(2).norm()));
    }
    return worst;
  };
  CHECK(drift(WithProduct<double, 5>{}) <= 1e-12);
  CHECK(drift(systems::NlsLattice<double, 5>()) <= 1e-12);
  CHECK(drift(GradientOnly<double, 5>{}) <= 1e-6);
}

TEST_CASE("Exponents of three hundred degrees of freedom are there in a blink", "[chaos][long]") {
  const systems::NlsLattice<double> h(300);
  Semiexplicit stepper(h, schemes::low_defect6_s13());
  auto z = some_point<double, Eigen::Dynamic>(300);
  LyapunovExponents lyapunov(stepper, 2);
  integrate(stepper, z, {.dt = 0.02, .steps = 2000}, lyapunov);
  CHECK(lyapunov.exponents()[0] > 0.01);
  CHECK(lyapunov.exponents()[1] < lyapunov.exponents()[0]);
}

}  // namespace test_tangent_runs
