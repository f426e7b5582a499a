#include "../../examples/ensemble_mpi/sweep.hpp"

#include "catch.hpp"

#include <cstddef>
#include <vector>

namespace test_sweep {

// The rows of the program ensemble_mpi.

using namespace examples;

TEST_CASE("evaluations a step are those of the steps that were tried", "[examples]") {
  const Sweep sweep{.members = 2, .dt = 10, .time = 1000, .extent = 0.1};
  const std::vector<double> rows = sweep.run(0, 2, 1);
  for (std::size_t member = 0; member < 2; ++member) {
    const double* const row = rows.data() + member * Sweep::columns().size();
    REQUIRE(row[5] != static_cast<double>(Status::success));  // in one of the first steps of a hundred
    CHECK(row[4] >= 3);
  }
}

}  // namespace test_sweep
