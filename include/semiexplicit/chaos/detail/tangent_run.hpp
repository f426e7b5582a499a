#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/chaos/tangent_vectors.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/derivatives/shift_search.hpp>
#include <semiexplicit/observers/run_clock.hpp>

namespace semiexplicit::detail {

/// What the observers of tangent vectors share: it follows the run step by step and keeps the vectors
/// orthonormal.
template <class Stepper>
class TangentRun {
  static_assert(is_stepper<Stepper>());

 public:
  using Scalar = typename Stepper::Scalar;
  using State = PhasePoint<Scalar, Stepper::Dof>;
  /// Of the many small logarithms of a run, which floats would round off.
  using Sum = std::conditional_t<std::is_same_v<Scalar, float>, double, Scalar>;

  /// `who` is the observer's name, for what it throws.
  TangentRun(const char* who, const Stepper& stepper, Eigen::Index least, Eigen::Index count)
      : who_(who), tangents_(stepper, require(who, least, count, most(stepper))), previous_(stepper.dof()) {
    // Directions of no symmetry, in which every growth has a part, also that of a saddle p = ±q.
    auto& v = tangents_.vectors();
    for (Eigen::Index j = 0; j < v.cols(); ++j)
      for (Eigen::Index i = 0; i < v.rows(); ++i)
        v(i, j) = Scalar(std::sin(0.7 * static_cast<double>((i + 1) * (i + 1) * (j + 1))));
    orthonormalise_well();
  }

  /// How many vectors there can be: 2d, without p_t where that is the work of a driven system.
  static Eigen::Index most(const Stepper& stepper) { return 2 * stepper.dof() - (has_work ? 1 : 0); }

  /// Other vectors to start with, made orthonormal.
  template <class Derived>
  void start_with(const Eigen::MatrixBase<Derived>& vectors) {
    auto& v = tangents_.vectors();
    if (vectors.rows() != v.rows() || vectors.cols() != v.cols())
      refuse("vectors to start with are 2d rows in as many columns as it carries");
    if (!fresh()) refuse("it has begun; give the vectors to start with before the run");
    const auto before = v;
    const Scalar unit = momenta_;
    v = vectors;
    const Eigen::Index d = v.rows() / 2;
    momenta_ = unit_between<Scalar>(norm(v.topRows(d).reshaped()), norm(v.bottomRows(d).reshaped()));
    if (!begin_with_given()) {
      v = before;
      momenta_ = unit;
      refuse("the vectors to start with are not independent");
    }
    given_ = true;
  }

  /// Takes in the next state; true where that was a step, which the vectors have gone along. Throws what
  /// LyapunovExponents says.
  bool follow(const Scalar& t, const State& z, const IntegrationReport& run) {
    using Next = typename RunClock<Scalar>::Next;
    if (count() == 0) refuse("it was moved from; use the one that it was moved to, or make a new one");
    if (z.vector().size() != previous_.vector().size())
      refuse("the state has another number of degrees of freedom than the stepper");
    const bool equal = clock_.started() && z.vector() == previous_.vector();
    const Next next = clock_.relation(t, equal, run);
    if (next == Next::first) {
      choose_units(z);
      tangents_.check(z);
    }
    if (run.at_event || next == Next::changed)
      refuse(
          "an event that may change the state cuts a step, and its tangent map is not known; follow the "
          "arcs between events in runs of their own");
    if (next == Next::anew && !equal)
      refuse("another orbit begins; every orbit wants an observer of its own, from its first state on");
    if (next == Next::follows) {
      if (clock_.steps_since(t, run) != 1)
        refuse("it is shown only some of the steps, and needs every one; take every() away from it");
      const Scalar dt = clock_.interval(t, run);
      if (steps_ > 0 && (dt > Scalar(0)) != forward_)
        refuse("the time turned round; every run wants an observer of its own");
      const StepReport report = tangents_.advance(previous_, dt);
      if (!report.ok())
        throw std::runtime_error(
            std::string(who_) + ": no tangent map of the step to t = " + in_words(t, 9) + ": " +
            (run.subdivided > subdivided_ ? std::string("the step was cut into parts (subdivide), and the "
                                                        "vectors take it whole; take a smaller dt, at which "
                                                        "no step is cut")
                                          : semiexplicit::describe(report.status)));
      elapsed_ += passed(z, dt);
      forward_ = dt > Scalar(0);
      ++steps_;
    }
    clock_.set(t, run, next);
    previous_ = z;
    subdivided_ = run.subdivided;
    return next == Next::follows;
  }

