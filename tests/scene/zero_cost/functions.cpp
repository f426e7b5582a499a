// The same gradients by hand and as scenes; check.cmake compares what the compiler makes of each pair.
#include <cmath>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;
using namespace semiexplicit::effects;
using Read = const In<double, 2>&;
using Write = Out<double, 2>;

struct Numbers {
  double gm, omega, c;
};

// Two effects: an orbit.
extern "C" void two_by_hand(const Numbers& n, Read q, Read p, Write dHdq, Write dHdp) {
  const double inverse2 = 1 / (q[0] * q[0] + q[1] * q[1]);
  const double factor = n.gm * inverse2 * std::sqrt(inverse2);
  const double dq0 = factor * q[0], dq1 = factor * q[1], dp0 = p[0], dp1 = p[1];
  dHdq[0] = dq0;
  dHdq[1] = dq1;
  dHdp[0] = dp0;
  dHdp[1] = dp1;
}
extern "C" void two_in_scene(const Numbers& n, Read q, Read p, Write dHdq, Write dHdp) {
  Scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = n.gm}).gradient(q, p, dHdq, dHdp);
}

// Three: the same in a frame that turns.
extern "C" void three_by_hand(const Numbers& n, Read q, Read p, Write dHdq, Write dHdp) {
  const double inverse2 = 1 / (q[0] * q[0] + q[1] * q[1]);
  const double factor = n.gm * inverse2 * std::sqrt(inverse2);
  const double dq0 = factor * q[0] - n.omega * p[1], dq1 = factor * q[1] + n.omega * p[0];
  const double dp0 = p[0] + n.omega * q[1], dp1 = p[1] - n.omega * q[0];
  dHdq[0] = dq0;
  dHdq[1] = dq1;
  dHdp[0] = dp0;
  dHdp[1] = dp1;
}
extern "C" void three_in_scene(const Numbers& n, Read q, Read p, Write dHdq, Write dHdp) {
  Scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = n.gm},
        orbits::RotatingFrame<double, 2>{.omega = n.omega})
      .gradient(q, p, dHdq, dHdp);
}

// One half alone of a separable scene.
extern "C" void half_by_hand(const Numbers& n, Read q, Read, Write dHdq, Write) {
  const double inverse2 = 1 / (q[0] * q[0] + q[1] * q[1]);
  const double factor = n.gm * inverse2 * std::sqrt(inverse2);
  const double dq0 = factor * q[0], dq1 = factor * q[1];
  dHdq[0] = dq0;
  dHdq[1] = dq1;
}
extern "C" void half_in_scene(const Numbers& n, Read q, Read, Write dHdq, Write) {
  Scene(orbits::Kinetic<double, 2>{}, orbits::Attraction<double, 2>{.gm = n.gm}).position_gradient(q, dHdq);
}
