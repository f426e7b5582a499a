#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>

#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "methods.hpp"

namespace test_symplecticity {

// MᵀJM = J for the Jacobian M of a step.

namespace {

using namespace semiexplicit;
using Real = long double;
using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                           boost::multiprecision::et_off>;

/// The largest entry of MᵀJM - J, with M by central differences of order 8 with the increment `delta`.
template <class Stepper>
double symplectic_defect(const Stepper& fresh, const typename Stepper::State& z,
                         const typename Stepper::Scalar& dt, const typename Stepper::Scalar& delta) {
  using Scalar = typename Stepper::Scalar;
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  const Eigen::Index n = z.vector().size(), d = n / 2;
  const Scalar weights[] = {Scalar(4) / 5, Scalar(-1) / 5, Scalar(4) / 105, Scalar(-1) / 280};
  const auto moved = [&](Eigen::Index k, const Scalar& by) {
    Stepper stepper = fresh;
    typename Stepper::State state = z;
    state.vector()[k] += by;
    REQUIRE(stepper.step(state, dt).ok());
    return state.vector();
  };
  Matrix m = Matrix::Zero(n, n);
  for (Eigen::Index k = 0; k < n; ++k)
    for (int j = 1; j <= 4; ++j)
      m.col(k) += weights[j - 1] / delta * (moved(k, j * delta) - moved(k, -j * delta));
  Matrix form = m.topRows(d).transpose() * m.bottomRows(d) - m.bottomRows(d).transpose() * m.topRows(d);
  form.topRightCorner(d, d).diagonal().array() -= Scalar(1);
  form.bottomLeftCorner(d, d).diagonal().array() += Scalar(1);
  double largest = 0;
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index k = 0; k < n; ++k) {
      const double entry = std::abs(static_cast<double>(form(i, k)));
      if (!(entry <= largest)) largest = entry;
    }
  return largest;
}

template <class Scalar>
using Lattice = systems::NlsLattice<Scalar, 3>;
template <class Scalar>
PhasePoint<Scalar, 3> start() {
  const auto tenths = [](int n) { return Scalar(n) / 10; };
  return {{tenths(10), tenths(5), tenths(-3)}, {tenths(4), tenths(-7), tenths(2)}};
}

/// A solver that evaluates f `evaluations` times, whatever is left then.
struct FixedNumber {
  int evaluations = 1;

  template <class Vec>
  struct Workspace {
    Workspace(const FixedNumber&, Eigen::Index size) : f(Vec::Zero(size)) {}
    Vec f;
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    m.setZero();
    residual(work.f);
    for (int k = 1; k < evaluations; ++k) {
      m -= work.f / 4;
      residual(m, work.f);
    }
    return {.status = Status::success, .evaluations = evaluations, .correction = work.f.norm() / 4};
  }
};

}  // namespace

TEST_CASE("The methods that are called symplectic are, to the precision of the solve", "[symplecticity]") {
  methods::Choice choice;
  choice.most_stages = 6;
  methods::for_each_of_phase_space(Lattice<Real>{}, choice,
                                   [&](const methods::Claim& claim, const auto& stepper) {
                                     if (!claim.symplectic) return;
                                     for (const Real dt : {0.15L, -0.05L}) {
                                       CAPTURE(claim.name, dt);
                                       CHECK(symplectic_defect(stepper, start<Real>(), dt, 0.002L) <= 1e-15);
                                     }
                                   });
}

TEST_CASE("Vortices are moved symplectically, in their scaled coordinates", "[symplecticity]") {
  const systems::PointVortices<Real, 3> h({1, -2.5L, 0.7L});
  const auto z = h.phase_point({0, 1, 0.3L}, {0, 0.2L, 1.1L});
  const auto tight = StoppingRule::paper(0);
  CHECK(symplectic_defect(Semiexplicit(h, schemes::blanes_moan4<Real>(), SimplifiedNewton{.stop = tight}), z,
                          0.1L, 0.001L) <= 1e-14);
  CHECK(symplectic_defect(Semiexplicit(h, schemes::strang<Real>(), Broyden{.stop = tight}), z, 0.1L,
                          0.001L) <= 1e-14);
  CHECK(symplectic_defect(MidpointProjection(h, schemes::strang<Real>()), z, 0.3L, 0.001L) >= 1e-9);
}

