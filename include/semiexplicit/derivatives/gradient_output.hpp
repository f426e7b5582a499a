#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/lanes.hpp>
#include <semiexplicit/core/median.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/reference_size.hpp>
#include <semiexplicit/core/simd.hpp>
#include <semiexplicit/core/split_hamiltonian.hpp>
#include <semiexplicit/derivatives/slope.hpp>

// What a gradient does with its outputs, and whether the other members that a Hamiltonian may have agree with
// it.

namespace semiexplicit {

/// What a gradient does with an entry of its output, which holds anything when it is called.
enum class GradientOutput {
  written,        ///< overwrites it
  not_written,    ///< leaves it as it is
  added_to,       ///< adds to it
  other_packs,    ///< overwrites it, and with another number where it is called with packs (HasPackGradient)
  other_lanes,    ///< and lane_gradient with another one (HasLaneGradient)
  other_halves,   ///< and position_gradient or momentum_gradient with another one (SeparableHamiltonian)
  other_range,    ///< and gradient_range with another one (HasRangeGradient)
  other_parts,    ///< and the exact flow and the rest add up to another one (SplitHamiltonian)
  other_hessian,  ///< and hessian or hessian_times is not its derivative (HasHessian, HasHessianTimes)
  unclear         ///< neither: it depends on what was there in another way, or changes from call to call
};

namespace detail {

SEMIEXPLICIT_COLD inline std::string describe(GradientOutput output) {
  switch (output) {
    case GradientOutput::written:
      return "is written";
    case GradientOutput::not_written:
      return "is not written: what was in the output stays there";
    case GradientOutput::added_to:
      return "is added to what was in the output: write it with =, or set the output to zero first";
    case GradientOutput::other_packs:
      return "is another number where the gradient is called with packs, as by Ensemble and "
             "GaussLegendreLanes: let both do the same, or leave PackGradientOf out";
    case GradientOutput::other_lanes:
      return "is another number by lane_gradient, which steps on registers call: let both do the same, or "
             "leave "
             "LaneGradientOf out";
    case GradientOutput::other_halves:
      return "is another number by position_gradient or momentum_gradient, which ExplicitSplitting calls: "
             "let both do the same, the slopes of the energy and not the forces, or leave "
             "SeparableGradientOf out";
    case GradientOutput::other_range:
      return "is another number by gradient_range, which the steps of large systems call: let both do the "
             "same for every range, from what reach() says alone, or leave RangeGradientOf out";
    case GradientOutput::other_parts:
      return "is another number by flow() and the gradients of the rest, which FlowSplitting calls: together "
             "they have to be the gradient, and a flow of the time 2t is that of t, twice";
    case GradientOutput::other_hessian:
      return "has another derivative than hessian or hessian_times says: let them be that of the gradient, "
             "or "
             "leave them out";
    case GradientOutput::unclear:
      return "depends on what was in the output, or changes from call to call";
  }
  return "";
}

/// The gradient of H at z, and what it does with its outputs, from calls that find different numbers in them.
template <Hamiltonian H>
SEMIEXPLICIT_COLD std::vector<GradientOutput> written_gradient(
    const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
    PhasePoint<typename H::Scalar, H::Dof>& given) {
  using Scalar = typename H::Scalar;
  using Limits = std::numeric_limits<Scalar>;
  using std::abs;
  using std::isfinite;
  using std::sqrt;
  const auto into = [&](const Scalar& filling) {
    auto out = z;
    out.vector().setConstant(filling);
    gradient_at(hamiltonian, z.vector().data(), out.vector().data(), z.dof());
    return out;
  };
  given = into(Scalar(0));
  Scalar filling(1);
  for (const Scalar& x : given.vector())
    if (isfinite(x)) filling = std::max(filling, abs(x));
  const auto second = into(filling), third = Limits::has_quiet_NaN ? into(Limits::quiet_NaN()) : second;
  // Of sums in another order, in the units of a half.
  const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(),
               largest[2] = {largest_absolute(given.q()), largest_absolute(given.p())};
  const auto same = [&](Eigen::Index i, const Scalar& x, const Scalar& y) {
    return x == y || (x != x && y != y) ||
           abs(x - y) <= sqrt(epsilon) * std::min<Scalar>(abs(x), abs(y)) +
                             256 * epsilon * largest[i < z.dof() ? 0 : 1];
  };
  std::vector<GradientOutput> outputs;
  for (Eigen::Index i = 0; i < given.vector().size(); ++i) {
    const Scalar a = given.vector()[i], b = second.vector()[i], c = third.vector()[i];
    outputs.push_back(same(i, a, b) && same(i, a, c)   ? GradientOutput::written
                      : a == Scalar(0) && b == filling ? GradientOutput::not_written
                      : isfinite(a) && abs(b - a - filling) <= sqrt(epsilon) * filling
                          ? GradientOutput::added_to
                          : GradientOutput::unclear);
  }
  return outputs;
}

/// Sizes of the entries of q, or of p.
template <class Scalar>
struct EntrySizes {
  Scalar largest;
  /// For entries that are zero, which say nothing about it: the middle one of the others' sizes, so that a
  /// late time or another large entry does not count.
  Scalar typical;
};

/// Of entries that are not all zero, or of none.
template <class Scalar>
SEMIEXPLICIT_COLD std::optional<EntrySizes<Scalar>> entry_sizes(const auto& entries) {
  using std::abs;
  std::vector<Scalar> sizes;
  for (const Scalar& x : entries)
    if (x != Scalar(0)) sizes.push_back(abs(x));
  if (sizes.empty()) return std::nullopt;
  return EntrySizes<Scalar>{largest_absolute(entries), median(std::move(sizes))};
}

/// Those of q and of p, whose units may be any; of a half that is zero those of the other one, or 1.
template <class Scalar, int Dof>
SEMIEXPLICIT_COLD std::array<EntrySizes<Scalar>, 2> sizes_of_halves(const PhasePoint<Scalar, Dof>& z) {
  const auto q = entry_sizes<Scalar>(z.q()), p = entry_sizes<Scalar>(z.p());
  const EntrySizes<Scalar> one{Scalar(1), Scalar(1)};
  return {q.value_or(p.value_or(one)), p.value_or(q.value_or(one))};
}

/// By how much each entry of a gradient, or of its derivative, is off by another member of H.
///
/// An entry is judged by its terms, which may cancel at one point but not at those around it, and by them
/// alone, since others may be in other units.
template <class State>
class Disagreement {
 public:
  using Scalar = typename State::Scalar;

