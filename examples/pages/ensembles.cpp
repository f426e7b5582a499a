// Many members at once: with parameters of their own, each against a stepper alone; with starts of their own,
// one of which fails; and a single orbit by Gauss-Legendre with the stages in the lanes.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

template <class S>
struct Oscillator {  // (1 + q²)(p² + k q²)/2; S is double, or a pack of them
  using Scalar = S;
  static constexpr int Dof = 1;
  S k;
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + k * q[0] * q[0]) + k * q[0] * (q[0] * q[0] + 1.0);
    dHdp[0] = p[0] * (q[0] * q[0] + 1.0);
  }
};

struct Product {  // (q² + 1)(p² + 1)/2, with a gradient that only indexes its arguments
  using Scalar = double;
  static constexpr int Dof = 1;
  using PackGradientOf = Product;
  template <class Q, class D>
  void gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1.0);
    dHdp[0] = p[0] * (q[0] * q[0] + 1.0);
  }
};

int main() {
  constexpr int members = 21;
  Eigen::MatrixXd parameters(1, members);  // a column a member
  std::vector<PhasePoint<double, 1>> starts;
  for (int i = 0; i < members; ++i) {
    parameters(0, i) = 0.5 + 0.1 * i;
    starts.emplace_back(0.3, 0.1);
  }
  Ensemble ensemble([]<class S>(const S* k) { return Oscillator<S>{k[0]}; }, parameters, starts,
                    schemes::low_defect6_s13<double>());
  ensemble.run({.dt = 0.1, .steps = 200});

  double worst = 0;
  for (int i = 0; i < members; ++i) {
    Semiexplicit alone(Oscillator<double>{parameters(0, i)}, schemes::low_defect6_s13<double>());
    PhasePoint<double, 1> z(0.3, 0.1);
    integrate(alone, z, {.dt = 0.1, .steps = 200});
    worst = std::max(worst, (ensemble.state(i).vector() - z.vector()).norm());
  }
  std::cout << members << " members, largest difference from a run alone: " << worst << '\n';

  // One Hamiltonian, three starts: the second is too far out for this step, and the others are not affected.
  const std::vector<PhasePoint<double, 1>> places{{-3, 0}, {-300, 0}, {-2, 0}};
  Ensemble three(Product(), places, schemes::low_defect6_s13<double>());
  const EnsembleReport report = three.run({.dt = 0.05, .steps = 200});
  std::cout << report.failed << " failed: " << three.failure(1) << '\n';

  GaussLegendreLanes gauss(Product(), {.stages = 6});
  PhasePoint<double, 1> z(-3, 0);
  integrate(gauss, z, {.dt = 0.05, .steps = 200});
  const double difference = (z.vector() - three.state(0).vector()).norm();
  std::cout << "Gauss-Legendre in lanes against member 0: " << difference << '\n';

  return worst < 1e-12 && report.failed == 1 && three.report(2).ok() && difference < 1e-5 ? 0 : 1;
}
