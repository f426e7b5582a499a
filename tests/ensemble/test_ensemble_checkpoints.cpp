// A run of an ensemble that goes on from a file is the run that was not interrupted, to the last bit.
#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"
#include "plain.hpp"
#include "refusal.hpp"

namespace test_ensemble_checkpoints {

namespace {

using namespace plain;
using Lattice5 = systems::NlsLattice<double, 5>;
const auto scheme = schemes::low_defect6_s13<double>();

std::vector<PhasePoint<double, 5>> lattices() {
  std::vector<PhasePoint<double, 5>> starts;
  for (int i = 0; i < 11; ++i) starts.push_back(lattice_state<5>(5, i % 8));
  return starts;
}
/// The seventh fails at once, the ninth needs its steps cut into parts.
std::vector<PhasePoint<double, 5>> wild_lattices() {
  auto starts = lattices();
  starts[7].q()[1] = 40;
  starts[9].q()[1] = 3.2;
  return starts;
}

/// Ends the run.
struct Interrupt {
  std::int64_t at;
  bool operator()(double, const EnsembleReport& so_far) const { return so_far.done < at; }
};

/// Interrupted at step 36 after a checkpoint at step 30, and resumed by other numbers of threads and other parts.
template <class Start, class Make, class Number>
void check(const Start& start, const EnsembleOptions& whole, const Make& make, const Number& number) {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  auto undisturbed = start;
  std::vector<decltype(make(start, 0))> fresh;
  for (Eigen::Index i = 0; i < start.size(); ++i) fresh.push_back(make(start, i));
  auto expected = fresh;
  const EnsembleReport all = undisturbed.run(whole, each(expected));
  if (whole.subdivide > 0) CHECK((all.failed == 1 && undisturbed.report(9).subdivided > 5));

  for (const int threads : {1, 2, 3}) {
    CAPTURE(threads);
    EnsembleOptions options = whole;
    options.threads = threads;
    options.together = 6;
    {
      auto ensemble = start;
      auto observers = fresh;
      EnsembleCheckpoints checkpoints(file, {.every = 15}, ensemble, options, observers);
      CHECK(checkpoints.resume() == 0);
      CHECK(ensemble.run(options, each(observers), Interrupt{36}, checkpoints).done == 36);
    }
    auto ensemble = start;
    auto observers = fresh;
    options.threads = 4 - threads;
    options.together = 11;
    EnsembleCheckpoints checkpoints(file, {.every = 15}, ensemble, options, observers);
    options.done = checkpoints.resume();
    CHECK(options.done == 36);  // 18 and 36 are the first where all were together after 15 more
    const EnsembleReport report = ensemble.run(options, each(observers), checkpoints);
    CHECK(
        (report.steps == all.steps && report.evaluations == all.evaluations && report.failed == all.failed));
    for (Eigen::Index i = 0; i < 11; ++i) {
      CAPTURE(i);
      const IntegrationReport &one = ensemble.report(i), &other = undisturbed.report(i);
      CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));
      CHECK((one.status == other.status && one.steps == other.steps && one.t == other.t));
      CHECK((one.gradients == other.gradients && one.subdivided == other.subdivided));
      CHECK((one.max_correction == other.max_correction && one.last.rate == other.last.rate));
      CHECK(ensemble.failure(i) == undisturbed.failure(i));
      CHECK(number(observers[std::size_t(i)]) == number(expected[std::size_t(i)]));
    }
    checkpoints.remove();
    CHECK_FALSE(std::filesystem::exists(file));
  }
}

struct Stronger : Lattice<5> {
  void gradient(const In<double, 5>& q, const In<double, 5>& p, Out<double, 5> dHdq,
                Out<double, 5> dHdp) const {
    Lattice<5>::gradient(q, p, dHdq, dHdp);
    dHdq *= 1.01;
  }
};

/// H = k (q² + p²)/2, whose gradient throws where q is above 2.5.
template <class S>
struct Fragile {
  using Scalar = S;
  static constexpr int Dof = 1;
  S k;
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    using std::abs;
    if (any_above(q[0])) throw std::domain_error("q is above the limit");
    dHdq[0] = k * q[0];
    dHdp[0] = k * p[0];
  }
  static bool any_above(double q) { return q > 2.5; }
  static bool any_above(const RegisterPack<double>& q) { return any_of(q > 2.5); }
};

}  // namespace

/// With exponents of members that take all their steps, and with invariants of such as fail or need their steps in parts.
template <class Make>
void check(const Make& ensemble) {
  check(
      ensemble(lattices()), {.dt = 0.02, .steps = 60, .t0 = 5},
      [](const auto& of, Eigen::Index i) { return LyapunovExponents(of.stepper(i), 1); },
      [](const auto& exponents) { return exponents.exponents()[0]; });
  check(
      ensemble(wild_lattices()), {.dt = 0.12, .steps = 60, .every = 2, .t0 = 5, .subdivide = 4},
      [](const auto&, Eigen::Index) { return Invariants(Lattice5()); },
      [](const auto& invariants) { return invariants["energy"].worst; });
}

TEST_CASE("An ensemble in lanes goes on from its checkpoint bit for bit, by any number of threads") {
  check([](const auto& starts) { return Ensemble(Lattice5(), starts, scheme); });
}

