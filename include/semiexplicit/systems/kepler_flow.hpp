#pragma once

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/report.hpp>
#include <semiexplicit/scene/exact_flow.hpp>
#include <semiexplicit/systems/orbits.hpp>

namespace semiexplicit::effects::orbits {

namespace detail {

template <class Scalar>
Scalar two_pi() {
  if constexpr (std::is_floating_point_v<Scalar>) {
    return 2 * std::numbers::pi_v<Scalar>;
  } else {
    using std::acos;
    static const Scalar value = 2 * acos(Scalar(-1));
    return value;
  }
}

/// |q × p|²/v², the square of a distance, in any number of dimensions.
template <int Dim, class Scalar>
Scalar square_of_impact(const auto& q, const auto& p, const Scalar& per_v) {
  Scalar sum(0);
  for (int i = 0; i < Dim; ++i)
    for (int j = 0; j < i; ++j) {
      const Scalar b = (q[i] * p[j] - q[j] * p[i]) * per_v;
      sum += b * b;
    }
  return sum;
}

/// Kepler's problem in universal variables. With r₀ = |q|, η₀ = q·p, β = 2GM/r₀ - p² and the functions
///
///     G₁ = sin(√β s)/√β,   G₂ = (1 - cos(√β s))/β,   G₃ = (s - G₁)/β      (β < 0: sinh and cosh),
///
/// the time t and the fictitious time s, ds = dt/r, belong together by t = r₀G₁ + η₀G₂ + GM G₃, which grows
/// with s.
///
/// A body that falls in fast and flies past leaves next to nothing of r₀ + η₀/√-β, on which its way out
/// depends. There r and t come from their growing and falling exponentials,
///
///     r = P eˣ + Q e⁻ˣ + GM/β,   x = √-β s,   4PQ = b² + (GM/β)²,   2Q = r₀ - η₀/√-β - GM/β,
///
/// with the distance b = L/√-β that it would pass the centre by without a force, and with P from the product,
/// where nothing cancels.
///
/// G₁ and G₂ come from the sine and cosine of the half angle, so that their identities hold to a rounding
/// that has no preferred sign. (From a series in double precision the energy drifts linearly, by 1e-16 a
/// call.) G₃ only enters the relation of s and t, where a wrong last digit is one of the time.
template <class Scalar>
class UniversalKepler {
 public:
  /// `root` is the square root of |beta|, `inverse` 1/r0, `impact2` the b² above, which only counts where
  /// beta and eta0 are negative.
  UniversalKepler(const Scalar& gm, const Scalar& r0, const Scalar& inverse, const Scalar& eta0,
                  const Scalar& beta, const Scalar& root, const Scalar& impact2)
      : gm_(gm),
        r0_(r0),
        inverse_(inverse),
        eta0_(eta0),
        beta_(beta),
        zeta_(gm - beta * r0),
        root_(root),
        per_root_(1 / root) {
    if constexpr (std::is_floating_point_v<Scalar>)
      excess_ = std::fma(root, root, beta < 0 ? beta : -beta) * (per_root_ * per_root_ / 2);
    if (beta < 0 && eta0 < 0) {
      const Scalar axis = gm / beta;
      falling_ = (r0 - eta0 * per_root_ - axis) / 2;
      growing_ = (impact2 + axis * axis) / (4 * falling_);
      inward_ = 64 * growing_ < falling_;
    }
  }

