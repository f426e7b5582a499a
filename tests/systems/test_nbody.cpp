#include "catch.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_nbody {

namespace {

using namespace semiexplicit;
using namespace semiexplicit::effects;
using State = PhasePoint<double, Eigen::Dynamic>;
using Vectors = nbody::Bodies<double>::Vectors;

constexpr double pi = std::numbers::pi, gm_sun = 39.476926;  // au³/year²

/// A star and three planets on inclined ellipses, Jupiter's mass or less.
nbody::Bodies<double> some_bodies() { return nbody::Bodies<double>({gm_sun, 4e-3, 3e-2, 1e-3}); }

Vectors places(const nbody::Bodies<double>& bodies, bool velocities) {
  const std::vector<orbits::Elements<double>> elements{
      {.a = 0.4, .e = 0.2, .inclination = 0.1, .node = 0.3, .periapsis = 1, .mean_anomaly = 2},
      {.a = 1.1, .e = 0.05, .inclination = 0.03, .node = 4, .periapsis = 2.5, .mean_anomaly = 5},
      {.a = 3, .e = 0.1, .inclination = 0.2, .node = 2, .periapsis = 0.4, .mean_anomaly = 1}};
  Vectors all{{0, 0, 0}};
  for (std::size_t i = 0; i < elements.size(); ++i) {
    const auto z = state_of(elements[i], bodies.gm(0) + bodies.gm(static_cast<Eigen::Index>(i) + 1));
    all.push_back(velocities ? z.p() : z.q());
  }
  return all;
}

State start_of(const nbody::Bodies<double>& bodies) {
  return bodies.jacobi(places(bodies, false), places(bodies, true));
}

/// Is the gradient of an effect that of its energy by automatic differentiation?
template <class E>
void require_gradient(const E& effect, const State& z, double tolerance = 1e-14) {
  const Scene scene(effect);
  const auto by_duals = from_energy(z.dof(), [&](const auto& q, const auto& p) {
    if constexpr (CoupledEffect<E>)
      return effect.energy(q, p);
    else if constexpr (MomentumEffect<E>)
      return effect.energy(p);
    else
      return effect.energy(q);
  });
  State g(z.dof()), wanted(z.dof());
  scene.gradient(z.q(), z.p(), g.q(), g.p());
  by_duals.gradient(z.q(), z.p(), wanted.q(), wanted.p());
  CAPTURE(E::name, (g.q() - wanted.q()).norm() / wanted.q().norm());
  CHECK((g.q() - wanted.q()).norm() <= tolerance * wanted.q().norm());
  CHECK((g.p() - wanted.p()).norm() <= tolerance * wanted.p().norm());
  CHECK(wanted.vector().norm() > 0);
}

}  // namespace

TEST_CASE("gradients of the n-body effects are those of their energies") {
  const auto bodies = some_bodies();
  const State z = start_of(bodies);
  require_gradient(nbody::Kinetic<double>{bodies}, z);
  require_gradient(nbody::Attraction<double>{bodies}, z);
  require_gradient(nbody::Interaction<double>{bodies}, z, 1e-11);  // a difference of much larger terms
  require_gradient(nbody::Oblateness<double>{bodies, 0.1, 0.2, {0.6, 0, 0.8}}, z);
  require_gradient(nbody::PostNewtonian1<double>{bodies, 30}, z);
  require_gradient(nbody::EinsteinInfeldHoffmann<double>(bodies, 30), z);
}

