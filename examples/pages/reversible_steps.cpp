// A comet of eccentricity 0.99 by steps that follow it: a monitor function without derivatives, no energy, a hundred steps an orbit.
#include <algorithm>
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

using namespace semiexplicit;

struct Kepler {  // H = |p|²/2 - 1/|q|
  using Scalar = double;
  static constexpr int Dof = 2;
  double energy(In<double, 2> q, In<double, 2> p) const { return p.squaredNorm() / 2 - 1 / q.norm(); }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = q / std::pow(q.squaredNorm(), 1.5);
    dHdp = p;
  }
};

int main() {
  const double e = 0.99, period = 2 * std::acos(-1.0);
  const Kepler H;
  PhasePoint<double, 2> z({-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))});  // the apocentre

  ReversibleSteps stepper(Semiexplicit(H, schemes::low_defect8_s20<double>()),
                          [](const auto& q, const auto&) { return std::pow(q.squaredNorm(), 0.75); });
  double shortest = 1, longest = 0, worst = 0;
  Invariants invariants(H);
  auto pericentres = poincare_section(
      H, [](const auto& q, const auto& p) { return q.dot(p); },
      [&, n = 0](double t, const auto&) mutable {
        worst = std::max(worst, std::abs(t / period - n++ - 0.5));
      },
      {.nodes = 6});
  const IntegrationReport run =
      integrate(stepper, z, {.dt = 0.12, .t_end = 100 * period}, invariants, pericentres,
                [&](double, const auto&, const IntegrationReport& step) {
                  if (step.taken == 0) return;  // at the start
                  shortest = std::min(shortest, step.taken);
                  longest = std::max(longest, step.taken);
                });

  std::cout << "steps per orbit: " << double(run.steps) / 100
            << ", the longest over the shortest: " << longest / shortest
            << "\nworst energy error: " << invariants["energy"].worst
            << ", pericentres: " << pericentres.count() << ", their times are off by " << worst
            << " of a period\n";
  return invariants["energy"].worst < 1e-8 && pericentres.count() == 100 && worst < 1e-6 ? 0 : 1;
}
