#include "catch.hpp"

#include <cmath>
#include <functional>
#include <limits>
#include <vector>

#include <Eigen/LU>

#include <semiexplicit/solvers/broyden.hpp>

namespace test_broyden {

// Broyden's method keeps its matrix as a few vectors; its iterates must be those of the matrix.

namespace {

using namespace semiexplicit;
using Vec = Eigen::VectorXd;
using Function = std::function<Vec(const Vec&)>;

/// A function as the solvers see a residual; it notes where it was evaluated.
struct Residual {
  Function f;
  Eigen::Index n;
  double size = 1, rounding = 0;
  std::vector<Vec> visited{};
  Vec last_f{};

  void operator()(Vec& value) { (*this)(Vec::Zero(n), value); }
  void operator()(const Vec& m, Vec& value) {
    visited.push_back(m);
    value = last_f = f(m);
  }
  double state_size() const { return size; }
  double farthest() const { return size; }
  double rounding_level() const { return rounding; }
  bool within_rounding(double multiple) const {
    const double epsilon = std::numeric_limits<double>::epsilon();
    return last_f.stableNorm() / 4 <= (multiple < 1 ? multiple * epsilon * size : multiple / 100 * rounding);
  }
};

struct Iterates {
  SolverReport<double> report;
  std::vector<Vec> visited;
  Vec m;
};

Iterates limited_memory(const Function& f, Eigen::Index n, const Broyden& solver) {
  Residual residual{f, n};
  Broyden::Workspace<Vec> work(solver, n);
  Vec m = Vec::Constant(n, 7);  // whatever was left there
  const auto report = solver.solve(residual, m, work);
  if (report.evaluations > 1) CHECK(m == residual.visited.back());
  return {report, residual.visited, residual.visited.back()};
}

/// The first `count` iterates with the inverse Jacobian as a matrix, by the update of Sherman and Morrison;
/// it starts anew from 4I after every `memory` updates.
std::vector<Vec> with_matrix(const Function& f, Eigen::Index n, std::size_t count, int memory) {
  const Eigen::MatrixXd first = Eigen::MatrixXd::Identity(n, n) / 4;
  Eigen::MatrixXd inverse = first;
  std::vector<Vec> visited{Vec::Zero(n)};
  Vec value = f(visited.back());
  int updates = 0;
  while (visited.size() < count) {
    const Vec step = -inverse * value;
    visited.push_back(visited.back() + step);
    const Vec next = f(visited.back());
    const Vec inverse_df = inverse * (next - value);
    inverse += ((step - inverse_df) / step.dot(inverse_df) * (step.transpose() * inverse)).eval();
    if (++updates > memory) {
      inverse = first;
      updates = 0;
    }
    value = next;
  }
  return visited;
}

/// f(m) = 4m + εg(m) + c with a nonlinear g that couples the entries.
Function coupled(double strength) {
  return [strength](const Vec& m) {
    Vec f(m.size());
    for (Eigen::Index i = 0; i < m.size(); ++i) {
      const double next = m[(i + 1) % m.size()];
      f[i] = 4 * m[i] + strength * (std::sin(3 * next) + m[i] * next + 0.5 * std::cos(m[i])) +
             0.1 * (1 + 0.3 * static_cast<double>(i));
    }
    return f;
  };
}

/// A linear function, which Broyden's method solves within 2n steps.
Function linear(const Eigen::MatrixXd& a) {
  return [a](const Vec& m) { return Vec(a * m - Vec::LinSpaced(m.size(), 1, 2)); };
}

}  // namespace

TEST_CASE("The iterates are those of the dense matrix", "[broyden]") {
  struct Case {
    Function f;
    Eigen::Index n;
  };
  Eigen::MatrixXd skew(4, 4);
  skew << 3, 1, 0, -1, -1, 5, 2, 0, 0, -2, 4, 1, 1, 0, -1, 3;
  for (const Case& c : {Case{coupled(0.1), 2}, Case{coupled(0.5), 6}, Case{coupled(1.0), 10},
                        Case{coupled(-0.8), 3}, Case{linear(skew), 4}}) {
    const auto found = limited_memory(c.f, c.n, {.stop = StoppingRule::paper(1e-12)});
    REQUIRE(found.report.status == Status::success);
    CHECK(found.report.evaluations == static_cast<int>(found.visited.size()));
    CHECK(found.report.evaluations >= 4);
    CHECK(c.f(found.m).norm() <= 1e-10);
    const auto expected = with_matrix(c.f, c.n, found.visited.size(), 1000);
    for (std::size_t k = 0; k < expected.size(); ++k) {
      CAPTURE(k);
      CHECK((found.visited[k] - expected[k]).norm() <= 1e-10 * (1 + expected[k].norm()));
    }
  }
}

TEST_CASE("Where the Jacobian is far from 4I Broyden converges and the simplified iteration would not",
          "[broyden]") {
  Eigen::MatrixXd large = Eigen::MatrixXd::Identity(3, 3) * 4;
  large(0, 0) = 12;  // m ← m - f/4 would multiply the error by -2
  large(1, 2) = -3;
  const auto found = limited_memory(linear(large), 3, {.stop = StoppingRule::paper(1e-12)});
  CHECK(found.report.status == Status::success);
  CHECK((large * found.m - Vec::LinSpaced(3, 1, 2)).norm() <= 1e-10);
  CHECK(found.report.evaluations <= 2 * 3 + 2);
}

TEST_CASE("A full memory starts anew from the current point", "[broyden]") {
  const Function f = coupled(1.0);
  for (const int memory : {1, 2, 3, 5}) {
    CAPTURE(memory);
    const auto found = limited_memory(f, 10, {.stop = StoppingRule::paper(1e-11), .memory = memory});
    REQUIRE(found.report.status == Status::success);
    CHECK(found.report.evaluations > memory + 2);  // so it did start anew
    CHECK(f(found.m).norm() <= 1e-9);
    const auto expected = with_matrix(f, 10, found.visited.size(), memory);
    for (std::size_t k = 0; k < expected.size(); ++k) {
      CAPTURE(k);
      CHECK((found.visited[k] - expected[k]).norm() <= 1e-8);
    }
  }
}

TEST_CASE("A singular update is left out", "[broyden]") {
  // In the first step m goes from 0 to -f(0)/4, where f has the same value again: Δf = 0, and no secant
  // exists.
  const Function flat_then_linear = [](const Vec& m) {
    Vec f(1);
    f[0] = m[0] > -0.3 ? 1 : 4 * m[0] + 2;
    return f;
  };
  const auto found = limited_memory(flat_then_linear, 1, {.stop = StoppingRule::paper(1e-12)});
  CHECK(found.report.status == Status::success);
  CHECK(found.m[0] == Approx(-0.5));
  CHECK(found.visited[1][0] == -0.25);
  CHECK(found.visited[2][0] == -0.5);  // a plain step of -f/4
}

TEST_CASE("NaN and Inf end the iteration, and are never a solution", "[broyden]") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    for (int from = 1; from <= 5; ++from) {
      CAPTURE(bad, from);
      int calls = 0;
      const Function good = coupled(1.0);
      const Function f = [&](const Vec& m) {
        Vec value = good(m);
        if (++calls >= from) value[2] = bad;
        return value;
      };
      for (const auto& rule : {StoppingRule::paper(1e-12), StoppingRule::product(1e-24)}) {
        calls = 0;
        const auto found = limited_memory(f, 6, {.stop = rule});
        CHECK(found.report.status == Status::not_finite);
        CHECK(found.report.evaluations == from);
      }
    }
  }
}

}  // namespace test_broyden
