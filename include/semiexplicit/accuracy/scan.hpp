#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <functional>
#include <iterator>
#include <limits>
#include <map>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/cost_options.hpp>
#include <semiexplicit/accuracy/hard_places.hpp>
#include <semiexplicit/accuracy/probe.hpp>
#include <semiexplicit/accuracy/right_gradient.hpp>
#include <semiexplicit/core/cold.hpp>

namespace semiexplicit::detail {

/// Processor time of this thread, in seconds.
inline double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// The work of cost_of_accuracy(): a pilot run that finds where the problem is hard, windows there and elsewhere, trials of
/// settings on them, and for each target a search for the step and the scheme.
template <class Scalar, int Dof>
class Scan {
 public:
  using H = AnyHamiltonian<Scalar, Dof>;
  using State = PhasePoint<Scalar, Dof>;

  Scan(const H& hamiltonian, const State& z0, double T, const CostOptions& options)
      : hamiltonian_(hamiltonian), z0_(z0), options_(options) {
    cost_.targets = options.targets;
    cost_.by = options.by;
    cost_.time = T;
  }

  SEMIEXPLICIT_COLD CostOfAccuracy result() {
    const double start = cpu_seconds();
    families_ = families();  // refuses what is misspelled
    find_scale();
    if (pilot()) {
      windows_ = windows();
      pilot_spent_ = cost_.spent_gradients;
      std::vector<double> targets = options_.targets;
      std::sort(targets.begin(), targets.end(), std::greater<>());
      double last = 0;
      for (const double target : targets) {
        searched_part_ += 1 / static_cast<double>(targets.size());
        // What rounding forbids is not looked for, but how near one comes.
        const double reachable = std::max(target, 10 * cost_.rounding);
        if (reachable != last) search(reachable, target);
        last = reachable;
      }
      finish_rows();
    }
    cost_.spent_seconds = cpu_seconds() - start;
    return cost_;
  }

 private:
  /// Trials of one scheme or number of stages, by the step, the largest first.
  struct Candidate {
    Setting setting;
    int order = 2;
    double kicks = 1;        ///< gradient calls a step, usually
    double least_calls = 1;  ///< and at least
    std::map<double, Probe, std::greater<>> trials{};
  };
  using Family = std::vector<Candidate>;

  SEMIEXPLICIT_COLD std::vector<Family> families() const {
    std::vector<Family> all;
    if (!options_.schemes.empty()) {
      all.emplace_back();
      for (const std::string& name : options_.schemes) {
        const auto scheme = schemes::by_name<double>(name);
        all.back().push_back({.setting = {.scheme = name},
                              .order = scheme.order,
                              .kicks = static_cast<double>(scheme.kicks()),
                              .least_calls = static_cast<double>(scheme.kicks())});
      }
    }
    const auto add_gauss = [&](Setting::Method method) {
      if (options_.gauss_stages.empty()) return;
      all.emplace_back();
      for (const int stages : options_.gauss_stages)
        all.back().push_back({.setting = {.method = method, .stages = stages},
                              .order = 2 * stages,
                              .kicks = 14.0 * stages,
                              .least_calls = 2.0 * stages});
    };
    // In gradient calls the stages in lanes are no better: they only win in time.
    if (hamiltonian_.takes_packs() && options_.by == CostBy::seconds)
      add_gauss(Setting::Method::gauss_lanes);
    else
      add_gauss(Setting::Method::gauss);
    return all;
  }

