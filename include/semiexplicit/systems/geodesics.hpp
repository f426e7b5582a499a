#pragma once

#include <cmath>
#include <concepts>
#include <limits>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/derivatives/dual.hpp>
#include <semiexplicit/scene/effect.hpp>

/// Geodesics of any metric, given as a function of the place: H = g^{μν}(x) p_μ p_ν/2, where q = x are four
/// coordinates in any system and p the covariant momenta per rest mass; c = G = 1, signature (-, +, +, +). H
/// is -1/2 for a body and 0 for light, and the time of integration is proper time (for light an affine
/// parameter).
namespace semiexplicit::effects::geodesics {

/// The ten components of a symmetric tensor, all zero at first, in numbers as x has them. g(i, j) and g(j, i)
/// are one.
template <class Number>
class Components {
 public:
  template <class X>
  explicit Components(const X&) : Components() {}
  Components() {
    for (Number& component : of_) component = Number(0);
  }
  Number& operator()(int i, int j) { return of_[place(i, j)]; }
  const Number& operator()(int i, int j) const { return of_[place(i, j)]; }

 private:
  static int place(int i, int j) { return i > j ? place(j, i) : 4 * i - i * (i + 1) / 2 + j; }
  Number of_[10];
};
template <class X>
Components(const X&) -> Components<std::remove_cvref_t<decltype(std::declval<const X&>()[0])>>;

/// The inverse of a symmetric tensor: g^{μν} where g_{μν} is what one has. NaN or Inf where it has none.
template <class Number>
Components<Number> inverse(const Components<Number>& g) {
  Components<Number> cofactors;
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) {
      int rows[3], columns[3];
      for (int k = 0, r = 0, c = 0; k < 4; ++k) {
        if (k != i) rows[r++] = k;
        if (k != j) columns[c++] = k;
      }
      const auto at = [&](int r, int c) { return g(rows[r], columns[c]); };
      const Number minor = at(0, 0) * (at(1, 1) * at(2, 2) - at(1, 2) * at(2, 1)) -
                           at(0, 1) * (at(1, 0) * at(2, 2) - at(1, 2) * at(2, 0)) +
                           at(0, 2) * (at(1, 0) * at(2, 1) - at(1, 1) * at(2, 0));
      cofactors(i, j) = (i + j) % 2 == 0 ? minor : -minor;
    }
  Number determinant(0);
  for (int j = 0; j < 4; ++j) determinant += g(0, j) * cofactors(0, j);
  for (int i = 0; i < 4; ++i)
    for (int j = i; j < 4; ++j) cofactors(i, j) = cofactors(i, j) / determinant;
  return cofactors;
}

/// A metric: called with a place of numbers of any type it gives the Components of g^{μν} there.
///
///     struct Schwarzschild {
///       auto operator()(const auto& x) const {  // x = (t, r, θ, φ)
///         using std::sin;
///         geodesics::Components g(x);
///         const auto f = 1 - 2 / x[1], s = sin(x[2]), r2 = x[1] * x[1];
///         g(0, 0) = -1 / f;
///         g(1, 1) = f;
///         g(2, 2) = 1 / r2;
///         g(3, 3) = 1 / (r2 * s * s);
///         return g;
///       }
///     };
template <class M, class Scalar = double>
concept Metric = requires(const M& metric, const Vector<Scalar, 4>& x) {
  { metric(x) } -> std::same_as<Components<Scalar>>;
};

/// Free motion in a metric. The derivatives of the metric come by automatic differentiation, exact to
/// rounding.
///
/// Source: C. Misner, K. Thorne, J. Wheeler, Gravitation (1973), exercise 25.2.
template <class M, class Scalar = double>
requires Metric<M, Scalar>
class Geodesic {
 public:
  using Acts = OnBoth<Scalar, 4>;
  static constexpr const char* name = "geodesic";
  static constexpr const char* about = "geodesic of a metric, g^{μν}(x) p_μ p_ν/2";

  explicit Geodesic(M metric) : metric_(std::move(metric)) {}

  Scalar energy(const auto& q, const auto& p) const {
    return square(metric_(Vector<Scalar, 4>(q[0], q[1], q[2], q[3])), p) / 2;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    using Dual = semiexplicit::detail::Dual<Scalar, 4>;
    Eigen::Matrix<Dual, 4, 1> x;
    for (int i = 0; i < 4; ++i) {
      x[i] = Dual(q[i]);
      x[i].derivative[i] = Scalar(1);
    }
    const Components<Dual> g = metric_(x);
    for (int i = 0; i < 4; ++i)
      for (int j = i; j < 4; ++j) {
        const Scalar product = i == j ? Scalar(p[i] * p[i] / 2) : Scalar(p[i] * p[j]);
        for (int k = 0; k < 4; ++k) dHdq[k] += product * g(i, j).derivative[k];
        dHdp[i] += g(i, j).value * p[j];
        if (i != j) dHdp[j] += g(i, j).value * p[i];
      }
  }

