#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <semiexplicit/core/hamiltonian.hpp>
#include <semiexplicit/core/phase_point.hpp>

namespace semiexplicit {

/// What check_gradient() found.
template <class Scalar>
struct GradientCheck {
  /// One entry of the gradient beside what the energy says.
  struct Entry {
    std::string name;    ///< "dH/dq[0]"
    Scalar given;        ///< by H.gradient
    Scalar expected;     ///< by differences of H.energy
    Scalar uncertainty;  ///< of `expected`: an entry is wrong if it is further off than this
    bool wrong;
  };
  std::vector<Entry> entries;  ///< all 2d, positions first

  bool ok() const {
    return std::none_of(entries.begin(), entries.end(), [](const Entry& e) { return e.wrong; });
  }
};

/// In words: every wrong entry with its value, the expected one and a guess at the cause.
template <class Scalar>
std::ostream& operator<<(std::ostream& out, const GradientCheck<Scalar>& check) {
  if (check.ok()) return out << "the gradient agrees with the energy";
  const auto near = [](const Scalar& x, const Scalar& y, const Scalar& uncertainty) {
    using std::abs;
    return abs(x - y) <= uncertainty;
  };
  const std::size_t d = check.entries.size() / 2;
  std::ostringstream text;
  for (std::size_t i = 0; i < check.entries.size(); ++i) {
    const auto& e = check.entries[i];
    if (!e.wrong) continue;
    const Scalar& partner = check.entries[(i + d) % (2 * d)].expected;
    text.precision(10);
    text << (text.str().empty() ? "" : "\n") << e.name << " is " << static_cast<long double>(e.given)
         << ", but by the energy it is " << static_cast<long double>(e.expected);
    text.precision(1);
    text << " (+- " << static_cast<long double>(e.uncertainty) << ")";
    if (near(e.expected, Scalar(0), e.uncertainty)) continue;
    if (near(e.given, Scalar(0), e.uncertainty))
      text << ": is it set at all?";
    else if (near(e.given, -e.expected, e.uncertainty))
      text << ": the sign is wrong";
    else if (near(e.given, 2 * e.expected, 2 * e.uncertainty) || near(2 * e.given, e.expected, e.uncertainty))
      text << ": a factor 2";
    else if (near(e.given, partner, e.uncertainty) || near(e.given, -partner, e.uncertainty))
      text << ": that is the other half's; are dHdq and dHdp exchanged?";
  }
  return out << text.str();
}

namespace detail {

/// A derivative and how far it may be off.
template <class Scalar>
struct Slope {
  Scalar value, uncertainty;
};

/// The level of noise in f near x, from the fourth differences of values so close that nothing else is left in them.
///
/// Source: J. J. Moré, S. M. Wild, SIAM J. Sci. Comput. 33 (2011) 1292.
template <class Scalar, class F>
Scalar noise_level(const F& f, const Scalar& x, const Scalar& step) {
  using std::sqrt;
  constexpr int count = 9, order = 4;
  Scalar values[count];
  for (int i = 0; i < count; ++i) values[i] = f(x + Scalar(i - count / 2) * step);
  for (int k = 0; k < order; ++k)
    for (int i = 0; i + 1 < count - k; ++i) values[i] = values[i + 1] - values[i];
  Scalar squares(0);
  for (int i = 0; i < count - order; ++i) squares += values[i] * values[i];
  return sqrt(squares / (count - order) / 70);  // 70 = 1 + 16 + 36 + 16 + 1
}

/// f'(x) by central differences, extrapolated to a vanishing step (Ridders' method): the step shrinks from `h` on, every
/// column of the tableau removes one more even power of it, and of every row the entry that agrees best with its neighbours is
/// a candidate. Its uncertainty is their disagreement and the noise of f, which is `rounding` at least, with room to spare. A
/// row of larger steps is believed only where it does not contradict the smaller ones: an oscillation may pass unseen.
///
/// Source: C. J. F. Ridders, Adv. Eng. Software 4 (1982) 75.
template <class Scalar, class F>
Slope<Scalar> extrapolated_slope(const F& f, const Scalar& x, Scalar h, const Scalar& rounding) {
  using std::abs;
  using std::isfinite;
  constexpr int rows = 16;
  const Scalar unknown = std::numeric_limits<Scalar>::infinity();
  const Scalar found = noise_level<Scalar>(f, x, h / 65536);
  const Scalar noise = 16 * (isfinite(found) && found > rounding ? found : rounding);
  std::vector<Slope<Scalar>> candidates;
  Scalar previous[rows], current[rows];
  for (int i = 0, known = 0; i < rows; ++i, h /= 2) {
    const Scalar right = x + h, left = x - h;
    current[0] = (f(right) - f(left)) / (right - left);
    if (!isfinite(current[0])) {  // outside of the domain: smaller steps may be inside
      known = 0;
      continue;
    }
    Slope<Scalar> best{current[0], unknown};
    Scalar power(4);
    for (int k = 1; k <= known; ++k, power *= 4) {
      current[k] = current[k - 1] + (current[k - 1] - previous[k - 1]) / (power - 1);
      const Scalar uncertainty =
          8 * std::max(abs(current[k] - current[k - 1]), abs(current[k] - previous[k - 1])) + noise / h;
      if (uncertainty < best.uncertainty) best = {current[k], uncertainty};
    }
    candidates.push_back(best);
    std::copy(current, current + known + 1, previous);
    ++known;
  }
  Slope<Scalar> result{std::numeric_limits<Scalar>::quiet_NaN(), unknown};
  for (auto row = candidates.rbegin(); row != candidates.rend(); ++row)
    if (row->uncertainty < result.uncertainty &&
        !(abs(row->value - result.value) > result.uncertainty + row->uncertainty))
      result = *row;
  return result;
}

}  // namespace detail

/// Compares the gradient of H at z, entry by entry, with differences of its energy, and takes no right gradient for a wrong
/// one: the differences come with their uncertainty, typically 1e-12 of the energy in double. Costs some fifty energies an
/// entry.
///
///     if (const auto check = check_gradient(H, z); !check.ok()) std::cerr << check << '\n';
///
/// A NaN in the gradient is wrong. An entry whose differences are not finite, at the edge of the domain, is not judged. Choose z with care: at a point of symmetry, as z = 0, many
/// wrong gradients vanish like the right one. Throws std::invalid_argument if z has another size than H, or the energy at z
/// is not finite.
template <HasEnergy H>
GradientCheck<typename H::Scalar> check_gradient(const H& hamiltonian,
                                                 const PhasePoint<typename H::Scalar, H::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  const Eigen::Index d = dof_of(hamiltonian);
  if (z.dof() != d)
    throw std::invalid_argument("check_gradient: z has " + std::to_string(z.dof()) +
                                " degrees of freedom and the Hamiltonian " + std::to_string(d));
  const Scalar energy = hamiltonian.energy(z.q(), z.p());
  if (!isfinite(energy))
    throw std::invalid_argument(
        "check_gradient: the energy at z is NaN or Inf; choose a point where it is finite");
  PhasePoint<Scalar, H::Dof> given(d), at(z);
  hamiltonian.gradient(z.q(), z.p(), given.q(), given.p());
  // What rounding makes of an energy is judged by its terms, which may be far larger than their sum.
  Scalar terms = abs(energy);
  for (Eigen::Index i = 0; i < 2 * d; ++i) {
    const Scalar term = abs(z.vector()[i] * given.vector()[i]);
    if (isfinite(term)) terms += term;
  }
  const Scalar rounding = Eigen::NumTraits<Scalar>::epsilon() * terms;
  const Scalar size = z.vector().cwiseAbs().maxCoeff();
  GradientCheck<Scalar> check;
  for (Eigen::Index i = 0; i < 2 * d; ++i) {
    // The first step is meant to be too large, but not by much: about a tenth of the variable. One that is far smaller than
    // the others may be a zero up to rounding, which is no size.
    const Scalar own = std::max<Scalar>(abs(z.vector()[i]), size / 1000);
    const Scalar step = (own > Scalar(0) ? own : Scalar(1)) / 9;
    const auto energy_at = [&](const Scalar& x) -> Scalar {
      at.vector()[i] = x;
      return hamiltonian.energy(at.q(), at.p());
    };
    const auto slope = detail::extrapolated_slope<Scalar>(energy_at, z.vector()[i], step, rounding);
    at.vector()[i] = z.vector()[i];
    const Scalar value = given.vector()[i];
    const std::string name =
        std::string(i < d ? "dH/dq[" : "dH/dp[") + std::to_string(i < d ? i : i - d) + "]";
    check.entries.push_back(
        {.name = name,
         .given = value,
         .expected = slope.value,
         .uncertainty = slope.uncertainty,
         .wrong = !isfinite(value) ||
                  (isfinite(slope.value) && !(abs(value - slope.value) <= slope.uncertainty))});
  }
  return check;
}

}  // namespace semiexplicit