TEST_CASE("in Jacobi coordinates the energy of n bodies is that of Newton, Einstein, Infeld and Hoffmann") {
  const auto bodies = some_bodies();
  const State z = start_of(bodies);
  const Vectors r = bodies.positions(z.q()), v = bodies.velocities(z.p());
  const double c = 30, j2 = 0.1, radius = 0.2;
  const Vector<double, 3> axis(0.6, 0, 0.8);
  double newton = 0, eih = 0, oblate = 0;
  Vector<double, 3> centre(0, 0, 0), momentum(0, 0, 0);
  for (std::size_t a = 0; a < 4; ++a) {
    const double m = bodies.gm(static_cast<Eigen::Index>(a));
    const Vector<double, 3> p = m * v[a];
    centre += m * r[a];
    momentum += p;
    newton += p.squaredNorm() / (2 * m);
    eih -= m * std::pow(p.squaredNorm() / (m * m), 2) / 8;
    for (std::size_t b = 0; b < 4; ++b) {
      if (b == a) continue;
      const double mb = bodies.gm(static_cast<Eigen::Index>(b)), d = (r[a] - r[b]).norm();
      const Vector<double, 3> n = (r[a] - r[b]) / d;
      newton -= m * mb / (2 * d);
      eih -= m * mb / (4 * d) * (6 * v[a].squaredNorm() - 7 * v[a].dot(v[b]) - n.dot(v[a]) * n.dot(v[b]));
      for (std::size_t k = 0; k < 4; ++k)
        if (k != a) eih += m * mb * bodies.gm(static_cast<Eigen::Index>(k)) / (2 * d * (r[a] - r[k]).norm());
    }
    if (a > 0) {
      const Vector<double, 3> d = r[a] - r[0];
      oblate += bodies.gm(0) * m * j2 * radius * radius / (2 * std::pow(d.norm(), 3)) *
                (3 * std::pow(axis.dot(d) / d.norm(), 2) - 1);
    }
  }
  const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                    nbody::Interaction<double>{bodies});
  CHECK(centre.norm() < 1e-14);
  CHECK(momentum.norm() < 1e-14);
  CHECK(scene.energy(z.q(), z.p()) == Approx(newton).epsilon(1e-14));
  CHECK(nbody::EinsteinInfeldHoffmann<double>(bodies, c).energy(z.q(), z.p()) ==
        Approx(eih / (c * c)).epsilon(1e-14));
  CHECK(nbody::Oblateness<double>{bodies, j2, radius, {0.6, 0, 0.8}}.energy(z.q()) ==
        Approx(oblate).epsilon(1e-14));
}

TEST_CASE("of two bodies the Hamiltonian of Einstein, Infeld and Hoffmann is that of the relative motion") {
  const nbody::Bodies<double> pair({3, 2});
  const State z({1.5, -0.3, 0.4}, {0.2, 1.4, -0.6});
  const nbody::PostNewtonian1<double> relative{pair, 7};
  const nbody::EinsteinInfeldHoffmann<double> eih(pair, 7);
  CHECK(eih.energy(z.q(), z.p()) == Approx(relative.energy(z.q(), z.p())).epsilon(1e-14));
  State a(3), b(3);
  Scene(eih).gradient(z.q(), z.p(), a.q(), a.p());
  Scene(relative).gradient(z.q(), z.p(), b.q(), b.p());
  CHECK((a.vector() - b.vector()).norm() <= 1e-14 * b.vector().norm());
  const Scene interaction(nbody::Interaction<double>{pair});
  interaction.gradient(z.q(), z.p(), a.q(), a.p());
  CHECK(a.vector().norm() == 0);
}

