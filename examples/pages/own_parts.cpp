// A solver, a stepper and an observer of one's own: checked by their concepts, usable with all the rest, and
// ready for checkpoints.
#include <cstdint>
#include <iostream>
#include <utility>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

using namespace semiexplicit;

/// Solver: simplified Newton with a fixed number of evaluations, so that every step takes the same time.
struct FixedWork {
  static constexpr const char* name = "FixedWork";
  int evaluations = 3;

  template <class List>
  void describe(List& list) const {
    list("evaluations", evaluations);
  }
  template <class Vec>
  struct Workspace {
    Workspace(const FixedWork&, Eigen::Index size) : f(Vec::Zero(size)) {}
    Vec f;
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
    m.setZero();
    residual(work.f);  // f(0)
    for (int i = 1; i < evaluations; ++i) {
      m -= work.f / 4;
      residual(m, work.f);  // f(m); the last one is that of the accepted m
    }
    return {.status = work.f.allFinite() ? Status::success : Status::not_finite,
            .evaluations = evaluations,
            .correction = work.f.norm() / 4};
  }
};

/// Stepper: the implicit midpoint rule z' = z + dt X((z + z')/2), by fixed-point iteration.
template <Hamiltonian H>
class ImplicitMidpoint {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  static constexpr const char* name = "ImplicitMidpoint";

  explicit ImplicitMidpoint(H hamiltonian) : hamiltonian_(std::move(hamiltonian)) {}

  StepReport step(State& z, const Scalar& dt) {
    StepReport report;
    State next = z;
    double change = 1;
    while (change > 1e-15 && report.evaluations < 100) {
      const State middle((z.q() + next.q()) / 2, (z.p() + next.p()) / 2);
      Vector<Scalar, H::Dof> dHdq, dHdp;
      hamiltonian_.gradient(middle.q(), middle.p(), dHdq, dHdp);
      const State moved(z.q() + dt * dHdp, z.p() - dt * dHdq);
      change = (moved.vector() - next.vector()).norm();
      next = moved;
      ++report.evaluations;
      ++report.gradients;
    }
    report.correction = change;
    report.status = !next.vector().allFinite() ? Status::not_finite
                    : change > 1e-15           ? Status::no_convergence
                                               : Status::success;
    if (report.ok()) z = next;  // else the state stays as it was
    return report;
  }

  const H& hamiltonian() const { return hamiltonian_; }

  template <class List>
  void describe(List& list) const {
    list.function("Hamiltonian", GradientSize(hamiltonian_));
  }
  template <class Visitor>
  void visit_memory(Visitor&&) {}  // it remembers nothing

 private:
  H hamiltonian_;
};

/// Observer: counts the turns of q from rising to falling.
class Turns {
 public:
  static constexpr const char* name = "Turns";

  template <class State>
  void operator()(double, const State& z) {
    if (seen_ && z.q()[0] < last_ && rising_) ++count_;
    rising_ = z.q()[0] > last_;
    last_ = z.q()[0];
    seen_ = true;
  }
  std::int64_t count() const { return count_; }

  template <class List>
  void describe(List&) const {}  // it has no options
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(last_);
    visit(rising_);
    visit(seen_);
    visit(count_);
  }
  bool fresh() const { return !seen_; }

 private:
  double last_ = 0;
  bool rising_ = false, seen_ = false;
  std::int64_t count_ = 0;
};

using State = PhasePoint<double, 1>;
static_assert(Solver<FixedWork, State::Storage> && Describable<FixedWork>);
static_assert(Stepper<ImplicitMidpoint<systems::Product<>>> &&
              Checkpointable<ImplicitMidpoint<systems::Product<>>>);
static_assert(Observer<Turns, double, State> && Checkpointable<Turns>);

int main() {
  const systems::Product<> H;  // (q² + 1)(p² + 1)/2: from (-3, 0) the period is about 3.26
  Semiexplicit projected(H, schemes::low_defect6_s13<double>(), FixedWork{.evaluations = 2});
  ImplicitMidpoint midpoint(H);

  State z(-3, 0), z_midpoint(-3, 0);
  Invariants invariants(H), invariants_midpoint(H);
  Turns turns, turns_midpoint;
  const IntegrationReport run = integrate(projected, z, {.dt = 0.05, .steps = 2000}, invariants, turns);
  integrate(midpoint, z_midpoint, {.dt = 0.05, .steps = 2000}, invariants_midpoint, turns_midpoint);

  std::cout << "projected, " << run.evaluations / run.steps << " evaluations a step: energy error "
            << invariants["energy"].worst << ", " << turns.count() << " turns\n"
            << "implicit midpoint rule: energy error " << invariants_midpoint["energy"].worst << ", "
            << turns_midpoint.count() << " turns\n";
  return invariants["energy"].worst < 1e-8 && invariants_midpoint["energy"].worst < 0.1 && turns.count() > 20
             ? 0
             : 1;
}