  /// Modified Gram-Schmidt; put(i, j, r) is told the upper triangle R of V = QR, column by column, the
  /// diagonal of each last. Where positions and momenta differ by so much that it would lose most digits,
  /// momenta count in units in which they are as large at the start. The work p_t of a driven system does not
  /// count: the rest goes on without it, and it grows as q δq does, twice as fast where an orbit leaves.
  template <class Put>
  void orthonormalise(const Put& put) {
    auto& v = tangents_.vectors();
    leave_out_work();
    multiply_momenta(1 / momenta_);
    for (Eigen::Index j = 0; j < v.cols(); ++j) {
      for (Eigen::Index i = 0; i < j; ++i) {
        const Scalar part = dot(v.col(i), v.col(j));
        v.col(j) -= part * v.col(i);
        put(i, j, part);
      }
      const Scalar length = norm(v.col(j));
      v.col(j) /= length;
      put(j, j, length);
    }
    multiply_momenta(momenta_);
  }

  bool fresh() const { return !clock_.started(); }
  Eigen::Index count() const { return tangents_.count(); }
  const auto& vectors() const { return tangents_.vectors(); }
  const auto& scheme() const { return tangents_.scheme(); }
  const auto& hamiltonian() const { return tangents_.hamiltonian(); }
  /// The time of the run so far, with its sign, and its steps.
  double elapsed() const { return elapsed_; }
  std::int64_t steps() const { return steps_; }

  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    tangents_.visit_memory(visit);
    visit(momenta_);
    visit(previous_.vector());
    visit(elapsed_);
    visit(steps_);
    visit(forward_);
    clock_.visit_memory(visit);
  }

 private:
  using Hamiltonian = std::remove_cvref_t<decltype(std::declval<const Stepper&>().hamiltonian())>;
  static constexpr bool has_work = [] {
    if constexpr (InExtendedPhaseSpace<Hamiltonian>)
      return Hamiltonian::steps_in_time;
    else
      return false;
  }();

  /// The unit that momenta of this size count in beside positions of that: 1, unless one is above 1/√ε of
  /// the other; a power of two.
  template <class S>
  static S unit_between(const S& positions, const S& momenta) {
    using std::isfinite;
    using std::sqrt;
    const S ratio = momenta / positions, most = 1 / sqrt(Eigen::NumTraits<S>::epsilon());
    if (!isfinite(ratio) || !(ratio > S(0)) || !(ratio > most || ratio < 1 / most)) return S(1);
    return power_of_two(ratio);
  }

