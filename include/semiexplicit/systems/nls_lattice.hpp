#pragma once

#include <algorithm>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/scene/effect.hpp>

/// Effects on a chain of N sites with open ends, ψ = q + ip at each; time in units of 1/energy. H moves it by
/// ψ' = -2i ∂H/∂ψ̄. N is the size, or Eigen::Dynamic with the size in `sites`. Scene(OnSite{.sites = n},
/// PairExchange{.sites = n}) is systems::NlsLattice. All keep the mass Σ|ψᵢ|².
namespace semiexplicit::effects::lattice {

namespace detail {

/// The number of sites, known to the type or to the effect. The effects' dof() is `sites` in both cases, so
/// that a scene refuses another number than that of its type.
template <int N>
constexpr Eigen::Index size(Eigen::Index sites) {
  return N == Eigen::Dynamic ? sites : N;
}

/// ψ² = u + 2iv: PairExchange reads the neighbours of a site by the sums of their u and of their v only.
template <class T>
T u(const T& q, const T& p) {
  return q * q - p * p;
}
template <class T>
T v(const T& q, const T& p) {
  return q * p;
}

/// put(i, Σu, Σv) for the sites begin to end - 1 that have neighbours. One pass that reads neighbours instead
/// of storing squares: vectorises, and touches memory once.
template <class Q, class P, class Put>
[[gnu::always_inline]] inline void over_neighbours(Eigen::Index sites, Eigen::Index begin, Eigen::Index end,
                                                   const Q& q, const P& p, const Put& put) {
  const auto u_at = [&](Eigen::Index i) { return u(q[i], p[i]); };
  const auto v_at = [&](Eigen::Index i) { return v(q[i], p[i]); };
  const Eigen::Index last = sites - 1;
  if (last < 1) return;
  if (begin == 0) put(0, u_at(1), v_at(1));
  const Eigen::Index inner_begin = std::max<Eigen::Index>(begin, 1), inner_end = std::min(end, last);
  for (Eigen::Index i = inner_begin; i < inner_end; ++i)
    put(i, u_at(i - 1) + u_at(i + 1), v_at(i - 1) + v_at(i + 1));
  if (end > last) put(last, u_at(last - 1), v_at(last - 1));
}

/// Both halves of the gradient at a site: of OnSite, density = g|ψ|², and of PairExchange, by_u = 2kΣu and
/// by_v = 4kΣv.
template <class T>
struct SiteGradient {
  T q, p;
  SiteGradient(const T& at_q, const T& at_p, const T& density, const T& by_u, const T& by_v)
      : q((density - by_u) * at_q - by_v * at_p), p((density + by_u) * at_p - by_v * at_q) {}
};

}  // namespace detail

/// The cubic nonlinearity on each site: g/4 Σ|ψᵢ|⁴. Alone it turns a site at g|ψ|².
template <class Scalar = double, int N = Eigen::Dynamic>
struct OnSite {
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "on_site";
  static constexpr const char* about = "cubic nonlinearity of each site, g/4 Σ|ψ|⁴";
  Eigen::Index sites = N;
  Scalar strength = Scalar(1);  ///< g

  Eigen::Index dof() const { return sites; }

  Scalar energy(const auto& q, const auto& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < detail::size<N>(sites); ++i) {
      const Scalar density = q[i] * q[i] + p[i] * p[i];
      sum += density * density;
    }
    return strength * sum / 4;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    for (Eigen::Index i = 0; i < detail::size<N>(sites); ++i) {
      const auto density = strength * (q[i] * q[i] + p[i] * p[i]);
      dHdq[i] += density * q[i];
      dHdp[i] += density * p[i];
    }
  }
};

