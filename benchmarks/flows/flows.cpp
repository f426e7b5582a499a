// What an exact flow for the dominant effects saves: Mercury with relativity, where Kepler's motion is exact,
// and a star in a rotating bar, where free motion in the turning frame is. For each accuracy the fastest of
// the methods without exact flows is set against the fastest with them; the two then alternate, so that a
// busy machine disturbs both alike, and the median of the ratios of neighbouring runs and their quartiles are
// printed. Times are those of the processor, not of the clock.
//
//     bench_flows [rounds]          pin it to a core: taskset -c 1 bench_flows

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

#include "../batches.hpp"

using namespace semiexplicit;
using bench::quantile;
namespace orbits = effects::orbits;

namespace {

template <class Work>
double seconds(const Work& work) {
  const std::clock_t begin = std::clock();
  work();
  return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
}

/// What a run with so many steps came to: the errors, its work and its time.
struct Result {
  bool ok = false;
  std::vector<double> errors{};
  double gradients = 0, seconds = 0;
  std::int64_t steps = 0;
};

struct Method {
  std::string name;
  bool exact = false;
  std::function<Result(std::int64_t steps)> measured;  ///< with its errors
  std::function<void(std::int64_t steps)> run;         ///< nothing but the run
};

/// A problem: its methods, the numbers of steps to try, and what is asked for: an error (by its index) and
/// its bounds.
struct Problem {
  std::string name;
  std::vector<Method> methods{};
  std::vector<std::int64_t> steps{};
  struct Target {
    std::string what;
    std::size_t error;
    double bound;
  };
  std::vector<Target> targets{};
};

template <class Split>
bool runs(Split& stepper, PhasePoint<double, Split::Dof>& z, double t_end, std::int64_t steps,
          auto&... observers) {
  return integrate(stepper, z,
                   {.dt = t_end / static_cast<double>(steps), .steps = steps, .on_failure = OnFailure::stop},
                   observers...)
      .ok();
}

/// `errors(invariants, z)` judges the end of a run.
template <class S, class H, class Errors>
Method method(std::string name, bool exact, S stepper, const H& hamiltonian,
              const PhasePoint<double, H::Dof>& start, double t_end, Errors errors) {
  const auto measured = [stepper, hamiltonian, start, t_end, errors](std::int64_t steps) mutable {
    Result result{.steps = steps};
    PhasePoint<double, H::Dof> z = start;
    Invariants invariants(hamiltonian);
    const IntegrationReport report = integrate(
        stepper, z, {.dt = t_end / static_cast<double>(steps), .steps = steps, .on_failure = OnFailure::stop},
        invariants);
    result.ok = report.ok();
    result.gradients = static_cast<double>(report.gradients);
    if (result.ok) result.errors = errors(invariants, z);
    return result;
  };
  const auto run = [stepper, start, t_end](std::int64_t steps) mutable {
    PhasePoint<double, H::Dof> z = start;
    runs(stepper, z, t_end, steps);
  };
  return {std::move(name), exact, measured, run};
}

/// All methods of the library that hold for any Hamiltonian.
template <class H, class Errors>
void add_without(std::vector<Method>& methods, const H& hamiltonian, const PhasePoint<double, H::Dof>& start,
                 double t_end, const Errors& errors) {
  for (const char* name : {"low_defect4_s7", "low_defect4_s11", "blanes_moan6", "low_defect6_s13",
                           "low_defect6_s15", "kahan_li8", "low_defect8_s20", "sofroniou_spaletta10"})
    methods.push_back(method(std::string("semiexplicit ") + name, false,
                             Semiexplicit(hamiltonian, schemes::by_name<double>(name)), hamiltonian, start,
                             t_end, errors));
  for (const int stages : {4, 6, 8})
    methods.push_back(method("gauss " + std::to_string(stages), false,
                             GaussLegendre(hamiltonian, {.stages = stages}), hamiltonian, start, t_end,
                             errors));
  for (const char* name : {"blanes_moan6", "low_defect6_s13"})
    methods.push_back(method(std::string("midpoint ") + name, false,
                             MidpointProjection(hamiltonian, schemes::by_name<double>(name)), hamiltonian,
                             start, t_end, errors));
}

void compare(const Problem& problem, int rounds) {
  std::printf(
      "\n%s\n\n| error | bound | without: method | steps | gradients | ms | with: method | steps | gradients "
      "| "
      "ms | time ratio | quartiles | gradients ratio "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      problem.name.c_str());
  std::vector<std::vector<Result>> all;
  for (const Method& m : problem.methods) {
    all.emplace_back();
    for (const std::int64_t steps : problem.steps) all.back().push_back(m.measured(steps));
  }
  for (const Problem::Target& target : problem.targets) {
    struct Best {
      const Method* method = nullptr;
      Result result;
    } best[2];
    for (std::size_t i = 0; i < problem.methods.size(); ++i)
      for (Result& result : all[i]) {
        // This and the next two numbers of steps: no lucky one.
        const std::size_t at = static_cast<std::size_t>(&result - all[i].data());
        bool good = true;
        for (std::size_t k = at; k < std::min(at + 3, all[i].size()); ++k)
          good = good && all[i][k].ok && all[i][k].errors[target.error] <= target.bound;
        if (!good) continue;
        const Method& m = problem.methods[i];
        if (result.seconds == 0) {
          std::vector<double> times;
          for (int k = 0; k < 3; ++k) times.push_back(seconds([&] { m.run(result.steps); }));
          result.seconds = quantile(times, 0);
        }
        Best& b = best[m.exact ? 1 : 0];
        if (!b.method || result.seconds < b.result.seconds) b = {&m, result};
        break;  // the steps are in growing order
      }
    if (!best[0].method || !best[1].method) {
      std::printf("| %s | %.0e | %s | | | | %s |\n", target.what.c_str(), target.bound,
                  best[0].method ? best[0].method->name.c_str() : "not reached",
                  best[1].method ? best[1].method->name.c_str() : "not reached");
      continue;
    }
    std::vector<double> times[2], ratios;
    for (int k = 0; k < rounds; ++k) {
      for (int side = 0; side < 2; ++side)
        times[side].push_back(seconds([&] { best[side].method->run(best[side].result.steps); }));
      ratios.push_back(times[0].back() / times[1].back());
    }
    std::printf("| %s | %.0e |", target.what.c_str(), target.bound);
    for (int side = 0; side < 2; ++side)
      std::printf(" %s | %lld | %.3g | %.3g |", best[side].method->name.c_str(),
                  static_cast<long long>(best[side].result.steps), best[side].result.gradients,
                  1e3 * quantile(times[side], 0.5));
    std::printf(" %.1f | %.1f to %.1f | %.1f |\n", quantile(ratios, 0.5), quantile(ratios, 0.25),
                quantile(ratios, 0.75), best[0].result.gradients / best[1].result.gradients);
    std::fflush(stdout);
  }
}

/// The direction of the perihelion from the Runge-Lenz vector, radians.
double perihelion(const PhasePoint<double, 3>& z, double gm) {
  const auto q = z.q(), p = z.p();
  const double l = q[0] * p[1] - q[1] * p[0], r = std::hypot(q[0], q[1]);
  return std::atan2(-p[0] * l - gm * q[1] / r, p[1] * l - gm * q[0] / r);
}

Problem mercury() {
  const double gm = 4 * std::numbers::pi * std::numbers::pi, a = 0.38709893, e = 0.20563069, century = 100;
  const Scene scene(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                    orbits::PostNewtonian1<double, 3>{.gm = gm, .c = 63241.077});
  const PhasePoint<double, 3> start({a * (1 - e), 0, 0}, {0, std::sqrt(gm / a * (1 + e) / (1 - e)), 0});
  const double orbits_a_century = century / std::sqrt(a * a * a);
  constexpr auto kepler = exactly<orbits::Kinetic<double, 3>, orbits::Attraction<double, 3>>();

  PhasePoint<double, 3> end = start, check = start;
  auto fine = stepper_for(scene, kepler, schemes::aba1064<double>());
  runs(fine, end, century, 40'000);
  GaussLegendre gauss(scene, {.stages = 8});
  runs(gauss, check, century, 40'000);
  const double reference = perihelion(end, gm), arcsec = std::numbers::pi / 180 / 3600;
  std::printf("Mercury's perihelion after a century: %.6f arcsec; Gauss with 8 stages differs by %.1e\n",
              reference / arcsec, (perihelion(check, gm) - reference) / arcsec);

  const auto errors = [=](const auto& invariants, const PhasePoint<double, 3>& z) {
    return std::vector<double>{invariants["energy"].worst, std::abs(perihelion(z, gm) - reference) / arcsec};
  };
  Problem problem{.name = "Mercury with 1PN, a century",
                  .targets = {{"perihelion, arcsec", 1, 1e-2},
                              {"perihelion, arcsec", 1, 1e-4},
                              {"energy", 0, 1e-6},
                              {"energy", 0, 1e-8},
                              {"energy", 0, 1e-10},
                              {"energy", 0, 1e-12}}};
  add_without(problem.methods, scene, start, century, errors);
  for (const auto& list : {schemes::aba82<double>(), schemes::aba84<double>(), schemes::aba104<double>(),
                           schemes::aba864<double>(), schemes::aba1064<double>()})
    problem.methods.push_back(
        method("exact " + list.name, true, stepper_for(scene, kepler, list), scene, start, century, errors));
  for (const double an_orbit :
       {2.7, 3.3, 3.7, 4.2, 4.7, 5.3, 6.,  7.,  8.,  9.,  10.,  12.,  14.,  16.,  18.,  20.,  24.,
        28., 32., 36., 40., 48., 56., 64., 72., 80., 96., 112., 128., 160., 200., 256., 320., 400.})
    problem.steps.push_back(static_cast<std::int64_t>(std::ceil(an_orbit * orbits_a_century)));
  return problem;
}

/// The logarithmic potential of a bar, v₀²/2 ln(R² + x² + (y/q)²).
///
/// Source: J. Binney and S. Tremaine, Galactic Dynamics, 2nd ed., section 3.3.2.
struct Bar {
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "bar";
  double v = 1, radius = 0.2, flattening = 0.8;
  double energy(const auto& q) const { return v * v / 2 * std::log(inner(q)); }
  void add_gradient(const auto& q, auto& dHdq) const {
    const double factor = v * v / inner(q);
    dHdq[0] += factor * q[0];
    dHdq[1] += factor * q[1] / (flattening * flattening);
  }
  double inner(const auto& q) const {
    return radius * radius + q[0] * q[0] + q[1] * q[1] / (flattening * flattening);
  }
};

/// A potential in a turning frame: free motion is exact.
template <class Potential>
Problem in_turning_frame(std::string name, const Potential& potential, double omega,
                         const PhasePoint<double, 2>& start, double t_end) {
  const Scene scene(orbits::Kinetic<double, 2>{}, orbits::RotatingFrame<double, 2>{.omega = omega},
                    potential);
  constexpr auto frame = exactly<orbits::Kinetic<double, 2>, orbits::RotatingFrame<double, 2>>();
  const auto errors = [](const auto& invariants, const PhasePoint<double, 2>&) {
    return std::vector<double>{invariants["energy"].worst};
  };
  Problem problem{
      .name = std::move(name),
      .targets = {{"energy", 0, 1e-4}, {"energy", 0, 1e-6}, {"energy", 0, 1e-8}, {"energy", 0, 1e-10}}};
  add_without(problem.methods, scene, start, t_end, errors);
  for (const char* scheme :
       {"blanes_moan4", "blanes_moan6", "kahan_li8", "sofroniou_spaletta8", "sofroniou_spaletta10"})
    problem.methods.push_back(method(std::string("exact ") + scheme, true,
                                     stepper_for(scene, frame, schemes::by_name<double>(scheme)), scene,
                                     start, t_end, errors));
  problem.methods.push_back(method("exact blanes_moan_nystrom6", true,
                                   stepper_for(scene, frame, schemes::blanes_moan_nystrom6<double>()), scene,
                                   start, t_end, errors));
  for (double dt = 1; dt > 0.01; dt /= 1.12)
    problem.steps.push_back(static_cast<std::int64_t>(std::ceil(t_end / dt)));
  return problem;
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::atoi(argv[1]) : 31;
  compare(mercury(), rounds);
  compare(in_turning_frame("A star in a rotating bar, to t = 400", Bar{}, 0.9, {{0.6, 0}, {0, 0.5}}, 400),
          rounds);
  compare(in_turning_frame("Restricted three-body problem, about the larger mass, to t = 200",
                           orbits::TwoCentres<double, 2>::restricted(0.0121505856), 1, {{0.45, 0}, {0, 1.4}},
                           200),
          rounds);
}