  explicit Disagreement(Eigen::Index dof) : off_(dof), terms_(dof) {}

  /// Another member says x.
  void note(Eigen::Index i, const Scalar& x, const Scalar& expected) {
    using std::abs;
    const Scalar found = abs(x - expected);
    auto& off = off_.vector()[i];
    if (!(found <= off)) off = found == found ? found : std::numeric_limits<Scalar>::infinity();
  }
  void count(Eigen::Index i, const Scalar& expected) {
    using std::abs;
    for (Scalar* size : {&terms_.vector()[i], &largest_[half(i)]})
      *size = std::max<Scalar>(*size, abs(expected));
  }
  /// Marks what is written and off by more than `part` of its terms, and than rounding.
  void mark(std::vector<GradientOutput>& outputs, GradientOutput as, const Scalar& part) const {
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    for (Eigen::Index i = 0; i < off_.vector().size(); ++i)
      if (auto& output = outputs[static_cast<std::size_t>(i)];
          output == GradientOutput::written && off_.vector()[i] > part * terms_.vector()[i] +
                                                                      64 * epsilon * largest_[half(i)] +
                                                                      (std::numeric_limits<Scalar>::min)())
        output = as;
  }

 private:
  std::size_t half(Eigen::Index i) const { return i < off_.dof() ? 0 : 1; }

  State off_, terms_;
  Scalar largest_[2] = {Scalar(0), Scalar(0)};
};

/// The gradient of H at and around z beside what other members of H make of it.
template <Hamiltonian H>
class OtherGradients {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;

