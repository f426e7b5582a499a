#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>

namespace semiexplicit::detail {

/// How far each coordinate may go before a gradient changes much, as far as the state and its velocity tell:
/// as far as the coordinates are from the origin, or the momenta; the time, as long as that takes. Whatever
/// the units are, these lengths are in them. 1 where nothing is known.
template <class H>
class Lengths {
 public:
  using Scalar = typename H::Scalar;
  using Vec = typename PhasePoint<Scalar, H::Dof>::Storage;

  void take(const Vec& z, const Vec& gradient) {
    const Eigen::Index d = z.size() / 2, n = d - (InExtendedPhaseSpace<H> ? 1 : 0);
    q_ = largest_absolute(z.head(n)), p_ = largest_absolute(z.segment(d, n));
    if constexpr (InExtendedPhaseSpace<H>) {
      using std::abs;
      const Scalar dq = largest_absolute(gradient.segment(d, n)), dp = largest_absolute(gradient.head(n));
      time_ = abs(gradient[2 * d - 1]) * smaller(dq > Scalar(0) ? Scalar(q_ / dq) : Scalar(0),
                                                 dp > Scalar(0) ? Scalar(p_ / dp) : Scalar(0));
      energy_ = std::max<Scalar>(p_ * dq, q_ * dp);
    }
  }

  /// That of one coordinate of 2d.
  Scalar of(Eigen::Index i, Eigen::Index d) const {
    Scalar length = i < d ? q_ : p_;
    if constexpr (InExtendedPhaseSpace<H>)
      if (i % d == d - 1) length = i < d ? time_ : energy_;
    return length > Scalar(0) ? length : Scalar(1);
  }

  /// What v is to be multiplied by so that no coordinate goes farther.
  template <class Column>
  Scalar along(const Column& v) const {
    const Eigen::Index d = v.size() / 2, n = d - (InExtendedPhaseSpace<H> ? 1 : 0);
    const auto part = [](const Scalar& length, const Scalar& moved) {
      return moved > Scalar(0) ? Scalar(length / moved) : Scalar(0);
    };
    Scalar length =
        smaller(part(q_, largest_absolute(v.head(n))), part(p_, largest_absolute(v.segment(d, n))));
    if constexpr (InExtendedPhaseSpace<H>) {
      using std::abs;
      length = smaller(length, smaller(part(time_, abs(v[d - 1])), part(energy_, abs(v[2 * d - 1]))));
    }
    if (length > Scalar(0)) return length;
    const Scalar largest = largest_absolute(v);
    return largest > Scalar(0) ? Scalar(1 / largest) : Scalar(1);
  }

 private:
  /// Of two, where 0 says nothing.
  static Scalar smaller(const Scalar& a, const Scalar& b) {
    return a > Scalar(0) && (a < b || !(b > Scalar(0))) ? a : b;
  }

  Scalar q_ = Scalar(0), p_ = Scalar(0), time_ = Scalar(0), energy_ = Scalar(0);
};

/// Looks for the shift of a central difference of the gradient: of shifts over several orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. Memory: six vectors of length 2d.
template <class H>
class ShiftSearch {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  static constexpr int most_shifts = 48;

  explicit ShiftSearch(Eigen::Index dof) : above_(dof), below_(dof) {
    for (Vec* one : {&here_, &middle_, &smaller_, &seen_}) *one = above_.vector();
  }

  /// What a difference writes its two gradients to.
  Vec& above() { return above_.vector(); }
  Vec& below() { return below_.vector(); }
  /// The gradient where the differences are taken: to be written before a search.
  Vec& here() { return here_; }

