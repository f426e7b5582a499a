#pragma once

#include <cmath>
#include <limits>
#include <stdexcept>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/systems/relativistic_charges.hpp>

namespace semiexplicit::effects::charges {

/// The line along which ChargeAlongPath measures the path, and what its clock is compared with.
template <class Scalar = double>
struct ReferenceLine {
  Scalar curvature = Scalar(0);  ///< 1/radius; above 0 the line bends away from the first axis, to negative x
  Scalar beta = Scalar(1);       ///< v/c of the clock that q[2] is measured against; Inf: q[2] is ct itself
};

/// A charge at any speed with the path s along a line as the independent variable, as accelerators are
/// computed: exact, not paraxial. A Hamiltonian for Autonomous, with s in the place of the time,
///
///     K(s; q, p) = -(1 + κx) [eA_s + π_s] - p_l/β,   π_s = √(w(w + 2mc) - π_x² - π_y²),
///     q = (x, y, l),  l = ct - s/β,        p = (p_x, p_y, p_l),  p_l = -H/c,
///
/// where H, A and t are those of RelativisticCharge, without the rest energy, π = p - eA is the kinetic
/// momentum, and cw = H - eφ the kinetic energy. All of q are lengths and all of p momenta. l is how far the
/// charge is behind a clock that moves along the line at βc, by default behind light. With β near the speed
/// of the charge it does not grow as t does, which at a late time takes digits from the state; and with β = 1
/// it is found to all its digits, however near that of light the speed is.
///
///     const charges::ChargeAlongPath line(e, m, c, charges::ReferenceLine<>{}, quadrupole);
///     const Autonomous K(line);
///     const auto [s, z] = line.on_line({.t = 0, .q = {1e-3, 0, 0}, .momentum = {0, 0, 10}});
///     auto Z = K.extended(z, s);
///     integrate(stepper, Z, {.dt = 0.01, .t0 = s, .t_end = 2});
///     const auto [t, q, momentum] = line.at_time(K.time(Z), K.point(Z));
///
/// Fields are those of RelativisticCharge, as functions of (x, y, s) and, if driven, of t. Where the line is
/// curved, A has its components along the three axes at s, which are unit vectors: A_s is A times the
/// tangent, without the factor 1 + κx, and
///
///     (1 + κx) B_y = ∂A_x/∂s - ∂[(1 + κx) A_s]/∂x.
///
/// BendField is made for it; most others are fields without currents along a straight line only. At s = 0 the
/// axes are those of Cartesian coordinates, and there the line runs along the third.
///
/// No component of p jumps where a magnet with a hard edge begins whose A has only the component A_s, as
/// QuadrupoleField and BendField: a run to the edge with one Hamiltonian goes on behind it with another.
///
/// The charge has to move on along the line. Where it has no kinetic energy left, or none along the line
/// because it turns round, or is beyond the centre of curvature, energy and gradient are NaN, and the step
/// that would go there fails with Status::not_finite.
///
/// Sources: E. Courant and H. Snyder, Ann. Phys. 3 (1958) 1; S. Y. Lee, Accelerator Physics, 3rd ed. (2012),
/// section 2.I.
template <class ScalarType, class... Fields>
class ChargeAlongPath {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = 3;
  using Column = Vector<Scalar, 3>;

  /// Throws std::invalid_argument unless beta is above 0, and the curvature finite and that of each
  /// BendField.
  ChargeAlongPath(Scalar charge, Scalar mass, Scalar c, ReferenceLine<Scalar> line, Fields... fields)
      : charge_(charge),
        rest_(mass * c),
        c_(c),
        curvature_(line.curvature),
        clock_(Scalar(1) / line.beta),
        relativity_{mass, c},
        fields_(line.curvature, std::move(fields)...) {
    using std::isfinite;
    if (!(line.beta > Scalar(0)) || !isfinite(line.curvature))
      throw std::invalid_argument(
          "ChargeAlongPath: the line has a beta that is not above 0, or a curvature that is not finite");
  }

  /// K, to all its digits for charges that are nearly as fast as light and β = 1.
  Scalar energy(const Scalar& s, const In<Scalar, 3>& q, const In<Scalar, 3>& p) const {
    const Motion m = motion(s, q, p);
    const Scalar behind = (m.across_square() - 2 * (rest_ * m.inverse) * (m.w * m.inverse)) /
                          ((m.w + m.along) * m.inverse) / m.inverse;  // w - π_s
    return behind - curvature_ * q[0] * m.along - m.stretch * charge_ * m.a[2] + m.electric / c_ +
           (Scalar(1) - clock_) * p[2];
  }
  /// Returns ∂K/∂s.
  Scalar gradient(const Scalar& s, const In<Scalar, 3>& q, const In<Scalar, 3>& p, Out<Scalar, 3> dKdq,
                  Out<Scalar, 3> dKdp) const {
    const Motion m = motion(s, q, p);
    const Column slopes(m.across[0] / m.along, m.across[1] / m.along, Scalar(1));  // velocity over that along
    // ∂K/∂(x, y, s) through the fields, and ∂K/∂t
    const Scalar factor = -charge_ * m.stretch;
    Column by_place(Scalar(0), Scalar(0), Scalar(0));
    if constexpr (AllFields::has_electric) {
      fields_.add_electric_gradient(m.place, by_place);
      by_place *= m.stretch * (m.w + rest_) / (c_ * m.along);
    }
    fields_.add_gradient(m.t, m.place, slopes, factor, by_place);
    const Scalar by_time = factor * fields_.time_derivative(m.t, m.place, slopes);

    dKdq[0] = by_place[0] - curvature_ * (charge_ * m.a[2] + m.along);
    dKdq[1] = by_place[1];
    dKdq[2] = by_time / c_;
    dKdp[0] = m.stretch * slopes[0];
    dKdp[1] = m.stretch * slopes[1];
    // (1 + κx) E/(cπ_s) - 1/β, E with the rest energy
    const Scalar rest = rest_ * m.inverse, along = m.along * m.inverse;
    const Scalar behind = (rest * rest + m.across_square()) / (along * (along + 1));
    dKdp[2] = m.stretch * behind + curvature_ * q[0] + (Scalar(1) - clock_);
    return by_place[2] + clock_ / c_ * by_time;
  }

