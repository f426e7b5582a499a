#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <semiexplicit/accuracy/hard_places.hpp>
#include <semiexplicit/accuracy/neighbour.hpp>
#include <semiexplicit/accuracy/trial.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// A coarse run as far as a part of the calls goes. It finds where along the way the energy varies most, how
/// large the observable becomes, and how fast a neighbouring orbit parts from this one.
template <class Any>
class Pilot {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;

  explicit Pilot(Problem<Any>& problem)
      : problem_(problem), energy_(problem, true), whole_(energy_), table_(problem.table) {
    hopeless = hopeless_beside(problem.energy.terms);
    coarse_error_ = coarse_beside(problem.energy.terms);
  }

  HardPlaces<State> places{};
  double rate = 0;          ///< gradient calls a unit of time
  double rate_time = 0;     ///< how far from z0 on that was seen
  double segment_time = 0;  ///< length of a stretch
  double hopeless = 1;      ///< an error that a trial is given up at
  double walk = 1;  ///< how far the energy ranges over the run, in the range within its hardest stretch

  /// Looks for the cheapest step that works at all. False: there is none, or the calls ended.
  SEMIEXPLICIT_COLD bool find_step() {
    const double before = problem_.limit;
    problem_.limit =
        std::min(problem_.options.max_gradients, std::max(1e5, 10 * problem_.options.min_gradients));
    bool cut = false, climbing = false;
    double dt = std::min(4 * table_.time_scale, table_.time);
    for (int attempt = 0; attempt < 90 && !cut; ++attempt) {
      setting_.dt = dt;
      const Probe seen = try_on_windows(
          problem_, setting_, {{problem_.z0, std::min(table_.time, 20 * dt), true}}, coarse_error_, true);
      cut = seen.cut;
      if (cut) break;
      const bool better = seen.works() && (rate == 0 || seen.rate < rate);
      if (better) rate = seen.rate, best_step_ = dt, rate_time = std::min(table_.time, 20 * dt);
      // A first step that works leaves room for larger ones; then on to smaller ones, as large ones take many
      // evaluations.
      if (attempt == 0 && seen.works()) climbing = true;
      if (rate > 0 && !better) {
        if (!climbing) break;
        climbing = false;
        dt = std::min(4 * table_.time_scale, table_.time);
        if (best_step_ > dt) break;
      }
      dt = climbing ? dt * 1.4 : dt / 1.4;
      if (climbing && dt > table_.time)
        climbing = false, dt = std::min(4 * table_.time_scale, table_.time) / 1.4;
    }
    problem_.limit = before;
    setting_.dt = best_step_;
    if (rate == 0 && (cut || table_.spent_gradients + 1e4 > before)) table_.unfinished = 1e300;
    return rate > 0;
  }

  /// The run proper: as far as `calls` go, with a neighbour where orbits that part matter. Then on to the end
  /// alone, where the whole run takes no more than `most` calls, or gets harder along the way.
  /// False where no step gets through a stretch.
  SEMIEXPLICIT_COLD bool follow(double least_segment, double calls, double most) {
    const double T = table_.time, whole = rate * T;
    const bool of_energy = problem_.options.observable.is_energy();
    watches_neighbour_ = !of_energy;
    if (watches_neighbour_) setting_.rule = tight_rule;  // unfinished solves part neighbours
    const double affordable = calls / (watches_neighbour_ ? 2 : 1) / rate;
    // What a short run leaves over makes it more faithful.
    setting_.dt /= std::clamp(affordable / T, 1.0, 6.0);
    first_dt_ = setting_.dt;
    const double length = std::min(T, affordable);
    segment_time = std::max({length / 2000, 4 * setting_.dt, least_segment});
    calls_if_stuck_ = 8 * calls;
    State z = problem_.z0;
    if (watches_neighbour_) neighbour_.emplace(problem_, first_dt_);
    whole_.start(z);
    bool stuck = follow_to(length, calls, z);
    const auto beyond_calls = [&](double limit, double allowed) {
      if (stuck || cut_ || table_.pilot_time >= T || whole > limit) return;
      stuck = follow_to(T, allowed, z) && of_energy;
      cut_ = cut_ && of_energy;
    };
    const auto rising = [&] { return places.will_rise(std::max(1.0, T / table_.pilot_time)); };
    watches_neighbour_ = false;
    watched_dt_ = setting_.dt;
    beyond_calls(std::min(most, problem_.options.max_gradients / 6), whole);
    if (table_.pilot_time < T && rising())
      beyond_calls(problem_.options.max_gradients / 6, 1.5 * whole);  // dearer where it is harder
    if (places.rises()) rate *= first_dt_ / setting_.dt;              // what the hardest takes
    // From a hard start the errors of what is no invariant are extrapolated safely.
    table_.changes = of_energy ? places.changes() : table_.pilot_time >= T ? places.rises() : rising();
    if (stuck) {
      if (cut_)
        table_.unfinished = 1e300;
      else
        table_.orbit_end = farthest_;
      return false;
    }
    if (places.all().empty()) places.add({problem_.z0, 0});
    walk = std::max(1.0, 1.5 * whole_.range() / largest_range_);  // of a higher order it may be somewhat more
    places.rank();
    problem_.weigh(0.01 * first_dt_);
    problem_.judge_growth_of_terms(table_.pilot_time);
    if (neighbour_) {
      judge_parting();
      problem_.responds(neighbour_->response());
    }
    return true;
  }

