// What Lyapunov exponents cost: the time of a step that is observed by LyapunovExponents over that of a plain
// one, for the NLS lattice and second derivatives from hessian_times, from dual numbers through the gradient,
// from differences of it, from an energy as sums of terms; and by the dense tangent map. Both kinds of runs
// alternate in batches; medians and quartiles of the ratios of the pairs are printed.
//
//     bench_chaos [rounds]          pin it to a core: taskset -c 1 bench_chaos

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "../../tests/lattice_energy.hpp"
#include "../batches.hpp"

using namespace semiexplicit;
using bench::quantile;

namespace {

constexpr int any = Eigen::Dynamic;
using Half = In<double, any>;
using Result = Out<double, any>;

/// The bundled lattice with nothing but its gradient.
struct GradientOnly {
  using Scalar = double;
  static constexpr int Dof = any;
  systems::NlsLattice<double> lattice;
  Eigen::Index dof() const { return lattice.dof(); }
  void gradient(const Half& q, const Half& p, Result dHdq, Result dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
  using RangeGradientOf = GradientOnly;
  void gradient_range(Eigen::Index begin, Eigen::Index end, const double* q, const double* p, double* dHdq,
                      double* dHdp) const {
    lattice.gradient_range(begin, end, q, p, dHdq, dHdp);
  }
};
/// The same with second derivatives times a vector, by hand.
struct WithProduct : GradientOnly {
  explicit WithProduct(const systems::NlsLattice<double>& of) : GradientOnly{of} {}
  using RangeGradientOf = WithProduct;
  void hessian_times(const Half& at_q, const Half& at_p, const Half& by_q, const Half& by_p, Result to_q,
                     Result to_p) const {
    times(at_q.data(), at_p.data(), by_q.data(), by_p.data(), to_q.data(), to_p.data());
  }

 private:
  /// In blocks: first the squares of each site and their derivatives, ψ² = u + iv, then the sums over
  /// neighbours.
  void times(const double* __restrict q, const double* __restrict p, const double* __restrict dq,
             const double* __restrict dp, double* __restrict hq, double* __restrict hp) const {
    constexpr Eigen::Index block = 128;
    double u[block + 2], v[block + 2], du[block + 2], dv[block + 2];
    for (Eigen::Index begin = 0; begin < dof(); begin += block) {
      const Eigen::Index size = std::min(block, dof() - begin), end = begin + size;
      u[0] = v[0] = du[0] = dv[0] = u[size + 1] = v[size + 1] = du[size + 1] = dv[size + 1] = 0;
      const Eigen::Index from = begin > 0 ? 0 : 1, to = end < dof() ? size + 2 : size + 1;
      for (Eigen::Index k = from; k < to; ++k) {
        const Eigen::Index i = begin + k - 1;
        u[k] = 2 * (q[i] * q[i] - p[i] * p[i]);
        v[k] = 4 * q[i] * p[i];
        du[k] = 4 * (q[i] * dq[i] - p[i] * dp[i]);
        dv[k] = 4 * (q[i] * dp[i] + p[i] * dq[i]);
      }
      for (Eigen::Index k = 0; k < size; ++k) {
        const Eigen::Index i = begin + k;
        const double us = u[k] + u[k + 2], vs = v[k] + v[k + 2], dus = du[k] + du[k + 2],
                     dvs = dv[k] + dv[k + 2];
        const double density = q[i] * q[i] + p[i] * p[i], change = 2 * (q[i] * dq[i] + p[i] * dp[i]);
        hq[i] = (density - us) * dq[i] + (change - dus) * q[i] - vs * dp[i] - dvs * p[i];
        hp[i] = (density + us) * dp[i] + (change + dus) * p[i] - vs * dq[i] - dvs * q[i];
      }
    }
  }
};

/// Exponents by the dense tangent map, which costs d³ a kick.
template <class H>
class DenseExponents {
 public:
  template <class Stepper>
  DenseExponents(const Stepper& stepper, Eigen::Index count)
      : map_(stepper), last_(stepper.dof()), frame_(Eigen::MatrixXd::Random(2 * stepper.dof(), count)) {}

