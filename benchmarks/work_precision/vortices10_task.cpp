#include "make_task.hpp"

namespace work_precision {

Task vortices_task(bool is_short) { return make_task(vortices_problem(), is_short); }
Task disparate_vortices_task(bool is_short) { return make_task(disparate_vortices_problem(), is_short); }

}  // namespace work_precision
