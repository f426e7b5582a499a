#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/chaos/detail/tangent_run.hpp>
#include <semiexplicit/core/checkpointable.hpp>
#include <semiexplicit/core/gradient_size.hpp>

namespace semiexplicit {

/// An observer that measures how fast neighbouring orbits part: the Lyapunov exponents of the run it
/// observes, the largest first as t grows, in units of 1/time, as growth in the direction of the run, forward
/// or backward. It carries a few tangent vectors along (TangentVectors: which steppers, where the second
/// derivatives come from) and makes them orthonormal again after each step; an exponent is the mean growth of
/// the logarithm of their lengths.
///
///     LyapunovExponents lyapunov(stepper, 1);            // the maximal one; without a number all 2d
///     integrate(stepper, z, {.dt = 0.05, .steps = 200'000}, lyapunov);
///     lyapunov.exponents()[0];                           // now
///     lyapunov.times(), lyapunov.series(0);              // the first one, twenty times a decade
///
/// These are estimates at the time reached: of a regular orbit they fall to zero like ln(t)/t, so look at the
/// series. The exponents of a Hamiltonian system come in pairs ±λ, two of them zero for each integral of
/// motion. Of a driven system, Autonomous of d degrees of freedom with the time, there are 2d - 1: its work
/// p_t does not count, and that of the time is zero; where its orbit leaves only the first is to be trusted.
/// With TimeTransformed, too, they are per unit of the time t, not of s.
/// Let the stepper be the one that makes the run.
///
/// k exponents cost 2 + ck plain steps a step, where c is the cost of a product over that of a gradient (1 to
/// 2, benchmarks/chaos), k d of memory and no heap in a step. A hessian or hessian_times is compared with
/// differences of the gradient at the first state, along two directions, and refused with
/// std::invalid_argument where it is off by more than a hundredth along both: another system's is found so,
/// a single wrong entry that counts little there may not be.
///
/// Source: G. Benettin, L. Galgani, A. Giorgilli, J.-M. Strelcyn, Meccanica 15 (1980) 9 and 21.
template <class Stepper>
class LyapunovExponents {
 public:
  using Scalar = typename Stepper::Scalar;
  static constexpr int Dof = Stepper::Dof;
  using State = PhasePoint<Scalar, Dof>;
  static constexpr const char* name = "LyapunovExponents";
  using Exponents = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

  /// `count` exponents of 2d; throws std::invalid_argument for another number than 1 to 2d, or 2d - 1 as
  /// above.
  LyapunovExponents(const Stepper& stepper, Eigen::Index count)
      : run_(name, stepper, 1, count), sums_(Sums::Zero(count)) {
    times_.reserve(most_samples);
    samples_.reserve(most_samples * static_cast<std::size_t>(count));
  }
  explicit LyapunovExponents(const Stepper& stepper)
      : LyapunovExponents(stepper, detail::TangentRun<Stepper>::most(stepper)) {}

  /// Starts with these vectors, 2d rows and a column each, made orthonormal, in place of those that have a
  /// part in every direction: in the excited sites of a large lattice, say. Throws std::invalid_argument
  /// where they do not fit, or the run has begun. A run that is resumed goes on with those of its checkpoint.
  template <class Derived>
  void start_with(const Eigen::MatrixBase<Derived>& vectors) {
    run_.start_with(vectors);
  }

  /// Takes in the next state. Throws std::runtime_error, saying what is wrong, where the step has no tangent
  /// map, and std::invalid_argument where the time turns round, another orbit begins or it is not shown every
  /// step.
  void operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    if (!run_.follow(t, z, run)) return;
    run_.orthonormalise([&](Eigen::Index i, Eigen::Index j, const Scalar& r) {
      using std::log;
      if (i == j) sums_[j] += static_cast<Sum>(log(r));
    });
    if (run_.steps() >= next_sample_ && times_.size() < most_samples && run_.elapsed() != 0) sample();
  }

  /// Whether it has seen nothing yet: a resumed run would give the exponents of its end only.
  bool fresh() const { return run_.fresh(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("exponents", run_.count());
    list.function("Hamiltonian", GradientSize(run_.hamiltonian()));
    list("scheme", run_.scheme());
  }
  /// The vectors that it carries along, what they have grown, and the series; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    run_.visit_memory(visit);
    visit(sums_);
    visit(next_sample_);
    visit(times_);
    visit(samples_);
  }

  /// The estimates up to now; zero before the first step.
  Exponents exponents() const {
    if (run_.elapsed() == 0) return Exponents::Zero(sums_.size());
    return (sums_ / Sum(std::abs(run_.elapsed()))).template cast<Scalar>();
  }

  /// The times since the first state at which the estimates were kept, twenty a decade or every step, of a
  /// backward run negative; and the j-th exponent at each, 0 being the largest. Throws std::invalid_argument
  /// for another j than 0 to count - 1.
  const std::vector<double>& times() const { return times_; }
  std::vector<Scalar> series(Eigen::Index j = 0) const {
    if (j < 0 || j >= sums_.size())
      throw std::invalid_argument("LyapunovExponents: series(" + std::to_string(j) + ") of " +
                                  std::to_string(sums_.size()) +
                                  " exponents; give 0 to their number less one");
    std::vector<Scalar> list;
    for (std::size_t i = 0; i < times_.size(); ++i)
      list.push_back(samples_[i * static_cast<std::size_t>(sums_.size()) + static_cast<std::size_t>(j)]);
    return list;
  }

  /// The tangent vectors as they are now, a column each: the first grows fastest. Orthonormal, momenta in the
  /// unit that growth is measured in.
  const auto& vectors() const { return run_.vectors(); }

 private:
  using Sum = typename detail::TangentRun<Stepper>::Sum;
  using Sums = Eigen::Matrix<Sum, Eigen::Dynamic, 1>;
  static constexpr std::size_t most_samples = 400;  ///< nineteen decades

  void sample() {
    times_.push_back(run_.elapsed());
    for (Eigen::Index j = 0; j < sums_.size(); ++j)
      samples_.push_back(static_cast<Scalar>(sums_[j] / Sum(std::abs(run_.elapsed()))));
    const auto later = static_cast<std::int64_t>(1.122018454301963 * static_cast<double>(run_.steps()) + 0.5);
    next_sample_ = later > run_.steps() ? later : run_.steps() + 1;
  }

  detail::TangentRun<Stepper> run_;
  Sums sums_;
  std::int64_t next_sample_ = 1;
  std::vector<double> times_;
  std::vector<Scalar> samples_;
};

}  // namespace semiexplicit
