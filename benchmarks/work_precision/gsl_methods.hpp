#pragma once

#include "adaptive.hpp"

#ifdef SEMIEXPLICIT_BENCHMARK_GSL
#include <memory>

#include <gsl/gsl_errno.h>
#include <gsl/gsl_odeiv2.h>
#endif

namespace work_precision {

#ifdef SEMIEXPLICIT_BENCHMARK_GSL
/// One run with a stepper of GSL. The driver is what its implicit steppers take their tolerances from.
template <class H>
class GslRun {
 public:
  GslRun(const Problem<H>& problem, const gsl_odeiv2_step_type* type, double tolerance)
      : hamiltonian_(problem.hamiltonian),
        z_(start_numbers(problem.start)),
        difference_(z_),
        system_{field, jacobian, z_.size(), this},
        driver_(gsl_odeiv2_driver_alloc_y_new(&system_, type, problem.step_per_call,
                                              tolerance * problem.size(), tolerance),
                gsl_odeiv2_driver_free) {
    gsl_set_error_handler_off();  // failures are statuses here, not the program's end
  }
  GslRun(const GslRun&) = delete;
  GslRun& operator=(const GslRun&) = delete;

  Outcome adaptive(double end, double first_dt, Watch* watch) {
    return run_adaptively(end, first_dt, watch, z_.data(), z_.size(), gradients_, [&](double& t, double& dt) {
      return gsl_odeiv2_evolve_apply(driver_->e, driver_->c, driver_->s, &system_, &t, end, &dt, z_.data()) ==
             GSL_SUCCESS;
    });
  }

  /// One step of a fixed size, with no say of the error control.
  bool step(double dt) {
    double t = 0;
    return gsl_odeiv2_evolve_apply_fixed_step(driver_->e, nullptr, driver_->s, &system_, &t, dt, z_.data()) ==
           GSL_SUCCESS;
  }

  const double* z() const { return z_.data(); }
  std::int64_t gradients() const { return gradients_; }

 private:
  static int field(double, const double* z, double* dzdt, void* self) {
    auto& run = *static_cast<GslRun*>(self);
    ++run.gradients_;
    vector_field(run.hamiltonian_, z, dzdt);
    return GSL_SUCCESS;
  }

  /// By forward differences: only a modified Newton iteration uses it.
  static int jacobian(double, const double* z, double* dfdz, double* dfdt, void* self) {
    auto& run = *static_cast<GslRun*>(self);
    const std::size_t n = run.z_.size();
    std::vector<double> there(n), here(n);
    std::copy(z, z + n, run.difference_.begin());
    vector_field(run.hamiltonian_, z, here.data());
    for (std::size_t j = 0; j < n; ++j) {
      const double h = 1.5e-8 * std::max(1.0, std::abs(z[j]));
      run.difference_[j] = z[j] + h;
      vector_field(run.hamiltonian_, run.difference_.data(), there.data());
      run.difference_[j] = z[j];
      for (std::size_t i = 0; i < n; ++i) dfdz[i * n + j] = (there[i] - here[i]) / h;
      dfdt[j] = 0;
    }
    run.gradients_ += static_cast<std::int64_t>(n + 1);
    return GSL_SUCCESS;
  }

  const H& hamiltonian_;
  Numbers<H::Dof> z_, difference_;
  gsl_odeiv2_system system_;
  std::unique_ptr<gsl_odeiv2_driver, decltype(&gsl_odeiv2_driver_free)> driver_;
  std::int64_t gradients_ = 0;
};

/// Fixed steps of an implicit method, whose iteration ends at the tolerance.
template <class H>
Outcome run_gsl_steps(const Problem<H>& problem, const gsl_odeiv2_step_type* type, double tolerance,
                      double end, double dt_wanted, Watch* watch) {
  GslRun<H> run(problem, type, tolerance);
  const auto steps = static_cast<std::int64_t>(std::ceil(end / dt_wanted * (1 - 1e-12)));
  const double dt = end / static_cast<double>(steps);
  Outcome outcome;
  const double begin = cpu_seconds();
  while (outcome.steps < steps && outcome.ok()) {
    if (!run.step(dt)) {
      outcome.status = "no convergence";
      break;
    }
    ++outcome.steps;
    const double t = static_cast<double>(outcome.steps) * dt;
    if (watch != nullptr && watch->due(t) && !watch->see(t, run.z())) outcome.status = "energy lost";
  }
  outcome.seconds = cpu_seconds() - begin;
  outcome.t = static_cast<double>(outcome.steps) * dt;
  outcome.gradients = run.gradients();
  return outcome;
}
#endif

/// Prince-Dormand of order 8 and Adams of GSL; for small systems the implicit Gauss method of order 4, too.
template <class H>
void add_gsl([[maybe_unused]] std::vector<Line>& lines, [[maybe_unused]] const Problem<H>& problem,
             [[maybe_unused]] double end) {
#ifdef SEMIEXPLICIT_BENCHMARK_GSL
  const auto add_adaptive = [&](const char* family, const char* name, const gsl_odeiv2_step_type* type) {
    Line line = line_of_tolerances({family, name, "adaptive", 0}, true);
    line.run = [=](double tolerance, Watch* watch) {
      return GslRun<H>(problem, type, tolerance).adaptive(end, problem.step_per_call, watch);
    };
    lines.push_back(line);
  };
  add_adaptive(family::rk8pd, "rk8pd", gsl_odeiv2_step_rk8pd);
  add_adaptive(family::msadams, "msadams", gsl_odeiv2_step_msadams);
  if (problem.start.dof() > 10) return;  // dense matrices
  add_adaptive(family::rk4imp, "rk4imp", gsl_odeiv2_step_rk4imp);
  for (const double tolerance : {1e-6, 1e-9, 1e-13}) {
    Line line{.method = {family::rk4imp, "rk4imp", "fixed step, tolerance " + number(tolerance), 4},
              .first = 10 * problem.step_per_call};
    line.run = [=](double dt, Watch* watch) {
      return run_gsl_steps(problem, gsl_odeiv2_step_rk4imp, tolerance, end, dt, watch);
    };
    lines.push_back(line);
  }
#endif
}

}  // namespace work_precision
