#pragma once

#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/words.hpp>
#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/detail/over_cube.hpp>

/// Effects on any number of bodies that attract each other, in Jacobi coordinates: body 1 relative to body 0,
/// body 2 to the centre of mass of 0 and 1, and so on. q holds these positions one behind the other, p the
/// momenta that belong to them; the centre of mass rests and is left out, so that n bodies have 3(n - 1)
/// degrees of freedom. Masses are given as GM, and all energies are G times those of mechanics; any
/// consistent units: au, year and GM = 4π², say.
///
/// Kinetic + Attraction is Kepler's motion of each body about those within, and has an exact flow
/// (nbody_flow.hpp); Interaction is the rest of Newton's attraction, smaller by the ratio of the masses.
///
/// Sources: J. Wisdom and M. Holman, Astron. J. 102 (1991) 1528; H. Rein and D. Tamayo, MNRAS 452 (2015) 376.
namespace semiexplicit::effects::nbody {

/// Bodies from the innermost (the primary) outwards.
template <class Scalar = double>
class Bodies {
  static_assert(!std::is_integral_v<Scalar>, "masses of whole numbers: write 1.0 for 1");

 public:
  using Vectors = std::vector<Vector<Scalar, 3>>;  ///< one column a body

  /// G times the masses. Throws std::invalid_argument unless there are two at least and all are positive.
  explicit Bodies(const std::vector<Scalar>& gm) {
    if (gm.size() < 2) throw std::invalid_argument("Bodies: give the GM of two bodies at least");
    Scalar sum(0);
    for (const Scalar& mass : gm) {
      if (!(mass > 0) || !(mass - mass == 0))
        throw std::invalid_argument("Bodies: GM of body " + std::to_string(bodies_.size()) +
                                    " is not positive; give a small one to a body that does not attract");
      const Scalar within = sum;
      sum += mass;
      bodies_.push_back({mass, sum, mass * (within / sum), mass / sum});
    }
  }

  bool operator==(const Bodies&) const = default;

  Eigen::Index size() const { return static_cast<Eigen::Index>(bodies_.size()); }
  /// 0 where they were moved from.
  Eigen::Index dof() const { return bodies_.empty() ? 0 : 3 * (size() - 1); }
  /// Of body i; of it and those within; its reduced mass beside those within (0 for the primary); its share
  /// of the mass of it and those within.
  const Scalar& gm(Eigen::Index i) const { return at(i).gm; }
  const Scalar& up_to(Eigen::Index i) const { return at(i).up_to; }
  const Scalar& reduced(Eigen::Index i) const { return at(i).reduced; }
  const Scalar& share(Eigen::Index i) const { return at(i).share; }
  /// GM of all, which effects of one scene have to agree on.
  std::vector<double> masses() const {
    std::vector<double> all;
    for (const Body& body : bodies_) all.push_back(static_cast<double>(body.gm));
    return all;
  }

  /// The state of bodies with these positions and velocities in any inertial frame. Throws
  /// std::invalid_argument for another number of them.
  PhasePoint<Scalar, Eigen::Dynamic> jacobi(const Vectors& positions, const Vectors& velocities) const {
    if (positions.size() != bodies_.size() || velocities.size() != bodies_.size())
      throw std::invalid_argument("Bodies: give a position and a velocity for each of the " +
                                  std::to_string(bodies_.size()) + " bodies");
    PhasePoint<Scalar, Eigen::Dynamic> z(dof());
    Vector<Scalar, 3> r = positions[0], v = velocities[0];  // of the centre of mass of those within
    for (Eigen::Index i = 1; i < size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const Vector<Scalar, 3> x = positions[k] - r, w = velocities[k] - v;
      z.q().template segment<3>(3 * (i - 1)) = x;
      z.p().template segment<3>(3 * (i - 1)) = reduced(i) * w;
      r += share(i) * x;
      v += share(i) * w;
    }
    return z;
  }

