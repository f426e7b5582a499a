#include "make_task.hpp"

namespace work_precision {

Task nls5_task(bool is_short) { return make_task(nls5_problem(), is_short); }
Task nls5_long_task(bool is_short) { return make_long_task(nls5_problem(), 1e9, is_short); }

}  // namespace work_precision
