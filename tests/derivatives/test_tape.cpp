#include "catch.hpp"

#include <cmath>
#include <limits>
#include <thread>
#include <vector>

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

#include "forward_gradient.hpp"
#include "gradient_of.hpp"
#include "lattice_energy.hpp"
#include "refusal.hpp"

namespace test_tape {

// Energies of many variables: gradients backwards, Hessians, and their use by the rest of the library.

namespace {

using namespace semiexplicit;
using Eigen::Index;

template <class Scalar = double, int Dof = Eigen::Dynamic>
PhasePoint<Scalar, Dof> some_point(Index dof) {
  PhasePoint<Scalar, Dof> z(dof);
  for (Index i = 0; i < 2 * dof; ++i) z.vector()[i] = Scalar(std::sin(1.0 + 1.7 * static_cast<double>(i)));
  return z;
}

/// A chain by terms, of any length; bonds as (q[i+1] - q[i])^4.
auto chain(Index n) {
  return [n](const auto& q, const auto& p) {
    return sum_over(n, [&](auto i) { return p[i] * p[i] / 2 + q[i] * q[i] / 2; }) +
           sum_over(n - 1, [&](auto i) {
             using std::pow;
             return pow(q[i + 1] - q[i], 4) / 4;
           });
  };
}

}  // namespace

TEST_CASE("An energy of many variables has the gradient by hand", "[tape]") {
  for (const Index n : {9, 13, 50, 333}) {
    CAPTURE(n);
    const auto z = some_point(n);
    const auto right = gradient_of(systems::NlsLattice<double>(n), z);
    CHECK((gradient_of(from_energy(n, lattice_energy), z) - right).norm() <= 1e-14 * right.norm());
  }
  const auto z = some_point<double, 16>(16);
  const auto right = gradient_of(systems::NlsLattice<double, 16>(), z);
  CHECK((gradient_of(from_energy<16>(lattice_energy), z) - right).norm() <= 1e-14 * right.norm());
  CHECK(refuses([] { from_energy(-1, lattice_energy); }, "give one or more"));
}

TEST_CASE("Every function has the same slope backwards as forwards", "[tape]") {
  // One function, or a few, of each coordinate.
  const auto energy = [](const auto& q, const auto& p) {
    using namespace std;  // NOLINT: as in an energy
    const auto one = [&](Index i) { return q[i]; };
    auto y = one(9);
    y += 1, y *= q[9], y -= q[9] / 2, y /= 1 + q[9];
    const bool holds = isfinite(y) && !isnan(y) && y != 0 && y == y && y >= 0 && !(y <= 0);
    return sqrt(one(0)) + cbrt(one(0)) + exp(one(0)) + exp2(one(0)) + expm1(one(0)) +
           log(one(1)) * log2(one(1)) + log10(one(1)) / log1p(one(1)) + sin(one(2)) * cos(one(2)) -
           tan(one(2)) + asin(one(2)) * acos(one(2)) + atan(one(2)) + sinh(one(3)) * cosh(one(3)) -
           tanh(one(3)) + asinh(one(3)) * atanh(one(3)) + acosh(1 + one(3)) + erf(one(4)) +
           erfc(2 * one(4)) * abs(-one(4)) + fabs(one(4)) + atan2(one(5), 2.0) + atan2(1, one(5)) +
           atan2(one(5), one(5) * one(5)) + hypot(one(5), 3) + hypot(1.0, one(5)) + pow(one(6), 3) +
           pow(one(6), 0.5) + pow(2, one(6)) + pow(one(6), one(6)) + pow(one(6), 0) +
           max(one(7), 0.5) * one(7) + min(0.5, one(7)) + fmax(one(7), 0.1) * fmin(one(7), one(7) * one(7)) +
           1 / one(8) - one(8) / 3 + (2 - one(8)) * (one(8) - 2) - (+one(8)) +
           (one(8) > 0.5 ? one(8) * one(8) : -one(8)) + (holds ? y : 0 * y) + pow(-one(10), 3) +
           pow(-one(10), decltype(y)(2)) + abs(-one(10)) * max(-one(10), -1.0) + q[0] * p[0];
  };
  for (const double x : {0.3, 0.7, 0.95}) {
    PhasePoint<double, Eigen::Dynamic> z(20);
    z.vector().setConstant(x);
    const auto found = gradient_of(from_energy(20, energy), z), right = forward_gradient(energy, z);
    for (Index i = 0; i < 40; ++i) {
      CAPTURE(x, i);
      CHECK(std::abs(found[i] - right[i]) <= (i == 0 ? 1e-15 : 1e-14) * (1 + std::abs(right[i])));
      CHECK((right[i] != 0) == (i <= 10 || i == 20));
    }
  }
}

TEST_CASE("The slopes of the error function and of logarithms are the known ones", "[tape]") {
  const double x = 0.8;
  const auto h = from_energy<6>([](const auto& q, const auto&) {
    using namespace std;  // NOLINT: as in an energy
    return erf(q[0]) + erfc(q[1]) + exp2(q[2]) + log2(q[3]) + log10(q[4]) + max(q[5], 0.5) + min(q[5], 0.5) +
           max(0.9, q[5]);
  });
  PhasePoint<double, 6> z(6);
  z.q().setConstant(x);
  const auto slope = gradient_of(h, z);
  const double bell = 2 / std::sqrt(std::acos(-1.0)) * std::exp(-x * x), ln2 = std::log(2.0);
  const double known[] = {bell, -bell, ln2 * std::exp2(x), 1 / (x * ln2), 1 / (x * std::log(10.0)), 1};
  for (Index i = 0; i < 6; ++i) CHECK(slope[i] == Approx(known[i]).epsilon(1e-15));
}

TEST_CASE("What the energy does not depend on does not spoil its gradient", "[tape]") {
  const auto h = from_energy(15, [](const auto& q, const auto& p) {
    using std::log, std::sqrt;
    const auto unused = sqrt(q[0]) + log(p[0]);  // slopes are infinite at 0
    return q[1] * p[1] + (unused > 1e9 ? unused : 0 * q[2]);
  });
  PhasePoint<double, Eigen::Dynamic> z(15);
  z.q()[1] = 2;
  z.p()[1] = 3;
  const auto gradient = gradient_of(h, z);
  CHECK(gradient.allFinite());
  CHECK(gradient[1] == 3);
  // A constant has a gradient, too.
  CHECK(gradient_of(from_energy(15, [](const auto&, const auto&) { return 3.0; }), z).isZero());
}

TEST_CASE("Gradients backwards have the precision of their numbers", "[tape]") {
  using Wide =
      boost::multiprecision::number<boost::multiprecision::cpp_bin_float<60>, boost::multiprecision::et_off>;
  const auto precise = []<class Scalar>(Scalar) {
    const auto z = some_point<Scalar>(14);
    const auto right = gradient_of(systems::NlsLattice<Scalar>(14), z);
    const Scalar off = detail::norm(gradient_of(from_energy<Scalar>(14, lattice_energy), z) - right);
    return static_cast<double>(off / detail::norm(right) / Eigen::NumTraits<Scalar>::epsilon());
  };
  CHECK(precise(1.0f) <= 10);
  CHECK(precise(1.0L) <= 10);
  CHECK(precise(Wide(1)) <= 10);
}

TEST_CASE("A Hessian times a vector is the product", "[tape]") {
  const auto check = [](const auto& h, Index n) {
    constexpr int dof = std::decay_t<decltype(h)>::Dof;
    const auto z = some_point<double, dof>(n);
    auto direction = z, out = z;
    for (Index i = 0; i < 2 * n; ++i) direction.vector()[i] = std::cos(static_cast<double>(i * i));
    Eigen::MatrixXd hessian(2 * n, 2 * n);
    Eigen::Matrix<double, twice(dof), twice(dof)> matrix(2 * n, 2 * n);
    h.hessian(z.q(), z.p(), matrix);
    hessian = matrix;
    h.hessian_times(z.q(), z.p(), direction.q(), direction.p(), out.q(), out.p());
    const Eigen::VectorXd product = hessian * direction.vector();
    CHECK((out.vector() - product).norm() <= 1e-13 * product.norm());
    CHECK(hessian == hessian.transpose());
    // The gradient is a cubic here: two differences give its slope.
    const auto slope = [&](double by) -> Eigen::VectorXd {
      auto above = z, below = z;
      above.vector() += by * direction.vector();
      below.vector() -= by * direction.vector();
      return (gradient_of(h, above) - gradient_of(h, below)) / (2 * by);
    };
    CHECK((product - (4 * slope(0.25) - slope(0.5)) / 3).norm() <= 1e-12 * product.norm());
  };
  check(from_energy<1>([](const auto& q, const auto& p) { return q[0] * q[0] * p[0] * p[0]; }), 1);
  check(from_energy<5>(lattice_energy), 5);
  check(from_energy(7, lattice_energy), 7);
  check(from_energy(23, lattice_energy), 23);
  check(from_energy<15>(chain(15)), 15);
  check(from_energy(31, chain(31)), 31);
  check(from_energy(17,
                    [](const auto& q, const auto& p) {
                      const auto pairs =
                          sum_over_pairs(17, [&](auto i, auto j) { return q[i] * q[j] * p[i]; });
                      return pairs + q[0] * p[16] +
                             sum_over(17, [&](auto i) { return q[i]; }) *
                                 sum_over(17, [&](auto i) { return q[(i + 5) % 17] * p[i]; });
                    }),
        17);
}

TEST_CASE("A gradient backwards takes no part in those of other threads", "[tape]") {
  const Index n = 40;
  const auto h = from_energy(n, chain(n));
  const auto z = some_point(n);
  const auto right = gradient_of(h, z);
  std::vector<int> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t k = 0; k < wrong.size(); ++k)
    threads.emplace_back([&, k] {
      for (int call = 0; call < 300; ++call) wrong[k] += gradient_of(h, z) != right;
    });
  for (auto& thread : threads) thread.join();
  CHECK(wrong == std::vector<int>(4, 0));
}

