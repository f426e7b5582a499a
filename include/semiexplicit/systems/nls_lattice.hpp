#pragma once

#include <stdexcept>
#include <string>

#include <semiexplicit/core/lanes.hpp>

namespace semiexplicit::systems {

/// The finite-dimensional cubic nonlinear Schrödinger lattice with N sites, open ends. With ψ = q + ip,
///
///     H = ¼ Σ |ψᵢ|⁴ - Σ Re(ψ²ᵢ₋₁ conj(ψᵢ)²),
///
/// the second sum over neighbours. It keeps H and the mass Σ |ψᵢ|². N is the size, or Eigen::Dynamic with the size given
/// to the constructor.
///
/// Sources: Colliander, Keel, Staffilani, Takaoka, Tao, Invent. Math. 181 (2010) 39; Jayawardana and Ohsawa (2023),
/// eq. (Hamil-NLS).
template <class ScalarType = double, int N = Eigen::Dynamic>
class NlsLattice {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = N;

  NlsLattice() requires(N != Eigen::Dynamic) : sites_(N) {}

  /// Throws std::invalid_argument unless there is at least one site.
  explicit NlsLattice(Eigen::Index sites) : sites_(sites) {
    if (sites < 1 || (N != Eigen::Dynamic && sites != N))
      throw std::invalid_argument("NlsLattice: " + std::to_string(sites) + " sites asked for; give " +
                                  (N == Eigen::Dynamic ? std::string("one or more") : std::to_string(N)));
  }

  Eigen::Index dof() const { return N == Eigen::Dynamic ? sites_ : N; }

  Scalar energy(const ConstRef<Scalar, N>& q, const ConstRef<Scalar, N>& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const Scalar density = q[i] * q[i] + p[i] * p[i];
      sum += density * density / 4;
      if (i > 0)
        sum -= (q[i - 1] * q[i - 1] - p[i - 1] * p[i - 1]) * (q[i] * q[i] - p[i] * p[i]) +
               4 * q[i - 1] * p[i - 1] * q[i] * p[i];
    }
    return sum;
  }

  /// Σ (q² + p²), the total mass: a quadratic invariant.
  static Scalar mass(const ConstRef<Scalar, N>& q, const ConstRef<Scalar, N>& p) {
    return detail::dot(q, q) + detail::dot(p, p);
  }

  void gradient(const ConstRef<Scalar, N>& q, const ConstRef<Scalar, N>& p, Ref<Scalar, N> dHdq,
                Ref<Scalar, N> dHdp) const {
    if constexpr (N != Eigen::Dynamic && N <= 64)
      small_gradient(q.data(), p.data(), dHdq.data(), dHdp.data());
    else
      large_gradient(q.data(), p.data(), dHdq.data(), dHdp.data());
  }

#ifdef SEMIEXPLICIT_HAS_LANES
  using LaneGradientOf = NlsLattice;
  /// The same for up to eight sites, all in one register; see HasLaneGradient.
  void lane_gradient(const Lanes& q, const Lanes& p, Lanes& dHdq, Lanes& dHdp) const
      requires(N > 0 && N <= 8) {
    const Lanes none{}, p_squared = p * p, u = q * q - p_squared, density = q * q + p_squared, v = q * p;
    const auto neighbours = [&none](const Lanes& x) {
      return __builtin_shufflevector(x, none, 8, 0, 1, 2, 3, 4, 5, 6) +
             __builtin_shufflevector(x, none, 1, 2, 3, 4, 5, 6, 7, 8);
    };
    const Lanes sum_u = neighbours(u), four_v = 4 * neighbours(v);
    dHdq = (density - 2 * sum_u) * q - four_v * p;
    dHdp = (density + 2 * sum_u) * p - four_v * q;
  }
#endif

 private:
  // With ψ² = u + 2iv, u = q² - p² and v = q p, the neighbours enter by the sums of their u and of their v only.
  static void site(Scalar q, Scalar p, Scalar sum_u, Scalar sum_v, Scalar& dHdq, Scalar& dHdp) {
    const Scalar density = q * q + p * p;
    dHdq = (density - 2 * sum_u) * q - 4 * sum_v * p;
    dHdp = (density + 2 * sum_u) * p - 4 * sum_v * q;
  }

  // Squares first, in registers, between two zeros that stand for the open ends.
  static void small_gradient(const Scalar* q, const Scalar* p, Scalar* __restrict dHdq,
                             Scalar* __restrict dHdp) {
    constexpr int size = N == Eigen::Dynamic ? 1 : N;
    Scalar u[size + 2], v[size + 2];
    u[0] = v[0] = u[size + 1] = v[size + 1] = Scalar(0);
    for (int i = 0; i < size; ++i) {
      u[i + 1] = q[i] * q[i] - p[i] * p[i];
      v[i + 1] = q[i] * p[i];
    }
    for (int i = 0; i < size; ++i) site(q[i], p[i], u[i] + u[i + 2], v[i] + v[i + 2], dHdq[i], dHdp[i]);
  }

  // One pass that reads neighbours instead of storing squares: vectorises, and touches memory once.
  void large_gradient(const Scalar* __restrict q, const Scalar* __restrict p, Scalar* __restrict dHdq,
                      Scalar* __restrict dHdp) const {
    const Eigen::Index last = dof() - 1;
    const auto u = [&](Eigen::Index i) { return q[i] * q[i] - p[i] * p[i]; };
    const auto v = [&](Eigen::Index i) { return q[i] * p[i]; };
    if (last == 0) return site(q[0], p[0], Scalar(0), Scalar(0), dHdq[0], dHdp[0]);
    site(q[0], p[0], u(1), v(1), dHdq[0], dHdp[0]);
    for (Eigen::Index i = 1; i < last; ++i)
      site(q[i], p[i], u(i - 1) + u(i + 1), v(i - 1) + v(i + 1), dHdq[i], dHdp[i]);
    site(q[last], p[last], u(last - 1), v(last - 1), dHdq[last], dHdp[last]);
  }

  Eigen::Index sites_;
};

}  // namespace semiexplicit::systems
