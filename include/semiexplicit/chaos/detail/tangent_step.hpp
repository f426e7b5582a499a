#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <utility>
#include <vector>

#include <semiexplicit/chaos/detail/hessian_product.hpp>
#include <semiexplicit/core/stepper.hpp>
#include <semiexplicit/steppers/detail/kick.hpp>
#include <semiexplicit/steppers/explicit_splitting.hpp>
#include <semiexplicit/steppers/midpoint_projection.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit::detail {

/// to += t J product, for 2d numbers. Not inlined where they are many: g++ vectorises the loops on their own,
/// and not within the sweep.
template <class Scalar>
SEMIEXPLICIT_NOINLINE void add_to_many(const Scalar& t, const Scalar* __restrict product,
                                       Scalar* __restrict to, Eigen::Index d) {
  for (Eigen::Index i = 0; i < d; ++i) to[i] += t * product[d + i];
  for (Eigen::Index i = 0; i < d; ++i) to[d + i] -= t * product[i];
}

/// Columns of 2d numbers, tangent vectors of a phase space.
template <class Scalar, int Dof>
using Frame = Eigen::Matrix<Scalar, twice(Dof), Eigen::Dynamic>;

/// Two copies of a phase point with up to N tangent vectors each, z + Σ vⱼ εⱼ, for a gradient that takes dual
/// numbers: the kicks of a step on such numbers move the points and their vectors.
template <class Scalar, int N>
struct MovingCopies {
  using Number = Dual<Scalar, N>;
  using Points = std::vector<Number, Eigen::aligned_allocator<Number>>;
  Points a, b, gradient;

  explicit MovingCopies(Eigen::Index size) : a(static_cast<std::size_t>(size)), b(a), gradient(a) {}

  /// How many of the columns from `first` on it takes.
  template <class V>
  static Eigen::Index taken(const V& v, Eigen::Index first) {
    return std::min<Eigen::Index>(N, v.cols() - first);
  }
  template <class Z, class V>
  static void join(const Z& z, const V& v, Eigen::Index first, Points& to) {
    const Eigen::Index count = taken(v, first);
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      Number& x = to[static_cast<std::size_t>(i)];
      x.value = z[i];
      for (Eigen::Index k = 0; k < count; ++k) x.derivative[k] = v(i, first + k);
    }
  }
  template <class Z, class V>
  static void part(const Points& from, Z& z, V& v, Eigen::Index first) {
    const Eigen::Index count = taken(v, first);
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const Number& x = from[static_cast<std::size_t>(i)];
      z[i] = x.value;
      for (Eigen::Index k = 0; k < count; ++k) v(i, first + k) = x.derivative[k];
    }
  }
};

/// The tangent vectors of a Hamiltonian whose gradient takes dual numbers, and gives no product, go along in
/// groups that fill registers, and what few are left one by one.
template <class H>
struct MovingGroups {
  using Scalar = typename H::Scalar;
  static constexpr bool apply = HasDualGradient<H> && !HasHessianTimes<H>;
  static constexpr int many = 8;
  MovingCopies<Scalar, 1> one;
  MovingCopies<Scalar, many> several;

  MovingGroups(Eigen::Index dof, Eigen::Index columns)
      : one(apply ? 2 * dof : 0), several(apply && columns > many / 2 ? 2 * dof : 0) {}

  /// f(copies, the first column that they take), for all columns.
  template <class F>
  void each(Eigen::Index columns, const F& f) {
    Eigen::Index j = 0;
    for (; columns - j > many / 2; j = std::min(j + many, columns)) f(several, j);
    for (; j < columns; ++j) f(one, j);
  }
};

/// The derivative of a stepper's step, applied to tangent vectors. Specialised for the steppers whose
/// derivative is known.
template <class Stepper>
class TangentStep {
  template <class T>
  static constexpr bool known = false;
  static_assert(known<Stepper>,
                "the derivative of this stepper's step is not known: give TangentVectors, LyapunovExponents "
                "and AlignmentIndex a Semiexplicit, a MidpointProjection or an ExplicitSplitting");
};

