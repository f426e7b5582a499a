#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/systems.hpp>

#include "../properties/methods.hpp"
#include "faulty.hpp"
#include "refusal.hpp"

namespace test_failures {

// What a step does that cannot be done: it says so, leaves the state alone to the last bit, and the stepper
// goes on as if nothing had been.

namespace {

using namespace semiexplicit;
using Fault = Faulty::Fault;

methods::Choice few_methods() {
  methods::Choice choice;
  choice.schemes = {"strang", "blanes_moan4"};
  choice.tao_schemes = {"strang", "triple_jump4"};
  choice.most_stages = 3;
  choice.stop = StoppingRule::product();
  return choice;
}

template <class Scalar, int Dof>
bool same_bits(const PhasePoint<Scalar, Dof>& x, const PhasePoint<Scalar, Dof>& y) {
  if (x.vector().size() != y.vector().size()) return false;
  const auto bytes = sizeof(Scalar) * static_cast<std::size_t>(x.vector().size());
  return bytes == 0 || std::memcmp(x.vector().data(), y.vector().data(), bytes) == 0;
}
template <class Scalar, int Dof>
bool same_bits(const ExtendedPoint<Scalar, Dof>& x, const ExtendedPoint<Scalar, Dof>& y) {
  return same_bits(x.a, y.a) && same_bits(x.b, y.b);
}

const double not_a_number = std::numeric_limits<double>::quiet_NaN();
const double infinite = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("A step that is zero, NaN or Inf is refused", "[failures]") {
  methods::for_each(Faulty{}, few_methods(), [](const methods::Claim& claim, auto stepper) {
    CAPTURE(claim.name);
    typename decltype(stepper)::State state(PhasePoint<double, 1>(-1, 0.5));
    const auto before = state;
    for (const double dt : {0.0, -0.0, not_a_number, infinite, -infinite}) {
      CAPTURE(dt);
      CHECK(stepper.step(state, dt).status == Status::invalid_step);
      CHECK(same_bits(state, before));
    }
    CHECK(stepper.step(state, 0.01).ok());
  });
}

TEST_CASE("A state of another size or not finite is refused", "[failures]") {
  methods::for_each(systems::NlsLattice<double>(3), few_methods(),
                    [](const methods::Claim& claim, auto stepper) {
                      CAPTURE(claim.name);
                      using State = typename decltype(stepper)::State;
                      for (const Eigen::Index size : {0, 2, 4}) {
                        State state{PhasePoint<double, Eigen::Dynamic>(size)};
                        const State before = state;
                        CHECK(stepper.step(state, 0.01).status == Status::invalid_state);
                        CHECK(same_bits(state, before));
                      }
                      for (const double bad : {not_a_number, infinite, -infinite})
                        for (Eigen::Index i = 0; i < 6; ++i) {
                          CAPTURE(bad, i);
                          PhasePoint<double, Eigen::Dynamic> z({1, 0.5, -0.3}, {0.4, -0.7, 0.2});
                          z.vector()[i] = bad;
                          State state(z);
                          const State before = state;
                          CHECK(stepper.step(state, 0.01).status == Status::invalid_state);
                          CHECK(same_bits(state, before));
                        }
                      State good(PhasePoint<double, Eigen::Dynamic>({1, 0.5, -0.3}, {0.4, -0.7, 0.2}));
                      CHECK(stepper.step(good, 0.01).ok());
                    });
}

TEST_CASE("A gradient that gives NaN or Inf, or throws, at any call does no harm", "[failures]") {
  const Faulty h;
  methods::for_each(h, few_methods(), [&](const methods::Claim& claim, const auto& fresh) {
    CAPTURE(claim.name);
    using State = typename std::decay_t<decltype(fresh)>::State;
    const double dt = 0.02;
    const bool starts_from_last_step =
        claim.name.starts_with("Gauss");  // whose iteration differs, not its result
    const bool takes_differences = (starts_from_last_step && claim.name.ends_with("Newton")) ||
                                   claim.name.find("Newton-Krylov") != std::string::npos;
    const auto agree = [&](const State& x, const State& y) {
      if (!starts_from_last_step) return same_bits(x, y);
      return (x.q() - y.q()).norm() <= 1e-14 && (x.p() - y.p()).norm() <= 1e-14;
    };

    // Three steps that go well, and the number of calls of the third.
    *h.plan = {};
    auto stepper = fresh;
    State state(PhasePoint<double, 1>(-1, 0.5));
    const State start = state;
    REQUIRE(stepper.step(state, dt).ok());
    const State first = state;
    REQUIRE(stepper.step(state, dt).ok());
    const State second = state;
    const auto prepared = stepper;
    const std::int64_t calls = stepper.step(state, dt).gradients;
    const State third = state;
    REQUIRE(calls >= 3);

    // A step of a copy of `from` with the planned fault; whether it failed, as it should.
    const auto step_with_fault = [&](const auto& from, const State& before, const State& after) {
      auto broken = from;
      State z = before;
      Status status = Status::not_finite;
      bool threw = false;
      try {
        status = broken.step(z, dt).status;
      } catch (const std::domain_error&) {
        threw = true;
      }
      // Of a derivative it may not matter in the end: another shift is taken, and Newton's iteration corrects
      // itself.
      if (takes_differences && status == Status::success) {
        REQUIRE(agree(z, after));
        return false;
      }
      REQUIRE(status == Status::not_finite);
      REQUIRE(threw == (h.plan->fault == Fault::raise));
      REQUIRE(same_bits(z, before));
      // Again, without the fault: as if it had not been.
      const Faulty::Plan plan = *h.plan;
      *h.plan = {};
      REQUIRE(broken.step(z, dt).ok());
      REQUIRE(agree(z, after));
      *h.plan = plan;
      return true;
    };
    for (const Fault fault : {Fault::nan_q, Fault::nan_p, Fault::infinite_q, Fault::infinite_p, Fault::raise})
      for (std::int64_t k = 0; k < calls; ++k) {
        CAPTURE(static_cast<int>(fault), k);
        *h.plan = {.at = k, .fault = fault};
        if (step_with_fault(prepared, second, third)) REQUIRE(h.plan->calls > k);
        // And the very first step of a stepper.
        *h.plan = {.at = std::min<std::int64_t>(k, 2), .fault = fault};
        step_with_fault(fresh, start, first);
      }
  });
}

TEST_CASE("A step that is too large fails, and the rate says so", "[failures]") {
  const systems::Product<double> h;
  PhasePoint<double, 1> z(-3, 0);
  const auto before = z;
  Semiexplicit stepper(h, schemes::strang());
  for (const double dt : {0.5, -0.5, 2.0, 100.0, 1e10, 1e300}) {
    CAPTURE(dt);
    const auto report = stepper.step(z, dt);
    CHECK((report.status == Status::no_convergence || report.status == Status::not_finite));
    CHECK_FALSE(report.ok());
    CHECK(same_bits(z, before));
  }
  // H = (q² + p²)/2, λ = 1: Strang bears h < 1.85 of it, and says at which rate it converges or does not.
  const auto oscillator = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq = q;
        dHdp = p;
      });
  Semiexplicit linear(oscillator, schemes::strang(),
                      SimplifiedNewton{.stop = StoppingRule::paper(1e-14), .max_iterations = 400});
  PhasePoint<double, 1> y(1, 0);
  const auto slow = linear.step(y, 1.5);
  CHECK(slow.ok());
  CHECK(slow.rate > 0.5);
  CHECK(slow.rate < 1);
  const auto there = y;
  const auto diverging = linear.step(y, 2.2);
  CHECK_FALSE(diverging.ok());
  CHECK(diverging.rate > 1);
  CHECK(same_bits(y, there));
  CHECK(linear.step(y, 0.1).ok());
}