TEST_CASE("An ensemble one by one goes on from its checkpoint bit for bit, by any number of threads") {
  check([](const auto& starts) {
    return Ensemble(Lattice<5>{}, starts, scheme, Broyden{.max_iterations = 12});
  });
}

TEST_CASE("Checkpoints of an ensemble keep parameters and why a member failed") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  Eigen::MatrixXd k(1, 10);
  for (Eigen::Index i = 0; i < 10; ++i) k(0, i) = 0.5 + 0.1 * double(i);
  std::vector<PhasePoint<double, 1>> starts;
  for (int i = 0; i < 10; ++i) starts.emplace_back(0.0, 0.3 * i);
  const auto family = []<class S>(const S* parameters) { return Fragile<S>{parameters[0]}; };
  EnsembleOptions options{.dt = 0.05, .steps = 120, .together = 70};
  Ensemble undisturbed(family, k, starts, scheme);
  CHECK(undisturbed.run(options).failed == 1);
  {
    Ensemble ensemble(family, k, starts, scheme);
    EnsembleCheckpoints checkpoints(file, {.every = 1}, ensemble, options);
    ensemble.run(options, checkpoints, Interrupt{70});
  }
  Ensemble ensemble(family, k, starts, scheme);
  EnsembleCheckpoints checkpoints(file, {.every = 1}, ensemble, options);
  options.done = checkpoints.resume();
  CHECK(options.done == 70);
  CHECK(ensemble.failure(9) == "the gradient threw: q is above the limit");
  ensemble.run(options, checkpoints);
  for (Eigen::Index i = 0; i < 10; ++i) CHECK(same_bits(ensemble.state(i), undisturbed.state(i)));

  // Other parameters are another run.
  k(0, 4) = 0.901;
  Ensemble other(family, k, starts, scheme);
  EnsembleCheckpoints of_other(file, {.every = 1}, other, options);
  CHECK(refuses([&] { of_other.resume(); }, "checksum of the parameters"));
}

TEST_CASE("A checkpoint of another ensemble is refused, and nothing is changed") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  const auto starts = lattices();
  const EnsembleOptions options{.dt = 0.02, .steps = 20, .together = 10};
  const auto watch = [](const auto& ensemble) {
    std::vector<LyapunovExponents<decltype(ensemble.stepper(0))>> list;
    for (Eigen::Index i = 0; i < ensemble.size(); ++i) list.emplace_back(ensemble.stepper(i), 1);
    return list;
  };
  {
    Ensemble ensemble(Lattice<5>{}, starts, scheme);
    auto exponents = watch(ensemble);
    EnsembleCheckpoints checkpoints(file, {.every = 1, .run = "a"}, ensemble, options, exponents);
    ensemble.run(options, each(exponents), Interrupt{10}, checkpoints);
  }
  const auto says_why = [&](auto ensemble, const EnsembleOptions& of, const std::string& label = "a") {
    auto exponents = watch(ensemble);
    EnsembleCheckpoints checkpoints(file, {.every = 1, .run = label}, ensemble, of, exponents);
    const auto before = ensemble.state(3);
    const std::string why = refusal([&] { checkpoints.resume(); });
    CHECK(says(why, file.string()));
    CHECK(same_bits(ensemble.state(3), before));
    CHECK(exponents[3].fresh());
    return why;
  };
  const Ensemble same(Lattice<5>{}, starts, scheme);
  CHECK(says(says_why(same, {.dt = 0.03, .steps = 20}), "dt"));
  CHECK(says(says_why(same, {.dt = 0.02, .steps = 20, .subdivide = 1}), "subdivide"));
  CHECK(says(says_why(same, options, "b"), "run: a"));
  CHECK(says(says_why(Ensemble(Lattice<5>{}, starts, scheme, Broyden{}), options), "Broyden"));
  CHECK(says(says_why(Ensemble(Lattice5(), starts, scheme), options), "in lanes"));
  CHECK(says(says_why(Ensemble(Lattice<5>{}, starts, schemes::yoshida6()), options), "scheme"));
  auto moved = starts;
  moved[10].p()[2] += 1e-9;
  CHECK(says(says_why(Ensemble(Lattice<5>{}, moved, scheme), options), "other initial states"));
  CHECK(says(says_why(Ensemble(Stronger{}, starts, scheme), options), "another Hamiltonian: where member 0"));

  Ensemble ensemble(Lattice<5>{}, starts, scheme);
  auto exponents = watch(ensemble);
  {
    EnsembleCheckpoints checkpoints(file, {.every = 1, .run = "a"}, ensemble, options, exponents);
    EnsembleOptions later = options;
    later.done = checkpoints.resume();
    auto forgotten = watch(ensemble);
    CHECK(refuses([&] { ensemble.run(later, each(forgotten)); }, "knows nothing of what came before"));
    CHECK(ensemble.run(later, each(exponents)).done == 20);
    exponents.pop_back();
    CHECK(refuses([&] { EnsembleCheckpoints(file, {}, ensemble, options, exponents); },
                  "a list has 10 observers and the ensemble 11"));
  }
  std::string bytes = contents(file);
  bytes[bytes.size() / 2] = char(bytes[bytes.size() / 2] ^ 1);
  std::ofstream(file, std::ios::binary) << bytes;
  CHECK(says(says_why(same, options), "damaged"));
}

}  // namespace test_ensemble_checkpoints
