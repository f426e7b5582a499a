#include "catch.hpp"

#include <atomic>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/systems.hpp>

#include "plain.hpp"
#include "refusal.hpp"

namespace test_ensemble {

namespace {

using namespace plain;
using Lattice5 = systems::NlsLattice<double, 5>;

/// 37 members fill no whole number of packs, whatever their width.
std::vector<PhasePoint<double, 5>> lattices(int count = 37) {
  std::vector<PhasePoint<double, 5>> starts;
  for (int i = 0; i < count; ++i) starts.push_back(lattice_state<5>(5, i % 8));
  for (int i = 0; i < count; ++i) starts[std::size_t(i)].q()[0] += 0.01 * i;
  return starts;
}

[[maybe_unused]] bool any_of(bool one) { return one; }  // as of the lanes of a pack

/// H = k (q² + p²)/2, whose gradient throws where q is above `limit`.
template <class S>
struct Fragile {
  using Scalar = S;
  static constexpr int Dof = 1;
  S k;
  double limit;
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    if (any_of(q[0] > limit)) throw std::domain_error("q is above the limit");
    dHdq[0] = k * q[0];
    dHdp[0] = k * p[0];
  }
};

/// Of no size.
struct Empty {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index dof() const { return 0; }
  void gradient(In<double, Dof>, In<double, Dof>, Out<double, Dof>, Out<double, Dof>) const {}
};

const auto scheme = schemes::low_defect6_s13<double>();

}  // namespace

TEST_CASE("Every member takes the steps that it would take alone") {
  const auto starts = lattices();
  const SimplifiedNewton solver{.stop = StoppingRule::paper(1e-13)};
  Ensemble ensemble(Lattice5(), starts, scheme, solver);
  const EnsembleReport all = ensemble.run({.dt = 0.02, .steps = 60});
  CHECK(all.ok());
  CHECK(all.members == 37);
  CHECK(all.steps == 37 * 60);
  std::int64_t evaluations = 0;
  for (Eigen::Index i = 0; i < ensemble.size(); ++i) {
    CAPTURE(i);
    Semiexplicit stepper(Lattice<5>{}, scheme, solver);
    auto z = starts[std::size_t(i)];
    const IntegrationReport alone = integrate(stepper, z, {.dt = 0.02, .steps = 60}),
                            &report = ensemble.report(i);
    CHECK(same_bits(ensemble.state(i), z));
    CHECK((report.status == alone.status && report.steps == 60 && report.t == alone.t));
    CHECK((report.evaluations == alone.evaluations && report.gradients == alone.gradients));
    CHECK((report.max_correction == alone.max_correction && report.last.correction == alone.last.correction));
    evaluations += alone.evaluations;
  }
  CHECK(all.evaluations == evaluations);
  CHECK(evaluations > 37 * 60);
}

TEST_CASE("Members take the usual scheme where none is given") {
  const std::vector<PhasePoint<double, 1>> starts(3, PhasePoint<double, 1>(1, 0.5));
  Ensemble ensemble(systems::Product<double>(), starts);
  ensemble.run({.dt = 0.1, .steps = 10});
  Semiexplicit stepper{systems::Product<double>()};
  auto z = starts[0];
  for (int n = 0; n < 10; ++n) stepper.step(z, 0.1);
  CHECK(ensemble.state(2).vector() == z.vector());
}

TEST_CASE("The number of threads changes nothing") {
  std::vector<PhasePoint<double, 5>> results[5];
  for (int i = 1; i <= 4; ++i) {
    const int threads = i < 4 ? i : 1'000'000;  // far more than can be started
    CAPTURE(threads);
    Ensemble ensemble(Lattice5(), lattices(), scheme);
    ensemble.run({.dt = 0.02, .steps = 50, .threads = threads});
    for (Eigen::Index member = 0; member < 37; ++member) {
      results[i].push_back(ensemble.state(member));
      CHECK(same_bits(results[i].back(), results[1][std::size_t(member)]));
    }
  }
}