  /// The characteristic time ‖z₀‖/‖X(z₀)‖, and the unit of the energy error.
  SEMIEXPLICIT_COLD void find_scale() {
    Vector<Scalar, Dof> gq = z0_.q(), gp = z0_.p();
    hamiltonian_.gradient(z0_.q(), z0_.p(), gq, gp);
    ++cost_.spent_gradients;
    const double speed = std::hypot(static_cast<double>(norm(gq)), static_cast<double>(norm(gp)));
    if (!std::isfinite(speed))
      throw std::invalid_argument(
          "cost_of_accuracy: the gradient at z0 is NaN or Inf; give another initial state");
    if (speed == 0)
      throw std::invalid_argument(
          "cost_of_accuracy: nothing moves at z0, the gradient is zero; give another state");
    const double size = static_cast<double>(norm(z0_.vector()));
    cost_.time_scale = std::min(cost_.time, size > 0 ? size / speed : cost_.time);
    const auto energy = [this](const auto& q, const auto& p) { return Scalar(hamiltonian_.energy(q, p)); };
    const Scalar first = energy(z0_.q(), z0_.p());
    using std::isfinite;
    if (!isfinite(first))
      throw std::invalid_argument(
          "cost_of_accuracy: the energy at z0 is NaN or Inf; give another initial state");
    const auto reference = reference_size(energy, first, z0_);
    energy_unit_ = reference.size;
    cost_.relative = reference.relative;
    State velocity = z0_;
    velocity.q() = gp, velocity.p() = -gq;
    const Scalar noise = require_right_gradient("cost_of_accuracy", hamiltonian_, z0_, velocity,
                                                cost_.time_scale, cost_.spent_gradients);
    terms_ = std::max(1.0, static_cast<double>(reference.terms / energy_unit_));
    if (isfinite(noise))
      noise_ = 4 * static_cast<double>(noise / energy_unit_);  // a level, and the largest counts
    cost_.rounding = rounding(cost_.time_scale);
    // An energy that is small beside its terms has large relative errors where nothing is wrong.
    hopeless_ = std::max(1.0, terms_ / 100);
    coarse_ = std::max(coarse_error * hopeless_, 10 * cost_.rounding);
  }

  /// What the rounding of the states adds to the error over the whole time, and the noise of the energy.
  double rounding(double dt) const {
    const double epsilon = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
    return epsilon / 2 * terms_ * std::sqrt(cost_.time / dt) + noise_;
  }

  /// Runs a cheap setting as far as its part of the budget goes, and keeps where its energy varied most. False: there is nothing
  /// to advise on, and cost_ says why.
  SEMIEXPLICIT_COLD bool pilot() {
    Setting coarse{.scheme = "low_defect4_s7", .rule = StoppingRule::product(1e-8)}, now = coarse;
    double rate = 0;
    now.dt = cost_.time_scale;
    // From the largest step that works at all on to the cheapest: large ones take many evaluations.
    limit_ = std::min(options_.max_gradients, std::max(1e5, 10 * options_.min_gradients));
    for (int attempt = 0; attempt < 60; ++attempt, now.dt /= 1.4) {
      const Probe seen = tried(now, {{z0_, std::min(cost_.time, 20 * now.dt), true}}, coarse_);
      if (seen.cut) break;
      if (!seen.works() && rate == 0) continue;
      if (!seen.works() || (rate > 0 && seen.rate > rate)) break;
      rate = seen.rate;
      coarse = now;
    }
    cost_.budget = limit_;
    if (rate == 0) {
      if (cost_.spent_gradients + 1e4 > limit_) cost_.unfinished = 1;
      return false;
    }
    pilot_rate_ = rate;
    double run_rates = 0;
    for (const double target : options_.targets) run_rates += run_over_pilot(target) * rate;
    budget_ = std::min(std::max(options_.min_gradients, options_.budget * run_rates * cost_.time),
                       options_.max_gradients / 3);
    cost_.budget = budget_;
    window_time_ = std::min(cost_.time, window_share * budget_ / (run_rates * trials_a_target));
    // As far as the calls go; what a short run leaves over makes it more faithful.
    const double affordable_time = pilot_share * budget_ / rate;
    coarse.dt /= std::clamp(affordable_time / cost_.time, 1.0, 6.0);
    return follow(coarse, std::min(cost_.time, affordable_time));
  }

  /// How many times the gradient calls of the pilot a run to a target takes, in the same time: a rule of thumb.
  static double run_over_pilot(double target) { return 1.5 * std::pow(target / 1e-4, -0.12); }

