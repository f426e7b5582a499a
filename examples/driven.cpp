// Kapitza's pendulum: a rigid one whose pivot shakes up and down, seen once a period of the shaking.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <iostream>
#include <numbers>
#include <stdexcept>
#include <string>

#include <CLI/CLI.hpp>
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

#include "common/arguments.hpp"
#include "common/output.hpp"
#include "common/prepare_outputs.hpp"

namespace {

using namespace semiexplicit;
using std::numbers::pi;

/// Lengths in units of the pendulum's, times in units of √(length/g). Of the angle θ from the lowest position
/// and its momentum p = θ' - aΩ sin(Ωt) sin θ, without what depends on the time only.
auto energy(double amplitude, double frequency) {
  return [=](const auto& t, const auto& q, const auto& p) {
    using std::cos, std::sin;
    const auto velocity = p[0] + amplitude * frequency * sin(frequency * t) * sin(q[0]);
    return velocity * velocity / 2 - cos(q[0]);
  };
}
auto pendulum(double amplitude, double frequency) {
  return Autonomous(from_energy<1>(energy(amplitude, frequency)));
}
/// The same of (θ, t) and (p, p_t), which has second derivatives.
auto extended_pendulum(double amplitude, double frequency) {
  return from_energy<2>(
      [own = energy(amplitude, frequency)](const auto& q, const auto& p) { return own(q[1], q, p) + p[1]; });
}
using Pendulum = decltype(pendulum(0, 0));

/// A step that failed, with the option that helps here.
std::runtime_error failed(const std::string& where, Status status) {
  const std::string why = describe(status);
  return std::runtime_error(where + ": " + why.substr(0, why.find(';')) + "; give more --steps");
}
template <class State, class... Observers>
void go(Semiexplicit<Pendulum>& stepper, State& Z, const IntegrationOptions<double>& options,
        Observers&... observers) {
  try {
    integrate(stepper, Z, options, observers...);
  } catch (const IntegrationError& error) {
    throw failed(examples::formatted("the step at t = %g", error.report().t), error.report().status);
  }
}

/// Half the trace of the derivative of the motion over a period, at the upper position: between -1 and 1 it
/// is stable.
double half_trace(double amplitude, double frequency, std::int64_t steps) {
  TangentMap tangent(Semiexplicit(extended_pendulum(amplitude, frequency), schemes::low_defect6_s13()));
  Eigen::Matrix2d product = Eigen::Matrix2d::Identity();
  const double dt = 2 * pi / frequency / static_cast<double>(steps);
  for (std::int64_t n = 0; n < steps; ++n) {
    // Not by a run, whose rounding would leave that position.
    const PhasePoint<double, 2> Z({pi, static_cast<double>(n) * dt}, {0, 0});
    const Status status = tangent.at(Z, dt);
    if (status != Status::success) throw failed("the tangent map", status);
    const auto& m =
        tangent.matrix();  // of (θ, t, p, p_t), where θ and p depend on the time, but it not on them
    const Eigen::Matrix2d block{{m(0, 0), m(0, 2)}, {m(2, 0), m(2, 2)}};
    product = block * product;
  }
  return product.trace() / 2;
}

/// Of half the trace, and of that by twice as many steps.
void report_stability(double half_trace, double finer, double amplitude, double frequency,
                      std::int64_t steps) {
  if (!std::isfinite(half_trace) || !std::isfinite(finer))
    throw std::runtime_error(
        "the motion about the upper position overflows in a period; give a larger --frequency");
  const auto stable = [](double half) { return std::abs(half) < 1; };
  const auto rate = [&](double half) {
    return (stable(half) ? std::acos(half) : std::acosh(std::abs(half))) * frequency / (2 * pi);
  };
  std::cout << "upside down: ";
  // Of half a radian, or of what grows like that, at the largest acceleration; four times as long ones do.
  const double needed = 4 * pi / frequency * std::sqrt(1 + amplitude * frequency * frequency);
  if (needed > 4 * static_cast<double>(steps))
    std::cout << "not to be told by such steps, give --steps of "
              << examples::formatted("%.0f", std::ceil(needed));
  else if (std::abs(std::abs(finer) - 1) < 1e-10)
    std::cout << "so slow beside the shaking that rounding hides it";
  else if (stable(half_trace) != stable(finer))
    std::cout << "too near to the threshold to be told by such steps, give more --steps";
  else
    std::cout << (stable(finer) ? "stable, swings at " : "unstable, parts at ")
              << examples::with_uncertainty(rate(finer),
                                            std::abs(rate(half_trace) - rate(finer)) +
                                                1e-14 * frequency / std::sqrt(std::abs(finer * finer - 1)));
  const double squared = amplitude * amplitude * frequency * frequency / 2 - 1;  // P. L. Kapitza (1951)
  if (amplitude <= 0.3 && frequency >= 5)
    std::cout << "; averaged over the shaking: " << (squared > 0 ? "stable, " : "unstable, ")
              << std::sqrt(std::abs(squared)) << '\n';
  else
    std::cout << "; no average over the shaking, which is for --amplitude up to 0.3 and --frequency from 5\n";
}

std::string script(const std::filesystem::path& png, const std::filesystem::path& csv, double amplitude,
                   double frequency, double fastest, const std::string& left_out, bool fine) {
  return examples::gnuplot_prologue(png, 1100, 900) + "set title 'A pendulum whose pivot shakes by " +
         examples::formatted("%g cos(%g t)", amplitude, frequency) + ": a point a period, a colour an orbit" +
         (fine ? "" : "; NO RESULT") +
         "'\nset xlabel 'angle from the lowest position, rad'\nset "
         "ylabel 'angular velocity, √(g/length)" +
         left_out +
         "'\nset "
         "xrange [-pi:pi]\nset yrange [-" +
         std::to_string(fastest) + ":" + std::to_string(fastest) +
         "]\nset key off\n"
         "set xtics ('-π' -pi, '-π/2' -pi/2, '0' 0, 'π/2' pi/2, 'π' pi)\nunset colorbox\nset cbrange "
         "[-0.5:*]\n"
         "set palette defined (0 '#0072B2', 1 '#009E73', 2 '#E69F00', 3 '#D55E00', 4 '#CC79A7')\n"
         "plot " +
         examples::quoted(csv.string()) +
         " using 2:3:1 skip 1 with points pointtype 7 pointsize 0.25 palette\n";
}

}  // namespace