/// Of a stepper that chooses its steps: the derivative of each at its own length. dt is the time of the step
/// here.
template <ChoosesSteps S>
class TangentStep<S> : public TangentStep<typename S::Fixed> {
 public:
  TangentStep(const S& chooser, Eigen::Index columns)
      : TangentStep<typename S::Fixed>(chooser.stepper(), columns) {}
};

/// What the doubled steps share: the kicks on two copies of a phase point and on two copies of its tangent
/// vectors, which each kick moves by its derivative, db += t J ∇²H(a) da.
template <class H>
class DoubledTangents {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  using Vectors = Frame<Scalar, H::Dof>;

  DoubledTangents(const H& hamiltonian, const Scheme<Scalar>& scheme, Eigen::Index columns)
      : hamiltonian_(hamiltonian),
        scheme_(scheme),
        second_(dof_of(hamiltonian_), columns),
        groups_(dof_of(hamiltonian_), columns),
        a(State(dof_of(hamiltonian_)).vector()),
        b(a),
        m(a),
        f(a),
        gradient_(a),
        da(Vectors::Zero(a.size(), columns)),
        db(da),
        w(da),
        g(da) {}

  /// The copies z ± m and, with `tangents`, v ± w go through all kicks; f and g become the residuals of the
  /// projection.
  template <bool tangents>
  void sweep(const State& z, const Vectors& v, const Scalar& dt) {
    if constexpr (tangents && MovingGroups<H>::apply) {
      groups_.each(v.cols(), [&](auto& copies, Eigen::Index j) {
        copies.join(z.vector() + m, v + w, j, copies.a);
        copies.join(z.vector() - m, v - w, j, copies.b);
        inlined<Scalar>([&] {
          kicks(hamiltonian_, scheme_, dt, copies.a.data(), copies.b.data(), copies.gradient.data(), z.dof());
        });
        copies.part(copies.a, a, da, j);
        copies.part(copies.b, b, db, j);
      });
    } else {
      a = z.vector() + m;
      b = z.vector() - m;
      if constexpr (tangents) {
        da = v + w;
        db = v - w;
      }
      inlined<Scalar>([&] {
        detail::sweep(
            scheme_, dt, [&](const Scalar& t) { kick<tangents>(t, a, da, b, db); },
            [&](const Scalar& t) { kick<tangents>(t, b, db, a, da); });
      });
    }
    f = a - b + 2 * m;
    drop_time<H>(z.vector(), f, scheme_.kicks());
    if constexpr (tangents) g = da - db + 2 * w;
  }

  /// How far the mean of the copies moved, of the point and of the vectors.
  Scalar distance(const State& z) {
    gradient_ = (a + b) / 2 - z.vector();
    return norm(gradient_);
  }
  /// The sizes of its positions and of its momenta, see sizes_of_halves().
  template <class Where>
  SizesOfHalves<Scalar> halves(const Where& where, const State& z) {
    gradient_ = a + b - 2 * z.vector();
    return sizes_of_halves(where, z.vector(), gradient_, own_dof<H>(z.dof()));
  }
  Scalar tangent_distance(const Vectors& v) const {
    return norm(((da.reshaped() - v.reshaped()) + (db.reshaped() - v.reshaped())) / 2);
  }

  /// Whether a step of size dt can start from z.
  Status check(const State& z, const Scalar& dt) const {
    return status_at_start(dt, !scheme_.b.empty(), z.vector().size() == a.size() && all_finite(z.vector()));
  }

  /// v becomes the mean of the copies; false, and v untouched, where that is not finite.
  bool finish(Vectors& v) {
    g = (da + db) / 2;
    if (!all_finite(g)) return false;
    v.swap(g);
    return true;
  }

  HessianProduct<H>& second() { return second_; }
  const HessianProduct<H>& second() const { return second_; }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<Scalar>& scheme() const { return scheme_; }

