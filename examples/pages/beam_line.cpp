// An electron of 1 GeV through thousands of cells of quadrupoles, with the path as the independent variable:
// a run ends at the edge of each magnet, and the next one takes its state.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

using namespace semiexplicit;
namespace charges = effects::charges;

int main() {
  // Units m = c = e = 1 and metres. A focusing magnet, a gap, a defocusing magnet, a gap.
  const double p = 1957, k = 2.4, magnet = 0.3, gap = 1.2;
  const auto quadrupole = [](double gradient) {
    return charges::ChargeAlongPath(1.0, 1.0, 1.0, charges::ReferenceLine<>{},
                                    charges::QuadrupoleField(gradient));
  };
  const auto through = [&](double gradient) {
    return Semiexplicit(Autonomous(quadrupole(gradient)), schemes::low_defect6_s13<double>());
  };
  auto focusing = through(k * p), defocusing = through(-k * p), drift = through(0);
  std::int64_t gradients = 0;
  const auto cell = [&](auto& Z) {
    const auto run = [&](auto& stepper, double length, int steps) {
      gradients += integrate(stepper, Z, {.dt = length / steps, .steps = steps}).gradients;
    };
    run(focusing, magnet, 2);
    run(drift, gap, 1);  // which one step does exactly
    run(defocusing, magnet, 2);
    run(drift, gap, 1);
  };
  const auto start = [&](double x, double px) {
    const auto line = quadrupole(0);
    const auto [s, z] =
        line.on_line({.t = 0, .q = {x, 0, 0}, .momentum = {px, 0, std::sqrt(p * p - px * px)}});
    return Autonomous(line).extended(z, s);
  };

  // Rays near the axis: the matrix of a cell by (x, px), and the advance of the phase.
  const double tiny = 1e-6;
  auto by_x = start(tiny, 0), by_p = start(0, tiny * p), axis = start(0, 0);
  for (auto* Z : {&by_x, &by_p, &axis}) cell(*Z);
  const double m11 = by_x.q()[0] / tiny, m21 = by_x.p()[0] / tiny, m12 = by_p.q()[0] / (tiny * p),
               m22 = by_p.p()[0] / (tiny * p);
  const double advance = std::acos((m11 + m22) / 2), sine = std::sin(advance);
  // The same by the textbook's matrices, for any momentum.
  const auto textbook = [&](double momentum) {
    const double root = std::sqrt(k * p / momentum), phi = root * magnet;
    const double c = std::cos(phi), s = std::sin(phi), ch = std::cosh(phi), sh = std::sinh(phi);
    const double a = gap * root;
    return std::acos(c * ch + a * (c * sh - s * ch) - a * a / 2 * s * sh);
  };
  std::cout << "advance of the phase a cell: " << advance << ", matrices: " << textbook(p) << '\n';

  // A ray 5 mm from the axis: its ellipse, and how far the wiggles put it behind the ray on the axis.
  const int cells = 10'000;
  auto Z = start(5e-3, 0);
  double least = 1e300, largest = 0, action = 0;
  gradients = 0;
  for (int i = 0; i < cells; ++i) {
    cell(Z);
    const double x = Z.q()[0], px = Z.p()[0];
    const double area = (m12 * px * px + (m11 - m22) * x * px - m21 * x * x) / sine;
    least = std::min(least, area);
    largest = std::max(largest, area);
    action += area / 2 / cells;
  }
  const double behind = Z.q()[2] / cells - axis.q()[2];
  // Both are derivatives of one function: l of p_l, and the phase of the action.
  const double expected = -action * (textbook(p * 1.0001) - textbook(p * 0.9999)) / (0.0002 * p);
  std::cout << "area of the ellipse in " << cells << " cells: " << least << " to " << largest << '\n'
            << "behind light a cell: " << axis.q()[2] << " on the axis, by the wiggles " << behind
            << " more\n"
            << "the action times the slope of the phase by the momentum: " << expected << '\n'
            << "gradient calls a cell: " << double(gradients) / cells << '\n';
  return std::abs(advance - textbook(p)) < 1e-6 && largest < least * 1.001 &&
                 std::abs(behind / expected - 1) < 1e-3
             ? 0
             : 1;
}
