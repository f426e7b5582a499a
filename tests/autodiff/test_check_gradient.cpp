#include "catch.hpp"

#include <cmath>
#include <limits>
#include <sstream>

#include <semiexplicit/semiexplicit.hpp>

#include "refusal.hpp"

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
