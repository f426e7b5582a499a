#pragma once

#include <utility>

#include <semiexplicit/core/vector.hpp>

namespace examples {

/// The disordered discrete nonlinear Schrödinger equation, open ends: with ψ = (q + ip)/√2,
///
///     H = Σ εᵢ|ψᵢ|² + β/2 |ψᵢ|⁴ - (ψᵢ₊₁ conj(ψᵢ) + its conjugate).
///
/// The gradient, and the second derivatives times a vector.
class Chain {
 public:
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  using Half = semiexplicit::In<double, Dof>;
  using Result = semiexplicit::Out<double, Dof>;

  Chain(Eigen::VectorXd energies, double beta) : energies_(std::move(energies)), beta_(beta) {}
  Eigen::Index dof() const { return energies_.size(); }

  double energy(const Half& q, const Half& p) const {
    const Eigen::Index bonds = dof() - 1;
    const auto density = (q.array().square() + p.array().square()) / 2;
    return ((energies_.array() + beta_ / 2 * density) * density).sum() - q.head(bonds).dot(q.tail(bonds)) -
           p.head(bonds).dot(p.tail(bonds));
  }

  void gradient(const Half& q, const Half& p, Result dHdq, Result dHdp) const {
    const auto turn = energies_.array() + beta_ / 2 * (q.array().square() + p.array().square());
    dHdq.array() = turn * q.array();
    dHdp.array() = turn * p.array();
    hop(q, dHdq);
    hop(p, dHdp);
  }

  void hessian_times(const Half& q, const Half& p, const Half& dq, const Half& dp, Result hq,
                     Result hp) const {
    const auto turn = energies_.array() + beta_ / 2 * (q.array().square() + p.array().square());
    const auto change = beta_ * (q.array() * dq.array() + p.array() * dp.array());
    hq.array() = turn * dq.array() + change * q.array();
    hp.array() = turn * dp.array() + change * p.array();
    hop(dq, hq);
    hop(dp, hp);
  }

 private:
  static void hop(const Half& from, Result& to) {
    const Eigen::Index bonds = from.size() - 1;
    to.head(bonds) -= from.tail(bonds);
    to.tail(bonds) -= from.head(bonds);
  }

  Eigen::VectorXd energies_;
  double beta_;
};

}  // namespace examples
