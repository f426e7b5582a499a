#pragma once

#include <cmath>

#include <semiexplicit/core/report.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/systems/kepler_flow.hpp>
#include <semiexplicit/systems/orbits.hpp>

namespace semiexplicit::effects::orbits {

namespace detail {

/// Positions and momenta turned by -ωt about the third axis, as the axes turn by ωt: by three shears, and the
/// momenta by the inverse transposed ones. Whatever their coefficients were rounded to, that is a symplectic
/// map, so the same rounding error in every step of a run makes no drift.
template <class Scalar>
class FrameTurn {
 public:
  FrameTurn() = default;
  FrameTurn(const Scalar& omega, const Scalar& t) {
    using std::cos;
    using std::floor;
    using std::sin;
    using std::tan;
    Scalar angle = omega * t;
    const Scalar pi = two_pi<Scalar>() / 2, halves = floor(angle / pi + Scalar(0.5));
    if (halves != 0) angle -= halves * pi;  // |angle| <= pi/2, where the tangent is at most 1
    opposite_ = halves - 2 * floor(halves / 2) != 0;
    outer_ = tan(angle / 2);
    inner_ = -sin(angle);
  }
  /// dq becomes turned (q + dq) - q, and dp likewise.
  template <int Dim>
  SEMIEXPLICIT_INLINE void after(const auto& q, const auto& p, auto& dq, auto& dp) const {
    turn(q[0], q[1], dq[0], dq[1], outer_, inner_);
    turn(p[1], p[0], dp[1], dp[0], Scalar(-outer_), Scalar(-inner_));
  }

 private:
  SEMIEXPLICIT_INLINE void turn(const Scalar& x0, const Scalar& y0, Scalar& dx, Scalar& dy,
                                const Scalar& outer, const Scalar& inner) const {
    const Scalar x = x0 + dx, y = y0 + dy, by_y = inner * (x + outer * y);
    const Scalar by_x = outer * (y + (y + by_y));
    dx += by_x;
    dy += by_y;
    if (opposite_) {
      dx = -(x0 + x0) - dx;
      dy = -(y0 + y0) - dy;
    }
  }

  Scalar outer_{}, inner_{};
  bool opposite_ = false;
};

}  // namespace detail

/// Free motion seen from a turning frame, the exact flow of Kinetic + RotatingFrame: q + t p and p, turned by
/// -ωt.
template <class Scalar = double, int Dim = 2>
struct RotatingFlow {
  Scalar omega = Scalar(1);  ///< radians/time

  /// The flow of a time t, with its sine and tangent.
  struct Prepared {
    Scalar t{};
    detail::FrameTurn<Scalar> turn{};

    SEMIEXPLICIT_INLINE Status increments(const auto& q, const auto& p, auto& dq, auto& dp) const {
      for (int i = 0; i < Dim; ++i) {
        dq[i] = t * p[i];
        dp[i] = Scalar(0);
      }
      turn.template after<Dim>(q, p, dq, dp);
      return Status::success;
    }
  };
  Prepared prepared(const Scalar& t) const { return {t, {omega, t}}; }

  /// Writes what q and p move by in the time t.
  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    return prepared(t).increments(q, p, dq, dp);
  }
};

/// Kepler's motion seen from a turning frame, the exact flow of Kinetic + Attraction + RotatingFrame. See
/// KeplerFlow.
template <class Scalar = double, int Dim = 2>
struct RotatingKeplerFlow {
  KeplerFlow<Scalar, Dim> kepler;
  Scalar omega = Scalar(1);  ///< radians/time

  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const Status status = kepler.increments(t, q, p, dq, dp);
    const detail::FrameTurn<Scalar> turn(omega, t);
    turn.template after<Dim>(q, p, dq, dp);
    return status;
  }
};

}  // namespace semiexplicit::effects::orbits

namespace semiexplicit {

/// See RotatingFlow. What it is used with, a potential, need not be small.
template <class Scalar, int Dim>
struct ExactFlow<effects::orbits::Kinetic<Scalar, Dim>, effects::orbits::RotatingFrame<Scalar, Dim>>
    : effects::orbits::RotatingFlow<Scalar, Dim> {
  static constexpr const char* name = "free motion in a turning frame";
  static constexpr bool rest_is_small = false, quadratic_in_momenta = true;
  ExactFlow(const effects::orbits::Kinetic<Scalar, Dim>&,
            const effects::orbits::RotatingFrame<Scalar, Dim>& frame)
      : effects::orbits::RotatingFlow<Scalar, Dim>{frame.omega} {}
};

/// See RotatingKeplerFlow.
template <class Scalar, int Dim>
struct ExactFlow<effects::orbits::Kinetic<Scalar, Dim>, effects::orbits::Attraction<Scalar, Dim>,
                 effects::orbits::RotatingFrame<Scalar, Dim>>
    : effects::orbits::RotatingKeplerFlow<Scalar, Dim> {
  static constexpr const char* name = "Kepler in a turning frame";
  static constexpr bool quadratic_in_momenta = true;
  ExactFlow(const effects::orbits::Kinetic<Scalar, Dim>&,
            const effects::orbits::Attraction<Scalar, Dim>& attraction,
            const effects::orbits::RotatingFrame<Scalar, Dim>& frame)
      : effects::orbits::RotatingKeplerFlow<Scalar, Dim>{{attraction.gm}, frame.omega} {}
};

}  // namespace semiexplicit