  OtherGradients(const H& hamiltonian, const State& z, std::vector<GradientOutput>& outputs)
      : hamiltonian_(hamiltonian), z_(z), sizes_(sizes_of_halves(z)), outputs_(outputs) {}

  /// Of the entries that are written, those that differ are marked as `mark`. `call(point, differs)` says
  /// differs(i, x) of entry i, or differs(i, x, gradient) of another point; where it throws std::logic_error
  /// the point is out of the domain.
  template <class Call>
  void compare(GradientOutput mark, const Call& call) {
    using std::sqrt;
    constexpr int points = 4;
    Disagreement<State> disagreement(z_.dof());
    State point = z_, given = z_;
    std::uint64_t random = 1;
    for (int k = 0; k < points; ++k) {
      if (k > 0) point.vector() += in_its_sizes(point, random).vector() / 4;
      try {
        gradient_at(hamiltonian_, point.vector().data(), given.vector().data(), z_.dof());
        if (!all_finite(given.vector())) continue;
        call(point, [&](Eigen::Index i, const Scalar& x, const std::optional<Scalar>& elsewhere = {}) {
          disagreement.note(i, x, elsewhere.value_or(given.vector()[i]));
          if (elsewhere) disagreement.count(i, *elsewhere);
        });
      } catch (const std::logic_error&) {
        continue;
      }
      for (Eigen::Index i = 0; i < given.vector().size(); ++i) disagreement.count(i, given.vector()[i]);
    }
    disagreement.mark(outputs_, mark, sqrt(Eigen::NumTraits<Scalar>::epsilon()));
  }

  /// The same of the derivative of the gradient along directions, which `product(direction, result)` writes:
  /// one changes every entry that is not zero, one those of q that are, one those of p.
  template <class Product>
  void compare_derivative(const Product& product) {
    std::uint64_t random = 1;
    const State sized = in_its_sizes(z_, random);
    for (const int part : {0, 1, 2}) {
      State direction = sized, at = z_, found(z_.dof());
      for (Eigen::Index i = 0; i < z_.vector().size(); ++i)
        if (part != (z_.vector()[i] != Scalar(0) ? 0 : i < z_.dof() ? 1 : 2)) direction.vector()[i] = 0;
      if (direction.vector().isZero(0)) continue;
      try {
        product(direction, found);
      } catch (const std::logic_error&) {
        return;
      }
      const auto along = [&](const Scalar& s, auto& column) {
        at.vector() = z_.vector() + s * direction.vector();
        gradient_at(hamiltonian_, at.vector().data(), column.data(), z_.dof());
      };
      const auto said = judge_slopes(found.vector(), State(z_.dof()).vector(), coarse(), along, Scalar(1) / 9,
                                     part == 0 ? Steps::one : Steps::all);
      for (std::size_t i = 0; i < outputs_.size(); ++i)
        if (said.wrong[i] && outputs_[i] == GradientOutput::written)
          outputs_[i] = GradientOutput::other_hessian;
    }
  }

  /// A point where all entries have the other sign and other sizes, or else one near z, whichever is first in
  /// the domain; and the gradient there.
  std::optional<std::pair<State, State>> elsewhere(const State& z) const {
    std::uint64_t random = 2;
    const State aside = in_its_sizes(z, random);
    std::pair<State, State> found(z, z);
    auto& [point, gradient] = found;
    for (const bool far : {true, false}) {
      for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
        using std::copysign;
        const Scalar x = z.vector()[i], by = aside.vector()[i];
        point.vector()[i] = far ? copysign(by, -x) : Scalar(x - by / 4);
      }
      try {
        gradient_at(hamiltonian_, point.vector().data(), gradient.vector().data(), z.dof());
        if (all_finite(gradient.vector())) return found;
      } catch (...) {  // where the motion need not come to
        continue;
      }
    }
    return std::nullopt;
  }

