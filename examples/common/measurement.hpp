#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <semiexplicit/checkpoint.hpp>

#include "output.hpp"
#include "run.hpp"

namespace examples {

/// A number that a measurement has found, so far.
struct Figure {
  std::string name;
  double value = 0;
  double uncertain = 0;  ///< by how it is measured, whatever the trajectory; not finite: it cannot be
  std::string beside{};  ///< what is to be known of it; of `expected` what that is
  std::optional<double> expected{};  ///< by a closed form or an estimate
  std::string missing{};             ///< why there is none; empty where there is one
  /// Of a figure that swings, what it is a quarter of a period later: either of them may pass by the true one
  /// with no error of its own, and has that of both.
  std::optional<double> quarter_later{};
};

/// A figure beside what a formula gives, or alone where a reason is `off` why the formula does not hold.
inline Figure compared(const std::string& name, double value, double uncertain, const std::string& formula,
                       double expected, const std::string& off = "") {
  if (off.empty()) return {name, value, uncertain, formula, expected};
  return {name, value, uncertain, "no closed form, " + off};
}
inline Figure not_measured(const std::string& name, const std::string& why) {
  return {.name = name, .missing = why};
}

/// "what: not measured, why".
inline void print_none(std::ostream& out, const std::string& what, const std::string& why) {
  out << what << ": not measured, " << why << '\n';
}

/// Why no companion tells the error of a figure.
inline std::string no_error(const Run& run) {
  if (run.companion && !run.companion_parted)
    return "a companion run of half the step has none; give a smaller --dt, or more --time";
  return run.companion
             ? formatted("a companion run of half the step parts from it before t = %.3g",
                         *run.companion_parted) +
                   "; give a smaller --dt, or less --time where the motion is chaotic"
             : "no companion run with --method " + run.method.name + " tells its error; give another";
}

/// A line "what: measured ± error; reference: expected (difference)", which is absolute where 0 is expected.
/// A figure whose error no companion tells is none.
inline void print_figure(std::ostream& out, const Figure& figure, const Run& run) {
  if (!figure.missing.empty()) return print_none(out, figure.name, figure.missing);
  if (!std::isfinite(figure.uncertain))
    return print_none(out, figure.name, "the run has too few steps; give a smaller --dt");
  const auto error = run.figure_error(figure.name);
  if (!error) return print_none(out, figure.name, no_error(run));
  out << figure.name << ": " << with_uncertainty(figure.value, error->all());
  if (!figure.beside.empty()) out << "; " << figure.beside;
  if (figure.expected)
    out << ": "
        << formatted(*figure.expected == 0 ? "%.8g (difference %.1e)" : "%.8g (relative difference %.1e)",
                     *figure.expected,
                     std::abs(*figure.expected == 0 ? figure.value : figure.value / *figure.expected - 1));
  out << '\n';
}

/// Looks on at a run and says something about it at the end.
template <int Dof>
struct Measurement {
  static constexpr const char* name = "Measurement";

  std::function<void(double t, const In<double, Dof>& q, const In<double, Dof>& p)> observe{};
  std::function<void(CheckpointMemory&)> memory{};  ///< of what it has seen; see CheckpointMemory
  /// Its figures so far: they get an error by a companion run, which needs a second measurement.
  std::function<std::vector<Figure>(const Run&)> figures{};
  std::function<void(std::ostream&, const Run&)> report{};  ///< instead of the figures; optional
  std::function<std::string()> heading{};                   ///< before them; optional
  std::function<std::string()> ending{};  ///< why a run ended early, where the motion tells; optional
  std::function<std::string()> doubt{};   ///< why a run that came to its end means nothing; optional

  template <class State>
  void operator()(double t, const State& z) const {
    if (observe) observe(t, z.q(), z.p());
  }
  template <class List>
  void describe(List&) const {}
  void visit_memory(CheckpointMemory& visit) const {
    if (memory) memory(visit);
  }

  /// Puts why a run is no result in place of its failure, where the motion tells.
  void explain(Run& run) const {
    if (run.is_result() || !ending) return;
    if (const std::string why = ending(); !why.empty())
      run.failure = formatted("ended at t = %.4g: ", run.report.t) + why;
  }
  /// Nothing is said of a run that is no result.
  void print(std::ostream& out, const Run& run) const {
    if (!report && !figures) return;
    if (!run.is_result()) {
      out << "nothing else is measured, as the run is no result; see the end of it\n";
      return;
    }
    if (figures) return tell(out, run);
    const double energy = run.quantities.front().worst;
    if (!(energy <= 1e-2)) {
      out << formatted("nothing else is measured, as the energy is off by %.1g of itself; ", energy)
          << "give a smaller --dt, or another method\n";
      return;
    }
    tell(out, run);
  }
  void tell(std::ostream& out, const Run& run) const {
    if (heading) out << heading();
    if (report) return report(out, run);
    if (!figures) return;
    for (const Figure& figure : figures(run)) print_figure(out, figure, run);
  }
};

/// Gives the figures of a run an error, by a measurement of a companion, whose states it is shown; see
/// with_error_estimate().
template <int Dof>
class FigureErrors {
 public:
  static constexpr const char* name = "FigureErrors";

