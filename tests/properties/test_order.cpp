#include "catch.hpp"

#include <boost/math/special_functions/jacobi_elliptic.hpp>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/systems.hpp>

#include "methods.hpp"

namespace test_order {

// The order that is measured on nonlinear, non-separable problems must be the one that is claimed. (Harmonic
// oscillators would not do: they hardly tell a wrong sequence of coefficients from the right one.)

namespace {

using namespace semiexplicit;
using Real = long double;

/// A problem with its solution at time T, which comes from elsewhere.
template <class H>
struct Problem {
  H hamiltonian;
  PhasePoint<Real, H::Dof> start, end;
  Real T;
};

/// H = (q² + 1)(p² + 1)/2 from (-3, 0), solved by Jacobi's cn.
Problem<systems::Product<Real>> product() {
  const Real T = 0.7L, k = 3 / std::sqrt(Real(10)), u = std::sqrt(Real(10)) * T;
  const Real q = -3 * boost::math::jacobi_cn(k, u);
  const Real slope = 3 * std::sqrt(Real(10)) * boost::math::jacobi_sn(k, u) * boost::math::jacobi_dn(k, u);
  return {{}, {-3, 0}, {q, slope / (q * q + 1)}, T};
}

/// Three sites of the NLS lattice; the solution by a method of another family, of order 16 and with fine
/// steps.
Problem<systems::NlsLattice<Real, 3>> lattice() {
  Problem<systems::NlsLattice<Real, 3>> problem{{}, {{1, 0.5L, -0.3L}, {0.4L, -0.7L, 0.2L}}, {}, 1};
  problem.end = problem.start;
  GaussLegendre gauss(problem.hamiltonian, {.stages = 8});
  integrate(gauss, problem.end, {.dt = problem.T / 60, .steps = 60});
  return problem;
}

/// The error at T after n steps; infinite where a step fails.
template <class H, class Stepper>
double error(const Problem<H>& problem, Stepper stepper, int n) {
  typename Stepper::State state(problem.start);
  const auto report =
      integrate(stepper, state, {.dt = problem.T / Real(n), .steps = n, .on_failure = OnFailure::stop});
  if (!report.ok()) return std::numeric_limits<double>::infinity();
  const Real squared =
      (state.q() - problem.end.q()).squaredNorm() + (state.p() - problem.end.p()).squaredNorm();
  return static_cast<double>(std::sqrt(squared));
}

/// How the error falls when the step is halved, as a power of two, once it is `small`.
template <class H, class Stepper>
double order(const Problem<H>& problem, const Stepper& stepper, double small) {
  int n = 2;
  double now = error(problem, stepper, n);
  while (!(now <= small) && n < 10'000) {
    n *= 2;
    now = error(problem, stepper, n);
  }
  return std::log2(now / error(problem, stepper, 2 * n));
}

/// Small enough to be ruled by the leading term, and so large that after another halving rounding is not yet
/// seen.
double small_error(const methods::Claim& claim) {
  // Here the leading term is that of the defect, which is small by design, and the next is two or four orders
  // higher.
  if (claim.name.starts_with("Pihajoki, low_defect6") || claim.name.starts_with("Pihajoki, low_defect8"))
    return 1e-11;
  return claim.order > 10 ? 1e-9 : std::pow(10.0, -2.5 - 0.9 * claim.order);
}

template <class H>
auto has_its_order(const Problem<H>& problem) {
  return [&problem](const methods::Claim& claim, const auto& stepper) {
    CAPTURE(claim.name);
    const double measured = order(problem, stepper, small_error(claim));
    // Where rounding leaves room for a few halvings only, the leading term does not rule alone.
    CHECK(measured >= claim.order - (claim.order < 10 ? 0.3 : 0.5));
    CHECK(measured <= claim.order + (claim.order < 10 ? 0.5 : 2.0));
  };
}

/// The list with two neighbours exchanged, at both ends: still palindromic, and with the same sum.
std::vector<Real> exchanged(std::vector<Real> list, std::size_t i) {
  std::swap(list[i], list[i + 1]);
  std::swap(list[list.size() - 1 - i], list[list.size() - 2 - i]);
  return list;
}

}  // namespace

TEST_CASE("Every method has its order on the problem with a closed form", "[order]") {
  const auto problem = product();
  methods::for_each(problem.hamiltonian, methods::every_scheme(), has_its_order(problem));
}

TEST_CASE("Every method has its order on the NLS lattice", "[order]") {
  const auto problem = lattice();
  methods::for_each(problem.hamiltonian, methods::every_scheme(), has_its_order(problem));
}

TEST_CASE("The low-defect schemes of order 6 and 8 need the projection", "[order]") {
  const auto problem = lattice();
  for (const char* name : {"low_defect6_s13", "low_defect6_s15", "low_defect8_s20"}) {
    CAPTURE(name);
    const auto s = schemes::by_name<Real>(name);
    CHECK(order(problem, Pihajoki(problem.hamiltonian, s), 1e-11) == Approx(4).margin(0.3));
    const double small = std::pow(10.0, -2.5 - 0.9 * s.order);
    CHECK(order(problem, Semiexplicit(problem.hamiltonian, s, Broyden{.stop = StoppingRule::paper(0)}),
                small) == Approx(s.order).margin(0.3));
    CHECK(order(problem, MidpointProjection(problem.hamiltonian, s), small) == Approx(s.order).margin(0.3));
  }
}

TEST_CASE("Coefficients in a wrong sequence do not have the order", "[order]") {
  const auto problem = product();
  const auto measured = [&](const Scheme<Real>& s) {
    return order(problem, Semiexplicit(problem.hamiltonian, s), 1e-7);
  };
  for (const char* name : {"yoshida6", "kahan_li6", "suzuki_umeno8"}) {
    CAPTURE(name);
    const auto right = schemes::by_name<Real>(name);
    for (const std::size_t i : {0U, 1U}) {
      CHECK(measured(compose(schemes::strang<Real>(), exchanged(right.b, i))) < right.order - 0.5);
    }
  }
  for (const char* name : {"blanes_moan4", "blanes_moan6", "low_defect6_s13"}) {
    CAPTURE(name);
    const auto right = schemes::by_name<Real>(name);
    CHECK(measured(make_scheme("a", exchanged(right.a, 0), right.b)) < right.order - 0.5);
    CHECK(measured(make_scheme("b", right.a, exchanged(right.b, 1))) < right.order - 0.5);
  }
}

}  // namespace test_order
