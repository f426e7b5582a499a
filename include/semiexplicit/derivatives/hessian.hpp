#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>

namespace semiexplicit::detail {

/// Looks for the shift of a central difference of the gradient: of shifts over several orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. Memory: five vectors of length 2d.
template <class H>
class ShiftSearch {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  static constexpr int most_shifts = 48;

  explicit ShiftSearch(Eigen::Index dof) : above_(dof), below_(dof) {
    for (Vec* one : {&middle_, &smaller_, &seen_}) *one = above_.vector();
  }

  /// What a difference writes its two gradients to.
  Vec& above() { return above_.vector(); }
  Vec& below() { return below_.vector(); }

  /// Of `count` shifts in geometric order from the larger one to the smaller one, that whose differences
  /// agree best with those of its two neighbours; of equals, as where the gradient is linear or even, that
  /// nearest to the usual one for a state of this size of which `own` is moved, beside entries that are no
  /// larger than `others`. difference(shift, column) writes above(), below() and their difference by the
  /// shift.
  template <class Difference>
  Scalar best(const Scalar& state_size, const Scalar& own, const Scalar& others, const Scalar& from,
              const Scalar& to, int count, const Difference& difference) {
    using std::abs;
    using std::cbrt;
    using std::log;
    using std::pow;
    const Scalar ratio = pow(to / from, Scalar(1) / Scalar(std::max(count - 1, 1)));
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar size = state_size > Scalar(0) ? state_size : Scalar(1);
    const Scalar usual = size * cbrt(epsilon * std::max<Scalar>(1, own / size));
    const auto distance = [&](const Scalar& x) { return abs(log(x / usual)); };
    const Scalar length = others > Scalar(0) ? others : Scalar(1);
    seen_.setZero();
    Scalar shift = from, best = from * pow(ratio, Scalar(count / 2)), least(1), before(1);
    bool known = false;
    for (int k = 0; k < count; ++k, shift *= ratio) {
      difference(shift, smaller_);
      if (k > 0) {
        const Scalar now = disagreement(middle_, smaller_, shift, length);
        if (known) {
          const Scalar worse = std::max(before, now);
          const Scalar here = shift / ratio;
          if (worse < least || (worse == least && distance(here) < distance(best)))
            least = worse, best = here;
        }
        before = now;
        known = true;
      }
      for (Eigen::Index j = 0; j < seen_.size(); ++j)
        if (smaller_[j] != Scalar(0)) seen_[j] = abs(smaller_[j]);
      middle_ = smaller_;
    }
    return best;
  }

  /// The same over all shifts that may be right: from the size of the state, or 1, to the rounding of what is
  /// moved, or nothing.
  template <class Difference>
  Scalar best_of_all(const Scalar& state_size, const Scalar& own, const Scalar& others,
                     const Difference& difference) {
    using std::ceil;
    using std::log;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar from = std::max<Scalar>(others, 1) / 2;
    Scalar least = others > Scalar(0) && others < Scalar(1) ? others : Scalar(1);
    least = std::max(Scalar(16 * epsilon * own), Scalar(epsilon * least));
    const Scalar count = ceil(log(from / least) / log(Scalar(8)));
    return best(state_size, own, others, from, least,
                count < Scalar(most_shifts) ? static_cast<int>(count) : most_shifts, difference);
  }

  /// A shift that was right a while ago, looked at again.
  template <class Difference>
  Scalar best_near(const Scalar& state_size, const Scalar& own, const Scalar& others, const Scalar& shift,
                   const Difference& difference) {
    const Scalar from = 512 * shift, to = shift / 512;
    const Scalar found = best(state_size, own, others, from, to, 7, difference);
    return found > from / 16 || found < to * 16 ? best_of_all(state_size, own, others, difference) : found;
  }

 private:
  /// How far two columns are from each other, the last one by this shift: the mean over the entries of the
  /// logarithm of their relative difference, which is no less than what the rounding of the gradient may make
  /// of it. One that has become 0 disagrees: it is below the resolution of the gradient. An entry counts by
  /// how much it moves its component of the gradient over `length`, at most all of it: a coupling far weaker
  /// than the forces would ask for shifts too large for these. At most 1.
  Scalar disagreement(const Vec& a, const Vec& b, const Scalar& shift, const Scalar& length) const {
    using std::abs;
    using std::cbrt;
    using std::isfinite;
    using std::log;
    // What is better than ε^{2/3} does not count: an entry that is constant would ask for shifts too large
    // for the others.
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), least = cbrt(epsilon) * cbrt(epsilon);
    Scalar sum(0), weights(0);
    for (Eigen::Index j = 0; j < a.size(); ++j) {
      const Scalar size = std::max<Scalar>(abs(a[j]), abs(b[j]));
      if (!isfinite(a[j]) || !isfinite(b[j])) return Scalar(1);
      const Scalar value = std::max<Scalar>(abs(above_.vector()[j]), abs(below_.vector()[j]));
      const Scalar moved = length * (size == Scalar(0) ? seen_[j] : size);
      if (moved == Scalar(0)) continue;
      const Scalar weight = moved / (value + moved);
      Scalar relative =
          size == Scalar(0) ? Scalar(1) : Scalar((abs(a[j] - b[j]) + epsilon * value / shift) / size);
      if (relative < least) relative = least;
      sum += weight * log(relative);
      weights += weight;
    }
    return weights > Scalar(0) ? Scalar(sum / weights) : log(least);
  }

