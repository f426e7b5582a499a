#include "catch.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>

#include <semiexplicit/semiexplicit.hpp>

#include "refusal.hpp"
#include "two_bodies.hpp"

namespace test_solvers {

// The solvers by themselves, on small systems f(m) = 0 whose solutions are known.

namespace {

using namespace semiexplicit;
using Vec = Eigen::Vector2d;

struct Residual {
  std::function<Vec(const Vec&)> f;
  double size = 1, rounding = 0;
  Vec last = Vec::Constant(std::nan("")), last_f = last;

  void operator()(Vec& value) { (*this)(Vec::Zero(), value); }
  void operator()(const Vec& m, Vec& value) {
    last = m;
    last_f = f(m);
    value = last_f;
  }
  double state_size() const { return size; }
  double farthest() const { return size; }
  double rounding_level() const { return rounding; }
  bool within_rounding(double multiple) const {
    const double epsilon = std::numeric_limits<double>::epsilon();
    return last_f.stableNorm() / 4 <= (multiple < 1 ? multiple * epsilon * size : multiple / 100 * rounding);
  }
};

template <class Solver>
SolverReport<double> solve(const Solver& solver, Residual& residual) {
  typename Solver::template Workspace<Vec> work(solver, 2);
  Vec m = Vec::Constant(1e300);  // must not matter
  return solver.solve(residual, m, work);
}

/// f(m) = 4m - c + s (m₁², m₀): near 4I, with a rate of about s/4.
std::function<Vec(const Vec&)> mild(double strength) {
  return [strength](const Vec& m) { return Vec(4 * m - Vec(0.4, -0.2) + strength * Vec(m[1] * m[1], m[0])); };
}

/// Two pendulums that are coupled by positions and momenta.
struct Pendulums {
  using Scalar = double;
  static constexpr int Dof = 2;
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = std::sin(q[0]) - std::sin(q[1] - q[0]);
    dHdq[1] = std::sin(q[1] - q[0]) + 2 * p[0] * p[0] * q[1] / 3;
    dHdp[0] = p[0] + 2 * p[0] * q[1] * q[1] / 3;
    dHdp[1] = p[1];
  }
};

bool accepted(const SolverReport<double>& report) {
  return report.status == Status::success || report.status == Status::rounding_limited;
}

/// Puts a test on all solvers.
template <class Test>
void with_each(const Test& test) {
  test(SimplifiedNewton{});
  test(Broyden{});
  test(NewtonKrylov{});
}

}  // namespace

TEST_CASE("The solvers find a root and report how", "[solver]") {
  with_each([](auto solver) {
    for (const double strength : {0.1, -0.5, 1.5}) {
      CAPTURE(strength);
      solver.stop = StoppingRule::paper(1e-12);
      Residual residual{mild(strength)};
      const auto report = solve(solver, residual);
      CHECK(report.status == Status::success);
      CHECK(residual.last_f.norm() <= 1e-11);
      CHECK(report.correction < 1e-12);
      CHECK(report.evaluations >= 3);
      CHECK(report.rate > 0);
      CHECK(report.rate < 0.5);
    }
  });
}

TEST_CASE("The simplified Newton iteration contracts at the rate it reports", "[solver]") {
  // f(m) = 2m - c: m ← m - f/4 halves the error.
  Residual residual{[](const Vec& m) { return Vec(2 * m - Vec(1, 0)); }};
  const auto report = solve(SimplifiedNewton{.stop = StoppingRule::paper(1e-6)}, residual);
  CHECK(report.status == Status::success);
  CHECK(report.rate == Approx(0.5));
  CHECK(report.evaluations == 19);  // 2⁻²·2⁻ⁿ < 1e-6 for n = 18
  CHECK(report.correction == Approx(std::ldexp(1.0, -20)));
  CHECK((residual.last - Vec(0.5, 0)).norm() <= 1e-5);
}

TEST_CASE("An accepted first evaluation counts one, and has no rate", "[solver]") {
  with_each([](auto solver) {
    for (const double value : {0.0, 1e-9}) {
      Residual residual{[value](const Vec&) { return Vec(value, 0); }};
      const auto report = solve(solver, residual);
      CHECK(report.status == Status::success);
      CHECK(report.evaluations == 1);
      CHECK(report.correction == value / 4);
      CHECK(report.rate == 0);
      CHECK(residual.last == Vec::Zero());
    }
  });
}