  FigureErrors(const Measurement<Dof>& of_run, Measurement<Dof> of_companion)
      : of_run_(of_run), of_companion_(std::move(of_companion)) {}

  bool wanted() const { return of_run_.figures && of_companion_.figures; }

  void operator()(double t, const PhasePoint<double, Dof>& z) const { of_companion_(t, z); }
  template <class List>
  void describe(List&) const {}
  void visit_memory(CheckpointMemory& visit) const { of_companion_.visit_memory(visit); }

  /// Puts the errors into the run, of those figures that both have; none where the two have parted.
  template <class Estimate>
  void conclude(const Estimate& estimate, Run& run) const {
    run.companion = true;
    run.companion_parted = estimate.parted_at();
    const std::vector<Figure> others = of_companion_.figures(run);
    for (const Figure& one : of_run_.figures(run))
      for (const Figure& other : others)
        if (one.name == other.name && one.missing.empty() && other.missing.empty())
          if (const auto error = estimate.error_of(one.value, other.value)) {
            const auto later = one.quarter_later && other.quarter_later
                                   ? estimate.error_of(*one.quarter_later, *other.quarter_later)
                                   : std::nullopt;
            run.figure_errors[one.name] = {std::hypot(*error, later.value_or(0)), one.uncertain};
          }
  }

 private:
  const Measurement<Dof>& of_run_;
  Measurement<Dof> of_companion_;
};

/// The memory of a measurement that has it in `seen`.
template <class Seen>
auto memory_of(const std::shared_ptr<Seen>& seen) {
  return [seen](CheckpointMemory& visit) { seen->visit_memory(visit); };
}

/// Why nothing is measured of a motion that is sampled too coarsely; empty where it is not. `angle`: the
/// largest from one step to the next.
inline std::string too_coarse(double angle, double limit = std::acos(-1.0) / 4) {
  if (angle < limit) return "";
  return formatted("it turns by up to %.0f degrees in a step; ", angle * 180 / std::acos(-1.0)) +
         formatted("give a --dt %.0f times smaller", std::ceil(angle / limit) + 1);
}

/// Between two vectors in space, in radians; 0 where one of them is zero.
inline double angle_between(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  const double along = a.dot(b);  // of zeros -0, which is on the other side
  return std::atan2(a.cross(b).norm(), along == 0 ? 0.0 : along);
}

/// From a to b, both nearly across the axis, in radians.
inline double angle_about(const Eigen::Vector3d& axis, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(axis.normalized().dot(a.cross(b)), a.dot(b));
}

/// Where the first of some values goes up through zero: by the cubic through the two steps before it and the
/// two after it, at the start the three after it.
template <int N>
class Crossing {
 public:
  using Values = Eigen::Matrix<double, N, 1>;
  struct Place {
    double t = 0;
    Values values = Values::Zero();
  };

  /// Takes the next step; is a crossing known by it?
  bool see(double t, const Values& values) {
    std::shift_left(steps_.begin(), steps_.end(), 1);
    steps_.back() = {t, values};
    if (++seen_ < 4) return false;
    for (const std::size_t i : {0U, 1U})
      if ((i == 1 || seen_ == 4) && steps_[i].values[0] < 0 && steps_[i + 1].values[0] >= 0) {
        place_ = crossing(i, 0, 4);
        by_parabolas_ = {crossing(i, 0, 3), crossing(i, 1, 3)};
        return true;
      }
    return false;
  }
  /// The last one.
  const Place& place() const { return place_; }
  /// The largest distance of that from where the parabolas through three of the steps have it, which are
  /// worse by an order.
  template <class Distance>
  double uncertain(const Distance& distance) const {
    return std::max(std::abs(distance(place_, by_parabolas_[0])),
                    std::abs(distance(place_, by_parabolas_[1])));
  }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    for (Place& step : steps_) visit(step.t), visit(step.values);
  }

 private:
  /// By the polynomial through `count` of the steps, between the steps i and i + 1.
  Place crossing(std::size_t i, std::size_t first, std::size_t count) const {
    double low = steps_[i].t, high = steps_[i + 1].t, t = low;
    Values values = steps_[i].values;
    for (int n = 0; n < 60; ++n) {
      t = (low + high) / 2;
      values.setZero();
      for (std::size_t j = first; j < first + count; ++j) {
        double weight = 1;
        for (std::size_t k = first; k < first + count; ++k)
          if (k != j) weight *= (t - steps_[k].t) / (steps_[j].t - steps_[k].t);
        values += weight * steps_[j].values;
      }
      (values[0] < 0 ? low : high) = t;
    }
    return {t, values};
  }

  std::int64_t seen_ = 0;
  std::array<Place, 4> steps_{};
  Place place_{};
  std::array<Place, 2> by_parabolas_{};
};

