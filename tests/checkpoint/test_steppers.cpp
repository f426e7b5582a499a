#include "catch.hpp"

#include <cstdint>
#include <filesystem>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"

namespace test_steppers {

// Runs that are interrupted and gone on with end as those that are not.

namespace {

using namespace semiexplicit;
namespace fs = std::filesystem;

const systems::NlsLattice<double, 2> lattice;
const PhasePoint<double, 2> lattice_start({1, 0.5}, {0.4, -0.7});
const Scene kepler(effects::orbits::Kinetic<double, 2>{}, effects::orbits::Attraction<double, 2>{.gm = 1});
const PhasePoint<double, 2> kepler_start({0.7, 0}, {0, 1.3});

/// Bit for bit.
template <class Scalar, int Dof>
bool same(const PhasePoint<Scalar, Dof>& u, const PhasePoint<Scalar, Dof>& v) {
  return u.vector() == v.vector();
}
template <class Scalar, int Dof>
bool same(const ExtendedPoint<Scalar, Dof>& u, const ExtendedPoint<Scalar, Dof>& v) {
  return same(u.a, v.a) && same(u.b, v.b);
}

/// Whether runs that are interrupted after some steps end as one that is not.
template <class S, class State>
bool goes_on(const S& fresh, const State& start) {
  using Scalar = typename S::Scalar;
  const Folder folder;
  const fs::path file = folder.path / "run.checkpoint";
  using Seen = Invariants<Scalar, S::Dof>;
  const auto follow = [](Seen& seen) {
    seen.add("size", [](const auto& q, const auto& p) { return q.squaredNorm() + p.squaredNorm(); });
  };
  IntegrationOptions<Scalar> options{.dt = Scalar(0.04), .steps = 40, .t0 = Scalar(0.3)};
  S whole = fresh;
  State z = start;
  Seen seen;
  follow(seen);
  const IntegrationReport report = integrate(whole, z, options, seen);

  bool all_same = true;
  for (const std::int64_t interrupted : {1, 2, 3, 17, 39}) {
    {
      S first = fresh;
      State lost = start;
      Seen lost_seen;
      follow(lost_seen);
      IntegrationOptions<Scalar> part = options;
      part.steps = interrupted;
      Checkpoints checkpoints(file, {.every = interrupted}, first, options, lost_seen);
      integrate(first, lost, part, lost_seen, checkpoints);
    }
    S second = fresh;
    State y = start;
    Seen seen_on;
    follow(seen_on);
    Checkpoints checkpoints(file, {.every = 1000}, second, options, seen_on);
    options.done = checkpoints.resume(y);
    const IntegrationReport on = integrate(second, y, options, seen_on, checkpoints);
    const auto &a = seen["size"], &b = seen_on["size"];
    all_same = all_same && options.done.steps == interrupted && same(y, z) && on.t == report.t &&
               on.steps == report.steps && on.gradients == report.gradients &&
               on.evaluations == report.evaluations && on.max_correction == report.max_correction &&
               a.worst == b.worst && a.worst_time == b.worst_time && a.final == b.final;
    options.done = {};
  }
  return all_same;
}

}  // namespace

TEST_CASE("Every stepper goes on bit for bit", "[checkpoint]") {
  const auto scheme = schemes::low_defect4_s7<double>();
  CHECK(goes_on(Semiexplicit(lattice, scheme), lattice_start));
  CHECK(goes_on(Semiexplicit(lattice, scheme, Robust{.stop = StoppingRule::product(1e-24)}), lattice_start));
  CHECK(goes_on(MidpointProjection(lattice, scheme), lattice_start));
  CHECK(goes_on(ExplicitSplitting(kepler, schemes::blanes_moan4<double>()), kepler_start));
  CHECK(goes_on(GaussLegendre(lattice, {.stages = 3}), lattice_start));
  CHECK(goes_on(GaussLegendre(lattice, {.stages = 2, .solver = StageSolver::newton, .tolerance = 1e-13}),
                lattice_start));
  CHECK(goes_on(GaussLegendreLanes(systems::Product<double>{}, {.stages = 5}), PhasePoint<double, 1>(-3, 0)));
  CHECK(goes_on(Pihajoki(lattice, scheme), ExtendedPoint(lattice_start)));
  CHECK(goes_on(Tao(lattice, schemes::strang<double>(), 20.0), ExtendedPoint(lattice_start)));

  const systems::NlsLattice<double> chain(7);  // whose size is known at run time
  PhasePoint<double, Eigen::Dynamic> z(7);
  z.q().setConstant(0.3);
  z.p()[2] = 1;
  CHECK(goes_on(GaussLegendre(chain, {.stages = 2}), z));
  CHECK(goes_on(Semiexplicit(systems::Product<long double>{}, schemes::strang<long double>()),
                PhasePoint<long double, 1>(-3, 0)));
}

}  // namespace test_steppers