  /// What the derivatives of functions of one number at 0 say of given numbers.
  struct Said {
    std::vector<bool> wrong;
    std::optional<Scalar> step;  ///< the first at which all agree
  };
  /// How many steps they are taken with.
  enum class Steps {
    one,        ///< the given one, and others only where a number is none of the derivatives by that
    agreement,  ///< as many as it takes until all agree
    all         ///< that one and smaller ones
  };
  /// Says which of `given` are not the derivatives at 0 of the functions that f(s, column) writes, by more
  /// than `part` of them and `slack`. Where a coordinate is zero nothing tells how far to go: `step` may be
  /// too far by any factor, where slopes are noise, or too near, where nothing moves. So a number that is not
  /// zero is right where any step shows it, and one that is zero is wrong where any shows another.
  template <class F>
  static Said judge_slopes(const auto& given, const auto& slack, const Scalar& part, const F& f,
                           const Scalar& step, Steps steps) {
    using std::abs;
    const Eigen::Index size = given.size();
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon();
    const auto half = [&](Eigen::Index i) { return i < size / 2 ? 0 : 1; };
    std::vector<bool> contradicted(static_cast<std::size_t>(size)), shown = contradicted;
    Said result{contradicted, std::nullopt};
    Scalar scaled = step;
    constexpr int most = 25;  // some 1e30
    for (int k = 0; k <= 2 * most; ++k, scaled = k <= most ? scaled / 16 : scaled * 16) {
      if (k == most + 1) scaled = 16 * step;
      const auto slopes = agreed_slopes(size, f, scaled);
      Scalar largest[2] = {Scalar(0), Scalar(0)};
      for (Eigen::Index i = 0; i < size; ++i)
        if (const auto& slope = slopes[static_cast<std::size_t>(i)];
            slope.judges && slope.uncertainty <= abs(slope.value))  // else it is noise
          largest[half(i)] = std::max<Scalar>(largest[half(i)], abs(slope.value));
      bool agree = true, clear = true;
      for (Eigen::Index i = 0; i < size; ++i) {
        const auto at = static_cast<std::size_t>(i);
        const auto& slope = slopes[at];
        const Scalar x = given[i], own = std::max<Scalar>(abs(x), abs(slope.value)),
                     noise =
                         64 * epsilon * largest[half(i)] + slack[i] + (std::numeric_limits<Scalar>::min)();
        const bool is_zero = abs(x) <= noise, sharp = slope.uncertainty <= coarse() * own + noise;
        const bool admits = slope.judges && slope.admits(x, part * own + noise);
        agree = agree && admits && (is_zero || sharp);
        if (slope.judges && !admits) {
          contradicted[at] = contradicted[at] || !is_zero || slope.uncertainty <= own / 4;
          clear = clear && contradicted[at];
        }
        shown[at] = shown[at] || (admits && sharp && !is_zero);
        result.wrong[at] = contradicted[at] && !shown[at];
        clear = clear && !result.wrong[at];
      }
      if (agree && !result.step) result.step = scaled;
      if (steps == Steps::agreement ? agree : clear && (steps == Steps::one || k >= most)) break;
    }
    return result;
  }

 private:
  /// The derivative at 0 of each of `size` functions of one number, which f(s, column) writes; where steps of
  /// different sizes do not agree on it nothing is known. Where f throws std::logic_error it is NaN.
  template <class F>
  static std::vector<Slope<Scalar>> agreed_slopes(Eigen::Index size, const F& f, const Scalar& step) {
    using std::isfinite;
    using Column = Vector<Scalar, Eigen::Dynamic>;
    std::map<Scalar, Column> columns;  // the functions are asked at the same numbers
    const auto column_at = [&](const Scalar& s) -> const Column& {
      const auto [found, is_new] = columns.try_emplace(s, Column::Zero(size));
      if (!is_new) return found->second;
      try {
        f(s, found->second);
      } catch (const std::logic_error&) {
        found->second.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
      }
      return found->second;
    };
    std::vector<Slope<Scalar>> slopes;
    for (Eigen::Index i = 0; i < size; ++i) {
      const auto entry = [&](const Scalar& s) -> Scalar { return column_at(s)[i]; };
      auto slope = extrapolated_slope<Scalar>(entry, Scalar(0), step, Scalar(0));
      slope.judges = isfinite(slope.uncertainty);
      for (const double part : {0.71, 0.03}) {
        const auto other = extrapolated_slope<Scalar>(entry, Scalar(0), Scalar(part) * step, Scalar(0));
        slope.judges = slope.judges && isfinite(other.uncertainty) && compatible(slope, other);
        slope.uncertainty += other.uncertainty;
      }
      if (!slope.judges) slope.uncertainty = std::numeric_limits<Scalar>::infinity();
      slopes.push_back(slope);
    }
    return slopes;
  }

