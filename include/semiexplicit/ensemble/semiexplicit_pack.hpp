#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/core/two_sum.hpp>
#include <semiexplicit/ensemble/pack_point.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>

namespace semiexplicit {

/// Semiexplicit with simplified Newton for a pack of phase points, one in each lane of the SIMD registers, in
/// lockstep. A sweep goes over all lanes; each lane stops for itself and gets its own report. One that has
/// converged waits for the others with its result at rest; one that fails keeps its state, and the others go
/// on. No lane's result depends on the others.
///
/// Each lane takes the step that Semiexplicit takes: the same operations in the same order. Where the
/// gradients agree to the bit and the compiler does not contract products and sums (-ffp-contract=off) the
/// results agree to the bit, too; else to rounding. Memory: seven arrays of 2d packs at most, and two for the
/// state.
template <class H>
class SemiexplicitPack {
  static_assert(
      PackHamiltonian<H>,
      "SemiexplicitPack needs a gradient that takes packs; see PackHamiltonian in ensemble/pack_point.hpp");
  static_assert(detail::is_hamiltonian<H>());
  static_assert(detail::is_in_one_process<H>());

 public:
  static constexpr int Dof = H::Dof;
  using State = PackPoint<Dof>;

  /// Throws std::invalid_argument, saying what is wrong, unless the scheme passes its own check and the
  /// solver's options make sense.
  SemiexplicitPack(H hamiltonian, Scheme<double> scheme, SimplifiedNewton solver = {})
      : SemiexplicitPack(std::move(hamiltonian), std::move(scheme), solver, Checked{}) {
    scheme_.check();
  }

  /// The same scheme and solver with another Hamiltonian.
  SemiexplicitPack with(H hamiltonian) const {
    return SemiexplicitPack(std::move(hamiltonian), scheme_, solver_, Checked{});
  }

  /// One step of size dt, which may be negative, of the lanes that are `wanted`; the point in another lane,
  /// or in one whose report is not ok(), is untouched. So are all where a gradient throws. No heap use. The
  /// reports count what the lane by itself would have taken.
  PackReport step(State& state, double dt, const LaneChoice& wanted = all_lanes()) {
    PackReport report{};
    const Status start = detail::status_at_start(dt, !scheme_.b.empty(), state.z.size() == f_.size());
    if (start != Status::success) return failed(report, start);
    const Mask in_play(wanted.data(), detail::unaligned);
    const Many size_z = state_size(state);
    Many e = detail::call_inlined([&] { return sweep(state.z.data(), nullptr, dt); });
    Mask ok = in_play;
    const Many distance = distance_moved();
    if (all_of(accepted(e, 0.0, size_or_moves(size_z, distance)) || !in_play)) {
      for (std::size_t k = 0; k < Many::size(); ++k) {
        report[k].evaluations = 1;
        report[k].gradients = gradients();
        report[k].correction = e[k];
      }
    } else {
      ok = iterate(state, dt, in_play, size_z, e, distance, report);
    }
    finish(state, ok, report);
    return report;
  }

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<double>& scheme() const { return scheme_; }
  const SimplifiedNewton& solver() const { return solver_; }

 private:
  using Many = detail::Many;
  using Mask = detail::LaneMask;
  using Column = std::vector<Many>;
  struct Checked {};

  SemiexplicitPack(H hamiltonian, Scheme<double> scheme, SimplifiedNewton solver, Checked)
      : hamiltonian_(std::move(hamiltonian)),
        scheme_(std::move(scheme)),
        solver_(solver),
        f_(size(), Many(0.0)),
        moved_(f_),
        m_(f_),
        kept_(f_) {
    detail::require_options(SimplifiedNewton::name, solver.stop, solver.max_iterations);
    if constexpr (!detail::fits_on_stack(Dof)) a_ = b_ = gradient_ = f_;
  }

  /// detail::state_size() in every lane.
  Many state_size(const State& state) const {
    const Many* const z = state.z.data();
    if constexpr (InExtendedPhaseSpace<H>) {
      const Many halves[2] = {detail::norm(z, dof() - 1), detail::norm(z + dof(), dof() - 1)};
      return detail::norm(halves, 2);
    } else {
      return detail::norm(z, length());
    }
  }

  Eigen::Index length() const { return 2 * dof(); }
  std::size_t size() const { return static_cast<std::size_t>(length()); }
  std::int64_t gradients() const { return static_cast<std::int64_t>(scheme_.kicks()); }

  static PackReport failed(PackReport& report, Status status) {
    for (StepReport& lane : report) lane.status = status;
    return report;
  }

  /// StoppingRule::accepts() in every lane.
  Mask accepted(const Many& e, const Many& size_m, const Many& size_z) const {
    const Many bound = solver_.stop.tolerance;
    if (solver_.stop.kind == StoppingRule::Kind::paper) return e < bound;
    return e == 0.0 || (e / size_z) * ((size_m + e) / size_z) <= bound;
  }

  /// All kicks from a = z + m, b = z - m (m = 0 where none is given); f_ becomes the residual and moved_ what
  /// both copies moved together. Gives ‖f‖/4.
  Many sweep(const Many* z, const Many* m, double dt) {
    if constexpr (detail::fits_on_stack(Dof)) {
      constexpr auto length = std::size_t(2 * Dof);
      Many a[length], b[length], gradient[length], moved[length], f[length];
      const Many e = residual(z, m, dt, a, b, gradient, moved, f, Dof);
      for (int i = 0; i < 2 * Dof; ++i) {
        f_[std::size_t(i)] = f[i];
        moved_[std::size_t(i)] = moved[i];
      }
      return e;
    } else {
      return residual(z, m, dt, a_.data(), b_.data(), gradient_.data(), moved_.data(), f_.data(), dof());
    }
  }

