// case no_mistake: compiles
// case no_energy: has no public energy, by which the run is to be judged: write `Scalar energy(
// case energy_not_const: the energy of this Hamiltonian is not const, or no number: write `Scalar energy(
// case energy_is_no_number: the energy of this Hamiltonian is not const, or no number: write `Scalar energy(
// case energy_of_other_arguments: the energy of this Hamiltonian takes other arguments: write `Scalar energy(
// case energy_is_whole: the energy of this Hamiltonian is a whole number, or one of fewer digits than Scalar: let it return a Scalar
// case energy_of_float: the energy of this Hamiltonian is a whole number, or one of fewer digits than Scalar: let it return a Scalar
// case energy_time_last: the energy of this Hamiltonian ends with a number, which would always be its default: the time comes first
// case energy_of_other_size: the energy of this Hamiltonian takes columns of another size or of other numbers than its Dof and Scalar: write `Scalar energy(
// case check_of_energy_of_other_size: the energy of this Hamiltonian takes columns of another size or of other numbers than its Dof and Scalar: write `Scalar energy(
// case cost_of_energy_of_other_size: the energy of this Hamiltonian takes columns of another size or of other numbers than its Dof and Scalar: write `Scalar energy(
// case energy_of_long_columns: compiles
// case energy_of_rows: compiles
// case energy_with_a_default: compiles
// case check_without_energy: has no public energy, by which the run is to be judged: write `Scalar energy(
// case cost_without_energy: has no public energy, by which the run is to be judged: write `Scalar energy(
// case cost_of_whole_numbers: this function tells no more than true and false, whole numbers, or ones of fewer digits than Scalar, which hides how far it strayed
// case cost_of_a_bool: this function tells no more than true and false, whole numbers, or ones of fewer digits than Scalar, which hides how far it strayed
// case driven_without_energy: of this driven Hamiltonian there is no K to judge a run by: write `Scalar energy(const Scalar& t
#include <semiexplicit/accuracy/cost_of_accuracy.hpp>
#include <semiexplicit/derivatives/check_gradient.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/time/autonomous.hpp>

using namespace semiexplicit;
using Column = In<double, 2>;
using Half = Out<double, 2>;

struct Mine {
  using Scalar = double;
  static constexpr int Dof = 2;
#if defined(no_energy) || defined(check_without_energy) || defined(cost_without_energy)
#elif defined(energy_not_const)
  double energy(Column q, Column p) { return q.dot(p); }
#elif defined(energy_is_whole)
  int energy(const auto& q, const auto& p) const { return int(q.dot(p)); }
#elif defined(energy_of_float)
  float energy(Column q, Column p) const { return float(q.dot(p)); }
#elif defined(energy_time_last)
  auto energy(const auto& q, const auto& p, double t = 1) const { return t * q.dot(p); }
#elif defined(energy_is_no_number)
  const char* energy(Column, Column) const { return "much"; }
#elif defined(energy_of_other_size) || defined(check_of_energy_of_other_size) || \
    defined(cost_of_energy_of_other_size)
  double energy(In<double, 3> q, In<double, 3> p) const { return q.dot(p); }
#elif defined(energy_of_long_columns)
  double energy(const Eigen::VectorXd& q, const Eigen::VectorXd& p) const { return q.dot(p); }
#elif defined(energy_of_rows)
  double energy(const Eigen::RowVector2d& q, const Eigen::RowVector2d& p) const { return q.dot(p); }
#elif defined(energy_with_a_default)
  double energy(Column q, Column p, const Eigen::Vector3d& field = Eigen::Vector3d(1, 1, 1)) const {
    return q.dot(p) * field[0];
  }
#elif defined(energy_of_other_arguments)
  double energy(const PhasePoint<double, 2>& z) const { return z.q().dot(z.p()); }
#else
  double energy(Column q, Column p) const { return q.dot(p); }
#endif
  void gradient(Column q, Column p, Half dHdq, Half dHdp) const { dHdq = p, dHdp = q; }
};

struct Driven {
  using Scalar = double;
  static constexpr int Dof = 2;
  double gradient(double t, Column q, Column p, Half dHdq, Half dHdp) const {
    dHdq = p, dHdp = t * q;
    return q.squaredNorm() / 2;
  }
};

int main() {
  const PhasePoint<double, 2> z({1, 2}, {3, 4});
#if defined(check_without_energy) || defined(check_of_energy_of_other_size)
  check_gradient(Mine(), z);
#elif defined(cost_without_energy) || defined(cost_of_energy_of_other_size)
  cost_of_accuracy(Mine(), z, 10);
#elif defined(cost_of_whole_numbers)
  cost_of_accuracy(Mine(), z, 10, {.observable = [](const auto& q, const auto&) { return int(q[0]); }});
#elif defined(cost_of_a_bool)
  cost_of_accuracy(Mine(), z, 10, {.observable = [](const auto& q, const auto&) { return q[0] > 0; }});
#elif defined(driven_without_energy)
  Invariants invariants{Autonomous(Driven())};
#else
  Invariants invariants{Mine()};
  invariants(0.0, z);
#endif
}
