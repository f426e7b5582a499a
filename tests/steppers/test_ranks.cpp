// One trajectory over several ranks, which are threads here: each has a block of a chain, and the steps are
// those of the whole chain.
#include "catch.hpp"

#include <algorithm>
#include <barrier>
#include <cmath>
#include <cstddef>
#include <limits>
#include <thread>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "folder.hpp"
#include "refusal.hpp"

namespace test_ranks {

namespace {

using namespace semiexplicit;
constexpr int dynamic = Eigen::Dynamic;
using Point = PhasePoint<double, dynamic>;
using Column = Vector<double, dynamic>;
constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// What the ranks share. One that has ended is waited for no longer, so that a test fails instead of hanging.
class Team {
 public:
  explicit Team(std::size_t ranks)
      : barrier_(static_cast<std::ptrdiff_t>(ranks)), told_(ranks), ends_(ranks) {}

  double sum(std::size_t rank, double x) {
    told_[rank] = x;
    barrier_.arrive_and_wait();
    double all = 0;
    for (const double one : told_) all += one;
    barrier_.arrive_and_wait();
    return all;
  }
  struct Neighbours {
    double left, right;
    bool has_left, has_right;
  };
  Neighbours exchange(std::size_t rank, double first, double last) {
    ends_[rank] = {first, last};
    barrier_.arrive_and_wait();
    const bool has_left = rank > 0, has_right = rank + 1 < ends_.size();
    const Neighbours found{has_left ? ends_[rank - 1].last : 0, has_right ? ends_[rank + 1].first : 0,
                           has_left, has_right};
    barrier_.arrive_and_wait();
    return found;
  }
  void leave() { barrier_.arrive_and_drop(); }
  std::size_t ranks() const { return told_.size(); }

