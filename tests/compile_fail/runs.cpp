// case no_mistake: compiles
// case observer_of_other_arguments: this observer cannot be called: write `void operator()(const Scalar& t, const State& state)`
// case observer_wants_mutable_state: this observer cannot be called: write `void operator()(const Scalar& t, const State& state)`
// case time_as_whole_number: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case any_time_as_whole_number: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case class_time_as_whole_number: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case nested_observer: this observer cannot be called: write `void operator()(const Scalar& t, const State& state)`
// case solver_without_workspace: this solver has no memory to work in: write `template <class Vec> struct Workspace`
// case solver_without_solve: this solver has no `template <class Residual, class Vec> SolverReport
// case multiplier_by_value: takes the residual or m by value, so that what it finds is lost: write `SolverReport
// case residual_by_value: takes the residual or m by value, so that what it finds is lost: write `SolverReport
// case hamiltonian_not_const: hamiltonian() of this stepper cannot be called: write `const H& hamiltonian() const`
// case dof_not_const: dof() of this stepper cannot be called, or is no number: write `Eigen::Index dof() const`
// case dof_of_an_argument: dof() of this stepper cannot be called, or is no number: write `Eigen::Index dof() const`
// case stepper_without_state: this stepper does not say what it moves: write `using Scalar = double; using State =
// case stepper_without_step: this stepper has no step: write `StepReport step(State& state, const Scalar& dt)`
// case step_of_a_copy: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_a_copy_on_lvalues: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_any_copy: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_a_longer_copy: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_a_const_state: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_any_const_state: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_a_const_template: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case static_step_of_a_const_state: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_of_whole_dt: takes dt as a whole number, or one of fewer digits than Scalar, which rounds it: write `StepReport step(State& state, const Scalar& dt)`
// case step_of_float: takes dt as a whole number, or one of fewer digits than Scalar, which rounds it: write `StepReport step(State& state, const Scalar& dt)`
// case estimate_of_a_copy: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case inner_without_memory: shows its memory: write `template <class Visitor> void visit_memory(
// case fresh_as_data: fresh() of this observer cannot be called: write `bool fresh() const`
// case time_as_float: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case any_time_as_float: takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write `const Scalar& t`
// case action_at_whole_times: this action takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write
// case action_at_floats: this action takes the time as a whole number, or one of fewer digits than Scalar, which rounds it: write
// case invariant_of_whole_numbers: this function tells no more than true and false, whole numbers, or ones of fewer digits than Scalar, which hides how far it strayed
// case invariant_of_float: this function tells no more than true and false, whole numbers, or ones of fewer digits than Scalar, which hides how far it strayed
// case invariant_of_a_bool: this function tells no more than true and false, whole numbers, or ones of fewer digits than Scalar, which hides how far it strayed
// case step_until_whole_times: step_until, begin or reached of this stepper takes a time as a whole number, or one of fewer digits
// case step_until_float: step_until, begin or reached of this stepper takes a time as a whole number, or one of fewer digits
// case begins_at_whole_times: step_until, begin or reached of this stepper takes a time as a whole number, or one of fewer digits
// case reached_whole_times: step_until, begin or reached of this stepper takes a time as a whole number, or one of fewer digits
// case surface_of_whole_numbers: this surface cannot be called, or tells no more than true and false, or whole numbers: write
// case step_until_of_a_copy: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_until_of_a_const_state: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_until_of_any_const_state: takes the state by value or const, so that it stays where it is: write `StepReport step(State&
// case step_until_alone: has a step_until() as one that chooses its steps, and lacks another part of ChoosesSteps
// case state_of_other_size: the state is of another type than the one that the stepper moves
// case record_of_other_size: the state has another number of degrees of freedom than this observer: give an observer of its Dof
// case invariants_of_other_size: the state has another number of degrees of freedom than this observer: give an observer of its Dof
// case const_state: the state is const, and a run moves it: leave `const` out, or give it a copy
// case const_stepper: the stepper is const, and a step changes it: leave `const` out
// case saved_without_memory: shows its memory: write `template <class Visitor> void visit_memory(
// case saved_without_options: lists its options, or a run could be resumed with others: write
// case visitor_by_value: visit_memory() takes its visitor by value, so that nothing is saved: write `template <class
// case list_by_value: lists its options, or a run could be resumed with others: write
// case visitor_of_constants: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case visitor_of_constant_lists: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case visitor_of_constant_matrices: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case visitor_of_constant_texts: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case visitor_of_temporaries: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case deduced_visitor_of_constants: visits what is const, or a temporary, so that nothing can be put back: leave `const` out behind its parameters
// case const_visitor_of_nothing: compiles
// case const_visitor_by_reference: compiles
// case inner_visitor_by_value: visit_memory() takes its visitor by value, so that nothing is saved: write `template <class
// case inner_memory_by_value: visit_memory() takes its visitor by value, so that nothing is saved: write `template <class
// case referred_observer_behind_checkpoints: an observer that a checkpoint can keep stands behind Checkpoints
// case referred_every_within_every: every() within every() would count the steps of the run, too: give one of them the product
// case fresh_of_another_meaning: compiles
// case fresh_not_const: fresh() of this observer cannot be called: write `bool fresh() const`
// case solver_without_options: does not list its options, so it could be resumed with others: write
// case reversible_steps_changed_by_events: events that change the state need a stepper of equal steps, and this one chooses its steps
// case reversible_steps_twice: this stepper chooses the times of its steps already: give ReversibleSteps its inner stepper
// case reversible_steps_of_transformed: is TimeTransformed, by which its steps follow a monitor already: give ReversibleSteps a stepper of the Hamiltonian within
// case every_part_of_a_step: every() counts steps: give a whole number of them, as 5 for 5.0
// case stepper_of_other_numbers: has other numbers than its Scalar, in which dt comes: give both the same
// case every_within_every: every() within every() would count the steps of the run, too: give one of them the product
// case monitor_of_one_argument: this monitor function cannot be called: write `double operator()(const auto& q, const auto& p) const`
// case monitor_without_gradient: this monitor function cannot be called: write `double operator()(const auto& q, auto&& dgdq) const`
// case monitor_of_whole_numbers: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case monitor_of_no_number: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case monitor_of_float: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case monitor_value_of_float: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case monitor_with_gradient_of_float: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case monitor_with_whole_gradient: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case centre_of_float: this monitor function returns a whole number, or one of fewer digits than Scalar, which rounds it: return g as a Scalar
// case centre_of_whole_numbers: a centre of whole numbers: write Eigen::Vector2d(0, 0)
// case transformed_without_energy: has no public energy, by which the run is to be judged: write `Scalar energy(
// case surface_without_on_event: events() takes kinds of events: write `on_event(surface, action)`
// case surface_of_one_argument: this surface cannot be called, or tells no more than true and false, or whole numbers: write `[](const auto& q, const auto& p) { return q[0]; }`
// case surface_of_no_number: this surface cannot be called, or tells no more than true and false, or whole numbers: write `[](const auto& q, const auto& p) { return q[0]; }`
// case surface_of_a_kept_bool: this surface cannot be called, or tells no more than true and false, or whole numbers: write `[](const auto& q, const auto& p) { return q[0]; }`
// case section_of_one_argument: this surface cannot be called, or tells no more than true and false, or whole numbers: write `[](const auto& q, const auto& p) { return q[0]; }`
// case reversible_steps_of_no_stepper: this stepper has no step: write `StepReport step(State& state, const Scalar& dt)`
// case observer_behind_checkpoints: an observer that a checkpoint can keep stands behind Checkpoints
// case changed_by_events_within_every: events that change the state are an argument of integrate() itself
// case changed_by_events_within_each: events that change the state are an argument of integrate() itself
// case changed_by_events_within_estimate: events that change the state are an argument of integrate() itself
// case changed_by_events_within_at_times: events that change the state are an argument of integrate() itself
// case changed_by_events_by_reference: events that change the state are an argument of integrate() itself
// case saved_within_every: compiles
// case saved_within_at_times: Checkpoints save the run where a step ends, and within at_times(), a section, events() or
// case saved_within_section: Checkpoints save the run where a step ends, and within at_times(), a section, events() or
// case saved_within_events: Checkpoints save the run where a step ends, and within at_times(), a section, events() or
// case saved_within_estimate: Checkpoints save the run where a step ends, and within at_times(), a section, events() or
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include <semiexplicit/checkpoint/checkpoints.hpp>
#include <semiexplicit/ensemble/ensemble.hpp>
#include <semiexplicit/observers/error_estimate.hpp>
#include <semiexplicit/observers/events.hpp>
#include <semiexplicit/observers/every.hpp>
#include <semiexplicit/observers/invariants.hpp>
#include <semiexplicit/observers/poincare_section.hpp>
#include <semiexplicit/observers/record.hpp>
#include <semiexplicit/schemes/named.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>
#include <semiexplicit/systems/product.hpp>
#include <semiexplicit/time/monitors.hpp>
#include <semiexplicit/time/reversible_steps.hpp>
#include <semiexplicit/time/time_transformed.hpp>

