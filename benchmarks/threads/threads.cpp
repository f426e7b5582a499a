// One large trajectory by 1, 2, ... threads: the time of a step of Semiexplicit, beside that of one thread that kicks the whole system
// kick after kick. The contestants take turns in short windows and the best of each counts: what else the machine does comes out of
// the figures so far as it leaves some windows alone. The states at the end are compared bit for bit.
//
//     bench_threads [windows] [threads] [least] [most]
//
// 200 windows, all threads of OpenMP and systems of all sizes where nothing is given.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../batches.hpp"

using namespace semiexplicit;

namespace {

using Point = PhasePoint<double, Eigen::Dynamic>;

void set_threads([[maybe_unused]] int threads) {
#ifdef _OPENMP
  omp_set_num_threads(threads);
#endif
}

/// The lattice that does not say how far a site reaches, as it was before there were waves.
struct KickAfterKick : systems::NlsLattice<double> {
  explicit KickAfterKick(Eigen::Index sites) : NlsLattice(sites) {}
  using RangeGradientOf = KickAfterKick;
  void reach() const {}
};
static_assert(HasRangeGradient<KickAfterKick> && !HasLocalGradient<KickAfterKick>);

/// A stepper with its state, and the best time of a step.
template <class H>
struct Runner {
  Runner(const H& system, const Point& start, double of_dt, int of_threads)
      : stepper(system, schemes::low_defect6_s13<double>()), z(start), dt(of_dt), threads(of_threads) {}

  void window(int steps) {
    set_threads(threads);
    stepper.step(z, dt);  // wakes the threads
    const double time = bench::seconds(steps, [&] { stepper.step(z, dt); }) / steps;
    best = best == 0 ? time : std::min(best, time);
  }

  Semiexplicit<H> stepper;
  Point z;
  double dt;
  int threads;
  double best = 0;
};

/// A row of the table; false where the bits differ.
template <class H, class Before>
bool row(const char* name, const H& system, const Before& before, const Point& start, double dt, int windows,
         int most) {
  Runner<Before> reference(before, start, dt, 1);
  std::vector<Runner<H>> runners;
  for (int threads = 1; threads <= most; ++threads) runners.emplace_back(system, start, dt, threads);
  reference.window(1);
  const int steps = std::max(1, static_cast<int>(1e-3 / reference.best));  // in a window
  for (auto& runner : runners) runner.window(1);
  for (int i = 0; i < windows; ++i) {
    reference.window(steps);
    for (auto& runner : runners) runner.window(steps);
  }
  std::printf("| %s | %ld | %.1f |", name, static_cast<long>(start.dof()), 1e6 * reference.best);
  bool same = true;
  for (const auto& runner : runners) {
    std::printf(" %.2f |", reference.best / runner.best);
    same = same && runner.z.vector() == reference.z.vector();
  }
  std::printf(" %s |\n", same ? "yes" : "NO");
  std::fflush(stdout);
  return same;
}

}  // namespace

int main(int argc, char** argv) {
  int most = 1;
#ifdef _OPENMP
  most = omp_get_max_threads();
#endif
  const int windows = argc > 1 ? std::atoi(argv[1]) : 200;
  if (argc > 2) most = std::atoi(argv[2]);
  const Eigen::Index smallest = argc > 3 ? std::atol(argv[3]) : 0,
                     largest = argc > 4 ? std::atol(argv[4]) : 1 << 30;
  const auto wanted = [&](Eigen::Index n) { return n >= smallest && n <= largest; };
  if (windows < 1 || most < 1) {
    std::fprintf(stderr, "bench_threads: give how many windows to measure, and how many threads\n");
    return 2;
  }
  std::printf("| system | size | µs a step, kick after kick |");
  for (int threads = 1; threads <= most; ++threads)
    std::printf(" times as fast, %d thread%s |", threads, threads > 1 ? "s" : "");
  std::printf(" same bits |\n|---|---|---|");
  for (int threads = 0; threads <= most; ++threads) std::printf("---|");
  std::printf("\n");

  bool same = true;
  for (const Eigen::Index n : {1000, 4000, 8000, 16'000, 32'000, 100'000, 300'000, 1'000'000}) {
    if (!wanted(n)) continue;
    Point z(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      z.q()[i] = 0.3 * std::cos(static_cast<double>(i));
      z.p()[i] = 0.2 * std::sin(1 + 2 * static_cast<double>(i));
    }
    const systems::NlsLattice<double> lattice(n);
    same = row("NLS lattice", lattice, KickAfterKick(n), z, 0.05, windows, most) && same;
  }
  for (const Eigen::Index n : {64, 128, 256, 400, 1000}) {
    if (!wanted(n)) continue;
    Eigen::VectorXd gamma(n), x(n), y(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto number = static_cast<double>(i);
      gamma[i] = i % 2 == 0 ? 1 : -0.5;
      x[i] = 3 * std::sin(1 + number * number);
      y[i] = 3 * std::cos(2 + 1.7 * number * number);
    }
    const systems::PointVortices<double> vortices(gamma);
    same = row("vortices", vortices, vortices, vortices.phase_point(x, y), 1e-5, windows, most) && same;
  }
  return same ? 0 : 1;
}
