#pragma once

#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <string>

#include <semiexplicit/chaos/detail/tangent_run.hpp>
#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/gradient_size.hpp>

namespace semiexplicit {

/// An observer that tells chaos from order sooner than Lyapunov exponents do: the generalised alignment
/// indices GALI_2 to GALI_k, the volumes of the parallelepipeds of the first 2 to k of its k tangent vectors,
/// each of length one. All start at 1. In chaos the vectors fall into line, and GALI_j decays as
/// exp(-[(λ₁-λ₂) + ... + (λ₁-λⱼ)] t); on a regular orbit, a torus of d dimensions, it stays about constant
/// for j ≤ d, and falls as t^{-2(j-d)} beyond. (Where the torus has fewer dimensions s, constant up to j =
/// s.)
///
///     AlignmentIndex gali(stepper, 2);                   // SALI is GALI_2 but for a factor between 1 and √2
///     integrate(stepper, z, {.dt = 0.05, .steps = 20'000}, gali);
///     gali.index(2), gali.log_index(2);
///
/// The vectors are carried as V = QR, Q orthonormal, so that an index is right long after the vectors
/// themselves agree in all digits: of what is smaller than any number log_index() still tells. What it takes
/// of steppers, work and memory is as for LyapunovExponents.
///
/// Source: Ch. Skokos, T. C. Bountis, Ch. Antonopoulos, Physica D 231 (2007) 30; SALI: Ch. Skokos, J. Phys. A
/// 34 (2001) 10029.
template <class Stepper>
class AlignmentIndex {
 public:
  using Scalar = typename Stepper::Scalar;
  static constexpr int Dof = Stepper::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "AlignmentIndex";

  /// `count` vectors; throws std::invalid_argument for another number than 2 to 2d, of a driven
  /// system 2d - 1.
  explicit AlignmentIndex(const Stepper& stepper, Eigen::Index count = 2)
      : run_(name, stepper, 2, count),
        step_(Square::Zero(count, count)),
        r_(Square::Identity(count, count)),
        column_(Column::Zero(count)),
        log_sides_(Sums::Zero(count)) {}

  /// Takes in the next state. Throws as LyapunovExponents does.
  void operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    using std::log;
    if (!run_.follow(t, z, run)) return;
    run_.orthonormalise([&](Eigen::Index i, Eigen::Index j, const Scalar& r) { step_(i, j) = r; });
    for (Eigen::Index j = 0; j < run_.count(); ++j) {
      for (Eigen::Index i = 0; i <= j; ++i) {
        column_[i] = Scalar(0);
        for (Eigen::Index l = i; l <= j; ++l) column_[i] += step_(i, l) * r_(l, j);
      }
      const Scalar length = detail::norm(column_.head(j + 1));
      r_.col(j).head(j + 1) = column_.head(j + 1) / length;
      log_sides_[j] += log(static_cast<Sum>(step_(j, j))) - log(static_cast<Sum>(length));
    }
  }

  /// Whether it has seen nothing yet.
  bool fresh() const { return run_.fresh(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("vectors", run_.count());
    list.function("Hamiltonian", GradientSize(run_.hamiltonian()));
    list("scheme", run_.scheme());
  }
  /// The vectors that it carries along; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    run_.visit_memory(visit);
    visit(r_);
    visit(log_sides_);
  }

  /// GALI_j, 2 ≤ j ≤ count, between 0 and 1, and its natural logarithm. Throws std::invalid_argument for
  /// another j.
  Scalar index(Eigen::Index j) const {
    using std::exp;
    return exp(log_index(j));
  }
  Scalar log_index(Eigen::Index j) const {
    if (j < 2 || j > run_.count())
      throw std::invalid_argument("AlignmentIndex: GALI_" + std::to_string(j) + " of " +
                                  std::to_string(run_.count()) + " vectors; give 2 to their number");
    return static_cast<Scalar>(log_sides_.head(j).sum());
  }
  /// The smaller alignment index min ‖v₁ ± v₂‖ of the first two vectors, between 0 and √2.
  Scalar smaller() const {
    using std::sqrt;
    const Scalar sine = index(2);
    return sine * sqrt(2 / (1 + sqrt(sine < Scalar(1) ? Scalar((1 - sine) * (1 + sine)) : Scalar(0))));
  }

 private:
  using Square = Eigen::Matrix<Scalar, Eigen::Dynamic, Eigen::Dynamic>;
  using Column = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;
  using Sum = typename detail::TangentRun<Stepper>::Sum;
  using Sums = Eigen::Matrix<Sum, Eigen::Dynamic, 1>;

  detail::TangentRun<Stepper> run_;
  Square step_, r_;  ///< R of the last step; of all, its columns of length one
  Column column_;
  Sums log_sides_;  ///< of the j-th vector's part across those before it; the vectors of length one
};

}  // namespace semiexplicit
