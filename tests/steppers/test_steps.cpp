#include "catch.hpp"

#include <boost/math/special_functions/jacobi_elliptic.hpp>
#include <boost/multiprecision/cpp_bin_float.hpp>
#include <boost/multiprecision/eigen.hpp>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_steps {

// Steps of the implicit Gauss methods: accuracy, cost, failures.

namespace {

using namespace semiexplicit;
using Real = long double;

const systems::NlsLattice<double, 3> lattice;
const PhasePoint<double, 3> lattice_start({1, 0.5, -0.3}, {0.4, -0.7, 0.2});
const systems::Product<double> product;
const PhasePoint<double, 1> product_start(-3, 0);
constexpr auto solvers = {StageSolver::fixed_point, StageSolver::newton};

template <class Point>
double distance(const Point& u, const Point& v) {
  return static_cast<double>((u.vector() - v.vector()).norm() / v.vector().norm());
}

/// Bit for bit.
template <class Point>
bool same(const Point& u, const Point& v) {
  const auto bytes = sizeof(typename Point::Scalar) * static_cast<std::size_t>(v.vector().size());
  return u.vector().size() == v.vector().size() &&
         std::memcmp(u.vector().data(), v.vector().data(), bytes) == 0;
}

/// |p|²/2 + q_0²/2 + 0.001 q_0, whose halves leave out the cyclic coordinate.
struct Cyclic {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr bool separable = true;
  using SeparableGradientOf = Cyclic;
  void position_gradient(const auto& q, auto& dVdq) const { dVdq[0] = q[0] + 1e-3; }
  void momentum_gradient(const auto& p, auto& dTdp) const {
    dTdp[0] += p[0];
    dTdp[1] += p[1];
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = q[0] + 1e-3;
    dHdq[1] = 0;
    dHdp = p;
  }
  Status flow(double t, const auto&, const auto& p, auto& dq, auto&) const {
    dq[0] = t * p[0];
    dq[1] = t * p[1];
    return Status::success;
  }
  std::string flow_name() const { return "free motion"; }
  static constexpr bool flow_is_quadratic = true;
  void rest_position_gradient(const auto& q, auto& dVdq) const { position_gradient(q, dVdq); }
};

/// The state after some steps.
template <class H, class Point>
Point after(const H& h, const GaussLegendreOptions& options, Point z, double dt, std::int64_t steps) {
  GaussLegendre stepper(h, options);
  integrate(stepper, z, {.dt = dt, .steps = steps});
  return z;
}

/// The error at T = 0.7 after n steps on Product from (-3, 0), solved by Jacobi's cn.
double error(int stages, int n) {
  const Real T = 0.7L, k = 3 / std::sqrt(Real(10)), u = std::sqrt(Real(10)) * T;
  const Real q = -3 * boost::math::jacobi_cn(k, u);
  const Real slope = 3 * std::sqrt(Real(10)) * boost::math::jacobi_sn(k, u) * boost::math::jacobi_dn(k, u);
  PhasePoint<Real, 1> z(-3, 0);
  GaussLegendre stepper(systems::Product<Real>{}, {.stages = stages});
  integrate(stepper, z, {.dt = T / Real(n), .steps = n});
  return static_cast<double>(std::hypot(z.q()[0] - q, z.p()[0] - slope / (q * q + 1)));
}

/// A gradient that is NaN left of zero.
struct HalfLine {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(const In<double, 1>& q, const In<double, 1>& p, Out<double, 1> dHdq,
                Out<double, 1> dHdp) const {
    dHdq[0] = p[0] * p[0] / (2 * std::sqrt(q[0]));
    dHdp[0] = p[0] + 2 * p[0] * std::sqrt(q[0]);
  }
};

/// Product, until it is told to throw.
struct Throwing {
  using Scalar = double;
  static constexpr int Dof = 1;
  std::shared_ptr<bool> throws = std::make_shared<bool>(false);
  void gradient(const In<double, 1>& q, const In<double, 1>& p, Out<double, 1> dHdq,
                Out<double, 1> dHdp) const {
    if (*throws) {
      dHdq[0] = dHdp[0] = std::numeric_limits<double>::quiet_NaN();
      throw std::domain_error("no gradient today");
    }
    product.gradient(q, p, dHdq, dHdp);
  }
};

}  // namespace