TEST_CASE("Broyden's method bears steps that the simplified iteration does not", "[failures]") {
  const systems::Product<double> h;
  PhasePoint<double, 1> z(-3, 0);
  double dt = 0.01;
  Semiexplicit simple(h, schemes::strang());
  for (auto y = z; simple.step(y, dt).ok(); y = z) dt *= 1.05;
  CHECK(dt > 0.1);
  Semiexplicit robust(h, schemes::strang(), Broyden{});
  CHECK(robust.step(z, dt).ok());
}

TEST_CASE("Negative steps go back in time", "[failures]") {
  methods::for_each(Faulty{}, few_methods(), [](const methods::Claim& claim, auto stepper) {
    CAPTURE(claim.name);
    typename decltype(stepper)::State state(PhasePoint<double, 1>(-1, 0.5));
    const auto report = integrate(stepper, state, {.dt = -0.01, .steps = 20});
    CHECK(report.ok());
    CHECK(report.t == Approx(-0.2));
    // q' = p (q² + 1) > 0 at the start, so q was smaller before.
    CHECK(state.q()[0] < -1);
  });
}

TEST_CASE("An equilibrium stays where it is", "[failures]") {
  for (const auto& rule : {StoppingRule::product(), StoppingRule::paper(1e-13), StoppingRule::paper(0)}) {
    methods::Choice choice = few_methods();
    choice.stop = rule;
    methods::for_each(Faulty{}, choice, [](const methods::Claim& claim, auto stepper) {
      CAPTURE(claim.name);
      typename decltype(stepper)::State state(PhasePoint<double, 1>(0, 0));
      const auto report = stepper.step(state, 0.1);
      CHECK(report.ok());
      if (!claim.name.starts_with("Gauss")) CHECK(report.evaluations == 1);
      CHECK(state.q()[0] == 0);
      CHECK(state.p()[0] == 0);
    });
  }
  // Away from the origin, where the gradient is zero as well: H = (q - 2)²/2 + p²/2.
  const auto h = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                             [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                               dHdq[0] = q[0] - 2;
                                               dHdp = p;
                                             });
  PhasePoint<double, 1> z(2, 0);
  Semiexplicit stepper(h, schemes::low_defect4_s7(), Broyden{});
  CHECK(stepper.step(z, 0.1).evaluations == 1);
  CHECK(z.vector() == Eigen::Vector2d(2, 0));
}

