// Geodesics of a metric of one's own, given by its components alone: a wormhole. And Kerr's, beside the one of the library.
#include <cmath>
#include <iostream>
#include <numbers>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
namespace geodesics = effects::geodesics;

struct Wormhole {  // ds² = -dt² + dl² + (b² + l²)(dθ² + sin²θ dφ²): l from -∞ to ∞, the throat at l = 0
  double b = 1;
  auto operator()(const auto& x) const {  // x = (t, l, θ, φ)
    using std::sin;
    geodesics::Components g(x);  // of g^{μν}, all zero
    const auto r2 = b * b + x[1] * x[1], s = sin(x[2]);
    g(0, 0) = -1;
    g(1, 1) = 1;
    g(2, 2) = 1 / r2;
    g(3, 3) = 1 / (r2 * s * s);
    return g;
  }
};

int main() {
  using std::numbers::pi;
  // Light from the other side: it passes the throat if its angular momentum is below bE, and turns back if it is above.
  const geodesics::Geodesic wormhole(Wormhole{});
  const Scene scene(wormhole);
  auto stepper = stepper_for(scene);
  for (const double l : {0.9, 1.1}) {
    const double r2 = 1 + 100.0;
    PhasePoint<double, 4> z({0, -10, pi / 2, 0}, {-1, std::sqrt(1 - l * l / r2), 0, l});
    integrate(stepper, z, {.dt = 0.05, .t_end = 40});
    std::cout << "light with L = " << l << "bE ends at l = " << z.q()[1]
              << ", H = " << scene.energy(z.q(), z.p()) << '\n';
  }

  // Kerr by hand and from its metric: the same orbit.
  const effects::black_hole::Kerr<double> by_hand{.mass = 1, .spin = 0.9};
  const geodesics::Geodesic from_metric(geodesics::KerrMetric<double>{.mass = 1, .spin = 0.9});
  PhasePoint<double, 4> y = by_hand.body(8, 1.3, 0, 1.5, 2.8), z = y;
  auto one = stepper_for(Scene(by_hand));
  auto other = stepper_for(Scene(from_metric));
  integrate(one, y, {.dt = 0.5, .steps = 200});
  integrate(other, z, {.dt = 0.5, .steps = 200});
  const double apart = (y.vector() - z.vector()).norm() / y.vector().norm();
  std::cout << "Kerr by hand and from its metric, after 100 M: " << (apart < 1e-11 ? "the same" : "apart")
            << '\n';
  return apart < 1e-11 ? 0 : 1;
}
