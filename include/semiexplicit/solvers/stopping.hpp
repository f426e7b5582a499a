#pragma once

#include <algorithm>
#include <concepts>
#include <limits>
#include <stdexcept>
#include <string>

#include <Eigen/Core>

#include <semiexplicit/core/inlined.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/core/solver.hpp>

namespace semiexplicit {

/// When the projection's iteration has come close enough, judged by e, the size of the solver's next
/// correction (for the simplified Newton ‖f‖/4), the size of the multiplier ‖m‖ and that of the state ‖z‖
/// (Euclidean norms).
struct StoppingRule {
  enum class Kind { paper, product };

  Kind kind = Kind::product;
  double tolerance = 1e-16;

  static constexpr const char* name = "StoppingRule";

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("kind", kind);
    list("tolerance", tolerance);
  }

  /// e < ε, absolute, as Jayawardana and Ohsawa (eq. "proj-error"). An ε below about 1e-16 ‖z‖ is under the
  /// rounding floor.
  static constexpr StoppingRule paper(double epsilon) { return {Kind::paper, epsilon}; }

  /// e (‖m‖ + e) ≤ τ ‖z‖². The step ends with the mean of the copies, whose errors of symplecticity, of
  /// quadratic invariants and of reversibility are of this product's size, so τ is a relative drift budget a
  /// step, below 1; it scales with the state. For ‖z‖ counts at most `moves` times what a step moves: an
  /// angle that is not wound back, or a drift far from the origin, would loosen the rule without limit.
  static constexpr StoppingRule product(double tau = 1e-16) { return {Kind::product, tau}; }

  static constexpr int moves = 100;

  /// NaN in any argument is never accepted.
  template <class Scalar>
  bool accepts(const Scalar& e, const Scalar& size_m, const Scalar& size_z) const {
    return accepts(e, size_m, [&] { return size_z; });
  }
  /// The same with a function that gives ‖z‖, which is called if the rule needs it.
  template <class Scalar, std::invocable SizeOfState>
  SEMIEXPLICIT_INTO_CALLER bool accepts(const Scalar& e, const Scalar& size_m,
                                        const SizeOfState& size_of_state) const {
    const Scalar bound = static_cast<Scalar>(tolerance);
    if (kind == Kind::paper) return e < bound;
    if (e == Scalar(0)) return true;
    // As a product of ratios: the squares of very small or very large states have no room in the exponent.
    const Scalar size_z = size_of_state();
    return (e / size_z) * ((size_m + e) / size_z) <= bound;
  }
};

namespace detail {

/// Throws std::invalid_argument, naming the solver and the remedy, for options that make no sense.
inline void require_options(const char* solver, const StoppingRule& rule, int max_iterations) {
  const auto refuse = [&](const char* why) { throw std::invalid_argument(std::string(solver) + ": " + why); };
  if (!(rule.tolerance >= 0 && rule.tolerance <= std::numeric_limits<double>::max()))
    refuse("the tolerance of the stopping rule is negative, NaN or Inf; give 0 or more, 1e-16 say");
  if (rule.kind == StoppingRule::Kind::product && rule.tolerance >= 1)
    refuse(
        "the tolerance of the product rule, relative to the state, is 1 or more, so that any step would do; "
        "give less, 1e-16 say");
  if (max_iterations < 1) refuse("max_iterations is below 1; give the evaluations that a step may take");
}

/// See AnyResidual::within_rounding().
template <class Scalar>
bool within_rounding(const Scalar* f, const Scalar* z, Eigen::Index size, const Scalar& distance,
                     double multiple) {
  using std::abs;
  const Scalar roundings = 4 * Scalar(multiple) * Eigen::NumTraits<Scalar>::epsilon();
  for (Eigen::Index i = 0; i < size; ++i)
    if (!(abs(f[i]) <= roundings * (abs(z[i]) + distance))) return false;
  return true;
}

/// See AnyResidual::farthest(). At other solutions, where many steps of that dt fail, ‖m‖ was above half of
/// the state, and at the step's own in 99.9 % below 1e-3 of it. By the move, too: angles that have wound up
/// are no measure; nor is a state at rest whose momenta are about to outweigh it.
template <class Scalar>
Scalar farthest(const Scalar& size_z, const Scalar& move, const Scalar& rounding_level) {
  using std::max;
  using std::min;
  return min(max(size_z, move), Scalar(2 * move)) / 16 + rounding_level;
}

/// The sizes of both halves of z, but no more than so many times what they moved, see StoppingRule, nor less
/// than that. `moved` is twice the move of the mean of the copies; the first `own` entries of a half count.
template <class Where, class Vec>
SizesOfHalves<typename Vec::Scalar> sizes_of_halves(const Where& where, const Vec& z, const Vec& moved,
                                                    Eigen::Index own) {
  using Scalar = typename Vec::Scalar;
  const auto size = [&](Eigen::Index begin) {
    const Scalar move = norm_over_ranks(where, moved.segment(begin, own)) / 2;
    return std::max<Scalar>(
        std::min<Scalar>(norm_over_ranks(where, z.segment(begin, own)), StoppingRule::moves * move), move);
  };
  const Scalar q = size(0);
  return {q, size(z.size() / 2)};
}

/// Norms that are known: ‖z‖, without the time where that is a coordinate, and how far the mean of the copies
/// moved.
template <class Scalar>
struct KnownNorms {
  Scalar z{}, move{};
  Scalar size() const { return z; }
  Scalar distance() const { return move; }
};

/// What solvers ask of a residual beside its values (AnyResidual), from the sizes of the state and of the
/// last evaluation. `Norms` has the members of KnownNorms; where it works them out, only the rules that need
/// them pay.
template <class Scalar, class Norms = KnownNorms<Scalar>>
struct ResidualSizes {
  const Scalar* z_data = nullptr;
  const Scalar* f_data = nullptr;
  Eigen::Index count = 0;
  Norms norms;
  Scalar rounding = Eigen::NumTraits<Scalar>::epsilon();  ///< of f, relative; more where differences enter it
  bool linear = false;                                    ///< f is, and has one solution

