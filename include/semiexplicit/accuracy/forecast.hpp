#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <semiexplicit/accuracy/candidates.hpp>
#include <semiexplicit/accuracy/neighbour.hpp>
#include <semiexplicit/accuracy/reference.hpp>

namespace semiexplicit::detail {

/// What the error that a trial saw stands for at T: against which reference it is measured, what that is
/// worth, and by how much errors grow behind a trial.
template <class Any>
class Forecast {
 public:
  /// What depends on the time has to be seen to the end.
  static constexpr bool timed = InExtendedPhaseSpace<Any>;

  Forecast(Problem<Any>& problem, const Scout<Any>& scout)
      : problem_(problem),
        table_(problem.table),
        scout_(scout),
        reference_(problem, scout),
        neighbour_(problem) {}

  /// Notes and returns how far paces differ along the way that the scout has seen.
  double note_paces() { return varies_ = scout_.paces().second; }

  /// Makes a reference where one is needed. False: there is nothing to compare with.
  SEMIEXPLICIT_COLD bool see_as_far_as(double length) {
    if (problem_.options.observable.is_energy()) {
      problem_.judged.terms = std::max(problem_.judged.terms, scout_.terms() / problem_.judged.unit);
      by_rounding_ = problem_.epsilon / 2 * std::abs(static_cast<double>(problem_.first[0]));
      table_.rounding = problem_.rounding_of_invariant(table_.time_scale);
    } else {
      // Near rounding whatever is asked for: only then is seen how the error of the reference grows.
      const double enough = 0.1 * tightest() * length / table_.time;
      if (!reference_.go(length, enough)) return false;
      table_.invariant = reference_.is_constant();
      problem_.judge_by_first();
      const auto by_motion = reference_.rounding_by_motion();
      if (!by_motion) return false;
      by_rounding_ = std::max({problem_.rounding_at(problem_.z0), problem_.rounding_at(reference_.state()),
                               *by_motion, problem_.epsilon * reference_.size()});
      if (table_.invariant)
        table_.rounding = std::max(problem_.rounding_of_invariant(table_.time_scale), least_error());
      else
        judge_reference(length);
    }
    return true;
  }
  /// Of the reference, gradient calls a unit of time; and the observable along it, nothing of an invariant.
  double rate_of_reference() const { return problem_.options.observable.is_energy() ? 0 : reference_.rate(); }
  const auto& samples() const {
    static const std::vector<Sample<Any>> none;
    return table_.invariant ? none : reference_.samples();
  }

  /// Follows a neighbouring orbit by that setting, as far as the calls go. False: its steps fail.
  SEMIEXPLICIT_COLD bool look_beside(const Setting& setting) {
    const bool followed = neighbour_.go(setting, scout_.lengths());
    if (neighbour_.time() < table_.time && neighbour_.rate() > 0) parts(neighbour_.rate());
    judge_reference(reference_.time());
    return followed;
  }

  /// What rounding makes of the observable and no run sees, as all round to the same.
  double least_error() const { return by_rounding_ / table_.unit; }
  /// The error of a run of the whole.
  double error_of_whole(const Probe& probe) const {
    return probe.error +
           std::max(table_.invariant ? problem_.judged.noise : known_by_reference(probe), least_error());
  }
  /// The error at T that a trial by steps of dt stands for.
  SEMIEXPLICIT_COLD double error_of(const Candidate& candidate, const Probe& probe, double dt) const {
    if (is_whole(probe)) return error_of_whole(probe);
    const double T = table_.time;
    // What rounding has made of it grows in its own way.
    const double known = table_.invariant ? problem_.rounding_of_invariant(dt) * std::sqrt(probe.length / T)
                                          : known_by_reference(probe);
    const double error = std::max(0.0, probe.error - 2 * known),
                 early = std::max(0.0, probe.early - 2 * known);
    // Only the energy, and of a symplectic method, is kept within bounds.
    const bool bounded = problem_.options.observable.is_energy() && candidate.is_symplectic();
    const double power = early > 0 ? std::log(error / early) / std::log(4.0) : 0;
    double growth = grown(probe.length, std::clamp(power, 0.0, bounded ? 1.0 : 3.0));
    // What comes back with the motion may hide growth of its own size.
    if (!bounded) growth = std::max(growth, 1 + hidden_growth * (T / probe.length - 1));
    const double harder = candidate.setting.reversible
                              ? 1
                              : std::pow(std::min(harder_behind(probe.seen_to()), 1e3), candidate.order);
    // What rounding hides in the trial may be seen where it is harder: as a larger step tells.
    double hidden = 0;
    if (harder > 1 && error <= 2 * known)
      for (const auto& [step, seen] : candidate.trials)
        if (step > dt && seen.works() && seen.asked == probe.asked && seen.error > 4 * known)
          hidden = error_of(candidate, seen, step) * std::pow(dt / step, candidate.order);
    // Nor is what rounding hides nothing where a neighbouring orbit saw errors grow by far more behind.
    if (!table_.invariant)
      hidden = std::max(hidden, std::min(known, probe.error) * neighbour_.growth_from(probe.length) / 2);
    return std::max(error * growth * harder, hidden) +
           (table_.invariant ? problem_.rounding_of_invariant(dt) + drift_of(candidate, probe, dt, known)
                             : table_.rounding);
  }
  /// Whether the error of such a run goes on to grow.
  bool grows(const Candidate& candidate, const Probe& probe) const {
    return !problem_.options.observable.is_energy() ||
           (!candidate.is_symplectic() && probe.error > 1.4 * probe.early);
  }

