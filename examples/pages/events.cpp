// A ball that bounces and loses a tenth of its speed each time: its bounces and tops, in order, and the end where it comes to rest.
#include <cmath>
#include <iostream>
#include <vector>

#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() {
  // H = p²/2 + q, let go at the height 1/2; the floor is at q = 0
  const auto H = from_energy<1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + q[0]; });
  using Ball = PhasePoint<double, 1>;

  const double kept = 0.9;
  std::vector<double> bounces, tops;
  auto watch =
      events(H,
             on_event([](const auto& q, const auto&) { return q[0]; },  // the floor, from above
                      [&](double t, Ball& z) {
                        bounces.push_back(t);
                        z.p()[0] *= -kept;
                        return z.p()[0] > 0.01;  // false: the run ends here
                      },
                      CrossingDirection::falling),
             on_event([](const auto&, const auto& p) { return p[0]; },  // the top: p falls through 0
                      [&](double, const Ball& z) { tops.push_back(z.q()[0]); }, CrossingDirection::falling));

  Semiexplicit stepper(H, schemes::low_defect6_s13<double>());
  Ball z(0.5, 0);
  const IntegrationReport run = integrate(stepper, z, {.dt = 0.05, .t_end = 100}, watch);

  // The flights take 2 · 0.9, 2 · 0.9², ...
  const double n = double(bounces.size()), expected = 1 + 2 * kept * (1 - std::pow(kept, n - 1)) / (1 - kept);
  std::cout << bounces.size() << " bounces, " << tops.size() << " tops, the last of height " << tops.back()
            << "\nat rest at t = " << run.t << ", off by " << std::abs(run.t - expected) << '\n';
  return run.status == Status::stopped && std::abs(run.t - expected) < 1e-10 ? 0 : 1;
}
