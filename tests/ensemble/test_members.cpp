// Ensembles whose members are stepped one by one, and what lanes and these have in common: against the plain
// stepper.
#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/systems.hpp>

#include "plain.hpp"
#include "refusal.hpp"

namespace test_members {

namespace {

using namespace plain;
using Lattice5 = systems::NlsLattice<double, 5>;
const auto scheme = schemes::low_defect6_s13<double>();

std::vector<PhasePoint<double, 5>> lattices(int count) {
  std::vector<PhasePoint<double, 5>> starts;
  for (int i = 0; i < count; ++i) {
    starts.push_back(lattice_state<5>(5, i % 8));
    starts.back().q()[0] += 0.01 * i;
  }
  return starts;
}

/// A user's solver: so many evaluations, whatever comes.
struct FixedWork {
  int evaluations = 3;
  template <class Vec>
  struct Workspace {
    Workspace(const FixedWork&, Eigen::Index size) : f(Vec::Zero(size)) {}
    Vec f;
  };
  template <class Residual, class Vec>
  SolverReport<double> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    m.setZero();
    residual(work.f);
    for (int i = 1; i < evaluations; ++i) {
      m -= work.f / 4;
      residual(m, work.f);
    }
    return {.status = Status::success, .evaluations = evaluations, .correction = detail::norm(work.f) / 4};
  }
};

bool same(double x, double y) { return x == y || (std::isnan(x) && std::isnan(y)); }

/// Every member of a run of 60 steps against the plain stepper, by 1 and 3 threads.
template <class H, class Plain, int Dof, class Solver>
void compare(const H& hamiltonian, const Plain& plain, const std::vector<PhasePoint<double, Dof>>& starts,
             double dt, const Solver& solver, int subdivide = 0, std::int64_t* subdivided = nullptr) {
  for (const int threads : {1, 3}) {
    Ensemble ensemble(hamiltonian, starts, scheme, solver);
    ensemble.run({.dt = dt, .steps = 60, .threads = threads, .t0 = 2, .subdivide = subdivide});
    for (Eigen::Index i = 0; i < ensemble.size(); ++i) {
      CAPTURE(threads, i);
      Semiexplicit stepper(plain, scheme, solver);
      auto z = starts[std::size_t(i)];
      const IntegrationReport alone =
          integrate(stepper, z,
                    {.dt = dt, .steps = 60, .on_failure = OnFailure::stop, .subdivide = subdivide, .t0 = 2});
      const IntegrationReport& report = ensemble.report(i);
      CHECK(same_bits(ensemble.state(i), z));
      CHECK((report.status == alone.status && report.steps == alone.steps && report.t == alone.t));
      CHECK((report.evaluations == alone.evaluations && report.gradients == alone.gradients));
      CHECK((report.max_correction == alone.max_correction && report.subdivided == alone.subdivided));
      CHECK((same(report.last.correction, alone.last.correction) && same(report.last.rate, alone.last.rate) &&
             report.last.evaluations == alone.last.evaluations));
      CHECK(report.dt == dt);
      if (subdivided) *subdivided += report.subdivided;
    }
  }
}

/// 5, 10 and 40 sites by terms, in one sum; reverse mode from 9 on.
auto lattice_energy(Eigen::Index n) {
  return from_energy(n, [n](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) {
      const auto density = q[i] * q[i] + p[i] * p[i];
      return density * density / 2 - (q[(i + 1) % n] * q[i] + p[(i + 1) % n] * p[i]);
    });
  });
}

/// H = (q² + p²)/2, whose gradient throws where q is above 0.55; it takes no packs.
struct Fragile {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    if (q[0] > 0.55) throw std::domain_error("q is above the limit");
    dHdq = q;
    dHdp = p;
  }
};

}  // namespace

