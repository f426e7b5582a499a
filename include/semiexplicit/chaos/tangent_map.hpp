#pragma once

#include <algorithm>
#include <cmath>
#include <utility>

#include <semiexplicit/core/extended_phase_space.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/linear_system.hpp>
#include <semiexplicit/core/ranks.hpp>
#include <semiexplicit/derivatives/hessian.hpp>
#include <semiexplicit/steppers/semiexplicit.hpp>

namespace semiexplicit {

/// The derivative M = ∂z'/∂z of a step of Semiexplicit, by the implicit function theorem. With the copies a =
/// z + m, b = z - m before and a', b' after the kicks, which are linearised one by one with the Hessian of H,
///
///     δm = -F⁻¹ (δa' - δb')|_{δm = 0},   F = ∂(a' - b' + 2m)/∂m,   M δz = (δa' + δb')/2.
///
/// M is symplectic to rounding, MᵀJM = J. It is the derivative of the step whose projection is solved
/// exactly; the multiplier is found anew here, by Newton's method with F.
///
///     TangentMap tangent(stepper);
///     if (tangent.at(z, dt) == Status::success) ... tangent.matrix() ...   // of the step that starts at z
///
/// Give H a Hessian, by hand or by from_energy(), where figures matter. It is believed, also one that H has
/// from a base class with another gradient; TangentVectors::check() tells. Without one it is an estimate,
/// from differences of the gradient by shifts that are right where neighbouring ones agree, and no bound of
/// its error is known. M, symplectic all the same, is usually off by 1e-9 of its size in double, 1e-5 in
/// float, in any units, near a very close pair by 1e-6; of an angle x by (2e-16 |x|)^{2/3}, 1e-6 at 6e6. It
/// may be off by much more
///  - where the gradient is a small difference of large terms: orbits of less than 1e-4 of the lengths of H
///    about the point from which q or p counts, late times in a fast drive;
///  - where nothing tells these lengths: from rest, or where q or p is zero, in units that are not those of
///    the orbit; where coordinates of a half are in units that are far apart;
///  - of what varies within 1e-3 of its distance from the origin;
///  - in float, one step of a hundred by 1e-2, where the orbit counts in 1e-2 and less.
///
/// Of an Autonomous without ∂H/∂t the last row is that of a run that follows p_t, but for ∂²H/∂t². The shifts
/// are kept from call to call. Cost: two or three sweeps with a Hessian a kick and products of matrices,
/// O(d³). Memory: O(d²). No heap use for a size known at compile time; otherwise Eigen's factorisation and
/// products take some.
template <class H>
class TangentMap {
 public:
  using Scalar = typename detail::HamiltonianDoor<H>::Scalar;
  static constexpr int Dof = detail::HamiltonianDoor<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  using Matrix = typename detail::SecondDerivatives<H>::Matrix;
  static_assert(detail::is_in_one_process<H>());
  static_assert(detail::second_derivatives_can_be_called<H>());

  TangentMap(H hamiltonian, Scheme<Scalar> scheme)
      : hamiltonian_(std::move(hamiltonian)),
        scheme_(std::move(scheme)),
        size_(2 * dof_of(hamiltonian_)),
        second_(dof_of(hamiltonian_)),
        correction_(dof()),
        a_(State(dof()).vector()),
        b_(a_),
        m_(a_),
        gradient_(a_),
        hessian_(Matrix::Zero(size_, size_)),
        slope_(hessian_),
        solution_(hessian_),
        matrix_(Matrix::Identity(size_, size_)),
        da_(Columns::Zero(size_, 2 * size_)),
        db_(da_),
        system_(size_) {
    scheme_.check();
    detail::require_symplectic(hamiltonian_, "TangentMap", "compare runs from neighbouring states instead");
  }

  /// Of the steps of that stepper.
  template <class Solver>
  explicit TangentMap(const Semiexplicit<H, Solver>& stepper)
      : TangentMap(stepper.hamiltonian(), stepper.scheme()) {}

