// Steps that follow the motion against steps of one size, at equal gradient calls: for each problem and each
// bound on the error the fewest calls with which each way of stepping keeps below it. Numbers of calls, no
// times: any machine prints the same.
//
//     bench_reversible_steps [problem]      all, or the one with this in its name; `long`: over 1e5 periods

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <utility>
#include <vector>

#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
#include <boost/numeric/odeint/stepper/generation.hpp>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>
#endif

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "../../tests/kepler.hpp"

using namespace semiexplicit;

namespace {

constexpr double pi = std::numbers::pi;

/// What a run came to: its gradient calls and its errors, both relative.
struct Outcome {
  bool ok = false;
  double calls = 0, energy = 0, place = 0;
};

/// A way to run a problem, at a fineness from 0 on, each step of which takes a fifth more work.
struct Way {
  std::string name;
  int group;  ///< 0 our fixed steps, 1 Gauss's fixed steps, 2 reversible, 3 time-transformed, 4 from another
              ///< library
  std::function<Outcome(int fineness)> run;
};

double finer(int fineness) { return std::pow(1.2, -fineness); }

template <class H, class Monitor>
struct Problem {
  std::string name;
  H hamiltonian;
  Monitor monitor;
  PhasePoint<double, H::Dof> start;
  double end;
  double first_dt, first_ds;  ///< coarsest steps: of one size, and over the monitor function
  double most_calls;
  bool follows_place = true;  ///< else the orbits part too fast
  std::function<PhasePoint<double, H::Dof>()> exact = {};
};

template <class H>
class Judge {
 public:
  Judge(const H& hamiltonian, const PhasePoint<double, H::Dof>& start)
      : hamiltonian_(hamiltonian), first_(hamiltonian.energy(start.q(), start.p())) {}
  bool see(const PhasePoint<double, H::Dof>& z) {
    const double error = std::abs(hamiltonian_.energy(z.q(), z.p()) / first_ - 1);
    worst_ = std::max(worst_, std::isnan(error) ? std::numeric_limits<double>::infinity() : error);
    return worst_ < 1e-2;  // nothing better will come of it
  }
  double worst() const { return worst_; }

