#pragma once

#include <concepts>
#include <functional>
#include <limits>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/threads.hpp>
#include <semiexplicit/core/two_sum.hpp>
#include <semiexplicit/steppers/detail/for_each_index.hpp>

namespace semiexplicit {

/// How a step adds to the state what it moved by.
enum class Summation {
  compensated,  ///< what rounding cuts off is carried into the next step; see CompensatedUpdate
  plain         ///< rounded every step: a little faster for small systems, the errors of long runs are larger
};

/// Adds increments to a state with compensated (Kahan's) summation: what rounding cuts off in one step is
/// carried into the next, so that the sum over a long run has the error of about one rounding instead of one
/// a step. Holds two vectors of length 2d. The carry belongs to the point that the last update() made; any
/// other point starts without one.
template <class Scalar, int Dof>
class CompensatedUpdate {
 public:
  explicit CompensatedUpdate(Eigen::Index dof)
      : carry_(PhasePoint<Scalar, Dof>(dof).vector()), next_(carry_) {}

  /// Is z the very point that the last update() made?
  bool continues(const PhasePoint<Scalar, Dof>& z) const {
    const Scalar* const state = z.vector().data();
    const Scalar* const next = next_.data();
    const auto differs = [&](Eigen::Index begin, Eigen::Index end) {
      int different = 0;  // no early exit: a loop without branches is faster
      for (Eigen::Index i = begin; i < end; ++i) different |= !(state[i] == next[i]);
      return different != 0;
    };
    if constexpr (detail::fits_on_stack(Dof))
      return !differs(0, next_.size());
    else
      return !detail::any_of_many(next_.size(), differs);
  }

  /// z += increment(i) in every component i < 2d, or nothing at all and false where one would not be finite.
  /// agreed(ok) may turn an update that is fine into one that is dropped; see on_all_ranks().
  template <class Increment, class Agreed = std::identity>
  bool update(PhasePoint<Scalar, Dof>& z, const Increment& increment, const Agreed& agreed = {}) {
    if (!continues(z)) carry_.setZero();
    // Small results stay in registers until they count.
    if constexpr (detail::fits_on_stack(Dof)) {
      Scalar sums[std::size_t(2 * Dof)], lost[std::size_t(2 * Dof)];
      if (!agreed(add(z.vector().data(), sums, lost, std::integral_constant<int, 2 * Dof>(), increment)))
        return drop();
      detail::for_each_index(std::integral_constant<int, 2 * Dof>(), [&](Eigen::Index i) {
        z.vector()[i] = next_[i] = sums[i];
        carry_[i] = lost[i];
      });
    } else {
      if (!agreed(add(z.vector().data(), next_.data(), carry_.data(), next_.size(), increment)))
        return drop();
      detail::for_many(next_.size(),
                       [to = z.vector().data(), from = next_.data()](Eigen::Index i) { to[i] = from[i]; });
    }
    return true;
  }

  /// Hands visit() every number that goes on from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(carry_);
    visit(next_);
  }

 private:
  /// The sums, and what rounding cut off; false where a sum is not finite.
  template <class Size, class Increment>
  bool add(const Scalar* state, Scalar* sums, Scalar* lost, Size size, const Increment& increment) {
    const Scalar* const carry = carry_.data();
    bool failed;
    if constexpr (std::same_as<Size, Eigen::Index>)
      failed = detail::any_of_many(size, [&](Eigen::Index begin, Eigen::Index end) {
        return !add_part(state, carry, sums, lost, begin, end - begin, increment);
      });
    else
      failed = !add_part(state, carry, sums, lost, 0, size, increment);
    return !failed;
  }
  bool drop() {
    next_.setConstant(std::numeric_limits<Scalar>::quiet_NaN());  // no state equals it: the carry is dropped
    return false;
  }
  /// The same of `size` numbers from `begin` on. (The carry may be where `lost` is.)
  template <class Size, class Increment>
  SEMIEXPLICIT_INLINE static bool add_part(const Scalar* state, const Scalar* carry, Scalar* __restrict sums,
                                           Scalar* lost, Eigen::Index begin, Size size,
                                           const Increment& increment) {
    Scalar not_finite(0);  // becomes NaN
    detail::for_each_index(size, [&](Eigen::Index k) {
      const Eigen::Index i = begin + k;
      const auto [sum, rest] = detail::two_sum<Scalar>(state[i], increment(i) + carry[i]);
      lost[i] = rest;
      sums[i] = sum;
      not_finite += sum - sum;
    });
    return not_finite == Scalar(0);
  }

  typename PhasePoint<Scalar, Dof>::Storage carry_, next_;
};

}  // namespace semiexplicit