  /// The pilot run proper. A segment that fails, or whose energy goes astray, is done again with a smaller step. False where no
  /// step gets through a segment.
  SEMIEXPLICIT_COLD bool follow(Setting coarse, double length) {
    double calls_left = 2 * pilot_share * budget_, farthest = 0;
    State z = z0_;
    segment_time_ = std::max({length / 2000, 4 * coarse.dt, window_time_ / window_count});
    bool stuck = false, cut = false;
    // To find out whether anything goes on takes more calls than it is worth otherwise.
    while (cost_.pilot_time < length && calls_left > (stuck ? -budget_ : 0.0) && !cut &&
           segment_time_ / coarse.dt < 1e9) {
      typename HardPlaces<State>::Segment segment{z, 0};
      const auto steps = static_cast<std::int64_t>(std::ceil(segment_time_ / coarse.dt));
      EnergyRange<Scalar, Dof> energies(hamiltonian_, energy_unit_);
      energies.start(z);
      const bool done = follow_segment(coarse, steps, z, energies, calls_left, farthest, cut);
      stuck = !done;
      if (done) {
        segment.hardness = energies.range();
        cost_.pilot_time += static_cast<double>(steps) * coarse.dt;
        places_.add(segment);
      } else {
        z = segment.start;
        coarse.dt /= 1.5;
      }
    }
    if (stuck) {
      if (cut)
        cost_.unfinished = 1;
      else
        cost_.orbit_end = farthest;
      return false;
    }
    if (places_.all().empty()) places_.add({z0_, 0});
    places_.rank();
    return true;
  }

  /// One segment of the pilot run; false where it fails, goes astray, or is `cut` for want of calls.
  SEMIEXPLICIT_COLD bool follow_segment(const Setting& coarse, std::int64_t steps, State& z,
                                        EnergyRange<Scalar, Dof>& energies, double& calls_left,
                                        double& farthest, bool& cut) {
    AnyStepper<Scalar, Dof> stepper = hamiltonian_.stepper(coarse);
    const double worst = static_cast<double>(stepper.max_gradients());
    for (std::int64_t n = 0; n < steps; ++n) {
      cut = cost_.spent_gradients + worst > options_.max_gradients;
      if (cut) return false;
      const StepReport report = stepper.step(z, Scalar(coarse.dt));
      calls_left -= static_cast<double>(report.gradients);
      cost_.spent_gradients += static_cast<double>(report.gradients);
      if (report.ok()) energies.add(z);
      if (!report.ok() || !(energies.range() <= 3 * coarse_)) return false;
      farthest = std::max(farthest, cost_.pilot_time + static_cast<double>(n + 1) * coarse.dt);
    }
    return true;
  }

  /// The windows that all settings are tried on: the start, evenly spread ones, and the hardest.
  SEMIEXPLICIT_COLD std::vector<Window<State>> windows() const {
    if (window_time_ >= cost_.time) return {{z0_, cost_.time, true}};
    const double each = window_time_ / window_count;
    std::vector<Window<State>> list{{z0_, each, true}};
    for (std::size_t i = 1; i <= 2; ++i)
      list.push_back({places_.all()[places_.all().size() * i / 3].start, each, true});
    for (std::size_t i = 0; i < 5 && i < places_.count(); ++i)
      list.push_back({places_.hardest(i), std::max(each, segment_time_), false});
    return list;
  }

  /// What a choice is confirmed on: other hard stretches, and the run itself as far as the calls go.
  SEMIEXPLICIT_COLD std::vector<Window<State>> confirming_windows(double rate) const {
    const double length = std::min(cost_.time, confirm_share * budget_ / rate);
    std::vector<Window<State>> list{{z0_, length, true}};
    for (std::size_t i = 5; i < 30 && i < places_.count() && length < cost_.time; ++i)
      list.push_back({places_.hardest(i), segment_time_, false});
    return list;
  }

  SEMIEXPLICIT_COLD Probe tried(const Setting& setting, const std::vector<Window<State>>& where,
                                double hopeless) {
    const Probe result =
        probe(hamiltonian_, setting, where, energy_unit_, hopeless, limit_ - cost_.spent_gradients);
    exhausted_ = exhausted_ || result.cut;
    cost_.spent_gradients += static_cast<double>(result.gradients);
    return result;
  }

  /// The estimate of the error over the whole time.
  SEMIEXPLICIT_COLD double error(const Candidate& candidate, const Probe& probe, double dt) const {
    return probe.range * probe.spread * places_.growth(candidate.order, cost_.time / cost_.pilot_time) +
           probe.drift * cost_.time + rounding(dt);
  }