  Many residual(const Many* z, const Many* m, double dt, Many* a, Many* b, Many* gradient, Many* moved,
                Many* f, Eigen::Index d) const {
    detail::projection_residual(hamiltonian_, scheme_, dt, true, z, m, a, b, gradient, moved, f, d);
    if constexpr (InExtendedPhaseSpace<H>)
      for (const Eigen::Index last : {d - 1, 2 * d - 1})
        detail::assign(detail::needs_no_solving<H>(f[last], z[last], scheme_.kicks()), f[last], 0.0);
    return detail::norm(f, 2 * d) / 4.0;
  }

  /// What Convergence asks of a residual, in one lane.
  struct LaneResidual {
    const SemiexplicitPack& pack;
    const Column& z;
    std::size_t lane;
    double state, full, distance;
    double state_size() const { return state; }
    double farthest() const { return detail::farthest(state, distance, rounding_level()); }
    double rounding_level() const { return 100 * Eigen::NumTraits<double>::epsilon() * (full + distance); }
    bool within_rounding(double multiple) const {
      for (std::size_t i = 0; i < z.size(); ++i) {
        const double f = pack.f_[i][lane], at = z[i][lane];
        if (!detail::within_rounding(&f, &at, 1, distance, multiple)) return false;
      }
      return true;
    }
  };

  /// Semiexplicit's state_size() after a sweep, where both copies moved by twice `distance`.
  static Many size_or_moves(const Many& size_z, const Many& distance) {
    const Many moves = StoppingRule::moves * distance;
    Many smaller = size_z;
    detail::assign(moves < size_z, smaller, moves);
    return smaller;
  }

  /// How far the mean of the copies moved.
  Many distance_moved() const { return detail::norm(moved_.data(), length()) / 2.0; }

  /// Goes on from the first evaluation, whose corrections are e and whose moves `distance`; gives the lanes
  /// that came to a good end.
  Mask iterate(const State& state, double dt, const Mask& in_play, const Many& size_z, Many e, Many distance,
               PackReport& report) {
    std::array<std::optional<detail::Convergence<double>>, Many::size()> lanes;
    for (auto& lane : lanes) lane = solver_.template convergence<double>();
    Mask going = in_play;
    Many size_m = 0.0;
    std::fill(m_.begin(), m_.end(), Many(0.0));
    for (;;) {
      const Many sizes = size_or_moves(size_z, distance);
      for (std::size_t k = 0; k < Many::size(); ++k)
        if (going[k])
          going[k] = !lanes[k]->done(e[k], size_m[k],
                                     LaneResidual{*this, state.z, k, sizes[k], size_z[k], distance[k]});
      if (none_of(going)) break;
      // All multipliers move on; lanes that are done keep their moves of the copies.
      for (std::size_t i = 0; i < size(); ++i) m_[i] -= f_[i] / 4.0;
      std::copy(moved_.begin(), moved_.end(), kept_.begin());
      e = detail::call_inlined([&] { return sweep(state.z.data(), m_.data(), dt); });
      for (std::size_t i = 0; i < size(); ++i) detail::assign(!going, moved_[i], kept_[i]);
      distance = distance_moved();
      size_m = detail::norm(m_.data(), length());
    }
    Mask ok = in_play;
    for (std::size_t k = 0; k < Many::size(); ++k) {
      const auto& lane = lanes[k]->report();
      report[k].status = lane.status;
      report[k].evaluations = lane.evaluations;
      report[k].gradients = lane.evaluations * gradients();
      report[k].correction = lane.correction;
      report[k].rate = lane.rate;
      ok[k] = ok[k] && lane.ok();
      if (in_play[k] && lane.status == Status::not_finite) diagnose(state, k, report);
    }
    return ok;
  }

  /// Tells a state that is not finite from a gradient that is not.
  void diagnose(const State& state, std::size_t k, PackReport& report) const {
    report[k].status = Status::not_finite;
    for (const Many& value : state.z)
      if (!std::isfinite(value[k])) report[k].status = Status::invalid_state;
  }

  /// The compensated move of the lanes that are ok to the mean of the copies; see CompensatedUpdate.
  void finish(State& state, const Mask& ok, PackReport& report) {
    Many not_finite = 0.0;  // becomes NaN
    for (std::size_t i = 0; i < size(); ++i) {
      const auto [sum, lost] = detail::two_sum<Many>(state.z[i], moved_[i] / 2.0 + state.carry[i]);
      m_[i] = sum;
      f_[i] = lost;
      not_finite += sum - sum;
    }
    const Mask good = ok && not_finite == 0.0;
    if (all_of(good)) {
      std::copy(m_.begin(), m_.end(), state.z.begin());
      std::copy(f_.begin(), f_.end(), state.carry.begin());
      return;
    }
    for (std::size_t i = 0; i < size(); ++i) {
      detail::assign(good, state.z[i], m_[i]);
      detail::assign(good, state.carry[i], f_[i]);
    }
    for (std::size_t k = 0; k < Many::size(); ++k)
      if (ok[k] && !good[k]) {
        diagnose(state, k, report);
        for (Many& carry : state.carry) carry[k] = 0;
      }
  }

  H hamiltonian_;
  Scheme<double> scheme_;
  SimplifiedNewton solver_;
  Column f_, moved_, m_;     ///< residual, moves of the copies, multiplier
  Column kept_;              ///< moves of the lanes that are done
  Column a_, b_, gradient_;  ///< of large systems only
};

}  // namespace semiexplicit
