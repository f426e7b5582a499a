// What the projection costs beyond its kicks: the time of a step with one evaluation of f over the time of the same kicks
// written by hand, on plain arrays, with the same gradient. The two alternate in short batches, so that a busy machine
// disturbs both alike; the ratio of each pair of batches is taken, and their median and quartiles are printed.
//
//     bench_overhead [rounds]          pin it to a core: taskset -c 1 bench_overhead

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

#include "../batches.hpp"

using namespace semiexplicit;
using bench::quantile;
using bench::seconds;

namespace {

/// All kicks of a step from z, and their mean: nothing but the arithmetic of the explicit map, on arrays of a size that is a
/// constant where the problem's is. Compilers make one of two shapes of this code much faster, and not always the same one;
/// the reference is the faster.
template <class H>
class ByHand {
  static constexpr int Size = twice(H::Dof);
  using Storage = Vector<double, Size>;

 public:
  ByHand(const H& hamiltonian, const Scheme<double>& scheme, const PhasePoint<double, H::Dof>& z)
      : hamiltonian_(hamiltonian), scheme_(scheme), z_(z.vector()), a_(z_), b_(z_), gradient_(z_) {}

  /// With the copies in members.
  __attribute__((flatten, noinline)) void in_members(double dt) {
    step(dt, z_.data(), a_.data(), b_.data(), gradient_.data(), z_.size());
  }
  /// With the copies on the stack; only for a size that is a constant.
  __attribute__((flatten, noinline)) void on_stack(double dt) {
    constexpr int size = Size == Eigen::Dynamic ? 1 : Size;
    constexpr auto length = std::size_t(size);
    double a[length], b[length], gradient[length];
    step(dt, z_.data(), a, b, gradient, size);
  }
  /// The same, free to be inlined into the caller's loop.
  __attribute__((flatten)) void inlined(double dt) {
    constexpr int size = Size == Eigen::Dynamic ? 1 : Size;
    constexpr auto length = std::size_t(size);
    double a[length], b[length], gradient[length];
    step(dt, z_.data(), a, b, gradient, size);
  }

 private:
  void step(double dt, double* z, double* a, double* b, double* gradient, Eigen::Index size) const {
    for (Eigen::Index i = 0; i < size; ++i) a[i] = b[i] = z[i];
    const std::size_t n = scheme_.b.size();
    for (std::size_t i = 0; i < n; ++i) {
      kick(dt * scheme_.a[i], a, b, gradient, size / 2);
      kick(dt * scheme_.b[i], b, a, gradient, size / 2);
    }
    kick(dt * scheme_.a[n], a, b, gradient, size / 2);
    for (Eigen::Index i = 0; i < size; ++i) z[i] = (a[i] + b[i]) / 2;
  }
  void kick(double t, const double* from, double* to, double* gradient, Eigen::Index d) const {
    using Column = Vector<double, H::Dof>;
    hamiltonian_.gradient(Eigen::Map<const Column>(from, d), Eigen::Map<const Column>(from + d, d),
                          Eigen::Map<Column>(gradient, d), Eigen::Map<Column>(gradient + d, d));
    for (Eigen::Index i = 0; i < d; ++i) to[i] += t * gradient[d + i];
    for (Eigen::Index i = 0; i < d; ++i) to[d + i] -= t * gradient[i];
  }

