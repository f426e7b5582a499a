#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "two_bodies.hpp"

namespace test_gauss_legendre {

namespace {

using namespace semiexplicit;

const systems::NlsLattice<double, 3> lattice;
const PhasePoint<double, 3> start({1, 0.5, -0.3}, {0.4, -0.7, 0.2});

/// The product system with its Hessian, its derivatives counted.
struct Counted {
  using Scalar = double;
  static constexpr int Dof = 1;

  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    ++*gradients;
    system.gradient(q, p, dHdq, dHdp);
  }
  void hessian(In<double, 1> q, In<double, 1> p, Eigen::Ref<Eigen::Matrix2d> result) const {
    ++*hessians;
    system.hessian(q, p, result);
  }

  systems::Product<double> system;
  std::shared_ptr<std::int64_t> gradients = std::make_shared<std::int64_t>(0);
  std::shared_ptr<std::int64_t> hessians = std::make_shared<std::int64_t>(0);
};
static_assert(HasHessian<Counted>);

/// Without its Hessian.
struct NoHessian {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    system.gradient(q, p, dHdq, dHdp);
  }
  Counted system;
};
static_assert(Hamiltonian<NoHessian> && !HasHessian<NoHessian>);

}  // namespace

TEST_CASE("One stage is the implicit midpoint rule", "[gauss]") {
  PhasePoint<double, 3> z = start;
  REQUIRE(GaussLegendre(lattice, {.stages = 1}).step(z, 0.05).ok());
  const PhasePoint<double, 3> middle((z.q() + start.q()) / 2, (z.p() + start.p()) / 2);
  Eigen::Vector3d dHdq, dHdp;
  lattice.gradient(middle.q(), middle.p(), dHdq, dHdp);
  CHECK((z.q() - start.q() - 0.05 * dHdp).norm() <= 1e-16);
  CHECK((z.p() - start.p() + 0.05 * dHdq).norm() <= 1e-16);
}

TEST_CASE("Newton's method and the fixed point solve the same equations", "[gauss]") {
  for (int stages = 1; stages <= 8; ++stages) {
    CAPTURE(stages);
    PhasePoint<double, 3> by_newton = start, by_fixed_point = start;
    GaussLegendre newton(lattice, {.stages = stages, .solver = StageSolver::newton});
    GaussLegendre fixed_point(lattice, {.stages = stages});
    for (int n = 0; n < 10; ++n) {
      const auto a = newton.step(by_newton, 0.1), b = fixed_point.step(by_fixed_point, 0.1);
      REQUIRE(a.status == Status::success);
      REQUIRE(b.status == Status::success);
      CHECK(a.evaluations <= b.evaluations);
    }
    CHECK((by_newton.vector() - by_fixed_point.vector()).norm() <= 1e-14);
  }
}

/// Many degrees of freedom that are known at compile time: matrices of them have no room within a class.
struct ManyProducts {
  using Scalar = double;
  static constexpr int Dof = 70;
  void gradient(In<double, Dof> q, In<double, Dof> p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    dHdq = q.array() * (1 + p.array().square());
    dHdp = p.array() * (1 + q.array().square());
  }
};

TEST_CASE("Both solvers take many degrees of freedom that are known at compile time", "[gauss]") {
  PhasePoint<double, 70> z, w;
  z.q().setConstant(0.3);
  z.p().setConstant(-0.2);
  w = z;
  GaussLegendre by_newton(ManyProducts{}, {.stages = 2, .solver = StageSolver::newton});
  GaussLegendre by_sweeps(ManyProducts{}, {.stages = 2});
  integrate(by_newton, z, {.dt = 0.1, .steps = 1});
  integrate(by_sweeps, w, {.dt = 0.1, .steps = 1});
  CHECK((z.vector() - w.vector()).norm() < 1e-13);
}

