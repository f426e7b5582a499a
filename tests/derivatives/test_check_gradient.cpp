#include "catch.hpp"

#include <cmath>
#include <cstdint>
#include <limits>
#include <locale>
#include <random>
#include <sstream>

#include <semiexplicit/accuracy/right_gradient.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>

#include "refusal.hpp"

namespace test_check_gradient {

// What a comparison with the energy finds in gradients that are right and in such that are not.

namespace {

using namespace semiexplicit;

/// The NLS lattice with a gradient that anything may be done to.
template <class Change>
auto changed(const Change& change) {
  return make_hamiltonian<double, 3>(
      [](const auto& q, const auto& p) { return systems::NlsLattice<double, 3>().energy(q, p); },
      [change](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        systems::NlsLattice<double, 3>().gradient(q, p, dHdq, dHdp);
        change(dHdq, dHdp);
      });
}

const PhasePoint<double, 3> point({0.3, -1.2, 0.8}, {0.9, 0.4, -0.7});

template <class Check>
std::string words(const Check& check) {
  std::ostringstream out;
  out << check;
  return out.str();
}

template <class Change>
std::string verdict(const Change& change) {
  return words(check_gradient(changed(change), point));
}

/// No degrees of freedom.
struct Empty {
  using Scalar = double;
  static constexpr int Dof = Eigen::Dynamic;
  Eigen::Index dof() const { return 0; }
  double energy(const In<double, Eigen::Dynamic>&, const In<double, Eigen::Dynamic>&) const { return 1; }
  void gradient(const In<double, Eigen::Dynamic>&, const In<double, Eigen::Dynamic>&,
                Out<double, Eigen::Dynamic>, Out<double, Eigen::Dynamic>) const {}
};

}  // namespace

TEST_CASE("A wrong gradient is named and explained", "[check_gradient]") {
  CHECK(verdict([](auto&, auto&) {}) == "the gradient agrees with the energy");
  const std::string sign = verdict([](auto& dHdq, auto&) { dHdq[1] *= -1; });
  CHECK(says(sign, "dH/dq[1] is "));
  CHECK(says(sign, "but by the energy it is "));
  CHECK(says(sign, "the sign is wrong"));
  CHECK_FALSE(says(sign, "dH/dq[0]"));
  CHECK_FALSE(says(sign, "dH/dp"));
  CHECK(says(verdict([](auto&, auto& dHdp) { dHdp[2] *= 2; }), "a factor 2"));
  CHECK(says(verdict([](auto&, auto& dHdp) { dHdp[2] /= 2; }), "a factor 2"));
  CHECK(says(verdict([](auto&, auto& dHdp) { dHdp[0] = 0; }), "dH/dp[0] is 0"));
  CHECK(says(verdict([](auto&, auto& dHdp) { dHdp[0] = 0; }), "is it set at all?"));
  CHECK(says(verdict([](auto& dHdq, auto& dHdp) { dHdq.swap(dHdp); }), "exchanged"));
  CHECK(says(verdict([](auto& dHdq, auto&) { dHdq[0] = NAN; }), "dH/dq[0] is nan"));
  // A subtle one, in the eleventh digit.
  CHECK(says(verdict([](auto& dHdq, auto&) { dHdq[0] *= 1 + 1e-10; }), "dH/dq[0]"));
}

TEST_CASE("No right gradient is called wrong", "[check_gradient]") {
  // Magnitudes from 1e-6 to 1e6 in one point, in three kinds of number.
  const auto all_right = []<class Scalar>(Scalar) {
    int wrong = 0;
    for (int k = 0; k < 50; ++k) {
      PhasePoint<Scalar, 3> z;
      for (int i = 0; i < 6; ++i)
        z.vector()[i] = Scalar(std::sin(k + 7 * i) * std::pow(10.0, 2 * std::sin(3 * k + i)));
      wrong += !check_gradient(systems::NlsLattice<Scalar, 3>(), z).ok();
    }
    return wrong == 0;
  };
  CHECK(all_right(1.0f));
  CHECK(all_right(1.0));
  CHECK(all_right(1.0L));
}

TEST_CASE("Hard energies are judged with care", "[check_gradient]") {
  // Oscillations much faster than the first step, a singularity close by, and noise in the ninth digit.
  int wrong = 0, blind = 0;
  for (int k = 0; k < 100; ++k) {
    const auto H = [&](double factor) {
      return make_hamiltonian<double, 1>(
          [](const auto& q, const auto& p) {
            const double noise = 1e-9 * std::sin(1e6 * std::sin(1e9 * q[0]));
            return p[0] * p[0] / 2 - 100 * (std::cos(100 * q[0]) + noise) + std::sqrt(q[0] - 0.9);
          },
          [factor](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
            dHdq[0] = factor * (1e4 * std::sin(100 * q[0]) + 0.5 / std::sqrt(q[0] - 0.9));
            dHdp[0] = p[0];
          });
    };
    const PhasePoint<double, 1> z(1.0 + 0.1 * k, 0.3);
    wrong += !check_gradient(H(1), z).ok();
    blind += check_gradient(H(1.01), z).ok();
  }
  CHECK(wrong == 0);
  CHECK(blind == 0);
}

TEST_CASE("What cannot be checked is refused", "[check_gradient]") {
  using Point = PhasePoint<double, Eigen::Dynamic>;
  const systems::NlsLattice<double> H(3);
  CHECK(refuses([&] { check_gradient(H, Point({1, 2}, {3, 4})); }, "z has 2 degrees of freedom"));
  CHECK(refuses([&] { check_gradient(H, Point({1, 2, NAN}, {3, 4, 5})); }, "energy at z is NaN or Inf"));
  CHECK(check_gradient(H, Point(3)).ok());  // all zero
  CHECK(refuses([] { check_gradient(Empty{}, Point(0)); }, "no degrees of freedom"));
  using namespace effects::orbits;
  const Scene dragged(Kinetic<double, 2>{}, Attraction<double, 2>{}, Drag<double, 2>{});
  CHECK(refuses(
      [&] {
        check_gradient(dragged, PhasePoint<double, 2>({1, 2}, {3, 4}));
      },
      "has an effect with a force of its own (OnMotion)"));
}

TEST_CASE("A variable that is zero up to rounding hides nothing", "[check_gradient]") {
  const auto energy = [](const auto& q, const auto& p) { return q[0] + q[1] * q[1] + p[0] * p[0] + p[1]; };
  const auto wrong =
      make_hamiltonian<double, 2>(energy, [](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq << -3, 2;
        dHdp << 2 * p[0], 1;
      });
  const PhasePoint<double, 2> z({std::cos(std::acos(0.0)), 1}, {1, 0.5});
  const auto check = check_gradient(wrong, z);
  CHECK(check.entries[0].wrong);
  CHECK_FALSE(check.entries[1].wrong);
  // And a NaN is wrong where the differences are NaN as well.
  const auto root =
      make_hamiltonian<double, 1>([](const auto& q, const auto& p) { return std::sqrt(q[0]) + p[0]; },
                                  [](const auto& q, const auto&, auto& dHdq, auto& dHdp) {
                                    dHdq[0] = 0 / q[0];
                                    dHdp[0] = 1;
                                  });
  CHECK_FALSE(check_gradient(root, PhasePoint<double, 1>(0, 1)).ok());
}

namespace {

/// H = (q² + 1)(p² + 1)/2, whose gradient's entries go through write(output, value).
template <class Write, class Write2>
auto product_that(const Write& by_q, const Write2& by_p) {
  return make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; },
      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        by_q(dHdq[0], q[0] * (p[0] * p[0] + 1));
        by_p(dHdp[0], p[0] * (q[0] * q[0] + 1));
      });
}
const auto assign = [](double& to, double value) { to = value; };
const auto add = [](double& to, double value) { to += value; };
const auto forget = [](double&, double) {};

}  // namespace

