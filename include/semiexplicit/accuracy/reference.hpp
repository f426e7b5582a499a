#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <vector>

#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// Gauss-Legendre with eight stages, whose steps are a fraction of the time scale of the motion where it is:
/// a hard place does not make the whole run dear. That scale is long where motion is nearly free, also right
/// before an encounter, so the first steps are short, and none is a large part of the run: two runs of
/// different fractions never take the same steps.
template <class Any>
class PacedGauss {
 public:
  using State = typename Any::State;

  static Setting method() { return {.method = Setting::Method::gauss, .stages = 8}; }

  SEMIEXPLICIT_COLD PacedGauss(Problem<Any>& problem, double fraction)
      : problem_(problem),
        fraction_(fraction),
        walker_(problem, method()),
        here_(problem.time_scale_at(problem.z0, 0.01 * problem.table.time_scale)) {}

  /// Time scale of the motion after the last step.
  double scale() const { return here_; }

  /// One step from t, not beyond `end`. Returns the time after it: t where no step works, or the calls ended.
  SEMIEXPLICIT_COLD double step(State& z, double t, double end, Probe& probe) {
    const double wanted = fraction_ * std::min(here_, problem_.table.time / 48);
    // Only a step that stays the same starts near its stages.
    if (wanted > 0 && !(wanted > dt_ / 1.4 && wanted < 1.4 * dt_))
      dt_ = rounded(std::min(wanted, dt_ > 0 ? 2 * dt_ : wanted / 16));
    for (int attempt = 0; attempt < 40; ++attempt, dt_ /= 2) {
      const double dt = std::min(dt_, end - t);
      State next = z;
      probe = Probe();
      if (!walker_.step(next, dt, probe, false)) {
        if (probe.cut) break;
        continue;
      }
      const double there = problem_.time_scale_at(next, 0.01 * dt);
      if (fraction_ * there < dt / 3 && attempt < 3) continue;  // ran into what is harder
      z = next, here_ = there;
      return dt < dt_ ? end : t + dt;
    }
    return t;
  }

 private:
  /// To ten bits: the times then add up without rounding.
  static double rounded(double dt) {
    int exponent = 0;
    const double part = std::frexp(dt, &exponent);
    return std::ldexp(std::floor(std::ldexp(part, 10)), exponent - 10);
  }

  Problem<Any>& problem_;
  double fraction_;
  Walker<Any> walker_;
  double here_, dt_ = 0;
};

/// The observable along a run that is known to be better than those that are compared with it, at some
/// hundred times.
template <class Any>
class Reference {
 public:
  using Value = typename Problem<Any>::Value;

  struct Wish {
    double calls;     ///< gradient calls, about
    double length;    ///< time to go to
    double end;       ///< time to go to until the motion comes back to where it is hard
    double tried;     ///< time from the start that the rate of calls is known from
    double trial;     ///< how long settings are to be tried
    double tightest;  ///< target
    bool whole;       ///< the motion gets harder along the way: nothing comes back
  };

