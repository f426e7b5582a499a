#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <locale>
#include <optional>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <semiexplicit/core/cold.hpp>
#include <semiexplicit/core/hamiltonian_door.hpp>
#include <semiexplicit/core/phase_point.hpp>
#include <semiexplicit/core/reference_size.hpp>
#include <semiexplicit/derivatives/gradient_output.hpp>
#include <semiexplicit/derivatives/slope.hpp>

namespace semiexplicit {

/// What check_gradient() found.
template <class Scalar>
struct GradientCheck {
  /// One entry of the gradient beside what the energy says.
  struct Entry {
    std::string name;    ///< "dH/dq[0]"
    Scalar given;        ///< by H.gradient, into an output of zeros
    Scalar expected;     ///< by differences of H.energy
    Scalar uncertainty;  ///< of `expected`: an entry that is judged is wrong if it is further off than this
    bool judged;  ///< false: the differences are too uncertain to tell a right entry from, say, one of the
                  ///< wrong sign
    bool wrong;
    GradientOutput output = GradientOutput::written;

    /// Not by the energy's slope, which an entry that is only written in the wrong way may have.
    bool clashes() const {
      using std::abs;
      using std::isfinite;
      return !isfinite(given) || (isfinite(expected) && !(abs(given - expected) <= uncertainty));
    }
  };
  std::vector<Entry> entries;  ///< all 2d, positions first