TEST_CASE("A gradient that does not overwrite its outputs is wrong", "[check_gradient]") {
  const PhasePoint<double, 1> z(-3, 0.5), at_rest(-3, 0);
  const auto adds = check_gradient(product_that(add, add), z);
  CHECK_FALSE(adds.ok());
  CHECK(adds.entries[0].output == GradientOutput::added_to);
  CHECK(says(words(adds), "dH/dq[0] is added to what was in the output: write it with ="));
  CHECK(says(words(adds), "dH/dp[0] is added to"));
  // Its true value is zero, so that no difference shows it.
  const auto forgets = check_gradient(product_that(assign, forget), at_rest);
  CHECK_FALSE(forgets.ok());
  CHECK_FALSE(forgets.entries[0].wrong);
  CHECK(forgets.entries[1].output == GradientOutput::not_written);
  CHECK(says(words(forgets), "dH/dp[0] is not written"));
  CHECK_FALSE(check_gradient(product_that(forget, forget), at_rest).ok());
  // Reading is not writing: 0 · NaN.
  const auto clears = [](double& to, double value) { to *= 0, to += value; };
  CHECK(says(words(check_gradient(product_that(clears, assign), z)), "dH/dq[0] depends on what was in"));
  // Nor is every call the same, say where threads share a sum: the last digits may differ.
  int calls = 0;
  const auto shaky = [&calls](double& to, double value) { to = value * (1 + 1e-15 * (++calls % 3)); };
  CHECK(check_gradient(product_that(shaky, assign), z).ok());
  CHECK(words(check_gradient(product_that(assign, assign), at_rest)) ==
        "the gradient agrees with the energy");
}

/// H = p²/2 + q²/2 + q⁴/4, whose gradient for packs has a factor at q³ of its own.
struct OtherInPacks {
  using Scalar = double;
  using PackGradientOf = OtherInPacks;
  static constexpr int Dof = 1;
  double factor;
  double energy(In<double, 1> q, In<double, 1> p) const {
    return (p[0] * p[0] + q[0] * q[0]) / 2 + q[0] * q[0] * q[0] * q[0] / 4;
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq[0] = q[0] + q[0] * q[0] * q[0];
    dHdp[0] = p[0];
  }
  template <class T>
  void gradient(const T* q, const T* p, T* dHdq, T* dHdp) const {
    dHdq[0] = q[0] + factor * q[0] * q[0] * q[0];
    dHdp[0] = p[0];
  }
};

