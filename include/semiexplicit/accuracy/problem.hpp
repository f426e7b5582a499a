#pragma once

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <semiexplicit/accuracy/any_hamiltonian.hpp>
#include <semiexplicit/accuracy/cost_options.hpp>
#include <semiexplicit/accuracy/right_gradient.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/reference_size.hpp>

namespace semiexplicit::detail {

/// What the parts of the search share: the Hamiltonian, where it starts, what is measured and in which unit,
/// the gradient calls that are left, and the table that is being made.
template <class Any>
class Problem {
 public:
  using Scalar = typename Any::Scalar;
  using State = typename Any::State;
  using Options = CostOptionsOf<Scalar, Eigen::Dynamic>;
  using Value = Vector<Scalar, Eigen::Dynamic>;
  /// Of times at which states are compared: an error of them is one of the observable.
  using Time = std::common_type_t<double, Scalar>;

  /// Throws std::invalid_argument for a start or a gradient that is wrong.
  SEMIEXPLICIT_COLD Problem(const Any& h, const State& z, double T, const Options& asked)
      : hamiltonian(h), z0(z), options(asked), limit(asked.max_gradients) {
    table.targets = options.targets;
    table.by = options.by;
    table.time = T;
    table.invariant = options.observable.is_energy();
    find_time_scale();
    const Scalar noise = check_gradient_and_energy();
    measure(z0, first);
    if (first.size() == 0 || !all_finite(first))
      throw std::invalid_argument(
          "cost_of_accuracy: options.observable is empty, NaN or Inf at z0; give a function that is finite");
    judge_by_first();
    // A level, and the largest counts.
    if (table.invariant && std::isfinite(static_cast<double>(noise)))
      judged.noise = 4 * static_cast<double>(noise) / judged.unit;
    table.rounding = rounding_of_invariant(table.time_scale);
  }

  /// The observable at z.
  void measure(const State& z, Value& value) const {
    if (options.observable.is_energy()) {
      value.resize(1);
      value[0] = hamiltonian.energy(z.q(), z.p());
      return;
    }
    value = options.observable(z);
    if (first.size() != 0 && value.size() != first.size())
      throw std::invalid_argument("cost_of_accuracy: options.observable gives a vector of " +
                                  std::to_string(value.size()) + " numbers, and of " +
                                  std::to_string(first.size()) + " at z0; give one of a fixed size");
  }

  /// About the size of the terms that the observable at z is a sum of.
  SEMIEXPLICIT_COLD double terms_at(const State& z) const { return static_cast<double>(size_at(z).terms); }

  /// How far the observable at z moves when z is rounded.
  SEMIEXPLICIT_COLD double rounding_at(const State& z) const {
    Value value, moved;
    measure(z, value);
    const auto distance = [&](const State& near) {
      measure(near, moved);
      return Scalar(norm(moved - value));
    };
    return when_rounded(z, distance);
  }
  /// The largest distance(near) of a z that is rounded: half that of points by one to two units beside it.
  static double when_rounded(const State& z, const auto& distance) {
    return static_cast<double>(largest_beside(z, Scalar(2 * epsilon), distance)) / 2;
  }

  /// Whether the energy at z is that at z0, up to that part of its terms: where a fast motion that the
  /// observable does not show has become unstable it is nothing like it.
  SEMIEXPLICIT_COLD bool keeps_energy(const State& z, double part = 0.1) const {
    const double off = energy_off(z);
    return off <= part * first_energy_size_ ||
           off <= part * size_of_energy(hamiltonian.energy(z.q(), z.p()), z);
  }
  /// By how much the energy at z differs from that at z0.
  double energy_off(const State& z) const {
    return std::abs(static_cast<double>(hamiltonian.energy(z.q(), z.p()) - first_energy_));
  }
  /// The size of the energy at z0, or of its terms.
  double energy_size() const { return first_energy_size_; }

  /// What rounding adds to the error of an invariant over the whole time by steps of dt: that of the states,
  /// which differ from the exact ones by an epsilon where the gradient is taken, step after step, and the
  /// noise of the observable.
  double rounding_of_invariant(double dt) const {
    return epsilon / 2 * judged.terms * std::sqrt(table.time / dt) + judged.noise;
  }

  /// A relative error as it is, an absolute one, which may be in any units, in the size of the terms.
  double in_terms(double error) const {
    return table.relative || !(judged.terms > 0) ? error : error / judged.terms;
  }

