#pragma once

#include <functional>
#include <string>
#include <vector>

#include "measure.hpp"

namespace work_precision {

/// The families that are compared: a front each.
namespace family {
inline constexpr const char* low_defect = "semiexplicit, low-defect";
inline constexpr const char* published = "semiexplicit, published";
inline constexpr const char* paper_rule = "semiexplicit, paper's rule";
inline constexpr const char* midpoint = "midpoint projection";
inline constexpr const char* reversible = "semiexplicit, reversible steps";
inline constexpr const char* tao = "Tao";
inline constexpr const char* gauss = "Gauss, scalar";
inline constexpr const char* gauss_lanes = "Gauss, lanes";
inline constexpr const char* gauss_reversible = "Gauss, reversible steps";
inline constexpr const char* rk78 = "odeint RK78";
inline constexpr const char* bulirsch_stoer = "odeint Bulirsch-Stoer";
inline constexpr const char* rk8pd = "GSL rk8pd";
inline constexpr const char* rk4imp = "GSL rk4imp";
inline constexpr const char* msadams = "GSL msadams";
inline constexpr const char* erkstep = "SUNDIALS ERKStep";
inline constexpr const char* cvode = "SUNDIALS CVODE";
}  // namespace family

struct Family {
  std::string name;
  bool ours;
  std::string colour;
  bool in_library = ours;  ///< its Gauss methods are, and count as rivals of the semiexplicit ones
};

/// All of them, in the order of tables and legends.
inline const std::vector<Family>& families() {
  static const std::vector<Family> list{
      {family::low_defect, true, "#0072B2"},
      {family::published, true, "#56B4E9"},
      {family::paper_rule, true, "#8DA0CB"},
      {family::midpoint, true, "#009E73"},
      {family::reversible, true, "#004D40"},
      {family::tao, false, "#CC79A7"},
      {family::gauss, false, "#E69F00", true},
      {family::gauss_lanes, false, "#D55E00", true},
      {family::gauss_reversible, false, "#FF8FA3", true},
      {family::rk78, false, "#999999"},
      {family::bulirsch_stoer, false, "#666666"},
      {family::rk8pd, false, "#B8860B"},
      {family::rk4imp, false, "#A6761D"},
      {family::msadams, false, "#C0B000"},
      {family::erkstep, false, "#7A5195"},
      {family::cvode, false, "#4B3F72"},
  };
  return list;
}

/// What tells one setting of a family from another, apart from the parameter that is scanned.
struct Method {
  std::string family;
  std::string name;     ///< scheme, number of stages, ...
  std::string options;  ///< stopping rule, tolerance, ω, ...
  int order = 0;        ///< of the fixed-step methods; 0: adaptive
};

/// One method, scanned over its step or its tolerance from the coarsest setting on.
struct Line {
  Method method;
  bool over_steps = true;  ///< the parameter is dt; else it is the tolerance
  double first = 0;        ///< coarsest value of the parameter
  double last = 0;         ///< finest; 0: until accuracy or patience end
  double factor = 1.25;
  bool in_short = false;  ///< one of the few that the short run takes
  /// Integrates from the start to the end; without a watch nobody looks on, and the clock is to be believed.
  std::function<Outcome(double parameter, Watch* watch)> run = {};
};

/// A problem with everything that is to be run on it, no longer depending on types.
struct Task {
  std::string name;   ///< of its files
  std::string title;  ///< for people
  Yardstick yardstick;
  double most_calls = 0;  ///< gradient calls: a single run that would take more is not begun
  std::vector<Line> lines = {};
  double gradient_error = 0;  ///< against differences of the energy, relative
};

/// The tasks, each from a source of its own. `is_short`: small versions for a test.
Task product_task(bool is_short);
Task nls5_task(bool is_short);
Task nls5_long_task(bool is_short);
Task nls1000_task(bool is_short);
Task nls1000_long_task(bool is_short);
Task vortices_task(bool is_short);
Task disparate_vortices_task(bool is_short);
Task vortices300_task(bool is_short);
Task vortices300_long_task(bool is_short);
Task bottle_task(bool is_short);
Task kerr_task(bool is_short);

}  // namespace work_precision
