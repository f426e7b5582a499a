#include "catch.hpp"

#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "gradient_of.hpp"
#include "lattice_energy.hpp"
#include "refusal.hpp"

namespace test_from_energy {

// Gradients from energies: against those written by hand and against closed forms.

namespace {

using namespace semiexplicit;

template <int Dof>
PhasePoint<double, Dof> some_point(Eigen::Index dof) {
  PhasePoint<double, Dof> z(dof);
  for (Eigen::Index i = 0; i < 2 * dof; ++i) z.vector()[i] = std::sin(1.0 + static_cast<double>(i));
  return z;
}

/// The derivative of a function of one variable, by from_energy.
template <class F>
double derivative(double x, const F& f) {
  const auto H = from_energy<1>([f](const auto& q, const auto&) { return f(q[0]); });
  return gradient_of(H, PhasePoint<double, 1>(x, 0))[0];
}

const auto product =
    from_energy<1>([](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; });
static_assert(HasEnergy<decltype(product)> && HasHessian<decltype(product)>);

}  // namespace

TEST_CASE("The gradient of an energy is the one written by hand", "[derivatives]") {
  const auto five = some_point<5>(5);
  CHECK((gradient_of(from_energy<5>(lattice_energy), five) -
         gradient_of(systems::NlsLattice<double, 5>(), five))
            .norm() <= 1e-14);
  // Sizes that take several sweeps of eight, the last one in part.
  for (const Eigen::Index n : {1, 4, 7, 21}) {
    const auto z = some_point<Eigen::Dynamic>(n);
    const systems::NlsLattice<double> hand(n);
    const auto H = from_energy(n, lattice_energy);
    CHECK(H.dof() == n);
    CHECK((gradient_of(H, z) - gradient_of(hand, z)).norm() <= 1e-13);
    CHECK(std::abs(H.energy(z.q(), z.p()) - hand.energy(z.q(), z.p())) <= 1e-13);
  }
  CHECK(refuses([] { from_energy(0, lattice_energy); }, "0 degrees of freedom"));
}

TEST_CASE("The numbers of an energy have the limits of those that they differentiate", "[derivatives]") {
  const auto nearest = [](const auto& q, const auto& p) {
    using std::exp;
    using std::min;
    using Number = std::remove_cvref_t<decltype(q[0])>;
    Number least(std::numeric_limits<Number>::max());
    for (Eigen::Index i = 0; i < q.size(); ++i) least = min(least, 1 - q[i] * q[i]);
    return exp(-least) + p.squaredNorm() / 2;
  };
  const auto slope = [](double q) { return 2 * q * std::exp(q * q - 1); };
  const auto few = from_energy<2>(nearest);
  CHECK(gradient_of(few, PhasePoint<double, 2>({0.3, -0.8}, {0, 0}))[1] == Approx(slope(-0.8)));
  const auto many = from_energy(9, nearest);
  PhasePoint<double, Eigen::Dynamic> z(9);
  z.q()[4] = 0.8;
  CHECK(gradient_of(many, z)[4] == Approx(slope(0.8)));

  // The numbers within a sum over terms are others.
  const auto sum = from_energy(20, [](const auto& q, const auto& p) {
    return sum_over(q.size(),
                    [&](auto i) {
                      using std::exp;
                      using std::min;
                      using Number = std::remove_cvref_t<decltype(q[i])>;
                      return exp(-min(Number(std::numeric_limits<Number>::max()), 1 - q[i] * q[i]));
                    }) +
           p.squaredNorm() / 2;
  });
  PhasePoint<double, Eigen::Dynamic> y(20);
  y.q()[4] = 0.8;
  y.q()[17] = -0.3;
  CHECK(gradient_of(sum, y)[4] == Approx(slope(0.8)));
  CHECK(gradient_of(sum, y)[17] == Approx(slope(-0.3)));
}

TEST_CASE("The Hessian of an energy is the one written by hand", "[derivatives]") {
  const PhasePoint<double, 1> z(-3, 0.5);
  Eigen::Matrix2d automatic, hand;
  product.hessian(z.q(), z.p(), automatic);
  systems::Product<double>().hessian(z.q(), z.p(), hand);
  CHECK((automatic - hand).norm() <= 1e-14);
}

TEST_CASE("A Hessian in several sweeps is the derivative of the gradient", "[derivatives]") {
  const Eigen::Index n = 6;
  const auto z = some_point<Eigen::Dynamic>(n);
  const auto H = from_energy(n, lattice_energy);
  Eigen::MatrixXd hessian(2 * n, 2 * n);
  H.hessian(z.q(), z.p(), hessian);
  const systems::NlsLattice<double> hand(n);
  for (Eigen::Index j = 0; j < 2 * n;
       ++j) {  // the gradient is a cubic: two differences give its slope exactly
    const auto slope = [&](double h) -> Eigen::VectorXd {
      auto above = z, below = z;
      above.vector()[j] += h;
      below.vector()[j] -= h;
      return (gradient_of(hand, above) - gradient_of(hand, below)) / (2 * h);
    };
    CHECK((hessian.col(j) - (4 * slope(0.25) - slope(0.5)) / 3).norm() <= 1e-12);
  }
}

TEST_CASE("Functions obey the chain rule", "[derivatives]") {
  using namespace std;  // NOLINT: as in an energy
  const double x = 0.7;
  CHECK(derivative(x, [](auto q) { return sqrt(q); }) == Approx(0.5 / sqrt(x)));
  CHECK(derivative(x, [](auto q) { return cbrt(q); }) == Approx(pow(x, -2.0 / 3) / 3));
  CHECK(derivative(x, [](auto q) { return exp(2 * q); }) == Approx(2 * exp(2 * x)));
  CHECK(derivative(x, [](auto q) { return expm1(q); }) == Approx(exp(x)));
  CHECK(derivative(x, [](auto q) { return log(3 * q); }) == Approx(1 / x));
  CHECK(derivative(x, [](auto q) { return log1p(q); }) == Approx(1 / (1 + x)));
  CHECK(derivative(x, [](auto q) { return sin(q) * cos(q); }) == Approx(cos(2 * x)));
  CHECK(derivative(x, [](auto q) { return tan(q); }) == Approx(1 / pow(cos(x), 2)));
  CHECK(derivative(x, [](auto q) { return asin(q) - acos(q); }) == Approx(2 / sqrt(1 - x * x)));
  CHECK(derivative(x, [](auto q) { return atan(q); }) == Approx(1 / (1 + x * x)));
  CHECK(derivative(x, [](auto q) { return atan2(sin(q), cos(q)); }) == Approx(1));
  CHECK(derivative(x, [](auto q) { return sinh(q) / cosh(q); }) == Approx(1 - pow(tanh(x), 2)));
  CHECK(derivative(x, [](auto q) { return tanh(q); }) == Approx(1 - pow(tanh(x), 2)));
  CHECK(derivative(x, [](auto q) { return hypot(3 * q, 4 * q); }) == Approx(5));
  CHECK(derivative(-x, [](auto q) { return abs(q) + fabs(q); }) == -2);
  CHECK(derivative(-x, [](auto q) { return pow(q, 3); }) == Approx(3 * x * x));
  CHECK(derivative(0, [](auto q) { return pow(q, 2) + pow(q, 0); }) == 0);
  CHECK(derivative(x, [](auto q) { return pow(q, q); }) == Approx(pow(x, x) * (log(x) + 1)));
  CHECK(derivative(x, [](auto q) { return pow(2, q); }) == Approx(log(2.0) * pow(2.0, x)));
  CHECK(derivative(x, [](auto q) { return (1 - q) / (2 + q) + 1 / q - (3 - q) / 2; }) ==
        Approx(-3 / pow(2 + x, 2) - 1 / (x * x) + 0.5));
  CHECK(derivative(x, [](auto q) { return q > 0.5 ? q * q : -q; }) == Approx(2 * x));
}

TEST_CASE("Energies may be written in terms of Eigen", "[derivatives]") {
  const auto H = from_energy<3>([](const auto& q, const auto& p) {
    using std::sqrt;
    return (2.0 * p - q).squaredNorm() / 2 + 1 / sqrt(q.squaredNorm()) + q.dot(p) + q.head(2).sum();
  });
  const auto z = some_point<3>(3);
  const Eigen::Vector3d q = z.q(), p = z.p(), plane(1, 1, 0);
  const auto gradient = gradient_of(H, z);
  CHECK((gradient.head<3>() - (-(2 * p - q) - q / std::pow(q.norm(), 3) + p + plane)).norm() <= 1e-14);
  CHECK((gradient.tail<3>() - (2 * (2 * p - q) + q)).norm() <= 1e-14);
}

TEST_CASE("A run with an automatic gradient is the run with the one by hand", "[derivatives]") {
  // Nothing may point to what is gone: sums are local, and what the energy returns is an expression of them.
  PhasePoint<double, 1> z(-3, 0), hand_z = z;
  Semiexplicit stepper(product, schemes::low_defect6_s13());
  Semiexplicit by_hand(systems::Product<double>{}, schemes::low_defect6_s13());
  integrate(stepper, z, {.dt = 0.1, .steps = 100});
  integrate(by_hand, hand_z, {.dt = 0.1, .steps = 100});
  CHECK((z.vector() - hand_z.vector()).norm() <= 1e-11);
}

TEST_CASE("Automatic gradients have the precision of their numbers", "[derivatives]") {
  const auto H = from_energy<1, long double>([](const auto& q, const auto& p) {
    using std::exp;
    return exp(q[0] * p[0]);
  });
  const PhasePoint<long double, 1> z(0.1L, 0.2L);
  const auto gradient = gradient_of(H, z);
  CHECK(std::abs(gradient[0] - 0.2L * std::exp(0.1L * 0.2L)) <= 1e-19L);
}

TEST_CASE("A power with an exponent of fewer digits has the precision of its base", "[derivatives]") {
  using Wide = long double;
  const auto check = [](auto c, int dof) {
    const auto energy = [=](const auto& q, const auto& p) {
      using std::pow;
      return p[0] * p[0] / 2 + pow(q[0], c);
    };
    const auto h = from_energy<Wide>(dof, energy);  // by duals, or by a tape
    PhasePoint<Wide, Eigen::Dynamic> z(dof), gradient(dof);
    z.vector().setConstant(3.5L);
    h.gradient(z.q(), z.p(), gradient.q(), gradient.p());
    const Wide exact = Wide(c) * std::pow(3.5L, Wide(c) - 1), slope = (Wide(c) - 1) / 3.5L * exact;
    const Wide epsilon = std::numeric_limits<Wide>::epsilon();
    CHECK(std::abs(gradient.q()[0] / exact - 1) < 4 * epsilon);
    Eigen::Matrix<Wide, Eigen::Dynamic, Eigen::Dynamic> hessian(2 * dof, 2 * dof);
    h.hessian(z.q(), z.p(), hessian);
    CHECK(std::abs(hessian(0, 0) / slope - 1) < 8 * epsilon);
  };
  for (const int dof : {1, 12}) {
    check(0.3, dof);
    check(-0.45, dof);
    check(1.7F, dof);
    check(3, dof);
  }
}

TEST_CASE("Powers have second derivatives at and below zero, mixed arguments theirs", "[derivatives]") {
  const auto h = from_energy<1>([](const auto& q, const auto& p) {
    using std::pow, std::atan2, std::hypot, std::asinh;
    return pow(q[0], 3) + pow(q[0], 2) + pow(q[0], 4.0) + atan2(p[0], 2.0) + hypot(3.0, p[0]) + asinh(p[0]);
  });
  for (const double q : {-1.5, 0.0, 0.7}) {
    CAPTURE(q);
    const double p = 0.4;
    const PhasePoint<double, 1> z(q, p);
    PhasePoint<double, 1> g(0, 0);
    Eigen::Matrix2d second;
    h.gradient(z.q(), z.p(), g.q(), g.p());
    h.hessian(z.q(), z.p(), second);
    CHECK(g.q()[0] == Approx(3 * q * q + 2 * q + 4 * q * q * q));
    CHECK(second(0, 0) == Approx(6 * q + 2 + 12 * q * q));
    const double r = std::sqrt(9 + p * p);
    CHECK(g.p()[0] == Approx(2 / (4 + p * p) + p / r + 1 / std::sqrt(1 + p * p)));
    CHECK(second(1, 1) ==
          Approx(-4 * p / std::pow(4 + p * p, 2) + 9 / (r * r * r) - p / std::pow(1 + p * p, 1.5)));
  }
}

TEST_CASE("A power with an exponent that varies has its derivatives at and below zero", "[derivatives]") {
  using std::pow;
  const auto power = from_energy<1>([](const auto& q, const auto& p) { return pow(q[0], p[0]); });
  Eigen::Matrix2d second;
  for (const double exponent : {2.0, 2.5, 3.0}) {
    CAPTURE(exponent);
    const PhasePoint<double, 1> z(0, exponent);
    CHECK(gradient_of(power, z) == Eigen::Vector2d(0, 0));
    power.hessian(z.q(), z.p(), second);
    CHECK(second(0, 0) == (exponent == 2 ? 2 : 0));
    CHECK(second(0, 1) == 0);
    CHECK(second(1, 1) == 0);
  }
  CHECK(gradient_of(power, PhasePoint<double, 1>(0, 1)) == Eigen::Vector2d(1, 0));
  // Below zero the power exists at whole exponents only: a slope along q, none along p.
  const Eigen::Vector2d below = gradient_of(power, PhasePoint<double, 1>(-3, 2));
  CHECK(below[0] == -6);
  CHECK(std::isnan(below[1]));
  for (const double q : {0.3, 1.0, 2.5})
    for (const double p : {-1.5, 0.0, 0.7, 2.0}) {
      CAPTURE(q, p);
      const double l = std::log(q), v = std::pow(q, p);
      const Eigen::Vector2d gradient = gradient_of(power, PhasePoint<double, 1>(q, p));
      CHECK(gradient[0] == Approx(p * std::pow(q, p - 1)).margin(1e-15));
      CHECK(gradient[1] == Approx(v * l).margin(1e-15));
      power.hessian(Vector<double, 1>(q), Vector<double, 1>(p), second);
      CHECK(second(0, 0) == Approx(p * (p - 1) * std::pow(q, p - 2)).margin(1e-14));
      CHECK(second(0, 1) == Approx(std::pow(q, p - 1) * (1 + p * l)).margin(1e-14));
      CHECK(second(1, 1) == Approx(v * l * l).margin(1e-14));
    }
  // An exponent that is a dual number without being a variable, and a plain base.
  CHECK(derivative(-3, [](auto q) { return pow(q, decltype(q)(2)); }) == -6);
  CHECK(derivative(0, [](auto q) { return pow(q, decltype(q)(0)); }) == 0);
  CHECK(derivative(3, [](auto q) { return pow(0, q); }) == 0);
  CHECK(derivative(3, [](auto q) { return pow(2.0, q); }) == Approx(8 * std::log(2.0)));
}

TEST_CASE("The second derivative of every function is the slope of its first", "[derivatives]") {
  using namespace std;  // NOLINT: as in an energy
  const auto check = [](const char* name, double x, const auto& f) {
    INFO(name);
    const auto slope = [&](double by) { return (derivative(x + by, f) - derivative(x - by, f)) / (2 * by); };
    const double expected = (4 * slope(1e-3) - slope(2e-3)) / 3;
    Eigen::Matrix2d forward;
    from_energy<1>([&](const auto& q, const auto&) {
      return f(q[0]);
    }).hessian(Vector<double, 1>(x), Vector<double, 1>(0), forward);
    CHECK(forward(0, 0) == Approx(expected).epsilon(1e-8));
    // By reverse mode, too: more degrees of freedom than eight.
    Eigen::MatrixXd reverse(18, 18);
    from_energy<9>([&](const auto& q, const auto&) {
      return f(q[0]);
    }).hessian(Vector<double, 9>::Constant(x), Vector<double, 9>::Zero(), reverse);
    CHECK(reverse(0, 0) == Approx(expected).epsilon(1e-8));
  };
#define CHECK_FUNCTION(x, f) check(#f, x, [](auto q) { return f(q); })
  CHECK_FUNCTION(0.7, sin);
  CHECK_FUNCTION(0.7, cos);
  CHECK_FUNCTION(0.7, tan);
  CHECK_FUNCTION(0.7, asin);
  CHECK_FUNCTION(0.7, acos);
  CHECK_FUNCTION(0.7, atan);
  CHECK_FUNCTION(0.7, sinh);
  CHECK_FUNCTION(0.7, cosh);
  CHECK_FUNCTION(0.7, tanh);
  CHECK_FUNCTION(0.7, asinh);
  CHECK_FUNCTION(1.7, acosh);
  CHECK_FUNCTION(0.7, atanh);
  CHECK_FUNCTION(0.7, exp);
  CHECK_FUNCTION(0.7, exp2);
  CHECK_FUNCTION(0.7, expm1);
  CHECK_FUNCTION(0.7, log);
  CHECK_FUNCTION(0.7, log2);
  CHECK_FUNCTION(0.7, log10);
  CHECK_FUNCTION(0.7, log1p);
  CHECK_FUNCTION(0.7, sqrt);
  CHECK_FUNCTION(0.7, cbrt);
  CHECK_FUNCTION(0.7, erf);
  CHECK_FUNCTION(0.7, erfc);
#undef CHECK_FUNCTION
  check("pow", 0.7, [](auto q) { return pow(q, 2.5); });
  check("pow of itself", 0.7, [](auto q) { return pow(q, q); });
  check("hypot", 0.7, [](auto q) { return hypot(q, 0.3); });
  check("atan2", 0.7, [](auto q) { return atan2(q, 0.3); });
}

TEST_CASE("Slopes neither overflow nor cancel where the function does not", "[derivatives]") {
  using namespace std;  // NOLINT: as in an energy
  for (const double x : {1e-200, 1e200}) {
    CHECK(derivative(x, [x](auto q) { return atan2(q, x) * x; }) == Approx(0.5));
    CHECK(derivative(x, [x](auto q) { return atan2(x, q) * x; }) == Approx(-0.5));
    CHECK(derivative(x, [x](auto q) { return hypot(q, x); }) == Approx(sqrt(0.5)));
  }
  CHECK(derivative(1e200, [](auto q) { return asinh(q) * 1e200; }) == Approx(1));
  CHECK(derivative(1e200, [](auto q) { return acosh(q) * 1e200; }) == Approx(1));
  const double next = 1 - 0x1p-40, above = 1 + 0x1p-40;  // 1 - x² loses half of its digits here
  CHECK(derivative(next, [](auto q) { return asin(q) - acos(q); }) ==
        Approx(2 / sqrt(0x1p-40 * (1 + next))).epsilon(1e-14));
  CHECK(derivative(next, [](auto q) { return atanh(q); }) == Approx(0x1p40 / (1 + next)).epsilon(1e-14));
  CHECK(derivative(above, [](auto q) { return acosh(q); }) ==
        Approx(1 / sqrt(0x1p-40 * (1 + above))).epsilon(1e-14));
  const auto magnitude = from_energy<1>([](const auto& q, const auto&) { return abs(q[0]); });
  CHECK_FALSE(signbit(magnitude.energy(Vector<double, 1>(-0.0), Vector<double, 1>(0))));
  CHECK(derivative(-0.0, [](auto q) { return 1 / abs(q); }) == -numeric_limits<double>::infinity());
  // No derivative: it says so, and does not make one up.
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return sqrt(q * q); })));
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return hypot(q, 0.0); })));
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return cbrt(q); })));
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return log(q); })));
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return atan2(q, 0.0 * q); })));
  CHECK_FALSE(isfinite(derivative(0, [](auto q) { return pow(q, -1); })));
}