TEST_CASE("A diverging iteration ends after max_iterations, with a rate above one", "[solver]") {
  Residual residual{[](const Vec& m) { return Vec(14 * m - Vec(1, 1)); }};
  const auto report = solve(SimplifiedNewton{.max_iterations = 20}, residual);
  CHECK(report.status == Status::no_convergence);
  CHECK(report.evaluations == 20);
  CHECK(report.rate == Approx(2.5));
  CHECK(report.correction > 1e6);

  // f has no root here.
  Residual rootless{[](const Vec& m) { return Vec(4 * m[0] * m[0] + 1, m[1] - 1); }};
  CHECK(solve(Broyden{.max_iterations = 33}, rootless).status == Status::no_convergence);
  CHECK(solve(Broyden{.max_iterations = 33}, rootless).evaluations == 33);
}

TEST_CASE("max_iterations is exact: the last evaluation may still be accepted", "[solver]") {
  with_each([](auto solver) {
    solver.stop = StoppingRule::paper(1e-12);
    Residual residual{mild(0.5)};
    const auto needed = static_cast<int>(solve(solver, residual).evaluations);
    solver.max_iterations = needed;
    CHECK(solve(solver, residual).status == Status::success);
    solver.max_iterations = needed - 1;
    const auto report = solve(solver, residual);
    CHECK(report.status == Status::no_convergence);
    CHECK(report.evaluations == needed - 1);
    solver.max_iterations = 1;
    CHECK(solve(solver, residual).status == Status::no_convergence);
    CHECK(solve(solver, residual).evaluations == 1);
  });
}

TEST_CASE("No step takes more evaluations than max_iterations", "[solver]") {
  for (int most = 1; most < 60; ++most)
    for (double dt = 0.5; dt < 8; dt += 0.5) {
      CAPTURE(most, dt);
      const auto evaluations = [&](auto solver) {
        PhasePoint<double, 2> z({1.0, 0.3}, {0.5, -0.2});
        return Semiexplicit(Pendulums(), schemes::low_defect6_s13<double>(), solver).step(z, dt).evaluations;
      };
      CHECK(evaluations(SimplifiedNewton{.max_iterations = most}) <= most);
      CHECK(evaluations(Broyden{.max_iterations = most}) <= most);
      CHECK(evaluations(NewtonKrylov{.max_iterations = most}) <= most);
      CHECK(evaluations(Robust{
                .newton_iterations = most, .broyden_iterations = most, .max_iterations = most}) <= 3 * most);
    }
}

TEST_CASE("Options that make no sense are refused before a step is taken", "[solver]") {
  with_each([](auto solver) {
    Residual residual{mild(0.5)};
    const auto refused = [&](auto options, const std::string& why) {
      const std::string said = refusal([&] { solve(options, residual); });
      return says(said, solver.name) && says(said, why);
    };
    for (const int none : {0, -5}) {
      auto options = solver;
      options.max_iterations = none;
      CHECK(refused(options, "max_iterations is below 1"));
    }
    for (const double tolerance : {-1e-16, std::nan(""), std::numeric_limits<double>::infinity()})
      for (const auto rule : {StoppingRule::product(tolerance), StoppingRule::paper(tolerance)}) {
        auto options = solver;
        options.stop = rule;
        CHECK(refused(options, "the tolerance of the stopping rule is negative, NaN or Inf"));
      }
    auto options = solver;
    options.stop = StoppingRule::product(1);
    CHECK(refused(options, "the tolerance of the product rule, relative to the state, is 1 or more"));
  });
  Residual residual{mild(0.5)};
  CHECK(refuses([&] { solve(Broyden{.memory = 0}, residual); }, "Broyden: memory is below 1"));
  CHECK(refuses([&] { solve(NewtonKrylov{.directions = 0}, residual); },
                "NewtonKrylov: directions is below 1"));
}

TEST_CASE("Corrections that no longer shrink are accepted at the level of rounding, and only there",
          "[solver]") {
  with_each([](auto solver) {
    solver.stop = StoppingRule::paper(1e-15);
    // Noise of 1e-9 on top of a solvable system.
    int calls = 0;
    const auto noisy = [&calls](const Vec& m) {
      const double disorder = std::fmod(++calls * 0.6180339887498949, 1.0) - 0.5;
      return Vec(4 * m - Vec(1, 2) + 1e-9 * Vec(disorder, std::fmod(7 * disorder, 1.0)));
    };
    Residual accepted{noisy, 1, 1e-8};
    const auto report = solve(solver, accepted);
    CHECK(report.status == Status::rounding_limited);
    CHECK(report.correction <= 1e-8);
    CHECK(report.rate >= 1);
    calls = 0;
    Residual refused{noisy, 1, 0};
    CHECK(solve(solver, refused).status == Status::no_convergence);
  });
}