  /// Whether steps go on to T as they were seen to before, and may be advised by that. What is not symplectic
  /// may become unstable, and reversible steps fail where their densities come to swing; where few of many
  /// equal ones fall into the hard places, errors differ from one passage to the next, and what a drive does
  /// but once is no passage. Nor is a motion that gets faster: errors grow by more than the order says where
  /// steps become long; nor where the observable is to be off by far more behind a trial.
  bool goes_on(const Candidate& candidate) const {
    const double most = timed ? 4 : problem_.options.observable.is_energy() ? 1000 : 100;
    return !problem_.options.whole && candidate.is_symplectic() && varies_ <= most &&
           scout_.speeds_up() <= much_faster && !scout_.errs_behind(table_.tried);
  }
  /// Whether the trial was a run of the whole, compared to its end: its last step may go beyond what is known
  /// of the observable, unless that is the energy.
  bool is_whole(const Probe& probe) const {
    const double compared =
        problem_.options.observable.is_energy() ? probe.length : std::min(probe.length, probe.seen_to());
    return !(compared < table_.time * (1 - 1e-12));
  }
  /// Whether what a trial saw holds to T, as far as a neighbouring orbit and its own error tell. What jumps
  /// behind it, beyond any power of the time, jumps with every method and step in its own way.
  bool lasts(const Candidate& candidate, const Probe& probe) const {
    if (is_whole(probe)) return true;
    const double known = 2 * known_by_reference(probe), seen = probe.seen_to();
    const bool is_fast = !table_.invariant && probe.error - known > much_in_trial * (probe.early + known),
               jumps = neighbour_.growth_from(seen) > much * std::pow(table_.time / seen, 2);
    return goes_on(candidate) && !scout_.errs_behind(seen) && looked_beside() && !jumps &&
           !(is_fast && probe.length < table_.time / 2);
  }

  /// How much harder it gets behind a trial. Where the race may go on to that, it need not be counted in
  /// full.
  SEMIEXPLICIT_COLD double harder_behind(double length) const {
    if (!(length < table_.time)) return 1;
    if (length != looked_from_) looked_from_ = length, harder_ = scout_.harder_than(length);
    return counts_harder_ ? harder_ : std::min(harder_, 1.3);
  }
  /// From now on that counts in full.
  void count_harder() { counts_harder_ = true; }
  /// Nothing was seen to T: what looked exponential up to there is taken for it.
  void believe_rate() {
    if (suspected_rate_ > 0) parts(suspected_rate_);
  }

 private:
  double loosest() const { return *std::max_element(table_.targets.begin(), table_.targets.end()); }
  double tightest() const { return *std::min_element(table_.targets.begin(), table_.targets.end()); }

  /// How well the reference knows the observable until there, in the unit of errors.
  double known_by_reference(const Probe& probe) const { return reference_.apart(probe.length) / table_.unit; }

  /// What the stopping rule of a projection, and rounding that has a sign, let an invariant drift behind a
  /// trial: as fast as in it, by no more than so many of these a step.
  double drift_of(const Candidate& candidate, const Probe& probe, double dt, double known) const {
    if (!candidate.is_symplectic() || probe.given_up) return 0;
    const double a_step = (candidate.projects() ? most_drift * StoppingRule{}.tolerance : 0) +
                          most_bias * problem_.epsilon,
                 left = table_.time - probe.length, most = a_step * problem_.judged.terms * left / dt;
    return std::min(most, std::max(0.0, probe.drift - known / 2) * 2 * left / probe.length);
  }

