#include "make_task.hpp"

namespace work_precision {

Task nls5_task(bool is_short) { return make_task(nls5_problem(), is_short); }

/// The same a hundred times as long: what drifts is seen to drift.
Task nls5_long_task(bool is_short) {
  auto problem = nls5_problem();
  problem.name += "_long";
  problem.title += ", long";
  problem.end *= 100;
  problem.short_end *= 10;
  problem.max_seconds = 10;
  return make_task(problem, is_short);
}

}  // namespace work_precision
