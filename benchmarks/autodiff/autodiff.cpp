// What a gradient by from_energy() costs in terms of one written by hand: the bare gradient, and a whole step. The two alternate
// in short batches, so that a busy machine disturbs both alike; the ratio of each pair of batches is taken, and their
// median and quartiles are printed.
//
//     bench_autodiff [rounds]          pin it to a core: taskset -c 1 bench_autodiff

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <type_traits>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../batches.hpp"

using namespace semiexplicit;
using bench::quantile;
using bench::seconds;

namespace {

/// Times of two works in alternation: the median of the first in nanoseconds, and the quartiles of the ratio.
template <class First, class Second>
void compare(const char* name, const char* what, int rounds, const First& first, const Second& second) {
  const int batch = std::max(1, static_cast<int>(1e-4 * 20 / seconds(20, second)));
  std::vector<double> by_first, ratios;
  for (int i = 0; i < rounds; ++i) {
    by_first.push_back(seconds(batch, first) / batch);
    ratios.push_back(seconds(batch, second) / batch / by_first.back());
  }
  std::printf("%-14s %-9s %10.1f %8.2f %8.2f %8.2f\n", name, what, 1e9 * quantile(by_first, 0.5),
              quantile(ratios, 0.5), quantile(ratios, 0.25), quantile(ratios, 0.75));
}

/// A gradient call whose result somebody may have looked at.
template <class H>
class Gradient {
 public:
  Gradient(const H& hamiltonian, const PhasePoint<double, H::Dof>& z)
      : hamiltonian_(hamiltonian), z_(z), gradient_(z) {}
  void operator()() {
    hamiltonian_.gradient(z_.q(), z_.p(), gradient_.q(), gradient_.p());
    asm volatile("" : : "r"(this), "r"(gradient_.vector().data()), "r"(z_.vector().data()) : "memory");
  }

 private:
  H hamiltonian_;
  PhasePoint<double, H::Dof> z_, gradient_;
};

template <class Hand, class Automatic>
void compare(const char* name, int rounds, const Hand& hand, const Automatic& automatic,
             const PhasePoint<double, Hand::Dof>& z0, double dt) {
  Gradient hand_gradient(hand, z0);
  Gradient automatic_gradient(automatic, z0);
  compare(
      name, "gradient", rounds, [&] { hand_gradient(); }, [&] { automatic_gradient(); });
  Semiexplicit hand_stepper(hand, schemes::low_defect6_s13());
  Semiexplicit automatic_stepper(automatic, schemes::low_defect6_s13());
  auto z = z0, w = z0;
  compare(
      name, "step", rounds, [&] { hand_stepper.step(z, dt); }, [&] { automatic_stepper.step(w, dt); });
}

/// Σ ¼|ψ|⁴ - Re(ψ²conj(ψ')²), as in systems::NlsLattice.
constexpr auto lattice_energy = [](const auto& q, const auto& p) {
  using Number = typename std::decay_t<decltype(q)>::Scalar;
  Number sum(0), u(0), v(0);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    const Number x = q[i], y = p[i], xx = x * x, yy = y * y, density = xx + yy;
    const Number next_u = xx - yy, next_v = x * y;
    sum += density * density / 4 - u * next_u - 4 * v * next_v;
    u = next_u;
    v = next_v;
  }
  return sum;
};

struct VortexEnergy {
  Vector<double, 10> circulation;
  template <class Q, class P>
  typename Q::Scalar operator()(const Q& q, const P& p) const {
    using Number = typename Q::Scalar;
    using std::log;
    Number x[10], y[10], sum(0);
    for (int i = 0; i < 10; ++i) {
      const double scale = 1 / std::sqrt(std::abs(circulation[i]));
      x[i] = q[i] * scale;
      y[i] = p[i] * std::copysign(scale, circulation[i]);
    }
    for (int i = 0; i < 10; ++i)
      for (int j = 0; j < i; ++j) {
        const Number dx = x[i] - x[j], dy = y[i] - y[j];
        sum -= circulation[i] * circulation[j] * log(dx * dx + dy * dy);
      }
    return sum / (4 * std::numbers::pi);
  }
};

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 400;
  if (rounds < 4) {
    std::fprintf(stderr, "bench_autodiff: rounds must be 4 or more\n");
    return 2;
  }
  std::printf("%-14s %-9s %10s %8s %8s %8s\n", "problem", "what", "hand, ns", "ratio", "1st qu.", "3rd qu.");

  compare("product", rounds, systems::Product<double>(), from_energy<1>([](const auto& q, const auto& p) {
            return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2;
          }),
          PhasePoint<double, 1>(-3, 0), 0.01);

  namespace orbits = effects::orbits;
  const orbits::Kinetic<double, 2> kinetic{};
  const orbits::Attraction<double, 2> attraction{.gm = 1};
  const orbits::PostNewtonian1<double, 2> correction{.gm = 1, .c = 10, .nu = 0.25};
  compare(
      "1PN orbit", rounds, Scene(kinetic, attraction, correction),
      from_energy<2>([](const auto& q, const auto& p) {
        using std::sqrt;
        constexpr double c2 = 100, nu = 0.25;
        const auto square = p[0] * p[0] + p[1] * p[1], u = 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
        const auto s = (q[0] * p[0] + q[1] * p[1]) * u;
        return square / 2 - u +
               (-(1 - 3 * nu) / 8 * square * square - u * ((3 + nu) * square + nu * s * s) / 2 + u * u / 2) /
                   c2;
      }),
      PhasePoint<double, 2>({1, 0}, {0, 0.9}), 0.01);

  compare("NLS 5", rounds, systems::NlsLattice<double, 5>(), from_energy<5>(lattice_energy),
          PhasePoint<double, 5>({3, .01, .01, .01, .01}, {1, 0, 0, 0, 0}), 1e-3);

  const Vector<double, 10> circulations{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6};
  const systems::PointVortices<double, 10> vortices(circulations);
  compare("ten vortices", rounds, vortices, from_energy<10>(VortexEnergy{circulations}),
          vortices.phase_point(Vector<double, 10>{3, -10, 6, 9, 0, 7, -8, 5, 9, 7},
                               Vector<double, 10>{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
          1e-2);

  PhasePoint<double, Eigen::Dynamic> lattice(100);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (auto& value : lattice.vector()) value = normal(random);
  compare("NLS 100", rounds, systems::NlsLattice<double>(100), from_energy(100, lattice_energy), lattice,
          1e-3);
}