  /// What the reference is worth at T.
  SEMIEXPLICIT_COLD void judge_reference(double length) {
    if (!problem_.options.absolute) {
      const double size = length < table_.time ? size_at_end(length) : reference_.size();
      problem_.measure_in(size > 0 ? size : 1);
      table_.relative = size > 0;
    }
    const double unit = table_.unit, floor = problem_.epsilon * reference_.size() / unit;
    const auto apart = [&](double t) { return std::max(floor, reference_.apart(t) / unit); };
    // The first time at which the loosest target is lost, or the end.
    double end = length;
    for (const auto& sample : reference_.samples())
      if (sample.apart / unit > loosest() / 3) end = std::min(end, static_cast<double>(sample.t));
    const bool lost = end < length || apart(length) > loosest() / 3;
    // Exponential is what grows as much in each third, as far as a neighbouring orbit does not know better:
    // close passages make single jumps, and so do steps of another length.
    const double first = apart(end / 3), second = apart(2 * end / 3), last = apart(end);
    const double rate = std::log(last / first) / (2 * end / 3);
    const bool stays_near = neighbour_.time() > length && neighbour_.rate() == 0;
    const bool exponential = std::min(second / first, last / second) > much && !stays_near;
    const double power = std::log(apart(length) / apart(length / 4)) / std::log(4.0);
    note_growth(end);
    if (lost && exponential) parts(rate);
    suspected_rate_ = !lost && exponential ? rate : 0;
    // A random walk of the energy moves the phase by the power 3/2, and more where steps change; one in steps
    // that grow with what is rounded goes by half a power more than that.
    const double least = std::max(1.5, 0.5 + std::min(2.0, reference_.growth_of_terms()));
    const double most_power = suspected_rate_ > 0          ? 12.0
                              : reference_.changes_steps() ? std::max(2.0, least)
                                                           : least;
    table_.size = reference_.size() / unit;
    table_.reference_error = apart(length) * grown(length, std::clamp(power, least, most_power));
    table_.rounding = std::max(more_rounding * table_.reference_error, least_error());
    table_.reference_time = length;
  }

  /// ‖f‖ up to T, of which the coarse run knows more, but by no more than the reference lets expect: it may
  /// have left for where the orbit never comes, as over a saddle.
  SEMIEXPLICIT_COLD double size_at_end(double length) const {
    const double seen = reference_.size(), half = reference_.size_until(length / 2),
                 coarse = scout_.largest_at_end();
    if (!(half > 0)) return std::max(seen, coarse);
    const double power = std::min(std::log2(seen / half), 3.0);
    return std::clamp(coarse, seen, 2 * seen * std::pow(table_.time / length, power));
  }

  /// Whether neighbouring orbits were followed for long enough to tell chaos from a power of the time.
  bool looked_beside() const {
    const double least = neighbour_.is_regular() ? 0 : 0.5 * table_.time;
    return table_.invariant ||
           neighbour_.time() >= std::min(table_.time, std::max(least, enough_scales * table_.time_scale));
  }

  /// Neighbouring orbits part at that rate. Of an observable that grows as fast there is something left.
  void parts(double rate) {
    table_.parting_rate = rate;
    const double beside_size = rate - rate_of_size_;
    table_.horizon = beside_size > 0.1 * rate ? std::log(1 / problem_.epsilon) / beside_size
                                              : std::numeric_limits<double>::infinity();
  }
  /// Notes at which rate the observable grows where it does so exponentially, as that of an orbit that
  /// leaves.
  SEMIEXPLICIT_COLD void note_growth(double end) {
    const double first = reference_.size_until(end / 3), second = reference_.size_until(2 * end / 3),
                 last = reference_.size_until(end);
    const bool exponential = std::min(second / first, last / second) > 5;  // a power: less in the last third
    rate_of_size_ = exponential ? std::log(last / first) / (2 * end / 3) : 0;
  }

  /// By how much what grows with that power of the time, or as neighbouring orbits part, grows until T.
  double grown(double length, double power) const {
    const double by_power =
        std::max(std::pow(table_.time / length, power), neighbour_.growth_from(length) / 2);
    if (!(table_.parting_rate > 0)) return by_power;
    return std::max(by_power, std::exp(std::min(500.0, table_.parting_rate * (table_.time - length))));
  }

  static constexpr double much = 20;             ///< for a power of the time
  static constexpr double much_in_trial = 8;     ///< from a quarter of its length on
  static constexpr double most_drift = 30;       ///< 15 were seen of unlike units of q and p
  static constexpr double most_bias = 0.1;       ///< 0.02 were seen
  static constexpr double hidden_growth = 0.4;   ///< in a trial, of the error that it saw
  static constexpr double more_rounding = 2;     ///< than the reference's, whose steps are few
  static constexpr double much_faster = 1.1;     ///< steps finer by as much in the course of T
  static constexpr double enough_scales = 1000;  ///< that neighbouring orbits are to be followed

  Problem<Any>& problem_;
  CostTable& table_;
  const Scout<Any>& scout_;
  Reference<Any> reference_;
  Neighbour<Any> neighbour_;
  double varies_ = 1;          ///< how far paces differ along the way
  double suspected_rate_ = 0;  ///< at which neighbouring orbits may part
  double rate_of_size_ = 0;    ///< at which the observable itself grows
  double by_rounding_ = 0;     ///< see least_error(); in the unit of the observable
  mutable double looked_from_ = 0, harder_ = 1;
  bool counts_harder_ = false;
};

}  // namespace semiexplicit::detail