TEST_CASE("A start at the origin that is no equilibrium leaves it", "[failures]") {
  // A state of size zero gives the stopping rule nothing to measure by. H = (q² + 1)(p² + 1)/2 + 3q - p.
  const auto h = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                             [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                               dHdq[0] = q[0] * (p[0] * p[0] + 1) + 3;
                                               dHdp[0] = p[0] * (q[0] * q[0] + 1) - 1;
                                             });
  const auto check = [&](auto stepper) {
    PhasePoint<double, 1> z(0, 0), reference(0, 0);
    CHECK(stepper.step(z, 0.01).ok());
    GaussLegendre gauss(h, {.stages = 4});
    CHECK(gauss.step(reference, 0.01).ok());
    CHECK((z.vector() - reference.vector()).norm() <= 1e-10);
  };
  check(Semiexplicit(h, schemes::blanes_moan4()));
  check(Semiexplicit(h, schemes::blanes_moan4(), Broyden{}));
  check(Semiexplicit(h, schemes::blanes_moan4(), SimplifiedNewton{.stop = StoppingRule::paper(1e-13)}));
}

TEST_CASE("States of any size are stepped to the same relative accuracy", "[failures]") {
  // A quadratic H that is not separable: the step is linear.
  const auto h = make_hamiltonian<double, 2>([](const auto&, const auto&) { return 0.0; },
                                             [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                               dHdq[0] = q[0] + 0.3 * p[1];
                                               dHdq[1] = 2 * q[1] - 0.2 * p[0];
                                               dHdp[0] = p[0] - 0.2 * q[1];
                                               dHdp[1] = p[1] + 0.3 * q[0];
                                             });
  const PhasePoint<double, 2> unit({1, -0.5}, {0.3, 0.8});
  methods::for_each(h, few_methods(), [&](const methods::Claim& claim, const auto& fresh) {
    using State = typename std::decay_t<decltype(fresh)>::State;
    State expected(unit);
    auto first = fresh;
    const auto usual = first.step(expected, 0.1);
    for (const int power : {-600, -500, 500, 600}) {  // 1e±150 and 1e±180; powers of two round alike
      const double size = std::ldexp(1.0, power);
      CAPTURE(claim.name, power);
      PhasePoint<double, 2> z = unit;
      z.vector() *= size;
      State state(z);
      auto stepper = fresh;
      const auto report = stepper.step(state, 0.1);
      REQUIRE(report.ok());
      CHECK((state.q() / size - expected.q()).norm() <= 1e-14);
      CHECK((state.p() / size - expected.p()).norm() <= 1e-14);
      if (!claim.name.starts_with("Gauss")) CHECK(report.evaluations == usual.evaluations);
      if (usual.correction > 1e-12) CHECK(report.correction / size == Approx(usual.correction).epsilon(1e-3));
    }
  });
}

