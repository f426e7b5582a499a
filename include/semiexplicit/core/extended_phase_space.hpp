#pragma once

#include <cmath>
#include <concepts>
#include <cstddef>

#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/ranks.hpp>

namespace semiexplicit {

/// The phase space of d degrees of freedom with the time as one more coordinate: (q, t) and (p, p_t). A
/// Hamiltonian says that it lives in it by deriving from this class, as Autonomous and TimeTransformed do;
/// see InExtendedPhaseSpace.
template <class ScalarType, int D>
class ExtendedPhaseSpace {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = D == Eigen::Dynamic ? Eigen::Dynamic : D + 1;
  using State = PhasePoint<Scalar, Dof>;
  using Point = PhasePoint<Scalar, D>;
  /// Whether a step of dt is one of the time, as Autonomous's; TimeTransformed says that its own are not.
  static constexpr bool steps_in_time = true;

  /// The phase point (q, p), and the time, of an extended one.
  static Point point(const State& extended) {
    Point z(extended.dof() - 1);
    z.q() = head(extended.q());
    z.p() = head(extended.p());
    return z;
  }
  static Scalar time(const State& extended) { return extended.q()[extended.dof() - 1]; }

 protected:
  static State join(const Point& z, const Scalar& t, const Scalar& p_t) {
    const Eigen::Index d = z.dof();
    State extended(d + 1);
    extended.q().head(d) = z.q();
    extended.p().head(d) = z.p();
    extended.q()[d] = t;
    extended.p()[d] = p_t;
    return extended;
  }

  /// (q) of (q, t), or (p) of (p, p_t).
  template <class V>
  static auto head(V&& v) {
    if constexpr (D == Eigen::Dynamic)
      return v.head(v.size() - 1);
    else
      return v.template head<D>();
  }
};

/// H derives from ExtendedPhaseSpace: its last coordinate is the time. Observers then take the time from the
/// state, and tolerances leave it out. A member that is merely called time() says nothing.
template <class H>
concept InExtendedPhaseSpace =
    (H::Dof == Eigen::Dynamic || H::Dof > 1) &&
    std::derived_from<
        H, ExtendedPhaseSpace<typename H::Scalar, H::Dof == Eigen::Dynamic ? Eigen::Dynamic : H::Dof - 1>>;

namespace detail {

/// How many of d degrees of freedom are the system's own: not the last one of an extended phase space.
template <class H>
constexpr Eigen::Index own_dof(Eigen::Index d) {
  return InExtendedPhaseSpace<H> ? d - 1 : d;
}

template <class H>
inline constexpr int own_dof_of = H::Dof == Eigen::Dynamic ? Eigen::Dynamic
                                                           : static_cast<int>(own_dof<H>(H::Dof));

/// The size that tolerances are relative to: ‖z‖, in an extended phase space without the last degree of
/// freedom, (t, p_t). After a long time t would outweigh all else, and every tolerance with it.
template <class H, class Scalar, int Dof>
Scalar state_size([[maybe_unused]] const H& h, const PhasePoint<Scalar, Dof>& z) {
  if constexpr (InExtendedPhaseSpace<H>)
    return norm(Vector<Scalar, 2>(norm(z.q().head(z.dof() - 1)), norm(z.p().head(z.dof() - 1))));
  else
    return norm_over_ranks(h, z.vector());
}

/// What the rounding of a sum of `kicks` terms leaves of a difference of the copies in the last degree of
/// freedom of an extended phase space, (t, p_t) = (z[d-1], z[2d-1]), where both should be equal: |f| <= this
/// is nothing. At a late time it would outweigh all else, and hide an iteration that diverges.
template <class Scalar>
Scalar time_rounding(const Scalar& value, std::size_t kicks) {
  using std::abs;
  return Scalar(static_cast<double>(2 * kicks + 4)) * Eigen::NumTraits<Scalar>::epsilon() * abs(value);
}
/// Whether an entry f of the last degree of freedom is nothing to solve for, of a number or of lanes: a
/// rounding; and whatever is finite where steps are of the time. p_t acts on nothing there, and the mean of
/// the copies is the same whatever they differ by, in any unit of energy.
template <class H, class Number>
auto needs_no_solving(const Number& f, [[maybe_unused]] const Number& z, [[maybe_unused]] std::size_t kicks) {
  using std::abs;
  if constexpr (H::steps_in_time)
    return f - f == Number(0);
  else
    return abs(f) <= time_rounding(z, kicks);
}
template <class H, class Vec>
void drop_time(const Vec& z, Vec& f, std::size_t kicks) {
  if constexpr (InExtendedPhaseSpace<H>)
    for (const Eigen::Index last : {z.size() / 2 - 1, z.size() - 1})
      if (needs_no_solving<H>(f[last], z[last], kicks)) f[last] = 0;
}

}  // namespace detail
}  // namespace semiexplicit