  /// What a slope has to be known to.
  static Scalar coarse() {
    using std::sqrt;
    return sqrt(sqrt(Eigen::NumTraits<Scalar>::epsilon()));
  }

  /// A direction that changes each entry by up to its own size.
  State in_its_sizes(const State& z, std::uint64_t& random) const {
    State direction = z;
    for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
      const Scalar x = z.vector()[i];
      direction.vector()[i] =
          Scalar(scattered(random)) * (x == Scalar(0) ? sizes_[i < z.dof() ? 0 : 1].typical : x);
    }
    return direction;
  }

  const H& hamiltonian_;
  const State& z_;
  std::array<EntrySizes<Scalar>, 2> sizes_;
  std::vector<GradientOutput>& outputs_;
};

/// The gradient for packs: what each lane says, with z in all of them, and with another point in half of
/// them.
template <HasPackGradient H>
SEMIEXPLICIT_COLD void compare_packs(const H& hamiltonian, OtherGradients<H>& others) {
  using P = Pack<typename H::Scalar>;
  int seen = 0;
  others.compare(GradientOutput::other_packs, [&](const auto& z, const auto& differs) {
    if (++seen > 2) return;
    const auto other = seen == 2 ? others.elsewhere(z) : std::nullopt;
    const auto is_other = [&](std::size_t lane) { return other && lane >= P::size() / 2; };
    const auto d = static_cast<std::size_t>(z.dof());
    std::vector<P> at(2 * d), packs(2 * d);
    for (std::size_t i = 0; i < 2 * d; ++i)
      for (std::size_t lane = 0; lane < P::size(); ++lane) {
        at[i][lane] = (is_other(lane) ? other->first : z).vector()[static_cast<Eigen::Index>(i)];
        packs[i][lane] = 1;
      }
    const P *q = at.data(), *p = q + d;
    P *dHdq = packs.data(), *dHdp = dHdq + d;
    hamiltonian.gradient(q, p, dHdq, dHdp);
    for (std::size_t k = 0; k < 2 * d; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      for (std::size_t lane = 0; lane < P::size(); ++lane)
        differs(i, packs[k][lane],
                is_other(lane) ? std::optional<typename H::Scalar>(other->second.vector()[i]) : std::nullopt);
    }
  });
}

#ifdef SEMIEXPLICIT_HAS_LANES
/// The gradient on registers.
template <HasLaneGradient H>
SEMIEXPLICIT_COLD void compare_lanes(const H& hamiltonian, OtherGradients<H>& others) {
  others.compare(GradientOutput::other_lanes, [&](const auto& z, const auto& differs) {
    LanePoint<H::Dof> at, gradient;
    at.load(z.vector().data());
    hamiltonian.lane_gradient(at.data, at.data + at.d, gradient.data, gradient.data + at.d);
    std::decay_t<decltype(z)> found = z;
    gradient.store(found.vector().data());
    for (Eigen::Index i = 0; i < 2 * z.dof(); ++i) differs(i, found.vector()[i]);
  });
}
#endif

/// The halves of a separable one, alone, into zeros as ExplicitSplitting calls them.
template <SeparableHamiltonian H>
SEMIEXPLICIT_COLD void compare_halves(const H& hamiltonian, OtherGradients<H>& others) {
  others.compare(GradientOutput::other_halves, [&](const auto& z, const auto& differs) {
    const Eigen::Index d = z.dof();
    std::decay_t<decltype(z)> found(d);
    OutColumn<H> by_q(found.vector().data(), d), by_p(found.vector().data() + d, d);
    hamiltonian.position_gradient(InColumn<H>(z.vector().data(), d), by_q);
    hamiltonian.momentum_gradient(InColumn<H>(z.vector().data() + d, d), by_p);
    for (Eigen::Index i = 0; i < 2 * d; ++i) differs(i, found.vector()[i]);
  });
}

