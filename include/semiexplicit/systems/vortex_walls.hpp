#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <semiexplicit/systems/vortices.hpp>

/// Walls that point vortices cannot cross, by the method of images: the Kirchhoff-Routh function without the
/// pairs themselves, which are vortices::Pairs. All vortices must start on the wet side of the wall; it is
/// not looked after.
///
/// Source: P. Newton, The N-Vortex Problem (2001), section 3.2; P. Saffman, Vortex Dynamics (1992),
/// section 7.
namespace semiexplicit::effects::vortices {

namespace detail {

/// A sum over images, 1/(4π) Σ_{i,j} ΓᵢΓⱼ log √w(zᵢ, zⱼ), where w is the wall's symmetric function of two
/// places.
template <class Wall, class Scalar, int N>
class Images {
 public:
  using Acts = OnBoth<Scalar, N>;

  Images(Circulations<Scalar, N> circulations, Wall wall)
      : c_(std::move(circulations)), wall_(std::move(wall)) {}
  Eigen::Index dof() const { return c_.size(); }
  std::vector<double> scene_constants() const { return c_.values(); }

  Scalar energy(const auto& q, const auto& p) const {
    using std::log;
    Scalar sum(0);
    for (Eigen::Index i = 0; i < dof(); ++i)
      for (Eigen::Index j = 0; j <= i; ++j) {
        const Scalar w = wall_.value(q[i] * c_.x_per_q[i], p[i] * c_.y_per_p[i], q[j] * c_.x_per_q[j],
                                     p[j] * c_.y_per_p[j]);
        sum += (i == j ? 1 : 2) * c_.gamma[i] * c_.gamma[j] * log(w);
      }
    return sum / (8 * pi<Scalar>());
  }

  // As w is symmetric, the two places of a pair give the same, and i = j gives twice its first half.
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const auto &sx = c_.x_per_q, &sy = c_.y_per_p;
    for (Eigen::Index i = 0; i < dof(); ++i) {
      const auto xi = q[i] * sx[i], yi = p[i] * sy[i];
      auto sum_x = xi - xi, sum_y = sum_x;
      for (Eigen::Index j = 0; j < dof(); ++j) {
        const auto xj = q[j] * sx[j], yj = p[j] * sy[j];
        const auto weight = c_.gamma[j] / wall_.value(xi, yi, xj, yj);
        sum_x += weight * wall_.by_x(xi, yi, xj, yj);
        sum_y += weight * wall_.by_y(xi, yi, xj, yj);
      }
      const Scalar factor = c_.gamma[i] * quarter_pi_inverse_;
      dHdq[i] += factor * sx[i] * sum_x;
      dHdp[i] += factor * sy[i] * sum_y;
    }
  }

 private:
  Circulations<Scalar, N> c_;
  Wall wall_;
  Scalar quarter_pi_inverse_ = 1 / (4 * pi<Scalar>());
};

/// w for the wall y = 0: the squared distance of z from the image of w.
struct FlatWall {
  static auto value(const auto& x, const auto& y, const auto& u, const auto& v) {
    return (x - u) * (x - u) + (y + v) * (y + v);
  }
  static auto by_x(const auto& x, const auto&, const auto& u, const auto&) { return 2 * (x - u); }
  static auto by_y(const auto&, const auto& y, const auto&, const auto& v) { return 2 * (y + v); }
};

/// w for the wall |z| = R: |R² - z w̄|² = R² |z - w|² + (R² - |z|²) (R² - |w|²).
template <class Scalar>
struct RoundWall {
  Scalar r2;  ///< R²
  auto value(const auto& x, const auto& y, const auto& u, const auto& v) const {
    return r2 * ((x - u) * (x - u) + (y - v) * (y - v)) + inside(x, y) * inside(u, v);
  }
  auto by_x(const auto& x, const auto&, const auto& u, const auto& v) const {
    return 2 * (r2 * (x - u) - x * inside(u, v));
  }
  auto by_y(const auto&, const auto& y, const auto& u, const auto& v) const {
    return 2 * (r2 * (y - v) - y * inside(u, v));
  }
  auto inside(const auto& x, const auto& y) const { return r2 - x * x - y * y; }  // small near the wall
};

}  // namespace detail

/// A straight wall along y = 0, the fluid above. A vortex at height d moves along it at Γ/(4πd).
template <class Scalar = double, int N = Eigen::Dynamic>
struct HalfPlane : detail::Images<detail::FlatWall, Scalar, N> {
  static constexpr const char* name = "half_plane";
  static constexpr const char* about = "a wall along y = 0, the fluid above";
  explicit HalfPlane(Circulations<Scalar, N> circulations)
      : detail::Images<detail::FlatWall, Scalar, N>(std::move(circulations), {}) {}
};

template <class Scalar, int N>
HalfPlane(Circulations<Scalar, N>) -> HalfPlane<Scalar, N>;

/// A round wall of radius R about the origin, the fluid inside. A vortex at r turns about the centre at
/// Γ/(2π(R² - r²)).
template <class Scalar = double, int N = Eigen::Dynamic>
struct Disk : detail::Images<detail::RoundWall<Scalar>, Scalar, N> {
  static constexpr const char* name = "disk";
  static constexpr const char* about = "a round wall about the origin, the fluid inside";
  /// `radius` in the unit of length of the positions. Throws std::invalid_argument unless it is positive and
  /// finite.
  Disk(Circulations<Scalar, N> circulations, Scalar radius)
      : detail::Images<detail::RoundWall<Scalar>, Scalar, N>(std::move(circulations), {radius * radius}) {
    using std::isfinite;
    if (!(radius > 0) || !isfinite(radius))
      throw std::invalid_argument("Disk: the radius is not positive and finite; give the wall's");
  }
};

template <class Scalar, int N, class Number>
Disk(Circulations<Scalar, N>, Number) -> Disk<Scalar, N>;

}  // namespace semiexplicit::effects::vortices
