// A star with two planets: Kepler's motion of each is exact, their attraction is kicked, only relativity is doubled. And an
// effect of one's own: a companion far away, which pulls all of them apart.
#include <iostream>
#include <numbers>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
namespace nbody = effects::nbody;
namespace orbits = effects::orbits;

struct
    Tide {  // of a mass at a distance along z: ½ k Σ m (x² + y² - 2z²), k = GM/distance³, in Jacobi coordinates with μ for m
  using Acts = OnPosition<double, Eigen::Dynamic>;
  static constexpr const char* name = "tide";
  nbody::Bodies<double> bodies;
  double k = 0;
  Eigen::Index dof() const { return bodies.dof(); }
  double energy(const auto& q) const {
    double sum = 0;
    for (Eigen::Index i = 0; i < q.size(); ++i)
      sum += bodies.reduced(1 + i / 3) * k / 2 * q[i] * q[i] * (i % 3 == 2 ? -2 : 1);
    return sum;
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    for (Eigen::Index i = 0; i < q.size(); ++i)
      dHdq[i] += bodies.reduced(1 + i / 3) * k * q[i] * (i % 3 == 2 ? -2 : 1);
  }
};

int main() {
  const double gm = 4 * std::numbers::pi * std::numbers::pi;  // au, years, a star like the Sun
  const nbody::Bodies<double> bodies({gm, gm * 1e-5, gm * 1e-3});
  const auto inner = state_of(orbits::Elements<double>{.a = 0.4, .e = 0.2}, gm);
  const auto outer = state_of(orbits::Elements<double>{.a = 2, .e = 0.1, .inclination = 0.3}, gm);
  const auto start = bodies.jacobi({{0, 0, 0}, inner.q(), outer.q()}, {{0, 0, 0}, inner.p(), outer.p()});

  const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                    nbody::Interaction<double>{bodies},
                    nbody::EinsteinInfeldHoffmann<double>(bodies, 63241.077), Tide{bodies, 1e-6});
  auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
  std::cout << explain(stepper, start) << '\n';
  auto z = start;
  Invariants invariants(scene);
  integrate(stepper, z, {.dt = 0.02, .t_end = 1000}, invariants);
  const auto r = bodies.positions(z.q()), v = bodies.velocities(z.p());
  const auto orbit = orbits::elements_of<double>(r[1] - r[0], v[1] - v[0], gm);
  std::cout << "after 1000 years: energy error " << invariants["energy"].worst
            << ", eccentricity of the inner planet " << orbit.e << '\n';

  // Two planets that get too close are refused, and the state stays at the last good step.
  const nbody::Bodies<double> close({gm, gm * 1e-3, gm * 1e-3});
  const auto one = state_of(orbits::Elements<double>{.a = 1}, gm);
  const auto two = state_of(orbits::Elements<double>{.a = 1.1, .mean_anomaly = 0.6}, gm);
  auto y = close.jacobi({{0, 0, 0}, one.q(), two.q()}, {{0, 0, 0}, one.p(), two.p()});
  auto refused = stepper_for(Scene(nbody::Kinetic<double>{close}, nbody::Attraction<double>{close},
                                   nbody::Interaction<double>{close}),
                             exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
  const auto run = integrate(refused, y, {.dt = 0.02, .on_failure = OnFailure::stop, .t_end = 10});
  std::cout << "at t = " << run.t << ": " << describe(run.status) << '\n';
  return invariants["energy"].worst < 1e-9 && run.status == Status::close_encounter ? 0 : 1;
}