  /// Finds s, and the functions of it, for a time t > 0 (of an ellipse: up to half a period). False: not
  /// found, or of no digit after a flyby so close that q does not hold its distance.
  bool solve(const Scalar& t) {
    using std::sqrt;
    const Scalar close = sqrt(epsilon()) / 4;  // a step so small, squared, leaves an error to the fourth
    Scalar s = start(t), low(0), high(0);
    bool bounded = false;
    if (beta_ > 0) {
      high = two_pi<Scalar>() / root_;
      bounded = true;
      if (!(s < high)) s = high / 2;
    }
    for (int i = 0; i < 200; ++i) {
      evaluate(s);
      const Scalar f = time(s) - t;
      const Scalar slope = distance();
      const Scalar bend = passing_ ? Scalar(root_ * (growing_ * power_ - falling_ / power_))
                                   : Scalar(eta0_ * g0_ + zeta_ * g1_);
      const Scalar turn = gm_ - beta_ * slope;
      // A step of fourth order where Newton's is small: its own factor may vanish far from the root. Else
      // Laguerre's, which converges from far away. Ratios first: squares of distances may be infinite.
      const Scalar per_slope = 1 / slope, newton = f * per_slope, bent = newton * bend * per_slope;
      const Scalar size =
          bent * bent +
          newton * newton * ((turn < 0 ? -turn : turn) * per_slope + (beta_ < 0 ? -beta_ : beta_));
      if (size <= close) {
        const Scalar step = reverted_per(-f, per_slope, bend, turn);
        shift(step);
        if (!passing_) return true;
        g3_ = (s + step - g1_) / beta_;
        const Scalar magnified = gm_ * g2_;  // by which the rounding errors of q grow, in new distances
        return (magnified < 0 ? -magnified : magnified) * epsilon() * 16 < distance();
      }
      if (f < 0)
        low = s;
      else {
        high = s;
        bounded = true;
      }
      Scalar next = s + laguerre(f, slope, bend);
      if (bounded) {
        if (!(next > low && next < high) || i > 20) next = (low + high) / 2;
        if (!(next > low && next < high)) {  // two neighbouring numbers
          shift(Scalar(0));
          return f - f == 0;
        }
      } else {
        const Scalar far = s > 0 ? s + s : Scalar(1);
        if (!(next > low && next < 4 * far)) next = far;
      }
      s = next;
    }
    return false;
  }

  /// G₁, G₂, r₀G₁ + η₀G₂ and the new distance, once solve(t) has found them.
  const Scalar& g1() const { return g1_; }
  const Scalar& g2() const { return g2_; }
  Scalar g(const Scalar& t) const { return passing_ ? Scalar(t - gm_ * g3_) : r0_ * g1_ + eta0_ * g2_; }
  Scalar distance() const {
    return passing_ ? Scalar(growing_ * power_ + falling_ / power_ + gm_ / beta_)
                    : r0_ * g0_ + eta0_ * g1_ + gm_ * g2_;
  }

 private:
  Scalar time(const Scalar& s) const {
    if (!passing_) return r0_ * g1_ + eta0_ * g2_ + gm_ * g3_;
    return (growing_ * (power_ - 1) + falling_ * (1 - 1 / power_)) * per_root_ + gm_ / beta_ * s;
  }
  static Scalar epsilon() { return Eigen::NumTraits<Scalar>::epsilon(); }
  /// The root of f + slope x + bend x²/2 + turn x³/6 by the reverted series.
  static SEMIEXPLICIT_INLINE Scalar reverted(const Scalar& f, const Scalar& slope, const Scalar& bend,
                                             const Scalar& turn) {
    return reverted_per(-f, Scalar(1 / slope), bend, turn);
  }
  static SEMIEXPLICIT_INLINE Scalar reverted_per(const Scalar& t, const Scalar& per_slope, const Scalar& bend,
                                                 const Scalar& turn) {
    const Scalar x = t * per_slope, second = bend * per_slope / 2, third = turn * per_slope / 6;
    return x * (1 - x * (second - x * (2 * second * second - third)));
  }
  static SEMIEXPLICIT_NOINLINE Scalar laguerre(const Scalar& f, const Scalar& slope, const Scalar& bend) {
    using std::sqrt;
    const Scalar inner = 16 * slope * slope - 20 * f * bend;
    return -5 * f / (slope + sqrt(inner < 0 ? -inner : inner));
  }

  Scalar start(const Scalar& t) const {
    using std::sqrt;
    const Scalar s = t * inverse_;
    const auto size = [](const Scalar& x) { return x < 0 ? Scalar(-x) : x; };
    if (size(eta0_) * s < r0_ / 2 && size(beta_) * s * s < 1 && size(zeta_) * s * s < r0_ / 2)
      return polished(reverted_per(t, inverse_, eta0_, zeta_), t);
    if (beta_ > 0 && gm_ > 0) return elliptic_start(t);
    const Scalar from_cubic = cubic_start(t, s);
    return size(beta_) * from_cubic * from_cubic < 4 ? from_cubic : hyperbolic_start(t, from_cubic);
  }

