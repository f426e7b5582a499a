#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/accuracy/any_hamiltonian.hpp>
#include <semiexplicit/accuracy/cost_options.hpp>
#include <semiexplicit/accuracy/right_gradient.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/median.hpp>

namespace semiexplicit::detail {

/// What an error that grows with a power of the time, or as neighbouring orbits part, is at the end of the
/// run that a table is about.
inline double error_at_the_end(const CostTable& table, double error, double length, double power) {
  const double stretch = std::max(1.0, table.time / length);
  if (table.parting_rate > 0)
    return error * std::exp(std::min(500.0, table.parting_rate * length * (stretch - 1)));
  return error * std::pow(stretch, power);
}

/// What the parts of the search share: the Hamiltonian, where it starts, what is measured and in which unit,
/// and the table that is being made.
template <class Any>
class Problem {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;
  using Options = CostOptionsOf<Scalar, Eigen::Dynamic>;
  using Value = Vector<Scalar, Eigen::Dynamic>;

  /// Throws std::invalid_argument for a start or a gradient that is wrong.
  SEMIEXPLICIT_COLD Problem(const Any& h, const State& z, double T, const Options& asked)
      : hamiltonian(h), z0(z), options(asked), limit(asked.max_gradients) {
    table.targets = options.targets;
    table.by = options.by;
    table.time = T;
    find_time_scale();
    check_gradient_and_energy();
    if (!options.observable.is_energy()) measure_first();
    table.rounding = rounding(table.time_scale);
  }

  /// The observable at z.
  void measure(const State& z, Value& value, bool of_energy = false) const {
    if (of_energy || options.observable.is_energy()) {
      value.resize(1);
      value[0] = hamiltonian.energy(z.q(), z.p());
    } else {
      value = options.observable(z);
      if (observable_size_ != 0 && value.size() != observable_size_)
        throw std::invalid_argument("cost_of_accuracy: options.observable gives a vector of " +
                                    std::to_string(value.size()) + " numbers, and of " +
                                    std::to_string(observable_size_) + " at z0; give one of a fixed size");
    }
  }
  Value measured(const State& z) const {
    Value value;
    measure(z, value);
    return value;
  }

  /// What rounding adds to the error of an invariant over the whole time: that of the states, which differ
  /// from the exact ones by an epsilon where the gradient is taken, step after step, and the noise of the
  /// observable.
  double rounding(double dt) const {
    const double epsilon = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
    return epsilon / 2 * judged.terms * std::sqrt(table.time / dt) + judged.noise;
  }

  /// The same where the observable is no invariant: the perturbations of all steps, as they have grown until
  /// the end. Those of short steps are less, as their sum is compensated.
  double rounding_of_orbit(double dt) const {
    const double epsilon = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());
    return epsilon * (along_the_slope * drifts_ * response_ / table.unit * std::sqrt(table.time / (3 * dt)) *
                          std::min(1.0, 3 * dt / table.time_scale) +
                      judged.terms);
  }
  /// The change of the observable at the end for one of the initial state by all of itself along the gradient
  /// of H, as far as it is linear.
  void responds(double response) { response_ = response; }

  /// The size of the energy's terms at z, in its unit.
  SEMIEXPLICIT_COLD double terms_of_energy(const State& z) const {
    return static_cast<double>(size_of_energy(z).terms) / energy.unit;
  }

  /// Makes errors of the observable relative to `unit`.
  void measure_in(double unit) {
    judged.terms *= judged.unit / unit;
    table.unit = judged.unit = unit;
  }

  /// Notes the size of the observable's terms at a later state of the orbit, and that of the velocities.
  void meet(const State& z) {
    met_.push_back(terms_at(z));
    const State velocity = velocity_at(z);
    met_q_.push_back(static_cast<double>(norm(velocity.q())));
    met_p_.push_back(static_cast<double>(norm(velocity.p())));
    size_q_.push_back(static_cast<double>(norm(z.q())));
    size_p_.push_back(static_cast<double>(norm(z.p())));
  }

  /// The vector field at z, for a gradient call.
  SEMIEXPLICIT_COLD State velocity_at(const State& z) {
    State velocity(z.dof());
    Vector<Scalar, Eigen::Dynamic> gq = z.q(), gp = z.p();
    hamiltonian.gradient(z.q(), z.p(), gq, gp);
    spend(1);
    velocity.q() = gp, velocity.p() = -gq;
    return velocity;
  }

