// What a gradient by from_energy() costs in terms of one written by hand: the bare gradient, and a whole
// step. The two alternate in short batches, so that a busy machine disturbs both alike; the ratio of each
// pair of batches is taken, and their median and quartiles are printed.
//
// The second table has large systems: what the gradient by terms, backwards and forwards takes, in terms of a
// plain loop by hand that the compiler vectorises. "/ product" is the second derivatives times a vector in
// terms of the gradient, "/ energy" the gradient in terms of the energy.
//
//     bench_autodiff [rounds]          pin it to a core: taskset -c 1 bench_autodiff

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../../tests/lattice_energy.hpp"
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

/// The energy of systems::NlsLattice, each of its products taken once: Σ ¼|ψ|⁴ - Re(ψ²conj(ψ')²).
constexpr auto lattice_by_sites = [](const auto& q, const auto& p) {
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

/// The gradient of the lattice as one would write it.
struct PlainLattice {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index n;

  Eigen::Index dof() const { return n; }
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    const double* const __restrict x = q.data(), * const __restrict y = p.data();
    double* const __restrict by_x = dHdq.data(), * const __restrict by_y = dHdp.data();
    const auto site = [&](Eigen::Index i, double u, double v) {
      const double density = x[i] * x[i] + y[i] * y[i];
      by_x[i] = (density - 2 * u) * x[i] - 4 * v * y[i];
      by_y[i] = (density + 2 * u) * y[i] - 4 * v * x[i];
    };
    const auto u = [&](Eigen::Index i) { return x[i] * x[i] - y[i] * y[i]; };
    const auto v = [&](Eigen::Index i) { return x[i] * y[i]; };
    site(0, u(1), v(1));
    for (Eigen::Index i = 1; i + 1 < n; ++i) site(i, u(i - 1) + u(i + 1), v(i - 1) + v(i + 1));
    site(n - 1, u(n - 2), v(n - 2));
  }
};

/// The gradient of vortices as one would write it: every pair twice, in a loop that vectorises.
struct PlainVortices {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::VectorXd gamma, x_per_q, y_per_p;

  Eigen::Index dof() const { return gamma.size(); }
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    const Eigen::Index n = dof();
    const double* const __restrict x = q.data(), * const __restrict y = p.data();
    const double* const __restrict sx = x_per_q.data(), * const __restrict sy = y_per_p.data();
    double* const __restrict by_x = dHdq.data(), * const __restrict by_y = dHdp.data();
    dHdq.setZero();
    dHdp.setZero();
    for (Eigen::Index j = 0; j < n; ++j) {
      const double xj = x[j] * sx[j], yj = y[j] * sy[j], strength = gamma[j];
      const auto add = [&](Eigen::Index begin, Eigen::Index end) {
        for (Eigen::Index i = begin; i < end; ++i) {
          const double dx = x[i] * sx[i] - xj, dy = y[i] * sy[i] - yj;
          const double weight = strength / (dx * dx + dy * dy);
          by_x[i] += dx * weight;
          by_y[i] += dy * weight;
        }
      };
      add(0, j);
      add(j + 1, n);
    }
    for (Eigen::Index i = 0; i < n; ++i) {
      by_x[i] *= -gamma[i] * sx[i] / (2 * std::numbers::pi);
      by_y[i] *= -gamma[i] * sy[i] / (2 * std::numbers::pi);
    }
  }
};

template <bool by_pairs>
auto vortex_energy(const PlainVortices& of) {
  return [=](const auto& q, const auto& p) {
    using std::log;
    const auto pair = [&](auto i, auto j) {
      const auto dx = q[i] * at(of.x_per_q, i) - q[j] * at(of.x_per_q, j);
      const auto dy = p[i] * at(of.y_per_p, i) - p[j] * at(of.y_per_p, j);
      return at(of.gamma, i) * at(of.gamma, j) * log(dx * dx + dy * dy);
    };
    if constexpr (by_pairs) {
      return sum_over_pairs(of.dof(), pair) / (-4 * std::numbers::pi);
    } else {
      typename std::decay_t<decltype(q)>::Scalar sum(0);
      for (Eigen::Index j = 1; j < of.dof(); ++j)
        for (Eigen::Index i = 0; i < j; ++i) sum += pair(i, j);
      return sum / (-4 * std::numbers::pi);
    }
  };
}

/// An energy in which all hangs together: cos of partial sums, Σ cos(Σ_{k ≤ i} q_k p_k) (1 + p_i²).
constexpr auto unstructured = [](const auto& q, const auto& p) {
  using std::cos;
  typename std::decay_t<decltype(q)>::Scalar sum(0), partial(0);
  for (Eigen::Index i = 0; i < q.size(); ++i) {
    partial += q[i] * p[i];
    sum += cos(partial) * (1 + p[i] * p[i]);
  }
  return sum;
};
struct PlainUnstructured {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index n;

  Eigen::Index dof() const { return n; }
  double energy(const In<double, Dof>& q, const In<double, Dof>& p) const { return unstructured(q, p); }
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    double partial = 0, later = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      partial += q[i] * p[i];
      dHdq[i] = partial;
    }
    for (Eigen::Index i = n; i-- > 0;) {
      const double weight = 1 + p[i] * p[i], at = dHdq[i];
      later -= std::sin(at) * weight;
      dHdq[i] = later * p[i];
      dHdp[i] = later * q[i] + 2 * p[i] * std::cos(at);
    }
  }
};

