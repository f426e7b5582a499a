#pragma once

#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/derivatives.hpp>

#include "../../tests/late_wall.hpp"

namespace bench {

using namespace semiexplicit;

/// A question to cost_of_accuracy() at random, whose answer rests on a part of T: the calls do not suffice
/// for more.
struct Question {
  double T, target, min_gradients;
};

/// Where the orbit of z0 is, at times that rise: Gauss-Legendre with eight stages, by steps of at most dt.
template <class H>
auto by_small_steps(const H& h, const PhasePoint<double, H::Dof>& z0, double dt) {
  return [h, at = z0, before = 0.0, dt](double t) mutable {
    if (t > before) run(h, at, t - before, {.method = Setting::Method::gauss, .stages = 8, .dt = dt});
    before = std::max(t, before);
    return at;
  };
}

/// Calls use(H, z0, question, observable, exact) for so many of each of six kinds of systems, each written as
/// an energy only; exact(t) is where the orbit is. use.begin(name) comes before each kind.
template <class Use>
void for_each_forecast(int count, Use& use) {
  std::mt19937_64 random(20261129);
  const auto between = [&](double a, double b) {
    return std::uniform_real_distribution<double>(a, b)(random);
  };
  const auto power = [&](double a, double b) { return std::pow(10.0, between(a, b)); };
  const auto ask = [&] { return Question{power(3, 4), power(-8, -3), power(4.3, 6)}; };
  const auto each = [&](const std::string& name, const auto& make) {
    use.begin(name);
    for (int i = 0; i < count; ++i) make();
  };

  each("Henon and Heiles", [&] {
    const auto h = from_energy<2>([](const auto& q, const auto& p) {
      return (p[0] * p[0] + p[1] * p[1] + q[0] * q[0] + q[1] * q[1]) / 2 + q[0] * q[0] * q[1] -
             q[1] * q[1] * q[1] / 3;
    });
    const double size = between(0.05, 0.35);
    PhasePoint<double, 2> z0;
    for (double& x : z0.vector()) x = size * between(-1, 1);
    use(
        h, z0, ask(), [](const auto& q, const auto&) { return q[1]; }, by_small_steps(h, z0, 0.1));
  });
  each("chain of four, quartic", [&] {
    const auto h = from_energy<4>([beta = power(-3, -0.3)](const auto& q, const auto& p) {
      auto sum = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]) / 2;
      for (int i = 0; i <= 4; ++i) {
        const auto stretch = i == 0 ? q[0] : i == 4 ? -q[3] : q[i] - q[i - 1];
        sum += stretch * stretch / 2 + beta * stretch * stretch * stretch * stretch / 4;
      }
      return sum;
    });
    PhasePoint<double, 4> z0;
    for (int i = 0; i < 4; ++i) {
      z0.q()[i] = std::sin(0.2 * std::acos(-1.0) * (i + 1)) * between(0.8, 1.2);
      z0.p()[i] = 0.1 * between(-1, 1);
    }
    use(
        h, z0, ask(), [](const auto& q, const auto&) { return q[0] * q[0]; }, by_small_steps(h, z0, 0.1));
  });
  each("two pendula, coupled by their momenta", [&] {
    const auto h = from_energy<2>([g = between(0.2, 2), e = power(-4, -0.5)](const auto& q, const auto& p) {
      const auto turned = e * cos(q[0] - q[1]);
      return (p[0] * p[0] + p[1] * p[1] - 2 * p[0] * p[1] * turned) / 2 / (1 - turned * turned) - cos(q[0]) -
             g * cos(q[1]);
    });
    const PhasePoint<double, 2> z0({between(-2, 2), between(-2, 2)}, {between(-1, 1), between(-1, 1)});
    use(
        h, z0, ask(), [](const auto& q, const auto&) { return std::sin(q[0]); }, by_small_steps(h, z0, 0.05));
  });
  each("nonlinear Schroedinger trimer", [&] {
    const auto h = from_energy<3>([J = power(-3, 0)](const auto& q, const auto& p) {
      auto sum = -J * (q[0] * q[1] + p[0] * p[1] + q[1] * q[2] + p[1] * p[2]);
      for (int i = 0; i < 3; ++i) {
        const auto norm = q[i] * q[i] + p[i] * p[i];
        sum += norm * norm / 4 * (1 + 0.3 * i);
      }
      return sum;
    });
    PhasePoint<double, 3> z0;
    for (double& x : z0.vector()) x = between(-1, 1);
    use(
        h, z0, ask(), [](const auto& q, const auto& p) { return q[0] * q[0] + p[0] * p[0]; },
        by_small_steps(h, z0, 0.05));
  });
  each("three bodies, in a rotating frame", [&] {
    const auto h = from_energy<2>([m = power(-5, -1)](const auto& q, const auto& p) {
      using std::sqrt;
      const auto x = q[0] + m, y2 = q[1] * q[1];
      return (p[0] * p[0] + p[1] * p[1]) / 2 + q[1] * p[0] - q[0] * p[1] - (1 - m) / sqrt(x * x + y2) -
             m / sqrt((x - 1) * (x - 1) + y2 + 1e-3);
    });
    const double a = between(0.3, 0.7), e = between(0, 0.4);
    const PhasePoint<double, 2> z0({a * (1 - e), 0}, {0, std::sqrt((1 + e) / a / (1 - e))});
    use(
        h, z0, ask(), [](const auto& q, const auto&) { return q[0]; }, by_small_steps(h, z0, 0.01));
  });
  each("a wall that comes once, beside an oscillator", [&] {
    const double steep = power(0, 2), speed = power(-1, 0.5), rate = power(-0.3, 1.5), turn = between(0, 3);
    const Question asked = ask();
    const LateWall wall{.steep = steep,
                        .speed = speed,
                        .rate = rate,
                        .arrives = asked.T * between(0.05, 0.95),
                        .y = between(-1, 1),
                        .v = between(-1, 1),
                        .turn = turn};
    use(
        from_energy<2>(wall), wall.at(0), asked, [](const auto& q, const auto&) { return q[0]; },
        [wall](double t) { return wall.at(t); });
  });
}

}  // namespace bench
