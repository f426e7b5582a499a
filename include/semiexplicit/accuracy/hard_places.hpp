#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// Where along a coarse run of the fourth order its energy varied most, and how much worse a longer run may
/// get.
template <class State>
class HardPlaces {
 public:
  /// A stretch of the coarse run: how far its energy ranged, relative to H(z0).
  struct Segment {
    State start;
    double hardness;
  };

  /// In the order of time.
  SEMIEXPLICIT_COLD void add(Segment segment) { segments_.push_back(std::move(segment)); }
  const std::vector<Segment>& all() const { return segments_; }

  /// The i-th hardest that is no neighbour of a harder one; there are count() of them.
  const State& hardest(std::size_t i) const { return segments_[hardest_[i]].start; }
  std::size_t count() const { return hardest_.size(); }

  /// To be called after the last add(): sorts by hardness, and fits the tail.
  SEMIEXPLICIT_COLD void rank() {
    std::vector<std::size_t> order(segments_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::sort(order.begin(), order.end(),
              [&](std::size_t a, std::size_t b) { return segments_[a].hardness > segments_[b].hardness; });
    std::vector<bool> taken(segments_.size() + 2, false);
    for (const std::size_t i : order) {
      if (taken[i] || taken[i + 2]) continue;
      taken[i + 1] = true;
      hardest_.push_back(i);
    }
    // The moment estimator of the tail's shape (Dekkers, Einmahl, de Haan, Ann. Statist. 17 (1989) 1833).
    tail_count_ = std::min<std::size_t>(hardest_.size() / 5, 50);
    if (tail_count_ < 4) {
      tail_count_ = 0;
      return;
    }
    const double threshold = segments_[hardest_[tail_count_]].hardness;
    if (!(threshold > 0)) {
      tail_count_ = 0;
      return;
    }
    for (std::size_t i = 0; i < tail_count_; ++i) {
      const double excess = std::log(segments_[hardest_[i]].hardness / threshold);
      tail_mean_ += excess / static_cast<double>(tail_count_);
      tail_square_ += excess * excess / static_cast<double>(tail_count_);
    }
    tail_top_ = std::log(segments_[hardest_[0]].hardness / threshold);
  }

  /// How much larger than in the hardest segment of the pilot run the error of a method of that order gets in
  /// a run `stretch` times as long. Errors go with the power `order` of the local time scale, those of the
  /// pilot with its fourth power.
  SEMIEXPLICIT_COLD double growth(int order, double stretch) const {
    if (tail_count_ == 0 || !(tail_square_ > 0)) return 1;
    const double power = order / 4.0, mean = power * tail_mean_;
    const double ratio = std::min(tail_mean_ * tail_mean_ / tail_square_, 0.95);
    // A bounded tail (shape below 0) cannot be told from a few dozen values: too much would hang on it.
    const double shape = std::max(mean + 1 - 0.5 / (1 - ratio), 0.0);
    const double expected = static_cast<double>(tail_count_) * std::max(1.0, stretch);
    const double reach = shape < 1e-6 ? std::log(expected) : (std::pow(expected, shape) - 1) / shape;
    const double largest = 1 + mean * reach;
    return std::clamp(largest / std::exp(power * tail_top_), 1.0, std::pow(dearest_growth, order));
  }

 private:
  static constexpr double dearest_growth =
      1.3;  ///< bound on what the extrapolation may add to the cost of a run

  std::vector<Segment> segments_{};
  std::vector<std::size_t> hardest_{};
  std::size_t tail_count_ = 0;  ///< of the hardest, which the tail's shape is taken from
  double tail_mean_ = 0, tail_square_ = 0, tail_top_ = 0;  ///< of the logarithm of their excess
};

}  // namespace semiexplicit::detail
