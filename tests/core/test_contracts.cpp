#include "catch.hpp"

#include <string>
#include <utility>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_contracts {

// What classes know of each other they know by their types, not by the names of members.

namespace {

using namespace semiexplicit;

struct Plain : systems::NlsLattice<double, 2> {};
/// With members that mean something else elsewhere.
struct WithNames : systems::NlsLattice<double, 2> {
  double time(const PhasePoint<double, 2>&) const { return 7; }
  PhasePoint<double, 2> point(const PhasePoint<double, 2>&) const {
    return PhasePoint<double, 2>({0, 0}, {0, 0});
  }
};

struct WithFresh {  // an observer with a member that has another meaning than that of the library's observers
  int calls = 0;
  bool fresh() const { return calls < 1000; }
  void operator()(double, const PhasePoint<double, 2>&) { ++calls; }
};

const PhasePoint<double, 2> start({0.01, 3}, {0.01, 1});

template <class H>
auto stepper_of(H h) {
  return Semiexplicit(std::move(h), schemes::strang(), SimplifiedNewton{.stop = StoppingRule::product(1e-8)});
}

}  // namespace

TEST_CASE("A member called time() or point() changes nothing", "[contracts]") {
  static_assert(!InExtendedPhaseSpace<WithNames>);
  const auto run = [](auto h) {
    auto stepper = stepper_of(h);
    auto z = start;
    double seen = 0;
    std::int64_t crossings = 0;
    auto at =
        at_times(h, {0.005, 0.5}, [&](double t, const PhasePoint<double, 2>& w) { seen += t * w.q()[1]; });
    auto section = poincare_section(
        h, [](const auto& q, const auto&) { return q[1]; },
        [&](double t, const PhasePoint<double, 2>& w) { seen += t * w.p()[1], ++crossings; });
    const IntegrationReport report = integrate(stepper, z, {.dt = 0.02, .steps = 1000}, at, section);
    CHECK(crossings > 10);
    return std::pair(report.evaluations, seen + z.q()[0]);
  };
  CHECK(run(WithNames()) == run(Plain()));
}

TEST_CASE("A member called fresh() of an observer without memory does not stop a resumed run",
          "[contracts]") {
  auto stepper = stepper_of(Plain());
  auto z = start;
  IntegrationOptions<double> options{.dt = 0.02, .steps = 10};
  options.done = integrate(stepper, z, options);
  options.steps = 20;
  WithFresh observer;
  CHECK(integrate(stepper, z, options, observer).steps == 20);
  CHECK(observer.calls == 10);
}

struct WithMemory : WithFresh {  // and does not list its options
  void visit_memory(auto&& visit) { visit(calls); }
};
/// A stepper that neither lists its options nor shows its memory.
struct Own {
  using Scalar = double;
  using State = PhasePoint<double, 2>;
  decltype(stepper_of(Plain())) inner = stepper_of(Plain());
  StepReport step(State& z, const double& dt) { return inner.step(z, dt); }
  Eigen::Index dof() const { return 2; }
};

TEST_CASE("An observer with memory that is fresh stops a resumed run, whether or not it can be saved",
          "[contracts]") {
  auto stepper = stepper_of(Plain());
  const auto resumed = [&](auto observer) {
    auto z = start;
    IntegrationOptions<double> options{.dt = 0.02, .steps = 10};
    options.done = integrate(stepper, z, options);
    options.steps = 20;
    return refusal([&] { integrate(stepper, z, options, observer); });
  };
  CHECK(says(resumed(WithMemory()), "an observer knows nothing of what came before"));
  CHECK(says(resumed(with_error_estimate(stepper)), "an observer knows nothing of what came before"));
  CHECK(says(resumed(with_error_estimate(Own())), "an observer knows nothing of what came before"));
}

TEST_CASE("A stepper that was moved from says so", "[contracts]") {
  const auto scheme = schemes::strang<double>();
  const auto check = [](auto from, auto z) {
    const auto before = z;
    auto to = std::move(from);
    const StepReport report = from.step(z, 0.01);  // NOLINT: that is what is tested
    CHECK((report.status == Status::invalid_stepper || report.status == Status::invalid_state));
    CHECK(says(describe(Status::invalid_stepper), "moved from"));
    if constexpr (requires { z.vector(); })
      CHECK(z.vector() == before.vector());
    else
      CHECK(z.a.vector() == before.a.vector());
    CHECK(to.step(z, 0.01).ok());
  };
  const auto each = [&](const auto& h, const auto& z) {
    check(Semiexplicit(h, scheme), z);
    check(Semiexplicit(h, scheme, Broyden{}), z);
    check(Semiexplicit(h, scheme, NewtonKrylov{}), z);
    check(Semiexplicit(h, scheme, Robust{}), z);
    check(Semiexplicit(h, scheme, SimplifiedNewton{}, Summation::plain), z);
    check(MidpointProjection(h, scheme), z);
    check(GaussLegendre(h), z);
    check(GaussLegendre(h, {.stages = 3, .solver = StageSolver::newton}), z);
    check(Pihajoki(h, scheme), ExtendedPoint(z));
    check(Tao(h, scheme, 3.0), ExtendedPoint(z));
  };
  each(systems::NlsLattice<double, 2>(), start);
  PhasePoint<double, Eigen::Dynamic> dynamic(2);
  dynamic.vector() = start.vector();
  each(systems::NlsLattice<double, Eigen::Dynamic>(2), dynamic);
  check(GaussLegendreLanes(systems::Product<double>(), {.stages = 2}), PhasePoint<double, 1>(1, 0));
  check(stepper_for(Scene(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{})),
        PhasePoint<double, 2>({1, 0}, {0, 1}));
}

