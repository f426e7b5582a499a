#pragma once

#include <algorithm>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/schemes/scheme.hpp>

/// Inlines everything that a function calls; see detail::inlined().
#if defined(__GNUC__) || defined(__clang__)
#define SEMIEXPLICIT_FLATTEN __attribute__((flatten))
#define SEMIEXPLICIT_NOINLINE __attribute__((noinline))
#else
#define SEMIEXPLICIT_FLATTEN
#define SEMIEXPLICIT_NOINLINE
#endif

namespace semiexplicit::detail {

template <class F>
SEMIEXPLICIT_FLATTEN auto call_inlined(const F& f) {
  return f();
}

/// Calls f with everything that it calls inlined. Compilers stop inlining a small gradient in a large translation unit,
/// which nearly doubles the time of a kick; the chain of kicks is where that must not happen. Not where numbers are
/// classes: with multiprecision arithmetic inlined into itself g++ takes hours and all memory.
template <class Scalar, class F>
auto inlined(const F& f) {
  if constexpr (std::is_floating_point_v<Scalar>)
    return call_inlined(f);
  else
    return f();
}

/// to += t X in `size` places, where X = (∂H/∂p, -∂H/∂q) and the momenta of `to` lie d places after its positions. Plain
/// loops over raw pointers: compilers vectorise these, and not the equivalent Eigen expression on the halves of a vector of
/// odd fixed size.
template <class Scalar>
void kick(const Scalar& t, const Scalar* __restrict gradient, Scalar* __restrict to, Eigen::Index size,
          Eigen::Index d) {
  for (Eigen::Index i = 0; i < size; ++i) to[i] += t * gradient[size + i];
  for (Eigen::Index i = 0; i < size; ++i) to[d + i] -= t * gradient[i];
}

/// The same, and sum += t X in one pass.
template <class Scalar>
void kick(const Scalar& t, const Scalar* __restrict gradient, Scalar* __restrict to, Scalar* __restrict sum,
          Eigen::Index size, Eigen::Index d) {
  for (Eigen::Index i = 0; i < size; ++i) {
    const Scalar move = t * gradient[size + i];
    to[i] += move;
    sum[i] += move;
  }
  for (Eigen::Index i = 0; i < size; ++i) {
    const Scalar move = t * gradient[i];
    to[d + i] -= move;
    sum[d + i] -= move;
  }
}

/// The kicks of a scheme, A(a₀t) B(b₀t) A(a₁t) ..., on two copies of a phase point. A is the exact flow of H(q, y) and B that
/// of H(x, p): with a = (q, y) and b = (x, p), each moves one copy along the vector field at the other, which rests.
template <class H>
class KickChain {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
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
  void run(const Scalar& dt) {
    inlined<Scalar>([&] { run_plainly(dt); });
  }
  /// The same from the given copies, which may be a and b themselves. `sum` becomes what both moved together: summed apart
  /// from the copies, it has the rounding errors of the increments and not those of the state.
  void run(const Vec& from_a, const Vec& from_b, const Scalar& dt, Vec& sum) {
    inlined<Scalar>([&] { run_plainly(from_a, from_b, dt, sum); });
  }

  /// False where the chain was moved from.
  bool valid() const { return !scheme.b.empty(); }
  std::int64_t gradients() const { return static_cast<std::int64_t>(scheme.kicks()); }

  H hamiltonian;
  Scheme<Scalar> scheme;
  Vec a, b;

 private:
  void run_plainly(const Scalar& dt) {
    if constexpr (HasLaneGradient<H>) {
      run_in_lanes(a, b, dt, gradient_);  // the sum is not wanted
    } else if constexpr (small) {
      Local at_a(a), at_b(b);
      kicks(dt, at_a.data, at_b.data, Local().data);
      at_a.store(a);
      at_b.store(b);
    } else {
      kicks(dt, a.data(), b.data(), gradient_.data());
    }
  }