  /// From now on q and p weigh the same in a time scale, by their usual velocities: in units in which one is
  /// far larger it does not hide the other. `h` is short beside the time scale at z0.
  SEMIEXPLICIT_COLD void weigh(double h) {
    if (met_q_.empty()) return;
    const double ratio = median(met_p_) / median(met_q_);
    if (!(ratio > 0 && std::isfinite(ratio))) return;
    weight_ = std::sqrt(ratio);
    table.time_scale = std::min(table.time, time_scale_at(z0, h));
  }

  /// Terms that grow along the way, to the time t, as where a coordinate winds or drifts, go on to grow.
  SEMIEXPLICIT_COLD void judge_growth_of_terms(double t) {
    if (met_.size() < 8) return;
    const Growth terms = growth_of(met_, t);
    const double later = terms.grows ? terms.last / std::sqrt(3.0) : terms.last;
    if (later > judged.terms && std::isfinite(later)) judged.terms = later;
    table.rounding = std::max(table.rounding, rounding(table.time_scale));
    // A coordinate that winds or drifts is rounded more and more, which turns the motion as much as it turns
    // while that far is gone.
    const auto turns = [](const Growth& far, const std::vector<double>& speed,
                          const std::vector<double>& change, const std::vector<double>& size) {
      return far.grows ? far.last / median(speed) * (median(change) / median(size)) / std::sqrt(10.0) : 0;
    };
    const double turned = std::max(turns(growth_of(size_q_, t), met_q_, met_p_, size_p_),
                                   turns(growth_of(size_p_, t), met_p_, met_q_, size_q_));
    if (turned > 1 && std::isfinite(turned)) drifts_ = turned;
  }

  /// z, which a coarse run came to, moved along the gradient to the energy of z0: other invariants, and those
  /// of a TimeTransformed, are only there what they are on the orbit.
  SEMIEXPLICIT_COLD State on_the_energy(State z) {
    for (int i = 0; i < 2 && left() > 1; ++i) {
      const State velocity = velocity_at(z);
      const Scalar size = norm(velocity.vector());
      const Scalar off =
          Scalar(hamiltonian.energy(z.q(), z.p())) - Scalar(hamiltonian.energy(z0.q(), z0.p()));
      const State from = z;
      z.q() += Scalar(off / size) * (velocity.p() / size);
      z.p() -= Scalar(off / size) * (velocity.q() / size);
      if (!all_finite(z.vector())) return from;
    }
    return z;
  }

  /// ‖X‖/‖dX/dt‖ at z, for two gradient calls: what it is in an Euler step of `h`.
  SEMIEXPLICIT_COLD double time_scale_at(const State& z, double h) {
    const State velocity = velocity_at(z);
    State moved = z;
    moved.vector() += Scalar(h) * velocity.vector();
    const State later = velocity_at(moved);
    const double change = weighed(later.q() - velocity.q(), later.p() - velocity.p());
    return change > 0 ? h * (weighed(velocity.q(), velocity.p()) / change)
                      : std::numeric_limits<double>::infinity();
  }

  /// One more gradient call, or several.
  void spend(double calls) { table.spent_gradients += calls; }
  double left() const { return limit - table.spent_gradients; }

  Any hamiltonian;
  State z0;
  Options options;
  CostTable table{};
  /// How a quantity is judged.
  struct Judged {
    double unit = 1, terms = 1, noise = 0;  ///< size of its terms, and its noise, in its unit
  };
  Judged energy{}, judged{};  ///< the energy, and the observable
  double limit;               ///< on gradient calls, at present

