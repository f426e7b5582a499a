#include "catch.hpp"

#include <boost/multiprecision/cpp_bin_float.hpp>

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <semiexplicit/steppers/detail/gauss_tableau.hpp>

namespace test_gauss_tableau {

namespace {

using namespace semiexplicit;
using Wide = boost::multiprecision::number<boost::multiprecision::cpp_bin_float_50::backend_type,
                                           boost::multiprecision::et_off>;

template <class Scalar>
Scalar a_of(const GaussTableau<Scalar>& t, Eigen::Index i, Eigen::Index j) {
  return t.m(i, j) * t.b[j];
}

/// Closed forms for 1, 2 and 3 stages, and what every collocation method of this kind satisfies.
template <class Scalar>
void check_tableaus(const Scalar& tolerance) {
  using std::sqrt;
  const auto close = [&](const Scalar& x, const Scalar& y) {
    return x - y <= tolerance && y - x <= tolerance;
  };
  const auto fraction = [](int n, int m) { return Scalar(n) / Scalar(m); };

  const GaussTableau<Scalar> one(1), two(2), three(3);
  CHECK(one.c.size() == 1);
  CHECK(close(one.c[0], fraction(1, 2)));
  CHECK(close(one.b[0], Scalar(1)));
  CHECK(close(a_of(one, 0, 0), fraction(1, 2)));

  const Scalar s3 = sqrt(Scalar(3));
  CHECK(close(two.c[0], fraction(1, 2) - s3 / 6));
  CHECK(close(two.c[1], fraction(1, 2) + s3 / 6));
  CHECK(close(two.b[0], fraction(1, 2)));
  CHECK(close(a_of(two, 0, 0), fraction(1, 4)));
  CHECK(close(a_of(two, 0, 1), fraction(1, 4) - s3 / 6));
  CHECK(close(a_of(two, 1, 0), fraction(1, 4) + s3 / 6));

  const Scalar s15 = sqrt(Scalar(15));
  CHECK(close(three.c[0], fraction(1, 2) - s15 / 10));
  CHECK(close(three.c[1], fraction(1, 2)));
  CHECK(close(three.b[0], fraction(5, 18)));
  CHECK(close(three.b[1], fraction(4, 9)));
  CHECK(close(a_of(three, 0, 0), fraction(5, 36)));
  CHECK(close(a_of(three, 0, 1), fraction(2, 9) - s15 / 15));
  CHECK(close(a_of(three, 0, 2), fraction(5, 36) - s15 / 30));
  CHECK(close(a_of(three, 1, 0), fraction(5, 36) + s15 / 24));
  CHECK(close(a_of(three, 1, 2), fraction(5, 36) - s15 / 24));
  CHECK(close(a_of(three, 2, 1), fraction(2, 9) + s15 / 15));

  for (int stages = 1; stages <= 8; ++stages) {
    CAPTURE(stages);
    const GaussTableau<Scalar> t(stages);
    for (int i = 0; i < stages; ++i) {
      if (i > 0) CHECK(t.c[i] > t.c[i - 1]);
      CHECK(close(t.c[i] + t.c[stages - 1 - i], Scalar(1)));
      CHECK(close(t.b[i], t.b[stages - 1 - i]));
      CHECK(t.b[i] > Scalar(0));
    }
    // B(2s): Σ b c^(k-1) = 1/k; C(s): Σ_j a_ij c_j^(k-1) = c_i^k/k.
    Vector<Scalar, Eigen::Dynamic> power = Vector<Scalar, Eigen::Dynamic>::Constant(stages, Scalar(1));
    for (int k = 1; k <= 2 * stages; ++k) {
      CHECK(close(t.b.dot(power), fraction(1, k)));
      for (int i = 0; k <= stages && i < stages; ++i) {
        Scalar sum(0);
        for (int j = 0; j < stages; ++j) sum += a_of(t, i, j) * power[j];
        CHECK(close(sum, power[i] * t.c[i] / Scalar(k)));
      }
      power = power.cwiseProduct(t.c).eval();
    }
    // A polynomial of degree s - 1 from its values at the nodes, where the stages of a next step lie.
    for (const Scalar& ratio : {fraction(1, 8), Scalar(1), Scalar(2)})
      for (int i = 0; i < stages; ++i) {
        using std::abs;
        Scalar at[8];
        const Scalar x = 1 + ratio * t.c[i];
        t.lagrange(x, at);
        for (int k = 0; k < stages; ++k) {
          Scalar sum(0), largest(0), here(1);
          for (int j = 0; j < stages; ++j) {
            Scalar value(1);
            for (int l = 0; l < k; ++l) value *= t.c[j];
            sum += at[j] * value;
            if (abs(at[j]) > largest) largest = abs(at[j]);
          }
          for (int l = 0; l < k; ++l) here *= x;
          CHECK(close((sum - here) / (largest + 1) / here, Scalar(0)));
        }
      }
  }
}

}  // namespace

TEST_CASE("The tableaus are those of Gauss, to the accuracy of the number type", "[gauss]") {
  check_tableaus<double>(1e-15);
  check_tableaus<long double>(4e-19L);
  check_tableaus<float>(1e-6F);
  check_tableaus<Wide>(Wide("1e-48"));
}

TEST_CASE("The condition of symplecticity holds exactly, rounding included", "[gauss]") {
  const auto check = [](auto zero) {
    using Scalar = decltype(zero);
    for (int stages = 1; stages <= 8; ++stages) {
      const GaussTableau<Scalar> t(stages);
      for (int i = 0; i < stages; ++i)
        for (int j = 0; j < stages; ++j) CHECK(t.m(i, j) + t.m(j, i) == Scalar(1));
    }
  };
  check(0.0);
  check(0.0F);
  check(0.0L);
}

TEST_CASE("Numbers of stages that are not there are refused", "[gauss]") {
  for (const int stages : {-1, 0, 9, 100}) {
    CAPTURE(stages);
    std::string text;
    try {
      GaussTableau<double> tableau(stages);
    } catch (const std::invalid_argument& error) {
      text = error.what();
    }
    CHECK(text.find(std::to_string(stages) + " stages") != std::string::npos);
    CHECK(text.find("1 to 8") != std::string::npos);
  }
}

TEST_CASE("In floats the coefficients are the rounded ones", "[gauss]") {
  for (int stages = 1; stages <= 8; ++stages) {
    const GaussTableau<float> rounded(stages);
    const GaussTableau<double> exact(stages);
    CHECK((rounded.b.cast<double>() - exact.b).cwiseAbs().maxCoeff() <= 1.6e-8);
    CHECK((rounded.c.cast<double>() - exact.c).cwiseAbs().maxCoeff() <= 3.1e-8);
  }
}

}  // namespace test_gauss_tableau
