// What a step costs beyond its kicks: the time of a step with one evaluation of f over the time of the same
// kicks written by hand, on plain arrays, with the same formula of the gradient. The two alternate in short
// batches, so that a busy machine disturbs both alike; the median and the quartiles of the ratios of the
// pairs are printed.
//
//     bench_overhead [rounds]  pinned to a core: taskset -c 1 bench_overhead; run.sh: compilers and options

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../batches.hpp"
#include "hamiltonians.hpp"

using namespace semiexplicit;
using bench::quantile;
using bench::seconds;

namespace {

/// Formula is what the kicks by hand call, on plain arrays.
template <class Formula>
struct OnArrays {
  void operator()(const double* q, const double* p, double* dHdq, double* dHdp, Eigen::Index) const {
    Formula::evaluate(q, p, dHdq, dHdp);
  }
};
/// A bundled system's own gradient.
template <class H>
struct Bundled {
  H hamiltonian;
  void operator()(const double* q, const double* p, double* dHdq, double* dHdp, Eigen::Index d) const {
    using Column = Vector<double, H::Dof>;
    Eigen::Map<Column> by_q(dHdq, d), by_p(dHdp, d);
    hamiltonian.gradient(Eigen::Map<const Column>(q, d), Eigen::Map<const Column>(p, d), by_q, by_p);
  }
};

/// All kicks of a step from z, and their mean: nothing but the arithmetic of the explicit map. Compilers make
/// one of several shapes of this code much faster, and not always the same one; the reference is the fastest.
template <class Gradient, int Dof>
class ByHand {
  static constexpr int Size = twice(Dof);
  static constexpr auto Length = std::size_t(Size == Eigen::Dynamic ? 1 : Size);
  using Storage = Vector<double, Size>;

 public:
  ByHand(const Gradient& gradient, const Scheme<double>& scheme, const PhasePoint<double, Dof>& z)
      : gradient_of_(gradient), scheme_(scheme), z_(z.vector()), a_(z_), b_(z_), gradient_(z_) {}

  /// With the copies in members.
  __attribute__((flatten, noinline)) void in_members(double dt) {
    step(dt, z_.data(), a_.data(), b_.data(), gradient_.data(), z_.size());
  }
  /// With the copies on the stack; only for a size that is a constant.
  __attribute__((flatten, noinline)) void on_stack(double dt) {
    double a[Length], b[Length], gradient[Length];
    step(dt, z_.data(), a, b, gradient, Size);
  }
  /// The same, free to be inlined into the caller's loop.
  __attribute__((flatten)) void inlined(double dt) {
    double a[Length], b[Length], gradient[Length];
    step(dt, z_.data(), a, b, gradient, Size);
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
    gradient_of_(from, from + d, gradient, gradient + d, d);
    for (Eigen::Index i = 0; i < d; ++i) to[i] += t * gradient[d + i];
    for (Eigen::Index i = 0; i < d; ++i) to[d + i] -= t * gradient[i];
  }