  /// Two runs whose steps differ by a factor 1.5, over and over until they agree to what the tightest target
  /// needs, or smaller steps no longer make them. False: the calls ended, or no step works.
  SEMIEXPLICIT_COLD bool make(Problem<Any>& problem, const Wish& wish) {
    const double begin = problem.table.spent_gradients;
    double fraction = 3;
    // A short stretch tells the step, for a fraction of the calls.
    for (const double share : {0.04, 0.36}) {
      double last = 0, last_apart = 0, last_fraction = 0;
      int no_better = 0;  // in a row: a few times it may be luck with larger steps, or none with these
      for (int attempt = 0; attempt < 24; ++attempt) {
        apart_.clear();
        std::vector<Value> coarse;
        const bool made = explore(problem, fraction, share * wish.calls, wish) &&
                          (coarse = choose_times(wish.trial), follow(problem, fraction / 1.5, 4 * explored_));
        const bool enough_calls = problem.table.spent_gradients - begin < 6 * wish.calls;
        if (!made) {
          if (cut_ || !enough_calls) return false;
          fraction /= 1.5;
          continue;
        }
        // Of a finer run the observable may be finite there, but it has to be seen.
        double& observable_end = problem.table.observable_end;
        if (length() < observable_end && std::isfinite(observable_end)) return false;
        observable_end = std::numeric_limits<double>::infinity();
        const double unit = find_unit(problem);
        apart_.assign(times_.size(), 0);
        for (std::size_t i = 0; i < times_.size(); ++i)
          apart_[i] = static_cast<double>(norm(values_[i] - coarse[i])) / unit;
        if (last_apart > 0 && apart() > 0)
          order_ = std::clamp(std::log(last_apart / apart()) / std::log(last_fraction / fraction), 0.0, 8.0);
        last_apart = apart(), last_fraction = fraction;
        const double whole = std::min(wish.length, length() * 0.36 / share);
        // Little below what is asked for, as parts of a run may tell too little, but not below rounding.
        const double rounding = problem.rounding_of_orbit(problem.table.time_scale);
        const double enough = std::clamp(rounding / 3, wish.tightest / 100, wish.tightest / 10) *
                              std::pow(whole / problem.table.time, 1.5) * (length() / whole);
        no_better = last > 0 && error() > 0.3 * last && error() < 1e-6 ? no_better + 1 : 0;
        const double epsilon = static_cast<double>(Eigen::NumTraits<typename Any::Scalar>::epsilon());
        const double by_rounding = std::min(1e6 * epsilon, 100 * rounding);
        const bool rounded = no_better == (error() < by_rounding ? 2 : 4);
        if (error() <= enough || rounded || !enough_calls) break;
        last = last > 0 ? std::min(last, error()) : error();
        fraction *= std::clamp(std::pow(enough / last, 1.0 / 16), 0.3, 1 / 1.5);
      }
      if (apart_.empty()) {  // no step goes on from there, in any of the runs
        problem.table.orbit_end = stuck_at_;
        return false;
      }
    }
    return true;
  }

  double length() const { return times_.back(); }
  /// How long settings are tried: for as long as asked, and until the motion has come back to where it is
  /// hard.
  double trial() const { return trial_; }
  /// When it has; 0: it is equally hard everywhere; infinite: it was not seen to.
  double cycle() const { return cycle_; }
  /// How much finer steps must be in hard places than at the start.
  double hardness() const { return hardness_; }
  /// How far the two runs are apart at worst: the error of the coarser one.
  double apart() const { return *std::max_element(apart_.begin(), apart_.end()); }
  /// The error of the finer one, as far as it was seen to fall with the step.
  double error() const { return error_until(length()); }
  double error_until(double t) const {
    double worst = 0;
    for (std::size_t i = 0; i < times_.size(); ++i)
      if (times_[i] <= t) worst = std::max(worst, apart_[i]);
    return worst * std::pow(1.5, -order_);
  }
  /// Whether the observable is constant as far as the reference knows: an invariant.
  SEMIEXPLICIT_COLD bool is_constant(const Problem<Any>& problem) const {
    const Value first = problem.measured(problem.z0);
    double range = 0;
    for (const Value& value : values_)
      range = std::max(range, static_cast<double>(norm(value - first)) / problem.table.unit);
    const double rounding =
        50 * static_cast<double>(Eigen::NumTraits<typename Any::Scalar>::epsilon()) * problem.judged.terms;
    return range <= std::max(10 * apart(), rounding);
  }

  /// Runs a setting as far as `length`; the largest errors in both halves go to the probe.
  SEMIEXPLICIT_COLD Probe compare(Problem<Any>& problem, const Setting& setting, double length) const {
    Probe probe;
    std::vector<double> times;
    for (const double t : times_)
      if (t <= length) times.push_back(t);
    const auto values = values_of_run(problem, setting, times, probe);
    note_errors(problem, times, values, values_, 1, probe);
    probe.early += error_until(probe.length / 2), probe.late += error_until(probe.length);
    return probe;
  }

 private:
  struct Point {
    double t, scale;
    Value value;
  };

  /// A run as far as the calls go; notes every step, or every second, fourth ... of many.
  SEMIEXPLICIT_COLD bool explore(Problem<Any>& problem, double fraction, double calls, const Wish& wish) {
    const double begin = problem.table.spent_gradients;
    PacedGauss<Any> run(problem, fraction);
    auto z = problem.z0;
    Probe probe;
    double t = 0, length = wish.length;
    way_.clear();
    goes_to_end_ = false;
    first_scale_ = run.scale();
    for (std::size_t n = 1, stride = 1; way_.empty() || problem.table.spent_gradients - begin < calls; ++n) {
      if (t >= length) {
        find_cycle(wish.whole);
        if (!std::isinf(cycle_) || t >= wish.end) break;
        length = wish.end;  // on, for what comes then
      }
      const double after = run.step(z, t, length, probe);
      cut_ = probe.cut;
      stuck_at_ = after;
      if (!(after > t)) return false;
      t = after;
      if (n % stride != 0) continue;
      if (t <= wish.tried) first_scale_ = std::min(first_scale_, run.scale());
      way_.push_back({t, run.scale(), problem.measured(z)});
      if (!all_finite(way_.back().value)) {
        problem.table.observable_end = std::min(problem.table.observable_end, t);
        return false;
      }
      if (way_.size() < most_points) continue;
      for (std::size_t i = 0; i < most_points / 2; ++i) way_[i] = way_[2 * i + 1];
      way_.resize(most_points / 2);
      stride *= 2;
    }
    explored_ = problem.table.spent_gradients - begin;
    goes_to_end_ = t >= wish.end;
    find_cycle(wish.whole);
    return true;
  }

