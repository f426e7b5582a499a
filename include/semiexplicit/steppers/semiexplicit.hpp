#pragma once

#include <concepts>
#include <cstdint>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/solver.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>
#include <semiexplicit/steppers/detail/doubled_step.hpp>

namespace semiexplicit {

/// The semiexplicit symplectic integrator: Pihajoki's explicit map bound by a symmetric projection. A step
/// looks for the multiplier m with which the copies, parted by +m and -m before the map and again after it,
/// end equal:
///
///     f(m) = a' - b' + 2m = 0,   (a', b') = map(z + m, z - m),   z' = (a' + b')/2.
///
/// The map z → z' is symplectic in the original phase space and symmetric, keeps linear and quadratic
/// invariants of H to the accuracy of the solve, and has the order of the scheme. Finishing with the mean
/// makes what is left of f enter those properties at second order only, which is why a loose solve is enough
/// (StoppingRule::product).
///
/// Source: B. Jayawardana and T. Ohsawa, Math. Comp. 92 (2023) 251, Definition 2.1; the invariants: T.
/// Ohsawa, arXiv:2208.10546. Memory: four vectors of length 2d, seven where 2d > 32, and the solver's
/// (simplified Newton one, Broyden memory + 2).
template <class H, class Solver = SimplifiedNewton>
class Semiexplicit {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static_assert(detail::solver_goes_with<H, Solver>());
  static constexpr const char* name = "Semiexplicit";

  /// Throws std::invalid_argument, saying what is wrong, unless the scheme passes its own check and the
  /// solver's options make sense.
  Semiexplicit(H hamiltonian, Scheme<Scalar> scheme, Solver solver = {},
               Summation summation = Summation::compensated)
      : Semiexplicit(detail::DoubledStep<H>(std::move(hamiltonian), std::move(scheme), summation),
                     std::move(solver)) {}

  /// The same with the usual scheme, low_defect6_s13.
  explicit Semiexplicit(H hamiltonian) : Semiexplicit(std::move(hamiltonian), usual_scheme<Scalar>(false)) {}

  /// The same scheme, solver and summation with another Hamiltonian, and no memory of earlier steps.
  Semiexplicit with(H hamiltonian) const { return {doubled_.with(std::move(hamiltonian)), solver_}; }

  /// One step of size dt, which may be negative. z is untouched unless the report is ok(); so it stays where
  /// a gradient throws. No heap use.
  StepReport step(State& z, const Scalar& dt) {
    StepReport report{.status = doubled_.check(z, dt)};
    if (!report.ok()) return report;
    Residual residual{doubled_, z, dt};
    const auto solved = solver_.solve(residual, m_, work_);
    solved.tell(report);
    report.gradients = solved.evaluations * doubled_.gradients();
    if (report.ok() && !doubled_.finish(z)) report.status = Status::not_finite;
    if (report.status == Status::not_finite) report.status = doubled_.diagnose(z);
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const requires std::same_as<Solver, SimplifiedNewton> {
    return solver_.max_iterations * doubled_.gradients();
  }

  Eigen::Index dof() const { return dof_of(hamiltonian()); }
  const H& hamiltonian() const { return doubled_.hamiltonian(); }
  const Scheme<Scalar>& scheme() const { return doubled_.scheme(); }
  Summation summation() const { return doubled_.summation(); }
  const Solver& solver() const { return solver_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    doubled_.describe(list);
    list("solver", solver_);
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    doubled_.visit_memory(visit);
  }

 private:
  using Vec = typename State::Storage;

  Semiexplicit(detail::DoubledStep<H> doubled, Solver solver)
      : doubled_(std::move(doubled)),
        solver_(std::move(solver)),
        m_(State(dof()).vector()),
        work_(solver_, m_.size()) {}

  struct Norms {
    const detail::DoubledStep<H>& step;
    const State& z;
    Scalar size() const { return detail::state_size(step.hamiltonian(), z); }
    Scalar distance() const { return step.distance(); }
    Scalar sum_over_ranks(const Scalar& x) const requires SumsOverRanks<H> {
      return step.hamiltonian().sum_over_ranks(x);
    }
  };
  /// f as the solvers see it: a function of m that also knows the sizes that their stopping is judged by.
  struct Residual : detail::ResidualSizes<Scalar, Norms> {
    Residual(detail::DoubledStep<H>& step, const State& start, const Scalar& of_dt)
        : detail::ResidualSizes<Scalar, Norms>{.z_data = start.vector().data(),
                                               .count = start.vector().size(),
                                               .norms = {step, start}},
          doubled(step),
          z(start),
          dt(of_dt) {}

    /// f(0), where every solver starts.
    void operator()(Vec& f) { evaluate(nullptr, f); }
    void operator()(const Vec& m, Vec& f) { evaluate(&m, f); }
    void evaluate(const Vec* m, Vec& f) {
      doubled.residual(z, m, dt, f);
      this->f_data = f.data();
    }
    detail::SizesOfHalves<Scalar> halves() const {
      return detail::sizes_of_halves(this->norms, z.vector(), doubled.moved(), detail::own_dof<H>(z.dof()));
    }

    detail::DoubledStep<H>& doubled;
    const State& z;
    const Scalar& dt;
  };

  detail::DoubledStep<H> doubled_;
  Solver solver_;
  Vec m_;
  typename detail::SolverDoor<Solver, Vec>::Workspace work_;
};

}  // namespace semiexplicit