/// The coupling of neighbours in the lattice of the resonant Schrödinger equation: -k Σ Re(ψ²ᵢ₋₁ conj(ψᵢ)²).
///
/// Source: Colliander, Keel, Staffilani, Takaoka, Tao, Invent. Math. 181 (2010) 39.
template <class Scalar = double, int N = Eigen::Dynamic>
struct PairExchange {
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "pair_exchange";
  static constexpr const char* about = "quartic coupling of neighbours, -k Σ Re(ψ²ψ̄²)";
  Eigen::Index sites = N;
  Scalar strength = Scalar(1);  ///< k

  Eigen::Index dof() const { return sites; }

  Scalar energy(const auto& q, const auto& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 1; i < detail::size<N>(sites); ++i)
      sum += detail::u(q[i - 1], p[i - 1]) * detail::u(q[i], p[i]) +
             4 * detail::v(q[i - 1], p[i - 1]) * detail::v(q[i], p[i]);
    return -strength * sum;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const Eigen::Index n = detail::size<N>(sites);
    detail::over_neighbours(n, 0, n, q, p, [&]<class T>(Eigen::Index i, const T& sum_u, const T& sum_v) {
      const T none = -Scalar(0);  // adding to it changes no number, so the compiler leaves that out
      const detail::SiteGradient<T> at(q[i], p[i], none, 2 * strength * sum_u, 4 * strength * sum_v);
      dHdq[i] += at.q;
      dHdp[i] += at.p;
    });
  }
};

/// Hopping to the neighbours: -J Σ Re(ψᵢ₋₁ conj(ψᵢ)), so that iψᵢ' = -J(ψᵢ₋₁ + ψᵢ₊₁), a wave of number k
/// turns at -2J cos k. Separable.
///
/// Source: the tight-binding model; C. Kittel, Introduction to Solid State Physics, chapter 9.
template <class Scalar = double, int N = Eigen::Dynamic>
struct Hopping {
  using Acts = OnEach<Scalar, N>;
  static constexpr const char* name = "hopping";
  static constexpr const char* about = "hopping to neighbours, -J Σ Re(ψψ̄)";
  Eigen::Index sites = N;
  Scalar rate = Scalar(1);  ///< J

  Eigen::Index dof() const { return sites; }

  Scalar energy(const auto& x) const {
    Scalar sum(0);
    for (Eigen::Index i = 1; i < detail::size<N>(sites); ++i) sum += x[i - 1] * x[i];
    return -rate * sum;
  }
  void add_gradient(const auto& x, auto& dHdx) const {
    const Eigen::Index last = detail::size<N>(sites) - 1;
    if (last < 1) return;
    dHdx[0] -= rate * x[1];
    for (Eigen::Index i = 1; i < last; ++i) dHdx[i] -= rate * (x[i - 1] + x[i + 1]);
    dHdx[last] -= rate * x[last - 1];
  }
};

/// An energy of its own for each site: ½ Σ εᵢ|ψᵢ|². A site alone turns at εᵢ. Separable.
///
/// Source: P. W. Anderson, Phys. Rev. 109 (1958) 1492.
template <class Scalar = double, int N = Eigen::Dynamic>
class Disorder {
 public:
  using Acts = OnEach<Scalar, N>;
  static constexpr const char* name = "disorder";
  static constexpr const char* about = "an energy of its own for each site, ½ Σ ε|ψ|²";

  explicit Disorder(Vector<Scalar, N> energies) : energies_(std::move(energies)) {}
  Eigen::Index dof() const { return detail::size<N>(energies_.size()); }
  const Vector<Scalar, N>& energies() const { return energies_; }

  Scalar energy(const auto& x) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i) sum += energies_[i] * x[i] * x[i];
    return sum / 2;
  }
  void add_gradient(const auto& x, auto& dHdx) const {
    for (Eigen::Index i = 0; i < dof(); ++i) dHdx[i] += energies_[i] * x[i];
  }

 private:
  Vector<Scalar, N> energies_;
};

}  // namespace semiexplicit::effects::lattice

