#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/core/simd.hpp>

namespace semiexplicit {

/// How many phase points are stepped at once.
inline constexpr int pack_width = static_cast<int>(RegisterPack<double>::size());

/// A Hamiltonian whose gradient takes a pack of phase points at once. Either it has a gradient that is a
/// template beside the ordinary one, and says so by `using PackGradientOf = H;` (see HasPackGradient); or it
/// is one of packs altogether, as Pendulum<RegisterPack<double>> of a user's `template <class S> struct
/// Pendulum` with `using Scalar = S;`, whose parameters then may differ from lane to lane.
template <class H>
concept PackHamiltonian = HasScalar<H> &&
    ((std::same_as<typename H::Scalar, RegisterPack<double>> && Hamiltonian<H>) ||
     (std::same_as<typename H::Scalar, double> && Hamiltonian<H> &&
      std::same_as<typename H::PackGradientOf, H> &&
      requires(const H& h, const RegisterPack<double>* at, RegisterPack<double>* gradient) {
        h.gradient(at, at, gradient, gradient);  // q, p, dHdq, dHdp
      }));

/// A yes or no for each lane.
using LaneChoice = std::array<bool, static_cast<std::size_t>(pack_width)>;

inline LaneChoice all_lanes() {
  LaneChoice lanes;
  lanes.fill(true);
  return lanes;
}

/// What a step did in each lane.
using PackReport = std::array<StepReport, static_cast<std::size_t>(pack_width)>;

/// A pack of phase points of d degrees of freedom, one a lane: entry i of all of them is the i-th of 2d
/// packs, positions first. With each goes what rounding has cut off its last steps (see CompensatedUpdate).
template <int Dof>
class PackPoint {
 public:
  /// All zeros.
  explicit PackPoint(Eigen::Index dof)
      : z(static_cast<std::size_t>(2 * dof), RegisterPack<double>(0.0)), carry(z) {}

  Eigen::Index dof() const { return static_cast<Eigen::Index>(z.size() / 2); }

  /// The phase point in lane k.
  PhasePoint<double, Dof> lane(std::size_t k) const {
    PhasePoint<double, Dof> point(dof());
    for (std::size_t i = 0; i < z.size(); ++i) point.vector()[static_cast<Eigen::Index>(i)] = z[i][k];
    return point;
  }

  /// Puts a phase point into lane k; throws std::invalid_argument for one of another size.
  void set_lane(std::size_t k, const PhasePoint<double, Dof>& point) {
    detail::require_same_dof("PackPoint", point.dof(), "pack", dof());
    for (std::size_t i = 0; i < z.size(); ++i) {
      z[i][k] = point.vector()[static_cast<Eigen::Index>(i)];
      carry[i][k] = 0;
    }
  }

  /// The point of lane k, with its carry, in all lanes.
  PackPoint alone(std::size_t k) const {
    PackPoint all = *this;
    for (std::size_t i = 0; i < z.size(); ++i) {
      all.z[i] = double(z[i][k]);
      all.carry[i] = double(carry[i][k]);
    }
    return all;
  }
  /// Whether the first lane has a carry, and all lanes without.
  bool has_carry() const {
    for (const auto& x : carry)
      if (x[0] != 0) return true;
    return false;
  }
  void drop_carry() { carry.assign(carry.size(), RegisterPack<double>(0.0)); }
  /// Takes into lane k what another pack has in its first.
  void take(std::size_t k, const PackPoint& from) {
    for (std::size_t i = 0; i < z.size(); ++i) {
      z[i][k] = double(from.z[i][0]);
      carry[i][k] = double(from.carry[i][0]);
    }
  }

  std::vector<RegisterPack<double>> z, carry;
};

}  // namespace semiexplicit
