// An electron in an undulator, and one in a pulse of light: fields of the library, and one of one's own from A(t, x) alone.
#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

using namespace semiexplicit;
namespace charges = effects::charges;

int main() {
  // Units m = c = e = 1, lengths in periods of the undulator; K = 1.5, gamma = 100.
  const double k = 2 * std::numbers::pi, strength = 1.5, gamma = 100, p = std::sqrt(gamma * gamma - 1);
  const charges::RelativisticKinetic motion(1.0, 1.0, 1.0, charges::UndulatorField(strength * k, k));
  const Scene scene(motion);
  auto stepper = stepper_for(scene);
  PhasePoint<double, 3> z({0, 0, 0}, motion.momentum(std::array{0.0, 0.0, 0.0}, std::array{0.0, 0.0, p}));
  const double t = 20;
  integrate(stepper, z, {.dt = 0.02, .t_end = t});
  const double slippage = t - z.q()[2], expected = t * (1 + strength * strength / 2) / (2 * gamma * gamma);
  std::cout << "undulator: behind light by " << slippage << ", textbook " << expected << '\n';

  // A pulse along z with a Gaussian shape, polarised along x. Potential and derivatives come from this one function.
  const charges::FieldFrom pulse([=](const auto& time, const auto& x) {
    using std::cos, std::exp;
    const auto phase = x[2] - time;
    const auto a = 2.0 * exp(-phase * phase / 8) * cos(3 * phase);
    return std::array{a, 0 * a, 0 * a};
  });
  const charges::RelativisticCharge electron(1.0, 1.0, 1.0, pulse);
  const Autonomous K(electron);
  auto driven = Semiexplicit(K, schemes::low_defect6_s13<double>());
  auto Z = K.extended({{0, 0, 20}, {0, 0, 0}}, 0.0);  // at rest, the pulse is behind it
  double fastest = 1;
  const auto watch = [&](double, const auto& now) {
    const auto at = K.point(now);
    fastest = std::max(fastest, electron.gamma(K.time(now), at.q(), at.p()));
  };
  integrate(driven, Z, {.dt = 0.05, .t_end = 80}, watch);
  const auto y = K.point(Z);
  // γ = 1 + a²/2 in the pulse, and rest behind it (Lawson and Woodward).
  std::cout << "pulse: gamma up to " << fastest << " (3 where |a| is 2), at the end "
            << electron.gamma(K.time(Z), y.q(), y.p()) << ", moved on by " << y.q()[2] - 20
            << ", energy less the work of the field " << K.energy(Z.q(), Z.p()) << '\n';
  return std::abs(slippage / expected - 1) < 1e-3 && std::abs(fastest - 3) < 0.01 ? 0 : 1;
}