TEST_CASE("An absolute tolerance under the rounding of a large state is met by what rounding allows",
          "[failures]") {
  // The rotation that made the published runs stall: states of size 60 and a bound of 1e-13.
  const systems::PointVortices<double, 4> h({10, -8, 12, 9});
  PhasePoint<double, 4> z = h.phase_point({10, -9, 3, 4}, {2, 12, -15, 9});
  REQUIRE(z.vector().norm() > 60);
  for (const double epsilon : {1e-13, 1e-15, 1e-17}) {
    CAPTURE(epsilon);
    Semiexplicit simple(h, schemes::strang(), SimplifiedNewton{.stop = StoppingRule::paper(epsilon)});
    Semiexplicit robust(h, schemes::strang(), Broyden{.stop = StoppingRule::paper(epsilon)});
    auto x = z, y = z;
    const auto first = integrate(simple, x, {.dt = 2, .steps = 2000});
    const auto second = integrate(robust, y, {.dt = 2, .steps = 2000});
    CHECK(first.status == Status::success);
    CHECK(second.status == Status::success);
    CHECK(first.max_correction <= 3e-12);
    CHECK(second.max_correction <= 3e-12);
  }
}

TEST_CASE("An edited scheme is refused by every stepper, with its name", "[failures]") {
  const systems::Product<double> h;
  const auto every_stepper_refuses = [&](const Scheme<double>& s) {
    CHECK(says(refusal([&] { Semiexplicit stepper(h, s); }), "\"" + s.name + "\""));
    CHECK(says(refusal([&] { Semiexplicit stepper(h, s, Broyden{}); }), "\"" + s.name + "\""));
    CHECK(says(refusal([&] { MidpointProjection stepper(h, s); }), "\"" + s.name + "\""));
    CHECK(says(refusal([&] { Pihajoki stepper(h, s); }), "\"" + s.name + "\""));
    CHECK(says(refusal([&] { Tao stepper(h, s, 1.0); }), "\"" + s.name + "\""));
  };
  Scheme<double> s = schemes::yoshida6();
  s.a[0] += 1e-3;
  every_stepper_refuses(s);
  s = schemes::yoshida6();
  s.b[3] = not_a_number;
  every_stepper_refuses(s);
  s = schemes::yoshida6();
  s.b.pop_back();
  every_stepper_refuses(s);
  s = schemes::yoshida6();
  s.order = 8;
  every_stepper_refuses(s);
  s = schemes::yoshida6();
  s.a.clear();
  s.b.clear();
  every_stepper_refuses(s);
  s = schemes::triple_jump(4);  // palindromic and of sum one still
  std::swap(s.b[0], s.b[1]);
  s.b[2] = s.b[0];
  every_stepper_refuses(s);
}

TEST_CASE("Tao's map takes compositions of Strang only, and a finite omega", "[failures]") {
  const systems::Product<double> h;
  for (const std::string& name : schemes::names()) {
    CAPTURE(name);
    bool composition = false;
    for (const char* family :
         {"strang", "triple_jump", "suzuki", "yoshida", "kahan_li", "sofroniou_spaletta"})
      composition = composition || name.starts_with(family);
    const std::string text = refusal([&] { Tao stepper(h, schemes::by_name(name), 1.0); });
    if (composition) {
      CHECK(text == accepted);
    } else {
      CHECK(says(text, name));
      CHECK(says(text, "not a composition of Strang"));
    }
  }
  for (const double omega : {not_a_number, infinite, -infinite})
    CHECK(says(refusal([&] { Tao stepper(h, schemes::strang(), omega); }), "omega is NaN or Inf"));
}

TEST_CASE("A stepper that is used for several states gives each what a fresh one gives", "[failures]") {
  methods::for_each(Faulty{}, few_methods(), [](const methods::Claim& claim, const auto& fresh) {
    CAPTURE(claim.name);
    using State = typename std::decay_t<decltype(fresh)>::State;
    auto used = fresh, first = fresh, second = fresh;
    State x(PhasePoint<double, 1>(-1, 0.5)), y(PhasePoint<double, 1>(0.2, 1.5));
    State u = x, v = y;
    // x goes a step, then y: nothing of x may be left.
    REQUIRE(used.step(x, 0.02).ok());
    REQUIRE(used.step(y, 0.02).ok());
    REQUIRE(first.step(u, 0.02).ok());
    REQUIRE(second.step(v, 0.02).ok());
    CHECK(same_bits(x, u));
    CHECK(same_bits(y, v));
    // A copy goes on like the original.
    auto copy = used;
    State w = y;
    REQUIRE(used.step(y, 0.02).ok());
    REQUIRE(copy.step(w, 0.02).ok());
    CHECK(same_bits(y, w));
  });
}