  /// A body at x with the momenta p₁, p₂, p₃, and with the p₀ = -E that its rest mass asks for, so that x₀
  /// grows with proper time: into the future where x₀ is a time, or is constant on light that comes in or
  /// goes out (Eddington-Finkelstein, g^{00} = 0). NaN where there is none.
  PhasePoint<Scalar, 4> body(const Vector<Scalar, 4>& x, const Vector<Scalar, 3>& momenta) const {
    using std::sqrt;
    const Components<Scalar> g = metric_(x);
    Vector<Scalar, 4> p(Scalar(0), momenta[0], momenta[1], momenta[2]);
    const Scalar a = g(0, 0), b = g(0, 1) * p[1] + g(0, 2) * p[2] + g(0, 3) * p[3], c = square(g, p) + 1;
    const Scalar rate = sqrt(b * b - a * c);  // dx₀/dτ = a p₀ + b
    if (b > 0)
      p[0] = -c / (b + rate);  // (rate - b)/a, without its difference of like numbers
    else
      p[0] = a == 0 ? std::numeric_limits<Scalar>::quiet_NaN() : Scalar((rate - b) / a);
    return {x, p};
  }
  const M& metric() const { return metric_; }

 private:
  static Scalar square(const Components<Scalar>& g, const auto& p) {
    Scalar sum(0);
    for (int i = 0; i < 4; ++i) {
      sum += g(i, i) * p[i] * p[i];
      for (int j = i + 1; j < 4; ++j) sum += 2 * g(i, j) * p[i] * p[j];
    }
    return sum;
  }

  M metric_;
};
template <class M>
Geodesic(M) -> Geodesic<M>;

/// Kerr's metric of mass M and spin aM in Boyer-Lindquist coordinates (t, r, θ, φ). black_hole::Kerr is the
/// same by hand, and three times as fast. Source: Misner, Thorne, Wheeler (1973), eq. (33.2).
template <class Scalar = double>
struct KerrMetric {
  Scalar mass = Scalar(1), spin = Scalar(0);
  static_assert(!std::is_integral_v<Scalar>, "a metric of whole numbers: write 1.0, or KerrMetric<double>");

  auto operator()(const auto& x) const {
    using std::cos;
    using std::sin;
    Components g(x);
    const auto r = x[1], s = sin(x[2]), c = cos(x[2]), s2 = s * s;
    const auto r2a2 = r * r + spin * spin, sigma = r * r + spin * spin * c * c;
    const auto delta = (r - mass) * (r - mass) - (mass - spin) * (mass + spin), pull = 2 * mass * r / delta;
    // Beginning with what they are far out, g^{tt} and g^{rr} have derivatives that lose nothing there.
    g(0, 0) = -1 - pull * r2a2 / sigma;
    g(0, 3) = -spin * pull / sigma;
    g(1, 1) = 1 - (2 * mass * r - spin * spin * s2) / sigma;
    g(2, 2) = 1 / sigma;
    g(3, 3) = (1 - spin * spin * s2 / delta) / (sigma * s2);
    return g;
  }
};

/// A black hole of mass M in a magnetic field B, uniform but for the hole and for its own weight, in
/// Schwarzschild's coordinates (an exact solution). For B = 0 it is Schwarzschild's; else E and L are all
/// that is kept, and orbits may be chaotic.
///
///     ds² = Λ² (-f dt² + dr²/f + r² dθ²) + r² sin²θ/Λ² dφ²,   f = 1 - 2M/r,   Λ = 1 + B² r² sin²θ/4.
///
/// Sources: F. Ernst, J. Math. Phys. 17 (1976) 54; V. Karas, D. Vokrouhlický, Gen. Relativ. Gravit. 24 (1992)
/// 729.
template <class Scalar = double>
struct ErnstMetric {
  Scalar mass = Scalar(1);
  Scalar field = Scalar(0);  ///< B, one over a length
  static_assert(!std::is_integral_v<Scalar>, "a metric of whole numbers: write 1.0, or ErnstMetric<double>");

  auto operator()(const auto& x) const {
    using std::sin;
    Components g(x);
    const auto r = x[1], s = sin(x[2]), rho2 = r * r * s * s, f = 1 - 2 * mass / r;
    const auto lambda = 1 + field * field / 4 * rho2, lambda2 = lambda * lambda;
    g(0, 0) = -1 / (lambda2 * f);
    g(1, 1) = f / lambda2;
    g(2, 2) = 1 / (lambda2 * r * r);
    g(3, 3) = lambda2 / rho2;
    return g;
  }
};

}  // namespace semiexplicit::effects::geodesics