  /// The time at which the charge is at s.
  Scalar time(const Scalar& s, const auto& q) const { return (q[2] + clock_ * s) / c_; }
  /// The kinetic momentum γmv in its components along the three axes at s.
  Column kinetic(const Scalar& s, const auto& q, const auto& p) const {
    const Motion m = motion(s, q, p);
    return {m.across[0], m.across[1], m.along};
  }
  Scalar gamma(const Scalar& s, const auto& q, const auto& p) const {
    return Scalar(1) + motion(s, q, p).w / rest_;
  }

  /// A charge at a time: its position and its kinetic momentum γmv in Cartesian coordinates.
  /// RelativisticCharge has momentum() and kinetic() to go from this to its canonical momentum and back.
  struct AtTime {
    Scalar t;
    Column q, momentum;
  };
  /// The same charge where it is at s.
  struct OnLine {
    Scalar s;
    PhasePoint<Scalar, 3> z;
  };

  /// What this class calls the state of a charge at a time. Of a curved line s is in the half turn before or
  /// behind s = 0. Throws std::invalid_argument where the charge does not move on along the line.
  OnLine on_line(const AtTime& charge) const {
    using std::atan2;
    using std::hypot;
    const Column &q = charge.q, &momentum = charge.momentum;
    const Scalar aside = 1 + curvature_ * q[0], ahead = curvature_ * q[2], radius = hypot(aside, ahead);
    const Scalar cosine = aside / radius, sine = ahead / radius;
    const Column place((2 * q[0] + curvature_ * (q[0] * q[0] + q[2] * q[2])) / (1 + radius), q[1],
                       curvature_ == Scalar(0) ? q[2] : Scalar(atan2(ahead, aside) / curvature_));
    const Scalar across = cosine * momentum[0] + sine * momentum[2];
    if (!(cosine * momentum[2] - sine * momentum[0] > Scalar(0)))
      throw std::invalid_argument(
          "ChargeAlongPath: the charge does not move on along the line; turn the line round, or take the "
          "time as the independent variable");
    const Column a = fields_.potential(charge.t, place);
    const Scalar kinetic = relativity_.energy(momentum) + fields_.electric_energy(place);
    return {place[2],
            {{place[0], place[1], c_ * charge.t - clock_ * place[2]},
             {across + charge_ * a[0], momentum[1] + charge_ * a[1], -kinetic / c_}}};
  }
  /// The reverse. The momentum is NaN where there is no state.
  AtTime at_time(const Scalar& s, const PhasePoint<Scalar, 3>& z) const {
    using std::cos;
    using std::sin;
    const Scalar angle = curvature_ * s, cosine = cos(angle), sine = sin(angle), half = sin(angle / 2);
    const bool straight = curvature_ == Scalar(0);
    const Scalar sag = straight ? Scalar(0) : Scalar(2 * half * half / curvature_);
    const Scalar chord = straight ? s : Scalar(sine / curvature_);
    const Scalar x = z.q()[0];
    const Column of_motion = kinetic(s, z.q(), z.p());
    return {time(s, z.q()),
            {x * cosine - sag, z.q()[1], x * sine + chord},
            {of_motion[0] * cosine - of_motion[2] * sine, of_motion[1],
             of_motion[0] * sine + of_motion[2] * cosine}};
  }

 private:
  using AllFields = detail::FieldsInTime<Scalar, Fields...>;

  /// What energy and gradient are made of.
  struct Motion {
    Scalar t, stretch, electric;  ///< time, 1 + κx, eφ
    Column place, a;              ///< (x, y, s), A
    Scalar w, along;              ///< kinetic energy/c, π_s
    Scalar inverse;  ///< of all energy/c: what is squared is over that, as p² is nothing in SI and float
    Vector<Scalar, 2> across;  ///< π_x, π_y

    /// Over the square of all energy/c.
    Scalar across_square() const {
      const Scalar x = across[0] * inverse, y = across[1] * inverse;
      return x * x + y * y;
    }
  };
  Motion motion(const Scalar& s, const auto& q, const auto& p) const {
    using std::sqrt;
    Motion m;
    m.t = time(s, q);
    m.stretch = 1 + curvature_ * q[0];
    m.place = Column(q[0], q[1], s);
    m.electric = fields_.electric_energy(m.place);
    m.a = fields_.potential(m.t, m.place);
    m.across = {p[0] - charge_ * m.a[0], p[1] - charge_ * m.a[1]};
    m.w = -p[2] - m.electric / c_;
    m.inverse = 1 / (m.w + rest_);
    // The square is also positive for energies below -mc², which no charge has.
    m.along = m.w > Scalar(0) && m.stretch > Scalar(0)
                  ? Scalar(sqrt((m.w * m.inverse) * ((m.w + 2 * rest_) * m.inverse) - m.across_square()) /
                           m.inverse)
                  : std::numeric_limits<Scalar>::quiet_NaN();
    return m;
  }

  Scalar charge_, rest_, c_, curvature_, clock_;  ///< e, mc, c, κ, 1/β
  detail::Relativity<Scalar> relativity_;
  AllFields fields_;
};

}  // namespace semiexplicit::effects::charges
