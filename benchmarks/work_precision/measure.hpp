#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <functional>
#include <limits>
#include <string>
#include <vector>

namespace work_precision {

inline constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// CPU time of this thread: what others do on the machine does not count, apart from the caches they share.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

inline double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size();
  return n == 0 ? nan : (values[(n - 1) / 2] + values[n / 2]) / 2;
}

/// What a run is judged by. A state is 2d numbers, positions first.
struct Yardstick {
  struct Invariant {
    std::string name;
    std::function<double(const double*)> value;
  };
  double end = 0;  ///< of the time
  std::vector<double> start;
  std::function<double(const double*)> energy;
  std::vector<Invariant> invariants;  ///< besides the energy
  std::vector<double> last;           ///< the state at the end; empty where nobody knows it
  double last_unknown = 0;            ///< what that may be off by, relative to the size of the start
};

/// Distance of two states, relative to the size of the start.
inline double distance(const double* a, const double* b, const std::vector<double>& start) {
  double apart = 0, size = 0;
  for (std::size_t i = 0; i < start.size(); ++i) {
    apart += (a[i] - b[i]) * (a[i] - b[i]);
    size += start[i] * start[i];
  }
  return std::sqrt(apart / size);
}

/// Largest relative errors of a run, as far as it came.
struct Errors {
  double energy = 0;
  double first_half = 0, second_half = 0;  ///< of the energy
  std::vector<double> invariants;
  double trajectory = nan;  ///< at the end, and what the reference may be off by; NaN: there is none

  /// Of the other invariants; NaN: there are none.
  double worst_invariant() const {
    return invariants.empty() ? nan : *std::max_element(invariants.begin(), invariants.end());
  }
  /// An error that grows steadily is twice as large in the second half.
  double growth() const { return second_half / first_half; }
  bool drifts() const { return growth() > 1.5; }
};

/// How a run went.
struct Outcome {
  std::string status = "ok";  ///< or why it ended early
  double t = 0;
  std::int64_t steps = 0, gradients = 0;
  double seconds = 0;

  bool ok() const { return status == "ok"; }
};

/// Looks at a run at equidistant times, or at the first step's end after each of them.
class Watch {
 public:
  /// A run of four times as many gradient calls as `most_calls` is given up.
  Watch(const Yardstick& yardstick, int samples, double most_calls)
      : yardstick_(yardstick),
        most_gradients_(4 * most_calls),
        interval_(yardstick.end / samples),
        energy_(yardstick.energy(yardstick.start.data())) {
    for (const auto& invariant : yardstick.invariants)
      invariants_.push_back(invariant.value(yardstick.start.data()));
    errors_.invariants.assign(invariants_.size(), 0.0);
    marks_.push_back(cpu_seconds());
  }

  bool due(double t) const { return t >= (static_cast<double>(seen_) + 1) * interval_ * (1 - 1e-9); }

  /// False: the energy is lost, and the rest of the run would say nothing.
  bool see(double t, const double* z) {
    seen_ = static_cast<std::int64_t>(t / interval_ * (1 + 1e-9));
    if (t >= static_cast<double>(marks_.size()) / parts * yardstick_.end * (1 - 1e-9))
      marks_.push_back(cpu_seconds());
    const double energy = relative(yardstick_.energy(z), energy_);
    errors_.energy = larger(errors_.energy, energy);
    double& half = 2 * t <= yardstick_.end ? errors_.first_half : errors_.second_half;
    half = larger(half, energy);
    for (std::size_t i = 0; i < invariants_.size(); ++i)
      errors_.invariants[i] =
          larger(errors_.invariants[i], relative(yardstick_.invariants[i].value(z), invariants_[i]));
    if (!yardstick_.last.empty() && t >= yardstick_.end * (1 - 1e-12))
      errors_.trajectory = distance(z, yardstick_.last.data(), yardstick_.start) + yardstick_.last_unknown;
    return energy <= 1;
  }

  /// Whether the run has taken more calls than anybody wants to wait for.
  bool is_late(std::int64_t gradients) const { return static_cast<double>(gradients) > most_gradients_; }

  const Errors& errors() const { return errors_; }

  /// CPU time of a long run that need not be run five times: five times the median of its fifths.
  double seconds_by_parts() const {
    std::vector<double> lengths;
    for (std::size_t i = 1; i < marks_.size(); ++i) lengths.push_back(marks_[i] - marks_[i - 1]);
    return parts * median(lengths);
  }

 private:
  static constexpr int parts = 5;

  static double relative(double value, double first) {
    return std::abs(value - first) / (first == 0 ? 1 : std::abs(first));
  }
  /// NaN wins: an error that is not a number must not get lost.
  static double larger(double a, double b) { return a >= b ? a : (std::isnan(a) ? a : b); }

  const Yardstick& yardstick_;
  double most_gradients_;
  double interval_;
  std::int64_t seen_ = 0;
  double energy_;
  std::vector<double> invariants_, marks_;
  Errors errors_;
};

}  // namespace work_precision
