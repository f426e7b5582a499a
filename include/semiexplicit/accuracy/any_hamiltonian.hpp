#pragma once

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/any_stepper.hpp>
#include <semiexplicit/accuracy/setting.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/simd.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/explicit_splitting.hpp>
#include <semiexplicit/steppers/gauss_legendre_lanes.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit::detail {

template <class Scalar>
struct OrdinaryPhaseSpace {};

/// A Hamiltonian whose type and size do not show: what uses one is compiled once for all with the same
/// numbers. `Timed`: its last coordinate is the time, see InExtendedPhaseSpace. Must not outlive the
/// Hamiltonian.
template <class ScalarType, bool Timed>
class AnyHamiltonian : public std::conditional_t<Timed, ExtendedPhaseSpace<ScalarType, Eigen::Dynamic>,
                                                 OrdinaryPhaseSpace<ScalarType>> {
 public:
  using Scalar = ScalarType;
  using Many = Pack<Scalar>;
  static constexpr int Dof = Eigen::Dynamic;
  using State = PhasePoint<Scalar, Dof>;
  using PackGradientOf = AnyHamiltonian;

  template <class H>
  requires(!std::same_as<H, AnyHamiltonian>) explicit AnyHamiltonian(const H& hamiltonian)
      : hamiltonian_(&hamiltonian), dof_(dof_of(hamiltonian)) {
    static_assert(is_in_one_process<H>());
    if constexpr (HasEnergy<H>)
      energy_ = [](const void* h, const Scalar* q, const Scalar* p, Eigen::Index dof) {
        const InColumn<H> at_q(q, dof), at_p(p, dof);
        return Scalar(static_cast<const H*>(h)->energy(at_q, at_p));
      };
    gradient_ = [](const void* h, const Scalar* q, const Scalar* p, Scalar* dHdq, Scalar* dHdp,
                   Eigen::Index dof) { gradient_at(*static_cast<const H*>(h), q, p, dHdq, dHdp, dof); };
    if constexpr (HasPackGradient<H>)
      packs_ = [](const void* h, const Many* q, const Many* p, Many* dHdq, Many* dHdp) {
        static_cast<const H*>(h)->gradient(q, p, dHdq, dHdp);
      };
    if constexpr (SeparableHamiltonian<H>) {
      half_gradient_ = [](const void* h, bool of_momentum, const Scalar* at, Scalar* half, Eigen::Index dof) {
        const InColumn<H> from(at, dof);
        OutColumn<H> out(half, dof);
        if (of_momentum)
          static_cast<const H*>(h)->momentum_gradient(from, out);
        else
          static_cast<const H*>(h)->position_gradient(from, out);
      };
      splitting_ = [](const AnyHamiltonian& h, const Scheme<Scalar>& scheme) {
        ExplicitSplitting<Separable> stepper(Separable{h}, scheme);
        const auto calls = stepper.max_gradients();
        return AnyStepper<Scalar>(std::move(stepper), calls);
      };
    }
  }

  Eigen::Index dof() const { return dof_; }
  bool takes_packs() const { return packs_ != nullptr; }
  bool is_separable() const { return splitting_ != nullptr; }

  /// As trials take it: NaN where it throws std::domain_error, out of its domain.
  AnyHamiltonian for_trials() const {
    AnyHamiltonian copy = *this;
    copy.nan_outside_ = true;
    return copy;
  }

  Scalar energy(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p) const {
    Scalar energy;
    call([&] { energy = energy_(hamiltonian_, q.data(), p.data(), dof_); }, &energy, 1);
    return energy;
  }
  void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                Out<Scalar, Dof> dHdp) const {
    gradient_into(q.data(), p.data(), dHdq.data(), dHdp.data());
  }
  /// Lane by lane where H has no gradient for packs, the lanes in use only.
  void gradient(const Many* q, const Many* p, Many* dHdq, Many* dHdp) const {
    if (lanes_ == 0 && takes_packs())
      return call([&] { packs_(hamiltonian_, q, p, dHdq, dHdp); }, dHdq, dof_, dHdp);
    const std::size_t lanes = lanes_ == 0 ? Many::size() : lanes_;
    const auto d = static_cast<std::size_t>(dof_);
    lane_.resize(4 * d);
    for (std::size_t k = 0; k < lanes; ++k) {
      bool same = k > 0;  // as the lane before, as where an iteration starts: one call for all
      const auto load = [&](Scalar& to, const Scalar& from) { same = same && to == from, to = from; };
      for (std::size_t i = 0; i < d; ++i) load(lane_[i], q[i][k]), load(lane_[d + i], p[i][k]);
      if (!same) gradient_into(lane_.data(), lane_.data() + d, lane_.data() + 2 * d, lane_.data() + 3 * d);
      for (std::size_t i = 0; i < d; ++i) dHdq[i][k] = lane_[2 * d + i], dHdp[i][k] = lane_[3 * d + i];
    }
  }

  /// What a setting is tried with: Gauss's sweeps that a step may take. At the edge of convergence no step is
  /// worth it, and may fail elsewhere on the way, or by GaussLegendre, which iterates from stage to stage and
  /// not by all stages at once.
  static constexpr int sweeps_of_trial = 30;

  /// The stepper of a setting; it may take so many sweeps. Throws std::invalid_argument for an unknown
  /// scheme, a number of stages outside 1 to 8, and a method that this Hamiltonian cannot have.
  SEMIEXPLICIT_COLD AnyStepper<Scalar> stepper(const Setting& setting,
                                               int sweeps = GaussLegendreOptions().max_iterations) const {
    if (setting.is_gauss()) {
      const bool lanes = setting.method == Setting::Method::gauss_lanes;
      if (lanes && !takes_packs())
        throw std::invalid_argument(
            "run: this Hamiltonian has no gradient for packs; take Setting::Method::gauss");
      AnyHamiltonian own = *this;
      own.lanes_ = lanes ? 0 : static_cast<std::size_t>(setting.stages);
      GaussLegendreLanes<AnyHamiltonian> stepper(std::move(own),
                                                 {.stages = setting.stages, .max_iterations = sweeps});
      const auto calls = stepper.max_gradients();
      return {std::move(stepper), calls};
    }
    const Scheme<Scalar> scheme = schemes::by_name<Scalar>(setting.scheme);
    if (setting.method == Setting::Method::splitting) {
      if (!is_separable())
        throw std::invalid_argument(
            "run: this Hamiltonian is not separable; take Setting::Method::semiexplicit");
      return splitting_(*this, scheme);
    }
    // The midpoint projection is the same step, taken as it is after one evaluation.
    const bool explicit_ = setting.method == Setting::Method::midpoint;
    Semiexplicit<AnyHamiltonian> stepper(
        *this, scheme,
        SimplifiedNewton{.stop = explicit_ ? StoppingRule::paper(any_correction) : setting.rule});
    const auto calls =
        explicit_ ? static_cast<std::int64_t>(scheme.kicks()) : std::int64_t{stepper.max_gradients()};
    return {std::move(stepper), calls};
  }

 private:
  struct Separable {
    using Scalar = ScalarType;
    static constexpr int Dof = Eigen::Dynamic;
    static constexpr bool separable = true;
    using SeparableGradientOf = Separable;
    AnyHamiltonian h;
    Eigen::Index dof() const { return h.dof_; }
    void gradient(const In<Scalar, Dof>& q, const In<Scalar, Dof>& p, Out<Scalar, Dof> dHdq,
                  Out<Scalar, Dof> dHdp) const {
      h.gradient(q, p, dHdq, dHdp);
    }
    void position_gradient(const In<Scalar, Dof>& q, Out<Scalar, Dof> half) const {
      h.half_gradient(false, q.data(), half.data());
    }
    void momentum_gradient(const In<Scalar, Dof>& p, Out<Scalar, Dof> half) const {
      h.half_gradient(true, p.data(), half.data());
    }
  };
  static constexpr double any_correction = 1e300;

  void gradient_into(const Scalar* q, const Scalar* p, Scalar* dHdq, Scalar* dHdp) const {
    call([&] { gradient_(hamiltonian_, q, p, dHdq, dHdp, dof_); }, dHdq, dof_, dHdp);
  }
  void half_gradient(bool of_momentum, const Scalar* at, Scalar* half) const {
    call([&] { half_gradient_(hamiltonian_, of_momentum, at, half, dof_); }, half, dof_);
  }
  /// A call that writes `length` numbers, and as many others.
  template <class Call, class Number>
  void call(const Call& write, Number* numbers, Eigen::Index length, Number* others = nullptr) const {
    if (!nan_outside_) return write();
    try {
      write();
    } catch (const std::domain_error&) {
      const Number nan(std::numeric_limits<Scalar>::quiet_NaN());
      std::fill_n(numbers, length, nan);
      if (others) std::fill_n(others, length, nan);
    }
  }

  const void* hamiltonian_;
  Eigen::Index dof_;
  bool nan_outside_ = false;
  std::size_t lanes_ = 0;  ///< that gradients of packs are called for one by one; 0: H takes packs
  mutable std::vector<Scalar> lane_{};
  Scalar (*energy_)(const void*, const Scalar*, const Scalar*, Eigen::Index) = nullptr;
  void (*gradient_)(const void*, const Scalar*, const Scalar*, Scalar*, Scalar*, Eigen::Index) = nullptr;
  void (*packs_)(const void*, const Many*, const Many*, Many*, Many*) = nullptr;
  void (*half_gradient_)(const void*, bool, const Scalar*, Scalar*, Eigen::Index) = nullptr;
  AnyStepper<Scalar> (*splitting_)(const AnyHamiltonian&, const Scheme<Scalar>&) = nullptr;
};

/// The monitor function of a setting's reversible steps.
template <class H>
SEMIEXPLICIT_COLD monitors::TimeScale<H> pace_of(const H& hamiltonian, const Setting& setting) {
  using Scalar = typename H::Scalar;
  return monitors::TimeScale<H>(hamiltonian, {.length = Scalar(setting.pace.length),
                                              .momentum = Scalar(setting.pace.momentum),
                                              .longest = Scalar(setting.pace.longest)});
}

/// AnyHamiltonian for an H.
template <class H>
using Erased = AnyHamiltonian<typename H::Scalar, InExtendedPhaseSpace<H>>;

}  // namespace semiexplicit::detail
