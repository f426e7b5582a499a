#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// The observable along a run that is known to be better than those that are compared with it, at a few hundred times.
template <class Any>
class Reference {
 public:
  using Value = typename Problem<Any>::Value;

  /// Two runs of Gauss-Legendre with eight stages whose steps differ by a factor 1.5, over and over until they agree to `enough`
  /// at the time `length`, or a smaller step no longer makes them. `dt`: where to begin. False: the calls ended, or no step works.
  SEMIEXPLICIT_COLD bool make(Problem<Any>& problem, double dt, double length, double enough) {
    // A short stretch tells the step, for a fraction of the calls.
    for (const double part : {length / 10, length}) {
      times_ = sample_times(part);
      double last = 0;
      std::vector<Value> coarse;
      for (int attempt = 0; attempt < 24; ++attempt, dt /= 1.5) {
        Setting setting{.method = Setting::Method::gauss, .stages = 8, .dt = std::min(dt, part)};
        Probe probe;
        values_ = values_along(problem, setting, times_, probe);
        if (probe.cut) return false;
        if (values_.size() < times_.size()) {
          coarse.clear();
          continue;
        }
        if (coarse.size() == values_.size()) {
          const double unit = find_unit(problem);
          apart_.assign(times_.size(), 0);
          for (std::size_t i = 0; i < times_.size(); ++i)
            apart_[i] = static_cast<double>(norm(values_[i] - coarse[i])) / unit;
          const double now = *std::max_element(apart_.begin(), apart_.end());
          const bool rounded = last > 0 && now > 0.3 * last && now < 1e-6;
          if (now <= enough * part / length || rounded) break;
          last = now;
        }
        coarse = values_;
      }
      if (apart_.size() != times_.size()) return false;
      dt *= 1.5;  // the larger of the two that agreed
    }
    return true;
  }

  double length() const { return times_.back(); }
  /// How far the two runs are apart at worst: the error of the coarser one.
  double error() const { return *std::max_element(apart_.begin(), apart_.end()); }
  /// Whether the observable is constant as far as the reference knows: an invariant.
  SEMIEXPLICIT_COLD bool is_constant(const Problem<Any>& problem) const {
    double range = 0;
    for (const Value& value : values_)
      range = std::max(range, static_cast<double>(norm(value - values_.front())) / problem.table.unit);
    const double rounding =
        50 * static_cast<double>(Eigen::NumTraits<typename Any::Scalar>::epsilon()) * problem.judged.terms;
    return range <= std::max(10 * error(), rounding);
  }

  /// Runs a setting as far as `part` of the length; the largest errors in both halves go to the probe.
  SEMIEXPLICIT_COLD Probe compare(Problem<Any>& problem, const Setting& setting, double part) const {
    Probe probe;
    std::vector<double> times;
    for (const double t : times_)
      if (t <= part * length()) times.push_back(t);
    const auto values = values_along(problem, setting, times, probe);
    probe.length = times.back();
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double error = static_cast<double>(norm(values[i] - values_[i])) / problem.table.unit;
      double& half = times[i] < probe.length / 2 ? probe.early : probe.late;
      if (!(error <= half)) half = error;
    }
    if (!std::isfinite(probe.late)) probe.status = Status::not_finite;
    return probe;
  }

 private:
  /// Denser near the start, where shorter trials end; not in step with any period.
  static std::vector<double> sample_times(double length) {
    std::vector<double> times;
    constexpr int count = 96;
    for (int i = 1; i <= count; ++i) {
      const double x = (i - 0.3 * std::fmod(0.618034 * i, 1.0)) / count;
      times.push_back(i == count ? length : length * x * (0.4 + 0.6 * x));
    }
    return times;
  }

  /// Relative errors are so to the largest ‖f‖; where that grows with the time, to what it will be.
  SEMIEXPLICIT_COLD double find_unit(Problem<Any>& problem) const {
    if (problem.options.absolute) return 1;
    double half = 0, whole = 0;
    for (std::size_t i = 0; i < times_.size(); ++i) {
      const double size = static_cast<double>(norm(values_[i]));
      whole = std::max(whole, size);
      if (times_[i] < times_.back() / 2) half = std::max(half, size);
    }
    if (whole > 1.6 * half) whole *= std::max(1.0, problem.table.time / times_.back());
    problem.measure_in(whole > 0 ? whole : 1);
    problem.table.relative = whole > 0;
    return problem.table.unit;
  }

  std::vector<double> times_{}, apart_{};
  std::vector<Value> values_{};
};

}  // namespace semiexplicit::detail
