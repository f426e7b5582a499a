#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "../common/line_fit.hpp"
#include "../common/output.hpp"

namespace examples {

/// The mean of log10 Λ over realizations, at each time. An exponent that is not positive, as early ones may
/// be, has no logarithm, and is left out.
class Series {
 public:
  std::vector<double> t{};

  /// One realization; the times are those of all.
  void add(const std::vector<double>& times, const std::vector<double>& exponents) {
    t = times;
    logarithms_.resize(t.size());
    positive_.resize(t.size());
    ++realizations_;
    for (std::size_t i = 0; i < t.size(); ++i)
      if (exponents[i] > 0) logarithms_[i] += std::log10(exponents[i]), ++positive_[i];
  }

  std::int64_t realizations() const { return realizations_; }

  /// At t[i], or at the last t; NaN where none is positive.
  double exponent(std::size_t i) const { return std::pow(10.0, mean(i)); }
  double end() const { return exponent(t.size() - 1); }

  /// How many decades of time there are, of which the slope is over the last two.
  double decades() const { return std::log10(t.back() / t.front()); }
  /// Only a slope over two of them is to be compared with the published one.
  bool is_long() const { return decades() > 2 - 1e-9; }

  /// By least squares over the last two decades, or all where these are fewer; NaN where they have fewer than
  /// two points, or a tenth of the exponents has no logarithm: the others alone would tell another slope.
  double slope() const {
    LineFit line;
    for (std::size_t i = 0; i < t.size(); ++i)
      if (late(i) && positive_[i] > 0) line.add(std::log10(t[i]), mean(i));
    return line.count < 2 || 10 * left_out() > late_ones() ? std::nan("") : line.slope();
  }

  /// The exponent at the end and the slope beside the published one, or why there is none, and what they
  /// leave out.
  std::string in_words(double published) const {
    const double at_end = end(), rate = slope();
    std::string text = std::isnan(at_end)
                           ? formatted("exponent at t = %g not measured, none is positive", t.back())
                           : formatted("exponent %.3g at t = %g", at_end, t.back());
    const std::string over =
        is_long() ? " over the last two decades" : formatted(" over %.1f decades", decades());
    if (late_ones() < 2 * realizations_)
      text += "; slope not measured, it needs a second point; give more --time";
    else
      text += std::isnan(rate)
                  ? "; slope" + over + " not measured, too few of the exponents there are positive"
                  : formatted("; slope %.3f", rate) + over;
    text += is_long()          ? formatted(", published %.2f", published)
            : std::isnan(rate) ? ""
                               : formatted(", the published %.2f is for two; give more --time", published);
    if (left_out() > 0)
      text += "; " + std::to_string(left_out()) + " of " + std::to_string(late_ones()) +
              " exponents there are not positive and left out";
    return text;
  }

 private:
  bool late(std::size_t i) const { return t[i] >= t.back() / 100; }
  std::int64_t late_ones() const {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < t.size(); ++i) count += late(i) ? realizations_ : 0;
    return count;
  }
  /// How many of these are not positive.
  std::int64_t left_out() const {
    std::int64_t count = 0;
    for (std::size_t i = 0; i < t.size(); ++i) count += late(i) ? realizations_ - positive_[i] : 0;
    return count;
  }
  double mean(std::size_t i) const {
    return positive_[i] == 0 ? std::nan("") : logarithms_[i] / static_cast<double>(positive_[i]);
  }

  std::vector<double> logarithms_{};      ///< sums of those that are
  std::vector<std::int64_t> positive_{};  ///< how many these are
  std::int64_t realizations_ = 0;
};

}  // namespace examples