 private:
  const H& hamiltonian_;
  double first_, worst_ = 0;
};

template <class Point>
double distance(const Point& z, const Point& reference) {
  double apart = 0, size = 0;
  for (Eigen::Index i = 0; i < 2 * z.dof(); ++i) {
    apart += std::pow(z.vector()[i] - reference.vector()[i], 2);
    size += std::pow(reference.vector()[i], 2);
  }
  return std::sqrt(apart / size);
}

template <class H, class Monitor>
std::vector<Way> ways(const Problem<H, Monitor>& problem, const PhasePoint<double, H::Dof>& reference) {
  using Point = PhasePoint<double, H::Dof>;
  std::vector<Way> all;
  const auto run = [&problem, &reference](auto stepper, double dt) {
    Outcome outcome;
    Point z = problem.start;
    Judge<H> judge(problem.hamiltonian, z);
    const auto report = integrate(stepper, z, {.dt = dt, .on_failure = OnFailure::stop, .t_end = problem.end},
                                  [&](double, const Point& at, const IntegrationReport& so_far) {
                                    return judge.see(at) && double(so_far.gradients) < problem.most_calls;
                                  });
    outcome.ok = report.status == Status::success;
    outcome.calls = double(report.gradients);
    outcome.energy = judge.worst();
    outcome.place = distance(z, reference);
    return outcome;
  };
  const auto add = [&](const std::string& name, bool gauss, const auto& stepper) {
    all.push_back({name + ", fixed", gauss ? 1 : 0,
                   [=, &problem](int fineness) { return run(stepper, problem.first_dt * finer(fineness)); }});
    all.push_back({name + ", reversible", 2, [=, &problem](int fineness) {
                     return run(ReversibleSteps(stepper, problem.monitor),
                                problem.first_ds * finer(fineness));
                   }});
  };
  for (const char* scheme : {"low_defect4_s11", "low_defect6_s13", "low_defect8_s20"})
    add(std::string("semiexplicit ") + scheme, false,
        Semiexplicit(problem.hamiltonian, schemes::by_name<double>(scheme)));
  for (const int stages : {4, 6})
    add("gauss " + std::to_string(stages), true, GaussLegendre(problem.hamiltonian, {.stages = stages}));

  if constexpr (PositionMonitor<Monitor, double, H::Dof> || PhaseMonitor<Monitor, double, H::Dof>) {
    const auto transformed = [&problem, &reference](const auto& make, double ds) {
      Outcome outcome;
      const double energy = problem.hamiltonian.energy(problem.start.q(), problem.start.p());
      const TimeTransformed k(problem.hamiltonian, problem.monitor, energy);
      auto stepper = make(k);
      auto extended = k.extended(problem.start, 0.0);
      Judge<H> judge(problem.hamiltonian, problem.start);
      Point end = problem.start;
      auto output = at_times(
          k, {problem.end}, [&](double, const Point& z) { end = z; }, 8);
      const auto report = integrate(
          stepper, extended, {.dt = ds, .steps = std::int64_t{1} << 40, .on_failure = OnFailure::stop},
          output, [&](double, const auto& at, const IntegrationReport& so_far) {
            return judge.see(k.point(at)) && double(so_far.gradients) < problem.most_calls &&
                   output.served() == 0;
          });
      outcome.ok = report.ok() && output.served() == 1;
      outcome.calls = double(report.gradients);
      outcome.energy = judge.worst();
      outcome.place = distance(end, reference);
      return outcome;
    };
    all.push_back({"semiexplicit low_defect8_s20, time-transformed", 3, [=, &problem](int fineness) {
                     return transformed(
                         [](const auto& k) { return Semiexplicit(k, schemes::low_defect8_s20<double>()); },
                         problem.first_ds * finer(fineness));
                   }});
    all.push_back({"gauss 6, time-transformed", 3, [=, &problem](int fineness) {
                     return transformed([](const auto& k) { return GaussLegendre(k, {.stages = 6}); },
                                        problem.first_ds * finer(fineness));
                   }});
  }
#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
  all.push_back({"Boost.odeint, Fehlberg 7(8), adaptive", 4, [&](int fineness) {
                   using Z = std::vector<double>;
                   const double tolerance = 1e-4 * std::pow(0.3, fineness);
                   auto stepper = boost::numeric::odeint::make_controlled(
                       tolerance, tolerance, boost::numeric::odeint::runge_kutta_fehlberg78<Z>());
                   Point z = problem.start, gradient = z;
                   const Eigen::Index d = z.dof();
                   Outcome outcome;
                   const auto field = [&](const Z& at, Z& rate, double) {
                     ++outcome.calls;
                     Point here(d);
                     std::copy(at.begin(), at.end(), here.vector().data());
                     problem.hamiltonian.gradient(here.q(), here.p(), gradient.q(), gradient.p());
                     for (Eigen::Index i = 0; i < d; ++i) {
                       rate[std::size_t(i)] = gradient.p()[i];
                       rate[std::size_t(i + d)] = -gradient.q()[i];
                     }
                   };
                   Z numbers(z.vector().begin(), z.vector().end());
                   Judge<H> judge(problem.hamiltonian, z);
                   double t = 0, dt = problem.first_dt * 1e-3;
                   while (problem.end - t > 1e-14 * problem.end && outcome.calls < problem.most_calls) {
                     dt = std::min(dt, problem.end - t);
                     if (!(dt > 1e-15 * problem.end)) return outcome;
                     if (stepper.try_step(field, numbers, t, dt) != boost::numeric::odeint::success) continue;
                     std::copy(numbers.begin(), numbers.end(), z.vector().data());
                     if (!judge.see(z)) return outcome;
                   }
                   outcome.ok = problem.end - t <= 1e-14 * problem.end;
                   outcome.energy = judge.worst();
                   outcome.place = distance(z, reference);
                   return outcome;
                 }});
#endif
  return all;
}

template <class H, class Monitor>
void compare(const std::string& wanted, const Problem<H, Monitor>& problem) {
  if (problem.name.find(wanted) == std::string::npos) return;
  PhasePoint<double, H::Dof> reference = problem.start;
  double shortest = std::numeric_limits<double>::infinity(), longest = 0;
  ReversibleSteps fine(GaussLegendre(problem.hamiltonian, {.stages = 8}), problem.monitor);
  const auto steps = [&](double, const auto&, const IntegrationReport& report) {
    if (report.taken == 0) return;
    shortest = std::min(shortest, report.taken);
    longest = std::max(longest, report.taken);
  };
  // Of an orbit whose place is not asked for, the time scales alone.
  integrate(fine, reference,
            {.dt = problem.first_ds / (problem.follows_place ? 16 : 4), .t_end = problem.end}, steps);
  if (problem.exact) reference = problem.exact();

  const std::vector<Way> all = ways(problem, reference);
  struct Target {
    const char* what;
    bool place;
    double bound;
  };
  std::vector<Target> targets{{"energy", false, 1e-6}, {"energy", false, 1e-9}};
  if (problem.follows_place) {
    targets.push_back({"place", true, 1e-4});
    targets.push_back({"place", true, 1e-7});
  }
  constexpr double never = std::numeric_limits<double>::infinity();
  std::vector<std::vector<double>> fewest(all.size(), std::vector<double>(targets.size(), never));
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<Outcome> outcomes;
    for (int fineness = 0; fineness < 60; ++fineness) {
      outcomes.push_back(all[i].run(fineness));
      if (outcomes.back().calls >= problem.most_calls) break;
      // This and the next: no lucky one.
      if (outcomes.size() < 2) continue;
      bool done = true;
      for (std::size_t k = 0; k < targets.size(); ++k) {
        const auto meets = [&](const Outcome& o) {
          return o.ok && (targets[k].place ? o.place : o.energy) <= targets[k].bound;
        };
        const Outcome& before = outcomes[outcomes.size() - 2];
        if (meets(before) && meets(outcomes.back())) fewest[i][k] = std::min(fewest[i][k], before.calls);
        done = done && fewest[i][k] < never;
      }
      if (done) break;
    }
  }
  std::printf("\n## %s\n\nThe time scales differ by a factor %.0f.\n\n| way |", problem.name.c_str(),
              longest / shortest);
  for (const Target& target : targets) std::printf(" %s %.0e |", target.what, target.bound);
  std::printf("\n|---|");
  for (std::size_t k = 0; k < targets.size(); ++k) std::printf("---|");
  std::printf("\n");
  const auto print = [&](double calls) {
    if (calls < never)
      std::printf(" %.3g |", calls);
    else
      std::printf(" more than %.0e |", problem.most_calls);
  };
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::printf("| %s |", all[i].name.c_str());
    for (const double calls : fewest[i]) print(calls);
    std::printf("\n");
  }
  std::printf("| **best fixed semiexplicit over best reversible** |");
  for (std::size_t k = 0; k < targets.size(); ++k) {
    double best[5] = {never, never, never, never, never};
    for (std::size_t i = 0; i < all.size(); ++i)
      best[all[i].group] = std::min(best[all[i].group], fewest[i][k]);
    if (best[2] == never)
      std::printf(" |");
    else if (best[0] == never)
      std::printf(" above %.1f |", problem.most_calls / best[2]);
    else
      std::printf(" %.1f |", best[0] / best[2]);
  }
  std::printf("\n");
  std::fflush(stdout);
}

