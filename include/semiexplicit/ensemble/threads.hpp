#pragma once

#include <cstdint>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>
#endif

namespace semiexplicit::detail {

/// How many threads are meant: the number given, or with 0 what OpenMP would take (OMP_NUM_THREADS, or one a core). One in
/// a program that is compiled without OpenMP.
inline int threads_meant([[maybe_unused]] int asked) {
#ifdef _OPENMP
  return asked > 0 ? asked : omp_get_max_threads();
#else
  return 1;
#endif
}

/// body(i) for i = 0 ... count - 1, by several threads where the program is compiled with OpenMP. An exception in one does
/// not keep the others from being done; the one of the smallest i is thrown again at the end, so that nothing depends on
/// the number of threads.
template <class Body>
void for_each_in_parallel(std::int64_t count, [[maybe_unused]] int threads, const Body& body) {
  std::exception_ptr first;
  std::int64_t first_at = count;
  std::mutex mutex;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic) num_threads(threads_meant(threads))
#endif
  for (std::int64_t i = 0; i < count; ++i) {
    try {
      body(i);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (i < first_at) {
        first = std::current_exception();
        first_at = i;
      }
    }
  }
  if (first) std::rethrow_exception(first);
}

}  // namespace semiexplicit::detail