TEST_CASE("A run in parts is the run in one") {
  Ensemble whole(Lattice5(), lattices(), scheme);
  Ensemble parts = whole;
  whole.run({.dt = 0.01, .steps = 30});
  parts.run({.dt = 0.01, .steps = 10});
  parts.run({.dt = 0.01, .steps = 20, .t0 = 0.1});
  for (Eigen::Index i = 0; i < whole.size(); ++i) CHECK(same_bits(whole.state(i), parts.state(i)));
  CHECK(parts.report(3).t == Approx(0.3));
}

TEST_CASE("Members have parameters of their own") {
  // Oscillators of frequencies k turn by k t.
  Eigen::MatrixXd k(1, 11);
  for (Eigen::Index i = 0; i < 11; ++i) k(0, i) = 0.5 + 0.25 * double(i);
  const std::vector<PhasePoint<double, 1>> starts(11, PhasePoint<double, 1>(1, 0));
  const auto family = []<class S>(const S* parameters) { return Fragile<S>{parameters[0], 10}; };
  Ensemble ensemble(family, k, starts, scheme);
  CHECK(ensemble.run({.dt = 0.05, .steps = 200}).ok());
  for (Eigen::Index i = 0; i < 11; ++i) {
    CAPTURE(i);
    CHECK(ensemble.state(i).q()[0] == Approx(std::cos(10 * k(0, i))).margin(1e-8));
    CHECK(ensemble.state(i).p()[0] == Approx(-std::sin(10 * k(0, i))).margin(1e-8));
  }
}

TEST_CASE("A member whose gradient throws says so, and the others go on") {
  Eigen::MatrixXd k(1, 21);
  std::vector<PhasePoint<double, 1>> starts;
  for (int i = 0; i < 21; ++i) {
    k(0, i) = 1 + i % 3;
    starts.emplace_back(0.0, 0.1 * i);  // q = 0.1 i sin k t
  }
  const auto bounded = []<class S>(const S* parameters) { return Fragile<S>{parameters[0], 0.85}; };
  const auto free = []<class S>(const S* parameters) { return Fragile<S>{parameters[0], 100}; };
  for (const int threads : {1, 3}) {
    Ensemble ensemble(bounded, k, starts, scheme);
    Ensemble undisturbed(free, k, starts, scheme);
    const EnsembleReport all = ensemble.run({.dt = 0.05, .steps = 100, .threads = threads});
    undisturbed.run({.dt = 0.05, .steps = 100});
    CHECK(all.failed == 12);
    for (Eigen::Index i = 0; i < 21; ++i) {
      CAPTURE(i);
      const IntegrationReport& report = ensemble.report(i);
      if (i <= 8) {
        CHECK(report.ok());
        CHECK(report.steps == 100);
        CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
      } else {
        CHECK(report.status == Status::gradient_threw);
        CHECK(ensemble.failure(i) == "the gradient threw: q is above the limit");
        // It stays where its last step ended.
        const double amplitude = 0.1 * double(i), limit = std::asin(0.85 / amplitude) / k(0, i);
        CHECK(report.t <= limit);
        CHECK(report.t >= limit - 0.15);
        CHECK(ensemble.state(i).q()[0] == Approx(amplitude * std::sin(k(0, i) * report.t)).margin(1e-8));
      }
    }
  }
}

