#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <utility>

#include <semiexplicit/chaos/tangent_map.hpp>
#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/observers/run_clock.hpp>

namespace semiexplicit {

/// An observer that measures how fast neighbouring orbits part: the Lyapunov exponents of the run it observes, the largest
/// first, in units of 1/time, as growth in the direction of the run, forward or backward. It carries a few tangent vectors along by the tangent map of every step and makes them
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
template <class H>
class LyapunovExponents {
 public:
  using Scalar = typename TangentMap<H>::Scalar;
  static constexpr int Dof = TangentMap<H>::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "LyapunovExponents";
  using Exponents = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// `count` exponents of 2d; throws std::invalid_argument for another number than 1 to 2d.
  LyapunovExponents(TangentMap<H> tangent, Eigen::Index count)
      : tangent_(std::move(tangent)),
        previous_(tangent_.dof()),
        frame_(Frame::Zero(2 * tangent_.dof(), count > 0 ? count : 1)),
        moved_(frame_),
        sums_(Sums::Zero(frame_.cols())) {
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
  /// and std::invalid_argument where the time turns round, another orbit begins or it is not shown every step.
  void operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    using Next = typename detail::RunClock<Scalar>::Next;
    const bool equal = clock_.started() && z.vector() == previous_.vector();
    const Next next = clock_.relation(t, equal, run);
    if (next == Next::anew && !equal)
      refuse("another orbit begins; every orbit wants an observer of its own, from its first state on");
    if (next == Next::follows) {
      if (clock_.steps_since(run) != 1)
        refuse("it is shown only some of the steps, and needs every one; take every() away from it");
      const Scalar dt = clock_.interval(t, run);
      if (elapsed_ != 0 && (dt > Scalar(0)) != (elapsed_ > 0))
        refuse("the time turned round; every run wants an observer of its own");
      const Status status = tangent_.at(previous_, dt);
      if (status != Status::success)
        throw std::runtime_error("LyapunovExponents: no tangent map of the step to t = " +
                                 detail::in_words(t, 9) + ": " + semiexplicit::describe(status));
      moved_.noalias() = tangent_.matrix() * frame_;
      frame_ = moved_;
      orthonormalise();
      elapsed_ += static_cast<double>(dt);
    }
    clock_.set(t, run, next);
    previous_ = z;
  }

  /// Whether it has seen nothing yet: a resumed run would give the exponents of its end only.
  bool fresh() const { return !clock_.started(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("exponents", frame_.cols());
    list("scheme", tangent_.scheme());
  }
  /// The vectors that it carries along and what they have grown; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    tangent_.visit_memory(visit);
    visit(frame_);
    visit(sums_);
    visit(previous_.vector());
    visit(elapsed_);
    clock_.visit_memory(visit);
  }

  /// The estimates up to now; zero before the first step.
  Exponents exponents() const {
    if (elapsed_ == 0) return Exponents::Zero(sums_.size());
    return (sums_ / Sum(std::abs(elapsed_))).template cast<Scalar>();
  }

 private:
  [[noreturn]] static void refuse(const char* why) {
    throw std::invalid_argument(std::string("LyapunovExponents: ") + why);
  }

  /// A sum of many small numbers, which floats would round off.
  using Sum = std::conditional_t<std::is_same_v<Scalar, float>, double, Scalar>;
  using Sums = Eigen::Matrix<Sum, Eigen::Dynamic, 1>;
  using Frame = Eigen::Matrix<Scalar, twice(Dof), Eigen::Dynamic>;

  /// Modified Gram-Schmidt; adds the logarithms of the lengths.
  void orthonormalise() {
    using std::log;
    for (Eigen::Index j = 0; j < frame_.cols(); ++j) {
      for (Eigen::Index k = 0; k < j; ++k)
        frame_.col(j) -= detail::dot(frame_.col(k), frame_.col(j)) * frame_.col(k);
      const Scalar length = detail::norm(frame_.col(j));
      frame_.col(j) /= length;
      sums_[j] += static_cast<Sum>(log(length));
    }
  }

  TangentMap<H> tangent_;
  State previous_;
  Frame frame_, moved_;
  Sums sums_;
  double elapsed_ = 0;  ///< the time of the run so far, with its sign
  detail::RunClock<Scalar> clock_;
};

template <class H, class Solver, class... Count>
LyapunovExponents(const Semiexplicit<H, Solver>&, Count...) -> LyapunovExponents<H>;

}  // namespace semiexplicit
