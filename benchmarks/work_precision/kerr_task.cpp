#include "make_task.hpp"

namespace work_precision {

Task kerr_task(bool is_short) { return make_task(kerr_problem(), is_short); }

}  // namespace work_precision