TEST_CASE("An energy may ask for the gradient of another one, and may throw", "[tape]") {
  const Index n = 16;
  const auto inner = from_energy(n, chain(n));
  const auto z = some_point(n);
  const double weight = gradient_of(inner, z)[2];
  const auto outer = from_energy(n, [&](const auto& q, const auto& p) {
    const auto first = sum_over(n, [&](auto i) { return q[i] * p[i]; });
    const double factor = gradient_of(inner, z)[2];
    return factor * first + sum_over(n, [&](auto i) { return p[i] * p[i] / 2; });
  });
  Eigen::VectorXd hand(2 * n);
  hand << weight * z.p(), weight * z.q() + z.p();
  CHECK((gradient_of(outer, z) - hand).norm() <= 1e-14);
  const auto throws = from_energy(n, [](const auto& q, const auto&) {
    if (q[0] > 0) throw std::runtime_error("q[0] is positive");
    return q[0] * q[0];
  });
  for (int call = 0; call < 2; ++call)
    CHECK(complaint([&] { gradient_of(throws, z); }) == "q[0] is positive");
  CHECK((gradient_of(outer, z) - hand).norm() <= 1e-14);
}

TEST_CASE("Steps, ensembles and tangent maps take gradients backwards", "[tape]") {
  const Index n = 18;
  const auto h = from_energy(n, lattice_by_terms(n));
  const systems::NlsLattice<double> hand(n);
  auto z = some_point(n), by_hand = z;
  Semiexplicit stepper(h, schemes::low_defect6_s13());
  Semiexplicit hand_stepper(hand, schemes::low_defect6_s13());
  integrate(stepper, z, {.dt = 0.01, .steps = 50});
  integrate(hand_stepper, by_hand, {.dt = 0.01, .steps = 50});
  CHECK((z.vector() - by_hand.vector()).norm() <= 1e-11);

  TangentMap tangent(stepper);
  REQUIRE(tangent.at(z, 0.01) == Status::success);
  TangentMap by_differences(hand_stepper);
  REQUIRE(by_differences.at(z, 0.01) == Status::success);
  CHECK((tangent.matrix() - by_differences.matrix()).norm() <= 1e-7);

  const auto start = some_point(n);
  const TimeTransformed K(
      h,
      [](const auto& q, auto&& dgdq) {
        dgdq = 2 * q;
        return 1 + q.squaredNorm();
      },
      h.energy(start.q(), start.p()));
  CHECK(check_gradient(K, K.extended(start, 0.0)).ok());
}

TEST_CASE("A driven energy of many variables has both gradients", "[tape]") {
  const Index n = 20;
  const Autonomous K(from_energy(n, [n](const auto& t, const auto& q, const auto& p) {
    using std::cos;
    return sum_over(n, [&](auto i) { return p[i] * p[i] / 2; }) -
           sum_over(n, [&](auto i) { return cos(q[(i + 1) % n] - q[i]) * (1 + 0.3 * cos(2 * t)); });
  }));
  const auto Z = K.extended(some_point(n), 0.4);
  CHECK(check_gradient(K, Z).ok());
  CHECK(check_gradient(K, Z).judged());
}

}  // namespace test_tape
