#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/derivatives/from_energy.hpp>
#include <semiexplicit/systems/orbits.hpp>
#include <semiexplicit/systems/post_newtonian.hpp>

namespace semiexplicit::systems {

/// Two spinning bodies, relative motion and spins, with Newton's attraction, 1PN and the leading coupling of
/// the spins to the orbit:
///
///     H = p²/2 - GM/r + H_1PN + 2GMν/(c²r³) L·(σ₁s₁ + σ₂s₂),   L = q × p,   σ₁ = 1 + 3m₂/(4m₁), σ₂ likewise,
///
/// per reduced mass, in ADM coordinates of the centre of mass. A spin s of given length has the canonical
/// pair (φ, s_z): s = (√(s² - s_z²) cos φ, √(s² - s_z²) sin φ, s_z), so that q = (x, y, z, φ₁, φ₂) and p =
/// (p_x, p_y, p_z, s₁z, s₂z). These fail where a spin points along ±z: turn the axes. The motion keeps L + s₁
/// + s₂, L² and L·(σ₁s₁ + σ₂s₂) and is integrable: no exponent grows.
///
/// Sources: T. Damour, Phys. Rev. D 64 (2001) 124013, the coupling; X. Wu, Y. Xie, Phys. Rev. D 81 (2010)
/// 084045, the spins' coordinates; S. Tanay, L. Stein, J. Gálvez Ghersi, Phys. Rev. D 103 (2021) 064066, that
/// it is integrable.
template <class ScalarType = double>
class SpinOrbit {
 public:
  using Scalar = ScalarType;
  using State = PhasePoint<Scalar, 5>;
  using Spin = Vector<Scalar, 3>;

  /// GM of both together, length³/time²; speed of light; share m₁/M of the first body; lengths of the spins,
  /// in units of GM_i²/c, at most 1 for a black hole. Throws std::invalid_argument for what makes no sense.
  SpinOrbit(const Scalar& gm, const Scalar& c, const Scalar& share, const Scalar& chi1, const Scalar& chi2)
      : gm_(gm), c_(c), nu_(share * (1 - share)), newton_{.gm = gm}, corrected_{.gm = gm, .c = c, .nu = nu_} {
    using std::isfinite;
    if (!(gm > 0) || !isfinite(gm) || !(c > 0))
      throw std::invalid_argument("SpinOrbit: gm and c are to be positive, and gm finite");
    if (!(share > 0 && share < 1))
      throw std::invalid_argument("SpinOrbit: the share of the first body is to be between 0 and 1");
    const Scalar shares[2] = {share, 1 - share}, chi[2] = {chi1, chi2};
    for (int i = 0; i < 2; ++i) {
      if (!(chi[i] >= 0) || !isfinite(chi[i]))
        throw std::invalid_argument("SpinOrbit: a spin's length is negative, NaN or Inf; give 0 or more");
      length_[i] = gm * shares[i] * shares[i] * chi[i] / (c * nu_);
      weight_[i] = 1 + 3 * (1 - shares[i]) / (4 * shares[i]);
    }
  }

  /// The Hamiltonian, with its gradient by automatic differentiation.
  auto hamiltonian() const {
    return from_energy<5, Scalar>(
        [bodies = *this](const auto& q, const auto& p) { return bodies.energy(q, p); });
  }

  auto energy(const auto& q, const auto& p) const {
    using effects::orbits::detail::dot;
    return dot<3>(p, p) / 2 + newton_.energy(q) + corrected_.energy(q, p) +
           detail::over_cube(Scalar(2 * gm_ * nu_ / (c_ * c_)), dot<3>(q, q)) * coupling(q, p);
  }
  /// L·(σ₁s₁ + σ₂s₂), which is kept.
  auto coupling(const auto& q, const auto& p) const {
    const auto l = angular_momentum(q, p);
    const auto s1 = spin(0, q, p), s2 = spin(1, q, p);
    auto sum = l[0] * (weight_[0] * s1[0] + weight_[1] * s2[0]);
    for (int k = 1; k < 3; ++k) sum += l[k] * (weight_[0] * s1[k] + weight_[1] * s2[k]);
    return sum;
  }
  /// L + s₁ + s₂, per reduced mass.
  Spin total_angular_momentum(const State& z) const {
    const auto l = angular_momentum(z.q(), z.p());
    const auto s1 = spin(0, z.q(), z.p()), s2 = spin(1, z.q(), z.p());
    return {l[0] + s1[0] + s2[0], l[1] + s1[1] + s2[1], l[2] + s1[2] + s2[2]};
  }

  /// Relative position and momentum per reduced mass, and the directions of the spins, of any length but 0.
  State state(const Vector<Scalar, 3>& position, const Vector<Scalar, 3>& momentum, const Spin& direction1,
              const Spin& direction2) const {
    using std::atan2;
    using std::isfinite;
    State z;
    z.q().template head<3>() = position;
    z.p().template head<3>() = momentum;
    const Spin* directions[2] = {&direction1, &direction2};
    for (int i = 0; i < 2; ++i) {
      const Spin& n = *directions[i];
      const Scalar size = semiexplicit::detail::norm(n);
      if (!(size > 0) || !isfinite(size))
        throw std::invalid_argument("SpinOrbit: direction " + std::to_string(i + 1) +
                                    " has no length, or holds NaN or Inf; give any other one");
      z.q()[3 + i] = atan2(n[1], n[0]);
      z.p()[3 + i] = length_[i] * (n[2] / size);
    }
    return z;
  }

 private:
  template <class Number>
  struct Triple {
    Number of[3];
    const Number& operator[](int i) const { return of[i]; }
  };
  template <class X>
  using NumberIn = std::remove_cvref_t<decltype(std::declval<const X&>()[0])>;

  auto angular_momentum(const auto& q, const auto& p) const {
    using Number = std::remove_cvref_t<decltype(q[0] * p[0])>;
    return Triple<Number>{{q[1] * p[2] - q[2] * p[1], q[2] * p[0] - q[0] * p[2], q[0] * p[1] - q[1] * p[0]}};
  }
  auto spin(int i, const auto& q, const auto& p) const {
    using std::cos, std::sin, std::sqrt;
    using Number = std::remove_cvref_t<decltype(q[0] * p[0])>;
    if (length_[i] == Scalar(0)) return Triple<Number>{{Number(0), Number(0), Number(0)}};
    const Number along = p[3 + i], across = sqrt(length_[i] * length_[i] - along * along);
    return Triple<Number>{{across * cos(q[3 + i]), across * sin(q[3 + i]), along}};
  }

  Scalar gm_, c_, nu_;
  effects::orbits::Attraction<Scalar, 3> newton_;
  effects::orbits::PostNewtonian1<Scalar, 3> corrected_;
  Scalar length_[2], weight_[2];
};

}  // namespace semiexplicit::systems
