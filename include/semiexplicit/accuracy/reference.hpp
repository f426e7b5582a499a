#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <exception>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/scout.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/two_sum.hpp>
#include <semiexplicit/observers/dense_output.hpp>

namespace semiexplicit::detail {

/// The observable along two runs by Gauss-Legendre with eight stages that are as good as rounding allows,
/// where it is no invariant. One takes three steps where the other takes two. Steps stay the same where the
/// motion is not far easier elsewhere: errors then grow least.
template <class Any>
class Reference {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;
  using Value = typename Problem<Any>::Value;
  using Time = typename Problem<Any>::Time;

  Reference(Problem<Any>& problem, const Scout<Any>& scout)
      : problem_(problem),
        scout_(scout),
        pacer_(problem),
        first_step_(pacer_.next()),
        by_two_(problem, method),
        by_three_(problem, method) {
    restart();
  }

  /// Goes on to `length`, with samples all along. For the first stretch of a run steps become smaller until
  /// both runs are apart by no more than `enough` in the unit of targets, or smaller ones no longer help.
  /// False: the calls ended, no step goes on, or the observable is not finite.
  SEMIEXPLICIT_COLD bool go(double length, double enough) {
    return (time_ > 0 ? go_on(length) : begin(length, enough)) && look_within_steps();
  }

  double rate() const { return rate_; }  ///< gradient calls a unit of time
  const std::vector<Sample<Any>>& samples() const { return samples_; }
  const auto& state() const { return fine_; }                 ///< where the finer one is
  double size() const { return size_; }                       ///< largest ‖f‖
  double time() const { return static_cast<double>(time_); }  ///< how far both runs went

  bool changes_steps() const { return varies_; }

  /// By how much both runs differ at worst, until t.
  double apart(double t) const {
    return largest_until(t, 0, [](const auto& sample) { return sample.apart; });
  }

  /// The largest ‖f‖ until t.
  double size_until(double t) const {
    return largest_until(t, size_of(problem_.first),
                         [](const auto& sample) { return size_of(sample.value); });
  }

  /// The power of the time with which the terms of the observable grow in the end.
  SEMIEXPLICIT_COLD double growth_of_terms() const {
    const auto terms_until = [this](double t) {
      return largest_until(t, 0, [](const auto& sample) { return sample.terms; });
    };
    const double before = terms_until(time() / 4);
    return before > 0 ? std::log(terms_until(time()) / before) / std::log(4.0) : 0;
  }

  /// Whether the observable is constant as far as the runs tell.
  SEMIEXPLICIT_COLD bool is_constant() const {
    double known = 50 * Problem<Any>::epsilon * scale();
    for (const auto& sample : samples_) {
      known = std::max(known, 10 * sample.apart);
      if (!(size_of(sample.value - problem_.first) <= known)) return false;
    }
    return true;
  }

  /// How far the observable is off a time scale behind z0 when that is rounded, where an entry of z moves by
  /// few roundings of itself: what depends on that entry is rounded by the motion, in all runs alike. 0
  /// elsewhere; nothing where the calls end.
  SEMIEXPLICIT_COLD std::optional<double> rounding_by_motion() {
    if (problem_.left() < 1) return std::nullopt;
    if (!hardly_moves()) return 0;
    Value value, moved;
    double h = std::min(problem_.table.time, problem_.table.time_scale);
    for (int attempt = 0; attempt < 20; ++attempt, h /= 2) {
      bool cut = false, works = measure_after(h, problem_.z0, value, cut);
      const auto distance = [&](const auto& near) {
        works = works && measure_after(h, near, moved, cut);
        return works ? Scalar(norm(moved - value)) : Scalar(0);
      };
      const double off = works ? problem_.when_rounded(problem_.z0, distance) : 0;
      if (cut) return std::nullopt;
      if (works) return off;
    }
    return 0;
  }

 private:
  SEMIEXPLICIT_COLD double largest_until(double t, double largest, const auto& measure) const {
    for (const auto& sample : samples_)
      if (sample.t <= t) largest = std::max(largest, measure(sample));
    return largest;
  }

  /// What rounding is relative to: the largest ‖f‖, or the terms that f is a sum of.
  double scale() const {
    return std::max({size_, problem_.judged.unit * problem_.judged.terms, scout_.terms()});
  }

  SEMIEXPLICIT_COLD void restart() {
    coarse_ = fine_ = problem_.z0;
    long_steps_.clear();
    time_ = carry_ = 0;
    size_ = size_of(problem_.first);
    samples_.clear();
  }

  /// A step that is longer than samples are to be apart.
  struct LongStep {
    State coarse, fine, fine_at_end;  ///< the states of both runs where it began, and of one where it ended
    Time t, dt;
    int parts;
  };

