#pragma once

#include <algorithm>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/gradient_size.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/parameters.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/solver.hpp>
#include <semiexplicit/core/split_hamiltonian.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/schemes/near_integrable.hpp>
#include <semiexplicit/solvers/simplified_newton.hpp>
#include <semiexplicit/steppers/detail/compensated_update.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>

namespace semiexplicit {

namespace detail {

// A part that takes other arguments than those of its concept, or wants an H that is not const, would be
// taken for absent; a template has no address and is called as it may be meant.
template <class H>
concept NamesPositionRest = requires {
  &H::rest_position_gradient;
}
|| requires(H& h, const InColumn<H>& at, OutColumn<H>& out) { h.rest_position_gradient(at, out); }
|| requires(H& h, const InColumn<H>& at, OutColumn<H>& out) { h.rest_position_gradient(at, at, out); };
template <class H>
concept NamesMomentumRest = requires {
  &H::rest_momentum_gradient;
}
|| requires(H& h, const InColumn<H>& at, OutColumn<H>& out) { h.rest_momentum_gradient(at, out); }
|| requires(H& h, const InColumn<H>& at, OutColumn<H>& out) { h.rest_momentum_gradient(at, at, out); };
template <class H>
concept NamesCoupledRest = requires {
  &H::coupled_rest;
}
|| requires(H& h) { h.coupled_rest(); };
struct NothingPrepared {};
template <class H>
struct PreparedFlowOf {
  using Type = NothingPrepared;
};
template <HasPreparedFlow H>
struct PreparedFlowOf<H> {
  using Type =
      std::remove_cvref_t<decltype(std::declval<const H&>().prepared(std::declval<typename H::Scalar>()))>;
};
template <class H>
concept SaysQuadraticByFunction = requires {
  requires points_to_function<decltype(&H::flow_is_quadratic)>;
};
/// What is wrong with the outputs of the flow, prepared or not, which is asked how it went, and of the
/// gradients of the rest, which are not.
template <class H>
constexpr OutputFaults faults_of_parts() {
  using Column = Vector<typename H::Scalar, H::Dof>;
  using At = const Column&;
  const auto flow = [](const auto& h, auto& out) -> decltype(void(h.flow(
                                                     std::declval<const typename H::Scalar&>(),
                                                     std::declval<At>(), std::declval<At>(), out, out))) {};
  const auto prepared = [](auto& h, auto& out) -> decltype(void(h.increments(
                                                   std::declval<At>(), std::declval<At>(), out, out))) {};
  const auto position = [](const auto& h,
                           auto& out) -> decltype(h.rest_position_gradient(std::declval<At>(), out)) {};
  const auto momentum = [](const auto& h,
                           auto& out) -> decltype(h.rest_momentum_gradient(std::declval<At>(), out)) {};
  return output_faults<decltype(flow), H, Column>() |
         output_faults<decltype(prepared), typename PreparedFlowOf<H>::Type, Column>() |
         output_faults<decltype(position), H, OutColumn<H>>() |
         output_faults<decltype(momentum), H, OutColumn<H>>();
}
/// Whether one of them takes a number behind its outputs, where a default stands in for it.
template <class H>
constexpr bool part_ends_with_a_number() {
  using Column = Vector<typename H::Scalar, H::Dof>;
  return ends_with_a_number<5>(pointer_to_flow<H, Column>()) ||
         ends_with_a_number<2>(pointer_to_rest_position_gradient<H, OutColumn<H>, OutColumn<H>, true>()) ||
         ends_with_a_number<2>(pointer_to_rest_momentum_gradient<H, OutColumn<H>, OutColumn<H>, true>());
}
/// Whether the flow's A is quadratic in p and the rest depends on q alone; see NearIntegrable.
template <class H>
constexpr bool has_nystrom_lists() {
  if constexpr (requires { H::flow_is_quadratic; })
    return H::flow_is_quadratic && HasPositionRest<H> && !HasMomentumRest<H> && !HasCoupledRest<H>;
  else
    return false;
}
template <class H>
struct CoupledRestOf {
  using Type = void;
};
template <HasCoupledRest H>
struct CoupledRestOf<H> {
  using Type = std::remove_cvref_t<decltype(std::declval<const H&>().coupled_rest())>;
};
/// Compiles unless the coupled rest is a Hamiltonian with a mistake.
template <class H>
consteval bool coupled_rest_writes() {
  if constexpr (HasCoupledRest<H>)
    return is_hamiltonian<typename CoupledRestOf<H>::Type>();
  else
    return true;
}

}  // namespace detail

/// Splitting of H = A + V + T + C where A has an exact flow: A(a₀dt) B(b₀dt) A(a₁dt) ... on one copy of the
/// phase space with the list of a NearIntegrable. A kick B(t) of the rest is V(t/2) T(t/2) C(t) T(t/2)
/// V(t/2), of what there is; where there is no C, V(t/2) T(t) V(t/2) or one of the two. Only C, which couples
/// q and p, is doubled, for the length of the kick: its semiexplicit map
///
///     a = z + m, b = z - m;   b += t X(a);   a += t X(b);   f(m) = a - b + 2m = 0;   z' = (a + b)/2,
///
/// takes two gradient calls an evaluation. It is its own adjoint, because the copies change places, and
/// symplectic; and as C is small, the first evaluation is nearly always the only one. The step is symplectic
/// to the accuracy of the solve, and reversible. Its error is that of the list, and where B has several parts
/// or a C, ε³ dt² from within the kicks: with a rest that is not small the step is then of order 2, whatever
/// the list.
///
/// Sources: R. McLachlan, BIT 35 (1995) 258; J. Wisdom and M. Holman, Astron. J. 102 (1991) 1528; the map of
/// C: see Semiexplicit. Memory: nine vectors of length 2d and the solver's.
template <class H, class Solver = SimplifiedNewton>
class FlowSplitting {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  static_assert(detail::is_in_one_process<H>());
  static_assert(SplitHamiltonian<H>,
                "FlowSplitting needs a Hamiltonian with an exact flow of a part: take stepper_for(scene, "
                "exactly<...>()), or see SplitHamiltonian");
  static_assert(
      detail::HasPositionRest<H> || !detail::NamesPositionRest<H>,
      "rest_position_gradient of this Hamiltonian cannot be called: write `void rest_position_gradient("
      "In<Scalar, Dof> q, Out<Scalar, Dof> dHdq) const`");
  static_assert(
      detail::HasMomentumRest<H> || !detail::NamesMomentumRest<H>,
      "rest_momentum_gradient of this Hamiltonian cannot be called: write `void rest_momentum_gradient("
      "In<Scalar, Dof> p, Out<Scalar, Dof> dHdp) const`");
  static_assert(
      detail::HasCoupledRest<H> || !detail::NamesCoupledRest<H>,
      "coupled_rest of this Hamiltonian cannot be called: write `const C& coupled_rest() const`, with a "
      "Hamiltonian C that this one keeps");
  static_assert(!detail::faults_of_parts<H>().lost,
                "flow, rest_position_gradient or rest_momentum_gradient of this Hamiltonian takes an output "
                "by value, so what it writes is lost: take it as `auto& dq`, or Out<Scalar, Dof>");
  static_assert(
      !detail::faults_of_parts<H>().answered,
      "rest_position_gradient or rest_momentum_gradient of this Hamiltonian returns a bool, an int "
      "or a Status, and nobody asks: let it return nothing, and throw, or write NaN, where there is none");
  static_assert(
      !detail::part_ends_with_a_number<H>(),
      "flow, rest_position_gradient or rest_momentum_gradient of this Hamiltonian ends with a number, "
      "which would always be its default: leave it out");
  static_assert(std::default_initializable<typename detail::PreparedFlowOf<H>::Type>,
                "what prepared() of this Hamiltonian gives cannot be made without one: give it a default "
                "constructor");
  static_assert(
      !detail::rounds<Scalar, 5, 0>(detail::pointer_to_flow<H, Vector<Scalar, Dof>>()) &&
          !detail::rounds<Scalar, 1, 0>(detail::pointer_to_prepared<H, Scalar, Scalar, true>()),
      "flow or prepared of this Hamiltonian takes the time as a whole number, or one of fewer digits than "
      "Scalar, which rounds it: write `const Scalar& t`");
  static_assert(!detail::overrides_beside(detail::pointer_to_flow<H, Vector<Scalar, Dof>>(),
                                          detail::pointer_to_prepared<H, Scalar, Scalar, true>()),
                "this Hamiltonian has a flow() of its own and inherits prepared(), which is asked instead: "
                "write both");
  static_assert(!detail::SaysQuadraticByFunction<H>,
                "flow_is_quadratic of this Hamiltonian is a function: write `static constexpr bool "
                "flow_is_quadratic = true;`");
  static_assert(detail::coupled_rest_writes<H>());
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "FlowSplitting";
  static constexpr bool has_position = detail::HasPositionRest<H>, has_momentum = detail::HasMomentumRest<H>,
                        has_coupled = detail::HasCoupledRest<H>;
  /// Whether a kick is the flow of the rest itself, for then the step has the order of the list.
  static constexpr bool kicks_exactly = !has_coupled && !(has_position && has_momentum);