TEST_CASE("A gradient for packs that is another one is wrong", "[check_gradient]") {
  const PhasePoint<double, 1> z(0.7, -0.3);
  static_assert(HasPackGradient<OtherInPacks>);
  CHECK(check_gradient(OtherInPacks{1}, z).ok());
  for (const double factor : {0., 1.0001}) {
    std::ostringstream words;
    const auto check = check_gradient(OtherInPacks{factor}, z);
    words << check;
    CHECK_FALSE(check.ok());
    CHECK(check.entries[0].wrong);
    CHECK_FALSE(check.entries[1].wrong);
    CHECK_THAT(words.str(),
               Catch::Contains("dH/dq[0] is another number where the gradient is called with packs"));
  }
}

/// The Earth as an oscillator, in SI units: dH/dq is of the order 1e22, dH/dp of 1e4; the second one for
/// packs has a factor. Two bodies whose forces cancel where they stand in the middle.
struct HeavyInPacks {
  using Scalar = double;
  using PackGradientOf = HeavyInPacks;
  static constexpr int Dof = 2;
  static constexpr double mass = 5.97e24, spring = mass * 3.9e-14;
  double factor;
  double energy(In<double, 2> q, In<double, 2> p) const {
    return (p[0] * p[0] / mass + p[1] * p[1] / mass + spring * (q[0] - q[1]) * (q[0] - q[1])) / 2;
  }
  void gradient(In<double, 2> q, In<double, 2> p, Out<double, 2> dHdq, Out<double, 2> dHdp) const {
    dHdq[0] = spring * (q[0] - q[1]);
    dHdq[1] = spring * (q[1] - q[0]);
    dHdp = p / mass;
  }
  template <class T>
  void gradient(const T* q, const T* p, T* dHdq, T* dHdp) const {
    dHdq[0] = spring * q[0] - spring * q[1];  // rounded otherwise
    dHdq[1] = spring * q[1] - spring * q[0];
    dHdp[0] = p[0] / mass;
    dHdp[1] = factor * p[1] / mass;
  }
};

TEST_CASE("A gradient for packs is compared in the units of each entry", "[check_gradient]") {
  const double q = 1.5e11, p = HeavyInPacks::mass * 3e4;
  for (const double apart : {0., 1e-15, 1.}) {
    CAPTURE(apart);
    const PhasePoint<double, 2> z({q, q * (1 - apart)}, {p, p * 1e-9});
    CHECK(check_gradient(HeavyInPacks{1}, z).ok());
    for (const double factor : {-2., 1.0001}) CHECK(check_gradient(HeavyInPacks{factor}, z).entries[3].wrong);
  }
}

TEST_CASE("Not judged is told from right", "[check_gradient]") {
  const auto times = [](double factor) {
    return [factor](double& to, double value) { to = factor * value; };
  };
  // So near to the origin that steps of a tenth of z move the energy by less than its rounding: larger ones
  // judge.
  for (const double size : {1e-4, 1e-8, 1e-10}) {
    CAPTURE(size);
    const PhasePoint<double, 1> z(size, -2 * size);
    const auto right = check_gradient(product_that(assign, assign), z);
    CHECK(right.ok());
    CHECK(right.judged());
    CHECK_FALSE(check_gradient(product_that(times(1.01), assign), z).ok());
    CHECK(says(words(check_gradient(product_that(assign, times(-1)), z)), "the sign is wrong"));
  }
  // Nothing is known about a gradient of 1e-20 beside an energy of 1/2.
  const auto blind = check_gradient(product_that(times(-1), assign), PhasePoint<double, 1>(1e-20, 0.5));
  CHECK(blind.ok());
  const auto hidden = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return 1e18 + q[0] * q[0] / 2 + 1e15 * p[0] * p[0]; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = -q[0];
        dHdp[0] = 2e15 * p[0];
      });
  const auto unsure = check_gradient(hidden, PhasePoint<double, 1>(1, 1));
  CHECK(unsure.ok());
  CHECK_FALSE(unsure.judged());
  CHECK_FALSE(unsure.entries[0].judged);
  CHECK(unsure.entries[1].judged);
  CHECK(says(words(unsure), "agrees with the energy in the entries that could be judged"));
  CHECK(says(words(unsure), "not judged: dH/dq[0]; the differences"));
  // An entry is judged to be zero where the energy moves nearby, and where it depends on nothing there.
  CHECK(check_gradient(product_that(assign, assign), PhasePoint<double, 1>(-3, 0)).judged());
  CHECK(check_gradient(product_that(assign, assign), PhasePoint<double, 1>(0, 0)).judged());
  const auto cyclic = make_hamiltonian<double, 1>(
      [](const auto&, const auto& p) { return p[0] * p[0] / 2; },
      [](const auto&, const auto& p, auto& dHdq, auto& dHdp) { dHdq[0] = 0, dHdp[0] = p[0]; });
  CHECK(check_gradient(cyclic, PhasePoint<double, 1>(1, 0.3)).judged());
  // At the edge of the domain.
  const auto edge = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return std::sqrt(q[0]) + p[0]; },
      [](const auto&, const auto&, auto& dHdq, auto& dHdp) { dHdq[0] = 1, dHdp[0] = 1; });
  const auto at_edge = check_gradient(edge, PhasePoint<double, 1>(0, 1));
  CHECK_FALSE(at_edge.entries[0].judged);
  CHECK(at_edge.entries[1].judged);
  const auto wall = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) {
        if (!(q[0] > -0.01)) throw std::domain_error("beyond the wall");
        return p.squaredNorm() / 2 + q[0] - 0.1 * std::log(q[0] + 0.01) + q[1] * q[1] / 2;
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq << 1 - 0.1 / (q[0] + 0.01), q[1];
        dHdp = p;
      });
  for (const double q : {0., 1e-3, 0.3})
    for (const double other : {0., 5.})
      CHECK(check_gradient(wall, PhasePoint<double, 2>({q, other}, {0.3, 0.2})).ok());
}

