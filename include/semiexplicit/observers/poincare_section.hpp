#pragma once

#include <cstdint>
#include <utility>

#include <semiexplicit/observers/dense_output.hpp>

namespace semiexplicit {

/// Which crossings of s = 0 count, in the direction of the run: from negative to positive s, the reverse, or all.
enum class CrossingDirection { rising, falling, both };

/// What poincare_section() may be told.
struct PoincareSectionOptions {
  CrossingDirection direction = CrossingDirection::rising;
  int nodes = 4;  ///< states that the interpolation goes through; see DenseOutput
};

/// Hands on the points where an orbit crosses a surface; see poincare_section().
template <class H, class Surface, class Observer>
class PoincareSection {
 public:
  using Scalar = typename DenseOutput<H>::Scalar;
  using State = typename DenseOutput<H>::State;
  static constexpr const char* name = "poincare_section";

  PoincareSection(H hamiltonian, Surface surface, Observer&& observer, PoincareSectionOptions options)
      : intervals_(std::move(hamiltonian), options.nodes),
        surface_(std::move(surface)),
        observer_(std::forward<Observer>(observer)),
        direction_(options.direction),
        crossing_(dof_of(dense().hamiltonian())) {}

  /// Takes in the next state; false where the observer asked to stop.
  bool operator()(const Scalar& t, const State& z, const IntegrationReport& run = {}) {
    bool go_on = true;
    intervals_.take(t, z, run, [&](std::size_t i) { go_on = look(i, run) && go_on; });
    return go_on;
  }

  /// Looks through a run that ended before it had as many states as the interpolation has nodes.
  void finish() {
    intervals_.finish([this](std::size_t i) { look(i, {}); });
  }

  /// How many crossings there were.
  std::int64_t count() const { return count_; }

  /// Whether it has seen nothing yet: a resumed run would miss the crossings before.
  bool fresh() const { return intervals_.fresh(); }

  /// See Describable.
  template <class List>
  void describe(List& list) const {
    list("direction", direction_);
    list.function("surface", surface_);
    dense().describe(list);
    detail::describe_inner(list, observer_);
  }
  /// The states between which it interpolates, the side of the surface, the count, and what the
  /// observer remembers; see CheckpointMemory.
  template <class Visitor>
  void visit_memory(Visitor&& visit) {
    intervals_.visit_memory(visit);
    visit(side_);
    visit(orbit_);
    visit(count_);
    detail::visit_inner(visit, observer_);
  }

 private:
  DenseOutput<H>& dense() { return intervals_.dense; }
  const DenseOutput<H>& dense() const { return intervals_.dense; }

  bool look(std::size_t i, const IntegrationReport& run) {
    const Scalar from = value(dense().state(i)), to = value(dense().state(i + 1));
    if (std::exchange(orbit_, intervals_.orbits()) != intervals_.orbits()) side_ = 0;
    if (side_of(from) != 0) side_ = side_of(from);
    const int before = side_, after = side_of(to);
    // On the surface it is not decided yet: an orbit that only touches it comes back to the side where it was.
    if (after == 0) return true;
    side_ = after;
    if (before == 0 || before == after) return true;
    if (direction_ == (after > 0 ? CrossingDirection::falling : CrossingDirection::rising)) return true;
    const auto at = [&](const Scalar& x) {
      dense().after(i, x, crossing_);
      return value(crossing_);
    };
    const Scalar x = from == Scalar(0)
                         ? Scalar(0)
                         : detail::bracketed_root(at, Scalar(0), from, Scalar(dense().interval(i)), to);
    dense().after(i, x, crossing_);
    ++count_;
    if constexpr (InExtendedPhaseSpace<H>)
      return detail::notify(observer_, H::time(crossing_), H::point(crossing_), run);
    else
      return detail::notify(observer_, Scalar(dense().time(i) + x), std::as_const(crossing_), run);
  }

  Scalar value(const State& z) const { return surface_(z.q(), z.p()); }
  static int side_of(const Scalar& s) { return s > Scalar(0) ? 1 : s < Scalar(0) ? -1 : 0; }

  detail::Intervals<H> intervals_;
  Surface surface_;
  Observer observer_;
  CrossingDirection direction_;
  State crossing_;
  int side_ = 0;  ///< of the surface where the orbit was last: -1, 1; 0 before it was seen beside it
  std::int64_t count_ = 0, orbit_ = 0;
};

/// A Poincaré section: an observer that calls another one, (t, z), with every point where the orbit crosses the surface
/// s(q, p) = 0, found to rounding on the interpolation between the steps (see DenseOutput).
///
///     auto section = poincare_section(H, [](const auto& q, const auto& p) { return q[0]; },
///                                     [](double t, const auto& z) { ... });
///     integrate(stepper, z, {.dt = 0.1, .steps = 100'000}, section);
///
/// s is to be continuous, and the steps so small that it changes its sign once in each: of an angle take sin(q), not q modulo
/// 2π. A start on the surface is no crossing, nor is a state that only touches it. Of an extended Hamiltonian s has the extended q and p, so that the time is the
/// last q, and the observer gets the time and the phase point without it. An observer that returns false ends the run. Call
/// finish() after a run of fewer than nodes - 1 steps. A named observer is referred to, a temporary is kept.
///
/// Points and times are as accurate as the run and the interpolation: on an orbit of systems::Product with 80 steps a period
/// the times are found to 1e-10 with four nodes and to 1e-12 with six.
template <class H, class Surface, class Observer>
PoincareSection<H, Surface, Observer> poincare_section(H hamiltonian, Surface surface, Observer&& observer,
                                                       PoincareSectionOptions options = {}) {
  return {std::move(hamiltonian), std::move(surface), std::forward<Observer>(observer), options};
}

}  // namespace semiexplicit
