#include "catch.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "henon_heiles.hpp"
#include "refusal.hpp"

namespace test_lyapunov {

// Lyapunov exponents: closed forms, another integrator's variational equations, order and chaos.

namespace {

using namespace semiexplicit;

struct WithHessian : HenonHeiles {
  void hessian(In<double, 2> q, In<double, 2>, Eigen::Ref<Eigen::Matrix4d> h) const {
    h.setZero();
    h(0, 0) = 1 + 2 * q[1];
    h(0, 1) = h(1, 0) = 2 * q[0];
    h(1, 1) = 1 - 2 * q[1];
    h(2, 2) = h(3, 3) = 1;
  }
};

Semiexplicit henon_heiles(WithHessian{}, schemes::low_defect6_s13());

/// arcosh of half the trace of the map over a period π of x'' = -(1 - cos 2t) x, by Runge and Kutta's method.
double floquet_of_mathieu() {
  using State = std::array<double, 4>;
  State s{1, 0, 0, 1};
  boost::numeric::odeint::runge_kutta_fehlberg78<State> stepper;
  const auto motion = [](const State& u, State& rate, double t) {
    const double k = 1 - std::cos(2 * t);
    rate = {u[1], -k * u[0], u[3], -k * u[2]};
  };
  const double pi = std::acos(-1.0);
  for (int n = 0; n < 100; ++n) stepper.do_step(motion, s, n * pi / 100, pi / 100);
  return std::acosh(std::abs(s[0] + s[3]) / 2) / pi;
}

}  // namespace

TEST_CASE("The growth is that of the variational equations by another integrator", "[lyapunov]") {
  auto z = HenonHeiles::point(-0.25);
  LyapunovExponents lyapunov(
      henon_heiles);  // all four: their sum is that of no frame, the first is that of one vector
  LyapunovExponents first(henon_heiles, 1);
  integrate(henon_heiles, z, {.dt = 0.05, .steps = 2000}, lyapunov, first);

  // The same vector by Runge and Kutta, with the Jacobian written out once more.
  using State = std::array<double, 8>;
  State s{0, -0.25, HenonHeiles::point(-0.25).p()[0], 0, 0, 0, 0, 0};
  double norm = 0;
  for (int i = 0; i < 4; ++i) s[static_cast<std::size_t>(4 + i)] = std::sin(0.7 * (i + 1) * (i + 1));
  for (std::size_t i = 4; i < 8; ++i) norm += s[i] * s[i];
  for (std::size_t i = 4; i < 8; ++i) s[i] /= std::sqrt(norm);
  boost::numeric::odeint::runge_kutta_fehlberg78<State> stepper;
  const auto motion = [](const State& u, State& rate, double) {
    const auto& [x, y, px, py, dx, dy, dpx, dpy] = u;
    rate = {px,
            py,
            -x - 2 * x * y,
            -y - x * x + y * y,
            dpx,
            dpy,
            -(1 + 2 * y) * dx - 2 * x * dy,
            -2 * x * dx - (1 - 2 * y) * dy};
  };
  for (int n = 0; n < 4000; ++n) stepper.do_step(motion, s, 0.0, 0.025);
  const double length = std::hypot(std::hypot(s[4], s[5]), std::hypot(s[6], s[7]));
  CHECK(std::abs(z.q()[0] - s[0]) <= 1e-6);  // the orbits have not parted yet
  CHECK(lyapunov.exponents()[0] == Approx(std::log(length) / 100).epsilon(1e-6));
  CHECK(first.exponents()[0] == Approx(lyapunov.exponents()[0]).epsilon(1e-12));
}

TEST_CASE("Lyapunov exponents say what they cannot do", "[lyapunov]") {
  CHECK(refuses([] { LyapunovExponents(henon_heiles, 5); }, "5 exponents asked for; there are 4"));
  CHECK(refuses([] { LyapunovExponents(henon_heiles, 0); }, "0 exponents"));
  LyapunovExponents lyapunov(henon_heiles, 1);
  CHECK(lyapunov.exponents()[0] == 0);
  lyapunov(0.0, HenonHeiles::point(0.1));
  CHECK(lyapunov.exponents()[0] == 0);
  std::string message;
  try {
    lyapunov(1e200, HenonHeiles::point(0.1));
  } catch (const std::runtime_error& error) {
    message = error.what();
  }
  CHECK(says(message, "no tangent map of the step to t = 1e+200"));
}

TEST_CASE("Lyapunov exponents say that a step was cut into parts", "[lyapunov]") {
  const systems::NlsLattice<double, 5> lattice;
  Semiexplicit stepper(lattice, schemes::low_defect6_s13());
  PhasePoint<double, 5> z(5);
  z.q() << 0.2, 3.2, 0.1, 0.3, 0.2;
  LyapunovExponents lyapunov(stepper, 1);
  const std::string why =
      complaint([&] { integrate(stepper, z, {.dt = 0.12, .steps = 60, .subdivide = 4}, lyapunov); });
  CHECK(says(why, "no tangent map of the step to t = "));
  CHECK(says(why, "the step was cut into parts (subdivide)"));
  CHECK(says(why, "take a smaller dt"));
}

TEST_CASE("Vectors to start with that are parallel but for rounding are refused", "[lyapunov]") {
  const systems::NlsLattice<double, 3> lattice;
  const Semiexplicit stepper(lattice);
  for (int i = 1; i <= 50; ++i) {
    CAPTURE(i);
    Eigen::Matrix<double, 6, 2> parallel;
    for (int k = 0; k < 6; ++k) parallel(k, 0) = std::sin(i + 7.0 * k);
    parallel.col(1) = parallel.col(0) * (1 + 0.1 * i) / 3;
    LyapunovExponents lyapunov(stepper, 2);
    CHECK(refuses([&] { lyapunov.start_with(parallel); }, "not independent"));
    parallel(0, 1) += 1e-6;
    CHECK_NOTHROW(LyapunovExponents(stepper, 2).start_with(parallel));
  }
}

TEST_CASE("Lyapunov exponents refuse a time that turns round", "[lyapunov]") {
  const auto h = from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; });
  Semiexplicit stepper(h, schemes::strang());
  LyapunovExponents lyapunov(stepper, 1);
  PhasePoint<double, 1> z(1, 0);
  integrate(stepper, z, {.dt = 0.1, .steps = 5}, lyapunov);
  CHECK(
      refuses([&] { integrate(stepper, z, {.dt = -0.1, .steps = 5, .t0 = 0.5}, lyapunov); }, "turned round"));
}

