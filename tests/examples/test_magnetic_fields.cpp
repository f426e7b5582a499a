#include "../../examples/charges/magnetic_fields.hpp"

#include "catch.hpp"

#include <semiexplicit/scene.hpp>

namespace test_magnetic_fields {

// The fields of the program charges, each an effect of its own, against the library's motion in all of them.

namespace {

using namespace examples;
using Chosen = RuntimeScene<double, 3>;

const double charge = -1.3, mass = 0.7;
const charges::UniformField uniform(0.4);
const charges::DipoleField dipole(2.1);
const charges::BottleField bottle(0.9, 1.7);

template <class Field>
FieldEffect<Field> effect(const char* name, const Field& field, const FieldSum& others, bool moves) {
  return {name, charge, mass, field, others, moves};
}

template <class A, class B>
void check_equal(const A& a, const B& b) {
  const Eigen::Vector3d q(0.8, -0.5, 0.6), p(0.3, 1.1, -0.7);
  Eigen::Vector3d a_by_q, a_by_p, b_by_q, b_by_p;
  a.gradient(q, p, a_by_q, a_by_p);
  b.gradient(q, p, b_by_q, b_by_p);
  CHECK((a_by_q - b_by_q).norm() <= 1e-14 * a_by_q.norm());
  CHECK((a_by_p - b_by_p).norm() <= 1e-14 * a_by_p.norm());
  CHECK(a.energy(q, p) == Approx(b.energy(q, p)).epsilon(1e-14));
}

}  // namespace

TEST_CASE("Magnetic fields that are effects of their own add up to the motion in all of them", "[examples]") {
  const Chosen all{charges::MagneticKinetic(charge, mass, uniform, dipole, bottle)};
  const Chosen apart{charges::Kinetic<>{.mass = mass}, effect("uniform", uniform, {}, false),
                     effect("dipole", dipole, FieldSum().add(uniform), false),
                     effect("bottle", bottle, FieldSum().add(uniform).add(dipole), false)};
  check_equal(all, apart);
  // Without the last one it is the motion in the others.
  check_equal(Chosen{charges::MagneticKinetic(charge, mass, uniform, dipole)}, apart.without("bottle"));
}

TEST_CASE("A magnetic field without a kinetic effect brings the motion along", "[examples]") {
  check_equal(Chosen{charges::MagneticKinetic(charge, mass, bottle)},
              Chosen{effect("bottle", bottle, {}, true)});
}

}  // namespace test_magnetic_fields
