// A forced oscillator, seen once a period of the force, beside the closed form.
#include <algorithm>
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

using namespace semiexplicit;

int main() {
  const double force = 0.7, driving = 2.1, pi = std::acos(-1.0);
  const Autonomous K(from_energy<1>([=](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return (p[0] * p[0] + q[0] * q[0]) / 2 - force * q[0] * cos(driving * t);
  }));

  // From rest, q(t) = F (cos Ωt - cos t)/(1 - Ω²).
  double worst = 0;
  auto section = poincare_section(
      K, [=](const auto& q, const auto&) { return std::sin(driving * q[1] / 2); },
      [&](double t, const PhasePoint<double, 1>& z) {
        const double exact = force * (std::cos(driving * t) - std::cos(t)) / (1 - driving * driving);
        worst = std::max(worst, std::abs(z.q()[0] - exact));
      },
      {.direction = CrossingDirection::both});

  Semiexplicit stepper(K, schemes::low_defect6_s13<double>());
  auto Z = K.extended({0, 0}, 0.0);
  Invariants invariants(K);
  integrate(stepper, Z, {.dt = 0.05, .steps = 2000}, section, invariants);

  const std::int64_t periods = static_cast<std::int64_t>(100 * driving / (2 * pi));
  std::cout << section.count() << " periods, worst error of q: " << worst << ", work done: " << -Z.p()[1]
            << ", error of K: " << invariants["energy"].worst << '\n';
  return section.count() == periods && worst < 1e-8 && invariants["energy"].worst < 1e-8 ? 0 : 1;
}
