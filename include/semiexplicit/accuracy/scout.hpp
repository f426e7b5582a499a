#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/pacer.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/median.hpp>

namespace semiexplicit::detail {

/// A coarse run ahead of the trials: how hard the motion is along the way, how far it goes at all, and how
/// large the terms of the observable become.
template <class Any>
class Scout {
 public:
  /// What steps in that time are off by at most, in the observable and in the energy.
  struct Interval {
    double from = 0, to = 0, off = 0, off_in_energy = 0;
    void join(const Interval& next) {
      to = next.to, off = std::max(off, next.off),
      off_in_energy = std::max(off_in_energy, next.off_in_energy);
    }
  };

  explicit Scout(Problem<Any>& problem) : problem_(problem) { restart(); }

  /// Goes on to T, as far as `calls` in all go; to the end also where that takes no more than `most`. False:
  /// no step goes on, nor does one of finer runs, with which it is seen whether the orbit ends or the errors
  /// have taken it there.
  SEMIEXPLICIT_COLD bool go(double calls, double most) {
    while (!follow(calls, most)) {
      const bool again = std::abs(time_ - ended_) < 0.05 * time_;
      if (again || tolerance_ < 1e-5) {
        problem_.table.orbit_end = time_;
        return false;
      }
      ended_ = time_;
      tolerance_ /= 100;
      restart();
    }
    return true;
  }
  double spent() const { return spent_; }  ///< gradient calls
  double time() const { return time_; }    ///< how far it went

  /// A time in which the motion changes at the start: as few steps of the scout take.
  SEMIEXPLICIT_COLD double time_scale() const {
    std::vector<double> first;
    for (std::size_t i = 0; i < places_.size() && i < 8; ++i) first.push_back(places_[i].pace);
    return first.empty() ? problem_.table.time_scale : std::min(problem_.table.time, median(first) / 2);
  }

  /// How much finer steps must be in the hardest place that is known than where a trial of that length was,
  /// but for its first quarter: it may have begun in the middle of one. Infinite where such places come back
  /// and the trial has not seen four: what an error grows by from one to the next is not known then.
  SEMIEXPLICIT_COLD double harder_than(double length) const {
    const auto [least, varies] = paces();
    const double infinity = std::numeric_limits<double>::infinity(), level = least * std::sqrt(varies);
    double seen = infinity;
    int visits = 0, visits_in_trial = 0;
    bool hard = false;
    for (const Place& place : places_) {
      if (place.t > length / 4 && place.t <= length) seen = std::min(seen, place.pace);
      if (hard ? place.pace < 1.2 * level : place.pace > level / 1.2) continue;
      hard = !hard;
      if (!hard) continue;
      ++visits;
      visits_in_trial += place.t <= length;
    }
    if (places_.empty()) return 1;
    if (varies > 4 && visits_in_trial < std::min(visits, 4)) return infinity;
    // What the paces of an even motion differ by is no hard place.
    return std::max(1.0, seen / least / 1.3);
  }

  /// Whether steps behind that time are off by far more than as long ones until then, as at a wall that a
  /// free motion comes to once: in the observable, which may show nothing of it before, or in the energy.
  SEMIEXPLICIT_COLD bool errs_behind(double length) const {
    const double rounding = 1e3 * Problem<Any>::epsilon;
    return off_behind(length, &Interval::off, much_more, rounding * largest_.back()) > 0 ||
           passes(
               off_behind(length, &Interval::off_in_energy, clearly_more, rounding * problem_.energy_size()));
  }

  /// Times in that stretch in which the observable, or the energy, is off by far more in a step than in
  /// nearly all of the time, as a velocity is at a bounce: those where errors, which grow, are the largest.
  SEMIEXPLICIT_COLD std::vector<Interval> flashes(double from, double to) const {
    std::vector<Interval> result;
    for (double Interval::*const off : {&Interval::off, &Interval::off_in_energy}) {
      std::vector<Interval> all = intervals_, found;
      std::sort(all.begin(), all.end(),
                [off](const Interval& a, const Interval& b) { return a.*off > b.*off; });
      double rest = rare * time_;
      const auto usual = std::find_if(
          all.begin(), all.end(), [&rest](const Interval& one) { return (rest -= one.to - one.from) <= 0; });
      if (usual == all.end()) continue;
      for (const Interval& one : intervals_) {
        if (!(one.*off > clearly_more * ((*usual).*off)) || one.to <= from || one.from >= to) continue;
        if (!found.empty() && one.from <= found.back().to)
          found.back().join(one);
        else
          found.push_back(one);
      }
      const auto few = std::min(most_flashes, found.size());
      std::sort(found.begin(), found.end(),
                [off](const Interval& a, const Interval& b) { return a.*off * a.to > b.*off * b.to; });
      result.insert(result.end(), found.begin(), found.begin() + static_cast<std::ptrdiff_t>(few));
    }
    return result;
  }