  State above_, below_;
  Vec middle_, smaller_, seen_;
};

/// ∇²H at z, a symmetric 2d × 2d matrix: by H.hessian where there is one, else by central differences of the
/// gradient. NaN or Inf where the gradient is; what a gradient throws goes through. Memory: nine vectors of
/// length 2d.
///
/// The shift of each coordinate is found from the gradient itself: of shifts over all orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. It is kept from call to call, looked at
/// again, one coordinate every 16 calls, and found anew where z has gone far since. An entry is off by about
/// (ε max(1, |x|/l))^{2/3} of its size (1e-10 to 1e-9 in double), where l is the length along which the
/// gradient varies: an angle of 6e6 is known to 1e-9 only, and its derivatives to 1e-6. So are for some steps
/// those of a column whose entries differ by orders of magnitude, as of weakly coupled oscillators.
template <class H>
class SecondDerivatives {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Matrix = Eigen::Matrix<Scalar, twice(H::Dof), twice(H::Dof)>;

  explicit SecondDerivatives(Eigen::Index dof)
      : at_(dof), search_(dof), shift_(at_.vector()), last_(shift_), column_(shift_) {}

  /// Gradient calls that the last Hessian took: 4d, and more where shifts were looked for.
  Eigen::Index gradients() const { return calls_; }
  /// Gradient calls that a Hessian cannot exceed.
  static Eigen::Index max_gradients(Eigen::Index dof) {
    return HasHessian<H> ? 0 : 4 * dof * (2 + ShiftSearch<H>::most_shifts);
  }

  /// Without `search` the shifts of the last call are kept, wherever z is.
  SEMIEXPLICIT_NOINLINE void operator()(const H& h, const typename State::Storage& z, Matrix& hessian,
                                        bool search = true) {
    const Eigen::Index d = z.size() / 2;
    calls_ = 0;
    if constexpr (HasHessian<H>) {
      h.hessian(InColumn<H>(z.data(), d), InColumn<H>(z.data() + d, d), hessian);
    } else {
      at_.vector() = z;
      if (search) find_shifts(h, z);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        difference(h, z, i, shift_[i], column_);
        hessian.col(i) = column_;
      }
      if constexpr (lacks_work<H>) {  // the column of the time has what the gradient leaves out of its row
        const Eigen::Index time = z.size() / 2 - 1;
        hessian.row(time) = hessian.col(time).transpose();
      }
      // Symmetric to the last bit, so that the tangent map is symplectic although its entries are
      // approximate.
      for (Eigen::Index i = 0; i < z.size(); ++i)
        for (Eigen::Index j = 0; j < i; ++j)
          hessian(i, j) = hessian(j, i) = (hessian(i, j) + hessian(j, i)) / 2;
    }
  }

  /// The shifts, which go on from call to call; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(shift_);
    visit(last_);
    visit(count_);
  }

 private:
  using Vec = typename State::Storage;
  static constexpr std::int64_t look_again = 16;

  /// The column i of the Hessian by one shift.
  void difference(const H& h, const Vec& z, Eigen::Index i, const Scalar& shift, Vec& column) {
    const Eigen::Index d = z.size() / 2;
    const Scalar right = z[i] + shift, left = z[i] - shift;
    at_.vector()[i] = right;
    gradient_at(h, at_.vector().data(), search_.above().data(), d);
    at_.vector()[i] = left;
    gradient_at(h, at_.vector().data(), search_.below().data(), d);
    at_.vector()[i] = z[i];
    column = (search_.above() - search_.below()) / (right - left);
    calls_ += 2;
  }

  void find_shifts(const H& h, const Vec& z) {
    using std::abs;
    // A shift is about 1e-5 of the length along which the gradient varies.
    bool far = count_ == 0;
    for (Eigen::Index i = 0; i < z.size(); ++i) far = far || !(abs(z[i] - last_[i]) <= 65536 * shift_[i]);
    last_ = z;
    const auto find = [&](Eigen::Index i, bool anew) {
      const Eigen::Index d = z.size() / 2;
      const Scalar size = state_size(h, at_), own = abs(z[i]);
      const Scalar others = largest_absolute(z.segment(i < d ? 0 : d, d));
      const auto by = [&](const Scalar& shift, Vec& column) { difference(h, z, i, shift, column); };
      shift_[i] = anew ? search_.best_of_all(size, own, others, by)
                       : search_.best_near(size, own, others, shift_[i], by);
    };
    if (far) {
      for (Eigen::Index i = 0; i < z.size(); ++i) find(i, true);
    } else if (count_ % look_again == 0) {
      find(static_cast<Eigen::Index>(count_ / look_again % z.size()), false);
    }
    count_ = count_ % (std::int64_t{1} << 40) + 1;
  }

  State at_;
  ShiftSearch<H> search_;
  Vec shift_, last_, column_;  ///< of each coordinate, and where it was at the last call
  std::int64_t count_ = 0;     ///< of the calls
  Eigen::Index calls_ = 0;
};

}  // namespace semiexplicit::detail
