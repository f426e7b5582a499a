#pragma once

#include <cstdint>
#include <utility>

#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>

namespace semiexplicit::detail {

/// What the explicit maps of the doubled space share: H, the scheme, and copies on which a step is tried
/// before it counts. Three vectors of length 2d.
template <class H>
class ExplicitMap {
 public:
  using Scalar = typename HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = HamiltonianDoor<H>::Dof;
  using State = ExtendedPoint<Scalar, Dof>;
  using Vec = typename PhasePoint<Scalar, Dof>::Storage;

  ExplicitMap(H h, Scheme<Scalar> s)
      : hamiltonian(std::move(h)),
        scheme(std::move(s)),
        a(PhasePoint<Scalar, Dof>(dof_of(hamiltonian)).vector()),
        b(a),
        gradient(a) {
    scheme.check();
  }

  /// Moves zeta by run(a, b, gradient, d), which works on arrays of 2d numbers, or of registers that hold
  /// them; only a finite result becomes the new state.
  template <class Run>
  StepReport step(State& zeta, const Scalar& dt, std::int64_t gradients, const Run& run) {
    const bool fits = on_all_ranks<Scalar>(
        hamiltonian, zeta.a.vector().size() == a.size() && zeta.b.vector().size() == b.size());
    StepReport report{.status = status_at_start(dt, !scheme.b.empty(), fits)};
    if (!report.ok()) return report;
    a = zeta.a.vector();
    b = zeta.b.vector();
    inlined<Scalar>([&] {
      if constexpr (fits_on_stack(Dof)) {
        typename WorkPoint<H>::Type at_a, at_b, slope;
        at_a.load(a.data());
        at_b.load(b.data());
        slope.load(gradient.data());
        run(at_a.data, at_b.data, slope.data, slope.d);
        at_a.store(a.data());
        at_b.store(b.data());
        slope.store(gradient.data());
      } else {
        run(a.data(), b.data(), gradient.data(), dof_of(hamiltonian));
      }
    });
    report = {.status = Status::not_finite, .evaluations = 1, .gradients = gradients};
    const auto finite = [this](const Vec& u, const Vec& v) {
      return on_all_ranks<Scalar>(hamiltonian, all_finite(u) && all_finite(v));
    };
    if (!finite(a, b)) {
      if (!finite(zeta.a.vector(), zeta.b.vector())) report.status = Status::invalid_state;
    } else {
      zeta.a.vector() = a;
      zeta.b.vector() = b;
      report.status = Status::success;
    }
    return report;
  }

  H hamiltonian;
  Scheme<Scalar> scheme;
  Vec a, b, gradient;
};

}  // namespace semiexplicit::detail