/// Ranges, which see no more than reach() tells where there is one.
template <HasRangeGradient H>
SEMIEXPLICIT_COLD void compare_ranges(const H& hamiltonian, OtherGradients<H>& others) {
  using Scalar = typename H::Scalar;
  others.compare(GradientOutput::other_range, [&](const auto& z, const auto& differs) {
    const Eigen::Index d = z.dof(), size = std::max<Eigen::Index>(1, (d + 2) / 3);
    auto seen = z;
    Vector<Scalar, Eigen::Dynamic> found(2 * size);
    for (Eigen::Index begin = 0; begin < d; begin += size) {
      const Eigen::Index end = std::min(d, begin + size);
      if constexpr (HasLocalGradient<H>)
        for (Eigen::Index i = 0; i < d; ++i) {
          const bool reached = i >= begin - hamiltonian.reach() && i < end + hamiltonian.reach();
          seen.q()[i] = reached ? z.q()[i] : std::numeric_limits<Scalar>::quiet_NaN();
          seen.p()[i] = reached ? z.p()[i] : std::numeric_limits<Scalar>::quiet_NaN();
        }
      found.setOnes();
      const Scalar *q = seen.vector().data(), *p = q + d;
      Scalar *dHdq = found.data(), *dHdp = dHdq + size;
      hamiltonian.gradient_range(begin, end, q, p, dHdq, dHdp);
      for (Eigen::Index i = begin; i < end; ++i) {
        differs(i, found[i - begin]);
        differs(d + i, found[size + i - begin]);
      }
    }
  });
}

/// The motion under the exact flow, at its beginning, and the rest.
template <SplitHamiltonian H>
SEMIEXPLICIT_COLD void compare_parts(const H& hamiltonian, OtherGradients<H>& others) {
  using Scalar = typename H::Scalar;
  using Column = Vector<Scalar, H::Dof>;
  others.compare(GradientOutput::other_parts, [&](const auto& z, const auto& differs) {
    const Eigen::Index d = z.dof();
    std::decay_t<decltype(z)> rest(d), given(d);
    if constexpr (HasPositionRest<H>) {
      OutColumn<H> by_q(rest.vector().data(), d);
      hamiltonian.rest_position_gradient(InColumn<H>(z.vector().data(), d), by_q);
    }
    if constexpr (HasMomentumRest<H>) {
      OutColumn<H> by_p(rest.vector().data() + d, d);
      hamiltonian.rest_momentum_gradient(InColumn<H>(z.vector().data() + d, d), by_p);
    }
    if constexpr (HasCoupledRest<H>) {
      gradient_at(hamiltonian.coupled_rest(), z.vector().data(), given.vector().data(), d);
      rest.vector() += given.vector();
    }
    // From a tenth of the time in which the largest entry of a half goes by its own size.
    gradient_at(hamiltonian, z.vector().data(), given.vector().data(), d);
    const auto sizes = sizes_of_halves(z);
    const Scalar rate = std::max<Scalar>({largest_absolute(given.p()) / sizes[0].largest,
                                          largest_absolute(given.q()) / sizes[1].largest,
                                          (std::numeric_limits<Scalar>::min)()});
    Column q = z.q(), p = z.p(), dq = q, dp = p;
    const auto move = [&](const Scalar& t, const auto& from, auto& moved) {
      q = from.head(d);
      p = from.tail(d);
      dq.setZero();
      dp.setZero();
      Status status;
      if constexpr (HasPreparedFlow<H>)
        status = hamiltonian.prepared(t).increments(q, p, dq, dp);
      else
        status = hamiltonian.flow(t, q, p, dq, dp);
      moved << dq, dp;
      if (status != Status::success) moved.setConstant(std::numeric_limits<Scalar>::quiet_NaN());
    };
    using std::abs;
    using std::sqrt;
    const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), part = sqrt(epsilon);
    const Scalar largest[2] = {largest_absolute(z.q()), largest_absolute(z.p())};
    const auto partner = [&](Eigen::Index i) { return i < d ? i + d : i - d; };  // whose slope is the motion
    std::decay_t<decltype(z)> motion(d), slack(d);
    for (Eigen::Index i = 0; i < 2 * d; ++i) {
      const Scalar all = given.vector()[i], other = rest.vector()[i];
      motion.vector()[partner(i)] = i < d ? Scalar(other - all) : Scalar(all - other);
      slack.vector()[partner(i)] = part * std::max<Scalar>(abs(all), abs(other));
    }
    const auto said = OtherGradients<H>::judge_slopes(
        motion.vector(), slack.vector(), part,
        [&](const Scalar& t, auto& moved) { move(t, z.vector(), moved); }, Scalar(0.1) / rate,
        OtherGradients<H>::Steps::agreement);
    const auto is_wrong = [&](Eigen::Index i) { differs(i, std::numeric_limits<Scalar>::quiet_NaN()); };
    for (Eigen::Index i = 0; i < 2 * d; ++i)
      if (said.wrong[static_cast<std::size_t>(partner(i))]) is_wrong(i);
    if (!said.step) return;
    // Of the time 2t it is that of t, twice.
    const Scalar step = *said.step;
    std::decay_t<decltype(z)> once(d), twice(d), again(d), there = z;
    move(step, z.vector(), once.vector());
    there.vector() += once.vector();
    move(step, there.vector(), again.vector());
    move(2 * step, z.vector(), twice.vector());
    for (Eigen::Index i = 0; i < 2 * d; ++i) {
      const Scalar first = once.vector()[partner(i)], in_all = twice.vector()[partner(i)],
                   off = abs(first + again.vector()[partner(i)] - in_all);
      if (off > part * (abs(in_all) + abs(first)) + 64 * epsilon * largest[i < d ? 1 : 0]) is_wrong(i);
    }
  });
}