TEST_CASE("The words on a gradient do not depend on the locale", "[check_gradient]") {
  struct Comma : std::numpunct<char> {
    char do_decimal_point() const override { return ','; }
  };
  const std::locale before = std::locale::global(std::locale(std::locale::classic(), new Comma));
  const std::string text = verdict([](auto& dHdq, auto&) { dHdq[1] *= -1; });
  std::locale::global(before);
  CHECK(says(text, "."));
  CHECK(text == verdict([](auto& dHdq, auto&) { dHdq[1] *= -1; }));
}

TEST_CASE("Entries of very different sizes are judged by the rounding of the values used",
          "[check_gradient]") {
  const auto times = [](double factor) {
    return [factor](double& to, double value) { to = factor * value; };
  };
  const auto right = product_that(assign, assign);
  const auto by_q = product_that(times(1.001), assign);
  const auto by_p = product_that(assign, times(1.001));
  CHECK(check_gradient(right, PhasePoint<double, 1>(1e7, 1e-6)).judged());
  std::mt19937 random(3);
  std::uniform_real_distribution<double> decade(-8, 8);
  int wrong = 0, passed = 0, found = 0;
  for (int k = 0; k < 300; ++k) {
    const double q = std::pow(10.0, decade(random)), p = std::pow(10.0, decade(random));
    const PhasePoint<double, 1> z(k % 2 == 0 ? q : -q, k % 3 == 0 ? -p : p);
    wrong += !check_gradient(right, z).ok();
    const auto first = check_gradient(by_q, z).entries[0], second = check_gradient(by_p, z).entries[1];
    passed += (first.judged && !first.wrong) + (second.judged && !second.wrong);
    found += first.wrong + second.wrong;
  }
  CHECK(wrong == 0);
  CHECK(passed == 0);
  CHECK(found >= 450);
  // A molecule in SI units.
  const auto molecule = [](double sign) {
    return make_hamiltonian<double, 1>(
        [](const auto& q, const auto& p) { return p[0] * p[0] / 2e-27 + 1e3 * q[0] * q[0] / 2; },
        [sign](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = 1e3 * q[0];
          dHdp[0] = sign * p[0] / 1e-27;
        });
  };
  const PhasePoint<double, 1> z(1e-10, 1e-23);
  CHECK(words(check_gradient(molecule(1), z)) == "the gradient agrees with the energy");
  CHECK(check_gradient(molecule(-1), z).entries[1].wrong);
  // A feature far narrower than the largest entry, and a tiny one beside it.
  const auto fast = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return std::sqrt(1 + 1e16 * p.squaredNorm()) + q.squaredNorm(); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq = 2 * q;
        dHdp = 1e16 * p / std::sqrt(1 + 1e16 * p.squaredNorm());
      });
  CHECK(check_gradient(fast, PhasePoint<double, 2>({84.1305, 4.73107e-10}, {1.40328e-10, 0.0101959})).ok());
}