  /// Nothing where the calls do not suffice.
  SEMIEXPLICIT_COLD const Probe* trial(Candidate& candidate, double dt) {
    Setting setting = candidate.setting;
    setting.dt = dt;
    double least = 0;
    for (const auto& window : windows_) least += candidate.least_calls * std::max(4.0, window.length / dt);
    exhausted_ = exhausted_ || !(cost_.spent_gradients + least <= limit_);
    if (exhausted_) return nullptr;
    const Probe seen = tried(setting, windows_, hopeless_);
    if (seen.cut) return nullptr;
    return &(candidate.trials[dt] = seen);
  }

  /// The cheapest rate of a candidate for a target; infinity where it does not reach it, or cannot be worth it.
  SEMIEXPLICIT_COLD double solve(Candidate& candidate, double target, double best) {
    const double infinity = std::numeric_limits<double>::infinity();
    auto& trials = candidate.trials;
    const auto error_at = [&](double step) { return error(candidate, trials[step], step); };
    double low = 0, high = infinity;
    for (int attempt = 0; attempt < 8; ++attempt) {
      // What is known: the smallest step that is not accurate enough, and the largest below it that is.
      low = 0, high = infinity;
      for (const auto& [step, seen] : trials)
        if (!(seen.works() && error_at(step) <= target)) high = std::min(high, step);
      for (const auto& [step, seen] : trials)
        if (step < high) low = std::max(low, step);
      if (low > 0 && (high / low < 1.12 || error_at(low) > target / 2.5)) break;
      if (low > 0 && trials[low].evaluations > 1.3 &&
          candidate.setting.method == Setting::Method::semiexplicit)
        break;  // larger steps take more evaluations still
      double dt = 0;
      const auto power_law = [&](double step) {
        return step * std::pow(0.7 * target / error_at(step), 1.0 / candidate.order);
      };
      if (trials.empty())
        dt = first_step(candidate, target);
      else if (low > 0 && high < infinity && trials[high].works())
        dt = low * std::pow(high / low, std::clamp(std::log(0.7 * target / error_at(low)) /
                                                       std::log(error_at(high) / error_at(low)),
                                                   0.1, 0.9));
      else if (low > 0 && high < infinity)
        dt = std::sqrt(low * high);
      else if (low > 0)
        dt = std::min(4 * low, power_law(low));
      else if (trials[high].works())
        dt = std::clamp(power_law(high), high / 5, high / 1.1);
      else
        dt = high / 1.6;
      const bool projects = candidate.setting.method == Setting::Method::semiexplicit;
      const double from = low > 0 ? low : high;
      if (from > 0 && from < infinity && trials[from].works() &&
          (!projects || trials[from].evaluations < 1.3)) {
        // Not worth more where even the step that is promised is dearer. Larger ones of Gauss take more iterations.
        const double promised =
            cost_rate(candidate, trials[from]) * std::pow(from / dt, projects ? 1.0 : 0.6);
        if (promised > 1.15 * best) return infinity;
      }
      if (low == 0 && high < infinity && trials[high].works()) {
        // No longer falling: rounding.
        const auto next = std::next(trials.rbegin());
        if (next != trials.rend() && next->second.works() && high < next->first / 1.1 &&
            error_at(high) < 1e-9 && error_at(high) > 0.7 * error_at(next->first))
          return infinity;
      }
      if (trial(candidate, dt) == nullptr) break;
    }
    if (low == 0) return infinity;
    double cheapest = infinity;
    for (const auto& [step, seen] : trials)
      if (seen.works() && error_at(step) <= target) cheapest = std::min(cheapest, cost_rate(candidate, seen));
    // Where the projection takes several evaluations, a smaller step may be cheaper; with one it costs `single` a kick.
    for (int attempt = 0; attempt < 5; ++attempt) {
      const Probe& seen = trials[low];
      if (candidate.setting.method != Setting::Method::semiexplicit || seen.evaluations < 1.1) break;
      low /= seen.evaluations > 1.5 ? 1.3 : 1.12;
      const double single = options_.by == CostBy::seconds ? seconds_per_call(candidate) : 1.0;
      if (candidate.kicks / low * single > std::min(cheapest, 1.2 * best)) break;
      const Probe* const smaller = trials.contains(low) ? &trials[low] : trial(candidate, low);
      if (smaller == nullptr || !smaller->works()) break;
      if (error_at(low) <= target) cheapest = std::min(cheapest, cost_rate(candidate, *smaller));
    }
    return cheapest;
  }

