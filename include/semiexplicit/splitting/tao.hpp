#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>

#include <semiexplicit/splitting/pihajoki.hpp>

namespace semiexplicit {

/// Tao's explicit map: Pihajoki's kicks and a third flow C of ω/2 ‖a - b‖², which turns the difference of the copies and so
/// keeps it bounded. One stage is A(h/2) B(h/2) C(h) B(h/2) A(h/2); stages are composed with the weights of the scheme,
/// neighbouring A kicks merged, so s stages cost 3s + 1 gradient calls. Symplectic in the doubled space only.
///
/// ω is a matter of trial: too small, and the copies part; 2ωh near a multiple of π swaps or freezes them.
///
/// Source: M. Tao, Phys. Rev. E 94 (2016) 043303. Memory: four vectors of length 2d, and H.
template <class H>
class Tao {
 public:
  using Scalar = typename H::Scalar;
  static constexpr int Dof = H::Dof;
  using State = ExtendedPoint<Scalar, Dof>;

  /// Throws std::invalid_argument unless the scheme passes its own check and is a composition of Strang, as strang,
  /// triple_jump, suzuki, yoshida6, kahan_li, suzuki_umeno and sofroniou_spaletta are: a direct list of A and B
  /// coefficients says nothing about C. Also unless ω is finite.
  Tao(H hamiltonian, Scheme<Scalar> scheme, Scalar omega)
      : chain_(std::move(hamiltonian), std::move(scheme)), omega_(std::move(omega)), gradient_(chain_.a) {
    using std::isfinite;
    require_composition_of_strang();
    if (!isfinite(omega_)) throw std::invalid_argument("Tao: omega is NaN or Inf; give a finite number");
  }

  /// One step of size dt, as Pihajoki::step().
  StepReport step(State& zeta, const Scalar& dt) {
    const auto gradients = static_cast<std::int64_t>(3 * scheme().b.size() + 1);
    return detail::step_explicitly(zeta, chain_, dt, gradients, [&] {
      detail::inlined<Scalar>([&] { kicks(dt, chain_.a.data(), chain_.b.data()); });
    });
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return chain_.hamiltonian; }
  const Scheme<Scalar>& scheme() const { return chain_.scheme; }
  const Scalar& omega() const { return omega_; }

 private:
  void kicks(const Scalar& dt, Scalar* a, Scalar* b) {
    using std::cos;
    using std::sin;
    const Eigen::Index d = dof();
    const auto flow_a = [&](const Scalar& t) {
      detail::gradient_at(hamiltonian(), a, gradient_.data(), d);
      detail::kick(t, gradient_.data(), b, d);
    };
    const auto flow_b = [&](const Scalar& t) {
      detail::gradient_at(hamiltonian(), b, gradient_.data(), d);
      detail::kick(t, gradient_.data(), a, d);
    };
    for (std::size_t i = 0; i < scheme().b.size(); ++i) {
      const Scalar h = dt * scheme().b[i];
      flow_a(dt * scheme().a[i]);
      flow_b(h / 2);
      const Scalar angle = 2 * omega_ * h;
      rotate(cos(angle), sin(angle), a, b, d);
      flow_b(h / 2);
    }
    flow_a(dt * scheme().a.back());
  }

  /// The flow C: the means of q, x and of p, y stay; the difference (q - x, p - y) turns clockwise. a = (q, y), b = (x, p).
  static void rotate(const Scalar& cosine, const Scalar& sine, Scalar* __restrict a, Scalar* __restrict b,
                     Eigen::Index d) {
    for (Eigen::Index i = 0; i < d; ++i) {
      const Scalar dq = (a[i] - b[i]) / 2, dp = (b[d + i] - a[d + i]) / 2;
      const Scalar q = (a[i] + b[i]) / 2, p = (b[d + i] + a[d + i]) / 2;
      const Scalar turned_dq = cosine * dq + sine * dp, turned_dp = cosine * dp - sine * dq;
      a[i] = q + turned_dq;
      b[i] = q - turned_dq;
      b[d + i] = p + turned_dp;
      a[d + i] = p - turned_dp;
    }
  }

  void require_composition_of_strang() const {
    using std::abs;
    const auto& a = scheme().a;
    const auto& b = scheme().b;
    const Scalar tolerance = 16 * Eigen::NumTraits<Scalar>::epsilon();
    for (std::size_t i = 0; i < a.size(); ++i) {
      const Scalar before = i > 0 ? b[i - 1] : Scalar(0), after = i < b.size() ? b[i] : Scalar(0);
      if (!(abs(a[i] - (before + after) / 2) <= tolerance * (1 + abs(before) + abs(after))))
        throw std::invalid_argument(
            "Tao: the scheme '" + scheme().name +
            "' is not a composition of Strang; use strang, triple_jump, suzuki, yoshida6, "
            "kahan_li, suzuki_umeno or sofroniou_spaletta, or compose() one from strang");
    }
  }

  detail::KickChain<H> chain_;
  Scalar omega_;
  typename PhasePoint<Scalar, Dof>::Storage gradient_;
};

}  // namespace semiexplicit
