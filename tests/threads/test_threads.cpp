// One large trajectory by several threads (tests/CMakeLists.txt: OpenMP): the bits are those of one thread,
// and those of a Hamiltonian that does not say how far its sites reach, which is kicked as a whole.
#include "catch.hpp"

#include <cmath>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_threads {

namespace {

using namespace semiexplicit;
constexpr int dynamic = Eigen::Dynamic;
template <class Scalar>
using Point = PhasePoint<Scalar, dynamic>;

void set_threads([[maybe_unused]] int threads) {
#ifdef _OPENMP
  omp_set_num_threads(threads);
#endif
}
/// As many as there were, also where a test fails.
struct Threads {
#ifdef _OPENMP
  int before = omp_get_max_threads();
#else
  int before = 1;
#endif
  ~Threads() { set_threads(before); }
};

template <class Scalar>
Point<Scalar> some_state(Eigen::Index d) {
  Point<Scalar> z(d);
  for (Eigen::Index i = 0; i < d; ++i) {
    z.q()[i] = Scalar(0.3 * std::cos(double(i)));
    z.p()[i] = Scalar(0.2 * std::sin(1 + 2.0 * double(i)));
  }
  return z;
}

/// Ranges of the lattice, which it does not say to be of near neighbours.
template <class S>
struct RangesOf {
  using Scalar = S;
  static constexpr int Dof = dynamic;
  using RangeGradientOf = RangesOf;
  systems::NlsLattice<S> lattice;
  Eigen::Index dof() const { return lattice.dof(); }
  void gradient(In<S, dynamic> q, In<S, dynamic> p, Out<S, dynamic> dHdq, Out<S, dynamic> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
  void gradient_range(Eigen::Index begin, Eigen::Index end, const S* q, const S* p, S* dHdq, S* dHdp) const {
    lattice.gradient_range(begin, end, q, p, dHdq, dHdp);
  }
};

/// A user's chain: Σ (qᵢ² + 1)(pᵢ² + 1)/2 + c/2 Σ (qᵢ - qᵢ₊ᵣ)², of reach r; the gradient throws where a q is
/// above `limit`.
template <bool local>
struct Chain {
  using Scalar = double;
  static constexpr int Dof = dynamic;
  using RangeGradientOf = Chain;
  Eigen::Index n, r;
  double limit = 1e300;
  Eigen::Index dof() const { return n; }
  Eigen::Index reach() const requires local { return r; }
  void gradient(In<double, dynamic> q, In<double, dynamic> p, Out<double, dynamic> dHdq,
                Out<double, dynamic> dHdp) const {
    gradient_range(0, n, q.data(), p.data(), dHdq.data(), dHdp.data());
  }
  void gradient_range(Eigen::Index begin, Eigen::Index end, const double* q, const double* p, double* dHdq,
                      double* dHdp) const {
    for (Eigen::Index i = begin; i < end; ++i) {
      if (q[i] > limit) throw std::domain_error("site " + std::to_string(i));
      double pull = 0;
      if (i >= r) pull += q[i] - q[i - r];
      if (i + r < n) pull += q[i] - q[i + r];
      dHdq[i - begin] = q[i] * (p[i] * p[i] + 1) + 0.1 * pull;
      dHdp[i - begin] = p[i] * (q[i] * q[i] + 1);
    }
  }
};

template <class Scalar>
bool same_bits(const Point<Scalar>& x, const Point<Scalar>& y) {
  if (x.dof() != y.dof()) return false;
  for (Eigen::Index i = 0; i < x.vector().size(); ++i)
    if (!(x.vector()[i] == y.vector()[i])) return false;
  return true;
}

/// Where so many steps lead, and the evaluations.
template <class Stepper>
auto run(Stepper stepper, typename Stepper::State z, double dt, int steps) {
  const IntegrationReport report =
      integrate(stepper, z, {.dt = typename Stepper::Scalar(dt), .steps = steps});
  return std::pair(z, report.evaluations);
}

const auto scheme = schemes::low_defect6_s13<double>();

/// Steps of `local` by 1, 2, 3 and 5 threads, against those of `whole` by one.
template <class Local, class Whole>
void compare(const Local& local, const Whole& whole, double dt, int steps, const SimplifiedNewton& solver) {
  const Threads back;
  using Scalar = typename Local::Scalar;
  const auto scheme_of = schemes::low_defect6_s13<Scalar>();
  const auto start = some_state<Scalar>(local.dof());
  set_threads(1);
  const auto [expected, evaluations] = run(Semiexplicit(whole, scheme_of, solver), start, dt, steps);
  CHECK(evaluations >= steps);
  for (const int threads : {1, 2, 3, 5}) {
    CAPTURE(local.dof(), threads);
    set_threads(threads);
    const auto [z, count] = run(Semiexplicit(local, scheme_of, solver), start, dt, steps);
    CHECK(same_bits(z, expected));
    CHECK(count == evaluations);
    const auto [other, other_count] = run(Semiexplicit(whole, scheme_of, solver), start, dt, steps);
    CHECK(same_bits(other, expected));
  }
}

}  // namespace

TEST_CASE("A large lattice has the same bits by any number of threads", "[long]") {
  static_assert(HasLocalGradient<systems::NlsLattice<double>> && !HasLocalGradient<RangesOf<double>>);
  for (const Eigen::Index n : {1000, 7500, 12345, 40'000}) {
    const systems::NlsLattice<double> lattice(n);
    compare(lattice, RangesOf<double>{lattice}, 0.05, 3, {});
    compare(lattice, RangesOf<double>{lattice}, 0.1, 2, {.stop = StoppingRule::paper(1e-12)});
  }
  const systems::NlsLattice<double> long_one(150'001);  // its moves are not summed, one thread goes in waves
  compare(long_one, RangesOf<double>{long_one}, 0.1, 2, {.stop = StoppingRule::paper(1e-11)});
  const systems::NlsLattice<float> single(20'000);
  compare(single, RangesOf<float>{single}, 0.05, 2, {});
}

TEST_CASE("A user's Hamiltonian may reach a block far") {
  for (const Eigen::Index reach : {1, 3, 64, 65, 1000}) {
    CAPTURE(reach);
    compare(Chain<true>{20'011, reach}, Chain<false>{20'011, reach}, 0.1, 2, {});
  }
}

TEST_CASE("An exception of a gradient in a thread leaves the state, and comes out") {
  const Threads back;
  for (const int threads : {1, 2, 3}) {
    CAPTURE(threads);
    set_threads(threads);
    auto z = some_state<double>(20'000);
    z.q()[15'000] = 7;
    const auto start = z;
    Semiexplicit stepper(Chain<true>{20'000, 1, 5}, scheme), whole(Chain<true>{20'000, 1}, scheme);
    CHECK_THROWS_WITH(stepper.step(z, 0.01), "site 15000");
    CHECK(same_bits(z, start));
    z.q()[15'000] = 0;
    auto other = z;
    CHECK(stepper.step(z, 0.01).ok());
    CHECK(whole.step(other, 0.01).ok());
    CHECK(same_bits(z, other));
  }
}

TEST_CASE("The other doubled steps of a large lattice have the same bits by any number of threads",
          "[long]") {
  const Threads back;
  const systems::NlsLattice<double> lattice(40'000);
  const auto start = some_state<double>(lattice.dof());
  const auto check = [&](const auto& stepper, const auto& z) {
    set_threads(1);
    const auto expected = run(stepper, z, 0.02, 2).first;
    for (const int threads : {2, 3}) {
      set_threads(threads);
      const auto found = run(stepper, z, 0.02, 2).first;
      CHECK((found.q() == expected.q() && found.p() == expected.p()));
    }
  };
  check(MidpointProjection(lattice, scheme), start);
  check(Semiexplicit(lattice, scheme, Broyden{.stop = StoppingRule::paper(1e-12)}), start);
  check(Pihajoki(lattice, scheme), ExtendedPoint<double, dynamic>(start));
  check(Tao(lattice, schemes::yoshida6(), 10), ExtendedPoint<double, dynamic>(start));
  // An energy on a tape has its increments added by threads.
  const Eigen::Index n = 70'000;
  const auto energy = from_energy(n, [n](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) { return (q[i] * q[i] + 1) * (p[i] * p[i] + 1) / 2; });
  });
  check(Semiexplicit(energy, schemes::strang()), some_state<double>(n));
}

TEST_CASE("Many vortices have the same bits by any number of threads, and the gradient of their energy") {
  const Threads back;
  for (const Eigen::Index n : {100, 300, 517}) {
    CAPTURE(n);
    Eigen::VectorXd gamma(n), x(n), y(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      gamma[i] = i % 2 == 0 ? 1 : -0.5;
      x[i] = 3 * std::sin(1.0 + double(i * i));
      y[i] = 3 * std::cos(2.0 + 1.7 * double(i * i));
    }
    const systems::PointVortices<double> vortices(gamma);
    const auto start = vortices.phase_point(x, y);
    set_threads(1);
    const auto expected = run(Semiexplicit(vortices, scheme), start, 1e-5, 2).first;
    const effects::vortices::Pairs pairs{effects::vortices::Circulations<double>(gamma)};
    Eigen::VectorXd by_q = Eigen::VectorXd::Zero(n), by_p = by_q, dHdq(n), dHdp(n);
    pairs.add_gradient(start.q(), start.p(), by_q, by_p);
    for (const int threads : {1, 2, 3}) {
      CAPTURE(threads);
      set_threads(threads);
      CHECK(same_bits(run(Semiexplicit(vortices, scheme), start, 1e-5, 2).first, expected));
      vortices.gradient(start.q(), start.p(), dHdq, dHdp);
      CHECK((dHdq - by_q).norm() <= 1e-11 * by_q.norm());
      CHECK((dHdp - by_p).norm() <= 1e-11 * by_p.norm());
    }
  }
}

TEST_CASE("The norm of a long vector is right, whatever its length and the number of threads") {
  const Threads back;
  for (const Eigen::Index n : {16'384, 16'385, 100'003, 300'000}) {
    Eigen::VectorXd v(n);
    long double sum = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      v[i] = std::sin(double(i)) * double(1 + i % 7);
      sum += static_cast<long double>(v[i]) * v[i];
    }
    set_threads(1);
    const double norm = detail::norm(v);
    CHECK(norm == Approx(double(std::sqrt(sum))).epsilon(1e-14));
    CHECK(detail::norm(v * 1e200) == Approx(norm * 1e200).epsilon(1e-14));
    for (const int threads : {2, 3, 7}) {
      set_threads(threads);
      CHECK(detail::norm(v) == norm);
    }
    // Of a pack, lane by lane; to rounding where the compiler contracts.
    std::vector<RegisterPack<double>> pack;
    for (Eigen::Index i = 0; i < n; ++i) pack.emplace_back(v[i]);
    CHECK(double(detail::norm(pack.data(), n)[0]) == Approx(norm).epsilon(4e-16));
  }
}

TEST_CASE("Parts of a loop begin at whole blocks and leave nothing out") {
  const Threads back;
  for (const int threads : {1, 2, 3, 8}) {
    set_threads(threads);
    for (const Eigen::Index n : {0, 1, 63, 64, 65, 1000}) {
      std::vector<int> seen(std::size_t(n), 0);
      in_parts(n, 64, 65, [&](Eigen::Index begin, Eigen::Index end) {
        if (begin % 64 != 0) throw std::logic_error("no block begins there");
        for (Eigen::Index i = begin; i < end; ++i) ++seen[std::size_t(i)];
      });
      CHECK(seen == std::vector<int>(std::size_t(n), 1));
    }
  }
}

TEST_CASE("Parts of a wave touch nothing that another part touches at the same time") {
  // Two copies of a phase point by tiles: stage 0 writes both, a kick reads one in three tiles and writes the
  // other, the last reads both.
  using Places = std::set<std::pair<int, Eigen::Index>>;
  struct Part {
    Places reads, writes;
  };
  for (const Eigen::Index stages : {5, 29})
    for (const int parts : {2, 3, 4}) {
      const Eigen::Index tiles = 2 * stages * parts + 1;
      std::vector<std::vector<int>> done(std::size_t(stages), std::vector<int>(std::size_t(tiles), 0));
      const auto record = [&](Part& part, Eigen::Index s, Eigen::Index b) {
        if (done[std::size_t(s)][std::size_t(b)]++ != 0) throw std::logic_error("done twice");
        const auto is_done = [&](Eigen::Index at) {
          return at < 0 || at >= tiles || done[std::size_t(s - 1)][std::size_t(at)] == 1;
        };
        if (s > 0 && !(is_done(b - 1) && is_done(b) && is_done(b + 1)) && s + 1 < stages)
          throw std::logic_error("too early");
        const int from = int((s + 1) % 2);
        if (s == 0) part.writes.insert({{0, b}, {1, b}});
        if (s == stages - 1) part.reads.insert({{0, b}, {1, b}});
        if (s == 0 || s == stages - 1) return;
        part.reads.insert({{from, b - 1}, {from, b}, {from, b + 1}});
        part.writes.insert({1 - from, b});
      };
      const auto no_conflict = [](const std::vector<Part>& all) {
        for (const Part& one : all)
          for (const Part& other : all)
            for (const auto& place : one.writes)
              if (&one != &other && (other.writes.contains(place) || other.reads.contains(place)))
                return false;
        return true;
      };
      const auto begin = [&](int part) { return tiles * part / parts; };
      std::vector<Part> first(std::size_t(parts), Part{}), second(std::size_t(parts - 1), Part{});
      for (int i = 0; i < parts; ++i)
        detail::wave(stages, begin(i), begin(i + 1), i > 0, i + 1 < parts,
                     [&](Eigen::Index s, Eigen::Index b) { record(first[std::size_t(i)], s, b); });
      for (int i = 0; i + 1 < parts; ++i)
        detail::fill_between(stages, begin(i + 1),
                             [&](Eigen::Index s, Eigen::Index b) { record(second[std::size_t(i)], s, b); });
      CAPTURE(stages, parts);
      CHECK(no_conflict(first));
      CHECK(no_conflict(second));
      for (const auto& stage : done) CHECK(stage == std::vector<int>(std::size_t(tiles), 1));
    }
}

TEST_CASE("Large members of an ensemble are as they are alone") {
  const Threads back;
  const Eigen::Index n = 20'000;
  const systems::NlsLattice<double> lattice(n);
  std::vector<Point<double>> starts(3, some_state<double>(n));
  for (int i = 0; i < 3; ++i) starts[std::size_t(i)].q()[i] = 0.7;
  Ensemble ensemble(RangesOf<double>{lattice}, starts, scheme);
  ensemble.run({.dt = 0.05, .steps = 2, .threads = 2});
  set_threads(3);
  for (int i = 0; i < 3; ++i)
    CHECK(same_bits(ensemble.state(i),
                    run(Semiexplicit(lattice, scheme), starts[std::size_t(i)], 0.05, 2).first));
}

}  // namespace test_threads