TEST_CASE("A Hessian that is given is used, and gives what differences give", "[gauss]") {
  const Counted with;
  const NoHessian without;
  PhasePoint<double, 1> a(-3, 0.5), b = a;
  GaussLegendre given(with, {.stages = 3, .solver = StageSolver::newton});
  GaussLegendre differences(without, {.stages = 3, .solver = StageSolver::newton});
  for (int n = 0; n < 10; ++n) {
    *with.gradients = *with.hessians = *without.system.gradients = 0;
    const auto r = given.step(a, 0.05), s = differences.step(b, 0.05);
    REQUIRE(r.ok());
    REQUIRE(s.ok());
    CHECK(r.gradients == *with.gradients);
    CHECK(s.gradients == *without.system.gradients);
    CHECK(*with.hessians == 3 * r.evaluations);
    CHECK(s.gradients > 4 * r.gradients);
  }
  CHECK(*without.system.hessians == 0);
  CHECK((a.vector() - b.vector()).norm() <= 1e-13);
}

TEST_CASE("Newton's method converges quadratically and bears steps that the fixed point does not",
          "[gauss]") {
  PhasePoint<double, 1> z(-3, 0);
  GaussLegendre newton(Counted{}, {.stages = 2, .solver = StageSolver::newton, .tolerance = 1e-10});
  const auto report = newton.step(z, 0.05);
  REQUIRE(report.ok());
  CHECK(report.evaluations <= 5);

  // A stiff oscillator, ten radians a step.
  const auto stiff = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return 50 * (q[0] * q[0] + p[0] * p[0]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq = 100 * q;
        dHdp = 100 * p;
      });
  PhasePoint<double, 1> y(1, 0);
  CHECK_FALSE(GaussLegendre(stiff, {.stages = 2}).step(y, 0.1).ok());
  CHECK(y.vector() == Eigen::Vector2d(1, 0));
  CHECK(GaussLegendre(stiff, {.stages = 2, .solver = StageSolver::newton}).step(y, 0.1).ok());
  CHECK(y.vector().norm() == Approx(1).epsilon(1e-13));
}

TEST_CASE("Newton's method comes to an end at an equilibrium", "[gauss]") {
  // The triangular point of two bodies whose lighter one has a hundredth of the mass, where the gradient is
  // but rounding.
  const auto h = from_energy<2>([](const auto& q, const auto& p) {
    using std::sqrt;
    const auto y2 = q[1] * q[1], a = q[0] + 0.01, b = q[0] - 0.99;
    return (p[0] * p[0] + p[1] * p[1]) / 2 + q[1] * p[0] - q[0] * p[1] - 0.99 / sqrt(a * a + y2) -
           0.01 / sqrt(b * b + y2);
  });
  const double y = std::sqrt(3.0) / 2;
  for (const int stages : {1, 3, 8})
    for (const double dt : {0.001, 0.01, 0.1}) {
      CAPTURE(stages, dt);
      GaussLegendre gauss(h, {.stages = stages, .solver = StageSolver::newton});
      PhasePoint<double, 2> z({0.49, y}, {-y, 0.49});
      for (int n = 0; n < 8; ++n) {
        const StepReport report = gauss.step(z, dt);
        REQUIRE(report.ok());
        CHECK(report.evaluations < 20);
      }
      CHECK(std::abs(z.q()[0] - 0.49) < 1e-14);
    }
}

TEST_CASE("Extrapolated starting values save iterations and change nothing else", "[gauss]") {
  for (const int stages : {2, 4, 6}) {
    CAPTURE(stages);
    const auto run = [&](bool extrapolate, PhasePoint<double, 3>& z) {
      GaussLegendre stepper(lattice, {.stages = stages, .extrapolate = extrapolate});
      return integrate(stepper, z, {.dt = 0.02, .steps = 200});
    };
    PhasePoint<double, 3> with = start, without = start;
    const auto a = run(true, with), b = run(false, without);
    // The more stages, the better the polynomial predicts.
    CHECK(static_cast<double>(a.evaluations) <=
          (stages < 4 ? 0.97 : 0.8) * static_cast<double>(b.evaluations));
    CHECK((with.vector() - without.vector()).norm() <= 1e-13);
  }
}

