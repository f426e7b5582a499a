#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include <semiexplicit/checkpoint.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "folder.hpp"
#include "kepler.hpp"
#include "oscillator.hpp"
#include "with_events.hpp"

namespace test_interpolation_error {

// What the observers that interpolate say of their error, against the error itself.

namespace {

using namespace semiexplicit;

/// That counts its calls.
template <class T>
struct Oscillator : OscillatorOf<T> {
  std::int64_t* calls = nullptr;
  void gradient(In<T, 1> q, In<T, 1> p, Out<T, 1> dHdq, Out<T, 1> dHdp) const {
    if (calls) ++*calls;
    OscillatorOf<T>::gradient(q, p, dHdq, dHdp);
  }
  static PhasePoint<T, 1> at(double t) { return {T(std::cos(t)), T(-std::sin(t))}; }
};

/// Kepler's motion with the eccentricity 0.2.
template <class T>
struct Planet : KeplerOf<T> {
  static PhasePoint<T, 2> at(double t) { return kepler_orbit<T>(0.2, t); }
};

template <class H>
double relative_error(const typename DenseOutput<H>::State& z, double t) {
  const auto exact = H::at(t).vector().template cast<double>().eval();
  return (z.vector().template cast<double>() - exact).norm() / exact.norm();
}

struct Errors {
  double real, estimate;
};

/// Of at_times() over exact states with steps of h, from the step `first` on.
template <class H>
Errors at_times_errors(double h, int nodes, int first) {
  using Scalar = typename H::Scalar;
  double worst = 0;
  std::vector<Scalar> times;
  for (int k = 0; k < 150; ++k) times.push_back(Scalar((first + 0.37 * k) * h));
  auto at = at_times(
      H(), times,
      [&](Scalar t, const auto& z) { worst = std::max(worst, relative_error<H>(z, static_cast<double>(t))); },
      nodes);
  for (int n = 0; n < 60 + nodes; ++n) {
    const Scalar t = static_cast<Scalar>(n * h);
    at(t, H::at(static_cast<double>(t)));
  }
  CHECK(at.served() == times.size());
  return {worst, static_cast<double>(at.interpolation_error())};
}

void check(const Errors& errors) {
  CAPTURE(errors.real, errors.estimate);
  CHECK(errors.estimate >= errors.real / 3);
  CHECK(errors.estimate <= errors.real * 30);
}

}  // namespace

TEMPLATE_TEST_CASE("The error of interpolation is known where it is above rounding", "[interpolation error]",
                   Oscillator<double>, Planet<double>) {
  const double turn = 2 * std::acos(-1.0);
  for (const int nodes : {2, 4, 6, 8})
    for (const double h : {turn / 5, turn / 10, 0.2, 0.1, 0.03}) {
      CAPTURE(nodes, h);
      const Errors errors = at_times_errors<TestType>(h, nodes, nodes);
      if (errors.real > 1e-13)
        check(errors);
      else
        CHECK(errors.estimate < 1e-12);
    }
}

TEMPLATE_TEST_CASE("The error of interpolation is known in float", "[interpolation error]", Oscillator<float>,
                   Planet<float>) {
  const double turn = 2 * std::acos(-1.0);
  for (const int nodes : {2, 4})
    for (const double h : {turn / 5, 0.5, 0.25, 0.06}) {
      CAPTURE(nodes, h);
      check(at_times_errors<TestType>(h, nodes, nodes));  // the last ones are rounding, or little more
    }
}

TEST_CASE("In the first steps many nodes make more of the rounding, and the estimate says so",
          "[interpolation error]") {
  for (const double h : {0.3, 0.5, 0.77, 1.0}) {
    CAPTURE(h);
    const Errors errors = at_times_errors<Oscillator<float>>(h, 8, 0);
    CAPTURE(errors.real, errors.estimate);
    CHECK(errors.real > 1e-6);
    CHECK(errors.estimate >= errors.real / 3);
    CHECK(errors.estimate <= errors.real * 30);
  }
}

TEST_CASE("Where a method of high order leaps over the motion, the estimate says so",
          "[interpolation error]") {
  // Gauss's method of six stages with eight steps an orbit.
  using H = Planet<double>;
  GaussLegendre stepper(H(), {.stages = 6});
  auto z = H::at(0);
  double between = 0, at_steps = 0;
  std::vector<double> times;
  for (int k = 1; k < 100; ++k) times.push_back(0.3 * k);
  auto at = at_times(H(), times,
                     [&](double t, const auto& y) { between = std::max(between, relative_error<H>(y, t)); });
  auto section = poincare_section(
      H(), [](const auto& q, const auto&) { return q[1]; }, [](double, const auto&) {});
  integrate(stepper, z, {.dt = 0.8, .t_end = 32}, at, section,
            [&](double t, const auto& y) { at_steps = std::max(at_steps, relative_error<H>(y, t)); });
  CHECK(at_steps < 1e-5);
  CHECK(between > 1000 * at_steps);
  check({between, at.interpolation_error()});
  CHECK(section.count() >= 4);
  CHECK(section.interpolation_error() > 100 * at_steps);
  CHECK(section.interpolation_error() < 3 * at.interpolation_error());
}

TEST_CASE("Steps that were cut are resolved no better between", "[interpolation error]") {
  using H = systems::Product<double>;
  Semiexplicit stepper(H(), schemes::low_defect6_s13());
  PhasePoint<double, 1> z(-3, 0), fine = z;
  std::vector<double> times, right, found;
  for (int k = 1; k < 60; ++k) times.push_back(0.2 * k);
  auto exact = at_times(H(), times,
                        [&](double, const auto& y) { right.push_back(y.q()[0]), right.push_back(y.p()[0]); });
  auto at = at_times(H(), times,
                     [&](double, const auto& y) { found.push_back(y.q()[0]), found.push_back(y.p()[0]); });
  integrate(stepper, fine, {.dt = 0.01, .t_end = 12}, exact);
  const IntegrationReport run = integrate(stepper, z, {.dt = 0.6, .subdivide = 6, .t_end = 12}, at);
  CHECK(run.subdivided > 0);
  REQUIRE(found.size() == right.size());
  double worst = 0;
  for (std::size_t i = 0; i < found.size(); i += 2)
    worst = std::max(worst, std::hypot(found[i] - right[i], found[i + 1] - right[i + 1]) /
                                std::hypot(right[i], right[i + 1]));
  CHECK(worst > 0.01);
  check({worst, at.interpolation_error()});
  CHECK(exact.interpolation_error() < 1e-9);
}

TEST_CASE("Nothing is said or paid where nothing is interpolated", "[interpolation error]") {
  using H = Oscillator<double>;
  std::int64_t calls = 0;
  DenseOutput dense(H{{}, &calls}, 4);
  for (int n = 0; n < 10; ++n) dense(0.5 * n, H::at(0.5 * n));
  CHECK(dense.interpolation_error() == 0);
  CHECK(calls == 0);
  PhasePoint<double, 1> z;
  dense.at(4.5, z);  // a state of the run
  CHECK(dense.interpolation_error() == 0);
  dense.at(4.45, z);
  CHECK(calls == 4);  // one for each node, as for the interpolation alone
  const double once = dense.interpolation_error();
  CHECK(once > 0);
  dense.at(4.48, z);
  CHECK(calls == 4);
  CHECK(dense.interpolation_error() == once);  // the worst so far
  dense.sought_after(2, 0.25, z);              // worse, but not handed on
  CHECK(dense.interpolation_error() == once);
  dense.after(2, 0.25, z);
  CHECK(dense.interpolation_error() > once);

  DenseOutput at_rest(H{}, 4);
  for (int n = 0; n < 6; ++n) at_rest(0.5 * n, {0, 0});
  at_rest.at(2.2, z);
  CHECK(at_rest.interpolation_error() <= 1e-15);
}

TEST_CASE("The error of interpolation goes on with a resumed run", "[interpolation error]") {
  const Folder folder;
  const with_events::Oscillator h;
  const auto run = [&](std::int64_t stop_at, bool saved) {
    auto stepper = with_events::semiexplicit_of(h);
    PhasePoint<double, 1> z(1, 0);
    // The worst ones come first: the times then lie near the steps.
    auto at = at_times(h, {1.25, 2.25, 3.25, 40.01, 45.01}, [](double, const auto&) {});
    IntegrationOptions<double> options{.dt = 0.5, .steps = 100};
    Checkpoints checkpoints(folder.path / "run.checkpoint", {.every = 25}, stepper, options, at);
    if (saved) options.done = checkpoints.resume(z);
    options.steps = stop_at;
    if (saved)
      integrate(stepper, z, options, at, checkpoints);
    else
      integrate(stepper, z, options, at);
    return at.interpolation_error();
  };
  const double whole = run(100, false);
  CHECK(whole > 1e-9);
  CHECK(run(50, true) == whole);
  CHECK(run(100, true) == whole);
}

TEST_CASE("A state of dynamic size becomes what is interpolated, whatever size it had") {
  const auto H =
      from_energy(2, [](const auto& q, const auto& p) { return (q.squaredNorm() + p.squaredNorm()) / 2; });
  PhasePoint<double, Eigen::Dynamic> z(2);
  z.q() << 1, 2;
  DenseOutput dense(H);
  integrate(Semiexplicit(H, schemes::low_defect6_s13()), z, {.dt = 0.1, .steps = 5}, dense);
  for (const Eigen::Index dof : {0, 1, 2, 3}) {
    PhasePoint<double, Eigen::Dynamic> at(dof);
    dense.at(0.25, at);
    REQUIRE(at.dof() == 2);
    CHECK(std::abs(at.q()[1] - 2 * std::cos(0.25)) < 1e-7);
    CHECK(std::abs(at.p()[0] + std::sin(0.25)) < 1e-7);
  }
}

}  // namespace test_interpolation_error