  void operator()(double t, const PhasePoint<double, any>& z) {
    if (t > time_ + 1e-6) {
      if (map_.at(last_, t - time_) != Status::success) std::abort();
      frame_ = map_.matrix() * frame_;
      for (Eigen::Index j = 0; j < frame_.cols(); ++j) {
        for (Eigen::Index i = 0; i < j; ++i)
          frame_.col(j) -= frame_.col(i).dot(frame_.col(j)) * frame_.col(i);
        sum_ += std::log(frame_.col(j).norm());
        frame_.col(j).normalize();
      }
    }
    time_ = t;
    last_ = z;
  }

 private:
  TangentMap<H> map_;
  PhasePoint<double, any> last_;
  Eigen::MatrixXd frame_;
  double time_ = 0, sum_ = 0;
};

/// Of the processor: other programs on a busy machine do not count.
template <class Work>
double cpu_seconds(const Work& work) {
  const std::clock_t start = std::clock();
  work();
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

struct Ratio {
  double low, median, high;
};

/// Observed steps over plain ones, and how many of the latter fit into a batch.
template <class H, class MakeObserver>
Ratio ratio(const H& h, const MakeObserver& make, int plain_steps, int observed_steps, int rounds) {
  PhasePoint<double, any> start(h.dof());
  for (Eigen::Index i = 0; i < 2 * h.dof(); ++i)
    start.vector()[i] = 0.5 * std::sin(1.0 + static_cast<double>(i % 1000 * (i % 1000)));
  Semiexplicit stepper(h, schemes::low_defect6_s13());
  auto observer = make(stepper);
  constexpr double dt = 0.01;
  auto z = start, y = start;
  double t = 0;
  integrate(stepper, z, {.dt = dt, .steps = 1}, observer);  // finds its shifts, if any
  t += dt;
  std::vector<double> ratios;
  for (int i = 0; i < rounds; ++i) {
    const double plain = cpu_seconds([&] { integrate(stepper, y, {.dt = dt, .steps = plain_steps}); });
    const double observed =
        cpu_seconds([&] { integrate(stepper, z, {.dt = dt, .steps = observed_steps, .t0 = t}, observer); });
    t += dt * observed_steps;
    ratios.push_back(observed / observed_steps / (plain / plain_steps));
  }
  return {quantile(ratios, 0.25), quantile(ratios, 0.5), quantile(ratios, 0.75)};
}

void print(const Ratio& r) {
  const int digits = r.median < 100 ? 2 : 0;
  std::printf("  %9.*f (%.*f to %.*f)", digits, r.median, digits, r.low, digits, r.high);
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 40;
  if (rounds < 4) {
    std::fprintf(stderr, "bench_chaos: rounds must be 4 or more\n");
    return 2;
  }
  std::printf("Steps with exponents over plain steps, NLS lattice, low_defect6_s13; quartiles\n%6s %3s  %s\n",
              "d", "k",
              "hessian_times            dual numbers             differences              from_energy        "
              "      dense");
  for (const Eigen::Index count : {1, 10})
    for (const Eigen::Index d : {10, 100, 1000, 10000}) {
      const int steps = static_cast<int>(std::max<Eigen::Index>(2, 100'000 / d / (count + 1)));
      const auto exponents = [&](const auto& stepper) { return LyapunovExponents(stepper, count); };
      const systems::NlsLattice<double> lattice(d);
      std::printf("%6ld %3ld", static_cast<long>(d), static_cast<long>(count));
      print(ratio(WithProduct(lattice), exponents, 2 * steps, steps, rounds));
      print(ratio(lattice, exponents, 2 * steps, steps, rounds));
      print(ratio(GradientOnly{lattice}, exponents, 2 * steps, steps, rounds));
      print(ratio(from_energy(d, lattice_by_terms(d)), exponents, 2 * steps, steps, rounds));
      if (d <= 100) {
        const auto dense = [&](const auto& stepper) { return DenseExponents<GradientOnly>(stepper, count); };
        print(ratio(GradientOnly{lattice}, dense, d < 100 ? 2000 : 200, 1, d < 100 ? rounds : 4));
      }
      std::printf("\n");
      std::fflush(stdout);
    }
}
