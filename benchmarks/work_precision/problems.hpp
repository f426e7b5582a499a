#pragma once

#include <cmath>
#include <random>
#include <string>
#include <vector>

#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
#include <boost/math/special_functions/jacobi_elliptic.hpp>
#endif

#include <semiexplicit/systems.hpp>

#include "measure.hpp"
#include "systems.hpp"

namespace work_precision {

using namespace semiexplicit;

/// A problem, and what the scans have to know about its scales.
template <class H>
struct Problem {
  std::string name, title;
  H hamiltonian;
  PhasePoint<double, H::Dof> start;
  double end, short_end;
  double step_per_call;  ///< scans begin at about this much time a gradient call, where accuracy is lost
  double omega;          ///< of Tao's coupling: the paper's, or one that was seen to do
  double most_calls;     ///< gradient calls of a single run
  std::vector<Yardstick::Invariant> invariants;
  std::function<void(double, double*)> exact = {};  ///< the state at a time, in closed form
  bool is_long = false;                             ///< too long for a reference of the trajectory

  /// Largest entry of the initial state, which tolerances are relative to. (Eigen's own reductions make g++
  /// 12 warn.)
  double size() const {
    double largest = 0;
    for (const double x : start.vector()) largest = std::max(largest, std::abs(x));
    return largest;
  }
};

/// A function of (q, p) as one of 2d numbers.
template <int Dof, class F>
auto on_numbers(Eigen::Index dof, const F& f) {
  return [=](const double* z) {
    using Column = Eigen::Map<const Vector<double, Dof>>;
    return static_cast<double>(f(Column(z, dof), Column(z + dof, dof)));
  };
}

/// The start is a turning point, and the amplitude √(1 + q₀²) the frequency: see systems/product.hpp.
inline Problem<systems::Product<double>> product_problem() {
  Problem<systems::Product<double>> problem{.name = "product",
                                            .title = "H = (q² + 1)(p² + 1)/2",
                                            .hamiltonian = {},
                                            .start = {-3, 0},
                                            .end = 1000,
                                            .short_end = 20,
                                            .step_per_call = 0.05,
                                            .omega = 20,
                                            .most_calls = 5e6,
                                            .invariants = {}};
#ifdef SEMIEXPLICIT_BENCHMARK_BOOST
  problem.exact = [](double t, double* z) {
    const double frequency = std::sqrt(10.0), k = 3 / frequency;
    double cn = 0, dn = 0;
    const double sn = boost::math::jacobi_elliptic(k, frequency * t, &cn, &dn);
    z[0] = -3 * cn;
    z[1] = 3 * frequency * sn * dn / (z[0] * z[0] + 1);
  };
#endif
  return problem;
}

/// The initial data of Jayawardana and Ohsawa (2023).
inline auto nls5_problem() {
  using H = systems::NlsLattice<double, 5>;
  return Problem<H>{.name = "nls5",
                    .title = "NLS lattice, N = 5",
                    .hamiltonian = {},
                    .start = PhasePoint<double, 5>({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}),
                    .end = 1000,
                    .short_end = 2,
                    .step_per_call = 1.0 / 250,
                    .omega = 100,
                    .most_calls = 1.2e7,
                    .invariants = {{"mass", on_numbers<5>(5, H::mass)}}};
}

/// Five long waves of random phase on a constant: every site moves, and none is faster than the rest by
/// chance, as with uncorrelated random sites. The constant is unstable: from t = 2 on the mass gathers in
/// peaks (largest |ψ|² 2 at the start, 18 at the end), which is the regime that the lattice is studied for.
inline auto nls1000_problem(bool is_short) {
  using H = systems::NlsLattice<double>;
  const int sites = is_short ? 40 : 1000;
  PhasePoint<double, Eigen::Dynamic> start(sites);
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };  // the same everywhere
  const double pi = std::acos(-1.0);
  start.q().setConstant(1);
  for (int wave = 1; wave <= 5; ++wave) {
    const double phase = 2 * pi * uniform(), other_phase = 2 * pi * uniform();
    for (int i = 0; i < sites; ++i) {
      start.q()[i] += 0.15 * std::cos(2 * pi * wave * i / sites + phase);
      start.p()[i] += 0.15 * std::cos(2 * pi * wave * i / sites + other_phase);
    }
  }
  return Problem<H>{.name = "nls1000",
                    .title = "NLS lattice, N = 1000",
                    .hamiltonian = H(sites),
                    .start = start,
                    .end = 20,
                    .short_end = 2,
                    .step_per_call = 1.0 / 300,
                    .omega = 20,
                    .most_calls = 4e5,
                    .invariants = {{"mass", on_numbers<Eigen::Dynamic>(sites, H::mass)}}};
}

