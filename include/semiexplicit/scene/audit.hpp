#pragma once

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/reference_size.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/scene/advised_flow.hpp>
#include <semiexplicit/scene/audit_report.hpp>
#include <semiexplicit/scene/runtime_scene.hpp>

namespace semiexplicit {

/// What trajectories are compared by.
enum class Compare {
  positions,  ///< q
  state       ///< q and p, as where both are coordinates (vortices, lattices)
};

/// How an audit is done.
template <class Scalar, int Dof>
struct AuditOptions {
  Scalar dt = Scalar(0);                   ///< the step of the runs; needed
  std::optional<Scheme<Scalar>> scheme{};  ///< else usual_scheme()
  int samples = 200;                       ///< how many times of the orbit are looked at
  Compare compare = Compare::positions;
  /// Bound on the gradient calls of all runs together, which is kept: an audit that needs more is refused, or
  /// given up. The timing of each effect comes on top: five times a call at every sample, and 5 ms at least.
  double max_gradients = 1e9;
  /// The scene without the effect of that name where others count it as there, as fields do that act through
  /// one |p - eA|²: they are made anew. Else RuntimeScene::without().
  std::function<RuntimeScene<Scalar, Dof>(const std::string&)> without{};
  /// Functions of (q, p) that the whole scene keeps, by name; the energy is always among them.
  std::vector<std::pair<std::string, std::function<Scalar(const In<Scalar, Dof>&, const In<Scalar, Dof>&)>>>
      invariants{};
};

namespace detail {

/// An audit at work: the runs and what is read off them.
template <class Scalar, int Dof>
class Auditor {
 public:
  using Chosen = RuntimeScene<Scalar, Dof>;
  using Any = AnyEffect<Scalar, Dof>;
  using State = PhasePoint<Scalar, Dof>;
  using Orbit = std::vector<State>;

  Auditor(Chosen scene, const State& z0, Scalar t_end, const AuditOptions<Scalar, Dof>& options)
      : scene_(std::move(scene)), z0_(z0), options_(options) {
    using std::abs;
    if (!valid_step(t_end) || !valid_step(options.dt) || options.samples < 1)
      throw std::invalid_argument(
          "audit: give a time T and options.dt that are finite and not zero, and samples > 0");
    detail::require_same_dof("audit", z0.dof(), "scene", scene_.dof());
    if (!(options.max_gradients > 0))
      throw std::invalid_argument(
          "audit: options.max_gradients is not positive; give a number of gradient calls");
    for (const auto& [name, value] : options.invariants)
      if (!value)
        throw std::invalid_argument("audit: the invariant " + name +
                                    " of options.invariants is empty; give it a function of (q, p)");
    const double steps = static_cast<double>(abs(t_end / options.dt));
    const double runs = 3 + static_cast<double>(scene_.effects().size());
    spent_ = 2 * (runs - 3) * (std::min<double>(options.samples, steps) + 2);  // to measure their sizes
    const double least =
        spent_ + steps * runs * (scene_.is_separable() ? 1.0 : static_cast<double>(scheme().kicks()));
    if (!(least <= options.max_gradients)) refuse_cost("at least " + in_words(least, 3));
    each_ = std::max<std::int64_t>(1, std::llround(steps / options.samples));
    blocks_ = std::max<std::int64_t>(1, std::llround(std::ceil(steps / static_cast<double>(each_) - 1e-9)));
    dt_ = t_end / Scalar(each_ * blocks_);
    invariants_ = options.invariants;
    invariants_.insert(invariants_.begin(), {"energy", [whole = scene_](const auto& q, const auto& p) {
                                               return whole.energy(q, p);
                                             }});
  }

  Audit operator()() {
    Audit audit;
    audit.t = static_cast<double>(dt_) * static_cast<double>(each_ * blocks_);
    audit.dt = static_cast<double>(dt_);
    for (const auto& [name, value] : invariants_) audit.invariants.push_back(name);
    const Orbit orbit = run(scene_, 1, OnFailure::raise);
    audit.noise = largest(distances(run(scene_, 2, OnFailure::raise), orbit));
    for (const auto& effect : scene_.effects()) {
      AuditRow row;
      row.name = effect.name();
      row.coupled = effect.coupled();
      measure_size(effect, orbit, row);
      leave_out(effect.name(), orbit, row);
      audit.rows.push_back(std::move(row));
    }
    double total = 0;
    for (std::size_t i = 0; i < audit.rows.size(); ++i)
      total += audit.rows[i].seconds = seconds_per_gradient(scene_.effects()[i], orbit);
    for (AuditRow& row : audit.rows) row.time_share = row.seconds / total;
    return audit;
  }

