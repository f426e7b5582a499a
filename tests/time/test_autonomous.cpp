#include "catch.hpp"

#include <array>
#include <cmath>

#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "refusal.hpp"

namespace test_autonomous {

// Hamiltonians that depend on the time: closed forms, an integrator of another library, invariants.

namespace {

using namespace semiexplicit;

/// An oscillator under a periodic force: H = (p² + ω²q²)/2 - F q cos(Ωt).
struct ForcedOscillator {
  using Scalar = double;
  static constexpr int Dof = 1;
  double frequency = 1.3, force = 0.7, driving = 2.1;

  double energy(double t, In<double, 1> q, In<double, 1> p) const {
    return (p[0] * p[0] + frequency * frequency * q[0] * q[0]) / 2 - force * q[0] * std::cos(driving * t);
  }
  void gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = frequency * frequency * q[0] - force * std::cos(driving * t);
    dHdp[0] = p[0];
  }
  double time_derivative(double t, In<double, 1> q, In<double, 1>) const {
    return force * driving * q[0] * std::sin(driving * t);
  }
};
static_assert(TimeDependentHamiltonian<ForcedOscillator> && !Hamiltonian<ForcedOscillator>);
static_assert(Hamiltonian<Autonomous<ForcedOscillator>> && HasEnergy<Autonomous<ForcedOscillator>>);
static_assert(!TimeDependentHamiltonian<systems::Product<double>>);

/// The same without ∂H/∂t.
struct Undifferentiated {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    ForcedOscillator().gradient(t, q, p, dHdq, dHdp);
  }
};
static_assert(Hamiltonian<Autonomous<Undifferentiated>> && !HasEnergy<Autonomous<Undifferentiated>>);

/// The same with a gradient that returns ∂H/∂t.
struct Returning {
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(double t, In<double, 1> q, In<double, 1> p) const {
    return ForcedOscillator().energy(t, q, p);
  }
  double gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                  Out<double, 1> dHdp) const {
    ForcedOscillator().gradient(t, q, p, dHdq, dHdp);
    return ForcedOscillator().time_derivative(t, q, p);
  }
};
static_assert(Hamiltonian<Autonomous<Returning>> && HasEnergy<Autonomous<Returning>>);
/// The same with what gradient() is called with by its type, none of it temporary.
struct OfMaps {
  using Scalar = double;
  static constexpr int Dof = 1;
  using Map = Eigen::Map<const Vector<double, 1>>;
  double energy(double t, const Map& q, const Map& p) const { return ForcedOscillator().energy(t, q, p); }
  double gradient(double t, auto& q, auto& p, auto& dHdq, Eigen::Map<Vector<double, 1>>& dHdp) const {
    ForcedOscillator().gradient(t, q, p, dHdq, dHdp);
    return time_derivative_of(t, q, p);
  }
  static double time_derivative_of(double t, const Map& q, const Map& p) {
    return ForcedOscillator().time_derivative(t, q, p);
  }
};
static_assert(Hamiltonian<Autonomous<OfMaps>> && HasEnergy<Autonomous<OfMaps>>);
/// The same as a reference to what it keeps.
struct Keeping : Returning {
  mutable double by_time = 0;
  const double& gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                         Out<double, 1> dHdp) const {
    return by_time = Returning::gradient(t, q, p, dHdq, dHdp);
  }
};
static_assert(Autonomous<Keeping>::gradient_follows_work);
/// With one that returns something else.
struct Talking : ForcedOscillator {
  const char* gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                       Out<double, 1> dHdp) const {
    ForcedOscillator::gradient(t, q, p, dHdq, dHdp);
    return "done";
  }
};
static_assert(!Autonomous<Talking>::gradient_follows_work && Autonomous<Talking>::follows_work);

/// Nonlinear and not separable, driven: H = (q² + 1)(p² + 1)/2 + q p sin(2t)/2.
const Autonomous driven_product(from_energy<1>([](const auto& t, const auto& q, const auto& p) {
  using std::sin;
  return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2 + q[0] * p[0] * sin(2 * t) / 2;
}));

/// Its motion by a Runge-Kutta method of order 8 in long double.
Eigen::Vector2d reference(double q0, double p0, double t0, double t1) {
  using Pair = std::array<long double, 2>;
  Pair z{q0, p0};
  const auto motion = [](const Pair& at, Pair& rate, long double t) {
    const auto [q, p] = at;
    rate = {p * (q * q + 1) + q * std::sin(2 * t) / 2, -q * (p * p + 1) - p * std::sin(2 * t) / 2};
  };
  boost::numeric::odeint::runge_kutta_fehlberg78<Pair, long double> stepper;
  const int steps = 2000;
  const long double dt = (static_cast<long double>(t1) - t0) / steps;
  for (int n = 0; n < steps; ++n) stepper.do_step(motion, z, t0 + n * dt, dt);
  return {static_cast<double>(z[0]), static_cast<double>(z[1])};
}

