// A comet of eccentricity 0.99: ten orbits in a thousand steps, and its place at given times by Kepler's
// equation.
#include <algorithm>
#include <cmath>
#include <iostream>
#include <vector>

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
  const double e = 0.99, pi = std::acos(-1.0);
  const PhasePoint<double, 2> pericentre({1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
  const Kepler H;

  const TimeTransformed K(H, monitors::Distance{.power = 1.5}, H.energy(pericentre.q(), pericentre.p()));
  Semiexplicit stepper(K, schemes::low_defect8_s20<double>());
  auto Z = K.extended(pericentre, 0.0);

  // The distance from the Sun at the times at which the eccentric anomaly is a quarter turn, half a turn, ...
  std::vector<double> times;
  for (int i = 0; i < 36; ++i) times.push_back(i * pi / 2 - e * std::sin(i * pi / 2));
  double worst = 0;
  auto distances = at_times(K, times, [&, i = 0](double, const PhasePoint<double, 2>& z) mutable {
    worst = std::max(worst, std::abs(z.q().norm() - (1 - e * std::cos(i++ * pi / 2))));
  });
  integrate(stepper, Z, {.dt = 0.11, .steps = 1000}, distances);

  const PhasePoint<double, 2> z = K.point(Z);
  const double energy_error = std::abs(H.energy(z.q(), z.p()) / -0.5 - 1);
  std::cout << "orbits: " << K.time(Z) / (2 * pi) << ", energy error: " << energy_error
            << ", worst error of the distances: " << worst << '\n';
  return distances.served() == times.size() && energy_error < 1e-9 && worst < 1e-6 ? 0 : 1;
}