 private:
  /// The state at the times of the samples, with a step `finer` times smaller. All runs take the stepper that
  /// the whole scene needs: what is left of their errors is then alike and hardly enters the differences.
  /// Shorter where the run failed.
  Orbit run(const Chosen& scene, int finer, OnFailure on_failure) const {
    const auto along = [&](auto stepper) {
      Orbit orbit{z0_};
      State z = z0_;
      const double worst = static_cast<double>(stepper.max_gradients());
      for (std::int64_t i = 0; i < blocks_; ++i) {
        const auto affords = [&](const Scalar&, const State&, const IntegrationReport& so_far) {
          return spent_ + static_cast<double>(so_far.gradients) + worst <= options_.max_gradients;
        };
        const auto report = integrate(stepper, z,
                                      {.dt = dt_ / Scalar(finer),
                                       .steps = each_ * finer,
                                       .on_failure = on_failure,
                                       .t0 = Scalar(i * each_) * dt_},
                                      affords);
        spent_ += static_cast<double>(report.gradients);
        // The last step of all may leave too little for another one, which nobody wants.
        const bool over = i + 1 == blocks_ && report.steps == each_ * finer;
        if (report.status == Status::stopped && !over) refuse_cost(in_words(spent_ + worst, 3) + " and more");
        if (!report.ok() && !over) break;
        orbit.push_back(z);
      }
      return orbit;
    };
    if (scene_.is_separable()) return along(stepper_for(SeparableRuntimeScene<Scalar, Dof>(scene), scheme()));
    return along(stepper_for(scene, scheme()));
  }

  Scheme<Scalar> scheme() const {
    return options_.scheme ? *options_.scheme : usual_scheme<Scalar>(scene_.is_separable());
  }

  [[noreturn]] void refuse_cost(const std::string& needed) const {
    throw std::invalid_argument("audit: its runs take " + needed +
                                " gradient calls, and options.max_gradients is " +
                                in_words(options_.max_gradients, 3) +
                                "; give a larger options.dt, a shorter time, or raise options.max_gradients");
  }

  /// The length that orbits are compared by.
  Scalar distance(const State& z, const State& from) const {
    return options_.compare == Compare::positions ? norm(z.q() - from.q()) : norm(z.vector() - from.vector());
  }

  /// How far `other` is from `orbit` at each sample, in units of the orbit's largest distance from the
  /// origin.
  std::vector<double> distances(const Orbit& other, const Orbit& orbit) const {
    Scalar size(0);
    for (const State& z : orbit) size = std::max(size, distance(z, State(z.dof())));
    if (size == Scalar(0)) size = Scalar(1);
    std::vector<double> list;
    for (std::size_t i = 0; i < other.size(); ++i)
      list.push_back(static_cast<double>(distance(other[i], orbit[i]) / size));
    return list;
  }
  static double largest(const std::vector<double>& list) {
    return *std::max_element(list.begin(), list.end());
  }

  /// The effect's part of the gradient along the orbit.
  void measure_size(const Any& effect, const Orbit& orbit, AuditRow& row) const {
    State own(z0_.dof()), whole(z0_.dof());
    for (const State& z : orbit) {
      own.vector().setZero();
      Out<Scalar, Dof> by_q = own.q(), by_p = own.p();
      effect.add_gradient(z.q(), z.p(), by_q, by_p);
      detail::gradient_at(scene_, z.vector().data(), whole.vector().data(), z.dof());
      const double size = detail::part_of_gradient(own, whole);
      row.size_max = larger(row.size_max, size);
      row.size_mean += size / static_cast<double>(orbit.size());
    }
  }