  /// ‖z‖, but no more than so many moves of a step: see StoppingRule.
  Scalar state_size() const {
    const Scalar moves = StoppingRule::moves * norms.distance(), size = norms.size();
    return moves < size ? moves : size;
  }
  Scalar farthest() const {
    if (linear) return std::numeric_limits<Scalar>::infinity();
    return detail::farthest<Scalar>(norms.size(), norms.distance(), rounding_level());
  }
  /// A correction below this may be nothing but rounding: the copies' own, made larger by the kicks in
  /// between.
  Scalar rounding_level() const { return 100 * rounding * (norms.size() + norms.distance()); }
  /// An iteration that no longer shrinks is allowed the rounding of differences; one that does is not.
  bool within_rounding(double multiple) const {
    const auto unit = static_cast<double>(rounding / Eigen::NumTraits<Scalar>::epsilon());
    return on_all_ranks<Scalar>(norms, detail::within_rounding(f_data, z_data, count, norms.distance(),
                                                               multiple < 1 ? multiple : multiple * unit));
  }
  /// Of a state in blocks; see SumsOverRanks.
  Scalar sum_over_ranks(const Scalar& x) const requires SumsOverRanks<Norms, Scalar> {
    return norms.sum_over_ranks(x);
  }
};

/// The bookkeeping that every solver shares: after each evaluation, is this the end, and how?
template <class Scalar>
class Convergence {
 public:
  /// With `creeps` an m of so many first corrections is suspected to be another solution's.
  Convergence(const StoppingRule& rule, int max_iterations,
              double creeps = std::numeric_limits<double>::infinity())
      : rule_(rule), max_iterations_(max_iterations), creeps_(creeps) {}

  /// Takes the next correction's size; true: stop, report() says why. `residual` knows the sizes of state and
  /// rounding. Inlined, so that the bookkeeping of a single evaluation is in registers: in memory it is
  /// written number by number and then copied as a whole, which waits for the last of them.
  template <class Residual>
  SEMIEXPLICIT_INTO_CALLER bool done(const Scalar& e, const Scalar& size_m, const Residual& residual) {
    using std::isfinite;
    using std::sqrt;
    ++report_.evaluations;
    const bool first = ++judged_ == 1;
    const Scalar previous = report_.correction;
    report_.correction = e;
    if (!first) report_.rate = e / previous;
    if (first) first_ = e;
    if (first || e > largest_) largest_ = e;
    if (first || e < best_ / 2) {
      best_ = e;
      stalled_ = 0;
    } else {
      ++stalled_;
    }
    if (!isfinite(e))
      report_.status = Status::not_finite;
    else if (rule_.accepts(e, size_m, [&] { return residual.state_size(); }))
      report_.status = Status::success;
    else if (residual.within_rounding(0.01))
      report_.status = Status::rounding_limited;  // m moves no digit of the copies: e would halve for ever
    else if (!first && e <= accurate_ && e <= residual.rounding_level() &&
             // Not after a correction that was worse than rounding, unless that goes on.
             ((e >= previous && residual.within_rounding(100) && (e <= 8 * best_ || stalled_ >= patience)) ||
              // The rounding of a large entry, carried to others by the kicks; an iteration that converges or
              // diverges slowly has shrunk or grown by then.
              (stalled_ >= 3 * patience && e <= 64 * best_)))
      report_.status = Status::rounding_limited;
    else {
      // Copies that diverge have a rounding level above the state itself; the first sweep's is believed.
      if (first) {
        accurate_ = residual.rounding_level() / (100 * sqrt(Eigen::NumTraits<Scalar>::epsilon()));
        farthest_ = residual.farthest();
      }
      return exhausted();
    }
    // An iteration that went astray may end at another solution, far from the step's.
    const bool astray = largest_ > 2 * first_ || size_m > Scalar(creeps_) * first_;
    if (report_.status != Status::not_finite && astray && !(size_m <= farthest_)) {
      distant_ = report_.status;
      report_.status = Status::no_convergence;
    }
    return true;
  }

  /// Whether the end was refused for its distance alone, and what takes it nevertheless.
  bool refused_as_distant() const { return distant_ != Status::no_convergence; }
  void take_distant() { report_.status = distant_; }

  /// One more evaluation, which is not judged.
  void count() { ++report_.evaluations; }
  /// Whether none is left; after `more` that are not counted yet.
  bool exhausted(int more = 0) const { return report_.evaluations + more >= max_iterations_; }

  const SolverReport<Scalar>& report() const { return report_; }

 private:
  StoppingRule rule_;
  int max_iterations_, judged_ = 0;
  double creeps_;
  static constexpr int patience = 8;  ///< corrections in which one that diverges shows
  int stalled_ = 0;                   ///< corrections since the smallest was halved
  Scalar first_ = 0, largest_ = 0, best_ = 0;
  Scalar accurate_ = 0;                                        ///< nothing larger passes for rounding
  Scalar farthest_ = std::numeric_limits<Scalar>::infinity();  ///< that a step's own solution may be
  Status distant_ = Status::no_convergence;
  SolverReport<Scalar> report_;
};

}  // namespace detail
}  // namespace semiexplicit
