#if __has_include(<CLI/CLI.hpp>)  // which the options of the methods need, and not every build has

#include "../../examples/geodesics/section.hpp"
#include "../../examples/geodesics/summary.hpp"

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

#include "refusal.hpp"

namespace test_geodesic_section {

// What the program geodesics says of an orbit.

namespace {

using namespace examples;
using End = Orbit::End;

const geodesics::KerrMetric<double> hole{.mass = 1, .spin = 0.9};
const RuntimeScene<double, 4> scene{geodesics::Geodesic{hole}};

Orbit followed(const State4& start, const Region& region, double dt) {
  return follow(scene, {}, start, region, dt, 3, [](std::int64_t) {});
}

}  // namespace

TEST_CASE("the region of bound orbits ends where those in the equator turn", "[examples]") {
  const auto [spin, energy, l] = GENERATE(std::tuple(0.9, 0.999, 4.0), std::tuple(0.998, 0.9, 2.0),
                                          std::tuple(-0.5, 0.96, 4.0), std::tuple(0.0, 0.97, 4.0));
  CAPTURE(spin, energy, l);
  const Region region = allowed(geodesics::KerrMetric<double>{.mass = 1, .spin = spin}, energy, l);
  for (const double r : {region.inner, region.outer}) {
    // S. Chandrasekhar, The Mathematical Theory of Black Holes (1983), section 61: R(r) = 0.
    const double r2a2 = r * r + spin * spin, left = std::pow(energy * r2a2 - spin * l, 2);
    CHECK((r2a2 - 2 * r) * (r * r + std::pow(l - spin * energy, 2)) == Approx(left).epsilon(1e-9));
  }
  CHECK(region.inner < region.outer);
}

TEST_CASE("an orbit is done, falls, leaves, fails or takes too long", "[examples][long]") {
  const Region region = allowed(hole, 0.95, 3);
  const State4 start = start_of(hole, region, 0, 2, 0.95, 3);
  const Orbit done = followed(start, region, 0.5);
  CHECK(done.end == End::all_passages);
  CHECK(done.points.size() == 6);
  CHECK(done.worst_energy < 1e-10);

  Region narrow = region;
  narrow.fallen = region.outer;
  CHECK(followed(start, narrow, 0.5).end == End::fell);
  narrow = region;
  narrow.left = region.inner;
  CHECK(followed(start, narrow, 0.5).end == End::left);
  narrow = region;
  narrow.most_periods = 0;
  CHECK(followed(start, narrow, 0.5).end == End::most_time);

  const Orbit failed = followed(start, region, 1000);
  CHECK(failed.end == End::failed);
  CHECK_FALSE(failed.measured());
  CHECK(Orbit::from(failed.numbers()).end == End::failed);
}

TEST_CASE("an orbit that loses its energy has no point of that step", "[examples]") {
  const geodesics::ErnstMetric<double> ernst{.mass = 1, .field = 0.1};
  const RuntimeScene<double, 4> about_ernst{geodesics::Geodesic{ernst}};
  const Region region = allowed(ernst, 1.36, 6);
  const Method midpoint{.name = "midpoint"};
  std::size_t lost = 0;
  for (std::int64_t k = 0; k < 6; ++k) {
    const State4 start = start_of(ernst, region, k, 6, 1.36, 6);
    const Orbit orbit = follow(about_ernst, midpoint, start, region, 30, 30, [](std::int64_t) {});
    if (orbit.end != End::failed) continue;
    CAPTURE(k);

    with_projected_stepper(midpoint, about_ernst, [&](auto& stepper) {
      const auto passages = [&](std::int64_t steps) {
        std::size_t count = 0;
        State4 z = start;
        auto section = poincare_section(
            about_ernst, [](const auto& q, const auto&) { return std::numbers::pi / 2 - q[2]; },
            [&](double, const State4&) { ++count; });
        integrate(stepper, z, {.dt = 30, .steps = steps, .on_failure = OnFailure::stop}, section);
        return count;
      };
      std::int64_t good = 0;
      const double energy = about_ernst.energy(start.q(), start.p());
      for (State4 z = start;
           stepper.step(z, 30).ok() && std::abs(about_ernst.energy(z.q(), z.p()) / energy - 1) <= 1e-2;)
        ++good;
      CHECK(orbit.points.size() == 2 * passages(good));
      lost += passages(good + 1) - passages(good);
    });
  }
  CHECK(lost > 0);
}

TEST_CASE("points of a section are as good as the steps, however long these are", "[examples]") {
  // Carter's constant of what passes the equator, by r and p_r; B. Carter, Phys. Rev. 174 (1968) 1559, (60).
  const double energy = 0.96, l = 3.2, spin = hole.spin;
  const auto carter = [&](double r, double p_r) {
    const double delta = r * r - 2 * r + spin * spin, k = (r * r + spin * spin) * energy - spin * l;
    return (k * k - delta * delta * p_r * p_r) / delta - r * r - std::pow(l - spin * energy, 2);
  };
  const Region region = allowed(hole, energy, l);
  const State4 start = start_of(hole, region, 0, 20, energy, l);
  const Orbit orbit = follow(scene, {}, start, region, 13, 40, [](std::int64_t) {});
  REQUIRE(orbit.points.size() == 80);
  const double first = carter(start.q()[1], 0);
  double worst = 0;
  for (std::size_t i = 0; i < 80; i += 2)
    worst = std::max(worst, std::abs(carter(orbit.points[i], orbit.points[i + 1]) / first - 1));
  CAPTURE(worst, orbit.worst_energy);
  CHECK(worst < 1e-3);  // it was 0.1 by interpolation between the steps
}

TEST_CASE("an error is that of all orbits which came through a step", "[examples]") {
  const auto said = [](const std::vector<Orbit>& orbits) {
    std::ostringstream out;
    Summary(orbits).print(out, {.inner = 1, .outer = 1});
    return out.str();
  };
  const Orbit at_once{.end = End::failed}, fallen{.worst_energy = 3e-4, .end = End::fell, .time = 8},
      done{.worst_energy = 2e-9, .time = 90}, slow{.worst_energy = 1e-9, .end = End::most_time, .time = 90};
  CHECK(says(said({at_once}), "0 left, 1 failed\nerror of g^{μν} p_μ p_ν, at worst: not measured"));
  CHECK(says(said({done, fallen, at_once}), "1 fell into the hole, 0 left, 1 failed\n"));
  CHECK(says(said({done, fallen, at_once}), "at worst: 3.0e-04\n"));
  CHECK(says(said({slow}), "1 were given up, which took more than 6.28e+03 M a passage\n"));
}

}  // namespace test_geodesic_section

#endif