  /// Positions of all bodies about their centre of mass. Throws std::invalid_argument for those of another
  /// number of bodies, as velocities().
  Vectors positions(const auto& q) const {
    semiexplicit::detail::require_same_dof("Bodies", q.size(), "bodies", dof(),
                                           "give q and p of as many bodies");
    return about_centre(
        [&](Eigen::Index i) { return Vector<Scalar, 3>(q[3 * i - 3], q[3 * i - 2], q[3 * i - 1]); });
  }
  /// Momenta per mass of all bodies; in Newton's limit their velocities.
  Vectors velocities(const auto& p) const {
    semiexplicit::detail::require_same_dof("Bodies", p.size(), "bodies", dof(),
                                           "give q and p of as many bodies");
    return about_centre([&](Eigen::Index i) {
      return Vector<Scalar, 3>(Vector<Scalar, 3>(p[3 * i - 3], p[3 * i - 2], p[3 * i - 1]) / reduced(i));
    });
  }

 private:
  struct Body {
    Scalar gm, up_to, reduced, share;
    bool operator==(const Body&) const = default;
  };
  const Body& at(Eigen::Index i) const { return bodies_[static_cast<std::size_t>(i)]; }

  template <class Of>
  Vectors about_centre(const Of& jacobi_vector) const {
    Vectors all(bodies_.size());
    Vector<Scalar, 3> centre(Scalar(0), Scalar(0), Scalar(0));
    for (Eigen::Index i = size() - 1; i > 0; --i) {
      const Vector<Scalar, 3> x = jacobi_vector(i);
      centre -= share(i) * x;  // of those within
      all[static_cast<std::size_t>(i)] = centre + x;
    }
    all[0] = centre;
    return all;
  }

  std::vector<Body> bodies_;
};

namespace detail {

template <class X>
using NumberIn = std::remove_cvref_t<decltype(std::declval<const X&>()[0])>;
/// A vector, in numbers of any type.
template <class Number>
struct Triple {
  Number of[3];
  Number& operator[](Eigen::Index i) { return of[i]; }
  const Number& operator[](Eigen::Index i) const { return of[i]; }
};

template <class Number>
auto dot(const Triple<Number>& x, const Triple<Number>& y) {
  return x[0] * y[0] + x[1] * y[1] + x[2] * y[2];
}

/// Columns of Jacobi vectors: the i-th one, of body i from 1 on.
template <class X>
Triple<NumberIn<X>> triple(const X& x, Eigen::Index i) {
  return {x[3 * i - 3], x[3 * i - 2], x[3 * i - 1]};
}

/// Calls use(j, k, d) for all pairs of bodies j < k, with d from j to k, and after those of a k end(k). The
/// sums go on from pair to pair, so that nothing is stored.
template <class Scalar, class X, class Use, class End>
void for_each_pair(const Bodies<Scalar>& bodies, const X& x, const Use& use, const End& end) {
  using Number = NumberIn<X>;
  Triple<Number> all{Number(0), Number(0), Number(0)};  // from the primary to the centre of those within k
  for (Eigen::Index k = 1; k < bodies.size(); ++k) {
    const Triple<Number> at = triple(x, k);
    Triple<Number> sum{all};  // from where body j's vector begins to the centre of those within k
    use(Eigen::Index(0), k, Triple<Number>{at[0] + sum[0], at[1] + sum[1], at[2] + sum[2]});
    for (Eigen::Index j = 1; j < k; ++j) {
      const Triple<Number> other = triple(x, j);
      use(j, k,
          Triple<Number>{at[0] + (sum[0] - other[0]), at[1] + (sum[1] - other[1]),
                         at[2] + (sum[2] - other[2])});
      for (Eigen::Index i = 0; i < 3; ++i) sum[i] -= bodies.share(j) * other[i];
    }
    end(k);
    for (Eigen::Index i = 0; i < 3; ++i) all[i] += bodies.share(k) * at[i];
  }
}

/// Adds the gradient of a sum over pairs: force(j, k, d) is ∂/∂d of the energy of a pair, as a Triple.
template <class Scalar, class X, class Force>
void add_pair_gradient(const Bodies<Scalar>& bodies, const X& x, auto& out, const Force& force) {
  using Number = NumberIn<X>;
  Triple<Number> sum{Number(0), Number(0), Number(0)};  // of the forces by the bodies up to j on k
  for_each_pair(
      bodies, x,
      [&](Eigen::Index j, Eigen::Index k, const Triple<Number>& d) {
        const Triple<Number> f = force(j, k, d);
        for (Eigen::Index i = 0; i < 3; ++i) {
          sum[i] += f[i];
          if (j > 0) out[3 * j - 3 + i] += bodies.share(j) * sum[i] - f[i];
        }
      },
      [&](Eigen::Index k) {
        for (Eigen::Index i = 0; i < 3; ++i) {
          out[3 * k - 3 + i] += sum[i];
          sum[i] = Number(0);
        }
      });
}

/// m/|x|³ x, the gradient of -m/|x|.
template <class Scalar, class Number>
Triple<Number> attraction(const Scalar& m, const Triple<Number>& x) {
  const Number k = semiexplicit::detail::over_cube(m, dot(x, x));
  return {k * x[0], k * x[1], k * x[2]};
}

/// The attraction of body i by those within, as if these were one mass at their centre: its energy, and the
/// gradient of that.
template <class Scalar, class X>
auto inner_energy(const Bodies<Scalar>& bodies, const X& q, Eigen::Index i) {
  using std::sqrt;
  const auto x = triple(q, i);
  return -(bodies.gm(i) * bodies.up_to(i - 1) / sqrt(dot(x, x)));
}
template <class Scalar, class X>
auto inner_gradient(const Bodies<Scalar>& bodies, const X& q, Eigen::Index i) {
  return attraction(bodies.gm(i) * bodies.up_to(i - 1), triple(q, i));
}

}  // namespace detail

/// Σ p²/(2μ) with the reduced masses of the Jacobi coordinates.
template <class Scalar = double, int Dof = Eigen::Dynamic>
struct Kinetic {
  using Acts = OnMomentum<Scalar, Dof>;
  static constexpr const char* name = "kinetic";
  static constexpr const char* about = "kinetic energy of the bodies about their centre of mass";
  Bodies<Scalar> bodies;