  /// One step on the series of t(s) up to the fifth power.
  SEMIEXPLICIT_INLINE Scalar polished(const Scalar& s, const Scalar& t) const {
    const Scalar z = beta_ * s * s;
    const Scalar f = s * (r0_ + s * (eta0_ / 2 * (1 - z / 12) + s * (zeta_ / 6 * (1 - z / 20)))) - t;
    const Scalar slope = r0_ + s * (eta0_ * (1 - z / 6) + s * (zeta_ / 2 * (1 - z / 12)));
    const Scalar bend = eta0_ * (1 - z / 2) + s * zeta_ * (1 - z / 6);
    const Scalar turn = zeta_ - beta_ * s * eta0_ - z * zeta_ / 2;
    return s + reverted(f, slope, bend, turn);
  }

  /// From the eccentric anomaly, M + 0.85 e with a sign (Danby).
  SEMIEXPLICIT_NOINLINE Scalar elliptic_start(const Scalar& t) const {
    using std::cos;
    using std::sin;
    using std::sqrt;
    const Scalar ec = 1 - beta_ * r0_ / gm_, es = eta0_ * root_ / gm_;
    const Scalar m = root_ * beta_ / gm_ * t, y = m - es;
    const Scalar e = sqrt(ec * ec + es * es);
    const Scalar side = es * cos(y) + ec * sin(y);
    const Scalar guess = y + (side < 0 ? -e : e) * Scalar(17) / 20;
    return guess > 0 ? Scalar(guess / root_) : Scalar(m / (2 * root_));
  }

  /// Of the three powers of s in t(s) the one that is reached first.
  SEMIEXPLICIT_NOINLINE Scalar cubic_start(const Scalar& t, const Scalar& linear) const {
    using std::cbrt;
    using std::sqrt;
    Scalar s = linear;
    if (eta0_ > 0) {
      const Scalar quadratic = sqrt(2 * t / eta0_);
      if (quadratic < s) s = quadratic;
    }
    if (gm_ > 0) {
      const Scalar cubic = cbrt(6 * t / gm_);
      if (cubic < s) s = cubic;
    }
    return s;
  }

  /// The growing exponential alone: t = (A + B)/2 e^x - B - Cx with x = √-β s; (A + B)/2 is P/√-β.
  SEMIEXPLICIT_NOINLINE Scalar hyperbolic_start(const Scalar& t, const Scalar& otherwise) const {
    using std::log;
    const Scalar k2 = -beta_, k3 = k2 * root_;
    const Scalar a = (r0_ * k2 + gm_) / k3, b = eta0_ / k2, c = gm_ / k3;
    const Scalar sum = b < 0 ? Scalar(2 * growing_ * per_root_) : Scalar(a + b);
    Scalar x = 0;
    for (int i = 0; i < 2; ++i) {
      const Scalar power = 2 * (t + b + c * x) / sum;
      if (!(power > 1)) break;
      x = log(power);
    }
    return x > 0 ? Scalar(x / root_) : otherwise;
  }

  /// The functions at s.
  SEMIEXPLICIT_INLINE void evaluate(const Scalar& s) {
    using std::cos;
    using std::sin;
    using std::sinh;
    using std::sqrt;
    const Scalar tiny = sqrt(epsilon()) / 2;
    const Scalar quarter = beta_ * s * s / 4, half = s / 2;
    if (quarter > tiny) {
      const Scalar x = root_ * half;
      s1_ = sin(x);
      c1_ = cos(x);
    } else if (quarter < -tiny) {
      s1_ = sinh(root_ * half);
      c1_ = sqrt(1 + s1_ * s1_);
    } else {
      s1_ = half * (1 - quarter / 6);
      c1_ = 1 - quarter / 2;
    }
    narrow_ = quarter <= tiny && quarter >= -tiny;
    double_angle(narrow_ ? s1_ : s1_ * per_root_);
    const bool small = quarter < Scalar(0.25) && quarter > Scalar(-0.25);
    g3_ = small ? s * s * s * c3(4 * quarter) : (s - g1_) / beta_;
    passing_ = inward_ && !small;
    if (passing_) power_ = (c1_ + s1_) * (c1_ + s1_);
  }

