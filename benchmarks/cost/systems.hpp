#pragma once

#include <cmath>
#include <string>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace bench {

using namespace semiexplicit;

/// A charge in a magnetic bottle, H = ‖p - A(q)‖²/2 with A = (1 + z²/400)/2 (-y, x, 0): gyration, bounce and
/// drift.
struct MagneticBottle {
  using Scalar = double;
  static constexpr int Dof = 3;

  static double field(double z) { return 1 + z * z / 400; }
  double energy(const In<double, 3>& q, const In<double, 3>& p) const {
    const double half = field(q[2]) / 2, vx = p[0] + half * q[1], vy = p[1] - half * q[0];
    return (vx * vx + vy * vy + p[2] * p[2]) / 2;
  }
  void gradient(const In<double, 3>& q, const In<double, 3>& p, Out<double, 3> dHdq,
                Out<double, 3> dHdp) const {
    const double half = field(q[2]) / 2, vx = p[0] + half * q[1], vy = p[1] - half * q[0];
    dHdq << -half * vy, half * vx, q[2] / 400 * (vx * q[1] - vy * q[0]);
    dHdp << vx, vy, p[2];
  }
};

/// Two bodies of equal mass in the first post-Newtonian approximation, in their centre of mass (G = m = μ =
/// 1): H = p²/2 - 1/r + (1/c²)(-(1 - 3ν)p⁴/8 - ((3 + ν)p² + ν (n·p)²)/(2r) + 1/(2r²)), ν = 1/4.
struct PostNewtonian {
  using Scalar = double;
  static constexpr int Dof = 2;
  double per_c_squared = 0.01;

  double energy(const In<double, 2>& q, const In<double, 2>& p) const {
    const double r = std::hypot(q[0], q[1]), pp = p[0] * p[0] + p[1] * p[1];
    const double np = (q[0] * p[0] + q[1] * p[1]) / r, nu = 0.25;
    return pp / 2 - 1 / r +
           per_c_squared *
               (-(1 - 3 * nu) * pp * pp / 8 - ((3 + nu) * pp + nu * np * np) / (2 * r) + 1 / (2 * r * r));
  }
  void gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                Out<double, 2> dHdp) const {
    const double rr = q[0] * q[0] + q[1] * q[1], r = std::sqrt(rr), pp = p[0] * p[0] + p[1] * p[1];
    const double qp = q[0] * p[0] + q[1] * p[1], nu = 0.25, k = per_c_squared;
    // The term with (n·p)² is -k nu (q·p)²/(2r³).
    const double along_q = 1 / (rr * r) + k * ((3 + nu) * pp / (2 * rr * r) +
                                               1.5 * nu * qp * qp / (rr * rr * r) - 1 / (rr * rr));
    const double along_p_in_q = -k * nu * qp / (rr * r);
    const double along_p = 1 - k * ((1 - 3 * nu) * pp / 2 + (3 + nu) / r);
    const double along_q_in_p = -k * nu * qp / (rr * r);
    for (int i = 0; i < 2; ++i) {
      dHdq[i] = along_q * q[i] + along_p_in_q * p[i];
      dHdp[i] = along_p * p[i] + along_q_in_p * q[i];
    }
  }
};

/// Two rods of unit length with unit masses at their ends: chaotic at this height.
struct DoublePendulum {
  using Scalar = double;
  static constexpr int Dof = 2;

  double energy(const In<double, 2>& q, const In<double, 2>& p) const {
    const double c = std::cos(q[0] - q[1]), n = 2 - c * c;
    return (p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c) / (2 * n) - 2 * std::cos(q[0]) -
           std::cos(q[1]);
  }
  void gradient(const In<double, 2>& q, const In<double, 2>& p, Out<double, 2> dHdq,
                Out<double, 2> dHdp) const {
    const double c = std::cos(q[0] - q[1]), s = std::sin(q[0] - q[1]), n = 2 - c * c;
    const double top = p[0] * p[0] + 2 * p[1] * p[1] - 2 * p[0] * p[1] * c;
    const double turn = p[0] * p[1] * s / n - top * c * s / (n * n);  // ∂/∂(q₀ - q₁) of the kinetic energy
    dHdq << turn + 2 * std::sin(q[0]), -turn + std::sin(q[1]);
    dHdp << (p[0] - p[1] * c) / n, (2 * p[1] - p[0] * c) / n;
  }
};

/// Calls use(name, H, z0, T) for each of the eight systems.
template <class Use>
void for_each_system(const Use& use) {
  use("product", systems::Product<double>(), PhasePoint<double, 1>(-3, 0), 2000.0);
  use("NLS 5", systems::NlsLattice<double, 5>(),
      PhasePoint<double, 5>({3, 0.01, 0.01, 0.01, 0.01}, {1, 0, 0, 0, 0}), 1000.0);

  using Ten = Vector<double, 10>;
  const systems::PointVortices<double, 10> ten(Ten{-.5, .3, .6, .7, -.2, -.8, -.9, -.3, .7, -.6});
  use("ten vortices", ten,
      ten.phase_point(Ten{3, -10, 6, 9, 0, 7, -8, 5, 9, 7}, Ten{-5, -6, 0, -2, 0, 10, 2, 9, 0, -1}),
      20'000.0);
  const systems::PointVortices<double, 10> disparate(
      Ten{-14.8, -18.8, 17.6, -8, -8.2, -6.8, -1.4, 6, -11, 13.8});
  use("disparate vortices", disparate,
      disparate.phase_point(Ten{.5, 3.5, -1.5, -.5, -4.5, -3.5, 1.5, -2, 4, -4},
                            Ten{5, .5, 2, 5, -2, -1, -.5, 3, 3.5, -4}),
      4000.0);

  PhasePoint<double, Eigen::Dynamic> chain(100);
  chain.q().setConstant(0.01);
  chain.q()[0] = 3;
  chain.p()[0] = 1;
  use("NLS 100", systems::NlsLattice<double>(100), chain, 300.0);

  use("magnetic bottle", MagneticBottle(), PhasePoint<double, 3>({0.5, 0, 0}, {0, 1, 0.7}), 5000.0);
  use("post-Newtonian orbit", PostNewtonian(), PhasePoint<double, 2>({1.5, 0}, {0, 0.55}), 5000.0);
  use("double pendulum", DoublePendulum(), PhasePoint<double, 2>({1.8, 2.2}, {0, 0}), 3000.0);
}

}  // namespace bench
