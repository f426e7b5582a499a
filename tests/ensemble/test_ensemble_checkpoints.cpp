// A run of an ensemble that goes on from a file is the run that was not interrupted, to the last bit.
#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
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

/// Interrupted at step 36 after a checkpoint at step 30, and resumed by other numbers of threads and other
/// parts.
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

/// With exponents of members that take all their steps, and with invariants of such as fail or need their
/// steps in parts.
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

TEST_CASE("An ensemble in lanes goes on from its checkpoint bit for bit, by any number of threads",
          "[long]") {
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
    auto all = each(forgotten);
    CHECK(refuses([&] { ensemble.run(later, std::ref(all)); }, "knows nothing of what came before"));
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

namespace {

/// Saves a run of an ensemble with these lists of observers, and says what is said of resuming it with
/// others.
struct Saved {
  Ensemble<detail::SameHamiltonian<Lattice<5>>> start{Lattice<5>{}, lattices(), scheme};
  Folder folder;
  std::filesystem::path file = folder.path / "run.checkpoint";
  EnsembleOptions options{.dt = 0.02, .steps = 20, .together = 10};

  template <class... Lists>
  void save(Lists... lists) const {
    auto ensemble = start;
    EnsembleCheckpoints checkpoints(file, {.every = 1}, ensemble, options, lists...);
    ensemble.run(options, each(lists)..., Interrupt{10}, checkpoints);
  }
  template <class... Lists>
  std::string resumed(Lists... lists) const {
    auto ensemble = start;
    EnsembleCheckpoints checkpoints(file, {.every = 1}, ensemble, options, lists...);
    const std::string why = refusal([&] { checkpoints.resume(); });
    if (why != accepted) {
      CHECK(same_bits(ensemble.state(3), start.state(3)));
      CHECK((lists[3].fresh() && ...));
    }
    return why;
  }
};

/// Functions "f" that are q[0], times a factor of one member's own.
auto functions(Eigen::Index member = 0, double factor = 1) {
  std::vector<Invariants<double, 5>> list(11);
  for (Eigen::Index i = 0; i < 11; ++i)
    list[std::size_t(i)].add("f", [k = i == member ? factor : 1](const auto& q, const auto&) {
      if (q[0] > 100) throw std::domain_error("q is above the limit");
      return k * q[0];
    });
  return list;
}

/// Times to hear of, of which one member has others.
auto times(std::size_t member = 0, std::vector<double> own = {0.1, 0.3}) {
  const auto at = [](std::vector<double> when) {
    return at_times(Lattice<5>{}, std::move(when), [](double, const PhasePoint<double, 5>&) {});
  };
  std::vector list(11, at({0.1, 0.3}));
  list[member] = at(std::move(own));
  return list;
}

}  // namespace

/// An observer with a file of its own.
struct Rows {
  static constexpr const char* name = "Rows";
  std::shared_ptr<CsvTrajectory> csv;
  void operator()(double t, const PhasePoint<double, 5>& z) const { (*csv)(t, z); }
  bool fresh() const { return csv->fresh(); }
  void describe(auto& list) const { csv->describe(list); }
  void visit_memory(auto&& visit) { csv->visit_memory(visit); }
};

TEST_CASE("A resume() of an ensemble that is refused leaves the rows of its members") {
  const Folder folder;
  const auto part = folder.path / "0.csv.part";
  const auto run = [&](const auto& hamiltonian, Interrupt dies) {
    Ensemble ensemble(hamiltonian, std::vector(2, lattices()[0]), scheme);
    std::vector<Rows> rows;
    for (const char* file : {"0.csv", "1.csv"})
      rows.push_back({std::make_shared<CsvTrajectory>(folder.path / file, 5)});
    EnsembleOptions options{.dt = 0.02, .steps = 30, .together = 5};
    EnsembleCheckpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, ensemble, options, rows);
    options.done = checkpoints.resume();
    ensemble.run(options, each(rows), checkpoints, dies);
    return options.done;
  };
  CHECK(run(Lattice<5>{}, Interrupt{15}) == 0);
  const std::string rows = contents(part);
  CHECK(refuses([&] { run(Stronger{}, Interrupt{20}); }, "another Hamiltonian"));
  CHECK(contents(part) == rows);
  CHECK(run(Lattice<5>{}, Interrupt{20}) == 10);
}

