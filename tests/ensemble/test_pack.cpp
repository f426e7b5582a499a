// Compiled for the processor at hand and without contraction to fused operations (see tests/CMakeLists.txt):
// a lane then has to give the very bits of the plain stepper.
#include "catch.hpp"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "plain.hpp"
#include "refusal.hpp"

namespace test_pack {

namespace {

using namespace plain;
constexpr auto lanes = std::size_t(pack_width);

static_assert(PackHamiltonian<systems::NlsLattice<double, 5>> &&
              PackHamiltonian<Product<RegisterPack<double>>>);
static_assert(!PackHamiltonian<Product<double>> && !PackHamiltonian<Lattice<5>>);

bool same(double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }
bool same(const StepReport& x, const StepReport& y) {
  return x.status == y.status && x.evaluations == y.evaluations && x.gradients == y.gradients &&
         same(x.correction, y.correction) && same(x.rate, y.rate);
}

/// 40 steps of a pack and of the plain stepper; gives the largest difference of the evaluations of two lanes
/// in a step.
template <class Packed, class Plain, int Dof>
std::int64_t compare(const Packed& packed, const Plain& plain,
                     const std::vector<PhasePoint<double, Dof>>& starts, double dt,
                     const SimplifiedNewton& solver) {
  const auto scheme = schemes::yoshida6<double>();
  SemiexplicitPack pack(packed, scheme, solver);
  PackPoint<Dof> point(starts[0].dof());
  std::vector<Semiexplicit<Plain>> steppers(lanes, Semiexplicit(plain, scheme, solver));
  auto states = starts;
  for (std::size_t k = 0; k < lanes; ++k) point.set_lane(k, starts[k]);
  std::int64_t spread = 0;
  for (int n = 0; n < 40; ++n) {
    const PackReport report = pack.step(point, dt);
    std::int64_t least = report[0].evaluations, most = least;
    for (std::size_t k = 0; k < lanes; ++k) {
      CAPTURE(n, k);
      REQUIRE(same(report[k], steppers[k].step(states[k], dt)));
      REQUIRE(same_bits(point.lane(k), states[k]));
      least = std::min(least, report[k].evaluations);
      most = std::max(most, report[k].evaluations);
    }
    spread = std::max(spread, most - least);
  }
  return spread;
}

template <int N>
std::vector<PhasePoint<double, N>> starts(Eigen::Index sites) {
  std::vector<PhasePoint<double, N>> list;
  for (std::size_t k = 0; k < lanes; ++k) list.push_back(lattice_state<N>(sites, int(7 * k / (lanes - 1))));
  return list;
}

/// The time goes in and changes nothing.
template <class S>
struct Driven {
  using Scalar = S;
  static constexpr int Dof = 1;
  void gradient(const S&, In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    Product<S>().gradient(q, p, dHdq, dHdp);
  }
};

/// As the README has it: one template parameter for both halves of the gradient.
struct Deduced {
  using Scalar = double;
  using PackGradientOf = Deduced;
  static constexpr int Dof = 1;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1.0);
    dHdp[0] = p[0] * (q[0] * q[0] + 1.0);
  }
};

}  // namespace

TEST_CASE("A lane takes the very step of the plain stepper") {
  const systems::NlsLattice<double, 5> packed;
  const Lattice<5> plain;
  CHECK(compare(packed, plain, starts<5>(5), 0.03, {}) >= 1);
  CHECK(compare(packed, plain, starts<5>(5), 0.03, {.stop = StoppingRule::paper(1e-13)}) >= 3);
  CHECK(compare(packed, plain, starts<5>(5), 0.03, {.stop = StoppingRule::paper(1e-17)}) >= 3);
  // A lane that is given up keeps its state.
  CHECK(compare(packed, plain, starts<5>(5), 0.1,
                {.stop = StoppingRule::product(1e-22), .max_iterations = 5}) >= 1);
}

TEST_CASE("A lane takes the very step of the plain stepper: size known at run time, any size of state") {
  constexpr int dynamic = Eigen::Dynamic;
  compare(systems::NlsLattice<double>(7), Lattice<dynamic>{systems::NlsLattice<double>(7)},
          starts<dynamic>(7), 0.02, {});
  // Squares of large and small states have no room in the exponent.
  std::vector<PhasePoint<double, 1>> sizes(lanes, PhasePoint<double, 1>(-1, 0.5));
  sizes[0].vector() *= 1e-170;
  sizes[1].vector() *= 1e170;
  if (lanes > 2) sizes[2].vector() *= 0;
  compare(Quadratic<RegisterPack<double>>(), Quadratic<double>(), sizes, 0.5, {});
  compare(Quadratic<RegisterPack<double>>(), Quadratic<double>(), sizes, 0.5,
          {.stop = StoppingRule::product(1e-24)});
}

TEST_CASE("Vortices in lanes agree with the plain stepper to rounding") {
  // Their reciprocals are another approximation in packs.
  const systems::PointVortices<double, 4> vortices(Eigen::Vector4d{1, 2, -0.5, 1.5});
  const auto scheme = schemes::low_defect6_s13<double>();
  SemiexplicitPack pack(vortices, scheme);
  PackPoint<4> point(4);
  std::vector<PhasePoint<double, 4>> states;
  for (std::size_t k = 0; k < lanes; ++k) {
    states.push_back(vortices.phase_point({1, -1, 0.3 * double(k), 2}, {0, 0.5, 3, -1}));
    point.set_lane(k, states.back());
  }
  for (int n = 0; n < 50; ++n) pack.step(point, 0.1);
  for (std::size_t k = 0; k < lanes; ++k) {
    Semiexplicit plain(vortices, scheme);
    integrate(plain, states[k], {.dt = 0.1, .steps = 50});
    CHECK((point.lane(k).vector() - states[k].vector()).norm() <= 1e-13 * states[k].vector().norm());
  }
}