  /// Cost a unit of time, in what is to be cheap.
  SEMIEXPLICIT_COLD double cost_rate(Candidate& candidate, const Probe& seen) {
    return seen.rate * (options_.by == CostBy::seconds ? seconds_per_call(candidate) : 1.0);
  }

  /// Where to begin: with a step as dear as the cheapest known one that meets the target, or nearly.
  SEMIEXPLICIT_COLD double first_step(const Candidate& candidate, double target) const {
    double least = std::numeric_limits<double>::infinity();
    for (const double factor : {1.0, 30.0}) {
      for (const Family& family : families_)
        for (const Candidate& other : family)
          for (const auto& [step, seen] : other.trials)
            if (seen.works() && error(other, seen, step) <= factor * target)
              least = std::min(least, seen.rate);
      if (std::isfinite(least)) break;
    }
    if (!std::isfinite(least)) least = run_over_pilot(target) * pilot_rate_;
    return candidate.kicks / least;
  }

  /// Where in a family a target is expected to be met best: by figures from many problems.
  static std::size_t expected(const Family& family, double target) {
    const double place = (-std::log10(target) - 4) / 2 +
                         (family.front().setting.method == Setting::Method::semiexplicit ? 0 : 1);
    return static_cast<std::size_t>(
        std::clamp(std::round(place), 0.0, static_cast<double>(family.size() - 1)));
  }

  /// Looks for the cheapest of each family: from where it is expected to both sides, for as long as it gets cheaper. `wanted` is
  /// what the user asked for, where rounding forbids that.
  SEMIEXPLICIT_COLD void search(double target, double wanted) {
    exhausted_ = false;
    limit_ = std::min(options_.max_gradients, pilot_spent_ + search_limit * budget_ * searched_part_);
    best_rate_ = std::numeric_limits<double>::infinity();
    for (Family& family : families_) {
      const std::size_t middle = expected(family, target);
      const double here = solve(family[middle], target, best_rate_);
      best_rate_ = std::min(best_rate_, here);
      const auto walk = [&](auto next) {
        double last = here;
        for (std::size_t i = next(middle); i < family.size() && affordable(); i = next(i)) {
          const double now = solve(family[i], target, best_rate_);
          best_rate_ = std::min(best_rate_, now);
          if (!(now < last) && std::isfinite(last)) break;
          last = now;
        }
      };
      walk([](std::size_t i) { return i + 1; });
      walk([](std::size_t i) { return i - 1; });  // below zero it wraps round, beyond the size
    }
    confirm(target);
    double least = std::numeric_limits<double>::infinity(), at = 1;
    for (const Family& family : families_)
      for (const Candidate& candidate : family)
        for (const auto& [step, seen] : candidate.trials)
          if (seen.works() && error(candidate, seen, step) < least)
            least = error(candidate, seen, step), at = step;
    if (least <= wanted) return;
    if (least < 3 * rounding(at))
      cost_.rounding = std::max(cost_.rounding, std::nextafter(wanted, 1.0));
    else if (exhausted_)
      cost_.unfinished = std::max(cost_.unfinished, wanted);
  }

  /// Whether there is something to advise, but no calls are left to look for better.
  bool affordable() const {
    return !std::isfinite(best_rate_) || cost_.spent_gradients < 1.5 * budget_ * searched_part_;
  }

  /// Tries what would be advised on more windows, and looks further where it fails there.
  SEMIEXPLICIT_COLD void confirm(double target) {
    for (int attempt = 0; attempt < 6; ++attempt) {
      Candidate* chosen = nullptr;
      double chosen_step = 0, least = std::numeric_limits<double>::infinity();
      for (Family& family : families_)
        for (Candidate& candidate : family)
          for (const auto& [step, seen] : candidate.trials)
            if (seen.works() && error(candidate, seen, step) <= target &&
                cost_rate(candidate, seen) < least) {
              least = cost_rate(candidate, seen);
              chosen = &candidate;
              chosen_step = step;
            }
      if (chosen == nullptr || chosen->trials[chosen_step].confirmed) return;
      Setting setting = chosen->setting;
      setting.dt = chosen_step;
      Probe& seen = chosen->trials[chosen_step];
      const Probe again = tried(setting, confirming_windows(seen.rate), hopeless_);
      if (again.cut) return;
      seen.confirmed = true;
      seen.status = again.works() ? seen.status : again.status;
      seen.range = std::max(seen.range, again.range);
      const bool dearer = again.rate > 1.1 * seen.rate;
      if (again.rate > 0) {
        seen.rate = 0.2 * seen.rate + 0.8 * again.rate;
        seen.evaluations = std::max(seen.evaluations, again.evaluations);
      }
      seen.max_evaluations = std::max(seen.max_evaluations, again.max_evaluations);
      seen.drift = std::max(seen.drift, again.drift);
      if (dearer || !(seen.works() && error(*chosen, seen, chosen_step) <= target))
        solve(*chosen, target, std::numeric_limits<double>::infinity());
    }
  }

