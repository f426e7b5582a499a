#include "catch.hpp"

#include <set>
#include <string>

#include <semiexplicit/core/report.hpp>

#include "refusal.hpp"

namespace test_report {

namespace {
using namespace semiexplicit;
}  // namespace

TEST_CASE("Every status has words of its own, and failures a remedy", "[report]") {
  const Status all[] = {Status::success,    Status::rounding_limited, Status::no_convergence,
                        Status::not_finite, Status::invalid_state,    Status::invalid_step,
                        Status::stopped};
  std::set<std::string> texts;
  for (const Status status : all) texts.insert(describe(status));
  CHECK(texts.size() == 7);
  CHECK(texts.count("unknown status") == 0);
  CHECK(says(describe(Status::no_convergence), "reduce dt"));
  CHECK(says(describe(Status::not_finite), "NaN or Inf"));
  CHECK(says(describe(Status::invalid_step), "finite step"));
  CHECK(says(describe(Status::invalid_state), "check the initial data"));
  CHECK(describe(static_cast<Status>(99)) == "unknown status");
}

TEST_CASE("ok() says whether the state moved, or the run came to its end", "[report]") {
  for (const Status status :
       {Status::no_convergence, Status::not_finite, Status::invalid_state, Status::invalid_step}) {
    CHECK_FALSE(StepReport{.status = status}.ok());
    CHECK_FALSE(IntegrationReport{.status = status}.ok());
  }
  CHECK(StepReport{}.ok());
  CHECK(StepReport{.status = Status::rounding_limited}.ok());
  CHECK(IntegrationReport{}.ok());
  CHECK(IntegrationReport{.status = Status::stopped}.ok());
}

TEST_CASE("The error of a run tells time, step and what the solver saw", "[report]") {
  IntegrationReport report{.status = Status::no_convergence, .t = 12.25, .steps = 49};
  report.last = {.status = Status::no_convergence, .evaluations = 100, .correction = 1.25e-3, .rate = 1.5};
  const std::string text = IntegrationError(report, 0.25).what();
  CHECK(says(text, "step 50 failed at t = 12.25 (dt = 0.25)"));
  CHECK(says(text, describe(Status::no_convergence)));
  CHECK(says(text, "last correction 0.00125 after 100 evaluations"));
  CHECK(says(text, "factor 1.5"));
  CHECK(IntegrationError(report, 0.25).report().steps == 49);

  const std::string other = IntegrationError({.status = Status::invalid_step}, 0).what();
  CHECK(says(other, "step 1 failed at t = 0 (dt = 0)"));
  CHECK_FALSE(says(other, "correction"));
}

}  // namespace test_report
