#include "../../examples/chaos/series.hpp"

#include "catch.hpp"

#include <cmath>
#include <string>
#include <vector>

#include "refusal.hpp"

namespace test_exponent_series {

// The mean over realizations of what the program chaos measures.

using namespace examples;

TEST_CASE("the mean of logarithms leaves out what has none, and says so", "[examples]") {
  Series series;
  series.add({1, 10, 100}, {-1, 0.1, 0.01});
  series.add({1, 10, 100}, {-2, -0.3, 0.0001});
  CHECK(std::isnan(series.exponent(0)));
  CHECK(series.exponent(1) == Approx(0.1));
  CHECK(series.end() == Approx(0.001));
  CHECK(std::isnan(series.slope()));  // of half of them it is another one
  CHECK(series.in_words(-0.3) ==
        "exponent 0.001 at t = 100; slope over the last two decades not measured, too few of the exponents "
        "there are positive, published -0.30; 3 of 6 exponents there are not positive and left out");
  Series many;
  for (int k = 0; k < 10; ++k) many.add({1, 10, 100}, {1, 0.1, 0.01});
  many.add({1, 10, 100}, {-1, -0.1, -0.01});
  CHECK(many.slope() == Approx(-1));
  CHECK(says(many.in_words(-0.3),
             "slope -1.000 over the last two decades, published -0.30; 3 of 33 exponents"));
}

TEST_CASE("an exponent and a slope that cannot be measured are said to be missing", "[examples]") {
  Series falling, one, good;
  falling.add({1, 10}, {0.1, -0.1});
  CHECK(says(
      falling.in_words(-0.3),
      "exponent at t = 10 not measured, none is positive; slope over 1.0 decades not measured, too few"));
  one.add({5}, {0.2});
  CHECK(one.in_words(-0.3) ==
        "exponent 0.2 at t = 5; slope not measured, it needs a second point; give more --time");
  good.add({1, 10, 1e3, 1e4}, {-1, 3, 0.1, 0.01});  // the first two are no part of the last two decades
  CHECK(good.in_words(-0.3) ==
        "exponent 0.01 at t = 10000; slope -1.000 over the last two decades, published -0.30");
}

TEST_CASE("a slope over fewer than two decades is compared with nothing", "[examples]") {
  Series shorter, two;
  shorter.add({0.15, 0.5, 3}, {20, 6, 1});
  CHECK(says(shorter.in_words(-0.3), " over 1.3 decades, the published -0.30 is for two; give more --time"));
  CHECK_FALSE(shorter.is_long());
  two.add({0.3, 3, 30}, {10, 1, 0.1});
  CHECK(two.in_words(-0.3) ==
        "exponent 0.1 at t = 30; slope -1.000 over the last two decades, published -0.30");
}

}  // namespace test_exponent_series
