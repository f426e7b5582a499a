#pragma once

#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/derivatives/dual.hpp>
#include <semiexplicit/derivatives/hessian.hpp>

namespace semiexplicit::detail {

/// The gradient takes arrays of dual numbers, as it takes packs; see HasPackGradient.
template <class H>
concept HasDualGradient = Hamiltonian<H> && std::same_as<typename H::PackGradientOf, H> &&
    requires(const H& h, const Dual<typename H::Scalar, 1>* at, Dual<typename H::Scalar, 1>* gradient) {
  h.gradient(at, at, gradient, gradient);
};

/// ∇²H(z) times columns v of 2d numbers, of length one, without the matrix: by H.hessian_times, exact to
/// rounding. Else with the matrix, where H gives it or where it is no dearer: d ≤ 4, or d columns and more.
/// Else by central differences of the gradient along v, two calls a column. Of a gradient that takes dual
/// numbers (HasDualGradient) and no hessian_times there is none: see MovingGroups.
///
/// The shift along each column is found as those of SecondDerivatives are: from the gradients themselves,
/// kept from call to call as a part of the length along the column, looked at again every 16 calls and found
/// anew where z has gone far. Each half of the product is off by about 1e-10 to 1e-9 of its size in double,
/// 1e-5 in float, for some steps by a hundred times that, and by (2e-16 x)^{2/3} where the column moves an
/// angle that has wound up to x. Such a product is not that of a symmetric matrix.
template <class H>
class HessianProduct {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Vec = typename State::Storage;
  static_assert(is_in_one_process<H>());
  static_assert(second_derivatives_can_be_called<H>());
  static constexpr bool exact = HasHessianTimes<H> || HasDualGradient<H>;

  HessianProduct(Eigen::Index dof, Eigen::Index columns)
      : dense_(!exact && (HasHessian<H> || dof <= 4 || columns >= dof)),
        second_(dense_ ? dof : few),
        differences_(exact || dense_ ? few : dof, columns) {
    if (dense_) matrix_.setZero(2 * dof, 2 * dof);
  }

  /// Before the products of a step; and before a sweep over points that the step has gone over before: with
  /// other shifts the differences' errors would be others, and an iteration would not come to rest.
  void begin() { search_ = true; }
  void keep_shifts() { search_ = false; }

  /// Before the products at a point z.
  void prepare(const H& h, const Vec& z) {
    if constexpr (!exact) {
      if (dense_)
        second_(h, z, matrix_, search_);
      else
        differences_.prepare(h, z, search_);
    }
  }

  /// product = ∇²H(z) v for the j-th column v.
  void times(const H& h, const Vec& z, const Scalar* v, Eigen::Index j, Vec& product) {
    const Eigen::Index d = z.size() / 2;
    if constexpr (HasHessianTimes<H>) {
      if constexpr (fits_on_stack(H::Dof))
        call_hessian_times(h, z.data(), v, product.data(), d);
      else
        not_inlined(h, z.data(), v, product.data(), d);
    } else if (dense_) {
      product.noalias() = matrix_ * Eigen::Map<const Vec>(v, 2 * d);
    } else {
      differences_.times(h, z, Eigen::Map<const Vec>(v, 2 * d), j, product);
    }
  }

  /// What products with columns that are equal but for rounding may differ by, relative to their size; of
  /// differences a bound.
  Scalar rounding() const {
    using std::sqrt;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    return exact || dense_ ? epsilon : sqrt(epsilon);
  }