  /// Throws std::invalid_argument, saying what is wrong, unless the list passes its own check and suits the
  /// Hamiltonian, and the solver's options make sense.
  FlowSplitting(H hamiltonian, NearIntegrable<Scalar> list, Solver solver = {})
      : hamiltonian_(std::move(hamiltonian)),
        list_(std::move(list)),
        solver_(std::move(solver)),
        moving_(State(dof()).vector(), State(dof()).q()),
        work_(State(dof()).vector()),
        update_(dof()),
        solver_work_(solver_, work_.m.size()) {
    list_.check();
    if (list_.nystrom && !detail::has_nystrom_lists<H>())
      throw std::invalid_argument(list_.name +
                                  " needs an exact flow that is quadratic in the momenta (flow_is_quadratic) "
                                  "and a rest that depends on positions alone; take another list "
                                  "(blanes_moan6, say)");
    if constexpr (has_coupled)
      detail::require_same_dof("FlowSplitting", dof(), "coupled rest", dof_of(hamiltonian_.coupled_rest()));
    flows_.resize(list_.a.size());
  }

  /// One step of size dt, which may be negative. z is untouched unless the report is ok(); so it stays where
  /// a gradient throws. No heap use. In the report `evaluations` are those of all kicks together (1 where
  /// nothing is doubled), `correction` and `rate` the largest of a kick; `gradients` counts the calls of the
  /// coupled rest, and a gradient in q or in p alone as half a call, rounded up.
  StepReport step(State& z, const Scalar& dt) {
    StepReport report{.status =
                          detail::status_at_start(dt, !list_.b.empty(), z.vector().size() == work_.m.size())};
    if (!report.ok()) return report;
    halves_ = 0;
    if constexpr (detail::HasPreparedFlow<H>)
      if (!(prepared_.dt == dt)) prepare(dt);
    detail::inlined<Scalar>([&] {
      if constexpr (detail::fits_on_stack(Dof)) {
        Moving moving(z.vector(), Column::Zero());
        flows(moving, dt, report);
        moving_.moved = moving.moved;
      } else {
        moving_.start = z.vector();
        moving_.at = moving_.start;
        moving_.moved.setZero();
        flows(moving_, dt, report);
      }
    });
    report.gradients = (halves_ + 1) / 2;
    if constexpr (!has_coupled) report.evaluations = 1;
    if (report.ok() &&
        !update_.update(z, [moved = moving_.moved.data()](Eigen::Index i) { return moved[i]; }))
      report.status = Status::not_finite;
    if (!report.ok() && !detail::all_finite(z.vector())) report.status = Status::invalid_state;
    return report;
  }