TEST_CASE("Oscillations far faster than the variable is large are resolved", "[check_gradient]") {
  // A late time, which is a variable here, and a large angle.
  const auto driven = [](double sign) {
    return make_hamiltonian<double, 2>(
        [](const auto& q, const auto& p) {
          return p[0] * p[0] / 2 + p[1] - std::cos(q[0]) * (1 + 0.5 * std::cos(3 * q[1]));
        },
        [sign](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = std::sin(q[0]) * (1 + 0.5 * std::cos(3 * q[1]));
          dHdq[1] = sign * 1.5 * std::cos(q[0]) * std::sin(3 * q[1]);
          dHdp << p[0], 1;
        });
  };
  int wrong = 0, passed = 0, found = 0, all = 0;
  for (const double late : {1e4, 1e5, 1e6, 1e7, 1e8, 1e9})
    for (int k = 0; k < 20; ++k, ++all) {
      const PhasePoint<double, 2> z({0.3 + 0.04 * k, late * (1 + 0.0317 * k)}, {0.5 - 0.01 * k, -0.2});
      const auto right = check_gradient(driven(1), z), other = check_gradient(driven(-1), z);
      wrong += !right.ok();
      passed += other.ok() && other.judged();
      found += other.entries[1].wrong;
      CHECK_FALSE((other.entries[0].wrong || other.entries[2].wrong || other.entries[3].wrong));
    }
  CHECK(wrong == 0);
  CHECK(passed == 0);
  CHECK(found >= all - 5);
  const auto angle = [](double sign) {
    return make_hamiltonian<double, 1>(
        [](const auto& q, const auto& p) { return p[0] * p[0] / 2 - std::cos(30 * q[0]) / 30; },
        [sign](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = sign * std::sin(30 * q[0]);
          dHdp[0] = p[0];
        });
  };
  for (const double q : {13.713, 137.13, 1371.3, 13713.0, 137131.0}) {
    CHECK(check_gradient(angle(1), PhasePoint<double, 1>(q, 0.5)).ok());
    CHECK_FALSE(check_gradient(angle(-1), PhasePoint<double, 1>(q, 0.5)).ok());
    CHECK_FALSE(check_gradient(angle(0), PhasePoint<double, 1>(q, 0.5)).ok());
  }
}

TEST_CASE("A gradient of a variable that the energy does not depend on is wrong", "[check_gradient]") {
  const auto extra = make_hamiltonian<double, 1>([](const auto&, const auto& p) { return p[0] * p[0] / 2; },
                                                 [](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
                                                   dHdq[0] = 5;
                                                   dHdp[0] = p[0];
                                                 });
  CHECK(check_gradient(extra, PhasePoint<double, 1>(1, 0.3)).entries[0].wrong);
}

TEST_CASE("Where the energy is coarsely rounded no right gradient is wrong", "[check_gradient]") {
  // A large number that is added and taken away again leaves multiples of its own rounding.
  const auto pendulum = [](double offset, double factor) {
    return make_hamiltonian<double, 1>(
        [=](const auto& q, const auto& p) { return (offset + (p[0] * p[0] / 2 - std::cos(q[0]))) - offset; },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = factor * std::sin(q[0]);
          dHdp[0] = p[0];
        });
  };
  int wrong = 0, found = 0;
  for (const double offset : {1e6, 1e8, 1e9, 3e9, 1e10, 3e10, 1e11, 1e12, 1e13, 1e15, 1e17})
    for (const double q : {0.3, 0.7, 1.3}) {
      const PhasePoint<double, 1> z(q, 0.2);
      wrong += !check_gradient(pendulum(offset, 1), z).ok();
      found += check_gradient(pendulum(offset, -1), z).entries[0].wrong;
    }
  CHECK(wrong == 0);
  CHECK(found >= 18);  // up to 1e11, where the rounding is 1e-5
  // The relativistic kinetic energy in SI units: multiples of 20 J.
  const auto falling = [](double factor) {
    constexpr double c = 299792458;
    return make_hamiltonian<double, 1>(
        [](const auto& q, const auto& p) {
          return c * c * (std::sqrt(1 + p[0] * p[0] / (c * c)) - 1) + 9.81 * q[0];
        },
        [factor](const auto&, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = 9.81;
          dHdp[0] = factor * p[0] / std::sqrt(1 + p[0] * p[0] / (c * c));
        });
  };
  for (const double v : {1.0, 10.0, 100.0, 1e3, 3e3, 1e4, 3e4, 1e5, 1e6}) {
    CAPTURE(v);
    const PhasePoint<double, 1> z(100, v);
    CHECK(check_gradient(falling(1), z).ok());
    CHECK(detail::glance_at_gradient(falling(1), z).complaint == "");
    CHECK(detail::glance_at_gradient(falling(1), PhasePoint<double, 1>(0, v)).complaint == "");
    if (v >= 3e3) {
      const auto check = check_gradient(falling(1.01), z);
      CHECK(check.entries[1].wrong);
      CHECK_FALSE(check.entries[0].wrong);
    }
  }
}

TEST_CASE("Positions are judged beside positions, and momenta beside momenta, in any units",
          "[check_gradient]") {
  // The potential is below the rounding of the energy.
  const auto wave = make_hamiltonian<double, 2>(
      [](const auto& q, const auto& p) { return p.squaredNorm() / 2 + std::sin(q[0] + q[1]); },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = dHdq[1] = std::cos(q[0] + q[1]);
        dHdp = p;
      });
  for (const double p : {1e6, 1e7, 3e8, 1e10})
    CHECK(check_gradient(wave, PhasePoint<double, 2>({1, 0.5}, {p, 0.3 * p})).ok());
  // A planet in SI units, with the Sun at rest in the origin.
  const double gm = 1.327e20, mass = 1.9e27;
  const auto planet = make_hamiltonian<double, 2>(
      [=](const auto& q, const auto& p) { return p.squaredNorm() / (2 * mass) - gm * mass / q.norm(); },
      [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq = gm * mass / std::pow(q.norm(), 3) * q;
        dHdp = p / mass;
      });
  const auto check = check_gradient(planet, PhasePoint<double, 2>({7.8e11, 0}, {0, 1.3e4 * mass}));
  CHECK(check.ok());
  CHECK(check.judged());
}