  /// Finds M for the step of size dt from z. Status::success, or what went wrong (describe() says it in
  /// words).
  Status at(const State& z, const Scalar& dt) {
    using std::isfinite;
    using std::pow;
    const bool fits = z.vector().size() == size_ && detail::all_finite(z.vector());
    if (const Status start = detail::status_at_start(dt, !scheme_.b.empty(), fits); start != Status::success)
      return start;
    Scalar close(0), rounding(0), last(0);
    m_.setZero();
    for (int iteration = 0; iteration < 20; ++iteration) {
      sweep(z, dt);
      combine(by_m, Scalar(-1), system_.matrix.data());
      for (Eigen::Index k = 0; k < size_; ++k) system_.matrix(k, k) += Scalar(2);
      system_.factorise();
      // At a multiplier that is off by this M is off by this times dt and third derivatives. Far from the
      // origin it is what the step moves that counts; rounding may not let corrections be as small there.
      if (iteration == 0) {
        const Scalar epsilon = Eigen::NumTraits<Scalar>::epsilon(), moved = detail::norm(a_ - z.vector());
        close = pow(epsilon, Scalar(0.75)) *
                std::min<Scalar>(detail::state_size(hamiltonian_, z) + moved, 100 * moved);
        rounding = 8 * epsilon * detail::norm(z.vector()) + close;
      }
      for (Eigen::Index k = 0; k < size_; ++k) gradient_[k] = a_[k] - b_[k] + 2 * m_[k];  // f
      system_.solve(gradient_.data(), correction_.vector().data());
      const Scalar correction = detail::state_size(hamiltonian_, correction_);
      if (!isfinite(correction)) return Status::not_finite;
      if (correction <= close || (correction <= rounding && 2 * correction >= last && iteration > 0)) {
        finish();
        return detail::all_finite(matrix_) ? Status::success : Status::not_finite;
      }
      m_ -= correction_.vector();
      last = correction;
    }
    return Status::no_convergence;
  }

  /// M of the last at() that succeeded; the identity before. Rows and columns in the order of
  /// PhasePoint::vector().
  const Matrix& matrix() const { return matrix_; }

  /// What the differences for a Hessian carry from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    second_.visit_memory(visit);
  }

  Eigen::Index dof() const { return dof_of(hamiltonian_); }
  const H& hamiltonian() const { return hamiltonian_; }
  const Scheme<Scalar>& scheme() const { return scheme_; }

 private:
  using Vec = typename State::Storage;
  using Columns =
      Eigen::Matrix<Scalar, twice(Dof), detail::columns_in_place<Scalar>(twice(Dof), twice(twice(Dof)))>;

  /// The two halves of da_ and db_: derivatives with respect to z, and to m.
  static constexpr Eigen::Index by_z = 0, by_m = 1;

  /// One half of da_ + sign * db_.
  void combine(Eigen::Index half, const Scalar& sign, Scalar* out) const {
    const Eigen::Index size = matrix_.size();
    for (Eigen::Index k = 0; k < size; ++k)
      out[k] = da_.data()[half * size + k] + sign * db_.data()[half * size + k];
  }

  /// M from the derivatives of the copies at the solution, where system_ has F.
  void finish() {
    combine(by_z, Scalar(-1), slope_.data());
    for (Eigen::Index k = 0; k < size_; ++k)
      system_.solve(slope_.data() + k * size_, solution_.data() + k * size_);
    combine(by_m, Scalar(1), slope_.data());
    matrix_.noalias() = slope_ * solution_;
    combine(by_z, Scalar(1), slope_.data());
    for (Eigen::Index k = 0; k < matrix_.size(); ++k)
      matrix_.data()[k] = (slope_.data()[k] - matrix_.data()[k]) / 2;
  }

  /// All kicks on the copies and on their derivatives with respect to z (left half of the columns) and m
  /// (right half).
  void sweep(const State& z, const Scalar& dt) {
    a_ = z.vector() + m_;
    b_ = z.vector() - m_;
    da_.setZero();
    db_.setZero();
    for (Eigen::Index k = 0; k < size_; ++k) {
      da_(k, k) = da_(k, size_ + k) = db_(k, k) = Scalar(1);
      db_(k, size_ + k) = Scalar(-1);
    }
    detail::sweep(
        scheme_, dt, [&](const Scalar& t) { kick(t, a_, da_, b_, db_); },
        [&](const Scalar& t) { kick(t, b_, db_, a_, da_); });
  }

  void kick(const Scalar& t, const Vec& from, const Columns& dfrom, Vec& to, Columns& dto) {
    const Eigen::Index d = size_ / 2;
    detail::gradient_at(hamiltonian_, from.data(), gradient_.data(), d);
    detail::add(t, gradient_.data(), to.data(), d, d);
    second_(hamiltonian_, from, hessian_);
    for (Eigen::Index k = 0; k < size_; ++k)
      for (Eigen::Index i = 0; i < d; ++i) {
        slope_(i, k) = t * hessian_(d + i, k);
        slope_(d + i, k) = -t * hessian_(i, k);
      }
    dto.noalias() += slope_ * dfrom;
  }

  H hamiltonian_;
  Scheme<Scalar> scheme_;
  Eigen::Index size_;
  detail::SecondDerivatives<H> second_;
  State correction_;
  Vec a_, b_, m_, gradient_;
  Matrix hessian_, slope_, solution_, matrix_;
  Columns da_, db_;  // ∂a/∂(z, m), ∂b/∂(z, m)
  detail::LinearSystem<Scalar> system_;
};

template <class H, class Solver>
TangentMap(const Semiexplicit<H, Solver>&) -> TangentMap<H>;

}  // namespace semiexplicit
