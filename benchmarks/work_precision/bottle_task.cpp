#include "make_task.hpp"

namespace work_precision {

Task bottle_task(bool is_short) { return make_task(bottle_problem(), is_short); }

}  // namespace work_precision
