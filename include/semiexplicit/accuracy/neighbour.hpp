#pragma once

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/pacer.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>

namespace semiexplicit::detail {

/// An orbit beside that of z0: by how much it goes off from that behind a trial, which is what the trial's
/// errors are multiplied by there.
template <class Any>
class Neighbour {
 public:
  explicit Neighbour(Problem<Any>& problem) : problem_(problem) {}

  /// Takes both orbits to T by equal steps of that setting, as far as the calls go, and until they are apart
  /// by a part of the `lengths` of steps. What an attempt before has seen stays where that was more, and
  /// calm. False: a step failed.
  SEMIEXPLICIT_COLD bool go(const Setting& setting, const LengthsOfWays& lengths) {
    const bool calm = rate() == 0;
    const auto before = std::exchange(seen_, {});
    Walker<Any> walker(problem_, setting), beside(problem_, setting);
    const double T = problem_.table.time, dt = T / steps_between(0.0, T, setting.dt);
    auto z = problem_.z0, other = z;
    const Eigen::Index own = own_dof<Any>(z.dof());
    const double small = 0.1 * std::sqrt(Problem<Any>::epsilon);
    using Scalar = typename Any::Scalar;
    for (Eigen::Index i = 0; i < own; ++i) {  // in a direction of no symmetry
      const double unit = lengths.unit[i], along = static_cast<double>(i * i);
      other.q()[i] += Scalar(small * lengths.in_q * unit * std::sin(1.0 + along));
      other.p()[i] += Scalar(small * lengths.in_p / unit * std::cos(2.0 + along));
    }
    Probe probe;
    double most = 0, t = 0, t_beside = 0;
    while (t < T && most < far) {
      if (!walker.step_on(z, t, dt, probe) || !beside.step_on(other, t_beside, dt, probe)) break;
      const auto off = [own](const auto& a, const auto& b) {
        return (a - b).head(own).template cast<double>().eval();
      };
      const double now = lengths.size_in_q(off(z.q(), other.q())) / lengths.in_q +
                         lengths.size_in_p(off(z.p(), other.p())) / lengths.in_p;
      if (!std::isfinite(now)) return false;
      most = std::max(most, now);
      if (t >= T || most >= far || seen_.empty() || t >= 1.05 * seen_.back().t) seen_.push_back({t, most});
    }
    if (!seen_.empty() && t > seen_.back().t) seen_.push_back({t, most});
    if (probe.cut && calm && !before.empty() && before.back().t > time()) seen_ = before;
    return probe.cut || t >= T || most >= far;
  }

  /// How far both went.
  double time() const { return seen_.empty() ? 0 : seen_.back().t; }

  /// By what factor both go apart from t to T; as a power of the time behind what was seen.
  SEMIEXPLICIT_COLD double growth_from(double t) const {
    const double T = problem_.table.time, end = time();
    if (end == 0 || t >= T) return 1;
    const double power = std::clamp(std::log(apart(end) / apart(end / 4)) / std::log(4.0), 1.0, 3.0);
    return apart(end) / apart(std::min(t, end)) * std::pow(T / std::max(t, end), power);
  }

  /// The rate at which they part where that is no power of the time, as in the end it was seen; else 0.
  SEMIEXPLICIT_COLD double rate() const {
    const double end = time();
    if (end == 0) return 0;
    for (const auto& [share, least] : {std::pair(0.25, 200.0), std::pair(0.5, 40.0)}) {
      const double factor = apart(end) / apart(share * end);
      if (factor > least) return std::log(factor) / ((1 - share) * end);
    }
    return 0;
  }

 private:
  struct Seen {
    double t, apart;  ///< the largest distance until then
  };
  double apart(double t) const {
    const auto behind =
        std::find_if(seen_.begin(), seen_.end(), [t](const Seen& seen) { return seen.t >= t; });
    return behind == seen_.end() ? seen_.back().apart : behind->apart;
  }

  static constexpr double far = 0.3;  ///< of a length along which the motion changes

  Problem<Any>& problem_;
  std::vector<Seen> seen_{};
};

}  // namespace semiexplicit::detail