TEST_CASE("Lyapunov exponents of a run in two parts, in whatever time the second one counts", "[lyapunov]") {
  Semiexplicit stepper(WithHessian(), schemes::blanes_moan4<double>());
  const auto start = HenonHeiles::point(1.0 / 6);
  auto z = start;
  LyapunovExponents whole(stepper, 2);
  integrate(stepper, z, {.dt = 0.05, .steps = 2000}, whole);
  for (const double t0 : {50.0, 0.0}) {
    LyapunovExponents parts(stepper, 2);
    z = start;
    integrate(stepper, z, {.dt = 0.05, .steps = 1000}, parts);
    integrate(stepper, z, {.dt = 0.05, .steps = 1000, .t0 = t0}, parts);
    for (const int k : {0, 1}) CHECK(parts.exponents()[k] == Approx(whole.exponents()[k]).epsilon(1e-9));
  }
}

TEST_CASE("Lyapunov exponents want every step of one orbit", "[lyapunov]") {
  Semiexplicit stepper(WithHessian(), schemes::blanes_moan4<double>());
  auto z = HenonHeiles::point(0.1);
  LyapunovExponents some(stepper, 1), two(stepper, 1);
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.05, .steps = 30}, every(3, some)); },
                "only some of the steps"));
  integrate(stepper, z, {.dt = 0.05, .steps = 30}, two);
  z = HenonHeiles::point(0.12);
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.05, .steps = 30}, two); }, "another orbit begins"));
}

/// A saddle, with the second derivatives of another Hamiltonian.
struct Inherits : systems::Product<double> {
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = -3 * q[0];
    dHdp[0] = p[0];
  }
};

TEST_CASE("Second derivatives that a type inherits beside another gradient are refused", "[chaos]") {
  Semiexplicit stepper(Inherits{}, schemes::low_defect6_s13<double>());
  PhasePoint<double, 1> z(0.1, 0.2);
  LyapunovExponents lyapunov(stepper, 2);
  CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.1, .steps = 10}, lyapunov), std::invalid_argument);
}

/// Two oscillators, the first in a unit that is far smaller and with a wave on its spring.
struct UnlikeUnits {
  using Scalar = double;
  static constexpr int Dof = 2;
  double unit, wave_number, stiffness = 1.25;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    const double x = q[0] / unit;
    dHdq[0] = (x - 0.05 * std::sin(wave_number * x) / wave_number) / unit;
    dHdq[1] = stiffness * q[1];
    dHdp[0] = unit * unit * p[0];
    dHdp[1] = p[1];
  }
  void hessian_times(In<double, 2> q, In<double, 2>, In<double, 2> dq, In<double, 2> dp, Out<double, 2> hq,
                     Out<double, 2> hp) const {
    hq[0] = (1 - 0.05 * std::cos(wave_number * q[0] / unit)) / (unit * unit) * dq[0];
    hq[1] = stiffness * dq[1];
    hp[0] = unit * unit * dp[0];
    hp[1] = dp[1];
  }
};

