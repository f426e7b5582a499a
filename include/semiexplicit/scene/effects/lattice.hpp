#pragma once

#include <utility>

#include <semiexplicit/scene/effect.hpp>

/// Effects on a chain of N sites with open ends, ψ = q + ip at each; time in units of 1/energy. H moves it by ψ' = -2i
/// ∂H/∂ψ̄. N is the size, or Eigen::Dynamic with the size in `sites`. Scene(OnSite{.sites = n}, PairExchange{.sites = n}) is
/// systems::NlsLattice. All keep the mass Σ|ψᵢ|².
namespace semiexplicit::effects::lattice {

namespace detail {

/// The number of sites, known to the type or to the effect.
template <int N>
constexpr Eigen::Index size(Eigen::Index sites) {
  return N == Eigen::Dynamic ? sites : N;
}

}  // namespace detail

/// The cubic nonlinearity on each site: g/4 Σ|ψᵢ|⁴. Alone it turns a site at g|ψ|².
template <int N = Eigen::Dynamic, class Scalar = double>
struct OnSite {
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "on_site";
  static constexpr const char* about = "cubic nonlinearity of each site, g/4 Σ|ψ|⁴";
  Eigen::Index sites = N;
  Scalar strength = Scalar(1);  ///< g

  Eigen::Index dof() const { return detail::size<N>(sites); }

  Scalar energy(const auto& q, const auto& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const Scalar density = q[i] * q[i] + p[i] * p[i];
      sum += density * density;
    }
    return strength * sum / 4;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const auto density = strength * (q[i] * q[i] + p[i] * p[i]);
      dHdq[i] += density * q[i];
      dHdp[i] += density * p[i];
    }
  }
};

/// The coupling of neighbours in the lattice of the resonant Schrödinger equation: -k Σ Re(ψ²ᵢ₋₁ conj(ψᵢ)²).
///
/// Source: Colliander, Keel, Staffilani, Takaoka, Tao, Invent. Math. 181 (2010) 39.
template <int N = Eigen::Dynamic, class Scalar = double>
struct PairExchange {
  using Acts = OnBoth<Scalar, N>;
  static constexpr const char* name = "pair_exchange";
  static constexpr const char* about = "quartic coupling of neighbours, -k Σ Re(ψ²ψ̄²)";
  Eigen::Index sites = N;
  Scalar strength = Scalar(1);  ///< k

  Eigen::Index dof() const { return detail::size<N>(sites); }

  Scalar energy(const auto& q, const auto& p) const {
    Scalar sum(0);
    for (Eigen::Index i = 1; i < dof(); ++i)
      sum += (q[i - 1] * q[i - 1] - p[i - 1] * p[i - 1]) * (q[i] * q[i] - p[i] * p[i]) +
             4 * q[i - 1] * p[i - 1] * q[i] * p[i];
    return -strength * sum;
  }
  // With ψ² = u + 2iv, u = q² - p² and v = qp, neighbours enter by their u and v only.
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto u = [&](Eigen::Index i) { return q[i] * q[i] - p[i] * p[i]; };
    const auto v = [&](Eigen::Index i) { return q[i] * p[i]; };
    const auto add = [&](Eigen::Index i, const auto& sum_u, const auto& sum_v) {
      const auto by_u = 2 * strength * sum_u, by_v = 4 * strength * sum_v;
      dHdq[i] -= by_u * q[i] + by_v * p[i];
      dHdp[i] += by_u * p[i] - by_v * q[i];
    };
    const Eigen::Index last = dof() - 1;
    if (last < 1) return;
    add(0, u(1), v(1));
    for (Eigen::Index i = 1; i < last; ++i) add(i, u(i - 1) + u(i + 1), v(i - 1) + v(i + 1));
    add(last, u(last - 1), v(last - 1));
  }
};

/// Hopping to the neighbours: -J Σ Re(ψᵢ₋₁ conj(ψᵢ)), so that iψᵢ' = -J(ψᵢ₋₁ + ψᵢ₊₁), a wave of number k turns at
/// -2J cos k. Separable.
///
/// Source: the tight-binding model; C. Kittel, Introduction to Solid State Physics, chapter 9.
template <int N = Eigen::Dynamic, class Scalar = double>
struct Hopping {
  using Acts = OnEach<Scalar, N>;
  static constexpr const char* name = "hopping";
  static constexpr const char* about = "hopping to neighbours, -J Σ Re(ψψ̄)";
  Eigen::Index sites = N;
  Scalar rate = Scalar(1);  ///< J

  Eigen::Index dof() const { return detail::size<N>(sites); }

  Scalar energy(const auto& x) const {
    Scalar sum(0);
    for (Eigen::Index i = 1; i < dof(); ++i) sum += x[i - 1] * x[i];
    return -rate * sum;
  }
  void add_gradient(const auto& x, auto& dHdx) const {
    const Eigen::Index last = dof() - 1;
    if (last < 1) return;
    dHdx[0] -= rate * x[1];
    for (Eigen::Index i = 1; i < last; ++i) dHdx[i] -= rate * (x[i - 1] + x[i + 1]);
    dHdx[last] -= rate * x[last - 1];
  }
};

/// An energy of its own for each site: ½ Σ εᵢ|ψᵢ|². A site alone turns at εᵢ. Separable.
///
/// Source: P. W. Anderson, Phys. Rev. 109 (1958) 1492.
template <int N = Eigen::Dynamic, class Scalar = double>
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