TEST_CASE("Observers and tangent maps that were moved from do not crash", "[contracts]") {
  const systems::NlsLattice<double, 2> h;
  auto stepper = stepper_of(Plain());
  auto z = start;
  DenseOutput dense(h);
  for (int n = 0; n < 6; ++n) dense(0.1 * n, z);
  DenseOutput moved = std::move(dense);
  moved(0.6, z);
  dense(0.6, z);
  TangentMap tangent(stepper);
  const auto taken = std::move(tangent);
  CHECK(tangent.at(z, 0.01) != Status::success);
  auto at = at_times(h, {0.0, 0.05}, [](double, const PhasePoint<double, 2>&) {});
  auto other = std::move(at);
  integrate(stepper, z, {.dt = 0.01, .steps = 10}, at);
  CHECK(at.served() == 0);
  integrate(stepper, z, {.dt = 0.01, .steps = 10}, other);
  CHECK(other.served() == 2);
}

TEST_CASE("Exponents, alignment and scenes that were moved from refuse by name, of any size", "[contracts]") {
  namespace lattice = effects::lattice;
  const auto check = [](const auto& scene, const auto& z0) {
    auto stepper = stepper_for(scene);
    const auto refuses_run = [&](auto from) {
      const auto to = std::move(from);
      auto z = z0;
      return refuses(
          [&] {
            integrate(stepper, z, {.dt = 0.01, .steps = 1}, from);  // NOLINT: that is what is tested
          },
          "it was moved from; use the one that it was moved to");
    };
    CHECK(refuses_run(LyapunovExponents(stepper, 2)));
    CHECK(refuses_run(AlignmentIndex(stepper, 2)));
  };
  const auto check_scene = [](auto from, const auto& z0) {
    const auto to = std::move(from);
    CHECK(from.dof() == 0);  // NOLINT: that is what is tested
    auto stepper = stepper_for(from);
    auto z = z0;
    CHECK(stepper.step(z, 0.01).status == Status::invalid_state);
    CHECK(z.vector() == z0.vector());
    CHECK(refuses([&] { LyapunovExponents(stepper, 2); },
                  "LyapunovExponents: the stepper has no degree of freedom"));
  };
  const Scene fixed(lattice::OnSite<double, 2>{}, lattice::PairExchange<double, 2>{});
  const Scene dynamic(lattice::OnSite<>{.sites = 2}, lattice::PairExchange<>{.sites = 2});
  const PhasePoint<double, 2> z = start;
  PhasePoint<double, Eigen::Dynamic> of_any_size(2);
  of_any_size.vector() = z.vector();
  check(fixed, z);
  check(dynamic, of_any_size);
  // Nor do books lose their accounts.
  const Scene lossy(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{},
                    effects::orbits::Drag<double, 2>{.linear = 0.1});
  Books books(lossy);
  const auto moved = std::move(books);
  auto orbit = PhasePoint<double, 2>({1, 0}, {0, 1});
  auto damped = stepper_for(lossy);
  integrate(damped, orbit, {.dt = 0.01, .steps = 10}, books);  // NOLINT: that is what is tested
  CHECK(books.work("drag") < 0);
  CHECK(moved.names() == books.names());
  // Scenes of run time share their effects, and lose none.
  const auto check_kept = [](auto from, const auto& z0) {
    const auto to = std::move(from);
    auto at = z0, expected = z0;
    CHECK(from.dof() == 2);  // NOLINT: that is what is tested
    CHECK(stepper_for(from).step(at, 0.01).ok());
    CHECK(stepper_for(to).step(expected, 0.01).ok());
    CHECK(at.vector() != z0.vector());
    CHECK(at.vector() == expected.vector());
  };
  check_kept(RuntimeScene(dynamic), of_any_size);
  check_kept(RuntimeScene(fixed), z);
  check_kept(SeparableRuntimeScene<double, 2>(
                 {effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{}}),
             z);
  const effects::nbody::Bodies<> bodies({1, 0.1});
  auto two = bodies.jacobi({{1, 0, 0}, {0, 0, 0}}, {{0, 1, 0}, {0, 0, 0}});
  check_scene(Scene(effects::nbody::Kinetic<>{bodies}, effects::nbody::Attraction<>{bodies}), two);
}

}  // namespace test_contracts