 private:
  /// An energy that is small beside its terms has large relative errors where nothing is wrong.
  static double hopeless_beside(double terms) { return std::max(1.0, terms / 100); }
  double coarse_beside(double terms) const {
    const double rounding = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon()) / 2 * terms *
                            std::sqrt(table_.time / table_.time_scale);
    return std::max(0.003 * hopeless_beside(terms), 10 * (rounding + problem_.energy.noise));
  }

  /// On from z to the time `length`, or until the calls are spent. A stretch that fails, or whose energy goes
  /// astray, is done again with a smaller step. True: no step tried got through the last one.
  SEMIEXPLICIT_COLD bool follow_to(double length, double calls, State& z) {
    const double begin = table_.spent_gradients;
    double last = begin;
    bool stuck = false;
    // To find out whether anything goes on takes more calls than it is worth otherwise.
    while (table_.pilot_time < length && !cut_ && segment_time / setting_.dt < 1e9 &&
           (stuck ? table_.spent_gradients - last < calls_if_stuck_
                  : table_.spent_gradients - begin < 2 * calls)) {
      const State start = z, beside_it = watches_neighbour_ ? neighbour_->state : z;
      const Range<Any> whole = whole_;
      stuck = !segment(z);
      if (stuck) {
        z = start, whole_ = whole;
        if (watches_neighbour_) neighbour_->state = beside_it;
        setting_.dt /= 1.5;
      } else {
        problem_.meet(z);
        if (watches_neighbour_) neighbour_->note(table_.pilot_time, z);
        last = table_.spent_gradients;
      }
    }
    return stuck;
  }

  /// One stretch from z on.
  SEMIEXPLICIT_COLD bool segment(State& z) {
    const auto steps = static_cast<std::int64_t>(std::ceil(segment_time / setting_.dt));
    Walker<Any> walker(problem_, setting_), beside_it(problem_, setting_);
    const State start = z;
    energy_.start(z);
    if (watches_neighbour_) neighbour_->begin();
    Probe probe;
    for (std::int64_t n = 0; n < steps; ++n) {
      if (!walker.step(z, setting_.dt, probe, false)) {
        cut_ = probe.cut;
        return false;
      }
      energy_.add(z);
      whole_.add(z);
      if (!(energy_.range() <= 3 * coarse_error_) &&
          !(energy_.range() <= 3 * coarse_beside(problem_.terms_of_energy(z))))
        return false;
      farthest_ = std::max(farthest_, table_.pilot_time + static_cast<double>(n + 1) * setting_.dt);
      if (!watches_neighbour_) continue;
      if (!beside_it.step(neighbour_->state, setting_.dt, probe, false)) {
        cut_ = probe.cut;
        return false;
      }
      neighbour_->see(z);
    }
    // As with the first step.
    places.add({start, energy_.range() * std::pow(first_dt_ / setting_.dt, 4)});
    largest_range_ = std::max(largest_range_, energy_.range());
    table_.pilot_time += static_cast<double>(steps) * setting_.dt;
    return true;
  }

  /// The rate at which neighbours part, seen again with steps of half the size: coarse ones may part them
  /// themselves in a hard place.
  SEMIEXPLICIT_COLD void judge_parting() {
    table_.parting_rate = neighbour_->parting_rate();
    for (int attempt = 0; attempt < 2 && table_.parting_rate > 0; ++attempt) {
      const double end = neighbour_->time_to_part();
      watched_dt_ /= 2;
      Neighbour<Any> again(problem_, watched_dt_);
      Walker<Any> walker(problem_, setting_), beside_it(problem_, setting_);
      const auto steps = static_cast<std::int64_t>(std::ceil(std::min(segment_time, end / 64) / watched_dt_));
      State z = problem_.z0;
      Probe probe;
      for (double t = 0; t < end;) {
        again.begin();
        for (std::int64_t n = 0; n < steps; ++n) {
          if (!walker.step(z, watched_dt_, probe, false) ||
              !beside_it.step(again.state, watched_dt_, probe, false))
            return note_horizon();
          again.see(z);
        }
        t += static_cast<double>(steps) * watched_dt_;
        again.note(t, z);
      }
      const double before = table_.parting_rate;
      table_.parting_rate = again.parting_rate();
      neighbour_.emplace(again);
      if (table_.parting_rate > 0.7 * before) break;
    }
    note_horizon();
  }
  void note_horizon() {
    const double epsilon = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
    if (table_.parting_rate > 0) table_.horizon = std::log(1 / epsilon) / table_.parting_rate;
  }

  inline static const StoppingRule rule = StoppingRule::product(1e-8),
                                   tight_rule = StoppingRule::product(1e-14);

  Problem<Any>& problem_;
  Range<Any> energy_, whole_;  ///< of a stretch, and of the run
  CostTable& table_;
  Setting setting_{.scheme = "low_defect4_s7", .rule = rule};
  double best_step_ = 0, first_dt_ = 0, coarse_error_ = 0.003, farthest_ = 0;
  double calls_if_stuck_ = 0;
  bool watches_neighbour_ = false;
  double largest_range_ = 1e-300;  ///< of the energy, within a stretch
  bool cut_ = false;
  std::optional<Neighbour<Any>> neighbour_{};
  double watched_dt_ = 0;  ///< of the steps that it was watched with
};

}  // namespace semiexplicit::detail