  /// How much finer steps become in the course of T, as those of a motion that gets faster: the least of the
  /// eighths of T beside the first one, as far as the energy was kept.
  SEMIEXPLICIT_COLD double speeds_up() const {
    double most = 0;
    for (const Eighth& one : eighths_)
      if (one.time > 0) most = std::max(most, eighths_.front().mean() - one.mean());
    return std::exp(most);
  }

  /// The least step that it asked for, and the most in that.
  SEMIEXPLICIT_COLD std::pair<double, double> paces() const {
    double least = problem_.table.time, most = 0;
    for (const Place& place : places_) least = std::min(least, place.pace), most = std::max(most, place.pace);
    return {least, most / least};
  }

  /// What reversible steps follow, and what they take on an average.
  SEMIEXPLICIT_COLD monitors::TimeScaleOptions<double> sizes() const {
    const auto [least, varies] = paces();
    return {.length = pacer_->longest_in_q(),
            .momentum = pacer_->longest_in_p(),
            .longest = positive(least * varies)};
  }
  LengthsOfWays lengths() const { return pacer_->lengths(); }
  double mean_step() const { return time_ / static_cast<double>(std::max<std::size_t>(steps_, 1)); }

  /// The shortest trial of so many steps of the scout, or up to eight times as many, that sees places not far
  /// easier than the hardest; of so many where there is none.
  SEMIEXPLICIT_COLD double first_trial(double steps) const {
    const auto after = [&](double n) {
      const auto i = static_cast<std::size_t>(n);
      return i < places_.size() ? places_[i].t : time_;
    };
    for (double n = steps; n < 8 * steps; n *= 1.1)
      if (harder_than(after(n)) < 2.5) return after(n);
    return after(steps);
  }
  /// Gradient calls a unit of time.
  double rate() const { return spent_ / time_; }

  /// The largest ‖f‖ up to T, by what was seen of it as long as the energy was kept and steps were short
  /// enough for f: what grew with the time all along goes on to, as where a coordinate winds.
  SEMIEXPLICIT_COLD double largest_at_end() const {
    bool grows = largest_.size() > 4;
    for (std::size_t i = largest_.size(); grows && i > largest_.size() - 3; --i)
      grows = largest_[i - 2] > 1.9 * largest_[i - 3];
    return largest_.back() * (grows ? problem_.table.time / kept_ : 1);
  }

  /// The size of the terms at T: what grows goes on to grow, as where a coordinate winds.
  SEMIEXPLICIT_COLD double terms() const {
    if (terms_.size() < 4) return 0;
    const double last = terms_.back(), before = terms_[terms_.size() - 4];  // an eighth of the time
    return last > 3 * before ? last * std::max(1.0, problem_.table.time / last_look_) / std::sqrt(3.0)
                             : std::max(last, before);
  }

 private:
  struct Place {
    double t, pace;
    Interval since;  ///< the place before
  };
  /// The logarithm of the pace, over an eighth of T.
  struct Eighth {
    double time = 0, sum = 0;
    double mean() const { return sum / time; }
  };

  /// The most that steps behind that time are off by, where that is so many times more than `until` and than
  /// before; 0: it is not.
  SEMIEXPLICIT_COLD double off_behind(double length, double Interval::*off, double times,
                                      double until) const {
    double longest = 0, most = 0;
    for (const Place& place : places_)
      if (place.t <= length)
        until = std::max(until, place.since.*off), longest = std::max(longest, place.pace);
    for (const Place& place : places_) {
      const double longer = std::max(1.0, place.pace / longest);
      if (place.t > length && longest > 0 && place.since.*off > times * until * std::pow(longer, 5))
        most = std::max(most, place.since.*off);
    }
    return most;
  }
  /// Whether the energy is off by that for a while only: it is so for ever in what leaves, which the
  /// observable need not show.
  SEMIEXPLICIT_COLD bool passes(double most) const {
    return most > 0 && !places_.empty() && places_.back().since.off_in_energy < most / clearly_more;
  }

  SEMIEXPLICIT_COLD void restart() {
    pacer_.emplace(problem_, tolerance_);
    z_ = problem_.z0;
    places_.clear(), terms_.clear(), largest_.assign(1, 0);
    eighths_.fill({}), eighth_ = 0;
    steps_ = known_ = 0, stride_ = 1;
    time_ = last_look_ = kept_ = wrong_ = 0, keeps_energy_ = true;
    intervals_.clear(), joined_ = 1, since_place_ = {};
  }