/// The apocentre.
PhasePoint<double, 2> apocentre(double e) { return {{-1 - e, 0}, {0, -std::sqrt((1 - e) / (1 + e))}}; }

void kepler(const std::string& wanted) {
  for (const double e : {0.9, 0.99, 0.999}) {
    char name[64];
    std::snprintf(name, sizeof name, "kepler, e = %g, ten periods", e);
    compare(wanted, Problem<Kepler, monitors::Distance>{.name = name,
                                                        .hamiltonian = {},
                                                        .monitor = {},
                                                        .start = apocentre(e),
                                                        .end = 20 * pi,
                                                        .first_dt = 0.5 * std::pow(1 - e, 0.75),
                                                        .first_ds = 0.9,
                                                        .most_calls = 2e6,
                                                        .exact = [e] { return apocentre(e); }});
  }
}

/// g = r^{3/2}.
struct ByRadius {
  double value(const auto& q, const auto&) const { return std::pow(q[1], 1.5); }
  double operator()(const auto& q, auto&& dgdq) const {
    dgdq.setZero();
    dgdq[1] = 1.5 * std::sqrt(q[1]);
    return value(q, q);
  }
};

void black_hole(const std::string& wanted) {
  const effects::black_hole::Kerr<> hole{.mass = 1, .spin = 0.9};
  const Scene scene(hole);
  compare(wanted, Problem<std::remove_const_t<decltype(scene)>, ByRadius>{
                      .name = "black hole, an orbit in the equator that zooms and whirls, to t = 2000",
                      .hamiltonian = scene,
                      .monitor = {},
                      .start = hole.body(20, pi / 2, 0, 0, 2.5),
                      .end = 2000,
                      .first_dt = 4,
                      .first_ds = 0.9,
                      .most_calls = 1e6});
}

void dipole(const std::string& wanted) {
  const effects::charges::MagneticKinetic motion(1.0, 1.0, effects::charges::DipoleField(1.0));
  const Scene scene(motion);
  const double v = 0.02, pitch = 12 * pi / 180;
  const Vector<double, 3> q(1, 0, 0), velocity(0, v * std::sin(pitch), v * std::cos(pitch));
  compare(wanted, Problem<std::remove_const_t<decltype(scene)>, monitors::Distance>{
                      .name = "dipole, a charge between its mirror points, to t = 300",
                      .hamiltonian = scene,
                      .monitor = {.power = 3},
                      .start = {q, motion.momentum(q, velocity)},
                      .end = 300,
                      .first_dt = 1,
                      .first_ds = 2.5,
                      .most_calls = 3e6});
}