  /// Of `count` shifts in geometric order from the larger one to the smaller one, that whose differences
  /// agree best with those of its two neighbours; of those that agree nearly as well, as where the gradient
  /// is linear or even, that nearest to the usual part of `length`. difference(shift, column) writes above(),
  /// below() and their difference by the shift.
  template <class Difference>
  Scalar best(const Scalar& length, const Scalar& from, const Scalar& to, int count,
              const Difference& difference) {
    using std::abs;
    using std::cbrt;
    using std::log;
    using std::pow;
    const Scalar ratio = pow(to / from, Scalar(1) / Scalar(std::max(count - 1, 1)));
    Scalar apart[most_shifts], least(1);
    seen_.setZero();
    saw_ = false;
    Scalar shift = from;
    for (int k = 0; k < count; ++k, shift *= ratio) {
      difference(shift, smaller_);
      apart[k] = k > 0 ? disagreement(middle_, smaller_, shift, length) : Scalar(1);
      if (k > 1) {
        apart[k - 1] = std::max(apart[k - 1], apart[k]);  // with both neighbours
        least = std::min(least, apart[k - 1]);
      }
      for (Eigen::Index j = 0; j < seen_.size(); ++j)
        if (smaller_[j] != Scalar(0)) seen_[j] = abs(smaller_[j]);
      middle_ = smaller_;
    }
    const Scalar usual = length * cbrt(Eigen::NumTraits<Scalar>::epsilon());
    Scalar best = from * pow(ratio, Scalar(count / 2)), nearest(-1);
    shift = from;
    for (int k = 0; k < count - 1; ++k, shift *= ratio) {
      const Scalar distance = abs(log(shift / usual));
      if (k == 0 || !(apart[k] < Scalar(1)) || apart[k] > least + log(Scalar(4))) continue;
      if (nearest < Scalar(0) || distance < nearest) nearest = distance, best = shift;
    }
    return best;
  }

  /// The same over all shifts that may be right: from the length, or 1, to the rounding of what is moved,
  /// `own`, or nothing.
  template <class Difference>
  Scalar best_of_all(const Scalar& length, const Scalar& own, const Scalar& unit,
                     const Difference& difference) {
    using std::ceil;
    using std::log;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const Scalar from = std::max<Scalar>(length, unit) / 2;
    const Scalar least =
        std::max(Scalar(16 * epsilon * own), Scalar(epsilon * std::min<Scalar>(length, unit)));
    const Scalar count = ceil(log(from / least) / log(Scalar(8)));
    return best(length, from, least, count < Scalar(most_shifts) ? static_cast<int>(count) : most_shifts,
                difference);
  }

  /// A shift that was right a while ago, looked at again.
  template <class Difference>
  Scalar best_near(const Scalar& length, const Scalar& own, const Scalar& unit, const Scalar& shift,
                   const Difference& difference) {
    const Scalar from = 512 * shift, to = shift / 512;
    const Scalar found = best(length, from, to, 7, difference);
    return found > from / 16 || found < to * 16 ? best_of_all(length, own, unit, difference) : found;
  }

  /// Whether any difference of the last search was not zero.
  bool saw() const { return saw_; }

 private:
  /// How far two columns are from each other, the last one by this shift: the mean over both halves of the
  /// logarithm of their relative difference, which is no less than what the rounding of the gradient may make
  /// of it. One that has become 0 disagrees: it is below the resolution of the gradient. A half counts by how
  /// much it moves its half of the gradient over `length`, at most all of it. In sums of entries, as a
  /// coupling far weaker than the forces would ask for shifts that are too large for these. At most 1.
  Scalar disagreement(const Vec& a, const Vec& b, const Scalar& shift, const Scalar& length) {
    using std::abs;
    using std::cbrt;
    using std::isfinite;
    using std::log;
    // What is better than ε^{2/3} does not count: a half that is constant would ask for shifts too large for
    // the other.
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), least = cbrt(epsilon) * cbrt(epsilon);
    const Eigen::Index d = a.size() / 2;
    Scalar sum(0), weights(0);
    for (const Eigen::Index half : {Eigen::Index{0}, d}) {
      Scalar apart(0), size(0), seen(0), force(0);
      for (Eigen::Index j = half; j < half + d; ++j) {
        if (!isfinite(a[j]) || !isfinite(b[j])) return Scalar(1);
        const Scalar value = std::max<Scalar>(abs(above_.vector()[j]), abs(below_.vector()[j]));
        const Scalar larger = std::max<Scalar>(abs(a[j]), abs(b[j]));
        apart += abs(a[j] - b[j]) + epsilon * value / shift;
        size += larger;
        seen += larger > Scalar(0) ? larger : seen_[j];
        force += abs(here_[j]);
      }
      if (seen == Scalar(0)) continue;
      saw_ = true;
      const Scalar relative = size == Scalar(0) ? Scalar(1) : std::max<Scalar>(apart / size, least);
      const Scalar weight = length * seen / (force + length * seen);
      sum += weight * log(relative);
      weights += weight;
    }
    return weights > Scalar(0) ? Scalar(sum / weights) : log(least);
  }

