#include "make_task.hpp"

namespace work_precision {

Task vortices300_task(bool is_short) { return make_task(vortices300_problem(is_short), is_short); }
Task vortices300_long_task(bool is_short) {
  return make_long_task(vortices300_problem(is_short), 5e5, is_short);
}

}  // namespace work_precision
