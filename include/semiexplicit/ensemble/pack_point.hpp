#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <vector>

#include <semiexplicit/core/pack.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/report.hpp>

#ifdef SEMIEXPLICIT_HAS_PACKS

/// A pack is a number to Eigen, too: columns of packs are what a Hamiltonian of packs takes.
namespace Eigen {
template <class Scalar, class Abi>
struct NumTraits<std::experimental::simd<Scalar, Abi>>
    : GenericNumTraits<std::experimental::simd<Scalar, Abi>> {
  using Real = std::experimental::simd<Scalar, Abi>;
  using NonInteger = Real;
  using Nested = Real;
  using Literal = Scalar;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 1,
    AddCost = 1,
    MulCost = 1
  };
  static Real epsilon() { return NumTraits<Scalar>::epsilon(); }
  static Real dummy_precision() { return NumTraits<Scalar>::dummy_precision(); }
  static Real highest() { return NumTraits<Scalar>::highest(); }
  static Real lowest() { return NumTraits<Scalar>::lowest(); }
  static int digits10() { return NumTraits<Scalar>::digits10(); }
};
}  // namespace Eigen

namespace semiexplicit {

/// As many numbers side by side as a register of the target holds: 8 with AVX-512, 4 with AVX2, 2 with neither. (A Pack
/// always holds eight, in several registers where it must, which g++ 12 copies clumsily.)
template <class Scalar>
using RegisterPack = std::experimental::native_simd<Scalar>;

/// How many phase points are stepped at once.
inline constexpr int pack_width = static_cast<int>(RegisterPack<double>::size());

/// A Hamiltonian whose gradient takes a pack of phase points at once. Either it has a gradient that is a template beside the
/// ordinary one, and says so by `using PackGradientOf = H;` (see HasPackGradient); or it is one of packs altogether, as
/// Pendulum<RegisterPack<double>> of a user's `template <class S> struct Pendulum` with `using Scalar = S;`, whose
/// parameters then may differ from lane to lane.
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

/// A pack of phase points of d degrees of freedom, one a lane: entry i of all of them is the i-th of 2d packs, positions
/// first. With each goes what rounding has cut off its last steps (see CompensatedUpdate).
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

  /// Puts a phase point of the same size into lane k.
  void set_lane(std::size_t k, const PhasePoint<double, Dof>& point) {
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
  /// Takes into lane k what another pack has in its first.
  void take(std::size_t k, const PackPoint& from) {
    for (std::size_t i = 0; i < z.size(); ++i) {
      z[i][k] = double(from.z[i][0]);
      carry[i][k] = double(from.carry[i][0]);
    }
  }

  std::vector<RegisterPack<double>> z, carry;
};

namespace detail {

using Many = RegisterPack<double>;
using LaneMask = Many::mask_type;

/// to = from in the chosen lanes.
inline void assign(const LaneMask& lanes, Many& to, const Many& from) {
#ifdef __clang__  // version 14 with AVX-512 makes nothing, or something else, of libstdc++'s where()
  for (std::size_t k = 0; k < Many::size(); ++k)
    if (lanes[k]) to[k] = double(from[k]);
#else
  where(lanes, to) = from;
#endif
}

/// v · v in each lane, summed in the order of dot().
inline Many squares(const Many* v, Eigen::Index n) {
  Many part[4] = {0.0, 0.0, 0.0, 0.0};
  const Eigen::Index whole = n - n % 4;
  for (Eigen::Index i = 0; i < whole; i += 4)
    for (Eigen::Index k = 0; k < 4; ++k) part[k] += v[i + k] * v[i + k];
  for (Eigen::Index i = whole; i < n; ++i) part[i - whole] += v[i] * v[i];
  return (part[0] + part[1]) + (part[2] + part[3]);
}

/// √x. g++ 12 suspects an uninitialised variable in its own AVX-512 intrinsic.
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wuninitialized"
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#endif
inline Many square_root(const Many& x) { return sqrt(x); }
#if defined(__GNUC__) && !defined(__clang__)
#pragma GCC diagnostic pop
#endif

/// The norms of all lanes, by the operations of the norm of a vector and in their order.
inline Many norm(const Many* v, Eigen::Index n) {
  const Many squared = squares(v, n);
  constexpr double small = std::numeric_limits<double>::min() / std::numeric_limits<double>::epsilon();
  constexpr double large = std::numeric_limits<double>::max() * std::numeric_limits<double>::epsilon();
  const LaneMask plain = (squared >= small && squared <= large) || squared != squared;
  Many result = square_root(squared);
  if (all_of(plain)) return result;
  // Some lane's squares have no room in the exponent.
  Many largest = 0.0;
  for (Eigen::Index i = 0; i < n; ++i) largest = max(largest, abs(v[i]));
  Many unit = largest, part[4] = {0.0, 0.0, 0.0, 0.0};
  assign(largest == 0.0, unit, 1.0);
  const Eigen::Index whole = n - n % 4;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Many scaled = v[i] / unit;
    part[i < whole ? i % 4 : i - whole] += scaled * scaled;
  }
  Many rescaled = largest * square_root((part[0] + part[1]) + (part[2] + part[3]));
  assign(!isfinite(largest), rescaled, largest);
  assign(!plain, result, rescaled);
  return result;
}

}  // namespace detail
}  // namespace semiexplicit

#endif
