// What lanes and threads are worth to an ensemble: the time of a step of a member in it, on one thread,
// beside that of the plain stepper, with and without the latter's own use of registers (HasLaneGradient,
// where the compiler's target has it); then the same ensemble on more threads. The contestants alternate in
// short batches, so that a busy machine disturbs all alike; the ratios are taken batch by batch, and their
// medians and quartiles printed.
//
//     bench_ensemble [rounds]          the lanes; pin it to a core: taskset -c 1 bench_ensemble
//     bench_ensemble [rounds] threads  the threads; not pinned, but held to their cores: OMP_PROC_BIND=true

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../batches.hpp"

using namespace semiexplicit;
using bench::quantile;
using bench::seconds;

namespace {

/// The same system without its gradient in registers.
template <class H>
struct Plain {
  using Scalar = double;
  static constexpr int Dof = H::Dof;
  H system;
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    system.gradient(q, p, dHdq, dHdp);
  }
};

void print_ratio(const char* what, const std::vector<double>& ratios) {
  std::printf("  %-38s %6.2f (quartiles %.2f, %.2f)\n", what, quantile(ratios, 0.5), quantile(ratios, 0.25),
              quantile(ratios, 0.75));
}

constexpr int members = 64;

template <int N>
std::vector<PhasePoint<double, N>> spread(const PhasePoint<double, N>& z, int count) {
  std::vector<PhasePoint<double, N>> starts(std::size_t(count), z);
  for (int i = 0; i < count; ++i) starts[std::size_t(i)].q()[0] *= 1 - 0.2 * i / count;
  return starts;
}

template <class H>
void compare(const char* name, const H& system, const PhasePoint<double, H::Dof>& z, double dt,
             const SimplifiedNewton& solver, int rounds) {
  const auto scheme = schemes::low_defect6_s13<double>();
  Ensemble ensemble(system, spread(z, members), scheme, solver);
  Semiexplicit plain(Plain<H>{system}, scheme, solver);
  Semiexplicit own(system, scheme, solver);
  auto plain_z = z, own_z = z;
  std::vector<double> times, against_plain, against_own;
  std::int64_t evaluations = 0, steps = 0, failed = 0;
  constexpr int batch = 64;
  for (int i = 0; i < rounds; ++i) {
    const double in_ensemble =
        seconds(1,
                [&] {
                  const auto run = ensemble.run({.dt = dt, .steps = batch, .threads = 1});
                  evaluations += run.evaluations, steps += run.steps, failed += run.failed;
                }) /
        (batch * members);
    const auto alone = [&](auto& stepper, auto& state) {
      return seconds(8 * batch, [&] { stepper.step(state, dt); }) / (8 * batch);
    };
    times.push_back(in_ensemble);
    against_plain.push_back(alone(plain, plain_z) / in_ensemble);
    against_own.push_back(alone(own, own_z) / in_ensemble);
  }
  std::printf(
      "%s: %.1f ns a member's step, %.2e member-steps a second, %.2f evaluations a step, %ld failed\n", name,
      1e9 * quantile(times, 0.5), 1 / quantile(times, 0.5),
      static_cast<double>(evaluations) / static_cast<double>(steps), static_cast<long>(failed));
  print_ratio("times the plain stepper", against_plain);
  if (HasLaneGradient<H>) print_ratio("times the stepper with lane gradient", against_own);
}

PhasePoint<double, 5> lattice_start() { return {{3, .01, .01, .01, .01}, {1, 0, 0, 0, 0}}; }

void compare_threads(int rounds) {
  Ensemble ensemble(systems::NlsLattice<double, 5>(), spread(lattice_start(), 4096),
                    schemes::low_defect6_s13<double>());
  const int most = detail::threads_meant(0);
  std::printf("NLS 5, 4096 members, %d threads at most\n", most);
  std::vector<std::vector<double>> times(std::size_t(most) + 1), gains(std::size_t(most) + 1);
  for (int i = 0; i < rounds; ++i)
    for (int threads = 1; threads <= most; ++threads) {
      const auto run = ensemble.run({.dt = 0.0125, .steps = 100, .threads = threads});
      times[std::size_t(threads)].push_back(run.seconds / static_cast<double>(run.steps));
      gains[std::size_t(threads)].push_back(times[1].back() / times[std::size_t(threads)].back());
    }
  for (int threads = 1; threads <= most; ++threads) {
    const auto at = std::size_t(threads);
    std::printf("  %d threads: %.2e member-steps a second, %.2f times one thread (quartiles %.2f, %.2f)\n",
                threads, 1 / quantile(times[at], 0.5), quantile(gains[at], 0.5), quantile(gains[at], 0.25),
                quantile(gains[at], 0.75));
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 100;
  if (rounds < 4 || argc > 3 || (argc == 3 && std::strcmp(argv[2], "threads") != 0)) {
    std::fprintf(stderr, "usage: bench_ensemble [rounds, 4 or more] [threads]\n");
    return 2;
  }
  if (argc == 3) {
    compare_threads(rounds);
    return 0;
  }
  std::printf("%d members a register\n", pack_width);
  const systems::NlsLattice<double, 5> lattice;
  compare("NLS 5, product rule", lattice, lattice_start(), 0.0125, {}, rounds);
  compare("NLS 5, paper's rule, 1e-13", lattice, lattice_start(), 0.0125,
          {.stop = StoppingRule::paper(1e-13)}, rounds);
  const systems::PointVortices<double, 4> four(Eigen::Vector4d::Ones());
  compare("four vortices", four, four.phase_point({1, -1, 0.3, 2}, {0, 0.5, 3, -1}), 0.1, {}, rounds);
  const systems::PointVortices<double, 10> ten(
      Vector<double, 10>{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6});
  compare("ten vortices", ten,
          ten.phase_point(Vector<double, 10>{3, -10, 6, 9, 0, 7, -8, 5, 9, 7},
                          Vector<double, 10>{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
          1, {}, rounds);
}