  /// Where the pair of runs is, and what it has seen.
  using Runs = std::tuple<State, State, Time, Time, double, double, double, std::vector<Sample<Any>>,
                          std::vector<LongStep>>;
  auto runs() {
    return std::tie(coarse_, fine_, time_, carry_, size_, rate_, spacing_, samples_, long_steps_);
  }

  /// Whether both runs are apart by no more than that. Where a force jumps next to a time at which both begin
  /// a step they are so, and both are wrong, at one jump of a hundred: where two more are cheap beside the
  /// calls allowed these have to agree, too.
  SEMIEXPLICIT_COLD bool agree(const Runs& start, double length, double most) {
    const bool is_cheap = rate_ * problem_.table.time < 0.03 * problem_.options.max_gradients;
    return apart(length) <= most && (!is_cheap || others_agree(start, length, most));
  }
  /// Whether two more runs from where the last stretch began, by other steps, are apart by no more than that;
  /// all is as it was then, and else goes on from these.
  SEMIEXPLICIT_COLD bool others_agree(const Runs& start, double length, double most) {
    const Runs made(runs());
    runs() = start;
    const double usual = std::exchange(stagger_, 0.87 * stagger_);
    if (follow(length) && apart(length) > most) return false;
    stagger_ = usual;
    runs() = made;
    return true;
  }

  SEMIEXPLICIT_COLD bool hardly_moves() {
    const auto& z0 = problem_.z0.vector();
    const auto last_velocity = problem_.velocity_at(fine_);  // from rest nothing moves at first
    const Scalar few = Scalar(1e4) * Eigen::NumTraits<Scalar>::epsilon();
    for (Eigen::Index i = 0; i < z0.size(); ++i)
      if ((problem_.first_velocity.vector()[i] != 0 || last_velocity.vector()[i] != 0) &&
          std::abs(fine_.vector()[i] - z0[i]) < few * std::abs(z0[i]))
        return true;
    return false;
  }
  /// The observable a step behind z. False: it fails.
  SEMIEXPLICIT_COLD bool measure_after(Time h, State z, Value& value, bool& cut) {
    Walker<Any> walker(problem_, method);
    Probe probe;
    const bool works = walker.step(z, h, probe);
    cut = probe.cut;
    if (!works) return false;
    problem_.measure(z, value);
    return all_finite(value);
  }

  /// The first stretch.
  SEMIEXPLICIT_COLD bool begin(double length, double enough) {
    constexpr double never = std::numeric_limits<double>::infinity();
    double before = never, least = never;
    bool agreed = false;
    const Runs start(runs());
    for (int no_better = 0; no_better < 3;) {
      if (!follow(length)) return false;
      const double rounding = 1e4 * Problem<Any>::epsilon * scale();
      const bool agrees =
          agree(start, length, std::min(enough * (problem_.options.absolute ? 1 : size_), rounding));
      const double now = apart(length);
      // Shorter steps do not bring so much by themselves.
      const bool too_soon = std::isfinite(before) && now < 1e-6 * before;
      if (agrees && (agreed || !too_soon)) break;
      agreed = agrees;
      const double small = std::max(1e-6 * size_, rounding);
      no_better = now > 0.3 * least && now < small ? no_better + 1 : 0;
      before = now, least = std::min(least, now);
      if (share_ < 1e-3) {
        others_agree(start, length, 10 * now);  // or what they are apart by counts
        break;
      }
      share_ /= 1.5;
      restart();
    }
    if (time_ == 0) return follow(length);
    return true;
  }

  /// Behind the first stretch. Where the runs part by far more than rounding would, in places that are
  /// harder, both begin anew with half the step, unless that was seen not to help, as in chaos.
  SEMIEXPLICIT_COLD bool go_on(double length) {
    const double from = time(), before = std::max(apart(from), Problem<Any>::epsilon * scale());
    const Runs start(runs());
    if (!follow(length)) return false;
    const double parted = apart(length);
    if (halving_failed_ || agree(start, length, 30 * before * std::pow(length / from, 1.5))) return true;
    share_ /= 2;
    restart();
    if (!follow(length)) return false;
    halving_failed_ = apart(length) > 0.3 * parted;
    return true;
  }

