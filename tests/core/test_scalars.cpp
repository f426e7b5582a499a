#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

namespace test_scalars {

// Whole runs in every number type, each as accurate as its digits allow.

namespace {

using namespace semiexplicit;
using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                           boost::multiprecision::et_off>;

template <class Scalar>
PhasePoint<Scalar, 2> start() {
  const auto tenths = [](int n) { return Scalar(n) / 10; };
  return {{tenths(10), tenths(-3)}, {tenths(4), tenths(7)}};
}

/// The worst relative errors of energy and mass of a run to T = 1.
template <class Scalar, class Stepper>
Invariants<Scalar, 2> errors(Stepper stepper, int steps) {
  using H = systems::NlsLattice<Scalar, 2>;
  PhasePoint<Scalar, 2> z = start<Scalar>();
  Invariants invariants(H{});
  invariants.add("mass", [](const auto& q, const auto& p) { return H::mass(q, p); });
  const auto report = integrate(stepper, z, {.dt = Scalar(1) / Scalar(steps), .steps = steps}, invariants);
  CHECK(report.status == Status::success);
  CHECK(report.steps == steps);
  return invariants;
}

/// A tolerance far below the square of the rounding.
constexpr double tight(double epsilon) { return 1e-4 * epsilon * epsilon; }

template <class Scalar>
double order_of(const Scheme<Scalar>& scheme, int steps) {
  const systems::NlsLattice<Scalar, 2> h;
  const auto after = [&](int n) {
    PhasePoint<Scalar, 2> z = start<Scalar>();
    const double epsilon = static_cast<double>(std::numeric_limits<Scalar>::epsilon());
    Semiexplicit stepper(h, scheme, Broyden{.stop = StoppingRule::product(tight(epsilon))});
    integrate(stepper, z, {.dt = Scalar(1) / Scalar(n), .steps = n});
    return z;
  };
  const auto z1 = after(steps), z2 = after(2 * steps), z4 = after(4 * steps);
  return std::log2(static_cast<double>((z1.vector() - z2.vector()).norm()) /
                   static_cast<double>((z2.vector() - z4.vector()).norm()));
}

}  // namespace

TEST_CASE("float", "[scalars]") {
  using H = systems::NlsLattice<float, 2>;
  const auto found = errors<float>(Semiexplicit(H{}, schemes::blanes_moan4<float>()), 50);
  CHECK(found["mass"].worst <= 1e-6F);
  CHECK(found["energy"].worst <= 1e-5F);
  CHECK(errors<float>(Semiexplicit(H{}, schemes::strang<float>(), Broyden{}), 100)["mass"].worst <= 1e-6F);
  CHECK(errors<float>(GaussLegendre(H{}, {.stages = 3}), 20)["energy"].worst <= 1e-5F);
  CHECK(order_of<float>(schemes::strang<float>(), 10) == Approx(2).margin(0.2));
}

TEST_CASE("double", "[scalars]") {
  using H = systems::NlsLattice<double, 2>;
  const auto found = errors<double>(Semiexplicit(H{}, schemes::low_defect8_s20()), 50);
  CHECK(found["mass"].worst <= 1e-14);
  CHECK(found["energy"].worst <= 2e-14);
  CHECK(errors<double>(Semiexplicit(H{}, schemes::strang(), Broyden{}), 100)["mass"].worst <= 1e-13);
  CHECK(errors<double>(GaussLegendre(H{}, {.stages = 6}), 30)["energy"].worst <= 1e-14);
  CHECK(order_of<double>(schemes::blanes_moan4(), 10) == Approx(4).margin(0.2));
}

TEST_CASE("long double", "[scalars]") {
  using H = systems::NlsLattice<long double, 2>;
  const long double epsilon = std::numeric_limits<long double>::epsilon();
  const auto rule = StoppingRule::product(tight(static_cast<double>(epsilon)));
  const auto found = errors<long double>(
      Semiexplicit(H{}, schemes::low_defect8_s20<long double>(), SimplifiedNewton{.stop = rule}), 150);
  CHECK(found["mass"].worst <= 50 * epsilon);
  // Where long double has 113 bits (ARM), the errors of the methods are larger than rounding.
  CHECK(found["energy"].worst <= std::max(100 * epsilon, 2e-22L));
  CHECK(errors<long double>(GaussLegendre(H{}, {.stages = 8}), 30)["energy"].worst <=
        std::max(100 * epsilon, 1e-30L));
  CHECK(order_of<long double>(schemes::kahan_li6<long double>(), 10) == Approx(6).margin(0.3));
}

TEST_CASE("Fifty decimal digits", "[scalars][long]") {
  using H = systems::NlsLattice<Wide, 2>;
  const Wide epsilon = std::numeric_limits<Wide>::epsilon();
  const auto rule = StoppingRule::product(1e-104);
  const auto newton = errors<Wide>(
      Semiexplicit(H{}, schemes::sofroniou_spaletta10<Wide>(), SimplifiedNewton{.stop = rule}), 16);
  CHECK(newton["mass"].worst <= 100 * epsilon);
  CHECK(newton["energy"].worst <= Wide(1e-14));
  const auto broyden = errors<Wide>(Semiexplicit(H{}, schemes::strang<Wide>(), Broyden{.stop = rule}), 10);
  CHECK(broyden["mass"].worst <= 100 * epsilon);
  CHECK(errors<Wide>(GaussLegendre(H{}, {.stages = 8}), 5)["mass"].worst <= 100 * epsilon);
  CHECK(order_of<Wide>(schemes::sofroniou_spaletta10<Wide>(), 4) == Approx(10).margin(0.5));

  // The doubled maps, and the explicit projection.
  PhasePoint<Wide, 2> z = start<Wide>();
  MidpointProjection explicit_step(H{}, schemes::strang<Wide>());
  CHECK(integrate(explicit_step, z, {.dt = 0.01, .steps = 5}).ok());
  ExtendedPoint zeta(start<Wide>());
  Pihajoki pihajoki(H{}, schemes::strang<Wide>());
  CHECK(integrate(pihajoki, zeta, {.dt = 0.01, .steps = 5}).ok());
  Tao tao(H{}, schemes::strang<Wide>(), Wide(10));
  CHECK(integrate(tao, zeta, {.dt = -0.01, .steps = 5}).ok());
  CHECK((zeta.q() - start<Wide>().q()).norm() <= Wide(1e-3));

  // Transformed time, and steps that follow a monitor function.
  const auto pace = [](const auto& q, const auto&) { return 1 / (1 + q.squaredNorm()); };
  const TimeTransformed k(
      H{},
      [&](const auto& q, auto& dgdq) {
        const Wide g = pace(q, q);
        dgdq = -2 * g * g * q;
        return g;
      },
      H{}.energy(z.q(), z.p()));
  auto extended = k.extended(z, Wide(0));
  CHECK(integrate(Semiexplicit(k, schemes::strang<Wide>()), extended, {.dt = 0.01, .steps = 5}).ok());
  CHECK(abs(k.energy(extended.q(), extended.p())) <= Wide(1e-3));
  ReversibleSteps adapted(Semiexplicit(H{}, schemes::strang<Wide>()), pace);
  CHECK(integrate(adapted, z, {.dt = 0.01, .t_end = 0.1}).ok());
}

TEST_CASE("Numbers beyond the range of double", "[scalars]") {
  // H = (q² + p²)/2: a step is linear, so that the size of the state cannot matter.
  using Real = long double;
  if (std::numeric_limits<Real>::max_exponent10 < 1000) return;
  const auto h =
      make_hamiltonian<Real, 1>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
                                [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                  dHdq = q;
                                  dHdp = p;
                                });
  for (const Real size : {1e-2000L, 1e2000L}) {
    PhasePoint<Real, 1> z(size, 0), unit(1, 0);
    Semiexplicit projected(h, schemes::blanes_moan4<Real>());
    CHECK(projected.step(z, 0.1L).ok());
    CHECK(projected.step(unit, 0.1L).ok());
    CHECK(static_cast<double>(z.q()[0] / size / unit.q()[0] - 1) == Approx(0).margin(1e-15));
    z = {size, 0};
    MidpointProjection midpoint(h, schemes::blanes_moan4<Real>());
    CHECK(midpoint.step(z, 0.1L).ok());
    GaussLegendre gauss(h, {.stages = 3});
    CHECK(gauss.step(z, 0.1L).ok());
  }
}

}  // namespace test_scalars
