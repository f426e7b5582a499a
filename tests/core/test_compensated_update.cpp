#include "catch.hpp"

#include <cmath>
#include <limits>

#include <semiexplicit/steppers/detail/compensated_update.hpp>

namespace test_compensated_update {

namespace {
using namespace semiexplicit;
}

TEST_CASE("A million increments leave one rounding error", "[compensated]") {
  CompensatedUpdate<double, 1> update(1);
  PhasePoint<double, 1> z(3, -1e3);
  double plain = 3;
  const double dq = 0.1, dp = 1e-3 / 3;
  for (int n = 0; n < 1'000'000; ++n) {
    REQUIRE(update.update(z, [&](Eigen::Index i) { return i == 0 ? dq : dp; }));
    plain += dq;
  }
  const long double q = 3 + 1e6L * dq, p = -1e3L + 1e6L * dp;
  CHECK(std::abs(static_cast<double>(z.q()[0] - q)) <= std::nextafter(1e5, 1e6) - 1e5);
  CHECK(std::abs(static_cast<double>(z.p()[0] - p)) <= 1.2e-13);
  CHECK(std::abs(static_cast<double>(plain - q)) >= 1e-7);  // what an ordinary sum makes of it
}

TEST_CASE("The increments may be larger than the state", "[compensated]") {
  CompensatedUpdate<float, 1> update(1);
  PhasePoint<float, 1> z(1e-3F, 0.0F);
  double q = static_cast<double>(1e-3F);
  for (int n = 0; n < 10'000; ++n) {
    const float dq = n % 2 == 0 ? 7.7F : -7.6F;
    REQUIRE(update.update(z, [&](Eigen::Index i) { return i == 0 ? dq : 0.0F; }));
    q += static_cast<double>(dq);
  }
  CHECK(static_cast<double>(z.q()[0]) == Approx(q).epsilon(2e-7));
}

TEST_CASE("The carry belongs to the point that was updated", "[compensated]") {
  const double small = std::numeric_limits<double>::epsilon() / 4;  // adds nothing to 1 for itself
  const auto add_small = [&](Eigen::Index) { return small; };
  CompensatedUpdate<double, 1> update(1);
  PhasePoint<double, 1> z(1, 1);
  for (int n = 0; n < 3; ++n) REQUIRE(update.update(z, add_small));
  CHECK(z.q()[0] > 1);  // three quarters of the spacing, rounded up

  CompensatedUpdate<double, 1> dropped(1);
  PhasePoint<double, 1> first(1, 1), second(1, 2), third(1, 1);
  CHECK_FALSE(dropped.continues(second));
  REQUIRE(dropped.update(first, add_small));
  REQUIRE(dropped.update(first, add_small));
  CHECK(dropped.continues(first));
  CHECK_FALSE(dropped.continues(second));
  REQUIRE(dropped.update(second, add_small));  // another point: what was carried is gone
  CHECK(second.q()[0] == 1);
  CHECK_FALSE(dropped.continues(first));
  third.q()[0] = 1;
  REQUIRE(dropped.update(third, add_small));
  CHECK(third.q()[0] == 1);

  // A point that somebody moved is another point.
  PhasePoint<double, 1> moved(1, 1);
  CompensatedUpdate<double, 1> fresh(1);
  REQUIRE(fresh.update(moved, add_small));
  REQUIRE(fresh.update(moved, add_small));
  moved.p()[0] = 0;
  REQUIRE(fresh.update(moved, add_small));
  CHECK(moved.q()[0] == 1);
}

TEST_CASE("An update that is not finite moves nothing and drops the carry", "[compensated]") {
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e308})
    for (Eigen::Index where = 0; where < 4; ++where) {
      CAPTURE(bad, where);
      CompensatedUpdate<double, Eigen::Dynamic> update(2);
      PhasePoint<double, Eigen::Dynamic> z({1, 1e308}, {1e308, 1});
      z.vector().setConstant(1.7e308);
      const auto before = z.vector();
      CHECK_FALSE(update.update(z, [&](Eigen::Index i) { return i == where ? bad : -0.1; }));
      CHECK(z.vector() == before);
      CHECK_FALSE(update.continues(z));
      CHECK(update.update(z, [](Eigen::Index) { return -1e308; }));
      CHECK(update.continues(z));
    }
}

}  // namespace test_compensated_update
