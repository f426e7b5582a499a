// case no_mistake: compiles
// case potential_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case gradient_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case relativistic_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case summed_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case electric_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case driven_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case without_gradient: this field has no `void add_potential(const auto& x, auto& a) const` with `void add_gradient(const auto&
// case gradient_not_const: this field has no `void add_potential(const auto& x, auto& a) const` with `void add_gradient(const auto&
// case driven_without_derivative: one that depends on the time takes it first in both and in `void add_time_derivative(
// case driven_at_whole_times: takes the time or the factor as a whole number, or one of fewer digits than the charge's, which rounds it: write `const auto& t`
// case potential_time_last: takes a number behind the place, which would always be its default: the time comes first
// case potential_answers: add_time_derivative of this field returns a bool, an int or a Status, and nobody asks: let it return nothing
// case time_last: add_potential or add_gradient of this field ends with a number, which would always be its default
// case charge_of_whole_numbers: a charge of whole numbers: write 1.0 for 1
// case two_components: the potential of this FieldFrom has not three components
// case plane_potential: acts in another number of dimensions than 3, or on other numbers than the charge's
// case potential_of_floats: acts in another number of dimensions than 3, or on other numbers than the charge's
// case of_both: is an electric potential and a magnetic field, and one of both would be left out: make two of it
// case whole_numbers: this effect computes with whole numbers: write 1.0 for 1, or name its numbers, as <double>
#include <array>

#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems/charges.hpp>
#include <semiexplicit/systems/field_from.hpp>
#include <semiexplicit/systems/orbits.hpp>
#include <semiexplicit/systems/relativistic_charges.hpp>

using namespace semiexplicit;
using namespace effects::charges;

#if defined(potential_by_value) || defined(relativistic_by_value)
using Written = Vector<double, 3>;
#else
using Written = Vector<double, 3>&;
#endif

struct Mine {
#ifdef potential_answers
  bool add_potential(const auto& x, Written a) const {
    a[1] += x[0];
    return true;
  }
#else
  void add_potential(const auto& x, Written a) const { a[1] += x[0]; }
#endif
#if defined(without_gradient)
#elif defined(time_last)
  void add_gradient(const auto&, const auto& v, double factor, auto& out, double t = 0) const {
    out[0] += t * factor * v[1];
  }
#elif defined(gradient_not_const)
  void add_gradient(const auto&, const auto& v, double factor, auto& out) { out[0] += factor * v[1]; }
#elif defined(gradient_by_value) || defined(summed_by_value)
  void add_gradient(const auto&, const auto& v, double factor, auto out) const { out[0] += factor * v[1]; }
#else
  void add_gradient(const auto&, const auto& v, double factor, auto& out) const { out[0] += factor * v[1]; }
#endif
};
struct Growing {
  void add_potential(double t, const auto& x, auto& a) const { a[1] += t * x[0]; }
#ifdef driven_at_whole_times
  using Time = int;
#else
  using Time = double;
#endif
  void add_gradient(Time t, const auto&, const auto& v, double factor, auto& out) const {
    out[0] += t * factor * v[1];
  }
#if defined(driven_without_derivative)
#elif defined(driven_by_value)
  void add_time_derivative(double, const auto& x, auto a) const { a[1] += x[0]; }
#else
  void add_time_derivative(double, const auto& x, auto& a) const { a[1] += x[0]; }
#endif
};

struct Electric {
  using Acts = OnPosition<double, 3>;
  static constexpr const char* name = "trap";
  double energy(const auto& q) const { return q[0] * q[0] / 2; }
#ifdef electric_by_value
  void add_gradient(const auto& q, Vector<double, 3> dHdq) const { dHdq[0] += q[0]; }
#else
  void add_gradient(const auto& q, auto& dHdq) const { dHdq[0] += q[0]; }
#endif
};

struct OfBoth : Electric {
  void add_potential(const auto& x, auto& a) const { a[1] += x[0]; }
  void add_gradient(const auto& q, auto& dHdq) const { Electric::add_gradient(q, dHdq); }
  void add_gradient(const auto&, const auto& v, double factor, auto& out) const { out[0] += factor * v[1]; }
};

int main() {
  const UniformField whole(1);  // is 1.0
  static_assert(std::is_same_v<decltype(whole), const UniformField<double>>);
  static_assert(std::is_same_v<decltype(BottleField(1, 10.0f)), BottleField<float>>);
  static_assert(std::is_same_v<decltype(UniformField(UniformField(1))), UniformField<double>>);
#if defined(potential_time_last)
  const FieldFrom field([](const auto& x, double t = 0) { return std::array{t * x[0], x[0], x[0]}; });
#elif defined(charge_of_whole_numbers)
  MagneticKinetic kinetic(1, 2, Mine{});
#elif defined(two_components)
  MagneticKinetic kinetic(1.0, 1.0, FieldFrom([](const auto& x) { return std::array{x[0], x[1]}; }));
  Vector<double, 3> z(1, 2, 3), out(0, 0, 0);
  kinetic.add_gradient(z, z, out, out);
#elif defined(plane_potential)
  RelativisticCharge charge(1.0, 1.0, 1.0, effects::orbits::Attraction<>{});
#elif defined(potential_of_floats)
  RelativisticCharge charge(1.0, 1.0, 1.0, effects::orbits::Attraction<float, 3>{});
#elif defined(of_both)
  RelativisticCharge charge(1.0, 1.0, 1.0, OfBoth{});
#elif defined(whole_numbers)
  const Scene scene(effects::orbits::Attraction<int, 2>{});
#elif defined(relativistic_by_value)
  RelativisticKinetic kinetic(1.0, 1.0, 1.0, Mine{});
#elif defined(summed_by_value)
  FieldSum sum;
  sum.add(Mine{});
#else
  RelativisticCharge charge(1.0, 1.0, 1.0, Growing{}, Electric{});
  MagneticKinetic kinetic(1.0, 1.0, Mine{});
#endif
}
