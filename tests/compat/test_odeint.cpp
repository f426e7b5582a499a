#include "catch.hpp"

#include <array>
#include <functional>
#include <utility>
#include <vector>

#include <boost/numeric/odeint/integrate/integrate_const.hpp>
#include <boost/numeric/odeint/integrate/integrate_n_steps.hpp>
#include <boost/numeric/odeint/iterator/n_step_iterator.hpp>
#include <semiexplicit/compat/odeint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_odeint {

// The library's steppers under Boost.odeint: its functions do what integrate() does.

namespace {

namespace odeint = boost::numeric::odeint;
using namespace semiexplicit;

const systems::NlsLattice<double, 2> H;
const PhasePoint<double, 2> start({0.8, -0.3}, {0.2, 0.9});
const Semiexplicit method(H, schemes::blanes_moan4());

/// After 100 steps of 0.05.
PhasePoint<double, 2> by_integrate() {
  auto stepper = method;
  auto z = start;
  integrate(stepper, z, {.dt = 0.05, .steps = 100});
  return z;
}

}  // namespace

TEST_CASE("odeint's functions take the steps of integrate()", "[odeint]") {
  const OdeintStepper stepper(method);
  const auto system = stepper.system();
  auto z = start;
  CHECK(odeint::integrate_const(stepper, system, z, 0.0, 5.0, 0.05) == 100);
  CHECK(z.vector() == by_integrate().vector());
  z = start;
  CHECK(odeint::integrate_n_steps(stepper, system, z, 0.0, 0.05, 100) == Approx(5));
  CHECK(z.vector() == by_integrate().vector());
  CHECK(stepper.order() == 4);
  CHECK(OdeintStepper(GaussLegendre(H, {.stages = 3})).order() == 6);
}

TEST_CASE("States may be vectors, arrays, and pairs of them", "[odeint]") {
  const OdeintStepper stepper(method);
  const auto end = by_integrate();
  std::vector<double> x{0.8, -0.3, 0.2, 0.9};
  odeint::integrate_n_steps(stepper, stepper.system(), x, 0.0, 0.05, 100);
  std::array<double, 4> y{0.8, -0.3, 0.2, 0.9};
  odeint::integrate_n_steps(stepper, stepper.system(), y, 0.0, 0.05, 100);
  std::pair<std::vector<double>, std::vector<double>> pair{{0.8, -0.3}, {0.2, 0.9}};
  odeint::integrate_n_steps(stepper, stepper.system(), pair, 0.0, 0.05, 100);
  for (std::size_t i = 0; i < 4; ++i) {
    CHECK(x[i] == end.vector()[static_cast<Eigen::Index>(i)]);
    CHECK(y[i] == x[i]);
    CHECK((i < 2 ? pair.first[i] : pair.second[i - 2]) == x[i]);
  }
}

TEST_CASE("odeint's observers and iterators see every step", "[odeint]") {
  OdeintStepper stepper(method);
  auto z = start;
  std::vector<double> times, energies;
  odeint::integrate_const(std::ref(stepper), stepper.system(), z, 0.0, 1.0, 0.25,
                          [&](const PhasePoint<double, 2>& at, double t) {
                            times.push_back(t);
                            energies.push_back(H.energy(at.q(), at.p()));
                          });
  CHECK(times == std::vector<double>{0, 0.25, 0.5, 0.75, 1});
  CHECK(energies.front() == H.energy(start.q(), start.p()));
  CHECK(energies.back() == Approx(energies.front()).epsilon(1e-2));

  auto w = start;
  std::size_t seen = 0;
  auto [begin, end] = odeint::make_n_step_range(stepper, stepper.system(), w, 0.0, 0.25, 4);
  for (auto at = begin; at != end; ++at, ++seen)
    CHECK(H.energy(at->q(), at->p()) == Approx(energies[seen]).epsilon(1e-13));
  CHECK(seen == 5);
}

TEST_CASE("A step that fails under odeint throws and keeps the state", "[odeint]") {
  OdeintStepper stepper(method);
  std::vector<double> x{0.8, -0.3, 0.2, 0.9};
  stepper.do_step(stepper.system(), x, 0.0, 0.05);
  const auto before = x;
  std::string message;
  try {
    stepper.do_step(stepper.system(), x, 0.05, 1e3);
  } catch (const IntegrationError& error) {
    message = error.what();
    CHECK(error.report().dt == 1e3);
  }
  CHECK(says(message, "step 2 failed at t = 0.05 (dt = 1000)"));
  CHECK(x == before);
  std::vector<double> short_state{1, 2, 3};
  CHECK(refuses([&] { stepper.do_step(stepper.system(), short_state, 0.0, 0.05); },
                "the state has 3 numbers where the Hamiltonian has 4"));
}

TEST_CASE("odeint's phase points of another size are refused, as numbers are", "[odeint]") {
  OdeintStepper stepper(MidpointProjection(systems::NlsLattice<double>(2), schemes::strang<double>()));
  PhasePoint<double, Eigen::Dynamic> z(3);
  CHECK(refuses([&] { stepper.do_step(stepper.system(), z, 0.0, 0.05); },
                "the state has 6 numbers where the Hamiltonian has 4"));
}

}  // namespace test_odeint