  /// That by the state and by second derivatives, which give it, where both have one, on the same side:
  /// either alone may be so at some places, as at q = 0 or at an angle that has wound up.
  void choose_units(const State& z) {
    const Hamiltonian& h = tangents_.hamiltonian();
    typename State::Storage gradient = z.vector(), at = gradient, there = gradient;
    gradient_at(h, z.vector().data(), gradient.data(), z.dof());
    Lengths<Hamiltonian> lengths;
    lengths.take(h, z.vector(), gradient, at, there);
    const Scalar of_state = unit_between<Scalar>(lengths.of(0, z.dof()), lengths.of(z.dof(), z.dof()));
    Scalar unit(1);
    if (of_state != Scalar(1)) {
      unit = unit_between<Scalar>(Scalar(1), tangents_.unit_of_momenta(z));
      if ((unit > Scalar(1)) != (of_state > Scalar(1))) unit = Scalar(1);
    }
    if (unit == momenta_) return;
    const Scalar before = std::exchange(momenta_, unit);
    if (given_) {
      if (!begin_with_given())
        refuse(
            "counted as the state's positions and momenta, which are far from each other, the vectors to "
            "start "
            "with are not independent; give others, or units in which both are of one size");
      return;
    }
    multiply_momenta(momenta_ / before);
    orthonormalise_well();
  }
  /// Of vectors that nearly depend on each other a pass leaves by so much less than all, and all at the last.
  void orthonormalise_well() {
    for (int pass = 0; pass < 3; ++pass) orthonormalise([](Eigen::Index, Eigen::Index, const Scalar&) {});
  }
  void leave_out_work() {
    if constexpr (has_work) tangents_.vectors().bottomRows(1).setZero();
  }
  void multiply_momenta(const Scalar& factor) {
    auto& v = tangents_.vectors();
    if (factor == Scalar(1)) return;
    for (Eigen::Index j = 0; j < v.cols(); ++j)
      for (Eigen::Index i = v.rows() / 2; i < v.rows(); ++i) v(i, j) *= factor;
  }

  /// Makes the vectors to start with orthonormal. False: they are not independent.
  bool begin_with_given() {
    auto& v = tangents_.vectors();
    leave_out_work();
    const auto given = v;
    bool independent = true;
    orthonormalise([&](Eigen::Index i, Eigen::Index j, const Scalar& part) {
      if (i != j) return;
      const Eigen::Index d = given.rows() / 2;
      const Vector<Scalar, 2> halves(norm(given.col(j).head(d)), norm(given.col(j).tail(d)) / momenta_);
      // What is left of it beside the others is more than their rounding.
      independent = independent && part > 100 * Eigen::NumTraits<Scalar>::epsilon() * norm(halves);
    });
    if (independent) orthonormalise_well();
    return independent && all_finite(v);
  }

  /// The time from the previous state to z. In an extended phase space the states have it; where dt is a
  /// step of the time what differs by no more than its rounding does not differ.
  double passed(const State& z, const Scalar& dt) const {
    using std::abs;
    if constexpr (InExtendedPhaseSpace<Hamiltonian>) {
      const Scalar before = previous_.q()[z.dof() - 1], now = z.q()[z.dof() - 1];
      const Scalar rounding =
          4 * Eigen::NumTraits<Scalar>::epsilon() * std::max<Scalar>(abs(before), abs(now));
      if (!Hamiltonian::steps_in_time || !(abs(now - before - dt) <= rounding))
        return static_cast<double>(now) - static_cast<double>(before);
    }
    return static_cast<double>(dt);
  }

  static Eigen::Index require(const char* who, Eigen::Index least, Eigen::Index count, Eigen::Index all) {
    if (all < 1)
      throw std::invalid_argument(std::string(who) +
                                  ": the stepper has no degree of freedom; give one that was not moved from, "
                                  "of a Hamiltonian that has");
    if (count < least || count > all)
      throw std::invalid_argument(std::string(who) + ": " + std::to_string(count) +
                                  (least == 1 ? " exponents" : " vectors") + " asked for; there are " +
                                  (least == 1 ? "" : std::to_string(least) + " to ") + std::to_string(all));
    return count;
  }
  [[noreturn]] void refuse(const char* why) const {
    throw std::invalid_argument(std::string(who_) + ": " + why);
  }

  const char* who_;
  TangentVectors<Stepper> tangents_;
  State previous_;
  Scalar momenta_ = Scalar(1);  ///< the unit that they count in
  bool given_ = false;          ///< the vectors to start with
  double elapsed_ = 0;
  std::int64_t steps_ = 0;
  bool forward_ = true;          ///< the steps so far
  std::int64_t subdivided_ = 0;  ///< so far, of the run's steps; for a message only, so no memory
  RunClock<Scalar> clock_;
};

}  // namespace semiexplicit::detail
