#pragma once

#include <cstdint>
#include <ctime>
#include <map>
#include <string>

#include <semiexplicit/accuracy/candidates.hpp>

namespace semiexplicit::detail {

/// Processor time of this thread, in seconds.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Measures what a gradient call of a method takes, its share of the step included, once for each.
template <class Any>
class CallTimer {
 public:
  explicit CallTimer(Problem<Any>& problem) : problem_(problem) {}

  /// In seconds, from about `enough` calls; 0 where no step of the candidate has worked.
  SEMIEXPLICIT_COLD double seconds_per_call(const Candidate& candidate, double enough) {
    double& known = known_[candidate.setting.name()];
    if (known > 0) return known;
    double dt = candidate.trials.empty() ? problem_.table.time_scale / 10 : 0;
    for (const auto& [step, seen] : candidate.trials)
      if (seen.works()) dt = step;
    if (dt == 0) return 0;
    Walker<Any> walker(problem_, candidate.with_step(dt));
    auto z = problem_.z0;
    Probe probe;
    double t = 0;
    const double& spent = problem_.table.spent_gradients;
    double from = spent, begin = cpu_seconds();
    for (std::int64_t n = 0; spent - from < enough || n < 20; ++n) {
      if (n == 10) from = spent, begin = cpu_seconds();  // warm now
      if (t < problem_.table.time && walker.step_on(z, t, dt, probe)) continue;
      if (probe.cut || n == 0) break;
      if (candidate.setting.reversible) break;
      z = problem_.z0, t = 0;  // it ran into something, or to the end: time the first steps again
    }
    const double calls = spent - from;
    known = calls > 0 ? (cpu_seconds() - begin) / calls : 0;
    return known;
  }

 private:
  Problem<Any>& problem_;
  std::map<std::string, double> known_{};
};

}  // namespace semiexplicit::detail
