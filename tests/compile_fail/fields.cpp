// case no_mistake: compiles
// case potential_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case gradient_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case relativistic_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case summed_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
// case electric_by_value: takes by value what it adds to, so that it adds nothing: write `auto& dHdq`
// case driven_by_value: takes by value what it adds to, so that it adds nothing: write `auto& a`
#include <semiexplicit/systems/charges.hpp>
#include <semiexplicit/systems/field_from.hpp>
#include <semiexplicit/systems/relativistic_charges.hpp>

using namespace semiexplicit;
using namespace effects::charges;

#if defined(potential_by_value) || defined(relativistic_by_value)
using Written = Vector<double, 3>;
#else
using Written = Vector<double, 3>&;
#endif

struct Mine {
  void add_potential(const auto& x, Written a) const { a[1] += x[0]; }
#if defined(gradient_by_value) || defined(summed_by_value)
  void add_gradient(const auto&, const auto& v, double factor, auto out) const { out[0] += factor * v[1]; }
#else
  void add_gradient(const auto&, const auto& v, double factor, auto& out) const { out[0] += factor * v[1]; }
#endif
};
struct Growing {
  void add_potential(double t, const auto& x, auto& a) const { a[1] += t * x[0]; }
  void add_gradient(double t, const auto&, const auto& v, double factor, auto& out) const {
    out[0] += t * factor * v[1];
  }
#ifdef driven_by_value
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

int main() {
#ifdef relativistic_by_value
  RelativisticKinetic kinetic(1.0, 1.0, 1.0, Mine{});
#elif defined(summed_by_value)
  FieldSum sum;
  sum.add(Mine{});
#else
  RelativisticCharge charge(1.0, 1.0, 1.0, Growing{}, Electric{});
  MagneticKinetic kinetic(1.0, 1.0, Mine{});
#endif
}
