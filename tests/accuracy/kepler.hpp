#pragma once

#include <cmath>

#include <semiexplicit/semiexplicit.hpp>

/// p²/2 - 1/r: separable.
struct Kepler {
  using Scalar = double;
  static constexpr int Dof = 2;
  static constexpr bool separable = true;
  using SeparableGradientOf = Kepler;
  double energy(semiexplicit::In<double, 2> q, semiexplicit::In<double, 2> p) const {
    return p.squaredNorm() / 2 - 1 / q.norm();
  }
  void position_gradient(semiexplicit::In<double, 2> q, semiexplicit::Out<double, 2> half) const {
    half = q / std::pow(q.norm(), 3);
  }
  void momentum_gradient(semiexplicit::In<double, 2> p, semiexplicit::Out<double, 2> half) const { half = p; }
  void gradient(semiexplicit::In<double, 2> q, semiexplicit::In<double, 2> p,
                semiexplicit::Out<double, 2> dHdq, semiexplicit::Out<double, 2> dHdp) const {
    position_gradient(q, dHdq);
    momentum_gradient(p, dHdp);
  }
};