  H hamiltonian_;
  Scheme<double> scheme_;
  Storage z_, a_, b_, gradient_;
};

template <class H>
void compare(const char* name, const H& hamiltonian, const PhasePoint<double, H::Dof>& z0, double dt,
             int rounds) {
  const auto scheme = schemes::yoshida6<double>();
  ByHand<H> hand(hamiltonian, scheme, z0);
  Semiexplicit library(hamiltonian, scheme);
  auto z = z0;
  std::int64_t evaluations = 0, steps = 0;
  const auto library_step = [&] { evaluations += library.step(z, dt).evaluations, ++steps; };

  const double trial = seconds(20, library_step) / 20;
  const int batch = std::max(1, static_cast<int>(2e-4 / trial));
  std::vector<std::vector<double>> by_hand(3), ratios(3);
  for (int i = 0; i < rounds; ++i) {
    by_hand[0].push_back(seconds(batch, [&] { hand.in_members(dt); }) / batch);
    if constexpr (H::Dof != Eigen::Dynamic) {
      by_hand[1].push_back(seconds(batch, [&] { hand.on_stack(dt); }) / batch);
      by_hand[2].push_back(seconds(batch, [&] { hand.inlined(dt); }) / batch);
    }
    const double by_library = seconds(batch, library_step) / batch;
    for (std::size_t shape = 0; shape < 3; ++shape)
      if (!by_hand[shape].empty()) ratios[shape].push_back(by_library / by_hand[shape].back());
  }
  // The shape with the fastest median is the reference in every round.
  std::size_t best = 0;
  for (std::size_t shape = 1; shape < 3; ++shape)
    if (!by_hand[shape].empty() && quantile(by_hand[shape], 0.5) < quantile(by_hand[best], 0.5)) best = shape;
  const double calls = static_cast<double>(scheme.kicks());
  std::printf("%-22s %9.1f %9.3f %8.3f %8.3f %12.3f\n", name, 1e9 * quantile(by_hand[best], 0.5) / calls,
              quantile(ratios[best], 0.5), quantile(ratios[best], 0.25), quantile(ratios[best], 0.75),
              static_cast<double>(evaluations) / static_cast<double>(steps));
}

/// Time of a step per degree of freedom and kick, which should hardly grow with the size: all work is in passes over vectors.
void scale(Eigen::Index sites) {
  PhasePoint<double, Eigen::Dynamic> z(sites);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (auto& value : z.vector()) value = normal(random);
  Semiexplicit stepper(systems::NlsLattice<double>(sites), schemes::yoshida6<double>());
  const int batch = static_cast<int>(std::max<Eigen::Index>(1, 100'000 / sites));
  std::vector<double> times;
  std::int64_t evaluations = 0, steps = 0;
  for (int i = 0; i < 11; ++i)
    times.push_back(seconds(batch, [&] { evaluations += stepper.step(z, 1e-4).evaluations, ++steps; }) /
                    batch);
  const double kicks = static_cast<double>(stepper.scheme().kicks()) * static_cast<double>(evaluations) /
                       static_cast<double>(steps);
  std::printf("NLS %-8ld %9.3f ns per degree of freedom and kick\n", static_cast<long>(sites),
              1e9 * quantile(times, 0.5) / (kicks * static_cast<double>(sites)));
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 400;
  if (rounds < 4) {
    std::fprintf(stderr, "bench_overhead: rounds must be 4 or more\n");
    return 2;
  }
  std::printf("%-22s %9s %9s %8s %8s %12s\n", "problem (yoshida6)", "ns/kick", "ratio", "1st qu.", "3rd qu.",
              "evaluations");

  compare("NLS 5", systems::NlsLattice<double, 5>(),
          PhasePoint<double, 5>({3, .01, .01, .01, .01}, {1, 0, 0, 0, 0}), 1e-3, rounds);

  PhasePoint<double, Eigen::Dynamic> lattice(1000);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (auto& value : lattice.vector()) value = normal(random);
  compare("NLS 1000", systems::NlsLattice<double>(1000), lattice, 1e-3, rounds);

  const systems::PointVortices<double, 10> vortices(
      Vector<double, 10>{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6});
  compare("ten vortices", vortices,
          vortices.phase_point(Vector<double, 10>{3, -10, 6, 9, 0, 7, -8, 5, 9, 7},
                               Vector<double, 10>{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
          1e-2, rounds);

  compare("one degree of freedom", systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 1e-3, rounds);

  std::printf("\n");
  for (const Eigen::Index sites : {1'000, 10'000, 100'000, 1'000'000}) scale(sites);
}