  Eigen::Index dof() const { return bodies.dof(); }
  std::vector<double> scene_constants() const { return bodies.masses(); }
  auto energy(const auto& p) const {
    auto sum = 0 * p[0];
    for (Eigen::Index i = 1; i < bodies.size(); ++i) {
      const auto w = detail::triple(p, i);
      const Scalar m = bodies.reduced(i);  // w² has no room in SI units and float
      sum += (w[0] * (w[0] / m) + w[1] * (w[1] / m) + w[2] * (w[2] / m)) / 2;
    }
    return sum;
  }
  void add_gradient(const auto& p, auto& dHdp) const {
    for (Eigen::Index i = 0; i < bodies.dof(); ++i) dHdp[i] += p[i] / bodies.reduced(1 + i / 3);
  }
};

/// Newton's attraction of each body by those within, as if these were one mass at their centre. Exact for two
/// bodies.
template <class Scalar = double, int Dof = Eigen::Dynamic>
struct Attraction {
  using Acts = OnPosition<Scalar, Dof>;
  static constexpr const char* name = "attraction";
  static constexpr const char* about = "attraction of each body by those within, as one mass";
  Bodies<Scalar> bodies;
  /// The flow refuses bodies that come closer than so many mutual Hill radii, ((m + m')/(3 m₀))^(1/3) (r +
  /// r')/2; 0: never.
  Scalar hill_radii = Scalar(3);

  Eigen::Index dof() const { return bodies.dof(); }
  std::vector<double> scene_constants() const { return bodies.masses(); }
  auto energy(const auto& q) const {
    auto sum = 0 * q[0];
    for (Eigen::Index i = 1; i < bodies.size(); ++i) sum += detail::inner_energy(bodies, q, i);
    return sum;
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    for (Eigen::Index i = 1; i < bodies.size(); ++i) {
      const auto f = detail::inner_gradient(bodies, q, i);
      for (Eigen::Index k = 0; k < 3; ++k) dHdq[3 * i - 3 + k] += f[k];
    }
  }
};

/// What Newton's attraction of all pairs is beyond Attraction. Nothing for two bodies.
template <class Scalar = double, int Dof = Eigen::Dynamic>
struct Interaction {
  using Acts = OnPosition<Scalar, Dof>;
  static constexpr const char* name = "interaction";
  static constexpr const char* about = "attraction of all pairs, beyond that by one mass within";
  Bodies<Scalar> bodies;