  /// Throws std::invalid_argument where H.hessian_times or H.hessian and differences of the gradient along v
  /// have nothing in common, as where a type inherits them and has another gradient.
  void check([[maybe_unused]] const H& h, [[maybe_unused]] const Vec& z, [[maybe_unused]] const Vec& v) {
    if constexpr (HasHessianTimes<H> || (HasHessian<H> && !exact)) {
      const Eigen::Index d = z.size() / 2;
      Vec along = z, given = z;
      prepare(h, z);
      // In units that are far apart from each other the one or the other direction may be hard for
      // differences. Positions and momenta one by one: beside one half the other may be nothing.
      const Vec scaled = Differences(d, 1).in_lengths(h, z, v);
      for (const Eigen::Index half : {0, 1}) {
        const auto off_by = [&](const Vec& direction) {
          along.setZero();
          along.segment(half * d, d) = direction.segment(half * d, d);
          if (const Scalar largest = largest_absolute(along); largest > Scalar(0)) along /= largest;
          times(h, z, along.data(), 0, given);
          return Differences(d, 1).compare(h, z, along, given);
        };
        const Scalar off = off_by(scaled);
        if (off > Scalar(0) && off_by(v) > Scalar(0))
          throw std::invalid_argument(
              std::string(HasHessianTimes<H> ? "hessian_times" : "hessian") +
              " of the Hamiltonian is not the derivative of its gradient: along some direction of " +
              (half == 0 ? "q" : "p") + " it is off by " + std::to_string(static_cast<double>(off)) +
              " of its size; check both with check_gradient() and with from_energy()");
      }
    }
  }

  /// The unit of momenta in which they change as fast as positions do, sqrt(|∂²H/∂q²| / |∂²H/∂p²|) at z along
  /// v; 1 where one of these is 0. By differences of the gradient, some hundred of them.
  static Scalar unit_of_momenta(const H& h, const Vec& z, const Vec& v) {
    using std::isfinite;
    using std::sqrt;
    const Eigen::Index d = z.size() / 2;
    const auto bend = [&](Eigen::Index begin) {
      Differences differences(d, 1);
      Vec along = Vec::Zero(2 * d), product = along;
      along.segment(begin, d) = v.segment(begin, d);
      differences.prepare(h, z, true);
      differences.times(h, z, along, 0, product);
      return Scalar(norm(product.segment(begin, d)) / norm(along));
    };
    const Scalar unit = sqrt(bend(0)) / sqrt(bend(d));
    return unit > Scalar(0) && isfinite(unit) ? unit : Scalar(1);
  }