 private:
  struct Ends {
    double first, last;
  };
  std::barrier<> barrier_;
  std::vector<double> told_;
  std::vector<Ends> ends_;
};

/// Σ (q² + 1)(p² + 1)/2 + k Σ (qᵢ - qᵢ₊₁)²/2, the whole.
struct Chain {
  using Scalar = double;
  static constexpr int Dof = dynamic;
  Eigen::Index n;
  double k = 1;
  Eigen::Index dof() const { return n; }
  void gradient(In<double, dynamic> q, In<double, dynamic> p, Out<double, dynamic> dHdq,
                Out<double, dynamic> dHdp) const {
    for (Eigen::Index i = 0; i < n; ++i) {
      dHdq[i] = q[i] * (p[i] * p[i] + 1);
      if (i > 0) dHdq[i] += k * (q[i] - q[i - 1]);
      if (i + 1 < n) dHdq[i] += k * (q[i] - q[i + 1]);
      dHdp[i] = p[i] * (q[i] * q[i] + 1);
    }
  }
};

/// The same, of which this is one rank's block.
struct Block {
  using Scalar = double;
  static constexpr int Dof = dynamic;
  Eigen::Index n;
  Team* team;
  std::size_t rank;
  double k = 1;
  double spoilt = 0;  ///< is added to one entry of the gradient
  Eigen::Index dof() const { return n; }
  double sum_over_ranks(const double& x) const { return team->sum(rank, x); }
  void gradient(In<double, dynamic> q, In<double, dynamic> p, Out<double, dynamic> dHdq,
                Out<double, dynamic> dHdp) const {
    const auto beside = team->exchange(rank, q[0], q[n - 1]);
    for (Eigen::Index i = 0; i < n; ++i) {
      dHdq[i] = q[i] * (p[i] * p[i] + 1);
      if (i > 0 || beside.has_left) dHdq[i] += k * (q[i] - (i > 0 ? q[i - 1] : beside.left));
      if (i + 1 < n || beside.has_right) dHdq[i] += k * (q[i] - (i + 1 < n ? q[i + 1] : beside.right));
      dHdp[i] = p[i] * (q[i] * q[i] + 1);
    }
    dHdq[0] += spoilt;
  }
};

/// Σ (qᵢ² + pᵢ²)/2 - Σ fᵢqᵢ, separable, f being large on one rank.
struct Pulled {
  using Scalar = double;
  static constexpr int Dof = dynamic;
  static constexpr bool separable = true;
  using SeparableGradientOf = Pulled;
  Eigen::Index n;
  Team* team;
  std::size_t rank;
  double force;
  Eigen::Index dof() const { return n; }
  double sum_over_ranks(const double& x) const { return team->sum(rank, x); }
  void position_gradient(In<double, dynamic> q, Out<double, dynamic> dVdq) const { dVdq = q.array() - force; }
  void momentum_gradient(In<double, dynamic> p, Out<double, dynamic> dTdp) const { dTdp = p; }
  void gradient(In<double, dynamic> q, In<double, dynamic> p, Out<double, dynamic> dHdq,
                Out<double, dynamic> dHdp) const {
    position_gradient(q, dHdq);
    momentum_gradient(p, dHdp);
  }
};

static_assert(SumsOverRanks<Block> && !SumsOverRanks<Chain>);

const std::vector<Eigen::Index> blocks{9, 2, 20};
constexpr Eigen::Index all_sites = 31;

/// The sites begin to begin + n - 1 of an initial state, whose first `at_rest` sites are zero.
Point state(Eigen::Index begin, Eigen::Index n, Eigen::Index at_rest = 0) {
  Point z(n);
  z.vector().setZero();
  for (Eigen::Index i = std::max<Eigen::Index>(at_rest - begin, 0); i < n; ++i) {
    z.q()[i] = 0.5 * std::sin(1 + 0.7 * static_cast<double>(begin + i));
    z.p()[i] = 0.4 * std::cos(0.3 * static_cast<double>(begin + i));
  }
  return z;
}

/// work(team, rank, first site) by a thread each.
template <class Work>
void on_ranks(const Work& work) {
  Team team(blocks.size());
  std::vector<std::thread> threads;
  Eigen::Index begin = 0;
  for (std::size_t rank = 0; rank < blocks.size(); ++rank) {
    threads.emplace_back([&work, &team, rank, begin] {
      work(team, rank, begin);
      team.leave();
    });
    begin += blocks[rank];
  }
  for (std::thread& thread : threads) thread.join();
}

template <class State>
Point point(const State& z) {
  Point result(z.q().size());
  result.q() = z.q();
  result.p() = z.p();
  return result;
}

/// A run of the whole, and one in blocks, by the stepper that make(H) gives.
template <class Make>
void compare(const Make& make, double k, double dt, Eigen::Index at_rest = 0) {
  constexpr int steps = 6;
  auto whole = make(Chain{all_sites, k});
  typename decltype(whole)::State z(state(0, all_sites, at_rest));
  const IntegrationReport expected = integrate(whole, z, {.dt = dt, .steps = steps});
  REQUIRE(expected.ok());

  std::vector<IntegrationReport> reports(blocks.size());
  Point together(all_sites);
  on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
    auto stepper = make(Block{blocks[rank], &team, rank, k});
    typename decltype(stepper)::State own(state(begin, blocks[rank], at_rest));
    reports[rank] = integrate(stepper, own, {.dt = dt, .steps = steps});
    together.q().segment(begin, blocks[rank]) = own.q();
    together.p().segment(begin, blocks[rank]) = own.p();
  });
  for (const IntegrationReport& report : reports) {
    CHECK(report.ok());
    CHECK(report.evaluations == expected.evaluations);
    CHECK(report.gradients == expected.gradients);
    CHECK(report.max_correction == reports.front().max_correction);  // the very same number on each
    CHECK(report.max_correction == Approx(expected.max_correction).epsilon(1e-3).margin(1e-14));
  }
  const double size = point(z).vector().norm();
  CHECK((together.vector() - point(z).vector()).norm() <= 1e-12 * size);
}

/// A solver as users write them.
struct OwnSolver {
  static constexpr bool over_ranks = true;
  template <class Vec>
  struct Workspace {
    Workspace(const OwnSolver&, Eigen::Index size) : f(size) {}
    Vec f;
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    SolverReport<typename Vec::Scalar> report;
    m.setZero();
    residual(work.f);
    for (report.evaluations = 1; report.evaluations < 50; ++report.evaluations) {
      report.correction = norm_over_ranks(residual, work.f) / 4;
      report.status =
          report.correction <= 1e-13 * residual.state_size() ? Status::success : Status::no_convergence;
      if (report.status == Status::success) break;
      m -= work.f / 4;
      residual(m, work.f);
    }
    return report;
  }
};

}  // namespace