TEST_CASE("Every solver takes the steps in an ensemble that it takes alone") {
  const Lattice5 packed;
  const auto starts = lattices(13);
  compare(packed, packed, starts, 0.03, Broyden{.stop = StoppingRule::paper(1e-13)});
  compare(packed, packed, starts, 0.03, NewtonKrylov{.stop = StoppingRule::paper(1e-12)});
  compare(packed, packed, starts, 0.15, Robust{});  // above what simplified Newton can do for some
  compare(packed, packed, starts, 0.03, FixedWork{});
  compare(Lattice<5>{}, Lattice<5>{}, starts, 0.03, SimplifiedNewton{});
}

TEST_CASE("An ensemble says how its members are stepped") {
  const auto starts = lattices(2);
  const Ensemble lanes(Lattice5(), starts, scheme);
  const Ensemble broyden(Lattice5(), starts, scheme, Broyden{});
  const Ensemble own(Lattice5(), starts, scheme, FixedWork{});
  const Ensemble plain(Lattice<5>{}, starts, scheme);
  CHECK((lanes.in_lanes() && !broyden.in_lanes() && !own.in_lanes() && !plain.in_lanes()));
  CHECK(says(lanes.how(), "in the lanes"));
  CHECK(broyden.how() == "one member at a time: only SimplifiedNewton goes in lanes, not Broyden");
  CHECK(own.how() == "one member at a time: only SimplifiedNewton goes in lanes");
  CHECK(says(plain.how(), "takes no packs"));
}

TEST_CASE("A Hamiltonian from its energy has an ensemble by any number of threads", "[long]") {
  for (const Eigen::Index n : {5, 10, 40}) {
    CAPTURE(n);
    std::vector<PhasePoint<double, Eigen::Dynamic>> starts;
    for (int i = 0; i < 11; ++i) starts.push_back(lattice_state<Eigen::Dynamic>(n, i % 5));
    compare(lattice_energy(n), lattice_energy(n), starts, 0.02, SimplifiedNewton{});
  }
  // Backwards over every operation, with a function that has no terms.
  const auto whole = from_energy<12>(
      [](const auto& q, const auto& p) { return (q.squaredNorm() + 1) * (p.squaredNorm() + 1) / 2; });
  std::vector<PhasePoint<double, 12>> starts;
  for (int i = 0; i < 11; ++i) starts.push_back(lattice_state<12>(12, i % 5));
  compare(whole, whole, starts, 0.01, SimplifiedNewton{});
  const Ensemble ensemble(whole, starts, scheme);
  CHECK_FALSE(ensemble.in_lanes());
}

TEST_CASE("An energy of packs goes in lanes") {
  const auto energy = [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; };
  const auto family = [energy]<class S>(const S*) { return from_energy<1, S>(energy); };
  std::vector<PhasePoint<double, 1>> starts;
  for (int i = 0; i < 11; ++i) starts.emplace_back(-1 - 0.1 * i, 0.2);
  Ensemble lanes(family, Eigen::MatrixXd(0, 11), starts, scheme);
  CHECK(lanes.in_lanes());
  CHECK(lanes.run({.dt = 0.05, .steps = 100}).ok());
  Ensemble plain(from_energy<1>(energy), starts, scheme);
  CHECK(plain.run({.dt = 0.05, .steps = 100}).ok());
  for (Eigen::Index i = 0; i < 11; ++i)
    CHECK((lanes.state(i).vector() - plain.state(i).vector()).norm() < 1e-12);
}

TEST_CASE("Failed steps are tried in parts, in lanes as alone", "[long]") {
  auto starts = lattices(13);
  for (const std::size_t i : {2u, 7u, 12u}) starts[i].q()[1] = 2.5 + 0.1 * double(i);
  for (const std::size_t i : {4u, 9u}) starts[i].q()[1] = 40;  // beyond help
  std::int64_t in_lanes = 0, one_by_one = 0;
  compare(Lattice5(), Lattice<5>{}, starts, 0.15, SimplifiedNewton{}, 6, &in_lanes);
  CHECK(in_lanes > 20);
  compare(Lattice<5>{}, Lattice<5>{}, starts, 0.15, SimplifiedNewton{}, 6, &one_by_one);
  CHECK(one_by_one == in_lanes);
  compare(Lattice5(), Lattice<5>{}, starts, 0.15, SimplifiedNewton{}, 2);
}