namespace {
/// The nonlinear oscillator beside a coordinate that only drifts, coupled to nothing.
template <class Scalar>
auto beside_a_drift() {
  return make_hamiltonian<Scalar, 2>(
      [](const auto& q, const auto& p) { return p[0] + (q[1] * q[1] + 1) * (p[1] * p[1] + 1) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 0;
        dHdp[0] = 1;
        dHdq[1] = q[1] * (p[1] * p[1] + 1);
        dHdp[1] = p[1] * (q[1] * q[1] + 1);
      });
}
template <class Scalar, class Solver>
void goes_as_alone(Solver solver, Scalar far, bool converges) {
  for (const Scalar q0 : {Scalar(0), far / 10, far}) {
    CAPTURE(q0);
    Semiexplicit stepper(beside_a_drift<Scalar>(), schemes::low_defect6_s13<Scalar>(), solver);
    PhasePoint<Scalar, 2> z({q0, Scalar(-3)}, {Scalar(0), Scalar(0)});
    const bool ok = stepper.step(z, Scalar(0.7)).ok();
    CHECK(ok == converges);
    // By Newton's method in more digits.
    if (ok) CHECK(std::hypot(z.q()[1] + 0.352667664, z.p()[1] - 2.81061867) <= 1e-8);
  }
}
}  // namespace

TEST_CASE("NaN or Inf in a coordinate that H does not depend on is the state's", "[failures]") {
  methods::for_each(beside_a_drift<double>(), few_methods(), [](const methods::Claim& claim, auto stepper) {
    CAPTURE(claim.name);
    for (const double bad : {not_a_number, infinite}) {
      typename decltype(stepper)::State state{PhasePoint<double, 2>({bad, 1}, {0.5, 0})};
      CHECK(stepper.step(state, 0.1).status == Status::invalid_state);
    }
  });
}

TEST_CASE("A large coordinate that is coupled to nothing hides no iteration that diverges", "[failures]") {
  goes_as_alone<double>(SimplifiedNewton{}, 1e12, false);
  goes_as_alone<double>(Broyden{}, 1e12, true);
  goes_as_alone<float>(SimplifiedNewton{}, 1e5F, false);
}

TEST_CASE("An iteration that converges slowly beside a large coordinate goes on to its end", "[failures]") {
  // p₁²/2 + 2.6 (p₂² + q₂²)/2 + 5e6 q₂⁴, at a rate of 0.93 and more for simplified Newton.
  const auto h = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) {
        const double square = q[1] * q[1];
        return (p[0] * p[0] + 2.6 * (p[1] * p[1] + square)) / 2 + 5e6 * square * square;
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 0;
        dHdq[1] = 2.6 * q[1] + 2e7 * q[1] * q[1] * q[1];
        dHdp[0] = p[0];
        dHdp[1] = 2.6 * p[1];
      });
  const auto energy_of_oscillator = [&](double far) {
    Semiexplicit stepper(h, schemes::low_defect6_s13<double>(), Robust{});
    PhasePoint<double, 2> z({far, 1e-4}, {1e-3, 0});
    const double before = h.energy(z.q(), z.p());
    double worst = 0;
    integrate(stepper, z, {.dt = 1, .steps = 500}, [&](double, const auto& at) {
      worst = std::max(worst, std::abs(h.energy(at.q(), at.p()) - before));
    });
    return worst;
  };
  const double alone = energy_of_oscillator(0);
  for (const double far : {1e6, 1e7, 1e9}) {
    CAPTURE(far);
    CHECK(energy_of_oscillator(far) <= 2 * alone);
  }
}

TEST_CASE("A large coordinate whose rounding the forces feel is no failure", "[failures]") {
  // A pendulum that has turned a million times: the rounding of its angle, 1e-9, is in its momentum, too.
  const auto H = from_energy<1>([](const auto& q, const auto& p) {
    using std::cos;
    return p[0] * p[0] / 2 - cos(q[0]);
  });
  const double turn = 2 * std::acos(-1.0);
  for (const double turns : {0.0, 1e3, 1e6}) {
    CAPTURE(turns);
    Semiexplicit stepper(H, schemes::blanes_moan4(), SimplifiedNewton{.stop = StoppingRule::product(0)});
    PhasePoint<double, 1> z(1 + turns * turn, 0.5);
    const auto report = integrate(stepper, z, {.dt = 0.1, .steps = 200});
    CHECK(report.evaluations <= 30 * report.steps);
  }
}

}  // namespace test_failures
