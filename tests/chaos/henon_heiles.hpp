#pragma once

#include <cmath>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>

/// H = (p² + q²)/2 + x²y - y³/3 (Hénon and Heiles, Astron. J. 69 (1964) 73), without second derivatives.
struct HenonHeiles {
  using Scalar = double;
  static constexpr int Dof = 2;
  void gradient(semiexplicit::In<double, 2> q, semiexplicit::In<double, 2> p,
                semiexplicit::Out<double, 2> dHdq, semiexplicit::Out<double, 2> dHdp) const {
    dHdq[0] = q[0] + 2 * q[0] * q[1];
    dHdq[1] = q[1] + q[0] * q[0] - q[1] * q[1];
    dHdp = p;
  }
  /// The point (0, y; px > 0, 0) of energy 1/8.
  static semiexplicit::PhasePoint<double, 2> point(double y) {
    return {{0, y}, {std::sqrt(0.25 - y * y + 2 * y * y * y / 3), 0}};
  }
};

/// The same with the product of its second derivatives.
struct HenonHeilesWithProduct : HenonHeiles {
  void hessian_times(semiexplicit::In<double, 2> q, semiexplicit::In<double, 2>,
                     semiexplicit::In<double, 2> dq, semiexplicit::In<double, 2> dp,
                     semiexplicit::Out<double, 2> hq, semiexplicit::Out<double, 2> hp) const {
    hq[0] = dq[0] + 2 * (dq[0] * q[1] + q[0] * dq[1]);
    hq[1] = dq[1] + 2 * (q[0] * dq[0] - q[1] * dq[1]);
    hp = dp;
  }
};