struct Counts {  // calls, of the whole or of members
  static constexpr const char* name = "Counts";
  mutable std::int64_t calls = 0;
  bool fresh() const { return calls == 0; }
  void describe(auto&) const {}
  void visit_memory(auto&& visit) { visit(calls); }
};
struct OfWhole : Counts {
  void operator()(double, const EnsembleReport&) { ++calls; }
};
struct OfMembers : Counts {
  void operator()(Eigen::Index, double, const PhasePoint<double, 5>&) const { ++calls; }
};

TEST_CASE("Observers of one's own that know nothing of the earlier part are refused by a resumed ensemble") {
  const auto resumed = [](auto observer, std::int64_t calls, std::int64_t every = 1) {
    Ensemble ensemble(Lattice<5>{}, std::vector(1, lattices()[0]), scheme);
    EnsembleOptions options{.dt = 0.02, .steps = 10, .every = every, .threads = 1};
    options.done = ensemble.run(options).done;
    options.steps = 20;
    observer.calls = calls;
    return refusal([&] { ensemble.run(options, observer); });
  };
  const std::string why = "the run is resumed after step 10, and an observer knows nothing of what came";
  CHECK(says(resumed(OfWhole(), 0), why));
  CHECK(says(resumed(OfMembers(), 0), why));
  CHECK(resumed(OfWhole(), 11) == accepted);
  CHECK(resumed(OfMembers(), 11) == accepted);
  CHECK(resumed(OfMembers(), 0, 0) == accepted);  // hears of no step
}

TEST_CASE("An ensemble whose observers hear of no step is resumed") {
  const Folder folder;
  const auto run = [&](Interrupt dies) {
    Ensemble ensemble(Lattice<5>{}, std::vector(2, lattices()[0]), scheme);
    std::vector<Record<double, 5>> records(2);
    EnsembleOptions options{.dt = 0.02, .steps = 30, .every = 0, .together = 5};
    EnsembleCheckpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, ensemble, options,
                                    records);
    options.done = checkpoints.resume();
    return ensemble.run(options, each(records), checkpoints, dies).done;
  };
  CHECK(run(Interrupt{15}) == 15);
  CHECK(run(Interrupt{99}) == 30);
}

TEST_CASE("An ensemble with a member whose gradient is infinite is resumed") {
  const Folder folder;
  std::vector<PhasePoint<double, 1>> starts{{1, 0}, {-800, 0}, {2, 0}};
  const auto morse = make_hamiltonian<double, 1>([](const auto&, const auto&) { return 0.0; },
                                                 [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                                   const double e = std::exp(-q[0]);
                                                   dHdq[0] = 2 * (1 - e) * e;
                                                   dHdp[0] = p[0];
                                                 });
  const auto run = [&](Interrupt dies) {
    Ensemble ensemble(morse, starts, scheme);
    EnsembleOptions options{.dt = 0.02, .steps = 30, .together = 5};
    EnsembleCheckpoints checkpoints(folder.path / "run.checkpoint", {.every = 10}, ensemble, options);
    options.done = checkpoints.resume();
    const auto report = ensemble.run(options, checkpoints, dies);
    CHECK(report.failed == 1);
    return std::pair(options.done, ensemble.state(2));
  };
  CHECK(run(Interrupt{15}).first == 0);
  const auto [done, state] = run(Interrupt{99});
  CHECK(done == 10);
  Ensemble undisturbed(morse, starts, scheme);
  undisturbed.run({.dt = 0.02, .steps = 30});
  CHECK(same_bits(state, undisturbed.state(2)));
}

TEST_CASE("An ensemble is not resumed with other functions of its observers") {
  Saved saved;
  saved.save(functions(), times());
  CHECK(saved.resumed(functions(), times()) == accepted);
  CHECK(saved.resumed(functions(7, 1 + 1e-15), times()) == accepted);  // another compiler's rounding
  CHECK(says(saved.resumed(functions(0, 2), times()), "it belongs to another f: where member 0 was saved"));
  CHECK(says(saved.resumed(functions(10, 1.001), times()), "another f: where member 10 was saved"));
  auto renamed = functions();
  renamed[4] = {};
  renamed[4].add("g", [](const auto& q, const auto&) { return q[0]; });
  CHECK(says(saved.resumed(renamed, times()), "'member 4: observer 1 g: a function"));
}