TEST_CASE("A member for which the family throws says so, and the others go on") {
  Eigen::MatrixXd k(1, 13);
  for (Eigen::Index i = 0; i < 13; ++i) k(0, i) = 1 + 0.1 * double(i);
  const std::vector<PhasePoint<double, 1>> starts(13, PhasePoint<double, 1>(1, 0));
  Eigen::MatrixXd wrong = k;
  for (const Eigen::Index i : {0, 5, 6}) wrong(0, i) = -1;
  const auto family = []<class S>(const S* parameters) {
    if (any_of(parameters[0] < 0.0)) throw std::invalid_argument("k is negative");
    return Fragile<S>{parameters[0], 10};
  };
  const auto check = [&](auto solver, bool in_lanes) {
    Ensemble ensemble(family, wrong, starts, scheme, solver), undisturbed(family, k, starts, scheme, solver);
    CHECK(ensemble.in_lanes() == in_lanes);
    std::vector<int> heard(13, 0);
    const auto count = [&](Eigen::Index member, double, const auto&) { ++heard[std::size_t(member)]; };
    CHECK(ensemble.run({.dt = 0.05, .steps = 50}, count).failed == 3);
    CHECK(ensemble.run({.dt = 0.05, .steps = 100, .done = 50}, count).failed == 3);
    undisturbed.run({.dt = 0.05, .steps = 100});
    for (Eigen::Index i = 0; i < 13; ++i) {
      CAPTURE(i);
      const IntegrationReport& report = ensemble.report(i);
      if (wrong(0, i) < 0) {
        CHECK(report.status == Status::gradient_threw);
        CHECK(ensemble.failure(i) == "the family threw: k is negative");
        CHECK((report.steps == 0 && report.t == 0 && heard[std::size_t(i)] == 1));
        CHECK(same_bits(ensemble.state(i), starts[0]));
      } else {
        CHECK((report.ok() && report.steps == 100 && heard[std::size_t(i)] == 101));
        CHECK(report.evaluations == undisturbed.report(i).evaluations);
        CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
      }
    }
  };
  check(SimplifiedNewton{}, true);
  check(Broyden{}, false);
  CHECK(refuses([&] { Ensemble(family, Eigen::MatrixXd::Constant(1, 13, -1), starts, scheme); },
                "k is negative"));
}

TEST_CASE("A member whose own observer throws says so, and the others go on") {
  struct Strict {
    double limit;
    int seen = 0;
    void operator()(double, const PhasePoint<double, 1>& z) {
      ++seen;
      if (z.q()[0] > limit) throw std::runtime_error("above " + std::to_string(int(limit)));
    }
  };
  Eigen::MatrixXd k = Eigen::MatrixXd::Constant(1, 11, 1.0);
  const std::vector<PhasePoint<double, 1>> starts(11, PhasePoint<double, 1>(0, 3));
  const auto family = []<class S>(const S* parameters) { return Fragile<S>{parameters[0], 100}; };
  const auto check = [&](auto ensemble, auto undisturbed) {
    std::vector<Strict> observers;
    for (int i = 0; i < 11; ++i) observers.push_back({i % 4 == 2 ? 2.0 : 10.0});
    const EnsembleReport all = ensemble.run({.dt = 0.05, .steps = 100}, each(observers));
    undisturbed.run({.dt = 0.05, .steps = 100});
    CHECK(all.failed == 3);
    for (Eigen::Index i = 0; i < 11; ++i) {
      CAPTURE(i);
      if (i % 4 == 2) {
        CHECK(ensemble.report(i).status == Status::observer_threw);
        CHECK(ensemble.failure(i) == "an observer of this member threw: above 2");
        CHECK(ensemble.report(i).steps == 15);  // 3 sin(0.75) > 2
      } else {
        CHECK(ensemble.report(i).ok());
        CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
        CHECK(observers[static_cast<std::size_t>(i)].seen == 101);
      }
    }
  };
  check(Ensemble(family, k, starts, scheme), Ensemble(family, k, starts, scheme));
  check(Ensemble(family, k, starts, scheme, Broyden{}), Ensemble(family, k, starts, scheme, Broyden{}));
}

