#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

#include "refusal.hpp"

namespace test_dense_output {

namespace {

using namespace semiexplicit;

/// H = (q² + p²)²/4, a rotation at the rate 2H/r² = r²/2... with r = 1 at the rate 1: not separable, and
/// known in closed form.
const auto rotor = make_hamiltonian<double, 1>(
    [](const auto& q, const auto& p) { return std::pow(q[0] * q[0] + p[0] * p[0], 2) / 4; },
    [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
      const double rr = q[0] * q[0] + p[0] * p[0];
      dHdq[0] = rr * q[0];
      dHdp[0] = rr * p[0];
    });
PhasePoint<double, 1> exact(double t) { return {std::cos(t), -std::sin(t)}; }

/// Largest error in the middle of the steps, of which each is h, from exact states.
double interpolation_error(int nodes, double h) {
  DenseOutput dense(rotor, nodes);
  PhasePoint<double, 1> z;
  double worst = 0;
  for (int n = 0; n < 40; ++n) {
    dense(n * h, exact(n * h));
    if (!dense.ready()) continue;
    dense.at((n - 0.5) * h, z);
    worst = std::max(worst, (z.vector() - exact((n - 0.5) * h).vector()).norm());
  }
  return worst;
}

}  // namespace

TEST_CASE("Dense output has the order of its nodes", "[dense output]") {
  for (const int nodes : {2, 3, 4, 5}) {
    CAPTURE(nodes);
    const double order = std::log2(interpolation_error(nodes, 0.4) / interpolation_error(nodes, 0.2));
    CHECK(order == Approx(2 * nodes).margin(0.3));
  }
  CHECK(interpolation_error(4, 0.05) < 1e-14);
  CHECK(refuses([] { DenseOutput dense(rotor, 1); }, "1 nodes"));
  CHECK(refuses([] { DenseOutput dense(rotor, 9); }, "9 nodes"));
}

TEST_CASE("Dense output goes back from its last state where a run turns round", "[dense output]") {
  DenseOutput dense(rotor, 3);
  for (int n = 0; n < 5; ++n) dense(n * 0.1, exact(n * 0.1));
  CHECK(dense.ready());
  dense(0.4, exact(0.4));  // the start of the next run: the same state
  CHECK(dense.size() == 3);
  CHECK(dense.end() == 0.4);
  dense(0.3, exact(0.3));
  dense(0.2, exact(0.2));
  CHECK(dense.size() == 3);
  CHECK(dense.begin() == 0.4);
  CHECK(dense.end() == 0.2);
}

TEST_CASE("Times that are no times are refused", "[dense output]") {
  const auto nothing = [](double, const PhasePoint<double, 1>&) {};
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  CHECK(refuses([&] { at_times(rotor, {0, nan, 1}, nothing); }, "time 1 is NaN or Inf"));
  CHECK(refuses([&] { at_times(rotor, {nan}, nothing); }, "time 0 is NaN or Inf"));
  CHECK(refuses([&] { at_times(rotor, {0, inf}, nothing); }, "time 1 is NaN or Inf"));
}

TEST_CASE("Output at times between the steps", "[dense output]") {
  const std::vector<double> times{0, 0.013, 0.05, 0.777, 1.2, 1.99, 2.0};
  for (const double direction : {1.0, -1.0}) {
    std::vector<double> wanted;
    for (const double t : times) wanted.push_back(direction * t);
    Semiexplicit stepper(rotor, schemes::low_defect8_s20());
    auto z = exact(0);
    std::size_t calls = 0;
    auto output = at_times(rotor, wanted, [&](double t, const auto& at) {
      CHECK(t == wanted[calls]);
      CHECK((at.vector() - exact(t).vector()).norm() < 1e-13);
      ++calls;
    });
    integrate(stepper, z, {.dt = direction * 0.05, .steps = 40}, output);
    CHECK(calls == times.size());
    CHECK(output.served() == times.size());
  }
  // A run of two steps has fewer states than nodes.
  Semiexplicit stepper(rotor, schemes::low_defect8_s20());
  auto z = exact(0);
  int calls = 0;
  auto output = at_times(rotor, {0.03}, [&](double, const auto&) { ++calls; });
  integrate(stepper, z, {.dt = 0.02, .steps = 2}, output);
  CHECK(calls == 0);
  output.finish();
  output.finish();
  CHECK(calls == 1);
  const auto nothing = [](double, const auto&) {};
  CHECK(refuses([&] { at_times(rotor, {0, 1, 0.5}, nothing); }, "sort them"));
  CHECK(refuses([&] { at_times(rotor, {0, 1, 1, 2}, nothing); }, "time 2 is there twice"));
  CHECK(refuses([&] { at_times(rotor, {1, 1}, nothing); }, "time 1 is there twice"));
  auto early = at_times(rotor, {-1, 0.5}, nothing);
  CHECK(refuses([&] { integrate(stepper, z, {.dt = 0.02, .steps = 9}, early); }, "before the start"));
}

TEST_CASE("A bracketed root is found to rounding", "[dense output]") {
  int calls = 0;
  const auto check = [&](auto f, double a, double b, double root) {
    calls = 0;
    const auto counted = [&](double x) {
      ++calls;
      return f(x);
    };
    CHECK(std::abs(detail::bracketed_root(counted, a, f(a), b, f(b)) - root) <= 4e-16 * std::abs(root));
    CHECK(calls <= 60);
    CHECK(std::abs(detail::bracketed_root(counted, b, f(b), a, f(a)) - root) <= 4e-16 * std::abs(root));
  };
  check([](double x) { return x * x - 2; }, 0, 2, std::sqrt(2.0));
  check([](double x) { return std::exp(x) - 3; }, -20, 5, std::log(3.0));
  check([](double x) { return x - 0.1; }, 0, 1, 0.1);
  check([](double x) { return std::tanh(50 * (x - 0.3)); }, 0, 1, 0.3);
  check([](double x) { return std::cos(x); }, 1, 2, std::acos(0.0));
}

TEST_CASE("Dense output of large values is as exact as they are", "[dense_output]") {
  // A clock q = t beside an oscillation: late it has few digits, of which the interpolation must lose none.
  const auto clock = make_hamiltonian<double, 2>([](const auto&, const auto& p) { return p[0]; },
                                                 [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                                   dHdq[0] = 0;
                                                   dHdp[0] = 1;
                                                   dHdq[1] = q[1];
                                                   dHdp[1] = p[1];
                                                 });
  for (const int nodes : {2, 4, 8})
    for (const double late : {1e9, 1e12, -1e15}) {
      CAPTURE(nodes, late);
      DenseOutput dense(clock, nodes);
      PhasePoint<double, 2> z;
      double worst = 0;
      for (int n = 0; n < 20; ++n) {
        const double t = 0.5 * n;
        dense(t, PhasePoint<double, 2>({late + t, std::cos(t)}, {late, -std::sin(t)}));
        if (!dense.ready()) continue;
        for (std::size_t i = 0; i + 1 < dense.size(); ++i)
          for (const double x : {0.1, 0.25, 0.4}) {
            dense.after(i, x, z);
            worst = std::max(worst, std::abs(z.q()[0] - (late + dense.time(i) + x)));
            CHECK(z.p()[0] == late);
          }
      }
      CHECK(worst <= 2.3e-16 * std::abs(late));
    }
}

TEST_CASE("What dense output does not hold is refused by the range that it holds", "[dense output]") {
  for (const double direction : {1.0, -1.0}) {
    DenseOutput dense(rotor, 3);
    PhasePoint<double, 1> z;
    const auto refuses = [&](const auto& action, const std::string& text) {
      return says(complaint<std::out_of_range>(action), text);
    };
    const std::string none = "DenseOutput: it holds no state yet";
    CHECK(refuses([&] { dense.at(0, z); }, none));
    CHECK(refuses([&] { dense.begin(); }, none));
    CHECK(refuses([&] { dense.end(); }, none));
    CHECK(refuses([&] { dense.state(0); }, none));
    dense(0, exact(0));
    dense.at(0, z);
    CHECK(z.vector() == exact(0).vector());
    CHECK(refuses([&] { dense.at(0.1, z); }, "from 0 to 0"));
    for (int n = 1; n <= 4; ++n) dense(direction * 0.1 * n, exact(direction * 0.1 * n));
    const auto range = direction > 0 ? "lies outside what it holds, from 0.2 to 0.4"
                                     : "lies outside what it holds, from -0.2 to -0.4";
    for (const double t : {0.19, 0.41, -1.0, std::numeric_limits<double>::infinity(), std::nan("")}) {
      CAPTURE(t);
      CHECK(refuses([&] { dense.at(direction * t, z); }, range));
    }
    for (const double t : {0.2 - 1e-15, 0.2, 0.3, 0.4, 0.4 + 1e-15, 0.401}) {
      CAPTURE(t);
      dense.at(direction * t, z);
      CHECK((z.vector() - exact(direction * t).vector()).norm() < 1e-6);
    }
    CHECK(refuses([&] { dense.state(3); }, "there is no state 3; they count from 0 to 2"));
    CHECK(refuses([&] { dense.time(9); }, "there is no state 9; they count from 0 to 2"));
    CHECK(refuses([&] { dense.interval(2); }, "there is no state 3; they count from 0 to 2"));
  }
}

}  // namespace test_dense_output