  /// The best of a few measurements, of a millisecond each.
  double seconds_per_gradient(const Any& effect, const Orbit& orbit) const {
    using Clock = std::chrono::steady_clock;
    State sum(z0_.dof());
    Out<Scalar, Dof> by_q = sum.q(), by_p = sum.p();
    double best = 1e300;
    for (int batch = 0; batch < 5; ++batch) {
      std::int64_t calls = 0;
      const auto start = Clock::now();
      std::chrono::duration<double> passed{};
      do {
        effect.add_gradients(orbit, by_q, by_p);
        calls += static_cast<std::int64_t>(orbit.size());
        passed = Clock::now() - start;
      } while (passed.count() < 1e-3);
      best = std::min(best, passed.count() / static_cast<double>(calls));
    }
    return best;
  }

  void leave_out(const std::string& name, const Orbit& orbit, AuditRow& row) const {
    row.invariant_shift.assign(invariants_.size(), AuditRow::infinite);
    row.shift_max = row.shift_final = AuditRow::infinite;
    if (scene_.effects().size() == 1) return;
    const Chosen rest = options_.without ? options_.without(name) : scene_.without(name);
    detail::require_same_dof("audit: options.without", rest.dof(), "scene", scene_.dof());
    const Orbit other = run(rest, 1, OnFailure::stop);
    if (other.size() < orbit.size()) return;
    const auto apart = distances(other, orbit);
    row.shift_max = largest(apart);
    row.shift_final = apart.back();
    for (std::size_t k = 0; k < invariants_.size(); ++k)
      row.invariant_shift[k] = strays(invariants_[k].second, other);
  }

  /// How far a function goes from its first value, in units of what its errors are relative to.
  template <class Function>
  double strays(const Function& value, const Orbit& orbit) const {
    using std::abs;
    const Scalar first = value(z0_.q(), z0_.p());
    Scalar worst(0);
    for (const State& z : orbit) {
      const Scalar shift = abs(value(z.q(), z.p()) - first);
      if (!(shift <= worst)) worst = shift;
      if (worst != worst) break;  // NaN stays
    }
    return static_cast<double>(worst / reference_size(value, first, z0_).size);
  }

  Chosen scene_;
  const State& z0_;
  const AuditOptions<Scalar, Dof>& options_;
  decltype(AuditOptions<Scalar, Dof>::invariants) invariants_;
  std::int64_t each_ = 1, blocks_ = 1;
  Scalar dt_;
  mutable double spent_ = 0;  ///< gradient calls
};

}  // namespace detail

/// What each effect of the scene is worth from z0 over the time T: its share of the gradient's time, its size
/// along the orbit, and how far the orbit and the invariants move when it is left out (all else, also the
/// initial state, being equal). The numerical error of the runs themselves, from a run at half the step,
/// tells which of those distances mean anything.
///
///     const Audit report = audit(scene, z0, 100.0, {.dt = 0.002});
///     report.called_for(1e-6);  // names
///     std::cout << report;
///
/// Takes k + 3 runs for k effects, and 5 ms an effect to time it. Throws std::invalid_argument for nonsense
/// and where the runs take more than options.max_gradients, and IntegrationError where the whole scene itself
/// does not run.
template <class Scalar, int Dof>
Audit audit(const RuntimeScene<Scalar, Dof>& scene, const PhasePoint<Scalar, Dof>& z0,
            const std::type_identity_t<Scalar>& t_end,
            const std::type_identity_t<AuditOptions<Scalar, Dof>>& options) {
  return detail::Auditor<Scalar, Dof>(scene, z0, t_end, options)();
}
template <class... Effects>
Audit audit(const Scene<Effects...>& scene,
            const PhasePoint<typename Scene<Effects...>::Scalar, Scene<Effects...>::Dof>& z0,
            const typename Scene<Effects...>::Scalar& t_end,
            const AuditOptions<typename Scene<Effects...>::Scalar, Scene<Effects...>::Dof>& options) {
  Audit found = audit(RuntimeScene(scene), z0, t_end, options);
  std::array<double, sizeof...(Effects)> sizes{};
  for (std::size_t i = 0; i < sizes.size(); ++i) sizes[i] = found.rows[i].size_max;
  found.exact_flow = advised_flow(scene, sizes).value_or("");
  return found;
}

}  // namespace semiexplicit