  /// sin(√β s/2)/√β. The rounding error of √β would be one of the energy, and the same in every call: it is
  /// taken out before the quotient is rounded.
  SEMIEXPLICIT_INLINE Scalar half_function() const {
    if (narrow_) return s1_;
    const Scalar x = s1_ * per_root_;
    if constexpr (std::is_floating_point_v<Scalar>)
      return x + (std::fma(-x, root_, s1_) + s1_ * excess_) * per_root_;
    else
      return x;
  }

  /// The functions of s from those of s/2; cos - 1 from the sine itself, for the same reason.
  SEMIEXPLICIT_INLINE void double_angle(const Scalar& h1) {
    g1_ = 2 * c1_ * h1;
    g2_ = 2 * h1 * h1;
    g0_ =
        narrow_ ? Scalar(1 - beta_ * g2_) : 1 - (beta_ < 0 ? Scalar(-2 * s1_ * s1_) : Scalar(2 * s1_ * s1_));
  }

  /// (√z - sin √z)/√z³ for |z| < 1.
  static SEMIEXPLICIT_INLINE Scalar c3(const Scalar& z) {
    if constexpr (std::numeric_limits<Scalar>::digits <= 64) {
      constexpr auto term = [](double factorial) { return Scalar(1) / Scalar(factorial); };
      const Scalar z2 = z * z, z4 = z2 * z2;
      return ((term(6) - z * term(120)) + z2 * (term(5040) - z * term(362880))) +
             z4 * (((term(39916800) - z * term(6227020800)) +
                    z2 * (term(1307674368000) - z * term(355687428096000))) +
                   z4 * term(121645100408832000));
    } else {
      Scalar term = Scalar(1) / 6, sum = term;
      for (int k = 4; term + sum != sum && k < 400; k += 2) {
        term *= -z / (k * (k + 1));
        sum += term;
      }
      return sum;
    }
  }

  /// From s to s + step, which is small: by the addition theorem, with the functions of step/2 from their
  /// series.
  SEMIEXPLICIT_INLINE void shift(const Scalar& step) {
    const Scalar half = step / 2, z = beta_ * half * half;
    const Scalar unit = narrow_ ? half : half * root_, sign = narrow_ ? beta_ : Scalar(beta_ < 0 ? -1 : 1);
    const Scalar sine = unit * (1 - z / 6 * (1 - z / 20)),
                 less = z / 2 * (1 - z / 12 * (1 - z / 30));  // 1 - cos
    const Scalar s1 = s1_ + (c1_ * sine - s1_ * less);
    c1_ -= sign * s1_ * sine + c1_ * less;
    s1_ = s1;
    double_angle(half_function());
    if (passing_) power_ = (c1_ + s1_) * (c1_ + s1_);
  }

  Scalar gm_, r0_, inverse_, eta0_, beta_, zeta_, root_, per_root_;
  Scalar excess_{};  ///< by which root_ is too large, relatively
  Scalar s1_{},
      c1_{};  ///< sine and cosine of √β s/2, or sinh and cosh; where that is tiny s/2 and 1 to second order
  bool narrow_ = false;
  Scalar g0_{}, g1_{}, g2_{}, g3_{};
  Scalar growing_{}, falling_{}, power_{};  ///< P, Q and eˣ
  bool inward_ = false;                     ///< P is what is left of a difference
  bool passing_ = false;                    ///< and s so large that it counts
};

}  // namespace detail

/// Kepler's motion about a centre at the origin, the exact flow of Kinetic + Attraction: ellipses, parabolas,
/// hyperbolas, and the orbits of repulsion (GM < 0) and of no force, for times of either sign and of any
/// number of periods. On a straight line through a centre that attracts the body turns back there, which is
/// the limit of narrow ellipses.
///
/// The errors are a few roundings of the orbit's largest q and p, and what roundings of the state do to the
/// orbit (from a periapsis at an eccentricity of 0.98 to 1e5 of them after a period), without a preferred
/// sign: the energy of a million calls walks by some 1e-12 to an eccentricity of 0.5, by up to 1e-10 at 0.9
/// and 1e-9 at 0.99. Where the calls come back to the same few places, after a period or several, the same
/// roundings add up: up to 3e-15 of the energy a call were seen to an eccentricity of 0.8, 5e-15 at 0.9,
/// 3e-13 at 0.99. Of n periods at once the phase has an error of n such roundings. About 0.2 µs a call.
///
/// Sources: E. Stiefel and G. Scheifele, Linear and Regular Celestial Mechanics (1971), section 11; J. Danby,
/// Fundamentals of Celestial Mechanics, 2nd ed., sections 6.8 and 6.9; B. Conway, Celest. Mech. 39 (1986)
/// 199.
template <class Scalar = double, int Dim = 2>
struct KeplerFlow {
  Scalar gm = Scalar(1);  ///< length³/time²