TEST_CASE("A chain in blocks takes the evaluations of the whole chain, and goes where that goes") {
  const auto scheme = schemes::low_defect4_s7<double>();
  SECTION("with simplified Newton") {
    compare([&](auto H) { return Semiexplicit(H, scheme); }, 1, 0.1);
  }
  SECTION("where a block is at rest, whose own residual is zero") {
    const SimplifiedNewton solver{.stop = StoppingRule::paper(1e-13)};
    compare([&](auto H) { return Semiexplicit(H, scheme, solver); }, 0, 0.1, blocks[0]);
  }
  SECTION("with plain summation and the paper's rule") {
    const SimplifiedNewton solver{.stop = StoppingRule::paper(1e-13)};
    compare([&](auto H) { return Semiexplicit(H, scheme, solver, Summation::plain); }, 1, 0.1);
  }
  SECTION("with Broyden's method") {
    compare([&](auto H) { return Semiexplicit(H, scheme, Broyden{}); }, 4, 0.3);
  }
  SECTION("with Newton and GMRES, in blocks that have fewer sites than GMRES directions") {
    const NewtonKrylov solver{.stop = StoppingRule::product(1e-20)};
    compare([&](auto H) { return Semiexplicit(H, scheme, solver); }, 4, 0.3);
    compare([&](auto H) { return Semiexplicit(H, scheme, NewtonKrylov{}); }, 30, 0.2);
  }
  SECTION("with all of them") {
    const Robust solver{.newton_iterations = 1, .broyden_iterations = 2};
    compare([&](auto H) { return Semiexplicit(H, scheme, solver); }, 4, 0.3);
  }
  SECTION("with a solver of one's own") {
    compare([&](auto H) { return Semiexplicit(H, scheme, OwnSolver{}); }, 1, 0.1);
  }
  SECTION("with the midpoint projection") {
    compare([&](auto H) { return MidpointProjection(H, scheme); }, 1, 0.05);
  }
  SECTION("with the explicit methods") {
    const auto bare = schemes::blanes_moan4<double>();
    compare([&](auto H) { return Pihajoki(H, bare); }, 1, 0.02);
    compare([&](auto H) { return Tao(H, schemes::triple_jump<double>(4), 10.0); }, 1, 0.02);
  }
}

TEST_CASE("A site that was moved by hand on one rank is a new state on all") {
  const auto run = [](auto h, Eigen::Index begin) {
    Tao stepper(h, schemes::strang<double>(), 10.0);
    ExtendedPoint<double, dynamic> z(state(begin, h.n));
    integrate(stepper, z, {.dt = 0.02, .steps = 5});
    if (begin == 0) z.a.p()[0] += 0.1, z.b.p()[0] += 0.1;
    integrate(stepper, z, {.dt = 0.02, .steps = 5, .t0 = 0.1});
    return Column(z.q());
  };
  const Column whole = run(Chain{all_sites}, 0);
  Column together(all_sites);
  on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
    together.segment(begin, blocks[rank]) = run(Block{blocks[rank], &team, rank}, begin);
  });
  CHECK((together - whole).norm() <= 1e-12 * whole.norm());
}

TEST_CASE("Checkpoints over ranks are taken by steps") {
  Team team(1);
  const Folder folder;
  const auto file = folder.path / "rank.checkpoint";
  Semiexplicit stepper(Block{4, &team, 0}, schemes::strang<double>());
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 10};
  CHECK(refuses([&] { Checkpoints(file, {.seconds = 60}, stepper, options); }, "give .every"));
  Checkpoints(file, {.every = 10}, stepper, options);
}

