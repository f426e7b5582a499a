#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include <semiexplicit/scene/effect.hpp>
#include <semiexplicit/systems/nbody.hpp>
#include <semiexplicit/systems/post_newtonian.hpp>

namespace semiexplicit::effects::nbody {

/// The first post-Newtonian correction of each body and those within, taken as one mass:
/// orbits::PostNewtonian1 in every Jacobi vector. For planets about a star the rest of EinsteinInfeldHoffmann
/// is smaller by the ratio of the masses.
template <class Scalar = double, int Dof = Eigen::Dynamic>
struct PostNewtonian1 {
  using Acts = OnBoth<Scalar, Dof>;
  static constexpr const char* name = "1pn";
  static constexpr const char* about = "first post-Newtonian correction of each body and those within";
  Bodies<Scalar> bodies;
  Scalar c = Scalar(1);  ///< speed of light, length/time

  Eigen::Index dof() const { return bodies.dof(); }
  std::vector<double> scene_constants() const { return bodies.masses(); }
  auto energy(const auto& q, const auto& p) const {
    auto sum = 0 * q[0];
    for (Eigen::Index i = 1; i < bodies.size(); ++i) {
      sum += bodies.reduced(i) * pair(i).energy(detail::triple(q, i), velocity(p, i));
    }
    return sum;
  }
  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    using Number = detail::NumberIn<std::remove_cvref_t<decltype(q)>>;
    for (Eigen::Index i = 1; i < bodies.size(); ++i) {
      const detail::Triple<Number> x = detail::triple(q, i), w = velocity(p, i);
      detail::Triple<Number> by_q{Number(0), Number(0), Number(0)}, by_p = by_q;
      pair(i).add_gradient(x, w, by_q, by_p);
      for (Eigen::Index k = 0; k < 3; ++k) {
        dHdq[3 * i - 3 + k] += bodies.reduced(i) * by_q[k];
        dHdp[3 * i - 3 + k] += by_p[k];
      }
    }
  }

 private:
  orbits::PostNewtonian1<Scalar, 3> pair(Eigen::Index i) const {
    return {.gm = bodies.up_to(i), .c = c, .nu = bodies.reduced(i) / bodies.up_to(i)};
  }
  auto velocity(const auto& p, Eigen::Index i) const {
    auto w = detail::triple(p, i);
    for (auto& of_w : w.of) of_w = of_w / bodies.reduced(i);
    return w;
  }
};

/// The first post-Newtonian correction of all bodies together (Einstein, Infeld and Hoffmann), with v = p/m,
/// φ the sum of the others' m/r, n the direction of a pair, in barycentric ADM (at this order also harmonic)
/// coordinates:
///
///     H = 1/c² (-Σ m v⁴/8 + Σ m φ²/2 - ½ Σ_pairs m m'/r (3 (v² + v'²) - 7 v·v' - (n·v)(n·v'))).
///
/// 64 bodies at most, so that no memory is asked for in a step. Source: Landau and Lifshitz, The Classical
/// Theory of Fields, section 106; in this form Damour, Jaranowski, Schäfer, Phys. Rev. D 62 (2000) 021501.
template <class Scalar = double, int Dof = Eigen::Dynamic>
class EinsteinInfeldHoffmann {
 public:
  using Acts = OnBoth<Scalar, Dof>;
  static constexpr const char* name = "eih";
  static constexpr const char* about = "first post-Newtonian correction of all bodies together";
  static constexpr int most_bodies = Dof == Eigen::Dynamic ? 64 : Dof / 3 + 1;

  /// Throws std::invalid_argument for more than 64 bodies, or where c, a length/time, is not positive.
  EinsteinInfeldHoffmann(Bodies<Scalar> of, Scalar speed_of_light)
      : bodies_(std::move(of)), c_(speed_of_light) {
    if (bodies_.size() > most_bodies)
      throw std::invalid_argument("EinsteinInfeldHoffmann: " + std::to_string(bodies_.size()) +
                                  " bodies, and it takes " + std::to_string(most_bodies) + " at most");
    if (!(c_ > 0)) throw std::invalid_argument("EinsteinInfeldHoffmann: c is not positive");
  }

  Eigen::Index dof() const { return bodies_.dof(); }
  std::vector<double> scene_constants() const { return bodies_.masses(); }
  auto energy(const auto& q, const auto& p) const {
    const Cartesian<detail::NumberIn<std::remove_cvref_t<decltype(q)>>> at(bodies_, q, p);
    auto sum = 0 * q[0];
    for (std::size_t a = 0; a < at.size; ++a) {
      const auto v2 = detail::dot(at.v[a], at.v[a]);
      sum += at.m[a] * (at.phi[a] * at.phi[a] / 2 - v2 * v2 / 8);
      for (std::size_t b = 0; b < a; ++b) {
        const auto pair = at.pair(a, b);
        sum -= at.m[a] * at.m[b] * pair.inverse *
               (pair.square - pair.by_a * pair.by_b * pair.inverse * pair.inverse) / 2;
      }
    }
    return sum / (c_ * c_);
  }

