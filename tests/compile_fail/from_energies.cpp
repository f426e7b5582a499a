// case no_mistake: compiles
// case depends_on_time: compiles
// case many: compiles
// case typed_arguments: from_energy: the energy does not take columns of any numbers
// case one_argument: from_energy: the energy does not take columns of any numbers
// case changes_itself: from_energy: the energy does not take columns of any numbers
// case time_last: the energy takes a number behind q and p, which would always be its default: the time comes first
// case no_return: from_energy: the energy gives no number of those it takes
// case many_typed_arguments: from_energy: the energy does not take columns of any numbers
// case many_no_return: from_energy: the energy gives no number of those it takes
#include <semiexplicit/derivatives/from_energy.hpp>
#include <semiexplicit/semiexplicit.hpp>

using namespace semiexplicit;

int main() {
#if defined(many) || defined(many_typed_arguments) || defined(many_no_return)
  constexpr int d = 12;
#else
  constexpr int d = 1;
#endif
#if defined(typed_arguments) || defined(many_typed_arguments)
  const auto h = from_energy<d>([](In<double, d> q, In<double, d> p) { return q[0] * p[0]; });
#elif defined(time_last)
  const auto h = from_energy<d>([](const auto& q, const auto& p, double t = 0) { return q[0] * p[0] + t; });
#elif defined(one_argument)
  const auto h = from_energy<d>([](const auto& z) { return z[0]; });
#elif defined(changes_itself)
  const auto h = from_energy<d>([n = 0](const auto& q, const auto& p) mutable { return ++n * q[0] * p[0]; });
#elif defined(no_return) || defined(many_no_return)
  const auto h = from_energy<d>([](const auto& q, const auto& p) { (void)(q[0] * p[0]); });
#elif defined(depends_on_time)
  const auto h = from_energy<d>([](const auto& t, const auto& q, const auto& p) { return t * q[0] * p[0]; });
#else
  const auto h = from_energy<d>([](const auto& q, const auto& p) { return q[0] * p[0]; });
#endif
  PhasePoint<double, d> z;
  z.vector().setOnes();
#if !defined(depends_on_time)
  Semiexplicit stepper(h, schemes::low_defect6_s13<double>());
  integrate(stepper, z, {.dt = 0.1, .steps = 1});
#else
  Vector<double, d> a, b;
  h.gradient(1.0, z.q(), z.p(), a, b);
#endif
}
