// Needs the component openmp
// One large trajectory by several threads: a chain whose gradient comes in ranges, and bodies that all pull
// at each other, whose gradient takes threads by itself. The results have the same bits by any number of
// threads.
#include <cmath>
#include <iostream>

#include <omp.h>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
constexpr int Dynamic = Eigen::Dynamic;

struct Chain {  // Σ (qᵢ² + 1)(pᵢ² + 1)/2 + Σ (qᵢ - qᵢ₊₁)²/2
  using Scalar = double;
  static constexpr int Dof = Dynamic;
  Eigen::Index n;
  Eigen::Index dof() const { return n; }
  void gradient(In<double, Dynamic> q, In<double, Dynamic> p, Out<double, Dynamic> dHdq,
                Out<double, Dynamic> dHdp) const {
    gradient_range(0, n, q.data(), p.data(), dHdq.data(), dHdp.data());
  }

  using RangeGradientOf = Chain;  // the entries begin to end - 1, to dHdq[0], dHdp[0] and on
  void gradient_range(Eigen::Index begin, Eigen::Index end, const double* q, const double* p, double* dHdq,
                      double* dHdp) const {
    for (Eigen::Index i = begin; i < end; ++i) {
      double pull = 0;
      if (i > 0) pull += q[i] - q[i - 1];
      if (i + 1 < n) pull += q[i] - q[i + 1];
      dHdq[i - begin] = q[i] * (p[i] * p[i] + 1) + pull;
      dHdp[i - begin] = p[i] * (q[i] * q[i] + 1);
    }
  }
  Eigen::Index reach() const { return 1; }  // entry i reads q and p from i - 1 to i + 1
};

struct Bodies {  // (1 + Σ p²/2)(1 - Σ_{i<j} 1/√(1 + (qᵢ - qⱼ)²)/n)
  using Scalar = double;
  static constexpr int Dof = Dynamic;
  Eigen::Index n;
  Eigen::Index dof() const { return n; }
  void gradient(In<double, Dynamic> q, In<double, Dynamic> p, Out<double, Dynamic> dHdq,
                Out<double, Dynamic> dHdp) const {
    const double kinetic = 1 + p.squaredNorm() / 2;
    // In blocks of 64, from 256 bodies on by threads: a block needs no other one's results.
    in_parts(n, 64, 256, [&](Eigen::Index begin, Eigen::Index end) {
      for (Eigen::Index i = begin; i < end; ++i) {
        double pull = 0, potential = 0;
        for (Eigen::Index j = 0; j < n; ++j) {
          const double r = q[i] - q[j], inverse = j == i ? 0 : 1 / std::sqrt(1 + r * r);
          potential += inverse;
          pull += r * inverse * inverse * inverse;
        }
        dHdq[i] = kinetic * pull / static_cast<double>(n);
        dHdp[i] = potential;  // summed below
      }
    });
    const double sum = dHdp.sum();  // in one order
    dHdp = p * (1 - sum / (2 * static_cast<double>(n)));
  }
};

/// Where three steps lead by so many threads.
template <class H>
Vector<double, Dynamic> after_steps(const H& H_, int threads) {
  omp_set_num_threads(threads);
  PhasePoint<double, Dynamic> z(H_.dof());
  for (Eigen::Index i = 0; i < z.dof(); ++i) {
    z.q()[i] = std::sin(static_cast<double>(i));
    z.p()[i] = 0.1 * std::cos(static_cast<double>(i));
  }
  Semiexplicit stepper(H_, schemes::low_defect4_s7<double>());
  integrate(stepper, z, {.dt = 0.05, .steps = 3});
  return z.vector();
}

int main() {
  bool same = true;
  for (const int threads : {2, 3}) {
    same = same && after_steps(Chain{17'000}, threads) == after_steps(Chain{17'000}, 1);
    same = same && after_steps(Bodies{300}, threads) == after_steps(Bodies{300}, 1);
  }
  std::cout << (same ? "the same bits by 1, 2 and 3 threads\n" : "threads changed the result\n");
  return same ? 0 : 1;
}