 private:
  template <bool tangents>
  SEMIEXPLICIT_INLINE void kick(const Scalar& t, const Vec& from, const Vectors& dfrom, Vec& to,
                                Vectors& dto) {
    const Eigen::Index d = from.size() / 2;
    if constexpr (tangents) {
      second_.prepare(hamiltonian_, from);
      for (Eigen::Index j = 0; j < dfrom.cols(); ++j) {
        second_.times(hamiltonian_, from, dfrom.data() + 2 * d * j, j, gradient_);
        if constexpr (fits_on_stack(H::Dof))
          add(t, gradient_.data(), dto.data() + 2 * d * j, d, d);
        else
          add_to_many(t, gradient_.data(), dto.data() + 2 * d * j, d);
      }
    }
    if constexpr (fits_on_stack(H::Dof) || HasRangeGradient<H>) {
      detail::kick(hamiltonian_, t, from.data(), to.data(), gradient_.data(), d);
    } else {
      gradient_at(hamiltonian_, from.data(), gradient_.data(), d);
      add_to_many(t, gradient_.data(), to.data(), d);
    }
  }

  H hamiltonian_;
  Scheme<Scalar> scheme_;
  HessianProduct<H> second_;
  MovingGroups<H> groups_;

 public:
  Vec a, b, m, f;

 private:
  Vec gradient_;

 public:
  Vectors da, db, w, g;
};

/// Of the projected step: with (a', b') = sweep(z + m, z - m) and f = a' - b' + 2m = 0, a tangent vector v
/// takes w with (da', db') = tangent sweep(v + w, v - w) and g = da' - db' + 2w = 0, and becomes (da' +
/// db')/2: the same equation, linearised at its solution, and solved by the stepper's own solver to its own
/// rule, so that vᵀJu is kept as the step keeps symplecticity. The simplified Newton method solves both in
/// one go: in most steps one sweep of the point with its vectors is all.
template <class H, class Solver>
class TangentStep<Semiexplicit<H, Solver>> {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vectors = Frame<Scalar, H::Dof>;

  TangentStep(const Semiexplicit<H, Solver>& stepper, Eigen::Index columns)
      : copies_(stepper.hamiltonian(), stepper.scheme(), columns),
        solver_(stepper.solver()),
        multiplier_(copies_.m),
        stacked_(Stacked::Zero(together ? 0 : copies_.w.size())),
        work_(solver_, multiplier_.size()),
        tangent_work_(solver_, stacked_.size()) {}

  /// v becomes the image of its columns, which have length one, by the derivative of the step from z;
  /// untouched unless ok.
  StepReport operator()(const State& z, Vectors& v, const Scalar& dt) {
    StepReport report{.status = copies_.check(z, dt)};
    if (!report.ok()) return report;
    copies_.second().begin();
    if constexpr (together)
      solve_together(z, v, dt, report);
    else
      solve_in_turn(z, v, dt, report);
    if (report.ok() && !copies_.finish(v)) report.status = Status::not_finite;
    return report;
  }

  HessianProduct<H>& second() { return copies_.second(); }
  const H& hamiltonian() const { return copies_.hamiltonian(); }
  const Scheme<Scalar>& scheme() const { return copies_.scheme(); }

 private:
  static constexpr bool together = std::same_as<Solver, SimplifiedNewton>;
  using Vec = typename State::Storage;
  using Stacked = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// The sizes that the stopping rule judges by, of the point or of the vectors.
  using Sizes = ResidualSizes<Scalar>;
  Sizes sizes(const State& z) {
    return {z.vector().data(),
            copies_.f.data(),
            copies_.f.size(),
            {detail::state_size(copies_.hamiltonian(), z), copies_.distance(z)}};
  }
  Sizes tangent_sizes(const Vectors& v) const {
    return {v.data(),
            copies_.g.data(),
            v.size(),
            {norm(v.reshaped()), copies_.tangent_distance(v)},
            copies_.second().rounding(),
            true};
  }

