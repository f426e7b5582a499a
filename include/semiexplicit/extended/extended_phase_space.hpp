#pragma once

#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// The phase space of d degrees of freedom with the time as one more coordinate: (q, t) and (p, p_t). What the Hamiltonians
/// that live in it share.
template <class ScalarType, int D>
class ExtendedPhaseSpace {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = D == Eigen::Dynamic ? Eigen::Dynamic : D + 1;
  using State = PhasePoint<Scalar, Dof>;
  using Point = PhasePoint<Scalar, D>;

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

}  // namespace semiexplicit
