#include "catch.hpp"

#include <cmath>
#include <string>
#include <vector>

#include <semiexplicit/chaos.hpp>
#include <semiexplicit/derivatives.hpp>
#include <semiexplicit/ensemble.hpp>
#include <semiexplicit/scene.hpp>
#include <semiexplicit/semiexplicit.hpp>
#include <semiexplicit/systems.hpp>
#include <semiexplicit/time.hpp>

namespace test_deduced_members {

// Members whose arguments and results are all deduced: what the library asks about them does not instantiate
// their bodies with types that they are not made for.

namespace {

using namespace semiexplicit;
using Read = In<double, 2>;
using Write = Out<double, 2>;
const PhasePoint<double, 2> start({1, 0.3}, {0.2, 1});

template <int N>
struct Sized {
  using Scalar = double;
  static constexpr int Dof = N;
};

struct Oscillator : Sized<2> {
  auto energy(const auto& q, const auto& p) const { return (q.dot(q) + p.dot(p)) / 2; }
  auto gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

/// Only outputs are deduced.
struct OutputsDeduced : Oscillator {
  auto gradient(Read q, Read p, auto& dHdq, auto& dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};
struct OutputsForwarded : Oscillator {
  auto gradient(Read q, Read p, auto&& dHdq, auto&& dHdp) const noexcept {
    dHdq = q;
    dHdp = p;
  }
};
struct OutputsAlike : Oscillator {
  template <class Output>
  auto gradient(const Read& q, const Read& p, Output& dHdq, Output& dHdp) const {
    dHdq = q;
    dHdp = p;
  }
};

/// A spring that time changes; the time is the only template parameter, one of three, or none.
struct TimeDeduced : Sized<2> {
  auto energy(const auto& t, Read q, Read p) const {
    using std::cos;
    return q.dot(q) / 2 * cos(t) + p.dot(p) / 2;
  }
  auto time_derivative(const auto& t, Read q, Read) const {
    using std::sin;
    return -q.dot(q) / 2 * sin(t);
  }
  auto gradient(const auto& t, Read q, Read p, Write dHdq, Write dHdp) const {
    using std::cos;
    dHdq = q * cos(t);
    dHdp = p;
  }
};
struct AllDeduced : Sized<2> {
  auto energy(const auto& t, const auto& q, const auto& p) const {
    return TimeDeduced().energy(double(t), q, p);
  }
  auto gradient(const auto& t, const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    TimeDeduced().gradient(double(t), q, p, dHdq, dHdp);
    return TimeDeduced().time_derivative(double(t), q, p);
  }
};
struct ColumnsDeduced : Sized<2> {
  template <class Column>
  auto energy(double t, const Column& q, const Column& p) const {
    return TimeDeduced().energy(t, q, p);
  }
  template <class Column, class Output>
  auto gradient(double t, const Column& q, const Column& p, Output& dHdq, Output& dHdp) const {
    TimeDeduced().gradient(t, q, p, dHdq, dHdp);
    return TimeDeduced().time_derivative(t, q, p);
  }
};

struct DrivenOutputsDeduced : Sized<2> {
  auto energy(double t, Read q, Read p) const { return TimeDeduced().energy(t, q, p); }
  auto gradient(double t, Read q, Read p, auto& dHdq, auto& dHdp) const {
    TimeDeduced().gradient(t, q, p, dHdq, dHdp);
    return TimeDeduced().time_derivative(t, q, p);
  }
};

/// The time beside the columns, of a type of its own.
struct TimeBeside : Sized<2> {
  template <class Time, class Column>
  Time energy(Time t, const Column& q, const Column& p) const {
    using std::cos;
    return Time(q.dot(q)) / 2 * cos(t) + Time(p.dot(p)) / 2;
  }
  template <class Time, class Column, class A, class B>
  double gradient(const Time& t, const Column& q, const Column& p, A& dHdq, B& dHdp) const {
    using std::cos;
    dHdq = q * cos(t);
    dHdp = p;
    return TimeDeduced().time_derivative(t, q, p);
  }
};

/// Steppers of free motion, whose dt is deduced.
struct Drift {
  using Scalar = double;
  using State = PhasePoint<double, 2>;
  StepReport step(State& z, auto dt) {
    z.q() += dt * z.p();
    return {.status = Status::success};
  }
};
struct DriftOfNumbers : Drift {
  template <class Number>
  StepReport step(PhasePoint<Number, 2>& z, const Number& dt) {
    return Drift::step(z, dt);
  }
};
struct DriftOfAll : Drift {
  template <class Number, class Point>
  StepReport step(Point& z, const Number& dt) {
    return Drift::step(z, dt);
  }
};
struct DriftOfAnyState : Drift {
  auto step(auto&& z, const double& dt) { return Drift::step(z, dt); }
};

/// For packs, too.
struct InPacks : Sized<1> {
  using PackGradientOf = InPacks;
  auto energy(const auto& q, const auto& p) const { return q[0] * q[0] + p[0] * p[0]; }
  template <class Q, class D>
  auto gradient(const Q& q, const Q& p, D&& dHdq, D&& dHdp) const {
    dHdq[0] = 2.0 * q[0];
    dHdp[0] = 2.0 * p[0];
  }
};

struct WithParts : Sized<1> {
  using SeparableGradientOf = WithParts;
  static constexpr bool separable = true;
  auto energy(const auto& q, const auto& p) const { return (q.dot(q) + p.dot(p)) / 2; }
  auto gradient(const auto& q, const auto& p, auto& dHdq, auto& dHdp) const {
    dHdq = q;
    dHdp = p;
  }
  auto position_gradient(const auto& q, auto& dHdq) const { dHdq = q; }
  auto momentum_gradient(const auto& p, auto& dHdp) const { dHdp = p; }
  auto hessian(const auto&, const auto&, auto& matrix) const { matrix.setIdentity(); }
  auto hessian_times(const auto&, const auto&, const auto& dq, const auto& dp, auto& hq, auto& hp) const {
    hq = dq;
    hp = dp;
  }
};

struct FreeMotion {
  double t = 0;
  Status increments(const auto&, const auto& p, auto& dq, auto& dp) const {
    dq = t * p;
    dp.setZero();
    return Status::success;
  }
};
struct Flowing : Oscillator {
  Status flow(const auto& t, const auto& q, const auto& p, auto& dq, auto& dp) const {
    return FreeMotion{double(t)}.increments(q, p, dq, dp);
  }
  auto prepared(const auto& t) const { return FreeMotion{double(t)}; }
  auto flow_name() const { return std::string("free motion"); }
  auto rest_position_gradient(const auto& q, auto& dHdq) const { dHdq = q; }
};

struct FlowingBesideOutputs : Flowing {
  auto rest_position_gradient(Read q, auto& dHdq) const { dHdq = q; }
};

struct Slope {
  using Acts = OnPosition<double, 2>;
  static constexpr const char* name = "slope";
  auto energy(const auto& q) const { return q[0] * q[0]; }
  auto add_gradient(const auto& q, auto& dHdq) const { dHdq[0] += 2 * q[0]; }
};
struct Shear {
  using Acts = OnBoth<double, 2>;
  static constexpr const char* name = "shear";
  template <class Column>
  auto energy(const Column& q, const Column& p) const {
    return q[0] * p[1];
  }
  template <class Column, class Output>
  auto add_gradient(const Column& q, const Column& p, Output&& dHdq, Output&& dHdp) const {
    dHdq[0] += p[1];
    dHdp[1] += q[0];
  }
};
struct Turn {
  using Acts = OnMotion<double, 2>;
  static constexpr const char* name = "turn";
  auto add_force(const auto&, const auto& p, auto&& force) const {
    force[0] += p[1];
    force[1] -= p[0];
  }
};
struct Squares {
  using Acts = OnEach<double, 2>;
  static constexpr const char* name = "squares";
  auto energy(const auto& x) const { return x[1] * x[1]; }
  auto add_gradient(const auto& x, auto&& dHdx) const { dHdx[1] += 2 * x[1]; }
};
struct SlopeOfOutputs : Slope {
  auto add_gradient(const Eigen::Vector2d& q, auto& dHdq) const { dHdq += q; }
};
struct ShearOfOutputs : Shear {
  auto add_gradient(Read q, Read p, auto& dHdq, auto& dHdp) const {
    dHdq[0] += p[1];
    dHdp[1] += q[0];
  }
};
struct TurnOfOutputs : Turn {
  auto add_force(const Eigen::Vector2d&, const Eigen::Vector2d& p, auto& force) const {
    force += Eigen::Vector2d(p[1], -p[0]);
  }
};
struct Sheet {
  auto add_potential(const auto& x, auto& a) const { a[1] += x[0] * x[0] / 2; }
  auto add_gradient(const auto& x, const auto& v, double factor, auto& out) const {
    out[0] += factor * v[1] * x[0];
  }
};

template <class Stepper, class State>
void check_run(Stepper&& stepper, State z) {
  const State before = z;
  CHECK(integrate(stepper, z, {.dt = 0.05, .steps = 20}).ok());
  CHECK((z.vector() - before.vector()).norm() > 0.1);
}
template <class H, class State>
void check_run(const H& hamiltonian, const State& z, const std::string& what) {
  CAPTURE(what);
  check_run(Semiexplicit(hamiltonian, schemes::strang<double>()), z);
}

}  // namespace

TEST_CASE("Hamiltonians and effects may deduce all that they take and return", "[hamiltonian_door]") {
  check_run(Oscillator(), start, "gradient");
  check_run(OutputsDeduced(), start, "outputs");
  check_run(OutputsForwarded(), start, "forwarded");
  check_run(OutputsAlike(), start, "alike");
  CHECK(check_gradient(OutputsDeduced(), start).ok());
  CHECK(check_gradient(OutputsForwarded(), start).ok());
  const Autonomous driven(DrivenOutputsDeduced{});
  check_run(driven, driven.extended(start, 0), "driven");
  CHECK(check_gradient(driven, driven.extended(start, 0.7)).ok());
  const Autonomous time(TimeDeduced{});
  const Autonomous all(AllDeduced{});
  const Autonomous columns(ColumnsDeduced{});
  check_run(time, time.extended(start, 0), "time");
  check_run(all, all.extended(start, 0), "all");
  check_run(columns, columns.extended(start, 0), "columns");
  CHECK(check_gradient(time, time.extended(start, 0.7)).ok());
  CHECK(check_gradient(all, all.extended(start, 0.7)).ok());
  CHECK(check_gradient(columns, columns.extended(start, 0.7)).ok());
  const Autonomous beside(TimeBeside{});
  check_run(beside, beside.extended(start, 0), "beside");
  CHECK(check_gradient(beside, beside.extended(start, 0.7)).ok());
  check_run(Scene(Slope{}, Shear{}, Turn{}, Squares{}), start, "effects");
  check_run(Scene(SlopeOfOutputs{}, ShearOfOutputs{}, TurnOfOutputs{}), start, "effects' outputs");
  check_run(Scene(effects::charges::MagneticKinetic(1.0, 1.0, Sheet{})),
            PhasePoint<double, 3>({1, 0, 0}, {0, 1, 0}), "field");
  const Autonomous charge(effects::charges::RelativisticCharge(1.0, 1.0, 1.0, Sheet{}));
  check_run(charge, charge.extended(PhasePoint<double, 3>({1, 0, 0}, {0, 1, 0}), 0), "charge");
}

TEST_CASE("Steppers take parts that deduce all", "[hamiltonian_door]") {
  const PhasePoint<double, 1> z(0.7, -0.2);
  check_run(Drift(), start);
  check_run(DriftOfNumbers(), start);
  check_run(DriftOfAll(), start);
  check_run(DriftOfAnyState(), start);
  check_run(FlowSplitting(Flowing{}, schemes::aba82<double>()), start);
  check_run(FlowSplitting(FlowingBesideOutputs{}, schemes::aba82<double>()), start);
  check_run(ExplicitSplitting(WithParts{}, schemes::strang<double>()), z);
  check_run(GaussLegendre(WithParts{}), z);
  CHECK(check_gradient(WithParts(), z).ok());
  CHECK(check_gradient(Flowing(), start).ok());
  Ensemble ensemble(InPacks{}, std::vector(3, z));
  CHECK(ensemble.run({.dt = 0.1, .steps = 10}).ok());
}

}  // namespace test_deduced_members