TEST_CASE("Halves of a gradient may leave out what is 0, or add", "[steppers]") {
  const auto run = [](auto stepper) {
    PhasePoint<double, 2> z({1, 0.5}, {0.2, 0.7});
    integrate(stepper, z, {.dt = 0.05, .steps = 200});
    CHECK(z.p()[1] == 0.7);
    CHECK(z.q()[1] == Approx(7.5).epsilon(1e-13));
    CHECK(z.q()[0] == Approx(1.001 * std::cos(10.0) + 0.2 * std::sin(10.0) - 1e-3).epsilon(1e-6));
  };
  run(ExplicitSplitting(Cyclic(), schemes::blanes_moan6()));
  run(FlowSplitting(Cyclic(), schemes::blanes_moan_nystrom6()));
}

TEST_CASE("The order of a Gauss method is twice the number of its stages", "[gauss]") {
  const int steps[] = {400, 60, 30, 20};
  for (int s = 1; s <= 4; ++s) {
    CAPTURE(s);
    const double coarse = error(s, steps[s - 1]), fine = error(s, 2 * steps[s - 1]);
    CHECK(coarse < 1e-3);
    CHECK(std::log2(coarse / fine) == Approx(2 * s).margin(0.2));
  }
  for (int s = 2; s <= 8; ++s) {
    CAPTURE(s);
    CHECK(error(s, 5) < error(s - 1, 5) / 2);
  }
  CHECK(error(8, 20) < 1e-4 * error(4, 20));
  CHECK(error(8, 40) < 1e-15);
}

TEST_CASE("The Gauss methods run with 50 digits", "[gauss]") {
  using Fifty = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                              boost::multiprecision::et_off>;
  for (int s = 1; s <= 8; ++s) {
    const GaussTableau<Fifty> tableau(s);
    for (int i = 0; i < s; ++i)
      for (int j = 0; j < s; ++j) CHECK(tableau.m(i, j) + tableau.m(j, i) == Fifty(1));
  }
  PhasePoint<Fifty, 1> z(Fifty(-3), Fifty(0));
  const auto start = z;
  const systems::Product<Fifty> h;
  GaussLegendre stepper(h, {.stages = 8});
  const Fifty dt = Fifty(1) / 100, before = h.energy(z.q(), z.p());
  integrate(stepper, z, {.dt = dt, .steps = 5});
  const Fifty off = h.energy(z.q(), z.p()) - before;
  CHECK(off * off < Fifty("1e-40"));
  integrate(stepper, z, {.dt = -dt, .steps = 5});
  CHECK((z.vector() - start.vector()).squaredNorm() < Fifty("1e-90"));
}

TEST_CASE("Gauss methods of fixed and of dynamic size take the same steps", "[gauss]") {
  PhasePoint<double, Eigen::Dynamic> start(3);
  start.vector() = lattice_start.vector();
  for (const StageSolver solver : solvers) {
    const GaussLegendreOptions options{.stages = 3, .solver = solver};
    const auto z = after(systems::NlsLattice<double>(3), options, start, 0.05, 20);
    CHECK((z.vector() - after(lattice, options, lattice_start, 0.05, 20).vector()).norm() < 1e-14);
  }
}