  Eigen::Index dof() const { return bodies.dof(); }
  std::vector<double> scene_constants() const { return bodies.masses(); }
  auto energy(const auto& q) const {
    using std::sqrt;
    auto sum = 0 * q[0];
    detail::for_each_pair(
        bodies, q,
        [&](Eigen::Index j, Eigen::Index k, const auto& d) {
          if (k > 1) sum -= bodies.gm(j) * bodies.gm(k) / sqrt(detail::dot(d, d));
        },
        [&](Eigen::Index k) {
          if (k > 1) sum -= detail::inner_energy(bodies, q, k);
        });
    return sum;
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    using Number = detail::NumberIn<std::remove_cvref_t<decltype(q)>>;
    detail::add_pair_gradient(bodies, q, dHdq,
                              [&](Eigen::Index j, Eigen::Index k, const detail::Triple<Number>& d) {
                                if (k == 1) return detail::Triple<Number>{Number(0), Number(0), Number(0)};
                                return detail::attraction(bodies.gm(j) * bodies.gm(k), d);
                              });
    for (Eigen::Index i = 2; i < bodies.size(); ++i) {
      const auto f = detail::inner_gradient(bodies, q, i);
      for (Eigen::Index k = 0; k < 3; ++k) dHdq[3 * i - 3 + k] -= f[k];
    }
  }
};

/// The direction of an axis.
template <class Scalar = double>
class Axis {
  static_assert(!std::is_integral_v<Scalar>, "an axis of whole numbers: write 1.0 for 1");

 public:
  /// From a vector of any length but 0. Throws std::invalid_argument for that, and for NaN and Inf.
  Axis(Scalar x, Scalar y, Scalar z) : n_{x, y, z} {
    using std::abs;
    using std::isfinite;
    const Scalar length = semiexplicit::detail::norm(Vector<Scalar, 3>(x, y, z));
    if (!(length > 0) || !isfinite(length))
      throw std::invalid_argument("Axis: it has no length, or holds NaN or Inf; give any other direction");
    if (abs(length - 1) > 4 * std::numeric_limits<Scalar>::epsilon())
      for (Scalar& part : n_.of) part /= length;
  }
  /// A component of the vector of length 1.
  const Scalar& operator[](Eigen::Index i) const { return n_[i]; }

 private:
  detail::Triple<Scalar> n_;
};

/// The oblateness of the primary as all others feel it: G m₀ m J₂ R²/(2r³) (3 (n·r)²/r² - 1) for each, with r
/// from the primary and n its axis. See orbits::Oblateness.
template <class Scalar = double, int Dof = Eigen::Dynamic>
struct Oblateness {
  using Acts = OnPosition<Scalar, Dof>;
  static constexpr const char* name = "j2";
  static constexpr const char* about = "oblateness of the primary";
  Bodies<Scalar> bodies;
  Scalar j2 = Scalar(0);      ///< a number
  Scalar radius = Scalar(1);  ///< equatorial, that J₂ refers to; length
  Axis<Scalar> axis{Scalar(0), Scalar(0), Scalar(1)};

  Eigen::Index dof() const { return bodies.dof(); }
  std::vector<double> scene_constants() const { return bodies.masses(); }
  auto energy(const auto& q) const {
    auto sum = 0 * q[0];
    detail::for_each_pair(
        bodies, q,
        [&](Eigen::Index j, Eigen::Index k, const auto& d) {
          if (j > 0) return;
          const auto r2 = detail::dot(d, d), along = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
          sum += over_cube(k, r2) * (3 * along * along / r2 - 1);
        },
        [](Eigen::Index) {});
    return sum;
  }
  void add_gradient(const auto& q, auto& dHdq) const {
    using Number = detail::NumberIn<std::remove_cvref_t<decltype(q)>>;
    detail::add_pair_gradient(
        bodies, q, dHdq, [&](Eigen::Index j, Eigen::Index k, const detail::Triple<Number>& d) {
          detail::Triple<Number> f{Number(0), Number(0), Number(0)};
          if (j > 0) return f;
          const Number r2 = detail::dot(d, d), along = d[0] * axis[0] + d[1] * axis[1] + d[2] * axis[2];
          const Number k5 = 3 * over_cube(k, r2) / r2;
          for (Eigen::Index i = 0; i < 3; ++i)
            f[i] = k5 * ((1 - 5 * along * along / r2) * d[i] + 2 * along * axis[i]);
          return f;
        });
  }

 private:
  /// GM₀ GM_k J₂ R²/(2r³); R² last, as it has no room beside the masses in SI units and float.
  auto over_cube(Eigen::Index k, const auto& r2) const {
    const Scalar strength = bodies.gm(0) * bodies.gm(k) * j2 / 2;
    return semiexplicit::detail::over_cube(strength, r2) * radius * radius;
  }
};

}  // namespace semiexplicit::effects::nbody