/// The second derivatives against those of the gradient.
template <Hamiltonian H>
SEMIEXPLICIT_COLD void compare_hessian(const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
                                       OtherGradients<H>& others) {
  const Eigen::Index d = z.dof();
  if constexpr (HasHessian<H>)
    others.compare_derivative([&](const auto& direction, auto& found) {
      Eigen::Matrix<typename H::Scalar, twice(H::Dof), twice(H::Dof)> matrix;
      matrix.setZero(2 * d, 2 * d);
      hamiltonian.hessian(InColumn<H>(z.vector().data(), d), InColumn<H>(z.vector().data() + d, d), matrix);
      found.vector() = matrix * direction.vector();
    });
  if constexpr (HasHessianTimes<H>)
    others.compare_derivative([&](const auto& direction, auto& found) {
      OutColumn<H> hq(found.vector().data(), d), hp(found.vector().data() + d, d);
      hamiltonian.hessian_times(InColumn<H>(z.vector().data(), d), InColumn<H>(z.vector().data() + d, d),
                                InColumn<H>(direction.vector().data(), d),
                                InColumn<H>(direction.vector().data() + d, d), hq, hp);
    });
}

/// Marks every entry that is written, and that another member of H makes another number.
template <Hamiltonian H>
SEMIEXPLICIT_COLD void compare_members(const H& hamiltonian, const PhasePoint<typename H::Scalar, H::Dof>& z,
                                       std::vector<GradientOutput>& outputs) {
  OtherGradients<H> others(hamiltonian, z, outputs);
  if constexpr (HasPackGradient<H>) compare_packs(hamiltonian, others);
#ifdef SEMIEXPLICIT_HAS_LANES
  if constexpr (HasLaneGradient<H>) compare_lanes(hamiltonian, others);
#endif
  if constexpr (SeparableHamiltonian<H>) compare_halves(hamiltonian, others);
  if constexpr (HasRangeGradient<H>) compare_ranges(hamiltonian, others);
  if constexpr (SplitHamiltonian<H>) compare_parts(hamiltonian, others);
  compare_hessian(hamiltonian, z, others);
}

}  // namespace detail

}  // namespace semiexplicit