TEST_CASE("What fails on one rank fails on all, with one status and every state as it was") {
  const auto scheme = schemes::low_defect4_s7<double>();
  std::vector<StepReport> reports(blocks.size());
  std::vector<int> untouched(blocks.size());
  Status expected = Status::success;
  SECTION("a gradient that is NaN") {
    expected = Status::not_finite;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      Semiexplicit stepper(Block{blocks[rank], &team, rank, 1, rank == 1 ? nan : 0}, scheme);
      Point z = state(begin, blocks[rank]);
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = z.vector() == state(begin, blocks[rank]).vector();
    });
  }
  SECTION("the same in a projection without iteration, and with plain summation") {
    expected = Status::not_finite;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      MidpointProjection stepper(Block{blocks[rank], &team, rank, 1, rank == 2 ? infinite : 0}, scheme,
                                 Summation::plain);
      Point z = state(begin, blocks[rank]);
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = z.vector() == state(begin, blocks[rank]).vector();
    });
  }
  SECTION("a state that is NaN") {
    expected = Status::invalid_state;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      Semiexplicit stepper(Block{blocks[rank], &team, rank}, scheme);
      Point z = state(begin, blocks[rank]);
      if (rank == 2) z.p()[1] = nan;
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = rank == 2 || z.vector() == state(begin, blocks[rank]).vector();
    });
  }
  SECTION("a state of another size") {
    expected = Status::invalid_state;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      Semiexplicit stepper(Block{blocks[rank], &team, rank}, scheme);
      Point z = state(begin, blocks[rank] + (rank == 0 ? 1 : 0));
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = z.vector() == state(begin, z.dof()).vector();
    });
  }
  SECTION("an iteration that one rank's stiffness keeps from converging") {
    expected = Status::no_convergence;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      Semiexplicit stepper(Block{blocks[rank], &team, rank, 1}, scheme,
                           SimplifiedNewton{.stop = StoppingRule::paper(0), .max_iterations = 3});
      Point z = state(begin, blocks[rank]);
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = z.vector() == state(begin, blocks[rank]).vector();
    });
    for (const StepReport& report : reports) CHECK(report.evaluations == 3);
  }
  SECTION("a copy of the doubled system") {
    expected = Status::not_finite;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      Pihajoki stepper(Block{blocks[rank], &team, rank, 1, rank == 0 ? nan : 0},
                       schemes::blanes_moan4<double>());
      ExtendedPoint<double, dynamic> z(state(begin, blocks[rank]));
      reports[rank] = stepper.step(z, 0.1);
      untouched[rank] = z.a.vector() == state(begin, blocks[rank]).vector();
    });
  }
  SECTION("a sum that overflows at the end of a separable step") {
    expected = Status::not_finite;
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index begin) {
      ExplicitSplitting stepper(Pulled{blocks[rank], &team, rank, rank == 1 ? 1e308 : 0},
                                schemes::blanes_moan4<double>());
      Point z = state(begin, blocks[rank]);
      if (rank == 1) z.p().setConstant(1.7e308);
      const Point before = z;
      reports[rank] = stepper.step(z, 1.0);
      untouched[rank] = z.vector() == before.vector();
    });
  }
  for (std::size_t rank = 0; rank < blocks.size(); ++rank) {
    INFO("rank " << rank);
    CHECK(reports[rank].status == expected);
    CHECK(reports[rank].evaluations == reports[0].evaluations);
    CHECK(untouched[rank] == 1);
  }
}

TEST_CASE("Norms over ranks are those of the whole column, at any size") {
  for (const double scale : {1.0, 1e-200, 1e200, 0.0, 5e-324}) {
    INFO("scale " << scale);
    std::vector<double> found(blocks.size());
    on_ranks([&](Team& team, std::size_t rank, Eigen::Index) {
      const Column v = Column::Constant(blocks[rank], scale * 3);
      found[rank] = norm_over_ranks(Block{blocks[rank], &team, rank}, v);
    });
    for (const double norm : found)
      CHECK(std::abs(norm - 3 * scale * std::sqrt(31.0)) <= 1e-15 * norm + (scale < 1e-300 ? 2e-323 : 0));
  }
  CHECK(norm_over_ranks(Chain{2}, Column::Constant(4, 0.5)) == 1.0);
}

}  // namespace test_ranks