  void add_gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    using Number = detail::NumberIn<std::remove_cvref_t<decltype(q)>>;
    const Cartesian<Number> at(bodies_, q, p);
    std::array<detail::Triple<Number>, static_cast<std::size_t>(most_bodies)> g, u;  // by r, by p
    for (std::size_t a = 0; a < at.size; ++a) {
      const Number v2 = detail::dot(at.v[a], at.v[a]);
      for (Eigen::Index i = 0; i < 3; ++i) {
        g[a][i] = Number(0);
        u[a][i] = -v2 * at.v[a][i] / 2;
      }
      for (std::size_t b = 0; b < a; ++b) {
        const auto pair = at.pair(a, b);
        const Number k = pair.inverse, k2 = k * k, k3 = k2 * k, mm = at.m[a] * at.m[b];
        const Number along =
            mm * k3 * ((pair.square - 3 * pair.by_a * pair.by_b * k2) / 2 - (at.phi[a] + at.phi[b]));
        for (Eigen::Index i = 0; i < 3; ++i) {
          const Number f =
              along * pair.d[i] + mm * k3 / 2 * (at.v[a][i] * pair.by_b + at.v[b][i] * pair.by_a);
          g[a][i] += f;
          g[b][i] -= f;
          u[a][i] -= at.m[b] * k / 2 * (6 * at.v[a][i] - 7 * at.v[b][i] - pair.d[i] * pair.by_b * k2);
          u[b][i] -= at.m[a] * k / 2 * (6 * at.v[b][i] - 7 * at.v[a][i] - pair.d[i] * pair.by_a * k2);
        }
      }
    }
    const Scalar weight = 1 / (c_ * c_);
    for (Eigen::Index i = 0; i < 3; ++i) {
      Number forces = g[0][i], momentum = at.m[0] * u[0][i];  // of those within
      for (std::size_t a = 1; a < at.size; ++a) {
        const auto of = static_cast<Eigen::Index>(a), row = 3 * of - 3 + i;
        forces += g[a][i];
        dHdq[row] += weight * (g[a][i] - bodies_.share(of) * forces);
        dHdp[row] += weight * (u[a][i] - momentum / bodies_.up_to(of - 1));
        momentum += at.m[a] * u[a][i];
      }
    }
  }

 private:
  /// Positions, from the primary, and velocities about the centre of mass, of all bodies, and what the pairs
  /// have in common.
  template <class Number>
  struct Cartesian {
    struct Pair {
      detail::Triple<Number> d;            // from b to a
      Number inverse, square, by_a, by_b;  // 1/r, 3 (v² + v'²) - 7 v·v', d·v and d·v'
    };

    Cartesian(const Bodies<Scalar>& bodies, const auto& q, const auto& p)
        : size(static_cast<std::size_t>(bodies.size())) {
      using std::sqrt;
      detail::Triple<Number> centre{Number(0), Number(0), Number(0)}, moving = centre;
      r[0] = v[0] = centre;
      m[0] = bodies.gm(0);
      for (std::size_t a = 1; a < size; ++a) {
        const auto i = static_cast<Eigen::Index>(a);
        const detail::Triple<Number> x = detail::triple(q, i), w = detail::triple(p, i);
        m[a] = bodies.gm(i);
        for (Eigen::Index k = 0; k < 3; ++k) {
          const Number speed = w[k] / bodies.reduced(i);
          r[a][k] = centre[k] + x[k];
          v[a][k] = moving[k] + speed;
          centre[k] += bodies.share(i) * x[k];
          moving[k] += bodies.share(i) * speed;
        }
      }
      for (std::size_t a = 0; a < size; ++a) {
        phi[a] = Number(0);
        for (Eigen::Index k = 0; k < 3; ++k) v[a][k] -= moving[k];
        for (std::size_t b = 0; b < a; ++b) {
          const Pair of = pair(a, b);
          phi[a] += m[b] * of.inverse;
          phi[b] += m[a] * of.inverse;
        }
      }
    }
    Pair pair(std::size_t a, std::size_t b) const {
      using std::sqrt;
      Pair of;
      for (Eigen::Index k = 0; k < 3; ++k) of.d[k] = r[a][k] - r[b][k];
      of.inverse = 1 / sqrt(detail::dot(of.d, of.d));
      of.square = 3 * (detail::dot(v[a], v[a]) + detail::dot(v[b], v[b])) - 7 * detail::dot(v[a], v[b]);
      of.by_a = detail::dot(of.d, v[a]);
      of.by_b = detail::dot(of.d, v[b]);
      return of;
    }

    std::size_t size;
    std::array<detail::Triple<Number>, static_cast<std::size_t>(most_bodies)> r, v;
    std::array<Number, static_cast<std::size_t>(most_bodies)> phi;
    std::array<Scalar, static_cast<std::size_t>(most_bodies)> m;
  };

  Bodies<Scalar> bodies_;
  Scalar c_;
};

}  // namespace semiexplicit::effects::nbody