  /// Takes samples within the long steps, where lines from one to the next are not what the observable of
  /// interpolated states does. False: the calls ended.
  SEMIEXPLICIT_COLD bool look_within_steps() {
    double range = largest_until(
        time(), 0, [this](const auto& sample) { return size_of(sample.value - problem_.first); });
    for (const LongStep& step : std::exchange(long_steps_, {})) {
      if (problem_.left() < 2) return false;
      const std::vector<Value> seen = interpolate(step);
      for (const auto& value : seen)
        if (all_finite(value)) range = std::max(range, size_of(value - problem_.first));
      std::vector<std::pair<std::size_t, std::size_t>> lines{{0, static_cast<std::size_t>(step.parts)}};
      while (!lines.empty()) {
        const auto [from, to] = lines.back();
        lines.pop_back();
        std::size_t furthest = 0;
        double most = straight * range;
        for (std::size_t i = from + 1; i < to; ++i) {
          const auto part = Scalar(i - from) / Scalar(to - from);
          const double off = size_of(seen[i] - seen[from] - part * (seen[to] - seen[from]));
          if (off > most) most = off, furthest = i;
        }
        if (furthest == 0) continue;
        if (!sample_within(step, step.dt * Time(furthest) / Time(step.parts))) return false;
        lines.emplace_back(from, furthest), lines.emplace_back(furthest, to);
      }
    }
    std::stable_sort(samples_.begin(), samples_.end(),
                     [](const auto& a, const auto& b) { return a.t < b.t; });
    return true;
  }
  /// The observable of states between the ends of a step by interpolation, at equal distances; NaN where they
  /// have left its domain.
  SEMIEXPLICIT_COLD std::vector<Value> interpolate(const LongStep& step) {
    DenseOutput<Any> dense(problem_.hamiltonian, 2);
    const auto dt = static_cast<Scalar>(step.dt);
    dense(Scalar(0), step.fine), dense(dt, step.fine_at_end);
    problem_.spend(2);
    std::vector<Value> result;
    State between = step.fine;
    for (int i = 0; i <= step.parts; ++i) {
      dense.sought_after(0, Scalar(i) / Scalar(step.parts) * dt, between);
      auto& value = result.emplace_back();
      try {
        problem_.measure(between, value);
      } catch (const std::exception&) {
        value = Value::Constant(problem_.first.size(), std::numeric_limits<Scalar>::quiet_NaN());
      }
    }
    return result;
  }
  /// Takes a sample so far behind the beginning of a step, by a shorter one of both runs, unless that fails.
  /// False: the calls ended.
  SEMIEXPLICIT_COLD bool sample_within(const LongStep& step, Time dt) {
    Value coarse, fine;
    bool cut = false;
    if (!measure_after(dt, step.fine, fine, cut) || !measure_after(dt, step.coarse, coarse, cut)) return !cut;
    add_sample(step.t + dt, coarse, fine, 0, true, false);
    return true;
  }

  SEMIEXPLICIT_COLD void add_sample(const Time& t, const Value& coarse, const Value& fine, double terms,
                                    bool stays, bool opens) {
    samples_.push_back({t, fine, size_of(coarse - fine), terms, stays, opens});
    size_ = std::max(size_, size_of(fine));
  }
  static double size_of(const auto& value) { return static_cast<double>(norm(value)); }

  /// How many steps of the coarse run, of so many in that stretch, no sample is further apart than. A trial
  /// over much of T may be advice by itself: its samples are as close as the motion asks for, as far as
  /// the values are not many numbers.
  SEMIEXPLICIT_COLD double steps_between_samples(double length, double all) const {
    if (length >= problem_.table.time / 8)
      return std::max(
          {0.25, all / most_count, all * static_cast<double>(problem_.first.size()) / most_numbers});
    return varies_ ? all / count : std::numeric_limits<double>::infinity();
  }
  /// What the coarse run would take for a step where the reference is, or in the hardest place.
  SEMIEXPLICIT_COLD double local_step() {
    if (!varies_) return hardest_;
    auto ahead = fine_;
    pacer_.step(ahead, time(), problem_.table.time - time());
    return pacer_.next();
  }

