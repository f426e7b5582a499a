#include "catch.hpp"

#include <cmath>
#include <functional>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

namespace test_four_blocks {

// The method as its source writes it down, with the four blocks ζ = (q, x, p, y), against the library's two
// copies.

namespace {

using namespace semiexplicit;
using Block = Eigen::Vector4d;
using Multiplier = Eigen::Matrix<double, 8, 1>;  // μ = (μ₁, μ₂)

using Lattice = systems::NlsLattice<double, 4>;
const Lattice lattice;
const PhasePoint<double, 4> start({1, 0.5, -0.3, 0.1}, {0.4, -0.7, 0.2, 0.9});

struct Blocks {
  Block q, x, p, y;
};

/// D₁H and D₂H, written out from the Hamiltonian of the NLS lattice.
Block d1(const Block& q, const Block& p) {
  Block g;
  for (int i = 0; i < 4; ++i) {
    g[i] = (q[i] * q[i] + p[i] * p[i]) * q[i];
    for (const int j : {i - 1, i + 1})
      if (j >= 0 && j < 4) g[i] -= 2 * q[j] * q[j] * q[i] - 2 * p[j] * p[j] * q[i] + 4 * p[j] * p[i] * q[j];
  }
  return g;
}
Block d2(const Block& q, const Block& p) {
  Block g;
  for (int i = 0; i < 4; ++i) {
    g[i] = (q[i] * q[i] + p[i] * p[i]) * p[i];
    for (const int j : {i - 1, i + 1})
      if (j >= 0 && j < 4) g[i] -= 2 * p[j] * p[j] * p[i] - 2 * q[j] * q[j] * p[i] + 4 * p[j] * q[j] * q[i];
  }
  return g;
}

/// Φ^A and Φ^B.
Blocks flow_a(double t, const Blocks& z) {
  return {z.q, z.x + t * d2(z.q, z.y), z.p - t * d1(z.q, z.y), z.y};
}
Blocks flow_b(double t, const Blocks& z) {
  return {z.q + t * d2(z.x, z.p), z.x, z.p, z.y - t * d1(z.x, z.p)};
}

/// Φ^C: the exact flow of q' = ω(p - y), p' = -ω(q - x), x' = ω(y - p), y' = -ω(x - q).
Blocks flow_c(double omega, double t, const Blocks& z) {
  const double c = std::cos(2 * omega * t), s = std::sin(2 * omega * t);
  const Block mean_q = (z.q + z.x) / 2, mean_p = (z.p + z.y) / 2;
  const Block dq = (z.q - z.x) / 2, dp = (z.p - z.y) / 2;
  return {mean_q + c * dq + s * dp, mean_q - c * dq - s * dp, mean_p - s * dq + c * dp,
          mean_p + s * dq - c * dp};
}

using Map = std::function<Blocks(double, const Blocks&)>;

Blocks strang(double dt, const Blocks& z) { return flow_a(dt / 2, flow_b(dt, flow_a(dt / 2, z))); }

/// Tao's map of second order with a given ω.
Map tao(double omega) {
  return [omega](double dt, Blocks z) {
    z = flow_b(dt / 2, flow_a(dt / 2, z));
    z = flow_c(omega, dt, z);
    return flow_a(dt / 2, flow_b(dt / 2, z));
  };
}

/// The triple jump of order n out of a method of order n - 2.
Map triple_jump(int n, Map base) {
  const double root = std::pow(2.0, 1.0 / (n - 1)), outer = 1 / (2 - root), middle = -root / (2 - root);
  return [=](double dt, const Blocks& z) { return base(outer * dt, base(middle * dt, base(outer * dt, z))); };
}

/// A(q, x, p, y) = (q - x, p - y), and ζ + Aᵀμ.
Multiplier a_of(const Blocks& z) {
  Multiplier r;
  r << z.q - z.x, z.p - z.y;
  return r;
}
Blocks plus_at(const Blocks& z, const Multiplier& mu) {
  return {z.q + mu.head<4>(), z.x - mu.head<4>(), z.p + mu.tail<4>(), z.y - mu.tail<4>()};
}

struct Solved {
  Blocks zeta;
  int evaluations = 0;
  double correction = 0;
};

/// The projected step with the simplified Newton iteration μ ← μ - f(μ)/4, until ‖Δμ‖ < ε.
Solved simplified_newton(const Map& map, double dt, const Blocks& zeta, double epsilon) {
  Multiplier mu = Multiplier::Zero();
  for (int evaluations = 1;; ++evaluations) {
    REQUIRE(evaluations <= 100);
    const Blocks ahead = plus_at(map(dt, plus_at(zeta, mu)), mu);
    const Multiplier correction = a_of(ahead) / 4;
    if (correction.norm() < epsilon) return {ahead, evaluations, correction.norm()};
    mu -= correction;
  }
}

/// The same with Broyden's method: the inverse Jacobian as a matrix, updated by the formula of Sherman and
/// Morrison.
Solved broyden(const Map& map, double dt, const Blocks& zeta, double epsilon) {
  Multiplier mu = Multiplier::Zero(), step = mu, before = mu;
  Eigen::Matrix<double, 8, 8> inverse = Eigen::Matrix<double, 8, 8>::Identity() / 4;
  for (int evaluations = 1;; ++evaluations) {
    REQUIRE(evaluations <= 100);
    const Blocks ahead = plus_at(map(dt, plus_at(zeta, mu)), mu);
    const Multiplier f = a_of(ahead);
    if (evaluations > 1) {
      const Multiplier inverse_df = inverse * (f - before);
      inverse += ((step - inverse_df) / step.dot(inverse_df) * (step.transpose() * inverse)).eval();
    }
    step = -inverse * f;
    const double correction = std::max(step.norm(), f.norm() / 4);  // the updates may cancel what f still has
    if (correction < epsilon) return {ahead, evaluations, correction};
    mu += step;
    before = f;
  }
}

Blocks doubled(const PhasePoint<double, 4>& z) { return {z.q(), z.q(), z.p(), z.p()}; }

double distance(const Blocks& z, const PhasePoint<double, 4>& other) {
  return std::max(((z.q + z.x) / 2 - other.q()).norm(), ((z.p + z.y) / 2 - other.p()).norm());
}
double distance(const Blocks& z, const ExtendedPoint<double, 4>& other) {
  return std::max({(z.q - other.q()).norm(), (z.x - other.x()).norm(), (z.p - other.p()).norm(),
                   (z.y - other.y()).norm()});
}

/// Each step of the library, from wherever it came, against the formulas.
template <class Stepper, class Formulas>
void equals_formulas(Stepper stepper, const Formulas& formulas, double dt, double epsilon) {
  PhasePoint<double, 4> z = start;
  std::int64_t counted = 0, wanted = 0;
  for (int n = 0; n < 100; ++n) {
    const Solved expected = formulas(dt, doubled(z), epsilon);
    const StepReport report = stepper.step(z, dt);
    REQUIRE(report.ok());
    REQUIRE(distance(expected.zeta, z) <= 1e-14);
    // What is left lies between the copies, on both sides of the mean.
    REQUIRE((expected.zeta.q - z.q()).norm() <= 2 * epsilon);
    REQUIRE(report.correction == Approx(expected.correction).epsilon(1e-3).margin(1e-15));
    counted += report.evaluations;
    wanted += expected.evaluations;
  }
  CHECK(counted == wanted);
}

}  // namespace

TEST_CASE("A projected step equals the four-block formulas", "[four blocks]") {
  const Map jump4 = triple_jump(4, strang), jump6 = triple_jump(6, jump4);
  const auto newton_of = [](Map map) {
    return
        [map](double dt, const Blocks& z, double epsilon) { return simplified_newton(map, dt, z, epsilon); };
  };
  const auto broyden_of = [](Map map) {
    return [map](double dt, const Blocks& z, double epsilon) { return broyden(map, dt, z, epsilon); };
  };
  for (const double epsilon : {1e-6, 1e-11}) {
    for (const double dt : {0.03, -0.08}) {
      CAPTURE(epsilon, dt);
      const SimplifiedNewton simplified{.stop = StoppingRule::paper(epsilon)};
      equals_formulas(Semiexplicit(lattice, schemes::strang(), simplified), newton_of(strang), dt, epsilon);
      equals_formulas(Semiexplicit(lattice, schemes::triple_jump(4), simplified), newton_of(jump4), dt,
                      epsilon);
      equals_formulas(Semiexplicit(lattice, schemes::triple_jump(6), simplified), newton_of(jump6), dt,
                      epsilon);
      const Broyden quasi{.stop = StoppingRule::paper(epsilon)};
      equals_formulas(Semiexplicit(lattice, schemes::strang(), quasi), broyden_of(strang), dt, epsilon);
      equals_formulas(Semiexplicit(lattice, schemes::triple_jump(4), quasi), broyden_of(jump4), dt, epsilon);
    }
  }
}

TEST_CASE("Pihajoki's and Tao's steps equal the four-block formulas", "[four blocks]") {
  const auto follow = [](auto stepper, const Map& map, double dt) {
    ExtendedPoint<double, 4> zeta(start);
    zeta.b.q()[1] += 0.01;  // the copies need not be equal
    zeta.a.p()[2] -= 0.02;
    Blocks blocks{zeta.q(), zeta.x(), zeta.p(), zeta.y()};
    for (int n = 0; n < 20; ++n) {
      REQUIRE(stepper.step(zeta, dt).ok());
      blocks = map(dt, blocks);
      REQUIRE(distance(blocks, zeta) <= 1e-13);
    }
    CHECK(distance(blocks, ExtendedPoint<double, 4>(start)) >= 0.1);
  };
  for (const double dt : {0.05, -0.02}) {
    follow(Pihajoki(lattice, schemes::strang()), strang, dt);
    follow(Pihajoki(lattice, schemes::triple_jump(4)), triple_jump(4, strang), dt);
    follow(Pihajoki(lattice, schemes::triple_jump(6)), triple_jump(6, triple_jump(4, strang)), dt);
    for (const double omega : {0.7, 20.0}) {
      follow(Tao(lattice, schemes::strang(), omega), tao(omega), dt);
      follow(Tao(lattice, schemes::triple_jump(4), omega), triple_jump(4, tao(omega)), dt);
    }
  }
}

TEST_CASE("The midpoint projection is the mean of the copies after Pihajoki's map", "[four blocks]") {
  PhasePoint<double, 4> z = start;
  MidpointProjection stepper(lattice, schemes::triple_jump(4));
  const Map map = triple_jump(4, strang);
  for (int n = 0; n < 50; ++n) {
    const Blocks expected = map(0.05, doubled(z));
    const StepReport report = stepper.step(z, 0.05);
    REQUIRE(report.ok());
    REQUIRE(distance(expected, z) <= 1e-14);
    REQUIRE(report.correction == Approx(a_of(expected).norm() / 4).epsilon(1e-6).margin(1e-15));
  }
}

}  // namespace test_four_blocks
