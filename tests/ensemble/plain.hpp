#pragma once

#include <cstring>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

/// Systems for the tests of packs and ensembles.
namespace plain {

using namespace semiexplicit;

/// A lattice of N sites without its gradient in registers (HasLaneGradient), which has other rounding errors.
template <int N>
struct Lattice {
  using Scalar = double;
  static constexpr int Dof = N;
  systems::NlsLattice<double, N> lattice;
  Eigen::Index dof() const { return lattice.dof(); }
  void gradient(const In<double, N>& q, const In<double, N>& p, Out<double, N> dHdq,
                Out<double, N> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
};

/// H = k (q² + 1)(p² + 1)/2, of numbers or of packs.
template <class S>
struct Product {
  using Scalar = S;
  static constexpr int Dof = 1;
  S k = S(1.0);
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    dHdq[0] = k * q[0] * (p[0] * p[0] + 1.0);
    dHdp[0] = k * p[0] * (q[0] * q[0] + 1.0);
  }
};

/// H = (q² + p²)/2 + 0.3 q p: states of any size move alike.
template <class S>
struct Quadratic {
  using Scalar = S;
  static constexpr int Dof = 1;
  void gradient(In<S, 1> q, In<S, 1> p, Out<S, 1> dHdq, Out<S, 1> dHdp) const {
    dHdq[0] = q[0] + 0.3 * p[0];
    dHdp[0] = p[0] + 0.3 * q[0];
  }
};

template <int Dof>
bool same_bits(const PhasePoint<double, Dof>& x, const PhasePoint<double, Dof>& y) {
  return x.dof() == y.dof() && std::memcmp(x.vector().data(), y.vector().data(),
                                           sizeof(double) * std::size_t(x.vector().size())) == 0;
}

/// Some lattice state, another for each i.
template <int N>
PhasePoint<double, N> lattice_state(Eigen::Index sites, int i) {
  PhasePoint<double, N> z(sites);
  for (Eigen::Index j = 0; j < sites; ++j) {
    z.q()[j] = (0.2 + 0.15 * i) * std::cos(double(j) + i);
    z.p()[j] = (0.1 + 0.10 * i) * std::sin(1 + 2.0 * double(j) - i);
  }
  return z;
}

}  // namespace plain
