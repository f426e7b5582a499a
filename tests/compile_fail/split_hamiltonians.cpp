// case no_mistake: compiles
// case not_const: rest_position_gradient of this Hamiltonian cannot be called: write `void rest_position_gradient(In<Scalar
// case other_output: rest_position_gradient of this Hamiltonian cannot be called: write `void rest_position_gradient(In<Scalar
// case template_not_const: rest_position_gradient of this Hamiltonian cannot be called: write `void rest_position_gradient(In<Scalar
// case template_of_both: rest_position_gradient of this Hamiltonian cannot be called: write `void rest_position_gradient(In<Scalar
// case output_by_value: takes an output by value, so what it writes is lost: take it as `auto& dq`
// case momentum_not_const: rest_momentum_gradient of this Hamiltonian cannot be called: write `void rest_momentum_gradient(In<Scalar
// case by_value: coupled_rest of this Hamiltonian cannot be called: write `const C& coupled_rest() const`
// case coupled_not_const: coupled_rest of this Hamiltonian cannot be called: write `const C& coupled_rest() const`
// case no_hamiltonian: coupled_rest of this Hamiltonian cannot be called: write `const C& coupled_rest() const`
// case stale_prepared: has a flow() of its own and inherits prepared(), which is asked instead: write both
// case quadratic_function: flow_is_quadratic of this Hamiltonian is a function: write `static constexpr bool
// case flow_of_whole_time: flow or prepared of this Hamiltonian takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case prepared_of_float: flow or prepared of this Hamiltonian takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case rest_answers: rest_position_gradient or rest_momentum_gradient of this Hamiltonian returns a bool, an int or a Status, and nobody asks: let it return nothing
// case rest_time_last: rest_position_gradient or rest_momentum_gradient of this Hamiltonian ends with a number, which would always be its default
// case coupled_into_copies: takes dHdq or dHdp by value, so what it writes is lost: take both as Out<Scalar, Dof>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

using Read = In<double, 1>;
using Write = Out<double, 1>;

struct Coupling {
  using Scalar = double;
  static constexpr int Dof = 1;
#ifdef coupled_into_copies
  using Written = Vector<double, 1>;
#else
  using Written = Write;
#endif
#ifndef no_hamiltonian
  void gradient(Read q, Read p, Written dHdq, Written dHdp) const {
    dHdq[0] = q[0] * p[0] * p[0];
    dHdp[0] = q[0] * q[0] * p[0];
  }
#endif
};

struct Anharmonic {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(Read q, Read p, Write dHdq, Write dHdp) const {
    dHdq[0] = q[0] + q[0] * q[0] * q[0];
    dHdp[0] = p[0] + p[0] * p[0] * p[0];
  }
#ifdef flow_of_whole_time
  Status flow(int, const auto&, const auto&, auto&, auto&) const { return Status::success; }
#else
  Status flow(double, const auto&, const auto&, auto&, auto&) const { return Status::success; }
#endif
  std::string flow_name() const { return "oscillator"; }
  struct Prepared {
    Status increments(const auto&, const auto&, auto&, auto&) const { return Status::success; }
  };
#ifdef prepared_of_float
  Prepared prepared(float) const { return {}; }
#else
  Prepared prepared(double) const { return {}; }
#endif
#ifdef quadratic_function
  static constexpr bool flow_is_quadratic() { return false; }
#endif

#if defined(not_const)
  void rest_position_gradient(Read q, Write dHdq) { dHdq[0] = q[0] * q[0] * q[0]; }
#elif defined(template_not_const)
  void rest_position_gradient(const auto& q, auto& dHdq) { dHdq[0] = q[0] * q[0] * q[0]; }
#elif defined(template_of_both)
  void rest_position_gradient(const auto& q, const auto&, auto& dHdq) const { dHdq[0] = q[0] * q[0] * q[0]; }
#elif defined(rest_answers)
  Status rest_position_gradient(Read q, Write dHdq) const {
    dHdq[0] = q[0] * q[0] * q[0];
    return Status::success;
  }
#elif defined(rest_time_last)
  void rest_position_gradient(const auto& q, auto& dHdq, double t = 1) const {
    dHdq[0] = t * q[0] * q[0] * q[0];
  }
#elif defined(output_by_value)
  void rest_position_gradient(Read q, Vector<double, 1> dHdq) const { dHdq[0] = q[0] * q[0] * q[0]; }
#elif defined(other_output)
  void rest_position_gradient(Read q, Eigen::VectorXd& dHdq) const { dHdq[0] = q[0] * q[0] * q[0]; }
#else
  void rest_position_gradient(Read q, Write dHdq) const { dHdq[0] = q[0] * q[0] * q[0]; }
#endif
#if defined(momentum_not_const)
  void rest_momentum_gradient(Read p, Write dHdp) { dHdp[0] = p[0] * p[0] * p[0]; }
#else
  void rest_momentum_gradient(Read p, Write dHdp) const { dHdp[0] = p[0] * p[0] * p[0]; }
#endif
#if defined(by_value)
  Coupling coupled_rest() const { return {}; }
#elif defined(coupled_not_const)
  const Coupling& coupled_rest() { return coupling; }
#else
  const Coupling& coupled_rest() const { return coupling; }
#endif
  Coupling coupling;
};

struct Pulled : Anharmonic {
  Status flow(double, const auto&, const auto&, auto& dq, auto&) const {
    dq[0] = 1;
    return Status::success;
  }
};

int main() {
#ifdef stale_prepared
  FlowSplitting other(Pulled{}, schemes::aba82<double>());
#endif
  FlowSplitting stepper(Anharmonic{}, schemes::aba82<double>());
  PhasePoint<double, 1> z(1, 0);
  (void)stepper.step(z, 0.1);
}
