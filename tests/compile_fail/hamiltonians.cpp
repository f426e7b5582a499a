// case no_mistake: compiles
// case no_scalar: does not say what it computes with: write `using Scalar = double;`
// case no_dof: does not say how many degrees of freedom it has: write `static constexpr int Dof = 2;`
// case dof_not_static: Dof of this Hamiltonian is no constant above 0: write `static constexpr int Dof = 2;`
// case dof_zero: Dof of this Hamiltonian is no constant above 0: write `static constexpr int Dof = 2;`
// case dynamic_without_dof: says its size at run time: write `Eigen::Index dof() const
// case no_gradient: has no public gradient of (q, p): write `void gradient(
// case gradient_not_const: the gradient of this Hamiltonian is not const: write `const` behind its parameters
// case gradient_returned: the gradient of this Hamiltonian takes other arguments: write `void gradient(
// case gradient_of_vectors: the gradient of this Hamiltonian takes other arguments: write `void gradient(
// case gradient_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case gradient_by_temporary: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case static_gradient_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case mixed_gradient_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case template_gradient_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case gradient_of_other_size: takes columns of another size or of other numbers than its Dof and Scalar: write
// case gradient_of_floats: takes columns of another size or of other numbers than its Dof and Scalar: write
// case time_dependent: depends on the time: give the stepper Autonomous(H)
// case hessian_by_value: takes an output by value, so what it writes is lost: take it as
// case driven_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case template_hessian_by_value: takes an output by value, so what it writes is lost: take it as
// case driven_template_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case driven_of_vectors: cannot be called with the time: write `void gradient(const Scalar& t, In<Scalar
// case driven_not_const: cannot be called with the time: write `void gradient(const Scalar& t, In<Scalar
// case driven_without_time: does not depend on the time: give the stepper H itself
// case time_last: ends with a number, which would always be its default: the time comes first
// case gradient_returns_a_code: returns a bool, an int or a Status, and nobody asks: let it return nothing, and throw, or write NaN
// case gradient_answers: returns a bool, an int or a Status, and nobody asks: let it return nothing, and throw, or write NaN
// case separable_function: separable of this Hamiltonian is a function: write `static constexpr bool separable = true;`
// case referred_lambda_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case driven_returns_float: returns another number than a Scalar: let it return dH/dt as a Scalar, or nothing
// case driven_returns_integer: returns another number than a Scalar: let it return dH/dt as a Scalar, or nothing
// case driven_at_whole_times: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case driven_energy_of_float: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case time_derivative_of_whole_times: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case time_derivative_not_const: time_derivative of this Hamiltonian cannot be called: write `Scalar time_derivative(const
// case driven_of_other_size: takes columns of another size or of other numbers than its Dof and Scalar: write
// case lambda_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case mixed_lambda_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case function_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
// case any_time_last: ends with a number, which would always be its default: the time comes first
// case halves_answer: position_gradient or momentum_gradient of this Hamiltonian returns a bool, an int or a Status, and nobody asks: let it return nothing
// case hessian_answers: position_gradient or momentum_gradient of this Hamiltonian returns a bool, an int or a Status, and nobody asks: let it return nothing
// case halves_time_last: position_gradient or momentum_gradient of this Hamiltonian ends with a number, which would always be its default
// case driven_answers: the gradient of this Hamiltonian returns a bool, an int or a Status, and nobody asks: let it return nothing
// case time_derivative_of_float: energy or time_derivative of this Hamiltonian is a whole number, or one of fewer digits than Scalar
// case driven_energy_is_whole: energy or time_derivative of this Hamiltonian is a whole number, or one of fewer digits than Scalar
// case lambda_answers: make_hamiltonian: the gradient returns a bool, an int or a Status, and nobody asks: let it return nothing
// case lambda_time_last: make_hamiltonian: a function takes a number behind the others, which would always be its default
// case lambda_energy_time_last: make_hamiltonian: a function takes a number behind the others, which would always be its default
// case lambda_energy_is_whole: make_hamiltonian: the energy is a whole number, or one of fewer digits than Scalar
// case longer_by_value: takes dHdq or dHdp by value, so what it writes is lost: take both as
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>
#include <semiexplicit/time/autonomous.hpp>

using namespace Eigen;  // whose names are others
using namespace semiexplicit;
using Column = In<double, 2>;
using Half = Out<double, 2>;