/// g = (Σ (Γ/D²)²)^{-1/2} over the pairs, with the sum Γ of the sizes of their circulations: the fastest
/// pair's turn, about.
struct FastestPair {
  const systems::PointVortices<double>* vortices;
  double value(const In<double, Eigen::Dynamic>& q, const In<double, Eigen::Dynamic>& p) const {
    const Eigen::VectorXd x = vortices->x(q), y = vortices->y(p), size = vortices->circulations().cwiseAbs();
    double sum = 0;
    for (Eigen::Index j = 1; j < x.size(); ++j)
      for (Eigen::Index i = 0; i < j; ++i) {
        const double dx = x[i] - x[j], dy = y[i] - y[j], rate = (size[i] + size[j]) / (dx * dx + dy * dy);
        sum += rate * rate;
      }
    return 1 / std::sqrt(sum);
  }
};

void vortices(const std::string& wanted) {
  // A jittered grid, as in work_precision.
  const int count = 300, row = 20;
  Eigen::VectorXd circulations(count), x(count), y(count);
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int i = 0; i < count; ++i) {
    x[i] = i % row + 0.5 * (uniform() - 0.5);
    y[i] = i / row + 0.5 * (uniform() - 0.5);
    const double size = 0.5 + 0.5 * uniform();
    circulations[i] = uniform() < 0.5 ? -size : size;
  }
  const systems::PointVortices<double> h(circulations);
  compare(wanted,
          Problem<systems::PointVortices<double>, FastestPair>{.name = "vortices, 300 of them, to t = 10",
                                                               .hamiltonian = h,
                                                               .monitor = {&h},
                                                               .start = h.phase_point(x, y),
                                                               .end = 10,
                                                               .first_dt = 0.5,
                                                               .first_ds = 10,
                                                               .most_calls = 3e4,
                                                               .follows_place = false});
}

/// Whether the energy drifts: its mean over the first and the last thousand periods, and its worst.
void long_run() {
  std::printf(
      "\n## Kepler orbits over 1e5 periods\n\n| e | steps a period | mean error, the first 1000 periods | "
      "worst | "
      "shortest and longest step over g dt | mean error, the last 1000 | worst | shortest and longest |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const double e : {0.9, 0.99, 0.999}) {
    const double ds = e < 0.95 ? 0.2 : 0.12, end = 1e5 * 2 * pi, part = end / 100;
    struct Window {
      double sum = 0, worst = 0, least = 10, most = 0;
      std::int64_t count = 0;
    } first, last;
    // The rule of the solver is a budget of drift: 1e-16 a step, by default, would show.
    ReversibleSteps stepper(Semiexplicit(Kepler(), schemes::low_defect8_s20<double>(),
                                         SimplifiedNewton{.stop = StoppingRule::product(1e-22)}),
                            monitors::Distance{});
    PhasePoint<double, 2> z = apocentre(e);
    double density = 0;
    const auto see = [&](double t, const PhasePoint<double, 2>& at, const IntegrationReport& report) {
      const double before = density;
      density = std::pow(std::hypot(at.q()[0], at.q()[1]), -1.5);
      if (before == 0 || (t > part && t < end - part) || t > end - 1)
        return;  // nor the two steps that are cut
      Window& window = t < end / 2 ? first : last;
      const double error = Kepler().energy(at.q(), at.p()) / -0.5 - 1,
                   ratio = report.taken / ds * std::sqrt(before * density);
      window.sum += error;
      window.worst = std::max(window.worst, std::abs(error));
      window.least = std::min(window.least, ratio);
      window.most = std::max(window.most, ratio);
      ++window.count;
    };
    const auto report = integrate(stepper, z, {.dt = ds, .t_end = end}, see);
    std::printf("| %g | %.1f |", e, double(report.steps) / 1e5);
    for (const Window& window : {first, last})
      std::printf(" %.4e | %.3e | %.4f, %.4f |", window.sum / double(window.count), window.worst,
                  window.least, window.most);
    std::printf("\n");
    std::fflush(stdout);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::string wanted = count > 1 ? arguments[1] : "";
  kepler(wanted);
  black_hole(wanted);
  dipole(wanted);
  vortices(wanted);
  if (wanted.empty() || wanted == "long") long_run();
}