  /// Gradient calls that a step cannot exceed.
  std::int64_t max_gradients() const requires(!has_coupled || std::same_as<Solver, SimplifiedNewton>) {
    if constexpr (has_coupled)
      return (halves_of_step(solver_.max_iterations) + 1) / 2;
    else
      return (halves_of_step(1) + 1) / 2;
  }
  /// Gradient calls of a kick whose map of the coupled rest needs one evaluation.
  std::int64_t gradients_of_kick() const { return (halves_of_kick(1) + 1) / 2; }

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const NearIntegrable<Scalar>& list() const { return list_; }
  const Solver& solver() const { return solver_; }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("degrees of freedom", dof());
    list("flow", std::string(hamiltonian_.flow_name()));
    list("list", list_);
    list("solver", solver_);
    list.function("Hamiltonian", GradientSize(hamiltonian_));
    // What is flowed and what is kicked may change while their sum stays.
    if constexpr (has_position)
      list.function("rest in q", [this](const auto& q, const auto&) {
        Column gradient = Column::Zero(q.size());
        hamiltonian_.rest_position_gradient(q, gradient);
        return Scalar(detail::norm(gradient));
      });
    if constexpr (has_momentum)
      list.function("rest in p", [this](const auto&, const auto& p) {
        Column gradient = Column::Zero(p.size());
        hamiltonian_.rest_momentum_gradient(p, gradient);
        return Scalar(detail::norm(gradient));
      });
    if constexpr (has_coupled) list.function("coupled rest", GradientSize(hamiltonian_.coupled_rest()));
  }
  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    update_.visit_memory(visit);
  }

 private:
  using Vec = typename State::Storage;
  using Column = Vector<Scalar, Dof>;
  using Coupled = typename detail::CoupledRestOf<H>::Type;

  /// What is moved. `at` is always the rounded start + moved, so that many small moves have the rounding
  /// errors of the moves only.
  struct Moving {
    Moving(const Vec& z, const Column& half)
        : start(z), at(z), moved(Vec::Zero(z.size())), q(half), p(half), dq(half), dp(half) {}
    SEMIEXPLICIT_INLINE void move(Eigen::Index i, const Scalar& by) {
      moved[i] += by;
      at[i] = start[i] + moved[i];
    }
    Vec start, at, moved;
    Column q, p, dq, dp;
  };
  /// What the doubled map of the coupled rest works on.
  struct Work {
    explicit Work(const Vec& zero) : m(zero), a(zero), b(zero), gradient(zero), kicked(zero) {}
    Vec m, a, b, gradient, kicked;
  };

  std::int64_t halves_of_kick(std::int64_t evaluations) const {
    if (has_coupled) return (has_position ? 2 : 0) + (has_momentum ? 2 : 0) + 4 * evaluations;
    return has_position && has_momentum ? 3 : has_position || has_momentum ? 1 : 0;
  }
  std::int64_t halves_of_step(std::int64_t evaluations) const {
    return halves_of_kick(evaluations) * static_cast<std::int64_t>(list_.b.size());
  }

  void prepare(const Scalar& dt) {
    prepared_.dt = Scalar(0);  // where a flow throws, those of two steps are mixed
    for (std::size_t i = 0; i < flows_.size(); ++i)
      flows_[i] = hamiltonian_.prepared(splits() ? dt * list_.a[i] : dt);
    prepared_.dt = dt;
  }

  static constexpr bool splits() { return has_position || has_momentum || has_coupled; }

  SEMIEXPLICIT_INLINE void flows(Moving& z, const Scalar& dt, StepReport& report) {
    if constexpr (splits()) {
      const std::size_t n = list_.b.size();
      for (std::size_t i = 0;; ++i) {
        exactly(z, dt * list_.a[i], i, report);
        if (i == n || !report.ok()) return;
        kick(z, dt * list_.b[i], report);
        if (!report.ok()) return;
      }
    } else {
      exactly(z, dt, 0, report);
    }
  }

  /// A part that was limited by rounding is not forgotten for those that were not.
  static void note(StepReport& report, Status of_part) {
    if (of_part != Status::success) report.status = of_part;
  }

  SEMIEXPLICIT_INLINE void exactly(Moving& z, const Scalar& t, [[maybe_unused]] std::size_t which,
                                   StepReport& report) {
    const Eigen::Index d = dof();
    for (Eigen::Index i = 0; i < d; ++i) {
      z.q[i] = z.at[i];
      z.p[i] = z.at[d + i];
    }
    z.dq.setZero();  // for a flow that leaves out what it does not move
    z.dp.setZero();
    if constexpr (detail::HasPreparedFlow<H>)
      note(report, flows_[which].increments(z.q, z.p, z.dq, z.dp));
    else
      note(report, hamiltonian_.flow(t, z.q, z.p, z.dq, z.dp));
    if (!report.ok()) return;
    for (Eigen::Index i = 0; i < d; ++i) {
      z.move(i, z.dq[i]);
      z.move(d + i, z.dp[i]);
    }
  }

  SEMIEXPLICIT_INLINE void kick(Moving& z, const Scalar& t, StepReport& report) {
    if constexpr (has_coupled) {
      if constexpr (has_position) kick_p(z, t / 2);
      if constexpr (has_momentum) drift_q(z, t / 2);
      kick_coupled(z, t, report);
      if constexpr (has_momentum) drift_q(z, t / 2);
      if constexpr (has_position) kick_p(z, t / 2);
    } else if constexpr (has_position && has_momentum) {
      kick_p(z, t / 2);
      drift_q(z, t);
      kick_p(z, t / 2);
    } else if constexpr (has_position) {
      kick_p(z, t);
    } else {
      drift_q(z, t);
    }
  }

  SEMIEXPLICIT_INLINE void kick_p(Moving& z, const Scalar& t) {
    const Eigen::Index d = dof();
    const Eigen::Map<const Column> q(z.at.data(), d);
    Eigen::Map<Column> gradient(z.dq.data(), d);  // which H may take by reference
    gradient.setZero();                           // for one that adds, or leaves out what is 0
    hamiltonian_.rest_position_gradient(q, gradient);
    for (Eigen::Index i = 0; i < d; ++i) z.move(d + i, -t * z.dq[i]);
    ++halves_;
  }
  SEMIEXPLICIT_INLINE void drift_q(Moving& z, const Scalar& t) {
    const Eigen::Index d = dof();
    const Eigen::Map<const Column> p(z.at.data() + d, d);
    Eigen::Map<Column> gradient(z.dp.data(), d);
    gradient.setZero();
    hamiltonian_.rest_momentum_gradient(p, gradient);
    for (Eigen::Index i = 0; i < d; ++i) z.move(i, t * z.dp[i]);
    ++halves_;
  }

  SEMIEXPLICIT_INLINE void kick_coupled(Moving& z, const Scalar& t, StepReport& report) {
    Residual<Coupled> residual(hamiltonian_.coupled_rest(), work_, z.at, t);
    const auto solved = solver_.solve(residual, work_.m, solver_work_);
    note(report, solved.status);
    report.evaluations += solved.evaluations;
    report.correction = std::max(report.correction, static_cast<double>(solved.correction));
    report.rate = std::max(report.rate, static_cast<double>(solved.rate));
    report.escalations = std::max(report.escalations, solved.escalations);
    halves_ += 4 * solved.evaluations;
    if (!report.ok()) return;
    for (Eigen::Index i = 0; i < z.at.size(); ++i) z.move(i, work_.kicked[i] / 2);
  }

  /// f as the solvers see it; see Semiexplicit.
  template <class C>
  struct Residual : detail::ResidualSizes<Scalar> {
    Residual(const C& of_rest, Work& on, const Vec& point, const Scalar& time)
        : detail::ResidualSizes<Scalar>{.z_data = point.data(),
                                        .count = point.size(),
                                        .norms = {detail::norm(point), Scalar(0)}},
          coupled(of_rest),
          work(on),
          at(point),
          t(time) {}

    void operator()(Vec& f) { evaluate(nullptr, f); }
    void operator()(const Vec& m, Vec& f) { evaluate(&m, f); }
    void evaluate(const Vec* m, Vec& f) {
      if constexpr (detail::fits_on_stack(Dof)) {
        detail::inlined<Scalar>([&] {
          typename detail::StackPoint<Scalar, Dof> a, b, gradient, kicked;
          map(m, f, a.data, b.data, gradient.data, kicked.data, a.d);
          kicked.store(work.kicked.data());
        });
      } else {
        map(m, f, work.a.data(), work.b.data(), work.gradient.data(), work.kicked.data(), dof_of(coupled));
      }
      this->f_data = f.data();
      this->norms.move = detail::norm(work.kicked) / 2;
    }
    detail::SizesOfHalves<Scalar> halves() const {
      return detail::sizes_of_halves(this->norms, at, work.kicked, at.size() / 2);
    }
    template <class Size>
    SEMIEXPLICIT_INLINE void map(const Vec* m, Vec& f, Scalar* a, Scalar* b, Scalar* gradient, Scalar* kicked,
                                 Size d) {
      const auto both = detail::twice_of(d);
      detail::for_each_index(both, [&](Eigen::Index i) {
        const Scalar apart = m ? Scalar((*m)[i]) : Scalar(0);
        a[i] = at[i] + apart;
        b[i] = at[i] - apart;
        kicked[i] = Scalar(0);
      });
      detail::kick(coupled, t, a, b, gradient, d, kicked);
      detail::kick(coupled, t, b, a, gradient, d, kicked);
      detail::for_each_index(both, [&](Eigen::Index i) {
        const Scalar apart = m ? Scalar((*m)[i] + (*m)[i]) : Scalar(0);
        f[i] = (a[i] - b[i]) + apart;
      });
    }

    const C& coupled;
    Work& work;
    const Vec& at;
    const Scalar& t;
  };

  /// The step that flows_ are for. In a copy for none: they may refer to the flow that they were made of.
  struct Prepared {
    Scalar dt{};
    Prepared() = default;
    Prepared(const Prepared&) {}
    Prepared& operator=(const Prepared&) {
      dt = Scalar(0);
      return *this;
    }
  };

  H hamiltonian_;
  NearIntegrable<Scalar> list_;
  Solver solver_;
  Moving moving_;
  Work work_;
  CompensatedUpdate<Scalar, Dof> update_;
  typename detail::SolverDoor<Solver, Vec>::Workspace solver_work_;
  std::int64_t halves_ = 0;
  std::vector<typename detail::PreparedFlowOf<H>::Type> flows_;  ///< where they can be prepared
  Prepared prepared_;
};

}  // namespace semiexplicit