/// A central force and a mass that vary in time, and a coupling of q and p: keeps the angular momentum.
const Autonomous central(from_energy<2>([](const auto& t, const auto& q, const auto& p) {
  using std::cos;
  const auto mixed = q.dot(p);
  return (1 + 0.3 * cos(t)) * p.squaredNorm() / 2 + (1 + 0.2 * cos(3 * t)) * q.squaredNorm() / 2 +
         mixed * mixed / 4;
}));

double angular_momentum(const PhasePoint<double, 3>& Z) { return Z.q()[0] * Z.p()[1] - Z.q()[1] * Z.p()[0]; }

}  // namespace

TEST_CASE("A forced oscillator follows the closed form, and p_t the work", "[autonomous]") {
  const ForcedOscillator H;
  const Autonomous K(H);
  const double t0 = 0.4, t1 = t0 + 10, amplitude = 0.7 / (1.3 * 1.3 - 2.1 * 2.1);
  const auto q = [&](double t) { return amplitude * (std::cos(2.1 * t) - std::cos(1.3 * t)); };
  const auto p = [&](double t) { return amplitude * (-2.1 * std::sin(2.1 * t) + 1.3 * std::sin(1.3 * t)); };
  const PhasePoint<double, 1> begin(q(t0), p(t0)), end(q(t1), p(t1));

  auto Z = K.extended(begin, t0);
  CHECK(K.time(Z) == t0);
  CHECK(K.point(Z).vector() == begin.vector());
  Semiexplicit stepper(K, schemes::low_defect6_s13());
  Invariants invariants(K);
  integrate(stepper, Z, {.dt = 0.01, .steps = 1000, .t0 = t0}, invariants);
  CHECK((K.point(Z).vector() - end.vector()).norm() <= 1e-13);
  CHECK(K.time(Z) == Approx(t1).epsilon(1e-15));
  const double work = H.energy(t1, end.q(), end.p()) - H.energy(t0, begin.q(), begin.p());
  CHECK(std::abs(work) > 0.1);
  CHECK(Z.p()[1] == Approx(-work).epsilon(1e-12));
  CHECK(invariants["energy"].worst <= 1e-12);
}

TEST_CASE("A wrong dH/dt is found by the check of the gradient", "[autonomous]") {
  struct Wrong : ForcedOscillator {
    double time_derivative(double t, In<double, 1> q, In<double, 1> p) const {
      return -ForcedOscillator::time_derivative(t, q, p);
    }
  };
  const Autonomous wrong{Wrong()};
  const auto check = check_gradient(wrong, wrong.extended({0.3, 0.4}, 0.7));
  CHECK(check.entries[1].wrong);  // dH/dq[1], by the time
  CHECK_FALSE(check.entries[0].wrong);
}

TEST_CASE("Without dH/dt the motion is the same", "[autonomous]") {
  const Autonomous with{ForcedOscillator()};
  const Autonomous without{Undifferentiated()};
  auto Z = with.extended({1, 0}, 0.0), W = without.extended({1, 0}, 0.0);
  Semiexplicit one(with, schemes::blanes_moan4());
  Semiexplicit other(without, schemes::blanes_moan4());
  integrate(one, Z, {.dt = 0.1, .steps = 100});
  integrate(other, W, {.dt = 0.1, .steps = 100});
  CHECK((with.point(Z).vector() - without.point(W).vector()).norm() <= 1e-13);
  CHECK(W.p()[1] == 0);
  CHECK(std::abs(Z.p()[1]) > 0.1);
}

TEST_CASE("A gradient that returns dH/dt does what a time_derivative does", "[autonomous]") {
  const Autonomous with{ForcedOscillator()};
  const Autonomous returning{Returning()};
  const Autonomous talking{Talking()};
  auto Z = with.extended({1, 0}, 0.0), W = Z;
  Semiexplicit one(with, schemes::blanes_moan4());
  Semiexplicit other(returning, schemes::blanes_moan4());
  integrate(one, Z, {.dt = 0.1, .steps = 100});
  integrate(other, W, {.dt = 0.1, .steps = 100});
  CHECK(Z.vector() == W.vector());
  const Autonomous of_maps{OfMaps()};
  Semiexplicit third(of_maps, schemes::blanes_moan4());
  auto V = with.extended({1, 0}, 0.0);
  Invariants energy(of_maps);
  integrate(third, V, {.dt = 0.1, .steps = 100}, energy);
  CHECK(Z.vector() == V.vector());
  CHECK(energy["energy"].worst <= 1e-4);
  CHECK(check_gradient(returning, Z).ok());
  CHECK(check_gradient(talking, Z).ok());
}

