#pragma once

#include <initializer_list>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/core/vector.hpp>

namespace semiexplicit {

/// A point z = (q, p) of the phase space R^{2d}: one contiguous vector, positions first.
template <class ScalarType, int DofValue>
class PhasePoint {
 public:
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;
  using Storage = Vector<Scalar, twice(Dof)>;

  /// All zeros; an empty point where the size is dynamic.
  PhasePoint() : z_(Storage::Zero(Dof == Eigen::Dynamic ? 0 : 2 * Dof)) {}

  /// All zeros, with `dof` degrees of freedom. Throws std::invalid_argument where that is negative, or a
  /// fixed size says otherwise.
  explicit PhasePoint(Eigen::Index dof) {
    require_size("dof", dof);
    z_.setZero(2 * dof);
  }

  /// From positions and momenta of equal size; throws std::invalid_argument otherwise.
  PhasePoint(const Vector<Scalar, Dof>& q, const Vector<Scalar, Dof>& p) : PhasePoint(q.size()) {
    if (p.size() != q.size())
      throw std::invalid_argument("PhasePoint: q has " + std::to_string(q.size()) + " entries and p has " +
                                  std::to_string(p.size()) + "; give both the same size");
    this->q() = q;
    this->p() = p;
  }

  /// The same from lists: `PhasePoint<double, 2> z({1, 0}, {0, 1})`.
  PhasePoint(std::initializer_list<Scalar> q, std::initializer_list<Scalar> p)
      : PhasePoint(column("q", q), column("p", p)) {}

  /// One degree of freedom from two numbers.
  PhasePoint(const Scalar& q, const Scalar& p) requires(Dof == 1) : z_(q, p) {}

  Eigen::Index dof() const { return z_.size() / 2; }

  /// Positions and momenta: views of length d into the point.
  auto q() { return first_half(z_); }
  auto q() const { return first_half(z_); }
  auto p() { return second_half(z_); }
  auto p() const { return second_half(z_); }

  /// (q, p) as one vector of length 2d.
  Storage& vector() { return z_; }
  const Storage& vector() const { return z_; }

 private:
  template <class Z>
  static auto first_half(Z& z) {
    if constexpr (Dof == Eigen::Dynamic)
      return z.head(z.size() / 2);
    else
      return z.template head<Dof>();
  }
  template <class Z>
  static auto second_half(Z& z) {
    if constexpr (Dof == Eigen::Dynamic)
      return z.tail(z.size() / 2);
    else
      return z.template tail<Dof>();
  }
  static void require_size(const char* name, Eigen::Index size) {
    if (size < 0 || (Dof != Eigen::Dynamic && size != Dof)) refuse_size(name, size);
  }
  [[noreturn]] static void refuse_size(const char* name, Eigen::Index size) {
    throw std::invalid_argument(std::string("PhasePoint: ") + name + " has size " + std::to_string(size) +
                                (Dof == Eigen::Dynamic
                                     ? "; give 0 or more"
                                     : ", but this type has " + std::to_string(Dof) + " degrees of freedom"));
  }
  static Vector<Scalar, Dof> column(const char* name, std::initializer_list<Scalar> list) {
    require_size(name, static_cast<Eigen::Index>(list.size()));
    return Eigen::Map<const Vector<Scalar, Dof>>(list.begin(), static_cast<Eigen::Index>(list.size()));
  }

  Storage z_;
};

namespace detail {

/// What observers of integrate() are shown: a state with its positions and momenta.
template <class State>
concept HasHalves = requires(const State& z) {
  z.q();
  z.p();
};

/// Compiles unless the types of a state and of an observer tell that their numbers of degrees of freedom
/// differ.
template <HasHalves State, int Dof>
consteval bool is_state_of() {
  using Column = std::remove_cvref_t<decltype(std::declval<const State&>().q())>;
  constexpr bool fits = [] {
    if constexpr (requires { Column::SizeAtCompileTime; })
      return sizes_may_agree(Column::SizeAtCompileTime, Dof);
    else
      return true;
  }();
  static_assert(
      fits,
      "the state has another number of degrees of freedom than this observer: give an observer of "
      "its Dof, as Record<double, 2> for PhasePoint<double, 2>, and Invariants the Hamiltonian of the run");
  return fits;
}

/// Throws std::invalid_argument, in the name of `who`, where a state has not the number of degrees of freedom
/// that `whose` has.
inline void require_same_dof(const char* who, Eigen::Index state, const char* whose, Eigen::Index own,
                             const char* remedy = "give both the same size") {
  if (state != own)
    throw std::invalid_argument(std::string(who) + ": the state has " + std::to_string(state) +
                                " degrees of freedom and the " + whose + " " + std::to_string(own) + "; " +
                                remedy);
}

}  // namespace detail

template <class Scalar, int Dof>
PhasePoint(const Vector<Scalar, Dof>&, const Vector<Scalar, Dof>&) -> PhasePoint<Scalar, Dof>;

/// A point ζ = (q, x, p, y) of the doubled phase space, kept as two ordinary phase points a = (q, y) and b =
/// (x, p): in this order the flow of H(q, y) is "b moves along the vector field at a", and the other one the
/// reverse.
template <class ScalarType, int DofValue>
struct ExtendedPoint {
  using Scalar = ScalarType;
  static constexpr int Dof = DofValue;

  /// Two equal copies of z: a point of the invariant subspace N.
  explicit ExtendedPoint(const PhasePoint<Scalar, Dof>& z) : a(z), b(z) {}

  Eigen::Index dof() const { return a.dof(); }

  auto q() const { return a.q(); }
  auto x() const { return b.q(); }
  auto p() const { return b.p(); }
  auto y() const { return a.p(); }

  /// ‖(q, p) - (x, y)‖, how far the copies are apart (Euclidean norm).
  Scalar defect() const { return detail::norm(a.vector() - b.vector()); }

  PhasePoint<Scalar, Dof> a, b;
};

template <class Scalar, int Dof>
ExtendedPoint(const PhasePoint<Scalar, Dof>&) -> ExtendedPoint<Scalar, Dof>;

}  // namespace semiexplicit