TEST_CASE("A member that fails says so, and the others go on") {
  auto starts = lattices(11);
  for (const std::size_t i : {3u, 10u}) starts[i].q()[0] = 50;  // too fast for the step
  starts[5].p()[1] = std::nan("");
  Ensemble ensemble(Lattice5(), starts, scheme), undisturbed(Lattice5(), lattices(11), scheme);
  CHECK(ensemble.run({.dt = 0.01, .steps = 20}).failed == 3);
  undisturbed.run({.dt = 0.01, .steps = 20});
  for (Eigen::Index i = 0; i < 11; ++i) {
    CAPTURE(i);
    const bool bad = i == 3 || i == 5 || i == 10;
    CHECK(ensemble.report(i).ok() == !bad);
    CHECK(ensemble.report(i).steps == (bad ? 0 : 20));
    if (!bad) CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
    if (i == 3) CHECK(same_bits(ensemble.state(i), starts[3]));
  }
  CHECK(ensemble.report(5).status == Status::invalid_state);
  CHECK(says(ensemble.failure(10), "reduce dt"));
}

TEST_CASE("An observer hears of every member at the times asked for") {
  Ensemble ensemble(Lattice5(), lattices(), scheme);
  std::vector<std::vector<double>> times(37);  // a member is told of by one thread at a time
  ensemble.run({.dt = 0.01, .steps = 25, .every = 10, .threads = 3, .t0 = 7},
               [&](Eigen::Index member, double t, const auto&) { times[std::size_t(member)].push_back(t); });
  for (const auto& heard : times) CHECK(heard == std::vector<double>{7, 7 + 10 * 0.01, 7 + 20 * 0.01});
  int calls = 0;  // without .every at each step
  ensemble.run({.dt = 0.01, .steps = 5, .threads = 1}, [&](Eigen::Index, double, const auto&) { ++calls; });
  CHECK(calls == 37 * 6);
  const auto in_no_step = [](auto members) {
    int told = 0, together = 0;
    members.run(
        {.dt = 0.01, .steps = 0, .threads = 1}, [&](Eigen::Index, double, const auto&) { ++told; },
        [&](double, const EnsembleReport&) { ++together; });
    return std::pair(told, together);
  };
  CHECK(in_no_step(Ensemble(Lattice5(), lattices(), scheme)) == std::pair(37, 1));
  CHECK(in_no_step(Ensemble(Lattice5(), lattices(), scheme, Broyden{})) == std::pair(37, 1));
}

TEST_CASE("An exception of the observer comes out when the others are done") {
  for (const int threads : {1, 2, 4}) {
    Ensemble ensemble(Lattice5(), lattices(), scheme);
    const auto observe = [](Eigen::Index member, double t, const auto&) {
      if ((member == 0 || member == 30) && t > 0.045)
        throw std::runtime_error("seen by " + std::to_string(member));
    };
    CHECK_THROWS_WITH(ensemble.run({.dt = 0.01, .steps = 10, .every = 5, .threads = threads}, observe),
                      "seen by 0");
    CHECK(ensemble.report(0).status == Status::stopped);
    CHECK(ensemble.report(0).steps == 5);
    CHECK(ensemble.report(20).steps == 10);
  }
}

TEST_CASE("A member that does not exist is refused") {
  std::vector<PhasePoint<double, 5>> starts(3);
  for (auto& z : starts) z.q().setOnes();
  Ensemble ensemble(systems::NlsLattice<double, 5>(), starts, schemes::low_defect6_s13<double>());
  CHECK(ensemble.run({.dt = 0.01, .steps = 2}).ok());
  for (const Eigen::Index member : {Eigen::Index(-1), Eigen::Index(3), Eigen::Index(1'000'000)}) {
    CHECK_THROWS_AS(ensemble.state(member), std::out_of_range);
    CHECK_THROWS_AS(ensemble.set_state(member, starts[0]), std::out_of_range);
    CHECK_THROWS_AS(ensemble.report(member), std::out_of_range);
    CHECK_THROWS_AS(ensemble.failure(member), std::out_of_range);
    CHECK_THROWS_AS(ensemble.hamiltonian(member), std::out_of_range);
  }
  CHECK(ensemble.state(2).dof() == 5);
}