TEST_CASE("fmax and fmin leave out what is no number, wherever it stands", "[from_energy]") {
  for (const double none : {std::nan(""), -std::nan("")}) {
    const auto slope = [&](auto f) {
      const auto h = from_energy<1>([f](const auto& q, const auto&) { return f(q[0]); });
      PhasePoint<double, 1> gradient;
      const PhasePoint<double, 1> z(0.7, 0);
      h.gradient(z.q(), z.p(), gradient.q(), gradient.p());
      return gradient.q()[0];
    };
    using std::fmax, std::fmin;
    CHECK(slope([=](const auto& q) { return fmax(q * none, 2 * q); }) == 2);
    CHECK(slope([=](const auto& q) { return fmax(2 * q, q * none); }) == 2);
    CHECK(slope([=](const auto& q) { return fmin(q * none, 3 * q); }) == 3);
    CHECK(slope([=](const auto& q) { return fmin(3 * q, q * none); }) == 3);
  }
}

TEST_CASE("Derivatives of functions near their limits have all digits", "[from_energy]") {
  const auto steps = from_energy<2>([](const auto& q, const auto&) {
    using std::expm1, std::tanh;
    return tanh(q[0]) + expm1(q[1]);
  });
  PhasePoint<double, 2> gradient;
  for (const double x : {0.3, 2.0, -9.0, 18.0, -25.0, 300.0, 800.0}) {
    CAPTURE(x);
    const PhasePoint<double, 2> z({x, -std::abs(x)}, {0, 0});
    steps.gradient(z.q(), z.p(), gradient.q(), gradient.p());
    const double small = std::exp(-2 * std::abs(x));
    CHECK(gradient.q()[0] == Approx(4 * small / ((1 + small) * (1 + small))).epsilon(1e-13));
    CHECK(gradient.q()[1] == Approx(std::exp(-std::abs(x))).epsilon(1e-13));
    Eigen::Matrix4d hessian;
    steps.hessian(z.q(), z.p(), hessian);
    CHECK(hessian(0, 0) == Approx(-2 * std::tanh(x) * gradient.q()[0]).epsilon(1e-13));
    CHECK(hessian(1, 1) == Approx(std::exp(-std::abs(x))).epsilon(1e-13));
  }
}

}  // namespace test_from_energy