  SEMIEXPLICIT_COLD double seconds_per_call(Candidate& candidate) {
    auto& known = seconds_per_call_[candidate.setting.name()];
    if (known > 0) return known;
    Setting setting = candidate.setting;
    for (const auto& [step, seen] : candidate.trials)
      if (seen.works()) setting.dt = step;
    AnyStepper<Scalar, Dof> stepper = hamiltonian_.stepper(setting);
    // Where time decides it is worth a little more.
    const double enough = budget_ * (options_.by == CostBy::seconds ? 0.02 : 0.003);
    const double worst = static_cast<double>(stepper.max_gradients());
    State z = z0_;
    double calls = 0, begin = cpu_seconds();
    for (std::int64_t n = 0; calls < enough || n < 20; ++n) {
      if (n == 10) calls = 0, begin = cpu_seconds();  // warm now
      if (cost_.spent_gradients + worst > options_.max_gradients) break;
      const StepReport report = stepper.step(z, Scalar(setting.dt));
      cost_.spent_gradients += static_cast<double>(report.gradients);
      if (!report.ok()) {
        if (calls > 0 || n == 0) break;
        z = z0_;  // the warm part ran into something: time the first steps again
        continue;
      }
      calls += static_cast<double>(report.gradients);
    }
    known = calls > 0 ? (cpu_seconds() - begin) / calls : 0;
    return known;
  }

  SEMIEXPLICIT_COLD void finish_rows() {
    for (Family& family : families_)
      for (Candidate& candidate : family)
        for (const auto& [step, seen] : candidate.trials) {
          CostRow row{.setting = candidate.setting};
          row.setting.dt = step;
          row.status = seen.status;
          const double nan = std::numeric_limits<double>::quiet_NaN();
          row.error = seen.works() ? error(candidate, seen, step) : nan;
          row.gradients = seen.works() ? seen.rate * cost_.time : nan;
          row.seconds = seen.works() ? row.gradients * seconds_per_call(candidate) : nan;
          row.confirmed = seen.confirmed;
          row.drifts = seen.works() && seen.drift * cost_.time > row.error / 3;
          cost_.rows.push_back(row);
        }
    cost_.growth = places_.growth(4, cost_.time / cost_.pilot_time);
    cost_.windows = static_cast<int>(windows_.size());
    for (const auto& window : windows_) cost_.window_time += window.length;
  }

  static constexpr double coarse_error = 0.003;                    ///< of the pilot run, in its first steps
  static constexpr double pilot_share = 0.3, window_share = 0.45;  ///< of the budget
  static constexpr double confirm_share = 0.25;
  static constexpr double trials_a_target = 12;
  static constexpr double window_count = 8;
  static constexpr double search_limit =
      5;  ///< budgets after which even a target without a setting is given up

  H hamiltonian_;
  State z0_;
  CostOptions options_;
  CostOfAccuracy cost_{};
  Scalar energy_unit_{};
  double terms_ = 1, noise_ = 0;  ///< size of the energy's terms, and its noise, in its unit
  double coarse_ = coarse_error,
         hopeless_ = 1;                 ///< relative errors that the pilot run, and trials, are given up at
  double limit_ = 0, pilot_spent_ = 0;  ///< gradient calls
  bool exhausted_ = false;              ///< the search for a target has met the limit
  double budget_ = 0, pilot_rate_ = 0, segment_time_ = 0, window_time_ = 0, best_rate_ = 0,
         searched_part_ = 0;
  HardPlaces<State> places_{};
  std::vector<Window<State>> windows_{};
  std::vector<Family> families_{};
  std::map<std::string, double> seconds_per_call_{};
};

}  // namespace semiexplicit::detail
