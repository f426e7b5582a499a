#include "catch.hpp"

#include <cmath>
#include <limits>

#include <semiexplicit/solvers/stopping.hpp>

namespace test_stopping {

namespace {
using namespace semiexplicit;
const double not_a_number = std::numeric_limits<double>::quiet_NaN();
const double infinite = std::numeric_limits<double>::infinity();
}  // namespace

TEST_CASE("The paper's rule is a bound on the correction, absolute", "[stopping]") {
  const auto rule = StoppingRule::paper(1e-10);
  CHECK(rule.kind == StoppingRule::Kind::paper);
  CHECK(rule.accepts(0.9e-10, 1.0, 1e-5));
  CHECK(rule.accepts(0.0, 0.0, 0.0));
  CHECK_FALSE(rule.accepts(1e-10, 0.0, 1e10));
  CHECK_FALSE(rule.accepts(1.1e-10, 0.0, 1e10));
}

TEST_CASE("The product rule bounds e (|m| + e) by the square of the state", "[stopping]") {
  const auto rule = StoppingRule::product(1e-16);
  CHECK(StoppingRule{}.kind == StoppingRule::Kind::product);
  CHECK(StoppingRule{}.tolerance == 1e-16);
  CHECK(rule.accepts(0.99e-8, 0.0, 1.0));  // without m the square of e alone
  CHECK_FALSE(rule.accepts(1.01e-8, 0.0, 1.0));
  CHECK(rule.accepts(0.99e-12, 1e-4, 1.0));
  CHECK_FALSE(rule.accepts(1.01e-12, 1e-4, 1.0));
  CHECK(rule.accepts(0.99e-12 * 60, 1e-4 * 60, 60.0));
  CHECK_FALSE(rule.accepts(1.01e-12 * 60, 1e-4 * 60, 60.0));
}

TEST_CASE("The product rule scales with the state, however small or large", "[stopping]") {
  const auto rule = StoppingRule::product(1e-16);
  for (const double size : {1e-300, 1e-250, 1e-150, 1.0, 1e150, 1e250, 1e300}) {
    CAPTURE(size);
    CHECK(rule.accepts(0.9e-12 * size, 1e-4 * size, size));
    CHECK_FALSE(rule.accepts(1.1e-12 * size, 1e-4 * size, size));
    CHECK_FALSE(rule.accepts(1e-3 * size, 1e-3 * size, size));
  }
}

TEST_CASE("For a state of zero only an exact solution will do", "[stopping]") {
  const auto rule = StoppingRule::product(1e-16);
  CHECK(rule.accepts(0.0, 0.0, 0.0));
  CHECK(rule.accepts(0.0, 1.0, 0.0));
  CHECK_FALSE(rule.accepts(1e-300, 0.0, 0.0));
}

TEST_CASE("NaN is never accepted", "[stopping]") {
  for (const auto& rule : {StoppingRule::paper(1e-10), StoppingRule::product(), StoppingRule::paper(infinite),
                           StoppingRule::product(infinite)}) {
    CHECK_FALSE(rule.accepts(not_a_number, 0.0, 1.0));
    CHECK_FALSE(rule.accepts(not_a_number, not_a_number, not_a_number));
  }
  CHECK_FALSE(StoppingRule::product().accepts(1e-20, not_a_number, 1.0));
  CHECK_FALSE(StoppingRule::product().accepts(1e-20, 1.0, not_a_number));
  CHECK_FALSE(StoppingRule::product().accepts(infinite, 1.0, 1.0));
  CHECK_FALSE(StoppingRule::paper(1e-10).accepts(infinite, 1.0, 1.0));
  CHECK_FALSE(StoppingRule::paper(not_a_number).accepts(1e-20, 0.0, 1.0));
  CHECK_FALSE(StoppingRule::product(not_a_number).accepts(1e-20, 1.0, 1.0));
}

TEST_CASE("The rules work in any floating-point type", "[stopping]") {
  CHECK(StoppingRule::paper(1e-5).accepts(0.9e-5F, 0.0F, 1.0F));
  CHECK_FALSE(StoppingRule::paper(1e-5).accepts(1.1e-5F, 0.0F, 1.0F));
  CHECK(StoppingRule::product().accepts(0.9e-8L, 0.0L, 1.0L));
  CHECK_FALSE(StoppingRule::product().accepts(1.1e-8L, 0.0L, 1.0L));
}

}  // namespace test_stopping