  /// No entry is wrong, as far as they could be judged.
  bool ok() const {
    return std::none_of(entries.begin(), entries.end(), [](const Entry& e) { return e.wrong; });
  }
  /// Every entry could be judged: right is then ok() && judged().
  bool judged() const {
    return std::all_of(entries.begin(), entries.end(), [](const Entry& e) { return e.judged; });
  }
};

namespace detail {

/// A guess at why entry i is not what the energy says, or nothing.
template <class Scalar>
SEMIEXPLICIT_COLD std::string gradient_guess(const GradientCheck<Scalar>& check, std::size_t i) {
  const auto& e = check.entries[i];
  const auto near = [](const Scalar& x, const Scalar& y, const Scalar& uncertainty) {
    using std::abs;
    return abs(x - y) <= uncertainty;
  };
  const std::size_t d = check.entries.size() / 2;
  const Scalar& partner = check.entries[(i + d) % (2 * d)].expected;
  if (near(e.expected, Scalar(0), e.uncertainty)) return "";
  if (near(e.given, Scalar(0), e.uncertainty)) return "is it set at all?";
  if (near(e.given, -e.expected, e.uncertainty)) return "the sign is wrong";
  if (near(e.given, 2 * e.expected, 2 * e.uncertainty) || near(2 * e.given, e.expected, e.uncertainty))
    return "a factor 2";
  if (near(e.given, partner, e.uncertainty) || near(e.given, -partner, e.uncertainty))
    return "that is the other half's; are dHdq and dHdp exchanged?";
  return "";
}

/// One wrong entry in words.
template <class Scalar>
SEMIEXPLICIT_COLD std::string entry_in_words(const GradientCheck<Scalar>& check, std::size_t i) {
  using std::isfinite;
  const auto& e = check.entries[i];
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text << e.name;
  const bool clashes = !isfinite(e.given) || (e.judged && e.clashes());
  if (clashes) {
    text.precision(10);
    text << " is " << static_cast<long double>(e.given) << ", but by the energy it is "
         << static_cast<long double>(e.expected);
    text.precision(1);
    text << " (+- " << static_cast<long double>(e.uncertainty) << ")";
    const std::string guess = gradient_guess(check, i);
    if (!guess.empty()) text << ": " << guess;
  }
  if (e.output != GradientOutput::written) text << (clashes ? "; it " : " ") << describe(e.output);
  return text.str();
}

}  // namespace detail

/// In words: every wrong entry with its value, the expected one and a guess at the cause, or that all is
/// right, and what could not be judged. Of long lists the first entries.
template <class Scalar>
SEMIEXPLICIT_COLD std::ostream& operator<<(std::ostream& out, const GradientCheck<Scalar>& check) {
  constexpr std::size_t most = 12;
  std::size_t wrong = 0, unjudged = 0;
  std::string lines, names;
  for (std::size_t i = 0; i < check.entries.size(); ++i) {
    const auto& e = check.entries[i];
    if (e.wrong && ++wrong <= most) lines += (lines.empty() ? "" : "\n") + detail::entry_in_words(check, i);
    if (!e.wrong && !e.judged && ++unjudged <= most) names += (names.empty() ? "" : ", ") + e.name;
  }
  if (wrong > most) lines += "\nand " + std::to_string(wrong - most) + " entries more";
  if (unjudged > most) names += " and " + std::to_string(unjudged - most) + " more";
  if (wrong == 0 && unjudged < check.entries.size())
    lines = unjudged == 0 ? "the gradient agrees with the energy"
                          : "the gradient agrees with the energy in the entries that could be judged";
  if (unjudged > 0)
    lines += (lines.empty() ? "" : "\n") + ("not judged: " + names) +
             "; the differences of the energy say too little about them here, choose another z";
  return out << lines;
}

namespace detail {

/// NaN where the energy throws std::logic_error, as std::domain_error out of its domain.
template <class H>
typename H::Scalar energy_or_nan(const H& hamiltonian, const auto& q, const auto& p) {
  try {
    return hamiltonian.energy(q, p);
  } catch (const std::logic_error&) {
    return std::numeric_limits<typename H::Scalar>::quiet_NaN();
  }
}

/// How far a coordinate that is zero, as all of its half are, is to go so that f, the energy, moves by about
/// `energy`: its size, of which nothing else tells.
template <class Scalar>
SEMIEXPLICIT_COLD std::optional<Scalar> size_by_energy(const ScalarFunction<Scalar>& f, const Scalar& guess,
                                                       const Scalar& energy) {
  using std::abs;
  constexpr int most = 80;
  const Scalar here = f(Scalar(0)), factor(16);
  const auto too_far = [&](const Scalar& x) {  // also out of the domain
    return !(abs(f(x) - here) <= energy && abs(f(-x) - here) <= energy);
  };
  Scalar size = guess;
  int k = 0;
  if (too_far(size))
    while (k < most && too_far(size)) size /= factor, ++k;
  else
    while (k < most && !too_far(size * factor)) size *= factor, ++k;
  return k < most ? std::optional(size) : std::nullopt;
}

/// What rounding makes of an energy is judged by its terms, which may be far larger than their sum, and by
/// how far it moves at least where all entries change, which is Inf where it does not. Not by the gradient: a
/// wrong one would excuse itself.
template <HasEnergy H>
typename H::Scalar energy_rounding(const H& hamiltonian, const typename H::Scalar& energy,
                                   const PhasePoint<typename H::Scalar, H::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  const auto terms =
      reference_size([&](const auto& q, const auto& p) { return energy_or_nan(hamiltonian, q, p); }, energy,
                     z)
          .terms;
  PhasePoint<Scalar, H::Dof> at = z, direction = z;
  const auto sizes = sizes_of_halves(z);
  const auto along = [&](const Scalar& s) -> Scalar {
    at.vector() = z.vector() + s * direction.vector();
    return energy_or_nan(hamiltonian, at.q(), at.p());
  };
  Scalar least = std::numeric_limits<Scalar>::infinity();
  std::uint64_t random = 1;
  const bool stays[2] = {z.q().isZero(0), z.p().isZero(0)};  // of unknown size
  for (int k = 0; k < 8 && (k < 4 || !isfinite(least)); ++k) {
    for (Eigen::Index i = 0; i < z.vector().size(); ++i) {
      const std::size_t half = i < z.dof() ? 0 : 1;
      const Scalar own = z.vector()[i] != Scalar(0) ? z.vector()[i]
                         : k < 4 && stays[half]     ? Scalar(0)
                                                    : sizes[half].typical;
      direction.vector()[i] = Scalar(scattered(random)) * (k < 4 ? own : std::max<Scalar>(abs(own), 1));
    }
    least =
        std::min(least, k < 4 ? first_move<Scalar>(along, Scalar(0), Scalar(1)) : first_move<Scalar>(along));
  }
  return std::max<Scalar>({Eigen::NumTraits<Scalar>::epsilon() * (abs(energy) + 2 * terms), least / 4,
                           std::numeric_limits<Scalar>::min()});  // where it underflows
}

}  // namespace detail

/// Compares the gradient of H at z, entry by entry, with differences of its energy, and takes no right
/// gradient for a wrong one: the differences come with their uncertainty, typically 1e-12 of the energy in
/// double. (But for a z within some 1e-5 of its size, 1e-3 in float, of a kink of the energy, of which it may
/// tell the other side; and where a term of the energy drowns in the rounding of the others, or oscillates
/// often within the size of a coordinate: of random sums with such terms one right gradient in 10,000 is
/// refused in float, one in 100,000 in double. An energy that is computed in single precision and returned as
/// double is less exact than its rounding shows, and it is one in a hundred.) Costs some sixty energies
/// an entry, up to eight times that where they say little or the entry is wrong, and three gradients, whose
/// outputs hold different numbers before.
///
/// Compares the gradient also with the other members that H may have, those for packs (HasPackGradient),
/// registers (HasLaneGradient), halves (SeparableHamiltonian) and for ranges (HasRangeGradient, with its
/// reach) at z and three points near it, packs beside points with other signs; with the exact flow and the
/// rest (SplitHamiltonian), by some 150 flows at each of these, where that of the time 2t has to be that of
/// t, twice; and its derivative along one direction with hessian() and hessian_times(), by some 150 gradients
/// each, and some 4000 more where coordinates of z are zero.
///
///     if (const auto check = check_gradient(H, z); !check.ok()) std::cerr << check << '\n';
///
/// Wrong are also a NaN in the gradient, and an entry that is not written or added to instead: an integrator
/// hands in outputs that hold anything; and one that is another number by one of these members. An entry
/// about which the differences say too little, as at the edge of the domain, is not judged:
/// GradientCheck::judged() is false then. Choose z with care: at a point of symmetry, as z = 0, many wrong
/// gradients vanish like the right one. Throws std::invalid_argument if z has another size than H, the energy
/// at z is not finite, or H is a scene with a force of its own (OnMotion), which has none.
template <class H>
SEMIEXPLICIT_COLD GradientCheck<typename detail::EnergyDoor<H>::Scalar> check_gradient(
    const H& hamiltonian,
    const PhasePoint<typename detail::EnergyDoor<H>::Scalar, detail::EnergyDoor<H>::Dof>& z) {
  using Scalar = typename H::Scalar;
  using std::abs;
  using std::isfinite;
  const Eigen::Index d = dof_of(hamiltonian);
  if (z.dof() != d)
    throw std::invalid_argument("check_gradient: z has " + std::to_string(z.dof()) +
                                " degrees of freedom and the Hamiltonian " + std::to_string(d));
  detail::require_symplectic(hamiltonian, "check_gradient", "check it without that effect");
  if (d == 0) throw std::invalid_argument("check_gradient: there are no degrees of freedom");
  const Scalar energy = hamiltonian.energy(z.q(), z.p());
  if (!isfinite(energy))
    throw std::invalid_argument(
        "check_gradient: the energy at z is NaN or Inf; choose a point where it is finite");
  PhasePoint<Scalar, H::Dof> given(d), at(z);
  auto outputs = detail::written_gradient(hamiltonian, z, given);
  detail::compare_members(hamiltonian, z, outputs);
  const Scalar rounding = detail::energy_rounding(hamiltonian, energy, z),
               epsilon = Eigen::NumTraits<Scalar>::epsilon();
  const auto sizes = detail::sizes_of_halves(z);
  GradientCheck<Scalar> check;
  for (Eigen::Index i = 0; i < 2 * d; ++i) {
    const auto energy_at = [&](const Scalar& x) -> Scalar {
      at.vector()[i] = x;
      return detail::energy_or_nan(hamiltonian, at.q(), at.p());
    };
    // The first step is meant to be too large, but not by much: about a tenth of the variable.
    const auto& [largest, typical] = sizes[i < d ? 0 : 1];
    const Scalar x = z.vector()[i], own = x == Scalar(0) ? typical : Scalar(abs(x));
    const auto slope_within = [&](const Scalar& from, const Scalar& widest) {
      return detail::judging_slope<Scalar>(energy_at, x, given.vector()[i], from, widest, rounding);
    };
    std::optional<Scalar> by_energy;
    const bool at_zero = (i < d ? z.q() : z.p()).isZero(0);
    if (at_zero) by_energy = detail::size_by_energy<Scalar>(energy_at, own, rounding / epsilon);
    auto slope = by_energy ? slope_within(*by_energy, *by_energy) : slope_within(own, largest);
    // The size of the other half says nothing of this one: what 1 tells has to agree.
    if (at_zero && !by_energy && slope.judges) {
      const auto other = slope_within(Scalar(1), Scalar(1));
      slope.judges = other.judges &&
                     abs(other.value - slope.value) <= other.uncertainty + slope.uncertainty &&
                     (given.vector()[i] == Scalar(0) || slope.uncertainty <= abs(given.vector()[i]));
    }
    // Beside energies elsewhere an oscillation may be too small to tell its size; the given slope may.
    const Scalar entry_size = abs(given.vector()[i]), implied = rounding / epsilon / entry_size;
    if (at_zero && slope.judges && !slope.admits(given.vector()[i]) && isfinite(implied) &&
        implied > Scalar(0))
      if (const auto other = slope_within(implied, implied);
          other.admits(given.vector()[i]) && other.uncertainty <= entry_size / 1000)
        slope = other;
    at.vector()[i] = z.vector()[i];
    typename GradientCheck<Scalar>::Entry entry{
        .name = std::string(i < d ? "dH/dq[" : "dH/dp[") + std::to_string(i < d ? i : i - d) + "]",
        .given = given.vector()[i],
        .expected = slope.value,
        .uncertainty = slope.uncertainty,
        .judged = slope.judges,
        .wrong = false,
        .output = outputs[static_cast<std::size_t>(i)]};
    entry.wrong = !isfinite(entry.given) || (entry.judged && entry.clashes()) ||
                  entry.output != GradientOutput::written;
    check.entries.push_back(entry);
  }
  return check;
}

}  // namespace semiexplicit
