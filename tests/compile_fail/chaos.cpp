// case no_mistake: compiles
// case no_derivative: the derivative of this stepper's step is not known: give TangentVectors, LyapunovExponents
// case of_a_hamiltonian: this stepper does not say what it moves: write `using Scalar = double; using State =
// case hessian_not_const: hessian of this Hamiltonian cannot be called: write `void hessian(In<Scalar, Dof> q
// case hessian_into_matrix: hessian of this Hamiltonian cannot be called: write `void hessian(In<Scalar, Dof> q
// case times_of_halves: hessian_times of this Hamiltonian cannot be called: write `void hessian_times(In<Scalar
// case map_of_hessian_not_const: hessian of this Hamiltonian cannot be called: write `void hessian(In<Scalar, Dof> q
#include <semiexplicit/chaos.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/tao.hpp>
#include <semiexplicit/systems/product.hpp>

using namespace semiexplicit;

struct Mine {
  using Scalar = double;
  static constexpr int Dof = 1;
  using Column = In<double, 1>;
  using Half = Out<double, 1>;
  void gradient(Column q, Column p, Half dHdq, Half dHdp) const { dHdq = q, dHdp = p; }
#if defined(hessian_not_const) || defined(map_of_hessian_not_const)
  void hessian(Column, Column, Eigen::Ref<Eigen::Matrix2d> result) { result.setIdentity(); }
#elif defined(hessian_into_matrix)
  void hessian(Column, Column, Eigen::Matrix2d& result) const { result.setIdentity(); }
#elif defined(times_of_halves)
  void hessian_times(Column, Column, Column dq, Column dp, Eigen::VectorXd& hq, Eigen::VectorXd& hp) const {
    hq = dq, hp = dp;
  }
#endif
};

int main() {
#ifdef no_derivative
  const Tao stepper(systems::Product<double>(), schemes::strang(), 10);
#elif defined(of_a_hamiltonian)
  const systems::Product<double> stepper;
#elif defined(hessian_not_const) || defined(hessian_into_matrix) || defined(times_of_halves) || \
    defined(map_of_hessian_not_const)
  const Semiexplicit stepper(Mine(), schemes::strang());
#else
  const Semiexplicit stepper(systems::Product<double>(), schemes::strang());
#endif
#ifdef map_of_hessian_not_const
  TangentMap map(Mine(), schemes::strang());
#endif
  const LyapunovExponents lyapunov(stepper, 1);
}
