#pragma once

#include <cmath>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

// A lattice and vectors to carry along.

namespace tangent_lattice {

using namespace semiexplicit;

/// The lattice's gradient, seen as a user's who has nothing more.
template <class Scalar_, int N>
struct GradientOnly {
  using Scalar = Scalar_;
  static constexpr int Dof = N;
  systems::NlsLattice<Scalar, N> lattice;
  Eigen::Index dof() const { return lattice.dof(); }
  void gradient(const In<Scalar, N>& q, const In<Scalar, N>& p, Out<Scalar, N> dHdq,
                Out<Scalar, N> dHdp) const {
    lattice.gradient(q, p, dHdq, dHdp);
  }
};
/// The same with its second derivatives times vectors, off by a factor where that is asked for.
template <class Scalar_, int N>
struct WithProduct : GradientOnly<Scalar_, N> {
  using Scalar = Scalar_;
  Scalar factor = 1;
  void hessian_times(const In<Scalar, N>& q, const In<Scalar, N>& p, const In<Scalar, N>& dq,
                     const In<Scalar, N>& dp, Out<Scalar, N> hq, Out<Scalar, N> hp) const {
    const Eigen::Index n = this->dof();
    for (Eigen::Index i = 0; i < n; ++i) {
      const Scalar density = q[i] * q[i] + p[i] * p[i], grows = 2 * (q[i] * dq[i] + p[i] * dp[i]);
      Scalar u(0), v(0), du(0), dv(0);
      for (const Eigen::Index j : {i - 1, i + 1}) {
        if (j < 0 || j == n) continue;
        u += 2 * (q[j] * q[j] - p[j] * p[j]);
        v += 4 * q[j] * p[j];
        du += 4 * (q[j] * dq[j] - p[j] * dp[j]);
        dv += 4 * (q[j] * dp[j] + p[j] * dq[j]);
      }
      hq[i] = factor * ((density - u) * dq[i] + (grows - du) * q[i] - v * dp[i] - dv * p[i]);
      hp[i] = factor * ((density + u) * dp[i] + (grows + du) * p[i] - v * dq[i] - dv * q[i]);
    }
  }
};
static_assert(HasHessianTimes<WithProduct<double, 5>> && !HasHessianTimes<GradientOnly<double, 5>>);

template <class Scalar, int N>
PhasePoint<Scalar, N> some_point(Eigen::Index n) {
  PhasePoint<Scalar, N> z(n);
  for (Eigen::Index i = 0; i < 2 * n; ++i)
    z.vector()[i] = Scalar(std::sin(1.0 + static_cast<double>(i * i))) / 2;
  return z;
}
template <class Vectors>
void fill(Vectors& v) {
  for (Eigen::Index j = 0; j < v.cols(); ++j)
    for (Eigen::Index i = 0; i < v.rows(); ++i)
      v(i, j) = typename Vectors::Scalar(std::cos(static_cast<double>((i + 2) * (j + 1) * (i + 1)))) *
                typename Vectors::Scalar(std::pow(10.0, static_cast<double>(3 * j)));
}

}  // namespace tangent_lattice