TEST_CASE("The checkpoints of an ensemble are those of the one that is run, from where it began") {
  const Folder folder;
  EnsembleOptions options{.dt = 0.05, .steps = 40, .together = 10};
  const Ensemble start(Product<double>{}, std::vector(3, PhasePoint<double, 1>(-3, 0)), scheme);
  const auto file = folder.path / "run.checkpoint";
  auto ensemble = start, copy = start, resumed = start, undisturbed = start;
  EnsembleCheckpoints checkpoints(file, {.every = 10}, ensemble, options);
  CHECK(refuses([&] { copy.run(options, checkpoints); }, "save another ensemble, or a copy of this one"));
  ensemble.run(options, Interrupt{20}, checkpoints);
  {
    EnsembleCheckpoints forgotten(file, {.every = 10}, copy, options);
    CHECK(forgotten.resume() == 20);
    CHECK(says(complaint<std::logic_error>([&] { copy.run(options, forgotten); }), "back to step 20"));
    options.done = 20;  // nothing was lost
    CHECK(copy.run(options).steps == 3 * 40);
    options.done = 0;
  }
  EnsembleCheckpoints again(file, {.every = 10}, resumed, options);
  options.done = again.resume();
  CHECK(options.done == 20);
  resumed.run(options, again);
  options.done = 0;
  undisturbed.run(options);
  CHECK(same_bits(resumed.state(2), undisturbed.state(2)));
  CHECK(same_bits(copy.state(2), undisturbed.state(2)));
}

TEST_CASE("An ensemble of packs alone is not resumed with another Hamiltonian") {
  const Folder folder;
  const EnsembleOptions options{.dt = 0.1, .steps = 20, .together = 10};
  const auto resumed = [&](double k, bool shared, bool save) {
    const std::vector<PhasePoint<double, 1>> starts(3, PhasePoint<double, 1>(1, 0.2));
    const auto go = [&](auto ensemble) {
      EnsembleCheckpoints checkpoints(folder.path / "run.checkpoint", {.every = 1}, ensemble, options);
      if (save) ensemble.run(options, Interrupt{10}, checkpoints);
      return refusal([&] { checkpoints.resume(); });
    };
    if (shared) return go(Ensemble(Product<detail::Many>{k}, starts, scheme));
    return go(Ensemble([k](const detail::Many* own) { return Product<detail::Many>{own[0] * k}; },
                       Eigen::MatrixXd::Ones(1, 3), starts, scheme));
  };
  for (const bool shared : {true, false}) {
    resumed(1, shared, true);
    CHECK(resumed(1, shared, false) == accepted);
    CHECK(says(resumed(7, shared, false), "it belongs to another Hamiltonian: where member 0 was saved"));
    std::filesystem::remove(folder.path / "run.checkpoint");
  }
}

TEST_CASE("A function of an observer that throws where the ensemble is saved does not end its run") {
  Saved saved;
  auto far = lattices();
  far[2].q()[0] = 1000;
  saved.start = Ensemble(Lattice<5>{}, far, scheme);
  saved.save(functions());
  CHECK(saved.resumed(functions()) == accepted);
  CHECK(says(saved.resumed(functions(3, 2)), "another f: where member 3 was saved"));
}

TEST_CASE("An ensemble is not resumed with other options of any member's observer") {
  Saved saved;
  saved.save(functions(), times());
  CHECK(says(saved.resumed(functions(), times(3, {0.1, 0.35})), "member 3: observer 2 times: 2 numbers 0.1"));
  CHECK(says(saved.resumed(functions(), times(10, {0.1})), "member 10: observer 2 times: 1 numbers"));
  CHECK(says(saved.resumed(functions(), times(0, {0.1, 0.2})), "observer 2 times: 2 numbers 0.1"));

  // What differs far beyond what is shown of it, and a member that has what all should have.
  std::vector<double> many;
  for (int i = 0; i < 1000; ++i) many.push_back(0.0004 * i);
  Saved other;
  other.save(times(3, many));
  CHECK(other.resumed(times(3, many)) == accepted);
  many[999] += 1e-9;
  const std::string why = other.resumed(times(3, many));
  CHECK((says(why, "member 3: observer 1 times: 1000 numbers 0 ") && why.size() < 700));
  CHECK(says(other.resumed(times()), "' there, 'nothing' here"));
  CHECK(says(other.resumed(times(4, many)), "'member 4: "));
}

