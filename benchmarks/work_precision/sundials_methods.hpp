#pragma once

#include "adaptive.hpp"

#ifdef SEMIEXPLICIT_BENCHMARK_SUNDIALS
#include <limits>
#include <memory>

#include <arkode/arkode_erkstep.h>
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sundials/sundials_context.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>
#endif

namespace work_precision {

#ifdef SEMIEXPLICIT_BENCHMARK_SUNDIALS
/// A handle of SUNDIALS, whose functions free it by its address.
template <class Handle, auto free>
class Owned {
 public:
  explicit Owned(Handle handle) : handle_(handle) {}
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() { free(&handle_); }
  operator Handle() const { return handle_; }

 private:
  Handle handle_;
};

inline SUNContext new_context() {
  SUNContext context = nullptr;
  SUNContext_Create(nullptr, &context);
  return context;
}
inline void destroy(N_Vector* vector) { N_VDestroy(*vector); }
inline void destroy(SUNNonlinearSolver* solver) { SUNNonlinSolFree(*solver); }

/// What the runs with SUNDIALS have in common: state, right-hand side, tolerances.
template <class H>
class SundialsRun {
 public:
  explicit SundialsRun(const Problem<H>& problem)
      : hamiltonian_(problem.hamiltonian),
        z_(start_numbers(problem.start)),
        context_(new_context()),
        vector_(N_VMake_Serial(static_cast<sunindextype>(z_.size()), z_.data(), context_)) {}

  /// ERKStep: explicit Runge-Kutta of this order, 2 to 8.
  Outcome explicit_steps(int order, double tolerance, double size, double end, Watch* watch) {
    const Owned<void*, ERKStepFree> memory(ERKStepCreate(field, 0, vector_, context_));
    ERKStepSetErrFile(memory, nullptr);
    ERKStepSetUserData(memory, this);
    ERKStepSetOrder(memory, order);
    ERKStepSStolerances(memory, tolerance, tolerance * size);
    ERKStepSetMaxNumSteps(memory, std::numeric_limits<long>::max());
    ERKStepSetStopTime(memory, end);
    return run(end, watch,
               [&](double& t) { return ERKStepEvolve(memory, end, vector_, &t, ARK_ONE_STEP) >= 0; });
  }

  /// CVODE: Adams methods of order 1 to 12, whose equations are solved by fixed-point iteration.
  Outcome adams(double tolerance, double size, double end, Watch* watch) {
    const Owned<void*, CVodeFree> memory(CVodeCreate(CV_ADAMS, context_));
    const Owned<SUNNonlinearSolver, static_cast<void (*)(SUNNonlinearSolver*)>(destroy)> solver(
        SUNNonlinSol_FixedPoint(vector_, 0, context_));
    CVodeSetErrFile(memory, nullptr);
    CVodeInit(memory, field, 0, vector_);
    CVodeSetUserData(memory, this);
    CVodeSStolerances(memory, tolerance, tolerance * size);
    CVodeSetNonlinearSolver(memory, solver);
    CVodeSetMaxNumSteps(memory, std::numeric_limits<long>::max());
    CVodeSetStopTime(memory, end);
    return run(end, watch, [&](double& t) { return CVode(memory, end, vector_, &t, CV_ONE_STEP) >= 0; });
  }

 private:
  template <class Step>
  Outcome run(double end, Watch* watch, const Step& step) {
    Outcome outcome =
        run_adaptively(end, end, watch, z_.data(), z_.size(), gradients_, [&](double& t, double&) {
          failed_ = failed_ || !step(t);
          return !failed_;
        });
    if (failed_) outcome.status = "refused";
    return outcome;
  }

  static int field(double, N_Vector z, N_Vector dzdt, void* self) {
    auto& run = *static_cast<SundialsRun*>(self);
    ++run.gradients_;
    vector_field(run.hamiltonian_, NV_DATA_S(z), NV_DATA_S(dzdt));
    return 0;
  }

  const H& hamiltonian_;
  Numbers<H::Dof> z_;
  Owned<SUNContext, SUNContext_Free> context_;
  Owned<N_Vector, static_cast<void (*)(N_Vector*)>(destroy)> vector_;
  std::int64_t gradients_ = 0;
  bool failed_ = false;
};
#endif

/// Explicit Runge-Kutta of orders 5 and 8 and Adams's methods of SUNDIALS.
template <class H>
void add_sundials([[maybe_unused]] std::vector<Line>& lines, [[maybe_unused]] const Problem<H>& problem,
                  [[maybe_unused]] double end) {
#ifdef SEMIEXPLICIT_BENCHMARK_SUNDIALS
  for (const int order : {5, 8}) {
    Line line =
        line_of_tolerances({family::erkstep, "ERKStep", "order " + std::to_string(order), 0}, order == 8);
    line.run = [=](double tolerance, Watch* watch) {
      return SundialsRun<H>(problem).explicit_steps(order, tolerance, problem.size(), end, watch);
    };
    lines.push_back(line);
  }
  Line line = line_of_tolerances({family::cvode, "CVODE", "Adams", 0}, true);
  line.run = [=](double tolerance, Watch* watch) {
    return SundialsRun<H>(problem).adams(tolerance, problem.size(), end, watch);
  };
  lines.push_back(line);
#endif
}

}  // namespace work_precision
