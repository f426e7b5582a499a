#pragma once

#include <cmath>
#include <stdexcept>
#include <string>

#include <semiexplicit/chaos/detail/tangent_step.hpp>

namespace semiexplicit {

/// Tangent vectors of a phase space that a stepper's steps carry along: each step multiplies them by its
/// derivative, which is never written down. k vectors take time and memory as k d, where TangentMap takes d³
/// and d².
///
///     TangentVectors tangents(stepper, 2);
///     tangents.vectors().col(0) = ...;
///     if (tangents.advance(z, dt).ok()) stepper.step(z, dt);     // of the step that starts at z
///
/// Of Semiexplicit (with any solver), MidpointProjection and ExplicitSplitting; of ReversibleSteps dt is the
/// time that the step takes, which is known behind it. A tangent vector of the
/// projected step has an equation of projection of its own, which the stepper's solver solves to the
/// stepper's rule: vᵀJu of two vectors is kept as the steps keep symplecticity. Beside the step's own sweep
/// that takes one sweep of gradients, and one of second derivatives for each vector.
///
/// Second derivatives along a vector come from `hessian_times` of the Hamiltonian (HasHessianTimes), which
/// costs about two gradients; else from its gradient with dual numbers where `using PackGradientOf = H;` says
/// that it is a template that only indexes its arguments, of eight vectors at a time; else from its
/// `hessian`; else from differences of the gradient, two calls a vector and kick. Those are estimates, see
/// TangentMap for where they may be wrong: usually they are off by about 1e-9 of their size in double and
/// 1e-5 in float, for some steps by a hundred times that, of an angle that has wound up to x by
/// (2e-16 x)^{2/3}, and so is what is kept of vᵀJu, where the others are exact to rounding.
/// In float that makes a regular orbit look chaotic in the end: growth that is linear in exact arithmetic
/// turns exponential, at a rate near √1e-5 of the orbit's own, after some hundred periods. Give second
/// derivatives there, or double.
/// A difference moves both halves of a vector at once: where units of positions and momenta are 1e6 and more
/// apart (1e3 in float), the halves of a vector have to be as far apart as those of the state, or rounding
/// hides what the smaller one does.
/// Up to four degrees of freedom, and with d vectors and more, a matrix of differences is taken, which is
/// symmetric.
///
/// Memory: 5k + 14 vectors of length 2d, with dual numbers of more than four vectors 5k + 61. No heap use in
/// a step.
template <class Stepper>
class TangentVectors {
  static_assert(detail::is_stepper<Stepper>());
  using Step = detail::TangentStep<Stepper>;

 public:
  using Scalar = typename Stepper::Scalar;
  static constexpr int Dof = Stepper::Dof;
  using State = PhasePoint<Scalar, Dof>;
  /// 2d rows, in the order of PhasePoint::vector(), and a column a vector.
  using Vectors = detail::Frame<Scalar, Dof>;

  /// `count` vectors, the first columns of the identity. Throws std::invalid_argument for a count below 1.
  TangentVectors(const Stepper& stepper, Eigen::Index count)
      : step_(checked(stepper), require(count)),
        vectors_(Vectors::Identity(2 * stepper.dof(), count)),
        scale_(count) {}

  /// To be set before the first step, and read after each; of any length but NaN or Inf, and as many.
  Vectors& vectors() { return vectors_; }
  const Vectors& vectors() const { return vectors_; }
  Eigen::Index count() const { return vectors_.cols(); }

  /// The vectors become their images by the derivative of the step of size dt, which may be negative, from z.
  /// They are untouched unless the report is ok(); its evaluations and its correction are those of the
  /// vectors' own projection. Throws std::invalid_argument where vectors() has become a matrix of another
  /// size.
  StepReport advance(const State& z, const Scalar& dt) {
    require_size();
    // To a length near one, since one rule judges all, and by powers of two, which rounds nothing.
    for (Eigen::Index j = 0; j < count(); ++j) scale_[j] = to_length_one(j);
    struct Back {  // also where a gradient throws
      TangentVectors& tangents;
      ~Back() {
        for (Eigen::Index j = 0; j < tangents.count(); ++j)
          if (tangents.scale_[j] != 0) tangents.multiply(j, -tangents.scale_[j]);
      }
    } back{*this};
    return step_(z, vectors_, dt);
  }

  /// Throws std::invalid_argument where the Hamiltonian's hessian_times is not the derivative of its gradient
  /// at z along the first vector, as far as differences of the gradient can tell. Some dozens of gradients,
  /// and memory of its own.
  void check(const State& z) {
    require_size();
    typename State::Storage v = vectors_.col(0);
    const Scalar length = detail::norm(v);
    if (length > Scalar(0)) step_.second().check(step_.hamiltonian(), z.vector(), v / length);
  }

  /// See HessianProduct::unit_of_momenta(), along the first vector.
  Scalar unit_of_momenta(const State& z) {
    require_size();
    const typename State::Storage v = vectors_.col(0);
    return step_.second().unit_of_momenta(step_.hamiltonian(), z.vector(), v);
  }

  Eigen::Index dof() const { return vectors_.rows() / 2; }
  const auto& hamiltonian() const { return step_.hamiltonian(); }
  const Scheme<Scalar>& scheme() const { return step_.scheme(); }

  /// The vectors, and what differences carry from step to step; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    step_.second().visit_memory(visit);
    visit(vectors_);
  }

 private:
  static const Stepper& checked(const Stepper& stepper) {
    if constexpr (requires { stepper.hamiltonian(); })
      detail::require_symplectic(stepper.hamiltonian(), "tangent vectors",
                                 "compare runs from neighbouring states instead");
    return stepper;
  }

  static Eigen::Index require(Eigen::Index count) {
    if (count < 1)
      throw std::invalid_argument("TangentVectors: " + std::to_string(count) + " vectors; give one or more");
    return count;
  }

  void require_size() const {
    if (count() != scale_.size() || (count() > 0 && vectors_.rows() != 2 * dof_of(step_.hamiltonian())))
      throw std::invalid_argument("TangentVectors: vectors() has been given " +
                                  std::to_string(vectors_.rows()) + " rows and " + std::to_string(count()) +
                                  " columns; set entries of it, or make it for as many vectors");
  }

  void multiply(Eigen::Index j, int power) {
    using std::ldexp;
    const int half = power / 2;  // the whole of it may be no number
    const Scalar factor = ldexp(Scalar(1), half), other = ldexp(Scalar(1), power - half);
    for (Eigen::Index i = 0; i < vectors_.rows(); ++i) vectors_(i, j) = vectors_(i, j) * factor * other;
  }
  int to_length_one(Eigen::Index j) {
    using std::frexp;
    using std::isfinite;
    const Scalar length = detail::norm(vectors_.col(j));
    int power = 0;
    if (!(length < Scalar(0.5) || length > Scalar(2)) || length == Scalar(0) || !isfinite(length)) return 0;
    frexp(length, &power);
    multiply(j, -power);
    return -power;
  }

  Step step_;
  Vectors vectors_;
  Eigen::Matrix<int, Eigen::Dynamic, 1> scale_;
};

}  // namespace semiexplicit