  SEMIEXPLICIT_COLD bool follow(double length) {
    const double from = time(), begin = problem_.table.spent_gradients;
    // At times in step with no period, and after as much of the motion, too.
    const double most_steps = steps_between_samples(length, (length - from) / scout_.mean_step()),
                 spacing = std::min(most_steps * scout_.mean_step(), (length - from) / count);
    // Those of before become as few as the new ones.
    const auto keep = static_cast<std::size_t>(from > 0 ? std::max(1.0, std::round(spacing / spacing_)) : 1);
    std::size_t seen = 0;
    std::erase_if(samples_,
                  [&](const auto& sample) { return !sample.stays && !sample.opening && ++seen % keep != 0; });
    spacing_ = spacing;
    const auto flashes = scout_.flashes(from, length);
    // A part of the flash that goes on at t, or begins or ended right there; infinite where there is none.
    const auto part_of_flash = [&](double t) {
      double part = std::numeric_limits<double>::infinity();
      for (const auto& one : flashes)
        if (const double width = one.to - one.from; one.from - width / 2 <= t && t < one.to + width / 2)
          part = std::min(part, width / flash_count);
      return part;
    };
    const auto [hardest, varies] = scout_.paces();
    hardest_ = hardest, varies_ = varies > far_easier;
    Value coarse, fine;
    double steps = 0;
    int next = 1;
    for (double planned = 0; time_ < length;) {
      const double before = time();
      for (; next < count && planned <= time_; ++next)
        planned = from + (next - 0.3 * std::fmod(0.618034 * next, 1.0)) / count * (length - from);
      const double part = part_of_flash(time());
      const double local = local_step();
      double most = std::min({part, most_steps * local, (length - from) / least_count});
      // Its first steps are too short to tell the scout how hard the motion is there.
      if (from == 0 && !varies_) most = std::min(most, std::max(first_step_, time() / 2));
      const State coarse_before = coarse_, fine_before = fine_;
      const Time began = time_;
      if (!step(length, local, most)) return false;
      problem_.measure(fine_, fine);
      if (!all_finite(fine)) {
        problem_.table.observable_end = time();
        return false;
      }
      const auto parts = static_cast<int>(std::round((time() - before) / (length - from) * looks));
      if (parts > 1 &&
          static_cast<double>(long_steps_.size() + 1) * static_cast<double>(fine_.dof()) < most_numbers)
        long_steps_.push_back({coarse_before, fine_before, fine_, began, time_ - began, parts});
      const bool flash = std::isfinite(part),
                 opens = from == 0 && time_ >= 1.5 * (samples_.empty() ? 0 : samples_.back().t);
      const bool is_planned = time_ >= std::min(planned, length);
      steps += (time() - before) / (varies_ ? local : scout_.mean_step());
      if (!flash && !opens && !is_planned && steps < most_steps) continue;
      if (!flash && !opens) steps = 0;
      problem_.measure(coarse_, coarse);
      const double terms = is_planned || flash ? problem_.terms_at(fine_) : 0;
      add_sample(time_, coarse, fine, terms, flash, opens);
    }
    rate_ = (problem_.table.spent_gradients - begin) / (length - from);
    return true;
  }

  /// Two steps of one run, three of the other, of `most` together and not beyond `end`.
  SEMIEXPLICIT_COLD bool step(double end, double local, double most) {
    const Time left = end - time_ - carry_;
    double planned = 2 * share_ * hardest_;
    const double wanted = 2 * share_ * local;
    while (planned > 1.5 * wanted) planned /= much_easier;
    while (much_easier * planned <= wanted) planned *= much_easier;
    planned = stagger_ * std::min(planned, most);
    Time dt = planned < 0.999 * left ? Time(planned) : left;
    bool cut = pacer_.cut();
    for (int attempt = 0; attempt < 40 && time_ + dt > time_ && !cut; ++attempt, dt /= 2) {
      auto coarse = coarse_, fine = fine_;
      Probe probe;
      if (by_three_.step(fine, dt / 3, probe) && by_three_.step(fine, dt / 3, probe) &&
          by_three_.step(fine, dt / 3, probe) && by_two_.step(coarse, dt / 2, probe) &&
          by_two_.step(coarse, dt / 2, probe)) {
        coarse_ = coarse, fine_ = fine;
        // A plain sum of equal steps is rounded to one side for long, and off by more than both runs are
        // apart.
        const auto [sum, lost] = two_sum<Time>(time_, carry_ + dt);
        time_ = dt == left ? Time(end) : sum;
        carry_ = dt == left ? Time(0) : lost;
        return true;
      }
      cut = probe.cut;
    }
    if (!cut) problem_.table.orbit_end = std::min(problem_.table.orbit_end, time());
    return false;
  }

  inline static const Setting method{.method = Setting::Method::gauss, .stages = 8};
  static constexpr int count = 80, least_count = 32;  ///< samples of a stretch, if steps are short; at least
  static constexpr double most_count = 500, most_numbers = 4e6;  ///< of those of all samples
  static constexpr double flash_count = 16;                      ///< the same of a flash
  static constexpr double far_easier = 20, much_easier = 4;
  static constexpr double looks = 640;      ///< between samples, of a stretch
  static constexpr double straight = 0.05;  ///< of the range of values

  Problem<Any>& problem_;
  const Scout<Any>& scout_;
  Pacer<Any> pacer_;
  double first_step_;  ///< by the motion at z0
  Walker<Any> by_two_, by_three_;
  State coarse_{}, fine_{};
  std::vector<Sample<Any>> samples_{};
  std::vector<LongStep> long_steps_{};
  Time time_ = 0, carry_ = 0;  ///< and what rounding has left out of it
  double rate_ = 0, size_ = 0;
  double spacing_ = 0;                ///< of samples, in time
  double share_ = 0.4, hardest_ = 0;  ///< of the scout's steps, and the shortest of them
  bool varies_ = false;               ///< there are far longer ones
  bool halving_failed_ = false;
  double stagger_ = 1;  ///< of steps
};

}  // namespace semiexplicit::detail