  /// Writes what q and p move by in the time t, as increments (f - 1) q + g p and f' q + (g' - 1) p: a small
  /// step has no rounding error of the state itself. Status::not_finite: from or into the centre;
  /// Status::no_convergence: time and state lie outside of what the number type can hold.
  Status increments(const Scalar& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    using std::floor;
    using std::sqrt;
    if (gm == 0) {  // through the centre, too
      const Scalar sum = detail::dot<Dim>(q, q) + detail::dot<Dim>(p, p) + t;
      if (!(sum - sum == 0)) return Status::not_finite;
      for (int i = 0; i < Dim; ++i) dq[i] = t * p[i], dp[i] = Scalar(0);
      return Status::success;
    }
    const Scalar r0 = sqrt(detail::dot<Dim>(q, q)), eta0 = detail::dot<Dim>(q, p);
    const Scalar inverse = 1 / r0, beta = 2 * gm * inverse - detail::dot<Dim>(p, p);
    const Scalar root = sqrt(beta < 0 ? Scalar(-beta) : beta);
    Scalar rest = t;
    if (beta > 0 && gm > 0) {
      const Scalar rate = beta * root, turn = detail::two_pi<Scalar>() * gm;
      if (rate * t > turn / 2 || rate * t < -turn / 2)
        rest = t - floor(rate * t / turn + Scalar(0.5)) * (turn / rate);
    }
    const Scalar unbounded = rest + inverse + beta + eta0;
    if (!(unbounded - unbounded == 0)) return Status::not_finite;
    const bool back = rest < 0;
    const Scalar eta = back ? Scalar(-eta0) : eta0, ahead = back ? Scalar(-rest) : rest;
    const Scalar impact2 =
        beta < 0 && eta < 0 ? detail::square_of_impact<Dim, Scalar>(q, p, 1 / root) : Scalar(0);
    detail::UniversalKepler<Scalar> kepler(gm, r0, inverse, eta, beta, root, impact2);
    if (!kepler.solve(ahead)) return Status::no_convergence;
    const Scalar g1 = back ? Scalar(-kepler.g1()) : kepler.g1(), g2 = kepler.g2();
    const Scalar f = -gm * g2 * inverse, g = back ? Scalar(-kepler.g(ahead)) : kepler.g(ahead);
    const Scalar per_r = 1 / kepler.distance();
    const Scalar f_dot = -gm * g1 * inverse * per_r, g_dot = -gm * g2 * per_r;
    const Scalar landed = per_r + f + g + f_dot;
    if (!(landed - landed == 0)) return Status::not_finite;
    for (int i = 0; i < Dim; ++i) {
      const Scalar x = q[i], v = p[i];
      dq[i] = f * x + g * v;
      dp[i] = f_dot * x + g_dot * v;
    }
    return Status::success;
  }
};

}  // namespace semiexplicit::effects::orbits

namespace semiexplicit {

/// See KeplerFlow.
template <class Scalar, int Dim>
struct ExactFlow<effects::orbits::Kinetic<Scalar, Dim>, effects::orbits::Attraction<Scalar, Dim>>
    : effects::orbits::KeplerFlow<Scalar, Dim> {
  static constexpr const char* name = "Kepler";
  static constexpr bool quadratic_in_momenta = true;
  ExactFlow(const effects::orbits::Kinetic<Scalar, Dim>&,
            const effects::orbits::Attraction<Scalar, Dim>& attraction)
      : effects::orbits::KeplerFlow<Scalar, Dim>{attraction.gm} {}
};

}  // namespace semiexplicit