TEST_CASE("Right second derivatives are taken whatever the units, and where the force has a narrow wave",
          "[chaos]") {
  const auto takes = [](UnlikeUnits h, double x) {
    CAPTURE(h.unit, h.wave_number, x);
    Semiexplicit stepper(h, schemes::strang());
    PhasePoint<double, 2> z({x * h.unit, 0.76}, {0.3 / h.unit, -0.5});
    LyapunovExponents lyapunov(stepper, 1);
    CHECK_NOTHROW(integrate(stepper, z, {.dt = 0.01, .steps = 1}, lyapunov));
  };
  for (const double unit : {1e-4, 1e-6, 1e-7, 1e-8})
    for (const double x : {0.1, 0.5, 0.9}) takes({unit, 1}, x);
  for (const double x : {100., 101.3, 107.7}) takes({1, 3e4}, x);

  struct Wrong : UnlikeUnits {
    double of_q, of_p;  // what is left of it
    void hessian_times(In<double, 2> q, In<double, 2> p, In<double, 2> dq, In<double, 2> dp,
                       Out<double, 2> hq, Out<double, 2> hp) const {
      UnlikeUnits::hessian_times(q, p, dq, dp, hq, hp);
      hq *= of_q;
      hp *= of_p;
    }
  };
  for (const double unit : {1e-6, 1.})
    for (const double speed : {1., 1e-9, 0.})
      for (const auto& [of_q, of_p] : {std::pair{1.2, 1.}, {0., 1.}, {1., 0.}, {0., 0.}}) {
        CAPTURE(unit, speed, of_q, of_p);
        Semiexplicit stepper(Wrong{{unit, 1}, of_q, of_p}, schemes::strang());
        PhasePoint<double, 2> z({0.5 * unit, 0.76}, {0.3 * speed / unit, -0.5 * speed});
        LyapunovExponents lyapunov(stepper, 1);
        CHECK_THROWS_AS(integrate(stepper, z, {.dt = 0.01, .steps = 1}, lyapunov), std::invalid_argument);
      }
}

TEST_CASE("Vectors to start with that are refused leave the observer as it was", "[lyapunov]") {
  const Semiexplicit stepper(HenonHeilesWithProduct{}, schemes::low_defect6_s13());
  LyapunovExponents lyapunov(stepper, 2);
  const auto before = lyapunov.vectors();
  auto parallel = before;
  parallel.col(1) = 2 * parallel.col(0);
  CHECK(refuses([&] { lyapunov.start_with(parallel); }, "are not independent"));
  CHECK(lyapunov.vectors() == before);
}

TEST_CASE("The work of a driven system has no part in its exponents", "[lyapunov]") {
  // Mathieu's equation is linear: by Floquet's theory its exponent is 0.24315 on every orbit, found here from
  // the two solutions over a period, and that of p_t, which grows as q δq, twice that.
  for (const double q0 : {0.0, 1e-8, 1.0}) {
    CAPTURE(q0);
    const Autonomous driven(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
      return p[0] * p[0] / 2 + (1 - cos(2 * t)) * q[0] * q[0] / 2;
    }));
    Semiexplicit stepper(driven, schemes::low_defect6_s13());
    LyapunovExponents first(stepper, 1), all(stepper);
    auto z = driven.extended({q0, 0}, 0.0);
    integrate(stepper, z, {.dt = 0.1, .steps = 500}, first, all);
    const double t = 50;
    CHECK(std::abs(first.exponents()[0] - floquet_of_mathieu()) < 2 / t);
    REQUIRE(all.exponents().size() == 3);
    CHECK(std::abs(all.exponents()[0] - floquet_of_mathieu()) < 2 / t);
    if (q0 != 0) continue;  // a shift of time is moved by as much as the orbit is
    CHECK(std::abs(all.exponents()[1]) < 2 / t);
    CHECK(std::abs(all.exponents()[2] + floquet_of_mathieu()) < 2 / t);
    CHECK(refuses([&] { LyapunovExponents(stepper, 4); }, "4 exponents asked for; there are 3"));
  }
}

TEST_CASE("The series of an exponent that there is not is refused", "[lyapunov]") {
  Semiexplicit stepper(systems::Product<double>(), schemes::low_defect6_s13());
  LyapunovExponents one(stepper, 1);
  PhasePoint<double, 1> z(-3, 0);
  integrate(stepper, z, {.dt = 0.05, .steps = 10}, one);
  CHECK(one.series(0).size() == one.times().size());
  for (const int j : {-1, 1, 10'000'000})
    CHECK(refuses([&] { one.series(j); }, "LyapunovExponents: series(" + std::to_string(j) + ") of 1"));
}

}  // namespace test_lyapunov