#if defined(changed_by_events_within_every) || defined(changed_by_events_within_each) ||        \
    defined(changed_by_events_within_estimate) || defined(changed_by_events_within_at_times) || \
    defined(changed_by_events_by_reference)
#define changed_by_events
#endif
#if defined(saved_within_every) || defined(saved_within_at_times) || defined(saved_within_section) || \
    defined(saved_within_events) || defined(saved_within_estimate)
#define saved_within
#endif

using namespace semiexplicit;
using Point = PhasePoint<double, 1>;

struct MySolver {
  StoppingRule stop = StoppingRule::product();
#ifndef solver_without_options
  static constexpr const char* name = "MySolver";
  template <class List>
  void describe(List& list) const {
    list("stop", stop);
  }
#endif
#ifndef solver_without_workspace
  template <class Vec>
  struct Workspace {
    Workspace(const MySolver&, Eigen::Index size) : f(Vec::Zero(size)) {}
    Vec f;
  };
#endif
#if !defined(solver_without_solve) && !defined(solver_without_workspace)
  template <class Residual, class Vec>
#ifdef multiplier_by_value
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec m, Workspace<Vec>& work) const {
#elif defined(residual_by_value)
  SolverReport<typename Vec::Scalar> solve(Residual residual, Vec& m, Workspace<Vec>& work) const {
#else
  SolverReport<typename Vec::Scalar> solve(Residual& residual, Vec& m, Workspace<Vec>& work) const {
#endif
    m.setZero();
    residual(work.f);
    return {.status = Status::success, .evaluations = 1};
  }
#endif
};

struct MyStepper {
#ifdef stepper_of_other_numbers
  using Scalar = float;
  using State = Point;
#elif !defined(stepper_without_state)
  using Scalar = double;
  using State = Point;
#endif
#ifndef stepper_without_step
#if defined(step_of_a_copy) || defined(estimate_of_a_copy)
  StepReport step(Point z, const double& dt) {
#elif defined(step_of_any_copy)
  StepReport step(auto z, const double& dt) {
#elif defined(step_of_a_longer_copy)
  StepReport step(Point z, const double& dt, int = 1) {
#elif defined(step_of_a_const_state)
  StepReport step(const Point& given, const double& dt) {
    Point z = given;
#elif defined(step_of_any_const_state)
  auto step(const auto& given, const double& dt) const {
    auto z = given;
#elif defined(step_of_a_const_template)
  template <class State, class Number>
  StepReport step(const State& given, Number dt) {
    State z = given;
#elif defined(static_step_of_a_const_state)
  static StepReport step(const Point& given, const double& dt) {
    Point z = given;
#elif defined(step_of_whole_dt)
  StepReport step(Point& z, int dt) {
#elif defined(step_of_float)
  StepReport step(Point& z, float dt) {
#elif defined(step_of_a_copy_on_lvalues)
  StepReport step(Point z, const double& dt) & noexcept {
#else
  StepReport step(Point& z, const double& dt) {
#endif
    z.q()[0] += dt;
    return StepReport{};
  }
#endif
#ifdef step_until_of_a_copy
  StepReport step_until(Point z, const double& dt, const double&) { return step(z, dt); }
#elif defined(step_until_of_a_const_state)
  StepReport step_until(const Point&, const double&, const double&) { return {}; }
#elif defined(step_until_of_any_const_state)
  StepReport step_until(const auto&, const double&, const double&) { return {}; }
#elif defined(step_until_alone)
  StepReport step_until(Point& z, const double& dt, const double&) { return step(z, dt); }
#endif
#ifdef hamiltonian_not_const
  systems::Product<double>& hamiltonian() { return own; }
  systems::Product<double> own;
#elif defined(dof_not_const)
  Eigen::Index dof() { return 1; }
#elif defined(dof_of_an_argument)
  Eigen::Index dof(int) const { return 1; }
#endif
#ifndef saved_without_options
  static constexpr const char* name = "MyStepper";
#endif
#ifdef list_by_value
  void describe(auto) const {}
#elif !defined(saved_without_options)
  template <class List>
  void describe(List&) const {}
#endif
  double sum = 0;
#ifdef visitor_by_value
  void visit_memory(auto) {}
#elif defined(visitor_of_constants)
  void visit_memory(auto&& visit) const { visit(sum); }
#elif defined(deduced_visitor_of_constants)
  template <class Visitor>
  auto visit_memory(Visitor& visit) const {
    visit(sum);
  }
#elif defined(visitor_of_constant_lists)
  std::vector<double> kept{};
  void visit_memory(CheckpointMemory& visit) const { visit(kept); }
#elif defined(visitor_of_constant_matrices)
  Eigen::Vector2d kept{};
  void visit_memory(auto&& visit) const { visit(kept); }
#elif defined(visitor_of_constant_texts)
  std::string kept{};
  void visit_memory(auto&& visit) const { visit(kept); }
#elif defined(visitor_of_temporaries)
  void visit_memory(auto&& visit) { visit(sum + 1); }
#elif defined(const_visitor_of_nothing)
  void visit_memory(auto&&) const {}
#elif defined(const_visitor_by_reference)
  struct Kept {
    double sum;
    std::vector<double> list;
    Eigen::Matrix2d matrix;
    Eigen::ArrayXf array;
    std::string text;
    bool flag;
  };
  std::shared_ptr<Kept> kept = std::make_shared<Kept>();
  auto visit_memory(auto&& visit) const {
    visit(kept->sum), visit(kept->list), visit(kept->matrix), visit(kept->array), visit(kept->text),
        visit(kept->flag);
  }
#elif !defined(saved_without_memory)
  template <class Visitor>
  void visit_memory(Visitor&&) {}
#endif
};

struct CountsSteps {
#ifdef fresh_of_another_meaning
  void fresh() { steps = 0; }
#else
  static constexpr const char* name = "CountsSteps";
  void describe(auto&) const {}
#ifdef inner_visitor_by_value
  void visit_memory(auto visit) { visit(steps); }
#elif defined(inner_without_memory)
#elif defined(fresh_as_data)
  void visit_memory(auto&& visit) { visit(steps); }
  bool fresh = true;
#elif defined(inner_memory_by_value)
  void visit_memory(CheckpointMemory visit) { visit(steps); }
#else
  void visit_memory(auto&& visit) { visit(steps); }
  bool fresh() { return steps == 0; }
#endif
#endif
  void operator()(double, const auto&) { ++steps; }
  int steps = 0;
};

struct WholeTime {
  template <class State>
  void operator()(std::int64_t, const State&) const {}
};
struct NoEnergy {
  using Scalar = double;
  static constexpr int Dof = 1;
  void gradient(In<double, 1> q, In<double, 1> p, Out<double, 1> dHdq, Out<double, 1> dHdp) const {
    dHdq = q, dHdp = p;
  }
};
/// Chooses its steps.
struct Chooses {
  using Scalar = double;
  using State = Point;
  using Fixed = MyStepper;
  using Clock = double;
  double at = 0, last = 0;
  Fixed inner;
#if defined(step_until_float)
  using Until = float;
#elif defined(step_until_whole_times)
  using Until = int;
#else
  using Until = const double&;
#endif
#ifdef begins_at_whole_times
  void begin(const Point&, long t) { at = static_cast<double>(t); }
#else
  void begin(const Point&, auto t) { at = t; }
#endif
#ifdef reached_whole_times
  bool reached(int t) const { return at >= t; }
#else
  bool reached(double t) const { return at >= t; }
#endif
  StepReport step(Point& z, const double& dt) { return at += last = dt, z.q()[0] += dt, StepReport{}; }
  StepReport step_until(Point& z, const double& dt, Until) { return step(z, dt); }
  double time() const { return at; }
  double taken() const { return last; }
  Clock clock() const { return at; }
  void rewind(const Clock& clock, const Point&) { at = clock; }
  const Fixed& stepper() const { return inner; }
};
struct NoStepper {
  using Scalar = double;
  using State = Point;
};

struct FloatValue {
  float value(const auto& q, const auto&) const { return float(q[0]); }
};

int main() {
  const auto scheme = schemes::strang<double>();
  const auto right = [](double, const Point&) {};
  [[maybe_unused]] const systems::Product<double> H;
  [[maybe_unused]] const auto first = [](const auto& q, const auto&) { return q[0]; };
  [[maybe_unused]] const auto change = [](double, Point& at) { at.p()[0] = 1; };
#if defined(observer_of_other_arguments) || defined(nested_observer)
  const auto observer = [](const Point&) {};
#elif defined(observer_wants_mutable_state)
  const auto observer = [](double, Point&) {};
#elif defined(any_time_as_whole_number)
  const auto observer = [](long, const auto&, const IntegrationReport&) {};
#elif defined(class_time_as_whole_number)
  const WholeTime observer;
#elif defined(time_as_float)
  const auto observer = [](float, const Point&) {};
#elif defined(any_time_as_float)
  const auto observer = [](float, const auto&) {};
#elif defined(time_as_whole_number)
  const auto observer = [](int, const Point&) {};
#else
  const auto observer = right;
#endif
#if defined(state_of_other_size)
  PhasePoint<double, 2> z({1, 2}, {3, 4});
#elif defined(const_state)
  const Point z(1, 2);
#else
  Point z(1, 2);
#endif
  const IntegrationOptions<double> options{.dt = 0.1, .steps = 10};
#if defined(saved_without_memory) || defined(saved_without_options) || defined(visitor_by_value) || \
    defined(list_by_value)
  MyStepper stepper;
  Checkpoints checkpoints("file", {}, stepper, options);
#elif defined(visitor_of_constants) || defined(visitor_of_constant_lists) ||       \
    defined(visitor_of_constant_matrices) || defined(visitor_of_constant_texts) || \
    defined(visitor_of_temporaries) || defined(deduced_visitor_of_constants) ||    \
    defined(const_visitor_of_nothing) || defined(const_visitor_by_reference)
  MyStepper stepper;
  Checkpoints checkpoints("file", {}, stepper, options);
  integrate(stepper, z, options, checkpoints);
#elif defined(record_of_other_size)
  integrate(Semiexplicit(H, scheme), z, options, every(2, Record<double, 3>()));
#elif defined(invariants_of_other_size)
  integrate(Semiexplicit(H, scheme), z, options, Invariants<double, 2>());
#elif defined(stepper_of_other_numbers)
  MyStepper stepper;
  integrate(stepper, z, {.dt = 0.1f, .steps = 10}, right);
#elif defined(stepper_without_state) || defined(stepper_without_step) || defined(step_of_a_copy) ||     \
    defined(step_of_a_copy_on_lvalues) || defined(step_until_of_a_copy) || defined(step_until_alone) || \
    defined(step_of_any_copy) || defined(step_of_a_longer_copy) || defined(step_of_whole_dt) ||         \
    defined(step_of_a_const_state) || defined(step_of_any_const_state) ||                               \
    defined(step_of_a_const_template) || defined(static_step_of_a_const_state) ||                       \
    defined(step_until_of_a_const_state) || defined(step_until_of_any_const_state) ||                   \
    defined(step_of_float) || defined(hamiltonian_not_const) || defined(dof_not_const) ||               \
    defined(dof_of_an_argument)
  MyStepper stepper;
  integrate(stepper, z, options, right);
#elif defined(estimate_of_a_copy)
  auto estimate = with_error_estimate(MyStepper{});
#elif defined(inner_visitor_by_value) || defined(inner_memory_by_value) || defined(inner_without_memory)
  Semiexplicit stepper(systems::Product<double>(), scheme);
  auto sparse = every(4, CountsSteps{});
  Checkpoints checkpoints("file", {}, stepper, options, sparse);
#elif defined(fresh_not_const) || defined(fresh_as_data) || defined(fresh_of_another_meaning)
  Semiexplicit stepper(systems::Product<double>(), scheme);
  integrate(stepper, z, options, CountsSteps{});
#elif defined(solver_without_options)
  Semiexplicit stepper(systems::Product<double>(), scheme, MySolver());
  Checkpoints checkpoints("file", {}, stepper, options);
#elif defined(reversible_steps_changed_by_events)
  ReversibleSteps stepper(Semiexplicit(H, scheme), [](const auto&, const auto&) { return 1.0; });
  auto watch = events(H, on_event(first, change));
  integrate(stepper, z, options, watch);
#elif defined(reversible_steps_twice)
  const auto pace = [](const auto&, const auto&) { return 1.0; };
  ReversibleSteps stepper(ReversibleSteps(Semiexplicit(H, scheme), pace), pace);
#elif defined(referred_every_within_every)
  auto inner = every(10, right);
  auto sparse = every(4, std::ref(inner));
#elif defined(every_part_of_a_step)
  auto sparse = every(2.5, right);
#elif defined(every_within_every)
  auto sparse = every(4, every(10, right));
#elif defined(monitor_of_one_argument)
  ReversibleSteps stepper(Semiexplicit(H, scheme), [](const auto& q) { return q[0]; });
#elif defined(reversible_steps_of_transformed)
  const TimeTransformed transformed(H, monitors::Distance(), 1.0);
  ReversibleSteps stepper(Semiexplicit(transformed, scheme), monitors::Distance());
#elif defined(monitor_of_whole_numbers)
  ReversibleSteps stepper(Semiexplicit(H, scheme), [](const auto& q, const auto&) { return int(q[0]); });
  stepper.step(z, 0.1);
#elif defined(monitor_of_no_number)
  ReversibleSteps stepper(Semiexplicit(H, scheme), [](const auto& q, const auto&) { return q[0] > 0; });
  stepper.step(z, 0.1);
#elif defined(monitor_of_float)
  ReversibleSteps stepper(Semiexplicit(H, scheme), [](const auto& q, const auto&) { return float(q[0]); });
  stepper.step(z, 0.1);
#elif defined(monitor_value_of_float)
  ReversibleSteps stepper(Semiexplicit(H, scheme), FloatValue());
  stepper.step(z, 0.1);
#elif defined(monitor_with_gradient_of_float)
  const auto pace = [](const auto& q, const auto&, auto&&, auto&&) { return float(q[0]); };
  ReversibleSteps stepper(Semiexplicit(H, scheme), pace);
  stepper.step(z, 0.1);
#elif defined(monitor_with_whole_gradient)
  const TimeTransformed transformed(
      H, [](const auto& q, auto&& dgdq) { return dgdq.setZero(), int(q[0]); }, 1.0);
  transformed.extended(z, 0.0);
#elif defined(centre_of_float)
  const monitors::DistanceFrom from(Eigen::Matrix<float, 1, 1>(0.0f));
  ReversibleSteps stepper(Semiexplicit(H, scheme), from);
  stepper.step(z, 0.1);
#elif defined(centre_of_whole_numbers)
  const monitors::DistanceFrom from(Eigen::Vector2i(0, 0));
#elif defined(monitor_without_gradient)
  TimeTransformed transformed(
      H, [](const auto& q) { return q[0]; }, 1.0);
#elif defined(transformed_without_energy)
  TimeTransformed transformed(NoEnergy(), monitors::Distance(), 1.0);
#elif defined(surface_without_on_event)
  auto watch = events(H, first, right);
#elif defined(surface_of_one_argument)
  auto watch = events(H, on_event([](const auto& q) { return q[0]; }, right));
#elif defined(surface_of_no_number)
  auto watch = events(H, on_event([](const auto& q, const auto&) { return q[0] > 0; }, right));
#elif defined(action_at_whole_times)
  auto watch = events(H, on_event(first, [](int, Point& at) { at.p()[0] = 1; }));
#elif defined(action_at_floats)
  auto watch = events(H, on_event(first, [](float, Point& at) { at.p()[0] = 1; }));
#elif defined(invariant_of_whole_numbers)
  Invariants(H).add("whole", [](const auto& q, const auto&) { return int(q[0]); });
#elif defined(invariant_of_float)
  Invariants(H).add("float", [](const auto& q, const auto&) { return float(q[0]); });
#elif defined(invariant_of_a_bool)
  Invariants(H).add("bool", [](const auto& q, const auto&) { return q[0] > 0; });
#elif defined(step_until_whole_times) || defined(step_until_float) || defined(begins_at_whole_times) || \
    defined(reached_whole_times)
  integrate(Chooses{}, z, options, right);
#elif defined(surface_of_whole_numbers)
  auto watch = events(H, on_event([](const auto& q, const auto&) { return int(q[0]); }, right));
#elif defined(surface_of_a_kept_bool)
  const bool kept = true;
  auto watch = events(H, on_event([&](const auto&, const auto&) -> const bool& { return kept; }, right));
#elif defined(section_of_one_argument)
  auto section = poincare_section(
      H, [](const auto& q) { return q[0]; }, right);
#elif defined(reversible_steps_of_no_stepper)
  ReversibleSteps stepper(NoStepper(), [](const auto&, const auto&) { return 1.0; });
#elif defined(referred_observer_behind_checkpoints)
  Semiexplicit stepper(H, scheme);
  Invariants invariants(H);
  Checkpoints checkpoints("file", {}, stepper, options, invariants);
  integrate(stepper, z, options, checkpoints, std::ref(invariants));
#elif defined(observer_behind_checkpoints)
  Semiexplicit stepper(H, scheme);
  Invariants invariants(H);
  Checkpoints checkpoints("file", {}, stepper, options, invariants);
  integrate(stepper, z, options, checkpoints, right, invariants);
#elif defined(saved_within)
  Semiexplicit stepper(H, scheme);
  Checkpoints checkpoints("file", {}, stepper, options);
#if defined(saved_within_at_times)
  integrate(stepper, z, options, at_times(H, {0.5}, std::ref(checkpoints)));
#elif defined(saved_within_section)
  integrate(stepper, z, options, poincare_section(H, first, every(2, checkpoints)));
#elif defined(saved_within_events)
  integrate(stepper, z, options, events(H, on_event(first, change), on_event(first, checkpoints)));
#elif defined(saved_within_estimate)
  integrate(stepper, z, options, with_error_estimate(stepper, {}, checkpoints));
#else
  integrate(stepper, z, options, every(2, checkpoints), std::ref(checkpoints));
#endif
#elif defined(changed_by_events)
  Semiexplicit stepper(H, scheme);
  auto watch = events(H, on_event(first, change));
#if defined(changed_by_events_within_every)
  integrate(stepper, z, options, every(1, watch));
#elif defined(changed_by_events_within_each)
  std::vector watches{watch, watch};
  Ensemble ensemble(H, std::vector<Point>{z, z}, scheme);
  ensemble.run({.dt = 0.1, .steps = 10}, each(watches));
#elif defined(changed_by_events_within_estimate)
  integrate(stepper, z, options, with_error_estimate(stepper, {}, watch));
#elif defined(changed_by_events_within_at_times)
  integrate(stepper, z, options, at_times(H, {0.5}, watch));
#else
  integrate(stepper, z, options, std::ref(watch));
#endif
#elif defined(const_stepper)
  const Semiexplicit stepper(systems::Product<double>(), scheme);
  integrate(stepper, z, options, right);
#elif defined(nested_observer)
  Semiexplicit stepper(systems::Product<double>(), scheme);
  integrate(stepper, z, options, every(10, observer));
#else
  Semiexplicit stepper(systems::Product<double>(), scheme, MySolver());
  integrate(stepper, z, {.dt = 0.1, .steps = 10}, right, observer);
  integrate(Semiexplicit(H, scheme), z, {.dt = 0.1, .steps = 10}, right);  // a temporary
  integrate(Semiexplicit(H, scheme), z, options, Record<double, 1>(), Record<double, Eigen::Dynamic>());
  integrate(
      Chooses{}, z, options, [](auto, const auto&) {}, [](long double, const auto&) {});
  Invariants(H)
      .add("product", [](const auto& q, const auto& p) { return q.transpose() * p; })
      .add("of vectors", [](Vector<double, 1> q, Vector<double, 1>) mutable { return q[0]; });
#endif
}
