#include "../../examples/common/measurement.hpp"

#include "catch.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace test_largest {

// The largest value of curves that are known between the steps as well.

using examples::Largest;

namespace {

struct Curve {
  const char* name;
  std::function<double(double)> at;
};
const Curve curves[] = {
    {"a swing", [](double x) { return std::sin(x); }},
    {"two swings", [](double x) { return std::sin(x) + 0.8 * std::sin(0.37 * x + 1); }},
    {"a flyby", [](double x) { return -std::hypot(1.3, x); }},
    {"a peak", [](double x) { return 1 / (1 + x * x / 2); }},
};

}  // namespace

TEST_CASE("The largest value is within what steps leave open, at the ends of a run as well", "[examples]") {
  for (const Curve& curve : curves)
    for (int i = 0; i < 4000; ++i) {
      const int steps = 4 + i % 37;
      const double step = 0.02 + 0.5 * std::abs(std::sin(3.0 * i)), start = 7 * std::sin(5.0 * i);
      Largest largest;
      double exact = -INFINITY;
      for (int n = 0; n <= 100 * steps; ++n) {
        const double value = curve.at(start + step * n / 100);
        exact = std::max(exact, value);
        if (n % 100 == 0) largest.see(value);
      }
      CAPTURE(curve.name, steps, step, start);
      CHECK(std::abs(largest.value() - exact) <= largest.uncertain() + 1e-5);
    }
}

TEST_CASE("A few steps do not tell a largest value", "[examples]") {
  Largest largest;
  for (const double value : {1.0, 2.0, 1.5, 1.0}) {
    largest.see(value);
    CHECK(std::isinf(largest.uncertain()));
  }
  largest.see(0.5);
  CHECK(std::isfinite(largest.uncertain()));
}

TEST_CASE("A straight line has its largest value at its end", "[examples]") {
  Largest largest;
  for (int n = 0; n < 10; ++n) largest.see(n);
  CHECK(largest.value() == 9);
  CHECK(largest.uncertain() == 0);
}

}  // namespace test_largest