TEST_CASE("Charges are moved symplectically along a curved path through magnets", "[symplecticity]") {
  namespace charges = effects::charges;
  const Real one = 1;
  const Autonomous K(charges::ChargeAlongPath(
      one, one, one, charges::ReferenceLine<Real>{.curvature = 0.3L, .beta = 0.9L},
      charges::BendField(2 * one, 0.3L), charges::QuadrupoleField(one), charges::UndulatorField(one, 3 * one),
      charges::SolenoidField(one, one, 0.5L)));
  const auto Z = K.extended({{0.1L, -0.2L, 0.3L}, {0.5L, 0.4L, -6}}, 0.2L);
  const Semiexplicit stepper(K, schemes::blanes_moan4<Real>(),
                             SimplifiedNewton{.stop = StoppingRule::paper(0)});
  for (const Real ds : {0.1L, -0.05L}) CHECK(symplectic_defect(stepper, Z, ds, 0.001L) <= 1e-14);
}

TEST_CASE("The midpoint projection is not symplectic, with a defect of order 2p + 2", "[symplecticity]") {
  const auto defect = [](const Scheme<Real>& s, Real dt) {
    return symplectic_defect(MidpointProjection(Lattice<Real>{}, s), start<Real>(), dt, 0.002L);
  };
  CHECK(defect(schemes::strang<Real>(), 0.15L) >= 1e-4);
  const auto slope = [&](const Scheme<Real>& s, Real dt) {
    return std::log2(defect(s, dt) / defect(s, dt / 2));
  };
  CHECK(slope(schemes::strang<Real>(), 0.04L) == Approx(6).margin(0.2));
  CHECK(slope(schemes::triple_jump<Real>(4), 0.06L) == Approx(10).margin(0.4));
}

TEST_CASE("The default stopping rule keeps the form within its budget", "[symplecticity]") {
  // In a wide type the differences are so fine that the number of iterations is the same at all points.
  for (const char* name : {"strang", "yoshida6", "low_defect4_s7", "low_defect6_s13"}) {
    const auto s = schemes::by_name<Wide>(name);
    for (const double dt : {0.02, 0.1}) {
      CAPTURE(name, dt);
      CHECK(symplectic_defect(Semiexplicit(Lattice<Wide>{}, s), start<Wide>(), dt, 1e-7) <= 1e-12);
      CHECK(symplectic_defect(Semiexplicit(Lattice<Wide>{}, s, Broyden{}), start<Wide>(), dt, 1e-7) <= 1e-12);
    }
  }
}

TEST_CASE("What is left of f enters the form at second order only", "[symplecticity]") {
  // With k evaluations the multiplier is of size h³ for Strang and what is left of size h^(k + 2). The
  // product of the two is of order k + 5; a method that ended with z + m would have k + 2.
  const auto defect = [](int evaluations, double dt) {
    return symplectic_defect(Semiexplicit(Lattice<Wide>{}, schemes::strang<Wide>(), FixedNumber{evaluations}),
                             start<Wide>(), dt, 1e-6);
  };
  for (int k = 1; k <= 4; ++k) {
    CAPTURE(k);
    const double coarse = defect(k, 0.01), fine = defect(k, 0.005);
    CHECK(std::log2(coarse / fine) >= k + 5 - 0.5);
    CHECK(std::log2(coarse / fine) <= k + 7 + 0.5);
  }
  // The size itself, against what the stopping rule judges by: e (‖m‖ + e)/‖z‖².
  for (const double tolerance : {1e-6, 1e-10, 1e-14, 1e-18, 1e-24}) {
    CAPTURE(tolerance);
    const SimplifiedNewton solver{.stop = StoppingRule::product(tolerance)};
    CHECK(symplectic_defect(Semiexplicit(Lattice<Wide>{}, schemes::strang<Wide>(), solver), start<Wide>(),
                            0.1, 1e-7) <= 1000 * tolerance);
  }
}

}  // namespace test_symplecticity
