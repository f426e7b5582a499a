#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/derivatives/shift_search.hpp>

namespace semiexplicit::detail {

/// ∇²H at z, a symmetric 2d × 2d matrix: by H.hessian where there is one, else by central differences of the
/// gradient. NaN or Inf where the gradient is; what a gradient throws goes through, but for std::domain_error
/// while a shift is looked for: that shift is too large. Memory: seventeen vectors of length 2d.
///
/// The shift of each coordinate is found from the gradient itself: of shifts over all orders of magnitude,
/// the one whose difference agrees best with its two neighbours'. It is kept from call to call, looked at
/// again, one coordinate every 16 calls, and found anew where z has gone far since or its second derivative
/// is another one. An entry is off by about (ε max(1, |x|/l))^{2/3} of its size (1e-10 to 1e-9 in double),
/// where l is the length along which the gradient varies: an angle of 6e6 is known to 1e-9 only, and its
/// derivatives to 1e-6. Of entries of a column that differ by orders of magnitude, as of weakly coupled
/// oscillators, it is so of the largest in its half.
template <class H>
class SecondDerivatives {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  static constexpr int side = twice(H::Dof);
  using Matrix = Eigen::Matrix<Scalar, side, columns_in_place<Scalar>(side, side)>;

  /// `exact`: the shift of a coordinate is looked for again where its second derivative has become another
  /// one. An iteration that only converges by them does not need it.
  explicit SecondDerivatives(Eigen::Index dof, bool exact = true)
      : exact_(exact),
        at_(dof),
        search_(dof),
        shift_(at_.vector()),
        last_(shift_),
        blind_(shift_),
        diagonal_(shift_),
        column_(shift_) {}

  /// Gradient calls that the last Hessian took: 4d, and more where shifts were looked for.
  Eigen::Index gradients() const { return calls_; }
  /// Gradient calls that a Hessian cannot exceed.
  static Eigen::Index max_gradients(Eigen::Index dof) {
    return HasHessian<H> ? 0 : 4 * dof * (3 + ShiftSearch<H>::most_shifts) + Lengths<H>::most_calls;
  }