  void run_plainly(const Vec& from_a, const Vec& from_b, const Scalar& dt, Vec& sum) {
    if constexpr (HasLaneGradient<H>) {
      run_in_lanes(from_a, from_b, dt, sum);
    } else if constexpr (small) {
      Local at_a(from_a), at_b(from_b), moved;
      kicks(dt, at_a.data, at_b.data, Local().data, moved.data);
      at_a.store(a);
      at_b.store(b);
      moved.store(sum);
    } else {
      a = from_a;
      b = from_b;
      sum.setZero();
      kicks(dt, a.data(), b.data(), gradient_.data(), sum.data());
    }
  }

  /// Few numbers are copied to the stack for a step, where the compiler can keep them in registers.
  static constexpr bool small = Dof != Eigen::Dynamic && Dof <= 16;
  struct Local {
    static constexpr int size = small ? 2 * Dof : 1;
    Scalar data[std::size_t(size)];

    Local() {
      for (int i = 0; i < size; ++i) data[i] = Scalar(0);
    }
    explicit Local(const Vec& from) {
      for (int i = 0; i < size; ++i) data[i] = from[i];
    }
    void store(Vec& to) const {
      for (int i = 0; i < size; ++i) to[i] = data[i];
    }
  };

  template <class... Sum>
  void kicks(const Scalar& dt, Scalar* at_a, Scalar* at_b, Scalar* gradient, Sum*... sum) const {
    const std::size_t n = scheme.b.size();
    for (std::size_t i = 0; i < n; ++i) {
      flow(Scalar(dt * scheme.a[i]), at_a, at_b, gradient, sum...);
      flow(Scalar(dt * scheme.b[i]), at_b, at_a, gradient, sum...);
    }
    flow(Scalar(dt * scheme.a[n]), at_a, at_b, gradient, sum...);
  }

  /// One kick: `to`, and sum, move by t X(from). `gradient` is work space, 2d numbers.
  template <class... Sum>
  void flow(const Scalar& t, const Scalar* from, Scalar* to, Scalar* gradient, Sum*... sum) const {
    const Eigen::Index d = dof_of(hamiltonian);
    if constexpr (HasRangeGradient<H>)
      if (d > block) return flow_in_blocks(t, from, to, gradient, d, sum...);
    gradient_at(hamiltonian, from, gradient, d);
    kick(t, gradient, to, sum..., d, d);
  }

  static constexpr Eigen::Index block = 64;
  /// Not inlined: g++ vectorises the loops on their own, and not within the chain.
  template <class... Sum>
  SEMIEXPLICIT_NOINLINE void flow_in_blocks(const Scalar& t, const Scalar* __restrict from,
                                            Scalar* __restrict to, Scalar* __restrict gradient,
                                            Eigen::Index d, Sum* __restrict... sum) const {
    for (Eigen::Index begin = 0; begin < d; begin += block) {
      const Eigen::Index size = std::min(block, d - begin);
      hamiltonian.gradient_range(begin, begin + size, from, from + d, gradient, gradient + size);
      kick(t, gradient, to + begin, (sum + begin)..., size, d);
    }
  }

  void run_in_lanes([[maybe_unused]] const Vec& from_a, [[maybe_unused]] const Vec& from_b,
                    [[maybe_unused]] const Scalar& dt, [[maybe_unused]] Vec& sum) {
#ifdef SEMIEXPLICIT_HAS_LANES
    using Point = LanePoint<Dof>;
    Point at_a = Point::load(from_a.data()), at_b = Point::load(from_b.data()), moved{};
    const auto flow = [&](const Scalar& t, const Point& from, Point& to) {
      Lanes dHdq[Point::size], dHdp[Point::size];
      hamiltonian.lane_gradient(from.q, from.p, dHdq, dHdp);
      for (int k = 0; k < Point::size; ++k) {
        to.q[k] += t * dHdp[k];
        to.p[k] -= t * dHdq[k];
        moved.q[k] += t * dHdp[k];
        moved.p[k] -= t * dHdq[k];
      }
    };
    const std::size_t n = scheme.b.size();
    for (std::size_t i = 0; i < n; ++i) {
      flow(dt * scheme.a[i], at_a, at_b);
      flow(dt * scheme.b[i], at_b, at_a);
    }
    flow(dt * scheme.a[n], at_a, at_b);
    at_a.store(a.data());
    at_b.store(b.data());
    moved.store(sum.data());
#endif
  }

  Vec gradient_;
};

}  // namespace semiexplicit::detail