  State above_, below_;
  Vec here_, middle_, smaller_, seen_;
  bool saw_ = false;
};

/// ∇²H at z, a symmetric 2d × 2d matrix: by H.hessian where there is one, else by central differences of the
/// gradient. NaN or Inf where the gradient is; what a gradient throws goes through. Memory: eleven vectors of
/// length 2d.
///
/// The shift of each coordinate is found from the gradient itself: of shifts over all orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. It is kept from call to call, looked at
/// again, one coordinate every 16 calls, and found anew where z has gone far since. An entry is off by about
/// (ε max(1, |x|/l))^{2/3} of its size (1e-10 to 1e-9 in double), where l is the length along which the
/// gradient varies: an angle of 6e6 is known to 1e-9 only, and its derivatives to 1e-6. Of entries of a
/// column that differ by orders of magnitude, as of weakly coupled oscillators, it is so of the largest in
/// its half.
template <class H>
class SecondDerivatives {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Matrix = Eigen::Matrix<Scalar, twice(H::Dof), twice(H::Dof)>;

  explicit SecondDerivatives(Eigen::Index dof)
      : at_(dof), search_(dof), shift_(at_.vector()), last_(shift_), blind_(shift_), column_(shift_) {}

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
    visit(blind_);
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
    const Eigen::Index d = z.size() / 2;
    const auto largest = [d](const Vec& at, Eigen::Index half) {
      return largest_absolute(at.segment(half, d));
    };
    // A shift is about 1e-5 of the length along which the gradient varies; momenta may have begun at zero.
    bool far = count_ == 0;
    for (const Eigen::Index half : {Eigen::Index{0}, d})
      far = far || largest(z, half) > 16 * largest(last_, half);
    for (Eigen::Index i = 0; i < z.size(); ++i) far = far || !(abs(z[i] - last_[i]) <= 65536 * shift_[i]);
    // Where nothing depends on a coordinate, as at the top of a drive, it is looked for again soon.
    const bool soon = (count_ & (count_ - 1)) == 0;
    const bool again = count_ % look_again == 0;
    const Eigen::Index next = static_cast<Eigen::Index>(count_ / look_again % z.size());
    count_ = count_ % (std::int64_t{1} << 40) + 1;
    last_ = z;
    if (!far && !again && !(soon && !blind_.isZero(0))) return;
    gradient_at(h, z.data(), search_.here().data(), d);
    ++calls_;
    lengths_.take(z, search_.here());
    for (Eigen::Index i = 0; i < z.size(); ++i) {
      const bool anew = far || (soon && blind_[i] != Scalar(0));
      if (!anew && !(again && i == next)) continue;
      const auto by = [&](const Scalar& shift, Vec& column) { difference(h, z, i, shift, column); };
      const Scalar length = lengths_.of(i, d), own = abs(z[i]);
      shift_[i] = anew ? search_.best_of_all(length, own, Scalar(1), by)
                       : search_.best_near(length, own, Scalar(1), shift_[i], by);
      blind_[i] = Scalar(search_.saw() ? 0 : 1);
    }
  }

  State at_;
  ShiftSearch<H> search_;
  Lengths<H> lengths_{};
  Vec shift_, last_, blind_, column_;  ///< of each coordinate; where it was; 1 where nothing depended on it
  std::int64_t count_ = 0;             ///< of the calls
  Eigen::Index calls_ = 0;
};

}  // namespace semiexplicit::detail