/// A spring in scaled coordinates, k (q/unit - rest)²/2.
template <class T>
struct ScaledSpring {
  using Scalar = T;
  static constexpr int Dof = 1;
  T unit, rest, k;
  T energy(In<T, 1> q, In<T, 1> p) const {
    const T x = q[0] / unit - rest;
    return p[0] * p[0] / 2 + k * x * x / 2;
  }
  void gradient(In<T, 1> q, In<T, 1> p, Out<T, 1> dHdq, Out<T, 1> dHdp) const {
    dHdq[0] = k * (q[0] / unit - rest) / unit;
    dHdp[0] = p[0];
  }
};
template <class T>
int refused_at_rest() {
  int refused = 0;
  for (int n = 1; n <= 2000; ++n) {
    const T x = T(n);
    const ScaledSpring<T> spring{5 + 4 * std::sin(x), 20 * std::sin(2 * x), 1 + std::cos(3 * x) / 2};
    if (!check_gradient(spring, PhasePoint<T, 1>(spring.rest * spring.unit, std::sin(5 * x))).ok()) ++refused;
  }
  return refused;
}

TEST_CASE("A right gradient at the rest of a spring in scaled coordinates is not called wrong",
          "[check_gradient]") {
  // The rounding of q makes it 0, where the energy says one rounding, and the other way round.
  CHECK(refused_at_rest<double>() == 0);
  CHECK(refused_at_rest<float>() == 0);
  CHECK(refused_at_rest<long double>() == 0);
  const ScaledSpring<double> spring{3, 7, 2};
  struct Off : ScaledSpring<double> {  // by some hundred roundings of the force at q
    void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
      ScaledSpring::gradient(q, p, dHdq, dHdp);
      dHdq[0] += 1e-12;
    }
  };
  CHECK_FALSE(check_gradient(Off{spring}, PhasePoint<double, 1>(21.0, 0.3)).ok());
}

/// Beside a coordinate of size one another that is zero and counts in 1e-7, with a wrong sign.
struct WrongSign {
  using Scalar = double;
  static constexpr int Dof = 2;
  double unit = 1e-7;
  double energy(In<double, 2> q, In<double, 2> p) const {
    const double x = q[1] / unit;
    return p.squaredNorm() / 2 + q[0] * q[0] / 2 + x * q[0] + x * x * x * x / 4;
  }
  void gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    const double x = q[1] / unit;
    dHdq[0] = q[0] + x;
    dHdq[1] = -(q[0] + x * x * x) / unit;
    dHdp = p;
  }
};

TEST_CASE("An entry is not judged to be right by differences that are more uncertain than it is large",
          "[check_gradient]") {
  for (const double unit : {1.0, 1e-3, 1e-5, 1e-6, 1e-7, 1e-9}) {
    const auto check = check_gradient(WrongSign{unit}, PhasePoint<double, 2>({1, 0}, {0.3, 0.2}));
    CAPTURE(unit);
    CHECK((check.entries[1].wrong || !check.entries[1].judged));
  }
}

TEST_CASE("A half that is zero is not judged by the size of the other one alone", "[check_gradient]") {
  // A car over a rough road: beside its energy the road is but rounding.
  const auto h = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) {
        return p[0] * p[0] / 2000 + 1e4 * (std::sin(10 * q[0] + 0.4) + q[0] / std::hypot(1.0, q[0]));
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = 1e4 * (10 * std::cos(10 * q[0] + 0.4) + std::pow(std::hypot(1.0, q[0]), -3));
        dHdp[0] = p[0] / 1000;
      });
  for (const double p : {1.0, 1e4, 1e8, 1e12}) {
    const auto check = check_gradient(h, PhasePoint<double, 1>(0, p));
    CAPTURE(p, check);
    CHECK(check.ok());
    CHECK(check.judged() == (p < 1e10));
  }
}