TEST_CASE("What a step of a Gauss method costs", "[gauss]") {
  for (int s = 1; s <= 4; ++s) {
    CAPTURE(s);
    // One call for the start, then one a stage and iteration; none for a start from the step before.
    auto z = lattice_start;
    GaussLegendre fixed_point(lattice, {.stages = s}), plain(lattice, {.stages = s, .extrapolate = false});
    const StepReport first = fixed_point.step(z, 0.02), second = fixed_point.step(z, 0.02);
    CHECK(first.gradients == 1 + s * first.evaluations);
    CHECK(second.gradients == s * second.evaluations);
    z = lattice_start;
    for (int n = 0; n < 3; ++n) {
      const StepReport report = plain.step(z, 0.02);
      CHECK(report.gradients == 1 + s * report.evaluations);
    }

    // The Hessian costs none, differences for it 4d more a stage, and more where their shifts are looked for:
    // at first.
    auto y = product_start;
    GaussLegendre given(product, {.stages = s, .solver = StageSolver::newton});
    const StepReport with_hessian = given.step(y, 0.02);
    CHECK(with_hessian.gradients == 1 + s * with_hessian.evaluations);
    z = lattice_start;
    GaussLegendre differences(lattice, {.stages = s, .solver = StageSolver::newton});
    const StepReport without = differences.step(z, 0.02);
    CHECK(without.gradients >= 1 + s * (1 + 4 * 3) * without.evaluations);
    CHECK(without.gradients <= differences.max_gradients());
    CHECK(without.evaluations <= 8);
    std::int64_t iterations = 0, calls = 0;
    for (int n = 0; n < 30; ++n) {
      const StepReport report = differences.step(z, 0.02);
      iterations += s * report.evaluations;
      calls += report.gradients;
    }
    CHECK(double(calls) <= 1.15 * (1 + 4 * 3) * double(iterations));
  }
}

TEST_CASE("A Gauss method starts anew from any point but the one that it came to, and with any other dt",
          "[gauss]") {
  const int s = 3;
  for (const StageSolver solver : solvers) {
    const GaussLegendreOptions options{.stages = s, .solver = solver};
    const int per_iteration = solver == StageSolver::newton ? s * (1 + 4 * 3) : s;
    GaussLegendre used(lattice, options);
    auto z = lattice_start;
    integrate(used, z, {.dt = 0.05, .steps = 5});
    const auto starts_anew = [&](const PhasePoint<double, 3>& from, double dt) {
      auto u = from, v = from;
      const StepReport report = used.step(u, dt);
      CHECK(report.ok());
      CHECK(report.gradients >= 1 + per_iteration * report.evaluations);
      CHECK((solver == StageSolver::newton || report.gradients == 1 + s * report.evaluations));
      GaussLegendre fresh(lattice, options);
      CHECK(fresh.step(v, dt).ok());
      CHECK(distance(u, v) < 1e-15);
      z = u;
    };
    starts_anew(z, -0.03);
    starts_anew(z, 0.05);
    starts_anew(lattice_start, 0.05);
    auto nearby = z;
    nearby.p()[2] = std::nextafter(nearby.p()[2], 10.0);
    starts_anew(nearby, 0.05);
    const StepReport goes_on = used.step(z, 0.05);
    CHECK(goes_on.gradients >= per_iteration * goes_on.evaluations);
    CHECK((solver == StageSolver::newton || goes_on.gradients == s * goes_on.evaluations));
  }
}

TEST_CASE("A step that is too large fails, leaves the state alone, and the Gauss method goes on", "[gauss]") {
  for (const StageSolver solver : solvers) {
    const GaussLegendreOptions options{.stages = 2, .solver = solver, .max_iterations = 20};
    GaussLegendre stepper(lattice, options);
    auto z = lattice_start;
    REQUIRE(stepper.step(z, 0.02).ok());
    const auto before = z;
    const StepReport failed = stepper.step(z, 1e4);
    CHECK((failed.status == Status::no_convergence || failed.status == Status::not_finite));
    CHECK(failed.evaluations > 0);
    CHECK(same(z, before));
    CHECK(stepper.step(z, 0.02).ok());
    CHECK(distance(z, after(lattice, options, lattice_start, 0.02, 2)) < 1e-15);
  }
}