  /// The second way out of what is hard, or into it, from a start there or elsewhere; the last where the run
  /// ends before, or where nothing comes back.
  SEMIEXPLICIT_COLD void find_cycle(bool nothing_returns) {
    cycle_ = 0;
    std::vector<double> scales;
    for (const Point& point : way_) scales.push_back(point.scale);
    std::sort(scales.begin(), scales.end());
    const double least = scales[scales.size() / 20], most = scales[scales.size() - 1 - scales.size() / 10];
    hardness_ = std::max(1.0, first_scale_ / least);
    if (nothing_returns) cycle_ = goes_to_end_ ? way_.back().t : std::numeric_limits<double>::infinity();
    if (nothing_returns || !(most > 3 * least)) return;
    const double level = std::sqrt(least * most);
    bool hard = way_.front().scale < level;
    int changes = 0;
    for (const Point& point : way_) {
      if (hard ? point.scale < 1.2 * level : point.scale > level / 1.2) continue;
      hard = !hard;
      cycle_ = point.t;
      if (++changes == 3) return;
    }
    if (!goes_to_end_) cycle_ = std::numeric_limits<double>::infinity();
  }

  /// As many ends of steps in the trial as beyond it, not in step with any period. Returns the values there.
  SEMIEXPLICIT_COLD std::vector<Value> choose_times(double trial) {
    trial /= hardness_;  // which makes it as dear
    trial_ = std::clamp(std::max(trial, std::min(1.05 * cycle_, 16 * trial)), way_.front().t, way_.back().t);
    if (2 * trial_ > way_.back().t) trial_ = way_.back().t;  // what little is left may be the hardest
    times_.clear();
    std::vector<Value> values;
    const auto choose = [&](std::size_t from, std::size_t to, std::size_t most) {
      const double count = static_cast<double>(std::min(most, to - from));
      std::size_t next = from;
      for (double i = 1; i <= count; ++i) {
        const double x = i == count ? 1 : (i - 0.3 * std::fmod(0.618034 * i, 1.0)) / count;
        const auto at = from + static_cast<std::size_t>(std::ceil(x * static_cast<double>(to - from))) - 1;
        if (at < next) continue;
        next = at + 1;
        times_.push_back(way_[at].t);
        values.push_back(way_[at].value);
      }
    };
    std::size_t in_trial = 1;
    while (in_trial < way_.size() && way_[in_trial - 1].t < trial_) ++in_trial;
    choose(0, in_trial, in_trial < way_.size() ? 96 : 160);
    choose(in_trial, way_.size(), 64);
    trial_ = std::min(trial_, times_.back());
    return values;
  }

  /// The observable at the chosen times of a run; false: a step failed, or it took more calls than that: the
  /// run that chose them went another way.
  SEMIEXPLICIT_COLD bool follow(Problem<Any>& problem, double fraction, double calls) {
    PacedGauss<Any> run(problem, fraction);
    Probe probe;
    double t = 0;
    const double end = problem.table.spent_gradients + calls;
    values_ = values_along(problem, times_, run.method(), probe, [&](auto& z) {
      return problem.table.spent_gradients < end ? t = run.step(z, t, times_.back(), probe) : t;
    });
    cut_ = probe.cut;
    return values_.size() == times_.size();
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

  static constexpr std::size_t most_points = 2048;

  std::vector<Point> way_{};
  std::vector<double> times_{}, apart_{};
  std::vector<Value> values_{};
  double order_ = 0, explored_ = 0, trial_ = 0, cycle_ = 0, stuck_at_ = 0, first_scale_ = 0, hardness_ = 1;
  bool cut_ = false, goes_to_end_ = false;
};

}  // namespace semiexplicit::detail