template <int N>
auto vortex_problem(std::string name, std::string title, const Vector<double, N>& circulations,
                    const Vector<double, N>& x, const Vector<double, N>& y) {
  using H = systems::PointVortices<double, N>;
  const H vortices(circulations);
  const auto invariant = [&](double (H::*value)(const typename H::Read&, const typename H::Read&) const) {
    return on_numbers<N>(vortices.dof(),
                         [=](const auto& q, const auto& p) { return (vortices.*value)(q, p); });
  };
  return Problem<H>{.name = std::move(name),
                    .title = std::move(title),
                    .hamiltonian = vortices,
                    .start = vortices.phase_point(x, y),
                    .end = 0,
                    .short_end = 0,
                    .step_per_call = 0,
                    .omega = 7,
                    .most_calls = 1e5,
                    .invariants = {{"linear_impulse_x", invariant(&H::linear_impulse_x)},
                                   {"linear_impulse_y", invariant(&H::linear_impulse_y)},
                                   {"angular_impulse", invariant(&H::angular_impulse)}}};
}

using Ten = Vector<double, 10>;

/// Both sets of Jayawardana and Ohsawa (2023), with the physical Hamiltonian.
inline auto vortices_problem() {
  auto problem =
      vortex_problem<10>("vortices10", "ten vortices", Ten{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6},
                         Ten{3, -10, 6, 9, 0, 7, -8, 5, 9, 7}, Ten{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1});
  problem.end = 1000;
  problem.short_end = 100;
  problem.step_per_call = 1;
  return problem;
}

inline auto disparate_vortices_problem() {
  auto problem = vortex_problem<10>("vortices10_disparate", "ten vortices, disparate circulations",
                                    Ten{-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8},
                                    Ten{.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4},
                                    Ten{5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4});
  problem.end = 100;
  problem.short_end = 1;
  problem.step_per_call = 0.02;
  problem.most_calls = 4e5;
  return problem;
}

/// A jittered grid: vortices fill the plane, and none starts so close to another that this pair decides about
/// the step.
inline auto vortices300_problem(bool is_short) {
  const int count = is_short ? 25 : 300, row = is_short ? 5 : 20;
  Vector<double, Eigen::Dynamic> circulations(count), x(count), y(count);
  std::mt19937 random(1);
  const auto uniform = [&] { return static_cast<double>(random()) / 4294967296.0; };
  for (int i = 0; i < count; ++i) {
    x[i] = i % row + 0.5 * (uniform() - 0.5);
    y[i] = i / row + 0.5 * (uniform() - 0.5);
    const double size = 0.5 + 0.5 * uniform();
    circulations[i] = uniform() < 0.5 ? -size : size;
  }
  auto problem = vortex_problem<Eigen::Dynamic>("vortices300", "300 vortices", circulations, x, y);
  problem.end = 10;
  problem.short_end = 1;
  problem.step_per_call = 0.1;
  problem.most_calls = 2e4;
  return problem;
}

/// A charge of speed 1 and gyration radius 0.3 to 0.4, caught between the throats.
inline auto bottle_problem() {
  const MagneticBottle bottle;
  PhasePoint<double, 3> start({1, 0, 0}, {0, 0, 0.9});
  start.p()[1] = 0.43 + 0.5 - 1.0 / 72;  // v_y + A_y
  return Problem<MagneticBottle>{
      .name = "magnetic_bottle",
      .title = "a charge in a magnetic bottle",
      .hamiltonian = bottle,
      .start = start,
      .end = 1000,
      .short_end = 20,
      .step_per_call = 0.03,
      .omega = 5,
      .most_calls = 1.2e7,
      .invariants = {{"angular_momentum", [](const double* z) { return z[0] * z[4] - z[1] * z[3]; }}}};
}

/// Spin 0.9, E = 0.95, L = 2.5: an inclined bound orbit, from a turning point of r in the equatorial plane
/// on. H = -1/2 gives p_u.
inline auto kerr_problem() {
  const KerrGeodesic kerr;
  PhasePoint<double, 2> start({7, 0}, {0, 0});
  const double without = kerr.energy(start.q(), start.p());
  start.p()[1] = std::sqrt((-0.5 - without) * 2) * start.q()[0];
  return Problem<KerrGeodesic>{
      .name = "kerr",
      .title = "a geodesic around a rotating black hole",
      .hamiltonian = kerr,
      .start = start,
      .end = 10000,
      .short_end = 200,
      .step_per_call = 3,
      .omega = 1,
      .most_calls = 2e6,
      .invariants = {{"carter_constant", [=](const double* z) { return kerr.carter(z); }}}};
}

}  // namespace work_precision
