// Error estimate: a companion with half the step goes along. Kepler's orbit, whose place is known
// in closed form.
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() {
  const auto H = from_energy<2>([](const auto& q, const auto& p) {
    using std::sqrt;
    return (p[0] * p[0] + p[1] * p[1]) / 2 - 1 / sqrt(q[0] * q[0] + q[1] * q[1]);
  });
  const double e = 0.5, periods = 50, period = 2 * std::acos(-1.0);
  const PhasePoint<double, 2> start({1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
  const auto pericentre = [](const auto& q, const auto& p) { return q[0] * p[0] + q[1] * p[1]; };

  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  double last = 0, of_companion = 0;  // the last passage of the pericentre
  auto passages = poincare_section(H, pericentre, [&](double t, const auto&) { last = t; }, {.nodes = 6});
  auto passages_there =
      poincare_section(H, pericentre, [&](double t, const auto&) { of_companion = t; }, {.nodes = 6});
  auto estimate = with_error_estimate(stepper, {}, passages_there);

  PhasePoint<double, 2> z = start;
  integrate(stepper, z, {.dt = 0.1, .t_end = (periods + 0.5) * period}, passages, estimate);

  const PhasePoint<double, 2> exact({-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))});  // the apocentre
  const double error = (z.vector() - exact.vector()).norm(), late = std::abs(last - periods * period);
  const auto of_place = estimate.error(), of_time = estimate.error_of(last, of_companion);
  if (!of_place || !of_time) return 1;  // the two have parted
  std::cout << "place: off by " << error << ", estimated " << *of_place << "\nlast pericentre at t = " << last
            << " +- " << *of_time << ", off by " << late << '\n';
  return error < 3 * *of_place && *of_place < 3 * error && late < 3 * *of_time && *of_time < 3 * late ? 0 : 1;
}