/// One derivative in each of the variables after the other's, eight at a time: what from_energy() did with
/// any energy once.
template <class Energy>
class Forwards {
 public:
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Forwards(Eigen::Index dof, Energy energy) : dof_(dof), energy_(std::move(energy)) {}
  Eigen::Index dof() const { return dof_; }
  void gradient(const In<double, Dof>& q, const In<double, Dof>& p, Out<double, Dof> dHdq,
                Out<double, Dof> dHdp) const {
    using Number = semiexplicit::detail::Dual<double, 8>;
    for (Eigen::Index begin = 0; begin < 2 * dof_; begin += 8) {
      const auto make = [begin](double value, Eigen::Index i) {
        return semiexplicit::detail::variable<double, 8>(value, i - begin);
      };
      const Number h =
          energy_(semiexplicit::detail::as_duals(q, 0, make), semiexplicit::detail::as_duals(p, dof_, make));
      for (Eigen::Index i = begin; i < std::min(begin + 8, 2 * dof_); ++i)
        (i < dof_ ? dHdq[i] : dHdp[i - dof_]) = h.derivative[i - begin];
    }
  }

 private:
  Eigen::Index dof_;
  Energy energy_;
};

PhasePoint<double, Eigen::Dynamic> random_point(Eigen::Index n) {
  PhasePoint<double, Eigen::Dynamic> z(n);
  std::mt19937_64 random(1);
  std::normal_distribution<double> normal;
  for (auto& value : z.vector()) value = normal(random);
  return z;
}

template <class Hand, class Other>
void compare_gradients(const char* name, const char* what, int rounds, const Hand& hand, const Other& other) {
  const auto z = random_point(hand.dof());
  Gradient hand_gradient(hand, z);
  Gradient other_gradient(other, z);
  other_gradient();
  compare(
      name, what, rounds, [&] { hand_gradient(); }, [&] { other_gradient(); });
}

void large_systems(int rounds) {
  for (const Eigen::Index n : {10, 100, 400}) {
    const std::string name = "NLS " + std::to_string(n);
    const PlainLattice hand{n};
    compare_gradients(name.c_str(), "forwards", std::min(rounds, 50), hand, Forwards(n, lattice_by_sites));
    compare_gradients(name.c_str(), "backwards", rounds, hand, from_energy(n, lattice_by_sites));
    const auto by_terms = from_energy(n, lattice_by_terms(n));
    compare_gradients(name.c_str(), "by terms", rounds, hand, by_terms);
    const auto z = random_point(n);
    auto product = z;
    Gradient gradient(by_terms, z);
    compare(
        name.c_str(), "/ product", rounds, [&] { gradient(); },
        [&] {
          by_terms.hessian_times(z.q(), z.p(), z.q(), z.p(), product.q(), product.p());
          asm volatile("" : : "r"(product.vector().data()) : "memory");
        });
  }
  PlainVortices vortices{random_point(100).vector(), {}, {}};
  vortices.x_per_q = vortices.gamma.cwiseAbs().cwiseSqrt().cwiseInverse();
  vortices.y_per_p = vortices.x_per_q.cwiseProduct(vortices.gamma.cwiseSign());
  const char* const name = "200 vortices";
  compare_gradients(name, "forwards", std::min(rounds, 10), vortices,
                    Forwards(200, vortex_energy<false>(vortices)));
  compare_gradients(name, "backwards", std::min(rounds, 100), vortices,
                    from_energy(200, vortex_energy<false>(vortices)));
  compare_gradients(name, "by pairs", rounds, vortices, from_energy(200, vortex_energy<true>(vortices)));
  for (const Eigen::Index n : {10, 100, 1000}) {
    const std::string any = "unstruct. " + std::to_string(n);
    const PlainUnstructured hand{n};
    compare_gradients(any.c_str(), "forwards", std::min(rounds, 20), hand, Forwards(n, unstructured));
    compare_gradients(any.c_str(), "backwards", rounds, hand, from_energy(n, unstructured));
    const auto z = random_point(n);
    Gradient backwards(from_energy(n, unstructured), z);
    compare(
        any.c_str(), "/ energy", rounds,
        [&] {
          const double h = hand.energy(z.q(), z.p());
          asm volatile("" : : "g"(&h) : "memory");
        },
        [&] { backwards(); });
  }
}

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

  compare("NLS 5", rounds, systems::NlsLattice<double, 5>(), from_energy<5>(lattice_by_sites),
          PhasePoint<double, 5>({3, .01, .01, .01, .01}, {1, 0, 0, 0, 0}), 1e-3);

  const Vector<double, 10> circulations{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6};
  const systems::PointVortices<double, 10> vortices(circulations);
  compare("ten vortices", rounds, vortices, from_energy<10>(VortexEnergy{circulations}),
          vortices.phase_point(Vector<double, 10>{3, -10, 6, 9, 0, 7, -8, 5, 9, 7},
                               Vector<double, 10>{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
          1e-2);

  compare("NLS 100", rounds, systems::NlsLattice<double>(100), from_energy(100, lattice_by_terms(100)),
          random_point(100), 1e-3);

  std::printf("\n");
  large_systems(rounds);
}
