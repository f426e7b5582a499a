// A pendulum with friction and a motor, and a satellite in thin air: forces that no Hamiltonian has, and where
// the energy goes.
#include <cmath>
#include <iostream>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
namespace orbits = effects::orbits;

struct Pendulum {  // -cos q
  using Acts = OnPosition<double, 1>;
  static constexpr const char* name = "pendulum";
  double energy(const auto& q) const { return -std::cos(q[0]); }
  void add_gradient(const auto& q, auto& dHdq) const { dHdq[0] += std::sin(q[0]); }
};
struct Rotation {  // p²/2
  using Acts = OnMomentum<double, 1>;
  static constexpr const char* name = "rotation";
  double energy(const auto& p) const { return p[0] * p[0] / 2; }
  void add_gradient(const auto& p, auto& dHdp) const { dHdp[0] += p[0]; }
};
struct Friction {  // a force of one's own: no energy, only add_force
  using Acts = OnMotion<double, 1>;
  static constexpr const char* name = "friction";
  double k = 0.05;
  void add_force(const auto&, const auto& p, auto& force) const { force[0] -= k * p[0]; }
};
struct Motor {  // a torque that does not depend on where the pendulum is
  using Acts = OnMotion<double, 1>;
  static constexpr const char* name = "motor";
  double torque = 0.02;
  void add_force(const auto&, const auto&, auto& force) const { force[0] += torque; }
};

int main() {
  const Scene scene(Rotation{}, Pendulum{}, Friction{}, Motor{});
  static_assert(!scene.symplectic && !scene.separable);
  auto stepper = stepper_for(scene);
  std::cout << explain(stepper) << "\n\n";
  PhasePoint<double, 1> z(3, 0);
  Books books(scene);
  integrate(stepper, z, {.dt = 0.05, .t_end = 50}, books);
  std::cout << books << '\n';

  // A satellite in 200 km, with the Earth's oblateness: only the drag is doubled.
  const double gm = 398600.4418, radius = 6378.137;  // km, s
  const Scene satellite(orbits::Kinetic<double, 3>{}, orbits::Attraction<double, 3>{.gm = gm},
                        orbits::Oblateness<double, 3>{.gm = gm, .j2 = 1.08263e-3, .radius = radius},
                        orbits::Drag<double, 3>{.quadratic = 3e-9, .height = 40, .radius = radius + 200});
  auto exact = stepper_for(satellite, exactly<orbits::Kinetic<double, 3>, orbits::Attraction<double, 3>>());
  std::cout << explain(exact) << "\n\n";
  const double r = radius + 200, v = std::sqrt(gm / r);
  PhasePoint<double, 3> y({r, 0, 0}, {0, 0.6 * v, 0.8 * v});
  Books account(satellite);
  integrate(exact, y, {.dt = 60, .t_end = 86400}, account);
  std::cout << account << "height after a day: " << y.q().norm() - radius << " km\n";
  return std::abs(books.difference()) < 1e-8 && std::abs(account.difference()) < 1e-4 * -account.work("drag")
             ? 0
             : 1;
}
