// case no_mistake: compiles
// case gauss_method: what is asked of it here takes norms of one process's state
// case transformed: what is asked of it here takes norms of one process's state
// case reversible_steps_over_ranks: what is asked of it here takes norms of one process's state
// case field_size_over_ranks: what is asked of it here takes norms of one process's state
// case time_scale_over_ranks: what is asked of it here takes norms of one process's state
// case advised: what is asked of it here takes norms of one process's state
// case events_on_one_rank: what is asked of it here takes norms of one process's state
// case section_on_one_rank: what is asked of it here takes norms of one process's state
// case estimate_on_one_rank: what is asked of it here takes norms of one process's state
// case in_ensemble: what is asked of it here takes norms of one process's state
// case sum_of_columns: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_of_whole_numbers: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_not_const: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_in_place: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_of_nothing: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case solver_of_one_process: has sum_over_ranks(), so that the solver has to take norms by
#include <vector>

#include <semiexplicit/accuracy.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/time.hpp>

using namespace semiexplicit;

struct Block {
  using Scalar = double;
  static constexpr int Dof = 2;
#if defined(sum_not_const)
  double sum_over_ranks(const double& x) { return x; }
#elif defined(sum_in_place)
  double sum_over_ranks(double& x) const { return x; }
#elif defined(sum_of_columns)
  void sum_over_ranks(double* x, int n) const { (void)x, (void)n; }
#elif defined(sum_of_whole_numbers)
  int sum_over_ranks(int x) const { return x; }
#elif defined(sum_of_nothing)
  void sum_over_ranks(const double&) const {}
#else
  double sum_over_ranks(const double& x) const { return x; }
#endif
  double energy(In<double, 2> q, In<double, 2> p) const { return (q.squaredNorm() + p.squaredNorm()) / 2; }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

struct OwnSolver {
#ifndef solver_of_one_process
  static constexpr bool over_ranks = true;
#endif
  template <class Vec>
  struct Workspace {
    Workspace(const OwnSolver&, Eigen::Index) {}
  };
  template <class Residual, class Vec>
  SolverReport<typename Vec::Scalar> solve(Residual&, Vec&, Workspace<Vec>&) const {
    return {};
  }
};

int main() {
  [[maybe_unused]] PhasePoint<double, 2> z({1, 2}, {0, 0});
  Semiexplicit stepper(Block{}, schemes::strang<double>(), OwnSolver{});
  [[maybe_unused]] const auto first = [](const auto& q, const auto&) { return q[0]; };
#if defined(gauss_method)
  GaussLegendre other(Block{});
#elif defined(advised)
  run(Block{}, z, 1.0, Setting{});
#elif defined(events_on_one_rank)
  auto watch = events(Block{}, on_event(first, [](double, PhasePoint<double, 2>& at) { at.p()[0] = 1; }));
#elif defined(section_on_one_rank)
  auto section = poincare_section(Block{}, first, [](double, const auto&) {});
#elif defined(estimate_on_one_rank)
  auto estimate = with_error_estimate(stepper);
#elif defined(in_ensemble)
  Ensemble other(Block{}, std::vector{z});
#elif defined(reversible_steps_over_ranks)
  ReversibleSteps other(stepper, [](const auto&, const auto&) { return 1.0; });
#elif defined(field_size_over_ranks)
  monitors::FieldSize other(Block{});
#elif defined(time_scale_over_ranks)
  monitors::TimeScale other(Block{});
#elif defined(transformed)
  TimeTransformed other(Block{}, monitors::Distance{}, 1.0);
#endif
}