TEST_CASE(
    "the steps of a planetary system are of generalised order (8,2), reversible, and keep angular momentum") {
  const auto bodies = some_bodies();
  const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                    nbody::Interaction<double>{bodies}, nbody::EinsteinInfeldHoffmann<double>(bodies, 3e3));
  auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
  const State start = start_of(bodies);
  const auto spin = [&](const State& z) {
    Vector<double, 3> sum(0, 0, 0);
    for (Eigen::Index i = 0; i < z.dof(); i += 3)
      sum += Vector<double, 3>(z.q().segment<3>(i)).cross(Vector<double, 3>(z.p().segment<3>(i)));
    return sum;
  };
  // The same by a method that knows nothing of Jacobi coordinates' use: Gauss's of order 12 with small steps.
  GaussLegendre reference(scene, {.stages = 6});
  State exact = start;
  integrate(reference, exact, {.dt = 0.005, .t_end = 2});
  double errors[2];
  for (int k = 0; k < 2; ++k) {
    State z = start;
    const auto run = integrate(stepper, z, {.dt = 0.02 / (k + 1), .t_end = 2});
    errors[k] = (bodies.positions(z.q())[1] - bodies.positions(exact.q())[1]).norm();
    CHECK((spin(z) - spin(start)).norm() <= 1e-13 * spin(start).norm());
    integrate(stepper, z, {.dt = -run.dt, .t_end = -2});
    CHECK((z.vector() - start.vector()).norm() <= 1e-11);
  }
  CHECK(errors[0] < 1e-5);
  CHECK(errors[1] < errors[0] / 3.5);  // ε² h² at least
}

TEST_CASE("a step of a planetary system is symplectic") {
  const nbody::Bodies<double> bodies({10, 2, 1});
  const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies, 0},
                    nbody::Interaction<double>{bodies}, nbody::EinsteinInfeldHoffmann<double>(bodies, 100));
  auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
  const State start({1, 0.2, 0, -0.3, 4, 0.5}, {-0.4, 5, 0.3, -1.2, 0.1, 0.2});
  const Eigen::Index n = 12;
  Eigen::MatrixXd jacobian(n, n), omega = Eigen::MatrixXd::Zero(n, n);  // of the step, by differences
  omega.topRightCorner(6, 6).setIdentity();
  omega.bottomLeftCorner(6, 6) = -Eigen::MatrixXd::Identity(6, 6);
  const double delta = 1e-3;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto at = [&](double by) {
      State z = start;
      z.vector()[i] += by * delta;
      REQUIRE(stepper.step(z, 0.05).ok());
      return Eigen::VectorXd(z.vector());
    };
    jacobian.col(i) = (0.75 * (at(1) - at(-1)) - 0.15 * (at(2) - at(-2)) + (at(3) - at(-3)) / 60) / delta;
  }
  CHECK((jacobian.transpose() * omega * jacobian - omega).norm() < 1e-9);
}

TEST_CASE(
    "relativity turns the perihelion of Mercury by 42.98 arcseconds a century, as a pair or by all pairs") {
  const double c = 63241.077, a = 0.38709927, e = 0.20563593;  // au/year, au
  const nbody::Bodies<double> bodies({gm_sun, gm_sun / 6023600.0});
  const auto z0 = state_of(orbits::Elements<double>{.a = a, .e = e}, gm_sun * (1 + 1 / 6023600.0));
  const State start = bodies.jacobi({{0, 0, 0}, z0.q()}, {{0, 0, 0}, z0.p()});
  const auto advance = [&](const auto& relativity) {
    const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies}, relativity);
    auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
    State z = start;
    double last = 0, turned = 0, sum_t = 0, sum_tt = 0, sum_a = 0, sum_ta = 0, n = 0;
    integrate(stepper, z, {.dt = 0.024, .t_end = 100}, [&](double t, const State& at) {
      const Vector<double, 3> q = at.q(), v = at.p() / bodies.reduced(1);
      const Vector<double, 3> to_perihelion = v.cross(q.cross(v)) / gm_sun - q.normalized();
      const double angle = std::atan2(to_perihelion[1], to_perihelion[0]);
      turned += std::remainder(angle - last, 2 * pi);
      last = angle;
      n += 1, sum_t += t, sum_tt += t * t, sum_a += turned, sum_ta += t * turned;
    });
    return (n * sum_ta - sum_t * sum_a) / (n * sum_tt - sum_t * sum_t) * 100 * 648000 / pi;
  };
  // 6πGM/(c²a(1 - e²)) an orbit, in arcseconds a century.
  const double expected = 6 * pi * gm_sun / (c * c * a * (1 - e * e)) * 100 *
                          std::sqrt(gm_sun / (a * a * a)) / (2 * pi) * 648000 / pi;
  CHECK(expected == Approx(42.98).epsilon(1e-4));
  CHECK(advance(nbody::PostNewtonian1<double>{bodies, c}) == Approx(expected).epsilon(2e-4));
  CHECK(advance(nbody::EinsteinInfeldHoffmann<double>(bodies, c)) == Approx(expected).epsilon(2e-4));
}