TEST_CASE("NaN from the gradient fails the step of a Gauss method, and no more", "[gauss]") {
  for (const StageSolver solver : solvers) {
    GaussLegendre stepper(HalfLine{}, {.solver = solver});
    PhasePoint<double, 1> z(0.5, -1);
    REQUIRE(stepper.step(z, 0.01).ok());
    const auto good = z;
    PhasePoint<double, 1> bad(-0.5, 1);
    const auto before = bad;
    CHECK(stepper.step(bad, 0.01).status == Status::not_finite);
    CHECK(same(bad, before));
    z = good;
    CHECK(stepper.step(z, 0.01).ok());
  }
}

TEST_CASE("A gradient that throws fails the step of a Gauss method, and no more", "[gauss]") {
  const Throwing h;
  for (const StageSolver solver : solvers) {
    const GaussLegendreOptions options{.stages = 3, .solver = solver};
    GaussLegendre stepper(h, options);
    auto z = product_start;
    REQUIRE(stepper.step(z, 0.02).ok());
    const auto before = z;
    *h.throws = true;
    CHECK_THROWS_AS(stepper.step(z, 0.02), std::domain_error);
    CHECK(same(z, before));
    *h.throws = false;
    REQUIRE(stepper.step(z, 0.02).ok());
    CHECK(distance(z, after(product, options, product_start, 0.02, 2)) < 1e-15);

    // From another point, so that the very first call throws; what it left behind is not extrapolated from.
    auto elsewhere = product_start;
    *h.throws = true;
    CHECK_THROWS_AS(stepper.step(elsewhere, 0.02), std::domain_error);
    *h.throws = false;
    REQUIRE(stepper.step(z, 0.02).ok());
    CHECK(distance(z, after(product, options, product_start, 0.02, 3)) < 1e-15);
  }
}

TEST_CASE("Steps and states that a Gauss method refuses", "[gauss]") {
  constexpr double infinite = std::numeric_limits<double>::infinity();
  for (const StageSolver solver : solvers) {
    GaussLegendre stepper(systems::NlsLattice<double>(3), {.solver = solver});
    PhasePoint<double, Eigen::Dynamic> z(3), shorter(2), longer(4);
    z.vector() = lattice_start.vector();
    const auto before = z;
    for (const double dt : {0.0, -0.0, std::nan(""), infinite, -infinite}) {
      CAPTURE(dt);
      const StepReport report = stepper.step(z, dt);
      CHECK(report.status == Status::invalid_step);
      CHECK(report.gradients == 0);
      CHECK(same(z, before));
    }
    CHECK(stepper.step(shorter, 0.01).status == Status::invalid_state);
    CHECK(stepper.step(longer, 0.01).status == Status::invalid_state);
    for (const double bad : {std::nan(""), infinite}) {
      z = before;
      z.p()[1] = bad;
      const auto spoiled = z;
      CHECK(stepper.step(z, 0.01).status == Status::invalid_state);
      CHECK(same(z, spoiled));
    }
    z = before;
    CHECK(stepper.step(z, 0.01).ok());
  }
}

TEST_CASE("A Gauss method keeps a quadratic invariant to rounding", "[gauss][long]") {
  const auto worst = [](const GaussLegendreOptions& options, double dt, std::int64_t steps) {
    auto z = lattice_start;
    Invariants invariants(lattice);
    invariants.add("mass", [](const auto& q, const auto& p) { return lattice.mass(q, p); });
    GaussLegendre stepper(lattice, options);
    integrate(stepper, z, {.dt = dt, .steps = steps}, invariants);
    CHECK(invariants["energy"].worst > 1e-12);  // not because nothing happens
    CHECK(invariants["energy"].worst < 1e-2);
    return invariants["mass"].worst;
  };
  CHECK(worst({.stages = 1}, 0.05, 1'000) < 1e-14);
  CHECK(worst({.stages = 2}, 0.05, 1'000) < 1e-14);
  CHECK(worst({.stages = 3}, 0.1, 1'000) < 1e-14);
  CHECK(worst({.stages = 2, .solver = StageSolver::newton}, 0.05, 1'000) < 1e-14);
  // The test can fail.
  CHECK(worst({.stages = 2, .tolerance = 1e-6}, 0.1, 1000) > 1e-12);
}

}  // namespace test_steps
