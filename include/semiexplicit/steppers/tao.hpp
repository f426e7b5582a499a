#pragma once

#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include <semiexplicit/steppers/detail/explicit_map.hpp>

namespace semiexplicit {

/// Tao's explicit map: Pihajoki's kicks and a third flow C of ω/2 ‖a - b‖², which turns the difference of the
/// copies and so keeps it bounded. One stage is A(h/2) B(h/2) C(h) B(h/2) A(h/2); stages are composed with
/// the weights of the scheme, neighbouring A kicks merged, so s stages cost 3s gradient calls: the last one
/// of a step is the first of the next, and only a run's first step calls once more. Symplectic in the doubled
/// space only.
///
/// ω is a matter of trial: too small, and the copies separate; 2ωh near a multiple of π swaps or freezes
/// them.
///
/// Source: M. Tao, Phys. Rev. E 94 (2016) 043303. Memory: four vectors of length 2d, and H.
template <class H>
class Tao {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = ExtendedPoint<Scalar, Dof>;
  static constexpr const char* name = "Tao";

  /// Throws std::invalid_argument unless the scheme passes its own check and is a composition of Strang, as
  /// strang, triple_jump, suzuki, yoshida6, kahan_li6 and 8, suzuki_umeno8 and sofroniou_spaletta6 to 10 are:
  /// a direct list of A and B coefficients says nothing about C. Also unless ω is finite.
  Tao(H hamiltonian, Scheme<Scalar> scheme, Scalar omega)
      : map_(std::move(hamiltonian), std::move(scheme)),
        omega_(std::move(omega)),
        turns_(map_.scheme.b.size()) {
    using std::isfinite;
    require_composition_of_strang();
    if (!isfinite(omega_)) throw std::invalid_argument("Tao: omega is NaN or Inf; give a finite number");
  }

  /// One step of size dt, as Pihajoki::step().
  StepReport step(State& zeta, const Scalar& dt) {
    // The map still holds the copies that the last step left, and the gradient at a.
    const bool known = std::exchange(gradient_known_, false) &&
                       on_all_ranks<Scalar>(hamiltonian(), map_.a.size() == zeta.a.vector().size() &&
                                                               map_.a == zeta.a.vector());
    const auto gradients = static_cast<std::int64_t>(3 * scheme().b.size() + (known ? 0 : 1));
    find_turns(dt);
    const StepReport report = map_.step(zeta, dt, gradients, [&](auto* a, auto* b, auto* gradient, auto d) {
      kicks(dt, known, a, b, gradient, d);
    });
    gradient_known_ = report.ok();
    return report;
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return map_.hamiltonian; }
  const Scheme<Scalar>& scheme() const { return map_.scheme; }
  const Scalar& omega() const { return omega_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("scheme", scheme());
    list("omega", omega_);
    list.function("Hamiltonian", GradientSize(hamiltonian()));
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(map_.a);  // where the gradient was taken
    visit(map_.gradient);
    visit(gradient_known_);
  }

 private:
  template <class Number, class Size>
  void kicks(const Scalar& dt, bool known, Number* a, Number* b, Number* gradient, Size d) const {
    const auto move = [&](const Scalar& t, Number* to) { detail::add(t, gradient, to, d, d); };
    const auto gradient_at = [&](const Number* at) { detail::gradient_on(hamiltonian(), at, gradient, d); };
    if (!known) gradient_at(a);
    for (std::size_t i = 0; i < scheme().b.size(); ++i) {
      const Scalar h = dt * scheme().b[i];
      move(Scalar(dt * scheme().a[i]), b);
      gradient_at(b);
      move(Scalar(h / 2), a);
      rotate(turns_[i], a, b, d);
      gradient_at(b);
      move(Scalar(h / 2), a);
      gradient_at(a);
    }
    move(Scalar(dt * scheme().a.back()), b);
  }

  /// Cosine and sine of the angle by which the flow C of a stage turns.
  struct Turn {
    Scalar cosine, sine;
  };
  void find_turns(const Scalar& dt) {
    using std::cos;
    using std::sin;
    if (dt == turns_dt_) return;
    for (std::size_t i = 0; i < turns_.size(); ++i) {
      const Scalar angle = 2 * omega_ * (dt * scheme().b[i]);
      turns_[i] = {cos(angle), sin(angle)};
    }
    turns_dt_ = dt;
  }

  /// The flow C: the means of q, x and of p, y stay; the difference (q - x, p - y) turns clockwise.
  template <class T>
  static void rotate(const Turn& by, T& q, T& x, T& p, T& y) {
    const T dq = (q - x) / 2, dp = (p - y) / 2;
    const T mean_q = (q + x) / 2, mean_p = (p + y) / 2;
    const T turned_q = by.cosine * dq + by.sine * dp, turned_p = by.cosine * dp - by.sine * dq;
    q = mean_q + turned_q;
    x = mean_q - turned_q;
    p = mean_p + turned_p;
    y = mean_p - turned_p;
  }
  /// The same for a = (q, y) and b = (x, p).
  template <class Number>
  static void rotate(const Turn& by, Number* __restrict a, Number* __restrict b, Eigen::Index d) {
    for (Eigen::Index k = 0; k < d; ++k) rotate(by, a[k], b[k], b[d + k], a[d + k]);
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
            "kahan_li8, suzuki_umeno8 or sofroniou_spaletta10, or compose() one from strang");
    }
  }

  detail::ExplicitMap<H> map_;
  Scalar omega_;
  bool gradient_known_ = false;
  std::vector<Turn> turns_;  ///< a stage each, of steps of turns_dt_
  Scalar turns_dt_ = Scalar(0);
};

}  // namespace semiexplicit