/// Follows how a point turns about the origin of a plane.
class Turning {
 public:
  void see(double t, double x, double y) {
    const double angle = std::atan2(y, x);
    if (seen_ == 0) {
      start_ = t;
    } else {
      const double turn = std::remainder(angle - last_, 2 * std::acos(-1.0));
      turned_ += turn;
      largest_ = std::max(largest_, std::abs(turn));
      longest_ = std::max(longest_, std::abs(t - now_));
    }
    last_ = angle;
    now_ = t;
    const double radius = std::hypot(x, y);
    radii_ += radius;
    farthest_ = std::max(farthest_, radius);
    ++seen_;
  }
  double turned() const { return turned_; }
  /// The largest turn from one step to the next.
  double largest() const { return largest_; }
  /// The same where it turns by about `rate`, which tells nearly a whole turn from a small one backwards.
  double largest(double rate) const { return std::max(largest_, std::abs(rate) * longest_); }
  /// Radians a unit of time, counterclockwise.
  double rate() const { return turned_ / (now_ - start_); }
  double mean_radius() const { return radii_ / static_cast<double>(seen_); }
  double farthest() const { return farthest_; }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    for (double* number : {&start_, &now_, &last_, &turned_, &radii_, &farthest_, &largest_, &longest_})
      visit(*number);
  }

 private:
  std::int64_t seen_ = 0;
  double start_ = 0, now_ = 0, last_ = 0, turned_ = 0, radii_ = 0, farthest_ = 0, largest_ = 0, longest_ = 0;
};

/// The largest value of what is seen at steps of one size: the top of the parabola through three of them.
class Largest {
 public:
  void see(double value) {
    value_ = std::max(value_, value);
    const double before = std::exchange(ahead_, -INFINITY);
    bool seen_again = false;
    const double earlier = recent_[3], last = recent_[4];
    if (const double bend = earlier - 2 * last + value; seen_ >= 2 && bend < 0) {
      const double place = (earlier - value) / (2 * bend),  // in steps from the middle one
          over = -bend * place * place / 2, top = last + over;
      seen_again = place < 0 && place >= -1 && before > -INFINITY;
      const double differs = seen_again ? std::abs(top - before) : 0;  // it may be as far from both
      if (seen_again) possible_ = std::max(possible_, before + differs);
      // It is between the middle one and a neighbour, and seen from there again, but for the ends of the run.
      if (std::abs(place) <= 0.5) offer({top, top + std::max(over - bend / 100, differs)});
      if (place > 0 && place <= 1) ahead_ = top;
    }
    if (!seen_again) possible_ = std::max(possible_, before);
    std::shift_left(recent_.begin(), recent_.end(), 1);
    recent_.back() = value;
    if (++seen_ == 5) offer(in_first_step(recent_));
  }
  double value() const { return std::max(value_, ended().top); }
  /// What the steps leave open: of the largest one, and whether another one is larger. Not finite where they
  /// are too few to tell.
  double uncertain() const {
    if (seen_ < 5) return INFINITY;
    return std::max(0.0, std::max(possible_, ended().possible) - value());
  }

  void visit_memory(CheckpointMemory& visit) {
    visit(seen_);
    for (double* number : {&value_, &possible_, &ahead_}) visit(*number);
    for (double& value : recent_) visit(value);
  }

 private:
  struct Top {
    double top, possible;
  };
  void offer(const Top& found) {
    value_ = std::max(value_, found.top);
    possible_ = std::max(possible_, found.possible);
  }
  Top ended() const {
    if (seen_ < 5) return {-INFINITY, -INFINITY};
    auto backwards = recent_;
    std::reverse(backwards.begin(), backwards.end());
    return in_first_step(backwards);
  }
  /// Of five values, between the first two, beside which there is nothing: by the parabola through three of
  /// them, and by what the others may make of that.
  static Top in_first_step(const std::array<double, 5>& f) {
    std::array<double, 5> differences = f;  // of order k, at the first value
    for (std::size_t k = 1; k < 5; ++k)
      for (std::size_t i = 4; i >= k; --i) differences[i] -= differences[i - 1];
    const double skew = std::max(std::abs(differences[3]), std::abs(differences[3] + differences[4]));
    Top found{std::max(f[0], f[1]), -INFINITY};
    for (int i = 1; i < 64; ++i) {
      const double x = i / 64.0, second = x * (x - 1) / 2, third = second * (x - 2) / 3,
                   fourth = third * (x - 3) / 4;
      const double parabola = f[0] + x * differences[1] + second * differences[2];
      found.top = std::max(found.top, parabola);
      found.possible = std::max({found.possible, parabola + 3 * third * skew,
                                 parabola + third * differences[3] + fourth * differences[4] +
                                     2 * std::abs(fourth * differences[4])});
    }
    found.possible = std::max(found.possible, found.top - differences[2] / 1e4);
    return found;
  }

  std::int64_t seen_ = 0;
  double value_ = -INFINITY, possible_ = -INFINITY;  ///< so far, and what it may be at most
  std::array<double, 5> recent_{};
  /// The top that the last three have between the last two of them.
  double ahead_ = -INFINITY;
};

}  // namespace examples
