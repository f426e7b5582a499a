#pragma once

#include <limits>
#include <sstream>
#include <string>
#include <type_traits>

#include <semiexplicit/checkpoint/file.hpp>
#include <semiexplicit/core/compensated_update.hpp>
#include <semiexplicit/integrate.hpp>
#include <semiexplicit/solver/stopping.hpp>
#include <semiexplicit/splitting/scheme.hpp>

namespace semiexplicit::detail {

/// Lines "what: value" of all that makes a trajectory this one beside H and the initial state: stepper, scheme, solver and
/// their options, dt, the type of the numbers. Two runs whose lines differ are different runs.
class Fingerprint {
 public:
  template <Stepper S>
  Fingerprint(const S& stepper, const IntegrationOptions<typename S::Scalar>& run, const std::string& label) {
    using Scalar = typename S::Scalar;
    using Limits = std::numeric_limits<Scalar>;
    add("run", label);
    add("stepper", S::name);
    add("bits of a number", Limits::digits);
    add("degrees of freedom", stepper.dof());
    add("dt", run.dt);
    add("t0", run.t0);
    add("subdivide", run.subdivide);
    if constexpr (requires { stepper.scheme(); }) add_scheme(stepper.scheme());
    if constexpr (requires { stepper.solver(); }) add_solver(stepper.solver());
    if constexpr (requires { stepper.summation(); })
      add("summation", stepper.summation() == Summation::compensated ? "compensated" : "plain");
    if constexpr (requires { stepper.omega(); }) add("omega", stepper.omega());
    if constexpr (requires { stepper.options().stages; }) {
      add("stages", stepper.options().stages);
      add("stage solver", static_cast<int>(stepper.options().solver));
      add("tolerance", stepper.options().tolerance);
      add("max_iterations", stepper.options().max_iterations);
      add("extrapolate", stepper.options().extrapolate);
    }
  }

  const std::string& text() const { return text_; }

  /// In words, where another one differs first; empty: nowhere.
  static std::string difference(const std::string& there, const std::string& here) {
    std::istringstream a(there), b(here);
    std::string line_a, line_b;
    for (;;) {
      const bool more_a = static_cast<bool>(std::getline(a, line_a));
      const bool more_b = static_cast<bool>(std::getline(b, line_b));
      if (!more_a && !more_b) return "";
      if (line_a != line_b || more_a != more_b)
        return "'" + (more_a ? line_a : std::string("nothing")) + "' there, '" +
               (more_b ? line_b : std::string("nothing")) + "' here";
    }
  }

 private:
  template <class T>
  void add(const char* what, const T& value) {
    std::string words;
    if constexpr (std::is_floating_point_v<T>)
      words = in_words(value, std::numeric_limits<T>::max_digits10);
    else if constexpr (std::is_arithmetic_v<T>)
      words = std::to_string(value);
    else
      words = value;
    for (char& c : words)
      if (c == '\n') c = ' ';
    text_ += std::string(what) + ": " + words + "\n";
  }

  template <class Scalar>
  void add_scheme(const Scheme<Scalar>& scheme) {
    std::string digits;
    for (const auto* list : {&scheme.a, &scheme.b})
      for (const Scalar& c : *list) digits += in_words(c, std::numeric_limits<Scalar>::max_digits10) + " ";
    add("scheme", scheme.name + ", " + std::to_string(scheme.kicks()) + " kicks, coefficients " +
                      std::to_string(checksum(digits)));
  }

  template <class Solver>
  void add_solver(const Solver& solver) {
    if constexpr (requires { Solver::name; }) add("solver", Solver::name);
    if constexpr (requires { solver.stop; }) {
      add("rule", solver.stop.kind == StoppingRule::Kind::paper ? "paper" : "product");
      add("tolerance", solver.stop.tolerance);
    }
    if constexpr (requires { solver.newton_iterations; }) add("newton_iterations", solver.newton_iterations);
    if constexpr (requires { solver.broyden_iterations; })
      add("broyden_iterations", solver.broyden_iterations);
    if constexpr (requires { solver.max_iterations; }) add("max_iterations", solver.max_iterations);
    if constexpr (requires { solver.memory; }) add("memory", solver.memory);
    if constexpr (requires { solver.directions; }) add("directions", solver.directions);
  }

  std::string text_;
};

}  // namespace semiexplicit::detail