namespace semiexplicit::systems {

/// The finite-dimensional cubic nonlinear Schrödinger lattice with N sites, open ends. With ψ = q + ip,
///
///     H = ¼ Σ |ψᵢ|⁴ - Σ Re(ψ²ᵢ₋₁ conj(ψᵢ)²),
///
/// the second sum over neighbours: the effects OnSite and PairExchange of strength 1 in one pass. It keeps H
/// and the mass Σ |ψᵢ|². N is the size, or Eigen::Dynamic with the size given to the constructor.
///
/// Sources: Colliander, Keel, Staffilani, Takaoka, Tao, Invent. Math. 181 (2010) 39; Jayawardana and Ohsawa
/// (2023), eq. (Hamil-NLS).
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
    return effects::lattice::OnSite<Scalar, N>{.sites = dof()}.energy(q, p) +
           effects::lattice::PairExchange<Scalar, N>{.sites = dof()}.energy(q, p);
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
  /// A site feels its neighbours; see HasLocalGradient.
  static constexpr Eigen::Index reach() { return 1; }
  /// Entries begin to end - 1; see HasRangeGradient.
  template <class T>
  void gradient_range(Eigen::Index begin, Eigen::Index end, const T* __restrict q, const T* __restrict p,
                      T* __restrict dHdq, T* __restrict dHdp) const {
    if (begin >= end) return;
    const auto put = [&](Eigen::Index i, const T& sum_u, const T& sum_v) {
      site(q[i], p[i], sum_u, sum_v, dHdq[i - begin], dHdp[i - begin]);
    };
    if (dof() == 1) return put(0, T(0), T(0));
    effects::lattice::detail::over_neighbours(dof(), begin, end, q, p, put);
  }

#ifdef SEMIEXPLICIT_HAS_LANES
  using LaneGradientOf = NlsLattice;
  /// The same for up to eight sites, all in one register; see HasLaneGradient.
  void lane_gradient(const Lanes* q, const Lanes* p, Lanes* dHdq, Lanes* dHdp) const
      requires(N > 0 && N <= 8) {
    const auto neighbours = [none = Lanes{}](const Lanes& x) -> Lanes {
      return __builtin_shufflevector(x, none, 8, 0, 1, 2, 3, 4, 5, 6) +
             __builtin_shufflevector(x, none, 1, 2, 3, 4, 5, 6, 7, 8);
    };
    namespace lattice = effects::lattice::detail;
    site(*q, *p, neighbours(lattice::u(*q, *p)), neighbours(lattice::v(*q, *p)), *dHdq, *dHdp);
  }
#endif

 private:
  template <class T>
  static void site(const T& q, const T& p, const T& sum_u, const T& sum_v, T& dHdq, T& dHdp) {
    const T density = q * q + p * p, by_u = 2 * sum_u, by_v = 4 * sum_v;
    const effects::lattice::detail::SiteGradient<T> gradient(q, p, density, by_u, by_v);
    dHdq = gradient.q;
    dHdp = gradient.p;
  }

  // Squares first, in registers, between two zeros that stand for the open ends.
  template <class T>
  static void small_gradient(const T* q, const T* p, T* __restrict dHdq, T* __restrict dHdp) {
    constexpr int size = N == Eigen::Dynamic ? 1 : N;
    namespace lattice = effects::lattice::detail;
    T u[std::size_t(size + 2)], v[std::size_t(size + 2)];
    u[0] = v[0] = u[size + 1] = v[size + 1] = T(0);
    for (int i = 0; i < size; ++i) {
      u[i + 1] = lattice::u(q[i], p[i]);
      v[i + 1] = lattice::v(q[i], p[i]);
    }
    for (int i = 0; i < size; ++i) site(q[i], p[i], u[i] + u[i + 2], v[i] + v[i + 2], dHdq[i], dHdp[i]);
  }

  Eigen::Index sites_;
};

}  // namespace semiexplicit::systems
