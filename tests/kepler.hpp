#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

/// H = |p|²/2 - 1/|q| in the plane: separable. Size is 2 or Eigen::Dynamic.
template <class T, int Size = 2>
struct KeplerOf {
  using Scalar = T;
  static constexpr int Dof = Size;
  static constexpr bool separable = true;
  using SeparableGradientOf = KeplerOf;
  using Read = semiexplicit::In<T, Size>;
  using Write = semiexplicit::Out<T, Size>;

  Eigen::Index dof() const { return 2; }
  T energy(Read q, Read p) const { return p.squaredNorm() / 2 - 1 / q.norm(); }
  void position_gradient(Read q, Write dHdq) const {
    using std::sqrt;
    const T rr = q.squaredNorm();
    dHdq = q / (rr * sqrt(rr));
  }
  void momentum_gradient(Read p, Write dHdp) const { dHdp = p; }
  void gradient(Read q, Read p, Write dHdq, Write dHdp) const {
    position_gradient(q, dHdq);
    momentum_gradient(p, dHdp);
  }
};
using Kepler = KeplerOf<double>;

/// Its orbit of semi-major axis 1 at the time t after the pericentre, from Kepler's equation.
template <class T = double>
semiexplicit::PhasePoint<T, 2> kepler_orbit(double e, double t) {
  const double mean = std::remainder(t, 2 * std::acos(-1.0));
  double anomaly = mean + (mean > 0 ? e : -e);
  for (int i = 0; i < 50; ++i)
    anomaly -= (anomaly - e * std::sin(anomaly) - mean) / (1 - e * std::cos(anomaly));
  const double c = std::cos(anomaly), s = std::sin(anomaly), b = std::sqrt(1 - e * e), rate = 1 / (1 - e * c);
  return {{T(c - e), T(b * s)}, {T(-s * rate), T(b * c * rate)}};
}
