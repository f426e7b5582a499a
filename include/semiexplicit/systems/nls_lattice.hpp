#pragma once

#include <algorithm>
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

  Scalar energy(const In<Scalar, N>& q, const In<Scalar, N>& p) const {
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
  static Scalar mass(const In<Scalar, N>& q, const In<Scalar, N>& p) {
    return semiexplicit::detail::dot(q, q) + semiexplicit::detail::dot(p, p);
  }

  void gradient(const In<Scalar, N>& q, const In<Scalar, N>& p, Out<Scalar, N> dHdq,
                Out<Scalar, N> dHdp) const {
    gradient(q.data(), p.data(), dHdq.data(), dHdp.data());
  }

  using PackGradientOf = NlsLattice;
  /// The same with any numbers in arrays, packs above all; see HasPackGradient.
  template <class T>
  void gradient(const T* q, const T* p, T* dHdq, T* dHdp) const {
    if constexpr (N != Eigen::Dynamic && N <= 64)
      small_gradient(q, p, dHdq, dHdp);
    else
      gradient_range(0, dof(), q, p, dHdq, dHdp);
  }

  using RangeGradientOf = NlsLattice;
  /// Entries begin to end - 1; see HasRangeGradient. One pass that reads neighbours instead of storing squares: vectorises,
  /// and touches memory once.
  template <class T>
  void gradient_range(Eigen::Index begin, Eigen::Index end, const T* __restrict q, const T* __restrict p,
                      T* __restrict dHdq, T* __restrict dHdp) const {
    const auto u = [&](Eigen::Index i) -> T { return q[i] * q[i] - p[i] * p[i]; };
    const auto v = [&](Eigen::Index i) -> T { return q[i] * p[i]; };
    const auto put = [&](Eigen::Index i, const T& sum_u, const T& sum_v) {
      site(q[i], p[i], sum_u, sum_v, dHdq[i - begin], dHdp[i - begin]);
    };
    const Eigen::Index last = dof() - 1;
    if (last == 0) return put(0, T(0), T(0));
    if (begin == 0) put(0, u(1), v(1));
    const Eigen::Index inner_begin = std::max<Eigen::Index>(begin, 1), inner_end = std::min(end, last);
    for (Eigen::Index i = inner_begin; i < inner_end; ++i) put(i, u(i - 1) + u(i + 1), v(i - 1) + v(i + 1));
    if (end > last) put(last, u(last - 1), v(last - 1));
  }

#ifdef SEMIEXPLICIT_HAS_LANES
  using LaneGradientOf = NlsLattice;
  /// The same for up to eight sites, all in one register; see HasLaneGradient.
  void lane_gradient(const Lanes* at_q, const Lanes* at_p, Lanes* dHdq, Lanes* dHdp) const
      requires(N > 0 && N <= 8) {
    const Lanes q = *at_q, p = *at_p, none{};
    const Lanes p_squared = p * p, u = q * q - p_squared, density = q * q + p_squared, v = q * p;
    const auto neighbours = [&none](const Lanes& x) {
      return __builtin_shufflevector(x, none, 8, 0, 1, 2, 3, 4, 5, 6) +
             __builtin_shufflevector(x, none, 1, 2, 3, 4, 5, 6, 7, 8);
    };
    const Lanes sum_u = neighbours(u), four_v = 4 * neighbours(v);
    *dHdq = (density - 2 * sum_u) * q - four_v * p;
    *dHdp = (density + 2 * sum_u) * p - four_v * q;
  }
#endif

 private:
  // With ψ² = u + 2iv, u = q² - p² and v = q p, the neighbours enter by the sums of their u and of their v only.
  template <class T>
  static void site(const T& q, const T& p, const T& sum_u, const T& sum_v, T& dHdq, T& dHdp) {
    const T density = q * q + p * p, two_u = 2 * sum_u, four_v = 4 * sum_v;
    dHdq = (density - two_u) * q - four_v * p;
    dHdp = (density + two_u) * p - four_v * q;
  }

  // Squares first, in registers, between two zeros that stand for the open ends.
  template <class T>
  static void small_gradient(const T* q, const T* p, T* __restrict dHdq, T* __restrict dHdp) {
    constexpr int size = N == Eigen::Dynamic ? 1 : N;
    T u[std::size_t(size + 2)], v[std::size_t(size + 2)];
    u[0] = v[0] = u[size + 1] = v[size + 1] = T(0);
    for (int i = 0; i < size; ++i) {
      u[i + 1] = q[i] * q[i] - p[i] * p[i];
      v[i + 1] = q[i] * p[i];
    }
    for (int i = 0; i < size; ++i) site(q[i], p[i], u[i] + u[i + 2], v[i] + v[i + 2], dHdq[i], dHdp[i]);
  }

  Eigen::Index sites_;
};

}  // namespace semiexplicit::systems