  void solve_together(const State& z, const Vectors& v, const Scalar& dt, StepReport& report) {
    auto orbit = solver_.template convergence<Scalar>(), tangent = orbit;
    copies_.m.setZero();
    copies_.w.setZero();
    Scalar size_m(0), size_w(0);
    for (bool settled = false;;) {
      copies_.template sweep<true>(z, v, dt);
      if (!settled) settled = orbit.done(norm(copies_.f) / 4, size_m, sizes(z));
      if (tangent.done(norm(copies_.g.reshaped()) / 4, size_w, tangent_sizes(v)) && settled) break;
      if (settled && !orbit.report().ok()) break;
      // The point rests once it is found: with it rest the rounding errors of differences, and the equation
      // of w is linear.
      if (!settled) copies_.m -= copies_.f / 4;
      copies_.w -= copies_.g / 4;
      size_m = norm(copies_.m);
      size_w = norm(copies_.w.reshaped());
      copies_.second().keep_shifts();
    }
    tangent.report().tell(report);
    if (!orbit.report().ok()) report.status = orbit.report().status;
  }

  void solve_in_turn(const State& z, const Vectors& v, const Scalar& dt, StepReport& report) {
    OrbitResidual orbit{{}, *this, z, v, dt};
    const auto solved = solver_.solve(orbit, multiplier_, work_);
    report.status = solved.status;
    if (!solved.ok()) return;
    TangentResidual tangent{{}, *this, z, v, dt};
    solver_.solve(tangent, stacked_, tangent_work_).tell(report);
  }

  /// f and g as the solvers see them; of vectors all positions come before all momenta, as in a state.
  struct OrbitResidual : Sizes {
    TangentStep& step;
    const State& z;
    const Vectors& v;
    const Scalar& dt;

    void operator()(Vec& f) { evaluate(step.copies_.m.setZero(), f); }
    void operator()(const Vec& m, Vec& f) { evaluate(step.copies_.m = m, f); }
    void evaluate(const Vec&, Vec& f) {
      step.copies_.template sweep<false>(z, v, dt);
      f = step.copies_.f;
      static_cast<Sizes&>(*this) = step.sizes(z);
    }
    SizesOfHalves<Scalar> halves() const { return step.copies_.halves(*this, z); }
  };
  struct TangentResidual : Sizes {
    TangentStep& step;
    const State& z;
    const Vectors& v;
    const Scalar& dt;

    void operator()(Stacked& g) { evaluate(step.copies_.w.setZero(), g); }
    void operator()(const Stacked& w, Stacked& g) {
      const Eigen::Index half = w.size() / 2, d = z.dof();
      step.copies_.w.topRows(d).reshaped() = w.head(half);
      step.copies_.w.bottomRows(d).reshaped() = w.tail(half);
      evaluate(step.copies_.w, g);
    }
    void evaluate(const Vectors&, Stacked& g) {
      step.copies_.template sweep<true>(z, v, dt);
      step.copies_.second().keep_shifts();
      const Eigen::Index half = g.size() / 2, d = z.dof();
      g.head(half) = step.copies_.g.topRows(d).reshaped();
      g.tail(half) = step.copies_.g.bottomRows(d).reshaped();
      static_cast<Sizes&>(*this) = step.tangent_sizes(v);
    }
    SizesOfHalves<Scalar> halves() const {
      return {norm(v.topRows(z.dof()).reshaped()), norm(v.bottomRows(z.dof()).reshaped())};
    }
  };

  DoubledTangents<H> copies_;
  Solver solver_;
  Vec multiplier_;
  Stacked stacked_;
  typename SolverDoor<Solver, Vec>::Workspace work_;
  typename SolverDoor<Solver, Stacked>::Workspace tangent_work_;
};

/// Of the mean of the copies without projection: one tangent sweep from m = w = 0.
template <class H>
class TangentStep<MidpointProjection<H>> {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vectors = Frame<Scalar, H::Dof>;

  TangentStep(const MidpointProjection<H>& stepper, Eigen::Index columns)
      : copies_(stepper.hamiltonian(), stepper.scheme(), columns) {}

