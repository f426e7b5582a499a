#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ostream>
#include <string>

#include <semiexplicit/checkpoint.hpp>

#include "table.hpp"

namespace examples {

/// Why nothing is measured of a motion that is sampled too coarsely; empty where it is not. `angle`: the largest from one step
/// to the next.
inline std::string too_coarse(double angle) {
  const double limit = std::acos(-1.0) / 4;
  if (angle < limit) return "";
  return formatted("it turns by up to %.0f degrees in a step; ", angle * 180 / std::acos(-1.0)) +
         formatted("give a --dt %.0f times smaller", std::ceil(angle / limit) + 1);
}

/// "what: not measured, why".
inline void print_none(std::ostream& out, const std::string& what, const std::string& why) {
  out << what << ": not measured, " << why << '\n';
}

/// Follows how a point turns about the origin of a plane.
class Turning {
 public:
  void see(double t, double x, double y) {
    const double angle = std::atan2(y, x);
    if (seen_ == 0) {
      start_ = t;
    } else {
      const double turn = std::remainder(angle - last_, 2 * std::acos(-1.0));
      turned_ += turn;
      largest_ = std::max(largest_, std::abs(turn));
    }
    last_ = angle;
    now_ = t;
    radii_ += std::hypot(x, y);
    ++seen_;
  }
  double turned() const { return turned_; }
  /// The largest turn from one step to the next.
  double largest() const { return largest_; }
  /// Radians a unit of time, counterclockwise.
  double rate() const { return turned_ / (now_ - start_); }
  double mean_radius() const { return radii_ / static_cast<double>(seen_); }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    for (double* number : {&start_, &now_, &last_, &turned_, &radii_, &largest_}) visit(*number);
  }

 private:
  std::int64_t seen_ = 0;
  double start_ = 0, now_ = 0, last_ = 0, turned_ = 0, radii_ = 0, largest_ = 0;
};

/// Follows a coordinate that goes up and down: how long that takes, and how far it gets.
class Bouncing {
 public:
  void see(double t, double z) {
    ++samples_;
    if (seen_ && last_ < 0 && z >= 0) {
      const double at = last_t_ - last_ * (t - last_t_) / (z - last_);
      if (passages_++ == 0)
        first_ = at;
      else
        fewest_ = std::min(fewest_, samples_);
      latest_ = at;
      samples_ = 0;
    }
    seen_ = true;
    last_ = z;
    last_t_ = t;
    highest_ = std::max(highest_, std::abs(z));
  }
  /// Why there is no figure; empty where there is one.
  std::string missing() const {
    if (passages_ < 2) return "the run has no whole bounce; give more --time";
    if (fewest_ < 16) return "a bounce has " + std::to_string(fewest_) + " steps; give a smaller --dt";
    return "";
  }
  double period() const { return (latest_ - first_) / static_cast<double>(passages_ - 1); }
  double highest() const { return highest_; }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    visit(passages_);
    visit(samples_);
    visit(fewest_);
    for (double* number : {&last_, &last_t_, &first_, &latest_, &highest_}) visit(*number);
  }

 private:
  bool seen_ = false;
  double last_ = 0, last_t_ = 0, first_ = 0, latest_ = 0, highest_ = 0;
  std::int64_t passages_ = 0, samples_ = 0, fewest_ = std::int64_t{1} << 62;
};

/// A line "what: measured; reference: expected (difference)".
inline void print_comparison(std::ostream& out, const std::string& what, double measured,
                             const std::string& reference, double expected) {
  out << what << ": " << formatted("%.8g", measured) << "; " << reference << ": "
      << formatted("%.8g (relative difference %.1e)\n", expected, std::abs(measured / expected - 1));
}

/// The same without a reference.
inline void print_figure(std::ostream& out, const std::string& what, double measured,
                         const std::string& why) {
  out << what << ": " << formatted("%.8g", measured) << "; no closed form, " << why << '\n';
}

}  // namespace examples
