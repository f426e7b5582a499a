// One Strang step of the doubled system by hand and by Pihajoki; then how far the copies separate, free,
// coupled and projected.
#include <algorithm>
#include <iostream>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

/// to += t X(from), where X = (∂H/∂p, -∂H/∂q): the flow of one half of the doubled Hamiltonian.
void kick(const systems::Product<>& H, double t, const Point& from, Point& to) {
  Vector<double, 1> dHdq, dHdp;
  H.gradient(from.q(), from.p(), dHdq, dHdp);
  to.q() += t * dHdp;
  to.p() -= t * dHdq;
}

int main() {
  const systems::Product<> H;  // (q² + 1)(p² + 1)/2
  const Point start(-3, 0);
  const double dt = 0.01;

  Point a = start, b = start;  // a = (q, y), b = (x, p)
  kick(H, dt / 2, a, b);
  kick(H, dt, b, a);
  kick(H, dt / 2, a, b);

  ExtendedPoint<double, 1> zeta(start);
  Pihajoki free_map(H, schemes::strang<double>());
  free_map.step(zeta, dt);
  const double difference = (zeta.a.vector() - a.vector()).norm() + (zeta.b.vector() - b.vector()).norm();

  // The worst distance of the copies over 2000 steps; `defect` is an observer like any other.
  const auto worst_defect = [&](auto stepper) {
    ExtendedPoint<double, 1> copies(start);
    double worst = 0;
    const auto defect = [&](double, const auto& state) { worst = std::max(worst, state.defect()); };
    integrate(stepper, copies, {.dt = dt, .steps = 2000, .on_failure = OnFailure::stop}, defect);
    return worst;
  };
  const double apart = worst_defect(free_map);
  const double coupled = worst_defect(Tao(H, schemes::strang<double>(), 20.0));

  Point z = start;
  Semiexplicit projected(H, schemes::strang<double>());
  Invariants invariants(H);
  integrate(projected, z, {.dt = dt, .steps = 2000}, invariants);

  std::cout << "Pihajoki less by hand: " << difference << '\n'
            << "copies apart, free: " << apart << ", with Tao's coupling: " << coupled << '\n'
            << "projected: no copies between steps, energy error " << invariants["energy"].worst << '\n';
  return difference < 1e-13 && coupled < apart / 2 && invariants["energy"].worst < 1e-2 ? 0 : 1;
}