TEST_CASE("Members whose gradient throws stop there, stepped one by one") {
  std::vector<PhasePoint<double, 1>> starts;
  for (int i = 0; i < 9; ++i) starts.emplace_back(0.0, 0.1 * i);
  Ensemble ensemble(Fragile(), starts, scheme);
  CHECK(ensemble.run({.dt = 0.05, .steps = 100, .threads = 2}).failed == 3);
  for (Eigen::Index i = 0; i < 9; ++i) {
    CAPTURE(i);
    CHECK(ensemble.report(i).ok() == (i <= 5));
    const double t = ensemble.report(i).t;
    CHECK(ensemble.state(i).q()[0] == Approx(0.1 * double(i) * std::sin(t)).margin(1e-8));
    if (i <= 5) continue;
    CHECK(ensemble.failure(i) == "the gradient threw: q is above the limit");
    const double limit = std::asin(0.55 / (0.1 * double(i)));
    CHECK((t <= limit && t >= limit - 0.15));
  }
}

TEST_CASE("An observer may end the run of one member") {
  const auto starts = lattices(13);
  const auto until = [](Eigen::Index member, double t, const auto&) { return member % 3 != 1 || t < 0.255; };
  const auto check = [&](auto ensemble) {
    auto undisturbed = ensemble;
    std::vector<std::int64_t> heard(13, 0);
    const auto count = [&](Eigen::Index member, double, const auto&, const IntegrationReport& run) {
      CHECK(run.steps == 5 * heard[std::size_t(member)]++);
    };
    ensemble.run({.dt = 0.01, .steps = 50, .every = 5, .threads = 1}, until, count);
    undisturbed.run({.dt = 0.01, .steps = 50});
    for (Eigen::Index i = 0; i < 13; ++i) {
      CAPTURE(i);
      const bool stopped = i % 3 == 1;
      CHECK(ensemble.report(i).status == (stopped ? Status::stopped : Status::success));
      CHECK(ensemble.report(i).steps == (stopped ? 30 : 50));
      CHECK(heard[std::size_t(i)] == (stopped ? 7 : 11));
      if (!stopped) CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
    }
  };
  check(Ensemble(Lattice5(), starts, scheme));
  check(Ensemble(Lattice<5>{}, starts, scheme));
}

TEST_CASE("Each member has a Lyapunov exponent", "[long]") {
  const auto starts = lattices(5);
  const auto check = [&](auto ensemble) {
    using Exponents = LyapunovExponents<decltype(ensemble.stepper(0))>;
    std::vector<Exponents> exponents;
    for (Eigen::Index i = 0; i < ensemble.size(); ++i) exponents.emplace_back(ensemble.stepper(i), 2);
    ensemble.run({.dt = 0.02, .steps = 100, .threads = 2}, each(exponents));
    for (std::size_t i = 0; i < 5; ++i) {
      CAPTURE(i);
      auto stepper = ensemble.stepper(Eigen::Index(i));
      LyapunovExponents alone(stepper, 2);
      auto z = starts[i];
      integrate(stepper, z, {.dt = 0.02, .steps = 100}, alone);
      CHECK(exponents[i].exponents()[0] != 0);
      // The lattice's own gradient in registers, which lanes do not have, rounds in another way.
      CHECK((exponents[i].exponents() - alone.exponents()).norm() < 1e-10);
      CHECK((ensemble.in_lanes() || exponents[i].exponents() == alone.exponents()));
    }
    exponents.pop_back();
    CHECK(refuses([&] { ensemble.run({.dt = 0.02, .steps = 1}, each(exponents)); },
                  "4 observers and the ensemble 5"));
  };
  check(Ensemble(Lattice5(), starts, scheme));
  check(Ensemble(Lattice5(), starts, scheme, Broyden{}));
}