TEST_CASE("a close encounter is refused, and the state stays at the last good step") {
  // Two planets of Jupiter's mass on orbits that cross; the mutual Hill radius is about 0.09.
  const nbody::Bodies<double> bodies({gm_sun, gm_sun * 1e-3, gm_sun * 1e-3});
  const auto one = state_of(orbits::Elements<double>{.a = 1}, gm_sun),
             two = state_of(orbits::Elements<double>{.a = 1.1, .mean_anomaly = 0.6}, gm_sun);
  const State start = bodies.jacobi({{0, 0, 0}, one.q(), two.q()}, {{0, 0, 0}, one.p(), two.p()});
  const auto end = [&](double hill_radii, double dt, State& z) {
    const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies, hill_radii},
                      nbody::Interaction<double>{bodies});
    auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
    z = start;
    return integrate(stepper, z, {.dt = dt, .on_failure = OnFailure::stop, .t_end = 3});
  };
  State z, fine;
  const auto run = end(3, 0.02, z);
  REQUIRE(run.status == Status::close_encounter);
  CHECK(run.t > 0.1);
  CHECK(run.t < 3);
  const auto distance = [&](const State& at) {
    const Vectors r = bodies.positions(at.q());
    return (r[1] - r[2]).norm();
  };
  const double hill = std::cbrt(2e-3 / 3) * 1.05;
  CHECK(distance(z) == Approx(3 * hill).epsilon(0.15));
  CHECK(z.vector().allFinite());
  CHECK(end(0, 0.02, fine).status == Status::success);
  CHECK(says(describe(Status::close_encounter), "hill_radii"));
}

TEST_CASE("bodies that pass each other within one step are refused, too") {
  // They meet at t = 0.23 within a mutual Hill radius, 0.009, at 1.5 au a year; a step is 0.1 years.
  const nbody::Bodies<double> bodies({gm_sun, gm_sun * 1e-6, gm_sun * 1e-6});
  Vectors r{{0, 0, 0}, {1, 0, 0}, {1, 0.004, 0.003}}, v{{0, 0, 0}, {0, 6.28, 0}, {1.5, 6.2, 0.3}};
  for (std::size_t i = 1; i < 3; ++i) {
    Vector<double, 3> dr, dv;
    REQUIRE(orbits::KeplerFlow<double, 3>{gm_sun}.increments(-0.23, r[i], v[i], dr, dv) == Status::success);
    r[i] += dr;
    v[i] += dv;
  }
  const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies},
                    nbody::Interaction<double>{bodies});
  auto stepper = stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>());
  State z = bodies.jacobi(r, v);
  const auto run = integrate(stepper, z, {.dt = 0.1, .steps = 5, .on_failure = OnFailure::stop});
  CHECK(run.status == Status::close_encounter);
  CHECK(run.steps == 2);
  // And on the way back, which begins behind the place.
  State after = bodies.jacobi(r, v);
  for (Eigen::Index i = 0; i < 6; i += 3) {
    const Vector<double, 3> x = after.q().segment<3>(i),
                            w = after.p().segment<3>(i) / bodies.reduced(1 + i / 3);
    Vector<double, 3> dx, dw;
    REQUIRE(orbits::KeplerFlow<double, 3>{gm_sun}.increments(0.4, x, w, dx, dw) == Status::success);
    after.q().segment<3>(i) += dx;
    after.p().segment<3>(i) += bodies.reduced(1 + i / 3) * dw;
  }
  CHECK(integrate(stepper, after, {.dt = -0.1, .steps = 4, .on_failure = OnFailure::stop}).status ==
        Status::close_encounter);
}

