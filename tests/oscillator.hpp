#pragma once

#include <semiexplicit/semiexplicit.hpp>

/// H = (p² + q²)/2, at the rate 1.
template <class T>
struct OscillatorOf {
  using Scalar = T;
  static constexpr int Dof = 1;
  using Read = semiexplicit::In<T, 1>;
  using Write = semiexplicit::Out<T, 1>;

  T energy(Read q, Read p) const { return (p[0] * p[0] + q[0] * q[0]) / 2; }
  void gradient(Read q, Read p, Write dHdq, Write dHdp) const {
    dHdq[0] = q[0];
    dHdp[0] = p[0];
  }
};