TEST_CASE("An ensemble that was moved from has no members and says so") {
  const auto check = [](auto from) {
    from.run({.dt = 0.02, .steps = 3});
    auto to = std::move(from);
    const auto says_so = [](const auto& action) {
      return says(complaint<std::logic_error>(action), "Ensemble: it was moved from");
    };
    for (const auto& empty : {from, decltype(from)(from)}) {  // NOLINT: that is what is tested
      CHECK(empty.size() == 0);
      CHECK(says_so([&] { empty.state(0); }));
      CHECK(says_so([&] { empty.report(0); }));
      CHECK(says_so([&] { empty.failure(-1); }));
      CHECK(says_so([&] { empty.hamiltonian(0); }));
      CHECK(says_so([&] { empty.stepper(4); }));
    }
    CHECK(says_so([&] { from.set_state(0, to.state(0)); }));
    CHECK(says_so([&] { from.run({.dt = 0.02, .steps = 3}); }));
    CHECK(says_so([&] { from.run({.dt = 0.02, .steps = 6, .done = 3}); }));
    CHECK(to.size() == 5);
    CHECK(
        says(complaint<std::invalid_argument>([&] { to.run({.dt = 0.02, .steps = 6, .t0 = 5, .done = 3}); }),
             "give the t0 that it began with"));
    CHECK(to.run({.dt = 0.02, .steps = 6, .done = 3}).steps == 30);

    from = to;
    CHECK(from.run({.dt = 0.02, .steps = 3}).steps == 15);
    to = std::move(from);
    CHECK((from.size() == 0 && to.report(4).steps == 3));
    CHECK(says_so([&] { from.run({.dt = 0.02, .steps = 3}); }));
  };
  check(Ensemble(Lattice5(), lattices(5), scheme));
  check(Ensemble(Lattice5(), lattices(5), scheme, Broyden{}));
  const auto family = []<class S>(const S* k) { return Fragile<S>{k[0], 10}; };
  const std::vector<PhasePoint<double, 1>> starts(5, PhasePoint<double, 1>(1, 0));
  check(Ensemble(family, Eigen::MatrixXd::Ones(1, 5), starts, scheme));
}

TEST_CASE("An ensemble that makes no sense is refused") {
  const auto family = []<class S>(const S* parameters) { return Fragile<S>{parameters[0], 10}; };
  const std::vector<PhasePoint<double, 1>> two(2);
  CHECK(refuses([&] { Ensemble(family, Eigen::MatrixXd(1, 3), two, scheme); },
                "2 initial states and 3 columns of parameters"));
  CHECK(refuses([&] { Ensemble(family, Eigen::MatrixXd(1, 0), {}, scheme); }, "no member"));
  const systems::NlsLattice<double> lattice(4);
  std::vector<PhasePoint<double, Eigen::Dynamic>> states(3, PhasePoint<double, Eigen::Dynamic>(4));
  states[1] = PhasePoint<double, Eigen::Dynamic>(5);
  CHECK(refuses([&] { Ensemble(lattice, states, scheme); },
                "member 1 has 5 degrees of freedom and the Hamiltonian 4"));
  states.assign(3, PhasePoint<double, Eigen::Dynamic>());
  CHECK(refuses([&] { Ensemble(Empty(), states, scheme); }, "0 degrees of freedom; give it one at least"));
  Ensemble fine(Lattice5(), lattices(3), scheme);
  CHECK(refuses([&] { fine.run({.dt = 0.1, .steps = -2}); }, "must not be negative"));
  CHECK(refuses([&] { fine.run({.dt = 0.1}); }, "give steps, or there is no end"));
  CHECK(fine.run({.dt = 0.1, .steps = 0}).ok());
  CHECK(refuses([&] { fine.run({.dt = 0.1, .steps = 1, .t0 = std::nan("")}); }, "t0 is not finite"));
  CHECK(refuses([&] { fine.run({.dt = 1e307, .steps = 30}); }, "t0 + steps dt is not finite"));
  CHECK(fine.run({.dt = 0, .steps = 1}).failed == 3);
  CHECK(says(fine.failure(0), "dt is zero"));
}

}  // namespace test_ensemble