  StepReport operator()(const State& z, Vectors& v, const Scalar& dt) {
    StepReport report{.status = copies_.check(z, dt)};
    if (!report.ok()) return report;
    copies_.second().begin();
    copies_.template sweep<true>(z, v, dt);
    report.evaluations = 1;
    if (!copies_.finish(v)) report.status = Status::not_finite;
    return report;
  }

  HessianProduct<H>& second() { return copies_.second(); }
  const H& hamiltonian() const { return copies_.hamiltonian(); }
  const Scheme<Scalar>& scheme() const { return copies_.scheme(); }

 private:
  DoubledTangents<H> copies_;
};

/// Of drifts q += t ∂T/∂p and kicks p -= t ∂V/∂q: dq += t (∇²H v)_p and dp -= t (∇²H v)_q.
template <class H>
class TangentStep<ExplicitSplitting<H>> {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  using Vectors = Frame<Scalar, H::Dof>;

  TangentStep(const ExplicitSplitting<H>& stepper, Eigen::Index columns)
      : hamiltonian_(stepper.hamiltonian()),
        scheme_(stepper.scheme()),
        second_(stepper.dof(), columns),
        groups_(stepper.dof(), columns),
        at_(State(stepper.dof()).vector()),
        gradient_(at_),
        moved_(Vectors::Zero(at_.size(), columns)) {}

  StepReport operator()(const State& z, Vectors& v, const Scalar& dt) {
    StepReport report{.status = status_at_start(dt, !scheme_.b.empty(),
                                                z.vector().size() == at_.size() && all_finite(z.vector()))};
    if (!report.ok()) return report;
    if constexpr (MovingGroups<H>::apply)
      groups_.each(v.cols(), [&](auto& copies, Eigen::Index j) {
        copies.join(z.vector(), v, j, copies.a);
        flows(dt, copies.a.data(), copies.gradient.data(), [](auto&&...) {});
        copies.part(copies.a, at_, moved_, j);
      });
    else
      along_orbit(z, v, dt);
    report.evaluations = 1;
    if (all_finite(moved_))
      v.swap(moved_);
    else
      report.status = Status::not_finite;
    return report;
  }

  HessianProduct<H>& second() { return second_; }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<Scalar>& scheme() const { return scheme_; }

 private:
  /// All flows of `at`; before each is called before(t, from, to), where it adds t times the half of the
  /// gradient that begins at `from` to the half at `to`.
  template <class Number, class Before>
  void flows(const Scalar& dt, Number* at, Number* gradient, const Before& before) {
    const Eigen::Index d = at_.size() / 2;
    const auto flow = [&](const Scalar& t, Eigen::Index from, Eigen::Index to) {
      before(t, from, to);
      gradient_on(hamiltonian_, at, gradient, d);
      for (Eigen::Index i = 0; i < d; ++i) add_multiple<Eigen::Index>(at[to + i], t, gradient[from + i]);
    };
    sweep(
        scheme_, dt, [&](const Scalar& t) { flow(t, d, 0); }, [&](const Scalar& t) { flow(-t, 0, d); });
  }

  /// The vectors by products at every point of the orbit.
  void along_orbit(const State& z, const Vectors& v, const Scalar& dt) {
    const Eigen::Index d = z.dof();
    second_.begin();
    at_ = z.vector();
    moved_ = v;
    flows(dt, at_.data(), gradient_.data(), [&](const Scalar& t, Eigen::Index from, Eigen::Index to) {
      second_.prepare(hamiltonian_, at_);
      for (Eigen::Index j = 0; j < moved_.cols(); ++j) {
        second_.times(hamiltonian_, at_, moved_.data() + 2 * d * j, j, gradient_);
        moved_.col(j).segment(to, d) += t * gradient_.segment(from, d);
      }
    });
  }

  H hamiltonian_;
  Scheme<Scalar> scheme_;
  HessianProduct<H> second_;
  MovingGroups<H> groups_;
  Vec at_, gradient_;
  Vectors moved_;
};

}  // namespace semiexplicit::detail