TEST_CASE("A lane that fails keeps its state, and the others go on as if it were not there") {
  const double not_a_number = std::numeric_limits<double>::quiet_NaN();
  const auto scheme = schemes::low_defect4_s7<double>();
  const std::vector<PhasePoint<double, 5>> good = starts<5>(5);
  for (const double bad : {not_a_number, 1e170, 60.0}) {
    CAPTURE(bad);
    SemiexplicitPack undisturbed(systems::NlsLattice<double, 5>(), scheme), disturbed = undisturbed;
    PackPoint<5> x(5), y(5);
    for (std::size_t k = 0; k < lanes; ++k) {
      x.set_lane(k, good[k]);
      y.set_lane(k, good[k]);
    }
    auto broken = good[1];
    broken.q()[2] = bad;
    y.set_lane(1, broken);
    for (int n = 0; n < 20; ++n) {
      undisturbed.step(x, 0.01);
      const PackReport report = disturbed.step(y, 0.01);
      CHECK(report[1].status == (std::isnan(bad) ? Status::invalid_state
                                 : bad > 1e100   ? Status::not_finite
                                                 : report[1].status));
      CHECK_FALSE(report[1].ok());
    }
    for (std::size_t k = 0; k < lanes; ++k) CHECK(same_bits(y.lane(k), k == 1 ? broken : x.lane(k)));
  }
}

TEST_CASE("A step that cannot be is refused in every lane, and lanes that are not wanted rest") {
  SemiexplicitPack pack(Product<RegisterPack<double>>{}, schemes::strang<double>());
  PackPoint<1> point(1), other(2);
  for (std::size_t k = 0; k < lanes; ++k) point.set_lane(k, PhasePoint<double, 1>(-1, 0.5));
  const auto start = point.lane(0);
  for (const double dt : {0.0, std::numeric_limits<double>::infinity(), std::nan("")})
    for (const StepReport& report : pack.step(point, dt)) CHECK(report.status == Status::invalid_step);
  for (const StepReport& report : pack.step(other, 0.1)) CHECK(report.status == Status::invalid_state);
  LaneChoice wanted{};
  wanted[1] = true;
  CHECK(pack.step(point, 0.1, wanted)[1].ok());
  for (std::size_t k = 0; k < lanes; ++k) CHECK(same_bits(point.lane(k), start) == (k != 1));

  Scheme<double> edited = schemes::strang<double>();
  edited.b[0] = 0.9;
  CHECK(refuses([&] { SemiexplicitPack(Product<RegisterPack<double>>{}, edited); }, "b sums to 0.9"));
}

TEST_CASE("A lane of a driven system judges itself by q and p, not by the time") {
  // As Semiexplicit does: at a late time the size of t would loosen every tolerance.
  const Autonomous driven(Driven<double>{});
  const Autonomous driven_lanes(Driven<RegisterPack<double>>{});
  for (const double t0 : {0.0, 1e6}) {
    CAPTURE(t0);
    const SimplifiedNewton solver{.stop = StoppingRule::product(1e-24)};
    Semiexplicit plain(driven, schemes::blanes_moan4(), solver);
    SemiexplicitPack pack(driven_lanes, schemes::blanes_moan4(), solver);
    PackPoint<2> point(2);
    auto z = driven.extended({1, 0.5}, t0);
    for (std::size_t k = 0; k < lanes; ++k) point.set_lane(k, z);
    for (int n = 0; n < 20; ++n) {
      const auto one = plain.step(z, 0.1);
      const auto many = pack.step(point, 0.1);
      REQUIRE(one.ok());
      CHECK(one.evaluations == many[0].evaluations);
    }
    CHECK((point.lane(0).vector() - z.vector()).norm() < 1e-9);
  }
}

TEST_CASE("A gradient that deduces one type for both halves takes packs") {
  SemiexplicitPack deduced(Deduced{}, schemes::blanes_moan4());
  SemiexplicitPack written(Product<RegisterPack<double>>{}, schemes::blanes_moan4());
  PackPoint<1> x(1), y(1);
  for (std::size_t k = 0; k < lanes; ++k) {
    x.set_lane(k, {-1, 0.5});
    y.set_lane(k, {-1, 0.5});
  }
  CHECK(deduced.step(x, 0.05)[0].ok());
  CHECK(written.step(y, 0.05)[0].ok());
  CHECK(same_bits(x.lane(0), y.lane(0)));
}

TEST_CASE("A point of another size has no place in a pack") {
  PackPoint<Eigen::Dynamic> z(2);
  CHECK(refuses([&] { z.set_lane(0, PhasePoint<double, Eigen::Dynamic>(3)); },
                "PackPoint: the state has 3 degrees of freedom and the pack 2"));
  CHECK(refuses([&] { z.set_lane(0, PhasePoint<double, Eigen::Dynamic>(1)); }, "PackPoint"));
}

TEST_CASE("A pack that was moved from says so") {
  SemiexplicitPack from(systems::NlsLattice<double, 3>(), schemes::strang<double>());
  SemiexplicitPack to = std::move(from);
  PackPoint<3> z(3);
  for (std::size_t k = 0; k < lanes; ++k) z.set_lane(k, {{1, 0.5, 0.2}, {0, 0.1, 0.3}});
  const auto before = z.lane(0);
  for (const StepReport& lane : from.step(z, 0.01))  // NOLINT: that is what is tested
    CHECK(lane.status == Status::invalid_stepper);
  CHECK(z.lane(0).vector() == before.vector());
  CHECK(to.step(z, 0.01)[0].ok());
}

}  // namespace test_pack