  SEMIEXPLICIT_COLD bool follow(double calls, double most) {
    const double T = problem_.table.time, limit = problem_.limit;
    const double begin = problem_.table.spent_gradients - spent_;
    while (time_ < T) {
      problem_.limit = std::min(limit, begin + (spent_ * T <= most * time_ ? most : calls));
      const double dt = pacer_->step(z_, time_, T - time_);
      spent_ = problem_.table.spent_gradients - begin;
      if (dt == 0) break;
      time_ = dt == T - time_ ? T : time_ + dt;
      ++steps_;
      Interval made{.from = time_ - dt, .to = time_};
      const double apart = std::abs(problem_.energy_off(z_) - problem_.energy_off(pacer_->whole()));
      if (std::isfinite(apart)) made.off_in_energy = apart;
      if (!problem_.options.observable.is_energy()) {  // whose size is known
        keeps_energy_ = keeps_energy_ && problem_.keeps_energy(z_, 0.01);
        if (keeps_energy_) made.off = measure();
      }
      note(made);
      since_place_.join(made);
      if (pacer_->pace() > 0 && ++known_ % stride_ == 0) {
        places_.push_back({time_, pacer_->pace(), std::exchange(since_place_, {})});
        if (places_.size() == most_places) thin();
      }
      note_pace(dt);
      if (time_ < 2 * last_look_ && time_ < T) continue;
      last_look_ = time_;
      if (kept_ == time_) largest_.push_back(largest_.back());
      terms_.push_back(problem_.terms_at(z_));
    }
    problem_.limit = limit;
    return time_ >= T || pacer_->cut();
  }

  SEMIEXPLICIT_COLD void note_pace(double dt) {
    const auto now =
        std::min(eighths_.size() - 1, static_cast<std::size_t>(8 * (time_ / problem_.table.time)));
    // What errors have made of a small motion beside a large one is no motion that gets faster.
    const auto is_known = [this] {
      return problem_.options.observable.is_energy() ? problem_.keeps_energy(z_, 0.01) : kept_ == time_;
    };
    if (now > eighth_) eighth_ = is_known() ? now : eighths_.size();
    if (eighth_ == now && pacer_->pace() > 0)
      eighths_[now].time += dt, eighths_[now].sum += dt * std::log(pacer_->pace());
  }

  /// Notes ‖f‖ unless errors have taken it there: the steps follow what moves most, beside which a small
  /// motion may become unstable. What f is off by in steps that are too long for it then adds up to its size.
  /// Returns what it is off by in the last one; 0: that is not noted.
  SEMIEXPLICIT_COLD double measure() {
    problem_.measure(z_, value_), problem_.measure(pacer_->whole(), by_whole_);
    const double size = static_cast<double>(norm(value_)),
                 off = static_cast<double>(norm(value_ - by_whole_));
    if (!std::isfinite(size)) return 0;
    if (!(off < 0.1 * std::max(size, largest_.back()))) wrong_ += off;
    if (!(wrong_ < 0.3 * std::max(size, largest_.back()))) return 0;
    kept_ = time_;
    largest_.back() = std::max(largest_.back(), size);
    return off;
  }

  /// Of so many steps that two are one interval, then four.
  SEMIEXPLICIT_COLD void note(const Interval& made) {
    if (intervals_.empty() || in_last_ == joined_) {
      if (intervals_.size() == most_places) {
        for (std::size_t i = 0; i < most_places / 2; ++i) {
          intervals_[i] = intervals_[2 * i];
          intervals_[i].join(intervals_[2 * i + 1]);
        }
        intervals_.resize(most_places / 2);
        joined_ *= 2;
      }
      intervals_.push_back(made);
      in_last_ = 1;
      return;
    }
    intervals_.back().join(made);
    ++in_last_;
  }

  /// The harder one of two, but among the first ones.
  SEMIEXPLICIT_COLD void thin() {
    std::size_t filled = first_places;
    for (std::size_t i = first_places; i + 1 < most_places; i += 2) {
      Interval both = places_[i].since;
      both.join(places_[i + 1].since);
      places_[filled] = places_[i].pace < places_[i + 1].pace ? places_[i] : places_[i + 1];
      places_[filled++].since = both;
    }
    places_.resize(filled);
    stride_ *= 2;
  }

  static constexpr std::size_t most_places = 4096, first_places = 2048;
  static constexpr std::size_t most_flashes = 8;
  static constexpr double rare = 1.0 / 16;    ///< of the time
  static constexpr double clearly_more = 10;  ///< that the observable is off by in a flash
  static constexpr double much_more = 30;     ///< that the observable is off by in a step behind a trial

  Problem<Any>& problem_;
  std::optional<Pacer<Any>> pacer_{};
  typename Any::State z_{};
  std::vector<Place> places_{};
  std::array<Eighth, 8> eighths_{};
  std::size_t eighth_ = 0;  ///< of T, that it is in; 8: the energy is no longer that of the start
  std::vector<double> terms_{};
  std::size_t steps_ = 0, known_ = 0, stride_ = 1;
  double time_ = 0, last_look_ = 0, spent_ = 0, tolerance_ = 1e-2, ended_ = -1;
  std::vector<double> largest_{};  ///< ‖f‖ until each look, and until now
  bool keeps_energy_ = true;       ///< has, all along
  typename Problem<Any>::Value value_{}, by_whole_{};
  double wrong_ = 0;  ///< what f was off by in steps that are too long for it, added up
  double kept_ = 0;   ///< the time of the last ‖f‖ that was noted
  std::vector<Interval> intervals_{};
  std::size_t joined_ = 1, in_last_ = 0;  ///< steps in each of them, and in the last
  Interval since_place_{};                ///< the last one
};

}  // namespace semiexplicit::detail