TEST_CASE("Observers of the whole hear where all members are together, which changes nothing") {
  const auto starts = lattices(13);
  const auto check = [&](auto ensemble) {
    auto undisturbed = ensemble, stopped = ensemble;
    undisturbed.run({.dt = 0.01, .steps = 25});
    std::vector<std::int64_t> steps;
    std::vector<double> times;
    const auto heard = [&](double t, const EnsembleReport& so_far) {
      steps.push_back(so_far.done);
      times.push_back(t);
      CHECK(so_far.steps == 13 * so_far.done);
    };
    ensemble.run({.dt = 0.01, .steps = 25, .threads = 2, .t0 = 3, .together = 10}, heard);
    CHECK(steps == std::vector<std::int64_t>{0, 10, 20, 25});
    CHECK(times == std::vector<double>{3, 3 + 10 * 0.01, 3 + 20 * 0.01, 3 + 25 * 0.01});
    for (Eigen::Index i = 0; i < 13; ++i) CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));

    // One that ends the run; it goes on later, with what it counted.
    const auto until = [](double, const EnsembleReport& so_far) { return so_far.done < 10; };
    const EnsembleReport first = stopped.run({.dt = 0.01, .steps = 25, .together = 5}, until);
    CHECK((first.stopped && first.done == 10 && first.t == 10 * 0.01));
    auto at_once = undisturbed;
    at_once.run({.dt = 0.01, .steps = 25, .t0 = 7}, [](double, const EnsembleReport&) { return false; });
    CHECK((at_once.report(0).steps == 0 && at_once.report(0).t == 7));
    CHECK(refuses([&] { stopped.run({.dt = 0.01, .steps = 25, .done = 9}); }, "9 steps are said to be done"));
    CHECK(refuses([&] { stopped.run({.dt = 0.02, .steps = 25, .done = 10}); }, "took steps of 0.01"));
    CHECK(refuses([&] { stopped.run({.dt = 0.01, .steps = 5, .done = 10}); }, "10 steps are done of 5"));
    const EnsembleReport second = stopped.run({.dt = 0.01, .steps = 25, .done = 10});
    CHECK((second.steps == 13 * 25 && second.done == 25 && second.ok()));
    for (Eigen::Index i = 0; i < 13; ++i) {
      CHECK(same_bits(stopped.state(i), undisturbed.state(i)));
      CHECK(stopped.report(i).evaluations == undisturbed.report(i).evaluations);
    }
  };
  check(Ensemble(Lattice5(), starts, scheme));
  check(Ensemble(Lattice5(), starts, scheme, Broyden{}));
}

TEST_CASE("Members of different sizes are refused") {
  Eigen::MatrixXd sizes(1, 3);
  sizes << 5, 7, 5;
  const auto family = [](const double* k) { return systems::NlsLattice<double>(Eigen::Index(k[0])); };
  const std::vector<PhasePoint<double, Eigen::Dynamic>> starts(3, PhasePoint<double, Eigen::Dynamic>(5));
  CHECK(refuses([&] { Ensemble(family, sizes, starts, scheme); },
                "the Hamiltonian of member 1 has 7 degrees of freedom, and the first one has 5"));
  sizes << -1, 5, 5;  // NlsLattice throws
  CHECK(Ensemble(family, sizes, starts, scheme).run({.dt = 0.01, .steps = 2}).failed == 1);
  sizes << 5, 5, 5;
  Ensemble fine(family, sizes, starts, scheme);
  CHECK(refuses([&] { fine.set_state(2, PhasePoint<double, Eigen::Dynamic>(4)); },
                "member 2 has 4 degrees of freedom and the Hamiltonian 5"));
}

}  // namespace test_members
