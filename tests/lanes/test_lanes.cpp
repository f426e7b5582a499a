// Compiled for the processor at hand (see tests/CMakeLists.txt). Where that has AVX-512, small systems run in registers;
// here they are held against the same systems without that path.

#include <cmath>

#include "catch.hpp"

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

namespace {

/// The same lattice, its gradient alone.
template <int N>
struct PlainLattice {
  using Scalar = double;
  static constexpr int Dof = N;
  systems::NlsLattice<double, N> lattice;
  void gradient(const ConstRef<double, N>& q, const ConstRef<double, N>& p, Ref<double, N> dHdq,
                Ref<double, N> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
};

/// A type with another gradient does not take over the lanes of its base.
struct Changed : systems::NlsLattice<double, 5> {
  void gradient(const ConstRef<double, 5>& q, const ConstRef<double, 5>& p, Ref<double, 5> dHdq,
                Ref<double, 5> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(Hamiltonian<Changed> && !HasLaneGradient<Changed>);

#ifdef SEMIEXPLICIT_HAS_LANES
static_assert(HasLaneGradient<systems::NlsLattice<double, 1>> &&
              HasLaneGradient<systems::NlsLattice<double, 8>>);
#endif
static_assert(!HasLaneGradient<PlainLattice<5>> && !HasLaneGradient<systems::NlsLattice<double, 9>> &&
              !HasLaneGradient<systems::NlsLattice<float, 5>> &&
              !HasLaneGradient<systems::NlsLattice<double>>);

template <int N>
void compare() {
  PhasePoint<double, N> start;
  for (int i = 0; i < N; ++i) {
    start.q()[i] = std::cos(i);
    start.p()[i] = 0.5 * std::sin(1 + 2 * i);
  }
  const auto scheme = schemes::yoshida6<double>();
  const auto distance = [](const auto& u, const auto& v) {
    return (u.vector() - v.vector()).norm() / u.vector().norm();
  };

  SECTION("projected, more than one evaluation a step") {
    Semiexplicit lanes(systems::NlsLattice<double, N>(), scheme, Broyden{.stop = StoppingRule::paper(1e-15)});
    Semiexplicit plain(PlainLattice<N>{}, scheme, Broyden{.stop = StoppingRule::paper(1e-15)});
    auto u = start, v = start;
    const auto report = integrate(lanes, u, {.dt = 0.05, .steps = 50});
    integrate(plain, v, {.dt = 0.05, .steps = 50});
    CHECK(report.evaluations > 50);
    CHECK(distance(u, v) < 1e-13);
  }
  SECTION("unprojected") {
    Pihajoki lanes(systems::NlsLattice<double, N>(), scheme);
    Pihajoki plain(PlainLattice<N>{}, scheme);
    ExtendedPoint u(start), v(start);
    for (int i = 0; i < 50; ++i) {
      REQUIRE(lanes.step(u, 2e-3).ok());
      REQUIRE(plain.step(v, 2e-3).ok());
    }
    CHECK(distance(u.a, v.a) < 1e-13);
    CHECK(distance(u.b, v.b) < 1e-13);
  }
}

}  // namespace

TEST_CASE("Small systems in registers take the steps of the plain code: 1 site") { compare<1>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 2 sites") { compare<2>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 5 sites") { compare<5>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 8 sites") { compare<8>(); }
