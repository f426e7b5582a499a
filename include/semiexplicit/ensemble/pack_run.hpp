#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>

#include <semiexplicit/ensemble/semiexplicit_pack.hpp>

namespace semiexplicit {

/// How far to go with all members of an ensemble, and how.
struct EnsembleOptions {
  double dt = 0;           ///< the step; negative goes back in time
  std::int64_t steps = 0;  ///< how many
  std::int64_t every = 1;  ///< the observer hears of the start and of every so many steps; 0: of none
  int threads = 0;         ///< 0: what OpenMP takes. Without OpenMP there is one, whatever this says
  double t0 = 0;           ///< time of the states
};

namespace detail {

/// A run of up to a register full of members, in lockstep. One that fails is left behind with its report.
struct PackRun {
  std::array<Eigen::Index, static_cast<std::size_t>(pack_width)> member{};  ///< by lanes
  LaneChoice going{};
  std::array<IntegrationReport, static_cast<std::size_t>(pack_width)> report{};
  std::int64_t steps = 0;
  std::exception_ptr gradient_threw, observer_threw;

  bool over(const EnsembleOptions& options) const { return steps == options.steps || going == LaneChoice{}; }

  /// Steps to the end, or to where a gradient or the observer throws.
  template <class H, class Observer>
  void advance(SemiexplicitPack<H>& stepper, PackPoint<H::Dof>& point, const EnsembleOptions& options,
               const Observer& observe) {
    PackReport step{};
    gradient_threw = nullptr;
    while (!over(options) && !observer_threw) {
      try {
        step = stepper.step(point, options.dt, going);
      } catch (...) {
        gradient_threw = std::current_exception();
        break;
      }
      ++steps;
      for (std::size_t k = 0; k < going.size(); ++k)
        if (going[k]) count(k, step[k]);
      if (options.every > 0 && steps % options.every == 0) tell(point, options, observe);
    }
    for (std::size_t k = 0; k < going.size(); ++k) {
      report[k].t = time(options, report[k].steps);
      if (!going[k]) continue;
      if (steps > 0) report[k].last = step[k];
      if (observer_threw) report[k].status = Status::stopped;
    }
  }

  /// Tells the observer where those are that go on.
  template <int Dof, class Observer>
  void tell(const PackPoint<Dof>& point, const EnsembleOptions& options, const Observer& observe) {
    try {
      for (std::size_t k = 0; k < going.size(); ++k)
        if (going[k]) observe(member[k], time(options, steps), point.lane(k));
    } catch (...) {
      observer_threw = std::current_exception();
    }
  }

 private:
  static double time(const EnsembleOptions& options, std::int64_t n) {
    return options.t0 + static_cast<double>(n) * options.dt;
  }

  void count(std::size_t k, const StepReport& step) {
    report[k].evaluations += step.evaluations;
    report[k].gradients += step.gradients;
    if (step.ok()) {
      ++report[k].steps;
      report[k].max_correction = std::max(report[k].max_correction, step.correction);
    } else {
      report[k].status = step.status;
      report[k].last = step;
      going[k] = false;
    }
  }
};

}  // namespace detail
}  // namespace semiexplicit