int main(int argc, char** argv) {
  using namespace examples;
  CLI::App app{
      "Kapitza's pendulum, whose pivot shakes by a cos(Ωt): a section at every period of the shaking (g = "
      "length = 1)."};
  double amplitude = 0.2, frequency = 10;
  std::int64_t orbits = 40, periods = 1000, steps = 40;
  Settings settings;
  add_value(app, "--amplitude", amplitude, "of the shaking, in lengths of the pendulum", positive());
  add_value(app, "--frequency", frequency, "of the shaking, in units of that of small swings at rest",
            positive());
  add_value(app, "--orbits", orbits, "which start at rest, all around", whole_number(1, 10'000), "N");
  add_value(app, "--periods", periods, "of the shaking, for each of them", whole_number(1, 1'000'000'000),
            "N");
  add_value(app, "--steps", steps, "in a period", whole_number(4, 1'000'000), "N");
  add_output(app, settings, false);

  return run_program(app, argc, argv, [&] {
    const auto K = pendulum(amplitude, frequency);
    Semiexplicit stepper(K, schemes::low_defect6_s13());
    const double period = 2 * pi / frequency, dt = period / static_cast<double>(steps);
    report_stability(half_trace(amplitude, frequency, steps), half_trace(amplitude, frequency, 2 * steps),
                     amplitude, frequency, steps);

    const std::filesystem::path csv = settings.output / "driven.csv", png = settings.output / "driven.png";
    prepare_outputs(settings, {csv, png});
    CsvWriter writer(csv, {"orbit", "angle", "velocity"});
    double worst = 0;
    // What the picture shows: the islands would be lost beside the fastest of the chaotic orbits.
    const double fastest = 2 + amplitude * frequency;
    std::int64_t points = 0, faster = 0;
    for (std::int64_t k = 0; k < orbits; ++k) {
      // At whole periods the pivot rests, and the momentum is the angular velocity.
      const auto write = [&](double, const PhasePoint<double, 1>& z) {
        writer.row({static_cast<double>(k), std::remainder(z.q()[0], 2 * pi), z.p()[0]});
        ++points, faster += std::abs(z.p()[0]) > fastest;
      };
      auto section =
          poincare_section(K, [=](const auto& q, const auto&) { return std::sin(frequency * q[1] / 2); },
                           write, {.direction = CrossingDirection::both});
      const double angle = 2 * pi * (static_cast<double>(k) + 0.5) / static_cast<double>(orbits);
      auto Z = K.extended({angle, 0}, 0);
      Invariants invariants(K);
      go(stepper, Z, {.dt = dt, .steps = periods * steps + 1}, section, invariants);
      // Not relative to next to nothing, as near there.
      const auto& energy = invariants["energy"];
      const double error = energy.worst * energy.unit;
      if (!(error <= worst)) worst = error;  // a NaN is the worst
    }
    writer.commit();
    const bool fine = worst <= 0.01 * (1 + std::pow(amplitude * frequency, 2));
    std::cout << "energy with the work of the pivot, worst error, in units of mass g length: " << worst
              << '\n'
              << "section: " << csv.string() << '\n';
    const std::string left_out =
        faster == 0 ? ""
                    : "; " + std::to_string(faster) + " of " + std::to_string(points) + " points are faster";
    if (!settings.no_plot) draw(png, script(png, csv, amplitude, frequency, fastest, left_out, fine), {csv});
    if (!fine)
      std::cerr << "driven: the energy is off by more than a hundredth, the section means nothing; "
                   "give more "
                   "--steps\n";
    return fine ? 0 : 1;
  });
}
