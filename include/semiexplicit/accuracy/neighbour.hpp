#pragma once

#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>
#include <vector>

#include <semiexplicit/accuracy/pacer.hpp>
#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/extended_phase_space.hpp>

namespace semiexplicit::detail {

/// What goes off from the orbit of z0 behind a trial, which is what the trial's errors are multiplied by
/// there: an orbit beside it, and the orbit itself by finer steps.
template <class Any>
class Neighbour {
 public:
  explicit Neighbour(Problem<Any>& problem) : problem_(problem) {}

  /// Takes both orbits to T by equal steps of that setting, as far as the calls go, and until they are apart
  /// by a part of the `lengths` of steps; the first one also by three steps for two. What an attempt before
  /// has seen stays where that was more, and calm. False: a step failed.
  SEMIEXPLICIT_COLD bool go(const Setting& setting, const LengthsOfWays& lengths) {
    const bool calm = rate() == 0;
    const auto before = std::exchange(seen_, {});
    const Ended ended = follow(setting, lengths, 0.1);
    if ((ended == Ended::calls || ended == Ended::failed) && calm && !before.empty() &&
        before.back().t > time())
      seen_ = before;
    if (ended != Ended::apart || rate() == 0) return ended != Ended::failed;
    // The passage of a saddle parts them once, chaos goes on: from nearer they stay together for longer by
    // half.
    const auto parted = std::exchange(seen_, {});
    if (follow(setting, lengths, 1e-5) == Ended::failed || time() < 3 * parted.back().t) seen_ = parted;
    return true;
  }

  /// How far both went.
  double time() const { return seen_.empty() ? 0 : seen_.back().t; }

  /// By what factor errors grow from t to T; as a power of the time behind what was seen.
  SEMIEXPLICIT_COLD double growth_from(double t) const {
    const double T = problem_.table.time, end = time();
    if (end == 0 || t >= T) return 1;
    const auto grown = [&](const auto& since) {
      const double half = std::log(since(end / 2)), quarter = std::log(since(end / 4)) - half,
                   power = std::clamp((half + quarter) / std::log(4.0), 1.0, 3.0), from = std::max(t, end);
      // What grows by far more in the second half than from a quarter to that is exponential.
      const double rate = half > 1 && half > 1.5 * quarter ? 2 * half / end : 0;
      return since(std::min(t, end)) *
             std::max(std::pow(T / from, power), std::exp(std::min(rate * (T - from), 500.0)));
    };
    return std::max(grown([this](double from) { return growth_since(from); }),
                    grown([this](double from) { return error_since(from); }));
  }

  /// Whether both grow hardly faster than the time, as beside a regular motion.
  bool is_regular() const {
    return time() > 0 && std::max(growth_since(time() / 4), error_since(time() / 4)) < much;
  }

  /// The rate at which they part where that is no power of the time, as in the end it was seen; else 0.
  SEMIEXPLICIT_COLD double rate() const {
    const double end = time();
    if (end == 0) return 0;
    for (const auto& [share, least] : {std::pair(0.25, 200.0), std::pair(0.5, 40.0)}) {
      const double factor = std::min(growth_since(share * end), motion_since(share * end));
      if (factor > least) return std::log(factor) / ((1 - share) * end);
    }
    return 0;
  }

 private:
  using Column = Eigen::VectorXd;

