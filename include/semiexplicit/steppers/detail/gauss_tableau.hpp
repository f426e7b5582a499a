#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <Eigen/Core>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/vector.hpp>

namespace semiexplicit {

/// The coefficients of the Gauss-Legendre collocation method with s stages (order 2s), computed to the
/// accuracy of Scalar.
///
/// Source: Hairer, Lubich, Wanner, Geometric Numerical Integration, II.1.3. The a_ij are kept as m_ij = a_ij
/// / b_j with m_ij + m_ji = 1, which holds exactly in floating point then: the condition of symplecticity b_i
/// a_ij + b_j a_ji = b_i b_j survives the rounding of the coefficients (Antoñana, Makazaga, Murua, Numer.
/// Algorithms 76 (2017) 861).
template <class Scalar>
struct GaussTableau {
  using Matrix = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;

  Vector<Scalar, Eigen::Dynamic> c;  ///< nodes in [0, 1], ascending
  Vector<Scalar, Eigen::Dynamic> b;  ///< weights
  Vector<Scalar, Eigen::Dynamic> w;  ///< 1/Π(c_j - c_k) over k ≠ j: ℓ_j(x) = w_j Π(x - c_k) / (x - c_j)
  Matrix m;                          ///< a_ij / b_j

  /// Throws std::invalid_argument unless 1 ≤ stages ≤ 8.
  SEMIEXPLICIT_COLD explicit GaussTableau(int stages) {
    if (stages < 1 || stages > 8)
      throw std::invalid_argument("GaussLegendre: " + std::to_string(stages) +
                                  " stages asked for; give 1 to 8");
    if constexpr (std::is_same_v<Scalar, float>) {  // whose own roundings would add up to several of its ε
      const GaussTableau<double> exact(stages);
      c = exact.c.template cast<float>();
      b = exact.b.template cast<float>();
      w = exact.w.template cast<float>();
      m = exact.m.template cast<float>();
      for (int i = 0; i < stages; ++i)
        for (int j = i + 1; j < stages; ++j) m(i, j) = 1 - m(j, i);
      return;
    }
    c.resize(stages);
    b.resize(stages);
    w.setOnes(stages);
    m.resize(stages, stages);
    for (int i = 0; i < stages; ++i) {
      const auto [root, slope] = legendre_root(stages, i);
      c[i] = (1 - root) / 2;
      b[i] = 1 / ((1 - root * root) * slope * slope);
    }
    for (int j = 0; j < stages; ++j)
      for (int k = 0; k < stages; ++k)
        if (k != j) w[j] /= c[j] - c[k];
    for (int i = 0; i < stages; ++i) {
      // a_ij is the integral of ℓ_j from 0 to c_i, which the method's own quadrature integrates exactly.
      Scalar integral[8]{}, value[8];
      for (int k = 0; k < stages; ++k) {
        lagrange(Scalar(c[i] * c[k]), value);
        for (int j = 0; j < stages; ++j) integral[j] += c[i] * b[k] * value[j];
      }
      m(i, i) = Scalar(1) / 2;
      for (int j = i + 1; j < stages; ++j) {
        m(j, i) = 1 - integral[j] / b[j];
        m(i, j) = 1 - m(j, i);  // exact, as 1/2 <= m_ji <= 2; the line above may round
      }
    }
  }

  /// ℓ_0(x), ..., ℓ_{s-1}(x) at an x that is no node, into values; x may be a pack of them.
  template <class X>
  void lagrange(const X& x, X* values) const {
    X all(Scalar(1));
    for (Eigen::Index k = 0; k < c.size(); ++k) all = all * (x - c[k]);
    for (Eigen::Index j = 0; j < c.size(); ++j) values[j] = all * w[j] / (x - c[j]);
  }

 private:
  struct Root {
    Scalar root, slope;
  };
  /// The i-th largest root of the Legendre polynomial of degree n, and the slope there: Newton from the usual
  /// cosine.
  static Root legendre_root(int n, int i) {
    using std::abs;
    Scalar x = static_cast<Scalar>(std::cos(3.14159265358979323846 * (i + 0.75) / (n + 0.5)));
    Scalar slope(0);
    for (int iteration = 0; iteration < 12;
         ++iteration) {  // quadratic from three digits: enough for thousands
      Scalar previous(1), value(x);
      for (int k = 2; k <= n; ++k) {
        const Scalar next = (Scalar(2 * k - 1) * x * value - Scalar(k - 1) * previous) / Scalar(k);
        previous = value;
        value = next;
      }
      slope = Scalar(n) * (x * value - previous) / (x * x - 1);
      x -= value / slope;
    }
    return {x, slope};
  }
};

}  // namespace semiexplicit
