#pragma once

#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>

#include <semiexplicit/tangent/tangent_map.hpp>

namespace semiexplicit {

/// An observer that measures how fast neighbouring orbits part: the Lyapunov exponents of the run it observes, the largest
/// first, in units of 1/time. It carries a few tangent vectors along by the tangent map of every step and makes them
/// orthonormal again after each; an exponent is the mean growth of the logarithm of their lengths.
///
///     LyapunovExponents lyapunov(stepper, 1);            // the maximal one; without a number all 2d
///     integrate(stepper, z, {.dt = 0.05, .steps = 200'000}, lyapunov);
///     lyapunov.exponents()[0];
///
/// These are estimates at the time reached: of a regular orbit they fall to zero like ln(t)/t, so look at them at several
/// times (in another observer, say). The exponents of a Hamiltonian system come in pairs ±λ, two of them zero for each
/// integral of motion. Let the stepper be the one that makes the run.
///
/// Source: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
template <Hamiltonian H>
class LyapunovExponents {
 public:
  using Scalar = typename H::Scalar;
  using State = PhasePoint<Scalar, H::Dof>;
  using Exponents = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// `count` exponents of 2d; throws std::invalid_argument for another number than 1 to 2d.
  LyapunovExponents(TangentMap<H> tangent, Eigen::Index count)
      : tangent_(std::move(tangent)),
        previous_(tangent_.dof()),
        frame_(Frame::Zero(2 * tangent_.dof(), count > 0 ? count : 1)),
        moved_(frame_),
        sums_(Exponents::Zero(frame_.cols())) {
    if (count < 1 || count > 2 * tangent_.dof())
      throw std::invalid_argument("LyapunovExponents: " + std::to_string(count) +
                                  " exponents asked for; there are " + std::to_string(2 * tangent_.dof()));
    // Directions of no symmetry, in which every growth has a part.
    for (Eigen::Index j = 0; j < frame_.cols(); ++j)
      for (Eigen::Index i = 0; i < frame_.rows(); ++i)
        frame_(i, j) = Scalar(std::sin(1.0 + static_cast<double>((i + 1) * (i + 1) * (j + 1))));
    orthonormalise();
    sums_.setZero();
  }
  template <class Solver>
  LyapunovExponents(const Semiexplicit<H, Solver>& stepper, Eigen::Index count)
      : LyapunovExponents(TangentMap<H>(stepper), count) {}
  template <class Solver>
  explicit LyapunovExponents(const Semiexplicit<H, Solver>& stepper)
      : LyapunovExponents(stepper, 2 * stepper.dof()) {}

  /// Takes in the next state. Throws std::runtime_error, saying what is wrong, where the step has no tangent map,
  /// and std::invalid_argument where the time turns round.
  void operator()(const Scalar& t, const State& z) {
    using std::abs;
    // A run that goes on shows its last state again, at a time that may differ by rounding.
    const bool again = started_ && abs(t - time_) <= 64 * Eigen::NumTraits<Scalar>::epsilon() * abs(t);
    if (started_ && !again) {
      if (time_ != begin_ && (t > time_) != (time_ > begin_))
        throw std::invalid_argument(
            "LyapunovExponents: the time turned round; every run wants an observer of its own");
      const Status status = tangent_.at(previous_, t - time_);
      if (status != Status::success) {
        std::ostringstream text;
        text << "LyapunovExponents: no tangent map of the step to t = " << static_cast<double>(t) << ": "
             << describe(status);
        throw std::runtime_error(text.str());
      }
      moved_.noalias() = tangent_.matrix() * frame_;
      frame_ = moved_;
      orthonormalise();
    }
    if (!started_) begin_ = t;
    started_ = true;
    time_ = t;
    previous_ = z;
  }

  /// Whether it has seen nothing yet: a run that goes on would give the exponents of its end only.
  bool fresh() const { return !started_; }

  /// The vectors that it carries along and what they have grown; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    visit(frame_);
    visit(sums_);
    visit(previous_.vector());
    visit(begin_);
    visit(time_);
    visit(started_);
  }

  /// The estimates up to now; zero before the first step.
  Exponents exponents() const {
    if (time_ == begin_) return Exponents::Zero(sums_.size());
    return sums_ / (time_ - begin_);
  }

 private:
  using Frame = Eigen::Matrix<Scalar, twice(H::Dof), Eigen::Dynamic>;

  /// Modified Gram-Schmidt; adds the logarithms of the lengths.
  void orthonormalise() {
    using std::log;
    for (Eigen::Index j = 0; j < frame_.cols(); ++j) {
      for (Eigen::Index k = 0; k < j; ++k)
        frame_.col(j) -= detail::dot(frame_.col(k), frame_.col(j)) * frame_.col(k);
      const Scalar length = detail::norm(frame_.col(j));
      frame_.col(j) /= length;
      sums_[j] += log(length);
    }
  }

  TangentMap<H> tangent_;
  State previous_;
  Frame frame_, moved_;
  Exponents sums_;
  Scalar begin_ = Scalar(0), time_ = Scalar(0);
  bool started_ = false;
};

template <class H, class Solver, class... Count>
LyapunovExponents(const Semiexplicit<H, Solver>&, Count...) -> LyapunovExponents<H>;

}  // namespace semiexplicit
