// case no_mistake: compiles
// case gauss: what is asked of it here takes norms of one process's state
// case transformed: what is asked of it here takes norms of one process's state
// case sum_not_const: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_in_place: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case sum_of_nothing: sum_over_ranks of this Hamiltonian cannot be called: write `Scalar sum_over_ranks(const Scalar& x) const`
// case solver_of_one_process: has sum_over_ranks(), so that the solver has to take norms by
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
  Semiexplicit stepper(Block{}, schemes::strang<double>(), OwnSolver{});
#if defined(gauss)
  GaussLegendre other(Block{});
#elif defined(transformed)
  TimeTransformed other(Block{}, monitors::Distance{}, 1.0);
#endif
}
