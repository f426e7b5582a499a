// The order of a scheme, seen: after one period of H = (q² + 1)(p² + 1)/2 the state is back where it was.
#include <cmath>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

/// How far from (-3, 0) the state is after a period, in n steps. The period is 4 K(k)/√(1 + q₀²), k² = q₀²/(1
/// + q₀²).
double miss(const Scheme<double>& scheme, int n) {
  const double period = 4 * std::comp_ellint_1(3 / std::sqrt(10.0)) / std::sqrt(10.0);
  Semiexplicit stepper(systems::Product<>{}, scheme);
  const PhasePoint<double, 1> start(-3, 0);
  PhasePoint<double, 1> z = start;
  integrate(stepper, z, {.dt = period / n, .steps = n});
  return (z.vector() - start.vector()).norm();
}

int main() {
  // A list of one's own: the triple jump, from Strang. compose() finds its order.
  const double w = 1 / (2 - std::cbrt(2.0));
  const Scheme<double> jump = compose(schemes::strang<double>(), {w, 1 - 2 * w, w}, "my triple jump");

  bool all_right = jump.order == 4;
  for (const Scheme<double>& scheme : {schemes::strang<double>(), jump, schemes::blanes_moan4<double>(),
                                       schemes::low_defect6_s13<double>()}) {
    const double coarse = miss(scheme, 100), fine = miss(scheme, 200);
    const double order = std::log2(coarse / fine);
    std::cout << scheme.name << ": order " << scheme.order << ", seen " << order << ", " << scheme.kicks()
              << " gradient calls a step, error " << coarse << '\n';
    all_right = all_right && std::abs(order - scheme.order) < 0.3;
  }

  try {  // a list that is no palindrome is refused, with the place and the remedy
    Scheme<double>("crooked", 2, {0.4, 0.6}, {1});
    all_right = false;
  } catch (const std::invalid_argument& refusal) {
    std::cout << refusal.what() << '\n';
  }
  return all_right ? 0 : 1;
}
