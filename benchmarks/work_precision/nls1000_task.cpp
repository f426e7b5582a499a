#include "make_task.hpp"

namespace work_precision {

Task nls1000_task(bool is_short) { return make_task(nls1000_problem(is_short), is_short); }
Task nls1000_long_task(bool is_short) { return make_long_task(nls1000_problem(is_short), 2e7, is_short); }

}  // namespace work_precision