TEST_CASE("elements make a state and a state makes the elements") {
  for (const double e : {0.0, 0.1, 0.7, 0.99})
    for (const double m : {-2.0, 0.001, 1.0, 3.0}) {
      const orbits::Elements<double> orbit{
          .a = 2, .e = e, .inclination = 0.4, .node = 1, .periapsis = 0.7, .mean_anomaly = m};
      const auto z = state_of(orbit, 3.0);
      const auto back = orbits::elements_of<double>(z.q(), z.p(), 3.0);
      const auto again = state_of(back, 3.0);
      CAPTURE(e, m);
      CHECK((again.vector() - z.vector()).norm() < 1e-12 / (1 - e));
      CHECK(back.a == Approx(2).epsilon(1e-12 / (1 - e)));
      CHECK(back.e == Approx(e).margin(1e-14));
      CHECK(back.inclination == Approx(0.4));
      if (e > 0) CHECK(std::remainder(back.periapsis - 0.7, 2 * pi) == Approx(0).margin(1e-13 / e));
      // Vis viva, and the flow of a period comes back.
      CHECK(z.p().squaredNorm() == Approx(3 * (2 / z.q().norm() - 0.5)));
    }
  CHECK(refuses([] { state_of(orbits::Elements<double>{.e = 1}, 1.0); }, "0 <= e < 1"));
  CHECK(refuses([] { nbody::Bodies<double>({1, 0}); }, "GM of body 1"));
}

TEST_CASE("Bodies of another number than the type says are refused", "[nbody]") {
  for (const std::vector<double>& masses : {std::vector{1.0, 1e-3}, std::vector{1.0, 1e-3, 1e-3, 1e-3}}) {
    const effects::nbody::Bodies<double> bodies(masses);
    const effects::nbody::Kinetic<double, 6> kinetic{bodies};
    const effects::nbody::Attraction<double, 6> attraction{bodies};
    const std::string said = "degrees of freedom, and the type of the scene has 6";
    CHECK(refuses([&] { Scene(kinetic, attraction); }, said));
    CHECK(refuses([&] { RuntimeScene<double, 6>{kinetic, attraction}; }, said));
  }
}

TEST_CASE("Positions and velocities of another number of bodies are refused", "[nbody]") {
  const effects::nbody::Bodies<double> bodies({1, 1e-3, 1e-3, 1e-3});
  const Eigen::VectorXd few = Eigen::VectorXd::Ones(6);
  CHECK(refuses([&] { bodies.positions(few); }, "6 degrees of freedom and the bodies 9"));
  CHECK(refuses([&] { bodies.velocities(few); }, "6 degrees of freedom and the bodies 9"));
}

TEST_CASE("A body that falls along a line has no elements", "[nbody]") {
  const Vector<double, 3> q(1, 0, 0), v(-0.1, 0, 0);
  CHECK(refuses([&] { orbits::elements_of<double>(q, v, 1.0); }, "falls along a line"));
  // Nearly a line: an e that is below 1, and comes back, or a refusal.
  for (const double across : {1e-3, 1e-5, 1e-7, 1e-9, 1e-12}) {
    CAPTURE(across);
    const Eigen::Vector3d position(0.46, 0.31, -0.17),
        velocity = 0.8 * position + across * Eigen::Vector3d(0.3, -0.2, 0.5);
    if (across < 2e-8) {
      CHECK(refuses([&] { orbits::elements_of<double>(position, velocity, 1.0); }, "falls along a line"));
      continue;
    }
    const auto orbit = orbits::elements_of<double>(position, velocity, 1.0);
    REQUIRE(orbit.e < 1);
    const auto back = orbits::state_of(orbit, 1.0);
    CHECK((back.q() - position).norm() < 1e-6);
  }
}

