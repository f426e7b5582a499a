#pragma once

#include <cmath>

#include <semiexplicit/core/report.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/systems/kepler_flow.hpp>
#include <semiexplicit/systems/orbits.hpp>

namespace semiexplicit::effects::orbits {

namespace detail {

/// A vector turned by -ωt about the third axis, as the axes turn by ωt. What it moves by, so that a small turn has no rounding
/// error of the vector: cos - 1 comes from the sine of the half angle.
template <class Scalar>
class FrameTurn {
 public:
  FrameTurn(const Scalar& omega, const Scalar& t) {
    using std::cos;
    using std::sin;
    const Scalar half = omega * t / 2, s = sin(half);
    sine_ = 2 * s * cos(half);
    less_ = 2 * s * s;
  }
  /// dx becomes (turned x) - x; the third entry, if there is one, 0.
  template <int Dim>
  void increments(const auto& x, auto& dx) const {
    const Scalar x0 = x[0], x1 = x[1];
    dx[0] = sine_ * x1 - less_ * x0;
    dx[1] = -sine_ * x0 - less_ * x1;
    if constexpr (Dim == 3) dx[2] = 0;
  }
  /// dx becomes turned (x + dx) - x.
  template <int Dim>
  void after(const auto& x, auto& dx) const {
    const Scalar x0 = x[0] + dx[0], x1 = x[1] + dx[1];
    dx[0] += sine_ * x1 - less_ * x0;
    dx[1] -= sine_ * x0 + less_ * x1;
  }

 private:
  Scalar sine_, less_;
};

}  // namespace detail

/// Free motion seen from a turning frame, the exact flow of Kinetic + RotatingFrame: q + t p and p, turned by -ωt.
template <class Scalar = double, int Dim = 2>
struct RotatingFlow {
  Scalar omega = Scalar(1);  ///< radians/time

  /// Writes what q and p move by in the time t.
  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const detail::FrameTurn<Scalar> turn(omega, t);
    for (int i = 0; i < Dim; ++i) dq[i] = t * p[i];
    turn.template after<Dim>(q, dq);
    turn.template increments<Dim>(p, dp);
    return Status::success;
  }
};

/// Kepler's motion seen from a turning frame, the exact flow of Kinetic + Attraction + RotatingFrame. See KeplerFlow.
template <class Scalar = double, int Dim = 2>
struct RotatingKeplerFlow {
  KeplerFlow<Scalar, Dim> kepler;
  Scalar omega = Scalar(1);  ///< radians/time

  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    const Status status = kepler.increments(t, q, p, dq, dp);
    const detail::FrameTurn<Scalar> turn(omega, t);
    turn.template after<Dim>(q, dq);
    turn.template after<Dim>(p, dp);
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
  static constexpr bool rest_is_small = false;
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
  ExactFlow(const effects::orbits::Kinetic<Scalar, Dim>&,
            const effects::orbits::Attraction<Scalar, Dim>& attraction,
            const effects::orbits::RotatingFrame<Scalar, Dim>& frame)
      : effects::orbits::RotatingKeplerFlow<Scalar, Dim>{{attraction.gm}, frame.omega} {}
};

}  // namespace semiexplicit
