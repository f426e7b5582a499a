#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <utility>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "../../tests/kepler.hpp"
#include "../cost/systems.hpp"

/// Cases that are hard for long runs of systems that are not separable. The tests run them for a while,
/// bench_stability for long and with every kind of method.
namespace stability {

using namespace semiexplicit;

/// One hard case, and the figure that it must hold.
template <class H>
struct Case {
  using Scalar = typename H::Scalar;
  using Point = PhasePoint<Scalar, H::Dof>;

  std::string name;
  std::string why;  ///< what is hard about it, and what the bound stands for
  H hamiltonian;
  Point start;
  double dt = 0;               ///< for the scheme low_defect6_s13
  double t_test = 0;           ///< how far the tests go
  double t_long = 0;           ///< how far the benchmark goes
  double energy_error = 0;     ///< the worst relative error allowed: of the energy,
  double invariant_error = 0;  ///< and of the other invariant, where there is one
  std::function<Scalar(const In<Scalar, H::Dof>&, const In<Scalar, H::Dof>&)> invariant{};
};

/// H = p²/2 + q⁴/4 - q²/2 + q²p²/5: a double well, of which the orbit comes back to the saddle again and
/// again.
struct DoubleWell {
  using Scalar = double;
  static constexpr int Dof = 1;
  double energy(In<double, 1> q, In<double, 1> p) const {
    const double qq = q[0] * q[0], pp = p[0] * p[0];
    return pp / 2 + qq * qq / 4 - qq / 2 + qq * pp / 5;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double qq = q[0] * q[0], pp = p[0] * p[0];
    dHdq[0] = q[0] * (qq - 1 + pp * 2 / 5);
    dHdp[0] = p[0] * (1 + qq * 2 / 5);
  }
};

using bench::DoublePendulum;

/// A lattice of `sites` whose amplitudes are random, of this size.
template <class Scalar = double>
PhasePoint<Scalar, Eigen::Dynamic> random_lattice(Eigen::Index sites, double amplitude) {
  PhasePoint<Scalar, Eigen::Dynamic> z(sites);
  std::mt19937_64 random(12345);
  // By hand: what the standard's distributions give is not the same everywhere.
  const auto uniform = [&] { return static_cast<double>(random() >> 11) / 4503599627370496.0 - 1; };
  for (Eigen::Index i = 0; i < 2 * sites; ++i) z.vector()[i] = static_cast<Scalar>(amplitude * uniform());
  return z;
}

/// Calls use(case) for each.
template <class Use>
void for_each_case(const Use& use) {
  using Ten = Vector<double, 10>;
  using Vortices = systems::PointVortices<double, 10>;
  const Vortices disparate(Ten{-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8});
  const auto impulse = [](const auto& vortices) {
    return [vortices](const auto& q, const auto& p) { return vortices.angular_impulse(q, p); };
  };
  use(Case<Vortices>{
      .name = "disparate vortices",
      .why = "circulations from 1.4 to 18.8 at distances from 1 to 12: chaotic, with close encounters",
      .hamiltonian = disparate,
      .start = disparate.phase_point(Ten{.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4},
                                     Ten{5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4}),
      .dt = 0.02,
      .t_test = 1000,
      .t_long = 1e5,
      .energy_error = 1e-6,
      .invariant_error = 1e-11,
      .invariant = impulse(disparate)});

  // The pair flies through a ring of others, a thousand times as far apart, at the speed Γ/(2πD) = 159.
  using Six = Vector<double, 6>;
  using SixVortices = systems::PointVortices<double, 6>;
  const SixVortices dipole(Six{1, -1, .8, 1.1, -.7, .9});
  use(Case<SixVortices>{
      .name = "vortex dipole, 1e-3",
      .why = "a pair a thousand times as close as the others: its gradient is a thousand times theirs",
      .hamiltonian = dipole,
      .start = dipole.phase_point(Six{-3, -3, 1, .4, -.8, -.5}, Six{.0005, -.0005, .9, -1.1, .7, -.8}),
      .dt = 1e-6,
      .t_test = 0.04,
      .t_long = 1,
      .energy_error = 1e-9,
      .invariant_error = 1e-11,
      .invariant = impulse(dipole)});

  using Lattice = systems::NlsLattice<double>;
  const auto mass = [](const auto& q, const auto& p) { return q.squaredNorm() + p.squaredNorm(); };
  const auto lattice = [&](const std::string& name, const std::string& why, Eigen::Index sites,
                           double amplitude, double dt, double t_test, double t_long, double bound) {
    use(Case<Lattice>{.name = name,
                      .why = why,
                      .hamiltonian = Lattice(sites),
                      .start = random_lattice(sites, amplitude),
                      .dt = dt,
                      .t_test = t_test,
                      .t_long = t_long,
                      .energy_error = bound,
                      .invariant_error = 1e-11,
                      .invariant = mass});
  };
  lattice("NLS, small amplitude", "nearly linear: what is not linear must not be lost in rounding", 16, 1e-3,
          0.1, 200, 1e5, 1e-9);
  lattice("NLS, amplitude one", "linear and nonlinear terms are of one size", 16, 1, 0.03, 200, 1e5, 1e-7);
  lattice("NLS, edge of convergence",
          "the step at which simplified Newton gives up now and then: it says so, the others go on", 16, 1,
          0.1, 200, 1e5, 1e-2);
  lattice("NLS, turbulent", "nonlinear frequencies a hundred times the linear ones, chaotic", 16, 10, 2.5e-4,
          1, 500, 1e-7);
  lattice("NLS, N = 1000, random",
          "every site another phase: nothing cancels, much is modulationally unstable", 1000, 1, 0.03, 10,
          500, 1e-7);

  use(Case<DoubleWell>{
      .name = "saddle",
      .why = "the orbit starts 1e-6 from an exponentially unstable equilibrium and comes back to it; its "
             "energy is -5e-13, and an error as large as that sends it into the other well",
      .hamiltonian = {},
      .start = {1e-6, 0},
      .dt = 0.04,
      .t_test = 1000,
      .t_long = 2e5,
      .energy_error = 0.9,
      .invariant_error = 0});
  use(Case<DoublePendulum>{
      .name = "chaotic double pendulum",
      .why = "nearby orbits part as exp(t/2); the kinetic energy is not a sum of squares",
      .hamiltonian = {},
      .start = {{1.8, 2.2}, {0, 0}},
      .dt = 0.05,
      .t_test = 500,
      .t_long = 1e5,
      .energy_error = 1e-4,
      .invariant_error = 0});

  // From the pericentre of an orbit of e = 0.99999, where the speed is 447 and the curvature 1e10.
  const double e = 0.99999;
  const TimeTransformed near(Kepler{}, monitors::Distance{}, -0.5);
  const PhasePoint<double, 2> pericentre({1 - e, 0}, {0, std::sqrt((1 + e) / (1 - e))});
  use(Case<std::remove_const_t<decltype(near)>>{
      .name = "near-singular start",
      .why = "Kepler from a pericentre of 1e-5 by the transformed time; the energy is a difference of two "
             "numbers 2e5 times "
             "its size",
      .hamiltonian = near,
      .start = near.extended(pericentre, 0.0),
      .dt = 0.05,
      .t_test = 200,
      .t_long = 2e4,
      .energy_error = 1e-6,
      .invariant_error = 1e-11,
      .invariant = [](const auto& q, const auto& p) { return q[0] * p[1] - q[1] * p[0]; }});

  using Single = systems::NlsLattice<float>;
  use(Case<Single>{.name = "single precision",
                   .why = "NLS in float: rounding is 1e-7, and the default rule is out of its reach",
                   .hamiltonian = Single(16),
                   .start = random_lattice<float>(16, 1),
                   .dt = 0.05,
                   .t_test = 200,
                   .t_long = 1e5,
                   .energy_error = 2e-4,
                   .invariant_error = 2e-4,
                   .invariant = mass});
}

/// The energy that a case speaks of: that of H, not of what a transformation of time makes of it.
template <class H, class Q, class P>
auto energy_of(const H& hamiltonian, const Q& q, const P& p) {
  if constexpr (requires { hamiltonian.hamiltonian(); })
    return hamiltonian.hamiltonian().energy(q.head(q.size() - 1), p.head(p.size() - 1));
  else
    return hamiltonian.energy(q, p);
}

}  // namespace stability
