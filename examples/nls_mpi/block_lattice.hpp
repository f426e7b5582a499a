#pragma once

#include <cmath>
#include <cstdint>

#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/threads.hpp>
#include <semiexplicit/systems/nls_lattice.hpp>

#include "ranks.hpp"

namespace examples {

using namespace semiexplicit;

/// The sites of systems::NlsLattice that this rank has, a range of them. The gradient asks the neighbours for
/// a site each; sums are those of all ranks.
class BlockLattice {
 public:
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  using Column = In<double, Dof>;
  using State = PhasePoint<double, Dof>;

  /// There are no fewer sites than ranks.
  BlockLattice(const Ranks& ranks, std::int64_t sites)
      : ranks_(&ranks),
        begin_(sites * ranks.rank() / ranks.size()),
        lattice_(sites * (ranks.rank() + 1) / ranks.size() - begin_) {}

  Eigen::Index dof() const { return lattice_.dof(); }
  double sum_over_ranks(const double& x) const { return ranks_->sum(x); }

  void gradient(const Column& q, const Column& p, Out<double, Dof> dHdq, Out<double, Dof> dHdp) const {
    const Eigen::Index last = dof() - 1;
    const auto beside = ranks_->exchange({q[0], p[0]}, {q[last], p[last]}, [&] {
      in_parts(dof(), 64, Eigen::Index{1} << 16, [&](Eigen::Index from, Eigen::Index to) {
        lattice_.gradient_range(from, to, q.data(), p.data(), dHdq.data() + from, dHdp.data() + from);
      });
    });
    const auto add = [&](Eigen::Index i, const Ranks::Site& other) {
      const double by_u = 2 * u(other), by_v = 4 * v(other);
      dHdq[i] -= by_u * q[i] + by_v * p[i];
      dHdp[i] += by_u * p[i] - by_v * q[i];
    };
    add(0, beside.left);
    add(last, beside.right);
  }

  /// Of all ranks. The pair of neighbours that two of them share counts for the right one.
  double energy(const Column& q, const Column& p) const {
    const Eigen::Index last = dof() - 1;
    double own = 0;
    const auto beside =
        ranks_->exchange({q[0], p[0]}, {q[last], p[last]}, [&] { own = lattice_.energy(q, p); });
    const Ranks::Site first{q[0], p[0]};
    return ranks_->sum(own - u(beside.left) * u(first) - 4 * v(beside.left) * v(first));
  }
  double mass(const Column& q, const Column& p) const {
    return dot_over_ranks(*this, q, q) + dot_over_ranks(*this, p, p);
  }
  /// Over how many sites the mass is spread: (Σ|ψ|²)²/Σ|ψ|⁴.
  double participation(const Column& q, const Column& p) const {
    const double all = mass(q, p),
                 squares = ranks_->sum((q.array().square() + p.array().square()).square().sum());
    return all * all / squares;
  }

  /// The block of a wave whose size is not the same everywhere.
  State start() const {
    State z(dof());
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const auto site = static_cast<double>(begin_ + i);
      const double size = 0.7 + 0.2 * std::sin(0.37 * site), phase = 0.1 * site + std::cos(0.011 * site);
      z.q()[i] = size * std::cos(phase);
      z.p()[i] = size * std::sin(phase);
    }
    return z;
  }

 private:
  // ψ² = u + 2iv
  static double u(const Ranks::Site& at) { return at.q * at.q - at.p * at.p; }
  static double v(const Ranks::Site& at) { return at.q * at.p; }

  const Ranks* ranks_;
  std::int64_t begin_;
  systems::NlsLattice<double> lattice_;
};

}  // namespace examples