  Gradient gradient_of_;
  Scheme<double> scheme_;
  Storage z_, a_, b_, gradient_;
};

template <class H, class Gradient>
void compare(const std::string& name, const H& hamiltonian, const Gradient& gradient,
             const PhasePoint<double, H::Dof>& z0, double dt, int rounds) {
  const auto scheme = schemes::yoshida6<double>();
  ByHand<Gradient, H::Dof> hand(gradient, scheme, z0);
  // Every evaluation is accepted: what is compared is a step with one.
  const SimplifiedNewton once{.stop = StoppingRule::paper(1e300)};
  Semiexplicit plain(hamiltonian, scheme, once, Summation::plain), compensated(hamiltonian, scheme, once);
  auto z = z0, y = z0;

  const double trial = seconds(20, [&] { plain.step(z, dt); }) / 20;
  const int batch = std::max(1, static_cast<int>(1e-4 / trial));
  std::vector<double> by_hand[3], by_plain[3], by_compensated[3];
  for (int i = 0; i < rounds; ++i) {
    z = y = z0;
    double times[3] = {seconds(batch, [&] { hand.in_members(dt); }), 1e300, 1e300};
    if constexpr (H::Dof != Eigen::Dynamic) {
      times[1] = seconds(batch, [&] { hand.on_stack(dt); });
      times[2] = seconds(batch, [&] { hand.inlined(dt); });
    }
    const double one = seconds(batch, [&] { plain.step(z, dt); });
    const double other = seconds(batch, [&] { compensated.step(y, dt); });
    for (std::size_t shape = 0; shape < 3; ++shape) {
      by_hand[shape].push_back(times[shape] / batch);
      by_plain[shape].push_back(one / times[shape]);
      by_compensated[shape].push_back(other / times[shape]);
    }
  }
  // The shape with the fastest median is the reference in every round.
  std::size_t best = 0;
  for (std::size_t shape = 1; shape < 3; ++shape)
    if (quantile(by_hand[shape], 0.5) < quantile(by_hand[best], 0.5)) best = shape;
  std::printf("%-26s %9.1f", name.c_str(),
              1e9 * quantile(by_hand[best], 0.5) / static_cast<double>(scheme.kicks()));
  for (const auto* ratios : {&by_plain[best], &by_compensated[best]})
    std::printf("   %7.3f (%.3f to %.3f)", quantile(*ratios, 0.5), quantile(*ratios, 0.25),
                quantile(*ratios, 0.75));
  std::printf("\n");
  std::fflush(stdout);
}

template <class Formula, int Dof>
void written(const char* name, const PhasePoint<double, Dof>& z0, double dt, int rounds) {
  compare(name, bench::Written<Formula, Dof>(), OnArrays<Formula>(), z0, dt, rounds);
}
template <class H>
void bundled(const char* name, const H& hamiltonian, const PhasePoint<double, H::Dof>& z0, double dt,
             int rounds) {
  compare(std::string(name) + ", bundled", hamiltonian, Bundled<H>{hamiltonian}, z0, dt, rounds);
}

/// Time of a step per degree of freedom and kick, which should hardly grow with the size: all work is in
/// passes over vectors.
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
  std::printf("%-26s %9s   %-24s   %s\n", "yoshida6, 1 evaluation", "ns a kick", "plain / by hand (quart.)",
              "compensated / by hand (quart.)");
  const PhasePoint<double, 5> nls({3, .01, .01, .01, .01}, {1, 0, 0, 0, 0});
  const Vector<double, 10> x{3, -10, 6, 9, 0, 7, -8, 5, 9, 7}, y{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1};
  written<bench::ProductFormula, 1>("product (1)", {-3, 0}, 1e-3, rounds);
  written<bench::DoublePendulumFormula, 2>("double pendulum (2)", {{1, 0.5}, {0.1, 0}}, 1e-3, rounds);
  written<bench::KerrFormula, 4>("Kerr geodesic (4)", {{0, 10, 1.4, 0}, {-0.96, 0, 1, 3.2}}, 1e-3, rounds);
  written<bench::NlsFormula, 5>("NLS (5)", nls, 1e-3, rounds);
  written<bench::VorticesFormula, 10>("vortices (10)", {x, y}, 1e-3, rounds);

  bundled("product (1)", systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 1e-3, rounds);
  bundled("NLS (5)", systems::NlsLattice<double, 5>(), nls, 1e-3, rounds);
  const systems::PointVortices<double, 10> vortices(
      Vector<double, 10>{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6});
  bundled("vortices (10)", vortices, vortices.phase_point(x, y), 1e-3, rounds);
  PhasePoint<double, Eigen::Dynamic> lattice(1000);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (auto& value : lattice.vector()) value = normal(random);
  bundled("NLS (1000)", systems::NlsLattice<double>(1000), lattice, 1e-3, rounds);

  std::printf("\n");
  for (const Eigen::Index sites : {1'000, 10'000, 100'000, 1'000'000}) scale(sites);
}