struct Mine {
#ifndef no_scalar
  using Scalar = double;
#endif

#if defined(no_dof)
#elif defined(dof_not_static)
  int Dof = 2;
#elif defined(dof_zero)
  static constexpr int Dof = 0;
#elif defined(dynamic_without_dof)
  static constexpr int Dof = Eigen::Dynamic;
#else
  static constexpr int Dof = 2;
#endif

#if defined(no_gradient)
  double energy(Column q, Column p) const { return q.dot(p); }
#elif defined(gradient_not_const)
  void gradient(Column q, Column p, Half dHdq, Half dHdp) { dHdq = p, dHdp = q; }
#elif defined(gradient_returned)
  Eigen::Vector4d gradient(Column q, Column p) const { return {p[0], p[1], q[0], q[1]}; }
#elif defined(gradient_of_vectors)
  void gradient(const Eigen::VectorXd& q, const Eigen::VectorXd& p, Eigen::VectorXd& dHdq,
                Eigen::VectorXd& dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(gradient_by_value)
  void gradient(Column q, Column p, Eigen::Vector2d dHdq, Eigen::Vector2d dHdp) const { dHdq = p, dHdp = q; }
#elif defined(gradient_by_temporary)
  void gradient(Column q, Column p, Eigen::Vector2d&& dHdq, Eigen::Vector2d&& dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(static_gradient_by_value)
  static void gradient(Column q, Column p, Half dHdq, Eigen::Vector2d dHdp) { dHdq = p, dHdp = q; }
#elif defined(mixed_gradient_by_value)
  void gradient(const auto& q, const auto& p, auto& dHdq, Eigen::Vector2d dHdp) const { dHdq = p, dHdp = q; }
#elif defined(longer_by_value)
  void gradient(const auto& q, const auto& p, Eigen::VectorXd dHdq, Eigen::VectorXd dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(template_gradient_by_value)
  template <class T>
  void gradient(T q, T p, Eigen::Matrix<double, 2, 1> dHdq, Half dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(gradient_of_other_size)
  void gradient(In<double, 3> q, In<double, 3> p, Out<double, 3> dHdq, Out<double, 3> dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(gradient_of_floats)
  void gradient(In<float, 2> q, In<float, 2> p, Out<float, 2> dHdq, Out<float, 2> dHdp) const {
    dHdq = p, dHdp = q;
  }
#elif defined(time_last)
  void gradient(Column q, Column p, Half dHdq, Half dHdp, double t = 0) const { dHdq = t * p, dHdp = q; }
#elif defined(any_time_last)
  void gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp, double t = 0) const {
    dHdq = t * p, dHdp = q;
  }
#elif defined(gradient_returns_a_code)
  int gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq = q;
    dHdp = p;
    return 0;
  }
#elif defined(gradient_answers)
  bool gradient(Column q, Column p, Half dHdq, Half dHdp) const {
    dHdq = p, dHdp = q;
    return false;
  }
#elif defined(time_dependent)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = q; }
#else
  void gradient(Column q, Column p, Half dHdq, Half dHdp) const { dHdq = p, dHdp = q; }
#endif
#ifdef halves_answer
  bool position_gradient(Column q, Half dHdq) const {
    dHdq = q;
    return true;
  }
#elif defined(halves_time_last)
  void momentum_gradient(const auto& p, auto& dHdp, double t = 0) const { dHdp = t * p; }
#elif defined(hessian_answers)
  Status hessian(const auto&, const auto&, auto& matrix) const {
    matrix.setIdentity();
    return Status::success;
  }
#endif
#ifdef separable_function
  static constexpr bool separable() { return false; }
#endif
#ifdef hessian_by_value
  void hessian_times(Column, Column, Column dq, Column dp, Eigen::Vector2d hq, Eigen::Vector2d hp) const {
    hq = dp, hp = dq;
  }
#elif defined(template_hessian_by_value)
  void hessian(const auto&, const auto&, auto matrix) const { matrix.setIdentity(); }
#endif
};

struct Driven {
  using Scalar = double;
  static constexpr int Dof = 2;
#if defined(driven_by_value)
  void gradient(double t, Column q, Column p, Eigen::Vector2d dHdq, Eigen::Vector2d dHdp) const {
    dHdq = t * p, dHdp = q;
  }
#elif defined(driven_template_by_value)
  void gradient(double t, const auto& q, const auto& p, Eigen::Vector2d dHdq, auto& dHdp) const {
    dHdq = t * p, dHdp = q;
  }
#elif defined(driven_of_vectors)
  void gradient(double t, Column q, Column p, Eigen::Vector2d& dHdq, Eigen::Vector2d& dHdp) const {
    dHdq = t * p, dHdp = q;
  }
#elif defined(driven_not_const)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) { dHdq = t * p, dHdp = q; }
#elif defined(driven_without_time)
  void gradient(Column q, Column p, Half dHdq, Half dHdp) const { dHdq = p, dHdp = q; }
#elif defined(driven_returns_float)
  float gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const {
    dHdq = t * p, dHdp = t * q;
    return static_cast<float>(q.dot(p));
  }
#elif defined(driven_returns_integer)
  int gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const {
    dHdq = t * p, dHdp = t * q;
    return static_cast<int>(q.dot(p));
  }
#elif defined(driven_answers)
  Status gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const {
    dHdq = t * p, dHdp = t * q;
    return Status::success;
  }
#elif defined(time_derivative_of_float)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = t * q; }
  float time_derivative(double, Column q, Column p) const { return float(q.dot(p)); }
#elif defined(driven_energy_is_whole)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = t * q; }
  int energy(double t, Column q, Column p) const { return int(t * q.dot(p)); }
#elif defined(driven_at_whole_times)
  void gradient(int t, const auto& q, const auto& p, Half dHdq, Half dHdp) const {
    dHdq = t * p, dHdp = t * q;
  }
#elif defined(driven_energy_of_float)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = t * q; }
  double energy(float t, Column q, Column p) const { return t * q.dot(p); }
#elif defined(time_derivative_of_whole_times)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = t * q; }
  double time_derivative(const int&, const auto& q, const auto& p) const { return q.dot(p); }
#elif defined(time_derivative_not_const)
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = t * q; }
  double time_derivative(double, Column q, Column p) { return q.dot(p); }
#elif defined(driven_of_other_size)
  void gradient(double t, In<double, 3> q, In<double, 3> p, Out<double, 3> dHdq, Out<double, 3> dHdp) const {
    dHdq = t * p, dHdp = q;
  }
#else
  void gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const { dHdq = t * p, dHdp = q; }
#endif
};

[[maybe_unused]] void into_copies(const Vector2d& q, const Vector2d& p, Vector2d dHdq, Vector2d dHdp) {
  dHdq = p, dHdp = q;
}

int main() {
  Autonomous driven(Driven{});
#ifdef lambda_by_value
  auto mine = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return q.dot(p); },
      [](const auto& q, const auto& p, Eigen::Vector2d dHdq, Eigen::Vector2d dHdp) { dHdq = p, dHdp = q; });
#elif defined(referred_lambda_by_value)
  const auto lambda = [](const auto& q, const auto& p, Eigen::Vector2d dHdq, Eigen::Vector2d dHdp) {
    dHdq = p, dHdp = q;
  };
  auto mine =
      make_hamiltonian<double, 2>([](const auto& q, const auto& p) { return q.dot(p); }, std::ref(lambda));
#elif defined(mixed_lambda_by_value)
  auto mine = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return q.dot(p); },
      [](const auto& q, const auto& p, auto& dHdq, Eigen::Vector2d dHdp) { dHdq = p, dHdp = q; });
#elif defined(lambda_answers)
  auto mine = make_hamiltonian<double, 2>([](const auto& q, const auto& p) { return q.dot(p); },
                                          [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
                                            dHdq = p, dHdp = q;
                                            return q[0] > 0;
                                          });
#elif defined(lambda_time_last)
  auto mine = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return q.dot(p); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp, double t = 1) { dHdq = t * p, dHdp = t * q; });
#elif defined(lambda_energy_time_last)
  auto mine = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p, double t = 1) { return t * q.dot(p); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq = p, dHdp = q; });
#elif defined(lambda_energy_is_whole)
  auto mine = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return int(q.dot(p)); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) { dHdq = p, dHdp = q; });
#elif defined(function_by_value)
  auto mine = make_hamiltonian<double, 2>([](const auto& q, const auto& p) { return q.dot(p); }, into_copies);
#else
  Mine mine;
#endif
  Semiexplicit stepper(mine, schemes::strang<double>());
  PhasePoint<double, 2> z({1, 2}, {3, 4});
  stepper.step(z, 0.1);
}
