#include "make_task.hpp"

namespace work_precision {

Task product_task(bool is_short) { return make_task(product_problem(), is_short); }

}  // namespace work_precision