TEST_CASE("A tolerance below all rounding is met by what rounding allows", "[solver]") {
  with_each([](auto solver) {
    for (const auto& rule : {StoppingRule::paper(0), StoppingRule::paper(1e-300), StoppingRule::product(0),
                             StoppingRule::product(1e-300)}) {
      solver.stop = rule;
      // Once m is below the rounding of the state only 2m is left of f, and the correction would halve for
      // ever.
      Residual halving{[](const Vec& m) { return Vec(2 * m + Vec(1e-14, 0)); }, 1, 1e-14};
      CHECK(accepted(solve(solver, halving)));
      Residual exact{[](const Vec&) { return Vec(0, 0); }, 1, 1e-14};
      CHECK(accepted(solve(solver, exact)));
      CHECK(solve(solver, exact).evaluations == 1);
    }
  });
}

TEST_CASE("NaN and Inf are failures, wherever they stand", "[solver]") {
  with_each([](auto solver) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
          -std::numeric_limits<double>::infinity()})
      for (const int where : {0, 1})
        for (int from = 1; from <= 3; ++from) {
          CAPTURE(bad, where, from);
          for (const auto& rule : {StoppingRule::paper(1e-15), StoppingRule::product(1e-28)}) {
            solver.stop = rule;
            int calls = 0;
            Residual residual{[&](const Vec& m) {
              Vec f = mild(0.5)(m);
              if (++calls >= from) f[where] = bad;
              return f;
            }};
            const auto report = solve(solver, residual);
            CHECK(report.status == Status::not_finite);
            CHECK(report.evaluations >= from);
            // Newton-Krylov tries shorter steps before it believes that.
            if (!std::is_same_v<decltype(solver), NewtonKrylov>) CHECK(report.evaluations == from);
          }
        }
  });
}

TEST_CASE("Systems of tiny and of huge size are solved to the same relative accuracy", "[solver]") {
  with_each([](auto solver) {
    for (const double size : {1e-200, 1e-150, 1e150, 1e200}) {
      CAPTURE(size);
      Residual residual{[size](const Vec& m) { return Vec(size * mild(0.5)(m / size)); }, size};
      const auto report = solve(solver, residual);
      CHECK(report.status == Status::success);
      CHECK(residual.last_f.stableNorm() <= 1e-11 * size);
    }
  });
}

TEST_CASE("A state of size zero needs an exact root", "[solver]") {
  with_each([](auto solver) {
    Residual residual{[](const Vec& m) { return Vec(4 * m - Vec(1, 2)); }, 0};
    const auto report = solve(solver, residual);
    CHECK(report.status == Status::success);
    CHECK(report.correction == 0);
  });
}

namespace {

/// H = (Q² + 1)(P² + 1)/2 with q = sQ, p = P/s: at rest the state is q alone, and p moves by 1/s² of it.
struct Scaled {
  using Scalar = double;
  static constexpr int Dof = 1;
  double s;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double x = q[0] / s, y = p[0] * s;
    dHdq[0] = x * (y * y + 1) / s;
    dHdp[0] = y * (x * x + 1) * s;
  }
};

}  // namespace

TEST_CASE("A step from rest is taken whatever the units", "[solver]") {
  for (const double s : {1e-6, 1e-4, 1e-2, 1.0, 1e2, 1e4})
    for (const double dt : {0.05, 0.1, 0.15, 0.2, 0.3})
      for (const auto& scheme :
           {schemes::blanes_moan4(), schemes::blanes_moan6(), schemes::low_defect4_s7()}) {
        CAPTURE(s, dt, scheme.name);
        PhasePoint<double, 1> z(-1.5 * s, 0), one(-1.5, 0);
        Semiexplicit stepper(Scaled{s}, scheme), in_ones(Scaled{1}, scheme);
        CHECK(stepper.step(z, dt).ok() == in_ones.step(one, dt).ok());
      }
}

TEST_CASE("Steps of two bodies far from the origin end by the rounding of their places", "[solvers]") {
  for (const double far : {1e7, 1e9}) {
    auto z = two_bodies_at(far);
    Semiexplicit stepper(two_bodies(), schemes::strang<double>());
    CHECK_NOTHROW(integrate(stepper, z, {.dt = 0.05, .steps = 1500}));
  }
}

}  // namespace test_solvers
