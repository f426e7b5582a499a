#pragma once

#include <cstdint>
#include <utility>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/splitting/scheme.hpp>

/// Inlines everything that a function calls. Compilers stop inlining a small gradient in a large translation unit, which
/// nearly doubles the time of a kick; the chain of kicks is where that must not happen.
#if defined(__GNUC__) || defined(__clang__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#else
#define SEMIEXPLICIT_FLATTEN
#endif

namespace semiexplicit::detail {

/// One gradient call at the contiguous phase point `at`, written to the contiguous pair (∂H/∂q, ∂H/∂p).
template <Hamiltonian H>
void gradient_at(const H& hamiltonian, const typename H::Scalar* at, typename H::Scalar* gradient,
                 Eigen::Index dof) {
  using Column = Vector<typename H::Scalar, H::Dof>;
  hamiltonian.gradient(Eigen::Map<const Column>(at, dof), Eigen::Map<const Column>(at + dof, dof),
                       Eigen::Map<Column>(gradient, dof), Eigen::Map<Column>(gradient + dof, dof));
}

/// to += t X, where X = (∂H/∂p, -∂H/∂q). A plain loop over raw pointers: compilers vectorise that, and not the equivalent
/// Eigen expression on the halves of a vector of odd fixed size.
template <class Scalar>
void kick(const Scalar& t, const Scalar* __restrict gradient, Scalar* __restrict to, Eigen::Index dof) {
  for (Eigen::Index i = 0; i < dof; ++i) to[i] += t * gradient[dof + i];
  for (Eigen::Index i = 0; i < dof; ++i) to[dof + i] -= t * gradient[i];
}

/// The same, and sum += t X in one pass.
template <class Scalar>
void kick(const Scalar& t, const Scalar* __restrict gradient, Scalar* __restrict to, Scalar* __restrict sum,
          Eigen::Index dof) {
  for (Eigen::Index i = 0; i < dof; ++i) {
    const Scalar move = t * gradient[dof + i];
    to[i] += move;
    sum[i] += move;
  }
  for (Eigen::Index i = 0; i < dof; ++i) {
    const Scalar move = t * gradient[i];
    to[dof + i] -= move;
    sum[dof + i] -= move;
  }
}

/// The kicks of a scheme, A(a₀t) B(b₀t) A(a₁t) ..., on two copies of a phase point. A is the exact flow of H(q, y) and B that
/// of H(x, p): with a = (q, y) and b = (x, p), each moves one copy along the vector field at the other, which rests.
template <Hamiltonian H>
class KickChain {
 public:
  using Scalar = typename H::Scalar;
  static constexpr int Dof = H::Dof;
  using Vec = typename PhasePoint<Scalar, Dof>::Storage;

  KickChain(H h, Scheme<Scalar> s)
      : hamiltonian(std::move(h)),
        scheme(std::move(s)),
        a(PhasePoint<Scalar, Dof>(dof_of(hamiltonian)).vector()),
        b(a),
        gradient_(a) {
    scheme.check();
  }

  /// All kicks of one step on the copies.
  void run(const Scalar& dt) { run(dt, a.data(), b.data()); }

  /// The same; `sum` becomes what both copies moved together. Summed apart from the copies, it has the rounding errors of
  /// the increments and not those of the state.
  void run(const Scalar& dt, Vec& sum) {
    sum.setZero();
    run(dt, a.data(), b.data(), sum.data());
  }

  std::int64_t gradients() const { return static_cast<std::int64_t>(scheme.kicks()); }

  H hamiltonian;
  Scheme<Scalar> scheme;
  Vec a, b;

 private:
  template <class... Sum>
  SEMIEXPLICIT_FLATTEN void run(const Scalar& dt, Scalar* first, Scalar* second, Sum*... sum) {
    const Eigen::Index d = dof_of(hamiltonian);
    Scalar* const gradient = gradient_.data();
    const std::size_t n = scheme.b.size();
    for (std::size_t i = 0; i < n; ++i) {
      gradient_at(hamiltonian, first, gradient, d);
      kick(Scalar(dt * scheme.a[i]), gradient, second, sum..., d);
      gradient_at(hamiltonian, second, gradient, d);
      kick(Scalar(dt * scheme.b[i]), gradient, first, sum..., d);
    }
    gradient_at(hamiltonian, first, gradient, d);
    kick(Scalar(dt * scheme.a[n]), gradient, second, sum..., d);
  }

  Vec gradient_;
};

}  // namespace semiexplicit::detail