  /// Makes errors of the observable relative to `unit`.
  void measure_in(double unit) {
    judged.terms *= judged.unit / unit;
    table.unit = judged.unit = unit;
  }
  /// Makes them relative to the first value, or absolute by request or where that is zero up to rounding.
  SEMIEXPLICIT_COLD void judge_by_first() {
    const ReferenceSize<Scalar> size = size_at(z0);
    table.relative = size.relative && !options.absolute;
    table.unit = judged.unit = options.absolute ? 1 : static_cast<double>(size.size);
    // Of a value that does not show what rounds it, a large constant in it, say: the value.
    judged.terms = std::max(static_cast<double>(size.terms), static_cast<double>(norm(first))) / judged.unit;
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

  /// Some gradient calls more.
  void spend(double calls) { table.spent_gradients += calls; }
  double left() const { return limit - table.spent_gradients; }

  static constexpr double epsilon = static_cast<double>(Eigen::NumTraits<Scalar>::epsilon());

  Any hamiltonian;
  State z0, first_velocity{};  ///< of the motion at z0
  Options options;
  CostTable table{};
  Value first{};  ///< the observable at z0
  /// How it is judged.
  struct {
    double unit = 1, terms = 1, noise = 0;  ///< size of its terms, and its noise, in its unit
  } judged{};
  double limit;  ///< on gradient calls, at present

 private:
  /// ‖X‖/‖dX/dt‖ at z0, by an explicit Euler step that is just long enough to change X visibly. (‖z‖/‖X‖ says
  /// nothing near the origin, or far from it.)
  SEMIEXPLICIT_COLD void find_time_scale() {
    first_velocity = velocity_at(z0);
    const double speed = static_cast<double>(norm(first_velocity.vector()));
    if (!std::isfinite(speed))
      throw std::invalid_argument(
          "cost_of_accuracy: the gradient at z0 is NaN or Inf; give another initial state");
    if (speed == 0)
      throw std::invalid_argument(
          "cost_of_accuracy: nothing moves at z0, the gradient is zero; give another state");
    const double visible = 1e3 * std::sqrt(epsilon);
    table.time_scale = table.time;
    double h = std::min(table.time, visible * static_cast<double>(state_size(hamiltonian, z0)) / speed);
    if (!(h > 0)) h = visible * table.time * 1e-3;
    const auto change_after = [&](double time) {
      State moved = z0;
      moved.vector() += Scalar(time) * first_velocity.vector();
      return static_cast<double>(norm(velocity_at(moved).vector() - first_velocity.vector()));
    };
    try {
      for (; h < table.time; h *= 10) {
        const double change = change_after(h);
        if (!(change > visible * speed)) continue;
        // A jump of a force is as large after a longer time.
        if (3 * h < table.time && change_after(3 * h) < 1.5 * change) continue;
        if (std::isfinite(change)) table.time_scale = std::min(table.time, h * speed / change);
        break;
      }
    } catch (const std::exception&) {
      table.time_scale = h;  // outside of the domain
    }
  }

  /// Returns the noise of the energy.
  SEMIEXPLICIT_COLD Scalar check_gradient_and_energy() {
    using std::isfinite;
    first_energy_ = hamiltonian.energy(z0.q(), z0.p());
    if (!isfinite(first_energy_))
      throw std::invalid_argument(
          "cost_of_accuracy: the energy at z0 is NaN or Inf; give another initial state");
    first_energy_size_ = size_of_energy(first_energy_, z0);
    return require_right_gradient("cost_of_accuracy", hamiltonian, z0, velocity_at(z0), table.time_scale,
                                  table.spent_gradients);
  }

  /// The energy at z, or the terms that it is a sum of, whichever is larger.
  SEMIEXPLICIT_COLD double size_of_energy(const Scalar& value, const State& z) const {
    const auto energy = [this](const auto& q, const auto& p) { return Scalar(hamiltonian.energy(q, p)); };
    return std::max(std::abs(static_cast<double>(value)),
                    static_cast<double>(reference_size(energy, value, z).terms));
  }

  /// Of ‖f‖ as of a number.
  SEMIEXPLICIT_COLD ReferenceSize<Scalar> size_at(const State& z) const {
    Value value;
    const auto size = [&](const auto& q, const auto& p) {
      State at(q.size());
      at.q() = q, at.p() = p;
      measure(at, value);
      return Scalar(norm(value));
    };
    return reference_size(size, size(z.q(), z.p()), z);
  }

  Scalar first_energy_{};
  double first_energy_size_ = 0;
};

}  // namespace semiexplicit::detail