TEST_CASE("Steps that change are extrapolated to, in lanes and one by one, and change nothing else",
          "[gauss]") {
  const auto check = [](auto make) {
    for (const int stages : {3, 4, 6, 8}) {
      CAPTURE(stages);
      const auto run = [&](bool extrapolate, PhasePoint<double, 3>& z) {
        auto stepper = make({.stages = stages, .extrapolate = extrapolate});
        std::int64_t gradients = 0;
        for (int n = 0; n < 200; ++n) {
          const StepReport report = stepper.step(z, 0.02 * (1 + 0.3 * std::sin(n)));
          REQUIRE(report.ok());
          gradients += report.gradients;
        }
        return static_cast<double>(gradients);
      };
      PhasePoint<double, 3> with = start, without = start;
      CHECK(run(true, with) <= 0.85 * run(false, without));
      CHECK((with.vector() - without.vector()).norm() <= 1e-13);
    }
  };
  check([](const GaussLegendreOptions& options) { return GaussLegendre(lattice, options); });
  check([](const GaussLegendreOptions& options) { return GaussLegendreLanes(lattice, options); });
}

TEST_CASE("A step of more than twice the last one is not extrapolated to", "[gauss]") {
  GaussLegendre stepper(lattice, {.stages = 4}), fresh(lattice, {.stages = 4});
  PhasePoint<double, 3> z = start;
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(z, 0.02).ok());
  PhasePoint<double, 3> copy = z;
  CHECK(stepper.step(z, 0.041).gradients == fresh.step(copy, 0.041).gradients);
  CHECK((z.vector() - copy.vector()).norm() <= 1e-15);
}

TEST_CASE("Another direction or another state is not extrapolated to", "[gauss]") {
  GaussLegendre stepper(lattice, {.stages = 4}), fresh(lattice, {.stages = 4});
  PhasePoint<double, 3> z = start;
  for (int n = 0; n < 3; ++n) REQUIRE(stepper.step(z, 0.05).ok());
  PhasePoint<double, 3> copy = z;
  const auto turned = stepper.step(z, -0.05), first = fresh.step(copy, -0.05);
  CHECK(turned.gradients == first.gradients);
  CHECK((z.vector() - copy.vector()).norm() <= 1e-15);

  PhasePoint<double, 3> other({0.1, 0.2, 0.3}, {0.3, 0.2, 0.1}), same = other;
  GaussLegendre new_one(lattice, {.stages = 4});
  CHECK(stepper.step(other, -0.05).gradients == new_one.step(same, -0.05).gradients);
  CHECK(other.vector() == same.vector());
}

TEST_CASE("A tolerance ends the iteration early", "[gauss]") {
  PhasePoint<double, 3> loose = start, tight = start;
  const auto a = GaussLegendre(lattice, {.stages = 3, .tolerance = 1e-6}).step(loose, 0.1);
  const auto b = GaussLegendre(lattice, {.stages = 3}).step(tight, 0.1);
  CHECK(a.ok());
  CHECK(a.correction < 1e-6);
  CHECK(a.evaluations < b.evaluations);
  CHECK((loose.vector() - tight.vector()).norm() <= 1e-6);
  // Out of reach: what rounding allows is accepted, and said so.
  PhasePoint<double, 3> z = start;
  CHECK(GaussLegendre(lattice, {.stages = 3, .tolerance = 1e-300}).step(z, 0.1).ok());
}