TEST_CASE("A scene refuses effects that hold other bodies, by the names of both", "[nbody]") {
  const nbody::Bodies<double> bodies({1, 1e-3}), same({1, 1e-3}), others({1, 2e-3});
  const nbody::Attraction<double> attraction{bodies};
  const auto says_of = [](const std::string& one, const std::string& other) {
    return "the effects " + one + " and " + other +
           " have other masses or circulations; give both the same ones";
  };
  const auto check = [&](const auto& effect) {
    const std::string said = says_of("attraction", effect.name);
    CHECK(refuses([&] { Scene(attraction, effect); }, "Scene: " + said));
    CHECK(refuses(
        [&] {
          (RuntimeScene<double, Eigen::Dynamic>{attraction, effect});
        },
        "RuntimeScene: " + said));
  };
  check(nbody::Kinetic<double>{others});
  check(nbody::Interaction<double>{others});
  check(nbody::Oblateness<double>{.bodies = others});
  check(nbody::PostNewtonian1<double>{others, 10});
  check(nbody::EinsteinInfeldHoffmann<double>(others, 10));
  CHECK(
      refuses([&] { Scene(nbody::Kinetic<double>{others}, attraction); }, says_of("kinetic", "attraction")));
  // Equal numbers are the same bodies, and effects without any go with all.
  CHECK(refusal([&] { Scene(nbody::Kinetic<double>{same}, attraction); }) == accepted);
  const Scene fixed(orbits::Kinetic<double, 3>{}, nbody::Attraction<double, 3>{bodies},
                    nbody::Interaction<double, 3>{same});
  CHECK(RuntimeScene(fixed).effects()[0].scene_constants().empty());
  CHECK(RuntimeScene(fixed).effects()[1].scene_constants() == bodies.masses());
}

TEST_CASE("The axis of an oblate primary may have any length but none", "[nbody]") {
  const auto bodies = some_bodies();
  const State z = start_of(bodies);
  const auto energy = [&](double x, double y, double z_) {
    return nbody::Oblateness<double>{.bodies = bodies, .j2 = 0.1, .radius = 0.2, .axis = {x, y, z_}}.energy(
        z.q());
  };
  const double wanted = energy(0.6, 0, 0.8);
  for (const double length : {2.0, 1e-200, 1e200})
    CHECK(energy(0.6 * length, 0, 0.8 * length) == Approx(wanted).epsilon(1e-14));
  CHECK(energy(0, 0, 7) == energy(0, 0, 1));
  const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
  CHECK(refuses([&] { energy(0, 0, 0); }, "Axis: it has no length"));
  CHECK(refuses([&] { energy(0, nan, 1); }, "Axis: it has no length"));
  CHECK(refuses([&] { energy(inf, 0, 1); }, "Axis: it has no length"));
  // A vector whose length is 1 to rounding stays as it is.
  const nbody::Axis<double> axis(0.36, 0.48, 0.8);
  CHECK((axis[0] == 0.36 && axis[1] == 0.48 && axis[2] == 0.8));
}

TEST_CASE("A negative number of Hill radii is refused, and none is not", "[nbody]") {
  const nbody::Bodies<double> bodies({1, 1e-3, 1e-3});
  const auto refused = [&](double radii) {
    const Scene scene(nbody::Kinetic<double>{bodies}, nbody::Attraction<double>{bodies, radii});
    return refusal([&] { stepper_for(scene, exactly<nbody::Kinetic<double>, nbody::Attraction<double>>()); });
  };
  CHECK(says(refused(-3), "hill_radii of Attraction is negative or NaN; give 0 or more"));
  CHECK(says(refused(std::nan("")), "hill_radii"));
  CHECK(refused(0) == accepted);
}

}  // namespace test_nbody
