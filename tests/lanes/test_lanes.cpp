// Compiled for the processor at hand (see tests/CMakeLists.txt). Where that has AVX-512, small systems run in
// registers; here they are held against the same systems without that path.

#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "catch.hpp"

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_lanes {

using namespace semiexplicit;

namespace {

/// The same lattice, its gradient alone.
template <int N>
struct PlainLattice {
  using Scalar = double;
  static constexpr int Dof = N;
  systems::NlsLattice<double, N> lattice;
  void gradient(const In<double, N>& q, const In<double, N>& p, Out<double, N> dHdq,
                Out<double, N> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
};

/// A type with another gradient does not take over the lanes of its base.
struct Changed : systems::NlsLattice<double, 5> {
  void gradient(const In<double, 5>& q, const In<double, 5>& p, Out<double, 5> dHdq,
                Out<double, 5> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
static_assert(Hamiltonian<Changed> && !HasLaneGradient<Changed>);

#ifdef SEMIEXPLICIT_HAS_LANES
static_assert(HasLaneGradient<systems::NlsLattice<double, 1>> &&
              HasLaneGradient<systems::NlsLattice<double, 8>> &&
              HasLaneGradient<systems::PointVortices<double, 10>>);
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
  SECTION("coupled") {
    Tao lanes(systems::NlsLattice<double, N>(), scheme, 7.0);
    Tao plain(PlainLattice<N>{}, scheme, 7.0);
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

TEST_CASE("Vortices in registers feel what they feel in wider numbers") {
  const auto check = [](auto n) {
    constexpr int N = n.value;
    CAPTURE(N);
    Vector<double, N> circulation, x, y;
    for (int i = 0; i < N; ++i) {
      circulation[i] = std::cos(3.0 * i) + 1.5 * (i % 2) - 0.2;
      x[i] = 2.0 * (i % 9) + 0.3 * std::sin(1 + 2.3 * i);
      y[i] = 2.0 * (i / 9) + 0.3 * std::cos(0.7 * i * i);
    }
    const systems::PointVortices<double, N> fixed(circulation);
    const systems::PointVortices<double> dynamic(circulation);
    const systems::PointVortices<long double, N> wide(circulation.template cast<long double>());
    const auto z = fixed.phase_point(x, y);
    const Vector<long double, N> q = z.q().template cast<long double>(),
                                 p = z.p().template cast<long double>();
    Vector<long double, N> dq, dp;
    wide.gradient(q, p, dq, dp);
    const auto close = [&](const auto& gradient_q, const auto& gradient_p) {
      const auto error = (gradient_q.template cast<long double>() - dq).norm() +
                         (gradient_p.template cast<long double>() - dp).norm();
      return error <= 5e-15L * (dq.norm() + dp.norm());
    };
    Vector<double, N> a, b;
    fixed.gradient(z.q(), z.p(), a, b);
    CHECK(close(a, b));
    Eigen::VectorXd c(N), d(N);
    dynamic.gradient(z.q(), z.p(), c, d);
    CHECK(close(c, d));
#ifdef SEMIEXPLICIT_HAS_LANES
    if constexpr (HasLaneGradient<systems::PointVortices<double, N>>) {
      detail::LanePoint<N> at, gradient;
      at.load(z.vector().data());
      fixed.lane_gradient(at.data, at.data + at.d, gradient.data, gradient.data + at.d);
      double all[32];
      for (int k = 0; k < registers_for(N); ++k) {
        _mm512_storeu_pd(all + 8 * k, gradient.data[k]);
        _mm512_storeu_pd(all + 16 + 8 * k, gradient.data[at.d + k]);
      }
      CHECK(close(Eigen::Map<Vector<double, N>>(all), Eigen::Map<Vector<double, N>>(all + 16)));
      for (int i = N; i < 8 * registers_for(N); ++i) CHECK((all[i] == 0 && all[16 + i] == 0));
    }
#endif
    std::vector<Pack<double>> at(2 * N), gradient(2 * N);
    for (int i = 0; i < 2 * N; ++i) at[std::size_t(i)] = z.vector()[i];
    fixed.gradient(at.data(), at.data() + N, gradient.data(), gradient.data() + N);
    for (int i = 0; i < N; ++i) {
      c[i] = gradient[std::size_t(i)][7];
      d[i] = gradient[std::size_t(N + i)][7];
    }
    CHECK(close(c, d));
  };
  [&]<int... Ns>(std::integer_sequence<int, Ns...>) { (check(std::integral_constant<int, Ns>()), ...); }
  (std::integer_sequence<int, 3, 7, 9, 10, 16, 70>());
}

TEST_CASE("Vortices that coincide give no finite gradient, in registers as elsewhere") {
  Vector<double, 10> circulation, x, y;
  for (int i = 0; i < 10; ++i) {
    circulation[i] = 1 + i;
    x[i] = i;
    y[i] = i * i;
  }
  for (const auto& [i, j] : {std::pair(0, 7), std::pair(3, 9), std::pair(8, 9)}) {
    CAPTURE(i, j);
    auto same_x = x, same_y = y;
    same_x[j] = x[i];
    same_y[j] = y[i];
    const systems::PointVortices<double, 10> vortices(Vector<double, 10>::Ones());
    Vector<double, 10> dq, dp;
    const auto z = vortices.phase_point(same_x, same_y);
    vortices.gradient(z.q(), z.p(), dq, dp);
    CHECK_FALSE((std::isfinite(dq[i]) && std::isfinite(dq[j])));
  }
}

TEST_CASE("Small systems in registers take the steps of the plain code: 1 site") { compare<1>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 2 sites") { compare<2>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 5 sites") { compare<5>(); }
TEST_CASE("Small systems in registers take the steps of the plain code: 8 sites") { compare<8>(); }

TEST_CASE("Sines in packs are right at any angle, and no lane depends on the others") {
  using Many = RegisterPack<double>;
  std::mt19937_64 random(1);
  double worst = 0;
  int others = 0;
  for (const double size : {1.0, 10.0, 700.0, 1e4, 1e8, 1e9, 1e10, 1e15})
    for (const double other : {1e-3, 1e12, std::nan("")})
      for (int n = 0; n < 1000; ++n) {
        std::uniform_real_distribution<double> angle(-size, size);
        Many x;
        for (std::size_t k = 0; k < Many::size(); ++k) x[k] = angle(random);
        Many beside = x;
        if (Many::size() > 1) beside[Many::size() - 1] = other;
        const Many s = sin(x), c = cos(x), s_beside = sin(beside), c_beside = cos(beside);
        for (std::size_t k = 0; k < Many::size(); ++k) {
          const double at = x[k];
          worst = std::max({worst, std::abs(s[k] - std::sin(at)), std::abs(c[k] - std::cos(at))});
          if (k + 1 < Many::size()) others += s[k] != s_beside[k] || c[k] != c_beside[k];
        }
      }
  CHECK(worst <= 3e-16);
  CHECK(others == 0);
}

/// A system in one register whose gradient there has a factor of its own.
struct OtherInLanes {
  using Scalar = double;
  using LaneGradientOf = OtherInLanes;
  static constexpr int Dof = 3;
  double factor;
  double energy(In<double, 3> q, In<double, 3> p) const { return (p.squaredNorm() + q.squaredNorm()) / 2; }
  void gradient(In<double, 3> q, In<double, 3> p, Out<double, 3> dHdq, Out<double, 3> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
#ifdef SEMIEXPLICIT_HAS_LANES
  void lane_gradient(const Lanes* q, const Lanes* p, Lanes* dHdq, Lanes* dHdp) const {
    dHdq[0] = q[0];
    dHdp[0] = factor * p[0];
  }
#endif
};

TEST_CASE("check_gradient compares the gradient on registers") {
  const PhasePoint<double, 3> z({0.3, -0.4, 0.5}, {1, 2, -3});
  CHECK(check_gradient(OtherInLanes{1}, z).ok());
  const auto check = check_gradient(OtherInLanes{-1}, z);
  CHECK(check.ok() != HasLaneGradient<OtherInLanes>);
  CHECK(check.entries[5].wrong == HasLaneGradient<OtherInLanes>);
  CHECK_FALSE(check.entries[2].wrong);
}

#ifdef __cpp_lib_experimental_parallel_simd
TEST_CASE("A masked assignment of packs is one of each lane") {
  const auto check = []<class Many>(const Many&) {
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> number(0, 1);
    int wrong = 0;
    for (int n = 0; n < 1000; ++n) {
      const Many x([&](auto) { return number(random); }), y([&](auto) { return number(random); });
      Many assigned = x, multiplied = x;
      where(x < y, assigned) = y;
      where(x < y, multiplied) *= y;
      for (std::size_t k = 0; k < Many::size(); ++k) {
        const double a = x[k], b = y[k];
        wrong += assigned[k] != (a < b ? b : a) || multiplied[k] != (a < b ? a * b : a);
      }
    }
    CHECK(wrong == 0);
  };
  check(RegisterPack<double>());
  check(Pack<double>());
}
#endif

}  // namespace test_lanes