TEST_CASE("The file of an ensemble whose observers have the same options names these once") {
  Saved one, many;
  one.start = Ensemble(Lattice<5>{}, std::vector(1, lattices()[0]), scheme);
  auto ensemble = one.start;
  auto first = std::vector(1, times()[0]), all = times();
  CHECK(
      EnsembleCheckpoints(one.file, {}, ensemble, one.options, first).settings().size() + 1 ==
      EnsembleCheckpoints(many.file, {}, many.start, many.options, all).settings().size());  // 1, 11 members
}

TEST_CASE("The members go on where they were put back, and what is saved has their number of steps") {
  const Folder folder;
  const auto file = folder.path / "run.checkpoint";
  EnsembleOptions options{.dt = 0.05, .steps = 20, .together = 10};
  const PhasePoint<double, 1> z(-3, 0);
  Ensemble ensemble(Product<double>{}, std::vector(3, z), scheme);
  {
    auto first = ensemble;
    EnsembleCheckpoints checkpoints(file, {.every = 10}, first, options);
    first.run(options, checkpoints);
    const auto old = contents(file);
    for (const int steps : {0, 10, 500})
      CHECK(refuses([&] { checkpoints.save(steps); }, "steps are said to be done, and 20 are"));
    CHECK(contents(file) == old);
    checkpoints.save(20);
  }
  options.steps = 40;
  EnsembleCheckpoints checkpoints(file, {.every = 10}, ensemble, options);
  options.done = checkpoints.resume();
  CHECK(options.done == 20);
  const auto there = ensemble.state(1);
  ensemble.set_state(1, z);
  CHECK(says(complaint<std::logic_error>([&] { ensemble.run(options, checkpoints); }),
             "leave the members where it has put them"));
  CHECK(same_bits(ensemble.state(1), z));
  ensemble.set_state(1, there);
  CHECK(ensemble.run(options, checkpoints).done == 40);
}

TEST_CASE("The checkpoint of an ensemble that was moved from is refused") {
  Saved saved;
  auto list = times();
  EnsembleCheckpoints checkpoints(saved.file, {}, saved.start, saved.options, list);
  const auto taken = std::move(saved.start);
  const auto says_so = [](const auto& action) {
    return says(complaint<std::logic_error>(action), "EnsembleCheckpoints: the ensemble was moved from");
  };
  CHECK(says_so([&] { checkpoints.resume(); }));
  CHECK(says_so([&] { checkpoints.save(10); }));
  std::vector<Invariants<double, 5>> none;
  CHECK(says_so([&] { EnsembleCheckpoints(saved.file, {}, saved.start, saved.options, none); }));
  CHECK_FALSE(std::filesystem::exists(saved.file));
}

TEST_CASE("A member whose observer threw at once keeps the others from nothing", "[ensemble_checkpoints]") {
  std::vector<Invariants<double, 5>> list(11);
  for (auto& one : list)
    one.add("q", [](const auto& q, const auto&) {
      if (q[1] > 30) throw std::domain_error("far");
      return q[0];
    });
  Ensemble ensemble(Lattice5(), wild_lattices(), scheme);
  ensemble.run({.dt = 0.01, .steps = 10}, each(list));
  REQUIRE(ensemble.report(7).status == Status::observer_threw);
  ensemble.run({.dt = 0.01, .steps = 20, .done = 10}, each(list));
  CHECK(ensemble.report(0).steps == 20);
}

TEST_CASE("An ensemble that begins without resume() says at once that no checkpoint can be written",
          "[checkpoint]") {
  const Folder folder;
  const auto path = folder.path / "run.checkpoint", part = folder.path / "run.checkpoint.part";
  std::filesystem::create_directory(part);
  Ensemble ensemble(systems::NlsLattice<double, 5>(), lattices(), scheme);
  const EnsembleOptions options{.dt = 0.01, .steps = 20, .every = 10};
  EnsembleCheckpoints checkpoints(path, {.seconds = 1e9}, ensemble, options);
  std::int64_t seen = 0;
  const auto run = [&] {
    ensemble.run(options, checkpoints, [&](double, const EnsembleReport& so_far) { seen = so_far.done; });
  };
  CHECK(says(complaint(run), "run.checkpoint.part: is in the way; remove it"));
  CHECK(seen == 0);
  std::filesystem::remove(part);
  CHECK(complaint(run) == accepted);
  CHECK(seen == 20);
  CHECK(std::filesystem::is_empty(folder.path));
}

}  // namespace test_ensemble_checkpoints