TEST_CASE("Driven steps have the order of the scheme", "[autonomous]") {
  const double t0 = 0.3, time = 2;
  const Eigen::Vector2d exact = reference(-1.5, 0.2, t0, t0 + time);
  const auto error = [&](auto stepper, int steps) {
    auto Z = driven_product.extended({-1.5, 0.2}, t0);
    integrate(stepper, Z, {.dt = time / steps, .steps = steps});
    return (driven_product.point(Z).vector() - exact).norm();
  };
  const auto order = [&](const auto& stepper, int steps) {
    return std::log2(error(stepper, steps) / error(stepper, 2 * steps));
  };
  const SimplifiedNewton tight{.stop = StoppingRule::product(1e-22)};
  CHECK(order(Semiexplicit(driven_product, schemes::strang(), tight), 64) == Approx(2).margin(0.1));
  CHECK(order(Semiexplicit(driven_product, schemes::blanes_moan4(), tight), 32) == Approx(4).margin(0.2));
  CHECK(order(Semiexplicit(driven_product, schemes::blanes_moan6(), tight), 16) == Approx(6).margin(0.4));
  CHECK(error(Semiexplicit(driven_product, schemes::sofroniou_spaletta10()), 64) <= 1e-12);
}

TEST_CASE("K strays no further over a long run, and quadratic invariants stay", "[autonomous][long]") {
  Semiexplicit stepper(central, schemes::blanes_moan4());
  auto Z = central.extended({{1, 0}, {0.2, 0.9}}, 0.0);
  const double momentum = angular_momentum(Z);
  double worst_momentum = 0;
  Invariants early(central), late(central);
  const auto follow = [&](double, const auto& at) {
    worst_momentum = std::max(worst_momentum, std::abs(angular_momentum(at) - momentum));
  };
  integrate(stepper, Z, {.dt = 0.05, .steps = 1'000}, early, late);
  integrate(stepper, Z, {.dt = 0.05, .steps = 20'000, .t0 = 50}, late, follow);
  CHECK(early["energy"].worst > 1e-9);
  CHECK(late["energy"].worst <= 3 * early["energy"].worst);
  CHECK(worst_momentum <= 1e-12);
}

TEST_CASE("A late time does not loosen the projection", "[autonomous]") {
  // Judged by |(q, p, t, p_t)| a step at t = 1e8 would be accepted with any defect.
  Semiexplicit stepper(central, schemes::strang());
  auto Z = central.extended({{1, 0}, {0.2, 0.9}}, 1e8);
  const double momentum = angular_momentum(Z);
  integrate(stepper, Z, {.dt = 0.125, .steps = 4'000});  // which a time of 1e8 can resolve
  CHECK(std::abs(angular_momentum(Z) - momentum) <= 1e-11);
}

TEST_CASE("An iteration that diverges is refused at a late time as at time zero", "[autonomous]") {
  // The rounding of the time, 1e-4 at 1e12, hides neither the defect of the copies nor its convergence.
  for (const double stiffness : {2.0, 20.0}) {
    const Autonomous H(from_energy<1>([=](const auto& t, const auto& q, const auto& p) {
      using std::cos;
      return p[0] * p[0] / 2 + stiffness * q[0] * q[0] / 2 + 100 * q[0] * cos(t);
    }));
    for (const auto summation : {Summation::plain, Summation::compensated})
      for (const double t0 : {0.0, 1e11, 1e12}) {
        CAPTURE(stiffness, t0);
        Semiexplicit stepper(H, schemes::strang(), {}, summation);
        auto Z = H.extended({1, 0.5}, t0);
        const StepReport report = stepper.step(Z, 0.5);
        CHECK(report.ok() == (stiffness == 2));
        if (report.ok()) CHECK(report.correction <= 1e-11);  // of moves of about 100
      }
    // A step that does not divide the time's last digit.
    Semiexplicit stepper(H, schemes::blanes_moan4(), SimplifiedNewton{.stop = StoppingRule::product(1e-18)});
    auto Z = H.extended({1, 0.5}, 1e12);
    const StepReport report = stepper.step(Z, 0.1);
    CHECK(report.ok());
    CHECK(report.correction <= 1e-11);
  }
}

/// A driven oscillator of mass 1, its length and its time in units of which p_t, an energy, may be far larger
/// than positions and momenta.
struct DrivenInUnits {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length, rate;
  double energy(double t, In<double, 1> q, In<double, 1> p) const {
    return p[0] * p[0] / 2 + rate * rate * q[0] * q[0] / 2 - drive() * q[0] * std::cos(rate / 2 * t);
  }
  double gradient(double t, In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq,
                  Out<double, 1> dHdp) const {
    dHdq[0] = rate * rate * q[0] - drive() * std::cos(rate / 2 * t);
    dHdp[0] = p[0];
    return drive() * rate / 2 * q[0] * std::sin(rate / 2 * t);
  }
  double drive() const { return 0.3 * length * rate * rate; }
};

TEST_CASE("Driven steps take as many evaluations in units in which energies are large", "[autonomous]") {
  const auto evaluations = [](const auto& solver, double length, double rate) {
    const Autonomous H(DrivenInUnits{length, rate});
    Semiexplicit stepper(H, schemes::strang(), solver);
    auto Z = H.extended({0.7 * length, -0.4 * length * rate}, 0);
    const auto report = integrate(stepper, Z, {.dt = 0.2 / rate, .steps = 100});
    const double t = 20, forced = 0.4 * std::cos(t / 2);  // 0.3 / (1 - 1/4)
    CHECK(Z.q()[0] / length == Approx(0.3 * std::cos(t) - 0.4 * std::sin(t) + forced).margin(0.05));
    return report.evaluations;
  };
  const auto check = [&](const auto& solver) {
    const auto usual = evaluations(solver, 1, 1);
    for (const double length : {0x1p-20, 1.0, 0x1p20})
      for (const double rate : {0x1p-20, 0x1p20, 0x1p30}) {
        CAPTURE(length, rate);
        CHECK(static_cast<double>(evaluations(solver, length, rate)) < 1.3 * static_cast<double>(usual));
      }
  };
  check(SimplifiedNewton{});
  check(NewtonKrylov{});
  check(Robust{});
}

TEST_CASE("Driven systems may have a size known at run time", "[autonomous]") {
  const auto energy = [](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (q.squaredNorm() + 1) * (p.squaredNorm() + 1) / 2 + q[0] * cos(t);
  };
  const Autonomous fixed(from_energy<3>(energy));
  const Autonomous dynamic(from_energy(3, energy));
  CHECK(dof_of(dynamic) == 4);
  const auto Z = fixed.extended({{1, 0, 0.5}, {0, 0.3, 0.1}}, 0.7);
  const auto W = dynamic.extended({{1, 0, 0.5}, {0, 0.3, 0.1}}, 0.7);
  auto dZ = Z;
  auto dW = W;
  fixed.gradient(Z.q(), Z.p(), dZ.q(), dZ.p());
  dynamic.gradient(W.q(), W.p(), dW.q(), dW.p());
  CHECK((dZ.vector() - dW.vector()).norm() <= 1e-14);
  CHECK(dZ.q()[3] == Approx(-std::sin(0.7)));
  CHECK(dZ.p()[3] == 1);
  CHECK(dynamic.point(W).dof() == 3);
  CHECK(refuses([&] { dynamic.extended({{1, 2}, {3, 4}}, 0.0); }, "the state has 2 degrees of freedom"));
}

namespace {
struct Still {
  using Scalar = double;
  static constexpr int Dof = 2;
  void gradient(double, In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = Eigen::Vector2d(q[0], 10 * q[1]);
    dHdp = Eigen::Vector2d(p[0], 10 * p[1]);
  }
};
}  // namespace

TEST_CASE("Gauss solves its stages as well at late times", "[autonomous][long]") {
  // Two oscillators; the fast one is small, and a step is three radians of it: the iteration contracts
  // slowly.
  for (const double t0 : {0.0, 1e6, 1e9}) {
    const Autonomous k(Still{});
    GaussLegendre stepper(k, {.stages = 4});
    auto z = k.extended(PhasePoint<double, 2>({1, 1e-6}, {0, 0}), t0);
    integrate(stepper, z, {.dt = 0.3, .steps = 2000, .t0 = t0});
    const auto w = k.point(z);
    CHECK((w.q()[1] * w.q()[1] + w.p()[1] * w.p()[1]) == Approx(1e-12).epsilon(1e-7));
  }
}

}  // namespace test_autonomous