TEST_CASE("Options that make no sense are refused", "[gauss]") {
  CHECK_THROWS_AS(GaussLegendre(lattice, {.stages = 0}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendre(lattice, {.stages = 9}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendre(lattice, {.max_iterations = 0}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendre(lattice, {.tolerance = -1}), std::invalid_argument);
  CHECK_THROWS_AS(GaussLegendre(lattice, {.tolerance = std::nan("")}), std::invalid_argument);
}

/// A proton of 10 MeV in the Earth's dipole field: p and eA are 30 times their difference, so that roundings
/// of p and of q may change an entry of the field by nothing where they cancel.
template <class Scalar, class Stepper>
int failures_in_a_dipole(const Stepper& make, double dt) {
  int failed = 0;
  for (int k = 0; k < 10; ++k) {
    const double pitch = (20 + 1.3 * k) * 0.017453, phase = 0.37 * k, v = 6.8629;
    const effects::charges::MagneticKinetic motion(Scalar(1), Scalar(1),
                                                   effects::charges::DipoleField<Scalar>(Scalar(-2988.597)));
    const Vector<Scalar, 3> q(4, 0, 0),
        along(Scalar(v * std::sin(pitch) * std::cos(phase)), Scalar(v * std::sin(pitch) * std::sin(phase)),
              Scalar(v * std::cos(pitch)));
    auto stepper = make(Scene(motion));
    PhasePoint<Scalar, 3> z(q, motion.momentum(q, along));
    failed += !integrate(stepper, z, {.dt = Scalar(dt), .steps = 4000, .on_failure = OnFailure::stop}).ok();
  }
  return failed;
}

TEST_CASE("Rounding ends the iteration also where it cancels in an entry of the field", "[gauss]") {
  const auto by = [](GaussLegendreOptions options) {
    return [options](auto h) { return GaussLegendre(h, options); };
  };
  CHECK(failures_in_a_dipole<double>(by({.stages = 8}), 0.0031) == 0);
  CHECK(failures_in_a_dipole<double>(by({.stages = 4}), 0.001) == 0);
  CHECK(failures_in_a_dipole<double>(by({.stages = 3, .solver = StageSolver::newton}), 0.002) == 0);
  CHECK(failures_in_a_dipole<float>(by({.stages = 4}), 0.0016) == 0);
}

/// A pendulum; see below.
struct Pendulum {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = std::sin(q[0]);
    dHdp[0] = p[0];
  }
};

TEST_CASE("A step of Newton's method that went far out first is solved all the same", "[gauss]") {
  // By steps too long for a pendulum, where some iterates are 1e16 and what rounding does there is no excuse.
  const struct {
    double q, p, dt;
  } starts[] = {{-3.0009033765748923, -0.09158521333313363, 2.0681494060637498},
                {-2.7389487876961987, -0.53646819112200061, 2.0018392666129179},
                {1.9696375396471191, 1.7183571651476428, 2.2670150099518467},
                {0.59635734235755944, -1.3725686364491416, 3.576789115482609}};
  for (const auto& [q, p, dt] : starts) {
    CAPTURE(q);
    PhasePoint<double, 1> z(q, p);
    if (!GaussLegendre(Pendulum(), {.stages = 1, .solver = StageSolver::newton}).step(z, dt).ok()) continue;
    CHECK(std::abs(z.q()[0] - q - dt * (z.p()[0] + p) / 2) < 1e-12);
    CHECK(std::abs(z.p()[0] - p + dt * std::sin((z.q()[0] + q) / 2)) < 1e-12);
  }
}

TEST_CASE("An iteration that runs away is no success, however its rounding has grown", "[gauss]") {
  const systems::Product<> h;
  for (const int stages : {1, 2, 4, 8})
    for (int i = 0; i < 400; ++i) {
      const double q = 3 * std::sin(2.0 * i), p = 3 * std::cos(5.0 * i), dt = 0.1 + 0.003 * i;
      const auto check = [&](auto stepper) {
        PhasePoint<double, 1> z(q, p);
        CAPTURE(stages, q, p, dt);
        if (stepper.step(z, dt).ok()) CHECK(z.vector().norm() < 1e6);
      };
      check(GaussLegendre(h, {.stages = stages}));
      check(GaussLegendreLanes(h, {.stages = stages}));
    }
}

TEST_CASE("Small corrections of Newton's method are no success where its equations are far off", "[gauss]") {
  for (float i = 0; i < 1000; ++i) {  // fields that grow exponentially, by steps far too long
    const float a = 2 * std::sin(i), b = 2 * std::cos(3 * i), dt = 0.02F * (i + 1);
    const auto h = from_energy<1, float>([=](const auto& q, const auto& p) {
      using std::exp;
      return exp(a * q[0]) + p[0] * p[0] / 2 * (1 + exp(b * q[0]));
    });
    GaussLegendre stepper(h, {.stages = 1, .solver = StageSolver::newton});
    const PhasePoint<float, 1> at(3 * std::sin(7 * i), 3 * std::cos(11 * i));
    PhasePoint<float, 1> z = at;
    if (!stepper.step(z, dt).ok()) continue;
    // The implicit midpoint rule, which one stage is.
    const double q = (double(z.q()[0]) + at.q()[0]) / 2, p = (double(z.p()[0]) + at.p()[0]) / 2;
    const double dq = z.q()[0] - at.q()[0], dp = z.p()[0] - at.p()[0];
    const double force = -a * std::exp(a * q) - p * p / 2 * b * std::exp(b * q);
    CAPTURE(a, b, dt, q, p);
    CHECK(std::abs(dq - dt * p * (1 + std::exp(b * q))) + std::abs(dp - dt * force) <
          0.1 * (std::abs(dq) + std::abs(dp)));
  }
}

TEST_CASE("Equations of Newton's method that are far off count beside numbers that are far larger",
          "[gauss]") {
  // A wall in small units, far from the origin: what its second derivatives are differenced by says nothing.
  const double unit = 0x1p-35, far = 4e-4;
  for (const double large : {1.0, 1e8, 1e12}) {
    const auto h = make_hamiltonian<double, 2>(
        [=](const auto& q, const auto& p) {
          const double x = (q[0] - far) / unit;
          return unit * (2 * p[0] * p[0] + (std::exp(1.75 * x) - x + x * x / 2) / 4) +
                 (q[1] * q[1] + p[1] * p[1]) / 2;
        },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          const double x = (q[0] - far) / unit;
          dHdq[0] = (1.75 * std::exp(1.75 * x) - 1 + x) / 4, dHdq[1] = q[1];
          dHdp[0] = 4 * unit * p[0], dHdp[1] = p[1];
        });
    GaussLegendre stepper(h, {.stages = 1, .solver = StageSolver::newton});
    PhasePoint<double, 2> z({far, large}, {0, large});
    if (!stepper.step(z, 0.5).ok()) continue;
    // The implicit midpoint rule.
    CAPTURE(large);
    CHECK((z.q()[0] - far) / unit == Approx(z.p()[0]).epsilon(1e-6));
    CHECK(z.p()[0] / 0.25 == Approx(-0.300541).epsilon(1e-5));
  }
}

namespace {
/// Their distance is kept by every solution of the stages.
auto two_vortices() {
  return from_energy<2, float>([](const auto& q, const auto& p) {
    using std::log;
    const auto x = q[0] - q[1], y = p[0] - p[1];
    return -log(x * x + y * y) / 2;
  });
}
}  // namespace

TEST_CASE("Rounding at a place that the stages have left is no excuse for what they change", "[gauss]") {
  const auto h = two_vortices();
  for (const StageSolver solver : {StageSolver::fixed_point, StageSolver::newton})
    for (const float turns : {0.3F, 3.0F, 30.0F, 100.0F, 300.0F, 1000.0F})
      for (float i = 0; i < 30; ++i) {
        const float r = std::pow(10.0F, -0.1F * i), x = r * std::cos(i) / 2, y = r * std::sin(i) / 2;
        PhasePoint<float, 2> z({x, -x}, {y, -y});
        GaussLegendre stepper(h, {.stages = 3, .solver = solver});
        if (!stepper.step(z, turns * std::acos(-1.0F) * r * r).ok()) continue;
        CAPTURE(turns, r);
        CHECK(std::hypot(z.q()[0] - z.q()[1], z.p()[0] - z.p()[1]) == Approx(r).epsilon(0.01));
      }
}

TEST_CASE("Stages whose places are rounded to a part of what they turn about run away all the same",
          "[gauss]") {
  const auto h = two_vortices();
  const float r = 0.0012F;  // ten thousand roundings of the place
  for (const StageSolver solver : {StageSolver::fixed_point, StageSolver::newton})
    for (const int stages : {2, 4})
      for (const float turns : {0.3F, 0.5F, 1.0F, 2.0F, 5.0F}) {
        int done = 0;
        for (float i = 0; i < 50; ++i) {
          const float x = r * std::cos(i) / 2, y = r * std::sin(i) / 2;
          PhasePoint<float, 2> z({1 + x, 1 - x}, {1 + y, 1 - y});
          GaussLegendre stepper(h, {.stages = stages, .solver = solver});
          if (!stepper.step(z, turns * std::acos(-1.0F) * r * r).ok()) continue;
          CAPTURE(stages, turns, i);
          CHECK(std::hypot(z.q()[0] - z.q()[1], z.p()[0] - z.p()[1]) == Approx(r).epsilon(0.1));
          ++done;
        }
        if (turns < 0.4F) CHECK(done == 50);
      }
}

TEST_CASE("Steps of what is far from the origin converge, though their places are rounded", "[gauss]") {
  for (const int stages : {1, 2, 4}) {
    auto z = two_bodies_at(1e5);
    GaussLegendre stepper(two_bodies(), {.stages = stages});
    CHECK_NOTHROW(integrate(stepper, z, {.dt = 0.05, .steps = 1500}));
    for (const StageSolver solver : {StageSolver::fixed_point, StageSolver::newton}) {
      PhasePoint<double, 1> wound(1e6, 2.5);
      GaussLegendre pendulum(Pendulum(), {.stages = stages, .solver = solver});
      CHECK_NOTHROW(integrate(pendulum, wound, {.dt = 0.1, .steps = 1500}));
    }
  }
}

TEMPLATE_TEST_CASE("Steps of what is nearly at rest converge", "[gauss]", float, double) {
  using Scalar = TestType;
  const auto h = from_energy<2, Scalar>([](const auto& q, const auto& p) {
    using std::cos;
    const auto x = q[0] - 1, y = q[1] - 2;
    return (p[0] * p[0] + p[1] * p[1] * (1 + x * x)) / 2 + 50 * x * x + y * y * (1 + x) - cos(x * y);
  });
  const Scalar epsilon = std::numeric_limits<Scalar>::epsilon();
  for (const StageSolver solver : {StageSolver::fixed_point, StageSolver::newton})
    for (const int stages : {1, 2, 4})
      for (const Scalar far : {Scalar(1), Scalar(100), Scalar(10'000)})
        for (int i = 0; i < 100; ++i) {
          const auto off = [&](int k) { return far * epsilon * Scalar(std::sin(double(k) * (i + 1))); };
          PhasePoint<Scalar, 2> z({1 + off(3), 2 + off(5)}, {off(7), off(11)});
          CAPTURE(stages, far, i);
          CHECK(GaussLegendre(h, {.stages = stages, .solver = solver}).step(z, Scalar(0.001 * (1 + i))).ok());
        }
}

namespace {
/// H = y²/2 + e^{cx} - cx of x and y in large units.
struct Wall {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length = 2146837.3629374155, momentum = 0.68117081218065323, c = 0.53329089372323013;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> by_q, Out<double, 1> by_p) const {
    by_q[0] = (std::exp(q[0] * (1 / length) * c) - 1) * c * momentum;
    by_p[0] = p[0] * (1 / momentum) * length;
  }
};
}  // namespace

template <class T>
struct CoupledPendula {
  using Scalar = T;
  static constexpr int Dof = 2;
  T stiffness = T(0.041673142462968826);
  void gradient(In<T, 2> q, In<T, 2> p, Out<T, 2> dHdq, Out<T, 2> dHdp) const {
    using std::sin;
    dHdq[0] = sin(q[0]) + stiffness * (q[0] - q[1]);
    dHdq[1] = sin(q[1]) - stiffness * (q[0] - q[1]);
    dHdp = p;
  }
};

TEST_CASE("An iteration that still shrinks at its last sweep is no success", "[gauss]") {
  // Changes shrink by a complex rate here, and in turns: the last one need not be the least.
  const auto step = []<class T>(T, int max_iterations) {
    GaussLegendre stepper(CoupledPendula<T>{}, {.stages = 4, .max_iterations = max_iterations});
    PhasePoint<T, 2> z({T(2.2556581497192383), T(0.34215390682220459)}, {T(0), T(0)});
    const bool ok = stepper.step(z, T(-4.2731337547302246)).ok();
    return std::pair(ok, Eigen::VectorXd(z.vector().template cast<double>()));
  };
  const auto [solved, right] = step(0.0L, 3000);
  REQUIRE(solved);
  int successes = 0;
  for (int most = 60; most <= 300; ++most) {
    CAPTURE(most);
    const auto [ok, z] = step(0.0f, most);
    successes += ok;
    if (ok) CHECK((z - right).norm() < 3e-5);
  }
  CHECK(successes > 100);
}

TEST_CASE("Positions and momenta that run away by turns are no success", "[gauss]") {
  PhasePoint<double, 1> z(-1729273.7822723263, -0.67588149094766647);
  CHECK_FALSE(GaussLegendre(Wall(), {.stages = 1}).step(z, 55.762009821212686).ok());
}

TEST_CASE("A rounding that makes much of the field at the foot of a wall is no excuse elsewhere", "[gauss]") {
  struct Case {
    double k, c, m, q, p, dt;
  };
  for (const Case& wall : {Case{5.50549681197624, 1.1500540613969417, 734.3110754019574, 19.85863598409038,
                                -0.7423294456595998, 0.039054333217918423},
                           Case{7.2624188889207915, 1, 240.28616101597288, 43.865975287477077,
                                -0.91071695830958099, 0.44527684941847512},
                           Case{4.3047177766231375, 0.070555537248356406, 126.48010428108152,
                                37.691247452515817, -1.7618047564442578, 0.081966185812648237},
                           Case{9.1866378633508106, 0.0029387924575090805, 1, 25.404118198562617,
                                -3.0727386073535907, 10.483092581047364}}) {
    const auto h = make_hamiltonian<double, 1>(
        [&](const auto& x, const auto& y) {
          return wall.c * (std::exp(wall.k * x[0]) / wall.k - x[0]) + wall.m / 2 * y[0] * y[0];
        },
        [&](const auto& x, const auto& y, auto& by_x, auto& by_y) {
          by_x[0] = (std::exp(x[0] * wall.k) - 1) * wall.c;
          by_y[0] = wall.m * y[0];
        });
    PhasePoint<double, 1> z(wall.q, wall.p);
    CAPTURE(wall.k, z.q()[0], z.p()[0]);
    CHECK_FALSE(GaussLegendre(h, {.stages = 1}).step(z, wall.dt).ok());
  }
}

TEST_CASE("Newton's method starts again at z where what it is extrapolated to is far off", "[gauss]") {
  GaussLegendreOptions options{.stages = 2, .solver = StageSolver::newton};
  GaussLegendre extrapolated(systems::Product<>(), options);
  options.extrapolate = false;
  GaussLegendre plain(systems::Product<>(), options);
  PhasePoint<double, 1> z(-0.97694053099113443, 0.97219529296407625), same = z;
  for (int n = 0; n < 2; ++n) {  // the motion is faster where the second step goes
    const auto report = extrapolated.step(z, 0.9112410422603886);
    REQUIRE(report.ok());
    CHECK(report.gradients <= extrapolated.max_gradients());
    REQUIRE(plain.step(same, 0.9112410422603886).ok());
    CHECK((z.vector() - same.vector()).norm() < 1e-12);
  }
}

TEST_CASE("An iteration that is cut off while it converges is no success", "[gauss]") {
  const auto h =
      from_energy<1, float>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; });
  GaussLegendre stepper(h, {.stages = 4});
  PhasePoint<float, 1> z(1, 0);
  for (int n = 0; n < 200; ++n)
    if (!stepper.step(z, 4.2369F).ok()) break;
  CHECK(z.vector().norm() == Approx(1).epsilon(1e-3));
}

TEST_CASE("Few iterations are not enough, and the state is left alone", "[gauss]") {
  for (const StageSolver solver : {StageSolver::fixed_point, StageSolver::newton}) {
    PhasePoint<double, 3> z = start;
    const auto report =
        GaussLegendre(lattice, {.stages = 3, .solver = solver, .max_iterations = 2}).step(z, 0.2);
    CHECK(report.status == Status::no_convergence);
    CHECK(report.evaluations == 2);
    CHECK(z.vector() == start.vector());
  }
}

}  // namespace test_gauss_legendre
