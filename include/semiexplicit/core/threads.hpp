#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>
#include <mutex>

#ifdef _OPENMP
#include <omp.h>
#endif

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>

namespace semiexplicit::detail {

/// How many threads are meant: the number given, or with 0 what OpenMP would take (OMP_NUM_THREADS, or one a
/// core), no more than there are tasks, nor than OpenMP may be trusted to start: it ends the program where it
/// cannot. One in a program that is compiled without OpenMP.
inline int threads_meant([[maybe_unused]] int asked, [[maybe_unused]] std::int64_t tasks) {
#ifdef _OPENMP
  constexpr std::int64_t most = 1024;
  const int meant = asked > 0 ? asked : omp_get_max_threads();
  return static_cast<int>(std::clamp<std::int64_t>(tasks, 1, std::min<std::int64_t>(meant, most)));
#else
  return 1;
#endif
}

/// body(i) for i = 0 ... count - 1, by several threads where the program is compiled with OpenMP. An
/// exception in one does not keep the others from being done; the one of the smallest i is thrown again at
/// the end, so that nothing depends on the number of threads.
template <class Body>
void for_each_in_parallel(std::int64_t count, [[maybe_unused]] int threads, const Body& body) {
  std::exception_ptr first;
  std::int64_t first_at = count;
  std::mutex mutex;
#ifdef _OPENMP
#pragma omp parallel for schedule(dynamic, 1) num_threads(threads_meant(threads, count))
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

/// How many threads may work on one large system: one in a program without OpenMP, and within threads, as of
/// an ensemble.
inline int threads_for_one() {
#ifdef _OPENMP
  return omp_get_level() > 0 ? 1 : omp_get_max_threads();
#else
  return 1;
#endif
}

}  // namespace semiexplicit::detail

namespace semiexplicit {

namespace detail {

/// in_parts() where there are many blocks. Not inlined: what small systems run is what it would be without
/// threads.
template <class F>
SEMIEXPLICIT_NOINLINE void in_threads(Eigen::Index n, Eigen::Index block, const F& f) {
  const Eigen::Index blocks = (n + block - 1) / block,
                     parts = std::min<Eigen::Index>(threads_for_one(), blocks);
  if (parts < 2) return f(Eigen::Index(0), n);
  for_each_in_parallel(parts, static_cast<int>(parts), [&](Eigen::Index part) {
    f(blocks * part / parts * block, std::min(n, blocks * (part + 1) / parts * block));
  });
}

}  // namespace detail

/// Calls f(begin, end) for parts of 0 to n - 1, one a thread, that begin at multiples of `block`: for a
/// gradient of a large system, say. Where the program is compiled without OpenMP, or this is within threads
/// already, and where n is below `least`, it is f(0, n). What is computed in whole blocks has the same bits
/// by any number of threads then, provided that a block needs no other one's results. An exception is thrown
/// again at the end. No heap use of its own.
template <class F>
void in_parts(Eigen::Index n, [[maybe_unused]] Eigen::Index block, [[maybe_unused]] Eigen::Index least,
              const F& f) {
#ifdef _OPENMP
  if (n >= least) return detail::in_threads(n, block, f);
#endif
  f(Eigen::Index(0), n);
}

namespace detail {

/// In vectors longer than this threads work on plain loops. (Measured: below it starting them takes longer
/// than the loop.)
inline constexpr Eigen::Index long_loop = Eigen::Index{1} << 16;

/// Calls f(i) for every i < n, by threads where these are many.
template <class F>
void for_many(Eigen::Index n, const F& f) {
  in_parts(n, 64, long_loop, [&](Eigen::Index begin, Eigen::Index end) {
    for (Eigen::Index i = begin; i < end; ++i) f(i);
  });
}

/// Whether f(begin, end) holds for one of the parts.
template <class F>
bool any_of_many(Eigen::Index n, const F& f) {
  std::atomic<bool> any = false;
  in_parts(n, 64, long_loop, [&](Eigen::Index begin, Eigen::Index end) {
    if (f(begin, end)) any = true;
  });
  return any;
}

}  // namespace detail
}  // namespace semiexplicit