  /// Without `search` the shifts of the last call are kept, wherever z is.
  SEMIEXPLICIT_NOINLINE void operator()(const H& h, const typename State::Storage& z, Matrix& hessian,
                                        bool search = true) {
    const Eigen::Index d = z.size() / 2;
    calls_ = 0;
    if constexpr (HasHessian<H>) {
      const InColumn<H> q(z.data(), d), p(z.data() + d, d);
      hessian.setZero();  // for one that adds, or leaves out what is 0
      h.hessian(q, p, hessian);
    } else {
      at_.vector() = z;
      bool looked = search && z.size() > 0 && find_shifts(h, z);
      for (Eigen::Index i = 0; i < z.size(); ++i) {
        difference(h, z, i, shift_[i], column_);
        if (search && exact_ && is_other(column_[i], diagonal_[i])) {
          if (!looked) prepare(h, z);
          looked = true;
          look_at(h, z, i, true);
          difference(h, z, i, shift_[i], column_);
        }
        if (diagonal_[i] != diagonal_[i]) diagonal_[i] = column_[i];
        hessian.col(i) = column_;
      }
      if constexpr (InExtendedPhaseSpace<H>) {  // ∂H/∂t is rounded by more than its derivatives, or left out
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
    visit(diagonal_);
    visit(search_.largest());
    for (Scalar& length : at_zero_) visit(length);
    visit(count_);
  }

 private:
  using Vec = typename State::Storage;
  static constexpr std::int64_t look_again = 16;

  /// The column i of the Hessian by one shift.
  void difference(const H& h, const Vec& z, Eigen::Index i, const Scalar& shift, Vec& column) {
    const Eigen::Index d = z.size() / 2;
    const Scalar right = z[i] + shift, left = z[i] - (right - z[i]);  // as far, but for an exponent
    at_.vector()[i] = right;
    gradient_at(h, at_.vector().data(), search_.above().data(), d);
    at_.vector()[i] = left;
    gradient_at(h, at_.vector().data(), search_.below().data(), d);
    at_.vector()[i] = z[i];
    column = (search_.above() - search_.below()) / (right - left);
    calls_ += 2;
  }

  /// Whether a second derivative is so far from what it was where its shift was found that another one may be
  /// right, as in a narrow hill beside a smooth plain.
  static bool is_other(const Scalar& now, const Scalar& then) {
    using std::abs;
    return 4 * abs(now - then) > 3 * std::max<Scalar>(abs(now), abs(then));
  }

  /// True: some were looked for.
  bool find_shifts(const H& h, const Vec& z) {
    using std::abs;
    const Eigen::Index d = z.size() / 2;
    const auto largest = [d](const Vec& at, Eigen::Index half) {
      return largest_absolute(at.segment(half, d));
    };
    // Farther than about half the length along which the gradient varies, by its shift; momenta may have
    // begun at zero.
    const Scalar to_length = Scalar(0.4) / ShiftSearch<H>::usual_part(Scalar(1));
    bool grown = count_ == 0;
    for (const Eigen::Index half : {Eigen::Index{0}, d})
      grown = grown || largest(z, half) > 16 * largest(last_, half);
    bool far = grown;
    for (Eigen::Index i = 0; i < z.size(); ++i) far = far || !(abs(z[i] - last_[i]) <= to_length * shift_[i]);
    // Where nothing depends on a coordinate, as at the top of a drive, it is looked for again soon.
    const bool soon = (count_ & (count_ - 1)) == 0 && !blind_.isZero(0);
    const bool again = count_ % look_again == 0;
    if (grown) blind_.setOnes();  // shifts found when it was small tell nothing
    const bool looks = far || soon || again;
    if (looks) prepare(h, z);
    const auto next = static_cast<Eigen::Index>(count_ / look_again % z.size());
    for (Eigen::Index i = 0; i < z.size() && looks; ++i) {
      const bool anew = far || (soon && blind_[i] != Scalar(0));
      if (anew || (again && i == next)) look_at(h, z, i, anew);
    }
    last_ = z;
    count_ = count_ % (std::int64_t{1} << 40) + 1;  // not where the gradient has thrown
    return looks;
  }

  /// Before shifts are looked for at z.
  void prepare(const H& h, const Vec& z) {
    gradient_at(h, z.data(), search_.here().data(), z.size() / 2);
    ++calls_;
    calls_ += lengths_.take(h, z, search_.here(), at_.vector(), search_.above(), true);
    search_.count_in(lengths_, z);
    const Eigen::Index d = z.size() / 2;
    for (int half = 0; half < 2; ++half)
      if (const Eigen::Index i = half * d; lengths_.guessed(i, d) && lengths_.known(i, d))
        at_zero_[half] = std::max<Scalar>(at_zero_[half], lengths_.of(i, d));
  }

  /// Finds the shift of that coordinate anew, or looks beside the last one.
  void look_at(const H& h, const Vec& z, Eigen::Index i, bool anew) {
    using std::abs;
    const auto by = [&](const Scalar& shift, Vec& column) {
      at_.vector() = z;  // where the gradient has thrown it was moved
      difference(h, z, i, shift, column);
    };
    const Eigen::Index d = z.size() / 2;
    const bool known = lengths_.known(i, d);
    const Scalar at_zero = i % d < own_dof<H>(d) ? at_zero_[i / d] : Scalar(0);
    typename ShiftSearch<H>::Along along{
        .length = lengths_.own(i, z),
        .farthest = std::max({lengths_.of(i, d), search_.largest_of_half(i), at_zero}),
        .own = abs(z[i]),
        .unit = std::max<Scalar>(lengths_.beyond(i, d), at_zero),
        .known = known,
        .time = InExtendedPhaseSpace<H> && i == d - 1};
    // Where a half is zero the rounding of what is within the gradient hides a part of it from the shortest.
    if (z[i] == Scalar(0) && known && lengths_.guessed(i, d)) along.own = 16 * along.length;
    const Scalar found = anew ? search_.best_of_all(along, by) : search_.best_near(along, shift_[i], by);
    const bool has_before = blind_[i] == Scalar(0);
    shift_[i] = has_before ? search_.bounded(found, shift_[i], along.length) : found;
    blind_[i] = Scalar(search_.saw() ? 0 : 1);
    diagonal_[i] = std::numeric_limits<Scalar>::quiet_NaN();  // to be noted with that shift
    at_.vector() = z;
  }

  bool exact_;
  State at_;
  ShiftSearch<H> search_;
  Lengths<H> lengths_{};
  Vec shift_, last_, blind_;  ///< of each coordinate; where it was; 1 where nothing depended on it
  Vec diagonal_, column_;     ///< the second derivative where its shift was found
  Scalar at_zero_[2] = {Scalar(0), Scalar(0)};  ///< lengths of both halves, found where they were zero
  std::int64_t count_ = 0;                      ///< of the calls
  Eigen::Index calls_ = 0;
};

}  // namespace semiexplicit::detail
