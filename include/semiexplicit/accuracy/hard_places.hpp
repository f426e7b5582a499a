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

  /// In the order of time. Of many, the harder one of every two, four ... is kept.
  SEMIEXPLICIT_COLD void add(Segment segment) {
    if (filled_ == 0)
      segments_.push_back(std::move(segment));
    else if (segment.hardness > segments_.back().hardness)
      segments_.back() = std::move(segment);
    if (++filled_ < together_) return;
    filled_ = 0;
    if (segments_.size() < most_segments) return;
    for (std::size_t i = 0; i < most_segments / 2; ++i) {
      const bool second = segments_[2 * i + 1].hardness > segments_[2 * i].hardness;
      segments_[i] = std::move(segments_[2 * i + (second ? 1 : 0)]);
    }
    segments_.resize(most_segments / 2);
    together_ *= 2;
  }
  const std::vector<Segment>& all() const { return segments_; }

  /// Whether the motion gets harder along the run: some later part of it has stretches, more than a few, that
  /// are twice as hard as any before. What comes back was as hard before.
  SEMIEXPLICIT_COLD bool rises() const { return rises(in_groups()); }
  /// Whether it gets harder or easier so.
  SEMIEXPLICIT_COLD bool changes() const {
    std::vector<double> groups = in_groups();
    if (rises(groups)) return true;
    std::reverse(groups.begin(), groups.end());
    return rises(groups);
  }
  /// How much harder the hardest segment behind a part of the run is than those before.
  SEMIEXPLICIT_COLD double harder_behind(double part) const {
    double before = 1e-300, behind = 0;
    for (std::size_t i = 0; i < segments_.size(); ++i) {
      const bool is_before = static_cast<double>(i + 1) <= part * static_cast<double>(segments_.size());
      double& side = is_before || i == 0 ? before : behind;
      side = std::max(side, segments_[i].hardness);
    }
    return behind / before;
  }
  /// Whether it will have become twice as hard in a run `stretch` times as long, where it goes on as it does:
  /// the medians of thirds rise.
  SEMIEXPLICIT_COLD bool will_rise(double stretch) const {
    const std::vector<double> groups = in_groups();
    const std::size_t n = groups.size() / 3;
    if (n < 3) return false;  // too little was seen
    double median[3], uncertainty = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto begin = groups.begin() + static_cast<std::ptrdiff_t>(k * n);
      std::vector<double> third(begin, begin + static_cast<std::ptrdiff_t>(n));
      std::sort(third.begin(), third.end());
      if (!(third[n / 4] > 0)) return rises(groups);
      median[k] = std::log(third[n / 2]);
      uncertainty += std::log(third[3 * n / 4] / third[n / 4]) / std::sqrt(static_cast<double>(n));
    }
    const double rise = median[2] - median[0];
    return rises(groups) || (median[1] > median[0] && median[2] > median[1] && rise > uncertainty &&
                             rise * 1.5 * stretch > std::log(2.0));
  }

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
  /// The hardest of every so many segments, in 30 to 60 groups: the phase of a period is no trend.
  SEMIEXPLICIT_COLD std::vector<double> in_groups() const {
    const std::size_t size = std::max<std::size_t>(1, (segments_.size() + 59) / 60);
    std::vector<double> groups((segments_.size() + size - 1) / size, 0.0);
    for (std::size_t i = 0; i < segments_.size(); ++i)
      groups[i / size] = std::max(groups[i / size], segments_[i].hardness);
    return groups;
  }
  SEMIEXPLICIT_COLD static bool rises(const std::vector<double>& groups) {
    for (const double part : {1 / 3.0, 1 / 2.0, 2 / 3.0, 5 / 6.0}) {
      const auto later = groups.begin() + static_cast<std::ptrdiff_t>(part * double(groups.size()));
      if (later == groups.begin()) continue;
      const double before = *std::max_element(groups.begin(), later);
      if (std::count_if(later, groups.end(), [&](double x) { return x > 2 * before; }) > 2) return true;
    }
    return false;
  }

  static constexpr std::size_t most_segments = 4096;
  static constexpr double dearest_growth =
      1.3;  ///< bound on what the extrapolation may add to the cost of a run

  std::vector<Segment> segments_{};
  std::size_t together_ = 1, filled_ = 0;  ///< stretches that an entry is the hardest of; in the last one
  std::vector<std::size_t> hardest_{};
  std::size_t tail_count_ = 0;  ///< of the hardest, which the tail's shape is taken from
  double tail_mean_ = 0, tail_square_ = 0, tail_top_ = 0;  ///< of the logarithm of their excess
};

}  // namespace semiexplicit::detail