  /// What differences carry from call to call; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    if constexpr (!exact) {
      if (dense_)
        second_.visit_memory(visit);
      else
        differences_.visit_memory(visit);
    }
  }

 private:
  static constexpr Eigen::Index few = H::Dof == Eigen::Dynamic ? 1 : H::Dof;  ///< size of what is not used

  SEMIEXPLICIT_INLINE static void call_hessian_times(const H& h, const Scalar* z, const Scalar* v,
                                                     Scalar* product, Eigen::Index d) {
    const InColumn<H> q(z, d), p(z + d, d), dq(v, d), dp(v + d, d);
    OutColumn<H> hq(product, d), hp(product + d, d);
    hq.setZero(), hp.setZero();  // for one that adds, or leaves out what is 0
    h.hessian_times(q, p, dq, dp, hq, hp);
  }
  /// For large systems: g++ vectorises the loops on their own, and not within the sweep.
  SEMIEXPLICIT_NOINLINE static void not_inlined(const H& h, const Scalar* z, const Scalar* v, Scalar* product,
                                                Eigen::Index d) {
    call_hessian_times(h, z, v, product, d);
  }

  /// Differences along columns.
  class Differences {
   public:
    Differences(Eigen::Index dof, Eigen::Index columns)
        : at_(dof),
          search_(dof),
          last_(at_.vector()),
          guessed_at_(last_),
          part_(Parts::Zero(columns)),
          found_(Parts::Zero(columns)) {}

    SEMIEXPLICIT_NOINLINE void prepare(const H& h, const Vec& z, bool search) {
      search_now_ = Search::none;
      may_search_ = search;
      if (!search) return;
      const bool first = count_ == 0;
      // Of a half that tells none the lengths are worth many gradients, but once where z rests.
      if (!is_measured(z)) {
        guessed_ = false;  // a gradient may throw
        if (lengths_.guesses(z, search_.here()))
          measure(h, z), guessed_at_ = z, guessed_ = true;
        else
          lengths_.take(h, z, search_.here(), at_.vector(), search_.above());
      }
      const Scalar usual = ShiftSearch<H>::usual_part(Scalar(1));
      const bool moved = largest_absolute(z - last_) > Scalar(0);
      const bool far = first || (moved && !(lengths_.along(z - last_) * 2 * part_.minCoeff() >= usual));
      search_now_ = far ? Search::anew : count_ % look_again == 0 ? Search::near : Search::none;
      count_ = count_ % (std::int64_t{1} << 40) + 1;
      if (search_now_ == Search::none) return;
      if (far) last_ = z;
      look(h, z);
    }

    template <class Column>
    SEMIEXPLICIT_NOINLINE void times(const H& h, const Vec& z, const Column& v, Eigen::Index j,
                                     Vec& product) {
      const Scalar largest = largest_absolute(v);
      if (largest == Scalar(0)) {
        product.setZero();
        return;
      }
      const auto by = [&](const Scalar& shift, Vec& to) { difference(h, z, v, shift, to); };
      // Momenta that have begun at zero make the length along v another one.
      Scalar length = lengths_.along(v);
      const bool other = !(length * largest <= 8 * found_[j] && length * largest >= found_[j] / 8);
      const bool anew = search_now_ == Search::anew || (may_search_ && other);
      if (anew && search_now_ == Search::none) {
        look(h, z);
        length = lengths_.along(v);
      }
      // No shift is too small because some coordinate is large: it may be coupled to nothing.
      const Scalar unit = 1 / largest;
      if (anew || search_now_ == Search::near) {
        const typename ShiftSearch<H>::Along along{length, std::max(length, lengths_.farthest_along(v)),
                                                   Scalar(0), unit};
        const Scalar found =
            anew ? search_.best_of_all(along, by) : search_.best_near(along, part_[j] * length, by);
        const Scalar before = part_[j] * found_[j] / largest;
        part_[j] = (before > Scalar(0) ? search_.bounded(found, before, length) : found) / length;
        found_[j] = length * largest;
      }
      by(part_[j] * length, product);
    }

    /// The direction v where its entries count in the lengths of the coordinates, whatever their units are.
    Vec in_lengths(const H& h, const Vec& z, const Vec& v) {
      prepare(h, z, true);
      Vec along = v;
      for (Eigen::Index i = 0; i < z.size(); ++i) along[i] *= lengths_.own(i, z);
      return along / largest_absolute(along);
    }

    /// How far a half of a product that H gives is off from differences, the usual one or another, relative
    /// to it; 0 where both are near, or differences cannot tell. Entries count in the lengths of coordinates.
    Scalar compare(const H& h, const Vec& z, const Vec& v, const Vec& given) {
      using std::abs;
      const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
      const Eigen::Index d = z.size() / 2;
      Vec found = z, other = z, weights = z;
      prepare(h, z, true);
      times(h, z, v, 0, found);
      for (Eigen::Index i = 0; i < z.size(); ++i) weights[i] = lengths_.own(i, z);
      const auto size = [&](Eigen::Index half, const Vec& of) {
        return Scalar(of.segment(half * d, d).cwiseProduct(weights.segment(half * d, d)).norm());
      };
      const Scalar usual = part_[0] * lengths_.along(v);
      Scalar off[2];
      bool near[2];
      // What rounding may make of a difference by that shift.
      const auto rounding = [&](Eigen::Index half, const Scalar& shift) {
        return epsilon * std::max(size(half, search_.above()), size(half, search_.below())) / shift;
      };
      // A difference that rounding swallows proves nothing. A product that is zero is near to one that is
      // nothing beside the usual one.
      const Scalar length = lengths_.along(v);
      const auto look_by = [&](const Scalar& shift) {
        difference(h, z, v, shift, other);
        for (const Eigen::Index half : {0, 1}) {
          const Scalar apart = size(half, other - given);
          near[half] =
              near[half] ||
              (apart <= size(half, other) / 100 && size(half, other) > 100 * rounding(half, shift)) ||
              (apart <= size(half, found) / 100 && shift > 200 * epsilon * length);
        }
        return near[0] && near[1];
      };
      for (const Eigen::Index half : {0, 1}) {
        off[half] = size(half, given - found) / size(half, found);
        near[half] = size(half, given - found) <= size(half, found) / 100 ||
                     !(100 * rounding(half, usual) < size(half, found));
      }
      if ((near[0] && near[1]) || look_by(usual / 2)) return Scalar(0);
      for (const Eigen::Index half : {0, 1})
        if (!(size(half, found - other) <= size(half, found) / 1000)) near[half] = true;
      // Where one half of z is far smaller than what it is on its way to, the shift may be one that the other
      // does not feel; where units differ, one that steps over what bends a coordinate.
      const Scalar smallest = Scalar(1e-14);
      const Scalar farther = ShiftSearch<H>::usual_part(lengths_.farthest_along(v));
      if (farther > Scalar(0) && look_by(farther)) return Scalar(0);
      Scalar least(0);  // below that rounding hides what some coordinate does
      for (Eigen::Index i = 0; i < z.size(); ++i)
        if (v[i] != Scalar(0)) least = std::max<Scalar>(least, 200 * epsilon * abs(z[i] / v[i]));
      for (Scalar shift = usual / 4; shift > least && shift > usual * smallest; shift /= 4)
        if (look_by(shift)) return Scalar(0);
      return std::max(near[0] ? Scalar(0) : off[0], near[1] ? Scalar(0) : off[1]);
    }

    template <class Visitor>
    void visit_memory(Visitor&& visit) {
      visit(part_);
      visit(found_);
      visit(last_);
      visit(search_.here());
      visit(search_.largest());
      visit(count_);
    }

   private:
    using Parts = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
    enum class Search { none, near, anew };
    static constexpr std::int64_t look_again = 16;

    /// Whether the last point was z, and is one of those; what a search needs is known then.
    bool is_measured(const Vec& z) const { return guessed_ && z == guessed_at_; }
    void measure(const H& h, const Vec& z) {
      gradient_at(h, z.data(), search_.here().data(), z.size() / 2);
      lengths_.take(h, z, search_.here(), at_.vector(), search_.above(), true);
    }
    /// Before a search.
    void look(const H& h, const Vec& z) {
      if (!is_measured(z)) measure(h, z);
      search_.count_in(lengths_, z);
    }

    template <class Column>
    void difference(const H& h, const Vec& z, const Column& v, const Scalar& shift, Vec& to) {
      const Eigen::Index d = z.size() / 2;
      at_.vector() = z + shift * v;
      gradient_at(h, at_.vector().data(), search_.above().data(), d);
      at_.vector() = z - shift * v;
      gradient_at(h, at_.vector().data(), search_.below().data(), d);
      to = (search_.above() - search_.below()) / (2 * shift);
    }

    State at_;
    ShiftSearch<H> search_;
    Lengths<H> lengths_{};
    Vec last_;        ///< where the shifts were found
    Vec guessed_at_;  ///< where lengths that nothing tells were looked for
    Parts part_;      ///< of the length along each column: its shift
    Parts found_;     ///< the largest entry of each column times that length, when it was found
    bool may_search_ = false, guessed_ = false;
    Search search_now_ = Search::none;
    std::int64_t count_ = 0;  ///< of the points
  };

  bool dense_, search_ = true;
  SecondDerivatives<H> second_;
  typename SecondDerivatives<H>::Matrix matrix_;
  Differences differences_;
};

}  // namespace semiexplicit::detail
