#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <string>

#include "table.hpp"

namespace examples {

/// Follows how a point turns about the origin of a plane. It has to be seen more than twice a turn.
class Turning {
 public:
  void see(double t, double x, double y) {
    const double angle = std::atan2(y, x);
    if (seen_ == 0)
      start_ = t;
    else
      turned_ += std::remainder(angle - last_, 2 * std::acos(-1.0));
    last_ = angle;
    now_ = t;
    radii_ += std::hypot(x, y);
    ++seen_;
  }
  double turned() const { return turned_; }
  /// Radians a unit of time, counterclockwise.
  double rate() const { return turned_ / (now_ - start_); }
  double mean_radius() const { return radii_ / static_cast<double>(seen_); }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    for (double* number : {&start_, &now_, &last_, &turned_, &radii_}) visit(*number);
  }

 private:
  std::int64_t seen_ = 0;
  double start_ = 0, now_ = 0, last_ = 0, turned_ = 0, radii_ = 0;
};

/// Follows a coordinate that goes up and down: how long that takes, and how far it gets.
class Bouncing {
 public:
  void see(double t, double z) {
    if (seen_ && last_ < 0 && z >= 0) {
      const double at = last_t_ - last_ * (t - last_t_) / (z - last_);
      if (passages_++ == 0) first_ = at;
      latest_ = at;
    }
    seen_ = true;
    last_ = z;
    last_t_ = t;
    highest_ = std::max(highest_, std::abs(z));
  }
  /// Upward passages through zero, less one.
  int bounces() const { return std::max(passages_ - 1, 0); }
  /// NaN where there is no whole bounce.
  double period() const { return (latest_ - first_) / bounces(); }
  double highest() const { return highest_; }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    visit(passages_);
    for (double* number : {&last_, &last_t_, &first_, &latest_, &highest_}) visit(*number);
  }

 private:
  bool seen_ = false;
  double last_ = 0, last_t_ = 0, first_ = 0, latest_ = 0, highest_ = 0;
  int passages_ = 0;
};

/// A line "what: measured; reference: expected (difference)".
inline void print_comparison(std::ostream& out, const std::string& what, double measured,
                             const std::string& reference, double expected) {
  out << what << ": " << formatted("%.8g", measured) << "; " << reference << ": "
      << formatted("%.8g (relative difference %.1e)\n", expected, std::abs(measured / expected - 1));
}

}  // namespace examples