 private:
  /// ‖X‖/‖dX/dt‖ at z0, by an explicit Euler step that is just long enough to change X visibly. (‖z‖/‖X‖ says
  /// nothing near the origin, or far from it.)
  SEMIEXPLICIT_COLD void find_time_scale() {
    const State velocity = velocity_at(z0);
    const double speed = static_cast<double>(norm(velocity.vector()));
    if (!std::isfinite(speed))
      throw std::invalid_argument(
          "cost_of_accuracy: the gradient at z0 is NaN or Inf; give another initial state");
    if (speed == 0)
      throw std::invalid_argument(
          "cost_of_accuracy: nothing moves at z0, the gradient is zero; give another state");
    const double visible = 1e3 * std::sqrt(static_cast<double>(Eigen::NumTraits<Scalar>::epsilon()));
    table.time_scale = table.time;
    double h = std::min(table.time, visible * static_cast<double>(state_size(hamiltonian, z0)) / speed);
    if (!(h > 0)) h = visible * table.time * 1e-3;
    try {
      for (; h < table.time; h *= 10) {
        State moved = z0;
        moved.vector() += Scalar(h) * velocity.vector();
        const double change = static_cast<double>(norm(velocity_at(moved).vector() - velocity.vector()));
        if (!(change > visible * speed)) continue;
        if (std::isfinite(change)) table.time_scale = std::min(table.time, h * speed / change);
        break;
      }
    } catch (const std::exception&) {
      table.time_scale = h;  // outside of the domain
    }
  }

  double weighed(const auto& q, const auto& p) const {
    return std::hypot(weight_ * static_cast<double>(norm(q)), static_cast<double>(norm(p)) / weight_);
  }

  SEMIEXPLICIT_COLD void check_gradient_and_energy() {
    const Scalar first = hamiltonian.energy(z0.q(), z0.p());
    using std::isfinite;
    if (!isfinite(first))
      throw std::invalid_argument(
          "cost_of_accuracy: the energy at z0 is NaN or Inf; give another initial state");
    const Scalar noise = require_right_gradient("cost_of_accuracy", hamiltonian, z0, velocity_at(z0),
                                                table.time_scale, table.spent_gradients);
    energy = judge(size_of_energy(z0), options.absolute && options.observable.is_energy());
    if (isfinite(noise))
      energy.noise = 4 * static_cast<double>(noise) / energy.unit;  // a level, and the largest counts
    judged = energy;
  }

  SEMIEXPLICIT_COLD void measure_first() {
    const Value first = measured(z0);
    if (first.size() == 0 || !all_finite(first))
      throw std::invalid_argument(
          "cost_of_accuracy: options.observable is empty, NaN or Inf at z0; give a function that is finite");
    observable_size_ = first.size();
    judged = judge(size_of_observable(z0), options.absolute);
  }

  SEMIEXPLICIT_COLD Judged judge(const ReferenceSize<Scalar>& reference, bool absolute) {
    table.relative = reference.relative && !absolute;
    table.unit = absolute ? 1 : static_cast<double>(reference.size);
    const double terms = static_cast<double>(reference.terms) / table.unit;
    return {.unit = table.unit, .terms = table.relative ? std::max(1.0, terms) : terms};
  }

  SEMIEXPLICIT_COLD ReferenceSize<Scalar> size_of_energy(const State& z) const {
    return reference_size([this](const auto& q, const auto& p) { return Scalar(hamiltonian.energy(q, p)); },
                          Scalar(hamiltonian.energy(z.q(), z.p())), z);
  }
  /// The same for ‖f‖ as for a number.
  SEMIEXPLICIT_COLD ReferenceSize<Scalar> size_of_observable(const State& z) const {
    const auto size = [this](const auto& q, const auto& p) {
      State at(q.size());
      at.q() = q, at.p() = p;
      return Scalar(norm(measured(at)));
    };
    return reference_size(size, Scalar(norm(measured(z))), z);
  }
  double terms_at(const State& z) const {
    return static_cast<double>(size_of_observable(z).terms) / table.unit;
  }

  /// A perturbation of random direction, in one of the same size along the gradient of H: as measured.
  static constexpr double along_the_slope = 0.1;

  /// The last of what was met along the way to the time t; where that grows, what it comes to at T.
  struct Growth {
    double last;
    bool grows;
  };
  Growth growth_of(const std::vector<double>& met, double t) const {
    const auto quarter = static_cast<std::ptrdiff_t>(met.size() / 4);
    const double first = median<double>({met.begin(), met.begin() + quarter}),
                 last = median<double>({met.end() - quarter, met.end()});
    if (last > 2 * first) return {last * std::max(1.0, table.time / t), true};
    return {std::max(first, last), false};
  }

  std::vector<double> met_{}, met_q_{}, met_p_{}, size_q_{}, size_p_{};
  double weight_ = 1, response_ = 0;
  double drifts_ = 1;  ///< how much more rounding disturbs the motion where it drifts away
  Eigen::Index observable_size_ = 0;
};

}  // namespace semiexplicit::detail