  struct Seen {
    double t = 0, of_f = 0, of_error = 0;  ///< by how much f differs at most until then, and by its error
    Column of_each{};                      ///< and each degree of freedom
  };
  enum class Ended { whole, apart, calls, failed };
  /// Both orbits from z0 on, which are off by that share of what a difference of steps is taken by.
  SEMIEXPLICIT_COLD Ended follow(const Setting& setting, const LengthsOfWays& lengths, double share) {
    Walker<Any> walker(problem_, setting), beside(problem_, setting), by_finer(problem_, setting);
    const double T = problem_.table.time, dt = T / (2 * steps_between(0.0, T, 2 * setting.dt));
    auto z = problem_.z0, other = z, finer = z;
    const Eigen::Index own = own_dof<Any>(z.dof());
    using Scalar = typename Any::Scalar;
    const double root = std::sqrt(Problem<Any>::epsilon), least = 1000 * root;
    for (Eigen::Index i = 0; i < own; ++i) {  // in a direction of no symmetry, a small motion by less
      const double unit = lengths.unit[i], along = static_cast<double>(i * i);
      const double way_q = std::max(lengths.of_each_q[i], least * lengths.in_q * unit),
                   way_p = std::max(lengths.of_each_p[i], least * lengths.in_p / unit);
      other.q()[i] += Scalar(share * root * way_q * std::sin(1.0 + along));
      other.p()[i] += Scalar(share * root * way_p * std::cos(2.0 + along));
    }
    Probe probe;
    Seen now{.of_each = Column::Zero(own)};
    double most = 0, t_beside = 0, t_finer = 0;
    typename Problem<Any>::Value f, f_beside, f_finer;
    const auto steps = [&probe](Walker<Any>& by, auto& state, double& t, double h, int count) {
      while (count > 0 && by.step_on(state, t, h, probe)) --count;
      return count == 0;
    };
    while (now.t < T && most < far) {
      if (!steps(walker, z, now.t, dt, 2) || !steps(beside, other, t_beside, dt, 2) ||
          !steps(by_finer, finer, t_finer, dt / 1.5, 3))
        break;
      const auto off = [own](const auto& a, const auto& b) -> Column {
        return (a - b).head(own).template cast<double>();
      };
      const Column in_q = off(z.q(), other.q()).cwiseQuotient(lengths.unit) / lengths.in_q,
                   in_p = off(z.p(), other.p()).cwiseProduct(lengths.unit) / lengths.in_p;
      problem_.measure(z, f), problem_.measure(other, f_beside), problem_.measure(finer, f_finer);
      const double of_f = static_cast<double>(norm(f - f_beside)),
                   of_error = std::max(static_cast<double>(norm(f - f_finer)),
                                       30 * Problem<Any>::epsilon * static_cast<double>(norm(f)));
      most = std::max(most, norm(in_q) + norm(in_p));
      if (!std::isfinite(most) || !std::isfinite(of_f) || !std::isfinite(of_error)) return Ended::failed;
      now.of_each = now.of_each.cwiseMax(in_q.cwiseAbs() + in_p.cwiseAbs());
      now.of_f = std::max(now.of_f, of_f), now.of_error = std::max(now.of_error, of_error);
      if (now.t >= T || most >= far || seen_.empty() || now.t >= 1.05 * seen_.back().t) seen_.push_back(now);
    }
    if (!seen_.empty() && now.t > seen_.back().t) seen_.push_back(now);
    return most >= far ? Ended::apart : now.t >= T ? Ended::whole : probe.cut ? Ended::calls : Ended::failed;
  }
  /// The last that was noted until then: what comes shortly behind t is growth.
  const Seen& at(double t) const {
    const auto behind =
        std::find_if(seen_.begin(), seen_.end(), [t](const Seen& seen) { return seen.t > t; });
    return behind == seen_.begin() ? *behind : *std::prev(behind);
  }
  /// By what factor f goes apart from t on: what it does not show takes nothing from it, and it may show a
  /// small motion beside a large one.
  double growth_since(double t) const {
    const double before = at(t).of_f;
    return before > 0 ? seen_.back().of_f / before : motion_since(t);
  }
  double error_since(double t) const { return seen_.back().of_error / at(t).of_error; }
  /// The same of the degree of freedom whose factor is the largest.
  double motion_since(double t) const {
    const Column &before = at(t).of_each, &last = seen_.back().of_each;
    double most = 1;
    for (Eigen::Index i = 0; i < last.size(); ++i)
      if (before[i] > 0) most = std::max(most, last[i] / before[i]);
    return most;
  }

  static constexpr double much = 6;   ///< from a quarter of the time on
  static constexpr double far = 0.3;  ///< of a length along which the motion changes

  Problem<Any>& problem_;
  std::vector<Seen> seen_{};
};

}  // namespace semiexplicit::detail