TEST_CASE("A half that is zero is judged by steps that move the energy, whatever the units",
          "[check_gradient]") {
  // Springs that overflow not far from where they are; a coupling by momenta that are counted in other units.
  const auto toda = [](double length, double factor) {
    return make_hamiltonian<double, 2>(
        [=](const auto& q, const auto& p) {
          return p.squaredNorm() / 2 + std::exp(q[0] / length) + 2 * std::exp((q[1] - q[0]) / length);
        },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          const double first = std::exp(q[0] / length), second = 2 * std::exp((q[1] - q[0]) / length);
          dHdq[0] = factor * (first - second) / length;
          dHdq[1] = second / length;
          dHdp = p;
        });
  };
  const auto coupled = [](double length, double momentum, double factor) {
    return make_hamiltonian<double, 2>(
        [=](const auto& q, const auto& p) {
          const double x = q[0] / length, y = q[1] / length, u = p[0] / momentum, v = p[1] / momentum;
          return (u * u + v * v + x * x + y * y + x * y * u) / 2;
        },
        [=](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          const double x = q[0] / length, y = q[1] / length, u = p[0] / momentum, v = p[1] / momentum;
          dHdq[0] = (x + y * u / 2) / length;
          dHdq[1] = (y + x * u / 2) / length;
          dHdp[0] = factor * (u + x * y / 2) / momentum;
          dHdp[1] = v / momentum;
        });
  };
  for (const double unit : {1e-12, 1e-6, 1e-3, 1., 1e6, 1e15}) {
    for (const double p : {1e-3, 1., 1e3}) {
      CAPTURE(unit, p);
      const PhasePoint<double, 2> z({0, 0}, {0.7 * p, 0.3 * p});
      CHECK(check_gradient(toda(unit, 1), z).ok());
      for (const double factor : {-1., 0., 0.5, 2.}) {
        const auto check = check_gradient(toda(unit, factor), z);
        CHECK_FALSE((check.ok() && check.judged()));
      }
    }
    for (const double momentum : {1e-18, 1e-6, 1., 1e12}) {
      CAPTURE(unit, momentum);
      const PhasePoint<double, 2> z({1.3 * unit, -0.7 * unit}, {0, 0});
      const auto right = check_gradient(coupled(unit, momentum, 1), z);
      CHECK((right.ok() && right.judged()));
      for (const double factor : {-1., 0., 1.01})
        CHECK(check_gradient(coupled(unit, momentum, factor), z).entries[2].wrong);
    }
  }
}

TEST_CASE("An output is looked at in the units of its half", "[check_gradient]") {
  constexpr double mass = HeavyInPacks::mass;
  int calls = 0;
  for (const bool changes : {false, true}) {
    const auto h = make_hamiltonian<double, 1>(
        [](const auto& q, const auto& p) { return p[0] * p[0] / 2 / mass + 1e-14 * mass * q[0] * q[0]; },
        [&calls, changes](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
          dHdq[0] = 2e-14 * mass * q[0];
          dHdp[0] = p[0] / mass * (changes && ++calls > 1 ? 3 : 1);
        });
    CHECK(check_gradient(h, PhasePoint<double, 1>(1.5e11, 3e4 * mass)).ok() == !changes);
  }
}

TEST_CASE("An angle so large that its rounding hides the oscillation is not judged", "[check_gradient]") {
  const auto rotor = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) {
        return p[0] * p[0] / 2 * (1 + 0.1 * std::cos(q[0])) - std::cos(q[0]);
      },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = std::sin(q[0]) * (1 - 0.05 * p[0] * p[0]);
        dHdp[0] = p[0] * (1 + 0.1 * std::cos(q[0]));
      });
  int wrong = 0, judged = 0;
  for (int exponent = 14; exponent <= 150; exponent += 2)
    for (const double p : {1.0, 1e3, 1e-3})
      for (const double q : {1.0, 1.3, 2.7}) {
        const double angle = q * std::pow(10.0, exponent);
        const auto check = check_gradient(rotor, PhasePoint<double, 1>(angle, p * angle));
        wrong += !check.ok();
        judged += exponent >= 20 && check.entries[0].judged;
      }
  CHECK(wrong == 0);
  CHECK(judged == 0);
}

TEST_CASE("A check comes back where an entry is next to nothing, or huge and moves nothing",
          "[check_gradient]") {
  const auto oscillator =
      from_energy<1>([](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; });
  for (const double q : {1e-310, 1e-320, 5e-324}) CHECK(check_gradient(oscillator, {q, 0.5}).ok());
  const auto in_float =
      from_energy<1, float>([](const auto& q, const auto& p) { return (p[0] * p[0] + q[0] * q[0]) / 2; });
  CHECK(check_gradient(in_float, {1e-40F, 0.5F}).ok());
  const auto free = from_energy<1>([](const auto& q, const auto& p) { return p[0] * p[0] / 2 + 0 * q[0]; });
  CHECK(check_gradient(free, {1e303, 0.5}).ok());
  const systems::NlsLattice<double, 41> lattice;
  PhasePoint<double, 41> packet;
  for (int i = 0; i < 41; ++i) packet.q()[i] = std::exp(-1.775 * (i - 20) * (i - 20));
  packet.p() = 0.1 * packet.q();
  CHECK(check_gradient(lattice, packet).ok());
}

TEST_CASE("A right gradient where the energy underflows is not called wrong", "[check_gradient]") {
  const auto oscillator = make_hamiltonian<double, 1>(
      [](const auto& q, const auto& p) { return (q[0] * q[0] + p[0] * p[0]) / 2; },
      [](const auto& q, const auto& p, auto& dHdq, auto& dHdp) {
        dHdq[0] = q[0];
        dHdp[0] = p[0];
      });
  for (const double size : {1e-150, 1e-160, 1e-170}) {
    const auto check = check_gradient(oscillator, PhasePoint<double, 1>(size, -size));
    CHECK(check.ok());
    CHECK(check.judged() == (size > 1e-154));
  }
}

TEST_CASE("Right gradients of close vortices are not called wrong, in float", "[check_gradient]") {
  const systems::PointVortices<float, 2> vortices(Vector<float, 2>(1, 1));
  int called_wrong = 0;
  std::uint64_t random = 7;
  for (int k = 0; k < 4000; ++k) {
    PhasePoint<float, 2> z;
    for (float& x : z.vector()) x = 0.03F * static_cast<float>(detail::scattered(random));
    called_wrong += !check_gradient(vortices, z).ok();
  }
  CHECK(called_wrong == 0);
}

// exp(-x²) beside polynomials: far out these are all there is.
struct Hidden {
  using Scalar = float;
  static constexpr int Dof = 3;
  Vector<float, 3> a{0.836563349F, 0.589241207F, 0.924439609F}, b{-0.142685026F, 0.389146954F, -0.93529737F},
      c{-0.97199589F, -0.347836137F, -0.240729868F}, d{-0.970645964F, -0.570383191F, -0.0533944853F};
  float length = 0x1p-18F, momentum = 0x1p-13F;
  float energy(In<float, 3> q, In<float, 3> p) const {
    const float x = a.dot(q) / length, y = b.dot(p) / momentum, u = c.dot(q) / length,
                v = d.dot(p) / momentum;
    return 32 * (1.65422118F * std::exp(-x * x) * std::log(3 + y * y) - 1.26252162F * u * u / 2 * v * v / 2);
  }
  void gradient(In<float, 3> q, In<float, 3> p, Out<float, 3> dHdq, Out<float, 3> dHdp) const {
    const float x = a.dot(q) / length, y = b.dot(p) / momentum, u = c.dot(q) / length,
                v = d.dot(p) / momentum;
    const float e = 32 * 1.65422118F * std::exp(-x * x), f = 32 * 1.26252162F / 2;
    dHdq = (-2 * x * e * std::log(3 + y * y) * a - f * u * v * v * c) / length;
    dHdp = (e * 2 * y / (3 + y * y) * b - f * u * u * v * d) / momentum;
  }
};

struct Waves {
  using Scalar = double;
  static constexpr int Dof = 1;
  double length, momentum;
  double energy(In<double, 1> q, In<double, 1> p) const {
    const double x = q[0] / length, y = p[0] / momentum;
    return 1 + std::sqrt(1 + x * x) * y * y / 2 - std::sin(x) * std::sin(y);
  }
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    const double x = q[0] / length, y = p[0] / momentum;
    dHdq[0] = (x / std::sqrt(1 + x * x) * y * y / 2 - std::cos(x) * std::sin(y)) / length;
    dHdp[0] = (std::sqrt(1 + x * x) * y - std::sin(x) * std::cos(y)) / momentum * factor;
  }
  double factor = 1;
};

/// H = (q² + 1)(p² + 1)/2; one gradient for columns and packs, whose outputs are of any type.
struct OneForAll {
  using Scalar = double;
  using PackGradientOf = OneForAll;
  static constexpr int Dof = 1;
  double energy(const auto& q, const auto& p) const { return (q[0] * q[0] + 1) * (p[0] * p[0] + 1) / 2; }
  void gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    dHdq[0] = q[0] * (p[0] * p[0] + 1.0);
    dHdp[0] = p[0] * (q[0] * q[0] + 1.0);
  }
};

TEST_CASE("A gradient whose outputs are auto& is checked with packs, too", "[check_gradient]") {
  CHECK(check_gradient(OneForAll(), PhasePoint<double, 1>(-3, 0.5)).ok());
}

TEST_CASE("Steps so large that they pass over what the energy does near z call nothing wrong, in float",
          "[check_gradient]") {
  const Hidden hidden;
  std::uint64_t random = 1;
  int wrong = 0;
  for (int n = 0; n < 300; ++n) {
    PhasePoint<float, 3> z;
    for (int i = 0; i < 3; ++i) {
      z.q()[i] = 2 * hidden.length * static_cast<float>(detail::scattered(random));
      z.p()[i] = 2 * hidden.momentum * static_cast<float>(detail::scattered(random));
    }
    if (!check_gradient(hidden, z).ok()) ++wrong;
  }
  CHECK(wrong == 0);
}

TEST_CASE("A half that is zero and of tiny units is not judged by steps that pass over its oscillation",
          "[check_gradient]") {
  for (const double length : {1.0, 1e7, 1e12})
    for (const double momentum : {1.0, 1e-10, 1e-12, 1e-16})
      for (int i = 1; i < 20; ++i) {
        CAPTURE(length, momentum, i);
        const PhasePoint<double, 1> z(length * i / 7.3, 0);
        CHECK(check_gradient(Waves{length, momentum}, z).ok());
        CHECK_FALSE(check_gradient(Waves{length, momentum, 2}, z).ok());
      }
}

}  // namespace test_check_gradient
